/* Operators of slip as a vector in each cell's plane: their storage, hierarchical and by transforms against dense, and
   what is refused. */
#include "vectorcells.h"
#include "operators.h"

/* Symmetric to the bit, known to be positive, of the sizes that were promised, with weights twice each */
static void matrices(void **state)
{
  SlipCells vectors[2], scalars[2];
  PetscInt m, n;
  PetscBool is, set, positive;
  const PetscScalar *w, *v;
  Vec weights, scalar, u;
  Mat S, Kn, K;

  Meshes(vectors, scalars);
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[1], "dense", 1e-6, &S, &Kn));
  ok(MatIsSymmetric(S, 0, &is));
  assert_true(is);
  ok(MatIsSymmetricKnown(S, &set, &is));
  ok(MatIsSPDKnown(S, &set, &positive));
  assert_true(is && positive);
  ok(MatGetSize(Kn, &m, &n));
  assert_true(m == T && n == 2 * T);
  ok(MatCreateVecs(Kn, &u, NULL));
  ok(VecGetSize(u, &n));
  assert_int_equal(n, 2 * T);
  ok(VecDestroy(&u));
  ok(MatSlipGetWeights(S, &weights));
  assert_null(weights); /* of one area */
  ObjectsDestroy(&S, &Kn);
  for (PetscInt e = 0; e < N; e++) rectangle_data[4 * N + e] = 70 + (PetscReal)(e / NX % NZ);
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[0], "dense", 1e-6, &S, NULL));
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &scalars[0], "dense", 1e-6, &K));
  ok(MatIsSymmetric(S, 0, &is));
  assert_true(is);
  ok(MatSlipGetWeights(S, &weights));
  ok(MatSlipGetWeights(K, &scalar));
  ok(VecGetSize(weights, &n));
  assert_int_equal(n, 2 * N);
  w = VecRead(weights);
  v = VecRead(scalar);
  for (PetscInt i = 0; i < 2 * N; i++) assert_true(w[i] == v[i / 2]);
  ObjectsDestroy(&S, &K);
}

/* Hierarchical storage against dense: its size, products, and the diagonal, with a scale too */
static void hierarchical(void **state)
{
  enum { nx = 16, nz = 8, n = 2 * nx * nz };
  static PetscReal data[8 * n], halves[TRIANGLE_COLUMNS * 2 * n];
  const SlipCells rectangles = TwoDippingPlanes(nx, nz, data), triangles = TrianglesOf(&rectangles, halves);

  for (int k = 0; k < 2; k++) {
    SlipCells c = k ? triangles : rectangles;
    Mat S[2], Kn[2];
    Vec d[2];
    MatInfo info;

    c.kernel.type = k ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
    for (int t = 0; t < 2; t++)
      ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", 1e-6, &S[t], &Kn[t]));
    ok(MatGetInfo(S[1], MAT_LOCAL, &info));
    assert_true(info.memory < (k ? 0.5 : 0.6) * 8 * PetscSqr(2 * c.n));
    ok(MatGetInfo(Kn[1], MAT_LOCAL, &info));
    assert_true(info.memory < (k ? 0.85 : 1) * 8 * 2 * PetscSqr(c.n));
    AssertHierarchical(S, Kn, 1e-6);
    ok(MatCreateVecs(S[0], &d[0], &d[1]));
    for (int t = 0; t < 2; t++) {
      ok(MatScale(S[t], 3));
      ok(MatGetDiagonal(S[t], d[t]));
    }
    AssertVecClose(d[1], d[0], NORM_2, 1e-13);
    for (int t = 0; t < 2; t++) ObjectsDestroy(&S[t], &Kn[t], &d[t]);
  }
}

/* Of two groups of cells far from each other a block of low rank holds what the one does to the other, a millionth of
   what cells do to themselves: off by at most the tolerance of its own norm, and the traction by uniform slip along
   either component by ten times that of its own, although it is small beside that of random slip in the same norm;
   compression too, and in either direction. */
