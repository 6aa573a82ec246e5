/*
  Corrects the error D = B - A of a cheap stage operator A on directions S whose products with the exact viscosity have
  already been computed for a solver (recycled.c). With the projection P onto them in A's inner product,

     P = S (S' A S)^-1 S' A,   A + D P + P' D - P' D P  =  B - (I - P)' D (I - P)

  is symmetric and exact on all of them. The rest of D is no larger in A's norm than D, say delta < 1/2, so that the
  operator is positive definite and each iteration reduces the error at least by delta / (1 - 2 delta). (In the 2-norm
  it would be the symmetric secant update of Powell: Dennis and Schnabel 1983, Numerical Methods, section 9.1.) The
  error remains where D is largest, so that iterates are the best directions: on two faults of 5,041 cells stages take 7
  to 11 products with H instead of 11 to 18, on a grid of 100 x 100 4 to 6 instead of 6 to 8. Directions are valid in
  later stages and steps, because only sums of the same products, and of their small matrices, depend on theta.
*/
#include <petsc/private/petscimpl.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipcells.h>
#include <petscblaslapack.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatstage.h>

#define CORRECTION_MAX 24 /* largest number of directions; each has five or six vectors */
/* A direction is added if the part of it outside of the span of earlier ones is larger. */
#define CORRECTION_NEW 0.1
/* Largest useful relative error of an image: small parts of an iterate are computed to few digits */
#define CORRECTION_ERROR 1e-3

/* The small matrices */
enum { OF_W, OF_K, OF_H, OF_R, SMALL };

struct _n_SlipSecant {
  Mat K;                /* borrowed */
  Mat R;                /* cheap viscosity, borrowed, or NULL */
  Vec weights;          /* of the rows of K, borrowed; NULL when all are 1 */
  PetscReal mass, mean; /* A = mean ((mass / theta) W + theta K) + R */
  PetscInt n;
  Vec s[CORRECTION_MAX];                                  /* orthonormal directions s */
  Vec stiffness[CORRECTION_MAX];                          /* K s */
  Vec viscosity[CORRECTION_MAX];                          /* H s */
  PetscReal error[CORRECTION_MAX];                        /* bound of the error of H s in the 2-norm */
  Vec a[CORRECTION_MAX];                                  /* A s at theta */
  Vec d[CORRECTION_MAX];                                  /* D s */
  Vec cheap[CORRECTION_MAX];                              /* R s */
  Vec like;                                               /* empty vector that has the layout */
  PetscReal theta;                                        /* of a and d; 0 if directions have been removed since */
  PetscInt formed;                                        /* number of directions whose a, d and small rows exist */
  PetscReal small[SMALL][CORRECTION_MAX][CORRECTION_MAX]; /* S' W S, S' K S, S' H S, S' R S */
  PetscReal factor[CORRECTION_MAX * CORRECTION_MAX];      /* Cholesky factor of S' A S [n][n] */
  PetscReal sds[CORRECTION_MAX * CORRECTION_MAX];         /* S' D S */
  PetscInt nseen;
  PetscObjectId seen[SLIP_RECYCLED_MAX];     /* directions of the viscosity that have been examined */
  PetscObjectState state[SLIP_RECYCLED_MAX]; /* their states at that time */
};

