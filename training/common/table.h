/* A growing table of rows. */
#pragma once
#include <petscsys.h>

typedef struct {
  PetscInt width, n, capacity;
  PetscReal *data; /* [n][width] */
} Table;

PETSC_INTERN PetscErrorCode TableAdd(Table *t, const PetscReal row[]);
PETSC_INTERN PetscErrorCode TableClear(Table *t); /* frees the rows, keeps the width */
