/* See plainrun.h. The rules of src/adapt/rl.c and of TSAdaptChoose(), the observations of src/adapt/observe.c and
   src/fault/observe.c. */
#include "plainrun.h"
#include <slipcompat.h>
#include <math.h>
#include <string.h>

enum { MAX_SEEN = 64 };
#define MAX_FAILURES 3 /* attempts in a row before steps are halved */

typedef struct {
  const PlainFault *p;
  double accuracy, tmax, time, dt_middle;
  PetscBool started, converged;
  double last_dt;
  PetscInt failures;
  double rate, peak, slip, weakening, energy, sliding; /* means over the cells of the state */
} Seen;

static double Clip(double x, double low, double high)
{
  return x < low ? low : (x > high ? high : x);
}

static void SumUp(Seen *o)
{
  const PlainFault *p = o->p;
  const double n = (double)p->n;

  o->rate = o->peak = o->slip = o->weakening = o->energy = o->sliding = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    double ku = 0;

    for (PetscInt j = 0; j < p->n; ++j) ku += p->K[i * p->n + j] * p->u[j];
    o->energy += p->u[i] * ku;
    o->rate += fabs(p->v[i]) / n;
    o->peak = PetscMax(o->peak, fabs(p->v[i]));
    o->slip += p->s[i] / n;
    o->weakening += PlainFaultWeakening(p, i) / n;
    o->sliding += p->v[i] != 0 ? 1 / n : 0;
  }
}

static double LogAccuracy(const Seen *o)
{
  return log10(o->accuracy);
}
static double LogRate(const Seen *o)
{
  return log10(Clip(o->rate * o->p->tstar / o->p->drop_slip, 1e-6, 1e6));
}
static double LogPeakRate(const Seen *o)
{
  return log10(Clip(o->peak * o->p->tstar / o->p->drop_slip, 1e-6, 1e6));
}
static double Energy(const Seen *o)
{
  return o->energy / o->p->critical_energy;
}
static double Progress(const Seen *o)
{
  return o->slip / o->p->drop_slip;
}
static double Weakening(const Seen *o)
{
  return o->weakening / o->p->mean_drop;
}
static double LogDrop(const Seen *o)
{
  return log10(o->p->drop_slip / o->p->mean_dc);
}
static double SlidingFraction(const Seen *o)
{
  return o->sliding;
}
static double Converged(const Seen *o)
{
  return o->started && o->converged ? 1 : 0;
}
static double Failures(const Seen *o)
{
  return (double)o->failures;
}
static double TimeFraction(const Seen *o)
{
  return o->time / o->tmax;
}
static double LogTimeLeft(const Seen *o)
{
  return log10(Clip((o->tmax - o->time) / o->p->tstar, 1e-3, 1e3));
}

static double LogStep(const Seen *o)
{
  return log10(Clip((o->started ? o->last_dt : o->dt_middle) / o->p->tstar, 1e-16, 1e16));
}

static double LogSlipError(const Seen *o)
{
  const PlainFault *p = o->p;

  return o->started ? log10(Clip(p->slip_error / (double)p->n / p->drop_slip, 1e-9, 1e3)) : -3;
}

static double Growth(const Seen *o)
{
  const PlainFault *p = o->p;

  return o->started && o->rate > 0 ? asinh(p->tstar * p->growth / ((double)p->n * o->rate)) : 0;
}

/* of_state: kept over a failed attempt */
static const struct {
  const char *name;
  PetscBool of_state;
  double (*value)(const Seen *);
} Rows[] = {
  {"log_accuracy", PETSC_FALSE, LogAccuracy},
  {"log_rate", PETSC_TRUE, LogRate},
  {"log_peak_rate", PETSC_TRUE, LogPeakRate},
  {"energy", PETSC_TRUE, Energy},
  {"progress", PETSC_TRUE, Progress},
  {"weakening", PETSC_TRUE, Weakening},
  {"log_drop", PETSC_TRUE, LogDrop},
  {"log_step", PETSC_FALSE, LogStep},
  {"log_slip_error", PETSC_TRUE, LogSlipError},
  {"growth", PETSC_TRUE, Growth},
  {"sliding_fraction", PETSC_TRUE, SlidingFraction},
  {"log_time_left", PETSC_FALSE, LogTimeLeft},
  {"converged", PETSC_FALSE, Converged},
  {"failures", PETSC_FALSE, Failures},
  {"time_fraction", PETSC_FALSE, TimeFraction},
};
enum { NROWS = PETSC_STATIC_ARRAY_LENGTH(Rows) };
static const char change[] = "change_";

