/* Slip as a vector in each cell's plane: kernels against fields, and operators against those of slip along rakes and against each other. */
#include "unit.h"
#include "cells.h"
#include "triangles.h"
#include <math.h>

enum { NX = 7, NZ = 5, N = 2 * NX * NZ, T = 2 * N };

static PetscReal rectangle_data[8 * N], triangle_data[TRIANGLE_COLUMNS * T];

static SlipCell CellOf(const SlipCells *c, PetscInt i)
{
  return (SlipCell){.rectangle = {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], c->strike[i], c->dip[i]},
                    .rake = c->rake[i],
                    .vertices = c->vertices ? c->vertices + 9 * i : NULL};
}

/* Along the rake, and its parts along strike and up dip */
static void PartsOf(PetscReal rake, PetscReal part[2])
{
  part[0] = PetscCosReal(rake * PETSC_PI / 180);
  part[1] = PetscSinReal(rake * PETSC_PI / 180);
}

/* The two planes with rakes that vary by more, as rectangles and as triangles with a kernel for vectors, and with the one for rakes */
static void Meshes(SlipCells vectors[2], SlipCells scalars[2])
{
  scalars[0] = TwoDippingPlanes(NX, NZ, rectangle_data);
  for (PetscInt e = 0; e < N; e++) ((PetscReal *)scalars[0].rake)[e] = 37.0 * (PetscReal)e - 200;
  scalars[1] = TrianglesOf(&scalars[0], triangle_data);
  for (int k = 0; k < 2; k++) {
    vectors[k] = scalars[k];
    vectors[k].kernel.type = k ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
    vectors[k].rake = NULL;
  }
}

/* Blocks are the tractions of the fields' stress, along strike, up dip and normal, of slip along strike and up dip. One closed form at
   one point or sixteen: rounding, 1e-12 of the largest. */
static void blocks_are_tractions(void **state)
{
  SlipCells vectors[2], scalars[2];

  (void)state;
  Meshes(vectors, scalars);
  for (int k = 0; k < 2; k++)
    for (int space = 0; space < 2; space++) {
      const SlipKernel *kernel = &vectors[k].kernel;
      PetscReal most = 0, worst = 0;

      vectors[k].kernel.full_space = (PetscBool)space;
      for (PetscInt r = 0; r < vectors[k].n; r += 5)
        for (PetscInt s = 0; s < vectors[k].n; s += 3) {
          const SlipCell receiver = CellOf(&scalars[k], r), source = CellOf(&scalars[k], s);
          const PetscReal at[3] = {receiver.rectangle.x, receiver.rectangle.y, receiver.rectangle.z};
          PetscReal block[6], directions[9];

          SlipKernelBlock(kernel, &receiver, &source, block);
          SlipPlaneDirections(receiver.rectangle.strike, receiver.rectangle.dip, 0, directions);
          for (int j = 0; j < 2; j++) {
            const PetscReal slip[3] = {j == 0, j == 1, 0};
            PetscReal stress[6], traction[3];

            if (k)
              ok(SlipTriangleStress(kernel->shear_modulus, kernel->poisson_ratio, (PetscBool)space, source.vertices,
                                    slip, 1, at, stress));
            else
              ok(SlipDippingStress(kernel->shear_modulus, kernel->poisson_ratio, (PetscBool)space, &source.rectangle,
                                   slip, 1, at, stress));
            SlipStressTraction(1, stress, directions, traction);
            for (int i = 0; i < 3; i++) {
              most = PetscMax(most, PetscAbsReal(traction[i]));
              worst = PetscMax(worst, PetscAbsReal(block[2 * i + j] - traction[i]));
            }
          }
        }
      assert_true(most > 0);
      assert_true(worst < 1e-12 * most);
    }
}

