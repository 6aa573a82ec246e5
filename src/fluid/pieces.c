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

/* Numbers the pieces of all cells; those of this process's cells are in s, with room for `entries`. */
static PetscErrorCode Fill(const SlipFaultMesh *mesh, const PetscInt corners[], const SlipFluidMeet *meet, Table *t,
                           SlipFluidSides *s, SlipFluidWhole *w)
{
  const PetscInt ends = mesh->kind->sides;
  PetscInt k = 0, all = 0, last = 0;

  PetscFunctionBegin;
  s->first = s->most = 0;
  s->offset[0] = w->offset[0] = 0;
  for (PetscInt e = 0; e < mesh->N; e++) {
    const size_t row = (size_t)SlipFaultMeshRowOf(mesh, e);
    const PetscBool ours = e >= mesh->start && e < mesh->start + mesh->n ? PETSC_TRUE : PETSC_FALSE;

    if (e == mesh->start) s->first = t->n;
    for (PetscInt c = 0; c < ends; c++) {
      const size_t side = ends * row + c;
      const PetscInt pieces = meet ? meet->first[side + 1] - meet->first[side] + 1 : 1;
      const SlipFluidCut *cut = meet ? meet->cut + meet->first[side] : NULL;

      for (PetscInt j = 0; j < pieces; j++) {
        const PetscInt a = j ? cut[j - 1].point : corners[side];
        const PetscInt b = j + 1 < pieces ? cut[j].point : corners[ends * row + (c + 1) % ends];
        const PetscInt piece = Number(t, a, b);

        w->piece[all++] = piece;
        if (!ours) continue;
        s->piece[k] = piece;
        s->side[k] = c;
        s->part[k++] = (j + 1 < pieces ? cut[j].part : 1) - (j ? cut[j - 1].part : 0);
      }
    }
    w->offset[e + 1] = all;
    if (!ours) continue;
    s->offset[e - mesh->start + 1] = k;
    s->most = PetscMax(s->most, k - s->offset[e - mesh->start]);
    last = t->n;
  }
  s->owned = last - s->first;
  w->pieces = t->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFluidSidesCreate(const SlipFaultMesh *mesh, SlipFluidSides *s)
{
  const PetscInt ends = mesh->kind->sides;
  const PetscBool list = mesh->kind == &SlipFaultMeshList ? PETSC_TRUE : PETSC_FALSE;
  PetscInt *corners, *sorted, entries = ends * mesh->n, place;
  size_t all = ends * (size_t)mesh->N;
  PetscReal *points;
  SlipFluidMeet meet;
  SlipFluidWhole whole;
  Table t = {.n = 0};

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(3 * (size_t)mesh->npoints, &points, all, &corners));
  PetscCall(mesh->kind->corners(mesh, points, corners));
  if (list) {
    PetscCall(SlipFluidMeetCreate(mesh->N, points, &meet));
    all += (size_t)meet.first[4 * (size_t)mesh->N];
    for (PetscInt i = mesh->start; i < mesh->start + mesh->n; i++) {
      const size_t row = (size_t)SlipFaultMeshRowOf(mesh, i);

      entries += meet.first[4 * row + 4] - meet.first[4 * row];
    }
  }
  PetscCall(PetscMalloc4(mesh->npoints, &t.head, all, &t.next, all, &t.high, all, &t.cells));
  for (PetscInt p = 0; p < mesh->npoints; p++) t.head[p] = -1;
  PetscCall(PetscMalloc4(mesh->n + 1, &s->offset, entries, &s->piece, entries, &s->side, entries, &s->part));
  PetscCall(PetscMalloc2((size_t)mesh->N + 1, &whole.offset, all, &whole.piece));
  PetscCall(Fill(mesh, list ? meet.point : corners, list ? &meet : NULL, &t, s, &whole));
  s->bodies = (SlipFluidBodies){.bodies = 1};
  if (mesh->kind != &SlipFaultMeshGrid) PetscCall(SlipFluidBodiesFind(mesh, points, corners, &whole, &s->bodies));
  PetscCall(PetscFree2(whole.offset, whole.piece));
  if (list) PetscCall(SlipFluidMeetDestroy(&meet));
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
