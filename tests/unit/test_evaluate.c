/* Errors of a run against a reference, on series whose errors are known in closed form. */
#include "unit.h"
#include "evaluate/evaluate.h"
#include <math.h>

#define ROUNDING 1e-12 /* sums of a few hundred numbers of order 1 */

/* y = t^2 and its rate 2 t on [0, 2], or that shifted up */
static PetscErrorCode Fill(Table *t, PetscInt n, PetscReal shift, PetscReal rate_shift)
{
  t->width = 3;
  for (PetscInt i = 0; i <= n; i++) {
    const PetscReal time = 2 * (PetscReal)i / (PetscReal)n;
    const PetscReal row[] = {time, time * time + shift * time, 2 * time + (i == n / 2 ? rate_shift : 0)};

    PetscCall(TableAdd(t, row));
  }
  return PETSC_SUCCESS;
}

/* An error that grows as 0.1 t: 0.2 at the end of 4, the largest there too; int (0.1 t)^2 = 0.01 * 8/3, int t^4 =
   32/5. */
static void test_known_errors(void **state)
{
  Evaluation p = {.nstates = 1, .ncolumns = 2, .rate = 1, .relative = PETSC_TRUE};
  Table ref = {0}, run = {0};
  EvaluateResult r = {0};

  ok(Fill(&ref, 400, 0, 0));
  ok(Fill(&run, 200, 0.1, 0.5));
  ok(EvaluateErrors(&p, NULL, &ref, &run, &r));
  assert_true(fabs(r.final - 4.2) < ROUNDING);
  assert_true(fabs(r.final_error - 0.05) < ROUNDING);
  assert_true(fabs(r.max_error - 0.05) < ROUNDING);
  assert_true(fabs(r.rate_error - 0.125) < ROUNDING); /* 0.5 of 4 */
  /* the trapezoidal rule with h = 0.01 errs by h^2/12 times the change of the integrand's slope, about 1e-4 relative */
  assert_true(fabs(r.l2_error / sqrt(0.01 * 8 / 3 / 6.4) - 1) < 2e-4);
  ok(TableClear(&ref));
  ok(TableClear(&run));
}

/* The reference is taken linear between its rows: at t = 0.5, halfway between 0 and 1 of a reference with step 1, y
   is 0.5. */
static void test_between_rows(void **state)
{
  Evaluation p = {.nstates = 1, .ncolumns = 2, .rate = -1, .relative = PETSC_FALSE};
  const PetscReal rows[][3] = {{0, 0, 0}, {0.5, 0.25, 0}, {2, 4, 0}};
  Table ref = {0}, run = {.width = 3};
  EvaluateResult r = {0};

  ok(Fill(&ref, 2, 0, 0));
  for (int i = 0; i < 3; i++) ok(TableAdd(&run, rows[i]));
  ok(EvaluateErrors(&p, NULL, &ref, &run, &r));
  assert_true(fabs(r.max_error - 0.25) < ROUNDING);
  assert_true(fabs(r.final_error) < ROUNDING);
  assert_true(isnan(r.rate_error));
  /* errors 0, 0.25, 0 at 0, 0.5, 2: int e^2 = 0.0625 (0.5 + 1.5)/2, over the duration 2 */
  assert_true(fabs(r.l2_error - sqrt(0.0625 / 2)) < ROUNDING);
  ok(TableClear(&ref));
  ok(TableClear(&run));
}

static PetscErrorCode Exact(void *model, PetscReal t, PetscReal row[])
{
  row[0] = *(const PetscReal *)model * t;
  row[1] = 0;
  return PETSC_SUCCESS;
}

/* Two states, an exact solution (3 t, 0), errors (0, 1) at every row but the first: norms of both states. */
static void test_exact_solution_of_two_states(void **state)
{
  PetscReal slope = 3;
  Evaluation p = {.nstates = 2, .ncolumns = 2, .rate = -1, .relative = PETSC_TRUE, .exact = Exact};
  const PetscReal rows[][3] = {{0, 0, 0}, {1, 3, 1}, {2, 6, 1}};
  Table ref = {.width = 3}, run = {.width = 3};
  EvaluateResult r = {0};

  for (int i = 0; i < 3; i++) {
    const PetscReal row[] = {rows[i][0], rows[i][1], 0};

    ok(TableAdd(&ref, row));
    ok(TableAdd(&run, rows[i]));
  }
  ok(EvaluateErrors(&p, &slope, &ref, &run, &r));
  assert_true(fabs(r.final_error - 1.0 / 6) < ROUNDING);
  assert_true(fabs(r.max_error - 1.0 / 6) < ROUNDING);
  assert_true(fabs(r.l2_error - sqrt(1.5 / (4.5 + 22.5))) < ROUNDING);
  ok(TableClear(&ref));
  ok(TableClear(&run));
}

SLIP_TESTS(test_known_errors, test_between_rows, test_exact_solution_of_two_states)
