/* Friction that sticks in explicit steps without inertia: blocks against their formulas, when they start and stop,
   faults of several cells against TSBATHE, refusals, and the formulas of TSRKC. */
#include "unit.h"
#include "faultstart.h"
#include "cells.h"
#include "tempdir.h"
#include "record.h"
#include <slipstep/rooms/sliph5.h>
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <string.h>

static const PetscReal sigma = 50e6, residual = 0.5, drop = 0.1;
static const char *const types[] = {TSRKC, TSRK, TSADAMS};

/* Cells of 1 km under radiation damping, from a shear stress [Pa] */
static SlipFault Fault(PetscInt nx, PetscInt nz, const char law[], PetscReal slip, PetscReal traction)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"friction_law", law}, {"viscosity", "radiation"}, {"initial", "traction"}));
  ok(FaultSetReals(fault, {"nx", nx}, {"nz", nz}, {"length_x", 1000 * (PetscReal)nx},
                   {"length_z", 1000 * (PetscReal)nz}, {"normal_stress", sigma}, {"normal_stress_gradient", 0},
                   {"friction_residual", residual}, {"friction_drop", drop}, {"friction_slip", slip},
                   {"initial_traction", traction}));
  ok(SlipFaultSetInertia(fault, PETSC_FALSE));
  ok(SlipFaultSetBool(fault, "initial_unstable", PETSC_TRUE));
  return fault;
}

/* Its run to the end, at a tolerance, or in constant steps where dt is not 0; w stays */
static void Run(SlipFault fault, const char type[], PetscReal rtol, PetscReal dt, PetscReal end, Vec *w)
{
  TS ts;

  ok(PetscOptionsSetValue(NULL, "-ts_type", type));
  ok(FaultStart(fault, dt > 0 ? TSADAPTNONE : NULL, dt, end, w, &ts));
  ok(TSSetFromOptions(ts));
  ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, rtol, NULL));
  ok(TSSolve(ts, *w));
  ok(PetscOptionsClearValue(NULL, "-ts_type"));
  ok(TSDestroy(&ts));
}

/* K and eta of a fault of one cell */
static void Numbers(SlipFault fault, PetscReal *K, PetscReal *eta)
{
  PetscReal G, rho;
  Vec one, k;
  Mat A;

  ok(SlipFaultGetReal(fault, "shear_modulus", &G));
  ok(SlipFaultGetReal(fault, "density", &rho));
  *eta = sqrt(G * rho) / 2;
  ok(SlipFaultGetOperators(fault, &A, NULL, NULL));
  ok(MatCreateVecs(A, &one, &k));
  ok(VecSet(one, 1));
  ok(MatMult(A, one, k));
  ok(VecMax(k, NULL, K));
  ObjectsDestroy(&one, &k);
}

/* ---- formulas of TSRKC ---- */

/* The polynomial that a step of s stages makes of y' = z y */
static PetscReal Polynomial(PetscInt s, PetscReal z)
{
  SlipRKCStage c[SLIP_RKC_MOST + 1];
  PetscReal y[SLIP_RKC_MOST + 1] = {1};

  SlipRKCCoefficients(s, c);
  y[1] = 1 + c[1].rate * z;
  for (PetscInt j = 2; j <= s; j++)
    y[j] =
      1 - c[j].one - c[j].two + c[j].one * y[j - 1] + c[j].two * y[j - 2] + c[j].rate * z * y[j - 1] + c[j].start * z;
  return y[s];
}

/* 1 + z + z^2/2 and what is smaller, and not larger than 1 up to the longest step */
static void formulas(void **state)
{
  for (PetscInt s = 2; s <= SLIP_RKC_MOST; s += s < 20 ? 1 : 20) {
    const PetscReal longest = SlipRKCLongest(s), z = 1e-3;

    /* z^3/6 of the exponential, of which a formula has up to the whole; rounding of s stages */
    assert_true(fabs(Polynomial(s, z) - 1 - z - z * z / 2) < z * z * z / 3 + 1e-14 * (double)(s * s));
    assert_int_equal(s, SlipRKCStages(longest));
    for (PetscInt k = 1; k <= 1000; k++)
      if (!(fabs(Polynomial(s, -longest * (PetscReal)k / 1000)) < 1))
        fail_msg("%d stages grow at %g", (int)s, (double)(-longest * (PetscReal)k / 1000));
  }
}

/* ---- one block ---- */

