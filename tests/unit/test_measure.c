/* The error that the dial of TSADAPTRL bounds: option, setter, view, the policy it chooses, and dials beyond a policy's
   training. */
#define _GNU_SOURCE /* setenv() */
#include "policies.h"
#include "faultstart.h"
#include "tempdir.h"
#include <math.h>
#include <stdlib.h>

/* The reference fault with one cell */
typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
  TSAdapt adapt;
} Run;

static Run start(const char options[])
{
  Run r;

  ok(SetOptions(options));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &r.fault));
  ok(FaultSetReals(r.fault, {"nx", 1}, {"nz", 1}));
  ok(FaultStart(r.fault, TSADAPTRL, 0, 0, &r.w, &r.ts));
  ok(TSGetAdapt(r.ts, &r.adapt));
  return r;
}

/* y = tanh(log_accuracy), steps from 1e-2 to 1 T*; trained for dials between two. measure: NULL: it does not say */
static SlipPolicy policy(const char measure[], PetscReal low, PetscReal high)
{
  const PetscReal range[] = {log10(low), log10(high)};
  SlipPolicy p = PolicyOfOne("log_accuracy", 1, 0, 1);

  ok(SlipPolicySetRange(p, &range[0], &range[1]));
  if (measure) ok(SlipPolicySetAttribute(p, SLIP_POLICY_MEASURE, measure));
  return p;
}

static void store(const char dir[], const char file[], const char measure[], PetscReal low, PetscReal high)
{
  SlipPolicy p = policy(measure, low, high);
  char path[TEMPDIR_LENGTH + 64];

  snprintf(path, sizeof(path), "%s/%s", dir, file);
  ok(SlipPolicyStore(p, path));
  ok(SlipPolicyDestroy(&p));
}

/* One step of a run with options; its length [T*]. text: what was printed. expected: NULL, or part of the error */
static PetscReal step(Run *r, char text[], size_t len, const char expected[])
{
  char file[64];
  FILE *usual = PETSC_STDOUT;
  SlipAttempt last = {0};
  PetscErrorCode ierr;
  PetscReal tstar;

  snprintf(file, sizeof(file), "test_measure.%ld.txt", (long)getpid());
  PETSC_STDOUT = fopen(file, "w");
  assert_non_null(PETSC_STDOUT);
  ok(TSSetFromOptions(r->ts));
  ok(TSSetMaxSteps(r->ts, 1));
  message[0] = 0;
  ierr = TSSolve(r->ts, r->w);
  fclose(PETSC_STDOUT);
  PETSC_STDOUT = fopen(file, "r");
  assert_non_null(PETSC_STDOUT);
  text[fread(text, 1, len - 1, PETSC_STDOUT)] = 0;
  fclose(PETSC_STDOUT);
  PETSC_STDOUT = usual;
  remove(file);
  if (expected) {
    assert_int_not_equal(0, (int)ierr);
    if (!strstr(message, expected)) fail_msg("expected \"%s\" in \"%s\"", expected, message);
    return 0;
  }
  ok(ierr);
  ok(TSBatheGetLastAttempt(r->ts, &last));
  ok(SlipFaultGetTimeScale(r->fault, &tstar));
  return last.dt / tstar;
}

/* A few roundings of numbers of order one; the bounds of a range went through a logarithm */
#define near(a, b) assert_true(fabs((a) - (b)) <= 1e-12)

