/* Kernels and operators of cells that open: the third source and the third stress, against fields, by reciprocity,
   against quadrature, and their matrices. */
#include "vectorcells.h"
#include "operators.h"
#include <petscksp.h>

/* The cells of vectors, with opening */
static void OpeningCells(SlipCells cells[2])
{
  SlipCells scalars[2];

  Meshes(cells, scalars);
  cells[0].kernel.type = &SlipKernelDippingOpening;
  cells[1].kernel.type = &SlipKernelTriangleOpening;
  for (int k = 0; k < 2; k++) cells[k].rake = scalars[k].rake; /* which do not count */
}

static void Stress(const SlipKernel *kernel, const SlipCell *source, PetscInt component, PetscInt n,
                   const PetscReal at[], PetscReal stress[])
{
  const PetscReal slip[3] = {component == 0, component == 1, component == 2};

  if (source->vertices)
    ok(SlipTriangleStress(kernel->shear_modulus, kernel->poisson_ratio, kernel->full_space, source->vertices, slip, n,
                          at, stress));
  else
    ok(SlipDippingStress(kernel->shear_modulus, kernel->poisson_ratio, kernel->full_space, &source->rectangle, slip, n,
                         at, stress));
}

/* Blocks are the tractions of the fields' stress: rounding, 1e-12 of the largest. Those of slip are those without
   opening, to the bit. */
static void blocks_are_tractions(void **state)
{
  SlipCells cells[2];

  OpeningCells(cells);
  for (int k = 0; k < 2; k++)
    for (int space = 0; space < 2; space++) {
      SlipKernel *kernel = &cells[k].kernel, vectors;
      PetscReal most = 0, worst = 0;

      kernel->full_space = (PetscBool)space;
      vectors = *kernel;
      vectors.type = k ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
      for (PetscInt r = 0; r < cells[k].n; r += 5)
        for (PetscInt s = 0; s < cells[k].n; s += 3) {
          const SlipCell receiver = CellOf(&cells[k], r), source = CellOf(&cells[k], s);
          const PetscReal at[3] = {receiver.rectangle.x, receiver.rectangle.y, receiver.rectangle.z};
          PetscReal block[9], slips[6], directions[9];

          SlipKernelBlock(kernel, &receiver, &source, block);
          SlipKernelBlock(&vectors, &receiver, &source, slips);
          SlipPlaneDirections(receiver.rectangle.strike, receiver.rectangle.dip, 0, directions);
          for (int j = 0; j < 3; j++) {
            PetscReal stress[6], traction[3];

            Stress(kernel, &source, j, 1, at, stress);
            SlipStressTraction(1, stress, directions, traction);
            for (int i = 0; i < 3; i++) {
              most = PetscMax(most, PetscAbsReal(traction[i]));
              worst = PetscMax(worst, PetscAbsReal(block[3 * i + j] - traction[i]));
              if (j < 2) assert_true(block[3 * i + j] == slips[2 * i + j]);
            }
          }
          if (r == s) assert_true(block[0] > 0 && block[4] > 0 && block[8] > 0); /* its own drop */
        }
      assert_true(most > 0);
      assert_true(worst < 1e-12 * most);
    }
}

/* The force on one triangle by slip or opening of another is that of the other by the same of the one, also where they
   touch, reach the ground or lie far from each other; of one on itself to the error of quadrature below the ground,
   1e-8. Those of slip are those without opening, to the bit. */
static void averages_are_reciprocal(void **state)
{
  SlipCells cells[2];

  OpeningCells(cells);
  cells[1].kernel.average = SLIP_AVERAGE_CELL;
  for (PetscInt e = 0; e < 9 * T; e++)
    if (e % 3 == 2) triangle_data[8 * T + e] -= 200; /* up to the ground */
  for (int space = 0; space < 2; space++) {
    SlipKernel vectors;
    PetscReal most = 0;

    cells[1].kernel.full_space = (PetscBool)space;
    vectors = cells[1].kernel;
    vectors.type = &SlipKernelTriangleVector;
    for (PetscInt r = 0; r < T; r += 4)
      for (PetscInt s = 0; s < T; s += 7) {
        const SlipCell a = CellOf(&cells[1], r), b = CellOf(&cells[1], s);
        const PetscReal A = a.rectangle.length * a.rectangle.width, B = b.rectangle.length * b.rectangle.width;
        PetscReal there[9], back[9], slips[6];

        SlipKernelBlock(&cells[1].kernel, &a, &b, there);
        SlipKernelBlock(&cells[1].kernel, &b, &a, back);
        SlipKernelBlock(&vectors, &a, &b, slips);
        for (int i = 0; i < 6; i++) assert_true(slips[i] == there[3 * (i / 2) + i % 2]);
        for (int i = 0; i < 3; i++) most = PetscMax(most, A * PetscAbsReal(there[4 * i]));
        for (int i = 0; i < 3; i++)
          for (int j = 0; j < 3; j++)
            AssertNear(A * there[3 * i + j], B * back[3 * j + i], (r == s ? 1e-8 : 1e-10) * most);
      }
    assert_true(most > 0);
  }
}

