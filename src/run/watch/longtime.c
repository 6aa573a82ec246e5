/* Decides whether the origin of time may move in runs of thousands of years (src/ts/clock.c). */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipsys.h>

/*
  SlipFaultClockStart - lets the origin of a long run's time move, or warns why it cannot

  Collective; before the observers of the run, which store times.
*/
PetscErrorCode SlipFaultClockStart(SlipFault fault, TS ts)
{
  const char *what = NULL;
  PetscReal end;
  PetscMPIInt rank;
  char limit[32], last[32];
  PetscBool known, history, rests;
  TSAdapt adapt;

  PetscFunctionBegin;
  fault->loads.origin = 0; /* an earlier run may have failed */
  /* what uses absolute times other than through ts, so that the origin cannot move; NULL: it can */
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, &known, TSBATHE, TSMOREAU, TSADAMS, TSRKC, TSRK, TSLAPUSTA, ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTHISTORY, &history));
  PetscCall(SlipElasticRests(fault->medium, &rests));
  what = fault->loads.pressed                                  ? "a pore pressure, which is of absolute times"
         : !rests                                              ? "a medium whose stress is of absolute times"
         : fault->options.check_error                          ? "-fault_check_error"
         : !known                                              ? "this -ts_type"
         : history || ts->event || ts->trajectory || ts->tspan ? "events, trajectories and given times of the TS"
                                                               : NULL;
  PetscCall(SlipClockStart(ts, what ? PETSC_FALSE : PETSC_TRUE));
  PetscCall(SlipClockRead(ts, NULL, &end));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!what || rank || !fault->options.reports || end <= SLIP_CLOCK_LIMIT || end >= PETSC_MAX_REAL)
    PetscFunctionReturn(PETSC_SUCCESS);
  SlipTimeText((PetscReal)SLIP_CLOCK_LIMIT, 4, limit, sizeof(limit));
  SlipTimeText(end, 4, last, sizeof(last));
  PetscCall(
    SlipWarning("time is one double in this run, as its origin cannot move with %s: at its end, %s, a step below "
                "%.2g s is lost, and ends it by an error. Expected an end before %s, or steps that stay longer",
                what, last, (double)(PETSC_MACHINE_EPSILON * end), limit));
  PetscFunctionReturn(PETSC_SUCCESS);
}
