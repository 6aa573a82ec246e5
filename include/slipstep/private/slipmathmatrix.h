/* Private to src/mat: hierarchical storage of the stiffness of cells. */
#pragma once
#include <slipstep/private/slipmatcells.h>

/* ---- aca.c: low-rank approximation of a block from some of its entries ---- */
/* entries a [m * n], column-major, of the rows i, i + 1, ... and the columns j, j + 1, ... of the block */
typedef void (*SlipEntriesFn)(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[]);
/* U [m * rank] V' [rank * n] (column-major U and V) with an error of about tolerance in the Frobenius norm, relative;
   found is false when the rank would exceed max. U and V are allocated (PetscFree). */
PETSC_INTERN PetscErrorCode SlipCrossApproximate(SlipEntriesFn entries, void *ctx, PetscInt m, PetscInt n,
                                                 PetscReal tolerance, PetscInt max, PetscInt *rank, PetscReal **U,
                                                 PetscReal **V, PetscBool *found);

/* ---- hmatrix.c ---- */
PETSC_INTERN PetscErrorCode SlipStiffnessCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance,
                                                     Mat *S);
PETSC_INTERN PetscErrorCode SlipNormalCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance, Mat *Kn);
PETSC_INTERN PetscErrorCode SlipHMatCosts(const SlipCells *cells, PetscReal cost[]);
