/* What a step may err by, and where it ends for what stops within it, from formulas of one cell and of parabolas. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/sliprun.h>
#include <math.h>
#include "tempdir.h"

static const PetscReal weakening = 0.05;

/* n cells of 1 km under slip weakening, at their instability, with inertia or without */
static SlipFault Cells(PetscInt n, PetscInt components, PetscBool inertia)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"initial", "traction"}, {"viscosity", "radiation"}));
  ok(FaultSetReals(fault, {"nx", (PetscReal)n}, {"nz", 1}, {"length_x", 1000 * (PetscReal)n}, {"length_z", 1000},
                   {"normal_stress", 50e6}, {"normal_stress_gradient", 0}, {"friction_slip", weakening},
                   {"initial_traction", 1e7}, {"thickness", 1000}));
  if (components > 1) ok(SlipFaultSetReal(fault, "slip_components", 2));
  ok(SlipFaultSetInertia(fault, inertia));
  return fault;
}

/* ---- stops ---- */

/* States with the rate v0 + k t + c t^2 of cell 0 at the shares 0, x and 1 of a step h, and constant rates of the
   others */
typedef struct {
  PetscReal v0, k, c, others; /* [m/s], [m/s^2], [m/s^3] */
  PetscReal x, h;
  PetscReal end; /* the rate at the end where it is below 0; 0: that of the parabola */
} Course;

static PetscReal StopOf(SlipFault fault, const Course *p, PetscReal sign, PetscReal rtol)
{
  const PetscReal at[3] = {0, p->x * p->h, p->h};
  const PetscInt components = fault->layout.components;
  PetscReal stop, *a;
  Vec w[4];

  for (int s = 0; s < 4; s++) {
    const PetscReal parabola =
      s < 3 ? p->v0 + p->k * at[s] + p->c * at[s] * at[s] : p->k; /* the last one is the derivative */
    const PetscReal v = s == 2 && p->end < 0 ? p->end : parabola;

    ok(SlipFaultCreateState(fault, &w[s]));
    ok(VecGetArray(w[s], &a));
    for (PetscInt i = 0; i < fault->mesh.n; i++) {
      const PetscReal value = sign * (i ? (s < 3 ? p->others : 0) : v);

      /* of two components along 3, 4 */
      for (PetscInt k = 0; k < components; k++)
        a[SlipFaultRateAt(fault, i) + k] = value * (components == 1 ? 1 : k ? 0.8 : 0.6);
    }
    ok(VecRestoreArray(w[s], &a));
  }
  ok(SlipFaultStop(fault, p->h, rtol, p->x, w, w[3], &stop));
  for (int s = 0; s < 4; s++) ok(VecDestroy(&w[s]));
  return stop;
}

/* The stop of a parabola is its root, after the state in between; before that one it is where the tangent at the start
   ends, or that state. */
