/* A binary tree of cells: each cluster is split in two across the longest side of the box of its centres. */
#include <slipcompat.h>
#include <slipstep/private/slipmatcells.h>
#include <stdlib.h>

/* Computes the smallest box that contains a cell, its low and top coordinates north, east and down. */
void SlipCellsBox(const SlipCells *c, PetscInt e, PetscReal box[6])
{
  const PetscReal centre[3] = {c->x[e], c->y[e], c->z[e]};
  PetscReal half[3] = {0.5 * c->length[e], 0, 0.5 * c->width[e]}, d[9];

  if (c->vertices) {
    const PetscReal *v = c->vertices + 9 * (size_t)e;

    for (int k = 0; k < 3; k++) {
      box[k] = PetscMin(v[k], PetscMin(v[3 + k], v[6 + k]));
      box[3 + k] = PetscMax(v[k], PetscMax(v[3 + k], v[6 + k]));
    }
    return;
  }
  if (c->strike || c->dip) {
    SlipPlaneDirections(c->strike ? c->strike[e] : 0, c->dip ? c->dip[e] : 90, 0, d);
    for (int k = 0; k < 3; k++)
      half[k] = 0.5 * (c->length[e] * PetscAbsReal(d[k]) + c->width[e] * PetscAbsReal(d[3 + k]));
  }
  for (int k = 0; k < 3; k++) {
    box[k] = centre[k] - half[k];
    box[3 + k] = centre[k] + half[k];
  }
}

/* Computes the box of the cells, and the coordinate in which their centres extend most. */
static void Bounds(const SlipCells *c, const PetscInt perm[], SlipCluster *node, const PetscReal **coordinate)
{
  const PetscReal *centre[3] = {c->x, c->y, c->z};
  PetscReal low[3], top[3], widest = -1, boxed = 0, spread = 0;

  for (int k = 0; k < 3; k++) {
    low[k] = node->low[k] = PETSC_MAX_REAL;
    top[k] = node->top[k] = PETSC_MIN_REAL;
  }
  for (PetscInt i = node->start; i < node->end; i++) {
    PetscReal box[6];

    SlipCellsBox(c, perm[i], box);
    for (int k = 0; k < 3; k++) {
      low[k] = PetscMin(low[k], centre[k][perm[i]]);
      top[k] = PetscMax(top[k], centre[k][perm[i]]);
      node->low[k] = PetscMin(node->low[k], box[k]);
      node->top[k] = PetscMax(node->top[k], box[3 + k]);
    }
  }
  for (int k = 0; k < 3; k++) {
    boxed += PetscSqr(node->top[k] - node->low[k]);
    spread += PetscSqr(top[k] - low[k]);
    if (top[k] - low[k] > widest) {
      widest = top[k] - low[k];
      *coordinate = centre[k];
    }
  }
  /* a row of long cells, as of a fault in plane strain, acts on far cells by its extent along the dip */
  node->diameter = PetscSqrtReal(c->dip ? spread : boxed);
}

/* Returns where to split `size` cells sorted by key: at the widest gap if that is a quarter of their extent, as between
   two faults, and has an eighth of the cells on either side; otherwise next to the middle, between two rows of cells if
   one ends in the middle half. If gaps were ignored, clusters would contain cells of both faults down to the leaves. */
static PetscInt Cut(PetscInt size, const SlipCellKey key[])
{
  PetscInt widest = size / 2;
  PetscReal gap = 0;

  for (PetscInt i = PetscMax(1, size / 8); i <= size - PetscMax(1, size / 8); i++)
    if (key[i].key - key[i - 1].key > gap) {
      gap = key[i].key - key[i - 1].key;
      widest = i;
    }
  if (gap >= 0.25 * (key[size - 1].key - key[0].key)) return widest;
  for (PetscInt d = 0; d < size / 4; d++) {
    const PetscInt low = size / 2 - d, top = size / 2 + d;

    if (low > 0 && key[low].key > key[low - 1].key) return low;
    if (top < size && key[top].key > key[top - 1].key) return top;
  }
  return size / 2;
}

PetscErrorCode SlipClusterTreeCreate(const SlipCells *cells, PetscInt leaf, SlipClusterTree *tree)
{
  const PetscInt n = cells->n;
  SlipCellKey *key;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &tree->perm));
  PetscCall(PetscMalloc1(2 * n, &tree->node)); /* a binary tree with at most n leaves */
  PetscCall(PetscMalloc1(n, &key));
  for (PetscInt i = 0; i < n; i++) tree->perm[i] = i;
  tree->node[0] = (SlipCluster){.start = 0, .end = n, .child = {-1, -1}};
  tree->nnodes = 1;
  for (PetscInt t = 0; t < tree->nnodes; t++) {
    SlipCluster *node = &tree->node[t];
    const PetscInt size = node->end - node->start, start = node->start, end = node->end;
    PetscInt middle;
    const PetscReal *coordinate = NULL;

    Bounds(cells, tree->perm, node, &coordinate);
    if (size <= leaf) continue;
    for (PetscInt i = 0; i < size; i++) {
      const PetscInt e = tree->perm[start + i];

      key[i] = (SlipCellKey){coordinate[e], e};
    }
    qsort(key, (size_t)size, sizeof(*key), SlipCellKeyCompare);
    for (PetscInt i = 0; i < size; i++) tree->perm[start + i] = key[i].cell;
    middle = start + Cut(size, key);
    for (int k = 0; k < 2; k++) {
      node->child[k] = tree->nnodes;
      tree->node[tree->nnodes++] =
        (SlipCluster){.start = k ? middle : start, .end = k ? end : middle, .child = {-1, -1}};
    }
  }
  PetscCall(PetscFree(key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipClusterTreeDestroy(SlipClusterTree *tree)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(tree->perm));
  PetscCall(PetscFree(tree->node));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal SlipClusterDistance(const SlipCluster *a, const SlipCluster *b)
{
  PetscReal sum = 0;

  for (int k = 0; k < 3; k++) sum += PetscSqr(PetscMax(0, PetscMax(a->low[k] - b->top[k], b->low[k] - a->top[k])));
  return PetscSqrtReal(sum);
}
