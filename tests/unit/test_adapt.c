/* The classical controllers, attempt by attempt. */
#include "scripted.h"

static void heuristic(void **state)
{
  TS ts = start(TSADAPTHEURISTIC, "", 0.1);

  ok(TSSetFromOptions(ts));
  ok(run(ts, 8, heuristic_error));
  tried(heuristic_h);
  accepted("raaraaaa");
  ok(TSDestroy(&ts));
}

static void heuristic_again(void **state)
{
  /* E = 8 halves; rejected again, 0.9 comes on top, until the step is accepted. */
  const PetscReal error[] = {8, 8, 8, 1, 8, 1}, h[] = {0.1, 0.05, 0.0225, 0.010125, 0.010125, 0.0050625};
  TS ts = start(TSADAPTHEURISTIC, "", 0.1);

  ok(run(ts, 6, error));
  tried(h);
  accepted("rrrara");
  ok(TSDestroy(&ts));
}

static void heuristic_options(void **state)
{
  /* p = 1, q = 1/2. The step after the first is capped by dt_max; then a failure and a rejection by E = 4. */
  const PetscReal error[] = {1.0 / 25, FAIL, 4, 1}, below[] = {1e6};
  const PetscReal h[] = {0.1, 0.25, 0.2, 0.1};
  TS ts = start(TSADAPTHEURISTIC,
                "-ts_adapt_heuristic_growth 4 -ts_adapt_heuristic_failure_factor 0.8 "
                "-ts_adapt_dt_max 0.25 -ts_adapt_dt_min 0.01",
                0.1);

  script.order = 1;
  ok(TSSetFromOptions(ts));
  ok(run(ts, 4, error));
  tried(h);
  accepted("arra");
  ok(TSSetStepNumber(ts, 0));
  ok(TSSetTimeStep(ts, 0.1));
  fails(run(ts, 1, below), "below -ts_adapt_dt_min 0.01");
  ok(TSDestroy(&ts));
  ts = start(TSADAPTHEURISTIC, "-ts_adapt_heuristic_growth 0.5", 0.1);
  fails(TSSetFromOptions(ts), "-ts_adapt_heuristic_growth is 0.5");
  PetscOptionsClear(NULL);
}

static void pi_filter(void **state)
{
  /* H211b, b = 2, q = 1/3: r = (E_n E_(n-1))^(-1/6) (h_(n-1)/h_(n-2))^(-1/2). */
  const PetscReal error[] = {1.5, 0.9, 40, 1.2, 0.5};
  TS ts = start(TSADAPTPI, "-ts_adapt_pi_filter H211b2", 0.1);
  PetscReal h[5] = {0.1};

  ok(TSSetFromOptions(ts));
  ok(run(ts, 5, error));
  h[1] = h[0] * pow(1.5, -1.0 / 6); /* history at the start: 1 */
  h[2] = h[1] * pow(0.9 * 1.5, -1.0 / 6) / sqrt(h[1] / h[0]);
  h[3] = h[2] * pow(40 * 0.9, -1.0 / 6) / sqrt(h[2] / h[1]); /* 0.55: below 0.8, rejected, and the history stays */
  h[4] = h[3] * PetscMin(1.2, pow(1.2 * 0.9, -1.0 / 6) / sqrt(h[3] / h[1])); /* 1.34, capped */
  tried(h);
  accepted("aaraa");
  ok(TSDestroy(&ts));
}

static void pi_cap(void **state)
{
  /* The default filter: a step of error 0 grows by 1.2 and counts as the error that asks for just that,
     E = 1.2^(-g1/q) = 1.2^-12. */
  const PetscReal error[] = {0, 1, FAIL, 1};
  PetscReal h[4] = {0.1, 0.12};
  TS ts = start(TSADAPTPI, "", 0.1);

  ok(TSSetFromOptions(ts));
  ok(run(ts, 4, error));
  h[2] = PetscMin(1.2, pow(pow(1.2, -12), -1.0 / 12) / pow(1.2, 0.25)) * h[1];
  h[3] = 0.6 * h[2];
  tried(h);
  accepted("aara");
  ok(TSDestroy(&ts));
  ts = start(TSADAPTPI, "-ts_adapt_pi_ratio_min 1.8", 0.1);
  fails(TSSetFromOptions(ts), "-ts_adapt_pi_ratio_min is 1.8");
  PetscOptionsClear(NULL);
}

/* A named filter brings its own limits of the ratio, which an option after it replaces: what the default would reject
   is accepted, and what it would cap at 1.2 is not. */
