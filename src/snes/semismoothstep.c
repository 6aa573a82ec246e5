/* Steps of SNES "semismooth" (semismooth.c): direction, line search, and remedies for active sets that cycle.
   SlipSearch (slipcore.h) makes the decisions. */
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

/* Relative tolerance of a linear solve with an approximate operator, whose error is larger than that. */
static const PetscReal inexact = 5e-3;
/* Residual of a direction over the residual that ends an inexact solve, and relative tolerance of solves that only
   check for instabilities. */
static const PetscReal target_share = 0.3, check = 1e-2;

/* Gets the operator of the linear solves: con->B, or its approximation by "MatSlipGetApproximation_C" (Mat, Mat *).
   With an approximation this is an inexact Newton method: residuals and solutions are still those of con->B. Where the
   approximate Jacobian is positive definite but the true one is not, iterations are repelled, so that they cannot reach
   the wrong branch, as with the true one. */
PetscErrorCode SlipSemismoothOperator(SlipConstraint con, PetscBool exact, Mat *A)
{
  PetscErrorCode (*f)(Mat, Mat *);

  PetscFunctionBegin;
  *A = con->B;
  if (exact) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectQueryFunction((PetscObject)con->B, "MatSlipGetApproximation_C", &f));
  if (f) PetscCall((*f)(con->B, A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves (A + slope) dx = rhs on the sliding set by a Krylov method; pd is false if it finds the matrix indefinite, or
   unstable with a coupling. */
PetscErrorCode SlipSemismoothKrylov(SNES snes, SlipConstraint con, Mat A, Vec slope, Vec cross, PetscBool *ok,
                                    PetscBool *pd)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  Vec rhs = ss->slip.work[SEMISMOOTH_RHS], dx = ss->slip.work[SEMISMOOTH_DX];
  KSPConvergedReason reason;
  PetscInt lits, n;
  PetscReal eta, *real, *imaginary;
  PetscScalar curvature;

  PetscFunctionBegin;
  if (!ss->J) PetscCall(MatCreateSlipJacobian(con->B, &ss->J));
  PetscCall(MatSlipJacobianSetCross(ss->J, cross));
  PetscCall(MatSlipJacobianSetParts(ss->J, A, con->mask, slope));
  if (con->row) {
    PetscBool cg;

    PetscCall(MatSlipJacobianSetCoupling(ss->J, con->C, con->row));
    PetscCall(PetscObjectTypeCompareAny((PetscObject)snes->ksp, &cg, KSPCG, KSPSLIPCG, ""));
    if (cg) PetscCall(KSPSetType(snes->ksp, KSPGMRES));
    PetscCall(KSPSetComputeEigenvalues(snes->ksp, PETSC_TRUE));
  }
  PetscCall(KSPSetOperators(snes->ksp, ss->J, ss->J));
  /* Near quadratic convergence the next residual is of the order of the square of this one: the tolerance is that, but
     not below rounding or the residual that ends the solve. Checks of a Jacobian come after the end of the solve. */
  eta = A == con->B ? PetscMin(1e-2, PetscMax(0.1 * con->norm, SLIP_SEARCH_ROUNDING / con->norm)) : inexact;
  if (con->target > 0 && A == con->B && con->norm > con->target)
    eta = PetscMin(1.0, con->target / con->norm) * target_share;
  else if (con->target > 0 && A == con->B)
    eta = check;
  if (!ss->ksp_set) PetscCall(KSPSetTolerances(snes->ksp, eta, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPSolve(snes->ksp, rhs, dx));
  PetscCall(KSPGetConvergedReason(snes->ksp, &reason));
  PetscCall(KSPGetIterationNumber(snes->ksp, &lits));
  snes->linear_its += lits;
  ss->n_krylov++;
  *ok = reason > 0 || reason == KSP_DIVERGED_ITS ? PETSC_TRUE : PETSC_FALSE;
  *pd = reason != KSP_DIVERGED_INDEFINITE_MAT && reason != KSP_DIVERGED_INDEFINITE_PC ? PETSC_TRUE : PETSC_FALSE;
  if (!con->row) { /* KSPCG detects a change of sign, but not a curvature that is negative from the start */
    PetscCall(VecDot(rhs, dx, &curvature));
    if (PetscRealPart(curvature) < 0.0) *pd = PETSC_FALSE;
  } else if (*ok) {
    /* unstable where an eigenvalue of the preconditioned matrix has no positive real part (SlipSolveGeneral(), with
       the preconditioner for D): such ones are apart from the others and found first if rhs has a part of their modes
     */
    PetscCall(PetscMalloc2(lits, &real, lits, &imaginary));
    PetscCall(KSPComputeEigenvalues(snes->ksp, lits, real, imaginary, &n));
    for (PetscInt i = 0; i < n; i++)
      if (!(real[i] > 0.0)) *pd = PETSC_FALSE;
    PetscCall(PetscFree2(real, imaginary));
  }
  if (!*pd) *ok = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y -= k P x where cells have two components: the term besides F in Newton's step across their directions (cone.c). */
static PetscErrorCode SlipSemismoothAddTransverse(SlipConstraint con, Vec x, Vec y)
{
  PetscInt n;
  const PetscReal *xx, *normal, *hold;
  PetscReal *yy;
  const SlipArrays arrays[] = {
    {x, .read = &xx}, {con->normal, .read = &normal}, {con->hold, .read = &hold}, {y, .write = &yy}};

  PetscFunctionBegin;
  if (!con->cells) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(con->cells, &n));
  PetscCall(SlipArraysGet(4, arrays));
  SlipDiskHold(n, con->components, normal, hold, xx, yy);
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes dx by the first method that works: direct, Krylov, and both again without the slope. On the sliding set s it
   solves J_ss dx_s = -F_s + (A x_t)_s; on the sticking set t, dx = -x. */
PetscErrorCode SlipSemismoothDirection(SNES snes, SlipConstraint con, Mat A, Vec x, PetscBool *picard, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  Vec *work = ss->slip.work, rhs = work[SEMISMOOTH_RHS], dx = work[SEMISMOOTH_DX], xt = work[SEMISMOOTH_XS];
  PetscReal moved;
  PetscBool done, pd;
  Vec image = NULL;

  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(xt, con->mask, x));
  PetscCall(VecAYPX(xt, -1.0, x));
  PetscCall(SlipVecLargest(xt, &moved));
  if (moved > 0.0) {
    PetscCall(MatMult(A, xt, work[SEMISMOOTH_BXT]));
    PetscCall(VecCopy(work[SEMISMOOTH_BXT], rhs));
    PetscCall(SlipConstraintAddCoupling(con, xt, rhs));
  } else
    PetscCall(VecZeroEntries(rhs));
  PetscCall(VecAXPY(rhs, -1.0, con->F));
  PetscCall(SlipSemismoothAddTransverse(con, x, rhs));
  PetscCall(VecPointwiseMult(rhs, con->mask, rhs));
  *ok = PETSC_FALSE;
  for (*picard = PETSC_FALSE;; *picard = PETSC_TRUE) {
    Vec slope = *picard ? work[SEMISMOOTH_ZERO] : con->slope, cross = con->cross;

    if (*picard) PetscCall(SlipConstraintSlope(con, x, NULL, slope, &cross));
    PetscCall(SlipDirectSolve(A, con->C, con->row, con->mask, slope, cross, rhs, dx, ss->direct_max, &done, &pd));
    if (done) {
      snes->linear_its++;
      ss->n_direct++;
      *ok = pd;
    } else
      PetscCall(SlipSemismoothKrylov(snes, con, A, slope, cross, ok, &pd));
    if (pd || *picard) break;
    if (con->refuse) {
      PetscCall(PetscInfo(snes, "Indefinite Jacobian: the step would go past an instability\n"));
      con->unstable = PETSC_TRUE;
      *ok = PETSC_FALSE;
      break;
    }
    PetscCall(PetscInfo(snes, "Indefinite Jacobian: step without the slope of the bound\n"));
    ss->n_picard++;
  }
  PetscCall(VecAXPY(dx, -1.0, xt));
  if (!*ok || !con->ops->affine) PetscFunctionReturn(PETSC_SUCCESS);
  if (!done) PetscTryMethod(snes->ksp, "KSPSlipGetImage_C", (KSP, Vec *), (snes->ksp, &image));
  if (!image)
    PetscCall(MatMult(A, dx, work[SEMISMOOTH_BDX]));
  else if (moved > 0.0)
    PetscCall(VecWAXPY(work[SEMISMOOTH_BDX], -1.0, work[SEMISMOOTH_BXT], image));
  else
    PetscCall(VecCopy(image, work[SEMISMOOTH_BDX]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipSemismoothFrom(SNES snes, SlipConstraint con, Vec x)
{
  const Vec *work = ((SNES_Semismooth *)snes->data)->slip.work;

  PetscFunctionBegin;
  PetscCall(VecCopy(x, work[SEMISMOOTH_XS]));
  if (con->ops->affine) PetscCall(VecCopy(con->g, work[SEMISMOOTH_GS]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipSemismoothMoveTo(SNES snes, SlipConstraint con, const SlipStageModel *model, PetscReal lambda, Vec x)
{
  const Vec *work = ((SNES_Semismooth *)snes->data)->slip.work;

  PetscFunctionBegin;
  PetscCall(VecWAXPY(x, lambda, work[SEMISMOOTH_DX], work[SEMISMOOTH_XS]));
  if (con->ops->affine) {
    PetscCall(VecWAXPY(con->g, lambda, work[SEMISMOOTH_BDX], work[SEMISMOOTH_GS]));
    PetscCall(SlipConstraintEvaluateKnown(con, x));
  } else
    PetscCall(SlipConstraintEvaluate(con, model, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the directional derivative of the stage's energy along dx at the point evaluated last, from the balance of
   the sliding cells. */
static PetscErrorCode SlipSemismoothPush(SNES snes, SlipConstraint con, PetscReal *push)
{
  const Vec *work = ((SNES_Semismooth *)snes->data)->slip.work;
  PetscScalar d;

  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(work[SEMISMOOTH_RHS], con->mask, con->F));
  PetscCall(VecDot(work[SEMISMOOTH_RHS], work[SEMISMOOTH_DX], &d));
  *push = PetscRealPart(d);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a step without the slope from xs, and doubles it while the load still acts in its direction
   (SlipSearchOvershoots()). */
static PetscErrorCode SlipSemismoothExpand(SNES snes, SlipConstraint con, const SlipStageModel *model, Vec x)
{
  PetscReal push, last;

  PetscFunctionBegin;
  PetscCall(SlipSemismoothMoveTo(snes, con, model, 1.0, x));
  PetscCall(SlipSemismoothPush(snes, con, &push));
  for (PetscInt k = 0; k < SLIP_SEARCH_DOUBLINGS && push < 0.0; k++) {
    const PetscReal lambda = PetscPowRealInt(2.0, (int)k + 1);

    last = push;
    PetscCall(SlipSemismoothMoveTo(snes, con, model, lambda, x));
    PetscCall(SlipSemismoothPush(snes, con, &push));
    if (SlipSearchOvershoots(last, push)) PetscCall(SlipSemismoothMoveTo(snes, con, model, 0.5 * lambda, x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the full step from xs, or the one that reverses no cell if that is better, or a shorter one; *stalled: none of
   them was accepted. */
static PetscErrorCode SlipSemismoothSearch(SNES snes, SlipConstraint con, const SlipStageModel *model, Vec x,
                                           PetscBool *stalled)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  const PetscReal last = con->merit;
  PetscReal lambda = 1.0;

  PetscFunctionBegin;
  *stalled = PETSC_TRUE;
  for (PetscInt k = 0; k <= SLIP_SEARCH_HALVINGS && *stalled; k++, lambda *= 0.5) {
    PetscCall(SlipSemismoothMoveTo(snes, con, model, lambda, x));
    if (k == 0 && !SlipSearchSuffices(last, con->merit)) {
      const PetscReal full = con->merit;
      PetscReal count;
      PetscBool turned;
      PetscInt n;
      const PetscScalar *from, *q;
      PetscScalar *to;
      const SlipArrays arrays[] = {
        {ss->slip.work[SEMISMOOTH_XS], .read = &from}, {con->q, .read = &q}, {x, .write = &to}};

      PetscCall(VecGetLocalSize(con->q, &n));
      if (!con->cells) {
        PetscCall(
          SlipLoopRun(SLIP_LOOP_CONE_TURN, n, NULL, (const Vec[]){con->q, ss->slip.work[SEMISMOOTH_XS], x}, &count));
        turned = count > 0 ? PETSC_TRUE : PETSC_FALSE;
      } else {
        PetscCall(SlipArraysGet(3, arrays));
        turned = SlipDiskStopTurning(n, con->components, q, from, to);
        PetscCall(SlipArraysRestore(3, arrays));
      }
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &turned, 1, MPIU_BOOL, MPI_LOR, PetscObjectComm((PetscObject)con)));
      if (turned) {
        PetscCall(SlipConstraintEvaluate(con, model, x));
        if (!(con->merit < full)) PetscCall(SlipSemismoothMoveTo(snes, con, model, 1.0, x));
      }
    }
    if (SlipSearchAccepts(&ss->search, lambda, con->merit)) *stalled = PETSC_FALSE;
  }
  if (*stalled) PetscCall(SlipSemismoothMoveTo(snes, con, model, 1.0, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a few steps of the fixed point, which cannot cycle for small slopes. */
PetscErrorCode SlipSemismoothProject(SNES snes, SlipConstraint con, const SlipStageModel *model, Vec x)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  const Vec *work = ss->slip.work;

  PetscFunctionBegin;
  PetscCall(VecCopy(con->rho, work[SEMISMOOTH_RHO]));
  for (PetscInt k = 0; k < SLIP_SEARCH_PROJECTIONS; k++)
    PetscCall(SlipProjectionStep(con, model, x, work[SEMISMOOTH_RHO], work[SEMISMOOTH_DX], work[SEMISMOOTH_RHS]));
  ss->search.stalls = 0;
  ss->n_projections++;
  SlipSearchForget(&ss->search, con->merit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a step from the point evaluated last; ok is false if no direction was found. */
PetscErrorCode SlipSemismoothStep(SNES snes, SlipConstraint con, const SlipStageModel *model, PetscInt it,
                                  PetscReal tolerance, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool picard, stalled = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipSemismoothDirection(snes, con, model ? model->A : con->B, x, &picard, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipSemismoothFrom(snes, con, x));
  if (picard) { /* it leaves the neighbourhood in which the merit function is meaningful */
    PetscCall(SlipSemismoothExpand(snes, con, model, x));
    if (con->ops->affine) PetscCall(SlipConstraintEvaluate(con, model, x)); /* ends rounding of large sums */
    SlipSearchForget(&ss->search, con->merit);
  } else
    PetscCall(SlipSemismoothSearch(snes, con, model, x, &stalled));
  SlipSearchRemember(&ss->search, it, con->merit);
  if (con->norm > tolerance && SlipSearchStuck(&ss->search, stalled, con->merit)) {
    PetscCall(PetscInfo(snes, "Three steps without decrease: %d projection steps\n", (int)SLIP_SEARCH_PROJECTIONS));
    PetscCall(SlipSemismoothProject(snes, con, model, x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
