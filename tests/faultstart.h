/* The start of a test's run: a fault whose parameters are set, at its initial state. */
#pragma once
#include <slipstep.h>
#include <slipcompat.h>

/* The fault set up, its state, and a TS of it up to time end [s] under a type of TSAdapt; dt [s] is the first step, and
   every step of TSADAPTNONE; 0 leaves it to the fault. */
static inline PetscErrorCode FaultStart(SlipFault fault, TSAdaptType type, PetscReal dt, PetscReal end, Vec *w, TS *ts)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, w));
  PetscCall(SlipFaultSetInitialState(fault, *w));
  PetscCall(TSCreate(PetscObjectComm((PetscObject)*w), ts));
  PetscCall(SlipFaultConfigureTS(fault, *ts));
  PetscCall(TSGetAdapt(*ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, type));
  if (dt > 0) PetscCall(TSSetTimeStep(*ts, dt));
  PetscCall(TSSetMaxTime(*ts, end));
  PetscFunctionReturn(PETSC_SUCCESS);
}
