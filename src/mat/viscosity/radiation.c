/* Viscosity of type "slipradiation": eta diag(w), where w are the weights of the rows of K. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipmatcommon.h>
#include <slipstep/private/slipmatviscosity.h>

typedef struct {
  PetscReal eta;   /* impedance [Pa s/m] */
  PetscBool alike; /* eta is that of all components */
  Vec weights;     /* referenced, or times the ratio of another damping across cells; NULL: 1 */
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

/* Returns the memory, without weights that are those of K. */
static PetscErrorCode RadiationGetInfo(Mat H, MatInfoType flag, MatInfo *info)
{
  Radiation *r;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &r));
  PetscCall(MatGetLocalSize(H, &n, NULL));
  PetscCall(SlipInfoFill(H, r->weights && !r->alike ? (PetscReal)sizeof(PetscReal) * (PetscReal)n : 0, flag, info));
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

static PetscErrorCode RadiationDevice(Mat H, PetscBool use, PetscReal *bytes)
{
  Radiation *r;
  PetscInt n;
  Vec there;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &r));
  PetscCall(MatGetSize(H, &n, NULL));
  *bytes = r->weights ? (PetscReal)sizeof(PetscReal) * (PetscReal)n : 0;
  if (!use || !r->weights) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipVecCopyThere(r->weights, &there));
  PetscCall(VecDestroy(&r->weights));
  r->weights = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets eta of a viscosity of this type with one eta for all components, and 0 for others. */
PetscErrorCode SlipRadiationGet(Mat H, PetscReal *eta)
{
  PetscBool match;
  Radiation *r;

  PetscFunctionBegin;
  *eta = 0;
  PetscCall(PetscObjectTypeCompare((PetscObject)H, "slipradiation", &match));
  if (!match) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(H, &r));
  if (r->alike) *eta = r->eta;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatCreateSlipRadiation - creates radiation damping, the same viscosity for every cell

  Collective

  Input Parameters:
+ K   - stiffness, N x N
- eta - traction per slip rate [Pa s/m], positive: G/(2 cs) of waves that leave the fault (Rice 1993)

  Output Parameter:
. H - eta times the weights of K's rows (MatSlipGetWeights()), N x N [Pa s/m], with K's distribution and K's prefix for
      options

  Level: beginner

  Errors: PETSC_ERR_ARG_OUTOFRANGE for eta

.seealso: MatCreateSlipRadiationOpening(), MatCreateSlipViscosity(), MatCreateSlipStage()
@*/
PetscErrorCode MatCreateSlipRadiation(Mat K, PetscReal eta, Mat *H)
{
  PetscFunctionBegin;
  PetscCall(MatCreateSlipRadiationOpening(K, eta, 0, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates radiation damping of cells that open, in their plane and across it. K: stiffness with three components a
   cell, 3 N x 3 N; eta: traction per slip rate [Pa s/m], positive: G/(2 cs) of shear waves that leave the fault;
   across: pressure per rate of opening [Pa s/m], positive: (lambda + 2 G)/(2 cp) = rho cp/2 of compressional waves; 0:
   K has no opening, and all components have eta; H: diagonal, 3 N x 3 N [Pa s/m], times the weights of K's rows.
   Errors: PETSC_ERR_ARG_OUTOFRANGE for eta or across. */
PetscErrorCode MatCreateSlipRadiationOpening(Mat K, PetscReal eta, PetscReal across, Mat *H)
{
  const SlipShellOps ops = {.mult = RadiationMult,
                            .diagonal = RadiationGetDiagonal,
                            .info = RadiationGetInfo,
                            .destroy = RadiationDestroy,
                            .device = RadiationDevice};
  const char *prefix;
  Radiation *r;
  Vec own;
  PetscReal *w;
  PetscInt n;

  PetscFunctionBegin;
  PetscCheck(eta > 0 && PetscIsNormalReal(eta), PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_OUTOFRANGE,
             "Radiation damping must be positive and finite, not %g Pa s/m", (double)eta);
  PetscCheck(across == 0 || (across > 0 && PetscIsNormalReal(across)), PetscObjectComm((PetscObject)K),
             PETSC_ERR_ARG_OUTOFRANGE, "Radiation damping across cells must be positive and finite, not %g Pa s/m",
             (double)across);
  PetscCall(PetscNew(&r));
  r->eta = eta;
  r->alike = across == 0 ? PETSC_TRUE : PETSC_FALSE;
  if (across > 0) {
    PetscCall(MatSlipGetWeights(K, &own));
    PetscCall(MatCreateVecs(K, NULL, &r->weights));
    PetscCall(VecSet(r->weights, 1));
    if (own) PetscCall(VecCopy(own, r->weights));
    PetscCall(VecGetLocalSize(r->weights, &n));
    PetscCall(VecGetArray(r->weights, &w));
    for (PetscInt i = 2; i < n; i += 3) w[i] *= across / eta;
    PetscCall(VecRestoreArray(r->weights, &w));
  } else {
    PetscCall(MatSlipGetWeights(K, &r->weights));
    if (r->weights) PetscCall(PetscObjectReference((PetscObject)r->weights));
  }
  PetscCall(SlipShellCreateLike(K, "slipradiation", &ops, r, H));
  PetscCall(MatGetOptionsPrefix(K, &prefix));
  PetscCall(MatSetOptionsPrefix(*H, prefix));
  PetscCall(SlipNote(*H, "SlipWhy", "radiation as asked"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
