/* Stages whose cells have two components: against those with one, in turned axes, by both solvers, with models, and
   10,000 random ones;
   -stages sets their number. */
#include "unit.h"
#include "vectors.h"

/* The largest of |a - b|, and of |a| */
static PetscReal Distance(Vec a, Vec b, PetscReal *size)
{
  PetscReal d;
  Vec e;

  ok(VecDuplicate(a, &e));
  ok(VecWAXPY(e, -1, a, b));
  ok(VecNorm(e, NORM_INFINITY, &d));
  ok(VecNorm(a, NORM_INFINITY, size));
  ok(VecDestroy(&e));
  return d;
}

/* A stage from a guess of this size in all cells; x and r are new. Whether it converged, and was refused */
static PetscBool Solve(Vectors *p, const char *type, PetscBool direct, PetscReal guess, Vec *x, Vec *r, PetscInt *its,
                       PetscBool *refused)
{
  SNESConvergedReason reason;
  SNES snes;

  ok(VecDuplicate(p->l.load, x));
  ok(VecDuplicate(p->l.load, r));
  ok(VecCopy(p->l.load, *x));
  ok(VecNormalize(*x, NULL));
  ok(VecScale(*x, guess));
  ok(VectorsCreateSolver(p, type, direct, &snes));
  ok(VectorsSolve(p, snes, *x, *r, &reason));
  ok(SNESGetIterationNumber(snes, its));
  ok(SlipConstraintWasUnstable(p->con, refused));
  ok(SNESDestroy(&snes));
  return reason > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Everything along one axis: the numbers of one component, 1e-13 of the largest; across the axis nothing but the
   rounding of LU. Refused stages are the same ones. Bounds that depend on other cells can have two solutions, and two
   components, which do more against cycles, may find the other one: stages that take another number of iterations do
   not count there. */
static void along_one_axis(void **state)
{
  uint64_t seed = 7;
  PetscInt solved = 0, unstable = 0, its, other;

  for (int trial = 0; trial < 400; trial++) {
    const PetscInt n = 1 + trial % 5, axis = trial / 5 % 2, law = trial % VECTORS_LAWS;
    const PetscReal *one, *two;
    VectorsNumbers s, v;
    Vectors p, w;
    PetscBool done, same, refused, also;
    PetscReal size;
    Vec x, r, y, f;

    ok(VectorsRandomNumbers(n, 1, law, &seed, &s));
    ok(VectorsRandomNumbers(n, 2, law, &seed, &v));
    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt j = 0; j < n; j++) {
        PetscReal *row = &v.B[(2 * i + axis) * 2 * n];

        row[2 * j + axis] = s.B[i * n + j];
        row[2 * j + 1 - axis] = 0;
        v.B[(2 * i + 1 - axis) * 2 * n + 2 * j + axis] = 0;
        v.C[i * 2 * n + 2 * j + axis] = s.C[i * n + j];
      }
      v.load[2 * i + axis] = s.load[i];
      v.load[2 * i + 1 - axis] = 0;
      v.strength[i] = s.strength[i];
      v.B[(2 * i + 1 - axis) * (2 * n + 1)] = 0.5 * s.B[i * (n + 1)]; /* the smaller of both, so that D is the same */
      for (PetscInt j = 0; j < n; j++)
        if (i != j) v.B[(2 * i + 1 - axis) * 2 * n + 2 * j + 1 - axis] = 0;
    }
    v.theta = s.theta, v.omega = s.omega, v.drop = s.drop, v.slip = s.slip, v.friction = s.friction, v.v0 = s.v0;
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    ok(VectorsCreate(PETSC_COMM_SELF, &v, &w));
    ok(SlipConstraintSetRefuseUnstable(p.con, trial % 3 ? PETSC_TRUE : PETSC_FALSE));
    ok(SlipConstraintSetRefuseUnstable(w.con, trial % 3 ? PETSC_TRUE : PETSC_FALSE));
    done = Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 0.1, &x, &r, &its, &refused);
    same = Solve(&w, SNESSEMISMOOTH, PETSC_TRUE, 0.1, &y, &f, &other, &also);
    if (VectorsIsCoupled(law) && its != other) done = same = refused = also = PETSC_FALSE;
    assert_true(done == same && refused == also);
    ok(VecNorm(x, NORM_INFINITY, &size));
    one = VecRead(x);
    two = VecRead(y);
    for (PetscInt i = 0; i < n && done; i++) {
      AssertNear(two[2 * i + axis], one[i], 1e-13 * size);
      AssertNear(two[2 * i + 1 - axis], 0, 1e-15 * size);
    }
    solved += done;
    unstable += refused;
    ObjectsDestroy(&x, &r, &y, &f);
    ok(VectorsDestroyAll(&p));
    ok(VectorsDestroyAll(&w));
  }
  printf("%d of 400 stages solved, %d refused\n", (int)solved, (int)unstable);
  assert_true(solved > 300 && unstable > 5);
}

