static const char help[] =
  "Circuit with an ideal Zener diode, C1 dV1/dt = (V2 - V1)/R - m Sign(V1) and a C2, L loop.\n"
  "  circuit -circuit_case evaluation -ts_adapt_type pi -circuit_reference 1e-4 -circuit_output run.h5\n"
  "Defaults: the evaluation setting, steps from 1e-9 s to t_max/10 (-ts_adapt_dt_min, -ts_adapt_dt_max), -ts_rtol "
  "1e-6,\n"
  "-ts_atol 1e-8, -ts_adapt_type heuristic.\n\n";

#include "smallmodel.h"

/* A run with constant steps, its states at every step. */
typedef struct {
  PetscReal dt;
  PetscInt n, max;  /* states stored, and room for them */
  PetscReal *state; /* [max, 3] */
} Reference;

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
  PetscCall(PetscArraycpy(&ref->state[3 * step], a, 3));
  PetscCall(VecRestoreArrayRead(w, &a));
  ref->n = step + 1;
  PetscFunctionReturn(0);
}

/* -circuit_reference: constant steps of the size nearest to that asked for that divides the run */
static PetscErrorCode ComputeReference(Run *run)
{
  Reference *ref = (Reference *)run->ctx;
  PetscReal dt = 0, steps;
  PetscBool only_help;
  TS ts;
  TSAdapt adapt;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(SlipCheckFiniteOption(PETSC_COMM_WORLD, "-circuit_reference"));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Reference", NULL);
  PetscCall(PetscOptionsReal("-circuit_reference",
                             "Compare with a run of constant steps of this size [s] (default 0: no comparison)", NULL,
                             dt, &dt, NULL));
  PetscOptionsEnd();
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  run->compared = dt != 0 && !only_help ? PETSC_TRUE : PETSC_FALSE;
  if (!run->compared) PetscFunctionReturn(0);
  steps = PetscMax(1, PetscFloorReal(0.5 + run->model->max_time / dt));
  PetscCheck(dt > 0 && steps < 1e8, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-circuit_reference is %g s, expected a step > 0 s of which fewer than 1e8 make the run", (double)dt);
  ref->dt = run->model->max_time / steps;
  ref->max = (PetscInt)steps + 1;
  PetscCall(PetscMalloc1(3 * ref->max, &ref->state));
  PetscCall(SlipModelCreateState(run->model, &w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(SlipModelConfigureTS(run->model, ts));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSSetTimeStep(ts, ref->dt));
  PetscCall(TSMonitorSet(ts, Store, ref, NULL));
  PetscCall(TSSolve(ts, w));
  PetscCall(TSDestroy(&ts));
  PetscCall(VecDestroy(&w));
  PetscFunctionReturn(0);
}

/* Linear between the reference's steps */
static PetscErrorCode Solution(const Run *run, PetscReal t, PetscReal w[])
{
  const Reference *ref = (const Reference *)run->ctx;
  const PetscInt j = PetscMin((PetscInt)(t / ref->dt), ref->n - 2);
  const PetscReal s = t / ref->dt - j;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 3; k++) w[k] = (1 - s) * ref->state[3 * j + k] + s * ref->state[3 * (j + 1) + k];
  PetscFunctionReturn(0);
}

static PetscErrorCode Results(const Run *run, const PetscReal w[], SlipOutput output)
{
  PetscFunctionBeginUser;
  PetscCall(SlipOutputAddResult(output, "V1", "final V1", "V", w[0]));
  PetscCall(SlipOutputAddResult(output, "V2", "final V2", "V", w[1]));
  PetscCall(SlipOutputAddResult(output, "i", "final i", "A", w[2]));
  PetscCall(SlipOutputAddResult(output, "energy", "final energy", "J", SlipModelEnergy(run->model, w)));
  if (!run->compared) PetscFunctionReturn(0);
  PetscCall(SlipOutputAddRun(output, "reference_dt", ((const Reference *)run->ctx)->dt));
  PetscCall(
    SlipOutputAddResult(output, "l2_error", "relative L2 error", NULL, PetscSqrtReal(run->errors / run->sizes)));
  PetscCall(PetscFree(((Reference *)run->ctx)->state));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  Reference reference = {.dt = 0};
  const Program program = {"circuit",       help,       "circuit_",       "output output_overwrite reference",
                           &SlipCircuitOps, &reference, ComputeReference, Solution,
                           Results};

  return RunProgram(argc, argv, &program);
}
