/* Small faults that are loaded, weaken with slip and heal, drawn at random. */
#include "sequence.h"
#include <slipcompat.h>

#define RESIDUAL 0.5 /* friction after all weakening */
#define FULL 0.97    /* the stress at the start is at most this share of the strength */
#define LEAST 0.1    /* of a field, over its mean */

static const PetscInt Meshes[][2] = {{1, 1}, {4, 3}, {6, 3}, {8, 4}, {10, 5}, {12, 6}, {16, 8}};
static const double Chances[] = {0.15, 0.2, 0.2, 0.15, 0.1, 0.1, 0.1}; /* of these */

typedef struct {
  PetscInt nx, nz;
  double side, stress; /* [m], [Pa] */
  RunWeakening weakening;
  double share;     /* of the drop, at the start */
  double rate;      /* of loading [m/s] */
  double healing;   /* time, over that in which loading makes up for the drop; 0: never */
  double thickness; /* [m] */
  PetscBool inertia, linear, by_stress, half_space;
} Draw;

static void DrawMesh(Random *random, Draw *d)
{
  double chance = RandomUniform(random);
  size_t k = 0;

  while (k + 1 < PETSC_STATIC_ARRAY_LENGTH(Meshes) && chance >= Chances[k]) chance -= Chances[k++];
  d->nx = Meshes[k][0];
  d->nz = Meshes[k][1];
}

static void DrawFault(Random *random, Draw *d)
{
  DrawMesh(random, d);
  d->side = RandomLog(random, 300, 3000);
  d->stress = RandomLog(random, 15e6, 100e6);
  d->weakening.drop = RandomLog(random, 0.05, 0.2);
  d->weakening.weakening = RandomLog(random, 0.5, 4);
  if (d->nx == 1) d->weakening.weakening = RandomLog(random, 1.3, 4); /* it is stable otherwise */
  d->weakening.scatter = RandomUniform(random) < 0.2 ? 0 : 0.3 * RandomUniform(random);
  d->weakening.length = RandomLog(random, 1, 6);
  d->share = 0.3 + 0.6 * RandomUniform(random);
  d->rate = RandomLog(random, 1e-10, 1e-8);
  d->healing = RandomUniform(random) < 0.1 ? 0 : RandomLog(random, 0.003, 0.3);
  d->thickness = RandomLog(random, 0.3, 1) * d->side * (double)PetscMax(d->nx, d->nz);
  d->linear = RandomUniform(random) < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  d->by_stress = RandomUniform(random) < 0.2 ? PETSC_TRUE : PETSC_FALSE;
  d->half_space = RandomUniform(random) < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  d->inertia = RandomUniform(random) < 0.25 ? PETSC_TRUE : PETSC_FALSE;
}

/* The rate at which loading stresses a cell by itself [Pa/s] */
static double StressingRate(const Draw *d)
{
  return RUN_CELL_STIFFNESS * RUN_SHEAR / (d->side * (double)PetscMin(d->nx, d->nz)) * d->rate;
}

static PetscErrorCode SetNumbers(const Draw *d, SlipFault fault)
{
  const double recurrence = d->weakening.drop * d->stress / StressingRate(d);
  const RunOption rows[] = {{"thickness", d->thickness, NULL},
                            {"friction_residual", RESIDUAL, NULL},
                            {"loading_rate", d->by_stress ? 0 : d->rate, NULL},
                            {"stressing_rate", d->by_stress ? StressingRate(d) : 0, NULL},
                            {"healing_time", d->healing * recurrence, NULL},
                            {"initial", 0, "traction"},
                            {"viscosity", 0, "radiation"},
                            {"kernel", 0, d->half_space ? "half_space" : "full_space"},
                            {"friction_law", 0, d->linear ? "linear_slip_weakening" : "exponential_slip_weakening"},
                            {"inertia", 0, d->inertia ? "yes" : "no"}};

  return RunSetOptions(fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows);
}

static PetscErrorCode SetFields(Random *random, const Draw *d, SlipFault fault)
{
  const PetscInt n = d->nx * d->nz;
  PetscReal *drop, *stress;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &drop, n, &stress));
  PetscCall(RunDrawWeakening(random, &d->weakening, d->nx, d->nz, d->side, d->stress, fault, drop, stress));
  for (PetscInt i = 0; i < n; i++) {
    stress[i] = (PetscReal)(d->share * PetscMax(1 + d->weakening.scatter * (double)stress[i], LEAST));
    stress[i] = (PetscReal)d->stress * (RESIDUAL + stress[i] * drop[i]);
    stress[i] = PetscMin(stress[i], (PetscReal)(FULL * d->stress) * (RESIDUAL + drop[i]));
  }
  PetscCall(SlipFaultSetField(fault, "initial_traction", n, stress));
  PetscCall(PetscFree2(drop, stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SequenceDraw(RunEpisode *e, Random *random)
{
  Draw d;

  PetscFunctionBegin;
  DrawFault(random, &d);
  ((SequenceEpisode *)e)->pass = d.healing > 0 ? 1 + (PetscInt)RandomIndex(random, SEQUENCE_MOST_PASS) : 0;
  PetscCall(RunNewFault(e, d.nx, d.nz, d.side, d.stress));
  PetscCall(SetNumbers(&d, e->fault));
  PetscCall(SetFields(random, &d, e->fault));
  PetscCall(SlipFaultSetUp(e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
