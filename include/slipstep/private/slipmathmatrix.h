/* Internal header of src/mat: hierarchical storage of the stiffness of cells */
#pragma once
#include <slipstep/private/slipmatcells.h>

/* ---- aca.c: low-rank approximation of a block from some of its entries ---- */
/* Computes the entries a, column-major, of m tuples of rows from tuple i on and n tuples of columns from tuple j on. */
typedef void (*SlipEntriesFn)(void *ctx, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscReal a[]);
/* Computes U [row_tuples * rows][rank] V' [rank][column_tuples * columns] (column-major U and V) with a relative error
   of about tolerance in the Frobenius norm; found is false if the rank would exceed max. The tolerance includes the
   rounding of all but the first head terms to single precision. U and V are allocated (PetscFree). */
PETSC_INTERN PetscErrorCode SlipCrossApproximate(SlipEntriesFn entries, void *ctx, PetscInt row_tuples, PetscInt rows,
                                                 PetscInt column_tuples, PetscInt columns, PetscReal tolerance,
                                                 PetscInt max, PetscInt *rank, PetscInt *head, PetscReal **U,
                                                 PetscReal **V, PetscBool *found);

/* The largest rank at which both factors have no more numbers than the block, r (m + n) <= m n, which needs more than
   32 bits from 46,341 rows and columns on */
static inline PetscInt SlipRankMost(PetscInt m, PetscInt n)
{
  return (PetscInt)((PetscInt64)m * n / ((PetscInt64)m + n));
}

/* Computes the first terms of a full block A [m * n], column-major: crosses through the largest entries, until the
   remainder, which replaces A, is at most share of A in the Frobenius norm. U [m * most] and V [n * most]; found is
   false if more than most terms are needed. */
PETSC_INTERN void SlipCrossSplit(PetscInt m, PetscInt n, PetscReal share, PetscInt most, PetscReal A[], PetscInt *terms,
                                 PetscReal U[], PetscReal V[], PetscBool *found);

/* ---- hblocks.c: the data of products ---- */
#define SLIP_HBLOCK_PAD 4
typedef struct {
  PetscInt row, column; /* the first, in the tree's order */
  PetscInt m, n;
  PetscInt rank;    /* terms of a low-rank block; -1: a full one */
  PetscInt head;    /* terms in double precision; other terms are in single precision */
  PetscBool single; /* of a full block: all but its head terms are in single precision */
  PetscReal *data;  /* in the order of hblocks.c */
} SlipHBlock;

PETSC_INTERN PetscErrorCode SlipHBlockStore(SlipHBlock *k, const PetscReal U[], const PetscReal V[],
                                            const PetscReal A[]);
PETSC_INTERN PetscReal SlipHBlockBytes(const SlipHBlock *k);
PETSC_INTERN PetscLogDouble SlipHBlockFlops(const SlipHBlock *k);
PETSC_INTERN PetscInt SlipHBlockWork(const SlipHBlock *k);
PETSC_INTERN void SlipHBlocksApply(PetscInt nblocks, const SlipHBlock block[], PetscBool whole, const PetscReal x[],
                                   PetscReal y[], PetscReal t[]);

/* ---- hdevice.c: products on the device ---- */
/* Data of the products, borrowed */
typedef struct {
  const SlipClusterTree *tree;
  PetscInt N, rows, columns; /* cells, and rows and columns of each */
  PetscBool whole;           /* no block represents its transpose, too */
  PetscInt nblocks;
  const SlipHBlock *block;
  const PetscInt *order; /* [N] number among the rows' cells of each cell in the tree's order */
} SlipHShape;
typedef struct _n_SlipHDevice *SlipHDevice;
PETSC_INTERN PetscErrorCode SlipHDeviceBytes(const SlipHShape *shape, PetscReal *bytes);
PETSC_INTERN PetscErrorCode SlipHDeviceCreate(const SlipHShape *shape, SlipHDevice *device);
PETSC_INTERN PetscErrorCode SlipHDeviceDestroy(SlipHDevice *device);
PETSC_INTERN PetscErrorCode SlipHDeviceApply(SlipHDevice device, PetscReal scale, Vec x, Vec y);

