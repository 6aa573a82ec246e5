/* Creates a fault, sets it up and destroys it. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <math.h>
#include <slipstep/private/slipwork.h>

/*@
  SlipFaultCreate - creates a fault with the parameters of the reference case "3 km" and one cell

  Collective.

  Input Parameter:
. comm - the processes of the fault

  Output Parameter:
. fault - the fault; change it with SlipFaultSetReal(), SlipFaultSetString(), SlipFaultSetFromOptions()

  Level: beginner

.seealso: SlipFaultSetUp(), SlipFaultConfigureTS(), SlipFaultDestroy()
@*/
PetscErrorCode SlipFaultCreate(MPI_Comm comm, SlipFault *fault)
{
  SlipFault f;

  PetscFunctionBegin;
  PetscAssertPointer(fault, 2);
  PetscCall(SlipFaultInitializePackage());
  PetscCall(PetscHeaderCreate(f, SLIP_FAULT_CLASSID, "SlipFault", "Strike-slip fault", "SlipFault", comm,
                              SlipFaultDestroy, SlipFaultView));
  PetscCall(PetscObjectChangeTypeName((PetscObject)f, "strike_slip"));
  f->comm = PetscObjectComm((PetscObject)f);
  f->layout =
    (SlipFaultLayout){.components = 1, .plane = 1, .block = 3, .rate = 0, .displacement = 1, .state = 2, .states = 1};
  f->operators.scaling = 1;
  f->options.inertia = PETSC_TRUE;
  PetscCall(PetscNew(&f->run));
  f->run->events = -1;
  f->told = SlipFaultProgressSetUp;
  for (PetscInt i = 0; i < FAULT_MAX_REALS; i++)
    f->options.value[i] = i < FAULT_NUM_REALS ? SlipFaultReals[i].value : (PetscReal)NAN;
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++)
    PetscCall(PetscStrncpy(f->options.text[i], SlipFaultStrings[i].value, sizeof(f->options.text[i])));
  *fault = f;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetUpMesh - creates the cells of a fault, before its fields are given

  Collective. Calling it again does nothing.

  Input Parameter:
. fault - the fault

  Level: intermediate

  Note:
  SlipFaultSetUp() calls it as well. After it, SlipFaultGetGeometry() and SlipFaultGetCentres() give the positions of
  the cells, so that fields can be functions of them: SlipFaultSetField(). All other parameters must be set before.

  Errors: a mesh that cannot be read or used, an unknown friction law

