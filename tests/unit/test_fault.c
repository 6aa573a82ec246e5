/* The fault without an integrator: parameters and their errors, files, scaling, critical state, elimination, energy. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <unistd.h>

static SlipFault Make(PetscInt nx, PetscInt nz)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", nx}, {"nz", nz}));
  return fault;
}

static void parameters(void **state)
{
  SlipFault fault = Make(2, 2);
  PetscReal x;

  ok(SlipFaultGetReal(fault, "thickness", &x));
  assert_true(x == 3000);
  ok(SlipFaultSetReal(fault, "length_x", 5000));
  ok(SlipFaultGetReal(fault, "thickness", &x));
  assert_true(x == 5000);
  ok(SlipFaultSetReal(fault, "thickness", 1000));
  ok(SlipFaultGetReal(fault, "thickness", &x));
  assert_true(x == 1000);
  fails(SlipFaultSetReal(fault, "nx", 0), "-fault_nx is 0, expected a whole number >= 1");
  fails(SlipFaultSetReal(fault, "nx", 2.5), "-fault_nx is 2.5");
  fails(SlipFaultSetReal(fault, "length_z", -1), "-fault_length_z is -1, expected a number > 0 and < 1e+06 m");
  fails(SlipFaultSetReal(fault, "thickness", 0), "-fault_thickness is 0");
  fails(SlipFaultSetReal(fault, "density", NAN), "-fault_density is nan");
  fails(SlipFaultSetReal(fault, "shear_modulus", INFINITY), "-fault_shear_modulus is inf");
  fails(SlipFaultSetReal(fault, "poisson_ratio", 0.5), "expected a number > -1 and < 0.5");
  fails(SlipFaultSetReal(fault, "color", 1), "no number \"color\"");
  fails(SlipFaultSetString(fault, "friction_law", "velcro"), "-fault_friction_law is \"velcro\", expected one of "
                                                             "exponential_slip_weakening, linear_slip_weakening, "
                                                             "rate_weakening, constant");
  fails(SlipFaultSetString(fault, "initial", "a|b"), "expected one of auto, critical, rest");
  fails(SlipFaultSetString(fault, "color", "red"), "no choice \"color\"");
  ok(SlipFaultDestroy(&fault));
}

/* The cells are known before the rest, fields are functions of them, and what the mesh is made of stays. */
static void mesh_first(void **state)
{
  SlipFault fault = Make(3, 2);
  PetscReal z[6], a[6], got[6];

  ok(FaultSetReals(fault, {"length_x", 3000}, {"length_z", 4000}, {"dip", 30}, {"strike", 350}, {"depth_top", 500}));
  fails(SlipFaultGetGeometry(fault, "z", 6, z), "call SlipFaultSetUpMesh() or SlipFaultSetUp() first");
  ok(SlipFaultSetUpMesh(fault));
  ok(SlipFaultSetUpMesh(fault));
  ok(SlipFaultGetGeometry(fault, "z", 6, z));
  ok(SlipFaultGetGeometry(fault, "area", 6, a));
  for (PetscInt i = 0; i < 6; i++) {
    assert_true(fabs(z[i] - (500 + (i / 3 ? 1500 : 500))) < 1e-9); /* half of 1000 and 3000 m down dip */
    assert_true(fabs(a[i] - 2e6) < 1e-6);
  }
  ok(SlipFaultGetGeometry(fault, "strike", 6, got));
  assert_true(fabs(got[0] - 350) < 1e-9);
  ok(SlipFaultGetGeometry(fault, "dip", 6, got));
  assert_true(fabs(got[0] - 30) < 1e-9);
  fails(SlipFaultGetGeometry(fault, "rake", 6, got), "cells have no \"rake\"; expected x, y, z, area");
  fails(SlipFaultGetGeometry(fault, "z", 5, got), "room for 5 cells, expected the 6");
  fails(SlipFaultSetReal(fault, "dip", 60), "dip must be set before SlipFaultSetUp() and SlipFaultSetUpMesh()");
  fails(SlipFaultSetString(fault, "mesh", "m.h5"), "mesh must be set before");
  fails(SlipFaultSetInertia(fault, PETSC_FALSE), "before SlipFaultSetUp() and SlipFaultSetUpMesh()");
  for (PetscInt i = 0; i < 6; i++) a[i] = 0.1 + 1e-5 * z[i];
  ok(SlipFaultSetField(fault, "friction_drop", 6, a));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultGetField(fault, "friction_drop", 6, got));
  for (PetscInt i = 0; i < 6; i++) assert_true(got[i] == a[i]);
  ok(SlipFaultDestroy(&fault));
}

