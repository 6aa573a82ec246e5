/* TSADAMS as a PETSc TS type: explicit Adams formulas of variable step and order, which predict, evaluate, correct and
   evaluate again. A step takes two right-hand sides and a rejected attempt one, for any order.

   From the derivatives f_n, f_n-1, ... of accepted steps, order k (that of the predictor) computes
      y* = y_n + the integral of the polynomial through f_n ... f_n-k+1,      f* = f(t_n+1, y*), y_n+1 = y_n + that of
      the one through f*, f_n ... f_n-k+1 (order k + 1), with twice what one node more changes of it, f_n+1 = f(t_n+1,
      y_n+1),
   and the error estimate is the change by the oldest of these nodes, which is of order h^(k + 1). The same difference
   with one node less or more estimates the errors of orders k - 1 and k + 1; the next step takes the order that allows
   the longest step (Shampine & Gordon 1975). Where stability limits the step, the estimates of high orders grow first,
   and the order falls.

   Nodes are at sums of steps, not at differences of times: after centuries the rounding of time is a part of the
   shortest steps that would enlarge the estimate, so that the controller would choose still shorter steps. */
#include <slipstep/private/slipts.h>

/* The order changes only if the other order allows a step longer by this factor. */
#define ADAMS_RAISE 1.2
#define ADAMS_LOWER 1.05
/* Norm of the estimate of a step that is above all bounds, and these bounds: squares of smaller numbers are finite */
#define FAR_TOO_LONG 1e10
#define BOUNDS 1e100
/* Rejected attempts in a row after which the formulas restart at order 1 */
#define RESTART_AFTER 2
/* The corrected state is corrector k + 1 plus so many times the difference of corrector k + 2 to it; 1 would have order
   k + 2. With 2 the error is that of 0 with the other sign, and on the negative real axis steps are stable to 2.98
   instead of 2.38 (k = 2), 2.38 instead of 1.93 (k = 3). */
#define ADAMS_BEYOND 2

static PetscErrorCode TSReset_Adams(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ADAMS_SLOTS; i++) PetscCall(VecDestroy(&ad->rate[i]));
  PetscCall(SlipAttemptsReset(ts));
  PetscCall(PetscFree(ad->inverse.inverse));
  ad->inverse.id[0] = 0;
  ad->n = 0;
  ad->rates[0] = ad->rates[1] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSSetUp_Adams(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < ad->max_order + 3; i++)
    if (!ad->rate[i]) PetscCall(VecDuplicate(ts->vec_sol, &ad->rate[i]));
  PetscCall(SlipAttemptsSetUp(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSSetFromOptions_Adams(TS ts, SlipOptionItems PetscOptionsObject)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscInt least = 1, most = SLIP_ADAMS_CORRECTIONS;
  PetscInt order = ad->max_order;
  PetscBool set;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Adams integrator options");
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)ts), ((PetscObject)ts)->options,
                                   ((PetscObject)ts)->prefix, "-ts_adams_max_order"));
  PetscCall(PetscOptionsInt("-ts_adams_max_order", "Highest order of the predictor; the step is one better",
                            "TSAdamsSetMaxOrder", order, &order, &set));
  if (set) PetscCall(TSAdamsSetMaxOrder(ts, order));
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)ts), ((PetscObject)ts)->options,
                                   ((PetscObject)ts)->prefix, "-ts_adams_max_corrections"));
  PetscCall(PetscOptionsInt("-ts_adams_max_corrections",
                            "Most corrections of a step, beyond one where it is not stable", NULL, ad->most, &ad->most,
                            NULL));
  PetscCheck(ad->most >= least && ad->most <= most, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adams_max_corrections is %" PetscInt_FMT ", expected a whole number from %" PetscInt_FMT
             " to %" PetscInt_FMT,
             ad->most, least, most);
  PetscOptionsHeadEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSView_Adams(TS ts, PetscViewer viewer)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (ascii)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  predictor of order %" PetscInt_FMT ", at most %" PetscInt_FMT "\n",
                                     ad->order, ad->max_order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdamsSetMaxOrder - sets the highest order of the predictor

  Logically collective; before TSSetUp()

  Input Parameters:
+ ts    - of type TSADAMS, ignored otherwise
- order - from 1 to 8; the order of a step is one more

  Options Database Key:
. -ts_adams_max_order <5> - the same

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for another order

