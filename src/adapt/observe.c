/* The table of observations: one row each, all dimensionless. */
#include <slipstep/private/slipadapt.h>
#include <stdlib.h>

#define CRITICAL_RESIDUAL 4 /* E_c of the residual */
#define FAILED_RESIDUAL 2   /* what a solve that failed or was not run counts as */
#define TIME_LEFT_MIN 1e-3  /* bounds of the remaining time whose logarithm is taken [T*] */
#define TIME_LEFT_MAX 1e3
#define CHANGE "change_"
#define LOG_FLOOR 1e-16 /* smallest argument of a logarithm */

static PetscReal LogClipped(PetscReal x)
{
  return PetscLog10Real(PetscClipInterval(x, (PetscReal)LOG_FLOOR, (PetscReal)(1 / LOG_FLOOR)));
}

/* Before the first attempt its residual counts as that of one failed solve. */
static PetscReal LastResidual(const SlipObserver *o)
{
  return o->started ? o->last.residual : FAILED_RESIDUAL;
}

/* After a failure the error counts as 2, before the first attempt as 1. */
static PetscReal LastError(const SlipObserver *o)
{
  if (!o->started) return 1;
  return o->last.converged ? o->last.error : 2;
}

/* ---- rows that the observer knows ---- */

static PetscReal Residual(const SlipObserver *o)
{
  return LastResidual(o) / CRITICAL_RESIDUAL;
}

static PetscReal Converged(const SlipObserver *o)
{
  return o->started && o->last.converged ? 1 : 0;
}

static PetscReal Accuracy(const SlipObserver *o)
{
  return o->started && o->last.converged ? 1 / (1 + o->last.error) : 0;
}

static PetscReal Step(const SlipObserver *o)
{
  PetscReal step;

  if (!o->started) return -0.5;
  step = PetscClipInterval((o->last.dt - o->dt_min) / (o->dt_max - o->dt_min), (PetscReal)0, (PetscReal)1);
  return o->last.converged ? step : -step;
}

static PetscReal LogError(const SlipObserver *o)
{
  return PetscClipInterval(LogClipped(LastError(o)), (PetscReal)-6, (PetscReal)6);
}

static PetscReal LogResidual(const SlipObserver *o)
{
  return LogClipped(LastResidual(o));
}

static PetscReal LogStep(const SlipObserver *o)
{
  return LogClipped((o->started ? o->last.dt : 0.5 * (o->dt_min + o->dt_max)) / o->tstar);
}

static PetscReal TimeFraction(const SlipObserver *o)
{
  return o->max_time < PETSC_MAX_REAL ? o->time / o->max_time : 0;
}

static PetscReal LogTimeScale(const SlipObserver *o)
{
  return o->max_time < PETSC_MAX_REAL ? LogClipped(o->max_time / o->tstar) : 0;
}

static PetscReal LogTimeLeft(const SlipObserver *o)
{
  const PetscReal left = o->max_time < PETSC_MAX_REAL ? (o->max_time - o->time) / o->tstar : PETSC_MAX_REAL;

  return PetscLog10Real(PetscClipInterval(left, (PetscReal)TIME_LEFT_MIN, (PetscReal)TIME_LEFT_MAX));
}

static PetscReal LogAccuracy(const SlipObserver *o)
{
  return PetscLog10Real(o->accuracy);
}

static PetscReal Failures(const SlipObserver *o)
{
  return (PetscReal)o->failures;
}

/* ---- rows that measure the state ---- */