/* What a matrix tells of itself; overwritten by the next. */
static const char *ViewOf(Mat A)
{
  static char text[4096];
  PetscViewer viewer;
  FILE *file = tmpfile();

  assert_non_null(file);
  ok(PetscViewerASCIIOpenWithFILE(PETSC_COMM_SELF, file, &viewer));
  ok(MatView(A, viewer));
  ok(PetscViewerDestroy(&viewer));
  rewind(file);
  text[fread(text, 1, sizeof(text) - 1, file)] = '\0';
  (void)fclose(file);
  return text;
}

/* Each of two faults reads the options of its own prefix and no others, calls them by it in errors, and hands it to its
   operators. */
static void two_faults(void **state)
{
  static const char *const options[][2] = {{"-upper_fault_nx", "2"},
                                           {"-lower_fault_nx", "3"},
                                           {"-fault_nx", "5"},
                                           {"-lower_fault_friction_law", "constant"},
                                           {"-lower_fault_thickness", "0"},
                                           {"-upper_fault_viscosity", "lanczos"},
                                           {"-lower_fault_viscosity", "lanczos"},
                                           {"-upper_mat_slipsqrtm_tolerance", "0.5"},
                                           {"-lower_mat_slipsqrtm_tolerance", "1e-10"}};
  SlipFault upper, lower, again;
  const char *prefix;
  PetscReal x;
  PetscInt N;
  Mat K;
  TS ts;

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(options); i++)
    ok(PetscOptionsSetValue(NULL, options[i][0], options[i][1]));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &upper));
  ok(SlipFaultSetOptionsPrefix(upper, "upper_"));
  ok(SlipFaultSetFromOptions(upper));
  ok(SlipFaultGetReal(upper, "nx", &x));
  assert_true(x == 2);
  ok(SlipFaultCreate(PETSC_COMM_SELF, &lower));
  ok(SlipFaultSetOptionsPrefix(lower, "lo"));
  ok(SlipFaultAppendOptionsPrefix(lower, "wer_"));
  ok(SlipFaultGetOptionsPrefix(lower, &prefix));
  assert_string_equal(prefix, "lower_");
  fails(SlipFaultSetFromOptions(lower), "-lower_fault_thickness is 0");
  ok(PetscOptionsClearValue(NULL, "-lower_fault_thickness"));
  ok(SlipFaultSetFromOptions(lower));
  fails(SlipFaultSetString(lower, "kernel", "none"), "-lower_fault_kernel is \"none\"");
  ok(SlipFaultSetUp(upper));
  ok(SlipFaultSetUp(lower));
  ok(SlipFaultGetOperators(lower, &K, NULL, NULL));
  ok(MatGetSize(K, &N, NULL));
  assert_int_equal(N, 3);
  ok(MatGetOptionsPrefix(K, &prefix));
  assert_string_equal(prefix, "lower_");
  /* by their views, as Lanczos' method is exact for so few cells */
  assert_non_null(strstr(ViewOf(upper->medium->H), "relative tolerance 0.5,"));
  assert_non_null(strstr(ViewOf(lower->medium->H), "relative tolerance 1e-10,"));
  assert_string_equal(lower->friction.law->name, "constant");
  assert_string_equal(upper->friction.law->name, "exponential_slip_weakening");
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(options); i++) ok(PetscOptionsClearValue(NULL, options[i][0]));

  /* a reference, and that of a TS, keep it alive */
  again = upper;
  ok(SlipFaultReference(again));
  ok(SlipFaultDestroy(&upper));
  assert_null(upper);
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipFaultConfigureTS(again, ts));
  assert_int_equal(((PetscObject)again)->refct, 2);
  ObjectsDestroy(&again, &ts, &lower);

  again = Make(2, 3);
  ok(SlipFaultSetOptionsPrefix(again, "third_"));
  ok(FaultSetStrings(again, {"operator", "hmat"}, {"viscosity", "spectral"}));
  fails(SlipFaultSetUp(again), "-third_fault_viscosity spectral needs a uniform grid with -third_fault_operator dense");
  ok(SlipFaultDestroy(&again));
}

