/* What loads a fault in time: the exponential integral, pressure by a record, a source and a function, corners,
   opening, and the start. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/sliph5.h>
#include <math.h>
#include "tempdir.h"
#include "record.h"

enum { NX = 3, NZ = 2, N = NX * NZ, ROWS = 3 };
static const PetscReal record_times[ROWS] = {10, 30, 100};

/* Of row k and cell e [Pa] */
static PetscReal RecordValue(PetscInt k, PetscInt e)
{
  return 1e6 * (1 + (PetscReal)(k * k)) + 1e4 * (PetscReal)e;
}

/* E1(x) = exp(-x) integral exp(-t)/(x + t) dt over t > 0, by the trapezoidal rule in ln t, whose error falls
   exponentially with 1/step, as the integrand is analytic and vanishes at both ends */
static PetscReal Quadrature(PetscReal x)
{
  const PetscReal step = 0.01;
  PetscReal sum = 0;

  for (PetscInt k = -6000; k < 600; k++) {
    const PetscReal t = exp(step * (PetscReal)k);

    sum += step * t * exp(-t) / (x + t);
  }
  return sum * exp(-x);
}

static void exponential_integral(void **state)
{
  /* Abramowitz & Stegun 1964, tables 5.1 and 5.2, to their last digit: E1(0.5), E1(1), E1(2), x exp(x) E1(x) at 10,
     20 */
  const PetscReal x[] = {1e-8, 1e-3, 0.1, 0.5, 0.999999, 1, 1.000001, 1.5, 2, 5, 10, 50, 300};

  assert_true(fabs(SlipExponentialIntegral(0.5) - 0.559773595) < 6e-10);
  assert_true(fabs(SlipExponentialIntegral(1) - 0.219383934) < 6e-10);
  assert_true(fabs(SlipExponentialIntegral(2) - 0.048900511) < 6e-10);
  assert_true(fabs(10 * exp(10) * SlipExponentialIntegral(10) - 0.915633339) < 6e-10);
  assert_true(fabs(20 * exp(20) * SlipExponentialIntegral(20) - 0.954370910) < 6e-10);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(x); k++)
    assert_true(fabs(SlipExponentialIntegral(x[k]) / Quadrature(x[k]) - 1) < 1e-13);
  assert_true(SlipExponentialIntegral(1e4) == 0 && SlipExponentialIntegral(PETSC_MAX_REAL) == 0);
}

/* ndim 3: [m, Nz, Nx], 2: [m, N] */
static void WriteOwnRecord(const char file[], PetscInt ndim)
{
  const PetscInt rows = ROWS, dims[3] = {ROWS, ndim == 3 ? NZ : N, NX};
  PetscReal pressure[ROWS * N];

  for (PetscInt k = 0; k < ROWS; k++)
    for (PetscInt e = 0; e < N; e++) pressure[k * N + e] = RecordValue(k, e);
  ok(WriteRecord(file, rows, record_times, ndim, dims, pressure));
}

static SlipFault Fault(void)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "initial", "traction"));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"normal_stress", 5e7}, {"normal_stress_gradient", 0},
                   {"initial_traction", 1e7}));
  return fault;
}

/* What has been taken from the normal stress of cell e at t */
static PetscReal PressureAt(SlipFault fault, PetscReal t, PetscInt e)
{
  const SlipFaultLoad *load;

  ok(SlipFaultGetLoad(fault, t, &load));
  return fault->fields.cell[FIELD_NORMAL_STRESS][e] - load->stress[e];
}

static void record(void **state)
{
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];

  assert_int_equal(0, TempDirFile("loads", "p.h5", dir, file));
  for (PetscInt ndim = 2; ndim <= 3; ndim++) {
    SlipFault fault = Fault();

    WriteOwnRecord(file, ndim);
    ok(SlipFaultSetString(fault, "pore_pressure", file));
    ok(SlipFaultSetUp(fault));
    for (PetscInt e = 0; e < N; e++) {
      const PetscReal a = RecordValue(0, e), b = RecordValue(1, e), c = RecordValue(2, e);

      /* rounding of 5e7 Pa less the pressure */
      assert_true(fabs(PressureAt(fault, -5, e) - a) < 1e-7 && fabs(PressureAt(fault, 10, e) - a) < 1e-7);
      assert_true(fabs(PressureAt(fault, 15, e) - (0.75 * a + 0.25 * b)) < 1e-7);
      assert_true(fabs(PressureAt(fault, 30, e) - b) < 1e-7);
      assert_true(fabs(PressureAt(fault, 86, e) - (0.2 * b + 0.8 * c)) < 1e-7);
      assert_true(fabs(PressureAt(fault, 100, e) - c) < 1e-7 && fabs(PressureAt(fault, 1e9, e) - c) < 1e-7);
    }
    /* a step's end that misses a corner by rounding has met it */
    assert_true(SlipLoadsNextCorner(&fault->loads, 0) == 10 && SlipLoadsNextCorner(&fault->loads, 10) == 30 &&
                SlipLoadsNextCorner(&fault->loads, 29) == 30);
    assert_true(SlipLoadsNextCorner(&fault->loads, 30 * (1 - 1e-15)) == 100 &&
                SlipLoadsNextCorner(&fault->loads, 100) > 1e300);
    ok(SlipFaultDestroy(&fault));
  }
  assert_int_equal(0, TempDirRemove(dir));
}

