/* What models offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipmodels.h>
#include <slipstep/rooms/slipts.h>

PETSC_EXTERN PetscErrorCode SlipModelSetUp(SlipModel model);
PETSC_EXTERN PetscInt SlipModelFindObservation(SlipModel model, const char name[]);
PETSC_EXTERN void SlipModelExactTable(SlipModel model, PetscReal dt, PetscInt n, PetscReal w[]);
PETSC_EXTERN PetscReal SlipSlidingModeEvent(const SlipSlidingMode *m, PetscReal t, PetscReal w);
PETSC_EXTERN void SlipCircuitFlow(const SlipCircuit *c, int sign, PetscReal t, const PetscReal from[], PetscReal to[]);
PETSC_EXTERN void SlipCircuitAdvance(const SlipCircuit *c, PetscReal t, int *sign, PetscReal w[]);