static void normal_stress(void **state)
{
  /* uniform part, gradient [Pa/m], what the deepest cell has per metre; NaN: not given. A value alone is uniform. */
  const PetscReal given[4][3] = {{NAN, NAN, 15e3}, {1e6, NAN, 0}, {1e6, 2e3, 2e3}, {NAN, 2e3, 2e3}};
  SlipFault fault;

  for (int k = 0; k < 4; k++) {
    PetscReal gradient;

    fault = Make(2, 3);
    ok(SlipFaultSetReal(fault, "depth_top", 200));
    if (!isnan(given[k][1])) ok(SlipFaultSetReal(fault, "normal_stress_gradient", given[k][1]));
    if (!isnan(given[k][0])) ok(SlipFaultSetReal(fault, "normal_stress", given[k][0]));
    ok(SlipFaultSetUp(fault));
    /* centre of the last row: 200 m + 2500 m; both terms are exact in doubles */
    assert_true(fault->fields.cell[FIELD_NORMAL_STRESS][5] ==
                (isnan(given[k][0]) ? 0 : given[k][0]) + given[k][2] * 2700);
    ok(SlipFaultGetReal(fault, "normal_stress_gradient", &gradient));
    assert_true(gradient == given[k][2]);
    fails(SlipFaultSetReal(fault, "nx", 3), "before SlipFaultSetUp");
    ok(SlipFaultDestroy(&fault));
  }
  fault = Make(1, 1);
  ok(SlipFaultSetReal(fault, "normal_stress_gradient", 0));
  fails(SlipFaultSetUp(fault), "expected > 0: raise -fault_normal_stress");
  ok(SlipFaultDestroy(&fault));
}

/* Sums of 9 numbers and refined conjugate gradients: 1e-11 leaves room for the condition number (about 5). */
static void scaling_and_critical_state(void **state)
{
  SlipFault fault = Make(3, 3);
  Vec sigma, x;
  PetscReal mean, stress, norm, sum;

  ok(SlipFaultSetString(fault, "stiffness_scaling", "mean_slip"));
  ok(SlipFaultSetUp(fault));
  VecsDuplicate(fault->critical.uc, &sigma, &x);
  for (PetscInt e = 0; e < 9; e++) ok(VecSetValue(sigma, e, fault->fields.cell[FIELD_NORMAL_STRESS][e], INSERT_VALUES));
  ok(VecAssemble(sigma));
  ok(SlipElasticSolve(fault->medium, sigma, x));
  ok(VecSum(x, &mean));
  ok(VecSum(sigma, &stress));
  assert_true(fabs(mean / (stress * 3000 / 30e9) - 1) < 1e-11);
  ok(MatMult(fault->medium->K, fault->critical.uc, x)); /* K uc = 0.6 sigma */
  ok(VecAXPY(x, -0.6, sigma));
  ok(VecNorm(x, NORM_INFINITY, &norm));
  ok(VecNorm(sigma, NORM_INFINITY, &sum));
  assert_true(norm < 1e-11 * sum);
  ObjectsDestroy(&x, &sigma, &fault);
}

