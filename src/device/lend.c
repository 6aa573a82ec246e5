/* Access of the processor, without a copy, to vectors of a device that computes in the processor's memory. Waiting for
   the device takes 20 microseconds or more with pocl, so that several vectors are mapped at once: its queue is in
   order, and only the last one has to wait. */
#include <slipcompat.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipsys.h>

/* Composed with the vector */
#define LENT "SlipDeviceVecLent"
typedef struct {
  Vec host; /* a VECSEQ without an array */
  SlipDeviceMemory memory;
  PetscReal *array; /* its array while the processor has access */
} Lent;

static PetscErrorCode Destroy(SlipContainerArg arg)
{
  Lent *l = (Lent *)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  PetscCall(VecDestroy(&l->host));
  PetscCall(PetscFree(l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceVecsLend(PetscInt n, PetscInt read, const Vec x[], Vec host[])
{
  SlipDevice device;
  PetscInt m, block;
  Lent *l;

  PetscFunctionBegin;
  PetscCall(SlipDeviceGet(&device));
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(VecGetLocalSize(x[k], &m));
    PetscCall(SlipObjectQueryData((PetscObject)x[k], LENT, &l));
    if (!l) {
      PetscCall(PetscNew(&l));
      PetscCall(SlipObjectComposeData((PetscObject)x[k], LENT, l, Destroy));
      PetscCall(VecGetBlockSize(x[k], &block));
      PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, block, m, NULL, &l->host));
    }
    PetscCall(k < read ? SlipDeviceVecRead(x[k], &l->memory) : SlipDeviceVecWrite(x[k], &l->memory));
    PetscCall(SlipDeviceMap(device, (size_t)m, (PetscBool)(k >= read), (PetscBool)(k == n - 1), l->memory, &l->array));
    PetscCall(VecPlaceArray(l->host, l->array));
    host[k] = l->host;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipDeviceVecsReturn(PetscInt n, const Vec x[], Vec host[])
{
  SlipDevice device;
  Lent *l;

  PetscFunctionBegin;
  PetscCall(SlipDeviceGet(&device));
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(SlipObjectQueryData((PetscObject)x[k], LENT, &l));
    PetscCall(VecResetArray(l->host));
    PetscCall(SlipDeviceUnmap(device, l->memory, &l->array));
    host[k] = NULL;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
