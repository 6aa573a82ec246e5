/* Stages with smooth friction: the balance of one cell against formulas written out here, and the solver of many
   against their residual. */
#include "unit.h"
#include "linear.h"
#include <math.h>

enum { N = 6 };
static const PetscReal a = 0.012, b = 0.02, dc = 0.05, f0 = 0.6, V0 = 1e-6, nothing = 0;

/* One cell of the aging or slip law under the normal stress sigma [Pa] */
static SlipFrictionCells Cell(const PetscReal *sigma, SlipStateLaw state_law)
{
  const SlipFrictionLaw *law = NULL;

  ok(SlipFrictionFind("rate_and_state", &law));
  return (SlipFrictionCells){.law = law,
                             .residual = &nothing,
                             .drop = &nothing,
                             .rate = &nothing,
                             .slip = &dc,
                             .stress = sigma,
                             .a = &a,
                             .b = &b,
                             .reference = &f0,
                             .reference_rate = V0,
                             .state_law = state_law};
}

/* The state s at the end of a stage, s = s0 + theta ds/dt, by halving what holds it, and the friction there */
static PetscReal Friction(SlipStateLaw state_law, PetscReal theta, PetscReal s0, PetscReal v)
{
  PetscReal low = s0 - 1 - theta * v / dc * (1 + fabs(log(v / V0)) + fabs(s0)),
            high = s0 + 1 + theta * V0 / dc * exp(-s0);

  high += theta * v / dc * (1 + fabs(log(v / V0)) + fabs(s0));
  for (int it = 0; it < 200; it++) {
    const PetscReal s = 0.5 * (low + high);
    const PetscReal rate = state_law == SLIP_STATE_SLIP ? -v / dc * (log(v / V0) + s) : V0 / dc * exp(-s) - v / dc;

    if (s - s0 - theta * rate > 0)
      high = s;
    else
      low = s;
  }
  return a * asinh(v / (2 * V0) * exp((f0 + b * low) / a));
}

/* D v + sigma mu = load has the root that the load was made of, from guesses near and far, with both signs. The
   friction is that of 1e7 Pa to rounding of the terms of its argument, some hundred: 1e-13; the rate then to that over
   a/mu = 0.02. Where friction falls faster than D v grows the root is no stable one, and is not returned as such. */
static void one_cell(void **state)
{
  const PetscReal guess[] = {0, 1, 1.5, 0.5, 1e3, 1e-3}, sigma[] = {25e6, 1e3, 1e-6};

  for (int law = 0; law < 2; law++)
    for (size_t g = 0; g < 6; g++)
      for (size_t j = 0; j < 3; j++)
        for (int k = 0; k < 14; k++)
          for (PetscReal v = 1e-16; v < 10; v *= 100) {
            const SlipFrictionCells f = Cell(&sigma[j], (SlipStateLaw)law);
            const PetscReal theta = pow(10, k - 4), s0 = log(V0 / v) + 0.3, h = 1e-5, sign = k % 2 ? -1 : 1;
            const SlipFrictionStageCell cell = {.diagonal = 5e6 + 1e6 * theta, .omega = 1, .theta = theta, .s0 = &s0};
            const PetscReal mu = Friction(f.state_law, theta, s0, v), load = sigma[j] * mu + cell.diagonal * v;
            const PetscReal change =
              Friction(f.state_law, theta, s0, v * (1 + h)) - Friction(f.state_law, theta, s0, v * (1 - h));
            const PetscReal slope = sigma[j] * change / (2 * h) + cell.diagonal * v; /* by ln v */
            PetscBool stable;
            PetscReal root;

            if (fabs(slope) < 0.05 * (fabs(slope - cell.diagonal * v) + cell.diagonal * v))
              continue; /* nearly double */
            root = SlipFrictionStageRate(&f, 0, &cell, sign * load, sign * guess[g] * v, &stable);
            if (guess[g] == 1) assert_int_equal(stable, slope > 0);
            if (!stable) continue;
            assert_true(sign * root > 0);
            if (slope > 0 && guess[g] > 0.4 && guess[g] < 2)
              assert_true(fabs(sign * root / v - 1) < 1e-12 * (load / slope + 100));
            assert_true(fabs(sigma[j] * Friction(f.state_law, theta, s0, sign * root) + cell.diagonal * sign * root -
                             load) < 1e-12 * load);
          }
}

