/* Stage solves of a chain of sliders with slip weakening: both SNES types, direct and Krylov, the same on every rank
   count. */
#include "ranks.h"
#include "../sliders.h"
#include <slipstep/private/slipsys.h>

enum { blocks = 20 };

/* A chain: next neighbours and an anchor, plus a far field so that the matrix is dense */
static PetscReal chain(PetscInt i, PetscInt j, PetscInt n)
{
  PetscReal d = (PetscReal)PetscAbsInt(i - j);

  return i == j ? 3.0 : -1.0 / (1.0 + d * d * d);
}

/* Cells near the middle are loaded beyond their strength. strength_i in [0, 1.2]; one row has no bound at all. */
static PetscErrorCode Chain(MPI_Comm comm, Sliders *p, Vec *w)
{
  PetscInt first, last;

  PetscCall(SlidersCreate(comm, blocks, chain, 1.0, 0.1, p));
  p->mud = 0.5;
  p->dmu = 0.5;
  p->dc = 1.0;
  PetscCall(VecGetOwnershipRange(p->bound, &first, &last));
  for (PetscInt i = first; i < last; i++) {
    PetscCall(VecSetValue(p->bound, i, i == 3 ? 0.0 : 1.0 + 0.2 * PetscSinReal(2.0 * i), INSERT_VALUES));
    PetscCall(VecSetValue(p->load, i, 2.5 * PetscExpReal(-0.05 * PetscSqr(i - 9.3)) * (i % 7 == 5 ? -1.0 : 1.0),
                          INSERT_VALUES));
  }
  PetscCall(VecAssemble(p->bound));
  PetscCall(VecAssemble(p->load));
  return SlidersCreateState(p, w);
}

/* One stage from rest */
static PetscErrorCode Solve(Sliders *p, Vec w, const char *type, const char *direct_max, PetscReal theta, Vec x, Vec r,
                            SNESConvergedReason *reason, PetscInt *its)
{
  SNES snes;
  SlipStage stage = {.t = theta, .theta = theta, .omega = 1.0, .base = w};
  PetscReal norm;

  PetscCall(CreateSolver(p->con, type, direct_max, &snes));
  PetscCall(VecZeroEntries(x));
  PetscCall(SNESSlipSolveStage(snes, &stage, x, r, &norm));
  PetscCall(SNESGetConvergedReason(snes, reason));
  PetscCall(SNESGetIterationNumber(snes, its));
  Check(*reason < 0 || norm <= 1e-10, "converged with residual %g", (double)norm);
  return SNESDestroy(&snes);
}

/* |r| <= q, r = -q sign(x) where x != 0, and G(x) = omega r to the solver's tolerance of 1e-10 times the loads (about
   3) */
static PetscErrorCode CheckSolution(Sliders *p, Vec x, Vec r)
{
  Vec q, g;
  const PetscScalar *xx, *rr, *qq, *gg;
  PetscInt n, first;

  PetscCall(DuplicateVecs(x, &q, &g));
  PetscCall(SlidersBound(p->con, x, q, NULL, p));
  PetscCall(LinearResidual(p->con, x, g, p));
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetOwnershipRange(x, &first, NULL));
  xx = VecRead(x);
  rr = VecRead(r);
  qq = VecRead(q);
  gg = VecRead(g);
  for (PetscInt i = 0; i < n; i++) {
    Check(PetscAbsReal(rr[i]) <= qq[i] * (1.0 + 1e-12), "|r| > q in %" PetscInt_FMT, first + i);
    Check(xx[i] == 0.0 || rr[i] == (xx[i] > 0 ? -qq[i] : qq[i]), "r != -q sign(x) in %" PetscInt_FMT, first + i);
    Check(PetscAbsReal(gg[i] - rr[i]) <= 1e-9, "G - r = %g in %" PetscInt_FMT, (double)(gg[i] - rr[i]), first + i);
    Check(first + i != 3 || xx[i] != 0.0, "the unconstrained row sticks");
  }
  return DestroyObjects(&q, &g);
}

