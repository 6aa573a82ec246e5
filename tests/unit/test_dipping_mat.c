/* Operators of dipping planes: against the vertical ones, against each other, and turned. */
#include "unit.h"
#include "products.h"
#include <math.h>

#define NX 9
#define NZ 8
#define N (NX * NZ)

static const SlipKernel Rock = {&SlipKernelDipping, 30e9, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL};

static SlipDippingGrid Grid(PetscReal dip, const PetscReal rake[])
{
  return (SlipDippingGrid){.grid = {NX, NZ, 900, 640, 100, Rock}, .dip = dip, .rake = rake};
}

static PetscReal LargestOf(Mat A)
{
  PetscReal norm;

  ok(MatNorm(A, NORM_INFINITY, &norm));
  return norm / N;
}

/* The difference of two dense matrices over the mean entry of a */
static PetscReal Differ(Mat a, Mat b, PetscReal scale)
{
  PetscReal norm;
  Mat d;

  ok(MatDuplicate(a, MAT_COPY_VALUES, &d));
  ok(MatAXPY(d, -1, b, SAME_NONZERO_PATTERN));
  norm = LargestOf(d) / scale;
  ok(MatDestroy(&d));
  return norm;
}

/* Dip 90 and rake 0 are the vertical plane, whose normal stress slip does not change; 1e-11: both kernels lose some digits of
   1e-16 between corners, ten cells away. */
static void vertical_is_the_limit(void **state)
{
  PetscReal rake[N] = {0};
  SlipDippingGrid dipping = Grid(90, rake);
  SlipGrid vertical = dipping.grid;
  Mat K, Kn, old;

  (void)state;
  vertical.kernel.type = &SlipKernelStrikeSlip;
  ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &dipping, "dense", &K, &Kn));
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &vertical, "dense", &old));
  assert_true(Differ(K, old, LargestOf(old)) < 1e-11);
  assert_true(LargestOf(Kn) < 1e-11 * LargestOf(old));
  ok(MatDestroy(&K));
  ok(MatDestroy(&Kn));
  ok(MatDestroy(&old));
}

/* Reciprocity: what the centres' stresses lack of symmetry is the error of taking them there, and goes with the cells'
   size. With rakes that vary, shear is taken along the receiver's. */
static void stiffness_is_nearly_symmetric(void **state)
{
  const SlipCell a = {{3000, 200, 2500, 100, 80, 20, 35}, 70}, b = {{1800, -900, 1500, 100, 80, 140, 60}, -20};
  const SlipCell near = {{3000, 200, 2500, 50, 40, 20, 35}, 70}, other = {{1800, -900, 1500, 50, 40, 140, 60}, -20};
  PetscReal ab[2], ba[2], fine[2][2];

  (void)state;
  SlipKernelBlock(&Rock, &a, &b, ab);
  SlipKernelBlock(&Rock, &b, &a, ba);
  SlipKernelBlock(&Rock, &near, &other, fine[0]);
  SlipKernelBlock(&Rock, &other, &near, fine[1]);
  /* (side/distance)^2/24 of what falls with the third power of the distance, 12 times that at most, of G A/(4 pi d^3); on
     cells of half the size a quarter of that */
  assert_true(PetscAbsReal(ab[0] - ba[0]) < 0.5 * PetscSqr(100. / 1911) * 30e9 * 8000 / (4 * PETSC_PI * pow(1911, 3)));
  assert_true(PetscAbsReal(fine[0][0] - fine[1][0]) / 2000 < 0.3 * PetscAbsReal(ab[0] - ba[0]) / 8000);
}

/* The same problem turned about the vertical and moved, 1e-11 of the largest entry: coordinates of 1e5 m round to 1e-11 m */
static void turned_problems_have_the_same_operators(void **state)
{
  const PetscReal turn = 37.3, c = PetscCosReal(turn * PETSC_PI / 180), s = PetscSinReal(turn * PETSC_PI / 180);
  static PetscReal column[2][8][2 * N];
  SlipCells cells[2];
  Mat K[2], Kn[2];

  (void)state;
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
    cells[t] = (SlipCells){2 * N,        column[t][0], column[t][1], column[t][2], column[t][3], column[t][4],
                           column[t][5], column[t][6], column[t][7], Rock,         NULL,         0,
                           NULL};
    ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells[t], "dense", 1e-8, &K[t]));
    ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, &cells[t], "dense", 1e-8, &Kn[t]));
  }
  assert_true(Differ(K[0], K[1], LargestOf(K[0])) < 1e-11);
  assert_true(Differ(Kn[0], Kn[1], LargestOf(K[0])) < 1e-11);
  for (int t = 0; t < 2; t++) {
    ok(MatDestroy(&K[t]));
    ok(MatDestroy(&Kn[t]));
  }
}

/* Products of hierarchical storage, of K and of Kn, which is not symmetric, and both at once, to ten times the tolerance of its blocks;
   share: what it may take of a dense matrix */
