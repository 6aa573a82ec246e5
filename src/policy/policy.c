/* SlipPolicy, a small network that maps an observation to a step size: creation, destruction, hash and view */
#include <slipstep/private/slippolicy.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipsys.h>

/*@
  SlipPolicyCreate - creates an empty policy

  Collective

  Input Parameter:
. comm - the communicator; every rank stores the same numbers

  Output Parameter:
. policy - the new object

  Level: beginner

.seealso: SlipPolicyLoad(), SlipPolicySetObservations(), SlipPolicyDestroy()
@*/
PetscErrorCode SlipPolicyCreate(MPI_Comm comm, SlipPolicy *policy)
{
  PetscFunctionBegin;
  PetscAssertPointer(policy, 2);
  *policy = NULL;
  PetscCall(SlipPolicyInitializePackage());
  PetscCall(PetscHeaderCreate(*policy, SLIP_POLICY_CLASSID, "SlipPolicy", "Step-size policy", "TS", comm,
                              SlipPolicyDestroy, SlipPolicyView));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipPolicyClear_Private(SlipPolicy p)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n; i++) PetscCall(PetscFree(p->names[i]));
  for (PetscInt l = 0; l < p->nlayers; l++) PetscCall(PetscFree2(p->layers[l].weight, p->layers[l].bias));
  for (PetscInt i = 0; i < 2 * p->nattributes; i++) PetscCall(PetscFree(p->attributes[i]));
  PetscCall(PetscFree(p->names));
  PetscCall(PetscFree2(p->scale, p->offset));
  p->factor = 0;
  PetscCall(PetscFree(p->range));
  PetscCall(PetscFree(p->layers));
  PetscCall(PetscFree(p->attributes));
  PetscCall(PetscFree(p->file));
  PetscCall(PetscFree(p->work));
  p->n = p->nlayers = p->nattributes = p->width = 0;
  p->has_action = PETSC_FALSE;
  p->hash[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipPolicyDestroy - removes a reference to a policy, which is freed with the last one

  Collective

  Input Parameter:
. policy - the object, set to `NULL`

  Level: beginner

.seealso: SlipPolicyCreate(), SlipPolicyReference()
@*/
PetscErrorCode SlipPolicyDestroy(SlipPolicy *policy)
{
  PetscFunctionBegin;
  if (!*policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscValidHeaderSpecific(*policy, SLIP_POLICY_CLASSID, 1);
  if (--((PetscObject)*policy)->refct > 0) {
    *policy = NULL;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipPolicyClear_Private(*policy));
  PetscCall(PetscHeaderDestroy(policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a reference to a policy. */
PetscErrorCode SlipPolicyReference(SlipPolicy policy)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(policy, SLIP_POLICY_CLASSID, 1);
  PetscCall(PetscObjectReference((PetscObject)policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets a hash of the policy's content, which identifies it in outputs. hash: 16 hexadecimal digits (FNV-1a, 64 bit),
   borrowed; the same for a policy in memory and loaded from its file. */
PetscErrorCode SlipPolicyGetHash(SlipPolicy p, const char *hash[])
{
  size_t n;
  char *bytes;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  if (!p->hash[0]) {
    PetscCall(SlipPolicyPack_Private(p, &n, &bytes));
    PetscCall(
      PetscSNPrintf(p->hash, sizeof(p->hash), "%016llx", (unsigned long long)SlipHashBytes(SLIP_HASH_START, bytes, n)));
    PetscCall(PetscFree(bytes));
  }
  *hash = p->hash;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipPolicyView - prints a policy

  Collective

  Input Parameters:
+ p      - the policy
- viewer - an ASCII viewer, `NULL` for standard output

  Level: beginner

.seealso: SlipPolicyLoad()
@*/
PetscErrorCode SlipPolicyView(SlipPolicy p, PetscViewer viewer)
{
  const char *hash;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(p, SLIP_POLICY_CLASSID, 1);
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(PetscObjectComm((PetscObject)p), &viewer));
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetHash(p, &hash));
  PetscCall(PetscViewerASCIIPrintf(viewer, "policy: %s, hash %s\n", SlipPolicySource_Private(p), hash));
  PetscCall(PetscViewerASCIIPushTab(viewer));
  for (PetscInt i = 0; i < p->nattributes; i++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s: %s\n", p->attributes[2 * i], p->attributes[2 * i + 1]));
  for (PetscInt i = 0; i < p->n; i++) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "observes %s, scale %g, offset %g", p->names[i], (double)p->scale[i],
                                     (double)p->offset[i]));
    PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_FALSE));
    if (p->range)
      PetscCall(
        PetscViewerASCIIPrintf(viewer, ", in [%g, %g] in training", (double)p->range[i], (double)p->range[p->n + i]));
    PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
    PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_TRUE));
  }
  for (PetscInt l = 0; l < p->nlayers; l++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "layer %" PetscInt_FMT ": %" PetscInt_FMT " to %" PetscInt_FMT ", %s\n", l,
                                     p->layers[l].in, p->layers[l].out, SlipActivations[p->layers[l].activation]));
  if (p->has_action)
    PetscCall(PetscViewerASCIIPrintf(viewer, "step from %g %s to %g %s, %s spacing\n", (double)p->dt[0],
                                     SlipStepUnits[p->dt_unit[0]], (double)p->dt[1], SlipStepUnits[p->dt_unit[1]],
                                     p->log_spacing ? "logarithmic" : "linear"));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
