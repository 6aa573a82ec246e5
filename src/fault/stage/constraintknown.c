/* Passes to the medium the products with K that are known already at a stage's start and at its end, so that stages do
   not compute them again. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsnes.h>

/* SlipFaultStoreEnd() stores nothing at a step's end for a fault that is loaded or heals, and only the last product of
   the solve is cached. Output must not change the rounding of the next step. Its stages therefore always begin with
   sums of the products with the start, w, and with the loading, which are computed here. */
static PetscErrorCode KnowWhole(SlipFault fault, Vec w)
{
  Vec u, product;

  PetscFunctionBegin;
  PetscCall(SlipFaultRestSetUp(fault));
  if (fault->kind.loaded) PetscCall(SlipElasticStore(fault->medium, fault->operators.vinf, fault->loads.pull));
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &product));
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  PetscCall(SlipElasticApply(fault->medium, u, product, NULL));
  PetscCall(SlipFaultRestoreWork(fault, &product));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* K u0 follows from cached products, as u0 = base_u + theta (ex_u - v_inf) is a sum of slips and slip rates of the
   states that the stage starts from. */
PetscErrorCode SlipFaultStoreStart(SlipFault fault, const SlipStage *stage)
{
  const PetscBool explicit_part = stage->explicit_part ? PETSC_TRUE : PETSC_FALSE;
  PetscInt n = 0;
  PetscReal factor[4];
  Vec x[4], work[3];

  PetscFunctionBegin;
  if (!stage->nfrom || SlipFaultOpens(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  if (fault->kind.sequence) PetscCall(KnowWhole(fault, stage->from[0]));
  for (int k = 0; k < 3; k++) PetscCall(SlipFaultGetWork(fault, &work[k]));
  for (; n < stage->nfrom; n++) {
    PetscCall(SlipFaultGetDisplacement(fault, stage->from[n], work[n]));
    x[n] = work[n];
    factor[n] = stage->factor[n];
  }
  if (explicit_part) {
    PetscCall(SlipFaultGetRate(fault, stage->from[0], work[n]));
    x[n] = work[n];
    factor[n++] = stage->theta;
  }
  if (fault->kind.loaded) {
    x[n] = fault->operators.vinf;
    factor[n++] = explicit_part ? -2 * stage->theta : -stage->theta;
  }
  PetscCall(SlipElasticStoreSum(fault->medium, fault->stage.u0, n, factor, x));
  for (int k = 2; k >= 0; k--) PetscCall(SlipFaultRestoreWork(fault, &work[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores products of the solve: B x = g + c, and that of the end u = u0 + theta x. A fault that is loaded or heals
   stores none at a step's end, and its next step computes its own. Displacements of years lie behind the stress at
   which slip begins: with rounding that added up from step to step, one block had 113 events instead of 20. */
PetscErrorCode SlipFaultStoreEnd(SlipFault fault, Vec g, Vec x, Vec w)
{
  const PetscReal factor[] = {1, fault->stage.theta};
  const Vec of[] = {fault->stage.u0, x};
  Vec work;

  PetscFunctionBegin;
  if (fault->kind.sequence && fault->stage.last) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &work));
  PetscCall(VecWAXPY(work, 1, g, fault->stage.c));
  PetscCall(SlipElasticStoreStage(fault->medium, x, work));
  PetscCall(SlipFaultGetDisplacement(fault, w, work));
  PetscCall(SlipElasticStoreSum(fault->medium, work, 2, factor, of));
  PetscCall(SlipFaultRestoreWork(fault, &work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
