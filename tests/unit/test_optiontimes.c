/* Times with a unit in the options database: which options, which units, what stays as it is; and times in messages.
   Integers beyond PetscInt. */
#include "unit.h"
#include <slipstep/private/slipsys.h>
#include <stdlib.h>

static void check(PetscOptions options, const char option[], const char want[])
{
  char text[64];
  PetscBool set;

  ok(PetscOptionsGetString(options, NULL, option, text, sizeof(text), &set));
  assert_true(set);
  if (strcmp(text, want)) fail_msg("%s is %s, expected %s", option, text, want);
}

static void expand(void **state)
{
  static const struct {
    const char *option, *given, *want;
  } rows[] = {{"-ts_max_time", "100y", "3155760000"},
              {"-ts_dt", "1.5h", "5400"},
              {"-ts_adapt_dt_min", "2min", "120"},
              {"-ts_adapt_dt_max", "1e2d", "8640000"},
              {"-fault_healing_time", "90s", "90"},
              {"-fault_injection_stop", "20d", "1728000"},
              {"-fault_output_time_interval", "0.1y", "3155760"},
              {"-upper_fault_wall_limit", "12h", "43200"},
              {"-upper_ts_init_time", "-1d", "-86400"},
              {"-fault_checkpoint_interval", "30", "30"}, /* what stays */
              {"-fault_restart_dt", "1 y", "1 y"},
              {"-fault_initial_state", "1m", "1m"},
              {"-ts_time_step", "infinity", "infinity"},
              {"-fault_length_x", "3d", "3d"},
              {"-default_ts_rtol", "1y", "1y"},
              {"-ts_max_times", "1y", "1y"}};
  PetscOptions options;

  ok(PetscOptionsCreate(&options));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++)
    ok(PetscOptionsSetValue(options, rows[i].option, rows[i].given));
  for (int again = 0; again < 2; again++) ok(SlipExpandTimes(options)); /* twice is once */
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++) check(options, rows[i].option, rows[i].want);
  ok(PetscOptionsDestroy(&options));
}

/* A fault and a TS read them, each from its own database. */
static void read_by_objects(void **state)
{
  PetscReal value;
  SlipFault fault;
  TS ts;

  ok(PetscOptionsInsertString(NULL, "-upper_fault_healing_time 2y -ts_max_time 3h"));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetOptionsPrefix(fault, "upper_"));
  ok(SlipFaultSetFromOptions(fault));
  ok(SlipFaultGetReal(fault, "healing_time", &value));
  assert_true(value == 2 * 365.25 * 86400);
  ok(SlipFaultDestroy(&fault));
  ok(PetscOptionsSetValue(NULL, "-ts_max_time", "3h"));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(SlipCheckSolverOptions(ts));
  ok(TSSetFromOptions(ts));
  ok(TSGetMaxTime(ts, &value));
  assert_true(value == 3 * 3600);
  ok(TSDestroy(&ts));
  ok(PetscOptionsClear(NULL));
}

static void expect_time(PetscReal seconds, const char want[])
{
  char text[64];

  SlipTimeText(seconds, 4, text, sizeof(text));
  assert_string_equal(want, text);
}

static void written(void **state)
{
  expect_time(0, "0 s");
  expect_time(1e-3, "0.001 s");
  expect_time(119.5, "119.5 s");
  expect_time(120, "2 min");
  expect_time(7199, "120 min");
  expect_time(7200, "2 h");
  expect_time(47 * 3600, "47 h");
  expect_time(48 * 3600, "2 days");
  expect_time(365 * 86400., "365 days");
  expect_time(2 * 365.25 * 86400, "2 years");
  expect_time(113.44 * 365.25 * 86400, "113.4 years");
  expect_time(-3600, "-60 min");
}

/* One beyond PetscInt, which has 32 or 64 bits, is refused by its digits where it would be read as what is left of it;
   others stay. */
static void integers(void **state)
{
  static const char large[] = "36893488147419103236"; /* 2^65 + 4 */
  static const char *const read[] = {"-ts_max_steps", "-upper_ts_max_steps", "-ksp_gmres_restart",
                                     "-fault_start_ksp_max_it", "-snes_lag_jacobian"};
  static const char *const other[] = {"-ts_max_time", "-fault_shear_modulus", "-seed"};
  SlipFault fault;
  char text[64];
  TS ts;

  ok(SlipCheckInteger(PETSC_COMM_SELF, "n", "unlimited"));
  ok(SlipCheckInteger(PETSC_COMM_SELF, "n", "36893488147419103236.5"));
  ok(SlipCheckInteger(PETSC_COMM_SELF, "n", "1,-2,3-5:2"));
  ok(PetscSNPrintf(text, sizeof(text), "%" PetscInt_FMT ",%" PetscInt_FMT, PETSC_MAX_INT, PETSC_MIN_INT));
  ok(SlipCheckInteger(PETSC_COMM_SELF, "n", text));
  fails(SlipCheckInteger(PETSC_COMM_SELF, "n", "1,36893488147419103236"), "-n is 36893488147419103236, which is more");
  fails(SlipCheckInteger(PETSC_COMM_SELF, "n", "1-36893488147419103236:2"), "-n is 36893488147419103236");
  fails(SlipCheckInteger(PETSC_COMM_SELF, "n", "-36893488147419103236"), "-n is -36893488147419103236");
  if (sizeof(PetscInt) == 4)
    fails(SlipCheckInteger(PETSC_COMM_SELF, "n", "2147483648"),
          "-n is 2147483648, which is more than this build's integers hold, 2147483647");
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(other); i++) ok(PetscOptionsSetValue(NULL, other[i], large));
  ok(SlipCheckIntegers(PETSC_COMM_SELF, NULL));
  ok(PetscOptionsClear(NULL));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(read); i++) {
    ok(PetscSNPrintf(text, sizeof(text), "%s is %s", read[i], large));
    ok(PetscOptionsSetValue(NULL, read[i], large));
    fails(SlipCheckSolverOptions(ts), text);
    ok(PetscOptionsClear(NULL));
  }
  /* of an object's own, and a number that was never a text */
  ok(TSSetType(ts, TSADAMS));
  ok(PetscOptionsSetValue(NULL, "-ts_adams_max_order", large));
  fails(TSSetFromOptions(ts), "-ts_adams_max_order is 36893488147419103236");
  ok(TSDestroy(&ts));
  ok(PetscOptionsClear(NULL));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(PetscOptionsSetValue(NULL, "-fault_nx", large));
  fails(SlipFaultSetFromOptions(fault), "-fault_nx is 36893488147419103236");
  ok(PetscOptionsClear(NULL));
  if (sizeof(PetscInt) == 4)
    fails(SlipFaultSetReal(fault, "nx", 4294967316.0), "-fault_nx is 4294967316, which is more");
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(expand, read_by_objects, written, integers)
