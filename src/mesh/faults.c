/* The faults of a mesh: labels in ascending order, and which of them each cell is of. Outputs and catalogues have a
   number for each in this order. */
#include <slipstep/private/slipmesh.h>
#include <stdlib.h>

/* Without labels each plane is a fault, but more planes than this are the parts of one that bends: columns of an
   output for each of its cells would be of no use. */
#define MESH_MOST_PLANES 21
/* Their labels are an attribute, for which HDF5 has 64 kB. */
#define MESH_MOST_FAULTS 4096

static int Compare(const void *a, const void *b)
{
  const PetscInt p = *(const PetscInt *)a, q = *(const PetscInt *)b;

  return p < q ? -1 : p > q;
}

/* Position of a label among all; it is there */
static PetscInt Find(const SlipFaultMesh *mesh, PetscInt label)
{
  const PetscInt *found = bsearch(&label, mesh->labels, (size_t)mesh->faults, sizeof(label), Compare);

  return (PetscInt)(found - mesh->labels);
}

/* mesh->label of a list without /fault, faults, labels and fault. Collective. */
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
  for (PetscInt e = 0; e < mesh->N; e++) mesh->fault[e] = Find(mesh, mesh->label[e]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
