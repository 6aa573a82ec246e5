/* Long histories. The time of a TS is one double, which resolves 4 ms after a million years: steps of an event, which
   are as short, would not advance it. A long run therefore counts times from an origin, which moves between steps. The
   TS, its integrator and its problem compute with times of the TS, which stay small, so that their differences are as
   accurate as early in the run. Files and messages have the sum of both. Runs below the limit have the origin 0, which
   never moves. */
#include <slipstep/private/slipbathe.h>

static const char key[] = "SlipClock";

PetscErrorCode SlipClockGet(TS ts, const SlipClock **clock)
{
  static const SlipClock none = {.origin = 0};
  SlipClock *own;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &own));
  *clock = own ? own : &none;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipClockRead(TS ts, PetscReal *time, PetscReal *end)
{
  const SlipClock *clock = NULL;

  PetscFunctionBegin;
  PetscCall(SlipClockGet(ts, &clock));
  if (time) *time = clock->origin + ts->ptime;
  if (end) *end = clock->is_long ? clock->end : ts->max_time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  TSGetSlipOrigin - gets the time of a run at which the time of its TS is zero

  Not collective

  Input Parameter:
. ts - the TS

  Output Parameter:
. origin - the origin [s]; 0 except in long runs

  Level: advanced

  Notes:
  A run of a fault beyond 2^37 s, 4355 years, counts the time of its TS from an origin that moves between steps: add the
  origin to `TSGetTime()`, `TSGetMaxTime()` and the times that monitors and functions of the problem receive. The sum of
  both, as two doubles, is exact to 2.4e-7 s. `SlipFaultOutputFinish()` sets the time of the TS to that of the run
  again. Where the origin cannot move, for reasons on the page of `SlipFaultOutputStart()`, it stays 0.

.seealso: SlipFaultOutputStart()
@*/
PetscErrorCode TSGetSlipOrigin(TS ts, PetscReal *origin)
{
  const SlipClock *clock = NULL;

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscAssertPointer(origin, 2);
  PetscCall(SlipClockGet(ts, &clock));
  *origin = clock->origin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves the origin, and subtracts `by` from all stored times. */
static PetscErrorCode MoveTo(TS ts, SlipClock *clock, PetscReal origin, PetscReal by)
{
  TS_Bathe *ba;

  PetscFunctionBegin;
  clock->origin = origin;
  ts->ptime -= by;
  ts->ptime_prev -= by;
  ts->solvetime -= by;
  if (clock->end < PETSC_MAX_REAL) ts->max_time = clock->end - origin;
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  if (ba) {
    if (ba->failures.barrier < PETSC_MAX_REAL) ba->failures.barrier -= by;
    ba->choice.refused -= by;
    ba->last.time -= by;
  }
  SlipProblemTry(ts, history.origin, origin, by);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves to the latest allowed origin, so that all runs that come to this time by the same steps have equal results. */
static PetscErrorCode Move(TS ts, SlipClock *clock)
{
  const PetscReal units = PetscFloorReal(ts->ptime / SLIP_CLOCK_UNIT);

  PetscFunctionBegin;
  if (clock->is_long && (clock->origin > 0 ? units >= 2 : ts->ptime >= SLIP_CLOCK_LIMIT))
    PetscCall(MoveTo(ts, clock, clock->origin + units * SLIP_CLOCK_UNIT, units * SLIP_CLOCK_UNIT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BeforeStep(TS ts)
{
  SlipClock *clock = NULL;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &clock));
  PetscCall(Move(ts, clock));
  if (clock->prestep) PetscCall((*clock->prestep)(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Own(TS ts, SlipClock **clock)
{
  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, clock));
  if (*clock) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(clock));
  PetscCall(SlipObjectComposeData((PetscObject)ts, key, *clock, SlipContainerDestroyDefault));
  (*clock)->prestep = ts->prestep;
  PetscCall(TSSetPreStep(ts, BeforeStep));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipClockStart(TS ts, PetscBool moves)
{
  SlipClock *clock = NULL;

  PetscFunctionBegin;
  PetscCall(SlipClockStop(ts));
  PetscCall(Own(ts, &clock));
  if (!moves || (ts->max_time <= SLIP_CLOCK_LIMIT && ts->ptime < SLIP_CLOCK_LIMIT)) PetscFunctionReturn(PETSC_SUCCESS);
  clock->is_long = PETSC_TRUE;
  clock->end = ts->max_time;
  PetscCall(Move(ts, clock));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipClockStop(TS ts)
{
  SlipClock *clock = NULL;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, key, &clock));
  if (!clock || !clock->is_long) PetscFunctionReturn(PETSC_SUCCESS);
  if (clock->origin != 0) PetscCall(MoveTo(ts, clock, 0, -clock->origin));
  clock->is_long = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipClockSet(TS ts, PetscReal origin)
{
  SlipClock *clock = NULL;

  PetscFunctionBegin;
  PetscCall(Own(ts, &clock));
  if (!clock->is_long) clock->end = ts->max_time;
  clock->is_long = PETSC_TRUE;
  PetscCall(MoveTo(ts, clock, origin, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}