/* Without normal stress, and without load */
static void no_friction(void **state)
{
  const PetscReal sigma = 0, some = 1e7, s0 = 1;
  const SlipFrictionStageCell cell = {.diagonal = 4, .omega = 1, .theta = 2, .s0 = &s0};
  const SlipFrictionCells none = Cell(&sigma, SLIP_STATE_AGING), loaded = Cell(&some, SLIP_STATE_AGING);
  PetscBool stable;

  assert_true(SlipFrictionStageRate(&none, 0, &cell, -6, 1e-9, &stable) == -1.5);
  assert_true(stable);
  assert_true(SlipFrictionStageRate(&loaded, 0, &cell, 0, 1e-9, &stable) == 0);
  assert_true(stable);
}

/* ---- many cells ---- */
typedef struct {
  LinearSystem l;
  PetscReal theta, s0[N], sigma[N];
  PetscInt fixed; /* a cell whose rate is prescribed, 1e-3; -1: none */
} Stage;

static PetscErrorCode Bound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  const Stage *s = (const Stage *)ctx;
  const PetscReal *v = VecRead(x);
  PetscReal *strength, *slope = NULL;

  PetscCall(VecGetArray(q, &strength));
  if (dq) PetscCall(VecGetArray(dq, &slope));
  for (PetscInt i = 0; i < N; i++) {
    const SlipFrictionCells f = Cell(&s->sigma[i], SLIP_STATE_AGING);

    SlipFrictionStrength(&f, 1, s->theta, 1, &s->s0[i], 1, &v[i], &strength[i], slope ? &slope[i] : NULL);
  }
  if (dq) PetscCall(VecRestoreArray(dq, &slope));
  return VecRestoreArray(q, &strength);
}

static PetscErrorCode SolveCells(SlipConstraint con, PetscReal omega, Vec D, Vec f, Vec x, PetscBool *unstable,
                                 void *ctx)
{
  const Stage *s = (const Stage *)ctx;
  const PetscReal *d = VecRead(D), *load;
  PetscReal *v;

  load = VecRead(f);
  PetscCall(VecGetArray(x, &v));
  for (PetscInt i = 0; i < N; i++) {
    const SlipFrictionCells cells = Cell(&s->sigma[i], SLIP_STATE_AGING);
    const SlipFrictionStageCell cell = {.diagonal = d[i], .omega = omega, .theta = s->theta, .s0 = &s->s0[i]};
    PetscBool stable = PETSC_TRUE;

    v[i] = i == s->fixed ? 1e-3 : SlipFrictionStageRate(&cells, 0, &cell, load[i], v[i], &stable);
    if (!stable) *unstable = PETSC_TRUE;
  }
  return VecRestoreArray(x, &v);
}

static PetscErrorCode Prescribed(SlipConstraint con, Vec mask, void *ctx)
{
  const PetscInt fixed = ((const Stage *)ctx)->fixed;

  if (fixed >= 0) PetscCall(VecSetValue(mask, fixed, 0, INSERT_VALUES));
  return VecAssemble(mask);
}

/* B = 5e6 + theta K of a chain that falls off like 1/r^3, driven by stresses on both sides of the friction */
static void Create(PetscReal theta, PetscInt fixed, Stage *s, SlipConstraint *con)
{
  static const SlipConstraintOps ops = {.residual = LinearResidual,
                                        .jacobian = LinearJacobian,
                                        .bound = Bound,
                                        .solve_cells = SolveCells,
                                        .prescribed = Prescribed};

  *s = (Stage){.theta = theta, .fixed = fixed};
  ok(MatCreateSeqDense(PETSC_COMM_SELF, N, N, NULL, &s->l.B));
  ok(VecCreateSeq(PETSC_COMM_SELF, N, &s->l.load));
  for (PetscInt i = 0; i < N; i++) {
    s->sigma[i] = i == 4 ? 1e-3 : 25e6; /* one without strength to speak of */
    s->s0[i] = 5 + i;
    ok(VecSetValue(s->l.load, i, (i == 2 ? -1 : 1) * (1.3e7 + 1e6 * (PetscReal)i), INSERT_VALUES));
    for (PetscInt j = 0; j < N; j++)
      ok(MatSetValue(s->l.B, i, j, i == j ? 5e6 + 3e6 * theta : -4e5 * theta / pow(labs((long)(i - j)), 3),
                     INSERT_VALUES));
  }
  ok(MatAssemble(s->l.B));
  ok(VecAssemble(s->l.load));
  ok(SlipConstraintCreate(PETSC_COMM_SELF, &ops, s, s->l.load, con));
}

