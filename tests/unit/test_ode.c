/* The plain equations, methods and controllers that the general policy is trained on, against PETSc's. */
#include "policies.h"
#include "ode/ode.h"
#include <petscts.h>
#include <math.h>

static PetscErrorCode Rhs(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  const Ode *ode = (const Ode *)ctx;
  const PetscScalar *a = VecRead(y);
  PetscScalar *b;

  PetscCall(VecGetArrayWrite(f, &b));
  (*ode->f)(ode, t, a, b);
  return VecRestoreArrayWrite(f, &b);
}

static PetscErrorCode NoJacobian(TS ts, PetscReal t, Vec y, Mat J, Mat P, void *ctx)
{
  const Ode *ode = (const Ode *)ctx;
  PetscReal x[ODE_MAX_N], f[ODE_MAX_N], g[ODE_MAX_N];
  const PetscScalar *a = VecRead(y);

  for (PetscInt i = 0; i < ode->n; i++) x[i] = a[i];
  (*ode->f)(ode, t, x, f);
  for (PetscInt j = 0; j < ode->n; j++) {
    const PetscReal keep = x[j];

    x[j] += 1e-7 * (1 + fabs(keep));
    (*ode->f)(ode, t, x, g);
    for (PetscInt i = 0; i < ode->n; i++) PetscCall(MatSetValue(P, i, j, (g[i] - f[i]) / (x[j] - keep), INSERT_VALUES));
    x[j] = keep;
  }
  return MatAssemble(P);
}

/* A policy of three rows, with rejections; unit "h" */
static SlipPolicy filter(void)
{
  const char *const names[] = {"log_error_step", "change_log_error_step", "log_step_ratio", "rejections"};
  const PetscReal w[] = {0.6, 0.2, -0.1, -0.2}, one[] = {1, 1, 1, 1}, zero[4] = {0}, bias = -0.02;
  SlipPolicy p;

  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  ok(SlipPolicySetObservations(p, 4, names, one, zero));
  ok(SlipPolicyAddLayer(p, 4, 1, w, &bias, SLIP_ACTIVATION_LINEAR));
  ok(SlipPolicySetAction(p, -1, 1, 0.1, "h", 10, "h", PETSC_TRUE));
  return p;
}

/* Steps and rejected attempts of PETSc's method under a controller; policy NULL: basic */
static void by_petsc(const OdeEpisode *e, SlipPolicy policy, PetscInt *steps, PetscInt *rejected, Vec *y)
{
  const Ode *ode = &e->ode;
  TSAdapt adapt;
  SNES snes;
  Mat J;
  TS ts;

  ok(VecCreateSeq(PETSC_COMM_SELF, ode->n, y));
  for (PetscInt i = 0; i < ode->n; i++) ok(VecSetValue(*y, i, ode->y0[i], INSERT_VALUES));
  ok(VecAssemble(*y));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, ode->n, ode->n, NULL, &J));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, e->pair == ODE_BATHE ? TSBATHE : TSRK));
  if (e->pair != ODE_BATHE) ok(TSRKSetType(ts, e->pair == ODE_BS32 ? TSRK3BS : TSRK5DP));
  ok(TSSetRHSFunction(ts, NULL, Rhs, (void *)ode));
  ok(TSSetRHSJacobian(ts, J, J, NoJacobian, (void *)ode));
  ok(TSSetMaxTime(ts, ode->end));
  ok(TSSetTimeStep(ts, e->first));
  ok(TSSetMaxSteps(ts, 100000));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  ok(TSSetTolerances(ts, e->tol, NULL, e->tol, NULL));
  ok(TSGetSNES(ts, &snes));
  ok(SNESSetTolerances(snes, 1e-13, 1e-13, 0, 50, 1000));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, policy ? TSADAPTRL : TSADAPTBASIC));
  if (policy) ok(TSAdaptRLSetPolicy(adapt, policy));
  ok(TSSolve(ts, *y));
  ok(TSGetStepNumber(ts, steps));
  ok(TSGetStepRejections(ts, rejected));
  ObjectsDestroy(&ts, &J);
}

/* Explicit pairs: the same attempts as PETSc's, under basic and under a policy. Rounding differs, and a step more or
   less than at the end would need the last step to be cut just so; the episodes are seeded. */
