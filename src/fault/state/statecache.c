/* Finds whether a state has changed since results were computed from it and cached. */
#include <slipstep/private/slipfault.h>

/* Sets now to everything that results of the state w depend on; *same: it equals `known`, that of the cached results.
   */
PetscErrorCode SlipFaultStateUnchanged(SlipFault fault, PetscReal t, Vec w, const SlipFaultMoment *known,
                                       SlipFaultMoment *now, PetscBool *same)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)w, &now->id));
  PetscCall(PetscObjectStateGet((PetscObject)w, &now->state));
  now->time = SlipLoadsVary(&fault->loads) || fault->zone.presses ? fault->loads.origin + t : 0;
  now->rates = fault->balance.put;
  *same = now->id == known->id && now->state == known->state && now->time == known->time && now->rates == known->rates
            ? PETSC_TRUE
            : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether u is bit by bit the displacement of the last right-hand side, at the same time where the medium depends
   on it. Collective. */
PetscErrorCode SlipFaultDisplacementUnchanged(SlipFault fault, PetscReal t, Vec u, PetscBool *same)
{
  PetscBool here, rests;

  PetscFunctionBegin;
  *same = PETSC_FALSE;
  PetscCall(SlipElasticRests(fault->medium, &rests));
  if (!fault->balance.known || (!rests && fault->balance.time != t)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipVecSame(u, fault->balance.u, &here));
  PetscCallMPI(MPI_Allreduce(&here, same, 1, MPIU_BOOL, MPI_LAND, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets u of w and f(u, t), which is cached where u is exactly that of the last right-hand side. Collective. */
PetscErrorCode SlipFaultForce(SlipFault fault, PetscReal t, Vec w, Vec u, Vec force)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  PetscCall(SlipFaultDisplacementUnchanged(fault, t, u, &same));
  if (same)
    PetscCall(VecCopy(fault->balance.force, force));
  else
    PetscCall(SlipElasticForce(fault->medium, t, u, NULL, force, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets (df/dv) v_rel, which is cached where the rate is exactly that of a node of the last step. Collective. */
PetscErrorCode SlipFaultDamping(SlipFault fault, PetscReal t, Vec relative, Vec damping)
{
  const SlipFaultSettled *s = &fault->settled;

  PetscFunctionBegin;
  for (int node = 0; node < SLIP_NUM_NODES; node++) {
    PetscBool here, same;

    if (!s->known[node]) continue;
    PetscCall(SlipVecSame(relative, s->rate[node], &here));
    PetscCallMPI(MPI_Allreduce(&here, &same, 1, MPIU_BOOL, MPI_LAND, fault->comm));
    if (!same) continue;
    PetscCall(VecCopy(s->damping[node], damping));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipElasticForce(fault->medium, t, NULL, relative, damping, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultSettledDestroy(SlipFault fault)
{
  PetscFunctionBegin;
  for (int node = 0; node < SLIP_NUM_NODES; node++) {
    PetscCall(VecDestroy(&fault->settled.rate[node]));
    PetscCall(VecDestroy(&fault->settled.damping[node]));
    fault->settled.known[node] = PETSC_FALSE;
  }
  PetscCall(VecDestroy(&fault->settled.force));
  PetscCall(VecDestroy(&fault->settled.rise));
  fault->settled.forced = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
