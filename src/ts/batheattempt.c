/* What TSBATHE reports of its attempts: the record of the last one, totals, monitors, and estimates
   from which errors of whole runs are computed. */
#include <slipstep/private/slipbathe.h>

/*@
  TSBatheGetLastAttempt - gets the record of the last attempted step

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameter:
. attempt - the record; its member accepted is false until the controller has chosen

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
  TSBatheMonitorSet - adds a function that is called after every attempted step, accepted or rejected

  Logically collective

  Input Parameters:
+ ts      - of type TSBATHE
. monitor - the function; monitors are called in the order of registration, after the attempt is accepted or rejected
. ctx     - passed to monitor (NULL allowed)
- destroy - destroys ctx with the TS or by TSBatheMonitorCancel() (NULL allowed)

  Level: intermediate

  Note:
  There may be any number of monitors. One with the same three arguments as an earlier one is not added again.

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
  TSBatheMonitorCancel - removes all functions that are called after attempted steps

  Logically collective

  Input Parameter:
. ts - of type TSBATHE

  Level: intermediate

  Note:
  This removes the functions of the output file and of error estimates of whole runs, too.

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

PetscErrorCode TSBatheRunMonitors(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  ba->last.products = SlipProductsRow(&ba->totals.cost);
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_LOOK));
  for (const TSBatheMonitor *m = ba->monitors; m; m = m->next) PetscCall((*m->fn)(ts, &ba->last, ts->vec_sol, m->ctx));
  PetscCall(SlipProductsPop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetTotals - gets the counts since TSSolve() began

  Not collective

  Input Parameter:
. ts - of type TSBATHE

  Output Parameters:
+ attempts - attempted steps (each output may be NULL)
. accepted - accepted steps
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
  if (attempts) *attempts = ba->totals.attempts;
  if (accepted) *accepted = ba->totals.accepted;
  if (solves) *solves = ba->totals.solves;
  if (newton) *newton = ba->totals.newton;
  if (linear) *linear = ba->totals.linear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the number of attempts since TSSolve() began that were explicit steps. ts: of type TSBATHE or TSMOREAU. */
PetscErrorCode TSBatheGetExplicitAttempts(TS ts, PetscInt *attempts)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *attempts = ba->totals.explicits;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSBatheGetEstimates - gets the estimated error of the last attempt, component by component, and dw/dt at its end

  Not collective

  Input Parameter:
. ts - the integrator

  Output Parameters:
+ error      - the estimated error in the layout and units of the solution, borrowed and valid until the next attempt;
               `NULL` when the last attempt did not converge or had no estimate, and when ts is not of type TSBATHE
. scale      - dimensionless factor: scale times error is the solution minus a more accurate one, to the method's order
- derivative - dw/dt at the attempt's end [units of the solution per s], borrowed likewise; `NULL` if not computed

  Level: advanced

  Notes:
  Each output may be `NULL`.

  The embedded estimate is that difference, with a scale of 1. Doubling returns the two halves minus the whole, over
  2^p - 1 with an assumed order p (-ts_bathe_order), 1 as published; the error of the halves is minus that difference
  over 2^q - 1 with the order q of `TSBatheGetOrder()`.

.seealso: TSBatheGetLastAttempt(), TSBatheSetError(), TSBatheSetDoublingOrder()
@*/
PetscErrorCode TSBatheGetEstimates(TS ts, Vec *error, PetscReal *scale, Vec *derivative)
{
  PetscBool known;
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  known = ba && ba->totals.attempts && ba->last.converged ? PETSC_TRUE : PETSC_FALSE;
  if (error) *error = known && ba->last.error >= 0.0 ? ba->estimate.E : NULL;
  if (derivative) *derivative = known && ba->k2_known ? ba->K2 : NULL;
  if (scale) {
    PetscReal order;

    *scale = 1.0;
    if (!ba || ba->estimate.type != TSBATHE_ERROR_DOUBLING) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(TSBatheGetOrder(ts, &order));
    *scale = -(PetscPowRealInt(2.0, (int)ba->estimate.order) - 1.0) / (PetscPowReal(2.0, order) - 1.0);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets states and weights of the last step, with which the method's own quadrature integrates. ts: of type TSBATHE,
   after an accepted step and before the next one; share: position of each of the three states in the step, from 0 to 1;
   weight: weights of the states: the integral of f(w) is the step times the sum of weight_i f(state_i); state: states
   at the start, at an inner point and at the end, borrowed. The inner state is that of the first stage. The weights are
   those with which the method adds up the derivatives of stages: the integral of dw/dt is the change in the step to the
   accuracy of the solver. Where the solution was computed in halves (-ts_bathe_error doubling) or other parts, the
   inner state is the end of the last part but one, and the weights are those of the quadratic through the three states.
   Errors: PETSC_ERR_ORDER before a step was accepted. */
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
  if (ba->last.solves == 1 && ba->was->weights) {
    (*ba->was->weights)(ba, weight);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  weight[1] = 1.0 / (6.0 * ba->share * (1.0 - ba->share));
  weight[2] = (2.0 - 3.0 * ba->share) / (6.0 * (1.0 - ba->share));
  weight[0] = 1.0 - weight[1] - weight[2];
  PetscFunctionReturn(PETSC_SUCCESS);
}
