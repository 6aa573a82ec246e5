/* Slip of two components: beside that of one where they must be the same, in axes that are turned, and the balance of
   each cell. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipsys.h>
#include <petscksp.h>
#include <math.h>

#define SIDE 1000.0 /* of a cell [m] */
#define LOAD 1e-9   /* [m/s] */
#define YEAR 3.15576e7

/* Rate-and-state cells in a full space, whose a differs from cell to cell as that of their places in a square does:
   rows go down, and so a turned over its diagonal is that of the square with strike and dip exchanged */
static SlipFault Cells(PetscInt nx, PetscInt nz, PetscBool turned, PetscReal rake, PetscInt components)
{
  PetscReal a[64];
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"kernel", "full_space"}, {"friction_law", "rate_and_state"}));
  ok(FaultSetReals(fault, {"nx", nx}, {"nz", nz}, {"length_x", nx * SIDE}, {"length_z", nz * SIDE}, {"rake", rake},
                   {"slip_components", components}, {"normal_stress", 5e7}, {"normal_stress_gradient", 0},
                   {"loading_rate", LOAD}, {"friction_slip", 0.05}, {"friction_b", 0.02}));
  for (PetscInt iz = 0; iz < nz; iz++)
    for (PetscInt ix = 0; ix < nx; ix++) {
      const PetscInt along = turned ? nz - 1 - iz : ix, up = turned ? ix : nz - 1 - iz;

      a[iz * nx + ix] = 0.01 + 0.002 * PetscSinReal(1 + 1.3 * (PetscReal)along + 2.1 * (PetscReal)up);
    }
  ok(SlipFaultSetField(fault, "friction_a", nx * nz, a));
  return fault;
}

/* Displacements [nx nz][components] after some years of the explicit problem. One correction: more of them go by the
   fastest rate of relaxation, whose power iteration begins with numbers of cells, not with places. */
static void Run(SlipFault fault, PetscReal years, PetscReal u[])
{
  PetscInt N;
  TS ts;
  Vec w;

  ok(FaultStart(fault, TSADAPTBASIC, 0, years * YEAR, &w, &ts));
  ok(PetscOptionsSetValue(NULL, "-ts_adams_max_corrections", "1"));
  ok(TSSetFromOptions(ts));
  ok(PetscOptionsClearValue(NULL, "-ts_adams_max_corrections"));
  ok(TSSetTolerances(ts, PETSC_DEFAULT, NULL, 1e-4, NULL));
  ok(TSSolve(ts, w));
  N = fault->mesh.N;
  ok(SlipFaultGetCellValues(fault, years * YEAR, w, "displacement", N, u));
  ObjectsDestroy(&w, &ts);
}

/* Of a line of n cells: two components with the rake 0 are the one and nothing, to 1e-9 of the largest, which is at
   least this [m] */
static void SameAsOne(PetscInt n, const PetscReal one[], const PetscReal two[], PetscReal least)
{
  PetscReal most = 0;

  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, PetscAbsReal(one[i]));
  assert_true(most > least);
  for (PetscInt i = 0; i < n; i++) {
    AssertNear(two[2 * i], one[i], 1e-9 * most);
    AssertNear(two[2 * i + 1], 0, 1e-9 * most);
  }
}

/* Of 4 x 3 cells with the rake 25, and of 3 x 4 with strike and dip exchanged: the same, to a share of the largest; and
   not all along the rake, by at least a share of that */
static void SameExchanged(const PetscReal u[], const PetscReal other[], PetscReal share, PetscReal least)
{
  const PetscReal c = cos(25 * PETSC_PI / 180), s = sin(25 * PETSC_PI / 180);
  PetscReal most = 0, across = 0;

  for (PetscInt i = 0; i < 12; i++) {
    most = PetscMax(most, hypot(u[2 * i], u[2 * i + 1]));
    across = PetscMax(across, PetscAbsReal(u[2 * i + 1] * c - u[2 * i] * s));
  }
  assert_true(most > 0.1 && across > least * most);
  for (PetscInt iz = 0; iz < 3; iz++)
    for (PetscInt ix = 0; ix < 4; ix++) {
      const PetscInt i = iz * 4 + ix, j = (3 - ix) * 3 + (2 - iz);

      AssertNear(u[2 * i], other[2 * j + 1], share * most);
      AssertNear(u[2 * i + 1], other[2 * j], share * most);
    }
}

