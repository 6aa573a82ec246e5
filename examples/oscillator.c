static const char help[] =
  "A mass on a spring with dry friction, m dv/dt = -k x + F_r, dx/dt = v, F_r in -mu N Sign(v).\n"
  "  oscillator -ts_adapt_type pi -oscillator_output run.h5\n"
  "examples/README.md walks through this program as a pattern for models of your own.\n\n";

#include <slipstep.h>
#include <petsctime.h>

/* 1. The parameters of the model. */
typedef struct {
  PetscReal mass, stiffness, friction, normal, start; /* [kg], [N/m], -, [N], x(0) [m] */
} Oscillator;

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

/* 2. The smooth forces F_s of the states w = (v, x), and their derivatives J[i n + j] = dF_i/dw_j. */
static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const Oscillator *o = (const Oscillator *)ctx;

  PetscFunctionBeginUser;
  (void)t;
  F[0] = -o->stiffness * w[1];
  F[1] = w[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t;
  (void)w;
  J[0 * 2 + 1] = -((const Oscillator *)ctx)->stiffness;
  J[1 * 2 + 0] = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 3. The bound q of the reaction |F_r| <= q. A q that depends on |v| also sets its derivative dq[0], unless dq is
   NULL. */
static PetscErrorCode Bound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  const Oscillator *o = (const Oscillator *)ctx;

  PetscFunctionBeginUser;
  (void)t;
  (void)w;
  (void)dq;
  q[0] = o->friction * o->normal;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 4. What is written after each accepted step; time comes first by itself. */
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

/* 5. The exact solution, for its error: half cycles about x = +-mu N/k, until the spring is too weak to move the
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

/* 6. The TS: the system in one table, then PETSc as usual. The reaction enters row 0, that of v. */
static PetscErrorCode ConfigureTS(Oscillator *o, TS ts)
{
  const PetscReal mass[] = {o->mass, 1};
  const PetscInt rows[] = {0};
  const SlipSmall problem = {
    .n = 2, .mass = mass, .nrows = 1, .rows = rows, .force = Force, .jacobian = Jacobian, .bound = Bound, .ctx = o};

  PetscFunctionBeginUser;
  PetscCall(SlipSmallConfigureTS(&problem, ts)); /* type bathe, the constraint, the controller heuristic */
  PetscCall(TSSetMaxTime(ts, 5));
  PetscCall(TSSetTimeStep(ts, 1e-3));
  PetscCall(TSSetTolerances(ts, 1e-6, NULL, 1e-4, NULL));
  PetscCall(SlipCheckSolverOptions(ts)); /* wrong values, with the name of their option */
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
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
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipErrorHandlerPush("oscillator")); /* errors are one line, not a traceback for PETSc's authors */
  PetscCall(SlipDeclareOptions("oscillator_", "mass stiffness friction normal start output"));
  PetscCall(SlipCheckOptionNames()); /* what is mistyped */
  PetscCall(SetFromOptions(&o, file));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 2, &w));
  PetscCall(VecSet(w, 0));
  PetscCall(VecSetValue(w, 1, o.start, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(w));
  PetscCall(VecAssemblyEnd(w));
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
