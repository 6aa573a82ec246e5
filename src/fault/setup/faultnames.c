/* Lists the names of the options of faults, so that unknown options can be found. */
#include <slipstep/private/slipfault.h>
#include <string.h>

static PetscErrorCode AddName(char names[], size_t len, const char before[], const char name[])
{
  PetscFunctionBegin;
  PetscCall(PetscStrlcat(names, before, len));
  PetscCall(PetscStrlcat(names, name, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists all that may follow "fault_", separated by blanks. */
PetscErrorCode SlipFaultOptionNames(char names[], size_t len)
{
  const SlipParameter *p;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(names, "view stiffness_view start_ksp_* start_pc_* fluid_ksp_* fluid_pc_*", len));
  for (PetscInt i = 0; i < FAULT_NUM_SWITCHES; i++) PetscCall(AddName(names, len, " ", SlipFaultSwitches[i].name));
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++) PetscCall(AddName(names, len, " ", SlipFaultStrings[i].name));
  for (PetscInt i = 0; (p = SlipFaultRealRow(i)); i++) PetscCall(AddName(names, len, " ", p->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Declares the options of faults to SlipCheckOptionNames(): those of the tables, the others that
   SlipFaultSetFromOptions() reads, and PETSc's for the solvers of the critical state and of pore
   fluid. */
PetscErrorCode SlipFaultDeclareOptions(void)
{
  static char names[FAULT_MAX_NAMES], times[FAULT_MAX_NAMES];
  const SlipParameter *p;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < FAULT_NUM_REALS; i++)
    PetscCheck(SlipFaultReals[i].part, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "the row of -fault_%s does not say what it is part of: expected a SlipPart", SlipFaultReals[i].name);
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++)
    PetscCheck(SlipFaultStrings[i].part, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "the row of -fault_%s does not say what it is part of: expected a SlipPart", SlipFaultStrings[i].name);
  for (PetscInt i = 0; i < FAULT_NUM_SWITCHES; i++)
    PetscCheck(SlipFaultSwitches[i].part, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "the row of -fault_%s does not say what it is part of: expected a SlipPart", SlipFaultSwitches[i].name);
  PetscCall(SlipFaultOptionNames(names, sizeof(names)));
  times[0] = '\0';
  for (PetscInt i = 0; (p = SlipFaultRealRow(i)); i++)
    if (!strcmp(p->unit, "s")) PetscCall(AddName(times, sizeof(times), " fault_", p->name));
  PetscCall(AddName(times, sizeof(times), " fault_", SlipFaultStrings[FAULT_TIDE_PERIOD].name));
  PetscCall(SlipDeclareTimes(times));
  PetscCall(SlipDeclareOptions("fault_", names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
