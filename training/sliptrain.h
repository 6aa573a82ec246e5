/* Training of step-size policies for a problem of your own, by CMA-ES: the library sliptrain, which programs link
   beside slipstep. */
#pragma once
#include <petscts.h>
#include <stdint.h>

/* A family of runs to learn from: instances that are drawn at random, each with a TS of type bathe. No run may reach
   other processes: every process draws and runs instances of its own. */
typedef struct {
  const char *name; /* of the problem: what SlipProblemOps calls it, if anything; in the policy's attribute "problem" */
  /* The instance of a seed, the same on any process, with a TS on PETSC_COMM_SELF and the state [solution of ts], at
     the start and ready for TSSolve(). Both stay the instance's; the trainer takes ts back to this start before each
     run, and chooses the steps. Monitors that follow a run begin anew at step 0. */
  PetscErrorCode (*draw)(uint64_t seed, void **instance, TS *ts, Vec *w);
  PetscErrorCode (*error)(void *instance, TS ts, Vec w, PetscReal *error); /* of the run that has reached its end, >= 0,
                                                                              relative: what the dial is to bound */
  PetscErrorCode (*destroy)(void **instance);
  const char *const *observations; /* names in order, ending with NULL; log_accuracy, the dial, among them */
  PetscReal dt_min, dt_max;        /* bounds of the step [T*], T* = 1 s unless SlipProblemOps says what it is */
} SlipTrainProblem;

PETSC_EXTERN PetscErrorCode SlipTrain(MPI_Comm comm, const SlipTrainProblem *problem);
