/* What steps of injections are trained by: the error of drawn faults under a pore pressure. */
#define _XOPEN_SOURCE 700 /* SIGXFSZ */
#include "unit.h"
#include "tempdir.h"
#include "runs/runs.h"
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

enum { STREAM = 98, CONSTANT = 3, WEAKENS = 4 }; /* of seeds, neither training's nor the benchmark's */

static RunEpisode *created(PetscInt k)
{
  RunEpisode *e;

  ok(RunEpisodeCreate(&RunInjection, NULL, 1, RandomStreamHashed(77, STREAM, k), &e));
  return e;
}

static PetscInt run(RunEpisode *e, PetscReal rtol, PetscReal *error)
{
  EpisodeResult r;
  const PetscReal *errors = r.errors;

  ok(RunEpisodeRun(e, NULL, RUN_INJECTION_TYPE, rtol, &r));
  assert_true(r.failures >= 0 && r.failures < r.solves);
  assert_true(errors[SLIP_ERROR_HISTORY] >= 0 && errors[SLIP_ERROR_FIELD] >= 0 && errors[SLIP_ERROR_SHIFT] >= 0);
  *error = r.error;
  assert_true(*error ==
              PetscMax(PetscMax(errors[SLIP_ERROR_HISTORY], errors[SLIP_ERROR_FIELD]), errors[SLIP_ERROR_SHIFT]));
  return r.solves;
}

/* A run with the reference's tolerance is the reference; a loose one is worse than a tight one: cells begin within a
   step, so that the error goes at least with its length, the cubic root of the tolerance: 4.6 times for a hundred times
   the tolerance. */
static void measured(void **state)
{
  for (PetscInt k = 0; k < 2; k++) {
    RunEpisode *e = created(k ? WEAKENS : CONSTANT);
    PetscReal same, small, large, drop;
    PetscInt fine, coarse;

    ok(SlipFaultGetReal(e->fault, "friction_drop", &drop));
    assert_true((drop > 0) == (k > 0));
    assert_int_equal(run(e, RUN_INJECTION_RTOL, &same), e->reference.solves);
    assert_true(same == 0);
    fine = run(e, 1e-4, &small);
    coarse = run(e, 1e-2, &large);
    assert_true(coarse < fine && fine < e->reference.solves);
    if (!(large > 4.6 * small && small > 0)) fail_msg("%g and %g", (double)large, (double)small);
    ok(RunEpisodeDestroy(&e));
  }
}

/* A cell that begins in one of two runs alone counts as if it had begun a whole duration too late. */
static void begun(void **state)
{
  RunEpisode *e = created(CONSTANT);
  PetscInt last = -1, count = 0;
  PetscReal error;

  for (PetscInt i = 0; i < e->n; i++) {
    assert_true((e->reference.slip[i] >= e->level[i]) == (e->reference.passed[i] >= 0));
    assert_true(e->reference.passed[i] <= e->end);
    if (e->reference.slip[i] > 2 * e->level[i]) last = i;
    if (e->reference.slip[i] >= 1.25 * e->level[i]) count++;
  }
  assert_true(last >= 0 && count > 2);
  e->reference.passed[last] = -1;
  run(e, RUN_INJECTION_RTOL, &error);
  AssertNear(error, sqrt(1 / (double)(count - 1)), 1e-12);
  ok(RunEpisodeDestroy(&e));
}

/* A step of an hour after a day, in a run of ten days; before the first attempt there is none. */
static void observed(void **state)
{
  const SlipRunNumbers day = {.started = PETSC_TRUE, .dt = 3600, .time = 86400, .max_time = 864000};
  SlipRunNumbers endless = day, start = {.max_time = 864000};
  PetscInt component;
  const PetscInt share = SlipObservationFind("log_step_share", &component),
                 past = SlipObservationFind("log_step_past", &component);

  endless.max_time = PETSC_MAX_REAL;
  AssertNear(SlipObservations[share].run(&day), log10(1 / 240.0), 1e-14);
  AssertNear(SlipObservations[past].run(&day), log10(1 / 24.0), 1e-14);
  assert_true(SlipObservations[share].run(&endless) == -9);
  assert_true(SlipObservations[share].run(&start) == -9 && SlipObservations[past].run(&start) == 0);
}

