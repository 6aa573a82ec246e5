/* Many trainings, one for each alpha and seed, as a queue that the ranks of a communicator work off. */
#pragma once
#include "trainer.h"

/* All that the -train_ options say, or one training when they name one. Collective. A training of several that fails
   says why and does not stop the others; failed: how many did, on all ranks. */
PETSC_INTERN PetscErrorCode SweepTrain(MPI_Comm comm, PetscInt *failed);
