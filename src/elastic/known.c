/* Products that need not be made. An implicit step asks for K u and H v of the states that its stages have found, of
   the start of the next stage, which is a sum of those, and of first guesses. Solvers have made most of these
   products already, and sums of them cost nothing (images.c). */
#include <slipstep/private/slipelastic.h>

/* Sums of sums, after which a product is made anew: rounding adds up, by 1e-16 of K u each */
enum { oldest = 100 };

/*@C
  SlipElasticStoreSum - tell a medium that a slip is the sum of others

  Collective; after SlipElasticStage()

  Input Parameters:
+ el - the medium
. y  - slip, sum_i a[i] x[i] to rounding [m]
. n  - number of terms, >= 1
. a  - factors [1, or s of slip rates]
- x  - other slips or slip rates [m, m/s]

  Level: developer

  Note:
  Where the products of K with the terms are known, or all but one, which is then made, that with y is known too, and
  SlipElasticApply() finds it. Of three slips, say, one product is made where the others have been found by stages.

.seealso: SlipElasticStoreStage(), SlipElasticApply()
@*/
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
  if (pair->has[SLIP_ELASTIC_K]) PetscFunctionReturn(PETSC_SUCCESS); /* by a product, or one that is younger */
  PetscCall(SlipElasticSetImage(pair, SLIP_ELASTIC_K, sum));
  pair->age = age + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticStore - tell a medium what its stiffness makes of a slip, that asking for it again takes no product

  Collective

  Input Parameters:
+ el - the medium
. x  - slip [m], or slip rate [m/s]
- kx - K x [Pa], or [Pa/s], by a product of before

  Level: developer

.seealso: SlipElasticStoreSum(), SlipElasticApply()
@*/
PetscErrorCode SlipElasticStore(SlipElastic el, Vec x, Vec kx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(SlipElasticKeepImage(el, SLIP_ELASTIC_K, x, kx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += a w x, w the weights of the stiffness */
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

/*@
  SlipElasticStoreStage - tell a medium what its stage operator has made of a slip rate

  Collective; after SlipElasticStage()

  Input Parameters:
+ el - the medium
. x  - slip rate [m/s]
- bx - (M/theta + df/dv + theta df/du) x [Pa]

  Level: developer

  Note:
  K x and H x are known then, with radiation for the damping without a product, else with one of K.

.seealso: SlipElasticApplyStage(), SlipElasticStoreSum()
@*/
PetscErrorCode SlipElasticStoreStage(SlipElastic el, Vec x, Vec bx)
{
  SlipElasticPair *pair;
  PetscReal theta, eta;
  Vec rest, product;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (el->stage != el->B) PetscFunctionReturn(PETSC_SUCCESS); /* of another medium than static */
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
    pair->theta = el->theta > 0 ? 1 / (1 / theta + 1 / el->theta) : theta; /* that of the first guess adds to it */
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipElasticGetWork(el, 1, &product));
  PetscCall(SlipElasticApply(el, x, product, NULL));
  PetscCall(VecAXPY(rest, -theta, product));
  PetscCall(SlipElasticTakePair(el, x, &pair));
  if (!pair->has[SLIP_ELASTIC_H]) PetscCall(SlipElasticSetImage(pair, SLIP_ELASTIC_H, rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticApplyStage - what the stage operator makes of a slip rate

  Collective; after SlipElasticStage()

  Input Parameters:
+ el - the medium
- x  - slip rate [m/s]

  Output Parameter:
. y - (M/theta + df/dv + theta df/du) x [Pa]; without a product where K x and H x are known

  Level: developer

.seealso: SlipElasticStage(), SlipElasticStoreStage()
@*/
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

/*@
  SlipElasticForget - forget the products that a medium has remembered

  Logically collective

  Input Parameter:
. el - the medium

  Level: developer

  Note:
  A run begins so, as its last digits are to be those of the same run before.

.seealso: SlipElasticStoreStage()
@*/
PetscErrorCode SlipElasticForget(SlipElastic el)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  el->npairs = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
