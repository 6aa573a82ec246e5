/* TSBATHE with a reaction of two components: a block on a plane, m = 1, dv/dt = load - K u + r, du/dt = v, |r| <= q.
   On a rough incline it has a closed form, on springs a reference by the classical Runge-Kutta method. */
#include "unit.h"
#include "linear.h"
#include <math.h>

typedef struct {
  LinearSystem l;  /* of the stage */
  PetscReal angle; /* by which all directions are turned */
  PetscReal load[2], K[2][2], q,
    weakening;                    /* q (1 - weakening (1 - exp(-|v|))); load and K in axes that are not turned */
  PetscReal (*push)(PetscReal t); /* what the second load has more, or NULL */
  PetscReal t, theta, base[4];
  SlipConstraint con;
} Block;

static void Turn(PetscReal angle, const PetscReal a[2], PetscReal b[2])
{
  const PetscReal x = a[0], y = a[1];

  b[0] = cos(angle) * x - sin(angle) * y;
  b[1] = sin(angle) * x + cos(angle) * y;
}

/* load - K u at u in turned axes */
static void Force(const Block *b, PetscReal t, const PetscReal u[2], PetscReal f[2])
{
  PetscReal p[2], g[2];

  Turn(-b->angle, u, p);
  for (int k = 0; k < 2; k++) g[k] = b->load[k] - b->K[k][0] * p[0] - b->K[k][1] * p[1];
  if (b->push) g[1] += (*b->push)(t);
  Turn(b->angle, g, f);
}

static PetscReal Strength(const Block *b, PetscReal v, PetscReal *dq)
{
  *dq = -b->q * b->weakening * exp(-v);
  return b->q * (1 - b->weakening * (1 - exp(-v)));
}

/* u = base + theta (v + explicit), B = 1 / theta + theta K */
static PetscErrorCode Stage(SlipConstraint con, const SlipStage *stage, void *ctx)
{
  Block *b = (Block *)ctx;
  const PetscReal *w, *more = NULL;
  PetscReal load[2], column[2], K[2], *p;

  b->t = stage->t;
  b->theta = stage->theta;
  w = VecRead(stage->base);
  if (stage->explicit_part) more = VecRead(stage->explicit_part);
  for (int k = 0; k < 4; k++) b->base[k] = w[k] + (more ? stage->theta * more[k] : 0);
  Force(b, b->t, &b->base[2], load);
  PetscCall(VecGetArrayWrite(b->l.load, &p));
  for (int k = 0; k < 2; k++) p[k] = load[k] + b->base[k] / b->theta;
  PetscCall(VecRestoreArrayWrite(b->l.load, &p));
  for (PetscInt j = 0; j < 2; j++) {
    const PetscReal unit[] = {j == 0, j == 1};

    Turn(-b->angle, unit, column);
    for (int k = 0; k < 2; k++) K[k] = b->K[k][0] * column[0] + b->K[k][1] * column[1];
    Turn(b->angle, K, column);
    for (PetscInt k = 0; k < 2; k++)
      PetscCall(MatSetValue(b->l.B, k, j, b->theta * column[k] + (k == j ? 1 / b->theta : 0), INSERT_VALUES));
  }
  return MatAssemble(b->l.B);
}

static PetscErrorCode Bound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  const PetscReal *v;
  PetscReal slope, strength;

  v = VecRead(x); /* of a full state too: the rate comes first */
  strength = Strength((const Block *)ctx, hypot(v[0], v[1]), &slope);
  PetscCall(VecSet(q, strength));
  if (dq) PetscCall(VecSet(dq, slope));
  return PETSC_SUCCESS;
}

static PetscErrorCode BoundState(SlipConstraint con, PetscReal t, Vec w, Vec q, void *ctx)
{
  return Bound(con, w, q, NULL, ctx);
}

static PetscErrorCode Reduce(SlipConstraint con, Vec w, Vec x, void *ctx)
{
  const PetscReal *a = VecRead(w);
  PetscReal *b;

  PetscCall(VecGetArrayWrite(x, &b));
  for (int k = 0; k < 2; k++) b[k] = a[k];
  return VecRestoreArrayWrite(x, &b);
}

