/* -fault_accuracy: the tolerances that follow from it keep it, and what goes before them. */
#define _GNU_SOURCE /* setenv() */
#include "unit.h"
#include "faultstart.h"
#include "dials/ladder.h"
#include "runs/runs.h"
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/sliph5.h>
#include <stdlib.h>
#include <string.h>
#include "tempdir.h"

enum { STREAM = 97, MOST_CASES = 40 }; /* of seeds: neither training's nor the benchmark's */
static const PetscReal Accuracies[] = {1e-1, 1e-2};

/* How many draws have errors up to the bound */
static PetscInt within(Ladder *l, PetscInt c, PetscReal rtol, PetscReal bound, PetscReal *kept, PetscReal accuracy)
{
  LadderRun run[MOST_CASES];
  LadderScore score;

  for (PetscInt e = 0; e < l->n; e++) ok(LadderRunOnce(l, e, l->controller[c], rtol, &run[e]));
  LadderScoreRuns(l->n, run, accuracy, &score);
  *kept = score.kept;
  LadderScoreRuns(l->n, run, bound, &score);
  return (PetscInt)PetscFloorReal(score.kept * (PetscReal)l->n + (PetscReal)0.5);
}

/* Each controller keeps the accuracy at the table's tolerance in nine of ten draws at least, as it does in 95 %; and so
   many draws as wanted have errors up to a share of it, which they do not at five times the tolerance: errors go with
   its power of two thirds, a factor of three. So a table whose number is five times larger or smaller fails. At the
   ladder's loosest tolerance, which pi does not go by any more, the table has just that. */
static void keeps(const Problem *problem, const char kind[], PetscInt draws, PetscReal share, PetscInt wanted)
{
  Ladder l;

  ok(LadderCreate(problem, NULL, 0, STREAM, 0, draws, DIAL_CONTROLLERS, &l));
  for (PetscInt a = 0; a < 2; a++)
    for (PetscInt c = 0; c < l.ncontrollers; c++) {
      PetscReal rtol, kept, loose;
      PetscInt n[2];

      ok(SlipFaultFindTolerance(kind, l.controller[c], Accuracies[a], &rtol));
      n[0] = within(&l, c, rtol, share * Accuracies[a], &kept, Accuracies[a]);
      n[1] = within(&l, c, 5 * rtol, share * Accuracies[a], &loose, Accuracies[a]);
      assert_true(kept >= 0.9);
      assert_true(n[0] >= wanted);
      assert_true(rtol == LadderTolerance(0) || n[1] < wanted);
    }
  ok(LadderDestroy(&l));
}

static void events(void **state)
{
  keeps(&ProblemDial, "event", 40, 1, 36);
}

/* The calibration has faults that are twice and three times as large as well, which take minutes here: the errors of
   small ones are a third of theirs. */
static void ruptures(void **state)
{
  CMAProblem row = *ProblemRupture.cma;
  Problem problem = ProblemRupture;

  row.create = RunsCreate;
  problem.cma = &row;
  keeps(&problem, "rupture", 24, 0.35, 19);
}

/* ---- the calibration, on a problem whose error is a factor of its own times the tolerance ---- */

enum { FACTORS = 20 };
static PetscReal spoiled = 0; /* runs at tolerances near this are off */

static uint64_t Seed(PetscInt seed, PetscInt stream, PetscInt64 k)
{
  return (uint64_t)k;
}

static PetscErrorCode SetUp(CMAOptions *o)
{
  return PETSC_SUCCESS;
}

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  PetscReal *factor;

  PetscCall(PetscNew(&factor));
  *factor = (PetscReal)(seed + 1);
  *episode = factor;
  return PETSC_SUCCESS;
}

static PetscErrorCode Destroy(void **episode)
{
  return PetscFree(*episode);
}

