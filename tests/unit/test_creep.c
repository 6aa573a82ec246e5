/* One cell under loading: creep by long steps with both rules of the first stage, the start under a traction against
   the critical one, and what of a displacement is slip. */
#include "unit.h"
#include "faultstart.h"
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

SLIP_TESTS(creep_does_not_toggle, traction_is_critical_start, loading_is_no_slip)
