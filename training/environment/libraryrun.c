/* Runs of the library itself, see libraryrun.h. */
#include "libraryrun.h"
#include <slipcompat.h>

PetscErrorCode RunSetController(TS ts, SlipPolicy policy, PetscReal accuracy, TSAdaptType type, PetscReal rtol)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  if (policy) {
    PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
    PetscCall(TSAdaptRLSetPolicy(adapt, policy));
    PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
    PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
  } else {
    PetscCall(SlipAdaptSetController(adapt, type));
    PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, rtol, NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunSolve(TS ts, Vec w, PetscBool *solved)
{
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = TSSolve(ts, w);
  PetscCall(PetscPopErrorHandler());
  *solved = code ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
