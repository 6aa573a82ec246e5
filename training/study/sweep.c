/* The sweep over alphas and seeds: many trainings as a queue that the ranks of a communicator work off. */
#include "trainer.h"
#include "common/queue.h"
#include <slipstep/rooms/sliph5.h>
#include <slipcompat.h>
#include <petsctime.h>
#include <stdio.h>

enum { NEXT, DONE, FAILED, COUNTERS }; /* of the queue */

static PetscErrorCode AddName(char file[], const char name[])
{
  char stem[PETSC_MAX_PATH_LEN], *dot;

  PetscFunctionBegin;
  if (!file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(stem, file, sizeof(stem)));
  dot = strrchr(stem, '.');
  if (dot && strcmp(dot, ".h5")) dot = NULL;
  if (dot) *dot = 0;
  PetscCall(PetscSNPrintf(file, PETSC_MAX_PATH_LEN, "%s%s%s", stem, name, dot ? ".h5" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The options of one training: its alpha and seed, and F.h5 becomes F_alpha2_seed1.h5. */
static PetscErrorCode SweepOptions(const TrainOptions *o, PetscInt job, TrainOptions *one)
{
  char name[64];

  PetscFunctionBegin;
  *one = *o;
  one->env.alpha = o->alphas[job % o->nalpha];
  one->seed = o->seeds[job / o->nalpha];
  /* not PetscSNPrintf(), which writes 2 as "2." */
  snprintf(name, sizeof(name), "_alpha%g_seed%" PetscInt_FMT, (double)one->env.alpha, one->seed);
  snprintf(one->label, sizeof(one->label), "alpha %g seed %" PetscInt_FMT ": ", (double)one->env.alpha, one->seed);
  PetscCall(AddName(one->output, name));
  PetscCall(AddName(one->log, name));
  PetscCall(AddName(one->resume, name));
  PetscCall(AddName(one->checkpoint, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One line for an error of a training, and back to the queue */
static PetscErrorCode SayError(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                               PetscErrorType type, const char *message, void *ctx)
{
  const TrainOptions *one = (const TrainOptions *)ctx;
  const char *general = NULL;

  (void)comm, (void)line, (void)function, (void)file;
  if (type == PETSC_ERROR_REPEAT) return code;
  if (!message || !message[0]) PetscErrorMessage(code, &general, NULL);
  fflush(stdout);
  fprintf(stderr, "train: error: %s%s\n", one->label,
          message && message[0] ? message : (general ? general : "unknown"));
  return code;
}

static PetscErrorCode SweepRun(MPI_Comm comm, const TrainOptions *o, PetscInt *failed)
{
  const PetscInt jobs = o->nalpha * o->nseed;
  PetscLogDouble begin, now;
  PetscInt job, done, bad;
  Queue q;

  PetscFunctionBegin;
  PetscCall(PetscTime(&begin));
  PetscCall(QueueCreate(comm, COUNTERS, &q));
  while (PETSC_TRUE) {
    TrainOptions one;
    PetscErrorCode code;

    PetscCall(QueueRaise(&q, NEXT, 1, &job));
    if (job >= jobs) break;
    PetscCall(SweepOptions(o, job, &one));
    PetscCall(PetscPushErrorHandler(SayError, &one));
    code = TrainerTrain(&one);
    PetscCall(PetscPopErrorHandler());
    if (code) SlipH5AbandonAll(); /* what it was writing; a curve keeps its rows */
    PetscCall(QueueRaise(&q, DONE, 1, &done));
    PetscCall(QueueRaise(&q, FAILED, code ? 1 : 0, &bad));
    done++;
    bad += code ? 1 : 0;
    PetscCall(PetscTime(&now));
    if (one.progress)
      PetscCall(PetscPrintf(
        PETSC_COMM_SELF,
        "%s%s; %" PetscInt_FMT " of %" PetscInt_FMT " trainings done, %" PetscInt_FMT " failed, about %.0f s left\n",
        one.label, code ? "failed" : "done", done, jobs, bad, (now - begin) / (double)done * (double)(jobs - done)));
  }
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(QueueRaise(&q, FAILED, 0, failed));
  PetscCall(QueueDestroy(&q));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SweepTrain(MPI_Comm comm, PetscInt *failed)
{
  EnvInstance instance;
  TrainOptions o;
  PetscBool only_help;
  PetscMPIInt rank;
  EnvRun run;

  PetscFunctionBegin;
  PetscCall(TrainOptionsSet(comm, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (only_help) {
    PetscCall(EnvInstanceCreate(&o.env, NULL, PETSC_FALSE, &instance)); /* the problem's and TS's options: a run's */
    PetscCall(o.env.problem->create(&o.env, &instance, &run));
    PetscCall(o.env.problem->destroy(&run));
  } else if (o.nalpha * o.nseed > 1) {
    PetscCall(SweepRun(comm, &o, failed));
  } else { /* the first rank trains and the others wait */
    if (!rank) PetscCall(TrainerTrain(&o));
    PetscCallMPI(MPI_Barrier(comm));
  }
  PetscCall(TrainOptionsFree(&o));
  PetscFunctionReturn(PETSC_SUCCESS);
}
