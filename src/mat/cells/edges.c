/*
  Finds which edges of irregular cells are shared, for averages over cells (average.c): an edge that two cells share has
  the geometric mean of both cells' cores, and where slip ends it may have another core. Uniform slip of two cells then
  has no stress from the edge between them.
*/
#include <slipcompat.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <stdlib.h>

/* Coordinates of cells relative to their edges of one kind: centres and extents across and along the edges */
typedef struct {
  const SlipCells *c;
  const PetscReal *u, *across, *v, *along;
  PetscBool along_strike;
} View;

static PetscReal Touch(const SlipCells *c, PetscInt i, PetscInt j)
{
  return SLIP_TOUCH * PetscMin(PetscMin(c->length[i], c->width[i]), PetscMin(c->length[j], c->width[j]));
}

/* Returns the length that the far edge of i and the near edge of j have in common. */
static PetscReal Shared(const View *w, PetscInt i, PetscInt j)
{
  const PetscReal touch = Touch(w->c, i, j);
  const PetscReal gap = (w->u[j] - 0.5 * w->across[j]) - (w->u[i] + 0.5 * w->across[i]);
  const PetscReal low = PetscMax(w->v[i] - 0.5 * w->along[i], w->v[j] - 0.5 * w->along[j]);
  const PetscReal top = PetscMin(w->v[i] + 0.5 * w->along[i], w->v[j] + 0.5 * w->along[j]);

  if (PetscAbsReal(gap) > touch || PetscAbsReal(w->c->y[i] - w->c->y[j]) > touch || top - low <= touch) return 0;
  return top - low;
}

static void Add(const View *w, PetscInt i, PetscReal length, PetscReal ratio, PetscReal force[])
{
  force[i] += w->across[i] * w->along[i] *
              w->c->kernel.type->edge(&w->c->kernel, w->along_strike, w->across[i], length / w->along[i], ratio);
}

/* Returns the first of the sorted near edges at or beyond u. */
static PetscInt First(PetscInt n, const SlipCellKey edge[], PetscReal u)
{
  PetscInt low = 0, top = n;

  while (low < top) {
    const PetscInt middle = (low + top) / 2;

    if (edge[middle].key < u)
      low = middle + 1;
    else
      top = middle;
  }
  return low;
}

/* Adds the edges' terms to force. free[2 i] and free[2 i + 1]: lengths of i's near and far edge that no cell shares */
static PetscErrorCode AddEdges(const View *w, PetscReal force[])
{
  const PetscInt n = w->c->n;
  PetscReal *free;
  SlipCellKey *edge; /* near edges */

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &edge, 2 * n, &free));
  for (PetscInt i = 0; i < n; i++) {
    edge[i] = (SlipCellKey){w->u[i] - 0.5 * w->across[i], i};
    free[2 * i] = free[2 * i + 1] = w->along[i];
  }
  qsort(edge, (size_t)n, sizeof(*edge), SlipCellKeyCompare);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal far = w->u[i] + 0.5 * w->across[i], reach = Touch(w->c, i, i);

    for (PetscInt k = First(n, edge, far - reach); k < n && edge[k].key <= far + reach; k++) {
      const PetscInt j = edge[k].cell;
      const PetscReal length = Shared(w, i, j), ratio = PetscSqrtReal(w->across[j] / w->across[i]);

      if (length == 0) continue;
      Add(w, i, length, ratio, force);
      Add(w, j, length, 1 / ratio, force);
      free[2 * i + 1] -= length;
      free[2 * j] -= length;
    }
  }
  for (PetscInt i = 0; i < 2 * n; i++) {
    const PetscInt e = i / 2;
    const PetscBool surface = (PetscBool)(w->along_strike && i % 2 == 0 && !w->c->kernel.full_space &&
                                          w->u[e] - 0.5 * w->across[e] <= Touch(w->c, e, e));

    if (free[i] > Touch(w->c, e, e) && !surface)
      Add(w, e, free[i], SlipAverageBorderRatio(w->c->kernel.average), force);
  }
  PetscCall(PetscFree2(edge, free));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes force [n][components][components], each cell's force on itself by its own edges. */
static PetscErrorCode Edges(const SlipCells *c, PetscReal **force)
{
  const View strike = {c, c->x, c->length, c->z, c->width, PETSC_FALSE};
  const View depth = {c, c->z, c->width, c->x, c->length, PETSC_TRUE};

  PetscFunctionBegin;
  PetscCall(PetscCalloc1((size_t)c->n * PetscSqr(c->kernel.type->components), force));
  if (c->vertices) {
    PetscCall(SlipTrianglesSides(c, *force));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!c->kernel.type->edge) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AddEdges(&strike, *force));
  PetscCall(AddEdges(&depth, *force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective */
PetscErrorCode SlipCellsEdges(const SlipCells *c, SlipShared shared, PetscReal **force)
{
  PetscFunctionBegin;
  if (SlipSharedFirst(shared)) PetscCall(Edges(c, force));
  PetscCall(SlipSharedMove(shared, sizeof(PetscReal) * (size_t)c->n * PetscSqr(c->kernel.type->components), force));
  PetscFunctionReturn(PETSC_SUCCESS);
}
