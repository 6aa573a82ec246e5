/* Explicit steps, TSMOREAU: order on blocks, stops and rest, sliding mode and circuit against exact solutions, the 3 km
   fault, every kind of faults against TSBATHE at short steps, and what a step costs. */
#include "smallsteps.h"
#include "faultstart.h"
#include "policies.h"
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* ---- blocks: m v' = load - K u - H v + r, |r| <= q(s), K and H full ---- */

enum { MOST = 3, ROWS = 3 * MOST };
typedef struct {
  PetscInt n;
  PetscReal K[MOST][MOST], H[MOST][MOST], load, strength, drop, slip;
} Blocks;

static PetscReal Strength(const Blocks *b, PetscReal s)
{
  return b->strength - b->drop + b->drop * exp(-s / b->slip);
}

/* w is v, u, s of all blocks */
static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const Blocks *b = (const Blocks *)ctx;

  for (PetscInt i = 0; i < b->n; i++) {
    F[i] = b->load;
    for (PetscInt j = 0; j < b->n; j++) F[i] -= b->K[i][j] * w[b->n + j] + b->H[i][j] * w[j];
    F[b->n + i] = w[i];
    F[2 * b->n + i] = fabs(w[i]);
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  const Blocks *b = (const Blocks *)ctx;
  const PetscInt n = b->n, N = 3 * n;

  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < n; j++) {
      J[i * N + n + j] = -b->K[i][j];
      J[i * N + j] = -b->H[i][j];
    }
    J[(n + i) * N + i] = 1;
    J[(2 * n + i) * N + i] = w[i] < 0 ? -1 : 1;
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode Bound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  const Blocks *b = (const Blocks *)ctx;

  for (PetscInt i = 0; i < b->n; i++) q[i] = Strength(b, w[2 * b->n + i]);
  return PETSC_SUCCESS;
}

static TS Explicit(Blocks *b)
{
  const PetscReal mass[ROWS] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
  const PetscInt rows[MOST] = {0, 1, 2};
  const SlipSmall problem = {3 * b->n, mass, b->n, rows, Force, Jacobian, Bound, b};
  TS ts;

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipSmallConfigureTS(&problem, ts));
  ok(TSSetType(ts, TSMOREAU)); /* the constraint stays */
  return ts;
}

/* H and K do not commute where there are several */
static Blocks Chain(PetscInt n)
{
  Blocks b = {.n = n, .load = 1.5, .strength = 1, .drop = 0.4, .slip = 0.3};

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) {
      b.K[i][j] = i == j ? 2 + (PetscReal)i : (abs((int)(i - j)) == 1 ? -1 : 0);
      b.H[i][j] = i == j ? 0.7 : (abs((int)(i - j)) == 1 ? -0.2 : 0.05);
    }
  return b;
}

static PetscReal EnergyOf(const Blocks *b, const PetscReal w[])
{
  PetscReal E = 0;

  for (PetscInt i = 0; i < b->n; i++) {
    E += 0.5 * w[i] * w[i] - b->load * w[b->n + i];
    for (PetscInt j = 0; j < b->n; j++) E += 0.5 * w[b->n + i] * b->K[i][j] * w[b->n + j];
  }
  return E;
}

/* While all slide forwards: classical Runge-Kutta steps, of an error below 1e-12 */
static void Reference(Blocks *b, PetscReal end, PetscReal w[])
{
  const PetscInt steps = 20000, n = 3 * b->n;
  const PetscReal h = end / steps;

  for (PetscInt k = 0; k < steps; k++) {
    PetscReal d[4][ROWS], z[ROWS];

    for (int s = 0; s < 4; s++) {
      for (PetscInt i = 0; i < n; i++) z[i] = w[i] + (s ? (s == 3 ? h : 0.5 * h) * d[s - 1][i] : 0);
      ok(Force(0, z, d[s], b));
      for (PetscInt i = 0; i < b->n; i++) d[s][i] -= Strength(b, z[2 * b->n + i]);
    }
    for (PetscInt i = 0; i < n; i++) w[i] += h / 6 * (d[0][i] + 2 * d[1][i] + 2 * d[2][i] + d[3][i]);
    for (PetscInt i = 0; i < b->n; i++) assert_true(w[i] > 0);
  }
}

