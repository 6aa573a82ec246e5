/* Rate-and-state friction and the balance of slip rates, against long double arithmetic and against themselves
   backwards. */
#include "../ratestate.h"

#define ETA 4.62444e6 /* [Pa s/m] */

enum { STATE_LAWS = SLIP_STATE_COMPOSITE + 1 };

static SlipFriction Parameters(PetscReal a)
{
  return (SlipFriction){.a = a, .b = 0.03, .slip = 0.14, .reference = 0.6, .reference_rate = 1e-6};
}

/* The formula as it is written, in more digits */
static long double Formula(const SlipFriction *p, long double s, long double v)
{
  return p->a * asinhl(v / (2 * (long double)p->reference_rate) * expl((p->reference + p->b * s) / p->a));
}

/* mu to rounding: of an argument of asinh with a logarithm of up to (f0 + b psi)/a, whose rounding it adds. */
static void friction(void **state)
{
  const PetscReal a[] = {0.002, 0.004, 0.01, 0.04}, s[] = {-13, 0, 7, 10};
  const SlipFrictionLaw *law = Law();

  for (size_t i = 0; i < 4; i++)
    for (size_t j = 0; j < 4; j++)
      for (PetscReal v = 1e-25; v < 1e4; v *= 7) {
        const SlipFriction p = Parameters(a[i]);
        const PetscReal terms = a[i] * fabs(log(v / 2e-6)) + 0.6 + 0.03 * fabs(s[j]), h = 1e-3;
        PetscReal mu, ds, dv;
        long double slope;

        law->eval(&p, &s[j], v, &mu, &ds, &dv);
        assert_true(fabs(mu - (PetscReal)Formula(&p, s[j], v)) <= 4 * EPS * terms);
        /* central differences in ln v and s: off by h^2/6 of third derivatives, which are at most 1/a^2 times the first
           in s where asinh bends */
        slope = (Formula(&p, s[j], v * expl(h)) - Formula(&p, s[j], v * expl(-h))) / (2 * h);
        assert_true(fabs(dv * v - (PetscReal)slope) <= 1e-6 * fabs((PetscReal)slope) + 1e-30);
        slope = (Formula(&p, s[j] + h, v) - Formula(&p, s[j] - h, v)) / (2 * h);
        assert_true(fabs(ds - (PetscReal)slope) <= (1e-6 + pow(h * p.b / a[i], 2)) * fabs((PetscReal)slope) + 1e-30);
      }
  {
    const SlipFriction p = Parameters(0.004);
    PetscReal mu, ds, dv, steady;

    law->eval(&p, (PetscReal[]){3}, 0, &mu, &ds, &dv);
    assert_true(mu == 0 && ds == 0 && dv > 0 && isfinite(dv));
    law->steady(&p, 1e-9, &steady);
    assert_true(fabs(steady - log(1e-6 / 1e-9)) < 1e-14); /* theta = d_c/v */
  }
}

/* v over 30 decades and both signs, from the traction that belongs to it. The traction is known to EPS of itself, which
   is EPS tau/(dtau/dln v) of v. Few of these cells are those of the closed form; the rest goes one by one. */
