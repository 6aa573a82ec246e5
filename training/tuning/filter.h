/* -train_algorithm filter: the parameters of a digital filter (TSADAPTPI), and how its rtol follows the accuracy
   wanted, by CMA-ES over runs of drawn episodes with the cost that policies are trained with. After Izgin and Ranocha
   (2023), arXiv:2312.01796: without such a controller nobody knows what of a policy's gain is that of tuning. */
#pragma once
#include <slipcore.h>

enum { FILTER_PARAMETERS = 7 };

/* rtol = factor accuracy^power */
typedef struct {
  SlipFilter filter;
  PetscReal factor, power;
} TunedFilter;

/* The whole, as its options say. Collective; the same on any number of ranks. Prints its progress and what it found.
   failed: nothing */
PETSC_INTERN PetscErrorCode FilterTune(MPI_Comm comm, PetscInt *failed);
/* x [FILTER_PARAMETERS]: logarithms and the like, any number of which is a filter */
PETSC_INTERN void FilterOfNumbers(const double x[], TunedFilter *f);
PETSC_INTERN void FilterStart(double x[]);
