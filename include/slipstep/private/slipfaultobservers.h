/* Who watches a run of a fault: a row of the table in observers.c each, over a context of its own that no other file knows. */
#pragma once
#include <slipstep/private/slipfault.h>

/* Before TSSolve(), after SlipFaultSetUp(): contexts of all that have something to do in this run, and their monitor */
PETSC_INTERN PetscErrorCode SlipFaultObserversCreate(SlipFault fault, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultObserversLayout(SlipFault fault, SlipOutput output); /* while the file is made */
PETSC_INTERN PetscErrorCode SlipFaultObserversVisit(SlipFault fault, SlipState state);    /* a checkpoint's part */
PETSC_INTERN PetscErrorCode SlipFaultObserversFinish(SlipFault fault, TS ts, SlipOutput output);
PETSC_INTERN PetscErrorCode SlipFaultObserversDestroy(SlipFault fault); /* at the end of a run, or of one that failed */

/* stepvalues.c: what several need of the end of a step, computed once for a state w and a time. Collective, borrowed. */
PETSC_INTERN PetscErrorCode SlipFaultStepTraction(SlipFault fault, PetscReal time, Vec w, Vec *traction);
PETSC_INTERN PetscErrorCode SlipFaultStepRate(SlipFault fault, PetscReal time, Vec w, PetscReal *largest);
PETSC_INTERN PetscErrorCode SlipFaultStepValuesDestroy(SlipFault fault);
/* The static traction of any state, weighted by area */
PETSC_INTERN PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r);
