/* What both kinds of mesh say of their cells: places and corners against each other, planes, extents, and that the
   user's options stay as they were. */
#include "operators.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include <string.h>
#include "cells.h"
#include "tempdir.h"

enum { NX = 3, NZ = 2, N = 2 * NX * NZ };

/* The centre of a cell is the mean of its corners, which are half its sides away along its directions; both to rounding
   of numbers of at most 1e4 m. */
static void CheckCorners(const SlipFaultMesh *mesh)
{
  PetscReal *points;
  PetscInt *corners;

  ok(PetscMalloc2(3 * mesh->npoints, &points, 4 * mesh->N, &corners));
  ok(mesh->kind->corners(mesh, points, corners));
  for (PetscInt e = 0; e < mesh->N; e++) {
    const PetscReal *const p[4] = {points + 3 * corners[4 * e], points + 3 * corners[4 * e + 1],
                                   points + 3 * corners[4 * e + 2], points + 3 * corners[4 * e + 3]};
    SlipFaultCell cell;

    mesh->kind->cell(mesh, e, &cell);
    for (int k = 0; k < 3; k++) {
      assert_true(fabs((p[0][k] + p[1][k] + p[2][k] + p[3][k]) / 4 - cell.centre[k]) < 1e-10);
      assert_true(fabs(p[1][k] - p[0][k] - cell.size[0] * cell.direction[0][k]) < 1e-10);
      assert_true(fabs(p[2][k] - p[1][k] - cell.size[1] * cell.direction[1][k]) < 1e-10);
    }
  }
  ok(PetscFree2(points, corners));
}

static PetscReal Real(SlipFault fault, const char name[])
{
  PetscReal value;

  ok(SlipFaultGetReal(fault, name, &value));
  return value;
}

static void grid(void **state)
{
  SlipFault fault;
  SlipFaultCell cell;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"depth_top", 500}));
  ok(SlipFaultSetUp(fault));
  CheckCorners(&fault->mesh);
  fault->mesh.kind->cell(&fault->mesh, NX + 2, &cell); /* 1000 x 1500 m, below, at the right */
  assert_true(cell.centre[0] == 2500 && cell.centre[1] == 0 && cell.centre[2] == 2750);
  assert_true(fault->mesh.npoints == (NX + 1) * (NZ + 1) && fault->mesh.planes == 1 && fault->mesh.area == 1.5e6);
  assert_true(Real(fault, "nx") == NX && Real(fault, "depth_top") == 500);
  ok(SlipFaultDestroy(&fault));
}

static void list(void **state)
{
  PetscReal numbers[5 * N], left = PETSC_MAX_REAL, right = PETSC_MIN_REAL, area = 0;
  const SlipCells cells = TwoGradedFaults(NX, NZ, 5, numbers);
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE], first[96], second[96];
  SlipFault fault;

  assert_int_equal(0, TempDirFile("mesh", "mesh.h5", dir, file));
  ok(WriteCells(file, &cells));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "mesh", file));
  assert_true(Real(fault, "nx") == 1);
  ok(SlipFaultSetUp(fault));
  CheckCorners(&fault->mesh);
  for (PetscInt e = 0; e < N; e++) {
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, e, &cell);
    assert_true(cell.centre[0] == cells.x[e] && cell.centre[1] == cells.y[e] && cell.centre[2] == cells.z[e]);
    assert_true(cell.size[0] == cells.length[e] && cell.size[1] == cells.width[e]);
    assert_true((cell.plane == 0) == (cells.y[e] == cells.y[0]) && cell.plane < 2);
    left = PetscMin(left, cells.x[e] - 0.5 * cells.length[e]);
    right = PetscMax(right, cells.x[e] + 0.5 * cells.length[e]);
    area += cells.length[e] * cells.width[e];
  }
  assert_int_equal(2, fault->mesh.planes);
  assert_true(fabs(fault->mesh.area * N / area - 1) < 1e-14);
  /* as a grid, the list is one row; the options of a grid keep their values, which do not count */
  assert_true(Real(fault, "nx") == N && Real(fault, "nz") == 1 && Real(fault, "length_x") == right - left);
  assert_true(Real(fault, "thickness") == right - left);
  assert_true(fault->options.value[FAULT_NX] == 1 && fault->options.value[FAULT_LENGTH_X] == 3000);
  /* a restart knows another mesh by one number */
  ok(fault->mesh.kind->digest(&fault->mesh, first, sizeof(first)));
  ((PetscReal *)fault->mesh.cells.z)[N - 1] += 1e-9;
  ok(fault->mesh.kind->digest(&fault->mesh, second, sizeof(second)));
  assert_true(strcmp(first, second) != 0);
  ok(SlipFaultDestroy(&fault));
  assert_int_equal(0, TempDirRemove(dir));
}