.seealso: TSADAMS
@*/
PetscErrorCode TSAdamsSetMaxOrder(TS ts, PetscInt order)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSADAMS, &same));
  if (!same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(order >= 1 && order <= ADAMS_MAX, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adams_max_order is %" PetscInt_FMT ", expected a whole number from 1 to %d", order, ADAMS_MAX);
  ((TS_Adams *)ts->data)->max_order = order;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the default of -ts_adams_max_corrections for a TS of type TSADAMS. */
PetscErrorCode SlipAdamsSetCorrections(TS ts, PetscInt most)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSADAMS, &same));
  if (same) ((TS_Adams *)ts->data)->most = most;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step ---- */

/* Computes the weights of the estimate of order k, which is the change by its oldest derivative. */
static void EstimateWeights(const TS_Adams *ad, PetscReal h, PetscInt k, PetscReal weight[])
{
  PetscReal less[SLIP_ADAMS_NODES];

  SlipAdamsCorrector(ad, h, k, weight);
  SlipAdamsCorrector(ad, h, k - 1, less);
  for (PetscInt j = 0; j <= k; j++) weight[j] = h * (weight[j] - (j < k ? less[j] : 0));
}

/* Returns whether the estimate of the next higher order exists and is used. */
static PetscBool MayRaise(const TS_Adams *ad)
{
  return ad->order < ad->max_order && ad->n > ad->order && ad->since >= ad->order ? PETSC_TRUE : PETSC_FALSE;
}

/* Computes the norms of the estimates from the sums of each rank over entries with a tolerance, which ad->inverse or
   sums counts. good: all numbers are finite; useless norms become FAR_TOO_LONG. Collective. */
