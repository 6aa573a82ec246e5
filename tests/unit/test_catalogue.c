/* The catalogue of events: its formulas by hand, the integrator's quadrature, the energy residual. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/sliprunfiles.h>
#include <math.h>
#include "tempdir.h"

static void formulas(void **state)
{
  const PetscReal t[] = {1, 2, 3.5}, far[] = {1, 2, 4.5};

  /* 1e-4 to 1e-2: halfway in the logarithm is 1e-3; from rest, and from the other side, straight lines */
  assert_true(fabs(SlipEventCrossing(1e-4, 1e-2, 1e-3) - 0.5) < 1e-14);
  assert_true(fabs(SlipEventCrossing(-1e-4, -1e-2, 1e-3) - 0.5) < 1e-14);
  assert_true(fabs(SlipEventCrossing(0, 4e-3, 1e-3) - 0.25) < 1e-14);
  assert_true(fabs(SlipEventCrossing(1e-3, -3e-3, 1e-3) - 0.5) < 1e-14);
  assert_true(fabs(SlipEventRate(1e-4, 1e-2, 0.5) - 1e-3) < 1e-17);
  assert_true(fabs(SlipEventRate(-1e-4, -1e-2, 0.5) + 1e-3) < 1e-17);
  assert_true(fabs(SlipEventRate(0, 4e-3, 0.25) - 1e-3) < 1e-17);
  assert_true(SlipEventRate(2e-3, 0, 1) == 0);
  /* 5 - (t - 2.4)^2 is highest between its values 3.04, 4.84 and 3.79; the middle counts where it is not the highest,
     and where distances differ too much */
  assert_true(fabs(SlipEventPeak(t, (PetscReal[]){3.04, 4.84, 3.79}) - 5) < 1e-12);
  assert_true(SlipEventPeak(t, (PetscReal[]){3, 4, 6}) == 6);
  assert_true(SlipEventPeak(far, (PetscReal[]){0, 1, 0.9}) == 1);
  /* Mw 6 is 10^18.1 N m, and a unit is 10^1.5 in moment */
  assert_true(fabs(SlipEventMagnitude(pow(10, 18.1)) - 6) < 1e-13);
  assert_true(fabs(SlipEventMagnitude(pow(10, 19.6)) - 7) < 1e-13);
}

/* du/dt = v - v_inf is linear, so that its integral by the nodes of a step is what the step has made of u: to the
   rounding of displacements of 0.2 m in single steps of the method, and by its order in doubled ones. */
static PetscErrorCode CheckQuadrature(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  PetscReal *worst = (PetscReal *)ctx, share[3], weight[3];
  const PetscReal *a[3], *vinf;
  SlipConstraint con;
  SlipFault fault;
  Vec node[3];

  PetscCall(TSBatheGetConstraint(ts, &con));
  PetscCall(SlipConstraintGetContext(con, &fault));
  PetscCall(TSBatheGetQuadrature(ts, share, weight, node));
  PetscCheck(share[0] == 0 && share[1] > 0 && share[1] < 1 && share[2] == 1, PETSC_COMM_SELF, PETSC_ERR_PLIB, "shares");
  for (PetscInt k = 0; k < 3; k++) a[k] = VecRead(node[k]);
  vinf = VecRead(fault->operators.vinf);
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal sum = 0;

    for (PetscInt k = 0; k < 3; k++) sum += attempt->dt * weight[k] * (a[k][3 * i] - vinf[i]);
    *worst = PetscMax(*worst, fabs(a[2][3 * i + 1] - a[0][3 * i + 1] - sum));
  }

  return PETSC_SUCCESS;
}

static PetscReal Quadrature(TSBatheError error, PetscInt steps)
{
  PetscReal worst = 0;
  SlipFault fault;
  TS ts;
  Vec w;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 4}, {"nz", 3}, {"loading_rate", 1e-3}));
  ok(FaultStart(fault, TSADAPTNONE, 4. / steps, 4, &w, &ts)); /* while all cells slide */
  ok(TSBatheSetError(ts, error));
  ok(TSBatheMonitorSet(ts, CheckQuadrature, &worst, NULL));
  ok(TSSolve(ts, w));
  ObjectsDestroy(&w, &ts, &fault);
  return worst;
}

static void quadrature(void **state)
{
  const PetscReal coarse = Quadrature(TSBATHE_ERROR_DOUBLING, 40), fine = Quadrature(TSBATHE_ERROR_DOUBLING, 80);

  AssertLess(Quadrature(TSBATHE_ERROR_EMBEDDED, 40), 1e-15);
  assert_true(coarse < 1e-6 && fine < coarse / 6); /* the local error of a method of second order goes by 8 */
}

