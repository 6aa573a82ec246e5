/* What adapt offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipadapt.h>
#include <slipstep/rooms/slippolicy.h>
#include <slipstep/rooms/slipts.h>

PETSC_EXTERN PetscErrorCode SlipAdaptInitializePackage(void); /* creation routines call it; later calls do nothing */
PETSC_EXTERN PetscErrorCode SlipAdaptSetNorm(TSAdapt adapt, NormType type);
PETSC_EXTERN PetscErrorCode TSAdaptRLSetDefaultAccuracy(TSAdapt adapt, PetscReal accuracy);
PETSC_EXTERN PetscErrorCode TSAdaptRLIsChosen(TSAdapt adapt, PetscBool *chosen);
PETSC_EXTERN PetscErrorCode TSAdaptRLHasActor(TSAdapt adapt, PetscBool *has);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetMeasure(TSAdapt adapt, const char *measure[]);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetHandoverStep(TSAdapt adapt, PetscInt *steps);
PETSC_EXTERN PetscErrorCode TSAdaptRLGetFallback(TSAdapt adapt, TSAdaptType *type);
