/* Static equilibrium: this file solves K x = b for x, and finds out whether K is positive definite. */
#include <slipstep/private/slipelastic.h>
#include <petscksp.h>

/* Largest accepted relative residual of K^-1 b: 1/1000 of the relative excess of the critical start over strength */
#define SLIP_ELASTIC_RESIDUAL 1e-8

/*@
  SlipElasticSolve - solves for the slip that balances a stress if all cells of the fault can slip freely

  Collective; after SlipElasticSetStiffness()

  Input Parameters:
+ el - the medium
- b  - shear stress, times the weights of the stiffness [Pa]

  Input/Output Parameter:
. x - the slip, which solves K x = b [m]; on entry a first guess

  Options Database Key:
. -fault_start_ksp_* - the solver, conjugate gradients by default

  Level: developer

  Note:
  The critical start of a fault exceeds its strength by a relative 1e-5 only, which magnifies an error of K^-1 q by 1e5:
  three passes with tolerance 1e-7 (K is symmetric positive definite) reduce the error to the rounding of K x. A
  residual above 1e-8, which options of the solver can cause, is an error.

  Errors: PETSC_ERR_NOT_CONVERGED

.seealso: SlipElasticApply()
@*/
PetscErrorCode SlipElasticSolve(SlipElastic el, Vec b, Vec x)
{
  const char *prefix = ((PetscObject)el)->prefix ? ((PetscObject)el)->prefix : "";
  PetscReal left, all;
  PetscInt rows;
  KSP ksp;
  PC pc;
  Vec r, d;
  KSPConvergedReason reason;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(MatGetSize(el->K, &rows, NULL));
  PetscCall(KSPCreate(PetscObjectComm((PetscObject)el), &ksp));
  PetscCall(KSPSetOptionsPrefix(ksp, ((PetscObject)el)->prefix));
  PetscCall(KSPAppendOptionsPrefix(ksp, "fault_start_"));
  PetscCall(KSPSetOperators(ksp, el->K, el->K));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-7, 0, 1e10, PetscMax(1000, 10 * rows)));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCSLIPSTAGE));
  PetscCall(KSPSetFromOptions(ksp));
  for (PetscInt pass = 0; pass < 3; pass++) {
    /* a pass of iterative refinement: x += K^-1 (b - K x) */
    PetscCall(SlipElasticGetWork(el, 0, &r));
    PetscCall(SlipElasticGetWork(el, 1, &d));
    PetscCall(MatMult(el->K, x, r));
    PetscCall(VecAYPX(r, -1, b));
    PetscCall(KSPSolve(ksp, r, d));
    PetscCall(KSPGetConvergedReason(ksp, &reason));
    PetscCheck(reason > 0, PetscObjectComm((PetscObject)el), PETSC_ERR_NOT_CONVERGED,
               "K^-1 q of the critical state was not found (%s): is the stiffness positive definite?",
               KSPConvergedReasons[reason]);
    PetscCall(VecAXPY(x, 1, d));
  }
  PetscCall(KSPDestroy(&ksp));
  PetscCall(SlipElasticGetWork(el, 0, &r));
  PetscCall(MatMult(el->K, x, r));
  PetscCall(VecAYPX(r, -1, b));
  PetscCall(VecNorm(r, NORM_2, &left));
  PetscCall(VecNorm(b, NORM_2, &all));
  PetscCheck(left <= SLIP_ELASTIC_RESIDUAL * all, PetscObjectComm((PetscObject)el), PETSC_ERR_NOT_CONVERGED,
             "K^-1 q of the critical state has a relative residual of %.3g, expected at most %.6g: give "
             "-%sfault_start_ksp_rtol, -%sfault_start_ksp_atol or -%sfault_start_ksp_type other values",
             (double)(left / all), SLIP_ELASTIC_RESIDUAL, prefix, prefix, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether conjugate gradients find a slip with no or negative elastic energy. products: largest number of
   products with K; b: the stress with which they start; it should have no symmetry [Pa]; x: work vector, overwritten;
   is: `PETSC_TRUE`: they found such a slip, so K is not positive definite. */
PetscErrorCode SlipElasticIsIndefinite(SlipElastic el, PetscInt products, Vec b, Vec x, PetscBool *is)
{
  KSPConvergedReason reason;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(KSPCreate(PetscObjectComm((PetscObject)el), &ksp));
  PetscCall(KSPSetOperators(ksp, el->K, el->K));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-8, 0, PETSC_MAX_REAL, products));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCNONE));
  PetscCall(KSPSolve(ksp, b, x));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCall(KSPDestroy(&ksp));
  *is = reason == KSP_DIVERGED_INDEFINITE_MAT ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
