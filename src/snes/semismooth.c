/* SNES "semismooth": Newton's method on the natural map of the cone.

   A sliding cell has its row of dG/dx plus the slope of its bound, and a sticking one a row of the identity, so that
   each step is a symmetric linear system on the sliding set (the primal-dual active set method if the bound is
   constant: Hintermueller, Ito and Kunisch 2003, SIAM J. Optim. 13).

   A bound that weakens with |x| can make that system indefinite in a long time step: the stage then has several
   solutions, and those with an indefinite Jacobian are unstable branches that no shorter time step reaches. There the
   step omits the weakening slope (a Picard step with a frozen bound): dG/dx is positive definite, the step decreases
   the stage's energy, and unstable solutions repel it. It converges only to a solution with a positive definite
   Jacobian, so that no stage ends on the wrong branch. Where bounds also depend on other rows the Jacobian is not
   symmetric, and the real parts of its eigenvalues must be positive (direct.c). */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

/* Share of the residual to which the model of an approximate operator is solved: its own error is about as large. */
static const PetscReal model_share = 1e-2;
/* Allowed relative error of products with dG/dx far from earlier points, while the residual is above loose_from: an
   approximate operator has an error of about 1e-3 there, and the product at the next point is exact again. */
static const PetscReal loose_share = 2e-4, loose_from = 1e-8;
/* Allowed error of products with dG/dx over the residual that ends a solve */
static const PetscReal wanted_share = 0.1;
/* Residuals need not go below this share of an operator's own error. */
static const PetscReal noise_share = 0.3;

/* Slopes of the bound at a stage's start and end count as equal if they differ by less, over the diagonal of dG/dx. */
static const PetscReal small_change = 1e-3;

enum {
  patience = 4,       /* iterations in a row in which an approximate operator may fail to halve the residual */
  model_steps = 200,  /* most Newton steps on a model */
  model_project = 8,  /* number of these after which projection steps help the sliding set to converge */
  vectors_project = 8 /* iterations with two components a cell after which projection steps help */
};

