/* Whether a state has changed since results were computed of it and cached. */
#include <slipstep/private/slipfault.h>

/* now: everything that results of the state w depend on; *same: it equals `known`, of the cached results */
PetscErrorCode SlipFaultStateUnchanged(SlipFault fault, PetscReal t, Vec w, const SlipFaultMoment *known,
                                       SlipFaultMoment *now, PetscBool *same)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)w, &now->id));
  PetscCall(PetscObjectStateGet((PetscObject)w, &now->state));
  now->time = SlipLoadsVary(&fault->loads) ? t : 0;
  now->rates = fault->balance.put;
  *same = now->id == known->id && now->state == known->state && now->time == known->time && now->rates == known->rates
            ? PETSC_TRUE
            : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Was this the displacement of the last right-hand side, bit by bit, and its time where the medium asks for that?
   Collective. */
PetscErrorCode SlipFaultDisplacementUnchanged(SlipFault fault, PetscReal t, Vec u, PetscBool *same)
{
  const PetscReal *a, *b;
  PetscBool here, rests;

  PetscFunctionBegin;
  *same = PETSC_FALSE;
  PetscCall(SlipElasticRests(fault->medium, &rests));
  if (!fault->balance.known || (!rests && fault->balance.time != t)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(u, &a));
  PetscCall(VecGetArrayRead(fault->balance.u, &b));
  PetscCall(PetscArraycmp(a, b, fault->layout.components * fault->mesh.n, &here));
  PetscCall(VecRestoreArrayRead(fault->balance.u, &b));
  PetscCall(VecRestoreArrayRead(u, &a));
  PetscCallMPI(MPI_Allreduce(&here, same, 1, MPIU_BOOL, MPI_LAND, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
