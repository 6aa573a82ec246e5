/* The stress of a region on the cells: closed forms, the same plane as each kind of mesh, turned with its stress, with
   one component of slip and with two, beside fields, and what is refused. Tolerances are roundings of sums of a dozen
   products of 1e8 Pa: 1e-14 of that, and 2e-12 of the shear stress where a rake is a multiple of 1e-10 degrees. */
#include "unit.h"
#include "faultstart.h"
#include "cells.h"
#include "tempdir.h"
#include <slipstep/private/slipfault.h>
#include <math.h>

#define RAD (PETSC_PI / 180)
#define SCALE 1e8
#define ROUNDING (1e-14 * SCALE)
#define OF_RAKE (2e-12 * SCALE)

enum { NX = 3, NZ = 2, N = NX * NZ };
static const char tensor[] = "9e7,1.2e8,1.4e8,-2e7,1e7,-5e6", gradient[] = "1e3,-2e3,3e3,500,-700,200";

static SlipFault Grid(PetscReal strike, PetscReal dip, PetscReal rake)
{
  SlipFault fault;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"depth_top", 2000}, {"strike", strike}, {"dip", dip},
                   {"rake", rake}));
  return fault;
}

static void Get(SlipFault fault, PetscInt n, PetscReal normal[], PetscReal shear[], PetscReal rake[])
{
  ok(SlipFaultGetField(fault, "normal_stress", n, normal));
  ok(SlipFaultGetField(fault, "initial_traction", n, shear));
  ok(SlipFaultGetField(fault, "rake", n, rake));
}

/* Mohr's circle of the horizontal stresses for vertical planes at any angle to SHmax, under water: left-lateral shear
   where SHmax points to the left of the strike */
static void strike_slip(void **state)
{
  const PetscReal azimuth = 25, major = 1.3, minor = 0.7;
  PetscReal normal[N], shear[N], rake[N], z[N];

  for (PetscReal strike = -170; strike < 180; strike += 35) {
    const PetscReal angle = 2 * (azimuth - strike) * RAD;
    SlipFault fault = Grid(strike, 90, 0);

    ok(SlipFaultSetString(fault, "regional_ratios", "1.3,0.7"));
    ok(FaultSetReals(fault, {"regional_azimuth", azimuth}, {"density", 2700}));
    ok(SlipFaultSetUp(fault));
    Get(fault, N, normal, shear, rake);
    ok(SlipFaultGetGeometry(fault, "z", N, z));
    for (int i = 0; i < N; i++) {
      const PetscReal vertical = 2700 * 9.81 * z[i], p = 9810 * z[i];

      AssertNear(normal[i], vertical * (0.5 * (major + minor) - 0.5 * (major - minor) * cos(angle)) - p, ROUNDING);
      AssertNear(shear[i], -0.5 * vertical * (major - minor) * sin(angle), ROUNDING);
      AssertNear(fault->fields.tendency[i], fabs(shear[i]) / normal[i], 1e-12);
    }
    ok(SlipFaultDestroy(&fault));
  }
}

/* Planes of any dip across SHmax: thrust, rake 90, where SHmax is the largest stress, and normal slip where Sv is */
static void thrust(void **state)
{
  static const char *const ratios[] = {"1.6,1.1", "0.7,0.5"};
  PetscReal normal[N], shear[N], rake[N], z[N];

  for (int k = 0; k < 2; k++)
    for (PetscReal dip = 15; dip < 90; dip += 15) {
      const PetscReal ratio = k ? 0.7 : 1.6;
      SlipFault fault = Grid(40, dip, 90);

      ok(FaultSetStrings(fault, {"regional_ratios", ratios[k]}, {"regional_pressure", "2e6,5e3"}));
      ok(SlipFaultSetReal(fault, "regional_azimuth", 130));
      ok(SlipFaultSetUp(fault));
      Get(fault, N, normal, shear, rake);
      ok(SlipFaultGetGeometry(fault, "z", N, z));
      for (int i = 0; i < N; i++) {
        const PetscReal vertical = 2500 * 9.81 * z[i];

        AssertNear(normal[i],
                   vertical * (0.5 * (1 + ratio) + 0.5 * (1 - ratio) * cos(2 * dip * RAD)) - 2e6 - 5e3 * z[i],
                   ROUNDING);
        AssertNear(shear[i], 0.5 * (ratio - 1) * vertical * sin(2 * dip * RAD), ROUNDING);
      }
      ok(SlipFaultDestroy(&fault));
    }
}

