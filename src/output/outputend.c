/* The end of an output file: /run and /result. */
#include <slipstep/private/slipoutput.h>
#include <slipcompat.h>
#include <slipadapt.h>
#include <slipsys.h>

PetscErrorCode SlipOutputFinishFile(SlipOutput out, const SlipOutputTotals *t)
{
  SlipH5 *h = &out->file;
  char *options, version[256];
  const char *file = NULL, *hash = NULL;
  SlipPolicy policy = NULL;
  PetscBool learned;
  PetscMPIInt size;
  TSAdapt adapt;
  TSType type;
  TSAdaptType adapt_type;

  PetscFunctionBegin;
  /* /run */
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

  /* which policy chose the steps, when one did */
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (learned) PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (policy) {
    PetscCall(SlipPolicyGetFile(policy, &file));
    PetscCall(SlipPolicyGetHash(policy, &hash));
    PetscCall(SlipH5WriteAttrString(h, "/run", "policy", file ? file : ""));
    PetscCall(SlipH5WriteAttrString(h, "/run", "policy_hash", hash ? hash : ""));
  }
  for (PetscInt i = 0; i < out->nrun; i++)
    PetscCall(SlipH5WriteAttrReal(h, "/run", out->run[i].name, out->run[i].value));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "wall_time", t->wall_setup + t->wall_solve));

  /* /result */
  for (PetscInt i = 0; i < out->nresults; i++)
    if (!PetscIsNanReal(out->result[i].value))
      PetscCall(SlipH5WriteAttrReal(h, "/result", out->result[i].name, out->result[i].value));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "accepted", t->accepted));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "rejected", t->rejected));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "solves", t->solves));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "newton_iterations", t->newton));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "linear_iterations", t->linear));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_setup", t->wall_setup));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_solve", t->wall_solve));
  PetscCall(SlipH5Close(&out->file)); /* the file takes its final name */
  PetscFunctionReturn(PETSC_SUCCESS);
}
