/* Courses of slip, their distance and the measures of a run. */
#include "unit.h"
#include <slipstep/rooms/slipcore.h>
#include <math.h>

#define near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

enum { NODES = 7, REFERENCE = 11 };

static PetscReal at(PetscInt n, const SlipCourseNode c[], PetscReal t)
{
  for (PetscInt k = 0; k + 1 < n; k++)
    if (t >= c[k].time && t < c[k + 1].time) {
      const PetscReal h = c[k + 1].time - c[k].time, x = (t - c[k].time) / h;

      /* Hermite's basis as textbooks have it */
      return c[k].slip * (1 + 2 * x) * (1 - x) * (1 - x) + h * c[k].rate * x * (1 - x) * (1 - x) +
             c[k + 1].slip * x * x * (3 - 2 * x) + h * c[k + 1].rate * x * x * (x - 1);
    }
  return t < c[0].time ? c[0].slip : c[n - 1].slip;
}

/* s = (1 - cos(pi t/T))/2 until T, at rest then; shifted and scaled */
static void swing(PetscInt n, PetscReal start, PetscReal T, PetscReal size, SlipCourseNode c[])
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal x = (PetscReal)k / (PetscReal)(n - 1);

    c[k].time = start + T * x;
    c[k].slip = size * (1 - cos(PETSC_PI * x)) / 2;
    c[k].rate = size * PETSC_PI / T * sin(PETSC_PI * x) / 2;
  }
}

/* Against the largest of dense samples: that is below by at most (dt/2)^2/2 of the second derivative of the distance,
   some (pi/T)^2 size = 10 [m/s^2] here, 2e-9 for dt = 4e-5 */
static void test_distance(void **state)
{
  SlipCourseNode a[NODES], b[REFERENCE];
  PetscReal error[SLIP_NUM_ERRORS], most = 0;

  swing(NODES, 0.1, 1.1, 1.2, a);
  swing(REFERENCE, 0, 1, 1, b);
  for (PetscInt i = 0; i <= 40000; i++)
    most = PetscMax(most, fabs(at(NODES, a, i * 4e-5) - at(REFERENCE, b, i * 4e-5)));
  SlipCourseCompare(NODES, a, REFERENCE, b, error);
  near(error[SLIP_ERROR_HISTORY], most, 3e-9);
  /* the other way round only the scale changes */
  SlipCourseCompare(REFERENCE, b, NODES, a, error);
  near(1.2 * error[SLIP_ERROR_HISTORY], most, 3e-9);
}

/* In closed form: a cubic is its own interpolation. s = 3 t^2 - 2 t^3 of [0, 1], rate 6 t (1 - t) */
static void test_cubic(void **state)
{
  const SlipCourseNode whole[] = {{0, 0, 0}, {1, 1, 0}};
  const SlipCourseNode half[] = {{0, 0, 0}, {0.25, 0.15625, 1.125}, {0.5, 0.5, 1.5}, {1, 1, 0}};
  const SlipCourseNode late[] = {{0, 0, 0}, {0.2, 0, 0}, {1.2, 1.1, 0}};
  PetscReal error[SLIP_NUM_ERRORS], rise;

  near(SlipCourseTime(2, whole, 0.5), 0.5, 1e-15);
  near(SlipCoursePeak(2, whole), 1.5, 1e-15);
  near(SlipCoursePeak(4, half), 1.5, 1e-15);
  /* 3 t^2 - 2 t^3 = 0.1, and its mirror image */
  rise = 1 - 2 * SlipCourseTime(2, whole, 0.1);
  near(SlipCourseTime(2, whole, 0.9), 1 - SlipCourseTime(2, whole, 0.1), 1e-14);
  near(pow(SlipCourseTime(2, whole, 0.1), 2) * (3 - 2 * SlipCourseTime(2, whole, 0.1)), 0.1, 1e-14);
  SlipCourseCompare(4, half, 2, whole, error);
  for (PetscInt i = 0; i < SLIP_NUM_ERRORS; i++) near(error[i], 0, 1e-14);
  SlipCourseCompare(3, late, 2, whole, error);
  near(error[SLIP_ERROR_FINAL], 0.1, 1e-14);
  near(error[SLIP_ERROR_SHIFT], 0.2 / rise, 1e-13);
  near(error[SLIP_ERROR_PEAK], 0.1, 1e-14);
  near(error[SLIP_ERROR_FIELD], 0, 0);
}

