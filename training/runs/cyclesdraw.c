/* Small faults of rate-and-state friction, drawn at random. */
#include "runs.h"
#include <slipcompat.h>
#include <math.h>

#define SHEAR 32e9      /* [Pa] */
#define CORE_DEPTH 0.55 /* of the core, over that of the fault */

static const PetscInt Meshes[][2] = {{16, 8}, {20, 10}, {12, 12}, {24, 6}, {1, 48}, {1, 32}};

/* In SI units; the weakening core is surrounded by cells that creep, of which the fault is half. */
typedef struct {
  PetscInt nx, nz;
  double cell, stress, a, b, slip, rim; /* a in the core, that of the rim over b */
} Draw;

/* G d_c/(b sigma): the length over which a rupture front weakens [m] */
static double FrontLength(const Draw *d)
{
  return SHEAR * d->slip / (d->b * d->stress);
}

static void DrawFault(Random *random, Draw *d)
{
  const PetscInt *mesh = Meshes[RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Meshes))];

  d->nx = mesh[0];
  d->nz = mesh[1];
  d->cell = RandomLog(random, 200, 2500);
  d->stress = RandomLog(random, 15e6, 60e6);
  d->b = RandomLog(random, 0.01, 0.03);
  d->a = d->b * (0.13 + 0.4 * RandomUniform(random));
  d->rim = 1.15 + RandomUniform(random);
  d->slip = 1;
  d->slip = RandomLog(random, 2.5, 4.5) * d->cell / FrontLength(d);
}

static PetscErrorCode SetNumbers(const Draw *d, SlipFault fault)
{
  const RunOption rows[] = {{"friction_law", 0, "rate_and_state"},
                            {"length_x", d->nx == 1 ? 1e7 : (double)d->nx * d->cell, NULL},
                            {"shear_modulus", SHEAR, NULL},
                            {"density", 2670, NULL},
                            {"friction_b", d->b, NULL},
                            {"friction_slip", d->slip, NULL},
                            {"loading_rate", 1e-9, NULL}};

  return RunSetOptions(fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows);
}

/* The core reaches from a fifth of the depth to three quarters and over the middle two thirds along strike; a tenth of
   it, at one end, begins ten times faster than the rest. */
static PetscErrorCode SetFields(const Draw *d, SlipFault fault)
{
  const PetscInt n = d->nx * d->nz;
  PetscReal *a, *rate;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &a, n, &rate));
  for (PetscInt i = 0; i < n; i++) {
    const double x = ((double)(i % d->nx) + 0.5) / (double)d->nx - 0.5, z = ((double)(i / d->nx) + 0.5) / (double)d->nz;
    const PetscBool core =
      (d->nx == 1 || fabs(x) < 1.0 / 3) && z > 0.2 && z < 0.2 + CORE_DEPTH ? PETSC_TRUE : PETSC_FALSE;

    a[i] = (PetscReal)(core ? d->a : d->b * d->rim);
    rate[i] = core && (d->nx == 1 ? z > 0.6 : x < -0.2) ? 1e-8 : 1e-9;
  }
  PetscCall(SlipFaultSetField(fault, "friction_a", n, a));
  PetscCall(SlipFaultSetField(fault, "initial_rate", n, rate));
  PetscCall(PetscFree2(a, rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CyclesDraw(RunEpisode *e, Random *random, PetscReal *side)
{
  Draw d;

  PetscFunctionBegin;
  DrawFault(random, &d);
  *side = (PetscReal)(d.cell * (double)PetscMax(d.nx, d.nz));
  PetscCall(RunNewFault(e, d.nx, d.nz, d.cell, d.stress));
  PetscCall(SetNumbers(&d, e->fault));
  PetscCall(SetFields(&d, e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
