/* Writes the groups /run and /result of an output file, on rank 0 only. */
#include <slipstep/private/sliprunoutput.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipadapt.h>
#include <slipstep/rooms/slipsys.h>
#include <petsctime.h>

/* Writes which policy chooses the steps, if one does. A default policy is loaded only in the first step. */
PetscErrorCode SlipOutputPolicy(SlipOutput out)
{
  SlipH5 *h = &out->file;
  const char *file = NULL, *hash = NULL;
  SlipPolicy policy = NULL;
  TSAdapt adapt;
  PetscBool learned;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  if (learned) PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (!policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipPolicyGetFile(policy, &file));
  PetscCall(SlipPolicyGetHash(policy, &hash));
  PetscCall(SlipH5WriteAttrString(h, "/run", "policy", file ? file : ""));
  PetscCall(SlipH5WriteAttrString(h, "/run", "policy_hash", hash ? hash : ""));
  out->policy_known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipOutputRunNumbers(SlipOutput out)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < out->nrun; i++)
    PetscCall(SlipH5WriteAttrReal(&out->file, "/run", out->run[i].name, out->run[i].value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SLIP_OUTPUT_WARNINGS 8192 /* bytes; a longer text is cut */

/* Writes the warnings so far, a line each: those of the set-up at the start, and later ones at the end. */
static PetscErrorCode SlipOutputWarnings(SlipOutput out)
{
  char *text, *old = NULL, before[SLIP_OUTPUT_WARNINGS] = "", all[SLIP_OUTPUT_WARNINGS];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipWarningsTake(&text));
  PetscCall(SlipH5HasAttribute(&out->file, "/run", "warnings", &has));
  if (has) PetscCall(SlipH5ReadAttrString(&out->file, "/run", "warnings", before, sizeof(before)));
  PetscCall(PetscStrstr(before, text, &old)); /* a run that continues repeats its warnings */
  PetscCall(PetscSNPrintf(all, sizeof(all), "%s%s", before, old ? "" : text));
  PetscCall(PetscFree(text));
  PetscCall(SlipH5WriteAttrString(&out->file, "/run", "warnings", all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes what is available at the start. A run that continues takes its counts so far from the file. */
PetscErrorCode SlipOutputRun(SlipOutput out)
{
  SlipH5 *h = &out->file;
  char *options, version[256], host[256], date[64];
  PetscMPIInt size;
  PetscInt restarts = 0;
  TSAdapt adapt;
  TSType type;
  TSAdaptType adapt_type;

  PetscFunctionBegin;
  if (out->resumed) {
    PetscBool ended;

    PetscCall(SlipH5ReadAttrInt(h, "/run", "restarts", &restarts));
    restarts++;
    PetscCall(SlipH5ReadAttrReal(h, "/run", "wall_time", &out->wall));
    PetscCall(SlipH5HasAttribute(h, "/result", "wall_time_solve", &ended));
    if (ended) {
      PetscCall(SlipH5ReadAttrReal(h, "/result", "wall_time_setup", &out->setup_before));
      PetscCall(SlipH5ReadAttrReal(h, "/result", "wall_time_solve", &out->solve_before));
    } else
      out->solve_before = out->wall;
    PetscCall(SlipH5RemoveGroup(h, "/result"));
  }
  PetscCall(SlipH5Group(h, "/run", PETSC_TRUE));
  PetscCall(SlipH5Group(h, "/result", PETSC_TRUE));
  PetscCallMPI(MPI_Comm_size(out->comm, &size));
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(SlipH5WriteAttrString(h, "/run", "options", options));
  PetscCall(PetscFree(options));
  PetscCall(PetscGetVersion(version, sizeof(version)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "petsc_version", version));
  PetscCall(SlipH5WriteAttrString(h, "/run", "slipstep_version", SLIPSTEP_VERSION));
  PetscCall(SlipH5WriteAttrInt(h, "/run", "ranks", size));
  PetscCall(PetscGetHostName(host, sizeof(host)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "host", host));
  PetscCall(PetscGetDate(date, sizeof(date)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "date", date));
  PetscCall(SlipOutputWarnings(out));
  PetscCall(SlipH5WriteAttrInt(h, "/run", "restarts", restarts));
  PetscCall(TSGetType(out->ts, &type));
  PetscCall(TSGetAdapt(out->ts, &adapt));
  PetscCall(TSAdaptGetType(adapt, &adapt_type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_type", type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_adapt_type", adapt_type ? adapt_type : ""));
  PetscCall(SlipOutputPolicy(out));
  PetscCall(SlipOutputRunNumbers(out));
  PetscCall(SlipOutputWall(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the wall time since the output was created, with that of earlier runs. A run's end has a better number. */
PetscErrorCode SlipOutputWall(SlipOutput out)
{
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(PetscTime(&now));
  PetscCall(SlipH5WriteAttrReal(&out->file, "/run", "wall_time", out->wall + (now - out->begin)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputFinishFile(SlipOutput out, const SlipOutputTotals *t)
{
  SlipH5 *h = &out->file;

  PetscFunctionBegin;
  PetscCall(SlipOutputPolicy(out));
  PetscCall(SlipOutputRunNumbers(out));
  PetscCall(SlipOutputWarnings(out));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "wall_time", t->wall_setup + t->wall_solve));
  for (PetscInt i = 0; i < out->nresults; i++)
    if (!PetscIsNanReal(out->result[i].value))
      PetscCall(SlipH5WriteAttrReal(h, "/result", out->result[i].name, out->result[i].value));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "accepted", t->accepted));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "rejected", t->rejected));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "solves", t->solves));
  if (t->implicit) PetscCall(SlipH5WriteAttrInt(h, "/result", "explicit_attempts", t->explicits));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "newton_iterations", t->newton));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "linear_iterations", t->linear));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_setup", t->wall_setup));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_solve", t->wall_solve));
  PetscCall(SlipH5Close(h)); /* the file takes its final name */
  PetscFunctionReturn(PETSC_SUCCESS);
}
