/* Caches values at the end of a step that several observers need, so that only the first of them computes. A value is
   valid for one state under the load of one time (SlipFaultMoment). faultobserve.c computes sums over the cells. */
#include <slipstep/private/slipfault.h>

/* Computes the static traction of the state, which the next step starts from, weighted by area. Where a cell has just
   come to rest it does not contain the impulse that stopped it. Collective. */
PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r)
{
  PetscFunctionBegin;
  PetscCheck(fault->friction.law->always_slides || fault->stage.con || fault->problem.steps.any_integrator, fault->comm,
             PETSC_ERR_ORDER, "the traction is known after SlipFaultConfigureTS()");
  if (fault->friction.law->always_slides)
    PetscCall(SlipFaultSmoothTraction(fault, time, w, r));
  else if (fault->problem.steps.any_integrator)
    PetscCall(SlipFaultStickingTraction(fault, time, w, r));
  else
    PetscCall(SlipConstraintInitialReaction(fault->stage.con, time, w, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStepTraction(SlipFault fault, PetscReal time, Vec w, Vec *traction)
{
  SlipFaultStepValues *known = &fault->known.step;
  SlipFaultMoment now;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipFaultStateUnchanged(fault, time, w, &known->traction_moment, &now, &same));
  if (!known->traction) PetscCall(VecDuplicate(fault->critical.uc, &known->traction));
  *traction = known->traction;
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultTraction(fault, time, w, known->traction));
  known->traction_moment = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the largest |v| [m/s]. */
PetscErrorCode SlipFaultStepRate(SlipFault fault, PetscReal time, Vec w, PetscReal *largest)
{
  SlipFaultStepValues *known = &fault->known.step;
  SlipFaultMoment now;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipFaultStateUnchanged(fault, time, w, &known->rate_moment, &now, &same));
  if (!same) PetscCall(SlipFaultLargestSpeed(fault, w, &known->rate));
  known->rate_moment = now;
  *largest = known->rate;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStepValuesDestroy(SlipFault fault)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&fault->known.step.traction));
  fault->known.step = (SlipFaultStepValues){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}
