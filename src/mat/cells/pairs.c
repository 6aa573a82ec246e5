/*
  Entries of a block of an irregular mesh's stiffness. Kernels of lanes take the numbers of SLIP_PAIRS cells at once,
  which are sorted once for all entries of the block; others take pairs, SlipCellsEntries().
*/
#include <slipstep/rooms/slipmat.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipwork.h>

/* Computes the numbers of all cells for kernels of lanes, else NULL. Collective. */
PetscErrorCode SlipCellsNumbers(const SlipCells *cells, SlipShared shared, PetscReal **numbers)
{
  const SlipKernelLanes *lanes = SlipKernelGetLanes(&cells->kernel);
  PetscInt start, end;

  PetscFunctionBegin;
  *numbers = NULL;
  if (!lanes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipSharedMalloc1(shared, (size_t)lanes->numbers * cells->n, numbers));
  SlipSharedSlice(shared, *numbers, cells->n, &start, &end);
  for (PetscInt i = start; i < end; i++) {
    const SlipCell cell = SlipCellsGet(cells, i);

    (*lanes->cell)(&cells->kernel, &cell, *numbers + (size_t)lanes->numbers * i);
  }
  PetscCall(SlipSharedReady(shared));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipCellsPairsCreate - prepares the computation of entries of a block

  unit is that of SlipCellsEntries(); the numbers of rows and columns are borrowed until SlipCellsPairsDestroy()
*/
PetscErrorCode SlipCellsPairsCreate(const SlipCells *cells, PetscReal unit, PetscInt m, const PetscInt row[],
                                    PetscInt n, const PetscInt column[], SlipCellsPairs *p)
{
  const SlipKernelLanes *lanes = cells->numbers ? SlipKernelGetLanes(&cells->kernel) : NULL;
  const size_t all = lanes ? (size_t)lanes->numbers * SLIP_PAIRS : 0;

  PetscFunctionBegin;
  *p = (SlipCellsPairs){.cells = cells, .unit = unit, .kernel = lanes, .n = {m, n}, .cell = {row, column}};
  if (!lanes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(all, &p->one));
  for (int side = 0; side < 2; side++) {
    const PetscInt groups = (p->n[side] + SLIP_PAIRS - 1) / SLIP_PAIRS;

    PetscCall(PetscMalloc2(all * (size_t)groups, &p->lanes[side], p->n[side], &p->area[side]));
    /* lanes after the last cell repeat it */
    for (PetscInt i = 0; i < groups * SLIP_PAIRS; i++) {
      const PetscInt cell = p->cell[side][PetscMin(i, p->n[side] - 1)];
      const PetscReal *from = cells->numbers + (size_t)lanes->numbers * cell;
      PetscReal *to = p->lanes[side] + all * (size_t)(i / SLIP_PAIRS) + i % SLIP_PAIRS;

      for (PetscInt k = 0; k < lanes->numbers; k++) to[SLIP_PAIRS * k] = from[k];
      if (i < p->n[side]) p->area[side][i] = cells->length[cell] * cells->width[cell];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCellsPairsDestroy(SlipCellsPairs *p)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(p->one));
  PetscCall(PetscFree(p->full));
  for (int side = 0; side < 2; side++) PetscCall(PetscFree2(p->lanes[side], p->area[side]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes all entries at once, full [m c][n c] column-major; later calls copy from them. */
PetscErrorCode SlipCellsPairsFill(SlipCellsPairs *p)
{
  const PetscInt c = p->cells->kernel.type->components, lda = p->n[0] * (p->unit == 0 ? 1 : c);
  PetscReal *full;

  PetscFunctionBegin;
  if (p->full) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((size_t)lda * p->n[1] * c, &full));
  SlipCellsPairsEntries(p, 0, p->n[0], 0, p->n[1], lda, full);
  p->full = full;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes blocks [SLIP_KERNEL_BLOCK][SLIP_PAIRS] of pairs in lanes, those that lanes cannot compute one by one. */
static void BlocksOf(const SlipCellsPairs *p, const PetscReal receiver[], const PetscReal source[], PetscInt count,
                     const PetscInt receivers[], PetscInt receiver_step, const PetscInt sources[], PetscInt source_step,
                     PetscReal block[])
{
  const SlipKernel *kernel = &p->cells->kernel;
  const PetscInt c = kernel->type->components, rows = p->unit == 0 ? 1 : c, first = p->unit == 0 ? c * c : 0;
  PetscReal near[SLIP_PAIRS], one[SLIP_KERNEL_BLOCK];

  (*p->kernel->blocks)(kernel, (PetscBool)(p->unit == 0), receiver, source, block, near);
  for (PetscInt k = 0; k < count; k++) {
    SlipCell a, b;

    if (near[k] == 0) continue;
    a = SlipCellsGet(p->cells, receivers[receiver_step * k]);
    b = SlipCellsGet(p->cells, sources[source_step * k]);
    (*kernel->type->centre)(kernel, &a, &b, one);
    for (PetscInt i = 0; i < rows * c; i++) block[SLIP_PAIRS * i + k] = one[first + i];
  }
}

/*
  SlipCellsPairsEntries - computes entries a of the block like SlipCellsEntries(), for m of its rows' cells, from number
  i on, and n of its columns' cells, from number j on
*/
void SlipCellsPairsEntries(const SlipCellsPairs *p, PetscInt i, PetscInt m, PetscInt j, PetscInt n, PetscInt lda,
                           PetscReal a[])
{
  const PetscInt c = p->cells->kernel.type->components, rows = p->unit == 0 ? 1 : c;
  const int many = m >= n ? 0 : 1; /* lanes are of rows or of columns */
  const PetscInt start[2] = {i, j}, size[2] = {m, n}, end = start[many] + size[many];
  const PetscReal unit = p->unit;
  size_t all;

  if (p->full) {
    for (PetscInt l = 0; l < c * n; l++)
      for (PetscInt k = 0; k < rows * m; k++)
        a[(size_t)l * lda + k] = p->full[(size_t)(c * j + l) * rows * p->n[0] + rows * i + k];
    return;
  }
  if (!p->kernel) {
    SlipCellsEntries(p->cells, unit, m, p->cell[0] + i, n, p->cell[1] + j, lda, a);
    return;
  }
  SlipWorkAdd(SLIP_WORK_TRIANGLE_PAIR, (PetscReal)m * (PetscReal)n);
  all = (size_t)p->kernel->numbers * SLIP_PAIRS;
  for (PetscInt o = 0; o < size[1 - many]; o++) {
    const PetscInt one = start[1 - many] + o, *cell = p->cell[1 - many] + one;
    const PetscReal *from = p->lanes[1 - many] + all * (size_t)(one / SLIP_PAIRS) + one % SLIP_PAIRS;

    for (size_t k = 0; k < all; k++) p->one[k] = from[k / SLIP_PAIRS * SLIP_PAIRS];
    for (PetscInt first = start[many] / SLIP_PAIRS * SLIP_PAIRS; first < end; first += SLIP_PAIRS) {
      const PetscReal *lanes[2] = {p->one, p->lanes[many] + all * (size_t)(first / SLIP_PAIRS)};
      const PetscReal *row = lanes[1 - many], *column = lanes[many];
      const PetscInt count = PetscMin(SLIP_PAIRS, end - first), *cells[2] = {cell, p->cell[many] + first};
      PetscReal block[SLIP_KERNEL_BLOCK * SLIP_PAIRS], back[SLIP_KERNEL_BLOCK * SLIP_PAIRS];

      BlocksOf(p, row, column, count, cells[1 - many], 1 - many, cells[many], many, block);
      if (unit != 0) BlocksOf(p, column, row, count, cells[many], many, cells[1 - many], 1 - many, back);
      for (PetscInt k = PetscMax(start[many] - first, 0); k < count; k++) {
        const PetscInt at[2] = {many ? o : first + k - i, many ? first + k - j : o};
        const PetscReal area[2] = {unit * p->area[0][i + at[0]], unit * p->area[1][j + at[1]]};
        PetscReal *to = a + (size_t)at[1] * c * lda + at[0] * rows;

        for (PetscInt l = 0; l < c; l++)
          for (PetscInt r = 0; r < rows; r++)
            to[l * lda + r] =
              unit == 0 ? block[SLIP_PAIRS * l + k]
                        : area[0] * block[SLIP_PAIRS * (r * c + l) + k] + area[1] * back[SLIP_PAIRS * (l * c + r) + k];
      }
    }
  }
}