static void source(void **state)
{
  const PetscReal p = 2e6, D = 0.5, stop = 4e6, t = 7e6;
  SlipFault fault = Fault();

  ok(SlipFaultSetString(fault, "injection", "500,750")); /* the centre of the first of the cells of 1000 x 1500 m */
  ok(FaultSetReals(fault, {"injection_pressure", p}, {"injection_diffusivity", D}, {"injection_stop", stop}));
  ok(SlipFaultSetUp(fault));
  for (PetscInt e = 0; e < N; e++) {
    const PetscReal x = 1000 * (PetscReal)(e % NX), z = 1500 * (PetscReal)(e / NX);
    const PetscReal r2 = e ? x * x + z * z : 1000 * 1500 / (PETSC_PI * exp(1));

    assert_true(PressureAt(fault, 0, e) == 0);
    assert_true(fabs(PressureAt(fault, 3e6, e) - p * Quadrature(r2 / (4 * D * 3e6))) < 1e-6);
    assert_true(fabs(PressureAt(fault, t, e) -
                     p * (Quadrature(r2 / (4 * D * t)) - Quadrature(r2 / (4 * D * (t - stop))))) < 1e-6);
  }
  assert_true(SlipLoadsNextCorner(&fault->loads, 0) == stop && SlipLoadsNextCorner(&fault->loads, stop) > 1e300);
  ok(SlipFaultDestroy(&fault));
}

/* Two planes 5 km apart: a cell of the other one has the pressure of its distance in space, whatever the file's
   order. */
static void source_of_planes(void **state)
{
  const PetscReal p = 2e6, D = 0.5, t = 3e7, h = 1000, apart = 5000, y = 300;
  const PetscReal cells[] = {0, y + apart, 5000,  h,         h,    0, y, 5000, h,         h,    2 * h, y, 5000,
                             h, h,         2 * h, y + apart, 6500, h, h, 0,    y + apart, 6500, h,     h};
  const PetscInt dims[2] = {5, 5};
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  SlipFault fault;
  SlipH5 h5;

  assert_int_equal(0, TempDirFile("planes", "m.h5", dir, file));
  ok(SlipH5Create(file, &h5));
  ok(SlipH5WriteReal(&h5, "/cells", 2, dims, cells, "m"));
  ok(SlipH5Close(&h5));
  for (int wrong = 0; wrong < 2; wrong++) {
    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    ok(FaultSetStrings(fault, {"mesh", file}, {"injection", wrong ? "0,5000" : "0,300,5000"}));
    ok(FaultSetReals(fault, {"normal_stress", 5e7}, {"injection_pressure", p}, {"injection_diffusivity", D}));
    if (wrong)
      fails(SlipFaultSetUp(fault), "-fault_injection is \"0,5000\"");
    else
      ok(SlipFaultSetUp(fault));
    for (PetscInt i = 0; i < 5 && !wrong; i++) {
      const PetscReal *c = cells + 5 * (fault->mesh.order ? fault->mesh.order[i] : i);
      const PetscReal r2 = c[0] * c[0] + (c[1] - y) * (c[1] - y) + (c[2] - 5000) * (c[2] - 5000);
      const PetscReal pressure = p * Quadrature(PetscMax(r2, h * h / (PETSC_PI * exp(1))) / (4 * D * t));

      assert_true(fabs(PressureAt(fault, t, i) - pressure) < 1e-6); /* rounding of the stress that p is taken from */
    }
    ok(SlipFaultDestroy(&fault));
  }
  assert_int_equal(0, TempDirRemove(dir));
}

/* Grows from nothing to the pressure of the last row in 100 s */
static PetscErrorCode Growing(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  for (PetscInt i = 0; i < n; i++) p[i] = *(PetscReal *)ctx * PetscClipInterval(t / 100, 0, 1);
  return PETSC_SUCCESS;
}

