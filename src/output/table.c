/* Tables of an output file: rows collected in memory, appended to HDF5 in blocks. */
#include <slipstep/private/slipoutput.h>
#include <slipcompat.h>

/* One series group/name per column; group "" is the root. Rank 0 only, as the rest of this file. */
PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                               const SlipOutputColumn column[], const PetscInt entries[], PetscInt rows)
{
  char path[128];
  PetscInt found, numbers = 0;

  PetscFunctionBegin;
  PetscCheck(ncolumns <= SLIP_TABLE_COLUMNS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " columns in %s, expected at most %d", ncolumns, group, SLIP_TABLE_COLUMNS);
  PetscCall(PetscStrncpy(t->group, group, sizeof(t->group)));
  t->ncolumns = ncolumns;
  t->nrows = 0;
  t->written = PetscMax(rows, 0);
  for (PetscInt c = 0; c < ncolumns; c++) {
    const PetscInt ndim = entries && entries[c] ? 1 : 0;

    t->column[c] = column[c];
    t->entries[c] = ndim ? entries[c] : 1;
    t->first[c] = numbers;
    numbers += t->entries[c];
    PetscCheck(numbers <= SLIP_TABLE_COLUMNS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "%" PetscInt_FMT " numbers in a row of %s, expected at most %d", numbers, group, SLIP_TABLE_COLUMNS);
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, column[c].name));
    if (rows < 0)
      PetscCall(SlipH5CreateSeries(h, path, ndim, t->entries + c, column[c].integer, column[c].unit));
    else
      PetscCall(SlipH5SetRows(h, path, rows));
  }
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
    series[c] = (SlipH5Rows){path[c], t->value[t->first[c]], 1};
  }
  PetscCall(SlipH5AppendAll(h, t->ncolumns, series, t->nrows));
  t->written += t->nrows;
  t->nrows = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableAdd(SlipTable *t, SlipH5 *h, const PetscReal row[])
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < t->ncolumns; c++)
    PetscCall(PetscArraycpy(&t->value[t->first[c]][0] + t->entries[c] * t->nrows, row + t->first[c], t->entries[c]));
  if (++t->nrows == SLIP_TABLE_ROWS) PetscCall(SlipTableFlush(t, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
