/* Private: parts of the dislocation that operators of a grid take apart. */
#pragma once
#include <slipelasticity.h>

/* Edges that differ by less than this share of the smaller cell's smaller side touch. */
#define SLIP_TOUCH 1e-6

/* ---- dislocation.c ---- */
PETSC_INTERN void SlipKernelSurface_Private(PetscReal G, PetscReal nu, PetscReal dx, PetscReal depth_sum, PetscReal a,
                                            PetscReal b, PetscReal part[3]);

/* ---- average.c; core: of edges inside, in units of cells ---- */
static inline PetscReal SlipAverageCore(SlipAverage average)
{
  return average == SLIP_AVERAGE_WHOLE ? SLIP_CORE_INNER : SLIP_CORE_CELL;
}
/* The border's core over that. */
static inline PetscReal SlipAverageBorderRatio(SlipAverage average)
{
  return average == SLIP_AVERAGE_WHOLE ? SLIP_CORE_BORDER / SLIP_CORE_INNER : 1;
}
/* equal cells of a grid */
PETSC_INTERN PetscReal SlipAverageDirect_Private(PetscReal G, PetscReal nu, PetscReal core, PetscReal dx, PetscReal dz,
                                                 PetscReal a, PetscReal b);
PETSC_INTERN void SlipAverageSurface_Private(PetscReal G, PetscReal nu, PetscReal core, PetscReal dx,
                                             PetscReal depth_sum, PetscReal a, PetscReal b, PetscReal part[2]);
PETSC_INTERN PetscReal SlipAverageBorder_Private(PetscReal G, PetscReal nu, PetscBool along_strike, PetscReal normal,
                                                 PetscReal share, PetscReal ratio);
