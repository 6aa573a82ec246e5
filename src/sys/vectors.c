/* Arrays of several vectors at once, and largest numbers over the processes */
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

/* MPI defines no order for NaN: MPI_MAX may drop it, or give processes different results, which would then take
   different branches. */
enum { MOST = 16 };

/*
  SlipAllreduceLargest - computes the largest of each of n numbers over the processes, or NaN if any process has NaN

  Collective. x [n], n at most 16
*/
PetscErrorCode SlipAllreduceLargest(MPI_Comm comm, PetscInt n, PetscReal x[])
{
  PetscReal all[2 * MOST]; /* followed by a 1 for each NaN */

  PetscFunctionBegin;
  PetscCheck(n <= MOST, comm, PETSC_ERR_PLIB, "%" PetscInt_FMT " numbers, expected at most %d", n, MOST);
  for (PetscInt k = 0; k < n; k++) {
    all[n + k] = PetscIsNanReal(x[k]) ? 1 : 0;
    all[k] = PetscIsNanReal(x[k]) ? 0 : x[k];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, (PetscMPIInt)(2 * n), MPIU_REAL, MPIU_MAX, comm));
  for (PetscInt k = 0; k < n; k++) x[k] = all[n + k] > 0 ? (PetscReal)NAN : all[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipVecLargest - computes the largest |x_i|, or NaN if an entry on any process is NaN

  Collective
*/
PetscErrorCode SlipVecLargest(Vec x, PetscReal *largest)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)x);
  const PetscScalar *a;
  PetscMPIInt size;
  PetscInt n;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size == 1) { /* computed where the vector is stored, which may be on a device */
    PetscCall(VecNorm(x, NORM_INFINITY, largest));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *largest = 0;
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < n; i++) *largest = SlipLarger(*largest, PetscAbsScalar(a[i]));
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCall(SlipAllreduceLargest(comm, 1, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
