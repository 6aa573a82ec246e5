/*
  A kernel of a user's own: every operator that is built from it is its matrix.

  It is G A / w^3 (1 + R^2 / w^2)^(-3/2) of a source of the area A at the distance R, plus that of its image: no rock's,
  but with all that operators ask for, symmetries, a free surface, smoothness far away and a matrix that is positive
  definite, and with a parameter of its own, w.
*/
#include "unit.h"
#include "products.h"
#include "cells.h"
#include <math.h>

#define NX 11
#define NZ 70 /* more than grids treat by blocks */
#define G 30e9

/* What each entry must be; depth: between receiver and source or its image */
static PetscReal Bump(PetscReal w, const SlipDippingRectangle *r, const SlipDippingRectangle *s, PetscReal depth)
{
  const PetscReal R2 = PetscSqr(r->x - s->x) + PetscSqr(r->y - s->y) + PetscSqr(depth);

  return G * s->length * s->width / (w * w * w) * PetscPowReal(1 + R2 / (w * w), -1.5);
}

static PetscReal Expected(PetscReal w, const SlipDippingRectangle *r, const SlipDippingRectangle *s,
                          PetscBool full_space)
{
  return Bump(w, r, s, r->z - s->z) + (full_space ? 0 : Bump(w, r, s, r->z + s->z));
}

static void Centre_Bump(const SlipKernel *k, const SlipCell *r, const SlipCell *s, PetscReal block[])
{
  block[0] = Expected(*(const PetscReal *)k->ctx, &r->rectangle, &s->rectangle, k->full_space);
}

static void Surface_Bump(const SlipKernel *k, PetscReal dx, PetscReal depth_sum, PetscReal a, PetscReal b,
                         PetscReal part[2])
{
  const SlipDippingRectangle receiver = {dx, 0, 0, a, b, 0, 90}, source = {0, 0, 0, a, b, 0, 90};

  part[0] = Bump(*(const PetscReal *)k->ctx, &receiver, &source, depth_sum);
  part[1] = 0;
}

static const PetscReal Width = 100; /* [m] */
static const SlipKernelType Bumps = {.name = "bump",
                                     .components = 1,
                                     .symmetry = {SLIP_EVEN_STRIKE, SLIP_EVEN_STRIKE | SLIP_EVEN_DEPTH},
                                     .centre = Centre_Bump,
                                     .surface = Surface_Bump};
static const SlipKernel Kernel = {&Bumps, G, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, &Width};
static PetscReal Columns[5][NX * NZ];

/* Cells of one size, rows of a grid one below the other, or on two planes 100 m apart and growing with depth */
static SlipCells MakeCells(PetscBool grid, PetscReal top)
{
  SlipCells cells = CellsOfColumns(NX * NZ, Columns[0]);

  for (PetscInt e = 0; e < NX * NZ; e++) {
    const PetscInt ix = e % NX, iz = e / NX;
    const PetscReal b = grid ? 50 : 40 + iz;

    Columns[0][e] = 90 * (ix + 0.5);
    Columns[1][e] = !grid && ix % 2 ? 100 : 0;
    Columns[2][e] = top + (grid ? iz * b : 40 * iz + 0.5 * iz * (iz - 1)) + 0.5 * b;
    Columns[3][e] = 90;
    Columns[4][e] = b;
  }
  cells.kernel = Kernel;
  return cells;
}

/* (A_i K_ij + A_j K_ji) / (2 mean(A)) straight from the formula */
static Mat Direct(const SlipCells *c)
{
  PetscReal area = 0;
  PetscScalar *a;
  Mat K;

  for (PetscInt i = 0; i < c->n; i++) area += c->length[i] * c->width[i] / c->n;
  ok(MatCreateSeqDense(PETSC_COMM_SELF, c->n, c->n, NULL, &K));
  ok(MatDenseGetArrayWrite(K, &a));
  for (PetscInt i = 0; i < c->n; i++)
    for (PetscInt j = 0; j < c->n; j++) {
      const SlipDippingRectangle r = {c->x[i], c->y[i], c->z[i], c->length[i], c->width[i], 0, 90};
      const SlipDippingRectangle s = {c->x[j], c->y[j], c->z[j], c->length[j], c->width[j], 0, 90};
      const PetscBool full = c->kernel.full_space;

      a[(size_t)j * c->n + i] =
        (r.length * r.width * Expected(Width, &r, &s, full) + s.length * s.width * Expected(Width, &s, &r, full)) /
        (2 * area);
    }
  ok(MatDenseRestoreArrayWrite(K, &a));
  ok(MatAssemble(K));
  return K;
}

