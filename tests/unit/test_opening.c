/* Faults that open: a pressurised penny crack, a cell that opens and closes, the balance of energy, and what is
   refused. */
#include "unit.h"
#include "faultstart.h"
#include <math.h>

/* Pressure of the cells [n] of a test, times a course in time */
typedef struct {
  const PetscReal *share; /* NULL: 1 */
  PetscReal rise;         /* [s] up to the largest, and as long down again; 0: at once */
  PetscReal hold;         /* [s] in between */
  PetscReal fall;         /* [s] down from the largest at 0; 0: for ever */
  PetscReal most;         /* [Pa] */
} Course;

static PetscReal At(const Course *c, PetscReal t)
{
  if (c->rise == 0) return c->most * (c->fall > 0 ? PetscMax(0, 1 - t / c->fall) : 1);
  if (t < c->rise) return c->most * t / c->rise;
  if (t < c->rise + c->hold) return c->most;
  return c->most * PetscMax(0, 1 - (t - c->rise - c->hold) / c->rise);
}

static PetscErrorCode Pressure(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  const Course *c = (const Course *)ctx;

  for (PetscInt i = 0; i < n; i++) p[i] = At(c, t) * (c->share ? c->share[i] : 1);
  return PETSC_SUCCESS;
}

/* nx x nz cells that open, in a full space unless with a dip below the ground, without inertia, of constant friction
   0.6 */
static SlipFault Cells(PetscInt nx, PetscInt nz, PetscReal side, Course *course)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"kernel", "full_space"}, {"friction_law", "constant"}, {"initial", "traction"},
                     {"viscosity", "radiation"}));
  ok(FaultSetReals(fault, {"nx", nx}, {"nz", nz}, {"length_x", nx * side}, {"length_z", nz * side},
                   {"slip_components", 2}, {"normal_stress", 1e6}, {"normal_stress_gradient", 0},
                   {"friction_residual", 0.6}, {"friction_drop", 0}));
  ok(SlipFaultSetBool(fault, "inertia", PETSC_FALSE));
  ok(SlipFaultSetBool(fault, "opening", PETSC_TRUE));
  ok(SlipFaultSetPressureFunction(fault, Pressure, course));
  return fault;
}

/* Opening of a disc of radius 1000 m in a full space of n x n cells, 2400 m wide, under 0.5 MPa more than what presses
   it together, over Sneddon's (1946) w = 4 (1 - nu) p sqrt(a^2 - r^2) / (pi G): error of the mean square and in the
   middle. All cells outside are pressed by 1 GPa. */
static void Crack(PetscInt n, PetscReal strike, PetscReal dip, PetscReal *error, PetscReal *middle)
{
  const PetscReal radius = 1000, side = 2400 / (PetscReal)n, G = 30e9, nu = 0.25;
  PetscReal *share, *normal, *open, *slip, sum[2] = {0, 0}, nearest = PETSC_MAX_REAL;
  Course course = {.most = 1.5e6};
  SlipFault fault;
  TS ts;
  Vec w;

  ok(PetscMalloc4(n * n, &share, n * n, &normal, n * n, &open, 2 * n * n, &slip));
  for (PetscInt i = 0; i < n * n; i++) {
    const PetscReal x = ((PetscReal)(i % n) + 0.5) * side - 1200, z = ((PetscReal)(i / n) + 0.5) * side - 1200;

    share[i] = hypot(x, z) < radius;
    normal[i] = share[i] != 0 ? 1e6 : 1e9;
  }
  course.share = share;
  fault = Cells(n, n, side, &course);
  ok(FaultSetReals(fault, {"strike", strike}, {"dip", dip}));
  ok(SlipFaultSetField(fault, "normal_stress", n * n, normal));
  ok(FaultStart(fault, TSADAPTBASIC, 0, 30, &w, &ts));
  ok(TSSolve(ts, w));
  ok(SlipFaultGetCellValues(fault, 30, w, "opening", n * n, open));
  ok(SlipFaultGetCellValues(fault, 30, w, "slip", n * n, slip));
  for (PetscInt i = 0; i < n * n; i++) {
    const PetscReal x = ((PetscReal)(i % n) + 0.5) * side - 1200, z = ((PetscReal)(i / n) + 0.5) * side - 1200;
    const PetscReal square = radius * radius - x * x - z * z;
    const PetscReal exact = square > 0 ? 4 * (1 - nu) * 0.5e6 / (PETSC_PI * G) * PetscSqrtReal(square) : 0;

    sum[0] += PetscSqr(open[i] - exact);
    sum[1] += exact * exact;
    if (square < 0) assert_true(open[i] == 0);
    assert_true(hypot(slip[2 * i], slip[2 * i + 1]) < 1e-12);
    if (x * x + z * z < nearest) {
      nearest = x * x + z * z;
      *middle = open[i] / exact - 1;
    }
  }
  *error = PetscSqrtReal(sum[0] / sum[1]);
  ok(PetscFree4(share, normal, open, slip));
  ObjectsDestroy(&fault, &w, &ts);
}