static void balance(void **state)
{
  enum { MAX = 4096 };
  static PetscReal a[MAX], b[MAX], f0[MAX], slip[MAX], sigma[MAX], weight[MAX], tau[MAX], s[3 * MAX], v[MAX], got[MAX],
    ds[3 * MAX], allowed[MAX], kept[SLIP_RATE_AND_STATE_KEPT * MAX];
  SlipFrictionCells f = Cells(a, b, f0, slip);
  PetscInt n = 0;

  f.stress = sigma;
  f.weight = weight;
  for (PetscReal rate = 1e-26; rate < 1e4; rate *= 5.3)
    for (int k = 0; k < 24; k++) {
      const SlipFriction p = Parameters((PetscReal[]){0.0005, 0.004, 0.01, 0.04}[k % 4]);
      const PetscReal stress = (PetscReal[]){25e6, 1e3, 1e-3}[k / 4 % 3];
      PetscReal mu, mu_s, mu_v;

      a[n] = p.a;
      b[n] = p.b;
      f0[n] = p.reference;
      slip[n] = p.slip;
      sigma[n] = stress;
      weight[n] = 1 + 0.5 * (k % 5);
      s[3 * n] = -13 + k;
      v[n] = k % 2 ? -rate : rate;
      SlipRateAndState(&p, &s[3 * n], rate, &mu, &mu_s, &mu_v);
      tau[n] = weight[n] * (stress * mu + ETA * rate) * (k % 2 ? -1 : 1);
      allowed[n] = 16 * EPS *
                   (1 + (0.6 + 0.03 * fabs(s[3 * n])) / p.a * p.a * stress / ((stress * mu_v + ETA) * rate) +
                    fabs(tau[n]) / weight[n] / ((stress * mu_v + ETA) * rate) + fabs(log(rate)));
      assert_true(++n < MAX);
    }
  Law()->keep(&f, n, ETA, kept);
  for (int law = 0; law < STATE_LAWS; law++) {
    f.state_law = (SlipStateLaw)law;
    SlipFrictionBalance(&f, law ? kept : NULL, n, ETA, tau, 3, s, got, ds);
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal rate = fabs(got[i]), aging = 1e-6 / slip[i] * exp(-s[3 * i]);
      const PetscReal by_slip = -rate / slip[i] * (log(rate / 1e-6) + s[3 * i]);
      const PetscReal expected[] = {aging - rate / slip[i], by_slip, by_slip + aging * exp(-rate / CUTOFF)};

      /* at 1e-26 m/s a small argument of asinh is below rounding of a traction that stands for it */
      assert_true(fabs(got[i] / v[i] - 1) <= allowed[i]);
      assert_true(fabs(ds[3 * i] - expected[law]) <=
                  8 * EPS * (aging + rate / slip[i] * (1 + fabs(log(rate / 1e-6)) + 26)));
    }
  }
}

/* mu of many cells at once, of rates over 30 decades and of both signs, at a stride: to the rounding of a times the
   logarithms that it is the sum of. Of small arguments of asinh, which go one by one, to that of the arguments. */
static void many(void **state)
{
  enum { MAX = 4096 };
  static PetscReal a[MAX], b[MAX], f0[MAX], slip[MAX], w[3 * MAX], mu[MAX];
  const SlipFrictionCells f = Cells(a, b, f0, slip);
  PetscInt n = 0, small = 0;

  for (PetscReal rate = 1e-26; rate < 1e4; rate *= 5.3)
    for (int k = 0; k < 24; k++, n++) {
      const SlipFriction p = Parameters((PetscReal[]){0.0005, 0.004, 0.01, 0.04}[k % 4]);

      a[n] = p.a;
      b[n] = p.b;
      f0[n] = p.reference;
      w[3 * n] = k % 2 ? -rate : rate;
      w[3 * n + 2] = -23 + 1.5 * k;
    }
  w[0] = 0;
  f.law->values(&f, n, 3, w + 2, 3, w, mu);
  assert_true(mu[0] == 0);
  for (PetscInt i = 1; i < n; i++) {
    const SlipFriction p = Parameters(a[i]);
    const PetscReal expected = (PetscReal)Formula(&p, w[3 * i + 2], fabs(w[3 * i]));
    const PetscReal size = p.reference + p.b * fabs(w[3 * i + 2]) + p.a * fabs(log(fabs(w[3 * i]) / 2e-6));

    AssertNear(mu[i], expected, 4 * EPS * (expected > p.a ? size : size / p.a * expected));
    small += expected < p.a;
  }
  assert_true(small > 100 && small < n / 2);
}

/* No normal stress leaves radiation damping, no traction no slip rate; and each neighbour is left alone. */
static void extremes(void **state)
{
  const PetscReal a[] = {0.01, 0.01, 0.01, 0.01}, f0[] = {0.6, 0.6, 0.6, 0.6}, slip[] = {1, 1, 1, 1};
  const PetscReal sigma[] = {0, 1e7, 0, 1e7}, tau[] = {ETA, 0, -2 * ETA, 6e6}, s[] = {0, 0, 0, 0};
  const PetscReal none[] = {NAN, NAN, 0, 0}, pushed[] = {6e6, 6e6, 6e6, NAN}, pressed[] = {1e7, 1e7, 1e7, 1e7};
  SlipFrictionCells f = Cells(a, a, f0, slip);
  PetscReal v[4];

  f.stress = sigma;
  SlipFrictionBalance(&f, NULL, 4, ETA, tau, 1, s, v, NULL);
  assert_true(fabs(v[0] - 1) < 4 * EPS && v[1] == 0 && fabs(v[2] + 2) < 8 * EPS);
  /* f0 at the rate V0: the friction of 6e6 Pa less eta V0 */
  assert_true(fabs(v[3] / 1e-6 - 1) < 1e-4 && v[3] < 1e-6);
  f.stress = pressed; /* the rate of what is no number is not that of before */
  v[0] = v[1] = v[2] = v[3] = 1;
  SlipFrictionBalance(&f, NULL, 4, ETA, pushed, 1, none, v, NULL);
  assert_true(v[0] != 1 && v[1] != 1 && v[2] < 1e-6 && v[2] > 0 && isnan(v[3]));
}

