/* Creates the file of a run with its tables, and appends to them. */
#include <slipstep/private/sliprunoutput.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>
#include <petsctime.h>

static const SlipOutputColumn StepColumns[] = {
  {.name = "time", .unit = "s"},
  {.name = "dt", .unit = "s"},
  {.name = "accepted", .integer = PETSC_TRUE},
  {.name = "error", .unit = "1"},
  {.name = "converged", .integer = PETSC_TRUE},
  {.name = "newton_iterations", .integer = PETSC_TRUE},
  {.name = "linear_iterations", .integer = PETSC_TRUE},
  {.name = "solves", .integer = PETSC_TRUE},
  {.name = "method", .integer = PETSC_TRUE},
  {.name = "right_hand_sides", .integer = PETSC_TRUE},
  {.name = "products_k", .integer = PETSC_TRUE},
  {.name = "products_h", .integer = PETSC_TRUE},
  {.name = "products_pc", .integer = PETSC_TRUE},
  {.name = "cost", .unit = "s"},
  {.name = "residual", .unit = "1"},
  {.name = "reason", .integer = PETSC_TRUE},
  {.name = "wall", .unit = "s"},
};

static const PetscInt TimeColumn = 0; /* column of built-in tables, and of others if it is named time */

SlipH5 *SlipOutputFile(SlipOutput out)
{
  return out->begun && !out->rank ? &out->file : NULL;
}

