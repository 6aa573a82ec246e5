/* Internal to src/fluid: which cells share which sides, and the equations of one cell */
#pragma once
#include <slipstep/rooms/slipfluid.h>

enum { FLUID_ENDS = 4 }; /* most sides of a cell */

/* The sides of the cells of this process, in pieces. A piece belongs to a side of a cell as a whole, or to a part of
   it where rectangles meet that are not equal. "Local" numbers of pieces count those that this process owns, then the
   ghosts; a process owns the pieces whose first cell, in the order of the mesh, is its own. */
typedef struct {
  PetscInt owned, ghosts; /* pieces */
  PetscInt first;         /* number of the first owned one among those of all processes */
  PetscInt *ghost;        /* [ghosts] their numbers among those of all processes */
  PetscInt *cells;        /* [owned + ghosts] how many cells share a piece */
  PetscInt *offset;       /* [n + 1] of the pieces of a cell in the arrays below */
  PetscInt *piece;        /* local number */
  PetscInt *side;         /* which side of the cell, 0 to 3: between corners side and side + 1 */
  PetscReal *part;        /* its part of the side's length */
} SlipFluidSides;

PETSC_INTERN PetscErrorCode SlipFluidSidesCreate(const SlipFaultMesh *mesh, SlipFluidSides *sides); /* sides.c */
PETSC_INTERN PetscErrorCode SlipFluidSidesDestroy(SlipFluidSides *sides);

/* cell.c: one cell; its corners in the plane of the cell, along strike and down dip, from its centre [m] */
typedef struct {
  PetscReal storage, along, down, sink, border; /* as in SlipDiffusionCells */
  PetscInt corners;                             /* 3, or 4: a rectangle of corner[0] = half its sides */
  PetscReal corner[3][2];                       /* of triangles: corner[k] is opposite of side k */
} SlipFluidCell;

PETSC_INTERN void SlipFluidCellShape(const SlipFaultCell *from, SlipFluidCell *cell);
/* t [pieces]: what flows out through a piece per pressure of the cell above that of the piece [m^3/(Pa s)]. Returns
   their sum. */
PETSC_INTERN PetscReal SlipFluidCellWeights(const SlipFluidCell *c, PetscInt pieces, const PetscInt side[],
                                            const PetscReal part[], PetscReal t[]);
/* Matrix of a cell [pieces][pieces] for the pressures of its pieces after its own was eliminated [m^3/Pa] */
PETSC_INTERN void SlipFluidCellMatrix(const SlipFluidCell *c, PetscReal dt, PetscInt pieces, const PetscReal t[],
                                      PetscReal total, PetscReal matrix[]);
/* What flows out through its pieces [m^3/s] at its pressure p and those of the pieces */
PETSC_INTERN void SlipFluidCellFlux(const SlipFluidCell *c, PetscInt pieces, const PetscReal t[], PetscReal p,
                                    const PetscReal lambda[], PetscReal flux[]);
/* The Darcy flux times width at its centre [m^2/s] */
PETSC_INTERN void SlipFluidCellCentre(const SlipFluidCell *c, PetscInt pieces, const PetscInt side[],
                                      const PetscReal flux[], PetscReal centre[2]);
PETSC_INTERN PetscReal SlipFluidCellRadius(const SlipFluidCell *c);
