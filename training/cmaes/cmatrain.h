/* -train_algorithm cmaes: the weights of a small network with an accuracy dial, by CMA-ES over runs of drawn
   episodes. */
#pragma once
#include "cmaes.h"
#include "problems/episodes.h"

enum {
  CMA_MAX_OBS = 24,
  CMA_MAX_LAYERS = 4,
  VALID_DIALS = 3, /* each validation episode runs at so many positions of the dial */
  CMA_KINDS = 2    /* single cells and meshes; other problems have the first only */
};

typedef struct {
  PetscInt nobs;
  char *names[CMA_MAX_OBS];
  PetscReal scale[CMA_MAX_OBS], offset[CMA_MAX_OBS]; /* the network sees obs * scale + offset */
  PetscInt hidden, layers;                           /* width and number of the hidden layers, tanh */
  const SlipTrainProblem *user;                      /* a user's problem; NULL: the next one */
  const Problem *problem;                            /* a small model, or drawn faults */
  PetscBool small;                                   /* no faults: episodes are of one kind */
  Family family;                                     /* of these; empty: the trainer's own draws */
  PetscReal dt_min, dt_max;                          /* bounds of the action, logarithmic spacing */
  PetscReal moving;                                  /* longest step while anything moves [T*], 0: no limit */
  char dt_max_unit[8];                               /* "T*" or "t_max"; dt_min is in T* */
  PetscInt nsingle, nmesh, side;                     /* episodes of one cell, of meshes; cells along a side */
  PetscInt batch_single, batch_mesh;                 /* of a generation */
  PetscInt late_generations, late_single, late_mesh; /* at the end, and the episodes of one of these */
  PetscInt validation, calibration;                  /* episodes of each kind */
  PetscInt population;                               /* 0: CMA-ES's default */
  PetscInt diagonal;                                 /* generations with a diagonal covariance */
  PetscReal sigma;
  PetscInt generations;
  PetscReal minutes; /* wall time after which training ends */
  PetscInt interval; /* generations between validations */
  PetscInt seed;
  PetscReal low, high; /* range of the dial */
  PetscReal within;    /* share of either kind's runs that shall keep the dial everywhere in its range, 0: as trained */
  char output[PETSC_MAX_PATH_LEN], log[PETSC_MAX_PATH_LEN], checkpoint[PETSC_MAX_PATH_LEN], resume[PETSC_MAX_PATH_LEN];
} CMAOptions;

/* Means over a validation. */
typedef struct {
  PetscReal cost, solves, within; /* share of the runs within the dial */
  PetscReal error;                /* geometric mean of error over dial */
  PetscReal kept[CMA_KINDS]
                [VALID_DIALS]; /* within, of either kind in each third of the dial's range, the finest first */
} CMAScore;

/* Single cells first. */
typedef struct {
  PetscInt n, nsingle;
  Episode **episode; /* [n] */
} CMASet;

typedef struct {
  CMAOptions o;
  MPI_Comm comm;
  PetscMPIInt rank, size;
  CMAES es;
  CMASet train, valid;
  PetscInt64 generation, evaluations;
  double *best;   /* [n] mean with the best validation */
  CMAScore score; /* of it */
  PetscInt64 best_generation;
  PetscReal shift[2]; /* decades by which the policy sees the dial moved, in the middle of its range, and per decade */
  PetscReal obs_min[CMA_MAX_OBS], obs_max[CMA_MAX_OBS];
  PetscLogDouble begin;
  PetscReal before; /* wall time spent before -train_resume [s] */
  struct _CMALog *log;
} CMATrainer;

/* user: NULL for -train_problem */
PETSC_INTERN PetscErrorCode CMAOptionsSet(MPI_Comm comm, const SlipTrainProblem *user, CMAOptions *o);
/* All of it, by the options */
PETSC_INTERN PetscErrorCode CMATrain(MPI_Comm comm, const SlipTrainProblem *user);
PETSC_INTERN PetscErrorCode CMATrainerCreate(MPI_Comm comm, const CMAOptions *o, CMATrainer *t);
PETSC_INTERN PetscErrorCode CMATrainerRun(CMATrainer *t); /* to the end; writes policy, log and checkpoint */
PETSC_INTERN PetscErrorCode CMATrainerDestroy(CMATrainer *t);

/* ---- the network (cmapolicy.c) ---- */
PETSC_INTERN PetscInt CMACountWeights(const CMAOptions *o);
PETSC_INTERN void CMAStart(const CMAOptions *o, double weights[]); /* the first mean */
/* shift: decades by which the dial is moved before the network sees it, in the middle of its range, and per decade */
PETSC_INTERN PetscErrorCode CMAPolicy(const CMAOptions *o, const double weights[], const PetscReal shift[2],
                                      SlipPolicy *policy);

/* ---- how good a policy is (cmavalid.c), on every rank ---- */

/* Runs of a set's episodes; the policy sees the dial moved by shift, as CMAPolicy() says. */
PETSC_INTERN PetscErrorCode CMAValidate(CMATrainer *t, const CMASet *set, const double weights[],
                                        const PetscReal shift[2], CMAScore *score);
/* Finds t->shift for t->best; t->score becomes that of the set. */
PETSC_INTERN PetscErrorCode CMACalibrate(CMATrainer *t, const CMASet *set);

/* ---- files (cmafiles.c), by the first rank ---- */
PETSC_INTERN PetscErrorCode CMAStorePolicy(CMATrainer *t);
PETSC_INTERN PetscErrorCode CMACheckpointWrite(CMATrainer *t);
PETSC_INTERN PetscErrorCode CMACheckpointRead(CMATrainer *t); /* on every rank */
PETSC_INTERN PetscErrorCode CMALogOpen(CMATrainer *t);
PETSC_INTERN PetscErrorCode CMALogRow(CMATrainer *t, PetscReal best, PetscReal median, const CMAScore *score);
PETSC_INTERN PetscErrorCode CMALogClose(CMATrainer *t);
