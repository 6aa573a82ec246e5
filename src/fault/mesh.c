/* The mesh of a fault: the choice of its kind, its distribution, and the weights of its cells. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>
#include <string.h>

/* Rank 0 has what the file of -fault_mesh holds, and all know what kind of cells. */
static PetscErrorCode ReadFile(SlipFault fault, SlipFaultMeshFile *file)
{
  static const PetscInt ways[] = {FAULT_MESH_FRAME, FAULT_MESH_UNIT};
  const char *prefix = SlipFaultPrefix(fault);
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_MESH][0]) {
    for (int k = 0; k < 2; k++) {
      const char *text = fault->options.text[ways[k]];

      PetscCheck(!strcmp(text, "auto"), fault->comm, PETSC_ERR_ARG_INCOMP,
                 "-%sfault_%s %s is of the file of -%sfault_mesh, which is not given", prefix,
                 SlipFaultStrings[ways[k]].name, text, prefix);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(!fault->options.text[FAULT_STIFFNESS_FILE][0], fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_stiffness_file %s and -%sfault_mesh %s exclude each other", prefix,
             fault->options.text[FAULT_STIFFNESS_FILE], prefix, fault->options.text[FAULT_MESH]);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = SlipFaultMeshRead(fault, file);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&file->triangles, 1, MPIU_BOOL, 0, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultMeshSetUp(SlipFault fault)
{
  SlipFaultMesh *mesh = &fault->mesh;
  const char *prefix = SlipFaultPrefix(fault);
  SlipFaultMeshFile file = {.n = 0};
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCall(ReadFile(fault, &file));
  mesh->kind = !fault->options.text[FAULT_MESH][0] ? &SlipFaultMeshGrid
               : file.triangles                    ? &SlipFaultMeshTriangles
                                                   : &SlipFaultMeshList;
  PetscCall(mesh->kind->create(fault, &file));
  mesh->names = file.names;
  file.names = NULL;
  PetscCall(SlipFaultMeshFileDestroy(&file));
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
  PetscCall(PetscFree(mesh->vertex));
  PetscCall(PetscFree(mesh->corner));
  PetscCall(PetscFree(mesh->names));
  PetscCall(PetscFree(mesh->labels));
  PetscCall(PetscFree(mesh->fault));
  PetscCall(SlipCellsDestroy(&mesh->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sum of the weighted values of a vector of slip along the rake, collective. */
PetscErrorCode SlipFaultWeightedSum(SlipFault fault, Vec x, PetscReal *sum)
{
  const PetscReal *a;

  PetscFunctionBegin;
  *sum = 0;
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    *sum += fault->mesh.weight[i] * SlipFaultDot(fault, a + fault->layout.components * i, SlipFaultAlong(fault, i));
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
