/* The composite law of the state of rate-and-state friction and that of Perrin, Rice and Zheng: their rates, steady
   states and drift. */
#include "../ratestate.h"

static const SlipFriction cell = {.b = 0.03,
                                  .slip = 0.14,
                                  .reference_rate = 1e-6,
                                  .state_law = SLIP_STATE_COMPOSITE,
                                  .cutoff_rate = CUTOFF,
                                  .shift = 0.7};

/* dpsi/dt = (dtheta/dt)/theta as Kato and Tullis (2001) write it, of theta and not of its logarithm */
static long double Composite(long double s, long double v)
{
  const long double theta = (long double)cell.slip / cell.reference_rate * expl(s - cell.shift),
                    x = v * theta / cell.slip;

  return (expl(-v / cell.cutoff_rate) - x * logl(x)) / theta;
}

/* The rate to the rounding of its two terms, and its derivatives by central differences in s and ln v, which are off by
   h^2/6 of third derivatives: those of exp(-v/V_c) are up to (v/V_c)^2 times its first, and it is below 1e-8 of itself
   from v = 20 V_c on. */
static void rate_of_state(void **state)
{
  const long double h = 1e-4L;

  for (PetscReal v = 1e-16; v < 10; v *= 3)
    for (PetscReal s = -20; s < 25; s += 1.3) {
      const PetscReal x = v / cell.cutoff_rate, healing = 1e-6 / 0.14 * exp(0.7 - s - x);
      const PetscReal terms = healing * (1 + fabs(s) + x) + v / 0.14 * (1 + fabs(log(v / 1e-6)) + fabs(s));
      PetscReal rate, ds, dv;

      SlipRateAndStateRate(&cell, &s, v, &rate, &ds, &dv);
      assert_true(fabs(rate - (PetscReal)Composite(s, v)) <= 8 * EPS * terms);
      AssertNear(ds, (PetscReal)((Composite(s + h, v) - Composite(s - h, v)) / (2 * h)), 1e-8 * terms);
      AssertNear(dv * v, (PetscReal)((Composite(s, v * expl(h)) - Composite(s, v * expl(-h))) / (2 * h)),
                 1e-8 * terms * (1 + PetscMin(x * x * x, 1e4)));
      assert_true(ds < 0);
    }
}

/* The law of Perrin, Rice and Zheng (1995) likewise, of theta; its cells one by one and many at once; its steady state,
   2 d_c/V, and a state whose theta is d_c/V, which by 3/4 of a second a second grows. */
static void perrin(void **state)
{
  const long double h = 1e-4L;
  const PetscReal one[] = {1}, slip[] = {cell.slip};
  SlipFriction p = cell;
  SlipFrictionCells f = Cells(one, one, one, slip);

  p.state_law = f.state_law = SLIP_STATE_PRZ;
  for (PetscReal v = 1e-16; v < 10; v *= 3)
    for (PetscReal s = -20; s < 25; s += 1.3) {
      const PetscReal healing = 1e-6 / 0.14 * exp(0.7 - s), fall = v * v * exp(s - 0.7) / (4 * 0.14 * 1e-6);
      PetscReal rate, ds, dv, got, bare = s - 0.7;
      long double side[2];

      SlipRateAndStateRate(&p, &s, v, &rate, &ds, &dv);
      for (int k = 0; k < 2; k++) {
        const long double theta = 0.14L / 1e-6L * expl(s - 0.7L + (k ? h : -h)), x = v * theta / 0.28L;

        side[k] = (1 - x * x) / theta;
      }
      assert_true(fabs(rate - (PetscReal)(0.5L * (side[0] + side[1]))) <= 2e-8 * (healing + fall));
      AssertNear(ds, (PetscReal)((side[1] - side[0]) / (2 * h)), 1e-8 * (healing + fall));
      AssertNear(dv * v, -2 * fall, 1e-14 * fall * (10 + fabs(s)));
      SlipFrictionStateRate(&f, 1, 1, &bare, 1, &v, &got);
      AssertNear(got, rate, 8 * EPS * (healing + fall) * (10 + fabs(s)));
    }
  for (PetscReal v = 1e-20; v < 10; v *= 3) {
    PetscReal s, rate, ds, dv;

    SlipRateAndStateSteady(&p, v, &s);
    AssertNear(SlipRateAndStateTheta(&p, s) * v / cell.slip, 2, 1e-13);
    SlipRateAndStateRate(&p, &s, v, &rate, &ds, &dv);
    assert_true(fabs(rate) <= 50 * EPS * v / 0.14);
    s -= log(2);
    SlipRateAndStateRate(&p, &s, v, &rate, &ds, &dv);
    AssertNear(rate * SlipRateAndStateTheta(&p, s), 0.75, 1e-13);
  }
}

