/* The program of a small model (slipmodels.h): one run with its output, compared with a solution that the program
   knows. circuit.c and sliding_mode.c say what differs. */
#pragma once
#include <slipstep.h>
#include <petsctime.h>

typedef struct _Program Program;

typedef struct {
  const Program *program;
  SlipModel model;
  void *ctx;                     /* the program's own */
  PetscBool compared;            /* with program->solution */
  PetscReal time, error2, size2; /* of the last step: squared norms of the error and of the solution */
  PetscReal errors, sizes;       /* their integrals over time, trapezoidal rule */
  PetscReal largest;             /* error */
} Run;

struct _Program {
  const char *name, *help, *prefix, *own; /* own: names of the program's options, behind the prefix of the model's */
  const SlipModelOps *ops;
  void *ctx;
  PetscErrorCode (*options)(Run *run); /* further ones, and what they ask for; NULL: none */
  PetscErrorCode (*solution)(const Run *run, PetscReal t, PetscReal w[]);            /* to compare with [states] */
  PetscErrorCode (*results)(const Run *run, const PetscReal w[], SlipOutput output); /* w: the last state */
};

/* TSMonitor */
static PetscErrorCode MeasureError(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Run *run = (Run *)ctx;
  const PetscScalar *a;
  PetscReal exact[SLIP_MODEL_STATES], error2 = 0, size2 = 0;

  PetscFunctionBeginUser;
  (void)ts;
  if (step < 0) PetscFunctionReturn(0); /* the final time once more */
  PetscCall((*run->program->solution)(run, time, exact));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt k = 0; k < run->model->ops->n; k++) {
    error2 += PetscSqr(a[k] - exact[k]);
    size2 += PetscSqr(exact[k]);
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  run->errors += 0.5 * (time - run->time) * (run->error2 + error2);
  run->sizes += 0.5 * (time - run->time) * (run->size2 + size2);
  run->largest = PetscMax(run->largest, PetscSqrtReal(error2));
  run->time = time;
  run->error2 = error2;
  run->size2 = size2;
  PetscFunctionReturn(0);
}

/* The columns: states, reaction, energy, and the exact state and reaction where they are known in closed form */
static PetscErrorCode Row(TS ts, PetscReal time, Vec w, Vec r, PetscReal row[], void *ctx)
{
  const SlipModel model = ((Run *)ctx)->model;
  const PetscInt n = model->ops->n;
  const PetscScalar *a, *b;

  PetscFunctionBeginUser;
  (void)ts;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(r, &b));
  PetscCall(PetscArraycpy(row, a, n));
  row[n] = b[0];
  row[n + 1] = SlipModelEnergy(model, a);
  if (model->ops->exact) row[n + 2] = (*model->ops->exact)(model, time, &row[n + 3]);
  PetscCall(VecRestoreArrayRead(r, &b));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(0);
}

static PetscErrorCode Solve(TS ts, Vec w, Run *run, const char file[], PetscBool overwrite, PetscLogDouble begin,
                            PetscBool *complete)
{
  char option[64];
  const SlipModelOps *ops = run->model->ops;
  const PetscInt n = ops->n;
  SlipOutputColumn column[SLIP_MODEL_STATES + 4];
  SlipOutput output;
  PetscLogDouble ready, end;
  const PetscScalar *a;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n; k++) column[k] = (SlipOutputColumn){ops->states[k], ops->units[k], PETSC_FALSE};
  column[n] = (SlipOutputColumn){"reaction", ops->units[n], PETSC_FALSE};
  column[n + 1] = (SlipOutputColumn){"energy", ops->energy_unit, PETSC_FALSE};
  column[n + 2] = (SlipOutputColumn){"exact", ops->units[0], PETSC_FALSE};
  column[n + 3] = (SlipOutputColumn){"exact_reaction", ops->units[n], PETSC_FALSE};
  PetscCall(SlipOutputCreate(ts, file, ops->exact ? n + 4 : n + 2, column, Row, run, &output));
  PetscCall(PetscSNPrintf(option, sizeof(option), "%s_output", run->program->name));
  PetscCall(SlipOutputSetOption(output, NULL, option, overwrite));
  if (run->compared) PetscCall(TSMonitorSet(ts, MeasureError, run, NULL));
  PetscCall(PetscTime(&ready));
  PetscCall(TSSolve(ts, w));
  PetscCall(PetscTime(&end));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall((*run->program->results)(run, a, output));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(SlipOutputFinish(&output, ready - begin, end - ready));
  PetscCall(SlipReportEnd(ts, NULL, complete));
  PetscFunctionReturn(0);
}

/* complete: the run reached its end, or there was none */
static PetscErrorCode Main(const Program *program, PetscBool *complete)
{
  Run run = {.program = program, .ctx = program->ctx, .compared = PETSC_TRUE};
  char file[PETSC_MAX_PATH_LEN] = "", option[64];
  PetscBool only_help, overwrite = PETSC_FALSE;
  PetscLogDouble begin;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(SlipCheckOptionNames());
  PetscCall(PetscTime(&begin));
  PetscCall(SlipModelCreate(program->ops, SLIP_MODEL_EVALUATION, &run.model));
  PetscCall(SlipModelSetFromOptions(run.model));
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s_output", program->name));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Output", NULL);
  PetscCall(PetscOptionsString(option, "HDF5 file to write (default none)", NULL, file, file, sizeof(file), NULL));
  PetscCall(PetscStrlcat(option, "_overwrite", sizeof(option)));
  PetscCall(PetscOptionsBool(option, "Throw the rows of an unfinished FILE.part away (default no)", NULL, overwrite,
                             &overwrite, NULL));
  PetscOptionsEnd();
  if (program->options) PetscCall((*program->options)(&run));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(SlipModelConfigureTS(run.model, ts));
  PetscCall(SlipModelCreateState(run.model, &w));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(SlipCheckSolverOptions(ts));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (!only_help) {
    PetscCall(SlipCheckUnusedOptions());
    PetscCall(Solve(ts, w, &run, file, overwrite, begin, complete));
    PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscCall(SlipModelDestroy(&run.model));
  PetscFunctionReturn(0);
}

static inline int RunProgram(int argc, char **argv, const Program *program)
{
  PetscBool complete = PETSC_TRUE;

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, program->name, program->help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipDeclareOptions(program->prefix, program->own));
  PetscCall(Main(program, &complete));
  PetscCall(PetscFinalize());
  return complete ? 0 : SLIP_EXIT_INCOMPLETE;
}
