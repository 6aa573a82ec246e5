/* Random faults for episodes: ranges as rows of a table, fields that vary in space. */
#include "episodes.h"
#include <math.h>
#include <slipcompat.h>

#define SHEAR_MODULUS 30e9 /* the fault's default [Pa] */
#define DENSITY 2500.      /* likewise [kg/m^3] */

enum { LENGTH, ASPECT, THICKNESS, DAMPING, STRESS, RESIDUAL, DROP, WEAKENING, PERTURBATION, MARGIN, RANGES };

/* All log-uniform. Weakening: what the critical displacement loses of its strength per slip at the start, over its
   stiffness; it sets friction_slip. Below 1.5 nothing slips within a reasonable time. */
static const struct {
  const char *meaning;
  double low, high;
} RangeTable[RANGES] = {
  [LENGTH] = {"length_x [m]", 500, 20e3},
  [ASPECT] = {"length_z over length_x of one cell", 1 / 3., 3},
  [THICKNESS] = {"thickness over length_x", 0.5, 2},
  [DAMPING] = {"damping_ratio", 0.1, 0.6},
  [STRESS] = {"normal_stress [Pa]", 5e6, 150e6},
  [RESIDUAL] = {"friction_residual", 0.2, 0.7},
  [DROP] = {"friction_drop", 0.03, 0.3},
  [WEAKENING] = {"weakening over stiffness", 1.5, 60},
  [PERTURBATION] = {"initial_perturbation", 1e-6, 1e-3},
  [MARGIN] = {"duration over time to rest", 1.2, 3.5},
};
#define DEPTH_GRADIENT 15e3 /* of the normal stress of half the meshes [Pa/m] */
#define SPREAD_MAX 0.4      /* standard deviation of the logarithm of a field */
#define SMOOTH_SHARE 0.25   /* of the meshes: nothing varies but the normal stress with depth */
#define BURIED_SHARE 0.6    /* of the meshes; half as many of the single cells */
#define LINEAR_SHARE 0.25   /* of linear slip weakening */
#define UNSCALED_SHARE 0.5  /* of stiffness as it is */
#define LIMIT 120           /* swings of the critical displacement */

static double Draw(Random *random, int range)
{
  return RandomLog(random, RangeTable[range].low, RangeTable[range].high);
}

/* Zero mean and unit variance over the mesh: waves of up to two periods, and some white noise. */
static void RandomField(Random *random, PetscInt nx, PetscInt nz, double g[])
{
  enum { WAVES = 5 };
  double wave[WAVES][3], mean = 0, variance = 0;
  const double noise = 0.5 * RandomUniform(random);
  const PetscInt n = nx * nz;

  for (int k = 0; k < WAVES; ++k)
    for (int i = 0; i < 3; ++i) wave[k][i] = RandomUniform(random);
  for (PetscInt i = 0; i < n; ++i) {
    const double x = (double)(i % nx) / (double)nx, z = (double)(i / nx) / (double)nz;

    g[i] = noise * sqrt(WAVES / 2.) * RandomNormal(random);
    for (int k = 0; k < WAVES; ++k)
      g[i] += cos(2 * PETSC_PI * (2 * wave[k][0] * x + (4 * wave[k][1] - 2) * z + wave[k][2]));
    mean += g[i] / (double)n;
  }
  for (PetscInt i = 0; i < n; ++i) variance += (g[i] - mean) * (g[i] - mean) / (double)n;
  for (PetscInt i = 0; i < n; ++i) g[i] = variance > 0 ? (g[i] - mean) / sqrt(variance) : 0;
}

static void Set(FaultDraw *d, const char name[], double value)
{
  d->name[d->nreal] = name;
  d->value[d->nreal++] = value;
}

/* Fields of a mesh */
static void DrawFields(Random *random, FaultDraw *d, double depth_top, double cell, double stress, double drop,
                       double residual)
{
  double g[EPISODE_MAX_CELLS];
  const PetscBool deep = RandomUniform(random) < 0.6 ? PETSC_TRUE : PETSC_FALSE;

  const PetscBool smooth = RandomUniform(random) < SMOOTH_SHARE ? PETSC_TRUE : PETSC_FALSE;

  for (PetscInt i = 0; i < d->n; ++i) {
    d->field[0][i] = deep ? DEPTH_GRADIENT * (depth_top + ((double)(i / d->nx) + 0.5) * cell) : stress;
    d->field[1][i] = drop;
    d->field[2][i] = residual;
    d->field[3][i] = 1;
  }
  for (int f = 0; f < DRAW_FIELDS; ++f) {
    double spread = SPREAD_MAX * RandomUniform(random) * (f == 2 ? 0.3 : 1);

    if (RandomUniform(random) < 0.25 || smooth) spread = 0;
    RandomField(random, d->nx, d->nz, g);
    for (PetscInt i = 0; i < d->n; ++i) d->field[f][i] *= exp(spread * g[i]);
  }
}

