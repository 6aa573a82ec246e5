/* The table of problems and what is the same for all of them. */
#include "problems.h"
#include <slipcompat.h>

const Problem *const ProblemTable[] = {&ProblemFault, &ProblemDial, &ProblemSlidingMode, &ProblemCircuit, NULL};

PetscErrorCode ProblemFind(const char name[], const Problem **row)
{
  char names[256] = "";
  PetscBool same;

  PetscFunctionBegin;
  for (PetscInt i = 0; ProblemTable[i]; ++i) {
    *row = ProblemTable[i];
    PetscCall(PetscStrcmp(name, (*row)->name, &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrlcat(names, " ", sizeof(names)));
    PetscCall(PetscStrlcat(names, (*row)->name, sizeof(names)));
  }
  SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_UNKNOWN_TYPE, "-train_problem %s is not known; expected one of:%s", name,
          names);
}

PetscErrorCode ProblemDescribeDraws(char text[], size_t len)
{
  char row[128];

  PetscFunctionBegin;
  text[0] = 0;
  for (PetscInt k = 0; ProblemTable[k]; ++k) {
    const Problem *p = ProblemTable[k];

    PetscCall(PetscSNPrintf(row, sizeof(row), "%s  %s: ", k ? "\n" : "", p->name));
    PetscCall(PetscStrlcat(text, row, len));
    for (PetscInt i = 0; i < p->ndraw; ++i) {
      PetscCall(PetscSNPrintf(row, sizeof(row), "%s%s %.6g..%.6g", i ? ", " : "", p->draw[i].meaning,
                              (double)p->draw[i].low, (double)p->draw[i].high));
      PetscCall(PetscStrlcat(text, row, len));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const char *ProblemPolicy(const Problem *p)
{
  return p->policy_problem ? p->policy_problem : p->name;
}

const Preset *ProblemPreset(const Problem *p, const char reward[])
{
  const Preset *row = p->presets;

  while (row->reward && strcmp(row->reward, reward)) ++row;
  return row;
}
