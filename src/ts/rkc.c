/* TSRKC as a PETSc TS type: explicit steps of second order with as many stages as stability needs, by the formulas of
   Runge, Kutta and Chebyshev (rkcweights.c). The longest stable step on the negative real axis is proportional to the
   square of the number of stages. Accuracy can thus choose the step where relaxation rates range from slow to fast, as
   those of slip without inertia do, which grow as cells become smaller.

   The error estimate is that of the paper, 0.8 (y_n - y_n+1) + 0.4 h (f_n + f_n+1), of order h^3; f_n+1 begins the next
   step. Hermite's cubic interpolates between both ends. */
#include <slipstep/private/slipts.h>

/* Upper bound of the number of steps; no run has so many */
#define MOST_STEPS 1e12

typedef struct {
  SlipAttempts at;
  PetscInt max_stages;
  PetscReal asked; /* fastest rate that the user gave [1/s]; 0: the problem computes it */
  PetscReal rate;  /* fastest rate at which the solution relaxes from the step's start [1/s] */
  PetscInt stages; /* number of stages of the last attempt */
  Vec end;         /* rates at the end of the step */
  Vec y[2], work;  /* the last two stages; rates and errors */
  Vec f0;          /* rates at the start of the last step */
} TS_RKC;

static PetscErrorCode TSSetFromOptions_RKC(TS ts, SlipOptionItems PetscOptionsObject)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  PetscInt stages = rkc->max_stages;
  PetscBool set;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Runge-Kutta-Chebyshev integrator options");
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)ts), ((PetscObject)ts)->options,
                                   ((PetscObject)ts)->prefix, "-ts_rkc_max_stages"));
  PetscCall(PetscOptionsInt("-ts_rkc_max_stages", "Most stages of a step, which bound its length", "TSRKCSetMaxStages",
                            stages, &stages, &set));
  if (set) PetscCall(TSRKCSetMaxStages(ts, stages));
  PetscCall(PetscOptionsReal("-ts_rkc_rate", "Fastest rate of relaxation [1/s]; 0: the problem knows it", NULL,
                             rkc->asked, &rkc->asked, NULL));
  PetscCheck(rkc->asked >= 0 && !PetscIsInfOrNanReal(rkc->asked), PetscObjectComm((PetscObject)ts),
             PETSC_ERR_ARG_OUTOFRANGE, "-ts_rkc_rate is %g, expected a number >= 0 [1/s]", (double)rkc->asked);
  PetscOptionsHeadEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSView_RKC(TS ts, PetscViewer viewer)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (ascii)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  %" PetscInt_FMT " stages in the last step, at most %" PetscInt_FMT "\n",
                                     rkc->stages, rkc->max_stages));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSRKCSetMaxStages - sets the largest number of stages of a step

  Logically collective

  Input Parameters:
+ ts     - of type TSRKC, ignored otherwise
- stages - from 2 to 200; steps are cut to what is stable with so many

  Options Database Key:
. -ts_rkc_max_stages <100> - the same

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for another number

