/* The loop of all trainings by CMA-ES: generations, validations in between, and what is done at the end. */
#pragma once
#include "cmaes.h"

/* What a training does, on every process; ctx is its own. */
typedef struct {
  PetscErrorCode (*draw)(void *ctx, Random *random); /* what the members of a generation run; NULL: always the same */
  CMAESFn cost;                                      /* of a member's runs */
  PetscErrorCode (*validate)(void *ctx);             /* the mean of now: score it, keep it, store it, say so */
  PetscErrorCode (*finish)(void *ctx);               /* after the last validation: calibrate, store */
} CMALoopOps;

typedef struct {
  MPI_Comm comm;
  PetscMPIInt rank, size;
  CMAES es;
  PetscInt generations, interval, diagonal; /* in all; between validations; with a diagonal covariance */
  PetscReal minutes;                        /* wall time after which it ends, 0: no limit */
  PetscBool start_counts;                   /* validate the start as well */
  uint64_t (*seed)(PetscInt seed, PetscInt stream, PetscInt64 k); /* of generation k's random numbers */
  PetscInt seeds, stream, first; /* the training's seed; its stream, and the number of the first generation */
  PetscReal best, median;        /* costs in the last generation; NaN before */
  PetscLogDouble begin;
  PetscReal before; /* wall time spent before it was resumed [s] */
} CMALoop;

/* From the first mean start [n]; the other members of loop are given. BLAS is set to one thread: more change the order
   of sums, and so bits, and the ranks have the cores already. */
PETSC_INTERN PetscErrorCode CMALoopCreate(MPI_Comm comm, PetscInt n, PetscInt population, const double start[],
                                          double sigma, CMALoop *loop);
PETSC_INTERN PetscErrorCode CMALoopDestroy(CMALoop *loop);
PETSC_INTERN PetscErrorCode CMALoopRun(CMALoop *loop, const CMALoopOps *ops, void *ctx);
PETSC_INTERN PetscErrorCode CMALoopElapsed(const CMALoop *loop, PetscReal *seconds); /* the same on every process */
