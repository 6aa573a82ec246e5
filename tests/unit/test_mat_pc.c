/* PC "slipstage": symmetric positive definite on every sliding set, few iterations of CG, the right solution. */
#include "unit.h"

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

/* The Jacobian on the sliding set as the cone solvers define it, written out here so that this room is tested alone. */
typedef struct {
  Mat B, J;
  Vec mask, slope, work;
  PetscInt n;
} Problem;

static PetscErrorCode JacobianMult(Mat J, Vec x, Vec y)
{
  Problem *p;
  const PetscReal *m, *d, *px;
  PetscReal *py;

  PetscCall(MatShellGetContext(J, &p));
  PetscCall(VecPointwiseMult(p->work, p->mask, x));
  PetscCall(MatMult(p->B, p->work, y));
  m = VecRead(p->mask);
  d = VecRead(p->slope);
  px = VecRead(x);
  PetscCall(VecGetArray(y, &py));
  for (PetscInt i = 0; i < p->n; i++) py[i] = m[i] * py[i] + d[i] * m[i] * px[i] + (1 - m[i]) * px[i];
  return VecRestoreArray(y, &py);
}

static Mat StageOf(PetscInt n, const char *type)
{
  const SlipGrid grid = {n, n, 3000.0, 3000.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
  Mat K, H, B;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, type, &K));
  ok(MatScale(K, 0.46));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  ObjectsDestroy(&K, &H);
  return B;
}

/* share of cells sliding at random; slip weakening (mu_s - mu_d) / d_c of 15 kPa/m * depth, times weakening */
static Problem *CreateProblem(Mat B, PetscReal theta, PetscReal share, PetscReal weakening)
{
  Problem *p;
  PetscRandom random;
  PetscReal *m, *d;

  ok(PetscNew(&p));
  p->B = B;
  ok(MatSlipStageSetTheta(B, theta));
  ok(MatGetSize(B, &p->n, NULL));
  ok(MatCreateVecs(B, &p->mask, &p->slope));
  ok(VecDuplicate(p->mask, &p->work));
  ok(PetscRandomCreate(PETSC_COMM_SELF, &random));
  ok(PetscRandomSetSeed(random, 7));
  ok(PetscRandomSeed(random));
  ok(VecSetRandom(p->mask, random));
  ok(PetscRandomDestroy(&random));
  ok(VecGetArray(p->mask, &m));
  ok(VecGetArray(p->slope, &d));
  for (PetscInt i = 0; i < p->n; i++) {
    m[i] = m[i] < share ? 1 : 0;
    d[i] = -theta * weakening * 15e3 * 3000.0 * (i + 0.5) / p->n;
  }
  ok(VecRestoreArray(p->mask, &m));
  ok(VecRestoreArray(p->slope, &d));
  ok(MatCreateShell(PETSC_COMM_SELF, p->n, p->n, p->n, p->n, p, &p->J));
  ok(MatShellSetOperation(p->J, MATOP_MULT, SlipMatShellFn(JacobianMult)));
  ok(PetscObjectCompose((PetscObject)p->J, "SlipStageOperator", (PetscObject)B));
  ok(PetscObjectCompose((PetscObject)p->J, "SlipMask", (PetscObject)p->mask));
  ok(PetscObjectCompose((PetscObject)p->J, "SlipSlope", (PetscObject)p->slope));
  return p;
}

static void DestroyProblem(Problem *p)
{
  ObjectsDestroy(&p->J, &p->mask, &p->slope, &p->work);
  ok(PetscFree(p));
}

