/* Computes states within a step of other integrators than TSBATHE, and powers of states. Where cells always slide,
   rates follow from the balance of the u and s of TSInterpolate(): this costs a product with K. Friction that sticks
   has rates that damping bounds, and the slopes of u and s at both ends are available: Hermite's cubics connect these,
   and their slopes are the rates within, without any product. Steps in which the bound is passed, two in an event, use
   the balance instead. A cubic does not show when the first cell starts, or that on a fault that slips from its start
   the rate there is not 0. */
#include <slipstep/private/sliprunfiles.h>
#include <slipstep/private/slipsys.h>

/* Computes powers of a state [W] from sum [3], and of faults after those, as SlipFaultGetPowers() returns them. */
static PetscErrorCode Assemble(SlipFaultCatalogue cat, PetscReal t, Vec w, const PetscReal sum[3], PetscReal power[])
{
  const PetscReal area = cat->fault->mesh.area;
  PetscReal loading;

  PetscFunctionBegin;
  PetscCall(SlipFaultLoadingPower(cat->fault, t, w, &loading));
  power[WORK_RADIATED] = area * sum[0];
  power[WORK_DISSIPATED] = area * sum[2];
  power[WORK_LOADING] = loading - area * sum[1];
  for (PetscInt k = FAULT_NUM_WORKS; k < cat->nwork; k++) power[k] *= area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal *OfFaults(SlipFaultCatalogue cat, PetscReal power[])
{
  return cat->nwork > FAULT_NUM_WORKS ? power + FAULT_NUM_WORKS : NULL;
}

/* Computes the powers of a state; costs a product with H. */
PetscErrorCode SlipCataloguePowers(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscReal power[])
{
  PetscReal sum[3];

  PetscFunctionBegin;
  PetscCall(SlipFaultGetPowers(cat->fault, t, w, NULL, sum, OfFaults(cat, power)));
  PetscCall(Assemble(cat, t, w, sum, power));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does the same for the middle of an explicit step without inertia; needs no product. */
PetscErrorCode SlipCatalogueMiddlePowers(SlipFaultCatalogue cat, const SlipEventStep *step, Vec w, PetscReal power[])
{
  const SlipFaultStickingStep ends = {step->node[0], step->node[step->nodes - 1], step->dt};
  const PetscReal t = step->begin + 0.5 * step->dt;
  PetscReal sum[3];

  PetscFunctionBegin;
  PetscCall(SlipFaultStickingPowers(cat->fault, t, w, &ends, sum, OfFaults(cat, power)));
  PetscCall(Assemble(cat, t, w, sum, power));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cached data of the last right-hand side, from which the integrator continues, and of the friction of its state */
typedef struct {
  PetscBool known, balanced;
  PetscReal time, *friction;
} Last;

static PetscErrorCode Swap(SlipFault fault)
{
  SlipFaultBalance *b = &fault->balance;
  Vec *of_last[] = {&b->u, &b->rate, &b->force, &fault->coupling.rise};

  PetscFunctionBegin;
  for (PetscInt k = 0; k < (fault->kind.coupled ? 4 : 3); k++) {
    const Vec last = *of_last[k];

    if (!b->aside[k]) PetscCall(VecDuplicate(last, &b->aside[k]));
    *of_last[k] = b->aside[k];
    b->aside[k] = last;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the cached data aside during computations of states within the step, until TakeBack(). */
static PetscErrorCode PutAside(SlipFault fault, Last *last)
{
  PetscFunctionBegin;
  *last = (Last){fault->balance.known, fault->coupling.balanced, fault->balance.time, fault->friction.known};
  PetscCall(Swap(fault));
  fault->balance.known = fault->coupling.balanced = PETSC_FALSE;
  fault->friction.known = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeBack(SlipFault fault, const Last *last)
{
  PetscFunctionBegin;
  PetscCall(Swap(fault));
  fault->balance.known = last->known;
  fault->balance.time = last->time;
  fault->coupling.balanced = last->balanced;
  fault->coupling.moment = (SlipFaultMoment){0};
  fault->friction.known = last->friction;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the slip rates of the balance for a state within the last step; F: its rates, power [3] and friction: as in
   SlipFaultGetPowers(), or NULL. Costs a product with K, and with Kn where slip changes normal stress. */
static PetscErrorCode BalanceWithin(SlipFault fault, PetscReal t, Vec w, Vec F, PetscReal power[3],
                                    PetscReal friction[])
{
  Last last;

  PetscFunctionBegin;
  PetscCall(PutAside(fault, &last));
  PetscCall(SlipFaultRates(fault, t, w, F));
  PetscCall(SlipFaultPutRates(fault, w));
  if (power) PetscCall(SlipFaultGetPowers(fault, t, w, NULL, power, friction));
  PetscCall(TakeBack(fault, &last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes Hermite's cubic between the ends, for integrators without a dense output. The slopes are their right-hand
   sides, which cost a product with K each. */
static PetscErrorCode Cubic(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal share, Vec w)
{
  const PetscReal s = share, h = step->dt;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2 && !step->sloped; k++) {
    if (!cat->slope[k]) PetscCall(SlipFaultCreateState(cat->fault, &cat->slope[k]));
    PetscCall(VecCopy(k ? step->node[step->nodes - 1] : cat->before, w));
    PetscCall(BalanceWithin(cat->fault, step->begin + k * h, w, cat->slope[k], NULL, NULL));
  }
  step->sloped = PETSC_TRUE;
  PetscCall(VecCopy(cat->before, w));
  PetscCall(VecAXPBY(w, s * s * (3 - 2 * s), 1 - s * s * (3 - 2 * s), step->node[step->nodes - 1]));
  PetscCall(VecAXPBYPCZ(w, h * s * (1 - s) * (1 - s), h * s * s * (s - 1), 1, cat->slope[0], cat->slope[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does the same on a straight line. The slip of a cell that starts to slide determines when, at its final rate. */
static PetscErrorCode Straight(SlipFaultCatalogue cat, const SlipEventStep *step, PetscReal share, Vec w)
{
  const Vec last = step->node[step->nodes - 1];
  SlipFault fault = cat->fault;
  const PetscReal *from, *to;
  PetscReal *a;
  const SlipArrays arrays[] = {{cat->before, .read = &from}, {last, .read = &to}};

  PetscFunctionBegin;
  PetscCall(VecCopy(cat->before, w));
  PetscCall(VecAXPBY(w, share, 1 - share, last));
  PetscCall(SlipArraysGet(2, arrays));
  PetscCall(VecGetArray(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt u = SlipFaultDisplacementAt(fault, i), c = fault->layout.components;
    PetscReal slip[3];

    if (SlipFaultSpeed(fault, from, i) != 0) continue;
    for (PetscInt k = 0; k < c; k++) slip[k] = to[u + k] - from[u + k];
    if ((1 - share) * step->dt * SlipFaultSpeed(fault, to, i) < SlipFaultLength(fault, slip) * (1 - (PetscReal)1e-9))
      continue;
    for (PetscInt k = 0; k < c; k++) a[SlipFaultRateAt(fault, i) + k] = 0;
  }
  PetscCall(VecRestoreArray(w, &a));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers within a step of length h follow from those at its ends and their slopes: the cubic and its slope are sums
   with these weights; that of the ends multiplies their difference */
typedef struct {
  PetscReal rise, first, last;                   /* beside the number at the start */
  PetscReal slope_rise, slope_first, slope_last; /* [1/s] of the first */
} Hermite;

static Hermite HermiteAt(PetscReal s, PetscReal h)
{
  return (Hermite){s * s * (3 - 2 * s), h * s * (1 - s) * (1 - s), -h * s * s * (1 - s),
                   6 * s * (1 - s) / h, (1 - s) * (1 - 3 * s),     s * (3 * s - 2)};
}

/* Computes the state for friction that sticks. A cell whose slope opposes its slip starts or stops within the step, and
   rests there. In the middle Simpson's rule with the slope gives the slip, and it is as exact as the rule. */
static PetscErrorCode Sticking(SlipFaultCatalogue cat, const SlipEventStep *step, PetscReal share, Vec w)
{
  SlipFault fault = cat->fault;
  const PetscInt components = fault->layout.components;
  const Hermite c = HermiteAt(share, step->dt);
  const PetscReal *from, *to, *vinf, *healing = fault->friction.healing;
  PetscReal *a;
  const SlipArrays arrays[] = {{cat->before, .read = &from},
                               {step->node[step->nodes - 1], .read = &to},
                               {fault->operators.vinf, .read = &vinf},
                               {w, .write = &a}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(4, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt v = SlipFaultRateAt(fault, i), u = SlipFaultDisplacementAt(fault, i), s = SlipFaultStateAt(fault, i);
    const PetscReal heals = healing ? healing[i] : 0;
    PetscReal way = 0;

    for (PetscInt k = 0; k < components; k++) {
      const PetscReal loading = vinf[components * i + k], first = from[v + k] - loading, last = to[v + k] - loading,
                      rise = to[u + k] - from[u + k];

      a[u + k] = from[u + k] + c.rise * rise + c.first * first + c.last * last;
      a[v + k] = loading + c.slope_rise * rise + c.slope_first * first + c.slope_last * last;
      way += a[v + k] * (rise + step->dt * loading);
    }
    for (PetscInt k = 0; k < components && !(way > 0); k++) a[v + k] = 0;
    a[s] = from[s] + c.rise * (to[s] - from[s]) + c.first * (SlipFaultSpeed(fault, from, i) - from[s] * heals) +
           c.last * (SlipFaultSpeed(fault, to, i) - to[s] * heals);
  }
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the state at a share of the step, and unless NULL its powers. */
PetscErrorCode SlipCatalogueStateWithin(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal share, Vec w,
                                        PetscReal power[])
{
  const PetscReal t = step->begin + share * step->dt;
  const SlipFaultStickingStep ends = {cat->before, step->node[step->nodes - 1], step->dt};
  PetscReal sum[3];
  Last last;

  PetscFunctionBegin;
  if (step->straight) {
    PetscCall(Straight(cat, step, share, w));
    if (power) PetscCall(SlipCataloguePowers(cat, t, w, power));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (step->sticks && !step->side) {
    PetscCall(Sticking(cat, step, share, w));
    PetscCall(PutAside(cat->fault, &last));
    PetscCall(SlipFaultStickingPowers(cat->fault, t, w, &ends, sum, OfFaults(cat, power)));
    PetscCall(TakeBack(cat->fault, &last));
    PetscCall(Assemble(cat, t, w, sum, power));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(step->dense ? TSInterpolate(step->ts, t, w) : Cubic(cat, step, share, w));
  PetscCall(BalanceWithin(cat->fault, t, w, NULL, power ? sum : NULL, power ? OfFaults(cat, power) : NULL));
  if (power) PetscCall(Assemble(cat, t, w, sum, power));
  PetscFunctionReturn(PETSC_SUCCESS);
}
