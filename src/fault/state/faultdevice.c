/* Runs a fault with rate-and-state friction on an OpenCL device, -fault_device. Its vectors are there (VECSLIPOPENCL),
   and K u and all that a step needs of the cells (devicecells.c) are computed there; the processor gets a few numbers.
   It computes the rest from the mirrors of vectors, which are then fetched. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>

/* Opens the device; before the stiffness. */
PetscErrorCode SlipFaultDeviceSetUp(SlipFault fault)
{
  SlipFaultDevice *d = &fault->device;
  const char *prefix = SlipFaultPrefix(fault), *name = fault->options.text[FAULT_DEVICE_NAME];
  char asked[PETSC_MAX_PATH_LEN + 128];
  PetscMPIInt size;
  PetscBool used;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_DEVICE], "opencl", &used));
  if (!used) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCheck(size == 1, fault->comm, PETSC_ERR_SUP, "-%sfault_device opencl is of one process: expected 1, not %d",
             prefix, (int)size);
  PetscCheck(!fault->friction.law->always_slides || !strcmp(fault->friction.law->name, "rate_and_state"), fault->comm,
             PETSC_ERR_SUP,
             "-%sfault_device opencl knows no cells that always slide but those of rate and state: expected "
             "-%sfault_friction_law rate_and_state, or one that sticks, not %s",
             prefix, prefix, fault->friction.law->name);
  PetscCall(PetscSNPrintf(asked, sizeof(asked), "-%sfault_device opencl%s%s%s%s", prefix, name[0] ? " -" : "",
                          name[0] ? prefix : "", name[0] ? "fault_device_name " : "", name));
  PetscCall(SlipDeviceOpen(fault->comm, asked, name, &d->device));
  PetscCall(SlipDeviceRegisterVec());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultDeviceDestroy(SlipFault fault)
{
  SlipFaultDevice *d = &fault->device;
  SlipDeviceMemory *const memory[] = {&d->cells, &d->pressure, &d->record, &d->distance2, &d->faults};

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(memory); k++)
    if (*memory[k]) PetscCall(SlipDeviceFree(d->device, memory[k]));
  PetscCall(VecDestroy(&d->shear));
  PetscCall(VecDestroy(&d->sticking));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether slip rates are balanced on the device. */
PetscBool SlipFaultDeviceBalances(SlipFault fault)
{
  return fault->device.device && fault->friction.law->keep && fault->balance.eta > 0 && !fault->kind.inertia
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Returns whether kernels can compute with this state. They cannot with a state that a user has created elsewhere. */
PetscBool SlipFaultOnDevice(SlipFault fault, Vec w)
{
  return SlipFaultDeviceBalances(fault) && SlipDeviceVecIs(w) ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- the numbers of a state, and vectors of slip ---- */

/* Copies the numbers from an offset in the block of each cell, as many as slip has components, into x; or back. */
PetscErrorCode SlipFaultDeviceMove(SlipFault fault, Vec w, PetscInt offset, PetscBool back, Vec x)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, block = (int)fault->layout.block,
            start = (int)offset;
  SlipDeviceMemory from, to;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(back ? x : w, &from));
  if (back)
    PetscCall(SlipDeviceVecChange(w, &to));
  else
    PetscCall(SlipDeviceVecWrite(x, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(c),    SLIP_DEVICE_ARG(block),
                                  SLIP_DEVICE_ARG(start), SLIP_DEVICE_ARG(from), SLIP_DEVICE_ARG(to)};

    PetscCall(
      SlipDeviceRun(fault->device.device, back ? KERNEL_FAULT_PLACE : KERNEL_FAULT_TAKE, (size_t)n, 1, 6, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest |v| of a state. */
PetscErrorCode SlipFaultDeviceFastest(SlipFault fault, Vec w, PetscReal *largest)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, block = (int)fault->layout.block;
  SlipDeviceMemory state;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(c), SLIP_DEVICE_ARG(block),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_FASTEST, (size_t)n, 4, args, 1, 0, largest));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the displacements and states that are not within these bounds. */
PetscErrorCode SlipFaultDeviceOutside(SlipFault fault, Vec w, PetscReal displacement, PetscReal bound,
                                      PetscInt *outside)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  SlipDeviceMemory state;
  PetscReal count;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(c), SLIP_DEVICE_ARG(displacement),
                                  SLIP_DEVICE_ARG(bound), SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_OUTSIDE, (size_t)n, 5, args, 1, 1, &count));
  }
  *outside = (PetscInt)count;
  PetscFunctionReturn(PETSC_SUCCESS);
}