static void stops(void **state)
{
  const Course after = {1, -1, -0.25, 0, 0.586, 1, 0}, before = {1, -2, 0, 0, 0.586, 1, 0},
               late = {1, -1, -1, 0, 0.8, 1, 0};
  const Course ends = {1, -1, 0, 0, 0.5, 1, 0}, meets = {1, -1, -2, 0, 0.5, 1, 0}, back = {1, -10, 20, 0, 0.8, 1, -1};
  const Course grows = {1, 0.5, -4, 0, 0.9, 1, 0}, moves = {1, -0.5, 0, 0, 0.586, 1, 0},
               still = {0, 0, 0, 1, 0.586, 1, 0};

  for (PetscInt components = 1; components <= 2; components++) {
    SlipFault fault = Cells(3, components, PETSC_TRUE);

    ok(SlipFaultSetUp(fault));
    for (int sign = -1; sign <= 1; sign += 2) {
      Course p = after;

      /* 1 - t - t^2/4 = 0 at 2 (sqrt 2 - 1), three fourths of the step */
      assert_true(fabs(StopOf(fault, &after, sign, 1e-9) - 2 * (sqrt(2) - 1)) < 1e-14);
      assert_true(fabs(StopOf(fault, &before, sign, 1e-9) - 0.5) < 1e-14);
      assert_true(fabs(StopOf(fault, &late, sign, 1e-9) - 0.8) <
                  1e-14); /* 1 - t - t^2 ends at 0.618, its tangent at 1 */
      assert_true(fabs(StopOf(fault, &grows, sign, 1e-9) - 0.9) < 1e-14);
      assert_true(StopOf(fault, &moves, sign, 1e-9) == PETSC_MAX_REAL &&
                  StopOf(fault, &still, sign, 1e-9) == PETSC_MAX_REAL);
      /* rates that are 0 at the end, and in between; a parabola that is 0 twice before says nothing of the end */
      assert_true(fabs(StopOf(fault, &ends, sign, 1e-9) - 1) < 1e-14 &&
                  fabs(StopOf(fault, &meets, sign, 1e-9) - 0.5) < 1e-14);
      assert_true(StopOf(fault, &back, sign, 1e-9) == 1);
      /* a stop counts of the cell with half of the rates, of 1 among two of 0.49 and of 0.51 */
      p.others = 0.49;
      assert_true(StopOf(fault, &p, sign, 1e-9) < 1);
      p.others = 0.51;
      assert_true(StopOf(fault, &p, sign, 1e-9) == PETSC_MAX_REAL);
      /* slip of v0 t is small below 0.03 of rtol d_c */
      assert_true(StopOf(fault, &before, sign, 0.99 * 0.5 / (0.03 * weakening)) < 1);
      assert_true(StopOf(fault, &before, sign, 1.01 * 0.5 / (0.03 * weakening)) == PETSC_MAX_REAL);
    }
    ok(SlipFaultDestroy(&fault));
  }
}

/* ---- errors ---- */

/* Of one cell: slip u and rate v at the start, how far it moves, and the errors of slip, rate and opening */
typedef struct {
  PetscReal u, v, moved, slip, rate, opening;
} Errors;

static PetscReal ErrorOf(SlipFault fault, PetscReal rtol, const Errors *of)
{
  PetscReal E, *a;
  Vec e, w[2];

  ok(SlipFaultCreateState(fault, &e));
  for (int k = 0; k < 2; k++) {
    ok(SlipFaultCreateState(fault, &w[k]));
    ok(VecGetArray(w[k], &a));
    a[SlipFaultRateAt(fault, 0)] = of->v;
    a[SlipFaultDisplacementAt(fault, 0)] = a[SlipFaultStateAt(fault, 0)] = of->u + (k ? of->moved : 0);
    ok(VecRestoreArray(w[k], &a));
  }
  ok(VecGetArray(e, &a));
  a[SlipFaultRateAt(fault, 0)] = of->rate;
  a[SlipFaultDisplacementAt(fault, 0)] = of->slip;
  if (SlipFaultOpens(fault)) a[SlipFaultDisplacementAt(fault, 0) + 2] = of->opening;
  ok(VecRestoreArray(e, &a));
  ok(SlipFaultErrorNorm(fault, rtol, 0, 1e-3, e, w[0], w[1], &E));
  ObjectsDestroy(&e, &w[0], &w[1]);
  return E;
}

/* The one entry of a matrix of one cell */
static PetscReal EntryOf(Mat A)
{
  PetscReal value;
  Vec diagonal;

  ok(MatCreateVecs(A, &diagonal, NULL));
  ok(MatGetDiagonal(A, diagonal));
  ok(VecSum(diagonal, &value));
  ok(VecDestroy(&diagonal));
  return value;
}

/* Without inertia an error e of the slip is one of the rate of e K/(H + theta K), against ten times rtol of the largest
   rate, which is at least rtol d_c K/H; slips count against d_c. */
