/* When the state of a run is written, and when a run stops before its end. */
#pragma once
#include <slipts.h>
#include <slipstep/private/slipstate.h>

/* All that a run remembers between two steps, in both directions. */
typedef PetscErrorCode (*SlipCheckpointFn)(SlipState state, TS ts, void *ctx);

typedef struct {
  const char *file;        /* written every interval of wall time [s], and at the end; "": none */
  const char *option;      /* that names it, for messages */
  PetscReal interval;      /* [s] */
  PetscReal wall_limit;    /* wall time of the program after which the run stops [s]; 0: none */
  const char *stop_file;   /* that ends the run when it appears; NULL or "": none */
  const char *stop_option; /* that names it, with the dash */
  const char *restart;     /* option that continues a run, with the dash */
  SlipCheckpointFn visit;
  void *ctx;
} SlipCheckpointPlan;

/* Collective; from the visit of a checkpoint that is read, after SlipStateTS(), the final time of ts being known:
   *left, whether a run that goes on from it has a step to take; a line says why not. An error where the checkpoint is
   after the final time. source: option and file, for messages */
PETSC_INTERN PetscErrorCode SlipCheckpointStepsLeft(SlipState state, TS ts, const char source[], PetscBool *left);
/* Collective; before TSSolve(). The plan's texts are copied, ts keeps the rest. */
PETSC_INTERN PetscErrorCode SlipCheckpointStart(TS ts, const SlipCheckpointPlan *plan);
/* Collective; after TSSolve(): the last checkpoint, unless no step was taken. An error where TSSolve() has failed by
   its steps, which it does not raise itself. The exit code of a run that was stopped, and a line on stderr that says
   how to go on; 0: it was not. What ts does from now on is no run to go on with. */
PETSC_INTERN PetscErrorCode SlipCheckpointFinish(TS ts, int *code);