/* Iterations of CG for 1e-8; the true residual is checked as well. */
static PetscInt Solve(Problem *p, const char *pctype)
{
  KSP ksp;
  PC pc;
  Vec x, b, r;
  PetscReal bnorm;
  PetscInt its;
  KSPConvergedReason reason;

  ok(MatCreateVecs(p->B, &x, &b));
  ok(VecDuplicate(b, &r));
  for (PetscInt i = 0; i < p->n; i++) ok(VecSetValue(b, i, 1 + PetscSinReal(3.0 * i), INSERT_VALUES));
  ok(VecPointwiseMult(b, b, p->mask));
  ok(KSPCreate(PETSC_COMM_SELF, &ksp));
  ok(KSPSetOperators(ksp, p->J, p->J));
  ok(KSPSetType(ksp, KSPCG));
  ok(KSPSetNormType(ksp, KSP_NORM_NATURAL));
  ok(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 500));
  ok(KSPGetPC(ksp, &pc));
  ok(PCSetType(pc, pctype));
  ok(KSPSetFromOptions(ksp));
  ok(KSPSolve(ksp, b, x));
  ok(KSPGetConvergedReason(ksp, &reason));
  assert_true(reason > 0);
  ok(KSPGetIterationNumber(ksp, &its));
  ok(MatMult(p->J, x, r));
  ok(VecNorm(b, NORM_2, &bnorm));
  /* the natural norm fell by 1e-8; the 2-norm may differ by the root of the condition of J, at most about 10 here */
  AssertVecNear(r, b, NORM_2, 1e-6 * bnorm);
  ObjectsDestroy(&ksp, &x, &b, &r);
  return its;
}

/* Bounds: what was measured plus two; without a preconditioner the last rows take 25 and more. */
static void test_iterations(void **state)
{
  static const struct {
    PetscReal theta, share, weakening;
    PetscInt most;
  } rows[] = {
    {0.0025, 1.0, 0.3, 4}, {0.0025, 0.5, 0.3, 4}, {0.1, 1.0, 0.3, 8},  {0.1, 0.5, 0.3, 8},
    {0.5, 1.0, 0.3, 10},   {0.5, 0.5, 0.3, 14},   {1.5, 1.0, 0.0, 11}, {1.5, 0.9, 0.3, 16},
  };

  for (PetscInt n = 25; n <= 50; n += 25) {
    Mat B = StageOf(n, "fft");

    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
      Problem *p = CreateProblem(B, rows[k].theta, rows[k].share, rows[k].weakening);
      const PetscInt its = Solve(p, PCSLIPSTAGE);

      assert_true(its <= rows[k].most);
      DestroyProblem(p);
    }
    ok(MatDestroy(&B));
  }
}

/* Smallest even length of at least n with no prime factor above 5, which is what the transforms are padded to. */
static PetscInt Padded(PetscInt n)
{
  for (n += n % 2;; n += 2) {
    PetscInt rest = n;

    while (rest % 2 == 0) rest /= 2;
    while (rest % 3 == 0) rest /= 3;
    while (rest % 5 == 0) rest /= 5;
    if (rest == 1) return n;
  }
}

/* sum over dx, dz of even a[P + 1][Q + 1] on a torus of 2 P x 2 Q cells at wavenumbers k, l. */
static PetscReal Cosines(PetscInt P, PetscInt Q, const PetscReal a[], PetscInt k, PetscInt l)
{
  PetscReal sum = 0;

  for (PetscInt i = 0; i < 2 * P; i++)
    for (PetscInt j = 0; j < 2 * Q; j++)
      sum += a[PetscMin(i, 2 * P - i) * (Q + 1) + PetscMin(j, 2 * Q - j)] * PetscCosReal(PETSC_PI * k * i / P) *
             PetscCosReal(PETSC_PI * l * j / Q);
  return sum;
}

/* P of a stage by the symbol against k(x - x', z - z') + k(x - x', z + z') of toeplitz_root.c, k by plain sums over the
   torus of an endless plane that is repeated: at the surface, with 2 cells between the fault and its image, and in a
   full space, where there is none. Odd and even numbers of cells. Rounding of sums of some 10^3 terms. */
