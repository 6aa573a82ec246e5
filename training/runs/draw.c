/* Faults that are drawn: their options and random fields. */
#include "runs.h"
#include <slipcompat.h>
#include <math.h>

#define WAVES 40

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
