/* The matrix-free generalised Jacobian against its definition, and the names under which its parts are composed. */
#include "ranks.h"
#include "../sliders.h"

enum { blocks = 11 };

static PetscReal entry(PetscInt i, PetscInt j, PetscInt n)
{
  return i == j ? 4.0 : 1.0 / (1.0 + PetscAbsInt(i - j));
}

/* J e_j, entry by entry: all sums have one term, so equality is to the rounding of one addition */
static PetscErrorCode CheckColumn(Mat J, PetscInt j, const PetscReal mask[], const PetscReal slope[])
{
  Vec e, y, d;
  PetscInt first, last;
  const PetscScalar *a, *b;

  PetscCall(MatCreateVecs(J, &e, &y));
  PetscCall(VecDuplicate(y, &d));
  PetscCall(VecSetValue(e, j, 1.0, INSERT_VALUES));
  PetscCall(VecAssemble(e));
  PetscCall(MatMult(J, e, y));
  PetscCall(MatGetDiagonal(J, d));
  PetscCall(VecGetOwnershipRange(y, &first, &last));
  a = VecRead(y);
  b = VecRead(d);
  for (PetscInt i = first; i < last; i++) {
    PetscReal expected = mask[i] * entry(i, j, blocks) * mask[j];

    if (i == j) expected += slope[i] * mask[i] + 1.0 - mask[i];
    Check(PetscAbsReal(a[i - first] - expected) < 1e-14, "J(%" PetscInt_FMT ",%" PetscInt_FMT ") is %g instead of %g",
          i, j, (double)a[i - first], (double)expected);
    Check(i != j || PetscAbsReal(b[i - first] - expected) < 1e-14, "diagonal %" PetscInt_FMT " is %g", i,
          (double)b[i - first]);
  }
  return DestroyObjects(&e, &y, &d);
}

static PetscErrorCode Run(void)
{
  Sliders p;
  Mat J, B;
  Vec m, s, mask, slope;
  PetscReal ms[blocks], ss[blocks];
  PetscBool same;

  PetscCall(SlipStepInitializePackage());
  PetscCall(SlidersCreate(PETSC_COMM_WORLD, blocks, entry, 1.0, 0.0, &p));
  PetscCall(DuplicateVecs(p.bound, &mask, &slope));
  for (PetscInt i = 0; i < blocks; i++) {
    PetscInt first, last;

    ms[i] = i % 3 ? 1.0 : 0.0;
    ss[i] = -0.1 * i;
    PetscCall(VecGetOwnershipRange(mask, &first, &last));
    if (i < first || i >= last) continue;
    PetscCall(VecSetValue(mask, i, ms[i], INSERT_VALUES));
    PetscCall(VecSetValue(slope, i, ss[i], INSERT_VALUES));
  }
  PetscCall(VecAssemble(mask));
  PetscCall(VecAssemble(slope));
  PetscCall(MatCreateSlipJacobian(p.K, &J));
  PetscCall(MatSlipJacobianSetParts(J, p.K, mask, slope));
  PetscCall(PetscObjectTypeCompare((PetscObject)J, MATSLIPJACOBIAN, &same));
  Check(same, "the type is not %s", MATSLIPJACOBIAN);
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipStageOperator", (PetscObject *)&B));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipMask", (PetscObject *)&m));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipSlope", (PetscObject *)&s));
  Check(B == p.K && m == mask && s == slope, "the parts are not composed");
  for (PetscInt j = 0; j < blocks; j++) PetscCall(CheckColumn(J, j, ms, ss));
  PetscCall(DestroyObjects(&J, &mask, &slope));
  return SlidersDestroy(&p);
}

SLIP_RANKS(Run)
