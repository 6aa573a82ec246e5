/*
  Products H x that cost the more the more digits they are to have, for a solver's iterates x, which differ less and
  less. Directions q_j, orthonormal, and their images H q_j are remembered, each with the error it was computed to. Of x
  only the part that they do not cover has to be computed, to an error that is small against H x, not against the part:
  few digits when the part is small. The same x again is free. Of a full memory the part of the last x is kept.

  A solver that says so (loose > 0) gets the product of an iterate that is far from the ones before to a few digits
  only: with the next one it is forgotten, since its error shows, and that one's product is as exact as ever. Newton's
  first iterate of a stage is wrong in its third digit, and paying for eight is paying for nothing: at 100 x 100 a run's
  products with H take 2250 products with K instead of 2460.

  An explicit scheme asks for the rates of its steps, of which each is nearly in the span of the last ones, to the error
  that its own allows (least).
*/
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

/* Shares of the tolerance. A product from scratch takes all of it; parts that would exceed what remembered ones may be
   wrong together are forgotten. */
#define SLIP_RECYCLED_NEW 0.2   /* of a new direction beside others */
#define SLIP_RECYCLED_OLD 2.0   /* of all remembered ones together */
#define SLIP_RECYCLED_REST 1e-4 /* a rest this small against x counts as nothing */
/* A rest this large against x is computed together with the other part: |H x| is not known from that part alone, and an
   error small against its product could be one that rounding does not allow. */
#define SLIP_RECYCLED_WHOLE 0.7
/* Beyond this tolerance directions need not be orthogonal to rounding. The part that they do not cover is at least
   SLIP_RECYCLED_REST of the tolerance, so that they are to 1e-16 over 1e-10. */
#define SLIP_RECYCLED_COARSE 1e-6
/* A few digits are worth their products only where they spare more than this factor. */
#define SLIP_RECYCLED_SPARE 100.0

