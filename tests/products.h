/* Operators compared by their products. */
#pragma once
#include "objects.h"

/* |A x - B x| / |B x| */
static inline PetscErrorCode ProductDistance(Mat A, Mat B, Vec x, PetscReal *distance)
{
  PetscReal norm;
  Vec a, b;

  PetscCall(DuplicateVecs(x, &a, &b));
  PetscCall(MatMult(A, x, a));
  PetscCall(MatMult(B, x, b));
  PetscCall(VecNorm(b, NORM_2, &norm));
  PetscCall(VecAXPY(a, -1, b));
  PetscCall(VecNorm(a, NORM_2, distance));
  *distance /= norm;
  return DestroyObjects(&a, &b);
}