/* Linear slip weakening from an excess e: eta u' = e + (W - K) u while u < d, then T - q_r - K u */
static PetscReal Block(PetscReal K, PetscReal eta, PetscReal e, PetscReal d, PetscReal t, PetscReal *v)
{
  const PetscReal W = sigma * drop / d, growth = (W - K) / eta, corner = log(1 + (W - K) * d / e) / growth;
  const PetscReal last = (e + sigma * drop) / K;

  if (t < corner) {
    *v = e / eta * exp(growth * t);
    return e / (W - K) * expm1(growth * t);
  }
  *v = (last - d) * K / eta * exp(-K / eta * (t - corner));
  return last + (d - last) * exp(-K / eta * (t - corner));
}

static void block(void **state)
{
  const PetscReal d = 0.05, excess = 1e5;

  for (int k = 0; k < 3; k++)
    for (int late = 0; late < 2; late++) {
      SlipFault fault = Fault(1, 1, "linear_slip_weakening", d, (residual + drop) * sigma + excess);
      PetscReal K, eta, v, u, end;
      const PetscReal *a;
      Vec w;

      ok(SlipFaultSetUp(fault));
      Numbers(fault, &K, &eta);
      end = 0.8 * log(1 + (sigma * drop / d - K) * d / excess) * eta / (sigma * drop / d - K) * (late ? 2 : 1);
      Run(fault, types[k], 1e-7, 0, end, &w);
      u = Block(K, eta, excess, d, end, &v);
      a = VecRead(w);
      /* local errors of 1e-7 d, some hundred of them, which grow as the excess does, fiftyfold */
      if (!(fabs(a[1] - u) < 2e-4 * d && fabs(a[0] - v) < 2e-4 * d * K / eta * 10 && a[2] == a[1]))
        fail_msg("%s: u %.9g, expected %.9g, v %.9g, expected %.9g, s %.9g", types[k], (double)a[1], (double)u,
                 (double)a[0], (double)v, (double)a[2]);
      ObjectsDestroy(&w, &fault);
    }
}

/* Constant friction under a pressure that rises and falls: it starts where friction is reached, at a time that rest
   knows exactly, slips after the pressure, and stops, exactly at rest, while that falls */
static void starts_and_stops(void **state)
{
  const PetscInt rows = 3, dims[] = {3, 1, 1};
  const PetscReal deficit = 2e5, peak = 1e6;
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];

  assert_int_equal(0, TempDirFile("sticking", "record.h5", dir, file));
  for (int k = 0; k < 3; k++) {
    SlipFault fault = Fault(1, 1, "constant", 1, residual * sigma - deficit);
    PetscReal K, eta, rise, start, v, u, stop, times[3] = {0, 10, 20}, pressure[3] = {0, peak, 0};
    const PetscReal *a;
    Vec w;

    ok(WriteRecord(file, rows, times, 3, dims, pressure));
    ok(SlipFaultSetString(fault, "pore_pressure", file));
    ok(SlipFaultSetUp(fault));
    Numbers(fault, &K, &eta);
    rise = residual * peak / times[1];
    start = deficit / rise;
    v = rise / K * -expm1(-K / eta * (times[1] - start));
    u = rise / K * (times[1] - start) - v * eta / K;
    stop = eta / K * log(1 + v * K / rise); /* of v' = -(K v + rise)/eta */
    u += -rise / K * stop + (v + rise / K) * eta / K * -expm1(-K / eta * stop);
    Run(fault, types[k], 1e-6, 0, times[2], &w);
    a = VecRead(w);
    /* local errors of 1e-6 u, some hundred of them */
    if (!(a[0] == 0 && fabs(a[1] - u) < 1e-4 * u && times[1] + stop < times[2]))
      fail_msg("%s: v %g, u %.9g, expected %.9g", types[k], (double)a[0], (double)a[1], (double)u);
    ObjectsDestroy(&w, &fault);
  }
  assert_int_equal(0, TempDirRemove(dir));
}

/* A law that falls with the rate: the balance of the rate itself, by bisection */
static void by_rate(void **state)
{
  const PetscReal traction = (residual + drop) * sigma + 1e5, v0 = 2;
  SlipFault fault = Fault(1, 1, "rate_weakening", 1, traction);
  PetscReal K, eta, low = 0, high = 10;
  const PetscReal *v;
  Vec w;

  ok(SlipFaultSetReal(fault, "friction_rate", v0));
  Run(fault, TSRKC, 1e-2, 0, 0.01, &w);
  Numbers(fault, &K, &eta);
  ok(VecZeroEntries(w));
  ok(SlipFaultRates(fault, 0, w, NULL));
  while (high - low > 1e-15) {
    const PetscReal middle = 0.5 * (low + high);

    *(sigma * (residual + drop / (1 + middle / v0)) + eta * middle > traction ? &high : &low) = middle;
  }
  v = VecRead(fault->balance.rate);
  assert_true(fabs(*v - low) < 1e-11 * low); /* rounding of stresses 1e3 times what is left */
  ObjectsDestroy(&w, &fault);
}

