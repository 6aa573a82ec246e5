/* How exact products with a viscosity are that Lanczos' method applies; other types have no such method. */
#include <petsc/private/petscimpl.h> /* PetscTryMethod() */
#include <slipmat.h>
#include <slipcompat.h>

/*@
  MatSlipViscosityAllow - the error that the next products with a viscosity may have

  Logically collective

  Input Parameters:
+ H         - viscosity of MatCreateSlipViscosity(), or any matrix; nothing happens to those that are not applied by
              Lanczos' method, to all of a fault or to each wavenumber of a large grid
- tolerance - relative, in the 2-norm, dimensionless; where it is not above MatSlipViscositySetTolerance() it does not
              count, so that 0 ends it

  Level: developer

  Note:
  What is remembered of products before is kept. Of a rate only what they do not span is multiplied: those of the steps
  of an explicit scheme at its limit, on the 3 km fault of 100 x 100 cells, take 2.5, 4.4 and 16 products with the
  stiffness each at tolerances of 1e-3, 1e-4 and 1e-9.

.seealso: MatSlipViscositySetTolerance(), SlipElasticViscous()
@*/
PetscErrorCode MatSlipViscosityAllow(Mat H, PetscReal tolerance)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscosityAllow_C", (Mat, PetscReal), (H, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipViscositySetTolerance - relative tolerance of the products with a viscosity that Lanczos' method applies

  Logically collective

  Input Parameters:
+ H         - viscosity of MatCreateSlipViscosity(); nothing happens to those that are not applied by Lanczos' method
- tolerance - error of a product, dimensionless, relative in the 2-norm, in (0, 1); 1e-8 unless set

  Options Database Key:
. -mat_slipsqrtm_tolerance <1e-8> - the same, with the prefix of H

  Errors: PETSC_ERR_ARG_OUTOFRANGE for the tolerance

  Level: intermediate

.seealso: MatSlipViscositySetFromOptions(), MatCreateSlipViscosity(), MatCreateSlipCellStiffness()
@*/
PetscErrorCode MatSlipViscositySetTolerance(Mat H, PetscReal tolerance)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscositySetTolerance_C", (Mat, PetscReal), (H, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipViscositySetFromOptions - read the options of a viscosity again, with its prefix

  Collective

  Input Parameter:
. H - viscosity of MatCreateSlipViscosity(), which has read them once, with the prefix of its stiffness

  Options Database Key:
. -mat_slipsqrtm_tolerance <1e-8> - relative error of products by Lanczos' method

  Level: intermediate

.seealso: MatSlipViscositySetTolerance(), MatSetOptionsPrefix()
@*/
PetscErrorCode MatSlipViscositySetFromOptions(Mat H)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscositySetFromOptions_C", (Mat), (H));
  PetscFunctionReturn(PETSC_SUCCESS);
}
