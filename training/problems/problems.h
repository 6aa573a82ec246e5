/* The table of problems: everything that can be trained on and evaluated, one row each. */
#pragma once
#include "environment/cmaproblem.h"
#include "environment/environment.h"
#include <slipcompat.h>

#define FAULT_SCALING "mean_slip" /* of the stiffness: the study's, by which shipped policies were trained and judged */

PETSC_INTERN const Problem *const ProblemTable[]; /* ends with NULL */
PETSC_INTERN const Problem ProblemFault, ProblemDial, ProblemProducts, ProblemSlidingMode, ProblemCircuit;
PETSC_INTERN const Problem ProblemOde, ProblemRupture, ProblemSequence, ProblemInjection; /* wings of their own */
PETSC_INTERN const CMAProblem CMAFault, CMASmall, CMAUser;
PETSC_INTERN const Evaluation EvaluationFault, EvaluationSlidingMode, EvaluationCircuit;
typedef enum {
  PROBLEM_BY_STEPS, /* a policy is trained step by step */
  PROBLEM_BY_RUNS,  /* a policy is trained by whole runs, -train_algorithm cmaes */
  PROBLEM_CLASSICAL /* runs under classical controllers */
} ProblemUse;
/* -train_problem between PetscOptionsBegin() and PetscOptionsEnd(), of the problems that can be used so; without it the
   problem of -train_family, where family is not NULL: to be freed, NULL without that option */
PETSC_INTERN PetscErrorCode ProblemOption(SlipOptionItems PetscOptionsObject, ProblemUse use, const Problem **row,
                                          Family **family);
/* That the problem draws faults of families, and of this one, which may be NULL */
PETSC_INTERN PetscErrorCode ProblemCheckFamily(const Problem *problem, const Family *family);
PETSC_INTERN PetscErrorCode ProblemDescribeDraws(char text[], size_t len); /* all rows of the table */
