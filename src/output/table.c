/* Tables of an output file: rows collected in memory, appended to HDF5 in blocks. */
#include <slipstep/private/slipoutput.h>
#include <slipcompat.h>

/* One series group/name per column; group "" is the root. Rank 0 only, as the rest of this file. */
PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                               const SlipOutputColumn column[], const PetscInt entries[], PetscInt rows)
{
  char path[128];
  PetscInt found, numbers = 0, ndim, size;

  PetscFunctionBegin;
  PetscCheck(ncolumns <= SLIP_TABLE_COLUMNS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " columns in %s, expected at most %d", ncolumns, group, SLIP_TABLE_COLUMNS);
  PetscCall(PetscStrncpy(t->group, group, sizeof(t->group)));
  t->ncolumns = ncolumns;
  t->nrows = 0;
  t->written = PetscMax(rows, 0);
  for (PetscInt c = 0; c < ncolumns; c++) {
    const PetscInt wide = entries && entries[c] ? 1 : 0;

    t->column[c] = column[c];
    t->entries[c] = wide ? entries[c] : 1;
    t->first[c] = numbers;
    numbers += t->entries[c];
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, column[c].name));
    if (rows < 0) {
      PetscCall(SlipH5CreateSeries(h, path, wide, t->entries + c, column[c].integer, column[c].unit));
      continue;
    }
    PetscCall(SlipH5SetRows(h, path, rows));
    PetscCall(SlipH5GetRank(h, path, &ndim));
    PetscCall(SlipH5GetSize(h, path, 1, &size));
    PetscCheck(ndim == 1 + wide && (!wide || size == t->entries[c]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s has other numbers in a row than the %" PetscInt_FMT " of this run%s", path, h->name,
               t->entries[c], h->source);
  }
  PetscCall(PetscMalloc1((size_t)numbers * SLIP_TABLE_ROWS, &t->value));
  if (!group[0]) PetscFunctionReturn(PETSC_SUCCESS); /* the root has groups as well */
  PetscCall(SlipH5CountMembers(h, group, &found));
  PetscCheck(found == ncolumns, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has %" PetscInt_FMT " datasets, expected the %" PetscInt_FMT " of this run%s", group, h->name,
             found, ncolumns, h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableFlush(SlipTable *t, SlipH5 *h)
{
  char path[SLIP_TABLE_COLUMNS][128];
  SlipH5Rows series[SLIP_TABLE_COLUMNS];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < t->ncolumns; c++) {
    PetscCall(PetscSNPrintf(path[c], sizeof(path[c]), "%s/%s", t->group, t->column[c].name));
    series[c] = (SlipH5Rows){path[c], t->value + (size_t)t->first[c] * SLIP_TABLE_ROWS, 1};
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
    PetscReal *column = t->value + (size_t)t->first[c] * SLIP_TABLE_ROWS;

    PetscCall(PetscArraycpy(column + (size_t)t->entries[c] * t->nrows, row + t->first[c], t->entries[c]));
  }
  if (++t->nrows == SLIP_TABLE_ROWS) PetscCall(SlipTableFlush(t, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableDestroy(SlipTable *t)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(t->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