static void test_symbol_by_plain_sums(void **state)
{
  static const struct {
    SlipGrid grid;
    PetscInt gap; /* -1: no image */
  } rows[] = {{{5, 7, 3000.0, 3500.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)}, 0},
              {{6, 8, 3000.0, 4000.0, 500.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)}, 2},
              {{7, 5, 3000.0, 2500.0, 0.0, ROCK(0.25, PETSC_TRUE, SLIP_AVERAGE_CENTRE)}, -1}};
  const PetscReal theta = 0.4;

  for (size_t r = 0; r < PETSC_STATIC_ARRAY_LENGTH(rows); r++) {
    const SlipGrid *g = &rows[r].grid;
    const PetscInt nx = g->nx, nz = g->nz, gap = rows[r].gap, N = nx * nz;
    const PetscInt P = Padded(2 * nx - 1) / 2, Q = Padded(gap < 0 ? nz : 2 * nz + gap);
    PetscReal *kernel, *f, worst = 0, size = 0;
    const PetscScalar *got;
    Mat K, H, B;
    Vec e, y;
    PC pc;

    assert_int_equal(PetscMalloc2((P + 1) * (Q + 1), &kernel, (P + 1) * (Q + 1), &f), PETSC_SUCCESS);
    for (PetscInt i = 0; i <= P; i++)
      for (PetscInt j = 0; j <= Q; j++)
        kernel[i * (Q + 1) + j] = SlipKernelFullSpace(30e9, 0.25, i * g->length_x / nx, j * g->length_z / nz,
                                                      g->length_x / nx, g->length_z / nz);
    for (PetscInt k = 0; k <= P; k++)
      for (PetscInt l = 0; l <= Q; l++) {
        const PetscReal S = PetscMax(0, Cosines(P, Q, kernel, k, l));

        f[k * (Q + 1) + l] = 1 / (MASS / theta + 2 * ZETA * PetscSqrtReal(MASS * S) + theta * S);
      }
    for (PetscInt i = 0; i <= P; i++)
      for (PetscInt j = 0; j <= Q; j++) kernel[i * (Q + 1) + j] = Cosines(P, Q, f, i, j) / (4 * P * Q);

    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, g, "fft", &K));
    ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
    ok(MatCreateSlipStage(K, H, MASS, &B));
    ok(MatSlipStageSetTheta(B, theta));
    ok(PCCreate(PETSC_COMM_SELF, &pc));
    ok(PCSetOperators(pc, B, B));
    ok(PCSetType(pc, PCSLIPSTAGE));
    ok(MatCreateVecs(B, &e, &y));
    for (PetscInt j = 0; j < N; j++) {
      ok(VecSet(e, 0));
      ok(VecSetValue(e, j, 1, INSERT_VALUES));
      ok(PCApply(pc, e, y));
      got = VecRead(y);
      for (PetscInt i = 0; i < N; i++) {
        const PetscInt dx = PetscAbsInt(i % nx - j % nx), iz = i / nx, jz = j / nx;
        PetscReal want = kernel[dx * (Q + 1) + PetscAbsInt(iz - jz)];

        if (gap >= 0) want += kernel[dx * (Q + 1) + iz + jz + 1 + gap];
        worst = PetscMax(worst, PetscAbsReal(got[i] - want));
        size = PetscMax(size, PetscAbsReal(want));
      }
    }
    AssertLess(worst, 1e-13 * size);
    ObjectsDestroy(&pc, &e, &y, &B, &H, &K);
    ok(PetscFree2(kernel, f));
  }
}

/* x'Py = y'Px and x'Px > 0, with the slope so strong that J itself is indefinite. */
static void test_symmetric_positive_definite(void **state)
{
  static const char *const types[] = {"fft", "dense"};

  for (int t = 0; t < 2; t++) {
    Mat B = StageOf(12, types[t]);
    Problem *p = CreateProblem(B, 2.0, 0.6, 30.0);
    Vec x, y, Px, Py;
    PC pc;
    PetscScalar xPy, yPx, xPx;

    ok(MatCreateVecs(B, &x, &y));
    VecsDuplicate(x, &Px, &Py);
    ok(PCCreate(PETSC_COMM_SELF, &pc));
    ok(PCSetOperators(pc, p->J, p->J));
    ok(PCSetType(pc, PCSLIPSTAGE));
    ok(PCSetUp(pc));
    for (int k = 0; k < 20; k++) {
      for (PetscInt i = 0; i < p->n; i++) {
        ok(VecSetValue(x, i, PetscSinReal(1.0 + 0.1 * (k + 1) * i), INSERT_VALUES));
        ok(VecSetValue(y, i, PetscCosReal(2.0 + 0.3 * (k + 2) * i), INSERT_VALUES));
      }
      ok(PCApply(pc, x, Px));
      ok(PCApply(pc, y, Py));
      ok(VecDot(x, Py, &xPy));
      ok(VecDot(y, Px, &yPx));
      ok(VecDot(x, Px, &xPx));
      assert_true(xPx > 0);
      assert_true(PetscAbsReal(xPy - yPx) < 1e-12 * xPx); /* rounding */
    }
    ObjectsDestroy(&pc, &x, &y, &Px, &Py);
    DestroyProblem(p);
    ok(MatDestroy(&B));
  }
}

