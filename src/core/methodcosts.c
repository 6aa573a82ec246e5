/* Explicit or implicit steps: which of them go a way for fewer products. Counts alone decide, no times, so that results
   do not depend on chance. */
#include <slipcompat.h>
#include <slipcore.h>

/* Share of the last attempt in what attempts take */
#define NEW (PetscReal)0.25

/* Costs before the first attempts, as far as nothing is known of them */
void SlipMethodSetUp(SlipMethodCosts *costs)
{
  costs->step = 2; /* one with K, one with H */
  costs->solve = 1;
}

/*
  What an implicit solve over x explicit steps takes in the mean: products and applications of the preconditioner.

  Measured on the 3 km fault of 24 x 24 and 50 x 50 cells with a spectral H, at x of 2.8 and 3.9: 11.6 and 11.7.
  Newton's iterations do not depend on x much, and those of CG go with the root of the condition number of M/theta +
  H + theta K, as x does. An exact H, which is made of products with K, makes both methods dearer. What solves have
  taken replaces this, SlipMethodLearn().
*/
PetscReal SlipMethodSolve(const SlipMethodCosts *costs, PetscReal x)
{
  return costs->solve * (PetscReal)0.25 * (costs->step + 2) * (8 + (PetscReal)2.2 * PetscSqrtReal(x));
}

/* Are explicit steps the cheaper way to go h [s]? limit: the longest of them [s], 0 where there are none. switched: the
   last was implicit, so that the first takes as much again. */
PetscBool SlipMethodIsExplicit(const SlipMethodCosts *costs, PetscReal h, PetscReal limit, PetscBool switched)
{
  const PetscReal x = limit > 0 ? h / limit : 0;

  if (!(limit > 0)) return PETSC_FALSE;
  return (PetscMax(PetscCeilReal(x), 1) + (switched ? 1 : 0)) * costs->step <= SlipMethodSolve(costs, x) ? PETSC_TRUE
                                                                                                         : PETSC_FALSE;
}

/* An attempt at h took so many products, those with the preconditioner included. The first solve says more than
   what was measured elsewhere: on irregular meshes, whose stages have no such preconditioner, it takes three to eight
   times as many. */
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
