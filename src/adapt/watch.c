/* Records attempts of integrators that do not record them, such as PETSc's, by what they pass to their controller and
   what it returns. It is not called for attempts that failed in a stage. These count among the rejections of the TS,
   and each shortens the step by the factor of TSAdaptSetScaleSolveFailed(), from which their steps follow. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipsys.h>

static const char key[] = "SlipAdaptWatch";

typedef struct {
  PetscErrorCode (*choose)(TSAdapt, TS, PetscReal, PetscInt *, PetscReal *, PetscBool *, PetscReal *, PetscReal *,
                           PetscReal *); /* of the controller */
  SlipAdaptWatchFn told;
  PetscInt rejected; /* reported attempts */
} Watch;

static PetscErrorCode TSAdaptChoose_Watched(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                            PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  PetscInt rejected;
  Watch *watch;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)adapt, key, &watch));
  PetscCall((*watch->choose)(adapt, ts, h, next_sc, next_h, accept, wlte, wltea, wlter));
  PetscCall(TSGetStepRejections(ts, &rejected));
  for (; watch->rejected < rejected; watch->rejected++) /* those that failed in a stage */
    PetscCall((*watch->told)(
      ts, &(SlipAttempt){.time = ts->ptime,
                         .dt = h / PetscPowReal(adapt->scale_solve_failed, (PetscReal)(rejected - watch->rejected)),
                         .error = -1}));
  if (!*accept) watch->rejected++;
  PetscCall((*watch->told)(
    ts, &(SlipAttempt){.time = ts->ptime, .dt = h, .converged = PETSC_TRUE, .accepted = *accept, .error = *wlte}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipAdaptWatch - calls a function for each attempt of a TS with its controller from now on; to be called between
  steps, and again if the type of the controller may have changed since
*/
PetscErrorCode SlipAdaptWatch(TS ts, SlipAdaptWatchFn told)
{
  TSAdapt adapt;
  Watch *watch;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipObjectQueryData((PetscObject)adapt, key, &watch));
  if (!watch) {
    PetscCall(PetscNew(&watch));
    PetscCall(SlipObjectComposeData((PetscObject)adapt, key, watch, SlipContainerDestroyDefault));
  }
  PetscCall(TSGetStepRejections(ts, &watch->rejected));
  watch->told = told;
  if (!adapt->ops->choose || adapt->ops->choose == TSAdaptChoose_Watched) PetscFunctionReturn(PETSC_SUCCESS);
  watch->choose = adapt->ops->choose;
  adapt->ops->choose = TSAdaptChoose_Watched;
  PetscFunctionReturn(PETSC_SUCCESS);
}
