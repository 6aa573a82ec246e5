/* The table of problems and what is the same for all of them. */
#include "problems.h"
#include "common/options.h"
#include <slipcompat.h>

const Problem *const ProblemTable[] = {
  &ProblemFault, &ProblemDial,   &ProblemProducts, &ProblemSlidingMode, &ProblemCircuit,
  &ProblemOde,   &ProblemCycles, &ProblemRupture,  &ProblemSequence,    &ProblemInjection,
  NULL};

static PetscBool Fits(const Problem *p, ProblemUse use)
{
  const PetscBool fits[] = {[PROBLEM_BY_STEPS] = p->create ? PETSC_TRUE : PETSC_FALSE,
                            [PROBLEM_BY_RUNS] = p->cma && p->cma->setup ? PETSC_TRUE : PETSC_FALSE,
                            [PROBLEM_CLASSICAL] = p->cma && p->cma->classical ? PETSC_TRUE : PETSC_FALSE};

  return fits[use];
}

PetscErrorCode ProblemOption(SlipOptionItems PetscOptionsObject, ProblemUse use, const Problem **row)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)] = {NULL};
  const Problem *rows[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)];
  char text[512] = "What is simulated";
  PetscInt n = 0, k = 0;

  PetscFunctionBegin;
  for (PetscInt i = 0; ProblemTable[i]; ++i) {
    if (!Fits(ProblemTable[i], use)) continue;
    PetscCall(
      TextAdd(text, sizeof(text), "%s%s, %s", n ? "; " : ": ", ProblemTable[i]->name, ProblemTable[i]->meaning));
    rows[n] = ProblemTable[i];
    names[n++] = ProblemTable[i]->name;
  }
  PetscCall(OptionChoice(PetscOptionsObject, "-train_problem", text, names, &k));
  *row = rows[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ProblemDescribeDraws(char text[], size_t len)
{
  PetscFunctionBegin;
  text[0] = 0;
  for (PetscInt k = 0; ProblemTable[k]; ++k) {
    const Problem *p = ProblemTable[k];

    if (!p->ndraw) continue;
    PetscCall(TextAdd(text, len, "%s  %s: ", k ? "\n" : "", p->name));
    for (PetscInt i = 0; i < p->ndraw; ++i)
      PetscCall(TextAdd(text, len, "%s%s %.6g..%.6g", i ? ", " : "", p->draw[i].meaning, (double)p->draw[i].low,
                        (double)p->draw[i].high));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