/* Axes of each cell turned by an angle of its own turn the solution: 1e-10 of the largest, as much as the solver's
   tolerance allows of stages that are not close to an instability. */
static void turned_axes(void **state)
{
  uint64_t seed = 11;
  PetscInt solved = 0, its;

  for (int trial = 0; trial < 300; trial++) {
    const PetscInt n = 1 + trial % 5, N = 2 * n, law = trial % VECTORS_LAWS;
    VectorsNumbers s, v;
    Vectors p, w;
    PetscBool done, also, unused;
    PetscReal R[10][10] = {{0}}, size, d;
    Vec x, r, y, f, e;

    ok(VectorsRandomNumbers(n, 2, law, &seed, &s));
    ok(VectorsRandomNumbers(n, 2, law, &seed, &v));
    for (PetscInt i = 0; i < N; i += 2) {
      const PetscReal angle = 6.3 * VectorsRandom(&seed);

      R[i][i] = R[i + 1][i + 1] = cos(angle);
      R[i][i + 1] = -sin(angle);
      R[i + 1][i] = sin(angle);
    }
    for (PetscInt i = 0; i < N; i++) {
      v.load[i] = 0;
      for (PetscInt k = 0; k < N; k++) v.load[i] += R[i][k] * s.load[k];
      for (PetscInt j = 0; j < N; j++) {
        v.B[i * N + j] = 0;
        for (PetscInt k = 0; k < N; k++)
          for (PetscInt l = 0; l < N; l++) v.B[i * N + j] += R[i][k] * s.B[k * N + l] * R[j][l];
      }
    }
    for (PetscInt i = 0; i < n; i++) {
      v.strength[i] = s.strength[i];
      for (PetscInt j = 0; j < N; j++) {
        v.C[i * N + j] = 0;
        for (PetscInt k = 0; k < N; k++) v.C[i * N + j] += s.C[i * N + k] * R[j][k];
      }
    }
    v.theta = s.theta, v.omega = s.omega, v.drop = s.drop, v.slip = s.slip, v.friction = s.friction, v.v0 = s.v0;
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    ok(VectorsCreate(PETSC_COMM_SELF, &v, &w));
    ok(SlipConstraintSetRefuseUnstable(p.con, PETSC_TRUE)); /* of several solutions the axes may choose */
    ok(SlipConstraintSetRefuseUnstable(w.con, PETSC_TRUE));
    done = Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 0.1, &x, &r, &its, &unused);
    also = Solve(&w, SNESSEMISMOOTH, PETSC_TRUE, 0.1, &y, &f, &its, &unused);
    if (done && also) {
      const PetscReal *a;
      PetscReal *b;

      ok(VecDuplicate(x, &e));
      a = VecRead(x);
      ok(VecGetArray(e, &b));
      for (PetscInt i = 0; i < N; i++) {
        b[i] = 0;
        for (PetscInt k = 0; k < N; k++) b[i] += R[i][k] * a[k];
      }
      ok(VecRestoreArray(e, &b));
      d = Distance(y, e, &size);
      assert_true(d <= 1e-10 * size);
      solved++;
      ok(VecDestroy(&e));
    }
    ObjectsDestroy(&x, &r, &y, &f);
    ok(VectorsDestroyAll(&p));
    ok(VectorsDestroyAll(&w));
  }
  printf("%d of 300 stages solved\n", (int)solved);
  assert_true(solved > 250);
}

/* Random stages of all laws, direct and by Krylov's methods, from guesses over ten decades: cells stick at exactly
   zero, or r = -q x / |x| to rounding, and the balance is what the tolerance of 1e-10 leaves after x was turned along
   n (the entries of theta K are up to 100). A bound may depend on other cells as much as B does, and weaken: such
   stages need not have a solution (with one component a third more of them fail). Without that all converge. Three in
   ten are solved by the projection too, with the same result where the bound is constant. */
