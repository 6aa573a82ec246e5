/* TSADAMS and its weights: exactness, order, error against tolerance, cost, interpolation, attempts that are
   refused. */
#include "../lotka.h"
#include "../unit.h"
#include <slipstep/rooms/slipcore.h>
#include <petsc/private/tsimpl.h>
#include <math.h>

/* Weights integrate polynomials of less than n nodes' degree exactly. Rounding grows with the sum of their
   magnitudes. */
static void weights(void **state)
{
  const PetscReal node[][SLIP_ADAMS_NODES] = {{1, 0, -1, -2, -3, -4, -5, -6, -7, -8},
                                              {0, -0.3, -2, -2.5, -4, -4.4, -7, -7.7, -9, -9.1},
                                              {1, 0, -1e5, -1.1e5, -1.3e5, -2e5, -3e5, -4e5, -5e5, -6e5}};

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

static void End(TS ts, Vec u, PetscReal x[2])
{

  ok(TSSolve(ts, u));
  x[0] = VecRead(u)[0];
  x[1] = VecRead(u)[1];
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
  ObjectsDestroy(&ts, &u);
}

/* Constant steps: the first one is of order 2 whatever comes later and leaves h^3, so that orders 2 and 3 show. Halving
   the step divides the error by 2^order, to the part that the next term is of it at these steps. */
static void order(void **state)
{
  PetscReal exact[2];

  Exact(exact);
  for (PetscInt max = 1; max <= 2; max++) {
    PetscReal error[2], x[2];

    for (int k = 0; k < 2; k++) {
      TS ts;
      Vec u;

      Make(&ts, &u, TSADAMS, END / (1600 << k));
      ok(TSAdamsSetMaxOrder(ts, max));
      SetAdapt(ts, TSADAPTNONE);
      End(ts, u, x);
      error[k] = hypot(x[0] - exact[0], x[1] - exact[1]);
      assert_true(evaluations == 2 * (1600 << k) + 1);
      ObjectsDestroy(&ts, &u);
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
  ObjectsDestroy(&ts, &u);
  return hypot(x[0] - exact[0], x[1] - exact[1]);
}

/* The error follows the tolerance over seven decades, and an error costs fewer right-hand sides than with the pairs.
   1000: the solution's growth of errors over the eight units of time, measured by a start that is off by 1e-6, is 9; a
   hundred steps add their errors up. */
static void adaptive(void **state)
{
  PetscReal exact[2], before = 1;

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

  if (step < 8 || t > END - 1e-9) return PETSC_SUCCESS;
  PetscCall(TSGetPrevTime(ts, &before));
  PetscCall(VecDuplicate(u, &x));
  for (int k = 0; k < 3; k++) {
    const PetscScalar *a;

    PetscCall(TSInterpolate(ts, before + 0.5 * k * (t - before), x));
    a = VecRead(x);
    kept[k] = a[0] - log(a[0]) + a[1] - log(a[1]);
  }
  worst = PetscMax(worst, fabs(kept[1] - 0.5 * (kept[0] + kept[2])));
  return VecDestroy(&x);
}

static void interpolation(void **state)
{
  PetscReal error[2], x[2];

  for (int k = 0; k < 2; k++) {
    TS ts;
    Vec u;

    Make(&ts, &u, TSADAMS, END / (50 << k));
    SetAdapt(ts, TSADAPTNONE);
    worst = 0;
    ok(TSMonitorSet(ts, Look, NULL, NULL));
    End(ts, u, x);
    error[k] = worst;
    ObjectsDestroy(&ts, &u);
  }
  assert_true(log2(error[0] / error[1]) > 3.5); /* the cubic is off by h^4 */
}

/* ---- attempts that are refused ---- */

/* y' = -y, whose domain ends once: at the first state asked about in the step after refuse_at accepted ones */
static PetscInt refuse_at;

static PetscErrorCode Fall(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  PetscCall(VecCopy(y, f));
  return VecScale(f, -1);
}

static PetscErrorCode FallJacobian(TS ts, PetscReal t, Vec y, Mat A, Mat B, void *ctx)
{
  PetscCall(MatZeroEntries(B));
  return MatShift(B, -1);
}

static PetscErrorCode Inside(TS ts, PetscReal t, Vec y, PetscBool *inside)
{
  PetscInt step;

  PetscCall(TSGetStepNumber(ts, &step));
  *inside = step == refuse_at ? PETSC_FALSE : PETSC_TRUE;
  if (!*inside) refuse_at = -1;
  return PETSC_SUCCESS;
}

static void MakeScalar(TS *ts, Vec *y, const char type[], const char adapt[], TSRHSFunction rate, PetscReal dt,
                       PetscReal end)
{
  ok(VecCreateSeq(PETSC_COMM_SELF, 1, y));
  *ts = MakeTS(type, dt, end);
  ok(TSSetProblemType(*ts, TS_NONLINEAR));
  ok(TSSetRHSFunction(*ts, NULL, rate, NULL));
  ok(TSSetMaxStepRejections(*ts, -1));
  SetAdapt(*ts, adapt);
}

static PetscReal value[16], when[16];

static PetscErrorCode Keep(TS ts, PetscInt step, PetscReal t, Vec y, void *ctx)
{
  if (step < 16) {
    PetscCall(VecMax(y, NULL, &value[step]));
    when[step] = t;
  }
  return PETSC_SUCCESS;
}

/* An attempt that leaves the domain is followed by one of a quarter of its step (PETSc's scale for solves that failed)
   and of the lowest order, by which one step is Euler's and the trapezoids after it, to rounding: y (1 - h + h^2/2).
   basic with a clip of 1 has steps of 0.1 until then; constant ones end the run. */
static void begins_anew(void **state)
{
  const PetscReal h = 0.1 / 4;
  TSAdapt adapt;
  TS ts;
  Vec y;

  MakeScalar(&ts, &y, TSADAMS, TSADAPTNONE, Fall, 0.1, 1);
  ok(VecSet(y, 1));
  ok(TSSetFunctionDomainError(ts, Inside));
  refuse_at = 6;
  fails(TSSolve(ts, y),
        "At time 0.6 s a constant step of 0.1 s leads to what is no state of the problem (-ts_type adams)");
  ObjectsDestroy(&ts, &y);
  MakeScalar(&ts, &y, TSADAMS, TSADAPTBASIC, Fall, 0.1, 1);
  ok(VecSet(y, 1));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetClip(adapt, 1, 1));
  ok(TSAdaptSetAlwaysAccept(adapt, PETSC_TRUE));
  ok(TSSetFunctionDomainError(ts, Inside));
  ok(TSMonitorSet(ts, Keep, NULL, NULL));
  refuse_at = 6;
  ok(TSSolve(ts, y));
  assert_true(refuse_at == -1 && fabs(when[7] - when[6] - h) < 1e-14);
  assert_true(fabs(value[7] / value[6] - (1 - h + h * h / 2)) < 1e-14);
  ObjectsDestroy(&ts, &y);
}

/* y' = 2 - y from 0, 2 - 2 exp(-t), up to y = 1, beyond which the rate is no number */
static PetscErrorCode Edge(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  const PetscScalar a = VecRead(y)[0];

  return VecSet(f, a < 1 ? 2 - a : NAN);
}

static PetscErrorCode IsNumber(TS ts, PetscInt step, PetscReal t, Vec y, void *ctx)
{
  PetscReal a;

  PetscCall(VecSum(y, &a));
  assert_true(isfinite(a));
  return PETSC_SUCCESS;
}

/* States that are no numbers are refused under every controller, and where no shorter step helps the run ends and names
   time and step, which is below the rounding of time by then; constant ones end it at once. 0.01: constant steps of
   0.05 are exact to 0.05^2. */
static void numbers_only(void **state)
{
  const char *const adapts[] = {TSADAPTNONE, TSADAPTBASIC, TSADAPTDSP, TSADAPTPI, TSADAPTHEURISTIC};

  for (int k = 0; k < 10; k++) {
    TS ts;
    Vec y;
    PetscReal a;

    MakeScalar(&ts, &y, TSADAMS, adapts[k / 2], Edge, 0.05, k % 2 ? 110 : 100.69);
    ok(VecSet(y, 0));
    ok(TSSetTime(ts, 100));
    ok(TSMonitorSet(ts, IsNumber, NULL, NULL));
    if (k % 2) {
      fails(TSSolve(ts, y),
            k / 2 ? "below the rounding of that time" : "a constant step of 0.05 s leads to what is no state");
    } else {
      ok(TSSolve(ts, y));
      ok(VecMax(y, NULL, &a));
      assert_true(fabs(a - (2 - 2 * exp(-0.69))) < 0.01);
    }
    ObjectsDestroy(&ts, &y);
  }
}

/* Constant steps that a corner of the loading cuts go on as they were. */
static PetscErrorCode Corner(TS ts, PetscReal t, PetscReal *next, void *ctx)
{
  const PetscReal at = *(const PetscReal *)ctx;

  *next = t < at ? at : PETSC_MAX_REAL;
  return PETSC_SUCCESS;
}

static void corner(void **state)
{
  static const SlipProblemOps problem = {.steps = {.corner = Corner}};
  PetscReal at = 0.375;
  const PetscReal want[] = {0, 0.25, 0.375, 0.625, 0.875, 1.125, 1.375};
  const char *const types[] = {TSADAMS, TSBATHE};

  for (int k = 0; k < 2; k++) {
    PetscInt steps;
    TS ts;
    Vec y;
    Mat J;

    MakeScalar(&ts, &y, types[k], TSADAPTNONE, Fall, 0.25, 1.375);
    ok(VecSet(y, 1));
    ok(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &J));
    ok(TSSetRHSJacobian(ts, J, J, FallJacobian, NULL));
    ok(TSSetSlipProblem(ts, &problem, &at));
    ok(TSMonitorSet(ts, Keep, NULL, NULL));
    ok(TSSolve(ts, y));
    ok(TSGetStepNumber(ts, &steps));
    assert_int_equal(steps, 6);
    for (PetscInt i = 0; i <= 6; i++) assert_true(when[i] == want[i]);
    ObjectsDestroy(&ts, &y, &J);
  }
}

/* Controllers that go by the error keep below three relaxation times where the problem knows them and steps are
   corrected once, constant steps stay. */
static PetscErrorCode Relaxes(TS ts, Vec w, PetscReal *rate, void *ctx)
{
  *rate = 100;
  return PETSC_SUCCESS;
}

static void bounded(void **state)
{
  static const SlipProblemOps problem = {.steps = {.relaxation = Relaxes}};
  const char *const adapts[] = {TSADAPTBASIC, TSADAPTPI, TSADAPTNONE};

  ok(PetscOptionsSetValue(NULL, "-ts_adams_max_corrections", "1"));
  for (int k = 0; k < 3; k++) {
    TS ts;
    Vec y;

    MakeScalar(&ts, &y, TSADAMS, adapts[k], Fall, 0.0625, 1);
    ok(TSSetFromOptions(ts));
    SetAdapt(ts, adapts[k]);
    ok(VecSet(y, 1));
    ok(TSSetTolerances(ts, 1e-2, NULL, 1e-2, NULL));
    ok(TSSetSlipProblem(ts, &problem, NULL));
    ok(TSMonitorSet(ts, Keep, NULL, NULL));
    ok(TSSolve(ts, y));
    for (int i = 2; i < 16; i++) assert_true(fabs(when[i] - when[i - 1] - (k < 2 ? 0.03 : 0.0625)) < 1e-14);
    ObjectsDestroy(&ts, &y);
  }
  ok(PetscOptionsClearValue(NULL, "-ts_adams_max_corrections"));
}

/* u' = cos t - r (u - sin t) of rates r up to 100, from u = 0: u = sin t. With more corrections than one the error
   keeps the tolerance, for less than 0.6 of the right-hand sides of one, also under pi, which never asks for a step so
   much longer that the second correction pays. */
static PetscErrorCode Follow(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  const PetscScalar *x;
  PetscScalar *r;

  evaluations++;
  x = VecRead(u);
  PetscCall(VecGetArrayWrite(f, &r));
  for (int i = 0; i < 8; i++) r[i] = cos(t) - 100.0 / (1 << i) * (x[i] - sin(t));
  return VecRestoreArrayWrite(f, &r);
}

static void CorrectedBy(const char adapt[])
{
  static const SlipProblemOps problem = {.steps = {.relaxation = Relaxes}};
  PetscInt n[2];

  for (int k = 0; k < 2; k++) {
    const PetscScalar *x;
    TS ts;
    Vec u;

    ok(PetscOptionsSetValue(NULL, "-ts_adams_max_corrections", k ? "7" : "1"));
    ok(VecCreateSeq(PETSC_COMM_SELF, 8, &u));
    ts = MakeTS(TSADAMS, 1e-3, 20);
    ok(TSSetProblemType(ts, TS_NONLINEAR));
    ok(TSSetRHSFunction(ts, NULL, Follow, NULL));
    SetAdapt(ts, adapt);
    ok(TSSetTolerances(ts, 1e-2, NULL, 0, NULL));
    ok(TSSetSlipProblem(ts, &problem, NULL));
    ok(TSSetFromOptions(ts));
    evaluations = 0;
    ok(TSSolve(ts, u));
    n[k] = evaluations;
    x = VecRead(u);
    for (int i = 0; i < 8; i++) AssertNear(x[i], sin(20), 1e-2);
    ObjectsDestroy(&ts, &u);
  }
  ok(PetscOptionsClearValue(NULL, "-ts_adams_max_corrections"));
  AssertLess((PetscReal)n[1], 0.6 * (PetscReal)n[0]);
}

static void corrected(void **state)
{
  CorrectedBy(TSADAPTBASIC);
  CorrectedBy(TSADAPTPI);
}

/* Late times, whose rounding is a thousandth of a step, cost no steps where the rate does not know of time: 2 % for the
   rounding of the time that is integrated. */
static void late(void **state)
{
  PetscInt steps[2];

  for (int k = 0; k < 2; k++) {
    const PetscReal start = k ? 1e10 : 0; /* rounded to 1.9e-6 */
    PetscReal x[2];
    TS ts;
    Vec u;

    Make(&ts, &u, TSADAMS, 1e-3);
    ok(TSSetTolerances(ts, 1e-11, NULL, 1e-11, NULL));
    ok(TSSetTime(ts, start));
    ok(TSSetMaxTime(ts, start + END));
    End(ts, u, x);
    ok(TSGetStepNumber(ts, &steps[k]));
    ObjectsDestroy(&ts, &u);
  }
  if (abs((int)(steps[1] - steps[0])) > steps[0] / 50) fail_msg("%d and %d steps", (int)steps[0], (int)steps[1]);
}

static void refuses(void **state)
{
  TS ts;

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSADAMS));
  fails(TSAdamsSetMaxOrder(ts, 0), "-ts_adams_max_order is 0");
  fails(TSAdamsSetMaxOrder(ts, 9), "-ts_adams_max_order is 9");
  ok(TSSetType(ts, TSRK));
  ok(TSAdamsSetMaxOrder(ts, 99));
  ok(TSDestroy(&ts));
}

SLIP_TESTS(weights, order, adaptive, interpolation, begins_anew, numbers_only, corner, bounded, corrected, late,
           refuses)
