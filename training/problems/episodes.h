/* Episodes for policies with an accuracy dial: faults drawn at random, single cells and small heterogeneous meshes,
   each with its fine reference, kept ready so that a policy runs through one in a fraction of a millisecond. An episode
   depends on its seed only, not on others or on ranks. Public headers of the library only. */
#pragma once
#include "problems.h"
#include "environment/plainfault.h"
#include "runs/runs.h"
#include <slipstep/rooms.h>

#define EPISODE_MAX_CELLS 144 /* of a drawn mesh, 12 x 12 */

/* A drawn fault: scalar parameters by name, fields by name, both as SlipFaultSetReal() and SlipFaultSetField() take
   them. */
enum { DRAW_MAX_REALS = FAMILY_MAX_LINES + 2, DRAW_MAX_STRINGS = FAMILY_MAX_LINES };
typedef struct {
  PetscInt nx, nz, n, nreal;
  const char *name[DRAW_MAX_REALS];
  PetscReal value[DRAW_MAX_REALS];
  PetscInt nstring;
  const char *string[DRAW_MAX_STRINGS], *text[DRAW_MAX_STRINGS]; /* names and values */
  PetscReal spread[DRAW_FIELDS]; /* of a family: standard deviation of the fields' logarithms */
  PetscReal
    field[DRAW_FIELDS]
         [EPISODE_MAX_CELLS]; /* see EpisodeFieldNames; of a family relative to the scalar, and friction_slip always */
  PetscReal
    weakening; /* at the start over the stiffness, both of the critical displacement: gives friction_slip. 0: of a
                            family, which has friction_slip itself */
  PetscBool of_family;
  PetscReal margin; /* duration over the time at which the reference rests */
  PetscReal limit;  /* the reference gives up after this time, over that of the critical displacement's swing */
} FaultDraw;
/* side: largest number of cells along a side, 1: one cell */
PETSC_INTERN void FaultDrawAtRandom(Random *random, PetscInt side, FaultDraw *draw);
/* As a user's file says; draw borrows its texts. side: at most so many cells along an edge, 1: one cell */
PETSC_INTERN PetscErrorCode FaultDrawOfFamily(const Family *family, Random *random, PetscInt side, FaultDraw *draw);

enum { COURSE_WIDTH = 3 };

/* Of a drawn fault; a user's problem has user and instance, ts, w and times in place of a fault */
typedef struct {
  const SlipTrainProblem *user;
  void *instance;
  PetscReal begin;   /* time of the start [s] */
  PetscInt failures; /* of its solves in a row, in the run under way */
  SlipFault fault;
  TS ts;
  Vec w, start;
  PetscReal tstar, tmax; /* [s] */
  PetscReal slip;        /* mean slip at the end of the reference [m] */
  Table reference;       /* its course, thinned out */
  PetscReal *field;      /* its final slip [n] [m] */
  PetscReal rest;        /* when it came to rest [s]; negative: not yet */
  PlainFault plain;      /* the same, without objects */
  double *plain_start;   /* [3 n] */
  /* of runs whose steps may be explicit: EpisodeCreateProducts() */
  SlipMethodCosts costs;
  PetscReal omega, fineness; /* the largest frequency [1/s], and by what that of a finer mesh exceeds it */
  /* of the run under way */
  Table run;             /* its course */
  PetscReal field_error; /* of its final slip; 0 until its end */
  PetscInt attempts_left;
  const SlipMeasure *measure; /* of EpisodeResult.error */
} Episode;

/* A run that has not ended after this many accepted steps is cut off. */
#define EPISODE_MAX_STEPS 400
#define EPISODE_MAX_EXPLICIT 4000 /* where steps may be explicit */

/* family: NULL for the draws above */
PETSC_INTERN PetscErrorCode EpisodeCreate(const Family *family, uint64_t seed, PetscInt side, Episode **episode);
/* Of these, and what its steps cost */
PETSC_INTERN PetscErrorCode EpisodeCreateProducts(const Family *family, uint64_t seed, PetscInt side,
                                                  Episode **episode);
PETSC_INTERN PetscErrorCode EpisodeDestroy(void **episode); /* Episode * */
/* Without objects when that knows what the policy observes, else by the library; the latter always with
   EpisodeRunLibrary(). */