/* Nobody has asked for a scaling: one cell of 3 km at the surface has 0.311646 G/km, known to these digits. */
static void elasticity_is_left_alone(void **state)
{
  SlipFault fault = Make(1, 1);
  PetscReal K;
  Vec d;

  ok(SlipFaultSetUp(fault));
  assert_true(fault->operators.scaling == 1);
  ok(SlipFaultGetWork(fault, &d));
  ok(MatGetDiagonal(fault->medium->K, d));
  ok(VecMax(d, NULL, &K));
  ok(SlipFaultRestoreWork(fault, &d));
  assert_true(fabs(K / (0.311646 * 30e9 / 1000) - 1) < 2e-6);
  ok(SlipFaultDestroy(&fault));
}

static void WriteField(const char file[], const char name[], PetscInt nz, PetscInt nx, const PetscReal data[])
{
  const PetscInt dims[2] = {nz, nx};
  SlipH5 h;

  ok(SlipH5Create(file, &h));
  ok(SlipH5WriteReal(&h, name, 2, dims, data, NULL));
  ok(SlipH5Close(&h));
}

/* The set-up of nx x nz cells with this option fails, and says want. */
static void Refuses(PetscInt nx, PetscInt nz, const char option[], const char value[], const char want[])
{
  SlipFault fault = Make(nx, nz);

  ok(SlipFaultSetString(fault, option, value));
  fails(SlipFaultSetUp(fault), want);
  ok(SlipFaultDestroy(&fault));
}

static void field_file(void **state)
{
  const char *file = "test_fault_fields.h5";
  PetscReal data[6] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  SlipFault fault = Make(3, 2);

  WriteField(file, "/friction_slip", 2, 3, data);
  ok(SlipFaultSetString(fault, "parameters", file));
  ok(SlipFaultSetUp(fault));
  assert_memory_equal(data, fault->fields.cell[FIELD_FRICTION_SLIP], sizeof(data));
  assert_true(fault->fields.cell[FIELD_FRICTION_DROP][5] == 0.1);
  assert_true(fabs(fault->critical.mean_dc - 0.35) < 1e-15);
  ok(SlipFaultDestroy(&fault));
  Refuses(2, 3, "parameters", file, "has shape [2, 3], expected [3, 2], Nz x Nx");
  data[4] = -0.5;
  WriteField(file, "/normal_stress", 2, 3, data);
  Refuses(3, 2, "parameters", file, "/normal_stress[1, 1] is -0.5, expected a finite number > 0 Pa");
  data[4] = NAN;
  WriteField(file, "/friction_drop", 2, 3, data);
  Refuses(3, 2, "parameters", file, "/friction_drop[1, 1] is nan");
  data[4] = 1;
  WriteField(file, "/frictoin_drop", 2, 3, data);
  Refuses(3, 2, "parameters", file, "holds /frictoin_drop, which nothing reads");
  unlink(file);
}

static void stiffness_file(void **state)
{
  const char *file = "test_fault_stiffness.h5";
  PetscReal good[4] = {3e7, -1e7, -1e7, 3e7}, x;
  SlipFault fault = Make(2, 1);

  WriteField(file, "/run/K", 2, 2, good);
  ok(FaultSetStrings(fault, {"stiffness_file", "test_fault_stiffness.h5:/run/K"}, {"stiffness_scaling", "none"}));
  ok(SlipFaultSetUp(fault));
  ok(MatNorm(fault->medium->K, NORM_FROBENIUS, &x));
  assert_true(fabs(x - sqrt(20.) * 1e7) < 1e-8); /* one rounding of a number of 4.5e7 is 7e-9 */
  ok(SlipFaultDestroy(&fault));
  Refuses(2, 1, "stiffness_file", file, "has no dataset /stiffness");
  Refuses(3, 1, "stiffness_file", "test_fault_stiffness.h5:/run/K",
          "has shape [2, 2], expected [3, 3], N x N with N = nx nz");
  good[2] = NAN;
  WriteField(file, "/stiffness", 2, 2, good);
  Refuses(2, 1, "stiffness_file", file, "/stiffness[1, 0] is nan");
  unlink(file);
}

