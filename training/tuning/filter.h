/* -train_algorithm filter: the parameters of a digital filter (TSADAPTPI), and how its rtol follows the accuracy wanted,
   by CMA-ES over runs of drawn episodes with the cost that policies are trained with. After Izgin and Ranocha (2023),
   arXiv:2312.01796: without such a controller nobody knows what of a policy's gain is that of tuning. */
#pragma once
#include "cmaes/cmaes.h"
#include "problems/episodes.h"

enum { FILTER_PARAMETERS = 7 };

typedef struct {
  PetscInt nsingle, nmesh, side; /* episodes of one cell, of meshes; cells along a side */
  PetscInt validation;           /* other episodes of each kind */
  PetscInt population, generations, interval, seed;
  PetscReal sigma, minutes;
  PetscReal low, high; /* range of the accuracy */
} FilterOptions;

/* rtol = factor accuracy^power */
typedef struct {
  SlipFilter filter;
  PetscReal factor, power;
} TunedFilter;

typedef struct {
  PetscReal cost, solves, within, error; /* means; share of runs within the accuracy; geometric mean of error over it */
} FilterScore;

PETSC_INTERN PetscErrorCode FilterOptionsSet(MPI_Comm comm, FilterOptions *o);
/* Collective; the same on any number of ranks. Prints its progress; score: of other episodes. */
PETSC_INTERN PetscErrorCode FilterTune(MPI_Comm comm, const FilterOptions *o, TunedFilter *best, FilterScore *score);
/* x [FILTER_PARAMETERS]: logarithms and the like, any number of which is a filter */
PETSC_INTERN void FilterOfNumbers(const double x[], TunedFilter *f);
PETSC_INTERN void FilterStart(double x[]);