/* Pairs at once are pairs one by one, in runs of one source, of one receiver, and of neither; with directions given and not: rounding */
static void pairs_at_once(void **state)
{
  enum { pairs = 53 };
  SlipCells vectors[2], scalars[2];

  (void)state;
  Meshes(vectors, scalars);
  for (int k = 0; k < 2; k++) {
    const SlipKernel *kernel = &vectors[k].kernel;
    SlipCell receiver[pairs], source[pairs];
    PetscReal at_once[6 * pairs], block[6], directions[9 * pairs], most = 0;

    for (int p = 0; p < pairs; p++) {
      receiver[p] = CellOf(&scalars[k], p < 20 ? 3 : 7 * p % vectors[k].n);
      source[p] = CellOf(&scalars[k], p < 20 ? 3 * p : p < 40 ? 11 : 13 * p % vectors[k].n);
      if (p % 3) continue;
      SlipPlaneDirections(source[p].rectangle.strike, source[p].rectangle.dip, 0, directions + 9 * p);
      source[p].directions = directions + 9 * p;
    }
    (*kernel->type->centres)(kernel, pairs, receiver, source, at_once);
    for (int i = 0; i < 6 * pairs; i++) most = PetscMax(most, PetscAbsReal(at_once[i]));
    for (int p = 0; p < pairs; p++) {
      SlipKernelBlock(kernel, &receiver[p], &source[p], block);
      for (int i = 0; i < 6; i++) AssertNear(at_once[6 * p + i], block[i], 1e-13 * most);
    }
  }
}

/* Of dense S [2 n][2 n] and Kn [n][2 n], the largest difference of P' S P and Kn P from those of slip along the rakes, over the largest
   entry of the latter's stiffness */
static PetscReal ProjectedDifference(const SlipCells *vectors, const SlipCells *scalars)
{
  const PetscInt n = vectors->n;
  PetscReal most = 0, worst = 0;
  const PetscScalar *a[2], *b[2];
  Mat S[2], Kn[2];

  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, vectors, "dense", 1e-6, &S[0], &Kn[0]));
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, scalars, "dense", 1e-6, &S[1]));
  ok(MatCreateSlipCellNormalStiffness(PETSC_COMM_SELF, scalars, "dense", 1e-6, &Kn[1]));
  for (int t = 0; t < 2; t++) {
    ok(MatDenseGetArrayRead(S[t], &a[t]));
    ok(MatDenseGetArrayRead(Kn[t], &b[t]));
  }
  for (PetscInt j = 0; j < n; j++)
    for (PetscInt i = 0; i < n; i++) {
      PetscReal p[2], q[2], shear = 0, normal = 0;

      PartsOf(scalars->rake[i], p);
      PartsOf(scalars->rake[j], q);
      for (int l = 0; l < 2; l++) {
        for (int k = 0; k < 2; k++) shear += p[k] * q[l] * a[0][(2 * j + l) * 2 * n + 2 * i + k];
        normal += q[l] * b[0][(2 * j + l) * n + i];
      }
      most = PetscMax(most, PetscAbsReal(a[1][j * n + i]));
      worst = PetscMax(worst, PetscAbsReal(shear - a[1][j * n + i]));
      worst = PetscMax(worst, PetscAbsReal(normal - b[1][j * n + i]));
    }
  for (int t = 0; t < 2; t++) {
    ok(MatDenseRestoreArrayRead(S[t], &a[t]));
    ok(MatDenseRestoreArrayRead(Kn[t], &b[t]));
    ok(MatDestroy(&S[t]));
    ok(MatDestroy(&Kn[t]));
  }
  return worst / most;
}

/* Slip along rakes, each cell its own, is what the vectors' operators are there: of rectangles and triangles, with averages and their edges,
   which some cells share and some do not. One formula, linear in both directions: rounding. */
static void projections_are_scalar(void **state)
{
  SlipCells vectors[2], scalars[2];

  (void)state;
  Meshes(vectors, scalars);
  for (int space = 0; space < 2; space++)
    for (int k = 0; k < 3; k++) {
      SlipCells v = vectors[k > 0], s = scalars[k > 0];

      v.kernel.full_space = s.kernel.full_space = (PetscBool)space;
      v.kernel.average = s.kernel.average = k == 2 ? SLIP_AVERAGE_CELL : SLIP_AVERAGE_CENTRE;
      assert_true(ProjectedDifference(&v, &s) < 1e-12);
    }
}

