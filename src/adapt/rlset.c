/* TSADAPTRL: setters of a policy or an actor and of the wanted accuracy, and getters. The setters compare the type of
   the controller and compose no function, because no other type can use what they set. */
#include <slipstep/private/slipadapt.h>

/* Sets the names of the observations, in the order of the policy or the actor. */
static PetscErrorCode TSAdaptRLSetNames(TSAdapt adapt, PetscInt n, const char *const names[])
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  PetscCall(PetscFree2(rl->seen, rl->obs));
  PetscCall(PetscCalloc2(n, &rl->seen, n, &rl->obs));
  rl->n = n;
  rl->needs_error = rl->sees_accuracy = PETSC_FALSE;
  for (PetscInt i = 0; i < n; i++) {
    const SlipObservation *row;
    PetscBool dial, error;

    SlipObservedSet(&rl->seen[i], names[i]);
    row = rl->seen[i].row;
    /* the observation of a problem's own error estimate has such a name */
    PetscCall(PetscStrendswith(names[i], "_error", &error));
    if (row ? row->reads & SLIP_READS_ERROR : error) rl->needs_error = PETSC_TRUE;
    PetscCall(PetscStrcmp(names[i], SLIP_OBSERVES_ACCURACY, &dial));
    if (dial) rl->sees_accuracy = PETSC_TRUE;
  }
  rl->begun = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLSetPolicy - sets the policy that chooses the steps

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
  TSAdapt_RL *rl = NULL;
  PetscInt n;
  const char *const *names;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(policy, SLIP_POLICY_CLASSID, 2);
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  if (!rl) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyReference(policy));
  PetscCall(SlipPolicyDestroy(&rl->policy));
  rl->policy = policy;
  rl->default_of[0] = 0;
  if (rl->actor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  PetscCall(TSAdaptRLSetNames(adapt, n, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSAdaptRLSetPolicyFile - loads the policy that chooses the steps

  Collective

  Input Parameters:
+ adapt - the controller
- file  - HDF5 file, errors as in `SlipPolicyLoad()`

  Level: beginner

.seealso: TSAdaptRLSetPolicy()
@*/
PetscErrorCode TSAdaptRLSetPolicyFile(TSAdapt adapt, const char file[])
{
  const char *unfinished = NULL;
  SlipPolicy policy;
  PetscErrorCode ierr;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(adapt, TSADAPT_CLASSID, 1);
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)adapt), &rank));
  PetscCall(SlipPolicyCreate(PetscObjectComm((PetscObject)adapt), &policy));
  ierr = SlipPolicyLoad(policy, file);
  if (!ierr) ierr = TSAdaptRLSetPolicy(adapt, policy);
  if (!ierr) ierr = SlipPolicyGetAttribute(policy, SLIP_POLICY_UNFINISHED, &unfinished);
  if (!ierr && unfinished && !rank)
    ierr =
      SlipWarning("the training of %s has not ended: its policy is %s, and may not keep the accuracy. Continue with "
                  "train -train_resume, if there is a checkpoint, or end it by train -train_calibrate",
                  file, unfinished);
  PetscCall(SlipPolicyDestroy(&policy));
  PetscCall(ierr);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetPolicy - gets the policy that chooses the steps

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
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  *policy = rl ? rl->policy : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  TSAdaptRLSetActor - sets a function that chooses the steps instead of a policy, for trainers

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

  Errors: PETSC_ERR_ARG_OUTOFRANGE unless 0 <= dt_min < dt_max