/* Stress at centres leaves an error of a share of a cell at the edge (the slip of a shear crack has the same): -cells
   48 goes on */
static void penny_crack(void **state)
{
  PetscInt finest = 24;

  ok(PetscOptionsGetInt(NULL, NULL, "-cells", &finest, NULL));
  for (PetscInt n = 12; n <= finest; n *= 2) {
    PetscReal error, middle = 1;

    Crack(n, n > 12 ? 40 : 0, n > 12 ? 30 : 90, &error, &middle); /* planes do not matter without a ground */
    printf("%d cells: off by %g, in the middle by %g\n", (int)n, (double)error, (double)middle);
    assert_true(error < 2 / (PetscReal)n && middle > 0 &&
                middle < 0.7 / (PetscReal)n); /* a share of a cell: 1.9 and 0.6 at 12 */
  }
}

/* x at t of eta x' + k x = a + b (t - t0), from x0 at t0 */
static PetscReal Relax(PetscReal eta, PetscReal k, PetscReal a, PetscReal b, PetscReal x0, PetscReal t)
{
  const PetscReal steady = a / k - b * eta / (k * k);

  return steady + b / k * t + (x0 - steady) * PetscExpReal(-k * t / eta);
}

/* A spring: its damping and stiffness */
typedef struct {
  PetscReal eta, k;
} Spring;

/* Of one cell in a full space: eta w' + k w = p - sigma while it is open, and eta u' + k u = T - mu (sigma - p) while
   it slides, without friction while it is open: exponentials between the corners of p. Opening at t [s], before it
   falls again, when it closes, and the slip then, with which it stays. */
static void Exact(const Course *c, Spring across, Spring along, PetscReal sigma, PetscReal T, PetscReal mu, PetscReal t,
                  PetscReal *open, PetscReal *closes, PetscReal *slip)
{
  const PetscReal rate = c->most / c->rise, slides = (sigma - T / mu) / rate, opens = sigma / rate;
  const PetscReal top = c->rise + c->hold, beyond = c->most - sigma;
  PetscReal w, w0, low, high, u;

  w0 = Relax(across.eta, across.k, 0, rate, 0, c->rise - opens);
  w = Relax(across.eta, across.k, beyond, 0, w0, c->hold);
  *open = Relax(across.eta, across.k, beyond, -rate, w, t - top);
  low = t - top;
  high = 2 * c->rise;
  for (int k = 0; k < 100; k++) {
    const PetscReal middle = 0.5 * (low + high);

    if (Relax(across.eta, across.k, beyond, -rate, w, middle) > 0)
      low = middle;
    else
      high = middle;
  }
  *closes = top + low;
  u = Relax(along.eta, along.k, 0, mu * rate, 0, opens - slides);
  *slip = Relax(along.eta, along.k, T, 0, u, *closes - opens);
}

