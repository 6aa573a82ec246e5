/* Every pair of features of a fault and of its runs (src/fault/setup/features.c) on twelve cells: what the table allows
   runs to its end, stays finite and keeps its energy, and what it does not is refused with the sentence of its rule, as
   is what lacks something that it needs. Argument -pairs: prints what became of each. */
#define _POSIX_C_SOURCE 200809L /* dup2(), fdopen() */
#include "unit.h"
#include "tempdir.h"
#include "record.h"
#include <slipstep/rooms/sliph5.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <math.h>

enum { NX = 4, NZ = 3, N = NX * NZ };
/* of an event, from which on a run is warned (src/run/catalogue/catalogue.c): errors of the powers' quadrature over
   steps */
#define RESIDUAL 0.035

/* How each is switched on; beside: what gives a run something to do with it, which any other feature may change;
   implies: what it is nothing without. Where the cells are a list, @ is _list, and where they are on several planes, #
   is the coordinate between two. */
static const struct {
  const char *own, *beside;
  SlipFaultFeatureSet implies;
} How[FAULT_NUM_FEATURES] = {
  [FEATURE_GRID] = {""},
  [FEATURE_RECTANGLES] = {"-fault_mesh rectangles.h5"},
  [FEATURE_TRIANGLES] = {"-fault_mesh triangles.h5"},
  [FEATURE_PLANES] = {"-fault_mesh planes.h5", "", SLIP_FEATURE(RECTANGLES)},
  [FEATURE_OBLIQUE] = {"-fault_dip 60 -fault_rake 90"},
  [FEATURE_MESH_FRAME] = {"-fault_mesh_frame ned"},
  [FEATURE_MESH_UNIT] = {"-fault_mesh_unit m"},
  [FEATURE_STIFFNESS_FILE] = {"-fault_stiffness_file k.h5"},
  [FEATURE_HALF_SPACE] = {"-fault_kernel half_space"},
  [FEATURE_MIRROR] = {"-fault_kernel mirror", "-fault_depth_top 0"},
  [FEATURE_FULL_SPACE] = {"-fault_kernel full_space"},
  [FEATURE_WAVES] = {"-fault_medium waves", "-ts_max_time 3", SLIP_FEATURE(WAVE_PLANE)},
  [FEATURE_WAVE_PLANE] = {"-fault_medium waves", "", SLIP_FEATURE(WAVES)},
  [FEATURE_CENTRE] = {"-fault_stiffness_average centre"},
  [FEATURE_CELL] = {"-fault_stiffness_average cell"},
  [FEATURE_WHOLE] = {"-fault_stiffness_average whole"},
  [FEATURE_MEAN_SLIP] = {"-fault_stiffness_scaling mean_slip"},
  [FEATURE_DENSE] = {"-fault_operator dense"},
  [FEATURE_FFT] = {"-fault_operator fft"},
  [FEATURE_HMAT] = {"-fault_operator hmat"},
  [FEATURE_STIFFNESS_VIEW] = {"-fault_stiffness_view binary:K.bin"},
  [FEATURE_DEVICE] = {"-fault_device opencl"},
  [FEATURE_SQRTM] = {"-fault_viscosity sqrtm"},
  [FEATURE_SPECTRAL] = {"-fault_viscosity spectral"},
  [FEATURE_LANCZOS] = {"-fault_viscosity lanczos"},
  [FEATURE_RADIATION] = {"-fault_viscosity radiation"},
  [FEATURE_NONE] = {"-fault_viscosity none"},
  [FEATURE_UNDAMPED] = {"-fault_damping_ratio 0", "-fault_viscosity sqrtm -fault_inertia yes"},
  [FEATURE_INERTIA] = {"-fault_inertia yes"},
  [FEATURE_BALANCE] = {"-fault_inertia no"},
  [FEATURE_SLIP_WEAKENING] = {"-fault_friction_law linear_slip_weakening"},
  [FEATURE_RATE_WEAKENING] = {"-fault_friction_law rate_weakening", "-fault_friction_rate 1"},
  [FEATURE_ALWAYS_SLIDES] = {"-fault_friction_law rate_and_state",
                             "-fault_initial_rate 0.1 -fault_friction_slip 0.02 -ts_max_time 400"},
  [FEATURE_SLIP_LAW] = {"-fault_state_law slip", "", SLIP_FEATURE(ALWAYS_SLIDES)},
  [FEATURE_COMPOSITE_LAW] = {"-fault_state_law composite", "", SLIP_FEATURE(ALWAYS_SLIDES)},
  [FEATURE_PRZ_LAW] = {"-fault_state_law prz", "", SLIP_FEATURE(ALWAYS_SLIDES)},
  [FEATURE_ALPHA] = {"-fault_friction_alpha 0.01", "", SLIP_FEATURE(ALWAYS_SLIDES)},
  [FEATURE_HEALING] = {"-fault_healing_time 1000"},
  [FEATURE_CREEP] = {""}, /* a field */
  [FEATURE_CRITICAL] = {"-fault_initial critical"},
  [FEATURE_REST] = {"-fault_initial rest"},
  [FEATURE_TRACTION] = {"-fault_initial traction", "-fault_initial_traction 1.21e7 -fault_initial_unstable yes"},
  [FEATURE_RATE] = {"-fault_initial rate"},
  [FEATURE_LOADING] = {"-fault_loading_rate 1e-9"},
  [FEATURE_STRESSING] = {"-fault_stressing_rate 1"},
  [FEATURE_REGIONAL] = {"-fault_regional_stress 2e7,2e7,2e7,-1.21e7,0,0 "
                        "-fault_regional_stress_gradient 9.81e3,9.81e3,9.81e3,0,0,0",
                        "-fault_initial_unstable yes"},
  [FEATURE_RATIOS] = {"-fault_regional_ratios 1.37,0.63", "-fault_regional_azimuth 135 -fault_initial_unstable yes",
                      SLIP_FEATURE(AZIMUTH)},
  [FEATURE_AZIMUTH] = {"-fault_regional_azimuth 136", "-fault_initial_unstable yes"},
  [FEATURE_REGIONAL_DETAIL] = {"-fault_regional_pressure 0,9.9e3", "-fault_initial_unstable yes"},
  [FEATURE_COUPLED] = {"-fault_normal_coupling yes"},
  [FEATURE_UNCOUPLED] = {"-fault_normal_coupling no"},
  [FEATURE_VECTOR] = {"-fault_slip_components 2"},
  [FEATURE_OPENING] = {"-fault_opening yes"},
  [FEATURE_INJECTION] = {"-fault_injection 1400,#3400", "", SLIP_FEATURE(PRESSURE)},
  [FEATURE_INJECTED] = {"-fault_injection_stop 1"},
  [FEATURE_SOURCE] = {"-fault_injection_pressure 1e4 -fault_injection_diffusivity 1", "", SLIP_FEATURE(INJECTED)},
  [FEATURE_HISTORY] = {"-fault_stress_history history.csv"},
  [FEATURE_TIDE] = {"-fault_tide_period 7"},
  [FEATURE_TIDAL] = {"-fault_tide_shear 1e4"},
  [FEATURE_TIDE_PHASE] = {"-fault_tide_phase 30"},
  [FEATURE_NUCLEATION] = {"-fault_nucleation 1400,#3400,2000,1e5,3"},
  [FEATURE_SHEAR_ZONE] = {"-fault_shear_zone_width 0.01"},
  [FEATURE_PRESSURISATION] = {"-fault_thermal_pressurisation 1e5"},
  [FEATURE_DILATANCY] = {"-fault_dilatancy 1e-6"},
  [FEATURE_PRESSURE] = {"-fault_pore_pressure record@.h5"},
  [FEATURE_FLUID] = {"-fault_permeability 1e-13"},
  [FEATURE_FLUID_DETAIL] = {"-fault_porosity 0.05"},
  [FEATURE_WELLS] = {"-fault_wells wells.csv"},
  [FEATURE_PERMEABILITY_BY_SLIP] = {"-fault_permeability_law valve", "",
                                    SLIP_FEATURE(PERMEABILITY_BY_STRESS) | SLIP_FEATURE(FLUID_DETAIL)},
  [FEATURE_PERMEABILITY_BY_STRESS] = {"-fault_permeability_law valve", "",
                                      SLIP_FEATURE(PERMEABILITY_BY_SLIP) | SLIP_FEATURE(FLUID_DETAIL)},
  [FEATURE_CARTER] = {"-fault_carter_leakoff 1e-12", "", SLIP_FEATURE(FLUID_DETAIL)},
  [FEATURE_CARTER_PRESSURE] = {"-fault_carter_pressure 2e3"},
  [FEATURE_PERMEABILITY_MAXIMUM] = {"-fault_permeability_maximum 1e-12"},
  [FEATURE_PERMEABILITY_SLIP] = {"-fault_permeability_slip 0.1"},
  [FEATURE_PERMEABILITY_HEALING] = {"-fault_permeability_healing_time 100"},
  [FEATURE_PERMEABILITY_STRESS] = {"-fault_permeability_stress 1e7"},
  [FEATURE_OUTPUT] = {"-fault_output run.h5"},
  [FEATURE_OUTPUT_PRESSURE] = {"-fault_output_fields slip,pore_pressure", "", SLIP_FEATURE(OUTPUT)},
  [FEATURE_OUTPUT_OPENING] = {"-fault_output_fields slip,opening", "", SLIP_FEATURE(OUTPUT)},
  [FEATURE_OUTPUT_TEMPERATURE] = {"-fault_output_fields slip,temperature", "", SLIP_FEATURE(OUTPUT)},
  [FEATURE_OUTPUT_ZONE] = {"-fault_output_fields slip,shear_zone_pressure", "", SLIP_FEATURE(OUTPUT)},
  [FEATURE_OUTPUT_FLUID] = {"-fault_output_fields slip,fluid_flux", "", SLIP_FEATURE(OUTPUT)},
  [FEATURE_STATIONS] = {"-fault_stations 1400,2600"},
  [FEATURE_SURFACE_STATIONS] = {"-fault_surface_stations 100,100"},
  [FEATURE_CATALOGUE] = {"-fault_catalogue events.h5"},
  [FEATURE_CHECKPOINT] = {"-fault_checkpoint state"},
  [FEATURE_CHECK_ERROR] = {"-fault_check_error yes", "-ts_type bathe"},
  [FEATURE_BATHE] = {"-ts_type bathe"},
  [FEATURE_MOREAU] = {"-ts_type moreau"},
  [FEATURE_ADAMS] = {"-ts_type adams"},
  [FEATURE_RK] = {"-ts_type rk -ts_rtol 3e-4"}, /* 3bs, whose steps have no inner states for the energy */
  [FEATURE_RKC] = {"-ts_type rkc"},
  [FEATURE_LAPUSTA] = {"-ts_type lapusta"},
  [FEATURE_OTHER_TS] = {"-ts_type ssp -ts_adapt_type none -ts_dt 0.05 -ts_max_time 1"}, /* without an error estimate */
};
static const char base[] =
  "-fault_nx 4 -fault_nz 3 -fault_depth_top 2000 -fault_normal_stress 2e7 -ts_max_time 30 -fault_catalogue events.h5 "
  "-fault_progress no -fault_output_xdmf no -fault_output_overwrite yes";
