/* The observations of a policy in a run on plain arrays. */
#pragma once
#include <slipstep.h>

enum { PLAIN_MAX_ROWS = 64 };

/* Rows of the policy's observations. model: whose own observations go first, NULL: a fault. known: every one can be told
   without the library's objects. */
PETSC_INTERN PetscErrorCode PlainRowsFind(SlipPolicy policy, SlipModel model, PetscInt *n, SlipObserved row[],
                                          PetscBool *known);
