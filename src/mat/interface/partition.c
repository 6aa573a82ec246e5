/*
  Distributes the cells of an irregular mesh over processes: METIS partitions the graph that joins each cell to its
  nearest ones into compact parts of equal cost (Karypis & Kumar 1998, SIAM J. Sci. Comput. 20).

  The graph is of cells, not of the cluster tree: bisection makes the clusters of the hierarchical stiffness for any
  number of processes, so that its low-rank blocks, and with them results, do not depend on that number.

  Without METIS the leaves of a tree of clusters, in their order, are divided into pieces of equal cost, which balances
  as well, with two to two and a half times the shared sides (1920 cells in two faults: 130 instead of 54 on 4
  processes, 266 instead of 129 on 7).
*/
#include <slipstep/rooms/slipcells.h>
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatinterface.h>
#include <stdlib.h>
#if defined(SLIPSTEP_HAVE_METIS)
  #include <metis.h>
#else
typedef PetscInt idx_t;
#endif

enum {
  near_cells = 8,      /* neighbours to which a cell is joined, as many as touch it on a grid */
  search_leaf = 16,    /* cells in a leaf of the search tree */
  max_recursive = 8,   /* number of parts up to which METIS bisects recursively, which balances better */
  cost_unit = 1 << 12, /* most cost of the mean cell, because METIS takes integers, */
  cost_all = 1 << 30,  /* and of all cells, because it sums them */
};

#if defined(SLIPSTEP_HAVE_METIS)
/* ---- nearest cells ---- */

/* The nearest cells found so far, by increasing distance */
typedef struct {
  PetscInt n;
  PetscInt cell[near_cells];
  PetscReal distance[near_cells];
} Near;

static PetscReal Centre(const SlipCells *c, PetscInt i, int k)
{
  return k == 0 ? c->x[i] : k == 1 ? c->y[i] : c->z[i];
}

static void AddNear(Near *near, PetscInt cell, PetscReal distance)
{
  PetscInt k;

  if (near->n == near_cells && distance >= near->distance[near_cells - 1]) return;
  if (near->n < near_cells) near->n++;
  for (k = near->n - 1; k > 0 && near->distance[k - 1] > distance; k--) {
    near->cell[k] = near->cell[k - 1];
    near->distance[k] = near->distance[k - 1];
  }
  near->cell[k] = cell;
  near->distance[k] = distance;
}

/* Returns the distance of a cell's centre from the box of a cluster, which contains the centres of its cells. */
static PetscReal DistanceToBox(const SlipCells *c, PetscInt i, const SlipCluster *box)
{
  PetscReal sum = 0;

  for (int k = 0; k < 3; k++) {
    const PetscReal x = Centre(c, i, k);

    sum += PetscSqr(PetscMax(0, PetscMax(box->low[k] - x, x - box->top[k])));
  }
  return PetscSqrtReal(sum);
}

static void Search(const SlipCells *c, const SlipClusterTree *tree, PetscInt node, PetscInt i, Near *near)
{
  const SlipCluster *p = &tree->node[node];

  if (near->n == near_cells && DistanceToBox(c, i, p) >= near->distance[near_cells - 1]) return;
  if (p->child[0] >= 0) {
    const int first = DistanceToBox(c, i, &tree->node[p->child[0]]) <= DistanceToBox(c, i, &tree->node[p->child[1]]);

    Search(c, tree, p->child[!first], i, near);
    Search(c, tree, p->child[first], i, near);
    return;
  }
  for (PetscInt k = p->start; k < p->end; k++) {
    const PetscInt j = tree->perm[k];
    PetscReal sum = 0;

    for (int d = 0; d < 3; d++) sum += PetscSqr(Centre(c, i, d) - Centre(c, j, d));
    if (j != i) AddNear(near, j, PetscSqrtReal(sum));
  }
}

/* ---- the graph ---- */

typedef struct {
  idx_t n, *start, *neighbour; /* compressed rows */
} Graph;

static int CompareIndices(const void *a, const void *b)
{
  const idx_t p = *(const idx_t *)a, q = *(const idx_t *)b;

  return p < q ? -1 : p > q;
}

