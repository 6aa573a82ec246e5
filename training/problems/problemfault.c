/* The fault as a problem to train on: instances drawn at random or taken from the options, and their exact
   continuation. */
#include "problems.h"
#include "runs/runs.h"
#include <slipstep/rooms.h>
#include <slipcompat.h>

/* Ranges of random faults: one cell, uniform normal stress. The last row is the duration. Draws whose weakening rate
   sigma dmu/d_c is not 1.5 to 15 times the stiffness G/Ly are repeated: below, nothing slips within the duration. */
enum {
  DRAW_LENGTH,
  DRAW_THICKNESS,
  DRAW_SLIP,
  DRAW_DROP,
  DRAW_RESIDUAL,
  DRAW_DAMPING,
  DRAW_STRESS,
  DRAW_DURATION,
  DRAW_COUNT
};
static const DrawRow DrawTable[DRAW_COUNT] = {
  [DRAW_LENGTH] = {"length_x = length_z [m]", 1e3, 10e3, PETSC_FALSE},
  [DRAW_THICKNESS] = {"thickness over length", 0.7, 1.4, PETSC_FALSE},
  [DRAW_SLIP] = {"friction_slip [m]", 0.03, 0.3, PETSC_FALSE},
  [DRAW_DROP] = {"friction_drop", 0.05, 0.2, PETSC_FALSE},
  [DRAW_RESIDUAL] = {"friction_residual", 0.3, 0.6, PETSC_FALSE},
  [DRAW_DAMPING] = {"damping_ratio", 0.15, 0.5, PETSC_FALSE},
  [DRAW_STRESS] = {"normal_stress [Pa]", 5e6, 60e6, PETSC_FALSE},
  [DRAW_DURATION] = {"duration [T*]", 25, 50, PETSC_FALSE},
};
#define WEAKENING_MIN 1.5
#define WEAKENING_MAX 15
#define SHEAR_MODULUS 30e9 /* the fault's default [Pa] */

/* Weights of the effects, in units of four attempts (EFFECT_PRICE of reward.c) */
#define SLIP_WEIGHT 50 /* per relative error of the final slip: 1 % weighs as much as two attempts */
#define RATE_WEIGHT 5  /* per relative error of the peak slip rate: 10 % weigh as much as two attempts */
#define TIME_WEIGHT 10 /* per relative shift in time: 5 % weigh as much as two attempts */

/* What an exact continuation from the current state meets; it watches itself while it runs. */
typedef struct {
  PetscReal slip; /* mean slip at the end [m] */
  PetscReal rate; /* largest slip rate still to come [m/s] */
  PetscReal time; /* when the slip passes nine tenths of its end; the start of the continuation if it already has [s] */
  Table samples;  /* time and largest slip */
  PetscBool stops; /* the run, once the fault rests after having slipped */
} Future;

/* The continuation of the start. Its samples are freed. */
struct _EnvReference {
  Future start;
};

struct _EnvJudge {
  const EnvOptions *o;
  PetscBool effects;
  EnvRun fine;        /* for continuations */
  Future start;       /* exact, of the whole run */
  Future before, now; /* of the state before the last step and of the current one; before has no samples */
  Future met;         /* the run's own samples and peak */
};

