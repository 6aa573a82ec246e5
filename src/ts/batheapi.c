/* TSBATHE's setters and getters of choices and of the reaction, which access the data of a TS of type bathe. Setters of
   choices ignore other types, as PetscTryMethod() would; for other types all else is an error, as with
   PetscUseMethod(). */
#include <slipstep/private/slipbathe.h>

/* Returns whether a TS is of type TSBATHE or TSMOREAU, which have the same functions. is: `PETSC_TRUE`: it is of one of
   these types. */
PetscErrorCode TSBatheIs(TS ts, PetscBool *is)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, is, TSBATHE, TSMOREAU, ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the data of a TS of type bathe or moreau; for another type *ba is NULL, or it is an error if required. */
PetscErrorCode TSBatheGetData(TS ts, PetscBool required, TS_Bathe **ba)
{
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(ts, &bathe));
  PetscCheck(bathe || !required, PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP, "TS type %s, expected " TSBATHE,
             ((PetscObject)ts)->type_name ? ((PetscObject)ts)->type_name : "not set yet");
  *ba = bathe ? (TS_Bathe *)ts->data : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetGamma - sets the split of the step into its trapezoidal and its backward part

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
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveReal(ts, gamma, 2);
  PetscCheck(gamma > 0.0 && gamma < 1.0, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_bathe_gamma is %.6g, expected a number in (0, 1)", (double)gamma);
  if (!ba) PetscFunctionReturn(PETSC_SUCCESS);
  ba->stages.gamma = gamma;
  if (ba->stages.first == TSBATHE_STAGE_TRAPEZOIDAL) SlipBatheSetUp(gamma, &ba->stages.c);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetGamma - gets the split of the step

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
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *gamma = ba->stages.gamma;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetFirstStage - sets the rule of stage 1

  Logically collective

  Input Parameters:
+ ts   - of type TSBATHE, ignored otherwise
- rule - TSBATHE_STAGE_TRAPEZOIDAL, to t + gamma h, or TSBATHE_STAGE_BACKWARD, to t + (1 - 1/sqrt 2) h

  Options Database Key:
. -ts_bathe_first_stage <trapezoidal,backward> - the same

  Level: intermediate

  Notes:
  With the backward rule the step is Alexander's second formula of order two, L-stable and algebraically stable. It
  ignores gamma and the treatment of the reaction, which no stage averages then. It is for steps that are longer than
  the times of inertia and radiation, such as those of a fault that creeps between events: there the trapezoidal rule
  repeats the unbalanced force of the start with the opposite sign.
  Faults that are loaded, heal or have no inertia use it unless the option is given, and so do problems of
  TSSetIFunction(). The trapezoidal rule evaluates F(t, w, w') at the start of the step as F(t, w, 0), which is correct
  where F is A w' + f(t, w) with a constant, invertible A. The solution is wrong where F is not linear in w', of order
  one where A changes, and it satisfies algebraic equations only in the mean of a step's ends.

.seealso: TSBATHE, TSBatheGetFirstStage(), TSBatheSetGamma(), TSBatheSetReactionType()
@*/
PetscErrorCode TSBatheSetFirstStage(TS ts, TSBatheFirstStage rule)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveEnum(ts, rule, 2);
  if (!ba) PetscFunctionReturn(PETSC_SUCCESS);
  ba->stages.first_set = PETSC_TRUE;
  ba->stages.first = rule;
  if (rule == TSBATHE_STAGE_BACKWARD)
    SlipBatheSetUpBackward(&ba->stages.c);
  else
    SlipBatheSetUp(ba->stages.gamma, &ba->stages.c);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetFirstStage - gets the rule of stage 1

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. rule - trapezoidal or backward

  Level: intermediate

.seealso: TSBatheSetFirstStage()
@*/
PetscErrorCode TSBatheGetFirstStage(TS ts, TSBatheFirstStage *rule)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *rule = ba->stages.first;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetReactionType - sets the treatment of the set-valued reaction in stage 1

  Logically collective

  Input Parameters:
+ ts   - of type TSBATHE, ignored otherwise
- type - TSBATHE_REACTION_TRAPEZOIDAL, mean of the reactions at both ends (second order while the sliding set does not
         change), or TSBATHE_REACTION_IMPLICIT, the one at the stage's end (published, first order)

  Options Database Key:
. -ts_bathe_reaction <trapezoidal,implicit> - the same

  Level: intermediate

.seealso: TSBATHE, TSBatheGetReactionType(), TSBatheGetReaction(), TSBatheSetConstraint()
@*/
PetscErrorCode TSBatheSetReactionType(TS ts, TSBatheReactionType type)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveEnum(ts, type, 2);
  if (ba) ba->stages.reaction = type;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetReactionType - gets the treatment of the set-valued reaction in stage 1

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. type - the treatment

  Level: intermediate

.seealso: TSBatheSetReactionType()
@*/
PetscErrorCode TSBatheGetReactionType(TS ts, TSBatheReactionType *type)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *type = ba->stages.reaction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetError - sets how a step's error is estimated

  Logically collective

  Input Parameters:
+ ts    - of type TSBATHE, ignored otherwise
- error - TSBATHE_ERROR_EMBEDDED (no extra solve, order 2), TSBATHE_ERROR_DOUBLING (three Bathe steps an attempt), or
          TSBATHE_ERROR_NONE

  Options Database Key:
. -ts_bathe_error <embedded,doubling,none> - the same

  Level: intermediate

.seealso: TSBATHE, TSBatheGetError(), TSBatheSetDoublingOrder(), TSEvaluateWLTE()
@*/
PetscErrorCode TSBatheSetError(TS ts, TSBatheError error)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveEnum(ts, error, 2);
  if (!ba) PetscFunctionReturn(PETSC_SUCCESS);
  ba->estimate.type = error;
  ba->estimate.given = PETSC_TRUE;
  ba->k0_known = PETSC_FALSE;
  ba->sol_id = 0; /* K0 is not stored: the next step computes it */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetError - gets how a step's error is estimated

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
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *error = ba->estimate.type;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetStageError - sets how accurately stages with a set-valued reaction are solved

  Logically collective

  Input Parameters:
+ ts    - of type TSBATHE, ignored otherwise
- share - largest error that the solves may add to a step, over the step's local error, dimensionless in [0, 1); 0: they
          end at -snes_rtol or at rounding; 0.1 unless set

  Options Database Key:
. -ts_bathe_stage_error <0.1> - the same

  Level: intermediate

  Note:
  The error estimate of the last attempt, over the change of the slip rates, predicts the error of the next one. Its
  stages reduce their residual to share times that ratio of their first residual, and at least to a hundredth. With
  -snes_rtol, without an estimate, and with a constraint that is not affine (SlipConstraintOps) they solve to rounding.

  Errors: PETSC_ERR_ARG_OUTOFRANGE

.seealso: TSBATHE, TSBatheSetError(), SNESSlipSolveStage()
@*/
PetscErrorCode TSBatheSetStageError(TS ts, PetscReal share)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveReal(ts, share, 2);
  if (!ba) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(share >= 0 && share < 1, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_bathe_stage_error is %g, expected a number in [0, 1)", (double)share);
  ba->stages.allowed = share;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the order p that step doubling assumes: e = (w_half - w_full)/(2^p - 1), which TSEvaluateWLTE() returns as
   proportional to h^(p + 1). ts: of type TSBATHE, ignored otherwise; p: at least 1; 1 as published, 2 is the method's
   order. Option -ts_bathe_order <1>: the same. Errors: PETSC_ERR_ARG_OUTOFRANGE for p < 1. */
PetscErrorCode TSBatheSetDoublingOrder(TS ts, PetscInt p)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  PetscValidLogicalCollectiveInt(ts, p, 2);
  PetscCheck(p >= 1, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_bathe_order is %" PetscInt_FMT ", expected at least 1", p);
  if (ba) ba->estimate.order = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetOrder - gets the order of the method as it is used: 2, or 1 if a set-valued reaction is treated implicitly

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. order - the order of the global error in the step, dimensionless

  Level: advanced

.seealso: TSBatheSetReactionType(), TSBatheSetDoublingOrder()
@*/
PetscErrorCode TSBatheGetOrder(TS ts, PetscReal *order)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *order = ba->con && ba->choice.method != TSBATHE_METHOD_EXPLICIT &&
               ba->stages.reaction == TSBATHE_REACTION_IMPLICIT && ba->stages.first == TSBATHE_STAGE_TRAPEZOIDAL
             ? 1
             : 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetConstraint - sets the constraint of a set-valued reaction F_r in A dw/dt = F_s(t, w) + F_r

  Collective

  Input Parameters:
+ ts  - of type TSBATHE or TSMOREAU (an error otherwise); the constraint stays when it becomes the other of the two
- con - the constraint, with all its operations; the TS takes a reference

  Level: intermediate

  Notes:
  The TS's SNES becomes "semismooth" unless it already is of a type that takes a constraint (-snes_type overrides), and
  the limits of PETSc on failed solves and rejections are lifted (-ts_max_snes_failures, -ts_max_reject): the run ends
  after -ts_bathe_max_failures failures in a row instead.

.seealso: TSBATHE, TSBatheGetConstraint(), SlipConstraintCreate(), TSBatheSetInitialReaction()
@*/
PetscErrorCode TSBatheSetConstraint(TS ts, SlipConstraint con)
{
  TS_Bathe *ba = NULL;
  SNES snes;
  PetscBool ours;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 2);
  PetscCall(SlipConstraintGetOps(con, &ba->ops));
  PetscCall(PetscObjectReference((PetscObject)con));
  PetscCall(SlipConstraintDestroy(&ba->con));
  ba->con = con;
  PetscCall(PetscObjectCompose((PetscObject)ts, TSBATHE_CONSTRAINT, (PetscObject)con)); /* for both types */
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
  TSBatheGetConstraint - gets the constraint of a TSBATHE

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
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *con = ba->con;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetReaction - gets the accepted reaction at the current time; with the solution it is the restart state

  Not collective

  Input Parameter:
. ts - of type TSBATHE with a constraint

  Output Parameter:
. r - borrowed, reduced [Pa for the fault]

  Level: intermediate

  Errors: PETSC_ERR_ORDER before TSBatheSetConstraint()

.seealso: TSBatheSetInitialReaction(), TSBatheSetConstraint()
@*/
PetscErrorCode TSBatheGetReaction(TS ts, Vec *r)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  PetscCheck(ba->r, PetscObjectComm((PetscObject)ts), PETSC_ERR_ORDER, "Call TSBatheSetConstraint() first");
  *r = ba->r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheSetInitialReaction - sets the reaction with which the next start or restart begins instead of static balance

  Collective

  Input Parameters:
+ ts - of type TSBATHE with a constraint
- r  - reduced [Pa for the fault]; copied

  Level: intermediate

  Errors: PETSC_ERR_ORDER before TSBatheSetConstraint()

.seealso: TSBatheGetReaction(), SlipConstraintInitialReaction()
@*/
PetscErrorCode TSBatheSetInitialReaction(TS ts, Vec r)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  PetscValidHeaderSpecific(r, VEC_CLASSID, 2);
  PetscCheck(ba->r, PetscObjectComm((PetscObject)ts), PETSC_ERR_ORDER, "Call TSBatheSetConstraint() first");
  PetscCall(VecCopy(r, ba->r));
  ba->r_given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