/* Steps of three lengths in turn, with the mean that constant ones have: the application context */
static PetscErrorCode Vary(TS ts)
{
  const PetscReal share[] = {1.3, 0.6, 1.1};
  const PetscReal *h;
  PetscInt step;

  PetscCall(TSGetApplicationContext(ts, (void *)&h));
  PetscCall(TSGetStepNumber(ts, &step));
  return TSSetTimeStep(ts, *h * share[step % 3]);
}

/* Errors at the end of the slip of all blocks and of the energy, with steps that vary or do not */
static void ErrorsAt(Blocks *b, PetscInt steps, PetscBool vary, PetscReal error[2])
{
  const PetscReal end = 1.2;
  PetscReal w[ROWS], exact[ROWS] = {0}, h = end / steps;
  TS ts = Explicit(b);
  Vec x = State(3 * b->n, exact);

  Reference(b, end, exact);
  ok(TSSetApplicationContext(ts, &h));
  if (vary) ok(TSSetPreStep(ts, Vary));
  Steps(ts, x, end, steps);
  Get(x, 3 * b->n, w);
  error[0] = 0;
  for (PetscInt k = 0; k < b->n; k++) error[0] += fabs(w[2 * b->n + k] - exact[2 * b->n + k]);
  error[1] = fabs(EnergyOf(b, w) - EnergyOf(b, exact));
  ObjectsDestroy(&ts, &x);
}

/* A factor of 4 for half the steps, of which the next term of the error takes or gives a fifth at these lengths; the
   forces of the start exceed the strength, so that all slide at once */
static void test_order(void **state)
{
  for (PetscInt n = 1; n <= MOST; n += 2)
    for (int vary = 0; vary < 2; vary++) {
      Blocks b = Chain(n);
      PetscReal coarse[2], fine[2];

      ErrorsAt(&b, 60, vary ? PETSC_TRUE : PETSC_FALSE, coarse);
      ErrorsAt(&b, 120, vary ? PETSC_TRUE : PETSC_FALSE, fine);
      for (int k = 0; k < 2; k++) {
        AssertLess(fine[k], 1e-3);
        AssertNear(coarse[k] / fine[k], 4, 0.8);
      }
    }
}

/* Without damping and weakening u'' = (load - q) - k u from rest stops after half a period at u = 2 (load - q)/k, and
   stays there while the spring pulls less than q: exactly, and the reaction balances it. A block whose load is below
   its strength does not move at all. */
static void test_stop(void **state)
{
  Blocks b = {.n = 1, .K = {{1}}, .load = 1.5, .strength = 1, .slip = 1};
  PetscReal w[3] = {0}, before[2], r;

  for (int k = 0; k < 2; k++) {
    const PetscReal start[3] = {0};
    Vec x = State(3, start), reaction;
    TS ts = Explicit(&b);

    Steps(ts, x, 4, 70 << (2 * k)); /* the stop, at pi, falls within a step */
    Get(x, 3, w);
    ok(TSBatheGetReaction(ts, &reaction));
    Get(reaction, 1, &r);
    assert_true(w[0] == 0);
    assert_true(w[1] == w[2]);
    AssertNear(r, w[1] - b.load, 1e-14);
    before[k] = fabs(w[1] - 2 * (b.load - b.strength));
    ObjectsDestroy(&ts, &x);
  }
  AssertLess(before[0], 0.5 * 0.5 * PetscSqr(4. / 70)); /* of less than a step's deceleration, a h^2/2 */
  AssertLess(before[1], 0.5 * 0.5 * PetscSqr(4. / 280));
  b.load = 0.99;
  {
    const PetscReal start[3] = {0};
    Vec x = State(3, start);
    TS ts = Explicit(&b);

    Steps(ts, x, 4, 20);
    Get(x, 3, w);
    assert_true(w[0] == 0 && w[1] == 0 && w[2] == 0);
    ObjectsDestroy(&ts, &x);
  }
}

