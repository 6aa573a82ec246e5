/* The table of the numbers of a fault, which options, setters, views and error messages use as they do those of
   choices.c, and the setters. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultregional.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define NONE PETSC_MAX_REAL
#define ANY PETSC_MIN_REAL
#define OPEN PETSC_TRUE
#define SHUT PETSC_FALSE
#define WHOLE PETSC_TRUE
#define REAL PETSC_FALSE
#define PROBLEM SLIP_PART_PROBLEM
#define CONTENT SLIP_PART_CONTENT
#define STEPS SLIP_PART_STEPS
#define RUN SLIP_PART_RUN
#define OUTPUT SLIP_PART_OUTPUT
#define TooLarge(p, x) ((p)->part == PROBLEM && isfinite(x) && PetscAbsReal(x) > 1e60) /* products overflow */

/* Defaults: the reference case "3 km" with one cell. */
const SlipParameter SlipFaultReals[FAULT_NUM_REALS] = {
  [FAULT_NX] = {"nx", 1, "", 1, NONE, SHUT, WHOLE, "Cells along strike", PROBLEM},
  [FAULT_NZ] = {"nz", 1, "", 1, NONE, SHUT, WHOLE, "Cells in depth", PROBLEM},
  [FAULT_LENGTH_X] = {"length_x", 3000, "m", 0, MESH_MAX_REACH, OPEN, REAL, "Length of the fault along strike",
                      PROBLEM},
  [FAULT_LENGTH_Z] = {"length_z", 3000, "m", 0, MESH_MAX_DEPTH, OPEN, REAL,
                      "Width of the fault, measured along its dip", PROBLEM},
  [FAULT_DEPTH_TOP] = {"depth_top", 0, "m", 0, MESH_MAX_DEPTH, SHUT, REAL,
                       "Depth of the upper edge; 0 touches the free surface", PROBLEM},
  [FAULT_STRIKE] = {"strike", 0, "degrees", -360, 360, SHUT, REAL,
                    "Strike, clockwise from north, which is x, as Aki and Richards define it", PROBLEM},
  [FAULT_DIP] = {"dip", 90, "degrees", 0, 90, OPEN, REAL,
                 "Dip, down to the right of the strike, as Aki and Richards define it", PROBLEM},
  [FAULT_RAKE] = {"rake", 0, "degrees", -360, 360, SHUT, REAL,
                  "Direction of slip, loading and shear stress in the plane, from the strike, up dip positive: 0 "
                  "left-lateral, 90 thrust, 180 right-lateral, -90 normal; may be a field of -fault_parameters",
                  PROBLEM},
  [FAULT_SLIP_COMPONENTS] = {"slip_components", 1, "", 1, 3, SHUT, WHOLE,
                             "Components of slip: 1, along the rake, or 2, along strike and up dip. With 2, friction "
                             "acts against the slip rate, and loading and shear stress act along the rake; not with "
                             "-fault_stiffness_file or -fault_stiffness_average of rectangles",
                             PROBLEM},
  [FAULT_THICKNESS] = {"thickness", (PetscReal)NAN, "m", 0, MESH_MAX_REACH, OPEN, REAL,
                       "Mobilised thickness Ly (default: length_x)", PROBLEM},
  [FAULT_SHEAR_MODULUS] = {"shear_modulus", 30e9, "Pa", 0, NONE, OPEN, REAL, "Shear modulus G", PROBLEM},
  [FAULT_POISSON_RATIO] = {"poisson_ratio", 0.25, "", -1, 0.5, OPEN, REAL, "Poisson's ratio", PROBLEM},
  [FAULT_DENSITY] = {"density", 2500, "kg/m^3", 0, NONE, OPEN, REAL, "Density rho", PROBLEM},
  [FAULT_DAMPING_RATIO] = {"damping_ratio", 0.8 / 3, "", 0, NONE, SHUT, REAL,
                           "Damping ratio zeta in H = 2 zeta M (M^-1 K)^(1/2)", PROBLEM},
  [FAULT_LOADING_RATE] = {"loading_rate", 0, "m/s", ANY, NONE, SHUT, REAL, "Far-field slip rate v_inf", PROBLEM},
  [FAULT_NORMAL_STRESS] = {"normal_stress", 0, "Pa", 0, NONE, SHUT, REAL,
                           "Effective normal stress: uniform, unless -fault_normal_stress_gradient adds to it",
                           PROBLEM},
  [FAULT_NORMAL_STRESS_GRADIENT] = {"normal_stress_gradient", NAN, "Pa/m", 0, NONE, SHUT, REAL,
                                    "Effective normal stress per depth of the cell's centre, added to "
                                    "-fault_normal_stress, not to a field normal_stress "
                                    "(default 15e3, 0 beside a -fault_normal_stress)",
                                    CONTENT},
  [FAULT_FRICTION_RESIDUAL] = {"friction_residual", 0.5, "", 0, NONE, SHUT, REAL, "Residual friction mu_d", PROBLEM},
  [FAULT_FRICTION_DROP] = {"friction_drop", 0.1, "", 0, NONE, SHUT, REAL,
                           "Friction above the residual at the start, dmu", PROBLEM},
  [FAULT_FRICTION_SLIP] = {"friction_slip", 0.1, "m", 0, NONE, OPEN, REAL,
                           "Weakening slip d_c of the slip weakening laws", PROBLEM},
  [FAULT_FRICTION_RATE] = {"friction_rate", 0.1, "m/s", 0, NONE, OPEN, REAL,
                           "Weakening rate v_c of the rate weakening law", PROBLEM},
  [FAULT_FRICTION_A] = {"friction_a", 0.01, "", 0, NONE, OPEN, REAL, "Direct effect a of rate-and-state friction",
                        PROBLEM},
  [FAULT_FRICTION_B] = {"friction_b", 0.015, "", 0, NONE, SHUT, REAL,
                        "Evolution effect b of rate-and-state friction; its d_c is friction_slip", PROBLEM},
  [FAULT_FRICTION_ALPHA] = {"friction_alpha", 0, "", 0, NONE, SHUT, REAL,
                            "Effect alpha of normal stress on the state of rate-and-state friction (Linker and "
                            "Dieterich 1992): when normal stress rises from sigma0 to sigma, friction falls at once by "
                            "alpha ln(sigma/sigma0), and then the state evolves; 0: disabled",
                            PROBLEM},
  [FAULT_FRICTION_REFERENCE] = {"friction_reference", 0.6, "", 0, NONE, SHUT, REAL,
                                "Steady rate-and-state friction f0 at the rate V0", PROBLEM},
  [FAULT_FRICTION_REFERENCE_RATE] = {"friction_reference_rate", 1e-6, "m/s", 0, NONE, OPEN, REAL,
                                     "Reference rate V0 of rate-and-state friction", PROBLEM},
  [FAULT_STATE_CUTOFF_RATE] = {"state_cutoff_rate", 1e-8, "m/s", 0, NONE, OPEN, REAL,
                               "Rate V_c above which -fault_state_law composite does not heal with time", PROBLEM},
  [FAULT_HEALING_TIME] = {"healing_time", 0, "s", 0, NONE, SHUT, REAL,
                          "Time t_h in which the friction state heals, ds/dt = |v| - s/t_h; 0: never", PROBLEM},
  [FAULT_INITIAL_TRACTION] = {"initial_traction", 0, "Pa", ANY, NONE, SHUT, REAL,
                              "Shear stress at the start, positive along positive slip", PROBLEM},
  [FAULT_INITIAL_RATE] =
    {"initial_rate", (PetscReal)NAN, "m/s", ANY, NONE, SHUT, REAL,
     "Slip rate at the start of rate-and-state friction (default: loading_rate, and a thousandth of it in "
     "cells that weaken, unless -fault_initial is traction)",
     PROBLEM},
  [FAULT_INITIAL_STATE] = {"initial_state", (PetscReal)NAN, "s", 0, NONE, OPEN, REAL,
                           "State theta at the start of rate-and-state friction (default: steady at loading_rate, or "
                           "what balances initial_traction)",
                           PROBLEM},
  [FAULT_CREEP] =
    {"creep", 0, "", 0, NONE, SHUT, REAL,
     "Not zero: the cell slips at the loading rate, whatever its stress; usually a field of -fault_parameters",
     PROBLEM},
  [FAULT_STRESSING_RATE] = {"stressing_rate", 0, "Pa/s", ANY, NONE, SHUT, REAL, "Rate of the shear stress", PROBLEM},
  SLIP_FAULT_REGIONAL_REALS,
  [FAULT_INJECTION_PRESSURE] = {"injection_pressure", 0, "Pa", ANY, NONE, SHUT, REAL,
                                "Pressure scale p* of -fault_injection: p = p* E1(r^2/(4 D t))", PROBLEM},
  [FAULT_INJECTION_DIFFUSIVITY] = {"injection_diffusivity", 0, "m^2/s", 0, NONE, SHUT, REAL,
                                   "Hydraulic diffusivity D of -fault_injection", PROBLEM},
  [FAULT_INJECTION_STOP] = {"injection_stop", 0, "s", 0, NONE, SHUT, REAL, "When the injection stops; 0: never",
                            PROBLEM},
  [FAULT_SHEAR_ZONE_WIDTH] = {"shear_zone_width", 0, "m", 0, MESH_MAX_REACH, SHUT, REAL,
                              "Standard deviation w of the Gaussian profile in which friction heats the rock across "
                              "the fault; 0: temperature is not computed",
                              PROBLEM},
  [FAULT_SHEAR_ZONE_TOLERANCE] = {"shear_zone_tolerance", (PetscReal)1e-4, "", 1e-8, (PetscReal)0.1, SHUT, REAL,
                                  "Relative error of the temperature that heat leaves, as a sum over wavenumbers",
                                  PROBLEM},
  [FAULT_HEAT_CAPACITY] = {"heat_capacity", 2.7e6, "J/(m^3 K)", 0, NONE, OPEN, REAL,
                           "Heat capacity rho c of the shear zone", PROBLEM},
  [FAULT_THERMAL_DIFFUSIVITY] = {"thermal_diffusivity", 1e-6, "m^2/s", 0, NONE, SHUT, REAL,
                                 "Diffusivity of heat across the shear zone", PROBLEM},
  [FAULT_HYDRAULIC_DIFFUSIVITY] = {"hydraulic_diffusivity", 1e-5, "m^2/s", 0, NONE, SHUT, REAL,
                                   "Diffusivity of pore fluid across the shear zone", PROBLEM},
  [FAULT_THERMAL_PRESSURISATION] = {"thermal_pressurisation", 0, "Pa/K", 0, NONE, SHUT, REAL,
                                    "Pore pressure that a degree makes in undrained rock, Lambda; 0: none", PROBLEM},
  [FAULT_DILATANCY] = {"dilatancy", 0, "", 0, NONE, SHUT, REAL,
                       "Dilatancy epsilon of rate-and-state friction: pores grow by epsilon as the state theta falls "
                       "by a factor e (Segall and Rice 1995)",
                       PROBLEM},
  [FAULT_DILATANCY_STORAGE] = {"dilatancy_storage", (PetscReal)1e-11, "1/Pa", 0, NONE, OPEN, REAL,
                               "Compressibility beta of pores and fluid: pore pressure falls by epsilon/beta", PROBLEM},
  [FAULT_DILATANCY_TIME] = {"dilatancy_time", 1e5, "s", 0, NONE, OPEN, REAL,
                            "Time t_p in which that pressure flows back", PROBLEM},
  [FAULT_PERMEABILITY] = {"permeability", 0, "m^2", 0, NONE, SHUT, REAL,
                          "Permeability k of the fault, of a layer of -fault_aperture; 0 everywhere: no diffusion of "
                          "pore fluid is computed",
                          PROBLEM},
  [FAULT_PERMEABILITY_RATIO] = {"permeability_ratio", 1, "", 0, NONE, OPEN, REAL,
                                "Permeability down dip over that along strike, which is -fault_permeability", PROBLEM},
  [FAULT_PERMEABILITY_MAXIMUM] = {"permeability_maximum", 0, "m^2", 0, NONE, SHUT, REAL,
                                  "Permeability kmax towards which slip changes it under -fault_permeability_law slip "
                                  "and valve",
                                  PROBLEM},
  [FAULT_PERMEABILITY_SLIP] = {"permeability_slip", 0, "m", 0, NONE, SHUT, REAL,
                               "Slip L in which permeability grows, dk/dt = |v|/L (kmax - k) + (k0 - k)/T", PROBLEM},
  [FAULT_PERMEABILITY_HEALING_TIME] = {"permeability_healing_time", 0, "s", 0, NONE, SHUT, REAL,
                                       "Time T in which permeability falls back to -fault_permeability k0; 0: never",
                                       PROBLEM},
  [FAULT_PERMEABILITY_STRESS] = {"permeability_stress", 0, "Pa", 0, NONE, SHUT, REAL,
                                 "Stress s* of -fault_permeability_law stress and valve: k falls by "
                                 "exp(-(s - s0)/s*) as the effective normal stress s rises from s0, the one at fluid "
                                 "pressure 0",
                                 PROBLEM},
  [FAULT_POROSITY] = {"porosity", (PetscReal)0.1, "", 0, 1, OPEN, REAL, "Porosity of that layer", PROBLEM},
  [FAULT_PORE_COMPRESSIBILITY] = {"pore_compressibility", (PetscReal)1e-9, "1/Pa", 0, NONE, OPEN, REAL,
                                  "Compressibility of pores and fluid together", PROBLEM},
  [FAULT_FLUID_VISCOSITY] = {"fluid_viscosity", (PetscReal)1e-3, "Pa s", 0, NONE, OPEN, REAL,
                             "Dynamic viscosity of the pore fluid", PROBLEM},
  [FAULT_APERTURE] = {"aperture", 1, "m", 0, MESH_MAX_REACH, OPEN, REAL,
                      "Thickness of the layer along the fault that conducts and stores fluid", PROBLEM},
  [FAULT_LEAKOFF] = {"leakoff", 0, "m/(Pa s)", 0, NONE, SHUT, REAL,
                     "Volume of fluid that leaves the fault into the rock, per time, area and pressure", PROBLEM},
  [FAULT_CARTER_LEAKOFF] = {"carter_leakoff", 0, "m/(Pa s^0.5)", 0, NONE, SHUT, REAL,
                            "Volume of fluid that leaves the fault into the rock, per area and pressure and root of "
                            "the time since the cell was reached (Carter)",
                            PROBLEM},
  [FAULT_CARTER_PRESSURE] = {"carter_pressure", (PetscReal)1e3, "Pa", 0, NONE, SHUT, REAL,
                             "Rise of the fluid pressure above that of the start at which a cell counts as reached, "
                             "for -fault_carter_leakoff",
                             PROBLEM},
  [FAULT_BORDER_PRESSURE] = {"border_pressure", (PetscReal)NAN, "Pa", ANY, NONE, SHUT, REAL,
                             "Fluid pressure held at the border of the fault (default: none, as -fault_fluid_border "
                             "says); usually a field of -fault_parameters, NaN in cells without such a border",
                             PROBLEM},
  [FAULT_FLUID_SOURCE] = {"fluid_source", 0, "m/s", ANY, NONE, SHUT, REAL,
                          "Volume of fluid that enters the fault all the time, per time and area", PROBLEM},
  [FAULT_FLUID_PRESSURE] = {"fluid_pressure", 0, "Pa", ANY, NONE, SHUT, REAL,
                            "Fluid pressure at the start, in excess of that at which -fault_normal_stress is effective",
                            PROBLEM},
  [FAULT_FLUID_TOLERANCE] =
    {"fluid_tolerance", (PetscReal)1e-3, "", 1e-12, (PetscReal)0.1, SHUT, REAL,
     "Relative error of fluid pressure in a step of the diffusion, whose solver has the options "
     "-fault_fluid_ksp_* and -fault_fluid_pc_*",
     PROBLEM},
  [FAULT_INITIAL_PERTURBATION] = {"initial_perturbation", 1e-5, "", ANY, NONE, SHUT, REAL,
                                  "Relative excess of the critical start over the strength", PROBLEM},
  [FAULT_VELOCITY_SCALE] = {"velocity_scale", 0.07, "m/s", 0, NONE, OPEN, REAL,
                            "Unit of slip rate in a policy's observation \"velocity\"", PROBLEM},
  [FAULT_OUTPUT_INTERVAL] =
    {"output_interval", 1, "steps", 1, NONE, SHUT, WHOLE,
     "Accepted steps from one entry of /fields to the next; beside another -fault_output_ interval only if given",
     OUTPUT},
  [FAULT_OUTPUT_SLIP_INTERVAL] =
    {"output_slip_interval", 0, "m", 0, NONE, SHUT, REAL,
     "Write an entry of /fields when a cell has slipped by this much since the last entry; 0: disabled", OUTPUT},
  [FAULT_OUTPUT_TIME_INTERVAL] =
    {"output_time_interval", 0, "s", 0, NONE, SHUT, REAL,
     "Write an entry of /fields at the first step at or after each multiple of this time; 0: disabled", OUTPUT},
  [FAULT_OUTPUT_RATE_CHANGE] = {"output_rate_change", 0, "", 0, NONE, SHUT, REAL,
                                "Write an entry of /fields when the largest slip rate has changed by this factor since "
                                "the last entry; 0: disabled",
                                OUTPUT},
  [FAULT_OUTPUT_SIZE] = {"output_size", 1e8, "bytes", 0, NONE, SHUT, REAL,
                         "Largest size of /fields when no other option sets its entries. The first fifth has one entry "
                         "a step, the rest is spread over time and slip; 0: unlimited",
                         OUTPUT},
  [FAULT_OUTPUT_COMPRESSION] = {"output_compression", 0, "", 0, 10, SHUT, WHOLE,
                                "Level of deflate compression of /fields, with bytes shuffled; 0: disabled", OUTPUT},
  [FAULT_HMAT_TOLERANCE] = {"hmat_tolerance", (PetscReal)NAN, "", 0, 1, OPEN, REAL,
                            "Error of blocks of -fault_operator hmat (default from -fault_accuracy, -ts_rtol)",
                            PROBLEM},
  [FAULT_KRYLOV_TOLERANCE] = {"krylov_tolerance", 1e-8, "", 0, 1, OPEN, REAL,
                              "Relative error of products with the viscosity of -fault_viscosity lanczos", STEPS},
  [FAULT_WAVES_TOLERANCE] = {"waves_tolerance", 1e-6, "", 1e-8, (PetscReal)0.1, SHUT, REAL,
                             "Largest error of the kernels of -fault_medium waves as sums of exponentials", PROBLEM},
  [FAULT_WAVES_PADDING] = {"waves_padding", (PetscReal)2.2, "", (PetscReal)1.5, 16, SHUT, REAL,
                           "Length of the transforms of -fault_medium waves over that of a line; of planes the square "
                           "root of their area over the fault's, images equally far away on all sides",
                           PROBLEM},
  [FAULT_RATE_TOLERANCE] = {"rate_tolerance", (PetscReal)NAN, "m/s", 0, NONE, OPEN, REAL,
                            "Absolute tolerance of slip rates in the local error (default 1e-10 m over T*)", STEPS},
  [FAULT_ACCURACY] = {"accuracy", (PetscReal)NAN, "", SLIP_FAULT_ACCURACY_MIN, SLIP_FAULT_ACCURACY_MAX, SHUT, REAL,
                      "Relative error that the run should keep, 1e-3 to 1e-1; sets -ts_rtol of heuristic, pi, dsp and "
                      "basic, and -ts_adapt_rl_accuracy (default 1e-2, of explicit runs 1e-3)",
                      STEPS},
  [FAULT_CHECKPOINT_INTERVAL] = {"checkpoint_interval", 600, "s", 0, NONE, SHUT, REAL,
                                 "Wall time from one checkpoint to the next", RUN},
  [FAULT_RESTART_DT] = {"restart_dt", 0, "s", 0, NONE, SHUT, REAL,
                        "First step after -fault_restart; 0: that of the checkpoint (-ts_dt has no effect there)", RUN},
  [FAULT_WALL_LIMIT] =
    {"wall_limit", 0, "s", 0, NONE, SHUT, REAL,
     "Wall time of the program before which the run stops with a checkpoint and exit code 152; 0: unlimited", RUN},
  [FAULT_EVENT_RATE] = {"event_rate", 1e-3, "m/s", 0, NONE, OPEN, REAL,
                        "Slip rate of a cell at which an event of -fault_catalogue begins and ends; its row is written "
                        "when all cells are below a tenth of it",
                        OUTPUT},
};