/* -fault_stiffness_view writes K after scaling, bit for bit, in PETSc's binary format. */
static void stiffness_view(void **state)
{
  const char *file = "test_fault_view.bin";
  SlipFault fault = Make(3, 2);
  PetscViewer viewer;
  Mat K, dense;
  PetscBool same;

  ok(PetscOptionsSetValue(NULL, "-fault_stiffness_view", "binary:test_fault_view.bin"));
  ok(SlipFaultSetFromOptions(fault));
  ok(PetscOptionsClearValue(NULL, "-fault_stiffness_view"));
  ok(SlipFaultSetString(fault, "stiffness_scaling", "mean_slip"));
  ok(SlipFaultSetUp(fault));
  assert_true(fault->operators.scaling != 1);
  ok(PetscViewerBinaryOpen(PETSC_COMM_SELF, file, FILE_MODE_READ, &viewer));
  ok(MatCreate(PETSC_COMM_SELF, &K));
  ok(MatSetType(K, MATDENSE));
  ok(MatLoad(K, viewer));
  ok(MatConvert(fault->medium->K, MATDENSE, MAT_INITIAL_MATRIX, &dense));
  ok(MatEqual(K, dense, &same));
  assert_true(same);
  ObjectsDestroy(&dense, &K, &viewer, &fault);
  unlink(file);
  unlink("test_fault_view.bin.info");
}

/* A stage's elimination: the lifted state must satisfy A (w - base) = theta (F_s(w) + ex + omega r) row by row, r the
   residual G(v)/omega of any v. Every term is at most about 1e9 Pa, so rounding is below 1e-6 Pa; 1e-4 is allowed. */
static void elimination(void **state)
{
  SlipFault fault = Make(3, 2);
  SlipStage stage = {.theta = 0.37, .omega = 2};
  Vec base, ex, w, F, v, r;
  PetscRandom random;
  PetscReal *a, *b, *c, *f;
  const PetscReal *g;

  ok(SlipFaultSetReal(fault, "loading_rate", 0.02));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultCreateState(fault, &base));
  VecsDuplicate(base, &ex, &w, &F);
  VecsDuplicate(fault->critical.uc, &v, &r);
  ok(PetscRandomCreate(PETSC_COMM_SELF, &random));
  ok(PetscRandomSetInterval(random, -1, 1));
  ok(VecSetRandom(base, random));
  ok(VecSetRandom(ex, random));
  ok(VecSetRandom(v, random));
  stage.base = base;
  stage.explicit_part = ex;
  ok(SlipFaultConstraintStage(fault, &stage));
  ok(SlipFaultConstraintResidual(fault, v, r)); /* G(v) = omega r */
  ok(SlipFaultConstraintLift(fault, v, w));
  ok(SlipFaultSmooth(fault, 0, w, F));
  ok(VecGetArray(w, &a));
  ok(VecGetArray(base, &b));
  ok(VecGetArray(ex, &c));
  ok(VecGetArray(F, &f));
  g = VecRead(r);
  for (PetscInt i = 0; i < 6; i++) {
    const PetscReal *wi = a + 3 * i, *bi = b + 3 * i, *ci = c + 3 * i, *fi = f + 3 * i;

    assert_true(fabs(fault->operators.mass / 0.37 * (wi[0] - bi[0]) - (fi[0] + ci[0] + g[i])) < 1e-4);
    assert_true(fabs((wi[1] - bi[1]) / 0.37 - (fi[1] + ci[1])) < 1e-12); /* numbers of size 1 */
    assert_true(fabs((wi[2] - bi[2]) / 0.37 - (fi[2] + ci[2])) < 1e-12);
  }
  ok(VecRestoreArray(w, &a));
  ok(VecRestoreArray(base, &b));
  ok(VecRestoreArray(ex, &c));
  ok(VecRestoreArray(F, &f));
  ObjectsDestroy(&random, &base, &ex, &w, &F, &v, &r, &fault);
}

