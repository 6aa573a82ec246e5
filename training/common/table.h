/* A growing table of rows. */
#pragma once
#include <petscsys.h>
#include <slipcompat.h>

typedef struct {
  PetscInt width, n, capacity;
  PetscReal *data; /* [n][width] */
} Table;

static inline PetscErrorCode TableAdd(Table *t, const PetscReal row[])
{
  PetscFunctionBegin;
  if (t->n == t->capacity) {
    t->capacity = t->capacity ? 2 * t->capacity : 256;
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(t->capacity * t->width), &t->data));
  }
  PetscCall(PetscArraycpy(&t->data[t->n++ * t->width], row, t->width));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the rows, keeps the width. */
static inline PetscErrorCode TableClear(Table *t)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(t->data));
  t->n = t->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
