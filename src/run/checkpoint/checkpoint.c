/* Checkpoints of a fault's run: when its state is written, when it stops early, and how it goes on. After each step the
   processes agree whether one of them received a request to stop, and whether the state must be written. That happens
   before the next step, or after TSSolve(), when monitors have written what belongs to the state. The objects that have
   a state visit it (slipstate.h); samerun.c compares runs. */
#define _POSIX_C_SOURCE 200809L
#include <petsc/private/tsimpl.h>
#include <slipcompat.h>
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipwork.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/rooms/slipsys.h>
#include <petsctime.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char key[] = "SlipCheckpoint";

/* A wall limit is treated as this signal, which batch systems send for it: exit code 152. */
#define CHECKPOINT_LIMIT SIGXCPU
/* A stop file is treated as this signal: exit code 138. */
#define CHECKPOINT_FILE SIGUSR1
/* The remaining time of a wall limit must suffice for a step and a checkpoint as long as the longest so far, times
   these factors, plus this time for the rest of the program [s]. */
#define CHECKPOINT_STEPS 1.5
#define CHECKPOINT_WRITES 2.0
#define CHECKPOINT_REST 1.0
/* Processes agree after every step, or if steps are shorter than this, after as many as take about as long [s]: a
   reduction then costs less than 0.1 % of the time, as a step of 25 x 25 cells has 167. */
#define CHECKPOINT_AGREE 0.05
#define CHECKPOINT_UNASKED 20 /* largest number of steps between, as later ones may take much longer */
/* The first checkpoint of a run with a wall limit is written after this share of it, so that its time is known. */
#define CHECKPOINT_FIRST 0.1

typedef struct {
  SlipFault fault; /* borrowed, as the next one */
  TS ts;
  MPI_Comm comm;
  PetscMPIInt rank;
  char file[PETSC_MAX_PATH_LEN], stop_file[PETSC_MAX_PATH_LEN], restart[128], stop_option[128];
  PetscReal interval, limit;
  PetscErrorCode (*poststep)(TS), (*prestep)(TS); /* the functions that were set before */
  PetscInt wait;                                  /* steps to the next agreement */
  PetscBool due;                                  /* a checkpoint is due before the next step */
  PetscBool over;                                 /* the run has ended: what the TS does now is not part of it */
  int stopped;                                    /* signal, or 0 */
  PetscBool by_limit, by_file;                    /* no signal was sent */
  PetscLogDouble last_step, last_write;           /* ends of the last ones [s] */
  PetscLogDouble longest_step, longest_write;     /* [s] */
  PetscInt written;                               /* checkpoints */
  PetscInt first;                                 /* steps before this run, which writes nothing without another one */
  PetscBool raises;                               /* Finish raises PETSc's error for a failed step */
} SlipCheckpoint;

/* Finds whether the TS is at its final time, or at the one that an earlier run reached. The last step may have gone
   beyond it. */
