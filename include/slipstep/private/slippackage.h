/* Creation routines of all our types, and the two registration passes. */
#pragma once
#include <petscts.h>

PETSC_INTERN PetscErrorCode SlipRegisterClasses(void);
PETSC_INTERN PetscErrorCode SlipRegisterTypes(void);
PETSC_INTERN PetscErrorCode SNESCreate_Semismooth(SNES);
PETSC_INTERN PetscErrorCode SNESCreate_Projection(SNES);
PETSC_INTERN PetscErrorCode TSCreate_Bathe(TS);
