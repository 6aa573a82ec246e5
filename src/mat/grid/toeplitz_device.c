/* Products with the stiffness of a uniform grid on the device, by the symbols of toeplitz.c: u and z u beside zeros,
   transformed in both directions at once, times the symbols, and back. */
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatgrid.h>

struct _n_SlipToeplitzDevice {
  SlipDevice device;
  SlipDeviceFFT fft;
  int nx, nz, columns, height, fields; /* cells; wavenumbers along strike, period in depth, and fields */
  SlipDeviceMemory pad, z, symbol[3];  /* hankel and product are NULL in a full space */
};

/* [height / 2 + 1][columns] of a part of the symbol, real or complex */
static PetscErrorCode PutSymbol(SlipToeplitzDevice d, SlipToeplitz plane, PetscInt part)
{
  const size_t each = part ? 2 : 1, rows = (size_t)d->height / 2 + 1, size = each * rows * (size_t)d->columns;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(size, &a));
  for (size_t i = 0; i < rows; i++)
    for (size_t k = 0; k < (size_t)d->columns; k++)
      SlipToeplitzSymbolOf(plane, &plane->stiffness, part, (PetscInt)k, (PetscInt)i,
                           a + each * (i * (size_t)d->columns + k));
  PetscCall(SlipDeviceAllocate(d->device, sizeof(PetscReal) * size, "the stiffness", &d->symbol[part]));
  PetscCall(SlipDevicePut(d->device, size, a, d->symbol[part]));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of a plane that is on one process */
PetscErrorCode SlipToeplitzDeviceCreate(SlipToeplitz plane, SlipToeplitzDevice *device)
{
  SlipToeplitzDevice d;
  size_t size;

  PetscFunctionBegin;
  PetscCall(PetscNew(&d));
  *device = d;
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
  for (PetscInt part = 0; part < (d->fields == 2 ? 3 : 1); part++) PetscCall(PutSymbol(d, plane, part));
  PetscCall(SlipDeviceFFTCreate(d->device, plane->period, plane->depth_period, d->fields, d->pad, &d->fft));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipToeplitzDeviceDestroy(SlipToeplitzDevice *device)
{
  SlipToeplitzDevice d = *device;

  PetscFunctionBegin;
  *device = NULL;
  if (!d) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceFFTDestroy(&d->fft));
  for (PetscInt part = 0; part < 3; part++) PetscCall(SlipDeviceFree(d->device, &d->symbol[part]));
  PetscCall(SlipDeviceFree(d->device, &d->pad));
  PetscCall(SlipDeviceFree(d->device, &d->z));
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What it will take [bytes], beside what VkFFT asks for by itself where a transform does not fit into fast memory,
   which is as much as the fields */
PetscReal SlipToeplitzDeviceBytes(PetscInt nx, PetscInt nz)
{
  const PetscReal columns = (PetscReal)(SlipGoodLength(2 * nx - 1) / 2 + 1),
                  height = (PetscReal)SlipGoodLength(2 * nz - 1);

  return (PetscReal)sizeof(PetscReal) * columns * height * (2 * 4 + (PetscReal)5 / 2);
}

/* y = scale * (stiffness) x, both on the device */
PetscErrorCode SlipToeplitzDeviceApply(SlipToeplitzDevice d, PetscReal scale, Vec x, Vec y)
{
  const int width = 2 * d->columns;
  const SlipDeviceMemory T = d->symbol[0], A = d->fields == 2 ? d->symbol[1] : T, Q = d->fields == 2 ? d->symbol[2] : T;
  SlipDeviceMemory from, to;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(x, &from));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),     SLIP_DEVICE_ARG(d->nz),     SLIP_DEVICE_ARG(width),
                                  SLIP_DEVICE_ARG(d->height), SLIP_DEVICE_ARG(d->fields), SLIP_DEVICE_ARG(d->z),
                                  SLIP_DEVICE_ARG(from),      SLIP_DEVICE_ARG(d->pad)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_GRID_PAD, (size_t)width, (size_t)d->height, 8, args));
  }
  PetscCall(SlipDeviceFFTApply(d->fft, PETSC_FALSE));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->columns), SLIP_DEVICE_ARG(d->height), SLIP_DEVICE_ARG(d->fields),
                                  SLIP_DEVICE_ARG(T),          SLIP_DEVICE_ARG(A),         SLIP_DEVICE_ARG(Q),
                                  SLIP_DEVICE_ARG(d->pad)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_GRID_SYMBOL, (size_t)d->columns, (size_t)d->height / 2 + 1, 7, args));
  }
  PetscCall(SlipDeviceFFTApply(d->fft, PETSC_TRUE));
  PetscCall(SlipDeviceVecWrite(y, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(d->nx),     SLIP_DEVICE_ARG(d->nz),     SLIP_DEVICE_ARG(width),
                                  SLIP_DEVICE_ARG(d->height), SLIP_DEVICE_ARG(d->fields), SLIP_DEVICE_ARG(scale),
                                  SLIP_DEVICE_ARG(d->z),      SLIP_DEVICE_ARG(d->pad),    SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_GRID_TAKE, (size_t)d->nx, (size_t)d->nz, 9, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
