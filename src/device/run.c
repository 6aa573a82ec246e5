/* Loops over arrays as kernels: a kernel that takes the number of items, numbers, and the arrays in the order of the
   list by which the processor's own loop gets them. */
#include <slipstep/private/slipdevice.h>

/* Are all of them on the device? Those that are NULL do not count. */
PetscBool SlipDeviceArraysAre(PetscInt n, const SlipArrays list[])
{
  PetscBool all = PETSC_TRUE;

  for (PetscInt k = 0; k < n; k++)
    if (list[k].vec && !SlipDeviceVecIs(list[k].vec)) all = PETSC_FALSE;
  return all;
}

/* Of an array that is NULL the kernel gets the first one, which it leaves alone. Results as of SlipDeviceReduce(), 0 of
   a kernel without. */
PetscErrorCode SlipDeviceArraysRun(SlipDeviceKernel kernel, PetscInt items, PetscInt numbers, const PetscReal number[],
                                   PetscInt n, const SlipArrays list[], PetscInt results, PetscInt sums,
                                   PetscReal result[])
{
  const int count = (int)items;
  SlipDeviceArg args[DEVICE_MAX_ARGS];
  SlipDeviceMemory memory[DEVICE_MAX_ARGS];
  SlipDevice device;
  PetscInt nargs = 0;

  PetscFunctionBegin;
  PetscCall(SlipDeviceGet(&device));
  args[nargs++] = (SlipDeviceArg)SLIP_DEVICE_ARG(count);
  for (PetscInt k = 0; k < numbers; k++) args[nargs++] = (SlipDeviceArg)SLIP_DEVICE_ARG(number[k]);
  for (PetscInt k = 0; k < n; k++)
    if (list[k].vec && !list[k].write) PetscCall(SlipDeviceVecRead(list[k].vec, &memory[k]));
  for (PetscInt k = 0; k < n; k++)
    if (list[k].vec && list[k].write) PetscCall(SlipDeviceVecChange(list[k].vec, &memory[k]));
  for (PetscInt k = 0; k < n; k++) {
    if (!list[k].vec) memory[k] = memory[0];
    args[nargs++] = (SlipDeviceArg)SLIP_DEVICE_ARG(memory[k]);
  }
  if (results)
    PetscCall(SlipDeviceReduce(device, kernel, (size_t)items, nargs, args, results, sums, result));
  else
    PetscCall(SlipDeviceRun(device, kernel, (size_t)items, 1, nargs, args));
  PetscFunctionReturn(PETSC_SUCCESS);
}
