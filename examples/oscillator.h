/* The model of oscillator.c and train_oscillator.c, m dv/dt = -k x + F_r, dx/dt = v, F_r in -mu N Sign(v): its
   parameters, forces, what policies observe of it, and a TS that integrates it. */
#pragma once
#include <slipstep.h>

/* 1. The parameters of the model. */
typedef struct {
  PetscReal mass, stiffness, friction, normal, start; /* [kg], [N/m], -, [N], x(0) [m] */
} Oscillator;

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

/* 4. What policies know of it: its unit of time, and two numbers that say how soon and how strongly it turns round. All
   oscillators are the same in units of T* and of the start, but for the friction. */
typedef struct {
  PetscReal turn, swing; /* time to the next turn [s]; amplitude of the half cycle under way [m], 0 at rest */
} OscillatorCycle;

static inline OscillatorCycle Cycle(const Oscillator *o, PetscReal v, PetscReal x)
{
  const PetscReal tstar = PetscSqrtReal(o->mass / o->stiffness), offset = o->friction * o->normal / o->stiffness;
  const PetscReal side = v != 0 ? v : -x;                               /* where it goes */
  const PetscReal y = x + (side > 0 ? offset : -offset), u = v * tstar; /* about the centre of this half cycle */

  if (v == 0 && PetscAbsReal(x) <= offset) return (OscillatorCycle){PETSC_MAX_REAL, 0};
  /* y = -A cos(phase), u = A sin(phase) where it goes up; the turn is at pi */
  return (OscillatorCycle){tstar * (PETSC_PI - PetscAtan2Real(PetscAbsReal(u), side > 0 ? -y : y)),
                           PetscSqrtReal(PetscSqr(y) + PetscSqr(u))};
}

static PetscErrorCode TimeScale(TS ts, PetscReal *tstar, void *ctx)
{
  const Oscillator *o = (Oscillator *)ctx;

  PetscFunctionBeginUser;
  (void)ts;
  *tstar = PetscSqrtReal(o->mass / o->stiffness);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Find(TS ts, const char name[], PetscInt *row, void *ctx)
{
  PetscFunctionBeginUser;
  (void)ts;
  (void)ctx;
  *row = !strcmp(name, "log_turn") ? 0 : !strcmp(name, "log_swing") ? 1 : -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Observe(TS ts, PetscReal t, PetscInt n, const PetscInt row[], PetscReal value[], void *ctx)
{
  Oscillator *o = (Oscillator *)ctx;
  OscillatorCycle cycle;
  PetscReal tstar = 1;
  const PetscScalar *a;
  Vec w;

  PetscFunctionBeginUser;
  (void)t;
  PetscCall(TimeScale(ts, &tstar, o));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(VecGetArrayRead(w, &a));
  cycle = Cycle(o, a[0], a[1]);
  PetscCall(VecRestoreArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal number = row[i] ? cycle.swing / PetscAbsReal(o->start) : cycle.turn / tstar;

    value[i] = PetscLog10Real(PetscClipInterval(number, (PetscReal)1e-3, (PetscReal)10));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipProblemOps OscillatorProblem = {.control = {.time_scale = TimeScale},
                                                 .observations = {.find = Find, .observe = Observe}};

/* 5. The TS: the system in one table, then PETSc as usual. The reaction enters row 0, that of v. */
static inline PetscErrorCode ConfigureTS(Oscillator *o, TS ts)
{
  const PetscReal mass[] = {o->mass, 1};
  const PetscInt rows[] = {0};
  const SlipSmall problem = {
    .n = 2, .mass = mass, .nrows = 1, .rows = rows, .force = Force, .jacobian = Jacobian, .bound = Bound, .ctx = o};

  PetscFunctionBeginUser;
  PetscCall(SlipSmallConfigureTS(&problem, ts)); /* type bathe, the constraint, the controller dsp */
  PetscCall(TSSetMaxTime(ts, 5));
  PetscCall(TSSetTimeStep(ts, 1e-3));
  PetscCall(TSSetTolerances(ts, 1e-6, NULL, 1e-4, NULL));
  PetscCall(TSSetSlipProblem(ts, &OscillatorProblem, o));
  PetscCall(SlipCheckSolverOptions(ts)); /* wrong values, with the name of their option */
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSBatheCheckOptions(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The state at the start */
static inline PetscErrorCode CreateState(const Oscillator *o, Vec *w)
{
  PetscFunctionBeginUser;
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 2, w));
  PetscCall(VecSet(*w, 0));
  PetscCall(VecSetValue(*w, 1, o->start, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(*w));
  PetscCall(VecAssemblyEnd(*w));
  PetscFunctionReturn(PETSC_SUCCESS);
}
