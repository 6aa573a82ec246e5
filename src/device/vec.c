/* VECSLIPOPENCL: a vector on the device, with a mirror on the processor. It is a VECSEQ whose array is the mirror. The
   operations that integrators and controllers need are computed on the device; all others are VECSEQ's own, which
   access the array by VecGetArray() and similar functions of this file. */
#include <petsc/private/vecimpl.h>
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipsys.h>

/* Which of mirror and device are valid */
enum { MIRROR = 1, DEVICE = 2 };

/* Composed with the vector, as its data are VECSEQ's */
typedef struct {
  SlipDevice device;
  SlipDeviceMemory memory;
  PetscScalar *array; /* the mirror */
  int valid;
} VecOnDevice;
#define DATA "SlipDeviceVec"

static struct _VecOps seq; /* operations of VECSEQ */

static PetscErrorCode VecGetArray_SlipOpenCL(Vec x, PetscScalar **a);

PetscBool SlipDeviceVecIs(Vec x)
{
  return x && x->ops->getarray == VecGetArray_SlipOpenCL ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the data of a vector of this type. */
static VecOnDevice *Data(Vec x)
{
  VecOnDevice *v = NULL;

  (void)SlipObjectQueryData((PetscObject)x, DATA, &v);
  return v;
}

/* ---- where the numbers are ---- */

static PetscErrorCode ToDevice(Vec x)
{
  VecOnDevice *v = Data(x);

  PetscFunctionBegin;
  if (!(v->valid & DEVICE)) PetscCall(SlipDevicePut(v->device, (size_t)x->map->n, v->array, v->memory));
  v->valid |= DEVICE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ToMirror(Vec x)
{
  VecOnDevice *v = Data(x);

  PetscFunctionBegin;
  if (!(v->valid & MIRROR)) PetscCall(SlipDeviceFetch(v->device, (size_t)x->map->n, v->memory, v->array));
  v->valid |= MIRROR;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceVecRead(Vec x, SlipDeviceMemory *memory)
{
  PetscFunctionBegin;
  PetscCall(ToDevice(x));
  *memory = Data(x)->memory;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceVecChange(Vec x, SlipDeviceMemory *memory)
{
  PetscFunctionBegin;
  PetscCall(ToDevice(x));
  PetscCall(SlipDeviceVecWrite(x, memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceVecWrite(Vec x, SlipDeviceMemory *memory)
{
  VecOnDevice *v = Data(x);

  PetscFunctionBegin;
  v->valid = DEVICE;
  *memory = v->memory;
  PetscCall(PetscObjectStateIncrease((PetscObject)x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecGetArray_SlipOpenCL(Vec x, PetscScalar **a)
{
  PetscFunctionBegin;
  PetscCall(ToMirror(x));
  Data(x)->valid = MIRROR;
  *a = Data(x)->array;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecGetArrayRead_SlipOpenCL(Vec x, const PetscScalar **a)
{
  PetscFunctionBegin;
  PetscCall(ToMirror(x));
  *a = Data(x)->array;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecGetArrayWrite_SlipOpenCL(Vec x, PetscScalar **a)
{
  PetscFunctionBegin;
  Data(x)->valid = MIRROR;
  *a = Data(x)->array;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecRestoreArray_SlipOpenCL(Vec x, PetscScalar **a)
{
  PetscFunctionBegin;
  (void)x;
  if (a) *a = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecRestoreArrayRead_SlipOpenCL(Vec x, const PetscScalar **a)
{
  PetscFunctionBegin;
  (void)x;
  if (a) *a = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecPlaceArray_SlipOpenCL(Vec x, const PetscScalar *a)
{
  PetscFunctionBegin;
  (void)a;
  SETERRQ(PetscObjectComm((PetscObject)x), PETSC_ERR_SUP, "an array cannot be placed in a vector of type %s",
          VECSLIPOPENCL);
}

static PetscErrorCode VecResetArray_SlipOpenCL(Vec x)
{
  PetscFunctionBegin;
  PetscCall(VecPlaceArray_SlipOpenCL(x, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums of vectors ---- */

/* Computes y = c z + the sum of m vectors times their factors; all are of this type, and z may be y. */
static PetscErrorCode Combine(Vec y, PetscReal c, Vec z, PetscInt m, const PetscReal a[], const Vec x[])
{
  VecOnDevice *v = Data(y);
  const int n = (int)y->map->n;
  SlipDeviceMemory to, from, term[4];
  PetscReal factor[4];

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(c == 0 ? x[0] : z, &from));
  for (PetscInt j = 0; j == 0 || j < m; j += 4) {
    const int here = (int)PetscMin(4, m - j);

    for (PetscInt k = 0; k < 4; k++) {
      term[k] = from;
      factor[k] = k < here ? a[j + k] : 0;
      if (k < here) PetscCall(SlipDeviceVecRead(x[j + k], &term[k]));
    }
    PetscCall(SlipDeviceVecWrite(y, &to));
    if (j) {
      c = 1;
      from = to;
    }
    {
      const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),         SLIP_DEVICE_ARG(to),        SLIP_DEVICE_ARG(c),
                                    SLIP_DEVICE_ARG(from),      SLIP_DEVICE_ARG(here),      SLIP_DEVICE_ARG(factor[0]),
                                    SLIP_DEVICE_ARG(term[0]),   SLIP_DEVICE_ARG(factor[1]), SLIP_DEVICE_ARG(term[1]),
                                    SLIP_DEVICE_ARG(factor[2]), SLIP_DEVICE_ARG(term[2]),   SLIP_DEVICE_ARG(factor[3]),
                                    SLIP_DEVICE_ARG(term[3])};

      PetscCall(SlipDeviceRun(v->device, KERNEL_COMBINE, (size_t)n, 1, 13, args));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Changes all entries by a kernel with one number; `all` are written without being read. */
static PetscErrorCode Entries(SlipDeviceKernel kernel, PetscBool all, Vec x, PetscScalar a)
{
  const int n = (int)x->map->n;
  SlipDeviceMemory to;

  PetscFunctionBegin;
  PetscCall(all ? SlipDeviceVecWrite(x, &to) : SlipDeviceVecChange(x, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(a), SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(Data(x)->device, kernel, (size_t)n, 1, 3, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecSet_SlipOpenCL(Vec x, PetscScalar a)
{
  return Entries(KERNEL_SET, PETSC_TRUE, x, a);
}

static PetscErrorCode VecShift_SlipOpenCL(Vec x, PetscScalar a)
{
  return Entries(KERNEL_SHIFT, PETSC_FALSE, x, a);
}

static PetscErrorCode VecReciprocal_SlipOpenCL(Vec x)
{
  return Entries(KERNEL_RECIPROCAL, PETSC_FALSE, x, 1);
}

static PetscErrorCode VecCopy_SlipOpenCL(Vec x, Vec y)
{
  SlipDeviceMemory from, to;

  PetscFunctionBegin;
  if (!SlipDeviceVecIs(y)) {
    PetscCall((*seq.copy)(x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (x == y) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceVecRead(x, &from));
  PetscCall(SlipDeviceVecWrite(y, &to));
  PetscCall(SlipDeviceCopy(Data(x)->device, (size_t)x->map->n, from, to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecScale_SlipOpenCL(Vec x, PetscScalar a)
{
  PetscFunctionBegin;
  PetscCall(a == 0 ? VecSet_SlipOpenCL(x, 0) : Combine(x, a, x, 0, NULL, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecAXPY_SlipOpenCL(Vec y, PetscScalar a, Vec x)
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceVecIs(x) ? Combine(y, 1, y, 1, &a, &x) : (*seq.axpy)(y, a, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecAXPBY_SlipOpenCL(Vec y, PetscScalar a, PetscScalar b, Vec x)
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceVecIs(x) ? Combine(y, b, y, 1, &a, &x) : (*seq.axpby)(y, a, b, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecAYPX_SlipOpenCL(Vec y, PetscScalar b, Vec x)
{
  const PetscScalar one = 1;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecIs(x) ? Combine(y, b, y, 1, &one, &x) : (*seq.aypx)(y, b, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecWAXPY_SlipOpenCL(Vec w, PetscScalar a, Vec x, Vec y)
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceVecIs(x) && SlipDeviceVecIs(y) ? Combine(w, 1, y, 1, &a, &x) : (*seq.waxpy)(w, a, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecAXPBYPCZ_SlipOpenCL(Vec z, PetscScalar a, PetscScalar b, PetscScalar c, Vec x, Vec y)
{
  const PetscScalar factor[] = {a, b};
  const Vec term[] = {x, y};

  PetscFunctionBegin;
  if (SlipDeviceVecIs(x) && SlipDeviceVecIs(y))
    PetscCall(Combine(z, c, z, 2, factor, term));
  else
    PetscCall((*seq.axpbypcz)(z, a, b, c, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecMAXPY_SlipOpenCL(Vec y, PetscInt m, const PetscScalar a[], Vec x[])
{
  PetscBool ours = PETSC_TRUE;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < m; k++)
    if (!SlipDeviceVecIs(x[k])) ours = PETSC_FALSE;
  if (m) PetscCall(ours ? Combine(y, 1, y, m, a, x) : (*seq.maxpy)(y, m, a, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes w from x and y by a kernel of three arrays. */
static PetscErrorCode Pointwise(SlipDeviceKernel kernel, Vec w, Vec x, Vec y)
{
  const int n = (int)w->map->n;
  SlipDeviceMemory a, b, to;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(x, &a));
  PetscCall(SlipDeviceVecRead(y, &b));
  PetscCall(SlipDeviceVecWrite(w, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(a), SLIP_DEVICE_ARG(b), SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(Data(w)->device, kernel, (size_t)n, 1, 4, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecPointwiseMult_SlipOpenCL(Vec w, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (SlipDeviceVecIs(x) && SlipDeviceVecIs(y))
    PetscCall(Pointwise(KERNEL_MULTIPLY, w, x, y));
  else
    PetscCall((*seq.pointwisemult)(w, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecPointwiseDivide_SlipOpenCL(Vec w, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (SlipDeviceVecIs(x) && SlipDeviceVecIs(y))
    PetscCall(Pointwise(KERNEL_DIVIDE, w, x, y));
  else
    PetscCall((*seq.pointwisedivide)(w, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies component `start` of the blocks of x to y, or back from y to x. */
static PetscErrorCode Stride(SlipDeviceKernel kernel, Vec x, PetscInt start, Vec y)
{
  const int n = (int)y->map->n, step = (int)x->map->bs, first = (int)start;
  SlipDeviceMemory many, one;

  PetscFunctionBegin;
  if (kernel == KERNEL_GATHER) {
    PetscCall(SlipDeviceVecRead(x, &many));
    PetscCall(SlipDeviceVecWrite(y, &one));
  } else {
    PetscCall(SlipDeviceVecRead(y, &one));
    PetscCall(SlipDeviceVecChange(x, &many));
  }
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),
                                  SLIP_DEVICE_ARG(first),
                                  SLIP_DEVICE_ARG(step),
                                  {sizeof(many), kernel == KERNEL_GATHER ? &many : &one},
                                  {sizeof(many), kernel == KERNEL_GATHER ? &one : &many}};

    PetscCall(SlipDeviceRun(Data(x)->device, kernel, (size_t)n, 1, 5, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecStrideGather_SlipOpenCL(Vec x, PetscInt start, Vec y, InsertMode mode)
{
  PetscFunctionBegin;
  if (SlipDeviceVecIs(y) && mode == INSERT_VALUES)
    PetscCall(Stride(KERNEL_GATHER, x, start, y));
  else
    PetscCall((*seq.stridegather)(x, start, y, mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecStrideScatter_SlipOpenCL(Vec y, PetscInt start, Vec x, InsertMode mode)
{
  PetscFunctionBegin;
  if (SlipDeviceVecIs(x) && mode == INSERT_VALUES)
    PetscCall(Stride(KERNEL_SCATTER, x, start, y));
  else
    PetscCall((*seq.stridescatter)(y, start, x, mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- numbers ---- */

/* Computes a result of x and y by a kernel of both. */
static PetscErrorCode Number(SlipDeviceKernel kernel, Vec x, Vec y, PetscReal *result)
{
  const int n = (int)x->map->n;
  SlipDeviceMemory a, b;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(x, &a));
  PetscCall(SlipDeviceVecRead(y, &b));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(a), SLIP_DEVICE_ARG(b)};

    PetscCall(SlipDeviceReduce(Data(x)->device, kernel, (size_t)n, 3, args, 1, 1, result));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecDot_SlipOpenCL(Vec x, Vec y, PetscScalar *dot)
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceVecIs(y) ? Number(KERNEL_DOT, x, y, dot) : (*seq.dot)(x, y, dot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecMDot_SlipOpenCL(Vec x, PetscInt m, const Vec y[], PetscScalar dot[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < m; k++) PetscCall(VecDot_SlipOpenCL(x, y[k], &dot[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { NORMS = 4 }; /* the sums of x, |x| and x^2, and the largest |x| */

/* Computes results of x by a kernel, of which the first are sums. */
static PetscErrorCode Results(SlipDeviceKernel kernel, Vec x, PetscInt n_results, PetscInt sums, PetscReal result[])
{
  const int n = (int)x->map->n;
  SlipDeviceMemory a;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(x, &a));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(a)};

    PetscCall(SlipDeviceReduce(Data(x)->device, kernel, (size_t)n, 2, args, n_results, sums, result));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecNorm_SlipOpenCL(Vec x, NormType type, PetscReal *norm)
{
  PetscReal result[NORMS];

  PetscFunctionBegin;
  PetscCall(Results(KERNEL_NORMS, x, NORMS, 3, result));
  if (type == NORM_1 || type == NORM_1_AND_2) *norm = result[1];
  if (type == NORM_2 || type == NORM_FROBENIUS) *norm = PetscSqrtReal(result[2]);
  if (type == NORM_1_AND_2) norm[1] = PetscSqrtReal(result[2]);
  if (type == NORM_INFINITY) *norm = result[3];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the smallest entry, -infinity if one is NaN; its place is found on the mirror. */
static PetscErrorCode VecMin_SlipOpenCL(Vec x, PetscInt *place, PetscReal *least)
{
  PetscReal result;

  PetscFunctionBegin;
  if (place) {
    PetscCall((*seq.min)(x, place, least));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Results(KERNEL_LEAST, x, 1, 0, &result));
  *least = -result;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecSum_SlipOpenCL(Vec x, PetscScalar *sum)
{
  PetscReal result[NORMS];

  PetscFunctionBegin;
  PetscCall(Results(KERNEL_NORMS, x, NORMS, 3, result));
  *sum = result[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipVecSame(Vec x, Vec y, PetscBool *same)
{
  const PetscScalar *a, *b;
  PetscReal differ;

  PetscFunctionBegin;
  if (!SlipDeviceVecIs(x) || !SlipDeviceVecIs(y)) {
    PetscCall(VecGetArrayRead(x, &a));
    PetscCall(VecGetArrayRead(y, &b));
    PetscCall(PetscArraycmp(a, b, x->map->n, same));
    PetscCall(VecRestoreArrayRead(y, &b));
    PetscCall(VecRestoreArrayRead(x, &a));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Number(KERNEL_DIFFER, x, y, &differ));
  *same = differ == 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipVecCopyThere(Vec x, Vec *there)
{
  SlipDeviceMemory memory;

  PetscFunctionBegin;
  PetscCall(VecCreate(PetscObjectComm((PetscObject)x), there));
  PetscCall(VecSetSizes(*there, x->map->n, x->map->N));
  PetscCall(VecSetBlockSize(*there, x->map->bs));
  PetscCall(VecSetType(*there, VECSLIPOPENCL));
  PetscCall(VecCopy(x, *there));
  PetscCall(SlipDeviceVecRead(*there, &memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the type ---- */

static PetscErrorCode Destroy(SlipContainerArg arg)
{
  VecOnDevice *v = (VecOnDevice *)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  PetscCall(SlipDeviceFree(v->device, &v->memory));
  PetscCall(PetscFree(v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecDuplicate_SlipOpenCL(Vec x, Vec *y)
{
  PetscFunctionBegin;
  PetscCall(VecCreate(PetscObjectComm((PetscObject)x), y));
  PetscCall(PetscLayoutReference(x->map, &(*y)->map));
  PetscCall(VecSetType(*y, VECSLIPOPENCL));
  (*y)->stash.ignorenegidx = x->stash.ignorenegidx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecDuplicateVecs_SlipOpenCL(Vec x, PetscInt m, Vec *y[])
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(m, y));
  for (PetscInt k = 0; k < m; k++) PetscCall(VecDuplicate(x, *y + k));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VecDestroyVecs_SlipOpenCL(PetscInt m, Vec x[])
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < m; k++) PetscCall(VecDestroy(&x[k]));
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void FillOps(struct _VecOps *ops)
{
  ops->duplicate = VecDuplicate_SlipOpenCL;
  ops->duplicatevecs = VecDuplicateVecs_SlipOpenCL;
  ops->destroyvecs = VecDestroyVecs_SlipOpenCL;
  ops->getarray = VecGetArray_SlipOpenCL;
  ops->getarrayread = VecGetArrayRead_SlipOpenCL;
  ops->getarraywrite = VecGetArrayWrite_SlipOpenCL;
  ops->restorearray = ops->restorearraywrite = VecRestoreArray_SlipOpenCL;
  ops->restorearrayread = VecRestoreArrayRead_SlipOpenCL;
  ops->placearray = ops->replacearray = VecPlaceArray_SlipOpenCL;
  ops->resetarray = VecResetArray_SlipOpenCL;
  ops->set = VecSet_SlipOpenCL;
  ops->copy = VecCopy_SlipOpenCL;
  ops->scale = VecScale_SlipOpenCL;
  ops->axpy = VecAXPY_SlipOpenCL;
  ops->axpby = VecAXPBY_SlipOpenCL;
  ops->aypx = VecAYPX_SlipOpenCL;
  ops->waxpy = VecWAXPY_SlipOpenCL;
  ops->axpbypcz = VecAXPBYPCZ_SlipOpenCL;
  ops->maxpy = VecMAXPY_SlipOpenCL;
  ops->pointwisemult = VecPointwiseMult_SlipOpenCL;
  ops->pointwisedivide = VecPointwiseDivide_SlipOpenCL;
  ops->stridegather = VecStrideGather_SlipOpenCL;
  ops->stridescatter = VecStrideScatter_SlipOpenCL;
  ops->dot = ops->tdot = ops->dot_local = ops->tdot_local = VecDot_SlipOpenCL;
  ops->mdot = ops->mtdot = ops->mdot_local = ops->mtdot_local = VecMDot_SlipOpenCL;
  ops->min = VecMin_SlipOpenCL;
  ops->shift = VecShift_SlipOpenCL;
  ops->reciprocal = VecReciprocal_SlipOpenCL;
  ops->norm = ops->norm_local = VecNorm_SlipOpenCL;
  ops->sum = VecSum_SlipOpenCL;
}

static PetscErrorCode VecCreate_SlipOpenCL(Vec x)
{
  SlipDevice device;
  VecOnDevice *v;
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCall(SlipDeviceGet(&device));
  PetscCheck(device, PetscObjectComm((PetscObject)x), PETSC_ERR_ORDER, "no device is open for a vector of type %s",
             VECSLIPOPENCL);
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)x), &size));
  PetscCheck(size == 1, PetscObjectComm((PetscObject)x), PETSC_ERR_SUP, "a vector of type %s is on one process, not %d",
             VECSLIPOPENCL, (int)size);
  PetscCall(VecSetType(x, VECSEQ));
  seq = *x->ops;
  PetscCall(PetscNew(&v));
  v->array = *(PetscScalar **)x->data;
  v->device = device;
  v->valid = MIRROR;
  FillOps(x->ops);
  PetscCall(PetscObjectChangeTypeName((PetscObject)x, VECSLIPOPENCL));
  PetscCall(SlipObjectComposeData((PetscObject)x, DATA, v, Destroy));
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * (size_t)x->map->n, "vectors", &v->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceRegisterVec(void)
{
  PetscFunctionBegin;
  PetscCall(VecRegister(VECSLIPOPENCL, VecCreate_SlipOpenCL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
