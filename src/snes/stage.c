/* One stage as a SNES: natural residual, convergence, reaction. Shared by the semismooth and projection types. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

static const char key[] = "SlipConstraint";

/* Work vectors, on first use */
PetscErrorCode SlipConstraintSetUpWork(SlipConstraint con)
{
  Vec *work[] = {&con->r, &con->g, &con->q, &con->dq, &con->F, &con->mask, &con->slope, &con->rho};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(work); i++)
    if (!*work[i]) PetscCall(VecDuplicate(con->x, work[i]));
  if (con->ops->coupling && !con->row) {
    PetscCall(VecDuplicate(con->x, &con->row));
    PetscCall(VecDuplicate(con->x, &con->cx));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintJacobian(SlipConstraint con, Vec x)
{
  PetscFunctionBegin;
  PetscCall((*con->ops->jacobian)(con, x, &con->B, con->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* B, rho = 1/diag(B) and the characteristic traction max(omega q) + max |G(0)| at the start of a solve */
PetscErrorCode SlipConstraintBegin(SlipConstraint con, Vec x)
{
  PetscReal qmax, cmax, dmin;

  PetscFunctionBegin;
  PetscCall(SlipConstraintSetUpWork(con));
  if (con->ops->at_rest) /* saves a product with the operator in each stage */
    PetscCall((*con->ops->at_rest)(con, con->g, con->ctx));
  else {
    PetscCall(VecZeroEntries(con->x));
    PetscCall((*con->ops->residual)(con, con->x, con->g, con->ctx));
  }
  PetscCall(VecNorm(con->g, NORM_INFINITY, &cmax));
  PetscCall((*con->ops->bound)(con, x, con->q, NULL, con->ctx));
  PetscCall(VecNorm(con->q, NORM_INFINITY, &qmax));
  con->scale = con->omega * qmax + cmax;
  if (con->scale == 0.0) con->scale = 1.0;
  PetscCall(SlipConstraintJacobian(con, x));
  PetscCall(MatGetDiagonal(con->B, con->rho));
  PetscCall(VecMin(con->rho, NULL, &dmin));
  PetscCheck(dmin > 0.0, PetscObjectComm((PetscObject)con), PETSC_ERR_ARG_OUTOFRANGE,
             "The stage operator has the diagonal entry %g; it must be positive definite", (double)dmin);
  PetscCall(VecReciprocal(con->rho));
  if (!con->ops->solve_cells) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecSet(con->mask, 1.0));
  if (con->ops->prescribed) PetscCall((*con->ops->prescribed)(con, con->mask, con->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* g = G(x) of the stage, or of its model */
PetscErrorCode SlipConstraintResidual(SlipConstraint con, const SlipStageModel *model, Vec x, Vec g)
{
  PetscFunctionBegin;
  if (model)
    PetscCall(MatMultAdd(model->A, x, model->offset, g));
  else
    PetscCall((*con->ops->residual)(con, x, g, con->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* C and the factors of its rows: omega sign a where a cell slides against a bound */
static PetscErrorCode SlipConstraintCoupling(SlipConstraint con)
{
  PetscInt n;
  const PetscScalar *g, *F, *q, *mask;
  PetscScalar *row;
  const SlipArrays arrays[] = {{con->g, .read = &g},
                               {con->F, .read = &F},
                               {con->q, .read = &q},
                               {con->mask, .read = &mask},
                               {con->row, .write = &row}};

  PetscFunctionBegin;
  PetscCall((*con->ops->coupling)(con, &con->C, con->row, con->ctx));
  PetscCall(VecGetLocalSize(con->row, &n));
  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < n; i++)
    row[i] = mask[i] != 0.0 && q[i] > 0.0 ? (F[i] > g[i] ? con->omega : -con->omega) * row[i] : 0.0;
  PetscCall(SlipArraysRestore(5, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintAddCoupling(SlipConstraint con, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (!con->C) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatMult(con->C, x, con->cx));
  PetscCall(VecPointwiseMult(con->cx, con->cx, con->row));
  PetscCall(VecAXPY(y, 1.0, con->cx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipConstraintEvaluate(SlipConstraint con, const SlipStageModel *model, Vec x)
{
  PetscInt n;
  const PetscScalar *xx, *g, *q, *dq, *rho;
  PetscScalar *F, *mask, *slope;
  const SlipArrays arrays[] = {
    {x, .read = &xx},         {con->g, .read = &g},  {con->q, .read = &q},        {con->dq, .read = &dq},
    {con->rho, .read = &rho}, {con->F, .write = &F}, {con->mask, .write = &mask}, {con->slope, .write = &slope}};

  PetscFunctionBegin;
  PetscCall(SlipConstraintResidual(con, model, x, con->g));
  PetscCall(PetscLogEventBegin(SLIP_Cone, con, x, 0, 0));
  PetscCall((*con->ops->bound)(con, x, con->q, con->dq, con->ctx));
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(SlipArraysGet(8, arrays));
  if (con->ops->solve_cells)
    SlipConeSmooth(n, con->omega, xx, g, q, dq, mask, F, slope);
  else
    SlipConeNatural(n, con->omega, xx, g, q, dq, rho, F, mask, slope);
  PetscCall(SlipArraysRestore(8, arrays));
  if (con->ops->coupling) PetscCall(SlipConstraintCoupling(con));
  PetscCall(VecNorm(con->F, NORM_2, &con->merit));
  PetscCall(VecNorm(con->F, NORM_INFINITY, &con->norm));
  con->merit /= con->scale;
  con->norm /= con->scale;
  PetscCall(PetscLogEventEnd(SLIP_Cone, con, x, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sticking cells to exactly zero, the reaction inside the cone, the cell with the largest residual */
PetscErrorCode SlipConstraintFinish(SlipConstraint con, Vec x)
{
  PetscInt n, rstart;
  const PetscScalar *g, *q, *F, *rho;
  PetscScalar *xx, *r;
  struct {
    double value;
    int index;
  } mine = {-1.0, -1}, all;
  const SlipArrays arrays[] = {{x, .write = &xx},    {con->r, .write = &r}, {con->g, .read = &g},
                               {con->q, .read = &q}, {con->F, .read = &F},  {con->rho, .read = &rho}};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetOwnershipRange(x, &rstart, NULL));
  PetscCall(SlipArraysGet(6, arrays));
  if (con->ops->solve_cells)
    for (PetscInt i = 0; i < n; i++) r[i] = xx[i] > 0 ? -q[i] : q[i];
  else
    SlipConeFinish(n, con->omega, g, q, rho, xx, r);
  for (PetscInt i = 0; i < n; i++) {
    /* NaN counts as the largest */
    if (PetscAbsReal(F[i]) <= mine.value) continue;
    mine.value = PetscIsInfOrNanReal(F[i]) ? PETSC_MAX_REAL : PetscAbsReal(F[i]);
    mine.index = (int)(rstart + i);
  }
  PetscCall(SlipArraysRestore(6, arrays));
  PetscCallMPI(MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE_INT, MPI_MAXLOC, PetscObjectComm((PetscObject)con)));
  con->worst = all.index;
  con->resnorm = con->norm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* slip: what the type keeps, or its first member */
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
  PetscCheck(*con, PetscObjectComm((PetscObject)snes), PETSC_ERR_ARG_WRONGSTATE,
             "SNES type %s solves problems with a set-valued reaction: call SNESSetSlipConstraint() first",
             ((PetscObject)snes)->type_name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bookkeeping of one iterate: monitors, history and the convergence test */
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
  else if (snes->norm <= snes->rtol)
    *reason = SNES_CONVERGED_FNORM_RELATIVE;
  else if (snes->norm <= snes->abstol)
    *reason = SNES_CONVERGED_FNORM_ABS;
  else if (it >= snes->max_its) /* a smaller tolerance may be below what rounding leaves */
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
  SNESSetSlipConstraint - give a SNES of type "semismooth" or "projection" the set-valued reaction to solve with

  Logically collective

  Input Parameters:
+ snes - the solver; its function becomes the natural residual
- con  - the constraint (a reference is kept)

  Level: intermediate

.seealso: SNESGetSlipConstraint(), SNESSlipSolveStage(), SlipConstraintCreate()
@*/
PetscErrorCode SNESSetSlipConstraint(SNES snes, SlipConstraint con)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(snes, SNES_CLASSID, 1);
  PetscValidHeaderSpecific(con, SLIP_CONSTRAINT_CLASSID, 2);
  PetscCall(PetscObjectCompose((PetscObject)snes, key, (PetscObject)con));
  PetscCall(SNESSetFunction(snes, NULL, SlipNaturalResidual, con));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SNESGetSlipConstraint - the constraint of a SNES

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
  SNESSlipSolveStage - solve one implicit stage with its set-valued reaction, G(x) = omega r, r in -q(|x|) Sign(x)

  Collective

  Input Parameters:
+ snes  - of type "semismooth" or "projection", with a constraint
. stage - the stage; passed to the problem's stage operation
- x     - reduced: the initial guess

  Output Parameters:
+ x       - the solution; sticking cells are exactly zero
. r       - the reaction: -q sign(x) where x != 0, inside [-q, q] elsewhere
- resnorm - largest natural residual divided by max(omega q) + max|G(0)| (dimensionless, NULL allowed)

  Level: advanced

  Errors: PETSC_ERR_ARG_WRONGSTATE without a constraint, PETSC_ERR_SUP for another type of SNES,
  PETSC_ERR_ARG_OUTOFRANGE unless theta > 0 and omega > 0. A solve that does not converge is none.

  Note:
  Look at SNESGetConvergedReason() before using the result.

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
  if (con->ops->stage) PetscCall((*con->ops->stage)(con, stage, con->ctx));
  PetscCall(SNESSolve(snes, NULL, x));
  PetscCall(VecCopy(con->r, r));
  if (resnorm) *resnorm = con->resnorm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SNESSlipGetWorstCell - the cell with the largest natural residual of the last solve, for error messages

  Not collective

  Input Parameter:
. snes - the solver

  Output Parameters:
+ cell  - its number: its global index in x, or its row in the mesh's file; -1 before any solve (NULL allowed)
- residual - that residual, relative, dimensionless (NULL allowed)

  Level: advanced

.seealso: SNESSlipSolveStage()
@*/
PetscErrorCode SNESSlipGetWorstCell(SNES snes, PetscInt *cell, PetscReal *residual)
{
  SlipConstraint con;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  if (cell) *cell = con->number && con->worst >= 0 ? con->number[con->worst] : con->worst;
  if (residual) *residual = con->resnorm;
  PetscFunctionReturn(PETSC_SUCCESS);
}