/* Creates the correction of A = mean ((mass / theta) W + theta K) + R; R may be NULL. Collective. */
PetscErrorCode SlipSecantCreate(Mat K, Mat R, PetscReal mass, PetscReal mean, SlipSecant *correction)
{
  SlipSecant c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->K = K;
  c->R = R;
  c->mass = mass;
  c->mean = mean;
  PetscCall(MatSlipGetWeights(K, &c->weights));
  PetscCall(MatCreateVecs(K, NULL, &c->like));
  *correction = c;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipSecantDestroy(SlipSecant *correction)
{
  SlipSecant c = *correction;

  PetscFunctionBegin;
  if (!c) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt j = 0; j < CORRECTION_MAX; j++) {
    PetscCall(VecDestroy(&c->s[j]));
    PetscCall(VecDestroy(&c->stiffness[j]));
    PetscCall(VecDestroy(&c->viscosity[j]));
    PetscCall(VecDestroy(&c->cheap[j]));
    PetscCall(VecDestroy(&c->a[j]));
    PetscCall(VecDestroy(&c->d[j]));
  }
  PetscCall(VecDestroy(&c->like));
  PetscCall(PetscFree(c));
  *correction = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of vectors. */
PetscReal SlipSecantVectors(SlipSecant c)
{
  PetscInt n = 0;

  while (n < CORRECTION_MAX && c->s[n]) n++;
  return (PetscReal)((c->R ? 6 : 5) * n + 1);
}

/* Removes direction k and its coefficient h[k] from their lists; its vectors go to the end and are used again. */
static void Drop(SlipSecant c, PetscInt k, PetscReal h[])
{
  Vec *const lists[] = {c->s, c->stiffness, c->viscosity, c->cheap};

  c->n--;
  c->theta = 0;
  for (PetscInt j = 0; j < c->n; j++)
    for (PetscInt i = 0; i < c->n; i++)
      for (int l = 0; l < SMALL; l++) c->small[l][j][i] = c->small[l][j < k ? j : j + 1][i < k ? i : i + 1];
  for (int i = 0; i < 4; i++) {
    const Vec dropped = lists[i][k];

    for (PetscInt j = k; j < c->n; j++) lists[i][j] = lists[i][j + 1];
    lists[i][c->n] = dropped;
  }
  for (PetscInt j = k; j < c->n; j++) {
    c->error[j] = c->error[j + 1];
    h[j] = h[j + 1];
  }
}

/* Removes directions, worst first, that would add an error of more than allowed to a direction with the coefficients h,
   and the oldest one if there is no room. Returns the remaining error. */
static PetscReal KeepAccurate(SlipSecant c, PetscReal error, PetscReal allowed, PetscReal h[])
{
  for (;;) {
    PetscReal sum = error;
    PetscInt worst = 0;

    for (PetscInt j = 0; j < c->n; j++) {
      sum += PetscAbsReal(h[j]) * c->error[j];
      if (PetscAbsReal(h[j]) * c->error[j] > PetscAbsReal(h[worst]) * c->error[worst]) worst = j;
    }
    if (c->n == CORRECTION_MAX)
      Drop(c, 0, h);
    else if (sum > allowed && c->n > 0)
      Drop(c, worst, h);
    else
      return sum;
  }
}

static PetscErrorCode Allocate(SlipSecant c, PetscInt k)
{
  Vec *const vectors[] = {&c->s[k], &c->stiffness[k], &c->viscosity[k], &c->a[k], &c->d[k], &c->cheap[k]};

  PetscFunctionBegin;
  if (c->s[k]) PetscFunctionReturn(PETSC_SUCCESS);
  for (int i = 0; i < (c->R ? 6 : 5); i++) PetscCall(VecDuplicate(c->like, vectors[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the products of the newest direction with all directions by W, K, R and H, which do not depend on theta. */
static PetscErrorCode FormRows(SlipSecant c)
{
  const PetscInt n = c->n, last = n - 1;
  PetscReal row[CORRECTION_MAX];
  Vec weighted = c->a[last]; /* used as work, as a is computed later */

  PetscFunctionBegin;
  if (c->weights)
    PetscCall(VecPointwiseMult(weighted, c->weights, c->s[last]));
  else
    PetscCall(VecCopy(c->s[last], weighted));
  for (int k = 0; k < SMALL; k++) {
    const Vec image[SMALL] = {weighted, c->stiffness[last], c->viscosity[last], c->cheap[last]};

    if (!image[k]) continue;
    PetscCall(VecMDot(image[k], n, c->s, row));
    for (PetscInt j = 0; j < n; j++) c->small[k][j][last] = c->small[k][last][j] = row[j];
  }
  /* symmetric except for the error of the products with H */
  PetscCall(VecMDot(c->s[last], n, c->viscosity, row));
  for (PetscInt j = 0; j < last; j++) {
    c->small[OF_H][j][last] = 0.5 * (c->small[OF_H][j][last] + row[j]);
    c->small[OF_H][last][j] = c->small[OF_H][j][last];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the part of q, of norm 1, outside of the span of the directions, unless it is small or its image is not accurate
   enough. image is H q with an error of at most error. Collective. */
static PetscErrorCode Add(SlipSecant c, Vec q, Vec image, PetscReal error)
{
  PetscReal h[CORRECTION_MAX], norm, size, covered = 0;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecNorm(image, NORM_2, &size));
  PetscCall(VecMDot(q, c->n, c->s, h));
  for (PetscInt i = 0; i < c->n; i++) covered += h[i] * h[i];
  if (covered > 1 - CORRECTION_NEW * CORRECTION_NEW || error > CORRECTION_ERROR * size)
    PetscFunctionReturn(PETSC_SUCCESS);
  error = KeepAccurate(c, error, CORRECTION_ERROR * size, h);
  n = c->n;
  PetscCall(Allocate(c, n));
  for (PetscInt i = 0; i < n; i++) h[i] = -h[i];
  PetscCall(VecCopy(q, c->s[n]));
  PetscCall(VecMAXPY(c->s[n], n, h, c->s));
  PetscCall(VecCopy(image, c->viscosity[n]));
  PetscCall(VecMAXPY(c->viscosity[n], n, h, c->viscosity));
  PetscCall(VecNormalize(c->s[n], &norm));
  PetscCall(VecScale(c->viscosity[n], 1 / norm));
  PetscCall(VecNorm(c->viscosity[n], NORM_2, &size));
  if (error > CORRECTION_ERROR * size * norm) PetscFunctionReturn(PETSC_SUCCESS);
  c->error[n] = error / norm;
  PetscCall(MatMult(c->K, c->s[n], c->stiffness[n]));
  if (c->R) PetscCall(MatMult(c->R, c->s[n], c->cheap[n]));
  c->n++;
  PetscCall(FormRows(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a direction of the viscosity has been examined in its present state, and its id and state. */
static PetscErrorCode HasSeen(SlipSecant c, Vec q, PetscObjectId *id, PetscObjectState *state, PetscBool *seen)
{
  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)q, id));
  PetscCall(PetscObjectStateGet((PetscObject)q, state));
  *seen = PETSC_FALSE;
  for (PetscInt i = 0; i < c->nseen; i++)
    if (c->seen[i] == *id && c->state[i] == *state) *seen = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a, d and the small matrices at theta. S' A S and its factor are the same on all ranks. */
static PetscErrorCode Form(SlipSecant c, PetscReal theta)
{
  const PetscReal inertia = c->mass / theta, more = c->mean - 1;
  const PetscInt n = c->n;
  PetscBLASInt bn, info;

  PetscFunctionBegin;
  for (PetscInt j = c->theta == theta ? c->formed : 0; j < n; j++) {
    if (c->weights)
      PetscCall(VecPointwiseMult(c->a[j], c->weights, c->s[j]));
    else
      PetscCall(VecCopy(c->s[j], c->a[j]));
    PetscCall(VecAXPBY(c->a[j], theta, inertia, c->stiffness[j]));
    PetscCall(VecWAXPY(c->d[j], -more, c->a[j], c->viscosity[j]));
    PetscCall(VecScale(c->a[j], c->mean));
    if (!c->R) continue;
    PetscCall(VecAXPY(c->a[j], 1, c->cheap[j]));
    PetscCall(VecAXPY(c->d[j], -1, c->cheap[j]));
  }
  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal base = inertia * c->small[OF_W][j][i] + theta * c->small[OF_K][j][i];
      const PetscReal cheap = c->R ? c->small[OF_R][j][i] : 0;

      c->factor[j * n + i] = c->mean * base + cheap;
      c->sds[j * n + i] = c->small[OF_H][j][i] - more * base - cheap;
    }
  c->theta = theta;
  c->formed = n;
  PetscCall(PetscBLASIntCast(n, &bn));
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &bn, c->factor, &bn, &info));
  PetscCheck(!info, PetscObjectComm((PetscObject)c->K), PETSC_ERR_LIB,
             "The stiffness is not positive on directions of the solution: LAPACK potrf %d", (int)info);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the correction for this theta and these exact products with H; *changed: A has changed. Collective. */
PetscErrorCode SlipSecantUpdate(SlipSecant c, const SlipRecycled *known, PetscReal theta, PetscBool *changed)
{
  PetscObjectId id[SLIP_RECYCLED_MAX];
  PetscObjectState state[SLIP_RECYCLED_MAX];

  PetscFunctionBegin;
  for (PetscInt j = 0; j < known->n; j++) {
    PetscBool seen = PETSC_FALSE;

    PetscCall(HasSeen(c, known->q[j], &id[j], &state[j], &seen));
    if (!seen) PetscCall(Add(c, known->q[j], known->image[j], known->error[j]));
  }
  c->nseen = known->n;
  PetscCall(PetscArraycpy(c->seen, id, known->n));
  PetscCall(PetscArraycpy(c->state, state, known->n));
  *changed = (PetscBool)(c->theta != theta || c->formed != c->n);
  if (*changed && c->n) PetscCall(Form(c, theta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y += (D P + P' D - P' D P) x. Collective. */
PetscErrorCode SlipSecantAdd(SlipSecant c, Vec x, Vec y)
{
  PetscReal u[CORRECTION_MAX], v[CORRECTION_MAX], w[CORRECTION_MAX];
  const PetscBLASInt n = (PetscBLASInt)c->n, one = 1;
  PetscBLASInt info;

  PetscFunctionBegin;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecMDot(x, n, c->a, u));
  PetscCall(VecMDot(x, n, c->d, v));
  PetscCallBLAS("LAPACKpotrs", LAPACKpotrs_("L", &n, &one, c->factor, &n, u, &n, &info)); /* P x = S u */
  for (PetscInt i = 0; i < n; i++) {
    w[i] = v[i];
    for (PetscInt j = 0; j < n; j++) w[i] -= c->sds[i * n + j] * u[j];
  }
  PetscCallBLAS("LAPACKpotrs", LAPACKpotrs_("L", &n, &one, c->factor, &n, w, &n, &info));
  PetscCall(VecMAXPY(y, n, u, c->d));
  PetscCall(VecMAXPY(y, n, w, c->a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads a checkpoint, in which `known` is equal: directions, images, and which of known's directions have
   been examined; all else is computed from these. Collective. */
PetscErrorCode SlipSecantState(SlipSecant c, const SlipRecycled *known, SlipState s)
{
  const PetscBool loading = SlipStateIsLoading(s);
  PetscReal theta;
  char name[32];

  PetscFunctionBegin;
  PetscCall(SlipStateCount(s, "secants", CORRECTION_MAX, &c->n));
  for (PetscInt j = 0; j < c->n; j++) PetscCall(Allocate(c, j));
  PetscCall(SlipStateVecs(s, "secant", c->n, c->s));
  PetscCall(SlipStateVecs(s, "secant_image", c->n, c->viscosity));
  PetscCall(SlipStateReal(s, "secant_errors", CORRECTION_MAX, c->error));
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
  for (PetscInt j = 0; j < c->n && loading; j++) {
    PetscCall(MatMult(c->K, c->s[j], c->stiffness[j]));
    if (c->R) PetscCall(MatMult(c->R, c->s[j], c->cheap[j]));
  }
  PetscCall(SlipProductsPop());
  /* their bits depend on the directions that existed when they were computed */
  PetscCall(SlipStateReal(s, "secant_products", SMALL * CORRECTION_MAX * CORRECTION_MAX, &c->small[0][0][0]));
  if (loading) c->nseen = 0;
  for (PetscInt j = 0; j < known->n; j++) {
    PetscObjectState state;
    PetscObjectId id;
    PetscBool seen;

    PetscCall(HasSeen(c, known->q[j], &id, &state, &seen));
    PetscCall(PetscSNPrintf(name, sizeof(name), "seen_%" PetscInt_FMT, j));
    PetscCall(SlipStateBool(s, name, &seen));
    if (!loading || !seen) continue;
    c->seen[c->nseen] = id;
    c->state[c->nseen++] = state;
  }
  theta = c->theta;
  PetscCall(SlipStateReal(s, "secant_theta", 1, &theta));
  if (!loading) PetscFunctionReturn(PETSC_SUCCESS);
  c->formed = 0;
  c->theta = theta;
  if (c->n && theta > 0) PetscCall(Form(c, theta)); /* an unbroken run does not do this in the next step */
  PetscFunctionReturn(PETSC_SUCCESS);
}