static PetscErrorCode TakeNorms(TS ts, const SlipVecsSums *sums, PetscBool inverse, PetscInt estimates, NormType type,
                                PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  PetscReal all[7];

  PetscFunctionBegin;
  all[6] = sums->finite ? 0 : 1;
  for (PetscInt k = 0; k < estimates; k++) {
    all[k] = type == NORM_INFINITY ? sums->most[k] : sums->squares[k];
    all[3 + k] = inverse ? ad->inverse.entries : sums->count[k];
  }
  for (PetscInt k = estimates; k < 3; k++) all[k] = all[3 + k] = 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 7, MPIU_REAL, type == NORM_INFINITY ? MPIU_MAX : MPIU_SUM,
                             PetscObjectComm((PetscObject)ts)));
  *good = all[6] == 0 ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt k = 0; k < estimates; k++) {
    const PetscReal norm = type == NORM_INFINITY ? all[k] : PetscSqrtReal(all[k] / PetscMax(all[3 + k], 1));

    /* a very short step can have no error, but controllers divide by the norm */
    ad->norms[k] = *good && norm < BOUNDS ? PetscMax(norm, 1e-10) : FAR_TOO_LONG;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = start + the sum of m derivatives times weight[0], where f* is the first if star is true, and the norms
   over all ranks of the estimates by the other weights. good is that of TakeNorms(). Collective. */
static PetscErrorCode AddUp(TS ts, PetscBool star, PetscInt m, const PetscReal weight[][SLIP_ADAMS_NODES],
                            PetscInt estimates, NormType type, Vec y, PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal *rate[SLIP_ADAMS_NODES], *start;
  SlipAdamsTolerance tolerance;
  PetscReal *to;
  Vec x[SLIP_ADAMS_NODES];
  SlipVecsSums sums;
  PetscBool done;
  PetscInt n;

  PetscFunctionBegin;
  for (PetscInt j = 0; j < m; j++) x[j] = star ? (j ? ad->rate[j - 1] : ad->star) : ad->rate[j];
  PetscCall(SlipVecsSum(ad->at.start, m, x, weight, estimates, ts->vatol, ts->vrtol, y, &sums, &done));
  if (done) {
    PetscCall(TakeNorms(ts, &sums, PETSC_FALSE, estimates, type, good));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (estimates) PetscCall(SlipAdamsGetTolerance(ts, &ad->inverse, &tolerance));
  if (estimates && ts->vatol) PetscCall(VecGetArrayRead(ts->vatol, &tolerance.absolutes));
  if (estimates && ts->vrtol) PetscCall(VecGetArrayRead(ts->vrtol, &tolerance.relatives));
  PetscCall(VecGetLocalSize(y, &n));
  for (PetscInt j = 0; j < m; j++) PetscCall(VecGetArrayRead(x[j], &rate[j]));
  PetscCall(VecGetArrayRead(ad->at.start, &start));
  PetscCall(VecGetArrayWrite(y, &to));
  SlipAdamsSum(n, start, m, rate, weight, estimates, &tolerance, to, &sums);
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscCall(VecRestoreArrayRead(ad->at.start, &start));
  for (PetscInt j = 0; j < m; j++) PetscCall(VecRestoreArrayRead(x[j], &rate[j]));
  if (estimates && ts->vatol) PetscCall(VecRestoreArrayRead(ts->vatol, &tolerance.absolutes));
  if (estimates && ts->vrtol) PetscCall(VecRestoreArrayRead(ts->vrtol, &tolerance.relatives));
  PetscCall(PetscLogFlops(2.0 * (estimates + 1) * (PetscLogDouble)m * (PetscLogDouble)n));
  PetscCall(TakeNorms(ts, &sums, tolerance.inverse ? PETSC_TRUE : PETSC_FALSE, estimates, type, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the corrected state y and the norms of its estimates. */
static PetscErrorCode Correct(TS ts, NormType type, Vec y, PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal h = ts->time_step;
  const PetscInt k = ad->order;
  const PetscBool more = ad->n > k ? PETSC_TRUE : PETSC_FALSE; /* one more derivative is stored */
  PetscReal weight[4][SLIP_ADAMS_NODES] = {{0}}, beyond[SLIP_ADAMS_NODES];

  PetscFunctionBegin;
  SlipAdamsCorrector(ad, h, k, weight[0]);
  if (more) SlipAdamsCorrector(ad, h, k + 1, beyond);
  for (PetscInt j = 0; j < k + 2; j++)
    weight[0][j] = h * (weight[0][j] + (more ? ADAMS_BEYOND * (beyond[j] - weight[0][j]) : 0));
  EstimateWeights(ad, h, k, weight[1]);
  if (k > 1) EstimateWeights(ad, h, k - 1, weight[2]);
  if (MayRaise(ad)) EstimateWeights(ad, h, k + 1, weight[3]);
  PetscCall(AddUp(ts, PETSC_TRUE, more ? k + 2 : k + 1, (const PetscReal(*)[SLIP_ADAMS_NODES])weight,
                  MayRaise(ad) ? 3 : 2, type, y, good));
  ad->type = type;
  ad->normed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the order of the next step and sets the norm of this step's estimate of that order. */
static void ChooseOrder(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscInt k = ad->order;
  PetscReal promise = SlipAdamsPromise(ts, ad->norms[0], k);

  ad->next = k;
  ad->norm = ad->norms[0];
  if (k > 1 && SlipAdamsPromise(ts, ad->norms[1], k - 1) > ADAMS_LOWER * promise) {
    ad->next = k - 1;
    ad->norm = ad->norms[1];
  } else if (MayRaise(ad) && SlipAdamsPromise(ts, ad->norms[2], k + 1) > ADAMS_RAISE * promise) {
    ad->next = k + 1;
    ad->norm = ad->norms[2];
  }
}

/* Returns the norm of the estimate for the order of the next step; an attempt computes it once. */
PetscErrorCode TSEvaluateWLTE_Adams(TS ts, NormType type, PetscInt *order, PetscReal *wlte)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  PetscBool good;

  PetscFunctionBegin;
  if (!ad->normed || ad->type != type) {
    PetscCall(Correct(ts, type, ad->y, &good));
    ad->estimated = PETSC_FALSE;
  }
  if (!ad->estimated) ChooseOrder(ts);
  ad->estimated = PETSC_TRUE;
  *wlte = ad->norm;
  if (order) *order = ad->next + 1;
  PetscCall(SlipHistoryError(ts, ts->vec_sol, wlte, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes vec_sol at the end of an attempt. If not good, the attempt left the domain of the right-hand side, and
   vec_sol is not defined. */
static PetscErrorCode Attempt(TS ts, PetscBool *good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal t = ts->ptime, h = ts->time_step;
  const PetscInt k = ad->order;
  PetscReal node[SLIP_ADAMS_NODES], weight[1][SLIP_ADAMS_NODES] = {{0}};

  PetscFunctionBegin;
  ad->estimated = ad->normed = PETSC_FALSE;
  ad->next = k;
  SlipAdamsCount(ts);
  for (PetscInt j = 0; j < k; j++) node[j] = -ad->age[j] / h;
  SlipAdamsWeights(k, node, weight[0]);
  for (PetscInt j = 0; j < k; j++) weight[0][j] *= h;
  PetscCall(AddUp(ts, PETSC_FALSE, k, (const PetscReal(*)[SLIP_ADAMS_NODES])weight, 0, ad->type, ad->y, good));
  PetscCall(TSPreStage(ts, t + h));
  if (*good) PetscCall(TSFunctionDomainError(ts, t + h, ad->y, good));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSComputeRHSFunction(ts, t + h, ad->y, ad->star));
  if (ad->corrections > 1) {
    PetscCall(SlipAdamsCorrectMore(ts, ad->y, ts->vec_sol, good));
    if (*good) PetscCall(Correct(ts, ts->adapt->wnormtype, ad->y, good)); /* the estimates, by the new derivative */
  } else
    PetscCall(Correct(ts, ts->adapt->wnormtype, ts->vec_sol, good));
  PetscCall(TSPostStage(ts, t + h, 0, &ts->vec_sol));
  if (*good) PetscCall(TSFunctionDomainError(ts, t + h, ts->vec_sol, good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Inserts a new derivative at the front, in the memory of the one that leaves at the end. */
static PetscErrorCode PushRate(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscInt last = ad->max_order + 2;
  Vec free_one = ad->rate[last];

  PetscFunctionBegin;
  for (PetscInt j = last; j > 0; j--) {
    ad->rate[j] = ad->rate[j - 1];
    ad->age[j] = ad->age[j - 1];
  }
  ad->rate[0] = free_one;
  ad->age[0] = 0;
  ad->n = PetscMin(ad->n + 1, ad->max_order + 1);
  if (ad->corrections > 1)
    PetscCall(VecCopy(ad->star, free_one));
  else
    PetscCall(TSComputeRHSFunction(ts, ts->ptime, ts->vec_sol, free_one));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Restarts from one derivative; the order grows again by one per step. */
static PetscErrorCode Begin(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  ad->n = 0;
  ad->order = 1;
  ad->since = 0;
  ad->corrections = 1;
  PetscCall(PushRate(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Start(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  if (ts->steprestart || !ad->n) PetscCall(Begin(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt Order(TS ts)
{
  return ((TS_Adams *)ts->data)->order + 1;
}

static PetscErrorCode Accept(TS ts)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  if (!ad->estimated) ad->next = PetscMin(PetscMin(ad->order + 1, ad->n), ad->max_order); /* as in constant steps */
  ad->dense = ad->order + 1;
  for (PetscInt j = 0; j < ad->n; j++) ad->age[j] += ad->at.h;
  ad->since = ad->next == ad->order ? ad->since + 1 : 0;
  ad->order = ad->next;
  PetscCall(ad->at.corner < PETSC_MAX_REAL ? Begin(ts) : PushRate(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives of earlier steps are useless for a much shorter step: after two rejected attempts, or one that left the
   domain, only the derivative at the start is used, and the order grows again. */
static PetscErrorCode Retry(TS ts, PetscBool good)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  ad->order = PetscMin(ad->next, ad->order);
  ad->since = 0;
  if (!good || ad->at.rejections >= RESTART_AFTER) ad->n = ad->order = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipAttemptOps SlipAdamsOps = {
  .begin = Start, .attempt = Attempt, .order = Order, .retry = Retry, .accept = Accept, .bound = SlipAdamsBoundStep};

/* Interpolates within the last step by the polynomial through both ends of the step whose slopes there, and at the
   starts of as many earlier steps as its order has, are the derivatives. For order 1 that is Hermite's cubic. Where
   rates grow tenfold in a step a cubic has an error of several tolerances. The difference between the step and the
   integral of the slopes is distributed as 6 x (1 - x), which is 0 at both ends. */
PetscErrorCode TSInterpolate_Adams(TS ts, PetscReal t, Vec x)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  const PetscReal s = PetscClipInterval((t - ad->at.before) / (ts->ptime - ad->at.before), 0, 1),
                  rest = s * s * (3 - 2 * s);
  PetscReal node[SLIP_ADAMS_NODES] = {1}, inner[SLIP_ADAMS_NODES], whole[SLIP_ADAMS_NODES], part[SLIP_ADAMS_NODES];

  PetscFunctionBegin;
  for (PetscInt j = 1; j < ad->dense; j++) node[j] = 1 - ad->age[j] / ad->at.h;
  SlipAdamsWeights(ad->dense, node, whole);
  for (PetscInt j = 0; j < ad->dense; j++) inner[j] = node[j] / PetscMax(s, PETSC_SMALL);
  SlipAdamsWeights(ad->dense, inner, part);
  for (PetscInt j = 0; j < ad->dense; j++) part[j] = ad->at.h * (s * part[j] - rest * whole[j]);
  PetscCall(VecCopy(ad->at.start, ad->y));
  PetscCall(VecAXPBY(ad->y, rest, 1 - rest, ts->vec_sol));
  PetscCall(VecMAXPY(ad->y, ad->dense, part, ad->rate));
  PetscCall(VecCopy(ad->y, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads what a checkpoint needs besides time, step and state. */
static PetscErrorCode State_Adams(TS ts, SlipState s)
{
  TS_Adams *ad = (TS_Adams *)ts->data;

  PetscFunctionBegin;
  if (!SlipStateIsLoading(s) && ts->steprestart) ad->n = 0; /* the next step restarts */
  PetscCall(SlipStateCount(s, "derivatives", ADAMS_MAX + 1, &ad->n));
  PetscCall(SlipStateInt(s, "order", 1, &ad->order));
  PetscCall(SlipStateInt(s, "steps_with_it", 1, &ad->since));
  PetscCall(SlipStateReal(s, "ages", ad->n, ad->age));
  PetscCall(SlipStateReal(s, "relaxation", 2, ad->rates));
  PetscCall(SlipStateReal(s, "last_step", 1, &ad->at.h));
  if (SlipStateIsLoading(s) && ad->n > ad->max_order + 1)
    SETERRQ(PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_INCOMP,
            "-ts_adams_max_order is %" PetscInt_FMT ", but the checkpoint has %" PetscInt_FMT " derivatives",
            ad->max_order, ad->n);
  PetscCall(SlipStateVecs(s, "derivative", ad->n, ad->rate));
  if (SlipStateIsLoading(s)) ts->steprestart = ad->n ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSADAMS - "adams": explicit Adams formulas of variable step and order, predictor and corrector, two right-hand sides a
  step, or more where stability needs them

  Options Database Keys:
+ -ts_adams_max_order <5>       - highest order of the predictor
- -ts_adams_max_corrections <7> - most corrections of a step, each one right-hand side; 1: two right-hand sides a step

  Level: beginner

  Notes:
  The method is for problems whose right-hand side (TSSetRHSFunction()) is smooth and expensive: explicit Runge-Kutta
  pairs evaluate it 3 (3bs) to 6 (5dp) times a step. Each step chooses its order anew, from 1 to the highest. TSAdapt
  types basic, dsp, pi, heuristic and rl control the step by the estimate of the next order. An attempt is rejected if
  it leaves the domain of the right-hand side (TSSetFunctionDomainError()) or is not finite; a step below the rounding
  of time is an error. After two rejected attempts the formulas restart at order 1. A constant step (TSADAPTNONE) that
  leaves the domain ends the run, because the equally long steps before it have made the state inaccurate.

  If the problem has the operation SlipStepOps.relaxation, the rate at which its solution relaxes, and the error
  allows steps that one correction does not make stable, a step with a predictor of order 1 to 4 has as many corrections
  as it needs: 2 to 5 for 6 to 28 relaxation times at order 2. Their error must be 40 times below the tolerance, because
  errors between events add up to those of the times of events. Constant steps, steps of rl, and steps of a fault with
  sticking friction and changing stress have one correction: kinks cause errors of one sign in longer steps.

  References:
. * - L. F. Shampine, M. K. Gordon, Computer Solution of Ordinary Differential Equations, Freeman, 1975.

.seealso: TSAdamsSetMaxOrder(), TSRK, TSBATHE
M*/
PetscErrorCode TSCreate_Adams(TS ts)
{
  TS_Adams *ad;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ad));
  ts->data = ad;
  ad->at = (SlipAttempts){
    .ops = &SlipAdamsOps, .nown = 5, .own = {&ad->at.start, &ad->star, &ad->y, &ad->room[0], &ad->room[1]}};
  ad->max_order = 5;
  ad->most = SLIP_ADAMS_CORRECTIONS;
  ad->corrections = 1;
  ts->ops->reset = TSReset_Adams;
  ts->ops->destroy = SlipAttemptsDestroy;
  ts->ops->view = TSView_Adams;
  ts->ops->setup = TSSetUp_Adams;
  ts->ops->setfromoptions = TSSetFromOptions_Adams;
  ts->ops->step = SlipAttemptsStep;
  ts->ops->evaluatewlte = TSEvaluateWLTE_Adams;
  ts->ops->rollback = SlipAttemptsRollBack;
  ts->ops->interpolate = TSInterpolate_Adams;
  ts->default_adapt_type = TSADAPTBASIC;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_STATE_METHOD, State_Adams));
  PetscFunctionReturn(PETSC_SUCCESS);
}
