/* Warns before a run, a line each, of implausible numbers, as in other units; of starts and thicknesses that decide a
   result without notice; and of what the equations leave out. Only a fault that has read its options warns, on rank 0.
   */
#include <slipstep/private/sliprun.h>
#include <slipstep/rooms/slipsys.h>
#include <math.h>

/* ---- units ---- */

/* Magnitudes of a parameter on faults in nature or in a laboratory, and the unit that smaller or larger ones suggest. 0
   is plausible everywhere. */
static const struct {
  SlipFaultRealId id;
  PetscReal least, most;
  const char *small, *large;
} plausible[] = {
  {FAULT_LENGTH_X, 100, MESH_MAX_REACH, "km", ""},
  {FAULT_LENGTH_Z, 100, MESH_MAX_DEPTH, "km", ""},
  {FAULT_THICKNESS, 1, MESH_MAX_REACH, "km", ""},
  {FAULT_SHEAR_MODULUS, 1e7, 1e12, "GPa", "less than a Pa"},
  {FAULT_DENSITY, 100, 3e4, "g/cm^3", "g/m^3"},
  {FAULT_NORMAL_STRESS, 1e4, 1e10, "MPa", "less than a Pa"},
  {FAULT_NORMAL_STRESS_GRADIENT, 100, 1e6, "MPa/km", "Pa/km"},
  {FAULT_FRICTION_RESIDUAL, 1e-3, 2, "hundreds", "per cent"},
  {FAULT_FRICTION_DROP, 1e-6, 2, "hundreds", "per cent"},
  {FAULT_FRICTION_REFERENCE, 1e-3, 2, "hundreds", "per cent"},
  {FAULT_FRICTION_A, 1e-5, 0.3, "hundreds", "per cent"},
  {FAULT_FRICTION_B, 1e-5, 0.3, "hundreds", "per cent"},
  {FAULT_FRICTION_SLIP, 1e-7, 20, "km", "mm"},
  {FAULT_LOADING_RATE, 1e-15, 0.1, "km/s", "mm a year"},
  {FAULT_INITIAL_TRACTION, 1e3, 1e10, "MPa", "less than a Pa"},
  {FAULT_INJECTION_PRESSURE, 100, 1e10, "MPa", "less than a Pa"},
  {FAULT_PERMEABILITY, 1e-24, 1e-7, "km^2", "darcys"},
  {FAULT_PERMEABILITY_MAXIMUM, 1e-24, 1e-7, "km^2", "darcys"},
  {FAULT_PERMEABILITY_SLIP, 1e-7, 100, "km", "mm"},
  {FAULT_PERMEABILITY_STRESS, 1e3, 1e10, "MPa", "less than a Pa"},
  {FAULT_PORE_COMPRESSIBILITY, 1e-13, 1e-5, "1/(less than a Pa)", "1/MPa or 1/GPa"},
  {FAULT_FLUID_VISCOSITY, 1e-6, 10, "kPa s", "mPa s"},
};

/* A small length is plausible for a laboratory where d_c is below this share of it: samples of 0.1 to 3 m have d_c of
   1e-7 to 1e-5 m, and faults of 1 to 100 km whose lengths are given in km have 1e-3 m and more. */
#define LABORATORY_SLIP 3e-5