/* Destroys A. */
static PetscReal Distance(Mat A, Mat B)
{
  PetscReal distance, diagonal, most;
  Vec x, a, b;

  ok(MatCreateVecs(B, &x, &a));
  ok(VecDuplicate(a, &b));
  ok(VecFillSines(x));
  ok(ProductDistance(A, B, x, &distance));
  ok(MatGetDiagonal(A, a));
  ok(MatGetDiagonal(B, b));
  ok(VecNorm(b, NORM_INFINITY, &most));
  ok(VecAXPY(a, -1, b));
  ok(VecNorm(a, NORM_INFINITY, &diagonal));
  ObjectsDestroy(&x, &a, &b);
  ok(MatDestroy(&A));
  return PetscMax(distance, diagonal / most);
}

/* 1e-12: rounding of transforms of some hundred points, as of our own kernel (test_mat.c) */
static void grids(void **state)
{
  const char *const depth[] = {"auto", "blocks", "transform"};

  for (int full = 0; full < 2; full++) {
    SlipGrid grid = {NX, NZ, 90 * NX, 50 * NZ, 130, Kernel};
    SlipCells cells = MakeCells(PETSC_TRUE, grid.depth_top);
    Mat direct, K;

    cells.kernel.full_space = grid.kernel.full_space = (PetscBool)full;
    direct = Direct(&cells);
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "dense", &K));
    assert_true(Distance(K, direct) < 1e-12);
    for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(depth); t++) {
      ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K));
      ok(MatSlipStiffnessSetDepth(K, depth[t]));
      assert_true(Distance(K, direct) < 1e-12);
    }
    ok(MatDestroy(&direct));
  }
}

/* Hierarchical storage to its tolerance and not to rounding, as blocks that are far away are of low rank */
static void cells(void **state)
{
  const SlipCells cells = MakeCells(PETSC_FALSE, 20);
  Mat direct = Direct(&cells), K;
  PetscReal error;

  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 0.5, &K));
  AssertLess(Distance(K, direct), 1e-14);
  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "hmat", 1e-8, &K));
  error = Distance(K, direct);
  assert_true(error > 1e-14 && error < 1e-8);
  ok(MatDestroy(&direct));
}

/* Without a form for transforms in depth there are blocks along strike, and no operator takes the kernel apart. */
static void blocks_only(void **state)
{
  SlipKernelType type = Bumps;
  SlipGrid grid = {NX, NZ, 90 * NX, 50 * NZ, 130, Kernel};
  const SlipCells cells = MakeCells(PETSC_TRUE, grid.depth_top);
  Mat direct = Direct(&cells), K[2], H[2];

  type.surface = NULL;
  grid.kernel.type = &type;
  for (int t = 0; t < 2; t++) {
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, t ? "fft" : "dense", &K[t]));
    if (t) fails(MatSlipStiffnessSetDepth(K[t], "transform"), "\"bump\" has no transforms in depth");
    ok(MatCreateSlipViscosity(K[t], 1e7, 0.3, "sqrtm", &H[t]));
  }
  fails(MatCreateSlipViscosity(K[1], 1e7, 0.3, "toeplitz", &H[1]), "toeplitz viscosity needs");
  assert_true(Distance(H[1], H[0]) < 1e-10); /* rounding, by the condition of K of some thousand */
  ok(MatDestroy(&H[0]));
  for (int t = 0; t < 2; t++) assert_true(Distance(K[t], direct) < 1e-12);
  grid.kernel.full_space = PETSC_TRUE; /* there differences in depth are enough */
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K[1]));
  ok(MatSlipStiffnessSetDepth(K[1], "transform"));
  ObjectsDestroy(&K[1], &direct);
}

