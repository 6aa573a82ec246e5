/* The distance between two slip histories. A history is mean slip over time: the ends of accepted steps, a cubic
   between two of them (Hermite, from slips and rates), and constant first and last slip before and after. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <string.h>

#define HALF 0.5
#define RISE_FROM 0.1 /* the rise time is between these fractions of the final slip */
#define RISE_TO 0.9
#define PEAK_SHARE 0.2 /* weight of an error of the peak rate */
#define CHORDS 16      /* chords per cubic, for the Levy distance */

/* The interval after a node: the cubic y = a + x (b + x (c + x d)) by values and slopes at its ends, per its length */
typedef struct {
  PetscReal t, h;       /* start and length [s] */
  PetscReal a, b, c, d; /* x = (time - t)/h */
} Cubic;

static void Fit(PetscReal t, PetscReal h, PetscReal y0, PetscReal m0, PetscReal y1, PetscReal m1, Cubic *p)
{
  *p = (Cubic){t, h, y0, h * m0, 3 * (y1 - y0) - h * (2 * m0 + m1), 2 * (y0 - y1) + h * (m0 + m1)};
}

static PetscReal Value(const Cubic *p, PetscReal x)
{
  return p->a + x * (p->b + x * (p->c + x * p->d));
}

static PetscReal Slope(const Cubic *p, PetscReal x)
{
  return (p->b + x * (2 * p->c + x * 3 * p->d)) / p->h;
}

/* Computes where the slope vanishes in the interval, in order; returns the number of such points. */
static PetscInt Extrema(const Cubic *p, PetscReal x[2])
{
  const PetscReal a = 3 * p->d, b = p->c, c = p->b, D = b * b - a * c;
  PetscReal root[2], q;
  PetscInt n = 0;

  if (D < 0 || (a == 0 && b == 0)) return 0;
  q = -(b + (b < 0 ? -PetscSqrtReal(D) : PetscSqrtReal(D))); /* avoids a difference of equal numbers */
  root[0] = a != 0 ? q / a : -1;
  root[1] = q != 0 ? c / q : 0;
  if (root[0] > root[1]) {
    const PetscReal swap = root[0];

    root[0] = root[1];
    root[1] = swap;
  }
  for (PetscInt i = 0; i < 2; i++)
    if (root[i] > 0 && root[i] < 1) x[n++] = root[i];
  return n;
}

/* The part of a history after node k; k = -1 and n - 1 are the parts before and after all nodes */
static void Part(PetscInt n, const SlipCourseNode c[], PetscInt k, Cubic *p)
{
  if (k < 0 || k == n - 1)
    *p = (Cubic){c[k < 0 ? 0 : k].time, 1, c[k < 0 ? 0 : k].slip, 0, 0, 0};
  else
    Fit(c[k].time, c[k + 1].time - c[k].time, c[k].slip, c[k].rate, c[k + 1].slip, c[k + 1].rate, p);
}

/* The largest |difference| of two parts between two times that lie in both parts */
static PetscReal Apart(const Cubic *p, const Cubic *q, PetscReal t0, PetscReal t1)
{
  const PetscReal x0 = (t0 - p->t) / p->h, x1 = (t1 - p->t) / p->h, y0 = (t0 - q->t) / q->h, y1 = (t1 - q->t) / q->h;
  PetscReal x[2], most;
  Cubic d;
  PetscInt n;

  Fit(t0, t1 - t0, Value(p, x0) - Value(q, y0), Slope(p, x0) - Slope(q, y0), Value(p, x1) - Value(q, y1),
      Slope(p, x1) - Slope(q, y1), &d);
  n = Extrema(&d, x);
  most = PetscMax(PetscAbsReal(d.a), PetscAbsReal(Value(&d, 1)));
  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, PetscAbsReal(Value(&d, x[i])));
  return most;
}

/* The largest distance over all times of either history */
static PetscReal Distance(PetscInt n, const SlipCourseNode a[], PetscInt m, const SlipCourseNode b[])
{
  const PetscReal end = PetscMax(a[n - 1].time, b[m - 1].time);
  PetscReal t = PetscMin(a[0].time, b[0].time), most = 0;
  PetscInt i = -1, j = -1;

  while (t < end) {
    PetscReal next = end;
    Cubic p, q;

    while (i < n - 1 && a[i + 1].time <= t) i++;
    while (j < m - 1 && b[j + 1].time <= t) j++;
    if (i < n - 1) next = PetscMin(next, a[i + 1].time);
    if (j < m - 1) next = PetscMin(next, b[j + 1].time);
    Part(n, a, i, &p);
    Part(m, b, j, &q);
    most = PetscMax(most, Apart(&p, &q, t, next));
    t = next;
  }
  return most;
}

