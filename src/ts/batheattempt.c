/* What TSBATHE says of its attempts: the record of the last one, totals, monitors, why one failed, and estimates for
   those who estimate errors of whole runs. */
#include <slipstep/private/slipts.h>
#include <petsc/private/snesimpl.h>

/* Of a stage's first residual: less of it says that the solver was on its way */
static const PetscReal floor_share = 1e-3;

/*@
  TSBatheGetLastAttempt - record of the last attempted step

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. attempt - the record; while the controller chooses, accepted is not known yet and false

  Level: intermediate

.seealso: TSBatheMonitorSet(), TSBatheGetTotals()
@*/
PetscErrorCode TSBatheGetLastAttempt(TS ts, SlipAttempt *attempt)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *attempt = ba->last;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSBatheMonitorSet - have a function called after every attempted step, accepted or not

  Logically collective

  Input Parameters:
+ ts      - of type TSBATHE
. monitor - called in the order of registration, once the verdict is known
. ctx     - passed to monitor (NULL allowed)
- destroy - destroys ctx with the TS or TSBatheMonitorCancel() (NULL allowed)

  Level: intermediate

  Note:
  There may be any number of them. One with the same three arguments as an earlier one is not added again.

.seealso: TSBatheMonitorCancel(), TSBatheGetLastAttempt(), TSMonitorSet()
@*/
PetscErrorCode TSBatheMonitorSet(TS ts, TSBatheAttemptFn monitor, void *ctx, PetscErrorCode (*destroy)(void **))
{
  TS_Bathe *ba = NULL;
  TSBatheMonitor *last;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  for (TSBatheMonitor *m = ba->monitors; m; m = m->next)
    if (m->fn == monitor && m->ctx == ctx && m->destroy == destroy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&last));
  *last = (TSBatheMonitor){monitor, ctx, destroy, NULL};
  if (!ba->monitors)
    ba->monitors = last;
  else {
    TSBatheMonitor *m = ba->monitors;

    while (m->next) m = m->next;
    m->next = last;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheMonitorCancel - forget all functions that are called after attempted steps

  Logically collective

  Input Parameter:
. ts - of type TSBATHE

  Level: intermediate

  Note:
  Those of the output file and of error estimates of whole runs are such functions too.

.seealso: TSBatheMonitorSet(), TSMonitorCancel()
@*/
PetscErrorCode TSBatheMonitorCancel(TS ts)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  while (ba->monitors) {
    TSBatheMonitor *m = ba->monitors;

    ba->monitors = m->next;
    if (m->destroy) PetscCall((*m->destroy)(&m->ctx));
    PetscCall(PetscFree(m));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetTotals - counts since TSSolve() began

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameters:
+ attempts - steps tried (each output may be NULL)
. accepted - steps taken
. solves   - Bathe steps computed, more than attempts with step doubling
. newton   - nonlinear iterations
- linear   - linear iterations

  Level: intermediate

.seealso: TSBatheGetLastAttempt()
@*/
PetscErrorCode TSBatheGetTotals(TS ts, PetscInt *attempts, PetscInt *accepted, PetscInt *solves, PetscInt *newton,
                                PetscInt *linear)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  if (attempts) *attempts = ba->attempts;
  if (accepted) *accepted = ba->accepted;
  if (solves) *solves = ba->solves;
  if (newton) *newton = ba->newton;
  if (linear) *linear = ba->linear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetExplicitAttempts - how many of the attempts since TSSolve() began were explicit steps

  Not collective

  Input Parameter:
. ts - of type TSBATHE or TSMOREAU

  Output Parameter:
. attempts - their number

  Level: intermediate

.seealso: TSBatheGetTotals(), TSBatheSetMethod()
@*/
PetscErrorCode TSBatheGetExplicitAttempts(TS ts, PetscInt *attempts)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *attempts = ba->explicits;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetEstimates - what the last attempt knows beside its solution: its error, component by component, and dw/dt

  Not collective

  Input Parameter:
. ts - the integrator

  Output Parameters:
+ error      - the estimated error in the layout and units of the solution, borrowed and valid until the next attempt;
               `NULL` when the last attempt did not converge or had no estimate, and when ts is not of type TSBATHE
. scale      - dimensionless factor that makes of the error the solution minus a more accurate one, to the method's
               order
- derivative - dw/dt at the attempt's end [units of the solution per s], borrowed likewise; `NULL` when not known

  Level: advanced

  Notes:
  Each output may be `NULL`.

  The embedded estimate is that difference, scale is 1. Doubling gives the two halves minus the whole, over 2^p - 1
  with an assumed order p (-ts_bathe_order), 1 as published; the error of the halves is minus the difference over 2^q
  - 1 with the order q of `TSBatheGetOrder()`.

.seealso: TSBatheGetLastAttempt(), TSBatheSetError(), TSBatheSetDoublingOrder()
@*/
PetscErrorCode TSBatheGetEstimates(TS ts, Vec *error, PetscReal *scale, Vec *derivative)
{
  PetscBool known;
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  known = ba && ba->attempts && ba->last.converged ? PETSC_TRUE : PETSC_FALSE;
  if (error) *error = known && ba->last.error >= 0.0 ? ba->E : NULL;
  if (derivative) *derivative = known && ba->k2_known ? ba->K2 : NULL;
  if (scale) {
    PetscReal order;

    *scale = 1.0;
    if (!ba || ba->error != TSBATHE_ERROR_DOUBLING) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(TSBatheGetOrder(ts, &order));
    *scale = -(PetscPowRealInt(2.0, (int)ba->order) - 1.0) / (PetscPowReal(2.0, order) - 1.0);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetQuadrature - states of the last step, by which an integral over it is computed as the method integrates

  Not collective

  Input Parameter:
. ts - of type TSBATHE, after an accepted step and before the next one

  Output Parameters:
+ share  - of the step at which each of the three states is, from 0 to 1
. weight - of the states: the integral of f(w) is the step times the sum of weight_i f(state_i)
- state  - at the start, at an inner point and at the end, borrowed

  Level: advanced

  Notes:
  The inner state is that of the first stage, and the weights are the method's own, by which it forms the solution of
  the stages' derivatives: of dw/dt the integral is the step's change to the last bits of the solver. Where the solution
  has been computed in halves (-ts_bathe_error doubling) or other parts, the inner state is the end of the last but one,
  and the weights are those of the quadratic through the three.

  Errors: PETSC_ERR_ORDER before a step was accepted

.seealso: TSBatheGetEstimates(), TSBatheGetGamma(), TSInterpolate()
@*/
PetscErrorCode TSBatheGetQuadrature(TS ts, PetscReal share[3], PetscReal weight[3], Vec state[3])
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  PetscCheck(ba->last.accepted, PetscObjectComm((PetscObject)ts), PETSC_ERR_ORDER, "no step was accepted yet");
  share[0] = 0.0;
  share[1] = ba->share;
  share[2] = 1.0;
  state[0] = ba->X0;
  state[1] = ba->Wm;
  state[2] = ba->Y[1];
  PetscCall(PetscArraycpy(weight, ba->c.weight, 3));
  if (ba->last.solves == 1 && ba->last.method == TSBATHE_METHOD_EXPLICIT && !ba->stabilised) { /* the midpoint rule */
    weight[0] = weight[2] = 0;
    weight[1] = 1;
  }
  if (ba->last.solves == 1 && !(ba->last.method == TSBATHE_METHOD_EXPLICIT && ba->stabilised))
    PetscFunctionReturn(PETSC_SUCCESS);
  weight[1] = 1.0 / (6.0 * ba->share * (1.0 - ba->share));
  weight[2] = (2.0 - 3.0 * ba->share) / (6.0 * (1.0 - ba->share));
  weight[0] = 1.0 - weight[1] - weight[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSBatheSetParts - compute the solution of every step in parts, the error estimate being that of the whole

  Logically collective

  Input Parameters:
+ ts    - of type TSBATHE
. parts - their number, even; 1: the whole
. told  - called with the time [s] and the state at the end of each part, also of attempts that are rejected later; may
          be `NULL`
- ctx   - passed to told

  Level: advanced

  Note:
  A run with the same controller then chooses steps of the same length at the same states, with a solution of parts of
  them: the difference of two such runs is a Richardson estimate of the error of the coarser one. Steps put where they
  were in time would not do, as an event that comes a little later meets the long steps meant for the rest after it.
  With doubling, whose solution is one of halves already, it is computed in twice as many. Costs as many further Bathe
  solves a step.

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a number that is neither 1 nor even

.seealso: TSBatheGetOrder(), TSBatheSetError()
@*/
PetscErrorCode TSBatheSetParts(TS ts, PetscInt parts, TSBathePartFn told, void *ctx)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  PetscCheck(parts == 1 || (parts > 0 && parts % 2 == 0), PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " parts of a step; expected 1 or an even number", parts);
  ba->parts = parts;
  ba->part = told;
  ba->part_ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the last solve was worst: cell of the constraint, or entry of the SNES residual */
PetscErrorCode TSBatheWorst(TS ts, PetscInt *index, PetscReal *residual)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  Vec f, a;

  PetscFunctionBegin;
  if (ba->con) {
    PetscCall(SNESSlipGetWorstCell(ts->snes, index, residual));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SNESGetFunction(ts->snes, &f, NULL, NULL));
  PetscCall(VecDuplicate(f, &a));
  PetscCall(VecCopy(f, a));
  PetscCall(VecAbs(a));
  PetscCall(VecMax(a, index, residual));
  PetscCall(VecDestroy(&a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shorter steps make a solve converge unless its residual stands where rounding, differences or an approximate Jacobian
   leave it. That is so where it is small and a first repetition, of a shorter step, has not halved it. */
PetscErrorCode TSBatheTellFloor(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const char *prefix = ((PetscObject)ts->snes)->prefix ? ((PetscObject)ts->snes)->prefix : "";
  PetscReal norm, first;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (ba->con || ba->floor_told || ba->failures > 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetFunctionNorm(ts->snes, &norm));
  first = ts->snes->rtol > 0 ? ts->snes->ttol / ts->snes->rtol : PETSC_MAX_REAL;
  if (ba->failures == 1) ba->stagnated = norm < floor_share * first ? norm : 0;
  if (ba->failures == 1 || !(ba->stagnated > 0) || norm < 0.5 * ba->stagnated) PetscFunctionReturn(PETSC_SUCCESS);
  ba->floor_told = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  if (!rank)
    PetscCall(SlipWarning(
      "at time %.6g s a stage ended as %s with the residual %.3g, and with %.3g at a shorter step: shorter steps do "
      "not help there. -%ssnes_rtol and -%ssnes_atol say what is small enough, -%ssnes_test_jacobian whether the "
      "Jacobian fits",
      (double)ts->ptime, SNESConvergedReasons[ba->last.reason], (double)ba->stagnated, (double)norm, prefix, prefix,
      prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}
