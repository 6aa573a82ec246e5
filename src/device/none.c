/* Replaces opencl.c and fft.c if the library is built without OpenCL. There is no device then, so that only
   SlipDeviceOpen() is ever called. */
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipdevice.h>

PetscBool SlipDeviceBuiltIn(void)
{
  return PETSC_FALSE;
}

PetscBool SlipDeviceShares(SlipDevice device)
{
  (void)device;
  return PETSC_FALSE;
}

size_t SlipDeviceLargest(SlipDevice device)
{
  (void)device;
  return 0;
}

SlipDeviceTraffic SlipDeviceGetTraffic(void)
{
  return (SlipDeviceTraffic){0};
}

PetscErrorCode SlipDeviceOpen(MPI_Comm comm, const char asked[], const char wanted[], SlipDevice *device)
{
  PetscFunctionBegin;
  (void)wanted;
  *device = NULL;
  SETERRQ(comm, PETSC_ERR_SUP,
          "%s: SlipStep was built without OpenCL; install ocl-icd-opencl-dev and libvkfft-dev, and build it anew",
          asked);
}

PetscErrorCode SlipDeviceFindCard(const char name[], PetscBool *found, char why[], size_t len)
{
  PetscFunctionBegin;
  (void)name;
  *found = PETSC_FALSE;
  PetscCall(PetscStrncpy(why, "SlipStep was built without OpenCL", len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool SlipDeviceFits(SlipDevice device, size_t bytes)
{
  (void)device, (void)bytes;
  return PETSC_FALSE;
}

PetscErrorCode SlipDeviceGet(SlipDevice *device)
{
  PetscFunctionBegin;
  *device = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define NONE(name, ...)                                                                                                \
  PetscErrorCode name(__VA_ARGS__)                                                                                     \
  {                                                                                                                    \
    PetscFunctionBegin;                                                                                                \
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_PLIB, "built without OpenCL");                                                  \
  }
#ifdef __GNUC__
  #pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
NONE(SlipDeviceText, SlipDevice device, char text[], size_t len)
NONE(SlipDeviceReserve, SlipDevice device, size_t bytes, const char what[])
NONE(SlipDeviceAllocate, SlipDevice device, size_t bytes, const char what[], SlipDeviceMemory *memory)
NONE(SlipDeviceFree, SlipDevice device, SlipDeviceMemory *memory)
NONE(SlipDevicePutAt, SlipDevice device, size_t start, size_t n, const PetscReal from[], SlipDeviceMemory to)
NONE(SlipDeviceRunGroups, SlipDevice device, SlipDeviceKernel kernel, size_t groups, PetscInt nargs,
     const SlipDeviceArg args[])
NONE(SlipDevicePut, SlipDevice device, size_t n, const PetscReal from[], SlipDeviceMemory to)
NONE(SlipDeviceFetch, SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[])
NONE(SlipDeviceFetchNumbers, SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[])
NONE(SlipDeviceCopy, SlipDevice device, size_t n, SlipDeviceMemory from, SlipDeviceMemory to)
NONE(SlipDeviceMap, SlipDevice device, size_t n, PetscBool write, PetscBool wait, SlipDeviceMemory memory,
     PetscReal **a)
NONE(SlipDeviceUnmap, SlipDevice device, SlipDeviceMemory memory, PetscReal **a)
NONE(SlipDeviceRun, SlipDevice device, SlipDeviceKernel kernel, size_t columns, size_t rows, PetscInt nargs,
     const SlipDeviceArg args[])
NONE(SlipDeviceReduce, SlipDevice device, SlipDeviceKernel kernel, size_t n, PetscInt nargs, const SlipDeviceArg args[],
     PetscInt nresults, PetscInt sums, PetscReal results[])
NONE(SlipDeviceFFTCreate, SlipDevice device, PetscInt columns, PetscInt rows, PetscInt fields, SlipDeviceMemory room,
     SlipDeviceFFT *fft)
NONE(SlipDeviceFFTApply, SlipDeviceFFT fft, PetscBool backward)
NONE(SlipDeviceFFTApplyAt, SlipDeviceFFT fft, SlipDeviceMemory room, PetscBool backward)
NONE(SlipDeviceFFTDestroy, SlipDeviceFFT *fft)
