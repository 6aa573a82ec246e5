/* Prints when and why a run ended. */
#include <slipstep/rooms/slipts.h>
#include <petsc/private/petscimpl.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <stdio.h>

#define DAYS (2 * 86400) /* seconds from which on a time is also printed in days or years */

/*@C
  SlipReportEnd - prints the last line of a summary: when a run ended and, if that was before its final time, why

  Collective; after TSSolve().

  Input Parameters:
+ ts    - the TS
- state - text that is added about the end, or NULL

  Output Parameter:
. complete - whether the final time was reached

  Level: intermediate

  Note:
  A program whose run is not complete ends with SLIP_EXIT_INCOMPLETE.

.seealso: SlipFaultReportEnd(), SlipOutputFinish()
@*/
PetscErrorCode SlipReportEnd(TS ts, const char state[], PetscBool *complete)
{
  TSConvergedReason reason;
  PetscReal time, end;
  PetscInt steps;
  char why[128] = "", long_time[40] = "", line[256]; /* by C's own printf, since PETSc's %g writes "5." for 5 */

  PetscFunctionBegin;
  PetscValidHeaderSpecific(ts, TS_CLASSID, 1);
  PetscAssertPointer(complete, 3);
  PetscCall(TSGetTime(ts, &time));
  PetscCall(TSGetMaxTime(ts, &end));
  PetscCall(TSGetMaxSteps(ts, &steps));
  PetscCall(TSGetConvergedReason(ts, &reason));
  *complete = time >= end * (1 - 10 * PETSC_MACHINE_EPSILON) ? PETSC_TRUE : PETSC_FALSE; /* 10: sums of steps */
  if (time >= DAYS) {
    SlipTimeText(time, 6, line, sizeof(line));
    (void)snprintf(long_time, sizeof(long_time), " (%.32s)", line);
  }
  if (!*complete) {
    if (reason == TS_CONVERGED_ITS)
      (void)snprintf(why, sizeof(why), "stopped by -ts_max_steps %lld at ", (long long)steps);
    else if (reason == TS_CONVERGED_USER)
      (void)snprintf(why, sizeof(why), "stopped on demand at ");
    else
      (void)snprintf(why, sizeof(why), "stopped (%s) at ", TSConvergedReasons[reason]);
    (void)snprintf(line, sizeof(line), "%st = %g of %g s%s", why, (double)time, (double)end, long_time);
  } else
    (void)snprintf(line, sizeof(line), "t = %g s%s", (double)time, long_time);
  PetscCall(PetscPrintf(PetscObjectComm((PetscObject)ts), "%-24s %s%s%s\n", "end:", line, state && state[0] ? ", " : "",
                        state ? state : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}
