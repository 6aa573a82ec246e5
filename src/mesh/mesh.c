/* The mesh of a fault: this file chooses its kind, distributes it, and computes the weights of its cells. */
#include <slipstep/private/slipmesh.h>
#include <slipstep/private/slipmatcells.h>
#include <string.h>

PetscErrorCode SlipFaultMeshCreate(const SlipFaultMeshOptions *o, SlipFaultMesh *mesh)
{
  SlipFaultMeshFile file = {.n = 0};
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank, size;

  PetscFunctionBegin;
  if (o->file[0]) {
    PetscCallMPI(MPI_Comm_rank(o->comm, &rank));
    if (!rank) ierr = SlipFaultMeshRead(o, &file);
    PetscCall(SlipErrorBcast(o->comm, ierr));
    PetscCallMPI(MPI_Bcast(&file.triangles, 1, MPIU_BOOL, 0, o->comm));
  }
  mesh->comm = o->comm;
  PetscCall(SlipSharedCreate(o->comm, &mesh->shared));
  mesh->kind = !o->file[0] ? &SlipFaultMeshGrid : file.triangles ? &SlipFaultMeshTriangles : &SlipFaultMeshList;
  PetscCall(mesh->kind->create(mesh, o, &file));
  mesh->names = file.names;
  file.names = NULL;
  PetscCall(SlipFaultMeshFileDestroy(&file));
  PetscCall(SlipFaultMeshFaults(mesh, o));
  PetscCallMPI(MPI_Comm_size(o->comm, &size));
  PetscCheck(size <= mesh->N, o->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%d processes for %" PetscInt_FMT " cells (-%sfault_nx times -%sfault_nz): expected at most one process "
             "per cell",
             (int)size, mesh->N, o->prefix, o->prefix);
  PetscCall(PetscSplitOwnership(o->comm, &mesh->n, &mesh->N));
  mesh->start = 0;
  PetscCallMPI(MPI_Exscan(&mesh->n, &mesh->start, 1, MPIU_INT, MPI_SUM, o->comm));
  PetscCall(PetscMalloc1(PetscMax(mesh->n, 1), &mesh->weight));
  for (PetscInt i = 0; i < mesh->n; i++) {
    SlipFaultCell cell;

    mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), &cell);
    mesh->weight[i] = mesh->unit > 0 ? cell.size[0] * cell.size[1] * mesh->unit : 1;
  }
  if (o->file[0]) SlipMemoryReturn();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshDestroy(SlipFaultMesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(mesh->weight));
  PetscCall(PetscFree(mesh->names));
  PetscCall(PetscFree(mesh->labels));
  PetscCall(SlipSharedDestroy(&mesh->shared));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the scatter of vectors like x, with one or more numbers per cell, to rank 0 in the order of rows. */
PetscErrorCode SlipFaultGatherCreate(const SlipFaultMesh *mesh, Vec x, VecScatter *scatter, Vec *x0)
{
  PetscMPIInt rank;
  PetscInt size, block, n, *cell;
  IS from;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCall(VecGetSize(x, &size));
  block = size / mesh->N;
  n = rank ? 0 : mesh->N;
  PetscCall(PetscMalloc1(n, &cell));
  for (PetscInt e = 0; e < n; e++) cell[SlipFaultMeshRowOf(mesh, e)] = e;
  PetscCall(ISCreateBlock(mesh->comm, block, n, cell, PETSC_OWN_POINTER, &from));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n * block, x0));
  PetscCall(VecScatterCreate(x, from, *x0, NULL, scatter));
  PetscCall(ISDestroy(&from));
  PetscFunctionReturn(PETSC_SUCCESS);
}
