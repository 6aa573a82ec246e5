/* -train_algorithm tolerances: the tolerance of every classical controller at which it keeps an accuracy, on drawn episodes of a
   problem: the table behind -fault_accuracy (src/fault/steps.c). */
#pragma once
#include <petscsys.h>

#define DIAL_CONTROLLERS "heuristic,pi,dsp,basic,pi:fault_history"
PETSC_INTERN PetscErrorCode TolerancesRun(MPI_Comm comm, PetscInt *failed);
