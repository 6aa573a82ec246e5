/* The planes and the faults of a mesh. Cells of a list are on one plane if their strikes, dips and the distances of
   their planes from the origin agree up to rounding; planes are numbered in the order of the cells. Faults are labels
   in ascending order, and the fault of each cell; outputs and catalogues have one number per fault in this order. */
#include <slipstep/private/slipmesh.h>
#include <stdlib.h>

/* Rounding of an angle over the circle, and of a distance over the coordinates: 1/1000 of cells' allowed overlap */
#define PLANE_ROUNDING 1e-9
/* Without labels each plane is a fault. More planes than this are parts of one fault that bends, because an output
   would otherwise have a useless column for each of its cells. */
#define MESH_MOST_PLANES 21
/* Labels are stored as an attribute, which HDF5 limits to 64 kB */
#define MESH_MOST_FAULTS 4096

static int CompareItems(const void *a, const void *b)
{
  const SlipFaultItem *p = (const SlipFaultItem *)a, *q = (const SlipFaultItem *)b;

  if (p->group != q->group) return p->group < q->group ? -1 : 1;
  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  return p->cell < q->cell ? -1 : p->cell > q->cell;
}

/* Splits the groups where sorted keys differ by more than rounding. */
void SlipFaultSplit(PetscInt n, SlipFaultItem item[], PetscReal rounding)
{
  PetscInt group = 0, last = 0;

  qsort(item, (size_t)n, sizeof(*item), CompareItems);
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt own = item[k].group;

    if (k > 0 && (own != last || item[k].key - item[k - 1].key > rounding)) group++;
    last = own;
    item[k].group = group;
  }
}

/* Returns a strike in [0, 360), where 360 less rounding becomes 0. */
static PetscReal Turn(PetscReal strike)
{
  const PetscReal turn = strike - 360 * PetscFloorReal(strike / 360);

  return turn > 360 * (1 - PLANE_ROUNDING) ? 0 : turn;
}

/* Computes on one process the plane of each cell and the number of planes. */
static PetscErrorCode Planes(SlipFaultMesh *mesh)
{
  const SlipCells *c = &mesh->cells;
  PetscReal *distance, far = 0;
  PetscInt *number;
  SlipFaultItem *item;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(c->n, &item, c->n, &distance, c->n, &number));
  for (PetscInt i = 0; i < c->n; i++) {
    item[i] = (SlipFaultItem){c->strike ? Turn(c->strike[i]) : 0, 0, i};
    distance[i] = c->y[i];
    if (c->dip) {
      SlipFaultCell cell;

      SlipFaultCellDirections(c->strike[i], c->dip[i], &cell);
      distance[i] = c->x[i] * cell.direction[2][0] + c->y[i] * cell.direction[2][1] + c->z[i] * cell.direction[2][2];
    }
    far = PetscMax(far, PetscMax(PetscMax(PetscAbsReal(c->x[i]), PetscAbsReal(c->y[i])), PetscAbsReal(c->z[i])));
    number[i] = -1;
  }
  SlipFaultSplit(c->n, item, 360 * PLANE_ROUNDING);
  for (PetscInt k = 0; k < c->n; k++) item[k].key = c->dip ? c->dip[item[k].cell] : 90;
  SlipFaultSplit(c->n, item, 360 * PLANE_ROUNDING);
  for (PetscInt k = 0; k < c->n; k++) item[k].key = distance[item[k].cell];
  SlipFaultSplit(c->n, item, far * PLANE_ROUNDING);
  for (PetscInt k = 0; k < c->n; k++) mesh->plane[item[k].cell] = item[k].group;
  mesh->planes = 0;
  for (PetscInt i = 0; i < c->n; i++) {
    PetscInt *p = &number[mesh->plane[i]];

    if (*p < 0) *p = mesh->planes++;
    mesh->plane[i] = *p;
  }
  PetscCall(PetscFree3(item, distance, number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets mesh->plane and the number of planes. Collective. */
PetscErrorCode SlipFaultMeshPlanes(SlipFaultMesh *mesh)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  PetscCall(SlipSharedMalloc1(mesh->shared, mesh->cells.n, &mesh->plane));
  if (!rank) ierr = Planes(mesh);
  PetscCall(SlipErrorBcast(mesh->comm, ierr));
  PetscCallMPI(MPI_Bcast(&mesh->planes, 1, MPIU_INT, 0, mesh->comm));
  PetscCall(SlipSharedBcast(mesh->shared, mesh->plane, mesh->cells.n, MPIU_INT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int CompareLabels(const void *a, const void *b)
{
  const PetscInt p = *(const PetscInt *)a, q = *(const PetscInt *)b;

  return p < q ? -1 : p > q;
}

/* Finds on one process the different labels of the cells, ascending: *n of them, labels (PetscFree()). */
static PetscErrorCode Labels(const SlipFaultMesh *mesh, PetscInt *n, PetscInt **labels)
{
  PetscInt *all;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->N, &all));
  PetscCall(PetscArraycpy(all, mesh->label, mesh->N));
  qsort(all, (size_t)mesh->N, sizeof(*all), CompareLabels);
  *n = 1;
  for (PetscInt e = 1; e < mesh->N; e++)
    if (all[e] != all[*n - 1]) all[(*n)++] = all[e];
  PetscCall(PetscMalloc1(*n, labels));
  PetscCall(PetscArraycpy(*labels, all, *n));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets faults, labels and fault of a mesh, and mesh->label if a list has no /fault. Collective. */
PetscErrorCode SlipFaultMeshFaults(SlipFaultMesh *mesh, const SlipFaultMeshOptions *o)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  PetscInt start, end;

  PetscFunctionBegin;
  mesh->faults = 1;
  if (!mesh->label) {
    PetscCall(PetscCalloc1(1, &mesh->labels));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Comm_rank(mesh->comm, &rank));
  SlipSharedSlice(mesh->shared, mesh->label, mesh->N, &start, &end);
  for (PetscInt e = start; e < end && !mesh->labelled; e++)
    mesh->label[e] = mesh->planes > MESH_MOST_PLANES ? 0 : mesh->plane[e];
  PetscCall(SlipSharedReady(mesh->shared));
  if (!rank) ierr = Labels(mesh, &mesh->faults, &mesh->labels);
  PetscCall(SlipErrorBcast(mesh->comm, ierr));
  PetscCallMPI(MPI_Bcast(&mesh->faults, 1, MPIU_INT, 0, mesh->comm));
  PetscCheck(mesh->faults <= MESH_MOST_FAULTS, mesh->comm, PETSC_ERR_FILE_UNEXPECTED,
             "/fault in %s (-%sfault_mesh) has %" PetscInt_FMT " labels, expected at most %d faults", o->file,
             o->prefix, mesh->faults, MESH_MOST_FAULTS);
  if (rank) PetscCall(PetscMalloc1(mesh->faults, &mesh->labels));
  PetscCallMPI(MPI_Bcast(mesh->labels, (PetscMPIInt)mesh->faults, MPIU_INT, 0, mesh->comm));
  if (mesh->faults == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipSharedMalloc1(mesh->shared, mesh->N, &mesh->fault));
  SlipSharedSlice(mesh->shared, mesh->fault, mesh->N, &start, &end);
  for (PetscInt e = start; e < end; e++) {
    const PetscInt *found = bsearch(&mesh->label[e], mesh->labels, (size_t)mesh->faults, sizeof(*found), CompareLabels);

    mesh->fault[e] = (PetscInt)(found - mesh->labels);
  }
  PetscCall(SlipSharedReady(mesh->shared));
  PetscFunctionReturn(PETSC_SUCCESS);
}
