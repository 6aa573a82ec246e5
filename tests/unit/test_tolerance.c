/* What a step may err by, and where it ends for what stops within it, from formulas of one cell and of parabolas. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include "tempdir.h"

static const PetscReal weakening = 0.05;

/* n cells of 1 km under slip weakening, at their instability, with inertia or without */
static SlipFault Cells(PetscInt n, PetscInt components, PetscBool inertia)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", (PetscReal)n}, {"nz", 1}, {"length_x", 1000 * (PetscReal)n}, {"length_z", 1000},
                   {"normal_stress", 50e6}, {"normal_stress_gradient", 0}, {"friction_slip", weakening},
                   {"initial_traction", 1e7}, {"thickness", 1000}));
  ok(SlipFaultSetString(fault, "initial", "traction"));
  ok(SlipFaultSetString(fault, "viscosity", "radiation"));
  if (components > 1) ok(SlipFaultSetReal(fault, "slip_components", 2));
  ok(SlipFaultSetInertia(fault, inertia));
  return fault;
}

/* ---- stops ---- */

/* States with the rate v0 + k t + c t^2 of cell 0 at the shares 0, x and 1 of a step h, and constant rates of the others */
typedef struct {
  PetscReal v0, k, c, others; /* [m/s], [m/s^2], [m/s^3] */
  PetscReal x, h;
} Course;

