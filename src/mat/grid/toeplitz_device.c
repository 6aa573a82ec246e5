/* Operators of a uniform grid on the device, by the symbols of toeplitz.c and toeplitz_root.c: u and z u are padded
   with zeros, transformed in both directions at once, multiplied by the symbols, and transformed backward. */
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatgrid.h>

struct _n_SlipToeplitzDevice {
  SlipDevice device;
  SlipDeviceFFT fft[2]; /* transforms of one field and of two, created at first use */
  int nx, nz;           /* numbers of cells */
  int columns, height;  /* wavenumbers along strike, period in depth */
  int fields;           /* fields for which pad has room */
  SlipDeviceMemory pad, z;

  /* data of an endless plane, SlipToeplitzDeviceApplyInverse(); NULL before first use */
  SlipDeviceFFT whole;
  int length, first, image; /* half its period in depth, the fault's first place in it, whether fields are even */
  PetscReal largest;
  SlipDeviceMemory plane, values; /* values [length + 1][columns] */
};

static PetscErrorCode Destroy(SlipToeplitzDevice *device)
{
  SlipToeplitzDevice d = *device;
  SlipDeviceMemory *const memory[] = {&d->pad, &d->z, &d->plane, &d->values};

  PetscFunctionBegin;
  *device = NULL;
  if (!d) PetscFunctionReturn(PETSC_SUCCESS);
  for (int k = 0; k < 2; k++) PetscCall(SlipDeviceFFTDestroy(&d->fft[k]));
  PetscCall(SlipDeviceFFTDestroy(&d->whole));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(memory); k++) PetscCall(SlipDeviceFree(d->device, memory[k]));
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the data on the device, which it creates at first use, for a plane on one process. */
static PetscErrorCode Get(SlipToeplitz plane, SlipToeplitzDevice *device)
{
  SlipToeplitzDevice d;
  size_t size;

  PetscFunctionBegin;
  *device = plane->device;
  if (*device) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&d));
  *device = plane->device = d;
  plane->device_destroy = Destroy;
  PetscCall(SlipDeviceGet(&d->device));
  d->nx = (int)plane->grid.nx;
  d->nz = (int)plane->grid.nz;
  d->columns = (int)plane->period / 2 + 1;
  d->height = (int)plane->depth_period;
  d->fields = plane->stiffness.product ? 2 : 1;
  size = (size_t)2 * d->columns * d->height * d->fields;
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * size, "the transforms", &d->pad));
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * (size_t)d->nz, "the transforms", &d->z));
  PetscCall(SlipDevicePut(d->device, (size_t)d->nz, plane->z, d->z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns how many numbers a part of a symbol has, real or complex. */
static size_t SizeOf(SlipToeplitzDevice d, PetscInt part)
{
  return (size_t)(part ? 2 : 1) * ((size_t)d->height / 2 + 1) * (size_t)d->columns;
}

static PetscErrorCode FreeSymbol(SlipToeplitzSymbol *symbol)
{
  SlipDevice device;

  PetscFunctionBegin;
  PetscCall(SlipDeviceGet(&device));
  for (int part = 0; part < 3; part++) PetscCall(SlipDeviceFree(device, &symbol->there[part]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates a part of a symbol. */
static PetscErrorCode AllocateSymbol(SlipToeplitzDevice d, PetscInt part, const char what[], SlipToeplitzSymbol *symbol)
{
  PetscFunctionBegin;
  symbol->there_free = FreeSymbol;
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * SizeOf(d, part), what, &symbol->there[part]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends a part of a symbol, [height / 2 + 1][columns], to the device. */
static PetscErrorCode PutSymbol(SlipToeplitzDevice d, SlipToeplitz plane, PetscInt part, SlipToeplitzSymbol *symbol)
{
  const size_t each = part ? 2 : 1, rows = (size_t)d->height / 2 + 1, size = SizeOf(d, part);
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(size, &a));
  for (size_t i = 0; i < rows; i++)
    for (size_t k = 0; k < (size_t)d->columns; k++)
      SlipToeplitzSymbolOf(plane, symbol, part, (PetscInt)k, (PetscInt)i, a + each * (i * (size_t)d->columns + k));
  PetscCall(AllocateSymbol(d, part, "the stiffness", symbol));
  PetscCall(SlipDevicePut(d->device, size, a, symbol->there[part]));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PutSymbols(SlipToeplitzDevice d, SlipToeplitz plane, SlipToeplitzSymbol *symbol)
{
  const PetscReal *const parts[] = {symbol->toeplitz, symbol->hankel, symbol->product};

  PetscFunctionBegin;
  for (PetscInt part = 0; part < 3; part++)
    if (parts[part] && !symbol->there[part]) PetscCall(PutSymbol(d, plane, part, symbol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the memory of products with the stiffness [bytes]. If a transform does not fit into fast memory, VkFFT needs
   further memory, as much as the fields. */
PetscReal SlipToeplitzDeviceBytes(PetscInt nx, PetscInt nz)
{
  const PetscReal columns = (PetscReal)(SlipGoodLength(2 * nx - 1) / 2 + 1),
                  height = (PetscReal)SlipGoodLength(2 * nz - 1);

  return (PetscReal)sizeof(PetscReal) * columns * height * (2 * 4 + (PetscReal)5 / 2);
}

/* Sends a symbol to the device before the first product. */
PetscErrorCode SlipToeplitzDevicePut(SlipToeplitz plane, SlipToeplitzSymbol *symbol)
{
  SlipToeplitzDevice d;

  PetscFunctionBegin;
  PetscCall(Get(plane, &d));
  PetscCall(PutSymbols(d, plane, symbol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the device computes in the processor's memory; the processor's own transforms then make products. */
static PetscBool Shares(void)
{
  SlipDevice device = NULL;

  (void)SlipDeviceGet(&device);
  return SlipDeviceShares(device);
}

/* Computes y = scale * (operator of this symbol) x. */
PetscErrorCode SlipToeplitzMult(SlipToeplitz plane, PetscReal scale, SlipToeplitzSymbol *symbol, Vec x, Vec y)
{
  SlipToeplitzDevice d;
  SlipDeviceMemory T, A, Q, from, to;
  int width, fields, hankel;

  PetscFunctionBegin;
  if (!SlipDeviceVecIs(x) || !SlipDeviceVecIs(y)) {
    PetscCall(SlipToeplitzApply(plane, scale, symbol, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (Shares()) {
    const Vec there[] = {x, y};
    Vec here[2];

    PetscCall(SlipDeviceVecsLend(2, 1, there, here));
    PetscCall(SlipToeplitzApply(plane, scale, symbol, here[0], here[1]));
    PetscCall(SlipDeviceVecsReturn(2, there, here));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Get(plane, &d));
  PetscCall(PutSymbols(d, plane, symbol));
  width = 2 * d->columns;
  fields = symbol->there[2] ? 2 : 1;
  hankel = symbol->there[1] ? 1 : 0;
  T = symbol->there[0];
  A = hankel ? symbol->there[1] : T;
  Q = fields == 2 ? symbol->there[2] : T;
  if (!d->fft[fields - 1])
    PetscCall(SlipDeviceFFTCreate(d->device, plane->period, plane->depth_period, fields, d->pad, &d->fft[fields - 1]));
  PetscCall(SlipDeviceVecRead(x, &from));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),     SLIP_DEVICE_ARG(d->nz),  SLIP_DEVICE_ARG(width),
                                  SLIP_DEVICE_ARG(d->height), SLIP_DEVICE_ARG(fields), SLIP_DEVICE_ARG(d->z),
                                  SLIP_DEVICE_ARG(from),      SLIP_DEVICE_ARG(d->pad)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_GRID_PAD, (size_t)width, (size_t)d->height, 8, args));
  }
  PetscCall(SlipDeviceFFTApply(d->fft[fields - 1], PETSC_FALSE));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->columns), SLIP_DEVICE_ARG(d->height), SLIP_DEVICE_ARG(fields),
                                  SLIP_DEVICE_ARG(hankel),     SLIP_DEVICE_ARG(T),         SLIP_DEVICE_ARG(A),
                                  SLIP_DEVICE_ARG(Q),          SLIP_DEVICE_ARG(d->pad)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_GRID_SYMBOL, (size_t)d->columns, (size_t)d->height / 2 + 1, 8, args));
  }
  PetscCall(SlipDeviceFFTApply(d->fft[fields - 1], PETSC_TRUE));
  PetscCall(SlipDeviceVecWrite(y, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),     SLIP_DEVICE_ARG(d->nz),  SLIP_DEVICE_ARG(width),
                                  SLIP_DEVICE_ARG(d->height), SLIP_DEVICE_ARG(fields), SLIP_DEVICE_ARG(scale),
                                  SLIP_DEVICE_ARG(d->z),      SLIP_DEVICE_ARG(d->pad), SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_GRID_TAKE, (size_t)d->nx, (size_t)d->nz, 9, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums of symbols ---- */

/* Computes to = identity + a x + b y for n numbers; y may be NULL. */
static PetscErrorCode Sum(SlipToeplitzDevice d, size_t n, PetscReal identity, PetscReal a, SlipDeviceMemory x,
                          PetscReal b, SlipDeviceMemory y, SlipDeviceMemory to)
{
  const int number = (int)n, terms = y ? 2 : 1;
  const PetscReal one = 1, none = 0;

  PetscFunctionBegin;
  if (!y) y = x;
  {
    const SlipDeviceArg set[] = {SLIP_DEVICE_ARG(number), SLIP_DEVICE_ARG(identity), SLIP_DEVICE_ARG(to)};
    const SlipDeviceArg args[] = {
      SLIP_DEVICE_ARG(number), SLIP_DEVICE_ARG(to),   SLIP_DEVICE_ARG(one), SLIP_DEVICE_ARG(to), SLIP_DEVICE_ARG(terms),
      SLIP_DEVICE_ARG(a),      SLIP_DEVICE_ARG(x),    SLIP_DEVICE_ARG(b),   SLIP_DEVICE_ARG(y),  SLIP_DEVICE_ARG(none),
      SLIP_DEVICE_ARG(x),      SLIP_DEVICE_ARG(none), SLIP_DEVICE_ARG(x)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_SET, n, 1, 3, set));
    PetscCall(SlipDeviceRun(d->device, KERNEL_COMBINE, n, 1, 13, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CombineThere(SlipToeplitz plane, const PetscReal factor[3], SlipToeplitzSymbol *sum)
{
  SlipToeplitzSymbol *const k = &plane->stiffness, *const r = &plane->root;
  const SlipToeplitzSymbol *same;
  const PetscReal *diagonal;
  SlipToeplitzDevice d;

  PetscFunctionBegin;
  PetscCall(Get(plane, &d));
  PetscCall(SlipToeplitzGetRoot(plane, &same, &diagonal));
  PetscCall(PutSymbols(d, plane, k));
  PetscCall(PutSymbols(d, plane, r));
  for (PetscInt part = 0; part < 3; part++) {
    const size_t n = SizeOf(d, part);

    if (!k->there[part]) continue;
    if (!sum->there[part]) PetscCall(AllocateSymbol(d, part, "the stage operator", sum));
    PetscCall(Sum(d, n, part ? 0 : factor[0], factor[1], k->there[part], factor[2], r->there[part], sum->there[part]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipToeplitzMultSum(SlipToeplitz plane, const PetscReal factor[3], SlipToeplitzSymbol *sum,
                                   PetscReal here[3], PetscReal there[3], Vec x, Vec y)
{
  const PetscBool device = SlipDeviceVecIs(x) && SlipDeviceVecIs(y) && !Shares() ? PETSC_TRUE : PETSC_FALSE;
  PetscReal *stored = device ? there : here;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(PetscArraycmp(stored, factor, 3, &same));
  if (!same && device) PetscCall(CombineThere(plane, factor, sum));
  if (!same && !device) PetscCall(SlipToeplitzCombine(plane, factor[0], factor[1], factor[2], sum));
  PetscCall(PetscArraycpy(stored, factor, 3));
  PetscCall(SlipToeplitzMult(plane, 1, sum, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- functions of the symbol of an endless plane ---- */

/* Sends the symbol, with wavenumbers along strike side by side, and allocates transforms over the whole plane: they
   have twice its length in depth, because fields that are even about the surface are transformed with their image. */
static PetscErrorCode GetPlane(SlipToeplitzDevice d, SlipToeplitz plane)
{
  const PetscReal *symbol;
  PetscReal *a;
  PetscInt nk, count;

  PetscFunctionBegin;
  if (d->whole) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipToeplitzGetWaves(plane, &nk, &count, &symbol));
  d->length = (int)plane->length;
  d->image = plane->image ? 1 : 0;
  d->first = plane->image ? (int)plane->gap / 2 : 0;
  PetscCall(PetscMalloc1((size_t)(nk * count), &a));
  for (PetscInt k = 0; k < nk; k++)
    for (PetscInt i = 0; i < count; i++) {
      a[(size_t)i * nk + k] = symbol[(size_t)k * count + i];
      d->largest = PetscMax(d->largest, a[(size_t)i * nk + k]);
    }
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * (size_t)(nk * count), "the preconditioner", &d->values));
  PetscCall(SlipDevicePut(d->device, (size_t)(nk * count), a, d->values));
  PetscCall(PetscFree(a));
  PetscCall(
    SlipDeviceAllocate(d->device, sizeof(PetscReal) * (size_t)4 * d->columns * d->length, "the transforms", &d->plane));
  PetscCall(SlipDeviceFFTCreate(d->device, plane->period, 2 * plane->length, 1, d->plane, &d->whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the processor computes products with such vectors. */
PetscBool SlipToeplitzWantsValues(Vec x)
{
  return SlipDeviceVecIs(x) && !Shares() ? PETSC_FALSE : PETSC_TRUE;
}

/* Replaces x by the part on the fault of 1 / f of the plane's operator, as SlipToeplitzApplyWaves() does. */
PetscErrorCode SlipToeplitzInvert(SlipToeplitz plane, const SlipToeplitzInverse *f, const PetscReal values[], Vec x,
                                  Vec y)
{
  SlipToeplitzDevice d;
  SlipDeviceMemory from, to;
  PetscReal smallest;
  int width;

  PetscFunctionBegin;
  if (!SlipDeviceVecIs(x)) {
    PetscCall(SlipToeplitzApplyWaves(plane, values, x, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (values) {
    const Vec there[] = {x, y};
    Vec here[2];

    PetscCall(SlipDeviceVecsLend(2, 1, there, here));
    PetscCall(SlipToeplitzApplyWaves(plane, values, here[0], here[1]));
    PetscCall(SlipDeviceVecsReturn(2, there, here));
    PetscCall(VecCopy(y, x));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Get(plane, &d));
  PetscCall(GetPlane(d, plane));
  width = 2 * d->columns;
  smallest = f->smallest * f->stiffness * d->largest;
  PetscCall(SlipDeviceVecRead(x, &from));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),     SLIP_DEVICE_ARG(d->nz),    SLIP_DEVICE_ARG(width),
                                  SLIP_DEVICE_ARG(d->length), SLIP_DEVICE_ARG(d->first), SLIP_DEVICE_ARG(d->image),
                                  SLIP_DEVICE_ARG(from),      SLIP_DEVICE_ARG(d->plane)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_PLANE_PAD, (size_t)width, (size_t)(2 * d->length), 8, args));
  }
  PetscCall(SlipDeviceFFTApply(d->whole, PETSC_FALSE));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->columns),   SLIP_DEVICE_ARG(d->length),
                                  SLIP_DEVICE_ARG(f->identity),  SLIP_DEVICE_ARG(f->root),
                                  SLIP_DEVICE_ARG(f->stiffness), SLIP_DEVICE_ARG(f->slope),
                                  SLIP_DEVICE_ARG(f->limit),     SLIP_DEVICE_ARG(smallest),
                                  SLIP_DEVICE_ARG(d->values),    SLIP_DEVICE_ARG(d->plane)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_PLANE_INVERSE, (size_t)d->columns, (size_t)(2 * d->length), 10, args));
  }
  PetscCall(SlipDeviceFFTApply(d->whole, PETSC_TRUE));
  PetscCall(SlipDeviceVecWrite(y, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),    SLIP_DEVICE_ARG(d->nz),    SLIP_DEVICE_ARG(width),
                                  SLIP_DEVICE_ARG(d->first), SLIP_DEVICE_ARG(d->plane), SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_PLANE_TAKE, (size_t)d->nx, (size_t)d->nz, 6, args));
  }
  PetscCall(VecCopy(y, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
