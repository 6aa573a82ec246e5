/* Strong rate weakening: the steady state and the evolution as Noda, Dunham and Rice (2009) write them, with psi, in
   more digits; derivatives; many cells at once; steps of the slip rate; the slip law far below V_w; what is refused. */
#include "../ratestate.h"
#include "faultstart.h"

enum { WEAKENED, WEAKENING_RATE };
static const PetscReal own[] = {[WEAKENED] = 0.2, [WEAKENING_RATE] = 0.1};
static const SlipFriction cell = {
  .a = 0.01, .b = 0.014, .slip = 0.4, .reference = 0.6, .reference_rate = 1e-6, .shift = 0.3, .own = own};

static const SlipFrictionLaw *Strong(void)
{
  const SlipFrictionLaw *law;

  ok(SlipFrictionFind("strong_rate_weakening", &law));
  assert_non_null(law);
  return law;
}

static long double SteadyFriction(long double v)
{
  const long double low = 0.6L - ((long double)cell.b - cell.a) * logl(v / 1e-6L);

  return 0.2L + (low - 0.2L) / powl(1 + powl(v / 0.1L, 8), 0.125L);
}

/* ds/dt = (dpsi/dt)/b */
static long double Rate(long double s, long double v)
{
  const long double psi = 0.6L + cell.b * (s - 0.3L), y = SteadyFriction(v) / cell.a;

  return -v / 0.4L * (psi - cell.a * logl(2e-6L / v * sinhl(y))) / cell.b;
}

/* To the rounding of logarithms of up to 40 over b/a; derivatives by central differences, off by h^2/6 of third ones,
   which for the eighth power are 64 times the first */
static void rate_of_state(void **state)
{
  const long double h = 1e-4L;
  const SlipFrictionLaw *law = Strong();

  for (PetscReal v = 1e-16; v < 100; v *= 1.7)
    for (PetscReal s = -20; s < 25; s += 2.7) {
      const PetscReal terms = v / cell.slip * 200;
      PetscReal rate, ds, dv;

      law->rate(&cell, &s, v, &rate, &ds, &dv);
      AssertNear(rate, (PetscReal)Rate(s, v), 8 * EPS * terms);
      AssertNear(ds, -v / cell.slip, EPS * v);
      AssertNear(dv * v, (PetscReal)((Rate(s, v * expl(h)) - Rate(s, v * expl(-h))) / (2 * h)), 1e-6 * terms);
    }
}

/* Steady friction is f_ss, as asinh with sinh gives it back; the rate there is 0; far below V_w the slip law has the
   same state, but for its asinh, and far above it friction is f_w and what is left of f_LV over V/V_w. Steady slip
   weakens most with ln V about V_w: the stiffness below which it is unstable is -d f_ss/d ln V over d_c. */
static void steady_state(void **state)
{
  const PetscReal a[] = {cell.a}, b[] = {cell.b}, f0[] = {0.6}, slip[] = {0.4};
  const SlipFrictionLaw *law = Strong();
  SlipFrictionCells f = Cells(a, b, f0, slip);
  PetscReal s, mu, ds, dv, rate, fall, critical;
  const long double h = 1e-4L;

  f.law = law, f.own = own, f.nown = 2;
  for (PetscReal v = 1e-20; v < 1e3; v *= 3) {
    law->steady(&cell, v, &s);
    law->eval(&cell, &s, v, &mu, &ds, &dv);
    AssertNear(mu, (PetscReal)SteadyFriction(v), 1e-14);
    law->rate(&cell, &s, v, &rate, &ds, &dv);
    assert_true(fabs(rate) <= 8 * EPS * v / 0.4 * 200);
    SlipFrictionWeakening(&f, 0, v, &fall, &critical);
    /* the fall that a rupture finds is all that is left to lose after the step to its rate, over d_c */
    law->steady(&cell, v, &s);
    law->eval(&cell, &s, 1, &mu, &ds, &dv);
    AssertNear(fall * 0.4, mu - (PetscReal)SteadyFriction(1), 1e-12);
    AssertNear(critical * 0.4, (PetscReal)((SteadyFriction(v * expl(-h)) - SteadyFriction(v * expl(h))) / (2 * h)),
               1e-7);
  }
  law->steady(&cell, 1e-9, &s);
  AssertNear(s - 0.3, log(1e3), 1e-12);
  law->steady(&cell, 1e3, &s);
  law->eval(&cell, &s, 1e3, &mu, &ds, &dv);
  AssertNear(mu, 0.2, 1e-4 * 0.4);
}

