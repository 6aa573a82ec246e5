/* The time of a run is the sum of two doubles: the time of its TS, and an origin that moves (src/ts/clock.c). */
#pragma once
#include <petscts.h>

/* The resolution of one double is 1.5e-5 s just before LIMIT, 4355 years. In a run beyond it the origin moves there,
   and then after every other UNIT, 34 years, so that the time of the TS has a resolution of 2.4e-7 s or better.
   Multiples of UNIT are exact doubles, and so are the differences from them. */
#define SLIP_CLOCK_LIMIT 137438953472.0 /* 2^37 s */
#define SLIP_CLOCK_UNIT 1073741824.0    /* 2^30 s */

typedef struct {
  PetscReal origin;              /* time of the run where that of its TS is 0 [s] */
  PetscReal end;                 /* end of the run [s], if is_long */
  PetscBool is_long;             /* the origin may move, because the run exceeds the limit */
  PetscErrorCode (*prestep)(TS); /* another prestep function, called after a move */
} SlipClock;

/* Gets the clock of ts, borrowed and never NULL: without SlipClockStart() its origin stays at 0. */
PETSC_INTERN PetscErrorCode SlipClockGet(TS ts, const SlipClock **clock);
/* Gets the time of the run that ts has reached, and its final time [s], each rounded to a double; both may be NULL. */
PETSC_INTERN PetscErrorCode SlipClockRead(TS ts, PetscReal *time, PetscReal *end);
/* Logically collective. Start, before TSSolve() of a run whose problem has `origin` (SlipHistoryOps): the origin moves
   from now on if moves allows it. Stop, after TSSolve(): the TS has the time of the run again, rounded to a double. */
PETSC_INTERN PetscErrorCode SlipClockStart(TS ts, PetscBool moves);
PETSC_INTERN PetscErrorCode SlipClockStop(TS ts);
/* Sets the origin of a run that continues from a checkpoint, from which its times count. */
PETSC_INTERN PetscErrorCode SlipClockSet(TS ts, PetscReal origin);

/* Returns the rounded sum a + b, and its rounding error in *rest (Knuth 1969). */
static inline PetscReal SlipTwoSum(PetscReal a, PetscReal b, PetscReal *rest)
{
  const PetscReal sum = a + b, part = sum - a, left = sum - part;

  *rest = (a - left) + (b - part);
  return sum;
}