/* An implicit stage of the state, and its derivative by differences */
static void advance(void **state)
{
  const PetscReal a[] = {0.01}, b[] = {0.03}, f0[] = {0.6}, slip[] = {0.14};
  SlipFrictionCells f = Cells(a, b, f0, slip);

  for (int law = 0; law < STATE_LAWS; law++)
    for (PetscReal v = 1e-15; v < 10; v *= 30)
      for (PetscReal theta = 1e-4; theta < 1e9; theta *= 50) {
        const PetscReal s0[] = {6.9}, h = 1e-5;
        PetscReal s, rate, mu, ds, dv, slope, side[2];

        f.state_law = (SlipStateLaw)law;
        SlipFrictionStateAdvance(&f, 1, theta, s0, &v, 1, &s);
        SlipFrictionStateRate(&f, 1, 1, &s, 1, &v, &rate);
        /* terms of the rate are larger than it where they cancel */
        assert_true(fabs(s - s0[0] - theta * rate) <=
                    8 * EPS * (1 + fabs(s)) *
                      (10 + theta * (1e-6 / 0.14 * exp(-s) + v / 0.14 * (1 + fabs(log(v / 1e-6))))));
        SlipFrictionStage(&f, 0, theta, s0, v, &mu, &ds, &dv, &slope);
        for (int k = 0; k < 2; k++) {
          const PetscReal other = v * (1 + (k ? h : -h));

          SlipFrictionStateAdvance(&f, 1, theta, s0, &other, 1, &side[k]);
        }
        assert_true(fabs(slope * v - (side[1] - side[0]) / (2 * h)) <= 1e-6 * (fabs(slope * v) + 1) / h * 1e-3);
      }
}

/* The state in which friction is what it is: there and back */
static void state_of(void **unused)
{
  const PetscReal a[] = {0.004}, b[] = {0.03}, f0[] = {0.6}, slip[] = {0.14};
  SlipFrictionCells f = Cells(a, b, f0, slip);

  for (PetscReal s = -10; s < 12; s += 1.7) {
    PetscReal mu, ds, dv, found;

    SlipFrictionEvaluate(&f, 0, &s, 1e-9, &mu, &ds, &dv);
    SlipFrictionSteady(&f, 0, 1e-9, &found);
    SlipFrictionStateOf(&f, 0, 0, mu, 1e-9, &found);
    if (mu > 0.1) assert_true(fabs(found - s) < 1e-11);
  }
}

/* The strength at the end of a long stage against its normal stress, by a centred difference with (d sigma/sigma)^2 =
   1e-8 of error and 1e-16/1e-4 of rounding; the state evolves by 40 times itself within the stage. Without the stress's
   share mu is 0.2 more. */
static void follows_normal_stress(void **state)
{
  const PetscReal a[] = {0.01}, b[] = {0.02}, f0[] = {0.6}, slip[] = {0.01}, start[] = {3e7}, alpha[] = {0.25};
  const PetscReal s0[] = {1}, v[] = {1e-9}, h = 1e-4;

  for (PetscReal theta = 0; theta < 2e6; theta += 1e6) {
    SlipFrictionCells f = Cells(a, b, f0, slip);
    PetscReal q[2], mu, gain;

    f.alpha = alpha;
    f.start = start;
    for (int k = 0; k < 2; k++) {
      const PetscReal stress = 2e7 * (k ? 1 + h : 1 - h);

      f.stress = &stress;
      SlipFrictionStrength(&f, 1, theta, 1, s0, 1, v, &q[k], NULL);
    }
    f.stress = (const PetscReal[]){2e7};
    gain = SlipFrictionStressGain(&f, 0, theta, s0, v[0]);
    SlipFrictionStrength(&f, 1, theta, 1, s0, 1, v, &mu, NULL);
    assert_true(fabs((q[1] - q[0]) / (2 * h * 2e7) - gain) < 1e-7);
    assert_true(mu / 2e7 - gain > (theta > 0 ? 0.005 : 0.2));
  }
  /* finite where all normal stress is gone */
  AssertNear(SlipRateAndStateShift(0.25, 0.02, 0, 3e7), 12.5 * log(1e-12), 1e-12);
}

