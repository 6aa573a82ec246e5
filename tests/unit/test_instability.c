/* Stages that go past an instability, against eigenvalues that are known by construction: stages of cells with linear
   weakening and linear coupling, whose Jacobian B - W + C is the same everywhere. */
#include "unit.h"
#include "linear.h"
#include <math.h>

enum { N = 16 };

/* q = 100 - w |x| + C x of cells that all slide, with two components along (1, -1) */
typedef struct {
  LinearSystem l;
  PetscInt components, nfree; /* the first cells have no strength */
  PetscReal omega;
  Vec weakening, start; /* w, and that of the stage's start */
  Vec solution, work;
  Mat C;
  SlipConstraint con;
} Modes;

static PetscErrorCode Bound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  const Modes *p = (const Modes *)ctx;
  const PetscInt c = p->components;
  const PetscReal *xx, *w;
  PetscReal *qq;
  PetscInt n;

  PetscCall(MatMult(p->C, x, q));
  if (dq) {
    PetscCall(VecCopy(p->weakening, dq));
    PetscCall(VecScale(dq, -1));
  }
  PetscCall(VecGetLocalSize(q, &n));
  xx = VecRead(x);
  w = VecRead(p->weakening);
  PetscCall(VecGetArray(q, &qq));
  for (PetscInt i = 0; i < n; i++)
    qq[i] += 100 - w[i] * (c == 1 ? PetscAbsReal(xx[i]) : hypot(xx[2 * i], xx[2 * i + 1]));
  for (PetscInt i = 0; i < p->nfree; i++) qq[i] = 0;
  return VecRestoreArray(q, &qq);
}

/* G(x) = B (x - solution) - q(solution), q along x */
static PetscErrorCode Residual(SlipConstraint con, Vec x, Vec g, void *ctx)
{
  Modes *p = (Modes *)ctx;
  const PetscInt c = p->components;
  const PetscReal *q;
  PetscReal *a;
  PetscInt n;
  Vec strength;

  PetscCall(VecDuplicate(p->weakening, &strength));
  PetscCall(Bound(con, p->solution, strength, NULL, ctx));
  PetscCall(VecWAXPY(p->work, -1, p->solution, x));
  PetscCall(MatMult(p->l.B, p->work, g));
  PetscCall(VecGetLocalSize(g, &n));
  q = VecRead(strength);
  PetscCall(VecGetArray(g, &a));
  for (PetscInt i = 0; i < n; i++) a[i] -= p->omega * q[i / c] * (c == 1 ? 1 : PetscSqrtReal(0.5) * (i % 2 ? -1 : 1));
  PetscCall(VecRestoreArray(g, &a));
  return VecDestroy(&strength);
}

static PetscErrorCode StartSlope(SlipConstraint con, Vec dq, void *ctx)
{
  PetscCall(VecCopy(((const Modes *)ctx)->start, dq));
  return VecScale(dq, -1);
}

static PetscErrorCode Coupling(SlipConstraint con, Mat *C, Vec a, void *ctx)
{
  *C = ((const Modes *)ctx)->C;
  return VecSet(a, 1);
}

/* B and C by rows, n x n, and x of n cells; without a coupling C = 0 is not mentioned; start NULL: as w; eta > 0: so
   much of B's diagonal is that of a stage of the library, beside its stiffness */
typedef struct {
  PetscInt n, components, nfree;                        /* components 0: one */
  PetscBool coupled, direct, go_on, ends;               /* ends: before the first iteration */
  PetscReal B[N * N], C[N * N], w[N], x[N], eta, omega; /* omega 0: one; w and C are times it */
  const PetscReal *start;
} Case;

/* Blocks of c x d, down diagonals a_ij */
static Mat Dense(PetscInt n, PetscInt c, PetscInt d, const PetscReal a[], PetscReal less)
{
  Mat A;

  ok(MatCreateSeqDense(PETSC_COMM_SELF, c * n, d * n, NULL, &A));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++)
      for (PetscInt k = 0; k < PetscMin(c, d); k++)
        ok(MatSetValue(A, c * i + k, d * j + k, a[i * n + j] - (i == j ? less : 0), INSERT_VALUES));
  ok(MatAssemble(A));
  return A;
}

/* c numbers a cell, of alternating sign */
static Vec Column(PetscInt n, PetscInt c, const PetscReal a[])
{
  Vec v;

  ok(VecCreateSeq(PETSC_COMM_SELF, c * n, &v));
  for (PetscInt i = 0; i < c * n; i++) ok(VecSetValue(v, i, i % c ? -a[i / c] : a[i / c], INSERT_VALUES));
  ok(VecAssemble(v));
  return v;
}

