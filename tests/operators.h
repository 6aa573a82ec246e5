/* Checks of stiffnesses that tests of several kernels share. */
#pragma once
#include "unit.h"

/* The largest entry of A - B, or of A where B is NULL */
static inline PetscReal LargestDifference(Mat A, Mat B)
{
  const PetscScalar *a, *b = NULL;
  PetscReal most = 0;
  PetscInt m, n;
  Mat dense[2] = {NULL};

  ok(MatConvert(A, MATDENSE, MAT_INITIAL_MATRIX, &dense[0]));
  if (B) ok(MatConvert(B, MATDENSE, MAT_INITIAL_MATRIX, &dense[1]));
  ok(MatGetSize(A, &m, &n));
  a = MatRead(dense[0]);
  if (B) b = MatRead(dense[1]);
  for (PetscInt i = 0; i < m * n; i++) most = PetscMax(most, PetscAbsScalar(a[i] - (b ? b[i] : 0)));
  ObjectsDestroy(&dense[0], &dense[1]);
  return most;
}

/* |A - B| / |B|, Frobenius, of any types */
static inline PetscReal MatDistance(Mat A, Mat B)
{
  PetscReal error, norm;
  Mat a, b;

  ok(MatConvert(A, MATDENSE, MAT_INITIAL_MATRIX, &a));
  ok(MatConvert(B, MATDENSE, MAT_INITIAL_MATRIX, &b));
  ok(MatNorm(b, NORM_FROBENIUS, &norm));
  ok(MatAXPY(a, -1, b, SAME_NONZERO_PATTERN));
  ok(MatNorm(a, NORM_FROBENIUS, &error));
  ObjectsDestroy(&a, &b);
  return error / norm;
}

/* The stiffness of a grid, and that of normal stress, by the kernel's number of components */
static inline PetscErrorCode CreateOfGrid(const SlipDippingGrid *grid, const char type[], Mat *S, Mat *Kn)
{
  return (grid->grid.kernel.type->components > 1 ? MatCreateSlipDippingVectorStiffness
                                                 : MatCreateSlipDippingStiffness)(PETSC_COMM_SELF, grid, type, S, Kn);
}

/* Products by transforms against dense: all entries, the diagonals, both at once with scales of their own, what is
   asked for without Kn, and either destroyed first. 1e-12 of S's largest entry: transforms of 2 nx numbers round to
   some 1e-16 of that, and kernels ten cells away to 1e-14 of themselves. */
static inline void AssertTransforms(const SlipDippingGrid *grid)
{
  static int calls;
  const int gone = calls++ % 2, left = !gone;
  const PetscInt components = grid->grid.kernel.type->components;
  PetscReal size;
  Mat dense[2], fft[2], alone;
  Vec u, f[2], n[2];

  ok(CreateOfGrid(grid, "dense", &dense[0], &dense[1]));
  ok(CreateOfGrid(grid, "fft", &fft[0], &fft[1]));
  ok(CreateOfGrid(grid, "fft", &alone, NULL));
  size = LargestDifference(dense[0], NULL);
  for (int t = 0; t < 2; t++) assert_true(LargestDifference(fft[t], dense[t]) < 1e-12 * size);
  assert_true(LargestDifference(alone, dense[0]) < 1e-12 * size);
  ok(MatCreateVecs(dense[0], &u, &f[0]));
  ok(MatCreateVecs(dense[1], NULL, &n[0]));
  ok(VecDuplicate(f[0], &f[1]));
  ok(VecDuplicate(n[0], &n[1]));
  for (int t = 0; t < (components > 1 ? 1 : 2); t++) {
    ok(MatGetDiagonal(dense[t], f[0]));
    ok(MatGetDiagonal(fft[t], f[1]));
    AssertVecNear(f[1], f[0], NORM_INFINITY, 1e-12 * size);
  }
  ok(VecFillSines(u));
  for (int t = 0; t < 2; t++) {
    Mat *A = t ? fft : dense;

    ok(MatScale(A[0], 2));
    if (components < 3) ok(MatScale(A[1], 0.3)); /* else its rows are those of S */
    ok(MatSlipStiffnessMultBoth(A[0], A[1], u, f[t], n[t]));
  }
  ok(VecNorm(f[0], NORM_INFINITY, &size));
  AssertVecNear(f[1], f[0], NORM_INFINITY, 1e-12 * size);
  AssertVecNear(n[1], n[0], NORM_INFINITY, 1e-12 * size);
  ok(MatDestroy(&fft[gone]));
  assert_true(LargestDifference(fft[left], dense[left]) < 1e-12 * LargestDifference(dense[0], NULL));
  ObjectsDestroy(&u, &f[0], &f[1], &n[0], &n[1], &alone, &fft[left], &dense[0], &dense[1]);
}

/* Products of hierarchical storage with S and with Kn at once against dense, of uniform slip along each component and
   of random slip: blocks are off by the tolerance in their own norm, and errors of some hundred blocks add up at
   random, ten times that of the product. The whole is off by the tolerance, as blocks are each. */
static inline void AssertHierarchical(Mat S[2], Mat Kn[2], PetscReal tolerance)
{
  PetscInt columns, rows;
  Vec u, f[2], n[2];

  ok(MatGetSize(Kn[0], &rows, &columns));
  ok(MatCreateVecs(S[0], &u, &f[0]));
  ok(MatCreateVecs(Kn[0], NULL, &n[0]));
  ok(VecDuplicate(f[0], &f[1]));
  ok(VecDuplicate(n[0], &n[1]));
  for (PetscInt slip = 0; slip <= columns / rows; slip++) {
    for (PetscInt i = 0; i < columns; i++) ok(VecSetValue(u, i, i % (columns / rows) == slip ? 1 : 0, INSERT_VALUES));
    if (slip == columns / rows) ok(VecFillSines(u));
    for (int t = 0; t < 2; t++) ok(MatSlipStiffnessMultBoth(S[t], Kn[t], u, f[t], n[t]));
    AssertVecClose(f[1], f[0], NORM_2, 10 * tolerance);
    AssertVecClose(n[1], n[0], NORM_2, 10 * tolerance);
  }
  assert_true(MatDistance(S[1], S[0]) < tolerance);
  assert_true(MatDistance(Kn[1], Kn[0]) < tolerance);
  ObjectsDestroy(&u, &f[0], &f[1], &n[0], &n[1]);
}

/* Pairs at once are pairs one by one: rounding only, where compilers fuse products, 1e-13 of the largest */
static inline void AssertPairsAtOnce(const SlipKernel *kernel, PetscInt n, const SlipCell receiver[],
                                     const SlipCell source[])
{
  const PetscInt c = kernel->type->components, size = c * (c + kernel->type->normals);
  PetscReal *at_once, block[SLIP_KERNEL_BLOCK], most = 0;

  ok(PetscMalloc1(size * n, &at_once));
  (*kernel->type->centres)(kernel, n, receiver, source, at_once);
  for (PetscInt k = 0; k < size * n; k++) most = PetscMax(most, PetscAbsReal(at_once[k]));
  for (PetscInt k = 0; k < n; k++) {
    SlipKernelBlock(kernel, &receiver[k], &source[k], block);
    for (PetscInt i = 0; i < size; i++) AssertNear(at_once[size * k + i], block[i], 1e-13 * most);
  }
  ok(PetscFree(at_once));
}