PetscErrorCode SlipRecycledReset(SlipRecycled *c)
{
  PetscFunctionBegin;
  for (PetscInt j = 0; j < SLIP_RECYCLED_MAX; j++) {
    PetscCall(VecDestroy(&c->q[j]));
    PetscCall(VecDestroy(&c->image[j]));
  }
  PetscCall(VecDestroy(&c->rest));
  c->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes a direction; its vectors go to the end, to be used again. */
static void Forget(SlipRecycled *c, PetscInt k)
{
  const Vec q = c->q[k], image = c->image[k];

  for (PetscInt j = k; j + 1 < c->n; j++) {
    c->q[j] = c->q[j + 1];
    c->image[j] = c->image[j + 1];
    c->error[j] = c->error[j + 1];
  }
  c->n--;
  c->q[c->n] = q;
  c->image[c->n] = image;
}

/* Forgets the least accurate contributions of x = sum a_j q_j until the others keep to the error allowed together.
   Errors of separate Lanczos processes do not know of each other: their squares add up. */
static void KeepAccurate(SlipRecycled *c, PetscReal a[], PetscReal allowed)
{
  for (;;) {
    PetscReal sum = 0;
    PetscInt worst = 0;

    for (PetscInt j = 0; j < c->n; j++) {
      sum += PetscSqr(a[j] * c->error[j]);
      if (PetscAbsReal(a[j]) * c->error[j] > PetscAbsReal(a[worst]) * c->error[worst]) worst = j;
    }
    if (sum <= PetscSqr(allowed)) return;
    Forget(c, worst);
    for (PetscInt j = worst; j < c->n; j++) a[j] = a[j + 1];
  }
}

/* Makes room: one direction, x's part along all of them, takes their place; y is its image. */
static PetscErrorCode Collapse(SlipRecycled *c, const PetscReal a[], Vec y)
{
  PetscReal norm2 = 0, error = 0;
  const PetscInt n = c->n;

  PetscFunctionBegin;
  for (PetscInt j = 0; j < n; j++) {
    norm2 += a[j] * a[j];
    error += PetscAbsReal(a[j]) * c->error[j];
  }
  c->n = norm2 > 0 ? 1 : 0;
  if (!c->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecScale(c->q[0], a[0]));
  PetscCall(VecMAXPY(c->q[0], n - 1, a + 1, c->q + 1));
  PetscCall(VecScale(c->q[0], 1 / PetscSqrtReal(norm2)));
  PetscCall(VecCopy(y, c->image[0]));
  PetscCall(VecScale(c->image[0], 1 / PetscSqrtReal(norm2)));
  c->error[0] = error / PetscSqrtReal(norm2);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y = H of the part of x that is covered accurately enough, rest = the other part; *size is |H x| as far as known. */
static PetscErrorCode Split(SlipRecycled *c, PetscReal tolerance, Vec x, Vec y, PetscReal *size)
{
  /* twice: orthogonal to rounding, however small the rest is; of few digits once */
  const int passes = tolerance > SLIP_RECYCLED_COARSE ? 1 : 2;
  const PetscInt n = c->n;
  PetscReal a[SLIP_RECYCLED_MAX], again[SLIP_RECYCLED_MAX];

  PetscFunctionBegin;
  *size = 0;
  PetscCall(VecCopy(x, c->rest));
  if (n) {
    PetscCall(VecMDot(x, n, c->q, a));
    PetscCall(VecZeroEntries(y));
    PetscCall(VecMAXPY(y, n, a, c->image));
    PetscCall(VecNorm(y, NORM_2, size));
    KeepAccurate(c, a, PetscMax(SLIP_RECYCLED_OLD * tolerance * *size, c->wanted));
  }
  for (int pass = 0; pass < passes && c->n; pass++) {
    if (pass) PetscCall(VecMDot(c->rest, c->n, c->q, again));
    for (PetscInt j = 0; j < c->n; j++) {
      if (pass) a[j] += again[j];
      again[j] = pass ? -again[j] : -a[j];
    }
    PetscCall(VecMAXPY(c->rest, c->n, again, c->q));
  }
  if (passes == 2 || c->n < n || !n) { /* else y is that already */
    PetscCall(VecZeroEntries(y));
    if (c->n) PetscCall(VecMAXPY(y, c->n, a, c->image));
  }
  if (c->n == SLIP_RECYCLED_MAX) PetscCall(Collapse(c, a, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y = H x with an error of tolerance |H x|, or of loose |H x|, see above; x and y differ. Collective. */
PetscErrorCode SlipRecycledMult(SlipRecycled *c, PetscReal tolerance, SlipProductFn product, void *ctx, Vec x, Vec y)
{
  PetscReal whole, norm, size, allowed, relative, image;
  PetscInt k;
  Vec q;

  PetscFunctionBegin;
  tolerance = PetscMax(tolerance, c->least);
  PetscCall(VecNorm(x, NORM_2, &whole));
  if (whole == 0) { /* as solvers ask for at their start: forgets nothing */
    PetscCall(VecZeroEntries(y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!c->rest) PetscCall(VecDuplicate(x, &c->rest));
  PetscCall(Split(c, tolerance, x, y, &size));
  PetscCall(VecNorm(c->rest, NORM_2, &norm));
  if (norm > SLIP_RECYCLED_WHOLE * whole) {
    PetscCall(VecCopy(x, c->rest));
    PetscCall(VecZeroEntries(y));
    norm = whole;
    size = 0;
    c->n = 0;
  }
  c->noise = tolerance * size;
  if (norm <= SLIP_RECYCLED_REST * tolerance * whole) PetscFunctionReturn(PETSC_SUCCESS);

  /* rest / norm and its image are remembered: to a share of the tolerance beside others, to all of it alone */
  allowed = PetscMax(SLIP_RECYCLED_NEW * tolerance * size, c->wanted);
  relative = size > 0 ? 0 : tolerance;
  c->loosened = (PetscBool)(c->loose > 0 && !c->loosened &&
                            (size > 0 ? c->loose * size * norm / whole > SLIP_RECYCLED_SPARE * allowed
                                      : c->loose > SLIP_RECYCLED_SPARE * tolerance));
  if (c->loosened) relative = c->loose;
  k = c->n++;
  if (!c->q[k]) {
    PetscCall(VecDuplicate(c->rest, &c->q[k]));
    PetscCall(VecDuplicate(c->rest, &c->image[k]));
  }
  q = c->q[k];
  c->q[k] = c->rest;
  c->rest = q;
  PetscCall(VecScale(c->q[k], 1 / norm));
  PetscCall((*product)(ctx, c->q[k], allowed / norm, relative, c->image[k]));
  PetscCall(VecNorm(c->image[k], NORM_2, &image));
  c->error[k] = PetscMax(allowed / norm, relative * image);
  PetscCall(VecAXPY(y, norm, c->image[k]));
  c->noise = PetscMax(tolerance * size, norm * c->error[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is remembered, for checkpoints. Collective. */
PetscErrorCode SlipRecycledState(SlipRecycled *c, Mat H, SlipState s)
{
  PetscFunctionBegin;
  PetscCall(SlipStateCount(s, "directions", SLIP_RECYCLED_MAX, &c->n));
  PetscCall(SlipStateBool(s, "loosened", &c->loosened));
  PetscCall(SlipStateReal(s, "noise", 1, &c->noise));
  for (PetscInt j = 0; j < c->n; j++)
    if (!c->q[j]) PetscCall(MatCreateVecs(H, &c->q[j], &c->image[j]));
  PetscCall(SlipStateVecs(s, "direction", c->n, c->q));
  PetscCall(SlipStateVecs(s, "image", c->n, c->image));
  PetscCall(SlipStateReal(s, "errors", SLIP_RECYCLED_MAX, c->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
