/* Estimates the errors of a run from the integrator's local error estimates: here that of its final slip, and in
   courseestimate.c that of its timing.

   An error of one step changes the final slip through everything that follows. For a fault this has a short formula, as
   the final slip does not depend on times. P = v.M v/2 + u.K u/2 + (integral of q over s) is the energy that can still
   do work, and dP/dt = -v.H v. A local error e = (e_v, e_u, e_s) of the state is a step along the trajectory, which
   changes only the timing, and a change of P,
       dP = M v.e_v + K u.e_u + q.e_s.
   Along the slip, dP/ds = -H v with v = sqrt(2 (P - P_potential)/M), so that a change of P decays as exp(-H/M t), here
   with H/M = 2 zeta w, w^2 = uc.K uc / (uc.M uc) the frequency of the critical displacement. When everything rests, a
   longer or shorter slip balances the remaining changes. With slips in proportion to the present ones, s_i/mean(s),
       (error of mean slip) = dP / sum_i (K u + q)_i s_i / mean(s).
   Cells stop one after another, and the share of dP in their slip then decays no more: the decay is proportional to
   the share of the slip on cells that still slide. For one cell under slip weakening all this is the exact first
   variation. */
#include <slipstep/private/sliprun.h>
#include <slipstep/rooms/slipadapt.h>

/*
  The reported error is one that nine in ten runs stay below (19 in 20 of 4 or 5 steps, for the final slip). It is a
  factor that depends on the number of steps, times, for the final slip and relative to it,
      (late + share of the slip made in steps in which cells come to rest) max(|signed|, floor magnitudes)
  for the time of the event, over the time from 10 to 90 % of the slip,
      max(|signed|, shift_floor magnitudes)
  and for the history the sum of the latter, history_final times the former, and the error of the cubic between the ends
  of a step.
  First variations hold for one smooth event. With few steps, or with several events, the signs of local errors mean
  little, so that the sum of their magnitudes counts too. A stop within a step is an error that no smooth formula
  contains, so that slip in such steps counts more. All numbers come from a file (estimatefile.c), which
  tests/benchmarks/verdict.py --calibrate makes.
*/
static const struct {
  const char *name, *label; /* of attributes, and in the summary */
} Estimates[NUM_ESTIMATES] = {{"history", "history"}, {"slip", "slip"}, {"event_time", "time"}};
static const char *const Measured[NUM_ESTIMATES] = {"history", "final_slip", "event_time"}; /* their SlipMeasures */

