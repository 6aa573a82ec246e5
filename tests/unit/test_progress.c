/* Lines of progress: when they are due, and times in fitting units. */
#include "unit.h"
#include <slipstep/private/slipfault.h>

static void expect_time(PetscReal seconds, const char want[])
{
  char text[64];

  SlipFaultTimeText(seconds, text, sizeof(text));
  assert_string_equal(want, text);
}

static void times(void **state)
{
  (void)state;
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

/* elapsed and since [s]; before the first line they are the same */
static void due(void **state)
{
  (void)state;
  assert_false(SlipFaultProgressDue(PETSC_TRUE, 1.9, 1.9));
  assert_true(SlipFaultProgressDue(PETSC_TRUE, 2, 2));
  assert_false(SlipFaultProgressDue(PETSC_TRUE, 6.9, 4.9));
  assert_true(SlipFaultProgressDue(PETSC_TRUE, 7, 5));
  assert_false(SlipFaultProgressDue(PETSC_FALSE, 59.9, 59.9));
  assert_true(SlipFaultProgressDue(PETSC_FALSE, 60, 60));
  assert_false(SlipFaultProgressDue(PETSC_FALSE, 100, 40));
}

SLIP_TESTS(times, due)