static PetscErrorCode Classical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *r)
{
  const PetscReal factor = *(const PetscReal *)episode;

  *r = (EpisodeResult){.solves = (PetscInt)(1 / rtol), .done = 1, .error = factor * rtol};
  if (spoiled > 0 && PetscAbsReal(PetscLogReal(rtol / spoiled)) < 0.1) r->error = 1;
  return PETSC_SUCCESS;
}

/* 95 % of the factors 1 to 20 are at most 19: the loosest tolerance for a is a/19, and none is that is looser than one
   which fails. */
static void calibrated(void **state)
{
  const CMAProblem row = {.seed = Seed, .setup = SetUp, .create = Create, .destroy = Destroy, .classical = Classical};
  const Problem problem = {.name = "factors", .cma = &row};
  PetscReal worst[LADDER_RUNGS];
  LadderScore score;
  PetscBool cut;
  Ladder l;

  for (PetscInt k = 0; k < 2; k++) {
    spoiled = k ? LadderTolerance(14) : 0;
    ok(LadderCreate(&problem, NULL, 0, STREAM, 0, FACTORS, "any", &l));
    for (PetscInt e = 0; e < FACTORS; e++) {
      ok(LadderClimb(&l, e, 0, 5e-4, 0, &cut));
      assert_false(cut);
    }
    LadderWorst(&l, 0, 0.95, worst);
    if (k)
      assert_true(LadderLoosest(worst, 1e-2) < LadderTolerance(14));
    else
      AssertNear(LadderLoosest(worst, 1e-2), 1e-2 / 19, 1e-12);
    assert_int_equal(LadderCheapest(&l, 9, LadderTolerance(6) * 10.5), (PetscInt)(1 / LadderTolerance(k ? 15 : 6)));
    ok(LadderScoreSetting(&l, "any", 1e-2 / 15.5, 1e-2, &score));
    AssertNear(score.kept, 0.75, 1e-12);
    ok(LadderDestroy(&l));
  }
  spoiled = 0;
}

/* The solves are one over the tolerance: a limit of 40 ends after rung 7, 56 solves, where the error of the factor 10
   is 0.18. Larger errors have the same runs as without the limit, smaller ones none. */
static void limited(void **state)
{
  const CMAProblem row = {.seed = Seed, .setup = SetUp, .create = Create, .destroy = Destroy, .classical = Classical};
  const Problem problem = {.name = "factors", .cma = &row};
  PetscReal worst[LADDER_RUNGS];
  PetscBool cut;
  Ladder l;

  ok(LadderCreate(&problem, NULL, 0, STREAM, 9, 1, "any", &l));
  ok(LadderClimb(&l, 0, 0, 5e-4, 40, &cut));
  assert_true(cut);
  assert_int_equal(LadderCheapest(&l, 0, 0.57), (PetscInt)(1 / LadderTolerance(5)));
  assert_int_equal(LadderCheapest(&l, 0, 0.17), 0);
  LadderWorst(&l, 0, 1, worst);
  AssertNear(worst[LADDER_RUNGS - 1], 10 * LadderTolerance(7), 1e-12);
  assert_true(LadderLoosest(worst, 0.17) < 0);
  ok(LadderDestroy(&l));
}

static void interpolated(void **state)
{
  PetscReal fine, coarse, between;

  ok(SlipFaultFindTolerance("rupture", "dsp", 1e-2, &coarse));
  ok(SlipFaultFindTolerance("rupture", "dsp", 3e-3, &fine));
  ok(SlipFaultFindTolerance("rupture", "dsp", PetscSqrtReal(3e-5), &between));
  AssertNear(between, PetscSqrtReal(fine * coarse), 1e-12 * coarse);
  ok(SlipFaultFindTolerance("rupture", "dsp:PI34", 1e-2, &between)); /* as dsp */
  assert_true(between == coarse);
  ok(SlipFaultFindTolerance("rupture", TSADAPTNONE, 1e-2, &between));
  assert_true(between == 0);
  fails(SlipFaultFindTolerance("landslide", "dsp", 1e-2, &between), "landslide");
}

