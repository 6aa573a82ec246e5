/* The update of a cell in an explicit step (TSMOREAU): of its rate in a kick, in which only its own balance counts, and
   of its states in a drift, in which its rate is constant */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

enum { MAX_IT = 100 };
#define ENOUGH 1e-14 /* last relative change of the rate */

/*
  SlipFrictionKick - computes the speed v of cell i with D v + omega w sigma mu(s, v) = load, 0 if friction holds it

  load >= 0; s are the states of c, with theta 0. For a law that depends on the rate, Newton's method works in a bracket
  from guess, the previous rate; *ok becomes false if friction decreases with the rate faster than D v grows, so that
  there may be several roots.
*/
PetscReal SlipFrictionKick(const SlipFrictionCells *f, PetscInt i, const SlipFrictionStageCell *c, PetscReal load,
                           PetscReal guess, PetscBool *ok)
{
  const PetscReal strength = c->omega * (f->weight ? f->weight[i] : 1) * f->stress[i];
  PetscReal mu, ds[SLIP_MAX_STATES], dv, none[SLIP_MAX_STATES], low = 0, high = load / c->diagonal, v;

  if (f->law->always_slides) {
    PetscBool stable;

    v = PetscAbsReal(SlipFrictionStageRate(f, i, c, load, guess, &stable));
    if (!stable) *ok = PETSC_FALSE;
    return v;
  }
  SlipFrictionStage(f, i, 0, c->s0, 0, &mu, ds, &dv, none);
  if (load <= strength * mu) return 0;
  if (!f->law->by_rate) return (load - strength * mu) / c->diagonal;
  v = PetscClipInterval(guess, low, high);
  for (int it = 0; it < MAX_IT; it++) {
    PetscReal g, slope, next;

    SlipFrictionStage(f, i, 0, c->s0, v, &mu, ds, &dv, none);
    g = c->diagonal * v + strength * mu - load;
    slope = c->diagonal + strength * dv;
    if (g > 0)
      high = v;
    else
      low = v;
    next = slope > 0 ? v - g / slope : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (PetscAbsReal(next - v) <= ENOUGH * v || !(high > low)) {
      if (!(slope > 0)) *ok = PETSC_FALSE;
      break;
    }
    v = next;
  }
  return v;
}

/* Computes the states after h [s] at the rates v [n], in place; s has a stride; work [n states]. Alexander's second
   formula, of second order and L-stable (batheweights.c), makes slip v h to the last bits, and leaves states that do
   not change as they are. */
void SlipFrictionStateDrift(const SlipFrictionCells *f, PetscInt n, PetscReal h, const PetscReal v[], PetscInt stride,
                            PetscReal s[], PetscReal work[])
{
  const PetscInt states = SlipFrictionStates(f->law);
  SlipBathe c;

  if (f->law->drift && f->law->drift(f, n, h, v, stride, s)) return;
  SlipBatheSetUpBackward(&c);
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt k = 0; k < states; k++) work[states * i + k] = s[stride * i + k];
  if (!f->law->nstates && !f->healing) {
    SlipFrictionStateAdvance(f, n, h, work, v, stride, s);
    return;
  }
  SlipFrictionStateAdvance(f, n, c.theta[0] * h, work, v, stride, s);
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt k = 0; k < states; k++) {
      PetscReal *base = work + states * i + k;
      const PetscReal inner = s[stride * i + k];

      *base = inner + c.a0 * (inner - *base);
    }
  SlipFrictionStateAdvance(f, n, c.theta[1] * h, work, v, stride, s);
}
