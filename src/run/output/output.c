/* Writes the output of a run of any TS problem: the monitor fills /series, and the end prints the summary. */
#include <slipstep/private/sliprunoutput.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipadapt.h>
#include <petsc/private/petscimpl.h>
#include <petsctime.h>
#include <math.h>

/* The TS has its output under this name. Its monitors look for it there, as they outlive the output. */
static const char key[] = SLIP_OUTPUT_KEY, key_monitored[] = "SlipOutputMonitored";

/* Gets the borrowed static reaction of the state, which the next step starts from; NULL when the integrator has none.
   The reaction of the last step's end costs nothing, but contains the impulse that stopped a cell. With moving_only
   that one suffices, and before the first step there is none: NULL, as moving cells then have the strength of their
   state. */
static PetscErrorCode SlipOutputReaction(SlipOutput out, PetscReal t, Vec w, Vec *r)
{
  PetscBool bathe;
  SlipConstraint con = NULL;
  Vec accepted;

  PetscFunctionBegin;
  *r = NULL;
  PetscCall(TSBatheIs(out->ts, &bathe));
  if (bathe) PetscCall(TSBatheGetConstraint(out->ts, &con));
  if (!con) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheGetReaction(out->ts, &accepted));
  if (out->moving_only && out->started) *r = accepted;
  if (out->moving_only) PetscFunctionReturn(PETSC_SUCCESS);
  if (!out->reaction) PetscCall(VecDuplicate(accepted, &out->reaction));
  PetscCall(SlipConstraintInitialReaction(con, t, w, out->reaction));
  *r = out->reaction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: adds a row with the time and no values to tables without a row of the start, so that their rows match
   those of /series. */
