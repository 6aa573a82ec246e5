/* TSBATHE of problems that TSSetIFunction() gives in forms that only a backward first stage integrates, and solves that
   end at the solver's floor. */
#include "unit.h"
#include <slipstep/private/slipsys.h>

typedef struct {
  PetscReal end, value; /* of the first component */
  PetscInt n;
  PetscReal start[2];
  void (*f)(PetscReal, const PetscScalar *, const PetscScalar *, PetscScalar *);
} Implicit;

/* u'^3 + u' + u^3 + u = 0 has u' = -u */
static void Cubic(PetscReal t, const PetscScalar *y, const PetscScalar *yd, PetscScalar *f)
{
  f[0] = yd[0] * yd[0] * yd[0] + yd[0] + y[0] * y[0] * y[0] + y[0];
}

/* M(t) u' + 2 t u = 0, M = 1 + t^2: u = 1 / (1 + t^2) */
static void Mass(PetscReal t, const PetscScalar *y, const PetscScalar *yd, PetscScalar *f)
{
  f[0] = (1 + t * t) * yd[0] + 2 * t * y[0];
}

/* M(u) u' + u (1 + u) = 0, M = 1 + u: u' = -u */
static void MassOfState(PetscReal t, const PetscScalar *y, const PetscScalar *yd, PetscScalar *f)
{
  f[0] = (1 + y[0]) * yd[0] + y[0] * (1 + y[0]);
}

/* Index 1: u' = -z^2, 0 = z^3 - u z^2 + (z - u), so that z = u: u = 1 / (1 + t) */
static void Algebraic(PetscReal t, const PetscScalar *y, const PetscScalar *yd, PetscScalar *f)
{
  f[0] = yd[0] + y[1] * y[1];
  f[1] = (y[1] - y[0]) * (1 + y[1] * y[1]);
}

/* Index 1 with a start that does not meet the algebraic equation, z = cos t: u' = z - u, u(0) = 1 */
static void OffBalance(PetscReal t, const PetscScalar *y, const PetscScalar *yd, PetscScalar *f)
{
  f[0] = yd[0] + y[0] - y[1];
  f[1] = y[1] - PetscCosReal(t);
}

static PetscErrorCode ImplicitForm(TS ts, PetscReal t, Vec y, Vec ydot, Vec F, void *ctx)
{
  const PetscScalar *a = VecRead(y), *b;
  PetscScalar *f;

  b = VecRead(ydot);
  PetscCall(VecGetArray(F, &f));
  (*((const Implicit *)ctx)->f)(t, a, b, f);
  return VecRestoreArray(F, &f);
}

/* No Jacobian is given: differences of the stage's residual. */
static TS CreateImplicit(const Implicit *form, PetscReal h, Vec *y)
{
  TS ts;
  SNES snes;
  Mat J;

  ok(VecCreateSeq(PETSC_COMM_SELF, form->n, y));
  for (PetscInt i = 0; i < form->n; i++) ok(VecSetValue(*y, i, form->start[i], INSERT_VALUES));
  ok(VecAssemble(*y));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSBATHE));
  ok(TSSetIFunction(ts, NULL, ImplicitForm, (void *)form));
  ok(TSGetSNES(ts, &snes));
  ok(MatCreateSeqDense(PETSC_COMM_SELF, form->n, form->n, NULL, &J));
  ok(SNESSetJacobian(snes, J, J, SNESComputeJacobianDefault, NULL));
  ok(MatDestroy(&J));
  ok(SNESSetTolerances(snes, 1e-12, 1e-11, 1e-14, 50, 1000));
  ok(TSSetTimeStep(ts, h));
  ok(TSSetMaxTime(ts, form->end));
  ok(TSSetMaxSteps(ts, 100000));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  return ts;
}

/* Order 2 + O(h), by halving: 0.1 is what is left of the O(h) part */
static void test_implicit_forms(void **state)
{
  const Implicit forms[] = {{2, PetscExpReal(-2), 1, {1}, Cubic},
                            {2, 0.2, 1, {1}, Mass},
                            {2, PetscExpReal(-2), 1, {1}, MassOfState},
                            {2, (PetscReal)1 / 3, 2, {1, 1}, Algebraic},
                            {2, 0.5 * (PetscCosReal(2) + PetscSinReal(2) + PetscExpReal(-2)), 2, {1, 7}, OffBalance}};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(forms); i++) {
    PetscReal error[2];

    for (int k = 0; k < 2; k++) {
      TSBatheFirstStage first;
      PetscScalar a[2];
      Vec y;
      TS ts = CreateImplicit(&forms[i], 0.05 / (1 + k), &y);

      ok(TSSolve(ts, y));
      ok(TSBatheGetFirstStage(ts, &first));
      assert_int_equal(first, TSBATHE_STAGE_BACKWARD);
      ok(VecGetValues(y, forms[i].n, (PetscInt[]){0, 1}, a));
      error[k] = PetscAbsReal(a[0] - forms[i].value);
      if (i == 3) AssertNear(a[1], a[0], 1e-10); /* the solver's */
      ObjectsDestroy(&y, &ts);
    }
    AssertLess(error[0], 1e-3); /* h^2 = 2.5e-3 with constants below 0.4 */
    AssertNear(log2(error[0] / error[1]), 2.0, 0.1);
  }
}

/* Nobody's choice is overruled. */
static void test_first_stage_chosen(void **state)
{
  const Implicit form = {2, 0, 1, {1}, Cubic};
  TSBatheFirstStage first;
  Vec y;
  TS ts = CreateImplicit(&form, 0.1, &y);

  ok(TSBatheSetFirstStage(ts, TSBATHE_STAGE_TRAPEZOIDAL));
  ok(TSSetSolution(ts, y));
  ok(TSSetUp(ts));
  ok(TSBatheGetFirstStage(ts, &first));
  assert_int_equal(first, TSBATHE_STAGE_TRAPEZOIDAL);
  ObjectsDestroy(&y, &ts);
}

/* u' + u = 0 whose u' is known to 1e-4 only: no solve's residual gets below some 5e-5, whatever the step */
static void Coarse(PetscReal t, const PetscScalar *y, const PetscScalar *yd, PetscScalar *f)
{
  f[0] = 1e-4 * round(yd[0] / 1e-4) + y[0];
}

static void test_floor_of_the_solver(void **state)
{
  const Implicit form = {2, 0, 1, {PETSC_PI}, Coarse};
  Vec y;
  TS ts = CreateImplicit(&form, 0.1, &y);
  SNES snes;
  char *told;

  ok(TSGetSNES(ts, &snes));
  ok(SlipWarningsTake(&told));
  ok(PetscFree(told));
  (void)TSSolve(ts, y); /* it ends, or gets on by steps that happen to meet the digits */
  ok(SlipWarningsTake(&told));
  assert_non_null(strstr(told, "shorter steps do not help"));
  assert_null(strstr(strstr(told, "shorter steps do not help") + 1, "shorter steps do not help")); /* once */
  ok(PetscFree(told));
  ObjectsDestroy(&y, &ts);
  ts = CreateImplicit(&form, 0.1, &y);
  ok(TSGetSNES(ts, &snes));
  ok(SNESSetTolerances(snes, 1e-4, 1e-11, 1e-14, 50, 1000)); /* as the warning says */
  ok(TSSolve(ts, y));
  ObjectsDestroy(&y, &ts);
}

SLIP_TESTS(test_implicit_forms, test_first_stage_chosen, test_floor_of_the_solver)
