/*
  What a cheap stage operator A gets wrong, D = B - A, made good where it is known: on directions S whose products with
  the exact viscosity a solver has paid for already (recycled.c). With the projection P onto them along A's inner
  product,

     P = S (S' A S)^-1 S' A,   A + D P + P' D - P' D P  =  B - (I - P)' D (I - P)

  is symmetric, exact on all of them, and what is left of D is no larger in A's norm than D, say delta < 1/2: it is
  positive definite, and iterations with it leave at most delta / (1 - 2 delta) of the error. (In the 2-norm it would
  be the symmetric secant update of Powell: Dennis and Schnabel 1983, Numerical Methods, section 9.1.) Iterations leave
  the error where D is largest, so that their iterates are the directions to know: on two faults of 5,041 cells stages
  take 7 to 11 products with H instead of 11 to 18, on a grid of 100 x 100 4 to 6 instead of 6 to 8. Directions outlast
  stages and steps, since only sums of the same products, and of their small matrices, depend on theta.
*/
#include <petsc/private/petscimpl.h>
#include <slipmat.h>
#include <slipcells.h>
#include <petscblaslapack.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatstage.h>

#define CORRECTION_MAX 24 /* directions; five or six vectors each */
/* Part of a direction that earlier ones must not cover. */
#define CORRECTION_NEW 0.1
/* Relative error of an image that is of use: small parts of an iterate are computed to few digits. */
#define CORRECTION_ERROR 1e-3

/* The small matrices. */
enum { OF_W, OF_K, OF_H, OF_R, SMALL };

struct _n_SlipSecant {
  Mat K;                /* borrowed */
  Mat R;                /* cheap viscosity, borrowed, or NULL */
  Vec weights;          /* of the rows of K, borrowed; NULL when all are 1 */
  PetscReal mass, mean; /* A = mean ((mass / theta) W + theta K) + R */
  PetscInt n;
  Vec s[CORRECTION_MAX];                                  /* orthonormal directions, */
  Vec stiffness[CORRECTION_MAX];                          /* K s */
  Vec viscosity[CORRECTION_MAX];                          /* H s */
  PetscReal error[CORRECTION_MAX];                        /* of H s in the 2-norm, at most */
  Vec a[CORRECTION_MAX];                                  /* A s at theta */
  Vec d[CORRECTION_MAX];                                  /* D s */
  Vec cheap[CORRECTION_MAX];                              /* R s */
  Vec like;                                               /* empty, for its layout */
  PetscReal theta;                                        /* of a and d; 0 when directions have been dropped since */
  PetscInt formed;                                        /* of the n: a and d, and the small matrices */
  PetscReal small[SMALL][CORRECTION_MAX][CORRECTION_MAX]; /* S' W S, S' K S, S' H S, S' R S */
  PetscReal factor[CORRECTION_MAX * CORRECTION_MAX];      /* Cholesky factor of S' A S [n][n] */
  PetscReal sds[CORRECTION_MAX * CORRECTION_MAX];         /* S' D S */
  PetscInt nseen;
  PetscObjectId seen[SLIP_RECYCLED_MAX];     /* directions of the viscosity that have been looked at, */
  PetscObjectState state[SLIP_RECYCLED_MAX]; /* and their states then */
};

/* For A = mean ((mass / theta) W + theta K) + R; R may be NULL. Collective. */
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

/* Vectors of one process. */
PetscReal SlipSecantVectors(SlipSecant c)
{
  PetscInt n = 0;

  while (n < CORRECTION_MAX && c->s[n]) n++;
  return (PetscReal)((c->R ? 6 : 5) * n + 1);
}

/* Takes a direction off the list, and its number h[k] off another; its vectors go to the end, to be used again. */
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

/* Takes off what would bring an error of more than allowed into a direction with the coefficients h, worst first, and
   the oldest when there is no room. Returns the error that is left. */
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

/* The products of the newest direction with all of them, none of which depends on theta: of W, K, R and H. */
static PetscErrorCode FormRows(SlipSecant c)
{
  const PetscInt n = c->n, last = n - 1;
  PetscReal row[CORRECTION_MAX];
  Vec weighted = c->a[last]; /* formed later */

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
  /* symmetric but for the error of the products with H */
  PetscCall(VecMDot(c->s[last], n, c->viscosity, row));
  for (PetscInt j = 0; j < last; j++) {
    c->small[OF_H][j][last] = 0.5 * (c->small[OF_H][j][last] + row[j]);
    c->small[OF_H][last][j] = c->small[OF_H][j][last];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The part of q, of norm 1, that the directions do not cover, unless it is small or its image is not accurate enough.
   image is H q with an error of at most error. Collective. */
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

/* Whether a direction of the viscosity has been looked at as it is; what tells. */
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

/* Directions of the viscosity that have come or changed since the last time. */
static PetscErrorCode Collect(SlipSecant c, const SlipRecycled *known)
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* a, d and the small matrices at theta. S' A S is the same on all ranks, and so is its factor. */
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

/* For this theta and these products with the exact viscosity; *changed says whether A has. Collective. */
PetscErrorCode SlipSecantUpdate(SlipSecant c, const SlipRecycled *known, PetscReal theta, PetscBool *changed)
{
  PetscFunctionBegin;
  PetscCall(Collect(c, known));
  *changed = (PetscBool)(c->theta != theta || c->formed != c->n);
  if (*changed && c->n) PetscCall(Form(c, theta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += (D P + P' D - P' D P) x. Collective. */
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

/* For checkpoints, known being as it was or is again: directions and images; what follows from them is formed anew. Of
   known's directions, which were looked at. Collective. */
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
  /* their bits depend on the directions that there were when they were formed */
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
  if (c->n && theta > 0) PetscCall(Form(c, theta)); /* no work of the next step, which an unbroken run does not have */
  PetscFunctionReturn(PETSC_SUCCESS);
}