/* Creates the graph that joins each cell to its nearest ones and them to it. */
static PetscErrorCode GraphCreate(const SlipCells *c, Graph *g)
{
  idx_t end = 0;
  SlipClusterTree tree;
  Near *near;
  idx_t *fill;

  PetscFunctionBegin;
  g->n = (idx_t)c->n;
  PetscCall(SlipClusterTreeCreate(c, search_leaf, &tree));
  PetscCall(PetscCalloc1(c->n, &near));
  PetscCall(PetscCalloc1((size_t)c->n + 1, &g->start));
  PetscCall(PetscMalloc1(2 * near_cells * (size_t)c->n, &g->neighbour));
  PetscCall(PetscMalloc1(c->n, &fill));
  for (PetscInt i = 0; i < c->n; i++) {
    Search(c, &tree, 0, i, &near[i]);
    g->start[i + 1] += (idx_t)near[i].n;
    for (PetscInt k = 0; k < near[i].n; k++) g->start[near[i].cell[k] + 1]++;
  }
  for (PetscInt i = 0; i < c->n; i++) {
    g->start[i + 1] += g->start[i];
    fill[i] = g->start[i];
  }
  for (PetscInt i = 0; i < c->n; i++)
    for (PetscInt k = 0; k < near[i].n; k++) {
      const PetscInt j = near[i].cell[k];

      g->neighbour[fill[i]++] = (idx_t)j;
      g->neighbour[fill[j]++] = (idx_t)i;
    }
  /* sort each row and remove duplicates */
  for (idx_t i = 0; i < g->n; i++) {
    const idx_t first = g->start[i], size = g->start[i + 1] - first;
    idx_t last = -1;

    qsort(g->neighbour + first, (size_t)size, sizeof(idx_t), CompareIndices);
    g->start[i] = end;
    for (idx_t k = first; k < first + size; k++) {
      if (g->neighbour[k] != last) g->neighbour[end++] = g->neighbour[k];
      last = g->neighbour[end - 1];
    }
  }
  g->start[g->n] = end;
  PetscCall(PetscFree(fill));
  PetscCall(PetscFree(near));
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the parts ---- */

/* Computes part[i] in [0, size) so that every part has a cell. Tiny meshes are divided equally in the file's order. */
static PetscErrorCode Cut(const SlipCells *c, PetscMPIInt size, const PetscReal cost[], idx_t part[])
{
  const PetscReal unit = PetscMin(cost_unit, (PetscReal)cost_all / (PetscReal)c->n);
  idx_t options[METIS_NOPTIONS], one = 1, parts = (idx_t)size, cut, *weight;
  PetscReal mean = 0;
  PetscInt *count, empty = 0;
  Graph g;
  int code;

  PetscFunctionBegin;
  PetscCall(GraphCreate(c, &g));
  PetscCall(PetscMalloc1(c->n, &weight));
  for (PetscInt i = 0; i < c->n; i++) mean += cost[i] / (PetscReal)c->n;
  for (PetscInt i = 0; i < c->n; i++) weight[i] = PetscMax(1, (idx_t)(unit * cost[i] / mean));
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1; /* the same parts in every run */
  code = (size > max_recursive ? METIS_PartGraphKway : METIS_PartGraphRecursive)(
    &g.n, &one, g.start, g.neighbour, weight, NULL, NULL, &parts, NULL, NULL, options, &cut, part);
  PetscCheck(code == METIS_OK, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "METIS could not cut %" PetscInt_FMT " cells into %d parts (code %d)", c->n, (int)size, code);
  PetscCall(PetscCalloc1(size, &count));
  for (PetscInt i = 0; i < c->n; i++) count[part[i]]++;
  for (PetscMPIInt r = 0; r < size; r++) empty += count[r] ? 0 : 1;
  for (PetscInt i = 0; i < c->n && empty; i++) part[i] = (idx_t)((double)i * size / (double)c->n);
  PetscCall(PetscFree(count));
  PetscCall(PetscFree(weight));
  PetscCall(PetscFree(g.start));
  PetscCall(PetscFree(g.neighbour));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
/* Computes part[i] in [0, size) so that every part has a cell. */
static PetscErrorCode Cut(const SlipCells *c, PetscMPIInt size, const PetscReal cost[], idx_t part[])
{
  SlipClusterTree tree;
  PetscReal total = 0, sum = 0;
  PetscInt r = 0, n = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < c->n; i++) total += cost[i];
  PetscCall(SlipClusterTreeCreate(c, 1, &tree));
  for (PetscInt k = 0; k < c->n; k++) {
    const PetscInt i = tree.perm[k], left = c->n - k;

    /* begin the next part when a cell's middle is past the share, or when the others need all remaining cells */
    if (n > 0 && r < size - 1 && (sum + cost[i] / 2 > total * (PetscReal)(r + 1) / size || left < size - r)) {
      r++;
      n = 0;
    }
    part[i] = (idx_t)r;
    sum += cost[i];
    n++;
  }
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}
#endif

/* Computes for size processes the order [n] of the cells, part by part and each in the file's order, and the sizes of
   the parts, count [size]. */
static PetscErrorCode Order(const SlipCells *c, PetscMPIInt size, const char type[], PetscInt order[], PetscInt count[])
{
  PetscReal *cost;
  idx_t *part;
  PetscInt k = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(c->n, &cost, c->n, &part));
  PetscCall(SlipCellsCosts(c, type, cost));
  PetscCall(Cut(c, size, cost, part));
  for (PetscMPIInt r = 0; r < size; r++) {
    count[r] = 0;
    for (PetscInt i = 0; i < c->n; i++) {
      if (part[i] != r) continue;
      order[k++] = i;
      count[r]++;
    }
  }
  PetscCall(PetscFree2(cost, part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Partitions a mesh into compact parts of equal cost for the processes. cells: the cells, the same on every process;
   type: storage that their stiffness will have: "dense", "hmat" or "auto"; with "hmat" a cell costs the expected
   storage of its row, otherwise all cost the same; order: [n] cell of each row of the stiffness, the same on every
   process; in its own order on one process. Free it with PetscFree(); nlocal: rows of this process, at least 1. Pass
   both to MatCreateSlipCellStiffness() as cells->order and cells->nlocal. Errors: PETSC_ERR_ARG_OUTOFRANGE when there
   are more processes than cells. */
PetscErrorCode SlipCellsPartition(MPI_Comm comm, const SlipCells *cells, const char *type, PetscInt **order,
                                  PetscInt *nlocal)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank, size;
  PetscInt *count;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCheck(size <= cells->n, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%d processes for %" PetscInt_FMT " cells: expected at most one process per cell", (int)size, cells->n);
  PetscCall(PetscMalloc1(cells->n, order));
  PetscCall(PetscMalloc1(size, &count));
  for (PetscInt i = 0; i < cells->n; i++) (*order)[i] = i;
  count[0] = cells->n;
  if (size > 1) {
    if (!rank) ierr = Order(cells, size, type, *order, count);
    PetscCall(SlipErrorBcast(comm, ierr));
    PetscCallMPI(MPI_Bcast(*order, (PetscMPIInt)cells->n, MPIU_INT, 0, comm));
    PetscCallMPI(MPI_Bcast(count, size, MPIU_INT, 0, comm));
  }
  *nlocal = count[rank];
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCellsForecasts(const SlipCells *cells, const char type[], PetscReal tolerance, PetscBool normal,
                                  PetscMPIInt size, SlipCellsForecast forecast[])
{
  PetscInt *order, *count;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(cells->n, &order, size, &count));
  PetscCall(PetscArrayzero(forecast, size));
  if (size > 1)
    PetscCall(Order(cells, size, type, order, count));
  else {
    for (PetscInt i = 0; i < cells->n; i++) order[i] = i;
    count[0] = cells->n;
  }
  PetscCall(SlipCellsForecastOfType(cells, type, PETSC_FALSE, tolerance, size, order, count, forecast));
  if (normal) PetscCall(SlipCellsForecastOfType(cells, type, PETSC_TRUE, tolerance, size, order, count, forecast));
  PetscCall(PetscFree2(order, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}
