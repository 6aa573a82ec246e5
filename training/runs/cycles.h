/* Cycles of events of small rate-and-state faults, and runs of them: what the policy cycles.h5 is trained on (train
   -train_algorithm cmaes -train_problem cycles). */
#pragma once
#include "common/random.h"
#include <slipstep.h>

enum { CYCLE_EVENTS = 5 }; /* of an episode, after those at the start */
#define CYCLE_JUDGED 10    /* the dial bounds the error of this event's time */

typedef struct {
  SlipFault fault;
  PetscReal end;                 /* [s] */
  PetscReal onset[CYCLE_EVENTS]; /* of the reference [s] */
  PetscInt products;             /* of the reference */
  PetscInt usual;                /* of TSADAMS under basic at the fault's default tolerance */
} CycleEpisode;

typedef struct {
  PetscInt products, steps, rejected;
  PetscInt events;
  PetscReal onset[CYCLE_EVENTS + 1]; /* one more, which would be spurious [s] */
  PetscReal error; /* of the time of event CYCLE_JUDGED over the recurrence, as that of these events lets expect */
  PetscBool good;  /* it ended, with the events of the reference */
} CycleResult;

/* A fault that is not set up yet; n: its cells, side: length of the longer side [m], either may be NULL */
PETSC_INTERN PetscErrorCode CycleFaultDraw(Random *random, SlipFault *fault, PetscInt *n, PetscReal *side);
/* A fault that has CYCLE_EVENTS events: draws are repeated until one has. */
PETSC_INTERN PetscErrorCode CycleEpisodeCreate(uint64_t seed, CycleEpisode *e);
PETSC_INTERN PetscErrorCode CycleEpisodeDestroy(CycleEpisode *e);
/* Under the policy with the dial at accuracy; without one, under basic with the tolerance rtol */
PETSC_INTERN PetscErrorCode CycleEpisodeRun(CycleEpisode *e, SlipPolicy policy, PetscReal accuracy, PetscReal rtol,
                                            CycleResult *r);