static void blocks_to_their_own_tolerance(void **state)
{
  enum { nx = 8, nz = 5, half = nx * nz, n = 2 * half };
  static PetscReal data[8 * n];
  const PetscReal tolerance = 1e-5;
  SlipCells c = TwoDippingPlanes(nx, nz, data);
  const PetscScalar *a[2];
  Mat A[2][2];

  for (PetscInt e = half; e < n; e++) data[e] += 5000;
  c.kernel.type = &SlipKernelDippingVector;
  for (int t = 0; t < 2; t++) {
    ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", tolerance, &A[0][t], &A[1][t]));
    for (int m = 0; m < 2 && t; m++) ok(MatConvert(A[m][t], MATDENSE, MAT_INPLACE_MATRIX, &A[m][t]));
  }
  for (int m = 0; m < 2; m++) {
    const PetscInt rows = m ? 1 : 2;

    for (int t = 0; t < 2; t++) a[t] = MatRead(A[m][t]);
    for (PetscInt to = 0; to < n; to += half) {
      const PetscInt from = half - to;
      PetscReal error[3] = {0}, size[3] = {0}; /* of entries, and of both uniform slips */

      for (PetscInt i = rows * to; i < rows * (to + half); i++) {
        PetscReal sum[2][2] = {{0}};

        for (PetscInt j = 2 * from; j < 2 * (from + half); j++) {
          const PetscInt at = j * rows * n + i;

          error[2] += PetscSqr(a[1][at] - a[0][at]);
          size[2] += PetscSqr(a[0][at]);
          for (int t = 0; t < 2; t++) sum[t][j % 2] += a[t][at];
        }
        for (int k = 0; k < 2; k++) {
          error[k] += PetscSqr(sum[1][k] - sum[0][k]);
          size[k] += PetscSqr(sum[0][k]);
        }
      }
      assert_true(error[2] > 0 && error[2] <= PetscSqr(tolerance) * size[2]);
      for (int k = 0; k < 2; k++) assert_true(error[k] <= PetscSqr(10 * tolerance) * size[k]);
    }
    for (int t = 0; t < 2; t++) ok(MatDestroy(&A[m][t]));
  }
}

/* Sizes with a middle and without, one column and one row; vertical planes too; below the ground, and in a full space,
   where K alone has transforms in depth; with opening */
static void transforms(void **state)
{
  const PetscInt sizes[][2] = {{9, 8}, {10, 5}, {1, 13}, {12, 1}, {1, 1}, {2, 17}};
  SlipCells vectors[2], scalars[2];

  Meshes(vectors, scalars);
  for (size_t s = 0; s < 8 * PETSC_STATIC_ARRAY_LENGTH(sizes); s++) {
    const PetscInt nx = sizes[s / 8][0], nz = sizes[s / 8][1];
    SlipDippingGrid grid = {.grid = {nx, nz, 100 * nx, 80 * nz, s % 3 ? 50 : 0, vectors[0].kernel},
                            .dip = s % 2 ? 90 : 40};

    grid.grid.kernel.full_space = (PetscBool)(s / 2 % 2);
    if (s / 4 % 2) grid.grid.kernel.type = &SlipKernelDippingOpening;
    AssertTransforms(&grid);
  }
}

/* P' S P and Kn P of a grid by transforms are its matrices of slip along rakes, each cell its own, of both types; along
   strike and on a vertical plane those of MatCreateSlipStiffness(), whose closed form is another. 1e-11: transforms,
   and forms that cancel ten cells away. */
static void grids_project(void **state)
{
  enum { nx = 9, nz = 8, n = nx * nz };
  static PetscReal rake[n];
  SlipCells vectors[2], scalars[2];

  Meshes(vectors, scalars);
  for (int which = 0; which < 3; which++) {
    SlipDippingGrid grid = {.grid = {nx, nz, 900, 640, 0, vectors[0].kernel}, .dip = which ? 90 : 40, .rake = rake};
    Mat A[2], B[2];

    for (PetscInt e = 0; e < n; e++) rake[e] = which == 2 ? 0 : 17.0 * (PetscReal)e - 300;
    ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "fft", &A[0], &B[0]));
    grid.grid.kernel.type = which == 2 ? &SlipKernelStrikeSlip : &SlipKernelDipping;
    if (which == 2) {
      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid.grid, "dense", &A[1]));
      ok(MatCreateDense(PETSC_COMM_SELF, n, n, n, n, NULL, &B[1]));
      ok(MatZeroEntries(B[1])); /* slip along strike does nothing to it */
    } else
      ok(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "fft", &A[1], &B[1]));
    for (int t = 0; t < 2; t++) {
      ok(MatConvert(A[t], MATDENSE, MAT_INPLACE_MATRIX, &A[t]));
      ok(MatConvert(B[t], MATDENSE, MAT_INPLACE_MATRIX, &B[t]));
    }
    assert_true(ProjectedDifference(A, B, rake) < 1e-11);
    for (int t = 0; t < 2; t++) ObjectsDestroy(&A[t], &B[t]);
  }
}