static PetscErrorCode SlipCheckpointAtEnd(TS ts, PetscReal reached, PetscBool *is)
{
  PetscReal end;

  PetscFunctionBegin;
  PetscCall(SlipClockRead(ts, NULL, &end));
  *is = reached == end || SlipControlAtEnd(ts->ptime, ts->max_time) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether a run that continues from a checkpoint has a step to take; otherwise a message states the reason. It is
   an error if the checkpoint is after the final time. source: option and file, for messages. Collective, after
   SlipStateTS(), once the final time of ts is set. */
static PetscErrorCode SlipCheckpointStepsLeft(SlipState state, TS ts, const char source[], PetscBool *left)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)ts);
  PetscReal reached = PETSC_MIN_REAL, time, last;
  const char *prefix;
  char at[32], end[32]; /* by C's own printf, as PETSc's %g writes "5." for 5 */
  PetscBool given, over = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipStateGroup(state, "run"));
  PetscCall(SlipStateReal(state, "final_time", 1, &reached));
  PetscCall(SlipCheckpointAtEnd(ts, reached, &over));
  *left = !over && ts->ptime < ts->max_time && ts->steps < ts->max_steps ? PETSC_TRUE : PETSC_FALSE;
  if (*left) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, prefix, "-ts_max_time", &given));
  if (!prefix) prefix = "";
  PetscCall(SlipClockRead(ts, &time, &last));
  (void)snprintf(at, sizeof(at), "%.9g", (double)time);
  (void)snprintf(end, sizeof(end), "%.9g", (double)last);
  PetscCheck(over || ts->ptime < ts->max_time, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "%s is at time %s s, after the final time of %s s (-%sts_max_time%s): expected a later final time", source,
             at, end, prefix, given ? "" : ", which was not given");
  if (over)
    PetscCall(PetscPrintf(
      comm, "%s is at the final time of %s s (-%sts_max_time): nothing is left to do, and nothing is written\n", source,
      end, prefix));
  else
    PetscCall(PetscPrintf(comm,
                          "%s is at time %s s after %" PetscInt_FMT " steps, and -%sts_max_steps is %" PetscInt_FMT
                          ": no step is left, and nothing is written\n",
                          source, at, ts->steps, prefix, ts->max_steps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits everything. New data that outlive a step are visited by an observer, or by SLIP_STATE_METHOD of their object.
   */
static PetscErrorCode VisitFaultState(SlipFault fault, SlipState s, TS ts)
{
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
  PetscCall(SlipFaultZoneVisit(fault, s));
  PetscCall(SlipFaultFluidVisit(fault, s));
  /* without a step to take there are no observers, and files stay as they are */
  PetscCall(left ? SlipFaultObserversVisit(fault, s) : SlipFaultObserversDestroy(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipCheckpointWrite(SlipCheckpoint *c)
{
  PetscLogDouble begin;
  SlipState state;
  PetscReal final_time = PETSC_MIN_REAL;
  PetscBool ended = PETSC_FALSE;

  PetscFunctionBegin;
  SlipWorkPause(PETSC_TRUE);
  PetscCall(SlipLogOutputBegin());
  PetscCall(PetscTime(&begin));
  PetscCall(SlipStateCreate(c->comm, c->file, &state));
  PetscCall(VisitFaultState(c->fault, state, c->ts));
  PetscCall(SlipCheckpointAtEnd(c->ts, final_time, &ended));
  if (ended || c->ts->ptime >= c->ts->max_time) PetscCall(SlipClockRead(c->ts, NULL, &final_time));
  PetscCall(SlipStateGroup(state, "run"));
  PetscCall(SlipStateReal(state, "final_time", 1, &final_time)); /* the one that was reached, if any */
  PetscCall(SlipStateClose(&state));
  PetscCall(PetscTime(&c->last_write));
  c->longest_write = PetscMax(c->longest_write, c->last_write - begin);
  c->written++;
  PetscCall(SlipLogOutputEnd());
  SlipWorkPause(PETSC_FALSE);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs after each step. Each process may have caught a signal; rank 0 decides about the other requests. */
static PetscErrorCode SlipCheckpointAfterStep(TS ts)
{
  enum { SIGNAL, LIMIT, FILE_THERE, DUE, WAIT, NUM }; /* a signal has priority over a file, and that over the limit */
  SlipCheckpoint *c;
  PetscLogDouble now, begun;
  int all[NUM] = {0};

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &c));
  if (c->poststep) PetscCall((*c->poststep)(ts));
  PetscCall(PetscTime(&now));
  c->longest_step = PetscMax(c->longest_step, now - c->last_step);
  if (c->wait-- > 0 || ts->reason) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipSignalsCaught(&all[SIGNAL]));
  if (!c->rank) {
    PetscReal spent;

    PetscCall(SlipGetStartTime(&begun));
    spent = (PetscReal)(now - begun);
    if (!all[SIGNAL] &&
        spent + CHECKPOINT_STEPS * c->longest_step + CHECKPOINT_WRITES * c->longest_write + CHECKPOINT_REST > c->limit)
      all[LIMIT] = CHECKPOINT_LIMIT;
    if (c->stop_file[0] && !access(c->stop_file, F_OK)) all[FILE_THERE] = CHECKPOINT_FILE;
    if (now - c->last_write >= c->interval || (!c->written && spent >= CHECKPOINT_FIRST * c->limit)) all[DUE] = 1;
    if (c->interval >= CHECKPOINT_AGREE)
      all[WAIT] = (int)PetscMin(CHECKPOINT_AGREE / (now - c->last_step), CHECKPOINT_UNASKED);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, NUM, MPI_INT, MPI_MAX, c->comm));
  c->wait = all[WAIT];
  c->due = all[DUE] && c->file[0] && !c->over ? PETSC_TRUE : PETSC_FALSE;
  if (all[SIGNAL] || all[LIMIT] || all[FILE_THERE]) {
    c->by_file = !all[SIGNAL] && all[FILE_THERE] ? PETSC_TRUE : PETSC_FALSE;
    c->by_limit = !all[SIGNAL] && !all[FILE_THERE] ? PETSC_TRUE : PETSC_FALSE;
    c->stopped = all[SIGNAL] ? all[SIGNAL] : c->by_file ? all[FILE_THERE] : all[LIMIT];
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipCheckpointBeforeStep(TS ts)
{
  SlipCheckpoint *c;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &c));
  if (c->due) PetscCall(SlipCheckpointWrite(c));
  c->due = PETSC_FALSE;
  if (c->prestep) PetscCall((*c->prestep)(ts)); /* it may change the state, and the continued run repeats that */
  PetscCall(PetscTime(&c->last_step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- how to continue ---- */

/* Appends a word, quoted for a shell if necessary. */
static PetscErrorCode AppendQuoted(char text[], size_t len, const char word[])
{
  static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,/:%@";
  const PetscBool quote = !word[0] || word[strspn(word, plain)] ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscStrlcat(text, text[0] ? " " : "", len));
  if (quote) PetscCall(PetscStrlcat(text, "'", len));
  for (const char *c = word; *c; c++) {
    const char one[] = {*c, '\0'};

    PetscCall(PetscStrlcat(text, *c == '\'' ? "'\\''" : one, len));
  }
  if (quote) PetscCall(PetscStrlcat(text, "'", len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Composes the command line of this program that continues from the checkpoint. */
static PetscErrorCode SlipCheckpointCommand(SlipCheckpoint *c, char text[], size_t len)
{
  PetscMPIInt size;
  char number[32];
  int argc;
  char **argv;

  PetscFunctionBegin;
  PetscCall(PetscGetArgs(&argc, &argv));
  PetscCallMPI(MPI_Comm_size(c->comm, &size));
  text[0] = '\0';
  if (c->by_file) {
    PetscCall(PetscStrlcat(text, "rm", len));
    PetscCall(AppendQuoted(text, len, c->stop_file));
    PetscCall(PetscStrlcat(text, " &&", len));
  }
  if (size > 1) {
    PetscCall(PetscSNPrintf(number, sizeof(number), "%smpirun -n %d", text[0] ? " " : "", (int)size));
    PetscCall(PetscStrlcat(text, number, len));
  }
  for (int i = 0; i < argc; i++) {
    PetscBool restart;

    PetscCall(PetscStrcmp(argv[i], c->restart, &restart));
    if (restart && i + 1 < argc)
      i++; /* and the name of its file */
    else
      PetscCall(AppendQuoted(text, len, argv[i]));
  }
  PetscCall(AppendQuoted(text, len, c->restart));
  PetscCall(AppendQuoted(text, len, c->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: prints where the state of a run is whose steps have failed; its error follows. */
static PetscErrorCode SlipCheckpointSayFailed(SlipCheckpoint *c)
{
  char command[8192];
  PetscReal time;

  PetscFunctionBegin;
  if (c->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipClockRead(c->ts, &time, NULL));
  PetscCall(SlipCheckpointCommand(c, command, sizeof(command)));
  PetscCall(SlipWarning(
    "steps fail at time %g s after %d steps; to continue from there, with another tolerance or controller and a "
    "first step by %s_dt: %s",
    (double)time, (int)c->ts->steps, c->restart, command));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes, before the error of a run whose steps fail, the start of the step that cannot be computed. */
static PetscErrorCode SlipCheckpointFailed(TS ts)
{
  SlipCheckpoint *c;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &c));
  if (c->over || !c->file[0] || ts->steps == c->first) PetscFunctionReturn(PETSC_SUCCESS);
  c->over = PETSC_TRUE;
  if (ts->ops->rollback) PetscCall((*ts->ops->rollback)(ts));
  PetscCall(SlipCheckpointWrite(c));
  PetscCall(SlipCheckpointSayFailed(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Calls the functions above in every step of a TS, and begins to count. */
static PetscErrorCode SlipCheckpointStart(SlipFault fault, TS ts)
{
  const SlipFaultOptions *o = &fault->options;
  const char *prefix = SlipFaultPrefix(fault);
  SlipCheckpoint *c;
  PetscInt there;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &c));
  if (!c) {
    PetscCall(PetscNew(&c));
    PetscCall(SlipObjectComposeData((PetscObject)ts, key, c, SlipContainerDestroyDefault));
    c->poststep = ts->poststep;
    c->prestep = ts->prestep;
    PetscCall(TSSetPostStep(ts, SlipCheckpointAfterStep));
    PetscCall(TSSetPreStep(ts, SlipCheckpointBeforeStep));
    PetscCall(PetscObjectComposeFunction((PetscObject)ts, SLIP_RUN_FAILS_METHOD, SlipCheckpointFailed));
  }
  c->fault = fault;
  c->ts = ts;
  c->comm = PetscObjectComm((PetscObject)ts);
  PetscCallMPI(MPI_Comm_rank(c->comm, &c->rank));
  PetscCall(PetscStrncpy(c->file, o->text[FAULT_CHECKPOINT], sizeof(c->file)));
  PetscCall(PetscStrncpy(c->stop_file, o->text[FAULT_STOP_FILE], sizeof(c->stop_file)));
  PetscCall(PetscSNPrintf(c->stop_option, sizeof(c->stop_option), "-%sfault_stop_file", prefix));
  PetscCall(PetscSNPrintf(c->restart, sizeof(c->restart), "-%sfault_restart", prefix));
  there = !c->rank && c->stop_file[0] && !access(c->stop_file, F_OK);
  PetscCallMPI(MPI_Bcast(&there, 1, MPIU_INT, 0, c->comm));
  PetscCheck(!there, c->comm, PETSC_ERR_FILE_OPEN,
             "%s is there already (%s), which ends a run after its step: remove it first", c->stop_file,
             c->stop_option);
  c->interval = o->value[FAULT_CHECKPOINT_INTERVAL];
  c->limit = o->value[FAULT_WALL_LIMIT] > 0 ? o->value[FAULT_WALL_LIMIT] : PETSC_MAX_REAL;
  c->stopped = 0;
  c->written = 0;
  c->first = ts->steps;
  if (c->file[0] && ts->errorifstepfailed) {
    c->raises = PETSC_TRUE;
    PetscCall(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  }
  c->wait = 0;
  c->due = c->over = PETSC_FALSE;
  PetscCall(PetscTime(&c->last_step));
  c->last_write = c->last_step;
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
  PetscCall(VisitFaultState(fault, s, ts));
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
  const char *file = fault->options.text[FAULT_CHECKPOINT], *prefix = SlipFaultPrefix(fault);
  PetscBool exists, same;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipFaultCheckFeatures(fault, ts));
  if (file[0]) { /* an older checkpoint is not overwritten by a run that does not continue from it */
    PetscCall(SlipStateCheckCreate(fault->comm, prefix, "fault_checkpoint", file, &exists));
    PetscCall(PetscStrcmp(file, fault->options.text[FAULT_RESTART], &same));
    PetscCheck(
      !exists || same || fault->options.output_overwrite, fault->comm, PETSC_ERR_FILE_OPEN,
      "%s is there already (-%sfault_checkpoint): go on from it with -%sfault_restart %s, or throw it away with "
      "-%sfault_output_overwrite",
      file, prefix, prefix, file, prefix);
  }
  fault->run->idle = PETSC_FALSE;
  if (fault->options.text[FAULT_RESTART][0]) PetscCall(Restart(fault, ts));
  PetscCall(SlipCheckpointStart(fault, ts));
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
  SlipCheckpoint *c;
  char command[8192], who[PETSC_MAX_PATH_LEN + 192];
  PetscReal time;
  PetscBool raises;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscAssertPointer(code, 3);
  *code = 0;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &c));
  if (!c) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipClockRead(ts, &time, NULL));
  c->over = PETSC_TRUE;
  if (c->file[0] && ts->steps > c->first) PetscCall(SlipCheckpointWrite(c));
  raises = c->raises;
  c->raises = PETSC_FALSE;
  if (raises) PetscCall(TSSetErrorIfStepFails(ts, PETSC_TRUE));
  if (raises && ts->reason < 0) {
    if (ts->steps > c->first) PetscCall(SlipCheckpointSayFailed(c));
    SETERRQ(c->comm, PETSC_ERR_NOT_CONVERGED, "At time %.15g s TSStep has failed due to %s%s", (double)time,
            TSConvergedReasons[ts->reason], ts->reason == TS_DIVERGED_STEP_REJECTED ? " (-ts_max_reject)" : "");
  }
  if (!c->stopped) PetscFunctionReturn(PETSC_SUCCESS);
  *code = 128 + c->stopped;
  if (c->by_limit)
    (void)snprintf(who, sizeof(who), "the wall limit of %g s", (double)c->limit);
  else if (c->by_file)
    (void)snprintf(who, sizeof(who), "the file %s (%s)", c->stop_file, c->stop_option);
  else
    PetscCall(PetscStrncpy(who, SlipSignalName(c->stopped), sizeof(who)));
  if (c->file[0]) PetscCall(SlipCheckpointCommand(c, command, sizeof(command)));
  if (!c->rank && c->file[0])
    PetscCall(SlipWarning("stopped by %s at time %g s after %d steps; to continue: %s", who, (double)time,
                          (int)c->ts->steps, command));
  if (!c->rank && !c->file[0])
    PetscCall(SlipWarning("stopped by %s at time %g s after %d steps, without a checkpoint to continue from: no "
                          "-fault_checkpoint was given",
                          who, (double)time, (int)c->ts->steps));
  PetscCall(SlipFaultObserversDestroy(fault)); /* files stay unfinished */
  PetscFunctionReturn(PETSC_SUCCESS);
}
