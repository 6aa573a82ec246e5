/* What the files of all trainings share: numbers in a policy, and checks of a checkpoint that is resumed. */
#pragma once
#include <slipstep.h>
#include <sliph5.h>

/* Of -train_output, -train_log and -train_checkpoint, which may be empty: three files, not fewer. */
PETSC_INTERN PetscErrorCode TrainCheckFiles(MPI_Comm comm, const char output[], const char log[],
                                            const char checkpoint[]);

PETSC_INTERN PetscErrorCode PolicySetNumber(SlipPolicy p, const char name[], const char format[], double value);

/* One process. kind: of checkpoint, for the message, "" or " of ..." */
PETSC_INTERN PetscErrorCode CheckpointCheckFormat(SlipH5 *h, const char format[], const char kind[]);
PETSC_INTERN PetscErrorCode CheckpointCheckObservations(SlipH5 *h, PetscInt n, char *const names[]);
PETSC_INTERN PetscErrorCode CheckpointReadFixed(SlipH5 *h, const char path[], PetscInt n, PetscReal **data);
