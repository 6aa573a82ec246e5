/* One pass over a device's memory that computes a weighted sum of vectors and the norms of other such sums. */
#include <slipstep/private/slipdevice.h>

/* The same struct as in kernels/adams.cl */
typedef struct {
  PetscReal of[4][SLIP_SUM_TERMS];
} Weights;
enum { Y, SQUARES, COUNT = 4, MOST, RESULTS = 8, SUMS = 5 };

PetscErrorCode SlipVecsSum(Vec start, PetscInt m, const Vec x[], const PetscReal weight[][SLIP_SUM_TERMS],
                           PetscInt others, Vec absolute, Vec relative, Vec y, SlipVecsSums *sums, PetscBool *done)
{
  SlipDeviceMemory from, to, atol, rtol, term[SLIP_SUM_TERMS];
  SlipDeviceArg args[DEVICE_MAX_ARGS];
  PetscReal results[RESULTS] = {0};
  Weights weights = {{{0}}};
  SlipDevice device;
  PetscInt n = 0, k = 0;
  int entries;

  PetscFunctionBegin;
  *done = SlipDeviceVecIs(y) && (!others || (absolute && relative)) ? PETSC_TRUE : PETSC_FALSE;
  if (!*done) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipDeviceGet(&device));
  PetscCall(VecGetLocalSize(y, &n));
  entries = (int)n;
  for (PetscInt j = 0; j <= others; j++)
    for (PetscInt i = 0; i < m; i++) weights.of[j][i] = weight[j][i];
  for (PetscInt j = 0; j < SLIP_SUM_TERMS; j++) /* indices beyond the last repeat it with the weight 0 */
    PetscCall(SlipDeviceVecRead(x[PetscMin(j, m - 1)], &term[j]));
  PetscCall(SlipDeviceVecRead(start, &from));
  PetscCall(SlipDeviceVecWrite(y, &to));
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(entries);
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(from);
  for (PetscInt j = 0; j < SLIP_SUM_TERMS; j++) args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(term[j]);
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(weights);
  args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(to);
  if (others) {
    PetscCall(SlipDeviceVecRead(absolute, &atol));
    PetscCall(SlipDeviceVecRead(relative, &rtol));
    args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(atol);
    args[k++] = (SlipDeviceArg)SLIP_DEVICE_ARG(rtol);
    PetscCall(SlipDeviceReduce(device, KERNEL_ADAMS_NORMS, (size_t)n, k, args, RESULTS, SUMS, results));
  } else
    PetscCall(SlipDeviceReduce(device, KERNEL_ADAMS, (size_t)n, k, args, 1, 1, results));
  *sums = (SlipVecsSums){.finite = PetscIsInfOrNanReal(results[Y]) ? PETSC_FALSE : PETSC_TRUE};
  for (PetscInt j = 0; j < others; j++) {
    sums->squares[j] = results[SQUARES + j];
    sums->count[j] = results[COUNT];
    sums->most[j] = results[MOST + j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
