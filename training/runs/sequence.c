/* Segments of sequences: where they start, how far a run through one is from the reference. Tolerances of
   loaded faults are measured on them. */
#include "sequence.h"
#include "common/files.h"
#include <slipcompat.h>

#define SURVEY_RTOL 1e-4 /* of dsp: the run whose states segments start from */
#define SURVEY_STEPS 8000
#define LOOSER 4   /* a segment whose references at two tolerances, by so much apart, */
#define AGREE 3e-4 /* are farther apart than this is not kept */
#define REFERENCE_STEPS 20000
#define USUAL_RTOL 1e-3 /* of dsp */
#define LONGEST 0.1     /* first step, of a segment */
#define MARGIN 0.15     /* of the interval, after an event: where a segment ends */
#define QUIET 0.3       /* and for so long no other event may begin */
#define CLEAR 2         /* an event's fastest cell exceeds the rate of events by this */
#define WITHIN 0.2      /* share of the segments that start within an event, */
#define LATEST 0.8      /* of its steps, */
#define AFTER 0.3       /* and just after the one before */
#define NEAREST 1e-3    /* others start by so much of the gap before an event, or earlier */
#define EVENT_RATE 1e-3 /* an event lasts while a cell is faster [m/s], */
#define OVER 10         /* and another one begins only after all were slower than this part of it */
#define RISE 0.1        /* of the slip: the duration is between this share and the rest of it */
#define PEAK_SHARE (PetscReal)0.2
#define MOST_SEARCHES 4 /* segments drawn from one fault before another one is */
#define MOST_PASS 4     /* events before the segments */

#define RESIDUAL 0.5 /* friction after all weakening */
#define FULL 0.97    /* the stress at the start is at most this share of the strength */
#define LEAST 0.1    /* of a field, over its mean */

static const PetscInt Meshes[][2] = {{1, 1}, {4, 3}, {6, 3}, {8, 4}, {10, 5}, {12, 6}, {16, 8}};
static const double Chances[] = {0.15, 0.2, 0.2, 0.15, 0.1, 0.1, 0.1}; /* of these */

