/* Lists the features of a fault and the combinations that it refuses. The same table refuses combinations, prints their
   reference, and lets a test try every pair. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <slipstep/rooms/slipts.h>
#include <string.h>

static PetscBool Chosen(SlipFault fault, PetscInt id, const char name[])
{
  return strcmp(fault->options.text[id], name) ? PETSC_FALSE : PETSC_TRUE;
}

static PetscBool Given(SlipFault fault, PetscInt id)
{
  return fault->options.text[id][0] ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool HasType(TS ts, const char type[])
{
  return ts && !strcmp(((PetscObject)ts)->type_name, type) ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool Lists(SlipFault fault, const char name[])
{
  PetscBool found = PETSC_FALSE;

  return !PetscStrInList(name, fault->options.text[FAULT_OUTPUT_FIELDS], ',', &found) && found ? PETSC_TRUE
                                                                                               : PETSC_FALSE;
}

/* Returns whether a parameter is not 0 in some cell. Collective. */
static PetscBool AnyCell(SlipFault fault, PetscInt field)
{
  int any = 0;

  for (PetscInt i = 0; i < fault->mesh.n; i++) any |= fault->fields.cell[field][i] != 0;
  (void)MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, fault->comm);
  return any ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether an option of pore fluid beside permeability and wells is not its default. Collective. */
