/* The end of an output file: /run and /result. */
#include <slipstep/private/slipoutput.h>
#include <slipcompat.h>
#include <slipadapt.h>
#include <slipsys.h>

/* In /result what the guard rails of a policy did, in the summary what should worry. */
PetscErrorCode SlipOutputAddGuards(SlipOutput out)
{
  PetscInt decisions, outside, halvings;
  PetscBool learned;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (!learned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptRLGetCounts(adapt, &decisions, &outside, NULL, &halvings));
  PetscCall(SlipOutputAddResult(out, "policy_decisions", NULL, NULL, decisions));
  PetscCall(
    SlipOutputAddResult(out, "policy_outside_range", outside ? "beyond training range" : NULL, "decisions", outside));
  PetscCall(SlipOutputAddResult(out, "policy_halvings", halvings ? "halved after failures" : NULL, "steps", halvings));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Which policy chose the steps, when one did. */
static PetscErrorCode SlipOutputWritePolicy(SlipH5 *h, TSAdapt adapt)
{
  PetscBool learned;
  SlipPolicy policy = NULL;
  const char *file = NULL, *hash = NULL;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (learned) PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (!policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(policy, &file));
  PetscCall(SlipPolicyGetHash(policy, &hash));
  PetscCall(SlipH5WriteAttrString(h, "/run", "policy", file ? file : ""));
  PetscCall(SlipH5WriteAttrString(h, "/run", "policy_hash", hash ? hash : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipOutputWriteRun(SlipOutput out, const SlipOutputTotals *t)
{
  SlipH5 *h = &out->file;
  char *options, version[256];
  PetscMPIInt size;
  TSAdapt adapt;
  TSType type;
  TSAdaptType adapt_type;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(out->comm, &size));
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(SlipH5WriteAttrString(h, "/run", "options", options));
  PetscCall(PetscFree(options));
  PetscCall(PetscGetVersion(version, sizeof(version)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "petsc_version", version));
  PetscCall(SlipH5WriteAttrString(h, "/run", "slipstep_version", SLIPSTEP_VERSION));
  PetscCall(SlipH5WriteAttrInt(h, "/run", "ranks", size));
  PetscCall(TSGetType(out->ts, &type));
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(TSAdaptGetType(adapt, &adapt_type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_type", type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_adapt_type", adapt_type ? adapt_type : ""));
  PetscCall(SlipOutputWritePolicy(h, adapt));
  for (PetscInt i = 0; i < out->nrun; i++)
    PetscCall(SlipH5WriteAttrReal(h, "/run", out->run[i].name, out->run[i].value));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "wall_time", t->wall_setup + t->wall_solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipOutputWriteResult(SlipOutput out, const SlipOutputTotals *t)
{
  SlipH5 *h = &out->file;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < out->nresults; i++)
    PetscCall(SlipH5WriteAttrReal(h, "/result", out->result[i].name, out->result[i].value));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "accepted", t->accepted));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "rejected", t->rejected));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "solves", t->solves));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "newton_iterations", t->newton));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "linear_iterations", t->linear));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_setup", t->wall_setup));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_solve", t->wall_solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is left to write, then the file's final name. */
PetscErrorCode SlipOutputFinishFile(SlipOutput out, const SlipOutputTotals *totals)
{
  PetscFunctionBegin;
  PetscCall(SlipOutputWriteRun(out, totals));
  PetscCall(SlipOutputWriteResult(out, totals));
  PetscCall(SlipH5Close(&out->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}
