/* Who watches a run of a fault: a row of the table in observers.c each, over a context of its own that no other file knows. */
#pragma once
#include <slipstep/private/slipfault.h>

/* samerun.c: the first part; an error where the checkpoint is of another run */
PETSC_INTERN PetscErrorCode SlipFaultVisitRun(SlipFault fault, SlipState state, TS ts);
PETSC_INTERN PetscErrorCode SlipFaultObserversVisit(SlipFault fault, SlipState state); /* a checkpoint's part */
PETSC_INTERN PetscErrorCode SlipFaultObserversDestroy(SlipFault fault);

/* filenames.c. Collective: the file of an earlier run to go on in, FILE.part or FILE; "": there is none, and a line says so */
PETSC_INTERN PetscErrorCode SlipFaultFindEarlier(SlipFault fault, const char file[], const char what[], PetscBool say,
                                                 char found[PETSC_MAX_PATH_LEN + 8]);

/* stepvalues.c: what several need of the end of a step, computed once for a state w and a time. Collective, borrowed. */
PETSC_INTERN PetscErrorCode SlipFaultStepTraction(SlipFault fault, PetscReal time, Vec w, Vec *traction);
PETSC_INTERN PetscErrorCode SlipFaultStepRate(SlipFault fault, PetscReal time, Vec w, PetscReal *largest);
PETSC_INTERN PetscErrorCode SlipFaultStepValuesDestroy(SlipFault fault);
/* The static traction of any state, weighted by area */
PETSC_INTERN PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r);
