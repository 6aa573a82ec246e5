/* What several observers need of the end of a step: who asks first has it computed, the others get the same. What is
   known is known of a state under the load of a time (SlipFaultMoment). Sums over the cells are in faultobserve.c. */
#include <slipstep/private/slipfault.h>

/* Collective. The traction is the static one of the state, which the next step starts from: where a cell has just come
   to rest it does not contain the impulse that stopped it. Weighted by area. */
PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r)
{
  PetscFunctionBegin;
  PetscCheck(fault->friction.law->always_slides || fault->stage.con || fault->problem.any_integrator, fault->comm,
             PETSC_ERR_ORDER, "the traction is known after SlipFaultConfigureTS()");
  if (fault->friction.law->always_slides)
    PetscCall(SlipFaultSmoothTraction(fault, time, w, r));
  else if (fault->problem.any_integrator)
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

/* Largest |v| [m/s] */
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
