/* Tuning a digital filter: runs under one, and what the tuning's numbers mean. */
#include "unit.h"
#include "problems/episodes.h"
#include "tuning/filter.h"
#include <math.h>
#include <slipstep.h>

static PetscErrorCode follow_filter(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  if (attempt->accepted) PetscCall(EpisodeFollow((Episode *)ctx, attempt->time + attempt->dt, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A run under a filter without objects against TSADAPTPI. Of an error estimate 12 binary digits are kept, so that both
   take the same steps, and of the errors the rounding of the solver is left, as in other runs on plain arrays. */
static void plain_filter(void **state)
{
  const SlipFilter filter = {"", 2.5, 6, 0.15, 0.5, 3};

  (void)state;
  for (uint64_t seed = 21; seed < 27; seed++) {
    PetscInt attempts, accepted, solves, newton, linear;
    const PetscReal rtol = seed % 2 ? 1e-2 : 1e-1;
    EpisodeResult a, l;
    TSAdapt adapt;
    Episode *e;
    TS ts;

    ok(EpisodeCreate(NULL, seed, seed % 3 ? 1 + (PetscInt)(seed % 3) : 1, &e));
    ok(EpisodeRunFilter(e, &filter, rtol, &a));
    ok(EpisodeRewind(e, 1e-2)); /* the rest of the episode follows the run of another TS */
    ok(PetscOptionsInsertString(NULL, "-ts_adapt_pi_g1 2.5 -ts_adapt_pi_g2 6 -ts_adapt_pi_kappa 0.15 "
                                      "-ts_adapt_pi_ratio_min 0.5 -ts_adapt_pi_ratio_max 3 -ts_adapt_type pi"));
    ok(TSCreate(PETSC_COMM_SELF, &ts));
    ok(SlipFaultConfigureTS(e->fault, ts));
    ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, rtol, NULL));
    ok(TSBatheMonitorSet(ts, follow_filter, e, NULL));
    ok(TSBatheSetStageError(ts, 0)); /* as the loops on arrays, to rounding */
    ok(TSSetMaxTime(ts, e->tmax));
    ok(TSSetFromOptions(ts));
    ok(TSGetAdapt(ts, &adapt));
    ok(TSSolve(ts, e->w));
    ok(TSBatheGetTotals(ts, &attempts, &accepted, &solves, &newton, &linear));
    EpisodeConclude(e, solves, accepted, &l);
    print_message("%d cells: %d and %d solves, %d failures, error %.3e, difference %.1e\n", (int)e->plain.n,
                  (int)a.solves, (int)l.solves, (int)a.failures, l.error, fabs(a.error - l.error));
    assert_int_equal(a.solves, l.solves);
    assert_int_equal(a.failures, l.failures);
    assert_true(fabs(a.error - l.error) < 1e-6 && a.done == 1 && l.done == 1);
    ok(TSDestroy(&ts));
    ok(EpisodeDestroy((void **)&e));
    ok(PetscOptionsClear(NULL));
  }
}

/* The numbers of a tuning are those of a filter, any seven of them; the start is H211b4 with a wider cap. */
static void filter_numbers(void **state)
{
  const double any[FILTER_PARAMETERS] = {0.5, -0.2, 0.3, -1, 2, -0.7, 0.4};
  double start[FILTER_PARAMETERS];
  TunedFilter f;

  (void)state;
  FilterStart(start);
  FilterOfNumbers(start, &f);
  assert_true(fabs(f.filter.g1 - 4) < 1e-12 && fabs(f.filter.g2 - 4) < 1e-12 && f.filter.kappa == 0.25);
  assert_true(fabs(f.filter.r_min - 0.8) < 1e-12 && fabs(f.filter.r_max - 2) < 1e-12 && f.factor == 1 && f.power == 1);
  FilterOfNumbers(any, &f);
  assert_true(fabs(f.filter.g1 - exp(-0.5)) < 1e-12 && fabs(f.filter.g2 + 5) < 1e-12 && f.filter.kappa == 0.3);
  assert_true(fabs(f.filter.r_min - 1 / (1 + exp(1))) < 1e-12 && fabs(f.filter.r_max - 1 - exp(2)) < 1e-12);
  assert_true(fabs(f.factor - exp(-0.7)) < 1e-12 && fabs(f.power - exp(0.4)) < 1e-12);
}

/* The shipped setting is a row of the table: its limits of the ratio come with it, and options after it still count. */
static void named(void **state)
{
  const SlipFilter *last = &SlipFilters[SLIP_NUM_FILTERS - 1];

  (void)state;
  assert_string_equal(last->name, "fault_history");
  assert_true(last->r_min < 0.8 && last->r_max > 1.2);
  for (int i = 0; i < SLIP_NUM_FILTERS - 1; i++)
    assert_true(fabs(SlipFilters[i].r_min - 0.8) < 1e-12 && fabs(SlipFilters[i].r_max - 1.2) < 1e-12);
}

SLIP_TESTS(plain_filter, filter_numbers, named)
