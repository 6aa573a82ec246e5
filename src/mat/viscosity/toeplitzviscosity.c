/* Viscosity of type "sliptoeplitz": the square root on an endless plane, mirrored at the free surface, see
   toeplitz_root.c. Its error is a few per cent along the fault's edges; a product costs as much as one of K. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

typedef struct {
  Mat K; /* referenced: owns the plane */
  SlipToeplitz plane;
  PetscReal factor; /* factor of the unscaled kernel's root */
} PlaneContext;

static PetscErrorCode PlaneMult(Mat H, Vec x, Vec y)
{
  PlaneContext *c;
  const SlipToeplitzSymbol *root;
  const PetscReal *diagonal;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  PetscCall(SlipToeplitzGetRoot(c->plane, &root, &diagonal)); /* forms it at first use */
  PetscCall(SlipToeplitzMult(c->plane, c->factor, &c->plane->root, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PlaneGetDiagonal(Mat H, Vec d)
{
  PlaneContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  PetscCall(SlipToeplitzGetRootDiagonal(c->plane, c->factor, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PlaneDestroy(Mat H)
{
  PlaneContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  PetscCall(MatDestroy(&c->K));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipViscosityCreate_Plane(Mat K, PetscReal factor, Mat *H)
{
  const SlipShellOps ops = {.mult = PlaneMult, .diagonal = PlaneGetDiagonal, .destroy = PlaneDestroy};
  PlaneContext *c;
  const SlipGrid *grid;
  PetscReal scale;

  PetscFunctionBegin;
  PetscCall(SlipGridOf(K, &grid));
  PetscCheck(grid, PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_WRONG,
             "A toeplitz viscosity needs a stiffness on a uniform grid; for other stiffnesses use sqrtm");
  PetscCall(PetscNew(&c));
  PetscCall(PetscObjectReference((PetscObject)K));
  c->K = K;
  PetscCall(SlipToeplitzOf(K, &c->plane));
  PetscCall(SlipGridScale(K, &scale));
  c->factor = factor * PetscSqrtReal(scale);
  PetscCall(SlipShellCreateLike(K, "sliptoeplitz", &ops, c, H));
  PetscCall(MatSetOption(*H, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