/* What the TS of a small fault has for a tolerance once a step was taken, under options */
typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
} Run;

static Run start(const char options[], PetscBool rupture)
{
  Run r;

  ok(SetOptions(options));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &r.fault));
  ok(SlipFaultSetReal(r.fault, "nx", 2));
  if (rupture) {
    ok(SlipFaultSetString(r.fault, "initial", "traction"));
    ok(SlipFaultSetReal(r.fault, "initial_traction", 1.4e7));
    ok(SlipFaultSetBool(r.fault, "initial_unstable", PETSC_TRUE));
    ok(PetscOptionsSetValue(NULL, "-ts_type", TSBATHE)); /* explicit steps are the default */
  }
  ok(SlipFaultSetFromOptions(r.fault));
  ok(FaultStart(r.fault, NULL, 0, 0, &r.w, &r.ts));
  ok(TSSetMaxSteps(r.ts, 1));
  ok(TSSetFromOptions(r.ts));
  return r;
}

static PetscReal tolerance(Run *r)
{
  PetscReal rtol;

  ok(TSSolve(r->ts, r->w));
  ok(TSGetTolerances(r->ts, NULL, NULL, &rtol, NULL));
  return rtol;
}

static void end(Run *r)
{
  ObjectsDestroy(&r->w, &r->ts, &r->fault);
  ok(PetscOptionsClear(NULL));
}

/* Where the table has no number for an accuracy the tolerance goes on by the slope of the two before: pi with the
   filter has none at 1e-3 for events, 0.000724 at 1e-2 and 0.000116 at 3e-3. */
static void beyond_the_table(void **state)
{
  const PetscReal slope = log(0.000116 / 0.000724) / log(0.3), expected = 0.000116 * pow(1e-3 / 3e-3, slope);
  Run r = start("-ts_adapt_type pi -ts_adapt_pi_filter fault_history -fault_accuracy 0.001", PETSC_FALSE);

  assert_true(fabs(tolerance(&r) / expected - 1) < 1e-12);
  assert_true(r.fault->steps.accuracy == 0); /* and is not said to keep it */
  end(&r);
}

static void precedence(void **state)
{
  const struct {
    const char *options, *controller;
    PetscReal accuracy, rtol; /* rtol > 0: that, whatever the accuracy */
  } rows[] = {
    {"-ts_adapt_safety 0.9", "pi:fault_history", 1e-2, 0},
    {"-ts_adapt_safety 0.9 -fault_accuracy 0.05", "pi:fault_history", 0.05, 0},
    {"-ts_adapt_type heuristic", "heuristic", 1e-2, 0},
    {"-ts_adapt_type pi -fault_accuracy 0.1", "pi", 0.1, 0},
    {"-ts_adapt_type pi -ts_adapt_pi_filter fault_history -fault_accuracy 0.004", "pi:fault_history", 4e-3, 0},
    {"-ts_adapt_type basic -ts_rtol 3e-4 -fault_accuracy 0.1", "basic", 0, 3e-4},
    {"-ts_adapt_type none", TSADAPTNONE, 0, 1e-3}};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++) {
    Run r = start(rows[i].options, PETSC_FALSE);
    PetscReal expected = rows[i].rtol, found = tolerance(&r);
    char name[64];
    TSAdapt adapt;

    ok(TSGetAdapt(r.ts, &adapt));
    ok(SlipAdaptGetController(adapt, name, sizeof(name)));
    if (rows[i].controller) assert_string_equal(name, rows[i].controller);
    if (expected == 0) ok(SlipFaultFindTolerance("event", name, rows[i].accuracy, &expected));
    assert_true(found == expected);
    /* again, and by TSSetTolerances() */
    ok(TSSetStepNumber(r.ts, 0));
    ok(TSSetTime(r.ts, 0));
    ok(SlipFaultSetInitialState(r.fault, r.w));
    ok(TSSetTolerances(r.ts, PETSC_DEFAULT, NULL, 7e-5, NULL));
    assert_true(tolerance(&r) == 7e-5);
    end(&r);
  }
}

