/* Networks of one hidden layer whose step is a ratio to the last one, with a tolerance that follows the dial: how problems set them up
   and where training starts. */
#pragma once
#include "cmaproblem.h"

/* An observation, scaled and shifted to order one; the row log_error_step has start 1 */
typedef struct {
  const char *name;
  double scale, offset, start;
} RatioRow;

/* Observations, their scaling, one layer of tanh units; the other numbers of o are the caller's */
PETSC_INTERN PetscErrorCode RatioSetUp(PetscInt rows, const RatioRow row[], PetscInt units, CMAOptions *o);
/* The elementary controller in one unit, weights of the others drawn that nothing reads; rtol: tolerance at the dial of the unit, in
   proportion to the dial */
PETSC_INTERN void RatioStart(const CMAOptions *o, const RatioRow row[], double rtol, double w[]);
