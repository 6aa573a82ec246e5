/* The matrix of runs that evaluate makes: problems, cells, results and the file that holds them. Public headers of the
   library, and its HDF5 helpers. */
#pragma once
#include "common/table.h"
#include "problems/problems.h"
#include <slipstep/rooms/sliph5.h>

#define EVALUATE_NAME PROBLEM_CASE_NAME
#define EVALUATE_COLUMNS 8   /* of a problem's series, time included */
#define EVALUATE_ATTEMPT 5   /* columns of a cell's attempts: time, dt, accepted, error, converged */
#define EVALUATE_PROFILES 96 /* depth profiles kept of a run */

/* ---- options and cells (evaluateoptions.c) ---- */

#define EVALUATE_MAX 64 /* entries of a list option */

typedef struct {
  char file[PETSC_MAX_PATH_LEN], name[EVALUATE_NAME];
  char problem[32];   /* it was trained for; empty: not said */
  char algorithm[32]; /* empty: not said */
  char hash[72];
  PetscReal alpha; /* NaN: not said */
  PetscBool dial;  /* observes the accuracy that is wanted */
} EvaluatePolicy;

typedef struct {
  char output[PETSC_MAX_PATH_LEN];
  PetscInt nproblems, nsizes, nmeshes, ncontrollers, nerrors, nreactions, ntolerances, nsteps, naccuracies, npolicies;
  const Problem *problems[EVALUATE_MAX];
  PetscReal sizes[EVALUATE_MAX];
  PetscInt meshes[EVALUATE_MAX];
  const char *controllers[EVALUATE_MAX];
  PetscInt errors[EVALUATE_MAX], reactions[EVALUATE_MAX]; /* TSBatheError, TSBatheReactionType */
  PetscReal tolerances[EVALUATE_MAX];                     /* factors of the problem's own */
  PetscInt steps[EVALUATE_MAX];                           /* constant steps of "none" */
  PetscReal accuracies[EVALUATE_MAX]; /* wanted of policies that observe it, besides the controller's default */
  EvaluatePolicy *policies;
  PetscInt repetitions, max_attempts, spread, reference_steps;
  PetscInt coarser; /* references have this many times fewer steps than the problems ask for */
  PetscReal time_limit;
  PetscBool list, repeat_failed;
  char *settings; /* all options but those of evaluate itself: cells of one file share them */
} EvaluateOptions;
PETSC_INTERN PetscErrorCode EvaluateOptionsSet(EvaluateOptions *o);
typedef struct {
  PetscInt instance; /* index of its case */
  const char *controller;
  const EvaluatePolicy *policy; /* of "rl", else NULL */
  TSBatheError error;
  TSBatheReactionType reaction;
  PetscReal tolerance;               /* factor */
  PetscReal accuracy;                /* wanted of a policy, 0: the controller's default */
  PetscInt steps;                    /* of "none", else 0 */
  char path[2 * EVALUATE_NAME + 16]; /* group in the file */
  PetscReal weight;                  /* guess of its cost, for the time left */
} EvaluateCell;

typedef struct {
  PetscInt ncases, ncells;
  ProblemCase *cases;
  EvaluateCell *cells;
} EvaluateMatrix;

/* ---- runs and their errors (evaluaterun.c) ---- */

typedef struct {
  PetscInt steps;                 /* of the stored run, 0: exact */
  PetscReal self_final, self_max; /* difference to the run of half as many steps, as error_final and error_max */
  PetscReal wall;
  Table series, profile; /* time and columns; time and profile */
} EvaluateReference;

typedef struct {
  PetscBool converged;
  char reason[512]; /* of a failure */
  PetscInt attempts, accepted, solves, newton, linear, failures, guarded;
  SlipProducts products;
  PetscReal final, final_error, max_error, l2_error, rate_error; /* NaN where unknown */
  PetscInt runs;
  PetscReal wall, wall_min, wall_max, wall_setup; /* median over the runs, and their range [s] */
  PetscReal cpu;                                  /* least processor time of a run, all its processes together [s] */
  Table series, steps, profile;
} EvaluateResult;
PETSC_INTERN PetscErrorCode EvaluateRunCell(const EvaluateOptions *o, MPI_Comm comm, const ProblemCase *c, void *model,
                                            const EvaluateCell *cell, const EvaluateReference *ref, EvaluateResult *r);
PETSC_INTERN PetscErrorCode EvaluateRunReference(const EvaluateOptions *o, MPI_Comm comm, const ProblemCase *c,
                                                 void *model, EvaluateReference *ref);
PETSC_INTERN PetscInt EvaluateReferenceSteps(const EvaluateOptions *o, const ProblemCase *c);
PETSC_INTERN PetscErrorCode EvaluateResultClear(EvaluateResult *r);
PETSC_INTERN PetscErrorCode EvaluateReferenceClear(EvaluateReference *r);
/* Errors of a series against a reference's, by numbers alone. exact: NULL, or the solution at any time. */
PETSC_INTERN PetscErrorCode EvaluateErrors(const Evaluation *p, void *model, const Table *ref, const Table *series,
                                           EvaluateResult *r);

/* ---- the file (evaluatefile.c): every write replaces it by a copy with one group more ---- */

PETSC_INTERN PetscErrorCode EvaluateFileCheck(const EvaluateOptions *o); /* rank 0: its format and settings */
/* Of a cell: it is there, failed, or was made with another file of its policy's name and counts for nothing */
typedef struct {
  PetscBool known, failed, outdated;
} EvaluateState;
/* Rank 0: which references are there, and the states of the cells */
PETSC_INTERN PetscErrorCode EvaluateFileKnown(const EvaluateOptions *o, const EvaluateMatrix *m, PetscBool reference[],
                                              EvaluateState cell[]);
PETSC_INTERN PetscErrorCode EvaluateFileReadReference(const EvaluateOptions *o, const ProblemCase *c,
                                                      EvaluateReference *ref);
PETSC_INTERN PetscErrorCode EvaluateFileWriteReference(const EvaluateOptions *o, const ProblemCase *c,
                                                       EvaluateReference *ref);
PETSC_INTERN PetscErrorCode EvaluateFileWriteCell(const EvaluateOptions *o, const ProblemCase *c,
                                                  const EvaluateCell *cell, EvaluateResult *r);

/* ---- the work (evaluatework.c) ---- */

PETSC_INTERN PetscErrorCode EvaluateWork(EvaluateOptions *o);
