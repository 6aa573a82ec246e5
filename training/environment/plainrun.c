/* See plainrun.h: the numbers of a plain fault that the library's formulas and rules (slipcore.h) are given. */
#include "plainrun.h"
#include "plainrows.h"
#include <slipcompat.h>
#include <math.h>

typedef struct {
  const PlainFault *p;
  SlipPolicy policy;
  PetscInt n;
  SlipObserved seen[PLAIN_MAX_ROWS];
  SlipRunNumbers run;
  SlipFaultNumbers fault;
  PetscBool rests;  /* nothing moves, and no force exceeds its strength */
  PetscReal moving; /* longest step while anything moves [T*]; 0: no limit, and the policy is asked at rest too */
} Chooser;

/* What rows of a fault read of its state; whether it rests */
static PetscBool SumUp(const PlainFault *p, SlipFaultNumbers *f)
{
  const double n = (double)p->n;
  PetscBool rests = PETSC_TRUE;

  f->velocity = f->rate = f->peak = f->displacement = f->slip = f->sliding = 0;
  f->energy = f->kinetic = f->power = f->strength = f->weakening = f->push = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    const double v = p->v[i], u = p->u[i], q = PlainFaultStrength(p, i);
    double ku = 0;

    for (PetscInt j = 0; j < p->n; ++j) ku += p->K[i * p->n + j] * p->u[j];
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
    f->push += (v != 0 ? -(v > 0 ? 1 : -1) * ku - q : PetscMax(fabs(ku) - q, 0)) / n;
    if (v != 0 || fabs(ku) > q) rests = PETSC_FALSE;
  }
  f->total_rate = n * f->rate;
  f->slip_error = p->slip_error / n;
  f->growth = p->growth;
  PlainFaultMode(p, f->peak != 0 ? p->v : p->uc, &f->mode_stiffness, &f->mode_weakening);
  return rests;
}

static PetscErrorCode Choose(Chooser *c, PetscBool state_changed, PetscReal *h)
{
  PetscReal obs[PLAIN_MAX_ROWS];

  PetscFunctionBegin;
  c->fault.estimated = c->run.started;
  if (state_changed) c->rests = SumUp(c->p, &c->fault);
  for (PetscInt i = 0; i < c->n; ++i) {
    SlipObserved *seen = &c->seen[i];

    if (state_changed || !SlipObservedOfState(seen))
      SlipObservedTake(seen, seen->own == 0 ? (*seen->row->fault)(&c->fault) : (*seen->row->run)(&c->run));
    obs[i] = seen->value;
  }
  PetscCall(SlipPolicyChoose(c->policy, obs, c->run.tstar, c->run.max_time, h, NULL));
  if (c->moving > 0)
    *h = SlipControlRest(*h, c->moving * c->run.tstar, c->rests ? PETSC_MAX_REAL : 0, c->run.max_time - c->run.time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainRun(PlainFault *p, SlipPolicy policy, PetscReal accuracy, PetscReal tmax, PetscInt max_steps,
                        PlainWatchFn fn, void *ctx, PlainTotals *totals)
{
  Chooser c = {.p = p,
               .policy = policy,
               .run = {.accuracy = accuracy, .max_time = tmax, .tstar = p->known.tstar},
               .fault = p->known};
  SlipRunNumbers *o = &c.run;
  PetscBool known, has;
  PetscReal h;

  PetscFunctionBegin;
  *totals = (PlainTotals){0, 0, 0};
  PetscCall(PlainRowsFind(policy, NULL, &c.n, c.seen, &known));
  PetscCheck(known, PETSC_COMM_SELF, PETSC_ERR_SUP, "A plain fault does not know all observations of the policy");
  PetscCall(SlipPolicyGetNumber(policy, SLIP_POLICY_MOVING_DT_MAX, &c.moving, &has));
  PetscCall(SlipPolicyGetStepBounds(policy, p->known.tstar, tmax, &o->dt_min, &o->dt_max));
  PetscCall(Choose(&c, PETSC_TRUE, &h));
  h = PetscMin(h, tmax);
  while (o->time < tmax && totals->accepted < max_steps && totals->attempts < 2 * max_steps) {
    o->converged = PlainFaultAttempt(p, h);
    o->started = PETSC_TRUE;
    o->dt = h;
    totals->attempts++;
    if (!o->converged) {
      if (!SlipControlHalve(++o->failures, SLIP_MAX_FAILURES, &h)) PetscCall(Choose(&c, PETSC_FALSE, &h));
      h = PetscMin(h, tmax - o->time);
      continue;
    }
    totals->accepted++;
    o->failures = 0;
    o->time += h;
    PlainFaultAccept(p);
    PetscCall(Choose(&c, PETSC_TRUE, &h));
    h = SlipControlMatch(h, tmax - o->time);
    PetscCall(fn(p, o->time, ctx));
  }
  totals->time = o->time;
  PetscFunctionReturn(PETSC_SUCCESS);
}
