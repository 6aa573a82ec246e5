/* The wells of -fault_wells: how much fluid enters the cells of a fault, or at which pressure a well is held */
#pragma once
#include <slipstep/rooms/slipfault.h>

typedef struct {
  char *name;
  PetscReal place[3];       /* x, y, z [m]; y is that of the nearest cell where the file has none */
  PetscInt rows;            /* changes */
  PetscReal *time, *value;  /* [rows] from when on [s], and what holds from then on: into the fault [m^3/s], or [Pa] */
  PetscBool pressure;       /* values are pressures */
  PetscReal radius, spread; /* of the well; standard deviation of the Gaussian over which a rate is spread, 0: none [m]
                             */
  PetscReal away;           /* from the centre of the nearest cell, in x and z where the file has no y [m] */
  PetscInt ncells, *cell;   /* [ncells] of this process */
  PetscReal *share;         /* [ncells] of the rate; all processes together 1 */
} SlipFaultWell;

/* wells.c */
PETSC_EXTERN PetscErrorCode SlipFaultWellsSetUp(SlipFault fault); /* collective */
PETSC_INTERN PetscErrorCode SlipFaultWellsDestroy(SlipFault fault);
PETSC_INTERN PetscErrorCode SlipFaultWellsView(SlipFault fault, PetscViewer viewer);
/* What the file says for t: a rate is 0 before its first time, and a pressure is not held before it. A step that begins
   at a change, to the rounding of time, has what holds after it. */
PETSC_EXTERN PetscReal SlipFaultWellValue(const SlipFaultWell *well, PetscReal t);
PETSC_EXTERN PetscBool SlipFaultWellHolds(const SlipFaultWell *well, PetscReal t);
PETSC_INTERN PetscReal SlipFaultWellNext(const SlipFaultWell *well, PetscReal t); /* change; PETSC_MAX_REAL: none */