/* rl is the default where its policy is there and trained for the accuracy, until a tolerance is given. */
static void learned(void **state)
{
  const struct {
    const char *options, *controller, *tolerant; /* and once TSSetTolerances() was called */
    PetscBool rupture;
  } rows[] = {{"", "rl", "pi:fault_history", PETSC_FALSE},
              {"", "rl", "pi", PETSC_TRUE},
              {"-fault_accuracy 1e-3", "rl", "dsp", PETSC_FALSE},
              {"-fault_accuracy 2e-3", "rl", "pi", PETSC_TRUE},
              {"-fault_accuracy 1.9e-3", "pi", "pi", PETSC_TRUE},
              {"-ts_adapt_rl_accuracy 0.05", "rl", "rl", PETSC_FALSE},
              {"-ts_rtol 1e-3", "pi:fault_history", "pi:fault_history", PETSC_FALSE},
              {"-ts_rtol 1e-3", "pi", "pi", PETSC_TRUE},
              {"-ts_adapt_pi_filter PI42", "pi:PI42", "pi:PI42", PETSC_TRUE},
              {"-ts_adapt_dsp_filter PI42", "rl", "pi", PETSC_TRUE}, /* of no controller that the run could take */
              {"-ts_adapt_dsp_filter PI42", "rl", "pi:fault_history", PETSC_FALSE},
              {"-ts_adapt_heuristic_growth 3", "rl", "pi:fault_history", PETSC_FALSE},
              {"-ts_adapt_type dsp", "dsp", "dsp", PETSC_FALSE},
              {"-ts_adapt_type rl", "rl", "rl", PETSC_FALSE},
              {"-fault_friction_law constant", "pi", "pi", PETSC_TRUE},
              {"-fault_friction_law linear_slip_weakening", "rl", "pi", PETSC_TRUE},
              {"-fault_friction_law rate_weakening", "pi:fault_history", "pi:fault_history", PETSC_FALSE},
              {"-fault_inertia no", "pi:fault_history", "pi:fault_history", PETSC_FALSE},
              {"-fault_loading_rate 1e-9", "dsp", "dsp", PETSC_FALSE}};

  for (PetscInt i = 0; i < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(rows); i++)
    for (PetscInt tolerant = 0; tolerant < 2; tolerant++) {
      Run r = start(rows[i].options, rows[i].rupture);
      PetscReal dial;
      char name[64];
      TSAdapt adapt;

      if (tolerant) ok(TSSetTolerances(r.ts, PETSC_DEFAULT, NULL, 1e-3, NULL));
      ok(TSSolve(r.ts, r.w));
      ok(TSGetAdapt(r.ts, &adapt));
      ok(SlipAdaptGetController(adapt, name, sizeof(name)));
      ok(TSAdaptRLGetAccuracy(adapt, &dial));
      assert_string_equal(name, tolerant ? rows[i].tolerant : rows[i].controller);
      if (i == 2 && !tolerant) assert_true(dial == 1e-3);
      end(&r);
    }
}

/* The type of TS that a rupture without inertia takes, and at which tolerance; 0: that of the fault, less than which
   another accuracy makes it */