/* Vertical cells, and overturned ones with the hanging wall below */
static void projections_at_any_dip(void **state)
{
  SlipCells vectors[2], scalars[2];

  (void)state;
  Meshes(vectors, scalars);
  for (PetscInt e = 0; e < N; e++) {
    PetscReal *data = rectangle_data;

    data[N + e] = e < N / 2 ? 0 : 500;
    data[2 * N + e] = 80 * (e / NX % NZ + 0.5);
    data[6 * N + e] = 90;
  }
  assert_true(ProjectedDifference(&vectors[0], &scalars[0]) < 1e-12);
  scalars[1] = TrianglesOf(&scalars[0], triangle_data);
  assert_true(ProjectedDifference(&vectors[1], &scalars[1]) < 1e-12);
  Meshes(vectors, scalars);
  for (PetscInt e = 0; e < T; e++) {
    if (triangle_data[6 * T + e] > 50) continue;
    triangle_data[5 * T + e] = 180;
    triangle_data[6 * T + e] = 180 - triangle_data[6 * T + e];
  }
  assert_true(ProjectedDifference(&vectors[1], &scalars[1]) < 1e-12);
}

/* The force on one triangle by slip on another along any pair of directions is that of the other by the same slip of the one, also where they
   touch, reach the ground or lie far from each other; of one on itself to the error of quadrature below the ground, 1e-8 */
static void averages_are_reciprocal(void **state)
{
  SlipCells vectors[2], scalars[2];

  (void)state;
  Meshes(vectors, scalars);
  vectors[1].kernel.average = SLIP_AVERAGE_CELL;
  for (PetscInt e = 0; e < 9 * T; e++)
    if (e % 3 == 2) triangle_data[8 * T + e] -= 200; /* up to the ground */
  for (int space = 0; space < 2; space++) {
    PetscReal most = 0;

    vectors[1].kernel.full_space = (PetscBool)space;
    for (PetscInt r = 0; r < T; r += 4)
      for (PetscInt s = 0; s < T; s += 7) {
        const SlipCell a = CellOf(&scalars[1], r), b = CellOf(&scalars[1], s);
        const PetscReal A = a.rectangle.length * a.rectangle.width, B = b.rectangle.length * b.rectangle.width;
        PetscReal there[6], back[6];

        SlipKernelBlock(&vectors[1].kernel, &a, &b, there);
        SlipKernelBlock(&vectors[1].kernel, &b, &a, back);
        for (int i = 0; i < 2; i++) most = PetscMax(most, A * PetscAbsReal(there[3 * i]));
        for (int i = 0; i < 2; i++)
          for (int j = 0; j < 2; j++)
            AssertNear(A * there[2 * i + j], B * back[2 * j + i], (r == s ? 1e-8 : 1e-10) * most);
      }
    assert_true(most > 0);
  }
}

/* Symmetric to the bit, known to be positive, of the sizes that were promised, with weights twice each */
static void matrices(void **state)
{
  SlipCells vectors[2], scalars[2];
  PetscInt m, n;
  PetscBool is, set, positive;
  const PetscScalar *w, *v;
  Vec weights, scalar, u;
  Mat S, Kn, K;

  (void)state;
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
  ok(MatDestroy(&S));
  ok(MatDestroy(&Kn));
  for (PetscInt e = 0; e < N; e++) rectangle_data[4 * N + e] = 70 + (PetscReal)(e / NX % NZ);
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[0], "dense", 1e-6, &S, NULL));
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &scalars[0], "dense", 1e-6, &K));
  ok(MatIsSymmetric(S, 0, &is));
  assert_true(is);
  ok(MatSlipGetWeights(S, &weights));
  ok(MatSlipGetWeights(K, &scalar));
  ok(VecGetSize(weights, &n));
  assert_int_equal(n, 2 * N);
  ok(VecGetArrayRead(weights, &w));
  ok(VecGetArrayRead(scalar, &v));
  for (PetscInt i = 0; i < 2 * N; i++) assert_true(w[i] == v[i / 2]);
  ok(VecRestoreArrayRead(weights, &w));
  ok(VecRestoreArrayRead(scalar, &v));
  ok(MatDestroy(&S));
  ok(MatDestroy(&K));
}

