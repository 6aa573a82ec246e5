/* One stage as a SNES: set-up, monitors and convergence, which the semismooth and projection types share. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

static const char key[] = "SlipConstraint";

static PetscErrorCode SNESSetUp_Slip(SNES snes)
{
  SNES_Slip *slip = (SNES_Slip *)snes->data;
  SlipConstraint con;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  PetscCall(VecDuplicateVecs(con->x, slip->nwork, &slip->work));
  for (PetscInt i = 0; i < slip->nwork; i++) PetscCall(VecZeroEntries(slip->work[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SNESReset_Slip(SNES snes)
{
  SNES_Slip *slip = (SNES_Slip *)snes->data;

  PetscFunctionBegin;
  if (slip->work) PetscCall(VecDestroyVecs(slip->nwork, &slip->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESDestroy_Slip(SNES snes)
{
  PetscFunctionBegin;
  PetscCall((*snes->ops->reset)(snes));
  PetscCall(PetscFree(snes->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the common part of a type. slip: the data of the type, or their first member */
PetscErrorCode SNESCreate_Slip(SNES snes, SNES_Slip *slip, PetscInt nwork, PetscInt max_it)
{
  PetscFunctionBegin;
  snes->data = slip;
  slip->nwork = nwork;
  snes->ops->setup = SNESSetUp_Slip;
  snes->ops->reset = SNESReset_Slip;
  snes->ops->destroy = SNESDestroy_Slip;
  snes->usesnpc = PETSC_FALSE;
  snes->alwayscomputesfinalresidual = PETSC_TRUE;
  SlipSNESDefaults(snes, SLIP_SEARCH_RTOL, max_it);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintQuery(SNES snes, SlipConstraint *con)
{
  PetscFunctionBegin;
  PetscCall(SNESGetSlipConstraint(snes, con));
  PetscCheck(
    *con, PetscObjectComm((PetscObject)snes), PETSC_ERR_ARG_WRONGSTATE,
    "SNES type %s solves stages with a set-valued reaction, which -ts_type bathe and moreau have and no other: "
    "call SNESSetSlipConstraint() first",
    ((PetscObject)snes)->type_name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Records one iterate: calls monitors, adds to the history and tests convergence. */
PetscErrorCode SlipConstraintReport(SNES snes, SlipConstraint con, PetscInt it, SNESConvergedReason *reason)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectSAWsTakeAccess((PetscObject)snes));
  snes->iter = it;
  snes->norm = con->norm;
  PetscCall(PetscObjectSAWsGrantAccess((PetscObject)snes));
  PetscCall(SNESLogConvergenceHistory(snes, snes->norm, snes->linear_its));
  PetscCall(SNESMonitor(snes, it, snes->norm));
  *reason = SNES_CONVERGED_ITERATING;
  if (PetscIsInfOrNanReal(snes->norm))
    *reason = SLIP_SNES_DIVERGED_NAN;
  else if (snes->norm <= PetscMax(snes->rtol, con->target))
    *reason = SNES_CONVERGED_FNORM_RELATIVE;
  else if (snes->norm <= snes->abstol)
    *reason = SNES_CONVERGED_FNORM_ABS;
  else if (it >= snes->max_its) /* a smaller tolerance may be below rounding */
    *reason = snes->norm <= SLIP_SEARCH_RTOL ? SNES_CONVERGED_FNORM_ABS : SNES_DIVERGED_MAX_IT;
  snes->reason = *reason;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipNaturalResidual(SNES snes, Vec x, Vec f, void *ctx)
{
  SlipConstraint con = (SlipConstraint)ctx;

  PetscFunctionBegin;
  (void)snes;
  PetscCall(SlipConstraintBegin(con, x));
  PetscCall(SlipConstraintEvaluate(con, NULL, x));
  PetscCall(VecCopy(con->F, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SNESSetSlipConstraint - sets the set-valued reaction of a SNES of type "semismooth" or "projection"

  Logically collective

  Input Parameters:
+ snes - the solver; its function becomes the natural residual
- con  - the constraint, of which the solver takes a reference; NULL: none

  Level: intermediate

.seealso: SNESGetSlipConstraint(), SNESSlipSolveStage(), SlipConstraintCreate()
@*/
PetscErrorCode SNESSetSlipConstraint(SNES snes, SlipConstraint con)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(snes, SNES_CLASSID, 1);
  if (con) PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 2);
  PetscCall(PetscObjectCompose((PetscObject)snes, key, (PetscObject)con));
  if (con) PetscCall(SNESSetFunction(snes, NULL, SlipNaturalResidual, con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SNESGetSlipConstraint - gets the constraint of a SNES

  Not collective

  Input Parameter:
. snes - the solver

  Output Parameter:
. con - borrowed; NULL when there is none

  Level: intermediate

.seealso: SNESSetSlipConstraint(), SNESSlipSolveStage()
@*/
PetscErrorCode SNESGetSlipConstraint(SNES snes, SlipConstraint *con)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(snes, SNES_CLASSID, 1);
  PetscAssertPointer(con, 2);
  PetscCall(PetscObjectQuery((PetscObject)snes, key, (PetscObject *)con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SNESSlipSolveStage - solves one implicit stage with its set-valued reaction, G(x) = omega r, r in -q(|x|) Sign(x)

  Collective

  Input Parameters:
+ snes  - of type "semismooth" or "projection", with a constraint
. stage - the stage; passed to the problem's stage operation
- x     - reduced: the initial guess

  Output Parameters:
+ x       - the solution; sticking cells are exactly zero
. r       - the reaction: -q x / |x| where x != 0, |r| <= q elsewhere
- resnorm - largest natural residual divided by max(omega q) + max|G(0)| (dimensionless, NULL allowed)

  Level: advanced

  Errors: PETSC_ERR_ARG_WRONGSTATE without a constraint, PETSC_ERR_SUP for another type of SNES,
  PETSC_ERR_ARG_OUTOFRANGE unless theta > 0 and omega > 0. A solve that does not converge is no error.

  Note:
  Check SNESGetConvergedReason() before you use the result.

.seealso: SNESSetSlipConstraint(), SNESSlipGetWorstCell()
@*/
PetscErrorCode SNESSlipSolveStage(SNES snes, const SlipStage *stage, Vec x, Vec r, PetscReal *resnorm)
{
  SlipConstraint con;
  PetscBool ours;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(snes, SNES_CLASSID, 1);
  PetscAssertPointer(stage, 2);
  PetscCall(SNESGetSlipConstraint(snes, &con));
  PetscCheck(con, PetscObjectComm((PetscObject)snes), PETSC_ERR_ARG_WRONGSTATE,
             "Call SNESSetSlipConstraint() before SNESSlipSolveStage()");
  PetscCall(PetscObjectTypeCompareAny((PetscObject)snes, &ours, SNESSEMISMOOTH, SNESPROJECTION, ""));
  PetscCheck(ours, PetscObjectComm((PetscObject)snes), PETSC_ERR_SUP,
             "-%ssnes_type %s cannot solve a set-valued reaction: use semismooth or projection",
             ((PetscObject)snes)->prefix ? ((PetscObject)snes)->prefix : "", ((PetscObject)snes)->type_name);
  PetscCheck(stage->omega > 0.0 && stage->theta > 0.0, PetscObjectComm((PetscObject)snes), PETSC_ERR_ARG_OUTOFRANGE,
             "A stage needs theta > 0 and omega > 0, not theta %g and omega %g", (double)stage->theta,
             (double)stage->omega);
  con->omega = stage->omega;
  con->share = stage->share;
  con->target = 0;
  if (con->ops->stage) PetscCall((*con->ops->stage)(con, stage, con->ctx));
  PetscCall(SNESSolve(snes, NULL, x));
  PetscCall(VecCopy(con->r, r));
  if (resnorm) *resnorm = con->resnorm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SNESSlipGetWorstCell - gets the cell with the largest natural residual of the last solve, for error messages

  Not collective

  Input Parameter:
. snes - the solver

  Output Parameters:
+ cell     - its number: its global index in q, or its row in the mesh's file; -1 before any solve (NULL allowed)
- residual - its relative residual, dimensionless (NULL allowed)

  Level: advanced

.seealso: SNESSlipSolveStage()
@*/
PetscErrorCode SNESSlipGetWorstCell(SNES snes, PetscInt *cell, PetscReal *residual)
{
  SlipConstraint con;
  Vec size;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  if (con->worst == SLIP_WORST_UNKNOWN) { /* on a device it is found on demand */
    PetscCall(VecDuplicate(con->F, &size));
    PetscCall(VecCopy(con->F, size));
    PetscCall(VecAbs(size));
    PetscCall(VecMax(size, &con->worst, NULL));
    PetscCall(VecDestroy(&size));
  }
  if (cell) *cell = con->number && con->worst >= 0 ? con->number[con->worst] : con->worst;
  if (residual) *residual = con->resnorm;
  PetscFunctionReturn(PETSC_SUCCESS);
}
