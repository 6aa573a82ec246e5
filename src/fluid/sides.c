/* Which cells share which sides. Every process numbers the sides of all cells in the order in which the cells of the
   mesh, as they are distributed, come to them; that needs no communication, and a process owns numbers that follow one
   another. The arrays of all cells are freed at the end. */
#include <slipstep/private/slipfluid.h>

/* The pieces of all cells so far, found by their ends */
typedef struct {
  PetscInt n, *head, *next, *high, *cells; /* the first by its lower end; of each piece */
} Table;

/* Number of the piece between two points, a new one if no cell had it before */
static PetscInt Number(Table *t, PetscInt a, PetscInt b)
{
  const PetscInt low = PetscMin(a, b), high = PetscMax(a, b);

  for (PetscInt s = t->head[low]; s >= 0; s = t->next[s])
    if (t->high[s] == high) {
      t->cells[s]++;
      return s;
    }
  t->high[t->n] = high;
  t->next[t->n] = t->head[low];
  t->cells[t->n] = 1;
  t->head[low] = t->n;
  return t->n++;
}

PetscErrorCode SlipFluidSidesCreate(const SlipFaultMesh *mesh, SlipFluidSides *s)
{
  const PetscInt ends = mesh->kind->sides;
  PetscInt *corners, *sorted, entries = ends * mesh->n, last = 0, place;
  PetscReal *points;
  Table t = {.n = 0};

  PetscFunctionBegin;
  PetscCheck(mesh->kind != &SlipFaultMeshList, mesh->comm, PETSC_ERR_SUP,
             "fluid diffuses in uniform grids and triangles only, not in rectangles of -fault_mesh");
  PetscCall(PetscMalloc2(3 * (size_t)mesh->npoints, &points, ends * (size_t)mesh->N, &corners));
  PetscCall(mesh->kind->corners(mesh, points, corners));
  PetscCall(PetscMalloc4(mesh->npoints, &t.head, ends * (size_t)mesh->N, &t.next, ends * (size_t)mesh->N, &t.high,
                         ends * (size_t)mesh->N, &t.cells));
  for (PetscInt p = 0; p < mesh->npoints; p++) t.head[p] = -1;
  PetscCall(PetscMalloc4(mesh->n + 1, &s->offset, entries, &s->piece, entries, &s->side, entries, &s->part));
  for (PetscInt e = 0, k = 0; e < mesh->N; e++) {
    const PetscInt *corner = corners + ends * (size_t)SlipFaultMeshRowOf(mesh, e), i = e - mesh->start;

    if (!i) s->first = t.n;
    for (PetscInt c = 0; c < ends; c++) {
      const PetscInt piece = Number(&t, corner[c], corner[(c + 1) % ends]);

      if (i < 0 || i >= mesh->n) continue;
      s->piece[k] = piece;
      s->side[k] = c;
      s->part[k++] = 1;
    }
    if (i >= 0 && i < mesh->n) {
      s->offset[i + 1] = k;
      last = t.n;
    }
  }
  s->offset[0] = 0;
  s->owned = last - s->first;
  /* pieces that processes before this one own are ghosts, ascending */
  PetscCall(PetscMalloc1(entries, &sorted));
  s->ghosts = 0;
  for (PetscInt k = 0; k < entries; k++)
    if (s->piece[k] < s->first) sorted[s->ghosts++] = s->piece[k];
  PetscCall(PetscSortRemoveDupsInt(&s->ghosts, sorted));
  PetscCall(PetscMalloc2(s->ghosts, &s->ghost, s->owned + s->ghosts, &s->cells));
  PetscCall(PetscArraycpy(s->ghost, sorted, s->ghosts));
  PetscCall(PetscFree(sorted));
  for (PetscInt k = 0; k < entries; k++) {
    if (s->piece[k] >= s->first) {
      s->piece[k] -= s->first;
      continue;
    }
    PetscCall(PetscFindInt(s->piece[k], s->ghosts, s->ghost, &place));
    s->piece[k] = s->owned + place;
  }
  PetscCall(PetscArraycpy(s->cells, t.cells + s->first, s->owned));
  for (PetscInt k = 0; k < s->ghosts; k++) s->cells[s->owned + k] = t.cells[s->ghost[k]];
  PetscCall(PetscFree4(t.head, t.next, t.high, t.cells));
  PetscCall(PetscFree2(points, corners));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFluidSidesDestroy(SlipFluidSides *s)
{
  PetscFunctionBegin;
  PetscCall(PetscFree4(s->offset, s->piece, s->side, s->part));
  PetscCall(PetscFree2(s->ghost, s->cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}