/* u' S u of slip [n] in space that lies in the plane of the cells */
static PetscReal Energy(const SlipCells *c, PetscReal slip[][3])
{
  PetscReal energy;
  Vec u, f;
  Mat S;

  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, c, "dense", 1e-6, &S, NULL));
  ok(MatCreateVecs(S, &u, &f));
  for (PetscInt e = 0; e < c->n; e++) {
    PetscReal d[9];

    SlipPlaneDirections(c->strike[e], c->dip[e], 0, d);
    for (int k = 0; k < 2; k++)
      ok(VecSetValue(u, 2 * e + k, d[3 * k] * slip[e][0] + d[3 * k + 1] * slip[e][1] + d[3 * k + 2] * slip[e][2],
                     INSERT_VALUES));
  }
  ok(MatMult(S, u, f));
  ok(VecDot(u, f, &energy));
  ok(VecDestroy(&u));
  ok(VecDestroy(&f));
  ok(MatDestroy(&S));
  return energy;
}

/* Triangles of one horizontal plane in a full space: their axes may be turned in the plane, from cell to cell too, and the plane with all on it to
   any other, vertical ones with either side as the hanging wall. The energy of the same slip in space stays, at centres and with averages: 1e-11 as
   coordinates round. */
static void energy_knows_no_axes(void **state)
{
  const PetscReal turned[4][3] = {
    {0, 0, 0}, {25, 90, 0}, {25, 90, 180}, {310, 40, 0}}; /* strike, dip, to the other side */
  SlipCells vectors[2], scalars[2], *c = &vectors[1];
  static PetscReal slip[T][3], in_plane[T][2];

  (void)state;
  Meshes(vectors, scalars);
  for (PetscInt e = 0; e < N; e++) {
    const PetscReal flat[3] = {100.0 * (e % NX), 80.0 * (e / NX), 3000};

    for (int k = 0; k < 3; k++) rectangle_data[k * N + e] = flat[k];
    rectangle_data[5 * N + e] = rectangle_data[6 * N + e] = 0;
  }
  for (PetscInt e = 0; e < T; e++)
    for (int k = 0; k < 2; k++) in_plane[e][k] = Random(-1, 1);
  for (int average = 0; average < 2; average++) {
    PetscReal energy = 0;

    for (int t = 0; t < 4; t++) {
      PetscReal d[9];

      scalars[1] = TrianglesOf(&scalars[0], triangle_data);
      c->kernel.full_space = PETSC_TRUE;
      c->kernel.average = average ? SLIP_AVERAGE_CELL : SLIP_AVERAGE_CENTRE;
      SlipPlaneDirections(turned[t][0], turned[t][1], 0, d);
      /* north and west of the horizontal plane become strike and up dip */
      for (PetscInt e = 0; e < T; e++) {
        for (int k = 0; k < 3; k++) slip[e][k] = in_plane[e][0] * d[k] + in_plane[e][1] * d[3 + k];
        for (int v = 0; v < 4; v++) {
          PetscReal *p = v < 3 ? triangle_data + 8 * T + 9 * e + 3 * v : NULL;
          const PetscReal x = p ? p[0] : triangle_data[e], y = p ? -p[1] : -triangle_data[T + e];

          for (int k = 0; k < 3; k++) {
            const PetscReal at = x * d[k] + y * d[3 + k] + (k == 2 ? 3000 : 0);

            if (p)
              p[k] = at;
            else
              triangle_data[k * T + e] = at;
          }
        }
        triangle_data[5 * T + e] = turned[t][0] + turned[t][2];
        triangle_data[6 * T + e] = turned[t][1];
      }
      if (t == 0) energy = Energy(c, slip);
      AssertNear(Energy(c, slip), energy, 1e-11 * energy);
      if (turned[t][1] > 0) continue;
      for (PetscInt e = 0; e < T; e++) triangle_data[5 * T + e] = 30 + (PetscReal)(e % 50);
      AssertNear(Energy(c, slip), energy, 1e-11 * energy);
    }
    assert_true(energy > 0);
  }
}

