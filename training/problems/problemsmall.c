/* Small systems as problems to train on: the sliding mode controller and the circuit, with the models of the programs
   in examples/. Both are dissipative: two solutions of the same system approach each other in the norm of the energy.
   So the error that a step leaves at its end bounds what it changes in the exact continuation, and the sum of these
   errors bounds that of the run. */
#include "environment/plainsmall.h"
#include "../examples/circuit.h"
#include "../examples/sliding_mode.h"
#include <slipcompat.h>

#define LEAVE_WEIGHT                                                                                                   \
  50                /* per error that a step leaves, over the size of the start: 1 % weighs as much as two attempts */
#define SUBSTEPS 16 /* of the exact solution across one step, at least */
#define REFERENCE_FINER 8 /* step of continuations over that of the table of the exact solution */

/* What distinguishes the two. */
typedef struct {
  PetscInt n; /* states */
  /* Norm of a difference of states over the norm of the start */
  PetscReal (*distance)(const void *model, const PetscReal difference[]);
  /* The exact solution at times 0, dt, ..., (n - 1) dt: state [n][states] */
  void (*table)(const void *model, PetscReal dt, PetscInt n, PetscReal state[]);
  void (*plain)(const void *model, PlainSmall *p); /* A, G, q, force and observe */
} System;

struct _EnvJudge {
  const EnvOptions *o;
  const System *system;
  EnvRun *run;
  PetscBool effects;
  EnvRun fine;          /* crosses one step after the other */
  Vec before, reaction; /* where the next step begins */
  PetscReal time;
  SmallErrors errors;
};

static const System SlidingModeSystem, CircuitSystem;

static const System *SystemOf(const Problem *p)
{
  return p == &ProblemCircuit ? &CircuitSystem : &SlidingModeSystem;
}

/* ---- creation ---- */

