/* Handles vectors of slip: one component, along the rake of each cell, or two, along its strike and up its dip. With
   two, loading, shear load and start are along the rake, friction opposes the slip rate in any direction, and
   quantities without direction, such as the state of friction, depend on the magnitude. Opening is a third component.
   */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipsys.h>

/* Chooses the places of a cell's numbers in a state; before the mesh. */
PetscErrorCode SlipFaultChooseComponents(SlipFault fault)
{
  const PetscInt c = (PetscInt)fault->options.value[FAULT_SLIP_COMPONENTS];

  PetscFunctionBegin;
  fault->layout.plane = c;
  fault->layout.components = fault->options.opening ? 3 : c;
  fault->layout.states = SlipFrictionStates(fault->friction.law);
  fault->layout.block = 2 * fault->layout.components + fault->layout.states;
  fault->layout.rate = 0;
  fault->layout.displacement = fault->layout.components;
  fault->layout.state = 2 * fault->layout.components;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the direction in which each cell is loaded, a vector of cells, and room for magnitudes; after the fields. */
PetscErrorCode SlipFaultComponentsSetUp(SlipFault fault)
{
  const PetscInt c = fault->layout.components;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(PetscMax(c * fault->mesh.n, 1), &fault->layout.along));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal *along = fault->layout.along + c * i;

    along[0] = 1;
    for (PetscInt k = 1; k < c; k++) along[k] = 0;
    if (c > 1) SlipDegrees(fault->fields.cell[FIELD_RAKE][i], &along[1], &along[0]);
  }
  if (c > 1) PetscCall(PetscMalloc1(2 * fault->mesh.n + 1, &fault->layout.sizes));
  PetscCall(VecCreate(fault->comm, &fault->cells));
  PetscCall(VecSetSizes(fault->cells, fault->mesh.n, fault->mesh.N));
  PetscCall(VecSetType(fault->cells, VECSTANDARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the numbers from an offset in the block of each cell, as many as slip has components, into x; or back. */
PetscErrorCode SlipFaultMove(SlipFault fault, PetscInt offset, PetscBool back, Vec w, Vec x)
{
  const PetscReal numbers[] = {(PetscReal)fault->layout.components, (PetscReal)fault->layout.block, (PetscReal)offset};

  PetscFunctionBegin;
  if (fault->layout.components == 1)
    PetscCall(back ? VecStrideScatter(x, offset, w, INSERT_VALUES) : VecStrideGather(w, offset, x, INSERT_VALUES));
  else
    PetscCall(SlipLoopRun(back ? SLIP_LOOP_PLACE_BLOCK : SLIP_LOOP_TAKE_BLOCK, fault->mesh.n, numbers,
                          back ? (const Vec[]){x, w} : (const Vec[]){w, x}, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultGetRate(SlipFault fault, Vec w, Vec v)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultMove(fault, fault->layout.rate, PETSC_FALSE, w, v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultGetDisplacement(SlipFault fault, Vec w, Vec u)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultMove(fault, fault->layout.displacement, PETSC_FALSE, w, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills x along the rake of each cell with value [n], or with 1 for NULL, times the cell's weight if weighted. */
PetscErrorCode SlipFaultFillAlong(SlipFault fault, const PetscReal value[], PetscBool weighted, Vec x)
{
  const PetscInt c = fault->layout.components;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal size = (value ? value[i] : 1) * (weighted ? fault->mesh.weight[i] : 1);

    for (PetscInt k = 0; k < c; k++) a[c * i + k] = size * SlipFaultAlong(fault, i)[k];
  }
  PetscCall(VecRestoreArrayWrite(x, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest |v| of a state [m/s]. Collective. */
PetscErrorCode SlipFaultLargestSpeed(SlipFault fault, Vec w, PetscReal *largest)
{
  PetscFunctionBegin;
  PetscCall(SlipVecLargestStart(w, fault->layout.block, fault->layout.components, largest));
  PetscCall(SlipAllreduceLargest(fault->comm, 1, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets a vector of slip for use within a function; its content is arbitrary. */
PetscErrorCode SlipFaultGetWork(SlipFault fault, Vec *x)
{
  PetscInt k = 0;

  PetscFunctionBegin;
  while (k < FAULT_WORK && fault->taken[k]) k++;
  PetscCheck(k < FAULT_WORK, fault->comm, PETSC_ERR_PLIB, "more than %d vectors of slip are in use", FAULT_WORK);
  if (!fault->work[k]) PetscCall(VecDuplicate(fault->critical.uc, &fault->work[k]));
  fault->taken[k] = PETSC_TRUE;
  *x = fault->work[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultRestoreWork(SlipFault fault, Vec *x)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < FAULT_WORK; k++)
    if (*x && fault->work[k] == *x) fault->taken[k] = PETSC_FALSE;
  *x = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
