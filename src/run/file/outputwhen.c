/* Decides when the next entry of /fields is due: by steps, slip, time or slip rate, whichever is first, or by the size
   of all entries; and reports that size. Without a rule, all entries take at most -fault_output_size. A share of them
   may belong to steps in a row at the start, which are all steps of a short run of a small fault. The others become
   available as the run proceeds, half of them with time, half with the mean slip where its final value is predictable,
   as for a fault that starts at its instability or is loaded. An event that takes seconds of centuries thus has entries
   according to its share of all slip. */
#include <slipstep/private/sliprunfiles.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

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

/* Returns the size of an entry [bytes]. */
static PetscReal EntrySize(SlipFaultOutput out)
{
  PetscReal bytes = sizeof(PetscReal);
  size_t number = sizeof(double);

  if (!strcmp(out->fault->options.text[FAULT_OUTPUT_PRECISION], "single")) number = sizeof(float);
  for (PetscInt f = 0; f < SlipFaultOutputCount(out->fault); f++)
    if (out->wanted[f])
      bytes += (PetscReal)SlipFaultOutputComponents(out->fault, f) * (PetscReal)out->fault->mesh.N * (PetscReal)number;
  return bytes;
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

/* Finds whether an entry is available for this state. The last one is for the end of the run. Collective. */
static PetscErrorCode IsLeft(SlipFaultOutput out, PetscReal time, Vec w, PetscBool *left)
{
  const PetscReal most = out->when.most, next = (PetscReal)(out->fault->run->entries + 2);
  PetscReal progress;

  PetscFunctionBegin;
  *left = next <= PetscMax(2, WHEN_AT_ONCE * most) ? PETSC_TRUE : PETSC_FALSE;
  if (*left || next > most) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Progress(out, time, w, &progress));
  *left = next <= most * (WHEN_AT_ONCE + (1 - WHEN_AT_ONCE) * progress) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultOutputWhenCheck(SlipFault fault)
{
  const PetscReal factor = fault->options.value[FAULT_OUTPUT_RATE_CHANGE];

  PetscFunctionBegin;
  PetscCheck(factor == 0 || factor > 1, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_output_rate_change is %g, expected a factor > 1, or 0", SlipFaultPrefix(fault), (double)factor);
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
PetscErrorCode SlipFaultOutputIsDue(SlipFaultOutput out, PetscInt step, PetscReal time, Vec w, PetscBool *due)
{
  SlipFault fault = out->fault;
  SlipFaultWhen *when = &out->when;
  const PetscReal interval = fault->options.value[FAULT_OUTPUT_TIME_INTERVAL],
                  slip = fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL];
  const PetscReal factor = fault->options.value[FAULT_OUTPUT_RATE_CHANGE], more = 1 + WHEN_ROUNDING;
  const PetscReal now = fault->loads.origin + time;

  PetscFunctionBegin;
  if (when->most > 0) {
    PetscCall(IsLeft(out, time, w, due));
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
PetscErrorCode SlipFaultOutputWasWritten(SlipFaultOutput out, PetscReal time, Vec w)
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

/* Saves or loads the cost of the run so far. */
static PetscErrorCode VisitCounts(SlipFault fault, SlipState s)
{
  static const SlipProductsUser users[] = {SLIP_PRODUCTS_RUN, SLIP_PRODUCTS_LOOK};
  static const char *const names[] = {"products", "products_looking"};
  SlipProducts now, products, *before = fault->run->before;
  PetscReal time = SlipProcessorTime() - fault->run->time;

  PetscFunctionBegin;
  for (int i = 0; i < 2; i++) {
    SlipProductsGetOf(users[i], &now);
    products = SlipProductsSince(&now, &before[users[i]]);
    PetscCall(SlipStateProducts(s, names[i], &products));
    before[users[i]] = SlipProductsSince(&now, &products);
  }
  PetscCall(SlipStateReal(s, "processor_time", 1, &time));
  fault->run->time = SlipProcessorTime() - time;
  PetscCall(SlipStateInt(s, "right_hand_sides", 1, &fault->balance.sides));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads a checkpoint's part: the newest entry of /fields. Data that the earlier run did not need start here.
   */
PetscErrorCode SlipFaultOutputState(SlipFaultOutput out, SlipState s)
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

  PetscFunctionBegin;
  PetscCall(VisitCounts(fault, s));
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
PetscErrorCode SlipFaultOutputSize(SlipFaultOutput out, TS ts)
{
  SlipFault fault = out->fault;
  const PetscReal interval = fault->options.value[FAULT_OUTPUT_TIME_INTERVAL], bytes = EntrySize(out);
  const PetscBool bounded = interval > 0 && !ByStep(fault) && fault->options.value[FAULT_OUTPUT_SLIP_INTERVAL] == 0 &&
                                fault->options.value[FAULT_OUTPUT_RATE_CHANGE] == 0
                              ? PETSC_TRUE
                              : PETSC_FALSE;
  const char *most = fault->options.value[FAULT_OUTPUT_COMPRESSION] > 0 ? "at most " : "", *most_of_all = most;
  PetscReal entries = ByOther(fault) ? 1000 : 1000 / fault->options.value[FAULT_OUTPUT_INTERVAL], begin, end;
  char one[32], all[32], text[64];

  PetscFunctionBegin;
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
