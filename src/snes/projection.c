/* SNES "projection": the self-adaptive fixed point x <- S(x - rho G(x), rho omega q).

   This is the published solver of the problem class and the plain reference for the semismooth one. rho is 1/diag(B)
   times one factor for the block of rates, adapted as in self-adaptive projection methods (He and Liao 2002, JOTA 112):
   with the ratio rho |G(x') - G(x)| / |x' - x| in the norms of diag(B), shorten by 2/3 and repeat the step above 0.9,
   lengthen by 3/2 below 0.3. A factor per cell does not work: the change of an cell's G is mostly its neighbours'
   doing, so cells that are already at rest would shorten theirs to nothing. */
#include <slipstep/private/slipsnes.h>
#include <slipcore.h>
#include <slipstep/private/slipsys.h>

static const PetscReal ratio_high = 0.9, ratio_low = 0.3, shorten = 2.0 / 3.0, lengthen = 1.5;
enum { max_trials = 20 };

typedef struct {
  Vec rho, x1, g1;
} SNES_Projection;

/* x1 = S(x - rho g, rho omega q) */
static PetscErrorCode SlipProject(SlipConstraint con, Vec x, Vec rho, Vec x1)
{
  PetscInt n;
  const PetscScalar *xx, *g, *q, *p;
  PetscScalar *y;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(SLIP_Cone, con, x, 0, 0));
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &xx));
  PetscCall(VecGetArrayRead(con->g, &g));
  PetscCall(VecGetArrayRead(con->q, &q));
  PetscCall(VecGetArrayRead(rho, &p));
  PetscCall(VecGetArrayWrite(x1, &y));
  for (PetscInt i = 0; i < n; i++) y[i] = SlipConeShrink(xx[i] - p[i] * g[i], p[i] * con->omega * q[i]);
  PetscCall(VecRestoreArrayWrite(x1, &y));
  PetscCall(VecRestoreArrayRead(rho, &p));
  PetscCall(VecRestoreArrayRead(con->q, &q));
  PetscCall(VecRestoreArrayRead(con->g, &g));
  PetscCall(VecRestoreArrayRead(x, &xx));
  PetscCall(PetscLogEventEnd(SLIP_Cone, con, x, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sum over the cells of a_i^2 rho_i and b_i^2 / rho_i, a = g1 - g, b = x1 - x, and from them the ratio */
static PetscErrorCode SlipRatio(SlipConstraint con, Vec x, Vec x1, Vec g1, Vec rho, PetscReal *ratio)
{
  PetscInt n;
  const PetscScalar *xx, *g, *y, *h, *p;
  PetscReal sum[2] = {0.0, 0.0};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &xx));
  PetscCall(VecGetArrayRead(con->g, &g));
  PetscCall(VecGetArrayRead(x1, &y));
  PetscCall(VecGetArrayRead(g1, &h));
  PetscCall(VecGetArrayRead(rho, &p));
  for (PetscInt i = 0; i < n; i++) {
    sum[0] += PetscSqr(h[i] - g[i]) * p[i];
    sum[1] += PetscSqr(y[i] - xx[i]) / p[i];
  }
  PetscCall(VecRestoreArrayRead(rho, &p));
  PetscCall(VecRestoreArrayRead(g1, &h));
  PetscCall(VecRestoreArrayRead(x1, &y));
  PetscCall(VecRestoreArrayRead(con->g, &g));
  PetscCall(VecRestoreArrayRead(x, &xx));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)con)));
  *ratio = sum[1] > 0.0 ? PetscSqrtReal(sum[0] / sum[1]) : ratio_high;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One step from a point that has been evaluated, ending at one that has been evaluated */
PetscErrorCode SlipProjectionStep(SlipConstraint con, Vec x, Vec rho, Vec x1, Vec g1)
{
  PetscReal ratio;

  PetscFunctionBegin;
  for (PetscInt trial = 0;; trial++) {
    PetscCall(SlipProject(con, x, rho, x1));
    PetscCall(SlipConstraintResidual(con, x1, g1));
    PetscCall(SlipRatio(con, x, x1, g1, rho, &ratio));
    if (ratio <= ratio_high || trial >= max_trials) break;
    PetscCall(VecScale(rho, shorten * PetscMin(1.0, 1.0 / ratio)));
  }
  if (ratio < ratio_low) PetscCall(VecScale(rho, lengthen));
  PetscCall(VecCopy(x1, x));
  PetscCall(SlipConstraintEvaluate(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSolve_Projection(SNES snes)
{
  SNES_Projection *pr = (SNES_Projection *)snes->data;
  SlipConstraint con;
  SNESConvergedReason reason;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  PetscCall(SlipConstraintBegin(con, snes->vec_sol));
  PetscCall(VecCopy(con->rho, pr->rho));
  PetscCall(SlipConstraintEvaluate(con, snes->vec_sol));
  PetscCall(SlipConstraintReport(snes, con, 0, &reason));
  for (PetscInt it = 1; reason == SNES_CONVERGED_ITERATING; it++) {
    PetscTryTypeMethod(snes, update, snes->iter);
    PetscCall(SlipProjectionStep(con, snes->vec_sol, pr->rho, pr->x1, pr->g1));
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
  }
  PetscCall(SlipConstraintFinish(con, snes->vec_sol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSetUp_Projection(SNES snes)
{
  SNES_Projection *pr = (SNES_Projection *)snes->data;
  SlipConstraint con;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  PetscCall(VecDuplicate(con->x, &pr->rho));
  PetscCall(VecDuplicate(con->x, &pr->x1));
  PetscCall(VecDuplicate(con->x, &pr->g1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESReset_Projection(SNES snes)
{
  SNES_Projection *pr = (SNES_Projection *)snes->data;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&pr->rho));
  PetscCall(VecDestroy(&pr->x1));
  PetscCall(VecDestroy(&pr->g1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESDestroy_Projection(SNES snes)
{
  PetscFunctionBegin;
  PetscCall(SNESReset_Projection(snes));
  PetscCall(PetscFree(snes->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  SNESPROJECTION - "projection": self-adaptive fixed point on the natural map of the cone

  Options Database Keys:
+ -snes_rtol <1e-10> - largest natural residual over max(omega q) + max|G(0)|, dimensionless
- -snes_max_it <200> - iterations before the solve has failed

  Level: intermediate

.seealso: SNESSEMISMOOTH, SNESSetSlipConstraint()
M*/
PetscErrorCode SNESCreate_Projection(SNES snes)
{
  SNES_Projection *pr;

  PetscFunctionBegin;
  PetscCall(PetscNew(&pr));
  snes->data = pr;
  snes->ops->solve = SNESSolve_Projection;
  snes->ops->setup = SNESSetUp_Projection;
  snes->ops->reset = SNESReset_Projection;
  snes->ops->destroy = SNESDestroy_Projection;
  snes->usesksp = PETSC_FALSE;
  snes->usesnpc = PETSC_FALSE;
  snes->alwayscomputesfinalresidual = PETSC_TRUE;
  SlipSNESDefaults(snes, 1e-10, 200);
  PetscFunctionReturn(PETSC_SUCCESS);
}