/* Finds the largest magnitude of a parameter, over all cells where it comes from a file or an array. Collective. */
static PetscErrorCode LargestMagnitude(SlipFault fault, SlipFaultRealId id, PetscReal *largest, const char **source)
{
  const PetscInt f = SlipFaultFieldOf(id);

  PetscFunctionBegin;
  *source = f < 0 ? NULL : fault->fields.source[f];
  *largest = *source ? 0 : PetscAbsReal(fault->options.value[id]);
  if (!*source) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < fault->mesh.n; i++) *largest = PetscMax(*largest, PetscAbsReal(fault->fields.cell[f][i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WarnOfUnits(SlipFault fault, PetscMPIInt rank)
{
  const char *prefix = SlipFaultPrefix(fault), *source;
  char what[PETSC_MAX_PATH_LEN + 64];
  PetscReal slip;

  PetscFunctionBegin;
  PetscCall(LargestMagnitude(fault, FAULT_FRICTION_SLIP, &slip, &source));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(plausible); k++) {
    const SlipParameter *p = &SlipFaultReals[plausible[k].id];
    const PetscBool extent =
      plausible[k].id == FAULT_LENGTH_X || plausible[k].id == FAULT_LENGTH_Z ? PETSC_TRUE : PETSC_FALSE;
    PetscReal x;
    PetscBool small;

    if (extent && fault->mesh.ndim == 1) continue; /* the file of the mesh has its own check */
    PetscCall(LargestMagnitude(fault, plausible[k].id, &x, &source));
    if (rank || x == 0 || isnan(x) || (x >= plausible[k].least && x <= plausible[k].most)) continue;
    small = x < plausible[k].least ? PETSC_TRUE : PETSC_FALSE;
    if (small && (extent || plausible[k].id == FAULT_THICKNESS) && slip < LABORATORY_SLIP * x) continue;
    PetscCall(PetscSNPrintf(what, sizeof(what), "%s%s%s%s is%s", source ? source : "-", source ? ": /" : prefix,
                            source ? "" : "fault_", p->name, source ? " at most" : ""));
    PetscCall(
      SlipWarnOfUnit(what, x, p->unit, plausible[k].least, plausible[k].most, plausible[k].small, plausible[k].large));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the start of rate-and-state friction ---- */

/* Largest relative deviations from the steady rate and state with which a cell counts as steady */
#define STEADY 1e-3

/* Warns of a steady start. Every cell at the loading rate with its steady state is an equilibrium. It is unstable where
   cells weaken and the fault is not too small, and rounding alone would decide when the first event comes. Collective.
   */
static PetscErrorCode WarnOfSteadyStart(SlipFault fault, PetscMPIInt rank)
{
  const PetscReal width = PetscMin(fault->mesh.extent[FAULT_LENGTH_X], fault->mesh.extent[FAULT_LENGTH_Z]);
  const SlipFaultResolution *r = &fault->resolution;
  const char *prefix = SlipFaultPrefix(fault);
  PetscInt moves = 0, weakens = 0;
  SlipFrictionCells friction;

  PetscFunctionBegin;
  if (!fault->friction.law->always_slides || SlipLoadsChange(&fault->loads) || !r->weakens)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (fault->mesh.N == 1 ? r->alone == 0 : r->nucleation > width) PetscFunctionReturn(PETSC_SUCCESS); /* stable */
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  for (PetscInt i = 0; i < fault->mesh.n && !moves; i++) {
    const PetscReal vinf = fault->fields.cell[FIELD_LOADING_RATE][i], rate = PetscAbsReal(vinf);
    const PetscReal load = fault->fields.cell[FIELD_INITIAL_TRACTION][i] * (vinf < 0 ? -1 : 1);
    PetscReal mu, ds, dv, s[SLIP_MAX_STATES];

    if (fault->fields.cell[FIELD_STRESSING_RATE][i] != 0 || vinf == 0) moves = 1;
    if (moves || (fault->balance.creeps && fault->balance.creeps[i])) continue;
    SlipFrictionSteady(&friction, i, vinf, s);
    SlipFrictionEvaluate(&friction, i, s, rate, &mu, &ds, &dv);
    /* the traction and the state give the rate */
    if (PetscAbsReal(load - mu * friction.stress[i]) > STEADY * dv * rate * friction.stress[i]) moves = 1;
    for (PetscInt k = 0; k < fault->layout.states; k++)
      if (PetscAbsReal(fault->friction.start[k][i] / SlipFrictionShown(&friction, i, k, s[k]) - 1) > STEADY) moves = 1;
    if (moves) continue;
    if (SlipFaultRateWeakens(&friction, i, vinf)) weakens = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moves, 1, MPIU_INT, MPI_MAX, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &weakens, 1, MPIU_INT, MPI_MAX, fault->comm));
  if (moves || !weakens || rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    SlipWarning("every cell starts in the steady state of its loading rate, and cells weaken. This equilibrium is "
                "unstable, and rounding errors decide when the first event comes. Leave -%sfault_initial_rate "
                "out (cells that weaken then start locked), or give -%sfault_parameters a field initial_rate "
                "or initial_state that differs in a patch",
                prefix, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- inertia ---- */

/* A front passes a cohesive zone, of about G/W, while the cells in it gain speed: with the mass rho Ly and the
   weakening W that takes sqrt(rho Ly/W), so that ruptures run at v1 = k cs sqrt(G/(W Ly)). k grows with the stress at
   the start, as the share f of the drop by which it exceeds the residual strength. Radiation damping is a limit as
   well, 1/v^2 = 1/v0^2 + 1/v1^2, with v0 = c cs without inertia; sqrtm, which contains the same mass, is none. Strips
   of 4 km with G/W = 600 m gave k = 0.30, 0.43, 0.53, 0.74, 1.00 and c = 0.22, 0.39, 0.55, 0.89, 1.32 for f = 0.5,
   0.55, 0.6, 0.7, 0.8 (src/physics.md), which these lines fit; both are less on strips as narrow as some cohesive
   zones. */
static PetscReal FrontOfMass(PetscReal f)
{
  return PetscMax(2.1 * (f - 0.35), 0.1);
}
static PetscReal FrontOfRadiation(PetscReal f)
{
  return PetscMax(3.3 * (f - 0.43), 0.1);
}
/* k at the common f of 0.6 and a little more, for the warning of too large thicknesses: low stress makes ruptures slow
   as well */
#define FRONT_SPEED 0.6
/* Rupture speeds over cs: nearly all earthquakes exceed the first one, and the second one gives the proposed thickness
   where ruptures would be faster than waves */
#define SLOW_FRONT 0.3
#define FAST_FRONT 0.9

/* Finds the mean f of the cells that weaken and start at most at their strength; 0: there are none. Collective. */
static PetscErrorCode StressShare(SlipFault fault, PetscReal *share)
{
  PetscReal sum[2] = {0, 0};
  SlipFrictionCells friction;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal load = PetscAbsReal(fault->fields.cell[FIELD_INITIAL_TRACTION][i]),
                    weakest = SlipFrictionWeakest(&friction, i);
    PetscReal mu, ds, dv, f;

    SlipFrictionEvaluate(&friction, i, NULL, 0, &mu, &ds, &dv);
    if (!(mu > weakest) || friction.stress[i] <= 0) continue;
    f = (load / friction.stress[i] - weakest) / (mu - weakest);
    if (f > 1) continue;
    sum[0] += f;
    sum[1]++;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, fault->comm));
  *share = sum[1] > 0 ? sum[0] / sum[1] : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WarnOfThickness(SlipFault fault, PetscMPIInt rank)
{
  const char *prefix = SlipFaultPrefix(fault);
  const PetscReal zone = fault->options.value[FAULT_SHEAR_MODULUS] / fault->resolution.critical; /* G/W */
  PetscReal thickness, speed, f = 0, mass, damping;
  PetscBool critical, radiation;

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  if (!fault->kind.inertia || !fault->resolution.known || fault->friction.law->by_rate ||
      fault->friction.law->nstates || critical)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StressShare(fault, &f));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetReal(fault, "thickness", &thickness));
  speed = FRONT_SPEED * PetscSqrtReal(zone / thickness);
  if (speed < SLOW_FRONT) {
    PetscCall(SlipWarning(
      "-%sfault_thickness is %.6g m%s. With this inertia ruptures run at about %.2g of the shear wave "
      "speed. Use at most %.2g m, for %g of it, or -%sfault_inertia no with -%sfault_viscosity "
      "radiation",
      prefix, (double)thickness, isnan(fault->options.value[FAULT_THICKNESS]) ? " (of -fault_length_x)" : "",
      (double)speed, (double)(zone * PetscSqr(FRONT_SPEED / SLOW_FRONT)), SLOW_FRONT, prefix, prefix));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrcmp(fault->kind.viscosity, "radiation", &radiation));
  mass = FrontOfMass(f) * PetscSqrtReal(zone / thickness);
  damping = radiation ? 1 / PetscSqr(FrontOfRadiation(f)) : 0;
  speed = 1 / PetscSqrtReal(1 / PetscSqr(mass) + damping);
  if (speed <= 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipWarning("-%sfault_thickness is %.6g m. With this inertia, and a stress of %.2g of the drop above the "
                        "residual strength, ruptures run at "
                        "about %.2g times the shear wave speed, as the equations have no waves that hold them back. "
                        "Use at least %.2g m, for %g of that speed",
                        prefix, (double)thickness, (double)f, (double)speed,
                        (double)(zone * PetscSqr(FrontOfMass(f)) * (1 / PetscSqr(FAST_FRONT) - damping)), FAST_FRONT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the mesh ---- */

/* Cells across a fault up to which `centre` has errors of a fifth and more where the whole fault slides: the final slip
   of the 3 km fault is off by 22.5 % on 20 x 20 cells, and by 50.2 % on 10 x 10 (src/accuracy.md, "What a mesh of n
   cells is worth") */
#define FEW_CELLS 20

/* Warns of few cells on a fault that starts at its instability without loading, and so slides as a whole, up to its
   edges. Dipping planes, and slip with two components, have no other average; there the numbers of the vertical fault
   are a guide. */
static PetscErrorCode WarnOfMesh(SlipFault fault, PetscMPIInt rank)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const char *prefix = SlipFaultPrefix(fault);
  const PetscBool whole = fault->kind.dipping || fault->layout.components > 1 ? PETSC_FALSE : PETSC_TRUE;
  PetscBool critical, centre, none;
  char average[128] = "";

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.initial, "critical", &critical));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_STIFFNESS_AVERAGE], "centre", &centre));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_STIFFNESS_SCALING], "none", &none));
  if (rank || !critical || fault->kind.driven || !centre || !none || fault->options.text[FAULT_STIFFNESS_FILE][0] ||
      mesh->ndim != 2)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (PetscMin(mesh->dims[0], mesh->dims[1]) < 2 || PetscMin(mesh->dims[0], mesh->dims[1]) > FEW_CELLS)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (whole) (void)snprintf(average, sizeof(average), "-%sfault_stiffness_average whole, or ", prefix);
  PetscCall(
    SlipWarning("%" PetscInt_FMT " x %" PetscInt_FMT " cells are few for -%sfault_stiffness_average centre on a "
                "fault that slides as a whole: its slip comes out too large (that of the vertical 3 km fault by 50 %% "
                "on 10 x 10 cells, 22 %% on 20 x 20, 10 %% on 40 x 40). Use %smore cells (-%sfault_nx, -%sfault_nz)",
                mesh->dims[1], mesh->dims[0], prefix, average, prefix, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints all warnings at the end of the set-up. Collective. */
PetscErrorCode SlipFaultWarn(SlipFault fault)
{
  PetscMPIInt rank;
  PetscBool help;
  const char *prefix = SlipFaultPrefix(fault), *source = fault->fields.source[FIELD_NORMAL_STRESS];
  const SlipFrictionLaw *law;
  const SlipParameter *p;
  PetscReal first, last;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (!fault->options.reports || help) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(WarnOfUnits(fault, rank));
  for (PetscInt k = 0; (p = SlipFaultOwnRow(k, &law)) && !rank; k++) {
    const char *own = fault->fields.source[FAULT_NUM_FIELDS + k];

    if (law == fault->friction.law || (!own && isnan(fault->options.value[FAULT_NUM_REALS + k]))) continue;
    PetscCall(SlipWarning("%s%s%s%s has no effect: it belongs to -%sfault_friction_law %s, but the law is %s",
                          own ? own : "-", own ? ": /" : prefix, own ? "" : "fault_", p->name, prefix, law->name,
                          fault->friction.law->name));
  }
  if (!rank && source &&
      fault->options.value[FAULT_NORMAL_STRESS_GRADIENT] != 0) { /* the field has all of the stress */
    char option[128];
    PetscBool set;

    (void)snprintf(option, sizeof(option), "-%sfault_normal_stress_gradient", prefix);
    PetscCall(PetscOptionsHasName(NULL, NULL, option, &set));
    if (set)
      PetscCall(
        SlipWarning("%s has no effect: %s: /normal_stress has the normal stress of each cell. Add the gradient to it",
                    option, source));
  }
  if (!rank) PetscCall(SlipFaultWarnOfIdle(fault));
  law = fault->friction.law;
  /* friction without a length: TPV3 with such friction at a scale of 5 m/s, and more stress, slips by 0.13, 0.15 and
     0.20 m in the mean with cells of 500, 250 and 125 m */
  if (fault->kind.waves && law->by_rate && !law->nstates && !rank)
    PetscCall(
      SlipWarning("the strength of -%sfault_friction_law %s falls with the slip rate at once, over no length: how "
                  "far a rupture runs depends on the size of the cells. Use slip weakening, or rate and state",
                  prefix, law->name));
  if (fault->mesh.planes > 1 && !fault->kind.coupled && !rank)
    PetscCall(SlipWarning("slip on one plane of -%sfault_mesh %s does not change the normal stress on the others, only "
                          "their shear stress. Use -%sfault_normal_coupling yes to include it",
                          prefix, fault->options.text[FAULT_MESH], prefix));
  PetscCall(WarnOfSteadyStart(fault, rank));
  PetscCall(WarnOfThickness(fault, rank));
  PetscCall(WarnOfMesh(fault, rank));
  if (!rank) PetscCall(SlipFaultResolutionWarn(fault));
  PetscCall(SlipElasticGetImages(fault->medium, &first, &last));
  if (first < PETSC_MAX_REAL) /* a line, no warning: a run may end before, and the waves may be too weak */
    PetscCall(PetscPrintf(fault->comm,
                          "%-24s waves of periodic images arrive %.4g s after slip (-%sfault_waves_padding)\n",
                          "images:", (double)first, prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}
