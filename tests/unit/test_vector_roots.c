/* Viscosities and stage operators of slip as a vector: roots by every method that needs no grid, radiation, stages and
   their solves. */
#include "unit.h"
#include "products.h"
#include "cells.h"
#include "tempdir.h"
#include <math.h>

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)
enum { NX = 9, NZ = 8, N = 2 * NX * NZ, T = 2 * N };

static PetscReal rectangle_data[8 * N], triangle_data[TRIANGLE_COLUMNS * T];

/* Two planes of rectangles whose widths differ, so that rows are weighted; or of triangles */
static SlipCells Mesh(PetscBool triangles)
{
  SlipCells c = TwoDippingPlanes(NX, NZ, rectangle_data);

  if (triangles) {
    c = TrianglesOf(&c, triangle_data);
    c.kernel.type = &SlipKernelTriangleVector;
    return c;
  }
  for (PetscInt e = 0; e < N; e++) rectangle_data[4 * N + e] = 60 + 2 * (PetscReal)(e / NX % NZ);
  c.kernel.type = &SlipKernelDippingVector;
  return c;
}

static SlipDippingGrid Grid(void)
{
  return (SlipDippingGrid){.grid = {NX, NZ, 900, 640, 0, Mesh(PETSC_FALSE).kernel}, .dip = 50};
}

/* The stiffness of a mesh or of a grid, by type */
static Mat Stiffness(const char kind[], const char type[])
{
  const SlipDippingGrid grid = Grid();
  Mat S;

  if (!strcmp(kind, "grid"))
    ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, type, &S, NULL));
  else {
    const SlipCells cells = Mesh((PetscBool)!strcmp(kind, "triangles"));

    ok(MatCreateSlipCellVectorStiffness(PETSC_COMM_SELF, &cells, type, 1e-10, &S, NULL));
  }
  return S;
}

static const struct {
  const char *kind, *type;
} Kinds[] = {{"rectangles", "dense"}, {"rectangles", "hmat"}, {"triangles", "dense"},
             {"triangles", "hmat"},   {"grid", "dense"},      {"grid", "fft"}};

/* H W^-1 H = 4 zeta^2 M S, W the weights: the root of all components at once, dense. To 1e-11: eigenvalues span three
   decades. A root by Lanczos' method has the same products, to its tolerance of 1e-8. */
static void roots(void **state)
{
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Kinds); k++) {
    Mat S = Stiffness(Kinds[k].kind, Kinds[k].type), H, L;
    PetscReal error;
    Vec weights, x, y, z, d;

    ok(MatSlipGetWeights(S, &weights));
    assert_true((weights != NULL) == !strcmp(Kinds[k].kind, "rectangles"));
    ok(MatCreateSlipViscosity(S, MASS, ZETA, "sqrtm", &H));
    ok(MatCreateVecs(S, &x, &y));
    VecsDuplicate(x, &z, &d);
    ok(VecFillSines(x));
    ok(MatMult(H, x, y));
    if (weights) ok(VecPointwiseDivide(y, y, weights));
    ok(MatMult(H, y, z));
    ok(MatMult(S, x, y));
    ok(VecScale(y, 4 * ZETA * ZETA * MASS));
    AssertVecClose(z, y, NORM_2, 1e-11);
    ok(MatCreateSlipViscosity(S, MASS, ZETA, "lanczos", &L));
    ok(ProductDistance(L, H, x, &error));
    assert_true(error < 1e-8);
    /* its diagonal is an estimate, for preconditioners: of both components */
    ok(MatGetDiagonal(H, y));
    ok(MatGetDiagonal(L, d));
    ok(VecPointwiseDivide(d, d, y));
    ok(VecShift(d, -1));
    ok(VecNorm(d, NORM_INFINITY, &error));
    assert_true(error < 0.1);
    ObjectsDestroy(&x, &y, &z, &d, &H, &L, &S);
  }
}

/* What needs a grid with one component says so. */
static void roots_refused(void **state)
{
  Mat S = Stiffness("grid", "fft"), H = NULL;

  fails(MatCreateSlipViscosity(S, MASS, ZETA, "spectral", &H), "spectral viscosity needs");
  fails(MatCreateSlipViscosity(S, MASS, ZETA, "toeplitz", &H), "toeplitz viscosity needs");
  ok(MatDestroy(&S));
}

