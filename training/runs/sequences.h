/* Sequences of events of small faults whose friction weakens with slip, and segments of them: runs from some state through the next
   event (train -train_algorithm cmaes -train_problem sequence). */
#pragma once
#include "common/random.h"
#include "common/table.h"
#include <slipstep.h>

#define SEQUENCE_EVENT_RATE 1e-3 /* an event lasts while a cell is faster [m/s], */
#define SEQUENCE_OVER 10         /* and another one begins only after all were slower than this part of it */

/* What a run has of an event: when it began and when the last cell became slow, and the slip of each cell at the end of the run */
typedef struct {
  Table course;      /* rows of SlipCourseNode, of mean slip and rate */
  PetscInt n;        /* cells */
  PetscInt events;   /* how many began */
  PetscReal begin;   /* of the first, where one began after the start [s] */
  PetscReal over;    /* of the last */
  PetscReal fastest; /* cell of all times [m/s] */
  PetscReal *slip;   /* [n] since the start [m] */
  PetscInt solves, rejected;
  PetscBool good; /* it ended where it was to */
} SegmentRun;

/* From when in a sequence a segment starts */
typedef enum { SEGMENT_AFTER, SEGMENT_BETWEEN, SEGMENT_WITHIN } SegmentKind;

/* All relative: of the onset over the interval between events, of the event's slip in each cell, its moment and duration, and a fifth
   of that of the peak rate. An event that is missed or added counts as 1. */
typedef enum {
  SEGMENT_ERROR_ONSET,
  SEGMENT_ERROR_SLIP,
  SEGMENT_ERROR_MOMENT,
  SEGMENT_ERROR_DURATION,
  SEGMENT_ERROR_PEAK,
  SEGMENT_NUM_ERRORS
} SegmentError;

typedef struct {
  SlipFault fault;
  PetscInt n;         /* cells */
  SegmentKind kind;   /* just after an event, between it and the next, within that */
  Vec start;          /* state */
  PetscReal first;    /* time of the start, */
  PetscReal step;     /* first step, */
  PetscReal end;      /* and where the segment ends [s] */
  PetscReal interval; /* mean time between events [s] */
  PetscReal size;     /* root mean square slip of the event [m] */
  PetscReal mean;     /* and its mean [m] */
  PetscReal duration; /* of the event [s] */
  PetscInt usual;     /* solves of the usual controller */
  SegmentRun reference;
} SegmentEpisode;

/* A fault that is loaded, drawn at random; events: those that pass before the segments */
PETSC_INTERN PetscErrorCode SequenceFaultDraw(Random *random, SlipFault *fault, PetscInt *n, PetscInt *events);

#define SEGMENT_REFERENCE_RTOL 3e-6 /* of pi */
/* The k-th segment of the fault of a seed; draws of faults, and then of segments, are repeated until they have one. */
PETSC_INTERN PetscErrorCode SegmentEpisodeCreate(uint64_t seed, PetscInt k, SegmentEpisode *e);
PETSC_INTERN PetscErrorCode SegmentEpisodeDestroy(SegmentEpisode *e);
/* Under the policy with the dial at accuracy; without one under a classical controller with the tolerance rtol. errors: of the run
   against the reference; error: the largest, a fifth of that of the peak rate; negative: the run did not end */
PETSC_INTERN PetscErrorCode SegmentEpisodeRun(SegmentEpisode *e, SlipPolicy policy, PetscReal accuracy,
                                              TSAdaptType type, PetscReal rtol, PetscInt *solves, PetscInt *rejected,
                                              PetscReal errors[], PetscReal *error);