static void random_stages(void **state)
{
  PetscInt stages = 10000, different[VECTORS_LAWS] = {0}, failed[VECTORS_LAWS] = {0}, tried[VECTORS_LAWS] = {0},
           compared = 0, its;
  uint64_t seed = 3;

  ok(PetscOptionsGetInt(NULL, NULL, "-stages", &stages, NULL));
  for (PetscInt trial = 0; trial < stages; trial++) {
    const PetscInt n = 1 + trial % 7, law = trial % VECTORS_LAWS;
    const PetscBool direct = trial % 4 ? PETSC_TRUE : PETSC_FALSE;
    VectorsNumbers s;
    Vectors p;
    PetscReal size;
    PetscBool unused, holds;
    Vec x, r, y, f;

    ok(VectorsRandomNumbers(n, 2, law, &seed, &s));
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    if (VectorsIsSmooth(law) && trial % 11 == 0) p.fixed = 0;
    tried[law]++;
    if (!Solve(&p, SNESSEMISMOOTH, direct, VectorsLogRandom(&seed, 1e-10, 1), &x, &r, &its, &unused)) {
      failed[law]++;
      ObjectsDestroy(&x, &r);
      ok(VectorsDestroyAll(&p));
      continue;
    }
    ok(VectorsHold(&p, x, r, &holds));
    assert_true(holds);
    if (trial % 10 < 3 && !VectorsIsSmooth(law)) {
      if (Solve(&p, SNESPROJECTION, direct, 0, &y, &f, &its, &unused)) {
        const PetscReal d = Distance(x, y, &size);

        compared++;
        if (d > 1e-6 * PetscMax(size, 1e-3)) different[law]++; /* 1e-10 over the smallest eigenvalue of B, 0.01 */
      }
      ObjectsDestroy(&y, &f);
    }
    ObjectsDestroy(&x, &r);
    ok(VectorsDestroyAll(&p));
  }
  for (int law = 0; law < VECTORS_LAWS; law++)
    printf("law %d: %d of %d failed\n", law, (int)failed[law], (int)tried[law]);
  printf("%d compared with projection, %d differ\n", (int)compared,
         (int)(different[VECTORS_WEAKENING] + different[VECTORS_COUPLED]));
  assert_int_equal(different[VECTORS_CONSTANT], 0);
  assert_true(different[VECTORS_WEAKENING] + different[VECTORS_COUPLED] <= compared / 100);
  assert_true(compared >= stages / 5);
  for (int law = 0; law < VECTORS_LAWS; law++)
    assert_true(failed[law] <=
                (VectorsIsCoupled(law) ? tried[law] / 30 : tried[law] / 10000)); /* 2 in 100,000 in all */
}

/* A square of cells that act on each other as on a fault, with 1/r^3 and the more the more they slide towards each
   other: loaded in its middle beyond the strength, in directions that differ from cell to cell */
static void Square(PetscInt side, PetscInt c, PetscInt law, PetscReal theta, VectorsNumbers *s)
{
  const PetscInt n = side * side, N = c * n;
  uint64_t seed = 5;

  *s = (VectorsNumbers){.n = n, .c = c, .law = law, .theta = theta, .omega = 1};
  s->drop = 0.5, s->slip = 10, s->friction = 0.3, s->v0 = 1e-8;
  ok(PetscMalloc4(N * N, &s->B, N, &s->load, n * N, &s->C, n, &s->strength));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal x = (PetscReal)(i % side) - 0.5 * (PetscReal)side,
                    y = (PetscReal)(i / side) - 0.5 * (PetscReal)side;
    const PetscReal size = 1.6 * exp(-8 * (x * x + y * y) / (PetscReal)n), angle = 0.3 + 0.1 * x + VectorsRandom(&seed);

    s->strength[i] = 0.8 + 0.4 * VectorsRandom(&seed);
    s->load[c * i] = size * cos(angle);
    if (c == 2) s->load[c * i + 1] = size * sin(angle);
    for (PetscInt j = 0; j < n; j++) {
      const PetscReal d[] = {(PetscReal)(i % side - j % side), (PetscReal)(i / side - j / side)}, r = hypot(d[0], d[1]);

      for (PetscInt k = 0; k < c; k++)
        for (PetscInt l = 0; l < c; l++) {
          const PetscReal same = k == l,
                          K = i == j ? 4 * same : -(0.125 * same + 0.375 * d[k] * d[l] / (r * r)) / (r * r * r);

          s->B[(c * i + k) * N + c * j + l] = theta * K + (i == j ? same * (0.3 / theta + 0.3) : 0);
          if (k == 0) s->C[i * N + c * j + l] = i == j ? 0 : 0.3 * theta * d[l] / (r * r * r * r);
        }
    }
  }
}

/* Many cells that act as those of a fault take as few iterations as with one component, however long the stage: at
   most 5 (4), and as many where there are 20 x 20. */
