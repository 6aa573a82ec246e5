/* Faults for training: drawn at random or taken from the options, and their exact continuation. */
#include "environment.h"
#include <slipstep/private/slipcompat.h>

/* Ranges of random faults: one element, uniform normal stress. The last row is the duration. Draws whose weakening rate
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
static const struct {
  const char *meaning;
  PetscReal low, high;
} DrawTable[DRAW_COUNT] = {
  [DRAW_LENGTH] = {"length_x = length_z [m]", 1e3, 10e3}, [DRAW_THICKNESS] = {"thickness over length", 0.7, 1.4},
  [DRAW_SLIP] = {"friction_slip [m]", 0.03, 0.3},         [DRAW_DROP] = {"friction_drop", 0.05, 0.2},
  [DRAW_RESIDUAL] = {"friction_residual", 0.3, 0.6},      [DRAW_DAMPING] = {"damping_ratio", 0.15, 0.5},
  [DRAW_STRESS] = {"normal_stress [Pa]", 5e6, 60e6},      [DRAW_DURATION] = {"duration [T*]", 25, 50},
};
#define WEAKENING_MIN 1.5
#define WEAKENING_MAX 15
#define SHEAR_MODULUS 30e9 /* the fault's default [Pa] */

PetscInt EnvDrawCount(void)
{
  return DRAW_COUNT;
}

