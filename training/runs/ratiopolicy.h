/* Networks of one hidden layer whose step is a ratio to the last one, with a tolerance that follows the dial: how
   problems set them up, where training starts, and the policy. A problem's row names its network and the functions
   here. */
#pragma once
#include "environment/cmaproblem.h"

struct _RatioNetwork {
  const CMAOptions *defaults; /* what RatioSetUp() does not set */
  PetscInt rows, units;
  const CMARow *row; /* the elementary controller has start 1 for log_error_step and 0 for all others */
  double bias;       /* log10 of the ratio at the start where all observations are 0 */
  PetscReal dial[2]; /* range of the training, and of the file */
  double unit, rtol; /* the tolerance at the start at this dial, */
  double power;      /* and the power of the dial with which it grows */
};
#define RATIO_SAFETY (-0.046) /* bias of the elementary controller: log10 of its safety factor */

/* The defaults, observations and their scaling, one layer of tanh units, the range of the dial, and what all these
   problems have */
PETSC_INTERN PetscErrorCode RatioSetUp(CMAOptions *o);
/* The digital filter of the rows' starts in one unit, and weights of the others drawn that nothing reads */
PETSC_INTERN void RatioStart(const CMAOptions *o, double w[]);
/* The numbers that are trained after the weights: those of the tolerance are the first two */
PETSC_INTERN PetscInt RatioNumbers(const CMAOptions *o);
PETSC_INTERN PetscErrorCode RatioPolicy(const CMAOptions *o, const double w[], SlipPolicy policy);
PETSC_INTERN void RatioRange(const CMAOptions *o, PetscReal low[], PetscReal high[]);
/* The functions of a problem's row that do nothing else */
#define RATIO_FUNCTIONS .setup = RatioSetUp, .start = RatioStart, .policy = RatioPolicy, .range = RatioRange