/* Was the stage refused, or not solved where stages go on? Else its solution is x, to a residual of 1e-10 of 100 or so
   over the least eigenvalue, a tenth. */
static PetscBool Refused(const Case *c)
{
  const PetscInt components = PetscMax(c->components, 1);
  const SlipConstraintOps ops = {.residual = Residual,
                                 .jacobian = LinearJacobian,
                                 .bound = Bound,
                                 .start_slope = StartSlope,
                                 .coupling = c->coupled ? Coupling : NULL};
  const SlipStage stage = {.theta = 1, .omega = c->omega > 0 ? c->omega : 1};
  Modes p = {.l = {.B = Dense(c->n, components, components, c->B, c->eta)},
             .omega = stage.omega,
             .C = Dense(c->n, 1, components, c->C, 0),
             .components = components,
             .nfree = c->nfree,
             .weakening = Column(c->n, 1, c->w),
             .start = Column(c->n, 1, c->start ? c->start : c->w),
             .solution = Column(c->n, components, c->x)};
  Mat K = p.l.B, H = NULL;
  SNESConvergedReason reason;
  PetscBool refused, again;
  PetscInt iterations;
  char rows[16];
  SNES snes;
  KSP ksp;
  Vec x, r;

  if (c->eta > 0) {
    ok(MatCreateSlipRadiation(K, c->eta, &H));
    ok(MatCreateSlipStage(K, H, 0, &p.l.B));
    ok(MatSlipStageSetTheta(p.l.B, 1));
    ObjectsDestroy(&K, &H);
  }
  ok(MatScale(p.C, 1 / p.omega));
  ok(VecScale(p.weakening, 1 / p.omega));
  ok(VecScale(p.start, 1 / p.omega));
  VecsDuplicate(p.solution, &p.work, &x, &r);
  ok(SlipConstraintCreate(PETSC_COMM_SELF, &ops, &p, x, &p.con));
  ok(SlipConstraintSetComponents(p.con, components, p.weakening));
  ok(SlipConstraintSetRefuseUnstable(p.con, c->go_on ? PETSC_FALSE : PETSC_TRUE));
  ok(PetscSNPrintf(rows, sizeof(rows), "%" PetscInt_FMT, c->direct ? components * c->n : 0));
  ok(CreateSolver(p.con, SNESSEMISMOOTH, rows, &snes));
  if (c->ends) ok(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 0, PETSC_DEFAULT));
  ok(VecCopy(p.solution, x));
  ok(VecScale(x, 0.9));
  ok(SNESSlipSolveStage(snes, &stage, x, r, NULL));
  ok(SNESGetConvergedReason(snes, &reason));
  ok(SlipConstraintWasUnstable(p.con, &refused));
  if (c->go_on) {
    assert_false(refused);
    assert_true(reason > 0 || reason == SNES_DIVERGED_LINEAR_SOLVE);
    refused = reason < 0 ? PETSC_TRUE : PETSC_FALSE;
  }
  if (c->ends) assert_true(reason == SNES_DIVERGED_MAX_IT && !refused);
  ok(SNESGetKSP(snes, &ksp));
  ok(KSPGetTotalIterations(ksp, &iterations));
  assert_int_equal(iterations == 0, c->direct || c->ends);
  assert_true(refused || c->ends ? reason < 0 : reason > 0);
  if (reason > 0) AssertVecNear(x, p.solution, NORM_INFINITY, 1e-7);
  if (refused && !c->go_on) { /* of this stage, not of the next */
    ok(SlipConstraintSetRefuseUnstable(p.con, PETSC_FALSE));
    ok(VecCopy(p.solution, x));
    ok(SNESSlipSolveStage(snes, &stage, x, r, NULL));
    ok(SlipConstraintWasUnstable(p.con, &again));
    assert_false(again);
  }
  ObjectsDestroy(&snes, &p.l.B, &p.C, &p.weakening, &p.start, &p.solution, &p.work, &x, &r);
  ok(SlipConstraintDestroy(&p.con));
  return refused;
}

/* C = S Q diag(value) Q' S^-1 - B + W, so that B - W + C has these eigenvalues; Q: the cosine transform, S: stretch^(i
   / N) */
static void Similar(Case *c, const PetscReal value[], PetscReal stretch)
{
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < N; j++) {
      PetscReal a = 0;

      for (PetscInt k = 0; k < N; k++)
        a += value[k] * (k ? 2.0 : 1.0) / N * cos(PETSC_PI * k * (i + 0.5) / N) * cos(PETSC_PI * k * (j + 0.5) / N);
      c->C[i * N + j] = a * pow(stretch, (PetscReal)(i - j) / N) - c->B[i * N + j] + (i == j ? c->w[i] : 0);
    }
}

