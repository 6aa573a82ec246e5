/* The combinations of features of a fault and of its runs that are errors. A choice that needs or excludes another
   choice is a rule here and nowhere else; conditions on computed numbers are checked where these are computed. */
#pragma once
#include <slipstep/rooms/slipfault.h>

/* All features, a row each: its name here, the group of those that are values of one choice (OWN: none), the user's
   option or a few words, and when it is active, for a fault f and a TS ts, which is NULL in SlipFaultSetUp(). LATE:
   that is decided when a run begins, or after SlipFaultSetUp(). */
#define SLIP_FAULT_FEATURES(EARLY, LATE)                                                                               \
  EARLY(GRID, MESH, "a uniform grid", HasMesh(f, FEATURE_GRID))                                                        \
  EARLY(RECTANGLES, MESH, "-fault_mesh of rectangles", HasMesh(f, FEATURE_RECTANGLES))                                 \
  EARLY(TRIANGLES, MESH, "-fault_mesh of triangles", HasMesh(f, FEATURE_TRIANGLES))                                    \
  EARLY(PLANES, OWN, "several planes", f->mesh.planes > 1)                                                             \
  EARLY(OBLIQUE, OWN, "dipping planes, or slip other than along strike", f->kind.oblique)                              \
  EARLY(MESH_FRAME, OWN, "-fault_mesh_frame", !Chosen(f, FAULT_MESH_FRAME, "auto"))                                    \
  EARLY(MESH_UNIT, OWN, "-fault_mesh_unit", !Chosen(f, FAULT_MESH_UNIT, "auto"))                                       \
  EARLY(STIFFNESS_FILE, OWN, "-fault_stiffness_file", Given(f, FAULT_STIFFNESS_FILE))                                  \
  EARLY(HALF_SPACE, MEDIUM, "-fault_kernel half_space", Chosen(f, FAULT_KERNEL, "half_space"))                         \
  EARLY(FULL_SPACE, MEDIUM, "-fault_kernel full_space", Chosen(f, FAULT_KERNEL, "full_space"))                         \
  EARLY(MIRROR, MEDIUM, "-fault_kernel mirror", Chosen(f, FAULT_KERNEL, "mirror"))                                     \
  EARLY(WAVES, OWN, "-fault_medium waves", Chosen(f, FAULT_MEDIUM, SLIPELASTICWAVES))                                  \
  EARLY(WAVE_PLANE, OWN, "-fault_medium waves of more than one column of cells",                                       \
        On_WAVES(f, ts) && (f->mesh.ndim < 2 || f->mesh.dims[1] > 1))                                                  \
  EARLY(CENTRE, AVERAGE, "-fault_stiffness_average centre", Chosen(f, FAULT_STIFFNESS_AVERAGE, "centre"))              \
  EARLY(CELL, AVERAGE, "-fault_stiffness_average cell", Chosen(f, FAULT_STIFFNESS_AVERAGE, "cell"))                    \
  EARLY(WHOLE, AVERAGE, "-fault_stiffness_average whole", Chosen(f, FAULT_STIFFNESS_AVERAGE, "whole"))                 \
  EARLY(MEAN_SLIP, OWN, "-fault_stiffness_scaling mean_slip", Chosen(f, FAULT_STIFFNESS_SCALING, "mean_slip"))         \
  EARLY(DENSE, STORAGE, "-fault_operator dense", Chosen(f, FAULT_OPERATOR, "dense"))                                   \
  EARLY(FFT, STORAGE, "-fault_operator fft", Chosen(f, FAULT_OPERATOR, "fft"))                                         \
  EARLY(HMAT, STORAGE, "-fault_operator hmat", Chosen(f, FAULT_OPERATOR, "hmat"))                                      \
  EARLY(STIFFNESS_VIEW, OWN, "-fault_stiffness_view", f->options.stiffness_viewer)                                     \
  EARLY(DEVICE, OWN, "-fault_device opencl", Chosen(f, FAULT_DEVICE, "opencl"))                                        \
  EARLY(SQRTM, VISCOSITY, "-fault_viscosity sqrtm", !strcmp(f->kind.viscosity, "sqrtm"))                               \
  EARLY(SPECTRAL, VISCOSITY, "-fault_viscosity spectral", !strcmp(f->kind.viscosity, "spectral"))                      \
  EARLY(LANCZOS, VISCOSITY, "-fault_viscosity lanczos", !strcmp(f->kind.viscosity, "lanczos"))                         \
  EARLY(RADIATION, VISCOSITY, "-fault_viscosity radiation", !strcmp(f->kind.viscosity, "radiation"))                   \
  EARLY(NONE, VISCOSITY, "-fault_viscosity none", !strcmp(f->kind.viscosity, "none"))                                  \
  EARLY(UNDAMPED, OWN, "-fault_damping_ratio 0 without radiation damping",                                             \
        f->options.value[FAULT_DAMPING_RATIO] == 0 && !On_RADIATION(f, ts))                                            \
  EARLY(INERTIA, MASS, "-fault_inertia yes", f->kind.inertia)                                                          \
  EARLY(BALANCE, MASS, "-fault_inertia no", !f->kind.inertia)                                                          \
  EARLY(SLIP_WEAKENING, LAW, "friction that weakens with slip",                                                        \
        !f->friction.law->always_slides && !f->friction.law->by_rate)                                                  \
  EARLY(RATE_WEAKENING, LAW, "friction that depends on the slip rate, and sticks",                                     \
        !f->friction.law->always_slides && f->friction.law->by_rate)                                                   \
  EARLY(ALWAYS_SLIDES, LAW, "friction whose cells always slide, as rate_and_state", f->friction.law->always_slides)    \
  EARLY(SLIP_LAW, STATE, "-fault_state_law slip",                                                                      \
        f->friction.law->always_slides && f->friction.state_law == SLIP_STATE_SLIP)                                    \
  EARLY(COMPOSITE_LAW, STATE, "-fault_state_law composite",                                                            \
        f->friction.law->always_slides && f->friction.state_law == SLIP_STATE_COMPOSITE)                               \
  EARLY(PRZ_LAW, STATE, "-fault_state_law prz",                                                                        \
        f->friction.law->always_slides && f->friction.state_law == SLIP_STATE_PRZ)                                     \
  EARLY(ALPHA, OWN, "-fault_friction_alpha", f->friction.law->always_slides &&AnyCell(f, FIELD_FRICTION_ALPHA))        \
  EARLY(HEALING, OWN, "-fault_healing_time", AnyCell(f, FIELD_HEALING_TIME))                                           \
  EARLY(CREEP, OWN, "-fault_creep", AnyCell(f, FIELD_CREEP))                                                           \
  EARLY(CRITICAL, START, "-fault_initial critical", !strcmp(f->kind.initial, "critical"))                              \
  EARLY(REST, START, "-fault_initial rest", !strcmp(f->kind.initial, "rest"))                                          \
  EARLY(TRACTION, START, "-fault_initial traction", !strcmp(f->kind.initial, "traction"))                              \
  EARLY(RATE, START, "-fault_initial rate", !strcmp(f->kind.initial, "rate"))                                          \
  EARLY(LOADING, OWN, "-fault_loading_rate", f->kind.loaded)                                                           \
  EARLY(STRESSING, OWN, "-fault_stressing_rate", AnyCell(f, FIELD_STRESSING_RATE))                                     \
  EARLY(REGIONAL, OWN, "-fault_regional_stress or -fault_regional_stress_gradient",                                    \
        Given(f, FAULT_REGIONAL_STRESS) || Given(f, FAULT_REGIONAL_STRESS_GRADIENT))                                   \
  EARLY(RATIOS, OWN, "-fault_regional_ratios", Given(f, FAULT_REGIONAL_RATIOS))                                        \
  EARLY(AZIMUTH, OWN, "-fault_regional_azimuth", f->options.value[FAULT_REGIONAL_AZIMUTH] != 0)                        \
  EARLY(REGIONAL_DETAIL, OWN, "-fault_regional_pressure or -fault_regional_rake",                                      \
        !Chosen(f, FAULT_REGIONAL_PRESSURE, "hydrostatic") || !Chosen(f, FAULT_REGIONAL_RAKE, "given"))                \
  EARLY(COUPLED, COUPLING, "-fault_normal_coupling yes", Chosen(f, FAULT_NORMAL_COUPLING, "yes"))                      \
  EARLY(UNCOUPLED, COUPLING, "-fault_normal_coupling no", Chosen(f, FAULT_NORMAL_COUPLING, "no"))                      \
  EARLY(VECTOR, OWN, "-fault_slip_components 2", f->options.value[FAULT_SLIP_COMPONENTS] == 2)                         \
  EARLY(OPENING, OWN, "-fault_opening yes", f->options.opening)                                                        \
  EARLY(INJECTION, OWN, "-fault_injection", Given(f, FAULT_INJECTION))                                                 \
  EARLY(INJECTED, OWN, "-fault_injection_pressure, -fault_injection_diffusivity or -fault_injection_stop",             \
        f->options.value[FAULT_INJECTION_PRESSURE] != 0 || f->options.value[FAULT_INJECTION_DIFFUSIVITY] != 0 ||       \
          f->options.value[FAULT_INJECTION_STOP] != 0)                                                                 \
  EARLY(SOURCE, OWN, "-fault_injection_pressure and -fault_injection_diffusivity",                                     \
        f->options.value[FAULT_INJECTION_PRESSURE] != 0 && f->options.value[FAULT_INJECTION_DIFFUSIVITY] > 0)          \
  EARLY(HISTORY, OWN, "-fault_stress_history or SlipFaultAddStress()",                                                 \
        Given(f, FAULT_STRESS_HISTORY) || f->loads.ngiven > 0)                                                         \
  EARLY(TIDE, OWN, "-fault_tide_period", Given(f, FAULT_TIDE_PERIOD))                                                  \
  EARLY(TIDAL, OWN, "-fault_tide_shear or -fault_tide_normal",                                                         \
        Given(f, FAULT_TIDE_SHEAR) || Given(f, FAULT_TIDE_NORMAL))                                                     \
  EARLY(TIDE_PHASE, OWN, "-fault_tide_phase", Given(f, FAULT_TIDE_PHASE))                                              \
  EARLY(NUCLEATION, OWN, "-fault_nucleation", Given(f, FAULT_NUCLEATION))                                              \
  EARLY(SHEAR_ZONE, OWN, "-fault_shear_zone_width", f->options.value[FAULT_SHEAR_ZONE_WIDTH] > 0)                      \
  EARLY(PRESSURISATION, OWN, "-fault_thermal_pressurisation", AnyCell(f, FIELD_THERMAL_PRESSURISATION))                \
  EARLY(DILATANCY, OWN, "-fault_dilatancy", AnyCell(f, FIELD_DILATANCY))                                               \
  LATE(PRESSURE, OWN, "a pore pressure", f->loads.pore)                                                                \
  EARLY(FLUID, OWN, "-fault_permeability", AnyCell(f, FIELD_PERMEABILITY))                                             \
  EARLY(FLUID_DETAIL, OWN, "-fault_porosity, -fault_leakoff and other options of fluid in the fault", FluidDetail(f))  \
  EARLY(CARTER, OWN, "-fault_carter_leakoff", AnyCell(f, FIELD_CARTER_LEAKOFF))                                        \
  EARLY(CARTER_PRESSURE, OWN, "-fault_carter_pressure",                                                                \
        f->options.value[FAULT_CARTER_PRESSURE] != SlipFaultReals[FAULT_CARTER_PRESSURE].value)                        \
  EARLY(WELLS, OWN, "-fault_wells", Given(f, FAULT_WELLS))                                                             \
  EARLY(PERMEABILITY_BY_SLIP, OWN, "-fault_permeability_law slip and valve", LawNeeds(f, SLIP_PERMEABILITY_BY_SLIP))   \
  EARLY(PERMEABILITY_BY_STRESS, OWN, "-fault_permeability_law stress and valve",                                       \
        LawNeeds(f, SLIP_PERMEABILITY_BY_STRESS))                                                                      \
  EARLY(PERMEABILITY_MAXIMUM, OWN, "-fault_permeability_maximum", AnyCell(f, FIELD_PERMEABILITY_MAXIMUM))              \
  EARLY(PERMEABILITY_SLIP, OWN, "-fault_permeability_slip", f->options.value[FAULT_PERMEABILITY_SLIP] > 0)             \
  EARLY(PERMEABILITY_HEALING, OWN, "-fault_permeability_healing_time",                                                 \
        f->options.value[FAULT_PERMEABILITY_HEALING_TIME] > 0)                                                         \
  EARLY(PERMEABILITY_STRESS, OWN, "-fault_permeability_stress", f->options.value[FAULT_PERMEABILITY_STRESS] > 0)       \
  LATE(OUTPUT, OWN, "-fault_output", Given(f, FAULT_OUTPUT))                                                           \
  LATE(OUTPUT_PRESSURE, OWN, "-fault_output_fields pore_pressure",                                                     \
       Given(f, FAULT_OUTPUT) && Lists(f, "pore_pressure"))                                                            \
  LATE(OUTPUT_OPENING, OWN, "-fault_output_fields opening", Given(f, FAULT_OUTPUT) && Lists(f, "opening"))             \
  LATE(OUTPUT_TEMPERATURE, OWN, "-fault_output_fields temperature", Given(f, FAULT_OUTPUT) && Lists(f, "temperature")) \
  LATE(OUTPUT_ZONE, OWN, "-fault_output_fields shear_zone_pressure",                                                   \
       Given(f, FAULT_OUTPUT) && Lists(f, "shear_zone_pressure"))                                                      \
  LATE(OUTPUT_FLUID, OWN, "-fault_output_fields permeability or fluid_flux",                                           \
       Given(f, FAULT_OUTPUT) && (Lists(f, "permeability") || Lists(f, "fluid_flux")))                                 \
  LATE(STATIONS, OWN, "-fault_stations", Given(f, FAULT_STATIONS))                                                     \
  LATE(SURFACE_STATIONS, OWN, "-fault_surface_stations", Given(f, FAULT_SURFACE_STATIONS))                             \
  LATE(CATALOGUE, OWN, "-fault_catalogue", Given(f, FAULT_CATALOGUE))                                                  \
  LATE(CHECKPOINT, OWN, "-fault_checkpoint or -fault_restart", Given(f, FAULT_CHECKPOINT) || Given(f, FAULT_RESTART))  \
  LATE(CHECK_ERROR, OWN, "-fault_check_error", f->options.check_error)                                                 \
  LATE(BATHE, INTEGRATOR, "-ts_type bathe", HasType(ts, TSBATHE))                                                      \
  LATE(MOREAU, INTEGRATOR, "-ts_type moreau", HasType(ts, TSMOREAU))                                                   \
  LATE(ADAMS, INTEGRATOR, "-ts_type adams", HasType(ts, TSADAMS))                                                      \
  LATE(RK, INTEGRATOR, "-ts_type rk", HasType(ts, TSRK))                                                               \
  LATE(RKC, INTEGRATOR, "-ts_type rkc", HasType(ts, TSRKC))                                                            \
  LATE(LAPUSTA, INTEGRATOR, "-ts_type lapusta", HasType(ts, TSLAPUSTA))                                                \
  LATE(OTHER_TS, INTEGRATOR, "-ts_type of another integrator of PETSc",                                                \
       ts && !On_BATHE(f, ts) && !On_MOREAU(f, ts) && !On_ADAMS(f, ts) && !On_RK(f, ts) && !On_RKC(f, ts) &&           \
         !On_LAPUSTA(f, ts))

