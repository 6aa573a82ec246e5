/* KSP "slipcg": preconditioned conjugate gradients (Hestenes and Stiefel 1952) that also compute the product of the
   stage operator B with their solution. A product with the Jacobian of a stage contains that of B with the direction in
   all rows, sticking cells included. Their sum is B dx, so that the residual of the stage after the step needs no
   product. */
#include <slipstep/private/slipsnes.h>
#include <petsc/private/kspimpl.h>

typedef struct {
  Vec image; /* B x */
} SlipCG;

enum { CG_R, CG_Z, CG_P, CG_W, CG_NWORK };

static PetscErrorCode KSPSetUp_SlipCG(KSP ksp)
{
  SlipCG *cg = (SlipCG *)ksp->data;

  PetscFunctionBegin;
  PetscCall(KSPSetWorkVecs(ksp, CG_NWORK));
  if (!cg->image) PetscCall(VecDuplicate(ksp->work[CG_R], &cg->image));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes z = P r and r.z. */
static PetscErrorCode SlipCGPrecondition(KSP ksp, PetscReal *rz)
{
  PetscFunctionBegin;
  PetscCall(KSP_PCApply(ksp, ksp->work[CG_R], ksp->work[CG_Z]));
  PetscCall(VecDot(ksp->work[CG_R], ksp->work[CG_Z], rz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tests convergence in iteration it, and computes z = P r unless the test needs no z and ends the solve, because the
   preconditioner costs as much as a product. */
static PetscErrorCode SlipCGTest(KSP ksp, PetscInt it, PetscReal *rz)
{
  const PetscBool late = ksp->normtype == KSP_NORM_UNPRECONDITIONED ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (!late) PetscCall(SlipCGPrecondition(ksp, rz));
  ksp->rnorm = 0;
  if (ksp->normtype == KSP_NORM_PRECONDITIONED)
    PetscCall(VecNorm(ksp->work[CG_Z], NORM_2, &ksp->rnorm));
  else if (ksp->normtype == KSP_NORM_UNPRECONDITIONED)
    PetscCall(VecNorm(ksp->work[CG_R], NORM_2, &ksp->rnorm));
  else if (ksp->normtype == KSP_NORM_NATURAL)
    ksp->rnorm = PetscSqrtReal(PetscAbsReal(*rz));
  ksp->its = it;
  PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
  PetscCall(KSPMonitor(ksp, it, ksp->rnorm));
  PetscCall((*ksp->converged)(ksp, it, ksp->rnorm, &ksp->reason, ksp->cnvP));
  if (ksp->reason) PetscFunctionReturn(PETSC_SUCCESS);
  if (late) PetscCall(SlipCGPrecondition(ksp, rz));
  if (!(*rz > 0)) ksp->reason = *rz == 0 ? KSP_CONVERGED_ATOL : KSP_DIVERGED_INDEFINITE_PC;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KSPSolve_SlipCG(KSP ksp)
{
  SlipCG *cg = (SlipCG *)ksp->data;
  Vec r = ksp->work[CG_R], z = ksp->work[CG_Z], p = ksp->work[CG_P], w = ksp->work[CG_W], x = ksp->vec_sol, product;
  PetscReal rz = 0, last = 0, curvature;
  Mat J;

  PetscFunctionBegin;
  PetscCall(PCGetOperators(ksp->pc, &J, NULL));
  PetscCall(MatSlipJacobianGetProduct(J, &product));
  PetscCheck(ksp->guess_zero, PetscObjectComm((PetscObject)ksp), PETSC_ERR_SUP,
             "KSP type %s starts from zero: unset -ksp_initial_guess_nonzero, or use -ksp_type cg", KSPSLIPCG);
  PetscCall(VecZeroEntries(x));
  PetscCall(VecZeroEntries(cg->image));
  PetscCall(VecCopy(ksp->vec_rhs, r));
  PetscCall(SlipCGTest(ksp, 0, &rz));
  for (PetscInt it = 1; !ksp->reason; it++) {
    if (it > ksp->max_it) {
      ksp->reason = KSP_DIVERGED_ITS;
      break;
    }
    if (it == 1)
      PetscCall(VecCopy(z, p));
    else
      PetscCall(VecAYPX(p, rz / last, z));
    PetscCall(KSP_MatMult(ksp, J, p, w));
    ksp->its = it;
    PetscCall(VecDot(p, w, &curvature));
    if (!(curvature > 0)) {
      ksp->reason = PetscIsInfOrNanReal(curvature) ? KSP_DIVERGED_NANORINF : KSP_DIVERGED_INDEFINITE_MAT;
      break;
    }
    PetscCall(VecAXPY(x, rz / curvature, p));
    PetscCall(VecAXPY(cg->image, rz / curvature, product));
    PetscCall(VecAXPY(r, -rz / curvature, w));
    last = rz;
    PetscCall(SlipCGTest(ksp, it, &rz));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KSPSlipGetImage_SlipCG(KSP ksp, Vec *image)
{
  PetscFunctionBegin;
  *image = ((SlipCG *)ksp->data)->image;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KSPReset_SlipCG(KSP ksp)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&((SlipCG *)ksp->data)->image));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode KSPDestroy_SlipCG(KSP ksp)
{
  PetscFunctionBegin;
  PetscCall(KSPReset_SlipCG(ksp));
  PetscCall(PetscObjectComposeFunction((PetscObject)ksp, "KSPSlipGetImage_C", NULL));
  PetscCall(KSPDestroyDefault(ksp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  KSPSLIPCG - "slipcg": conjugate gradients that also compute the product of the stage operator with their solution

  Level: advanced

  Notes:
  The matrix must be of type MATSLIPJACOBIAN, the first guess zero, and the preconditioner symmetric positive definite.
  It is the default of SNESSEMISMOOTH, which with any other type needs one more product for each direction.

.seealso: SNESSEMISMOOTH, MatCreateSlipJacobian(), PCSLIPSTAGE
M*/
PetscErrorCode KSPCreate_SlipCG(KSP ksp)
{
  SlipCG *cg;

  PetscFunctionBegin;
  PetscCall(PetscNew(&cg));
  ksp->data = cg;
  PetscCall(KSPSetSupportedNorm(ksp, KSP_NORM_UNPRECONDITIONED, PC_LEFT, 3));
  PetscCall(KSPSetSupportedNorm(ksp, KSP_NORM_PRECONDITIONED, PC_LEFT, 2));
  PetscCall(KSPSetSupportedNorm(ksp, KSP_NORM_NATURAL, PC_LEFT, 2));
  PetscCall(KSPSetSupportedNorm(ksp, KSP_NORM_NONE, PC_LEFT, 1));
  ksp->ops->setup = KSPSetUp_SlipCG;
  ksp->ops->solve = KSPSolve_SlipCG;
  ksp->ops->reset = KSPReset_SlipCG;
  ksp->ops->destroy = KSPDestroy_SlipCG;
  ksp->ops->buildsolution = KSPBuildSolutionDefault;
  ksp->ops->buildresidual = KSPBuildResidualDefault;
  PetscCall(PetscObjectComposeFunction((PetscObject)ksp, "KSPSlipGetImage_C", KSPSlipGetImage_SlipCG));
  PetscFunctionReturn(PETSC_SUCCESS);
}
