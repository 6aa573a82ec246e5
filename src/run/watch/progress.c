/* Prints for -fault_progress a line every few seconds on a terminal, and once a minute elsewhere, with the progress of
   a run and the time left; a set-up that takes seconds prints its parts. */
#define _POSIX_C_SOURCE 200809L
#include <slipstep/private/sliprun.h>
#include <petsctime.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PROGRESS_FIRST 2                /* time of the first line on a terminal [s] */
#define PROGRESS_TERMINAL 5             /* between lines on a terminal [s] */
#define PROGRESS_FILE 60                /* between lines elsewhere [s] */
#define PROGRESS_SETUP 1                /* a set-up that takes longer prints lines [s] */
#define PROGRESS_CLEAR "\033[K"         /* clears the terminal's line */
#define PROGRESS_AGREE 0.25             /* interval at which ranks agree about a line [s] */
#define PROGRESS_MAX_STEPS_BETWEEN 1000 /* largest number of steps between */
#define PROGRESS_OVER 10                /* an event is over below the event rate over this, as in the catalogue */
#define PROGRESS_REACH 20               /* the longest prediction, over the length of the cycles so far */

/* Returns whether a line is due. elapsed: time since the run began; since: time since the last line [s] */
PetscBool SlipFaultProgressDue(PetscBool terminal, PetscReal elapsed, PetscReal since)
{
  if (!terminal) return since >= PROGRESS_FILE ? PETSC_TRUE : PETSC_FALSE;
  return since >= (since < elapsed ? PROGRESS_TERMINAL : PROGRESS_FIRST) ? PETSC_TRUE : PETSC_FALSE;
}

