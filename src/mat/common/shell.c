/* Common parts of our matrices: type name and conversion of shells to MATDENSE, and notes for views. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <stdarg.h>
#include <stdio.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatcommon.h>

/* Ends a conversion of A: returns dense, which the caller must not use any more, as MatConvert() needs it. */
PetscErrorCode SlipShellReplace(Mat A, Mat dense, MatReuse reuse, Mat *D)
{
  PetscFunctionBegin;
  if (reuse == MAT_INPLACE_MATRIX)
    PetscCall(MatHeaderReplace(A, &dense));
  else if (reuse == MAT_REUSE_MATRIX) {
    PetscCall(MatCopy(dense, *D, SAME_NONZERO_PATTERN));
    PetscCall(MatDestroy(&dense));
  } else
    *D = dense;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Converts by N products; for tests and for small sizes. */
static PetscErrorCode ShellToDense(Mat A, MatType type, MatReuse reuse, Mat *D)
{
  Mat dense;

  PetscFunctionBegin;
  (void)type;
  PetscCall(MatComputeOperator(A, MATDENSE, &dense));
  PetscCall(SlipShellReplace(A, dense, reuse, D));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a shell with m local of M rows and n local of N columns, symmetric and assembled unless ops say otherwise,
   and composes "MatConvert_<type>_dense_C"; it owns ctx, which its destroy operation frees. */
PetscErrorCode SlipShellCreateOfSize(MPI_Comm comm, PetscInt m, PetscInt n, PetscInt M, PetscInt N, const char type[],
                                     const SlipShellOps *ops, void *ctx, Mat *A)
{
  char name[64];

  PetscFunctionBegin;
  PetscCall(MatCreateShell(comm, m, n, M, N, ctx, A));
  PetscCall(MatShellSetManageScalingShifts(*A));
  PetscCall(MatShellSetOperation(*A, MATOP_MULT, SlipMatShellFn(ops->mult)));
  if (!ops->unsymmetric) PetscCall(MatShellSetOperation(*A, MATOP_MULT_TRANSPOSE, SlipMatShellFn(ops->mult)));
  if (ops->diagonal) PetscCall(MatShellSetOperation(*A, MATOP_GET_DIAGONAL, SlipMatShellFn(ops->diagonal)));
  PetscCall(MatShellSetOperation(*A, MATOP_DESTROY, SlipMatShellFn(ops->destroy)));
  if (ops->scale) PetscCall(MatShellSetOperation(*A, MATOP_SCALE, SlipMatShellFn(ops->scale)));
  if (ops->info) PetscCall(MatShellSetOperation(*A, MATOP_GETINFO, SlipMatShellFn(ops->info)));
  if (ops->view) PetscCall(MatShellSetOperation(*A, MATOP_VIEW, SlipMatShellFn(ops->view)));
  if (ops->state) PetscCall(PetscObjectComposeFunction((PetscObject)*A, SLIP_STATE_METHOD, ops->state));
  if (ops->device) PetscCall(PetscObjectComposeFunction((PetscObject)*A, SLIP_DEVICE_METHOD, ops->device));
  if (ops->device_mult) PetscCall(PetscObjectComposeFunction((PetscObject)*A, SLIP_DEVICE_MULT, ops->device_mult));
  if (ops->device_both) PetscCall(PetscObjectComposeFunction((PetscObject)*A, SLIP_DEVICE_BOTH, ops->device_both));
  PetscCall(PetscObjectChangeTypeName((PetscObject)*A, type));
  PetscCall(PetscSNPrintf(name, sizeof(name), "MatConvert_%s_dense_C", type));
  PetscCall(PetscObjectComposeFunction((PetscObject)*A, name, ShellToDense));
  PetscCall(MatSetOption(*A, MAT_SYMMETRIC, (PetscBool)!ops->unsymmetric));
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipShellCreateLike(Mat K, const char type[], const SlipShellOps *ops, void *ctx, Mat *A)
{
  PetscInt m, N;
  VecType vectors;

  PetscFunctionBegin;
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(MatGetLocalSize(K, &m, NULL));
  PetscCall(SlipShellCreateOfSize(PetscObjectComm((PetscObject)K), m, m, N, N, type, ops, ctx, A));
  PetscCall(MatGetVecType(K, &vectors)); /* on the device if K's are there */
  PetscCall(MatShellSetVecType(*A, vectors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipNote(Mat A, const char name[], const char format[], ...)
{
  char text[1024], *copy;
  va_list args;

  PetscFunctionBegin;
  va_start(args, format);
  (void)vsnprintf(text, sizeof(text), format, args);
  va_end(args);
  PetscCall(PetscStrallocpy(text, &copy));
  PetscCall(SlipObjectComposeData((PetscObject)A, name, copy, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the factor of H with it, from which a preconditioner computes the viscosity's symbol. */
PetscErrorCode SlipViscosityComposeFactor(Mat H, PetscReal factor)
{
  PetscReal *copy;

  PetscFunctionBegin;
  PetscCall(PetscNew(&copy));
  *copy = factor;
  PetscCall(SlipObjectComposeData((PetscObject)H, "SlipViscosityFactor", copy, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the factor of H = factor * sqrt(K) [sqrt(kg) / m]; 0 if H is zero or not of MatCreateSlipViscosity(). */
PetscErrorCode SlipViscosityGetFactor(Mat H, PetscReal *factor)
{
  const PetscReal *composed;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)H, "SlipViscosityFactor", &composed));
  *factor = composed ? *composed : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
