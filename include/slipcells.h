/* Irregular meshes: rectangles and triangles of any direction, and their stiffness. */
#pragma once
#include <petscmat.h>
#include <slipelasticity.h>

/* Cells in any order; every process holds all of them. */
typedef struct {
  PetscInt n;
  const PetscReal *x, *y,
    *z; /* centres [n]: north, east and depth [m]; of vertical planes along x: along strike, across */
  const PetscReal *length;              /* extent along strike [n], [m] */
  const PetscReal *width;               /* extent along dip [n], [m] */
  const PetscReal *strike, *dip, *rake; /* [n], after Aki & Richards [deg]; NULL: 0, 90 and 0 of all */
  SlipKernel kernel;                    /* of K_ij, the stress drop on cell i for unit slip on cell j */
  const PetscInt *order;  /* cell of each row of the stiffness [n]; NULL: cell i is row i, shares by PETSC_DECIDE */
  PetscInt nlocal;        /* rows of this process, where there is an order */
  const PetscReal *edges; /* of averages: the creators of stiffnesses fill it in their own copies */
  const PetscReal *directions; /* [n][3][3] of triangles, likewise */
  const PetscInt *number;      /* of each cell in messages [n]; NULL: from 0 */
  /* Of triangles [n][3][3], north, east and down [m]; NULL: rectangles. The centres are centroids, length * width the
     area, and dips of more than 90 those of cells that are overturned: their hanging wall is below. */
  const PetscReal *vertices;
} SlipCells;

/* Refuses cells that are not finite, have no extent, reach above the surface, overlap or cross; source names where they
   come from in messages, which count rows from 0. */
PETSC_EXTERN PetscErrorCode SlipCellsCheck(MPI_Comm comm, const SlipCells *cells, const char source[]);

/* Compact shares of a mesh for the processes, of equal cost, by METIS: what order [n] (PetscFree() it) and nlocal above
   should be for a stiffness of this type. */
PETSC_EXTERN PetscErrorCode SlipCellsPartition(MPI_Comm comm, const SlipCells *cells, const char *type,
                                               PetscInt **order, PetscInt *nlocal);

/* Area-weighted stiffness, symmetric: S_ij = (A_i K_ij + A_j K_ji) / (2 mean(A)) [Pa/m], K_ij the stress drop at the
   centre of cell i, or on its average, for unit slip on cell j. type: "dense", "hmat" (hierarchical, to the relative
   tolerance) or "auto". Rows are distributed as cells->order says. */
PETSC_EXTERN PetscErrorCode MatCreateSlipCellStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                       PetscReal tolerance, Mat *S);
/* What slip does to normal stress: compression at the centre of cell i for unit slip on cell j [Pa/m], neither
   symmetric nor weighted. The kernel has a row of normal stress; type and tolerance as above. */
PETSC_EXTERN PetscErrorCode MatCreateSlipCellNormalStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                             PetscReal tolerance, Mat *Kn);
/* Slip and shear traction as vectors along strike and up dip of each cell (its rake does not count): rows and columns 2
   i and 2 i + 1 are those of cell i's row. S: symmetric, area weighted, 2 N x 2 N [Pa/m]; Kn (NULL: not wanted):
   compression, N x 2 N, not weighted. */
PETSC_EXTERN PetscErrorCode MatCreateSlipCellVectorStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                             PetscReal tolerance, Mat *S, Mat *Kn);
/* The weights A_i / mean(A) of the rows of such a stiffness, or NULL when all are 1; borrowed. */
PETSC_EXTERN PetscErrorCode MatSlipGetWeights(Mat S, Vec *weights);

/* For a viscosity applied by Lanczos' method: relative tolerance of its products; others ignore it. */
PETSC_EXTERN PetscErrorCode MatSlipViscosityAllow(Mat H, PetscReal tolerance);
PETSC_EXTERN PetscErrorCode MatSlipViscositySetTolerance(Mat H, PetscReal tolerance);
PETSC_EXTERN PetscErrorCode MatSlipViscositySetFromOptions(Mat H);