static void explicit_ruptures(void **state)
{
  const struct {
    const char *options, *type;
    PetscReal rtol;
  } rows[] = {{"", TSRKC, 0.013},
              {"-fault_accuracy 1e-1", TSRKC, 0.3},
              {"-fault_accuracy 3e-2", TSRKC, 0},
              {"-fault_slip_components 2", TSRKC, 0.013},
              {"-fault_friction_law linear_slip_weakening", TSRKC, 0.013},
              {"-ts_type adams", TSADAMS, 0.015},
              {"-ts_type rkc", TSRKC, 0.013},
              {"-ts_type rkc -fault_stressing_rate 1", TSRKC, 1e-2},
              {"-ts_type adams -fault_stressing_rate 1", TSADAMS, 1e-3},
              {"-ts_rtol 1e-4", TSRKC, 1e-4},
              {"-ts_adapt_type dsp", TSBATHE, 0},
              {"-ts_bathe_gamma 0.6", TSBATHE, 0},
              {"-ksp_type cg", TSBATHE, 0},
              {"-ts_adapt_clip 0.1,4 -fault_output_fields slip", TSRKC, 0.013},
              {"-fault_check_error", TSBATHE, 0},
              {"-fault_friction_law constant", TSBATHE, 0},
              {"-fault_friction_law rate_weakening", TSBATHE, 0},
              {"-fault_stressing_rate 1", TSBATHE, 0},
              {"-fault_injection 1500,1500 -fault_injection_pressure 1e6 -fault_injection_diffusivity 1", TSBATHE, 0},
              {"-fault_inertia yes -fault_viscosity sqrtm", TSBATHE, 0}};

  for (PetscInt i = 0; i < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(rows); i++)
    for (PetscInt named = 0; named < 2; named++) { /* a type that the program has set counts */
      SlipFault fault;
      PetscReal rtol;
      TSType type;
      TS ts;

      ok(SetOptions(rows[i].options));
      ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
      ok(SlipFaultSetString(fault, "initial", "traction"));
      ok(FaultSetReals(fault, {"nx", 2}, {"initial_traction", 1.4e7}));
      ok(SlipFaultSetBool(fault, "initial_unstable", PETSC_TRUE));
      ok(SlipFaultSetFromOptions(fault));
      ok(SlipFaultSetUp(fault));
      ok(TSCreate(PETSC_COMM_SELF, &ts));
      if (named) ok(TSSetType(ts, TSBATHE));
      ok(SlipFaultConfigureTS(fault, ts));
      ok(TSSetFromOptions(ts));
      ok(TSGetType(ts, &type));
      ok(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
      assert_string_equal(type, named && !strstr(rows[i].options, "-ts_type") ? TSBATHE : rows[i].type);
      if (!named && rows[i].rtol > 0) AssertNear(rtol, rows[i].rtol, 1e-12);
      if (!strcmp(rows[i].options, "-fault_accuracy 3e-2") && !named) assert_true(rtol > 0.013 && rtol < 0.3);
      ObjectsDestroy(&ts, &fault);
    }
  ok(PetscOptionsClear(NULL));
}

static void without_policies(void **state)
{
  char name[64];
  TSAdapt adapt;
  Run r;

  assert_int_equal(setenv("SLIPSTEP_POLICY_DIR", "/nowhere", 1), 0);
  r = start("", PETSC_TRUE);
  assert_int_equal(unsetenv("SLIPSTEP_POLICY_DIR"), 0);
  ok(TSGetAdapt(r.ts, &adapt));
  ok(SlipAdaptGetController(adapt, name, sizeof(name)));
  assert_string_equal(name, "pi");
  end(&r);
}

/* The dial of rl, and the tolerance that a run is handed over with: that of the fallback by the dial. A rupture is not
   what the policy of events knows. */
static void handed_over(void **state)
{
  const struct {
    const char *options;
    PetscReal dial, rtol; /* rtol 0: by the dial */
  } rows[] = {{"-ts_adapt_rl_problem fault -ts_adapt_type rl", 1e-2, 0},
              {"-ts_adapt_rl_problem fault -ts_adapt_type rl -fault_accuracy 0.03", 0.03, 0},
              {"-ts_adapt_rl_problem fault -ts_adapt_type rl -fault_accuracy 0.03 -ts_adapt_rl_accuracy 0.05", 0.05, 0},
              {"-ts_adapt_rl_problem fault -ts_adapt_type rl -fault_accuracy 0.03 -ts_rtol 2e-3", 0.03, 2e-3}};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++) {
    Run r = start(rows[i].options, PETSC_TRUE);
    PetscReal expected = rows[i].rtol, found = tolerance(&r), dial;
    TSAdaptType fallback;
    PetscInt steps;
    PetscBool handed;
    TSAdapt adapt;

    ok(TSGetAdapt(r.ts, &adapt));
    ok(TSAdaptRLGetAccuracy(adapt, &dial));
    assert_true(dial == rows[i].dial);
    ok(TSAdaptRLGetHandover(adapt, &handed, NULL));
    assert_true(handed);
    ok(TSAdaptRLGetFallback(adapt, &fallback));
    ok(TSAdaptRLGetHandoverStep(adapt, &steps));
    assert_int_equal(steps, 0);
    if (expected == 0) ok(SlipFaultFindTolerance("rupture", fallback, dial, &expected));
    assert_true(found == expected && expected > 0);
    end(&r);
  }
}

