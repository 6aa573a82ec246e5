/* -train_algorithm steps: the best steps of one fault, open loop: what can be had at all with so many of them. */
#pragma once
#include <petscsys.h>

PETSC_INTERN PetscErrorCode StepsRun(MPI_Comm comm, PetscInt *failed); /* as its options say; failed: nothing */
