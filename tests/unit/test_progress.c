/* Lines of progress: when they are due, and how long a run will take. */
#include "unit.h"
#include <slipstep/private/sliprun.h>
#include <math.h>

/* elapsed and since [s]; before the first line they are the same */
static void due(void **state)
{
  assert_false(SlipFaultProgressDue(PETSC_TRUE, 1.9, 1.9));
  assert_true(SlipFaultProgressDue(PETSC_TRUE, 2, 2));
  assert_false(SlipFaultProgressDue(PETSC_TRUE, 6.9, 4.9));
  assert_true(SlipFaultProgressDue(PETSC_TRUE, 7, 5));
  assert_false(SlipFaultProgressDue(PETSC_FALSE, 59.9, 59.9));
  assert_true(SlipFaultProgressDue(PETSC_FALSE, 60, 60));
  assert_false(SlipFaultProgressDue(PETSC_FALSE, 100, 40));
}

/* A run of 100 years, of which seconds take the wall time: 10 s of each cycle of 20 years, 9 of them in its event */
static void left(void **state)
{
  const PetscReal year = 31557600, bound = 1e-3;
  SlipFaultProgress p = {.begin = 1000};

  /* by the time that has passed where nothing drives the fault, or it has had no event */
  assert_true(fabs(SlipFaultProgressLeft(&p, PETSC_FALSE, 1010, 5, 30) - 50) < 1e-12);
  SlipFaultProgressSee(&p, 1001, 10 * year, 1e-9, bound);
  assert_true(fabs(SlipFaultProgressLeft(&p, PETSC_TRUE, 1001, 10 * year, 100 * year) - 9) < 1e-12);
  /* in the first event, and after it, nobody knows; that a rate touches the bound is no onset */
  SlipFaultProgressSee(&p, 1001, 10 * year, 1.1e-3, bound);
  SlipFaultProgressSee(&p, 1002, 10 * year + 1, 0.9e-3, bound);
  SlipFaultProgressSee(&p, 1003, 10 * year + 2, 2, bound);
  assert_true(SlipFaultProgressLeft(&p, PETSC_TRUE, 1003, 10 * year + 2, 100 * year) < 0);
  SlipFaultProgressSee(&p, 1010, 10 * year + 90, 1e-5, bound);
  assert_true(SlipFaultProgressLeft(&p, PETSC_TRUE, 1010.5, 20 * year, 100 * year) < 0);
  assert_int_equal(1, p.onsets);
  /* in the second: 10 s for each 20 of the 70 years, less what has passed of the event */
  SlipFaultProgressSee(&p, 1011, 30 * year, 1e-2, bound);
  SlipFaultProgressSee(&p, 1015, 30 * year, 1, bound);
  assert_int_equal(2, p.onsets);
  assert_true(fabs(SlipFaultProgressLeft(&p, PETSC_TRUE, 1015, 30 * year, 100 * year) - (35 - 4)) < 1e-9);
  /* an aftershock's distance is no cycle */
  p.newest_time = p.first_time + 3600;
  assert_true(SlipFaultProgressLeft(&p, PETSC_TRUE, 1015, 30 * year, 100 * year) < 0);
}

SLIP_TESTS(due, left)