/* A run under pressure that grows to 40 MPa in 100 s: by a record when file is given, else by a function. Its slip. */
static PetscReal Slip(const char file[], PetscReal largest, PetscReal *opened)
{
  const SlipFaultLoad *load;
  SlipFaultObservables o;
  SlipFault fault = Fault();
  TS ts;
  Vec w;

  ok(FaultSetStrings(fault, {"viscosity", "radiation"}, {"friction_law", "constant"}));
  ok(SlipFaultSetInertia(fault, PETSC_FALSE));
  if (file)
    ok(SlipFaultSetString(fault, "pore_pressure", file));
  else
    ok(SlipFaultSetPressureFunction(fault, Growing, &largest));
  ok(FaultStart(fault, "heuristic", 0, 100, &w, &ts));
  ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, 1e-3, NULL));
  fails(SlipFaultSetPressureFunction(fault, Growing, &largest), "before SlipFaultSetUp()");
  ok(TSSolve(ts, w));
  ok(SlipFaultGetObservables(fault, 100, w, NULL, &o));
  ok(SlipFaultGetLoad(fault, 100, &load));
  if (opened) *opened = fault->loads.opened ? load->stress[0] : -1;
  ObjectsDestroy(&w, &ts, &fault);
  return o.mean_slip;
}

static void function(void **state)
{
  const PetscInt dims[2] = {2, N}, rows = 2;
  const PetscReal times[2] = {0, 100};
  PetscReal pressure[2 * N] = {0}, a, b;
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];

  assert_int_equal(0, TempDirFile("loads", "p.h5", dir, file));
  for (PetscInt e = 0; e < N; e++) pressure[N + e] = 4e7;
  ok(WriteRecord(file, rows, times, 2, dims, pressure));
  a = Slip(file, 0, NULL);
  b = Slip(NULL, 4e7, NULL);
  /* onsets differ by rounding, 1e-15, which no step amplifies: quasi-static slip follows from the load alone */
  assert_true(a > 0.1 && fabs(a / b - 1) < 1e-10);
  assert_int_equal(0, TempDirRemove(dir));
}

/* ---- corners that a step may pass ---- */

enum { MANY = 200 };

/* times [rows] and what each cell has then, the last one half as much */
static void WriteEvenRecord(const char file[], PetscInt rows, const PetscReal times[], const PetscReal p[])
{
  const PetscInt dims[2] = {rows, N};
  PetscReal *all;

  ok(PetscMalloc1(rows * N, &all));
  for (PetscInt k = 0; k < rows * N; k++) all[k] = p[k / N] * (k % N == N - 1 ? 0.5 : 1);
  ok(WriteRecord(file, rows, times, 2, dims, all));
  ok(PetscFree(all));
}

static PetscReal NextCorner(SlipFault fault, TS ts, PetscReal t, PetscReal h, Vec w)
{
  PetscReal next;

  ok(TSSetTimeStep(ts, h));
  ok(TSSetSolution(ts, w));
  ok(SlipFaultNextCorner(ts, t, &next, fault));
  return next;
}

/* A parabola c t^2 at whole seconds, and a jump by 1 MPa from 150 to 151 s. Slip of the whole fault by relative D, D
   the displacement so far, costs relative D (1.K 1)/N of stress, mu times the pressure. */