static PetscErrorCode Energy(const SlipObserver *o, PetscInt k, PetscReal *value)
{
  PetscReal norm;

  PetscFunctionBegin;
  (void)k;
  PetscCall(VecNorm(o->ts->vec_sol, NORM_2, &norm));
  *value = PetscSqr(norm / (o->w0_norm > 0 ? o->w0_norm : 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Velocity(const SlipObserver *o, PetscInt k, PetscReal *value)
{
  PetscScalar sum;
  PetscInt n;

  PetscFunctionBegin;
  (void)k;
  PetscCall(VecSum(o->ts->vec_sol, &sum));
  PetscCall(VecGetSize(o->ts->vec_sol, &n));
  *value = PetscRealPart(sum) / (PetscReal)n / (o->w0_max > 0 ? o->w0_max : 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One entry of a vector, on every rank. */
static PetscErrorCode GlobalEntry(Vec w, PetscInt k, PetscReal *value)
{
  PetscInt start, end, n;
  const PetscScalar *a;
  PetscReal mine = 0;

  PetscFunctionBegin;
  PetscCall(VecGetSize(w, &n));
  PetscCheck(k < n, PetscObjectComm((PetscObject)w), PETSC_ERR_ARG_OUTOFRANGE,
             "Observation state_%" PetscInt_FMT " of a state with %" PetscInt_FMT " components", k, n);
  PetscCall(VecGetOwnershipRange(w, &start, &end));
  PetscCall(VecGetArrayRead(w, &a));
  if (k >= start && k < end) mine = PetscRealPart(a[k - start]);
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(&mine, value, 1, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)w)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StateComponent(const SlipObserver *o, PetscInt k, PetscReal *value)
{
  PetscReal w, w0;

  PetscFunctionBegin;
  PetscCall(GlobalEntry(o->ts->vec_sol, k, &w));
  PetscCall(GlobalEntry(o->w0, k, &w0));
  if (w0 == 0) w0 = o->w0_max > 0 ? o->w0_max : 1;
  *value = w / w0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* h, E and residuals are those of the last attempt. What follows "else" serves problems that do not supply the row. */
static const SlipObservation Table[] = {
  {"energy", SLIP_OBSERVES_STATE, NULL, Energy, "mean internal energy / critical energy; else |w|^2/|w_0|^2"},
  {"velocity", SLIP_OBSERVES_STATE, NULL, Velocity, "mean rate / its estimated maximum; else mean of w / max |w_0|"},
  {"state_", SLIP_OBSERVES_STATE, NULL, StateComponent,
   "state_k: component k of the state / its start; else w_k/w_k(0)"},
  {"residual", SLIP_OBSERVES_ATTEMPT, Residual, NULL, "sum of the attempt's final residuals / 4; 0.5 at the start"},
  {"converged", SLIP_OBSERVES_ATTEMPT, Converged, NULL, "1 when the attempt converged, else 0; 0 at the start"},
  {"accuracy", SLIP_OBSERVES_ERROR, Accuracy, NULL,
   "1/(1 + E), E its error estimate; 0 after a failure and at the start"},
  {"step", SLIP_OBSERVES_ATTEMPT, Step, NULL,
   "(h - h_min)/(h_max - h_min), negative after a failure; -0.5 at the start"},
  {"log_error", SLIP_OBSERVES_ERROR, LogError, NULL, "log10 of E in [-6, 6]; of 2 after a failure, of 1 at the start"},
  {"log_residual", SLIP_OBSERVES_ATTEMPT, LogResidual, NULL,
   "log10 of the sum of residuals, at least -16; of 2 at the start"},
  {"log_step", SLIP_OBSERVES_ATTEMPT, LogStep, NULL, "log10(h/T*); of (h_min + h_max)/2 at the start"},
  {"time_fraction", SLIP_OBSERVES_ATTEMPT, TimeFraction, NULL, "time / maximum time; 0 without a maximum"},
  {"log_time_scale", SLIP_OBSERVES_ATTEMPT, LogTimeScale, NULL, "log10(maximum time / T*); 0 without a maximum"},
  {"log_time_left", SLIP_OBSERVES_ATTEMPT, LogTimeLeft, NULL,
   "log10(remaining time / T*) in [-3, 3]; 3 without a maximum time"},
  {SLIP_OBSERVES_ACCURACY, SLIP_OBSERVES_ATTEMPT, LogAccuracy, NULL,
   "log10 of the wanted relative error of the run's result (-ts_adapt_rl_accuracy)"},
  {"failures", SLIP_OBSERVES_ATTEMPT, Failures, NULL, "attempts in a row that did not converge"},
};

/* NULL: not in the table. state_k matches the row "state_". */
static const SlipObservation *FindRow(const char name[], PetscInt *component)
{
  *component = 0;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Table); i++) {
    const size_t n = strlen(Table[i].name);
    char *end;
    long k;

    if (Table[i].measure != StateComponent) {
      if (!strcmp(name, Table[i].name)) return &Table[i];
      continue;
    }
    if (strncmp(name, Table[i].name, n) || name[n] < '0' || name[n] > '9') continue;
    k = strtol(name + n, &end, 10);
    if (*end || k > PETSC_MAX_INT) continue;
    *component = (PetscInt)k;
    return &Table[i];
  }
  return NULL;
}

/* What a name means. "change_" before a name is a row of every row: the value less that at the accepted step before. */
PetscErrorCode SlipObservedSet(SlipObserved *seen, const char name[])
{
  PetscBool change;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(seen->name, name, sizeof(seen->name)));
  PetscCall(PetscStrncmp(name, CHANGE, sizeof(CHANGE) - 1, &change));
  seen->change = change ? sizeof(CHANGE) - 1 : 0;
  seen->row = FindRow(name + seen->change, &seen->component);
  seen->has_base = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipObservationKnown - whether an observation is in the library's table

  Not collective

  Input Parameter:
. name - such as "energy" or "state_2"

  Output Parameter:
. known - whether any problem can be observed that way; a problem may know more names ("SlipObserve_C" of its TS)

  Level: intermediate

.seealso: SlipObservationView()
@*/
PetscErrorCode SlipObservationKnown(const char name[], PetscBool *known)
{
  SlipObserved seen;

  PetscFunctionBegin;
  PetscCall(SlipObservedSet(&seen, name));
  *known = seen.row ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipObservationView - print the table of observations

  Collective

  Input Parameter:
. viewer - an ASCII viewer, `NULL` for standard output

  Level: intermediate

.seealso: SlipObservationKnown()
@*/
PetscErrorCode SlipObservationView(PetscViewer viewer)
{
  PetscFunctionBegin;
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(PETSC_COMM_WORLD, &viewer));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Table); i++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%-14s %s\n", Table[i].name, Table[i].meaning));
  PetscCall(PetscViewerASCIIPrintf(viewer, "%-14s %s\n", CHANGE,
                                   "before a name: the value less that at the accepted step before; 0 at the start"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipObserverReset(SlipObserver *o)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&o->w0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipObserverStart(SlipObserver *o, TS ts)
{
  PetscErrorCode (*scale)(TS, PetscReal *);

  PetscFunctionBegin;
  PetscCall(SlipObserverReset(o));
  PetscCall(PetscMemzero(o, sizeof(*o)));
  o->ts = ts;
  o->time = ts->ptime;
  o->tstar = 1;
  PetscCall(TSGetMaxTime(ts, &o->max_time));
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, "SlipTimeScale_C", &scale));
  if (scale) PetscCall((*scale)(ts, &o->tstar));
  PetscCall(VecDuplicate(ts->vec_sol, &o->w0));
  PetscCall(VecCopy(ts->vec_sol, o->w0));
  PetscCall(VecNorm(o->w0, NORM_2, &o->w0_norm));
  PetscCall(VecNorm(o->w0, NORM_INFINITY, &o->w0_max));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Unknown(const SlipObserver *o, PetscInt i, const char name[], const char source[])
{
  char names[512] = "";

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Table); k++) {
    const size_t n = strlen(names);

    PetscCall(PetscSNPrintf(names + n, sizeof(names) - n, "%s%s%s", k ? ", " : "", Table[k].name,
                            Table[k].measure == StateComponent ? "<k>" : ""));
  }
  SETERRQ(PetscObjectComm((PetscObject)o->ts), PETSC_ERR_ARG_UNKNOWN_TYPE,
          "Policy %s: entry %" PetscInt_FMT
          " of /observation/names is \"%s\", which this problem does not know; expected "
          "one of %s, or a name of the problem's own",
          source, i, name, names);
}

static void TakeChange(SlipObserved *seen)
{
  const PetscReal now = seen->value;

  seen->value = seen->has_base ? now - seen->base : 0;
  seen->base = now;
  seen->has_base = PETSC_TRUE;
}

PetscErrorCode SlipObserve(const SlipObserver *o, PetscInt n, SlipObserved seen[], PetscBool state_changed,
                           const char source[])
{
  PetscErrorCode (*ask)(TS, const char[], PetscReal *, PetscBool *);

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)o->ts, "SlipObserve_C", &ask));
  for (PetscInt i = 0; i < n; i++) {
    const SlipObservation *row = seen[i].row;
    PetscBool known = PETSC_FALSE;

    if (!row || row->kind == SLIP_OBSERVES_STATE || seen[i].change) {
      if (!state_changed) continue;
      if (ask) PetscCall((*ask)(o->ts, seen[i].name + seen[i].change, &seen[i].value, &known));
      if (!row && !known) PetscCall(Unknown(o, i, seen[i].name, source));
    }
    if (!known && row->number) seen[i].value = (*row->number)(o);
    if (!known && row->measure) PetscCall((*row->measure)(o, seen[i].component, &seen[i].value));
    if (seen[i].change) TakeChange(&seen[i]);
    PetscCheck(!PetscIsInfOrNanReal(seen[i].value), PetscObjectComm((PetscObject)o->ts), PETSC_ERR_FP,
               "Observation %s is %g at time %g s; expected a finite number", seen[i].name, (double)seen[i].value,
               (double)o->time);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