.seealso: TSRKC
@*/
PetscErrorCode TSRKCSetMaxStages(TS ts, PetscInt stages)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSRKC, &same));
  if (!same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(stages >= 2 && stages <= SLIP_RKC_MOST, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_rkc_max_stages is %" PetscInt_FMT ", expected a whole number from 2 to %d", stages, SLIP_RKC_MOST);
  ((TS_RKC *)ts->data)->max_stages = stages;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step ---- */

/* Computes in y[1] the state after a step h of s stages from start, where the side is f; overwrites y[0] and work. */
PetscErrorCode SlipChebyshevStages(TS ts, SlipSideFn side, PetscReal t, PetscReal h, PetscInt s, Vec start, Vec f,
                                   Vec y[2], Vec work)
{
  SlipRKCStage c[SLIP_RKC_MOST + 1];

  PetscFunctionBegin;
  SlipRKCCoefficients(s, c);
  PetscCall(VecCopy(start, y[0]));
  PetscCall(VecWAXPY(y[1], c[1].rate * h, f, start));
  for (PetscInt j = 2; j <= s; j++) {
    const Vec last = y[1], v[] = {start, last, work, f};
    const PetscScalar a[] = {1 - c[j].one - c[j].two, c[j].one, c[j].rate * h, c[j].start * h};

    PetscCall(TSPreStage(ts, t + c[j - 1].share * h));
    PetscCall((*side)(ts, t + c[j - 1].share * h, last, work));
    PetscCall(VecScale(y[0], c[j].two));
    PetscCall(VecMAXPY(y[0], 4, a, (Vec *)v));
    y[1] = y[0];
    y[0] = last;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the error e of a step h between two states from their right-hand sides. */
PetscErrorCode SlipChebyshevError(PetscReal h, Vec start, Vec end, Vec f_start, Vec f_end, Vec e)
{
  const Vec v[] = {start, end, f_start, f_end};
  const PetscScalar a[] = {0.8, -0.8, 0.4 * h, 0.4 * h};

  PetscFunctionBegin;
  PetscCall(VecZeroEntries(e));
  PetscCall(VecMAXPY(e, 4, a, (Vec *)v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(TS ts)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;

  PetscFunctionBegin;
  rkc->rate = rkc->asked;
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  PetscCheck(rkc->rate > 0 || (problem && problem->steps.relaxation), PetscObjectComm((PetscObject)ts),
             PETSC_ERR_ARG_WRONGSTATE,
             "-ts_type " TSRKC " needs the fastest rate at which the problem relaxes: expected -ts_rkc_rate [1/s]");
  if (!(rkc->rate > 0)) PetscCall((*problem->steps.relaxation)(ts, rkc->at.start, &rkc->rate, ctx));
  rkc->rate *= SLIP_RATE_MARGIN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Limit(TS ts)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  PetscReal longest;

  PetscFunctionBegin;
  if (!(rkc->rate > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  longest = SlipRKCLongest(rkc->max_stages) / rkc->rate;
  PetscCheck(
    !(rkc->asked > 0) || ts->max_time >= PETSC_MAX_REAL || longest * MOST_STEPS >= ts->max_time - ts->ptime,
    PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
    "-ts_rkc_rate %g 1/s allows steps of %g s at most, of which the run of another %g s would take more than %g",
    (double)rkc->asked, (double)longest, (double)(ts->max_time - ts->ptime), (double)MOST_STEPS);
  ts->time_step = PetscMin(ts->time_step, longest);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes vec_sol and its rates at the end of an attempt. If not good, the attempt left the domain of the right-hand
   side, and vec_sol is not defined. */
static PetscErrorCode Attempt(TS ts, PetscBool *good)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  const PetscReal t = ts->ptime, h = ts->time_step;
  const PetscInt s = PetscMin((PetscInt)SlipRKCStages(h * rkc->rate), rkc->max_stages);

  PetscFunctionBegin;
  rkc->stages = s;
  PetscCall(SlipChebyshevStages(ts, TSComputeRHSFunction, t, h, s, rkc->at.start, rkc->at.f, rkc->y, rkc->work));
  PetscCall(VecCopy(rkc->y[1], ts->vec_sol));
  PetscCall(TSPostStage(ts, t + h, 0, &ts->vec_sol));
  PetscCall(SlipGuardState(ts->vec_sol, good));
  if (*good) PetscCall(TSFunctionDomainError(ts, t + h, ts->vec_sol, good));
  if (*good) PetscCall(TSComputeRHSFunction(ts, t + h, ts->vec_sol, rkc->end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSEvaluateWLTE_RKC(TS ts, NormType type, PetscInt *order, PetscReal *wlte)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;

  PetscFunctionBegin;
  PetscCall(SlipChebyshevError(ts->time_step, rkc->at.start, ts->vec_sol, rkc->at.f, rkc->end, rkc->work));
  PetscCall(SlipAttemptsError(ts, rkc->work, type, order, wlte));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Accept(TS ts)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  const Vec f0 = rkc->f0;

  PetscFunctionBegin;
  rkc->f0 = rkc->at.f;
  rkc->at.f = rkc->end;
  rkc->end = f0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipAttemptOps ops = {.begin = Begin, .limit = Limit, .attempt = Attempt, .accept = Accept};

static PetscErrorCode TSInterpolate_RKC(TS ts, PetscReal t, Vec x)
{
  TS_RKC *rkc = (TS_RKC *)ts->data;
  const PetscReal s = PetscClipInterval((t - rkc->at.before) / (ts->ptime - rkc->at.before), 0, 1),
                  rest = s * s * (3 - 2 * s);
  const Vec v[] = {ts->vec_sol, rkc->f0, rkc->at.f};
  const PetscScalar a[] = {rest, rkc->at.h * s * (1 - s) * (1 - s), -rkc->at.h * s * s * (1 - s)};

  PetscFunctionBegin;
  PetscCall(VecCopy(rkc->at.start, rkc->work));
  PetscCall(VecScale(rkc->work, 1 - rest));
  PetscCall(VecMAXPY(rkc->work, 3, a, (Vec *)v));
  PetscCall(VecCopy(rkc->work, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSRKC - "rkc": explicit stabilised formulas of second order, Runge, Kutta and Chebyshev's, with as many stages a step
  as stability needs

  Options Database Keys:
+ -ts_rkc_max_stages <100> - most stages of a step, which bound its length
- -ts_rkc_rate <0>         - fastest rate at which the problem relaxes [1/s]; 0: the problem computes it

  Level: beginner

  Notes:
  The method is for problems without inertia whose right-hand side (TSSetRHSFunction()) is expensive, continuous but not
  smooth, and relaxes at real rates from slow to fast. s stages are stable over 0.65 (s^2 - 1) of the shortest
  relaxation times; a stage of an explicit pair or of TSADAMS is over 0.8 to 1.5. The fastest rate comes from the
  problem (SlipStepOps.relaxation) or from -ts_rkc_rate. TSAdapt types basic, dsp, pi and heuristic control the step;
  constant steps take the stages that they need.

  Errors: PETSC_ERR_ARG_WRONGSTATE where neither the problem nor the option gives the rate

  References:
. * - B. P. Sommeijer, L. F. Shampine, J. G. Verwer, RKC: an explicit solver for parabolic PDEs, J. Comput. Appl. Math.
  88, 1998.

.seealso: TSRKCSetMaxStages(), TSADAMS, TSRK, TSBATHE
M*/
PetscErrorCode TSCreate_RKC(TS ts)
{
  TS_RKC *rkc;

  PetscFunctionBegin;
  PetscCall(PetscNew(&rkc));
  ts->data = rkc;
  rkc->at =
    (SlipAttempts){.ops = &ops,
                   .nown = 7,
                   .own = {&rkc->at.start, &rkc->at.f, &rkc->end, &rkc->y[0], &rkc->y[1], &rkc->work, &rkc->f0}};
  rkc->max_stages = 100;
  ts->ops->reset = SlipAttemptsReset;
  ts->ops->destroy = SlipAttemptsDestroy;
  ts->ops->view = TSView_RKC;
  ts->ops->setup = SlipAttemptsSetUp;
  ts->ops->setfromoptions = TSSetFromOptions_RKC;
  ts->ops->step = SlipAttemptsStep;
  ts->ops->evaluatewlte = TSEvaluateWLTE_RKC;
  ts->ops->rollback = SlipAttemptsRollBack;
  ts->ops->interpolate = TSInterpolate_RKC;
  ts->default_adapt_type = TSADAPTBASIC;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_STATE_METHOD, SlipAttemptsState));
  PetscFunctionReturn(PETSC_SUCCESS);
}
