/*
  The part of sqrt(K) that the spectral approximation misses. It lives near the fault's two ends and has low numerical rank, so it
  is kept as W diag(lambda) W' for each parity under the mirror x -> -x. Found by randomised subspace iteration (Halko,
  Martinsson & Tropp 2011), deterministic in its seed.
*/
#include <slipmat.h>
#include <petscblaslapack.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

/* A small linear congruential generator (Knuth's MMIX constants), uniform in (-1, 1). */
static PetscReal NextRandom(uint64_t *state)
{
  *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
  return (PetscReal)(*state >> 11) / 4503599627370496.0 - 1.0;
}

/* Orthonormal basis of the columns of Y (n x r, column-major), in place. */
static PetscErrorCode Orthonormalise(PetscBLASInt n, PetscBLASInt r, PetscReal Y[])
{
  PetscBLASInt info, lwork = 64 * r;
  PetscReal *tau, *work;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(r, &tau, lwork, &work));
  PetscCallBLAS("LAPACKgeqrf", LAPACKgeqrf_(&n, &r, Y, &n, tau, work, &lwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK geqrf failed (info %d)", (int)info);
  PetscCallBLAS("LAPACKorgqr", LAPACKorgqr_(&n, &r, &r, Y, &n, tau, work, &lwork, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK orgqr failed (info %d)", (int)info);
  PetscCall(PetscFree2(tau, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Eigenpairs of the symmetric D (n x n) in a subspace of dimension r: Q (n x r) and lambda[r]. */
static PetscErrorCode SubspaceEigen(PetscInt n, const PetscReal D[], PetscInt r, PetscReal Q[], PetscReal lambda[])
{
  const PetscScalar one = 1, zero = 0;
  PetscBLASInt bn, br;
  PetscReal *Y, *T;
  PetscInt info;
  uint64_t seed = 20260101;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(n, &bn));
  PetscCall(PetscBLASIntCast(r, &br));
  PetscCall(PetscMalloc2((size_t)n * r, &Y, (size_t)r * r, &T));
  for (size_t i = 0; i < (size_t)n * r; i++) Q[i] = NextRandom(&seed);
  for (int sweep = 0; sweep < 2; sweep++) {
    PetscCallBLAS("BLASgemm", BLASgemm_("N", "N", &bn, &br, &bn, &one, D, &bn, Q, &bn, &zero, Y, &bn));
    PetscCall(PetscArraycpy(Q, Y, (size_t)n * r));
    PetscCall(Orthonormalise(bn, br, Q));
  }
  PetscCallBLAS("BLASgemm", BLASgemm_("N", "N", &bn, &br, &bn, &one, D, &bn, Q, &bn, &zero, Y, &bn));
  PetscCallBLAS("BLASgemm", BLASgemm_("T", "N", &br, &br, &bn, &one, Q, &bn, Y, &bn, &zero, T, &br));
  PetscCall(SlipDenseEigen(r, T, lambda, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "Eigenvalues did not converge (LAPACK info %" PetscInt_FMT ")",
             info);
  PetscCallBLAS("BLASgemm", BLASgemm_("N", "N", &bn, &br, &br, &one, Q, &bn, T, &br, &zero, Y, &bn));
  PetscCall(PetscArraycpy(Q, Y, (size_t)n * r));
  PetscCall(PetscFree2(Y, T));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The eigenpairs of D with |lambda| > cutoff: *rank columns of *W (n x rank, PetscFree) and *lambda (PetscFree). The subspace
   grows until it holds 16 pairs too many. */
PetscErrorCode SlipLowRank(PetscInt n, const PetscReal D[], PetscReal cutoff, PetscInt guess, PetscInt *rank,
                           PetscReal **W, PetscReal **lambda)
{
  PetscReal *Q, *values;
  PetscInt r = PetscMin(n, PetscMax(guess, 32)), kept;

  PetscFunctionBegin;
  for (;; r = PetscMin(n, 2 * r)) {
    PetscCall(PetscMalloc1((size_t)n * r, &Q));
    PetscCall(PetscMalloc1(r, &values));
    PetscCall(SubspaceEigen(n, D, r, Q, values));
    kept = 0;
    for (PetscInt k = 0; k < r; k++) kept += PetscAbsReal(values[k]) > cutoff;
    if (r == n || kept + 16 <= r) break;
    PetscCall(PetscFree(Q));
    PetscCall(PetscFree(values));
  }
  kept = 0;
  for (PetscInt k = 0; k < r; k++) {
    if (PetscAbsReal(values[k]) <= cutoff) continue;
    if (kept != k) PetscCall(PetscArraycpy(Q + (size_t)kept * n, Q + (size_t)k * n, n));
    values[kept++] = values[k];
  }
  *rank = kept;
  *W = Q;
  *lambda = values;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += W lambda W' x; t is scratch of rank entries. */
PetscErrorCode SlipLowRankApply(PetscInt n, PetscInt rank, const PetscReal W[], const PetscReal lambda[],
                                const PetscReal x[], PetscReal y[], PetscReal t[])
{
  const PetscScalar one = 1, zero = 0;
  const PetscBLASInt bn = (PetscBLASInt)n, br = (PetscBLASInt)rank, inc = 1;

  PetscFunctionBegin;
  if (n == 0 || rank == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallBLAS("BLASgemv", BLASgemv_("T", &bn, &br, &one, W, &bn, x, &inc, &zero, t, &inc));
  for (PetscInt k = 0; k < rank; k++) t[k] *= lambda[k];
  PetscCallBLAS("BLASgemv", BLASgemv_("N", &bn, &br, &one, W, &bn, t, &inc, &one, y, &inc));
  PetscFunctionReturn(PETSC_SUCCESS);
}