static void slip_and_rate(void **state)
{
  const PetscReal rtol = 1e-3, u = 0.01, e = 1e-5;
  PetscReal K, H;
  SlipFault fault = Cells(1, 1, PETSC_FALSE);
  Mat k, damping;

  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetOperators(fault, &k, &damping, NULL));
  K = EntryOf(k);
  H = EntryOf(damping);
  for (int m = 0; m < 3; m++) {
    const PetscReal theta = m == 0 ? 0 : m == 1 ? H / K : 100 * H / K;
    const PetscReal fast = 1e-3 * weakening * K / H, slow = 1e-6 * weakening * K / H; /* rates */

    for (int quick = 0; quick < 2; quick++) {
      const PetscReal v = quick ? fast : slow;
      const PetscReal rate = e * K / (H + theta * K) / (10 * rtol * (v + rtol * weakening * K / H));

      fault->stage.theta = theta;
      AssertNear(ErrorOf(fault, rtol, &(Errors){.u = u, .v = v, .slip = e}) / PetscMax(rate, e / weakening / rtol), 1,
                 1e-12);
    }
  }
  ok(SlipFaultDestroy(&fault));
}

/* The slip of a step counts by its cube, times the share of the weakening rate that is left; with inertia a rate lasts,
   and its error is that of the slip that it leads to while the cell swings, against a twentieth of the tolerance. */
static void cube_and_swing(void **state)
{
  const PetscReal rtol = 1e-3, share = 0.2;
  PetscReal mass;
  SlipFault fault = Cells(1, 1, PETSC_FALSE);
  Mat K;

  ok(SlipFaultSetUp(fault));
  for (int k = 0; k < 3; k++)
    AssertNear(ErrorOf(fault, rtol, &(Errors){.u = k * weakening, .moved = share * weakening}) /
                 (exp(-k) * share * share * share / (0.5 * rtol)),
               1, 1e-12);
  ok(SlipFaultDestroy(&fault));
  fault = Cells(1, 1, PETSC_TRUE);
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetOperators(fault, &K, NULL, &mass));
  AssertNear(ErrorOf(fault, rtol, &(Errors){.rate = 1e-4}) /
               (1e-4 / (0.05 * rtol * weakening * sqrt(EntryOf(K) / mass))),
             1, 1e-12);
  ok(SlipFaultDestroy(&fault));
}

/* What the pressure may be off by is worth a slip of so much of d_c, or where a smooth law answers to less, of a sigma;
   where cells open it counts itself, not times the friction. */
static void pressure(void **state)
{
  const PetscReal relative = 1e-3, a = 0.01, b = 0.015, dc = 0.5, v = 1e-9;
  PetscReal tolerance, shear, *x;

  for (int opens = 0; opens < 2; opens++) {
    SlipFault fault = Cells(1, opens ? 2 : 1, PETSC_FALSE);
    Mat K;
    Vec d;
    Vec w;

    ok(SlipFaultSetString(fault, "friction_law", opens ? "linear_slip_weakening" : "rate_and_state"));
    ok(FaultSetReals(fault, {"depth_top", 1000}, {"friction_a", a}, {"friction_b", b}));
    if (opens)
      ok(SlipFaultSetBool(fault, "opening", PETSC_TRUE));
    else
      ok(FaultSetReals(fault, {"friction_slip", dc}, {"initial_traction", 3e7}, {"initial_rate", v}));
    ok(FaultSetUpState(fault, &w));
    ok(SlipFaultGetOperators(fault, &K, NULL, NULL));
    if (opens) ok(VecStrideSet(w, fault->layout.displacement, 2 * weakening));
    ok(SlipFaultLoadTolerance(fault, relative, 0, w, &tolerance, &shear));
    if (opens) {
      ok(SlipFaultGetWork(fault, &d));
      ok(MatGetDiagonal(K, d));
      ok(VecGetArray(d, &x));
      AssertNear(tolerance / (relative * x[0] * weakening), 1, 1e-12);
      AssertNear(shear / tolerance, 1, 1e-12);
      ok(VecRestoreArray(d, &x));
      ok(SlipFaultRestoreWork(fault, &d));
    } else {
      assert_true(a * 50e6 < EntryOf(K) * dc);
      /* the start's traction of 30 MPa at 50 MPa is the friction of 0.6 but for the radiation of 1e-9 m/s */
      AssertNear(tolerance / (relative * a * 50e6 / 0.6), 1, 1e-8);
      AssertNear(shear / (relative * a * 50e6), 1, 1e-12);
    }
    ObjectsDestroy(&w, &fault);
  }
}