/* ---- models with exact solutions ---- */

enum { CIRCUIT_STATES = 3 };
typedef struct {
  SlipModel model;
  PetscReal h, largest;
  const PetscReal *table;
} Against;

static PetscErrorCode Compare(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Against *a = (Against *)ctx;
  PetscReal value, r;

  if (step < 0) return PETSC_SUCCESS;
  Get(w, 1, &value);
  a->largest =
    PetscMax(a->largest,
             fabs(value - (a->table ? a->table[CIRCUIT_STATES * step] : (*a->model->ops->exact)(a->model, time, &r))));
  return PETSC_SUCCESS;
}

static PetscReal ModelError(const SlipModelOps *ops, PetscReal end, PetscInt steps)
{
  PetscReal *table = NULL;
  Against a = {.h = end / steps};
  TS ts;
  Vec w;

  ok(SlipModelCreate(ops, SLIP_MODEL_EVALUATION, &a.model));
  if (!ops->exact) {
    ok(PetscMalloc1(CIRCUIT_STATES * (steps + 1), &table));
    SlipModelExactTable(a.model, end / steps, steps + 1, table);
    a.table = table;
  }
  ok(SlipModelCreateState(a.model, &w));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSMOREAU));
  ok(SlipModelConfigureTS(a.model, ts)); /* leaves the type */
  ok(TSMonitorSet(ts, Compare, &a, NULL));
  Steps(ts, w, end, steps);
  ObjectsDestroy(&ts, &w);
  ok(SlipModelDestroy(&a.model));
  ok(PetscFree(table));
  return a.largest;
}

/* The largest error at any time, arrests, departures and turns included: of second order, a factor of 16 for a quarter
   of the step */
static void test_models(void **state)
{
  PetscReal error[2];

  for (int k = 0; k < 2; k++) error[k] = ModelError(&SlipSlidingModeOps, 0.5, 250 << (2 * k));
  AssertLess(error[0], 1e-4);
  AssertNear(error[0] / error[1], 16, 1);
  for (int k = 0; k < 2; k++) error[k] = ModelError(&SlipCircuitOps, 10, 500 << (2 * k));
  AssertNear(error[0] / error[1], 16, 1);
}

/* ---- faults ---- */

enum { TIMES = 4096 };
typedef struct {
  SlipFault fault;
  PetscInt n;
  PetscReal slip[TIMES];
} Course;

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Course *c = (Course *)ctx;
  SlipFaultObservables obs;

  if (step < 0) return PETSC_SUCCESS;
  PetscCall(SlipFaultGetObservables(c->fault, time, w, NULL, &obs));
  c->slip[c->n++] = obs.mean_slip;
  return PETSC_SUCCESS;
}

static PetscErrorCode (*before_step)(TS);
static PetscInt *monitor_ctx;
static PetscErrorCode CountMethods(TS, const SlipAttempt *, Vec, void *);

/* The mean slip after each of so many constant steps up to end */
static void Run(const char options[], const char type[], PetscReal end, PetscInt steps, Course *c)
{
  TS ts;
  Vec w;

  ok(SetOptions(options));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &c->fault));
  ok(SlipFaultSetFromOptions(c->fault));
  c->n = 0;
  ok(FaultStart(c->fault, TSADAPTNONE, end / steps, end, &w, &ts));
  ok(TSSetType(ts, type));
  ok(TSMonitorSet(ts, Follow, c, NULL));
  if (before_step) ok(TSSetPreStep(ts, before_step));
  if (monitor_ctx) ok(TSBatheMonitorSet(ts, CountMethods, monitor_ctx, NULL));
  ok(TSSolve(ts, w));
  ObjectsDestroy(&ts, &w);
  ok(SlipFaultDestroy(&c->fault));
  ok(PetscOptionsClear(NULL));
}

