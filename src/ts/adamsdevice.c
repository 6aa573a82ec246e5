/* adamssum.c on a device: one pass over its memory computes a step's sums and the norms of its estimates. */
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipts.h>

/* The same struct as in kernels/adams.cl */
typedef struct {
  PetscReal of[4][SLIP_ADAMS_NODES];
} Weights;
enum { Y, SQUARES, COUNT = 4, MOST, RESULTS = 8, SUMS = 5 };

PetscErrorCode SlipAdamsSumDevice(TS ts, PetscBool star, PetscInt m, const PetscReal weight[][SLIP_ADAMS_NODES],
                                  PetscInt estimates, Vec y, SlipAdamsSums *sums)
{
  TS_Adams *ad = (TS_Adams *)ts->data;
  SlipDeviceMemory start, to, absolute, relative, rate[SLIP_ADAMS_NODES];
  SlipDeviceArg args[DEVICE_MAX_ARGS];
  PetscReal results[RESULTS] = {0};
  Weights weights = {{{0}}};
  SlipDevice device;
  PetscInt n = 0, k = 0;
  int entries;

  PetscFunctionBegin;
  PetscCall(SlipDeviceGet(&device));
  PetscCall(VecGetLocalSize(y, &n));
  entries = (int)n;
  for (PetscInt j = 0; j <= estimates; j++)
    for (PetscInt i = 0; i < m; i++) weights.of[j][i] = weight[j][i];
  for (PetscInt j = 0; j < SLIP_ADAMS_NODES; j++) {
    const PetscInt i = PetscMin(j, m - 1); /* indices beyond the last repeat it with the weight 0 */

    PetscCall(SlipDeviceVecRead(star ? (i ? ad->rate[i - 1] : ad->star) : ad->rate[i], &rate[j]));
  }
  PetscCall(SlipDeviceVecRead(ad->at.start, &start));
  PetscCall(SlipDeviceVecWrite(y, &to));
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(entries);
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(start);
  for (PetscInt j = 0; j < SLIP_ADAMS_NODES; j++) args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(rate[j]);
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(weights);
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(to);
  if (estimates) {
    PetscCall(SlipDeviceVecRead(ts->vatol, &absolute));
    PetscCall(SlipDeviceVecRead(ts->vrtol, &relative));
    args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(absolute);
    args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(relative);
    PetscCall(SlipDeviceReduce(device, KERNEL_ADAMS_NORMS, (size_t)n, k, args, RESULTS, SUMS, results));
  } else
    PetscCall(SlipDeviceReduce(device, KERNEL_ADAMS, (size_t)n, k, args, 1, 1, results));
  *sums = (SlipAdamsSums){.finite = PetscIsInfOrNanReal(results[Y]) ? PETSC_FALSE : PETSC_TRUE};
  for (PetscInt j = 0; j < estimates; j++) {
    sums->squares[j] = results[SQUARES + j];
    sums->count[j] = results[COUNT];
    sums->most[j] = results[MOST + j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
