/* Triangles as cells: their kernel against that of rectangles, pairs at once, stiffnesses dense and hierarchical, and
   what is refused. */
#include "cells.h"
#include "operators.h"
#include <math.h>

enum { NX = 24, NZ = 8, N = 2 * NX * NZ, T = 2 * N };

static PetscReal rectangle_data[8 * N], triangle_data[TRIANGLE_COLUMNS * T];

/* Slip on both triangles of a rectangle is slip on the rectangle: shear and normal stress at the centroid of any
   triangle, of the same plane, of the other one and of the rectangle itself. Both are closed forms that cancel among
   corners: 1e-11 of the largest, in both media. */
static void pairs_are_rectangles(void **state)
{
  const SlipCells rectangles = TwoDippingPlanes(NX, NZ, rectangle_data);
  PetscReal most = 0, worst = 0;

  for (int space = 0; space < 2; space++) {
    SlipCells triangles = TrianglesOf(&rectangles, triangle_data);
    SlipKernel rock = rectangles.kernel;

    triangles.kernel.full_space = rock.full_space = (PetscBool)space;
    for (PetscInt r = 0; r < T; r += 15)
      for (PetscInt s = 0; s < N; s++) {
        const SlipCell receiver = CellOf(&triangles, r), source = CellOf(&rectangles, s);
        const SlipCell at = {.rectangle = receiver.rectangle, .rake = receiver.rake};
        PetscReal one[2], two[2], want[2];
        const SlipCell half[2] = {CellOf(&triangles, 2 * s), CellOf(&triangles, 2 * s + 1)};

        SlipKernelBlock(&triangles.kernel, &receiver, &half[0], one);
        SlipKernelBlock(&triangles.kernel, &receiver, &half[1], two);
        SlipKernelBlock(&rock, &at, &source, want);
        for (int k = 0; k < 2; k++) {
          most = PetscMax(most, PetscAbsReal(want[k]));
          worst = PetscMax(worst, PetscAbsReal(one[k] + two[k] - want[k]));
        }
      }
  }
  assert_true(most > 0);
  assert_true(worst < 1e-11 * most);
}

/* Entries as they are defined: S_ij = (A_i K_ij + A_j K_ji) / (2 mean(A)), Kn_ij the normal stress on i by j; to
   rounding of pairs at once */
static void entries(void **state)
{
  const SlipCells rectangles = TwoDippingPlanes(4, 3, rectangle_data), c = TrianglesOf(&rectangles, triangle_data);
  const PetscScalar *s, *n;
  PetscReal mean = 0, most = 0;
  Mat S, Kn;

  for (PetscInt i = 0; i < c.n; i++) mean += c.length[i] * c.width[i] / c.n;
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &c, "dense", 1e-6, &S));
  ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, &c, "dense", 1e-6, &Kn));
  s = MatRead(S);
  n = MatRead(Kn);
  for (PetscInt k = 0; k < c.n * c.n; k++) most = PetscMax(most, PetscAbsReal(s[k]));
  for (PetscInt j = 0; j < c.n; j++)
    for (PetscInt i = 0; i < c.n; i++) {
      const SlipCell p = CellOf(&c, i), q = CellOf(&c, j);
      PetscReal there[2], back[2];

      SlipKernelBlock(&c.kernel, &p, &q, there);
      SlipKernelBlock(&c.kernel, &q, &p, back);
      AssertNear(n[j * c.n + i], there[1], 1e-12 * most);
      AssertNear(s[j * c.n + i],
                 (c.length[i] * c.width[i] * there[0] + c.length[j] * c.width[j] * back[0]) / (2 * mean), 1e-12 * most);
    }
  ObjectsDestroy(&S, &Kn);
}

/* Hierarchical storage against dense */
static void hierarchical(void **state)
{
  const SlipCells rectangles = TwoDippingPlanes(NX, NZ, rectangle_data), c = TrianglesOf(&rectangles, triangle_data);
  Mat S[2], Kn[2];

  for (int t = 0; t < 2; t++) {
    MatInfo info[2];

    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", 1e-6, &S[t]));
    ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", 1e-6, &Kn[t]));
    ok(MatGetInfo(S[t], MAT_LOCAL, &info[0]));
    ok(MatGetInfo(Kn[t], MAT_LOCAL, &info[1]));
    if (t) assert_true(PetscMax(info[0].memory, info[1].memory) < 0.8 * 8 * T * T);
  }
  AssertHierarchical(S, Kn, 1e-6);
  ObjectsDestroy(&S[0], &S[1], &Kn[0], &Kn[1]);
}