static PetscBool FluidDetail(SlipFault fault)
{
  static const PetscInt ids[] = {FAULT_PERMEABILITY_RATIO, FAULT_POROSITY,        FAULT_PORE_COMPRESSIBILITY,
                                 FAULT_FLUID_VISCOSITY,    FAULT_APERTURE,        FAULT_LEAKOFF,
                                 FAULT_CARTER_LEAKOFF,     FAULT_BORDER_PRESSURE, FAULT_FLUID_SOURCE,
                                 FAULT_FLUID_PRESSURE,     FAULT_FLUID_TOLERANCE};
  int any = !Chosen(fault, FAULT_FLUID_BORDER, "closed") || !Chosen(fault, FAULT_PERMEABILITY_LAW, "constant");

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ids); k++) {
    const PetscInt field = SlipFaultFieldOf(ids[k]);
    const PetscReal *x = field < 0 ? &fault->options.value[ids[k]] : fault->fields.cell[field];
    const PetscReal usual = SlipFaultReals[ids[k]].value;

    for (PetscInt i = 0; i < (field < 0 ? 1 : fault->mesh.n); i++)
      any |= x[i] != usual && !(PetscIsNanReal(x[i]) && PetscIsNanReal(usual));
  }
  (void)MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, fault->comm);
  return any ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool LawNeeds(SlipFault fault, PetscInt what)
{
  return SlipPermeabilityFind(fault->options.text[FAULT_PERMEABILITY_LAW])->needs & what ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool HasMesh(SlipFault fault, SlipFaultFeatureId id)
{
  static const SlipFaultMeshKind *const kind[] = {[FEATURE_GRID] = &SlipFaultMeshGrid,
                                                  [FEATURE_RECTANGLES] = &SlipFaultMeshList,
                                                  [FEATURE_TRIANGLES] = &SlipFaultMeshTriangles};

  return fault->mesh.kind == kind[id] ? PETSC_TRUE : PETSC_FALSE;
}

/* Whether a feature is active, in a function called On_NAME */
#define FEATURE_ON(name, group, text, condition)                                                                       \
  static PetscBool On_##name(SlipFault f, TS ts)                                                                       \
  {                                                                                                                    \
    (void)f, (void)ts;                                                                                                 \
    return (condition) ? PETSC_TRUE : PETSC_FALSE;                                                                     \
  }
SLIP_FAULT_FEATURES(FEATURE_ON, FEATURE_ON)

enum { OWN, MESH, MEDIUM, AVERAGE, STORAGE, VISCOSITY, MASS, LAW, STATE, START, COUPLING, INTEGRATOR };

#define EARLY(name, group, text, condition) [FEATURE_##name] = {text, group, PETSC_FALSE, On_##name},
#define LATE(name, group, text, condition) [FEATURE_##name] = {text, group, PETSC_TRUE, On_##name},

const SlipFaultFeature SlipFaultFeatures[FAULT_NUM_FEATURES] = {SLIP_FAULT_FEATURES(EARLY, LATE)};

#define F(name) SLIP_FEATURE(name)
#define EXCLUDES PETSC_FALSE
#define NEEDS PETSC_TRUE

/* The rules are checked in this order, and the first broken one gives the message. */
const SlipFaultRule SlipFaultRules[] = {
  {F(ALWAYS_SLIDES), EXCLUDES, F(CRITICAL) | F(REST), 0,
   "-fault_initial % does not go with -fault_friction_law %, whose cells always slide: expected rate or traction"},
  {F(RATE), NEEDS, F(ALWAYS_SLIDES), 0, "-fault_initial rate needs rate-and-state friction, not -fault_friction_law %"},
  {F(STIFFNESS_FILE), EXCLUDES, F(RECTANGLES) | F(TRIANGLES), 0,
   "-fault_stiffness_file % and -fault_mesh % exclude each other"},
  {F(VECTOR), EXCLUDES, F(STIFFNESS_FILE), 0,
   "-fault_slip_components 2 does not go with -fault_stiffness_file %, which has a number for each pair of cells: "
   "expected 1"},
  {F(OPENING), NEEDS, F(VECTOR), 0, "-fault_opening yes needs slip as a vector: expected -fault_slip_components 2"},
  {F(OPENING), EXCLUDES, F(ALWAYS_SLIDES), 0,
   "-fault_opening yes does not go with -fault_friction_law %, whose cells always slide: expected a law that sticks, "
   "such as linear_slip_weakening"},
  {F(OPENING), NEEDS, F(TRACTION), 0,
   "-fault_opening yes does not go with -fault_initial %: expected traction, with -fault_initial_traction 0 for none"},
  {F(OPENING), EXCLUDES, F(MEAN_SLIP), 0,
   "-fault_opening yes does not go with -fault_stiffness_scaling %: expected none"},
  {F(OPENING), EXCLUDES, F(UNCOUPLED), 0,
   "-fault_opening yes needs the normal stress that slip and opening make: expected -fault_normal_coupling auto or "
   "yes"},
  {F(COUPLED), EXCLUDES, F(STIFFNESS_FILE), 0,
   "-fault_normal_coupling yes needs a kernel, but -fault_stiffness_file % is given, which does not contain normal "
   "stress: expected auto or no"},
  {F(MESH_FRAME), NEEDS, F(RECTANGLES) | F(TRIANGLES), 0,
   "-fault_mesh_frame % is of the file of -fault_mesh, which is not given"},
  {F(MESH_UNIT), NEEDS, F(RECTANGLES) | F(TRIANGLES), 0,
   "-fault_mesh_unit % is of the file of -fault_mesh, which is not given"},
  {F(CREEP), NEEDS, F(ALWAYS_SLIDES), 0, "-fault_creep needs rate-and-state friction without inertia"},
  {F(CREEP), EXCLUDES, F(INERTIA), 0, "-fault_creep needs rate-and-state friction without inertia"},
  {F(RATIOS), EXCLUDES, F(REGIONAL), 0,
   "-fault_regional_ratios % and -fault_regional_stress or -fault_regional_stress_gradient exclude each other"},
  {F(AZIMUTH), NEEDS, F(RATIOS), 0,
   "-fault_regional_azimuth is that of -fault_regional_ratios SHmax/Sv,Shmin/Sv, which is not given"},
  {F(REGIONAL_DETAIL), NEEDS, F(REGIONAL) | F(RATIOS), 0,
   "-fault_regional_pressure and -fault_regional_rake need a stress: expected -fault_regional_stress or "
   "-fault_regional_ratios"},
  {F(INJECTED), NEEDS, F(INJECTION), 0,
   "-fault_injection_pressure, -fault_injection_diffusivity and -fault_injection_stop need the point of "
   "-fault_injection x,z, or x,y,z where there are several planes"},
  {F(INJECTION), NEEDS, F(SOURCE), 0,
   "-fault_injection % needs -fault_injection_pressure [Pa] and -fault_injection_diffusivity [m^2/s]"},
  {F(TIDE), NEEDS, F(TIDAL), 0,
   "-fault_tide_period % needs amplitudes: expected -fault_tide_shear or -fault_tide_normal [Pa]"},
  {F(TIDAL) | F(TIDE_PHASE), NEEDS, F(TIDE), 0,
   "-fault_tide_shear, -fault_tide_normal and -fault_tide_phase need -fault_tide_period [s]"},
  {F(WAVES), EXCLUDES, F(RECTANGLES) | F(TRIANGLES) | F(STIFFNESS_FILE), 0,
   "-fault_medium waves is of one plane with equal cells: expected a uniform grid"},
  {F(WAVES), NEEDS, F(TRACTION) | F(RATE), 0,
   "-fault_medium waves starts from a stress: expected -fault_initial traction, or rate, not %"},
  {F(WAVES), NEEDS, F(RADIATION), 0, "-fault_medium waves radiates: expected -fault_viscosity radiation, not %"},
  {F(WAVES), EXCLUDES, F(INERTIA), 0,
   "-fault_medium waves has the inertia of the rock, all of it: expected -fault_inertia no"},
  {F(WAVES), EXCLUDES, F(OPENING), 0, "-fault_medium waves is of slip alone: expected -fault_opening no"},
  {F(WAVES), EXCLUDES, F(COUPLED), 0,
   "-fault_medium waves is of a plane whose slip does not change its normal stress: expected -fault_normal_coupling "
   "no"},
  {F(WAVES), EXCLUDES, F(MEAN_SLIP), 0,
   "-fault_medium waves computes with the stiffness of the rock: expected -fault_stiffness_scaling none"},
  {F(WAVES), EXCLUDES, F(CELL) | F(WHOLE), 0,
   "-fault_medium waves averages no stress, so that -fault_stiffness_average % has no effect: expected centre"},
  {F(WAVE_PLANE), NEEDS, F(FULL_SPACE) | F(MIRROR), 0,
   "-fault_medium waves of a plane knows no ground, which reflects waves: expected -fault_kernel full_space, mirror, "
   "which approximates it, or an antiplane line (-fault_nx 1)"},
  {F(MIRROR), EXCLUDES, F(OBLIQUE) | F(VECTOR) | F(COUPLED) | F(OPENING) | F(TRIANGLES), 0,
   "-fault_kernel mirror is of slip along strike on vertical rectangles: expected -fault_rake 0, "
   "-fault_slip_components 1 and -fault_normal_coupling no, or -fault_kernel half_space"},
  {F(CELL) | F(WHOLE), EXCLUDES, F(STIFFNESS_FILE), 0,
   "-fault_stiffness_average % cannot average the entries of -fault_stiffness_file %: expected no average"},
  {F(WHOLE), EXCLUDES, F(TRIANGLES), 0,
   "-fault_stiffness_average whole does not support triangles: expected centre or cell"},
  {F(CELL) | F(WHOLE), EXCLUDES, F(OBLIQUE) | F(VECTOR) | F(COUPLED), F(TRIANGLES),
   "-fault_stiffness_average % supports only triangles, and vertical planes with the rake 0: expected centre"},
  {F(FFT) | F(HMAT), EXCLUDES, F(STIFFNESS_FILE), 0,
   "-fault_operator % cannot store the entries of -fault_stiffness_file %: expected dense or auto"},
  {F(FFT), EXCLUDES, F(RECTANGLES) | F(TRIANGLES), 0,
   "-fault_operator fft needs a uniform grid, but -fault_mesh % is an irregular one: expected dense, hmat or auto"},
  {F(SPECTRAL), EXCLUDES, F(STIFFNESS_FILE), 0,
   "-fault_viscosity spectral needs a uniform grid with -fault_operator dense or fft, but -fault_stiffness_file % is "
   "given: expected -fault_viscosity sqrtm, lanczos or none"},
  {F(SPECTRAL), EXCLUDES, F(OBLIQUE) | F(VECTOR) | F(COUPLED) | F(TRIANGLES), 0,
   "-fault_viscosity spectral supports only vertical planes with the rake 0: expected sqrtm, lanczos, radiation or "
   "none"},
  {F(SPECTRAL), EXCLUDES, F(RECTANGLES), 0,
   "-fault_viscosity spectral needs a uniform grid with -fault_operator dense or fft, but -fault_mesh % is given: "
   "expected -fault_viscosity sqrtm, lanczos or none"},
  {F(SPECTRAL), EXCLUDES, F(HMAT), 0,
   "-fault_viscosity spectral needs a uniform grid with -fault_operator dense or fft, but -fault_operator % is given: "
   "expected -fault_viscosity sqrtm, lanczos or none"},
  {F(SPECTRAL), EXCLUDES, F(WHOLE), 0,
   "-fault_viscosity spectral does not know the border of -fault_stiffness_average whole: expected -fault_viscosity "
   "sqrtm, lanczos or none, or -fault_stiffness_average cell"},
  {F(BALANCE), EXCLUDES, F(NONE) | F(UNDAMPED), 0,
   "-fault_inertia no needs a viscosity, which limits slip rates in its place: expected -fault_viscosity radiation, or "
   "another but none with -fault_damping_ratio > 0"},
  {F(STIFFNESS_VIEW), EXCLUDES, F(VECTOR), 0,
   "-fault_stiffness_view writes a number for each pair of cells: expected -fault_slip_components 1"},
  {F(WAVES), EXCLUDES, F(BATHE) | F(MOREAU) | F(ADAMS) | F(RK) | F(RKC) | F(OTHER_TS), 0,
   "-ts_type % takes steps between which waves go on differently: expected lapusta with -fault_medium waves"},
  {F(OTHER_TS), EXCLUDES, F(SLIP_WEAKENING) | F(RATE_WEAKENING) | F(INERTIA) | F(SQRTM) | F(SPECTRAL) | F(LANCZOS), 0,
   "-ts_type % knows no friction, expected bathe or moreau"},
  {F(MOREAU), EXCLUDES, F(BALANCE), 0,
   "-ts_type % needs the inertia that its explicit steps accelerate: expected -fault_inertia yes, or -ts_type bathe"},
  {F(ADAMS) | F(RK) | F(RKC) | F(LAPUSTA), EXCLUDES, F(INERTIA) | F(SQRTM) | F(SPECTRAL) | F(LANCZOS), 0,
   "-ts_type % knows friction only where the slip rate of a cell follows from its own stress: expected bathe, or "
   "-fault_inertia no with -fault_viscosity radiation"},
  {F(ADAMS) | F(RK) | F(RKC) | F(LAPUSTA), EXCLUDES, F(OPENING), 0,
   "-ts_type % does not close cells that open, whose contact is a bound of their displacement: expected bathe"},
  {F(RKC), EXCLUDES, F(ALWAYS_SLIDES), 0,
   "-ts_type rkc does not go with -fault_friction_law %, whose rates change by decades within a step: expected adams, "
   "rk or bathe"},
  {F(CHECKPOINT), EXCLUDES, F(OTHER_TS), 0,
   "-fault_checkpoint and -fault_restart work with -ts_type bathe, rkc, rk, adams or lapusta, not %"},
  {F(CHECK_ERROR), EXCLUDES, F(ADAMS) | F(RK) | F(RKC) | F(LAPUSTA) | F(OTHER_TS), 0,
   "-fault_check_error computes each step in parts, which -ts_type % does not: expected -ts_type bathe, or a second "
   "run with another -ts_rtol"},
  {F(PRESSURISATION), NEEDS, F(SHEAR_ZONE), 0,
   "-fault_thermal_pressurisation needs the zone that slip heats: expected -fault_shear_zone_width > 0"},
  {F(DILATANCY), NEEDS, F(ALWAYS_SLIDES), 0,
   "-fault_dilatancy needs the state of rate-and-state friction, not -fault_friction_law %"},
  {F(SHEAR_ZONE), EXCLUDES, F(OPENING), 0, "-fault_shear_zone_width is of closed cells: expected -fault_opening no"},
  {F(SHEAR_ZONE) | F(DILATANCY), EXCLUDES, F(ALPHA), 0,
   "-fault_shear_zone_width and -fault_dilatancy do not know states that follow normal stress: expected "
   "-fault_friction_alpha 0"},
  {F(SHEAR_ZONE) | F(DILATANCY), EXCLUDES, F(RK) | F(OTHER_TS), 0,
   "-ts_type % does not see the error of pressure across the fault: expected adams, bathe, lapusta or rkc with "
   "-fault_shear_zone_width or -fault_dilatancy"},
  {F(DILATANCY), EXCLUDES, F(BATHE) | F(MOREAU), 0,
   "-ts_type % knows no -fault_dilatancy: expected adams, or lapusta with waves"},
  {F(WELLS), NEEDS, F(FLUID), 0,
   "-fault_wells % needs a fault in which pore fluid flows: expected -fault_permeability > 0 m^2"},
  {F(FLUID_DETAIL) | F(PERMEABILITY_BY_SLIP) | F(PERMEABILITY_BY_STRESS), NEEDS, F(FLUID), 0,
   "-fault_permeability_ratio, -fault_porosity, -fault_pore_compressibility, -fault_fluid_viscosity, -fault_aperture, "
   "-fault_leakoff, -fault_carter_leakoff, -fault_permeability_law, -fault_fluid_border, -fault_border_pressure, "
   "-fault_fluid_source, "
   "-fault_fluid_pressure and "
   "-fault_fluid_tolerance are of a fault in which pore fluid flows: expected -fault_permeability > 0 m^2"},
  {F(CARTER_PRESSURE), NEEDS, F(CARTER), 0,
   "-fault_carter_pressure is of fluid that leaks off: expected -fault_carter_leakoff > 0 m/(Pa s^0.5)"},
  {F(PERMEABILITY_BY_SLIP), NEEDS, F(PERMEABILITY_MAXIMUM), 0,
   "-fault_permeability_law % needs the permeability that slip makes: expected -fault_permeability_maximum > 0 m^2"},
  {F(PERMEABILITY_BY_SLIP), NEEDS, F(PERMEABILITY_SLIP), 0,
   "-fault_permeability_law % needs the slip in which permeability grows: expected -fault_permeability_slip > 0 m"},
  {F(PERMEABILITY_MAXIMUM) | F(PERMEABILITY_SLIP) | F(PERMEABILITY_HEALING), NEEDS, F(PERMEABILITY_BY_SLIP), 0,
   "-fault_permeability_maximum, -fault_permeability_slip and -fault_permeability_healing_time are of permeability "
   "that slip changes: expected -fault_permeability_law slip or valve"},
  {F(PERMEABILITY_BY_STRESS), NEEDS, F(PERMEABILITY_STRESS), 0,
   "-fault_permeability_law % needs the stress that makes permeability fall: expected -fault_permeability_stress > 0 "
   "Pa"},
  {F(PERMEABILITY_STRESS), NEEDS, F(PERMEABILITY_BY_STRESS), 0,
   "-fault_permeability_stress is of permeability that stress changes: expected -fault_permeability_law stress or "
   "valve"},
  {F(FLUID), EXCLUDES, F(OPENING), 0, "-fault_permeability is of closed cells: expected -fault_opening no"},
  {F(PERMEABILITY_BY_SLIP), EXCLUDES, F(RK) | F(OTHER_TS), 0,
   "-ts_type % does not see the error of a pressure that slip changes: expected adams, bathe, lapusta or rkc with "
   "-fault_permeability_law slip or valve"},
  {F(OUTPUT_TEMPERATURE), NEEDS, F(SHEAR_ZONE), 0,
   "-fault_output_fields has temperature, but the fault has none: expected -fault_shear_zone_width > 0"},
  {F(OUTPUT_ZONE), NEEDS, F(PRESSURISATION) | F(DILATANCY), 0,
   "-fault_output_fields has shear_zone_pressure, but the fault has none: expected -fault_thermal_pressurisation or "
   "-fault_dilatancy"},
  {F(OUTPUT_PRESSURE), NEEDS, F(PRESSURE) | F(FLUID), 0,
   "-fault_output_fields has pore_pressure, but the fault has none: expected -fault_pore_pressure, -fault_injection "
   "or -fault_permeability"},
  {F(OUTPUT_FLUID), NEEDS, F(FLUID), 0,
   "-fault_output_fields has permeability or fluid_flux, but no pore fluid flows in the fault: expected "
   "-fault_permeability > 0 m^2"},
  {F(OUTPUT_OPENING), NEEDS, F(OPENING), 0,
   "-fault_output_fields has opening, but cells do not open: expected -fault_opening yes"},
  {F(STATIONS), NEEDS, F(OUTPUT), 0, "-fault_stations % is written to the output: expected -fault_output"},
  {F(SURFACE_STATIONS), NEEDS, F(OUTPUT), 0,
   "-fault_surface_stations % is written to the output: expected -fault_output"},
  {F(SURFACE_STATIONS), EXCLUDES, F(FULL_SPACE) | F(MIRROR), 0,
   "-fault_surface_stations needs a free surface: expected -fault_kernel half_space"},
  {F(DEVICE), EXCLUDES, F(WAVES), 0, "-fault_device % knows no waves: expected -fault_medium static, not %"},
  {F(DEVICE), EXCLUDES, F(HISTORY) | F(TIDE) | F(NUCLEATION), 0,
   "-fault_device % knows no -fault_stress_history, -fault_tide_period and -fault_nucleation: expected none"},
  {F(DEVICE), EXCLUDES, F(SHEAR_ZONE) | F(DILATANCY), 0,
   "-fault_device % knows no -fault_shear_zone_width and -fault_dilatancy: expected neither"},
  {F(DEVICE), EXCLUDES, F(FLUID), 0, "-fault_device % knows no -fault_permeability: expected 0"},
  {F(DEVICE), EXCLUDES, F(LAPUSTA) | F(OTHER_TS), 0,
   "-fault_device % knows no such steps: expected -ts_type bathe, moreau, rkc, adams or rk, not %"},
  {.sentence = NULL},
};

SlipFaultFeatureSet SlipFaultFeaturesOn(SlipFault fault, TS ts)
{
  SlipFaultFeatureSet on = 0;

  for (PetscInt f = 0; f < FAULT_NUM_FEATURES; f++)
    if ((ts || !SlipFaultFeatures[f].late) && (*SlipFaultFeatures[f].on)(fault, ts)) on |= (SlipFaultFeatureSet)1 << f;
  return on;
}

/* Returns the value of an option with choices, where "auto" is decided. */
static const char *ValueOf(SlipFault fault, TS ts, const char name[])
{
  if (ts && !strcmp(name, "ts_type")) return ((PetscObject)ts)->type_name;
  if (!strcmp(name, "fault_initial")) return fault->kind.initial;
  for (PetscInt id = 0; id < FAULT_NUM_STRINGS; id++)
    if (!strncmp(name, "fault_", 6) && !strcmp(name + 6, SlipFaultStrings[id].name)) return fault->options.text[id];
  return "?";
}

PetscErrorCode SlipFaultRuleText(SlipFault fault, TS ts, const SlipFaultRule *rule, char text[], size_t len)
{
  char name[64] = "";

  PetscFunctionBegin;
  text[0] = '\0';
  for (const char *s = rule->sentence; *s; s++) {
    const char one[2] = {*s, '\0'};

    if (!strncmp(s, "-fault_", 7) || !strncmp(s, "-ts_", 4)) {
      const size_t n = strspn(s + 1, "abcdefghijklmnopqrstuvwxyz_");

      PetscCall(PetscStrncpy(name, s + 1, PetscMin(n + 1, sizeof(name))));
      PetscCall(PetscStrlcat(text, "-", len));
      PetscCall(PetscStrlcat(text, s[1] == 'f' ? SlipFaultPrefix(fault) : "", len));
      PetscCall(PetscStrlcat(text, name, len));
      s += n;
    } else
      PetscCall(PetscStrlcat(text, *s == '%' ? ValueOf(fault, ts, name) : one, len));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Refuses(const SlipFaultRule *rule, SlipFaultFeatureSet on)
{
  const PetscBool other = on & rule->others ? PETSC_TRUE : PETSC_FALSE;

  return on & rule->these && !(on & rule->unless) && other != rule->needs ? PETSC_TRUE : PETSC_FALSE;
}

PetscErrorCode SlipFaultRefuses(SlipFault fault, TS ts, SlipFaultFeatureSet these, char text[], size_t len)
{
  const SlipFaultFeatureSet on = SlipFaultFeaturesOn(fault, ts);

  PetscFunctionBegin;
  text[0] = '\0';
  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence && !text[0]; rule++)
    if (Refuses(rule, on | these) && !Refuses(rule, on)) PetscCall(SlipFaultRuleText(fault, ts, rule, text, len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultCheckFeatures(SlipFault fault, TS ts)
{
  const SlipFaultFeatureSet on = SlipFaultFeaturesOn(fault, ts);

  PetscFunctionBegin;
  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence; rule++) {
    char text[2 * PETSC_MAX_PATH_LEN];

    if (!Refuses(rule, on)) continue;
    PetscCall(SlipFaultRuleText(fault, ts, rule, text, sizeof(text)));
    SETERRQ(fault->comm, PETSC_ERR_ARG_INCOMP, "%s", text);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintSet(PetscViewer viewer, SlipFaultFeatureSet set)
{
  const char *before = "";

  PetscFunctionBegin;
  for (PetscInt f = 0; f < FAULT_NUM_FEATURES; f++) {
    if (!(set >> f & 1)) continue;
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s%s", before, SlipFaultFeatures[f].name));
    before = "; ";
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultFeaturesView - prints which features of a fault and of its runs cannot be combined

  Collective

  Input Parameter:
. viewer - an ASCII viewer, `NULL` for standard output

  Options Database Key:
. -fault_features - prints them, in the program fault

  Level: intermediate

  Note:
  There is a line for each rule, with " | " between: features; "not with" or "only with"; others, of which one suffices;
  features that lift it; the sentence by which SlipFaultSetUp() or SlipFaultOutputStart() refuses it, ... in place of
  values. A last line lists the features that no rule names.

.seealso: SlipFaultSetUp(), SlipFaultOutputStart(), SlipObservationView()
@*/
PetscErrorCode SlipFaultFeaturesView(PetscViewer viewer)
{
  SlipFaultFeatureSet named = 0;

  PetscFunctionBegin;
  if (!viewer) PetscCall(PetscViewerASCIIGetStdout(PETSC_COMM_WORLD, &viewer));
  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence; rule++) {
    char text[512];
    size_t n = 0;

    for (const char *s = rule->sentence; *s && n + 4 < sizeof(text); s++)
      for (const char *t = *s == '%' ? "..." : s; *t && (t == s || *s == '%'); t++) text[n++] = *t;
    text[n] = '\0';
    PetscCall(PrintSet(viewer, rule->these));
    PetscCall(PetscViewerASCIIPrintf(viewer, " | %s | ", rule->needs ? "only with" : "not with"));
    PetscCall(PrintSet(viewer, rule->others));
    PetscCall(PetscViewerASCIIPrintf(viewer, " | "));
    PetscCall(PrintSet(viewer, rule->unless));
    PetscCall(PetscViewerASCIIPrintf(viewer, " | %s\n", text));
    named |= rule->these | rule->others;
  }
  PetscCall(PetscViewerASCIIPrintf(viewer, "with all: "));
  PetscCall(PrintSet(viewer, ~named));
  PetscCall(PetscViewerASCIIPrintf(viewer, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
