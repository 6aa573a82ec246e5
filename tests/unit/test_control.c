/* The pure rules of controllers and the formulas of observations, against PETSc's own rule and numbers by hand. */
#include "unit.h"
#include <petscts.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* PETSc matches the final time in TSAdaptChoose(), with its default factors. */
static void match(void **state)
{
  const PetscReal left[] = {10, 4.5, 2.02, 2.01, 1.999, 1.5, 1.0099, 0.995, 0.98, 0.3};
  TSAdapt adapt;
  TS ts;
  Vec w;

  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, TSEULER));
  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &w));
  ok(TSSetSolution(ts, w));
  ok(VecDestroy(&w));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, TSADAPTNONE));
  ok(TSSetTimeStep(ts, 1));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(left); i++) {
    PetscReal next;
    PetscBool accept;

    ok(TSSetMaxTime(ts, 1 + left[i])); /* the step just taken ends at 1 s */
    ok(TSAdaptChoose(adapt, ts, 1, NULL, &next, &accept));
    if (fabs(next - SlipControlMatch(1, left[i])) > 1e-14)
      fail_msg("%g s left: %.17g, PETSc's rule %.17g", (double)left[i], (double)SlipControlMatch(1, left[i]),
               (double)next);
  }
  ok(TSDestroy(&ts));
}

/* PETSc 3.22's TSAdaptChoose() ends a run with an error where this fails after a step, t being its end. */
static PetscBool petsc_goes_on(PetscReal t, PetscReal end)
{
  const PetscReal eps = 10 * PETSC_MACHINE_EPSILON, left = end - t;

  return left > eps || (fabs(left) <= eps && fabs(left) <= eps * PetscMax(fabs(t), fabs(end))) ? PETSC_TRUE
                                                                                               : PETSC_FALSE;
}

/* Steps from anywhere to the end of a run of ten to thousands of seconds: without the rule more than a hundred are
   refused. */
static void end_exactly(void **state)
{
  PetscInt beyond = 0, refused = 0;
  uint64_t x = 1;

  for (PetscInt i = 0; i < 20000; i++) {
    PetscReal u[2], end, t, h, used;

    for (PetscInt k = 0; k < 2; k++) { /* Knuth's MMIX */
      x = x * 6364136223846793005u + 1442695040888963407u;
      u[k] = (PetscReal)(x >> 11) / 9007199254740992.;
    }
    end = 10 * PetscPowReal(1000, u[0]);
    t = 0.7 * u[1] * u[1] * end;
    h = end - t;
    used = SlipControlEnd(h, t, end);
    beyond += t + h > end ? 1 : 0;
    refused += petsc_goes_on(t + h, end) ? 0 : 1;
    assert_true(used <= h && h - used <= 2 * PETSC_MACHINE_EPSILON * h);
    assert_true(t + used <= end && petsc_goes_on(t + used, end) && SlipControlAtEnd(t + used, end));
    assert_true(SlipControlEnd(2 * h, t, end) == 2 * h); /* not by rounding: not its business */
  }
  if (!(beyond > 100 && refused > 100)) fail_msg("%d beyond, %d refused", (int)beyond, (int)refused);
}

static void rest(void **state)
{
  assert_true(SlipControlRest(3, 2, 0, 50) == 2); /* something moves: no longer than the limit */
  assert_true(SlipControlRest(1, 2, 0, 50) == 1);
  assert_true(SlipControlRest(1, 2, 20, 50) == 20); /* at rest: to its end */
  assert_true(SlipControlRest(1, 2, PETSC_MAX_REAL, 50) == 50);
  assert_true(SlipControlRest(9, 2, 0.5, 50) == 2); /* and no shorter than the limit */
}

static void halve(void **state)
{
  PetscReal h = 8;

  assert_false(SlipControlHalve(2, 3, &h));
  assert_true(h == 8);
  assert_true(SlipControlHalve(3, 3, &h));
  assert_true(h == 4);
}

/* Powers of two, so that E^-q is exact to rounding: 64^(-1/3) = 1/4. */
static void ceiling(void **state)
{
  assert_true(fabs(SlipControlCeiling(128, 2, 1. / 3) - 0.25) < 1e-15);
  assert_true(SlipControlCeiling(1e9, 1, 1. / 3) == 0.1);
  assert_true(SlipControlCeiling(1.01, 1, 1. / 3) == 0.9);
}

static PetscReal of_fault(const char name[], const SlipFaultNumbers *f)
{
  PetscInt k, row = SlipObservationFind(name, &k);

  assert_true(row >= 0);
  assert_non_null(SlipObservations[row].fault);
  return (*SlipObservations[row].fault)(f);
}

