/* The mesh of a fault: the choice of its kind, its distribution, and the weights of its cells. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>

PetscErrorCode SlipFaultMeshSetUp(SlipFault fault)
{
  SlipFaultMesh *mesh = &fault->mesh;
  const char *prefix = SlipFaultPrefix(fault);
  PetscMPIInt size;

  PetscFunctionBegin;
  mesh->kind = fault->options.text[FAULT_MESH][0] ? &SlipFaultMeshList : &SlipFaultMeshGrid;
  PetscCall(mesh->kind->create(fault));
  PetscCall(SlipFaultMeshFaults(fault));
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCheck(size <= mesh->N, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%d processes for %" PetscInt_FMT " cells (-%sfault_nx times -%sfault_nz): expected at most one process "
             "per cell",
             (int)size, mesh->N, prefix, prefix);
  PetscCall(PetscSplitOwnership(fault->comm, &mesh->n, &mesh->N));
  mesh->start = 0;
  PetscCallMPI(MPI_Exscan(&mesh->n, &mesh->start, 1, MPIU_INT, MPI_SUM, fault->comm));
  PetscCall(PetscMalloc1(PetscMax(mesh->n, 1), &mesh->weight));
  for (PetscInt i = 0; i < mesh->n; i++) {
    SlipFaultCell cell;

    mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), &cell);
    mesh->weight[i] = mesh->unit > 0 ? cell.size[0] * cell.size[1] * mesh->unit : 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshDestroy(SlipFaultMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(mesh->weight));
  PetscCall(PetscFree(mesh->order));
  PetscCall(PetscFree(mesh->plane));
  PetscCall(PetscFree(mesh->label));
  PetscCall(PetscFree(mesh->labels));
  PetscCall(PetscFree(mesh->fault));
  PetscCall(SlipCellsDestroy(&mesh->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sum of the weighted values of a reduced vector, collective. */
PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum)
{
  const PetscReal *a;

  PetscFunctionBegin;
  *sum = 0;
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) *sum += fault->mesh.weight[i] * a[i];
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For gathering vectors like x, one or more numbers for each cell, on rank 0 by rows. */
PetscErrorCode SlipFaultGatherCreate(SlipFault fault, Vec x, VecScatter *scatter, Vec *x0)
{
  PetscMPIInt rank;
  PetscInt size, block, n, *cell;
  IS from;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(VecGetSize(x, &size));
  block = size / fault->mesh.N;
  n = rank ? 0 : fault->mesh.N;
  PetscCall(PetscMalloc1(n, &cell));
  for (PetscInt e = 0; e < n; e++) cell[SlipFaultMeshRowOf(&fault->mesh, e)] = e;
  PetscCall(ISCreateBlock(fault->comm, block, n, cell, PETSC_OWN_POINTER, &from));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n * block, x0));
  PetscCall(VecScatterCreate(x, from, *x0, NULL, scatter));
  PetscCall(ISDestroy(&from));
  PetscFunctionReturn(PETSC_SUCCESS);
}
