/* What ts offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipts.h>
#include <slipstep/rooms/slipsnes.h>
#include <slipstep/rooms/slipsys.h>

PETSC_EXTERN PetscErrorCode SlipTSInitializePackage(void);   /* creation routines call it; later calls do nothing */
PETSC_EXTERN PetscErrorCode TSBatheIs(TS ts, PetscBool *is); /* is ts of type bathe or moreau? */
PETSC_EXTERN PetscErrorCode TSBatheSetDefaultMethod(TS ts, TSBatheMethod method);
PETSC_EXTERN PetscErrorCode TSBatheGetSolveCost(TS ts, PetscReal *cost); /* relative to an explicit step */
PETSC_EXTERN PetscErrorCode TSBatheSetDoublingOrder(TS ts, PetscInt p);
/* Quadrature over the last accepted step: borrowed states at these fractions of the step, with their weights */
PETSC_EXTERN PetscErrorCode TSBatheGetQuadrature(TS ts, PetscReal share[3], PetscReal weight[3], Vec state[3]);
/* Divides each step into parts, which change neither steps nor estimates and make the solution finer; the function gets
   the state [v, u, s per cell] at the end of each part. */
typedef PetscErrorCode (*TSBathePartFn)(TS ts, PetscReal time, Vec w, void *ctx);
PETSC_EXTERN PetscErrorCode TSBatheSetParts(TS ts, PetscInt parts, TSBathePartFn told, void *ctx);
PETSC_EXTERN PetscErrorCode TSBatheGetExplicitAttempts(TS ts, PetscInt *attempts);
/* Is ts of type lapusta, and were slip rates constant in its last step? */
PETSC_EXTERN PetscErrorCode SlipLapustaIsStraight(TS ts, PetscBool *lapusta, PetscBool *straight);