static PetscErrorCode Lift(SlipConstraint con, Vec x, Vec w, void *ctx)
{
  const Block *b = (const Block *)ctx;
  const PetscReal *v = VecRead(x);
  PetscReal *a;

  PetscCall(VecGetArrayWrite(w, &a));
  for (int k = 0; k < 2; k++) {
    a[k] = v[k];
    a[2 + k] = b->base[2 + k] + b->theta * v[k];
  }
  return VecRestoreArrayWrite(w, &a);
}

static PetscErrorCode Smooth(SlipConstraint con, PetscReal t, Vec w, Vec F, void *ctx)
{
  const PetscReal *a = VecRead(w);
  PetscReal *f;

  PetscCall(VecGetArrayWrite(F, &f));
  Force((const Block *)ctx, t, &a[2], f);
  for (int k = 0; k < 2; k++) f[2 + k] = a[k];
  return VecRestoreArrayWrite(F, &f);
}

static PetscErrorCode AddReaction(SlipConstraint con, PetscReal a, Vec r, Vec F, void *ctx)
{
  const PetscReal *b = VecRead(r);
  PetscReal *f;

  PetscCall(VecGetArray(F, &f));
  for (int k = 0; k < 2; k++) f[k] += a * b[k];
  return VecRestoreArray(F, &f);
}

static PetscErrorCode SolveMass(SlipConstraint con, Vec F, Vec k, void *ctx)
{
  if (F != k) PetscCall(VecCopy(F, k));
  return PETSC_SUCCESS;
}

static void Create(Block *b)
{
  const SlipConstraintOps ops = {.stage = Stage,
                                 .residual = LinearResidual,
                                 .jacobian = LinearJacobian,
                                 .bound = Bound,
                                 .reduce = Reduce,
                                 .lift = Lift,
                                 .smooth = Smooth,
                                 .add_reaction = AddReaction,
                                 .solve_mass = SolveMass,
                                 .bound_state = BoundState};
  PetscInt c;
  Vec cells;

  ok(MatCreateSeqDense(PETSC_COMM_SELF, 2, 2, NULL, &b->l.B));
  ok(VecCreateSeq(PETSC_COMM_SELF, 2, &b->l.load));
  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &cells));
  ok(SlipConstraintCreate(PETSC_COMM_SELF, &ops, b, b->l.load, &b->con));
  fails(SlipConstraintSetComponents(b->con, 4, cells), "expected 1, 2 or 3");
  fails(SlipConstraintSetComponents(b->con, 2, b->l.load), "expected 2 for each of 2 cells");
  ok(SlipConstraintSetComponents(b->con, 2, cells));
  ok(SlipConstraintGetComponents(b->con, &c));
  assert_int_equal(c, 2);
  ok(VecDestroy(&cells));
}

static void Destroy(Block *b)
{
  ok(SlipConstraintDestroy(&b->con));
  ObjectsDestroy(&b->l.B, &b->l.load);
}

/* From v = start, u = 0 to tmax in constant steps; the end and the reaction there in axes that are not turned */
static void Run(Block *b, const PetscReal start[2], PetscReal tmax, PetscInt steps, TSBatheFirstStage first,
                PetscReal end[4], PetscReal reaction[2], SlipAttempt *attempt)
{
  PetscReal *a;
  const PetscReal *p;
  Vec w, r;
  TS ts;

  Create(b);
  ok(VecCreateSeq(PETSC_COMM_SELF, 4, &w));
  ok(VecGetArray(w, &a));
  Turn(b->angle, start, a);
  ok(VecRestoreArray(w, &a));
  ts = MakeTS(TSBATHE, tmax / (PetscReal)steps, tmax);
  ok(TSBatheSetConstraint(ts, b->con));
  ok(TSBatheSetFirstStage(ts, first));
  ok(TSSetSolution(ts, w));
  ok(TSSetTolerances(ts, 1, NULL, 0, NULL));
  SetAdapt(ts, TSADAPTNONE);
  ok(TSSetFromOptions(ts));
  ok(TSSolve(ts, w));
  ok(TSBatheGetLastAttempt(ts, attempt));
  ok(TSBatheGetReaction(ts, &r));
  p = VecRead(r);
  Turn(-b->angle, p, reaction);
  ok(VecGetArray(w, &a));
  for (int k = 0; k < 4; k += 2) Turn(-b->angle, &a[k], &end[k]);
  ok(VecRestoreArray(w, &a));
  fails(SlipConstraintSetComponents(b->con, 1, NULL), "before the first solve");
  ObjectsDestroy(&ts, &w);
  Destroy(b);
}

