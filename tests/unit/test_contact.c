/* Stages whose cells open: contact and the friction disk in one problem. Random ones, -stages sets their number;
   against cells that cannot open, and one cell by hand. */
#include "unit.h"
#include "vectors.h"

static PetscInt iterations; /* of the last Solve() */

/* From a guess of random numbers up to size; x and r are the caller's */
static PetscBool Solve(Vectors *p, const char *type, PetscBool direct, PetscReal size, uint64_t *seed, Vec *x, Vec *r)
{
  SNESConvergedReason reason;
  PetscReal *a;
  PetscInt n;
  SNES snes;

  ok(VecDuplicate(p->l.load, x));
  ok(VecDuplicate(p->l.load, r));
  ok(VecGetLocalSize(*x, &n));
  ok(VecGetArray(*x, &a));
  for (PetscInt i = 0; i < n; i++) a[i] = size * (2 * VectorsRandom(seed) - 1);
  ok(VecRestoreArray(*x, &a));
  ok(VectorsCreateSolver(p, type, direct, &snes));
  ok(VectorsSolve(p, snes, *x, *r, &reason));
  ok(SNESGetIterationNumber(snes, &iterations));
  ok(SNESDestroy(&snes));
  return reason > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Random stages, direct and by Krylov's methods, from guesses over ten decades. Complementarity is exact, the cone
   holds to rounding (1e-12), the balance to what the tolerance of 1e-10 leaves after x was turned along n and closed
   (entries of theta K are up to 100). Friction that depends on the pressure may leave no solution, as coupled
   bounds. */
static void random_stages(void **state)
{
  PetscInt stages = 10000, failed[2] = {0}, tried[2] = {0}, kinds[4] = {0}, compared = 0, different = 0;
  uint64_t seed = 17;

  ok(PetscOptionsGetInt(NULL, NULL, "-stages", &stages, NULL));
  for (PetscInt trial = 0; trial < stages; trial++) {
    const PetscInt n = 1 + trial % 7, which = trial / 7 % 2;
    PetscReal size, far;
    const PetscReal *a, *f;
    VectorsNumbers s;
    PetscBool holds;
    Vectors p;
    Vec x, r, y, e;

    ok(VectorsRandomNumbers(n, 3, VECTORS_FRICTION + which, &seed, &s));
    for (PetscInt i = 0; i < n; i++) s.strength[i] *= s.friction; /* up to 1.2 */
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    tried[which]++;
    if (Solve(&p, SNESSEMISMOOTH, trial % 4 ? PETSC_TRUE : PETSC_FALSE, VectorsLogRandom(&seed, 1e-10, 1), &seed, &x,
              &r)) {
      ok(VectorsHold(&p, x, r, &holds));
      assert_true(holds);
      a = VecRead(x);
      f = VecRead(r);
      for (PetscInt i = 0; i < 3 * n; i += 3)
        kinds[a[i + 2] > 0 ? 0 : a[i] != 0 || a[i + 1] != 0 ? 1 : f[i + 2] > 0 ? 2 : 3]++;
      if (which == 0 && trial % 10 < 3) {
        if (Solve(&p, SNESPROJECTION, PETSC_TRUE, 0, &seed, &y, &e)) {
          compared++;
          ok(VecNorm(x, NORM_INFINITY, &size));
          ok(VecAXPY(y, -1, x));
          ok(VecNorm(y, NORM_INFINITY, &far));
          if (far > 1e-6 * PetscMax(size, 1e-3)) different++;
        }
        ObjectsDestroy(&y, &e);
      }
    } else
      failed[which]++;
    ObjectsDestroy(&x, &r);
    ok(VectorsDestroyAll(&p));
  }
  printf("failed %d of %d, weakening %d of %d; open %d, sliding %d, sticking %d; %d compared, %d differ\n",
         (int)failed[0], (int)tried[0], (int)failed[1], (int)tried[1], (int)kinds[0], (int)kinds[1], (int)kinds[2],
         (int)compared, (int)different);
  assert_true(kinds[0] > stages / 10 && kinds[1] > stages / 10 && kinds[2] > stages / 10);
  assert_true(failed[0] <= tried[0] / 30 && failed[1] <= tried[1] / 30 && different <= compared / 50);
}

/* Cells that a pressure keeps closed are cells with two components whose bound the others change: the same rows of B, q
   = mu (P + B_nt x). 1e-9 of the largest, as both solve to 1e-10; in no more iterations, as the slopes are the same,
   and refused as those are. */
static void pressed_cells(void **state)
{
  const PetscReal pressure = 50;
  uint64_t seed = 23;
  PetscInt solved = 0, count = 0, its;

  for (int trial = 0; trial < 200; trial++) {
    const PetscInt n = 1 + trial % 5, weakens = trial % 2;
    const PetscReal *a, *b;
    VectorsNumbers s, v;
    PetscReal size = 0;
    PetscBool done, also, unstable, refused;
    Vectors p, w;
    Vec x, r, y, f;

    ok(VectorsRandomNumbers(n, 3, VECTORS_FRICTION + weakens, &seed, &s));
    ok(VectorsRandomNumbers(n, 2, weakens ? VECTORS_WEAKENING : VECTORS_COUPLED, &seed, &v));
    v.theta = s.theta, v.omega = s.omega, v.drop = s.drop, v.slip = s.slip;
    for (PetscInt i = 0; i < n; i++) {
      s.strength[i] *= weakens ? 2 / pressure : 0.02; /* which slides under loads of up to 3 */
      s.load[3 * i + 2] = -pressure;
      v.strength[i] = s.strength[i] * pressure / s.omega;
      for (PetscInt k = 0; k < 2; k++) {
        v.load[2 * i + k] = s.load[3 * i + k];
        for (PetscInt j = 0; j < n; j++) {
          for (PetscInt l = 0; l < 2; l++) v.B[(2 * i + k) * 2 * n + 2 * j + l] = s.B[(3 * i + k) * 3 * n + 3 * j + l];
          v.C[i * 2 * n + 2 * j + k] = s.B[(3 * i + 2) * 3 * n + 3 * j + k] / (pressure * v.friction);
          if (weakens) /* whose bound knows no others: here the normal rows do not either */
            s.B[(3 * i + 2) * 3 * n + 3 * j + k] = s.B[(3 * j + k) * 3 * n + 3 * i + 2] = 0;
        }
      }
    }
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    ok(VectorsCreate(PETSC_COMM_SELF, &v, &w));
    ok(SlipConstraintSetRefuseUnstable(p.con, weakens ? PETSC_TRUE : PETSC_FALSE));
    ok(SlipConstraintSetRefuseUnstable(w.con, weakens ? PETSC_TRUE : PETSC_FALSE));
    done = Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 0, &seed, &x, &r);
    its = iterations;
    also = Solve(&w, SNESSEMISMOOTH, PETSC_TRUE, 0, &seed, &y, &f);
    if (done && also) assert_true(its <= iterations);
    ok(SlipConstraintWasUnstable(p.con, &unstable));
    ok(SlipConstraintWasUnstable(w.con, &refused));
    assert_true(unstable == refused);
    count += refused;
    ok(VecNorm(y, NORM_INFINITY, &size));
    a = VecRead(x);
    b = VecRead(y);
    for (PetscInt i = 0; i < n && done && also; i++) {
      for (PetscInt k = 0; k < 2; k++) AssertNear(a[3 * i + k], b[2 * i + k], 1e-9 * size);
      assert_true(a[3 * i + 2] == 0);
    }
    solved += done && also && size > 0;
    ObjectsDestroy(&x, &r, &y, &f);
    ok(VectorsDestroyAll(&p));
    ok(VectorsDestroyAll(&w));
  }
  printf("%d of 200 solved, and moving, %d refused\n", (int)solved, (int)count);
  assert_true(solved > 130 && count > 2);
}

