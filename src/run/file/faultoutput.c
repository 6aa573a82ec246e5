/* Writes -fault_output: the file of a run, with /series, and /fields for the start and for the steps after which they
   are due. */
#include <slipstep/private/sliprunfiles.h>

/* Creates the observer also without -fault_output, as checkpoints store the cost of a run. */
static PetscErrorCode OutputCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  SlipFaultOutput out;
  SlipH5Kind kind;
  PetscErrorCode ierr = PETSC_SUCCESS;
  Vec w;

  PetscFunctionBegin;
  (void)wanted;
  PetscCall(SlipFaultOutputWhenCheck(fault));
  PetscCall(PetscNew(&out));
  *ctx = out;
  out->fault = fault;
  out->ts = ts;
  fault->run->entries = 0;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &out->rank));
  if (!fault->options.text[FAULT_OUTPUT][0]) PetscFunctionReturn(PETSC_SUCCESS);
  kind = (SlipH5Kind){.prefix = SlipFaultPrefix(fault), .option = "fault_output"};
  if (!out->rank) ierr = SlipH5CheckCreateKind(&kind, fault->options.text[FAULT_OUTPUT]);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(SlipFaultOutputCreateRun(out, ts));
  PetscCall(SlipFaultOutputSize(out, ts));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultGatherCreate(&fault->mesh, w, &out->gather_w, &out->w0));
  PetscCall(SlipFaultGatherCreate(&fault->mesh, fault->critical.uc, &out->gather_r, &out->r0));
  PetscCall(SlipFaultGatherCreate(&fault->mesh, fault->cells, &out->gather_c, &out->c0));
  PetscCall(VecDestroy(&w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OutputDestroy(void **ctx)
{
  SlipFaultOutput out = (SlipFaultOutput)*ctx;

  PetscFunctionBegin;
  PetscCall(SlipOutputDestroy(&out->fault->run->file)); /* the file of a run that did not finish */
  PetscCall(VecScatterDestroy(&out->gather_w));
  PetscCall(VecScatterDestroy(&out->gather_r));
  PetscCall(VecScatterDestroy(&out->gather_c));
  {
    Vec *vecs[] = {&out->w0,      &out->r0,     &out->c0,    &out->p0,    &out->n0,
                   &out->numbers, &out->start0, &out->shown, &out->vinf0, &out->when.entry_u};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  }
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the start, unless the run continues: then the file contains it, and the checkpoint has the newest entry. */
static PetscErrorCode OutputStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  SlipFaultOutput out = (SlipFaultOutput)ctx;
  PetscInt step;

  PetscFunctionBegin;
  if (!fault->run->file) PetscFunctionReturn(PETSC_SUCCESS);
  if (!out->resumed || !out->when.known) PetscCall(SlipFaultOutputWasWritten(out, time, w));
  out->when.time = fault->loads.origin + time;
  if (out->resumed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultOutputFields(out, time, w));
  PetscCall(SlipFaultOutputWasWritten(out, time, w));
  PetscCall(TSGetStepNumber(ts, &step));
  out->last_field_step = step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OutputStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFaultOutput out = (SlipFaultOutput)ctx;
  PetscBool due;

  PetscFunctionBegin;
  (void)ts;
  if (!fault->run->file) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultOutputIsDue(out, step, time, w, &due));
  if (!due) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultOutputFields(out, time, w));
  PetscCall(SlipFaultOutputWasWritten(out, time, w));
  out->last_field_step = step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes an entry for the last step in any case. */
static PetscErrorCode OutputFinish(SlipFault fault, TS ts, SlipOutput output, void *ctx)
{
  SlipFaultOutput out = (SlipFaultOutput)ctx;
  PetscInt step;
  PetscReal time;
  Vec w;

  PetscFunctionBegin;
  (void)output;
  PetscCall(TSGetStepNumber(ts, &step));
  if (!fault->options.text[FAULT_OUTPUT][0] || step == out->last_field_step) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultOutputFields(out, time, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints ---- */

/* On rank 0: checks that the row of /series is the one of this time. */
static PetscErrorCode CheckRow(SlipFault fault, const char file[], PetscInt row, PetscReal time)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscReal *times = NULL;
  PetscInt n = 0;
  PetscBool same;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenRead(file, &h));
  PetscCall(SlipH5ReadReal(&h, "/series/time", 1, &n, &times));
  same = n >= row && (!row || times[row - 1] == time) ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscFree(times));
  PetscCall(SlipH5Close(&h));
  PetscCheck(
    same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
    "%s (-%sfault_output) is not the output that -%sfault_restart %s was written with: it has no row %" PetscInt_FMT
    " of time %.9g s; give the name of that one, or of a file that is not there",
    file, prefix, prefix, fault->options.text[FAULT_RESTART], row, (double)time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Continues in the file of the run, or from here in a new one. rows: those of /steps, /series and /fields to keep */
static PetscErrorCode Resume(SlipFaultOutput out, const PetscInt rows[3])
{
  SlipFault fault = out->fault;
  char file[PETSC_MAX_PATH_LEN + 8];
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscReal time;

  PetscFunctionBegin;
  PetscCall(SlipFaultFindEarlier(fault, fault->options.text[FAULT_OUTPUT], "output", PETSC_TRUE, file));
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipClockRead(out->ts, &time, NULL));
  if (!out->rank) ierr = CheckRow(fault, file, rows[1], time);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  out->resumed = PETSC_TRUE;
  fault->run->entries = rows[2];
  PetscCall(SlipOutputResume(fault->run->file, rows[0], rows[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OutputVisit(SlipFault fault, SlipState s, void *ctx)
{
  SlipFaultOutput out = (SlipFaultOutput)ctx;
  PetscInt rows[3] = {0, 0, fault->run->entries};

  PetscFunctionBegin;
  if (!SlipStateIsLoading(s) && fault->run->file) PetscCall(SlipOutputSync(fault->run->file, &rows[0], &rows[1]));
  PetscCall(SlipStateGroup(s, "output"));
  PetscCall(SlipStateInt(s, "rows", 3, rows));
  PetscCall(SlipFaultOutputState(out, s));
  if (SlipStateIsLoading(s) && fault->run->file) PetscCall(Resume(out, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultOutputObserver = {.name = "output",
                                                   .create = OutputCreate,
                                                   .layout = SlipFaultOutputLayout,
                                                   .start = OutputStart,
                                                   .step = OutputStep,
                                                   .visit = OutputVisit,
                                                   .finish = OutputFinish,
                                                   .destroy = OutputDestroy};
