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

/* Forgets the least accurate contributions until the others keep to the error allowed together. */
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

/* Makes room: one direction, x's part along all of them, takes their place; y is its image. */
static PetscErrorCode Collapse(SlipRecall *r, const PetscReal c[], Vec y)
{
  PetscReal norm2 = 0, error = 0;
  const PetscInt n = r->n;
  Vec q = r->q[0];

  PetscFunctionBegin;
  for (PetscInt j = 0; j < n; j++) {
    norm2 += c[j] * c[j];
    error += PetscAbsReal(c[j]) * r->error[j];
  }
  r->n = norm2 > 0 ? 1 : 0;
  if (!r->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecScale(q, c[0]));
  PetscCall(VecMAXPY(q, n - 1, c + 1, r->q + 1));
  PetscCall(VecScale(q, 1 / PetscSqrtReal(norm2)));
  PetscCall(VecCopy(y, r->image[0]));
  PetscCall(VecScale(r->image[0], 1 / PetscSqrtReal(norm2)));
  r->error[0] = error / PetscSqrtReal(norm2);
  PetscFunctionReturn(PETSC_SUCCESS);
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
  PetscCall(VecMDot(x, r->n, r->q, c));
  for (PetscInt j = 0; j < r->n; j++) c[j] = -c[j];
  PetscCall(VecMAXPY(x, r->n, c, r->q));
  PetscCall(VecMDot(x, r->n, r->q, again)); /* orthogonal to rounding, however small the rest is */
  for (PetscInt j = 0; j < r->n; j++) again[j] = -again[j];
  PetscCall(VecMAXPY(x, r->n, again, r->q));
  for (PetscInt j = 0; j < r->n; j++) c[j] = -(c[j] + again[j]);
  PetscCall(VecMAXPY(y, r->n, c, r->image));
  if (r->n == SLIP_RECALL_MAX) PetscCall(Collapse(r, c, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A direction of norm 1, orthogonal to those kept, and its image to an absolute error; SlipRecallSplit() has made room. */
PetscErrorCode SlipRecallAdd(SlipRecall *r, Vec q, Vec image, PetscReal error)
{
  PetscFunctionBegin;
  if (!r->q[r->n]) {
    PetscCall(VecDuplicate(q, &r->q[r->n]));
    PetscCall(VecDuplicate(q, &r->image[r->n]));
  }
  PetscCall(VecCopy(q, r->q[r->n]));
  PetscCall(VecCopy(image, r->image[r->n]));
  r->error[r->n++] = error;
  PetscFunctionReturn(PETSC_SUCCESS);
}
