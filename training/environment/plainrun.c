/* See plainrun.h: the numbers of a plain fault that the library's formulas and rules (slipcore.h) are given. */
#include "plainrun.h"
#include <slipcompat.h>
#include <math.h>

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
  PetscReal moving,
    h = 0; /* moving: longest step while anything moves [T*]; 0: no limit, and it is asked at rest too */
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
      PetscCall(PlainPolicyChoose(policy, &h));
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
  totals->time = o->time;
  PetscFunctionReturn(PETSC_SUCCESS);
}
