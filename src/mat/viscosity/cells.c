/*
  Viscosity of stiffnesses without a uniform grid: H = factor D (D^-1 S D^-1)^(1/2) D, D = diag(w)^(1/2), w the weights
  of the rows of S. That is w times the H = factor K^(1/2) of the unweighted K = diag(1/w) S, and symmetric. The root is
  a dense one for a dense S or up to SLIP_ROOT_DENSE_MAX rows; else Lanczos' method applies it in each product.
*/
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

#define SLIP_ROOT_DENSE_MAX 3000

/* D and D^-1 of S's weights; both NULL without any. */
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

/* Rank 0 computes the root, so that it does not depend on the number of ranks. */
static PetscErrorCode ViscosityCreate_DenseRoot(Mat S, PetscReal factor, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)S);
  Vec root, inverse;
  Mat scaled;
  PetscReal *entries = NULL, result[2] = {1, 0};
  PetscMPIInt rank;
  PetscInt N, m, info = 0;
  PetscBool found;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(MatGetSize(S, &N, NULL));
  PetscCall(MatGetLocalSize(S, &m, NULL));
  PetscCall(SlipRootWeights(S, &root, &inverse));
  PetscCall(SlipCacheLoadRoot(S, &entries, &found));
  if (!found) {
    PetscCall(MatConvert(S, MATDENSE, MAT_INITIAL_MATRIX, &scaled));
    if (root) PetscCall(MatDiagonalScale(scaled, inverse, inverse));
    PetscCall(SlipDenseGather(scaled, &entries));
    PetscCall(MatDestroy(&scaled));
  }
  if (rank == 0 && !found) {
    PetscCall(SlipDenseSqrt(N, entries, &result[0], &info));
    result[1] = (PetscReal)info;
  }
  PetscCallMPI(MPI_Bcast(result, 2, MPIU_REAL, 0, comm));
  PetscCheck(result[1] == 0, comm, PETSC_ERR_LIB, "Eigenvalues of the stiffness did not converge (LAPACK info %g)",
             (double)result[1]);
  PetscCheck(result[0] > 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: its smallest eigenvalue is %g Pa/m", (double)result[0]);
  if (!found) PetscCall(SlipCacheSaveRoot(S, entries));
  for (size_t k = 0; !rank && k < (size_t)N * N; k++) entries[k] *= factor;
  PetscCall(SlipDenseScatter(comm, m, N, entries, H));
  PetscCall(PetscFree(entries));
  if (root) PetscCall(MatDiagonalScale(*H, root, root));
  PetscCall(VecDestroy(&root));
  PetscCall(VecDestroy(&inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipViscosityIsOfCells(Mat K, PetscBool *is)
{
  Vec weights;

  PetscFunctionBegin;
  PetscCall(MatSlipGetWeights(K, &weights));
  PetscCall(PetscObjectTypeCompare((PetscObject)K, "sliphmat", is));
  if (weights) *is = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The root takes after the stiffness: dense for a dense one, and for a hierarchical one where that is cheap. */
PetscErrorCode SlipViscosityCreate_Cells(Mat K, PetscReal factor, Mat *H)
{
  PetscBool hmat;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(PetscObjectTypeCompare((PetscObject)K, "sliphmat", &hmat));
  if (hmat && N > SLIP_ROOT_DENSE_MAX)
    PetscCall(SlipViscosityCreate_Lanczos(K, factor, H));
  else
    PetscCall(ViscosityCreate_DenseRoot(K, factor, H));
  PetscCall(MatSetOption(*H, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*H, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