/* A draw whose record cannot be written, as no file may be larger than this, leaves nothing in the folder of temporary
   files. */
static void left_behind(void **state)
{
  char folder[TEMPDIR_LENGTH];
  PetscInt failed = 0;
  struct rlimit limit, small;

  assert_int_equal(TempDirMake("injections", folder), 0);
  ok(PetscOptionsSetValue(NULL, "-tmp", folder));
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
  small = limit;
  small.rlim_cur = 1000;
  assert_true(signal(SIGXFSZ, SIG_IGN) != SIG_ERR);
  for (uint64_t seed = 0; seed < 8; seed++) {
    RunEpisode e = {.kind = &RunInjection};
    PetscErrorCode code;
    Random random;

    RandomSeed(&random, seed);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    code = InjectionDraw(&e, &random);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    failed += code ? 1 : 0;
    ok(SlipFaultDestroy(&e.fault));
  }
  assert_true(failed > 0);
  assert_int_equal(rmdir(folder), 0); /* there is nothing in it */
  ok(PetscOptionsClearValue(NULL, "-tmp"));
}

/* Of a user's file: a source of its pressure, over the duration that it says. */
static void of_family(void **state)
{
  const char *lines =
    "-fault_initial traction\n-fault_inertia no\n-fault_viscosity radiation\n-fault_nx 8\n-fault_nz 6\n"
    "-fault_length_x 1e3\n-fault_length_z 750\n-fault_depth_top 2e3\n-fault_normal_stress 20e6\n"
    "-fault_normal_stress_gradient 0\n-fault_friction_law constant\n-fault_friction_residual 0.6\n"
    "-fault_initial_traction 11e6\n-fault_injection 400,2300\n-fault_injection_pressure 2e6:4e6\n"
    "-fault_injection_diffusivity 0.5\n-duration 1e5:4e5\n";
  FILE *f = fopen("injections.opts", "w");
  PetscReal pressure;
  Family family;
  RunEpisode *e;

  assert_non_null(f);
  assert_true(fputs(lines, f) >= 0);
  assert_int_equal(fclose(f), 0);
  ok(FamilyRead(PETSC_COMM_SELF, "injections.opts", &family));
  assert_string_equal(family.problem, "injection");
  ok(RunEpisodeCreate(&RunInjection, &family, 1, 5, &e));
  ok(SlipFaultGetReal(e->fault, "injection_pressure", &pressure));
  assert_true(e->end >= 1e5 && e->end <= 4e5 && pressure >= 2e6 && pressure <= 4e6);
  assert_true(e->n == 48 && e->reference.good && e->usual > 0);
  ok(RunEpisodeDestroy(&e));
}

/* The tolerances of the default controller keep their accuracies in 97 % of drawn injections: at least eleven of twelve
   do with a probability of 95 %. */
static void kept(void **state)
{
  const PetscReal accuracies[] = {1e-1, 3e-2};
  PetscReal rtol[2];
  PetscInt within[2] = {0, 0};
  EpisodeResult r;

  for (PetscInt a = 0; a < 2; a++) ok(SlipFaultFindTolerance("injection", "basic", accuracies[a], &rtol[a]));
  for (PetscInt k = 0; k < 12; k++) {
    RunEpisode *e = created(20 + k);

    for (PetscInt a = 0; a < 2; a++) {
      ok(RunEpisodeRun(e, NULL, TSADAPTBASIC, rtol[a], &r));
      if (r.done == 1 && r.error <= accuracies[a]) within[a]++;
    }
    ok(RunEpisodeDestroy(&e));
  }
  for (PetscInt a = 0; a < 2; a++) assert_true(within[a] >= 11);
}

SLIP_TESTS(measured, begun, observed, left_behind, of_family, kept)