/* The cells of a grid as a file of rectangles or triangles, whose rows 2 e and 2 e + 1 are those of cell e */
static SlipFault FromFile(const char file[], SlipFault grid, PetscBool triangles, PetscReal strike, PetscReal dip)
{
  const SlipFaultMesh *mesh = &grid->mesh;
  const PetscInt vertices[] = {mesh->npoints, 3}, shape[] = {2 * N, 3}, rows[] = {N, 7};
  PetscReal *points, row[N][7];
  PetscInt *corners, corner[2 * N][3];
  SlipFault fault;
  SlipH5 h;

  ok(SlipH5Create(file, &h));
  ok(PetscMalloc2(3 * mesh->npoints, &points, 4 * mesh->N, &corners));
  ok(mesh->kind->corners(mesh, points, corners));
  for (PetscInt e = 0; e < N; e++) {
    SlipFaultCell cell;

    mesh->kind->cell(mesh, e, &cell);
    for (int k = 0; k < 3; k++) {
      row[e][k] = cell.centre[k];
      corner[2 * e][k] = corners[4 * e + k];
      corner[2 * e + 1][k] = corners[4 * e + (k ? k + 1 : 0)];
    }
    row[e][3] = cell.size[0], row[e][4] = cell.size[1], row[e][5] = strike, row[e][6] = dip;
  }
  if (triangles) {
    ok(SlipH5WriteReal(&h, "/vertices", 2, vertices, points, "m"));
    ok(SlipH5WriteInt(&h, "/triangles", 2, shape, corner[0], NULL));
  } else {
    ok(SlipH5WriteReal(&h, "/cells", 2, rows, row[0], NULL));
    ok(SlipH5WriteAttrString(&h, "/cells", "columns", "x y z length width strike dip"));
    ok(SlipH5WriteAttrString(&h, "/cells", "units", "m"));
  }
  ok(SlipH5Close(&h));
  ok(PetscFree2(points, corners));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "mesh", file));
  return fault;
}

/* To 1e-13 for triangles, whose directions come from coordinates of 1e4 m that round to 1e-12 m; with a gradient the
   cells of a grid and of rectangles alone have the same centres */
static void meshes(void **state)
{
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  PetscReal normal[3][2 * N], shear[3][2 * N], rake[2 * N], *z = rake;

  assert_int_equal(0, TempDirFile("regional", "mesh.h5", dir, file));
  for (int graded = 0; graded < 2; graded++)
    for (PetscReal dip = 35; dip <= 90; dip += 55) {
      SlipFault grid = Grid(37, dip, 70), fault;

      for (int kind = 0; kind < 3 - graded; kind++) {
        fault = kind ? FromFile(file, grid, (PetscBool)(kind == 2), 37, dip) : grid;
        ok(SlipFaultSetReal(fault, "rake", 70));
        ok(SlipFaultSetString(fault, "regional_stress", tensor));
        if (graded) ok(SlipFaultSetString(fault, "regional_stress_gradient", gradient));
        ok(SlipFaultSetString(fault, "regional_pressure", graded ? "hydrostatic" : "1e6,0"));
        ok(SlipFaultSetUp(fault));
        Get(fault, kind == 2 ? 2 * N : N, normal[kind], shear[kind], rake);
        for (PetscInt e = 0; e < (kind == 2 ? 2 * N : N); e++) {
          AssertNear(normal[kind][e], normal[0][kind == 2 ? e / 2 : e], 10 * ROUNDING);
          AssertNear(shear[kind][e], shear[0][kind == 2 ? e / 2 : e], 10 * ROUNDING);
        }
        if (kind) ok(SlipFaultDestroy(&fault));
      }
      ok(SlipFaultGetGeometry(grid, "z", N, z));
      AssertLess(graded ? 1e6 : -1, fabs(normal[0][0] - normal[0][N - 1]));
      ok(SlipFaultDestroy(&grid));
    }
  assert_int_equal(0, TempDirRemove(dir));
}

