/* Diffusion of pore fluid in the cells of a fault mesh. It knows meshes and no fault. */
#pragma once
#include <petscksp.h>
#include <slipstep/private/slipmesh.h>

typedef struct _SlipDiffusion *SlipDiffusion;

/* Coefficients of the cells of this process [n]; copied */
typedef struct {
  const PetscReal *storage;      /* volume that a cell takes in per pressure, C [m^3/Pa], > 0 */
  const PetscReal *along, *down; /* permeability times width over viscosity, along strike and down dip [m^3/(Pa s)] */
  const PetscReal *sink;         /* volume rate that leaves a cell per pressure [m^3/(Pa s)]; NULL: 0 */
  const PetscReal *border;       /* pressure at those sides of a cell that no other cell shares [Pa]; NaN: nothing
                                    flows through them; NULL: through none */
} SlipDiffusionCells;

/* Collective. prefix: of the fault; that of the options of its KSP has "fault_fluid_" behind it */
PETSC_EXTERN PetscErrorCode SlipDiffusionCreate(const SlipFaultMesh *mesh, const char prefix[], SlipDiffusion *d);
PETSC_EXTERN PetscErrorCode SlipDiffusionDestroy(SlipDiffusion *d);
/* Sets coefficients; the matrix follows at the next solve. Setting equal ones, bit by bit on all processes, keeps the
   factorisation. */
PETSC_EXTERN PetscErrorCode SlipDiffusionSet(SlipDiffusion d, const SlipDiffusionCells *cells);
/* One implicit stage: C y + dt (net outflow of y through sides + sink y) = b. b, y [n]: volumes [m^3], pressures [Pa];
   y on input: a guess, which decides the result only within the tolerance of the solver. What leaves a cell through a
   shared side enters the others to the last bit but rounding, whatever the solver's tolerance is. Collective. */
PETSC_EXTERN PetscErrorCode SlipDiffusionSolve(SlipDiffusion d, PetscReal dt, const PetscReal b[], PetscReal y[]);
/* The error of a pressure that solves may leave [Pa], where 1e-9 of the largest change from the guess is less; 0 at
   first. */
PETSC_EXTERN PetscErrorCode SlipDiffusionAccuracy(SlipDiffusion d, PetscReal error);
/* The next solve makes the preconditioner of its matrix, unless it has that one. Later ones use it for similar matrices
   too, so that their rounding depends on what was solved since this call. */
PETSC_EXTERN PetscErrorCode SlipDiffusionRenew(SlipDiffusion d);
/* Pressures of sides: how many a cell has at most, on all processes, 0 where those of the cells are the unknowns. Keeps
   those of the last solve, x[stride i + k] of side k of cell i, in the same order on any number of processes; and lets
   the next solve begin with such ones, NULL: of the last solve, at which the cells' pressures were y [n], which must
   stand until then; NULL: the guess of that solve. */
PETSC_EXTERN PetscErrorCode SlipDiffusionMost(SlipDiffusion d, PetscInt *most);
PETSC_EXTERN PetscErrorCode SlipDiffusionKeep(SlipDiffusion d, PetscInt stride, PetscReal x[]);
PETSC_EXTERN PetscErrorCode SlipDiffusionBegin(SlipDiffusion d, PetscInt stride, const PetscReal x[],
                                               const PetscReal y[]);
/* What flows at the pressures y of the last solve: through the border, outwards, of the cells of all processes [m^3/s],
   and the Darcy flux times width at the centres [n][2], along strike and down dip [m^2/s]. NULL: not wanted */
PETSC_EXTERN PetscErrorCode SlipDiffusionFlow(SlipDiffusion d, PetscReal *border, PetscReal flux[]);
/* The radius at which the pressure around a well equals the pressure of its cell (Peaceman 1978) [m], [n] */
PETSC_EXTERN PetscErrorCode SlipDiffusionRadius(SlipDiffusion d, PetscReal radius[]);
/* Bodies of fluid, which no side joins; how many cells meet cells of another fault or body without a common side, and
   the labels of two faults of which they are */
PETSC_EXTERN PetscErrorCode SlipDiffusionBodies(SlipDiffusion d, PetscInt *bodies, PetscInt *apart, PetscInt faults[2]);
PETSC_EXTERN PetscErrorCode SlipDiffusionView(SlipDiffusion d, PetscViewer viewer);
