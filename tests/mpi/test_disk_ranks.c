/* Stages whose cells have two components, on all ranks and on this one alone, direct and by Krylov's methods, with
   prescribed cells; and the generalised Jacobian of such cells, with its preconditioner, against their definitions.
   */
#include "ranks.h"
#include "../vectors.h"

enum { cells = 9 };

/* The whole of x on each rank; from PetscMalloc() */
static PetscErrorCode Whole(Vec x, PetscReal **a)
{
  VecScatter scatter;
  PetscInt n;
  const PetscReal *p;
  Vec all;

  PetscCall(VecScatterCreateToAll(x, &scatter, &all));
  PetscCall(VecScatterBegin(scatter, x, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter, x, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecGetSize(all, &n));
  PetscCall(PetscMalloc1(n, a));
  p = VecRead(all);
  PetscCall(PetscArraycpy(*a, p, n));
  PetscCall(VecScatterDestroy(&scatter));
  return VecDestroy(&all);
}

/* Solves, checks and gives the whole x; cell fixed has x = (0.1, -0.2). The worst cell is one of the stage. */
static PetscErrorCode Solve(MPI_Comm comm, const VectorsNumbers *s, const char *type, PetscBool direct, PetscInt fixed,
                            PetscReal **x)
{
  const PetscReal start[] = {0.1, -0.2};
  SNESConvergedReason reason;
  PetscInt worst;
  PetscBool holds;
  Vectors p;
  SNES snes;
  Vec v, r;

  PetscCall(VectorsCreate(comm, s, &p));
  p.fixed = fixed;
  PetscCall(DuplicateVecs(p.l.load, &v, &r));
  for (PetscInt i = 0; i < 2 * s->n; i++) PetscCall(VecSetValue(v, i, start[i % 2], INSERT_VALUES));
  PetscCall(VecAssemble(v));
  PetscCall(VectorsCreateSolver(&p, type, direct, &snes));
  PetscCall(VectorsSolve(&p, snes, v, r, &reason));
  PetscCall(SNESSlipGetWorstCell(snes, &worst, NULL));
  Check(reason > 0, "law %" PetscInt_FMT " by %s, direct %d: %s", s->law, type, (int)direct,
        SNESConvergedReasons[reason]);
  Check(worst >= 0 && worst < s->n, "the worst cell is %" PetscInt_FMT, worst);
  PetscCall(VectorsHold(&p, v, r, &holds));
  Check(holds, "law %" PetscInt_FMT " has no solution", s->law);
  PetscCall(Whole(v, x));
  Check(fixed < 0 || ((*x)[2 * fixed] == start[0] && (*x)[2 * fixed + 1] == start[1]), "the prescribed cell moves");
  PetscCall(DestroyObjects(&snes, &v, &r));
  return VectorsDestroy(&p);
}

/* 1e-8: each solution is within the residual tolerance of 1e-10 times a condition number of about 100; projection,
   which no step polishes, for the constant bound. */
static PetscErrorCode TestSolutions(void)
{
  uint64_t seed = 5;

  for (PetscInt trial = 0; trial < 4 * VECTORS_LAWS; trial++) {
    const PetscInt law = trial % VECTORS_LAWS, fixed = VectorsIsSmooth(law) && trial >= 2 * VECTORS_LAWS ? 6 : -1;
    PetscReal *x[4] = {NULL}, size = 0;
    VectorsNumbers s;
    PetscInt n = 3;

    PetscCall(VectorsRandomNumbers(cells, 2, law, &seed, &s));
    s.friction *= 0.1; /* far from where stages have no solution */
    PetscCall(Solve(PETSC_COMM_SELF, &s, SNESSEMISMOOTH, PETSC_TRUE, fixed, &x[0]));
    PetscCall(Solve(PETSC_COMM_WORLD, &s, SNESSEMISMOOTH, PETSC_TRUE, fixed, &x[1]));
    PetscCall(Solve(PETSC_COMM_WORLD, &s, SNESSEMISMOOTH, PETSC_FALSE, fixed, &x[2]));
    if (law == VECTORS_CONSTANT && s.theta < 1)
      PetscCall(Solve(PETSC_COMM_WORLD, &s, SNESPROJECTION, PETSC_TRUE, fixed, &x[n++]));
    for (PetscInt i = 0; i < 2 * cells; i++) size = PetscMax(size, PetscAbsReal(x[0][i]));
    for (PetscInt k = 1; k < n; k++)
      for (PetscInt i = 0; i < 2 * cells; i++)
        Check(PetscAbsReal(x[k][i] - x[0][i]) <= 1e-8 * size,
              "trial %" PetscInt_FMT ", law %" PetscInt_FMT ", way %" PetscInt_FMT ": %.12g instead of %.12g", trial,
              law, k, (double)x[k][i], (double)x[0][i]);
    for (PetscInt k = 0; k < n; k++) PetscCall(PetscFree(x[k]));
    PetscCall(VectorsFreeNumbers(&s));
  }
  return PETSC_SUCCESS;
}

/* The Jacobian and the preconditioner of the last Krylov solve, found where the solver has them: J e_j is column j of
   B + slope in rows and columns that slide and of the identity in others; P (diag(B) + slope) = I cell by cell, as no
   slope here takes nine tenths of diag(B) away. Sums of few terms: rounding, over the largest entry. */
static PetscErrorCode TestJacobian(void)
{
  uint64_t seed = 23;
  PetscInt first, last, N = 2 * cells, sliding = 0;
  PetscReal *m, *d, *c, *diagonal;
  SNESConvergedReason reason;
  Vec mask, slope, cross, diag, x, r, e, y;
  VectorsNumbers s;
  Vectors p;
  SNES snes;
  Mat J, B;
  KSP ksp;
  PC pc;

  PetscCall(VectorsRandomNumbers(cells, 2, VECTORS_WEAKENING, &seed, &s));
  for (PetscInt i = 0; i < N; i++) s.load[i] *= i == 4 || i == 5 ? 0.01 : 3; /* one sticks */
  PetscCall(VectorsCreate(PETSC_COMM_WORLD, &s, &p));
  PetscCall(MatCreateVecs(p.l.B, &x, &r));
  PetscCall(MatCreateVecs(p.l.B, &e, &y));
  PetscCall(VectorsCreateSolver(&p, SNESSEMISMOOTH, PETSC_FALSE, &snes));
  PetscCall(VectorsSolve(&p, snes, x, r, &reason));
  Check(reason > 0, "%s", SNESConvergedReasons[reason]);
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetOperators(ksp, &J, NULL));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(MatSlipJacobianGetParts(J, &B, &mask, &slope));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipCross", (PetscObject *)&cross));
  Check(B == p.l.B && cross, "the parts are not composed");
  PetscCall(MatSlipJacobianSetParts(J, B, mask, slope)); /* for the preconditioner: they have changed since */
  PetscCall(PCSetUp(pc));
  PetscCall(VecDuplicate(x, &diag));
  PetscCall(MatGetDiagonal(B, diag));
  PetscCall(Whole(mask, &m));
  PetscCall(Whole(slope, &d));
  PetscCall(Whole(cross, &c));
  PetscCall(Whole(diag, &diagonal));
  PetscCall(VecGetOwnershipRange(y, &first, &last));
  for (PetscInt j = 0; j < N; j++) {
    const PetscInt other = j ^ 1;
    const PetscReal *a;

    sliding += m[j] != 0;
    PetscCall(VecZeroEntries(e));
    PetscCall(VecSetValue(e, j, 1, INSERT_VALUES));
    PetscCall(VecAssemble(e));
    PetscCall(MatMult(J, e, y));
    a = VecRead(y);
    for (PetscInt i = first; i < last; i++) {
      PetscReal expected = m[i] * m[j] * s.B[i * N + j];

      if (i == j) expected = m[i] != 0 ? expected + d[i] : 1;
      if (i == other) expected += m[i] * c[i / 2];
      PetscCheck(PetscAbsReal(a[i - first] - expected) <= 1e-12 * (1 + PetscAbsReal(expected)), PETSC_COMM_SELF,
                 PETSC_ERR_USER, "J(%" PetscInt_FMT ",%" PetscInt_FMT ") is %g instead of %g", i, j,
                 (double)a[i - first], (double)expected);
    }
    PetscCall(VecSetValue(e, j, m[j] != 0 ? diagonal[j] + d[j] : 1, INSERT_VALUES));
    if (m[j] != 0) PetscCall(VecSetValue(e, other, c[j / 2], INSERT_VALUES));
    PetscCall(VecAssemble(e));
    PetscCall(PCApply(pc, e, y));
    a = VecRead(y);
    for (PetscInt i = first; i < last; i++)
      Check(PetscAbsReal(a[i - first] - (i == j)) <= 1e-11, "P J(%" PetscInt_FMT ",%" PetscInt_FMT ") is %g", i, j,
            (double)a[i - first]);
  }
  Check(sliding > 4 && sliding < N, "%" PetscInt_FMT " components slide", sliding);
  PetscCall(PetscFree(m));
  PetscCall(PetscFree(d));
  PetscCall(PetscFree(c));
  PetscCall(PetscFree(diagonal));
  PetscCall(DestroyObjects(&x, &r, &e, &y, &diag, &snes));
  return VectorsDestroyAll(&p);
}

