/* Decides when the state of a run is written, and when a run stops early. */
#pragma once
#include <slipstep/rooms/slipts.h>
#include <slipstep/private/slipstate.h>

/* Visits all data that a run needs from one step to the next, in both directions. */
typedef PetscErrorCode (*SlipCheckpointFn)(SlipState state, TS ts, void *ctx);

typedef struct {
  const char *file;        /* written every interval of wall time [s], and at the end; "": none */
  const char *option;      /* option that names it, for messages */
  PetscReal interval;      /* [s] */
  PetscReal wall_limit;    /* wall time of the program after which the run stops [s]; 0: none */
  const char *stop_file;   /* the run ends when this file appears; NULL or "": none */
  const char *stop_option; /* option that names it, with the dash */
  const char *restart;     /* option that continues a run, with the dash */
  SlipCheckpointFn visit;
  void *ctx;
} SlipCheckpointPlan;

/* Collective; called when a checkpoint is read, after SlipStateTS() and once the final time of ts is set. *left: a run
   that continues from it has a step to take; otherwise a message states the reason. It is an error if the checkpoint is
   after the final time. source: option and file, for messages */
PETSC_INTERN PetscErrorCode SlipCheckpointStepsLeft(SlipState state, TS ts, const char source[], PetscBool *left);
/* Collective; before TSSolve(). The plan's texts are copied, ts stores the rest. */
PETSC_INTERN PetscErrorCode SlipCheckpointStart(TS ts, const SlipCheckpointPlan *plan);
/* Collective; after TSSolve(): writes the last checkpoint, unless no step was taken. Raises an error if TSSolve() has
   failed by its steps, which it does not raise itself. code is the exit code of a run that was stopped, with a line on
   stderr that says how to continue; 0: it was not. Later steps of ts do not belong to the run. */
PETSC_INTERN PetscErrorCode SlipCheckpointFinish(TS ts, int *code);
