/*
  Finds which sides of triangles are shared, for averages over cells (triangle_loops.c): a shared side has the smaller
  core of the two cells, and a side where slip ends may have another core. If several triangles are beyond a side, as
  where faults branch, each counts for its share. Shared sides have equal coordinates, as in meshes of files.
*/
#include <slipcompat.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <stdlib.h>

/* A side: its ends, the one with the smaller coordinates first */
typedef struct {
  PetscReal end[2][3];
  PetscInt cell, side;
  PetscReal height; /* of the cell over it [m] */
} Side;

static int ComparePoints(const PetscReal a[3], const PetscReal b[3])
{
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  return 0;
}

static int CompareEnds(const Side *p, const Side *q)
{
  const int first = ComparePoints(p->end[0], q->end[0]);

  return first ? first : ComparePoints(p->end[1], q->end[1]);
}

static int Compare(const void *a, const void *b)
{
  const Side *p = (const Side *)a, *q = (const Side *)b;
  const int ends = CompareEnds(p, q);

  return ends ? ends : (p->cell > q->cell) - (p->cell < q->cell);
}

static Side SideOf(const SlipCells *c, PetscInt cell, PetscInt k)
{
  const PetscReal *a = c->vertices + 9 * (size_t)cell + 3 * k, *b = c->vertices + 9 * (size_t)cell + 3 * ((k + 1) % 3);
  const PetscBool turned = ComparePoints(a, b) > 0 ? PETSC_TRUE : PETSC_FALSE;
  Side s = {.cell = cell, .side = k};
  PetscReal square = 0;

  for (int i = 0; i < 3; i++) {
    s.end[0][i] = turned ? b[i] : a[i];
    s.end[1][i] = turned ? a[i] : b[i];
    square += PetscSqr(b[i] - a[i]);
  }
  s.height = 2 * c->length[cell] * c->width[cell] / PetscSqrtReal(square);
  return s;
}

static void Add(const SlipCells *c, const Side *s, PetscReal share, PetscReal ratio, PetscReal force[])
{
  const SlipCell cell = SlipCellsGet(c, s->cell);
  const PetscInt size = PetscSqr(c->kernel.type->components);
  PetscReal block[9];

  c->kernel.type->side(&c->kernel, &cell, s->side, share, ratio, block);
  for (PetscInt k = 0; k < size; k++) force[s->cell * size + k] += c->length[s->cell] * c->width[s->cell] * block[k];
}

/* Returns whether a side is on the free surface, beyond which slip continues. */
static PetscBool OnGround(const SlipCells *c, const Side *s)
{
  const PetscReal touch = SLIP_TOUCH * s->height;

  return !c->kernel.full_space && s->end[0][2] <= touch && s->end[1][2] <= touch ? PETSC_TRUE : PETSC_FALSE;
}

/* Adds to force [n][components][components] what each cell's own sides add to its force on itself. */
PetscErrorCode SlipTrianglesSides(const SlipCells *c, PetscReal force[])
{
  const PetscInt n = 3 * c->n;
  const PetscReal border = SlipAverageBorderRatio(c->kernel.average);
  Side *side;

  PetscFunctionBegin;
  if (!c->kernel.type->side) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(n, &side));
  for (PetscInt k = 0; k < n; k++) side[k] = SideOf(c, k / 3, k % 3);
  qsort(side, (size_t)n, sizeof(*side), Compare);
  for (PetscInt first = 0, end; first < n; first = end) {
    for (end = first + 1; end < n && !CompareEnds(side + first, side + end);) end++;
    for (PetscInt i = first; i < end; i++)
      for (PetscInt j = first; j < end; j++)
        if (j != i)
          Add(c, side + i, 1 / (PetscReal)(end - first - 1), PetscMin(1, side[j].height / side[i].height), force);
    if (end == first + 1 && !OnGround(c, side + first)) Add(c, side + first, 1, border, force);
  }
  PetscCall(PetscFree(side));
  PetscFunctionReturn(PETSC_SUCCESS);
}
