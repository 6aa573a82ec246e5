/* Elastic half-space: rectangular dislocations in closed form, as pure functions. */
#pragma once
#include <petscsys.h>

/* Static shear-stress DROP at the centre of a receiver for unit uniform strike slip on a rectangular source cell of a
   vertical plane: entry K_ij > 0 on the diagonal [Pa/m]. Okada (1992); Chinnery (1963) for nu = 1/4. */
PETSC_EXTERN PetscReal SlipKernelFullSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dz, PetscReal a,
                                           PetscReal b);
PETSC_EXTERN PetscReal SlipKernelHalfSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal z_receiver,
                                           PetscReal z_source, PetscReal a, PetscReal b);
/* The same with the receiver on a parallel plane at the distance dy [m]. */
PETSC_EXTERN PetscReal SlipKernelOffset(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dy, PetscReal z_receiver,
                                        PetscReal z_source, PetscReal a, PetscReal b, PetscBool full_space);