/* A line of cells in a full space: slip along it makes no shear stress across it, so that two components with the rake
   0 do as one. 400 years are two events, in which a difference of 1e-16 grows by some decades */
static void a_line_slips_as_with_one_component(void **state)
{
  PetscReal one[8], two[16];
  SlipFault fault;

  fault = Cells(8, 1, PETSC_FALSE, 0, 1);
  Run(fault, 1500, one);
  ok(SlipFaultDestroy(&fault));
  fault = Cells(8, 1, PETSC_FALSE, 0, 2);
  Run(fault, 1500, two);
  ok(SlipFaultDestroy(&fault));
  SameAsOne(8, one, two, 0.1);
}

/* Strike and dip exchanged, with the rake 90 degrees less that of before: the same slip, by isotropy. Nothing but
   kernels and friction that do not prefer an axis can do that. */
static void axes_do_not_matter(void **state)
{
  PetscReal u[24], other[24];
  SlipFault fault;

  fault = Cells(4, 3, PETSC_FALSE, 25, 2);
  Run(fault, 300, u);
  ok(SlipFaultDestroy(&fault));
  fault = Cells(3, 4, PETSC_TRUE, 65, 2);
  Run(fault, 300, other);
  ok(SlipFaultDestroy(&fault));
  SameExchanged(u, other, 1e-9, 1e-4);
}

/* A state with rates that the balance has made: the traction of each cell is against its slip rate, and what loading
   gives goes where the powers say, with K u of the matrix itself */
static void friction_opposes_the_slip_rate_and_powers_add_up(void **state)
{
  const PetscInt N = 12;
  PetscReal v[24], tau[24], rate[24], stress[24], sum = 0, friction = 0, eta;
  SlipFault fault = Cells(4, 3, PETSC_FALSE, 25, 2);
  SlipFaultObservables o;
  SlipFrictionCells cells;
  const PetscReal *f;
  PetscReal *a;
  Vec w, u, force;

  ok(FaultSetUpState(fault, &w));
  ok(VecGetArray(w, &a));
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt k = 0; k < 2; k++) a[5 * i + 2 + k] = -0.02 * PetscSinReal(1 + 3.3 * (PetscReal)(2 * i + k));
  ok(VecRestoreArray(w, &a));
  ok(SlipFaultRates(fault, 0, w, NULL));
  ok(SlipFaultPutRates(fault, w));
  ok(SlipFaultGetCellValues(fault, 0, w, "slip_rate", N, v));
  ok(SlipFaultGetCellValues(fault, 0, w, "traction", N, tau));
  ok(SlipFaultGetCellValues(fault, 0, w, "stress", N, stress));
  ok(SlipFaultGetFrictionOf(fault, 0, w, &cells));
  eta = fault->balance.eta;
  ok(VecGetArray(w, &a));
  for (PetscInt i = 0; i < N; i++) {
    const PetscReal speed = hypot(v[2 * i], v[2 * i + 1]), size = hypot(tau[2 * i], tau[2 * i + 1]);
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&cells, i, &a[5 * i + 4], speed, &mu, &ds, &dv);
    AssertNear(size, mu * 5e7, 1e-12 * size);
    AssertNear(tau[2 * i] * v[2 * i + 1] - tau[2 * i + 1] * v[2 * i], 0, 1e-12 * size * speed);
    assert_true(tau[2 * i] * v[2 * i] + tau[2 * i + 1] * v[2 * i + 1] < 0);
    for (PetscInt k = 2 * i; k < 2 * i + 2; k++) {
      const PetscReal along = k % 2 ? sin(25 * PETSC_PI / 180) : cos(25 * PETSC_PI / 180);

      rate[k] = v[k] - LOAD * along;
      /* stress + friction - eta (v - v_inf) = 0, to what Newton's method leaves of ln v */
      AssertNear(stress[k] + tau[k] - eta * rate[k], 0, 1e-10 * size);
    }
  }
  ok(VecRestoreArray(w, &a));
  ok(SlipFaultGetWork(fault, &u));
  ok(SlipFaultGetWork(fault, &force));
  ok(SlipFaultGetDisplacement(fault, w, u));
  ok(MatMult(fault->medium->K, u, force));
  f = VecRead(force);
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt k = 0; k < 2; k++) {
      const PetscReal load = fault->fields.cell[FIELD_INITIAL_TRACTION][i] * SlipFaultAlong(fault, i)[k];

      sum += (f[2 * i + k] - load) * rate[2 * i + k];
      friction -= tau[2 * i + k] * v[2 * i + k];
    }
  ok(SlipFaultRestoreWork(fault, &force));
  ok(SlipFaultRestoreWork(fault, &u));
  ok(SlipFaultGetObservables(fault, 0, w, NULL, &o));
  AssertNear(o.friction_power, friction / N, 1e-12 * friction / N);
  AssertNear(sum / N + o.viscous_power + o.friction_power, o.loading_power, 1e-9 * o.friction_power);
  ObjectsDestroy(&w, &fault);
}

