/* -train_algorithm cmaes: the weights of a small network, by CMA-ES over runs of drawn episodes of any problem that has
   a row for it (environment/cmaproblem.h). */
#pragma once
#include "cmaes.h"
#include "problems/problems.h"
#include <slipstep/rooms/sliph5.h>

/* Single cells first, where there are two kinds. */
typedef struct {
  PetscInt n, nsingle;
  void **episode; /* [n] */
} CMASet;

/* What the members of a generation run, all the same */
typedef struct {
  PetscInt n, singles, *episode; /* single cells first */
  PetscReal *dial;
} CMABatch;

typedef struct {
  CMAOptions o;
  const CMAProblem *cma; /* of o.problem */
  MPI_Comm comm;
  PetscMPIInt rank, size;
  CMAES es;
  CMASet train, valid;
  CMABatch batch;
  PetscInt64 evaluations;
  PetscReal least, median; /* costs in the last generation; NaN before */
  double *best;            /* [n] mean with the best validation */
  CMAScore score;          /* of it */
  PetscInt64 best_generation;
  PetscLogDouble begin; /* wall time at the start, */
  PetscReal before;     /* and that spent before the training was resumed [s] */
  PetscReal reference,
    calibration; /* wall time of an episode's reference, and of the calibration if the dial moves far; 0: not known */
  PetscReal shift[2]; /* decades by which the policy sees the dial moved, in the middle of its range, and per decade */
  PetscReal obs_min[CMA_MAX_OBS], obs_max[CMA_MAX_OBS];
  SlipH5 *log; /* NULL: none */
} CMATrainer;

/* problem: a user's; NULL: that of -train_problem */
PETSC_INTERN PetscErrorCode CMAOptionsSet(MPI_Comm comm, const Problem *problem, CMAOptions *o);
PETSC_INTERN PetscErrorCode CMAOptionsFree(CMAOptions *o);
/* All of it, by the options */
PETSC_INTERN PetscErrorCode CMATrain(MPI_Comm comm, const Problem *problem);
/* o: its names and family become the trainer's. BLAS is set to one thread: more change the order of sums, and so bits,
   and the ranks have the cores already. */
PETSC_INTERN PetscErrorCode CMATrainerCreate(MPI_Comm comm, const CMAOptions *o, CMATrainer *t);
PETSC_INTERN PetscErrorCode CMATrainerRun(CMATrainer *t); /* to the end; writes policy, log and checkpoint */
PETSC_INTERN PetscErrorCode CMATrainerDestroy(CMATrainer *t);

/* ---- files (cmafiles.c, cmaread.c), by the first rank ---- */
PETSC_INTERN PetscErrorCode CMAStorePolicy(CMATrainer *t, PetscBool unfinished);
PETSC_INTERN PetscErrorCode CMACheckpointWrite(CMATrainer *t);
PETSC_INTERN PetscErrorCode CMACheckpointRead(CMATrainer *t); /* on every rank */
/* The policy of o.calibrate as the best one, and the shift of its dial; on every rank */
PETSC_INTERN PetscErrorCode CMAPolicyRead(CMATrainer *t);
PETSC_INTERN PetscErrorCode CMAStartRead(const CMAOptions *o, double w[]); /* -train_start */
PETSC_INTERN PetscErrorCode CMALogOpen(CMATrainer *t);
PETSC_INTERN PetscErrorCode CMALogRow(CMATrainer *t, const CMAScore *score);