/* A tensor that turns about the vertical with the plane */
static void turned(void **state)
{
  const PetscReal s[] = {9e7, 1.2e8, 1.4e8, -2e7, 1e7, -5e6};
  PetscReal normal[2][N], shear[2][N], rake[N];

  for (PetscReal turn = 0; turn < 360; turn += 75) {
    const PetscReal c = cos(turn * RAD), d = sin(turn * RAD);
    SlipFault fault = Grid(20 + turn > 360 ? turn - 340 : 20 + turn, 50, -60);
    char text[256];

    snprintf(text, sizeof(text), "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", c * c * s[0] + d * d * s[1] - 2 * c * d * s[3],
             d * d * s[0] + c * c * s[1] + 2 * c * d * s[3], s[2], c * d * (s[0] - s[1]) + (c * c - d * d) * s[3],
             c * s[4] - d * s[5], d * s[4] + c * s[5]);
    ok(SlipFaultSetString(fault, "regional_stress", text));
    ok(SlipFaultSetUp(fault));
    Get(fault, N, normal[turn > 0], shear[turn > 0], rake);
    for (int i = 0; i < N; i++) {
      AssertNear(normal[turn > 0][i], normal[0][i], 10 * ROUNDING);
      AssertNear(shear[turn > 0][i], shear[0][i], 10 * ROUNDING);
    }
    ok(SlipFaultDestroy(&fault));
  }
}

/* Two components of slip: the load is the shear stress as a vector, which one component has along its rake, along
   rakes 0 and 90 in turn; one component whose rake is that of the shear has the same normal stress, rake and size. */
static void components(void **state)
{
  PetscReal normal[4][N], shear[4][N], rake[4][N];

  for (int k = 0; k < 4; k++) {
    SlipFault fault = Grid(110, 40, k == 1 ? 90 : 0);
    const SlipFaultLoad *load;
    const PetscScalar *a;

    ok(FaultSetStrings(fault, {"regional_stress", tensor}, {"regional_stress_gradient", gradient}));
    if (k == 2) ok(SlipFaultSetString(fault, "regional_rake", "shear"));
    if (k == 3) ok(SlipFaultSetReal(fault, "slip_components", 2));
    ok(SlipFaultSetUp(fault));
    Get(fault, N, normal[k], shear[k], rake[k]);
    for (int i = 0; i < N; i++) AssertNear(normal[k][i], normal[0][i], 0);
    for (int i = 0; i < N && k == 2; i++) {
      AssertNear(shear[2][i], hypot(shear[0][i], shear[1][i]), OF_RAKE);
      AssertNear(rake[2][i], atan2(shear[1][i], shear[0][i]) / RAD, 1e-10);
      AssertNear(fault->fields.tendency[i], shear[2][i] / normal[2][i], 1e-12);
    }
    if (k == 3) {
      ok(SlipFaultGetLoad(fault, 0, &load));
      a = VecRead(load->shear);
      for (int i = 0; i < N; i++) {
        assert_true(shear[3][i] == shear[2][i] && rake[3][i] == rake[2][i]);
        AssertNear(a[2 * i], shear[0][i], OF_RAKE);
        AssertNear(a[2 * i + 1], shear[1][i], OF_RAKE);
      }
    }
    ok(SlipFaultDestroy(&fault));
  }
}

/* Stress of one shape at all depths, and uniform stress, give all cells of a plane one rake, and pure strike slip
   exactly 180, so that the stiffness stays that of one direction. */
static void one_rake(void **state)
{
  PetscReal normal[N], shear[N], rake[N];

  for (int k = 0; k < 2; k++) {
    SlipFault fault = Grid(k ? 77 : 0, k ? 63 : 90, 0);

    ok(FaultSetStrings(fault, {"regional_ratios", "1.3,0.6"}, {"regional_rake", "shear"}));
    ok(SlipFaultSetReal(fault, "regional_azimuth", 31));
    ok(SlipFaultSetUp(fault));
    Get(fault, N, normal, shear, rake);
    for (int i = 0; i < N; i++) assert_true(rake[i] == rake[0] && shear[i] > 0);
    assert_true(k || rake[0] == 180);
    ok(SlipFaultDestroy(&fault));
  }
}

