/* A fault of rate and state on a device of OpenCL, -fault_device: its vectors are there (VECSLIPOPENCL), K u is formed
   there, and so is all that a step needs of the cells: slip rates in balance, bounds, relaxation, sums. The processor
   gets a few numbers. What is not done there works all the same, on the mirrors of vectors, which then are fetched. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatgrid.h>

/* What the cells keep, in the order of kernels/ratestate.cl */
enum { OFFSET, SLOPE, INVERSE, SCALE, LOAD, SLIP, LOADING, TRACTION, NUM_KEPT };
/* Vectors of a state, of slip: of TSADAMS of the highest order, its tolerances, the fault's work (counted) */
enum { STATE_VECTORS = 19, SLIP_VECTORS = 14 };

/* Before the stiffness: the device, with room for the fault */
PetscErrorCode SlipFaultDeviceSetUp(SlipFault fault)
{
  SlipFaultDevice *d = &fault->device;
  const char *prefix = SlipFaultPrefix(fault), *name = fault->options.text[FAULT_DEVICE_NAME];
  const PetscReal n = (PetscReal)fault->mesh.n;
  char asked[PETSC_MAX_PATH_LEN + 128];
  PetscMPIInt size;
  PetscBool used;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_DEVICE], "opencl", &used));
  if (!used) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCheck(size == 1, fault->comm, PETSC_ERR_SUP, "-%sfault_device opencl is of one process: expected 1, not %d",
             prefix, (int)size);
  PetscCheck(
    !strcmp(fault->friction.law->name, "rate_and_state"), fault->comm, PETSC_ERR_SUP,
    "-%sfault_device opencl balances rate-and-state friction: expected -%sfault_friction_law rate_and_state, not %s",
    prefix, prefix, fault->friction.law->name);
  PetscCall(PetscSNPrintf(asked, sizeof(asked), "-%sfault_device opencl%s%s%s%s", prefix, name[0] ? " -" : "",
                          name[0] ? prefix : "", name[0] ? "fault_device_name " : "", name));
  PetscCall(SlipDeviceOpen(fault->comm, asked, name, &d->device));
  PetscCall(SlipDeviceRegisterVec());
  d->bytes = SlipToeplitzDeviceBytes(fault->mesh.dims[1], fault->mesh.dims[0]) +
             (PetscReal)sizeof(PetscReal) * n * (STATE_VECTORS * fault->layout.block + SLIP_VECTORS + NUM_KEPT);
  PetscCall(SlipDeviceReserve(d->device, (size_t)d->bytes, "the stiffness and the vectors of the fault"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultDeviceDestroy(SlipFault fault)
{
  PetscFunctionBegin;
  if (fault->device.cells) PetscCall(SlipDeviceFree(fault->device.device, &fault->device.cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Vectors that K makes, and those that are made like them, are on the device. */
PetscErrorCode SlipFaultDeviceVectors(SlipFault fault, Mat K)
{
  PetscFunctionBegin;
  if (fault->device.device) PetscCall(SlipMatUseDevice(K));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is this a state for kernels? One that a user has made elsewhere is none. */
PetscBool SlipFaultOnDevice(SlipFault fault, Vec w)
{
  return fault->device.device && fault->balance.kept && SlipDeviceVecIs(w) ? PETSC_TRUE : PETSC_FALSE;
}

/* What the cells keep, put there once: neither normal stress nor shear load changes */
static PetscErrorCode Cells(SlipFault fault, SlipDeviceMemory *cells)
{
  const PetscInt n = fault->mesh.n;
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE], eta = fault->balance.eta, *shear = NULL;
  const SlipFaultLoad *load;
  PetscReal *a;

  PetscFunctionBegin;
  if (!fault->device.cells) {
    PetscCall(SlipFaultGetLoad(fault, 0, &load));
    PetscCall(PetscMalloc1((size_t)(NUM_KEPT * n), &a));
    PetscCall(PetscArraycpy(a, fault->balance.kept, (size_t)(LOAD * n)));
    if (load->shear) PetscCall(VecGetArrayRead(load->shear, &shear));
    for (PetscInt i = 0; i < n; i++) {
      a[LOAD * n + i] = (shear ? shear[i] : 0) + eta * vinf[i];
      a[SLIP * n + i] = fault->fields.cell[FIELD_FRICTION_SLIP][i];
      a[LOADING * n + i] = vinf[i];
      a[TRACTION * n + i] = fault->fields.cell[FIELD_INITIAL_TRACTION][i];
    }
    if (load->shear) PetscCall(VecRestoreArrayRead(load->shear, &shear));
    PetscCall(SlipDeviceAllocate(fault->device.device, sizeof(PetscReal) * (size_t)(NUM_KEPT * n), "cells",
                                 &fault->device.cells));
    PetscCall(SlipDevicePut(fault->device.device, (size_t)(NUM_KEPT * n), a, fault->device.cells));
    PetscCall(PetscFree(a));
  }
  *cells = fault->device.cells;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The slip rates of the state w, whose K u is in balance.force, into balance.rate; unless F is NULL its rates */
PetscErrorCode SlipFaultDeviceRates(SlipFault fault, Vec w, Vec F)
{
  SlipFaultBalance *b = &fault->balance;
  const PetscReal V0 = fault->options.value[FAULT_FRICTION_REFERENCE_RATE];
  const int n = (int)fault->mesh.n, slip_law = fault->friction.slip_law;
  SlipDevice device = fault->device.device;
  SlipDeviceMemory cells, state, force, rate, f = NULL;

  PetscFunctionBegin;
  PetscCall(Cells(fault, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(b->force, &force));
  PetscCall(SlipDeviceVecWrite(b->rate, &rate));
  if (F) PetscCall(SlipDeviceVecWrite(F, &f));
  {
    const SlipDeviceArg closed[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state),
                                    SLIP_DEVICE_ARG(force), SLIP_DEVICE_ARG(rate)};
    const SlipDeviceArg others[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(b->eta), SLIP_DEVICE_ARG(cells),
                                    SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(force),  SLIP_DEVICE_ARG(rate)};
    const SlipDeviceArg derivative[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(slip_law), SLIP_DEVICE_ARG(V0),
                                        SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state),    SLIP_DEVICE_ARG(rate),
                                        SLIP_DEVICE_ARG(f)};

    PetscCall(SlipDeviceRun(device, KERNEL_FAULT_RATES, (size_t)n, 1, 5, closed));
    PetscCall(SlipDeviceRun(device, KERNEL_FAULT_OTHERS, (size_t)n, 1, 6, others));
    if (F) PetscCall(SlipDeviceRun(device, KERNEL_FAULT_DERIVATIVE, (size_t)n, 1, 7, derivative));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How many displacements and states are not within these bounds */
PetscErrorCode SlipFaultDeviceOutside(SlipFault fault, Vec w, PetscReal displacement, PetscReal bound,
                                      PetscInt *outside)
{
  const int n = (int)fault->mesh.n;
  SlipDeviceMemory state;
  PetscReal count;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(displacement), SLIP_DEVICE_ARG(bound),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_OUTSIDE, (size_t)n, 4, args, 1, 1, &count));
  }
  *outside = (PetscInt)count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest dv/dtau of the balance, of the rates of the last right-hand side */
PetscErrorCode SlipFaultDeviceCompliance(SlipFault fault, Vec w, PetscReal *most)
{
  SlipFaultBalance *b = &fault->balance;
  const int n = (int)fault->mesh.n;
  SlipDeviceMemory cells, state, rate;

  PetscFunctionBegin;
  PetscCall(Cells(fault, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(b->rate, &rate));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(b->eta), SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(rate)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_RELAXATION, (size_t)n, 5, args, 1, 0, most));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums of a state whose K u is force, and its largest |v| */
PetscErrorCode SlipFaultDeviceSums(SlipFault fault, Vec w, Vec force, PetscReal sum[], PetscReal *max_v)
{
  const PetscReal eta = fault->balance.eta;
  const int n = (int)fault->mesh.n, shears = fault->loads.shears ? 1 : 0;
  PetscReal results[FAULT_NUM_SUMS + 1];
  SlipDeviceMemory cells, state, ku;

  PetscFunctionBegin;
  PetscCall(Cells(fault, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(force, &ku));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(eta),   SLIP_DEVICE_ARG(shears),
                                  SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(ku)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_SUMS, (size_t)n, 6, args, FAULT_NUM_SUMS + 1,
                               FAULT_NUM_SUMS, results));
  }
  PetscCall(PetscArraycpy(sum, results, FAULT_NUM_SUMS));
  *max_v = results[FAULT_NUM_SUMS];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipFaultGetPowers(), of friction that is that of the state */
PetscErrorCode SlipFaultDevicePowers(SlipFault fault, Vec w, PetscReal power[3])
{
  const PetscReal eta = fault->balance.eta;
  const int n = (int)fault->mesh.n;
  SlipDeviceMemory cells, state;

  PetscFunctionBegin;
  PetscCall(Cells(fault, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(eta), SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_POWERS, (size_t)n, 4, args, 3, 3, power));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest slip since displacements were u, a time dt ago */
PetscErrorCode SlipFaultDeviceSlip(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest)
{
  const int n = (int)fault->mesh.n;
  SlipDeviceMemory cells, state, then;

  PetscFunctionBegin;
  PetscCall(Cells(fault, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(u, &then));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(dt), SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(then)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_SLIP, (size_t)n, 5, args, 1, 0, largest));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