/* Many rows are by Lanczos' method where the stiffness is not dense. */
static void many_rows(void **state)
{
  const SlipDippingGrid grid = {.grid = {32, 16, 3200, 1280, 0, Mesh(PETSC_FALSE).kernel}, .dip = 50};
  PetscBool match;
  Mat S, H;

  ok(MatCreateSlipDippingVectorStiffness(PETSC_COMM_SELF, &grid, "auto", &S, NULL));
  ok(MatCreateSlipViscosity(S, MASS, ZETA, "sqrtm", &H));
  ok(PetscObjectTypeCompare((PetscObject)H, "sliplanczos", &match));
  assert_true(match);
  ObjectsDestroy(&S, &H);
}

/* eta w on both components */
static void radiation(void **state)
{
  const PetscReal eta = 4.3e6;

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Kinds); k++) {
    Mat S = Stiffness(Kinds[k].kind, Kinds[k].type), H;
    PetscReal error, norm;
    Vec weights, x, y;

    ok(MatSlipGetWeights(S, &weights));
    ok(MatCreateSlipRadiation(S, eta, &H));
    ok(MatCreateVecs(S, &x, &y));
    ok(VecFillSines(x));
    ok(MatMult(H, x, y));
    if (weights) ok(VecPointwiseDivide(y, y, weights));
    ok(VecNorm(x, NORM_2, &norm));
    ok(VecAXPY(y, -eta, x));
    ok(VecNorm(y, NORM_2, &error));
    assert_true(error < 1e-14 * eta * norm);
    ObjectsDestroy(&x, &y, &H, &S);
  }
}

/* B x = (M / theta) w x + H x + theta S x, and its diagonal; conjugate gradients with the preconditioner of stages
   solve with it to what they are asked for. Without inertia too, where radiation lets solvers ask for entries. */
static void stages(void **state)
{
  const PetscReal theta = 0.02, eta = 4.3e6;

  for (size_t k = 0; k < 3 * PETSC_STATIC_ARRAY_LENGTH(Kinds); k++) {
    const PetscReal mass = k % 3 == 2 ? 0 : MASS;
    Mat S = Stiffness(Kinds[k / 3].kind, Kinds[k / 3].type), H, B;
    Vec weights, x, y, z, d;
    KSP ksp;
    PC pc;

    if (k % 3 == 2)
      ok(MatCreateSlipRadiation(S, eta, &H));
    else
      ok(MatCreateSlipViscosity(S, MASS, ZETA, k % 3 ? "lanczos" : "sqrtm", &H));
    ok(MatCreateSlipStage(S, H, mass, &B));
    ok(MatSlipStageSetTheta(B, theta));
    ok(MatSlipGetWeights(S, &weights));
    ok(MatCreateVecs(S, &x, &y));
    VecsDuplicate(x, &z, &d);
    ok(VecFillSines(x));
    for (int diagonal = 0; diagonal < 2; diagonal++) {
      if (diagonal)
        ok(MatGetDiagonal(S, y));
      else
        ok(MatMult(S, x, y));
      ok(VecScale(y, theta));
      if (diagonal)
        ok(MatGetDiagonal(H, z));
      else
        ok(MatMult(H, x, z));
      ok(VecAXPY(y, 1, z));
      if (diagonal)
        ok(VecSet(d, 1));
      else
        ok(VecCopy(x, d));
      if (weights) ok(VecPointwiseMult(d, d, weights));
      ok(VecAXPY(y, mass / theta, d));
      if (diagonal)
        ok(MatGetDiagonal(B, z));
      else
        ok(MatMult(B, x, z));
      AssertVecClose(z, y, NORM_2, (k % 3 == 1 ? 2e-8 : 1e-13)); /* Lanczos' method: twice its tolerance */
    }
    ok(MatMult(B, x, y));
    ok(KSPCreate(PETSC_COMM_SELF, &ksp));
    ok(KSPSetOperators(ksp, B, B));
    ok(KSPSetType(ksp, KSPCG));
    ok(KSPGetPC(ksp, &pc));
    ok(PCSetType(pc, PCSLIPSTAGE));
    ok(KSPSetTolerances(ksp, 1e-7, PETSC_DEFAULT, PETSC_DEFAULT, 500));
    ok(KSPSolve(ksp, y, z));
    AssertVecClose(z, x, NORM_2, 1e-4); /* by the condition of B, some hundred */
    ObjectsDestroy(&x, &y, &z, &d, &B, &H, &S);
    ok(KSPDestroy(&ksp));
  }
}

SLIP_TESTS(roots, roots_refused, many_rows, radiation, stages)
