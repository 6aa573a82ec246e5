/* What sys offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipsys.h>

/* Arrays that the processes of a machine hold once, with their processes: shared.c */
typedef struct _SlipShared *SlipShared;

PETSC_EXTERN PetscErrorCode SlipCheckNumberOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                  const char option[], PetscBool whole, PetscBool *set,
                                                  PetscReal *value);
PETSC_EXTERN PetscErrorCode SlipCheckBoolOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                const char option[]);
/* Raises an error for integers that overflow PetscInt, which PETSc would read truncated. */
PETSC_EXTERN PetscErrorCode SlipCheckInteger(MPI_Comm comm, const char name[], const char text[]);
PETSC_EXTERN PetscErrorCode SlipCheckIntegerOption(MPI_Comm comm, PetscOptions options, const char prefix[],
                                                   const char option[]);
PETSC_EXTERN PetscErrorCode SlipCheckIntegers(MPI_Comm comm, PetscOptions options);
PETSC_EXTERN PetscErrorCode SlipCheckLinearOptions(MPI_Comm comm, PetscOptions options, const char prefix[]);
/* Prints one line on stderr, "program: warning: ...", from the process that calls it. */
PETSC_EXTERN PetscErrorCode SlipWarning(const char format[], ...);
PETSC_EXTERN PetscErrorCode SlipWarningsTake(char **text);
PETSC_EXTERN PetscErrorCode SlipSignalsCaught(int *number); /* 0: none */