/* Cell k of a plane of strike and dip whose middle is at the place at [m], 2 x 2 cells of 400 m x 300 m */
static void AddTo(PetscReal column[7][8], PetscInt row, PetscInt k, PetscReal strike, PetscReal dip,
                  const PetscReal at[3])
{
  PetscReal d[9];

  SlipPlaneDirections(strike, dip, 0, d);
  for (int i = 0; i < 3; i++) column[i][row] = at[i] + (k % 2 ? 200 : -200) * d[i] - (k / 2 ? 150 : -150) * d[3 + i];
  column[3][row] = 400;
  column[4][row] = 300;
  column[5][row] = strike;
  column[6][row] = dip;
}

static SlipFault FaultOf(const char file[], const SlipCells *cells, const PetscReal label[])
{
  SlipFault fault;

  ok(WriteLabelledCells(file, cells, label));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "mesh", file));
  ok(SlipFaultSetString(fault, "initial", "rest")); /* critical does not know normal stress that slip changes */
  ok(SlipFaultSetUp(fault));
  return fault;
}

/* Two parallel planes, rows in turn: strikes a turn apart and coordinates of 1e5 m that round make no third one. */
static void planes(void **state)
{
  const PetscReal at[2][3] = {{-1e5, 2e5, 5000}, {-1e5, 203000, 5000}}, label[8] = {7, 7, -3, 7, 7, -3, 7, 7};
  PetscReal column[7][8], d[9];
  SlipCells cells = {.n = 8};
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE], first[96], second[96];
  SlipFault fault;

  assert_int_equal(0, TempDirFile("mesh", "mesh.h5", dir, file));
  for (PetscInt k = 0; k < 8; k++) AddTo(column, k, k / 2, k == 4 ? 340 : -20, 35, at[k % 2]);
  cells.x = column[0], cells.y = column[1], cells.z = column[2], cells.length = column[3], cells.width = column[4];
  cells.strike = column[5], cells.dip = column[6];
  fault = FaultOf(file, &cells, NULL);
  CheckCorners(&fault->mesh);
  assert_int_equal(2, fault->mesh.planes);
  assert_true(fault->mesh.dips && !fault->mesh.labelled);
  SlipPlaneDirections(-20, 35, 0, d);
  for (PetscInt k = 0; k < 8; k++) {
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, k, &cell);
    assert_true(cell.plane == k % 2 && fault->mesh.label[k] == k % 2);
    for (int i = 0; i < 3; i++) { /* sines of strikes a turn apart agree to rounding */
      AssertNear(cell.direction[0][i], d[i], 1e-14);
      AssertNear(cell.direction[1][i], -d[3 + i], 1e-14);
      AssertNear(cell.direction[2][i], d[6 + i], 1e-14);
    }
  }
  /* 3000 m apart eastward, which is -sin(20) of that along the strike; 1e-9: of 1e5 m that round */
  AssertNear(Real(fault, "length_x"), 800 + 3000 * PetscSinReal(20 * PETSC_PI / 180), 1e-9);
  AssertNear(Real(fault, "length_z"), 600, 1e-9);
  AssertNear(Real(fault, "depth_top"), 5000 - 300 * PetscSinReal(35 * PETSC_PI / 180), 1e-9);
  assert_true(Real(fault, "dip") == 35);
  ok(fault->mesh.kind->digest(&fault->mesh, first, sizeof(first)));
  ok(SlipFaultDestroy(&fault));
  /* labels are the file's, and count as another mesh */
  fault = FaultOf(file, &cells, label);
  for (PetscInt k = 0; k < 8; k++) assert_int_equal((PetscInt)label[k], fault->mesh.label[k]);
  ok(fault->mesh.kind->digest(&fault->mesh, second, sizeof(second)));
  assert_true(strcmp(first, second) != 0);
  ok(SlipFaultDestroy(&fault));
  assert_int_equal(0, TempDirRemove(dir));
}

