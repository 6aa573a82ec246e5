/* Operators compared by their products. */
#pragma once
#include <slipstep.h>
#include <slipcompat.h>

/* |A x - B x| / |B x| */
static inline PetscErrorCode ProductDistance(Mat A, Mat B, Vec x, PetscReal *distance)
{
  PetscReal norm;
  Vec a, b;

  PetscCall(VecDuplicate(x, &a));
  PetscCall(VecDuplicate(x, &b));
  PetscCall(MatMult(A, x, a));
  PetscCall(MatMult(B, x, b));
  PetscCall(VecNorm(b, NORM_2, &norm));
  PetscCall(VecAXPY(a, -1, b));
  PetscCall(VecNorm(a, NORM_2, distance));
  *distance /= norm;
  PetscCall(VecDestroy(&a));
  PetscCall(VecDestroy(&b));
  return PETSC_SUCCESS;
}
