/* The table of problems and what is the same for all of them. */
#include "problems.h"
#include "common/options.h"
#include <slipcompat.h>

const Problem *const ProblemTable[] = {&ProblemFault, &ProblemDial, &ProblemSlidingMode, &ProblemCircuit, NULL};

PetscErrorCode ProblemFind(const char name[], const Problem **row)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)] = {NULL};
  PetscInt k;

  PetscFunctionBegin;
  for (PetscInt i = 0; ProblemTable[i]; ++i) names[i] = ProblemTable[i]->name;
  PetscCall(OptionFind("-train_problem", name, names, &k));
  *row = ProblemTable[k];
  PetscFunctionReturn(PETSC_SUCCESS);
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