/* The number that each field replaces, and who uses it: any fault, laws whose cells always slide, or pore fluid */
enum { EVERY, SLIDES, FLOWS };
static const struct {
  SlipFaultRealId real;
  int user;
} Fields[FAULT_NUM_FIELDS] = {
  [FIELD_NORMAL_STRESS] = {FAULT_NORMAL_STRESS, EVERY},
  [FIELD_FRICTION_RESIDUAL] = {FAULT_FRICTION_RESIDUAL, EVERY},
  [FIELD_FRICTION_DROP] = {FAULT_FRICTION_DROP, EVERY},
  [FIELD_FRICTION_SLIP] = {FAULT_FRICTION_SLIP, EVERY},
  [FIELD_FRICTION_RATE] = {FAULT_FRICTION_RATE, EVERY},
  [FIELD_LOADING_RATE] = {FAULT_LOADING_RATE, EVERY},
  [FIELD_HEALING_TIME] = {FAULT_HEALING_TIME, EVERY},
  [FIELD_INITIAL_TRACTION] = {FAULT_INITIAL_TRACTION, EVERY},
  [FIELD_STRESSING_RATE] = {FAULT_STRESSING_RATE, EVERY},
  [FIELD_FRICTION_A] = {FAULT_FRICTION_A, SLIDES},
  [FIELD_FRICTION_B] = {FAULT_FRICTION_B, SLIDES},
  [FIELD_FRICTION_ALPHA] = {FAULT_FRICTION_ALPHA, SLIDES},
  [FIELD_FRICTION_REFERENCE] = {FAULT_FRICTION_REFERENCE, SLIDES},
  [FIELD_INITIAL_RATE] = {FAULT_INITIAL_RATE, SLIDES},
  [FIELD_INITIAL_STATE] = {FAULT_INITIAL_STATE, SLIDES},
  [FIELD_CREEP] = {FAULT_CREEP, SLIDES},
  [FIELD_RAKE] = {FAULT_RAKE, EVERY},
  [FIELD_THERMAL_PRESSURISATION] = {FAULT_THERMAL_PRESSURISATION, EVERY},
  [FIELD_DILATANCY] = {FAULT_DILATANCY, SLIDES},
  [FIELD_PERMEABILITY] = {FAULT_PERMEABILITY, FLOWS},
  [FIELD_PERMEABILITY_RATIO] = {FAULT_PERMEABILITY_RATIO, FLOWS},
  [FIELD_PERMEABILITY_MAXIMUM] = {FAULT_PERMEABILITY_MAXIMUM, FLOWS},
  [FIELD_POROSITY] = {FAULT_POROSITY, FLOWS},
  [FIELD_PORE_COMPRESSIBILITY] = {FAULT_PORE_COMPRESSIBILITY, FLOWS},
  [FIELD_APERTURE] = {FAULT_APERTURE, FLOWS},
  [FIELD_LEAKOFF] = {FAULT_LEAKOFF, FLOWS},
  [FIELD_CARTER_LEAKOFF] = {FAULT_CARTER_LEAKOFF, FLOWS},
  [FIELD_BORDER_PRESSURE] = {FAULT_BORDER_PRESSURE, FLOWS},
  [FIELD_FLUID_SOURCE] = {FAULT_FLUID_SOURCE, FLOWS},
  [FIELD_FLUID_PRESSURE] = {FAULT_FLUID_PRESSURE, FLOWS},
};

