/* The object of a medium: its operations and its matrices, how they are set up, and how it is destroyed. */
#include <slipstep/private/slipelastic.h>
#include <slipstep/rooms/slipcells.h>
#include <slipstep/private/slipsys.h>

PetscClassId SLIP_ELASTIC_CLASSID = 0;
/*@C
  SlipElasticSetOps - sets the operations of a type of medium

  Logically collective; call it in the function that is passed to SlipElasticRegister()

  Input Parameters:
+ el   - the medium
. ops  - the operations, copied; where force or stage is NULL, that of static is used
- data - the type's own data; its destroy() frees it

  Level: advanced

  Errors: PETSC_ERR_ARG_WRONG for a medium with memory (advance) that has no visit, or that sets rests

.seealso: SlipElasticRegister(), SlipElasticGetData()
@*/
PetscErrorCode SlipElasticSetOps(SlipElastic el, const SlipElasticOps *ops, void *data)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCheck(!ops->advance || (ops->visit && !ops->rests), PetscObjectComm((PetscObject)el), PETSC_ERR_ARG_WRONG,
             "A medium that remembers (advance) needs visit too, and does not rest");
  el->ops[0] = *ops;
  el->data = data;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipElasticGetData - gets the data that a type has passed to SlipElasticSetOps()

  Not collective

  Input Parameter:
. el - the medium

  Output Parameter:
. data - address of a pointer that receives it

  Level: advanced

.seealso: SlipElasticSetOps()
@*/
PetscErrorCode SlipElasticGetData(SlipElastic el, void *data)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  *(void **)data = el->data;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticSetStiffness - sets the stiffness matrices of static slip

  Collective; before SlipElasticSetUp()

  Input Parameters:
+ el - the medium
. K  - symmetric stiffness [Pa/m]; the medium takes a reference
- Kn - compression that unit slip adds [Pa/m]; the medium takes a reference; `NULL`: slip adds none

  Level: advanced

.seealso: SlipElasticScale(), MatCreateSlipStiffness()
@*/
PetscErrorCode SlipElasticSetStiffness(SlipElastic el, Mat K, Mat Kn)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscValidHeaderSpecific(K, MAT_CLASSID, 2);
  PetscCall(PetscObjectReference((PetscObject)K));
  if (Kn) PetscCall(PetscObjectReference((PetscObject)Kn));
  PetscCall(MatDestroy(&el->K));
  PetscCall(MatDestroy(&el->Kn));
  el->K = K;
  el->Kn = Kn;
  PetscCall(SlipLogProducts(K, SLIP_StiffnessMult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies the stiffness of a medium by a factor. factor: factor of K and Kn, dimensionless. */
PetscErrorCode SlipElasticScale(SlipElastic el, PetscReal factor)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(MatScale(el->K, factor));
  if (el->Kn) PetscCall(MatScale(el->Kn, factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticSetUp - creates the viscosity and the stage operator of a medium

  Collective; after SlipElasticSetStiffness()

  Input Parameters:
+ el   - the medium
- rock - properties of the rock that the stiffness does not contain; copied as far as needed

  Level: advanced

.seealso: SlipElasticForce(), SlipElasticStage(), MatCreateSlipViscosity()
@*/
PetscErrorCode SlipElasticSetUp(SlipElastic el, const SlipElasticRock *rock)
{
  PetscBool radiation;
  PetscInt start, end;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  PetscCall(PetscStrcmp(rock->viscosity, "radiation", &radiation));
  if (radiation)
    PetscCall(MatCreateSlipRadiationOpening(el->K, rock->impedance, rock->across, &el->H));
  else
    PetscCall(MatCreateSlipViscosity(el->K, rock->mass, rock->zeta, rock->zeta > 0 ? rock->viscosity : "none", &el->H));
  PetscCall(MatSlipViscositySetTolerance(el->H, rock->tolerance));
  PetscCall(MatSlipViscositySetFromOptions(el->H)); /* the option of the viscosity overrides rock->tolerance */
  el->inertia = rock->inertia ? rock->mass : 0;
  PetscCall(MatCreateSlipStage(el->K, el->H, el->inertia, &el->B));
  PetscCall(MatSlipStageSetFromOptions(el->B));
  el->mass = rock->mass;
  el->components = rock->components;
  if (rock->order) {
    PetscCall(MatGetOwnershipRange(el->K, &start, &end));
    start /= el->components;
    end /= el->components;
    PetscCall(PetscFree(el->number));
    PetscCall(PetscMalloc1(end - start, &el->number));
    PetscCall(PetscArraycpy(el->number, rock->order + start, end - start));
  }
  if (el->ops->setup) PetscCall((*el->ops->setup)(el, rock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticGetMatrices - gets the matrices of a medium, for types of media and for callers that need entries

  Not collective

  Input Parameter:
. el - the medium

  Output Parameters (each may be `NULL`):
+ K  - stiffness [Pa/m], borrowed
. Kn - change of normal stress by slip [Pa/m], borrowed; `NULL`: slip does not change it
- H  - viscosity [Pa s/m], borrowed; `NULL` before SlipElasticSetUp()

  Level: advanced

.seealso: SlipElasticSetStiffness()
@*/
PetscErrorCode SlipElasticGetMatrices(SlipElastic el, Mat *K, Mat *Kn, Mat *H)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  if (K) *K = el->K;
  if (Kn) *Kn = el->Kn;
  if (H) *H = el->H;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipElasticDestroy - destroys a medium when its last reference is gone

  Collective

  Input Parameter:
. el - the medium; it is set to NULL

  Level: advanced

.seealso: SlipElasticCreate()
@*/
PetscErrorCode SlipElasticDestroy(SlipElastic *el)
{
  PetscFunctionBegin;
  if (*el) PetscValidHeaderSpecific(*el, SLIP_ELASTIC_CLASSID, 1);
  if (*el && --((PetscObject)*el)->refct == 0) {
    SlipElastic e = *el;

    if (e->ops->destroy) PetscCall((*e->ops->destroy)(e));
    for (int k = 0; k < 2; k++) {
      PetscCall(VecDestroy(&e->diagonal[k]));
      PetscCall(VecDestroy(&e->work[k]));
      PetscCall(VecDestroy(&e->past[k].u));
    }
    PetscCall(PetscFree(e->number));
    PetscCall(SlipElasticDestroyImages(e));
    PetscCall(MatDestroy(&e->B));
    PetscCall(MatDestroy(&e->H));
    PetscCall(MatDestroy(&e->K));
    PetscCall(MatDestroy(&e->Kn));
    PetscCall(PetscHeaderDestroy(el));
  }
  *el = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipElasticGetWork(SlipElastic el, PetscInt n, Vec *work)
{
  PetscFunctionBegin;
  if (!el->work[n]) PetscCall(MatCreateVecs(el->K, &el->work[n], NULL));
  *work = el->work[n];
  PetscFunctionReturn(PETSC_SUCCESS);
}