static PetscErrorCode Distance(Vec a, Vec b, PetscReal *d)
{
  Vec e;
  PetscReal norm;

  PetscCall(VecDuplicate(a, &e));
  PetscCall(VecWAXPY(e, -1.0, a, b));
  PetscCall(VecNorm(e, NORM_INFINITY, d));
  PetscCall(VecNorm(a, NORM_INFINITY, &norm));
  *d /= norm;
  return VecDestroy(&e);
}

/* The same problem on this rank alone gives the reference for any rank count */
static PetscErrorCode Fingerprint(Vec x, PetscReal *sum)
{
  const PetscScalar *xx;
  PetscInt n, first;
  PetscReal mine = 0.0;

  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetOwnershipRange(x, &first, NULL));
  xx = VecRead(x);
  for (PetscInt i = 0; i < n; i++) mine += xx[i] * (1.0 + PetscSinReal((PetscReal)(first + i)));
  PetscCall(MPIU_Allreduce(&mine, sum, 1, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)x)));
  return PETSC_SUCCESS;
}

/* Direct, Krylov and projection agree to 1e-8: each is within its residual tolerance of 1e-10 times a condition number
   that the anchored chain keeps below 10 */
static PetscErrorCode TestTypesAgree(void)
{
  Sliders p;
  Vec w, x, y, r;
  PetscReal d, sum;
  PetscInt its;
  SNESConvergedReason reason;

  PetscCall(Chain(PETSC_COMM_WORLD, &p, &w));
  PetscCall(DuplicateVecs(p.bound, &x, &y, &r));
  for (PetscReal theta = 0.01; theta < 1.0; theta *= 4.0) {
    PetscCall(Solve(&p, w, SNESSEMISMOOTH, "350", theta, x, r, &reason, &its));
    Check(reason > 0 && its <= 8, "direct: %s after %" PetscInt_FMT, SNESConvergedReasons[reason], its);
    PetscCall(CheckSolution(&p, x, r));
    PetscCall(Fingerprint(x, &sum));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "theta %g: direct %" PetscInt_FMT " iterations, fingerprint %.12e\n",
                          (double)theta, its, (double)sum));
    PetscCall(Solve(&p, w, SNESSEMISMOOTH, "0", theta, y, r, &reason, &its));
    Check(reason > 0 && its <= 8, "Krylov: %s after %" PetscInt_FMT, SNESConvergedReasons[reason], its);
    PetscCall(CheckSolution(&p, y, r));
    PetscCall(Distance(x, y, &d));
    Check(d < 1e-8, "Krylov differs from direct by %g", (double)d);
    PetscCall(Solve(&p, w, SNESPROJECTION, "350", theta, y, r, &reason, &its));
    PetscCall(
      PetscPrintf(PETSC_COMM_WORLD, "  projection: %s after %" PetscInt_FMT "\n", SNESConvergedReasons[reason], its));
    Check(reason > 0, "projection: %s", SNESConvergedReasons[reason]);
    PetscCall(CheckSolution(&p, y, r));
    PetscCall(Distance(x, y, &d));
    Check(d < 1e-8, "projection differs from direct by %g", (double)d);
  }
  PetscCall(DestroyObjects(&w, &x, &y, &r));
  return SlidersDestroy(&p);
}

/* A stiff chain without anchor: the projection gives up at its 200 iterations, semismooth Newton does not notice */
static PetscReal stiff(PetscInt i, PetscInt j, PetscInt n)
{
  return i == j ? (i == 0 || i == n - 1 ? 1.01 : 2.01) : (PetscAbsInt(i - j) == 1 ? -1.0 : 0.0);
}