/* The largest difference at the times of the coarser one, over the last slip of the finer */
static PetscReal Off(const Course *coarse, const Course *fine)
{
  const PetscInt every = (fine->n - 1) / (coarse->n - 1);
  PetscReal most = 0;

  assert_int_equal(every * (coarse->n - 1), fine->n - 1); /* no step was cut */
  for (PetscInt k = 0; k < coarse->n; k++) most = PetscMax(most, fabs(coarse->slip[k] - fine->slip[every * k]));
  return most / fine->slip[fine->n - 1];
}

/* Against TSBATHE at an eighth of the step, whose own error is a hundredth of what is allowed: of second order, with
   every law of ours and all that acts on a cell. A factor of 4, of which cells that start and stop within steps may
   take a third. */
static const struct {
  const char *name, *options;
  PetscReal allowed; /* with 100 steps */
} Kinds[] = {
  {"the root of K as viscosity", "", 4e-3},
  {"radiation", "-fault_viscosity radiation", 4e-3},
  {"no viscosity", "-fault_viscosity none", 4e-3},
  {"rate weakening", "-fault_friction_law rate_weakening -fault_friction_rate 1", 1.5e-2},
  {"coupled normal stress", "-fault_dip 40 -fault_rake 90", 4e-3},
  {"vectors", "-fault_dip 40 -fault_rake 60 -fault_slip_components 2", 4e-3},
  {"rate and state",
   "-fault_friction_law rate_and_state -fault_inertia yes -fault_initial_rate 0.1 -fault_friction_slip 0.02", 2.5e-2},
  {"opening",
   "-fault_initial traction -fault_initial_traction 1.21e7 -fault_initial_unstable yes -fault_inertia yes "
   "-fault_slip_components 2 -fault_opening yes -fault_friction_law linear_slip_weakening -fault_injection 1400,3000 "
   "-fault_injection_pressure 3e7 -fault_injection_diffusivity 2e4 -fault_viscosity radiation",
   4e-3},
};

static void test_kinds(void **state)
{
  static Course fine, coarse;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Kinds); k++) {
    char options[1024];
    PetscReal off[2];

    snprintf(options, sizeof(options),
             "-fault_nx 4 -fault_nz 3 -fault_depth_top 2000 -fault_normal_stress 2e7 -fault_progress no %s",
             Kinds[k].options);
    Run(options, TSBATHE, 12, 800, &fine);
    for (int i = 0; i < 2; i++) {
      Run(options, TSMOREAU, 12, 100 << i, &coarse);
      off[i] = Off(&coarse, &fine);
    }
    AssertLess(off[0], Kinds[k].allowed);
    AssertLess(2.6 * off[1], off[0]);
  }
}

/* Both methods in turn, from attempt to attempt, as a controller may choose them */
static PetscErrorCode Alternate(TS ts)
{
  PetscInt step;

  PetscCall(TSGetStepNumber(ts, &step));
  return TSBatheSetMethod(ts, step / 3 % 2 ? TSBATHE_METHOD_EXPLICIT : TSBATHE_METHOD_IMPLICIT);
}

static PetscErrorCode CountMethods(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  ((PetscInt *)ctx)[attempt->method]++;
  return PETSC_SUCCESS;
}

/* A step far longer than stable is cut to what is until all rests, and the slip stays right; a factor of 4 for half
   the steps where both methods take turns. */