.seealso: TSAdaptRLSetPolicy()
@*/
PetscErrorCode TSAdaptRLSetActor(TSAdapt adapt, PetscInt n, const char *const names[], PetscReal dt_min,
                                 PetscReal dt_max, TSAdaptRLActorFn fn, void *ctx)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  if (!rl) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!fn || (dt_min >= 0 && dt_min < dt_max), PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_OUTOFRANGE,
             "Steps of an actor in [%g, %g] s; expected 0 <= dt_min < dt_max", (double)dt_min, (double)dt_max);
  rl->actor = fn;
  rl->actor_ctx = ctx;
  rl->actor_dt[0] = dt_min;
  rl->actor_dt[1] = dt_max;
  if (!fn) n = 0;
  if (!fn && rl->policy) PetscCall(SlipPolicyGetObservations(rl->policy, &n, &names));
  PetscCall(TSAdaptRLSetNames(adapt, n, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLSetAccuracy - sets the wanted accuracy, the relative error that the result of the run may have

  Logically collective; without effect when the type of adapt is not `TSADAPTRL`

  Input Parameters:
+ adapt    - the controller
- accuracy - relative error of the run that `TSAdaptRLSetMeasure()` selects, dimensionless, between
             `TSADAPTRL_ACCURACY_MIN` and `TSADAPTRL_ACCURACY_MAX`

  Options Database Key:
. -ts_adapt_rl_accuracy <0.01> - the same

  Level: beginner

  Errors: PETSC_ERR_ARG_OUTOFRANGE for an accuracy outside of the bounds

  Note:
  A policy that lists the observation log_accuracy depends on the accuracy. Any other one was trained for one compromise
  of accuracy and cost and ignores it, as `TSAdaptView()` prints. An accuracy outside of the policy's training range is
  clipped to that range, with one line of message.

.seealso: TSAdaptRLGetAccuracy(), TSAdaptRLSetMeasure(), TSAdaptRLSetPolicyFile()
@*/
PetscErrorCode TSAdaptRLSetAccuracy(TSAdapt adapt, PetscReal accuracy)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  PetscValidLogicalCollectiveReal(adapt, accuracy, 2);
  PetscCheck(
    accuracy >= TSADAPTRL_ACCURACY_MIN && accuracy <= TSADAPTRL_ACCURACY_MAX, PetscObjectComm((PetscObject)adapt),
    PETSC_ERR_ARG_OUTOFRANGE,
    "-ts_adapt_rl_accuracy is %g; expected a relative error between %g and %g, and in a policy's own range, which "
    "each has within these",
    (double)accuracy, TSADAPTRL_ACCURACY_MIN, TSADAPTRL_ACCURACY_MAX);
  if (!rl) PetscFunctionReturn(PETSC_SUCCESS);
  rl->accuracy = rl->observer.run.accuracy = accuracy;
  rl->accuracy_given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the wanted accuracy if neither `TSAdaptRLSetAccuracy()` nor its option has set it. accuracy: see
   `TSAdaptRLSetAccuracy()`, dimensionless. */
PetscErrorCode TSAdaptRLSetDefaultAccuracy(TSAdapt adapt, PetscReal accuracy)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  if (!rl || rl->accuracy_given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptRLSetAccuracy(adapt, accuracy));
  rl->accuracy_given = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets whether a function, `TSAdaptRLSetActor()`, chooses the steps instead of a policy. has: whether; false when the
   type of adapt is not `TSADAPTRL`. */
PetscErrorCode TSAdaptRLHasActor(TSAdapt adapt, PetscBool *has)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  PetscAssertPointer(has, 2);
  *has = rl && rl->actor ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets whether a policy, an actor, the accuracy, the measure or strictness was set. chosen: whether; false if the type
   of adapt is not `TSADAPTRL`, and for a default policy. A problem whose default is this controller may use another one
   if the user has set none of these. */
PetscErrorCode TSAdaptRLIsChosen(TSAdapt adapt, PetscBool *chosen)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  *chosen = rl && (rl->actor || (rl->policy && !rl->default_of[0]) || rl->accuracy_given || rl->measure || rl->strict)
              ? PETSC_TRUE
              : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetAccuracy - gets the wanted accuracy

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
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  *accuracy = rl ? rl->accuracy : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetCounts - gets the numbers of decisions and of interventions by guard rails

  Not collective

  Input Parameter:
. adapt - the controller

  Output Parameters (each may be `NULL`; 0 when adapt is not `TSADAPTRL`):
+ decisions - steps that the policy chose, over all runs
. outside   - of these, with an observation beyond its training range by more than a tenth of the range's width
. failures  - attempts that did not converge
- halvings  - steps halved after too many failures in a row

  Level: intermediate

.seealso: TSADAPTRL, SlipPolicySetRange()
@*/
PetscErrorCode TSAdaptRLGetCounts(TSAdapt adapt, PetscInt *decisions, PetscInt *outside, PetscInt *failures,
                                  PetscInt *halvings)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  if (decisions) *decisions = rl ? rl->decisions : 0;
  if (outside) *outside = rl ? rl->outside : 0;
  if (failures) *failures = rl ? rl->failures : 0;
  if (halvings) *halvings = rl ? rl->halvings : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLSetStrict - sets whether the policy also controls runs unlike those of its training

  Logically collective; without effect when the type of adapt is not `TSADAPTRL`

  Input Parameters:
+ adapt  - the controller
- strict - `PETSC_TRUE`: never hand a run over to a classical controller

  Options Database Key:
. -ts_adapt_rl_strict - the same

  Level: intermediate

.seealso: TSADAPTRL, TSAdaptRLGetHandover()
@*/
PetscErrorCode TSAdaptRLSetStrict(TSAdapt adapt, PetscBool strict)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  if (rl) rl->strict = strict;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSAdaptRLGetHandover - gets whether a classical controller has replaced the policy, and since when

  Not collective

  Input Parameter:
. adapt - the controller

  Output Parameters (each may be `NULL`):
+ handed - whether the policy was replaced; `PETSC_FALSE` when the type of adapt is not `TSADAPTRL`
- time   - when [s]

  Level: intermediate

.seealso: TSADAPTRL, TSAdaptRLSetStrict(), TSAdaptRLGetFallback()
@*/
PetscErrorCode TSAdaptRLGetHandover(TSAdapt adapt, PetscBool *handed, PetscReal *time)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  if (handed) *handed = rl ? rl->handed : PETSC_FALSE;
  if (time) *time = rl ? rl->handover_time : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets how many accepted steps the policy had chosen when the run was handed over. steps: number of accepted steps of
   the run before that; -1 when it was not handed over or the type of adapt is not `TSADAPTRL`. */
PetscErrorCode TSAdaptRLGetHandoverStep(TSAdapt adapt, PetscInt *steps)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  *steps = rl && rl->handed ? rl->handover_step : -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the type of the classical controller that replaces the policy. type: of `TSAdapt`, and after a colon its filter
   as in `SlipAdaptGetController()`, borrowed; NULL if the run was not handed over or the type of adapt is not
   `TSADAPTRL`. */
PetscErrorCode TSAdaptRLGetFallback(TSAdapt adapt, TSAdaptType *type)
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  *type = rl && rl->handed ? rl->fallback_name : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- without a policy: the default one of its problem ---- */

#define GENERAL "ode" /* for any TS with an error estimate: problems without a policy of their own use it */

/*
  A policy that names its problem is used for that one, unless -ts_adapt_rl_problem names it, too. Without a policy it
  is the default one of -ts_adapt_rl_problem, or of the problem's own name, or else the general one.
*/
PetscErrorCode TSAdaptRLFindPolicy_Private(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const MPI_Comm comm = PetscObjectComm((PetscObject)adapt);
  const SlipProblemOps *problem;
  void *ctx;
  const char *name = rl->problem, *trained, *source;
  char file[PETSC_MAX_PATH_LEN];
  PetscBool found = PETSC_FALSE;

  PetscFunctionBegin;
  if (rl->actor) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (!name[0] && problem && problem->control.name) PetscCall((*problem->control.name)(ts, &name, ctx));
  PetscCall(TSAdaptRLCheckMeasure_Private(adapt, problem, name));
  if (rl->policy) {
    PetscCall(SlipPolicyGetAttribute(rl->policy, "problem", &trained));
    PetscCall(SlipPolicyGetFile(rl->policy, &source));
    PetscCheck(!trained || !name[0] || !strcmp(trained, name) || !strcmp(trained, GENERAL), comm, PETSC_ERR_ARG_WRONG,
               "Policy %s was trained for the problem %s, not for %s (-ts_adapt_rl_policy; -ts_adapt_rl_problem %s "
               "takes it nevertheless)",
               source, trained, name, trained);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (name[0])
    PetscCall(TSAdaptRLFindDefault_Private(comm, name, (rl->measure ? rl->measure : SlipMeasures)->name, file,
                                           sizeof(file), &found));
  if (!found && !rl->problem[0]) {
    char general[PETSC_MAX_PATH_LEN];

    PetscCall(SlipPolicyFindDefault(comm, GENERAL, general, sizeof(general), &found));
    if (found || !name[0]) {
      PetscCall(PetscStrncpy(file, general, sizeof(file)));
      name = GENERAL;
    }
  }
  PetscCheck(
    found, comm, PETSC_ERR_FILE_OPEN,
    "-ts_adapt_type rl has no policy, and the default one of the problem %s, %s, is not there; name a policy with "
    "-ts_adapt_rl_policy <file.h5>, or the folder with the environment variable SLIPSTEP_POLICY_DIR",
    name, file);
  PetscCall(TSAdaptRLSetPolicyFile(adapt, file));
  PetscCall(PetscStrncpy(rl->default_of, name, sizeof(rl->default_of)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
