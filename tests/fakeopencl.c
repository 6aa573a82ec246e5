/* Preloaded (LD_PRELOAD), it makes a device of OpenCL look or behave as FAKEOPENCL says, a list with commas:

     card          a graphics card with memory of its own
     none          there is no device
     nodoubles     without double precision
     memory=BYTES  so much of it
     largest=BYTES its arrays have no more than that
     full=BYTES    more than that cannot be had
     broken        its compiler meets an error in the last line of a program
     lost=COUNT    after so many kernels everything fails

   The first two are of all devices. Drivers call themselves by other names, so that only programs see this. */
#define _GNU_SOURCE /* RTLD_NEXT */
#define CL_TARGET_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -1: not asked for; 0: asked for without a number */
static long long Asked(const char what[])
{
  const char *list = getenv("FAKEOPENCL");
  const size_t n = strlen(what);

  while (list && *list) {
    if (!strncmp(list, what, n) && (!list[n] || list[n] == ',' || list[n] == '='))
      return list[n] == '=' ? atoll(list + n + 1) : 0;
    list = strchr(list, ',');
    if (list) list++;
  }
  return -1;
}

/* The function of the loader of drivers, by its type */
#define REAL(name) (__extension__(__typeof__(name) *) dlsym(RTLD_NEXT, #name))

cl_int clGetPlatformIDs(cl_uint most, cl_platform_id *platforms, cl_uint *n)
{
  if (Asked("none") < 0) return REAL(clGetPlatformIDs)(most, platforms, n);
  if (n) *n = 0;
  return -1001; /* CL_PLATFORM_NOT_FOUND_KHR */
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t size, void *value, size_t *given)
{
  const cl_int error = REAL(clGetDeviceInfo)(device, what, size, value, given);
  const long long memory = Asked("memory");

  if (error || !value) return error;
  if (what == CL_DEVICE_TYPE && Asked("card") >= 0) *(cl_device_type *)value = CL_DEVICE_TYPE_GPU;
  if (what == CL_DEVICE_HOST_UNIFIED_MEMORY && Asked("card") >= 0) *(cl_bool *)value = CL_FALSE;
  if (what == CL_DEVICE_DOUBLE_FP_CONFIG && Asked("nodoubles") >= 0) *(cl_device_fp_config *)value = 0;
  if ((what == CL_DEVICE_GLOBAL_MEM_SIZE || what == CL_DEVICE_MAX_MEM_ALLOC_SIZE) && memory >= 0)
    *(cl_ulong *)value = (cl_ulong)memory;
  if (what == CL_DEVICE_MAX_MEM_ALLOC_SIZE && Asked("largest") >= 0) *(cl_ulong *)value = (cl_ulong)Asked("largest");
  return error;
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void *host, cl_int *error)
{
  static long long used = 0;
  const long long full = Asked("full");

  used += (long long)size;
  if (full < 0 || used <= full) return REAL(clCreateBuffer)(context, flags, size, host, error);
  if (error) *error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
  return NULL;
}

cl_program clCreateProgramWithSource(cl_context context, cl_uint count, const char **text, const size_t *length,
                                     cl_int *error)
{
  static const char last[] = "\nthere is an error here\n";
  const char *all[16];
  size_t lengths[16];

  if (Asked("broken") < 0 || count > 15) return REAL(clCreateProgramWithSource)(context, count, text, length, error);
  for (cl_uint k = 0; k < count; k++) {
    all[k] = text[k];
    lengths[k] = length && length[k] ? length[k] : strlen(text[k]);
  }
  all[count] = last;
  lengths[count] = strlen(last);
  return REAL(clCreateProgramWithSource)(context, count + 1, all, lengths, error);
}

static int Lost(int kernels)
{
  static long long count = 0;
  const long long lost = Asked("lost");

  count += kernels;
  return lost >= 0 && count > lost;
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t *offset,
                              const size_t *global, const size_t *local, cl_uint n, const cl_event *wait,
                              cl_event *event)
{
  if (Lost(1)) return CL_OUT_OF_RESOURCES;
  return REAL(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offset, global, local, n, wait, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem memory, cl_bool wait, size_t start, size_t size, void *to,
                           cl_uint n, const cl_event *before, cl_event *event)
{
  if (Lost(0)) return CL_OUT_OF_RESOURCES;
  return REAL(clEnqueueReadBuffer)(queue, memory, wait, start, size, to, n, before, event);
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem memory, cl_bool wait, size_t start, size_t size,
                            const void *from, cl_uint n, const cl_event *before, cl_event *event)
{
  if (Lost(0)) return CL_OUT_OF_RESOURCES;
  return REAL(clEnqueueWriteBuffer)(queue, memory, wait, start, size, from, n, before, event);
}

cl_int clEnqueueCopyBuffer(cl_command_queue queue, cl_mem from, cl_mem to, size_t start, size_t there, size_t size,
                           cl_uint n, const cl_event *before, cl_event *event)
{
  if (Lost(0)) return CL_OUT_OF_RESOURCES;
  return REAL(clEnqueueCopyBuffer)(queue, from, to, start, there, size, n, before, event);
}

void *clEnqueueMapBuffer(cl_command_queue queue, cl_mem memory, cl_bool wait, cl_map_flags flags, size_t start,
                         size_t size, cl_uint n, const cl_event *before, cl_event *event, cl_int *error)
{
  if (!Lost(0)) return REAL(clEnqueueMapBuffer)(queue, memory, wait, flags, start, size, n, before, event, error);
  if (error) *error = CL_OUT_OF_RESOURCES;
  return NULL;
}

cl_int clFinish(cl_command_queue queue)
{
  return Lost(0) ? CL_OUT_OF_RESOURCES : REAL(clFinish)(queue);
}
