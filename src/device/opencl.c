/* The device of the process by OpenCL: its choice, its context and queue, its kernels and its memory. */
#define _POSIX_C_SOURCE 200809L /* sigaction(), pthread_sigmask() */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <signal.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipdeviceopencl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PLATFORMS = 16, MOST_DEVICES = 16, NAME = 128, GROUPS = 64, ITEMS = 128 };

struct _n_SlipDevice {
  SlipDeviceOpenCL cl;
  char asked[NAME], name[NAME], platform[NAME];
  size_t bytes, most, largest; /* bytes in use, of the device, and of the largest array */
  PetscBool shares;            /* it computes in the processor's memory */
  cl_program program;
  cl_kernel kernel[DEVICE_NUM_KERNELS];
  SlipDeviceMemory room, result; /* work and results of reductions */
};

static SlipDevice opened = NULL;
static SlipDeviceTraffic traffic;

/* All files of kernels, one after the other */
static const char source[] = {
#include "slipkernels.inc"
};

#define FIRST_OF(name, ...) #name,
#define NAME_OF(place, ...) FIRST_OF(__VA_ARGS__, )
static const char *const KernelNames[DEVICE_NUM_KERNELS] = {SLIP_DEVICE_KERNELS(NAME_OF)};

/* Returns a text for errors that users may see. */
static const char *Meaning(cl_int error)
{
  static const struct {
    cl_int error;
    const char *meaning;
  } meanings[] = {{CL_DEVICE_NOT_AVAILABLE, "the device is not available"},
                  {CL_MEM_OBJECT_ALLOCATION_FAILURE, "its memory is full"},
                  {CL_OUT_OF_RESOURCES, "it is out of resources, or was lost"},
                  {CL_OUT_OF_HOST_MEMORY, "the processor's memory is full"},
                  {CL_COMPILER_NOT_AVAILABLE, "it has no compiler"},
                  {CL_INVALID_COMMAND_QUEUE, "it was lost"}};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(meanings); i++)
    if (meanings[i].error == error) return meanings[i].meaning;
  return "an error of OpenCL";
}

#define CheckCL(device, error, what)                                                                                   \
  PetscCheck(!(error), PETSC_COMM_SELF, PETSC_ERR_LIB, "the device %s failed, %s: %s (OpenCL's error %d)",             \
             (device)->name, what, Meaning(error), (int)(error))

PetscBool SlipDeviceBuiltIn(void)
{
  return PETSC_TRUE;
}

SlipDeviceTraffic SlipDeviceGetTraffic(void)
{
  traffic.bytes = opened ? (PetscInt64)opened->bytes : 0;
  return traffic;
}

PetscErrorCode SlipDeviceGet(SlipDevice *device)
{
  PetscFunctionBegin;
  *device = opened;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipDeviceOpenCL *SlipDeviceGetOpenCL(SlipDevice device)
{
  return &device->cl;
}

/* ---- the choice of the device ---- */

typedef struct {
  cl_platform_id platform[MOST_PLATFORMS * MOST_DEVICES];
  cl_device_id device[MOST_PLATFORMS * MOST_DEVICES];
  PetscInt n;
} Devices;

/* Lists all devices in the order of clinfo -l. */
static void ListDevices(Devices *all)
{
  cl_platform_id platforms[MOST_PLATFORMS];
  cl_device_id devices[MOST_DEVICES];
  cl_uint n = 0, m;

  all->n = 0;
  if (clGetPlatformIDs(MOST_PLATFORMS, platforms, &n)) return;
  for (cl_uint p = 0; p < PetscMin(n, MOST_PLATFORMS); p++) {
    m = 0;
    if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, MOST_DEVICES, devices, &m)) continue;
    for (cl_uint d = 0; d < PetscMin(m, MOST_DEVICES); d++) {
      all->platform[all->n] = platforms[p];
      all->device[all->n++] = devices[d];
    }
  }
}

static void Names(const Devices *all, PetscInt k, char name[], char platform[])
{
  name[0] = platform[0] = '\0';
  (void)clGetDeviceInfo(all->device[k], CL_DEVICE_NAME, NAME, name, NULL);
  (void)clGetPlatformInfo(all->platform[k], CL_PLATFORM_NAME, NAME, platform, NULL);
  name[NAME - 1] = platform[NAME - 1] = '\0';
}

