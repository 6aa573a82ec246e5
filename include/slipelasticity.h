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

/* A rectangle of a vertical plane: centre along strike, across and in depth, extents along strike and in depth [m]. */
typedef struct {
  PetscReal x, y, z, length, width;
} SlipRectangle;
/* Cores of edges in units of a cell's extent across them. Inside of a grid: the one at which waves of slip meet the
   stiffness of the continuum up to the second order of their wavenumber. Where slip ends: the one at which a crack that
   ends there slips as in the continuum, up to the second order of the cell. */
#define SLIP_CORE_INNER 0.15915494309189535 /* 1 / (2 pi) */
#define SLIP_CORE_BORDER 0.0494428
/* Average of that drop over the receiver; core: of edges that both have in common. */
PETSC_EXTERN PetscReal SlipKernelAverage(PetscReal G, PetscReal nu, const SlipRectangle *receiver,
                                         const SlipRectangle *source, const PetscReal core[2], PetscBool full_space);
