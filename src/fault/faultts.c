/* The fault as a TS problem. */
#include <slipstep/private/slipfault.h>

#define SLIP_FAULT_RTOL 1e-3     /* reference tolerance, as SLIP_FAULT_ATOL */
#define SLIP_FAULT_MAX_TIME 30.0 /* [s] */
/* First step over T*: the instability grows from a relative excess of 1e-5, so anything well below T* is safe. */
#define SLIP_FAULT_FIRST_STEP 0.01

static PetscErrorCode SlipFaultOfTS(TS ts, SlipFault *fault)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectQuery((PetscObject)ts, "SlipFault", (PetscObject *)fault));
  PetscCheck(*fault, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_WRONGSTATE,
             "this TS was not configured by a fault");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rows that read the integrator's estimates have them summed up first. */
static PetscErrorCode SlipFaultTakeEstimates(SlipFault fault, TS ts, Vec w, const char name[])
{
  Vec error, derivative;
  PetscBool reads_error, reads_growth;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(name, "log_slip_error", &reads_error));
  PetscCall(PetscStrcmp(name, "growth", &reads_growth));
  if (!reads_error && !reads_growth) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheGetEstimates(ts, &error, NULL, &derivative));
  PetscCall(SlipFaultKeepEstimates(fault, w, error, derivative));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "SlipObserve_C" of slipts.h */
static PetscErrorCode SlipObserve_Fault(TS ts, const char name[], PetscReal *value, PetscBool *known)
{
  SlipFault fault;
  Vec w;

  PetscFunctionBegin;
  PetscCall(SlipFaultOfTS(ts, &fault));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultTakeEstimates(fault, ts, w, name));
  PetscCall(SlipFaultObserve(fault, w, name, value, known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "SlipTimeScale_C" of slipts.h */
static PetscErrorCode SlipTimeScale_Fault(TS ts, PetscReal *tstar)
{
  SlipFault fault;

  PetscFunctionBegin;
  PetscCall(SlipFaultOfTS(ts, &fault));
  PetscCall(SlipFaultGetTimeScale(fault, tstar));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "SlipProblemName_C" of slipts.h */
static PetscErrorCode SlipProblemName_Fault(TS ts, const char **name)
{
  PetscFunctionBegin;
  (void)ts;
  *name = "fault";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "SlipRestTime_C" of slipts.h */
static PetscErrorCode SlipRestTime_Fault(TS ts, PetscReal *rest)
{
  SlipFault fault;
  Vec w;

  PetscFunctionBegin;
  PetscCall(SlipFaultOfTS(ts, &fault));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultRestTime(fault, w, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* dw/dt = A^-1 F_s(w), the smooth part: what integrators without the constraint see. */
static PetscErrorCode SlipFaultRHS(TS ts, PetscReal t, Vec w, Vec F, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)ts;
  (void)t;
  PetscCall(SlipFaultSmooth(fault, w, F));
  PetscCall(VecGetArray(F, &a));
  for (PetscInt i = 0; i < fault->n; i++) a[3 * i] /= fault->mass * fault->weight[i];
  PetscCall(VecRestoreArray(F, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultSetTolerances(SlipFault fault, TS ts)
{
  Vec atol;
  PetscReal *a, rate;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetReal(fault, "rate_tolerance", &rate));
  PetscCall(SlipFaultCreateState(fault, &atol));
  PetscCall(VecGetArray(atol, &a));
  for (PetscInt i = 0; i < fault->n; i++) {
    a[3 * i] = rate;
    a[3 * i + 1] = a[3 * i + 2] = SLIP_FAULT_ATOL;
  }
  PetscCall(VecRestoreArray(atol, &a));
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, atol, SLIP_FAULT_RTOL, NULL));
  PetscCall(VecDestroy(&atol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultAttach(SlipFault fault, TS ts)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectCompose((PetscObject)ts, "SlipFault", (PetscObject)fault));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipObserve_C", SlipObserve_Fault));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipTimeScale_C", SlipTimeScale_Fault));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipProblemName_C", SlipProblemName_Fault));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipRestTime_C", SlipRestTime_Fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultConfigureTS - make a TS integrate the fault

  Collective; after SlipFaultSetUp(), before TSSetFromOptions().

  Input Parameters:
+ fault - the fault; the TS keeps a reference
- ts    - the TS

  Notes:
  Sets the type bathe with the fault's friction as its constraint, the smooth right-hand side, a vector of absolute
  tolerances (1e-10 m for u and s, 1e-10 m/T* for v unless -fault_rate_tolerance says otherwise) and rtol 1e-3, max time
  30 s (-ts_max_time), exact final time matchstep (-ts_exact_final_time), unlimited rejections and failed solves, first
  step 0.01 T* (-ts_dt), and the composed functions by which controllers observe the fault (slipts.h).

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

  Level: beginner

.seealso: SlipFaultCreateState(), SlipFaultSetInitialState(), TSBATHE
@*/
PetscErrorCode SlipFaultConfigureTS(SlipFault fault, TS ts)
{
  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipFaultConstraintCreate(fault));
  PetscCall(TSSetProblemType(ts, TS_NONLINEAR));
  PetscCall(TSSetType(ts, TSBATHE));
  PetscCall(TSSetRHSFunction(ts, NULL, SlipFaultRHS, fault));
  PetscCall(TSBatheSetConstraint(ts, fault->con));
  PetscCall(SlipFaultSetTolerances(fault, ts));
  PetscCall(TSSetMaxTime(ts, SLIP_FAULT_MAX_TIME));
  PetscCall(TSSetMaxSteps(ts, PETSC_MAX_INT));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSSetMaxSNESFailures(ts, SLIP_UNLIMITED));
  PetscCall(TSSetMaxStepRejections(ts, SLIP_UNLIMITED));
  PetscCall(TSSetTimeStep(ts, SLIP_FAULT_FIRST_STEP * fault->tstar));
  PetscCall(SlipFaultAttach(fault, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}
