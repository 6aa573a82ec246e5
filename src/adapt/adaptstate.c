/* The memory of controllers, for checkpoints: our types compose a function, and this file covers PETSc's types. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipstate.h>

/* TSADAPTDSP has no getters for its memory, so this is a copy of its context in src/ts/adapt/impls/dsp/adaptdsp.c,
   which is the same in PETSc 3.8 to 3.25. Without it a continued run with the default controller of loaded faults would
   differ from an unbroken one (tests/integration/restarts.py). CheckDSP() compares a new context with it, number by
   number, before it is used. */
typedef struct {
  PetscReal kBeta[3], Alpha[2];   /* the filter */
  PetscReal cerror[3], hratio[3]; /* errors and ratios of earlier steps */
  PetscBool rollback;
} TSAdapt_DSP;

static PetscErrorCode CheckDSP(TSAdapt adapt)
{
  const PetscReal expected[] = {0.5 + 0.25 + 0.125, -(0.25 + 2 * 0.125), 0.125, 0, 0, 1, 1, 1, 1, 1, 1};
  MPI_Comm comm = PetscObjectComm((PetscObject)adapt);
  const TSAdapt_DSP *dsp;
  PetscBool same = PETSC_TRUE;
  TSAdapt fresh;

  PetscFunctionBegin;
  PetscCall(TSAdaptCreate(PETSC_COMM_SELF, &fresh));
  PetscCall(TSAdaptSetType(fresh, TSADAPTDSP));
  PetscCall(TSAdaptDSPSetPID(fresh, 0.5, 0.25, 0.125)); /* kBeta, and no Alpha */
  dsp = (const TSAdapt_DSP *)fresh->data;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(expected); i++)
    if (((const PetscReal *)dsp)[i] != expected[i]) same = PETSC_FALSE;
  if (dsp->rollback) same = PETSC_FALSE;
  PetscCall(TSAdaptDestroy(&fresh));
  PetscCheck(same, comm, PETSC_ERR_SUP,
             "a checkpoint cannot hold the memory of -ts_adapt_type dsp of this version of PETSc: take pi, or none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipState_DSP(TSAdapt adapt, SlipState s)
{
  TSAdapt_DSP *dsp = (TSAdapt_DSP *)adapt->data;

  PetscFunctionBegin;
  PetscCall(CheckDSP(adapt));
  PetscCall(SlipStateReal(s, "errors", 3, dsp->cerror));
  PetscCall(SlipStateReal(s, "ratios", 3, dsp->hratio));
  PetscCall(SlipStateBool(s, "rollback", &dsp->rollback));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits a controller of any type; if the file has another type, the controller starts without memory. */
PetscErrorCode SlipStateController(SlipState s, const char name[], TSAdapt adapt)
{
  PetscBool dsp;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTDSP, &dsp));
  if (dsp) PetscCall(PetscObjectComposeFunction((PetscObject)adapt, SLIP_STATE_METHOD, SlipState_DSP));
  PetscCall(SlipStateObject(s, name, (PetscObject)adapt));
  if (dsp) PetscCall(PetscObjectComposeFunction((PetscObject)adapt, SLIP_STATE_METHOD, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective; called between two steps, after SlipStateTS() */
PetscErrorCode SlipStateAdapt(SlipState s, TS ts)
{
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  if (SlipStateIsLoading(s)) PetscTryMethod(adapt, "TSAdaptResume_C", (TSAdapt, TS), (adapt, ts));
  PetscCall(SlipStateController(s, "adapt", adapt));
  PetscCall(SlipStateInt(s, "just_decreased", 1, &adapt->timestepjustdecreased));
  PetscFunctionReturn(PETSC_SUCCESS);
}