static PetscBool IsCard(cl_device_id device)
{
  cl_device_type type = 0;

  (void)clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof(type), &type, NULL);
  return type & (CL_DEVICE_TYPE_GPU | CL_DEVICE_TYPE_ACCELERATOR) ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool HasDoubles(cl_device_id device)
{
  cl_device_fp_config doubles = 0;

  (void)clGetDeviceInfo(device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof(doubles), &doubles, NULL);
  return doubles ? PETSC_TRUE : PETSC_FALSE;
}

/* Finds a device by name or number; -1: there is none. */
static PetscInt Find(const Devices *all, const char wanted[])
{
  char name[NAME], platform[NAME], *end;
  const long number = strtol(wanted, &end, 10);

  if (wanted[0] && !*end) return number >= 0 && number < all->n ? (PetscInt)number : -1;
  for (int cards = 1; cards >= 0; cards--)
    for (PetscInt k = 0; k < all->n; k++) {
      if (cards && !IsCard(all->device[k])) continue;
      Names(all, k, name, platform);
      if (!wanted[0] || strstr(name, wanted) || strstr(platform, wanted)) return k;
    }
  return -1;
}

static PetscErrorCode Choose(MPI_Comm comm, const char asked[], const char wanted[], SlipDevice device)
{
  char list[16 * NAME] = "", name[NAME], platform[NAME];
  cl_ulong most = 0, largest = 0;
  cl_bool unified = CL_FALSE;
  Devices all;
  PetscInt k;

  PetscFunctionBegin;
  ListDevices(&all);
  PetscCheck(all.n, comm, PETSC_ERR_SUP,
             "%s: there is no device of OpenCL; install the driver of the graphics card, or pocl-opencl-icd, which "
             "computes on the processor; clinfo -l lists what there is",
             asked);
  k = Find(&all, wanted);
  for (PetscInt i = 0; i < all.n && k < 0; i++) {
    const size_t n = strlen(list);

    Names(&all, i, name, platform);
    (void)snprintf(list + n, sizeof(list) - n, "%s%d %s (%s)", i ? ", " : "", (int)i, name, platform);
  }
  PetscCheck(k >= 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "%s: there is no such device of OpenCL; expected one of %s", asked,
             list);
  Names(&all, k, device->name, device->platform);
  device->cl.device = all.device[k];
  PetscCheck(HasDoubles(all.device[k]), comm, PETSC_ERR_SUP,
             "%s: the device %s has no double precision, which faults need", asked, device->name);
  (void)clGetDeviceInfo(all.device[k], CL_DEVICE_GLOBAL_MEM_SIZE, sizeof(most), &most, NULL);
  (void)clGetDeviceInfo(all.device[k], CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof(largest), &largest, NULL);
  device->most = (size_t)most;
  device->largest = (size_t)largest;
  (void)clGetDeviceInfo(all.device[k], CL_DEVICE_HOST_UNIFIED_MEMORY, sizeof(unified), &unified, NULL);
  device->shares = unified && !IsCard(all.device[k]) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- creation and destruction ---- */

static PetscErrorCode Build(MPI_Comm comm, SlipDevice device)
{
  const char *text = source;
  const size_t length = sizeof(source);
  char *log;
  size_t size = 0;
  cl_int error;

  PetscFunctionBegin;
  device->program = clCreateProgramWithSource(device->cl.context, 1, &text, &length, &error);
  CheckCL(device, error, "making its program");
  error = clBuildProgram(device->program, 1, &device->cl.device, device->shares ? "-w -DPROCESSOR" : "-w", NULL, NULL);
  if (error) {
    (void)clGetProgramBuildInfo(device->program, device->cl.device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size);
    PetscCall(PetscCalloc1(size + 1, &log));
    (void)clGetProgramBuildInfo(device->program, device->cl.device, CL_PROGRAM_BUILD_LOG, size, log, NULL);
    log[strcspn(log, "\n")] = '\0';
    SETERRQ(comm, PETSC_ERR_LIB, "the kernels do not build on the device %s: %s (OpenCL's error %d)", device->name,
            log[0] ? log : "its compiler says nothing", (int)error);
  }
  for (PetscInt k = 0; k < DEVICE_NUM_KERNELS; k++) {
    device->kernel[k] = clCreateKernel(device->program, KernelNames[k], &error);
    CheckCL(device, error, KernelNames[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Open(MPI_Comm comm, const char asked[], const char wanted[], SlipDevice device)
{
  const int n = 1;
  const PetscReal zero = 0;
  cl_int error;

  PetscFunctionBegin;
  PetscCall(Choose(comm, asked, wanted, device));
  device->cl.context = clCreateContext(NULL, 1, &device->cl.device, NULL, NULL, &error);
  CheckCL(device, error, "opening it");
  device->cl.queue = clCreateCommandQueue(device->cl.context, device->cl.device, 0, &error);
  CheckCL(device, error, "opening its queue");
  PetscCall(Build(comm, device));
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * GROUPS * DEVICE_MAX_RESULTS, "reductions", &device->room));
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * DEVICE_MAX_RESULTS, "reductions", &device->result));
  { /* run a first kernel, so that the compiler is set up now, with the present handlers of signals */
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(zero), SLIP_DEVICE_ARG(device->result)};

    PetscCall(SlipDeviceRun(device, KERNEL_SET, 1, 1, 3, args));
    error = clFinish(device->cl.queue);
    CheckCL(device, error, "in its first kernel");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(SlipDevice *device)
{
  SlipDevice d = *device;

  PetscFunctionBegin;
  *device = NULL;
  if (!d) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceFree(d, &d->room));
  PetscCall(SlipDeviceFree(d, &d->result));
  for (PetscInt k = 0; k < DEVICE_NUM_KERNELS; k++)
    if (d->kernel[k]) (void)clReleaseKernel(d->kernel[k]);
  if (d->program) (void)clReleaseProgram(d->program);
  if (d->cl.queue) (void)clReleaseCommandQueue(d->cl.queue);
  if (d->cl.context) (void)clReleaseContext(d->cl.context);
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Close(void)
{
  PetscFunctionBegin;
  PetscCall(Destroy(&opened));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The compilers of drivers install handlers for about fifteen signals at their first use, and start threads to which
   signals of the process could be delivered. Neither must change the effect of signals. */
typedef struct {
  struct sigaction handler[32];
  PetscBool known[32];
  sigset_t blocked;
} Signals;

static void KeepSignals(Signals *s)
{
  sigset_t all;

  for (int k = 1; k < 32; k++) s->known[k] = sigaction(k, NULL, &s->handler[k]) ? PETSC_FALSE : PETSC_TRUE;
  sigfillset(&all);
  (void)pthread_sigmask(SIG_SETMASK, &all, &s->blocked);
}

static void PutSignals(const Signals *s)
{
  for (int k = 1; k < 32; k++)
    if (s->known[k] && k != SIGKILL && k != SIGSTOP) (void)sigaction(k, &s->handler[k], NULL);
  (void)pthread_sigmask(SIG_SETMASK, &s->blocked, NULL);
}

PetscErrorCode SlipDeviceOpen(MPI_Comm comm, const char asked[], const char wanted[], SlipDevice *device)
{
  Signals signals;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  *device = opened;
  PetscCheck(!opened || !strcmp(opened->asked, wanted), comm, PETSC_ERR_SUP,
             "%s: a process computes on one device, and already does on %s", asked, opened->name);
  if (opened) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(device));
  PetscCall(PetscStrncpy((*device)->asked, wanted, NAME));
  KeepSignals(&signals);
  ierr = Open(comm, asked, wanted, *device);
  PutSignals(&signals);
  if (ierr) (void)Destroy(device);
  PetscCall(ierr);
  opened = *device;
  PetscCall(PetscRegisterFinalize(Close));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFindCard(const char wanted[], PetscBool *found, char why[], size_t len)
{
  char name[NAME] = "", platform[NAME];
  Signals signals;
  Devices all;
  PetscInt k;

  PetscFunctionBegin;
  KeepSignals(&signals);
  ListDevices(&all);
  k = Find(&all, wanted);
  if (k >= 0) Names(&all, k, name, platform);
  if (!all.n)
    (void)snprintf(why, len, "there is no device of OpenCL");
  else if (k < 0)
    (void)snprintf(why, len, "no device of OpenCL is named %s", wanted);
  else if (!IsCard(all.device[k]))
    (void)snprintf(why, len, "there is no graphics card: %s is a processor", name);
  else if (!HasDoubles(all.device[k]))
    (void)snprintf(why, len, "%s has no double precision", name);
  else
    why[0] = '\0';
  PutSignals(&signals);
  *found = why[0] ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceText(SlipDevice device, char text[], size_t len)
{
  PetscFunctionBegin;
  (void)snprintf(text, len, "%s (%s) with %.4g MB", device->name, device->platform, 1e-6 * (double)device->most);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- memory ---- */

PetscBool SlipDeviceFits(SlipDevice device, size_t bytes)
{
  return device->bytes + bytes <= device->most ? PETSC_TRUE : PETSC_FALSE;
}

PetscErrorCode SlipDeviceReserve(SlipDevice device, size_t bytes, const char what[])
{
  PetscFunctionBegin;
  PetscCheck(SlipDeviceFits(device, bytes), PETSC_COMM_SELF, PETSC_ERR_MEM,
             "the device %s has %.4g MB of memory, %.4g MB of it in use here, and %s need %.4g MB more: expected fewer "
             "cells, or another device (-fault_device_name)",
             device->name, 1e-6 * (double)device->most, 1e-6 * (double)device->bytes, what, 1e-6 * (double)bytes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceAllocate(SlipDevice device, size_t bytes, const char what[], SlipDeviceMemory *memory)
{
  cl_int error;

  PetscFunctionBegin;
  PetscCall(SlipDeviceReserve(device, bytes, what));
  PetscCheck(
    bytes <= device->largest, PETSC_COMM_SELF, PETSC_ERR_MEM,
    "the device %s has arrays of at most %.4g MB, and %s need one of %.4g MB: expected fewer cells, or another "
    "device (-fault_device_name)",
    device->name, 1e-6 * (double)device->largest, what, 1e-6 * (double)bytes);
  *memory = clCreateBuffer(device->cl.context, CL_MEM_READ_WRITE, bytes ? bytes : 1, NULL, &error);
  CheckCL(device, error, what);
  device->bytes += bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFree(SlipDevice device, SlipDeviceMemory *memory)
{
  size_t bytes = 0;

  PetscFunctionBegin;
  if (!*memory) PetscFunctionReturn(PETSC_SUCCESS);
  (void)clGetMemObjectInfo(*memory, CL_MEM_SIZE, sizeof(bytes), &bytes, NULL);
  (void)clReleaseMemObject(*memory);
  device->bytes -= PetscMin(bytes, device->bytes);
  *memory = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

size_t SlipDeviceLargest(SlipDevice device)
{
  return device->largest;
}

PetscErrorCode SlipDevicePut(SlipDevice device, size_t n, const PetscReal from[], SlipDeviceMemory to)
{
  PetscFunctionBegin;
  PetscCall(SlipDevicePutAt(device, 0, n, from, to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDevicePutAt(SlipDevice device, size_t start, size_t n, const PetscReal from[], SlipDeviceMemory to)
{
  cl_int error;

  PetscFunctionBegin;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  error = clEnqueueWriteBuffer(device->cl.queue, to, CL_TRUE, sizeof(PetscReal) * start, sizeof(PetscReal) * n, from, 0,
                               NULL, NULL);
  CheckCL(device, error, "taking numbers");
  PetscCall(PetscLogCpuToGpu((PetscLogDouble)(sizeof(PetscReal) * n)));
  traffic.puts++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Fetch(SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[])
{
  cl_int error;

  PetscFunctionBegin;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  error = clEnqueueReadBuffer(device->cl.queue, from, CL_TRUE, 0, sizeof(PetscReal) * n, to, 0, NULL, NULL);
  CheckCL(device, error, "giving numbers");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFetch(SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[])
{
  PetscFunctionBegin;
  PetscCall(Fetch(device, n, from, to));
  PetscCall(PetscLogGpuToCpu((PetscLogDouble)(sizeof(PetscReal) * n)));
  traffic.fetches++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceFetchNumbers(SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[])
{
  PetscFunctionBegin;
  PetscCall(Fetch(device, n, from, to));
  traffic.numbers += (PetscInt64)n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceCopy(SlipDevice device, size_t n, SlipDeviceMemory from, SlipDeviceMemory to)
{
  cl_int error;

  PetscFunctionBegin;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  error = clEnqueueCopyBuffer(device->cl.queue, from, to, 0, 0, sizeof(PetscReal) * n, 0, NULL, NULL);
  CheckCL(device, error, "copying");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool SlipDeviceShares(SlipDevice device)
{
  return device->shares;
}

PetscErrorCode SlipDeviceMap(SlipDevice device, size_t n, PetscBool write, PetscBool wait, SlipDeviceMemory memory,
                             PetscReal **a)
{
  cl_int error;

  PetscFunctionBegin;
  *a = (PetscReal *)clEnqueueMapBuffer(device->cl.queue, memory, wait ? CL_TRUE : CL_FALSE,
                                       write ? CL_MAP_WRITE_INVALIDATE_REGION : CL_MAP_READ, 0, sizeof(PetscReal) * n,
                                       0, NULL, NULL, &error);
  CheckCL(device, error, "lending its memory");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceUnmap(SlipDevice device, SlipDeviceMemory memory, PetscReal **a)
{
  cl_int error;

  PetscFunctionBegin;
  error = clEnqueueUnmapMemObject(device->cl.queue, memory, *a, 0, NULL, NULL);
  CheckCL(device, error, "taking its memory back");
  *a = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- kernels ---- */

static PetscErrorCode Launch(SlipDevice device, SlipDeviceKernel kernel, const size_t global[2], const size_t local[2],
                             PetscInt nargs, const SlipDeviceArg args[])
{
  cl_int error = CL_SUCCESS;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < nargs && !error; k++)
    error = clSetKernelArg(device->kernel[kernel], (cl_uint)k, args[k].size, args[k].value);
  if (!error)
    error = clEnqueueNDRangeKernel(device->cl.queue, device->kernel[kernel], 2, NULL, global, local, 0, NULL, NULL);
  CheckCL(device, error, KernelNames[kernel]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceRun(SlipDevice device, SlipDeviceKernel kernel, size_t columns, size_t rows, PetscInt nargs,
                             const SlipDeviceArg args[])
{
  const size_t local[2] = {ITEMS, 1}, global[2] = {(columns + ITEMS - 1) / ITEMS * ITEMS, rows};

  PetscFunctionBegin;
  if (!columns || !rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Launch(device, kernel, global, local, nargs, args));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceRunGroups(SlipDevice device, SlipDeviceKernel kernel, size_t groups, PetscInt nargs,
                                   const SlipDeviceArg args[])
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceRun(device, kernel, groups * ITEMS, 1, nargs, args));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceReduce(SlipDevice device, SlipDeviceKernel kernel, size_t n, PetscInt nargs,
                                const SlipDeviceArg args[], PetscInt nresults, PetscInt sums, PetscReal results[])
{
  const size_t local[2] = {ITEMS, 1}, each = (device->shares ? 32 : 8) * ITEMS, most = (n + each - 1) / each;
  const int groups = (int)PetscClipInterval(most, 1, GROUPS), number = (int)nresults, first = (int)sums;
  const size_t global[2] = {(size_t)groups * ITEMS, 1}, one[2] = {ITEMS, 1};
  SlipDeviceArg all[DEVICE_MAX_ARGS];
  const SlipDeviceArg fold[] = {SLIP_DEVICE_ARG(device->room), SLIP_DEVICE_ARG(groups), SLIP_DEVICE_ARG(number),
                                SLIP_DEVICE_ARG(first), SLIP_DEVICE_ARG(device->result)};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < nargs; k++) all[k] = args[k];
  all[nargs] = (SlipDeviceArg)SLIP_DEVICE_ARG(device->room);
  PetscCall(Launch(device, kernel, global, local, nargs + 1, all));
  if (groups > 1) PetscCall(Launch(device, KERNEL_FOLD, one, local, 5, fold));
  PetscCall(Fetch(device, (size_t)nresults, groups > 1 ? device->result : device->room, results));
  traffic.numbers += nresults;
  PetscFunctionReturn(PETSC_SUCCESS);
}