static void Destroy(Stage *s, SlipConstraint *con)
{
  ok(SlipConstraintDestroy(con));
  ObjectsDestroy(&s->l.B, &s->l.load);
}

/* From this rate in all cells, by the direct solver or CG; x is the solution. */
static SNESConvergedReason Solve(SlipConstraint con, PetscReal from, PetscInt direct_max, Vec x, PetscInt *its)
{
  SNESConvergedReason reason;
  SNES snes;
  KSP ksp;
  PC pc;

  ok(CreateSolver(con, SNESSEMISMOOTH, direct_max ? "350" : "0", &snes));
  ok(SNESSetTolerances(snes, PETSC_DEFAULT, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  ok(SNESGetKSP(snes, &ksp));
  ok(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  ok(KSPGetPC(ksp, &pc));
  ok(PCSetType(pc, PCJACOBI));
  ok(VecSet(x, from));
  ok(SNESSolve(snes, NULL, x));
  ok(SNESGetConvergedReason(snes, &reason));
  ok(SNESGetIterationNumber(snes, its));
  ok(SNESDestroy(&snes));
  return reason;
}

/* The solution has the balance of each cell to 1e-12 of the largest load, by the formulas above, from starts over ten
   decades, by the direct solver and by CG, with and without a cell whose rate is prescribed. */
static void many_cells(void **state)
{
  const PetscReal from[] = {1e-12, 1e-6, 1e-2};

  for (PetscInt fixed = -1; fixed < 2; fixed += 2)
    for (int direct = 0; direct < 2; direct++)
      for (size_t k = 0; k < 3; k++) {
        const PetscReal *v;
        Stage s;
        SlipConstraint con;
        PetscInt its;
        Vec x, g;

        Create(0.01, fixed, &s, &con);
        VecsDuplicate(s.l.load, &x, &g);
        assert_true(Solve(con, from[k], direct, x, &its) > 0);
        assert_true(its <= 12);
        ok(MatMult(s.l.B, x, g));
        ok(VecAXPY(g, -1, s.l.load));
        v = VecRead(x);
        for (PetscInt i = 0; i < N; i++) {
          const PetscReal friction =
            copysign(s.sigma[i] * Friction(SLIP_STATE_AGING, s.theta, s.s0[i], fabs(v[i])), v[i]);
          PetscReal balance;

          ok(VecGetValues(g, 1, &i, &balance));
          if (i == fixed)
            assert_true(v[i] == 1e-3);
          else
            assert_true(fabs(balance + friction) < 1e-12 * 1.8e7);
        }
        assert_true(v[2] < 0);
        ObjectsDestroy(&x, &g);
        Destroy(&s, &con);
      }
}

/* Cells that would go on at 1e-9 m/s but for the state, at many times the normal stress at which their stiffness keeps
   them stable, have long broken at the end of a stage in which that makes 5 d_c: refused. One in which it makes a
   hundredth of d_c is not. */
static void instability(void **state)
{
  for (int long_stage = 0; long_stage < 2; long_stage++) {
    PetscBool unstable;
    Stage s;
    SlipConstraint con;
    SNESConvergedReason reason;
    PetscInt its;
    Vec x;

    Create(long_stage ? 2.5e8 : 5e5, -1, &s, &con);
    for (PetscInt i = 0; i < N; i++) {
      s.sigma[i] = 400e6;
      s.s0[i] = 9;
    }
    ok(VecDuplicate(s.l.load, &x));
    ok(VecSet(x, 1e-9));
    ok(MatMult(s.l.B, x, s.l.load));
    ok(VecShift(s.l.load, 400e6 * Friction(SLIP_STATE_AGING, 0, 9, 1e-9)));
    reason = Solve(con, 1e-9, 1, x, &its);
    ok(SlipConstraintWasUnstable(con, &unstable));
    assert_int_equal(reason < 0, long_stage);
    assert_int_equal(unstable, long_stage);
    ok(VecDestroy(&x));
    Destroy(&s, &con);
  }
}

/* The other type knows no smooth bound. */
static void projection(void **state)
{
  Stage s;
  SlipConstraint con;
  SNES snes;
  Vec x;

  Create(0.01, -1, &s, &con);
  ok(VecDuplicate(s.l.load, &x));
  ok(CreateSolver(con, SNESPROJECTION, "350", &snes));
  fails(SNESSolve(snes, NULL, x), "smooth");
  ObjectsDestroy(&snes, &x);
  Destroy(&s, &con);
}

SLIP_TESTS(one_cell, no_friction, many_cells, instability, projection)