#define FEATURE_ID(name, group, text, condition) FEATURE_##name,
typedef enum { SLIP_FAULT_FEATURES(FEATURE_ID, FEATURE_ID) FAULT_NUM_FEATURES } SlipFaultFeatureId;

typedef struct {
  const char *name; /* the user's option, or a few words */
  PetscInt group;   /* of features that are values of one choice, from 1 on; 0: none */
  PetscBool late;   /* decided when a run begins, or after SlipFaultSetUp() */
  /* Is it active? ts: NULL in SlipFaultSetUp() */
  PetscBool (*on)(SlipFault fault, TS ts);
} SlipFaultFeature;
PETSC_EXTERN const SlipFaultFeature SlipFaultFeatures[FAULT_NUM_FEATURES];

/* Sets of features, bit by bit, in two words */
__extension__ typedef unsigned __int128 SlipFaultFeatureSet;
#define SLIP_FEATURE(name) ((SlipFaultFeatureSet)1 << FEATURE_##name)

/* If one of `these` is active and none of `unless`, one of the others must not be, or must be. The sentence is for the
   user: -fault_NAME gets the prefix, and % is the value of the option before it. */
typedef struct {
  SlipFaultFeatureSet these;
  PetscBool needs;
  SlipFaultFeatureSet others, unless;
  const char *sentence;
} SlipFaultRule;
PETSC_EXTERN const SlipFaultRule SlipFaultRules[]; /* the last one has no sentence */

/* The active features of a fault whose cells are set up; ts NULL: without the late ones */
PETSC_EXTERN SlipFaultFeatureSet SlipFaultFeaturesOn(SlipFault fault, TS ts);
PETSC_EXTERN PetscErrorCode SlipFaultRuleText(SlipFault fault, TS ts, const SlipFaultRule *rule, char text[],
                                              size_t len);
/* Gets the sentence of the first rule that forbids these with the active features, but not those alone, or "". */
PETSC_INTERN PetscErrorCode SlipFaultRefuses(SlipFault fault, TS ts, SlipFaultFeatureSet these, char text[],
                                             size_t len);
/* Raises errors for forbidden combinations, before any computation with ts NULL, and again before a run. */
PETSC_EXTERN PetscErrorCode SlipFaultCheckFeatures(SlipFault fault, TS ts);