/* Edges: a run of one node, nothing slipped, and a cubic that goes back in between */
static void test_edges(void **state)
{
  const SlipCourseNode rest[] = {{3, 0, 0}}, whole[] = {{0, 0, 0}, {1, 1, 0}};
  const SlipCourseNode wave[] = {{0, 0, 12}, {1, 1, 12}};
  PetscReal error[SLIP_NUM_ERRORS], t;

  near(SlipCourseTime(1, rest, 0.5), 3, 0);
  near(SlipCoursePeak(1, rest), 0, 0);
  SlipCourseCompare(1, rest, 2, whole, error);
  near(error[SLIP_ERROR_FINAL], 1, 0);
  near(error[SLIP_ERROR_HISTORY], 1, 0);
  near(error[SLIP_ERROR_PEAK], 1, 0);
  t = SlipCourseTime(2, wave, 0.9); /* before the first hill, which is at 0.24 */
  assert_true(t < 0.24);
  near(at(2, wave, t), 0.9, 1e-13);
}

static void test_measures(void **state)
{
  const PetscReal error[SLIP_NUM_ERRORS] = {0.01, 0.02, 0.03, 0.2, 0.035};
  const PetscReal broken[SLIP_NUM_ERRORS] = {0.01, NAN, 0.03, 0.2, 0.035};

  assert_string_equal(SlipMeasures[0].name, "history");
  near(SlipMeasureOf(SlipMeasureFind("history"), error), 0.04, 1e-16);
  near(SlipMeasureOf(SlipMeasureFind("final_slip"), error), 0.01, 0);
  near(SlipMeasureOf(SlipMeasureFind("event_time"), error), 0.03, 0);
  assert_true(isnan(SlipMeasureOf(SlipMeasureFind("history"), broken)));
  near(SlipMeasureOf(SlipMeasureFind("final_slip"), broken), 0.01, 0);
  assert_null(SlipMeasureFind("slip"));
}

/* Of a jump at the end of rest, half of the way, and slips at the end that differ: the jump's time counts over the
   duration, the slip over the final one. Of straight lines with slopes 1 and 0.8, from the end of one time back: half
   of what they differ by would do with both along the diagonal, but the courses end there, so that all of it counts. */
static void test_levy(void **state)
{
  const SlipCourseNode early[] = {{0, 0, 0}, {40, 0, 0}, {40.001, 1, 0}, {100, 2, 1e-2}};
  const SlipCourseNode late[] = {{0, 0, 0}, {43, 0, 0}, {43.001, 1, 0}, {100, 2, 1e-2}};
  const SlipCourseNode slow[] = {{0, 0, 0}, {40, 0, 0}, {40.001, 0.9, 0}, {100, 0.9, 0}};
  const SlipCourseNode fast[] = {{0, 0, 0}, {40, 0, 0}, {40.001, 1, 0}, {100, 1, 0}};
  const SlipCourseNode line[] = {{0, 0, 1}, {1, 1, 1}}, lower[] = {{0, 0, 0.8}, {1, 0.8, 0.8}};
  const SlipCourseNode bold[] = {{0, 0, 1}, {0.5, 0.5, 1}, {1, 1, 50}};
  PetscReal error[SLIP_NUM_ERRORS];

  near(SlipCourseLevy(4, early, 4, early), 0, 0);
  near(SlipCourseLevy(4, late, 4, early), 0.03, 2e-5);
  near(SlipCourseLevy(4, early, 4, late), 0.03, 2e-5);
  near(SlipCourseLevy(4, slow, 4, fast), 0.1, 1e-14);
  near(SlipCourseLevy(2, lower, 2, line), 0.2, 1e-14);
  SlipCourseCompare(4, late, 4, early, error);
  assert_true(error[SLIP_ERROR_HISTORY] > 0.4); /* what a difference at equal times makes of the jump */
  /* A rate that outruns the slip of its step does not make the slip fall: a cubic with ends 1 and 3 times the mean is
     4/27 off from the line at most, one that rests and then jumps would be a quarter. */
  assert_true(SlipCourseLevy(3, bold, 2, line) < 0.149);
  /* one node: rest */
  near(SlipCourseLevy(1, line, 2, line), 1, 1e-14);
}

SLIP_TESTS(test_distance, test_cubic, test_edges, test_measures, test_levy)
