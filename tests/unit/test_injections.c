/* What steps of injections are trained by: the error of drawn faults under a pore pressure. */
#include "unit.h"
#include "injections/injections.h"
#include <math.h>

enum { STREAM = 98, CONSTANT = 3, WEAKENS = 4 }; /* of seeds, neither training's nor the benchmark's */

static void run(InjectionEpisode *e, PetscReal rtol, PetscInt *solves, PetscReal *error)
{
  InjectionErrors errors;
  PetscInt rejected;

  ok(InjectionEpisodeRun(e, NULL, 0, INJECTION_REFERENCE_TYPE, rtol, solves, &rejected, &errors, error));
  assert_true(rejected >= 0 && rejected < *solves);
  assert_true(errors.course >= 0 && errors.field >= 0 && errors.front >= 0);
  assert_true(*error == PetscMax(PetscMax(errors.course, errors.field), errors.front));
}

/* A run with the reference's tolerance is the reference; a loose one is worse than a tight one: cells begin within a step, so that the
   error goes at least with its length, the cubic root of the tolerance: 4.6 times for a hundred times the tolerance. */
static void measured(void **state)
{
  (void)state;
  for (PetscInt k = 0; k < 2; k++) {
    InjectionEpisode e;
    PetscInt solves, fine, coarse;
    PetscReal same, small, large;

    ok(InjectionEpisodeCreate(RandomStreamHashed(77, STREAM, k ? WEAKENS : CONSTANT), &e));
    assert_int_equal(e.weakens, k);
    run(&e, INJECTION_REFERENCE_RTOL, &solves, &same);
    assert_true(same == 0);
    assert_int_equal(solves, e.reference.solves);
    run(&e, 1e-4, &fine, &small);
    run(&e, 1e-2, &coarse, &large);
    assert_true(coarse < fine && fine < solves);
    if (!(large > 4.6 * small && small > 0)) fail_msg("%g and %g", (double)large, (double)small);
    ok(InjectionEpisodeDestroy(&e));
  }
}

/* A cell that begins in one of two runs alone counts as if it had begun a whole duration too late. */
static void begun(void **state)
{
  InjectionEpisode e;
  PetscInt solves, last = -1, count = 0;
  PetscReal error;

  (void)state;
  ok(InjectionEpisodeCreate(RandomStreamHashed(77, STREAM, CONSTANT), &e));
  for (PetscInt i = 0; i < e.n; i++) {
    assert_true((e.reference.slip[i] >= e.passed) == (e.reference.began[i] >= 0));
    assert_true(e.reference.began[i] <= e.end);
    if (e.reference.slip[i] > 2 * e.passed) last = i;
    if (e.reference.slip[i] >= 1.25 * e.passed) count++;
  }
  assert_true(last >= 0 && count > 2);
  e.reference.began[last] = -1;
  run(&e, INJECTION_REFERENCE_RTOL, &solves, &error);
  AssertNear(error, sqrt(1 / (double)(count - 1)), 1e-12);
  ok(InjectionEpisodeDestroy(&e));
}

/* A step of an hour after a day, in a run of ten days; before the first attempt there is none. */
static void observed(void **state)
{
  const SlipRunNumbers day = {.started = PETSC_TRUE, .dt = 3600, .time = 86400, .max_time = 864000};
  SlipRunNumbers endless = day, start = {.max_time = 864000};
  PetscInt component;
  const PetscInt share = SlipObservationFind("log_step_share", &component),
                 past = SlipObservationFind("log_step_past", &component);

  (void)state;
  endless.max_time = PETSC_MAX_REAL;
  AssertNear(SlipObservations[share].run(&day), log10(1 / 240.0), 1e-14);
  AssertNear(SlipObservations[past].run(&day), log10(1 / 24.0), 1e-14);
  assert_true(SlipObservations[share].run(&endless) == -9);
  assert_true(SlipObservations[share].run(&start) == -9 && SlipObservations[past].run(&start) == 0);
}

SLIP_TESTS(measured, begun, observed)
