/* What the error handler of programs adds to a message, and what it clears away. Without that handler these do
   nothing. */
#pragma once
#include <petscsys.h>

PETSC_EXTERN PetscErrorCode SlipErrorSource(const char option[]); /* option at work, NULL when it is done */
PETSC_EXTERN PetscErrorCode
SlipErrorUnfinished(const char file[]); /* remove it on an error; NULL: keep it from now on */
