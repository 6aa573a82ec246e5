/* Formulates faults without inertia as an explicit TS: tolerances, right-hand side, and the end of a step. Their cells
   always slide, as with rate-and-state friction, or friction sticks (sticking.c). */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipts.h>
#include <slipstep/rooms/slipadapt.h>

#define EXPLICIT_RTOL 1e-3 /* with waves, for the worst cell */
/* Tolerance of cycles with waves over the accuracy, for lines and planes. At an accuracy of 1e-2 the second event of
   SEAS BP1-FD, with cells of 100 m, is 0.02 years from the limit of shorter steps by 15,800 products with K; steps that
   bound slip (lapusta) are 1.04 years from it by 13,500, and 0.3 by 55,400. That of BP4-FD, with cells of 1 km, is 0.02
   years from its limit by 5,200 products, and lapusta's 8.6 by 4,500. */
#define WAVES_RTOL_LINE 0.01
#define WAVES_RTOL_PLANE 0.2
#define FIRST_STEP 0.01          /* over the time in which the fastest cell slips its d_c */
#define STICKING_FIRST_STEP 0.01 /* over T* */
#define EXPLICIT_FARTHEST 1e6    /* distance from the displacement of the loading [m] */

/* Sets |e_u| <= rtol d_c and |e_s| <= rtol in every cell, whatever the size of u and s: equal shares of both change
   friction equally. It is called again when rtol has changed. */