static PetscBool Drawable(const PetscReal value[])
{
  const PetscReal ratio = value[DRAW_STRESS] * value[DRAW_DROP] / value[DRAW_SLIP] * value[DRAW_LENGTH] *
                          value[DRAW_THICKNESS] / SHEAR_MODULUS;

  return ratio >= WEAKENING_MIN && ratio <= WEAKENING_MAX ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode Create(const EnvOptions *o, const EnvInstance *instance, EnvRun *run)
{
  const PetscReal *v = instance->value;
  const RunOption row[] = {{"nx", 1, NULL},
                           {"nz", 1, NULL},
                           {"length_x", v[DRAW_LENGTH], NULL},
                           {"length_z", v[DRAW_LENGTH], NULL},
                           {"thickness", v[DRAW_LENGTH] * v[DRAW_THICKNESS], NULL},
                           {"shear_modulus", SHEAR_MODULUS, NULL},
                           {"friction_slip", v[DRAW_SLIP], NULL},
                           {"friction_drop", v[DRAW_DROP], NULL},
                           {"friction_residual", v[DRAW_RESIDUAL], NULL},
                           {"damping_ratio", v[DRAW_DAMPING], NULL},
                           {"normal_stress", v[DRAW_STRESS], NULL},
                           {"normal_stress_gradient", 0, NULL}};
  SlipFault fault;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  run->model = fault;
  PetscCall(SlipFaultSetString(fault, "stiffness_scaling", FAULT_SCALING));
  if (instance->drawn)
    PetscCall(RunSetOptions(fault, PETSC_STATIC_ARRAY_LENGTH(row), row));
  else
    PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultGetTimeScale(fault, &run->tstar));
  PetscCall(SlipFaultCreateState(fault, &run->w));
  PetscCall(SlipFaultSetInitialState(fault, run->w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlipFaultConfigureTS(fault, run->ts));
  if (instance->drawn) PetscCall(TSSetMaxTime(run->ts, v[DRAW_DURATION] * run->tstar));
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(SlipCheckSolverOptions(run->ts));
  PetscCall(TSSetFromOptions(run->ts));
  if (instance->drawn) PetscCall(TSSetMaxTime(run->ts, v[DRAW_DURATION] * run->tstar));
  /* the fault's own vector of absolute tolerances is 1e-6 in the units of EnvOptions */
  PetscCall(EnvSetTolerances(run->ts, o->rtol > 0 ? o->rtol : PETSC_DEFAULT, o->atol > 0 ? o->atol / 1e-6 : 1));
  PetscCall(TSGetMaxTime(run->ts, &run->tmax));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(EnvRun *run)
{
  SlipFault fault = (SlipFault)run->model;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&run->w));
  PetscCall(TSDestroy(&run->ts));
  PetscCall(SlipFaultDestroy(&fault));
  run->model = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* When the slip passes nine tenths of its last value, between samples by a straight line. */
static PetscReal FuturePassage(const Future *f)
{
  const PetscReal *s = f->samples.data, level = 0.9 * s[2 * f->samples.n - 1];

  for (PetscInt i = 1; i < f->samples.n; ++i) {
    const PetscReal *a = &s[2 * i - 2], *b = &s[2 * i];

    if (a[1] < level && b[1] >= level) return a[0] + (level - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
  }
  return s[0];
}

/* TSBatheAttemptFn: remembers rate and slip of accepted steps */
static PetscErrorCode Watch(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Future *future = (Future *)ctx;
  PetscReal rate, sample[2] = {attempt->time + attempt->dt};

  PetscFunctionBegin;
  if (!attempt->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecStrideNorm(w, 0, NORM_INFINITY, &rate));
  PetscCall(VecStrideNorm(w, 2, NORM_INFINITY, &sample[1]));
  future->rate = PetscMax(future->rate, rate);
  PetscCall(TableAdd(&future->samples, sample));
  if (future->stops && rate == 0 && sample[1] > 0) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A second copy of the fault that runs with small constant steps and no error estimate. */
static PetscErrorCode ContinuationCreate(const EnvOptions *o, const EnvInstance *instance, Future *future, EnvRun *fine)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  *future = (Future){.samples.width = 2, .stops = PETSC_TRUE};
  PetscCall(Create(o, instance, fine));
  PetscCall(TSGetAdapt(fine->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSBatheSetError(fine->ts, TSBATHE_ERROR_NONE));
  PetscCall(TSSetExactFinalTime(fine->ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSBatheMonitorSet(fine->ts, Watch, future, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Run the fault on from state w at time t with small constant steps until it rests, into the future of
   ContinuationCreate(). r: reaction, NULL at the start. */
static PetscErrorCode Continue(const EnvOptions *o, EnvRun *fine, Vec w, Vec r, PetscReal t, Future *future)
{
  SlipFaultObservables seen;
  PetscReal sample[2] = {t};

  PetscFunctionBegin;
  if (w != fine->w) PetscCall(VecCopy(w, fine->w));
  PetscCall(VecStrideNorm(w, 0, NORM_INFINITY, &future->rate));
  PetscCall(VecStrideNorm(w, 2, NORM_INFINITY, &sample[1]));
  future->samples.n = 0;
  PetscCall(TableAdd(&future->samples, sample));
  PetscCall(TSSetTime(fine->ts, t));
  PetscCall(TSSetStepNumber(fine->ts, 0));
  PetscCall(TSSetTimeStep(fine->ts, o->continuation * fine->tstar));
  PetscCall(TSSetConvergedReason(fine->ts, TS_CONVERGED_ITERATING));
  if (r) PetscCall(TSBatheSetInitialReaction(fine->ts, r));
  if (t < fine->tmax) PetscCall(TSSolve(fine->ts, fine->w));
  PetscCall(TSGetTime(fine->ts, &t));
  PetscCall(SlipFaultGetObservables((SlipFault)fine->model, t, fine->w, NULL, &seen));
  future->slip = seen.mean_slip;
  future->time = FuturePassage(future);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceCreate(const EnvOptions *o, const EnvInstance *instance, EnvReference *reference)
{
  EnvRun fine;
  Future start;

  PetscFunctionBegin;
  PetscCall(ContinuationCreate(o, instance, &start, &fine));
  PetscCall(Continue(o, &fine, fine.w, NULL, 0, &start));
  PetscCheck(start.slip > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONGSTATE,
             "This fault does not slip in %g s: errors of its steps need one that does", (double)fine.tmax);
  PetscCall(Destroy(&fine));
  PetscCall(TableClear(&start.samples));
  PetscCall(PetscNew(reference));
  (*reference)->start = start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceDestroy(EnvReference *reference)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(*reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeCreate(const EnvOptions *o, const EnvInstance *instance, EnvRun *run, PetscBool effects,
                                  EnvJudge *judge)
{
  const PetscReal sample[2] = {0, 0};
  EnvJudge j;

  PetscFunctionBegin;
  PetscCall(PetscNew(&j));
  j->o = o;
  j->met.samples.width = 2;
  j->effects = effects;
  j->before = j->start = instance->reference->start;
  if (effects) PetscCall(ContinuationCreate(o, instance, &j->now, &j->fine));
  PetscCall(TableAdd(&j->met.samples, sample));
  PetscCall(TSBatheMonitorSet(run->ts, Watch, &j->met, NULL));
  *judge = j;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the step changed what an exact continuation meets. A peak or a passage that lies inside the step or behind it is
   not judged. */
static PetscErrorCode JudgeStep(EnvJudge j, EnvRun *run, PetscReal t, PetscReal *effect)
{
  PetscReal rate, slip_error, rate_error, time_error;
  Vec r;

  PetscFunctionBegin;
  PetscCall(TSBatheGetReaction(run->ts, &r));
  PetscCall(Continue(j->o, &j->fine, run->w, r, t, &j->now));
  PetscCall(VecStrideNorm(run->w, 0, NORM_INFINITY, &rate));
  slip_error = PetscAbsReal(j->now.slip - j->before.slip) / j->start.slip;
  rate_error = rate < j->now.rate ? PetscAbsReal(j->now.rate - j->before.rate) / j->start.rate : 0;
  time_error = t < j->now.time ? PetscAbsReal(j->now.time - j->before.time) / j->start.time : 0;
  j->before = j->now;
  *effect = SLIP_WEIGHT * slip_error + RATE_WEIGHT * rate_error + TIME_WEIGHT * time_error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Signed, so that a bias over many runs can be told from scatter. */
static PetscErrorCode JudgeErrors(EnvJudge j, EnvRun *run, PetscReal error[])
{
  SlipFaultObservables seen;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(TSGetTime(run->ts, &t));
  PetscCall(SlipFaultGetObservables((SlipFault)run->model, t, run->w, NULL, &seen));
  error[0] = seen.mean_slip / j->start.slip - 1;
  error[1] = j->met.rate / j->start.rate - 1;
  error[2] = FuturePassage(&j->met) / j->start.time - 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeDestroy(EnvJudge *judge)
{
  EnvJudge j = *judge;

  PetscFunctionBegin;
  if (!j) PetscFunctionReturn(PETSC_SUCCESS);
  if (j->effects) PetscCall(Destroy(&j->fine));
  PetscCall(TableClear(&j->now.samples));
  PetscCall(TableClear(&j->met.samples));
  PetscCall(PetscFree(*judge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Preset Presets[] = {
  PRESET("published", 1e-6, "T*", 6, "s", PETSC_FALSE, "energy", "velocity", "residual", "converged", "accuracy",
         "step"),
  /* no error: the same steps whatever the tolerances and estimates, and no step doubling to pay for */
  PRESET("balanced", 1e-2, "T*", 14, "T*", PETSC_TRUE, "energy", "log_velocity", "slip", "log_step", "converged"),
  PRESET(NULL, 1e-2, "T*", 14, "T*", PETSC_TRUE, "energy", "log_velocity", "slip", "log_error", "log_step",
         "converged"),
};

const Problem ProblemFault = {.name = "fault",
                              .meaning = "the strike-slip fault of the -fault_ options; drawn: one cell",
                              PROBLEM_DRAWS(DrawTable),
                              .drawable = Drawable,
                              .presets = Presets,
                              .rtol = 1e-3,
                              .atol = 1e-6,
                              .atol_unit = "0.1 mm for slip and 0.1 mm/T* for slip rate",
                              PROBLEM_ERRORS("final mean slip", "peak slip rate", "time of nine tenths of the slip"),
                              PROBLEM_FUNCTIONS,
                              .cma = &CMAFault,
                              .evaluation = &EvaluationFault};
