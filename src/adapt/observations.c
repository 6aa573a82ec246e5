/* The observations of TSADAPTRL: computes the numbers for the formulas of slipcore.h, and the problem's own rows. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipwork.h>
#include <slipstep/private/slipclock.h>
#include <slipstep/private/slipsys.h>

/*@C
  SlipObservationView - prints the table of observations, those of any problem and those of faults

  Collective

  Input Parameter:
. viewer - an ASCII viewer, `NULL` for standard output

  Level: intermediate

.seealso: TSADAPTRL, TSSetSlipProblem()
@*/
PetscErrorCode SlipObservationView(PetscViewer viewer)
{
  PetscFunctionBegin;
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(PETSC_COMM_WORLD, &viewer));
  for (const SlipObservation *row = SlipObservations; row->name; row++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%-14s %s\n", row->name, row->meaning));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipObserverReset(SlipObserver *o)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&o->w0));
  PetscCall(PetscFree2(o->own, o->value));
  o->nown = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipObserverStart(SlipObserver *o, TS ts)
{
  PetscFunctionBegin;
  PetscCall(SlipObserverReset(o));
  PetscCall(PetscMemzero(o, sizeof(*o)));
  o->ts = ts;
  o->run.tstar = 1;
  PetscCall(SlipClockRead(ts, &o->run.time, &o->run.max_time));
  PetscCall(TSGetSlipProblem(ts, &o->problem, &o->ctx));
  if (o->problem && o->problem->control.time_scale)
    PetscCall((*o->problem->control.time_scale)(ts, &o->run.tstar, o->ctx));
  PetscCall(VecDuplicate(ts->vec_sol, &o->w0));
  PetscCall(VecCopy(ts->vec_sol, o->w0));
  PetscCall(VecNorm(o->w0, NORM_2, &o->run.norm0));
  PetscCall(SlipVecLargest(o->w0, &o->run.max0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Unknown_Observer(const SlipObserver *o, PetscInt i, const char name[], const char source[])
{
  char names[512] = "";

  PetscFunctionBegin;
  for (const SlipObservation *row = SlipObservations; row->name; row++) {
    if (!row->run) continue;
    PetscCall(PetscStrlcat(names, names[0] ? ", " : "", sizeof(names)));
    PetscCall(PetscStrlcat(names, row->name, sizeof(names)));
    if (row->name[strlen(row->name) - 1] == '_') PetscCall(PetscStrlcat(names, "<k>", sizeof(names)));
  }
  SETERRQ(PetscObjectComm((PetscObject)o->ts), PETSC_ERR_ARG_UNKNOWN_TYPE,
          "Policy %s: entry %" PetscInt_FMT
          " of /observation/names is \"%s\", which this problem does not know; expected "
          "one of %s, or a name of the problem's own",
          source, i, name, names);
}

PetscErrorCode SlipObserverFindRows(SlipObserver *o, PetscInt n, SlipObserved seen[], const char source[])
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &o->own, n, &o->value));
  o->nown = 0;
  for (PetscInt i = 0; i < n; i++) {
    seen[i].has_base = PETSC_FALSE;
    seen[i].own = -1;
    if (!SlipObservedOfState(&seen[i])) continue;
    if (o->problem && o->problem->observations.find)
      PetscCall((*o->problem->observations.find)(o->ts, seen[i].name + seen[i].change, &seen[i].own, o->ctx));
    if (seen[i].own >= 0)
      o->own[o->nown++] = seen[i].own;
    else if (!seen[i].row || !seen[i].row->run)
      PetscCall(Unknown_Observer(o, i, seen[i].name, source));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets one entry of a vector on every rank */
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

/* Computes what rows of the state need for a problem that does not supply them */
static PetscErrorCode MeasureState(SlipObserver *o, PetscInt k)
{
  const Vec w = o->ts->vec_sol;
  PetscScalar sum;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecNorm(w, NORM_2, &o->run.norm));
  PetscCall(VecSum(w, &sum));
  PetscCall(VecGetSize(w, &n));
  o->run.mean = PetscRealPart(sum) / (PetscReal)n;
  PetscCall(GlobalEntry(w, k, &o->run.component));
  PetscCall(GlobalEntry(o->w0, k, &o->run.component0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipObserve(SlipObserver *o, PetscInt n, SlipObserved seen[], PetscBool state_changed)
{
  PetscInt own = 0, numbers;

  PetscFunctionBegin;
  SlipWorkBegin(SLIP_SHARE_OBSERVATION);
  PetscCall(VecGetLocalSize(o->ts->vec_sol, &numbers));
  SlipWorkAdd(SLIP_WORK_OBSERVED, (PetscReal)numbers);
  o->run.converged = o->last.converged;
  o->run.error = o->last.error;
  o->run.residual = o->last.residual;
  o->run.dt = o->last.dt;
  if (state_changed && o->nown)
    PetscCall((*o->problem->observations.observe)(o->ts, o->run.time, o->nown, o->own, o->value, o->ctx));
  for (PetscInt i = 0; i < n; i++) {
    PetscReal value;

    if (!state_changed && SlipObservedOfState(&seen[i])) continue;
    if (seen[i].own >= 0) {
      value = o->value[own++];
    } else {
      if (seen[i].row->reads & SLIP_READS_STATE) PetscCall(MeasureState(o, seen[i].component));
      value = (*seen[i].row->run)(&o->run);
    }
    SlipObservedTake(&seen[i], value);
    PetscCheck(!PetscIsInfOrNanReal(seen[i].value), PetscObjectComm((PetscObject)o->ts), PETSC_ERR_FP,
               "Observation %s is %g at time %g s; expected a finite number", seen[i].name, (double)seen[i].value,
               (double)o->run.time);
  }
  SlipWorkEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}
