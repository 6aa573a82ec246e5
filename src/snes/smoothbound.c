/* SNES "semismooth" where the bound is smooth and 0 at rest, as with rate-and-state friction: G(x) + omega Q(x) = 0,
   Q(x) = q(|x|) sign(x). No cell sticks, and no cone is needed; but Q grows like the logarithm of x over thirty
   decades, over which Newton's method in x does not converge.

   Each cell by itself is a scalar equation. With D = diag(B) and the load f = D x - G(x) from the other cells, D y +
   omega Q(y) = f has a root y = S(f), found in ln y. Newton's method on x = S(f(x)), a nonlinear elimination of cells,
   has the Jacobian S' (B + omega Q'(y)), so that its step from y is that of Newton's method in x, (B + omega Q') dx =
   -F(y), followed by the elimination at y + dx. There G is linear: by the step's own equation
     f = D (y + dx) + omega (Q + Q' dx)
   needs no further product. If bounds also depend on the x of other cells, Q' + R C replaces Q': the linear solve
   includes R C, f has the further term omega R C dx, and cells balance the friction of the bounds at y + dx.
   With two components a cell (cone.c) all this holds for vectors, Q' = q' n n' + q / |x| P, and the scalar equation is
   that of their lengths. The elimination moves every cell to the rate, of any decade, at which its friction balances
   the load after the linear step. An iteration takes one product with B, and those of the linear solve. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

enum {
  patience = 4, /* iterations in a row in which an approximate operator may fail to halve the residual */
  /* Iterations after which every step must lower the residual, as directions of two components a cell can cycle */
  strict_after = 10,
  strict_halvings = 15
};

/* Solves (A + slope) dx = -F on the rows that are not prescribed. ok is false where the matrix is not positive
   definite: the stage goes past an instability. */
