/* -train_algorithm tolerances: the tolerance of every classical controller at which it keeps an accuracy, on drawn
   episodes of a problem or a user's family: the file of -fault_tolerances. */
#pragma once
#include <petscsys.h>

#define DIAL_CONTROLLERS "heuristic,pi,dsp,basic,pi:fault_history"
PETSC_INTERN PetscErrorCode TolerancesRun(MPI_Comm comm, PetscInt *failed);