/* A block that starts with the speed v0 across an incline of downhill acceleration a, k = mu cot(slope) > 1: with u =
   tan(phi / 2), phi the angle between its velocity and downhill, v = v0 u^k / sin phi, and by du/dt = -2 a u^2 / (v0
   u^k (1 + u^2)) t and the place are sums of powers of u; it stops at u = 0. (Any book on mechanics has the
   hodograph; these integrals of it are done here.) */
static void Incline(PetscReal v0, PetscReal a, PetscReal k, PetscReal t, PetscReal end[4])
{
  const PetscReal stop = v0 * k / (a * (k * k - 1));
  PetscReal low = 0, high = 1, u;

  for (int it = 0; it < 200 && t < stop; it++) {
    u = 0.5 * (low + high);
    if (v0 / (2 * a) * ((1 - pow(u, k - 1)) / (k - 1) + (1 - pow(u, k + 1)) / (k + 1)) > t)
      low = u;
    else
      high = u;
  }
  u = t < stop ? 0.5 * (low + high) : 0;
  end[0] = v0 * pow(u, k);
  end[1] = u > 0 ? v0 * pow(u, k - 1) * (1 - u * u) / 2 : 0;
  end[2] = v0 * v0 / (2 * a) * ((1 - pow(u, 2 * k - 1)) / (2 * k - 1) + (1 - pow(u, 2 * k + 1)) / (2 * k + 1));
  end[3] = v0 * v0 / (4 * a) * ((1 - pow(u, 2 * k - 2)) / (2 * k - 2) - (1 - pow(u, 2 * k + 2)) / (2 * k + 2));
}

static PetscReal Far(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal d = 0;

  for (PetscInt i = 0; i < n; i++) d = PetscMax(d, PetscAbsReal(a[i] - b[i]));
  return d;
}

/* Rates and displacement of order two while the block slides: errors fall to a quarter with half the step, to 10 %.
   Both rules of stage 1, in turned axes. After its stop it rests at exactly zero, held by the friction that the
   incline takes. */
static void incline(void **state)
{
  const PetscReal v0 = 1, a = 1, k = 2, start[] = {v0, 0};
  SlipAttempt attempt;

  for (int rule = 0; rule < 2; rule++)
    for (int axes = 0; axes < 3; axes++) {
      Block b = {.load = {0, a}, .q = a * k, .angle = axes == 1 ? PETSC_PI / 2 : 0.7 * axes};
      PetscReal end[4], exact[4], r[2], error, last = 0;

      Incline(v0, a, k, 0.4, exact);
      for (PetscInt n = 40; n <= 160; n *= 2, last = error) {
        Run(&b, start, 0.4, n, rule ? TSBATHE_STAGE_BACKWARD : TSBATHE_STAGE_TRAPEZOIDAL, end, r, &attempt);
        error = Far(4, end, exact);
        AssertNear(hypot(r[0], r[1]), b.q, 1e-12);
        AssertNear(r[0] * end[1] - r[1] * end[0], 0, 1e-12);
        if (last > 0) assert_true(last / error > 3.6 && last / error < 4.4);
      }
      Incline(v0, a, k, 1, exact);
      Run(&b, start, 1, 400, rule ? TSBATHE_STAGE_BACKWARD : TSBATHE_STAGE_TRAPEZOIDAL, end, r, &attempt);
      assert_true(end[0] == 0 && end[1] == 0);
      assert_true(Far(2, &end[2], &exact[2]) < 2e-6); /* of 0.67; 8e-7 and 4e-7 measured */
      AssertNear(r[0], 0, 1e-12);
      AssertNear(r[1], -a, 1e-12);
    }
}

