/* Faults that are drawn: their options and random fields. */
#include "runs.h"
#include <slipcompat.h>
#include <math.h>

#define WAVES 40
#define LEAST 0.1 /* of a field, over its mean */

PetscErrorCode RunSetOptions(SlipFault fault, size_t n, const RunOption row[])
{
  PetscFunctionBegin;
  for (size_t i = 0; i < n; i++) {
    if (row[i].word)
      PetscCall(FamilySetWord(fault, row[i].name, row[i].word));
    else
      PetscCall(SlipFaultSetReal(fault, row[i].name, (PetscReal)row[i].value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void RunDrawField(Random *random, PetscInt nx, PetscInt nz, double length, PetscReal field[])
{
  const PetscInt n = nx * nz;

  for (PetscInt i = 0; i < n; i++) field[i] = 0;
  for (PetscInt k = 0; k < WAVES; k++) {
    const double angle = 2 * PETSC_PI * RandomUniform(random), phase = 2 * PETSC_PI * RandomUniform(random);
    const double number = 2 * PETSC_PI / (length * RandomLog(random, 1, 8));
    const double x = number * cos(angle), z = number * sin(angle);

    for (PetscInt i = 0; i < n; i++)
      field[i] +=
        (PetscReal)(sqrt(2.0 / WAVES) * cos(x * ((double)(i % nx) + 0.5) + z * ((double)(i / nx) + 0.5) + phase));
  }
}

PetscErrorCode RunNewFault(RunEpisode *e, PetscInt nx, PetscInt nz, double side, double stress)
{
  const RunOption rows[] = {{"nx", (double)nx, NULL},
                            {"nz", (double)nz, NULL},
                            {"length_x", (double)nx * side, NULL},
                            {"length_z", (double)nz * side, NULL},
                            {"shear_modulus", RUN_SHEAR, NULL},
                            {"normal_stress", stress, NULL},
                            {"normal_stress_gradient", 0, NULL}};

  PetscFunctionBegin;
  e->n = nx * nz;
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &e->fault));
  PetscCall(RunSetOptions(e->fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RunDrawWeakening(Random *random, const RunWeakening *w, PetscInt nx, PetscInt nz, double side,
                                double stress, SlipFault fault, PetscReal drop[], PetscReal field[])
{
  const PetscInt n = nx * nz;
  PetscReal *weaken;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &weaken));
  RunDrawField(random, nx, nz, w->length, drop);
  RunDrawField(random, nx, nz, w->length, field);
  for (PetscInt i = 0; i < n; i++) {
    drop[i] = (PetscReal)(w->drop * PetscMax(1 + w->scatter * (double)drop[i], LEAST));
    weaken[i] = (PetscReal)((double)drop[i] * stress * side / (w->weakening * RUN_CELL_STIFFNESS * RUN_SHEAR));
  }
  PetscCall(SlipFaultSetField(fault, "friction_drop", n, drop));
  PetscCall(SlipFaultSetField(fault, "friction_slip", n, weaken));
  PetscCall(PetscFree(weaken));
  PetscFunctionReturn(PETSC_SUCCESS);
}