PetscErrorCode EnvDescribeDraw(char text[], size_t len)
{
  char row[96];

  PetscFunctionBegin;
  text[0] = 0;
  for (PetscInt i = 0; i < DRAW_COUNT; ++i) {
    PetscCall(PetscSNPrintf(row, sizeof(row), "%s%s %.6g..%.6g", i ? ", " : "", DrawTable[i].meaning,
                            (double)DrawTable[i].low, (double)DrawTable[i].high));
    PetscCall(PetscStrlcat(text, row, len));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvDrawFault(Random *random, PetscInt n, PetscReal value[])
{
  PetscReal ratio;

  PetscFunctionBegin;
  PetscCheck(n == DRAW_COUNT, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%" PetscInt_FMT " drawn parameters, expected %d", n,
             DRAW_COUNT);
  do {
    for (PetscInt i = 0; i < n; ++i) value[i] = (PetscReal)RandomLog(random, DrawTable[i].low, DrawTable[i].high);
    ratio = value[DRAW_STRESS] * value[DRAW_DROP] / value[DRAW_SLIP] * value[DRAW_LENGTH] * value[DRAW_THICKNESS] /
            SHEAR_MODULUS;
  } while (ratio < WEAKENING_MIN || ratio > WEAKENING_MAX);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetDrawn(SlipFault fault, const PetscReal value[])
{
  PetscFunctionBegin;
  PetscCall(SlipFaultSetReal(fault, "nx", 1));
  PetscCall(SlipFaultSetReal(fault, "nz", 1));
  PetscCall(SlipFaultSetReal(fault, "length_x", value[DRAW_LENGTH]));
  PetscCall(SlipFaultSetReal(fault, "length_z", value[DRAW_LENGTH]));
  PetscCall(SlipFaultSetReal(fault, "thickness", value[DRAW_LENGTH] * value[DRAW_THICKNESS]));
  PetscCall(SlipFaultSetReal(fault, "shear_modulus", SHEAR_MODULUS));
  PetscCall(SlipFaultSetReal(fault, "friction_slip", value[DRAW_SLIP]));
  PetscCall(SlipFaultSetReal(fault, "friction_drop", value[DRAW_DROP]));
  PetscCall(SlipFaultSetReal(fault, "friction_residual", value[DRAW_RESIDUAL]));
  PetscCall(SlipFaultSetReal(fault, "damping_ratio", value[DRAW_DAMPING]));
  PetscCall(SlipFaultSetReal(fault, "normal_stress", value[DRAW_STRESS]));
  PetscCall(SlipFaultSetReal(fault, "normal_stress_gradient", 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fault's own vector of absolute tolerances is 1e-6 in the units of EnvOptions: scale it. */
static PetscErrorCode SetTolerances(const EnvOptions *o, TS ts)
{
  Vec vatol, scaled;
  PetscReal rtol, atol;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, &atol, &vatol, &rtol, NULL));
  if (o->rtol > 0) rtol = o->rtol;
  if (o->atol > 0 && vatol) {
    PetscCall(VecDuplicate(vatol, &scaled));
    PetscCall(VecCopy(vatol, scaled));
    PetscCall(VecScale(scaled, o->atol / 1e-6));
    PetscCall(TSSetTolerances(ts, atol, scaled, rtol, NULL));
    PetscCall(VecDestroy(&scaled));
  } else
    PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, rtol, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvRunCreate(const EnvOptions *o, const PetscReal drawn[], EnvRun *run)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &run->fault));
  if (drawn)
    PetscCall(SetDrawn(run->fault, drawn));
  else
    PetscCall(SlipFaultSetFromOptions(run->fault));
  PetscCall(SlipFaultSetUp(run->fault));
  PetscCall(SlipFaultGetTimeScale(run->fault, &run->tstar));
  PetscCall(SlipFaultCreateState(run->fault, &run->w));
  PetscCall(SlipFaultSetInitialState(run->fault, run->w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlipFaultConfigureTS(run->fault, run->ts));
  if (drawn) PetscCall(TSSetMaxTime(run->ts, drawn[DRAW_DURATION] * run->tstar));
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(TSSetFromOptions(run->ts));
  if (drawn) PetscCall(TSSetMaxTime(run->ts, drawn[DRAW_DURATION] * run->tstar));
  PetscCall(SetTolerances(o, run->ts));
  PetscCall(TSGetMaxTime(run->ts, &run->tmax));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvRunDestroy(EnvRun *run)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&run->w));
  PetscCall(TSDestroy(&run->ts));
  PetscCall(SlipFaultDestroy(&run->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FutureAppend(EnvFuture *f, PetscReal t, PetscReal slip)
{
  PetscFunctionBegin;
  if (f->n == f->capacity) {
    f->capacity = f->capacity ? 2 * f->capacity : 256;
    PetscCall(PetscRealloc(sizeof(PetscReal) * 2 * (size_t)f->capacity, &f->sample));
  }
  f->sample[2 * f->n] = t;
  f->sample[2 * f->n++ + 1] = slip;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* When the slip passes nine tenths of its last value, between samples by a straight line. */
static PetscReal FuturePassage(const EnvFuture *f)
{
  const PetscReal *s = f->sample, level = 0.9 * s[2 * f->n - 1];

  for (PetscInt i = 1; i < f->n; ++i) {
    const PetscReal *a = &s[2 * i - 2], *b = &s[2 * i];

    if (a[1] < level && b[1] >= level) return a[0] + (level - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
  }
  return s[0];
}

/* Remembers rate and slip and stops the continuation once the fault rests after having slipped. */
static PetscErrorCode WatchContinuation(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  EnvFuture *future = (EnvFuture *)ctx;
  PetscReal rate, slip;

  PetscFunctionBegin;
  if (!attempt->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecStrideNorm(w, 0, NORM_INFINITY, &rate));
  PetscCall(VecStrideNorm(w, 2, NORM_INFINITY, &slip));
  future->rate = PetscMax(future->rate, rate);
  PetscCall(FutureAppend(future, attempt->time + attempt->dt, slip));
  if (rate == 0 && slip > 0) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A second copy of the fault that runs with small constant steps and no error estimate. */
PetscErrorCode EnvContinuationCreate(const EnvOptions *o, const PetscReal drawn[], EnvFuture *future, EnvRun *fine)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(EnvRunCreate(o, drawn, fine));
  PetscCall(TSGetAdapt(fine->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSBatheSetError(fine->ts, TSBATHE_ERROR_NONE));
  PetscCall(TSSetExactFinalTime(fine->ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSBatheAddAttemptMonitor(fine->ts, WatchContinuation, future));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvContinue(const EnvOptions *o, EnvRun *fine, Vec w, Vec r, PetscReal t, EnvFuture *future)
{
  SlipFaultObservables seen;
  PetscReal slip;

  PetscFunctionBegin;
  PetscCall(VecCopy(w, fine->w));
  PetscCall(VecStrideNorm(w, 0, NORM_INFINITY, &future->rate));
  PetscCall(VecStrideNorm(w, 2, NORM_INFINITY, &slip));
  future->n = 0;
  PetscCall(FutureAppend(future, t, slip));
  PetscCall(TSSetTime(fine->ts, t));
  PetscCall(TSSetStepNumber(fine->ts, 0));
  PetscCall(TSSetTimeStep(fine->ts, o->continuation * fine->tstar));
  PetscCall(TSSetConvergedReason(fine->ts, TS_CONVERGED_ITERATING));
  if (r) PetscCall(TSBatheSetInitialReaction(fine->ts, r));
  if (t < fine->tmax) PetscCall(TSSolve(fine->ts, fine->w));
  PetscCall(SlipFaultGetObservables(fine->fault, fine->w, NULL, &seen));
  future->slip = seen.mean_slip;
  future->time = FuturePassage(future);
  PetscFunctionReturn(PETSC_SUCCESS);
}
