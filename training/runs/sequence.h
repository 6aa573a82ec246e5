/* Segments of sequences of events of small faults: runs from some state through the next event (train -train_algorithm
   tolerances -train_problem sequence). */
#pragma once
#include "runs.h"

#define SEQUENCE_REFERENCE_RTOL 3e-6 /* of pi */

/* From when in a sequence a segment starts */
typedef enum { SEGMENT_AFTER, SEGMENT_BETWEEN, SEGMENT_WITHIN } SegmentKind;

/* All relative: of the onset over the interval between events, of the event's slip in each cell, its moment and
   duration, and a fifth of that of the peak rate. An event that is missed or added counts as 1. */
typedef enum {
  SEGMENT_ERROR_ONSET,
  SEGMENT_ERROR_SLIP,
  SEGMENT_ERROR_MOMENT,
  SEGMENT_ERROR_DURATION,
  SEGMENT_ERROR_PEAK,
  SEGMENT_NUM_ERRORS
} SegmentError;

typedef struct {
  RunEpisode base; /* span: the mean time between events [s] */
  Random random;   /* of segments; that of faults is another one */
  PetscBool begun; /* so is this: what follows is drawn once for all faults */
  double of_kind;
  PetscInt pass;    /* events before the segments */
  SegmentKind kind; /* just after an event, between it and the next, within that */
  PetscReal size;   /* root mean square slip of the event [m] */
  PetscReal mean;   /* and its mean [m] */
} SequenceEpisode;