static PetscErrorCode Direction(SNES snes, SlipConstraint con, Mat A, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  Vec rhs = ss->slip.work[SEMISMOOTH_RHS], dx = ss->slip.work[SEMISMOOTH_DX];
  PetscBool done, pd;

  PetscFunctionBegin;
  PetscCall(VecPointwiseMult(rhs, con->mask, con->F));
  PetscCall(VecScale(rhs, -1.0));
  PetscCall(
    SlipDirectSolve(A, con->C, con->row, con->mask, con->slope, con->cross, rhs, dx, ss->direct_max, &done, &pd));
  if (done) {
    snes->linear_its++;
    ss->n_direct++;
    *ok = pd;
  } else
    PetscCall(SlipSemismoothKrylov(snes, con, A, con->slope, con->cross, ok, &pd));
  if (!pd) {
    PetscCall(PetscInfo(snes, "Indefinite Jacobian: the step would go past an instability\n"));
    con->unstable = PETSC_TRUE;
    *ok = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Balances cells with two components along their loads, by the speed |x| of each: D |x| + omega q(|x|) = |f|. */
static PetscErrorCode SolveVectors(SlipConstraint con, Vec D, Vec f, Vec x, PetscBool *unstable)
{
  Vec diagonal = con->spare, load = con->hold, speed = con->cells;
  const PetscReal *d, *ff, *m;
  PetscReal *xx, *one, *size, *v;
  const SlipArrays before[] = {{D, .read = &d},           {f, .read = &ff},       {x, .write = &xx},
                               {diagonal, .write = &one}, {load, .write = &size}, {speed, .write = &v}};
  const SlipArrays after[] = {
    {con->mask, .read = &m}, {f, .read = &ff}, {load, .write = &size}, {speed, .write = &v}, {x, .write = &xx}};
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(con->cells, &n));
  PetscCall(SlipArraysGet(6, before));
  for (PetscInt i = 0; i < n; i++) {
    one[i] = d[2 * i];
    size[i] = hypot(ff[2 * i], ff[2 * i + 1]);
    v[i] = hypot(xx[2 * i], xx[2 * i + 1]);
  }
  PetscCall(SlipArraysRestore(6, before));
  PetscCall((*con->ops->solve_cells)(con, con->omega, diagonal, load, speed, unstable, con->ctx));
  PetscCall(SlipArraysGet(5, after));
  for (PetscInt i = 0; i < 2 * n; i++)
    if (m[i] != 0) xx[i] = size[i / 2] > 0 ? v[i / 2] * (ff[i] / size[i / 2]) : 0;
  PetscCall(SlipArraysRestore(5, after));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves x to the balance of cells after lambda dx from XS and evaluates it, unless a cell has no stable balance. */
static PetscErrorCode MoveTo(SNES snes, SlipConstraint con, PetscReal lambda, Vec x, PetscBool *unstable)
{
  const Vec *work = ((SNES_Semismooth *)snes->data)->slip.work;

  PetscFunctionBegin;
  *unstable = PETSC_FALSE;
  PetscCall(VecWAXPY(work[SEMISMOOTH_LOAD], lambda, work[SEMISMOOTH_RHS], work[SEMISMOOTH_OFFSET]));
  if (con->C) { /* the bounds at the end of the linear step */
    PetscCall(VecWAXPY(x, lambda, work[SEMISMOOTH_DX], work[SEMISMOOTH_XS]));
    PetscCall((*con->ops->bound)(con, x, con->cx, NULL, con->ctx));
  }
  PetscCall(VecCopy(work[SEMISMOOTH_XS], x));
  if (con->cells)
    PetscCall(SolveVectors(con, work[SEMISMOOTH_RHO], work[SEMISMOOTH_LOAD], x, unstable));
  else
    PetscCall(
      (*con->ops->solve_cells)(con, con->omega, work[SEMISMOOTH_RHO], work[SEMISMOOTH_LOAD], x, unstable, con->ctx));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, unstable, 1, MPIU_BOOL, MPI_LOR, PetscObjectComm((PetscObject)con)));
  if (!*unstable) PetscCall(SlipConstraintEvaluate(con, NULL, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the longest of the steps dx, dx/2, ... that lowers the residual; *ok is false if none does. */
static PetscErrorCode Step(SNES snes, SlipConstraint con, Mat A, PetscInt it, Vec x, PetscBool *ok)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  PetscBool unstable = PETSC_FALSE, found = PETSC_FALSE;
  PetscReal lambda = 1.0;
  PetscInt halvings = SLIP_SEARCH_HALVINGS;
  const Vec *work = ss->slip.work;
  Vec D = work[SEMISMOOTH_RHO], rest = work[SEMISMOOTH_OFFSET], change = work[SEMISMOOTH_RHS];

  PetscFunctionBegin;
  if (con->cells && it > strict_after) {
    halvings = strict_halvings;
    SlipSearchForget(&ss->search, con->merit);
  }
  PetscCall(Direction(snes, con, A, ok));
  if (!*ok) PetscFunctionReturn(PETSC_SUCCESS);
  /* Loads of cells after the step lambda dx: rest + lambda change. With two components a cell, cells balance rest at
     lambda = 0, so that short steps go along dx and lower the residual; with one, rest is a step of Jacobi's method. */
  PetscCall(VecCopy(con->rho, D));
  PetscCall(VecReciprocal(D));
  PetscCall(VecPointwiseMult(rest, D, x));
  PetscCall(VecAXPY(rest, -1.0, con->g));
  PetscCall(VecWAXPY(change, 1.0, D, con->slope));
  PetscCall(VecPointwiseMult(change, change, work[SEMISMOOTH_DX]));
  if (con->cross) PetscCall(SlipAddCross(con->cross, con->mask, work[SEMISMOOTH_DX], change));
  PetscCall(SlipConstraintAddCoupling(con, work[SEMISMOOTH_DX], change));
  PetscCall(VecAXPY(con->cells ? rest : change, 1.0, con->F)); /* rest + change is the same in both cases */
  PetscCall(VecCopy(x, ss->slip.work[SEMISMOOTH_XS]));
  for (PetscInt k = 0; k <= halvings && !found; k++, lambda *= 0.5) {
    PetscCall(MoveTo(snes, con, lambda, x, &unstable));
    if (!unstable) found = SlipSearchAccepts(&ss->search, lambda, con->merit);
  }
  if (found) {
    SlipSearchRemember(&ss->search, it, con->merit);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (unstable) PetscCall(PetscInfo(snes, "Cells without a stable balance: the step would go past an instability\n"));
  con->unstable = unstable;
  *ok = PETSC_FALSE;
  PetscCall(VecCopy(ss->slip.work[SEMISMOOTH_XS], x));
  PetscCall(SlipConstraintEvaluate(con, NULL, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipSmoothBoundSolve(SNES snes, SlipConstraint con, Vec x)
{
  SNES_Semismooth *ss = (SNES_Semismooth *)snes->data;
  SNESConvergedReason reason;
  PetscBool ok, exact = PETSC_FALSE;
  PetscInt slow = 0;
  PetscReal last;
  Mat A;

  PetscFunctionBegin;
  PetscCall(SlipConstraintBegin(con, x));
  PetscCall(SlipConstraintEvaluate(con, NULL, x));
  SlipSearchForget(&ss->search, con->merit);
  PetscCall(SlipConstraintReport(snes, con, 0, &reason));
  for (PetscInt it = 1; reason == SNES_CONVERGED_ITERATING; it++) {
    PetscTryTypeMethod(snes, update, snes->iter);
    last = con->norm;
    if (it > 1) PetscCall(SlipConstraintJacobian(con, x));
    PetscCall(SlipSemismoothOperator(con, exact, &A));
    PetscCall(Step(snes, con, A, it, x, &ok));
    if (!ok && !con->unstable && con->norm <= SLIP_SEARCH_RTOL) { /* only rounding is left */
      snes->reason = SNES_CONVERGED_FNORM_ABS;
      break;
    }
    if (!ok) {
      snes->reason = con->unstable ? SNES_DIVERGED_LINEAR_SOLVE : SNES_DIVERGED_LINE_SEARCH;
      break;
    }
    PetscCall(SlipConstraintReport(snes, con, it, &reason));
    slow = con->norm > 0.5 * last ? slow + 1 : 0;
    if (slow && reason == SNES_CONVERGED_ITERATING && con->norm <= SLIP_SEARCH_RTOL && A == con->B)
      snes->reason = reason = SNES_CONVERGED_FNORM_ABS;
    if (slow >= patience && A != con->B) {
      exact = PETSC_TRUE;
      ss->n_exact++;
    }
  }
  PetscCall(SlipConstraintFinish(con, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
