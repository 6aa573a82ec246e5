/* Stresses in time: records, tides and a nucleation against closed forms, their sums and corners, the steps that they
   allow, and what is no stress. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>

enum { NX = 3, NZ = 2, N = NX * NZ };
static const PetscReal T0 = 1e7, sigma = 5e7;

static SlipFault Fault(PetscInt components)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"initial", "traction"}, {"viscosity", "radiation"}, {"friction_law", "constant"}));
  ok(SlipFaultSetInertia(fault, PETSC_FALSE));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"normal_stress", sigma}, {"normal_stress_gradient", 0},
                   {"initial_traction", T0}, {"slip_components", (PetscReal)components}));
  return fault;
}

/* Component k of the shear load of cell e, and its normal stress, at t */
static PetscReal Shear(SlipFault fault, PetscReal t, PetscInt e, PetscInt k)
{
  const SlipFaultLoad *load;
  const PetscReal *a;
  PetscReal value;

  ok(SlipFaultGetLoad(fault, t, &load));
  ok(VecGetArrayRead(load->shear, &a));
  value = a[fault->layout.components * e + k];
  ok(VecRestoreArrayRead(load->shear, &a));
  return value;
}

static PetscReal Normal(SlipFault fault, PetscReal t, PetscInt e)
{
  const SlipFaultLoad *load;

  ok(SlipFaultGetLoad(fault, t, &load));
  return load->stress[e];
}

/* Two records with corners of their own: one of a number, one of fields; sums to rounding of 5e7 Pa */
static void records(void **state)
{
  const PetscReal time[] = {10, 30, 100}, course[] = {1, 3, -1}, other[] = {20, 30}, ramp[] = {0, 1}, one = 2e6;
  PetscReal shear[N], normal[N];
  SlipFault fault = Fault(1);

  for (PetscInt e = 0; e < N; e++) {
    shear[e] = 1e5 * (PetscReal)(e + 1);
    normal[e] = -2e5 * (PetscReal)(e + 1);
  }
  ok(SlipFaultAddStress(fault, 3, time, course, 1, &one, 0, NULL));
  ok(SlipFaultAddStress(fault, 2, other, ramp, N, shear, N, normal));
  ok(SlipFaultSetUp(fault));
  for (PetscInt e = 0; e < N; e++) {
    assert_true(fabs(Shear(fault, -5, e, 0) - (T0 + one)) < 1e-7 && Normal(fault, -5, e) == sigma);
    assert_true(fabs(Shear(fault, 15, e, 0) - (T0 + 1.5 * one)) < 1e-7);
    assert_true(fabs(Shear(fault, 25, e, 0) - (T0 + 2.5 * one + 0.5 * shear[e])) < 1e-7);
    assert_true(fabs(Normal(fault, 25, e) - (sigma + 0.5 * normal[e])) < 1e-7);
    assert_true(fabs(Shear(fault, 65, e, 0) - (T0 + one + shear[e])) < 1e-7);
    assert_true(fabs(Shear(fault, 1e9, e, 0) - (T0 - one + shear[e])) < 1e-7);
    assert_true(fabs(Normal(fault, 1e9, e) - (sigma + normal[e])) < 1e-7);
  }
  /* those of both, once */
  assert_true(SlipLoadsNextCorner(&fault->loads, 0) == 10 && SlipLoadsNextCorner(&fault->loads, 10) == 20 &&
              SlipLoadsNextCorner(&fault->loads, 20) == 30 && SlipLoadsNextCorner(&fault->loads, 30) == 100 &&
              SlipLoadsNextCorner(&fault->loads, 100) > 1e300);
  fails(SlipFaultAddStress(fault, 2, other, ramp, 1, &one, 0, NULL), "before SlipFaultSetUp()");
  ok(SlipFaultDestroy(&fault));
}

/* Vectors along strike and up dip: both components count where slip has two, and what is along the rake where it has
   one */
