/* A matrix of the rows of normal stress in a stiffness with opening. */
#include <petsc/private/petscimpl.h> /* methods */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipcells.h>
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatcommon.h>

typedef struct {
  Mat S;       /* referenced */
  Vec product; /* S u */
  Vec weights; /* weights of S's rows, borrowed from S; NULL: 1 */
  Vec there;   /* weights of the normal rows on the device; NULL: 1, or no device */
} NormalRows;

/* n_i = f_(3 i + 2) / w_i */
static PetscErrorCode Take(const NormalRows *r, Vec f, Vec n)
{
  const PetscReal *a, *w = NULL;
  PetscReal *b;
  PetscInt m;
  const SlipArrays arrays[] = {{f, .read = &a}, {r->weights, .read = &w}, {n, .write = &b}};
  const int start = 2, step = 3;
  SlipDeviceMemory from, to;
  SlipDevice device;
  int rows;

  PetscFunctionBegin;
  if (SlipDeviceVecIs(f) && SlipDeviceVecIs(n)) {
    PetscCall(SlipDeviceGet(&device));
    PetscCall(VecGetLocalSize(n, &m));
    rows = (int)m;
    PetscCall(SlipDeviceVecRead(f, &from));
    PetscCall(SlipDeviceVecWrite(n, &to));
    {
      const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(rows), SLIP_DEVICE_ARG(start), SLIP_DEVICE_ARG(step),
                                    SLIP_DEVICE_ARG(from), SLIP_DEVICE_ARG(to)};

      PetscCall(SlipDeviceRun(device, KERNEL_GATHER, (size_t)rows, 1, 5, args));
    }
    if (r->there) PetscCall(VecPointwiseDivide(n, n, r->there));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetLocalSize(n, &m));
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < m; i++) b[i] = a[3 * i + 2] / (w ? w[3 * i + 2] : 1);
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NormalRowsMult(Mat Kn, Vec u, Vec n)
{
  NormalRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(MatMult(r->S, u, r->product));
  PetscCall(Take(r, r->product, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MatSlipStiffnessMultBoth() of this type: it takes one product if K is the matrix of Kn's rows. */
static PetscErrorCode NormalRowsMultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n)
{
  NormalRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(MatMult(K, u, f));
  if (K == r->S)
    PetscCall(Take(r, f, n));
  else
    PetscCall(MatMult(Kn, u, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the matrix on the device; S is there as well. */
static PetscErrorCode NormalRowsDevice(Mat Kn, PetscBool use, PetscReal *bytes)
{
  const PetscReal *w;
  PetscReal *a, own;
  PetscBool there;
  NormalRows *r;
  VecType type;
  PetscInt m;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(MatGetLocalSize(Kn, &m, NULL));
  PetscCall(MatGetVecType(r->S, &type));
  PetscCall(PetscStrcmp(type, VECSLIPOPENCL, &there));
  PetscCall(SlipMatDeviceBytes(r->S, &own));
  if (there) own = 0;
  *bytes = own + (PetscReal)sizeof(PetscReal) * (PetscReal)m * (r->weights ? 4 : 3);
  if (!use) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipMatUseDevice(r->S));
  PetscCall(VecDestroy(&r->product));
  PetscCall(MatCreateVecs(r->S, NULL, &r->product));
  if (!r->weights) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCreate(PetscObjectComm((PetscObject)Kn), &r->there));
  PetscCall(VecSetSizes(r->there, m, PETSC_DETERMINE));
  PetscCall(VecSetType(r->there, VECSLIPOPENCL));
  PetscCall(VecGetArrayRead(r->weights, &w));
  PetscCall(VecGetArrayWrite(r->there, &a));
  for (PetscInt i = 0; i < m; i++) a[i] = w[3 * i + 2];
  PetscCall(VecRestoreArrayWrite(r->there, &a));
  PetscCall(VecRestoreArrayRead(r->weights, &w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NormalRowsDestroy(Mat Kn)
{
  NormalRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &r));
  PetscCall(VecDestroy(&r->product));
  PetscCall(VecDestroy(&r->there));
  PetscCall(MatDestroy(&r->S));
  PetscCall(PetscFree(r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix of the change of normal stress from a stiffness with slip and opening. S: stiffness of cells that
   open, 3 N x 3 N, of MatCreateSlipCellVectorStiffness() or MatCreateSlipDippingVectorStiffness(), of which Kn takes a
   reference; Kn: matrix [Pa/m], N x 3 N: every third row of S over its weight, the compression of a cell by slip and
   opening of all. Its product takes one product with S, and so does MatSlipStiffnessMultBoth(). MatScale() of S scales
   both. Errors: PETSC_ERR_ARG_SIZ for an S whose rows here are no multiple of 3. */
PetscErrorCode MatCreateSlipNormalRows(Mat S, Mat *Kn)
{
  const SlipShellOps ops = {
    .mult = NormalRowsMult, .destroy = NormalRowsDestroy, .device = NormalRowsDevice, .unsymmetric = PETSC_TRUE};
  NormalRows *r;
  PetscInt m, M;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(S, MAT_CLASSID, 1);
  PetscAssertPointer(Kn, 2);
  PetscCall(MatGetLocalSize(S, &m, NULL));
  PetscCall(MatGetSize(S, &M, NULL));
  PetscCheck(m % 3 == 0, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ,
             "The stiffness has %" PetscInt_FMT " rows here, expected three a cell", m);
  PetscCall(PetscNew(&r));
  r->S = S;
  PetscCall(PetscObjectReference((PetscObject)S));
  PetscCall(MatCreateVecs(S, NULL, &r->product));
  PetscCall(MatSlipGetWeights(S, &r->weights));
  PetscCall(SlipShellCreateOfSize(PetscObjectComm((PetscObject)S), m / 3, m, M / 3, M, "slipnormalrows", &ops, r, Kn));
  PetscCall(PetscObjectComposeFunction((PetscObject)*Kn, "MatSlipStiffnessMultBoth_C", NormalRowsMultBoth));
  PetscFunctionReturn(PETSC_SUCCESS);
}