/* ---- the energy residual ---- */

typedef struct {
  PetscReal row[EVENT_NUM_COLUMNS];
  PetscInt events;
  SlipFaultObservables start, final;
  PetscReal drop; /* mean of K s at the end [Pa] */
} Outcome;

static PetscReal Read(SlipH5 *h, const char name[], PetscInt *n)
{
  PetscReal *x, value;

  ok(SlipH5ReadReal(h, name, 1, n, &x));
  value = *n ? x[*n - 1] : NAN;
  ok(PetscFree(x));
  return value;
}

/* A fault whose energies are added up, its thrust dipping gently and breaking the surface, so that slip changes its
   normal stress */
typedef struct {
  PetscReal loading; /* [m/s] */
  PetscReal rate;    /* of events [m/s] */
  PetscReal time;    /* of the run [s] */
  PetscReal most;    /* energy residual with 150 steps */
  PetscReal end;     /* error of the end with 150 steps [s] */
  PetscBool thrust;
} Case;

static void SetThrust(SlipFault fault)
{
  ok(FaultSetReals(fault, {"dip", 20}, {"rake", 90}, {"depth_top", 0}, {"normal_stress", 1e7},
                   {"normal_stress_gradient", 0}));
  ok(SlipFaultSetReal(fault, "initial_traction", 7.2e6)); /* over the strength, as friction is 0.7 before any slip */
  ok(SlipFaultSetString(fault, "initial", "traction"));
  ok(SlipFaultSetBool(fault, "initial_unstable", PETSC_TRUE));
  ok(SlipFaultSetInertia(fault, PETSC_TRUE));
}

/* The last event of a run with equal steps, and how many there are */
static Outcome Run(const char law[], Case c, PetscInt steps)
{
  static const struct {
    SlipEventColumn id;
    const char *name;
  } columns[] = {{EVENT_ONSET, "/onset"},
                 {EVENT_END, "/end"},
                 {EVENT_AREA, "/area"},
                 {EVENT_MEAN_SLIP, "/mean_slip"},
                 {EVENT_MOMENT, "/moment"},
                 {EVENT_STRESS_DROP, "/stress_drop"},
                 {EVENT_PEAK_SLIP_RATE, "/peak_slip_rate"},
                 {EVENT_ELASTIC_ENERGY, "/elastic_energy"},
                 {EVENT_RADIATED_ENERGY, "/radiated_energy"},
                 {EVENT_LOADING_WORK, "/loading_work"},
                 {EVENT_ENERGY_RESIDUAL, "/energy_residual"}};
  char folder[TEMPDIR_LENGTH], file[TEMPDIR_LENGTH + 16];
  Outcome out;
  SlipFault fault;
  SlipH5 h;
  TS ts;
  Vec w;

  assert_int_equal(0, TempDirMake("catalogue", folder));
  ok(PetscSNPrintf(file, sizeof(file), "%s/events.h5", folder));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 6}, {"nz", 5}, {"loading_rate", c.loading}, {"event_rate", c.rate}));
  if (c.thrust) SetThrust(fault);
  ok(FaultSetStrings(fault, {"friction_law", law}, {"catalogue", file}));
  ok(FaultStart(fault, TSADAPTNONE, c.time / steps, c.time, &w, &ts));
  assert_true(fault->kind.coupled == c.thrust);
  ok(SlipFaultGetObservables(fault, 0, w, NULL, &out.start));
  ok(SlipFaultOutputStart(fault, ts));
  ok(TSSolve(ts, w));
  ok(SlipFaultOutputFinish(fault, ts, 0, 0));
  ok(SlipFaultGetObservables(fault, c.time, w, NULL, &out.final));
  {
    Vec u, stress;

    ok(SlipFaultGetWork(fault, &u));
    ok(SlipFaultGetWork(fault, &stress));
    ok(VecStrideGather(w, 2, u, INSERT_VALUES));
    ok(MatMult(fault->medium->K, u, stress));
    ok(VecSum(stress, &out.drop));
    ok(SlipFaultRestoreWork(fault, &stress));
    ok(SlipFaultRestoreWork(fault, &u));
  }
  out.drop /= 30;
  ok(SlipH5OpenRead(file, &h));
  for (size_t c = 0; c < sizeof(columns) / sizeof(columns[0]); c++)
    out.row[columns[c].id] = Read(&h, columns[c].name, &out.events);
  ok(SlipH5Close(&h));
  assert_int_equal(0, TempDirRemove(folder));
  assert_int_equal(out.events, fault->run->events);
  ObjectsDestroy(&w, &ts, &fault);
  return out;
}

