/* Inside the room device: what OpenCL calls the device of the process. */
#pragma once
#include <CL/cl.h>
#include <slipstep/private/slipdevice.h>

typedef struct {
  cl_device_id device;
  cl_context context;
  cl_command_queue queue;
} SlipDeviceOpenCL;
PETSC_INTERN const SlipDeviceOpenCL *SlipDeviceGetOpenCL(SlipDevice device);
