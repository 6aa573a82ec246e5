/* Operators of slip as a vector in each cell's plane: their storage, hierarchical and by transforms against dense, and
   what is refused. */
#include "vectorcells.h"

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

/* Hierarchical storage against dense, of random and of uniform slip, along strike and up dip. Blocks are off by the
   tolerance in their own norm, and errors of some hundred blocks add up at random: ten times that of the product. There
   are blocks of low rank; both products at once are those one by one. */
static void hierarchical(void **state)
{
  enum { nx = 16, nz = 8, n = 2 * nx * nz };
  static PetscReal data[8 * n], halves[TRIANGLE_COLUMNS * 2 * n];
  const PetscReal tolerance = 1e-6;
  const SlipCells rectangles = TwoDippingPlanes(nx, nz, data), triangles = TrianglesOf(&rectangles, halves);

  for (int k = 0; k < 2; k++) {
    SlipCells c = k ? triangles : rectangles;
    PetscReal norm, error;
    Mat S[3], Kn[3];
    Vec u, f[2], p[2], d[2];
    MatInfo info;

    c.kernel.type = k ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
    for (int t = 0; t < 2; t++)
      ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", tolerance, &S[t], &Kn[t]));
    ok(MatGetInfo(S[1], MAT_LOCAL, &info));
    assert_true(info.memory < (k ? 0.5 : 0.6) * 8 * PetscSqr(2 * c.n));
    ok(MatGetInfo(Kn[1], MAT_LOCAL, &info));
    assert_true(info.memory < (k ? 0.85 : 1) * 8 * 2 * PetscSqr(c.n));
    ok(MatCreateVecs(S[0], &u, &f[0]));
    ok(MatCreateVecs(Kn[0], NULL, &p[0]));
    VecsDuplicate(f[0], &f[1], &d[0], &d[1]);
    ok(VecDuplicate(p[0], &p[1]));
    for (int slip = 0; slip < 3; slip++) {
      for (PetscInt i = 0; i < 2 * c.n; i++)
        ok(VecSetValue(u, i, slip == 2 ? PetscSinReal((PetscReal)(i * i)) : i % 2 == slip, INSERT_VALUES));
      for (int t = 0; t < 2; t++) ok(MatSlipStiffnessMultBoth(S[t], Kn[t], u, f[t], p[t]));
      ok(VecNorm(f[0], NORM_2, &norm));
      AssertVecNear(f[1], f[0], NORM_2, 10 * tolerance * norm);
      ok(VecNorm(p[0], NORM_2, &norm));
      ok(VecAXPY(p[1], -1, p[0]));
      ok(VecNorm(p[1], NORM_2, &error));
      assert_true(error > 0 && error < 10 * tolerance * norm);
    }
    for (int t = 0; t < 2; t++) {
      ok(MatScale(S[t], 3));
      ok(MatGetDiagonal(S[t], d[t]));
    }
    ok(VecNorm(d[0], NORM_2, &norm));
    AssertVecNear(d[1], d[0], NORM_2, 1e-13 * norm);
    for (int m = 0; m < 2; m++) {
      Mat *A = m ? Kn : S;

      ok(MatConvert(A[1], MATDENSE, MAT_INITIAL_MATRIX, &A[2]));
      ok(MatNorm(A[0], NORM_FROBENIUS, &norm));
      ok(MatAXPY(A[2], -1, A[0], SAME_NONZERO_PATTERN));
      ok(MatNorm(A[2], NORM_FROBENIUS, &error));
      assert_true(error < tolerance * norm); /* of blocks each, so of all */
      for (int t = 0; t < 3; t++) ok(MatDestroy(&A[t]));
    }
    ObjectsDestroy(&u, &f[0], &f[1], &p[0], &p[1], &d[0], &d[1]);
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
    for (int t = 0; t < 2; t++) {
      ok(MatDestroy(&A[m][t]));
    }
  }
}

/* The largest difference of two matrices of one size over the largest entry of size */
static PetscReal LargestDifference(Mat a, Mat b, Mat size)
{
  PetscReal difference, most;
  Mat d, e;

  ok(MatConvert(a, MATDENSE, MAT_INITIAL_MATRIX, &d));
  ok(MatConvert(b, MATDENSE, MAT_INITIAL_MATRIX, &e));
  ok(MatAXPY(d, -1, e, SAME_NONZERO_PATTERN));
  ok(MatDestroy(&e));
  ok(MatConvert(size, MATDENSE, MAT_INITIAL_MATRIX, &e));
  {
    const PetscScalar *p, *q;
    PetscInt m, n, all;

    ok(MatGetSize(d, &m, &n));
    ok(MatGetSize(e, &all, NULL));
    p = MatRead(d);
    q = MatRead(e);
    difference = most = 0;
    for (PetscInt i = 0; i < m * n; i++) difference = PetscMax(difference, PetscAbsScalar(p[i]));
    for (PetscInt i = 0; i < all * all; i++) most = PetscMax(most, PetscAbsScalar(q[i]));
  }
  ObjectsDestroy(&d, &e);
  return difference / most;
}

