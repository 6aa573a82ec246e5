/* Small systems as problems to train on: the sliding mode controller and the circuit, with the models of slipmodels.h.
   Both are dissipative: two solutions of the same system approach each other in the norm of the energy. So the error
   that a step leaves at its end bounds what it changes in the exact continuation, and the sum of these errors bounds
   that of the run. */
#include "problems.h"
#include "environment/plainsmall.h"
#include <slipstep/rooms/slipmodels.h>
#include <slipcompat.h>

#define LEAVE_WEIGHT                                                                                                   \
  50                /* per error that a step leaves, over the size of the start: 1 % weighs as much as two attempts */
#define SUBSTEPS 16 /* of the exact solution across one step, at least */
#define REFERENCE_FINER 8 /* step of continuations over that of the table of the exact solution */

struct _EnvJudge {
  const EnvOptions *o;
  EnvRun *run;
  PetscBool effects;
  EnvRun fine;          /* crosses one step after the other */
  Vec before, reaction; /* where the next step begins */
  PetscReal time;
  SmallErrors errors;
};

/* ---- creation ---- */

static PetscErrorCode Create(const EnvOptions *o, const EnvInstance *instance, EnvRun *run)
{
  PetscReal rtol, atol;
  SlipModel model;

  PetscFunctionBegin;
  PetscCall(SlipModelCreate(o->problem->model, SLIP_MODEL_TRAINING, &model));
  run->model = model;
  PetscCall(SlipModelSetFromOptions(model));
  if (instance->drawn) {
    o->problem->apply(instance->value, model);
    PetscCall(SlipModelSetUp(model));
  }
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlipModelConfigureTS(model, run->ts));
  PetscCall(SlipModelCreateState(model, &run->w));
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(SlipCheckSolverOptions(run->ts));
  PetscCall(TSSetFromOptions(run->ts));
  PetscCall(TSBatheCheckOptions(run->ts));
  if (instance->drawn) PetscCall(TSSetMaxTime(run->ts, model->max_time));
  PetscCall(TSGetTolerances(run->ts, &atol, NULL, &rtol, NULL));
  PetscCall(TSSetTolerances(run->ts, o->atol > 0 ? o->atol : atol, NULL, o->rtol > 0 ? o->rtol : rtol, NULL));
  PetscCall(TSGetMaxTime(run->ts, &run->tmax));
  run->tstar = model->tstar;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(EnvRun *run)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&run->w));
  PetscCall(TSDestroy(&run->ts));
  PetscCall(SlipModelDestroy((SlipModel *)&run->model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the exact solution ---- */

static PetscErrorCode ReferenceCreate(const EnvOptions *o, const EnvInstance *instance, EnvReference *reference)
{
  EnvReference ref;
  EnvRun run;
  PetscReal steps;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ref));
  *reference = ref;
  PetscCall(Create(o, instance, &run));
  steps = PetscCeilReal(run.tmax / (o->continuation * run.tstar) * REFERENCE_FINER);
  ref->dt = run.tmax / steps;
  ref->n = (PetscInt)steps + 1;
  ref->states = ((SlipModel)run.model)->ops->n;
  PetscCall(PetscCalloc1((size_t)(ref->n * ref->states), &ref->state));
  SlipModelExactTable((SlipModel)run.model, ref->dt, ref->n, ref->state);
  PetscCall(Destroy(&run));
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
  TSAdapt adapt;
  EnvJudge j;
  Vec r;
  const PetscScalar *a;

  PetscFunctionBegin;
  PetscCall(PetscNew(&j));
  j->o = o;
  j->run = run;
  j->effects = effects;
  PetscCall(VecGetArrayRead(run->w, &a));
  SmallErrorsStart(instance->reference, a, &j->errors);
  PetscCall(VecRestoreArrayRead(run->w, &a));
  PetscCall(TSBatheMonitorSet(run->ts, WatchRun, j, NULL));
  if (effects) {
    PetscCall(Create(o, instance, &j->fine)); /* for constant steps: no step limits, no error estimates */
    PetscCall(TSGetAdapt(j->fine.ts, &adapt));
    PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
    PetscCall(TSBatheSetError(j->fine.ts, TSBATHE_ERROR_NONE));
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
  const SlipModel model = (SlipModel)run->model;
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
  for (PetscInt i = 0; i < model->ops->n; ++i) difference[i] = a[i] - b[i];
  PetscCall(VecRestoreArrayRead(j->fine.w, &b));
  PetscCall(VecRestoreArrayRead(run->w, &a));
  /* the norm of the difference over that of the start */
  *effect =
    LEAVE_WEIGHT * (model->ops->n == 1
                      ? PetscAbsReal(difference[0] / model->start[0])
                      : PetscSqrtReal(SlipModelEnergy(model, difference) / SlipModelEnergy(model, model->start)));
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
  if (j->effects) PetscCall(Destroy(&j->fine));
  PetscCall(VecDestroy(&j->before));
  PetscCall(VecDestroy(&j->reaction));
  PetscCall(PetscFree(*judge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows of the table ---- */

#define SMALL_PROBLEM(Model, rtol_, atol_, unit)                                                                       \
  .model = &Slip##Model##Ops, .cma = &CMASmall, .evaluation = &Evaluation##Model, PROBLEM_DRAWS(Model##Draws),         \
  .apply = Apply##Model, .presets = Model##Presets, .rtol = rtol_, .atol = atol_, .atol_unit = unit,                   \
  PROBLEM_ERRORS("relative L2 norm", "relative L2 norm, the run linear between its steps"), PROBLEM_FUNCTIONS

enum { SLIDING_AMPLITUDE, SLIDING_START, SLIDING_DURATION, SLIDING_COUNT };
static const DrawRow SlidingModeDraws[SLIDING_COUNT] = {
  [SLIDING_AMPLITUDE] = {"amplitude over gain, D/k", 0.5, 1.2, PETSC_TRUE},
  [SLIDING_START] = {"start w(0) omega/k", 1, 6, PETSC_FALSE},
  [SLIDING_DURATION] = {"duration [1/omega]", 10, 30, PETSC_FALSE},
};

static void ApplySlidingMode(const PetscReal drawn[], void *model)
{
  SlipSlidingMode *m = (SlipSlidingMode *)model;

  m->D = drawn[SLIDING_AMPLITUDE] * m->k;
  m->model.start[0] = drawn[SLIDING_START] * m->k / m->omega;
  m->model.max_time = drawn[SLIDING_DURATION] / m->omega;
}

#define LONGEST_SLIDING_STEP 0.6283185307179586 /* 2 pi/10 of 1/omega */
static const Preset SlidingModePresets[] = {
  PRESET("published", 1e-5, "s", LONGEST_SLIDING_STEP, "T*", PETSC_FALSE, "energy", "state_0", "residual", "converged",
         "accuracy", "step"),
  PRESET("dial", 1e-3, "T*", LONGEST_SLIDING_STEP, "T*", PETSC_TRUE, "log_accuracy", "log_event", "log_state", "load",
         "bend", "rest"),
  PRESET(NULL, 0.1, "T*", LONGEST_SLIDING_STEP, "T*", PETSC_TRUE, "state_0", "log_step", "converged"),
};

const Problem ProblemSlidingMode = {.name = "sliding_mode",
                                    .meaning = "the first-order sliding mode controller of the -sliding_mode_ options",
                                    SMALL_PROBLEM(SlidingMode, 1e-3, 1e-6, "1")};

enum { CIRCUIT_AMPLITUDE, CIRCUIT_POLAR, CIRCUIT_AZIMUTH, CIRCUIT_DURATION, CIRCUIT_COUNT };
static const DrawRow CircuitDraws[CIRCUIT_COUNT] = {
  [CIRCUIT_AMPLITUDE] = {"root of twice the energy of the start [sqrt(J)]", 0.1, 10, PETSC_FALSE},
  [CIRCUIT_POLAR] = {"its direction: cosine of the angle to i", -1, 1, PETSC_TRUE},
  [CIRCUIT_AZIMUTH] = {"and angle from V1 to V2 [rad]", 0, 6.283185307179586, PETSC_TRUE},
  [CIRCUIT_DURATION] = {"duration [s]", 10, 20, PETSC_FALSE},
};

static void ApplyCircuit(const PetscReal drawn[], void *model)
{
  SlipCircuit *c = (SlipCircuit *)model;
  const PetscReal level = drawn[CIRCUIT_AMPLITUDE], cosine = drawn[CIRCUIT_POLAR],
                  rest = level * PetscSqrtReal(1 - PetscSqr(cosine));

  c->model.start[0] = rest * PetscCosReal(drawn[CIRCUIT_AZIMUTH]) / PetscSqrtReal(c->C1);
  c->model.start[1] = rest * PetscSinReal(drawn[CIRCUIT_AZIMUTH]) / PetscSqrtReal(c->C2);
  c->model.start[2] = level * cosine / PetscSqrtReal(c->L);
  c->model.max_time = drawn[CIRCUIT_DURATION];
  c->unit_start = PETSC_FALSE;
}

static const Preset CircuitPresets[] = {
  PRESET("published", 1e-5, "s", 0.1, "t_max", PETSC_FALSE, "energy", "state_2", "state_0", "state_1", "residual",
         "converged", "accuracy", "step"),
  PRESET("dial", 1e-3, "T*", 5, "T*", PETSC_TRUE, "log_accuracy", "log_event", "log_time_left", "time_fraction",
         "log_energy", "log_level"),
  PRESET(NULL, 0.1, "T*", 0.1, "t_max", PETSC_TRUE, "log_energy", "state_0", "state_1", "state_2", "log_step",
         "converged"),
};

const Problem ProblemCircuit = {.name = "circuit",
                                .meaning = "the circuit with an ideal Zener diode of the -circuit_ options",
                                SMALL_PROBLEM(Circuit, 1e-6, 1e-8, "V and A")};
