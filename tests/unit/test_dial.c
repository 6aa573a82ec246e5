/* The accuracy dial of TSADAPTRL: option, setter, getter, view, and what a policy that observes it is told. */
#include "policies.h"
#include "faultstart.h"
#include <math.h>

/* The reference fault with one cell for three seconds. */
typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
} Run;

static Run start(const char options[])
{
  Run r;

  ok(SetOptions(options));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &r.fault));
  ok(SlipFaultSetString(r.fault, "stiffness_scaling", "mean_slip"));
  ok(FaultStart(r.fault, NULL, 0, 3, &r.w, &r.ts));
  return r;
}

/* y = tanh(log_accuracy), or of energy */
static SlipPolicy policy(const char name[])
{
  return PolicyOfOne(name, 1, 0, 1);
}

/* The first step of a run [T*]. */
static PetscReal first_step(const char options[], const char observation[], PetscReal accuracy)
{
  Run r = start(options);
  SlipPolicy p = policy(observation);
  SlipAttempt last;
  PetscReal tstar, seen;
  TSAdapt adapt;

  ok(TSGetAdapt(r.ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTRL));
  ok(TSAdaptRLSetPolicy(adapt, p));
  if (accuracy > 0) {
    ok(TSAdaptRLSetAccuracy(adapt, accuracy));
    ok(TSAdaptRLGetAccuracy(adapt, &seen));
    assert_true(seen == accuracy);
  }
  ok(TSSetFromOptions(r.ts));
  ok(TSSetMaxSteps(r.ts, 1));
  ok(TSSolve(r.ts, r.w));
  ok(TSBatheGetLastAttempt(r.ts, &last));
  ok(SlipFaultGetTimeScale(r.fault, &tstar));
  ok(SlipPolicyDestroy(&p));
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  return last.dt / tstar;
}

/* A few roundings of numbers of order one. */
#define near(a, b) assert_true(fabs((a) - (b)) <= 1e-13)

static void dial_is_observed(void **state)
{
  near(first_step("", "log_accuracy", 0), pow(10, tanh(-2) - 1)); /* the default, 1e-2 */
  near(first_step("", "log_accuracy", 1e-3), pow(10, tanh(-3) - 1));
  near(first_step("-ts_adapt_rl_accuracy 0.1", "log_accuracy", 1e-3), pow(10, tanh(-1) - 1));
}

