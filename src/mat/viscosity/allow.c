/* The tolerance of products with a viscosity that Lanczos' method applies; other types ignore these functions. */
#include <petsc/private/petscimpl.h> /* PetscTryMethod() */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>

/* Sets the error that the next products with a viscosity may have. H: viscosity of MatCreateSlipViscosity(), or any
   matrix; ignored unless Lanczos' method applies it, to the whole fault or to each wavenumber of a large grid;
   tolerance: relative error in the 2-norm, dimensionless; values not above MatSlipViscositySetTolerance() are ignored,
   so that 0 restores the usual error. Stored products remain valid. Only the part of a rate outside of their span is
   multiplied: the rates of an explicit scheme at its longest stable step, on the 3 km fault of 100 x 100 cells, take
   2.5, 4.4 and 16 products with the stiffness each at tolerances of 1e-3, 1e-4 and 1e-9. */
PetscErrorCode MatSlipViscosityAllow(Mat H, PetscReal tolerance)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscosityAllow_C", (Mat, PetscReal), (H, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the relative tolerance of products with a viscosity that Lanczos' method applies. H: viscosity of
   MatCreateSlipViscosity(); ignored unless Lanczos' method applies it; tolerance: error of a product, dimensionless,
   relative in the 2-norm, in (0, 1); 1e-8 by default. Option -mat_slipsqrtm_tolerance <1e-8>: the same, with the prefix
   of H. Errors: PETSC_ERR_ARG_OUTOFRANGE for the tolerance. */
PetscErrorCode MatSlipViscositySetTolerance(Mat H, PetscReal tolerance)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscositySetTolerance_C", (Mat, PetscReal), (H, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options of a viscosity again, with its prefix. H: viscosity of MatCreateSlipViscosity(), which has read
   them with the prefix of its stiffness. Option -mat_slipsqrtm_tolerance <1e-8>: relative error of products by Lanczos'
   method. */
PetscErrorCode MatSlipViscositySetFromOptions(Mat H)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscositySetFromOptions_C", (Mat), (H));
  PetscFunctionReturn(PETSC_SUCCESS);
}