/* Slip weakening from a given stress, with inertia and the exact root of the mass and K for viscosity: implicit steps,
   the cone in SNES */
static SlipFault Weakening(PetscInt nx, PetscInt nz, PetscBool turned, PetscReal rake, PetscInt components)
{
  PetscReal load[64];
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"kernel", "full_space"}, {"initial", "traction"}, {"viscosity", "sqrtm"}));
  ok(FaultSetReals(fault, {"nx", nx}, {"nz", nz}, {"length_x", nx * SIDE}, {"length_z", nz * SIDE}, {"rake", rake},
                   {"slip_components", components}, {"normal_stress", 5e7}, {"normal_stress_gradient", 0},
                   {"friction_slip", 0.1}, {"friction_residual", 0.5}, {"friction_drop", 0.1}, {"thickness", 3000}));
  ok(SlipFaultSetBool(fault, "initial_unstable", PETSC_TRUE));
  ok(SlipFaultSetInertia(fault, PETSC_TRUE));
  for (PetscInt iz = 0; iz < nz; iz++)
    for (PetscInt ix = 0; ix < nx; ix++) {
      const PetscInt along = turned ? nz - 1 - iz : ix, up = turned ? ix : nz - 1 - iz;

      load[iz * nx + ix] = 2.7e7 + 4e6 * PetscSinReal(1 + 1.3 * (PetscReal)along + 2.1 * (PetscReal)up);
    }
  ok(SlipFaultSetField(fault, "initial_traction", nx * nz, load));
  return fault;
}

/* The end [nx nz][components] of a rupture, in steps of one size */
static void Rupture(SlipFault fault, PetscInt steps, PetscReal u[], PetscInt *sliding)
{
  const PetscReal end = 6;
  PetscReal v[128];
  PetscInt N;
  TS ts;
  Vec w;

  ok(FaultStart(fault, TSADAPTNONE, end / (PetscReal)steps, end, &w, &ts));
  ok(TSBatheSetStageError(ts, 0));
  ok(TSSolve(ts, w));
  N = fault->mesh.N;
  ok(SlipFaultGetCellValues(fault, end, w, "displacement", N, u));
  ok(SlipFaultGetCellValues(fault, end, w, "slip_rate", N, v));
  *sliding = 0;
  for (PetscInt i = 0; i < N; i++) *sliding += SlipFaultLength(fault, v + fault->layout.components * i) != 0;
  ObjectsDestroy(&w, &ts);
}

/* As of the smooth law; to the tolerance of stages, 1e-10 of the stress, which a rupture that stops forgets */
static void a_line_ruptures_as_with_one_component(void **state)
{
  PetscReal one[8], two[16];
  PetscInt sliding, of_two;
  SlipFault fault;

  fault = Weakening(8, 1, PETSC_FALSE, 0, 1);
  Rupture(fault, 300, one, &sliding);
  ok(SlipFaultDestroy(&fault));
  fault = Weakening(8, 1, PETSC_FALSE, 0, 2);
  Rupture(fault, 300, two, &of_two);
  ok(SlipFaultDestroy(&fault));
  assert_int_equal(sliding, of_two);
  SameAsOne(8, one, two, 0.1);
}

