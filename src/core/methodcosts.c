/* Chooses explicit or implicit steps by the number of products that they take over the same time. Only counts decide,
   not measured times, so that results are reproducible. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

/* Weight of the last attempt in the moving means */
#define NEW (PetscReal)0.25

/* Costs before the first attempts */
void SlipMethodSetUp(SlipMethodCosts *costs)
{
  costs->step = 2; /* one with K, one with H */
  costs->solve = 1;
}

/*
  Mean cost of an implicit solve over x explicit steps: products and applications of the preconditioner.

  Measured on the 3 km fault of 24 x 24 and 50 x 50 cells with a spectral H, at x of 2.8 and 3.9: 11.6 and 11.7.
  Newton's iterations depend little on x, and those of CG scale with the root of the condition number of M/theta + H +
  theta K, as x does. An exact H, which consists of products with K, makes both methods costlier. SlipMethodLearn()
  replaces these numbers by those of the run.
*/
PetscReal SlipMethodSolve(const SlipMethodCosts *costs, PetscReal x)
{
  return costs->solve * (PetscReal)0.25 * (costs->step + 2) * (8 + (PetscReal)2.2 * PetscSqrtReal(x));
}

/* True if explicit steps cost less over h [s]. limit: the longest stable one [s], 0: there is none. switched: the last
   step was implicit, so that the first explicit one costs as much as two. */
PetscBool SlipMethodIsExplicit(const SlipMethodCosts *costs, PetscReal h, PetscReal limit, PetscBool switched)
{
  const PetscReal x = limit > 0 ? h / limit : 0;

  if (!(limit > 0)) return PETSC_FALSE;
  return (PetscMax(PetscCeilReal(x), 1) + (switched ? 1 : 0)) * costs->step <= SlipMethodSolve(costs, x) ? PETSC_TRUE
                                                                                                         : PETSC_FALSE;
}

/* An attempt at h took so many products, including those with the preconditioner. The first solve replaces the value
   above instead of being averaged: on irregular meshes, whose stages have no such preconditioner, a solve takes three
   to eight times as many. */
void SlipMethodLearn(SlipMethodCosts *costs, PetscBool is_explicit, PetscReal h, PetscReal limit, PetscReal products)
{
  SlipMethodCosts one = *costs;

  one.solve = 1;
  if (is_explicit)
    costs->step += NEW * (products - costs->step);
  else if (limit > 0)
    costs->solve +=
      (costs->solve == one.solve ? 1 : NEW) * (products / SlipMethodSolve(&one, h / limit) - costs->solve);
}
