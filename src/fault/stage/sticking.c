/* Computes friction that sticks in explicit steps without inertia. In each cell the slip rate is a function of stress,

      eta v = max(|T - K u + eta v_inf| - q(s, |v|), 0) along that stress,

   continuous, with a kink where a cell starts or stops. It is a right-hand side for TSRKC, TSRK and TSADAMS, whose
   cells rest with v = 0 exactly. While all of them rest, until the next one starts, nothing is solved: such a step has
   constant rates, which formulas of any order add up to the state that SlipFaultRest() finds. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <slipstep/private/slipwork.h>

/* At the end of an event: the slip that may remain, over the tolerance of a step; the share of stress to which solves
   with the sliding cells converge; and the largest numbers of solves and of products in each. */
#define LANDING_SLIP 0.1
#define LANDING_SHARE 1e-3
#define LANDING_FAR 1e3 /* steps of a rupture up to its end, below which going on is cheaper */
enum { LANDING_SOLVES = 8, LANDING_PRODUCTS = 200 };

/* Sets the tolerances of a state: errors of u and s are measured against d_c or the largest displacement so far
   (tolerance.c), times rtol. */
PetscErrorCode SlipFaultStickingTolerances(SlipFault fault, PetscReal rtol, PetscReal atol[])
{
  SlipFaultBalance *b = &fault->balance;
  SlipFrictionCells friction;
  PetscBool follows = PETSC_FALSE, steady = PETSC_FALSE;
  PetscReal least = PETSC_MAX_REAL;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscBool weakens;
    const PetscReal scale = SlipFaultSlipScale(fault, &friction, i, b->moved, &weakens);
    const PetscReal wanted = rtol * SlipFaultStickingScale(fault, scale, weakens, b->moved);

    if (!weakens) steady = PETSC_TRUE;
    if (!weakens || wanted < rtol * scale) follows = PETSC_TRUE;
    least = PetscMin(least, scale);
    for (PetscInt k = 0; k < fault->layout.components; k++) {
      atol[SlipFaultRateAt(fault, i) + k] = 1; /* nothing integrates the rate */
      atol[SlipFaultDisplacementAt(fault, i) + k] = wanted;
    }
    for (PetscInt k = 0; k < fault->layout.states; k++) atol[SlipFaultStateAt(fault, i) + k] = wanted;
  }
  PetscCallMPI(MPI_Allreduce(&steady, &b->steady, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  PetscCallMPI(MPI_Allreduce(&follows, &b->follows, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  PetscCallMPI(MPI_Allreduce(&least, &b->least, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the friction of a state as a weighted reaction: the strength of sliding cells, and what balances the stress
   of others. Where the last right-hand side was that of the state, SlipConstraintInitialReaction() needs a product
   more. */
PetscErrorCode SlipFaultStickingTraction(SlipFault fault, PetscReal t, Vec w, Vec r)
{
  const PetscReal *weight = fault->mesh.weight, eta = fault->balance.eta;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *force, *vinf, *shear = NULL;
  const SlipFaultLoad *load;
  PetscReal *q;
  Vec u, ku;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &ku));
  PetscCall(SlipFaultForce(fault, t, w, u, ku));
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  const SlipArrays arrays[] = {
    {w, .read = &a}, {ku, .read = &force}, {fault->operators.vinf, .read = &vinf}, {r, .write = &q}};

  PetscCall(SlipArraysGet(4, arrays));
  if (load->shear) PetscCall(VecGetArrayRead(load->shear, &shear));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++) {
      const PetscReal rate = a[SlipFaultRateAt(fault, i) + k] - vinf[c * i + k];

      q[c * i + k] = force[c * i + k] + eta * weight[i] * rate - (shear ? shear[c * i + k] : 0);
    }
  if (load->shear) PetscCall(VecRestoreArrayRead(load->shear, &shear));
  PetscCall(SlipArraysRestore(4, arrays));
  PetscCall(SlipFaultRestoreWork(fault, &ku));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For a cell that starts or stops within a step, finds the rate and its square in the middle with which Simpson's rule
   gives the slip and the radiated energy of a rate that changes linearly: rate [c]; *along, its size, which may be
   negative; *square. Returns false for a cell that slides, or rests, all the while. from, to: the states at the ends */
static PetscBool StartsOrStops(SlipFault fault, PetscInt i, const PetscReal from[], const PetscReal to[], PetscReal dt,
                               const PetscReal vinf[], PetscReal rate[], PetscReal *along, PetscReal *square)
{
  const PetscReal before = SlipFaultSpeed(fault, from, i), after = SlipFaultSpeed(fault, to, i),
                  speed = PetscMax(before, after);
  const PetscReal *v = (after > 0 ? to : from) + SlipFaultRateAt(fault, i);
  const PetscInt u = SlipFaultDisplacementAt(fault, i), c = fault->layout.components;
  PetscReal slip = 0;

  if ((before > 0) == (after > 0)) return PETSC_FALSE;
  for (PetscInt k = 0; k < c; k++) slip += v[k] / speed * (to[u + k] - from[u + k] + vinf[c * i + k] * dt);
  *along = 1.5 * slip / dt - 0.25 * speed;
  for (PetscInt k = 0; k < c; k++) rate[k] = v[k] / speed * *along;
  *square = speed * (slip / dt - 0.25 * speed);
  return PETSC_TRUE;
}

/* Does SlipFaultGetPowers(), r being the friction of the state, in one pass. step: the step of which the state is the
   middle, or NULL. */
PetscErrorCode SlipFaultStickingPowers(SlipFault fault, PetscReal t, Vec w, const SlipFaultStickingStep *step,
                                       PetscReal power[3], PetscReal friction[])
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const PetscReal *weight = mesh->weight, *a, *vinf, *from = NULL, *to = NULL, eta = fault->balance.eta;
  const PetscInt c = fault->layout.components;
  PetscReal *value;
  const SlipArrays arrays[] = {{w, .read = &a},
                               {fault->operators.vinf, .read = &vinf},
                               {fault->cells, .write = &value},
                               {step ? step->from : NULL, .read = &from},
                               {step ? step->to : NULL, .read = &to}};
  SlipFrictionCells of;
  PetscBool at_once;

  PetscFunctionBegin;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  PetscCall(PetscArrayzero(power, 3));
  if (friction) PetscCall(PetscArrayzero(friction, mesh->faults));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &of));
  PetscCall(SlipArraysGet(step ? 5 : 3, arrays));
  at_once = of.law->values && !of.known && (c == 1 || !of.law->by_rate) ? PETSC_TRUE : PETSC_FALSE;
  if (at_once)
    of.law->values(&of, mesh->n, fault->layout.block, a + fault->layout.state, fault->layout.block,
                   a + fault->layout.rate, value);
  for (PetscInt i = 0; i < mesh->n; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i);
    PetscReal speed = SlipFaultLength(fault, v), square = speed * speed, along[2], mu, ds, dv, share;

    if (step && StartsOrStops(fault, i, from, to, step->dt, vinf, along, &speed, &square)) v = along;
    for (PetscInt k = 0; k < c; k++) {
      const PetscReal loading = vinf[c * i + k];

      power[0] += eta * weight[i] * loading * (loading - 2 * v[k]);
      power[1] += eta * weight[i] * loading * (v[k] - loading);
    }
    power[0] += eta * weight[i] * square;
    if (speed == 0) continue;
    if (at_once)
      mu = value[i];
    else
      SlipFrictionEvaluate(&of, i, a + SlipFaultStateAt(fault, i), PetscAbsReal(speed), &mu, &ds, &dv);
    share = speed * mu * (weight[i] * of.stress[i]);
    power[2] += share;
    if (friction) friction[SlipFaultMeshFaultOf(mesh, SlipFaultMeshRow(mesh, i))] += share;
  }
  PetscCall(SlipArraysRestore(step ? 5 : 3, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, power, 3, MPIU_REAL, MPIU_SUM, fault->comm));
  if (friction)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, friction, (PetscMPIInt)mesh->faults, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes for each cell the slip rate to which stress and strength drive it [m/s], below 0 where friction holds it. */
PetscErrorCode SlipFaultStickingPush(SlipFault fault, PetscReal t, Vec w, Vec push)
{
  const PetscReal *weight = fault->mesh.weight, eta = fault->balance.eta;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *force, *vinf, *shear = NULL;
  SlipFrictionCells friction;
  const SlipFaultLoad *load;
  PetscReal *b;
  Vec u, ku;

  PetscFunctionBegin;
  SlipWorkCells(fault->mesh.n, fault->layout.components, fault->friction.law->always_slides);
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &ku));
  PetscCall(SlipFaultForce(fault, t, w, u, ku));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  const SlipArrays arrays[] = {
    {w, .read = &a}, {ku, .read = &force}, {fault->operators.vinf, .read = &vinf}, {push, .write = &b}};

  PetscCall(SlipArraysGet(4, arrays));
  if (load->shear) PetscCall(VecGetArrayRead(load->shear, &shear));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal tau[2], mu, ds, dv;

    b[i] = SlipFaultSpeed(fault, a, i);
    if (b[i] > 0) continue;
    for (PetscInt k = 0; k < c; k++)
      tau[k] = (shear ? shear[c * i + k] : 0) - force[c * i + k] + eta * weight[i] * vinf[c * i + k];
    SlipFrictionEvaluate(&friction, i, a + SlipFaultStateAt(fault, i), 0, &mu, &ds, &dv);
    b[i] = (SlipFaultLength(fault, tau) / weight[i] - mu * friction.stress[i]) / eta;
  }
  if (load->shear) PetscCall(VecRestoreArrayRead(load->shear, &shear));
  PetscCall(SlipArraysRestore(4, arrays));
  PetscCall(SlipFaultRestoreWork(fault, &ku));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the end of an event ---- */

