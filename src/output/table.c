/* Tables of an output file: rows collected in memory, appended to HDF5 in blocks. */
#include <slipstep/private/slipoutput.h>
#include <slipcompat.h>

/* One series group/name per column; group "" is the root. Rank 0 only, as the rest of this file. */
PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                               const SlipOutputColumn column[], const PetscInt entries[], PetscInt rows)
{
  char path[128];
  PetscInt found, numbers = 0, axes, size;

  PetscFunctionBegin;
  PetscCheck(ncolumns <= SLIP_TABLE_COLUMNS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " columns in %s, expected at most %d", ncolumns, group, SLIP_TABLE_COLUMNS);
  PetscCall(PetscStrncpy(t->group, group, sizeof(t->group)));
  t->ncolumns = ncolumns;
  t->nrows = 0;
  t->written = PetscMax(rows, 0);
  for (PetscInt c = 0; c < ncolumns; c++) {
    const PetscInt n = entries ? entries[c] : 0, dims[] = {PetscAbsInt(n), 3}, wide = n < 0 ? 2 : n > 0 ? 1 : 0;
    PetscInt ndim;

    t->column[c] = column[c];
    t->entries[c] = n < 0 ? -3 * n : PetscMax(n, 1);
    t->first[c] = numbers;
    numbers += t->entries[c];
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, column[c].name));
    if (rows < 0) {
      PetscCall(SlipH5CreateSeries(h, path, wide, dims, column[c].integer, column[c].unit));
      continue;
    }
    PetscCall(SlipH5SetRows(h, path, rows));
    PetscCall(SlipH5GetRank(h, path, &ndim));
    PetscCall(SlipH5GetSize(h, path, 1, &size));
    PetscCheck(ndim == 1 + wide && (!wide || size == dims[0]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s has other numbers in a row than the %" PetscInt_FMT " of this run%s", path, h->target,
               t->entries[c], h->source);
  }
  t->room = PetscClipInterval(SLIP_TABLE_NUMBERS / numbers, 1, SLIP_TABLE_ROWS);
  PetscCall(PetscMalloc1((size_t)numbers * (size_t)t->room, &t->value));
  if (!group[0]) PetscFunctionReturn(PETSC_SUCCESS); /* the root has groups as well */
  PetscCall(SlipH5CountMembers(h, group, &found));
  PetscCall(SlipH5CountAxes(h, group, &axes));
  PetscCheck(found - axes == ncolumns, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has %" PetscInt_FMT " datasets, expected the %" PetscInt_FMT " of this run%s", group, h->target,
             found - axes, ncolumns, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableFlush(SlipTable *t, SlipH5 *h)
{
  char path[SLIP_TABLE_COLUMNS][128];
  SlipH5Rows series[SLIP_TABLE_COLUMNS];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < t->ncolumns; c++) {
    PetscCall(PetscSNPrintf(path[c], sizeof(path[c]), "%s/%s", t->group, t->column[c].name));
    series[c] = (SlipH5Rows){path[c], t->value + (size_t)t->first[c] * (size_t)t->room, 1};
  }
  PetscCall(SlipH5AppendAll(h, t->ncolumns, series, t->nrows));
  t->written += t->nrows;
  t->nrows = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableAdd(SlipTable *t, SlipH5 *h, const PetscReal row[])
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < t->ncolumns; c++) {
    PetscReal *column = t->value + (size_t)t->first[c] * (size_t)t->room;

    PetscCall(PetscArraycpy(column + (size_t)t->entries[c] * t->nrows, row + t->first[c], t->entries[c]));
  }
  if (++t->nrows == t->room) PetscCall(SlipTableFlush(t, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableDestroy(SlipTable *t)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(t->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
