/* What attempts cost by the prices of some calls (src/sys/products.c), against work whose processor time is known. */
#include "../../src/sys/products.c"
#include "unit.h"

/* Work of so much processor time [s], whatever else the machine does */
static void Work(PetscReal seconds)
{
  struct timespec begin, now;

  assert_int_equal(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin), 0);
  do assert_int_equal(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now), 0);
  while ((PetscReal)(now.tv_sec - begin.tv_sec) + 1e-9 * (PetscReal)(now.tv_nsec - begin.tv_nsec) < seconds);
}

/* Attempts cost what was done in them, by the prices of some calls: two kinds of work of which one is part of the
   other and has units, and the rest of an attempt, in turn much of one and much of the other. A tenth is for reading
   clocks. */
static void cost_is_what_was_done(void **state)
{
  const PetscReal outer_price = 4e-5, inner_price = 2e-5, rest_price = 6e-5; /* [s] a unit */
  SlipMeter outer = {0}, inner = {0};
  SlipCost cost = {.rows = 0};
  SlipProducts row;
  PetscReal sum[2] = {0, 0}, expected[2] = {0, 0};

  (void)state;
  SlipProductsRun();
  SlipCostStart(&cost);
  for (int i = 0; i < 300; i++) {
    const int calls = i % 2 ? 5 : 1, units = 1 + i % 3, rest = i % 2 ? 1 : 4;

    for (int k = 0; k < calls; k++) {
      SlipMeterBegin(&outer);
      Work(outer_price);
      SlipMeterBegin(&inner);
      Work(inner_price * units);
      SlipMeterEnd(&inner, units);
      SlipMeterEnd(&outer, 1);
    }
    Work(rest_price * rest);
    SlipCostRow(&cost, rest, &row);
    if (i < 20) continue; /* the first calls prepare others, and have no price */
    sum[i % 2] += row.cost;
    expected[i % 2] += calls * (outer_price + inner_price * units) + rest_price * rest;
  }
  for (int odd = 0; odd < 2; odd++) {
    printf("%g s of %g s\n", sum[odd], expected[odd]);
    AssertNear(sum[odd] / expected[odd], 1, 0.1);
  }
}

/* Meters that an error has left running are gone when the next run begins, and so is for whom products were made. */
static void errors_leave_nothing(void **state)
{
  SlipMeter outer = {0}, inner = {0};
  SlipProducts before, after;

  (void)state;
  for (int i = 0; i < 20; i++) {
    SlipProductsRun();
    ok(SlipProductsPush(SLIP_PRODUCTS_LOOK));
    ok(SlipProductsPush(SLIP_PRODUCTS_SETUP));
    SlipMeterBegin(&outer); /* and an error */
  }
  SlipProductsRun();
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, &before);
  for (int i = 0; i < 9; i++) {
    SlipMeterBegin(&inner);
    Work(1e-3);
    SlipMeterEnd(&inner, 1);
    SlipProductsAdd((SlipProducts){.k = 1});
  }
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, &after);
  assert_true(after.k - before.k == 9 && running == 0 && last == 0);
  AssertNear(inner.seconds / inner.units, 1e-3, 1e-4); /* interrupts take some 1e-5 s */
}

SLIP_TESTS(cost_is_what_was_done, errors_leave_nothing)
