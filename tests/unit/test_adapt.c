/* The controllers on a TS without numerics (y' = 0): the test says what each attempt's error is and whether it
   converged, and expects the exact sequence of steps. */
#include "unit.h"
#include <petsc/private/tsimpl.h>
#include <math.h>

/* A handful of pow() and products of numbers near 1: a few hundred roundings of 1.1e-16 at most. */
#define near(a, b) assert_true(fabs((a) - (b)) <= 1e-13 * (1 + fabs(b)))

/* ---- the TS: attempts as scripted ---- */

#define FAIL -2.0 /* in place of an error: the attempt does not converge */

static struct {
  const PetscReal *error; /* of attempt 0, 1, ... */
  int n, at;
  PetscInt order;
  PetscReal tried[64]; /* step of each attempt [s] */
  PetscBool accepted[64], needs_error;
  SlipAttempt last;
  PetscReal energy;      /* what the problem supplies; NaN: nothing */
  const char *untrained; /* what it says of itself */
  int asked;             /* how often */
} script;

static PetscErrorCode EvaluateWLTE_Scripted(TS ts, NormType norm, PetscInt *order, PetscReal *wlte)
{
  PetscFunctionBegin;
  (void)ts, (void)norm;
  *order = script.order + 1; /* the power of h in the estimate of a method of that order */
  *wlte = script.last.error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GetLastAttempt_Scripted(TS ts, SlipAttempt *attempt)
{
  PetscFunctionBegin;
  (void)ts;
  *attempt = script.last;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Find_Scripted(TS ts, const char name[], PetscInt *row)
{
  PetscFunctionBegin;
  (void)ts;
  *row = strcmp(name, "energy") || isnan(script.energy) ? -1 : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Observe_Scripted(TS ts, PetscInt n, const PetscInt row[], PetscReal value[])
{
  PetscFunctionBegin;
  (void)ts;
  for (PetscInt i = 0; i < n; i++) {
    assert_int_equal(0, (int)row[i]);
    value[i] = script.energy;
    script.asked++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TimeScale_Scripted(TS ts, PetscReal *tstar)
{
  PetscFunctionBegin;
  (void)ts;
  *tstar = 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Untrained_Scripted(TS ts, const char **why)
{
  PetscFunctionBegin;
  (void)ts;
  *why = script.untrained;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One attempt as TSBATHE makes it; ends the run when the script does. */
static PetscErrorCode Attempt(TS ts, PetscBool *accept)
{
  const PetscReal E = script.error[script.at];
  PetscErrorCode (*after)(TSAdapt, TS, PetscReal, PetscReal *);
  PetscReal next = ts->time_step;

  PetscFunctionBegin;
  *accept = PETSC_FALSE;
  script.tried[script.at] = ts->time_step;
  script.last = (SlipAttempt){.step = ts->steps, .time = ts->ptime, .dt = ts->time_step, .error = E, .solves = 1};
  script.last.residual = E == FAIL ? 2 : 0.004;
  script.last.converged = E == FAIL ? PETSC_FALSE : PETSC_TRUE;
  if (E == FAIL) {
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseAfterFailure_C", &after));
    PetscCall((*after)(ts->adapt, ts, ts->time_step, &next));
  } else {
    PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, NULL, &next, accept));
  }
  script.accepted[script.at++] = *accept;
  if (*accept) ts->ptime += ts->time_step;
  ts->time_step = next;
  if (script.at == script.n) ts->reason = TS_CONVERGED_USER;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Step_Scripted(TS ts)
{
  PetscErrorCode (*first)(TSAdapt, TS, PetscReal *);
  PetscErrorCode (*needs)(TSAdapt, PetscBool *);
  PetscBool accept = PETSC_FALSE;

  PetscFunctionBegin;
  if (!script.at) {
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseFirst_C", &first));
    if (first) PetscCall((*first)(ts->adapt, ts, &ts->time_step));
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptNeedsError_C", &needs));
    script.needs_error = PETSC_TRUE;
    if (needs) PetscCall((*needs)(ts->adapt, &script.needs_error));
  }
  while (!accept && !ts->reason) PetscCall(Attempt(ts, &accept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipProblemOps Scripted = {.time_scale = TimeScale_Scripted,
                                        .untrained = Untrained_Scripted,
                                        .find = Find_Scripted,
                                        .observe = Observe_Scripted};

static PetscErrorCode Create_Scripted(TS ts)
{
  PetscFunctionBegin;
  ts->ops->step = Step_Scripted;
  ts->ops->evaluatewlte = EvaluateWLTE_Scripted;
  ts->usessnes = PETSC_FALSE;
  ts->default_adapt_type = TSADAPTNONE;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "TSBatheGetLastAttempt_C", GetLastAttempt_Scripted));
  PetscCall(TSSetSlipProblem(ts, &Scripted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Rhs(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  PetscFunctionBegin;
  (void)ts, (void)t, (void)y, (void)ctx;
  PetscCall(VecZeroEntries(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A TS of three components (2, -4, 1), T* = 2 s, 100 s, first step h. */
static TS start(const char *type, const char *options, PetscReal h)
{
  TS ts;
  Vec y;
  TSAdapt adapt;

  memset(&script, 0, sizeof(script));
  script.order = 2;
  script.energy = NAN;
  ok(PetscOptionsClear(NULL));
  ok(PetscOptionsInsertString(NULL, options));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, "scripted"));
  ok(TSSetRHSFunction(ts, NULL, Rhs, NULL));
  ok(VecCreateSeq(PETSC_COMM_SELF, 3, &y));
  ok(VecSetValue(y, 0, 2, INSERT_VALUES));
  ok(VecSetValue(y, 1, -4, INSERT_VALUES));
  ok(VecSetValue(y, 2, 1, INSERT_VALUES));
  ok(VecAssemblyBegin(y));
  ok(VecAssemblyEnd(y));
  ok(TSSetSolution(ts, y));
  ok(VecDestroy(&y));
  ok(TSSetTimeStep(ts, h));
  ok(TSSetMaxTime(ts, 100));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, type));
  return ts;
}

static PetscErrorCode run(TS ts, int n, const PetscReal error[])
{
  script.error = error;
  script.n = n;
  script.at = 0;
  return TSSolve(ts, NULL);
}

static void tried(const PetscReal h[])
{
  for (int i = 0; i < script.n; i++)
    if (fabs(script.tried[i] - h[i]) > 1e-13 * fabs(h[i])) /* as in near() */
      fail_msg("attempt %d: step %.17g, expected %.17g", i, script.tried[i], h[i]);
}

static void accepted(const char *pattern)
{
  for (int i = 0; i < script.n; i++) assert_int_equal(pattern[i] == 'a', script.accepted[i]);
}

/* q = 1/3: E = 8 halves, E = 1/27 would triple but 2 is the cap, E = 1/8 doubles, E = 0 grows by the cap. */
static const PetscReal heuristic_error[] = {8, 1, 1.0 / 27, FAIL, 1.0 / 8, 0, 0.5, 1};
static const PetscReal heuristic_h[] = {0.1, 0.05, 0.05, 0.1, 0.06, 0.12, 0.24, 0.30238105197476955};

static void heuristic(void **state)
{
  TS ts = start(TSADAPTHEURISTIC, "", 0.1);

  (void)state;
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

  (void)state;
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

  (void)state;
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
  fails(TSSetFromOptions(ts), "-ts_adapt_heuristic_growth is 0.5; expected > 1");
  PetscOptionsClear(NULL);
}

static void pi_filter(void **state)
{
  /* H211b, b = 2, q = 1/3: r = (E_n E_(n-1))^(-1/6) (h_(n-1)/h_(n-2))^(-1/2). */
  const PetscReal error[] = {1.5, 0.9, 40, 1.2, 0.5};
  TS ts = start(TSADAPTPI, "-ts_adapt_pi_filter H211b2", 0.1);
  PetscReal h[5] = {0.1};

  (void)state;
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

  (void)state;
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

/* ---- rl ---- */

/* h = 0.1 + (tanh(w.obs + b) + 1)/2 * (10.1 - 0.1) */
static SlipPolicy policy(PetscInt n, const char *const names[], const PetscReal w[], PetscReal b)
{
  const PetscReal one[8] = {1, 1, 1, 1, 1, 1, 1, 1}, zero[8] = {0};
  SlipPolicy p;

  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  ok(SlipPolicySetObservations(p, n, names, one, zero));
  ok(SlipPolicyAddLayer(p, n, 1, w, &b, SLIP_ACTIVATION_LINEAR));
  ok(SlipPolicySetAction(p, -1, 1, 0.1, "s", 10.1, "s", PETSC_FALSE));
  return p;
}

static PetscReal chosen(PetscReal y)
{
  return 0.1 + 5 * (tanh(y) + 1);
}

static void rl_observations(void **state)
{
  const char *const names[] = {"residual", "converged", "accuracy", "step"};
  const PetscReal w[] = {0.3, -0.7, 1.1, 0.5};
  const PetscReal error[] = {4, FAIL, 0.25, 1};
  SlipPolicy p = policy(4, names, w, 0.2), q;
  TS ts = start(TSADAPTRL, "", 77);
  PetscReal h[4];
  TSAdapt adapt;

  (void)state;
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptRLSetPolicy(adapt, p));
  ok(TSAdaptRLGetPolicy(adapt, &q));
  assert_ptr_equal(p, q);
  ok(SlipPolicyDestroy(&p));
  ok(TSSetFromOptions(ts));
  ok(run(ts, 4, error));
  h[0] = chosen(0.2 + 0.3 * 0.5 + 0.5 * -0.5);                                   /* the start */
  h[1] = chosen(0.2 + 0.3 * 0.001 - 0.7 + 1.1 / 5 + 0.5 * (h[0] - 0.1) / 10);    /* converged with E = 4 */
  h[2] = chosen(0.2 + 0.3 * 0.5 - 0.5 * (h[1] - 0.1) / 10);                      /* failed */
  h[3] = chosen(0.2 + 0.3 * 0.001 - 0.7 + 1.1 / 1.25 + 0.5 * (h[2] - 0.1) / 10); /* converged with E = 0.25 */
  tried(h);
  accepted("araa");
  assert_true(script.needs_error);
  ok(TSDestroy(&ts));
}

static void rl_fallbacks(void **state)
{
  /* The state (2, -4, 1) never moves: energy 1, velocity (-1/3)/4, state_1 1; with the problem's own energy, that. */
  const char *const names[] = {"energy", "velocity", "state_1", "log_step", "time_fraction"};
  const PetscReal w[] = {0.1, 0.2, 0.3, 0.4, 0.5}, error[] = {-1, -1};
  PetscReal h[2], base = 0.2 * (-1.0 / 3) / 4 + 0.3;
  TSAdapt adapt;

  (void)state;
  for (int own = 0; own < 2; own++) {
    SlipPolicy p = policy(5, names, w, 0);
    TS ts = start(TSADAPTRL, "", 77);

    if (own) script.energy = -3;
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptRLSetPolicy(adapt, p));
    ok(SlipPolicyDestroy(&p));
    ok(run(ts, 2, error));
    h[0] = chosen(0.1 * (own ? -3 : 1) + base + 0.4 * log10(5.1 / 2));
    h[1] = chosen(0.1 * (own ? -3 : 1) + base + 0.4 * log10(h[0] / 2) + 0.5 * h[0] / 100);
    tried(h);
    assert_false(script.needs_error); /* it observes no error, so none is computed */
    ok(TSDestroy(&ts));
  }
}

static void rl_guard_rail(void **state)
{
  /* A policy that always answers 5.1 s: halved after 3 failures until a step converges, then it resumes. */
  const char *const names[] = {"energy"};
  const PetscReal w[] = {0}, error[] = {FAIL, FAIL, FAIL, FAIL, FAIL, 1, 1, FAIL, 1};
  const PetscReal h[] = {5.1, 5.1, 5.1, 2.55, 1.275, 0.6375, 5.1, 5.1, 5.1};
  SlipPolicy p = policy(1, names, w, 0);
  TS ts = start(TSADAPTRL, "", 77);
  TSAdapt adapt;

  (void)state;
  script.energy = 1;
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptRLSetPolicy(adapt, p));
  ok(SlipPolicyDestroy(&p));
  ok(run(ts, 9, error));
  tried(h);
  accepted("rrrrraara");
  assert_int_equal(4, script.asked); /* the start and three accepted steps: a failed attempt leaves the state alone */
  ok(TSDestroy(&ts));
}

static void rl_ceiling(void **state)
{
  /* E/ceiling = 8 halves; 1.1 shrinks by the smallest amount, to 0.9; 1e9 by the largest, to 0.1; 100 itself passes. */
  const char *const names[] = {"energy"};
  const PetscReal w[] = {0}, error[] = {800, 110, 1e11, 100, 99};
  const PetscReal h[] = {5.1, 2.55, 2.55 * 0.9, 2.55 * 0.9 * 0.1, 5.1};
  SlipPolicy p = policy(1, names, w, 0);
  TS ts = start(TSADAPTRL, "-ts_adapt_rl_error_ceiling 100", 77);
  TSAdapt adapt;

  (void)state;
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptRLSetPolicy(adapt, p));
  ok(SlipPolicyDestroy(&p));
  ok(TSSetFromOptions(ts));
  ok(run(ts, 5, error));
  tried(h);
  accepted("rrraa");
  assert_true(script.needs_error);
  ok(TSDestroy(&ts));
}

static struct {
  int calls, guarded, without_last;
  PetscReal obs[8][2];
  PetscBool converged[8], accepted[8];
} seen;

static PetscErrorCode Actor(TSAdapt adapt, TS ts, PetscInt n, const PetscReal obs[], const SlipAttempt *last,
                            PetscBool guarded, PetscReal *h, void *ctx)
{
  PetscFunctionBegin;
  (void)adapt, (void)ts, (void)n;
  seen.guarded += guarded;
  seen.without_last += !last;
  memcpy(seen.obs[seen.calls], obs, sizeof(seen.obs[0]));
  seen.converged[seen.calls] = last ? last->converged : PETSC_FALSE;
  seen.accepted[seen.calls] = last ? last->accepted : PETSC_FALSE;
  *h = *(PetscReal *)ctx + seen.calls++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void rl_actor(void **state)
{
  const char *const names[] = {"step", "converged"};
  const PetscReal error[] = {1, FAIL, FAIL, 1}, h[] = {1, 2, 3, 1.5};
  TS ts = start(TSADAPTRL, "-ts_adapt_rl_max_failures 2", 77);
  PetscReal base = 1;
  TSAdapt adapt;

  (void)state;
  memset(&seen, 0, sizeof(seen));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptRLSetActor(adapt, 2, names, 0, 4, Actor, &base));
  ok(TSSetFromOptions(ts));
  ok(run(ts, 4, error));
  tried(h);                        /* the second failure in a row halves 3 s */
  assert_int_equal(5, seen.calls); /* before the first step and after each of four attempts */
  assert_int_equal(1, seen.without_last);
  assert_int_equal(1, seen.guarded);
  near(seen.obs[0][0], -0.5);
  near(seen.obs[1][0], 0.25);
  near(seen.obs[2][0], -0.5);
  near(seen.obs[3][0], -0.75);
  near(seen.obs[4][0], 0.375);
  assert_true(seen.converged[1] && seen.accepted[1] && !seen.converged[2] && !seen.accepted[3] && seen.accepted[4]);
  assert_true(script.needs_error); /* rewards use it */
  ok(TSDestroy(&ts));
}

static struct {
  char text[1024];
  int lines;
} printed;

/* PetscVFPrintf: keeps what is printed */
static PetscErrorCode keep_printed(FILE *out, const char format[], va_list args)
{
  const size_t n = strlen(printed.text);

  (void)out;
  vsnprintf(printed.text + n, sizeof(printed.text) - n, format, args);
  printed.lines++;
  return 0;
}

/* The first decision outside the training range is said, once, with the observation that is furthest off in widths of
   its range: at the start time_fraction = 0 is half a width below [1, 3], log_step =
   log10(5.1 s/2 s) = 0.41, from the middle of the bounds of the step, sixteen below [2, 2.1]. Every decision counts. Inside the range nothing is said. */
static void rl_outside(void **state)
{
  const char *const names[] = {"time_fraction", "log_step", "failures"};
  const PetscReal w[] = {0, 0, 0}, error[] = {1, 1}, wide[2][3] = {{0, -3, 0}, {2, 3, 0}},
                  narrow[2][3] = {{1, 2, 0}, {3, 2.1, 0}};
  PetscErrorCode (*print)(FILE *, const char[], va_list) = PetscVFPrintf;

  (void)state;
  for (int k = 0; k < 2; k++) {
    TS ts = start(TSADAPTRL, "", 77);
    SlipPolicy p = policy(3, names, w, 0);
    PetscInt outside, decisions;
    TSAdapt adapt;

    ok(SlipPolicySetRange(p, k ? narrow[0] : wide[0], k ? narrow[1] : wide[1]));
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptRLSetPolicy(adapt, p));
    ok(SlipPolicyDestroy(&p));
    ok(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
    memset(&printed, 0, sizeof(printed));
    PetscVFPrintf = keep_printed;
    ok(run(ts, 2, error));
    PetscVFPrintf = print;
    ok(TSAdaptRLGetCounts(adapt, &decisions, &outside, NULL, NULL));
    assert_true(decisions >= 2);
    assert_int_equal(k ? (int)decisions : 0, (int)outside);
    assert_int_equal(k, printed.lines);
    if (k) {
      assert_non_null(strstr(printed.text, "2 of 3 observations are outside the training range of policy (in memory)"));
      assert_non_null(strstr(printed.text, "most of all log_step = "));
      assert_non_null(strstr(printed.text, "in training 2 to 2.1 (said once"));
    }
    ok(TSDestroy(&ts));
  }
}

/* A policy that always answers 5.1 s and was only trained on attempts that converge: decisions outside its range are
   those at the start and after a failure. Two in a row are nothing, the third hands over, and what follows is the
   heuristic's. */
static void rl_handover(void **state)
{
  const char *const names[] = {"converged"};
  const PetscReal w[] = {0}, low[] = {0.9}, high[] = {1};
  const PetscReal never[] = {FAIL, 1, FAIL, FAIL, 1, 8}, after[] = {FAIL, FAIL, 8, 1.0 / 27, 1.0 / 8, 1};
  const PetscReal fixed[] = {5.1, 5.1, 5.1, 5.1, 5.1, 5.1}, halved[] = {5.1, 5.1, 3.06, 1.53, 3.06, 6.12};
  PetscErrorCode (*print)(FILE *, const char[], va_list) = PetscVFPrintf;

  (void)state;
  for (int k = 0; k < 3; k++) {
    TS ts = start(TSADAPTRL, k == 2 ? "-ts_adapt_rl_strict" : "", 77);
    SlipPolicy p = policy(1, names, w, 0);
    PetscReal time;
    PetscBool handed;
    TSAdapt adapt;

    ok(SlipPolicySetRange(p, low, high));
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptRLSetPolicy(adapt, p));
    ok(SlipPolicyDestroy(&p));
    ok(TSSetFromOptions(ts));
    memset(&printed, 0, sizeof(printed));
    PetscVFPrintf = keep_printed;
    ok(run(ts, 6, k == 1 ? after : never));
    PetscVFPrintf = print;
    tried(k == 1 ? halved : fixed);
    accepted(k == 1 ? "rrraaa" : "rarraa");
    ok(TSAdaptRLGetHandover(adapt, &handed, &time));
    assert_int_equal(k == 1, handed);
    assert_int_equal(k == 1, strstr(printed.text, "rl hands the run over to heuristic, because its "
                                                  "observations stay outside the policy's training range") != NULL);
    assert_int_equal(k == 1 ? 2 : 1, printed.lines);
    assert_true(time == 0);
    ok(TSDestroy(&ts));
  }
}

/* A problem that no policy was trained for is the heuristic's from the first step on, in a second solve too, where it
   is not said again; and the policy's when that is strict. */
static void rl_untrained(void **state)
{
  const char *const names[] = {"converged"};
  const PetscReal w[] = {0}, fixed[] = {5.1, 5.1, 5.1}, growth[] = {0.1, 0.4, 0.08}, small[] = {0, FAIL, 1};
  PetscErrorCode (*print)(FILE *, const char[], va_list) = PetscVFPrintf;

  (void)state;
  for (int k = 0; k < 3; k++) {
    const char *const options[] = {"", "-ts_adapt_rl_strict",
                                   "-ts_adapt_heuristic_growth 4 -ts_adapt_heuristic_failure_factor 0.2"};
    TS ts = start(TSADAPTRL, options[k], 0.1);
    SlipPolicy p = policy(1, names, w, 0);
    TSAdapt adapt;

    script.untrained = "it is new";
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptRLSetPolicy(adapt, p));
    ok(SlipPolicyDestroy(&p));
    ok(TSSetFromOptions(ts));
    memset(&printed, 0, sizeof(printed));
    PetscVFPrintf = keep_printed;
    for (int again = 0; again < 2 && !k; again++) {
      ok(run(ts, 8, heuristic_error));
      tried(heuristic_h);
      accepted("raaraaaa");
      assert_true(script.needs_error);
      ok(TSSetStepNumber(ts, 0));
      ok(TSSetTime(ts, 0));
      ok(TSSetTimeStep(ts, 0.1));
    }
    if (k) {
      ok(run(ts, 3, small));
      tried(k == 1 ? fixed : growth);
    }
    PetscVFPrintf = print;
    assert_int_equal(k != 1, printed.lines);
    if (k != 1) assert_non_null(strstr(printed.text, "because it is new (-ts_adapt_rl_strict keeps the policy)"));
    ok(TSDestroy(&ts));
  }
}

static void rl_errors(void **state)
{
  const char *const unknown[] = {"energy", "temperature"}, *const accuracy[] = {"accuracy"}, *const far[] = {"state_3"};
  const char *const *const names[] = {unknown, accuracy, far};
  const char *const want[] = {"entry 1 of /observation/names is \"temperature\"",
                              "-ts_adapt_type rl needs an error estimate", "state_3 of a state with 3 components"};
  const PetscReal w[] = {0, 0}, error[] = {-1, -1};
  TS ts = start(TSADAPTRL, "", 77);

  (void)state;
  fails(run(ts, 1, error), "-ts_adapt_rl_policy <file.h5>");
  for (int k = 0; k < 3; k++) {
    SlipPolicy p = policy(k ? 1 : 2, names[k], w, 0);
    TSAdapt adapt;

    ts = start(TSADAPTRL, "", 77);
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptRLSetPolicy(adapt, p));
    ok(SlipPolicyDestroy(&p));
    fails(run(ts, 2, error), want[k]);
  }
  ts = start(TSADAPTRL, "-ts_adapt_rl_policy no_such_policy.h5", 77);
  fails(TSSetFromOptions(ts), "no_such_policy.h5");
  ts = start(TSADAPTRL, "-ts_adapt_rl_max_failures 0", 77);
  fails(TSSetFromOptions(ts), "-ts_adapt_rl_max_failures is 0");
  PetscOptionsClear(NULL);
}

static int Register(void **state)
{
  (void)state;
  return (int)TSRegister("scripted", Create_Scripted);
}

SLIP_TESTS_WITH(Register, NULL, heuristic, heuristic_again, heuristic_options, pi_filter, pi_cap, rl_observations,
                rl_fallbacks, rl_guard_rail, rl_ceiling, rl_actor, rl_errors, rl_outside, rl_handover, rl_untrained)
