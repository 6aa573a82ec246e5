/*
  This file finds the largest frequency at which a fault with inertia can vibrate, which bounds explicit steps:

     omega^2 = the largest eigenvalue of A = D^-1 (df/du) D^-1 / mass,   D = diag(w)^(1/2),

  where w are the weights of the stiffness. Lanczos' process finds the largest Ritz value. Its sum with its residual is
  an upper bound if the start is not orthogonal to the eigenvector (Zhou & Li 2011, Linear Algebra Appl. 435), and the
  start is random. Lost orthogonality of the recurrence only repeats Ritz values, and the bound stays valid.
*/
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipmatviscosity.h>
#include <slipstep/rooms/slipblas.h>
#include <slipstep/rooms/slipcore.h>

#define FREQUENCY_MOST 40       /* largest number of products */
#define FREQUENCY_RESIDUAL 0.01 /* residual over the Ritz value where the process ends: omega is <= 0.5 % too large */

/* The operator y = D^-1 (df/du) D^-1 x / mass. df/du is symmetric, and f(u, t) is affine in u: offset is f(0, t), and
   NULL where that is 0. */
typedef struct {
  SlipElastic el;
  PetscReal t;
  Vec inverse; /* D^-1, or NULL: 1 */
  Vec offset, scaled;
} Operator;