/* Every row of a fault, by hand from numbers that tell the members apart */
static void fault_rows(void **state)
{
  SlipFaultNumbers f = {.tstar = 2,
                        .velocity_scale = 4,
                        .mean_dc = 0.5,
                        .mean_uc = 3,
                        .mean_q0 = 11,
                        .mean_drop = 7,
                        .drop_slip = 5,
                        .critical_energy = 13,
                        .velocity = 0.6,
                        .rate = 0.75,
                        .peak = 1.25,
                        .total_rate = 6,
                        .displacement = -1.5,
                        .slip = 0.25,
                        .sliding = 0.375,
                        .energy = 26,
                        .kinetic = 6.5,
                        .power = -39,
                        .strength = 22,
                        .weakening = 3.5,
                        .estimated = PETSC_TRUE,
                        .slip_error = 0.05,
                        .growth = 9,
                        .mass = 2,
                        .damping_ratio = 0.6,
                        .critical_stiffness = 25,
                        .critical_weakening = 32, /* root -3 + sqrt(9 - 25 + 32) = 1, so T_g = 1/5.5 */
                        .push = -0.75 * 5 * 2,    /* as much as w |v| M */
                        .relaxation = 50,
                        .step_limit = 1 / 34.,
                        .solve_cost = 25,
                        .mode_stiffness = 4,
                        .mode_weakening = 18.56}; /* root -1.2 + sqrt(1.44 - 4 + 18.56) = 2.8, so T_g = 1/3.4 */
  const struct {
    const char *name;
    double value;
  } want[] = {{"energy", 2},
              {"velocity", 0.15},
              {"log_velocity", log10(5)},
              {"log_mean_velocity", log10(3)},
              {"sliding_fraction", 0.375},
              {"slip", 0.5},
              {"displacement", -0.5},
              {"strength", 2},
              {"log_rate", log10(0.3)},
              {"log_peak_rate", log10(0.5)},
              {"progress", 0.05},
              {"weakening", 0.5},
              {"log_drop", 1},
              {"log_slip_error", -2},
              {"growth", asinh(3)},
              {"log_growth_time", -log10(6.8)},
              {"growth_rate", 2.8 / 3.4},
              {"start_growth_rate", 1 / 5.5},
              {"seen_growth", asinh(1.5 / 3.4)},
              {"log_mode_rate", log10(0.03)},
              {"log_push", log10(0.03)}, /* 7.5 over 2 x 25 x 5 */
              {"phase", -0.5},
              {"damping_ratio", 0.6},
              {"log_peak_ratio", log10(1.25 / 0.75)},
              {"kinetic", 0.5},
              {"log_energy_rate", log10(12)},
              {"log_step_limit", -1},
              {"log_solve_cost", log10(25)},
              {"log_relaxation", 2}};
  size_t rows = 0;

  for (const SlipObservation *o = SlipObservations; o->name; o++) rows += o->fault ? 1 : 0;
  assert_int_equal(PETSC_STATIC_ARRAY_LENGTH(want), rows); /* a new row needs a line here */
  for (size_t i = 0; i < rows; i++)
    if (fabs(of_fault(want[i].name, &f) - want[i].value) > 1e-14) /* some roundings of numbers up to 3 */
      fail_msg("%s is %.17g, expected %.17g", want[i].name, (double)of_fault(want[i].name, &f), want[i].value);
  f.estimated = PETSC_FALSE;
  assert_true(of_fault("log_slip_error", &f) == -3 && of_fault("growth", &f) == 0 && of_fault("seen_growth", &f) == 0);
  f.mode_weakening = 0; /* swings: the real part, in the time of the swing */
  assert_true(fabs(of_fault("growth_rate", &f) + 0.6) < 1e-15 &&
              fabs(of_fault("log_growth_time", &f) + log10(4)) < 1e-15);
  f.rate = f.push = 0;
  assert_true(of_fault("phase", &f) == 0 && of_fault("log_peak_ratio", &f) == 0 && of_fault("log_mode_rate", &f) == -8);
  f.critical_stiffness = 0; /* no critical state: in T* */
  assert_true(of_fault("start_growth_rate", &f) == 0);
  f.drop_slip = f.critical_energy = 0; /* friction that does not weaken: in d_c and Pa m */
  assert_true(of_fault("progress", &f) == 0.5 && of_fault("energy", &f) == 26);
}