static void ruptures_prefer_no_axis(void **state)
{
  PetscReal u[24], other[24];
  PetscInt sliding;
  SlipFault fault;

  fault = Weakening(4, 3, PETSC_FALSE, 25, 2);
  Rupture(fault, 200, u, &sliding);
  ok(SlipFaultDestroy(&fault));
  fault = Weakening(3, 4, PETSC_TRUE, 65, 2);
  Rupture(fault, 200, other, &sliding);
  ok(SlipFaultDestroy(&fault));
  SameExchanged(u, other, 1e-8, 1e-3);
}

/* Rest ends where the first stress, a vector that turns as loading goes on, is as long as the strength: with slips in
   all directions, on a thrust whose strength slip changes. At the time that is found, and not before it. */
static void rest_ends_where_the_first_vector_is_long_enough(void **state)
{
  enum { N = 9 };
  SlipFault fault;
  PetscReal rest, stress[2 * N], *a;
  Vec w;

  for (PetscInt dip = 30; dip <= 90; dip += 60) {
    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    ok(FaultSetStrings(fault, {"friction_law", "constant"}, {"initial", "traction"}));
    ok(FaultSetReals(fault, {"nx", 3}, {"nz", 3}, {"rake", 40}, {"slip_components", 2}, {"dip", dip},
                     {"normal_stress", 5e7}, {"normal_stress_gradient", 0}, {"loading_rate", LOAD},
                     {"initial_traction", 1e7}));
    ok(SlipFaultSetUp(fault));
    assert_int_equal(fault->medium->Kn ? 1 : 0, dip < 90);
    ok(SlipFaultCreateState(fault, &w));
    ok(VecGetArrayWrite(w, &a));
    for (PetscInt i = 0; i < 5 * N; i++) a[i] = i % 5 < 2 || i % 5 == 4 ? 0 : 0.1 * PetscSinReal((PetscReal)(7 * i));
    ok(VecRestoreArrayWrite(w, &a));
    ok(SlipFaultRestTime(NULL, 0, w, &rest, fault));
    assert_true(rest > 0 && rest < 1e11);
    for (PetscInt part = 1; part <= 2; part++) { /* half of it, and all */
      SlipFrictionCells friction;
      PetscReal most = 0;
      Vec later;

      ok(VecDuplicate(w, &later));
      ok(VecCopy(w, later));
      ok(VecGetArray(later, &a));
      for (PetscInt i = 0; i < N; i++)
        for (PetscInt k = 0; k < 2; k++) a[5 * i + 2 + k] -= 0.5 * part * rest * LOAD * SlipFaultAlong(fault, i)[k];
      ok(VecRestoreArray(later, &a));
      ok(SlipFaultGetCellValues(fault, 0, later, "stress", N, stress));
      ok(SlipFaultGetFrictionOf(fault, 0, later, &friction));
      for (PetscInt i = 0; i < N; i++)
        most = PetscMax(most, hypot(stress[2 * i], stress[2 * i + 1]) / (0.5 * friction.stress[i]));
      /* H v_inf holds as well, 9 MPa s/m times 1e-9 m/s of some 1e7 Pa; and the root of a square, 1e-8 of whose
         argument may cancel */
      if (part == 1)
        assert_true(most < 1 - 1e-4);
      else
        AssertNear(most, 1, 1e-8);
      ok(VecDestroy(&later));
    }
    ObjectsDestroy(&w, &fault);
  }
}

/* A round crack in a full space under a stress drop of 1 Pa along the rake: u = (8/pi) (1 - nu)/(2 - nu) sqrt(R^2 -
   r^2)/G along it (Eshelby 1957), whatever the rake. Square cells within the circle have the symmetry of a square: what
   the rake 90 does is what 0 does, turned, to the solver's tolerance; so the slip of any other rake follows, and its
   error, that of collocation at 20 cells across (2.4 % in the middle), differs with the rake by what the mesh does
   across it, to second order in a few per cent. */
