/* The rest of a fault: when it ends under stressing, healing and pressure, and the state at its middle and its end,
   from the formulas of one cell. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include "cells.h"
#include "tempdir.h"

static const PetscReal sigma = 50e6, residual = 0.5, drop = 0.1, weakening = 0.05;

/* One square cell of 1 km with the strength sigma (residual + drop exp(-s/weakening)) */
static SlipFault Cell(void)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"friction_law", "exponential_slip_weakening"}, {"viscosity", "radiation"},
                     {"initial", "traction"}));
  ok(FaultSetReals(fault, {"nx", 1}, {"nz", 1}, {"length_x", 1000}, {"length_z", 1000}, {"normal_stress", sigma},
                   {"normal_stress_gradient", 0}, {"friction_residual", residual}, {"friction_drop", drop},
                   {"friction_slip", weakening}));
  return fault;
}

/* What SlipFaultRest() says of a fault without slip rate */
typedef struct {
  PetscReal end, u[3], s[3]; /* displacement and state of the first cell at the start, the middle and the end */
  PetscReal h;               /* step to go on with */
} Rest;

static Rest RestOf(SlipFault fault, PetscReal t, PetscReal limit, PetscReal u, PetscReal s)
{
  Rest rest = {.u = {u}, .s = {s}};
  PetscReal *a;
  Vec w[3];

  for (int k = 0; k < 3; k++) ok(SlipFaultCreateState(fault, &w[k]));
  ok(VecGetArray(w[0], &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    a[3 * i + 1] = u;
    a[3 * i + 2] = s;
  }
  ok(VecRestoreArray(w[0], &a));
  ok(SlipFaultRest(NULL, t, limit, w[0], w[1], w[2], &rest.end, &rest.h, fault));
  for (int k = 1; k < 3; k++) {
    ok(VecGetArray(w[k], &a));
    assert_true(rest.end == t || a[0] == 0);
    rest.u[k] = a[1];
    rest.s[k] = a[2];
    ok(VecRestoreArray(w[k], &a));
  }
  ObjectsDestroy(&w[0], &w[1], &w[2]);
  return rest;
}

/* ---- healing ---- */

static PetscReal Strength(PetscReal s)
{
  return sigma * (residual + drop * exp(-s / weakening));
}

/* The first t [healing times] at which traction + rate t reaches the strength of a state that was s: steps of 1e-4, far
   shorter than any course of the strength, then bisection to rounding */
static PetscReal FirstRoot(PetscReal traction, PetscReal rate, PetscReal s)
{
  PetscReal low = 0, high = 0;

  while (traction + rate * high < Strength(s * exp(-high))) {
    low = high;
    high += 1e-4;
    assert_true(high < 1000);
  }
  for (int k = 0; k < 60; k++) {
    const PetscReal middle = 0.5 * (low + high);

    if (traction + rate * middle < Strength(s * exp(-middle)))
      low = middle;
    else
      high = middle;
  }
  return high;
}

/* The strength of a cell that has slipped by many d_c stays low, rises when s is some d_c, and ends at its height. A
   force that grows by a constant rate exceeds it just before that rise, for half of the healing time and again much
   later. The search must find the first time, wherever it is within five healing times: its pieces are a twentieth of
   the healing time and a tenth of the past, together less than the half of one. A strength that does not heal is
   reached later, or never. */
static void healing(void **state)
{
  const PetscReal time = 3e7, before = 2,
                  width = 0.5; /* s in d_c at the middle of the excess, its length in healing times */

  for (PetscInt k = 0; k <= 60; k++) {
    const PetscReal start = before * exp(0.3 + 0.05 * (PetscReal)k), middle = log(start / before);
    /* the force is tangent to the strength at the middle, but for what makes the excess so long */
    const PetscReal rate = (Strength(weakening * start * exp(-middle - 0.5 * width)) -
                            Strength(weakening * start * exp(-middle + 0.5 * width))) /
                           width;
    const PetscReal traction = Strength(weakening * before * exp(0.5 * width)) - rate * (middle - 0.5 * width);
    const PetscReal root = FirstRoot(traction, rate, weakening * start);
    SlipFault fault = Cell();
    Rest rest;

    assert_true(fabs(root - (middle - 0.5 * width)) < 1e-9); /* it enters there and leaves at the other end */
    ok(FaultSetReals(fault, {"healing_time", time}, {"initial_traction", traction}, {"stressing_rate", rate / time}));
    ok(SlipFaultSetUp(fault));
    rest = RestOf(fault, 0, 1000 * time, 0, weakening * start);
    /* rounding of forces of 3e7 Pa over their difference, which grows by 1e5 Pa and more in a healing time */
    if (!(fabs(rest.end / time - root) < 1e-11))
      fail_msg("slip begins after %.15g healing times, not %.15g", (double)(rest.end / time), (double)root);
    ok(SlipFaultDestroy(&fault));
  }
}

/* A rest changes the displacement by the loading and the state by healing alone, du/dt = -v_inf and ds/dt = -s/t_h: at
   its end, and halfway, where a rest of half the length ends. */
static void states(void **state)
{
  const PetscReal time = 3e7, v = 1e-9, u = 0.3, s = 0.4, begin = 1e8;

  for (int heals = 0; heals < 2; heals++) {
    SlipFault fault = Cell();
    PetscReal length;
    Rest all, part;

    if (heals) ok(SlipFaultSetReal(fault, "healing_time", time));
    ok(FaultSetReals(fault, {"loading_rate", v}, {"initial_traction", 2e7}));
    ok(SlipFaultSetUp(fault));
    all = RestOf(fault, begin, 1e12, u, s);
    length = all.end - begin;
    assert_true(length > time && all.end < 1e12);
    for (int k = 1; k <= 2; k++) {
      const PetscReal dt = 0.5 * k * length;

      assert_true(fabs(all.u[k] - (u - v * dt)) < 1e-15 * (u + v * length));
      assert_true(fabs(all.s[k] - (heals ? s * exp(-dt / time) : s)) < 1e-12 * s);
    }
    part = RestOf(fault, begin, begin + length / 2, u, s);
    assert_true(part.end == begin + length / 2);
    /* half of the length is rounded with the times */
    assert_true(fabs(part.u[2] - all.u[1]) < 1e-15 * (u + v * length) && fabs(part.s[2] - all.s[1]) < 1e-12 * s);
    ok(SlipFaultDestroy(&fault));
  }
}

/* ---- stress ---- */

/* A stressing rate is one per area: a cell reaches its strength when it says so, whatever its area. Cells of 1, 2 and 3
   ha, the middle one the strongest, then the others. */
static void areas(void **state)
{
  const PetscReal cells[] = {50, 150, 250, 0, 0, 0, 50, 100, 150, 100, 100, 100, 100, 200, 300};
  const SlipCells mesh = CellsOfColumns(3, cells);
  const PetscReal rate[] = {0.1, 0.25, 0.2}, start = 2e7;
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];

  assert_int_equal(0, TempDirFile("rest", "mesh.h5", dir, file));
  ok(WriteCells(file, &mesh));
  for (int first = 0; first < 3; first++) {
    PetscReal rates[3], force[3];
    SlipFault fault = Cell();
    Rest rest;

    for (int k = 0; k < 3; k++) {
      rates[k] = (k == first ? 10 : 1) * rate[k];
      force[k] = start;
    }
    ok(SlipFaultSetString(fault, "mesh", file));
    ok(SlipFaultSetField(fault, "stressing_rate", 3, rates));
    ok(SlipFaultSetField(fault, "initial_traction", 3, force));
    ok(SlipFaultSetUp(fault));
    assert_true(fabs(fault->mesh.weight[2] / fault->mesh.weight[0] - 3) < 1e-12);
    rest = RestOf(fault, 0, 1e12, 0, 0);
    assert_true(fabs(rest.end / ((Strength(0) - start) / rates[first]) - 1) < 1e-12);
    ok(SlipFaultDestroy(&fault));
  }
  assert_int_equal(0, TempDirRemove(dir));
}