/* ---- several cells ---- */

/* Powers of cells of 1, 2 and 3 ha, one of which rests, are sums over their areas: those of one pass, which explicit
   steps use, against products with H, as for other integrators and a given reaction, but for rounding. */
static void powers(void **state)
{
  const PetscReal columns[] = {50, 150, 250, 0, 0, 0, 50, 100, 150, 100, 100, 100, 100, 200, 300};
  const PetscReal rate[] = {0.1, 0, 0.3}, vinf = 1e-2;
  const SlipCells mesh = CellsOfColumns(3, columns);
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];

  assert_int_equal(0, TempDirFile("sticking", "mesh.h5", dir, file));
  ok(WriteCells(file, &mesh));
  for (PetscInt components = 1; components <= 2; components++) {
    SlipFault fault = Fault(1, 1, "exponential_slip_weakening", 0.2, residual * sigma);
    PetscReal *a, *f, power[3], expected[3], radiated = 0, eta;
    const PetscReal *q;
    Vec w, r;
    TS ts;

    ok(SlipFaultSetString(fault, "mesh", file));
    ok(FaultSetReals(fault, {"slip_components", components}, {"loading_rate", vinf}));
    ok(PetscOptionsSetValue(NULL, "-ts_type", TSRKC));
    ok(FaultStart(fault, NULL, 0, 1, &w, &ts));
    ok(PetscOptionsClearValue(NULL, "-ts_type"));
    assert_true(fault->problem.steps.any_integrator); /* else both are the same */
    eta = fault->balance.eta;
    ok(VecGetArray(w, &a));
    for (PetscInt i = 0; i < 3; i++) {
      PetscReal *v = a + SlipFaultRateAt(fault, i);

      v[0] = rate[i];
      if (components > 1) v[1] = 0.5 * rate[i];
      radiated += (i + 1) / 2. * eta * (PetscSqr(v[0] - vinf) + (components > 1 ? PetscSqr(v[1]) : 0));
    }
    ok(VecRestoreArray(w, &a));
    ok(VecDuplicate(fault->operators.vinf, &r));
    ok(SlipFaultStrength(fault, 0, w, fault->cells));
    q = VecRead(fault->cells);
    ok(VecGetArray(r, &f));
    ok(VecGetArray(w, &a));
    for (PetscInt i = 0; i < 3; i++)
      for (PetscInt k = 0; k < components; k++) {
        const PetscReal *v = a + SlipFaultRateAt(fault, i), speed = SlipFaultLength(fault, v);

        f[components * i + k] = speed > 0 ? -q[i] * v[k] / speed : 0;
      }
    ok(VecRestoreArray(w, &a));
    ok(VecRestoreArray(r, &f));
    ok(SlipFaultGetPowers(fault, 0, w, NULL, power, NULL));
    ok(SlipFaultGetPowers(fault, 0, w, r, expected, NULL));
    for (int k = 0; k < 3; k++) AssertNear(power[k] / expected[k], 1, 1e-12);
    AssertNear(power[0] / radiated, 1, 1e-12);
    ObjectsDestroy(&r, &w, &ts, &fault);
  }
  assert_int_equal(0, TempDirRemove(dir));
}

/* Dipping cells with vectors of slip, whose normal stress slip changes, healing and loaded: against TSBATHE */
static void against_bathe(void **state)
{
  for (int k = 0; k < 3; k++) {
    PetscReal error, size;
    Vec w[2];

    for (int i = 0; i < 2; i++) {
      SlipFault fault = Fault(4, 3, "exponential_slip_weakening", 0.2, (residual + drop) * sigma + 1e5);

      ok(FaultSetReals(fault, {"dip", 50}, {"rake", 60}, {"slip_components", 2}, {"healing_time", 100},
                       {"loading_rate", 1e-3}, {"depth_top", 1000}));
      Run(fault, i ? types[k] : TSBATHE, i ? 1e-6 : 1e-5, 0, 4, &w[i]);
      ok(SlipFaultDestroy(&fault));
    }
    ok(VecNorm(w[0], NORM_INFINITY, &size));
    ok(VecAXPY(w[1], -1, w[0]));
    ok(VecNorm(w[1], NORM_INFINITY, &error));
    if (!(error < 1e-3 * size)) fail_msg("%s: %g of %g", types[k], (double)error, (double)size); /* bathe's at 1e-5 */
    ObjectsDestroy(&w[0], &w[1]);
  }
}

