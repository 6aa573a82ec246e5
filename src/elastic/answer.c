/* The stress with which the medium responds to slip and slip rate, and the energy that it stores and loses. */
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipmatviscosity.h>
#include <string.h>
#include <slipstep/private/slipwork.h>

/*@
  SlipElasticForce - computes the stress with which the medium resists slip

  Collective; after SlipElasticSetUp()

  Input Parameters:
+ el - the medium
. t  - the time [s], not before the start of the last step
. u  - displacement relative to the far field [m]; `NULL`: shear is (df/dv) v alone
- v  - slip rate relative to the far field [m/s]; `NULL`: 0

  Output Parameters:
+ shear  - f(u, v, t), times the weights of the stiffness [Pa]; `NULL`: it is not computed
- normal - compression that u adds, one number per cell [Pa]; `NULL`: it is not computed

  Level: developer

  Note:
  A call with both outputs computes once what they have in common.

.seealso: SlipElasticApply(), SlipElasticStage()
@*/
PetscErrorCode SlipElasticForce(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  const SlipProducts before = SlipProductsNow();

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  SlipWorkBegin(SLIP_SHARE_PRODUCTS);
  PetscCall((*el->ops->force)(el, t, u, v, shear, normal));
  SlipWorkEnd();
  /* A type that multiplies by none of our matrices counts as one product; static may have cached the product. */
  if (u && strcmp(((PetscObject)el)->type_name, SLIPELASTICSTATIC) && SlipProductsNow().all == before.all)
    SlipProductsAdd((SlipProducts){.k = 1, .all = 1});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the damping of a slip rate, as accurately as a step needs it. v: slip rate relative to the far field [m/s];
   tolerance: allowed relative error in the 2-norm, dimensionless, not negative; stress: (df/dv) v, times the weights of
   the stiffness [Pa]. Only a square root that Lanczos' method applies uses the tolerance. It stores the rates of the
   last products, also in checkpoints, so that consecutive steps need few products with the stiffness:
   MatSlipViscosityAllow(). An error of 1e-4 changes the history of slip by 2e-5 to 4e-5, measured on the 3 km fault. */
PetscErrorCode SlipElasticViscous(SlipElastic el, Vec v, PetscReal tolerance, Vec stress)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(MatSlipViscosityAllow(el->H, tolerance));
  PetscCall((*el->ops->force)(el, el->past[1].t, NULL, v, stress, NULL));
  PetscCall(MatSlipViscosityAllow(el->H, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticStage - prepares the stage operator B = M/theta + df/dv + theta df/du

  Collective; after SlipElasticSetUp()

  Input Parameters:
+ el    - the medium
. t     - time of the stage's end [s]
- theta - factor of the slip rate in u = u0 + theta v, which holds in the stage [s]

  Level: developer

.seealso: SlipElasticGetStage()
@*/
PetscErrorCode SlipElasticStage(SlipElastic el, PetscReal t, PetscReal theta)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  el->theta = 0;
  PetscCall((*el->ops->stage)(el, t, theta, &el->stage, &el->coupling));
  PetscCall(SlipLogProducts(el->stage, SLIP_StageMult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticGetStage - gets the stage operator of the last SlipElasticStage()

  Not collective

  Input Parameter:
. el - the medium

  Output Parameters (each may be `NULL`):
+ B - M/theta + df/dv + theta df/du [Pa s/m], borrowed until the next stage
- C - change of normal stress by slip there [Pa/m], borrowed likewise; `NULL`: slip does not change it

  Level: developer

  Errors: PETSC_ERR_ORDER before a stage

.seealso: SlipElasticStage()
@*/
PetscErrorCode SlipElasticGetStage(SlipElastic el, Mat *B, Mat *C)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCheck(el->stage, PetscObjectComm((PetscObject)el), PETSC_ERR_ORDER, "call SlipElasticStage() first");
  if (B) *B = el->stage;
  if (C) *C = el->coupling;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the static stress of a slip. x: slip [m]; shear: K x, times the weights of the stiffness [Pa]; NULL: it is
   not computed; normal: compression that x adds [Pa]; NULL: it is not computed. Implicit steps cache products, so that
   another call with the same x computes none. */
PetscErrorCode SlipElasticApply(SlipElastic el, Vec x, Vec shear, Vec normal)
{
  Vec known = NULL;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (shear) PetscCall(SlipElasticFindImage(el, SLIP_ELASTIC_K, x, &known));
  if (known)
    PetscCall(VecCopy(known, shear));
  else if (shear && normal)
    PetscCall(MatSlipStiffnessMultBoth(el->K, el->Kn, x, shear, normal));
  else if (shear)
    PetscCall(MatMult(el->K, x, shear));
  if (normal && (known || !shear)) PetscCall(MatMult(el->Kn, x, normal));
  if (shear && !known) PetscCall(SlipElasticKeepImage(el, SLIP_ELASTIC_K, x, shear));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the stress on each cell of its own slip and slip rate. k: diagonal of K [Pa/m], borrowed; h: diagonal of df/dv
   [Pa s/m], borrowed. */
PetscErrorCode SlipElasticGetDiagonals(SlipElastic el, Vec *k, Vec *h)
{
  const Mat of[] = {el->K, el->H};
  Vec *out[] = {k, h};

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  for (int i = 0; i < 2; i++) {
    if (!out[i]) continue;
    if (!el->diagonal[i]) {
      PetscCall(MatCreateVecs(el->K, &el->diagonal[i], NULL));
      PetscCall(MatGetDiagonal(of[i], el->diagonal[i]));
    }
    *out[i] = el->diagonal[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the radiation damping of a medium. eta: impedance, if df/dv is eta times the weights of the stiffness [Pa s/m];
   0: df/dv is another matrix. */
PetscErrorCode SlipElasticGetImpedance(SlipElastic el, PetscReal *eta)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(SlipRadiationGet(el->H, eta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up over all processes what the operation of a type computes; the sum is 0 for a type without the operation. */
static PetscErrorCode Sum(SlipElastic el, PetscErrorCode (*op)(SlipElastic, PetscReal, Vec, PetscReal *), PetscReal t,
                          Vec u, PetscReal *sum)
{
  PetscFunctionBegin;
  *sum = 0;
  if (!op) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*op)(el, t, u, sum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)el)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticGetEnergy - computes the energy that a medium stores besides u.f(u, t)/2

  Collective

  Input Parameters:
+ el - the medium
. t  - the time [s]
- u  - displacement [m]

  Output Parameter:
. stored - sum over all cells [J/m^2]; 0 without history

  Level: developer

.seealso: SlipElasticGetPower(), SlipElasticForce()
@*/
PetscErrorCode SlipElasticGetEnergy(SlipElastic el, PetscReal t, Vec u, PetscReal *stored)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(Sum(el, el->ops->energy, t, u, stored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the power that a medium loses besides v.(df/dv) v. t: the time [s]; u: displacement [m]; v: slip rate, both
   relative to the far field [m/s]; lost: sum over all cells [W/m^2]; 0 without history. */
PetscErrorCode SlipElasticGetPower(SlipElastic el, PetscReal t, Vec u, Vec v, PetscReal *lost)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *lost = 0;
  if (!el->ops->power) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*el->ops->power)(el, t, u, v, lost));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, lost, 1, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)el)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
