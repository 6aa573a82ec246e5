/* PC "slipstage" on irregular cells: symmetric positive definite, few iterations whatever theta, whole or part
   sliding. */
#include "unit.h"
#include "cells.h"

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)
#define TSTAR 0.866 /* of the 3 km fault [s] */
enum { NX = 30, NZ = 22, PLANES = 2, N = NX * NZ * PLANES };

static PetscReal Data[5][N];

/* Two graded planes of 3 km, 800 m apart: lengths grow towards the ends, widths with depth, by about four. */
static SlipCells MakeCells(void)
{
  PetscReal length[NX], width[NZ], sum = 0, x, z = 0;
  PetscInt e = 0;

  for (int i = 0; i < NX; i++) sum += length[i] = 1 + 3 * PetscAbsReal(2 * i - NX + 1.0) / NX;
  for (int i = 0; i < NX; i++) length[i] *= 3000 / sum;
  sum = 0;
  for (int k = 0; k < NZ; k++) sum += width[k] = 1 + 3.0 * k / NZ;
  for (int k = 0; k < NZ; k++) width[k] *= 3000 / sum;
  for (int p = 0; p < PLANES; p++) {
    z = 0;
    for (int k = 0; k < NZ; k++) {
      x = 0;
      for (int i = 0; i < NX; i++, e++) {
        Data[0][e] = x + 0.5 * length[i];
        Data[1][e] = 800 * p;
        Data[2][e] = z + 0.5 * width[k];
        Data[3][e] = length[i];
        Data[4][e] = width[k];
        x += length[i];
      }
      z += width[k];
    }
  }
  return CellsOfColumns(N, &Data[0][0]);
}

/* J of MatCreateSlipJacobian() for B at theta: the upper part of both faults slides, weakening as in the reference
   case. */
typedef struct {
  Mat K, H, B, J;
  Vec mask, slope, b, x;
} Problem;

static void Create(const char type[], Problem *p)
{
  const SlipCells cells = MakeCells();

  ok(MatCreateSlipCellStiffness(PETSC_COMM_SELF, &cells, type, 1e-8, &p->K));
  ok(MatCreateVecs(p->K, &p->mask, &p->slope));
  ok(VecDuplicate(p->mask, &p->b));
  ok(VecDuplicate(p->mask, &p->x));
  ok(MatScale(p->K, 0.46)); /* the preconditioner must notice */
  ok(MatCreateSlipViscosity(p->K, MASS, ZETA, "sqrtm", &p->H));
  ok(MatCreateSlipStage(p->K, p->H, MASS, &p->B));
  ok(MatCreateSlipJacobian(p->B, &p->J));
}

static void Set(Problem *p, PetscReal theta, PetscReal depth)
{
  const SlipCells cells = MakeCells();
  PetscReal *m, *d, *b;

  ok(MatSlipStageSetTheta(p->B, theta));
  ok(VecGetArray(p->mask, &m));
  ok(VecGetArray(p->slope, &d));
  ok(VecGetArray(p->b, &b));
  for (PetscInt i = 0; i < N; i++) {
    const PetscReal strength = 15e3 * cells.z[i] * cells.length[i] * cells.width[i] * N / (2 * 9e6);

    m[i] = cells.z[i] < depth ? 1 : 0;
    d[i] = -0.01 * theta * strength;
    b[i] = m[i] * strength;
  }
  ok(VecRestoreArray(p->b, &b));
  ok(VecRestoreArray(p->slope, &d));
  ok(VecRestoreArray(p->mask, &m));
  ok(MatSlipJacobianSetParts(p->J, p->B, p->mask, p->slope));
}

static void Destroy(Problem *p)
{
  ok(MatDestroy(&p->J));
  ok(MatDestroy(&p->B));
  ok(MatDestroy(&p->H));
  ok(MatDestroy(&p->K));
  ok(VecDestroy(&p->mask));
  ok(VecDestroy(&p->slope));
  ok(VecDestroy(&p->b));
  ok(VecDestroy(&p->x));
}

static KSP Solver(const char pctype[])
{
  KSP ksp;
  PC pc;

  ok(KSPCreate(PETSC_COMM_SELF, &ksp));
  ok(KSPSetType(ksp, KSPCG));
  ok(KSPSetTolerances(ksp, 1e-8, 0, PETSC_DEFAULT, 1000));
  ok(KSPGetPC(ksp, &pc));
  ok(PCSetType(pc, pctype));
  return ksp;
}