/* Estimates the smallest possible residual, from rounding or from the operator's own error of dG/dx x. */
static PetscErrorCode SlipSemismoothFloor(SlipConstraint con, PetscReal *floor)
{
  PetscReal noise = 0;
  PetscInt n;

  PetscFunctionBegin;
  PetscTryMethod(con->B, "MatSlipGetNoise_C", (Mat, PetscReal *), (con->B, &noise));
  PetscCall(VecGetSize(con->x, &n));
  *floor = PetscMax(SLIP_SEARCH_ROUNDING, noise_share * noise / (PetscSqrtReal((PetscReal)n) * con->scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reduces the residual from the tolerance to that floor with plain Newton steps, usually one. The residual is relative
   to the strength, for which slow slip rates are many orders too small to matter: only at the floor are they accurate
   enough for runs on any number of ranks to agree. It ends at the better point when the residual no longer halves. */
static PetscErrorCode SlipSemismoothPolish(SNES snes, SlipConstraint con, PetscBool exact, Vec x)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  Vec dx = ss->slip.work[SEMISMOOTH_DX];
  SNESConvergedReason reason;
  PetscReal last, step, size, floor = 0;
  PetscBool ok, picard;
  Mat A;

  PetscFunctionBegin;
  for (PetscInt it = snes->iter + 1; it <= snes->max_its; it++) {
    PetscCall(SlipSemismoothFloor(con, &floor));
    if (con->norm <= floor) break;
    last = con->norm;
    PetscCall(SlipConstraintJacobian(con, x));
    PetscCall(SlipSemismoothOperator(con, exact, &A));
    PetscCall(SlipSemismoothDirection(snes, con, A, x, &picard, &ok));
    if (con->unstable) {
      snes->reason = SNES_DIVERGED_LINEAR_SOLVE;
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    if (!ok || picard) break;
    PetscCall(SlipSemismoothFrom(snes, con, x));
    PetscCall(SlipSemismoothMoveTo(snes, con, NULL, 1.0, x));
    if (!(con->norm < last)) {
      PetscCall(SlipSemismoothMoveTo(snes, con, NULL, 0.0, x));
      break;
    }
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
    PetscCall(SlipConstraintNorm(con, dx, &step));
    PetscCall(SlipConstraintNorm(con, x, &size));
    if (A != con->B) step *= con->norm / last; /* the remaining error, as convergence is linear */
    if (SlipSearchPolished(last, con->norm, step, size)) break;
  }
  snes->reason = SNES_CONVERGED_FNORM_RELATIVE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes a step with an approximate operator A: to the solution of the stage with G(y) + A (x - y) for G(x), where y is
   the point evaluated last. A step needs G once, and A until the sliding set has converged. It reduces the error by a
   factor |A^-1 (B - A)| that does not depend on this set, while single Newton steps with A would first have to find the
   set (Josephy 1979, MRC Technical Report 1965: Newton's method for generalised equations). */
static PetscErrorCode SlipSemismoothModel(SNES snes, SlipConstraint con, Mat A, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  const PetscReal target = PetscMax(PetscMax(model_share * con->norm, 0.3 * con->target), SLIP_SEARCH_ROUNDING);
  const SlipStageModel model = {A, ss->slip.work[SEMISMOOTH_OFFSET]};

  PetscFunctionBegin;
  PetscCall(MatMult(A, x, model.offset));
  PetscCall(VecAYPX(model.offset, -1.0, con->g));
  *ok = PETSC_TRUE;
  for (PetscInt k = 1; *ok && k <= model_steps && con->norm > target; k++) {
    PetscCall(SlipSemismoothStep(snes, con, &model, k, target, x, ok));
    PetscCall(
      PetscInfo(snes, "Model step %" PetscInt_FMT ": residual %g of %g\n", k, (double)con->norm, (double)target));
    ss->n_model++;
    if (*ok && k % model_project == 0 && con->norm > target && !PetscIsInfOrNanReal(con->merit))
      PetscCall(SlipSemismoothProject(snes, con, &model, x));
  }
  PetscCall(SlipConstraintEvaluate(con, NULL, x));
  SlipSearchForget(&ss->search, con->merit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills v with numbers in (0, 1) from the numbers of cells (Steele et al. 2014, OOPSLA: SplitMix), so that it has a
   part of every mode of sliding and does not depend on the distribution of cells. */
static PetscErrorCode SlipSemismoothSpread(SlipConstraint con, Vec v)
{
  PetscInt n, first;
  const PetscInt c = con->components;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(v, &n));
  PetscCall(VecGetOwnershipRange(v, &first, NULL));
  PetscCall(VecGetArrayWrite(v, &a));
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt cell = (first + i) / c;
    uint64_t z = ((uint64_t)(con->number ? con->number[cell] : cell) * c + i % c + 1) * 0x9e3779b97f4a7c15u;

    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    a[i] = (PetscReal)(z >> 11) / 9007199254740992.0;
  }
  PetscCall(VecRestoreArrayWrite(v, &a));
  PetscCall(VecPointwiseMult(v, v, con->mask));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether dG/dx with this slope is positive definite on the sliding cells; a Krylov method starts from rhs. */
static PetscErrorCode SlipSemismoothCheck(SNES snes, SlipConstraint con, Vec slope, Vec cross, PetscBool *pd)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  Vec *work = ss->slip.work;
  PetscBool done, ok;

  PetscFunctionBegin;
  PetscCall(SlipDirectSolve(con->B, con->C, con->row, con->mask, slope, cross, work[SEMISMOOTH_RHS],
                            work[SEMISMOOTH_DX], ss->direct_max, &done, pd));
  if (done) PetscFunctionReturn(PETSC_SUCCESS);
  if (con->row) PetscCall(SlipSemismoothSpread(con, work[SEMISMOOTH_RHS]));
  PetscCall(SlipSemismoothKrylov(snes, con, con->B, slope, cross, &ok, pd));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets rhs for a Krylov method to the slip rates, in which modes that grow have a part. */
static PetscErrorCode SlipSemismoothMoving(SNES snes, SlipConstraint con, Vec x)
{
  Vec rhs = ((SNES_Semismooth *)snes->data)->slip.work[SEMISMOOTH_RHS];

  PetscFunctionBegin;
  PetscCall(VecPointwiseDivide(rhs, x, con->rho));
  PetscCall(VecPointwiseMult(rhs, rhs, con->mask));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the stage does not go past an instability. The generalised Jacobian of the sliding cells must be positive
   definite at the end of the solve, which an inexact solve has not checked, and also with the slope at the stage's
   start: if it is indefinite only there, an instability began and ended within the stage. If it is positive definite
   with the smaller of both slopes in each cell, it is so with either. */
static PetscErrorCode SlipSemismoothCheckStable(SNES snes, SlipConstraint con, Vec x)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  Vec *work = ss->slip.work, slope = work[SEMISMOOTH_XS], rhs = work[SEMISMOOTH_RHS], least = work[SEMISMOOTH_GS];
  Vec dq = con->cells ? con->cells : slope, cross;
  const PetscBool inexact = con->target > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscReal change = 0;
  PetscBool pd = PETSC_TRUE;

  PetscFunctionBegin;
  if (con->ops->start_slope) {
    PetscCall((*con->ops->start_slope)(con, dq, con->ctx));
    PetscCall(SlipConstraintPress(con, x, dq));
    PetscCall(SlipConstraintSlope(con, x, dq, slope, &cross));
    PetscCall(VecWAXPY(rhs, -1.0, slope, con->slope));
    PetscCall(VecPointwiseMult(rhs, rhs, con->rho));
    PetscCall(SlipVecLargest(rhs, &change));
  }
  if (inexact && change >= small_change && !con->cells && !con->row) {
    PetscCall(VecPointwiseMin(least, slope, con->slope));
    PetscCall(SlipSemismoothMoving(snes, con, x));
    PetscCall(SlipSemismoothCheck(snes, con, least, NULL, &pd));
    if (pd) PetscFunctionReturn(PETSC_SUCCESS);
  }
  pd = PETSC_TRUE;
  if (inexact) {
    PetscCall(SlipSemismoothMoving(snes, con, x));
    PetscCall(SlipSemismoothCheck(snes, con, con->slope, con->cross, &pd));
  }
  if (pd && change >= small_change) {
    PetscCall(VecWAXPY(rhs, -1.0, slope, con->slope));
    PetscCall(VecPointwiseMult(rhs, rhs, con->rho));
    PetscCall(SlipSemismoothCheck(snes, con, slope, cross, &pd));
  }
  if (pd) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscInfo(snes, "Indefinite Jacobian at the start or the end: the step would go past an instability\n"));
  con->unstable = PETSC_TRUE;
  snes->reason = SNES_DIVERGED_LINEAR_SOLVE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSolve_Semismooth(SNES snes)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  SlipConstraint con;
  SNESConvergedReason reason;
  Vec x = snes->vec_sol;
  PetscReal last;
  PetscInt n, slow = 0; /* iterations in a row in which an approximation hardly converged */
  PetscBool ok, loose, exact = PETSC_FALSE;
  Mat A;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  con->unstable = PETSC_FALSE;
  if (con->ops->solve_cells) {
    PetscCall(SlipSmoothBoundSolve(snes, con, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipConstraintBegin(con, x));
  PetscCall(SlipConstraintEvaluate(con, NULL, x));
  SlipSearchForget(&ss->search, con->merit);
  ss->search.stalls = 0;
  /* cells that open and close need an exact solve */
  con->target = ss->rtol_set || !con->ops->affine || con->friction ? 0 : con->share * con->norm;
  PetscCall(VecGetSize(x, &n));
  PetscTryMethod(con->B, "MatSlipSetWanted_C", (Mat, PetscReal),
                 (con->B, wanted_share * con->target * con->scale * PetscSqrtReal((PetscReal)n)));
  PetscCall(SlipConstraintReport(snes, con, 0, &reason));
  for (PetscInt it = 1; reason == SNES_CONVERGED_ITERATING; it++) {
    PetscTryTypeMethod(snes, update, snes->iter);
    last = con->norm;
    if (it > 1) PetscCall(SlipConstraintJacobian(con, x)); /* SlipConstraintBegin() computed the first */
    PetscCall(SlipSemismoothOperator(con, exact, &A));
    loose = (PetscBool)(A != con->B && con->norm > loose_from && !(con->target > 0));
    PetscTryMethod(con->B, "MatSlipSetLoose_C", (Mat, PetscReal), (con->B, loose ? loose_share : 0.0));
    if (A != con->B)
      PetscCall(SlipSemismoothModel(snes, con, A, x, &ok));
    else
      PetscCall(SlipSemismoothStep(snes, con, NULL, it, PetscMax(snes->rtol, con->target), x, &ok));
    if (ok && A == con->B && con->cells && it % vectors_project == 0 && con->norm > SLIP_SEARCH_RTOL &&
        !PetscIsInfOrNanReal(con->merit))
      PetscCall(SlipSemismoothProject(snes, con, NULL, x));
    if (!ok) {
      snes->reason = reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    }
    if (loose && con->norm <= PetscMax(snes->rtol, con->target)) { /* no solve may end with such a product */
      PetscTryMethod(con->B, "MatSlipSetLoose_C", (Mat, PetscReal), (con->B, 0.0));
      PetscCall(SlipConstraintEvaluate(con, NULL, x));
    }
    /* replace an approximation that hardly converges, as near an instability, where dG/dx is almost singular */
    slow = A != con->B && con->norm > 0.5 * last ? slow + 1 : 0;
    if (slow >= patience) {
      PetscCall(PetscInfo(snes, "Approximate Jacobian does not converge: exact one for the rest of this solve\n"));
      exact = PETSC_TRUE;
      slow = 0;
      ss->n_exact++;
    }
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
  }
  PetscTryMethod(con->B, "MatSlipSetLoose_C", (Mat, PetscReal), (con->B, 0.0));
  if (reason == SNES_CONVERGED_FNORM_RELATIVE && !(con->target > 0))
    PetscCall(SlipSemismoothPolish(snes, con, exact, x));
  if (snes->reason > 0 && con->refuse) PetscCall(SlipSemismoothCheckStable(snes, con, x));
  PetscTryMethod(con->B, "MatSlipSetWanted_C", (Mat, PetscReal), (con->B, 0.0));
  PetscCall(SlipConstraintFinish(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESReset_Semismooth(SNES snes)
{
  PetscFunctionBegin;
  PetscCall(MatDestroy(&((SNES_Semismooth *)snes->data)->J));
  PetscCall(SNESReset_Slip(snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSetFromOptions_Semismooth(SNES snes, SlipOptionItems PetscOptionsObject)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Semismooth Newton options");
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)snes), ((PetscObject)snes)->options,
                                   ((PetscObject)snes)->prefix, "-snes_slip_direct_max"));
  PetscCall(PetscOptionsInt("-snes_slip_direct_max",
                            "Sliding cells, >= 0, up to which a dense Cholesky factorisation is used (200)", "",
                            ss->direct_max, &ss->direct_max, NULL));
  PetscOptionsHeadEnd();
  PetscCall(
    PetscOptionsHasName(((PetscObject)snes)->options, ((PetscObject)snes)->prefix, "-snes_rtol", &ss->rtol_set));
  PetscCall(PetscOptionsHasName(((PetscObject)snes->ksp)->options, ((PetscObject)snes->ksp)->prefix, "-ksp_rtol",
                                &ss->ksp_set));
  PetscCheck(ss->direct_max >= 0, PetscObjectComm((PetscObject)snes), PETSC_ERR_ARG_OUTOFRANGE,
             "-snes_slip_direct_max is %" PetscInt_FMT ", expected at least 0", ss->direct_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESView_Semismooth(SNES snes, PetscViewer viewer)
{
  const SNES_Semismooth *ss = (const SNES_Semismooth *)snes->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (ascii)
    PetscCall(PetscViewerASCIIPrintf(
      viewer,
      "  direct up to %" PetscInt_FMT " sliding cells; %" PetscInt_FMT " direct and %" PetscInt_FMT
      " Krylov solves, %" PetscInt_FMT " indefinite Jacobians, %" PetscInt_FMT
      " times unstuck by projection, %" PetscInt_FMT " steps on models, %" PetscInt_FMT
      " times left an approximation\n",
      ss->direct_max, ss->n_direct, ss->n_krylov, ss->n_picard, ss->n_projections, ss->n_model, ss->n_exact));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  SNESSEMISMOOTH - "semismooth": semismooth Newton method on the natural map of the cone |r| <= q

  Options Database Keys:
+ -snes_rtol <1e-10>          - largest natural residual over max(omega q) + max|G(0)|, dimensionless
. -snes_max_it <50>           - iterations after which the solve has failed
- -snes_slip_direct_max <200> - most sliding cells for which a dense Cholesky factorisation is used; 0: none

  Level: intermediate

  Notes:
  Above the limit, or if the entries of the operator are not stored, the KSP (default slipcg with the preconditioner
  "slipstage") solves on the sliding set. Bounds that depend on other rows' x (coupling of SlipConstraintOps), as where
  slip changes normal stress, make the Jacobian unsymmetric: LU replaces Cholesky, and gmres replaces cg. It then counts
  as positive definite if its eigenvalues have positive real parts: LU checks all those of D^-1 J, where D is the
  diagonal of B, if its symmetric part is not positive; a KSP checks those that it finds (KSPComputeEigenvalues()). Each
  iteration chooses the KSP's relative tolerance, unless -ksp_rtol is given.

  Where G is affine (SlipConstraintOps) and the stage allows a share of its first residual (SlipStage), the solve ends
  there, directions are solved to a third of that, and products of an approximated viscosity have an error of a tenth.
  Otherwise it ends at -snes_rtol, and Newton steps then reduce the residual to rounding.

  With two components a cell (SlipConstraintSetComponents()) the step also turns the directions of sliding cells. The
  linear systems stay symmetric, and the limit on direct solves is twice the number of cells.

  Where the operator has an approximation A (MatSlipStageGetApproximation()), each iteration solves the stage with
  G(y) + A (x - y) for G(x), y the last iterate, to a hundredth of its residual, by Newton steps that are not counted as
  iterations, and needs the operator itself once. How many iterations that takes depends on the quality of A alone;
  -info shows the steps, -snes_view counts them.

  A smooth bound that is 0 at x = 0 (solve_cells of SlipConstraintOps) has no cone: Newton's method then eliminates
  each cell by itself, and a stage that goes past an instability always fails (SlipConstraintWasUnstable()).

.seealso: SNESPROJECTION, SNESSetSlipConstraint(), MatCreateSlipJacobian()
M*/
PetscErrorCode SNESCreate_Semismooth(SNES snes)
{
  SNES_Semismooth *ss;
  KSP ksp;
  PC pc;
  PetscErrorCode (*slipstage)(PC);

  PetscFunctionBegin;
  PetscCall(PetscNew(&ss));
  PetscCall(SNESCreate_Slip(snes, &ss->slip, SEMISMOOTH_NWORK, SLIP_SEARCH_MAX_IT));
  ss->direct_max = 200;
  snes->ops->solve = SNESSolve_Semismooth;
  snes->ops->reset = SNESReset_Semismooth;
  snes->ops->setfromoptions = SNESSetFromOptions_Semismooth;
  snes->ops->view = SNESView_Semismooth;
  snes->usesksp = PETSC_TRUE;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPSLIPCG));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscFunctionListFind(PCList, "slipstage", &slipstage));
  PetscCall(PCSetType(pc, slipstage ? "slipstage" : PCJACOBI));
  PetscFunctionReturn(PETSC_SUCCESS);
}
