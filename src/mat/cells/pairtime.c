/* Measures what a pair of cells takes on this processor, for predictions of the time of assembly. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipwork.h>

/* Cells of rows, and as many of columns, from all over the mesh, so that few are near each other. Their pairs are
   computed by rows and by columns, as approximations do it; so many are in the usual leaf of a tree. */
#define SAMPLE 40
/* Processor time of a measurement [s], and its share of that of all pairs */
#define LONG_ENOUGH 0.08
#define SHARE 0.05

/* Copies every so-manieth cell, data [17 n]. */
static SlipCells Sample(const SlipCells *c, PetscInt n, PetscReal data[])
{
  const PetscReal *const from[] = {c->x, c->y, c->z, c->length, c->width, c->strike, c->dip, c->rake};
  enum { COLUMNS = PETSC_STATIC_ARRAY_LENGTH(from) };
  PetscReal *column[COLUMNS] = {NULL}, *vertices = data + (size_t)COLUMNS * n;
  SlipCells sample = *c;

  for (PetscInt i = 0; i < n; i++) {
    const PetscInt e = (PetscInt)((PetscInt64)i * c->n / n);

    for (size_t k = 0; k < COLUMNS; k++) {
      column[k] = data + k * (size_t)n;
      if (from[k]) column[k][i] = from[k][e];
    }
    for (int k = 0; k < 9 && c->vertices; k++) vertices[9 * i + k] = c->vertices[9 * (size_t)e + k];
  }
  sample.n = n;
  sample.x = column[0];
  sample.y = column[1];
  sample.z = column[2];
  sample.length = column[3];
  sample.width = column[4];
  sample.strike = c->strike ? column[5] : NULL;
  sample.dip = c->dip ? column[6] : NULL;
  sample.rake = c->rake ? column[7] : NULL;
  sample.vertices = c->vertices ? vertices : NULL;
  sample.order = NULL;
  sample.number = NULL;
  return sample;
}

/* Measures the processor time of the entries of a pair of different cells [s]: of S, or if normal of Kn. all: how many
   pairs will be computed */
PetscErrorCode SlipCellsPairTime(const SlipCells *cells, PetscBool normal, PetscReal all, PetscReal *seconds)
{
  const PetscInt half = PetscMin(SAMPLE, cells->n / 2), n = 2 * half, c = cells->kernel.type->components;
  const PetscReal unit = normal ? 0 : SlipCellsUnit(cells);
  PetscReal *data, *a, *directions, *numbers, begin, least = PETSC_MAX_REAL;
  SlipCellsPairs pairs;
  SlipShared shared;
  SlipCells sample;
  PetscInt *cell;

  PetscFunctionBegin;
  *seconds = 0;
  if (!half) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc3(17 * (size_t)n, &data, (size_t)(half * half) * PetscSqr(c), &a, n, &cell));
  PetscCall(SlipSharedCreate(PETSC_COMM_SELF, &shared));
  sample = Sample(cells, n, data);
  PetscCall(SlipCellsDirections(&sample, shared, &directions));
  sample.directions = directions;
  PetscCall(SlipCellsNumbers(&sample, shared, &numbers));
  sample.numbers = numbers;
  for (PetscInt i = 0; i < n; i++) cell[i] = i < half ? 2 * i : 2 * (i - half) + 1;
  PetscCall(SlipCellsPairsCreate(&sample, unit, half, cell, half, cell + half, &pairs));
  SlipWorkPause(PETSC_TRUE);
  for (PetscReal sum = 0; sum < LONG_ENOUGH && (sum == 0 || sum < SHARE * all * least / ((PetscReal)half * half));) {
    PetscReal time;

    begin = SlipProcessorTime();
    for (PetscInt i = 0; i < half; i += 2) {
      SlipCellsPairsEntries(&pairs, i, 1, 0, half, normal ? 1 : c, a);
      SlipCellsPairsEntries(&pairs, 0, half, i, 1, half * (normal ? 1 : c), a);
    }
    time = SlipProcessorTime() - begin;
    sum += PetscMax(time, 1e-6);
    least = PetscMin(least, time);
  }
  SlipWorkPause(PETSC_FALSE);
  *seconds = least / ((PetscReal)half * (PetscReal)half);
  PetscCall(SlipCellsPairsDestroy(&pairs));
  PetscCall(SlipSharedDestroy(&shared));
  PetscCall(PetscFree3(data, a, cell));
  PetscFunctionReturn(PETSC_SUCCESS);
}