/* Error of the balance relative to the elastic change, with 150, 300, 600 and 1200 steps, measured: unloaded 9.1e-7
   2.3e-7 7.1e-8 1.1e-8, loaded at a rate of a quarter of the bound, where the work of loading is 6 % of that change,
   2.0e-6 4.2e-7 1.0e-7 3.0e-8 (9.2e-7 to 2.0e-8 with a backward first stage). That is the method's order: a factor of
   64 in all for 8 times the steps, half of which is asked for as cells stop at other places within their steps. Onset
   and end, which a step has in its middle, have the same order: their errors go from 6e-3 and 1.1e-2 s to 4e-4 and 6e-4
   s of steps of 0.2 and 0.05 s (3e-3 without the state of the first stage). So do slip and peak rate, 2e-4 to 4e-4 with
   the longest steps. The thrust, whose normal stress slip changes while that does no work, starts with a force that
   nothing balances: 3.1e-5 and 4.7e-7, the same 64. Its last cells stop within a fifth of the longest steps, 1.4e-2
   s. */
static void energy_residual(void **state)
{
  static const Case cases[] = {{0, 1e-3, 30, 4e-6, 1.2e-2, PETSC_FALSE},
                               {1e-3, 4e-3, 30, 4e-6, 8e-3, PETSC_FALSE},
                               {0, 1e-3, 10, 1e-4, 2e-2, PETSC_TRUE}};

  for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(cases); c++) {
    const Outcome coarse = Run("exponential_slip_weakening", cases[c], 150);
    const Outcome middle = Run("exponential_slip_weakening", cases[c], 600);
    const Outcome fine = Run("exponential_slip_weakening", cases[c], 1200);

    assert_int_equal(1, coarse.events);
    assert_int_equal(1, fine.events);
    AssertLess(fabs(coarse.row[EVENT_ENERGY_RESIDUAL]), cases[c].most);
    AssertLess(32 * fabs(fine.row[EVENT_ENERGY_RESIDUAL]), fabs(coarse.row[EVENT_ENERGY_RESIDUAL]));
    assert_true((cases[c].loading != 0) ==
                (fabs(fine.row[EVENT_LOADING_WORK] / fine.row[EVENT_ELASTIC_ENERGY]) > 0.05));
    assert_true(fine.row[EVENT_RADIATED_ENERGY] > 0 && fine.row[EVENT_ELASTIC_ENERGY] < 0);
    AssertNear(coarse.row[EVENT_ONSET], fine.row[EVENT_ONSET], 8e-3);
    AssertNear(middle.row[EVENT_ONSET], fine.row[EVENT_ONSET], 1e-3);
    AssertNear(coarse.row[EVENT_END], fine.row[EVENT_END], cases[c].end);
    AssertNear(middle.row[EVENT_END], fine.row[EVENT_END], 8e-4);
    AssertNear(coarse.row[EVENT_MEAN_SLIP] / fine.row[EVENT_MEAN_SLIP], 1, 5e-4);
    AssertNear(coarse.row[EVENT_PEAK_SLIP_RATE] / fine.row[EVENT_PEAK_SLIP_RATE], 1, 6e-4);
  }
}

/* Of an event that is nearly the whole run, as its rate is 1e-5 of the peak: slip, moment and energies are those of the
   states at both ends of the run, the stress drop is K times the slip. What is missing moved at less than 1e-5 of the
   peak: 1e-4 of the slip. */
static void whole_run(void **state)
{
  const PetscReal area = 9e6, G = 30e9;
  const Outcome o = Run("exponential_slip_weakening", (Case){0, 3e-7, 30, 0, 0, PETSC_FALSE}, 600);

  assert_int_equal(1, o.events);
  assert_true(fabs(o.row[EVENT_AREA] / area - 1) < 1e-14);
  assert_true(fabs(o.row[EVENT_MEAN_SLIP] / o.final.mean_slip - 1) < 1e-4);
  assert_true(fabs(o.row[EVENT_MOMENT] / (G * area * o.row[EVENT_MEAN_SLIP]) - 1) < 1e-14);
  assert_true(fabs(o.row[EVENT_ELASTIC_ENERGY] / (area * (o.final.elastic - o.start.elastic)) - 1) < 1e-4);
  assert_true(fabs(o.row[EVENT_STRESS_DROP] / o.drop - 1) < 1e-4);
  assert_true(o.row[EVENT_STRESS_DROP] > 1e6);
}

/* ---- cells that always slide ---- */

