/* Episodes for policies with an accuracy dial: faults drawn at random, single cells and small heterogeneous meshes,
   each with its fine reference, kept ready so that a policy runs through one in a fraction of a millisecond. An episode
   depends on its seed only, not on others or on ranks. Public headers of the library only. */
#pragma once
#include "problems.h"
#include "environment/plainrun.h"
#include "common/random.h"
#include <slipstep.h>

#define EPISODE_MAX_CELLS 144 /* of a drawn mesh, 12 x 12 */

/* A drawn fault: scalar parameters by name, fields by name, both as SlipFaultSetReal() and SlipFaultSetField() take
   them. */
enum { DRAW_MAX_REALS = 16, DRAW_FIELDS = 4 };
typedef struct {
  PetscInt nx, nz, n, nreal;
  const char *name[DRAW_MAX_REALS];
  PetscReal value[DRAW_MAX_REALS];
  PetscReal field[DRAW_FIELDS][EPISODE_MAX_CELLS]; /* meshes only; see EpisodeFieldNames */
  PetscReal margin;                                /* duration over the time at which the reference rests */
  PetscReal limit;                                 /* the reference gives up after this time [T*] */
} FaultDraw;
PETSC_INTERN const char *const EpisodeFieldNames[DRAW_FIELDS];
/* side: largest number of cells along a side, 1: one cell */
PETSC_INTERN void FaultDrawAtRandom(Random *random, PetscInt side, FaultDraw *draw);

/* The reference's course, thinned out. */
typedef struct {
  PetscInt n, capacity;
  PetscReal *t, *slip; /* [n] time [s] and mean slip [m] */
  PetscReal peak;      /* largest mean slip rate [m/s] */
  PetscReal rest;      /* when it came to rest [s]; negative: not yet */
} Course;

typedef struct _EpisodeSmall *EpisodeSmall;

typedef struct {
  EpisodeSmall small; /* another problem than the fault (episodesmall.c); nothing of what follows is used then */
  SlipFault fault;
  TS ts;
  Vec w, start;
  PetscReal tstar, tmax; /* [s] */
  PetscReal slip;        /* mean slip at the end of the reference [m] */
  Course course;         /* of the reference */
  PlainFault plain;      /* the same, without objects */
  double *plain_start;   /* [3 n] */
  /* of the run under way */
  PetscReal history, peak, last_t, last_gap,
    last_slip; /* integral of the slip's distance to the reference's [m s]; largest mean rate [m/s] */
  PetscInt attempts_left;
} Episode;

/* Errors are relative. */
typedef struct {
  PetscInt solves, failures;
  PetscReal slip_error;    /* |final slip / reference - 1| */
  PetscReal history_error; /* mean over time of the slip's distance to the reference's, over the final slip */
  PetscReal rate_error;    /* of the largest mean slip rate, seen at the ends of steps */
  PetscReal done;          /* share of the duration that was reached: 1 when finished */
} EpisodeResult;

/* A run that has not ended after this many accepted steps is cut off. */
#define EPISODE_MAX_STEPS 150

PETSC_INTERN PetscErrorCode EpisodeCreate(uint64_t seed, PetscInt side, Episode **episode);
/* Another problem of the table, an instance drawn at random; slip_error of its runs is the problem's first error. o:
   problem, observations and bounds of the step. */
PETSC_INTERN PetscErrorCode EpisodeCreateSmall(const EnvOptions *o, uint64_t seed, Episode **episode);
PETSC_INTERN PetscErrorCode EpisodeSmallDestroy(EpisodeSmall *small);
PETSC_INTERN PetscErrorCode EpisodeDestroy(Episode **episode);
/* Without objects when that knows what the policy observes, else by the library; the latter always with
   EpisodeRunLibrary(). */
PETSC_INTERN PetscErrorCode EpisodeRun(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result);
PETSC_INTERN PetscErrorCode EpisodeRunLibrary(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result);
/* The same, with an observer of every observation vector [n] of the policy. */
typedef void (*EpisodeWatchFn)(PetscInt n, const PetscReal obs[], void *ctx);
PETSC_INTERN PetscErrorCode EpisodeSmallRun(EpisodeSmall small, SlipPolicy policy, PetscReal accuracy,
                                            EpisodeWatchFn fn, void *ctx, EpisodeResult *result); /* fn: NULL allowed */
PETSC_INTERN PetscErrorCode EpisodeSmallRunLibrary(EpisodeSmall small, SlipPolicy policy, PetscReal accuracy,
                                                   EpisodeWatchFn fn, void *ctx, EpisodeResult *result); /* likewise */
PETSC_INTERN PetscErrorCode EpisodeWatch(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn,
                                         void *ctx);

/* The pieces of a run that is done elsewhere, by the episode's TS: back to the start, at a position of the dial; a
   state after a step to time t; the result. A step may be followed more than once. */
PETSC_INTERN PetscErrorCode EpisodeRewind(Episode *e, PetscReal accuracy);
PETSC_INTERN PetscErrorCode EpisodeFollow(Episode *e, PetscReal t, Vec w);
PETSC_INTERN void EpisodeConclude(const Episode *e, PetscInt solves, PetscInt accepted, EpisodeResult *result);

/* What a run costs: ln(solves) and penalties for errors beyond the dial. */
PETSC_INTERN PetscReal EpisodeCost(const EpisodeResult *r, PetscReal accuracy);
/* 0 below half the dial, 1 at the dial, and growing like its logarithm beyond: x = error over what is allowed. */
PETSC_INTERN PetscReal EpisodePenalty(PetscReal x);
