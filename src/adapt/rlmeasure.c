/* TSADAPTRL: the error that its accuracy bounds, the default policy for it, and accuracies outside the training
   range */
#include <slipstep/private/slipadapt.h>

#define MEASURE_OF_OLD "final_slip" /* for policies without the attribute */
#define DIAL_MARGIN 0.1             /* fraction of the range's width by which observations may exceed it */

/*@C
  TSAdaptRLSetMeasure - sets which error of the run the wanted accuracy bounds

  Logically collective; without effect when the type of adapt is not `TSADAPTRL`

  Input Parameters:
+ adapt   - the controller
- measure - "history": the largest of all relative errors (final mean slip; mean slip at any time, over the final one;
            time of half the slip, over the time from 10 to 90 % of it; a fifth of that of the peak mean slip rate; RMS
            of the final slip field), "final_slip": only the final mean slip, or "event_time": the time of half the slip

  Options Database Key:
. -ts_adapt_rl_measure <history,final_slip,event_time> - the same

  Level: beginner

  Notes:
  The measure selects the default policy: PROBLEM.h5 is for history, PROBLEM_MEASURE.h5 for another one if that file
  exists. A policy bounds the measure that it was trained for, its attribute measure (final_slip if it has none), which
  is the measure of the run without this call or the option. `TSSolve()` raises an error if the measure differs from
  that of a policy that was named, except that a policy for history bounds event_time, too.

  Problems with only one error of their own, such as `SlipSmall`, accept only history, which then means that error.

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for another name

.seealso: TSAdaptRLGetMeasure(), TSAdaptRLSetAccuracy(), SlipPolicyFindDefault()
@*/
PetscErrorCode TSAdaptRLSetMeasure(TSAdapt adapt, const char measure[])
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  PetscAssertPointer(measure, 2);
  if (!SlipMeasureFind(measure)) {
    char names[128] = ""; /* "a, b or c" */

    for (const SlipMeasure *row = SlipMeasures; row->name; row++) {
      PetscCall(PetscStrlcat(names, row == SlipMeasures ? "" : row[1].name ? ", " : " or ", sizeof(names)));
      PetscCall(PetscStrlcat(names, row->name, sizeof(names)));
    }
    SETERRQ(PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_UNKNOWN_TYPE,
            "-ts_adapt_rl_measure is \"%s\", expected %s", measure, names);
  }
  if (!rl || rl->measure == SlipMeasureFind(measure)) PetscFunctionReturn(PETSC_SUCCESS);
  rl->measure = SlipMeasureFind(measure);
  /* A default policy is looked up again. */
  if (rl->default_of[0]) PetscCall(SlipPolicyDestroy(&rl->policy));
  rl->default_of[0] = 0;
  rl->begun = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the measure that a policy was trained for */
