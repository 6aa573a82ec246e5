/* TSADAPTRL without a policy: the default one of its problem. */
#include <slipstep/private/slipadapt.h>

/* -ts_adapt_rl_problem, or what the problem calls itself ("SlipProblemName_C"); "" when neither is there */
static PetscErrorCode ProblemName(TSAdapt adapt, TS ts, const char **name)
{
  PetscErrorCode (*ask)(TS, const char **);

  PetscFunctionBegin;
  *name = ((TSAdapt_RL *)adapt->data)->problem;
  if ((*name)[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectQueryFunction((PetscObject)ts, "SlipProblemName_C", &ask));
  if (ask) PetscCall((*ask)(ts, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A policy that names its problem is for that one, unless -ts_adapt_rl_problem names it too. */
static PetscErrorCode CheckProblem(TSAdapt adapt, TS ts, SlipPolicy policy)
{
  const char *trained, *name, *file;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetAttribute(policy, "problem", &trained));
  PetscCall(ProblemName(adapt, ts, &name));
  if (!trained || !name[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrcmp(trained, name, &same));
  PetscCall(SlipPolicyGetFile(policy, &file));
  PetscCheck(same, PetscObjectComm((PetscObject)adapt), PETSC_ERR_ARG_WRONG,
             "Policy %s was trained for the problem %s, not for %s (-ts_adapt_rl_policy; -ts_adapt_rl_problem %s takes "
             "it nevertheless)",
             file ? file : "(in memory)", trained, name, trained);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSAdaptRLFindPolicy_Private(TSAdapt adapt, TS ts)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;
  const MPI_Comm comm = PetscObjectComm((PetscObject)adapt);
  char file[PETSC_MAX_PATH_LEN];
  const char *name;
  PetscBool found;

  PetscFunctionBegin;
  if (!rl->actor && rl->policy) PetscCall(CheckProblem(adapt, ts, rl->policy));
  if (rl->actor || rl->policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ProblemName(adapt, ts, &name));
  PetscCheck(name[0], comm, PETSC_ERR_ARG_WRONGSTATE,
             "-ts_adapt_type rl has no policy, and this problem has no default one; name a policy with "
             "-ts_adapt_rl_policy <file.h5>, or with -ts_adapt_rl_problem the problem whose default to take");
  PetscCall(SlipPolicyFindDefault(comm, name, file, sizeof(file), &found));
  PetscCheck(
    found, comm, PETSC_ERR_FILE_OPEN,
    "-ts_adapt_type rl has no policy, and the default one of the problem %s, %s, is not there; name a policy with "
    "-ts_adapt_rl_policy <file.h5>, or the folder with the environment variable SLIPSTEP_POLICY_DIR",
    name, file);
  PetscCall(TSAdaptRLSetPolicyFile(adapt, file));
  PetscCall(PetscStrncpy(rl->default_of, name, sizeof(rl->default_of)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A policy that was found, not given, is looked for again: the next problem may be another. */
PetscErrorCode TSAdaptRLForgetDefault_Private(TSAdapt adapt)
{
  TSAdapt_RL *rl = (TSAdapt_RL *)adapt->data;

  PetscFunctionBegin;
  if (rl->default_of[0]) PetscCall(SlipPolicyDestroy(&rl->policy));
  rl->default_of[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