/* Of the same cell as a fault, by so many steps of one length */
static void Computed(Course *course, PetscInt steps, PetscReal T, PetscReal t, PetscReal end, PetscReal *open,
                     PetscReal slip[2], Spring *across, Spring *along)
{
  SlipFault fault = Cells(1, 1, 1000, course);
  PetscReal normal, closed;
  PetscScalar diagonal[3], damping[3];
  Mat K, H;
  Vec w, d;
  TS ts;

  ok(FaultSetReals(fault, {"initial_traction", T}, {"rake", 30}));
  ok(FaultStart(fault, TSADAPTNONE, end / (PetscReal)steps, t, &w, &ts));
  ok(SlipFaultGetOperators(fault, &K, &H, NULL));
  ok(MatCreateVecs(K, &d, NULL));
  for (int k = 0; k < 2; k++) {
    const PetscInt of[] = {0, 1, 2};

    ok(MatGetDiagonal(k ? H : K, d));
    ok(VecGetValues(d, 3, of, k ? damping : diagonal));
  }
  *along = (Spring){damping[0], diagonal[0]};
  *across = (Spring){damping[2], diagonal[2]};
  AssertNear(diagonal[1], diagonal[0], 1e-12 * diagonal[0]); /* a square */
  ok(TSSolve(ts, w));
  ok(SlipFaultGetCellValues(fault, t, w, "opening", 1, open));
  ok(TSSetMaxTime(ts, end));
  ok(TSSolve(ts, w));
  ok(SlipFaultGetCellValues(fault, end, w, "opening", 1, &closed));
  ok(SlipFaultGetCellValues(fault, end, w, "slip", 1, slip));
  ok(SlipFaultGetCellValues(fault, end, w, "normal_stress", 1, &normal));
  assert_true(closed == 0);
  AssertNear(normal, 1e6, 1e-9); /* nothing is left of it */
  ok(SlipFaultDestroy(&fault));
  ObjectsDestroy(&w, &d, &ts);
}

/* A cell that is pushed open and falls shut again, and slides meanwhile: opening on the way, and the slip that stays.
   When the cell starts, opens and closes falls into steps, which leaves an error of their square times the jump of the
   rate, here at most the drop of stress over eta: (h / (eta / k))^2 of the largest. */
static void opens_and_closes(void **state)
{
  const PetscReal T = 0.3e6, t = 2, end = 3.5;
  Course course = {.rise = 1, .hold = 0.5, .most = 2e6};
  PetscReal last[1] = {1};

  for (PetscInt steps = 100; steps <= 1600; steps *= 4) {
    PetscReal open, slip[2], exact[2], closes, error[2];
    Spring across, along;

    Computed(&course, steps, T, t, end, &open, slip, &across, &along);
    Exact(&course, across, along, 1e6, T, 0.6, t, &exact[0], &closes, &exact[1]);
    assert_true(exact[0] > 0 && closes > t && closes < end);
    AssertNear(PetscAtan2Real(slip[1], slip[0]), PETSC_PI / 6, 1e-12);
    error[0] = PetscAbsReal(open / exact[0] - 1);
    error[1] = PetscAbsReal(hypot(slip[0], slip[1]) / exact[1] - 1);
    printf("%d steps: opening off by %g, slip by %g\n", (int)steps, (double)error[0], (double)error[1]);
    assert_true(error[0] < PetscSqr(end / (PetscReal)steps * across.k / across.eta));
    assert_true(error[0] < last[0] / 8 &&
                error[1] < 1e-7); /* 16, where kinks lie alike in their steps; slip has reached its end */
    last[0] = error[0];
  }
}

/* Where a pressure rises that meets no shear stress a rest ends when it meets the normal stress: the search for the end
   stops within the rounding of its time, and steps begin. */
static PetscErrorCode Begin(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  PetscReal *begin = (PetscReal *)ctx, open;
  SlipFault fault;

  PetscCall(TSGetApplicationContext(ts, &fault));
  PetscCall(SlipFaultGetCellValues(fault, time, w, "opening", 1, &open));
  if (open == 0) *begin = time;
  return PETSC_SUCCESS;
}

