/* Reuse of products. An implicit step needs K u and H v of the states at which its stages ended, of the start of the
   next stage, which is a sum of these states, and of first guesses. Solvers have computed most of these products
   already, and their sums cost no product. images.c caches them. */
#include <slipstep/private/slipelastic.h>

/* Number of nested sums after which a product is computed anew: each adds rounding of 1e-16 of K u */
enum { oldest = 100 };

/* Stores that a slip is a sum of others, so that its product with K is the sum of their products. y: slip, equal to
   sum_i a[i] x[i] up to rounding [m]; a: factors [1, for slip rates s]; x: other slips or slip rates [m, m/s]. If the
   products of K with all terms but at most one are cached, the missing one is computed, the product with y is cached,
   and SlipElasticApply() finds it. A sum of three slips, two of which stages have found, costs one product. */
PetscErrorCode SlipElasticStoreSum(SlipElastic el, Vec y, PetscInt n, const PetscReal a[], const Vec x[])
{
  SlipElasticPair *pair;
  PetscInt missing = 0, last = 0, age = 0;
  Vec sum, product;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(SlipElasticFindPair(el, x[i], &pair));
    if (pair && pair->has[SLIP_ELASTIC_K])
      age = PetscMax(age, pair->age);
    else {
      missing++;
      last = i;
    }
  }
  if (missing > 1 || age >= oldest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticGetWork(el, 0, &sum));
  PetscCall(SlipElasticGetWork(el, 1, &product));
  if (missing) PetscCall(SlipElasticApply(el, x[last], product, NULL));
  PetscCall(VecZeroEntries(sum));
  for (PetscInt i = 0; i < n; i++) {
    PetscCall(SlipElasticFindPair(el, x[i], &pair));
    PetscCall(VecAXPY(sum, a[i], pair->image[SLIP_ELASTIC_K]));
  }
  PetscCall(SlipElasticTakePair(el, y, &pair));
  if (pair->has[SLIP_ELASTIC_K]) PetscFunctionReturn(PETSC_SUCCESS); /* from a product, or from fewer nested sums */
  PetscCall(SlipElasticSetImage(pair, SLIP_ELASTIC_K, sum));
  pair->age = age + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Caches the product of the stiffness with a slip, so that it need not be computed again. x: slip [m], or slip rate
   [m/s]; kx: K x [Pa], or [Pa/s], from an earlier product. */
PetscErrorCode SlipElasticStore(SlipElastic el, Vec x, Vec kx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(SlipElasticKeepImage(el, SLIP_ELASTIC_K, x, kx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += a w x, where w are the weights of the stiffness */
static PetscErrorCode AddWeighted(SlipElastic el, PetscReal a, Vec x, Vec y)
{
  Vec weights, work;

  PetscFunctionBegin;
  PetscCall(MatSlipGetWeights(el->K, &weights));
  if (!weights) {
    PetscCall(VecAXPY(y, a, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipElasticGetWork(el, 1, &work));
  PetscCall(VecPointwiseMult(work, weights, x));
  PetscCall(VecAXPY(y, a, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Caches the product of the stage operator with a slip rate. x: slip rate [m/s]; bx: (M/theta + df/dv + theta df/du) x
   [Pa]. K x and H x are cached then. That takes no product where the damping is radiation, and one with K otherwise. */
PetscErrorCode SlipElasticStoreStage(SlipElastic el, Vec x, Vec bx)
{
  SlipElasticPair *pair;
  PetscReal theta, eta;
  Vec rest, product;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (el->stage != el->B) PetscFunctionReturn(PETSC_SUCCESS); /* the medium is not static */
  PetscCall(MatSlipStageGetTheta(el->B, &theta));
  PetscCall(SlipRadiationGet(el->H, &eta));
  PetscCall(SlipElasticGetWork(el, 0, &rest));
  PetscCall(VecCopy(bx, rest));
  PetscCall(AddWeighted(el, -(el->inertia / theta + eta), x, rest));
  if (eta > 0) {
    PetscCall(SlipElasticTakePair(el, x, &pair));
    if (pair->has[SLIP_ELASTIC_K]) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(VecScale(rest, 1 / theta));
    PetscCall(SlipElasticSetImage(pair, SLIP_ELASTIC_K, rest));
    pair->theta = el->theta > 0 ? 1 / (1 / theta + 1 / el->theta) : theta; /* the first guess's error adds up */
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipElasticGetWork(el, 1, &product));
  PetscCall(SlipElasticApply(el, x, product, NULL));
  PetscCall(VecAXPY(rest, -theta, product));
  PetscCall(SlipElasticTakePair(el, x, &pair));
  if (!pair->has[SLIP_ELASTIC_H]) PetscCall(SlipElasticSetImage(pair, SLIP_ELASTIC_H, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the product of the stage operator with a slip rate. x: slip rate [m/s]; y: (M/theta + df/dv + theta df/du) x
   [Pa]; computed without a product where K x and H x are cached. */
PetscErrorCode SlipElasticApplyStage(SlipElastic el, Vec x, Vec y)
{
  Vec kx = NULL, hx = NULL;
  PetscReal theta, eta;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (el->stage == el->B) {
    PetscCall(SlipRadiationGet(el->H, &eta));
    PetscCall(SlipElasticFindImage(el, SLIP_ELASTIC_K, x, &kx));
    if (kx && !(eta > 0)) PetscCall(SlipElasticFindImage(el, SLIP_ELASTIC_H, x, &hx));
    if (!(eta > 0) && !hx) kx = NULL;
  }
  if (!kx) {
    PetscCall(MatMult(el->stage, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatSlipStageGetTheta(el->B, &theta));
  PetscCall(VecCopy(kx, y));
  PetscCall(VecScale(y, theta));
  PetscCall(AddWeighted(el, el->inertia / theta + eta, x, y));
  if (hx) PetscCall(VecAXPY(y, 1, hx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Deletes the cached products of a medium. Each run begins with this call, so that its results do not depend, in their
   last digits, on earlier runs. */
PetscErrorCode SlipElasticForget(SlipElastic el)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  el->npairs = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
