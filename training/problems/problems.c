/* The table of problems and what is the same for all of them. */
#include "problems.h"
#include "common/options.h"
#include <slipcompat.h>

const Problem *const ProblemTable[] = {&ProblemFault,     &ProblemDial, &ProblemProducts, &ProblemSlidingMode,
                                       &ProblemCircuit,   &ProblemOde,  &ProblemRupture,  &ProblemSequence,
                                       &ProblemInjection, NULL};

PetscErrorCode ProblemCheckFamily(const Problem *problem, const Family *family)
{
  PetscFunctionBegin;
  PetscCheck(!family || problem->cma->kinds || problem->cma->runs, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-train_family is for faults with an accuracy dial, expected -train_problem fault_dial");
  PetscCheck(!family || !strcmp(family->problem, problem->name), PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-train_family %s describes %s, expected -train_problem %s, or none", family->file, family->describes,
             family->problem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ProblemOption(SlipOptionItems PetscOptionsObject, ProblemUse use, const Problem **row, Family **family)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)] = {NULL};
  const Problem *rows[PETSC_STATIC_ARRAY_LENGTH(ProblemTable)];
  char text[512] = "What is simulated";
  PetscInt n = 0, k = 0;
  PetscBool given;

  PetscFunctionBegin;
  if (family) PetscCall(FamilyOption(PetscOptionsObject, family));
  for (PetscInt i = 0; ProblemTable[i]; ++i) {
    const Problem *p = ProblemTable[i];

    if (use == PROBLEM_BY_STEPS ? !p->create
                                : !p->cma || (use == PROBLEM_BY_RUNS ? !p->cma->setup : !p->cma->classical))
      continue;
    PetscCall(TextAdd(text, sizeof(text), "%s%s, %s", n ? "; " : ": ", p->name, p->meaning));
    rows[n] = p;
    names[n++] = p->name;
  }
  PetscCall(OptionChoice(PetscOptionsObject, "-train_problem", text, names, &k));
  *row = rows[k];
  if (!family || !*family) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsHasName(NULL, NULL, "-train_problem", &given));
  for (PetscInt i = 0; !given && ProblemTable[i]; ++i)
    if (!strcmp((*family)->problem, ProblemTable[i]->name)) *row = ProblemTable[i];
  PetscCheck(use != PROBLEM_BY_RUNS || (*row)->cma->setup, PETSC_COMM_WORLD, PETSC_ERR_SUP,
             "-train_family %s: no policy of the problem %s is trained, as none won; expected ruptures or events from "
             "rest, or -train_algorithm tolerances",
             (*family)->file, (*row)->name);
  PetscCall(ProblemCheckFamily(*row, *family));
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
