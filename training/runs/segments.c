/* Segments of sequences: where they start, and how far a run through one is from the reference. */
#include "sequences.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>

#define SURVEY_RTOL 1e-4 /* of dsp: the run whose states segments start from */
#define SURVEY_STEPS 8000
#define LOOSER 4   /* a segment whose references at two tolerances, by so much apart, */
#define AGREE 3e-4 /* are farther apart than this is not kept */
#define REFERENCE_STEPS 20000
#define USUAL_RTOL 1e-3  /* of dsp */
#define LONGEST 0.1      /* first step, of a segment */
#define MARGIN 0.15      /* of the interval, after an event: where a segment ends */
#define QUIET 0.3        /* and for so long no other event may begin */
#define CLEAR 2          /* an event's fastest cell exceeds the rate of events by this */
#define WITHIN 0.2       /* share of the segments that start within an event, */
#define LATEST 0.8       /* of its steps, */
#define AFTER 0.3        /* and just after the one before */
#define NEAREST 1e-3     /* others start by so much of the gap before an event, or earlier */
#define MOST_OF_USUAL 20 /* steps of a run that is worth ending */
#define RISE 0.1         /* of the slip: the duration is between this share and the rest of it */
#define PEAK_SHARE (PetscReal)0.2
#define MOST_SEARCHES 4 /* segments drawn from one fault before another one is */

/* ---- events of a run ---- */

typedef struct {
  PetscBool on, armed;  /* an event lasts; all were slow since the last */
  PetscReal time, rate; /* of the last step: [s], fastest cell [m/s] */
} Events;

/* A step to time t, where the fastest cell has the rate: when an event began in it, or the last cell became slow; negative: not so */
static void EventsStep(Events *e, PetscReal t, PetscReal rate, PetscReal *began, PetscReal *slow)
{
  const PetscReal bound = (PetscReal)SEQUENCE_EVENT_RATE, h = t - e->time;

  *began = *slow = -1;
  if (rate > bound && e->rate <= bound) {
    if (e->armed) *began = e->time + h * SlipEventCrossing(e->rate, rate, bound);
    e->on = PETSC_TRUE;
    e->armed = PETSC_FALSE;
  }
  if (rate <= bound && e->rate > bound) *slow = t - h * SlipEventCrossing(rate, e->rate, bound);
  if (rate < bound / SEQUENCE_OVER) {
    e->armed = PETSC_TRUE;
    e->on = PETSC_FALSE;
  }
  e->time = t;
  e->rate = rate;
}

static PetscErrorCode Fastest(Vec w, PetscReal *rate)
{
  const PetscReal *a;
  PetscInt n;

  PetscFunctionBegin;
  *rate = 0;
  PetscCall(VecGetLocalSize(w, &n));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i += 3) *rate = PetscMax(*rate, PetscAbsReal(a[i]));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run whose states segments start from ---- */

typedef struct {
  PetscInt n, wanted; /* cells; events that pass before */
  Events events;
  PetscInt passed;              /* events that began */
  PetscReal opening;            /* when the first event began */
  PetscReal onset, over, quiet; /* of the event of the segments, and the end of the one before it [s] */
  PetscReal interval;           /* [s] */
  PetscReal fastest;            /* in the event */
  Table state;                  /* [][1 + 3 n] time and state of the steps from the end of the event before on */
  PetscBool good;
} Survey;

static PetscErrorCode AppendState(Survey *s, PetscReal t, Vec w)
{
  const PetscReal *a;
  PetscReal *row;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(s->state.width, &row));
  PetscCall(VecGetArrayRead(w, &a));
  row[0] = t;
  PetscCall(PetscArraycpy(row + 1, a, 3 * s->n));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(TableAdd(&s->state, row));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The event that begins now follows another one too soon: the next one may do. */