/* Many cells at once are those one by one, and a state drifts at constant rates as its linear equation does. */
static void many(void **state)
{
  enum { N = 700 };
  static PetscReal a[N], b[N], f0[N], slip[N], stress[N], tau[N], s[N], v[N], ds[N], mine[2 * N], kept[4 * N];
  const SlipFrictionLaw *law = Strong();
  SlipFrictionCells f = Cells(a, b, f0, slip);
  int fast = 0;

  f.law = law, f.stress = stress, f.own = mine, f.nown = 2;
  for (int i = 0; i < N; i++) {
    a[i] = 0.008 + 1e-5 * (i % 10), b[i] = 0.012, f0[i] = 0.6, slip[i] = 0.1, stress[i] = 1e8;
    mine[2 * i] = 0.1 + 1e-4 * i, mine[2 * i + 1] = 0.1 + 1e-3 * i;
    tau[i] = (i % 2 ? -1 : 1) * (3e7 + 1e5 * (i % 300)), s[i] = -30 + 0.08 * (i % 500);
  }
  law->keep(&f, N, 4.6e6, kept);
  SlipFrictionBalance(&f, kept, N, 4.6e6, tau, 1, s, v, ds);
  for (int i = 0; i < N; i++) {
    const SlipFriction p = {
      .a = a[i], .b = b[i], .slip = slip[i], .reference = 0.6, .reference_rate = 1e-6, .own = mine + 2 * i};
    PetscReal mu, d, dv, rate, steady, end = s[i], work[1];
    const SlipFrictionCells one = {.law = law,
                                   .a = a + i,
                                   .b = b + i,
                                   .slip = slip + i,
                                   .reference = f0 + i,
                                   .stress = stress + i,
                                   .residual = f0,
                                   .drop = f0,
                                   .rate = f0,
                                   .reference_rate = 1e-6,
                                   .own = mine + 2 * i,
                                   .nown = 2};

    law->eval(&p, &s[i], fabs(v[i]), &mu, &d, &dv);
    AssertNear((v[i] < 0 ? -1 : 1) * (mu * 1e8 + 4.6e6 * fabs(v[i])), tau[i], 1e-12 * 6e7);
    law->rate(&p, &s[i], fabs(v[i]), &rate, &d, &dv);
    AssertNear(ds[i], rate, 1e-14 * fabs(rate));
    fast += fabs(v[i]) > mine[2 * i + 1];
    law->steady(&p, fabs(v[i]), &steady);
    SlipFrictionStateDrift(&one, 1, 0.3 * slip[i] / fabs(v[i]), &v[i], 1, &end, work);
    AssertNear(end, steady + (s[i] - steady) * exp(-0.3), 1e-12 * (1 + fabs(steady) + fabs(s[i])));
  }
  assert_true(fast > N / 10 && fast < N / 2);
}

/* A step of the rate, in steady slip: at once friction rises by a times ln of the ratio, and then it goes to f_ss
   exponentially over d_c of slip, by Runge-Kutta's rule with 2000 steps: its error is (1/200)^4 of that. Below V_w the
   change is -(b - a) of ln V, and above it friction falls to f_w. */
static void step_of_rate(void **state)
{
  const PetscReal from[] = {1e-9, 1e-3, 1e-2}, to[] = {1e-8, 1, 10};
  const SlipFrictionLaw *law = Strong();

  for (int k = 0; k < 3; k++) {
    const PetscReal h = 10 * cell.slip / to[k] / 2000;
    PetscReal s, mu[3], ds, dv, r[4], x;

    law->steady(&cell, from[k], &s);
    law->eval(&cell, &s, from[k], &mu[0], &ds, &dv);
    law->eval(&cell, &s, to[k], &mu[1], &ds, &dv);
    AssertNear(mu[1] - mu[0], cell.a * log(to[k] / from[k]), 1e-13);
    for (int i = 0; i < 2000; i++) {
      for (int j = 0; j < 4; j++) {
        x = s + (j ? (j < 3 ? 0.5 : 1) * h * r[j - 1] : 0);
        law->rate(&cell, &x, to[k], &r[j], &ds, &dv);
      }
      s += h / 6 * (r[0] + 2 * r[1] + 2 * r[2] + r[3]);
    }
    law->eval(&cell, &s, to[k], &mu[2], &ds, &dv);
    AssertNear(mu[2] - (PetscReal)SteadyFriction(to[k]), (mu[1] - (PetscReal)SteadyFriction(to[k])) * exp(-10), 1e-9);
    if (!k) AssertNear((PetscReal)SteadyFriction(to[k]) - mu[0], -0.004 * log(10), 1e-12);
  }
}

/* The law's own parameters are numbers and fields of a fault, of which b must not be 0, and cards refuse it by name. */
static void of_faults(void **state)
{
  PetscReal rates[] = {0.1, 0.2, 0.3, 1}, got[4], theta[4];
  SlipFault fault;
  Vec w;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 2}, {"nz", 2}, {"friction_weakened", 0.15}, {"loading_rate", 1e-9},
                   {"initial_traction", 4e7}, {"initial_rate", 1e-12}, {"normal_stress", 8e7}));
  ok(FaultSetStrings(fault, {"friction_law", "strong_rate_weakening"}, {"initial", "traction"}));
  ok(SlipFaultSetField(fault, "friction_weakening_rate", 4, rates));
  ok(FaultSetUpState(fault, &w));
  ok(SlipFaultGetField(fault, "friction_weakening_rate", 4, got));
  ok(SlipFaultGetField(fault, "initial_state", 4, theta));
  for (int i = 0; i < 4; i++) { /* the state of the stress and rate at the start */
    const PetscReal psi = 0.6 + 0.015 * log(1e-6 * theta[i] / 0.1);

    assert_true(got[i] == rates[i]);
    AssertNear(psi, 0.01 * log(2e-6 / 1e-12 * sinh(0.5 / 0.01)), 1e-9);
  }
  ObjectsDestroy(&w, &fault);
  for (int k = 0; k < 2; k++) {
    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    ok(FaultSetReals(fault, {"loading_rate", 1e-9}, {"friction_b", k ? 0.015 : 0}));
    ok(SlipFaultSetString(fault, "friction_law", "strong_rate_weakening"));
    if (k) ok(SlipFaultSetString(fault, "device", "opencl"));
    fails(SlipFaultSetUp(fault), k ? "not strong_rate_weakening"
                                   : "-fault_friction_b is 0 in 1 of 1 cells, expected a number > 0 with "
                                     "-fault_friction_law strong_rate_weakening");
    ok(SlipFaultDestroy(&fault));
  }
}

SLIP_TESTS(rate_of_state, steady_state, many, step_of_rate, of_faults)
