/* The pure functions of the cone: projection, regions, natural map, generalised Jacobian. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include <petscsys.h>
#include <slipcore.h>

static void test_projections(void **state)
{
  (void)state;
  assert_true(SlipConeShrink(3.0, 1.0) == 2.0);
  assert_true(SlipConeShrink(-3.0, 1.0) == -2.0);
  assert_true(SlipConeShrink(0.5, 1.0) == 0.0);
  assert_true(SlipConeClip(3.0, 1.0) == 1.0);
  assert_true(SlipConeClip(-3.0, 1.0) == -1.0);
  assert_true(SlipConeClip(0.25, 1.0) == 0.25);
  /* Moreau: p = shrink(p, k) + clip(p, k), exactly for these binary fractions */
  for (double p = -2.0; p <= 2.0; p += 0.25) assert_true(SlipConeShrink(p, 0.75) + SlipConeClip(p, 0.75) == p);
}

static void test_regions(void **state)
{
  (void)state;
  assert_int_equal(SlipConeRegion(0.0, 0.5, 1.0, 1.0), SLIP_REGION_STICK);
  assert_int_equal(SlipConeRegion(0.0, -1.5, 1.0, 1.0), SLIP_REGION_POSITIVE);
  assert_int_equal(SlipConeRegion(0.0, 1.5, 1.0, 1.0), SLIP_REGION_NEGATIVE);
  assert_int_equal(SlipConeRegion(2.0, -1.0, 1.0, 1.0), SLIP_REGION_POSITIVE);
  /* a row without a bound is never an identity row, not even at x = g = 0 */
  assert_int_equal(SlipConeRegion(0.0, 0.0, 1.0, 0.0), SLIP_REGION_FREE);
}

/* The natural residual vanishes exactly at solutions of g = omega r, r in -q Sign(x), for whatever rho */
static void test_natural_map_is_zero_at_solutions(void **state)
{
  const PetscReal x[] = {2.0, -2.0, 0.0, 0.0, 5.0}, q[] = {1.0, 1.0, 1.0, 1.0, 0.0}, omega = 2.0;
  const PetscReal g[] = {-2.0, 2.0, 1.5, -2.0, 0.0};
  const PetscReal dq[5] = {0};
  PetscReal F[5], mask[5], slope[5];

  (void)state;
  for (PetscReal r = 0.125; r < 20.0; r *= 4.0) {
    const PetscReal rho[] = {r, r, r, r, r};

    assert_true(SlipConeNatural(5, omega, x, g, q, dq, rho, F, mask, slope) == 0.0);
    for (int i = 0; i < 5; i++) assert_true(F[i] == 0.0);
    assert_true(mask[0] == 1.0 && mask[1] == 1.0 && mask[2] == 0.0 && mask[4] == 1.0);
  }
  assert_true(SlipConeReaction(omega, x[0], g[0], q[0]) == -1.0);
  assert_true(SlipConeReaction(omega, x[2], g[2], q[2]) == 0.75);
  assert_true(SlipConeReaction(omega, x[4], g[4], q[4]) == 0.0);
}

/* Slope against a central difference of F with q(|x|) = 1 - 0.3 |x|; the error of the difference of a linear function
   is rounding only, 1e-16 / 1e-6 */
static void test_slope_is_the_derivative(void **state)
{
  const PetscReal points[] = {0.7, -0.7}, forces[] = {-3.0, 3.0}, eps = 1e-6, omega = 1.5, rho = 1.0;

  (void)state;
  for (int k = 0; k < 2; k++) {
    PetscReal F[2], mask, slope, unused, dq = -0.3, q = 1.0 - 0.3 * PetscAbsReal(points[k]);

    SlipConeNatural(1, omega, &points[k], &forces[k], &q, &dq, &rho, F, &mask, &slope);
    for (int s = 0; s < 2; s++) {
      PetscReal y = points[k] + (s ? -eps : eps), qy = 1.0 - 0.3 * PetscAbsReal(y);

      SlipConeNatural(1, omega, &y, &forces[k], &qy, &dq, &rho, &F[s], &mask, &unused);
    }
    assert_true(mask == 1.0);
    assert_true(PetscAbsReal(slope - (F[0] - F[1]) / (2.0 * eps)) < 1e-8);
  }
}

/* A row that slides against the sign of its x is reported, in units of g */
static void test_inconsistency(void **state)
{
  const PetscReal x = -0.5, g = -4.0, q = 1.0, dq = -0.3, rho = 0.25;
  PetscReal F, mask, slope;

  (void)state;
  assert_int_equal(SlipConeRegion(x, g, rho, q), SLIP_REGION_POSITIVE);
  assert_true(SlipConeNatural(1, 1.0, &x, &g, &q, &dq, &rho, &F, &mask, &slope) == 2.0);
  assert_true(slope == 0.3); /* q rises on the way to zero */
}

int main(void)
{
  const struct CMUnitTest tests[] = {
    cmocka_unit_test(test_projections),
    cmocka_unit_test(test_regions),
    cmocka_unit_test(test_natural_map_is_zero_at_solutions),
    cmocka_unit_test(test_slope_is_the_derivative),
    cmocka_unit_test(test_inconsistency),
  };

  return cmocka_run_group_tests(tests, NULL, NULL);
}
