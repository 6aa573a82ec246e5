/* The first-order sliding mode controller dw/dt = D sin(omega t) + F_r, F_r in -k Sign(w): one scalar
   unknown, an exact piecewise solution, and the smallest constraint that a user can write. */
#include "unit.h"
#include "linear.h"

static const PetscReal k = 2.0, D = 1.5, omega = 50.0, start = 0.1;

static PetscReal First(Vec x)
{
  const PetscScalar *a = VecRead(x);
  PetscReal v;

  v = PetscRealPart(a[0]);
  return v;
}

/* (w - base)/theta = D sin(omega t) + explicit + r */
static PetscErrorCode Stage(SlipConstraint con, const SlipStage *st, void *ctx)
{
  LinearSystem *m = (LinearSystem *)ctx;
  PetscReal c;

  c = First(st->base) / st->theta + D * PetscSinReal(omega * st->t);
  if (st->explicit_part) c += First(st->explicit_part);
  PetscCall(VecSet(m->load, c));
  PetscCall(MatZeroEntries(m->B));
  return MatShift(m->B, 1.0 / st->theta);
}

static PetscErrorCode Copy(SlipConstraint con, Vec a, Vec b, void *ctx)
{
  if (a != b) PetscCall(VecCopy(a, b));
  return PETSC_SUCCESS;
}

static PetscErrorCode Smooth(SlipConstraint con, PetscReal t, Vec w, Vec F, void *ctx)
{
  return VecSet(F, D * PetscSinReal(omega * t));
}

static PetscErrorCode AddReaction(SlipConstraint con, PetscReal a, Vec r, Vec F, void *ctx)
{
  return VecAXPY(F, a, r);
}

static PetscErrorCode BoundState(SlipConstraint con, PetscReal t, Vec w, Vec q, void *ctx)
{
  return LinearBound(con, w, q, NULL, ctx);
}

/* w while it slides: w falls as k > D, reaches zero once and stays */
static PetscReal Exact(PetscReal t)
{
  return PetscMax(0.0, start + D / omega * (1.0 - PetscCosReal(omega * t)) - k * t);
}

/* w and r at tmax with constant steps */
static PetscErrorCode Run(PetscReal tmax, PetscInt steps, PetscReal *w, PetscReal *r)
{
  const SlipConstraintOps ops = {Stage,  LinearResidual, LinearJacobian, LinearBound, Copy,      Copy,
                                 Smooth, AddReaction,    Copy,           BoundState,  NULL,      NULL,
                                 NULL,   NULL,           NULL,           NULL,        PETSC_TRUE};
  LinearSystem m = {.q = k};
  SlipConstraint con;
  TS ts;
  Vec x, reaction;

  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, 1, 1, NULL, &m.B));
  PetscCall(MatCreateVecs(m.B, &x, &m.load));
  PetscCall(VecSet(x, start));
  PetscCall(SlipConstraintCreate(PETSC_COMM_SELF, &ops, &m, x, &con));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(TSSetType(ts, TSBATHE));
  PetscCall(TSBatheSetConstraint(ts, con));
  PetscCall(TSSetTimeStep(ts, tmax / steps));
  PetscCall(TSSetMaxTime(ts, tmax));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(TSSolve(ts, x));
  PetscCall(TSBatheGetReaction(ts, &reaction));
  *w = First(x);
  *r = First(reaction);
  return DestroyObjects(&ts, &con, &x, &m.load, &m.B);
}

/* Order 2 before the arrest (at 0.06 s), up to the O(h) part at these steps of less than a tenth of a period */
static void test_sliding_phase(void **state)
{
  PetscReal w[2], r;

  for (int i = 0; i < 2; i++) {
    ok(Run(0.05, 20 << i, &w[i], &r));
    assert_true(r == -k);
    w[i] = fabs(w[i] - Exact(0.05));
  }
  print_message("errors %g %g, order %.3f\n", w[0], w[1], log2(w[0] / w[1]));
  assert_true(fabs(log2(w[0] / w[1]) - 2.0) < 0.05);
}

/* After it w is zero to the bit and the reaction is minus the load, to the rounding of w/theta + load */
static void test_sliding_mode(void **state)
{
  PetscReal w, r;

  assert_true(Exact(0.5) == 0.0);
  ok(Run(0.5, 100, &w, &r));
  assert_true(w == 0.0);
  assert_true(fabs(r + D * sin(omega * 0.5)) < 1e-13);
}

SLIP_TESTS(test_sliding_phase, test_sliding_mode)
