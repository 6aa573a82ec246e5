/* Irregular meshes of rectangles and triangles in any direction, and their stiffness */
#pragma once
#include <petscmat.h>
#include <slipelasticity.h>

/* Cells in any order; every process stores all of them. */
typedef struct {
  PetscInt n;
  const PetscReal *x, *y,
    *z; /* centres [n]: north, east and depth [m]; of vertical planes along x: along strike, across */
  const PetscReal *length;              /* extent along strike [n] [m] */
  const PetscReal *width;               /* extent along dip [n] [m] */
  const PetscReal *strike, *dip, *rake; /* [n] after Aki & Richards [deg]; NULL: 0, 90 and 0 for all */
  SlipKernel kernel;                    /* computes K_ij, the stress drop on cell i for unit slip on cell j */
  const PetscInt *order;                /* cell of each row of the stiffness [n]; NULL: cell i is row i, PETSC_DECIDE */
  PetscInt nlocal;                      /* rows of this process, if there is an order */
  const PetscReal *edges;               /* for averages: creators of stiffnesses set it in their own copies */
  const PetscReal *directions;          /* [n][3][3] of triangles, likewise */
  const PetscReal *numbers;             /* of cells for their kernel, likewise */
  const PetscInt *number;               /* of each cell in messages [n]; NULL: counted from 0 */
  /* Of triangles [n][3][3]: north, east and down [m]; NULL: rectangles. For triangles the centres are centroids, length
     * width is the area, and dips above 90 are those of overturned cells, whose hanging wall is below. */
  const PetscReal *vertices;
} SlipCells;

/* Creates the area-weighted stiffness, which is symmetric: S_ij = (A_i K_ij + A_j K_ji) / (2 mean(A)) [Pa/m]; K_ij is
   the stress drop at the centre of cell i, or its average there, for unit slip on cell j. type: "dense", "hmat"
   (hierarchical, to the relative tolerance) or "auto". cells->order distributes the rows. */
PETSC_EXTERN PetscErrorCode MatCreateSlipCellStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                       PetscReal tolerance, Mat *S);
/* Creates the effect of slip on normal stress: compression at the centre of cell i for unit slip on cell j [Pa/m],
   neither symmetric nor weighted. The kernel must have a row of normal stress; type and tolerance are as above. */
PETSC_EXTERN PetscErrorCode MatCreateSlipCellNormalStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                             PetscReal tolerance, Mat *Kn);
/* The same for slip and shear traction as vectors along strike and up dip of each cell (rakes are ignored): rows and
   columns 2 i and 2 i + 1 belong to the row of cell i. S is symmetric and area weighted, 2 N x 2 N [Pa/m]; Kn (may be
   NULL) is compression, N x 2 N, not weighted. */
PETSC_EXTERN PetscErrorCode MatCreateSlipCellVectorStiffness(MPI_Comm comm, const SlipCells *cells, const char *type,
                                                             PetscReal tolerance, Mat *S, Mat *Kn);
