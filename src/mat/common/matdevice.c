/* Products on the device: what matrices of ours need there, and how they are asked for them. A dense one is PETSc's, so
   that its products are replaced here. */
#include <petsc/private/petscimpl.h> /* states */
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatcommon.h>

/* ---- dense matrices ---- */

/* Groups of columns, which are summed up at the end: a card has more work than there are rows */
enum { COLUMNS_APART = 16 };

typedef struct {
  SlipDevice device;
  PetscErrorCode (*mult)(Mat, Vec, Vec); /* of others than vectors on the device */
  int m, n;                              /* rows and columns */
  PetscObjectState state;                /* of the entries that are there */
  SlipDeviceMemory entries, parts;       /* [n][m], [COLUMNS_APART][m] */
} DenseOnDevice;
#define DENSE "SlipDenseOnDevice"

static PetscErrorCode DenseDestroy(SlipContainerArg arg)
{
  DenseOnDevice *d = (DenseOnDevice *)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  PetscCall(SlipDeviceFree(d->device, &d->entries));
  PetscCall(SlipDeviceFree(d->device, &d->parts));
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DensePut(Mat A, DenseOnDevice *d)
{
  const PetscScalar *a;
  PetscScalar *copy;
  PetscInt lda;

  PetscFunctionBegin;
  PetscCall(PetscObjectStateGet((PetscObject)A, &d->state));
  PetscCall(MatDenseGetLDA(A, &lda));
  PetscCall(MatDenseGetArrayRead(A, &a));
  PetscCall(PetscMalloc1((size_t)d->m * (size_t)d->n, &copy));
  for (PetscInt j = 0; j < d->n; j++)
    PetscCall(PetscArraycpy(copy + (size_t)j * (size_t)d->m, a + (size_t)j * (size_t)lda, d->m));
  PetscCall(SlipDevicePut(d->device, (size_t)d->m * (size_t)d->n, copy, d->entries));
  PetscCall(PetscFree(copy));
  PetscCall(MatDenseRestoreArrayRead(A, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DenseMult(Mat A, Vec x, Vec y)
{
  const int apart = COLUMNS_APART;
  SlipDeviceMemory from, to;
  PetscObjectState now;
  DenseOnDevice *d;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, DENSE, &d));
  if (!SlipDeviceVecIs(x) || !SlipDeviceVecIs(y)) {
    PetscCall((*d->mult)(A, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectStateGet((PetscObject)A, &now));
  if (now != d->state) PetscCall(DensePut(A, d)); /* scaled, or filled anew */
  PetscCall(SlipDeviceVecRead(x, &from));
  PetscCall(SlipDeviceVecWrite(y, &to));
  {
    const SlipDeviceArg parts[] = {SLIP_DEVICE_ARG(d->m),       SLIP_DEVICE_ARG(d->n), SLIP_DEVICE_ARG(apart),
                                   SLIP_DEVICE_ARG(d->entries), SLIP_DEVICE_ARG(from), SLIP_DEVICE_ARG(d->parts)};
    const SlipDeviceArg sum[] = {SLIP_DEVICE_ARG(d->m), SLIP_DEVICE_ARG(apart), SLIP_DEVICE_ARG(d->parts),
                                 SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_DENSE_PARTS, (size_t)d->m, COLUMNS_APART, 6, parts));
    PetscCall(SlipDeviceRun(d->device, KERNEL_DENSE_SUM, (size_t)d->m, 1, 4, sum));
  }
  PetscCall(PetscLogFlops(2 * (PetscLogDouble)d->m * (PetscLogDouble)d->n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DenseDevice(Mat A, PetscBool use, PetscReal *bytes)
{
  DenseOnDevice *d;
  PetscInt m, n;
  size_t size;

  PetscFunctionBegin;
  PetscCall(MatGetSize(A, &m, &n));
  size = sizeof(PetscReal) * (size_t)m;
  *bytes = (PetscReal)size * (PetscReal)(n + COLUMNS_APART);
  if (!use) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&d));
  PetscCall(SlipObjectComposeData((PetscObject)A, DENSE, d, DenseDestroy));
  PetscCall(SlipDeviceGet(&d->device));
  d->m = (int)m;
  d->n = (int)n;
  PetscCall(SlipDeviceAllocate(d->device, size * (size_t)n, "the stiffness", &d->entries));
  PetscCall(SlipDeviceAllocate(d->device, size * COLUMNS_APART, "the stiffness", &d->parts));
  PetscCall(DensePut(A, d));
  PetscCall(SlipLogProductsReplace(A, DenseMult, &d->mult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all of them ---- */

/* MatCreateVecs() makes vectors of the device, whose products are formed there. */
static PetscErrorCode DiagonalDevice(Mat A, PetscBool use, PetscReal *bytes)
{
  PetscFunctionBegin;
  (void)A;
  (void)use;
  *bytes = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Find(Mat A, PetscErrorCode (**device)(Mat, PetscBool, PetscReal *))
{
  PetscBool dense, constant;
  MatType type;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATSEQDENSE, &dense));
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATCONSTANTDIAGONAL, &constant));
  PetscCall(PetscObjectQueryFunction((PetscObject)A, SLIP_DEVICE_METHOD, device));
  if (dense) *device = DenseDevice;
  if (constant) *device = DiagonalDevice;
  PetscCall(MatGetType(A, &type));
  PetscCheck(*device, PetscObjectComm((PetscObject)A), PETSC_ERR_SUP,
             "products with a matrix of type %s are not formed on a device (-fault_device)", type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A device that is the processor, as pocl is, has none of that: vectors are lent to the processor's own products, which
   are written for it. */
#define LENDS "SlipLendsToProcessor"
typedef struct {
  PetscErrorCode (*mult)(Mat, Vec, Vec);
} Lends;

static PetscErrorCode LentMult(Mat A, Vec x, Vec y)
{
  const Vec there[] = {x, y};
  Vec here[2];
  Lends *l;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, LENDS, &l));
  if (!SlipDeviceVecIs(x) || !SlipDeviceVecIs(y)) {
    PetscCall((*l->mult)(A, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipDeviceVecsLend(2, 1, there, here));
  PetscCall((*l->mult)(A, here[0], here[1]));
  PetscCall(SlipDeviceVecsReturn(2, there, here));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is x lent to the processor for products with A? */
PetscErrorCode SlipMatLends(Mat A, Vec x, PetscBool *lends)
{
  Lends *l;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, LENDS, &l));
  *lends = (PetscBool)(l && SlipDeviceVecIs(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What products with A need, or will need, on the device [bytes], beside their vectors; what two matrices share counts
   with both */
PetscErrorCode SlipMatDeviceBytes(Mat A, PetscReal *bytes)
{
  PetscErrorCode (*method)(Mat, PetscBool, PetscReal *);
  SlipDevice device;

  PetscFunctionBegin;
  PetscCall(Find(A, &method));
  PetscCall((*method)(A, PETSC_FALSE, bytes));
  PetscCall(SlipDeviceGet(&device));
  if (device && SlipDeviceShares(device)) *bytes = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  From now on vectors that MatCreateVecs() makes are of type VECSLIPOPENCL, and products with those are formed on the
  device, which is open; others as before. What products need is put there now, after the device was asked for room.
  Again does nothing.
*/
PetscErrorCode SlipMatUseDevice(Mat A)
{
  PetscErrorCode (*method)(Mat, PetscBool, PetscReal *);
  PetscReal bytes;
  SlipDevice device;
  Lends *lends;
  PetscBool *used;
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCall(Find(A, &method));
  PetscCall(SlipObjectQueryData((PetscObject)A, "SlipUsesDevice", &used));
  if (used) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceGet(&device));
  PetscCheck(device, PetscObjectComm((PetscObject)A), PETSC_ERR_ORDER, "No device is open for products");
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)A), &size));
  PetscCheck(size == 1, PetscObjectComm((PetscObject)A), PETSC_ERR_SUP,
             "products on a device are of one process: expected 1, not %d", (int)size);
  if (SlipDeviceShares(device)) {
    PetscCall(PetscNew(&lends));
    PetscCall(SlipObjectComposeData((PetscObject)A, LENDS, lends, SlipContainerDestroyDefault));
    PetscCall(SlipLogProductsReplace(A, LentMult, &lends->mult));
  } else {
    PetscCall(SlipMatDeviceBytes(A, &bytes));
    PetscCall(SlipDeviceReserve(device, (size_t)bytes, "products"));
    PetscCall((*method)(A, PETSC_TRUE, &bytes));
  }
  PetscCall(MatSetVecType(A, VECSLIPOPENCL));
  PetscCall(PetscNew(&used));
  *used = PETSC_TRUE;
  PetscCall(SlipObjectComposeData((PetscObject)A, "SlipUsesDevice", used, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
