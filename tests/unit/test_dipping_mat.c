/* Operators of dipping planes: against the vertical ones, against each other, and turned. */
#include "cells.h"
#include "operators.h"
#include <math.h>

#define NX 9
#define NZ 8
#define N (NX * NZ)

static const SlipKernel Rock = {&SlipKernelDipping, 30e9, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL};

static SlipDippingGrid Grid(PetscReal dip, const PetscReal rake[])
{
  return (SlipDippingGrid){.grid = {NX, NZ, 900, 640, 100, Rock}, .dip = dip, .rake = rake};
}

/* Dip 90 and rake 0 are the vertical plane, whose normal stress slip does not change; 1e-11: both kernels lose some
   digits of 1e-16 between corners, ten cells away. */
static void vertical_is_the_limit(void **state)
{
  PetscReal rake[N] = {0};
  SlipDippingGrid dipping = Grid(90, rake);
  SlipGrid vertical = dipping.grid;
  Mat K, Kn, old;

  vertical.kernel.type = &SlipKernelStrikeSlip;
  ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &dipping, "dense", &K, &Kn));
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &vertical, "dense", &old));
  assert_true(LargestDifference(K, old) < 1e-11 * LargestDifference(old, NULL));
  assert_true(LargestDifference(Kn, NULL) < 1e-11 * LargestDifference(old, NULL));
  ObjectsDestroy(&K, &Kn, &old);
}

/* Reciprocity: what the centres' stresses lack of symmetry is the error of taking them there, and goes with the cells'
   size. With rakes that vary, shear is taken along the receiver's. */
static void stiffness_is_nearly_symmetric(void **state)
{
  const SlipCell a = {.rectangle = {3000, 200, 2500, 100, 80, 20, 35}, .rake = 70},
                 b = {.rectangle = {1800, -900, 1500, 100, 80, 140, 60}, .rake = -20};
  const SlipCell near = {.rectangle = {3000, 200, 2500, 50, 40, 20, 35}, .rake = 70},
                 other = {.rectangle = {1800, -900, 1500, 50, 40, 140, 60}, .rake = -20};
  PetscReal ab[2], ba[2], fine[2][2];

  SlipKernelBlock(&Rock, &a, &b, ab);
  SlipKernelBlock(&Rock, &b, &a, ba);
  SlipKernelBlock(&Rock, &near, &other, fine[0]);
  SlipKernelBlock(&Rock, &other, &near, fine[1]);
  /* (side/distance)^2/24 of what falls with the third power of the distance, 12 times that at most, of G A/(4 pi d^3);
     on cells of half the size a quarter of that */
  assert_true(PetscAbsReal(ab[0] - ba[0]) < 0.5 * PetscSqr(100. / 1911) * 30e9 * 8000 / (4 * PETSC_PI * pow(1911, 3)));
  assert_true(PetscAbsReal(fine[0][0] - fine[1][0]) / 2000 < 0.3 * PetscAbsReal(ab[0] - ba[0]) / 8000);
}

/* Of cells of one plane, whose directions are kept from one to the next, and of others; of numbers that no vector is
   full of */
static void pairs_at_once(void **state)
{
  enum { pairs = 53 };
  SlipCell receiver[pairs], source[pairs];

  for (int space = 0; space < 2; space++) {
    SlipKernel kernel = Rock;

    kernel.full_space = (PetscBool)space;
    for (int k = 0; k < pairs; k++) {
      const PetscReal turn = k > 20 ? 7.0 * k : 30, other = k > 35 ? -50 + k : 20;

      receiver[k] =
        (SlipCell){.rectangle = {100.0 * k, 300, 2000 + 10 * k, 100, 80, turn, 20 + k}, .rake = k < 9 ? 90 : 10.0 * k};
      source[k] = (SlipCell){.rectangle = {500, 70.0 * k, 900, 100 + k, 120, other, k > 40 ? 90 : 35},
                             .rake = k > 30 ? 3.0 * k : 60};
    }
    receiver[17] = source[17]; /* a cell on itself */
    AssertPairsAtOnce(&kernel, pairs, receiver, source);
  }
}

/* The same problem turned about the vertical and moved, 1e-11 of the largest entry: coordinates of 1e5 m round to 1e-11
   m */