.seealso: SlipFaultSetUp(), SlipFaultGetGeometry(), SlipFaultSetField()
@*/
PetscErrorCode SlipFaultSetUpMesh(SlipFault fault)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  if (fault->meshed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFrictionFind(fault->options.text[FAULT_FRICTION_LAW], &fault->friction.law));
  PetscCall(SlipFaultChooseDefaults(fault));
  PetscCall(SlipFaultChooseComponents(fault));
  PetscCall(SlipFaultMeshSetUp(fault));
  fault->meshed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(SlipFault fault)
{
  PetscReal thickness;

  PetscFunctionBegin;
  PetscCall(SlipFaultSetUpMesh(fault));
  PetscCall(SlipFaultGetReal(fault, "thickness", &thickness));
  fault->operators.mass = fault->options.value[FAULT_DENSITY] * thickness;
  fault->operators.tstar =
    thickness * PetscSqrtReal(fault->options.value[FAULT_DENSITY] / fault->options.value[FAULT_SHEAR_MODULUS]);
  PetscCall(SlipFaultCellsSetUp(fault));
  PetscCall(SlipFaultDeviceChoose(fault));
  PetscCall(SlipFaultCheckFeatures(fault, NULL));
  PetscCall(SlipFaultDeviceSetUp(fault));
  PetscCall(SlipFaultMediumCreate(fault));
  PetscCall(SlipFaultLoadsSetUp(fault));
  PetscCall(SlipFaultForecastView(fault));
  PetscCall(SlipFaultStiffnessSetUp(fault));
  SlipFaultCellsChoose(fault);
  PetscCall(SlipFaultCriticalSetUp(fault));
  PetscCall(SlipFaultZoneSetUp(fault));
  PetscCall(SlipFaultCouplingSetUp(fault));
  PetscCall(SlipFaultFollowSetUp(fault));
  PetscCall(SlipFaultBalanceSetUp(fault));
  PetscCall(SlipFaultResolutionSetUp(fault));
  fault->setup = PETSC_TRUE;
  PetscCall(SlipFaultProgressSetUpEnd(fault));
  PetscCall(SlipFaultWarn(fault));
  if (fault->options.viewer) {
    PetscCall(PetscViewerPushFormat(fault->options.viewer, fault->options.format));
    PetscCall(SlipFaultView(fault, fault->options.viewer));
    PetscCall(PetscViewerPopFormat(fault->options.viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetUp - computes or loads stiffness K, viscosity H, per-cell parameters and the critical state

  Collective. Calling it again does nothing.

  Input Parameter:
. fault - the fault

  Level: beginner

  Errors: parameters out of range, files that cannot be read or have other shapes, a K that is not positive definite;
  PETSC_ERR_ARG_INCOMP for features that cannot be combined, which SlipFaultFeaturesView() lists

.seealso: SlipFaultCreate(), SlipFaultGetOperators()
@*/
PetscErrorCode SlipFaultSetUp(SlipFault fault)
{
  static PetscBool begun = PETSC_FALSE; /* another fault was set up in this process */
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  if (fault->setup) PetscFunctionReturn(PETSC_SUCCESS);
  for (int i = 0; i < SLIP_PRODUCTS_USERS; i++) SlipProductsGetOf((SlipProductsUser)i, &fault->run->before[i]);
  fault->run->work = SlipWorkGet();
  fault->run->time = begun ? SlipProcessorTime() : 0; /* the first run includes the time before it */
  if (!begun) PetscCall(PetscMemzero(&fault->run->work, sizeof(fault->run->work)));
  begun = PETSC_TRUE;
  SlipWorkPrepare();
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
  SlipWorkAdd(SLIP_WORK_RUN, 1);
  ierr = SetUp(fault);
  if (ierr) SlipProductsRun(); /* the program may continue with another fault */
  PetscCall(ierr);
  PetscCall(SlipProductsPop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultDestroy - destroys the fault; a TS that it configured keeps it alive until the TS is destroyed as well

  Collective.

  Input Parameter:
. fault - the fault; set to NULL

  Level: beginner

.seealso: SlipFaultCreate(), SlipFaultReference()
@*/
PetscErrorCode SlipFaultDestroy(SlipFault *fault)
{
  SlipFault f = *fault;

  PetscFunctionBegin;
  if (!f) PetscFunctionReturn(PETSC_SUCCESS);
  PetscValidHeaderSpecific(f, SLIP_FAULT_CLASSID, 1);
  *fault = NULL;
  if (--((PetscObject)f)->refct > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultObserversDestroy(f));
  PetscCall(SlipConstraintDestroy(&f->stage.con));
  PetscCall(PetscViewerDestroy(&f->options.viewer));
  PetscCall(PetscViewerDestroy(&f->options.stiffness_viewer));
  for (PetscInt i = 0; i < FAULT_MAX_FIELDS; i++) PetscCall(PetscFree(f->fields.cell[i]));
  for (PetscInt i = 0; i < FAULT_MAX_FIELDS; i++) PetscCall(PetscFree(f->fields.given[i]));
  PetscCall(PetscFree(f->fields.tendency));
  PetscCall(PetscFree(f->friction.own));
  PetscCall(PetscFree(f->friction.known));
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++) PetscCall(PetscFree(f->options.longer[i]));
  PetscCall(PetscFree(f->layout.along));
  PetscCall(PetscFree(f->layout.sizes));
  {
    Vec *vecs[] = {&f->critical.uc, &f->operators.vinf, &f->stage.c, &f->stage.u0, &f->stage.s0, &f->cells};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
    for (PetscInt i = 0; i < FAULT_WORK; i++) PetscCall(VecDestroy(&f->work[i]));
  }
  PetscCall(SlipFaultLoadsDestroy(f));
  PetscCall(SlipFaultBalanceDestroy(f));
  PetscCall(SlipFaultDeviceDestroy(f));
  PetscCall(SlipFaultSettledDestroy(f));
  PetscCall(SlipFaultCouplingDestroy(f));
  PetscCall(SlipFaultZoneDestroy(f));
  PetscCall(SlipFaultMeshDestroy(&f->mesh));
  PetscCall(SlipElasticDestroy(&f->medium));
  PetscCall(PetscFree(f->run));
  PetscCall(PetscHeaderDestroy(&f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a reference to a fault. */
PetscErrorCode SlipFaultReference(SlipFault fault)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(PetscObjectReference((PetscObject)fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultSetOptionsPrefix - sets the prefix of this fault's options, for several faults in one program

  Logically collective; before SlipFaultSetFromOptions()

  Input Parameters:
+ fault  - the fault
- prefix - with "upper_" the option for the cells along strike is -upper_fault_nx; NULL for none. Copied.

  Level: intermediate

  Notes:
  Stiffness, viscosity and stage operator have the prefix too, and so does the solver of the critical state,
  -<prefix>fault_start_ksp_type. A TS has a prefix of its own.

.seealso: SlipFaultAppendOptionsPrefix(), SlipFaultGetOptionsPrefix(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultSetOptionsPrefix(SlipFault fault, const char prefix[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(PetscObjectSetOptionsPrefix((PetscObject)fault, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultAppendOptionsPrefix - appends to the prefix of this fault's options

  Logically collective; before SlipFaultSetFromOptions()

  Input Parameters:
+ fault  - the fault
- prefix - appended to the present prefix

  Level: advanced

.seealso: SlipFaultSetOptionsPrefix(), SlipFaultGetOptionsPrefix(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultAppendOptionsPrefix(SlipFault fault, const char prefix[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(PetscObjectAppendOptionsPrefix((PetscObject)fault, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetOptionsPrefix - gets the prefix of this fault's options

  Not collective

  Input Parameter:
. fault - the fault

  Output Parameter:
. prefix - borrowed; NULL for none

  Level: intermediate

.seealso: SlipFaultSetOptionsPrefix()
@*/
PetscErrorCode SlipFaultGetOptionsPrefix(SlipFault fault, const char *prefix[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscAssertPointer(prefix, 2);
  PetscCall(PetscObjectGetOptionsPrefix((PetscObject)fault, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}
