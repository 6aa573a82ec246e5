/* TSBATHE with a constraint: one mass with closed-form motion, arrest, reaction, adaptivity and failure. */
#include "unit.h"
#include "sliders.h"

/* m dv/dt = -eta v - k u + load + r, |r| <= q constant, from v = 0, u = 0 with load > q: while it slides forwards,
   u = A (1 - exp(-a t)(cos w t + (a/w) sin w t)), A = (load - q)/k, a = eta/2m, w^2 = k/m - a^2. v returns to zero at t
   = pi/w, where |k u - load| < q holds it: it sticks for good. */
static const PetscReal mass = 2.0, eta = 0.6, stiffness = 5.0, load = 3.0, strength = 1.0;

static PetscReal entry(PetscInt i, PetscInt j, PetscInt n)
{
  return stiffness;
}

static PetscReal Displacement(PetscReal t)
{
  const PetscReal a = 0.5 * eta / mass, w = PetscSqrtReal(stiffness / mass - a * a), s = PetscMin(t, PETSC_PI / w);

  return (load - strength) / stiffness *
         (1.0 - PetscExpReal(-a * s) * (PetscCosReal(w * s) + a / w * PetscSinReal(w * s)));
}

static void Setup(Sliders *p, Vec *w)
{
  ok(SlidersCreate(PETSC_COMM_SELF, 1, entry, mass, eta, p));
  ok(VecSet(p->bound, strength));
  ok(VecSet(p->load, load));
  ok(SlidersCreateState(p, w));
}

/* The displacement at 1 s under friction that weakens from 1 to 0.4 over the slip of 1: no closed form, so a fine run
   is the truth, exact to 1e-10 */
static PetscReal Weakened(TSBatheReactionType reaction, PetscInt steps)
{
  PetscReal u;
  Sliders p;
  Vec w;

  Setup(&p, &w);
  p.mud = 0.4;
  p.dmu = 0.6;
  ok(SlidersSolve(&p, reaction, 1.0, steps, w, NULL));
  u = VecRead(w)[1];
  ok(VecDestroy(&w));
  ok(SlidersDestroy(&p));
  return u;
}

/* While sliding: order 2 with the trapezoidal reaction, 1 with the implicit one, up to the next term of the error. That
   is large and of the other sign for the implicit one here, so it shows its order at small steps only. */
static void test_order_while_sliding(void **state)
{
  const PetscReal truth = Weakened(TSBATHE_REACTION_TRAPEZOIDAL, 20000);

  for (int k = 0; k < 2; k++) {
    const TSBatheReactionType reaction = k ? TSBATHE_REACTION_IMPLICIT : TSBATHE_REACTION_TRAPEZOIDAL;
    PetscReal error[2];

    for (int i = 0; i < 2; i++) error[i] = fabs(Weakened(reaction, (k ? 1280 : 40) << i) - truth);
    AssertNear(log2(error[0] / error[1]), (k ? 1.0 : 2.0), 0.1);
  }
}

/* Constant friction against the closed form, before and after the arrest; sticking is exact: v == 0 and r == k u -
   load */
static void test_closed_form(void **state)
{
  PetscReal error[2];

  for (int i = 0; i < 2; i++) {
    Sliders p;
    Vec w, r;
    TS ts;

    Setup(&p, &w);
    ok(SlidersSolve(&p, TSBATHE_REACTION_TRAPEZOIDAL, 1.5, 30 << i, w, NULL));
    error[i] = fabs(VecRead(w)[1] - Displacement(1.5));
    ok(VecDestroy(&w));
    ok(SlidersCreateState(&p, &w));
    ok(SlidersSolve(&p, TSBATHE_REACTION_TRAPEZOIDAL, 4.0, 80, w, &ts));
    ok(TSBatheGetReaction(ts, &r));
    assert_true(VecRead(w)[0] == 0.0);
    /* equal up to the rounding of K u and of the stage's sums, terms of about 40 m v/theta */
    AssertNear(VecRead(r)[0], (stiffness * VecRead(w)[1] - load), 1e-12);
    AssertLess(fabs(VecRead(r)[0]), strength);
    /* In the step of the arrest the three-point formula extrapolates the velocity past zero: it may slip back by
       O(h^2). */
    AssertNear(VecRead(w)[1], VecRead(w)[2], 0.05 * 0.05);
    AssertNear(VecRead(w)[1], Displacement(4.0), 0.05 * 0.05);
    ObjectsDestroy(&ts, &w);
    ok(SlidersDestroy(&p));
  }
  AssertNear(log2(error[0] / error[1]), 2.0, 0.1);
}

