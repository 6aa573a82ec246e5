/* The table of algorithms. */
#include "trainer.h"
#include <slipcompat.h>

static const Algorithm AlgorithmTable[] = {
  {"tqc", "truncated quantile critics with state-dependent exploration (Kuznetsov et al. 2020, Raffin et al. 2022)",
   NULL, TrainerTrain},
  {"td3", "twin delayed deep deterministic policy gradient (Fujimoto et al. 2018)", NULL, TrainerTrain},
  {NULL, NULL, NULL, NULL}};

PetscErrorCode AlgorithmFind(const char name[], const Algorithm **row)
{
  char names[256] = "";
  PetscBool same;

  PetscFunctionBegin;
  for (*row = AlgorithmTable; (*row)->name; ++*row) {
    PetscCall(PetscStrcmp(name, (*row)->name, &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(names, (*row)->name, sizeof(names)));
  }
  SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_UNKNOWN_TYPE, "-train_algorithm %s is not known; expected one of:%s cmaes",
          name, names);
}
