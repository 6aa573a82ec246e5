/* The time of a run as the sum of two doubles: that of its TS, and an origin that moves (src/ts/clock.c). */
#pragma once
#include <petscts.h>

/* One double tells times apart by 1.5e-5 s just before LIMIT, 4355 years. A run that goes on beyond it has its origin
   moved there, and from then on after every other UNIT, 34 years, so that the time of the TS is known to 2.4e-7 s or
   better. Multiples of UNIT are exact doubles, and so are the differences from them. */
#define SLIP_CLOCK_LIMIT 137438953472.0 /* 2^37 s */
#define SLIP_CLOCK_UNIT 1073741824.0    /* 2^30 s */

typedef struct {
  PetscReal origin;              /* time of the run where that of its TS is 0 [s] */
  PetscReal end;                 /* of the run [s]; of use where is_long */
  PetscBool is_long;             /* the origin may move: the run goes on beyond the limit */
  PetscErrorCode (*prestep)(TS); /* of others, called after a move */
} SlipClock;

/* That of ts, borrowed while it lives; never NULL: one whose origin stays at 0 where none was started */
PETSC_INTERN PetscErrorCode SlipClockGet(TS ts, const SlipClock **clock);
/* The time of the run that ts has reached, and its final time [s], each rounded to one double; either may be NULL */
PETSC_INTERN PetscErrorCode SlipClockRead(TS ts, PetscReal *time, PetscReal *end);
/* Logically collective. Before TSSolve() of a run whose problem has `origin` (SlipProblemOps): from here on it moves
   where moves says that it may. After it: the TS has the time of the run again, rounded to one double. */
PETSC_INTERN PetscErrorCode SlipClockStart(TS ts, PetscBool moves);
PETSC_INTERN PetscErrorCode SlipClockStop(TS ts);
/* The origin that a run goes on with, from a checkpoint, whose times count from it */
PETSC_INTERN PetscErrorCode SlipClockSet(TS ts, PetscReal origin);

/* a + b = the sum returned + *rest, exactly (Knuth 1969) */
static inline PetscReal SlipTwoSum(PetscReal a, PetscReal b, PetscReal *rest)
{
  const PetscReal sum = a + b, part = sum - a, left = sum - part;

  *rest = (a - left) + (b - part);
  return sum;
}
