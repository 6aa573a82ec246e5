/* What steps of sequences are trained by: the error of segments. */
#include "unit.h"
#include "runs/sequences.h"

enum { STREAM = 97 }; /* of seeds, neither training's nor the benchmark's */

static PetscReal largest(const PetscReal errors[])
{
  PetscReal most = 0;

  for (PetscInt i = 0; i < SEGMENT_NUM_ERRORS; i++) most = PetscMax(most, errors[i]);
  return most;
}

/* The reference again is exact. Runs at tolerances a thousand times apart differ by the power of two thirds of that, 100, where the
   tolerance bounds all steps: by more than 10 in the geometric mean of a few segments, as loose ones are held by instabilities too, and
   single errors pass through zero. */
static void measured(void **state)
{
  PetscReal ratio = 0;
  PetscInt n = 6;

  (void)state;
  for (PetscInt k = 0; k < n; k++) {
    PetscReal errors[SEGMENT_NUM_ERRORS], same, coarse, fine;
    PetscInt solves[2], rejected;
    SegmentEpisode e;

    ok(SegmentEpisodeCreate(RandomStreamHashed(77, STREAM, k), 0, &e));
    assert_true(e.step > 0 && e.step < e.end - e.first && e.size > 0 && e.interval > 0);
    assert_int_equal(e.reference.events, e.kind == SEGMENT_WITHIN ? 0 : 1);
    ok(SegmentEpisodeRun(&e, NULL, 0, TSADAPTPI, SEGMENT_REFERENCE_RTOL, &solves[0], &rejected, errors, &same));
    assert_true(same == 0);
    assert_int_equal(solves[0], e.reference.solves);
    ok(SegmentEpisodeRun(&e, NULL, 0, TSADAPTPI, 1e-4, &solves[0], &rejected, errors, &fine));
    AssertNear(fine, largest(errors), 0);
    ok(SegmentEpisodeRun(&e, NULL, 0, TSADAPTPI, 1e-1, &solves[1], &rejected, errors, &coarse));
    assert_true(fine > 0 && coarse > 0 && solves[1] < solves[0]);
    ratio += PetscLogReal(coarse / fine) / (PetscReal)n;
    ok(SegmentEpisodeDestroy(&e));
  }
  if (!(ratio > PetscLogReal(10))) fail_msg("ratio %g", (double)PetscExpReal(ratio));
}

/* An event that one of the two runs alone has counts as 1, and so does a run that is asked for another time than that of its event by
   a whole interval. */
static void missed(void **state)
{
  PetscReal errors[SEGMENT_NUM_ERRORS], error;
  PetscInt solves, rejected, k = 0;
  SegmentEpisode e;

  (void)state;
  ok(SegmentEpisodeCreate(RandomStreamHashed(77, STREAM, k), 0, &e));
  while (e.kind == SEGMENT_WITHIN) {
    ok(SegmentEpisodeDestroy(&e));
    ok(SegmentEpisodeCreate(RandomStreamHashed(77, STREAM, ++k), 0, &e));
  }
  e.reference.begin += e.interval / 8; /* within the segment, whose margin is more than that */
  ok(SegmentEpisodeRun(&e, NULL, 0, TSADAPTPI, SEGMENT_REFERENCE_RTOL, &solves, &rejected, errors, &error));
  AssertNear(errors[SEGMENT_ERROR_ONSET], 0.125, 1e-9);
  e.reference.begin -= e.interval / 8;
  e.reference.events = 2;
  ok(SegmentEpisodeRun(&e, NULL, 0, TSADAPTPI, SEGMENT_REFERENCE_RTOL, &solves, &rejected, errors, &error));
  assert_true(error == 1);
  ok(SegmentEpisodeDestroy(&e));
}

/* A segment is the same again, and others of its fault start elsewhere. */
static void drawn(void **state)
{
  PetscInt others = 0;
  PetscReal first = 0;

  (void)state;
  for (PetscInt k = 0; k < 5; k++) {
    SegmentEpisode e;

    ok(SegmentEpisodeCreate(RandomStreamHashed(77, STREAM, 2), k == 1 ? 0 : k, &e));
    if (k == 0) first = e.first;
    if (k == 1) assert_true(e.first == first);
    others += e.first != first ? 1 : 0;
    ok(SegmentEpisodeDestroy(&e));
  }
  assert_true(others > 0);
}

SLIP_TESTS(measured, missed, drawn)
