/* Collects rows of an output file's tables in memory, and appends them to HDF5 in blocks. */
#include <slipstep/private/sliprunoutput.h>
#include <slipcompat.h>
#include <slipstep/private/slipwork.h>

PetscErrorCode SlipTableRest(const SlipClock *clock, SlipH5 *h, const char path[], PetscInt wide, const PetscInt dims[],
                             PetscInt rows, PetscBool *has)
{
  PetscBool there = PETSC_FALSE;

  PetscFunctionBegin;
  if (rows >= 0) PetscCall(SlipH5Has(h, path, &there));
  *has = there || (clock && clock->is_long) ? PETSC_TRUE : PETSC_FALSE;
  if (there)
    PetscCall(SlipH5SetRows(h, path, rows));
  else if (*has) {
    PetscCall(SlipH5CreateSeries(h, path, wide, dims, NULL, "s"));
    PetscCall(SlipH5AppendZeros(h, path, rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt Columns(const SlipTable *t)
{
  return t->ncolumns + (t->rests ? t->ntimes : 0);
}

/* Creates a series group/name per column; group "" is the root. Rank 0 only, as the rest of this file. */
PetscErrorCode SlipTableCreate(SlipTable *t, SlipH5 *h, const char group[], PetscInt ncolumns,
                               const SlipOutputColumn column[], const PetscInt entries[], PetscInt rows)
{
  char path[128];
  PetscInt found, numbers = 0, size;

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
    t->wide[c] = wide;
    numbers += t->entries[c];
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, column[c].name));
    if (rows < 0) {
      PetscCall(
        SlipH5CreateSeries(h, path, wide, dims, &(SlipH5Storage){.integer = column[c].integer}, column[c].unit));
      continue;
    }
    PetscCall(SlipH5SetRows(h, path, rows));
    PetscCall(SlipH5GetRank(h, path, &ndim));
    PetscCall(SlipH5GetSize(h, path, 1, &size));
    PetscCheck(ndim == 1 + wide && (!wide || size == dims[0]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s has other numbers in a row than the %" PetscInt_FMT " of this run%s", path, h->target,
               t->entries[c], h->source);
  }
  /* columns for the rests of times beyond a double */
  for (PetscInt k = 0; k < t->ntimes; k++) {
    const PetscInt c = t->times[k], all = t->ncolumns + k, n = t->entries[c];

    PetscCall(PetscSNPrintf(t->rest[k], sizeof(t->rest[k]), "%s_rest", t->column[c].name));
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", t->group, t->rest[k]));
    PetscCall(SlipTableRest(t->clock, h, path, t->wide[c], &n, rows, &t->rests));
    t->entries[all] = n;
    t->first[all] = numbers;
    numbers += n;
  }
  t->room = PetscClipInterval(SLIP_TABLE_NUMBERS / numbers, 1, SLIP_TABLE_ROWS);
  PetscCall(PetscMalloc1((size_t)numbers * (size_t)t->room, &t->value));
  if (!group[0]) PetscFunctionReturn(PETSC_SUCCESS); /* the root has groups as well */
  PetscCall(SlipH5CountMembers(h, group, &found));
  PetscCheck(found == Columns(t), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s in %s has %" PetscInt_FMT " datasets, expected the %" PetscInt_FMT " of this run%s", group, h->target,
             found, Columns(t), h->source);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableFlush(SlipTable *t, SlipH5 *h)
{
  char path[SLIP_TABLE_ALL][128];
  SlipH5Rows series[SLIP_TABLE_ALL];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < Columns(t); c++) {
    /* tables move in memory as others are added: no pointer may refer into its own table */
    const char *name = c < t->ncolumns ? t->column[c].name : t->rest[c - t->ncolumns];

    PetscCall(PetscSNPrintf(path[c], sizeof(path[c]), "%s/%s", t->group, name));
    series[c] = (SlipH5Rows){path[c], t->value + (size_t)t->first[c] * (size_t)t->room, 1};
  }
  PetscCall(SlipH5AppendAll(h, Columns(t), series, t->nrows));
  t->written += t->nrows;
  t->nrows = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipTableAdd(SlipTable *t, SlipH5 *h, const PetscReal row[])
{
  PetscFunctionBegin;
  SlipWorkAdd(SLIP_WORK_NUMBER, (PetscReal)(t->first[t->ncolumns - 1] + t->entries[t->ncolumns - 1]));
  for (PetscInt c = 0; c < t->ncolumns; c++) {
    PetscReal *column = t->value + (size_t)t->first[c] * (size_t)t->room;

    PetscCall(PetscArraycpy(column + (size_t)t->entries[c] * t->nrows, row + t->first[c], t->entries[c]));
  }
  for (PetscInt k = 0; k < t->ntimes && t->rests; k++) {
    const PetscInt c = t->times[k], n = t->entries[c], all = t->ncolumns + k;
    PetscReal *time = t->value + (size_t)t->first[c] * (size_t)t->room + (size_t)n * t->nrows,
              *rest = t->value + (size_t)t->first[all] * (size_t)t->room + (size_t)n * t->nrows;

    for (PetscInt i = 0; i < n; i++) time[i] = SlipTwoSum(t->clock->origin, time[i], &rest[i]);
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
