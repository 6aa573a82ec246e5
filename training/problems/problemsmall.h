/* Small models as plain arrays. */
#pragma once
#include "problems.h"
#include "environment/plainsmall.h"

/* The system of a run of such a problem, whose model must live as long */
PETSC_INTERN PetscErrorCode ProblemSmallPlain(const EnvRun *run, PlainSmall *p);
