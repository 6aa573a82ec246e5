/* Runs of the library itself under a policy that is being trained, or under a classical controller. */
#pragma once
#include <slipstep/rooms.h>

/* The policy with its dial at accuracy, whatever it is worth; without one a controller of this type with the relative
   tolerance rtol */
PETSC_INTERN PetscErrorCode RunSetController(TS ts, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                             PetscReal rtol);
/* A controller may drive a run anywhere: an error of the library's is a run that was not solved. */
PETSC_INTERN PetscErrorCode RunSolve(TS ts, Vec w, PetscBool *solved);
