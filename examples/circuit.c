static const char help[] =
  "Circuit with an ideal Zener diode, C1 dV1/dt = (V2 - V1)/R - m Sign(V1) and a C2, L loop.\n"
  "  circuit -circuit_case evaluation -ts_adapt_type pi -circuit_reference 1e-4 -circuit_output run.h5\n"
  "Defaults: the evaluation setting, steps from 1e-9 s to t_max/10 (-ts_adapt_dt_min, -ts_adapt_dt_max), -ts_rtol "
  "1e-6,\n"
  "-ts_atol 1e-8, -ts_adapt_type heuristic.\n\n";

#include "circuit.h"
#include <petsctime.h>

/* A run with constant steps, its states at every step. */
typedef struct {
  PetscReal dt;
  PetscInt n, max;  /* states stored, and room for them */
  PetscReal *state; /* [max, CIRCUIT_N] */
} Reference;

typedef struct {
  Circuit model;
  Reference reference;
  PetscReal time, error2, size2; /* of the last step: squared norms of the error and of the reference */
  PetscReal errors, sizes;       /* their integrals over time, trapezoidal rule */
} Run;

/* TSMonitor of the reference run */
static PetscErrorCode Store(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Reference *ref = (Reference *)ctx;
  const PetscScalar *a;

  PetscFunctionBeginUser;
  (void)ts;
  (void)time;
  if (step < 0 || step >= ref->max) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(PetscArraycpy(&ref->state[CIRCUIT_N * step], a, CIRCUIT_N));
  PetscCall(VecRestoreArrayRead(w, &a));
  ref->n = step + 1;
  PetscFunctionReturn(0);
}

/* Constant steps of the size nearest to that asked for that divides the run */
static PetscErrorCode ReferenceCompute(Run *run, PetscReal dt)
{
  Reference *ref = &run->reference;
  const PetscReal steps = PetscMax(1, PetscFloorReal(0.5 + run->model.max_time / dt));
  TS ts;
  TSAdapt adapt;
  Vec w;

  PetscFunctionBeginUser;
  PetscCheck(dt > 0 && steps < 1e8, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-circuit_reference is %g s, expected a step > 0 s of which fewer than 1e8 make the run", (double)dt);
  ref->dt = run->model.max_time / steps;
  ref->max = (PetscInt)steps + 1;
  PetscCall(PetscMalloc1(CIRCUIT_N * ref->max, &ref->state));
  PetscCall(CircuitCreateState(&run->model, &w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(CircuitConfigureTS(&run->model, ts));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSSetTimeStep(ts, ref->dt));
  PetscCall(TSMonitorSet(ts, Store, ref, NULL));
  PetscCall(TSSolve(ts, w));
  PetscCall(TSDestroy(&ts));
  PetscCall(VecDestroy(&w));
  PetscFunctionReturn(0);
}

/* The reference at any time, linear between its steps */
static PetscReal ReferenceAt(const Reference *ref, PetscInt k, PetscReal time)
{
  const PetscInt j = PetscMin((PetscInt)(time / ref->dt), ref->n - 2);
  const PetscReal s = time / ref->dt - j;

  return (1 - s) * ref->state[CIRCUIT_N * j + k] + s * ref->state[CIRCUIT_N * (j + 1) + k];
}

/* TSMonitor of the run */
static PetscErrorCode MeasureError(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Run *run = (Run *)ctx;
  const PetscScalar *a;
  PetscReal error2 = 0, size2 = 0;

  PetscFunctionBeginUser;
  (void)ts;
  if (step < 0) PetscFunctionReturn(0); /* the final time once more */
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt k = 0; k < CIRCUIT_N; k++) {
    const PetscReal exact = ReferenceAt(&run->reference, k, time);

    error2 += PetscSqr(a[k] - exact);
    size2 += PetscSqr(exact);
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  run->errors += 0.5 * (time - run->time) * (run->error2 + error2);
  run->sizes += 0.5 * (time - run->time) * (run->size2 + size2);
  run->time = time;
  run->error2 = error2;
  run->size2 = size2;
  PetscFunctionReturn(0);
}

static const SlipOutputColumn columns[] = {{"V1", "V", PETSC_FALSE},
                                           {"V2", "V", PETSC_FALSE},
                                           {"i", "A", PETSC_FALSE},
                                           {"reaction", "A", PETSC_FALSE},
                                           {"energy", "J", PETSC_FALSE}};

static PetscErrorCode Row(TS ts, PetscReal time, Vec w, Vec r, PetscReal row[], void *ctx)
{
  const PetscScalar *a, *b;

  PetscFunctionBeginUser;
  (void)ts;
  (void)time;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(r, &b));
  PetscCall(PetscArraycpy(row, a, CIRCUIT_N));
  row[3] = b[0];
  row[4] = CircuitEnergy(&((Run *)ctx)->model, a);
  PetscCall(VecRestoreArrayRead(r, &b));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(0);
}

static PetscErrorCode AddResults(Run *run, Vec w, SlipOutput output)
{
  const PetscScalar *a;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(SlipOutputAddResult(output, "V1", "final V1", "V", a[0]));
  PetscCall(SlipOutputAddResult(output, "V2", "final V2", "V", a[1]));
  PetscCall(SlipOutputAddResult(output, "i", "final i", "A", a[2]));
  PetscCall(SlipOutputAddResult(output, "energy", "final energy", "J", CircuitEnergy(&run->model, a)));
  PetscCall(VecRestoreArrayRead(w, &a));
  if (run->reference.n) {
    PetscCall(SlipOutputAddRun(output, "reference_dt", run->reference.dt));
    PetscCall(
      SlipOutputAddResult(output, "l2_error", "relative L2 error", NULL, PetscSqrtReal(run->errors / run->sizes)));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(TS ts, Vec w, Run *run, const char file[], PetscReal dt)
{
  SlipOutput output;
  PetscLogDouble begin, ready, end;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin));
  if (dt != 0) PetscCall(ReferenceCompute(run, dt));
  PetscCall(SlipOutputCreate(ts, file, PETSC_STATIC_ARRAY_LENGTH(columns), columns, Row, run, &output));
  if (dt != 0) PetscCall(TSMonitorSet(ts, MeasureError, run, NULL));
  PetscCall(PetscTime(&ready));
  PetscCall(TSSolve(ts, w));
  PetscCall(PetscTime(&end));
  PetscCall(AddResults(run, w, output));
  PetscCall(SlipOutputFinish(&output, ready - begin, end - ready));
  PetscCall(PetscFree(run->reference.state));
  PetscFunctionReturn(0);
}

static PetscErrorCode Main(void)
{
  Run run = {.time = 0};
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscReal dt = 0;
  PetscBool only_help;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(CircuitSetFromOptions(&run.model, 1));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Output", NULL);
  PetscCall(
    PetscOptionsString("-circuit_output", "HDF5 file to write (default none)", NULL, file, file, sizeof(file), NULL));
  PetscCall(PetscOptionsReal("-circuit_reference",
                             "Compare with a run of constant steps of this size [s] (default 0: no comparison)", NULL,
                             dt, &dt, NULL));
  PetscOptionsEnd();
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(CircuitConfigureTS(&run.model, ts));
  PetscCall(CircuitCreateState(&run.model, &w));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (!only_help) {
    PetscCall(Solve(ts, w, &run, file, dt));
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
  PetscCall(SlipErrorHandlerPush("circuit"));
  PetscCall(Main());
  PetscCall(PetscFinalize());
  return 0;
}
