/* Internal header of src/mat: irregular meshes, their trees and their distribution */
#pragma once
#include <slipstep/rooms/slipcells.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcommon.h>
#include <slipstep/private/slipsys.h>

/* ---- irregular.c ---- */
/* S_ij of MatCreateSlipCellStiffness() with unit 1 / (2 mean(A)), or with unit 0 the effect of slip on normal stress */
PETSC_INTERN void SlipCellsEntries(const SlipCells *cells, PetscReal unit, PetscInt m, const PetscInt row[], PetscInt n,
                                   const PetscInt column[], PetscInt lda, PetscReal a[]);
PETSC_INTERN PetscErrorCode SlipCellsRows(MPI_Comm comm, const SlipCells *cells, PetscInt *nlocal);
PETSC_INTERN SlipCell SlipCellsGet(const SlipCells *cells, PetscInt i);
PETSC_INTERN PetscErrorCode SlipCellsDirections(const SlipCells *cells, SlipShared shared, PetscReal **directions);
PETSC_INTERN PetscReal SlipCellsUnit(const SlipCells *cells);
PETSC_INTERN PetscErrorCode SlipCellsDestroy(SlipCells *cells);              /* x owns the memory of all columns */
PETSC_INTERN PetscErrorCode SlipCellsCompose(Mat S, const SlipCells *cells); /* attaches the weights of its rows to S */
/* The cell of a row of the stiffness */
static inline PetscInt SlipCellsAt(const SlipCells *cells, PetscInt row)
{
  return cells->order ? cells->order[row] : row;
}

/* ---- pairs.c: entries of a block, and what its cells are for their kernel ---- */
typedef struct {
  const SlipCells *cells;
  PetscReal unit;
  const SlipKernelLanes *kernel; /* NULL: it has no lanes */
  PetscInt n[2];                 /* numbers of cells of rows and of columns */
  const PetscInt *cell[2];       /* these cells */
  PetscReal *lanes[2];           /* their numbers, [n / SLIP_PAIRS][numbers][SLIP_PAIRS] */
  PetscReal *area[2];            /* [m^2] */
  PetscReal *one;                /* numbers of one cell in all lanes */
  PetscReal *full;               /* all entries; NULL: not computed at once */
} SlipCellsPairs;
PETSC_INTERN PetscErrorCode SlipCellsNumbers(const SlipCells *cells, SlipShared shared, PetscReal **numbers);
PETSC_INTERN PetscErrorCode SlipCellsPairsCreate(const SlipCells *cells, PetscReal unit, PetscInt m,
                                                 const PetscInt row[], PetscInt n, const PetscInt column[],
                                                 SlipCellsPairs *pairs);
PETSC_INTERN void SlipCellsPairsEntries(const SlipCellsPairs *pairs, PetscInt i, PetscInt m, PetscInt j, PetscInt n,
                                        PetscInt lda, PetscReal a[]);
PETSC_INTERN PetscErrorCode SlipCellsPairsFill(SlipCellsPairs *pairs);
PETSC_INTERN PetscErrorCode SlipCellsPairsDestroy(SlipCellsPairs *pairs);

PETSC_INTERN PetscErrorCode SlipCellsPairTime(const SlipCells *cells, PetscBool normal, PetscReal all,
                                              PetscReal *seconds); /* pairtime.c */

/* A cell for sorting by one coordinate [m], and by number if equal */
typedef struct {
  PetscReal key;
  PetscInt cell;
} SlipCellKey;
PETSC_INTERN int SlipCellKeyCompare(const void *a, const void *b); /* for qsort() */

/* ---- edges.c: shared and free edges, for averages over cells; [n][components][components] ---- */
PETSC_INTERN PetscErrorCode SlipCellsEdges(const SlipCells *cells, SlipShared shared, PetscReal **force);
PETSC_INTERN PetscErrorCode SlipTrianglesSides(const SlipCells *cells, PetscReal force[]); /* sides.c, added */

/* ---- clusters.c: a binary tree of cells that are close to each other ---- */
typedef struct {
  PetscInt start, end;      /* its cells are perm[start, end) */
  PetscInt child[2];        /* indices of nodes; -1 in a leaf */
  PetscReal low[3], top[3]; /* box that contains its cells [m] */
  PetscReal diameter;       /* of that box; of dipping cells, of the one that contains their centres [m] */
} SlipCluster;

typedef struct {
  PetscInt *perm; /* [n] cells in the tree's order */
  PetscInt nnodes;
  SlipCluster *node; /* node[0] is the root */
} SlipClusterTree;
PETSC_INTERN void SlipCellsBox(const SlipCells *cells, PetscInt cell, PetscReal box[6]); /* low [3] and top [3] */
PETSC_INTERN PetscErrorCode SlipClusterTreeCreate(const SlipCells *cells, PetscInt leaf, SlipClusterTree *tree);
PETSC_INTERN PetscErrorCode SlipClusterTreeDestroy(SlipClusterTree *tree);
PETSC_INTERN PetscReal SlipClusterDistance(const SlipCluster *a, const SlipCluster *b);
