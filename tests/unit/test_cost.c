/* What work costs (src/sys/workcounts.c): for whom it is, sums without rounding, and what PETSc's log counts. */
#define _POSIX_C_SOURCE 200809L /* of workcounts.c */
#include "../../src/sys/workcounts.c"
#include "unit.h"

static PetscReal CostOf(SlipProductsUser user)
{
  SlipProducts p;

  SlipProductsGetOf(user, &p);
  return p.cost;
}

/* Rows add up to the run to the bit, in whatever order work is done, and each is its work at the prices, to the quantum
   of each piece. */
static void rows_add_up(void **state)
{
  SlipWorkTotals before;
  SlipProducts last = {0};
  PetscReal sum = 0, expected = 0, begin;

  SlipProductsRun();
  before = SlipWorkGet();
  (void)SlipProductsRow(&last);
  begin = CostOf(SLIP_PRODUCTS_RUN);
  for (int i = 0; i < 1000; i++) {
    PetscReal row = 0, cost;

    for (int k = 0; k < 5; k++) {
      const SlipWork work = (SlipWork)(SLIP_WORK_PRODUCT + (7 * i + 3 * k) % (SLIP_WORK_PIECE - SLIP_WORK_PRODUCT));
      const PetscReal units = 1 + (i * (k + 1)) % 97;

      SlipWorkAdd(work, units);
      row += units * WorkPrices[work];
    }
    cost = SlipProductsRow(&last).cost;
    assert_true(PetscAbsReal(cost - row) <= 5 * QUANTUM / 2 + 1e-15 * row);
    sum += cost;
    expected += row;
  }
  assert_true(sum == CostOf(SLIP_PRODUCTS_RUN) - begin);
  AssertNear(sum / expected, 1, 1e-4);
  {
    const SlipWorkTotals after = SlipWorkGet();
    PetscReal shares = 0;

    for (int i = 0; i < SLIP_SHARES; i++) shares += after.cost[i] - before.cost[i];
    AssertNear(shares / sum, 1, 1e-12);
  }
}

/* Flops of vectors are those that PETSc logs beside the ones of a kind of their own. */
static void flops_of_vectors_are_the_rest(void **state)
{
  SlipWorkTotals before, after;

  SlipProductsRun();
  before = SlipWorkGet();
  ok(PetscLogFlops(1000));
  ok(SlipWorkFlops(SLIP_WORK_TRANSFORM, 2000.7));
  ok(PetscLogFlops(70));
  SlipWorkLogged(SLIP_WORK_DENSE, 30);
  after = SlipWorkGet();
  assert_true(after.units[SLIP_WORK_VECTOR][SLIP_SHARE_CELLS] - before.units[SLIP_WORK_VECTOR][SLIP_SHARE_CELLS] ==
              1040);
  assert_true(after.units[SLIP_WORK_TRANSFORM][SLIP_SHARE_PRODUCTS] -
                before.units[SLIP_WORK_TRANSFORM][SLIP_SHARE_PRODUCTS] ==
              2000);
}

/* What is done for set-up or output is theirs, and the next run finds nothing that an error has left begun. */
static void errors_leave_nothing(void **state)
{
  SlipWorkTotals begin, end;
  PetscReal run;

  for (int i = 0; i < 20; i++) {
    SlipProductsRun();
    ok(SlipProductsPush(SLIP_PRODUCTS_LOOK));
    ok(SlipProductsPush(SLIP_PRODUCTS_SETUP));
    for (int k = 0; k < 5; k++) SlipWorkBegin(SLIP_SHARE_PRODUCTS); /* and an error */
  }
  begin = SlipWorkGet();
  SlipWorkAdd(SLIP_WORK_RUN, 1);
  SlipWorkAdd(SLIP_WORK_VECTOR, 1e6);
  end = SlipWorkGet();
  AssertNear((end.cost[SLIP_SHARE_SETUP] - begin.cost[SLIP_SHARE_SETUP]) /
               (WorkPrices[SLIP_WORK_RUN] + 1e6 * WorkPrices[SLIP_WORK_VECTOR]),
             1, 1e-6);
  assert_true(end.cost[SLIP_SHARE_CELLS] == begin.cost[SLIP_SHARE_CELLS]);
  SlipProductsRun();
  assert_true(depth == 0 && last == 0);
  run = CostOf(SLIP_PRODUCTS_RUN);
  SlipWorkAdd(SLIP_WORK_VECTOR, 1e6);
  SlipWorkAdd(SLIP_WORK_READ, 1); /* no attempt's, wherever it is met */
  SlipWorkAdd(SLIP_WORK_NUMBER, 1e6);
  AssertNear((CostOf(SLIP_PRODUCTS_RUN) - run) / (1e6 * WorkPrices[SLIP_WORK_VECTOR]), 1, 1e-4);
}

/* Of what is measured each share has what was done in it, to the clock's own time, and all of them the whole. */
static void shares_are_measured(void **state)
{
  SlipWorkTotals before, after;
  PetscReal begin, sum = 0;

  SlipProductsRun();
  SlipWorkMeasure();
  before = SlipWorkGet();
  begin = clock_seen;
  for (int i = 0; i < 20; i++) {
    SlipWorkBegin(SLIP_SHARE_PRODUCTS);
    for (const PetscReal to = SlipProcessorTime() + 2e-3; SlipProcessorTime() < to;) continue;
    SlipWorkBegin(SLIP_SHARE_DIRECT);
    for (const PetscReal to = SlipProcessorTime() + 1e-3; SlipProcessorTime() < to;) continue;
    SlipWorkEnd();
    SlipWorkEnd();
  }
  after = SlipWorkGet();
  for (int i = 0; i < SLIP_SHARES; i++) sum += after.seconds[i] - before.seconds[i];
  AssertNear(sum / (clock_seen - begin), 1, 1e-9);
  AssertNear(after.seconds[SLIP_SHARE_PRODUCTS] - before.seconds[SLIP_SHARE_PRODUCTS], 40e-3, 4e-3);
  AssertNear(after.seconds[SLIP_SHARE_DIRECT] - before.seconds[SLIP_SHARE_DIRECT], 20e-3, 2e-3);
}

SLIP_TESTS(rows_add_up, flops_of_vectors_are_the_rest, errors_leave_nothing, shares_are_measured)