static PetscErrorCode SetTolerances(SlipFault fault, TS ts, PetscReal rtol)
{
  Vec atol, none;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(SlipFaultCreateState(fault, &atol));
  PetscCall(VecDuplicate(atol, &none));
  PetscCall(VecGetArrayWrite(atol, &a));
  if (!fault->friction.law->always_slides) PetscCall(SlipFaultStickingTolerances(fault, rtol, a));
  for (PetscInt i = 0; i < fault->mesh.n && fault->friction.law->always_slides; i++) {
    for (PetscInt k = 0; k < fault->layout.components; k++) {
      a[SlipFaultRateAt(fault, i) + k] = 1;
      a[SlipFaultDisplacementAt(fault, i) + k] = rtol * fault->fields.cell[FIELD_FRICTION_SLIP][i];
    }
    for (PetscInt k = 0; k < fault->layout.states; k++) a[SlipFaultStateAt(fault, i) + k] = rtol;
  }
  PetscCall(VecRestoreArrayWrite(atol, &a));
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, atol, rtol, none));
  fault->balance.rtol = rtol;
  PetscCall(VecDestroy(&none));
  PetscCall(VecDestroy(&atol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RHS(TS ts, PetscReal t, Vec w, Vec F, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultBalance *b = &fault->balance;
  PetscReal rtol;
  Vec *stage = NULL;

  PetscFunctionBegin;
  if (b->resting) {
    PetscCall(VecCopy(b->way, F));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  if (rtol != b->rtol) PetscCall(SetTolerances(fault, ts, rtol));
  if (b->first) PetscCall(TSGetStages(ts, NULL, &stage)); /* the stages of TSRK */
  if (b->first && w == stage[0]) { /* at a restart, this is the first stage of each attempt at the first step */
    PetscCall(VecCopy(b->first, F));
    ts->steprestart = PETSC_FALSE; /* for its controller */
  } else {
    PetscCall(SlipFaultRates(fault, t, w, F));
    b->sides++;
  }
  b->F = F;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSSetFunctionDomainError(). TSRK subtracts a rejected step from the state, which leaves rounding of the size of what
   it had added. The result of a step that is far too long (rates grow as V0 exp(-psi)/d_c) must therefore be rejected
   before it is added. With pairs whose last stage is the step's end, the new state is a stage as well. */
static PetscErrorCode InDomain(TS ts, PetscReal t, Vec w, PetscBool *accept)
{
  PetscReal bound[2 * 3 + SLIP_MAX_STATES] = {0};
  PetscBool good;
  PetscInt states, c, outside;
  SlipFault fault;

  PetscFunctionBegin;
  (void)t;
  PetscCall(PetscObjectQuery((PetscObject)ts, "SlipFault", (PetscObject *)&fault));
  states = fault->friction.law->nstates;
  c = fault->layout.components;
  for (PetscInt k = 0; k < c; k++) bound[fault->layout.displacement + k] = EXPLICIT_FARTHEST;
  for (PetscInt k = 0; k < states; k++) {
    const PetscReal largest = fault->friction.law->states[k].largest;

    bound[fault->layout.state + k] = largest > 0 ? largest : PETSC_MAX_REAL;
  }
  PetscCall((*fault->cell_ops->outside)(fault, w, bound, &outside));
  good = outside == 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscCallMPI(MPI_Allreduce(&good, accept, 1, MPIU_BOOL, MPI_LAND, PetscObjectComm((PetscObject)ts)));
  if (*accept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipGuardConstant(ts, ts->time_step));
  PetscCall(SlipGuardStep(ts)); /* without this TSRK would shorten steps for ever from a state that no step can leave */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether the last right-hand side of TSRK was that of the step's end. */
static PetscErrorCode EndIsKnown(SlipFault fault, TS ts, PetscReal t, PetscBool *known)
{
  PetscBool rk;

  PetscFunctionBegin;
  *known = PETSC_FALSE;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSRK, &rk));
  if (!rk || !fault->balance.known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSRKGetTableau(ts, NULL, NULL, NULL, NULL, NULL, NULL, NULL, known));
  if (PetscAbsReal(fault->balance.time - t) > 4 * PETSC_MACHINE_EPSILON * PetscAbsReal(t)) *known = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipStepOps.finish. TSADAMS and TSRKC call it for the slip rates within their steps, which are those of the last
   right-hand side. */
PetscErrorCode SlipFaultFinishStep(TS ts, PetscReal t, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)ts;
  if (fault->balance.time != t) PetscCall(SlipFaultRates(fault, t, w, NULL));
  PetscCall(SlipFaultPutRates(fault, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSPostEvaluate: runs after a step of PETSc's own types, before monitors. It hides the change of the state from PETSc,
   as the next step would otherwise begin anew, without the last right-hand side. Our types use SlipFaultMoment. */
static PetscErrorCode SlipFaultAfterStep(TS ts)
{
  PetscObjectState state;
  SlipFault fault;
  PetscBool known, ours, rkc, good;
  PetscReal t, moved;
  Vec w;

  PetscFunctionBegin;
  PetscCall(PetscObjectQuery((PetscObject)ts, "SlipFault", (PetscObject *)&fault));
  if (fault->balance.resting) {
    PetscCall(SlipFaultEndRest(fault, ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSRKC, &rkc));
  /* Tolerances of slips that are relative to the largest displacement follow it. TSRKC uses the error of each step
     instead, and needs them where cells do not weaken, for the end of an event. */
  if (!fault->friction.law->always_slides && (!rkc || fault->balance.steady)) {
    PetscCall(SlipFaultLargestDisplacement(fault, w, &moved));
    if (fault->balance.follows && moved != fault->balance.moved) {
      fault->balance.moved = moved;
      PetscCall(SetTolerances(fault, ts, fault->balance.rtol));
    }
  }
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, &ours, TSADAMS, TSRKC, TSLAPUSTA, ""));
  if (ours) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDestroy(&fault->balance.first));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(PetscObjectStateGet((PetscObject)w, &state));
  PetscCall(EndIsKnown(fault, ts, t, &known));
  if (!known) {
    PetscCall(InDomain(ts, t, w, &good)); /* no stage had this state */
    PetscCheck(good, fault->comm, PETSC_ERR_FP,
               "At time %g s a step ended in what is no state of the fault, not refused by -ts_adapt_type; expected a "
               "shorter step: a smaller -ts_rtol, or -ts_rk_type 3bs or 5dp, which see it",
               (double)t);
    PetscCall(SlipFaultRates(fault, t, w, NULL));
  }
  PetscCall(SlipFaultPutRates(fault, w));
  PetscCall(PetscObjectStateSet((PetscObject)w, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets *seen: the state w at t, with its slip rates, for a controller. While an attempt is judged, w is its end but has
   the rates of the start. This costs a right-hand side of the state itself, as the last one was of another state. */
PetscErrorCode SlipFaultObservedState(SlipFault fault, TS ts, PetscReal t, Vec w, Vec *seen)
{
  SlipFaultBalance *b = &fault->balance;
  PetscReal start;

  PetscFunctionBegin;
  *seen = w;
  PetscCall(TSGetTime(ts, &start));
  if (!(t > start)) PetscFunctionReturn(PETSC_SUCCESS); /* there is no attempt */
  if (!b->seen) PetscCall(VecDuplicate(w, &b->seen));
  PetscCall(VecCopy(w, b->seen));
  PetscCall(SlipFaultRates(fault, t, b->seen, NULL));
  PetscCall(SlipFaultPutRates(fault, b->seen));
  *seen = b->seen;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads a checkpoint's part. It has the rates of the last stage of the step before, where the next step uses
   them, as they differ from those of the state by rounding. TSRK would compute them anew at a restart. */
PetscErrorCode SlipFaultExplicitState(SlipFault fault, SlipState s, TS ts)
{
  SlipFaultBalance *b = &fault->balance;
  PetscBool known = PETSC_FALSE, rk;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSRK, &rk));
  if (!fault->problem.steps.any_integrator) PetscFunctionReturn(PETSC_SUCCESS);
  if (!fault->friction.law->always_slides) {
    PetscCall(SlipStateReal(s, "largest_displacement", 1, &b->moved));
    PetscCall(SlipStateReal(s, "largest_rate", 1, &b->fastest));
    if (SlipStateIsLoading(s)) PetscCall(SetTolerances(fault, ts, b->rtol));
  }
  if (!rk) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetTime(ts, &t));
  if (SlipStateIsLoading(s)) PetscCall(VecDestroy(&b->first));
  if (!SlipStateIsLoading(s) && b->F && !ts->steprestart) PetscCall(EndIsKnown(fault, ts, t, &known));
  if (b->first) known = PETSC_TRUE; /* no step since the last checkpoint */
  PetscCall(SlipStateBool(s, "rates_known", &known));
  if (!known) PetscFunctionReturn(PETSC_SUCCESS);
  if (SlipStateIsLoading(s)) PetscCall(SlipFaultCreateState(fault, &b->first));
  PetscCall(SlipStateVec(s, "rates", b->first ? b->first : b->F));
  if (SlipStateIsLoading(s)) PetscCall(TSRestartStep(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the first step of a smooth law [s], explicit or not. */
PetscErrorCode SlipFaultFirstStep(SlipFault fault, PetscReal *step)
{
  const PetscReal *rate = fault->fields.cell[FIELD_INITIAL_RATE], *slip = fault->fields.cell[FIELD_FRICTION_SLIP];
  PetscReal time = PETSC_MAX_REAL;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if (rate[i] != 0) time = PetscMin(time, slip[i] / PetscAbsReal(rate[i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &time, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  *step = FIRST_STEP * (time < PETSC_MAX_REAL ? time : fault->operators.tstar);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the explicit problem. */
PetscErrorCode SlipFaultExplicitConfigure(SlipFault fault, TS ts)
{
  const PetscBool sticks = fault->friction.law->always_slides ? PETSC_FALSE : PETSC_TRUE;
  PetscReal step, shortest, rtol = EXPLICIT_RTOL;
  char type[64] = TSRKC;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSSetProblemType(ts, TS_NONLINEAR));
  PetscCall(SlipElasticGetShortestStep(fault->medium, &shortest));
  if (shortest == 0 && sticks) PetscCall(SlipFaultExplicitSteps(fault, ts, type, sizeof(type), &rtol));
  if (!sticks)
    PetscCall(SlipFaultCycleSteps(fault, ts, &rtol));
  else {
    /* A cell that starts or stops is a kink of its right-hand side, which formulas of low order cross at the least
       loss. No step ends there: with many cells, each step would end at one of them. */
    fault->balance.moved = SLIP_FAULT_ATOL;
    fault->balance.fastest = 0;
    fault->balance.known = fault->balance.resting = PETSC_FALSE;
    PetscCall(TSSetType(ts, type));
    PetscCall(TSGetAdapt(ts, &adapt));
    PetscCall(TSAdaptSetType(adapt, TSADAPTBASIC));
    if (fault->kind.sequence || fault->loads.pressed) PetscCall(SlipAdamsSetCorrections(ts, 1));
    PetscCall(SlipAdaptSetNorm(adapt, NORM_INFINITY));
    PetscCall(TSSetTimeStep(ts, STICKING_FIRST_STEP * fault->operators.tstar));
  }
  if (shortest > 0) { /* steps of constant slip rates, for a medium that remembers its waves */
    PetscCall(TSSetType(ts, TSLAPUSTA));
    PetscCall(TSGetAdapt(ts, &adapt));
    PetscCall(SlipAdaptSetController(adapt, sticks ? TSADAPTLAPUSTA : TSADAPTDSP));
    PetscCall(SlipAdaptSetNorm(adapt, NORM_INFINITY));
    PetscCall(TSSetTimeStep(ts, shortest));
    if (!sticks) rtol = (fault->mesh.dims[1] > 1 ? WAVES_RTOL_PLANE : WAVES_RTOL_LINE) * SlipFaultAccuracy(fault);
  }
  PetscCall(TSSetRHSFunction(ts, NULL, RHS, fault));
  PetscCall(TSSetFunctionDomainError(ts, InDomain));
  PetscCall(TSSetPostEvaluate(ts, SlipFaultAfterStep));
  PetscCall(SetTolerances(fault, ts, rtol));
  if (sticks || shortest > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultFirstStep(fault, &step));
  PetscCall(TSSetTimeStep(ts, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}
