/* Runs a fault on an OpenCL device, -fault_device: its vectors are there (VECSLIPOPENCL), products and all that a step
   needs of the cells are computed there (observe/cellsopencl.c), and the processor gets a few numbers. It computes the
   rest from the mirrors of vectors, which are then fetched. -fault_device auto is a graphics card if there is one that
   can compute this fault, else the processor; the choice replaces "auto" in the options. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <stdio.h>
#include <string.h>

static PetscErrorCode Choose(SlipFault fault, const char device[], const char why[])
{
  PetscFunctionBegin;
  PetscCall(PetscStrncpy(fault->options.text[FAULT_DEVICE], device, sizeof(fault->options.text[FAULT_DEVICE])));
  PetscCall(PetscStrncpy(fault->device.why, why, sizeof(fault->device.why)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a TS of the type that the options select, for checks of what devices support; NULL: no such type. */
static PetscErrorCode AskedType(SlipFault fault, TS *ts)
{
  const char *prefix = ((PetscObject)fault)->prefix;
  void (*create)(void) = NULL;
  char type[64] = "";

  PetscFunctionBegin;
  *ts = NULL;
  PetscCall(PetscOptionsGetString(((PetscObject)fault)->options, prefix, "-ts_type", type, sizeof(type), NULL));
  if (type[0]) PetscCall(PetscFunctionListFind(TSList, type, &create));
  if (!create) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSCreate(fault->comm, ts));
  PetscCall(TSSetType(*ts, type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Decides from the fault, the number of processes and the cards; before features are checked. Collective. */
PetscErrorCode SlipFaultDeviceChoose(SlipFault fault)
{
  SlipFaultDevice *d = &fault->device;
  char why[sizeof(d->why)] = "";
  PetscBool automatic, found;
  PetscMPIInt size;
  TS ts;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->options.text[FAULT_DEVICE], "auto", &automatic));
  if (!automatic) PetscFunctionReturn(PETSC_SUCCESS);
  d->automatic = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_size(fault->comm, &size));
  PetscCall(AskedType(fault, &ts));
  PetscCall(SlipFaultRefuses(fault, ts, SLIP_FEATURE(DEVICE), why, sizeof(why)));
  PetscCall(TSDestroy(&ts));
  if (!why[0] && fault->friction.law->always_slides && strcmp(fault->friction.law->name, "rate_and_state"))
    (void)snprintf(why, sizeof(why), "the friction law %s is not rate_and_state", fault->friction.law->name);
  if (size > 1) (void)snprintf(why, sizeof(why), "a device is of one process, not of %d", (int)size);
  if (!why[0]) PetscCall(SlipDeviceFindCard(fault->options.text[FAULT_DEVICE_NAME], &found, why, sizeof(why)));
  PetscCall(Choose(fault, why[0] ? "none" : "opencl", why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether there is room for device.bytes. Without room, auto takes the processor, and opencl is an error. */
PetscErrorCode SlipFaultDeviceRoom(SlipFault fault, PetscBool *room)
{
  SlipFaultDevice *d = &fault->device;
  char why[sizeof(d->why)], text[256];

  PetscFunctionBegin;
  *room = PETSC_TRUE;
  if (d->automatic && !SlipDeviceFits(d->device, (size_t)d->bytes)) {
    PetscCall(SlipDeviceText(d->device, text, sizeof(text)));
    (void)snprintf(why, sizeof(why), "the fault and its integrator need up to %.3g MB, more than is free of %s",
                   1e-6 * (double)d->bytes, text);
    PetscCall(Choose(fault, "none", why));
    d->device = NULL;
    *room = PETSC_FALSE;
  } else
    PetscCall(SlipDeviceReserve(d->device, (size_t)d->bytes, "the stiffness and the vectors of the fault"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* Prints what of a device the fault takes, or why it has none. */
PetscErrorCode SlipFaultDeviceView(SlipFault fault, PetscViewer viewer)
{
  const SlipFaultDevice *d = &fault->device;
  char text[512];

  PetscFunctionBegin;
  if (d->device) {
    PetscCall(SlipDeviceText(d->device, text, sizeof(text)));
    PetscCall(PetscViewerASCIIPrintf(viewer, "device: %s, of which the fault and its integrator take up to %.3g MB%s\n",
                                     text, 1e-6 * (double)d->bytes, d->automatic ? ", by -fault_device auto" : ""));
  } else if (d->automatic)
    PetscCall(
      PetscViewerASCIIPrintf(viewer, "device: none by -%sfault_device auto, as %s\n", SlipFaultPrefix(fault), d->why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the numbers of arrays to and from the device and of numbers from it, since the process began. */
void SlipFaultDeviceTraffic(PetscInt64 traffic[3])
{
  const SlipDeviceTraffic now = SlipDeviceGetTraffic();

  traffic[0] = now.puts;
  traffic[1] = now.fetches;
  traffic[2] = now.numbers;
}
