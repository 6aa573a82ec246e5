/* Internal to src/fluid: which cells share which sides, and the equations of one cell */
#pragma once
#include <slipstep/rooms/slipfluid.h>

/* The pieces of all cells, in the order of the mesh */
typedef struct {
  PetscInt pieces;
  PetscInt *offset, *piece; /* [N + 1]; number among those of all processes */
} SlipFluidWhole;

/* bodies.c: how many parts of the mesh no side joins; how many cells of different faults or parts meet along a line
   without having it in common, and two faults of which they are, by the order of their labels */
typedef struct {
  PetscInt bodies, apart, fault[2];
} SlipFluidBodies;
PETSC_INTERN PetscErrorCode SlipFluidBodiesFind(const SlipFaultMesh *mesh, const PetscReal points[],
                                                const PetscInt corners[], const SlipFluidWhole *whole,
                                                SlipFluidBodies *bodies);

/* The sides of the cells of this process, in pieces. A piece belongs to a side of a cell as a whole, or to a part of
   it where rectangles meet that are not equal. "Local" numbers of pieces count those that this process owns, then the
   ghosts; a process owns the pieces whose first cell, in the order of the mesh, is its own. */
typedef struct {
  PetscInt owned, ghosts; /* pieces */
  PetscInt first;         /* number of the first owned one among those of all processes */
  PetscInt *ghost;        /* [ghosts] their numbers among those of all processes */
  PetscInt *cells;        /* [owned + ghosts] how many cells share a piece */
  PetscInt most;          /* of a cell of this process */
  PetscInt *offset;       /* [n + 1] of the pieces of a cell in the arrays below */
  PetscInt *piece;        /* local number */
  PetscInt *side;         /* which side of the cell, 0 to 3: between corners side and side + 1 */
  PetscReal *part;        /* its part of the side's length */
  SlipFluidBodies bodies;
} SlipFluidSides;

PETSC_INTERN PetscErrorCode SlipFluidSidesCreate(const SlipFaultMesh *mesh, SlipFluidSides *sides); /* pieces.c */
PETSC_INTERN PetscErrorCode SlipFluidSidesDestroy(SlipFluidSides *sides);

/* meet.c: a point on a side, and where it is from the side's begin to its end, 0 to 1 */
typedef struct {
  PetscInt point;
  PetscReal part;
} SlipFluidCut;

/* Side k of the rectangles goes from corner k to the next one, 4 for each cell. */
typedef struct {
  PetscInt *point;   /* [4 N] corners at one place have one number */
  PetscInt *first;   /* [4 N + 1] of each side in cut[] */
  SlipFluidCut *cut; /* in order along the side */
} SlipFluidMeet;

PETSC_INTERN PetscErrorCode SlipFluidMeetCreate(PetscInt N, const PetscReal points[], SlipFluidMeet *meet);
PETSC_INTERN PetscErrorCode SlipFluidMeetDestroy(SlipFluidMeet *meet);

/* cell.c: one cell; its corners in the plane of the cell, along strike and down dip, from its centre [m] */
typedef struct {
  PetscReal storage, along, down, sink, border; /* as in SlipDiffusionCells */
  PetscInt corners;                             /* 3, or 4: a rectangle of corner[0] = half its sides */
  PetscReal corner[3][2];                       /* of triangles: corner[k] is opposite of side k */
} SlipFluidCell;

/* The pieces of one cell, which are in the order of the sides and along each */
typedef struct {
  PetscInt n;
  const PetscInt *side;
  const PetscReal *part;
  PetscReal *t;      /* what flows out through a piece per pressure of the cell above that of all pieces [m^3/(Pa s)] */
  PetscReal *couple; /* [3] of triangles, with n = 3: the second part of T for the sides other than k (cell.c) */
  PetscReal *gathered; /* [n] work */
} SlipFluidPieces;

PETSC_INTERN void SlipFluidCellShape(const SlipFaultCell *from, SlipFluidCell *cell);
/* Sets t of the pieces, and what else follows of the coefficients; returns the sum of t. */
PETSC_INTERN PetscReal SlipFluidCellWeights(const SlipFluidCell *c, const SlipFluidPieces *p);
/* Matrix of a cell [n][n] for the pressures of its pieces after its own was eliminated [m^3/Pa]; kept: storage plus dt
   sink */
