/* See plainsmall.h. The step of src/ts/bathestep.c, the rules of src/adapt/rl.c and TSAdaptChoose(), the observations
   of src/adapt/observe.c. */
#include "plainsmall.h"
#include <slipcompat.h>

#define GAMMA 0.5
enum { MAX_SEEN = 24 };

/* ---- the integrator ---- */

/* x of (A - c G) x = b, by elimination without pivoting: A is positive and G dissipates */
static void SolveLinear(const PlainSmall *p, PetscReal c, const PetscReal b[], PetscReal x[])
{
  const PetscInt n = p->n;
  PetscReal a[SMALL_MAX_STATES][SMALL_MAX_STATES];

  for (PetscInt i = 0; i < n; ++i) {
    for (PetscInt j = 0; j < n; ++j) a[i][j] = (i == j ? p->A[i] : 0) - c * p->G[i][j];
    x[i] = b[i];
  }
  for (PetscInt k = 0; k < n; ++k)
    for (PetscInt i = k + 1; i < n; ++i) {
      const PetscReal factor = a[i][k] / a[k][k];

      for (PetscInt j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      x[i] -= factor * x[k];
    }
  for (PetscInt k = n - 1; k >= 0; --k) {
    for (PetscInt j = k + 1; j < n; ++j) x[k] -= a[k][j] * x[j];
    x[k] /= a[k][k];
  }
}

/* A stage: (A - c G) w = b + cr r e_0, r in -q Sign(w_0) */
static void Stage(const PlainSmall *p, PetscReal c, PetscReal cr, const PetscReal b[], PetscReal w[])
{
  const PetscReal unit[SMALL_MAX_STATES] = {cr, 0, 0};
  PetscReal free[SMALL_MAX_STATES], pushed[SMALL_MAX_STATES], r;

  SolveLinear(p, c, b, free);
  SolveLinear(p, c, unit, pushed);
  r = SlipConeClip(-free[0] / pushed[0], p->q);
  for (PetscInt i = 0; i < p->n; ++i) w[i] = free[i] + r * pushed[i];
  if (PetscAbsReal(r) < p->q) w[0] = 0;
}

static PetscReal Force(const PlainSmall *p, PetscInt i, PetscReal t, const PetscReal w[])
{
  PetscReal F = i == 0 && p->force ? (*p->force)(p->model, t) : 0;

  for (PetscInt j = 0; j < p->n; ++j) F += p->G[i][j] * w[j];
  return F;
}

/* One step of the composite rule with the trapezoidal reaction, in place */
static void Step(const PlainSmall *p, PetscReal t, PetscReal h, PetscReal w[])
{
  const PetscReal r = SlipConeReaction(1, w[0], -Force(p, 0, t, w), p->q); /* at rest the static balance holds */
  PetscReal b[SMALL_MAX_STATES], w1[SMALL_MAX_STATES], theta[2];
  SlipBathe c;

  SlipBatheSetUp(GAMMA, &c);
  theta[0] = c.theta[0] * h;
  theta[1] = c.theta[1] * h;
  for (PetscInt i = 0; i < p->n; ++i) b[i] = p->A[i] * w[i] + theta[0] * Force(p, i, t, w);
  b[0] += theta[0] * (r + (p->force ? (*p->force)(p->model, t + GAMMA * h) : 0));
  Stage(p, theta[0], theta[0], b, w1);
  for (PetscInt i = 0; i < p->n; ++i) b[i] = p->A[i] * (c.a1 * w1[i] - c.a0 * w[i]);
  if (p->force) b[0] += theta[1] * (*p->force)(p->model, t + h);
  Stage(p, theta[1], theta[1], b, w);
}

/* ---- observations ---- */

typedef struct {
  const PlainSmall *p;
  PetscReal accuracy, time, last_dt;
  const PetscReal *w;
  PetscBool started;
} Seen;

/* Those that the library knows of every problem */
static PetscBool ObserveCommon(const Seen *o, const char name[], PetscReal *value)
{
  const PlainSmall *p = o->p;

  if (!strcmp(name, "log_accuracy")) {
    *value = PetscLog10Real(o->accuracy);
  } else if (!strcmp(name, "log_time_left")) {
    *value = PetscLog10Real(PetscClipInterval((p->tmax - o->time) / p->tstar, (PetscReal)1e-3, (PetscReal)1e3));
  } else if (!strcmp(name, "time_fraction")) {
    *value = o->time / p->tmax;
  } else if (!strcmp(name, "log_step")) {
    *value = PetscLog10Real(PetscClipInterval(o->last_dt / p->tstar, (PetscReal)1e-16, (PetscReal)1e16));
  } else if (!strcmp(name, "converged")) {
    *value = o->started ? 1 : 0;
  } else {
    return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

static PetscBool Observe(const Seen *o, const char name[], PetscReal *value)
{
  return (*o->p->observe)(o->p->model, o->time, o->w, name, value) || ObserveCommon(o, name, value) ? PETSC_TRUE
                                                                                                    : PETSC_FALSE;
}

PetscErrorCode PlainSmallKnows(const PlainSmall *p, SlipPolicy policy, PetscBool *known)
{
  const Seen o = {.p = p, .accuracy = 1, .w = p->start, .last_dt = p->tstar};
  const char *const *names;
  PetscReal value;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  *known = n <= MAX_SEEN ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt i = 0; i < n && *known; ++i) *known = Observe(&o, names[i], &value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

/* PETSc's matching of the final time with its default factors: the last two steps are halves of what is left. */
static PetscReal Match(PetscReal h, PetscReal left)
{
  if (left <= 0) return h;
  if (1.01 * h > left) return left;
  return 2 * h > left ? 0.5 * left : h;
}

static PetscErrorCode Choose(const Seen *o, SlipPolicy policy, PlainSmallWatchFn fn, void *ctx, PetscReal *h)
{
  const char *const *names;
  PetscReal obs[MAX_SEEN], action;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetObservations(policy, &n, &names));
  for (PetscInt i = 0; i < n; ++i) Observe(o, names[i], &obs[i]);
  if (fn) fn(n, obs, ctx);
  PetscCall(SlipPolicyEvaluate(policy, obs, &action, NULL));
  PetscCall(SlipPolicyActionToStep(policy, action, o->p->tstar, o->p->tmax, h));
  *h = PetscClipInterval(*h, o->p->dt_low, o->p->dt_high);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainSmallRun(const PlainSmall *p, SlipPolicy policy, PetscReal accuracy, EnvReference reference,
                             PetscInt max_steps, PlainSmallWatchFn fn, void *ctx, PlainSmallResult *result)
{
  PetscReal w[SMALL_MAX_STATES] = {p->start[0], p->start[1], p->start[2]}, h, low, high;
  Seen o = {.p = p, .accuracy = accuracy, .w = w};
  SmallErrors errors;

  PetscFunctionBegin;
  PetscCall(SlipPolicyGetStepBounds(policy, p->tstar, p->tmax, &low, &high));
  o.last_dt = 0.5 * (low + high);
  SmallErrorsStart(reference, w, &errors);
  result->steps = 0;
  PetscCall(Choose(&o, policy, fn, ctx, &h));
  h = PetscMin(h, p->tmax);
  while (o.time < p->tmax && result->steps < max_steps) {
    Step(p, o.time, h, w);
    o.time += h;
    o.last_dt = h;
    o.started = PETSC_TRUE;
    result->steps++;
    SmallErrorsStep(&errors, o.time, w);
    PetscCall(Choose(&o, policy, fn, ctx, &h));
    h = Match(h, p->tmax - o.time);
  }
  result->finished = o.time >= p->tmax ? PETSC_TRUE : PETSC_FALSE;
  SmallErrorsEnd(&errors, result->error);
  PetscFunctionReturn(PETSC_SUCCESS);
}