/* The traction of a state within an event, loaded fast: each sliding cell's is its strength against its rate, and the
   powers are those of this traction, to the rounding of stresses */
static void traction_and_powers(void **state)
{
  SlipFault fault = Fault(4, 3, "exponential_slip_weakening", 0.2, (residual + drop) * sigma + 1e5);
  const PetscReal end = 0.5, *a, *r, *q;
  PetscReal powers[2][3];
  Vec w, traction, strength;

  ok(FaultSetReals(fault, {"loading_rate", 1e-2}, {"slip_components", 2}, {"rake", 60}));
  Run(fault, TSRKC, 1e-2, 0, end, &w);
  ok((*fault->cell_ops->traction)(fault, end, w, &traction));
  ok(VecDuplicate(fault->cells, &strength));
  ok((*fault->cell_ops->strength)(fault, end, w, strength));
  a = VecRead(w);
  r = VecRead(traction);
  q = VecRead(strength);
  for (int i = 0; i < 12; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i), speed = hypot(v[0], v[1]);

    assert_true(speed > 0);
    for (int k = 0; k < 2; k++) AssertNear(r[2 * i + k], -q[i] * v[k] / speed, 1e-12 * q[i]);
  }
  for (int k = 0; k < 2; k++) ok(SlipFaultGetPowers(fault, end, w, k ? traction : NULL, powers[k], NULL));
  for (int k = 0; k < 3; k++) AssertNear(powers[0][k] / powers[1][k], 1, 1e-10);
  ObjectsDestroy(&strength, &w, &fault);
}

static const PetscReal loading = 1e-6; /* [m/s] */
static PetscReal seen[8];              /* times after steps */

static PetscErrorCode See(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  assert_true(step < 8 && VecRead(w)[0] == 0);
  AssertNear(VecRead(w)[1], -loading * t, 1e-15 * loading * t);
  seen[step] = t;
  return PETSC_SUCCESS;
}

/* A fault that rests under loading takes steps to the corners of its record, and to the end. */
static void rests_to_corners(void **state)
{
  const PetscInt rows = 3, dims[] = {3, 1, 1};
  const PetscReal times[] = {0, 10, 25}, pressure[] = {0, 1e5, 0}, end = 40;
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  SlipFault fault = Fault(1, 1, "constant", 1, residual * sigma - 2e5);
  PetscInt steps;
  TS ts;
  Vec w;

  assert_int_equal(0, TempDirFile("sticking", "record.h5", dir, file));
  ok(WriteRecord(file, rows, times, 3, dims, pressure));
  ok(SlipFaultSetString(fault, "pore_pressure", file));
  ok(SlipFaultSetReal(fault, "loading_rate", loading));
  ok(PetscOptionsSetValue(NULL, "-ts_type", TSRKC));
  ok(FaultStart(fault, NULL, 0, end, &w, &ts));
  ok(TSSetFromOptions(ts));
  ok(PetscOptionsClearValue(NULL, "-ts_type"));
  ok(TSMonitorSet(ts, See, NULL, NULL));
  ok(TSSolve(ts, w));
  ok(TSGetStepNumber(ts, &steps));
  assert_int_equal(3, steps);
  assert_true(seen[1] == times[1] && seen[2] == times[2] && seen[3] == end);
  ObjectsDestroy(&ts, &w, &fault);
  assert_int_equal(0, TempDirRemove(dir));
}

/* An event whose loading turns comes to rest: all cells are still, and have slipped by their displacement, but for the
   rounding of both: the end of an event is found at once, and not followed. */
static void lands(void **state)
{
  SlipFault fault = Fault(4, 3, "linear_slip_weakening", 0.05, (residual + drop) * sigma + 1e5);
  PetscReal rest;
  const PetscReal *a;
  Vec w;

  ok(SlipFaultSetReal(fault, "stressing_rate", -1e-3));
  Run(fault, TSRKC, 1e-2, 0, 1e4, &w);
  ok(SlipFaultRestTime(NULL, 1e4, w, &rest, fault)); /* 0 where a cell moves */
  a = VecRead(w);
  assert_true(rest > 0 && a[1] > 0.05);
  for (int i = 0; i < 12; i++) AssertNear(a[3 * i + 2], a[3 * i + 1], 1e-14);
  ObjectsDestroy(&w, &fault);
}

SLIP_TESTS(formulas, block, starts_and_stops, by_rate, powers, against_bathe, traction_and_powers, rests_to_corners,
           lands)