/* From a model with its start in w, configured as far as TSSetFromOptions(). */
static PetscErrorCode FinishRun(const EnvOptions *o, PetscReal duration, EnvRun *run)
{
  PetscErrorCode (*scale)(TS, PetscReal *);
  PetscReal rtol, atol;

  PetscFunctionBegin;
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(TSSetFromOptions(run->ts));
  PetscCall(TSBatheCheckOptions(run->ts));
  if (duration > 0) PetscCall(TSSetMaxTime(run->ts, duration));
  PetscCall(TSGetTolerances(run->ts, &atol, NULL, &rtol, NULL));
  PetscCall(TSSetTolerances(run->ts, o->atol > 0 ? o->atol : atol, NULL, o->rtol > 0 ? o->rtol : rtol, NULL));
  PetscCall(TSGetMaxTime(run->ts, &run->tmax));
  PetscCall(PetscObjectQueryFunction((PetscObject)run->ts, "SlipTimeScale_C", &scale));
  PetscCall((*scale)(run->ts, &run->tstar));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(EnvRun *run)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&run->w));
  PetscCall(TSDestroy(&run->ts));
  PetscCall(PetscFree(run->model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the exact solution ---- */

/* A copy of the instance for constant steps: no step limits, no error estimates. */
static PetscErrorCode FineCreate(const EnvOptions *o, const EnvInstance *instance, EnvRun *fine)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(o->problem->create(o, instance, fine));
  PetscCall(TSGetAdapt(fine->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSBatheSetError(fine->ts, TSBATHE_ERROR_NONE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceCreate(const EnvOptions *o, const EnvInstance *instance, EnvReference *reference)
{
  const System *system = SystemOf(o->problem);
  EnvReference ref;
  EnvRun run;
  PetscReal steps;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ref));
  *reference = ref;
  PetscCall(o->problem->create(o, instance, &run));
  steps = PetscCeilReal(run.tmax / (o->continuation * run.tstar) * REFERENCE_FINER);
  ref->dt = run.tmax / steps;
  ref->n = (PetscInt)steps + 1;
  ref->states = system->n;
  PetscCall(PetscCalloc1((size_t)(ref->n * system->n), &ref->state));
  (*system->table)(run.model, ref->dt, ref->n, ref->state);
  PetscCall(o->problem->destroy(&run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceDestroy(EnvReference *reference)
{
  PetscFunctionBegin;
  PetscCall(PetscFree((*reference)->state));
  PetscCall(PetscFree(*reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- effects and errors ---- */

/* TSBatheAttemptFn: the L2 error of the accepted steps */
static PetscErrorCode WatchRun(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  EnvJudge j = (EnvJudge)ctx;
  const PetscScalar *a;

  PetscFunctionBegin;
  (void)ts;
  if (!attempt->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(w, &a));
  SmallErrorsStep(&j->errors, attempt->time + attempt->dt, a);
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeCreate(const EnvOptions *o, const EnvInstance *instance, EnvRun *run, PetscBool effects,
                                  EnvJudge *judge)
{
  EnvJudge j;
  Vec r;
  const PetscScalar *a;

  PetscFunctionBegin;
  PetscCall(PetscNew(&j));
  j->o = o;
  j->system = SystemOf(o->problem);
  j->run = run;
  j->effects = effects;
  PetscCall(VecGetArrayRead(run->w, &a));
  SmallErrorsStart(instance->reference, a, &j->errors);
  PetscCall(VecRestoreArrayRead(run->w, &a));
  PetscCall(TSBatheMonitorSet(run->ts, WatchRun, j, NULL));
  if (effects) {
    PetscCall(FineCreate(o, instance, &j->fine));
    PetscCall(VecDuplicate(run->w, &j->before));
    PetscCall(VecCopy(run->w, j->before));
    PetscCall(TSBatheGetReaction(run->ts, &r));
    PetscCall(VecDuplicate(r, &j->reaction));
  }
  *judge = j;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The exact solution from before the step to its end, against what the step made of it */
static PetscErrorCode JudgeStep(EnvJudge j, EnvRun *run, PetscReal t, PetscReal *effect)
{
  const PetscReal h = t - j->time,
                  n = PetscMax((PetscReal)SUBSTEPS, PetscCeilReal(h / (j->o->continuation * run->tstar)));
  PetscReal difference[SMALL_MAX_STATES];
  const PetscScalar *a, *b;
  TS ts = j->fine.ts;
  Vec r;

  PetscFunctionBegin;
  PetscCall(VecCopy(j->before, j->fine.w));
  PetscCall(TSSetTime(ts, j->time));
  PetscCall(TSSetStepNumber(ts, 0));
  PetscCall(TSSetMaxTime(ts, t));
  PetscCall(TSSetTimeStep(ts, h / n));
  PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_ITERATING));
  if (j->time > 0) PetscCall(TSBatheSetInitialReaction(ts, j->reaction));
  PetscCall(TSSolve(ts, j->fine.w));
  PetscCall(VecGetArrayRead(run->w, &a));
  PetscCall(VecGetArrayRead(j->fine.w, &b));
  for (PetscInt i = 0; i < j->system->n; ++i) difference[i] = a[i] - b[i];
  PetscCall(VecRestoreArrayRead(j->fine.w, &b));
  PetscCall(VecRestoreArrayRead(run->w, &a));
  *effect = LEAVE_WEIGHT * j->system->distance(run->model, difference);
  PetscCall(VecCopy(run->w, j->before));
  PetscCall(TSBatheGetReaction(run->ts, &r));
  PetscCall(VecCopy(r, j->reaction));
  j->time = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeErrors(EnvJudge j, EnvRun *run, PetscReal error[])
{
  PetscFunctionBegin;
  (void)run;
  SmallErrorsEnd(&j->errors, error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeDestroy(EnvJudge *judge)
{
  EnvJudge j = *judge;

  PetscFunctionBegin;
  if (!j) PetscFunctionReturn(PETSC_SUCCESS);
  if (j->effects) PetscCall(j->o->problem->destroy(&j->fine));
  PetscCall(VecDestroy(&j->before));
  PetscCall(VecDestroy(&j->reaction));
  PetscCall(PetscFree(*judge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows of the table ---- */

/* Model: what its draws, presets and creation are called after */
#define SMALL_PROBLEM(name_, meaning_, Model, draws, rtol_, atol_, unit)                                               \
  {                                                                                                                    \
    .name = (name_), .meaning = (meaning_), .draw = Model##Draws, .ndraw = (draws), .presets = Model##Presets,         \
    .rtol = (rtol_), .atol = (atol_), .atol_unit = (unit), .nerrors = 2,                                               \
    .errors = {"relative L2 norm", "relative L2 norm, the run linear between its steps"},                              \
    PROBLEM_FUNCTIONS(Model##Create)                                                                                   \
  }

/* ---- the sliding mode controller ---- */

enum { SLIDING_AMPLITUDE, SLIDING_START, SLIDING_DURATION, SLIDING_COUNT };
static const DrawRow SlidingModeDraws[SLIDING_COUNT] = {
  [SLIDING_AMPLITUDE] = {"amplitude over gain, D/k", 0.5, 1.2, PETSC_TRUE},
  [SLIDING_START] = {"start w(0) omega/k", 1, 6, PETSC_FALSE},
  [SLIDING_DURATION] = {"duration [1/omega]", 10, 30, PETSC_FALSE},
};

static PetscErrorCode SlidingModeCreate(const EnvOptions *o, const EnvInstance *instance, EnvRun *run)
{
  const PetscReal *drawn = instance->value;
  SlidingMode *m;

  PetscFunctionBegin;
  PetscCall(PetscNew(&m));
  run->model = m;
  PetscCall(SlidingModeSetFromOptions(m, 0));
  if (instance->drawn) {
    m->D = drawn[SLIDING_AMPLITUDE] * m->k;
    m->start = drawn[SLIDING_START] * m->k / m->omega;
  }
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlidingModeConfigureTS(m, run->ts));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 1, &run->w));
  PetscCall(VecSet(run->w, m->start));
  PetscCall(FinishRun(o, instance->drawn ? drawn[SLIDING_DURATION] / m->omega : 0, run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal SlidingModeDistance(const void *model, const PetscReal difference[])
{
  return PetscAbsReal(difference[0] / ((const SlidingMode *)model)->start);
}

static void SlidingModeTable(const void *model, PetscReal dt, PetscInt n, PetscReal state[])
{
  PetscReal reaction;

  for (PetscInt k = 0; k < n; ++k)
    state[k] = SlidingModeExact((const SlidingMode *)model, (PetscReal)k * dt, &reaction);
}

static PetscReal SlidingModeLoad(const void *model, PetscReal t)
{
  const SlidingMode *m = (const SlidingMode *)model;

  return m->D * PetscSinReal(m->omega * t);
}

static PetscBool SlidingModeSays(const void *model, PetscReal t, const PetscReal w[], const char name[],
                                 PetscReal *value)
{
  return SlidingModeObservation((const SlidingMode *)model, t, w[0], name, value);
}

static void SlidingModePlain(const void *model, PlainSmall *p)
{
  p->A[0] = 1;
  p->q = ((const SlidingMode *)model)->k;
  p->force = SlidingModeLoad;
  p->observe = SlidingModeSays;
}

static const System SlidingModeSystem = {1, SlidingModeDistance, SlidingModeTable, SlidingModePlain};

#define LONGEST_SLIDING_STEP 0.6283185307179586 /* 2 pi/10 of 1/omega */
static const Preset SlidingModePresets[] = {
  PRESET("published", 1e-5, "s", LONGEST_SLIDING_STEP, "T*", PETSC_FALSE, "energy", "state_0", "residual", "converged",
         "accuracy", "step"),
  PRESET("dial", 1e-3, "T*", LONGEST_SLIDING_STEP, "T*", PETSC_TRUE, "log_accuracy", "log_event", "log_state", "load",
         "bend", "rest"),
  PRESET(NULL, 0.1, "T*", LONGEST_SLIDING_STEP, "T*", PETSC_TRUE, "state_0", "log_step", "converged"),
};

const Problem ProblemSlidingMode =
  SMALL_PROBLEM("sliding_mode", "the first-order sliding mode controller of the -sliding_mode_ options", SlidingMode,
                SLIDING_COUNT, 1e-3, 1e-6, "1");

/* ---- the circuit ---- */

enum { CIRCUIT_AMPLITUDE, CIRCUIT_POLAR, CIRCUIT_AZIMUTH, CIRCUIT_DURATION, CIRCUIT_COUNT };
static const DrawRow CircuitDraws[CIRCUIT_COUNT] = {
  [CIRCUIT_AMPLITUDE] = {"root of twice the energy of the start [sqrt(J)]", 0.1, 10, PETSC_FALSE},
  [CIRCUIT_POLAR] = {"its direction: cosine of the angle to i", -1, 1, PETSC_TRUE},
  [CIRCUIT_AZIMUTH] = {"and angle from V1 to V2 [rad]", 0, 6.283185307179586, PETSC_TRUE},
  [CIRCUIT_DURATION] = {"duration [s]", 10, 20, PETSC_FALSE},
};

static PetscErrorCode CircuitCreate(const EnvOptions *o, const EnvInstance *instance, EnvRun *run)
{
  const PetscReal *drawn = instance->value;
  Circuit *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  run->model = c;
  PetscCall(CircuitSetFromOptions(c, 0));
  if (instance->drawn) {
    const PetscReal level = drawn[CIRCUIT_AMPLITUDE], cosine = drawn[CIRCUIT_POLAR],
                    rest = level * PetscSqrtReal(1 - PetscSqr(cosine));

    c->start[0] = rest * PetscCosReal(drawn[CIRCUIT_AZIMUTH]) / PetscSqrtReal(c->C1);
    c->start[1] = rest * PetscSinReal(drawn[CIRCUIT_AZIMUTH]) / PetscSqrtReal(c->C2);
    c->start[2] = level * cosine / PetscSqrtReal(c->L);
    c->max_time = drawn[CIRCUIT_DURATION];
    PetscCall(CircuitSetUnits(c, PETSC_FALSE));
  }
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(CircuitConfigureTS(c, run->ts));
  PetscCall(CircuitCreateState(c, &run->w));
  PetscCall(FinishRun(o, instance->drawn ? c->max_time : 0, run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal CircuitDistance(const void *model, const PetscReal difference[])
{
  const Circuit *c = (const Circuit *)model;

  return PetscSqrtReal(CircuitEnergy(c, difference) / CircuitEnergy(c, c->start));
}

static void CircuitTable(const void *model, PetscReal dt, PetscInt n, PetscReal state[])
{
  const Circuit *c = (const Circuit *)model;
  const PetscReal rate = 1 / (c->C1 * c->R) + 1 / (c->C2 * c->R) + 1 / PetscSqrtReal(c->L * c->C2);
  const PetscInt parts = (PetscInt)PetscCeilReal(5 * rate * dt); /* for CircuitFlow() */
  int sign = c->start[0] > 0 ? 1 : (c->start[0] < 0 ? -1 : CircuitPhaseFromRest(c, c->start));
  PetscReal w[CIRCUIT_N];

  for (PetscInt i = 0; i < CIRCUIT_N; ++i) w[i] = state[i] = c->start[i];
  for (PetscInt k = 1; k < n; ++k) {
    for (PetscInt part = 0; part < parts; ++part) CircuitAdvance(c, dt / (PetscReal)parts, &sign, w);
    for (PetscInt i = 0; i < CIRCUIT_N; ++i) state[CIRCUIT_N * k + i] = w[i];
  }
}

static PetscBool CircuitSays(const void *model, PetscReal t, const PetscReal w[], const char name[], PetscReal *value)
{
  (void)t;
  return CircuitObservation((const Circuit *)model, w, name, value);
}

static void CircuitPlain(const void *model, PlainSmall *p)
{
  const Circuit *c = (const Circuit *)model;
  const PetscReal A[] = {c->C1, c->C2, c->L}, g = 1 / c->R,
                  G[CIRCUIT_N][CIRCUIT_N] = {{-g, g, 0}, {g, -g, 1}, {0, -1, 0}};

  for (PetscInt i = 0; i < CIRCUIT_N; ++i) {
    p->A[i] = A[i];
    for (PetscInt j = 0; j < CIRCUIT_N; ++j) p->G[i][j] = G[i][j];
  }
  p->q = c->m;
  p->observe = CircuitSays;
}

static const System CircuitSystem = {CIRCUIT_N, CircuitDistance, CircuitTable, CircuitPlain};

static const Preset CircuitPresets[] = {
  PRESET("published", 1e-5, "s", 0.1, "t_max", PETSC_FALSE, "energy", "state_2", "state_0", "state_1", "residual",
         "converged", "accuracy", "step"),
  PRESET("dial", 1e-3, "T*", 5, "T*", PETSC_TRUE, "log_accuracy", "log_event", "log_time_left", "time_fraction",
         "log_energy", "log_level"),
  PRESET(NULL, 0.1, "T*", 0.1, "t_max", PETSC_TRUE, "log_energy", "state_0", "state_1", "state_2", "log_step",
         "converged"),
};

const Problem ProblemCircuit =
  SMALL_PROBLEM("circuit", "the circuit with an ideal Zener diode of the -circuit_ options", Circuit, CIRCUIT_COUNT,
                1e-6, 1e-8, "V and A");

PetscErrorCode ProblemSmallPlain(const EnvRun *run, PlainSmall *p)
{
  const System *system = SystemOf(run->problem);
  const PetscScalar *a;
  TSAdapt adapt;

  PetscFunctionBegin;
  *p = (PlainSmall){.n = system->n, .tstar = run->tstar, .tmax = run->tmax, .model = run->model};
  (*system->plain)(run->model, p);
  PetscCall(VecGetArrayRead(run->w, &a));
  PetscCall(PetscArraycpy(p->start, a, p->n));
  PetscCall(VecRestoreArrayRead(run->w, &a));
  PetscCall(TSGetAdapt(run->ts, &adapt));
  PetscCall(TSAdaptGetStepLimits(adapt, &p->dt_low, &p->dt_high));
  PetscFunctionReturn(PETSC_SUCCESS);
}