static void corners(void **state)
{
  const PetscReal relative = 1e-2, D = 0.01, mu = 0.6, c = 20;
  PetscReal times[MANY], p[MANY], tolerance;
  PetscInt k;
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  Vec w, one, k_one;
  Mat K;
  TSAdapt adapt;
  TS ts;

  assert_int_equal(0, TempDirFile("loads", "p.h5", dir, file));
  for (PetscInt i = 0; i < MANY; i++) {
    times[i] = (PetscReal)i;
    p[i] = c * (PetscReal)(i * i) + (i > 150 ? 1e6 : 0);
  }
  WriteEvenRecord(file, MANY, times, p);
  /* friction that stays, that weakens over more than has slipped, and over half of it, which then is what counts; a
     source that stops */
  for (int kind = 0; kind < 4; kind++) {
    const PetscBool stops = kind == 3 ? PETSC_TRUE : PETSC_FALSE,
                    weakens = kind == 1 || kind == 2 ? PETSC_TRUE : PETSC_FALSE;
    SlipFault fault = Fault();

    ok(SlipFaultSetString(fault, "friction_law", weakens ? "exponential_slip_weakening" : "constant"));
    ok(FaultSetReals(fault, {"friction_residual", weakens ? mu - 0.1 : mu}, {"friction_drop", 0.1},
                     {"friction_slip", kind == 2 ? D / 2 : 10 * D}));
    ok(SlipFaultSetInertia(fault, PETSC_FALSE));
    ok(FaultSetStrings(fault, {"viscosity", "radiation"}, {"pore_pressure", file}));
    if (stops) {
      ok(SlipFaultSetString(fault, "injection", "500,750"));
      ok(FaultSetReals(fault, {"injection_pressure", 1e3}, {"injection_diffusivity", 1}, {"injection_stop", 3.5}));
    }
    ok(FaultStart(fault, "heuristic", 0, 200, &w, &ts));
    ok(TSSetSolution(ts, w));
    ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, relative, NULL));
    ok(SlipFaultGetOperators(fault, &K, NULL, NULL));
    ok(MatCreateVecs(K, &one, &k_one));
    ok(VecSet(one, 1));
    ok(MatMult(K, one, k_one));
    ok(VecDot(one, k_one, &tolerance));
    tolerance *= relative * (kind == 2 ? D / 2 : D) / N / mu;
    /* k seconds miss the corner in the middle by c j (k - j), j = k/2 without its remainder */
    for (k = 1; c * (PetscReal)((k + 1) / 2 * ((k + 2) / 2)) <= tolerance;) k++;
    assert_true(k > 10 && k < 100);
    /* nothing has moved: no error of slip is small against that */
    assert_true(NextCorner(fault, ts, 10, 50, w) == 11);
    ok(VecStrideSet(w, 1, D));
    if (stops) {
      assert_true(NextCorner(fault, ts, 0, 50, w) == 3.5);
    } else {
      /* a step that ends before the first corner, or before the last that it may pass, is left alone */
      assert_true(NextCorner(fault, ts, 10, 0.5, w) == 11 && NextCorner(fault, ts, 10, k - 1.5, w) > 1e300);
      assert_true(NextCorner(fault, ts, 10, 130, w) == 10 + k);
      assert_true(NextCorner(fault, ts, 140.5, 50, w) == 150 && NextCorner(fault, ts, 150, 30, w) == 151);
      ok(TSGetAdapt(ts, &adapt));
      ok(TSAdaptSetType(adapt, TSADAPTNONE)); /* constant steps keep no error that could be small against another */
      assert_true(NextCorner(fault, ts, 10, 50, w) == 11);
    }
    ObjectsDestroy(&one, &k_one, &w, &ts, &fault);
  }
  assert_int_equal(0, TempDirRemove(dir));
}

/* Above the normal stress a cell has no strength, and less than none: the slip is that of all of the initial traction,
   whatever the pressure */
static void opening(void **state)
{
  PetscReal stress[2], closed;
  const PetscReal just = Slip(NULL, 5e7, NULL), once = Slip(NULL, 6e7, &stress[0]), twice = Slip(NULL, 1e8, &stress[1]);

  (void)Slip(NULL, 4.9e7, &closed);
  assert_true(stress[0] == 0 && stress[1] == 0 && closed == -1);
  /* Slip follows the load within H/K, some 3000 m/(2 cs) = 0.4 s: 16 s and more after all cells have opened the two are
     the same but for what steps of seconds may err, 1 % of the largest displacement each (tolerance.c), of which the
     next ones damp nine tenths and more. 1 % of slip is left to come where the load has just ended. */
  assert_true(fabs(once / twice - 1) < 2e-3 && fabs(once / just - 1) < 0.02);
}

static PetscErrorCode Steady(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  for (PetscInt i = 0; i < n; i++) p[i] = *(PetscReal *)ctx;
  return PETSC_SUCCESS;
}

/* The strength that a start may not exceed is mu (sigma - p) with the pressure of that time, which may be a suction
   too. */
static void start_under_pressure(void **state)
{
  const PetscReal mu = 0.6;

  for (int k = 0; k < 6; k++) {
    PetscReal pressure = 1e7 * (k / 2 - 1);
    SlipFault fault = Fault();
    Vec w;

    ok(SlipFaultSetString(fault, "friction_law", "constant"));
    ok(FaultSetReals(fault, {"friction_residual", mu},
                     {"initial_traction", (k % 2 ? 1.001 : 0.999) * mu * (5e7 - pressure)}));
    ok(SlipFaultSetPressureFunction(fault, Steady, &pressure));
    ok(SlipFaultSetUp(fault));
    ok(SlipFaultCreateState(fault, &w));
    if (k % 2)
      fails(SlipFaultSetInitialState(fault, w), "fault_initial traction");
    else
      ok(SlipFaultSetInitialState(fault, w));
    ObjectsDestroy(&w, &fault);
  }
}

SLIP_TESTS(exponential_integral, record, source, source_of_planes, function, corners, opening, start_under_pressure)