/* Strike 0 and dip 90 everywhere are the list of five columns, to the bit; a vertical plane of another strike is that
   plane turned, whose stiffness is the same but for rounding: 1e-12 of its diagonal, at coordinates of a few cells. */
static void vertical(void **state)
{
  PetscReal numbers[5 * N], zero[N], ninety[N], thirty[N], x[N], y[N];
  SlipCells cells = TwoGradedFaults(NX, NZ, 5, numbers);
  const PetscReal c = PetscCosReal(PETSC_PI / 6), s = PetscSinReal(PETSC_PI / 6);
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE], digest[2][96];
  SlipFault fault[3];
  Mat K[3];

  assert_int_equal(0, TempDirFile("mesh", "mesh.h5", dir, file));
  for (PetscInt k = 0; k < N; k++) {
    zero[k] = 0;
    thirty[k] = 30;
    ninety[k] = 90;
    x[k] = c * cells.x[k] - s * cells.y[k];
    y[k] = s * cells.x[k] + c * cells.y[k];
  }
  fault[0] = FaultOf(file, &cells, NULL);
  cells.strike = zero;
  cells.dip = ninety;
  fault[1] = FaultOf(file, &cells, NULL);
  cells.strike = thirty;
  cells.x = x;
  cells.y = y;
  fault[2] = FaultOf(file, &cells, NULL);
  for (int f = 0; f < 3; f++) ok(SlipFaultGetOperators(fault[f], &K[f], NULL, NULL));
  assert_true(!fault[1]->mesh.dips && !fault[2]->mesh.dips && fault[2]->mesh.planes == 2);
  for (int f = 0; f < 2; f++) ok(fault[f]->mesh.kind->digest(&fault[f]->mesh, digest[f], sizeof(digest[f])));
  assert_string_equal(digest[0], digest[1]);
  AssertNear(Real(fault[2], "length_x"), Real(fault[0], "length_x"), 1e-10);
  assert_true(MatDistance(K[1], K[0]) == 0);
  assert_true(MatDistance(K[2], K[0]) < 1e-12);
  for (int f = 0; f < 3; f++) ok(SlipFaultDestroy(&fault[f]));
  assert_int_equal(0, TempDirRemove(dir));
}

/* A vertical grid of any strike has the stiffness of that of strike 0, in hierarchical storage too. */
static void turned_grid(void **state)
{
  Mat K[2];
  SlipFault fault[2];

  for (int f = 0; f < 2; f++) {
    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault[f]));
    ok(FaultSetStrings(fault[f], {"operator", f ? "hmat" : "dense"}, {"viscosity", "radiation"}));
    ok(FaultSetReals(fault[f], {"nx", NX}, {"nz", NZ}, {"strike", f ? 50 : 0}));
    ok(SlipFaultSetUp(fault[f]));
    ok(SlipFaultGetOperators(fault[f], &K[f], NULL, NULL));
  }
  assert_true(MatDistance(K[1], K[0]) < 1e-12); /* one block, which is stored as it is */
  ObjectsDestroy(&fault[0], &fault[1]);
}

/* ---- triangles ---- */

/* A rectangle of length x width [m] from a corner, of its strike and dip, as two triangles: rows of vertex and corner
   from r on */
