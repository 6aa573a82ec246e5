/* A graphics card, or another OpenCL device: its selection, memory and kernels, and vectors and transforms on it. Each
   process has one device, with one context and one in-order queue, and sums have a fixed tree, so that results are
   reproducible. If the library was built without OpenCL, SlipDeviceOpen() raises an error, and no other function is
   called. */
#pragma once
#include <petscvec.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipsys.h>

typedef struct _n_SlipDevice *SlipDevice;
typedef struct _cl_mem *SlipDeviceMemory; /* OpenCL's cl_mem */

/* ---- device.c: one device per process ---- */

/* Opens the device whose name, or that of its platform, has these letters, or of this number in the order of clinfo -l;
   "": a card of the first platform that has one, else the first device. asked: the option and its value, for messages.
   Later calls return the same device, and raise an error for another name. Signal handlers, and which signals are
   blocked in the process's own threads, do not change. */
PETSC_EXTERN PetscErrorCode SlipDeviceOpen(MPI_Comm comm, const char asked[], const char name[], SlipDevice *device);
/* Checks whether there is a graphics card, of that name or number, with double precision, without opening it. why: a
   short reason if there is none. */
PETSC_EXTERN PetscErrorCode SlipDeviceFindCard(const char name[], PetscBool *found, char why[], size_t len);
PETSC_EXTERN PetscBool SlipDeviceBuiltIn(void);                /* was the library built with OpenCL? */
PETSC_INTERN PetscErrorCode SlipDeviceGet(SlipDevice *device); /* the open device; NULL: there is none */
/* Its name and memory, "NAME (PLATFORM) with 1.73e+04 MB", for views */
PETSC_INTERN PetscErrorCode SlipDeviceText(SlipDevice device, char text[], size_t len);

/* Allocates bytes in its memory after a check; what: their meaning, for the message. SlipDeviceFree() frees them. */
PETSC_EXTERN PetscErrorCode SlipDeviceAllocate(SlipDevice device, size_t bytes, const char what[],
                                               SlipDeviceMemory *memory);
PETSC_EXTERN PetscErrorCode SlipDeviceFree(SlipDevice device, SlipDeviceMemory *memory);
PETSC_INTERN size_t SlipDeviceLargest(SlipDevice device); /* largest array [bytes] */
/* Checks whether there is memory for so much more. Reserve raises an error that states how much is needed. */
PETSC_INTERN PetscBool SlipDeviceFits(SlipDevice device, size_t bytes);
PETSC_EXTERN PetscErrorCode SlipDeviceReserve(SlipDevice device, size_t bytes, const char what[]);
PETSC_EXTERN PetscErrorCode SlipDevicePut(SlipDevice device, size_t n, const PetscReal from[], SlipDeviceMemory to);
/* The same, starting at number `start` of the device's memory */
PETSC_INTERN PetscErrorCode SlipDevicePutAt(SlipDevice device, size_t start, size_t n, const PetscReal from[],
                                            SlipDeviceMemory to);
PETSC_EXTERN PetscErrorCode SlipDeviceFetch(SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[]);
/* The same for a few numbers, which are counted separately */
PETSC_EXTERN PetscErrorCode SlipDeviceFetchNumbers(SlipDevice device, size_t n, SlipDeviceMemory from, PetscReal to[]);
PETSC_INTERN PetscErrorCode SlipDeviceCopy(SlipDevice device, size_t n, SlipDeviceMemory from, SlipDeviceMemory to);
/* Some devices, as pocl, compute in the processor's memory. Arrays are then mapped there without a copy: n numbers,
   which are all written or only read until they are unmapped. Of several maps only the last one has to wait. */
PETSC_EXTERN PetscBool SlipDeviceShares(SlipDevice device);
PETSC_INTERN PetscErrorCode SlipDeviceMap(SlipDevice device, size_t n, PetscBool write, PetscBool wait,
                                          SlipDeviceMemory memory, PetscReal **a);
PETSC_INTERN PetscErrorCode SlipDeviceUnmap(SlipDevice device, SlipDeviceMemory memory, PetscReal **a);

/* Transfers between processor and device since the start: vectors and other arrays, and single numbers; and memory in
   use there [bytes], without that of VkFFT */
typedef struct {
  PetscInt64 puts, fetches, numbers, bytes;
} SlipDeviceTraffic;
PETSC_EXTERN SlipDeviceTraffic SlipDeviceGetTraffic(void);

/* ---- the kernels of the files kernels/NAME.cl, one list per file: value of SlipDeviceKernel, and name ---- */
/* clang-format off */
#define SLIP_KERNELS_COMMON(X)                                                                                         \
  X(FOLD, fold_groups)