/* Groups of which every fault has one; of storage and coupling there is auto, and of laws of the state the default */
static PetscBool Complete(PetscInt group)
{
  return group && group != SlipFaultFeatures[FEATURE_DENSE].group &&
             group != SlipFaultFeatures[FEATURE_COUPLED].group && group != SlipFaultFeatures[FEATURE_SLIP_LAW].group
           ? PETSC_TRUE
           : PETSC_FALSE;
}

static SlipFaultFeatureSet One(PetscInt f)
{
  return (SlipFaultFeatureSet)1 << f;
}

static PetscBool Broken(const SlipFaultRule *rule, SlipFaultFeatureSet set)
{
  return !rule->needs && set & rule->these && set & rule->others && !(set & rule->unless) ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool SameGroup(PetscInt f, PetscInt g)
{
  return SlipFaultFeatures[f].group && SlipFaultFeatures[f].group == SlipFaultFeatures[g].group ? PETSC_TRUE
                                                                                                : PETSC_FALSE;
}

/* Two choices of one thing */
static PetscBool Twice(SlipFaultFeatureSet set)
{
  PetscBool chosen[FAULT_NUM_FEATURES] = {PETSC_FALSE}; /* groups */

  for (PetscInt f = 0; f < FAULT_NUM_FEATURES; f++) {
    const PetscInt group = SlipFaultFeatures[f].group;

    if (!(set & One(f)) || !group) continue;
    if (chosen[group]) return PETSC_TRUE;
    chosen[group] = PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static PetscBool Consistent(SlipFaultFeatureSet set)
{
  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence; rule++)
    if (Broken(rule, set)) return PETSC_FALSE;
  return !Twice(set);
}

/* Of a group of which every fault has a member, what the set leaves: nothing but one, all of it where nothing is left,
   none where there is a choice */
static SlipFaultFeatureSet Left(SlipFaultFeatureSet set, PetscInt group)
{
  SlipFaultFeatureSet all = 0, left = 0;

  for (PetscInt f = 0; f < FAULT_NUM_FEATURES; f++) {
    if (SlipFaultFeatures[f].group != group) continue;
    all |= One(f);
    if (Consistent(set | One(f))) left |= One(f);
  }
  if (set & all || left & (left - 1)) return 0;
  return left ? left : all;
}

/* With all that these need, and what is left where they exclude every other choice */
static SlipFaultFeatureSet Closure(SlipFaultFeatureSet set, PetscBool implied)
{
  for (SlipFaultFeatureSet before = 0; before != set;) {
    before = set;
    for (PetscInt f = 0; f < FAULT_NUM_FEATURES && implied; f++)
      if (set & One(f)) set |= How[f].implies;
    for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence; rule++)
      if (rule->needs && set & rule->these && !(set & rule->others))
        set |= rule->others & (~rule->others + 1); /* the first */
    for (PetscInt f = 0; f < FAULT_NUM_FEATURES && Consistent(set); f++)
      if (Complete(SlipFaultFeatures[f].group)) set |= Left(set, SlipFaultFeatures[f].group);
  }
  return set;
}

static void Add(char text[], size_t len, const char more[], PetscBool list, PetscBool planes)
{
  size_t n = strlen(text);

  for (const char *c = more ? more : ""; *c && n + 8 < len; c++) {
    const char *put = *c == '@' ? (list ? "_list" : "") : *c == '#' ? (planes ? "0," : "") : NULL;

    if (put)
      n += (size_t)snprintf(text + n, len - n, "%s", put);
    else
      text[n++] = *c;
  }
  text[n++] = ' ';
  text[n] = '\0';
}

/* Those of the two come last, so that theirs count, and choices beside them are left out; of rectangles and several
   planes the latter */
static void Options(SlipFaultFeatureSet set, PetscInt a, PetscInt b, char text[], size_t len)
{
  const PetscBool planes = set & SLIP_FEATURE(PLANES) ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool list = set & (SLIP_FEATURE(RECTANGLES) | SLIP_FEATURE(TRIANGLES)) ? PETSC_TRUE : PETSC_FALSE;
  const SlipFaultFeatureSet fields = SLIP_FEATURE(OUTPUT_PRESSURE) | SLIP_FEATURE(OUTPUT_OPENING) |
                                     SLIP_FEATURE(OUTPUT_TEMPERATURE) | SLIP_FEATURE(OUTPUT_ZONE) |
                                     SLIP_FEATURE(OUTPUT_FLUID);

  text[0] = '\0';
  Add(text, len, base, list, planes);
  for (PetscInt f = 0; f < FAULT_NUM_FEATURES; f++)
    if (set & One(f)) Add(text, len, How[f].beside, list, planes);
  for (PetscInt f = 0; f < FAULT_NUM_FEATURES; f++)
    if (set & One(f) && f != a && f != b && !SameGroup(f, a) && !SameGroup(f, b))
      Add(text, len, How[f].own, list, planes);
  Add(text, len, How[b].own, list, planes);
  Add(text, len, How[a].own, list, planes);
  if (One(a) & fields && One(b) & fields) { /* one option for both */
    text[strlen(text) - 1] = ',';
    Add(text, len, strrchr(How[b].own, ',') + 1, list, planes);
  }
}

/* ---- a run ---- */

typedef struct {
  PetscBool refused, complete;
  SlipFaultFeatureSet on;
  PetscReal residual, largest; /* of its events, over the larger of elastic energy and heat; of its state */
  PetscInt events, steps;      /* steps in which a cell slides, whether or not others follow at rest */
  char said[4096];
} Outcome;

static PetscErrorCode Energies(Outcome *out)
{
  PetscReal *left, *elastic, *heat;
  SlipH5 h;

  PetscCall(SlipH5OpenRead("events.h5", &h));
  PetscCall(SlipH5ReadReal(&h, "/energy_residual", 1, &out->events, &left));
  PetscCall(SlipH5ReadReal(&h, "/elastic_energy", 1, &out->events, &elastic));
  PetscCall(SlipH5ReadReal(&h, "/dissipated_energy", 1, &out->events, &heat));
  for (PetscInt k = 0; k < out->events; k++) {
    const PetscReal one = fabs(left[k] * elastic[k]) / PetscMax(fabs(elastic[k]), fabs(heat[k]));

    if (!(one <= out->residual)) out->residual = one;
  }
  PetscCall(PetscFree(left));
  PetscCall(PetscFree(elastic));
  PetscCall(PetscFree(heat));
  return SlipH5Close(&h);
}

/* A monitor: the steps at whose end a cell slides */
static PetscErrorCode CountSlides(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  SlipFault fault;
  PetscReal speed;

  PetscCall(PetscObjectQuery((PetscObject)ts, "SlipFault", (PetscObject *)&fault));
  PetscCall(SlipFaultLargestSpeed(fault, w, &speed));
  ((Outcome *)ctx)->steps += step > 0 && speed > 0;
  return PETSC_SUCCESS;
}

static PetscErrorCode Solve(SlipFault fault, TS ts, SlipFaultFeatureSet wanted, Vec *w, Outcome *out)
{
  PetscReal creep[N] = {[N - 1] = 1};
  TSConvergedReason reason;
  int code;

  PetscCall(SlipFaultSetFromOptions(fault));
  if (wanted & SLIP_FEATURE(CREEP)) PetscCall(SlipFaultSetField(fault, "creep", N, creep));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, w));
  PetscCall(SlipFaultSetInitialState(fault, *w));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(TSSetSolution(ts, *w));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  out->on = SlipFaultFeaturesOn(fault, ts);
  out->steps = 0;
  PetscCall(TSMonitorSet(ts, CountSlides, out, NULL));
  PetscCall(SlipFaultOutputStart(fault, ts));
  PetscCall(SlipFaultCheckpointStart(fault, ts));
  PetscCall(TSSolve(ts, *w));
  PetscCall(TSGetConvergedReason(ts, &reason));
  PetscCall(SlipFaultCheckpointFinish(fault, ts, &code));
  PetscCall(SlipFaultOutputFinish(fault, ts, 0, 0));
  PetscCall(VecNorm(*w, NORM_INFINITY, &out->largest));
  out->complete = reason > 0 && !code ? PETSC_TRUE : PETSC_FALSE;
  return Energies(out);
}

