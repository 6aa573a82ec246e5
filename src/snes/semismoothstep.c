/* Steps of SNES "semismooth" (semismooth.c): direction, search, and what helps active sets that cycle. */
#include <slipstep/private/slipsnes.h>

/* Relative tolerance of a linear solve with an approximate operator, which is off by more than that. */
static const PetscReal inexact = 5e-3;

enum {
  halvings = 4,
  doublings = 40,
  projections = 20 /* projection steps when stuck */
};

void SlipSemismoothForget(SNES_Semismooth *ss, SlipConstraint con)
{
  for (PetscInt i = 0; i < SLIP_SEMISMOOTH_MEMORY; i++) ss->recent[i] = con->merit;
}

/* The operator of the linear solves: con->B, or what it composes as "MatSlipGetApproximation_C" (Mat, Mat *). With
   an approximation the method is an inexact Newton method: residuals remain those of con->B, and so do its
   solutions. Where the approximate Jacobian is positive definite but the true one is not, iterations are repelled,
   so that the wrong branch is as unreachable as with the true one. */
PetscErrorCode SlipSemismoothOperator(SNES_Semismooth *ss, SlipConstraint con)
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

/* Krylov solve on the sliding set; pd is false when the matrix shows itself indefinite */
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
  /* Near quadratic convergence the next residual is of the order of the square of this one: solve so far, or to
     rounding. */
  eta = ss->A == con->B ? PetscMin(1e-2, PetscMax(0.1 * con->norm, SLIP_SEMISMOOTH_ROUNDING / con->norm)) : inexact;
  PetscCall(KSPSetTolerances(snes->ksp, eta, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPSolve(snes->ksp, ss->rhs, ss->dx));
  PetscCall(KSPGetConvergedReason(snes->ksp, &reason));
  PetscCall(KSPGetIterationNumber(snes->ksp, &lits));
  snes->linear_its += lits;
  ss->n_krylov++;
  /* KSPCG notices a change of sign, not a curvature that is negative from the start */
  PetscCall(VecDot(ss->rhs, ss->dx, &curvature));
  *pd = reason == KSP_DIVERGED_INDEFINITE_MAT || reason == KSP_DIVERGED_INDEFINITE_PC || PetscRealPart(curvature) < 0.0
          ? PETSC_FALSE
          : PETSC_TRUE;
  *ok = reason > 0 || reason == KSP_DIVERGED_ITS ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* dx, by the first way that works: direct, Krylov, and both again without the slope */
PetscErrorCode SlipSemismoothDirection(SNES snes, SlipConstraint con, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool done, pd;

  PetscFunctionBegin;
  PetscCall((*con->ops->jacobian)(con, x, &con->B, con->ctx));
  PetscCall(SlipSemismoothOperator(ss, con));
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

/* Directional derivative of the stage's energy along dx at the point evaluated last: the balance of the sliding
   cells */
static PetscErrorCode SemismoothPush(SNES_Semismooth *ss, SlipConstraint con, PetscReal *push)
{
  PetscScalar d;

  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(ss->rhs, con->mask, con->F));
  PetscCall(VecDot(ss->rhs, ss->dx, &d));
  *push = PetscRealPart(d);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Picard step: go on doubling it while the loading still pushes the same way, else an instability that has hardly
   begun would take hundreds of steps to grow. Of the last two points the better balanced one is kept. */
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

/* Stops at zero the cells that the step from xs to x would turn round; sets of rows without a bound are left
   alone. turned: whether there were any. */
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

/* The full step, or, if that hardly lowers the merit, the better of it and of the one that turns no cell round:
   sliding that comes to rest seldom goes the other way at once, and sets of cells that turn round together in one
   step and back in the next shrink by a few cells in each. */
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

/* Full step if it is no worse than the worst of the recent ones, else halve; *stalled when nothing helped */
static PetscErrorCode SemismoothSearch(SNES_Semismooth *ss, SlipConstraint con, Vec x, PetscBool *stalled)
{
  PetscReal limit = 0.0, lambda = 1.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < SLIP_SEMISMOOTH_MEMORY; i++) limit = PetscMax(limit, ss->recent[i]);
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
PetscErrorCode SlipSemismoothProject(SNES_Semismooth *ss, SlipConstraint con, Vec x)
{
  PetscFunctionBegin;
  PetscCall(VecCopy(con->rho, ss->rho));
  for (PetscInt k = 0; k < projections; k++) PetscCall(SlipProjectionStep(con, x, ss->rho, ss->dx, ss->rhs));
  ss->stalls = 0;
  ss->n_projections++;
  SlipSemismoothForget(ss, con);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Against cycling active sets: projection steps after repeated stalls */
static PetscErrorCode SemismoothUnstick(SNES snes, SlipConstraint con, Vec x, PetscBool stalled)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;

  PetscFunctionBegin;
  ss->stalls = stalled ? ss->stalls + 1 : 0;
  if (ss->stalls < 3 || PetscIsInfOrNanReal(con->merit)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscInfo(snes, "Three steps without decrease: %d projection steps\n", (int)projections));
  PetscCall(SlipSemismoothProject(ss, con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step from the point evaluated last; ok is false when no direction was found */
PetscErrorCode SlipSemismoothStep(SNES snes, SlipConstraint con, PetscInt it, PetscReal tolerance, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool stalled = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipSemismoothDirection(snes, con, x, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  if (ss->picard) { /* leaves the neighbourhood where the merit means something
 */
    PetscCall(SemismoothExpand(ss, con, x));
    SlipSemismoothForget(ss, con);
  } else
    PetscCall(SemismoothSearch(ss, con, x, &stalled));
  ss->recent[it % SLIP_SEMISMOOTH_MEMORY] = con->merit;
  if (con->norm > tolerance) PetscCall(SemismoothUnstick(snes, con, x, stalled));
  PetscFunctionReturn(PETSC_SUCCESS);
}