#define SLIP_KERNELS_VECTORS(X)                                                                                        \
  X(SET, set) X(SHIFT, shift) X(COMBINE, combine) X(MULTIPLY, multiply) X(DIVIDE, divide) X(GATHER, gather)            \
  X(SCATTER, scatter)                                                                                                  \
  X(RECIPROCAL, reciprocal) X(DOT, dot_product) X(NORMS, norms) X(LARGEST, largest) X(LEAST, least) X(DIFFER, differ)
#define SLIP_KERNELS_DENSE(X)                                                                                          \
  X(DENSE_PARTS, dense_parts) X(DENSE_SUM, dense_sum)
#define SLIP_KERNELS_HMAT(X)                                                                                           \
  X(HMAT_ORDER, hmat_order) X(HMAT_DOTS, hmat_dots) X(HMAT_FOLD, hmat_fold) X(HMAT_SUMS, hmat_sums)
#define SLIP_KERNELS_GRID(X)                                                                                           \
  X(GRID_PAD, grid_pad) X(GRID_SYMBOL, grid_symbol) X(GRID_TAKE, grid_take)
#define SLIP_KERNELS_BLOCKS(X)                                                                                         \
  X(BLOCKS_PAD, blocks_pad) X(BLOCKS_PRODUCT, blocks_product) X(BLOCKS_TAKE, blocks_take)
#define SLIP_KERNELS_ADAMS(X)                                                                                          \
  X(ADAMS, adams) X(ADAMS_NORMS, adams_norms)
#define SLIP_KERNELS_RATESTATE(X)                                                                                      \
  X(FAULT_RATES, fault_rates) X(FAULT_RATES_2, fault_rates_2) X(FAULT_OTHERS, fault_others)                            \
  X(FAULT_DERIVATIVE, fault_derivative) X(FAULT_DERIVATIVE_2, fault_derivative_2)            \
                                                            \
  X(FAULT_OUTSIDE, fault_outside) X(FAULT_RELAXATION, fault_relaxation) X(FAULT_SUMS, fault_sums)                      \
  X(FAULT_POWERS, fault_powers) X(FAULT_SHARE, fault_share) X(FAULT_SLIP, fault_slip)
#define SLIP_KERNELS_LOADS(X)                                                                                          \
  X(FAULT_PRESSURE, fault_pressure) X(FAULT_SHEAR, fault_shear) X(FAULT_LOAD, fault_load)                              \
  X(FAULT_STRENGTH, fault_strength) X(FAULT_OPEN, fault_open) X(FAULT_BARE, fault_bare)
#define SLIP_KERNELS_STAGE(X)                                                                                          \
  X(PLANE_PAD, plane_pad) X(PLANE_INVERSE, plane_inverse) X(PLANE_TAKE, plane_take)                                    \
  X(WEIGHTED_NORM, weighted_norm) X(STICK_ELIMINATE, stick_eliminate)                                                  \
  X(STICK_BOUND, stick_bound) X(STICK_START_SLOPE, stick_start_slope) X(STICK_STRENGTH, stick_strength)                \
  X(STICK_LIFT, stick_lift) X(STICK_SMOOTH, stick_smooth) X(STICK_ADD_REACTION, stick_add_reaction)                    \
  X(STICK_MASS, stick_mass) X(STICK_KICK, stick_kick) X(STICK_DRIFT, stick_drift) X(STICK_SUMS, stick_sums)            \
  X(STICK_MODE, stick_mode) X(STICK_ESTIMATES, stick_estimates) X(STICK_STEP, stick_step)                              \
  X(STICK_TIMING, stick_timing) X(STICK_POWERS, stick_powers)
#define SLIP_KERNELS_RECORD(X)                                                                                         \
  X(FAULT_LOOK, fault_look) X(FAULT_GROUND, fault_ground) X(FAULT_RUPTURE, fault_rupture)
#define SLIP_DEVICE_KERNELS(X)                                                                                         \
  SLIP_KERNELS_COMMON(X)                                                                                               \
  SLIP_KERNELS_VECTORS(X)                                                                                              \
  SLIP_KERNELS_DENSE(X)                                                                                                \
  SLIP_KERNELS_HMAT(X)                                                                                                 \
  SLIP_KERNELS_GRID(X)                                                                                                 \
  SLIP_KERNELS_BLOCKS(X)                                                                                               \
  SLIP_KERNELS_ADAMS(X)                                                                                                \
  SLIP_KERNELS_RATESTATE(X)                                                                                            \
  SLIP_KERNELS_LOADS(X)                                                                                                \
  SLIP_KERNELS_RECORD(X)                                                                                               \
  SLIP_KERNELS_STAGE(X)                                                                                                \
  SLIP_LOOPS(X)
/* clang-format on */

