/* Prints the end of a summary of a fault's run, also of one that was stopped. */
#include <slipstep/private/sliprun.h>
#include <stdio.h>

/*@
  SlipFaultReportEnd - prints the last lines of a fault's summary: the scaling of its stiffness, when the run ended and,
  when this was before its final time, why, and whether the fault rests

  Collective; after SlipFaultOutputFinish().

  Input Parameters:
+ fault - the fault
- ts    - the TS that it configured, solved

  Output Parameter:
. complete - whether the final time was reached; a program ends with SLIP_EXIT_INCOMPLETE otherwise

  Level: intermediate

.seealso: SlipReportEnd(), SlipFaultOutputFinish()
@*/
PetscErrorCode SlipFaultReportEnd(SlipFault fault, TS ts, PetscBool *complete)
{
  PetscInt moving = 0;
  const PetscScalar *a;
  char text[128];
  Vec w;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) moving += SlipFaultSpeed(fault, a, i) != 0;
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moving, 1, MPIU_INT, MPI_SUM, fault->comm));
  if (fault->operators.scaling != 1) {
    (void)snprintf(text, sizeof(text), "%.6g", (double)fault->operators.scaling); /* PETSc's %g differs */
    PetscCall(PetscPrintf(fault->comm, "%-24s multiplied by %s (-%sfault_stiffness_scaling mean_slip)\n",
                          "stiffness:", text, SlipFaultPrefix(fault)));
  }
  if (moving)
    PetscCall(PetscSNPrintf(text, sizeof(text), "%" PetscInt_FMT " of %" PetscInt_FMT " cells slide%s", moving,
                            fault->mesh.N,
                            fault->kind.driven ? "" : ": the error of unfinished slip is not estimated"));
  else
    PetscCall(PetscSNPrintf(text, sizeof(text), "all cells rest"));
  PetscCall(SlipReportEnd(ts, text, complete));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultReportStop - prints the summary of a run that was stopped before its end: steps, final mean slip, wall times,
  when and where it ended. Its output stays unfinished

  Collective; after SlipFaultCheckpointFinish() has returned that the run was stopped.

  Input Parameters:
+ fault      - the fault
. ts         - the TS that it configured
. wall_setup - wall time of set-up [s]
- wall_solve - wall time of TSSolve() [s]

  Level: intermediate

.seealso: SlipFaultCheckpointFinish(), SlipFaultReportEnd()
@*/
PetscErrorCode SlipFaultReportStop(SlipFault fault, TS ts, PetscReal wall_setup, PetscReal wall_solve)
{
  SlipFaultObservables obs;
  PetscBool complete;
  SlipOutput run;
  PetscReal t;
  Vec w;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(SlipClockStop(ts));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(SlipFaultGetObservables(fault, t, w, NULL, &obs));
  PetscCall(SlipOutputCreate(ts, NULL, 0, NULL, NULL, NULL, &run));
  PetscCall(SlipOutputAddResult(run, "mean_slip", "mean slip so far", "m", obs.mean_slip));
  PetscCall(SlipOutputAddResult(run, "max_slip_rate", "largest slip rate", "m/s", obs.max_slip_rate));
  PetscCall(SlipOutputFinish(&run, wall_setup, wall_solve));
  PetscCall(SlipFaultReportEnd(fault, ts, &complete));
  PetscFunctionReturn(PETSC_SUCCESS);
}
