/* Runs loops over arrays as kernels. The arguments of a kernel are the number of items, numbers, and the arrays, in the
   order of the list from which the processor's own loop gets them. */
#include <slipstep/private/slipdevice.h>

/* Returns whether all arrays are on the device; arrays that are NULL do not count. */
PetscBool SlipDeviceArraysAre(PetscInt n, const SlipArrays list[])
{
  PetscBool all = PETSC_TRUE;

  for (PetscInt k = 0; k < n; k++)
    if (list[k].vec && !SlipDeviceVecIs(list[k].vec)) all = PETSC_FALSE;
  return all;
}

/* Runs a kernel. It gets the first array for each array that is NULL, and must not use that. Results are those of
   SlipDeviceReduce(); a kernel without results has 0. */
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
