/* Products with stiffnesses on a device of OpenCL: against those of the processor and the dense matrix, their bits from
   one to the next, and what goes between the processor and the device. Where there is no device the test says so. */
#include "unit.h"
#include "cells.h"
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatcommon.h>
#include <math.h>

static SlipDevice device;
#define NEEDS_DEVICE                                                                                                   \
  (void)state;                                                                                                         \
  if (!device) skip()

static void Fill(PetscInt which, Vec x)
{
  PetscReal *a;
  PetscInt n;

  ok(VecGetLocalSize(x, &n));
  ok(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < n; i++)
    a[i] = sin(1.3 + 0.7 * (double)which + 0.013 * (double)((which + 2) * i)) + 0.3 * (double)(i % 7);
  ok(VecRestoreArrayWrite(x, &a));
}

/* Of vectors of either kind, relative to the largest entry of x */
static PetscReal Difference(Vec x, Vec y)
{
  const PetscReal *a, *b;
  PetscReal most = 0, differ = 0;
  PetscInt n;

  ok(VecGetLocalSize(x, &n));
  ok(VecGetArrayRead(x, &a));
  ok(VecGetArrayRead(y, &b));
  for (PetscInt i = 0; i < n; i++) {
    most = PetscMax(most, fabs(a[i]));
    differ = PetscMax(differ, fabs(a[i] - b[i]));
  }
  ok(VecRestoreArrayRead(y, &b));
  ok(VecRestoreArrayRead(x, &a));
  return differ / most;
}

/* The largest difference of y = K x on the device from K x on the processor, and from D x unless D is NULL: 1e-12,
   rounding of sums of some thousand terms. Again gives the same bits, without any vector between the two; a matrix that
   was scaled gives as much more. */
static void Products(const char what[], Mat K, Mat D)
{
  SlipDeviceTraffic start, end;
  PetscReal bytes, differ, dense = 0;
  Vec x, y, z = NULL, u, v, w;
  PetscBool same;

  ok(MatCreateVecs(K, &x, &y));
  Fill(1, x);
  ok(MatMult(K, x, y));
  if (D) {
    ok(VecDuplicate(y, &z));
    ok(MatMult(D, x, z));
  }
  ok(SlipMatDeviceBytes(K, &bytes)); /* of some, of what it shares with another one, too */
  start = SlipDeviceGetTraffic();
  ok(SlipMatUseDevice(K));
  end = SlipDeviceGetTraffic();
  assert_true((PetscReal)(end.bytes - start.bytes) <= bytes); /* what it says is what it takes, VkFFT's own apart */
  ok(SlipMatUseDevice(K));
  assert_true(SlipDeviceGetTraffic().bytes == end.bytes);
  ok(MatCreateVecs(K, &u, &v));
  assert_true(SlipDeviceVecIs(u) && SlipDeviceVecIs(v));
  Fill(1, u);
  ok(MatMult(K, u, v));
  differ = Difference(y, v);
  if (D) dense = Difference(z, v);
  if (!(differ < 1e-12 && dense < 1e-12))
    fail_msg("%s: products on the device differ by %g, and from a dense matrix by %g", what, (double)differ,
             (double)dense);
  if (SlipDeviceShares(device)) assert_true(differ == 0); /* it is the processor's own product */
  ok(VecDuplicate(v, &w));
  start = SlipDeviceGetTraffic();
  ok(MatMult(K, u, w));
  end = SlipDeviceGetTraffic();
  assert_true(end.puts == start.puts && end.fetches == start.fetches && end.numbers == start.numbers);
  ok(SlipVecSame(v, w, &same));
  assert_true(same);
  ok(MatHasOperation(K, MATOP_SCALE, &same));
  if (same) {
    ok(MatScale(K, -0.5));
    ok(VecScale(y, -0.5));
  }
  ok(MatMult(K, u, w));
  assert_true(Difference(y, w) < 1e-12);
  ok(MatMult(K, x, y)); /* and on the processor as before */
  assert_true(Difference(y, w) < 1e-12);
  ObjectsDestroy(&x, &y, &z, &u, &v, &w);
}

/* Both at once are one by one, to the bit, and without traffic. */
static void Both(Mat K, Mat Kn)
{
  SlipDeviceTraffic start, end;
  PetscBool same;
  Vec u, f, n, g, m;

  ok(MatCreateVecs(K, &u, &f));
  ok(MatCreateVecs(Kn, NULL, &n));
  ok(VecDuplicate(f, &g));
  ok(VecDuplicate(n, &m));
  Fill(2, u);
  ok(MatMult(K, u, f));
  ok(MatMult(Kn, u, n));
  start = SlipDeviceGetTraffic();
  ok(MatSlipStiffnessMultBoth(K, Kn, u, g, m));
  end = SlipDeviceGetTraffic();
  assert_true(end.puts == start.puts && end.fetches == start.fetches && end.numbers == start.numbers);
  ok(SlipVecSame(f, g, &same));
  assert_true(same);
  ok(SlipVecSame(n, m, &same));
  assert_true(same);
  ObjectsDestroy(&u, &f, &n, &g, &m);
}