static void turned_problems_have_the_same_operators(void **state)
{
  const PetscReal turn = 37.3, c = PetscCosReal(turn * PETSC_PI / 180), s = PetscSinReal(turn * PETSC_PI / 180);
  static PetscReal column[2][8][2 * N];
  SlipCells cells[2];
  Mat K[2], Kn[2];

  for (PetscInt e = 0; e < 2 * N; e++) {
    const PetscReal down = 80 * ((e % N) / NX + 0.5), along = 100 * (e % NX), dip = e < N ? 50 : 70;
    const PetscReal angle = dip * PETSC_PI / 180,
                    across = down * PetscCosReal(angle) * (e < N ? 1 : -1) + (e < N ? 0 : 700);
    const PetscReal cell[8] = {
      e < N ? along : 800 - along, across, 50 + down * PetscSinReal(angle), 100, 80, e < N ? 0 : 180, dip,
      e < N ? 90 - e : -90};

    for (int k = 0; k < 8; k++) column[0][k][e] = column[1][k][e] = cell[k];
    column[1][0][e] = c * cell[0] - s * cell[1] + 5000;
    column[1][1][e] = s * cell[0] + c * cell[1] - 3000;
    column[1][5][e] += turn;
  }
  for (int t = 0; t < 2; t++) {
    cells[t] = DippingCellsOfColumns(2 * N, column[t][0]);
    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells[t], "dense", 1e-8, &K[t]));
    ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, &cells[t], "dense", 1e-8, &Kn[t]));
  }
  assert_true(LargestDifference(K[0], K[1]) < 1e-11 * LargestDifference(K[0], NULL));
  assert_true(LargestDifference(Kn[0], Kn[1]) < 1e-11 * LargestDifference(K[0], NULL));
  for (int t = 0; t < 2; t++) ObjectsDestroy(&K[t], &Kn[t]);
}

/* Products of hierarchical storage of the tolerance 1e-8 by default; share: what it may take of a dense matrix */
static void Hierarchical(const SlipDippingGrid *grid, PetscReal share)
{
  const PetscInt n = grid->grid.nx * grid->grid.nz;
  PetscReal most, all;
  Mat K[2], Kn[2];

  for (int t = 0; t < 2; t++) ok(CreateOfGrid(grid, t ? "hmat" : "dense", &K[t], &Kn[t]));
  AssertHierarchical(K, Kn, grid->tolerance != 0 ? grid->tolerance : (PetscReal)1e-8);
  ok(MatSlipGetMemory(K[1], &most, &all));
  assert_true(all < share * (PetscReal)sizeof(PetscReal) * (PetscReal)n * (PetscReal)n);
  ObjectsDestroy(&K[0], &K[1], &Kn[0], &Kn[1]);
}

/* A plane with rakes that vary, and a fault in plane strain: one column of cells 1e7 m long, which are far from each
   other all the same. Half of K is kept anyway. */
static void hierarchical_is_dense(void **state)
{
  enum { nx = 24, nz = 20, line = 400 };
  static PetscReal rake[nx * nz];
  const SlipDippingGrid plane = {.grid = {nx, nz, 2400, 1600, 0, Rock}, .dip = 25, .rake = rake};
  const SlipDippingGrid loose = {.grid = plane.grid, .dip = 25, .rake = rake, .tolerance = 1e-3};
  const SlipDippingGrid strain = {.grid = {1, line, 1e7, 40e3, 0, Rock}, .dip = 60, .rake = rake};

  for (PetscInt e = 0; e < nx * nz; e++) rake[e] = 60 + 0.1 * e;
  Hierarchical(&plane, 0.6);
  Hierarchical(&loose, 0.4); /* 0.34 with 1e-3, 0.52 with 1e-8 */
  for (PetscInt e = 0; e < line; e++) rake[e] = 90;
  Hierarchical(&strain, 0.25);
}

/* What products by transforms rest on: along strike, stress on the plane is even or odd, to 1e-13 of the stress at the
   centre, as corners of either sign differ by rounding of 1e-16 and cancel ten cells away, where they are 100 times
   their sum. */
static void stress_is_even_or_odd_along_strike(void **state)
{
  const PetscReal even[2][3] = {{1, -1, -1}, {-1, 1, 1}};
  const SlipDippingRectangle source = {0, 0, 300, 100, 80, 0, 35};
  PetscReal points[2][3], traction[2][3], own[3];

  for (PetscInt slip = 0; slip < 2; slip++) {
    ok(SlipKernelDipping.plane(&Rock, &source, slip, 1, &source.x, own));
    for (PetscInt d = 1; d < 10; d++)
      for (PetscInt row = -3; row < 4; row++) {
        for (int side = 0; side < 2; side++) {
          points[side][0] = side ? -100 * d : 100 * d;
          points[side][1] = 80 * row * PetscCosReal(35 * PETSC_PI / 180);
          points[side][2] = 300 + 80 * row * PetscSinReal(35 * PETSC_PI / 180);
        }
        ok(SlipKernelDipping.plane(&Rock, &source, slip, 2, points[0], traction[0]));
        for (int c = 0; c < 3; c++)
          AssertNear(traction[1][c], even[slip][c] * traction[0][c], 1e-13 * PetscAbsReal(own[slip]));
      }
  }
}

