/* TSADAPTRL: a trained policy chooses the step, and guard rails let a run continue where the policy fails. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipts.h>
#include <slipstep/rooms/sliph5.h>

/* After so many decisions in a row with an observation outside the training range a classical controller takes over. Of
   828 runs of random faults 3 were outside for one or two, and 101 for three or more: of these the policy reached the
   accuracy 1e-2 in 64 %, and the heuristic, from the third on, in 96 % (tests/benchmarks/verdict.py draws such
   faults). */
#define OUTSIDE_IN_A_ROW 3

/* The pace is measured over PACE_DECISIONS decisions. A run is stopped if the time left is more than PACE_WINDOWS times
   what they covered: at 0.1 ms a step it would take three hours at least. */
#define PACE_DECISIONS 10000
#define PACE_WINDOWS 10000

/*
  The run continues with a classical controller, as a run of that type would from here. There is no handover for actors,
  which learn from such runs, nor with -ts_adapt_rl_strict.
*/
static PetscErrorCode HandOver_RL(TSAdapt adapt, TS ts, const char why[])
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  if (rl->actor || rl->strict || rl->handed) PetscFunctionReturn(PETSC_SUCCESS);
  rl->handed = PETSC_TRUE;
  PetscCall(SlipClockRead(ts, &rl->handover_time, NULL));
  rl->handover_step = ts->steps;
  PetscCall(TSAdaptRLFallbackCreate_Private(adapt, ts));
  if (rl->printed) PetscFunctionReturn(PETSC_SUCCESS);
  rl->printed = PETSC_TRUE;
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)adapt),
                        "At time %g s rl hands the run over to %s with -ts_rtol %.3g, because %s (-ts_adapt_rl_strict "
                        "keeps the policy)\n",
                        (double)rl->handover_time, rl->fallback_name, (double)ts->rtol, why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A solve begins: the present state becomes the start. */
static PetscErrorCode Begin_RL(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  const char *source = "(actor)", *why = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLFindPolicy_Private(adapt, ts));
  PetscCall(SlipObserverStart(o, ts));
  PetscCall(TSAdaptRLClipDial_Private(adapt, &o->run.accuracy));
  rl->relative = PETSC_FALSE;
  if (rl->actor) {
    o->run.dt_min = rl->actor_dt[0];
    o->run.dt_max = rl->actor_dt[1];
  } else {
    PetscCall(SlipPolicyGetFile(rl->policy, &source));
    PetscCall(SlipPolicyIsRelative(rl->policy, &rl->relative));
    PetscCall(TSAdaptRLSetTolerance_Private(adapt, ts));
    PetscCall(SlipPolicyGetStepBounds(rl->policy, o->run.tstar, o->run.max_time, &o->run.dt_min, &o->run.dt_max));
  }
  PetscCall(TSAdaptRLFindGuards_Private(adapt));
  PetscCall(SlipObserverFindRows(o, rl->n, rl->seen, source));
  rl->begun = PETSC_TRUE;
  rl->steps = ts->steps;
  rl->handed = PETSC_FALSE;
  rl->outside_run = 0;
  rl->hold = 0;
  rl->solves_failed = ts->num_snes_failures;
  rl->paced = 0;
  if (o->problem && o->problem->control.untrained && !rl->relative)
    PetscCall((*o->problem->control.untrained)(ts, &why, o->ctx));
  if (why) PetscCall(HandOver_RL(adapt, ts, why));
  PetscCall(TSAdaptRLWarnOfIdle_Private(adapt, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the data of the last attempt; for a TS that records none, they are the arguments of the controller. */
static PetscErrorCode Record_RL(TSAdapt adapt, TS ts, PetscReal h, PetscBool converged, PetscBool need_error)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  SlipObserver *o = &((TSAdapt_RL *)adapt->data)->observer;
  SlipAttempt *last = &o->last;
  PetscErrorCode (*get)(TS, SlipAttempt *);
  PetscReal q = 0;

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, "TSBatheGetLastAttempt_C", &get));
  if (get) {
    PetscCall((*get)(ts, last));
  } else {
    PetscCall(PetscMemzero(last, sizeof(*last)));
    last->step = ts->steps;
    last->time = ts->ptime;
    last->dt = h;
    last->error = -1;
    last->residual = converged ? 0 : 2;
    last->solves = 1;
  }
  last->converged = converged;
  last->accepted = PETSC_FALSE;
  if (converged && need_error && (last->error < 0 || rl->relative))
    PetscCall(SlipAdaptEvaluateError(adapt, ts, &q, &last->error));
  if (q > 0) o->run.order = 1 / q;
  PetscCheck(!converged || !need_error || last->error >= 0, PetscObjectComm((PetscObject)adapt), PETSC_ERR_SUP,
             "-ts_adapt_type rl needs an error estimate (its policy observes accuracy, log_error, log_error_step or "
             "log_slip_error, or -ts_adapt_rl_error_ceiling is set), but -ts_type %s gives none; with bathe use "
             "-ts_bathe_error doubling or "
             "embedded",
             ((PetscObject)ts)->type_name);
  o->run.started = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Distance from a range, in widths of the range */