/* Sets x to zero in cells that do not slide. */
static PetscErrorCode KeepSliding(SlipFault fault, Vec x)
{
  const PetscInt c = fault->layout.components;
  const PetscReal *v;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(fault->balance.rate, &v));
  PetscCall(VecGetArray(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = c * i; k < c * (i + 1); k++)
      if (SlipFaultLength(fault, v + c * i) == 0) a[k] = 0;
  PetscCall(VecRestoreArray(x, &a));
  PetscCall(VecRestoreArrayRead(fault->balance.rate, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves K x = r for the sliding cells by conjugate gradients to LANDING_SHARE of r, and overwrites r. */
static PetscErrorCode SolveSliding(SlipFault fault, Vec r, Vec x)
{
  PetscReal square, first, next, curvature;
  Vec p, kp;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetWork(fault, &p));
  PetscCall(SlipFaultGetWork(fault, &kp));
  PetscCall(VecZeroEntries(x));
  PetscCall(VecCopy(r, p));
  PetscCall(VecDot(r, r, &square));
  first = square;
  for (PetscInt k = 0; k < LANDING_PRODUCTS && square > PetscSqr(LANDING_SHARE) * first; k++) {
    PetscCall(SlipElasticApply(fault->medium, p, kp, NULL));
    PetscCall(KeepSliding(fault, kp));
    PetscCall(VecDot(p, kp, &curvature));
    if (!(curvature > 0)) break;
    PetscCall(VecAXPY(x, square / curvature, p));
    PetscCall(VecAXPY(r, -square / curvature, kp));
    PetscCall(VecDot(r, r, &next));
    PetscCall(VecAYPX(p, next / square, r));
    square = next;
  }
  PetscCall(SlipFaultRestoreWork(fault, &kp));
  PetscCall(SlipFaultRestoreWork(fault, &p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a slip x to u and s of the state w. */
static PetscErrorCode AddSlip(SlipFault fault, Vec x, Vec w)
{
  const PetscInt c = fault->layout.components;
  const PetscReal *d;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(x, &d));
  PetscCall(VecGetArray(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    for (PetscInt k = 0; k < c; k++) a[SlipFaultDisplacementAt(fault, i) + k] += d[c * i + k];
    a[SlipFaultStateAt(fault, i)] += SlipFaultLength(fault, d + c * i);
  }
  PetscCall(VecRestoreArray(w, &a));
  PetscCall(VecRestoreArrayRead(x, &d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Brings the fault to rest at once, if that is within the tolerance. An event ends by dying away exponentially, for
   ever but for rounding, and long explicit steps do not follow that. The remaining slip relieves the stress by which
   sliding cells exceed their strength: K du = eta v in those, repeated as du weakens them and loads others. The
   function tries this when the largest rate has halved since the last step, as it does not in a nucleation or in steady
   creep, and is so small that the remaining slip is negligible. */
static PetscErrorCode Land(SlipFault fault, PetscReal t, Vec w, PetscBool *landed)
{
  SlipFaultBalance *b = &fault->balance;
  const PetscReal *weight = fault->mesh.weight;
  const PetscInt c = fault->layout.components;
  PetscReal largest = 0, before, *a;
  Vec r, x;

  PetscFunctionBegin;
  *landed = PETSC_FALSE;
  before = b->fastest;
  PetscCall(SlipFaultLargestSpeed(fault, w, &b->fastest));
  if (b->fastest == 0 || !(b->fastest < 0.5 * before)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultLeastStiffness(fault, &largest));
  if (!(b->fastest * b->eta < LANDING_SLIP * b->rtol * b->least * largest)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &r));
  PetscCall(SlipFaultGetWork(fault, &x));
  PetscCall(VecCopy(w, b->rested));
  for (PetscInt k = 0; k < LANDING_SOLVES && !*landed; k++) {
    PetscCall(SlipFaultRates(fault, t, b->rested, NULL));
    PetscCall(VecCopy(b->rate, r));
    PetscCall(SlipVecLargest(r, &largest));
    *landed = largest == 0 ? PETSC_TRUE : PETSC_FALSE;
    if (*landed) break;
    PetscCall(VecGetArray(r, &a));
    for (PetscInt i = 0; i < c * fault->mesh.n; i++) a[i] *= b->eta * weight[i / c];
    PetscCall(VecRestoreArray(r, &a));
    PetscCall(SolveSliding(fault, r, x));
    PetscCall(AddSlip(fault, x, b->rested));
  }
  PetscCall(SlipFaultRestoreWork(fault, &x));
  PetscCall(SlipFaultRestoreWork(fault, &r));
  if (*landed) {
    PetscCall(VecCopy(b->rested, w));
    PetscCall(SlipFaultPutRates(fault, w));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares a step: if all cells rest, it lasts until one of them starts, the loading has a corner or the run ends. Else
   it must end at a corner, which TSRK does not look for. */
PetscErrorCode SlipFaultBeginRest(SlipFault fault, TS ts)
{
  SlipFaultBalance *b = &fault->balance;
  PetscReal t, end, h, limit, corner = PETSC_MAX_REAL;
  PetscBool constant, landed = PETSC_FALSE;
  TSAdapt adapt;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetTimeStep(ts, &h));
  PetscCall(TSGetMaxTime(ts, &limit));
  PetscCall(TSGetSolution(ts, &w));
  if (fault->problem.steps.corner) PetscCall((*fault->problem.steps.corner)(ts, t, &corner, fault));
  limit = PetscMin(limit, corner);
  b->next = h;
  end = t;
  if (fault->problem.steps.rest) {
    if (!b->rested) PetscCall(SlipFaultCreateState(fault, &b->rested));
    if (!b->way) PetscCall(SlipFaultCreateState(fault, &b->way));
    if (fault->kind.sequence || fault->loads.pressed || limit - t > LANDING_FAR * h)
      PetscCall(Land(fault, t, w, &landed));
    PetscCall((*fault->problem.steps.rest)(ts, t, limit, w, b->way, b->rested, &end, &b->next, fault));
  }
  b->resting = end > t ? PETSC_TRUE : PETSC_FALSE;
  if (landed || b->resting) PetscCall(VecDestroy(&b->first)); /* a checkpoint's rates, of the state before */
  if (landed) PetscCall(TSRestartStep(ts));
  if (!b->resting) {
    PetscCall(TSSetTimeStep(ts, PetscMin(h, corner - t)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  if (constant) b->next = h;
  h = end - t;
  if (t + h < end) h = nextafter(h, PETSC_MAX_REAL); /* a step that rounding ends too early would need another one */
  PetscCall(VecWAXPY(b->way, -1, w, b->rested));
  PetscCall(VecScale(b->way, 1 / h));
  PetscCall(TSSetTimeStep(ts, h));
  PetscCall(TSRestartStep(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finishes such a step. */
PetscErrorCode SlipFaultEndRest(SlipFault fault, TS ts)
{
  SlipFaultBalance *b = &fault->balance;
  PetscReal t, end;
  Vec w;

  PetscFunctionBegin;
  b->resting = PETSC_FALSE;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetMaxTime(ts, &end));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(VecCopy(b->rested, w));
  PetscCall(SlipFaultRates(fault, t, w, NULL));
  PetscCall(SlipFaultPutRates(fault, w));
  PetscCall(TSSetTimeStep(ts, end > t ? PetscMin(b->next, end - t) : b->next));
  PetscCall(TSRestartStep(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}