/* Steady states: the rate is 0 to the rounding of its terms, v/d_c times logarithms of up to 40. Far below the cut-off
   rate V theta/d_c is exp(W(1)) = 1.763, far above it 1; between, steady friction falls faster with ln v than by
   b - a. */
static void steady_state(void **state)
{
  const PetscReal a[] = {0.01}, b[] = {0.03}, f0[] = {0.6}, slip[] = {0.14};
  SlipFrictionCells f = Cells(a, b, f0, slip);
  PetscReal s, rate, ds, dv, fall, critical;

  for (PetscReal v = 1e-20; v < 10; v *= 3) {
    SlipRateAndStateSteady(&cell, v, &s);
    SlipRateAndStateRate(&cell, &s, v, &rate, &ds, &dv);
    assert_true(fabs(rate) <= 8 * EPS * v / 0.14 * 40);
  }
  SlipRateAndStateSteady(&cell, 1e-20, &s);
  AssertNear(s - 0.7 - log(1e-6 / 1e-20), 0.56714329040978387, 1e-11); /* W(1) less 1e-12 (v/V_c) of itself */
  SlipRateAndStateSteady(&cell, 1, &s);
  AssertNear(s - 0.7 - log(1e-6), 0, 1e-14);
  /* Far from the cut-off rate K_c is (b (1 + W) - a (1 + W))/d_c, with W = W(1) below it, 0 above it */
  f.state_law = SLIP_STATE_COMPOSITE;
  SlipFrictionWeakening(&f, 0, 1e-20, &fall, &critical);
  AssertNear(critical, 0.02 / 0.14 * 1.56714329040978387, 1e-11);
  SlipFrictionWeakening(&f, 0, 1e-3, &fall, &critical);
  AssertNear(critical, 0.02 / 0.14, 1e-12);
  SlipFrictionWeakening(&f, 0, CUTOFF, &fall, &critical);
  assert_true(critical > 0.02 / 0.14 * 1.3);
}

/* The state after a time at a constant rate, for which this law has no closed form: of second order, so that halving
   the steps leaves a quarter of the error, to a tenth; and the steady state stays. */
static void drift(void **state)
{
  const PetscReal slip = 0.05, one = 1, h = 2e6;
  SlipFrictionCells f = Cells(&one, &one, &one, &slip);
  const SlipFriction p = {
    .slip = slip, .reference_rate = 1e-6, .state_law = SLIP_STATE_COMPOSITE, .cutoff_rate = CUTOFF};
  PetscReal v = CUTOFF, s, end[3], steady, work;

  f.state_law = p.state_law;
  for (int k = 0; k < 3; k++) {
    const int n = k < 2 ? 20 << k : 20000;

    end[k] = -2;
    for (int i = 0; i < n; i++) SlipFrictionStateDrift(&f, 1, h / n, &v, 1, &end[k], &work);
  }
  AssertNear((end[0] - end[2]) / (end[1] - end[2]), 4, 0.4);
  SlipRateAndStateSteady(&p, v, &steady);
  s = steady;
  SlipFrictionStateDrift(&f, 1, 1e12, &v, 1, &s, &work);
  AssertNear(s, steady, 1e-13);
}

SLIP_TESTS(rate_of_state, perrin, steady_state, drift)
