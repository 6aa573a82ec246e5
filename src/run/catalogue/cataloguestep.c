/* Handles a step of an event: where the largest rate passes the bound in it, when cells pass it, and integrals over it,
   with the states that the integrator has within the step. TSBATHE has one such state, of its first stage. Between
   these three states rates are interpolated as in core/event.c, and every integral has the weights with which the
   integrator forms displacements from slip rates (TSBatheGetQuadrature()). A cheaper rule, such as the two ends alone,
   would reduce the order of the energy balance, or the sign of its error where a stage has stopped a cell. The
   trapezoidal rule integrates the part of the step outside of the event, where every cell is slower than the bound.
   Where cells always slide, displacement and state are smooth within a step, and the rate, an exponential function of
   both, may grow by decades: the mean of the two ends had an error of 30 % for an event. So rates are those of the
   balance of u and s from TSInterpolate(), and halves, quarters and eighths of a step are added until Romberg's rule
   has converged. Each costs a product with K, or none where friction sticks (cataloguewithin.c). */
#include <slipstep/private/sliprunfiles.h>
#include <slipstep/private/slipsys.h>

/* Romberg's rule ends when a halving changes it by less than this share. The remaining error is its power 1.5 over 12,
   1e-3, for rates that grow exponentially (by Simpson 1e-4), which is the integrators' default tolerance. Three
   halvings suffice for growth by e^7. */
#define ROMBERG_ENOUGH 0.05
/* Largest logarithm of the largest rate over the bound at a crossing: its error over the time of growth by e */
#define CROSSING_ENOUGH 1e-4
enum { CROSSING_MOST = 20 };

static void AddWork(SlipFaultCatalogue cat, PetscReal time, const PetscReal power[], PetscReal work[])
{
  for (PetscInt k = 0; k < cat->nwork; k++) work[k] += time * power[k];
}