static void test_methods(void **state)
{
  static Course fine, coarse, still;
  const char *options = "-fault_nx 4 -fault_nz 3 -fault_depth_top 2000 -fault_normal_stress 2e7 -fault_progress no";
  PetscReal off[2];

  Run(options, TSBATHE, 12, 800, &fine);
  Run(options, TSMOREAU, 12, 3, &coarse);
  assert_in_range(coarse.n, 20, 60);
  AssertNear(coarse.slip[coarse.n - 1] / fine.slip[fine.n - 1], 1, 3e-2); /* 27 steps */
  Run(options, TSMOREAU, 60, 15, &coarse);
  Run(options, TSMOREAU, 120, 30, &still);
  assert_int_equal(still.n, coarse.n + 15); /* it rests, in steps of 4 s as asked for */
  assert_true(still.slip[still.n - 1] == coarse.slip[coarse.n - 1]);
  for (int i = 0; i < 2; i++) {
    PetscInt attempts[2] = {0};

    before_step = Alternate;
    monitor_ctx = attempts;
    Run(options, TSBATHE, 12, 100 << i, &coarse);
    before_step = NULL;
    monitor_ctx = NULL;
    assert_in_range(attempts[0], 45 << i, 55 << i);
    assert_in_range(attempts[1], 45 << i, 55 << i);
    off[i] = Off(&coarse, &fine);
  }
  assert_true(off[0] < 4e-3 && off[0] > 2.6 * off[1]);
}

/* How often products with K and H were asked for in the run */
static PetscInt Products(const char event[])
{
  PetscEventPerfInfo info;
  PetscLogStage stage;
  PetscLogEvent id;

  ok(PetscLogEventGetId(event, &id));
  ok(PetscLogStageGetId("Main Stage", &stage));
  ok(PetscLogEventGetPerfInfo(stage, id, &info));
  return (PetscInt)info.count;
}

/* The 3 km fault on 24 x 24 cells: errors of the history as a scheme of ten lines has them, and one product with K and
   one with H a step, observed at each. */
static void test_3km(void **state)
{
  const char *options = "-fault_nx 24 -fault_nz 24 -fault_stiffness_scaling mean_slip -fault_progress no "
                        "-mat_slipsqrtm_setup sketch"; /* Lanczos' method makes H of products with K */
  const struct {
    PetscInt steps;
    PetscReal most;
  } row[] = {{150, 7e-3}, {250, 2.8e-3}, {400, 1.2e-3}};
  static Course fine, coarse;

  ok(PetscLogDefaultBegin());
  Run(options, TSMOREAU, 30, 3000, &fine);
  for (int i = 0; i < 3; i++) {
    const PetscInt stiffness = Products("SlipKMult"), viscosity = Products("SlipHMult");
    PetscReal most = 0;

    Run(options, TSMOREAU, 30, row[i].steps, &coarse);
    for (PetscInt k = 0; k < coarse.n; k++)
      most = PetscMax(most, fabs(coarse.slip[k] - fine.slip[3000 * k / row[i].steps]));
    most /= fine.slip[fine.n - 1];
    assert_true((3000 % row[i].steps == 0 || row[i].steps == 400) && most < row[i].most);
    assert_int_equal(row[i].steps + 2, Products("SlipHMult") - viscosity); /* the start is observed before the run */
    /* of the set-up the critical state and the largest frequency */
    assert_in_range(Products("SlipKMult") - stiffness, row[i].steps + 1, row[i].steps + 120);
  }
  fine.n = Products("SlipHMult"); /* long steps at rest have no more, as they keep their force and are not damped */
  Run("-fault_nx 8 -fault_nz 8 -fault_stiffness_scaling mean_slip -fault_progress no", TSMOREAU, 80, 40, &coarse);
  assert_int_equal(Products("SlipHMult") - fine.n, coarse.n + 1);
}

/* What moves is observed without a product of its own: the change of the force over the step is that of its inner rate,
   and on a thrust that of the normal stress. test_episodes.c compares values with those of dense matrices. */