static PetscReal of_run(const char name[], const SlipRunNumbers *r)
{
  PetscInt k, row = SlipObservationFind(name, &k);

  assert_true(row >= 0);
  assert_true(SlipObservations[row].reads & SLIP_READS_ATTEMPTS);
  return (*SlipObservations[row].run)(r);
}

/* The rows of the attempts so far, by hand: accepted at 2, rejected twice at 6 and 3, accepted at 1, failed at 4 */
static void attempts(void **state)
{
  const struct {
    PetscReal h, E;
    PetscBool converged, accepted;
    double error_step, ratio, rejected, rejections;
  } row[] = {{2, 1. / 8, PETSC_TRUE, PETSC_TRUE, log10(2), 0, 0, 0},
             {6, 27, PETSC_TRUE, PETSC_FALSE, -log10(3), log10(3), 1, 0.2},
             {3, 8, PETSC_TRUE, PETSC_FALSE, -log10(2), log10(1.5), 1, 0.36},
             {1, 1e-30, PETSC_TRUE, PETSC_TRUE, 1, -log10(2), 0, 0.288},
             {4, 0, PETSC_FALSE, PETSC_FALSE, -log10(2), log10(4), 0, 0.2304},
             {0.01, 0, PETSC_TRUE, PETSC_TRUE, 1, -1, 0, 0.18432}};
  SlipRunNumbers r = {0};

  assert_true(of_run("log_error_step", &r) == 0 && of_run("log_step_ratio", &r) == 0 && of_run("order", &r) == 0);
  r.order = 3;
  assert_true(of_run("order", &r) == 3);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++) {
    SlipRunAttempt(&r, row[i].h, row[i].converged, row[i].accepted);
    r.error = row[i].E;
    /* a few roundings of numbers below 1 */
    assert_true(fabs(of_run("log_error_step", &r) - row[i].error_step) < 1e-15);
    assert_true(fabs(of_run("log_step_ratio", &r) - row[i].ratio) < 1e-15);
    assert_true(of_run("rejected", &r) == row[i].rejected);
    assert_true(fabs(of_run("rejections", &r) - row[i].rejections) < 1e-15);
  }
  assert_true(SlipControlShrink(2, 1, 1) == 1 && SlipControlShrink(2, 3, 1) == 1.8 && SlipControlShrink(2, 3, 2) == 1);
}

static void methods(void **state)
{
  SlipMethodCosts costs;

  SlipMethodSetUp(&costs);
  assert_true(costs.step == 2 && costs.solve == 1); /* by hand: 0.25 (2 + 2) (8 + 2.2 sqrt x) */
  AssertNear(SlipMethodSolve(&costs, 0), 8, 1e-14);
  AssertNear(SlipMethodSolve(&costs, 4), 12.4, 1e-14);
  SlipMethodLearn(&costs, PETSC_FALSE, 1, 0, 100); /* without an explicit step there is nothing to compare with */
  assert_true(costs.solve == 1);
  SlipMethodLearn(&costs, PETSC_TRUE, 1, 0.1, 6); /* a quarter of what was new: 2 + (6 - 2)/4, and solves of it */
  AssertNear(costs.step, 3, 1e-14);
  AssertNear(SlipMethodSolve(&costs, 4), 0.25 * 5 * 12.4, 1e-14);
  costs.solve = 2; /* at least one step, and one more after an implicit one: 3 and 6 products against 2.5 (8 + ...) */
  assert_true(SlipMethodIsExplicit(&costs, 1e-3, 1, PETSC_FALSE));
  costs.solve = 0.25; /* 2.5 to 2.57 products: less than the one step, however short the way */
  assert_false(SlipMethodIsExplicit(&costs, 1e-3, 1, PETSC_FALSE));
  SlipMethodSetUp(&costs);
  costs.solve = 0.25; /* no way at all takes one step as well, and a tie is explicit: 2 of 2, and of 1.6 */
  assert_true(SlipMethodIsExplicit(&costs, 0, 1, PETSC_FALSE));
  costs.solve = 0.2;
  assert_false(SlipMethodIsExplicit(&costs, 0, 1, PETSC_FALSE));
  SlipMethodSetUp(&costs);
  assert_false(SlipMethodIsExplicit(&costs, 1, 0, PETSC_FALSE)); /* there is no explicit step */
  assert_true(SlipMethodIsExplicit(&costs, 1e9, PETSC_MAX_REAL, PETSC_TRUE));
  /* a solve over x steps takes 8 + 2.2 sqrt x, steps 2 ceil(x): 13.39 against 12 at x = 6, 13.50 against 14 at 6.25 */
  assert_true(SlipMethodIsExplicit(&costs, 0.6, 0.1, PETSC_FALSE));
  assert_false(SlipMethodIsExplicit(&costs, 0.625, 0.1, PETSC_FALSE));
  /* the first step after a solve counts twice: 12 against 12.92 at x = 5, 14 against 13.16 at 5.5 */
  assert_true(SlipMethodIsExplicit(&costs, 0.5, 0.1, PETSC_TRUE));
  assert_false(SlipMethodIsExplicit(&costs, 0.55, 0.1, PETSC_TRUE));
  assert_true(SlipMethodIsExplicit(&costs, 0.55, 0.1, PETSC_FALSE));
  /* solves that take 12 over 4 steps, not 12.4 */
  SlipMethodLearn(&costs, PETSC_FALSE, 0.4, 0.1, 109); /* the first takes the place of what was not known */
  assert_true(fabs(SlipMethodSolve(&costs, 4) - 109) < 1e-9);
  SlipMethodLearn(&costs, PETSC_FALSE, 0.4, 0.1, 109 - 40); /* a later one counts a quarter */
  assert_true(fabs(SlipMethodSolve(&costs, 4) - 99) < 1e-9);
  for (int i = 0; i < 100; i++) SlipMethodLearn(&costs, PETSC_FALSE, 0.4, 0.1, 12);
  assert_true(fabs(SlipMethodSolve(&costs, 4) - 12) < 1e-9);
  assert_true(fabs(SlipMethodSolve(&costs, 9) - 12 * 14.6 / 12.4) < 1e-9);
  assert_true(SlipMethodIsExplicit(&costs, 0.6, 0.1, PETSC_FALSE));
  assert_false(SlipMethodIsExplicit(&costs, 0.8, 0.1, PETSC_FALSE));
  for (int i = 0; i < 100; i++) SlipMethodLearn(&costs, PETSC_TRUE, 0.1, 0.1, 18);
  assert_true(fabs(costs.step - 18) < 1e-9 && fabs(SlipMethodSolve(&costs, 4) - 5 * 12) < 1e-7);
}