/* Averages over both triangles of a rectangle, with slip on both of another one, are those of the rectangles: of a
   vertical plane that slips along strike, whose averages are known in closed form with a surface too, for equal cells,
   whose cores agree. Entries count by area over the mean: four of triangles are twice that of their rectangles. Below a
   surface averages of triangles are by quadrature, off by up to 7e-10 of a cell's own; there cells touch the ground. */
static void averages(void **state)
{
  enum { nx = 5, nz = 4, n = nx * nz };
  PetscReal data[8 * n], halves[TRIANGLE_COLUMNS * 2 * n];
  const SlipCells rectangles = DippingCellsOfColumns(n, data);

  for (PetscInt e = 0; e < n; e++) {
    const PetscReal value[8] = {100 * (e % nx + 0.5), 0, 80 * (e / nx + 0.5), 100, 80, 0, 90, 0};

    for (int k = 0; k < 8; k++) data[k * n + e] = value[k];
  }
  for (int space = 0; space < 2; space++) {
    SlipCells triangles = TrianglesOf(&rectangles, halves), plane = rectangles;
    const PetscScalar *s, *t;
    PetscReal most = 0;
    Mat S, T2;

    plane.strike = plane.dip = plane.rake = NULL;
    plane.kernel.type = &SlipKernelStrikeSlip;
    plane.kernel.average = triangles.kernel.average = SLIP_AVERAGE_CELL;
    plane.kernel.full_space = triangles.kernel.full_space = (PetscBool)space;
    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &plane, "dense", 1e-6, &S));
    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &triangles, "dense", 1e-6, &T2));
    s = MatRead(S);
    t = MatRead(T2);
    for (PetscInt k = 0; k < n; k++) most = PetscMax(most, s[k * (n + 1)]);
    for (PetscInt j = 0; j < n; j++)
      for (PetscInt i = 0; i < n; i++) {
        const PetscInt m = 2 * n;
        const PetscReal sum =
          t[2 * j * m + 2 * i] + t[2 * j * m + 2 * i + 1] + t[(2 * j + 1) * m + 2 * i] + t[(2 * j + 1) * m + 2 * i + 1];

        AssertNear(0.5 * sum, s[j * n + i], (space ? 1e-12 : 1e-8) * most);
      }
    ObjectsDestroy(&S, &T2);
  }
}

/* A row of needles beside a row of triangles 300 times as high: the core of a shared side is a share of the lower
   height, and all own averages stay positive. */
static void needles(void **state)
{
  enum { n = 8 };
  PetscReal data[TRIANGLE_COLUMNS * n];
  PetscReal *v = data + 8 * n;
  const PetscScalar *s;
  SlipCells c = DippingCellsOfColumns(n, data);
  Mat S;

  for (PetscInt e = 0; e < n; e++) {
    const PetscReal x = 100 * (PetscReal)(e / 2), deep = e % 2 ? 100 : -0.3;
    const PetscReal corner[9] = {x, 0, 1000, x + 100, 0, 1000, x + 50, 0, 1000 + deep};
    const PetscReal value[8] = {x + 50, 0, 1000 + deep / 3, 100, 0.5 * PetscAbsReal(deep), 0, 90, 0};

    for (int k = 0; k < 9; k++) v[9 * e + k] = corner[k];
    for (int k = 0; k < 8; k++) data[k * n + e] = value[k];
  }
  c.vertices = v;
  c.kernel.type = &SlipKernelTriangle;
  c.kernel.full_space = PETSC_TRUE;
  c.kernel.average = SLIP_AVERAGE_CELL;
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &c, "dense", 1e-6, &S));
  s = MatRead(S);
  for (PetscInt k = 0; k < n; k++) assert_true(s[k * (n + 1)] > 0);
  ok(MatDestroy(&S));
}

/* The kernel of triangles needs them, and those of rectangles have no use for them. */
static void refused(void **state)
{
  const SlipCells rectangles = TwoDippingPlanes(4, 3, rectangle_data);
  SlipCells c = TrianglesOf(&rectangles, triangle_data), none = rectangles;
  PetscInt number[48];

  ok(SlipCellsCheck(PETSC_COMM_SELF, &c, "test"));
  none.kernel.type = &SlipKernelTriangle;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &none, "test"), "kernel \"triangle\" with rectangles");
  c.kernel.type = &SlipKernelDipping;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &c, "test"), "kernel \"dipping\" with triangles");
  c.kernel.type = &SlipKernelTriangle;
  for (PetscInt i = 0; i < 48; i++) number[i] = 100 + i;
  c.number = number;
  ((PetscReal *)c.vertices)[9 * 5 + 2] = -1;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &c, "test"), "triangle 105 reaches above the surface: a vertex at depth -1 m");
}

SLIP_TESTS(pairs_are_rectangles, entries, hierarchical, averages, needles, refused)