/* ---- rows of the tables, followed by those of registered laws, which are all fields ---- */

const SlipParameter *SlipFaultOwnRow(PetscInt k, const SlipFrictionLaw **law)
{
  if (k >= FAULT_MAX_OWN) return NULL;
  for (const SlipFrictionLaw *l = SlipFrictionNext(NULL); l; l = SlipFrictionNext(l))
    for (const SlipParameter *p = l->own; p && p->name; p++) {
      if (k--) continue;
      if (law) *law = l;
      return p;
    }
  return NULL;
}

const SlipParameter *SlipFaultRealRow(PetscInt id)
{
  return id < FAULT_NUM_REALS ? &SlipFaultReals[id] : SlipFaultOwnRow(id - FAULT_NUM_REALS, NULL);
}

const SlipParameter *SlipFaultFieldRow(PetscInt field)
{
  return field < FAULT_NUM_FIELDS ? &SlipFaultReals[Fields[field].real]
                                  : SlipFaultOwnRow(field - FAULT_NUM_FIELDS, NULL);
}

PetscInt SlipFaultFieldOf(PetscInt id)
{
  if (id >= FAULT_NUM_REALS) return id - FAULT_NUM_REALS + FAULT_NUM_FIELDS;
  for (PetscInt f = 0; f < FAULT_NUM_FIELDS; f++)
    if (id == (PetscInt)Fields[f].real) return f;
  return -1;
}

