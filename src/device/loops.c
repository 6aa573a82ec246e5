/* Runs the loops of kernels/loops.cl: as C on the processor's arrays, or as kernels if all arrays are on the device. */
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/rooms/slipformulas.h>

#define NUM(name) const PetscReal name = *number++;
#define IN(name) const PetscReal *const name = *array++;
#define OUT(name) PetscReal *const name = *array++;
#define LOOP(name, arguments)                                                                                          \
  static void name(PetscInt n, const PetscReal *number, PetscReal *const *array, PetscReal *mine)                      \
  {                                                                                                                    \
    arguments;                                                                                                         \
    (void)number, (void)array, (void)mine;                                                                             \
    for (PetscInt i = 0; i < n; i++)
#define SUMS(name, sums, arguments) LOOP(name, arguments)
#define END }
#define END_SUMS(sums) }
#include "kernels/loops.cl"

#define ROW(place, name, arguments, sums) {KERNEL_##place, name, arguments, sums},
static const struct {
  SlipDeviceKernel kernel;
  void (*run)(PetscInt n, const PetscReal *number, PetscReal *const *array, PetscReal *sum);
  const char *arguments;
  int sums;
} loops[] = {SLIP_LOOPS(ROW)};

PetscErrorCode SlipLoopRun(SlipLoop loop, PetscInt items, const PetscReal number[], const Vec x[], PetscReal sum[])
{
  const char *kind = loops[loop].arguments;
  PetscReal *array[DEVICE_MAX_ARGS] = {NULL};
  SlipArrays list[DEVICE_MAX_ARGS] = {{NULL}};
  PetscInt n = 0, numbers = 0;
  SlipDeviceMemory unused;

  PetscFunctionBegin;
  for (; kind[numbers] == 'n'; numbers++) continue;
  for (; kind[numbers + n]; n++) {
    list[n] = (SlipArrays){.vec = x[n]};
    if (kind[numbers + n] != 'r')
      list[n].write = &array[n];
    else
      list[n].read = (const PetscReal **)&array[n];
  }
  if (SlipDeviceArraysAre(n, list)) {
    for (PetscInt k = 0; k < n; k++)
      if (kind[numbers + k] == 'o') PetscCall(SlipDeviceVecWrite(x[k], &unused)); /* is not sent first */
    PetscCall(SlipDeviceArraysRun(loops[loop].kernel, items, numbers, number, n, list, loops[loop].sums,
                                  loops[loop].sums, sum));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int k = 0; k < loops[loop].sums; k++) sum[k] = 0;
  PetscCall(SlipArraysGet(n, list));
  (*loops[loop].run)(items, number, array, sum);
  PetscCall(SlipArraysRestore(n, list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- questions about vectors ---- */

PetscErrorCode SlipVecLargestBlock(Vec x, PetscInt c, PetscReal *size, PetscInt *block)
{
  const PetscReal *a;
  PetscInt n;

  PetscFunctionBegin;
  *size = -1;
  *block = -1;
  if (SlipDeviceVecIs(x)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(x, &n));
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < n / c; i++) {
    const PetscReal here = c > 1 ? SlipBlockSize(c, a + c * i) : PetscAbsReal(a[i]);

    if (here <= *size) continue;
    *size = PetscIsInfOrNanReal(here) ? PETSC_MAX_REAL : here;
    *block = i;
  }
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipVecLargestStart(Vec x, PetscInt block, PetscInt c, PetscReal *largest)
{
  const PetscReal numbers[] = {(PetscReal)c, (PetscReal)block};
  const SlipArrays arrays[] = {{.vec = x}};
  const PetscReal *a;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(x, &n));
  n /= block;
  if (SlipDeviceVecIs(x)) {
    PetscCall(SlipDeviceArraysRun(KERNEL_LARGEST, n, 2, numbers, 1, arrays, 1, 0, largest));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *largest = 0;
  PetscCall(VecGetArrayRead(x, &a));
  for (PetscInt i = 0; i < n; i++, a += block)
    *largest = SlipLarger(*largest, c == 1 ? PetscAbsReal(a[0]) : hypot(a[0], a[1]));
  a -= block * n;
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipVecWeightedNorm(TS ts, Vec y, Vec z, PetscReal ignore, NormType type, PetscReal *norm)
{
  PetscReal numbers[3], result[3], absolute_part, relative_part;
  Vec absolute, relative;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, &numbers[0], &absolute, &numbers[1], &relative));
  const SlipArrays arrays[] = {{.vec = y}, {.vec = z}, {.vec = absolute}, {.vec = relative}};

  if (relative || ignore >= 0 || !SlipDeviceVecIs(y) || !SlipDeviceArraysAre(4, arrays)) {
    PetscCall(TSErrorWeightedNorm(ts, y, z, type, norm, &absolute_part, &relative_part));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  numbers[2] = absolute ? 1 : 0;
  PetscCall(VecGetLocalSize(y, &n));
  PetscCall(SlipDeviceArraysRun(KERNEL_WEIGHTED_NORM, n, 3, numbers, 4, arrays, 3, 2, result));
  PetscCheck(!PetscIsInfOrNanReal(result[0]), PetscObjectComm((PetscObject)ts), PETSC_ERR_FP,
             "Infinite or not-a-number generated in norm");
  *norm = type == NORM_INFINITY ? result[2] : PetscSqrtReal(result[0] / PetscMax(result[1], 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}