/* Products by transforms against dense: all entries, the diagonal, both at once with scales of their own, what is asked
   for without Kn, and either destroyed first. Sizes with a middle and without, one column and one row; vertical planes
   too. 1e-12 of the largest entry, as for slip along rakes (test_dipping_mat.c). */
static void transforms(void **state)
{
  const PetscInt sizes[][2] = {{9, 8}, {10, 5}, {1, 13}, {12, 1}, {1, 1}, {2, 17}};
  SlipCells vectors[2], scalars[2];

  Meshes(vectors, scalars);
  for (size_t s = 0; s < 2 * PETSC_STATIC_ARRAY_LENGTH(sizes); s++) {
    const PetscInt nx = sizes[s / 2][0], nz = sizes[s / 2][1];
    const SlipDippingGrid grid = {.grid = {nx, nz, 100 * nx, 80 * nz, s % 3 ? 50 : 0, vectors[0].kernel},
                                  .dip = s % 2 ? 90 : 40};
    Mat dense[2], fft[2], alone;
    PetscReal size;
    Vec u, f[2], n[2];

    ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "dense", &dense[0], &dense[1]));
    ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "fft", &fft[0], &fft[1]));
    ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "fft", &alone, NULL));
    for (int t = 0; t < 2; t++) assert_true(LargestDifference(fft[t], dense[t], dense[0]) < 1e-12);
    assert_true(LargestDifference(alone, dense[0], dense[0]) < 1e-12);
    ok(MatCreateVecs(dense[0], &u, &f[0]));
    ok(MatCreateVecs(dense[1], NULL, &n[0]));
    ok(VecDuplicate(f[0], &f[1]));
    ok(VecDuplicate(n[0], &n[1]));
    ok(MatGetDiagonal(dense[0], f[0]));
    ok(MatGetDiagonal(fft[0], f[1]));
    ok(VecNorm(f[0], NORM_INFINITY, &size));
    AssertVecNear(f[1], f[0], NORM_INFINITY, 1e-12 * size);
    for (PetscInt i = 0; i < 2 * nx * nz; i++)
      ok(VecSetValue(u, i, PetscSinReal(1 + 0.7 * i + 0.01 * i * i), INSERT_VALUES));
    for (int t = 0; t < 2; t++) {
      Mat *A = t ? fft : dense;

      ok(MatScale(A[0], 2));
      ok(MatScale(A[1], 0.3));
      ok(MatSlipStiffnessMultBoth(A[0], A[1], u, f[t], n[t]));
    }
    ok(VecNorm(f[0], NORM_INFINITY, &size));
    AssertVecNear(f[1], f[0], NORM_INFINITY, 1e-12 * size);
    AssertVecNear(n[1], n[0], NORM_INFINITY, 1e-12 * size);
    ok(MatDestroy(&fft[s % 2]));
    assert_true(LargestDifference(fft[!(s % 2)], dense[!(s % 2)], dense[0]) < 1e-12);
    ObjectsDestroy(&u, &f[0], &f[1], &n[0], &n[1], &alone, &fft[!(s % 2)], &dense[0], &dense[1]);
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
    PetscReal most = 0, worst = 0;
    const PetscScalar *a[2], *b[2];
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
      a[t] = MatRead(A[t]);
      b[t] = MatRead(B[t]);
    }
    for (PetscInt j = 0; j < n; j++)
      for (PetscInt i = 0; i < n; i++) {
        PetscReal p[2], q[2], shear = 0, normal = 0;

        PartsOf(rake[i], p);
        PartsOf(rake[j], q);
        for (int l = 0; l < 2; l++) {
          for (int k = 0; k < 2; k++) shear += p[k] * q[l] * a[0][(2 * j + l) * 2 * n + 2 * i + k];
          normal += q[l] * b[0][(2 * j + l) * n + i];
        }
        most = PetscMax(most, PetscAbsReal(a[1][j * n + i]));
        worst = PetscMax(worst, PetscAbsReal(shear - a[1][j * n + i]));
        worst = PetscMax(worst, PetscAbsReal(normal - b[1][j * n + i]));
      }
    assert_true(worst < 1e-11 * most);
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
