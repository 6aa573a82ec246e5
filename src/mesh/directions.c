/* Functions for every kind of mesh: the directions of a cell, and gathering numbers of all cells on every process. */
#include <slipstep/private/slipmesh.h>

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

/* Gathers the numbers local [n] of all processes' cells on every process, in the order of the grid or of the mesh's
   file. Collective. */
PetscErrorCode SlipFaultGatherAll(const SlipFaultMesh *mesh, const PetscReal local[], PetscReal all[])
{
  PetscMPIInt size, rank, *count, *start;
  PetscReal *row;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(mesh->comm, &size));
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCall(PetscMalloc3(size, &count, size, &start, mesh->N, &row));
  count[rank] = (PetscMPIInt)mesh->n;
  start[rank] = (PetscMPIInt)mesh->start;
  PetscCallMPI(MPI_Allgather(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, count, 1, MPI_INT, mesh->comm));
  PetscCallMPI(MPI_Allgather(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, start, 1, MPI_INT, mesh->comm));
  PetscCallMPI(MPI_Allgatherv(local, count[rank], MPIU_REAL, row, count, start, MPIU_REAL, mesh->comm));
  for (PetscInt e = 0; e < mesh->N; e++) all[SlipFaultMeshRowOf(mesh, e)] = row[e];
  PetscCall(PetscFree3(count, start, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
