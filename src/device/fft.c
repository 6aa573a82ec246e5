/* Transforms on the device by VkFFT, a header that generates and compiles kernels for given lengths. */
#define CL_TARGET_OPENCL_VERSION 120
#define VKFFT_BACKEND 3 /* OpenCL */
#include <vkFFT.h>
#include <slipcompat.h>
#include <slipstep/private/slipdeviceopencl.h>

struct _n_SlipDeviceFFT {
  SlipDeviceOpenCL cl;
  VkFFTApplication app;
  SlipDeviceMemory room;
  uint64_t bytes;
};

PetscErrorCode SlipDeviceFFTCreate(SlipDevice device, PetscInt columns, PetscInt rows, PetscInt fields,
                                   SlipDeviceMemory room, SlipDeviceFFT *fft)
{
  VkFFTConfiguration c = {0};
  SlipDeviceFFT f;
  VkFFTResult result;

  PetscFunctionBegin;
  PetscCall(PetscNew(&f));
  f->cl = *SlipDeviceGetOpenCL(device);
  f->room = room;
  f->bytes = (uint64_t)sizeof(PetscReal) * (uint64_t)(columns + 2) * (uint64_t)rows * (uint64_t)fields;
  c.FFTdim = rows > 1 ? 2 : 1;
  c.size[0] = (uint64_t)columns;
  c.size[1] = (uint64_t)rows;
  c.numberBatches = (uint64_t)fields;
  c.doublePrecision = 1;
  c.performR2C = 1;
  c.normalize = 1;
  c.device = &f->cl.device;
  c.context = &f->cl.context;
  c.bufferSize = &f->bytes;
  c.buffer = &f->room;
  result = initializeVkFFT(&f->app, c);
  PetscCheck(result == VKFFT_SUCCESS, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "VkFFT cannot plan transforms of %" PetscInt_FMT " x %" PetscInt_FMT " numbers (its error %d)", columns,
             rows, (int)result);
  *fft = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFFTApply(SlipDeviceFFT fft, PetscBool backward)
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceFFTApplyAt(fft, fft->room, backward));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFFTApplyAt(SlipDeviceFFT fft, SlipDeviceMemory room, PetscBool backward)
{
  VkFFTLaunchParams launch = {0};
  VkFFTResult result;

  PetscFunctionBegin;
  launch.commandQueue = &fft->cl.queue;
  launch.buffer = &room;
  result = VkFFTAppend(&fft->app, backward ? 1 : -1, &launch);
  PetscCheck(result == VKFFT_SUCCESS, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "a transform on the device failed (VkFFT's error %d)", (int)result);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFFTDestroy(SlipDeviceFFT *fft)
{
  PetscFunctionBegin;
  if (!*fft) PetscFunctionReturn(PETSC_SUCCESS);
  deleteVkFFT(&(*fft)->app);
  PetscCall(PetscFree(*fft));
  PetscFunctionReturn(PETSC_SUCCESS);
}
