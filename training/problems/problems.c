/* The table of problems and what is the same for all of them. */
#include "problems.h"
#include "common/options.h"
#include <slipcompat.h>

const Problem *const ProblemTable[] = {&ProblemFault,  &ProblemDial, &ProblemSlidingMode, &ProblemCircuit, &ProblemOde,
                                       &ProblemCycles, NULL};

PetscErrorCode ProblemOption(SlipOptionItems PetscOptionsObject, PetscBool by_cma, const Problem **row)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)] = {NULL};
  const Problem *rows[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)];
  char text[512] = "What is simulated";
  PetscInt n = 0, k = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; ProblemTable[i]; ++i) {
    if (by_cma ? !ProblemTable[i]->cma : !ProblemTable[i]->create) continue;
    PetscCall(PetscStrlcat(text, n ? "; " : ": ", sizeof(text)));
    PetscCall(PetscStrlcat(text, ProblemTable[i]->name, sizeof(text)));
    PetscCall(PetscStrlcat(text, ", ", sizeof(text)));
    PetscCall(PetscStrlcat(text, ProblemTable[i]->meaning, sizeof(text)));
    rows[n] = ProblemTable[i];
    names[n++] = ProblemTable[i]->name;
  }
  PetscCall(OptionChoice(PetscOptionsObject, "-train_problem", text, names, &k));
  *row = rows[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ProblemDescribeDraws(char text[], size_t len)
{
  char row[128];

  PetscFunctionBegin;
  text[0] = 0;
  for (PetscInt k = 0; ProblemTable[k]; ++k) {
    const Problem *p = ProblemTable[k];

    if (!p->ndraw) continue;
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