/* ---- files of tolerances ---- */

enum { GOOD, NO_KIND, NO_ROWS, OTHER_SHAPE, RISING, OTHER_FORMAT, OTHER_VERSION };

/* Two controllers at three accuracies, of which the second keeps one; damage: what is wrong with it */
static void write_tolerances(const char file[], int damage)
{
  static const char *const names[] = {"pi", "dsp"};
  const PetscReal accuracy[] = {1e-1, 1e-2, 1e-3}, rtol[] = {0.3, 0.02, damage == RISING ? 0.05 : 0.001, 0.4, 0, 0};
  const PetscInt n[2] = {damage == OTHER_SHAPE ? 1 : 2, 3};
  SlipH5 h;

  ok(SlipH5Create(file, &h));
  ok(SlipH5WriteAttrString(&h, "/", "format", damage == OTHER_FORMAT ? "slipstep-policy" : "slipstep-tolerances"));
  ok(SlipH5WriteAttrInt(&h, "/", "version", damage == OTHER_VERSION ? 1 : 2));
  if (damage != NO_KIND) {
    ok(SlipH5WriteReal(&h, "/rupture/accuracy", 1, &n[1], accuracy, NULL));
    ok(SlipH5WriteStrings(&h, "/rupture/controllers", 2, names));
    if (damage != NO_ROWS) ok(SlipH5WriteReal(&h, "/rupture/rtol", 2, n, rtol, NULL));
  }
  ok(SlipH5Close(&h));
}

/* A file that an option names counts for runs of its kind, which rl is no default of then. */
static void named_tolerances(void **state)
{
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE], options[256];
  const struct {
    const char *options;
    PetscReal rtol, accuracy;
  } rows[] = {{"", 0.02, 1e-2}, /* pi is the default of ruptures */
              {"-fault_accuracy 1e-3", 1e-3, 1e-3},
              {"-ts_adapt_type dsp -fault_accuracy 0.1", 0.4, 0.1},
              {"-ts_adapt_type dsp", 1e-3, 0}, /* it keeps none, and has that of controllers without a row */
              {"-ts_adapt_type heuristic", 1e-3, 0},
              {"-ts_rtol 0.07", 0.07, 0}};
  PetscReal found;
  Run r;

  assert_int_equal(0, TempDirFile("test_steps", "mine.h5", dir, file));
  write_tolerances(file, GOOD);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++) {
    snprintf(options, sizeof(options), "-fault_tolerances %s %s", file, rows[i].options);
    r = start(options, PETSC_TRUE);
    found = tolerance(&r);
    AssertNear(found, rows[i].rtol, 1e-15);
    assert_true(r.fault->steps.accuracy == rows[i].accuracy);
    end(&r);
  }
  /* In a folder of policies a file counts for all runs; where there is none the library's own does. */
  assert_int_equal(setenv("SLIPSTEP_POLICY_DIR", dir, 1), 0);
  ok(SlipFaultFindTolerance("rupture", "pi", 1e-2, &found));
  assert_true(found == 0.0238);
  snprintf(file, sizeof(file), "%s/tolerances.h5", dir);
  write_tolerances(file, GOOD);
  ok(SlipFaultFindTolerance("rupture", "pi", 1e-2, &found));
  assert_true(found == 0.02);
  assert_int_equal(unsetenv("SLIPSTEP_POLICY_DIR"), 0);
  ok(SlipFaultFindTolerance("sequence_inertia", "pi", 1e-1, &found));
  assert_true(found == 0.01 / 5); /* no looser than what loses no events, and a fifth with inertia */
  assert_int_equal(0, TempDirRemove(dir));
}

