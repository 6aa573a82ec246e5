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
/* Where the stress of slip on a cell is taken, and what cores edges have, in units of a cell's extent across them. */
typedef enum {
  SLIP_AVERAGE_CENTRE, /* the value at the centre */
  SLIP_AVERAGE_CELL,   /* the average over the cell; one core, for slip that is made to end at some edge */
  SLIP_AVERAGE_WHOLE   /* the same; a core inside and another at the border, for faults all of whose cells slide */
} SlipAverage;
/* The one at which cracks of 10 to 60 cells across have the exact slip in their middle, measured. */
#define SLIP_CORE_CELL 0.11
/* Inside: the one at which waves of slip meet the stiffness of the continuum to the second order of their wavenumber. At
   the border: the one at which a crack that ends there then slips as in the continuum, to the second order as well. */
#define SLIP_CORE_INNER 0.15915494309189535 /* 1 / (2 pi) */
#define SLIP_CORE_BORDER 0.0494428
/* Average of that drop over the receiver; core: of edges that both have in common. */
PETSC_EXTERN PetscReal SlipKernelAverage(PetscReal G, PetscReal nu, const SlipRectangle *receiver,
                                         const SlipRectangle *source, const PetscReal core[2], PetscBool full_space);
/* Displacement [n][3] of points [n][2] of the free surface for unit strike slip. Okada (1985). */
PETSC_EXTERN void SlipSurfaceDisplacement(PetscReal nu, const SlipRectangle *source, PetscInt n,
                                          const PetscReal points[], PetscReal u[]);
