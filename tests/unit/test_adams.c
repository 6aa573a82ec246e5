/* TSADAMS and its weights: exactness, order, error against tolerance, cost, interpolation. */
#include "../unit.h"
#include <slipcore.h>
#include <math.h>

/* Weights integrate polynomials of less than n nodes' degree exactly. Rounding grows with the sum of their magnitudes. */
static void weights(void **state)
{
  const PetscReal node[][SLIP_ADAMS_NODES] = {{1, 0, -1, -2, -3, -4, -5, -6, -7, -8},
                                              {0, -0.3, -2, -2.5, -4, -4.4, -7, -7.7, -9, -9.1},
                                              {1, 0, -1e5, -1.1e5, -1.3e5, -2e5, -3e5, -4e5, -5e5, -6e5}};

  (void)state;
  for (size_t s = 0; s < 3; s++)
    for (PetscInt n = 1; n <= SLIP_ADAMS_NODES; n++) {
      PetscReal w[SLIP_ADAMS_NODES];

      SlipAdamsWeights(n, node[s], w);
      for (PetscInt r = 0; r < n; r++) {
        PetscReal sum = 0, all = 0;

        for (PetscInt j = 0; j < n; j++) {
          sum += w[j] * pow(node[s][j], (double)r);
          all += fabs(w[j] * pow(node[s][j], (double)r));
        }
        assert_true(fabs(sum - 1.0 / (double)(r + 1)) <= 1e3 * PETSC_MACHINE_EPSILON * (1 + all));
      }
    }
}

/* Lotka's and Volterra's: x' = x (1 - y), y' = y (x - 1), which keeps x - ln x + y - ln y */
static PetscInt evaluations;

static PetscErrorCode Rate(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  const PetscScalar *x;
  PetscScalar *r;

  PetscFunctionBeginUser;
  (void)ts, (void)t, (void)ctx;
  evaluations++;
  PetscCall(VecGetArrayRead(u, &x));
  PetscCall(VecGetArrayWrite(f, &r));
  r[0] = x[0] * (1 - x[1]);
  r[1] = x[1] * (x[0] - 1);
  PetscCall(VecRestoreArrayWrite(f, &r));
  PetscCall(VecRestoreArrayRead(u, &x));
  PetscFunctionReturn(0);
}

#define END 8.0

static void Make(TS *ts, Vec *u, const char type[], PetscReal dt)
{
  ok(VecCreateSeq(PETSC_COMM_SELF, 2, u));
  ok(VecSetValues(*u, 2, (const PetscInt[]){0, 1}, (const PetscScalar[]){2, 0.5}, INSERT_VALUES));
  ok(VecAssemblyBegin(*u));
  ok(VecAssemblyEnd(*u));
  ok(TSCreate(PETSC_COMM_SELF, ts));
  ok(TSSetProblemType(*ts, TS_NONLINEAR));
  ok(TSSetType(*ts, type));
  ok(TSSetRHSFunction(*ts, NULL, Rate, NULL));
  ok(TSSetTimeStep(*ts, dt));
  ok(TSSetMaxTime(*ts, END));
  ok(TSSetMaxSteps(*ts, 1000000));
  ok(TSSetExactFinalTime(*ts, TS_EXACTFINALTIME_MATCHSTEP));
  evaluations = 0;
}

static void End(TS ts, Vec u, PetscReal x[2])
{
  const PetscScalar *a;

  ok(TSSolve(ts, u));
  ok(VecGetArrayRead(u, &a));
  x[0] = a[0];
  x[1] = a[1];
  ok(VecRestoreArrayRead(u, &a));
}

/* By an eighth order pair at its tightest */
static void Exact(PetscReal x[2])
{
  TS ts;
  Vec u;

  Make(&ts, &u, TSRK, 1e-2);
  ok(TSRKSetType(ts, TSRK8VR));
  ok(TSSetTolerances(ts, 1e-14, NULL, 1e-14, NULL));
  End(ts, u, x);
  ok(TSDestroy(&ts));
  ok(VecDestroy(&u));
}

/* Constant steps: the first one is of order 2 whatever comes later and leaves h^3, so that orders 2 and 3 show. Halving
   the step divides the error by 2^order, to the part that the next term is of it at these steps. */
