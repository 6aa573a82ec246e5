/* Products on the device: how matrices are put there, and the memory that they need there. Dense matrices are PETSc's,
   so that this file replaces their products. */
#include <petsc/private/petscimpl.h> /* states */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatcommon.h>

/* ---- dense matrices ---- */

/* Groups of columns, whose sums are added at the end, because a device runs more work items than there are rows */
enum { COLUMNS_APART = 16 };

typedef struct {
  SlipDevice device;
  int m, n;                        /* rows and columns */
  PetscObjectState state;          /* state of the entries on the device */
  SlipDeviceMemory entries, parts; /* [n][m], [COLUMNS_APART][m] */
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
  PetscCall(PetscObjectStateGet((PetscObject)A, &now));
  if (now != d->state) PetscCall(DensePut(A, d)); /* it was scaled or filled again */
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
  PetscCall(PetscObjectComposeFunction((PetscObject)A, SLIP_DEVICE_MULT, DenseMult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all of them ---- */

/* Puts nothing on the device: MatCreateVecs() creates vectors there, which PETSc multiplies there. */
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

/* ---- products by where the vectors are ---- */

/* If the device is the processor, as with pocl, nothing is put there: our products for the processor compute in the
   memory of the vectors, which are lent to them. */
#define ROUTES "SlipProductRoutes"
typedef struct {
  PetscErrorCode (*here)(Mat, Vec, Vec), (*there)(Mat, Vec, Vec); /* on the processor, and on the device */
  PetscErrorCode (*both_here)(Mat, Mat, Vec, Vec, Vec), (*both_there)(Mat, Mat, Vec, Vec, Vec); /* with K and Kn */
} Routes;

static PetscErrorCode RoutedMult(Mat A, Vec x, Vec y)
{
  const Vec there[] = {x, y};
  Vec here[2];
  Routes *r;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)A, ROUTES, &r));
  if (!SlipDeviceVecIs(x) || !SlipDeviceVecIs(y))
    PetscCall((*r->here)(A, x, y));
  else if (r->there)
    PetscCall((*r->there)(A, x, y));
  else {
    PetscCall(SlipDeviceVecsLend(2, 1, there, here));
    PetscCall((*r->here)(A, here[0], here[1]));
    PetscCall(SlipDeviceVecsReturn(2, there, here));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RoutedBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n)
{
  const Vec there[] = {u, f, n};
  Vec here[3];
  Routes *k, *r;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)K, ROUTES, &k));
  PetscCall(SlipObjectQueryData((PetscObject)Kn, ROUTES, &r));
  if (!k || !SlipDeviceVecIs(u) || !SlipDeviceVecIs(f) || !SlipDeviceVecIs(n))
    PetscCall((*r->both_here)(K, Kn, u, f, n));
  else if (r->both_there)
    PetscCall((*r->both_there)(K, Kn, u, f, n));
  else {
    PetscCall(SlipDeviceVecsLend(3, 1, there, here));
    PetscCall((*r->both_here)(K, Kn, here[0], here[1], here[2]));
    PetscCall(SlipDeviceVecsReturn(3, there, here));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Has vectors on the device multiplied there, or lent to the processor. Matrices without a product for the device use
   operations of vectors, which compute where these are. */
static PetscErrorCode Route(Mat A, PetscBool lends)
{
  Routes *r;

  PetscFunctionBegin;
  PetscCall(PetscNew(&r));
  PetscCall(SlipObjectComposeData((PetscObject)A, ROUTES, r, SlipContainerDestroyDefault));
  if (!lends) {
    PetscCall(PetscObjectQueryFunction((PetscObject)A, SLIP_DEVICE_MULT, &r->there));
    PetscCall(PetscObjectQueryFunction((PetscObject)A, SLIP_DEVICE_BOTH, &r->both_there));
  }
  if (lends || r->there) PetscCall(SlipLogProductsReplace(A, RoutedMult, &r->here));
  PetscCall(PetscObjectQueryFunction((PetscObject)A, "MatSlipStiffnessMultBoth_C", &r->both_here));
  if (r->both_here && (lends || r->both_there))
    PetscCall(PetscObjectComposeFunction((PetscObject)A, "MatSlipStiffnessMultBoth_C", RoutedBoth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipMatGetDiagonal(Mat A, Vec *stored, Vec d)
{
  PetscFunctionBegin;
  if (!SlipDeviceVecIs(d)) {
    PetscCall(MatGetDiagonal(A, d));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!*stored) {
    PetscCall(VecDuplicate(d, stored));
    PetscCall(MatGetDiagonal(A, *stored));
  }
  PetscCall(VecCopy(*stored, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the memory that products with A need, or will need, on the device besides vectors [bytes]. Memory that two
   matrices share counts for both. */
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
  Moves products of A with vectors of type VECSLIPOPENCL, which MatCreateVecs() then creates, to the device, which must
  be open. Other products do not change. The data of products is sent now, after a check that the device has room.
  Further calls do nothing.
*/
PetscErrorCode SlipMatUseDevice(Mat A)
{
  PetscErrorCode (*method)(Mat, PetscBool, PetscReal *);
  PetscReal bytes;
  SlipDevice device;
  Routes *used;
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCall(Find(A, &method));
  PetscCall(SlipObjectQueryData((PetscObject)A, ROUTES, &used));
  if (used) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceGet(&device));
  PetscCheck(device, PetscObjectComm((PetscObject)A), PETSC_ERR_ORDER, "No device is open for products");
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)A), &size));
  PetscCheck(size == 1, PetscObjectComm((PetscObject)A), PETSC_ERR_SUP,
             "products on a device are of one process: expected 1, not %d", (int)size);
  if (!SlipDeviceShares(device)) {
    PetscCall(SlipMatDeviceBytes(A, &bytes));
    PetscCall(SlipDeviceReserve(device, (size_t)bytes, "products"));
    PetscCall((*method)(A, PETSC_TRUE, &bytes));
  }
  PetscCall(Route(A, SlipDeviceShares(device)));
  PetscCall(MatSetVecType(A, VECSLIPOPENCL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
