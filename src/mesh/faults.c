/* The faults of a mesh: their labels in ascending order, and the fault of each cell. Outputs and catalogues have one
   number per fault in this order. */
#include <slipstep/private/slipmesh.h>
#include <stdlib.h>

/* Without labels each plane is a fault. More planes than this are parts of one fault that bends, because an output
   would otherwise have a useless column for each of its cells. */
#define MESH_MOST_PLANES 21
/* Labels are stored as an attribute, which HDF5 limits to 64 kB */
#define MESH_MOST_FAULTS 4096

static int Compare(const void *a, const void *b)
{
  const PetscInt p = *(const PetscInt *)a, q = *(const PetscInt *)b;

  return p < q ? -1 : p > q;
}

/* Sets faults, labels and fault of a mesh, and mesh->label if a list has no /fault. Collective. */
PetscErrorCode SlipFaultMeshFaults(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o)
{
  PetscFunctionBegin;
  if (mesh->label && !mesh->labelled)
    for (PetscInt e = 0; e < mesh->N; e++) mesh->label[e] = mesh->planes > MESH_MOST_PLANES ? 0 : mesh->plane[e];
  mesh->faults = 1;
  PetscCall(PetscCalloc1(mesh->label ? mesh->N : 1, &mesh->labels));
  if (!mesh->label) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArraycpy(mesh->labels, mesh->label, mesh->N));
  qsort(mesh->labels, (size_t)mesh->N, sizeof(*mesh->labels), Compare);
  for (PetscInt e = 1; e < mesh->N; e++)
    if (mesh->labels[e] != mesh->labels[mesh->faults - 1]) mesh->labels[mesh->faults++] = mesh->labels[e];
  PetscCheck(mesh->faults <= MESH_MOST_FAULTS, mesh->comm, PETSC_ERR_FILE_UNEXPECTED,
             "/fault in %s (-%sfault_mesh) has %" PetscInt_FMT " labels, expected at most %d faults", o->file,
             o->prefix, mesh->faults, MESH_MOST_FAULTS);
  if (mesh->faults == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(mesh->N, &mesh->fault));
  for (PetscInt e = 0; e < mesh->N; e++) {
    const PetscInt *found = bsearch(&mesh->label[e], mesh->labels, (size_t)mesh->faults, sizeof(*found), Compare);

    mesh->fault[e] = (PetscInt)(found - mesh->labels);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