static void Observed(PetscReal dip)
{
  SlipPolicy policy = PolicyOfOne("log_growth_time", 0, -0.9, 1); /* steps that hardly differ */
  PetscInt before, steps, k;
  SlipFault fault;
  PetscReal longest;
  TSAdapt adapt;
  TS ts;
  Vec w;

  ok(PetscLogDefaultBegin());
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 6}, {"nz", 5}, {"dip", dip}, {"rake", dip < 90 ? 90 : 0}));
  ok(FaultStart(fault, TSADAPTRL, 0.01, 1, &w, &ts));
  ok(TSSetType(ts, TSMOREAU));
  ok(TSSetSolution(ts, w));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptRLSetPolicy(adapt, policy));
  ok(TSBatheGetLongestStep(ts, &longest)); /* its products */
  before = Products("SlipKMult");          /* Kn too */
  ok(TSSolve(ts, w));
  ok(TSGetStepNumber(ts, &steps));
  k = Products("SlipKMult") - before;
  AssertLess(20, steps);
  /* one a step; and the start, its displacement, and that of the instability */
  assert_in_range(k, dip < 90 ? 2 * steps : steps, dip < 90 ? 2 * steps + 8 : steps + 4);
  ObjectsDestroy(&ts, &w, &fault, &policy);
}

static void test_observed(void **state)
{
  Observed(90);
  Observed(40);
}

/* ---- what cannot be ---- */

static void test_refused(void **state)
{
  SlipFault fault;
  PetscReal longest;
  TS ts;
  Vec w;

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSMOREAU));
  ok(VecCreateSeq(PETSC_COMM_SELF, 3, &w));
  ok(TSSetMaxTime(ts, 1));
  fails(TSSolve(ts, w), "expected -ts_type bathe");
  ObjectsDestroy(&ts, &w);
  /* a fault without inertia */
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 3}, {"nz", 2}));
  ok(SlipFaultSetInertia(fault, PETSC_FALSE));
  ok(FaultStart(fault, NULL, 0, 0, &w, &ts));
  ok(TSBatheSetMethod(ts, TSBATHE_METHOD_EXPLICIT));
  ok(TSSetSolution(ts, w));
  ok(TSBatheGetLongestStep(ts, &longest));
  assert_true(longest == 0);
  fails(TSSolve(ts, w), "expected -ts_type bathe");
  ObjectsDestroy(&ts, &w);
  ok(SlipFaultDestroy(&fault));
}

/* ---- the cell ---- */

/* The speed balances, sticks below the strength and only there, whatever the guess; what does not move does not change,
   slip is v h, and the state of rate-and-state friction is of second order. */
static void test_cell(void **state)
{
  const PetscReal residual = 0.5, drop = 0.1, slip = 0.05, rate = 0.3, stress = 2;
  SlipFrictionCells f = {.residual = &residual, .drop = &drop, .slip = &slip, .rate = &rate, .stress = &stress};
  const PetscReal at[] = {0.02};
  const SlipFrictionStageCell cell = {.diagonal = 3, .omega = 1, .s0 = at};
  PetscReal s, v = 0.2, still = 0, work;

  ok(SlipFrictionFind("rate_weakening", &f.law));
  for (PetscReal load = 0; load < 4; load += 0.05)
    for (PetscReal guess = 0; guess < 2; guess += 0.5) {
      PetscBool solved = PETSC_TRUE;
      const PetscReal speed = SlipFrictionKick(&f, 0, &cell, load, guess, &solved);
      PetscReal mu, ds, dv;

      SlipFrictionEvaluate(&f, 0, at, speed, &mu, &ds, &dv);
      assert_true(solved);
      if (speed == 0)
        assert_true(load <= stress * mu);
      else
        AssertNear(3 * speed + stress * mu, load, 1e-13);
    }
  s = 0.3;
  SlipFrictionStateDrift(&f, 1, 0.7, &v, 1, &s, &work);
  assert_true(s == 0.3 + 0.7 * v);
  SlipFrictionStateDrift(&f, 1, 0.7, &still, 1, &s, &work);
  assert_true(s == 0.3 + 0.7 * v);
}

SLIP_TESTS(test_order, test_stop, test_models, test_kinds, test_methods, test_3km, test_observed, test_refused,
           test_cell)
