/* Products of a grid by transforms along strike and a real block per wavenumber on a device, as in dipping_fft.c and
   circulant.c: slip is transformed once for shear and for normal stress. */
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatgrid.h>

enum { SHEAR, NORMAL, STAGED = 1 << 22 /* numbers that are sent at once */ };

struct _n_SlipBlocksDevice {
  SlipDevice device;
  SlipBlocksShape shape;
  int nx, nz, n, width, waves, step, shared; /* n: number of fields; step: numbers of a cell in vectors of slip */
  SlipDeviceFFT fft, normal_fft;             /* transforms of all fields, and of one */
  SlipDeviceMemory share, pad;               /* [n] fields */
  SlipDeviceMemory block[2], product[2];     /* of shear and of normal stress; NULL before first use */
};

/* Returns the numbers of a block, which is half of a symmetric one for shear. */
static size_t BlockSize(const SlipBlocksShape *s, int which)
{
  const size_t m = (size_t)(s->n * s->nz);

  return which == SHEAR ? m * (m + 1) / 2 : m * (size_t)s->nz;
}

PetscReal SlipBlocksDeviceBytes(const SlipBlocksShape *s, PetscBool normal)
{
  const size_t waves = (size_t)s->period / 2 + 1, field = 2 * waves * (size_t)s->nz, n = (size_t)s->n;

  return (PetscReal)sizeof(PetscReal) *
         (PetscReal)(field * (n + (normal ? 1 : n)) + (s->share[0] ? n * (size_t)(s->nx * s->nz) : 0) +
                     waves * BlockSize(s, normal ? NORMAL : SHEAR));
}

PetscErrorCode SlipBlocksDeviceCreate(const SlipBlocksShape *s, SlipBlocksDevice *device)
{
  const size_t cells = (size_t)(s->nx * s->nz);
  SlipBlocksDevice d;

  PetscFunctionBegin;
  PetscCall(PetscNew(&d));
  *device = d;
  PetscCall(SlipDeviceGet(&d->device));
  d->shape = *s;
  d->nx = (int)s->nx;
  d->nz = (int)s->nz;
  d->n = (int)s->n;
  d->waves = (int)s->period / 2 + 1;
  d->width = 2 * d->waves;
  d->shared = s->share[0] ? 1 : 0;
  d->step = d->shared ? 1 : d->n;
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * (size_t)(d->width * d->nz) * (size_t)d->n,
                               "the transforms", &d->pad));
  if (d->shared)
    PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * cells * (size_t)d->n, "the transforms", &d->share));
  for (PetscInt c = 0; c < s->n && d->shared; c++)
    PetscCall(SlipDevicePutAt(d->device, (size_t)c * cells, cells, s->share[c], d->share));
  PetscCall(SlipDeviceFFTCreate(d->device, s->period, 1, s->n * s->nz, d->pad, &d->fft));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipBlocksDeviceDestroy(SlipBlocksDevice *device)
{
  SlipBlocksDevice d = *device;

  PetscFunctionBegin;
  *device = NULL;
  if (!d) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceFFTDestroy(&d->fft));
  PetscCall(SlipDeviceFFTDestroy(&d->normal_fft));
  for (int which = 0; which < 2; which++) {
    PetscCall(SlipDeviceFree(d->device, &d->block[which]));
    PetscCall(SlipDeviceFree(d->device, &d->product[which]));
  }
  PetscCall(SlipDeviceFree(d->device, &d->share));
  PetscCall(SlipDeviceFree(d->device, &d->pad));
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists where number p of the device's block is in the processor's block, which is of SlipSymmetricHalf(), a whole
   symmetric one, or one of normal stress. */
static size_t *Places(const SlipBlocksShape *s, int which, size_t size, size_t place[])
{
  const PetscInt m = s->n * s->nz, most = m - m % 8;
  size_t start = 0, p = 0;

  if (which == NORMAL) {
    for (; p < size; p++) place[p] = p;
    return place;
  }
  for (PetscInt j = 0; j < m; j++) {
    const PetscInt first = s->half && j < most ? j - j % 8 : 0;

    for (PetscInt i = j; i < m; i++) place[p++] = start + (size_t)(i - first);
    start += (size_t)(m - first);
  }
  return place;
}

/* Sends blocks [wavenumbers] of shear, stored as in the shape, or of normal stress [n nz][nz]. The device stores all
   wavenumbers of a number beside each other. */