/* What the run does by the default policies in the working folder */
static void chooses(const char options[], const char file[], const char measure[])
{
  const char *found;
  SlipPolicy p;
  char text[512];
  Run r = start(options);

  (void)step(&r, text, sizeof(text), NULL);
  assert_string_equal(text, "");
  ok(TSAdaptRLGetPolicy(r.adapt, &p));
  ok(SlipPolicyGetFile(p, &found));
  assert_string_equal(strrchr(found, '/') + 1, file);
  ok(TSAdaptRLGetMeasure(r.adapt, &found));
  assert_string_equal(found, measure);
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

static void default_policies(void **state)
{
  char dir[TEMPDIR_LENGTH];

  assert_int_equal(0, TempDirMake("test_measure", dir));
  assert_int_equal(0, setenv("SLIPSTEP_POLICY_DIR", dir, 1));
  store(dir, "fault.h5", "history", 1e-3, 1e-1);
  chooses("", "fault.h5", "history");
  chooses("-ts_adapt_rl_measure history", "fault.h5", "history");
  chooses("-ts_adapt_rl_measure event_time", "fault.h5", "event_time");
  chooses("-ts_adapt_rl_measure final_slip", "fault.h5", "final_slip"); /* its error is one of those of the history */
  store(dir, "fault_final_slip.h5", NULL, 1e-4, 1e-1);
  chooses("", "fault.h5", "history");
  chooses("-ts_adapt_rl_measure final_slip", "fault_final_slip.h5", "final_slip");
  chooses("-ts_adapt_rl_measure event_time", "fault.h5", "event_time");
  /* an older policy that a user has put there */
  store(dir, "fault.h5", NULL, 1e-4, 1e-1);
  chooses("", "fault.h5", "final_slip");
  assert_int_equal(0, unsetenv("SLIPSTEP_POLICY_DIR"));
  assert_int_equal(0, TempDirRemove(dir));
}

/* A policy that is named: its own measure, or the one asked for if it has that. */
static void named(void **state)
{
  const struct {
    const char *trained, *asked, *measure, *error;
  } row[] = {
    {"history", "", "history", NULL},
    {NULL, "", "final_slip", NULL},
    {"final_slip", "-ts_adapt_rl_measure final_slip", "final_slip", NULL},
    {"history", "-ts_adapt_rl_measure event_time", "event_time", NULL},
    {"history", "-ts_adapt_rl_measure final_slip", NULL,
     "was trained for the measure history, not for -ts_adapt_rl_measure final_slip"},
    {NULL, "-ts_adapt_rl_measure history", NULL,
     "was trained for the measure final_slip, not for -ts_adapt_rl_measure history"},
  };
  const char *found;
  char text[512];

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++) {
    Run r = start(row[i].asked);
    SlipPolicy p = policy(row[i].trained, 1e-3, 1e-1);

    ok(TSAdaptRLSetPolicy(r.adapt, p));
    (void)step(&r, text, sizeof(text), row[i].error);
    ok(TSAdaptRLGetMeasure(r.adapt, &found));
    if (!row[i].error) assert_string_equal(found, row[i].measure);
    ok(SlipPolicyDestroy(&p));
    ObjectsDestroy(&r.ts, &r.w, &r.fault);
  }
}

