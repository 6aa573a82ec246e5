static const char help[] =
  "A mass on a spring with dry friction, m dv/dt = -k x + F_r, dx/dt = v, F_r in -mu N Sign(v).\n"
  "  oscillator -ts_adapt_type pi -oscillator_output run.h5\n"
  "  oscillator -ts_adapt_type rl -ts_adapt_rl_policy my.h5     (by a policy of train_oscillator)\n"
  "examples/howto/own_model.md says how to write such a model of your own.\n\n";

#include "oscillator.h"
#include <petsctime.h>

static PetscErrorCode SetFromOptions(Oscillator *o, char file[])
{
  const char *const numbers[] = {"-oscillator_mass", "-oscillator_stiffness", "-oscillator_friction",
                                 "-oscillator_normal", "-oscillator_start"};

  PetscFunctionBeginUser;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(numbers); i++)
    PetscCall(SlipCheckFiniteOption(PETSC_COMM_WORLD, numbers[i]));
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Oscillator with dry friction", NULL);
  PetscCall(PetscOptionsReal("-oscillator_mass", "Mass m [kg]", NULL, o->mass, &o->mass, NULL));
  PetscCall(PetscOptionsReal("-oscillator_stiffness", "Stiffness k [N/m]", NULL, o->stiffness, &o->stiffness, NULL));
  PetscCall(
    PetscOptionsReal("-oscillator_friction", "Coefficient of friction mu", NULL, o->friction, &o->friction, NULL));
  PetscCall(PetscOptionsReal("-oscillator_normal", "Normal force N [N]", NULL, o->normal, &o->normal, NULL));
  PetscCall(PetscOptionsReal("-oscillator_start", "Position x at the start [m]", NULL, o->start, &o->start, NULL));
  PetscCall(PetscOptionsString("-oscillator_output", "HDF5 file to write (default none)", NULL, file, file,
                               PETSC_MAX_PATH_LEN, NULL));
  PetscOptionsEnd();
  PetscCheck(o->mass > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-oscillator_mass is %g, expected a number > 0 kg", (double)o->mass);
  PetscCheck(o->friction * o->normal >= 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-oscillator_friction %g times -oscillator_normal %g N is negative, expected a force >= 0 N",
             (double)o->friction, (double)o->normal);
  PetscCheck(o->stiffness > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-oscillator_stiffness is %g, expected a number > 0 N/m", (double)o->stiffness);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is written after each accepted step; time comes first by itself. */
static const SlipOutputColumn columns[] = {
  {"v", "m/s", PETSC_FALSE}, {"x", "m", PETSC_FALSE}, {"reaction", "N", PETSC_FALSE}, {"energy", "J", PETSC_FALSE}};

static PetscErrorCode Row(TS ts, PetscReal time, Vec w, Vec r, PetscReal row[], void *ctx)
{
  const Oscillator *o = (const Oscillator *)ctx;
  const PetscScalar *a, *b;

  PetscFunctionBeginUser;
  (void)ts;
  (void)time;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(r, &b));
  row[0] = a[0];
  row[1] = a[1];
  row[2] = b[0];
  row[3] = 0.5 * (o->mass * PetscSqr(a[0]) + o->stiffness * PetscSqr(a[1]));
  PetscCall(VecRestoreArrayRead(r, &b));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The exact solution, for its error: half cycles about x = +-mu N/k, until the spring is too weak to move the
   mass. */
static PetscReal Exact(const Oscillator *o, PetscReal t)
{
  const PetscReal offset = o->friction * o->normal / o->stiffness,
                  half = PETSC_PI * PetscSqrtReal(o->mass / o->stiffness);
  PetscReal x = o->start, centre;

  for (; PetscAbsReal(x) > offset; x = 2 * centre - x, t -= half) {
    centre = x > 0 ? offset : -offset;
    if (t <= half) return centre + (x - centre) * PetscCosReal(PETSC_PI * t / half);
  }
  return x;
}

static PetscErrorCode Solve(TS ts, Vec w, Oscillator *o, const char file[], PetscBool *complete)
{
  SlipOutput output;
  PetscLogDouble begin, end;
  PetscReal t, row[4];
  Vec r;

  PetscFunctionBeginUser;
  PetscCall(SlipOutputCreate(ts, file, PETSC_STATIC_ARRAY_LENGTH(columns), columns, Row, o, &output));
  PetscCall(PetscTime(&begin));
  PetscCall(TSSolve(ts, w));
  PetscCall(PetscTime(&end));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSBatheGetReaction(ts, &r));
  PetscCall(Row(ts, t, w, r, row, o));
  PetscCall(SlipOutputAddResult(output, "v", "final v", "m/s", row[0]));
  PetscCall(SlipOutputAddResult(output, "x", "final x", "m", row[1]));
  PetscCall(SlipOutputAddResult(output, "x_error", "error of final x", "m", PetscAbsReal(row[1] - Exact(o, t))));
  PetscCall(SlipOutputFinish(&output, 0, end - begin));
  PetscCall(SlipReportEnd(ts, NULL, complete));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  Oscillator o = {.mass = 1, .stiffness = 40, .friction = 0.3, .normal = 10, .start = 1};
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool only_help, complete = PETSC_TRUE;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "oscillator",
                                  help)); /* errors are one line, not a traceback for PETSc's authors */
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipDeclareOptions("oscillator_", "mass stiffness friction normal start output"));
  PetscCall(SlipCheckOptionNames()); /* what is mistyped */
  PetscCall(SetFromOptions(&o, file));
  PetscCall(CreateState(&o, &w));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(ConfigureTS(&o, ts));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (!only_help) {
    PetscCall(SlipCheckUnusedOptions()); /* what would do nothing */
    PetscCall(Solve(ts, w, &o, file, &complete));
    PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscCall(PetscFinalize());
  return complete ? 0 : SLIP_EXIT_INCOMPLETE;
}