static PetscErrorCode Multiply(Operator *A, Vec x, Vec y)
{
  PetscFunctionBegin;
  PetscCall(VecCopy(x, A->scaled));
  if (A->inverse) PetscCall(VecPointwiseMult(A->scaled, A->scaled, A->inverse));
  PetscCall(SlipElasticForce(A->el, A->t, A->scaled, NULL, y, NULL));
  if (A->offset) PetscCall(VecAXPY(y, -1, A->offset));
  if (A->inverse) PetscCall(VecPointwiseMult(y, y, A->inverse));
  PetscCall(VecScale(y, 1 / A->el->mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lanczos' process starts from q and overwrites it; old and next are work vectors. */
static PetscErrorCode LargestEigenvalue(Operator *A, Vec q, Vec old, Vec next, PetscReal *largest)
{
  PetscReal alpha[FREQUENCY_MOST], beta[FREQUENCY_MOST], value = 0, residual = 0;
  PetscReal d[FREQUENCY_MOST], e[FREQUENCY_MOST], Z[FREQUENCY_MOST * FREQUENCY_MOST], work[2 * FREQUENCY_MOST];
  PetscInt m = 0;
  PetscBLASInt n, info;

  PetscFunctionBegin;
  PetscCall(VecNormalize(q, NULL));
  do {
    Vec spare = old;

    PetscCall(Multiply(A, q, next));
    if (m) PetscCall(VecAXPY(next, -beta[m - 1], old));
    PetscCall(VecDot(next, q, &alpha[m]));
    PetscCall(VecAXPY(next, -alpha[m], q));
    PetscCall(VecNorm(next, NORM_2, &beta[m]));
    PetscCheck(!PetscIsInfOrNanReal(beta[m]), PetscObjectComm((PetscObject)A->el), PETSC_ERR_FP,
               "the stress that slip makes is not finite");
    m++;
    /* the largest Ritz value and its residual; the matrix has alpha[m] on and beta[m - 1] beside its diagonal */
    PetscCall(PetscBLASIntCast(m, &n));
    PetscCall(PetscArraycpy(d, alpha, m));
    PetscCall(PetscArraycpy(e, beta, m));
    SLIP_dstev("V", &n, d, e, Z, &n, work, &info);
    PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK stev: info %d", (int)info);
    value = d[m - 1];
    residual = beta[m - 1] * PetscAbsReal(Z[m * m - 1]);
    old = q;
    q = next;
    next = spare;
    if (beta[m - 1] > 0) PetscCall(VecScale(q, 1 / beta[m - 1]));
  } while (residual > FREQUENCY_RESIDUAL * PetscAbsReal(value) && m < FREQUENCY_MOST);
  PetscCall(PetscInfo(A->el, "largest eigenvalue %g 1/s^2, residual %g, after %" PetscInt_FMT " products\n",
                      (double)value, (double)residual, m));
  *largest = value + residual;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Frequency(SlipElastic el, PetscReal *omega)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)el);
  Operator A = {.el = el, .t = el->past[1].t};
  PetscReal largest, *a;
  Vec work[4], root;
  PetscInt start, end;

  PetscFunctionBegin;
  PetscCall(SlipRootWeights(el->K, &root, &A.inverse));
  PetscCall(MatCreateVecs(el->K, &work[0], NULL));
  for (int k = 1; k < 4; k++) PetscCall(VecDuplicate(work[0], &work[k]));
  A.scaled = work[3];
  if (el->ops->force != SlipElasticForceStatic) { /* its f is 0 where u is 0, which others need not be */
    PetscCall(VecDuplicate(work[0], &A.offset));
    PetscCall(VecZeroEntries(work[3]));
    PetscCall(SlipElasticForce(el, A.t, work[3], NULL, A.offset, NULL));
  }
  /* random numbers in (-1, 1) of the cells' numbers, whatever the order and the owners of cells */
  PetscCall(VecGetOwnershipRange(work[0], &start, &end));
  PetscCall(VecGetArrayWrite(work[0], &a));
  for (PetscInt i = 0; i < end - start; i++) {
    const PetscInt row = el->number ? el->number[i / el->components] * el->components + i % el->components : start + i;
    uint64_t seed = SlipHashBytes(SLIP_HASH_START, &row, sizeof(row));

    SlipRandomFill(1, &a[i], &seed);
  }
  PetscCall(VecRestoreArrayWrite(work[0], &a));
  PetscCall(LargestEigenvalue(&A, work[0], work[1], work[2], &largest));
  PetscCheck(largest > 0, comm, PETSC_ERR_ARG_WRONG,
             "the stiffness has no positive eigenvalue (%g 1/s^2 over the mass): expected stress that resists slip",
             (double)largest);
  *omega = PetscSqrtReal(largest);
  for (int k = 0; k < 4; k++) PetscCall(VecDestroy(&work[k]));
  PetscCall(VecDestroy(&A.offset));
  PetscCall(VecDestroy(&A.inverse));
  PetscCall(VecDestroy(&root));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the largest frequency of a fault with inertia of which all cells slide. omega: square root of the largest
   eigenvalue of M^-1 df/du, where M is the mass times the weights of the stiffness [rad/s]; it is not below the exact
   value, and at most 0.5 % above. The first call computes it by some 10 to 25 products with df/du. The medium stores
   it, also in checkpoints, so that a restarted run takes the same steps. The number of processes changes it by rounding
   only. A part of a fault vibrates no faster than the whole fault. A medium with memory may be stiffer to slip from now
   on than to earlier slip: df/du is that of its last state. Errors: PETSC_ERR_ORDER for a medium with memory before
   SlipElasticAccept(), PETSC_ERR_ARG_WRONG where df/du has no positive eigenvalue. */
PetscErrorCode SlipElasticGetFrequency(SlipElastic el, PetscReal *omega)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCheck(!el->ops->advance || el->known, PetscObjectComm((PetscObject)el), PETSC_ERR_ORDER,
             "a medium that remembers answers slip from a past: call SlipElasticAccept() first");
  if (!el->frequency) PetscCall((*(el->ops->frequency ? el->ops->frequency : Frequency))(el, &el->frequency));
  *omega = el->frequency;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the largest frequency if it has been computed. omega: that of SlipElasticGetFrequency() [rad/s]; 0: it has not
   been computed. */
PetscErrorCode SlipElasticGetFoundFrequency(SlipElastic el, PetscReal *omega)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *omega = el->frequency;
  PetscFunctionReturn(PETSC_SUCCESS);
}