/* ---- hpartition.c: blocks and processes ---- */
/* A block: its clusters, and whether it is far enough to be of low rank */
typedef struct {
  PetscInt a, b; /* nodes of the cluster tree */
  PetscBool low;
} SlipHPair;

typedef struct {
  PetscReal admissible;
  PetscInt n, capacity;
  SlipHPair *pair;
} SlipHPairs;

/* Parts of blocks: those of block i are first[i] to first[i + 1], and each has about the same number of terms */
typedef struct {
  PetscInt *first;     /* [blocks + 1] */
  PetscMPIInt *keeper; /* the process that stores and applies each; the first one of a block computes the block */
  PetscInt *start,
    *block; /* the blocks of process r's parts are block[start[r]] to block[start[r + 1] - 1], by number */
} SlipHParts;
PETSC_INTERN PetscErrorCode SlipHPairsCreate(const SlipCells *cells, PetscBool whole, SlipClusterTree *tree,
                                             SlipHPairs *list);
PETSC_INTERN PetscErrorCode SlipHPairsAssign(const SlipClusterTree *tree, const SlipHPairs *list, PetscReal tolerance,
                                             const PetscMPIInt owner[], PetscMPIInt size, SlipHParts *parts);
PETSC_INTERN PetscReal SlipHPairCost(const SlipClusterTree *tree, const SlipHPair *pair, PetscReal tolerance);
PETSC_INTERN PetscErrorCode SlipHPartsDestroy(SlipHParts *parts);
/* Runs of consecutive cells of the tree's order that blocks touch */
typedef struct {
  PetscInt start, end, place; /* place: number of the first cell among those of all runs */
} SlipHRun;
typedef struct {
  PetscInt n, cells; /* numbers of runs, and of their cells */
  SlipHRun *run;     /* [n], ascending; PetscFree() */
} SlipHRuns;
PETSC_INTERN PetscErrorCode SlipHRunsCreate(const SlipClusterTree *tree, const SlipHPairs *list,
                                            const SlipHParts *parts, PetscMPIInt rank, PetscBool rows,
                                            PetscBool columns, SlipHRuns *runs);
PETSC_INTERN PetscInt SlipHRunsPlace(const SlipHRuns *runs, PetscInt cell);
PETSC_INTERN PetscErrorCode SlipHMatCosts(const SlipCells *cells, PetscReal cost[]);
/* The usual number of terms of a low-rank block, which grows with the square of the logarithm of the tolerance: 13, 28
   and 50 at 1e-4, 1e-6 and 1e-8 (8,000 triangles of a bent fault) */
PETSC_INTERN PetscReal SlipHRank(PetscReal tolerance);
/* How many rows and columns of a low-rank block are computed */
PETSC_INTERN PetscReal SlipHSearched(PetscReal tolerance);
/* ---- hlayout.c: which process has which blocks; the processes of a machine hold it once ---- */
typedef struct {
  SlipShared shared;
  SlipClusterTree tree;
  SlipHPairs list;
  SlipHParts parts;
  PetscInt *order; /* [N] number among the rows' cells of each cell in the tree's order */
} SlipHLayout;
PETSC_INTERN PetscErrorCode SlipHLayoutCreate(PetscLayout rows, const SlipCells *cells, PetscBool whole,
                                              PetscReal tolerance, SlipHLayout *layout);
PETSC_INTERN PetscErrorCode SlipHLayoutDestroy(SlipHLayout *layout);
/* ---- hforecast.c ---- */
PETSC_INTERN PetscErrorCode SlipHMatForecast(const SlipCells *cells, PetscBool whole, PetscReal tolerance,
                                             PetscMPIInt size, const PetscInt order[], const PetscInt count[],
                                             SlipCellsForecast forecast[]);

/* ---- hmatrix.c ---- */
PETSC_INTERN PetscErrorCode SlipCellMatCreate_HMat(MPI_Comm comm, const SlipCells *cells, PetscReal tolerance,
                                                   PetscBool whole, Mat *S);