static void AddRectangle(PetscReal vertex[][3], PetscReal triangle[][3], PetscInt r, PetscReal strike, PetscReal dip,
                         PetscReal length, PetscReal width, const PetscReal at[3])
{
  static const int corners[2][3] = {{0, 1, 2}, {0, 2, 3}};
  const PetscReal a = strike * PETSC_PI / 180, b = dip * PETSC_PI / 180;
  const PetscReal along[3] = {PetscCosReal(a), PetscSinReal(a), 0};
  const PetscReal down[3] = {-PetscSinReal(a) * PetscCosReal(b), PetscCosReal(a) * PetscCosReal(b), PetscSinReal(b)};

  for (int v = 0; v < 4; v++)
    for (int k = 0; k < 3; k++)
      vertex[4 * r + v][k] = at[k] + (v == 1 || v == 2 ? length : 0) * along[k] + (v >= 2 ? width : 0) * down[k];
  for (int t = 0; t < 2; t++)
    for (int k = 0; k < 3; k++) triangle[2 * r + t][k] = 4 * r + corners[t][k];
}

/* Of the first n triangles of such rectangles, each of which has a label of its own */
static SlipFault FaultOfTriangles(PetscInt n, const PetscReal vertex[][3], const PetscReal triangle[][3])
{
  const PetscInt vertices[2] = {4 * ((n + 1) / 2), 3}, triangles[2] = {n, 3};
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  PetscReal label[16];
  SlipFault fault;
  SlipH5 h;

  for (PetscInt i = 0; i < n; i++) label[i] = i / 2;
  assert_int_equal(0, TempDirFile("mesh", "mesh.h5", dir, file));
  ok(SlipH5Create(file, &h));
  ok(SlipH5WriteReal(&h, "/vertices", 2, vertices, &vertex[0][0], "m"));
  ok(SlipH5WriteReal(&h, "/triangles", 2, triangles, &triangle[0][0], NULL));
  ok(SlipH5WriteReal(&h, "/fault", 1, triangles, label, NULL));
  ok(SlipH5Close(&h));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"mesh", file}, {"initial", "rest"}, {"viscosity", "radiation"}));
  ok(SlipFaultSetUp(fault));
  assert_int_equal(0, TempDirRemove(dir));
  return fault;
}

/* Vertical planes of one strike, and of both strikes of one plane, are those of an infinite dip: neither strikes a turn
   apart by rounding, nor a second one by the choice of the hanging wall at 1e-3 from north, make them others, and what
   is more than a billionth of a circle does. */
static void vertical_triangles(void **state)
{
  const PetscReal edge = PetscAsinReal(1e-3) * 180 / PETSC_PI;
  const struct {
    PetscReal strike[2], dip[2], turn;
    PetscBool dips;
  } cases[] = {{{30, 30}, {90, 90}, 0, PETSC_FALSE},
               {{1e-9, -1e-9}, {90, 90}, 360, PETSC_FALSE},
               {{-edge + 1e-10, -edge - 1e-10}, {90, 90}, 180, PETSC_FALSE},
               {{30, 30 + 2e-7}, {90, 90}, 0, PETSC_FALSE},
               {{30, 30 + 1e-6}, {90, 90}, 0, PETSC_TRUE},
               {{30, 30}, {90, 90 - 2e-7}, 0, PETSC_FALSE},
               {{30, 30}, {90, 90 - 1e-6}, 0, PETSC_TRUE},
               {{30, 30}, {90 - 1e-6, 90}, 0, PETSC_TRUE},
               {{30, 120}, {90, 90}, 90, PETSC_TRUE}};

  for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(cases); c++) {
    PetscReal vertex[8][3], triangle[4][3];
    SlipFault fault;

    for (int r = 0; r < 2; r++) {
      const PetscReal at[3] = {0, 5000 * r, 1000};

      AddRectangle(vertex, triangle, r, cases[c].strike[r], cases[c].dip[r], 1000, 1000, at);
    }
    fault = FaultOfTriangles(4, (const PetscReal(*)[3])vertex, (const PetscReal(*)[3])triangle);
    assert_int_equal(cases[c].dips, fault->mesh.dips);
    AssertNear(PetscAbsReal(fault->mesh.cells.strike[0] - fault->mesh.cells.strike[2]), cases[c].turn, 2e-6);
    ok(SlipFaultDestroy(&fault));
  }
}

