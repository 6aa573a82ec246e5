/* Decides -fault_device auto: a graphics card if there is one that can compute this fault, else the processor. The
   choice replaces "auto" in the options, so that all other code has only two cases. */
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
