/* What steps of sequences are trained by: the error of segments. */
#include "unit.h"
#include "runs/sequence.h"
#include <stdio.h>

enum { STREAM = 97 }; /* of seeds, neither training's nor the benchmark's */

static PetscReal largest(const PetscReal errors[])
{
  PetscReal most = 0;

  for (PetscInt i = 0; i < SEGMENT_NUM_ERRORS; i++) most = PetscMax(most, errors[i]);
  return most;
}

static SequenceEpisode *created(PetscInt k)
{
  RunEpisode *e;

  ok(RunEpisodeCreate(&RunSequence, NULL, 1, RandomStreamHashed(77, STREAM, k), &e));
  return (SequenceEpisode *)e;
}

static PetscInt run(SequenceEpisode *e, PetscReal rtol, EpisodeResult *r)
{
  ok(RunEpisodeRun(&e->base, NULL, TSADAPTPI, rtol, r));
  assert_true(r->done == 1);
  return r->solves;
}

/* The reference again is exact. Runs at tolerances a thousand times apart differ by the power of two thirds of that,
   100, where the tolerance bounds all steps: by more than 10 in the geometric mean of a few segments, as loose ones are
   held by instabilities too, and single errors pass through zero. */
static void measured(void **state)
{
  PetscReal ratio = 0;
  PetscInt n = 6;

  for (PetscInt k = 0; k < n; k++) {
    EpisodeResult same, fine, coarse;
    SequenceEpisode *e = created(k);
    const RunEpisode *base = &e->base;

    assert_true(base->step > 0 && base->step < base->end - base->begin && e->size > 0 && base->span > 0);
    assert_int_equal(base->reference.events, e->kind == SEGMENT_WITHIN ? 0 : 1);
    /* by which a run's cost is counted */
    assert_true(base->work > (PetscReal)base->usual);
    assert_int_equal(run(e, SEQUENCE_REFERENCE_RTOL, &same), base->reference.solves);
    assert_true(same.error == 0);
    run(e, 1e-4, &fine);
    AssertNear(fine.error, largest(fine.errors), 0);
    run(e, 1e-1, &coarse);
    assert_true(fine.error > 0 && coarse.error > 0 && coarse.solves < fine.solves);
    ratio += PetscLogReal(coarse.error / fine.error) / (PetscReal)n;
    ok(RunEpisodeDestroy((RunEpisode **)&e));
  }
  if (!(ratio > PetscLogReal(10))) fail_msg("ratio %g", (double)PetscExpReal(ratio));
}

/* An event that one of the two runs alone has counts as 1, and so does a run that is asked for another time than that
   of its event by a whole interval. */
static void missed(void **state)
{
  SequenceEpisode *e = created(0);
  EpisodeResult r;

  for (PetscInt k = 1; e->kind == SEGMENT_WITHIN; k++) {
    ok(RunEpisodeDestroy((RunEpisode **)&e));
    e = created(k);
  }
  e->base.reference.begin[0] += e->base.span / 8; /* within the segment, whose margin is more than that */
  run(e, SEQUENCE_REFERENCE_RTOL, &r);
  AssertNear(r.errors[SEGMENT_ERROR_ONSET], 0.125, 1e-9);
  e->base.reference.begin[0] -= e->base.span / 8;
  e->base.reference.events = 2;
  run(e, SEQUENCE_REFERENCE_RTOL, &r);
  assert_true(r.error == 1);
  ok(RunEpisodeDestroy((RunEpisode **)&e));
}

/* A segment is the same again, and those of other seeds start elsewhere. */
static void drawn(void **state)
{
  PetscReal first[3];

  for (PetscInt k = 0; k < 3; k++) {
    SequenceEpisode *e = created(k < 2 ? 2 : 3);

    first[k] = e->base.begin;
    ok(RunEpisodeDestroy((RunEpisode **)&e));
  }
  assert_true(first[0] == first[1] && first[1] != first[2]);
}

/* Of a user's file: a fault with the file's numbers, loaded, and a segment through one of its events; the same seed
   draws it again. */
static void of_family(void **state)
{
  const char *lines =
    "-fault_initial traction\n-fault_inertia no\n-fault_viscosity radiation\n-fault_nx 4:6\n-fault_nz 3\n"
    "-fault_length_x 4e3:6e3\n-fault_length_z 3e3\n-fault_normal_stress 50e6\n"
    "-fault_normal_stress_gradient 0\n-fault_friction_drop 0.1:0.2\n-fault_friction_slip 0.1\n"
    "-fault_loading_rate 1e-9\n-fault_healing_time 1e8\n-stress_share 0.3:0.8\n";
  FILE *f = fopen("sequences.opts", "w");
  PetscReal length, slip, end = 0;
  Family family;

  assert_non_null(f);
  assert_true(fputs(lines, f) >= 0);
  assert_int_equal(fclose(f), 0);
  ok(FamilyRead(PETSC_COMM_SELF, "sequences.opts", &family));
  assert_string_equal(family.problem, "sequence");
  for (int k = 0; k < 2; k++) {
    RunEpisode *e;

    ok(RunEpisodeCreate(&RunSequence, &family, 1, 5, &e));
    ok(SlipFaultGetReal(e->fault, "length_x", &length));
    ok(SlipFaultGetReal(e->fault, "friction_slip", &slip));
    assert_true(length >= 4e3 && length <= 6e3 && slip == 0.1);
    assert_true(e->n >= 12 && e->n <= 18 && e->reference.good && e->end > e->begin);
    assert_true(k == 0 || e->end == end);
    end = e->end;
    ok(RunEpisodeDestroy(&e));
  }
}

SLIP_TESTS(measured, missed, drawn, of_family)