/* Hierarchical storage against dense, of random and of uniform slip, along strike and up dip. Blocks are off by the tolerance in their own norm, and
   errors of some hundred blocks add up at random: ten times that of the product. There are blocks of low rank; both products at once are those
   one by one. */
static void hierarchical(void **state)
{
  enum { nx = 16, nz = 8, n = 2 * nx * nz };
  static PetscReal data[8 * n], halves[TRIANGLE_COLUMNS * 2 * n];
  const PetscReal tolerance = 1e-6;
  const SlipCells rectangles = TwoDippingPlanes(nx, nz, data), triangles = TrianglesOf(&rectangles, halves);

  (void)state;
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
      ok(VecAXPY(f[1], -1, f[0]));
      ok(VecNorm(f[1], NORM_2, &error));
      assert_true(error < 10 * tolerance * norm);
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
    ok(VecAXPY(d[1], -1, d[0]));
    ok(VecNorm(d[1], NORM_2, &error));
    assert_true(error < 1e-13 * norm);
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

/* Of two groups of cells far from each other a block of low rank holds what the one does to the other, a millionth of what cells do to
   themselves: off by at most the tolerance of its own norm, and the traction by uniform slip along either component by ten times that of
   its own, although it is small beside that of random slip in the same norm; compression too, and in either direction. */
static void blocks_to_their_own_tolerance(void **state)
{
  enum { nx = 8, nz = 5, half = nx * nz, n = 2 * half };
  static PetscReal data[8 * n];
  const PetscReal tolerance = 1e-5;
  SlipCells c = TwoDippingPlanes(nx, nz, data);
  const PetscScalar *a[2];
  Mat A[2][2];

  (void)state;
  for (PetscInt e = half; e < n; e++) data[e] += 5000;
  c.kernel.type = &SlipKernelDippingVector;
  for (int t = 0; t < 2; t++) {
    ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", tolerance, &A[0][t], &A[1][t]));
    for (int m = 0; m < 2 && t; m++) ok(MatConvert(A[m][t], MATDENSE, MAT_INPLACE_MATRIX, &A[m][t]));
  }
  for (int m = 0; m < 2; m++) {
    const PetscInt rows = m ? 1 : 2;

    for (int t = 0; t < 2; t++) ok(MatDenseGetArrayRead(A[m][t], &a[t]));
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
      ok(MatDenseRestoreArrayRead(A[m][t], &a[t]));
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
    ok(MatDenseGetArrayRead(d, &p));
    ok(MatDenseGetArrayRead(e, &q));
    difference = most = 0;
    for (PetscInt i = 0; i < m * n; i++) difference = PetscMax(difference, PetscAbsScalar(p[i]));
    for (PetscInt i = 0; i < all * all; i++) most = PetscMax(most, PetscAbsScalar(q[i]));
    ok(MatDenseRestoreArrayRead(d, &p));
    ok(MatDenseRestoreArrayRead(e, &q));
  }
  ok(MatDestroy(&d));
  ok(MatDestroy(&e));
  return difference / most;
}

/* Products by transforms against dense: all entries, the diagonal, both at once with scales of their own, what is asked for without Kn, and
   either destroyed first. Sizes with a middle and without, one column and one row; vertical planes too. 1e-12 of the largest entry, as for
   slip along rakes (test_dipping_mat.c). */
static void transforms(void **state)
{
  const PetscInt sizes[][2] = {{9, 8}, {10, 5}, {1, 13}, {12, 1}, {1, 1}, {2, 17}};
  SlipCells vectors[2], scalars[2];

  (void)state;
  Meshes(vectors, scalars);
  for (size_t s = 0; s < 2 * PETSC_STATIC_ARRAY_LENGTH(sizes); s++) {
    const PetscInt nx = sizes[s / 2][0], nz = sizes[s / 2][1];
    const SlipDippingGrid grid = {.grid = {nx, nz, 100 * nx, 80 * nz, s % 3 ? 50 : 0, vectors[0].kernel},
                                  .dip = s % 2 ? 90 : 40};
    Mat dense[2], fft[2], alone;
    PetscReal size, error;
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
    ok(VecAXPY(f[1], -1, f[0]));
    ok(VecNorm(f[1], NORM_INFINITY, &error));
    assert_true(error < 1e-12 * size);
    for (PetscInt i = 0; i < 2 * nx * nz; i++)
      ok(VecSetValue(u, i, PetscSinReal(1 + 0.7 * i + 0.01 * i * i), INSERT_VALUES));
    for (int t = 0; t < 2; t++) {
      Mat *A = t ? fft : dense;

      ok(MatScale(A[0], 2));
      ok(MatScale(A[1], 0.3));
      ok(MatSlipStiffnessMultBoth(A[0], A[1], u, f[t], n[t]));
    }
    ok(VecNorm(f[0], NORM_INFINITY, &size));
    ok(VecAXPY(f[1], -1, f[0]));
    ok(VecNorm(f[1], NORM_INFINITY, &error));
    assert_true(error < 1e-12 * size);
    ok(VecAXPY(n[1], -1, n[0]));
    ok(VecNorm(n[1], NORM_INFINITY, &error));
    assert_true(error < 1e-12 * size);
    ok(MatDestroy(&fft[s % 2]));
    assert_true(LargestDifference(fft[!(s % 2)], dense[!(s % 2)], dense[0]) < 1e-12);
    ObjectsDestroy(&u, &f[0], &f[1], &n[0], &n[1], &alone, &fft[!(s % 2)], &dense[0], &dense[1]);
  }
}

/* P' S P and Kn P of a grid by transforms are its matrices of slip along rakes, each cell its own, of both types; along strike and on a
   vertical plane those of MatCreateSlipStiffness(), whose closed form is another. 1e-11: transforms, and forms that cancel ten cells away. */
static void grids_project(void **state)
{
  enum { nx = 9, nz = 8, n = nx * nz };
  static PetscReal rake[n];
  SlipCells vectors[2], scalars[2];

  (void)state;
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
      ok(MatDenseGetArrayRead(A[t], &a[t]));
      ok(MatDenseGetArrayRead(B[t], &b[t]));
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
    for (int t = 0; t < 2; t++) {
      ok(MatDenseRestoreArrayRead(A[t], &a[t]));
      ok(MatDenseRestoreArrayRead(B[t], &b[t]));
      ok(MatDestroy(&A[t]));
      ok(MatDestroy(&B[t]));
    }
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

  (void)state;
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
  const SlipKernelType three = {.name = "three", .components = 3, .centre = SlipKernelDipping.centre};
  const SlipKernelType shear = {.name = "shear", .components = 2, .centre = SlipKernelDippingVector.centre};
  PetscReal rake[12] = {0};
  SlipDippingGrid grid = {.grid = {4, 3, 400, 300, 0}, .dip = 50, .rake = rake};
  SlipCells vectors[2], scalars[2];
  Mat A = NULL, B = NULL;

  (void)state;
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
  vectors[0].kernel.type = &three;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &vectors[0], "test"), "3 components of slip and 0 rows");
  vectors[0].kernel.type = &shear;
  fails(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &vectors[0], "dense", 1e-6, &A, &B),
        "\"shear\" has no row of normal stress");
  vectors[0].kernel.type = &SlipKernelTriangleVector;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &vectors[0], "test"), "kernel \"triangle_vector\" with rectangles");
  vectors[1].kernel.type = &SlipKernelDippingVector;
  fails(SlipCellsCheck(PETSC_COMM_SELF, &vectors[1], "test"), "kernel \"dipping_vector\" with triangles");
}

SLIP_TESTS(blocks_are_tractions, pairs_at_once, projections_are_scalar, projections_at_any_dip, averages_are_reciprocal,
           matrices, energy_knows_no_axes, hierarchical, blocks_to_their_own_tolerance, transforms, grids_project,
           chosen, refused)