/* ---- pressure ---- */

static const PetscReal p = 1e6, D = 1, stop = 1e8, distance = 632.4555320336759; /* r^2/(4 D) = 1e5 s */

static PetscReal SourceAt(PetscReal since)
{
  const PetscReal time = distance * distance / (4 * D);

  return p * (SlipExponentialIntegral(time / (stop + since)) - (since > 0 ? SlipExponentialIntegral(time / since) : 0));
}

/* After three years of injection the pressure at a distance rises on for hours after the stop and then falls: a cell
   that it brings to its strength within that time begins to slip then, though it is far below it days later. */
static void pressure_after_the_stop(void **state)
{
  PetscReal low = 0, high = 1e5, height;
  SlipFault fault = Cell();
  Rest rest;

  while (high - low > 1) { /* where its rate, exp(-time/t)/t less the same since the stop, is zero */
    const PetscReal middle = 0.5 * (low + high), time = distance * distance / (4 * D);

    if (exp(-time / (stop + middle)) / (stop + middle) > exp(-time / middle) / middle)
      low = middle;
    else
      high = middle;
  }
  assert_true(high > 3600 && high < 1e-3 * stop);
  height = 0.5 * (SourceAt(0) + SourceAt(high));
  assert_true(SourceAt(10 * high) < SourceAt(0));
  low = 0;
  while (high - low > 1e-6) {
    const PetscReal middle = 0.5 * (low + high);

    if (SourceAt(middle) < height)
      low = middle;
    else
      high = middle;
  }
  ok(FaultSetStrings(fault, {"friction_law", "constant"}, {"injection", "1132.4555320336759,500"}));
  ok(FaultSetReals(fault, {"initial_traction", residual * (sigma - height)}, {"injection_pressure", p},
                   {"injection_diffusivity", D}, {"injection_stop", stop}));
  ok(SlipFaultSetUp(fault));
  rest = RestOf(fault, stop, 10 * stop, 0, 0);
  /* rounding of stresses of 5e7 Pa, of which pressure takes 0.01 Pa in a second, is 1e-6 s */
  if (!(fabs(rest.end - stop - high) < 1e-4))
    fail_msg("slip begins %.9g s after the stop, not %.9g", (double)(rest.end - stop), (double)high);
  ok(SlipFaultDestroy(&fault));
}