static PetscReal StopOf(SlipFault fault, const Course *p, PetscReal sign, PetscReal rtol)
{
  const PetscReal at[3] = {0, p->x * p->h, p->h};
  const PetscInt components = fault->layout.components;
  PetscReal stop, *a;
  Vec w[4];

  for (int s = 0; s < 4; s++) {
    const PetscReal v = s < 3 ? p->v0 + p->k * at[s] + p->c * at[s] * at[s] : p->k; /* the last one is the derivative */

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

/* The stop of a parabola is its root, after the state in between; before that one it is where the tangent at the start ends, or that state. */
static void stops(void **state)
{
  const Course after = {1, -1, -0.25, 0, 0.586, 1}, before = {1, -2, 0, 0, 0.586, 1}, late = {1, -1, -1, 0, 0.8, 1};
  const Course grows = {1, 0.5, -4, 0, 0.9, 1}, moves = {1, -0.5, 0, 0, 0.586, 1}, still = {0, 0, 0, 1, 0.586, 1};

  (void)state;
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

/* Of one cell: displacement u, slip rate v and the errors of both; with an opening of its own where cells open */
static PetscReal ErrorOf(SlipFault fault, PetscReal rtol, PetscReal u, PetscReal v, PetscReal eu, PetscReal opening)
{
  const PetscReal h = 1e-3; /* so that no slip of this step counts */
  PetscReal E, *a;
  Vec e, w[2];

  ok(SlipFaultCreateState(fault, &e));
  for (int k = 0; k < 2; k++) {
    ok(SlipFaultCreateState(fault, &w[k]));
    ok(VecGetArray(w[k], &a));
    a[SlipFaultRateAt(fault, 0)] = v;
    a[SlipFaultDisplacementAt(fault, 0)] = u;
    a[SlipFaultStateAt(fault, 0)] = u;
    ok(VecRestoreArray(w[k], &a));
  }
  ok(VecGetArray(e, &a));
  a[SlipFaultDisplacementAt(fault, 0)] = eu;
  if (SlipFaultOpens(fault)) a[SlipFaultDisplacementAt(fault, 0) + 2] = opening;
  ok(VecRestoreArray(e, &a));
  ok(SlipFaultErrorNorm(fault, rtol, 0, h, e, w[0], w[1], &E));
  ObjectsDestroy(&e, &w[0], &w[1]);
  return E;
}

/* Without inertia an error e of the slip is one of the rate of e K/(H + theta K), against ten times rtol of the largest rate, which is at
   least rtol d_c K/H; slips count against d_c. */
static void slip_and_rate(void **state)
{
  const PetscReal rtol = 1e-3, u = 0.01, e = 1e-5;
  PetscReal K, H;
  SlipFault fault = Cells(1, 1, PETSC_FALSE);
  Mat k, damping;
  Vec diagonal;

  (void)state;
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetOperators(fault, &k, &damping, NULL));
  ok(MatCreateVecs(k, &diagonal, NULL));
  ok(MatGetDiagonal(k, diagonal));
  ok(VecSum(diagonal, &K));
  ok(MatGetDiagonal(damping, diagonal));
  ok(VecSum(diagonal, &H));
  ok(VecDestroy(&diagonal));
  for (int m = 0; m < 3; m++) {
    const PetscReal theta = m == 0 ? 0 : m == 1 ? H / K : 100 * H / K;
    const PetscReal fast = 1e-3 * weakening * K / H, slow = 1e-6 * weakening * K / H; /* rates */

    for (int quick = 0; quick < 2; quick++) {
      const PetscReal v = quick ? fast : slow;
      const PetscReal rate = e * K / (H + theta * K) / (10 * rtol * (v + rtol * weakening * K / H));

      fault->stage.theta = theta;
      AssertNear(ErrorOf(fault, rtol, u, v, e, 0) / PetscMax(rate, e / weakening / rtol), 1, 1e-12);
    }
  }
  ok(SlipFaultDestroy(&fault));
}

/* What opens a cell counts as slip does. */
static void opening(void **state)
{
  const PetscReal rtol = 1e-3, u = 0.01, e = 1e-5;
  SlipFault fault = Cells(1, 2, PETSC_FALSE);

  (void)state;
  ok(FaultSetReals(fault, {"depth_top", 1000}));
  ok(SlipFaultSetBool(fault, "opening", PETSC_TRUE));
  ok(SlipFaultSetString(fault, "friction_law", "linear_slip_weakening"));
  ok(SlipFaultSetUp(fault));
  fault->stage.theta = 1e6; /* so that rates do not count */
  AssertNear(ErrorOf(fault, rtol, u, 0, e, 0) / (e / weakening / rtol), 1, 1e-12);
  AssertNear(ErrorOf(fault, rtol, u, 0, e, 3 * e) / (3 * e / weakening / rtol), 1, 1e-12);
  AssertNear(ErrorOf(fault, rtol, u, 0, e, -3 * e) / (3 * e / weakening / rtol), 1, 1e-12);
  AssertNear(ErrorOf(fault, rtol, u, 0, 3 * e, e) / (3 * e / weakening / rtol), 1, 1e-12);
  ok(SlipFaultDestroy(&fault));
}

/* ---- the estimate of a run's error ---- */

/* What the error e of a step changes the work by, M v.e_v + K u.e_u + q.e_s, where slip has changed the normal stress of q, as it does where a
   fault dips: after one step, from the state, the strength and K themselves. */
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
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_LENGTH + 8];

  (void)state;
  assert_int_equal(0, TempDirMake("tolerance", dir));
  snprintf(file, sizeof(file), "%s/o.h5", dir);
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 3}, {"nz", 2}, {"dip", 40}, {"rake", 90}, {"depth_top", 500}));
  ok(SlipFaultSetString(fault, "output", file));
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
  ok(VecGetArrayRead(w, &a));
  ok(VecGetArrayRead(error, &e));
  ok(VecGetArrayRead(ku, &f));
  for (PetscInt i = 0; i < CELLS; i++) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, a[3 * i + 2], fabs(a[3 * i]), &mu, &ds, &dv);
    work += mass * a[3 * i] * e[3 * i] + f[i] * e[3 * i + 1] + mu * sigma[i] * e[3 * i + 2];
    change += mu * (sigma[i] - fault->fields.cell[FIELD_NORMAL_STRESS][i]) * e[3 * i + 2];
  }
  ok(VecRestoreArrayRead(ku, &f));
  ok(VecRestoreArrayRead(error, &e));
  ok(VecRestoreArrayRead(w, &a));
  /* sums of terms that cancel in part, each to rounding; what slip has changed is far more */
  assert_true(fabs(change) > 1e-4 * fabs(work));
  AssertNear(fault->run.error.work[0] / (scale * work), 1, 1e-9);
  ObjectsDestroy(&u, &ku, &w, &ts, &fault);
  assert_int_equal(0, TempDirRemove(dir));
}

SLIP_TESTS(stops, slip_and_rate, opening, work_of_an_error)
