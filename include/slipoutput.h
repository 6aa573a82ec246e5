/* What a run leaves behind, for any TS problem: an HDF5 file and the summary that is printed at its end. The file,
   whose attribute complete is 1 when the run has ended:
     /run      attributes: options, versions, ranks, policy and its hash, wall time, restarts
     /steps    a row per attempt: time (start), dt, accepted, error, converged, iterations, right-hand sides, reason,
     wall
     /series   a row for the start and per accepted step: time and the problem's columns
     /result   attributes: the problem's results, accepted, rejected, solves, iterations, wall times */
#pragma once
#include <petscts.h>

/* The output of one run. */
typedef struct _n_SlipOutput *SlipOutput;

/* One dataset of /series; the strings are borrowed until SlipOutputFinish(). */
typedef struct {
  const char *name;
  const char *unit;  /* SI; "1" for a pure number, NULL for a count */
  PetscBool integer; /* stored as 64-bit integers */
} SlipOutputColumn;

/* Values of the columns at the start, or after an accepted step that ended, at time t with state w; r is the reaction,
   NULL when the integrator has none. Collective; what rank 0 fills in is written. */
typedef PetscErrorCode (*SlipOutputRowFn)(TS ts, PetscReal t, Vec w, Vec r, PetscReal row[], void *ctx);

PETSC_EXTERN PetscErrorCode SlipOutputCreate(TS ts, const char file[], PetscInt n, const SlipOutputColumn column[],
                                             SlipOutputRowFn row, void *ctx, SlipOutput *output);
/* The option that named the file, for messages, and whether rows of an unfinished FILE.part may go */
PETSC_EXTERN PetscErrorCode SlipOutputSetOption(SlipOutput output, const char prefix[], const char option[],
                                                PetscBool overwrite);
/* Further tables, with a row for each row of /series, of observers and the like */
PETSC_EXTERN PetscErrorCode SlipOutputAddTable(SlipOutput output, const char group[], PetscInt n,
                                               const SlipOutputColumn column[], const PetscInt entries[],
                                               PetscInt *table);
PETSC_EXTERN PetscErrorCode SlipOutputAddRows(SlipOutput output, PetscInt table, PetscInt n, const PetscReal row[]);
PETSC_EXTERN PetscErrorCode SlipOutputAddAttribute(SlipOutput output, const char group[], const char name[],
                                                   PetscReal value);
/* For checkpoints. Sync: bring all rows to the disk, and count them. Resume, before TSSolve(): go on in the file of an
   earlier run, FILE.part or else FILE, cut to these rows. Both do nothing, with 0 rows, where there is no file. */
PETSC_EXTERN PetscErrorCode SlipOutputSync(SlipOutput output, PetscInt *steps, PetscInt *series);
PETSC_EXTERN PetscErrorCode SlipOutputResume(SlipOutput output, PetscInt steps, PetscInt series);
/* A number for the summary and for /result; label NULL keeps it out of the summary. */
PETSC_EXTERN PetscErrorCode SlipOutputAddResult(SlipOutput output, const char name[], const char label[],
                                                const char unit[], PetscReal value);
PETSC_EXTERN PetscErrorCode SlipOutputAddRun(SlipOutput output, const char name[], PetscReal value); /* for /run */
PETSC_EXTERN PetscErrorCode SlipOutputFinish(SlipOutput *output, PetscReal wall_setup, PetscReal wall_solve);
PETSC_EXTERN PetscErrorCode SlipOutputDestroy(SlipOutput *output); /* gives up a run that did not finish */
