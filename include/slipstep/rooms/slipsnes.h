/* What snes offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipsnes.h>

PETSC_EXTERN PetscErrorCode SlipSNESInitializePackage(void); /* creation routines call it; later calls do nothing */
PETSC_EXTERN PetscErrorCode SlipConstraintGetComponents(SlipConstraint con, PetscInt *c);
PETSC_EXTERN PetscErrorCode SlipConstraintReactionOf(SlipConstraint con, PetscReal t, Vec w, Vec Fs, Vec r);
PETSC_EXTERN PetscErrorCode MatCreateSlipJacobian(Mat B, Mat *J);
PETSC_EXTERN PetscErrorCode MatSlipJacobianSetParts(Mat J, Mat B, Vec mask, Vec slope);
PETSC_EXTERN PetscErrorCode MatSlipJacobianGetParts(Mat J, Mat *B, Vec *mask, Vec *slope); /* borrowed */
