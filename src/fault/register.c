/* What faults register with PETSc. */
#include <slipstep/private/slipfault.h>
#include <slipadapt.h>

PetscClassId SLIP_FAULT_CLASSID;

/* The options of faults: those of the tables, the others that SlipFaultSetFromOptions() reads, and PETSc's for the solver
   of the critical state. */
static PetscErrorCode SlipFaultDeclareOptions(void)
{
  static char names[2048];

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(names, "check_error view stiffness_view output_overwrite start_ksp_* start_pc_*", sizeof(names)));
  for (PetscInt i = 0; i < FAULT_NUM_REALS + FAULT_NUM_STRINGS; i++) {
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(
      names, i < FAULT_NUM_REALS ? SlipFaultReals[i].name : SlipFaultStrings[i - FAULT_NUM_REALS].name, sizeof(names)));
  }
  PetscCall(SlipDeclareOptions("fault_", names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Register_Fault(void)
{
  PetscFunctionBegin;
  PetscCall(SlipAdaptInitializePackage());
  PetscCall(PetscClassIdRegister("SlipFault", &SLIP_FAULT_CLASSID));
  PetscCall(SlipFaultDeclareOptions());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultInitializePackage - register the class of faults and all that a TS of a fault can be made of

  Not collective; after PetscInitialize(). Again it does nothing.

  Level: developer

.seealso: SlipStepInitializePackage(), SlipFaultCreate()
@*/
PetscErrorCode SlipFaultInitializePackage(void)
{
  return SlipRegisterOnce(Register_Fault);
}
