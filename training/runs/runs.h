/* Runs of small faults that are drawn at random, under a policy or a classical controller: what all kinds of run share.
   A kind is a row (RunKind): it draws a fault, judges the draw by a reference, follows runs, and says how far off one
   is. Here are the rest: draws until one is good, the run, its cost, and what CMA-ES needs of them. */
#pragma once
#include "common/table.h"
#include "environment/cmaproblem.h"
#include <slipstep/rooms.h>

enum { RUN_EVENTS = 6 }; /* of a run that are kept */

/* A course of slip: rows of SlipCourseNode */
static inline const SlipCourseNode *CourseNodes(const Table *course)
{
  return (const SlipCourseNode *)course->data;
}

/* What a run leaves. A kind fills what it needs. */
typedef struct {
  Table course;                        /* rows of SlipCourseNode, of mean slip and rate */
  PetscReal *slip;                     /* [RunKind.slips][n] final; or what the kind says [m] */
  PetscReal *passed;                   /* [n] when its slip passed the episode's level, negative: it did not [s] */
  PetscInt events;                     /* that began */
  PetscReal begin[RUN_EVENTS];         /* of the events: the first cell becomes fast, */
  PetscReal over[RUN_EVENTS];          /* and the last one slow [s] */
  PetscInt solves, attempts, rejected; /* steps at rest take no solve */
  PetscReal work;                      /* SlipProducts.cost [us], at least 1 */
  PetscBool good;                      /* it ended where it was to */
} RunResult;

/* A drawn fault and its reference. A kind may have a struct of its own that begins with this one. */
typedef struct {
  const RunKind *kind;
  const Family *family; /* a user's, that it is drawn from; NULL: the kind's own draws */
  uint64_t seed;
  PetscInt larger; /* so many times more cells along either side than usual */
  SlipFault fault;
  PetscInt n;            /* cells */
  PetscReal *level;      /* [n] slip at which a cell counts as begun [m]; NULL: none does */
  Vec start;             /* NULL: the fault's initial state at time 0, and its own first step */
  PetscReal begin, step; /* [s] */
  PetscReal end;         /* [s] */
  PetscReal margin;      /* drawn: its duration over the time in which it fades */
  PetscReal span;        /* what errors of times are measured by [s] */
  PetscInt usual, most;  /* solves of the usual controller; steps of a run that is worth ending */
  PetscReal work;        /* of the usual controller */
  RunResult reference;
} RunEpisode;

/* A run under way */
typedef struct {
  RunEpisode *e;
  RunResult *r;
  PetscReal *before;       /* [2 n] slip and rate of each cell at the last step */
  PetscReal last, rate;    /* of the last step: [s], fastest cell [m/s] */
  PetscBool within, armed; /* an event lasts; all cells were slow since the last */
} RunWatch;

/* What a run is to do: under the policy with its dial at the setting, or under a controller of the type with the
   tolerance setting */
typedef struct {
  SlipPolicy policy;
  TSAdaptType type;
  PetscReal setting;
  PetscReal end; /* [s] */
  PetscInt most; /* accepted steps */
} RunRequest;

struct _RunKind {
  size_t size;       /* of an episode */
  TSType type;       /* NULL: as the fault has it */
  PetscInt column;   /* of the state: the slip of cells, whose mean makes the course; 0: there is no course */
  PetscInt slips;    /* of each cell that a run keeps, RunResult.slip */
  PetscBool bounded; /* slip between steps, a cubic, is taken to be monotonous where a level is passed */
  /* A fault, set up, of n cells, and what else of the episode is drawn with it */
  PetscErrorCode (*draw)(RunEpisode *e, Random *random);
  /* Its end, reference and usual solves; good: it is worth learning from */
  PetscErrorCode (*judge)(RunEpisode *e, PetscBool *good);
  /* At the start and after every step, before watch->last and rate become those of now, a [3 n]. NULL: the course is
     enough */
  PetscErrorCode (*follow)(RunWatch *watch, TS ts, PetscInt step, PetscReal t, PetscReal rate, const PetscReal a[]);
  /* errors [SLIP_NUM_ERRORS] of the kind, 1 before, and the largest that counts; negative: the run did not end */
  PetscErrorCode (*compare)(const RunEpisode *e, const RunResult *r, PetscReal errors[], PetscReal *error);
  PetscInt most;        /* steps of classical controllers; 0: the episode's */
  const char *expected; /* of a family: what its faults shall do */
  PetscReal lost;       /* cost of a run that did not end; 0: no policy of the kind is trained, and no run has a cost */
  PetscReal free;       /* errors up to this share of the dial cost nothing, */
  PetscReal steep;      /* larger ones this power of them, */
  PetscReal worst;      /* up to so many times that; the error of a run that did not end */
};