static void rest_ends_where_pressure_meets_the_stress(void **state)
{
  Course course = {.rise = 8e5, .most = 2e6};
  SlipFault fault = Cells(1, 1, 1000, &course);
  PetscReal begin = -1;
  TS ts;
  Vec w;

  ok(FaultStart(fault, TSADAPTBASIC, 0, 6e5, &w, &ts));
  ok(TSSetApplicationContext(ts, fault));
  ok(TSMonitorSet(ts, Begin, &begin, NULL));
  ok(TSSolve(ts, w));
  AssertNear(begin, 4e5, 1);
  ok(SlipFaultDestroy(&fault));
  ObjectsDestroy(&w, &ts);
}

/* Energies and powers along a run, summed up by the trapezoidal rule */
typedef struct {
  SlipFault fault;
  PetscReal time, power, start, energy, work,
    most;                  /* of the last step; kinetic and elastic at the start and now; largest work */
  PetscReal widest;        /* largest opening [m] */
  PetscInt opened, closed; /* cells that did so, of steps that saw it */
  PetscReal *open;
} Energies;

static PetscErrorCode Book(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Energies *l = (Energies *)ctx;
  SlipFaultObservables o;
  PetscReal power, *open;
  PetscInt N;
  Vec r;

  PetscCall(TSBatheGetReaction(ts, &r));
  PetscCall(SlipFaultGetObservables(l->fault, time, w, r, &o));
  power = o.loading_power - o.viscous_power - o.friction_power;
  l->energy = o.kinetic + o.elastic;
  PetscCall(VecGetSize(w, &N));
  N /= 7;
  PetscCall(PetscMalloc1(N, &open));
  PetscCall(SlipFaultGetCellValues(l->fault, time, w, "opening", N, open));
  if (step == 0) {
    l->start = l->energy;
    PetscCall(PetscCalloc1(N, &l->open));
  } else {
    l->work += 0.5 * (time - l->time) * (power + l->power);
    l->most = PetscMax(l->most, PetscAbsReal(l->energy - l->start));
  }
  for (PetscInt i = 0; i < N; i++) {
    l->opened += open[i] > 0 && l->open[i] == 0;
    l->closed += open[i] == 0 && l->open[i] > 0;
    l->widest = PetscMax(l->widest, open[i]);
    l->open[i] = open[i];
  }
  l->time = time;
  l->power = power;
  return PetscFree(open);
}

/* A plane that dips by 30 degrees, 300 m below the ground, under shear, whose middle a pressure opens and lets fall
   shut: what is stored changes by what loading supplies less what friction and viscosity take. Powers have kinks where
   a cell starts or opens, and jump where it closes, of which the trapezoidal rule leaves the step over the 0.2 s in
   which a cell relaxes, of a cell's share: a twentieth. */
static void balance_of_energy(void **state)
{
  enum { nx = 8, nz = 6 };
  PetscReal share[nx * nz], off, last = 1;

  for (PetscInt i = 0; i < nx * nz; i++)
    share[i] = PetscExpReal(-0.15 * (PetscSqr((PetscReal)(i % nx) - 3.4) + PetscSqr((PetscReal)(i / nx) - 2)));
  for (PetscInt steps = 100; steps <= 1600; steps *= 4) {
    Course course = {.share = share, .rise = 1, .hold = 0.5, .most = 2.5e6};
    SlipFault fault = Cells(nx, nz, 500, &course);
    Energies sums = {.fault = fault};
    Vec w;
    TS ts;

    ok(
      FaultSetReals(fault, {"dip", 30}, {"rake", 60}, {"initial_traction", 0.3e6}, {"strike", 20}, {"depth_top", 300}));
    ok(SlipFaultSetString(fault, "kernel", "half_space"));
    ok(FaultStart(fault, TSADAPTNONE, 3.5 / (PetscReal)steps, 3.5, &w, &ts));
    ok(TSMonitorSet(ts, Book, &sums, NULL));
    ok(TSSolve(ts, w));
    off = PetscAbsReal(sums.energy - sums.start - sums.work) / sums.most;
    printf("%d steps: off by %g of what was stored; %d cells opened, %d closed, %g m at most\n", (int)steps,
           (double)off, (int)sums.opened, (int)sums.closed, (double)sums.widest);
    assert_true(sums.opened > 20 && sums.closed == sums.opened && sums.widest > 0.05);
    assert_true(off < 0.05 * 3.5 / (PetscReal)steps / 0.2 && off < last / 2);
    last = off;
    ok(PetscFree(sums.open));
    ok(SlipFaultDestroy(&fault));
    ObjectsDestroy(&w, &ts);
  }
}