/* Components that have nothing to do with each other, and a row of normal stress */
static void Centre_Bumps(const SlipKernel *k, const SlipCell *r, const SlipCell *s, PetscReal block[])
{
  const PetscInt c = k->type->components, n = (c + k->type->normals) * c;

  for (PetscInt i = 0; i < n; i++)
    block[i] = i < c * c && i % (c + 1) ? 0 : Expected(Width, &r->rectangle, &s->rectangle, k->full_space);
}

static void Centres_Bumps(const SlipKernel *k, PetscInt n, const SlipCell r[], const SlipCell s[], PetscReal block[])
{
  for (PetscInt i = 0; i < n; i++) Centre_Bumps(k, &r[i], &s[i], block + SLIP_KERNEL_BLOCK * i);
}

/* A kernel may have more numbers in a block than an operator takes, up to twelve: each has room for all of them, which
   the sanitizers see, and takes its own. */
static void largest_blocks(void **state)
{
  SlipKernelType type = {.name = "bumps",
                         .components = 1,
                         .normals = 1,
                         .symmetry = {SLIP_EVEN_STRIKE, SLIP_EVEN_STRIKE},
                         .centre = Centre_Bumps};
  SlipGrid grid = {NX, NZ, 90 * NX, 50 * NZ, 130, Kernel};
  SlipCells cells = MakeCells(PETSC_TRUE, grid.depth_top);
  Mat direct = Direct(&cells), K, Kn;

  grid.kernel.type = &type;
  for (int t = 0; t < 2; t++) {
    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, t ? "fft" : "dense", &K));
    assert_true(Distance(K, direct) < 1e-12);
  }
  type.symmetry[0] |= SLIP_EVEN_DEPTH; /* which goes by distances alone, so that the image does not fit: no values */
  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K));
  ok(MatDestroy(&K));
  type.components = 3;
  cells.kernel.type = &type;
  for (int t = 0; t < 4; t++) {
    const PetscScalar *a, *b;
    Vec x, y, d, want;

    type.centres = t % 2 ? Centres_Bumps : NULL;
    ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &cells, t / 2 ? "hmat" : "dense", 1e-8, &K, &Kn));
    ok(MatCreateVecs(K, &x, &y));
    ok(MatCreateVecs(direct, &want, NULL));
    ok(VecDuplicate(x, &d));
    ok(MatGetDiagonal(K, d));
    ok(MatGetDiagonal(direct, want));
    a = VecRead(d);
    b = VecRead(want);
    for (PetscInt i = 0; i < 3 * NX * NZ; i++) AssertNear(a[i], b[i / 3], 1e-14 * b[i / 3]);
    ObjectsDestroy(&K, &Kn, &x, &y, &d, &want);
  }
  ok(MatDestroy(&direct));
}

static void refused(void **state)
{
  SlipKernelType type = Bumps;
  SlipGrid grid = {NX, NZ, 90 * NX, 50 * NZ, 130, Kernel};
  SlipCells cells = MakeCells(PETSC_FALSE, 20);
  Mat K = NULL;

  grid.kernel.type = cells.kernel.type = NULL;
  fails(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K), "SlipKernelStrikeSlip");
  fails(SlipCellsCheck(PETSC_COMM_SELF, &cells, "cells"), "SlipKernelStrikeSlip");
  grid.kernel = cells.kernel = Kernel;
  grid.kernel.average = cells.kernel.average = SLIP_AVERAGE_CELL;
  fails(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K), "\"bump\" knows no average");
  fails(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "hmat", 1e-8, &K), "\"bump\" knows no average");
  grid.kernel = cells.kernel = (SlipKernel){&type, G, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, &Width};
  type.symmetry[0] = 0;
  fails(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "dense", &K), "SLIP_EVEN_STRIKE");
  ok(SlipCellsCheck(PETSC_COMM_SELF, &cells, "cells"));
  type.components = 2;
  ok(SlipCellsCheck(PETSC_COMM_SELF, &cells, "cells"));
  fails(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, "dense", 1e-8, &K), "2 components of slip, expected 1");
}

SLIP_TESTS(grids, cells, blocks_only, largest_blocks, refused)
