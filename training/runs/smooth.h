/* Implicit steps through cycles of small rate-and-state faults, with inertia or without, and runs of them (train -train_algorithm cmaes
   -train_problem smooth). */
#pragma once
#include "common/random.h"
#include <slipstep.h>

enum { SMOOTH_EVENTS = 2 }; /* of an episode */

/* An event: when the first cell became fast and the last one slow, and by how much each slipped between */
typedef struct {
  PetscReal begin, over; /* [s] */
  PetscReal *slip;       /* [n] [m] */
} SmoothEvent;

typedef struct {
  PetscInt n, solves, rejected;
  PetscInt events;                      /* that began */
  PetscInt ended;                       /* and ended */
  SmoothEvent event[SMOOTH_EVENTS + 1]; /* one more, which would be spurious */
  PetscBool good;                       /* it ended where it was to */
} SmoothRun;

/* What the error of a run is the largest of, of its events */
typedef struct {
  PetscReal onset;  /* of the time at which one begins, over the recurrence */
  PetscReal slip;   /* root mean square of the cells' slips, relative */
  PetscReal moment; /* relative */
} SmoothErrors;

typedef struct {
  SlipFault fault;
  PetscInt n;
  PetscBool inertia;
  PetscReal end;        /* [s] */
  PetscReal recurrence; /* from one event to the next [s] */
  PetscInt usual;       /* solves of heuristic at 1e-3 */
  SmoothRun reference;
} SmoothEpisode;

#define SMOOTH_REFERENCE_TYPE TSADAPTDSP
#define SMOOTH_REFERENCE_RTOL 1e-5
/* A fault that has SMOOTH_EVENTS events: draws are repeated until one has. */
PETSC_INTERN PetscErrorCode SmoothEpisodeCreate(uint64_t seed, SmoothEpisode *e);
PETSC_INTERN PetscErrorCode SmoothEpisodeDestroy(SmoothEpisode *e);
/* Under the policy with the dial at accuracy; without one under a classical controller with the tolerance rtol. error: the largest of
   errors, 1 where an event is missed or added; negative: the run did not end */
PETSC_INTERN PetscErrorCode SmoothEpisodeRun(SmoothEpisode *e, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                             PetscReal rtol, PetscInt *solves, PetscInt *rejected, SmoothErrors *errors,
                                             PetscReal *error);
