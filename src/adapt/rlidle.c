/* TSADAPTRL: warnings, at the start of a run, of options that were given and have no effect on it */
#include <slipstep/private/slipadapt.h>
#include <slipstep/rooms/slipsys.h>

static PetscErrorCode Given(TS ts, const char option[], PetscBool *given)
{
  return PetscOptionsHasName(((PetscObject)ts)->options, ((PetscObject)ts)->prefix, option, given);
}

/* True if the policy's file has a number that depends on the wanted accuracy */
static PetscErrorCode FollowsDial(const TSAdapt_RL *rl, PetscBool *follows)
{
  PetscReal number;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetNumber(rl->policy, SLIP_POLICY_RTOL_POWER, &number, follows));
  if (!*follows) PetscCall(SlipPolicyGetNumber(rl->policy, SLIP_POLICY_FIRST_STEP_POWER, &number, follows));
  if (rl->sees_accuracy) *follows = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True if a step depends on the tolerances: their error, not that of slip itself, is observed, or a ceiling limits
   it */
static PetscErrorCode FollowsTolerance(const TSAdapt_RL *rl, PetscBool *follows)
{
  const char *const *names;
  PetscInt n, component;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetObservations(rl->policy, &n, &names));
  *follows = rl->ceiling > 0 ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < n && !*follows; i++) {
    const PetscInt row = SlipObservationFind(names[i], &component);

    if (row >= 0 && (SlipObservations[row].reads & (SLIP_READS_ERROR | SLIP_READS_ESTIMATES)) == SLIP_READS_ERROR)
      *follows = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of options of other types than the one that would take over */
static PetscErrorCode WarnOfFallbacks(TSAdapt_RL *rl, TS ts)
{
  static const struct {
    const char *type, *option;
  } row[] = {{TSADAPTHEURISTIC, "-ts_adapt_heuristic_growth"},
             {TSADAPTHEURISTIC, "-ts_adapt_heuristic_failure_factor"},
             {TSADAPTPI, "-ts_adapt_pi_filter"},
             {TSADAPTPI, "-ts_adapt_pi_g1"},
             {TSADAPTPI, "-ts_adapt_pi_g2"},
             {TSADAPTPI, "-ts_adapt_pi_kappa"},
             {TSADAPTPI, "-ts_adapt_pi_ratio_min"},
             {TSADAPTPI, "-ts_adapt_pi_ratio_max"},
             {TSADAPTPI, "-ts_adapt_pi_failure_factor"},
             {TSADAPTDSP, "-ts_adapt_dsp_filter"},
             {TSADAPTDSP, "-ts_adapt_dsp_pid"},
             {NULL, "-ts_adapt_clip"}, /* options of each type: a policy computes its own ratio of steps */
             {NULL, "-ts_adapt_safety"},
             {NULL, "-ts_adapt_reject_safety"}};
  const char *fallback = TSAdaptRLFallbackType_Private(rl), *prefix = ((PetscObject)ts)->prefix;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++) {
    const char *type = row[i].type ? row[i].type : fallback;
    const size_t len = strcspn(type, ":");
    const PetscBool same =
      !strncmp(fallback, type, len) && (!fallback[len] || fallback[len] == ':') ? PETSC_TRUE : PETSC_FALSE;
    PetscBool given;

    PetscCall(Given(ts, row[i].option, &given));
    if (!given || (same && rl->handed)) continue;
    if (same)
      PetscCall(SlipWarning("-%s%s has no effect unless -ts_adapt_type rl hands the run over to %s",
                            prefix ? prefix : "", row[i].option + 1, type));
    else
      PetscCall(SlipWarning("-%s%s has no effect: the controller is rl%s%s, give -ts_adapt_type %s",
                            prefix ? prefix : "", row[i].option + 1,
                            rl->handed ? ", which has handed the run over to " : "", rl->handed ? fallback : "", type));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0 prints the warnings, once */
PetscErrorCode TSAdaptRLWarnOfIdle_Private(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const char *prefix = ((PetscObject)ts)->prefix ? ((PetscObject)ts)->prefix : "", *source;
  PetscBool dial, first, rtol, follows, bathe;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)adapt), &rank));
  if (rl->told_idle || rl->actor || !rl->from_options || rank) PetscFunctionReturn(PETSC_SUCCESS);
  rl->told_idle = PETSC_TRUE;
  PetscCall(WarnOfFallbacks(rl, ts));
  if (rl->handed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(rl->policy, &source));
  PetscCall(FollowsDial(rl, &follows));
  PetscCall(Given(ts, "-ts_adapt_rl_accuracy", &dial));
  if (dial && !follows)
    PetscCall(SlipWarning(
      "-%sts_adapt_rl_accuracy %g has no effect: the policy %s does not observe " SLIP_OBSERVES_ACCURACY "%s", prefix,
      (double)rl->accuracy, source,
      rl->relative ? ". Its steps follow -ts_rtol and -ts_atol" : ", it was trained for one accuracy"));
  if (rl->relative) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheIs(ts, &bathe)); /* other types do not call for a first step */
  PetscCall(Given(ts, "-" SLIP_TS_DT, &first));
  if (first && bathe)
    PetscCall(
      SlipWarning("-%s" SLIP_TS_DT " has no effect: the policy %s chooses the first step as well", prefix, source));
  PetscCall(Given(ts, "-ts_rtol", &rtol));
  PetscCall(FollowsTolerance(rl, &follows));
  if (rtol && !follows)
    PetscCall(
      SlipWarning("-%sts_rtol has no effect unless -ts_adapt_type rl hands the run over: the policy %s does not look "
                  "at the error of a step",
                  prefix, source));
  PetscFunctionReturn(PETSC_SUCCESS);
}