static void a_round_crack_slips_along_its_load(void **state)
{
  enum { SIDES = 20, MOST = SIDES * SIDES };
  const PetscReal rake[] = {0, 37, 90}, G = 3e10, nu = 0.25, R = 0.5 * SIDES, pi = PETSC_PI;
  PetscReal x[MOST], y[MOST], z[MOST], size[MOST], strike[MOST], dip[MOST], slip[3][2 * MOST], middle[3] = {0, 0, 0};
  PetscInt at[SIDES][SIDES], n = 0;
  SlipCells cells;
  Vec b, u;
  Mat K;
  KSP ksp;

  for (PetscInt j = 0; j < SIDES; j++)
    for (PetscInt i = 0; i < SIDES; i++) {
      const PetscReal a = (PetscReal)i + 0.5 - R, d = (PetscReal)j + 0.5 - R;

      at[j][i] = -1;
      if (hypot(a, d) > R) continue;
      at[j][i] = n;
      x[n] = a;
      y[n] = 0;
      z[n] = 1000 + d;
      size[n] = 1;
      strike[n] = 0;
      dip[n] = 90;
      n++;
    }
  cells = (SlipCells){
    .n = n, .x = x, .y = y, .z = z, .length = size, .width = size, .strike = strike, .dip = dip, .rake = strike};
  cells.kernel =
    (SlipKernel){.type = &SlipKernelDippingVector, .shear_modulus = G, .poisson_ratio = nu, .full_space = PETSC_TRUE};
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-8, &K, NULL));
  ok(MatCreateVecs(K, &u, &b));
  ok(KSPCreate(PETSC_COMM_SELF, &ksp));
  ok(KSPSetOperators(ksp, K, K));
  ok(KSPSetType(ksp, KSPCG));
  ok(KSPSetTolerances(ksp, 1e-13, 0, PETSC_DEFAULT, 10000));
  for (int k = 0; k < 3; k++) {
    PetscReal *f, c, s, across = 0;
    const PetscReal *a;

    SlipDegrees(rake[k], &s, &c);
    ok(VecGetArrayWrite(b, &f));
    for (PetscInt i = 0; i < n; i++) {
      f[2 * i] = c;
      f[2 * i + 1] = s;
    }
    ok(VecRestoreArrayWrite(b, &f));
    ok(KSPSolve(ksp, b, u));
    a = VecRead(u);
    ok(PetscArraycpy(slip[k], a, 2 * n));
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal along = slip[k][2 * i] * c + slip[k][2 * i + 1] * s;

      across = PetscMax(across, PetscAbsReal(slip[k][2 * i + 1] * c - slip[k][2 * i] * s));
      middle[k] = PetscMax(middle[k], along * G * pi / 8 * (2 - nu) / (1 - nu) / PetscSqrtReal(R * R - 0.5) - 1);
    }
    assert_true(middle[k] > 0.02 && middle[k] < 0.08);
    AssertNear(middle[k], middle[0], 5e-3);
  }
  for (PetscInt j = 0; j < SIDES; j++)
    for (PetscInt i = 0; i < SIDES; i++) {
      /* strike to up dip: a point at (a, up) goes to (up, a) */
      const PetscInt from = at[j][i], to = at[SIDES - 1 - i][SIDES - 1 - j];

      if (from < 0) continue;
      AssertNear(slip[2][2 * to + 1], slip[0][2 * from], 1e-9 * R / G);
      AssertNear(slip[2][2 * to], slip[0][2 * from + 1], 1e-9 * R / G);
    }
  ObjectsDestroy(&ksp, &u, &b, &K);
}

static void wrong_combinations_are_refused(void **state)
{
  SlipFault fault;

  fault = Cells(2, 2, PETSC_FALSE, 0, 2);
  ok(SlipFaultSetString(fault, "stiffness_file", "k.h5"));
  fails(SlipFaultSetUp(fault), "-fault_slip_components 2 does not go with -fault_stiffness_file k.h5");
  ok(SlipFaultDestroy(&fault));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  fails(SlipFaultSetReal(fault, "slip_components", 3), "slip_components");
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(a_line_slips_as_with_one_component, axes_do_not_matter, friction_opposes_the_slip_rate_and_powers_add_up,
           a_line_ruptures_as_with_one_component, ruptures_prefer_no_axis,
           rest_ends_where_the_first_vector_is_long_enough, a_round_crack_slips_along_its_load,
           wrong_combinations_are_refused)
