/* -fault_device auto: a graphics card where there is one that can compute this fault, else the processor. What was
   chosen stands in the place of "auto" in the options from then on, so that everything else knows two choices. */
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

/* A TS of the type that the options ask for, for what devices do not go with; NULL: of none that there is */
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

/* Before features are checked: what the fault is, how many processes there are, whether there is a card. Collective */
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

/* Is there room for device.bytes? Where there is none auto takes the processor, else this ends with a line. */
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
