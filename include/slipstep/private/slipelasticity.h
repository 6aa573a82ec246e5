/* Private: parts of the dislocation that operators of a grid take apart. */
#pragma once
#include <slipelasticity.h>

/* ---- dislocation.c ---- */
PETSC_INTERN void SlipKernelSurface_Private(PetscReal G, PetscReal nu, PetscReal dx, PetscReal depth_sum, PetscReal a,
                                            PetscReal b, PetscReal part[3]);