static PetscErrorCode TryNext(Survey *s)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&s->state));
  s->wanted = s->passed + 1;
  s->over = -1;
  s->fastest = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Look(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Survey *s = (Survey *)ctx;
  PetscReal rate, began, slow;

  PetscFunctionBegin;
  PetscCall(Fastest(w, &rate));
  if (step == 0) s->events = (Events){PETSC_FALSE, PETSC_TRUE, t, rate};
  EventsStep(&s->events, t, rate, &began, &slow);
  if (began >= 0) {
    if (s->passed == 0) s->opening = began;
    if (s->passed == s->wanted + 1 || (s->passed == s->wanted && s->state.n < 2)) PetscCall(TryNext(s));
    if (s->passed == s->wanted) {
      s->onset = began;
      s->interval = s->passed ? (began - s->opening) / (PetscReal)s->passed : began;
    }
    s->passed++;
  }
  if (slow >= 0) s->over = slow;
  if (s->passed == s->wanted && !s->events.on && !s->state.n) s->quiet = t;
  if ((s->passed == s->wanted && !s->events.on) || s->passed == s->wanted + 1) PetscCall(AppendState(s, t, w));
  if (s->passed == s->wanted + 1) {
    s->fastest = PetscMax(s->fastest, rate);
    if (!s->events.on && t > s->over + QUIET * s->interval) {
      s->good = PETSC_TRUE;
      PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurveyFault(SlipFault fault, PetscInt n, PetscInt events, Survey *s)
{
  FaultRun run = {.type = TSADAPTDSP,
                  .setting = (PetscReal)SURVEY_RTOL,
                  .end = PETSC_MAX_REAL / 2,
                  .most = SURVEY_STEPS,
                  .follow = Look,
                  .ctx = s};
  PetscInt solves, rejected;
  PetscBool ended;

  PetscFunctionBegin;
  *s = (Survey){.n = n, .wanted = events, .over = -1, .state = {.width = 1 + 3 * n}};
  PetscCall(RunFault(fault, &run, &solves, &rejected, &ended));
  if (!ended || s->fastest < CLEAR * SEQUENCE_EVENT_RATE) s->good = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

typedef struct {
  const SegmentEpisode *e;
  SegmentRun *r;
  Events events;
} Watch;

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Watch *watch = (Watch *)ctx;
  SegmentRun *r = watch->r;
  PetscReal row[3] = {t, 0, 0}, rate, began, slow;
  const PetscReal *a;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(Fastest(w, &rate));
  if (step == 0)
    watch->events = (Events){watch->e->kind == SEGMENT_WITHIN ? PETSC_TRUE : PETSC_FALSE,
                             watch->e->kind == SEGMENT_WITHIN ? PETSC_FALSE : PETSC_TRUE, t, rate};
  EventsStep(&watch->events, t, rate, &began, &slow);
  if (began >= 0 && r->events++ == 0) r->begin = began;
  if (slow >= 0) r->over = slow;
  r->fastest = PetscMax(r->fastest, rate);
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < r->n; i++) {
    r->slip[i] = a[3 * i + 1];
    row[1] += a[3 * i + 1] / (PetscReal)r->n;
    row[2] += PetscAbsReal(a[3 * i]) / (PetscReal)r->n;
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(TableAdd(&r->course, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunDestroy(SegmentRun *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->course));
  PetscCall(PetscFree(r->slip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Integrate(const SegmentEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                                PetscInt most, SegmentRun *r)
{
  Watch watch = {.e = e, .r = r};
  FaultRun run = {policy,          type,          setting,      .start = e->start, .begin = e->first,
                  .step = e->step, .end = e->end, .most = most, .follow = Follow,  .ctx = &watch};

  PetscFunctionBegin;
  *r = (SegmentRun){
    .course = {.width = 3}, .n = e->n, .begin = e->kind == SEGMENT_WITHIN ? e->first : e->end, .over = e->end};
  PetscCall(PetscCalloc1(e->n, &r->slip));
  PetscCall(RunFault(e->fault, &run, &r->solves, &r->rejected, &r->good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal FieldError(const SegmentEpisode *e, const SegmentRun *r, PetscReal *mean)
{
  PetscReal sum = 0;

  *mean = 0;
  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal d = r->slip[i] - e->reference.slip[i];

    sum += PetscSqr(d) / (PetscReal)e->n;
    *mean += d / (PetscReal)e->n;
  }
  return PetscSqrtReal(sum);
}

static PetscReal PeakOf(const SegmentRun *r)
{
  return SlipCoursePeak(r->course.n, (const SlipCourseNode *)r->course.data);
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
static PetscErrorCode Rise(const SegmentRun *r, PetscReal *rise)
{
  const SlipCourseNode *all = (const SlipCourseNode *)r->course.data;
  SlipCourseNode *node;
  PetscInt n = 1;

  PetscFunctionBegin;
  *rise = 0;
  if (r->course.n < 2 || r->over <= r->begin) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(r->course.n + 2, &node));
  node[0] = NodeAt(r->course.n, all, r->begin);
  for (PetscInt k = 0; k < r->course.n; k++)
    if (all[k].time > r->begin && all[k].time < r->over) node[n++] = all[k];
  node[n++] = NodeAt(r->course.n, all, r->over);
  for (PetscInt k = n - 1; k >= 0; k--) node[k].slip -= node[0].slip;
  *rise = SlipCourseTime(n, node, (PetscReal)(1 - RISE)) - SlipCourseTime(n, node, (PetscReal)RISE);
  PetscCall(PetscFree(node));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Compare(const SegmentEpisode *e, const SegmentRun *r, PetscReal error[], PetscReal *most)
{
  const SegmentRun *ref = &e->reference;
  const PetscBool within = e->kind == SEGMENT_WITHIN ? PETSC_TRUE : PETSC_FALSE;
  PetscReal mean, rise, of_reference;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < SEGMENT_NUM_ERRORS; i++) error[i] = 1;
  *most = 1;
  if (r->events != ref->events) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Rise(r, &rise));
  PetscCall(Rise(ref, &of_reference));
  error[SEGMENT_ERROR_ONSET] = within ? 0 : PetscAbsReal(r->begin - ref->begin) / e->interval;
  error[SEGMENT_ERROR_SLIP] = FieldError(e, r, &mean) / e->size;
  error[SEGMENT_ERROR_MOMENT] = PetscAbsReal(mean) / e->mean;
  error[SEGMENT_ERROR_DURATION] = PetscAbsReal(rise / of_reference - 1);
  error[SEGMENT_ERROR_PEAK] = PEAK_SHARE * PetscAbsReal(PeakOf(r) / PeakOf(ref) - 1);
  *most = 0;
  for (PetscInt i = 0; i < SEGMENT_NUM_ERRORS; i++) *most = PetscMax(*most, error[i]);
  *most = PetscMin(*most, 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SegmentEpisodeRun(SegmentEpisode *e, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                 PetscReal rtol, PetscInt *solves, PetscInt *rejected, PetscReal errors[],
                                 PetscReal *error)
{
  SegmentRun r;

  PetscFunctionBegin;
  PetscCall(Integrate(e, policy, type, policy ? accuracy : rtol, MOST_OF_USUAL * e->usual, &r));
  *solves = r.solves;
  *rejected = r.rejected;
  PetscCall(Compare(e, &r, errors, error));
  if (!r.good) *error = -1;
  PetscCall(RunDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an episode ---- */

/* Where it starts, by the steps of the survey */
static PetscErrorCode ChooseStart(Random *random, const Survey *s, SegmentEpisode *e)
{
  const double share = RandomUniform(random);
  const PetscReal remains = (PetscReal)RandomLog(random, NEAREST, 1);
  const PetscInt onset = StepAt(s, s->onset), over = StepAt(s, s->over);
  PetscReal sum = 0, mean = 0;
  PetscInt k = 0;
  PetscReal *a;

  PetscFunctionBegin;
  if (e->kind == SEGMENT_BETWEEN) k = StepAt(s, s->onset - remains * (s->onset - s->quiet));
  if (e->kind == SEGMENT_WITHIN) k = onset + 1 + (PetscInt)(LATEST * share * (double)(over - onset - 1));
  PetscCall(SlipFaultCreateState(e->fault, &e->start));
  PetscCall(VecGetArrayWrite(e->start, &a));
  PetscCall(PetscArraycpy(a, Row(s, k) + 1, 3 * s->n));
  PetscCall(VecRestoreArrayWrite(e->start, &a));
  e->first = Row(s, k)[0];
  e->step = (Row(s, k + 1)[0] - e->first) * (PetscReal)RandomLog(random, 1, 4);
  e->interval = s->interval;
  e->end = s->over + (PetscReal)MARGIN * s->interval;
  e->step = PetscMin(e->step, (PetscReal)LONGEST * (e->end - e->first));
  e->duration = s->over - s->onset;
  for (PetscInt i = 0; i < s->n; i++) {
    const PetscReal d = Row(s, over + 1)[1 + 3 * i + 1] - Row(s, onset)[1 + 3 * i + 1];

    sum += PetscSqr(d) / (PetscReal)s->n;
    mean += d / (PetscReal)s->n;
  }
  e->size = PetscSqrtReal(sum);
  e->mean = PetscAbsReal(mean);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Two references that agree, and the usual number of solves */
static PetscErrorCode Judge(SegmentEpisode *e, PetscBool *good)
{
  const PetscInt events = e->kind == SEGMENT_WITHIN ? 0 : 1;
  PetscReal errors[SEGMENT_NUM_ERRORS], error;
  SegmentRun r;

  PetscFunctionBegin;
  *good = PETSC_FALSE;
  PetscCall(Integrate(e, NULL, TSADAPTPI, (PetscReal)(LOOSER * SEGMENT_REFERENCE_RTOL), REFERENCE_STEPS, &r));
  if (r.good && r.events == events && r.over < e->end) {
    PetscCall(Integrate(e, NULL, TSADAPTPI, (PetscReal)SEGMENT_REFERENCE_RTOL, REFERENCE_STEPS, &e->reference));
    PetscCall(Compare(e, &r, errors, &error));
    *good = e->reference.good && e->reference.events == events && error < AGREE ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(RunDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Integrate(e, NULL, TSADAPTDSP, (PetscReal)USUAL_RTOL, REFERENCE_STEPS, &r));
  e->usual = r.solves;
  PetscCall(RunDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ForgetSegment(SegmentEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(RunDestroy(&e->reference));
  PetscCall(VecDestroy(&e->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SegmentEpisodeDestroy(SegmentEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(ForgetSegment(e));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SegmentEpisodeCreate(uint64_t seed, PetscInt k, SegmentEpisode *e)
{
  PetscBool good = PETSC_FALSE;
  Random random, of_segment;
  double of_kind;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  RandomSeed(&of_segment, seed + 1 + (uint64_t)k);
  of_kind = RandomUniform(&of_segment);
  while (!good) {
    PetscInt events;
    Survey s;

    *e = (SegmentEpisode){.kind = of_kind < WITHIN           ? SEGMENT_WITHIN
                                  : of_kind < WITHIN + AFTER ? SEGMENT_AFTER
                                                             : SEGMENT_BETWEEN};
    PetscCall(SequenceFaultDraw(&random, &e->fault, &e->n, &events));
    PetscCall(SurveyFault(e->fault, e->n, events, &s));
    for (PetscInt i = 0; i < MOST_SEARCHES && s.good && !good; i++) {
      PetscCall(ChooseStart(&of_segment, &s, e));
      PetscCall(Judge(e, &good));
      if (!good) PetscCall(ForgetSegment(e));
    }
    PetscCall(TableClear(&s.state));
    if (!good) PetscCall(SegmentEpisodeDestroy(e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
