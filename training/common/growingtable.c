/* Tables of rows, see table.h. */
#include "table.h"
#include <slipcompat.h>

PetscErrorCode TableAdd(Table *t, const PetscReal row[])
{
  PetscFunctionBegin;
  if (t->n == t->capacity) {
    t->capacity = t->capacity ? 2 * t->capacity : 256;
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(t->capacity * t->width), &t->data));
  }
  PetscCall(PetscArraycpy(&t->data[t->n++ * t->width], row, t->width));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TableClear(Table *t)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(t->data));
  t->n = t->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