/* The first column of the symmetric circulant matrix, or the odd one, with the eigenvalues, or their imaginary parts,
   value[k] of the modes k and N - k */
static void Circulant(const PetscReal value[], PetscBool odd, PetscReal a[])
{
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < N; j++) {
      PetscReal sum = 0;

      for (PetscInt k = 0; k < N; k++) {
        const PetscReal v = value[PetscMin(k, N - k)], angle = 2 * PETSC_PI * k * (i - j) / N;

        sum += odd ? (k > N / 2 ? -v : v) * -sin(angle) / N : v * cos(angle) / N;
      }
      a[i * N + j] = sum;
    }
}

enum { FAR, FAR_COUPLED, NEAR, NEAR_COUPLED, NEAR_DOWN, NEAR_UP, SWINGING, KINDS };

/* A case with m unstable modes, which have the real part -0.25 or less, others 0.25 or more.
   FALSE: not of this kind */
static PetscBool Make(int kind, PetscInt m, Case *c)
{
  PetscReal value[N], odd[N] = {0};

  *c = (Case){.n = N, .coupled = kind == FAR || kind == NEAR ? PETSC_FALSE : PETSC_TRUE};
  for (PetscInt i = 0; i < N; i++) {
    c->x[i] = 1 + 0.5 * sin(3.0 * (PetscReal)i);
    c->B[i * N + i] = 2;
    value[i] = 0.25 + 0.5 * (PetscReal)(i - m);
    c->w[i] = 1;
  }
  switch (kind) {
  case FAR: /* nothing but themselves */
  case FAR_COUPLED:
    for (PetscInt i = 0; i < N; i++) {
      c->w[i] = i % 3 == 1 && i / 3 < m ? 2.25 : 1.75;
      for (PetscInt j = 0; j < N && kind == FAR_COUPLED; j++) c->C[i * N + j] = i == j ? 0 : 1e-9 * (PetscReal)(i - j);
    }
    break;
  case NEAR: /* the values of B - W */
    Similar(c, value, 1);
    for (PetscInt i = 0; i < N * N; i++) {
      c->B[i] += c->C[i];
      c->C[i] = 0;
    }
    for (PetscInt i = 0; i < N; i++) { /* weaker, and stiffer, so that B is positive definite */
      c->w[i] += 4;
      c->B[i * N + i] += 4;
    }
    break;
  case NEAR_COUPLED:
    Similar(c, value, 2);
    break;
  case NEAR_DOWN: /* far from a positive symmetric part, stable or not: cells act on those after them, or before */
  case NEAR_UP:
    Similar(c, value, kind == NEAR_DOWN ? 30 : 1 / 30.0);
    break;
  default: /* pairs of modes k and N - k with the imaginary parts +- 1, of which none passes zero */
    if (m % 2) return PETSC_FALSE;
    for (PetscInt k = 0; k <= N / 2; k++) {
      value[k] = k ? 2 + 0.5 * (PetscReal)k : 7;
      odd[k] = k && 2 * k < N ? 1 : 0;
    }
    Circulant(value, PETSC_FALSE, c->B);
    Circulant(odd, PETSC_TRUE, c->C);
    for (PetscInt i = 0; i < N; i++) c->w[i] = 2.25 + 0.25 * (PetscReal)m;
  }
  return PETSC_TRUE;
}

/* LU, Cholesky, GMRES and CG refuse the stages that have an unstable mode, and no other; where nothing weakens they are
   not solved, as neither the matrix nor that with a frozen bound leads anywhere. */
static void modes_are_counted(void **state)
{
  Case c;

  for (int kind = 0; kind < KINDS; kind++)
    for (PetscInt m = 0; m <= 4; m++) {
      PetscBool refused[4];
      const int ways = kind == FAR || kind == NEAR ? 2 : 4;

      if (!Make(kind, m, &c)) continue;
      for (int k = 0; k < ways; k++) {
        c.direct = k % 2 ? PETSC_FALSE : PETSC_TRUE;
        for (PetscInt i = 0; i < N && k == 2; i++) {
          c.C[(N + 1) * i] -= c.w[i];
          c.w[i] = 0;
          c.go_on = PETSC_TRUE;
        }
        refused[k] = Refused(&c);
      }
      for (int k = 0; k < ways; k++) assert_true(refused[k] == (m > 0));
    }
}

/* All modes are unstable: conjugate gradients see no change of sign. */
static void every_mode(void **state)
{
  Case c = {.n = 2, .B = {2, 0, 0, 2}, .w = {3, 3}, .x = {1, 1.5}};

  for (int k = 0; k < 2; k++) {
    c.direct = k ? PETSC_FALSE : PETSC_TRUE;
    assert_true(Refused(&c));
  }
}