/* d(kinetic + elastic)/dt + viscous + friction = loading holds instant by instant: with dw/dt = A^-1 (F_s + r) the
   rate of change is v.M dv/dt + u.K du/dt. Relative to the largest term; sums of a dozen doubles: 1e-12. */
static void power_balance(void **state)
{
  SlipFault fault = Make(4, 3);
  Vec w, F, r, ku, u;
  PetscRandom random;
  SlipFaultObservables o;
  PetscReal rate = 0, *a, *f, *x;
  const PetscReal *k, *q;

  ok(SlipFaultSetReal(fault, "loading_rate", -0.03));
  ok(SlipFaultSetUp(fault));
  ok(SlipFaultCreateState(fault, &w));
  ok(VecDuplicate(w, &F));
  VecsDuplicate(fault->critical.uc, &r, &ku, &u);
  ok(PetscRandomCreate(PETSC_COMM_SELF, &random));
  ok(PetscRandomSetInterval(random, -0.1, 0.1));
  ok(VecSetRandom(w, random));
  ok(VecSetRandom(r, random));
  ok(VecScale(r, 1e7));
  ok(SlipFaultSmooth(fault, 0, w, F));
  ok(VecGetArray(w, &a));
  ok(VecGetArrayWrite(u, &x));
  for (PetscInt i = 0; i < 12; i++) x[i] = a[3 * i + 1];
  ok(VecRestoreArrayWrite(u, &x));
  ok(MatMult(fault->medium->K, u, ku));
  ok(VecGetArray(F, &f));
  k = VecRead(ku);
  q = VecRead(r);
  for (PetscInt i = 0; i < 12; i++) rate += (a[3 * i] * (f[3 * i] + q[i]) + k[i] * f[3 * i + 1]) / 12;
  ok(VecRestoreArray(F, &f));
  ok(VecRestoreArray(w, &a));
  ok(SlipFaultGetObservables(fault, 0, w, r, &o));
  assert_true(o.viscous_power > 0);
  assert_true(fabs(rate + o.viscous_power + o.friction_power - o.loading_power) <
              1e-12 * (fabs(rate) + o.viscous_power + fabs(o.friction_power) + fabs(o.loading_power)));
  ObjectsDestroy(&random, &w, &F, &r, &ku, &u, &fault);
}

static PetscReal ObserveFault(SlipFault fault, Vec w, const char name[])
{
  PetscInt component, row = SlipObservationFind(name, &component);
  PetscReal value;

  assert_true(row >= 0);
  ok(SlipFaultObserve(fault, 0, w, 1, &row, &value));
  return value;
}

static void observations(void **state)
{
  SlipFault fault = Make(3, 3);
  Vec w;
  PetscReal x;

  ok(FaultSetUpState(fault, &w));
  x = ObserveFault(fault, w, "energy");
  assert_true(fabs(x - 1.00001 * 1.00001) < 1e-11); /* refined conjugate gradients: rounding only */
  x = ObserveFault(fault, w, "displacement");
  assert_true(fabs(x + 1.00001) < 1e-11);
  x = ObserveFault(fault, w, "velocity");
  assert_true(x == 0);
  ok(VecSetValue(w, 3 * 4, 0.63, INSERT_VALUES)); /* v of cell 4 */
  ok(VecAssemble(w));
  x = ObserveFault(fault, w, "velocity");
  assert_true(fabs(x - 1) < 1e-14); /* 0.63/9/0.07 */
  x = ObserveFault(fault, w, "sliding_fraction");
  assert_true(fabs(x - 1. / 9) < 1e-15);
  x = ObserveFault(fault, w, "log_velocity");
  assert_true(fabs(x - log10(0.63 * sqrt(2500 / 30e9) * 3000 / 0.1)) < 1e-13);
  ObjectsDestroy(&w, &fault);
}

