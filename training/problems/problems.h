/* The table of problems: everything that can be trained on and evaluated, one row each. */
#pragma once
#include "environment/environment.h"

#define FAULT_SCALING "mean_slip" /* of the stiffness: the study's, by which shipped policies were trained and judged */

PETSC_INTERN const Problem *const ProblemTable[]; /* ends with NULL */
PETSC_INTERN const Problem ProblemFault, ProblemDial, ProblemSlidingMode, ProblemCircuit;
PETSC_INTERN const Evaluation EvaluationFault, EvaluationSlidingMode, EvaluationCircuit;
PETSC_INTERN PetscErrorCode ProblemFind(const char name[], const Problem **row);
PETSC_INTERN PetscErrorCode ProblemDescribeDraws(char text[], size_t len); /* all rows of the table */
PETSC_INTERN const char *ProblemPolicy(const Problem *p);                  /* the problem that its policies are for */
PETSC_INTERN const Preset *ProblemPreset(const Problem *p, const char reward[]);
