/* What controllers ask of the problem that a TS integrates: one table of operations, carried by the TS. */
#include <slipts.h>
#include <petsc/private/petscimpl.h>
#include <slipcompat.h>

/*@C
  TSSetSlipProblem - say what controllers may ask of the problem that a TS integrates

  Logically collective

  Input Parameters:
+ ts      - the TS
- problem - its operations, borrowed: they must live as long as ts

  Level: developer

.seealso: TSGetSlipProblem(), SlipObservationView(), TSADAPTRL
@*/
PetscErrorCode TSSetSlipProblem(TS ts, const SlipProblemOps *problem)
{
  PetscContainer container;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscContainerCreate(PetscObjectComm((PetscObject)ts), &container));
  PetscCall(PetscContainerSetPointer(container, (void *)(uintptr_t)problem));
  PetscCall(PetscObjectCompose((PetscObject)ts, "SlipProblem", (PetscObject)container));
  PetscCall(PetscContainerDestroy(&container));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSGetSlipProblem - what controllers may ask of the problem that a TS integrates

  Not collective

  Input Parameter:
. ts - the TS

  Output Parameter:
. problem - its operations, borrowed; `NULL` when there are none

  Level: developer

.seealso: TSSetSlipProblem()
@*/
PetscErrorCode TSGetSlipProblem(TS ts, const SlipProblemOps **problem)
{
  PetscContainer container;
  void *pointer = NULL;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscObjectQuery((PetscObject)ts, "SlipProblem", (PetscObject *)&container));
  if (container) PetscCall(PetscContainerGetPointer(container, &pointer));
  *problem = (const SlipProblemOps *)pointer;
  PetscFunctionReturn(PETSC_SUCCESS);
}
