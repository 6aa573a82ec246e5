/* Runs of the library itself, see libraryrun.h. */
#include "libraryrun.h"
#include <slipcompat.h>

/* "pi", or "pi:fault_history": a type, and its filter where it has named ones */
static PetscErrorCode SetClassical(TSAdapt adapt, const char name[])
{
  char type[64], *filter;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(type, name, sizeof(type)));
  PetscCall(PetscStrchr(type, ':', &filter));
  if (filter) *filter++ = 0;
  PetscCall(TSAdaptSetType(adapt, type));
  if (!filter) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptPISetFilter(adapt, filter));
  PetscCall(TSAdaptDSPSetFilter(adapt, filter));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
    PetscCall(SetClassical(adapt, type));
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