/* Rows of the policy's observations; row -1: not known here. */
static PetscErrorCode FindRows(SlipPolicy policy, PetscInt *n, PetscInt row[], PetscBool is_change[], PetscBool *known)
{
  const char *const *names;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetObservations(policy, n, &names));
  *known = *n <= MAX_SEEN ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < *n && *known; ++i) {
    const char *name = names[i];

    is_change[i] = strncmp(name, change, sizeof(change) - 1) ? PETSC_FALSE : PETSC_TRUE;
    if (is_change[i]) name += sizeof(change) - 1;
    row[i] = -1;
    for (PetscInt k = 0; k < NROWS; ++k)
      if (!strcmp(name, Rows[k].name)) row[i] = k;
    if (row[i] < 0) *known = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainRunKnows(SlipPolicy policy, PetscBool *known)
{
  PetscInt n, row[MAX_SEEN];
  PetscBool is_change[MAX_SEEN];

  PetscFunctionBegin;
  PetscCall(FindRows(policy, &n, row, is_change, known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  SlipPolicy policy;
  PetscInt n, row[MAX_SEEN];
  PetscBool is_change[MAX_SEEN], has_base[MAX_SEEN];
  PetscReal obs[MAX_SEEN], base[MAX_SEEN];
  PetscReal moving; /* longest step while anything moves [T*]; 0: no limit, and the policy is asked at rest too */
} Chooser;

/* Nothing moves, and no force exceeds its strength. */
static PetscBool Rests(const PlainFault *p)
{
  for (PetscInt i = 0; i < p->n; ++i)
    if (p->v[i] != 0) return PETSC_FALSE;
  for (PetscInt i = 0; i < p->n; ++i) {
    double ku = 0;

    for (PetscInt j = 0; j < p->n; ++j) ku += p->K[i * p->n + j] * p->u[j];
    if (fabs(ku) > PlainFaultStrength(p, i)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

static PetscErrorCode Choose(Chooser *c, Seen *o, PetscBool state_changed, PetscReal *h)
{
  PetscReal action;

  PetscFunctionBegin;
  if (state_changed) SumUp(o);
  for (PetscInt i = 0; i < c->n; ++i) {
    const PetscInt k = c->row[i];

    if (!state_changed && (Rows[k].of_state || c->is_change[i])) continue;
    c->obs[i] = (PetscReal)Rows[k].value(o);
    if (!c->is_change[i]) continue;
    const PetscReal now = c->obs[i];

    c->obs[i] = c->has_base[i] ? now - c->base[i] : 0;
    c->base[i] = now;
    c->has_base[i] = PETSC_TRUE;
  }
  PetscCall(SlipPolicyEvaluate(c->policy, c->obs, &action, NULL));
  PetscCall(SlipPolicyActionToStep(c->policy, action, o->p->tstar, o->tmax, h));
  if (c->moving > 0)
    *h = Rests(o->p) ? PetscMax(o->tmax - o->time, c->moving * o->p->tstar) : PetscMin(*h, c->moving * o->p->tstar);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PETSc's matching of the final time with its default factors: the last two steps are halves of what is left. */
static double Match(double h, double left)
{
  if (left <= 0) return h;
  if (1.01 * h > left) return left;
  return 2 * h > left ? 0.5 * left : h;
}

PetscErrorCode PlainRun(PlainFault *p, SlipPolicy policy, PetscReal accuracy, PetscReal tmax, PetscInt max_steps,
                        PlainWatchFn fn, void *ctx, PlainTotals *totals)
{
  Seen o = {.p = p, .accuracy = (double)accuracy, .tmax = (double)tmax};
  Chooser c = {.policy = policy};
  PetscReal dt_min, dt_max, h;
  PetscBool known, has;

  PetscFunctionBegin;
  *totals = (PlainTotals){0, 0, 0};
  PetscCall(FindRows(policy, &c.n, c.row, c.is_change, &known));
  PetscCheck(known, PETSC_COMM_SELF, PETSC_ERR_SUP, "A plain fault does not know all observations of the policy");
  PetscCall(SlipPolicyGetNumber(policy, SLIP_POLICY_MOVING_DT_MAX, &c.moving, &has));
  PetscCall(SlipPolicyGetStepBounds(policy, p->tstar, tmax, &dt_min, &dt_max));
  o.dt_middle = 0.5 * (double)(dt_min + dt_max);
  PetscCall(Choose(&c, &o, PETSC_TRUE, &h));
  h = PetscMin(h, tmax);
  while (o.time < o.tmax && totals->accepted < max_steps && totals->attempts < 2 * max_steps) {
    o.converged = PlainFaultAttempt(p, h);
    o.started = PETSC_TRUE;
    o.last_dt = h;
    totals->attempts++;
    if (!o.converged) {
      if (++o.failures >= MAX_FAILURES)
        h *= 0.5;
      else
        PetscCall(Choose(&c, &o, PETSC_FALSE, &h));
      h = PetscMin(h, o.tmax - o.time);
      continue;
    }
    totals->accepted++;
    o.failures = 0;
    o.time += h;
    PlainFaultAccept(p);
    PetscCall(Choose(&c, &o, PETSC_TRUE, &h));
    h = Match(h, o.tmax - o.time);
    fn(p, o.time, ctx);
  }
  totals->time = o.time;
  PetscFunctionReturn(PETSC_SUCCESS);
}
