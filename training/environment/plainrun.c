/* See plainfault.h: runs, by the numbers of a plain fault that the library's formulas and rules (slipcore.h) are given,
   and the explicit step of src/ts/moreau.c and src/fault/stage/explicitkick.c, with entries in place of products. */
#include "plainfault.h"
#include <slipcompat.h>
#include <math.h>

enum { F, P, P_BEFORE, P_END, INNER, K_INNER }; /* of PlainMemory.f */

static double *At(const PlainFault *p, const PlainMemory *m, int row)
{
  return m->f + row * p->n;
}

double PlainFaultLimit(const PlainFault *p)
{
  return p->omega > 0 ? (double)(SLIP_LAG_MARGIN * SlipLagLimit(p->known.damping_ratio, 1)) / p->omega : 0;
}

static void Force(const PlainFault *p, const double u[], double f[])
{
  PlainMultiply(p->n, p->K, u, f);
  for (PetscInt i = 0; i < p->n; ++i) f[i] = -f[i];
}

/* v after h [s] with the force g - friction */
static void Kick(const PlainFault *p, double h, const double g[], const double s[], double v[])
{
  for (PetscInt i = 0; i < p->n; ++i) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&p->friction, i, &s[i], 0, &mu, &ds, &dv);
    v[i] = SlipKickConstant(p->mass, 0, h, g[i], mu * p->friction.stress[i], v[i]);
  }
}

static void Drift(const PlainFault *p, double h, const double v[], double u[], double s[])
{
  double *speed = p->work, *work = speed + p->n;

  for (PetscInt i = 0; i < p->n; ++i) {
    u[i] += h * v[i];
    speed[i] = fabs(v[i]);
  }
  SlipFrictionStateDrift(&p->friction, p->n, h, speed, 1, s, work);
}

/* One explicit step, TSMOREAU's, of friction that does not depend on the rate, likewise; h at most PlainFaultLimit()
   [s] */
static PetscBool PlainFaultKick(PlainFault *p, double h)
{
  const PetscInt n = p->n;
  const size_t size = sizeof(double) * (size_t)n;
  PlainMemory *m = &p->start;
  PlainMemory *end = &p->end;
  double *first = p->work + 2 * n, *push = first + n, *inner = At(p, end, INNER), *damping = At(p, end, P), weight;

  if (!m->known) { /* nothing of earlier steps */
    Force(p, p->u, At(p, m, F));
    PlainMultiply(n, p->H, p->v, At(p, m, P));
    memcpy(At(p, m, P_END), At(p, m, P), size);
    m->h = m->h_before = 0;
    m->known = PETSC_TRUE;
  }
  weight = SlipLagWeight(h, m->h, m->h_before, p->omega, p->known.damping_ratio);
  memcpy(p->v2, p->v, size);
  memcpy(p->u2, p->u, size);
  memcpy(p->s2, p->s, size);
  for (PetscInt i = 0; i < n; ++i) {
    first[i] = At(p, m, P)[i];
    if (weight != 1) first[i] = weight * first[i] + (1 - weight) * At(p, m, P_BEFORE)[i];
    push[i] = At(p, m, F)[i] - first[i];
  }
  Kick(p, 0.5 * h, push, p->s2, p->v2);
  memcpy(inner, p->v2, size);
  Drift(p, 0.5 * h, inner, p->u2, p->s2);
  PlainMultiply(n, p->H, inner, damping);
  Drift(p, 0.5 * h, inner, p->u2, p->s2);
  Force(p, p->u2, At(p, end, F));
  for (PetscInt i = 0; i < n; ++i) {
    At(p, end, K_INNER)[i] = (At(p, m, F)[i] - At(p, end, F)[i]) / h;
    push[i] = At(p, end, F)[i] - 2 * damping[i] + first[i];
    At(p, end, P_END)[i] = damping[i] + h / (h + m->h) * (damping[i] - At(p, m, P)[i]);
  }
  Kick(p, 0.5 * h, push, p->s2, p->v2);
  memcpy(At(p, end, P_BEFORE), At(p, m, P), size);
  end->h_before = m->h;
  end->h = h;
  end->known = PETSC_TRUE;
  for (PetscInt i = 0; i < n; ++i)
    if (!isfinite(p->v2[i]) || !isfinite(p->s2[i])) return PETSC_FALSE;
  /* sums of the estimates of slip and of d|v|/dt at the end, where a cell that has stopped has none */
  p->slip_error = p->growth = 0;
  for (PetscInt i = 0; i < n; ++i) {
    const double v = p->v2[i];
    PetscReal mu, ds, dv;

    p->slip_error += fabs(2. / 3 * (p->s2[i] - p->s[i] - 0.5 * h * (fabs(p->v[i]) + fabs(v))));
    if (v == 0) continue;
    SlipFrictionEvaluate(&p->friction, i, &p->s2[i], fabs(v), &mu, &ds, &dv);
    p->growth += ((v > 0 ? 1 : -1) * (At(p, end, F)[i] - At(p, end, P_END)[i]) - mu * p->friction.stress[i]) / p->mass;
  }
  return PETSC_TRUE;
}

/* PlainFaultMode() of what moves: the inner rate of the explicit step that led here, else the rate, else where all rest
   uc */
