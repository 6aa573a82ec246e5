/*
  Products with a linear operator that are known already: directions q_j, orthonormal, and their images f(q_j), each with
  the error it was computed to. Solvers ask for products with vectors that differ less and less; of each, only the part
  that no earlier direction covers has to be computed, and to an absolute error only.
*/
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipcells.h>

PetscErrorCode SlipRecallReset(SlipRecall *r)
{
  PetscFunctionBegin;
  r->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipRecallDestroy(SlipRecall *r)
{
  PetscFunctionBegin;
  for (PetscInt j = 0; j < SLIP_RECALL_MAX; j++) {
    PetscCall(VecDestroy(&r->q[j]));
    PetscCall(VecDestroy(&r->image[j]));
  }
  r->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes a direction; its vectors go to the end, to be used again. */
static void Forget(SlipRecall *r, PetscInt k)
{
  const Vec q = r->q[k], image = r->image[k];

  for (PetscInt j = k; j + 1 < r->n; j++) {
    r->q[j] = r->q[j + 1];
    r->image[j] = r->image[j + 1];
    r->error[j] = r->error[j + 1];
  }
  r->n--;
  r->q[r->n] = q;
  r->image[r->n] = image;
}

/* Least accurate contributions first: those that would exceed the error allowed together are forgotten. */
static void KeepAccurate(SlipRecall *r, PetscReal c[], PetscReal allowed)
{
  for (;;) {
    PetscReal sum = 0;
    PetscInt worst = 0;

    for (PetscInt j = 0; j < r->n; j++) {
      sum += PetscAbsReal(c[j]) * r->error[j];
      if (PetscAbsReal(c[j]) * r->error[j] > PetscAbsReal(c[worst]) * r->error[worst]) worst = j;
    }
    if (sum <= allowed) return;
    Forget(r, worst);
    for (PetscInt j = worst; j < r->n; j++) c[j] = c[j + 1];
  }
}

/* y = f of the part of x that is covered to the relative error tolerance; x := the rest; *size is the norm of f(x) as far
   as it is known. */
PetscErrorCode SlipRecallSplit(SlipRecall *r, PetscReal tolerance, Vec x, Vec y, PetscReal *size)
{
  PetscReal c[SLIP_RECALL_MAX], again[SLIP_RECALL_MAX];

  PetscFunctionBegin;
  *size = 0;
  PetscCall(VecZeroEntries(y));
  if (!r->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecMDot(x, r->n, r->q, c));
  PetscCall(VecMAXPY(y, r->n, c, r->image));
  PetscCall(VecNorm(y, NORM_2, size));
  KeepAccurate(r, c, tolerance * *size);
  PetscCall(VecZeroEntries(y));
  if (!r->n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt j = 0; j < r->n; j++) c[j] = -c[j];
  PetscCall(VecMAXPY(x, r->n, c, r->q));
  PetscCall(VecMDot(x, r->n, r->q, again)); /* orthogonal to rounding, however small the rest is */
  for (PetscInt j = 0; j < r->n; j++) again[j] = -again[j];
  PetscCall(VecMAXPY(x, r->n, again, r->q));
  for (PetscInt j = 0; j < r->n; j++) c[j] = -(c[j] + again[j]);
  PetscCall(VecMAXPY(y, r->n, c, r->image));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A direction of norm 1, orthogonal to those kept, and its image to an absolute error; the oldest one makes room. */
PetscErrorCode SlipRecallAdd(SlipRecall *r, Vec q, Vec image, PetscReal error)
{
  PetscFunctionBegin;
  if (r->n == SLIP_RECALL_MAX) Forget(r, 0);
  if (!r->q[r->n]) {
    PetscCall(VecDuplicate(q, &r->q[r->n]));
    PetscCall(VecDuplicate(q, &r->image[r->n]));
  }
  PetscCall(VecCopy(q, r->q[r->n]));
  PetscCall(VecCopy(image, r->image[r->n]));
  r->error[r->n++] = error;
  PetscFunctionReturn(PETSC_SUCCESS);
}
