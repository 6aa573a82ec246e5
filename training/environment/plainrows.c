/* See plainrows.h. */
#include "plainrows.h"
#include <slipcompat.h>

PetscErrorCode PlainRowsFind(SlipPolicy policy, SlipModel model, PetscInt *n, SlipObserved row[], PetscBool *known)
{
  const char *const *names;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetObservations(policy, n, &names));
  *known = *n <= PLAIN_MAX_ROWS ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < *n && *known; ++i) {
    SlipObserved *seen = &row[i];

    SlipObservedSet(seen, names[i]);
    if (!model)
      seen->own = seen->row && seen->row->fault ? 0 : -1;
    else if (SlipObservedOfState(seen))
      seen->own = SlipModelFindObservation(model, seen->name + seen->change);
    *known = seen->own >= 0 || SlipObservedOfRun(seen) ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
