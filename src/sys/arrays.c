/* Access to the arrays of several vectors at once */
#include <slipstep/private/slipsys.h>

static PetscErrorCode SlipArraysEach(PetscInt n, const SlipArrays list[],
                                     PetscErrorCode (*reading)(Vec, const PetscScalar **),
                                     PetscErrorCode (*writing)(Vec, PetscScalar **))
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    if (!list[i].vec) continue;
    if (list[i].read) PetscCall((*reading)(list[i].vec, list[i].read));
    if (list[i].write) PetscCall((*writing)(list[i].vec, list[i].write));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipArraysGet(PetscInt n, const SlipArrays list[])
{
  return SlipArraysEach(n, list, VecGetArrayRead, VecGetArray);
}

PetscErrorCode SlipArraysRestore(PetscInt n, const SlipArrays list[])
{
  return SlipArraysEach(n, list, VecRestoreArrayRead, VecRestoreArray);
}
