/* Internal header of src/device: OpenCL's objects of the process's device */
#pragma once
#include <CL/cl.h>
#include <slipstep/private/slipdevice.h>

typedef struct {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue;
} SlipDeviceOpenCL;
PETSC_INTERN const SlipDeviceOpenCL *SlipDeviceGetOpenCL(SlipDevice device);