/* Fields override the stress, and it overrides scalars; a rake that is a field turns the traction. */
static void fields(void **state)
{
  PetscReal normal[N], shear[N], rake[N], across[N], given[N], upward[N];
  SlipFault fault = Grid(110, 40, 90);

  for (int i = 0; i < N; i++) given[i] = 1e7 + i, upward[i] = 90;
  ok(SlipFaultSetString(fault, "regional_stress", tensor));
  ok(FaultSetReals(fault, {"normal_stress", 5e7}, {"initial_traction", 1e6}));
  ok(SlipFaultSetUp(fault));
  Get(fault, N, normal, across, rake);
  assert_string_equal(fault->fields.source[FIELD_NORMAL_STRESS], "-fault_regional_stress");
  assert_string_equal(fault->fields.source[FIELD_INITIAL_TRACTION], "-fault_regional_stress");
  assert_true(!fault->fields.source[FIELD_RAKE] && !strcmp(fault->kind.initial, "traction"));
  ok(SlipFaultDestroy(&fault));

  fault = Grid(110, 40, 0);
  ok(SlipFaultSetString(fault, "regional_stress", tensor));
  ok(SlipFaultSetField(fault, "normal_stress", N, given));
  ok(SlipFaultSetField(fault, "rake", N, upward));
  ok(SlipFaultSetUp(fault));
  Get(fault, N, normal, shear, rake);
  for (int i = 0; i < N; i++) assert_true(normal[i] == given[i] && shear[i] == across[i] && rake[i] == 90);
  assert_string_equal(fault->fields.source[FIELD_NORMAL_STRESS], "SlipFaultSetField()");
  ok(SlipFaultDestroy(&fault));
}

static void Refuse(const char options[], const char want[])
{
  SlipFault fault = Grid(0, 90, 0);

  ok(SetOptions(options));
  ok(SlipFaultSetFromOptions(fault));
  fails(SlipFaultSetUp(fault), want);
  ok(SetOptions(""));
  ok(SlipFaultDestroy(&fault));
}

static void refused(void **state)
{
  PetscReal upward[N] = {0};
  SlipFault fault;

  Refuse("-fault_regional_stress 1e8,1e8,1e8", "-fault_regional_stress is \"1e8,1e8,1e8\", expected six numbers of Pa");
  Refuse("-fault_regional_stress 1e8,1e8,1e8,0,0,x", "expected six numbers of Pa");
  Refuse("-fault_regional_stress 1e8,1e8,1e8,0,0,inf", "expected six numbers of Pa");
  Refuse("-fault_regional_stress_gradient 1,2,3,4,5,6,7", "expected six numbers of Pa/m");
  Refuse("-fault_regional_ratios 0.5,1.5", "the first one not below the second");
  Refuse("-fault_regional_ratios 1.5,-1", "both > 0");
  Refuse("-fault_regional_ratios 1.5", "expected two numbers SHmax/Sv,Shmin/Sv");
  Refuse("-fault_regional_stress 1e8,1e8,1e8,0,0,0 -fault_regional_pressure wet",
         "-fault_regional_pressure is \"wet\", expected hydrostatic, none, or two numbers");
  Refuse("-fault_regional_stress 1e8,1e8,1e8,0,0,0 -fault_regional_ratios 1.2,0.8", "exclude each other");
  Refuse("-fault_regional_pressure none", "expected -fault_regional_stress or -fault_regional_ratios");
  Refuse("-fault_regional_azimuth 30", "which is not given");
  /* centres at 2750 and 4250 m, and 3e7 Pa of water from 3058 m on */
  Refuse("-fault_regional_stress 3e7,3e7,3e7,0,0,0",
         "the effective normal stress by -fault_regional_stress is not positive in 3 of 6 cells, of which the first is "
         "cell 3 at x 500, y 0, z 4250 m with -1.16925e+07 Pa");
  fault = Grid(0, 90, 0);
  ok(SlipFaultSetString(fault, "regional_stress", tensor));
  ok(SlipFaultSetReal(fault, "slip_components", 2));
  ok(SlipFaultSetField(fault, "rake", N, upward));
  fails(SlipFaultSetUp(fault), "-fault_regional_stress and a field rake (SlipFaultSetField()) exclude each other");
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(strike_slip, thrust, meshes, turned, components, one_rake, fields, refused)
