/* Warns before a run, one line each, of options that were given without effect, because another choice excludes them.
   Only a fault that has read its options warns, on rank 0. adapt/rlidle.c does the same for options of steps. */
#include <slipstep/private/sliprun.h>
#include <slipstep/rooms/slipsys.h>
#include <string.h>

/* ---- conditions under which options are unused ---- */

static PetscBool Is(const char choice[], const char name[])
{
  return strcmp(choice, name) ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool NotCritical(SlipFault fault)
{
  return Is(fault->kind.initial, "critical") ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool NotFromTraction(SlipFault fault)
{
  return Is(fault->kind.initial, "traction") ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool NoState(SlipFault fault)
{
  return fault->friction.law->always_slides ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool NoCutoff(SlipFault fault)
{
  return NoState(fault) || fault->friction.state_law != SLIP_STATE_COMPOSITE ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool OwnState(SlipFault fault)
{
  return Is(fault->friction.law->name, "strong_rate_weakening");
}

/* The law evolves the state by itself; with inertia, healing changes the steps nevertheless. */
static PetscBool OwnHealing(SlipFault fault)
{
  return fault->friction.law->nstates && !fault->kind.inertia ? PETSC_TRUE : PETSC_FALSE;
}

/* H does not grow with the square root of K */
static PetscBool NoRoot(SlipFault fault)
{
  return Is(fault->kind.viscosity, "radiation") || Is(fault->kind.viscosity, "none") ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool NoLanczos(SlipFault fault)
{
  return Is(fault->kind.viscosity, "lanczos") ? PETSC_FALSE : PETSC_TRUE;
}

/* Checks the types of the matrices, as -fault_operator auto may have chosen them. */
static PetscBool NoHierarchy(SlipFault fault)
{
  PetscBool is;

  PetscCallAbort(PETSC_COMM_SELF, SlipFaultIsHierarchical(fault, &is));
  return is ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool NoFiles(SlipFault fault)
{
  return fault->options.text[FAULT_OUTPUT][0] || fault->options.text[FAULT_CATALOGUE][0] ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool KFromFile(SlipFault fault)
{
  return fault->options.text[FAULT_STIFFNESS_FILE][0] ? PETSC_TRUE : PETSC_FALSE;
}

static const struct {
  const char *names; /* separated by blanks */
  PetscBool (*idle)(SlipFault);
  const char *why;
} Rows[] = {
  {"initial_perturbation", NotCritical, "it is for -fault_initial critical"},
  {"initial_unstable", NotFromTraction, "it is for -fault_initial traction"},
  {"state_law initial_rate initial_state", NoState, "it is for -fault_friction_law rate_and_state"},
  {"state_law state_cutoff_rate", OwnState, "the state of this -fault_friction_law evolves by a law of its own"},
  {"state_cutoff_rate", NoCutoff, "it is for -fault_state_law composite"},
  {"healing_time", OwnHealing, "the state of this -fault_friction_law evolves by a law of its own"},
  {"damping_ratio", NoRoot, "it is for -fault_viscosity sqrtm, spectral and lanczos"},
  {"krylov_tolerance", NoLanczos, "it is for -fault_viscosity lanczos"},
  {"hmat_tolerance", NoHierarchy, "there is no hierarchical matrix (-fault_operator hmat)"},
  {"kernel stiffness_average", KFromFile, "-fault_stiffness_file has the stiffness"},
  {"output_overwrite", NoFiles, "there is neither -fault_output nor -fault_catalogue"},
};

/* Options that go with a text that is not given */
static const struct {
  const char *names;
  PetscInt text;
  const char *why;
} Missing[] = {
  {"injection_pressure injection_diffusivity injection_stop", FAULT_INJECTION, "there is no -fault_injection"},
  {"output_fields output_interval output_slip_interval output_time_interval output_rate_change output_size "
   "output_compression output_precision output_xdmf stations surface_stations",
   FAULT_OUTPUT, "there is no -fault_output"},
  {"surface_motion", FAULT_SURFACE_STATIONS, "there are no -fault_surface_stations"},
  {"catalogue_maps event_rate", FAULT_CATALOGUE, "there is no -fault_catalogue"},
  {"checkpoint_interval", FAULT_CHECKPOINT, "there is no -fault_checkpoint"},
  {"restart_dt", FAULT_RESTART, "there is no -fault_restart"},
};

/* ---- warnings ---- */

static PetscErrorCode Given(SlipFault fault, const char name[], PetscBool *given)
{
  char option[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(option, sizeof(option), "-fault_%s", name));
  PetscCall(PetscOptionsHasName(((PetscObject)fault)->options, ((PetscObject)fault)->prefix, option, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of those of several options that are given. */
static PetscErrorCode WarnOf(SlipFault fault, const char names[], const char why[])
{
  char name[SLIP_NAME_LENGTH];
  PetscBool given;

  PetscFunctionBegin;
  while (SlipNextName("", &names, name)) {
    PetscCall(Given(fault, name, &given));
    if (given) PetscCall(SlipWarning("-%sfault_%s has no effect: %s", SlipFaultPrefix(fault), name, why));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultWarnOfIdle(SlipFault fault)
{
  const char *prefix = SlipFaultPrefix(fault);
  const SlipFrictionLaw *law = fault->friction.law;
  const SlipParameter *p;

  PetscFunctionBegin;
  /* Warns of numbers of friction that the law does not use; a user's law may use any. */
  for (PetscInt id = FAULT_FRICTION_RESIDUAL; id <= FAULT_FRICTION_REFERENCE_RATE && law->reads; id++) {
    const char *reads = law->reads;
    PetscBool given, read = PETSC_FALSE;
    char name[SLIP_NAME_LENGTH];

    while (SlipNextName("friction_", &reads, name))
      if (!strcmp(name, SlipFaultReals[id].name)) read = PETSC_TRUE;
    PetscCall(Given(fault, SlipFaultReals[id].name, &given));
    if (given && !read)
      PetscCall(SlipWarning("-%sfault_%s has no effect: the law %s does not read it (-%sfault_friction_law)", prefix,
                            SlipFaultReals[id].name, law->name, prefix));
  }
  /* Warns of numbers that fields override; warn.c handles the gradient. */
  for (PetscInt id = 0; (p = SlipFaultRealRow(id)); id++) {
    const PetscInt field = SlipFaultFieldOf(id);
    PetscBool given;

    if (field < 0 || !fault->fields.source[field]) continue;
    PetscCall(Given(fault, p->name, &given));
    if (given)
      PetscCall(SlipWarning("-%sfault_%s has no effect: %s: /%s has the values of all cells", SlipFaultPrefix(fault),
                            p->name, fault->fields.source[field], p->name));
  }
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Rows); i++)
    if ((*Rows[i].idle)(fault)) PetscCall(WarnOf(fault, Rows[i].names, Rows[i].why));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Missing); i++)
    if (!fault->options.text[Missing[i].text][0]) PetscCall(WarnOf(fault, Missing[i].names, Missing[i].why));
  PetscFunctionReturn(PETSC_SUCCESS);
}