/* On rank 0: opens the file with /run, /result and the tables; the problem adds to this layout afterwards. */
static PetscErrorCode SlipOutputOpen(SlipOutput out)
{
  SlipH5 *h = &out->file;

  PetscFunctionBegin;
  if (out->resumed)
    PetscCall(SlipH5CreateCopy(&out->kind, NULL, out->name, h));
  else
    PetscCall(SlipH5CreateKind(&out->kind, out->name, h));
  PetscCall(SlipOutputRun(out));
  out->steps = out->series = (SlipTable){.clock = out->clock, .times = &TimeColumn, .ntimes = 1};
  PetscCall(SlipTableCreate(&out->steps, h, "/steps", PETSC_STATIC_ARRAY_LENGTH(StepColumns), StepColumns, NULL,
                            out->resumed ? out->resume_steps : -1));
  PetscCall(SlipTableCreate(&out->series, h, "/series", out->ncolumns, out->column, out->entries,
                            out->resumed ? out->resume_series : -1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipOutputAddTable - adds a table with a row for each row of /series

  Collective; while the file of a run is created, as in the function layout of a SlipFaultObserver

  Input Parameters:
+ output  - the output
. group   - group of its datasets, such as "/stations/0"
. n       - columns, at most 40; the first is usually time
. column  - their names and units [n]; the strings are borrowed
- entries - numbers of a column in a row [n]: m for a dataset [rows, m], 0 for one number and [rows], -m for
            m vectors of 3 numbers and [rows, m, 3]; NULL: one number in each

  Output Parameter:
. table - its number, for SlipOutputAddRows()

  Level: advanced

  Notes:
  The file of a run that continues has the table already, and it is cut to the rows of the checkpoint.
  SlipOutputAddRows() is called before each row of /series: for the start and for each accepted step. Without a call the
  start has a row of its time and NaN.

  Times in a first column named time are those of the TS in rows, and of the run in the file, see `TSGetSlipOrigin()`.

  Errors: PETSC_ERR_FILE_UNEXPECTED when the file of a run that continues has no such table

.seealso: SlipOutputAddRows(), SlipOutputAddAttribute(), SlipFaultRegisterObserver()
@*/
PetscErrorCode SlipOutputAddTable(SlipOutput out, const char group[], PetscInt n, const SlipOutputColumn column[],
                                  const PetscInt entries[], PetscInt *table)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool timed;

  PetscFunctionBegin;
  PetscCheck(out->begun && !out->started, out->comm, PETSC_ERR_ORDER, "tables are added while the file is made");
  PetscCall(PetscRealloc((size_t)(out->nmore + 1) * sizeof(*out->more), &out->more));
  PetscCall(PetscStrcmp(column[0].name, "time", &timed));
  out->more[out->nmore] = (SlipTable){.clock = out->clock, .times = &TimeColumn, .ntimes = timed ? 1 : 0};
  if (!out->rank)
    ierr = SlipTableCreate(&out->more[out->nmore], &out->file, group, n, column, entries,
                           out->resumed ? out->resume_series : -1);
  PetscCall(SlipErrorBcast(out->comm, ierr));
  *table = out->nmore++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipOutputAddRows - adds a row to each of several tables

  Collective; once for each row of /series, before it, as in the functions start and step of a SlipFaultObserver

  Input Parameters:
+ output - the output
. table  - number of the first table
. n      - number of tables that get a row
- row    - their rows one after the other, each with numbers for all columns, in SI units; those of rank 0 are written

  Level: advanced

  Notes:
  A run that continues in its file has the row of the start there, and gets no other one.

  Errors: PETSC_ERR_FILE_WRITE when the file cannot be written

.seealso: SlipOutputAddTable()
@*/
PetscErrorCode SlipOutputAddRows(SlipOutput out, PetscInt table, PetscInt n, const PetscReal row[])
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCheck(table >= 0 && n >= 0 && table + n <= out->nmore, out->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "rows for tables %" PetscInt_FMT " to %" PetscInt_FMT ", there are %" PetscInt_FMT, table, table + n - 1,
             out->nmore);
  if (!out->started && out->start_known) PetscFunctionReturn(PETSC_SUCCESS);
  for (SlipTable *t = out->more + table; !out->rank && t < out->more + table + n && !ierr; t++) {
    const PetscInt last = t->ncolumns - 1;

    ierr = SlipTableAdd(t, &out->file, row);
    row += t->first[last] + t->entries[last];
  }
  PetscCall(SlipErrorBcast(out->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipOutputAddAttribute - adds a number that describes a table of the file

  Collective; while the file is created, after SlipOutputAddTable()

  Input Parameters:
+ output - the output
. group  - group of the table
. name   - name of the attribute
- value  - the number, in SI units

  Level: advanced

  Notes:
  The file of a run that continues has it already, and it stays.

.seealso: SlipOutputAddTable(), SlipOutputAddResult()
@*/
PetscErrorCode SlipOutputAddAttribute(SlipOutput out, const char group[], const char name[], PetscReal value)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!out->rank && !out->resumed) ierr = SlipH5WriteAttrReal(&out->file, group, name, value);
  PetscCall(SlipErrorBcast(out->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes the last rows before an error that ends the program. */
static PetscErrorCode SlipOutputLast(void *ctx)
{
  SlipOutput out = (SlipOutput)ctx;

  PetscFunctionBegin;
  PetscCall(SlipTableFlush(&out->steps, &out->file));
  PetscCall(SlipTableFlush(&out->series, &out->file));
  for (PetscInt k = 0; k < out->nmore; k++) PetscCall(SlipTableFlush(&out->more[k], &out->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: names dimensions. Rows are times; another dimension is of components, or in /series of faults. */
static PetscErrorCode NameDimensions(SlipOutput out)
{
  const SlipH5Axes rows = {.row = "time"}, series = {.row = "time", .rest = "fault_index"};

  PetscFunctionBegin;
  PetscCall(SlipH5NameDimensions(&out->file, "/steps", &rows));
  PetscCall(SlipH5NameDimensions(&out->file, "/series", &series));
  for (PetscInt k = 0; k < out->nmore; k++) PetscCall(SlipH5NameDimensions(&out->file, out->more[k].group, &rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputBegin(SlipOutput out)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscInt numbers = 0;

  PetscFunctionBegin;
  if (!out->wanted || out->begun) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt c = 0; c < out->ncolumns; c++) numbers += PetscMax(out->entries[c], 1);
  PetscCall(PetscCalloc1(numbers, &out->numbers));
  if (!out->rank) ierr = SlipOutputOpen(out);
  PetscCall(SlipErrorBcast(out->comm, ierr));
  out->begun = PETSC_TRUE;
  if (out->layout) PetscCall((*out->layout)(out, out->ctx));
  if (!out->rank && !out->resumed) ierr = NameDimensions(out);
  if (!out->rank && !ierr) ierr = SlipH5Live(&out->file);
  PetscCall(SlipErrorBcast(out->comm, ierr));
  out->file.last = SlipOutputLast;
  out->file.ctx = out;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0, like the next function: writes all rows to the file. */
PetscErrorCode SlipOutputFlush(SlipOutput out)
{
  PetscLogDouble begin;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  PetscCall(SlipOutputLast(out));
  if (!out->policy_known) PetscCall(SlipOutputPolicy(out));
  PetscCall(SlipOutputWall(out));
  PetscCall(SlipH5Flush(&out->file));
  out->file.cost = out->file.flushed - begin; /* with many stations the tables take most of it */
  if (out->flushed) PetscCall((*out->flushed)(out, out->flushed_ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a row, and writes collected rows to the disk from time to time. */
PetscErrorCode SlipOutputRow(SlipOutput out, SlipTable *table, const PetscReal row[])
{
  PetscBool due;

  PetscFunctionBegin;
  PetscCall(SlipTableAdd(table, &out->file, row));
  PetscCall(SlipH5FlushIsDue(&out->file, &due));
  if (due) PetscCall(SlipOutputFlush(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}
