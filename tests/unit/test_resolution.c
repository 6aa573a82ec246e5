/* Defaults that decide results: the lengths of a rupture against the cells, where rate-and-state friction starts, and
   when a fault has inertia. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <string.h>

enum { NX = 4, NZ = 2, N = NX * NZ };
static const PetscReal G = 30e9, sigma = 50e6, length = 1000, width = 500;

/* Cells of 1000 m x 500 m under the same normal stress in a full space, where all have the same stiffness */
static SlipFault Fault(const char law[], PetscReal nx, PetscReal nz)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"kernel", "full_space"}, {"friction_law", law}));
  ok(FaultSetReals(fault, {"nx", nx}, {"nz", nz}, {"length_x", nx * length}, {"length_z", nz * width},
                   {"normal_stress", sigma}, {"normal_stress_gradient", 0}));
  return fault;
}

static PetscReal OwnStiffness(SlipFault fault)
{
  PetscReal *a, k;
  Vec d;
  Mat K;

  ok(SlipFaultGetOperators(fault, &K, NULL, NULL));
  ok(MatCreateVecs(K, &d, NULL));
  ok(MatGetDiagonal(K, d));
  ok(VecGetArray(d, &a));
  k = a[0];
  ok(VecRestoreArray(d, &a));
  ok(VecDestroy(&d));
  return k;
}

static void Same(PetscReal x, PetscReal expected)
{
  assert_true(fabs(x / expected - 1) < 1e-12); /* rounding of a formula */
}

/* Three of eight cells weaken at 1.01 times their own stiffness, four at 0.99, and one does not. */
static void slip_weakening(void **state)
{
  static const char *const laws[] = {"linear_slip_weakening", "exponential_slip_weakening"};

  for (int l = 0; l < 2; l++) {
    SlipFault fault = Fault(laws[l], NX, NZ);
    PetscReal slip[N], drop[N], k;

    ok(SlipFaultSetUp(fault));
    k = OwnStiffness(fault);
    ok(SlipFaultDestroy(&fault));
    for (PetscInt i = 0; i < N; i++) {
      drop[i] = i == 7 ? 0 : 0.05 * (1 + (double)(i % 2));
      slip[i] = sigma * 0.05 * (1 + (double)(i % 2)) / (k * (i < 3 ? 1.01 : 0.99));
    }
    fault = Fault(laws[l], NX, NZ);
    ok(SlipFaultSetField(fault, "friction_drop", N, drop));
    ok(SlipFaultSetField(fault, "friction_slip", N, slip));
    ok(SlipFaultSetUp(fault));
    assert_true(fault->resolution.known && fault->resolution.zone);
    Same(fault->resolution.length, 9 * PETSC_PI / 32 * G / (1.01 * k));
    Same(fault->resolution.nucleation, 1.158 * G / (1.01 * k));
    Same(fault->resolution.cell, length);
    Same(fault->resolution.least, 9 * PETSC_PI / 32 * G / (1.01 * k) / length);
    Same(fault->resolution.alone, 3.0 / 7);
    ok(SlipFaultDestroy(&fault));
  }
}

/* L_b of the cells with a < b alone, that creep by themselves left out; cells of an antiplane fault count by their
   width. */
static void rate_and_state(void **state)
{
  const PetscReal b = 0.02, slip = 0.05, a[N] = {0.01, 0.012, 0.03, 0.03, 0.01, 0.01, 0.021, 0.01};
  PetscReal creep[N] = {0, 0, 0, 0, 1, 1, 1, 1}, dc[N];

  for (int antiplane = 0; antiplane < 2; antiplane++) {
    SlipFault fault = antiplane ? Fault("rate_and_state", 1, N) : Fault("rate_and_state", NX, NZ);
    PetscReal k;

    for (PetscInt i = 0; i < N; i++) dc[i] = i > 1 ? 1e-3 : slip; /* where nothing weakens it does not matter */
    ok(FaultSetReals(fault, {"friction_b", b}, {"loading_rate", 1e-9}));
    ok(SlipFaultSetField(fault, "friction_a", N, a));
    ok(SlipFaultSetField(fault, "friction_slip", N, dc));
    ok(SlipFaultSetField(fault, "creep", N, creep));
    ok(SlipFaultSetUp(fault));
    k = OwnStiffness(fault);
    Same(fault->resolution.length, G * slip / (b * sigma));
    Same(fault->resolution.nucleation, 2 / PETSC_PI * G * slip / ((b - 0.01) * sigma));
    Same(fault->resolution.cell, antiplane ? width : length);
    assert_true(k > (b - 0.01) * sigma / slip && fault->resolution.alone == 0);
    ok(SlipFaultDestroy(&fault));
  }
}