/* Mean over the receiver of the traction by each source, from its values at the centroids of 4^level parts: the error
   goes as the square of their size */
static void Mean(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source, PetscInt level,
                 PetscReal mean[9])
{
  const PetscInt side = 1 << level;
  const PetscReal *v = receiver->vertices;
  PetscReal directions[9];

  SlipPlaneDirections(receiver->rectangle.strike, receiver->rectangle.dip, 0, directions);
  for (int i = 0; i < 9; i++) mean[i] = 0;
  for (PetscInt i = 0; i < side; i++)
    for (PetscInt j = 0; j < 2 * (side - i) - 1; j++) {
      const PetscReal a = ((PetscReal)i + (j % 2 ? 2.0 / 3 : 1.0 / 3)) / (PetscReal)side;
      const PetscReal b = ((PetscReal)(j / 2) + (j % 2 ? 2.0 / 3 : 1.0 / 3)) / (PetscReal)side;
      PetscReal at[3], stress[6], traction[3];

      for (int k = 0; k < 3; k++) at[k] = v[k] + a * (v[3 + k] - v[k]) + b * (v[6 + k] - v[k]);
      for (int s = 0; s < 3; s++) {
        Stress(kernel, source, s, 1, at, stress);
        SlipStressTraction(1, stress, directions, traction);
        for (int k = 0; k < 3; k++) mean[3 * k + s] += traction[k] / (PetscReal)(side * side);
      }
    }
}

/* Averages of triangles that do not touch against means of values, whose leading error Richardson takes off: what is
   left is of the fourth power of the part's share of the distance, at most (1/16)^4 = 2e-5 times what two parts differ
   by, 1e-6 of the largest here */
static void averages_are_means(void **state)
{
  SlipCells cells[2];

  OpeningCells(cells);
  for (int space = 0; space < 2; space++) {
    SlipKernel values = cells[1].kernel;
    PetscInt pairs = 0;

    cells[1].kernel.average = SLIP_AVERAGE_CELL;
    values.full_space = cells[1].kernel.full_space = (PetscBool)space;
    for (PetscInt r = 0; r < T; r += 9)
      for (PetscInt s = 0; s < T; s += 11) {
        const SlipCell a = CellOf(&cells[1], r), b = CellOf(&cells[1], s);
        const PetscReal far =
          hypot(hypot(a.rectangle.x - b.rectangle.x, a.rectangle.y - b.rectangle.y), a.rectangle.z - b.rectangle.z);
        PetscReal block[9], coarse[9], fine[9], most = 0;

        if (far < 250 || far > 700) continue;
        SlipKernelBlock(&cells[1].kernel, &a, &b, block);
        Mean(&values, &a, &b, 3, coarse);
        Mean(&values, &a, &b, 4, fine);
        for (int i = 0; i < 9; i++) most = PetscMax(most, PetscAbsReal(block[i]));
        for (int i = 0; i < 9; i++) AssertNear(block[i], (4 * fine[i] - coarse[i]) / 3, 1e-6 * most);
        pairs++;
      }
    assert_true(pairs > 20);
  }
}

/* S is symmetric and positive definite, hierarchical storage is it to the tolerance, and Kn its third rows over their
   weights; both products at once are those one by one. */
static void operators(void **state)
{
  SlipCells cells[2];

  OpeningCells(cells);
  for (PetscInt e = 0; e < N; e++) rectangle_data[4 * N + e] = 70 + (PetscReal)(e / NX % NZ); /* areas differ */
  for (int k = 0; k < 3; k++) {
    SlipCells c = cells[k > 0];
    const PetscScalar *a, *w = NULL;
    PetscBool is;
    Vec u, f, n[2], weights;
    Mat S[2], Kn[2], L;

    c.kernel.average = k == 2 ? SLIP_AVERAGE_CELL : SLIP_AVERAGE_CENTRE;
    for (int t = 0; t < 2; t++)
      ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &c, t ? "hmat" : "dense", 1e-6, &S[t], &Kn[t]));
    ok(MatIsSymmetric(S[0], 0, &is));
    assert_true(is);
    ok(MatDuplicate(S[0], MAT_COPY_VALUES, &L));
    ok(MatSetOption(L, MAT_SPD, PETSC_TRUE));
    ok(MatCholeskyFactor(L, NULL, NULL)); /* fails unless positive definite */
    AssertHierarchical(S, Kn, 1e-6);
    ok(MatCreateVecs(S[0], &u, &f));
    ok(MatCreateVecs(Kn[0], NULL, &n[0]));
    ok(VecDuplicate(n[0], &n[1]));
    ok(VecFillSines(u));
    ok(MatSlipStiffnessMultBoth(S[0], Kn[0], u, f, n[0]));
    ok(MatMult(Kn[0], u, n[1]));
    ok(MatSlipGetWeights(S[0], &weights));
    assert_true((weights != NULL) == (k == 0));
    if (weights) w = VecRead(weights);
    a = VecRead(f);
    for (int both = 0; both < 2; both++)
      for (PetscInt i = 0; i < c.n; i++) assert_true(VecRead(n[both])[i] == a[3 * i + 2] / (w ? w[3 * i + 2] : 1));
    ObjectsDestroy(&L, &S[0], &S[1], &Kn[0], &Kn[1], &u, &f, &n[0], &n[1]);
  }
}