/* Slip of cells that always slide is that since the start, whatever time of a long run the clock counts from. */
static void slip_since_the_start(void **state)
{
  SlipFault fault = Make(2, 2);
  SlipFaultObservables o[2];
  Vec w;

  ok(SlipFaultSetString(fault, "friction_law", "rate_and_state"));
  ok(SlipFaultSetReal(fault, "loading_rate", 0.25));
  ok(FaultSetUpState(fault, &w));
  ok(SlipFaultGetObservables(fault, 5, w, NULL, &o[0]));
  fault->loads.origin = 3;
  ok(SlipFaultGetObservables(fault, 2, w, NULL, &o[1]));
  assert_true(o[0].mean_slip == 1.25 && o[1].mean_slip == 1.25);
  ObjectsDestroy(&w, &fault);
}

/* The growth that a policy observes is that of the size of rates, whichever way cells slide; cells at rest have
   none. */
static void growth(void **state)
{
  const PetscReal v[] = {0.2, -0.3, 0, -0.1}, derivative[] = {1, 2, 4, -8};
  SlipFault fault = Make(2, 2);
  Vec w, d;

  ok(FaultSetUpState(fault, &w));
  ok(VecDuplicate(w, &d));
  ok(VecZeroEntries(d));
  for (PetscInt i = 0; i < 4; i++) {
    ok(VecSetValue(w, 3 * i, v[i], INSERT_VALUES));
    ok(VecSetValue(d, 3 * i, derivative[i], INSERT_VALUES));
  }
  ok(VecAssemble(w));
  ok(VecAssemble(d));
  ok(SlipFaultKeepEstimates(fault, w, NULL, d));
  assert_true(fault->known.estimates.sum[ESTIMATE_GROWTH] == 1 - 2 + 8);
  ObjectsDestroy(&w, &d, &fault);
}

/* Vectors for the time of a function: each is another one, they are given back after runs of all sorts, and one more
   than there are is an error. */
static void work_vectors(void **state)
{
  const char *const kinds[][2] = {
    {"friction_law", "linear_slip_weakening"}, {"friction_law", "rate_and_state"}, {"initial", "rest"}};
  Vec x[FAULT_WORK + 1] = {NULL};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(kinds); k++) {
    SlipFault fault = Make(3, 2);
    TS ts;
    Vec w;

    ok(SlipFaultSetString(fault, kinds[k][0], kinds[k][1]));
    ok(SlipFaultSetReal(fault, "loading_rate", 1e-3));
    ok(FaultStart(fault, NULL, 0, 5, &w, &ts));
    ok(TSSetMaxSteps(ts, 20));
    ok(TSSolve(ts, w));
    for (PetscInt i = 0; i < FAULT_WORK; i++) assert_false(fault->taken[i]);
    if (!k) {
      for (PetscInt i = 0; i < FAULT_WORK; i++) {
        ok(SlipFaultGetWork(fault, &x[i]));
        for (PetscInt j = 0; j < i; j++) assert_ptr_not_equal(x[i], x[j]);
      }
      fails(SlipFaultGetWork(fault, &x[FAULT_WORK]), "vectors of slip are in use");
      for (PetscInt i = 0; i < FAULT_WORK; i++) ok(SlipFaultRestoreWork(fault, &x[i]));
      ok(SlipFaultGetWork(fault, &x[0]));
      ok(SlipFaultRestoreWork(fault, &x[0]));
      assert_null(x[0]);
    }
    ObjectsDestroy(&ts, &w, &fault);
  }
}

SLIP_TESTS(work_vectors, parameters, mesh_first, two_faults, normal_stress, scaling_and_critical_state,
           elasticity_is_left_alone, field_file, stiffness_file, elimination, stiffness_view, power_balance,
           observations, slip_since_the_start, growth)
