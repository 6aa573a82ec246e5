/* SNES "projection": the self-adaptive fixed point x <- S(x - rho G(x), rho omega q).

   This is the published solver of the problem class, and the simple reference for the semismooth one. rho is 1/diag(B)
   times one factor for the block of rates, adapted as in self-adaptive projection methods (He and Liao 2002, JOTA 112):
   if the ratio rho |G(x') - G(x)| / |x' - x| in the norms of diag(B) is above 0.9 the factor shrinks by 2/3 and the
   step is repeated, and below 0.3 it grows by 3/2 (SlipConeAdaptStep()). A factor per cell does not work: G of a cell
   changes mostly by its neighbours, so that cells which already rest would shrink their factors to zero. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

enum { PROJECTION_RHO, PROJECTION_X1, PROJECTION_G1, PROJECTION_NWORK };

/* Takes one step from an evaluated point, and evaluates the new point. */
PetscErrorCode SlipProjectionStep(SlipConstraint con, const SlipStageModel *model, Vec x, Vec rho, Vec x1, Vec g1)
{
  PetscBool again = PETSC_TRUE;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(con->q, &n));
  for (PetscInt trial = 0; again; trial++) {
    const PetscScalar *xx, *xx1, *g, *gg1, *q, *p;
    PetscScalar *y;
    const SlipArrays from[] = {{x, .read = &xx}, {con->g, .read = &g}, {con->q, .read = &q}, {rho, .read = &p}};
    const SlipArrays both[] = {{x1, .read = &xx1}, {g1, .read = &gg1}};
    PetscReal sum[2] = {0.0, 0.0}, factor;

    PetscCall(PetscLogEventBegin(SLIP_Cone, con, x, 0, 0));
    PetscCall(SlipArraysGet(4, from));
    PetscCall(VecGetArrayWrite(x1, &y));
    if (con->cells)
      SlipDiskProject(n, con->components, con->omega, xx, g, q, p, y);
    else
      SlipConeProject(n, con->omega, xx, g, q, p, y);
    if (con->friction) SlipContactProject(n, xx, g, p, y);
    PetscCall(VecRestoreArrayWrite(x1, &y));
    PetscCall(PetscLogEventEnd(SLIP_Cone, con, x, 0, 0));
    PetscCall(SlipConstraintResidual(con, model, x1, g1));
    PetscCall(SlipArraysGet(2, both));
    SlipConeChanges(con->components * n, xx, xx1, g, gg1, p, sum);
    PetscCall(SlipArraysRestore(2, both));
    PetscCall(SlipArraysRestore(4, from));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)con)));
    again = SlipConeAdaptStep(trial, sum, &factor);
    if (factor != 1.0) PetscCall(VecScale(rho, factor));
  }
  PetscCall(VecCopy(x1, x));
  PetscCall(SlipConstraintEvaluate(con, model, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSolve_Projection(SNES snes)
{
  Vec *work = ((SNES_Slip *)snes->data)->work, x = snes->vec_sol;
  SlipConstraint con;
  SNESConvergedReason reason;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  PetscCheck(!con->ops->solve_cells, PetscObjectComm((PetscObject)snes), PETSC_ERR_SUP,
             "-%ssnes_type projection cannot solve with a smooth bound: use semismooth",
             ((PetscObject)snes)->prefix ? ((PetscObject)snes)->prefix : "");
  PetscCall(SlipConstraintBegin(con, x));
  PetscCall(VecCopy(con->rho, work[PROJECTION_RHO]));
  PetscCall(SlipConstraintEvaluate(con, NULL, x));
  PetscCall(SlipConstraintReport(snes, con, 0, &reason));
  for (PetscInt it = 1; reason == SNES_CONVERGED_ITERATING; it++) {
    PetscTryTypeMethod(snes, update, snes->iter);
    PetscCall(SlipProjectionStep(con, NULL, x, work[PROJECTION_RHO], work[PROJECTION_X1], work[PROJECTION_G1]));
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
  }
  PetscCall(SlipConstraintFinish(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  SNESPROJECTION - "projection": self-adaptive fixed point on the natural map of the cone

  Options Database Keys:
+ -snes_rtol <1e-10> - largest natural residual over max(omega q) + max|G(0)|, dimensionless
- -snes_max_it <200> - iterations after which the solve has failed

  Level: intermediate

.seealso: SNESSEMISMOOTH, SNESSetSlipConstraint()
M*/
PetscErrorCode SNESCreate_Projection(SNES snes)
{
  SNES_Slip *slip;

  PetscFunctionBegin;
  PetscCall(PetscNew(&slip));
  PetscCall(SNESCreate_Slip(snes, slip, PROJECTION_NWORK, 200));
  snes->ops->solve = SNESSolve_Projection;
  snes->usesksp = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
