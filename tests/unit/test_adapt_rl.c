/* The controller rl, attempt by attempt: what its policy sees and decides, its guard rails, and when it hands over. */
#include "scripted.h"

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

/* The controller of ts, which takes the policy over */
static TSAdapt choose_by(TS ts, SlipPolicy p)
{
  TSAdapt adapt;

  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptRLSetPolicy(adapt, p));
  ok(SlipPolicyDestroy(&p));
  return adapt;
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

  for (int own = 0; own < 2; own++) {
    SlipPolicy p = policy(5, names, w, 0);
    TS ts = start(TSADAPTRL, "", 77);

    if (own) script.energy = -3;
    choose_by(ts, p);
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

  script.energy = 1;
  choose_by(ts, p);
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

  choose_by(ts, p);
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
  seen.guarded += guarded;
  seen.without_last += !last;
  memcpy(seen.obs[seen.calls], obs, sizeof(seen.obs[0]));
  seen.converged[seen.calls] = last ? last->converged : PETSC_FALSE;
  seen.accepted[seen.calls] = last ? last->accepted : PETSC_FALSE;
  *h = *(PetscReal *)ctx + seen.calls++;
  return PETSC_SUCCESS;
}

static void rl_actor(void **state)
{
  const char *const names[] = {"step", "converged"};
  const PetscReal error[] = {1, FAIL, FAIL, 1}, h[] = {1, 2, 3, 1.5};
  TS ts = start(TSADAPTRL, "-ts_adapt_rl_max_failures 2", 77);
  PetscReal base = 1;
  TSAdapt adapt;

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

  vsnprintf(printed.text + n, sizeof(printed.text) - n, format, args);
  printed.lines++;
  return 0;
}

/* The first decision outside the training range is said, once, with the observation that is furthest off in widths of
   its range: at the start time_fraction = 0 is half a width below [1, 3], log_step = log10(5.1 s/2 s) = 0.41, from the
   middle of the bounds of the step, sixteen below [2, 2.1]. Every decision counts. Inside the range nothing is said. */