static PetscErrorCode SlipOutputFillTables(SlipOutput out, PetscReal time)
{
  PetscFunctionBegin;
  for (SlipTable *t = out->more; t < out->more + out->nmore; t++) {
    const PetscInt last = t->ncolumns - 1, n = t->first[last] + t->entries[last];
    PetscReal *row;

    if (t->written || t->nrows) continue;
    PetscCall(PetscMalloc1(n, &row));
    for (PetscInt k = 0; k < n; k++) row[k] = k ? (PetscReal)NAN : time;
    PetscCall(SlipTableAdd(t, &out->file, row));
    PetscCall(PetscFree(row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSMonitor: creates the file when TSSolve() starts, and adds a row of /series for the start and each accepted step. */
static PetscErrorCode SlipOutputStepMonitor(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipOutput out;
  Vec r = NULL;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  (void)ctx;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &out));
  if (step < 0 || !out || !out->wanted || out->closed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(out));
  PetscCall(SlipOutputAttemptsStep(out, step, time));
  if (out->started ? step != out->last_step : !out->start_known) {
    PetscCall(SlipOutputReaction(out, time, w, &r));
    out->numbers[0] = time;
    PetscCall((*out->row)(ts, time, w, r, out->numbers + 1, out->ctx));
    if (!out->rank && !out->started) ierr = SlipOutputFillTables(out, time);
    if (!out->rank && !ierr) ierr = SlipOutputRow(out, &out->series, out->numbers);
  }
  out->started = PETSC_TRUE;
  out->last_step = step;
  PetscCall(PetscTime(&out->attempts.begin));
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(out->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipOutputCreate - creates an HDF5 file for the steps and states of a TS

  Collective; after the type of ts is set, before TSSolve().

  Input Parameters:
+ ts     - the TS
. file   - name of the file; NULL or empty: no file, SlipOutputFinish() then only prints
. n      - columns of /series besides time, at most 31
. column - their names and units [n]
. row    - function that computes a row
- ctx    - context of row

  Output Parameter:
. output - the output; SlipOutputFinish() ends it

  Level: intermediate

  Errors: PETSC_ERR_FILE_OPEN when the file cannot be created

  Notes:
  /steps gets a row per attempt, /series one for the start and one per accepted step. The content goes to FILE.part,
  created at the start of TSSolve(), which SlipOutputFinish() renames to FILE: a run that fails leaves an older FILE as
  it was. FILE.part can be read during the run and after it was killed: it has whole rows, and its attribute
  "complete" is 0. One with rows is not overwritten, see SlipOutputSetOption().

  The row of the start has the state that TSSolve() begins with. The reaction in a row is the static one of the state,
  which the next step starts from: where something has just come to rest it does not contain the impulse that stopped
  it.

.seealso: SlipOutputSetOption(), SlipOutputResume(), SlipOutputAddResult(), SlipOutputFinish()
@*/
PetscErrorCode SlipOutputCreate(TS ts, const char file[], PetscInt n, const SlipOutputColumn column[],
                                SlipOutputRowFn row, void *ctx, SlipOutput *output)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)ts);
  SlipOutput out;
  void *other, *monitored;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCheck(n >= 0 && n < SLIP_TABLE_COLUMNS, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " columns of /series, expected 0 to %d", n, SLIP_TABLE_COLUMNS - 1);
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &other));
  PetscCheck(!other, comm, PETSC_ERR_ORDER, "the output of the last run was not finished");
  PetscCall(PetscNew(&out));
  *output = out;
  out->ts = ts;
  PetscCall(SlipClockGet(ts, &out->clock));
  out->comm = comm;
  out->row = row;
  out->ctx = ctx;
  out->file.id = -1;
  out->kind = (SlipH5Kind){.growing = PETSC_TRUE, .first = 1};
  PetscCall(PetscTime(&out->begin));
  out->wanted = file && file[0] ? PETSC_TRUE : PETSC_FALSE;
  PetscCallMPI(MPI_Comm_rank(comm, &out->rank));
  PetscCall(SlipObjectComposeData((PetscObject)ts, key, out, NULL));
  PetscCall(PetscObjectQuery((PetscObject)ts, key, (PetscObject *)&out->box));
  PetscCall(PetscObjectReference((PetscObject)out->box));
  if (!out->wanted) PetscFunctionReturn(PETSC_SUCCESS);

  PetscCall(PetscStrncpy(out->name, file, sizeof(out->name)));
  if (!out->rank) ierr = SlipH5CheckCreateKind(&(SlipH5Kind){0}, file);
  PetscCall(SlipErrorBcast(comm, ierr));
  out->ncolumns = n + 1;
  out->column[0] = (SlipOutputColumn){"time", "s", PETSC_FALSE};
  PetscCall(PetscArraycpy(out->column + 1, column, n));

  /* monitors are set once for a TS, for all its runs */
  PetscCall(SlipObjectQueryData((PetscObject)ts, key_monitored, &monitored));
  if (monitored) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSMonitorSet(ts, SlipOutputStepMonitor, NULL, NULL));
  PetscCall(SlipOutputAttemptsStart(ts));
  PetscCall(SlipObjectComposeData((PetscObject)ts, key_monitored, ts, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipOutputSetOption - sets the name of the option for the file, for messages

  Logically collective; before TSSolve()

  Input Parameters:
+ output    - the output
. prefix    - options prefix, or NULL
. option    - name of the option without dash and prefix
- overwrite - allows to overwrite the rows of an unfinished FILE.part of an earlier run; a program with an option for
              this calls it as the message about such a file does: option_overwrite

  Level: intermediate

.seealso: SlipOutputCreate()
@*/
PetscErrorCode SlipOutputSetOption(SlipOutput output, const char prefix[], const char option[], PetscBool overwrite)
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(output->prefix, prefix ? prefix : "", sizeof(output->prefix)));
  PetscCall(PetscStrncpy(output->option, option, sizeof(output->option)));
  output->kind.prefix = output->prefix;
  output->kind.option = output->option;
  output->kind.overwrite = overwrite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes all rows to the disk, and counts them, for a checkpoint. steps: rows of /steps that the file has now, 0 where
   there is no file. Errors: PETSC_ERR_FILE_WRITE when the rows cannot be written. */
PetscErrorCode SlipOutputSync(SlipOutput output, PetscInt *steps, PetscInt *series)
{
  PetscInt rows[2] = {0, 0};
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(output));
  if (SlipOutputFile(output)) {
    ierr = SlipOutputFlush(output);
    if (!ierr) ierr = SlipH5Sync(&output->file);
    rows[0] = output->steps.written;
    rows[1] = output->series.written;
  }
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(output->comm, ierr));
  PetscCallMPI(MPI_Bcast(rows, 2, MPIU_INT, 0, output->comm));
  *steps = rows[0];
  *series = rows[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Continues the file of an earlier run. output: the output, with the name and the columns of the earlier run's; steps:
   rows of /steps that stay, as SlipOutputSync() counted them; series: rows of /series that stay. The file is FILE.part
   or, when there is none, FILE of a run that has ended, which stays as it is until this run ends too. A copy is cut,
   and replaces FILE.part when it is complete. TSSolve() then writes no row for the state that it starts from, unless
   series is 0. Wall times of /run and /result continue, and the attribute restarts of /run counts. Without a file name
   the function does nothing. Errors: PETSC_ERR_FILE_OPEN when there is neither file or another program is writing it,
   PETSC_ERR_FILE_UNEXPECTED when it has fewer rows or other datasets, PETSC_ERR_FILE_WRITE when it cannot be copied. */
PetscErrorCode SlipOutputResume(SlipOutput output, PetscInt steps, PetscInt series)
{
  PetscFunctionBegin;
  PetscCheck(!output->begun, output->comm, PETSC_ERR_ORDER, "the run has begun");
  PetscCheck(steps >= 0 && series >= 0, output->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " and %" PetscInt_FMT " rows to keep, expected no negative number", steps, series);
  output->resumed = PETSC_TRUE;
  output->resume_steps = steps;
  output->resume_series = series;
  output->start_known = series > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(output));
  PetscCall(SlipLogOutputEnd());
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipOutputAdd(SlipOutput out, SlipOutputNumber list[], PetscInt *n, const char name[],
                                    const char label[], const char unit[], PetscReal value)
{
  SlipOutputNumber *number = &list[*n];

  PetscFunctionBegin;
  PetscCheck(*n < SLIP_OUTPUT_NUMBERS, out->comm, PETSC_ERR_ARG_OUTOFRANGE, "at most %d numbers, %s is one more",
             SLIP_OUTPUT_NUMBERS, name);
  PetscCall(PetscStrncpy(number->name, name, sizeof(number->name)));
  PetscCall(PetscStrncpy(number->label, label ? label : "", sizeof(number->label)));
  PetscCall(PetscStrncpy(number->unit, unit ? unit : "", sizeof(number->unit)));
  number->value = value;
  (*n)++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipOutputAddResult - adds a result of the run to /result and the summary

  Logically collective

  Input Parameters:
+ output - the output
. name   - name of the attribute of /result
. label  - name in the summary, NULL to omit it there
. unit   - printed after it, NULL for none
- value  - the number, in that unit; NaN: unknown, the summary prints unit instead and /result has no attribute

  Level: intermediate

.seealso: SlipOutputCreate(), SlipOutputFinish()
@*/
PetscErrorCode SlipOutputAddResult(SlipOutput output, const char name[], const char label[], const char unit[],
                                   PetscReal value)
{
  PetscFunctionBegin;
  PetscCall(SlipOutputAdd(output, output->result, &output->nresults, name, label, unit, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipOutputAddRun - adds a number that describes the run, an attribute of /run

  Logically collective

  Input Parameters:
+ output - the output
. name   - name of the attribute
- value  - the number, in SI units

  Level: intermediate

.seealso: SlipOutputCreate(), SlipOutputFinish()
@*/
PetscErrorCode SlipOutputAddRun(SlipOutput output, const char name[], PetscReal value)
{
  PetscFunctionBegin;
  PetscCall(SlipOutputAdd(output, output->run, &output->nrun, name, NULL, NULL, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputClose(SlipOutput out)
{
  SlipOutputTotals *t = &out->totals;
  PetscInt attempts, decisions, outside, halvings;
  PetscBool bathe, learned, handed;
  PetscReal time;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(out->ts, &bathe));
  if (bathe) {
    PetscCall(TSBatheGetTotals(out->ts, &attempts, &t->accepted, &t->solves, &t->newton, &t->linear));
    PetscCall(TSBatheGetExplicitAttempts(out->ts, &t->explicits));
    t->rejected = attempts - t->accepted;
    t->implicit = PETSC_TRUE;
  } else {
    PetscCall(TSGetStepNumber(out->ts, &t->accepted));
    PetscCall(TSGetStepRejections(out->ts, &t->rejected));
    PetscCall(TSGetSNESIterations(out->ts, &t->newton));
    PetscCall(TSGetKSPIterations(out->ts, &t->linear));
    t->implicit = t->newton > 0 ? PETSC_TRUE : PETSC_FALSE;
  }

  /* counts of a policy's guard rails; the summary has those that deserve attention */
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (learned) {
    PetscCall(TSAdaptRLGetCounts(adapt, &decisions, &outside, NULL, &halvings));
    PetscCall(SlipOutputAddResult(out, "policy_decisions", NULL, NULL, decisions));
    PetscCall(
      SlipOutputAddResult(out, "policy_outside_range", outside ? "beyond training range" : NULL, "decisions", outside));
    PetscCall(
      SlipOutputAddResult(out, "policy_halvings", halvings ? "halved after failures" : NULL, "steps", halvings));
    PetscCall(TSAdaptRLGetHandover(adapt, &handed, &time));
    if (handed) {
      TSAdaptType fallback;
      char label[SLIP_OUTPUT_NAME];
      PetscInt steps, all;

      PetscCall(TSAdaptRLGetFallback(adapt, &fallback));
      PetscCall(TSAdaptRLGetHandoverStep(adapt, &steps));
      PetscCall(TSGetStepNumber(out->ts, &all));
      PetscCall(SlipOutputAddResult(out, "policy_steps", "steps by the policy", NULL, steps));
      PetscCall(PetscSNPrintf(label, sizeof(label), "steps by %s", fallback));
      PetscCall(SlipOutputAddResult(out, "heir_steps", label, NULL, all - steps));
      PetscCall(PetscSNPrintf(label, sizeof(label), "handed to %s at", fallback));
      PetscCall(SlipOutputAddResult(out, "policy_handover_time", label, "s", time));
    }
  }
  out->closed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipOutputPrint(SlipOutput out, const SlipOutputTotals *t)
{
  PetscFunctionBegin;
  PetscCall(PetscPrintf(out->comm, "%-24s %" PetscInt_FMT "\n", "accepted steps:", t->accepted));
  PetscCall(PetscPrintf(out->comm, "%-24s %" PetscInt_FMT "\n", "rejected steps:", t->rejected));
  if (t->implicit) {
    PetscCall(PetscPrintf(out->comm, "%-24s %" PetscInt_FMT "%s", "Bathe solves:", t->solves,
                          t->solves < t->accepted + t->rejected ? " (steps at rest need none)" : ""));
    if (t->explicits)
      PetscCall(PetscPrintf(out->comm, " (%" PetscInt_FMT " of them explicit, without a solve)", t->explicits));
    PetscCall(PetscPrintf(out->comm, "\n"));
    PetscCall(PetscPrintf(out->comm, "%-24s %" PetscInt_FMT "\n", "Newton iterations:", t->newton));
    PetscCall(PetscPrintf(out->comm, "%-24s %" PetscInt_FMT "\n", "linear iterations:", t->linear));
  }
  for (PetscInt i = 0; i < out->nresults; i++) {
    const SlipOutputNumber *r = &out->result[i];
    char label[SLIP_OUTPUT_NAME + 1];

    if (!r->label[0]) continue;
    PetscCall(PetscSNPrintf(label, sizeof(label), "%s:", r->label));
    if (PetscIsNanReal(r->value))
      PetscCall(PetscPrintf(out->comm, "%-24s %s\n", label, r->unit));
    else
      PetscCall(PetscPrintf(out->comm, r->value == PetscFloorReal(r->value) ? "%-24s %.0f%s%s\n" : "%-24s %.7g%s%s\n",
                            label, (double)r->value, r->unit[0] ? " " : "", r->unit)); /* counts have all digits */
  }
  PetscCall(PetscPrintf(out->comm, "%-24s %.4f s\n", "wall time of set-up:", (double)t->wall_setup));
  PetscCall(PetscPrintf(out->comm, "%-24s %.4f s\n", "wall time of the solve:", (double)t->wall_solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipOutputFinish - completes the file of a run and prints its summary

  Collective; after TSSolve().

  Input Parameters:
+ output     - the output; set to NULL
. wall_setup - wall time of set-up [s]
- wall_solve - wall time of TSSolve() [s]

  Level: intermediate

.seealso: SlipOutputCreate(), SlipOutputAddResult()
@*/
PetscErrorCode SlipOutputFinish(SlipOutput *output, PetscReal wall_setup, PetscReal wall_solve)
{
  SlipOutput out = *output;
  SlipOutputTotals totals;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!out->closed) PetscCall(SlipOutputClose(out));
  totals = out->totals;
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(out));
  totals.wall_setup = out->setup_before + wall_setup;
  totals.wall_solve = out->solve_before + wall_solve;
  PetscCallMPI(MPI_Bcast(&totals.wall_setup, 1, MPIU_REAL, 0, out->comm));
  PetscCallMPI(MPI_Bcast(&totals.wall_solve, 1, MPIU_REAL, 0, out->comm));
  if (SlipOutputFile(out)) {
    ierr = SlipOutputFlush(out);
    if (!ierr) ierr = SlipOutputFinishFile(out, &totals);
  }
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(out->comm, ierr));
  PetscCall(SlipOutputPrint(out, &totals));
  PetscCall(SlipOutputDestroy(output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipOutputDestroy - closes the output of a run that did not finish: FILE.part stays with its rows, and FILE as it was

  Collective

  Input Parameter:
. output - the output; set to NULL

  Level: intermediate

.seealso: SlipOutputFinish()
@*/
PetscErrorCode SlipOutputDestroy(SlipOutput *output)
{
  SlipOutput out = *output;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscInt owners;

  PetscFunctionBegin;
  if (!out) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectGetReference((PetscObject)out->box, &owners));
  if (owners == 1) out->policy_known = PETSC_TRUE; /* the TS was destroyed before, and has no policy any more */
  if (out->file.id > 0) {
    if (out->file.live) ierr = SlipOutputFlush(out);
    if (!ierr) ierr = SlipH5Abandon(&out->file);
  }
  if (out->wanted) PetscCall(SlipErrorBcast(out->comm, ierr));
  PetscCall(VecDestroy(&out->reaction));
  PetscCall(SlipTableDestroy(&out->steps));
  PetscCall(SlipTableDestroy(&out->series));
  for (PetscInt k = 0; k < out->nmore && !out->rank; k++) PetscCall(SlipTableDestroy(&out->more[k]));
  PetscCall(PetscFree(out->more));
  PetscCall(PetscFree(out->numbers));
  PetscCall(PetscContainerSetPointer(out->box, NULL)); /* the TS, if it still exists, owns the box */
  PetscCall(PetscContainerDestroy(&out->box));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(PETSC_SUCCESS);
}
