/* What elasticity offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipelasticity.h>

PETSC_EXTERN PetscErrorCode SlipKernelCheck(MPI_Comm comm, const SlipKernel *kernel);
/* Fields at points [n][3] of slip [3] on the source, along strike, up dip and opening, with or without a free surface.
   Okada (1992). */
PETSC_EXTERN PetscErrorCode SlipDippingDisplacement(PetscReal nu, PetscBool full_space,
                                                    const SlipDippingRectangle *source, const PetscReal slip[],
                                                    PetscInt n, const PetscReal points[], PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipDippingGradient(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *source,
                                                const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                PetscReal gradient[]);
PETSC_EXTERN PetscErrorCode SlipDippingStress(PetscReal G, PetscReal nu, PetscBool full_space,
                                              const SlipDippingRectangle *source, const PetscReal slip[], PetscInt n,
                                              const PetscReal points[], PetscReal stress[]);
/* The same for a triangle with the vertices [3][3] and slip [3] along strike, up dip and opening */
PETSC_EXTERN PetscErrorCode SlipTriangleDisplacement(PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                                     const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                     PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipTriangleGradient(PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                                 const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                 PetscReal gradient[]);
PETSC_EXTERN PetscErrorCode SlipTriangleStress(PetscReal G, PetscReal nu, PetscBool full_space,
                                               const PetscReal vertices[], const PetscReal slip[], PetscInt n,
                                               const PetscReal points[], PetscReal stress[]);
PETSC_EXTERN PetscErrorCode SlipTriangleDirections(const PetscReal vertices[], const PetscReal side[],
                                                   PetscReal angles[], PetscReal directions[]);
