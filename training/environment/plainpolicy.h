/* A policy in a run on plain arrays: what it observes, and the step that TSADAPTRL would take. */
#pragma once
#include <slipstep/rooms.h>
#include <slipstep/rooms/slipcore.h>

enum { PLAIN_MAX_ROWS = 64 };

typedef struct {
  SlipPolicy policy;
  SlipModel model; /* whose own observations go first; NULL: a fault, or neither */
  PetscInt n;
  SlipObserved seen[PLAIN_MAX_ROWS];
  PetscReal obs[PLAIN_MAX_ROWS];
  SlipRunNumbers run; /* of the run under way; its loop sets what it knows */
} PlainPolicy;

/* known: every observation can be told without the library's objects and without error estimates. */
PETSC_INTERN PetscErrorCode PlainPolicyStart(SlipPolicy policy, SlipModel model, PlainPolicy *p, PetscBool *known);
/* A run from time 0 to max_time with the dial at accuracy: the bounds of its steps */
PETSC_INTERN PetscErrorCode PlainPolicyRun(PlainPolicy *p, PetscReal accuracy, PetscReal tstar, PetscReal max_time);
/* obs after an attempt: fault's numbers, or the model's state w; changed: no: the state is that of the last time */
PETSC_INTERN void PlainPolicyObserve(PlainPolicy *p, const SlipFaultNumbers *fault, const PetscReal w[],
                                     PetscBool changed);
