/*
  Products H x that cost the more the more digits they are to have, for a solver's iterates x, which differ less and less:
  H x = H x0 + H (x - x0) needs few digits of the increment, since the error that may be left is relative to H x. Errors
  add up, so after SLIP_INCREMENTS such products H x is computed from scratch. The same x again is free.
*/
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

#define SLIP_INCREMENTS 8 /* each may leave 1 / SLIP_INCREMENTS of the tolerance */

PetscErrorCode SlipIncrementReset(SlipIncrement *c)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&c->x));
  PetscCall(VecDestroy(&c->y));
  PetscCall(VecDestroy(&c->dx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether the last product helps for an x of this size; *change is |x - x0|, dx = x - x0. */
static PetscErrorCode NearLast(SlipIncrement *c, Vec x, PetscReal size, PetscBool *near, PetscReal *change)
{
  PetscFunctionBegin;
  *near = PETSC_FALSE;
  if (!c->x) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecWAXPY(c->dx, -1, c->x, x));
  PetscCall(VecNorm(c->dx, NORM_2, change));
  *near = (PetscBool)(*change == 0 || (*change < 0.5 * size && c->count < SLIP_INCREMENTS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y = H x with an error of tolerance |H x|. Collective. */
PetscErrorCode SlipIncrementMult(SlipIncrement *c, PetscReal tolerance, SlipProductFn product, void *ctx, Vec x, Vec y)
{
  PetscReal change = 0, size;
  PetscBool near;

  PetscFunctionBegin;
  PetscCall(VecNorm(x, NORM_2, &size));
  if (size == 0) { /* as solvers ask for at their start: forgets nothing */
    PetscCall(VecZeroEntries(y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(NearLast(c, x, size, &near, &change));
  if (near && change > 0) {
    PetscCall((*product)(ctx, c->dx, tolerance * c->size / SLIP_INCREMENTS, y));
    PetscCall(VecAXPY(c->y, 1, y));
    PetscCall(VecCopy(x, c->x));
    c->count++;
  }
  if (!near) {
    if (!c->x) {
      PetscCall(VecDuplicate(x, &c->x));
      PetscCall(VecDuplicate(x, &c->y));
      PetscCall(VecDuplicate(x, &c->dx));
    }
    PetscCall((*product)(ctx, x, 0, c->y));
    PetscCall(VecCopy(x, c->x));
    PetscCall(VecNorm(c->y, NORM_2, &c->size));
    c->count = 0;
  }
  PetscCall(VecCopy(c->y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