static void order(void **state)
{
  PetscReal exact[2];

  (void)state;
  Exact(exact);
  for (PetscInt max = 1; max <= 2; max++) {
    PetscReal error[2], x[2];

    for (int k = 0; k < 2; k++) {
      TS ts;
      Vec u;
      TSAdapt adapt;

      Make(&ts, &u, TSADAMS, END / (1600 << k));
      ok(TSAdamsSetMaxOrder(ts, max));
      ok(TSGetAdapt(ts, &adapt));
      ok(TSAdaptSetType(adapt, TSADAPTNONE));
      End(ts, u, x);
      error[k] = hypot(x[0] - exact[0], x[1] - exact[1]);
      assert_true(evaluations == 2 * (1600 << k) + 1);
      ok(TSDestroy(&ts));
      ok(VecDestroy(&u));
    }
    assert_true(fabs(log2(error[0] / error[1]) - (double)(max + 1)) < 0.1);
  }
}

static PetscReal Adaptive(const char type[], const char pair[], PetscReal tolerance, const PetscReal exact[2],
                          PetscInt *n)
{
  PetscReal x[2];
  TS ts;
  Vec u;

  Make(&ts, &u, type, 1e-3);
  if (pair) ok(TSRKSetType(ts, pair));
  ok(TSSetTolerances(ts, tolerance, NULL, tolerance, NULL));
  End(ts, u, x);
  *n = evaluations;
  ok(TSDestroy(&ts));
  ok(VecDestroy(&u));
  return hypot(x[0] - exact[0], x[1] - exact[1]);
}

/* The error follows the tolerance over seven decades, and an error costs fewer right-hand sides than with the pairs. 1000: the
   solution's growth of errors over the eight units of time, measured by a start that is off by 1e-6, is 9; a hundred
   steps add their errors up. */
static void adaptive(void **state)
{
  PetscReal exact[2], before = 1;

  (void)state;
  Exact(exact);
  for (PetscReal tolerance = 1e-3; tolerance > 1e-11; tolerance *= 0.1) {
    PetscInt n, other;
    PetscReal error = Adaptive(TSADAMS, NULL, tolerance, exact, &n);

    assert_true(error < 1000 * tolerance && error < before);
    before = 2 * error;
    if (tolerance < 1e-7) {
      /* at least as exact as the pair, whose tolerance is chosen so that it is not, and cheaper */
      assert_true(Adaptive(TSRK, TSRK3BS, 10 * tolerance, exact, &other) > 0 && other > n);
    }
  }
}

/* Between the ends of a step to the third order, at them exactly */
static PetscReal worst;

static PetscErrorCode Look(TS ts, PetscInt step, PetscReal t, Vec u, void *ctx)
{
  PetscReal before, kept[3];
  Vec x;

  PetscFunctionBeginUser;
  (void)ctx;
  if (step < 8 || t > END - 1e-9) PetscFunctionReturn(0);
  PetscCall(TSGetPrevTime(ts, &before));
  PetscCall(VecDuplicate(u, &x));
  for (int k = 0; k < 3; k++) {
    const PetscScalar *a;

    PetscCall(TSInterpolate(ts, before + 0.5 * k * (t - before), x));
    PetscCall(VecGetArrayRead(x, &a));
    kept[k] = a[0] - log(a[0]) + a[1] - log(a[1]);
    PetscCall(VecRestoreArrayRead(x, &a));
  }
  worst = PetscMax(worst, fabs(kept[1] - 0.5 * (kept[0] + kept[2])));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(0);
}

static void interpolation(void **state)
{
  PetscReal error[2], x[2];

  (void)state;
  for (int k = 0; k < 2; k++) {
    TS ts;
    Vec u;
    TSAdapt adapt;

    Make(&ts, &u, TSADAMS, END / (50 << k));
    ok(TSGetAdapt(ts, &adapt));
    ok(TSAdaptSetType(adapt, TSADAPTNONE));
    worst = 0;
    ok(TSMonitorSet(ts, Look, NULL, NULL));
    End(ts, u, x);
    error[k] = worst;
    ok(TSDestroy(&ts));
    ok(VecDestroy(&u));
  }
  assert_true(log2(error[0] / error[1]) > 3.5); /* the cubic is off by h^4 */
}

static void refuses(void **state)
{
  TS ts;

  (void)state;
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSADAMS));
  fails(TSAdamsSetMaxOrder(ts, 0), "-ts_adams_max_order is 0, expected a whole number from 1 to 8");
  fails(TSAdamsSetMaxOrder(ts, 9), "-ts_adams_max_order is 9");
  ok(TSSetType(ts, TSRK));
  ok(TSAdamsSetMaxOrder(ts, 99));
  ok(TSDestroy(&ts));
}

SLIP_TESTS(weights, order, adaptive, interpolation, refuses)