static void vectors(void **state)
{
  const PetscReal time[] = {0, 10}, course[] = {0, 1}, angle = 30 * PETSC_PI / 180;
  PetscReal shear[2 * N];

  for (PetscInt i = 0; i < 2 * N; i++) shear[i] = 1e5 * (PetscReal)(i + 1);
  for (PetscInt c = 1; c <= 2; c++) {
    SlipFault fault = Fault(c);

    ok(SlipFaultSetReal(fault, "rake", 30));
    ok(SlipFaultAddStress(fault, 2, time, course, 2 * N, shear, 0, NULL));
    ok(SlipFaultSetUp(fault));
    for (PetscInt e = 0; e < N; e++) {
      const PetscReal x = 0.5 * shear[2 * e], y = 0.5 * shear[2 * e + 1];

      if (c == 1)
        assert_true(fabs(Shear(fault, 5, e, 0) - (T0 + x * cos(angle) + y * sin(angle))) < 1e-7);
      else
        assert_true(fabs(Shear(fault, 5, e, 0) - (T0 * cos(angle) + x)) < 1e-7 &&
                    fabs(Shear(fault, 5, e, 1) - (T0 * sin(angle) + y)) < 1e-7);
    }
    ok(SlipFaultDestroy(&fault));
  }
}

/* Sines, also after a million periods, where rounding of the phase leaves 1e6 eps of the amplitude */
static void tides(void **state)
{
  const PetscReal period[] = {100, 7}, shear[] = {1e5, 2e5}, normal = 3e5, phase = 30.0 / 360;
  SlipFault fault = Fault(1);

  ok(FaultSetStrings(fault, {"tide_period", "100,7"}, {"tide_shear", "1e5,2e5"}, {"tide_normal", "0,3e5"},
                     {"tide_phase", "0,30"}));
  ok(SlipFaultSetUp(fault));
  for (PetscReal t = 0; t < 1e8; t = 3 * t + 1) {
    PetscReal sine[2];

    for (int k = 0; k < 2; k++) sine[k] = sin(2 * PETSC_PI * (fmod(t, period[k]) / period[k] + (k ? phase : 0)));
    assert_true(fabs(Shear(fault, t, 4, 0) - (T0 + shear[0] * sine[0] + shear[1] * sine[1])) < 1e-3);
    assert_true(fabs(Normal(fault, t, 4) - (sigma + normal * sine[1])) < 1e-3);
  }
  assert_true(SlipLoadsNextCorner(&fault->loads, 0) > 1e300 && SlipLoadsScale(&fault->loads, 0) == 7);
  ok(SlipFaultDestroy(&fault));
}

/* The patch of SCEC's benchmarks: at its middle, within it and beyond it; its ends are corners */
static void nucleation(void **state)
{
  const PetscReal R = 1400, A = 25e6, T = 8;
  SlipFault fault = Fault(1);

  ok(SlipFaultSetString(fault, "nucleation", "500,750,1400,25e6,8")); /* the centre of a cell of 1000 x 1500 m */
  ok(SlipFaultSetUp(fault));
  for (PetscReal t = -1; t < 12; t += 0.5) {
    const PetscReal G = t <= 0 ? 0 : t >= T ? 1 : exp((t - T) * (t - T) / (t * (t - 2 * T)));

    assert_true(fabs(Shear(fault, t, 0, 0) - (T0 + A * G)) < 1e-7);
    assert_true(fabs(Shear(fault, t, 1, 0) - (T0 + A * G * exp(1e6 / (1e6 - R * R)))) < 1e-7);
    assert_true(Shear(fault, t, 2, 0) == T0 && Shear(fault, t, NX, 0) == T0);
  }
  assert_true(SlipLoadsNextCorner(&fault->loads, -1) == 0 && SlipLoadsNextCorner(&fault->loads, 0) == T &&
              SlipLoadsNextCorner(&fault->loads, T) > 1e300);
  assert_true(SlipLoadsScale(&fault->loads, 1) == T && SlipLoadsScale(&fault->loads, T) > 1e300);
  assert_true(!fault->kind.sequence); /* it starts one rupture; a tide that follows it may start more */
  ok(SlipFaultDestroy(&fault));
  fault = Fault(1);
  ok(FaultSetStrings(fault, {"nucleation", "500,750,1400,25e6,8"}, {"tide_period", "9"}, {"tide_shear", "1e5"}));
  ok(SlipFaultSetUp(fault));
  assert_true(fault->kind.sequence);
  ok(SlipFaultDestroy(&fault));
}