/* d(v, u)/dt while it slides */
static void Slide(const Block *b, const PetscReal w[4], PetscReal f[4])
{
  const PetscReal v = hypot(w[0], w[1]);
  PetscReal unused, q = Strength(b, v, &unused);

  Force(b, 0, &w[2], f);
  for (int k = 0; k < 2; k++) {
    f[k] -= q * w[k] / v;
    f[2 + k] = w[k];
  }
}

/* On springs, pulled obliquely, with friction that falls with the speed, before it stops: order two against 20,000
   steps of order four */
static void springs(void **state)
{
  const PetscReal start[] = {0.4, 1}, tmax = 0.8;
  Block b = {.load = {1.5, -0.3}, .K = {{2, 0.4}, {0.4, 1}}, .q = 0.5, .weakening = 0.3};
  PetscReal w[4] = {start[0], start[1]}, end[4], r[2], last = 0, error;
  SlipAttempt attempt;
  const PetscInt N = 20000;

  for (PetscInt n = 0; n < N; n++) {
    const PetscReal h = tmax / (PetscReal)N;
    PetscReal k[4][4], y[4];

    for (int s = 0; s < 4; s++) {
      for (int i = 0; i < 4; i++) y[i] = w[i] + (s ? (s == 3 ? h : h / 2) * k[s - 1][i] : 0);
      Slide(&b, y, k[s]);
    }
    for (int i = 0; i < 4; i++) w[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
  }
  for (PetscInt n = 20; n <= 80; n *= 2, last = error) {
    b.angle = 0.3 * (PetscReal)n;
    Run(&b, start, tmax, n, TSBATHE_STAGE_TRAPEZOIDAL, end, r, &attempt);
    error = Far(4, end, w);
    if (last > 0) assert_true(last / error > 3.6 && last / error < 4.4);
  }
}

/* c at 0, -c in the middle of the step and 0 at its end: stage 1 ends with v = 0 there, and so does stage 2 */
static PetscReal Push(PetscReal t)
{
  return t == 0 ? 1 : (t < 0.75 ? -1 : 0);
}

/* A cell that slides along one axis does not stick along the other: its error counts where that rate is exactly zero.
   The embedded estimate is e0 k0 + e1 k1 + e2 k2, here of 1, -1 and 0; three of four rows have no error, and the
   tolerance is 1. */
static void rate_of_zero_along_an_axis(void **state)
{
  const PetscReal start[] = {1, 0};
  Block b = {.push = Push};
  PetscReal end[4], r[2];
  SlipAttempt attempt;
  SlipBathe c;

  SlipBatheSetUp(0.5, &c);
  Run(&b, start, 1, 1, TSBATHE_STAGE_TRAPEZOIDAL, end, r, &attempt);
  assert_true(end[0] == 1 && end[1] == 0);
  AssertNear(attempt.error, PetscAbsReal(c.error[0] - c.error[1]) / 2, 1e-14);
  assert_true(attempt.error > 0.01);
}

/* At rest the static balance, projected on the disk */
static void initial_reaction(void **state)
{
  for (int above = 0; above < 2; above++) {
    Block b = {.load = {3, -4}, .q = above ? 2 : 6, .angle = 1.1};
    PetscReal a[2];
    const PetscReal *p;
    Vec w, r;

    Create(&b);
    ok(VecCreateSeq(PETSC_COMM_SELF, 4, &w));
    ok(VecDuplicate(b.l.load, &r));
    ok(SlipConstraintInitialReaction(b.con, 0, w, r));
    p = VecRead(r);
    Turn(-b.angle, p, a);
    AssertNear(a[0], above ? -1.2 : -3, 1e-14);
    AssertNear(a[1], above ? 1.6 : 4, 1e-14);
    ok(VecSetValue(w, 0, cos(b.angle), INSERT_VALUES));
    ok(VecSetValue(w, 1, sin(b.angle), INSERT_VALUES));
    ok(SlipConstraintInitialReaction(b.con, 0, w, r));
    p = VecRead(r);
    Turn(-b.angle, p, a);
    AssertNear(a[0], -b.q, 1e-14);
    AssertNear(a[1], 0, 1e-14);
    ObjectsDestroy(&w, &r);
    Destroy(&b);
  }
}

SLIP_TESTS(incline, springs, rate_of_zero_along_an_axis, initial_reaction)
