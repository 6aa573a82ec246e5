/* What implicit steps through cycles of rate-and-state faults are measured by: the error of drawn faults. */
#include "unit.h"
#include "runs/runs.h"

enum { STREAM = 98, QUICK = 0 }; /* of seeds, neither training's nor the benchmark's; one of a line of cells */

static PetscInt run(RunEpisode *e, PetscReal rtol, PetscReal *error)
{
  EpisodeResult r;

  ok(RunEpisodeRun(e, NULL, TSADAPTDSP, rtol, &r));
  assert_true(r.done == 1 && r.failures >= 0 && r.failures < r.solves);
  *error = r.error;
  assert_true(*error ==
              PetscMax(r.errors[SLIP_ERROR_SHIFT], PetscMax(r.errors[SLIP_ERROR_FIELD], r.errors[SLIP_ERROR_FINAL])));
  return r.solves;
}

/* A run with the reference's tolerance is the reference. A loose one is worse than a tight one: errors of a method of
   second order go with the power two thirds of the tolerance, 21 times for a hundred times the tolerance, of which half
   is asked for. An event that the reference does not have counts as 1. */
static void measured(void **state)
{
  PetscReal same, small, large;
  const RunResult *reference;
  PetscInt fine, coarse;
  RunEpisode *e;

  (void)state;
  ok(RunEpisodeCreate(&RunSmooth, NULL, 1, RandomStreamHashed(77, STREAM, QUICK), &e));
  reference = &e->reference;
  assert_true(e->span > 0 && reference->begin[0] < reference->over[0]);
  assert_true(reference->over[0] < reference->begin[1] && reference->over[1] < e->end);
  assert_int_equal(run(e, 1e-5, &same), reference->solves); /* as the reference's */
  assert_true(same == 0);
  fine = run(e, 3e-4, &small);
  coarse = run(e, 3e-2, &large);
  assert_true(coarse < fine && fine < reference->solves);
  if (!(large > 10 * small && small > 0)) fail_msg("%g and %g", (double)large, (double)small);
  e->end = (PetscReal)0.5 * (reference->over[0] + reference->begin[1]); /* the second one is missed */
  run(e, 3e-2, &large);
  assert_true(large == 1);
  ok(RunEpisodeDestroy(&e));
}

SLIP_TESTS(measured)
