/* One cell under loading: creep by long steps with both rules of the first stage, the start under a traction against
   the critical one, and what of a displacement is slip; cells that creep at a given rate, and rate-and-state friction
   that starts backward and under pressure. */
#include "unit.h"
#include "faultstart.h"
#include "tempdir.h"
#include "record.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <string.h>

static const PetscReal sigma = 50e6, drop = 0.1, residual = 0.5, v_inf = 1e-9, side = 1000;

static PetscReal Stiffness(void)
{
  return 30e9 * sqrt(2) / PETSC_PI * (7.0 / 3) / side; /* of a square in a full space, nu = 1/4 */
}

/* One square cell that weakens by share of its stiffness */
static SlipFault Fault(const char law[], const char initial[], PetscReal share)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"kernel", "full_space"}, {"viscosity", "radiation"}, {"friction_law", law},
                     {"initial", initial}));
  ok(FaultSetReals(fault, {"nx", 1}, {"nz", 1}, {"length_x", side}, {"length_z", side}, {"normal_stress", sigma},
                   {"normal_stress_gradient", 0}, {"friction_drop", drop}, {"friction_residual", residual},
                   {"friction_slip", sigma * drop / (share * Stiffness())}));
  return fault;
}

/* Slip rates after each step from the fourth on, over the loading rate */
typedef struct {
  PetscReal least, largest;
} Rates;

static PetscErrorCode Watch(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Rates *rates = (Rates *)ctx;
  const PetscReal *a = VecRead(w);
  PetscReal v;

  v = a[0] / v_inf;
  if (step < 4) rates->least = rates->largest = v;
  rates->least = PetscMin(rates->least, v);
  rates->largest = PetscMax(rates->largest, v);
  return PETSC_SUCCESS;
}

static Rates Creep(TSBatheFirstStage rule, PetscReal excess, PetscBool inertia)
{
  SlipFault fault = Fault("linear_slip_weakening", "traction", 0.5);
  Rates rates = {0};
  TS ts;
  Vec w;

  ok(SlipFaultSetReal(fault, "initial_traction", (1 + excess) * (residual + drop) * sigma));
  fault->options.initial_unstable = PETSC_TRUE;
  ok(SlipFaultSetReal(fault, "loading_rate", v_inf));
  ok(SlipFaultSetInertia(fault, inertia));
  ok(FaultStart(fault, TSADAPTNONE, 1e6, 1e8, &w, &ts));
  ok(TSBatheSetFirstStage(ts, rule));
  ok(TSMonitorSet(ts, Watch, &rates, NULL));
  ok(TSSolve(ts, w));
  ObjectsDestroy(&w, &ts, &fault);
  return rates;
}

/* Three years of creep by a hundred steps, each a million times as long as inertia takes, from a state without slip
   rate that is at the strength, or above it by what one step loads. Strength falls by half the stiffness: K (v - v_inf)
   = K v/2, so that v = 2 v_inf. The trapezoidal rule alone would repeat what the rate of a step's start is off by with
   the other sign; the backward formula after it takes that away, so neither rule toggles here. */
static void creep_does_not_toggle(void **state)
{
  for (int k = 0; k < 6; k++) {
    const TSBatheFirstStage rule = k < 2 ? TSBATHE_STAGE_TRAPEZOIDAL : TSBATHE_STAGE_BACKWARD;
    const Rates rates = Creep(rule, k % 2 ? 1e-3 : 0, k < 4 ? PETSC_TRUE : PETSC_FALSE);

    /* radiation leaves H/(K theta) = 1e-6 of an excess in each step */
    assert_true(fabs(rates.least / 2 - 1) < 1e-5 && fabs(rates.largest / 2 - 1) < 1e-5);
  }
}