PETSC_INTERN const RunKind RunRupture, RunInjection, RunSequence;

/* ---- runs.c ---- */
PETSC_INTERN PetscErrorCode RunSetController(TS ts, TSAdaptType type, PetscReal rtol); /* a classical one */
/* A controller may drive a run anywhere: an error of the library's is a run that was not solved. */
PETSC_INTERN PetscErrorCode RunSolve(TS ts, Vec w, PetscBool *solved);
/* Of a seed: draws are repeated until one is good */
PETSC_INTERN PetscErrorCode RunEpisodeCreate(const RunKind *kind, const Family *family, PetscInt larger, uint64_t seed,
                                             RunEpisode **e);
PETSC_INTERN PetscErrorCode RunEpisodeDestroy(RunEpisode **e);
PETSC_INTERN PetscErrorCode RunIntegrate(RunEpisode *e, const RunRequest *request, RunResult *r);
PETSC_INTERN PetscErrorCode RunResultDestroy(RunResult *r);
/* What it took and its errors; done 0: it did not end */
PETSC_INTERN PetscErrorCode RunEpisodeRun(RunEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                                          EpisodeResult *result);
/* Root mean square difference of the cells' slips, slip[i stride], relative */
PETSC_INTERN PetscReal RunFieldError(PetscInt n, const PetscReal slip[], PetscInt stride, const PetscReal reference[]);
/* RMS over the cells that passed their level in the reference of the error of the time, over span; a cell that did in
   one of the two alone counts as 1. Cells whose final slip is close to their level are left to the error of the
   field. */
PETSC_INTERN PetscReal RunPassedError(const RunEpisode *e, const RunResult *r, PetscReal span);

/* The functions of a problem's row */
PETSC_INTERN PetscErrorCode RunsCreate(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode);
PETSC_INTERN PetscErrorCode RunsDestroy(void **episode);
/* The cost: logarithm of the work over the usual one, and of what the error is beyond the dial */
PETSC_INTERN PetscErrorCode RunsRun(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *r);
PETSC_INTERN PetscErrorCode RunsClassical(void *episode, TSAdaptType type, PetscReal rtol, EpisodeResult *r);
/* What the rows of these problems have in common */
#define RUNS                                                                                                           \
  .seed = RandomStreamHashed, .first = 1, .start_counts = PETSC_TRUE, .measure = "history", .destroy = RunsDestroy,    \
  .run = RunsRun

/* ---- draw.c ---- */
#define RUN_SHEAR 30e9          /* [Pa] */
#define RUN_CELL_STIFFNESS 1.05 /* of a square cell by itself, over the shear modulus by its side: sqrt(2)/pi 7/3 */
/* A number, or a word: of an option of faults */
typedef struct {
  const char *name;
  double value;
  const char *word; /* "yes" and "no" of switches; NULL: a number */
} RunOption;
PETSC_INTERN PetscErrorCode RunSetOptions(SlipFault fault, size_t n, const RunOption row[]);
/* The episode's fault of nx x nz square cells of a side [m] under a normal stress [Pa], not set up */
PETSC_INTERN PetscErrorCode RunNewFault(RunEpisode *e, PetscInt nx, PetscInt nz, double side, double stress);
/* Random fields of slip weakening, [nx nz] each: drop with a mean, and a standard deviation and correlation [cells];
   and one of mean 0 and variance 1 for the caller. friction_slip follows from weakening, over the stiffness of a cell
   by itself. */
typedef struct {
  double drop, scatter, length, weakening;
} RunWeakening;
PETSC_INTERN PetscErrorCode RunDrawWeakening(Random *random, const RunWeakening *w, PetscInt nx, PetscInt nz,
                                             double side, double stress, SlipFault fault, PetscReal drop[],
                                             PetscReal field[]);
/* A field of mean 0 and variance 1 over all draws: waves of random directions, whose lengths are from one to eight of
   the correlation's [cells]; field [nx nz] */
PETSC_INTERN void RunDrawField(Random *random, PetscInt nx, PetscInt nz, double length, PetscReal field[]);

/* ---- injection.c ---- */
PETSC_INTERN PetscErrorCode InjectionDraw(RunEpisode *e, Random *random);
#define RUN_INJECTION_TYPE TSADAPTHEURISTIC /* of the reference */
#define RUN_INJECTION_RTOL 1e-5
/* ---- familydraw.c: the fault, margin and end of a user's family ---- */
PETSC_INTERN PetscErrorCode RunDrawOfFamily(RunEpisode *e, Random *random);
/* ---- rupture.c ---- */
#define RUN_RUPTURE_RTOL 1e-5 /* of the reference, by pi */