static void as_petsc(void **state)
{
  int seen[ODE_PAIRS] = {0};
  PetscInt rejections = 0;

  for (uint64_t seed = 1; seed <= 12; seed++) {
    SlipPolicy policies[] = {NULL, filter()};
    OdeEpisode e;

    ok(OdeEpisodeCreate(seed, &e));
    for (int k = 0; k < 2 && e.pair != ODE_BATHE; k++) {
      PetscInt steps, rejected;
      OdeResult r;
      Vec y;

      ok(OdeEpisodeRun(&e, policies[k], e.tol, &r));
      by_petsc(&e, policies[k], &steps, &rejected, &y);
      if (r.steps != steps || r.rejected != rejected)
        fail_msg("%s, seed %d, %s: %d steps and %d rejected, PETSc %d and %d", e.ode.kind, (int)seed,
                 k ? "policy" : "basic", (int)r.steps, (int)r.rejected, (int)steps, (int)rejected);
      rejections += rejected;
      ok(VecDestroy(&y));
    }
    seen[e.pair]++;
    ok(SlipPolicyDestroy(&policies[1]));
    ok(OdeEpisodeDestroy(&e));
  }
  assert_true(seen[ODE_BS32] && seen[ODE_DP54] && seen[ODE_BATHE]);
  assert_true(rejections > 20);
}

/* y' = -y + sin t has a solution in closed form: errors of one step of h and h/2 fall with the order of the method plus
   one, 2^4, 2^6 and 2^3 for the solutions, and E with the power that OdeOrder() says. */
static void Decay(const Ode *ode, double t, const double y[], double dy[])
{
  dy[0] = -y[0] + sin(t);
}

static void orders(void **state)
{
  const double of_error[] = {4, 6, 3};
  const Ode ode = {.kind = "decay", .n = 1, .f = Decay, .end = 1, .y0 = {1}};

  for (int pair = 0; pair < ODE_PAIRS; pair++) {
    double error[2], E[2];

    for (int k = 0; k < 2; k++) {
      const double h = 0.1 / (1 + k), exact = 1.5 * exp(-h) + 0.5 * (sin(h) - cos(h));
      OdeStepper s;

      OdeStepperStart(&ode, (OdePair)pair, 1e-9, &s);
      assert_true(OdeAttempt(&s, h));
      error[k] = fabs(s.y1[0] - exact);
      E[k] = s.E;
      OdeAccept(&s, h);
      assert_true(s.t == h && fabs(s.k[0] + s.y[0] - sin(h)) < 1e-10); /* f at the end; Newton's to 1e-12 */
    }
    /* the next term of either is smaller by h and a factor of order one: a tenth of a power */
    assert_true(fabs(log2(error[0] / error[1]) - of_error[pair]) < 0.3);
    assert_true(fabs(log2(E[0] / E[1]) - OdeOrder((OdePair)pair)) < 0.3);
  }
}

/* An episode follows from its seed; basic's own cost is near 0, as the line goes through its runs; more work for the
   same error costs its logarithm. */
static void episodes(void **state)
{
  double sum = 0;

  for (uint64_t seed = 20; seed < 32; seed++) {
    OdeEpisode e, again;
    OdeResult r;

    ok(OdeEpisodeCreate(seed, &e));
    ok(OdeEpisodeCreate(seed, &again));
    assert_true(e.pair == again.pair && e.tol == again.tol && e.n == again.n && e.basic[1] == again.basic[1]);
    assert_memory_equal(e.y, again.y, (size_t)(e.n * e.ode.n) * sizeof(*e.y));
    ok(OdeEpisodeRun(&e, NULL, e.tol, &r));
    assert_true(r.done && fabs(OdeEpisodeCost(&e, &r)) < 0.3); /* what an episode's line may be missed by */
    sum += OdeEpisodeCost(&e, &r);
    r.work *= 2;
    const double more = OdeEpisodeCost(&e, &r);
    r.work /= 2;
    assert_true(fabs(more - OdeEpisodeCost(&e, &r) - log(2)) < 1e-14);
    r.done = PETSC_FALSE;
    assert_true(OdeEpisodeCost(&e, &r) == 3);
    ok(OdeEpisodeDestroy(&e));
    ok(OdeEpisodeDestroy(&again));
  }
  assert_true(fabs(sum / 12) < 0.1);
}

SLIP_TESTS(as_petsc, orders, episodes)