/* Adaptive runs through the arrest. The estimate must not chase the jump of the acceleration there: the steps stay far
   above what resolving a jump to the tolerance (h < 1e-8 here) would take, and the result is as good as asked for. */
static void test_adaptive_arrest(void **state)
{
  const TSBatheError kinds[] = {TSBATHE_ERROR_EMBEDDED, TSBATHE_ERROR_DOUBLING};

  for (int k = 0; k < 2; k++) {
    Sliders p;
    Vec w;
    TS ts;
    PetscInt steps, rejected;

    Setup(&p, &w);
    ts = MakeTS(TSBATHE, 0.01, 4.0);
    ok(TSBatheSetConstraint(ts, p.con));
    ok(TSBatheSetError(ts, kinds[k]));
    ok(TSSetSolution(ts, w));
    ok(TSSetTolerances(ts, 1e-8, NULL, 1e-4, NULL));
    SetAdapt(ts, TSADAPTBASIC);
    ok(TSSetFromOptions(ts));
    ok(TSSolve(ts, w));
    ok(TSGetStepNumber(ts, &steps));
    ok(TSGetStepRejections(ts, &rejected));
    assert_true(VecRead(w)[0] == 0.0);
    AssertNear(VecRead(w)[1], Displacement(4.0), 1e-3); /* about ten times rtol times the largest displacement */
    assert_true(steps < 300 && rejected < 60);
    ObjectsDestroy(&ts, &w);
    ok(SlidersDestroy(&p));
  }
}

/* Rolled back, state and reaction are those of the step's start and the step repeats bit for bit */
static void test_rollback_restores_reaction(void **state)
{
  Sliders p;
  Vec w, r, r0, w0, w1;
  TS ts;
  PetscBool same;

  Setup(&p, &w);
  p.mud = 0.4;
  p.dmu = 0.6;
  ok(SlidersSolve(&p, TSBATHE_REACTION_TRAPEZOIDAL, 0.5, 5, w, &ts));
  ok(TSSetMaxTime(ts, 10.0));
  ok(TSBatheGetReaction(ts, &r));
  ok(VecDuplicate(r, &r0));
  VecsDuplicate(w, &w0, &w1);
  ok(VecCopy(r, r0));
  ok(VecCopy(w, w0));
  ok(TSStep(ts));
  ok(VecCopy(w, w1));
  ok(VecEqual(r, r0, &same));
  assert_false(same);
  ok(TSRollBack(ts));
  ok(VecEqual(r, r0, &same));
  assert_true(same);
  ok(VecEqual(w, w0, &same));
  assert_true(same);
  ok(TSStep(ts));
  ok(VecEqual(w, w1, &same));
  assert_true(same);
  ObjectsDestroy(&r0, &w0, &w1, &w, &ts);
  ok(SlidersDestroy(&p));
}

/* A stage that cannot converge: no iteration is allowed. Every attempt is recorded with residual 2 a solve, the state
   stays that of the start, and after the allowed number the error names time, step and cell. */
typedef struct {
  PetscInt calls;
  PetscReal residual, next, v;
} Log;

static PetscErrorCode Watch(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Log *log = (Log *)ctx;

  log->calls++;
  log->residual = attempt->residual;
  log->next = attempt->dt;
  return VecGetValues(w, 1, (PetscInt[]){0}, &log->v);
}

static PetscErrorCode Third(TSAdapt adapt, TS ts, PetscReal h, PetscReal *next)
{
  *next = h / 3.0;
  return PETSC_SUCCESS;
}

