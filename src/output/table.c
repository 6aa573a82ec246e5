/* Tables of an output file: rows collected in memory, appended to HDF5 in blocks. */
#include <slipstep/private/slipoutput.h>
#include <slipcompat.h>

/* One series group/name per column. Rank 0 only, as the rest of this file. */
PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                               const SlipOutputColumn column[])
{
  char path[128];

  PetscFunctionBegin;
  PetscCheck(ncolumns <= SLIP_TABLE_COLUMNS, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " columns in %s, expected at most %d", ncolumns, group, SLIP_TABLE_COLUMNS);
  t->group = group;
  t->ncolumns = ncolumns;
  t->nrows = 0;
  for (PetscInt c = 0; c < ncolumns; c++) {
    t->column[c] = column[c];
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, column[c].name));
    PetscCall(SlipH5CreateSeries(h, path, 0, NULL, column[c].integer, column[c].unit));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableFlush(SlipTable *t, SlipH5 *h)
{
  char path[128];
  PetscReal values[SLIP_TABLE_ROWS];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < t->ncolumns && t->nrows; c++) {
    for (PetscInt i = 0; i < t->nrows; i++) values[i] = t->row[i][c];
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", t->group, t->column[c].name));
    PetscCall(SlipH5Append(h, path, t->nrows, values));
  }
  t->nrows = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableAdd(SlipTable *t, SlipH5 *h, const PetscReal row[])
{
  PetscFunctionBegin;
  PetscCall(PetscArraycpy(t->row[t->nrows], row, t->ncolumns));
  if (++t->nrows == SLIP_TABLE_ROWS) PetscCall(SlipTableFlush(t, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
