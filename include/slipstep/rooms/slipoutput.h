/* What output offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipoutput.h>

/* For checkpoints. Sync writes all rows to the disk and counts them. Resume, before TSSolve(), continues the file of an
   earlier run, FILE.part or else FILE, truncated to these rows. Without a file both do nothing and return 0 rows. */
PETSC_EXTERN PetscErrorCode SlipOutputSync(SlipOutput output, PetscInt *steps, PetscInt *series);
PETSC_EXTERN PetscErrorCode SlipOutputResume(SlipOutput output, PetscInt steps, PetscInt series);