static void many_cells(void **state)
{
  for (int law = 0; law < VECTORS_LAWS; law++)
    for (PetscReal theta = 0.01; theta < 200; theta *= 100)
      for (int direct = 0; direct < 2; direct++) {
        PetscInt its[2];

        for (PetscInt c = 1; c <= 2; c++) {
          PetscBool unused, holds;
          VectorsNumbers s;
          Vectors p;
          Vec x, r;

          Square(8, c, law, theta, &s);
          ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
          assert_true(Solve(&p, SNESSEMISMOOTH, direct ? PETSC_TRUE : PETSC_FALSE, 1e-6, &x, &r, &its[c - 1], &unused));
          ok(VectorsHold(&p, x, r, &holds));
          assert_true(holds);
          ObjectsDestroy(&x, &r);
          ok(VectorsDestroyAll(&p));
        }
        assert_true(its[0] <= 6 && its[1] <= 6);
      }
}

static PetscErrorCode Approximation(Mat B, Mat *A)
{
  return PetscObjectQuery((PetscObject)B, "A", (PetscObject *)A);
}

/* Newton's steps with B / (1 - 0.05) for B, on models of the stage: each leaves about 0.05 of the residual, and the
   solution is that of B, 1e-8 for stages with a condition number of up to 1e2. One of 0.9 is given up after four. */
static void approximate_operator(void **state)
{
  for (int law = 0; law < 2 * VECTORS_LAWS; law++)
    for (PetscReal theta = 0.01; theta < 200; theta *= 100) {
      PetscBool unused;
      PetscInt its;
      PetscReal size;
      VectorsNumbers s;
      Vectors p;
      Vec x, y, r, f;
      Mat A;

      Square(8, 1 + law % 2, law / 2, theta, &s);
      ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
      assert_true(Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 1e-6, &x, &r, &its, &unused));
      ok(MatDuplicate(p.l.B, MAT_COPY_VALUES, &A));
      ok(MatScale(A, 1 / (1 - 0.05)));
      ok(PetscObjectCompose((PetscObject)p.l.B, "A", (PetscObject)A));
      ok(PetscObjectComposeFunction((PetscObject)p.l.B, "MatSlipGetApproximation_C", Approximation));
      assert_true(Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 1e-6, &y, &f, &its, &unused));
      assert_true(its <= 16);
      assert_true(Distance(x, y, &size) <= 1e-8 * size);
      ObjectsDestroy(&y, &f);
      ok(MatScale(A, (1 - 0.05) / (1 - 0.9)));
      assert_true(Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 1e-6, &y, &f, &its, &unused));
      if (!VectorsIsSmooth(law / 2)) assert_true(its <= 4 + 6);
      assert_true(Distance(x, y, &size) <= 1e-8 * size);
      ObjectsDestroy(&x, &y, &r, &f, &A);
      ok(VectorsDestroyAll(&p));
    }
}

/* A guess and no iteration: cells with one component, two, and those that open, each by itself, the first of which
   sticks and the second slides, in units of rho = 1 / diag(B), for both components of a cell of the larger entry.
   Strengths are 0.5 and 0.3, with omega = 2, a pull of 3 on the second, or a pressure of 4 that friction is a quarter
   of what it has without: the scale is 1 and 3, or 4. First the guess, 4 = 8 / 2 of it, is the largest residual, then
   the pull less its strength, 2.4, then what 1.5 / rho is across. */
static void residual_of_a_guess(void **state)
{
  const PetscReal guess[3][3] = {{0.5, 0, 0}, {0, 0, 0}, {0, 0, 1.5}}, largest[] = {4, 2.4, 6};
  uint64_t seed = 1;

  for (PetscInt c = 1; c <= 3; c++)
    for (int k = 0; k < c; k++) {
      const PetscReal scale = c < 3 ? 4 : 5;
      SNESConvergedReason reason;
      VectorsNumbers s;
      PetscInt cell;
      PetscReal residual, *a;
      Vectors p;
      SNES snes;
      Vec x, r;

      ok(VectorsRandomNumbers(2, c, c < 3 ? VECTORS_CONSTANT : VECTORS_FRICTION, &seed, &s));
      s.theta = 1, s.omega = 2;
      s.strength[0] = c < 3 ? 0.5 : 0.25, s.strength[1] = c < 3 ? 0.3 : 0.15;
      for (PetscInt i = 0; i < 4 * c * c; i++) s.B[i] = 0;
      for (PetscInt i = 0; i < 2 * c; i++) {
        s.B[(2 * c + 1) * i] = c == 1 || i == 1 || i == c ? 8 : i % c == 2 ? 4 : 2;
        s.load[i] = i % c == 2 ? -4 : 0;
      }
      s.load[0] = 0.1, s.load[c + (c > 1)] = 3; /* along the entry 2, as the one of the larger entry does not tell */
      ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
      ok(VectorsCreateSolver(&p, SNESSEMISMOOTH, PETSC_TRUE, &snes));
      ok(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 0, PETSC_DEFAULT));
      VecsDuplicate(p.l.load, &x, &r);
      ok(VecZeroEntries(x));
      ok(VecGetArray(x, &a));
      if (k == 0) a[c > 1] = guess[0][0];
      if (k == 2) a[5] = guess[2][2];
      ok(VecRestoreArray(x, &a));
      ok(VectorsSolve(&p, snes, x, r, &reason));
      assert_int_equal(reason, SNES_DIVERGED_MAX_IT);
      ok(SNESSlipGetWorstCell(snes, &cell, &residual));
      AssertNear(residual, largest[k] / scale, 1e-14);
      assert_int_equal(cell, k > 0);
      ObjectsDestroy(&snes, &x, &r);
      ok(VectorsDestroyAll(&p));
    }
}