PETSC_INTERN PetscErrorCode EpisodeRun(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result);
/* Of EpisodeCreateProducts(), without objects: steps are explicit where that takes fewer products, the result's solves
   are products */
PETSC_INTERN PetscErrorCode EpisodeRunProducts(void *episode, SlipPolicy policy, PetscReal accuracy,
                                               EpisodeResult *result);
PETSC_INTERN PetscErrorCode EpisodeRunLibrary(Episode *e, SlipPolicy policy, PetscReal accuracy, EpisodeResult *result);
/* The latter without its result: what the TS took; a user's problem too */
PETSC_INTERN PetscErrorCode EpisodeSolve(Episode *e, SlipPolicy policy, PetscReal accuracy, PetscInt *accepted,
                                         PetscInt *solves);
/* By the library under a classical controller in place of a policy, see CMAProblem */
PETSC_INTERN PetscErrorCode EpisodeRunClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *result);
/* By the library, with an observer of every observation vector of the policy; a user's problem too */
PETSC_INTERN PetscErrorCode EpisodeWatch(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn,
                                         void *ctx);

/* The pieces of a run that is done elsewhere, by the episode's TS: back to the start, at a position of the dial; a
   state after a step to time t; the result. A step may be followed more than once. */
PETSC_INTERN PetscErrorCode EpisodeRewind(Episode *e, PetscReal accuracy);
PETSC_INTERN PetscErrorCode EpisodeFollow(Episode *e, PetscReal t, Vec w);
/* Without a cost */
PETSC_INTERN void EpisodeConclude(const Episode *e, PetscInt solves, PetscInt accepted, EpisodeResult *result);

/* What a run costs: ln(solves) and penalties for errors beyond the dial. */
PETSC_INTERN PetscReal EpisodeCost(const EpisodeResult *r, PetscReal accuracy);
/* 0 below half the dial, 1 at the dial, and growing like its logarithm beyond: x = error over what is allowed. */
PETSC_INTERN PetscReal EpisodePenalty(PetscReal x);

/* ---- small models of the table (episodesmall.c); the error of a run is the problem's first one ---- */
typedef struct _EpisodeSmall *EpisodeSmall;
/* o: problem, observations and bounds of the step */
PETSC_INTERN PetscErrorCode EpisodeSmallCreate(const EnvOptions *o, uint64_t seed, EpisodeSmall *episode);
PETSC_INTERN PetscErrorCode EpisodeSmallDestroy(void **episode); /* EpisodeSmall * */
/* Without objects when that knows what the policy observes, else by the library; the latter always with
   EpisodeSmallRunLibrary(). fn: NULL allowed */
PETSC_INTERN PetscErrorCode EpisodeSmallRun(EpisodeSmall e, SlipPolicy policy, PetscReal accuracy, EpisodeWatchFn fn,
                                            void *ctx, EpisodeResult *result);
PETSC_INTERN PetscErrorCode EpisodeSmallRunLibrary(EpisodeSmall e, SlipPolicy policy, PetscReal accuracy,
                                                   EpisodeWatchFn fn, void *ctx, EpisodeResult *result);

/* ---- policies with an accuracy dial, of these and of users' problems (episodeuser.c): dialnetwork.c ---- */
PETSC_INTERN void DialStart(const CMAOptions *o, double w[]);
PETSC_INTERN PetscErrorCode DialPolicy(const CMAOptions *o, const double w[], SlipPolicy policy);
PETSC_INTERN PetscErrorCode DialSay(const CMAScore *score, char text[], size_t len);

/* What their rows share: of the problem, and of its defaults */
#define CMA_DIAL                                                                                                       \
  .episodes = "episodes", .seed = RandomStream, .stream = 1, .dial = CMA_DIAL_SPREAD, .start = DialStart,              \
  .policy = DialPolicy, .say = DialSay
#define CMA_DIAL_DEFAULTS                                                                                              \
  .layers = 1, .activation = SLIP_ACTIVATION_TANH, .side = 7, .sigma = 0.1, .high = TSADAPTRL_ACCURACY_MAX,            \
  .within = 0.97