/* A plane in a full space: opening makes no shear stress on it, and slip no normal stress. 1e-13 of the largest:
   rounding of both terms that cancel */
static void opening_of_a_plane_makes_no_shear(void **state)
{
  SlipDippingGrid grid = {.grid = {.nx = 6, .nz = 5, .length_x = 600, .length_z = 400, .depth_top = 100}, .dip = 40};
  const PetscScalar *a;
  PetscReal most = 0, mixed = 0, own = 0;
  Mat S;

  grid.grid.kernel = (SlipKernel){&SlipKernelDippingOpening, 30e9, 0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE, NULL};
  ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "auto", &S, NULL));
  a = MatRead(S);
  for (PetscInt j = 0; j < 90; j++)
    for (PetscInt i = 0; i < 90; i++) {
      const PetscReal entry = PetscAbsReal(a[j * 90 + i]);

      if ((i % 3 == 2) != (j % 3 == 2))
        mixed = PetscMax(mixed, entry);
      else
        most = PetscMax(most, entry);
      if (i == j && i % 3 == 2) own = PetscMax(own, entry);
    }
  assert_true(most > 0 && own > 0.5 * most && mixed < 1e-13 * most);
  ok(MatDestroy(&S));
}

/* With the ground and without, of one cell each way and more */
static void transforms(void **state)
{
  const PetscInt sizes[][2] = {{7, 4}, {1, 5}, {6, 1}, {12, 9}};

  for (int k = 0; k < 8; k++) {
    const PetscBool full = k % 2 ? PETSC_TRUE : PETSC_FALSE;
    const SlipKernel rock = {&SlipKernelDippingOpening, 30e9, 0.2, full, SLIP_AVERAGE_CENTRE, NULL};
    const SlipDippingGrid grid = {.grid = {sizes[k / 2][0], sizes[k / 2][1], 700, 400, 100, rock},
                                  .dip = 35 + 20 * (k % 3)};

    AssertTransforms(&grid);
  }
}

/* Shear and compressional waves damp slip and opening apart, in products, on the diagonal and in the stage operator. */
static void radiation(void **state)
{
  SlipCells cells[2];
  const PetscReal eta = 3, across = 5, theta = 0.5, mass = 7;
  const PetscScalar *a, *w, *k, *b;
  Vec x, y, d, weights;
  Mat S, H, B, L;

  OpeningCells(cells);
  for (PetscInt e = 0; e < N; e++) rectangle_data[4 * N + e] = 70 + (PetscReal)(e / NX % NZ);
  ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &cells[0], "dense", 1e-6, &S, NULL));
  fails(MatCreateSlipRadiationOpening(S, eta, -1, &H), "across cells must be positive");
  ok(MatCreateSlipRadiationOpening(S, eta, across, &H));
  ok(MatCreateVecs(S, &x, &y));
  ok(VecDuplicate(y, &d));
  ok(VecSet(x, 2));
  ok(MatMult(H, x, y));
  ok(MatGetDiagonal(H, d));
  ok(MatSlipGetWeights(S, &weights));
  w = VecRead(weights);
  a = VecRead(y);
  k = VecRead(d);
  for (PetscInt i = 0; i < 3 * N; i++) {
    AssertNear(k[i], (i % 3 == 2 ? across : eta) * w[i], 1e-14 * across);
    AssertNear(a[i], 2 * k[i], 1e-14 * across);
  }
  ok(MatCreateSlipStage(S, H, mass, &B));
  ok(MatSlipStageSetTheta(B, theta));
  ok(MatMult(B, x, y));
  ok(MatDuplicate(S, MAT_COPY_VALUES, &L));
  ok(MatMult(L, x, d));
  a = VecRead(y);
  b = VecRead(d);
  for (PetscInt i = 0; i < 3 * N; i++)
    AssertNear(a[i], theta * b[i] + 2 * w[i] * (mass / theta + (i % 3 == 2 ? across : eta)),
               1e-12 * PetscAbsReal(b[i]) + 1e-9);
  ObjectsDestroy(&x, &y, &d, &S, &H, &B, &L);
}

SLIP_TESTS(blocks_are_tractions, averages_are_reciprocal, averages_are_means, operators,
           opening_of_a_plane_makes_no_shear, transforms, radiation)
