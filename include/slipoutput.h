/* The output of a run, for any TS problem: an HDF5 file and the summary that is printed at its end. The attribute
   complete of the file is 1 when the run has ended:
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

/* Computes the columns at the start and after each accepted step, for the state w at time t; r is the reaction, NULL if
   the integrator has none. Collective; rank 0 writes its values. */
typedef PetscErrorCode (*SlipOutputRowFn)(TS ts, PetscReal t, Vec w, Vec r, PetscReal row[], void *ctx);

PETSC_EXTERN PetscErrorCode SlipOutputCreate(TS ts, const char file[], PetscInt n, const SlipOutputColumn column[],
                                             SlipOutputRowFn row, void *ctx, SlipOutput *output);
/* Sets the option that named the file, for messages, and whether rows of an unfinished FILE.part may be overwritten. */
PETSC_EXTERN PetscErrorCode SlipOutputSetOption(SlipOutput output, const char prefix[], const char option[],
                                                PetscBool overwrite);
/* Adds a table of observers or others that has one row for each row of /series. */
PETSC_EXTERN PetscErrorCode SlipOutputAddTable(SlipOutput output, const char group[], PetscInt n,
                                               const SlipOutputColumn column[], const PetscInt entries[],
                                               PetscInt *table);
PETSC_EXTERN PetscErrorCode SlipOutputAddRows(SlipOutput output, PetscInt table, PetscInt n, const PetscReal row[]);
PETSC_EXTERN PetscErrorCode SlipOutputAddAttribute(SlipOutput output, const char group[], const char name[],
                                                   PetscReal value);
/* Adds a number to the summary and to /result; with a NULL label it is omitted from the summary. */
PETSC_EXTERN PetscErrorCode SlipOutputAddResult(SlipOutput output, const char name[], const char label[],
                                                const char unit[], PetscReal value);
PETSC_EXTERN PetscErrorCode SlipOutputAddRun(SlipOutput output, const char name[], PetscReal value); /* for /run */
PETSC_EXTERN PetscErrorCode SlipOutputFinish(SlipOutput *output, PetscReal wall_setup, PetscReal wall_solve);
PETSC_EXTERN PetscErrorCode SlipOutputDestroy(SlipOutput *output); /* discards a run that did not finish */
