/* -fault_hmat_tolerance by default: what it follows from, and that set-up fixes it. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>

/* Creates a fault that has read options. */
static SlipFault Read(const char options[])
{
  SlipFault fault;

  ok(PetscOptionsClear(NULL));
  ok(PetscOptionsInsertString(NULL, options));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 12}, {"nz", 10}));
  ok(FaultSetStrings(fault, {"operator", "hmat"}));
  ok(SlipFaultSetFromOptions(fault));
  return fault;
}

/* A hundredth of the wanted error, between bounds; an option that asks for less error counts, one for more does not. */
static void follows(void **state)
{
  static const struct {
    const char *options;
    PetscReal tolerance;
    const char *why;
  } rows[] = {{"", 1e-4, "from -fault_accuracy 0.01"},
              {"-fault_accuracy 1e-3", 1e-5, "from -fault_accuracy 0.001"},
              {"-fault_accuracy 4e-3", 4e-5, "from -fault_accuracy 0.004"},
              {"-fault_accuracy 0.1", 1e-4, "from -fault_accuracy 0.1"},
              {"-ts_rtol 1e-5", 1e-7, "from -ts_rtol 1e-05"},
              {"-ts_rtol 0.3", 1e-4, "from -fault_accuracy 0.01"},
              {"-ts_rtol 1e-12", 1e-8, "from -ts_rtol 1e-12"},
              {"-ts_rtol 3e-3 -fault_accuracy 1e-3", 1e-5, "from -fault_accuracy 0.001"},
              {"-ts_adapt_rl_accuracy 2e-3", 2e-5, "from -ts_adapt_rl_accuracy 0.002"},
              {"-ts_adapt_type none -ts_dt 1", 1e-8, "as steps are given"},
              {"-ts_adapt_type none -ts_dt 1 -fault_accuracy 2e-3", 2e-5, "from -fault_accuracy 0.002"},
              {"-ts_adapt_type pi", 1e-4, "from -fault_accuracy 0.01"},
              {"-fault_hmat_tolerance 1e-3 -fault_accuracy 1e-3", 1e-3, "as asked"}};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++) {
    SlipFault fault = Read(rows[i].options);
    PetscReal tolerance;

    for (int after = 0; after < 2; after++) {
      if (after) ok(SlipFaultSetUp(fault));
      ok(SlipFaultGetReal(fault, "hmat_tolerance", &tolerance));
      AssertNear(tolerance, rows[i].tolerance, 1e-12 * rows[i].tolerance);
    }
    assert_string_equal(fault->operators.hmat_why, rows[i].why);
    ok(SlipFaultDestroy(&fault));
  }
  ok(PetscOptionsClear(NULL));
}

/* A fault that reads no options does not take those of others, and one with a prefix takes its own. */
static void own_options(void **state)
{
  SlipFault fault;
  PetscReal tolerance;

  ok(PetscOptionsClear(NULL));
  ok(PetscOptionsInsertString(NULL, "-ts_rtol 1e-6 -a_ts_rtol 1e-4"));
  for (int prefix = 0; prefix < 2; prefix++) {
    ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
    if (prefix) ok(SlipFaultSetOptionsPrefix(fault, "a_"));
    if (prefix) ok(SlipFaultSetFromOptions(fault));
    ok(SlipFaultSetUp(fault));
    ok(SlipFaultGetReal(fault, "hmat_tolerance", &tolerance));
    AssertNear(tolerance, prefix ? 1e-6 : 1e-4, 1e-18);
    assert_string_equal(fault->operators.hmat_why, prefix ? "from -a_ts_rtol 0.0001" : "from -fault_accuracy 0.01");
    ok(SlipFaultDestroy(&fault));
  }
  ok(PetscOptionsClear(NULL));
}

/* The accuracy may change after set-up, with which the stiffness does not. */
static void fixed(void **state)
{
  SlipFault fault = Read("");
  PetscReal tolerance;

  ok(SlipFaultSetUp(fault));
  ok(SlipFaultSetReal(fault, "accuracy", 1e-3));
  ok(SlipFaultGetReal(fault, "hmat_tolerance", &tolerance));
  AssertNear(tolerance, 1e-4, 1e-16);
  ok(SlipFaultDestroy(&fault));
}

SLIP_TESTS(follows, own_options, fixed)