static void CompareTypes(PetscInt nx, PetscInt nz, const PetscReal rake[])
{
  SlipDippingGrid grid = {.grid = {nx, nz, 100 * nx, 80 * nz, 50, Rock}, .dip = 40, .rake = rake};

  AssertTransforms(&grid);
  grid.grid.kernel.full_space = PETSC_TRUE; /* where K alone has transforms in depth */
  AssertTransforms(&grid);
}

/* Sizes with a middle and without, one column and one row, rows that vectors of eight take and leave over; rakes that
   need one component of slip, in both directions, and two */
static void transforms_are_dense(void **state)
{
  const PetscInt sizes[][2] = {{NX, NZ}, {10, 5}, {1, 13}, {12, 1}, {1, 1}, {2, 17}};
  const PetscReal uniform[] = {0, 90, 37, 180, -90};
  PetscReal rake[N];

  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(sizes); s++) {
    for (size_t r = 0; r < PETSC_STATIC_ARRAY_LENGTH(uniform); r++) {
      for (PetscInt e = 0; e < N; e++) rake[e] = uniform[r];
      CompareTypes(sizes[s][0], sizes[s][1], rake);
    }
    for (PetscInt e = 0; e < N; e++) rake[e] = e % 3 ? 90 : -90;
    CompareTypes(sizes[s][0], sizes[s][1], rake);
    for (PetscInt e = 0; e < N; e++) rake[e] = 17 * e - 300;
    CompareTypes(sizes[s][0], sizes[s][1], rake);
  }
}

/* f and n are scale[0] K u and scale[1] Kn u, to 1e-12 of the former's size as above */
static void AssertBoth(Mat K, Mat Kn, Mat dense[2], const PetscReal scale[2])
{
  PetscReal distance, size;
  Vec u, f[2], n[2];

  ok(MatCreateVecs(K, &u, &f[0]));
  VecsDuplicate(u, &f[1], &n[0], &n[1]);
  ok(VecFillSines(u));
  ok(MatMult(dense[0], u, f[0]));
  ok(MatMult(dense[1], u, n[0]));
  ok(VecNorm(f[0], NORM_INFINITY, &size));
  ok(MatSlipStiffnessMultBoth(K, Kn, u, f[1], n[1]));
  ok(VecAXPY(f[1], -scale[0], f[0]));
  ok(VecAXPY(n[1], -scale[1], n[0]));
  ok(VecNorm(f[1], NORM_INFINITY, &distance));
  assert_true(distance < 1e-12 * size);
  ok(VecNorm(n[1], NORM_INFINITY, &distance));
  assert_true(distance < 1e-12 * size);
  ObjectsDestroy(&u, &f[0], &f[1], &n[0], &n[1]);
}

/* Both products at once share transforms with the K of the same call and with no other; each has its own factor, and
   either can be destroyed first. */
static void both_at_once(void **state)
{
  const PetscReal one[2] = {1, 1}, scaled[2] = {0.5, -3}, half[2] = {1, -3};
  PetscReal rake[N];
  Mat K[3], Kn[3], dense[2];
  Vec x, y;

  for (int general = 0; general < 2; general++) {
    for (PetscInt e = 0; e < N; e++) rake[e] = general ? 5 * e : 90;
    SlipDippingGrid grid = Grid(30, rake);

    ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "dense", &dense[0], &dense[1]));
    for (int t = 0; t < 2; t++) ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "fft", &K[t], &Kn[t]));
    AssertBoth(K[0], Kn[0], dense, one);
    ok(MatScale(K[0], 0.5));
    ok(MatScale(Kn[0], -3));
    AssertBoth(K[0], Kn[0], dense, scaled);
    AssertBoth(K[1], Kn[0], dense, half);     /* another of its kind */
    AssertBoth(dense[0], Kn[0], dense, half); /* and of another */
    ok(MatDestroy(&K[0]));
    AssertBoth(K[1], Kn[0], dense, half);
    ok(MatDestroy(&Kn[1]));
    ok(MatCreateVecs(K[1], &x, &y));
    ok(VecSet(x, 1));
    ok(MatMult(K[1], x, y));
    ObjectsDestroy(&x, &y, &K[1], &Kn[0], &dense[0], &dense[1]);
  }
}

/* Blocks of as many numbers as the file says: K's halves of [n nz][n nz], columns from the first row of their eight on,
   and Kn's [n nz][nz], for period / 2 + 1 wavenumbers. And Kn is not taken for symmetric. */
