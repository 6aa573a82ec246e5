/* TSBATHE's setters and getters: the public function validates and dispatches, the static one after it does the
   work. */
#include <slipstep/private/slipts.h>

/*@
  TSBatheSetGamma - split of the step into its trapezoidal and its backward part

  Logically collective

  Input Parameters:
+ ts    - of type TSBATHE, ignored otherwise
- gamma - in (0, 1), dimensionless; 1/2 is Bathe's, 2 - sqrt(2) makes both stage operators equal

  Options Database Key:
. -ts_bathe_gamma <0.5> - the same

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a gamma outside of (0, 1)

.seealso: TSBATHE, TSBatheGetGamma()
@*/
PetscErrorCode TSBatheSetGamma(TS ts, PetscReal gamma)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscValidLogicalCollectiveReal(ts, gamma, 2);
  PetscCheck(gamma > 0.0 && gamma < 1.0, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_bathe_gamma is %.6g, expected a number in (0, 1)", (double)gamma);
  PetscTryMethod(ts, "TSBatheSetGamma_C", (TS, PetscReal), (ts, gamma));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSetGamma_Bathe(TS ts, PetscReal gamma)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  ba->gamma = gamma;
  SlipBatheSetUp(gamma, &ba->c);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetGamma - split of the step

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. gamma - in (0, 1), dimensionless

  Level: intermediate

.seealso: TSBatheSetGamma()
@*/
PetscErrorCode TSBatheGetGamma(TS ts, PetscReal *gamma)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetGamma_C", (TS, PetscReal *), (ts, gamma));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheGetGamma_Bathe(TS ts, PetscReal *gamma)
{
  PetscFunctionBegin;
  *gamma = ((TS_Bathe *)ts->data)->gamma;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetReaction - treatment of the set-valued reaction in stage 1

  Logically collective

  Input Parameters:
+ ts       - of type TSBATHE, ignored otherwise
- reaction - TSBATHE_REACTION_TRAPEZOIDAL, mean of the reactions at both ends (second order while the sliding set does
             not change), or TSBATHE_REACTION_IMPLICIT, the one at the stage's end (published, first order)

  Options Database Key:
. -ts_bathe_reaction <trapezoidal,implicit> - the same

  Level: intermediate

.seealso: TSBATHE, TSBatheSetConstraint()
@*/
PetscErrorCode TSBatheSetReaction(TS ts, TSBatheReaction reaction)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscTryMethod(ts, "TSBatheSetReaction_C", (TS, TSBatheReaction), (ts, reaction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSetReaction_Bathe(TS ts, TSBatheReaction reaction)
{
  PetscFunctionBegin;
  ((TS_Bathe *)ts->data)->reaction = reaction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetError - how a step's error is estimated

  Logically collective

  Input Parameters:
+ ts    - of type TSBATHE, ignored otherwise
- error - TSBATHE_ERROR_EMBEDDED (no extra solve, order 2), TSBATHE_ERROR_DOUBLING (three Bathe steps an attempt), or
          TSBATHE_ERROR_NONE

  Options Database Key:
. -ts_bathe_error <embedded,doubling,none> - the same

  Level: intermediate

.seealso: TSBATHE, TSBatheSetOrder(), TSEvaluateWLTE()
@*/
PetscErrorCode TSBatheSetError(TS ts, TSBatheError error)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscTryMethod(ts, "TSBatheSetError_C", (TS, TSBatheError), (ts, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSetError_Bathe(TS ts, TSBatheError error)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  ba->error = error;
  ba->error_set = PETSC_TRUE;
  ba->k0_known = PETSC_FALSE;
  ba->sol_id = 0; /* K0 has not been kept: have the next step compute it */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetError - how a step's error is estimated

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. error - the estimate

  Level: intermediate

.seealso: TSBatheSetError()
@*/
PetscErrorCode TSBatheGetError(TS ts, TSBatheError *error)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetError_C", (TS, TSBatheError *), (ts, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheGetError_Bathe(TS ts, TSBatheError *error)
{
  PetscFunctionBegin;
  *error = ((TS_Bathe *)ts->data)->error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetOrder - order that step doubling assumes: e = (w_half - w_full)/(2^p - 1), and reports

  Logically collective

  Input Parameters:
+ ts - of type TSBATHE, ignored otherwise
- p  - at least 1; 1 as published, 2 is the method's order

  Options Database Key:
. -ts_bathe_order <1> - the same

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for p < 1

.seealso: TSBatheSetError()
@*/
PetscErrorCode TSBatheSetOrder(TS ts, PetscInt p)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscValidLogicalCollectiveInt(ts, p, 2);
  PetscCheck(p >= 1, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_bathe_order is %" PetscInt_FMT ", expected at least 1", p);
  PetscTryMethod(ts, "TSBatheSetOrder_C", (TS, PetscInt), (ts, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSetOrder_Bathe(TS ts, PetscInt p)
{
  PetscFunctionBegin;
  ((TS_Bathe *)ts->data)->order = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetConstraint - a set-valued reaction F_r in A dw/dt = F_s(t, w) + F_r

  Collective

  Input Parameters:
+ ts  - of type TSBATHE (an error otherwise)
- con - the constraint, with all its operations (a reference is kept)

  Level: intermediate

  Notes:
  The TS's SNES becomes "semismooth" unless it already is of a type that takes a constraint (-snes_type overrides), and
  the limits of PETSc on failed solves and rejections are lifted (-ts_max_snes_failures, -ts_max_reject): the run ends
  after -ts_bathe_max_failures failures in a row instead.

.seealso: TSBATHE, TSBatheGetConstraint(), SlipConstraintCreate(), TSBatheSetInitialReaction()
@*/
PetscErrorCode TSBatheSetConstraint(TS ts, SlipConstraint con)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 2);
  PetscUseMethod(ts, "TSBatheSetConstraint_C", (TS, SlipConstraint), (ts, con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSetConstraint_Bathe(TS ts, SlipConstraint con)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SNES snes;
  PetscBool ours;

  PetscFunctionBegin;
  PetscCall(SlipConstraintGetOps(con, &ba->ops));
  PetscCall(PetscObjectReference((PetscObject)con));
  PetscCall(SlipConstraintDestroy(&ba->con));
  ba->con = con;
  PetscCall(SlipConstraintGetContext(con, &ba->ctx));
  PetscCall(VecDestroy(&ba->r));
  PetscCall(SlipConstraintCreateReduced(con, &ba->r));
  PetscCall(TSGetSNES(ts, &snes));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)snes, &ours, SNESSEMISMOOTH, SNESPROJECTION, ""));
  if (!ours) PetscCall(SNESSetType(snes, SNESSEMISMOOTH));
  PetscCall(SNESSetSlipConstraint(snes, con));
  PetscCall(TSSetMaxSNESFailures(ts, SLIP_UNLIMITED));
  PetscCall(TSSetMaxStepRejections(ts, SLIP_UNLIMITED));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetConstraint - the constraint of a TSBATHE

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. con - borrowed; NULL when there is none

  Level: intermediate

.seealso: TSBatheSetConstraint()
@*/
PetscErrorCode TSBatheGetConstraint(TS ts, SlipConstraint *con)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetConstraint_C", (TS, SlipConstraint *), (ts, con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheGetConstraint_Bathe(TS ts, SlipConstraint *con)
{
  PetscFunctionBegin;
  *con = ((TS_Bathe *)ts->data)->con;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetReaction - the accepted reaction at the current time; with the solution it is the restart state

  Not collective

  Input Parameter:
. ts - of type TSBATHE with a constraint

  Output Parameter:
. r - borrowed, reduced [Pa for the fault]

  Level: intermediate

.seealso: TSBatheSetInitialReaction(), TSBatheSetConstraint()
@*/
PetscErrorCode TSBatheGetReaction(TS ts, Vec *r)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetReaction_C", (TS, Vec *), (ts, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheGetReaction_Bathe(TS ts, Vec *r)
{
  PetscFunctionBegin;
  *r = ((TS_Bathe *)ts->data)->r;
  PetscCheck(*r, PetscObjectComm((PetscObject)ts), PETSC_ERR_ORDER, "Call TSBatheSetConstraint() first");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetInitialReaction - the reaction that the next start or restart begins with, instead of the static balance

  Collective

  Input Parameters:
+ ts - of type TSBATHE with a constraint
- r  - reduced [Pa for the fault]; copied

  Level: intermediate

.seealso: TSBatheGetReaction(), SlipConstraintInitialReaction()
@*/
PetscErrorCode TSBatheSetInitialReaction(TS ts, Vec r)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscValidHeaderSpecific(r, VEC_CLASSID, 2);
  PetscUseMethod(ts, "TSBatheSetInitialReaction_C", (TS, Vec), (ts, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheSetInitialReaction_Bathe(TS ts, Vec r)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCheck(ba->r, PetscObjectComm((PetscObject)ts), PETSC_ERR_ORDER, "Call TSBatheSetConstraint() first");
  PetscCall(VecCopy(r, ba->r));
  ba->r_given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetLastAttempt - record of the last attempted step

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. attempt - the record; while the controller chooses, accepted is not known yet and false

  Level: intermediate

.seealso: TSBatheAddAttemptMonitor(), TSBatheGetTotals()
@*/
PetscErrorCode TSBatheGetLastAttempt(TS ts, SlipAttempt *attempt)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetLastAttempt_C", (TS, SlipAttempt *), (ts, attempt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheGetLastAttempt_Bathe(TS ts, SlipAttempt *attempt)
{
  PetscFunctionBegin;
  *attempt = ((TS_Bathe *)ts->data)->last;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSBatheAddAttemptMonitor - have a function called after every attempted step, accepted or not

  Logically collective

  Input Parameters:
+ ts  - of type TSBATHE
. fn  - called in the order of registration, once the verdict is known
- ctx - passed to fn

  Level: intermediate

.seealso: TSBatheGetLastAttempt()
@*/
PetscErrorCode TSBatheAddAttemptMonitor(TS ts, TSBatheAttemptFn fn, void *ctx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheAddAttemptMonitor_C", (TS, TSBatheAttemptFn, void *), (ts, fn, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheAddAttemptMonitor_Bathe(TS ts, TSBatheAttemptFn fn, void *ctx)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCheck(ba->nmonitors < BATHE_MAX_MONITORS, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "At most %d attempt monitors", (int)BATHE_MAX_MONITORS);
  ba->monitor[ba->nmonitors] = fn;
  ba->monitorctx[ba->nmonitors++] = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetTotals - counts since TSSolve() began

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameters:
+ attempts - steps tried (each output may be NULL)
. accepted - steps taken
. solves   - Bathe steps computed, more than attempts with step doubling
. newton   - nonlinear iterations
- linear   - linear iterations

  Level: intermediate

.seealso: TSBatheGetLastAttempt()
@*/
PetscErrorCode TSBatheGetTotals(TS ts, PetscInt *attempts, PetscInt *accepted, PetscInt *solves, PetscInt *newton,
                                PetscInt *linear)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscUseMethod(ts, "TSBatheGetTotals_C", (TS, PetscInt *, PetscInt *, PetscInt *, PetscInt *, PetscInt *),
                 (ts, attempts, accepted, solves, newton, linear));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSBatheGetTotals_Bathe(TS ts, PetscInt *attempts, PetscInt *accepted, PetscInt *solves,
                                             PetscInt *newton, PetscInt *linear)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (attempts) *attempts = ba->attempts;
  if (accepted) *accepted = ba->accepted;
  if (solves) *solves = ba->solves;
  if (newton) *newton = ba->newton;
  if (linear) *linear = ba->linear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define COMPOSE(name)                                                                                                  \
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, #name "_C", compose ? (void (*)(void))name##_Bathe : NULL))

/* Compose or un-compose all of the above */
PetscErrorCode TSBatheComposeSetters(TS ts, PetscBool compose)
{
  PetscFunctionBegin;
  COMPOSE(TSBatheSetGamma);
  COMPOSE(TSBatheGetGamma);
  COMPOSE(TSBatheSetReaction);
  COMPOSE(TSBatheSetError);
  COMPOSE(TSBatheGetError);
  COMPOSE(TSBatheSetOrder);
  COMPOSE(TSBatheSetConstraint);
  COMPOSE(TSBatheGetConstraint);
  COMPOSE(TSBatheGetReaction);
  COMPOSE(TSBatheSetInitialReaction);
  COMPOSE(TSBatheGetLastAttempt);
  COMPOSE(TSBatheGetEstimates);
  COMPOSE(TSBatheAddAttemptMonitor);
  COMPOSE(TSBatheGetTotals);
  COMPOSE(TSBatheGetOrder);
  COMPOSE(TSBatheSetHalved);
  PetscFunctionReturn(PETSC_SUCCESS);
}
