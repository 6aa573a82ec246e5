/* Random fields of faults that are drawn. */
#pragma once
#include "common/random.h"
#include <petscsys.h>

/* Of mean 0 and variance 1 over all draws: waves of random directions, whose lengths are from one to eight of the correlation's
   [cells]; field [nx nz] */
PETSC_INTERN void DrawnField(Random *random, PetscInt nx, PetscInt nz, double length, PetscReal field[]);
