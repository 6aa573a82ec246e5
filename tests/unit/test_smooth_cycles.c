/* What implicit steps through cycles of rate-and-state faults are measured by: the error of drawn faults. */
#include "unit.h"
#include "runs/smooth.h"

enum { STREAM = 98, QUICK = 0 }; /* of seeds, neither training's nor the benchmark's; one of a line of cells */

static void run(SmoothEpisode *e, PetscReal rtol, PetscInt *solves, PetscReal *error)
{
  SmoothErrors errors;
  PetscInt rejected;

  ok(SmoothEpisodeRun(e, NULL, 0, SMOOTH_REFERENCE_TYPE, rtol, solves, &rejected, &errors, error));
  assert_true(rejected >= 0 && rejected < *solves);
  assert_true(*error == PetscMax(errors.onset, PetscMax(errors.slip, errors.moment)));
}

/* A run with the reference's tolerance is the reference. A loose one is worse than a tight one: errors of a method of second order go with
   the power two thirds of the tolerance, 21 times for a hundred times the tolerance, of which half is asked for. An event that the
   reference does not have counts as 1. */
static void measured(void **state)
{
  SmoothEpisode e;
  PetscInt solves, fine, coarse;
  PetscReal same, small, large;

  (void)state;
  ok(SmoothEpisodeCreate(RandomStreamHashed(77, STREAM, QUICK), &e));
  assert_true(e.recurrence > 0 && e.reference.event[0].begin < e.reference.event[0].over);
  assert_true(e.reference.event[0].over < e.reference.event[1].begin && e.reference.event[1].over < e.end);
  run(&e, SMOOTH_REFERENCE_RTOL, &solves, &same);
  assert_true(same == 0);
  assert_int_equal(solves, e.reference.solves);
  run(&e, 3e-4, &fine, &small);
  run(&e, 3e-2, &coarse, &large);
  assert_true(coarse < fine && fine < solves);
  if (!(large > 10 * small && small > 0)) fail_msg("%g and %g", (double)large, (double)small);
  e.end = (PetscReal)0.5 * (e.reference.event[0].over + e.reference.event[1].begin); /* the second one is missed */
  run(&e, 3e-2, &coarse, &large);
  assert_true(large == 1);
  ok(SmoothEpisodeDestroy(&e));
}

SLIP_TESTS(measured)