PETSC_INTERN void SlipFluidCellMatrix(const SlipFluidCell *c, PetscReal kept, PetscReal dt, const SlipFluidPieces *p,
                                      PetscReal total, PetscReal matrix[]);
/* What flows out through its pieces [m^3/s] at its pressure y and those of the pieces */
PETSC_INTERN void SlipFluidCellFlux(const SlipFluidCell *c, const SlipFluidPieces *p, PetscReal y,
                                    const PetscReal lambda[], PetscReal flux[]);
/* The Darcy flux times width at its centre [m^2/s] */
PETSC_INTERN void SlipFluidCellCentre(const SlipFluidCell *c, const SlipFluidPieces *p, const PetscReal flux[],
                                      PetscReal centre[2]);
PETSC_INTERN PetscReal SlipFluidCellRadius(const SlipFluidCell *c);

/* solver.c: for a matrix that is set; step: dt times what flows out of a cell per pressure, over its storage, on
   average */
PETSC_INTERN PetscErrorCode SlipFluidSolverChoose(KSP ksp, PetscInt cells, PetscReal step);

/* diffusion.c */
struct _SlipDiffusion {
  MPI_Comm comm;
  PetscInt n, all; /* cells of this process, and of all */
  SlipFluidSides sides;
  SlipFluidCell *cell; /* [n] */
  PetscReal *t;        /* [pieces of all n cells] weights, */
  PetscReal *couple;   /* [n][3] of SlipFluidPieces */
  PetscReal *kept;     /* [n] storage plus dt sink of this solve [m^3/Pa] */
  PetscReal *total;    /* [n] sums of weights, */
  PetscReal *sum;      /* [local pieces] and those of the cells that share a piece */
  PetscReal *held;     /* [local pieces] pressure of the border, NaN elsewhere */
  PetscReal *flux;     /* [pieces of all n cells] of the last solve, outwards [m^3/s] */
  PetscReal *gathered; /* [most] pressures of the pieces of a cell */
  PetscReal *value;    /* of the matrix, cell by cell */
  PetscReal dt;        /* the matrix is that of this step; 0: of none */
  PetscReal mean;      /* dt T/C on average, by which the solver is chosen */
  PetscReal fastest;   /* largest T/C [1/s] */
  PetscReal accuracy;  /* [Pa] */
  PetscBool set;
  PetscBool similar;     /* the preconditioner may be that of another matrix: */
  PetscReal made;        /* that of this step; 0: of none */
  PetscInt first, last;  /* iterations of the first solve with it, -1: none; and of the last one */
  PetscInt *other;       /* [pieces of all n cells] the cell at the other side, -1: none; NULL: unknowns are sides */
  const char *prefix;    /* of the solver's options */
  Vec lambda, residual;  /* of pieces, with ghosts */
  PetscBool begun;       /* lambda is set, by SlipDiffusionBegin(): */
  const PetscReal *base; /* [n] for these pressures of the cells; NULL: for the guess of the next solve */
  Vec right, step;       /* of the unknowns; of pieces with ghosts */
  Mat A;
  KSP ksp;
};

static inline SlipFluidPieces SlipFluidPiecesOf(SlipDiffusion d, PetscInt i)
{
  const PetscInt first = d->sides.offset[i];

  return (SlipFluidPieces){d->sides.offset[i + 1] - first,
                           d->sides.side + first,
                           d->sides.part + first,
                           d->t + first,
                           d->couple + 3 * i,
                           d->gathered};
}

/* Adds up numbers of the pieces of all cells at their pieces, of which all processes that have them get the sum. */
PETSC_INTERN PetscErrorCode SlipDiffusionSum(SlipDiffusion d, const PetscReal x[], Vec sum);
/* Assembles the matrix for a step. */
PETSC_INTERN PetscErrorCode SlipDiffusionAssemble(SlipDiffusion d, PetscReal dt);