/* Gets the step that ended in w. */
PetscErrorCode SlipCatalogueGetStep(SlipFaultCatalogue cat, TS ts, PetscReal time, Vec w, SlipEventStep *step)
{
  SlipAttempt attempt;
  PetscBool lapusta, rests, rk;
  PetscInt order;

  PetscFunctionBegin;
  *step = (SlipEventStep){.ts = ts};
  if (!cat->before) {
    PetscCall(TSBatheGetLastAttempt(ts, &attempt));
    step->begin = attempt.time;
    step->dt = attempt.dt;
    step->nodes = 3;
    PetscCall(TSBatheGetQuadrature(ts, step->share, step->weight, step->node));
    step->node[2] = w;
    step->simpson = attempt.method == TSBATHE_METHOD_EXPLICIT && attempt.solves == 1 && !cat->fault->kind.inertia
                      ? PETSC_TRUE
                      : PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  step->begin = cat->time_before;
  step->dt = time - cat->time_before;
  step->nodes = 2;
  step->share[1] = 1;
  step->node[0] = cat->before;
  step->node[1] = w;
  /* TSInterpolate() follows the solution with TSADAMS and TSRKC, but of TSRK's pairs only with 5dp: the others use a
     straight line */
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, &step->dense, TSADAMS, TSBATHE, TSMOREAU, TSRKC, ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSRK, &rk));
  if (rk) {
    PetscCall(TSRKGetTableau(ts, NULL, NULL, NULL, NULL, NULL, &order, NULL, NULL));
    step->dense = order >= 3 ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscCall(SlipLapustaIsStraight(ts, &lapusta, &step->straight));
  if (lapusta && !step->straight) step->dense = PETSC_TRUE;
  PetscCall(SlipElasticRests(cat->fault->medium, &rests));
  step->sticks = rests && !step->straight && !cat->fault->friction.law->nstates ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A crossing before this share of a step is at its start */
static const PetscReal at_once = 1e-12;

/* ---- where the rate passes the bound ---- */

/* Returns the rate of cell i for a crossing: signed for one component, the magnitude for two. */
static PetscReal EventRate(SlipFault fault, const PetscReal a[], PetscInt i)
{
  return fault->layout.components == 1 ? a[SlipFaultRateAt(fault, i)] : SlipFaultSpeed(fault, a, i);
}

/* Finds the least share of the way from slow, where no such cell exceeds the rate, to fast, after which a cell does. */
static PetscErrorCode FirstCrossing(SlipFaultCatalogue cat, Vec slow, Vec fast, PetscReal *share)
{
  SlipFault fault = cat->fault;
  const PetscReal rate = fault->options.value[FAULT_EVENT_RATE];
  const PetscReal *a, *b;
  const SlipArrays arrays[] = {{slow, .read = &a}, {fast, .read = &b}};

  PetscFunctionBegin;
  *share = 1;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if (SlipFaultSpeed(fault, b, i) > rate)
      *share = PetscMin(*share, SlipEventCrossing(EventRate(fault, a, i), EventRate(fault, b, i), rate));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, share, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the rate at a share of the way. For two components the magnitude is interpolated like a rate of one, and the
   direction is between those of the ends. */
static void RateBetween(SlipFault fault, const PetscReal from[], const PetscReal to[], PetscReal share, PetscReal v[])
{
  PetscReal size, length;

  if (fault->layout.components == 1) {
    v[0] = SlipEventRate(from[0], to[0], share);
    return;
  }
  for (PetscInt k = 0; k < fault->layout.components; k++) v[k] = (1 - share) * from[k] + share * to[k];
  length = SlipFaultLength(fault, v);
  size = SlipEventRate(SlipFaultLength(fault, from), SlipFaultLength(fault, to), share);
  for (int k = 0; k < 2 && length > 0; k++) v[k] *= size / length;
}

/* Computes the state at a share of the way from slow to fast, dt away from slow, negative when it is earlier. The
   displacements follow the mean of the two rates, starting from the end where they are small. */
static PetscErrorCode Cut(SlipFaultCatalogue cat, Vec slow, Vec fast, PetscReal share, PetscReal dt)
{
  SlipFault fault = cat->fault;
  const PetscReal *a, *b, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  PetscReal *c;
  const SlipArrays arrays[] = {{slow, .read = &a}, {fast, .read = &b}, {cat->cut, .write = &c}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *from = a + SlipFaultRateAt(fault, i), *to = b + SlipFaultRateAt(fault, i);
    PetscReal *v = c + SlipFaultRateAt(fault, i);

    RateBetween(fault, from, to, share, v);
    for (PetscInt k = 0; k < fault->layout.components; k++)
      c[SlipFaultDisplacementAt(fault, i) + k] = a[SlipFaultDisplacementAt(fault, i) + k] +
                                                 dt * (0.5 * (from[k] + v[k]) - vinf[i] * SlipFaultAlong(fault, i)[k]);
    for (PetscInt k = SlipFaultStateAt(fault, i); k < SlipFaultStateAt(fault, i) + fault->layout.states; k++)
      c[k] = fault->friction.law->nstates
               ? a[k] + share * (b[k] - a[k])
               : a[k] + dt * 0.5 * (SlipFaultLength(fault, from) + SlipFaultLength(fault, v));
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns where the largest rate passes the bound in a step without inertia that ends at rest. Stress then decays
   exponentially, and the length of the step, in which slip has become negligible, has no relation to it. The decay of
   the step before is continued. */
static PetscReal DiesAway(SlipFaultCatalogue cat, const SlipEventStep *step)
{
  const SlipFaultEvent *e = &cat->event;
  const PetscReal rate = cat->fault->options.value[FAULT_EVENT_RATE];

  if (e->steps < 2 || !(e->rate[0] > e->rate[1])) return 1;
  return PetscMin(1, (e->time[1] - e->time[0]) * PetscLogReal(e->rate[1] / rate) /
                       PetscLogReal(e->rate[0] / e->rate[1]) / step->dt);
}

/* Finds the crossing for TSBATHE, between two of the three states. The state of a backward first stage has only first
   order: where both ends move it is not used, and the logarithm of what grows or decays exponentially is linear between
   them. */
static PetscErrorCode CrossNodes(SlipFaultCatalogue cat, SlipEventStep *step)
{
  const PetscReal rate = cat->fault->options.value[FAULT_EVENT_RATE];
  const PetscBool onset = step->side < 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscReal max[3], share, dt;
  PetscInt slow = onset ? 0 : 2, fast = 1;
  TSBatheFirstStage rule;
  PetscBool crude;

  PetscFunctionBegin;
  PetscCall(TSBatheGetFirstStage(step->ts, &rule));
  for (PetscInt k = 0; k < 3; k++) PetscCall(SlipFaultLargestSpeed(cat->fault, step->node[k], &max[k]));
  crude = rule == TSBATHE_STAGE_BACKWARD && !step->simpson && (!onset || max[0] > 0) ? PETSC_TRUE : PETSC_FALSE;
  if (crude)
    fast = onset ? 2 : 0;
  else if (max[1] <= rate) {
    slow = 1;
    fast = onset ? 2 : 0;
  }
  if (crude && max[2] == 0 && !cat->fault->kind.inertia)
    share = 1 - DiesAway(cat, step);
  else
    PetscCall(FirstCrossing(cat, step->node[slow], step->node[fast], &share));
  dt = (step->share[fast] - step->share[slow]) * step->dt;
  PetscCall(Cut(cat, step->node[slow], step->node[fast], share, share * dt));
  step->slow = slow;
  step->cut = step->share[slow] + share * dt / step->dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the crossing of a smooth solution, the zero of the logarithm of the largest rate over the bound, by the regula
   falsi of Illinois. Where rates grow exponentially, the first guess is exact. */
static PetscErrorCode CrossWithin(SlipFaultCatalogue cat, SlipEventStep *step)
{
  const PetscReal rate = cat->fault->options.value[FAULT_EVENT_RATE];
  PetscReal x[2] = {0, 1}, y[2], max;
  PetscInt last = -1;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(SlipFaultLargestSpeed(cat->fault, step->node[k], &max));
    y[k] = PetscLogReal(PetscMax(max, PETSC_SMALL * rate) / rate);
  }
  for (PetscInt it = 0; it < CROSSING_MOST; it++) {
    PetscReal value;
    PetscInt side;

    step->cut = (x[0] * y[1] - x[1] * y[0]) / (y[1] - y[0]);
    PetscCall(SlipCatalogueStateWithin(cat, step, step->cut, cat->cut, NULL));
    PetscCall(SlipFaultLargestSpeed(cat->fault, cat->cut, &max));
    value = PetscLogReal(PetscMax(max, PETSC_SMALL * rate) / rate);
    if (PetscAbsReal(value) < CROSSING_ENOUGH) break;
    side = (value > 0) == (y[0] > 0) ? 0 : 1;
    if (side == last) y[1 - side] *= 0.5;
    x[side] = step->cut;
    y[side] = value;
    last = side;
  }
  if (step->cut < at_once) step->cut = 0; /* with friction that sticks, slip may exceed the bound from its start on */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds where the largest rate passes the bound: upwards, where an event begins in the step, or downwards. The state
   there is in cat->cut. */
PetscErrorCode SlipCatalogueCross(SlipFaultCatalogue cat, SlipEventStep *step, PetscBool upwards)
{
  PetscFunctionBegin;
  step->side = upwards ? -1 : 1;
  PetscCall(cat->before ? CrossWithin(cat, step) : CrossNodes(cat, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks cells that exceed the rate at the end of a step for the first time in this event, with the time. */
PetscErrorCode SlipCatalogueMarkRuptured(SlipFaultCatalogue cat, const SlipEventStep *step)
{
  SlipFault fault = cat->fault;
  const PetscReal begin = step->begin - cat->event.onset;
  const int nodes = (int)step->nodes;
  PetscBool unbroken = PETSC_FALSE;

  PetscFunctionBegin;
  if (step->sticks && !cat->unbroken) PetscFunctionReturn(PETSC_SUCCESS);
  if (step->sticks && !cat->push_known) {
    if (!cat->push) PetscCall(VecDuplicate(cat->rupture, &cat->push));
    PetscCall(SlipFaultStickingPush(fault, step->begin, cat->before, cat->push));
  }
  PetscCall((*fault->cell_ops->rupture)(fault, step->nodes, step->node, step->share, begin, step->dt,
                                        step->sticks ? cat->push : NULL, cat->rupture, &unbroken));
  if (step->sticks) {
    PetscCallMPI(MPI_Allreduce(&unbroken, &cat->unbroken, 1, MPIU_BOOL, MPI_LOR, fault->comm));
    cat->push_known = cat->unbroken;
  }
  if (cat->push_known)
    PetscCall(SlipFaultStickingPush(fault, step->begin + step->dt, step->node[nodes - 1], cat->push));
  PetscCall(SlipCatalogueHypocentres(cat, step->dt, step->node[nodes - 1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- integrals ---- */

/* Adds the energy that cells lose which close within the step: with inertia that of their opening, M v_n^2/2 [J], with
   the rate at its start. */
static PetscErrorCode AddImpacts(SlipFaultCatalogue cat, const SlipEventStep *step, PetscReal work[])
{
  SlipFault fault = cat->fault;
  const PetscReal *a, *b;
  const SlipArrays arrays[] = {{step->node[0], .read = &a}, {step->node[step->nodes - 1], .read = &b}};
  PetscReal lost = 0;

  PetscFunctionBegin;
  if (!SlipFaultOpens(fault) || !fault->kind.inertia) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt opening = SlipFaultDisplacementAt(fault, i) + 2;

    if (a[opening] > 0 && b[opening] == 0)
      lost += 0.5 * fault->operators.mass * fault->mesh.weight[i] * PetscSqr(a[SlipFaultRateAt(fault, i) + 2]);
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &lost, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  work[WORK_DISSIPATED] += fault->mesh.area * lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Integrates for TSBATHE. The whole step has its weights. The slow part uses the integrator's rules of its stages, from
   its end over the state of the first stage, where that is slow too, and a trapezoid to the crossing, as the
   displacement there does. */
static PetscErrorCode IntegrateNodes(SlipFaultCatalogue cat, const SlipEventStep *step, PetscReal fast[],
                                     PetscReal slow[])
{
  PetscReal *power[] = {cat->power, cat->inner, cat->next};

  PetscFunctionBegin;
  for (PetscInt k = cat->power_known ? 1 : 0; k < 3; k++)
    if (k == 1 && step->simpson)
      PetscCall(SlipCatalogueMiddlePowers(cat, step, step->node[k], power[k]));
    else
      PetscCall(SlipCataloguePowers(cat, step->begin + step->share[k] * step->dt, step->node[k], power[k]));
  for (PetscInt k = 0; k < 3; k++) AddWork(cat, step->dt * step->weight[k], power[k], fast);
  PetscCall(AddImpacts(cat, step, fast));
  if (step->side) {
    const PetscReal part = PetscAbsReal(step->cut - step->share[step->slow]) * step->dt;

    PetscCall(SlipCataloguePowers(cat, step->begin + step->cut * step->dt, cat->cut, cat->cut_power));
    if (step->slow == 1) {
      const PetscReal sign = step->side < 0 ? 1 : -1, stage = sign * step->share[1] * step->dt;
      PetscReal backward; /* share of the stage's state in its rule */
      TSBatheFirstStage rule;

      PetscCall(TSBatheGetFirstStage(step->ts, &rule));
      if (step->side > 0) AddWork(cat, 1, fast, slow);
      backward = rule == TSBATHE_STAGE_BACKWARD && !step->simpson ? 1 : 0.5;
      AddWork(cat, (1 - backward) * stage, power[0], slow);
      AddWork(cat, backward * stage, power[1], slow);
    }
    AddWork(cat, 0.5 * part, power[step->slow], slow);
    AddWork(cat, 0.5 * part, cat->cut_power, slow);
    AddWork(cat, -1, slow, fast);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Applies Romberg's rule from one share to another, whose powers are given; in straight steps the trapezoidal rule, and
   where friction sticks Simpson's. middle: gets the state in between */
static PetscErrorCode Romberg(SlipFaultCatalogue cat, SlipEventStep *step, const PetscReal share[2],
                              const PetscReal *const power[2], Vec middle, PetscReal work[])
{
  const PetscReal whole = (share[1] - share[0]) * step->dt;
  const PetscInt n = cat->nwork, most = step->sticks && !step->side ? 1 : SLIP_EVENT_HALVINGS;
  PetscReal *row = cat->romberg; /* [SLIP_EVENT_HALVINGS + 1][n], of the last halving, from the trapezoidal rule on */
  PetscReal change = 1, size = 0;
  PetscInt halvings = 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < n; k++) row[k] = 0.5 * whole * (power[0][k] + power[1][k]);
  if (step->straight) {
    PetscCall(SlipCatalogueStateWithin(cat, step, 0.5 * (share[0] + share[1]), middle, NULL));
    AddWork(cat, 1, row, work);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt m = 1; m <= most && change > ROMBERG_ENOUGH * size; m++) {
    const PetscInt parts = 1 << (m - 1);

    PetscCall(PetscArrayzero(cat->sum, n)); /* the trapezoidal rule of halved parts */
    AddWork(cat, 0.5, row, cat->sum);
    for (PetscInt j = 0; j < parts; j++) {
      const PetscReal at = share[0] + (share[1] - share[0]) * ((PetscReal)j + 0.5) / (PetscReal)parts;

      PetscCall(SlipCatalogueStateWithin(cat, step, at, m == 1 ? middle : cat->within, cat->inner));
      AddWork(cat, 0.5 * whole / (PetscReal)parts, cat->inner, cat->sum);
    }
    change = size = 0;
    for (PetscInt k = 0; k < n; k++) {
      PetscReal better = cat->sum[k], power4 = 1;
      const PetscReal best = row[(m - 1) * n + k];

      for (PetscInt j = 0; j <= m; j++) {
        const PetscReal older = row[j * n + k];

        row[j * n + k] = better;
        power4 *= 4;
        if (j < m) better += (better - older) / (power4 - 1);
      }
      if (k >= FAULT_NUM_WORKS) continue;
      change += PetscAbsReal(row[m * n + k] - best);
      size += PetscAbsReal(row[m * n + k]);
    }
    halvings = m;
  }
  AddWork(cat, 1, row + halvings * n, work);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode IntegrateWithin(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal fast[], PetscReal slow[])
{
  const PetscReal cut[] = {0, step->cut, 1};
  const PetscReal *const power[] = {cat->power, cat->cut_power, cat->next};

  PetscFunctionBegin;
  if (step->side >= 0 && !cat->power_known) PetscCall(SlipCataloguePowers(cat, step->begin, step->node[0], cat->power));
  PetscCall(SlipCataloguePowers(cat, step->begin + step->dt, step->node[1], cat->next));
  if (step->side) PetscCall(SlipCataloguePowers(cat, step->begin + step->cut * step->dt, cat->cut, cat->cut_power));
  if (step->side > 0) {
    PetscCall(Romberg(cat, step, cut, power, cat->middle, fast));
    PetscCall(Romberg(cat, step, cut + 1, power + 1, cat->middle, slow));
  } else {
    const PetscReal begin = step->side ? step->cut : 0, both[] = {begin, 1};
    const PetscInt last = step->nodes;
    const PetscReal *const ends[] = {step->side ? cat->cut_power : cat->power, cat->next};

    PetscCall(Romberg(cat, step, both, ends, cat->middle, fast));
    step->share[last] = step->share[last - 1];
    step->node[last] = step->node[last - 1];
    step->share[last - 1] = 0.5 * (begin + 1); /* a new node before the last one */
    step->node[last - 1] = cat->middle;
    step->nodes++;
    if (!step->side) PetscFunctionReturn(PETSC_SUCCESS);
    step->share[0] = begin;
    step->node[0] = cat->cut;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the integrals [nwork] over the part of a step that belongs to the event, and over the other part where its
   event ends. */
PetscErrorCode SlipCatalogueIntegrate(SlipFaultCatalogue cat, SlipEventStep *step, PetscReal fast[], PetscReal slow[])
{
  PetscFunctionBegin;
  PetscCall(PetscArrayzero(fast, cat->nwork));
  PetscCall(PetscArrayzero(slow, cat->nwork));
  PetscCall(cat->before ? IntegrateWithin(cat, step, fast, slow) : IntegrateNodes(cat, step, fast, slow));
  PetscCall(PetscArraycpy(cat->power, cat->next, cat->nwork));
  cat->power_known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