static void setter(void **state)
{
  const char *found;
  char text[4096] = "";
  PetscViewer viewer;
  Run r = start("-ts_adapt_rl_measure slip");
  FILE *f;

  message[0] = 0;
  assert_int_not_equal(0, (int)TSSetFromOptions(r.ts));
  if (!strstr(message, "-ts_adapt_rl_measure is \"slip\", expected history, final_slip or event_time"))
    fail_msg("%s", message);
  ok(TSAdaptRLGetMeasure(r.adapt, &found));
  assert_string_equal(found, "history");
  ok(TSAdaptRLSetMeasure(r.adapt, "event_time"));
  ok(PetscViewerASCIIOpen(PETSC_COMM_SELF, "test_measure_view.txt", &viewer));
  ok(TSAdaptView(r.adapt, viewer));
  ok(PetscViewerDestroy(&viewer));
  f = fopen("test_measure_view.txt", "r");
  assert_non_null(f);
  assert_true(fread(text, 1, sizeof(text) - 1, f) > 0);
  fclose(f);
  remove("test_measure_view.txt");
  assert_non_null(strstr(text, "measure of the error: event_time\n"));
  ok(TSAdaptSetType(r.adapt, TSADAPTHEURISTIC));
  ok(TSAdaptRLSetMeasure(r.adapt, "history"));
  ok(TSAdaptRLGetMeasure(r.adapt, &found));
  assert_null(found);
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

/* A problem whose error is its own */
static void other_problem(void **state)
{
  SlipPolicy p = policy(NULL, 1e-3, 1e-1);
  Run r = start("-ts_adapt_rl_measure final_slip");
  char text[512];

  ok(TSSetSlipProblem(r.ts, NULL, NULL));
  ok(TSAdaptRLSetPolicy(r.adapt, p));
  (void)step(&r, text, sizeof(text), "-ts_adapt_rl_measure final_slip: the problem has only one measure of error");
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  r = start("-ts_adapt_rl_measure history");
  ok(TSSetSlipProblem(r.ts, NULL, NULL));
  ok(TSAdaptRLSetPolicy(r.adapt, p));
  (void)step(&r, text, sizeof(text), NULL);
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  ok(SlipPolicyDestroy(&p));
}

static PetscReal dialled(const char options[], char text[], size_t len)
{
  SlipPolicy p = policy("history", 1e-3, 5e-2);
  Run r = start(options);
  PetscReal h, dial;

  ok(TSAdaptRLSetPolicy(r.adapt, p));
  h = step(&r, text, len, NULL);
  ok(TSAdaptRLGetAccuracy(r.adapt, &dial));
  if (strstr(options, "2e-4")) assert_true(dial == 2e-4); /* what was asked for */
  ok(SlipPolicyDestroy(&p));
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  return h;
}

/* The range is 1.7 decades wide, and its margin a tenth of that: a factor of 1.48. */
static void clipped(void **state)
{
  char text[512];

  near(dialled("-ts_adapt_rl_accuracy 1e-2", text, sizeof(text)), pow(10, tanh(-2) - 1));
  assert_string_equal(text, "");
  near(dialled("-ts_adapt_rl_accuracy 7e-4", text, sizeof(text)), pow(10, tanh(log10(7e-4)) - 1));
  assert_string_equal(text, "");
  near(dialled("-ts_adapt_rl_accuracy 2e-4", text, sizeof(text)), pow(10, tanh(-3) - 1));
  assert_string_equal(text, "-ts_adapt_rl_accuracy 0.0002: the run uses 0.001, as policy (in memory) was trained for "
                            "0.001 to 0.05\n");
  near(dialled("-ts_adapt_rl_accuracy 0.1", text, sizeof(text)), pow(10, tanh(log10(5e-2)) - 1));
  assert_non_null(strstr(text, "-ts_adapt_rl_accuracy 0.1: the run uses 0.05,"));
}

/* The line of a default policy names the measure that serves. */
static void alternative(void **state)
{
  char dir[TEMPDIR_LENGTH];
  char text[1024];
  Run r;

  assert_int_equal(0, TempDirMake("test_measure", dir));
  assert_int_equal(0, setenv("SLIPSTEP_POLICY_DIR", dir, 1));
  store(dir, "fault.h5", "history", 3e-3, 1e-1);
  store(dir, "fault_final_slip.h5", NULL, 1e-4, 1e-1);
  r = start("-ts_adapt_rl_accuracy 1e-3");
  near(step(&r, text, sizeof(text), NULL), pow(10, tanh(log10(3e-3)) - 1));
  assert_non_null(strstr(text, "-ts_adapt_rl_accuracy 0.001: the run uses 0.003, as policy "));
  assert_non_null(strstr(text, "for 0.003 to 0.1; -ts_adapt_rl_measure final_slip goes down to 0.0001\n"));
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  r = start("-ts_adapt_rl_accuracy 1e-3 -ts_adapt_rl_measure final_slip");
  near(step(&r, text, sizeof(text), NULL), pow(10, tanh(-3) - 1));
  assert_string_equal(text, "");
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  assert_int_equal(0, unsetenv("SLIPSTEP_POLICY_DIR"));
  assert_int_equal(0, TempDirRemove(dir));
}

static PetscReal seen;

static PetscErrorCode actor(TSAdapt adapt, TS ts, PetscInt n, const PetscReal obs[], const SlipAttempt *last,
                            PetscBool guarded, PetscReal *h, void *ctx)
{
  seen = obs[0];
  *h = 0.01;
  return PETSC_SUCCESS;
}

/* A trainer's dial is what it draws, whatever policy is there too. */
static void actors(void **state)
{
  const char *const names[] = {"log_accuracy"};
  SlipPolicy p = policy("history", 1e-3, 5e-2);
  Run r = start("-ts_adapt_rl_accuracy 1e-4");
  char text[512];

  ok(TSAdaptRLSetPolicy(r.adapt, p));
  ok(TSAdaptRLSetActor(r.adapt, 1, names, 0, 1, actor, NULL));
  (void)step(&r, text, sizeof(text), NULL);
  near(seen, -4);
  assert_string_equal(text, "");
  ok(SlipPolicyDestroy(&p));
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

SLIP_TESTS(default_policies, named, setter, other_problem, clipped, alternative, actors)
