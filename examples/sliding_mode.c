static const char help[] =
  "First-order sliding mode controller dw/dt = D sin(omega t) + F_r, F_r in -k Sign(w).\n"
  "  sliding_mode -ts_adapt_type pi -sliding_mode_output run.h5\n"
  "Defaults: the evaluation setting, 0.5 s (-ts_max_time), steps from 1e-9 s to 2 pi/(10 omega) "
  "(-ts_adapt_dt_min, -ts_adapt_dt_max),\n-ts_rtol 1e-3, -ts_atol 1e-6, -ts_adapt_type heuristic.\n\n";

#include "sliding_mode.h"
#include <petsctime.h>

/* Error of the accepted steps against the exact solution. */
typedef struct {
  SlidingMode model;
  PetscReal time, square; /* of the last step, and its squared error */
  PetscReal integral;     /* of the squared error over time, trapezoidal rule [s] */
  PetscReal largest;
} Run;

static PetscErrorCode First(Vec x, PetscReal *value)
{
  const PetscScalar *a;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &a));
  *value = a[0];
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscFunctionReturn(0);
}

/* TSMonitor */
static PetscErrorCode MeasureError(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Run *run = (Run *)ctx;
  PetscReal value = 0, reaction, square;

  PetscFunctionBeginUser;
  (void)ts;
  if (step < 0) PetscFunctionReturn(0); /* the final time once more */
  PetscCall(First(w, &value));
  square = PetscSqr(value - SlidingModeExact(&run->model, time, &reaction));
  run->integral += 0.5 * (time - run->time) * (run->square + square);
  run->largest = PetscMax(run->largest, PetscSqrtReal(square));
  run->time = time;
  run->square = square;
  PetscFunctionReturn(0);
}

static const SlipOutputColumn columns[] = {{"w", "1", PETSC_FALSE},
                                           {"reaction", "1/s", PETSC_FALSE},
                                           {"energy", "1", PETSC_FALSE},
                                           {"exact", "1", PETSC_FALSE},
                                           {"exact_reaction", "1/s", PETSC_FALSE}};

static PetscErrorCode Row(TS ts, PetscReal time, Vec w, Vec r, PetscReal row[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)ts;
  PetscCall(First(w, &row[0]));
  PetscCall(First(r, &row[1]));
  row[2] = 0.5 * PetscSqr(row[0]);
  row[3] = SlidingModeExact(&((Run *)ctx)->model, time, &row[4]);
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(TS ts, Vec w, Run *run, const char file[], PetscLogDouble begin)
{
  SlipOutput output;
  PetscLogDouble ready, end;
  PetscReal final = 0;

  PetscFunctionBeginUser;
  PetscCall(SlipOutputCreate(ts, file, PETSC_STATIC_ARRAY_LENGTH(columns), columns, Row, run, &output));
  PetscCall(TSMonitorSet(ts, MeasureError, run, NULL));
  PetscCall(PetscTime(&ready));
  PetscCall(TSSolve(ts, w));
  PetscCall(PetscTime(&end));
  PetscCall(First(w, &final));
  PetscCall(SlipOutputAddResult(output, "w", "final w", NULL, final));
  PetscCall(SlipOutputAddResult(output, "l2_error", "L2 error", NULL, PetscSqrtReal(run->integral / run->time)));
  PetscCall(SlipOutputAddResult(output, "max_error", "largest error", NULL, run->largest));
  PetscCall(SlipOutputFinish(&output, ready - begin, end - ready));
  PetscFunctionReturn(0);
}

static PetscErrorCode Main(void)
{
  Run run = {.time = 0};
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool only_help;
  PetscLogDouble begin;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin));
  PetscCall(SlidingModeSetFromOptions(&run.model, 1));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Output", NULL);
  PetscCall(PetscOptionsString("-sliding_mode_output", "HDF5 file to write (default none)", NULL, file, file,
                               sizeof(file), NULL));
  PetscOptionsEnd();
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(SlidingModeConfigureTS(&run.model, ts));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 1, &w));
  PetscCall(VecSet(w, run.model.start));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (!only_help) {
    PetscCall(Solve(ts, w, &run, file, begin));
    PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipErrorHandlerPush("sliding_mode"));
  PetscCall(Main());
  PetscCall(PetscFinalize());
  return 0;
}