void FaultDrawAtRandom(Random *random, PetscInt side, FaultDraw *d)
{
  const double length = Draw(random, LENGTH), aspect = Draw(random, ASPECT),
               thickness = length * Draw(random, THICKNESS), damping = Draw(random, DAMPING);
  const double stress = Draw(random, STRESS), residual = Draw(random, RESIDUAL), drop = Draw(random, DROP);
  const double perturbation = Draw(random, PERTURBATION);
  double depth;

  d->nreal = d->nstring = 0;
  d->of_family = PETSC_FALSE;
  d->weakening = Draw(random, WEAKENING);
  d->margin = Draw(random, MARGIN);
  d->limit = LIMIT;
  d->string[0] = "friction_law";
  d->text[0] = RandomUniform(random) < LINEAR_SHARE ? "linear_slip_weakening" : "exponential_slip_weakening";
  d->string[1] = "stiffness_scaling";
  d->text[1] = RandomUniform(random) < UNSCALED_SHARE ? "none" : FAULT_SCALING;
  d->nstring = 2;
  d->nx = side > 1 ? 2 + (PetscInt)RandomIndex(random, (uint64_t)side - 1) : 1;
  d->nz = side > 1 ? 2 + (PetscInt)RandomIndex(random, (uint64_t)side - 1) : 1;
  d->n = d->nx * d->nz;
  depth = RandomUniform(random) < (side > 1 ? BURIED_SHARE : BURIED_SHARE / 2) ? RandomLog(random, 100, 5e3) : 0;
  DrawFields(random, d, depth, length / (double)d->nx, stress, drop, residual);
  if (side == 1) d->field[0][0] = stress, d->field[1][0] = drop, d->field[2][0] = residual, d->field[3][0] = 1;
  Set(d, "nx", (double)d->nx);
  Set(d, "nz", (double)d->nz);
  Set(d, "length_x", length);
  Set(d, "length_z", side > 1 ? length * (double)d->nz / (double)d->nx : length * aspect);
  Set(d, "depth_top", depth);
  Set(d, "thickness", thickness);
  Set(d, "shear_modulus", SHEAR_MODULUS);
  Set(d, "density", DENSITY);
  Set(d, "damping_ratio", damping);
  Set(d, "initial_perturbation", perturbation);
}

/* ---- of a family ---- */

#define FAMILY_LIMIT 500 /* swings: users' faults may be slow */

/* Cells along an edge: as the family says; 1 of a single cell */
static PetscInt FamilyCells(const Family *family, const char name[], Random *random, PetscInt side)
{
  const FamilyLine *line = FamilyFind(family, name);
  const double drawn = line ? (double)FamilyDraw(line, random) : (double)side;

  return side == 1 ? 1 : (PetscInt)PetscClipInterval(floor(drawn + 0.5), 1, (double)side);
}

PetscErrorCode FaultDrawOfFamily(const Family *family, Random *random, PetscInt side, FaultDraw *d)
{
  PetscFunctionBegin;
  d->nreal = d->nstring = 0;
  d->of_family = PETSC_TRUE;
  d->weakening = FamilyNumber(family, "weakening", 0, random);
  d->margin = Draw(random, MARGIN);
  d->limit = FAMILY_LIMIT;
  d->nx = FamilyCells(family, "fault_nx", random, side);
  d->nz = FamilyCells(family, "fault_nz", random, side);
  d->n = d->nx * d->nz;
  for (PetscInt f = 0; f < DRAW_FIELDS; ++f) d->spread[f] = 0;
  for (PetscInt i = 0; i < family->n; ++i) {
    const FamilyLine *line = &family->line[i];
    const char *name = line->name + strlen("fault_");

    if (!strcmp(line->name, "fault_nx") || !strcmp(line->name, "fault_nz") || !strcmp(line->name, "weakening"))
      continue;
    if (!strcmp(line->name, "margin")) {
      d->margin = FamilyDraw(line, random);
    } else if (line->name[0] == 's') {
      for (int f = 0; f < DRAW_FIELDS; ++f)
        if (!strcmp(line->name + strlen("spread_"), EpisodeFieldNames[f])) d->spread[f] = FamilyDraw(line, random);
    } else if (line->nchoices) {
      d->string[d->nstring] = name;
      d->text[d->nstring++] = FamilyChoose(line, random);
    } else
      Set(d, name, (double)FamilyDraw(line, random));
  }
  Set(d, "nx", (double)d->nx);
  Set(d, "nz", (double)d->nz);
  for (int f = 0; f < DRAW_FIELDS; ++f) {
    double g[EPISODE_MAX_CELLS];

    RandomField(random, d->nx, d->nz, g);
    for (PetscInt k = 0; k < d->n; ++k) d->field[f][k] = exp(d->spread[f] * g[k]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
