/* Private to src/mat: entries of an irregular mesh's stiffness, its hierarchical storage, and Lanczos' square root. */
#pragma once
#include <slipcells.h>

/* ---- cells.c ---- */
/* S_ij of MatCreateSlipCellStiffness(); unit is 1 / (2 mean(A)). */
PETSC_INTERN PetscReal SlipCellsEntry(const SlipCells *cells, PetscReal unit, PetscInt i, PetscInt j);
PETSC_INTERN PetscReal SlipCellsUnit(const SlipCells *cells);
PETSC_INTERN PetscErrorCode SlipCellsCosts(const SlipCells *cells, const char type[], PetscReal cost[]);
PETSC_INTERN PetscErrorCode SlipCellsDestroy(SlipCells *cells); /* whose x owns the memory of all columns */

/* The cells that a stiffness was made from, borrowed from it; NULL for other matrices. */
PETSC_INTERN PetscErrorCode SlipCellsOf(Mat S, const SlipCells **cells);
/* The cell of a row of the stiffness. */
static inline PetscInt SlipCellsAt(const SlipCells *cells, PetscInt row)
{
  return cells->order ? cells->order[row] : row;
}

/* A cell for sorting: by one coordinate [m], ties by number. */
typedef struct {
  PetscReal key;
  PetscInt cell;
} SlipCellKey;
PETSC_INTERN int SlipCellKeyCompare(const void *a, const void *b); /* for qsort() */

/* ---- hcluster.c: a binary tree of cells that are close to each other ---- */
typedef struct {
  PetscInt start, end;      /* its cells are perm[start, end) */
  PetscInt child[2];        /* indices of nodes; -1 in a leaf */
  PetscReal low[3], top[3]; /* box that holds its cells [m] */
} SlipCluster;

typedef struct {
  PetscInt *perm; /* [n] cells in the tree's order */
  PetscInt nnodes;
  SlipCluster *node; /* node[0] is the root */
} SlipClusterTree;
PETSC_INTERN PetscErrorCode SlipClusterTreeCreate(const SlipCells *cells, PetscInt leaf, SlipClusterTree *tree);
PETSC_INTERN PetscErrorCode SlipClusterTreeDestroy(SlipClusterTree *tree);
PETSC_INTERN PetscReal SlipClusterDiameter(const SlipCluster *c);
PETSC_INTERN PetscReal SlipClusterDistance(const SlipCluster *a, const SlipCluster *b);

/* ---- aca.c: low-rank approximation of a block from some of its entries ---- */
typedef PetscReal (*SlipEntryFn)(void *ctx, PetscInt i, PetscInt j); /* entry in row i, column j of the block */
/* U [m * rank] V' [rank * n] (column-major U and V) with an error of about tolerance in the Frobenius norm, relative;
   found is false when the rank would exceed max. U and V are allocated (PetscFree). */
PETSC_INTERN PetscErrorCode SlipCrossApproximate(SlipEntryFn entry, void *ctx, PetscInt m, PetscInt n,
                                                 PetscReal tolerance, PetscInt max, PetscInt *rank, PetscReal **U,
                                                 PetscReal **V, PetscBool *found);

/* ---- hmatrix.c ---- */
PETSC_INTERN PetscErrorCode SlipStiffnessCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance,
                                                     Mat *S);
PETSC_INTERN PetscErrorCode SlipHMatCosts(const SlipCells *cells, PetscReal cost[]);

/* ---- lanczos.c ---- */
/* Whether K is an area-weighted stiffness of cells, or hierarchical: viscosities of it are made here. */
PETSC_INTERN PetscErrorCode SlipViscosityIsOfCells(Mat K, PetscBool *is);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Cells(Mat K, PetscReal factor, Mat *H);
/* Square roots of the weights of S's rows, and their inverses; both NULL without weights. viscosity_cells.c */
PETSC_INTERN PetscErrorCode SlipRootWeights(Mat S, Vec *root, Vec *inverse);
PETSC_INTERN PetscErrorCode SlipViscosityCreate_Lanczos(Mat K, PetscReal factor, Mat *H);
