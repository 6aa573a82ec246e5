/* The pure functions of the cone: projection, regions, natural map, generalised Jacobian. */
#include "unit.h"
#include <petscsys.h>
#include <slipstep/rooms/slipcore.h>

static void test_projections(void **state)
{
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

  for (PetscReal r = 0.125; r < 20.0; r *= 4.0) {
    const PetscReal rho[] = {r, r, r, r, r};

    SlipConeNatural(5, omega, x, g, q, dq, rho, F, mask, slope);
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

/* A row that slides against the sign of its x is no solution, and needs no test of its own: its residual is larger than
   |x| / rho, for all x, g, q and rho of a grid of binary fractions, in which nothing is rounded. Against that the slope
   changes its sign. */
static void test_residual_of_rows_that_slide_backwards(void **state)
{
  const PetscReal dq = -0.25, omega = 2.0;
  PetscReal F, mask, slope;
  PetscInt backwards = 0;

  for (PetscReal rho = 0.25; rho <= 4.0; rho *= 4.0)
    for (PetscReal q = 0.5; q <= 2.0; q *= 2.0)
      for (PetscReal x = -2.0; x <= 2.0; x += 0.125)
        for (PetscReal g = -16.0; g <= 16.0; g += 0.25) {
          const PetscReal p = x - rho * g;

          if (!(PetscAbsReal(p) > rho * omega * q && p * x < 0.0)) continue;
          SlipConeNatural(1, omega, &x, &g, &q, &dq, &rho, &F, &mask, &slope);
          assert_true(PetscAbsReal(F) > PetscAbsReal(x) / rho);
          assert_true(mask == 1.0 && slope == 0.5);
          backwards++;
        }
  assert_true(backwards > 1000);
}

/* Sticking rows and those that slide backwards end at exactly zero with a reaction inside the cone */
static void test_finish(void **state)
{
  const PetscReal g[] = {-1.0, 0.5, -3.0, 3.0, 4.0}, q[] = {1.0, 1.0, 1.0, 1.0, 0.0}, rho[] = {1.0, 1.0, 1.0, 1.0, 1.0};
  PetscReal x[] = {2.0, 0.25, -0.5, 0.5, -7.0}, r[5];

  SlipConeFinish(5, 1.0, g, q, rho, x, r);
  assert_true(x[0] == 2.0 && r[0] == -1.0);                /* slides */
  assert_true(x[1] == 0.0 && r[1] == 0.5);                 /* sticks: the balance */
  assert_true(x[2] == 0.0 && r[2] == -1.0);                /* backwards */
  assert_true(x[3] == 0.0 && r[3] == 1.0 && x[4] == -7.0); /* and the other way; no bound */
}

/* Rows that a step would reverse stop, but for those without a bound. Changes of x and g are measured by each row's own
   rho: 0.5 * 1 + 2 * 9, and 4 / 0.5 + 1 / 2. */
static void test_turning_and_changes(void **state)
{
  const PetscReal q[] = {1.0, 1.0, 0.0, 1.0}, from[] = {1.0, 1.0, 1.0, 0.0}, rho[] = {0.5, 2.0};
  const PetscReal x[] = {1.0, 2.0}, x1[] = {3.0, 1.0}, g[] = {0.0, 1.0}, g1[] = {1.0, -2.0};
  PetscReal to[] = {-0.5, 0.5, -0.5, -0.5}, sum[2] = {0.0, 0.0};

  assert_true(SlipConeStopTurning(4, q, from, to));
  assert_true(to[0] == 0.0 && to[1] == 0.5 && to[2] == -0.5 && to[3] == -0.5);
  assert_false(SlipConeStopTurning(4, q, from, to));
  SlipConeChanges(2, x, x1, g, g1, rho, sum);
  assert_true(sum[0] == 18.5 && sum[1] == 8.5);
}

SLIP_TESTS(test_projections, test_regions, test_natural_map_is_zero_at_solutions, test_slope_is_the_derivative,
           test_residual_of_rows_that_slide_backwards, test_finish, test_turning_and_changes)