static void rl_outside(void **state)
{
  const char *const names[] = {"time_fraction", "log_step", "failures"};
  const PetscReal w[] = {0, 0, 0}, error[] = {1, 1}, wide[2][3] = {{0, -3, 0}, {2, 3, 0}},
                  narrow[2][3] = {{1, 2, 0}, {3, 2.1, 0}};
  PetscErrorCode (*print)(FILE *, const char[], va_list) = PetscVFPrintf;

  for (int k = 0; k < 2; k++) {
    TS ts = start(TSADAPTRL, "", 77);
    SlipPolicy p = policy(3, names, w, 0);
    PetscInt outside, decisions;
    TSAdapt adapt;

    ok(SlipPolicySetRange(p, k ? narrow[0] : wide[0], k ? narrow[1] : wide[1]));
    adapt = choose_by(ts, p);
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
      assert_non_null(strstr(printed.text, "in training 2 to 2.1"));
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
  const PetscReal fixed[] = {5.1, 5.1, 5.1, 5.1, 5.1, 5.1}, halved[] = {5.1, 5.1, 3.06, 1.53, 3.06, 6.12},
                  bounded[] = {5.1, 5.1, 3.06, 1.53, 3.06, 6};
  PetscErrorCode (*print)(FILE *, const char[], va_list) = PetscVFPrintf;

  for (int k = 0; k < 5; k++) { /* 3, 4: the bounds of steps go on */
    const PetscBool over = k % 2 ? PETSC_TRUE : PETSC_FALSE;
    TS ts = start(TSADAPTRL,
                  k == 2   ? "-ts_adapt_rl_strict"
                  : k >= 3 ? k == 4 ? "-ts_adapt_dt_min 2" : "-ts_adapt_dt_max 6"
                           : "",
                  77);
    SlipPolicy p = policy(1, names, w, 0);
    PetscReal time;
    PetscBool handed;
    TSAdapt adapt;

    ok(SlipPolicySetRange(p, low, high));
    adapt = choose_by(ts, p);
    ok(TSSetFromOptions(ts));
    memset(&printed, 0, sizeof(printed));
    PetscVFPrintf = keep_printed;
    if (k == 4)
      fails(run(ts, 6, after), "below -ts_adapt_dt_min 2");
    else
      ok(run(ts, 6, over ? after : never));
    PetscVFPrintf = print;
    if (k == 4) {
      ok(TSDestroy(&ts));
      break;
    }
    tried(k == 1 ? halved : k == 3 ? bounded : fixed);
    accepted(over ? "rrraaa" : "rarraa");
    ok(TSAdaptRLGetHandover(adapt, &handed, &time));
    assert_int_equal(over, handed);
    assert_int_equal(over, strstr(printed.text, "rl hands the run over to heuristic with -ts_rtol 0.0001, because its "
                                                "observations stay outside the policy's training range") != NULL);
    assert_int_equal(over ? 2 : 1, printed.lines);
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

  for (int k = 0; k < 3; k++) {
    const char *const options[] = {"", "-ts_adapt_rl_strict",
                                   "-ts_adapt_heuristic_growth 4 -ts_adapt_heuristic_failure_factor 0.2"};
    TS ts = start(TSADAPTRL, options[k], 0.1);
    SlipPolicy p = policy(1, names, w, 0);

    script.untrained = "it is new";
    choose_by(ts, p);
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

/* Steps in units of the last one: log10 of the ratio is tanh(w.obs). The order is 3; E > 1 rejects; of the two
   rejections in a row the first is cut to 0.9 h and the second to 0.5 h by the guard rails, a failure halves, and the
   first step is the TS's own. */
static void rl_relative(void **state)
{
  const char *const names[] = {"log_error_step", "change_log_error_step", "log_step_ratio", "rejected", "order"};
  const PetscReal w[] = {0.5, 0.25, -0.5, 2, 0.01}, error[] = {1. / 8, 1. / 27, 8, 64, 1, FAIL, 1. / 8};
  const PetscReal one[5] = {1, 1, 1, 1, 1}, zero[5] = {0}, two = log10(2), three = log10(3);
  const PetscReal bias = 0;
  PetscReal h[7], ratio;
  SlipPolicy p;
  TS ts = start(TSADAPTRL, "", 2);

  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  ok(SlipPolicySetObservations(p, 5, names, one, zero));
  ok(SlipPolicyAddLayer(p, 5, 1, w, &bias, SLIP_ACTIVATION_LINEAR));
  ok(SlipPolicySetAction(p, -1, 1, 0.1, "h", 10, "h", PETSC_TRUE));
  choose_by(ts, p);
  ok(run(ts, 7, error));
  h[0] = 2;
  h[1] = h[0] * pow(10, tanh(0.5 * two + 0.03));
  ratio = log10(h[1] / h[0]);
  h[2] = h[1] * pow(10, tanh(0.5 * three + 0.25 * (three - two) - 0.5 * ratio + 0.03));
  h[3] = 0.9 * h[2]; /* it is told of the rejection, and would grow */
  h[4] = 0.5 * h[3];
  ratio = log10(h[4] / h[1]);
  h[5] = h[4] * pow(10, tanh(0.25 * -three - 0.5 * ratio + 0.03));
  h[6] = 0.5 * h[5];
  tried(h);
  accepted("aarrara");
  assert_true(script.needs_error);

  /* PETSc has failed to solve, and shortened the step: no growth for four attempts, whatever the error */
  ts->num_snes_failures++;
  script.last = (SlipAttempt){.converged = PETSC_TRUE, .dt = 1, .error = 1e-9};
  for (int i = 0; i < 5; i++) {
    PetscReal next;
    PetscBool accept;

    ok(TSAdaptChoose(ts->adapt, ts, 1, NULL, &next, &accept));
    assert_true(accept && (i < 4 ? next == 1 : next > 1));
  }
  ok(TSDestroy(&ts));
}

/* A policy's own numbers: tolerance and first step follow the dial a unless they are given, and after a failed solve
   two steps do not grow. 5 a and 30 a^0.5 T* at a = 1e-2: 0.05, and 6 s. An error estimate of 3, or of the option's 2,
   still passes. */
static void rl_numbers(void **state)
{
  const char *const names[] = {"log_error_step"};
  const struct {
    const char *name, *value;
  } attribute[] = {
    {SLIP_POLICY_RTOL_FACTOR, "5"},        {SLIP_POLICY_RTOL_POWER, "1"}, {SLIP_POLICY_FIRST_STEP_FACTOR, "30"},
    {SLIP_POLICY_FIRST_STEP_POWER, "0.5"}, {SLIP_POLICY_HOLD, "2"},       {SLIP_POLICY_CEILING, "3"}};
  const char *const options[] = {"", "-ts_rtol 0.3 -ts_dt 1.5 -ts_adapt_rl_error_ceiling 2"};
  const PetscReal one = 1, zero = 0, error[] = {1};

  for (PetscInt given = 0; given < 2; given++) {
    TS ts = start(TSADAPTRL, options[given], 2);
    PetscReal rtol;
    SlipPolicy p;

    ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
    ok(SlipPolicySetObservations(p, 1, names, &one, &zero));
    ok(SlipPolicyAddLayer(p, 1, 1, &one, &zero, SLIP_ACTIVATION_LINEAR));
    ok(SlipPolicySetAction(p, -1, 1, 0.1, "h", 10, "h", PETSC_TRUE));
    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(attribute); i++)
      ok(SlipPolicySetAttribute(p, attribute[i].name, attribute[i].value));
    choose_by(ts, p);
    ok(TSSetFromOptions(ts));
    ok(run(ts, 1, error));
    near(script.tried[0], given ? 1.5 : 6);
    ok(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
    near(rtol, given ? 0.3 : 0.05);
    ts->num_snes_failures++;
    script.last = (SlipAttempt){.converged = PETSC_TRUE, .dt = 1, .error = 1e-9};
    for (int i = 0; i < 3; i++) {
      PetscReal next;
      PetscBool accept;

      ok(TSAdaptChoose(ts->adapt, ts, 1, NULL, &next, &accept));
      assert_true(accept && (i < 2 ? next == 1 : next > 1));
    }
    for (PetscReal E = 1.5; E < 4.6; E += 1) {
      PetscReal next;
      PetscBool accept;

      script.last = (SlipAttempt){.converged = PETSC_TRUE, .dt = 1, .error = E};
      ok(TSAdaptChoose(ts->adapt, ts, 1, NULL, &next, &accept));
      assert_true(accept == (E <= (given ? 2 : 3) ? PETSC_TRUE : PETSC_FALSE));
    }
    ok(TSDestroy(&ts));
  }
  PetscOptionsClear(NULL);
}

static void rl_errors(void **state)
{
  const char *const unknown[] = {"energy", "temperature"}, *const accuracy[] = {"accuracy"}, *const far[] = {"state_3"};
  const char *const *const names[] = {unknown, accuracy, far};
  const char *const want[] = {"entry 1 of /observation/names is \"temperature\"",
                              "-ts_adapt_type rl needs an error estimate", "state_3 of a state with 3 components"};
  const PetscReal w[] = {0, 0}, error[] = {-1, -1};
  TS ts = start(TSADAPTRL, "-ts_adapt_rl_problem weather", 77);

  ok(TSSetFromOptions(ts));
  fails(run(ts, 1, error), "-ts_adapt_rl_policy <file.h5>");
  for (int k = 0; k < 3; k++) {
    SlipPolicy p = policy(k ? 1 : 2, names[k], w, 0);

    ts = start(TSADAPTRL, "", 77);
    choose_by(ts, p);
    fails(run(ts, 2, error), want[k]);
  }
  ts = start(TSADAPTRL, "-ts_adapt_rl_policy no_such_policy.h5", 77);
  fails(TSSetFromOptions(ts), "no_such_policy.h5");
  ts = start(TSADAPTRL, "-ts_adapt_rl_max_failures 0", 77);
  fails(TSSetFromOptions(ts), "-ts_adapt_rl_max_failures is 0");
  PetscOptionsClear(NULL);
}

SLIP_TESTS_WITH(Register, NULL, rl_observations, rl_fallbacks, rl_guard_rail, rl_ceiling, rl_actor, rl_relative,
                rl_numbers, rl_errors, rl_outside, rl_handover, rl_untrained)
