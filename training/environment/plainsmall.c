/* See plainsmall.h. The step of src/ts/bathestep.c; observations and the rules of steps are the library's
   (slipcore.h). */
#include "plainsmall.h"
#include <slipcompat.h>

#define GAMMA 0.5

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

/* ---- a run ---- */

static PetscErrorCode Choose(const PlainSmall *p, PlainPolicy *policy, const PetscReal w[], PlainSmallWatchFn fn,
                             void *ctx, PetscReal *h)
{
  PetscFunctionBegin;
  PlainPolicyObserve(policy, NULL, w, PETSC_TRUE);
  if (fn) fn(policy->n, policy->obs, ctx);
  PetscCall(SlipPolicyChoose(policy->policy, policy->obs, p->tstar, p->tmax, h, NULL));
  *h = PetscClipInterval(*h, p->dt_low, p->dt_high);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainSmallRun(const PlainSmall *p, PlainPolicy *policy, PetscReal accuracy, EnvReference reference,
                             PetscInt max_steps, PlainSmallWatchFn fn, void *ctx, PlainSmallResult *result)
{
  PetscReal w[SMALL_MAX_STATES] = {p->start[0], p->start[1], p->start[2]}, h;
  SlipRunNumbers *o = &policy->run;
  SmallErrors errors;

  PetscFunctionBegin;
  PetscCall(PlainPolicyRun(policy, accuracy, p->tstar, p->tmax));
  o->converged = PETSC_TRUE;
  SmallErrorsStart(reference, w, &errors);
  result->steps = 0;
  PetscCall(Choose(p, policy, w, fn, ctx, &h));
  h = PetscMin(h, p->tmax);
  while (o->time < p->tmax && result->steps < max_steps) {
    Step(p, o->time, h, w);
    o->time += h;
    o->dt = h;
    o->started = PETSC_TRUE;
    result->steps++;
    SmallErrorsStep(&errors, o->time, w);
    PetscCall(Choose(p, policy, w, fn, ctx, &h));
    h = SlipControlMatch(h, p->tmax - o->time);
  }
  result->finished = o->time >= p->tmax ? PETSC_TRUE : PETSC_FALSE;
  SmallErrorsEnd(&errors, result->error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- errors ---- */

static PetscReal Square(PetscInt n, const PetscReal w[])
{
  PetscReal sum = 0;

  for (PetscInt i = 0; i < n; ++i) sum += w[i] * w[i];
  return sum;
}

void SmallErrorsStart(EnvReference reference, const PetscReal w[], SmallErrors *e)
{
  *e = (SmallErrors){.reference = reference, .size2 = Square(reference->states, w)};
  for (PetscInt i = 0; i < reference->states; ++i) e->last[i] = w[i];
}

void SmallErrorsStep(SmallErrors *e, PetscReal t, const PetscReal w[])
{
  const EnvReference ref = e->reference;
  const PetscInt n = ref->states, k = PetscMin((PetscInt)(t / ref->dt), ref->n - 2);
  const PetscReal at = t / ref->dt - (PetscReal)k;
  PetscReal exact[SMALL_MAX_STATES], error[SMALL_MAX_STATES], error2, size2;

  for (; e->next < ref->n && (PetscReal)e->next * ref->dt <= t; ++e->next) { /* what a long step jumps over */
    const PetscReal s = ((PetscReal)e->next * ref->dt - e->seen) / (t - e->seen), *known = &ref->state[n * e->next];

    for (PetscInt i = 0; i < n; ++i) e->between += PetscSqr((1 - s) * e->last[i] + s * w[i] - known[i]);
    e->between_size += Square(n, known);
  }
  for (PetscInt i = 0; i < n; ++i) {
    exact[i] = (1 - at) * ref->state[n * k + i] + at * ref->state[n * (k + 1) + i];
    error[i] = w[i] - exact[i];
    e->last[i] = w[i];
  }
  error2 = Square(n, error);
  size2 = Square(n, exact);
  e->errors += 0.5 * (t - e->seen) * (e->error2 + error2);
  e->sizes += 0.5 * (t - e->seen) * (e->size2 + size2);
  e->seen = t;
  e->error2 = error2;
  e->size2 = size2;
}

void SmallErrorsEnd(const SmallErrors *e, PetscReal error[2])
{
  error[0] = PetscSqrtReal(e->errors / e->sizes);
  error[1] = PetscSqrtReal(e->between / e->between_size);
}
