/* Largest numbers over the processes. MPI defines no order for NaN: MPI_MAX may drop it, or give processes different
   results, which would then take different branches. */
#include <slipstep/private/slipsys.h>

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