/* A law of somebody else's, here the same one, takes the way of one cell at a time. */
static void registered(void **state)
{
  SlipFrictionLaw law = *Law();
  const PetscReal a[] = {0.004, 0.04}, b[] = {0.03, 0.03}, f0[] = {0.6, 0.6}, slip[] = {0.14, 0.14};
  const PetscReal sigma[] = {25e6, 25e6}, tau[] = {19e6, -13e6}, s[] = {6.9, 6.9};
  SlipFrictionCells f = Cells(a, b, f0, slip);
  const SlipFrictionLaw *found;
  PetscReal v[2], w[2];

  f.stress = sigma;
  law.name = "mine";
  ok(SlipFrictionRegister(&law));
  ok(SlipFrictionFind("mine", &found));
  assert_string_equal("mine", found->name);
  fails(SlipFrictionRegister(&law), "There is a friction law mine already");
  law.name = "other";
  law.rate = NULL;
  fails(SlipFrictionRegister(&law), "has states, but not what they are, their rates and steady ones");
  law.nstates = 0;
  fails(SlipFrictionRegister(&law), "needs a state");
  law.nstates = SLIP_MAX_STATES + 1;
  fails(SlipFrictionRegister(&law), "has 9 states, expected 0 to 8");
  SlipFrictionBalance(&f, NULL, 2, ETA, tau, 1, s, v, NULL);
  for (int i = 0; i < 2; i++) {
    const SlipFriction p = {.a = a[i], .b = b[i], .reference = f0[i], .slip = slip[i], .reference_rate = 1e-6};

    w[i] = SlipFrictionBalanceOne(found, &p, &s[i], sigma[i], ETA, tau[i]);
    assert_true(fabs(v[i] / w[i] - 1) < 1e-12); /* EPS tau/(a sigma), 200 here, and some */
  }
}

static int evaluations;

static void Counted(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal ds[],
                    PetscReal *dv)
{
  evaluations++;
  SlipRateAndState(p, s, v, mu, ds, dv);
}

/* Cells that have lost nearly all normal stress slide at nearly tau/eta, the upper end of the bracket. Newton's method
   from there takes few evaluations, where bisection towards it would take more than 50; the rates balance to
   rounding, which has the terms of the logarithm in mu and of ln v. */
static void unclamped(void **state)
{
  const SlipFriction p = Parameters(0.01);
  SlipFrictionLaw law = *Law();

  law.eval = Counted;
  for (PetscReal sigma = 1e8; sigma > 1e-14; sigma = sigma > 1e-12 ? sigma / 10 : 0)
    for (PetscReal s = -15; s < 20; s += 5) {
      const PetscReal tau = 2e7;
      PetscReal v;

      evaluations = 0;
      v = SlipFrictionBalanceOne(&law, &p, &s, sigma, ETA, tau);
      assert_true(v > 0 && v <= tau / ETA * (1 + 40 * EPS));
      assert_true(evaluations <= 30);
      assert_true(fabs((PetscReal)(sigma * Formula(&p, s, v) + (long double)ETA * v - tau)) <=
                  200 * EPS * (tau + sigma * p.a));
    }
  assert_true(SlipFrictionBalanceOne(&law, &p, &(PetscReal){7}, 0, ETA, -2e7) == -2e7 / ETA);
}

/* ---- several states ---- */

enum { D2 = 3 }; /* d_2/d_c */

/* Rate-and-state friction of psi + 0.3 T, and a second state T that follows 0.2 psi: both rates depend on both
   states. */
static void Pair(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal ds[], PetscReal *dv)
{
  const PetscReal sum = s[0] + 0.3 * s[1];

  SlipRateAndState(p, &sum, v, mu, ds, dv);
  ds[1] = 0.3 * ds[0];
}