/* Of faults that are loaded, weaken with slip and heal */
static PetscErrorCode Draw(RunEpisode *e, Random *random)
{
  double chance = RandomUniform(random), side, normal, share, rate, heals, thickness, stressing;
  PetscBool linear, by_stress, half_space, inertia;
  PetscInt k = 0, nx, nz, n;
  PetscReal *drop, *stress;
  RunWeakening w;

  PetscFunctionBegin;
  while (k + 1 < (PetscInt)PETSC_STATIC_ARRAY_LENGTH(Meshes) && chance >= Chances[k]) chance -= Chances[k++];
  nx = Meshes[k][0];
  nz = Meshes[k][1];
  n = nx * nz;
  side = RandomLog(random, 300, 3000);     /* [m] */
  normal = RandomLog(random, 15e6, 100e6); /* [Pa] */
  w.drop = RandomLog(random, 0.05, 0.2);
  w.weakening = RandomLog(random, 0.5, 4);
  if (nx == 1) w.weakening = RandomLog(random, 1.3, 4); /* it is stable otherwise */
  w.scatter = RandomUniform(random) < 0.2 ? 0 : 0.3 * RandomUniform(random);
  w.length = RandomLog(random, 1, 6);
  share = 0.3 + 0.6 * RandomUniform(random); /* of the drop, at the start */
  rate = RandomLog(random, 1e-10, 1e-8);     /* of loading [m/s] */
  /* time, over that in which loading makes up for the drop; 0: never */
  heals = RandomUniform(random) < 0.1 ? 0 : RandomLog(random, 0.003, 0.3);
  thickness = RandomLog(random, 0.3, 1) * side * (double)PetscMax(nx, nz);
  linear = RandomUniform(random) < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  by_stress = RandomUniform(random) < 0.2 ? PETSC_TRUE : PETSC_FALSE;
  half_space = RandomUniform(random) < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  inertia = RandomUniform(random) < 0.25 ? PETSC_TRUE : PETSC_FALSE;
  ((SequenceEpisode *)e)->pass = heals > 0 ? 1 + (PetscInt)RandomIndex(random, MOST_PASS) : 0;
  /* the rate at which loading stresses a cell by itself [Pa/s] */
  stressing = RUN_CELL_STIFFNESS * RUN_SHEAR / (side * (double)PetscMin(nx, nz)) * rate;
  const RunOption rows[] = {{"thickness", thickness, NULL},
                            {"friction_residual", RESIDUAL, NULL},
                            {"loading_rate", by_stress ? 0 : rate, NULL},
                            {"stressing_rate", by_stress ? stressing : 0, NULL},
                            {"healing_time", heals * (w.drop * normal / stressing), NULL},
                            {"initial", 0, "traction"},
                            {"viscosity", 0, "radiation"},
                            {"kernel", 0, half_space ? "half_space" : "full_space"},
                            {"friction_law", 0, linear ? "linear_slip_weakening" : "exponential_slip_weakening"},
                            {"inertia", 0, inertia ? "yes" : "no"}};

  PetscCall(RunNewFault(e, nx, nz, side, normal));
  PetscCall(RunSetOptions(e->fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscCall(PetscMalloc2(n, &drop, n, &stress));
  PetscCall(RunDrawWeakening(random, &w, nx, nz, side, normal, e->fault, drop, stress));
  for (PetscInt i = 0; i < n; i++) {
    stress[i] = (PetscReal)(share * PetscMax(1 + w.scatter * (double)stress[i], LEAST));
    stress[i] = (PetscReal)normal * (RESIDUAL + stress[i] * drop[i]);
    stress[i] = PetscMin(stress[i], (PetscReal)(FULL * normal) * (RESIDUAL + drop[i]));
  }
  PetscCall(SlipFaultSetField(e->fault, "initial_traction", n, stress));
  PetscCall(PetscFree2(drop, stress));
  PetscCall(SlipFaultSetUp(e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step to time t, where the fastest cell has the rate: when an event began in it, or the last cell became slow;
   negative: not so */
static void EventsStep(RunWatch *watch, PetscReal t, PetscReal rate, PetscReal *began, PetscReal *slow)
{
  const PetscReal bound = (PetscReal)EVENT_RATE, h = t - watch->last;

  *began = *slow = -1;
  if (rate > bound && watch->rate <= bound) {
    if (watch->armed) *began = watch->last + h * SlipEventCrossing(watch->rate, rate, bound);
    watch->within = PETSC_TRUE;
    watch->armed = PETSC_FALSE;
  }
  if (rate <= bound && watch->rate > bound) *slow = t - h * SlipEventCrossing(rate, watch->rate, bound);
  if (rate < bound / OVER) {
    watch->armed = PETSC_TRUE;
    watch->within = PETSC_FALSE;
  }
}

/* ---- the run whose states segments start from ---- */

typedef struct {
  RunEpisode base;
  PetscInt wanted;              /* events that pass before */
  PetscInt passed;              /* events that began */
  PetscReal opening;            /* when the first event began */
  PetscReal onset, over, quiet; /* of the event of the segments, and the end of the one before it [s] */
  PetscReal interval;           /* [s] */
  PetscReal fastest;            /* in the event */
  Table state;                  /* [][1 + 3 n] time and state of the steps from the end of the event before on */
  PetscBool good;
} Survey;

static PetscErrorCode Look(RunWatch *watch, TS ts, PetscInt step, PetscReal t, PetscReal rate, const PetscReal a[])
{
  Survey *s = (Survey *)watch->e;
  PetscReal began, slow;

  PetscFunctionBegin;
  if (step == 0) watch->armed = PETSC_TRUE;
  EventsStep(watch, t, rate, &began, &slow);
  if (began >= 0) {
    if (s->passed == 0) s->opening = began;
    if (s->passed == s->wanted + 1 || (s->passed == s->wanted && s->state.n < 2)) { /* too soon: the next one may do */
      PetscCall(TableClear(&s->state));
      s->wanted = s->passed + 1;
      s->over = -1;
      s->fastest = 0;
    }
    if (s->passed == s->wanted) {
      s->onset = began;
      s->interval = s->passed ? (began - s->opening) / (PetscReal)s->passed : began;
    }
    s->passed++;
  }
  if (slow >= 0) s->over = slow;
  if (s->passed == s->wanted && !watch->within && !s->state.n) s->quiet = t;
  if ((s->passed == s->wanted && !watch->within) || s->passed == s->wanted + 1) {
    PetscReal *row;

    PetscCall(PetscMalloc1(s->state.width, &row));
    row[0] = t;
    PetscCall(PetscArraycpy(row + 1, a, s->state.width - 1));
    PetscCall(TableAdd(&s->state, row));
    PetscCall(PetscFree(row));
  }
  if (s->passed == s->wanted + 1) {
    s->fastest = PetscMax(s->fastest, rate);
    if (!watch->within && t > s->over + QUIET * s->interval) {
      s->good = PETSC_TRUE;
      PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const RunKind RunSurvey = {.size = sizeof(Survey), .follow = Look};

static const PetscReal *Row(const Survey *s, PetscInt k)
{
  return s->state.data + s->state.width * k;
}

/* The last kept step that is not after the time; the first one at the earliest */
static PetscInt StepAt(const Survey *s, PetscReal t)
{
  PetscInt k = 0;

  while (k + 2 < s->state.n && Row(s, k + 1)[0] <= t) k++;
  return k;
}

/* ---- a run through a segment ---- */

static PetscErrorCode Follow(RunWatch *watch, TS ts, PetscInt step, PetscReal t, PetscReal rate, const PetscReal a[])
{
  const RunEpisode *e = watch->e;
  RunResult *r = watch->r;
  PetscReal began, slow;

  PetscFunctionBegin;
  (void)ts, (void)a;
  if (step == 0) {
    watch->within = ((const SequenceEpisode *)e)->kind == SEGMENT_WITHIN ? PETSC_TRUE : PETSC_FALSE;
    watch->armed = watch->within ? PETSC_FALSE : PETSC_TRUE;
    r->begin[0] = watch->within ? e->begin : e->end;
    r->over[0] = e->end;
  }
  EventsStep(watch, t, rate, &began, &slow);
  if (began >= 0 && r->events++ == 0) r->begin[0] = began;
  if (slow >= 0) r->over[0] = slow;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of a course at a time between its first and last node: a cubic of slips and rates */
static SlipCourseNode NodeAt(PetscInt n, const SlipCourseNode node[], PetscReal t)
{
  PetscInt k = 0;
  PetscReal h, x, slope[2], turn[2];

  while (k + 2 < n && node[k + 1].time <= t) k++;
  h = node[k + 1].time - node[k].time;
  x = PetscClipInterval((t - node[k].time) / h, (PetscReal)0, (PetscReal)1);
  slope[0] = h * node[k].rate;
  slope[1] = h * node[k + 1].rate;
  turn[0] = 3 * (node[k + 1].slip - node[k].slip) - 2 * slope[0] - slope[1];
  turn[1] = 2 * (node[k].slip - node[k + 1].slip) + slope[0] + slope[1];
  return (SlipCourseNode){t, node[k].slip + x * (slope[0] + x * (turn[0] + x * turn[1])),
                          (slope[0] + x * (2 * turn[0] + x * 3 * turn[1])) / h};
}

/* The time in which the mean slip of the event goes from a tenth to nine tenths of its way [s] */
static PetscErrorCode Rise(const RunResult *r, PetscReal *rise)
{
  const SlipCourseNode *all = CourseNodes(&r->course);
  SlipCourseNode *node;
  PetscInt n = 1;

  PetscFunctionBegin;
  *rise = 0;
  if (r->course.n < 2 || r->over[0] <= r->begin[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(r->course.n + 2, &node));
  node[0] = NodeAt(r->course.n, all, r->begin[0]);
  for (PetscInt k = 0; k < r->course.n; k++)
    if (all[k].time > r->begin[0] && all[k].time < r->over[0]) node[n++] = all[k];
  node[n++] = NodeAt(r->course.n, all, r->over[0]);
  for (PetscInt k = n - 1; k >= 0; k--) node[k].slip -= node[0].slip;
  *rise = SlipCourseTime(n, node, (PetscReal)(1 - RISE)) - SlipCourseTime(n, node, (PetscReal)RISE);
  PetscCall(PetscFree(node));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Compare(const RunEpisode *base, const RunResult *r, PetscReal error[], PetscReal *most)
{
  const SequenceEpisode *e = (const SequenceEpisode *)base;
  const RunResult *ref = &base->reference;
  PetscReal sum = 0, mean = 0, rise, of_reference;

  PetscFunctionBegin;
  *most = 1;
  if (r->events != ref->events) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Rise(r, &rise));
  PetscCall(Rise(ref, &of_reference));
  error[SEGMENT_ERROR_ONSET] = e->kind == SEGMENT_WITHIN ? 0 : PetscAbsReal(r->begin[0] - ref->begin[0]) / base->span;
  for (PetscInt i = 0; i < base->n; i++) {
    const PetscReal d = r->slip[i] - ref->slip[i];

    sum += PetscSqr(d) / (PetscReal)base->n;
    mean += d / (PetscReal)base->n;
  }
  error[SEGMENT_ERROR_SLIP] = PetscSqrtReal(sum) / e->size;
  error[SEGMENT_ERROR_MOMENT] = PetscAbsReal(mean) / e->mean;
  error[SEGMENT_ERROR_DURATION] = PetscAbsReal(rise / of_reference - 1);
  error[SEGMENT_ERROR_PEAK] = PEAK_SHARE * PetscAbsReal(SlipCoursePeak(r->course.n, CourseNodes(&r->course)) /
                                                          SlipCoursePeak(ref->course.n, CourseNodes(&ref->course)) -
                                                        1);
  *most = 0;
  for (PetscInt i = 0; i < SEGMENT_NUM_ERRORS; i++) *most = PetscMax(*most, error[i]);
  *most = PetscMin(*most, 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an episode ---- */

/* Where it starts, by the steps of the survey */
static PetscErrorCode ChooseStart(const Survey *s, SequenceEpisode *segment)
{
  RunEpisode *e = &segment->base;
  Random *random = &segment->random;
  const double share = RandomUniform(random);
  const PetscReal remains = (PetscReal)RandomLog(random, NEAREST, 1);
  const PetscInt onset = StepAt(s, s->onset), over = StepAt(s, s->over);
  PetscReal sum = 0, mean = 0;
  PetscInt k = 0;
  PetscReal *a;

  PetscFunctionBegin;
  if (segment->kind == SEGMENT_BETWEEN) k = StepAt(s, s->onset - remains * (s->onset - s->quiet));
  if (segment->kind == SEGMENT_WITHIN) k = onset + 1 + (PetscInt)(LATEST * share * (double)(over - onset - 1));
  PetscCall(SlipFaultCreateState(e->fault, &e->start));
  PetscCall(VecGetArrayWrite(e->start, &a));
  PetscCall(PetscArraycpy(a, Row(s, k) + 1, 3 * e->n));
  PetscCall(VecRestoreArrayWrite(e->start, &a));
  e->begin = Row(s, k)[0];
  e->step = (Row(s, k + 1)[0] - e->begin) * (PetscReal)RandomLog(random, 1, 4);
  e->span = s->interval;
  e->end = s->over + (PetscReal)MARGIN * s->interval;
  e->step = PetscMin(e->step, (PetscReal)LONGEST * (e->end - e->begin));
  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal d = Row(s, over + 1)[1 + 3 * i + 1] - Row(s, onset)[1 + 3 * i + 1];

    sum += PetscSqr(d) / (PetscReal)e->n;
    mean += d / (PetscReal)e->n;
  }
  segment->size = PetscSqrtReal(sum);
  segment->mean = PetscAbsReal(mean);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two references that agree, and the usual solves and work */
static PetscErrorCode JudgeSegment(SequenceEpisode *segment, PetscBool *good)
{
  RunEpisode *e = &segment->base;
  const PetscInt events = segment->kind == SEGMENT_WITHIN ? 0 : 1;
  RunRequest request = {NULL, TSADAPTPI, (PetscReal)(LOOSER * SEQUENCE_REFERENCE_RTOL), .end = e->end,
                        .most = REFERENCE_STEPS};
  PetscReal errors[SLIP_NUM_ERRORS], error;
  RunResult r;

  PetscFunctionBegin;
  *good = PETSC_FALSE;
  PetscCall(RunIntegrate(e, &request, &r));
  if (r.good && r.events == events && r.over[0] < e->end) {
    request.setting = (PetscReal)SEQUENCE_REFERENCE_RTOL;
    PetscCall(RunIntegrate(e, &request, &e->reference));
    PetscCall(Compare(e, &r, errors, &error));
    *good = e->reference.good && e->reference.events == events && error < AGREE ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(RunResultDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  request.type = TSADAPTDSP;
  request.setting = (PetscReal)USUAL_RTOL;
  PetscCall(RunIntegrate(e, &request, &r));
  e->usual = r.solves;
  e->work = r.work;
  PetscCall(RunResultDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Some segments of one fault are tried. */
static PetscErrorCode Judge(RunEpisode *e, PetscBool *good)
{
  const RunRequest survey = {NULL, TSADAPTDSP, (PetscReal)SURVEY_RTOL, .end = PETSC_MAX_REAL / 2, .most = SURVEY_STEPS};
  SequenceEpisode *segment = (SequenceEpisode *)e;
  RunResult r;
  Survey s;

  PetscFunctionBegin;
  if (!segment->begun) {
    RandomSeed(&segment->random, e->seed + 1);
    segment->of_kind = RandomUniform(&segment->random);
    segment->begun = PETSC_TRUE;
  }
  segment->kind = segment->of_kind < WITHIN           ? SEGMENT_WITHIN
                  : segment->of_kind < WITHIN + AFTER ? SEGMENT_AFTER
                                                      : SEGMENT_BETWEEN;
  if (e->family) {
    PetscReal healing;

    PetscCall(SlipFaultGetReal(e->fault, "healing_time", &healing));
    segment->pass = healing > 0 ? 1 + (PetscInt)RandomIndex(&segment->random, MOST_PASS) : 0;
  }
  *good = PETSC_FALSE;
  s = (Survey){.base = {.kind = &RunSurvey, .fault = e->fault, .n = e->n},
               .wanted = segment->pass,
               .over = -1,
               .state = {.width = 1 + 3 * e->n}};
  PetscCall(RunIntegrate(&s.base, &survey, &r));
  if (!r.good || s.fastest < CLEAR * EVENT_RATE) s.good = PETSC_FALSE;
  PetscCall(RunResultDestroy(&r));
  for (PetscInt i = 0; i < MOST_SEARCHES && s.good && !*good; i++) {
    PetscCall(ChooseStart(&s, segment));
    PetscCall(JudgeSegment(segment, good));
    if (!*good) {
      PetscCall(RunResultDestroy(&e->reference));
      PetscCall(VecDestroy(&e->start));
    }
  }
  PetscCall(TableClear(&s.state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const RunKind RunSequence = {.size = sizeof(SequenceEpisode),
                             .column = 1,
                             .slips = 1,
                             .draw = Draw,
                             .judge = Judge,
                             .follow = Follow,
                             .compare = Compare,
                             .expected = "has an event to learn from: expected one that is loaded until its cells slip "
                                         "faster than 2 mm/s, and then rests",
                             .worst = 4};

/* ---- the problem: no policy of it is trained ---- */

static const CMAProblem CMASequences = {RUNS, .stream = 11, .runs = &RunSequence, .create = RunsCreate,
                                        .classical = RunsClassical};

const Problem ProblemSequence = {
  .name = "sequence", .meaning = "segments of sequences of events of small faults", .cma = &CMASequences};
