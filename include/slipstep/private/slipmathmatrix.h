/* Private to src/mat: hierarchical storage of the stiffness of cells. */
#pragma once
#include <slipstep/private/slipmatcells.h>

/* ---- aca.c: low-rank approximation of a block from some of its entries ---- */
/* entries a, column-major, of m tuples of rows from tuple i on and n tuples of columns from tuple j on of the block */
typedef void (*SlipEntriesFn)(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[]);
/* U [row_tuples * rows][rank] V' [rank][column_tuples * columns] (column-major U and V) with an error of about
   tolerance in the Frobenius norm, relative; found is false when the rank would exceed max. U and V are allocated
   (PetscFree). */
PETSC_INTERN PetscErrorCode SlipCrossApproximate(SlipEntriesFn entries, void *ctx, PetscInt row_tuples, PetscInt rows,
                                                 PetscInt column_tuples, PetscInt columns, PetscReal tolerance,
                                                 PetscInt max, PetscInt *rank, PetscReal **U, PetscReal **V,
                                                 PetscBool *found);

/* The largest rank at which both factors have no more numbers than the block, r (m + n) <= m n: more than 32 bits hold
   from 46,341 rows and columns on. */
static inline PetscInt SlipRankMost(PetscInt m, PetscInt n)
{
  return (PetscInt)((PetscInt64)m * n / ((PetscInt64)m + n));
}

/* ---- hmatrix.c ---- */
PETSC_INTERN PetscErrorCode SlipStiffnessCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance,
                                                     Mat *S);
PETSC_INTERN PetscErrorCode SlipNormalCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance, Mat *Kn);
PETSC_INTERN PetscErrorCode SlipHMatCosts(const SlipCells *cells, PetscReal cost[]);
