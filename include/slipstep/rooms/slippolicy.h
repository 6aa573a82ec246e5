/* What policy offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slippolicy.h>

PETSC_EXTERN PetscErrorCode SlipPolicyInitializePackage(void); /* creation routines call it; later calls do nothing */
PETSC_EXTERN PetscErrorCode SlipPolicyReference(SlipPolicy policy);
PETSC_EXTERN PetscErrorCode SlipPolicyGetNumber(SlipPolicy p, const char name[], PetscReal *value, PetscBool *has);
/* of the training; NULL: unknown */
PETSC_EXTERN PetscErrorCode SlipPolicyGetRange(SlipPolicy p, const PetscReal *min[], const PetscReal *max[]);
PETSC_EXTERN PetscErrorCode SlipPolicyIsRelative(SlipPolicy p, PetscBool *relative); /* unit "h" */
/* Hexadecimal hash of the file's content, which identifies the policy in outputs */
PETSC_EXTERN PetscErrorCode SlipPolicyGetHash(SlipPolicy p, const char *hash[]);
PETSC_EXTERN PetscErrorCode SlipPolicyGetFile(SlipPolicy p, const char *file[]);