static void PairRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal ds[],
                     PetscReal dv[])
{
  const PetscReal sum = s[0] + 0.3 * s[1], share = v / (D2 * p->slip);

  SlipRateAndStateRate(p, &sum, v, rate, ds, dv);
  ds[1] = 0.3 * ds[0];
  rate[1] = share * (0.2 * s[0] - s[1]);
  ds[2] = 0.2 * share;
  ds[3] = -share;
  dv[1] = (0.2 * s[0] - s[1]) / (D2 * p->slip);
}

static void PairSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  s[0] = log(p->reference_rate / v) / 1.06;
  s[1] = 0.2 * s[0];
}

static const SlipFrictionState names[] = {{.name = "psi", .start = "initial_state"},
                                          {.name = "t", .start = "initial_state"}};
static const SlipFrictionLaw pair = {.name = "pair",
                                     .eval = Pair,
                                     .formula = "pair",
                                     .by_rate = PETSC_TRUE,
                                     .always_slides = PETSC_TRUE,
                                     .states = names,
                                     .nstates = 2,
                                     .rate = PairRate,
                                     .steady = PairSteady};

/* An implicit stage of both states, to the rounding of the terms of their rates, and its derivative and that of the
   strength, of which mu is a tenth or so, by differences, as advance() has it for one */
static void advance_two(void **state)
{
  const PetscReal a[] = {0.01}, b[] = {0.03}, f0[] = {0.6}, slip[] = {0.14}, s0[] = {6.9, -2}, stress[] = {1};
  SlipFrictionCells f = Cells(a, b, f0, slip);

  f.law = &pair;
  f.stress = stress;
  for (int slip_law = 0; slip_law < 2; slip_law++)
    for (PetscReal v = 1e-15; v < 10; v *= 30)
      for (PetscReal theta = 1e-4; theta < 1e9; theta *= 50) {
        const PetscReal h = 1e-5;
        PetscReal s[2], rate[2], mu, ds[2], dv, slope[2], side[2][2], q, dq, near[2];

        f.state_law = (SlipStateLaw)slip_law;
        SlipFrictionStateAdvance(&f, 1, theta, s0, &v, 2, s);
        SlipFrictionStateRate(&f, 1, 2, s, 1, &v, rate);
        SlipFrictionStage(&f, 0, theta, s0, v, &mu, ds, &dv, slope);
        SlipFrictionStrength(&f, 1, theta, 2, s0, 1, &v, &q, &dq);
        for (int k = 0; k < 2; k++) {
          const PetscReal other = v * (1 + (k ? h : -h));

          SlipFrictionStateAdvance(&f, 1, theta, s0, &other, 2, side[k]);
          SlipFrictionStrength(&f, 1, theta, 2, s0, 1, &other, &near[k], NULL);
        }
        assert_true(q == mu && fabs(dq * v - (near[1] - near[0]) / (2 * h)) <= 1e-9 / h * 1e-3);
        for (int k = 0; k < 2; k++) {
          const PetscReal sum = s[0] + 0.3 * s[1],
                          fast = v / 0.14 * (1 + fabs(log(v / 1e-6)) + fabs(s[0]) + fabs(s[1]));

          assert_true(fabs(s[k] - s0[k] - theta * rate[k]) <=
                      8 * EPS * (10 + fabs(s[0]) + fabs(s[1])) * (1 + theta * (1e-6 / 0.14 * exp(-sum) + fast)));
          assert_true(fabs(slope[k] * v - (side[1][k] - side[0][k]) / (2 * h)) <=
                      1e-6 * (fabs(slope[k] * v) + 1) / h * 1e-3);
        }
      }
}

/* Two states that turn around each other, ds/dt = v (s_2, -s_1): an implicit stage is a rotation and a shrinkage, to
   rounding. Where it is long the matrix has its largest entries beside the diagonal. */
static void TurnRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal ds[],
                     PetscReal dv[])
{
  rate[0] = v * s[1];
  rate[1] = -v * s[0];
  ds[1] = v;
  ds[2] = -v;
  dv[0] = s[1];
  dv[1] = -s[0];
}

static void TurnSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  s[0] = s[1] = 0;
}