static Outcome Try(SlipFaultFeatureSet set, PetscInt a, PetscInt b)
{
  Outcome out = {0};
  char text[4096];
  SlipFault fault;
  TS ts;
  Vec w = NULL;

  Options(set, a, b, text, sizeof(text));
  remove("events.h5");
  remove("state");
  remove("K.bin");
  ok(SetOptions(text));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  message[0] = '\0';
  if (!Solve(fault, ts, set, &w, &out)) {
    if (!access("K.bin", R_OK)) out.on |= SLIP_FEATURE(STIFFNESS_VIEW); /* which is over after the set-up */
  } else {
    out.refused = PETSC_TRUE;
    snprintf(out.said, sizeof(out.said), "%s", message[0] ? message : "an error without words");
  }
  ObjectsDestroy(&w, &ts, &fault);
  return out;
}

/* ---- the files ---- */

static PetscErrorCode WriteOwnRecord(const char name[], PetscInt ndim, const PetscInt shape[])
{
  const PetscInt two = 2;
  const PetscReal times[] = {0, 10};
  PetscReal pressure[2 * N] = {0};

  for (PetscInt i = 0; i < N; i++) pressure[N + i] = 1e4 * (PetscReal)i;
  return WriteRecord(name, two, times, ndim, shape, pressure);
}