/* Slip and slip rate at the end of an event */
static void Event(const char initial[], PetscReal end, PetscReal *slip, PetscReal *rate)
{
  SlipFault fault = Fault("exponential_slip_weakening", initial, 3);
  const PetscReal *a;
  TS ts;
  Vec w;

  /* the critical start's excess of 1e-5 */
  if (!strcmp(initial, "traction"))
    ok(SlipFaultSetReal(fault, "initial_traction", (1 + 1e-5) * (residual + drop) * sigma));
  fault->options.initial_unstable = PETSC_TRUE;
  ok(SlipFaultSetInertia(fault, PETSC_TRUE)); /* a traction alone would be without */
  ok(FaultStart(fault, TSADAPTNONE, 0.01, end, &w, &ts));
  ok(TSSolve(ts, w));
  a = VecRead(w);
  *rate = a[0];
  *slip = a[2];
  ObjectsDestroy(&w, &ts, &fault);
}

/* The same stress, by the displacement that makes it or given: the two differ by rounding of the balance, 1e-16 of the
   strength, in an excess of 1e-5 of it, so by 1e-11 of the slip rates that grow from it. */
static void traction_is_critical_start(void **state)
{
  const PetscReal ends[] = {1, 2, 20};

  for (int k = 0; k < 3; k++) {
    PetscReal slip[2], rate[2];

    Event("critical", ends[k], &slip[0], &rate[0]);
    Event("traction", ends[k], &slip[1], &rate[1]);
    assert_true(slip[0] > 0 && fabs(slip[1] / slip[0] - 1) < 1e-9);
    assert_true(fabs(rate[1] - rate[0]) <= 1e-9 * rate[0]);
  }
}

/* What a step's slip asks of its length: SlipFaultErrorNorm() of a step of h that slips by so much under a loading
   rate, without an error of its own */
static PetscReal ErrorOf(PetscReal loading, PetscReal h, PetscReal slip)
{
  SlipFault fault = Fault("exponential_slip_weakening", "traction", 0.5);
  PetscReal *a, E;
  Vec e, w[2];

  ok(SlipFaultSetReal(fault, "loading_rate", loading));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultCreateState(fault, &e));
  for (int k = 0; k < 2; k++) {
    ok(SlipFaultCreateState(fault, &w[k]));
    ok(VecGetArray(w[k], &a));
    a[0] = slip / h;
    a[1] = 0.5 + k * (slip - loading * h);
    a[2] = k * slip;
    ok(VecRestoreArray(w[k], &a));
  }
  ok(SlipFaultErrorNorm(fault, 1e-3, h, h, e, w[0], w[1], &E));
  ObjectsDestroy(&e, &w[0], &w[1], &fault);
  return E;
}

/* du/dt = v - v_inf: a step that slips weakens a cell by its slip, not by its displacement, which is another one under
   loading and none where the cell creeps along with it. A rest of ten years does not weaken. */
static void loading_is_no_slip(void **state)
{
  const PetscReal h = 3e8, slips[] = {0.01, 0.3, 0.6};
  PetscReal smaller = 0;

  for (int k = 0; k < 3; k++) {
    const PetscReal unloaded = ErrorOf(0, h, slips[k]);

    assert_true(unloaded > smaller);
    /* displacements of 0.5 m are rounded by 1e-16 m */
    assert_true(fabs(ErrorOf(v_inf, h, slips[k]) / unloaded - 1) < 1e-12);
    assert_true(fabs(ErrorOf(-v_inf, h, slips[k]) / unloaded - 1) < 1e-12);
    smaller = unloaded;
  }
  assert_true(fabs(ErrorOf(v_inf, h, 0)) < 1e-12 && fabs(ErrorOf(-v_inf, h, 0)) < 1e-12);
}

/* ---- rate-and-state friction ---- */

/* Cells of which the first creeps, implicit by both rules: its rate is the loading rate and its displacement 0, to the
   bit, and its state, which is not steady, that of the start, while the other one moves. */
