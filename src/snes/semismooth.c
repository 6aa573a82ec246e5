/* SNES "semismooth": Newton's method on the natural map of the cone.

   A sliding element keeps its row of dG/dx plus the slope of its bound, a
   sticking one is an identity row, so each step is a symmetric linear system on
   the sliding set (the primal-dual active set method when the bound is
   constant: Hintermueller, Ito and Kunisch 2003, SIAM J. Optim. 13).

   A bound that weakens with |x| can make that system indefinite when the step
   is long: the stage then has several solutions, and those at which the
   Jacobian is indefinite are unstable branches that no smaller step reaches.
   There the weakening slope is left out of the step (a Picard step with the
   bound frozen): dG/dx is positive definite, the step goes down the stage's
   energy, and unstable solutions repel it. What it converges to has a positive
   definite Jacobian, so no stage ends on the wrong branch. */
#include <slipstep/private/slipsnes.h>

static const PetscReal rounding = 1e-15; /* relative residual that summation errors leave */
/* Relative tolerance of a linear solve with an approximate operator, which is
 * off by more than that. */
static const PetscReal inexact = 5e-3;
/* Share of the residual to which the model of an approximate operator is
 * solved: it leaves about as much for its own error. */
static const PetscReal model_share = 1e-2;

enum {
  memory = 5, /* merits that a new one is compared with */
  halvings = 4,
  doublings = 40,
  sweeps = 20,       /* projection steps when stuck */
  patience = 4,      /* iterations in a row that an approximate operator may fail to
                   halve the residual */
  model_steps = 200, /* Newton steps on a model */
  model_sweep = 8    /* after so many of them projection steps help the sliding set
                     to settle */
};

typedef struct {
  Mat J;
  Mat A;                      /* what stands for dG/dx in it: con->B, or its approximation; borrowed
          */
  PetscBool exact;            /* approximations have failed in this solve */
  PetscInt slow;              /* iterations in a row with an approximation that hardly
                      converged */
  Vec rhs, dx, xs, zero, rho; /* right side, step, start of the step, no slope,
                                 rho of the projection */
  Vec offset;                 /* of the model's residual */
  PetscInt direct_max;        /* largest sliding set that is solved directly */
  PetscBool picard;           /* the last step left out the slope */
  PetscReal recent[memory];   /* merits */
  PetscInt stalls;            /* steps in a row without enough decrease */
  PetscInt n_direct, n_krylov, n_picard, n_sweeps, n_exact, n_model; /* since creation, for -snes_view */
} SNES_Semismooth;

/* The operator of the linear solves: con->B, or what it composes as
   "MatSlipGetApproximation_C" (Mat, Mat *). With an approximation the method is
   an inexact Newton method: residuals remain those of con->B, and so do its
   solutions. Where the approximate Jacobian is positive definite but the true
   one is not, iterations are repelled, so that the wrong branch is as
   unreachable as with the true one. */