static void damaged_tolerances(void **state)
{
  const struct {
    int damage;
    const char *says;
  } rows[] = {{NO_KIND, "has no group /rupture, which has the tolerances of such a run"},
              {NO_ROWS, "has no dataset /rupture/rtol"},
              {OTHER_SHAPE, "/rupture/rtol in"},
              {RISING, "number 0, 2 of /rupture/rtol is 0.05; expected numbers >= 0 that do not rise along a row"},
              {OTHER_FORMAT, "attribute format of / is \"slipstep-policy\"; expected \"slipstep-tolerances\""},
              {OTHER_VERSION, "attribute version of / is 1; this library reads version 2"}};
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  SlipFaultTolerances t;
  PetscReal found;

  assert_int_equal(0, TempDirFile("test_steps", "tolerances.h5", dir, file));
  assert_int_equal(setenv("SLIPSTEP_POLICY_DIR", dir, 1), 0);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++) {
    write_tolerances(file, rows[i].damage);
    fails(SlipFaultTolerancesRead(PETSC_COMM_SELF, NULL, file, "rupture", &t), rows[i].says);
    fails(SlipFaultTolerancesRead(PETSC_COMM_SELF, "a_", file, "rupture", &t), "(-a_fault_tolerances)");
    fails(SlipFaultFindTolerance("rupture", "pi", 1e-2, &found),
          file); /* it is an error, and the library's do not count */
  }
  assert_int_equal(truncate(file, 1000), 0);
  fails(SlipFaultTolerancesRead(PETSC_COMM_SELF, NULL, file, "rupture", &t), "truncated or damaged");
  fails(SlipFaultTolerancesRead(PETSC_COMM_SELF, NULL, "nowhere.h5", "rupture", &t),
        "cannot read nowhere.h5: no such file, or no permission (-fault_tolerances)");
  assert_int_equal(unsetenv("SLIPSTEP_POLICY_DIR"), 0);
  assert_int_equal(0, TempDirRemove(dir));
}

/* Words in the value of an option are none of the TS. */
static void words_in_values(void **state)
{
  Run r;
  TSAdapt adapt;
  char name[64];

  ok(PetscOptionsClear(NULL));
  ok(PetscOptionsSetValue(NULL, "-title", "made with -ts_rtol 1e-3 and -ts_adapt_type heuristic , -ts_adapt_pi_g1 3"));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &r.fault));
  ok(SlipFaultSetReal(r.fault, "nx", 2));
  ok(FaultStart(r.fault, NULL, 0, 0, &r.w, &r.ts));
  ok(TSSetFromOptions(r.ts));
  ok(TSGetAdapt(r.ts, &adapt));
  ok(SlipAdaptGetController(adapt, name, sizeof(name)));
  assert_string_equal(name, "rl");
  end(&r);
}

static void refused(void **state)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  fails(SlipFaultSetReal(fault, "accuracy", 0.11), "-fault_accuracy is 0.11, expected a number >= 0.001 and <= 0.1");
  fails(SlipFaultSetReal(fault, "accuracy", 9e-4), "-fault_accuracy is 0.0009, expected a number >= 0.001 and <= 0.1");
  ok(FaultSetReals(fault, {"accuracy", 0.1}, {"accuracy", 1e-3}));
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(events, ruptures, calibrated, limited, interpolated, beyond_the_table, precedence, learned,
           explicit_ruptures, without_policies, handed_over, named_tolerances, damaged_tolerances, words_in_values,
           refused)