/* One cell by hand, B = [b 0 e; 0 b 0; e 0 b], mu = 0.5: pulled open, y and v of B x = load; pressed, and pushed beyond
   friction; pressed, held; on the edge of opening it moves freely. */
static void one_cell(void **state)
{
  const PetscReal b = 2, e = 0.5, mu = 0.5, loads[][3] = {{1, 0.5, 3}, {4, 0, -2}, {0.5, 0.4, -3}, {1, 1, 0}};
  const PetscReal det = b * b - e * e;
  /* pressed: (b + mu e) v = 4 - mu (2), as r = 2 + e v and v > 0 */
  const PetscReal slides = (4 - mu * 2) / (b + mu * e);
  const PetscReal x[][3] = {
    {(b * 1 - e * 3) / det, 0.25, (b * 3 - e * 1) / det}, {slides, 0, 0}, {0, 0, 0}, {NAN, NAN, 0}};
  const PetscReal pressure[] = {0, 2 + e * slides, 3, NAN};
  uint64_t seed = 1;

  for (int k = 0; k < 4; k++) {
    VectorsNumbers s;
    const PetscReal *a;
    PetscBool holds;
    Vectors p;
    Vec y, r;

    ok(VectorsRandomNumbers(1, 3, VECTORS_FRICTION, &seed, &s));
    for (int i = 0; i < 9; i++) s.B[i] = i % 4 == 0 ? b : i == 2 || i == 6 ? e : 0;
    for (int i = 0; i < 3; i++) s.load[i] = loads[k][i];
    s.strength[0] = mu, s.omega = 1;
    ok(VectorsCreate(PETSC_COMM_SELF, &s, &p));
    assert_true(Solve(&p, SNESSEMISMOOTH, PETSC_TRUE, 0.1, &seed, &y, &r));
    assert_true(iterations <= 2); /* a linear problem, once it is known what moves */
    ok(VectorsHold(&p, y, r, &holds));
    assert_true(holds);
    a = VecRead(y);
    for (int i = 0; i < 3; i++)
      if (!isnan(x[k][i])) AssertNear(a[i], x[k][i], 1e-12);
    if (isnan(pressure[k])) /* v presses by e v_x */
      AssertNear(VecRead(r)[2], e * a[0], 1e-12);
    else
      AssertNear(VecRead(r)[2], pressure[k], 1e-12);
    ObjectsDestroy(&y, &r);
    ok(VectorsDestroyAll(&p));
  }
}

SLIP_TESTS(one_cell, pressed_cells, random_stages)
