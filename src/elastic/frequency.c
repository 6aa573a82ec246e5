/*
  The largest frequency at which a fault with inertia can vibrate, by which explicit steps are bounded:

     omega^2 = the largest eigenvalue of A = D^-1 (df/du) D^-1 / mass,   D = diag(w)^(1/2),

  w the weights of the stiffness. Lanczos' process finds the largest Ritz value; with its residual added it is a bound
  from above as long as the start is not orthogonal to the eigenvector (Zhou & Li 2011, Linear Algebra Appl. 435), and
  the start is random. Orthogonality that the recurrence loses repeats Ritz values, which the bound does not mind.
*/
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipmatviscosity.h>
#include <slipblas.h>
#include <slipcore.h>

#define FREQUENCY_MOST 40       /* products */
#define FREQUENCY_RESIDUAL 0.01 /* over the Ritz value where it ends: omega is then at most 0.5 % too large */

/* y = D^-1 (df/du) D^-1 x / mass. df/du is symmetric, and f(u, t) affine in u, where offset is f(0, t), or NULL. */
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

/* A number in (-1, 1) for each row, whatever the order of the cells and their owners: of the cell's number */
static PetscErrorCode FillStart(SlipElastic el, Vec x)
{
  PetscInt start, end;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetOwnershipRange(x, &start, &end));
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < end - start; i++) {
    const PetscInt row = el->number ? el->number[i / el->components] * el->components + i % el->components : start + i;
    uint64_t seed = SlipHashBytes(SLIP_HASH_START, &row, sizeof(row));

    SlipRandomFill(1, &a[i], &seed);
  }
  PetscCall(VecRestoreArrayWrite(x, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest Ritz value of T, alpha[m] on and beta[m - 1] beside its diagonal, and its residual */
static PetscErrorCode LargestRitz(PetscInt m, const PetscReal alpha[], const PetscReal beta[], PetscReal *value,
                                  PetscReal *residual)
{
  PetscReal d[FREQUENCY_MOST], e[FREQUENCY_MOST], Z[FREQUENCY_MOST * FREQUENCY_MOST], work[2 * FREQUENCY_MOST];
  PetscBLASInt n, info;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(m, &n));
  PetscCall(PetscArraycpy(d, alpha, m));
  PetscCall(PetscArraycpy(e, beta, m));
  SLIP_dstev("V", &n, d, e, Z, &n, work, &info);
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK stev: info %d", (int)info);
  *value = d[m - 1];
  *residual = beta[m - 1] * PetscAbsReal(Z[m * m - 1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lanczos' process from q, which is overwritten; old and next: work */
static PetscErrorCode LargestEigenvalue(Operator *A, Vec q, Vec old, Vec next, PetscReal *largest)
{
  PetscReal alpha[FREQUENCY_MOST], beta[FREQUENCY_MOST], value = 0, residual = 0;
  PetscInt m = 0;

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
    PetscCall(LargestRitz(m, alpha, beta, &value, &residual));
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
  PetscReal largest;
  Vec work[4], root;

  PetscFunctionBegin;
  PetscCall(SlipRootWeights(el->K, &root, &A.inverse));
  PetscCall(MatCreateVecs(el->K, &work[0], NULL));
  for (int k = 1; k < 4; k++) PetscCall(VecDuplicate(work[0], &work[k]));
  A.scaled = work[3];
  if (el->ops->force != SlipElasticForceStatic) { /* only its f is known to be 0 where u is */
    PetscCall(VecDuplicate(work[0], &A.offset));
    PetscCall(VecZeroEntries(work[3]));
    PetscCall(SlipElasticForce(el, A.t, work[3], NULL, A.offset, NULL));
  }
  PetscCall(FillStart(el, work[0]));
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

/*@
  SlipElasticGetFrequency - the largest frequency of a fault with inertia, all of which slides

  Collective; after SlipElasticSetUp()

  Input Parameter:
. el - the medium

  Output Parameter:
. omega - square root of the largest eigenvalue of M^-1 df/du, M the mass times the weights of the stiffness [rad/s];
          not below it, and at most 0.5 % above

  Level: developer

  Notes:
  It is found once, by products with df/du, some 10 to 25 of them, and remembered, by checkpoints as well, so that a run
  that goes on takes the same steps. On other numbers of processes it is the same up to rounding. Parts of a fault
  vibrate no faster than all of it.

  A medium that remembers may be stiffer to slip from now on than to slip of long ago: df/du is that of its last state.

  Errors: PETSC_ERR_ORDER for a medium that remembers before SlipElasticAccept(), PETSC_ERR_ARG_WRONG where df/du has no
  positive eigenvalue

.seealso: SlipElasticForce(), SlipElasticViscous()
@*/
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

/*@
  SlipElasticGetFoundFrequency - the largest frequency, if it has been asked for

  Not collective

  Input Parameter:
. el - the medium

  Output Parameter:
. omega - that of SlipElasticGetFrequency() [rad/s]; 0: not found yet

  Level: developer

.seealso: SlipElasticGetFrequency()
@*/
PetscErrorCode SlipElasticGetFoundFrequency(SlipElastic el, PetscReal *omega)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *omega = el->frequency;
  PetscFunctionReturn(PETSC_SUCCESS);
}