static void dial_is_ignored(void **state)
{
  Run r = start("");
  SlipPolicy p = policy("energy");
  char text[4096] = "";
  const char file[] = "test_dial_view.txt";
  FILE *f;
  PetscViewer viewer;
  TSAdapt adapt;

  near(first_step("-ts_adapt_rl_accuracy 0.1", "energy", 0), first_step("-ts_adapt_rl_accuracy 1e-4", "energy", 0));
  ok(TSGetAdapt(r.ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTRL));
  ok(TSAdaptRLSetPolicy(adapt, p));
  ok(PetscViewerASCIIOpen(PETSC_COMM_SELF, file, &viewer));
  ok(TSAdaptView(adapt, viewer));
  ok(PetscViewerDestroy(&viewer));
  f = fopen(file, "r");
  assert_non_null(f);
  assert_true(fread(text, 1, sizeof(text) - 1, f) > 0);
  fclose(f);
  remove(file);
  assert_non_null(strstr(text, "accuracy dial 0.01 (ignored: the policy does not observe log_accuracy)"));
  ok(SlipPolicyDestroy(&p));
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

/* A policy that observes the error of slip needs the estimate. */
static void needs_estimate(void **state)
{
  Run r = start("-ts_bathe_error none");
  SlipPolicy p = policy("log_slip_error");
  TSAdapt adapt;

  ok(TSGetAdapt(r.ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTRL));
  ok(TSAdaptRLSetPolicy(adapt, p));
  ok(TSSetFromOptions(r.ts));
  message[0] = 0;
  assert_int_not_equal(0, (int)TSSolve(r.ts, r.w));
  if (!strstr(message, "needs an error estimate")) fail_msg("unexpected message \"%s\"", message);
  ok(SlipPolicyDestroy(&p));
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

static PetscReal rest_time(Run *r)
{
  const SlipProblemOps *problem;
  void *fault;
  PetscReal rest;

  ok(TSGetSlipProblem(r->ts, &problem, &fault));
  assert_non_null(problem);
  ok((*problem->control.rest_time)(r->ts, 0, r->w, &rest, fault));
  return rest;
}

/* At rest without load: for ever. At the instability: not at all. Under load: until the traction H v_inf + K v_inf t
   reaches the strength mu sigma; one cell's K is G/Ly and its H is 2 zeta sqrt(M K). */
static void rest(void **state)
{
  const PetscReal rate = 1e-3, stiffness = 30e9 / 3000, mass = 2500 * 3000., strength = 0.6 * 15e3 * 1500;
  const PetscReal wait = (strength - 2 * (0.8 / 3) * sqrt(mass * stiffness) * rate) / (stiffness * rate);
  Run r = start("");

  assert_true(rest_time(&r) == 0);
  ok(VecZeroEntries(r.w));
  assert_true(rest_time(&r) == PETSC_MAX_REAL);
  ok(VecSetValue(r.w, 0, 1e-9, INSERT_VALUES));
  ok(VecAssemble(r.w));
  assert_true(rest_time(&r) == 0); /* it moves */
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
  ok(SlipFaultCreate(PETSC_COMM_SELF, &r.fault));
  ok(SlipFaultSetString(r.fault, "stiffness_scaling", "mean_slip"));
  ok(FaultSetReals(r.fault, {"nx", 1}, {"nz", 1}, {"loading_rate", rate}));
  ok(SlipFaultSetUp(r.fault));
  ok(SlipFaultCreateState(r.fault, &r.w));
  ok(TSCreate(PETSC_COMM_SELF, &r.ts));
  ok(SlipFaultConfigureTS(r.fault, r.ts));
  /* the stiffness is scaled to G/Ly by a solve to 1e-12 */
  if (fabs(rest_time(&r) / wait - 1) > 1e-9) fail_msg("rest time %.12g s, expected %.12g s", rest_time(&r), wait);
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

static void bounds(void **state)
{
  const char *const options[] = {"-ts_adapt_rl_accuracy 0.2", "-ts_adapt_rl_accuracy 1e-5",
                                 "-ts_adapt_rl_accuracy -0.01"};
  const char *const want[] = {"-ts_adapt_rl_accuracy is 0.2", "-ts_adapt_rl_accuracy is 1e-05",
                              "-ts_adapt_rl_accuracy is -0.01"};

  for (int i = 0; i < 3; i++) {
    Run r = start(options[i]);

    SetAdapt(r.ts, TSADAPTRL);
    message[0] = 0;
    assert_int_not_equal(0, (int)TSSetFromOptions(r.ts));
    if (!strstr(message, want[i]) || !strstr(message, "between 0.0001 and 0.1"))
      fail_msg("expected \"%s\" in \"%s\"", want[i], message);
    ObjectsDestroy(&r.ts, &r.w, &r.fault);
  }
}

/* A controller of another type has no dial. */
static void other_types(void **state)
{
  PetscReal seen = 1;
  TSAdapt adapt;
  Run r = start("");

  ok(TSGetAdapt(r.ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTHEURISTIC));
  ok(TSAdaptRLSetAccuracy(adapt, 0.05));
  ok(TSAdaptRLGetAccuracy(adapt, &seen));
  assert_true(seen == 0);
  ObjectsDestroy(&r.ts, &r.w, &r.fault);
}

SLIP_TESTS(dial_is_observed, dial_is_ignored, needs_estimate, rest, bounds, other_types)
