/* Creates the file of a run with its tables, appends to them, and writes the groups /run and /result. */
#include <slipstep/private/sliprunoutput.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipadapt.h>
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

/* ---- /run and /result; on rank 0 only ---- */

/* Writes which policy chooses the steps, if one does. A default policy is loaded only in the first step. */
static PetscErrorCode SlipOutputPolicy(SlipOutput out)
{
  SlipH5 *h = &out->file;
  const char *file = NULL, *hash = NULL;
  SlipPolicy policy = NULL;
  TSAdapt adapt;
  PetscBool learned;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (learned) PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (!policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(policy, &file));
  PetscCall(SlipPolicyGetHash(policy, &hash));
  PetscCall(SlipH5WriteAttrString(h, "/run", "policy", file ? file : ""));
  PetscCall(SlipH5WriteAttrString(h, "/run", "policy_hash", hash ? hash : ""));
  out->policy_known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipOutputRunNumbers(SlipOutput out)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < out->nrun; i++)
    PetscCall(SlipH5WriteAttrReal(&out->file, "/run", out->run[i].name, out->run[i].value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SLIP_OUTPUT_WARNINGS 8192 /* bytes; a longer text is cut */

/* Writes the warnings so far, a line each: those of the set-up at the start, and later ones at the end. */
static PetscErrorCode SlipOutputWarnings(SlipOutput out)
{
  char *text, *old = NULL, before[SLIP_OUTPUT_WARNINGS] = "", all[SLIP_OUTPUT_WARNINGS];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipWarningsTake(&text));
  PetscCall(SlipH5HasAttribute(&out->file, "/run", "warnings", &has));
  if (has) PetscCall(SlipH5ReadAttrString(&out->file, "/run", "warnings", before, sizeof(before)));
  PetscCall(PetscStrstr(before, text, &old)); /* a run that continues repeats its warnings */
  PetscCall(PetscSNPrintf(all, sizeof(all), "%s%s", before, old ? "" : text));
  PetscCall(PetscFree(text));
  PetscCall(SlipH5WriteAttrString(&out->file, "/run", "warnings", all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the wall time since the output was created, with that of earlier runs. A run's end has a better number. */
static PetscErrorCode SlipOutputWall(SlipOutput out)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  PetscCall(SlipH5WriteAttrReal(&out->file, "/run", "wall_time", out->wall + (now - out->begin)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes what is available at the start. A run that continues takes its counts so far from the file. */
static PetscErrorCode SlipOutputRun(SlipOutput out)
{
  SlipH5 *h = &out->file;
  char *options, version[256], host[256], date[64];
  PetscMPIInt size;
  PetscInt restarts = 0;
  TSAdapt adapt;
  TSType type;
  TSAdaptType adapt_type;

  PetscFunctionBegin;
  if (out->resumed) {
    PetscBool ended;

    PetscCall(SlipH5ReadAttrInt(h, "/run", "restarts", &restarts));
    restarts++;
    PetscCall(SlipH5ReadAttrReal(h, "/run", "wall_time", &out->wall));
    PetscCall(SlipH5HasAttribute(h, "/result", "wall_time_solve", &ended));
    if (ended) {
      PetscCall(SlipH5ReadAttrReal(h, "/result", "wall_time_setup", &out->setup_before));
      PetscCall(SlipH5ReadAttrReal(h, "/result", "wall_time_solve", &out->solve_before));
    } else
      out->solve_before = out->wall;
    PetscCall(SlipH5RemoveGroup(h, "/result"));
  }
  PetscCall(SlipH5Group(h, "/run", PETSC_TRUE));
  PetscCall(SlipH5Group(h, "/result", PETSC_TRUE));
  PetscCallMPI(MPI_Comm_size(out->comm, &size));
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(SlipH5WriteAttrString(h, "/run", "options", options));
  PetscCall(PetscFree(options));
  PetscCall(PetscGetVersion(version, sizeof(version)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "petsc_version", version));
  PetscCall(SlipH5WriteAttrString(h, "/run", "slipstep_version", SLIPSTEP_VERSION));
  PetscCall(SlipH5WriteAttrInt(h, "/run", "ranks", size));
  PetscCall(PetscGetHostName(host, sizeof(host)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "host", host));
  PetscCall(PetscGetDate(date, sizeof(date)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "date", date));
  PetscCall(SlipOutputWarnings(out));
  PetscCall(SlipH5WriteAttrInt(h, "/run", "restarts", restarts));
  PetscCall(TSGetType(out->ts, &type));
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(TSAdaptGetType(adapt, &adapt_type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_type", type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_adapt_type", adapt_type ? adapt_type : ""));
  PetscCall(SlipOutputPolicy(out));
  PetscCall(SlipOutputRunNumbers(out));
  PetscCall(SlipOutputWall(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputFinishFile(SlipOutput out, const SlipOutputTotals *t)
{
  SlipH5 *h = &out->file;

  PetscFunctionBegin;
  PetscCall(SlipOutputPolicy(out));
  PetscCall(SlipOutputRunNumbers(out));
  PetscCall(SlipOutputWarnings(out));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "wall_time", t->wall_setup + t->wall_solve));
  for (PetscInt i = 0; i < out->nresults; i++)
    if (!PetscIsNanReal(out->result[i].value))
      PetscCall(SlipH5WriteAttrReal(h, "/result", out->result[i].name, out->result[i].value));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "accepted", t->accepted));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "rejected", t->rejected));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "solves", t->solves));
  if (t->implicit) PetscCall(SlipH5WriteAttrInt(h, "/result", "explicit_attempts", t->explicits));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "newton_iterations", t->newton));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "linear_iterations", t->linear));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_setup", t->wall_setup));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_solve", t->wall_solve));
  PetscCall(SlipH5Close(h)); /* the file takes its final name */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the file ---- */

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