/* Sums for the state w after a step and its error e; costs a product with K, unless the step has computed it. */
static PetscErrorCode StepSums(SlipFault fault, PetscReal t, Vec w, Vec e, PetscReal sum[STEP_SUMS])
{
  Vec u, ku;
  PetscBool rests;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &ku));
  PetscCall(SlipElasticRests(fault->medium, &rests));
  PetscCall(SlipFaultForce(fault, t, w, u, ku));
  if (!rests) PetscCall(SlipElasticApply(fault->medium, u, ku, NULL));
  PetscCall((*fault->cell_ops->step)(fault, t, w, e, ku, sum));
  PetscCall(SlipFaultRestoreWork(fault, &ku));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, STEP_SUMS, MPIU_REAL, MPI_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reset(SlipFaultRunError *est)
{
  PetscFunctionBegin;
  est->known = PETSC_TRUE;
  est->moving = 1;
  est->explicit_steps = 0;
  est->sum = est->late = 0;
  est->timing = (SlipFaultTiming){0};
  PetscCall(PetscArrayzero(est->work, 2));
  PetscCall(PetscArrayzero(est->slip, 2));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSBatheAttemptFn: adds the error of an accepted step. */
static PetscErrorCode EstimateStep(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultRunError *est = &fault->run->error;
  PetscReal sum[STEP_SUMS], scale, decay, moving, mean;
  Vec e;

  PetscFunctionBegin;
  if (!attempt->accepted || est->off || fault->kind.driven) PetscFunctionReturn(PETSC_SUCCESS);
  if (attempt->step == 0) PetscCall(Reset(est));
  if (attempt->method == TSBATHE_METHOD_EXPLICIT) est->explicit_steps++;
  PetscCall(TSBatheGetEstimates(ts, &e, &scale, NULL));
  if (!e) est->known = PETSC_FALSE;
  if (!est->known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StepSums(fault, attempt->time + attempt->dt, w, e, sum));
  PetscCall(SlipFaultTimingStep(fault, ts, attempt, w, e, scale));
  moving = sum[STEP_SLIP] > 0 ? sum[STEP_MOVING] / sum[STEP_SLIP] : 1;
  decay = PetscExpReal(-est->decay * attempt->dt * (est->moving + moving) / 2);
  est->work[0] = est->work[0] * decay + scale * sum[STEP_WORK];
  est->work[1] = est->work[1] * decay + PetscAbsReal(scale * sum[STEP_WORK]);
  if (moving < est->moving) est->late += sum[STEP_SLIP] - est->sum;
  est->sum = sum[STEP_SLIP];
  est->moving = moving;
  mean = sum[STEP_SLIP] / fault->mesh.N;
  if (moving == 0 && mean > 0) { /* all cells rest: changes of P become an error of the slip */
    if (sum[STEP_RESTRAINT] <= 0) est->known = PETSC_FALSE;
    for (PetscInt k = 0; k < 2 && est->known; k++) {
      est->slip[k] += est->work[k] * mean / sum[STEP_RESTRAINT];
      est->work[k] = 0;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the run is one event: sequences of events, and slow slip, have no such error. */
static PetscBool IsOneEvent(SlipFault fault)
{
  return fault->kind.sequence || fault->loads.pressed || fault->friction.law->always_slides ? PETSC_FALSE : PETSC_TRUE;
}

/* Returns whether the estimate was calibrated on such faults, see WhyUnknown(). */
static PetscBool IsCalibrated(SlipFault fault)
{
  return fault->kind.driven || fault->friction.law != SlipFrictionLaws ? PETSC_FALSE : PETSC_TRUE;
}

/* Creates the observer also where nothing is estimated, as checkpoints store that. */
static PetscErrorCode EstimateCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  SlipFaultRunError *est = &fault->run->error;
  PetscBool bathe, none;
  PetscObjectId id;
  const PetscReal *uc;
  PetscReal inertia = 0;

  PetscFunctionBegin;
  (void)wanted;
  *ctx = fault;
  PetscCall(TSBatheIs(ts, &bathe));
  PetscCall(Reset(est));
  est->known = PETSC_FALSE; /* until a step is accepted */
  /* The estimate is for a single event: for sequences only a repetition gives the error. */
  est->recorded = !fault->kind.driven || fault->options.check_error ? PETSC_TRUE : PETSC_FALSE;
  if (est->recorded) est->course.n = 0;
  if (!est->recorded || !bathe) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(fault->critical.uc, &uc));
  for (PetscInt i = 0, c = fault->layout.components; i < c * fault->mesh.n; i++)
    inertia += fault->operators.mass * fault->mesh.weight[i / c] * PetscSqr(uc[i]);
  PetscCall(VecRestoreArrayRead(fault->critical.uc, &uc));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &inertia, 1, MPIU_REAL, MPI_SUM, fault->comm));
  PetscCall(PetscStrcmp(fault->kind.viscosity, "none", &none));
  est->decay = none || inertia <= 0
                 ? 0
                 : 2 * fault->options.value[FAULT_DAMPING_RATIO] * PetscSqrtReal(fault->critical.energy / inertia);
  if (IsOneEvent(fault) && IsCalibrated(fault))
    PetscCall(SlipFaultCalibrationRead(fault->comm, ((PetscObject)fault)->prefix, fault->options.text[FAULT_ESTIMATES],
                                       Measured, &est->calibration));
  if (fault->options.check_error) PetscCall(SlipFaultCheckStart(fault, ts));
  PetscCall(PetscObjectGetId((PetscObject)ts, &id));
  if (est->id != id) PetscCall(TSBatheMonitorSet(ts, EstimateStep, fault, NULL)); /* once for a TS, for all its runs */
  est->id = id;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rounds to two digits, as an estimate has no more. */
static PetscReal TwoDigits(PetscReal x)
{
  const PetscReal unit = x > 0 ? PetscPowReal(10, PetscFloorReal(PetscLog10Real(x)) - 1) : 1;

  return PetscFloorReal(x / unit + (PetscReal)0.5) * unit;
}

/* Returns whether the factors of explicit steps apply to a run. */
static PetscBool MostlyExplicit(const SlipFaultRunError *est, PetscInt steps)
{
  return est->calibration.of_explicit.n && 2 * est->explicit_steps >= steps ? PETSC_TRUE : PETSC_FALSE;
}

/* Gives the reason why the estimate was not calibrated for this run; NULL: it was. */
static PetscErrorCode WhyUnknown(SlipFault fault, TS ts, PetscInt steps, const char **why)
{
  const SlipFaultRunError *est = &fault->run->error;
  TSBatheReactionType reaction;
  TSBatheError estimate;

  PetscFunctionBegin;
  PetscCall(TSBatheGetReactionType(ts, &reaction));
  PetscCall(TSBatheGetError(ts, &estimate));
  *why = NULL;
  if (SlipFaultPressureFollows(fault))
    *why = SLIP_ZONE_UNCALIBRATED;
  else if (fault->loads.pore)
    *why = "not calibrated under a pore pressure";
  else if (SlipLoadsChange(&fault->loads))
    *why = "not calibrated under stresses in time";
  else if (fault->friction.law->always_slides)
    *why = "not calibrated for this friction law";
  else if (fault->kind.sequence)
    *why = "events follow each other";
  else if (fault->kind.driven)
    *why = "not calibrated without inertia";
  else if (!est->known)
    *why = "its steps have no error estimates";
  else if (est->moving > 0)
    *why = "the fault still slides";
  else if (fault->friction.law != SlipFrictionLaws)
    *why = "not calibrated for this friction law";
  else if (SlipFaultOpens(fault) && !MostlyExplicit(est, steps))
    *why = "not calibrated for implicit steps of cells that may open";
  else if (reaction != TSBATHE_REACTION_TRAPEZOIDAL || estimate != TSBATHE_ERROR_EMBEDDED)
    *why = "not calibrated for this integrator";
  else if (steps < est->calibration.least)
    *why = "too few steps";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the estimates before their calibration, relative like the errors that they estimate. */
static void Measures(const SlipFaultRunError *est, PetscReal mean_slip, PetscReal measure[NUM_ESTIMATES])
{
  const SlipFaultCalibration *c = &est->calibration;
  const SlipFaultCourse *course = &est->course;
  const SlipFaultTiming *timing = &est->timing;
  const PetscReal late = est->sum > 0 ? est->late / est->sum : 1;
  const PetscReal shift = PetscMax(PetscAbsReal(timing->shift[0]), c->shift_floor * timing->shift[1]);
  const PetscReal rise = SlipCourseTime(course->n, course->node, 0.9) - SlipCourseTime(course->n, course->node, 0.1);

  measure[ESTIMATE_FINAL] =
    (c->late + late) * PetscMax(PetscAbsReal(est->slip[0]), c->floor * est->slip[1]) / mean_slip;
  measure[ESTIMATE_TIME] = shift / rise;
  measure[ESTIMATE_HISTORY] =
    measure[ESTIMATE_TIME] + c->history_final * measure[ESTIMATE_FINAL] + timing->bend / mean_slip;
}

/* Returns the factor of an estimate. Errors of explicit steps cancel more than those of implicit ones. */
static PetscReal Factor(const SlipFaultRunError *est, SlipFaultEstimate which, PetscInt steps)
{
  const SlipFaultCalibration *c = &est->calibration;
  const SlipFaultFactors *f = MostlyExplicit(est, steps) ? &c->of_explicit : &c->of_all;
  PetscInt i = 0;

  while ((PetscReal)steps > f->row[i].steps) i++;
  return f->row[i].factor[which];
}

/* Finds the row of Estimates that judges a run: its controller's measure, or the history where there is none. */
static PetscErrorCode Judged(TS ts, SlipFaultEstimate *which)
{
  TSAdapt adapt;
  const char *measure;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptRLGetMeasure(adapt, &measure));
  *which = 0;
  for (PetscInt k = 0; k < NUM_ESTIMATES && measure; k++)
    if (!strcmp(measure, Measured[k])) *which = (SlipFaultEstimate)k;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds an attribute WHICH_error_KIND to /result, and for the judging measure a line "KIND WHICH error" with the verdict
   on the wanted accuracy to the summary. */
static PetscErrorCode Report(SlipOutput run, SlipFaultEstimate which, const char kind[], const char participle[],
                             PetscReal error, const char text[])
{
  char name[64], label[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(name, sizeof(name), "%s_error_%s", Estimates[which].name, kind));
  PetscCall(PetscSNPrintf(label, sizeof(label), "%s %s error", participle, Estimates[which].label));
  PetscCall(SlipOutputAddResult(run, name, text ? label : NULL, text, TwoDigits(error)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes "(wanted 0.01: verdict)", and adds an attribute to /result: 1 when the accuracy is satisfied (by the estimate:
   likely), 0 when not, -1 when that is unknown. The text is empty when no accuracy is wanted. */
static PetscErrorCode Verdict(SlipOutput run, const char attribute[], PetscReal wanted, PetscReal met,
                              const char verdict[], char text[], size_t len)
{
  PetscFunctionBegin;
  text[0] = 0;
  if (wanted <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipOutputAddResult(run, attribute, NULL, NULL, met));
  PetscCall(PetscSNPrintf(text, len, "(wanted %g: %s)", (double)wanted, verdict));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports an estimate of the judging measure only, with its verdict. */
static PetscErrorCode ReportVerdict(SlipOutput run, SlipFaultEstimate judged, PetscReal wanted, PetscReal error,
                                    const char met[], const char unsure[])
{
  const PetscBool is = error <= wanted * (1 + PETSC_SMALL) ? PETSC_TRUE : PETSC_FALSE;
  char text[160];

  PetscFunctionBegin;
  PetscCall(Verdict(run, "slip_error_estimate_met", wanted, is ? 1 : -1, is ? met : unsure, text, sizeof(text)));
  PetscCall(Report(run, judged, "estimate", "estimated", error, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the estimates that need no repetition. */
static PetscErrorCode ReportEstimates(SlipFault fault, TS ts, SlipOutput run, PetscReal mean_slip, PetscReal wanted)
{
  const SlipFaultRunError *est = &fault->run->error;
  PetscReal measure[NUM_ESTIMATES], error;
  SlipFaultEstimate judged;
  PetscInt steps;
  const char *why = NULL;
  char advice[64], unsure[96], text[160], name[64];

  PetscFunctionBegin;
  PetscCall(Judged(ts, &judged));
  PetscCall(PetscSNPrintf(advice, sizeof(advice), "-%sfault_check_error measures it", SlipFaultPrefix(fault)));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(WhyUnknown(fault, ts, steps, &why));
  if (why) {
    PetscCall(SlipFaultToleranceError(fault, ts, &error));
    if (error > 0) {
      PetscCall(ReportVerdict(run, judged, fault->steps.accuracy, error,
                              fault->kind.sequence ? "likely met in each event" : "likely met", "perhaps not met"));
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    PetscCall(PetscSNPrintf(text, sizeof(text), "not estimated (%s); %s", why, advice));
    if (wanted > 0) PetscCall(SlipOutputAddResult(run, "slip_error_estimate_met", NULL, NULL, -1));
    PetscCall(Report(run, judged, "estimate", "estimated", NAN, text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscSNPrintf(unsure, sizeof(unsure), "perhaps not met, %s", advice));
  Measures(est, mean_slip, measure);
  PetscCall(SlipOutputAddResult(run, "slip_error_signed", NULL, NULL, est->slip[0] / mean_slip));
  for (PetscInt k = 0; k < NUM_ESTIMATES; k++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "%s_error_measure", Estimates[k].name));
    PetscCall(SlipOutputAddResult(run, name, NULL, NULL, measure[k]));
    error = Factor(est, (SlipFaultEstimate)k, steps) * measure[k];
    if (k == (PetscInt)judged)
      PetscCall(Verdict(run, "slip_error_estimate_met", wanted, error <= wanted ? 1 : -1,
                        error <= wanted ? "likely met" : unsure, text, sizeof(text)));
    PetscCall(Report(run, (SlipFaultEstimate)k, "estimate", "estimated", error, k == (PetscInt)judged ? text : NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the error of explicit steps, which have estimates of each step but none of how these add up: the tolerance
   gives it, for runs like those of its calibration. */
static PetscErrorCode ReportExplicit(SlipFault fault, TS ts, SlipOutput run)
{
  const PetscReal wanted = fault->steps.accuracy;
  SlipFaultEstimate judged;
  PetscReal rtol, error;
  const char *why;
  char text[160];
  TSAdapt adapt;
  PetscBool slips;

  PetscFunctionBegin;
  PetscCall(Judged(ts, &judged));
  if (fault->friction.law->always_slides) judged = ESTIMATE_TIME; /* of events, over the recurrence */
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTLAPUSTA, &slips));
  if (slips)
    PetscCall(PetscSNPrintf(text, sizeof(text),
                            "not estimated (-ts_adapt_type %s bounds slips, no errors); a second run "
                            "with smaller cells tells",
                            TSADAPTLAPUSTA));
  else {
    PetscCall(
      (fault->friction.law->always_slides ? SlipFaultCycleError : SlipFaultExplicitEstimate)(fault, ts, &error, &why));
    if (!why) {
      PetscCall(ReportVerdict(run, judged, wanted, error, "likely met", "perhaps not met"));
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    PetscCall(PetscSNPrintf(text, sizeof(text), "not estimated (%s); a second run with -ts_type %s -ts_rtol %.2g tells",
                            why, ((PetscObject)ts)->type_name, (double)(rtol / 10)));
  }
  PetscCall(Report(run, judged, "estimate", "estimated", NAN, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the errors that a repetition finds. */
static PetscErrorCode ReportCheck(SlipFault fault, TS ts, SlipOutput run, PetscReal wanted)
{
  static const char *const names[SLIP_NUM_ERRORS] = {"final", "history", "shift", "peak", "field"};
  PetscReal all[SLIP_NUM_ERRORS], final, error;
  SlipFaultEstimate judged;
  PetscInt solves;
  char name[64], text[128];

  PetscFunctionBegin;
  PetscCall(Judged(ts, &judged));
  PetscCall(SlipFaultCheckError(fault, ts, run, all, &final, &solves));
  if (PetscIsNanReal(final)) {
    if (wanted > 0) PetscCall(SlipOutputAddResult(run, "slip_error_check_met", NULL, NULL, -1));
    PetscCall(Report(run, judged, "check", "checked", final, "unknown, the repetition was stopped"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipOutputAddResult(run, "slip_error_check_signed", NULL, NULL, final));
  for (PetscInt k = 0; k < SLIP_NUM_ERRORS; k++) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "check_error_%s", names[k]));
    PetscCall(SlipOutputAddResult(run, name, NULL, NULL, all[k]));
  }
  for (PetscInt k = 0; k < NUM_ESTIMATES; k++) {
    error = SlipMeasureOf(SlipMeasureFind(Measured[k]), all);
    if (k == (PetscInt)judged)
      PetscCall(Verdict(run, "slip_error_check_met", wanted, error <= wanted ? 1 : 0,
                        error <= wanted ? "met" : "not met", text, sizeof(text)));
    PetscCall(Report(run, (SlipFaultEstimate)k, "check", "checked", error, k == (PetscInt)judged ? text : NULL));
  }
  PetscCall(SlipOutputAddResult(run, "check_solves", "Bathe solves of check", NULL, solves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Adds the estimates to the summary and to /result, each relative as TSAdaptRLSetMeasure() describes; X is slip, history
  or event_time:
    slip_error_signed    the first variation above, computed minus exact
    X_error_measure      the estimate before its calibration
    X_error_estimate     nine in ten runs stay below it
    X_error_check        of -fault_check_error; slip_error_check_signed, and check_error_* for each SlipErrorKind
    accuracy_requested   of a policy that observes log_accuracy; slip_error_estimate_met and slip_error_check_met
                         judge it by the measure of the run, which has a line in the summary
  The verdict of the estimate is "likely met" or unknown: an error above the wanted accuracy cannot be told from one
  below it (for the final slip, where |signed| was four times the accuracy, 84 % of 141 runs exceeded it, and a run that
  exceeds it by less shows nothing).
*/
static PetscErrorCode EstimateFinish(SlipFault fault, TS ts, SlipOutput run, void *ctx)
{
  SlipFaultObservables obs;
  PetscReal wanted, t, mean_slip;
  PetscBool bathe;
  Vec w;
  TSAdapt adapt;
  SlipPolicy policy;
  PetscInt n = 0;
  const char *const *names = NULL;
  PetscBool sees = PETSC_FALSE;

  PetscFunctionBegin;
  (void)ctx;
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(SlipFaultGetObservables(fault, t, w, NULL, &obs));
  mean_slip = obs.mean_slip;
  if (mean_slip <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  wanted = 0; /* the accuracy of the learned controller; 0 when its policy does not observe it */
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (policy) PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  for (PetscInt i = 0; i < n && !sees; i++) PetscCall(PetscStrcmp(names[i], "log_accuracy", &sees));
  if (sees) PetscCall(TSAdaptRLGetAccuracy(adapt, &wanted));
  if (wanted > 0) PetscCall(SlipOutputAddResult(run, "accuracy_requested", NULL, NULL, wanted));
  PetscCall(TSBatheIs(ts, &bathe));
  if (bathe) PetscCall(ReportEstimates(fault, ts, run, mean_slip, wanted));
  if (!bathe && (IsOneEvent(fault) || fault->friction.law->always_slides)) PetscCall(ReportExplicit(fault, ts, run));
  if (fault->options.check_error) PetscCall(ReportCheck(fault, ts, run, wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Records the start and every accepted step. */
static PetscErrorCode EstimateStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  SlipFaultRunError *est = &fault->run->error;

  PetscFunctionBegin;
  (void)ts;
  (void)ctx;
  if (est->recorded) PetscCall(SlipFaultCourseAdd(fault, est->off ? &est->fine : &est->course, time, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EstimateNext(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  PetscFunctionBegin;
  (void)step;
  PetscCall(EstimateStart(fault, ts, time, w, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads the course, and the estimates of its errors. */
static PetscErrorCode EstimateVisit(SlipFault fault, SlipState s, void *ctx)
{
  SlipFaultRunError *est = &fault->run->error;
  PetscBool has;

  PetscFunctionBegin;
  (void)ctx;
  PetscCall(SlipStateGroup(s, "estimate"));
  PetscCall(SlipStateBool(s, "known", &est->known));
  PetscCall(SlipStateReal(s, "moving", 1, &est->moving));
  PetscCall(SlipStateReal(s, "work", 2, est->work));
  PetscCall(SlipStateReal(s, "slip", 2, est->slip));
  PetscCall(SlipStateReal(s, "slip_so_far", 1, &est->sum));
  PetscCall(SlipStateReal(s, "slip_in_stops", 1, &est->late));
  PetscCall(SlipStateHasValue(s, "explicit_steps", &has)); /* states of SlipStep 0.4 have none */
  if (has) PetscCall(SlipStateInt(s, "explicit_steps", 1, &est->explicit_steps));
  PetscCall(SlipFaultCourseState(fault, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EstimateDestroy(void **ctx)
{
  SlipFaultRunError *est = &((SlipFault)*ctx)->run->error;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&est->start));
  PetscCall(PetscFree(est->course.node));
  PetscCall(PetscFree(est->fine.node));
  est->course = est->fine = (SlipFaultCourse){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultEstimateObserver = {.name = "estimate",
                                                     .create = EstimateCreate,
                                                     .start = EstimateStart,
                                                     .step = EstimateNext,
                                                     .visit = EstimateVisit,
                                                     .finish = EstimateFinish,
                                                     .destroy = EstimateDestroy,
                                                     .repeats = PETSC_TRUE};
