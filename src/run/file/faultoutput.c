/* Writes -fault_output: the file of a run, with /series, and /fields for the start and for the steps after which they
   are due.

   An entry of /fields is due by steps, slip, time or slip rate, whichever is first, or by the size of all entries.
   Without a rule, all entries take at most -fault_output_size. A share of them may belong to steps in a row at the
   start, which are all steps of a short run of a small fault. The others become available as the run proceeds, half of
   them with time, half with the mean slip where its final value is predictable, as for a fault that starts at its
   instability or is loaded. An event that takes seconds of centuries thus has entries according to its share of all
   slip. */
#include <slipstep/private/sliprunfiles.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- when an entry is due ---- */

/* Two times that differ by less are equal but for rounding. */
#define WHEN_ROUNDING 1e-12

/* Share of the entries that may belong to steps in a row */
#define WHEN_AT_ONCE 0.2

static PetscBool ByOther(SlipFault fault)
{
  return fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL] > 0 || fault->options.value[FAULT_OUTPUT_TIME_INTERVAL] > 0 ||
             fault->options.value[FAULT_OUTPUT_RATE_CHANGE] > 0
           ? PETSC_TRUE
           : PETSC_FALSE;
}

static PetscBool ByStep(SlipFault fault)
{
  return !ByOther(fault) || fault->options.interval_given ? PETSC_TRUE : PETSC_FALSE;
}