static PetscErrorCode SemismoothOperator(SNES_Semismooth *ss, SlipConstraint con)
{
  PetscErrorCode (*f)(Mat, Mat *);

  PetscFunctionBegin;
  ss->A = con->B;
  if (con->model) ss->A = con->model;
  if (ss->exact || con->model) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectQueryFunction((PetscObject)con->B, "MatSlipGetApproximation_C", &f));
  if (f) PetscCall((*f)(con->B, &ss->A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives up the approximation when it hardly converges, as near instability,
 * where little is left of dG/dx. */
static PetscErrorCode SemismoothJudge(SNES snes, SlipConstraint con, PetscReal last)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;

  PetscFunctionBegin;
  ss->slow = ss->A != con->B && con->norm > 0.5 * last ? ss->slow + 1 : 0;
  if (ss->slow < patience) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscInfo(snes, "Approximate Jacobian does not converge: exact one "
                            "for the rest of this solve\n"));
  ss->exact = PETSC_TRUE;
  ss->slow = 0;
  ss->n_exact++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* rhs_s = -F_s + (B x)_s with x on the sticking set; dx = -x there */
static PetscErrorCode SemismoothRightSide(SNES_Semismooth *ss, SlipConstraint con, Vec x)
{
  PetscReal moved;

  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(ss->xs, con->mask, x));
  PetscCall(VecAYPX(ss->xs, -1.0, x)); /* x on the sticking set */
  PetscCall(VecNorm(ss->xs, NORM_INFINITY, &moved));
  if (moved > 0.0)
    PetscCall(MatMult(ss->A, ss->xs, ss->rhs));
  else
    PetscCall(VecZeroEntries(ss->rhs));
  PetscCall(VecAXPY(ss->rhs, -1.0, con->F));
  PetscCall(VecPointwiseMult(ss->rhs, con->mask, ss->rhs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Krylov solve on the sliding set; pd is false when the matrix shows itself
 * indefinite */
static PetscErrorCode SemismoothKrylov(SNES snes, SlipConstraint con, Vec slope, PetscBool *ok, PetscBool *pd)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  KSPConvergedReason reason;
  PetscInt lits;
  PetscReal eta;
  PetscScalar curvature;

  PetscFunctionBegin;
  if (!ss->J) PetscCall(MatCreateSlipJacobian(con->B, &ss->J));
  PetscCall(MatSlipJacobianSetParts(ss->J, ss->A, con->mask, slope));
  PetscCall(KSPSetOperators(snes->ksp, ss->J, ss->J));
  /* Near quadratic convergence the next residual is of the order of the square
   * of this one: solve so far, or to rounding. */
  eta = ss->A == con->B ? PetscMin(1e-2, PetscMax(0.1 * con->norm, rounding / con->norm)) : inexact;
  PetscCall(KSPSetTolerances(snes->ksp, eta, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPSolve(snes->ksp, ss->rhs, ss->dx));
  PetscCall(KSPGetConvergedReason(snes->ksp, &reason));
  PetscCall(KSPGetIterationNumber(snes->ksp, &lits));
  snes->linear_its += lits;
  ss->n_krylov++;
  /* KSPCG notices a change of sign, not a curvature that is negative from the
   * start */
  PetscCall(VecDot(ss->rhs, ss->dx, &curvature));
  *pd = reason == KSP_DIVERGED_INDEFINITE_MAT || reason == KSP_DIVERGED_INDEFINITE_PC || PetscRealPart(curvature) < 0.0
          ? PETSC_FALSE
          : PETSC_TRUE;
  *ok = reason > 0 || reason == KSP_DIVERGED_ITS ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* dx, by the first way that works: direct, Krylov, and both again without the
 * slope */
static PetscErrorCode SemismoothDirection(SNES snes, SlipConstraint con, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool done, pd;

  PetscFunctionBegin;
  PetscCall((*con->ops->jacobian)(con, x, &con->B, con->ctx));
  PetscCall(SemismoothOperator(ss, con));
  PetscCall(SemismoothRightSide(ss, con, x));
  *ok = PETSC_FALSE;
  for (ss->picard = PETSC_FALSE;; ss->picard = PETSC_TRUE) {
    Vec slope = ss->picard ? ss->zero : con->slope;

    PetscCall(SlipDirectSolve(ss->A, con->mask, slope, ss->rhs, ss->dx, ss->direct_max, &done, &pd));
    if (done) {
      snes->linear_its++;
      ss->n_direct++;
      *ok = pd;
    } else
      PetscCall(SemismoothKrylov(snes, con, slope, ok, &pd));
    if (pd || ss->picard) break;
    PetscCall(PetscInfo(snes, "Indefinite Jacobian: step without the slope of the bound\n"));
    ss->n_picard++;
  }
  PetscCall(VecAXPY(ss->dx, -1.0, ss->xs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Directional derivative of the stage's energy along dx at the point evaluated
 * last: the balance of the sliding elements */
static PetscErrorCode SemismoothPush(SNES_Semismooth *ss, SlipConstraint con, PetscReal *push)
{
  PetscScalar d;

  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(ss->rhs, con->mask, con->F));
  PetscCall(VecDot(ss->rhs, ss->dx, &d));
  *push = PetscRealPart(d);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Picard step: go on doubling it while the loading still pushes the same way,
   else an instability that has hardly begun would take hundreds of steps to
   grow. Of the last two points the better balanced one is kept. */
static PetscErrorCode SemismoothExpand(SNES_Semismooth *ss, SlipConstraint con, Vec x)
{
  PetscReal push, last;

  PetscFunctionBegin;
  PetscCall(VecCopy(x, ss->xs));
  PetscCall(VecAXPY(x, 1.0, ss->dx));
  PetscCall(SlipConstraintEvaluate(con, x));
  PetscCall(SemismoothPush(ss, con, &push));
  for (PetscInt k = 0; k < doublings && push < 0.0; k++) {
    const PetscReal lambda = PetscPowRealInt(2.0, (int)k + 1);

    last = push;
    PetscCall(VecWAXPY(x, lambda, ss->dx, ss->xs));
    PetscCall(SlipConstraintEvaluate(con, x));
    PetscCall(SemismoothPush(ss, con, &push));
    if (push > -last) {
      PetscCall(VecWAXPY(x, 0.5 * lambda, ss->dx, ss->xs));
      PetscCall(SlipConstraintEvaluate(con, x));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stops at zero the elements that the step from xs to x would turn round; sets
   of rows without a bound are left alone. turned: whether there were any. */
static PetscErrorCode SemismoothStop(SlipConstraint con, Vec xs, Vec x, PetscBool *turned)
{
  PetscInt n;
  const PetscScalar *from, *q;
  PetscScalar *to;

  PetscFunctionBegin;
  *turned = PETSC_FALSE;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(xs, &from));
  PetscCall(VecGetArrayRead(con->q, &q));
  PetscCall(VecGetArray(x, &to));
  for (PetscInt i = 0; i < n; i++) {
    if (!(PetscRealPart(from[i]) * PetscRealPart(to[i]) < 0.0 && PetscRealPart(q[i]) > 0.0)) continue;
    to[i] = 0.0;
    *turned = PETSC_TRUE;
  }
  PetscCall(VecRestoreArray(x, &to));
  PetscCall(VecRestoreArrayRead(con->q, &q));
  PetscCall(VecRestoreArrayRead(xs, &from));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, turned, 1, MPIU_BOOL, MPI_LOR, PetscObjectComm((PetscObject)con)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The full step, or, if that hardly lowers the merit, the better of it and of
   the one that turns no element round: sliding that comes to rest seldom goes
   the other way at once, and sets of elements that turn round together in one
   step and back in the next shrink by a few elements in each. */
static PetscErrorCode SemismoothFullStep(SNES_Semismooth *ss, SlipConstraint con, Vec x)
{
  const PetscReal last = con->merit;
  PetscReal full;
  PetscBool turned;

  PetscFunctionBegin;
  PetscCall(VecWAXPY(x, 1.0, ss->dx, ss->xs));
  PetscCall(SlipConstraintEvaluate(con, x));
  full = con->merit;
  if (full <= 0.1 * last) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SemismoothStop(con, ss->xs, x, &turned));
  if (!turned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipConstraintEvaluate(con, x));
  if (con->merit < full) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecWAXPY(x, 1.0, ss->dx, ss->xs));
  PetscCall(SlipConstraintEvaluate(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Full step if it is no worse than the worst of the recent ones, else halve;
 * *stalled when nothing helped */
static PetscErrorCode SemismoothSearch(SNES_Semismooth *ss, SlipConstraint con, Vec x, PetscBool *stalled)
{
  PetscReal limit = 0.0, lambda = 1.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < memory; i++) limit = PetscMax(limit, ss->recent[i]);
  PetscCall(VecCopy(x, ss->xs));
  *stalled = PETSC_TRUE;
  for (PetscInt k = 0; k <= halvings && *stalled; k++, lambda *= 0.5) {
    if (k == 0)
      PetscCall(SemismoothFullStep(ss, con, x));
    else {
      PetscCall(VecWAXPY(x, lambda, ss->dx, ss->xs));
      PetscCall(SlipConstraintEvaluate(con, x));
    }
    if (con->merit < (1.0 - 1e-4 * lambda) * limit) *stalled = PETSC_FALSE;
  }
  if (*stalled) {
    PetscCall(VecWAXPY(x, 1.0, ss->dx, ss->xs));
    PetscCall(SlipConstraintEvaluate(con, x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A few steps of the fixed point, which cannot cycle for small slopes */
static PetscErrorCode SemismoothSweep(SNES_Semismooth *ss, SlipConstraint con, Vec x)
{
  PetscFunctionBegin;
  PetscCall(VecCopy(con->rho, ss->rho));
  for (PetscInt k = 0; k < sweeps; k++) PetscCall(SlipProjectionStep(con, x, ss->rho, ss->dx, ss->rhs));
  ss->stalls = 0;
  ss->n_sweeps++;
  for (PetscInt i = 0; i < memory; i++) ss->recent[i] = con->merit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Against cycling active sets: projection steps after repeated stalls */
static PetscErrorCode SemismoothUnstick(SNES snes, SlipConstraint con, Vec x, PetscBool stalled)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;

  PetscFunctionBegin;
  ss->stalls = stalled ? ss->stalls + 1 : 0;
  if (ss->stalls < 3 || PetscIsInfOrNanReal(con->merit)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscInfo(snes, "Three steps without decrease: %d projection steps\n", (int)sweeps));
  PetscCall(SemismoothSweep(ss, con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* From the tolerance down to rounding with plain Newton steps, usually one. The
   residual is relative to the strength, and slow slip rates are many orders
   below those that it balances: only there are they exact enough for runs on
   different numbers of ranks to agree. Stops when the residual no longer
   halves, and keeps the better point. */
static PetscErrorCode SemismoothPolish(SNES snes, SlipConstraint con, Vec x)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  SNESConvergedReason reason;
  PetscReal last, step, size;
  PetscBool ok;

  PetscFunctionBegin;
  for (PetscInt it = snes->iter + 1; con->norm > rounding && it <= snes->max_its; it++) {
    last = con->norm;
    PetscCall(SemismoothDirection(snes, con, x, &ok));
    if (!ok || ss->picard) break;
    PetscCall(VecCopy(x, ss->xs));
    PetscCall(VecAXPY(x, 1.0, ss->dx));
    PetscCall(SlipConstraintEvaluate(con, x));
    if (!(con->norm < last)) {
      PetscCall(VecCopy(ss->xs, x));
      PetscCall(SlipConstraintEvaluate(con, x));
      break;
    }
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
    PetscCall(VecNorm(ss->dx, NORM_INFINITY, &step));
    PetscCall(VecNorm(x, NORM_INFINITY, &size));
    if (ss->A != con->B) step *= con->norm / last; /* the error that is left, where convergence is linear */
    if (con->norm > 0.5 * last || step <= 1e-11 * size) break;
  }
  snes->reason = SNES_CONVERGED_FNORM_RELATIVE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step from the point evaluated last; ok is false when no direction was found
 */
static PetscErrorCode SemismoothStep(SNES snes, SlipConstraint con, PetscInt it, PetscReal tolerance, Vec x,
                                     PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool stalled = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SemismoothDirection(snes, con, x, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ss->picard) { /* leaves the neighbourhood where the merit means something
                     */
    PetscCall(SemismoothExpand(ss, con, x));
    for (PetscInt i = 0; i < memory; i++) ss->recent[i] = con->merit;
  } else
    PetscCall(SemismoothSearch(ss, con, x, &stalled));
  ss->recent[it % memory] = con->merit;
  if (con->norm > tolerance) PetscCall(SemismoothUnstick(snes, con, x, stalled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step of an approximate operator A: to the solution of the stage with G(y)
   + A (x - y) for G(x), y the point evaluated last. Each needs G once, and A as
   often as the sliding set takes to settle. What it leaves of the error, |A^-1
   (B - A)|, does not depend on that set, where single Newton steps with A would
   have to wait for it (Josephy 1979, MRC Technical Report 1965: Newton's method
   for generalised equations). */
static PetscErrorCode SemismoothModel(SNES snes, SlipConstraint con, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscReal target;

  PetscFunctionBegin;
  target = PetscMax(model_share * con->norm, rounding);
  if (!ss->offset) PetscCall(VecDuplicate(x, &ss->offset));
  PetscCall(MatMult(ss->A, x, ss->offset));
  PetscCall(VecAYPX(ss->offset, -1.0, con->g));
  con->model = ss->A;
  con->offset = ss->offset;
  *ok = PETSC_TRUE;
  for (PetscInt k = 1; *ok && k <= model_steps && con->norm > target; k++) {
    PetscCall(SemismoothStep(snes, con, k, target, x, ok));
    PetscCall(
      PetscInfo(snes, "Model step %" PetscInt_FMT ": residual %g of %g\n", k, (double)con->norm, (double)target));
    ss->n_model++;
    if (*ok && k % model_sweep == 0 && con->norm > target && !PetscIsInfOrNanReal(con->merit))
      PetscCall(SemismoothSweep(ss, con, x));
  }
  con->model = NULL;
  PetscCall(SlipConstraintEvaluate(con, x));
  for (PetscInt i = 0; i < memory; i++) ss->recent[i] = con->merit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSolve_Semismooth(SNES snes)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  SlipConstraint con;
  SNESConvergedReason reason;
  Vec x = snes->vec_sol;
  PetscReal last;
  PetscBool ok;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  ss->exact = PETSC_FALSE;
  ss->slow = 0;
  PetscCall(SlipConstraintBegin(con, x));
  PetscCall(SlipConstraintEvaluate(con, x));
  for (PetscInt i = 0; i < memory; i++) ss->recent[i] = con->merit;
  ss->stalls = 0;
  PetscCall(SlipConstraintReport(snes, con, 0, &reason));
  for (PetscInt it = 1; reason == SNES_CONVERGED_ITERATING; it++) {
    PetscTryTypeMethod(snes, update, snes->iter);
    last = con->norm;
    PetscCall((*con->ops->jacobian)(con, x, &con->B, con->ctx));
    PetscCall(SemismoothOperator(ss, con));
    if (ss->A != con->B)
      PetscCall(SemismoothModel(snes, con, x, &ok));
    else
      PetscCall(SemismoothStep(snes, con, it, snes->rtol, x, &ok));
    if (!ok) {
      snes->reason = reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    }
    PetscCall(SemismoothJudge(snes, con, last));
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
  }
  if (reason == SNES_CONVERGED_FNORM_RELATIVE) PetscCall(SemismoothPolish(snes, con, x));
  PetscCall(SlipConstraintFinish(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSetUp_Semismooth(SNES snes)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  SlipConstraint con;

  PetscFunctionBegin;
  PetscCall(SlipConstraintQuery(snes, &con));
  PetscCall(VecDuplicate(con->x, &ss->rhs));
  PetscCall(VecDuplicate(con->x, &ss->dx));
  PetscCall(VecDuplicate(con->x, &ss->xs));
  PetscCall(VecDuplicate(con->x, &ss->rho));
  PetscCall(VecDuplicate(con->x, &ss->zero));
  PetscCall(VecZeroEntries(ss->zero));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESReset_Semismooth(SNES snes)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;

  PetscFunctionBegin;
  PetscCall(MatDestroy(&ss->J));
  PetscCall(VecDestroy(&ss->rhs));
  PetscCall(VecDestroy(&ss->dx));
  PetscCall(VecDestroy(&ss->xs));
  PetscCall(VecDestroy(&ss->rho));
  PetscCall(VecDestroy(&ss->zero));
  PetscCall(VecDestroy(&ss->offset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESDestroy_Semismooth(SNES snes)
{
  PetscFunctionBegin;
  PetscCall(SNESReset_Semismooth(snes));
  PetscCall(PetscFree(snes->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESSetFromOptions_Semismooth(SNES snes, SlipOptionItems PetscOptionsObject)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Semismooth Newton options");
  PetscCall(PetscOptionsInt("-snes_slip_direct_max",
                            "Sliding elements, >= 0, up to which a dense "
                            "Cholesky factorisation is used (350)",
                            "", ss->direct_max, &ss->direct_max, NULL));
  PetscCheck(ss->direct_max >= 0, PetscObjectComm((PetscObject)snes), PETSC_ERR_ARG_OUTOFRANGE,
             "-snes_slip_direct_max is %" PetscInt_FMT ", expected at least 0", ss->direct_max);
  PetscOptionsHeadEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESView_Semismooth(SNES snes, PetscViewer viewer)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (ascii)
    PetscCall(PetscViewerASCIIPrintf(
      viewer,
      "  direct up to %" PetscInt_FMT " sliding elements; %" PetscInt_FMT " direct and %" PetscInt_FMT
      " Krylov solves, %" PetscInt_FMT " indefinite Jacobians, %" PetscInt_FMT
      " times unstuck by projection, %" PetscInt_FMT " steps on models, %" PetscInt_FMT
      " times left an approximation\n",
      ss->direct_max, ss->n_direct, ss->n_krylov, ss->n_picard, ss->n_sweeps, ss->n_model, ss->n_exact));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  SNESSEMISMOOTH - "semismooth": semismooth Newton method on the natural map of
the cone |r| <= q

  Options Database Keys:
+ -snes_rtol <1e-10>          - largest natural residual over max(omega q) +
max|G(0)|, dimensionless . -snes_max_it <50>           - iterations before the
solve has failed
- -snes_slip_direct_max <350> - sliding elements up to which a dense Cholesky
factorisation is used, 0 for never

  Level: intermediate

  Notes:
  Above the limit, or when the entries of the operator are not at hand, the KSP
(default cg with the preconditioner "slipstage") solves on the sliding set. The
KSP's relative tolerance is chosen in each iteration. Where the operator has an
approximation A (MatSlipStageGetApproximation()), each iteration solves the
stage with G(y) + A (x - y) for G(x), y the last iterate, to a hundredth of its
residual, by Newton steps that are not counted as iterations, and needs the
operator itself once. How many iterations that takes depends on the quality of A
alone; -info shows the steps, -snes_view counts them.

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
  snes->data = ss;
  ss->direct_max = 350;
  snes->ops->solve = SNESSolve_Semismooth;
  snes->ops->setup = SNESSetUp_Semismooth;
  snes->ops->reset = SNESReset_Semismooth;
  snes->ops->destroy = SNESDestroy_Semismooth;
  snes->ops->setfromoptions = SNESSetFromOptions_Semismooth;
  snes->ops->view = SNESView_Semismooth;
  snes->usesksp = PETSC_TRUE;
  snes->usesnpc = PETSC_FALSE;
  snes->alwayscomputesfinalresidual = PETSC_TRUE;
  SlipSNESDefaults(snes, 1e-10, 50);
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscFunctionListFind(PCList, "slipstage", &slipstage));
  PetscCall(PCSetType(pc, slipstage ? "slipstage" : PCJACOBI));
  PetscFunctionReturn(PETSC_SUCCESS);
}
