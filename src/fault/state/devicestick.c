/* Computes cells whose friction sticks on a device. Kernels (kernels/stage.cl) replace the loops of faultconstraint.c,
   explicitkick.c and the sums over cells, for slip with one component and built-in laws under constant normal stress.
   The processor computes others, from the mirrors of vectors. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>

/* Numbers stored for each cell, in the order of kernels/stage.cl */
enum { RESIDUAL, DROP, DISTANCE, RATE, STRESS, VINF, TRACTION, STRESSING, NUM_KEPT };
enum { MOST_ARRAYS = 12 };

/* Returns the number of the law in the order of kernels/stage.cl, or -1. */
static int LawOf(SlipFault fault)
{
  static const char *const laws[] = {"exponential_slip_weakening", "linear_slip_weakening", "rate_weakening",
                                     "constant"};

  for (int k = 0; k < 4; k++)
    if (!strcmp(fault->friction.law->name, laws[k])) return k;
  return -1;
}

PetscBool SlipFaultSticksOnDevice(SlipFault fault, PetscInt n, const SlipArrays list[])
{
  if (!fault->device.device || fault->layout.components != 1 || fault->layout.block != 3 || LawOf(fault) < 0)
    return PETSC_FALSE;
  if (fault->mesh.kind != &SlipFaultMeshGrid || fault->kind.oblique) return PETSC_FALSE; /* its weights are 1 */
  if (fault->kind.heals || fault->friction.healing || fault->kind.coupled || fault->loads.pressed) return PETSC_FALSE;
  return SlipDeviceArraysAre(n, list);
}

/* Gets the numbers of the cells; copies them to the device once. */
static PetscErrorCode GetCells(SlipFault fault, Vec *cells)
{
  const PetscInt n = fault->mesh.n;
  PetscReal *const *field = fault->fields.cell;
  SlipFrictionCells friction;
  PetscReal *a;

  PetscFunctionBegin;
  if (!fault->device.sticking) {
    PetscCall(SlipFaultGetFriction(fault, 0, &friction));
    PetscCall(VecCreate(fault->comm, &fault->device.sticking));
    PetscCall(VecSetSizes(fault->device.sticking, NUM_KEPT * n, NUM_KEPT * n));
    PetscCall(VecSetType(fault->device.sticking, VECSLIPOPENCL));
    PetscCall(VecGetArrayWrite(fault->device.sticking, &a));
    for (PetscInt i = 0; i < n; i++) {
      a[RESIDUAL * n + i] = friction.residual[i];
      a[DROP * n + i] = friction.drop[i];
      a[DISTANCE * n + i] = friction.slip[i];
      a[RATE * n + i] = friction.rate[i];
      a[STRESS * n + i] = friction.stress[i];
      a[VINF * n + i] = field[FIELD_LOADING_RATE][i];
      a[TRACTION * n + i] = field[FIELD_INITIAL_TRACTION][i];
      a[STRESSING * n + i] = field[FIELD_STRESSING_RATE][i];
    }
    PetscCall(VecRestoreArrayWrite(fault->device.sticking, &a));
  }
  *cells = fault->device.sticking;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStickRun(SlipFault fault, SlipDeviceKernel kernel, PetscInt numbers, const PetscReal number[],
                                 PetscInt n, const SlipArrays list[])
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceArraysRun(kernel, fault->mesh.n, numbers, number, n, list, 0, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStickFriction(SlipFault fault, SlipDeviceKernel kernel, PetscInt numbers,
                                      const PetscReal number[], PetscInt n, const SlipArrays list[], PetscInt results,
                                      PetscInt sums, PetscReal result[])
{
  SlipArrays arrays[MOST_ARRAYS];
  PetscReal with_law[MOST_ARRAYS];

  PetscFunctionBegin;
  with_law[0] = LawOf(fault);
  for (PetscInt k = 0; k < numbers; k++) with_law[k + 1] = number[k];
  for (PetscInt k = 0; k < n; k++) arrays[k] = list[k];
  arrays[n] = (SlipArrays){.vec = NULL};
  PetscCall(GetCells(fault, &arrays[n].vec));
  PetscCall(SlipDeviceArraysRun(kernel, fault->mesh.n, numbers + 1, with_law, n + 1, arrays, results, sums, result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the shear load by its copy on the device, which is renewed when the load has changed. */
PetscErrorCode SlipFaultStickShear(SlipFault fault, Vec *shear)
{
  SlipFaultDevice *d = &fault->device;
  PetscObjectState state;
  PetscObjectId id;

  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)*shear, &id));
  PetscCall(PetscObjectStateGet((PetscObject)*shear, &state));
  if (!d->shear) {
    PetscCall(VecDuplicate(fault->critical.uc, &d->shear));
    d->shear_id = 0;
  }
  if (id != d->shear_id || state != d->shear_state) PetscCall(VecCopy(*shear, d->shear));
  d->shear_id = id;
  d->shear_state = state;
  *shear = d->shear;
  PetscFunctionReturn(PETSC_SUCCESS);
}