/* ---- slip as a vector, and opening ---- */

/* One cell with two components or three, the displacement u in its plane and the opening across it; the rest until
   limit, or where that is 0 of SlipFaultRestTime() */
static PetscReal VectorRest(SlipFault fault, const PetscReal u[2], PetscReal opening, PetscReal limit)
{
  PetscReal end, h, *a;
  Vec w[3];

  for (int k = 0; k < 3; k++) ok(SlipFaultCreateState(fault, &w[k]));
  ok(VecGetArray(w[0], &a));
  for (int k = 0; k < 2; k++) a[SlipFaultDisplacementAt(fault, 0) + k] = u[k];
  if (opening > 0) a[SlipFaultDisplacementAt(fault, 0) + 2] = opening;
  ok(VecRestoreArray(w[0], &a));
  if (limit > 0)
    ok(SlipFaultRest(NULL, 0, limit, w[0], w[1], w[2], &end, &h, fault));
  else
    ok(SlipFaultRestTime(NULL, 0, w[0], &end, fault));
  ObjectsDestroy(&w[0], &w[1], &w[2]);
  return end;
}

/* A force F - K u, with displacements across the rake, grows along the rake by a constant rate: it meets the strength,
   a circle, where bisection finds it; it may pass the circle's middle first, and may never come where the rate is 0. */
static void vectors(void **state)
{
  const PetscReal rates[] = {0.02, 0, -0.02};

  for (int m = 0; m < 3; m++)
    for (int across = -1; across <= 1; across++) {
      const PetscReal traction = 1e7, never = 1e12;
      SlipFault fault = Cell();
      PetscReal force[2], u[2] = {0, 0.3 * across}, low = 0, high = 1e11, limit = sigma * (residual + drop);
      Vec x, f;
      Mat K;
      const PetscReal *a;

      ok(FaultSetReals(fault, {"slip_components", 2}, {"initial_traction", traction}, {"stressing_rate", rates[m]},
                       {"loading_rate", 0}));
      ok(SlipFaultSetUp(fault));
      ok(SlipFaultGetOperators(fault, &K, NULL, NULL));
      ok(MatCreateVecs(K, &x, &f));
      ok(VecSetValue(x, 1, u[1], INSERT_VALUES));
      ok(VecAssemble(x));
      ok(MatMult(K, x, f));
      a = VecRead(f);
      force[0] = traction - a[0];
      force[1] = -a[1];
      assert_true(hypot(force[0], force[1]) < 0.9 * limit && (!across || fabs(force[1]) > 0.05 * limit));
      for (int k = 0; k < 200; k++) {
        const PetscReal middle = 0.5 * (low + high);

        if (hypot(force[0] + rates[m] * middle, force[1]) < limit)
          low = middle;
        else
          high = middle;
      }
      /* rounding of forces, whose difference to the strength is a share of them */
      AssertNear(VectorRest(fault, u, 0, never) / (m == 1 ? never : low), 1, 1e-12);
      if (m == 1)
        assert_true(VectorRest(fault, u, 0, 0) == PETSC_MAX_REAL);
      else
        AssertNear(VectorRest(fault, u, 0, 0) / low, 1, 1e-12);
      u[1] *= 1e3; /* beyond the strength */
      if (across) assert_true(VectorRest(fault, u, 0, never) == 0 && VectorRest(fault, u, 0, 0) == 0);
      ObjectsDestroy(&x, &f, &fault);
    }
}

