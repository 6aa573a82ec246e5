/* main() of the tests that are no cmocka programs: run() on all ranks between PETSc's start and end. */
#pragma once
#include "objects.h"

/* An error of this process with a message, unless it holds */
#define Check(holds, ...) PetscCheck(holds, PETSC_COMM_SELF, PETSC_ERR_PLIB, __VA_ARGS__)

#define SLIP_RANKS(run)                                                                                                \
  int main(int argc, char **argv)                                                                                      \
  {                                                                                                                    \
    return RunOnRanks(argc, argv, run);                                                                                \
  }

/* Returns main()'s exit code; an error on one rank ends all of them. */
static inline int RunOnRanks(int argc, char **argv, PetscErrorCode (*run)(void))
{
  if (PetscInitialize(&argc, &argv, NULL, NULL) || SlipStepInitializePackage()) return 1;
  PetscCallAbort(PETSC_COMM_WORLD, run());
  return PetscFinalize() ? 1 : 0;
}