/* Undrained slip without diffusion across a Gaussian of 1 mm: strength falls by 1 - exp(-slip f Lambda w(0)/(rho c)) */
static void pressure(void **state)
{
  const PetscReal f = 0.6, w = 1e-3, lambda = 1e5, small = 1e-6, b = 0.02, dc = 0.05;
  const PetscReal fall = -expm1(-small * f * lambda / (sqrt(2 * PETSC_PI) * w * 2.7e6)) / small; /* of sigma [1/m] */

  for (int weakens = 0; weakens < 2; weakens++) {
    SlipFault fault = Fault(weakens ? "linear_slip_weakening" : "rate_and_state", NX, NZ);

    ok(FaultSetReals(fault, {"shear_zone_width", w}, {"thermal_pressurisation", lambda}, {"friction_slip", dc}));
    if (weakens)
      ok(FaultSetReals(fault, {"friction_residual", 0.5}, {"friction_drop", 0.1}));
    else
      ok(FaultSetReals(fault, {"friction_b", b}, {"loading_rate", 1e-9}));
    ok(SlipFaultSetUp(fault));
    assert_true(fabs(fault->resolution.length / (weakens ? 9 * PETSC_PI / 32 * G / ((0.1 / dc + f * fall) * sigma)
                                                         : G / ((b / dc + f * fall) * sigma)) -
                     1) < 1e-4);
    ok(SlipFaultDestroy(&fault));
  }
}

/* TPV103's friction: from the reference rate to ten times V_w it rises by a ln(1e6) to its peak and has then 0.2, and
   1e-1 of what f_LV is above it, to 1e-9 */
static void strong_weakening(void **state)
{
  const PetscReal a = 0.01, b = 0.014, dc = 0.4, peak = 0.6 + a * log(1e6), slow = 0.6 - (b - a) * log(1e6);
  SlipFault fault = Fault("strong_rate_weakening", NX, NZ);

  ok(FaultSetReals(fault, {"friction_a", a}, {"friction_b", b}, {"friction_slip", dc}, {"friction_weakened", 0.2},
                   {"friction_weakening_rate", 0.1}, {"initial_rate", 1e-9}));
  ok(SlipFaultSetUp(fault));
  assert_true(fabs(fault->resolution.length /
                     (9 * PETSC_PI / 32 * G * dc / ((peak - 0.2 - (slow - 0.2) / pow(1 + 1e8, 0.125)) * sigma)) -
                   1) < 1e-10);
  Same(fault->resolution.nucleation, 2 / PETSC_PI * G * dc / ((b - a) * sigma));
  ok(SlipFaultDestroy(&fault));
}

/* Motion runs away below (loss - H)^2/(4 M); without inertia there is no length, nor with one cell, nor of constant
   friction. */
static void others(void **state)
{
  const PetscReal drop = 0.1, rate = 0.1, eta = 0.5 * sqrt(30e9 * 2500), loss = drop * sigma / rate - eta;
  SlipFault fault = Fault("rate_weakening", NX, NZ);
  PetscReal mass;

  ok(SlipFaultSetString(fault, "viscosity", "radiation"));
  ok(SlipFaultSetReal(fault, "friction_rate", rate));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetOperators(fault, NULL, NULL, &mass));
  assert_true(fault->resolution.known && !fault->resolution.zone);
  Same(fault->resolution.length, 2 / PETSC_PI * G * 4 * mass / (loss * loss));
  ok(SlipFaultDestroy(&fault));
  for (int k = 0; k < 2; k++) {
    fault = k ? Fault("linear_slip_weakening", 1, 1) : Fault("constant", NX, NZ);
    ok(SlipFaultSetUp(fault));
    assert_false(fault->resolution.known);
    ok(SlipFaultDestroy(&fault));
  }
}