static void advance_turning(void **state)
{
  const PetscReal one[] = {1}, s0[] = {3, 1}, v = 2;
  SlipFrictionLaw law = pair;
  SlipFrictionCells f = Cells(one, one, one, one);

  law.rate = TurnRate;
  law.steady = TurnSteady;
  f.law = &law;
  for (PetscReal theta = 0.01; theta < 100; theta *= 10) {
    const PetscReal angle = theta * v, all = 1 + angle * angle;
    PetscReal s[2];

    SlipFrictionStateAdvance(&f, 1, theta, s0, &v, 2, s);
    AssertNear(s[0], (s0[0] + angle * s0[1]) / all, 1e-14);
    AssertNear(s[1], (s0[1] - angle * s0[0]) / all, 1e-14);
  }
}

/* The stiffness at which steady slip becomes unstable, by Hurwitz's criterion: with m = mu_s, J = f_s, r = f_v, t and
   D the trace and determinant of J, growth rates x have mu_v x^3 + (K + A) x^2 + (B - t K) x + K D = 0 with A = m r -
   mu_v t and B = mu_v D + m (J - t) r, and the real part of two of them is 0 where (K + A)(B - t K) = mu_v K D. To
   the rounding of a root's place, 1e-16 over the slope. Where there is no such K slip is stable. */
static void unstable_two(void **state)
{
  const PetscReal a[] = {0.01}, b[] = {0.03, 0.012, 0.008}, f0[] = {0.6}, slip[] = {0.14}, v = 1e-9;
  int found = 0;

  for (int i = 0; i < 6; i++) {
    SlipFrictionCells f = Cells(a, b + i / 2, f0, slip);
    const SlipFriction p = {.a = 0.01,
                            .b = b[i / 2],
                            .slip = 0.14,
                            .reference = 0.6,
                            .reference_rate = 1e-6,
                            .state_law = (SlipStateLaw)(i % 2)};
    PetscReal s[2], mu, m[2], mu_v, rate[2], J[4], r[2], fall, critical, t, D, A, B, half, root;

    f.law = &pair;
    f.state_law = p.state_law;
    pair.steady(&p, v, s);
    pair.eval(&p, s, v, &mu, m, &mu_v);
    pair.rate(&p, s, v, rate, J, r);
    assert_true(fabs(rate[0]) < 1e-22 && fabs(rate[1]) < 1e-22);
    t = J[0] + J[3];
    D = J[0] * J[3] - J[1] * J[2];
    A = m[0] * r[0] + m[1] * r[1] - mu_v * t;
    B = mu_v * D + m[0] * ((J[0] - t) * r[0] + J[1] * r[1]) + m[1] * (J[2] * r[0] + (J[3] - t) * r[1]);
    /* t K^2 + (mu_v D + A t - B) K - A B = 0 */
    half = -(mu_v * D + A * t - B) / (2 * t);
    root = half + sqrt(PetscMax(half * half + A * B / t, 0));
    SlipFrictionWeakening(&f, 0, v, &fall, &critical);
    assert_true(fabs(fall - b[i / 2] / 0.14) < 1e-12 * fall);
    if (half * half + A * B / t >= 0 && root > 0 && B - t * root > 0) {
      assert_true(fabs(critical / root - 1) < 1e-10);
      found++;
    } else
      assert_true(critical <= 0);
  }
  assert_true(found > 0 && found < 6);
}

/* Ruina's states with b_k and the relaxation rates r_k = v/d_k: with x_k = w^2/(w^2 + r_k^2) disturbances of the
   frequency w last where sum b_k (1 - x_k) = a, at the stiffness sum b_k r_k x_k/v. That is at three frequencies here,
   of which the lowest has the largest stiffness. */
static const PetscReal ruina_a = 5e-4, ruina_b[] = {0.05, -0.04, 0.01}, ruina_slip[] = {1, 1.0 / 30, 1.0 / 90};

static void Ruina(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal ds[], PetscReal *dv)
{
  *mu = ruina_a * log(v);
  *dv = ruina_a / v;
  for (int k = 0; k < 3; k++) {
    *mu += ruina_b[k] * s[k];
    ds[k] = ruina_b[k];
  }
}

static void RuinaRate(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal ds[],
                      PetscReal dv[])
{
  for (int k = 0; k < 3; k++) {
    rate[k] = -v / ruina_slip[k] * (s[k] + log(v));
    ds[4 * k] = -v / ruina_slip[k];
    dv[k] = -(s[k] + log(v) + 1) / ruina_slip[k];
  }
}

