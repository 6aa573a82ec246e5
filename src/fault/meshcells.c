/* What every kind of mesh asks for: the directions of a cell, and numbers of all cells on every process. */
#include <slipstep/private/slipfault.h>

void SlipFaultCellDirections(PetscReal strike, PetscReal dip, SlipFaultCell *cell)
{
  PetscReal d[9];

  SlipPlaneDirections(strike, dip, 0, d);
  for (int k = 0; k < 3; k++) {
    cell->direction[0][k] = d[k];
    cell->direction[1][k] = 0 - d[3 + k];
    cell->direction[2][k] = d[6 + k];
  }
}

/* Numbers of this process' cells, local [n], as those of all cells, on every process, in the order of the grid or of the
   mesh's file. Collective. */
PetscErrorCode SlipFaultGatherAll(SlipFault fault, const PetscReal local[], PetscReal all[])
{
  PetscMPIInt size, rank, *count, *start;
  PetscReal *row;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(PetscMalloc3(size, &count, size, &start, fault->mesh.N, &row));
  count[rank] = (PetscMPIInt)fault->mesh.n;
  start[rank] = (PetscMPIInt)fault->mesh.start;
  PetscCallMPI(MPI_Allgather(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, count, 1, MPI_INT, fault->comm));
  PetscCallMPI(MPI_Allgather(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, start, 1, MPI_INT, fault->comm));
  PetscCallMPI(MPI_Allgatherv(local, count[rank], MPIU_REAL, row, count, start, MPIU_REAL, fault->comm));
  for (PetscInt e = 0; e < fault->mesh.N; e++) all[SlipFaultMeshRowOf(&fault->mesh, e)] = row[e];
  PetscCall(PetscFree3(count, start, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
