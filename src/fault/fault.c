/* A fault's life: create, set up, state, destroy. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>
#include <slipcompat.h>

/*@
  SlipFaultCreate - the reference case "3 km" with one cell

  Collective.

  Input Parameter:
. comm - its processes

  Output Parameter:
. fault - the fault; change it with SlipFaultSetReal(), SlipFaultSetString(), SlipFaultSetFromOptions()

  Level: beginner

.seealso: SlipFaultSetUp(), SlipFaultConfigureTS(), SlipFaultDestroy()
@*/
PetscErrorCode SlipFaultCreate(MPI_Comm comm, SlipFault *fault)
{
  SlipFault f;

  PetscFunctionBegin;
  PetscCall(SlipFaultInitializePackage());
  PetscCall(PetscNew(&f));
  PetscCall(PetscCommDuplicate(comm, &f->comm, NULL));
  f->refct = 1;
  f->scaling = 1;
  for (PetscInt i = 0; i < FAULT_NUM_REALS; i++) f->value[i] = SlipFaultReals[i].value;
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++)
    PetscCall(PetscStrncpy(f->text[i], SlipFaultStrings[i].value, sizeof(f->text[i])));
  *fault = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetUp - compute or load stiffness K, viscosity H, per-cell parameters and the critical state

  Collective. Calling it again does nothing.

  Input Parameter:
. fault - the fault

  Level: beginner

  Errors: parameters out of range, files that cannot be read or hold other shapes, a K that is not positive definite.

.seealso: SlipFaultCreate(), SlipFaultGetOperators()
@*/
PetscErrorCode SlipFaultSetUp(SlipFault fault)
{
  PetscReal thickness;

  PetscFunctionBegin;
  if (fault->setup) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultMeshSetUp(fault));
  PetscCall(SlipFaultGetReal(fault, "thickness", &thickness));
  fault->mass = fault->value[FAULT_DENSITY] * thickness;
  fault->tstar = thickness * PetscSqrtReal(fault->value[FAULT_DENSITY] / fault->value[FAULT_SHEAR_MODULUS]);
  PetscCall(SlipFrictionFind(fault->text[FAULT_FRICTION_LAW], &fault->law));
  PetscCall(SlipFaultCellsSetUp(fault));
  PetscCall(SlipFaultWeightsSetUp(fault));
  PetscCall(SlipFaultStiffnessSetUp(fault));
  PetscCall(SlipFaultCriticalSetUp(fault));
  fault->setup = PETSC_TRUE;
  if (fault->viewer) PetscCall(SlipFaultView(fault, fault->viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultDestroy - release the fault; a TS that it configured keeps it alive until that is destroyed as well

  Collective.

  Input Parameter:
. fault - set to NULL

  Level: beginner

.seealso: SlipFaultCreate()
@*/
PetscErrorCode SlipFaultDestroy(SlipFault *fault)
{
  SlipFault f = *fault;

  PetscFunctionBegin;
  *fault = NULL;
  if (!f || --f->refct > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultOutputDestroy(&f->output));
  PetscCall(SlipFaultRunErrorDestroy(f));
  PetscCall(SlipConstraintDestroy(&f->con));
  PetscCall(PetscViewerDestroy(&f->viewer));
  PetscCall(PetscViewerDestroy(&f->stiffness_viewer));
  for (PetscInt i = 0; i < FAULT_NUM_FIELDS; i++) PetscCall(PetscFree(f->field[i]));
  for (PetscInt i = 0; i < FAULT_NUM_FIELDS; i++) PetscCall(PetscFree(f->given[i]));
  for (PetscInt i = 0; i < 3; i++) PetscCall(VecDestroy(&f->work[i]));
  PetscCall(PetscFree(f->weight));
  PetscCall(SlipCellsDestroy(&f->mesh));
  PetscCall(PetscFree(f->order));
  PetscCall(VecDestroy(&f->uc));
  PetscCall(VecDestroy(&f->vinf));
  PetscCall(VecDestroy(&f->c));
  PetscCall(VecDestroy(&f->u0));
  PetscCall(VecDestroy(&f->s0));
  PetscCall(MatDestroy(&f->B));
  PetscCall(MatDestroy(&f->H));
  PetscCall(MatDestroy(&f->K));
  PetscCall(PetscCommDestroy(&f->comm));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultCreateState - a vector for the state w: block size 3, (v [m/s], u [m], s [m]) per cell

  Collective; after SlipFaultSetUp().

  Input Parameter:
. fault - the fault

  Output Parameter:
. w - zero, of global size 3 N; destroy it

  Level: beginner

  Notes:
  Cell e = iz * nx + ix is entry e. The cells of a mesh are numbered process by process instead.

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultSetInitialState()
@*/
PetscErrorCode SlipFaultCreateState(SlipFault fault, Vec *w)
{
  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  PetscCall(VecCreate(fault->comm, w));
  PetscCall(VecSetSizes(*w, 3 * fault->n, 3 * fault->N));
  PetscCall(VecSetBlockSize(*w, 3));
  PetscCall(VecSetType(*w, VECSTANDARD));
  PetscCall(VecZeroEntries(*w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetInitialState - the start that -fault_initial names

  Collective. "critical": v = 0, s = 0, u = -(1 + perturbation) K^-1 q(0), so that -K u slightly exceeds the strength
  everywhere; "rest": all zero.

  Input Parameters:
+ fault - the fault
- w     - of SlipFaultCreateState(); overwritten

  Options Database Keys:
+ -fault_initial <critical,rest>       - which start
- -fault_initial_perturbation <1e-5>   - relative excess of the critical start, dimensionless

  Level: beginner

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultCreateState()
@*/
PetscErrorCode SlipFaultSetInitialState(SlipFault fault, Vec w)
{
  const PetscReal factor = -(1 + fault->value[FAULT_INITIAL_PERTURBATION]);
  PetscBool critical;
  PetscReal *a;
  const PetscReal *uc;

  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  PetscCall(PetscStrcmp(fault->text[FAULT_INITIAL], "critical", &critical));
  PetscCall(VecZeroEntries(w));
  if (!critical) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(w, &a));
  PetscCall(VecGetArrayRead(fault->uc, &uc));
  for (PetscInt i = 0; i < fault->n; i++) a[3 * i + 1] = factor * uc[i];
  PetscCall(VecRestoreArrayRead(fault->uc, &uc));
  PetscCall(VecRestoreArray(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetOperators - stiffness, viscosity and mass of the fault

  Not collective; after SlipFaultSetUp()

  Input Parameter:
. fault - the fault

  Output Parameters (each may be NULL):
+ K    - stiffness after scaling, N x N [Pa/m], borrowed
. H    - viscosity, N x N [Pa s/m], borrowed
- mass - rho Ly [kg/m^2]

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultSetUp()
@*/
PetscErrorCode SlipFaultGetOperators(SlipFault fault, Mat *K, Mat *H, PetscReal *mass)
{
  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  if (K) *K = fault->K;
  if (H) *H = fault->H;
  if (mass) *mass = fault->mass;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetTimeScale - T* = Ly sqrt(rho/G) [s], the time of a shear wave across the mobilised thickness

  Not collective; after SlipFaultSetUp()

  Input Parameter:
. fault - the fault

  Output Parameter:
. tstar - T* [s]

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultConfigureTS()
@*/
PetscErrorCode SlipFaultGetTimeScale(SlipFault fault, PetscReal *tstar)
{
  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  *tstar = fault->tstar;
  PetscFunctionReturn(PETSC_SUCCESS);
}
