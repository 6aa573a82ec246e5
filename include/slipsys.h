/* Initialisation, registration and version of the SlipStep library. */
#pragma once
#include <petscts.h>
#include <slipcompat.h>

#define SLIPSTEP_VERSION_MAJOR 0
#define SLIPSTEP_VERSION_MINOR 2
#define SLIPSTEP_VERSION_PATCH 0
#define SLIPSTEP_VERSION                                                                                               \
  PetscStringize(SLIPSTEP_VERSION_MAJOR) "." PetscStringize(SLIPSTEP_VERSION_MINOR) "." PetscStringize(                \
    SLIPSTEP_VERSION_PATCH)

/* Of the library that a program runs with, which need not be the one whose headers it was compiled against. */
PETSC_EXTERN PetscErrorCode SlipStepGetVersion(char version[], size_t len);
PETSC_EXTERN PetscErrorCode SlipStepGetVersionNumber(PetscInt *major, PetscInt *minor, PetscInt *patch);

PETSC_EXTERN PetscErrorCode SlipStepInitializePackage(void);
/* Stages of -log_view: programs push those of set-up and run, the library that of output inside them. */
PETSC_EXTERN PetscLogStage SLIP_STAGE_SETUP, SLIP_STAGE_RUN, SLIP_STAGE_OUTPUT;

/* Entry point that PETSc calls for -dll_prepend libslipstep.so */
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_slipstep(void);

/* Programs: errors end with one line on stderr ("program: error: message") unless -slip_traceback is given. */
PETSC_EXTERN PetscErrorCode SlipErrorHandlerPush(const char program[]);
/* Before TSSetFromOptions(): what PETSc would refuse without naming the option. */
PETSC_EXTERN PetscErrorCode SlipCheckSolverOptions(TS ts);
PETSC_EXTERN PetscErrorCode SlipCheckNumberOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                  const char option[], PetscBool whole, PetscBool *set,
                                                  PetscReal *value);
/* A warning for each option that nothing has read: most often they are mistyped. */
PETSC_EXTERN PetscErrorCode SlipWarnOfUnusedOptions(void);
/* One line on stderr, "program: warning: ...", from the process that calls it. */
PETSC_EXTERN PetscErrorCode SlipWarning(const char format[], ...);
/* What rank 0 did alone failed there: fail on every rank. */
PETSC_EXTERN PetscErrorCode SlipErrorBcast(MPI_Comm comm, PetscErrorCode code);
/* Programs: SIGTERM, SIGINT, SIGUSR1 and SIGXCPU ask for the end of the run after the step in work, a second one ends it
   at once. */
PETSC_EXTERN PetscErrorCode SlipSignalsPush(void);
PETSC_EXTERN PetscErrorCode SlipSignalsPop(void);
PETSC_EXTERN PetscErrorCode SlipSignalsCaught(int *number); /* 0: none */
