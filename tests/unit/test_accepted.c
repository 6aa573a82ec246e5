/* The errors that controllers accept where blocks stick and slip: after a step in which a block has stuck the estimate
   is all but 0, and the next one may be thousands of tolerances. */
#include "unit.h"

#define TOLERANCE 1e-6

/* Blocks on a belt that moves at speed, each on a spring k to the ground and, beside others, on springs kc to these.
   w: their rates relative to the belt, and their places. q = low + more f(|v|). */
typedef struct {
  PetscInt n;
  PetscReal k, kc, speed, low, more, v0, end;
  PetscBool hyperbolic; /* f = 1/(1 + |v|/v0), exp(-|v|/v0) otherwise */
} Belt;

static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const Belt *b = (const Belt *)ctx;
  const PetscReal *u = w + b->n;

  for (PetscInt i = 0; i < b->n; i++) {
    F[i] = -b->k * u[i];
    if (i > 0) F[i] -= b->kc * (u[i] - u[i - 1]);
    if (i + 1 < b->n) F[i] -= b->kc * (u[i] - u[i + 1]);
    F[b->n + i] = w[i] + b->speed;
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  const Belt *b = (const Belt *)ctx;
  const PetscInt n = b->n, m = 2 * n;

  for (PetscInt i = 0; i < n; i++) {
    J[i * m + n + i] = -b->k - b->kc * ((i > 0) + (i + 1 < n));
    if (i > 0) J[i * m + n + i - 1] = b->kc;
    if (i + 1 < n) J[i * m + n + i + 1] = b->kc;
    J[(n + i) * m + i] = 1;
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode Bound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  const Belt *b = (const Belt *)ctx;

  for (PetscInt i = 0; i < b->n; i++) {
    const PetscReal x = PetscAbsReal(w[i]) / b->v0;
    const PetscReal f = b->hyperbolic ? 1 / (1 + x) : PetscExpReal(-x);

    q[i] = b->low + b->more * f;
    if (dq) dq[i] = -b->more * f * (b->hyperbolic ? f : 1) / b->v0;
  }
  return PETSC_SUCCESS;
}

typedef struct {
  PetscReal largest, end;
  PetscInt accepted, attempts, above, sticks;
  PetscBool stuck;
} Seen;

static PetscErrorCode See(TS ts, const SlipAttempt *a, Vec w, void *ctx)
{
  Seen *s = (Seen *)ctx;
  PetscScalar v;

  s->attempts++;
  if (!a->accepted) return PETSC_SUCCESS;
  s->accepted++;
  s->largest = PetscMax(s->largest, a->error);
  s->above += a->error > 2;
  PetscCall(VecGetValues(w, 1, (PetscInt[]){0}, &v));
  s->sticks += v == 0 && !s->stuck;
  s->stuck = v == 0 ? PETSC_TRUE : PETSC_FALSE;
  return PETSC_SUCCESS;
}

/* A run; the place of the first block at its end */
static Seen Run(const Belt *belt, const char controller[], PetscReal tolerance)
{
  static const PetscReal mass[] = {1, 1, 1, 1, 1, 1};
  static const PetscInt rows[] = {0, 1, 2};
  const SlipSmall small = {2 * belt->n, mass, belt->n, rows, Force, Jacobian, Bound, (void *)belt};
  SlipConstraint con;
  Seen seen = {0};
  TSAdapt adapt;
  PetscScalar end;
  TS ts;
  Vec w;

  ok(VecCreateSeq(PETSC_COMM_SELF, 2 * belt->n, &w));
  for (PetscInt i = 0; i < belt->n; i++) ok(VecSetValue(w, belt->n + i, 1e-3 * (PetscReal)(i * i), INSERT_VALUES));
  ok(VecAssemble(w));
  ok(SlipConstraintCreateSmall(&small, &con));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSBATHE));
  ok(TSBatheSetConstraint(ts, con));
  ok(TSGetAdapt(ts, &adapt));
  ok(SlipAdaptSetController(adapt, controller));
  ok(TSSetTolerances(ts, tolerance, NULL, tolerance, NULL));
  ok(TSSetTimeStep(ts, 1e-4));
  ok(TSSetMaxTime(ts, belt->end));
  ok(TSSetMaxSteps(ts, 1000000));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  ok(TSBatheMonitorSet(ts, See, &seen, NULL));
  ok(TSSolve(ts, w));
  ok(VecGetValues(w, 1, (PetscInt[]){belt->n}, &end));
  seen.end = end;
  ObjectsDestroy(&ts, &w);
  ok(SlipConstraintDestroy(&con));
  return seen;
}

static void test_accepted_errors(void **state)
{
  static const Belt belts[] = {{1, 100, 0, 0.1, 2, 2, 0.02, 5, PETSC_FALSE},
                               {3, 100, 40, 0.1, 2, 2, 0.02, 5, PETSC_FALSE},
                               {1, 50, 0, 0.2, 1, 3, 0.1, 8, PETSC_TRUE}};
  /* the largest error that each accepts; dsp, which is PETSc's, says of none */
  static const struct {
    const char *name;
    double most;
  } controllers[] = {{"heuristic", 1},         {"basic", 1},         {"dsp", PETSC_MAX_REAL},  {"pi", 1.954},
                     {"pi:elementary", 1.954}, {"pi:PI33", 1.954},   {"pi:PI34", 1.954},       {"pi:PI42", 1.954},
                     {"pi:H211PI", 1.954},     {"pi:H211b2", 1.954}, {"pi:fault_history", 226}};

  for (size_t b = 0; b < PETSC_STATIC_ARRAY_LENGTH(belts); b++) {
    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(controllers); i++) {
      const Seen s = Run(&belts[b], controllers[i].name, TOLERANCE);

      AssertLess(3, s.sticks);
      assert_true(s.largest <= controllers[i].most);
    }
  }
}

SLIP_TESTS(test_accepted_errors)