/* Largest step of a run under a tide, until end, and its number of steps */
static PetscReal largest_step;
static PetscErrorCode Largest(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  PetscReal *last = (PetscReal *)ctx;

  if (step) largest_step = PetscMax(largest_step, t - *last);
  *last = t;
  return PETSC_SUCCESS;
}

/* Steps are at most an eighth of a period whose stress matters: more than 1e-3 of G/L d_c, which is some 100 Pa. Steady
   slip takes longer ones without a tide, and with one that does not matter. */
static void steps(void **state)
{
  static const char *const types[] = {TSADAMS, TSBATHE, TSRK};
  static const char *const amplitude[] = {"1e4", "10", ""};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(types); k++)
    for (int a = 0; a < 3; a++) {
      PetscReal last = 0;
      SlipFault fault;
      Vec w;
      TS ts;

      ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
      ok(SlipFaultSetString(fault, "friction_law", "rate_and_state"));
      ok(FaultSetReals(fault, {"normal_stress", sigma}, {"normal_stress_gradient", 0}, {"friction_a", 0.01},
                       {"friction_b", 0.005}, {"friction_slip", 0.01}, {"loading_rate", 1e-9}));
      if (amplitude[a][0]) ok(FaultSetStrings(fault, {"tide_period", "1000"}, {"tide_shear", amplitude[a]}));
      ok(PetscOptionsSetValue(NULL, "-ts_type", types[k]));
      ok(FaultStart(fault, NULL, 10, 2e5, &w, &ts));
      ok(TSSetFromOptions(ts));
      ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, 1e-3, NULL));
      largest_step = 0;
      ok(TSMonitorSet(ts, Largest, &last, NULL));
      ok(TSSolve(ts, w));
      /* a time of 2e5 s has 17 digits */
      assert_true(a ? largest_step > 2000 : largest_step <= 125 * (1 + 1e-9));
      ObjectsDestroy(&w, &ts, &fault);
      ok(PetscOptionsClear(NULL));
    }
}

static void RefusedRecord(const PetscReal time[2], const PetscReal course[2], PetscInt nshear, const PetscReal shear[],
                          PetscInt nnormal, const PetscReal normal[], const char words[])
{
  SlipFault fault = Fault(1);

  ok(SlipFaultAddStress(fault, 2, time, course, nshear, shear, nnormal, normal));
  fails(SlipFaultSetUp(fault), words);
  ok(SlipFaultDestroy(&fault));
}

static void refused(void **state)
{
  const PetscReal up[2] = {0, 1}, same[2] = {1, 1}, bad[2] = {0, (PetscReal)NAN}, one = 1e6;
  const PetscReal few[N] = {0};

  RefusedRecord(same, up, 1, &one, 0, NULL, "time[1] is 1 s, expected finite times, each later");
  RefusedRecord(bad, up, 1, &one, 0, NULL, "time[1] is nan s");
  RefusedRecord(up, bad, 1, &one, 0, NULL, "course[1] is nan");
  RefusedRecord(up, up, 1, &bad[1], 0, NULL, "shear[0] is nan");
  RefusedRecord(up, up, N - 1, few, 0, NULL, "shear has 5 numbers, expected 1, 6 for the cells, or 12");
  RefusedRecord(up, up, 0, NULL, N - 1, few, "normal has 5 numbers, expected 1, or 6");
  RefusedRecord(up, up, 0, NULL, 0, NULL, "neither shear nor normal");
}

SLIP_TESTS(records, vectors, tides, nucleation, steps, refused)
