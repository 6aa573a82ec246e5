/* Creation routines of all our types, and the two registration passes. */
#pragma once
#include <petscts.h>

PETSC_INTERN PetscErrorCode SlipRegisterClasses(void);
PETSC_INTERN PetscErrorCode SlipRegisterTypes(void);
