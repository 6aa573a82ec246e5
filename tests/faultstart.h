/* The start of a test's run: a fault whose parameters are set, at its initial state. */
#pragma once
#include <slipstep/rooms.h>
#include <slipcompat.h>

typedef struct {
  const char *name;
  PetscReal value;
} FaultReal;

typedef struct {
  const char *name, *value;
} FaultString;

/* SlipFaultSetReal() and SlipFaultSetString() of several: FaultSetReals(fault, {"nx", 3}, {"nz", 2}) */
#define FaultSetReals(fault, ...)                                                                                      \
  FaultSetRealRows(fault, sizeof((const FaultReal[]){__VA_ARGS__}) / sizeof(FaultReal),                                \
                   (const FaultReal[]){__VA_ARGS__})
#define FaultSetStrings(fault, ...)                                                                                    \
  FaultSetStringRows(fault, sizeof((const FaultString[]){__VA_ARGS__}) / sizeof(FaultString),                          \
                     (const FaultString[]){__VA_ARGS__})
static inline PetscErrorCode FaultSetRealRows(SlipFault fault, size_t n, const FaultReal row[])
{
  for (size_t i = 0; i < n; i++) PetscCall(SlipFaultSetReal(fault, row[i].name, row[i].value));
  return PETSC_SUCCESS;
}

static inline PetscErrorCode FaultSetStringRows(SlipFault fault, size_t n, const FaultString row[])
{
  for (size_t i = 0; i < n; i++) PetscCall(SlipFaultSetString(fault, row[i].name, row[i].value));
  return PETSC_SUCCESS;
}

static inline PetscErrorCode FaultSetUpState(SlipFault fault, Vec *w)
{
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, w));
  return SlipFaultSetInitialState(fault, *w);
}

/* The fault set up, its state, and a TS of it up to time end [s] under a type of TSAdapt; dt [s] is the first step, and
   every step of TSADAPTNONE; NULL and 0 leave these to the fault. */
static inline PetscErrorCode FaultStart(SlipFault fault, TSAdaptType type, PetscReal dt, PetscReal end, Vec *w, TS *ts)
{
  TSAdapt adapt;

  PetscCall(FaultSetUpState(fault, w));
  PetscCall(TSCreate(PetscObjectComm((PetscObject)*w), ts));
  PetscCall(SlipFaultConfigureTS(fault, *ts));
  PetscCall(TSGetAdapt(*ts, &adapt));
  if (type) PetscCall(TSAdaptSetType(adapt, type));
  if (dt > 0) PetscCall(TSSetTimeStep(*ts, dt));
  if (end > 0) PetscCall(TSSetMaxTime(*ts, end));
  return PETSC_SUCCESS;
}