static void names(void **state)
{
  SlipObserved seen;

  SlipObservedSet(&seen, "change_log_step");
  assert_string_equal("log_step", seen.row->name);
  assert_true(SlipObservedOfState(&seen) && SlipObservedOfRun(&seen));
  assert_true(SlipObservedTake(&seen, 3) == 0 && SlipObservedTake(&seen, 5) == 2 && SlipObservedTake(&seen, 4) == -1);
  SlipObservedSet(&seen, "state_12");
  assert_int_equal(12, (int)seen.component);
  assert_true(SlipObservedOfState(&seen) && !SlipObservedOfRun(&seen));
  SlipObservedSet(&seen, "log_error");
  assert_true(!SlipObservedOfState(&seen) && !SlipObservedOfRun(&seen));
  SlipObservedSet(&seen, "log_step_ratio");
  assert_true(!SlipObservedOfState(&seen) && !SlipObservedOfRun(&seen));
  SlipObservedSet(&seen, "change_");
  assert_null(seen.row);
  SlipObservedSet(&seen, "weather");
  assert_true(!seen.row && SlipObservedOfState(&seen)); /* the problem may know it */
}

/* After a step whose error was all but 0, as of a block that has stuck, a filter's ratio is large whatever the error is
   now; after one that was reached by refused ones it may be small. No filter accepts an error that asks by itself for a
   shorter step than its least ratio, what it asks for then is shorter, and none refuses an error of 1 or less. */
static void filter_after_rest(void **state)
{
  const PetscReal q = (PetscReal)1 / 3;

  for (PetscInt i = 0; i < SLIP_NUM_FILTERS; i++) {
    const SlipFilter *f = &SlipFilters[i];
    const PetscReal most = PetscPowReal(f->r_min, -1 / q);
    PetscBool accept;

    for (PetscReal before = 1e-12; before < 1e13; before *= 10)
      for (PetscReal share = 0.001; share < 1e4; share *= 1.7) {
        SlipFilterMemory memory = {.error = before};
        const PetscReal ratio = SlipControlFilter(f, &memory, q, share * most, 1, PETSC_FALSE, &accept);

        if (share > 1) assert_false(accept);
        if (share * most <= 1) assert_true(accept && ratio >= f->r_min);
        if (!accept) {
          assert_true(ratio < 1 || share < 1);
          assert_true(memory.error == before); /* it moves on accepted steps alone */
        }
      }
  }
}

SLIP_TESTS(match, end_exactly, rest, halve, ceiling, fault_rows, attempts, methods, names, filter_after_rest)
