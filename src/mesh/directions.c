/* Functions for every kind of mesh: the directions of a cell, and the exchange of numbers of all cells. */
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

/* Computes how many cells each process has, and their first ones. count and start [processes] */
static PetscErrorCode Owned(const SlipFaultMesh *mesh, PetscMPIInt rank, PetscMPIInt count[], PetscMPIInt start[])
{
  PetscFunctionBegin;
  count[rank] = (PetscMPIInt)mesh->n;
  start[rank] = (PetscMPIInt)mesh->start;
  PetscCallMPI(MPI_Allgather(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, count, 1, MPI_INT, mesh->comm));
  PetscCallMPI(MPI_Allgather(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, start, 1, MPI_INT, mesh->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers the numbers local [n] of all processes' cells on the first one, or sends them from there, in the order of the
   grid or of the mesh's file, all [N], which others do not access. */
static PetscErrorCode Exchange(const SlipFaultMesh *mesh, PetscBool gather, PetscReal local[], PetscReal all[])
{
  PetscMPIInt size, rank, *count, *start;
  PetscReal *row;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(mesh->comm, &size));
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCall(PetscMalloc3(size, &count, size, &start, rank ? 0 : mesh->N, &row));
  PetscCall(Owned(mesh, rank, count, start));
  for (PetscInt e = 0; e < mesh->N && !gather && !rank; e++) row[e] = all[SlipFaultMeshRowOf(mesh, e)];
  if (gather)
    PetscCallMPI(MPI_Gatherv(local, count[rank], MPIU_REAL, row, count, start, MPIU_REAL, 0, mesh->comm));
  else
    PetscCallMPI(MPI_Scatterv(row, count, start, MPIU_REAL, local, count[rank], MPIU_REAL, 0, mesh->comm));
  for (PetscInt e = 0; e < mesh->N && gather && !rank; e++) all[SlipFaultMeshRowOf(mesh, e)] = row[e];
  PetscCall(PetscFree3(count, start, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultGatherFirst(const SlipFaultMesh *mesh, const PetscReal local[], PetscReal all[])
{
  PetscFunctionBegin;
  PetscCall(Exchange(mesh, PETSC_TRUE, (PetscReal *)local, all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultScatterFirst(const SlipFaultMesh *mesh, const PetscReal all[], PetscReal local[])
{
  PetscFunctionBegin;
  PetscCall(Exchange(mesh, PETSC_FALSE, local, (PetscReal *)all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultGatherAll(const SlipFaultMesh *mesh, const PetscReal local[], PetscReal all[])
{
  PetscFunctionBegin;
  PetscCall(SlipFaultGatherFirst(mesh, local, all));
  PetscCallMPI(MPI_Bcast(all, (PetscMPIInt)mesh->N, MPIU_REAL, 0, mesh->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
