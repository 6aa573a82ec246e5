/* Copies from a device the few numbers that observers need of a rate-and-state fault at the end of a step. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>

enum { GROUND_AT_ONCE = 12 }; /* as many numbers of the ground as kernels/record.cl sums at once */

/* Creates a vector of cells, on the device where the states are there. */
PetscErrorCode SlipFaultDeviceCellVector(SlipFault fault, Vec *x)
{
  PetscFunctionBegin;
  PetscCall(VecCreate(fault->comm, x));
  PetscCall(VecSetSizes(*x, fault->mesh.n, fault->mesh.N));
  PetscCall(VecSetType(*x, fault->device.device ? VECSLIPOPENCL : VECSTANDARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares to read the numbers of m cells, given by their places on this process. */
PetscErrorCode SlipFaultDeviceLookCreate(SlipFault fault, PetscInt m, const PetscInt cell[], SlipFaultDeviceLook *look)
{
  const size_t width = 2 * (size_t)fault->layout.components + 3;
  SlipDevice device = fault->device.device;
  PetscReal *places;

  PetscFunctionBegin;
  look->m = m;
  PetscCall(PetscMalloc1(m, &places));
  for (PetscInt k = 0; k < m; k++) places[k] = (PetscReal)cell[k];
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * (size_t)m, "stations", &look->places));
  PetscCall(SlipDevicePut(device, (size_t)m, places, look->places));
  PetscCall(PetscFree(places));
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * (size_t)m * width, "stations", &look->out));
  PetscCall(PetscMalloc1((size_t)m * width, &look->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills look->values from the state w at t. */
PetscErrorCode SlipFaultDeviceLookAt(SlipFault fault, PetscReal t, Vec w, SlipFaultDeviceLook *look)
{
  const int m = (int)look->m, n = (int)fault->mesh.n, c = (int)fault->layout.components;
  const PetscReal eta = fault->balance.eta;
  SlipDeviceMemory cells, state;
  PetscBool changing;
  int changes;

  PetscFunctionBegin;
  PetscCall(SlipFaultDeviceCells(fault, t, w, &cells, &changing));
  changes = changing;
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(m),     SLIP_DEVICE_ARG(n),       SLIP_DEVICE_ARG(c),
                                  SLIP_DEVICE_ARG(eta),   SLIP_DEVICE_ARG(changes), SLIP_DEVICE_ARG(look->places),
                                  SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state),   SLIP_DEVICE_ARG(look->out)};

    PetscCall(SlipDeviceRun(fault->device.device, KERNEL_FAULT_LOOK, (size_t)m, 1, 9, args));
  }
  PetscCall(SlipDeviceFetchNumbers(fault->device.device, (size_t)m * (size_t)(2 * c + 3), look->out, look->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies matrix [components n][m] to the device: m numbers of the ground for 1 m of slip of each cell and component */
PetscErrorCode SlipFaultDeviceGroundCreate(SlipFault fault, PetscInt m, const PetscReal matrix[],
                                           SlipFaultDeviceLook *look)
{
  const size_t rows = (size_t)m, columns = (size_t)(fault->layout.components * fault->mesh.n);
  SlipDevice device = fault->device.device;
  PetscReal *a;

  PetscFunctionBegin;
  look->m = m;
  PetscCall(PetscMalloc1(rows * columns, &a));
  for (size_t i = 0; i < columns; i++)
    for (size_t k = 0; k < rows; k++) a[k * columns + i] = matrix[i * rows + k];
  PetscCall(SlipDeviceAllocate(device, sizeof(PetscReal) * rows * columns, "stations of the ground", &look->places));
  PetscCall(SlipDevicePut(device, rows * columns, a, look->places));
  PetscCall(PetscFree(a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes them [m] for the displacement of w since start [components n], and for its rate relative to the far field */
PetscErrorCode SlipFaultDeviceGround(SlipFault fault, Vec w, Vec start, const SlipFaultDeviceLook *look,
                                     PetscReal moved[], PetscReal moves[])
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  PetscReal results[2 * GROUND_AT_ONCE];
  SlipDeviceMemory cells, state, u0;

  PetscFunctionBegin;
  PetscCall(SlipFaultDeviceCells(fault, 0, NULL, &cells, NULL));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(start, &u0));
  for (int first = 0; first < look->m; first += GROUND_AT_ONCE) {
    const int count = (int)PetscMin(GROUND_AT_ONCE, look->m - first);
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),
                                  SLIP_DEVICE_ARG(c),
                                  SLIP_DEVICE_ARG(first),
                                  SLIP_DEVICE_ARG(count),
                                  SLIP_DEVICE_ARG(look->places),
                                  SLIP_DEVICE_ARG(u0),
                                  SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(
      SlipDeviceReduce(fault->device.device, KERNEL_FAULT_GROUND, (size_t)n, 8, args, 2 * count, 2 * count, results));
    PetscCall(PetscArraycpy(moved + first, results, count));
    PetscCall(PetscArraycpy(moves + first, results + count, count));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultDeviceLookDestroy(SlipFault fault, SlipFaultDeviceLook *look)
{
  PetscFunctionBegin;
  if (look->places) PetscCall(SlipDeviceFree(fault->device.device, &look->places));
  if (look->out) PetscCall(SlipDeviceFree(fault->device.device, &look->out));
  PetscCall(PetscFree(look->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks in rupture, a vector of cells, the cells that first exceed the rate of events in this step. */
PetscErrorCode SlipFaultDeviceRupture(SlipFault fault, PetscInt nodes, const Vec node[], const PetscReal share[],
                                      PetscReal begin, PetscReal dt, Vec rupture)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, count = (int)nodes;
  const PetscReal bound = fault->options.value[FAULT_EVENT_RATE];
  SlipDeviceMemory state[3], times;
  PetscReal at[3];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt last = PetscMin(k, nodes - 1);

    at[k] = share[last];
    PetscCall(SlipDeviceVecRead(node[last], &state[k]));
  }
  PetscCall(SlipDeviceVecChange(rupture, &times));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),        SLIP_DEVICE_ARG(c),        SLIP_DEVICE_ARG(count),
                                  SLIP_DEVICE_ARG(bound),    SLIP_DEVICE_ARG(begin),    SLIP_DEVICE_ARG(dt),
                                  SLIP_DEVICE_ARG(at[0]),    SLIP_DEVICE_ARG(at[1]),    SLIP_DEVICE_ARG(at[2]),
                                  SLIP_DEVICE_ARG(state[0]), SLIP_DEVICE_ARG(state[1]), SLIP_DEVICE_ARG(state[2]),
                                  SLIP_DEVICE_ARG(times)};

    PetscCall(SlipDeviceRun(fault->device.device, KERNEL_FAULT_RUPTURE, (size_t)n, 1, 13, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
