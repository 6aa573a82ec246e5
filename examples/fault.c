static const char help[] =
  "Strike-slip fault: slip from a frictional instability, or under loading. All units are SI.\n"
  "  fault -fault_nx 25 -fault_nz 25 -ts_adapt_type heuristic -fault_output run.h5\n"
  "Without options: the 3 km fault of 10 x 10 cells at its instability, for 30 s, with errors of 1e-2 "
  "(-fault_accuracy). Loaded faults take -ts_adapt_type dsp with -ts_rtol 1e-4.\n\n";

#include "sweep.h"
#include <slipstep.h>
#include <petsctime.h>

/* The program's: SLIP_EXIT_INCOMPLETE, or above 128 when a signal or the wall limit has stopped it */
static int exit_code = 0;
enum { MAX_PLANS = 16 };

/* -fault_cells: the cells of the fault of the options, and nothing else */
static PetscErrorCode Cells(const char file[])
{
  SlipFault fault;

  PetscFunctionBeginUser;
  PetscCall(SlipCheckOptionNames());
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(SlipFaultSetReal(fault, "nx", 10));
  PetscCall(SlipFaultSetReal(fault, "nz", 10));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultWriteCells(fault, file));
  PetscCall(SlipFaultDestroy(&fault));
  PetscFunctionReturn(0);
}

/* -fault_plan: what the mesh of the options takes on numbers of processes, and nothing else */
static PetscErrorCode Plan(PetscInt n, const PetscInt size[])
{
  SlipFault fault;

  PetscFunctionBeginUser;
  PetscCall(SlipCheckOptionNames());
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultPlan(fault, n, size, NULL));
  PetscCall(SlipFaultDestroy(&fault));
  PetscFunctionReturn(0);
}

static PetscErrorCode Run(void)
{
  SlipFault fault;
  TS ts;
  Vec w;
  PetscBool only_help, complete;
  int stopped;
  PetscLogDouble begin, ready, end;

  PetscFunctionBeginUser;
  if (exit_code > 128) PetscFunctionReturn(0); /* no further run of a sweep */
  PetscCall(SlipCheckOptionNames());
  PetscCall(PetscLogStagePush(SLIP_STAGE_SETUP));
  PetscCall(PetscTime(&begin));
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(SlipFaultSetReal(fault, "nx", 10));
  PetscCall(SlipFaultSetReal(fault, "nz", 10));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultSetInitialState(fault, w));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(SlipCheckSolverOptions(ts));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscCall(PetscLogStagePop());
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (!only_help) {
    PetscCall(SlipCheckUnusedOptions());
    PetscCall(SlipFaultOutputStart(fault, ts));
    PetscCall(SlipFaultCheckpointStart(fault, ts));
    PetscCall(PetscTime(&ready));
    PetscCall(PetscLogStagePush(SLIP_STAGE_RUN));
    PetscCall(TSSolve(ts, w));
    PetscCall(PetscLogStagePop());
    PetscCall(PetscTime(&end));
    PetscCall(SlipFaultCheckpointFinish(fault, ts, &stopped));
    if (stopped) {
      exit_code = stopped;
      PetscCall(SlipFaultReportStop(fault, ts, ready - begin, end - ready));
    } else {
      PetscCall(SlipFaultOutputFinish(fault, ts, ready - begin, end - ready));
      PetscCall(SlipFaultReportEnd(fault, ts, &complete));
      if (!complete) exit_code = SLIP_EXIT_INCOMPLETE;
    }
    PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscCall(SlipFaultDestroy(&fault));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  char sweep[PETSC_MAX_PATH_LEN] = "", cells[PETSC_MAX_PATH_LEN] = "";
  PetscInt ranks[MAX_PLANS], nranks = MAX_PLANS;
  PetscBool features = PETSC_FALSE, plan = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "fault", help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipSignalsPush());
  PetscCall(SlipDeclareOptions("fault_", "sweep features cells plan"));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Several runs", NULL);
  PetscCall(PetscOptionsBool("-fault_features", "Print what goes with what, and nothing else (default no)",
                             "SlipFaultFeaturesView", features, &features, NULL));
  PetscCall(
    PetscOptionsString("-fault_sweep",
                       "File with a line of options for each of several runs, which write files of their own (default "
                       "none)",
                       NULL, sweep, sweep, sizeof(sweep), NULL));
  PetscCall(PetscOptionsString("-fault_cells",
                               "Write centres [m], area [m^2], strike, dip [degrees] and fault of the cells to a file, "
                               "of which fields of -fault_parameters can be functions, and nothing else (default none)",
                               "SlipFaultWriteCells", cells, cells, sizeof(cells), NULL));
  PetscCall(PetscOptionsIntArray("-fault_plan",
                                 "Print memory, exchange and time of the stiffness of a mesh on these numbers of "
                                 "processes, and nothing else (default none)",
                                 "SlipFaultPlan", ranks, &nranks, &plan));
  PetscOptionsEnd();
  if (features)
    PetscCall(SlipFaultFeaturesView(NULL));
  else if (cells[0])
    PetscCall(Cells(cells));
  else if (plan)
    PetscCall(Plan(nranks, ranks));
  else if (sweep[0])
    PetscCall(Sweep(sweep, Run));
  else
    PetscCall(Run());
  PetscCall(PetscFinalize());
  return exit_code;
}
