/* See plainpolicy.h. */
#include "plainpolicy.h"
#include <slipcompat.h>

PetscErrorCode PlainPolicyStart(SlipPolicy policy, SlipModel model, PlainPolicy *p, PetscBool *known)
{
  const char *const *names;

  PetscFunctionBegin;
  p->policy = policy;
  p->model = model;
  p->run = (SlipRunNumbers){.started = PETSC_FALSE};
  PetscCall(SlipPolicyGetObservations(policy, &p->n, &names));
  PetscCheck(p->n <= PLAIN_MAX_ROWS, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ,
             "A policy with %" PetscInt_FMT " observations, expected %d at most", p->n, PLAIN_MAX_ROWS);
  *known = PETSC_TRUE;
  for (PetscInt i = 0; i < p->n; ++i) {
    SlipObserved *seen = &p->seen[i];

    SlipObservedSet(seen, names[i]);
    if (!model)
      seen->own = seen->row && seen->row->fault ? 0 : -1;
    else if (SlipObservedOfState(seen))
      seen->own = SlipModelFindObservation(model, seen->name + seen->change);
    if (seen->own < 0 && !SlipObservedOfRun(seen)) *known = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainPolicyRun(PlainPolicy *p, PetscReal accuracy, PetscReal tstar, PetscReal max_time)
{
  SlipRunNumbers *o = &p->run;

  PetscFunctionBegin;
  *o = (SlipRunNumbers){.accuracy = accuracy, .tstar = tstar, .max_time = max_time};
  PetscCall(SlipPolicyGetStepBounds(p->policy, tstar, max_time, &o->dt_min, &o->dt_max));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void PlainPolicyObserve(PlainPolicy *p, const SlipFaultNumbers *fault, const PetscReal w[], PetscBool changed)
{
  for (PetscInt i = 0; i < p->n; ++i) {
    SlipObserved *seen = &p->seen[i];
    const SlipModelObservation *own = p->model && seen->own >= 0 ? &p->model->ops->observations[seen->own] : NULL;

    if (changed || !SlipObservedOfState(seen))
      SlipObservedTake(seen, own              ? (*own->value)(p->model, p->run.time, w, own->k)
                             : seen->own >= 0 ? (*seen->row->fault)(fault)
                                              : (*seen->row->run)(&p->run));
    p->obs[i] = seen->value;
  }
}