static void RuinaSteady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  s[0] = s[1] = s[2] = -log(v);
}

/* The excess of sum b_k (1 - x_k) over a; *k: the stiffness */
static PetscReal Lasts(PetscReal v, PetscReal w, PetscReal *k)
{
  PetscReal excess = -ruina_a;

  *k = 0;
  for (int i = 0; i < 3; i++) {
    const PetscReal r = v / ruina_slip[i], x = w * w / (w * w + r * r);

    excess += ruina_b[i] * (1 - x);
    *k += ruina_b[i] * x / ruina_slip[i];
  }
  return excess;
}

static void unstable_three(void **state)
{
  const PetscReal one[] = {1}, v = 2;
  SlipFrictionLaw law = pair;
  SlipFrictionCells f = Cells(one, one, one, one);
  PetscReal stiffness[3] = {0}, fall, critical;
  int found = 0;

  law.nstates = 3;
  law.eval = Ruina;
  law.rate = RuinaRate;
  law.steady = RuinaSteady;
  f.law = &law;
  for (PetscReal w = 1e-3 * v; w < 1e4 * v; w *= 1.1) {
    PetscReal low = w, high = 1.1 * w, k;
    const PetscBool positive = Lasts(v, low, &k) > 0 ? PETSC_TRUE : PETSC_FALSE;

    if (positive == (Lasts(v, high, &k) > 0)) continue;
    for (int it = 0; it < 60; it++) {
      const PetscReal middle = 0.5 * (low + high);

      *(positive == (Lasts(v, middle, &k) > 0) ? &low : &high) = middle;
    }
    assert_true(found < 3);
    stiffness[found++] = k;
  }
  assert_true(found == 3 && stiffness[0] > 0 && stiffness[0] > stiffness[1] && stiffness[0] > stiffness[2]);
  SlipFrictionWeakening(&f, 0, v, &fall, &critical);
  AssertNear(fall, 0.05 - 0.04 * 30 + 0.01 * 90, 1e-14);
  AssertNear(critical / stiffness[0], 1, 1e-10); /* as in unstable_two() */
}

/* States after a step at a constant rate are exact: one step is as good as many, and many of Euler's are nearly. Where
   normal stress changes the state, that of theta evolves as without. */
static void drift(void **state)
{
  const PetscReal slip = 0.05, start[] = {0.3, -2}, alpha = 0.25, b = 0.02, stress = 2e7, first = 3e7;
  const PetscReal shift = SlipRateAndStateShift(alpha, b, stress, first);
  SlipFrictionCells f = {.slip = &slip, .reference_rate = 1e-6};

  ok(SlipFrictionFind("rate_and_state", &f.law));
  for (int k = 0; k < 8; k++) {
    const SlipFriction p = {
      .slip = slip, .reference_rate = 1e-6, .state_law = k % 2 ? SLIP_STATE_SLIP : SLIP_STATE_AGING};
    const PetscReal v = k / 4 ? -0.2 : 1e-9, h = k / 4 ? 0.5 : 1e6;
    PetscReal s = start[k / 2 % 2], many = s, euler = s, shifted = s + shift, work, rate, ds, dv;
    SlipFrictionCells follows;

    f.state_law = p.state_law;
    follows = f;
    follows.alpha = &alpha;
    follows.b = &b;
    follows.stress = &stress;
    follows.start = &first;
    SlipFrictionStateDrift(&follows, 1, h, &v, 1, &shifted, &work);
    SlipFrictionStateDrift(&f, 1, h, &v, 1, &s, &work);
    AssertNear(shifted, s + shift, 1e-13); /* numbers of up to 20 */
    for (int i = 0; i < 100000; i++) {
      SlipFrictionStateDrift(&f, 1, h / 100000, &v, 1, &many, &work);
      SlipRateAndStateRate(&p, &euler, PetscAbsReal(v), &rate, &ds, &dv);
      euler += rate * h / 100000;
    }
    AssertNear(many, s, 1e-9);
    AssertNear(euler, s, 2e-3);
  }
}

/* ---- the composite law ---- */

SLIP_TESTS(friction, balance, many, extremes, advance, state_of, follows_normal_stress, registered, unclamped,
           advance_two, drift, advance_turning, unstable_two, unstable_three)