/* "auto" by the size of a grid and of a mesh */
static void chosen(void **state)
{
  const struct {
    PetscInt nx, nz;
    const char *type;
  } cases[] = {{16, 16, MATSEQDENSE}, {2, 140, "sliphmat"}, {17, 17, "slipdippingfft"}};
  SlipCells vectors[2], scalars[2];
  PetscBool match;
  Mat S;

  Meshes(vectors, scalars);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(cases); k++) {
    const SlipDippingGrid grid = {
      .grid = {cases[k].nx, cases[k].nz, 100 * cases[k].nx, 80 * cases[k].nz, 50, vectors[0].kernel}, .dip = 60};

    ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "auto", &S, NULL));
    ok(PetscObjectTypeCompare((PetscObject)S, cases[k].type, &match));
    assert_true(match);
    ok(MatDestroy(&S));
  }
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[1], "auto", 1e-4, &S, NULL));
  ok(PetscObjectTypeCompare((PetscObject)S, MATSEQDENSE, &match));
  assert_true(match);
  ok(MatDestroy(&S));
}

static void refused(void **state)
{
  const SlipKernelType four = {.name = "four", .components = 4, .centre = SlipKernelDipping.centre};
  const SlipKernelType shear = {.name = "shear", .components = 2, .centre = SlipKernelDippingVector.centre};
  PetscReal rake[12] = {0};
  SlipDippingGrid grid = {.grid = {4, 3, 400, 300, 0}, .dip = 50, .rake = rake};
  SlipCells vectors[2], scalars[2];
  Mat A = NULL, B = NULL;

  Meshes(vectors, scalars);
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &scalars[0], "dense", 1e-6, &A, &B),
        "\"dipping\" has 1 components of slip, expected 2");
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &scalars[1], "hmat", 1e-6, &A, NULL),
        "\"triangle\" has 1 components of slip, expected 2");
  fails(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &vectors[0], "dense", 1e-6, &A),
        "\"dipping_vector\" has 2 components of slip, expected 1");
  fails(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, &vectors[1], "hmat", 1e-6, &A),
        "\"triangle_vector\" has 2 components of slip, expected 1");
  grid.grid.kernel = scalars[0].kernel;
  fails(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "dense", &A, &B),
        "\"dipping\" has 1 components of slip, expected 2");
  grid.grid.kernel = vectors[0].kernel;
  fails(MatCreateSlipDippingStiffness(PETSC_COMM_SELF, &grid, "dense", &A, &B),
        "\"dipping_vector\" has 2 components of slip, expected 1");
  fails(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "sparse", &A, &B), "\"sparse\"");
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[1], "fft", 1e-6, &A, &B), "\"fft\"");
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[1], "hmat", 2, &A, &B), "in (0, 1), not 2");
  vectors[0].kernel.average = SLIP_AVERAGE_CELL;
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[0], "dense", 1e-6, &A, &B),
        "\"dipping_vector\" knows no average");
  vectors[0].kernel.average = SLIP_AVERAGE_CENTRE;
  vectors[0].kernel.type = &four;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &vectors[0], "test"), "4 components of slip and 0 rows");
  vectors[0].kernel.type = &shear;
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[0], "dense", 1e-6, &A, &B),
        "\"shear\" has no row of normal stress");
  vectors[0].kernel.type = &SlipKernelTriangleVector;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &vectors[0], "test"), "kernel \"triangle_vector\" with rectangles");
  vectors[1].kernel.type = &SlipKernelDippingVector;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &vectors[1], "test"), "kernel \"dipping_vector\" with triangles");
}

SLIP_TESTS(matrices, hierarchical, blocks_to_their_own_tolerance, transforms, grids_project, chosen, refused)