static void pi_named(void **state)
{
  const PetscReal error[] = {20, 0, 0, 1};
  const SlipFilter f = SlipFilters[SLIP_NUM_FILTERS - 1];
  PetscReal h[4] = {0.1};

  for (int limited = 0; limited < 2; limited++) {
    TS ts = start(TSADAPTPI,
                  limited ? "-ts_adapt_pi_filter fault_history -ts_adapt_pi_ratio_max 5"
                          : "-ts_adapt_pi_filter fault_history",
                  0.1);

    ok(TSSetFromOptions(ts));
    ok(run(ts, 4, error));
    h[1] = h[0] * pow(20, -1 / (3 * f.g1));
    assert_true(h[1] < 0.8 * h[0]);
    h[2] = h[1] * (limited ? 5 : f.r_max);
    h[3] = h[2] * (limited ? 5 : f.r_max);
    tried(h);
    accepted("aaaa");
    ok(TSDestroy(&ts));
    PetscOptionsClear(NULL);
  }
}

/* PETSc's factors on the ratio of steps, and limits of it, hold for our types as for PETSc's own; without these options
   their own count, and the next type of the same object has PETSc's again. */
static void options_of_all(void **state)
{
  const PetscReal error[] = {1.0 / 8, 8, 1e-9, 1}; /* q = 1/3: ratios of 2, 1/2 and 1000 */
  const PetscReal half[] = {0.1, 0.1 * 1.5, 0.1 * 1.5 * 0.7, 0.1 * 1.5 * 0.7 * 1.5};
  PetscReal safe[] = {0.1, 0.1, 0.1 * 0.25,
                      0}; /* the last one capped, before the factor by heuristic, after it by pi */
  TSAdapt adapt;
  TS ts;

  for (int pi = 0; pi < 2; pi++) {
    const char *own = pi ? "-ts_adapt_pi_filter elementary -ts_adapt_pi_ratio_max 4" : "-ts_adapt_heuristic_growth 4";

    for (int clip = 0; clip < 2; clip++) {
      ts = start(pi ? TSADAPTPI : TSADAPTHEURISTIC, own, 0.1);
      ok(PetscOptionsInsertString(NULL, clip ? "-ts_adapt_clip 0.7,1.5" : "-ts_adapt_safety 0.5"));
      ok(TSSetFromOptions(ts));
      ok(run(ts, 4, error));
      safe[3] = safe[2] * (pi ? 0.5 * 4 : 4);
      tried(clip ? half : safe);
      accepted("araa");
      ok(TSGetAdapt(ts, &adapt));
      ok(TSAdaptSetType(adapt, TSADAPTBASIC));
      assert_true(adapt->clip[0] == (clip ? 0.7 : 0.1) && adapt->clip[1] == (clip ? 1.5 : 10));
      ok(TSDestroy(&ts));
      PetscOptionsClear(NULL);
    }
  }
}

/* PETSc's basic is what it is without dsp before: dsp has a factor of refused steps of its own, and leaves it. */
static void after_dsp(void **state)
{
  PetscReal alone[2], after[2];
  TSAdapt adapt;

  ok(TSAdaptCreate(PETSC_COMM_SELF, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTBASIC));
  ok(TSAdaptGetSafety(adapt, &alone[0], &alone[1]));
  for (int k = 0; k < 2; k++) {
    ok(SlipAdaptSetController(adapt, "dsp:PI42"));
    ok(SlipAdaptSetController(adapt, TSADAPTDSP));
    ok(k ? SlipAdaptSetController(adapt, TSADAPTBASIC) : TSAdaptSetType(adapt, TSADAPTBASIC));
    ok(TSAdaptGetSafety(adapt, &after[0], &after[1]));
    assert_true(after[0] == alone[0] && after[1] == alone[1]);
  }
  ok(TSAdaptDestroy(&adapt));
}

static PetscErrorCode Root(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  const PetscReal *a = VecRead(y);
  PetscReal *b;

  PetscCall(VecGetArrayWrite(f, &b));
  b[0] = -PetscSqrtReal(a[0]);
  b[1] = -a[1];
  return VecRestoreArrayWrite(f, &b);
}

/* A state without a rate is no state that a step may end in, also where the largest error counts, in which PETSc
   loses what is no number. */
static void no_number(void **state)
{
  const char *const types[] = {TSADAPTPI, TSADAPTHEURISTIC};

  for (int k = 0; k < 2; k++) {
    TSAdapt adapt;
    Vec y;
    TS ts;

    ok(VecCreateSeq(PETSC_COMM_SELF, 2, &y));
    ok(VecSet(y, 1));
    ts = MakeTS(TSRK, 0.1, 4);
    ok(TSSetRHSFunction(ts, NULL, Root, NULL));
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptSetType(adapt, types[k]));
    ok(SlipAdaptSetNorm(adapt, NORM_INFINITY));
    fails(TSSolve(ts, y), "is not a number");
    ObjectsDestroy(&ts, &y);
  }
}

SLIP_TESTS_WITH(Register, NULL, options_of_all, heuristic, heuristic_again, heuristic_options, pi_filter, pi_cap,
                pi_named, after_dsp, no_number)
