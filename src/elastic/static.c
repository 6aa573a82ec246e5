/* The medium "static": elastic stress follows slip at once, f = K u + H v; H is a viscosity or radiation damping. */
#include <slipstep/private/slipelastic.h>

/*@
  SlipElasticForceStatic - computes the stress of a static medium, to which other types of media add theirs

  Collective; after SlipElasticSetUp()

  Input Parameters:
+ el - the medium, of any type
. t  - the time, not used [s]
. u  - displacement [m]; `NULL`: shear is H v alone, and normal does not change
- v  - slip rate [m/s]; `NULL`: 0, which is allowed only with u

  Output Parameters:
+ shear  - K u + H v [Pa]; `NULL`: it is not computed
- normal - Kn u [Pa]; `NULL`: it is not computed

  Level: advanced

.seealso: SlipElasticSetOps(), SlipElasticForce()
@*/
PetscErrorCode SlipElasticForceStatic(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  Vec damping;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(el, SLIP_ELASTIC_CLASSID, 1);
  (void)t;
  if (u) PetscCall(SlipElasticApply(el, u, shear, normal));
  if (!v || !shear) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticFindImage(el, SLIP_ELASTIC_H, v, &damping));
  if (!damping) {
    PetscCall(SlipElasticGetWork(el, 0, &damping));
    PetscCall(MatMult(el->H, v, damping));
  }
  if (u)
    PetscCall(VecAXPY(shear, 1, damping));
  else
    PetscCall(VecCopy(damping, shear));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Stage_Static(SlipElastic el, PetscReal t, PetscReal theta, Mat *B, Mat *C)
{
  PetscFunctionBegin;
  (void)t;
  PetscCall(MatSlipStageSetTheta(el->B, theta));
  *B = el->B;
  *C = el->Kn;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipElasticOps SlipElasticStatic = {.force = SlipElasticForceStatic, .stage = Stage_Static, .rests = PETSC_TRUE};