/* Pairs of cells, on different ranks where there are several, whose motion swings and fades, or swings and grows, while
   the sum of the matrix's diagonal, in rows of different units, says the opposite: T (2 - w + C) T, C skew, the same
   wherever cells slide forwards. One is solved, the other not. */
static PetscErrorCode TestSwingingPairs(void)
{
  const PetscReal w[][2] = {{3, 0}, {2.5, 1.75}}, t[][2] = {{3, 1}, {1, 3}};
  const PetscInt n = 8;

  for (int k = 0; k < 2; k++) {
    SNESConvergedReason reason;
    uint64_t seed = 3;
    VectorsNumbers s;
    Vectors p;
    SNES snes;
    Vec x, r;

    PetscCall(VectorsRandomNumbers(n, 1, VECTORS_COUPLED, &seed, &s));
    PetscCall(PetscArrayzero(s.B, n * n));
    PetscCall(PetscArrayzero(s.C, n * n));
    s.omega = s.friction = 1;
    for (PetscInt i = 0; i < n; i++) {
      const PetscInt side = i < n / 2 ? 0 : 1, other = n - 1 - i;
      const PetscReal own = PetscSqr(t[k][side]);

      s.B[(n + 1) * i] = 2 * own;
      s.C[(n + 1) * i] = -w[k][side] * own;
      s.C[n * i + other] = (side ? -2 : 2) * t[k][0] * t[k][1];
      s.strength[i] = 1;
      /* of x = 0.01 / t everywhere */
      s.load[i] = 1 + 0.01 * t[k][side] * (2 - w[k][side] + (side ? -2 : 2));
    }
    PetscCall(VectorsCreate(PETSC_COMM_WORLD, &s, &p));
    PetscCall(DuplicateVecs(p.l.load, &x, &r));
    PetscCall(VecSet(x, 0.01));
    PetscCall(VectorsCreateSolver(&p, SNESSEMISMOOTH, PETSC_TRUE, &snes));
    PetscCall(VectorsSolve(&p, snes, x, r, &reason));
    Check(k ? reason == SNES_DIVERGED_LINEAR_SOLVE : reason > 0, "pairs that %s: %s", k ? "grow" : "fade",
          SNESConvergedReasons[reason]);
    PetscCall(DestroyObjects(&snes, &x, &r));
    PetscCall(VectorsDestroyAll(&p));
  }
  return PETSC_SUCCESS;
}

static PetscErrorCode Run(void)
{
  PetscCall(SlipStepInitializePackage());
  PetscCall(TestSolutions());
  PetscCall(TestJacobian());
  return TestSwingingPairs();
}

SLIP_RANKS(Run)
