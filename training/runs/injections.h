/* Small faults that slip under a pore pressure alone, and runs of them (train -train_algorithm cmaes -train_problem injection). */
#pragma once
#include "common/random.h"
#include "common/table.h"
#include <slipstep.h>

/* The course of a run: mean slip and rate, rows of SlipCourseNode, and when each cell began to slip */
typedef struct {
  Table course;
  PetscInt n;
  PetscReal *began;          /* [n] when its slip passed the episode's, negative: it did not [s] */
  PetscReal *slip;           /* [n] final [m] */
  PetscInt solves, rejected; /* steps at rest take no solve */
  PetscBool good;            /* it ended where it was to */
} InjectionRun;

/* What an injection's error is the largest of */
typedef struct {
  PetscReal course; /* Levy distance of mean slip over time, over the final slip and the duration */
  PetscReal field;  /* root mean square of the cells' final slips, relative */
  PetscReal front;  /* that of the times at which cells begin to slip, over the duration */
} InjectionErrors;

typedef struct {
  SlipFault fault;
  PetscInt n;
  PetscReal end;    /* [s] */
  PetscReal passed; /* a cell has begun when it has slipped so far: a hundredth of the final largest slip [m] */
  PetscInt usual;   /* solves of heuristic at 1e-3 */
  PetscBool weakens, inertia;
  InjectionRun reference;
} InjectionEpisode;

/* A fault with its pressure, set up, and how long a run lasts [s]; weakens: friction falls with slip */
PETSC_INTERN PetscErrorCode InjectionFaultDraw(Random *random, SlipFault *fault, PetscInt *n, PetscReal *end,
                                               PetscBool *weakens, PetscBool *inertia);

#define INJECTION_REFERENCE_TYPE TSADAPTHEURISTIC
#define INJECTION_REFERENCE_RTOL 1e-5
/* A fault that slips, of 24 to 192 cells: draws are repeated until one does, and until a second tight run confirms the reference. */
PETSC_INTERN PetscErrorCode InjectionEpisodeCreate(uint64_t seed, InjectionEpisode *e);
PETSC_INTERN PetscErrorCode InjectionEpisodeDestroy(InjectionEpisode *e);
/* Under the policy with the dial at accuracy; without one under a classical controller with the tolerance rtol. error: the largest of
   errors; negative: the run did not end */
PETSC_INTERN PetscErrorCode InjectionEpisodeRun(InjectionEpisode *e, SlipPolicy policy, PetscReal accuracy,
                                                TSAdaptType type, PetscReal rtol, PetscInt *solves, PetscInt *rejected,
                                                InjectionErrors *errors, PetscReal *error);