/* By transforms: half-space and full space, at the ground and below, one row and many, averages; and without transforms
   in depth, a kernel below the ground that has none */
static void grids(void **state)
{
  static SlipKernelType plain;
  const SlipGrid grids[] = {
    {20, 12, 3000.0, 1800.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)},
    {17, 9, 2000.0, 1100.0, 700.0, ROCK(0.1, PETSC_FALSE, SLIP_AVERAGE_CENTRE)},
    {13, 1, 2000.0, 100.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)},
    {1, 16, 500.0, 3600.0, 0.0, ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)},
    {24, 15, 3000.0, 2000.0, 0.0, ROCK(0.3, PETSC_TRUE, SLIP_AVERAGE_CELL)},
    {11, 9, 3000.0, 2900.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_WHOLE)},
    {20, 11, 3000.0, 1900.0, 300.0, {&plain, 30e9, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL}},
    {1, 7, 300.0, 1900.0, 300.0, {&plain, 30e9, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL}}};

  NEEDS_DEVICE;
  plain = SlipKernelStrikeSlip;
  plain.surface = NULL;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(grids); k++) {
    Mat K, D;

    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grids[k], "fft", &K));
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grids[k], "dense", &D));
    Products("a grid", K, D);
    ObjectsDestroy(&K, &D);
  }
}

/* Slip along strike, up dip, along rakes that differ, as a vector and with opening; normal stress, and both at once */
static void dipping(void **state)
{
  enum { nx = 14, nz = 9, n = nx * nz };
  const SlipKernelType *const types[] = {&SlipKernelDipping, &SlipKernelDipping, &SlipKernelDipping,
                                         &SlipKernelDippingVector, &SlipKernelDippingOpening};
  PetscReal rake[n];

  NEEDS_DEVICE;
  for (int k = 0; k < 5; k++) {
    const SlipDippingGrid grid = {
      .grid = {nx, nz, 1500, 800, 50 * (k % 2), {types[k], 30e9, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL}},
      .dip = 55,
      .rake = rake,
      .tolerance = 1e-6};
    Mat K, Kn, D, Dn;

    for (PetscInt i = 0; i < n; i++) rake[i] = k < 2 ? 90 * k : 3 * (double)i;
    for (int t = 0; t < 2; t++)
      if (k < 3)
        ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, t ? "dense" : "fft", t ? &D : &K, t ? &Dn : &Kn));
      else
        ok(
          MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, t ? "dense" : "fft", t ? &D : &K, t ? &Dn : &Kn));
    Products("normal stress of a dipping grid", Kn, Dn);
    Products("a dipping grid", K, D);
    Both(K, Kn);
    ObjectsDestroy(k % 2 ? &K : &Kn);
    ObjectsDestroy(&K, &Kn, &D, &Dn);
  }
}

/* Square and not, of fewer columns than groups of them, and of more rows than a group of items */
static void dense(void **state)
{
  const PetscInt sizes[][2] = {{200, 200}, {7, 5}, {1, 300}, {129, 64}};

  NEEDS_DEVICE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(sizes); k++) {
    const PetscInt m = sizes[k][0], n = sizes[k][1];
    PetscReal *a;
    Mat A;

    ok(MatCreateSeqDense(PETSC_COMM_SELF, m, n, NULL, &A));
    ok(MatDenseGetArrayWrite(A, &a));
    for (PetscInt i = 0; i < m * n; i++) a[i] = cos(0.37 * (double)(i % 1013)) + 0.2;
    ok(MatDenseRestoreArrayWrite(A, &a));
    ok(MatAssemble(A));
    Products("a dense matrix", A, NULL);
    ok(MatDestroy(&A));
  }
}

/* Rows of normal stress, whose weights differ */
static void opening(void **state)
{
  enum { n = 2 * 4 * 3 };
  static PetscReal data[8 * n];
  SlipCells cells = TwoDippingPlanes(4, 3, data);
  Mat S, Kn;

  NEEDS_DEVICE;
  for (PetscInt e = 0; e < n; e++) data[4 * n + e] = 70 + (PetscReal)(e / 4 % 3);
  cells.kernel.type = &SlipKernelDippingOpening;
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-6, &S, &Kn));
  Products("normal stress of cells that open", Kn, NULL);
  Products("a stiffness of cells that open", S, NULL);
  Both(S, Kn);
  ObjectsDestroy(&S, &Kn);
}

/* Two planes far from each other, blocks of which are taller than a group of work items takes; and triangles of two
   planes that are close, of slip along rakes, as a vector and with opening, with normal stress. To tolerances at which
   blocks have terms in both precisions. */
