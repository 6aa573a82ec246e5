/* Many trainings, one for each alpha and seed, as a queue that the ranks of a communicator work off. */
#pragma once
#include "trainer.h"

PETSC_INTERN PetscInt SweepCount(const TrainOptions *o);
/* Collective. A training that fails says why and does not stop the others; failed: how many did, on all ranks. */
PETSC_INTERN PetscErrorCode SweepRun(MPI_Comm comm, const TrainOptions *o, PetscInt *failed);
