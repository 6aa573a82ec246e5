/* TSADAPTRL as an object: creation, setters, options, view. */
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipsys.h>

static PetscErrorCode TSAdaptRLSetPolicy_RL(TSAdapt adapt, SlipPolicy policy)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  PetscInt n;
  const char *const *names;

  PetscFunctionBegin;
  PetscCall(SlipPolicyReference(policy));
  PetscCall(SlipPolicyDestroy(&rl->policy));
  rl->policy = policy;
  rl->default_of[0] = 0;
  if (rl->actor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  PetscCall(TSAdaptRLSetNames_Private(adapt, n, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptRLGetPolicy_RL(TSAdapt adapt, SlipPolicy *policy)
{
  PetscFunctionBegin;
  *policy = ((TSAdapt_RL *)adapt->data)->policy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptRLSetActor_RL(TSAdapt adapt, PetscInt n, const char *const names[], PetscReal dt_min,
                                           PetscReal dt_max, TSAdaptRLActorFn fn, void *ctx)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  rl->actor = fn;
  rl->actor_ctx = ctx;
  if (!fn) {
    if (rl->policy) PetscCall(SlipPolicyGetObservations(rl->policy, &n, &names));
    PetscCall(TSAdaptRLSetNames_Private(adapt, rl->policy ? n : 0, names));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(dt_min >= 0 && dt_min < dt_max, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "Steps of an actor in [%g, %g] s; expected 0 <= dt_min < dt_max", (double)dt_min, (double)dt_max);
  rl->actor_dt[0] = dt_min;
  rl->actor_dt[1] = dt_max;
  PetscCall(TSAdaptRLSetNames_Private(adapt, n, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptRLSetAccuracy_RL(TSAdapt adapt, PetscReal accuracy)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  rl->accuracy = rl->observer.accuracy = accuracy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptRLGetAccuracy_RL(TSAdapt adapt, PetscReal *accuracy)
{
  PetscFunctionBegin;
  *accuracy = ((TSAdapt_RL *)adapt->data)->accuracy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLSetPolicy - the policy that chooses the steps

  Logically collective; without effect when the type of adapt is not `TSADAPTRL`

  Input Parameters:
+ adapt  - the controller
- policy - the policy, referenced

  Options Database Key:
. -ts_adapt_rl_policy <file.h5> - load it from a file

  Level: intermediate

.seealso: TSAdaptRLSetPolicyFile(), TSAdaptRLGetPolicy(), SlipPolicyLoad()
@*/
PetscErrorCode TSAdaptRLSetPolicy(TSAdapt adapt, SlipPolicy policy)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscValidHeaderSpecific(policy, SLIP_POLICY_CLASSID, 2);
  PetscTryMethod(adapt, "TSAdaptRLSetPolicy_C", (TSAdapt, SlipPolicy), (adapt, policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSAdaptRLSetPolicyFile - load the policy that chooses the steps

  Collective

  Input Parameters:
+ adapt - the controller
- file  - HDF5 file, errors as in `SlipPolicyLoad()`

  Level: beginner

.seealso: TSAdaptRLSetPolicy()
@*/
PetscErrorCode TSAdaptRLSetPolicyFile(TSAdapt adapt, const char file[])
{
  SlipPolicy policy;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscCall(SlipPolicyCreate(PetscObjectComm((PetscObject)adapt), &policy));
  ierr = SlipPolicyLoad(policy, file);
  if (!ierr) ierr = TSAdaptRLSetPolicy(adapt, policy);
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetPolicy - the policy that chooses the steps

  Not collective

  Input Parameter:
. adapt - the controller

  Output Parameter:
. policy - borrowed; `NULL` when there is none or the controller is not `TSADAPTRL`

  Level: intermediate

.seealso: TSAdaptRLSetPolicy(), SlipPolicyGetHash(), SlipPolicyGetFile()
@*/
PetscErrorCode TSAdaptRLGetPolicy(TSAdapt adapt, SlipPolicy *policy)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  *policy = NULL;
  PetscTryMethod(adapt, "TSAdaptRLGetPolicy_C", (TSAdapt, SlipPolicy *), (adapt, policy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSAdaptRLSetActor - let a function, a trainer's, choose the steps in place of a policy

  Logically collective

  Input Parameters:
+ adapt  - the controller
. n      - number of observations
. names  - their names [n], see `SlipObservationView()`
. dt_min - smallest step the actor may choose [s], for the observation "step"
. dt_max - largest [s]
. fn     - called before the first step and after every attempt, `NULL` goes back to the policy
- ctx    - passed to fn

  Level: advanced

.seealso: TSAdaptRLSetPolicy()
@*/
PetscErrorCode TSAdaptRLSetActor(TSAdapt adapt, PetscInt n, const char *const names[], PetscReal dt_min,
                                 PetscReal dt_max, TSAdaptRLActorFn fn, void *ctx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscTryMethod(adapt, "TSAdaptRLSetActor_C",
                 (TSAdapt, PetscInt, const char *const[], PetscReal, PetscReal, TSAdaptRLActorFn, void *),
                 (adapt, n, names, dt_min, dt_max, fn, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLSetAccuracy - the accuracy dial: the relative error of the run's result that the user wants

  Logically collective; without effect when the type of adapt is not `TSADAPTRL`

  Input Parameters:
+ adapt    - the controller
- accuracy - wanted relative error of the final slip (or of what another problem calls its result), dimensionless,
             between `TSADAPTRL_ACCURACY_MIN` and `TSADAPTRL_ACCURACY_MAX`

  Options Database Key:
. -ts_adapt_rl_accuracy <0.01> - the same

  Level: beginner

  Errors: PETSC_ERR_ARG_OUTOFRANGE for an accuracy outside of the bounds

  Note:
  A policy that lists the observation log_accuracy follows the dial; any other one was trained for one trade of accuracy
  against cost and ignores it, which `TSAdaptView()` says.

.seealso: TSAdaptRLGetAccuracy(), TSAdaptRLSetPolicyFile()
@*/
PetscErrorCode TSAdaptRLSetAccuracy(TSAdapt adapt, PetscReal accuracy)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscValidLogicalCollectiveReal(adapt, accuracy, 2);
  PetscCheck(accuracy >= TSADAPTRL_ACCURACY_MIN && accuracy <= TSADAPTRL_ACCURACY_MAX,
             PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_rl_accuracy is %g; expected a relative error between %g and %g", (double)accuracy,
             TSADAPTRL_ACCURACY_MIN, TSADAPTRL_ACCURACY_MAX);
  PetscTryMethod(adapt, "TSAdaptRLSetAccuracy_C", (TSAdapt, PetscReal), (adapt, accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetAccuracy - the accuracy dial

  Not collective

  Input Parameter:
. adapt - the controller

  Output Parameter:
. accuracy - wanted relative error of the run's result, dimensionless; 0 when the type of adapt is not `TSADAPTRL`

  Level: intermediate

.seealso: TSAdaptRLSetAccuracy()
@*/
PetscErrorCode TSAdaptRLGetAccuracy(TSAdapt adapt, PetscReal *accuracy)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  *accuracy = 0;
  PetscTryMethod(adapt, "TSAdaptRLGetAccuracy_C", (TSAdapt, PetscReal *), (adapt, accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptSetFromOptions_RL(TSAdapt adapt, SlipOptionItems PetscOptionsObject)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscReal accuracy = rl->accuracy;
  PetscBool set, dial;

  PetscFunctionBegin;
  PetscOptionsHeadBegin(PetscOptionsObject, "Learned step-size controller options");
  PetscCall(PetscOptionsString("-ts_adapt_rl_policy", "HDF5 file with the policy (default: the one of the problem)",
                               "TSAdaptRLSetPolicyFile", file, file, sizeof(file), &set));
  PetscCall(PetscOptionsString(
    "-ts_adapt_rl_problem",
    "Problem whose default policy to take when none is named, or for which the named one was trained (fault, ...; "
    "default: its own)",
    "SlipPolicyFindDefault", rl->problem, rl->problem, sizeof(rl->problem), NULL));
  PetscCall(PetscOptionsInt("-ts_adapt_rl_max_failures",
                            "Failed attempts in a row before steps are halved until one converges, >= 1", "",
                            rl->max_failures, &rl->max_failures, NULL));
  PetscCall(PetscOptionsReal("-ts_adapt_rl_error_ceiling",
                             "Larger error estimates reject and shrink the step; 0: every converged step is accepted",
                             "", rl->error_ceiling, &rl->error_ceiling, NULL));
  PetscCall(
    PetscOptionsReal("-ts_adapt_rl_accuracy",
                     "Wanted relative error of the run's final slip, 1e-4 to 1e-1, for policies that observe it",
                     "TSAdaptRLSetAccuracy", accuracy, &accuracy, &dial));
  PetscOptionsHeadEnd();
  if (dial) PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
  PetscCheck(rl->max_failures >= 1, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_rl_max_failures is %" PetscInt_FMT "; expected at least 1", rl->max_failures);
  PetscCheck(rl->error_ceiling >= 0, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_adapt_rl_error_ceiling is %g; expected a positive number, or 0 for none", (double)rl->error_ceiling);
  PetscCheck(!set || file[0], PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_WRONG,
             "-ts_adapt_rl_policy has no value, expected the name of a file");
  PetscCall(SlipErrorSource("-ts_adapt_rl_policy"));
  if (set) PetscCall(TSAdaptRLSetPolicyFile(adapt, file));
  PetscCall(SlipErrorSource(NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptView_RL(TSAdapt adapt, PetscViewer viewer)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPushTab(viewer));
  if (rl->actor) PetscCall(PetscViewerASCIIPrintf(viewer, "steps are chosen by an actor\n"));
  if (rl->policy) PetscCall(SlipPolicyView(rl->policy, viewer));
  if (rl->default_of[0])
    PetscCall(PetscViewerASCIIPrintf(viewer, "it is the default policy of the problem %s\n", rl->default_of));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "accuracy dial %g%s\n", (double)rl->accuracy,
    rl->sees_accuracy || !rl->n ? "" : " (ignored: the policy does not observe " SLIP_OBSERVES_ACCURACY ")"));
  PetscCall(PetscViewerASCIIPrintf(viewer, "guard rails: steps are halved after %" PetscInt_FMT " failures in a row",
                                   rl->max_failures));
  PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_FALSE));
  if (rl->error_ceiling > 0)
    PetscCall(PetscViewerASCIIPrintf(viewer, "; error ceiling %g\n", (double)rl->error_ceiling));
  else
    PetscCall(PetscViewerASCIIPrintf(viewer, "; no error ceiling\n"));
  PetscCall(PetscViewerASCIIUseTabs(viewer, PETSC_TRUE));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "decisions %" PetscInt_FMT ", outside the training range %" PetscInt_FMT
                                   ", failed attempts %" PetscInt_FMT ", halved steps %" PetscInt_FMT
                                   ", rejected by the ceiling %" PetscInt_FMT "\n",
                                   rl->decisions, rl->outside, rl->failures, rl->halvings, rl->ceilings));
  PetscCall(PetscViewerASCIIPopTab(viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSAdaptReset_RL(TSAdapt adapt)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(SlipObserverReset(&rl->observer));
  PetscCall(TSAdaptRLForgetDefault_Private(adapt));
  rl->begun = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What TSBATHE and the setters find by name; destroying takes it off again. */
static PetscErrorCode Compose(TSAdapt adapt, PetscBool on)
{
  const struct {
    const char *name;
    void (*fn)(void);
  } methods[] = {
    {"TSAdaptRLSetPolicy_C", (void (*)(void))TSAdaptRLSetPolicy_RL},
    {"TSAdaptRLGetPolicy_C", (void (*)(void))TSAdaptRLGetPolicy_RL},
    {"TSAdaptRLSetAccuracy_C", (void (*)(void))TSAdaptRLSetAccuracy_RL},
    {"TSAdaptRLGetAccuracy_C", (void (*)(void))TSAdaptRLGetAccuracy_RL},
    {"TSAdaptRLSetActor_C", (void (*)(void))TSAdaptRLSetActor_RL},
    {"TSAdaptChooseFirst_C", (void (*)(void))TSAdaptChooseFirst_RL},
    {"TSAdaptChooseAfterFailure_C", (void (*)(void))TSAdaptChooseAfterFailure_RL},
    {"TSAdaptNeedsError_C", (void (*)(void))TSAdaptNeedsError_RL},
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
  PetscCall(Compose(adapt, PETSC_FALSE));
  PetscCall(SlipPolicyDestroy(&rl->policy));
  PetscCall(PetscFree2(rl->seen, rl->obs));
  PetscCall(PetscFree(adapt->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSADAPTRL - step sizes from a learned policy

  The policy maps an observation of the last attempt to the next step, and every converged step is accepted. It never
  needs what its file does not list: without accuracy or log_error the TS is told to skip its error estimate.

  Guard rails: after max_failures failed attempts in a row the step is halved until one converges, because a policy may
  answer the same observation with the same failing step forever; with an error ceiling a step with a larger estimate is
  repeated with the heuristic's h (E/ceiling)^(-q), limited to [0.1, 0.9] h; observations outside the training range are
  counted and reported once.

  With a TS other than bathe, failed solves stay PETSc's business (-ts_adapt_scale_solve_failed), the residual counts as
  0, the first step is the TS's own, and the start that energy, velocity and state_k refer to is the first state seen.

  Options Database Keys:
+ -ts_adapt_rl_policy <file.h5>      - the policy; without it, TSAdaptRLSetPolicy() or an actor, the problem's default
. -ts_adapt_rl_problem <name>        - the problem whose default policy that is, see SlipPolicyFindDefault()
. -ts_adapt_rl_accuracy <1e-2>       - wanted relative error of the final slip, for policies that observe log_accuracy
. -ts_adapt_rl_max_failures <3>      - failed attempts in a row before steps are halved
- -ts_adapt_rl_error_ceiling <0>     - largest accepted error estimate, 0 for none

  Level: beginner

.seealso: SlipPolicy, TSAdaptRLSetPolicy(), TSAdaptRLSetActor(), TSADAPTHEURISTIC
M*/
PetscErrorCode TSAdaptCreate_RL(TSAdapt adapt)
{
  TSAdapt_RL *rl;

  PetscFunctionBegin;
  PetscCall(PetscNew(&rl));
  rl->max_failures = 3;
  rl->accuracy = TSADAPTRL_ACCURACY_DEFAULT;
  adapt->data = rl;
  adapt->ops->choose = TSAdaptChoose_RL;
  adapt->ops->setfromoptions = TSAdaptSetFromOptions_RL;
  adapt->ops->view = TSAdaptView_RL;
  adapt->ops->reset = TSAdaptReset_RL;
  adapt->ops->destroy = TSAdaptDestroy_RL;
  PetscCall(Compose(adapt, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