static PetscErrorCode Put(SlipBlocksDevice d, int which, const PetscReal blocks[])
{
  const SlipBlocksShape *s = &d->shape;
  const size_t size = BlockSize(s, which), waves = (size_t)d->waves, m = (size_t)(s->n * s->nz);
  const size_t apart = which == NORMAL ? size : s->half ? SlipSymmetricHalf((PetscInt)m, NULL, NULL) : m * m;
  const size_t many = PetscMax(1, STAGED / waves);
  PetscReal *staged;
  size_t *place;

  PetscFunctionBegin;
  if (d->block[which]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * size * waves, "the stiffness", &d->block[which]));
  PetscCall(SlipDeviceAllocate(d->device,
                               sizeof(PetscReal) * (size_t)(d->width * d->nz) * (size_t)(which == NORMAL ? 1 : d->n),
                               "the transforms", &d->product[which]));
  PetscCall(PetscMalloc2(many * waves, &staged, size, &place));
  (void)Places(s, which, size, place);
  for (size_t start = 0; start < size; start += many) {
    const size_t n = PetscMin(many, size - start);

    for (size_t k = 0; k < waves; k++)
      for (size_t p = 0; p < n; p++) staged[p * waves + k] = blocks[k * apart + place[start + p]];
    PetscCall(SlipDevicePutAt(d->device, start * waves, n * waves, staged, d->block[which]));
  }
  PetscCall(PetscFree2(staged, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipBlocksDevicePutShear(SlipBlocksDevice d, const PetscReal blocks[])
{
  PetscFunctionBegin;
  PetscCall(Put(d, SHEAR, blocks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipBlocksDevicePutNormal(SlipBlocksDevice d, const PetscReal blocks[])
{
  PetscFunctionBegin;
  PetscCall(Put(d, NORMAL, blocks));
  if (d->n > 1 && !d->normal_fft)
    PetscCall(SlipDeviceFFTCreate(d->device, d->shape.period, 1, d->shape.nz, d->product[NORMAL], &d->normal_fft));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms slip for the functions below. */
PetscErrorCode SlipBlocksDeviceForward(SlipBlocksDevice d, Vec x)
{
  const SlipDeviceMemory share = d->shared ? d->share : d->pad;
  SlipDeviceMemory from;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(x, &from));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),   SLIP_DEVICE_ARG(d->nz),     SLIP_DEVICE_ARG(d->width),
                                  SLIP_DEVICE_ARG(d->step), SLIP_DEVICE_ARG(d->shared), SLIP_DEVICE_ARG(share),
                                  SLIP_DEVICE_ARG(from),    SLIP_DEVICE_ARG(d->pad)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_BLOCKS_PAD, (size_t)d->width, (size_t)(d->n * d->nz), 8, args));
  }
  PetscCall(SlipDeviceFFTApply(d->fft, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Multiply(SlipBlocksDevice d, int which)
{
  const int m = d->n * d->nz, rows = which == NORMAL ? d->nz : m, symmetric = which == SHEAR;
  const int turned = which == SHEAR ? d->nz : d->shape.strike ? 0 : d->nz;

  PetscFunctionBegin;
  {
    const SlipDeviceArg args[] = {
      SLIP_DEVICE_ARG(d->waves),        SLIP_DEVICE_ARG(rows),   SLIP_DEVICE_ARG(m),
      SLIP_DEVICE_ARG(symmetric),       SLIP_DEVICE_ARG(d->nz),  SLIP_DEVICE_ARG(turned),
      SLIP_DEVICE_ARG(d->block[which]), SLIP_DEVICE_ARG(d->pad), SLIP_DEVICE_ARG(d->product[which])};

    PetscCall(SlipDeviceRun(d->device, KERNEL_BLOCKS_PRODUCT, (size_t)d->waves, (size_t)(rows + 3) / 4, 9, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Take(SlipBlocksDevice d, int which, PetscReal scale, Vec y)
{
  const int fields = which == NORMAL ? 1 : d->n, shared = which == SHEAR && d->shared;
  const int step = which == NORMAL ? 1 : d->step;
  const SlipDeviceMemory share = d->shared ? d->share : d->pad;
  SlipDeviceMemory to;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecWrite(y, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),  SLIP_DEVICE_ARG(d->nz),  SLIP_DEVICE_ARG(d->width),
                                  SLIP_DEVICE_ARG(step),   SLIP_DEVICE_ARG(fields), SLIP_DEVICE_ARG(scale),
                                  SLIP_DEVICE_ARG(shared), SLIP_DEVICE_ARG(share),  SLIP_DEVICE_ARG(d->product[which]),
                                  SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_BLOCKS_TAKE, (size_t)d->nx, (size_t)d->nz, 10, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = scale times shear. */
PetscErrorCode SlipBlocksDeviceShear(SlipBlocksDevice d, PetscReal scale, Vec y)
{
  PetscFunctionBegin;
  PetscCall(Multiply(d, SHEAR));
  PetscCall(SlipDeviceFFTApplyAt(d->fft, d->product[SHEAR], PETSC_TRUE));
  PetscCall(Take(d, SHEAR, scale, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = scale times compression. */
PetscErrorCode SlipBlocksDeviceNormal(SlipBlocksDevice d, PetscReal scale, Vec y)
{
  PetscFunctionBegin;
  PetscCall(Multiply(d, NORMAL));
  PetscCall(SlipDeviceFFTApplyAt(d->normal_fft ? d->normal_fft : d->fft, d->product[NORMAL], PETSC_TRUE));
  PetscCall(Take(d, NORMAL, scale, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