static PetscReal Excess(PetscReal x, PetscReal min, PetscReal max)
{
  const PetscReal beyond = PetscMax(min - x, x - max);

  return beyond <= 0 ? 0 : max > min ? beyond / (max - min) : PETSC_MAX_REAL;
}

/* Guard rail against situations that the policy was not trained for: counts them, prints one message, and hands the run
   over if they last */
static PetscErrorCode WatchRange_RL(TSAdapt adapt, TS ts, PetscInt outside)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const PetscReal *min, *max;
  const char *file;
  PetscInt worst = 0;

  PetscFunctionBegin;
  rl->outside_run = outside ? rl->outside_run + 1 : 0;
  if (rl->outside_run == OUTSIDE_IN_A_ROW)
    PetscCall(HandOver_RL(adapt, ts, "its observations stay outside the policy's training range"));
  if (!outside || rl->outside++) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(rl->policy, &file));
  PetscCall(SlipPolicyGetRange(rl->policy, &min, &max));
  for (PetscInt i = 1; i < rl->n; i++)
    if (Excess(rl->obs[i], min[i], max[i]) > Excess(rl->obs[worst], min[worst], max[worst])) worst = i;
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)adapt),
                        "Warning: at time %g s %" PetscInt_FMT " of %" PetscInt_FMT
                        " observations are outside the training range of policy %s, most of all %s = %g, in training "
                        "%g to %g. Compare with a run by -ts_adapt_type heuristic, or train a policy on such runs "
                        "(printed once; the summary and -ts_view count)\n",
                        (double)rl->observer.run.time, outside, rl->n, file, rl->seen[worst].name,
                        (double)rl->obs[worst], (double)min[worst], (double)max[worst]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Guard rail against a creeping fault, which always moves by the criteria of a policy for single events, so that its
   steps are limited to fractions of T*. Without -ts_adapt_rl_strict such a run is handed over; relative steps grow. */