/*
  Returns whether stdout is a terminal. Open MPI gives its processes pseudo-terminals whatever the stdout of mpirun is,
  so that under it the stdout of the parent decides.
*/
static PetscBool IsTerminal(void)
{
  char link[64], name[64];
  ssize_t n;

  if (!isatty(STDOUT_FILENO)) return PETSC_FALSE;
  if (!getenv("OMPI_COMM_WORLD_RANK")) return PETSC_TRUE;
  (void)snprintf(link, sizeof(link), "/proc/%ld/fd/1", (long)getppid());
  n = readlink(link, name, sizeof(name) - 1);
  if (n < 0) return PETSC_FALSE;
  name[n] = '\0';
  return !strncmp(name, "/dev/pts/", 9) || !strncmp(name, "/dev/tty", 8) ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- the time left ---- */

/* Updates the cycles from which the wall time of a driven fault follows, as its seconds of events take as long as years
   of rest: a cycle lasts from the onset of an event to that of another. now, time: wall and model time [s]; rate,
   bound: largest slip rate and rate of events [m/s] */
void SlipFaultProgressSee(SlipFaultProgress *p, PetscLogDouble now, PetscReal time, PetscReal rate, PetscReal bound)
{
  if (!p->fast && rate > bound) {
    p->fast = PETSC_TRUE;
    if (!p->onsets++) {
      p->first = now;
      p->first_time = time;
    }
    p->newest = now;
    p->newest_time = time;
  } else if (rate <= bound / PROGRESS_OVER)
    p->fast = PETSC_FALSE;
}

/* Returns the wall time that is left at a wall and a model time [s]; negative: unknown. */
PetscReal SlipFaultProgressLeft(const SlipFaultProgress *p, PetscBool driven, PetscLogDouble now, PetscReal time,
                                PetscReal end)
{
  const PetscReal cycles = p->newest_time - p->first_time;

  if (time <= p->start || end <= time) return -1;
  if (!driven || !p->onsets) return (PetscReal)(now - p->begin) * ((end - time) / (time - p->start));
  if (cycles <= 0 || end - p->newest_time > PROGRESS_REACH * cycles) return -1;
  /* counted from the newest onset, since which some time has passed */
  return PetscMax((PetscReal)(p->newest - p->first) * ((end - p->newest_time) / cycles) - (PetscReal)(now - p->newest),
                  0);
}

/* ---- the set-up ---- */

/* Prints what the set-up does. On a terminal the next line overwrites it, so that a short set-up leaves no trace. */
PetscErrorCode SlipFaultProgressSetUp(SlipFault fault, const char what[])
{
  SlipFaultProgress *p = &fault->run->progress;
  const PetscBool terminal = IsTerminal();
  PetscMPIInt rank;
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (rank || !fault->options.progress) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  if (p->setup == 0) p->setup = now;
  if (terminal)
    PetscCall(
      PetscPrintf(PETSC_COMM_SELF, "\r" PROGRESS_CLEAR "set-up of %" PetscInt_FMT " cells: %s", fault->mesh.N, what));
  else if (now - p->setup >= PROGRESS_SETUP)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "set-up of %" PetscInt_FMT " cells, after %.1f s: %s\n", fault->mesh.N,
                          (double)(now - p->setup), what));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultProgressSetUpEnd(SlipFault fault)
{
  SlipFaultProgress *p = &fault->run->progress;
  PetscLogDouble now;

  PetscFunctionBegin;
  if (p->setup == 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (IsTerminal()) PetscCall(PetscPrintf(PETSC_COMM_SELF, "\r" PROGRESS_CLEAR));
  PetscCall(PetscTime(&now));
  if (now - p->setup >= PROGRESS_SETUP)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "set-up of %" PetscInt_FMT " cells took %.1f s\n", fault->mesh.N,
                          (double)(now - p->setup)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* On rank 0: prints the line. rate: the largest slip rate [m/s] */
static PetscErrorCode PrintLine(SlipFault fault, TS ts, PetscReal time, PetscReal rate, PetscLogDouble now)
{
  const SlipFaultProgress *p = &fault->run->progress;
  char at[64], end[64], left[64], events[64] = "", text[128] = "";
  PetscReal last, wait;
  PetscInt steps, rejected, attempts, accepted;
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCall(SlipClockRead(ts, NULL, &last));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(TSGetStepRejections(ts, &rejected));
  PetscCall(TSBatheIs(ts, &bathe));
  if (bathe) {
    PetscCall(TSBatheGetTotals(ts, &attempts, &accepted, NULL, NULL, NULL));
    rejected = attempts - accepted;
  }
  SlipTimeText(time, 4, at, sizeof(at));
  SlipTimeText(last, 4, end, sizeof(end));
  if (fault->run->events >= 0 && !p->repetition)
    (void)snprintf(events, sizeof(events), ", %lld event%s", (long long)fault->run->events,
                   fault->run->events == 1 ? "" : "s");
  wait = SlipFaultProgressLeft(p, fault->kind.driven, now, time, last);
  if (wait >= 0) {
    SlipTimeText(wait, 4, left, sizeof(left));
    (void)snprintf(text, sizeof(text), ", %s left", left);
  }
  PetscCall(PetscPrintf(PETSC_COMM_SELF,
                        "%stime %s of %s (%.1f %%), largest slip rate %.3g m/s, %" PetscInt_FMT " steps, %" PetscInt_FMT
                        " rejected%s%s\n",
                        p->repetition ? "check of the error: " : "", at, end, (double)(100 * time / last), (double)rate,
                        steps, rejected, events, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProgressCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  PetscFunctionBegin;
  (void)ts;
  *ctx = &fault->run->progress;
  *wanted = fault->options.progress;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProgressStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  SlipFaultProgress *p = (SlipFaultProgress *)ctx;
  PetscReal rate;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultStepRate(fault, time, w, &rate));
  PetscCall(PetscTime(&p->begin));
  p->printed = p->step = p->begin;
  p->start = fault->loads.origin + time;
  p->wait = p->onsets = 0;
  p->fast = PETSC_FALSE;
  p->repetition = fault->run->error.off;
  SlipFaultProgressSee(p, p->begin, p->start, rate, fault->options.value[FAULT_EVENT_RATE]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProgressStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFaultProgress *p = (SlipFaultProgress *)ctx;
  PetscMPIInt rank;
  PetscLogDouble now;
  PetscReal rate = 0;
  int word[2] = {0, 0};

  PetscFunctionBegin;
  (void)step;
  PetscCall(PetscTime(&now));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (p->wait-- <= 0) {
    PetscCall(SlipFaultStepRate(fault, time, w, &rate));
    SlipFaultProgressSee(p, now, fault->loads.origin + time, rate, fault->options.value[FAULT_EVENT_RATE]);
    if (!rank) { /* word[0]: whether a line is due, word[1]: the number of steps until the next decision */
      word[0] = SlipFaultProgressDue(IsTerminal(), (PetscReal)(now - p->begin), (PetscReal)(now - p->printed));
      word[1] = now > p->step ? (int)PetscMin(PROGRESS_AGREE / (now - p->step), PROGRESS_MAX_STEPS_BETWEEN)
                              : PROGRESS_MAX_STEPS_BETWEEN;
    }
    PetscCallMPI(MPI_Bcast(word, 2, MPI_INT, 0, fault->comm));
    p->wait = word[1];
  }
  p->step = now;
  if (!word[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (!rank) PetscCall(PrintLine(fault, ts, fault->loads.origin + time, rate, now));
  p->printed = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultProgressObserver = {
  .name = "progress", .create = ProgressCreate, .start = ProgressStart, .step = ProgressStep, .repeats = PETSC_TRUE};
