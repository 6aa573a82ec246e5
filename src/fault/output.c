/* Output of a run: monitors that fill the file, and the summary at its end. */
#include <slipstep/private/slipfaultoutput.h>
#include <slipstep/private/sliperror.h>
#include <slipstep/private/slipcompat.h>
#include <slipadapt.h>
#include <petsctime.h>

#define SLIP_OUTPUT_FLUSH 10.0 /* wall time after which rows collected are brought to disk [s] */

PetscErrorCode SlipFaultOutputDestroy(SlipFaultOutput *output)
{
  SlipFaultOutput out = *output;

  PetscFunctionBegin;
  if (!out) PetscFunctionReturn(PETSC_SUCCESS);
  if (out->file.id > 0) H5Fclose(out->file.id); /* of a run that did not finish: FILE.part stays, FILE is untouched */
  PetscCall(VecScatterDestroy(&out->gather_w));
  PetscCall(VecScatterDestroy(&out->gather_r));
  PetscCall(VecDestroy(&out->w0));
  PetscCall(VecDestroy(&out->r0));
  PetscCall(PetscFree(*output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultOutputFlush(SlipFaultOutput out)
{
  PetscFunctionBegin;
  PetscCall(SlipTableFlush(&out->steps, &out->file));
  PetscCall(SlipTableFlush(&out->series, &out->file));
  PetscCall(SlipH5Flush(&out->file));
  PetscCall(PetscTime(&out->last_flush));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A row of /steps, and what was collected to disk from time to time. Rank 0. */
static PetscErrorCode SlipFaultOutputAttempt(SlipFaultOutput out, const SlipAttempt *a)
{
  const PetscReal row[] = {a->time,
                           a->dt,
                           a->accepted,
                           a->error,
                           a->converged,
                           (PetscReal)a->newton,
                           (PetscReal)a->linear,
                           (PetscReal)a->solves,
                           a->residual,
                           (PetscReal)a->reason,
                           a->wall};
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(SlipTableAdd(&out->steps, &out->file, row));
  PetscCall(PetscTime(&now));
  if (now - out->last_flush > SLIP_OUTPUT_FLUSH) PetscCall(SlipFaultOutputFlush(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultAttemptMonitor(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  SlipFaultOutput out = ((SlipFault)ctx)->output;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  (void)ts;
  (void)w;
  if (!out) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipErrorUnfinished(NULL)); /* the run has begun */
  if (!out->rank) ierr = SlipFaultOutputAttempt(out, attempt);
  PetscCall(SlipErrorBcast(out->fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The reaction, or NULL when the integrator has none. */
static PetscErrorCode SlipFaultReaction(TS ts, Vec *r)
{
  PetscBool bathe;

  PetscFunctionBegin;
  *r = NULL;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (bathe) PetscCall(TSBatheGetReaction(ts, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultOutputSeries(SlipFaultOutput out, PetscReal time, Vec w, Vec r)
{
  SlipFaultObservables o;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetObservables(out->fault, w, r, &o));
  if (!out->rank) {
    const PetscReal row[] = {
      time,      o.mean_slip_rate, o.max_slip_rate, o.mean_slip,      o.mean_displacement, o.sliding_fraction,
      o.kinetic, o.elastic,        o.viscous_power, o.friction_power, o.loading_power};

    ierr = SlipTableAdd(&out->series, &out->file, row);
  }
  PetscCall(SlipErrorBcast(out->fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSMonitor: a row of /series for each accepted step; /fields for the start and every n-th step. */
static PetscErrorCode SlipFaultStepMonitor(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultOutput out = fault->output;
  Vec r;

  PetscFunctionBegin;
  if (step < 0 || !out) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultReaction(ts, &r));
  if (step > 0) PetscCall(SlipFaultOutputSeries(out, time, w, r));
  if (step % (PetscInt)fault->value[FAULT_OUTPUT_INTERVAL] == 0) {
    PetscCall(SlipFaultOutputFields(out, time, w, r));
    out->last_field_step = step;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputStart - open -fault_output and attach the monitors that write it; without that option do nothing

  Collective; after TSSetFromOptions(), before TSSolve().

  Level: intermediate

  Errors: PETSC_ERR_FILE_OPEN when the file cannot be created, PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown field.

  Notes:
  The content goes to FILE.part, which takes FILE's name in SlipFaultOutputFinish(): a run that fails leaves an older
  FILE as it was. FILE.part stays when the run had begun. The layout is that of DESIGN.md section 7.

.seealso: SlipFaultOutputFinish()
@*/
PetscErrorCode SlipFaultOutputStart(SlipFault fault, TS ts)
{
  SlipFaultOutput out;
  Vec w;
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  if (!fault->text[FAULT_OUTPUT][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!fault->output, fault->comm, PETSC_ERR_ORDER, "the output of the last run was not finished");
  PetscCall(PetscNew(&out));
  fault->output = out;
  out->fault = fault;
  out->file.id = -1;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &out->rank));
  PetscCall(SlipErrorSource("-fault_output"));
  PetscCall(SlipFaultOutputOpen(out));
  if (!out->rank) PetscCall(SlipErrorUnfinished(out->file.name));
  PetscCall(SlipErrorSource(NULL));
  PetscCall(PetscTime(&out->last_flush));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(VecScatterCreateToZero(w, &out->gather_w, &out->w0));
  PetscCall(VecScatterCreateToZero(fault->uc, &out->gather_r, &out->r0));
  PetscCall(VecDestroy(&w));
  PetscCall(SlipFaultOutputMesh(out));
  PetscCall(TSMonitorSet(ts, SlipFaultStepMonitor, fault, NULL));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (bathe) PetscCall(TSBatheAddAttemptMonitor(ts, SlipFaultAttemptMonitor, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the end of a run reports. */
typedef struct {
  PetscInt accepted, rejected, solves, newton, linear;
  PetscReal mean_slip, wall_setup, wall_solve;
} SlipFaultResult;

static PetscErrorCode SlipFaultGetResult(SlipFault fault, TS ts, SlipFaultResult *res)
{
  SlipFaultObservables obs;
  Vec w;
  PetscBool bathe;
  PetscInt attempts;

  PetscFunctionBegin;
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultGetObservables(fault, w, NULL, &obs));
  res->mean_slip = obs.mean_slip;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (bathe) {
    PetscCall(TSBatheGetTotals(ts, &attempts, &res->accepted, &res->solves, &res->newton, &res->linear));
    res->rejected = attempts - res->accepted;
  } else {
    PetscCall(TSGetStepNumber(ts, &res->accepted));
    PetscCall(TSGetStepRejections(ts, &res->rejected));
    PetscCall(TSGetSNESIterations(ts, &res->newton));
    PetscCall(TSGetKSPIterations(ts, &res->linear));
    res->solves = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Which policy chose the steps, when one did. */
static PetscErrorCode SlipFaultWritePolicy(SlipH5 *h, TSAdapt adapt)
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

static PetscErrorCode SlipFaultWriteRun(SlipFault fault, TS ts, SlipH5 *h, const SlipFaultResult *res)
{
  char *options, version[256];
  PetscMPIInt size;
  TSAdapt adapt;
  TSType type;
  TSAdaptType adapt_type;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCall(PetscOptionsGetAll(NULL, &options));
  PetscCall(SlipH5WriteAttrString(h, "/run", "options", options));
  PetscCall(PetscFree(options));
  PetscCall(PetscGetVersion(version, sizeof(version)));
  PetscCall(SlipH5WriteAttrString(h, "/run", "petsc_version", version));
  PetscCall(SlipH5WriteAttrString(h, "/run", "slipstep_version", SLIPSTEP_VERSION));
  PetscCall(SlipH5WriteAttrInt(h, "/run", "ranks", size));
  PetscCall(TSGetType(ts, &type));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptGetType(adapt, &adapt_type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_type", type));
  PetscCall(SlipH5WriteAttrString(h, "/run", "ts_adapt_type", adapt_type ? adapt_type : ""));
  PetscCall(SlipFaultWritePolicy(h, adapt));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "stiffness_scaling_factor", fault->scaling));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "time_scale", fault->tstar));
  PetscCall(SlipH5WriteAttrReal(h, "/run", "wall_time", res->wall_setup + res->wall_solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultWriteResult(SlipH5 *h, const SlipFaultResult *res)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrReal(h, "/result", "mean_slip", res->mean_slip));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "accepted", res->accepted));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "rejected", res->rejected));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "solves", res->solves));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "newton_iterations", res->newton));
  PetscCall(SlipH5WriteAttrInt(h, "/result", "linear_iterations", res->linear));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_setup", res->wall_setup));
  PetscCall(SlipH5WriteAttrReal(h, "/result", "wall_time_solve", res->wall_solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: what is left, then the file's final name. */
static PetscErrorCode SlipFaultOutputComplete(SlipFaultOutput out, TS ts, const SlipFaultResult *res)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultOutputFlush(out));
  PetscCall(SlipFaultWriteRun(out->fault, ts, &out->file, res));
  PetscCall(SlipFaultWriteResult(&out->file, res));
  PetscCall(SlipH5Close(&out->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultOutputLastFields(SlipFaultOutput out, TS ts)
{
  PetscInt step;
  PetscReal time;
  Vec w, r;

  PetscFunctionBegin;
  PetscCall(TSGetStepNumber(ts, &step));
  if (step == out->last_field_step) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipFaultReaction(ts, &r));
  PetscCall(SlipFaultOutputFields(out, time, w, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultPrintResult(MPI_Comm comm, const SlipFaultResult *res)
{
  PetscFunctionBegin;
  PetscCall(PetscPrintf(comm, "accepted steps:          %" PetscInt_FMT "\n", res->accepted));
  PetscCall(PetscPrintf(comm, "rejected steps:          %" PetscInt_FMT "\n", res->rejected));
  PetscCall(PetscPrintf(comm, "Bathe solves:            %" PetscInt_FMT "\n", res->solves));
  PetscCall(PetscPrintf(comm, "Newton iterations:       %" PetscInt_FMT "\n", res->newton));
  PetscCall(PetscPrintf(comm, "linear iterations:       %" PetscInt_FMT "\n", res->linear));
  PetscCall(PetscPrintf(comm, "final mean slip:         %.12g m\n", (double)res->mean_slip));
  PetscCall(PetscPrintf(comm, "wall time of set-up:     %.4f s\n", (double)res->wall_setup));
  PetscCall(PetscPrintf(comm, "wall time of the solve:  %.4f s\n", (double)res->wall_solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputFinish - print the summary of a run and complete its output file

  Collective; after TSSolve().

  Input Parameters:
+ fault      - the fault
. ts         - the TS that was solved
. wall_setup - wall time of set-up [s]
- wall_solve - wall time of TSSolve() [s]

  Level: intermediate

.seealso: SlipFaultOutputStart()
@*/
PetscErrorCode SlipFaultOutputFinish(SlipFault fault, TS ts, PetscReal wall_setup, PetscReal wall_solve)
{
  SlipFaultOutput out = fault->output;
  SlipFaultResult res = {.wall_setup = wall_setup, .wall_solve = wall_solve};
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetResult(fault, ts, &res));
  if (out) {
    PetscCall(SlipFaultOutputLastFields(out, ts));
    if (!out->rank) ierr = SlipFaultOutputComplete(out, ts, &res);
    PetscCall(SlipErrorBcast(fault->comm, ierr));
    PetscCall(SlipFaultOutputDestroy(&fault->output));
  }
  PetscCall(SlipFaultPrintResult(fault->comm, &res));
  PetscFunctionReturn(PETSC_SUCCESS);
}