/* When a part first reaches a slip, which is larger than that at its start and reached by x in [0, 1], to rounding */
static PetscReal Meets(const Cubic *p, PetscReal slip, PetscReal x)
{
  PetscReal low = 0, high = x;

  for (PetscInt i = 0; i < 60; i++) {
    const PetscReal middle = HALF * (low + high);

    if (Value(p, middle) < slip)
      low = middle;
    else
      high = middle;
  }
  return p->t + high * p->h;
}

/*
  SlipCourseTime - computes when the slip first reaches a fraction of the final slip

  c: n >= 1 nodes in the order of their times. Returns the time [s]; that of the first node if there is no slip.
*/
PetscReal SlipCourseTime(PetscInt n, const SlipCourseNode c[], PetscReal share)
{
  const PetscReal slip = share * c[n - 1].slip;

  if (c[0].slip >= slip) return c[0].time;
  for (PetscInt k = 0; k + 1 < n; k++) {
    PetscReal x[3];
    PetscInt ends;
    Cubic p;

    Part(n, c, k, &p);
    ends = Extrema(&p, x);
    x[ends] = 1;
    for (PetscInt i = 0; i <= ends; i++)
      if (Value(&p, x[i]) >= slip) return Meets(&p, slip, x[i]);
  }
  return c[n - 1].time;
}

/*
  SlipCoursePeak - computes the largest rate of n >= 1 nodes and of the cubics between them [m/s]
*/
PetscReal SlipCoursePeak(PetscInt n, const SlipCourseNode c[])
{
  PetscReal peak = c[n - 1].rate;

  for (PetscInt k = 0; k + 1 < n; k++) {
    PetscReal x;
    Cubic p;

    Part(n, c, k, &p);
    x = p.d != 0 ? -p.c / (3 * p.d) : 0; /* where the curvature vanishes */
    peak = PetscMax(peak, c[k].rate);
    if (x > 0 && x < 1) peak = PetscMax(peak, Slope(&p, x));
  }
  return peak;
}

/*
  SlipCourseCompare - computes the errors of a run relative to a reference, except that of the final field

  run [n], reference [m]: nodes in the order of their times, n and m >= 1; the final slip of the reference is not 0.
  error [SLIP_NUM_ERRORS]: all relative, see SlipErrorKind; that of the field is set to 0.
*/
void SlipCourseCompare(PetscInt n, const SlipCourseNode run[], PetscInt m, const SlipCourseNode reference[],
                       PetscReal error[])
{
  const PetscReal slip = reference[m - 1].slip, peak = SlipCoursePeak(m, reference);
  const PetscReal rise = SlipCourseTime(m, reference, RISE_TO) - SlipCourseTime(m, reference, RISE_FROM);

  error[SLIP_ERROR_FINAL] = PetscAbsReal(run[n - 1].slip / slip - 1);
  error[SLIP_ERROR_HISTORY] = Distance(n, run, m, reference) / slip;
  error[SLIP_ERROR_SHIFT] = PetscAbsReal(SlipCourseTime(n, run, HALF) - SlipCourseTime(m, reference, HALF)) / rise;
  error[SLIP_ERROR_PEAK] = PetscAbsReal(SlipCoursePeak(n, run) / peak - 1);
  error[SLIP_ERROR_FIELD] = 0;
}

/* ---- the Levy distance ---- */

/* A walk along the graph of a history, chord by chord, in coordinates rotated by 45 degrees: a = time + slip, which
   grows along the graph, including jumps, and b = slip - time, each over its scale */
typedef struct {
  PetscInt n, at; /* nodes, chords passed */
  const SlipCourseNode *c;
  PetscReal duration, slip; /* scales */
  PetscReal highest;        /* largest slip so far [m] */
  PetscReal a[2], b[2];     /* ends of the chord; beyond the last one the graph is horizontal */
} Walk;