/* Numbers of two rectangles beside each other in one dipping plane, and of two planes */
static void extents_of_triangles(void **state)
{
  const PetscReal strike = 300, dip = 40, sine = PetscSinReal(dip * PETSC_PI / 180);
  PetscReal d[9], vertex[8][3], triangle[4][3];
  SlipFault fault;

  SlipPlaneDirections(strike, dip, 0, d);
  for (int r = 0; r < 2; r++) {
    const PetscReal at[3] = {7e3 + 1200 * r * d[0], -3e3 + 1200 * r * d[1], 500 + 1200 * r * d[2]};

    AddRectangle(vertex, triangle, r, strike, dip, 1200, 800, at);
  }
  fault = FaultOfTriangles(4, (const PetscReal(*)[3])vertex, (const PetscReal(*)[3])triangle);
  assert_true(fault->mesh.N == 4 && fault->mesh.planes == 1 && fault->mesh.dips && fault->mesh.labelled);
  assert_true(fault->mesh.npoints == 6 && fault->mesh.faults == 2); /* vertices in one place are one */
  assert_true(Real(fault, "nx") == 4 && Real(fault, "nz") == 1);
  AssertNear(Real(fault, "length_x"), 2400, 1e-8); /* of coordinates of 1e4 m that round */
  AssertNear(Real(fault, "length_z"), 800, 1e-8);
  AssertNear(Real(fault, "depth_top"), 500, 1e-8);
  AssertNear(Real(fault, "strike"), strike, 1e-9);
  AssertNear(Real(fault, "dip"), dip, 1e-9);
  AssertNear(fault->mesh.area, 0.5 * 1200 * 800, 1e-6);
  for (PetscInt e = 0; e < 4; e++) {
    PetscReal centre[3] = {0, 0, 0};
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, e, &cell);
    AssertNear(cell.size[0], 1200, 1e-8);
    AssertNear(cell.size[1], 400, 1e-8); /* the area over that */
    for (int k = 0; k < 9; k++) centre[k % 3] += cell.vertices[k] / 3;
    for (int k = 0; k < 3; k++) AssertNear(cell.centre[k], centre[k], 1e-9);
    AssertNear(cell.centre[2], 500 + 800 * sine * (e % 2 ? 2 : 1) / 3, 1e-8);
    for (int k = 0; k < 3; k++) AssertNear(cell.direction[2][k], d[6 + k], 1e-12);
  }
  ok(SlipFaultDestroy(&fault));
  for (int r = 0; r < 2; r++) { /* strikes and dips in the middle, and the ground as it rounds */
    const PetscReal at[3] = {0, 9000 * r, -1e-5};

    AddRectangle(vertex, triangle, r, r ? 350 : 310, r ? 50 : 30, 1000, 500, at);
  }
  fault = FaultOfTriangles(4, (const PetscReal(*)[3])vertex, (const PetscReal(*)[3])triangle);
  assert_true(fault->mesh.planes == 2 && Real(fault, "depth_top") == 0);
  AssertNear(Real(fault, "strike"), 330, 1e-9);
  AssertNear(Real(fault, "dip"), 40, 1e-9);
  for (PetscInt e = 0; e < 4; e++) {
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, e, &cell);
    SlipPlaneDirections(e / 2 ? 350 : 310, e / 2 ? 50 : 30, 0, d);
    assert_int_equal(e / 2, cell.plane);
    for (int k = 0; k < 3; k++) AssertNear(cell.direction[0][k], d[k], 1e-9);
  }
  ok(SlipFaultDestroy(&fault));
  fault = FaultOfTriangles(1, (const PetscReal(*)[3])vertex, (const PetscReal(*)[3])triangle);
  assert_true(fault->mesh.N == 1 && fault->mesh.dips && Real(fault, "nx") == 1);
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(grid, list, planes, vertical, turned_grid, vertical_triangles, extents_of_triangles)