static void hierarchical(void **state)
{
  enum { nx = 40, nz = 15, n = 2 * nx * nz, mx = 12, mz = 6, m = 2 * mx * mz };
  static PetscReal far[5 * n], data[8 * m], halves[TRIANGLE_COLUMNS * 2 * m];
  const SlipKernelType *const types[] = {&SlipKernelTriangle, &SlipKernelTriangleVector, &SlipKernelTriangleOpening};
  SlipCells cells = TwoGradedFaults(nx, nz, 7, far), triangles;
  const SlipCells rectangles = TwoDippingPlanes(mx, mz, data);
  Mat S, Kn;

  NEEDS_DEVICE;
  for (PetscInt i = 0; i < n; i++) far[n + i] *= 40;
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "hmat", 1e-8, &S));
  Products("a hierarchical stiffness", S, NULL);
  ok(MatDestroy(&S));
  triangles = TrianglesOf(&rectangles, halves);
  for (int k = 0; k < 3; k++) {
    triangles.kernel.type = types[k];
    if (k == 0) {
      ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &triangles, "hmat", 1e-4, &S));
      ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, &triangles, "hmat", 1e-4, &Kn));
    } else
      ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &triangles, "hmat", 1e-6, &S, &Kn));
    if (k < 2)
      Products("hierarchical normal stress", Kn, NULL);
    else
      Products("normal stress of cells that open", Kn, NULL);
    Products("a hierarchical stiffness of triangles", S, NULL);
    Both(S, Kn);
    ObjectsDestroy(&S, &Kn);
  }
}

/* Of all cells the same, of each its own by its area, and of opening another one */
static void radiation(void **state)
{
  static PetscReal data[8 * 24];
  SlipCells cells = TwoDippingPlanes(4, 3, data);

  NEEDS_DEVICE;
  for (int weighted = 0; weighted < 2; weighted++) {
    Mat K, H;

    for (PetscInt i = 0; i < cells.n && weighted; i++) data[4 * cells.n + i] *= 1 - 0.02 * (double)(i % 3);
    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-6, &K));
    ok(MatCreateSlipRadiation(K, 4.5e6, &H));
    Products("radiation damping", H, NULL);
    ObjectsDestroy(&K, &H);
  }
}

/* What a device has no product for */
static void refused(void **state)
{
  Mat A;

  NEEDS_DEVICE;
  ok(MatCreateSeqAIJ(PETSC_COMM_SELF, 3, 3, 1, NULL, &A));
  fails(SlipMatUseDevice(A), "products with a matrix of type seqaij are not formed on a device");
  ok(MatDestroy(&A));
}

/* What does not fit is refused before anything is put there, and goes on with the processor. Arrays that nobody touches
   take the memory. */
static void memory(void **state)
{
  enum { nx = 20, nz = 15, n = 2 * nx * nz, MOST = 64 };
  static PetscReal data[5 * n];
  const SlipCells cells = TwoGradedFaults(nx, nz, 7, data);
  SlipDeviceMemory taken[MOST] = {NULL};
  const size_t left = 100000;
  size_t room = 0, first;
  PetscInt64 before;
  PetscReal bytes;
  Mat S, D;
  Vec u;

  NEEDS_DEVICE;
  if (SlipDeviceShares(device)) skip();
  for (size_t step = (size_t)1 << 45; step; step /= 2)
    if (!SlipDeviceReserve(device, room + step, "a test")) room += step;
  first = room / 8;
  for (int k = 0; k < MOST && room > left; k++) {
    const size_t piece = PetscMin(first, room - left);

    if (SlipDeviceAllocate(device, piece, "a test", &taken[k])) break; /* more than arrays may have */
    room -= piece;
  }
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "hmat", 1e-8, &S));
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-8, &D));
  ok(SlipMatDeviceBytes(S, &bytes));
  before = SlipDeviceGetTraffic().bytes;
  if (room <= left) {
    fails(SlipMatUseDevice(S), "products need ");
    fails(SlipMatUseDevice(D), "MB more: expected fewer cells, or another device (-fault_device_name)");
    assert_true(SlipDeviceGetTraffic().bytes == before);
    ok(MatCreateVecs(S, &u, NULL));
    assert_false(SlipDeviceVecIs(u));
    ok(VecDestroy(&u));
  }
  for (int k = 0; k < MOST; k++)
    if (taken[k]) ok(SlipDeviceFree(device, &taken[k]));
  assert_true(bytes > left);
  Products("a stiffness that there is room for now", S, NULL);
  ObjectsDestroy(&S, &D);
}

static int setup(void **state)
{
  ok(SlipDeviceRegisterVec());
  if (SlipDeviceOpen(PETSC_COMM_SELF, "-test_device", "", &device)) {
    device = NULL;
    print_message("skipped: %s\n", message);
    return strstr(message, "there is no device") || !SlipDeviceBuiltIn() ? 0 : 1;
  }
  return 0;
}

SLIP_TESTS_WITH(setup, NULL, grids, dipping, dense, opening, hierarchical, radiation, refused, memory)