static void WalkOn(Walk *w)
{
  const PetscInt k = w->at / CHORDS, part = w->at % CHORDS;
  PetscReal time, slip;

  w->a[0] = w->a[1];
  w->b[0] = w->b[1];
  if (k >= w->n - 1 && w->at > 0) {
    w->a[1] = PETSC_MAX_REAL;
    return;
  }
  if (k < w->n - 1) {
    const SlipCourseNode *c = w->c + k;
    const PetscReal h = c[1].time - c[0].time, x = (PetscReal)(part + 1) / CHORDS,
                    most = 3 * (c[1].slip - c[0].slip) / h;
    Cubic p;

    /* Steeper ends, as rates before a corner of loads may be, would let it decrease (Fritsch & Carlson 1980). */
    Fit(c[0].time, h, c[0].slip, PetscMin(c[0].rate, most), c[1].slip, PetscMin(c[1].rate, most), &p);
    time = part + 1 == CHORDS ? c[1].time : p.t + x * h;
    slip = part + 1 == CHORDS ? c[1].slip : PetscMax(Value(&p, x), w->highest);
  } else {
    time = w->c[0].time;
    slip = w->c[0].slip;
  }
  w->highest = slip;
  w->a[1] = time / w->duration + slip / w->slip;
  w->b[1] = slip / w->slip - time / w->duration;
  w->at++;
}

static Walk WalkStart(PetscInt n, const SlipCourseNode c[], PetscReal duration, PetscReal slip)
{
  Walk w = {.n = n, .c = c, .duration = duration, .slip = slip, .highest = c[0].slip};

  w.a[0] = w.a[1] = c[0].time / duration + c[0].slip / slip;
  w.b[0] = w.b[1] = c[0].slip / slip - c[0].time / duration;
  return w;
}

static PetscReal WalkAt(const Walk *w, PetscReal a)
{
  if (w->a[1] == PETSC_MAX_REAL || a < w->a[0]) return w->b[0] - (a - w->a[0]);
  return w->a[1] > w->a[0] ? w->b[0] + (a - w->a[0]) / (w->a[1] - w->a[0]) * (w->b[1] - w->b[0]) : w->b[1];
}

/*
  SlipCourseLevy - computes the Levy distance of a run's slip history from that of a reference

  run [n], reference [m]: nodes in the order of their times, n and m >= 1, whose slips do not decrease; the reference
  has slipped, over a time > 0. The distance is the least e such that within e times the duration of the reference,
  before or after, each has the slip of the other to e times the final one. Where slip jumps, as in an event of seconds
  among months, it is the error of the time; at rest it is that of the slip. The largest difference of slips bounds it.
*/
PetscReal SlipCourseLevy(PetscInt n, const SlipCourseNode run[], PetscInt m, const SlipCourseNode reference[])
{
  const PetscReal duration = reference[m - 1].time - reference[0].time, slip = reference[m - 1].slip;
  Walk p = WalkStart(n, run, duration, slip), q = WalkStart(m, reference, duration, slip);
  PetscReal most = 0;

  while (p.a[1] < PETSC_MAX_REAL || q.a[1] < PETSC_MAX_REAL) {
    const PetscReal a = PetscMin(p.a[1], q.a[1]);

    most = PetscMax(most, (PetscReal)HALF * PetscAbsReal(WalkAt(&p, a) - WalkAt(&q, a)));
    if (p.a[1] <= a) WalkOn(&p);
    if (q.a[1] <= a) WalkOn(&q);
  }
  return most;
}

const SlipMeasure SlipMeasures[] = {
  {"history", {1, 1, 1, PEAK_SHARE, 1}, "the largest of all errors, that of the peak rate counting a fifth"},
  {"final_slip", {1, 0, 0, 0, 0}, "final mean slip"},
  {"event_time", {0, 0, 1, 0, 0}, "time of half the slip, over the time from 10 to 90 % of it"},
  {NULL, {0, 0, 0, 0, 0}, NULL},
};

/*
  SlipMeasureFind - finds the measure with a name, or NULL
*/
const SlipMeasure *SlipMeasureFind(const char name[])
{
  for (const SlipMeasure *row = SlipMeasures; row->name; row++)
    if (!strcmp(row->name, name)) return row;
  return NULL;
}

/*
  SlipMeasureOf - computes one number from the errors of a run

  error [SLIP_NUM_ERRORS]. The result is NaN if an error with a share is NaN.
*/
PetscReal SlipMeasureOf(const SlipMeasure *measure, const PetscReal error[])
{
  PetscReal most = 0;

  for (PetscInt i = 0; i < SLIP_NUM_ERRORS; i++) {
    if (measure->share[i] == 0) continue;
    if (PetscIsNanReal(error[i])) return error[i];
    most = PetscMax(most, measure->share[i] * error[i]);
  }
  return most;
}