static PetscErrorCode WriteHistory(const char name[])
{
  FILE *file = fopen(name, "w");

  if (!file) return PETSC_ERR_FILE_OPEN;
  fprintf(file, "time,shear,normal\n0,0,0\n3,2e4,1e4\n10,-1e4,-1e5\n");
  return fclose(file) ? PETSC_ERR_FILE_WRITE : PETSC_SUCCESS;
}

static PetscErrorCode WriteWells(void)
{
  FILE *file = fopen("wells.csv", "w");

  if (!file) return PETSC_ERR_FILE_OPEN;
  fprintf(file, "well,x,z,s,L/s\nA,1400,3400,0,0.01\nA,1400,3400,10,0\n");
  return fclose(file) ? PETSC_ERR_FILE_WRITE : PETSC_SUCCESS;
}

/* The plane of the grid, and one whose right half is 200 m aside and turned */
static PetscErrorCode WriteRectangles(const char name[], PetscBool aside)
{
  const PetscInt shape[] = {N, 7};
  PetscReal cells[N][7];
  SlipH5 h;

  for (PetscInt e = 0; e < N; e++) {
    const PetscInt i = e % NX, j = e / NX;
    const PetscReal cell[7] = {
      750 * (i + 0.5), aside && i >= NX / 2 ? 200 : 0, 2000 + 1000 * (j + 0.5), 750, 1000, 0, 90};

    PetscCall(PetscArraycpy(cells[e], cell, 7));
  }
  PetscCall(SlipH5Create(name, &h));
  PetscCall(SlipH5WriteReal(&h, "/cells", 2, shape, cells[0], NULL));
  PetscCall(SlipH5WriteAttrString(&h, "/cells", "columns", "x y z length width strike dip"));
  PetscCall(SlipH5WriteAttrString(&h, "/cells", "units", "m"));
  return SlipH5Close(&h);
}