/* Where no rate is given cells that weaken begin at a thousandth of the loading rate, with the state that is steady at
   that; a given rate, and the start under a given traction, mean what they say. */
static void start_of_rate_and_state(void **state)
{
  const PetscReal vinf = 2e-9, b = 0.015, slip = 0.1;
  PetscReal a[N];

  for (PetscInt i = 0; i < N; i++) a[i] = i % 2 ? 0.01 : 0.02;
  for (int k = 0; k < 4; k++) {
    SlipFault fault = Fault("rate_and_state", NX, NZ);
    const PetscReal sign = k == 3 ? -1 : 1;

    ok(FaultSetReals(fault, {"loading_rate", sign * vinf}, {"friction_b", b}, {"friction_slip", slip}));
    ok(SlipFaultSetField(fault, "friction_a", N, a));
    if (k == 1) ok(SlipFaultSetReal(fault, "initial_rate", vinf));
    if (k == 2) {
      ok(SlipFaultSetString(fault, "initial", "traction"));
      ok(SlipFaultSetReal(fault, "initial_traction", 0.6 * sigma));
    }
    ok(SlipFaultSetUp(fault));
    for (PetscInt i = 0; i < N; i++) {
      const PetscBool locked = (k == 0 || k == 3) && i % 2 ? PETSC_TRUE : PETSC_FALSE;

      Same(fault->fields.cell[FIELD_INITIAL_RATE][i], sign * vinf * (locked ? 1e-3 : 1));
      if (k != 2) Same(fault->fields.cell[FIELD_INITIAL_STATE][i], slip / vinf);
    }
    ok(SlipFaultDestroy(&fault));
  }
}

/* Quasi-dynamic with radiation damping: rate and state, and slip weakening from a traction, unless they are told
   otherwise */
static void inertia_and_viscosity(void **state)
{
  static const struct {
    const char *law, *initial, *viscosity;
    int given; /* -1: not */
    PetscBool inertia;
    const char *becomes;
  } rows[] = {
    {"linear_slip_weakening", "traction", "auto", -1, PETSC_FALSE, "radiation"},
    {"linear_slip_weakening", "traction", "auto", 1, PETSC_TRUE, "sqrtm"},
    {"linear_slip_weakening", "traction", "sqrtm", -1, PETSC_FALSE, "sqrtm"},
    {"linear_slip_weakening", "traction", "none", -1, PETSC_TRUE, "none"},
    {"linear_slip_weakening", "critical", "auto", -1, PETSC_TRUE, "sqrtm"},
    {"linear_slip_weakening", "rest", "auto", -1, PETSC_TRUE, "sqrtm"},
    {"rate_weakening", "traction", "auto", -1, PETSC_TRUE, "sqrtm"}, /* no balance without inertia */
    {"rate_and_state", "auto", "auto", -1, PETSC_FALSE, "radiation"},
    {"rate_and_state", "auto", "auto", 1, PETSC_TRUE, "radiation"},
    {"rate_and_state", "traction", "sqrtm", 1, PETSC_TRUE, "sqrtm"},
  };

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    SlipFault fault = Fault(rows[k].law, NX, NZ);
    char text[32];

    ok(FaultSetStrings(fault, {"initial", rows[k].initial}, {"viscosity", rows[k].viscosity}));
    ok(FaultSetReals(fault, {"loading_rate", 1e-9}, {"initial_traction", 0.5 * sigma}));
    if (rows[k].given >= 0) ok(SlipFaultSetInertia(fault, rows[k].given ? PETSC_TRUE : PETSC_FALSE));
    ok(SlipFaultSetUp(fault));
    assert_int_equal(fault->kind.inertia, rows[k].inertia);
    assert_string_equal(fault->kind.viscosity, rows[k].becomes);
    ok(SlipFaultGetString(fault, "viscosity", text, sizeof(text)));
    assert_string_equal(text, rows[k].becomes);
    assert_string_equal(fault->options.text[FAULT_VISCOSITY], rows[k].viscosity); /* what the user chose */
    ok(SlipFaultDestroy(&fault));
  }
}

SLIP_TESTS(slip_weakening, rate_and_state, pressure, strong_weakening, others, start_of_rate_and_state,
           inertia_and_viscosity)
