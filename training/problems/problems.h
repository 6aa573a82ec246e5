/* The table of problems: everything that can be trained on and evaluated, one row each. */
#pragma once
#include "environment/cmaproblem.h"
#include "environment/environment.h"
#include <slipcompat.h>

#define FAULT_SCALING "mean_slip" /* of the stiffness: the study's, by which shipped policies were trained and judged */

PETSC_INTERN const Problem *const ProblemTable[]; /* ends with NULL */
PETSC_INTERN const Problem ProblemFault, ProblemDial, ProblemProducts, ProblemSlidingMode, ProblemCircuit;
PETSC_INTERN const Problem ProblemOde, ProblemCycles, ProblemRupture, ProblemSequence, ProblemInjection,
  ProblemSmooth; /* wings of their own */
PETSC_INTERN const CMAProblem CMAFault, CMASmall, CMAUser;
PETSC_INTERN const Evaluation EvaluationFault, EvaluationSlidingMode, EvaluationCircuit;
/* -train_problem between PetscOptionsBegin() and PetscOptionsEnd(): of those for -train_algorithm cmaes, or of those
   that go step by step */
PETSC_INTERN PetscErrorCode ProblemOption(SlipOptionItems PetscOptionsObject, PetscBool by_cma, const Problem **row);
PETSC_INTERN PetscErrorCode ProblemDescribeDraws(char text[], size_t len); /* all rows of the table */
