/* Stops and continues runs. After each step the processes agree whether one of them received a request to stop, and
   whether the state must be written. That happens before the next step, or after TSSolve(), when monitors have written
   what belongs to the state. The objects that own a state visit it (slipstate.h). */
#define _POSIX_C_SOURCE 200809L
#include <petsc/private/tsimpl.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/rooms/slipcore.h>
#include <slipstep/private/sliprunsaving.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipts.h>
#include <petsctime.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <slipstep/private/slipwork.h>

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
  TS ts; /* borrowed */
  MPI_Comm comm;
  PetscMPIInt rank;
  char file[PETSC_MAX_PATH_LEN], stop_file[PETSC_MAX_PATH_LEN], restart[128], option[64], stop_option[128];
  PetscReal interval, limit;
  SlipCheckpointFn visit;
  void *ctx;
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
  PetscCall((*c->visit)(state, c->ts, c->ctx));
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

/* Collects this process's requests: the signal that it caught, or on rank 0 the end of the time; and on rank 0 a
   checkpoint, the number of steps that need no agreement, and the end if the stop file exists. */
static PetscErrorCode SlipCheckpointRequests(SlipCheckpoint *c, int wish[4])
{
  PetscLogDouble now, begun;
  PetscReal spent;

  PetscFunctionBegin;
  PetscCall(SlipSignalsCaught(&wish[0]));
  PetscCall(PetscTime(&now));
  wish[1] = wish[2] = wish[3] = 0;
  if (c->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipGetStartTime(&begun));
  spent = (PetscReal)(now - begun);
  if (!wish[0] &&
      spent + CHECKPOINT_STEPS * c->longest_step + CHECKPOINT_WRITES * c->longest_write + CHECKPOINT_REST > c->limit)
    wish[0] = -CHECKPOINT_LIMIT;
  if (now - c->last_write >= c->interval || (!c->written && spent >= CHECKPOINT_FIRST * c->limit)) wish[1] = 1;
  wish[2] =
    c->interval < CHECKPOINT_AGREE ? 0 : (int)PetscMin(CHECKPOINT_AGREE / (now - c->last_step), CHECKPOINT_UNASKED);
  wish[3] = c->stop_file[0] && !access(c->stop_file, F_OK) ? CHECKPOINT_FILE : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs after each step. */
static PetscErrorCode SlipCheckpointAfterStep(TS ts)
{
  SlipCheckpoint *c;
  PetscLogDouble now;
  int wish[4], all[5];

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &c));
  if (c->poststep) PetscCall((*c->poststep)(ts));
  PetscCall(PetscTime(&now));
  c->longest_step = PetscMax(c->longest_step, now - c->last_step);
  if (c->wait-- > 0 || ts->reason) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipCheckpointRequests(c, wish));
  all[0] = PetscMax(wish[0], 0); /* a signal has priority over a limit */
  all[1] = PetscMax(-wish[0], 0);
  all[2] = wish[1];
  all[3] = wish[2];
  all[4] = wish[3];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 5, MPI_INT, MPI_MAX, c->comm));
  c->wait = all[3];
  c->due = all[2] && c->file[0] && !c->over ? PETSC_TRUE : PETSC_FALSE;
  if (all[0] || all[1] || all[4]) {
    c->by_file = !all[0] && all[4] ? PETSC_TRUE : PETSC_FALSE;
    c->by_limit = !all[0] && !all[4] ? PETSC_TRUE : PETSC_FALSE;
    c->stopped = all[0] ? all[0] : c->by_file ? all[4] : all[1];
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

static PetscErrorCode SlipCheckpointFailed(TS ts); /* below */

PetscErrorCode SlipCheckpointStart(TS ts, const SlipCheckpointPlan *plan)
{
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
  c->ts = ts;
  c->comm = PetscObjectComm((PetscObject)ts);
  PetscCallMPI(MPI_Comm_rank(c->comm, &c->rank));
  PetscCall(PetscStrncpy(c->file, plan->file, sizeof(c->file)));
  PetscCall(PetscStrncpy(c->stop_file, plan->stop_file ? plan->stop_file : "", sizeof(c->stop_file)));
  PetscCall(PetscStrncpy(c->stop_option, plan->stop_option ? plan->stop_option : "", sizeof(c->stop_option)));
  there = !c->rank && c->stop_file[0] && !access(c->stop_file, F_OK);
  PetscCallMPI(MPI_Bcast(&there, 1, MPIU_INT, 0, c->comm));
  PetscCheck(!there, c->comm, PETSC_ERR_FILE_OPEN,
             "%s is there already (%s), which ends a run after its step: remove it first", c->stop_file,
             c->stop_option);
  PetscCall(PetscStrncpy(c->restart, plan->restart, sizeof(c->restart)));
  PetscCall(PetscStrncpy(c->option, plan->option ? plan->option : "checkpoint", sizeof(c->option)));
  c->interval = plan->interval;
  c->limit = plan->wall_limit > 0 ? plan->wall_limit : PETSC_MAX_REAL;
  c->visit = plan->visit;
  c->ctx = plan->ctx;
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

PetscErrorCode SlipCheckpointFinish(TS ts, int *code)
{
  SlipCheckpoint *c;
  char command[8192], who[PETSC_MAX_PATH_LEN + 192];
  PetscReal time;
  PetscBool raises;

  PetscFunctionBegin;
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
  if (c->rank) PetscFunctionReturn(PETSC_SUCCESS);
  if (c->by_limit)
    (void)snprintf(who, sizeof(who), "the wall limit of %g s", (double)c->limit);
  else if (c->by_file)
    (void)snprintf(who, sizeof(who), "the file %s (%s)", c->stop_file, c->stop_option);
  else
    PetscCall(PetscStrncpy(who, SlipSignalName(c->stopped), sizeof(who)));
  if (c->file[0]) {
    PetscCall(SlipCheckpointCommand(c, command, sizeof(command)));
    PetscCall(SlipWarning("stopped by %s at time %g s after %d steps; to continue: %s", who, (double)time,
                          (int)c->ts->steps, command));
  } else
    PetscCall(
      SlipWarning("stopped by %s at time %g s after %d steps, without a checkpoint to continue from: no -%s was given",
                  who, (double)time, (int)c->ts->steps, c->option));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCheckpointStepsLeft(SlipState state, TS ts, const char source[], PetscBool *left)
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
