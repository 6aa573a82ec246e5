/*
  Distributes the cells of an irregular mesh over processes: the cells in the order of their tree of clusters are
  divided into pieces of equal cost. A piece then consists of few clusters, of which the blocks of a hierarchical
  stiffness consist, too: processes exchange 0.85 to 0.99 of what they would with parts of METIS, and on 128
  of them the busiest has 1.25 times the mean work and not 1.47 (10^6 triangles).

  Bisection makes the clusters for any number of processes, so that blocks, and with them results, do not depend on that
  number.
*/
#include <slipstep/rooms/slipcells.h>
#include <slipstep/rooms/slipsys.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatinterface.h>
#include <slipstep/private/slipsys.h>

/* Most cells in a leaf of the tree, if they are few beside those of a part */
#define PARTITION_LEAF 48

/* Processor time of what is done with an entry after it is computed: approximation, rounding, storage [s] (8,000
   triangles, one and two components) */
#define ALGEBRA 5e-8

/* Computes part[i] in [0, size) so that every part has a cell. */
static PetscErrorCode Cut(const SlipCells *c, PetscMPIInt size, const PetscReal cost[], PetscMPIInt part[])
{
  SlipClusterTree tree;
  PetscReal total = 0, sum = 0;
  PetscMPIInt r = 0;
  PetscInt n = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < c->n; i++) total += cost[i];
  PetscCall(SlipClusterTreeCreate(c, PetscClipInterval(c->n / (8 * size), 1, PARTITION_LEAF), &tree));
  for (PetscInt k = 0; k < c->n; k++) {
    const PetscInt i = tree.perm[k], left = c->n - k;

    /* begin the next part when a cell's middle is past the share, or when the others need all remaining cells */
    if (n > 0 && r < size - 1 && (sum + cost[i] / 2 > total * (PetscReal)(r + 1) / size || left < size - r)) {
      r++;
      n = 0;
    }
    part[i] = r;
    sum += cost[i];
    n++;
  }
  PetscCall(SlipClusterTreeDestroy(&tree));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes for size processes the order [n] of the cells, part by part and each in the file's order, and the sizes of
   the parts, count [size]. */
static PetscErrorCode Order(const SlipCells *c, PetscMPIInt size, const char type[], PetscInt order[], PetscInt count[])
{
  PetscReal *cost;
  PetscMPIInt *part;
  PetscInt *end;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(c->n, &cost, c->n, &part));
  PetscCall(SlipCellsCosts(c, type, cost));
  PetscCall(Cut(c, size, cost, part));
  PetscCall(PetscArrayzero(count, size));
  PetscCall(PetscCalloc1(size + 1, &end));
  for (PetscInt i = 0; i < c->n; i++) count[part[i]]++;
  for (PetscMPIInt r = 1; r < size; r++) end[r] = end[r - 1] + count[r - 1];
  for (PetscInt i = 0; i < c->n; i++) order[end[part[i]]++] = i;
  PetscCall(PetscFree(end));
  PetscCall(PetscFree2(cost, part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Partitions a mesh into compact parts of equal cost for the processes. cells: the cells, the same on every process;
   type: storage that their stiffness will have: "dense", "hmat" or "auto"; with "hmat" a cell costs the expected
   storage of its row, otherwise all cost the same; order: [n] cell of each row of the stiffness, the same on every
   process; in its own order on one process. It is an array of shared, or without shared one to free by PetscFree();
   nlocal: rows of this process, at least 1. Pass both to MatCreateSlipCellStiffness() as cells->order and
   cells->nlocal. Errors: PETSC_ERR_ARG_OUTOFRANGE when there are more processes than cells. */
PetscErrorCode SlipCellsPartition(MPI_Comm comm, const SlipCells *cells, const char *type, SlipShared shared,
                                  PetscInt **order, PetscInt *nlocal)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank, size;
  PetscInt *count;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCheck(size <= cells->n, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%d processes for %" PetscInt_FMT " cells: expected at most one process per cell", (int)size, cells->n);
  if (shared)
    PetscCall(SlipSharedMalloc1(shared, cells->n, order));
  else
    PetscCall(PetscMalloc1(cells->n, order));
  PetscCall(PetscMalloc1(size, &count));
  count[0] = cells->n;
  for (PetscInt i = 0; i < cells->n && size == 1; i++) (*order)[i] = i;
  if (size > 1) {
    if (!rank) ierr = Order(cells, size, type, *order, count);
    PetscCall(SlipErrorBcast(comm, ierr));
    if (shared)
      PetscCall(SlipSharedBcast(shared, *order, cells->n, MPIU_INT));
    else
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
  PetscCall(PetscArrayzero(forecast, (normal ? 2 : 1) * size));
  if (size > 1)
    PetscCall(Order(cells, size, type, order, count));
  else {
    for (PetscInt i = 0; i < cells->n; i++) order[i] = i;
    count[0] = cells->n;
  }
  for (int k = 0; k < (normal ? 2 : 1); k++) {
    SlipCellsForecast *f = forecast + (size_t)k * size;
    const PetscReal c = (PetscReal)cells->kernel.type->components, numbers = k ? c : c * c; /* of a pair of cells */
    PetscReal pair, all = 0;

    PetscCall(SlipCellsForecastOfType(cells, type, (PetscBool)k, tolerance, size, order, count, f));
    for (PetscMPIInt r = 0; r < size; r++) all += f[r].pairs;
    PetscCall(SlipCellsPairTime(cells, (PetscBool)k, all, &pair));
    for (PetscMPIInt r = 0; r < size; r++) f[r].seconds = f[r].pairs * (pair + ALGEBRA * numbers);
  }
  PetscCall(PetscFree2(order, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}