PetscInt SlipFaultFindField(const char name[])
{
  const SlipParameter *p;

  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)); f++)
    if (!strcmp(name, p->name)) return f;
  return -1;
}

/* Returns whether the fault uses this field, once its cells are set up. */
PetscBool SlipFaultHasField(SlipFault fault, PetscInt field)
{
  const SlipFrictionLaw *law = NULL;

  if (field == FIELD_INITIAL_STATE) {
    for (PetscInt k = 0; k < fault->friction.law->nstates; k++)
      if (fault->friction.law->always_slides && !strcmp(fault->friction.law->states[k].start, "initial_state"))
        return PETSC_TRUE;
    return PETSC_FALSE;
  }
  if (field < FAULT_NUM_FIELDS)
    return Fields[field].user == EVERY ||
               (Fields[field].user == FLOWS ? fault->kind.flows : fault->friction.law->always_slides)
             ? PETSC_TRUE
             : PETSC_FALSE;
  (void)SlipFaultOwnRow(field - FAULT_NUM_FIELDS, &law);
  return law == fault->friction.law ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode SlipFaultFindReal(SlipFault fault, const char name[], PetscInt *id)
{
  const SlipParameter *p;

  PetscFunctionBegin;
  *id = 0;
  while ((p = SlipFaultRealRow(*id)) && strcmp(name, p->name)) (*id)++;
  PetscCheck(p, fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "a fault has no number \"%s\"", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Upper bounds are excluded except for these parameters. */
static PetscBool MayBeUpper(const SlipParameter *p)
{
  return p == &SlipFaultReals[FAULT_ACCURACY] || p == &SlipFaultReals[FAULT_DIP] ? PETSC_TRUE : PETSC_FALSE;
}

/* Describes the valid values of a parameter, or of a cell, for example "a number > 0 m"; with C's own %g, since PETSc's
   writes "0." for 0. */
void SlipParameterBounds(const SlipParameter *p, PetscBool cell, char text[], size_t len)
{
  const char *kind = p->integer ? "whole " : "";
  char low[32] = "", high[32] = "";

  if (cell && !p->integer) kind = "finite ";
  if (!cell) (void)snprintf(low, sizeof(low), " that is finite");
  if (p->lower > ANY) (void)snprintf(low, sizeof(low), " %s %g", p->open ? ">" : ">=", (double)p->lower);
  if (p->upper < NONE) (void)snprintf(high, sizeof(high), " and %s %g", MayBeUpper(p) ? "<=" : "<", (double)p->upper);
  (void)snprintf(text, len, "a %snumber%s%s%s%s", kind, low, high, p->unit[0] ? " " : "", p->unit);
}

PetscBool SlipParameterHolds(const SlipParameter *p, PetscReal x)
{
  const PetscBool low = p->open ? (x > p->lower) : (x >= p->lower);
  const PetscBool high = !TooLarge(p, x) && (x < p->upper || (MayBeUpper(p) && x == p->upper));

  return low && high && isfinite(x) && (!p->integer || x == PetscFloorReal(x)) ? PETSC_TRUE : PETSC_FALSE;
}

PetscErrorCode SlipFaultCheckReal(SlipFault fault, const SlipParameter *p, PetscReal x)
{
  char bounds[128], value[32];

  PetscFunctionBegin;
  SlipParameterBounds(p, PETSC_FALSE, bounds, sizeof(bounds));
  if (TooLarge(p, x)) (void)snprintf(bounds, sizeof(bounds), "a number of size <= 1e60 %s", p->unit);
  (void)snprintf(value, sizeof(value), p->integer && PetscAbsReal(x) < 1e15 ? "%.15g" : "%g", (double)x);
  PetscCheck(!p->integer || !isfinite(x) || PetscAbsReal(x) <= (PetscReal)PETSC_MAX_INT, fault->comm,
             PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_%s is %s, which is more than this build's integers hold, %" PetscInt_FMT, SlipFaultPrefix(fault),
             p->name, value, PETSC_MAX_INT);
  PetscCheck(SlipParameterHolds(p, x), fault->comm, PETSC_ERR_ARG_OUTOFRANGE, "-%sfault_%s is %s, expected %s",
             SlipFaultPrefix(fault), p->name, value, bounds);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultSetReal - sets a scalar parameter of the fault

  Logically collective; only before SlipFaultSetUp() (except velocity_scale, accuracy and those that -help calls "of
  the output")

  Input Parameters:
+ fault - the fault
. name  - the option's name without "fault_", for example "length_x"
- value - in the unit that -help gives

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown name, PETSC_ERR_ARG_OUTOFRANGE outside the parameter's bounds.

.seealso: SlipFaultGetReal(), SlipFaultSetString(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultSetReal(SlipFault fault, const char name[], PetscReal value)
{
  PetscInt id = 0;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(SlipFaultFindReal(fault, name, &id));
  PetscCheck(
    !fault->meshed || id == FAULT_VELOCITY_SCALE || id == FAULT_ACCURACY || SlipFaultRealRow(id)->part == OUTPUT,
    fault->comm, PETSC_ERR_ARG_WRONGSTATE, "%s must be set before SlipFaultSetUp() and SlipFaultSetUpMesh()", name);
  PetscCall(SlipFaultCheckReal(fault, SlipFaultRealRow(id), value));
  fault->options.value[id] = value;
  if (id == FAULT_OUTPUT_INTERVAL) fault->options.interval_given = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultGetReal - gets a scalar parameter of the fault

  Not collective. Defaults: thickness is length_x, rate_tolerance 1e-10 m over T*, accuracy 1e-2, hmat_tolerance by it,
  and normal_stress_gradient 15e3 Pa/m, or 0 where a normal_stress is set.

  Input Parameters:
+ fault - the fault
- name  - the option's name without "fault_", for example "length_x"

  Output Parameter:
. value - in the unit that -help gives

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown name

.seealso: SlipFaultSetReal()
@*/
PetscErrorCode SlipFaultGetReal(SlipFault fault, const char name[], PetscReal *value)
{
  PetscReal thickness;
  PetscInt id = 0;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCall(SlipFaultFindReal(fault, name, &id));
  *value = fault->mesh.kind && id < MESH_REALS ? fault->mesh.extent[id] : fault->options.value[id];
  if (id >= FAULT_NUM_REALS && isnan(*value)) *value = SlipFaultRealRow(id)->value;
  if (id == FAULT_THICKNESS && isnan(*value)) PetscCall(SlipFaultGetReal(fault, "length_x", value));
  if (id == FAULT_NORMAL_STRESS_GRADIENT && isnan(*value))
    *value = fault->options.value[FAULT_NORMAL_STRESS] > 0 ? 0 : SLIP_FAULT_STRESS_GRADIENT;
  if (id == FAULT_ACCURACY && isnan(*value)) *value = SLIP_FAULT_ACCURACY;
  if (id == FAULT_HMAT_TOLERANCE) PetscCall(SlipFaultHmatTolerance(fault, value, NULL, 0));
  if (id == FAULT_RATE_TOLERANCE && isnan(*value)) {
    PetscCall(SlipFaultGetReal(fault, "thickness", &thickness));
    *value = SLIP_FAULT_ATOL / thickness *
             PetscSqrtReal(fault->options.value[FAULT_SHEAR_MODULUS] / fault->options.value[FAULT_DENSITY]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the choices of a parameter for a message. *is: value is one of them (NULL allowed). */
PetscErrorCode SlipFaultListChoices(const SlipFaultString *p, const char value[], char list[], size_t len,
                                    PetscBool *is)
{
  char all[FAULT_MAX_CHOICES] = "|", key[PETSC_MAX_PATH_LEN + 2], *found;
  size_t k = 0;

  PetscFunctionBegin;
  if (p == &SlipFaultStrings[FAULT_FRICTION_LAW])
    for (const SlipFrictionLaw *law = SlipFrictionNext(NULL); law; law = SlipFrictionNext(law)) {
      PetscCall(PetscStrlcat(all, law->name, sizeof(all)));
      PetscCall(PetscStrlcat(all, "|", sizeof(all)));
    }
  else if (p == &SlipFaultStrings[FAULT_PERMEABILITY_LAW])
    for (const SlipPermeabilityLaw *law = SlipPermeabilityNext(NULL); law; law = SlipPermeabilityNext(law)) {
      PetscCall(PetscStrlcat(all, law->name, sizeof(all)));
      PetscCall(PetscStrlcat(all, "|", sizeof(all)));
    }
  else if (p == &SlipFaultStrings[FAULT_MEDIUM])
    PetscCall(SlipElasticListTypes(all, sizeof(all)));
  else
    PetscCall(PetscStrncpy(all, p->choices, sizeof(all)));
  for (const char *c = all + 1; *c && c[1] && k + 3 < len; c++) {
    if (*c == '|') list[k++] = ',';
    list[k++] = *c == '|' ? ' ' : *c;
  }
  list[k] = '\0';
  if (!value) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(key, sizeof(key), "|%s|", value));
  PetscCall(PetscStrstr(all, key, &found));
  *is = found ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultSetString - sets a text parameter of the fault, which selects a choice or names a file

  Logically collective; only before SlipFaultSetUp() (except those that -help calls "of the output")

  Input Parameters:
+ fault - the fault
. name  - the option's name without "fault_", for example "friction_law"
- value - one of the choices that -help lists, or a file name

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown name or choice, PETSC_ERR_ARG_OUTOFRANGE for a value of
  PETSC_MAX_PATH_LEN characters or more that is no list of points

.seealso: SlipFaultSetReal(), SlipFaultSetFromOptions()
@*/
PetscErrorCode SlipFaultSetString(SlipFault fault, const char name[], const char value[])
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  for (PetscInt i = 0; i < FAULT_NUM_STRINGS; i++) {
    const SlipFaultString *p = &SlipFaultStrings[i];
    PetscBool same;

    PetscCall(PetscStrcmp(name, p->name, &same));
    if (!same) continue;
    PetscCheck(!fault->meshed || p->part == OUTPUT, fault->comm, PETSC_ERR_ARG_WRONGSTATE,
               "%s must be set before SlipFaultSetUp() and SlipFaultSetUpMesh()", name);
    if (p->choices) {
      char list[FAULT_MAX_CHOICES];
      PetscBool found;

      PetscCall(SlipFaultListChoices(p, value, list, sizeof(list), &found));
      PetscCheck(found, fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "-%sfault_%s is \"%s\", expected one of %s",
                 SlipFaultPrefix(fault), name, value, list);
    }
    PetscCall(PetscFree(fault->options.longer[i]));
    if (strlen(value) >= sizeof(fault->options.text[i])) {
      PetscCheck(i == FAULT_STATIONS || i == FAULT_SURFACE_STATIONS, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
                 "-%sfault_%s has %zu characters, expected at most %zu", SlipFaultPrefix(fault), name, strlen(value),
                 sizeof(fault->options.text[i]) - 1);
      PetscCall(PetscStrallocpy(value, &fault->options.longer[i]));
    }
    PetscCall(PetscStrncpy(fault->options.text[i], value, sizeof(fault->options.text[i])));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  SETERRQ(fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "a fault has no choice \"%s\"", name);
}

/* Returns the text in use. -fault_operator stays "auto", as the type of K shows the choice. */
const char *SlipFaultGetText(SlipFault fault, PetscInt id)
{
  if (fault->setup && id == FAULT_INITIAL) return fault->kind.initial;
  if (fault->setup && id == FAULT_VISCOSITY) return fault->kind.viscosity;
  if (fault->setup && id == FAULT_NORMAL_COUPLING) return fault->kind.coupled ? "yes" : "no";
  return fault->options.text[id];
}