static PetscInt Iterations(Problem *p, Mat A, const char pctype[])
{
  KSP ksp = Solver(pctype);
  KSPConvergedReason reason;
  PetscReal error, norm;
  PetscInt its;
  Vec r;

  ok(KSPSetOperators(ksp, A, A));
  ok(KSPSolve(ksp, p->b, p->x));
  ok(KSPGetConvergedReason(ksp, &reason));
  ok(KSPGetIterationNumber(ksp, &its));
  assert_true(reason > 0);
  ok(VecDuplicate(p->b, &r));
  ok(MatMult(A, p->x, r));
  ok(VecAXPY(r, -1, p->b));
  ok(VecNorm(r, NORM_2, &error));
  ok(VecNorm(p->b, NORM_2, &norm));
  assert_true(error < 1e-6 * norm); /* the test is of the preconditioned residual, whose condition is below 100 */
  ok(VecDestroy(&r));
  ok(KSPDestroy(&ksp));
  return its;
}

/* Whole and part sliding, theta from a tenth of T* to seven: at most 20 iterations, as every mode is covered, and from
   3 T* on at most half of the diagonal's, which grow with theta. */
static void few_iterations(void **state)
{
  const PetscReal thetas[] = {0.1, 1, 3, 7}, depths[] = {4000, 1000};
  const char *const types[] = {"dense", "hmat"};

  (void)state;
  for (int t = 0; t < 2; t++) {
    Problem p;

    Create(types[t], &p);
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(thetas); k++)
      for (size_t d = 0; d < PETSC_STATIC_ARRAY_LENGTH(depths); d++) {
        PetscInt parts, diagonal;

        Set(&p, thetas[k] * TSTAR, depths[d]);
        parts = Iterations(&p, p.J, PCSLIPSTAGE);
        diagonal = Iterations(&p, p.J, PCJACOBI);
        print_message("%s, theta %g T*, sliding to %g m: %d iterations, %d with the diagonal\n", types[t],
                      (double)thetas[k], (double)depths[d], (int)parts, (int)diagonal);
        assert_true(parts <= 20);
        if (thetas[k] >= 3) assert_true(2 * parts <= diagonal);
      }
    assert_true(2 * Iterations(&p, p.K, PCSLIPSTAGE) < Iterations(&p, p.K, PCJACOBI)); /* the critical state's solve */
    Destroy(&p);
  }
}

/* x.P y = y.P x and x.P x > 0 for vectors of all wavelengths, with a slope that exceeds B. */
static void symmetric_positive_definite(void **state)
{
  Problem p;
  KSP ksp = Solver(PCSLIPSTAGE);
  PC pc;
  Vec v[4], w[4];
  PetscReal *a;

  (void)state;
  Create("dense", &p);
  Set(&p, 5 * TSTAR, 1500);
  ok(VecScale(p.slope, 1e3));
  ok(MatSlipJacobianSetParts(p.J, p.B, p.mask, p.slope));
  ok(KSPSetOperators(ksp, p.J, p.J));
  ok(KSPSetUp(ksp));
  ok(KSPGetPC(ksp, &pc));
  for (int k = 0; k < 4; k++) {
    ok(VecDuplicate(p.b, &v[k]));
    ok(VecDuplicate(p.b, &w[k]));
    ok(VecGetArray(v[k], &a));
    for (PetscInt i = 0; i < N; i++) a[i] = PetscCosReal(0.1 + (PetscReal)i * PetscPowRealInt(0.05, k));
    ok(VecRestoreArray(v[k], &a));
    ok(PCApply(pc, v[k], w[k]));
  }
  for (int k = 0; k < 4; k++)
    for (int j = 0; j <= k; j++) {
      PetscReal one, other, size;

      ok(VecDot(v[j], w[k], &one));
      ok(VecDot(v[k], w[j], &other));
      ok(VecDot(v[k], w[k], &size));
      assert_true(size > 0);
      assert_true(PetscAbsReal(one - other) < 1e-12 * PetscMax(size, PetscAbsReal(one)));
    }
  for (int k = 0; k < 4; k++) {
    ok(VecDestroy(&v[k]));
    ok(VecDestroy(&w[k]));
  }
  ok(KSPDestroy(&ksp));
  Destroy(&p);
}

int main(int argc, char **argv)
{
  static const struct CMUnitTest tests[] = {
    cmocka_unit_test(few_iterations),
    cmocka_unit_test(symmetric_positive_definite),
  };

  return RunTests(argc, argv, tests, NULL, NULL);
}
