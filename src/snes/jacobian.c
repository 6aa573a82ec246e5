/* The generalised Jacobian of the natural map, matrix-free: rows of B where sliding, identity where sticking. */
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>

/* The parts are composed with the Mat under these names, where the PC "slipstage" finds them. */
static const char key_B[] = "SlipStageOperator", key_mask[] = "SlipMask", key_slope[] = "SlipSlope",
                  key_cross[] = "SlipCross";

typedef struct {
  Vec work[2]; /* masked input, product */
  Mat B;       /* the parts, borrowed, so that thousands of products need not look up names */
  Vec mask, slope;
  Vec cross; /* borrowed; NULL: one component a cell */
  Mat C;     /* coupling, borrowed; NULL: the normal rows of B */
  Vec row;   /* factors of its rows, borrowed; NULL: the Jacobian is symmetric */
  Vec cx;    /* C (m x) */
} SlipJacobian;

/* Gets the context of a Mat whose parts are set. */
static PetscErrorCode SlipJacobianGet(Mat J, SlipJacobian **jac)
{
  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, jac));
  PetscCheck((*jac)->B && (*jac)->mask && (*jac)->slope, PetscObjectComm((PetscObject)J), PETSC_ERR_ORDER,
             "Call MatSlipJacobianSetParts() before using a %s matrix", MATSLIPJACOBIAN);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAddCoupling(Mat C, Vec row, Vec x, Vec cx, Vec y)
{
  const PetscReal *a, *f;
  PetscReal *yy;
  PetscInt n, m;
  const SlipArrays arrays[] = {{cx, .read = &a}, {row, .read = &f}, {y, .write = &yy}};

  PetscFunctionBegin;
  PetscCall(MatMult(C, x, cx));
  PetscCall(VecGetLocalSize(cx, &m));
  PetscCall(VecGetLocalSize(y, &n));
  if (n == m) {
    PetscCall(VecPointwiseMult(cx, cx, row));
    PetscCall(VecAXPY(y, 1.0, cx));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < n; i++) yy[i] += f[i] * a[i / 2];
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAddPressure(Vec row, Vec z, Vec x, Vec rho, Vec y)
{
  const PetscReal *f, *a, *b = NULL, *p = NULL;
  PetscReal *yy;
  PetscInt n;
  const SlipArrays arrays[] = {
    {row, .read = &f}, {z == y ? NULL : z, .read = &a}, {y, .write = &yy}, {x, .read = &b}, {rho, .read = &p}};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(y, &n));
  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < n; i += 3) {
    const PetscReal change = (z == y ? yy : a)[i + 2] - (x ? b[i + 2] / p[i + 2] : 0);

    for (PetscInt k = i; k < i + 2; k++) yy[k] += f[k] * change;
  }
  PetscCall(SlipArraysRestore(5, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipAddCross(Vec cross, Vec mask, Vec x, Vec y)
{
  const PetscReal *c, *m, *xx;
  PetscReal *yy;
  PetscInt n, block;
  const SlipArrays arrays[] = {{cross, .read = &c}, {mask, .read = &m}, {x, .read = &xx}, {y, .write = &yy}};

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(cross, &n));
  PetscCall(VecGetLocalSize(x, &block));
  block /= PetscMax(n, 1);
  PetscCall(SlipArraysGet(4, arrays));
  for (PetscInt i = 0, k = 0; i < n; i++, k += block) {
    if (m[k] == 0.0) continue;
    yy[k] += c[i] * xx[k + 1];
    yy[k + 1] += c[i] * xx[k];
  }
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = B (m x) + d x where m is not 0, and y = x elsewhere, with B (m x) in work[1]. */
static PetscErrorCode MatMult_SlipJacobian(Mat J, Vec x, Vec y)
{
  SlipJacobian *jac;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipJacobianGet(J, &jac));
  PetscCall(VecPointwiseMult(jac->work[0], jac->mask, x));
  PetscCall(MatMult(jac->B, jac->work[0], jac->work[1]));
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(SlipLoopRun(SLIP_LOOP_MASKED_SUM, n, NULL, (const Vec[]){jac->mask, jac->slope, x, jac->work[1], y}, NULL));
  if (jac->cross) PetscCall(SlipAddCross(jac->cross, jac->mask, x, y));
  if (jac->C)
    PetscCall(SlipAddCoupling(jac->C, jac->row, jac->work[0], jac->cx, y));
  else if (jac->row)
    PetscCall(SlipAddPressure(jac->row, jac->work[1], NULL, NULL, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MatGetDiagonal_SlipJacobian(Mat J, Vec diag)
{
  SlipJacobian *jac;
  PetscInt n;
  const PetscScalar *m, *d;
  PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(SlipJacobianGet(J, &jac));
  PetscCall(MatGetDiagonal(jac->B, diag));
  PetscCall(VecGetLocalSize(diag, &n));
  const SlipArrays arrays[] = {{jac->mask, .read = &m}, {jac->slope, .read = &d}, {diag, .write = &v}};

  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < n; i++) v[i] = m[i] != 0.0 ? v[i] + d[i] : 1.0;
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MatDestroy_SlipJacobian(Mat J)
{
  SlipJacobian *jac;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &jac));
  for (PetscInt i = 0; i < 2; i++) PetscCall(VecDestroy(&jac->work[i]));
  PetscCall(VecDestroy(&jac->cx));
  PetscCall(PetscFree(jac));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the generalised Jacobian of a stage's natural map as a symmetric matrix-free Mat. B: the stage operator, N x
   N, symmetric; J: (J y)_i = m_i [B (m y)]_i + d_i m_i y_i + (1 - m_i) y_i; its parts must be set before use. */
PetscErrorCode MatCreateSlipJacobian(Mat B, Mat *J)
{
  SlipJacobian *jac;
  PetscInt m, n, M, N;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(B, MAT_CLASSID, 1);
  PetscAssertPointer(J, 2);
  PetscCall(PetscNew(&jac));
  PetscCall(MatCreateVecs(B, &jac->work[0], &jac->work[1]));
  PetscCall(MatGetLocalSize(B, &m, &n));
  PetscCall(MatGetSize(B, &M, &N));
  PetscCall(MatCreateShell(PetscObjectComm((PetscObject)B), m, n, M, N, jac, J));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT, SlipMatShellFn(MatMult_SlipJacobian)));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT_TRANSPOSE, SlipMatShellFn(MatMult_SlipJacobian)));
  PetscCall(MatShellSetOperation(*J, MATOP_GET_DIAGONAL, SlipMatShellFn(MatGetDiagonal_SlipJacobian)));
  PetscCall(MatShellSetOperation(*J, MATOP_DESTROY, SlipMatShellFn(MatDestroy_SlipJacobian)));
  PetscCall(MatSetOption(*J, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*J, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  PetscCall(PetscObjectChangeTypeName((PetscObject)*J, MATSLIPJACOBIAN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the operator, sliding set and slope of a generalised Jacobian. J: from MatCreateSlipJacobian(); B: the stage
   operator [Pa s/m for the fault]; mask: 1 where a cell slides, 0 where it sticks; slope: diagonal that the bound adds
   where sliding, same units as B. The Mat takes references. Call this again after a change of their values, so that
   preconditioners are set up anew. */
PetscErrorCode MatSlipJacobianSetParts(Mat J, Mat B, Vec mask, Vec slope)
{
  SlipJacobian *jac;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(J, MAT_CLASSID, 1);
  PetscCall(MatShellGetContext(J, &jac));
  if (B != jac->B) PetscCall(PetscObjectCompose((PetscObject)J, key_B, (PetscObject)B));
  if (mask != jac->mask) PetscCall(PetscObjectCompose((PetscObject)J, key_mask, (PetscObject)mask));
  if (slope != jac->slope) PetscCall(PetscObjectCompose((PetscObject)J, key_slope, (PetscObject)slope));
  jac->B = B;
  jac->mask = mask;
  jac->slope = slope;
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscObjectStateIncrease((PetscObject)J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the off-diagonal entries of d, which is a symmetric block for a cell with two components. */
PetscErrorCode MatSlipJacobianSetCross(Mat J, Vec cross)
{
  SlipJacobian *jac;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &jac));
  if (cross != jac->cross) PetscCall(PetscObjectCompose((PetscObject)J, key_cross, (PetscObject)cross));
  jac->cross = cross;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets B (m x) of the last product in all rows, borrowed. */
PetscErrorCode MatSlipJacobianGetProduct(Mat J, Vec *product)
{
  SlipJacobian *jac;

  PetscFunctionBegin;
  PetscCall(SlipJacobianGet(J, &jac));
  *product = jac->work[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds row (C (m x)) to products, so that J is not symmetric any more; row is 0 where a cell sticks. */
PetscErrorCode MatSlipJacobianSetCoupling(Mat J, Mat C, Vec row)
{
  SlipJacobian *jac;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(J, &jac));
  if (row && !jac->row) {
    PetscCall(MatSetOption(J, MAT_SYMMETRY_ETERNAL, PETSC_FALSE));
    PetscCall(MatSetOption(J, MAT_SYMMETRIC, PETSC_FALSE));
  }
  if (C && !jac->cx) PetscCall(MatCreateVecs(C, NULL, &jac->cx));
  jac->C = C;
  jac->row = row;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the parts of a generalised Jacobian. J: from MatCreateSlipJacobian(); B: the stage operator, borrowed; mask: 1
   where a cell slides, 0 where it sticks, borrowed; slope: diagonal that the bound adds, borrowed. Errors:
   PETSC_ERR_ORDER before MatSlipJacobianSetParts(). */
PetscErrorCode MatSlipJacobianGetParts(Mat J, Mat *B, Vec *mask, Vec *slope)
{
  SlipJacobian *jac;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(J, MAT_CLASSID, 1);
  PetscCall(SlipJacobianGet(J, &jac));
  *B = jac->B;
  *mask = jac->mask;
  *slope = jac->slope;
  PetscFunctionReturn(PETSC_SUCCESS);
}