/* At the strength itself, and just below it, a force that falls passes the middle before it comes to the other side. */
static void from_the_edge(void **state)
{
  const PetscReal limit = sigma * (residual + drop), share[] = {1, 1 - 1e-9}, u[2] = {0, 0};

  for (int k = 0; k < 2; k++) {
    SlipFault fault = Cell();

    ok(FaultSetReals(fault, {"slip_components", 2}, {"initial_traction", share[k] * limit}, {"stressing_rate", -0.02}));
    ok(SlipFaultSetUp(fault));
    AssertNear(VectorRest(fault, u, 0, 0) / ((1 + share[k]) * limit / 0.02), 1, 1e-12);
    ok(SlipFaultDestroy(&fault));
  }
}

/* What is left of the way to the strength by rounding is no rest: displacements would stay as they are, and with them
   all that follows. A few times more is one, and so is that of a force that falls away from its strength. */
static void of_rounding(void **state)
{
  const PetscReal limit = sigma * (residual + drop), share[] = {7e-16, 1e-14};

  for (int k = 0; k < 4; k++) {
    SlipFault fault = Cell();
    Rest rest;

    ok(FaultSetReals(fault, {"initial_traction", (1 - share[k / 2]) * limit}, {"stressing_rate", k % 2 ? -1e6 : 1e6}));
    ok(SlipFaultSetUp(fault));
    rest = RestOf(fault, 0, 1e3, 0, 0);
    if (k % 2)
      AssertNear(rest.end, 2 * limit / 1e6, 1e-9);
    else
      assert_true(k == 0 ? rest.end == 0 : fabs(rest.end / (share[1] * limit / 1e6) - 1) < 0.1);
    ok(SlipFaultDestroy(&fault));
  }
}

/* ---- the step after it ---- */

/* Half of the time in which the cell runs away; or where it would swing and its damping is lost, a hundred times that
   in which it swings. */
static void first_step(void **state)
{
  const PetscReal traction = 2.9e7, rate = 1e6, vc = 0.5;

  for (int swings = 0; swings < 2; swings++) {
    SlipFault fault = Cell();
    PetscReal K, H, mass;
    Mat k, h;
    Rest rest;
    Vec x;

    if (swings) {
      ok(SlipFaultSetString(fault, "friction_law", "rate_weakening"));
      ok(FaultSetReals(fault, {"friction_rate", vc}, {"thickness", 1000}));
    }
    ok(FaultSetReals(fault, {"initial_traction", traction}, {"stressing_rate", rate}));
    ok(SlipFaultSetInertia(fault, swings ? PETSC_TRUE : PETSC_FALSE));
    ok(SlipFaultSetUp(fault));
    ok(SlipFaultGetOperators(fault, &k, &h, &mass));
    ok(MatCreateVecs(k, &x, NULL));
    ok(MatGetDiagonal(k, x));
    ok(VecSum(x, &K));
    ok(MatGetDiagonal(h, x));
    ok(VecSum(x, &H));
    ok(VecDestroy(&x));
    rest = RestOf(fault, 0, 1e3, 0, 0);
    AssertNear(rest.end, (sigma * (residual + drop) - traction) / rate, 1e-9);
    if (swings)
      AssertNear(rest.h / (100 / sqrt(K / mass)), 1, 1e-12);
    else
      AssertNear(rest.h / (0.5 * H / (sigma * drop / weakening - K)), 1, 1e-12);
    ok(SlipFaultDestroy(&fault));
  }
}

/* A cell that is open does not rest, however slowly it moves. */
static void open_cell(void **state)
{
  const PetscReal u[2] = {0, 0};
  SlipFault fault = Cell();

  ok(SlipFaultSetReal(fault, "slip_components", 2));
  ok(SlipFaultSetBool(fault, "opening", PETSC_TRUE));
  ok(SlipFaultSetInertia(fault, PETSC_FALSE));
  ok(FaultSetReals(fault, {"initial_traction", 0}, {"depth_top", 1000})); /* no shear that would move it */
  ok(SlipFaultSetUp(fault));
  assert_true(VectorRest(fault, u, 0, 1e9) == 1e9 && VectorRest(fault, u, 0, 0) == PETSC_MAX_REAL);
  assert_true(VectorRest(fault, u, 1e-9, 1e9) == 0 && VectorRest(fault, u, 1e-9, 0) == 0);
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(healing, states, areas, pressure_after_the_stop, vectors, from_the_edge, of_rounding, first_step, open_cell)