static PetscInt updates; /* of the last solve */

static PetscErrorCode Count(SNES snes, PetscInt it)
{
  updates++;
  return PETSC_SUCCESS;
}

/* Cells that slide in one stage and all stick in the next one of the same solver, from a guess, are at rest after one
   iteration: what they moved by before does not count. B is diagonal. SNESSetUpdate() is heard in every iteration. */
static void stage_after_another(void **state)
{
  uint64_t seed = 1;

  for (PetscInt c = 1; c <= 2; c++) {
    SNESConvergedReason reason;
    VectorsNumbers s;
    PetscReal size;
    PetscInt its;
    Vectors p;
    SNES snes;
    Vec x, r;

    ok(VectorsRandomNumbers(2, c, VECTORS_CONSTANT, &seed, &s));
    for (PetscInt i = 0; i < 4 * c * c; i++) s.B[i] = i % (2 * c + 1) ? 0 : 2;
    for (PetscInt i = 0; i < 2 * c; i++) s.load[i] = 10;
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    ok(VectorsCreateSolver(&p, SNESSEMISMOOTH, PETSC_TRUE, &snes));
    ok(SNESSetUpdate(snes, Count));
    VecsDuplicate(p.l.load, &x, &r);
    for (int k = 0; k < 2; k++) {
      updates = 0;
      ok(VecSet(x, 1));
      ok(VectorsSolve(&p, snes, x, r, &reason));
      assert_true(reason > 0);
      ok(VecNorm(x, NORM_INFINITY, &size));
      assert_true(k ? size == 0 : size > 1);
      ok(VecSet(p.l.load, 0.01));
    }
    ok(SNESGetIterationNumber(snes, &its));
    assert_true(its == 1 && updates == 1);
    ObjectsDestroy(&snes, &x, &r);
    ok(VectorsDestroyAll(&p));
  }
}

/* A load that is not a number, of any row, ends the solve, and the cell is named. Without loads and strengths nothing
   moves. */
static void not_a_number(void **state)
{
  uint64_t seed = 1;

  for (PetscInt c = 1; c <= 3; c++)
    for (PetscInt k = -1; k < c; k++) {
      SNESConvergedReason reason;
      VectorsNumbers s;
      PetscInt cell;
      PetscReal size;
      Vectors p;
      SNES snes;
      Vec x, r;

      ok(VectorsRandomNumbers(3, c, c < 3 ? VECTORS_CONSTANT : VECTORS_FRICTION, &seed, &s));
      if (k >= 0) s.load[c + k] = NAN;
      for (PetscInt i = 0; i < 3 * c && k < 0; i++) s.load[i] = s.strength[i / c] = 0;
      ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
      ok(VectorsCreateSolver(&p, SNESSEMISMOOTH, PETSC_TRUE, &snes));
      VecsDuplicate(p.l.load, &x, &r);
      ok(VecZeroEntries(x));
      ok(VectorsSolve(&p, snes, x, r, &reason));
      if (k >= 0) {
        ok(SNESSlipGetWorstCell(snes, &cell, NULL));
        assert_int_equal(reason, SLIP_SNES_DIVERGED_NAN);
        assert_int_equal(cell, 1);
      } else {
        ok(VecNorm(x, NORM_INFINITY, &size));
        assert_true(reason > 0 && size == 0);
      }
      ObjectsDestroy(&snes, &x, &r);
      ok(VectorsDestroyAll(&p));
    }
}

SLIP_TESTS(residual_of_a_guess, stage_after_another, not_a_number, along_one_axis, turned_axes, many_cells,
           approximate_operator, random_stages)