/* A stiffness alone: the inverse of the plane's symbol, so that the number of iterations hardly grows with the grid
   (for 1e-7 at 200 x 200 it takes 10 where the inverse diagonal takes 75). Bound: the 10 measured here and a half
   more. */
static void test_stiffness_alone(void **state)
{
  for (PetscInt n = 25; n <= 100; n *= 2) {
    const SlipGrid grid = {n, n, 3000.0, 3000.0, 0.0, ROCK(0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE)};
    Mat K;
    Vec x, b;
    KSP ksp;
    PC pc;
    KSPConvergedReason reason;
    PetscInt its;

    ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &K));
    ok(MatCreateVecs(K, &x, &b));
    for (PetscInt i = 0; i < n * n; i++) ok(VecSetValue(b, i, 1 + PetscSinReal(3.0 * i), INSERT_VALUES));
    ok(KSPCreate(PETSC_COMM_SELF, &ksp));
    ok(KSPSetOperators(ksp, K, K));
    ok(KSPSetType(ksp, KSPCG));
    ok(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 500));
    ok(KSPGetPC(ksp, &pc));
    ok(PCSetType(pc, PCSLIPSTAGE));
    ok(KSPSolve(ksp, b, x));
    ok(KSPGetConvergedReason(ksp, &reason));
    ok(KSPGetIterationNumber(ksp, &its));
    assert_true(reason > 0 && its <= 15);
    ObjectsDestroy(&ksp, &x, &b, &K);
  }
}

/* A stage operator without a grid behind it (entries from elsewhere) gets the inverse diagonal. */
static void test_diagonal_without_grid(void **state)
{
  const PetscReal entries[] = {4e6, 1e6, 0, 1e6, 3e6, 5e5, 0, 5e5, 2e6};
  const PetscInt row = 1;
  PetscScalar got, diagonal, one = 1;
  Mat K, H, B;
  Vec x, y;
  PC pc;

  ok(MatCreateSlipStiffnessFromEntries(PETSC_COMM_SELF, 3, entries, "test", &K));
  ok(MatCreateSlipViscosity(K, MASS, ZETA, "sqrtm", &H));
  ok(MatCreateSlipStage(K, H, MASS, &B));
  ok(MatSlipStageSetTheta(B, 0.5));
  ok(MatCreateVecs(B, &x, &y));
  ok(VecSetValues(x, 1, &row, &one, INSERT_VALUES));
  ok(PCCreate(PETSC_COMM_SELF, &pc));
  ok(PCSetOperators(pc, B, B));
  ok(PCSetType(pc, PCSLIPSTAGE));
  ok(PCApply(pc, x, y));
  ok(VecGetValues(y, 1, &row, &got));
  ok(MatGetDiagonal(B, x));
  ok(VecGetValues(x, 1, &row, &diagonal));
  assert_true(PetscAbsReal(got * diagonal - 1) < 1e-14);
  ObjectsDestroy(&pc, &x, &y, &B, &H, &K);
}

/* Its options are its own, with its prefix; a type that was given up is refused by name. */
static void test_options(void **state)
{
  Mat B = StageOf(8, "fft");
  PC pc;

  ok(PCCreate(PETSC_COMM_SELF, &pc));
  ok(PCSetOptionsPrefix(pc, "own_"));
  ok(PCSetOperators(pc, B, B));
  ok(PCSetType(pc, PCSLIPSTAGE));
  ok(PetscOptionsSetValue(NULL, "-own_pc_slipstage_type", "symbol"));
  ok(PetscOptionsSetValue(NULL, "-pc_slipstage_type", "blocks")); /* another's */
  ok(PCSetFromOptions(pc));
  ok(PetscOptionsSetValue(NULL, "-own_pc_slipstage_type", "blocks"));
  fails(PCSetFromOptions(pc), "-own_pc_slipstage_type is \"blocks\"");
  ok(PetscOptionsClear(NULL));
  ObjectsDestroy(&pc, &B);
}

SLIP_TESTS(test_iterations, test_options, test_symbol_by_plain_sums, test_symmetric_positive_definite,
           test_stiffness_alone, test_diagonal_without_grid)
