/* Saves and loads checkpoints of a fault's run: all data that outlive a step. samerun.c compares runs. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipts.h>
#include <slipstep/private/sliprunsaving.h>
#include <slipstep/private/slipwork.h>

/* ---- the state ---- */

/* Visits everything. New data that outlive a step are visited by an observer, or by SLIP_STATE_METHOD of their object.
   */
static PetscErrorCode VisitFaultState(SlipState s, TS ts, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  char restart[PETSC_MAX_PATH_LEN + 64];
  PetscBool left = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(restart, sizeof(restart), "-%sfault_restart %s", SlipFaultPrefix(fault),
                          fault->options.text[FAULT_RESTART]));
  PetscCall(SlipFaultVisitRun(fault, s, ts));
  PetscCall(SlipStateCells(s, fault->mesh.N, fault->mesh.order));
  PetscCall(SlipStateTS(s, ts));
  PetscCall(SlipFaultExplicitState(fault, s, ts));
  if (SlipStateIsLoading(s)) PetscCall(SlipCheckpointStepsLeft(s, ts, restart, &left));
  fault->run->idle = left ? PETSC_FALSE : PETSC_TRUE;
  if (SlipStateIsLoading(s) && fault->problem.steps.begin)
    PetscCall((*fault->problem.steps.begin)(ts, PETSC_FALSE, fault));
  PetscCall(SlipStateAdapt(s, ts));
  PetscCall(SlipElasticVisit(fault->medium, s));
  /* without a step to take there are no observers, and files stay as they are */
  PetscCall(left ? SlipFaultObserversVisit(fault, s) : SlipFaultObserversDestroy(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* Sets the checkpoint's step, unless -fault_restart_dt gives another one. */
static PetscErrorCode RestartStep(SlipFault fault, TS ts)
{
  const char *prefix;
  const PetscReal dt = fault->options.value[FAULT_RESTART_DT];
  PetscReal step, least;
  PetscBool given, renamed; /* its name in PETSc from 3.25 on */

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, prefix, "-ts_dt", &given));
  PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, prefix, "-ts_time_step", &renamed));
  if (dt > 0) PetscCall(TSSetTimeStep(ts, dt));
  PetscCall(TSGetTimeStep(ts, &step));
  PetscCheck(
    !SlipStepIsLost(ts, step, &least), fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
    "the next step is %g s at the time of -%sfault_restart %s, %.15g s: expected at least %g s, by -%sfault_restart_dt",
    (double)step, SlipFaultPrefix(fault), fault->options.text[FAULT_RESTART], (double)ts->ptime, (double)least,
    SlipFaultPrefix(fault));
  if ((given || renamed) && dt <= 0)
    PetscCall(PetscPrintf(fault->comm,
                          "The run goes on with the step of its checkpoint, %g s, and not that of -%sts_dt: "
                          "-%sfault_restart_dt would be used\n",
                          (double)step, prefix ? prefix : "", SlipFaultPrefix(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Restart(SlipFault fault, TS ts)
{
  char source[128], first[128] = "";
  PetscReal time;
  PetscInt step;
  SlipState s;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(source, sizeof(source), "-%sfault_restart", SlipFaultPrefix(fault)));
  SlipWorkPause(PETSC_TRUE);
  PetscCall(SlipStateOpen(fault->comm, fault->options.text[FAULT_RESTART], source, &s));
  PetscCall(VisitFaultState(s, ts, fault));
  PetscCall(SlipStateClose(&s));
  SlipWorkPause(PETSC_FALSE);
  if (fault->run->idle) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RestartStep(fault, ts));
  PetscCall(SlipClockRead(ts, &time, NULL));
  PetscCall(TSGetStepNumber(ts, &step));
  if (fault->options.value[FAULT_RESTART_DT] > 0)
    PetscCall(PetscSNPrintf(first, sizeof(first), ", with a step of %g s (-%sfault_restart_dt)",
                            (double)fault->options.value[FAULT_RESTART_DT], SlipFaultPrefix(fault)));
  PetscCall(PetscPrintf(fault->comm, "The run continues from %s at time %g s after %" PetscInt_FMT " steps%s\n",
                        fault->options.text[FAULT_RESTART], (double)time, step, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses to overwrite an older checkpoint in a run that does not continue from it. */
static PetscErrorCode CheckFile(SlipFault fault)
{
  const char *file = fault->options.text[FAULT_CHECKPOINT], *prefix = SlipFaultPrefix(fault);
  PetscBool exists, same;

  PetscFunctionBegin;
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateCheckCreate(fault->comm, prefix, "fault_checkpoint", file, &exists));
  PetscCall(PetscStrcmp(file, fault->options.text[FAULT_RESTART], &same));
  if (fault->options.output_overwrite) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!exists || same, fault->comm, PETSC_ERR_FILE_OPEN,
             "%s is there already (-%sfault_checkpoint): go on from it with -%sfault_restart %s, or throw it away with "
             "-%sfault_output_overwrite",
             file, prefix, prefix, file, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultCheckpointStart - continues from -fault_restart, and writes checkpoints of the run

  Collective; after SlipFaultOutputStart() with the solution set, before TSSolve().

  Input Parameters:
+ fault - the fault
- ts    - the TS that it configured, of type TSBATHE, or TSRKC, TSRK or TSADAMS without inertia

  Options Database Keys:
+ -fault_checkpoint <F.h5>           - writes the state of the run to this file; the one before stays as F.h5.previous
. -fault_checkpoint_interval <600>   - wall time from one checkpoint to the next [s]
. -fault_restart <F.h5>              - continues from this checkpoint, or from F.h5.previous when it is damaged
. -fault_restart_dt <dt>             - next step of a run that continues [s]; 0: the checkpoint's
. -fault_wall_limit <S>              - stops in time for the program to end within S seconds
- -fault_stop_file <F>               - stops after the present step when F appears where the first process sees it

  Level: intermediate

  Notes:
  A continued run is the same run: on as many processes with the same bits, on others to rounding. It refuses options
  that change what is computed, with both values, announces changed options of steps and solvers, and accepts others
  for what is written. The memory of the controller is part of the checkpoint, also that of dsp, which is PETSc's;
  another controller begins without memory. A policy other than the checkpoint's is announced. A larger -ts_max_time
  lengthens a run that has reached its end. A run without a step to take, because its final time or -ts_max_steps is
  reached, writes nothing: it prints a line, its observers are destroyed, and TSSolve() returns at once.

  A run whose steps fail ends by an error, and writes the state before that.

  After `SlipSignalsPush()`, SIGTERM, SIGINT, SIGUSR1 and SIGXCPU stop the run after the present step, with a
  checkpoint; `SlipFaultCheckpointFinish()` returns this after TSSolve().

  Errors: PETSC_ERR_ARG_INCOMP for another TS type, PETSC_ERR_FILE_OPEN when the file exists and the run does not
  continue from it, or cannot write it, PETSC_ERR_ARG_INCOMP for the checkpoint of another run, PETSC_ERR_ARG_OUTOFRANGE
  for a final time before the checkpoint's, or a step below the rounding of its time, which -fault_restart_dt replaces

.seealso: SlipFaultCheckpointFinish(), SlipSignalsPush(), SlipFaultOutputStart()
@*/
PetscErrorCode SlipFaultCheckpointStart(SlipFault fault, TS ts)
{
  const char *prefix = SlipFaultPrefix(fault);
  const SlipCheckpointPlan plan = {.file = fault->options.text[FAULT_CHECKPOINT],
                                   .interval = fault->options.value[FAULT_CHECKPOINT_INTERVAL],
                                   .wall_limit = fault->options.value[FAULT_WALL_LIMIT],
                                   .stop_file = fault->options.text[FAULT_STOP_FILE],
                                   .visit = VisitFaultState,
                                   .ctx = fault};
  SlipCheckpointPlan named = plan;
  char restart[128], stop[128];

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipFaultCheckFeatures(fault, ts));
  PetscCall(CheckFile(fault));
  fault->run->idle = PETSC_FALSE;
  if (fault->options.text[FAULT_RESTART][0]) PetscCall(Restart(fault, ts));
  PetscCall(PetscSNPrintf(restart, sizeof(restart), "-%sfault_restart", prefix));
  PetscCall(PetscSNPrintf(stop, sizeof(stop), "-%sfault_stop_file", prefix));
  named.restart = restart;
  named.stop_option = stop;
  named.option = "fault_checkpoint";
  PetscCall(SlipCheckpointStart(ts, &named));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultCheckpointFinish - writes the last checkpoint of a run

  For a run that was stopped before its end it prints on stderr how to continue.

  Collective; after TSSolve(), before SlipFaultOutputFinish().

  Input Parameters:
+ fault - the fault
- ts    - the TS, after SlipFaultCheckpointStart()

  Output Parameter:
. code - exit code for the program: 128 plus the number of the signal, 152 (SIGXCPU) for -fault_wall_limit, 138
         (SIGUSR1) for -fault_stop_file; 0: the run was not stopped

  Level: intermediate

  Errors: PETSC_ERR_NOT_CONVERGED, after the checkpoint is written, where a step has failed in TSSolve()
  (TSSetErrorIfStepFails())

  Note:
  The output of a run that was stopped stays unfinished: call `SlipFaultReportStop()` instead of
  `SlipFaultOutputFinish()`.

.seealso: SlipFaultCheckpointStart(), SlipFaultReportStop()
@*/
PetscErrorCode SlipFaultCheckpointFinish(SlipFault fault, TS ts, int *code)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscAssertPointer(code, 3);
  PetscCall(SlipCheckpointFinish(ts, code));
  if (*code) PetscCall(SlipFaultObserversDestroy(fault)); /* files stay unfinished */
  PetscFunctionReturn(PETSC_SUCCESS);
}