/* What opens a cell counts as slip does. */
static void opening(void **state)
{
  const PetscReal rtol = 1e-3, u = 0.01, e = 1e-5;
  SlipFault fault = Cells(1, 2, PETSC_FALSE);

  ok(FaultSetReals(fault, {"depth_top", 1000}));
  ok(SlipFaultSetBool(fault, "opening", PETSC_TRUE));
  ok(SlipFaultSetString(fault, "friction_law", "linear_slip_weakening"));
  ok(SlipFaultSetUp(fault));
  fault->stage.theta = 1e6; /* so that rates do not count */
  AssertNear(ErrorOf(fault, rtol, &(Errors){.u = u, .slip = e}) / (e / weakening / rtol), 1, 1e-12);
  AssertNear(ErrorOf(fault, rtol, &(Errors){.u = u, .slip = e, .opening = 3 * e}) / (3 * e / weakening / rtol), 1,
             1e-12);
  AssertNear(ErrorOf(fault, rtol, &(Errors){.u = u, .slip = e, .opening = -3 * e}) / (3 * e / weakening / rtol), 1,
             1e-12);
  AssertNear(ErrorOf(fault, rtol, &(Errors){.u = u, .slip = 3 * e, .opening = e}) / (3 * e / weakening / rtol), 1,
             1e-12);
  ok(SlipFaultDestroy(&fault));
}

/* ---- the estimate of a run's error ---- */

/* What the error e of a step changes the work by, M v.e_v + K u.e_u + q.e_s, where slip has changed the normal stress
   of q, as it does where a fault dips: after one step, from the state, the strength and K themselves. */
static void work_of_an_error(void **state)
{
  enum { CELLS = 6 };
  PetscReal sigma[CELLS], scale, mass, work = 0, change = 0;
  const PetscReal *a, *e, *f;
  SlipFrictionCells friction;
  SlipFault fault;
  Vec w, error, u, ku;
  Mat K;
  TS ts;
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];

  assert_int_equal(0, TempDirFile("tolerance", "o.h5", dir, file));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "output", file));
  ok(FaultSetReals(fault, {"nx", 3}, {"nz", 2}, {"dip", 40}, {"rake", 90}, {"depth_top", 500}));
  ok(FaultStart(fault, TSADAPTNONE, 0.5, 0, &w, &ts));
  ok(TSSetMaxSteps(ts, 1));
  ok(TSSetSolution(ts, w));
  ok(SlipFaultOutputStart(fault, ts));
  ok(TSSolve(ts, w));
  ok(TSBatheGetEstimates(ts, &error, &scale, NULL));
  assert_non_null(error);
  ok(SlipFaultGetOperators(fault, &K, NULL, &mass));
  ok(SlipFaultGetCellValues(fault, 0.5, w, "normal_stress", CELLS, sigma));
  ok(SlipFaultGetFriction(fault, 0, &friction));
  ok(MatCreateVecs(K, &u, &ku));
  ok(SlipFaultGetDisplacement(fault, w, u));
  ok(MatMult(K, u, ku));
  a = VecRead(w);
  e = VecRead(error);
  f = VecRead(ku);
  for (PetscInt i = 0; i < CELLS; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, &a[3 * i + 2], fabs(a[3 * i]), &mu, &ds, &dv);
    work += mass * a[3 * i] * e[3 * i] + f[i] * e[3 * i + 1] + mu * sigma[i] * e[3 * i + 2];
    change += mu * (sigma[i] - fault->fields.cell[FIELD_NORMAL_STRESS][i]) * e[3 * i + 2];
  }
  /* sums of terms that cancel in part, each to rounding; what slip has changed is far more */
  assert_true(fabs(change) > 1e-4 * fabs(work));
  AssertNear(fault->run->error.work[0] / (scale * work), 1, 1e-9);
  ObjectsDestroy(&u, &ku, &w, &ts, &fault);
  assert_int_equal(0, TempDirRemove(dir));
}

SLIP_TESTS(stops, slip_and_rate, cube_and_swing, pressure, opening, work_of_an_error)