static PetscErrorCode WatchPace_RL(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const SlipRunNumbers *run = &rl->observer.run;
  const PetscReal covered = run->time - rl->pace_time;

  PetscFunctionBegin;
  if (rl->paced++ % PACE_DECISIONS) PetscFunctionReturn(PETSC_SUCCESS);
  if (rl->paced > 1 && rl->strict && !rl->relative && covered * PACE_WINDOWS < run->max_time - run->time) {
    PetscCall(SlipRunFails(ts));
    SETERRQ(PetscObjectComm((PetscObject)adapt), PETSC_ERR_CONV_FAILED,
            "-ts_adapt_rl_strict keeps a policy whose last %d steps covered %g s, at time %g s, of %g s that are left: "
            "expected a run like those of its training. Without the option the run continues with %s",
            PACE_DECISIONS, (double)covered, (double)run->time, (double)(run->max_time - run->time),
            TSAdaptRLFallbackType_Private(rl));
  }
  rl->pace_time = run->time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the observations; the actor or the policy chooses the next step. */
static PetscErrorCode Decide_RL(TSAdapt adapt, TS ts, PetscBool state_changed, PetscBool guarded, PetscReal *h)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  const SlipProblemOps *problem = o->problem;
  PetscReal limit, t, rest = 0;
  PetscInt outside;
  PetscBool limited;
  Vec w;

  PetscFunctionBegin;
  if (!rl->actor && guarded) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(SLIP_Observe, adapt, ts, 0, 0));
  PetscCall(SlipObserve(o, rl->n, rl->seen, state_changed));
  PetscCall(PetscLogEventEnd(SLIP_Observe, adapt, ts, 0, 0));
  for (PetscInt i = 0; i < rl->n; i++) rl->obs[i] = rl->seen[i].value;
  rl->decisions++;
  if (rl->actor) {
    PetscCall((*rl->actor)(adapt, ts, rl->n, rl->obs, o->run.started ? &o->last : NULL, guarded, h, rl->actor_ctx));
    PetscCheck(*h > 0 && !PetscIsInfOrNanReal(*h), PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
               "The actor of TSAdaptRLSetActor() chose a step of %g s; expected a positive number", (double)*h);
  } else {
    PetscCall(PetscLogEventBegin(SLIP_Policy, adapt, 0, 0, 0));
    PetscCall(SlipPolicyChoose(rl->policy, rl->obs, o->run.tstar, o->run.max_time, h, &outside));
    PetscCall(PetscLogEventEnd(SLIP_Policy, adapt, 0, 0, 0));
    if (rl->relative) *h *= o->last.dt;
    /* A policy trained on a few cells cannot observe how few cells of a fine mesh may still slide. Its attribute
       therefore limits the step while any cell moves, and a step at rest lasts until a cell slips, which the problem
       computes. */
    PetscCall(SlipPolicyGetNumber(rl->policy, SLIP_POLICY_MOVING_DT_MAX, &limit, &limited));
    if (limited && problem && problem->control.rest_time) {
      PetscCall(TSGetTime(ts, &t));
      PetscCall(TSGetSolution(ts, &w));
      PetscCall((*problem->control.rest_time)(ts, t, w, &rest, o->ctx));
    }
    if (limited) *h = SlipControlRest(*h, limit * o->run.tstar, rest, o->run.max_time - o->run.time);
    PetscCall(WatchRange_RL(adapt, ts, outside));
    PetscCall(WatchPace_RL(adapt, ts));
  }
  *h = PetscClipInterval(*h, adapt->dt_min, adapt->dt_max);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptChooseFirst_RL(TSAdapt adapt, TS ts, PetscReal *h)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(Begin_RL(adapt, ts));
  if (rl->handed) PetscFunctionReturn(PETSC_SUCCESS);
  if (rl->relative)
    PetscCall(TSAdaptRLFirstStep_Private(adapt, ts, h));
  else
    PetscCall(Decide_RL(adapt, ts, PETSC_TRUE, PETSC_FALSE, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The policy's decision after an attempt that converged */
static PetscErrorCode Converged_RL(TSAdapt adapt, TS ts, PetscReal h, PetscReal *next_h, PetscBool *accept)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  const PetscBool limit = rl->ceiling > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscReal E, q;

  PetscFunctionBegin;
  PetscCall(Record_RL(adapt, ts, h, PETSC_TRUE, rl->needs_error || limit ? PETSC_TRUE : PETSC_FALSE));
  o->run.failures = 0;
  *accept = !limit || o->last.error <= rl->ceiling || adapt->always_accept ? PETSC_TRUE : PETSC_FALSE;
  o->last.accepted = *accept;
  if (*accept) {
    PetscCall(SlipClockRead(ts, &o->run.time, NULL));
    o->run.time += h;
  }
  SlipRunAttempt(&o->run, o->last.dt, PETSC_TRUE, *accept);
  PetscCall(Decide_RL(adapt, ts, *accept, *accept || rl->relative ? PETSC_FALSE : PETSC_TRUE, next_h));
  /* PETSc has shortened the step, perhaps more than once, after a failed solve: it must not grow back at once. */
  if (ts->num_snes_failures > rl->solves_failed) rl->hold = rl->hold_after_failure;
  rl->solves_failed = ts->num_snes_failures;
  if (rl->relative && rl->hold > 0) {
    *next_h = PetscMin(*next_h, h);
    rl->hold--;
  }
  if (*accept) PetscFunctionReturn(PETSC_SUCCESS);
  rl->ceilings++;
  if (rl->relative) {
    *next_h = SlipControlShrink(h, *next_h, o->run.rejected);
  } else {
    PetscCall(SlipAdaptEvaluateError(adapt, ts, &q, &E));
    *next_h = h * SlipControlCeiling(o->last.error, rl->ceiling, q);
  }
  PetscCall(
    SlipAdaptCheckMinimum(adapt, ts, *next_h, rl->relative ? "the error estimate" : "-ts_adapt_rl_error_ceiling"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptChoose_RL(TSAdapt adapt, TS ts, PetscReal h, PetscInt *next_sc, PetscReal *next_h,
                                       PetscBool *accept, PetscReal *wlte, PetscReal *wltea, PetscReal *wlter)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  *next_sc = 0;
  *wltea = *wlter = -1;
  *next_h = h;
  if (!rl->begun || ts->steps < rl->steps) PetscCall(Begin_RL(adapt, ts));
  rl->steps = ts->steps;
  if (!rl->handed) {
    PetscCall(Converged_RL(adapt, ts, h, next_h, accept));
    *wlte = rl->observer.last.error;
  }
  /* Also for the attempt that causes the handover: the new controller accepts or rejects it. */
  if (rl->handed) PetscCall(TSAdaptRLFallbackChoose_Private(adapt, ts, h, next_sc, next_h, accept, wlte, wltea, wlter));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The policy's decision after an attempt that did not converge */
static PetscErrorCode Failed_RL(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipObserver *o = &rl->observer;
  PetscReal halved = h_failed;
  PetscBool guarded;

  PetscFunctionBegin;
  PetscCall(Record_RL(adapt, ts, h_failed, PETSC_FALSE, PETSC_FALSE));
  o->last.dt = h_failed;
  SlipRunAttempt(&o->run, h_failed, PETSC_FALSE, PETSC_FALSE);
  o->run.failures++;
  rl->failures++;
  guarded = SlipControlHalve(o->run.failures, rl->relative ? 1 : rl->max_failures, &halved);
  PetscCall(Decide_RL(adapt, ts, PETSC_FALSE, guarded, h_next));
  if (!guarded) PetscFunctionReturn(PETSC_SUCCESS);
  rl->halvings++;
  *h_next = halved;
  PetscCall(SlipAdaptCheckMinimum(adapt, ts, *h_next, "a solve that did not converge"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptChooseAfterFailure_RL(TSAdapt adapt, TS ts, PetscReal h_failed, PetscReal *h_next)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  if (!rl->begun) PetscCall(Begin_RL(adapt, ts));
  if (!rl->handed) PetscCall(Failed_RL(adapt, ts, h_failed, h_next));
  if (rl->handed) PetscCall(TSAdaptRLFallbackAfterFailure_Private(adapt, ts, h_failed, h_next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The trainer's rewards contain the error, so that an actor always needs it. */
static PetscErrorCode TSAdaptNeedsError_RL(TSAdapt adapt, PetscBool *flg)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  *flg = rl->needs_error || rl->error_ceiling > 0 || rl->actor || rl->handed ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
static PetscErrorCode TSAdaptSetFromOptions_RL(TSAdapt adapt, SlipOptionItems PetscOptionsObject)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscReal accuracy = rl->accuracy;
  char measure[64] = "";
  PetscBool set, dial, measured;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Learned step-size controller options");
  PetscCall(PetscOptionsString("-ts_adapt_rl_policy",
                               "HDF5 file with the policy (default: the one of the problem in the policies that come "
                               "with the library, else ode.h5)",
                               "TSAdaptRLSetPolicyFile", file, file, sizeof(file), &set));
  PetscCall(PetscOptionsString("-ts_adapt_rl_problem",
                               "Problem whose default policy is used when -ts_adapt_rl_policy is not given, or for "
                               "which the given one was trained (fault, ...; default: that of the TS)",
                               "SlipPolicyFindDefault", rl->problem, rl->problem, sizeof(rl->problem), NULL));
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)adapt), ((PetscObject)adapt)->options,
                                   ((PetscObject)adapt)->prefix, "-ts_adapt_rl_max_failures"));
  PetscCall(PetscOptionsInt("-ts_adapt_rl_max_failures",
                            "Failed attempts in a row before steps are halved until one converges, >= 1", "",
                            rl->max_failures, &rl->max_failures, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_rl_error_ceiling",
                             "Larger error estimates reject and shrink the step; 0: the limit of the policy, or none",
                             "", rl->error_ceiling, &rl->error_ceiling, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_rl_accuracy",
                             "Relative error that the run should keep, 1e-4 to 1e-1, for policies that observe it; a "
                             "value outside of the policy's range (printed) is replaced by the end of that range",
                             "TSAdaptRLSetAccuracy", accuracy, &accuracy, &dial));
  PetscCall(PetscOptionsString("-ts_adapt_rl_measure",
                               "Error that -ts_adapt_rl_accuracy bounds: history (the largest), final_slip or "
                               "event_time (default: the policy's; a policy trained for another one is refused)",
                               "TSAdaptRLSetMeasure", rl->measure ? rl->measure->name : SlipMeasures[0].name, measure,
                               sizeof(measure), &measured));
  PetscCall(PetscOptionsBool("-ts_adapt_rl_strict",
                             "Keep the policy in runs unlike those of its training, an error if its steps would not "
                             "reach the end; otherwise such runs continue with a classical controller (default no)",
                             "TSAdaptRLSetStrict", rl->strict, &rl->strict, NULL));
  PetscOptionsHeadEnd();
  PetscCall(TSAdaptRLFallbackOptions_Private(adapt, PetscOptionsObject));
  if (dial) PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
  if (measured) PetscCall(TSAdaptRLSetMeasure(adapt, measure));
  PetscCheck(rl->max_failures >= 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_rl_max_failures is %" PetscInt_FMT "; expected at least 1", rl->max_failures);
  PetscCheck(rl->error_ceiling >= 0, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_rl_error_ceiling is %g; expected a positive number, or 0 for none", (double)rl->error_ceiling);
  PetscCheck(!set || file[0], PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_WRONG,
             "-ts_adapt_rl_policy has no value, expected the name of a file");
  if (set) {
    PetscCall(
      SlipH5CheckRead(PetscObjectComm((PetscObject)adapt), ((PetscObject)adapt)->prefix, "ts_adapt_rl_policy", file));
    PetscCall(TSAdaptRLSetPolicyFile(adapt, file));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSAdaptView() calls it only for ASCII viewers */
static PetscErrorCode TSAdaptView_RL(TSAdapt adapt, PetscViewer viewer)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  const char *measure;

  PetscFunctionBegin;
  PetscCall(PetscViewerASCIIPushTab(viewer));
  if (rl->actor) PetscCall(PetscViewerASCIIPrintf(viewer, "steps are chosen by an actor\n"));
  if (rl->policy) PetscCall(SlipPolicyView(rl->policy, viewer));
  if (rl->default_of[0])
    PetscCall(PetscViewerASCIIPrintf(viewer, "it is the default policy of the problem %s\n", rl->default_of));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "accuracy dial %g%s\n", (double)rl->accuracy,
    rl->sees_accuracy || !rl->n ? "" : " (ignored: the policy does not observe " SLIP_OBSERVES_ACCURACY ")"));
  PetscCall(TSAdaptRLGetMeasure(adapt, &measure));
  PetscCall(PetscViewerASCIIPrintf(viewer, "measure of the error: %s\n", measure));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "guard rails: steps are halved after %" PetscInt_FMT " failures in a row; error ceiling %g (0: none)\n",
    rl->max_failures, (double)(rl->begun ? rl->ceiling : rl->error_ceiling)));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "decisions %" PetscInt_FMT ", outside the training range %" PetscInt_FMT
                                   ", failed attempts %" PetscInt_FMT ", halved steps %" PetscInt_FMT
                                   ", rejected by the ceiling %" PetscInt_FMT "\n",
                                   rl->decisions, rl->outside, rl->failures, rl->halvings, rl->ceilings));
  if (rl->strict) PetscCall(PetscViewerASCIIPrintf(viewer, "never handed over\n"));
  if (rl->handed)
    PetscCall(
      PetscViewerASCIIPrintf(viewer, "handed over to %s at time %g s\n", rl->fallback_name, (double)rl->handover_time));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptReset_RL(TSAdapt adapt)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(SlipObserverReset(&rl->observer));
  PetscCall(TSAdaptDestroy(&rl->fallback));
  rl->handed = PETSC_FALSE;
  /* A default policy is looked up again, because the next problem may be another one. */
  if (rl->default_of[0]) PetscCall(SlipPolicyDestroy(&rl->policy));
  rl->default_of[0] = 0;
  rl->begun = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A solve has begun. If the file's policy is another one, this policy starts with its next observation. */
static PetscErrorCode SlipState_RL(TSAdapt adapt, SlipState s)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  SlipRunNumbers *run = &rl->observer.run;
  const char *hash;
  PetscBool same, start = PETSC_FALSE;
  char name[32];

  PetscFunctionBegin;
  if (!rl->policy) PetscFunctionReturn(PETSC_SUCCESS); /* there is an actor instead */
  PetscCall(SlipStateInt(s, "decisions", 1, &rl->decisions));
  PetscCall(SlipStateInt(s, "failures", 1, &rl->failures));
  PetscCall(SlipStateInt(s, "halvings", 1, &rl->halvings));
  PetscCall(SlipStateInt(s, "ceilings", 1, &rl->ceilings));
  PetscCall(SlipStateInt(s, "outside", 1, &rl->outside));
  PetscCall(SlipStateInt(s, "steps", 1, &rl->steps));
  PetscCall(SlipStateBool(s, "handed_over", &rl->handed));
  PetscCall(SlipStateReal(s, "handover_time", 1, &rl->handover_time));
  PetscCall(SlipStateInt(s, "handover_step", 1, &rl->handover_step));
  PetscCall(SlipStateBool(s, "told", &rl->printed));
  PetscCall(SlipStateInt(s, "outside_in_a_row", 1, &rl->outside_run));
  if (rl->handed && !rl->fallback) PetscCall(TSAdaptRLFallbackCreate_Private(adapt, rl->observer.ts));
  if (rl->handed) {
    PetscCall(SlipStateController(s, "heir", rl->fallback));
    PetscCall(SlipStateGroup(s, "adapt")); /* the fallback's memory has the names below as well */
  }
  PetscCall(SlipPolicyGetHash(rl->policy, &hash));
  PetscCall(SlipStateSame(s, "policy", hash, &same));
  if (!same)
    PetscCall(PetscPrintf(
      PetscObjectComm((PetscObject)adapt),
      "The run continues with another policy than its checkpoint's (-ts_adapt_rl_policy), of hash %s\n", hash));
  if (!same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateAttempt(s, &rl->observer.last));
  PetscCall(SlipStateBool(s, "started", &run->started));
  PetscCall(SlipStateBool(s, "converged", &run->converged));
  PetscCall(SlipStateReal(s, "error", 1, &run->error));
  PetscCall(SlipStateReal(s, "residual", 1, &run->residual));
  PetscCall(SlipStateReal(s, "dt", 1, &run->dt));
  PetscCall(SlipStateInt(s, "failures_in_a_row", 1, &run->failures));
  PetscCall(SlipStateReal(s, "time", 1, &run->time));
  if (rl->relative) {
    PetscCall(SlipStateReal(s, "order", 1, &run->order));
    PetscCall(SlipStateBool(s, "accepted", &run->accepted));
    PetscCall(SlipStateReal(s, "dt_before", 1, &run->dt_before));
    PetscCall(SlipStateInt(s, "rejected_in_a_row", 1, &run->rejected));
    PetscCall(SlipStateReal(s, "rejections", 1, &run->rejections));
    PetscCall(SlipStateInt(s, "hold", 1, &rl->hold));
  }
  /* Observations that the problem does not supply refer to the start, which is therefore part of the state. */
  PetscCall(SlipStateReal(s, "norm_of_start", 1, &rl->observer.run.norm0));
  PetscCall(SlipStateReal(s, "largest_of_start", 1, &rl->observer.run.max0));
  for (PetscInt i = 0; i < rl->n; i++)
    if (SlipObservedOfState(&rl->seen[i]) && rl->seen[i].own < 0) start = PETSC_TRUE;
  if (start) PetscCall(SlipStateVec(s, "start", rl->observer.w0));
  for (PetscInt i = 0; i < rl->n; i++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "has_base_%" PetscInt_FMT, i));
    PetscCall(SlipStateBool(s, name, &rl->seen[i].has_base));
    PetscCall(PetscSNPrintf(name, sizeof(name), "base_%" PetscInt_FMT, i));
    PetscCall(SlipStateReal(s, name, 1, &rl->seen[i].base));
    PetscCall(PetscSNPrintf(name, sizeof(name), "value_%" PetscInt_FMT, i));
    PetscCall(SlipStateReal(s, name, 1, &rl->seen[i].value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Composes the functions that TSBATHE and checkpoints look up by name, and removes them on destruction. */
static PetscErrorCode Compose_RL(TSAdapt adapt, PetscBool on)
{
  const struct {
    const char *name;
    void (*fn)(void);
  } methods[] = {
    {"TSAdaptChooseFirst_C", (void (*)(void))TSAdaptChooseFirst_RL},
    {"TSAdaptChooseAfterFailure_C", (void (*)(void))TSAdaptChooseAfterFailure_RL},
    {"TSAdaptNeedsError_C", (void (*)(void))TSAdaptNeedsError_RL},
    {"TSAdaptResume_C", (void (*)(void))Begin_RL},
    {SLIP_STATE_METHOD, (void (*)(void))SlipState_RL},
  };

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(methods); i++)
    PetscCall(PetscObjectComposeFunction((PetscObject)adapt, methods[i].name, on ? methods[i].fn : NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptDestroy_RL(TSAdapt adapt)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(TSAdaptReset_RL(adapt));
  PetscCall(Compose_RL(adapt, PETSC_FALSE));
  PetscCall(SlipPolicyDestroy(&rl->policy));
  PetscCall(PetscFree2(rl->seen, rl->obs));
  PetscCall(PetscFree(adapt->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSADAPTRL - chooses steps by a trained policy

  The policy maps an observation of the last attempt to the next step, and every converged step is accepted. Only the
  observations that its file lists are computed: without accuracy or log_error the TS skips its error estimate.

  Guard rails: after max_failures failed attempts in a row the step is halved until one converges, because a policy may
  repeat a failing step forever for the same observation; with an error ceiling a step with a larger estimate is
  repeated with the heuristic's h (E/ceiling)^(-q), limited to [0.1, 0.9] h; observations outside the training range are
  counted and reported once.

  A classical controller takes over a run for good, with one line of message, if the problem states that no policy was
  trained for it (a loaded fault), at the start, or after three decisions in a row with an observation outside the
  training range. The problem names the controller (SlipProblemOps); the default is TSADAPTHEURISTIC. The rest is a run
  of that type, with its options and -ts_rtol; without that option the problem sets the tolerance with which that type
  reaches the wanted accuracy, if it has one. If -ts_adapt_rl_strict forbids this and 10,000 decisions have covered less
  than 1e-4 of the time left, as on a creeping fault, the run ends with an error.

  A policy whose steps are multiples of the last one (unit "h" of its action, such as the general policy ode.h5, which
  problems without their own policy use) relies on the error estimate: E > 1, or above the policy's attribute
  error_ceiling, rejects the attempt; the step after a rejection is at most 0.9 h, or 0.5 h after two in a row, and h/2
  after a failed solve; the first step is that of the TS. After a failed solve the step does not grow for four attempts,
  or as many as the policy's attribute hold.

  A policy with the attribute rtol_factor was trained with a tolerance that depends on the wanted accuracy a: -ts_rtol
  is rtol_factor a^rtol_power unless the option is given, and then a message says so. Likewise the first step is
  first_step_factor a^first_step_power T* unless -ts_dt is given.

  With a TS other than bathe, PETSc handles failed solves (-ts_adapt_scale_solve_failed), the residual is 0, the first
  step is that of the TS, and energy, velocity and state_k refer to the first state that the controller gets.

  Options Database Keys:
+ -ts_adapt_rl_policy <file.h5>      - the policy; without it, TSAdaptRLSetPolicy() or an actor, the problem's default
. -ts_adapt_rl_problem <name>        - the problem whose default policy is used, see SlipPolicyFindDefault()
. -ts_adapt_rl_accuracy <1e-2>       - wanted relative error of the run, for policies that observe log_accuracy
. -ts_adapt_rl_measure <history>     - which error that is, see TSAdaptRLSetMeasure()
. -ts_adapt_rl_max_failures <3>      - failed attempts in a row before steps are halved
. -ts_adapt_rl_error_ceiling <0>     - largest accepted error estimate; 0: the policy's own, else none
- -ts_adapt_rl_strict <no>           - never hand a run over

  Level: beginner

.seealso: SlipPolicy, TSAdaptRLSetPolicy(), TSAdaptRLSetActor(), TSADAPTHEURISTIC
M*/
PetscErrorCode TSAdaptCreate_RL(TSAdapt adapt)
{
  TSAdapt_RL *rl;

  PetscFunctionBegin;
  PetscCall(PetscNew(&rl));
  adapt->data = rl;
  rl->max_failures = SLIP_MAX_FAILURES;
  rl->accuracy = TSADAPTRL_ACCURACY_DEFAULT;
  PetscCall(Compose_RL(adapt, PETSC_TRUE));
  adapt->ops->choose = TSAdaptChoose_RL;
  adapt->ops->setfromoptions = TSAdaptSetFromOptions_RL;
  adapt->ops->view = TSAdaptView_RL;
  adapt->ops->reset = TSAdaptReset_RL;
  adapt->ops->destroy = TSAdaptDestroy_RL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
