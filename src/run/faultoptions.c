/* Reads all parameters of a fault from options. */
#include <slipstep/private/sliprun.h>
#include <string.h>

/* Checks that a value is a number. PETSc's own message does not name the option. */
static PetscErrorCode SlipFaultCheckOption(SlipFault fault, const SlipParameter *p, const char option[])
{
  char text[64], bounds[128];
  PetscBool set;
  PetscReal x;
  PetscInt i;
  PetscErrorCode ierr;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(((PetscObject)fault)->options, ((PetscObject)fault)->prefix, option, text,
                                  sizeof(text), &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  ierr = p->integer ? PetscOptionsStringToInt(text, &i) : PetscOptionsStringToReal(text, &x);
  PetscCall(PetscPopErrorHandler());
  SlipParameterBounds(p, PETSC_FALSE, bounds, sizeof(bounds));
  PetscCheck(!ierr, fault->comm, PETSC_ERR_ARG_WRONG, "-%s%s is \"%s\", expected %s%s", SlipFaultPrefix(fault),
             option + 1, text, bounds, SlipIsTimeOption(option + 1) ? ", or with " SLIP_TIME_UNITS " behind it" : "");
  if (p->integer)
    PetscCall(SlipCheckIntegerOption(fault->comm, ((PetscObject)fault)->options, ((PetscObject)fault)->prefix, option));
  else
    PetscCall(SlipFaultCheckReal(fault, p, x)); /* NaN is refused by PETSc from 3.22 on, without a name */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the name of a row's part for -help; parameters of a law belong to the problem. */
static const char *PartText(SlipPart part)
{
  static const char *const text[SLIP_NUM_PARTS] = {"problem", "problem", "problem", "steps", "run", "output"};

  return text[part];
}

static PetscErrorCode SlipFaultRealFromOptions(SlipFault fault, PetscInt id, SlipOptionItems PetscOptionsObject)
{
  const SlipParameter *p = SlipFaultRealRow(id);
  char option[64], help[512], text[64];
  PetscReal value;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(option, sizeof(option), "-fault_%s", p->name));
  PetscCall(PetscSNPrintf(help, sizeof(help), "%s%s%s%s; of the %s", p->help, p->unit[0] ? " [" : "", p->unit,
                          p->unit[0] ? "]" : "", PartText(p->part)));
  PetscCall(SlipFaultGetReal(fault, p->name, &value));
  PetscCall(SlipFaultCheckOption(fault, p, option));
  if (p->integer) {
    PetscInt whole = (PetscInt)value;

    PetscCall(PetscOptionsInt(option, help, "SlipFaultSetReal", whole, &whole, &set));
    value = (PetscReal)whole;
  } else if (PetscIsNanReal(value)) { /* a default that is derived later; PETSc from 3.22 on refuses NaN as a number */
    PetscCall(PetscOptionsString(option, help, "SlipFaultSetReal", "derived", text, sizeof(text), &set));
    if (set) PetscCall(PetscOptionsStringToReal(text, &value));
  } else
    PetscCall(PetscOptionsReal(option, help, "SlipFaultSetReal", value, &value, &set));
  if (set) PetscCall(SlipFaultSetReal(fault, p->name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsList(PetscInt id)
{
  return id == FAULT_INJECTION || (id >= FAULT_TIDE_PERIOD && id <= FAULT_NUCLEATION) ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode SlipFaultStringFromOptions(SlipFault fault, PetscInt id, SlipOptionItems PetscOptionsObject)
{
  const SlipFaultString *p = &SlipFaultStrings[id];
  const PetscOptions options = ((PetscObject)fault)->options;
  char option[64], help[384 + FAULT_MAX_CHOICES], list[FAULT_MAX_CHOICES] = "", value[PETSC_MAX_PATH_LEN];
  const char *whole = NULL;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(option, sizeof(option), "-fault_%s", p->name));
  if (p->choices) PetscCall(SlipFaultListChoices(p, NULL, list, sizeof(list), NULL));
  PetscCall(PetscSNPrintf(help, sizeof(help), "%s%s%s; of the %s%s", p->help, p->choices ? "; one of " : "", list,
                          PartText(p->part), p->value[0] ? "" : " (default none)"));
  PetscCall(
    PetscOptionsString(option, help, "SlipFaultSetString", fault->options.text[id], value, sizeof(value), &set));
  if (set) PetscCall(PetscOptionsFindPair(options, SlipFaultPrefix(fault), option, &whole, NULL)); /* uncut */
  PetscCheck(!set || value[0] || id == FAULT_OUTPUT_FIELDS, fault->comm, PETSC_ERR_ARG_WRONG,
             "-%s%s has no value, expected %s", SlipFaultPrefix(fault), option + 1,
             p->choices                     ? list
             : id == FAULT_STATIONS         ? "points \"x,z;x,z\" in m"
             : id == FAULT_SURFACE_STATIONS ? "points \"x,y;x,y\" in m"
             : IsList(id)                   ? "numbers separated by commas"
                                            : "the name of a file");
  if (set) PetscCall(SlipFaultSetString(fault, p->name, whole ? whole : value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of options that a mesh makes unused: users who give both should know which one has an effect. */
static PetscErrorCode SlipFaultWarnOfGrid(SlipFault fault)
{
  const char *prefix = SlipFaultPrefix(fault);
  static const SlipFaultRealId grid[] = {FAULT_NX,        FAULT_NZ,     FAULT_LENGTH_X, FAULT_LENGTH_Z,
                                         FAULT_DEPTH_TOP, FAULT_STRIKE, FAULT_DIP};
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(grid) && fault->options.text[FAULT_MESH][0] && !rank; i++) {
    char option[64];
    PetscBool set;

    PetscCall(PetscSNPrintf(option, sizeof(option), "-fault_%s", SlipFaultReals[grid[i]].name));
    PetscCall(PetscOptionsHasName(((PetscObject)fault)->options, ((PetscObject)fault)->prefix, option, &set));
    if (set)
      PetscCall(SlipWarning("-%s%s does nothing: the cells of -%sfault_mesh %s count", prefix, option + 1, prefix,
                            fault->options.text[FAULT_MESH]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultSetFromOptions - reads every parameter from the options database, as -<prefix>fault_<name>

  Collective.

  Input Parameter:
. fault - the fault

  Options Database Keys:
+ -fault_<name> <value>           - sets a parameter; -help lists them with unit and default
. -fault_progress <yes>           - prints the progress of a run
. -fault_output_xdmf <yes>        - writes FILE.xdmf2 beside FILE of -fault_output
. -fault_view                     - prints all of them after set-up, and the operators with their memory; at the end
                                    also the time of each part of the run
- -fault_stiffness_view <viewer>  - writes K after scaling, for example to binary:K.bin

  Level: beginner

  Notes:
  Only a fault that has read its options prints lines of progress (-fault_progress) and writes an XDMF file beside its
  output (-fault_output_xdmf). Times may have a unit, see SlipExpandTimes().

  Errors: PETSC_ERR_ARG_WRONG, PETSC_ERR_ARG_OUTOFRANGE or PETSC_ERR_ARG_UNKNOWN_TYPE, with the option and the expected
  values, for a value that is no number, out of bounds, missing or not one of the choices

.seealso: SlipFaultSetReal(), SlipFaultSetString(), SlipFaultSetOptionsPrefix()
@*/
PetscErrorCode SlipFaultSetFromOptions(SlipFault fault)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscOptions options = ((PetscObject)fault)->options;
  static const char *const solvers[] = {"start", "fluid"};
  char own[128];

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(SlipExpandTimes(options));
  for (int i = 0; i < 2; i++) {
    PetscCall(PetscSNPrintf(own, sizeof(own), "%sfault_%s_", prefix, solvers[i]));
    PetscCall(SlipCheckLinearOptions(fault->comm, options, own));
  }
  PetscObjectOptionsBegin((PetscObject)fault);
  for (PetscInt id = 0; SlipFaultRealRow(id); id++) PetscCall(SlipFaultRealFromOptions(fault, id, PetscOptionsObject));
  for (PetscInt id = 0; id < FAULT_NUM_STRINGS; id++)
    PetscCall(SlipFaultStringFromOptions(fault, id, PetscOptionsObject));
  fault->options.reports = fault->options.output_xdmf = fault->options.progress = PETSC_TRUE;
  for (PetscInt i = 0; i < FAULT_NUM_SWITCHES; i++) {
    PetscBool value = *(PetscBool *)((char *)fault + SlipFaultSwitches[i].offset), set;
    char option[64], help[512];

    PetscCall(PetscSNPrintf(option, sizeof(option), "-fault_%s", SlipFaultSwitches[i].name));
    PetscCall(PetscSNPrintf(help, sizeof(help), "%s; of the %s", SlipFaultSwitches[i].help,
                            PartText(SlipFaultSwitches[i].part)));
    PetscCall(SlipCheckBoolOption(fault->comm, ((PetscObject)fault)->options, SlipFaultPrefix(fault), option));
    PetscCall(PetscOptionsBool(option, help, SlipFaultSwitches[i].manual, value, &value, &set));
    if (set) PetscCall(SlipFaultSetBool(fault, SlipFaultSwitches[i].name, value));
  }
  PetscCall(SlipFaultWarnOfGrid(fault));
  PetscCall(SlipFaultCheckFileNames(fault)); /* viewers open their files at once */
  PetscCall(PetscViewerDestroy(&fault->options.viewer));
  PetscCall(PetscOptionsViewer("-fault_view",
                               "Print the parameters and the operators after set-up, and at the end where time went",
                               "SlipFaultView", &fault->options.viewer, &fault->options.format, NULL));
  if (fault->options.viewer) SlipWorkMeasure();
  PetscCall(PetscViewerDestroy(&fault->options.stiffness_viewer));
  PetscCall(PetscOptionsViewer("-fault_stiffness_view", "Write K [Pa/m] after scaling, for example to binary:K.bin",
                               "SlipFaultSetUp", &fault->options.stiffness_viewer, &fault->options.stiffness_format,
                               NULL));
  PetscOptionsEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}