static void test_failure(void **state)
{
  Sliders p;
  Vec w;
  TS ts;
  TSAdapt adapt;
  SNES snes;
  Log log = {0};
  PetscErrorCode ierr;

  Setup(&p, &w);
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSBATHE));
  ok(TSBatheSetConstraint(ts, p.con));
  ok(TSBatheSetError(ts, TSBATHE_ERROR_DOUBLING));
  ok(TSBatheMonitorSet(ts, Watch, &log, NULL));
  ok(TSSetSolution(ts, w));
  ok(TSSetMaxTime(ts, 4.0));
  ok(TSSetTimeStep(ts, 0.9));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTBASIC));
  ok(PetscObjectComposeFunction((PetscObject)adapt, "TSAdaptChooseAfterFailure_C", Third));
  ok(PetscOptionsSetValue(NULL, "-ts_bathe_max_failures", "4"));
  ok(TSSetFromOptions(ts));
  ok(PetscOptionsClearValue(NULL, "-ts_bathe_max_failures"));
  ok(TSGetSNES(ts, &snes));
  ok(SNESSetTolerances(snes, 1e-30, 1e-10, 0.0, 0, 1000));
  ierr = TSSolve(ts, w);
  assert_int_equal((int)ierr, PETSC_ERR_NOT_CONVERGED);
  assert_non_null(strstr(message, "-ts_bathe_max_failures"));
  assert_non_null(strstr(message, "time 0"));
  assert_non_null(strstr(message, "cell 0"));
  assert_non_null(strstr(message, "DIVERGED_MAX_IT"));
  assert_int_equal(log.calls, 4);
  AssertNear(log.next, 0.9 / 27.0, 1e-15);
  assert_true(log.residual == 6.0); /* one failed, two not run */
  assert_true(log.v == 0.0);
  ObjectsDestroy(&ts, &w);
  ok(SlidersDestroy(&p));
}

/* A type of SNES that knows no constraint is refused by name */
static void test_wrong_snes_is_refused(void **state)
{
  Sliders p;
  Vec w;
  PetscErrorCode ierr;

  Setup(&p, &w);
  ok(PetscOptionsSetValue(NULL, "-snes_type", "newtonls"));
  ierr = SlidersSolve(&p, TSBATHE_REACTION_TRAPEZOIDAL, 1.0, 4, w, NULL);
  ok(PetscOptionsClearValue(NULL, "-snes_type"));
  assert_int_equal((int)ierr, PETSC_ERR_SUP);
  assert_non_null(strstr(message, "newtonls"));
  ok(VecDestroy(&w));
  ok(SlidersDestroy(&p));
}

/* A long step under strong weakening has an indefinite Jacobian at rest. The stage must still end on the branch that
   the loading leads to: forwards, at a solution of the implicit equations with a positive definite Jacobian. */
static void indefinite_start(const char *direct_max)
{
  Sliders p;
  Vec w, x, r, q, dq;
  SNES snes;
  SlipStage stage = {.t = 3.0, .theta = 3.0, .omega = 1.0};
  SNESConvergedReason reason;

  Setup(&p, &w);
  ok(VecSet(p.load, 1.0 + 1e-5));
  p.mud = 0.2;
  p.dmu = 0.8;
  p.dc = 0.02;
  stage.base = w;
  VecsDuplicate(p.bound, &x, &r, &q, &dq);
  ok(VecZeroEntries(x));
  ok(CreateSolver(p.con, SNESSEMISMOOTH, direct_max, &snes));
  ok(SNESSlipSolveStage(snes, &stage, x, r, NULL));
  ok(SNESGetConvergedReason(snes, &reason));
  AssertLess(0, reason);
  ok(SlidersBound(p.con, x, q, dq, &p));
  AssertLess(1e-3, VecRead(x)[0]);
  AssertLess(0.0, mass / 3.0 + eta + 3.0 * stiffness + VecRead(dq)[0]);
  assert_true(VecRead(r)[0] == -VecRead(q)[0]);
  ObjectsDestroy(&snes, &x, &r, &q, &dq, &w);
  ok(SlidersDestroy(&p));
}

static void test_indefinite_start(void **state)
{
  indefinite_start("350");
  indefinite_start("0"); /* Krylov */
}

SLIP_TESTS(test_order_while_sliding, test_closed_form, test_adaptive_arrest, test_rollback_restores_reaction,
           test_failure, test_wrong_snes_is_refused, test_indefinite_start)