static void creeping_cells(void **state)
{
  for (int k = 0; k < 2; k++) {
    SlipFault fault = Fault("rate_and_state", "rate", 1);
    const PetscReal creep[] = {1, 0};
    PetscReal start;
    TS ts;
    Vec w;

    ok(FaultSetReals(fault, {"nx", 2}, {"length_x", 2 * side}, {"loading_rate", v_inf}, {"initial_rate", 1e-10},
                     {"initial_state", 1e7}));
    ok(SlipFaultSetField(fault, "creep", 2, creep));
    ok(PetscOptionsSetValue(NULL, "-ts_type", TSBATHE));
    ok(FaultStart(fault, TSADAPTNONE, 1e5, 1e6, &w, &ts));
    ok(TSSetFromOptions(ts));
    ok(PetscOptionsClearValue(NULL, "-ts_type"));
    ok(TSBatheSetFirstStage(ts, k ? TSBATHE_STAGE_BACKWARD : TSBATHE_STAGE_TRAPEZOIDAL));
    start = VecRead(w)[2];
    assert_true(VecRead(w)[0] == v_inf);
    ok(TSSolve(ts, w));
    assert_true(VecRead(w)[0] == v_inf && VecRead(w)[1] == 0);
    AssertNear(VecRead(w)[2], start, 1e-13 * start); /* rounding of the weights of stages */
    assert_true(VecRead(w)[3] != v_inf && VecRead(w)[4] != 0);
    ObjectsDestroy(&ts, &w, &fault);
  }
}

/* The traction that balances a start backward is that of one forward with the other sign. */
static void starts_backward(void **state)
{
  PetscReal traction[2];

  for (int k = 0; k < 2; k++) {
    SlipFault fault = Fault("rate_and_state", "rate", 1);
    const PetscReal rate = k ? -1e-10 : 1e-10;

    ok(FaultSetReals(fault, {"loading_rate", 10 * rate}, {"initial_rate", rate}));
    ok(SlipFaultSetUp(fault));
    ok(SlipFaultGetField(fault, "initial_traction", 1, &traction[k]));
    ok(SlipFaultDestroy(&fault));
  }
  assert_true(traction[0] > 0.5 * residual * sigma && traction[1] == -traction[0]);
}

/* Friction and radiation balance the traction under the pressure of each time, to the rounding of stresses. */
static void balance_under_pressure(void **state)
{
  const PetscInt rows = 2, dims[] = {2, 1, 1};
  const PetscReal times[] = {0, 10}, pressure[] = {0, 0.2 * sigma};
  SlipFault fault = Fault("rate_and_state", "rate", 1);
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  PetscReal G, rho, traction;
  Vec w;

  assert_int_equal(0, TempDirFile("creep", "record.h5", dir, file));
  ok(WriteRecord(file, rows, times, 3, dims, pressure));
  ok(SlipFaultSetString(fault, "pore_pressure", file));
  ok(FaultSetReals(fault, {"loading_rate", v_inf}, {"initial_rate", v_inf}));
  ok(FaultSetUpState(fault, &w));
  ok(SlipFaultGetReal(fault, "shear_modulus", &G));
  ok(SlipFaultGetReal(fault, "density", &rho));
  ok(SlipFaultGetField(fault, "initial_traction", 1, &traction));
  for (PetscReal t = 0; t <= 10; t += 5) {
    SlipFrictionCells f;
    PetscReal mu, ds, dv, v;

    ok(SlipFaultRates(fault, t, w, NULL));
    v = VecRead(fault->balance.rate)[0];
    ok(SlipFaultGetFriction(fault, t, &f));
    AssertNear(f.stress[0], sigma * (1 - 0.02 * t), 1e-14 * sigma);
    SlipFrictionEvaluate(&f, 0, VecRead(w) + 2, v, &mu, &ds, &dv);
    AssertNear(f.stress[0] * mu + sqrt(G * rho) / 2 * (v - v_inf), traction, 1e-13 * traction);
  }
  ObjectsDestroy(&w, &fault);
  assert_int_equal(0, TempDirRemove(dir));
}

SLIP_TESTS(creep_does_not_toggle, traction_is_critical_start, loading_is_no_slip, creeping_cells, starts_backward,
           balance_under_pressure)
