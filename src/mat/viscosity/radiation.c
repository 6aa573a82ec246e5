/* Viscosity of type "slipradiation": eta diag(w), w the weights of the rows of K. */
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

typedef struct {
  PetscReal eta; /* [Pa s/m] */
  Vec weights;   /* referenced; NULL: 1 */
} Radiation;

static PetscErrorCode RadiationMult(Mat H, Vec x, Vec y)
{
  Radiation *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &r));
  if (r->weights)
    PetscCall(VecPointwiseMult(y, r->weights, x));
  else
    PetscCall(VecCopy(x, y));
  PetscCall(VecScale(y, r->eta));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RadiationGetDiagonal(Mat H, Vec d)
{
  Radiation *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &r));
  PetscCall(VecSet(d, r->eta));
  if (r->weights) PetscCall(VecPointwiseMult(d, d, r->weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RadiationDestroy(Mat H)
{
  Radiation *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &r));
  PetscCall(VecDestroy(&r->weights));
  PetscCall(PetscFree(r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* eta of a viscosity of this type, 0 of others */
PetscErrorCode SlipRadiationGet(Mat H, PetscReal *eta)
{
  PetscBool match;
  Radiation *r;

  PetscFunctionBegin;
  *eta = 0;
  PetscCall(PetscObjectTypeCompare((PetscObject)H, "slipradiation", &match));
  if (!match) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(H, &r));
  *eta = r->eta;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatCreateSlipRadiation - radiation damping, the same viscosity for every cell

  Collective

  Input Parameters:
+ K   - stiffness, N x N
- eta - traction that a slip rate costs [Pa s/m], positive: G/(2 cs) of waves that leave the fault (Rice 1993)

  Output Parameter:
. H - eta times the weights of K's rows (MatSlipGetWeights()), N x N [Pa s/m], with K's distribution and K's prefix for
      options

  Level: beginner

  Errors: PETSC_ERR_ARG_OUTOFRANGE for eta

.seealso: MatCreateSlipViscosity(), MatCreateSlipStage()
@*/
PetscErrorCode MatCreateSlipRadiation(Mat K, PetscReal eta, Mat *H)
{
  const SlipShellOps ops = {.mult = RadiationMult, .diagonal = RadiationGetDiagonal, .destroy = RadiationDestroy};
  const char *prefix;
  Radiation *r;

  PetscFunctionBegin;
  PetscCheck(eta > 0 && PetscIsNormalReal(eta), PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_OUTOFRANGE,
             "Radiation damping must be positive and finite, not %g Pa s/m", (double)eta);
  PetscCall(PetscNew(&r));
  r->eta = eta;
  PetscCall(MatSlipGetWeights(K, &r->weights));
  if (r->weights) PetscCall(PetscObjectReference((PetscObject)r->weights));
  PetscCall(SlipShellCreateLike(K, "slipradiation", &ops, r, H));
  PetscCall(MatGetOptionsPrefix(K, &prefix));
  PetscCall(MatSetOptionsPrefix(*H, prefix));
  PetscCall(SlipNote(*H, "SlipWhy", "radiation as asked"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