/* Two by three rectangles, each cut in two */
static PetscErrorCode WriteTriangles(void)
{
  const PetscInt vertices[] = {12, 3}, triangles[] = {N, 3};
  PetscReal vertex[12][3];
  PetscInt corner[N][3];
  SlipH5 h;

  for (PetscInt k = 0; k < 12; k++) {
    const PetscReal point[3] = {1500 * (PetscReal)(k % 3), 0, 2000 + 1000 * (PetscReal)(k / 3)};

    PetscCall(PetscArraycpy(vertex[k], point, 3));
  }
  for (PetscInt q = 0; q < N / 2; q++) {
    const PetscInt k = q % 2 + 3 * (q / 2), two[2][3] = {{k, k + 1, k + 3}, {k + 1, k + 4, k + 3}};

    PetscCall(PetscArraycpy(corner[2 * q], two[0], 6));
  }
  PetscCall(SlipH5Create("triangles.h5", &h));
  PetscCall(SlipH5WriteReal(&h, "/vertices", 2, vertices, vertex[0], "m"));
  PetscCall(SlipH5WriteInt(&h, "/triangles", 2, triangles, corner[0], NULL));
  return SlipH5Close(&h);
}

/* The stiffness of the grid, as -fault_stiffness_file has it */
static PetscErrorCode WriteStiffness(void)
{
  const PetscInt shape[] = {N, N};
  const PetscScalar *a;
  SlipFault fault;
  Mat K, dense;
  SlipH5 h;

  PetscCall(SetOptions(base));
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultGetOperators(fault, &K, NULL, NULL));
  PetscCall(MatConvert(K, MATDENSE, MAT_INITIAL_MATRIX, &dense));
  a = MatRead(dense);
  PetscCall(SlipH5Create("k.h5", &h));
  PetscCall(SlipH5WriteReal(&h, "/stiffness", 2, shape, a, "Pa/m"));
  PetscCall(SlipH5Close(&h));
  return DestroyObjects(&dense, &fault);
}