/* Finds how far a run has proceeded, from 0 to 1. Collective. */
static PetscErrorCode Progress(SlipFaultOutput out, PetscReal time, Vec w, PetscReal *progress)
{
  SlipFault fault = out->fault;
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE], *a;
  PetscReal sum[2] = {0, 0}, end, slip;
  PetscBool critical;
  TS ts = out->ts;

  PetscFunctionBegin;
  PetscCall(SlipClockRead(ts, NULL, &end));
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  time += fault->loads.origin;
  *progress = end > 0 ? PetscMin(PetscMax(time / end, 0), 1) : 1;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    sum[0] +=
      fault->mesh.weight[i] * SlipFaultDot(fault, a + SlipFaultDisplacementAt(fault, i), SlipFaultAlong(fault, i));
    sum[1] += fault->mesh.weight[i] * vinf[i];
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  slip = PetscAbsReal(sum[1]) / (PetscReal)fault->mesh.N * end + (critical ? fault->critical.drop_slip : 0);
  if (slip > 0)
    *progress = 0.5 * (*progress + PetscMin(PetscAbsReal((sum[0] + sum[1] * time) / (PetscReal)fault->mesh.N -
                                                         fault->critical.start_share * fault->critical.mean_uc) /
                                              slip,
                                            1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest |slip| [m] of a cell since the newest entry, from du/dt = v - v_inf. Collective. */
static PetscErrorCode SlipSinceEntry(SlipFaultOutput out, PetscReal time, Vec w, PetscReal *largest)
{
  SlipFault fault = out->fault;
  const PetscReal dt = fault->loads.origin + time - out->when.entry_time;

  PetscFunctionBegin;
  PetscCall((*fault->cell_ops->slip)(fault, dt, w, out->when.entry_u, largest));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest |v| [m/s], or the tolerance of the integrator, below which rates mean nothing. Collective. */
static PetscErrorCode LargestRate(SlipFault fault, PetscReal time, Vec w, PetscReal *rate)
{
  PetscReal tolerance;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetReal(fault, "rate_tolerance", &tolerance));
  PetscCall(SlipFaultStepRate(fault, time, w, rate));
  *rate = PetscMax(*rate, tolerance);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether an entry is due for the state after this step. Collective. */
static PetscErrorCode SlipFaultOutputIsDue(SlipFaultOutput out, PetscInt step, PetscReal time, Vec w, PetscBool *due)
{
  SlipFault fault = out->fault;
  SlipFaultWhen *when = &out->when;
  const PetscReal interval = fault->options.value[FAULT_OUTPUT_TIME_INTERVAL],
                  slip = fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL];
  const PetscReal factor = fault->options.value[FAULT_OUTPUT_RATE_CHANGE], more = 1 + WHEN_ROUNDING;
  const PetscReal now = fault->loads.origin + time;

  PetscFunctionBegin;
  if (when->most > 0) {
    const PetscReal next = (PetscReal)(fault->run->entries + 2); /* the last one is for the end of the run */
    PetscReal progress;

    *due = next <= PetscMax(2, WHEN_AT_ONCE * when->most) ? PETSC_TRUE : PETSC_FALSE;
    if (*due || next > when->most) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(Progress(out, time, w, &progress));
    *due = next <= when->most * (WHEN_AT_ONCE + (1 - WHEN_AT_ONCE) * progress) ? PETSC_TRUE : PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *due = ByStep(fault) && step % (PetscInt)fault->options.value[FAULT_OUTPUT_INTERVAL] == 0 ? PETSC_TRUE : PETSC_FALSE;
  if (interval > 0 && PetscFloorReal(now * more / interval) > PetscFloorReal(when->time * more / interval))
    *due = PETSC_TRUE;
  when->time = now;
  if (!*due && slip > 0) {
    PetscReal largest;

    PetscCall(SlipSinceEntry(out, time, w, &largest));
    *due = largest >= slip ? PETSC_TRUE : PETSC_FALSE;
  }
  if (!*due && factor > 0) {
    PetscReal rate;

    PetscCall(LargestRate(fault, time, w, &rate));
    *due = rate >= factor * when->entry_rate || rate * factor <= when->entry_rate ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes that an entry of this state was written, from which slip and rate count. Collective. */
static PetscErrorCode SlipFaultOutputWasWritten(SlipFaultOutput out, PetscReal time, Vec w)
{
  SlipFault fault = out->fault;
  SlipFaultWhen *when = &out->when;

  PetscFunctionBegin;
  when->known = PETSC_TRUE;
  when->time = when->entry_time = fault->loads.origin + time;
  if (fault->options.value[FAULT_OUTPUT_RATE_CHANGE] > 0) PetscCall(LargestRate(fault, time, w, &when->entry_rate));
  if (fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL] > 0) {
    if (!when->entry_u) PetscCall(VecDuplicate(fault->critical.uc, &when->entry_u));
    PetscCall(SlipFaultGetDisplacement(fault, w, when->entry_u));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads a checkpoint's part: the newest entry of /fields. Data that the earlier run did not need start here.
   */
static PetscErrorCode SlipFaultOutputState(SlipFaultOutput out, SlipState s)
{
  SlipFault fault = out->fault;
  const PetscBool file = fault->run->file ? PETSC_TRUE : PETSC_FALSE;
  SlipFaultWhen nothing = {0}, *when = file ? &out->when : &nothing;
  const PetscBool rate = file && fault->options.value[FAULT_OUTPUT_RATE_CHANGE] > 0 ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool slip =
    when->entry_u || (SlipStateIsLoading(s) && file && fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL] > 0)
      ? PETSC_TRUE
      : PETSC_FALSE;
  PetscBool known = when->known, has_rate = rate, has_slip = slip;
  PetscInt last = file ? out->last_field_step : 0;
  static const SlipProductsUser users[] = {SLIP_PRODUCTS_RUN, SLIP_PRODUCTS_LOOK};
  static const char *const names[] = {"products", "products_looking"};
  SlipProducts now, products, *before = fault->run->before;
  PetscReal time = SlipProcessorTime() - fault->run->time;

  PetscFunctionBegin;
  /* the cost of the run so far */
  for (int i = 0; i < 2; i++) {
    SlipProductsGetOf(users[i], &now);
    products = SlipProductsSince(&now, &before[users[i]]);
    PetscCall(SlipStateProducts(s, names[i], &products));
    before[users[i]] = SlipProductsSince(&now, &products);
  }
  PetscCall(SlipStateReal(s, "processor_time", 1, &time));
  fault->run->time = SlipProcessorTime() - time;
  PetscCall(SlipStateInt(s, "right_hand_sides", 1, &fault->balance.sides));
  PetscCall(SlipStateBool(s, "entry", &known));
  PetscCall(SlipStateInt(s, "entry_step", 1, &last));
  PetscCall(SlipStateReal(s, "entry_time", 1, &when->entry_time));
  PetscCall(SlipStateBool(s, "entry_has_rate", &has_rate));
  PetscCall(SlipStateReal(s, "entry_rate", 1, &when->entry_rate));
  PetscCall(SlipStateBool(s, "entry_has_displacement", &has_slip));
  if (has_slip && slip) {
    if (!when->entry_u) PetscCall(VecDuplicate(fault->critical.uc, &when->entry_u));
    PetscCall(SlipStateVec(s, "entry_displacement", when->entry_u));
  }
  if (!SlipStateIsLoading(s) || !file) PetscFunctionReturn(PETSC_SUCCESS);
  out->last_field_step = last;
  when->known = known && (has_rate || !rate) && (has_slip || !slip) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the size of entries ---- */

static void SizeText(PetscReal bytes, char text[], size_t len)
{
  static const char *const unit[] = {"bytes", "kB", "MB", "GB", "TB"};
  size_t k = 0;

  for (; bytes >= 1000 && k + 1 < PETSC_STATIC_ARRAY_LENGTH(unit); k++) bytes /= 1000;
  (void)snprintf(text, len, "%.3g %s", (double)bytes, unit[k]);
}

/* Finds how many entries there may be. Prints the size of one, and of all where their number has a bound, else of those
   of a thousand steps. Collective. */
static PetscErrorCode SlipFaultOutputSize(SlipFaultOutput out, TS ts)
{
  SlipFault fault = out->fault;
  const PetscReal interval = fault->options.value[FAULT_OUTPUT_TIME_INTERVAL],
                  number =
                    strcmp(fault->options.text[FAULT_OUTPUT_PRECISION], "single") ? sizeof(double) : sizeof(float);
  const PetscBool bounded = interval > 0 && !ByStep(fault) && fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL] == 0 &&
                                fault->options.value[FAULT_OUTPUT_RATE_CHANGE] == 0
                              ? PETSC_TRUE
                              : PETSC_FALSE;
  const char *most = fault->options.value[FAULT_OUTPUT_COMPRESSION] > 0 ? "at most " : "", *most_of_all = most;
  PetscReal entries = ByOther(fault) ? 1000 : 1000 / fault->options.value[FAULT_OUTPUT_INTERVAL], begin, end;
  PetscReal bytes = sizeof(PetscReal); /* of an entry */
  char one[32], all[32], text[64];

  PetscFunctionBegin;
  for (PetscInt f = 0; f < SlipFaultOutputCount(fault); f++)
    if (out->wanted[f]) bytes += (PetscReal)SlipFaultOutputComponents(fault, f) * (PetscReal)fault->mesh.N * number;
  PetscCall(SlipClockRead(ts, &begin, &end));
  out->when.most = 0;
  (void)snprintf(text, sizeof(text), ByOther(fault) ? "for 1000" : "for every 1000 steps");
  if (bounded) {
    entries = PetscMax(PetscFloorReal(end / interval) - PetscFloorReal(begin / interval), 0) + 2;
    (void)snprintf(text, sizeof(text), "for the entries of the run, at most %.0f", (double)entries);
  } else if (!ByOther(fault) && !fault->options.interval_given && fault->options.value[FAULT_OUTPUT_SIZE] > 0) {
    entries = out->when.most = PetscMax(PetscFloorReal(fault->options.value[FAULT_OUTPUT_SIZE] / bytes), 2);
    most_of_all = "at most ";
    (void)snprintf(text, sizeof(text), "in all (-%sfault_output_size)", SlipFaultPrefix(fault));
  }
  SizeText(bytes, one, sizeof(one));
  SizeText(bytes * entries, all, sizeof(all));
  PetscCall(PetscPrintf(fault->comm, "%-24s %s%s an entry of /fields, %s%s %s\n", "output:", most, one, most_of_all,
                        all, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the observer ---- */

/* Creates the observer also without -fault_output, as checkpoints store the cost of a run. */
static PetscErrorCode OutputCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  const PetscReal factor = fault->options.value[FAULT_OUTPUT_RATE_CHANGE];
  SlipFaultOutput out;
  SlipH5Kind kind;
  PetscErrorCode ierr = PETSC_SUCCESS;
  Vec w;

  PetscFunctionBegin;
  (void)wanted;
  PetscCheck(factor == 0 || factor > 1, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_output_rate_change is %g, expected a factor > 1, or 0", SlipFaultPrefix(fault), (double)factor);
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
    Vec *vecs[] = {&out->w0,     &out->r0,    &out->c0,    &out->numbers,
                   &out->start0, &out->shown, &out->vinf0, &out->when.entry_u};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
    for (PetscInt f = 0; f < OUTPUT_NUM_FIELDS; f++) PetscCall(VecDestroy(&out->of[f]));
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