static PetscErrorCode TestProjectionGivesUp(void)
{
  Sliders p;
  Vec w, x, r;
  PetscInt its;
  SNESConvergedReason reason;

  PetscCall(SlidersCreate(PETSC_COMM_WORLD, blocks, stiff, 1.0, 0.0, &p));
  PetscCall(VecSet(p.load, 1.05));
  PetscCall(SlidersCreateState(&p, &w));
  PetscCall(DuplicateVecs(p.bound, &x, &r));
  PetscCall(Solve(&p, w, SNESPROJECTION, "350", 30.0, x, r, &reason, &its));
  Check(reason == SNES_DIVERGED_MAX_IT && its == 200, "projection: %s after %" PetscInt_FMT,
        SNESConvergedReasons[reason], its);
  for (int k = 0; k < 2; k++) {
    PetscCall(Solve(&p, w, SNESSEMISMOOTH, k ? "0" : "350", 30.0, x, r, &reason, &its));
    Check(reason > 0 && its <= 5, "semismooth: %s after %" PetscInt_FMT, SNESConvergedReasons[reason], its);
  }
  PetscCall(DestroyObjects(&w, &x, &r));
  return SlidersDestroy(&p);
}

/* A whole run of TSBATHE, on all ranks and on this one alone, directly and by Krylov; 1e-9 is what the library
   promises */
static PetscErrorCode TestRanksAgree(void)
{
  const MPI_Comm comm[] = {PETSC_COMM_SELF, PETSC_COMM_WORLD, PETSC_COMM_WORLD};
  Sliders p;
  Vec w;
  PetscReal sum[3];

  for (int k = 0; k < 3; k++) {
    PetscCall(PetscOptionsSetValue(NULL, "-snes_slip_direct_max", k == 2 ? "0" : "350"));
    PetscCall(Chain(comm[k], &p, &w));
    PetscCall(SlidersSolve(&p, TSBATHE_REACTION_TRAPEZOIDAL, 4.0, 40, w, NULL));
    PetscCall(Fingerprint(w, &sum[k]));
    PetscCall(VecDestroy(&w));
    PetscCall(SlidersDestroy(&p));
    Check(PetscAbsReal(sum[k] - sum[0]) < 1e-9 * PetscAbsReal(sum[0]), "the run ends at %.15e instead of %.15e",
          (double)sum[k], (double)sum[0]);
  }
  return PetscPrintf(PETSC_COMM_WORLD, "relative differences %g (ranks), %g (Krylov)\n",
                     (double)PetscAbsReal(sum[1] / sum[0] - 1.0), (double)PetscAbsReal(sum[2] / sum[0] - 1.0));
}

/* What is no number on the last rank is so on all of them. */
static PetscErrorCode TestLargest(void)
{
  PetscReal x[2], norm;
  PetscMPIInt rank, size;
  Vec v;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(VecCreateMPI(PETSC_COMM_WORLD, 2, PETSC_DETERMINE, &v));
  for (int bad = 0; bad < 2; bad++) {
    x[0] = -1 - (PetscReal)rank;
    x[1] = bad && rank == size - 1 ? (PetscReal)NAN : 0.5;
    PetscCall(VecSetValue(v, 2 * rank, x[0], INSERT_VALUES));
    PetscCall(VecSetValue(v, 2 * rank + 1, x[1], INSERT_VALUES));
    PetscCall(VecAssemble(v));
    PetscCall(SlipVecLargest(v, &norm));
    PetscCall(SlipAllreduceLargest(PETSC_COMM_WORLD, 2, x));
    Check(x[0] == -1 && (bad ? PetscIsNanReal(x[1]) : x[1] == 0.5), "the largest numbers are %g and %g", (double)x[0],
          (double)x[1]);
    Check(bad ? PetscIsNanReal(norm) : norm == (PetscReal)size, "the norm is %g", (double)norm);
  }
  return VecDestroy(&v);
}

static PetscErrorCode Run(void)
{
  PetscCall(SlipStepInitializePackage());
  PetscCall(TestLargest());
  PetscCall(TestTypesAgree());
  PetscCall(TestProjectionGivesUp());
  return TestRanksAgree();
}

SLIP_RANKS(Run)
