/* Numbers and decisions of the semismooth Newton method, for the SNES type and for the trainer's loop on arrays: when
   a step is taken, shortened, lengthened or replaced by projections, and when the solution is as exact as rounding
   lets it be. */
#include <slipcompat.h>
#include <slipcore.h>

/* All remembered merits are this one */
void SlipSearchForget(SlipSearch *search, PetscReal merit)
{
  for (PetscInt i = 0; i < SLIP_SEARCH_MEMORY; i++) search->recent[i] = merit;
}

void SlipSearchRemember(SlipSearch *search, PetscInt it, PetscReal merit)
{
  search->recent[it % SLIP_SEARCH_MEMORY] = merit;
}

/* The step lambda dx is taken when it is no worse than the worst of the recent ones */
PetscBool SlipSearchAccepts(const SlipSearch *search, PetscReal lambda, PetscReal merit)
{
  PetscReal limit = 0.0;

  for (PetscInt i = 0; i < SLIP_SEARCH_MEMORY; i++) limit = PetscMax(limit, search->recent[i]);
  return merit < (1.0 - 1e-4 * lambda) * limit ? PETSC_TRUE : PETSC_FALSE;
}

/* Does the full step lower the merit so much that the one that turns no cell round (SlipConeStopTurning()) need not be
   tried? Sliding that comes to rest seldom goes the other way at once, and sets of cells that turn round together in
   one step and back in the next shrink by a few cells in each. */
PetscBool SlipSearchSuffices(PetscReal last, PetscReal merit)
{
  return merit <= 0.1 * last ? PETSC_TRUE : PETSC_FALSE;
}

/* Count the steps in a row that stalled: against cycling sliding sets projections help, which cannot cycle for small
   slopes of the bound */
PetscBool SlipSearchStuck(SlipSearch *search, PetscBool stalled, PetscReal merit)
{
  search->stalls = stalled ? search->stalls + 1 : 0;
  return search->stalls >= 3 && !PetscIsInfOrNanReal(merit) ? PETSC_TRUE : PETSC_FALSE;
}

/* A step without the slope of the bound is doubled while the balance of the sliding cells along it, negative, still
   pushes the same way, else an instability that has hardly begun would take hundreds of steps to grow. Of the last two
   points the better balanced one is kept: is that the shorter? */
PetscBool SlipSearchOvershoots(PetscReal last_push, PetscReal push)
{
  return push > -last_push ? PETSC_TRUE : PETSC_FALSE;
}

/* Newton steps beyond the tolerance end when the residual no longer halves, or when the step is rounding */
PetscBool SlipSearchPolished(PetscReal last, PetscReal norm, PetscReal step, PetscReal size)
{
  return norm > 0.5 * last || step <= 1e-11 * size ? PETSC_TRUE : PETSC_FALSE;
}