#define SLIP_KERNEL_PLACE(place, ...) KERNEL_##place,
typedef enum { SLIP_DEVICE_KERNELS(SLIP_KERNEL_PLACE) DEVICE_NUM_KERNELS } SlipDeviceKernel;

/* An argument of a kernel: int, double, memory or a struct of them */
typedef struct {
  size_t size;
  const void *value;
} SlipDeviceArg;
#define SLIP_DEVICE_ARG(x)                                                                                             \
  {                                                                                                                    \
    sizeof(x), &(x)                                                                                                    \
  }
/* Runs a kernel for columns x rows items; more are started, which do nothing. */
PETSC_INTERN PetscErrorCode SlipDeviceRun(SlipDevice device, SlipDeviceKernel kernel, size_t columns, size_t rows,
                                          PetscInt nargs, const SlipDeviceArg args[]);
/* Runs a kernel with so many groups of 128 items. */
PETSC_INTERN PetscErrorCode SlipDeviceRunGroups(SlipDevice device, SlipDeviceKernel kernel, size_t groups,
                                                PetscInt nargs, const SlipDeviceArg args[]);
/* Runs a kernel that ends with fold(), for results [nresults] over n items: the first `sums` results are sums, the
   others largest values. The kernel's own arguments come first. */
PETSC_INTERN PetscErrorCode SlipDeviceReduce(SlipDevice device, SlipDeviceKernel kernel, size_t n, PetscInt nargs,
                                             const SlipDeviceArg args[], PetscInt nresults, PetscInt sums,
                                             PetscReal results[]);
enum { DEVICE_MAX_RESULTS = 24, DEVICE_MAX_ARGS = 32 };

/* ---- vec.c: a Vec type whose array is on the device ---- */
/* The vector is on one process. The processor has a mirror of its array, which VecGetArray() and similar functions
   update if the array has changed on the device; the next use on the device copies it back. Operations that the device
   does not support are those of VECSEQ, on the mirror. VecPlaceArray() is not supported. */
#define VECSLIPOPENCL "slipopencl"
PETSC_EXTERN PetscErrorCode SlipDeviceRegisterVec(void); /* before the first vector; later calls do nothing */
PETSC_EXTERN PetscBool SlipDeviceVecIs(Vec x);
PETSC_INTERN PetscErrorCode SlipDeviceVecRead(Vec x, SlipDeviceMemory *memory);   /* borrowed */
PETSC_INTERN PetscErrorCode SlipDeviceVecChange(Vec x, SlipDeviceMemory *memory); /* read and written */
PETSC_INTERN PetscErrorCode SlipDeviceVecWrite(Vec x, SlipDeviceMemory *memory);  /* all entries are written */
/* For operations that the processor does better than kernels, on a device that computes in its memory: VECSEQs with the
   arrays of n vectors, the first `read` of which are read; all others are written completely. Until they are returned
   no other code may access the vectors; lend.c */
PETSC_EXTERN PetscErrorCode SlipDeviceVecsLend(PetscInt n, PetscInt read, const Vec x[], Vec host[]);
PETSC_EXTERN PetscErrorCode SlipDeviceVecsReturn(PetscInt n, const Vec x[], Vec host[]);

/* ---- run.c: loops over arrays ---- */
PETSC_INTERN PetscBool SlipDeviceArraysAre(PetscInt n, const SlipArrays list[]);
PETSC_INTERN PetscErrorCode SlipDeviceArraysRun(SlipDeviceKernel kernel, PetscInt items, PetscInt numbers,
                                                const PetscReal number[], PetscInt n, const SlipArrays list[],
                                                PetscInt results, PetscInt sums, PetscReal result[]);

/* ---- fft.c: transforms in two directions of several fields of reals, in place, by VkFFT ---- */
/* Fields [rows][columns] of reals, each row in columns + 2 numbers, because the transform's row has columns/2 + 1
   complex numbers. Backward divides by columns x rows. Fields with one row are transformed only along it. ApplyAt
   transforms other fields than those in room. */
typedef struct _n_SlipDeviceFFT *SlipDeviceFFT;
PETSC_INTERN PetscErrorCode SlipDeviceFFTCreate(SlipDevice device, PetscInt columns, PetscInt rows, PetscInt fields,
                                                SlipDeviceMemory room, SlipDeviceFFT *fft);
PETSC_INTERN PetscErrorCode SlipDeviceFFTApply(SlipDeviceFFT fft, PetscBool backward);
PETSC_INTERN PetscErrorCode SlipDeviceFFTApplyAt(SlipDeviceFFT fft, SlipDeviceMemory room, PetscBool backward);
PETSC_INTERN PetscErrorCode SlipDeviceFFTDestroy(SlipDeviceFFT *fft);
