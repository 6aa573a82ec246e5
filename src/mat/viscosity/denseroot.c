/*
  Viscosity by a dense root: H = factor D (D^-1 S D^-1)^(1/2) D with D = diag(w)^(1/2), where w are the weights of the
  rows of S. It is w times H = factor K^(1/2) of the unweighted K = diag(1/w) S, and symmetric.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

/* Creates D and D^-1 from S's weights; both are NULL without weights. */
PetscErrorCode SlipRootWeights(Mat S, Vec *root, Vec *inverse)
{
  Vec weights;

  PetscFunctionBegin;
  *root = *inverse = NULL;
  PetscCall(MatSlipGetWeights(S, &weights));
  if (!weights) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(weights, root));
  PetscCall(VecCopy(weights, *root));
  PetscCall(VecSqrtAbs(*root));
  PetscCall(VecDuplicate(weights, inverse));
  PetscCall(VecCopy(*root, *inverse));
  PetscCall(VecReciprocal(*inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes sqrt(scale * K) of a uniform grid on one process, by its mirror blocks. */
static PetscErrorCode SqrtOfGrid(const SlipGrid *g, PetscReal scale, PetscReal root[], PetscReal *smallest,
                                 PetscInt *info)
{
  const PetscInt nx = g->nx, nz = g->nz;
  PetscReal *kernel, *block[2], lowest;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)nx * nz * nz, &kernel));
  for (PetscInt d = 0; d < nx; d++) SlipGridKernel(g, d, kernel + (size_t)d * nz * nz);
  *info = 0;
  *smallest = PETSC_MAX_REAL;
  for (PetscInt parity = 0; parity < 2; parity++) {
    const PetscInt n = SlipMirrorWidth(nx, parity) * nz;

    PetscCall(PetscMalloc1((size_t)n * n, &block[parity]));
    SlipMirrorSplit(nx, nz, kernel, scale, parity, block[parity]);
    if (n && !*info && *smallest > 0) {
      PetscCall(SlipDenseSqrt(n, block[parity], &lowest, info));
      *smallest = PetscMin(*smallest, lowest);
    }
  }
  PetscCall(PetscFree(kernel));
  SlipMirrorMerge(nx, nz, block[0], block[1], root);
  PetscCall(PetscFree(block[0]));
  PetscCall(PetscFree(block[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the viscosity. Rank 0 computes the root, so that it does not depend on the number of ranks. */
PetscErrorCode SlipViscosityCreate_DenseRoot(Mat S, PetscReal factor, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)S);
  Vec root, inverse;
  Mat scaled;
  const SlipGrid *grid;
  PetscReal *entries = NULL, scale, result[2] = {1, 0};
  PetscMPIInt rank;
  PetscInt N, m, info = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(MatGetSize(S, &N, NULL));
  PetscCall(MatGetLocalSize(S, &m, NULL));
  PetscCall(SlipRootWeights(S, &root, &inverse));
  PetscCall(SlipGridOf(S, &grid));
  if (grid) {
    PetscCall(SlipGridScale(S, &scale));
    if (!rank) PetscCall(PetscMalloc1((size_t)N * N, &entries));
    if (!rank) PetscCall(SqrtOfGrid(grid, scale, entries, &result[0], &info));
  } else {
    PetscCall(MatConvert(S, MATDENSE, MAT_INITIAL_MATRIX, &scaled));
    if (root) PetscCall(MatDiagonalScale(scaled, inverse, inverse));
    PetscCall(SlipDenseGather(scaled, &entries));
    PetscCall(MatDestroy(&scaled));
    if (!rank) PetscCall(SlipDenseSqrt(N, entries, &result[0], &info));
  }
  result[1] = (PetscReal)info;
  PetscCallMPI(MPI_Bcast(result, 2, MPIU_REAL, 0, comm));
  if (result[1] != 0 || result[0] <= 0) PetscCall(PetscFree(entries));
  PetscCheck(result[1] == 0, comm, PETSC_ERR_LIB, "Eigenvalues of the stiffness did not converge (LAPACK info %g)",
             (double)result[1]);
  PetscCheck(result[0] > 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: its smallest eigenvalue is %g Pa/m", (double)result[0]);
  for (size_t k = 0; !rank && k < (size_t)N * N; k++) entries[k] *= factor;
  PetscCall(SlipDenseScatter(comm, m, N, entries, H));
  PetscCall(PetscFree(entries));
  if (root) PetscCall(MatDiagonalScale(*H, root, root));
  PetscCall(MatSetOption(*H, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*H, MAT_SPD, PETSC_TRUE));
  PetscCall(VecDestroy(&root));
  PetscCall(VecDestroy(&inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}