static void Hierarchical(const SlipDippingGrid *grid, PetscReal share)
{
  const PetscInt n = grid->grid.nx * grid->grid.nz;
  Mat K[2], Kn[2];
  Vec u, f[2], c[2];
  PetscReal distance, size, most, all;

  for (int t = 0; t < 2; t++)
    ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, grid, t ? "hmat" : "dense", &K[t], &Kn[t]));
  ok(MatCreateVecs(K[0], &u, &f[0]));
  ok(VecDuplicate(u, &f[1]));
  for (int t = 0; t < 2; t++) ok(VecDuplicate(u, &c[t]));
  for (int uniform = 0; uniform < 2; uniform++) {
    for (PetscInt i = 0; i < n; i++)
      ok(VecSetValue(u, i, uniform ? 1 : PetscSinReal(1 + 0.7 * i + 0.01 * i * i), INSERT_VALUES));
    ok(MatMult(K[0], u, f[0]));
    ok(MatMult(Kn[0], u, c[0]));
    ok(MatSlipStiffnessMultBoth(K[1], Kn[1], u, f[1], c[1]));
    ok(VecNorm(f[0], NORM_2, &size));
    ok(VecAXPY(f[1], -1, f[0]));
    ok(VecNorm(f[1], NORM_2, &distance));
    assert_true(distance < 1e-7 * size);
    ok(VecAXPY(c[1], -1, c[0]));
    ok(VecNorm(c[1], NORM_2, &distance));
    assert_true(distance < 1e-7 * size);
  }
  ok(MatSlipGetMemory(K[1], &most, &all));
  assert_true(all < share * (PetscReal)sizeof(PetscReal) * (PetscReal)n * (PetscReal)n);
  ObjectsDestroy(&u, &f[0], &f[1]);
  for (int t = 0; t < 2; t++) {
    ok(VecDestroy(&c[t]));
    ok(MatDestroy(&K[t]));
    ok(MatDestroy(&Kn[t]));
  }
}

/* A plane with rakes that vary, and a fault in plane strain: one column of cells 1e7 m long, which are far from each other all the
   same. Half of K is kept anyway. */
static void hierarchical_is_dense(void **state)
{
  enum { nx = 24, nz = 20, line = 400 };
  static PetscReal rake[nx * nz];
  const SlipDippingGrid plane = {.grid = {nx, nz, 2400, 1600, 0, Rock}, .dip = 25, .rake = rake};
  const SlipDippingGrid strain = {.grid = {1, line, 1e7, 40e3, 0, Rock}, .dip = 60, .rake = rake};

  (void)state;
  for (PetscInt e = 0; e < nx * nz; e++) rake[e] = 60 + 0.1 * e;
  Hierarchical(&plane, 0.6);
  for (PetscInt e = 0; e < line; e++) rake[e] = 90;
  Hierarchical(&strain, 0.25);
}

/* Plane strain: a cell 1e7 m long dips as an edge dislocation of the same half-space. The stress of a full space is
   G/(2 pi (1 - nu)) (1/(d - w/2) - 1/(d + w/2)) on the plane; far from the surface the image is below (w/depth)^2. */
static void long_cells_are_plane_strain(void **state)
{
  const PetscReal d = 1000, w = 100, nu = 0.25;
  const SlipCell source = {{0, 0, 1e6, 1e8, w, 0, 30}, 90};
  const SlipCell receiver = {{0, d * PetscCosReal(PETSC_PI / 6), 1e6 + 0.5 * d, 1e8, w, 0, 30}, 90};
  const PetscReal expected = 30e9 / (2 * PETSC_PI * (1 - nu)) * (1 / (d + w / 2) - 1 / (d - w / 2));
  SlipKernel full = Rock;
  PetscReal block[2];

  (void)state;
  full.full_space = PETSC_TRUE;
  SlipKernelBlock(&full, &receiver, &source, block);
  AssertNear(block[0], expected, 1e-6 * PetscAbsReal(expected)); /* (d/length)^2, and corners of 1e8 m: 1e-16 1e8/w */
  assert_true(PetscAbsReal(block[1]) < 1e-6 * PetscAbsReal(expected));
}

static void what_is_refused(void **state)
{
  PetscReal rake[N] = {0};
  SlipDippingGrid grid = Grid(95, rake);
  Mat K;

  (void)state;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "dense", &K, NULL),
        "Dip must lie in (0, 90] degrees, not 95");
  grid.dip = 40;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "bad", &K, NULL), "known: dense, hmat, auto");
  grid.grid.depth_top = -100;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "dense", &K, NULL), "reaches above the surface");
}

SLIP_TESTS(vertical_is_the_limit, stiffness_is_nearly_symmetric, turned_problems_have_the_same_operators,
           hierarchical_is_dense, long_cells_are_plane_strain, what_is_refused)