/* ---- the pairs ---- */

enum { RUNS, REFUSED, VOID, KINDS };
static PetscBool print = PETSC_FALSE;
static FILE *report; /* the standard error, which runs fill with warnings */

/* Do these words follow from a sentence? */
static PetscBool Says(const char *s, const char *said)
{
  for (; *s; s++) {
    if (*s == '%') /* a value, without blanks */
      while (*said && *said != ' ' && *said != s[1]) said++;
    else if (*s != *said++)
      return PETSC_FALSE;
  }
  return *said ? PETSC_FALSE : PETSC_TRUE;
}

/* The fault said what a rule of both says, or where there is none a rule of what they need */
static PetscBool SaidByRule(SlipFaultFeatureSet both, SlipFaultFeatureSet needed, const char said[])
{
  PetscBool direct = PETSC_FALSE;

  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence; rule++) {
    if (!Broken(rule, both)) continue;
    direct = PETSC_TRUE;
    if (Says(rule->sentence, said)) return PETSC_TRUE;
  }
  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence && !direct; rule++)
    if (needed & rule->these && Says(rule->sentence, said)) return PETSC_TRUE;
  return PETSC_FALSE;
}

static int Pair(PetscInt a, PetscInt b, int count[KINDS])
{
  const SlipFaultFeatureSet both = One(a) | One(b), needed = Closure(both, PETSC_FALSE),
                            set = Closure(both, PETSC_TRUE);
  const PetscBool refused = !Consistent(needed) && !Twice(both) ? PETSC_TRUE : PETSC_FALSE;
  const SlipFaultFeatureSet each = Closure(One(a), PETSC_TRUE) | Closure(One(b), PETSC_TRUE);
  /* cells start at once with their rate, within a step that can be no shorter: half a step of an event is not seen */
  const PetscBool jumps = set & SLIP_FEATURE(WAVES) && set & SLIP_FEATURE(RATE_WEAKENING) ? PETSC_TRUE : PETSC_FALSE;
  const char *wrong = NULL;
  Outcome out;

  if (Twice(both) || (!refused && !Consistent(set)) ||
      (both & SLIP_FEATURE(UNDAMPED) && each & SLIP_FEATURE(RADIATION))) {
    count[VOID]++;
    return 0;
  }
  out = Try(refused ? each : set, a, b);
  if (refused && !out.refused) wrong = "was not refused";
  if (refused && out.refused && !SaidByRule(both, needed, out.said)) wrong = "was refused by other words";
  if (!refused && out.refused) wrong = "was refused";
  if (!refused && !out.refused) {
    if ((out.on & both) != both) wrong = "is not on";
    if (!out.complete) wrong = "did not end";
    if (!isfinite(out.largest)) wrong = "is not finite";
    if (!(out.residual < (jumps ? 2 / (PetscReal)out.steps : RESIDUAL))) wrong = "lost energy";
  }
  count[refused ? REFUSED : RUNS]++;
  if (print || wrong)
    fprintf(report, "%s%s | %s | %d events, %d steps, residual %.2g | %s\n",
            wrong     ? wrong
            : refused ? "refused"
                      : "runs",
            wrong ? "!" : "", SlipFaultFeatures[a].name, (int)out.events, (int)out.steps, (double)out.residual,
            SlipFaultFeatures[b].name);
  if (print || wrong) fprintf(report, "  %s\n", out.said);
  return wrong ? 1 : 0;
}

