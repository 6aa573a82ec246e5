/*
  Reuse of products H x, whose cost grows with the number of digits, for a solver's iterates x, which differ less and
  less. Orthonormal directions q_j and their images H q_j are stored, each with the error of the image. Only the part of
  x outside of their span is computed, with an error that is small relative to H x and not to the part: a small part
  needs few digits. The same x again needs no product. When the memory is full only the part along the last x is kept.

  For a solver with loose > 0 the product of an iterate far from earlier ones has a few digits only. With the next
  iterate it is removed, because its error would show, and that one's product has the usual accuracy. Newton's first
  iterate of a stage is wrong in its third digit, so that eight digits of its product would be useless: at 100 x 100 a
  run's products with H take 2250 products with K instead of 2460.

  An explicit scheme needs products of the rates of its steps, each of which is nearly in the span of the last ones,
  with the error that the scheme allows (least).
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

/* Shares of the tolerance. A product without stored ones uses all of it; stored ones with which the sum would exceed
   their common share are removed. */
#define SLIP_RECYCLED_NEW 0.2   /* share of a new direction besides others */
#define SLIP_RECYCLED_OLD 2.0   /* share of all stored ones together */
#define SLIP_RECYCLED_REST 1e-4 /* a rest this small relative to x is neglected */
/* A rest this large relative to x is computed together with the other part: |H x| does not follow from that part alone,
   and an error that is small relative to its product could be below rounding. */
#define SLIP_RECYCLED_WHOLE 0.7
/* Above this tolerance directions need not be orthogonal to rounding. The part outside of their span is at least
   SLIP_RECYCLED_REST times the tolerance, so that they are orthogonal to 1e-16 over 1e-10. */
#define SLIP_RECYCLED_COARSE 1e-6
/* A product with few digits pays only if its tolerance is larger by more than this factor. */
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

/* Removes the least accurate contributions of x = sum a_j q_j until the error of the others together is allowed.
   Errors of separate Lanczos processes are independent, so that their squares add up. */
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
    {
      const Vec q = c->q[worst], image = c->image[worst];

      for (PetscInt j = worst; j + 1 < c->n; j++) {
        c->q[j] = c->q[j + 1];
        c->image[j] = c->image[j + 1];
        c->error[j] = c->error[j + 1];
      }
      c->n--;
      c->q[c->n] = q; /* the vectors are used again */
      c->image[c->n] = image;
    }
    for (PetscInt j = worst; j < c->n; j++) a[j] = a[j + 1];
  }
}

/* Makes room: x's part along all directions replaces them as one direction, whose image is y. */
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

/* Computes y = H times the part of x along accurate directions, and rest = the other part; *size estimates |H x|. */
static PetscErrorCode Split(SlipRecycled *c, PetscReal tolerance, Vec x, Vec y, PetscReal *size)
{
  /* two passes are orthogonal to rounding for any size of the rest; few digits need one */
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
  if (passes == 2 || c->n < n || !n) { /* otherwise y has it already */
    PetscCall(VecZeroEntries(y));
    if (c->n) PetscCall(VecMAXPY(y, c->n, a, c->image));
  }
  if (c->n == SLIP_RECYCLED_MAX) PetscCall(Collapse(c, a, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = H x with an error of tolerance |H x|, or of loose |H x|, see above; x and y differ. Collective. */
PetscErrorCode SlipRecycledMult(SlipRecycled *c, PetscReal tolerance, SlipProductFn product, void *ctx, Vec x, Vec y)
{
  PetscReal whole, norm, size, allowed, relative, image;
  PetscInt k;
  Vec q;

  PetscFunctionBegin;
  tolerance = PetscMax(tolerance, c->least);
  PetscCall(VecNorm(x, NORM_2, &whole));
  if (whole == 0) { /* solvers start with it: it removes no direction */
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

  /* rest / norm and its image are stored: with a share of the tolerance besides others, with all of it if alone */
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

/* Writes or reads the stored products in a checkpoint. Collective. */
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
