/* -train_algorithm steps: the best steps of one fault, open loop: what can be had at all with so many of them. */
#pragma once
#include "cmaes/cmaes.h"
#include "problems/episodes.h"

typedef struct {
  PetscInt least, most; /* solves, the one to the end included */
  PetscInt generations, restarts, population, seed;
  char output[PETSC_MAX_PATH_LEN];
} StepsOptions;

/* What was found for one number of solves. */
typedef struct {
  PetscInt n;       /* steps besides the one to the end */
  PetscReal error;  /* by the measure of the episode */
  double *log_step; /* [n] ln(step/s) */
} StepsPlan;

PETSC_INTERN PetscErrorCode StepsOptionsSet(MPI_Comm comm, StepsOptions *o);
/* The best of some searches, started from the plan for one step less (NULL: none) and from steps drawn about equal ones;
   ranks share the searches, and all get the answer, the same on any number of them. plan->log_step is the caller's. */
PETSC_INTERN PetscErrorCode StepsSearch(MPI_Comm comm, const StepsOptions *o, Episode *e, const StepsPlan *fewer,
                                        StepsPlan *plan);
/* The whole, as its options say */
PETSC_INTERN PetscErrorCode StepsRun(MPI_Comm comm);