static void PlainFaultMotion(const PlainFault *p, PetscBool moves, PetscReal *stiffness, PetscReal *weakening)
{
  const double *inner = p->start.known && p->start.h > 0 ? At(p, &p->start, INNER) : NULL;
  PetscBool moved = PETSC_FALSE;

  for (PetscInt i = 0; i < p->n && inner; ++i)
    if (inner[i] != 0) moved = PETSC_TRUE;
  if (!moves)
    PlainFaultMode(p, p->uc, NULL, stiffness, weakening);
  else if (moved)
    PlainFaultMode(p, inner, At(p, &p->start, K_INNER), stiffness, weakening);
  else
    PlainFaultMode(p, p->v, NULL, stiffness, weakening);
}

/* What rows of a fault read of its state; whether it rests */
static PetscBool SumUp(const PlainFault *p, SlipFaultNumbers *f)
{
  const double n = (double)p->n;
  PetscBool rests = PETSC_TRUE;

  f->velocity = f->rate = f->peak = f->displacement = f->slip = f->sliding = 0;
  f->energy = f->kinetic = f->power = f->strength = f->weakening = f->push = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    const double v = p->v[i], u = p->u[i], q = PlainFaultStrength(p, i);
    double ku = p->start.known ? -p->start.f[i] : 0;

    for (PetscInt j = 0; j < p->n && !p->start.known; ++j) ku += p->K[i * p->n + j] * p->u[j];
    f->velocity += v / n;
    f->rate += fabs(v) / n;
    f->peak = PetscMax(f->peak, fabs(v));
    f->displacement += u / n;
    f->slip += p->s[i] / n;
    f->sliding += v != 0 ? 1 / n : 0;
    f->energy += u * ku;
    f->kinetic += p->mass * (v * v);
    f->power += v * ku;
    f->strength += q / n;
    f->weakening += PlainFaultWeakening(p, i) / n;
    f->push += SlipConePush(v, ku, q) / n;
    if (v != 0 || fabs(ku) > q) rests = PETSC_FALSE;
  }
  f->total_rate = n * f->rate;
  f->slip_error = p->slip_error / n;
  f->growth = p->growth;
  PlainFaultMotion(p, f->peak != 0 ? PETSC_TRUE : PETSC_FALSE, &f->mode_stiffness, &f->mode_weakening);
  return rests;
}

/* One attempt by the method that goes h for fewer products. An explicit one is cut to what is stable, but at rest
   begins anew, as TSMoreauCut() does. */
static PetscBool Attempt(PlainFault *p, const SlipMethodCosts *costs, PetscBool rests, PetscReal *h,
                         PlainTotals *totals)
{
  const PetscReal limit = costs ? (PetscReal)PlainFaultLimit(p) : 0;

  if (!costs) return PlainFaultAttempt(p, *h);
  if (!SlipMethodIsExplicit(costs, *h, limit, p->start.known ? PETSC_FALSE : PETSC_TRUE)) {
    totals->products += (double)SlipMethodSolve(costs, limit > 0 ? *h / limit : 1);
    return PlainFaultAttempt(p, *h);
  }
  totals->products += (double)costs->step * (p->start.known ? 1 : 2);
  if (*h > limit && rests)
    p->start.known = PETSC_FALSE; /* what it then computes is known: the force has stayed, and nothing is damped */
  else
    *h = PetscMin(*h, limit);
  return PlainFaultKick(p, *h);
}

PetscErrorCode PlainRun(PlainFault *p, PlainPolicy *policy, PetscReal accuracy, PetscReal tmax,
                        const SlipMethodCosts *costs, PetscInt max_steps, PlainWatchFn fn, void *ctx,
                        PlainTotals *totals)
{
  SlipRunNumbers *o = &policy->run;
  SlipFaultNumbers fault = p->known;
  PetscReal moving, h = 0; /* longest step while anything moves [T*], 0: no limit, and it is asked at rest too */
  PetscBool has, rests = PETSC_FALSE, changed = PETSC_TRUE, choose = PETSC_TRUE;

  PetscFunctionBegin;
  *totals = (PlainTotals){.attempts = 0};
  fault.step_limit = (PetscReal)PlainFaultLimit(p);
  fault.solve_cost = costs ? SlipMethodSolve(costs, 1) / costs->step : 0;
  PetscCall(PlainPolicyRun(policy, accuracy, p->known.tstar, tmax));
  PetscCall(SlipPolicyGetNumber(policy->policy, SLIP_POLICY_MOVING_DT_MAX, &moving, &has));
  while (PETSC_TRUE) {
    if (choose) {
      fault.estimated = o->started;
      if (changed) rests = SumUp(p, &fault);
      PlainPolicyObserve(policy, &fault, NULL, changed);
      PetscCall(SlipPolicyChoose(policy->policy, policy->obs, o->tstar, o->max_time, &h, NULL));
      if (moving > 0) h = SlipControlRest(h, moving * o->tstar, rests ? PETSC_MAX_REAL : 0, tmax - o->time);
    }
    if (o->started && changed) {
      h = SlipControlMatch(h, tmax - o->time);
      PetscCall(fn(p, o->time, ctx));
    } else
      h = PetscMin(h, tmax - o->time);
    if (o->time >= tmax || totals->accepted >= max_steps || totals->attempts >= 2 * max_steps) break;
    o->converged = changed = Attempt(p, costs, rests, &h, totals);
    o->started = PETSC_TRUE;
    o->dt = h;
    totals->attempts++;
    choose = changed || !SlipControlHalve(++o->failures, SLIP_MAX_FAILURES, &h) ? PETSC_TRUE : PETSC_FALSE;
    if (!changed) continue;
    totals->accepted++;
    o->failures = 0;
    o->time += h;
    PlainFaultAccept(p);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