static PetscErrorCode MeasureOf(SlipPolicy policy, const char **measure)
{
  PetscFunctionBegin;
  PetscCall(SlipPolicyGetAttribute(policy, SLIP_POLICY_MEASURE, measure));
  if (!*measure) *measure = MEASURE_OF_OLD;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets which error of the run the wanted accuracy bounds. measure: its name: as set, or that of the policy, or
   "history" while there is none; NULL if the type of adapt is not `TSADAPTRL`. */
PetscErrorCode TSAdaptRLGetMeasure(TSAdapt adapt, const char *measure[])
{
  TSAdapt_RL *rl = NULL;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLContext_Private(adapt, &rl));
  PetscAssertPointer(measure, 2);
  *measure = rl ? SlipMeasures[0].name : NULL;
  if (rl && rl->measure)
    *measure = rl->measure->name;
  else if (rl && rl->policy)
    PetscCall(MeasureOf(rl->policy, measure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the default policy of PROBLEM for a measure: PROBLEM_MEASURE.h5 takes precedence over PROBLEM.h5. */
PetscErrorCode TSAdaptRLFindDefault_Private(MPI_Comm comm, const char problem[], const char measure[], char file[],
                                            size_t len, PetscBool *found)
{
  char name[128];

  PetscFunctionBegin;
  *found = PETSC_FALSE;
  if (strcmp(measure, SlipMeasures[0].name)) {
    PetscCall(PetscSNPrintf(name, sizeof(name), "%s_%s", problem, measure));
    PetscCall(SlipPolicyFindDefault(comm, name, file, len, found));
  }
  if (!*found) PetscCall(SlipPolicyFindDefault(comm, problem, file, len, found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the problem, and a policy that was named, support the measure that was set. */
PetscErrorCode TSAdaptRLCheckMeasure_Private(TSAdapt adapt, const SlipProblemOps *problem, const char name[])
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  const MPI_Comm comm = PetscObjectComm((PetscObject)adapt);
  const PetscBool measures = problem ? problem->control.measures : PETSC_FALSE;
  const char *trained, *source;

  PetscFunctionBegin;
  if (!rl->measure) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(measures || rl->measure == SlipMeasures, comm, PETSC_ERR_SUP,
             "-ts_adapt_rl_measure %s: the problem%s%s has only one measure of error; leave the option out",
             rl->measure->name, name[0] ? " " : "", name);
  if (!measures || !rl->policy || rl->default_of[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeasureOf(rl->policy, &trained));
  if (!strcmp(trained, rl->measure->name)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(rl->policy, &source));
  /* the error of the time is one of those of history */
  PetscCheck(!strcmp(trained, SlipMeasures[0].name) && !strcmp(rl->measure->name, "event_time"), comm,
             PETSC_ERR_ARG_WRONG,
             "Policy %s was trained for the measure %s, not for -ts_adapt_rl_measure %s: leave one of the two out",
             source, trained, rl->measure->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the range of accuracies that a policy was trained for; PETSC_FALSE: any, or it does not observe them */
static PetscErrorCode Trained(SlipPolicy policy, PetscReal dial[2], PetscBool *known)
{
  const PetscReal *min, *max;
  const char *const *names;
  PetscInt n;

  PetscFunctionBegin;
  *known = PETSC_FALSE;
  PetscCall(SlipPolicyGetRange(policy, &min, &max));
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  for (PetscInt i = 0; i < n && min; i++)
    if (!strcmp(names[i], SLIP_OBSERVES_ACCURACY)) {
      dial[0] = PetscPowReal(10, min[i]);
      dial[1] = PetscPowReal(10, max[i]);
      *known = PETSC_TRUE;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Suggests a measure whose default policy covers an accuracy that this one does not; empty: there is none */
static PetscErrorCode Alternative(TSAdapt adapt, PetscReal used, char text[], size_t len)
{
  const TSAdapt_RL *rl = (const TSAdapt_RL *)adapt->data;
  const MPI_Comm comm = PetscObjectComm((PetscObject)adapt);
  char file[PETSC_MAX_PATH_LEN];
  const char *measure;
  PetscReal dial[2];
  PetscBool found, known = PETSC_FALSE;
  SlipPolicy other;

  PetscFunctionBegin;
  text[0] = 0;
  PetscCall(TSAdaptRLGetMeasure(adapt, &measure));
  if (!rl->default_of[0] || !strcmp(measure, "final_slip") || used < rl->accuracy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptRLFindDefault_Private(comm, rl->default_of, "final_slip", file, sizeof(file), &found));
  if (!found) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyCreate(comm, &other));
  PetscCall(SlipPolicyLoad(other, file));
  PetscCall(MeasureOf(other, &measure));
  if (!strcmp(measure, "final_slip")) PetscCall(Trained(other, dial, &known));
  PetscCall(SlipPolicyDestroy(&other));
  if (known && dial[0] < used)
    PetscCall(PetscSNPrintf(text, len, "; -ts_adapt_rl_measure final_slip goes down to %.3g", (double)dial[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At the start of a run: clips the accuracy that the policy observes to its training range, because outside of it the
   run would be handed over after three decisions. This does not apply to an actor. */
PetscErrorCode TSAdaptRLClipDial_Private(TSAdapt adapt, PetscReal *used)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  PetscReal dial[2], margin;
  PetscBool known = PETSC_FALSE;
  const char *source;
  char other[128];

  PetscFunctionBegin;
  *used = rl->accuracy;
  if (!rl->actor && rl->policy) PetscCall(Trained(rl->policy, dial, &known));
  if (!known) PetscFunctionReturn(PETSC_SUCCESS);
  margin = PetscPowReal(dial[1] / dial[0], (PetscReal)DIAL_MARGIN);
  if (*used >= dial[0] / margin && *used <= dial[1] * margin) PetscFunctionReturn(PETSC_SUCCESS);
  *used = PetscClipInterval(*used, dial[0], dial[1]);
  if (rl->told_dial == rl->accuracy) PetscFunctionReturn(PETSC_SUCCESS);
  rl->told_dial = rl->accuracy;
  PetscCall(SlipPolicyGetFile(rl->policy, &source));
  PetscCall(Alternative(adapt, *used, other, sizeof(other)));
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)adapt),
                        "-ts_adapt_rl_accuracy %g: the run uses %.3g, as policy %s was trained for %.3g to %.3g%s\n",
                        (double)rl->accuracy, (double)*used, source, (double)dial[0], (double)dial[1], other));
  PetscFunctionReturn(PETSC_SUCCESS);
}