static void storage_of_transforms(void **state)
{
  PetscReal rake[N], most, all[2][2];
  PetscBool known, symmetric;
  Mat K, Kn;

  for (int general = 0; general < 2; general++) {
    for (PetscInt e = 0; e < N; e++) rake[e] = general ? 5 * e : 0;
    SlipDippingGrid grid = Grid(30, rake);

    ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "fft", &K, &Kn));
    ok(MatSlipGetMemory(K, &most, &all[general][0]));
    ok(MatSlipGetMemory(Kn, &most, &all[general][1]));
    ok(MatIsSymmetricKnown(Kn, &known, &symmetric));
    assert_true(known && !symmetric);
    ok(MatIsSymmetricKnown(K, &known, &symmetric));
    assert_true(known && symmetric);
    ObjectsDestroy(&K, &Kn);
  }
  /* 18 cells with padding are 10 wavenumbers; NZ = 8: halves of 16 columns take 8 * 16 + 8 * 8, of 8 all 64, and waves
     2 NZ */
  AssertNear((all[1][1] - all[0][1]) / sizeof(PetscReal), 10 * NZ * NZ, 0);
  AssertNear(all[0][1] / sizeof(PetscReal), 10 * (NZ * NZ + 2 * NZ), 0);
  AssertNear((all[1][0] - all[0][0]) / sizeof(PetscReal), 10 * (192 - 64 + 4 * NZ) + N, 0);
}

/* Plane strain: a cell 1e7 m long dips as an edge dislocation of the same half-space. The stress of a full space is
   G/(2 pi (1 - nu)) (1/(d - w/2) - 1/(d + w/2)) on the plane; far from the surface the image is below (w/depth)^2. */
static void long_cells_are_plane_strain(void **state)
{
  const PetscReal d = 1000, w = 100, nu = 0.25;
  const SlipCell source = {.rectangle = {0, 0, 1e6, 1e8, w, 0, 30}, .rake = 90};
  const SlipCell receiver = {.rectangle = {0, d * PetscCosReal(PETSC_PI / 6), 1e6 + 0.5 * d, 1e8, w, 0, 30},
                             .rake = 90};
  const PetscReal expected = 30e9 / (2 * PETSC_PI * (1 - nu)) * (1 / (d + w / 2) - 1 / (d - w / 2));
  SlipKernel full = Rock;
  PetscReal block[2];

  full.full_space = PETSC_TRUE;
  SlipKernelBlock(&full, &receiver, &source, block);
  AssertNear(block[0], expected, 1e-6 * PetscAbsReal(expected)); /* (d/length)^2, and corners of 1e8 m: 1e-16 1e8/w */
  assert_true(PetscAbsReal(block[1]) < 1e-6 * PetscAbsReal(expected));
}

static void what_is_refused(void **state)
{
  PetscReal rake[N] = {0};
  SlipDippingGrid grid = Grid(95, rake);
  const SlipKernelType slow = {.name = "slow", .components = 1, .normals = 1, .centre = SlipKernelDipping.centre};
  Mat K;

  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "dense", &K, NULL),
        "Dip must lie in (0, 90] degrees, not 95");
  grid.dip = 40;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "bad", &K, NULL), "known: dense, hmat, fft, auto");
  grid.grid.depth_top = -100;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "dense", &K, NULL), "reaches above the surface");
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "fft", &K, NULL), "reaches above the surface");
  grid = Grid(40, rake);
  grid.grid.kernel.type = &slow;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "fft", &K, NULL), "Kernel \"slow\" has no stress on a");
  grid.grid.nz = 0;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "fft", &K, NULL), "at least one cell each way");
}

/* "auto": up to 256 cells, deeper than 50 times as many cells as along strike, the rest, and that by a kernel without
   plane() */
static void auto_chooses(void **state)
{
  static PetscReal rake[17 * 17];
  const SlipKernelType slow = {.name = "slow", .components = 1, .normals = 1, .centre = SlipKernelDipping.centre};
  const struct {
    PetscInt nx, nz;
    const SlipKernelType *kernel;
    const char *type;
  } cases[] = {{16, 16, &SlipKernelDipping, MATSEQDENSE},
               {2, 140, &SlipKernelDipping, "sliphmat"},
               {17, 17, &SlipKernelDipping, "slipdippingfft"},
               {17, 17, &slow, "sliphmat"}};
  PetscBool same;
  Mat K;

  for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(cases); c++) {
    SlipDippingGrid grid = {.grid = {cases[c].nx, cases[c].nz, 1600, 1600, 0, Rock}, .dip = 40, .rake = rake};

    grid.grid.kernel.type = cases[c].kernel;
    ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "auto", &K, NULL));
    ok(PetscObjectTypeCompare((PetscObject)K, cases[c].type, &same));
    assert_true(same);
    ok(MatDestroy(&K));
  }
}

SLIP_TESTS(vertical_is_the_limit, pairs_at_once, stiffness_is_nearly_symmetric, turned_problems_have_the_same_operators,
           hierarchical_is_dense, stress_is_even_or_odd_along_strike, transforms_are_dense, both_at_once,
           storage_of_transforms, long_cells_are_plane_strain, what_is_refused, auto_chooses)