/* A positive symmetric part needs no eigenvalues, and an odd number of unstable modes is known from the determinant;
   the eigenvalues, of which there are others to refuse an even number, cost 10 N^3. */
static void odd_numbers_cost_no_eigenvalues(void **state)
{
  PetscLogDouble flops[3], before;
  Case c;

  for (PetscInt m = 0; m <= 2; m++) {
    assert_true(Make(m ? NEAR_COUPLED : FAR_COUPLED, m, &c));
    c.direct = PETSC_TRUE;
    ok(PetscGetFlops(&before));
    assert_true(Refused(&c) == (m > 0));
    ok(PetscGetFlops(&flops[m]));
    flops[m] -= before;
  }
  assert_true(flops[0] < 9.0 * N * N * N);
  assert_true(flops[2] - flops[1] > 9.0 * N * N * N);
}

/* A mode and its mirror image go past an instability with the weakening of the start alone, while all else, the load,
   the solution and both slopes, is the same in all cells; with two components slip is along (1, -1). Bounds of half the
   strength act twice. */
static void start_counts_in_every_mode(void **state)
{
  Case c;
  PetscReal start[N];

  for (int k = 0; k < 8; k++) {
    (void)Make(SWINGING, 0, &c);
    c.components = k < 4 ? 1 : 2;
    c.omega = 2;
    for (PetscInt i = 0; i < N * N && c.components == 2; i++) c.C[i] = 0;
    for (PetscInt i = 0; i < N; i++) {
      c.x[i] = 1;
      start[i] = k % 2 ? 2.75 : 2.4; /* 2.5 is what holds that mode */
    }
    c.start = start;
    c.direct = k % 4 < 2 ? PETSC_TRUE : PETSC_FALSE;
    assert_true(Refused(&c) == (k % 2 != 0));
  }
}

/* It is the slope over the diagonal of B that counts, whatever the units, and where it changes its sign; what has not
   converged is not asked. */
static void start_counts_if_the_end_is_known(void **state)
{
  Case c;
  PetscReal start[N];

  for (int k = 0; k < 3; k++) {
    const PetscReal unit = k == 0 ? 1e-4 : 1;

    (void)Make(SWINGING, 0, &c);
    for (PetscInt i = 0; i < N * N; i++) {
      c.B[i] *= unit;
      c.C[i] *= unit;
    }
    for (PetscInt i = 0; i < N; i++) {
      c.x[i] = 1;
      c.w[i] = k == 1 ? -2.75 : unit * c.w[i];
      start[i] = unit * 2.75;
    }
    c.start = start;
    c.direct = PETSC_TRUE;
    c.ends = k == 2 ? PETSC_TRUE : PETSC_FALSE;
    assert_true(Refused(&c) == (k < 2));
  }
}

/* What the bound of a cell without strength would gain, an instability, does not count: its row is that of B. */
static void rows_without_strength(void **state)
{
  Case c = {.n = 2, .nfree = 1, .coupled = PETSC_TRUE, .B = {2, 0.5, 0.5, 2}, .C = {0, 0, 0, 1}, .x = {1, 1}};

  for (int k = 0; k < 8; k++) {
    c.components = 1 + k % 4 / 2;
    c.direct = k % 2 ? PETSC_FALSE : PETSC_TRUE;
    c.C[0] = k < 4 ? 8 : -8;
    assert_false(Refused(&c));
  }
}

/* Two cells whose mode swings, and grows or not as 4 - w1 - w2 says, in other units of their rows: B - W + C becomes T
   (B - W + C) T. The sum of its diagonal says the opposite; with eta so does that over the diagonal of the stiffness
   alone. One that swings on without growing is refused. */
static void units_do_not_matter(void **state)
{
  const PetscReal w[][2] = {{3, 0}, {2.5, 1.75}, {2.5, 1}, {2, 2}}, t[][2] = {{3, 1}, {1, 3}, {1, 3}, {1, 1}},
                  eta[] = {0, 0, 1.9, 0};

  for (int k = 0; k < 4; k++) {
    Case c = {.n = 2, .coupled = PETSC_TRUE, .direct = PETSC_TRUE, .eta = eta[k]};

    for (PetscInt i = 0; i < 2; i++) {
      c.x[i] = 1 / t[k][i];
      c.B[3 * i] = 2 * t[k][i] * t[k][i];
      c.w[i] = w[k][i] * t[k][i] * t[k][i];
      c.C[1 + i] = (i ? -2 : 2) * t[k][0] * t[k][1];
    }
    assert_true(Refused(&c) == (k % 2 != 0));
  }
}

SLIP_TESTS(modes_are_counted, every_mode, odd_numbers_cost_no_eigenvalues, start_counts_in_every_mode,
           start_counts_if_the_end_is_known, rows_without_strength, units_do_not_matter)