typedef struct {
  PetscReal moment, dissipated, radiated, duration, residual; /* of the first event; the largest residual of all */
  PetscInt cell;
} Smooth;

/* The first events of 8 x 4 cells of 2 km, too large for their nucleation, so that rates grow by decades in a step;
   tolerance 0: the default */
static Smooth RunSmooth(const char type[], const char pair[], PetscReal tolerance)
{
  char folder[TEMPDIR_LENGTH], file[TEMPDIR_LENGTH + 16];
  PetscReal *x, onset;
  PetscInt n, first;
  Smooth out = {0};
  SlipFault fault;
  TSAdapt adapt;
  SlipH5 h;
  TS ts;
  Vec w;

  assert_int_equal(0, TempDirMake("catalogue", folder));
  ok(PetscSNPrintf(file, sizeof(file), "%s/events.h5", folder));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"friction_law", "rate_and_state"}, {"catalogue", file}));
  ok(FaultSetReals(fault, {"nx", 8}, {"nz", 4}, {"length_x", 16e3}, {"length_z", 8e3}, {"loading_rate", 1e-9},
                   {"normal_stress", 5e7}, {"normal_stress_gradient", 0}, {"friction_slip", 0.02},
                   {"friction_a", 0.008}, {"friction_b", 0.012}, {"initial_rate", 1e-10}));
  ok(SlipFaultSetUp(fault));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipFaultConfigureTS(fault, ts));
  if (type) ok(TSSetType(ts, type));
  if (pair) ok(TSRKSetType(ts, pair));
  ok(TSGetAdapt(ts, &adapt));
  if (tolerance > 0) {
    ok(TSAdaptSetType(adapt, TSADAPTBASIC));
    ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, tolerance, NULL));
  }
  ok(TSSetMaxTime(ts, 5.225e8)); /* 16.557 years */
  ok(SlipFaultCreateState(fault, &w));
  ok(SlipFaultSetInitialState(fault, w));
  ok(SlipFaultOutputStart(fault, ts));
  ok(TSSolve(ts, w));
  ok(SlipFaultOutputFinish(fault, ts, 0, 0));
  ok(SlipH5OpenRead(file, &h));
  ok(SlipH5ReadReal(&h, "/energy_residual", 1, &n, &x));
  assert_true(n >= 2);
  for (PetscInt k = 0; k < n; k++) out.residual = PetscMax(out.residual, fabs(x[k]));
  ok(PetscFree(x));
#define FIRST(name, value)                                                                                             \
  ok(SlipH5ReadReal(&h, name, 1, &first, &x));                                                                         \
  value = x[0];                                                                                                        \
  ok(PetscFree(x));
  FIRST("/moment", out.moment)
  FIRST("/dissipated_energy", out.dissipated)
  FIRST("/radiated_energy", out.radiated)
  FIRST("/end", out.duration)
  FIRST("/onset", onset)
  FIRST("/cell", out.cell)
#undef FIRST
  out.duration -= onset;
  ok(SlipH5Close(&h));
  assert_int_equal(0, TempDirRemove(folder));
  ObjectsDestroy(&w, &ts, &fault);
  return out;
}

/* Residuals of all events, in brackets with trapezoids between the ends of steps: 1.0e-3 (2.2e-2) of Adams' formulas,
   3.1e-3 (5.5e-2) of the pair 5dp, 4.1e-4 (4.9e-3) of 3bs, which has no dense output. Heat and
   duration of the first event are off by 3e-4 to 6e-4 and by up to 7e-4 (1e-2) from a run with a thousandth of the
   tolerance. */
static void smooth(void **state)
{
  static const struct {
    const char *type, *pair;
    PetscReal tolerance, residual, event;
  } cases[] = {{NULL, NULL, 1e-3, 2e-3, 2e-3},
               {TSRK, TSRK5DP, 1e-3, 7e-3, 2e-3},
               {TSRK, TSRK3BS, 1e-3, 1e-3, 2e-3},
               {NULL, NULL, 0, 2e-2, 2e-2}};
  const Smooth fine = RunSmooth(NULL, NULL, 1e-6);

  AssertLess(fine.residual, 1e-4);
  for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(cases); c++) {
    const Smooth found = RunSmooth(cases[c].type, cases[c].pair, cases[c].tolerance);
    const PetscReal worst =
      PetscMax(fabs(found.dissipated / fine.dissipated - 1), fabs(found.duration / fine.duration - 1));

    AssertLess(found.residual, cases[c].residual);
    AssertLess(worst, cases[c].event);
    assert_int_equal(fine.cell, found.cell);
  }
}

SLIP_TESTS(formulas, quadrature, energy_residual, whole_run, smooth)