/* Without what a rule says that it needs; what it implies may need something else first */
static int Alone(const SlipFaultRule *rule)
{
  PetscInt f = 0;
  Outcome out;

  while (!(rule->these & One(f))) f++;
  out = Try(One(f) | How[f].implies, f, f);
  for (const SlipFaultRule *r = SlipFaultRules; r->sentence && out.refused; r++)
    if (r->needs && r->these & (rule->these | How[f].implies) && Says(r->sentence, out.said)) return 0;
  fprintf(report, "%s alone: %s\n", SlipFaultFeatures[f].name, out.refused ? out.said : "was not refused");
  return 1;
}

static void pairs(void **state)
{
  const PetscInt grid[] = {2, NZ, NX}, list[] = {2, N};
  char dir[TEMPDIR_LENGTH];
  int count[KINDS] = {0}, wrong = 0;
  FILE *out = PETSC_STDOUT, *err = PETSC_STDERR;
  const int errors = dup(2);
  SlipDevice device;
  const PetscBool present =
    SlipDeviceOpen(PETSC_COMM_SELF, "-fault_device opencl", "", &device) ? PETSC_FALSE : PETSC_TRUE;

  assert_int_equal(0, TempDirMake("features", dir));
  assert_int_equal(0, chdir(dir));
  PETSC_STDOUT = PETSC_STDERR = fopen("/dev/null", "w");
  report = fdopen(errors, "w");
  assert_true(dup2(fileno(PETSC_STDOUT), 2) == 2);
  ok(WriteOwnRecord("record.h5", 3, grid));
  ok(WriteOwnRecord("record_list.h5", 2, list));
  ok(WriteHistory("history.csv"));
  ok(WriteWells());
  ok(WriteRectangles("rectangles.h5", PETSC_FALSE));
  ok(WriteRectangles("planes.h5", PETSC_TRUE));
  ok(WriteTriangles());
  ok(WriteStiffness());
  if (!present) fprintf(report, "%s is skipped: %s\n", SlipFaultFeatures[FEATURE_DEVICE].name, message);
  for (PetscInt a = 0; a < FAULT_NUM_FEATURES; a++) {
    assert_non_null(How[a].own);
    for (PetscInt b = 0; b < a; b++)
      if (present || (a != FEATURE_DEVICE && b != FEATURE_DEVICE)) wrong += Pair(a, b, count);
  }
  for (const SlipFaultRule *rule = SlipFaultRules; rule->sentence; rule++)
    if (rule->needs && (present || !(rule->these & SLIP_FEATURE(DEVICE)))) wrong += Alone(rule);
  ok(PetscOptionsClear(NULL));
  fclose(PETSC_STDOUT);
  PETSC_STDOUT = out;
  PETSC_STDERR = err;
  assert_true(dup2(errors, 2) == 2);
  fclose(report);
  assert_int_equal(0, chdir(".."));
  assert_int_equal(0, TempDirRemove(dir));
  printf("%d pairs run, %d are refused, %d are choices of one thing or idle; %d went wrong\n", count[RUNS],
         count[REFUSED], count[VOID], wrong);
  assert_int_equal(wrong, 0);
}

int main(int argc, char **argv)
{
  const CMUnitTestFunction tests[] = {pairs};

  print = argc > 1 && !strcmp(argv[1], "-pairs") ? PETSC_TRUE : PETSC_FALSE;
  return RunTests(1, argv, 1, tests, (char[]){"pairs"}, NULL, NULL);
}
