/* Runs of the library itself under a policy that is being trained, or under a classical controller. */
#pragma once
#include <slipstep.h>

/* The policy with its dial at accuracy, whatever it is worth; without one a controller of this type with the relative tolerance rtol */
PETSC_INTERN PetscErrorCode RunSetController(TS ts, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                             PetscReal rtol);
/* A controller may drive a run anywhere: an error of the library's is a run that was not solved. */
PETSC_INTERN PetscErrorCode RunSolve(TS ts, Vec w, PetscBool *solved);

/* What a run is to do: under the policy with its dial at the setting, or under a controller of the type with the tolerance setting */
typedef struct {
  SlipPolicy policy;
  TSAdaptType type;
  PetscReal setting;
  Vec start;             /* NULL: the fault's initial state at time 0, and its own first step */
  PetscReal begin, step; /* [s] */
  PetscReal end;         /* [s] */
  PetscInt most;         /* accepted steps */
  /* At the start and after every step; it may end the run by TS_CONVERGED_USER. */
  PetscErrorCode (*follow)(TS, PetscInt, PetscReal, Vec, void *);
  void *ctx;
  PetscOptions options; /* of the TS in place of the program's; NULL: the program's */
} FaultRun;
/* ended: it came to its end, or to where follow ended it; rejected: attempts */
PETSC_INTERN PetscErrorCode RunFault(SlipFault fault, FaultRun *run, PetscInt *solves, PetscInt *rejected,
                                     PetscBool *ended);
/* Root mean square difference of the cells' slips, relative */
PETSC_INTERN PetscReal RunFieldError(PetscInt n, const PetscReal slip[], const PetscReal reference[]);