/* Of M w'' + k w = p - sigma from rest, p = most (1 - t / fall): the opening at t, without a ground to fall on */
static PetscReal Swing(PetscReal k, PetscReal omega, PetscReal sigma, const Course *c, PetscReal t)
{
  const PetscReal A = (c->most - sigma) / k, rate = c->most / (c->fall * k);

  return A * (1 - cos(omega * t)) - rate * (t - sin(omega * t) / omega);
}

/* A cell that is closed after a step does not open at all, however fast it closed: its rate has no error. */
static PetscErrorCode ClosedIsExact(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Vec e;

  ok(TSBatheGetEstimates(ts, &e, NULL, NULL));
  if (e && VecRead(w)[5] == 0) assert_true(VecRead(e)[2] == 0); /* three rates, and three displacements */
  return PETSC_SUCCESS;
}

/* One cell with inertia and nothing else: under a pressure that falls over a period it opens, comes back while it is at
   speed, and stays shut. The rule has the second order: errors are of (omega h)^2. */
static void falls_shut(void **state)
{
  const PetscReal sigma = 1e6;

  for (PetscInt steps = 100; steps <= 1600; steps *= 4) {
    Course course = {.most = 2e6};
    SlipFault fault = Cells(1, 1, 1000, &course);
    PetscReal k, mass, omega, period, low, high, open, h;
    SlipFaultObservables o;
    PetscScalar diagonal;
    const PetscInt across = 2;
    Vec w, d;
    Mat K;
    TS ts;

    ok(SlipFaultSetBool(fault, "inertia", PETSC_TRUE));
    ok(SlipFaultSetString(fault, "viscosity", "none"));
    ok(SlipFaultSetUp(fault));
    ok(SlipFaultGetOperators(fault, &K, NULL, &mass));
    ok(MatCreateVecs(K, &d, NULL));
    ok(MatGetDiagonal(K, d));
    ok(VecGetValues(d, 1, &across, &diagonal));
    k = PetscRealPart(diagonal);
    omega = PetscSqrtReal(k / mass);
    course.fall = period = 2 * PETSC_PI / omega;
    h = period / (PetscReal)steps;
    low = 0.5 * period;
    high = period;
    for (int i = 0; i < 60; i++)
      if (Swing(k, omega, sigma, &course, 0.5 * (low + high)) > 0)
        low = 0.5 * (low + high);
      else
        high = 0.5 * (low + high);
    ok(FaultStart(fault, TSADAPTNONE, h, 0.5 * period, &w, &ts));
    ok(TSMonitorSet(ts, ClosedIsExact, NULL, NULL));
    ok(TSSolve(ts, w));
    ok(SlipFaultGetCellValues(fault, 0, w, "opening", 1, &open));
    AssertNear(open / Swing(k, omega, sigma, &course, 0.5 * period), 1, PetscSqr(omega * h));
    ok(TSSetMaxTime(ts, low - h));
    ok(TSSolve(ts, w));
    ok(SlipFaultGetCellValues(fault, 0, w, "opening", 1, &open));
    assert_true(open > 0);
    ok(TSSetMaxTime(ts, low + h));
    ok(TSSolve(ts, w));
    ok(SlipFaultGetCellValues(fault, 0, w, "opening", 1, &open));
    assert_true(open == 0);
    ok(TSSetMaxTime(ts, 3 * period));
    ok(TSSolve(ts, w));
    ok(SlipFaultGetCellValues(fault, 0, w, "opening", 1, &open));
    ok(SlipFaultGetObservables(fault, 3 * period, w, NULL, &o));
    assert_true(open == 0 && o.kinetic == 0 && o.elastic == 0);
    ok(SlipFaultDestroy(&fault));
    ObjectsDestroy(&w, &ts, &d);
  }
}

SLIP_TESTS(penny_crack, opens_and_closes, falls_shut, rest_ends_where_pressure_meets_the_stress, balance_of_energy)
