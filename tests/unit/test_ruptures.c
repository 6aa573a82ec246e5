/* What steps of ruptures are trained by: the error of drawn ruptures. */
#include "unit.h"
#include "ruptures/ruptures.h"

enum { STREAM = 98, LARGE = 106 }; /* of seeds, neither training's nor the benchmark's; one of slips of several d_c */

static void run(RuptureEpisode *e, SlipPolicy policy, PetscReal setting, PetscInt *solves, PetscReal *error)
{
  PetscReal errors[SLIP_NUM_ERRORS];
  PetscInt rejected;

  ok(RuptureEpisodeRun(e, policy, setting, TSADAPTPI, setting, solves, &rejected, errors, error));
  assert_true(rejected < *solves);
  for (PetscInt i = 0; i < SLIP_NUM_ERRORS; i++)
    assert_true(i == SLIP_ERROR_PEAK || (errors[i] >= 0 && errors[i] <= *error));
}

/* A run with the reference's tolerance is the reference; a loose one is worse than a tight one, by more than twenty times for 400 times the
   tolerance, as errors go with its power of two thirds: 54. */
static void measured(void **state)
{
  RuptureEpisode e;
  PetscInt fine, coarse;
  PetscReal same, small, large;

  (void)state;
  ok(RuptureEpisodeCreate(RandomStreamHashed(77, STREAM, LARGE), 1, &e));
  assert_true(e.rise > 0 && e.end > e.rise);
  run(&e, NULL, RUPTURE_REFERENCE_RTOL, &fine, &same);
  assert_true(same == 0);
  assert_int_equal(fine, e.reference.solves);
  run(&e, NULL, 1e-4, &fine, &small);
  run(&e, NULL, 4e-2, &coarse, &large);
  assert_true(coarse < fine);
  if (!(large > 20 * small && small > 0)) fail_msg("%g and %g", (double)large, (double)small);
  ok(RuptureEpisodeDestroy(&e));
}

/* A cell that breaks in one of two runs alone counts as if it had broken a rise time too late, but not where its slip is close to d_c. */
static void broken(void **state)
{
  RuptureEpisode e;
  PetscInt solves, last = -1, count = 0;
  PetscReal error;

  (void)state;
  ok(RuptureEpisodeCreate(RandomStreamHashed(77, STREAM, LARGE), 1, &e));
  for (PetscInt i = 0; i < e.n; i++)
    if (e.reference.slip[i] > 2 * e.weaken[i]) {
      assert_true(e.reference.broke[i] >= 0);
      last = i;
    }
  for (PetscInt i = 0; i < e.n; i++)
    if (e.reference.slip[i] > 1.25 * e.weaken[i]) count++;
  assert_true(last >= 0);
  e.reference.broke[last] = -1;
  run(&e, NULL, RUPTURE_REFERENCE_RTOL, &solves, &error);
  AssertNear(error, PetscSqrtReal(1 / (PetscReal)(count - 1)), 1e-12);
  ok(RuptureEpisodeDestroy(&e));
}

SLIP_TESTS(measured, broken)
