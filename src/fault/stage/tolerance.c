/* How large the local error of a step may be, for faults that rest and creep for years between events.

   What such runs are about are the times and the slips of events. A slip is right when it is so against d_c, in which
   strength changes; a slip rate against the largest one of the fault now. Each cell counts by itself, as an event
   begins in a few of them. While all is slow, rates do not count: they jump whenever a cell joins or leaves those that
   slide, within the time that inertia or radiation take for one cell, in which a slow slip is no slip at all.

   With inertia a rate lasts, and its error is that of the slip which it leads to: times the time in which the cell
   would swing, against d_c. Relative to the rate itself it would be too loose while an event slips, and too tight while
   the cell creeps, where long steps do not follow the swing.

   A cell of constant friction has no d_c: its strength does not fall with slip, nothing there is unstable, and without
   inertia stages that end in balance are exact whatever the step while slip goes on in one direction. Its slip is right
   when it is so against the largest displacement of the fault so far, the only slip that such a run knows of. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>

/* Wanted errors in units of the relative tolerance: of the slip and the state over d_c, of the slip rate over the
   largest one, which the next steps forget unless it grows, and of the slip that a rate leads to, which they keep */
static const PetscReal of_slip = 1, of_rate = 10, of_swing = 0.05;
/* What a step of second order leaves of a strength that falls with slip, likewise: the slip over d_c, cubed, times the
   share of the weakening rate that the cell still has; whatever the embedded estimate sees of it in cells that begin or
   cease to slip within the step. */
static const PetscReal of_cube = 0.5;

/* The slip against which that of a cell counts [m]. *weakens: it is d_c, else the largest displacement */
PetscReal SlipFaultSlipScale(SlipFault fault, const SlipFrictionCells *friction, PetscInt i, PetscReal displacement,
                             PetscBool *weakens)
{
  *weakens = SlipFrictionExcess(friction, i, NULL, 0) > 0 ? PETSC_TRUE : PETSC_FALSE;
  return *weakens ? fault->fields.cell[FIELD_FRICTION_SLIP][i] : displacement;
}

/* Size of what opens a cell, of a state or an error from its displacement on; 0 where cells do not open */
static PetscReal Opening(SlipFault fault, const PetscReal u[])
{
  return PetscAbsReal(SlipFaultAcross(fault, u));
}

/* The largest |u| or opening of a state [m]; SLIP_FAULT_ATOL: it has not moved. Collective. */
PetscErrorCode SlipFaultLargestDisplacement(SlipFault fault, Vec w, PetscReal *largest)
{
  const PetscReal *a;

  PetscFunctionBegin;
  *largest = SLIP_FAULT_ATOL;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    *largest = PetscMax(PetscMax(*largest, SlipFaultDistance(fault, a, i)),
                        Opening(fault, a + SlipFaultDisplacementAt(fault, i)));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without inertia the rate is what the balance makes of the slip, and changes with it at once: its error is that of the
   slip times K/(H + theta K) of the cell. K/H would do for short steps; in long ones the next stage takes most of such
   an error away again. slow: the least of the cells' rates d_c over the time that inertia or radiation take. swing: of
   cells with inertia that weaken with slip, which largest leaves out, the error over the wanted one. */
static PetscErrorCode RateError(SlipFault fault, PetscReal rtol, PetscReal tolerance, const SlipFrictionCells *friction,
                                PetscReal displacement, Vec e, PetscReal *largest, PetscReal *slow, PetscReal *swing)
{
  const PetscBool lasts = (PetscBool)(fault->kind.inertia && !fault->friction.law->by_rate);
  const PetscReal *a, *k, *viscosity;
  Vec diagonal[2];

  PetscFunctionBegin;
  PetscCall(SlipElasticGetDiagonals(fault->medium, &diagonal[0], &diagonal[1]));
  const SlipArrays arrays[] = {{e, .read = &a}, {diagonal[0], .read = &k}, {diagonal[1], .read = &viscosity}};

  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscBool weakens;
    const PetscReal stiffness = SlipFaultLargest(fault, k, i), damping = SlipFaultLargest(fault, viscosity, i);
    const PetscReal times = fault->kind.inertia
                              ? PetscSqrtReal(stiffness / (fault->operators.mass * fault->mesh.weight[i]))
                              : stiffness / damping;
    const PetscReal scale = SlipFaultSlipScale(fault, friction, i, displacement, &weakens) * times;
    PetscReal error = SlipFaultSpeed(fault, a, i);

    *slow = PetscMin(*slow, scale);
    if (lasts && weakens) {
      error /= of_swing * rtol * scale + tolerance;
      *swing = SlipLarger(*swing, error);
      continue;
    }
    if (!fault->kind.inertia)
      error = SlipLarger(SlipFaultDistance(fault, a, i), SlipFaultStateSize(fault, a, i)) *
              (stiffness / (damping + fault->stage.theta * stiffness));
    *largest = SlipLarger(*largest, error);
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rate of weakening with slip of cell i, which weakens, in the state s, over the friction drop by d_c: at most 1 */
static PetscReal Weakening(const SlipFrictionCells *friction, PetscInt i, const PetscReal s[])
{
  PetscReal mu, ds, dv;

  SlipFrictionEvaluate(friction, i, s, 0, &mu, &ds, &dv);
  return PetscMin(1, -ds * friction->slip[i] / friction->drop[i]);
}

/* Of a smooth law: a slip counts against d_c, the state, a logarithm, and with inertia the slip rate against itself by
   the same share, as each then changes the friction by as much. Without inertia the rate is what the balance makes of
   the others. */
static PetscErrorCode SmoothErrorNorm(SlipFault fault, PetscReal rtol, Vec e, Vec w0, Vec w1, PetscReal *E)
{
  const PetscReal *a, *b, *c, *vinf = fault->fields.cell[FIELD_LOADING_RATE],
                              *slip = fault->fields.cell[FIELD_FRICTION_SLIP];
  const SlipArrays arrays[] = {{e, .read = &a}, {w0, .read = &b}, {w1, .read = &c}};
  PetscReal largest = 0;

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal rate =
      PetscMax(PetscMax(SlipFaultSpeed(fault, b, i), SlipFaultSpeed(fault, c, i)), PetscAbsReal(vinf[i]));
    PetscReal error = SlipLarger(SlipFaultDistance(fault, a, i) / slip[i], SlipFaultStateSize(fault, a, i));

    if (fault->kind.inertia && rate > 0) error = SlipLarger(error, SlipFaultSpeed(fault, a, i) / rate);
    largest = SlipLarger(largest, error);
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscCall(SlipAllreduceLargest(fault->comm, 1, &largest));
  *E = largest / rtol;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFaultErrorNorm - the largest of the cells' errors over the wanted ones

  Collective. e: local error of a step h from w0 to w1, the state of the time t.
*/
PetscErrorCode SlipFaultErrorNorm(SlipFault fault, PetscReal rtol, PetscReal t, PetscReal h, Vec e, Vec w0, Vec w1,
                                  PetscReal *E)
{
  const PetscReal *a, *b, *c, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  PetscReal largest[6] = {0, 0, 0, 0, 0, 0}; /* error of slips over d_c, of rates, rate, cubes, minus slow, swing */
  PetscReal slow = PETSC_MAX_REAL, tolerance = 0, wanted, displacement, swing;
  const SlipArrays arrays[] = {{e, .read = &a}, {w0, .read = &b}, {w1, .read = &c}};
  SlipFrictionCells friction;

  PetscFunctionBegin;
  if (fault->friction.law->always_slides) {
    PetscCall(SmoothErrorNorm(fault, rtol, e, w0, w1, E));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!PetscIsNanReal(fault->options.value[FAULT_RATE_TOLERANCE]))
    tolerance = fault->options.value[FAULT_RATE_TOLERANCE];
  PetscCall(SlipFaultGetFrictionOf(fault, t, w1, &friction));
  PetscCall(SlipFaultLargestDisplacement(fault, w1, &displacement));
  PetscCall(RateError(fault, rtol, tolerance, &friction, displacement, e, &largest[1], &slow, &largest[5]));
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal error =
      SlipLarger(SlipLarger(SlipFaultDistance(fault, a, i), Opening(fault, a + SlipFaultDisplacementAt(fault, i))),
                 SlipFaultStateSize(fault, a, i));
    const PetscReal rate = PetscMax(SlipFaultSpeed(fault, b, i), SlipFaultSpeed(fault, c, i));

    PetscBool weakens;
    const PetscReal slip = SlipFaultSlipScale(fault, &friction, i, displacement, &weakens);
    PetscReal way[3] = {0, 0, 0}, moved;

    for (PetscInt k = 0; k < fault->layout.components; k++)
      way[k] = c[SlipFaultDisplacementAt(fault, i) + k] - b[SlipFaultDisplacementAt(fault, i) + k] +
               h * (vinf[i] * SlipFaultAlong(fault, i)[k]);
    moved = SlipFaultLength(fault, way) / slip;

    largest[0] = SlipLarger(largest[0], error / slip);
    if (weakens)
      largest[3] =
        PetscMax(largest[3], Weakening(&friction, i, b + SlipFaultStateAt(fault, i)) * PetscPowRealInt(moved, 3));
    largest[2] = PetscMax(largest[2], PetscMax(rate, PetscAbsReal(vinf[i])));
  }
  PetscCall(SlipArraysRestore(3, arrays));
  largest[4] = -slow;
  PetscCall(SlipAllreduceLargest(fault->comm, 6, largest));
  wanted = of_rate * rtol * (largest[2] - rtol * largest[4]) + tolerance;
  *E = SlipLarger(SlipLarger(largest[0] / (of_slip * rtol), largest[3] / (of_cube * rtol)), largest[5]);
  if (wanted > 0) *E = SlipLarger(*E, largest[1] / wanted);
  PetscCall(SlipFaultRunaway(fault, t, w1, &swing));
  *E = SlipLarger(*E, PetscPowRealInt(swing, 3));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does stress change with time, so that one event follows another? */
static PetscBool IsLoaded(SlipFault fault)
{
  return fault->kind.sequence || fault->loads.pressed ? PETSC_TRUE : PETSC_FALSE;
}

/* Share of the largest displacement against which slips count as a rupture begins */
static const PetscReal of_displacement = 0.1;

/* Likewise in explicit steps without inertia. As the only rupture of a run begins, what is wrong with its slip grows
   with it, and makes it earlier or later: slips count against the displacement so far as long as that is of the order
   of d_c. */
PetscReal SlipFaultStickingScale(SlipFault fault, PetscReal scale, PetscBool weakens, PetscReal displacement)
{
  return weakens && !IsLoaded(fault) ? PetscMin(scale, of_displacement * displacement) : scale;
}

/*
  SlipFaultStickingErrorNorm - likewise, of an explicit step without inertia that ended in w1 at the last right-hand
  side

  Collective. Formulas of higher order that average no stop need no more than the first two of these errors, of slips
  and, of faults that are loaded, of the rates that follow from them: by those a later nucleation counts against itself,
  long before its slip does.
*/
PetscErrorCode SlipFaultStickingErrorNorm(SlipFault fault, PetscReal rtol, PetscReal theta, Vec e, Vec w0, Vec w1,
                                          PetscReal *E)
{
  const PetscReal *a, *b, *v, *k, *viscosity, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  PetscReal largest[4] = {0, 0, 0, -PETSC_MAX_REAL}; /* errors of slips, of rates, rate, minus the slowest of them */
  PetscReal displacement, wanted;
  SlipFrictionCells friction;
  Vec diagonal[2];

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction)); /* of which no stress is asked for */
  PetscCall(SlipFaultLargestDisplacement(fault, w1, &displacement));
  PetscCall(SlipElasticGetDiagonals(fault->medium, &diagonal[0], &diagonal[1]));
  const SlipArrays arrays[] = {{e, .read = &a},
                               {w0, .read = &b},
                               {fault->balance.rate, .read = &v},
                               {diagonal[0], .read = &k},
                               {diagonal[1], .read = &viscosity}};

  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscBool weakens;
    const PetscReal all = SlipFaultSlipScale(fault, &friction, i, displacement, &weakens);
    const PetscReal scale = SlipFaultStickingScale(fault, all, weakens, displacement);
    const PetscReal stiffness = SlipFaultLargest(fault, k, i), damping = SlipFaultLargest(fault, viscosity, i);
    const PetscReal times = stiffness / damping;
    const PetscReal error = SlipLarger(SlipFaultDistance(fault, a, i), SlipFaultStateSize(fault, a, i));
    const PetscReal rate =
      PetscMax(SlipFaultSpeed(fault, b, i), SlipFaultLength(fault, v + fault->layout.components * i));

    largest[0] = SlipLarger(largest[0], error / scale);
    largest[1] = SlipLarger(largest[1], error * (stiffness / (damping + theta * stiffness)));
    largest[2] = PetscMax(largest[2], PetscMax(rate, PetscAbsReal(vinf[i])));
    largest[3] = PetscMax(largest[3], -scale * times);
  }
  PetscCall(SlipArraysRestore(5, arrays));
  PetscCall(SlipAllreduceLargest(fault->comm, 4, largest));
  wanted = of_rate * rtol * (largest[2] - rtol * largest[3]);
  *E = largest[0] / (of_slip * rtol);
  if (IsLoaded(fault)) *E = SlipLarger(*E, largest[1] / wanted);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* K u.u of the fault that slips as a whole, over its area [Pa/m]: no other slip costs less stress, but for its shape */
PetscErrorCode SlipFaultLeastStiffness(SlipFault fault, PetscReal *stiffness)
{
  Vec u, ku;

  PetscFunctionBegin;
  if (fault->loads.soft == 0) {
    PetscCall(SlipFaultGetWork(fault, &u));
    PetscCall(SlipFaultGetWork(fault, &ku));
    PetscCall(SlipFaultFillAlong(fault, NULL, PETSC_FALSE, u));
    PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
    PetscCall(SlipElasticApply(fault->medium, u, ku, NULL));
    PetscCall(SlipProductsPop());
    PetscCall(VecDot(u, ku, &fault->loads.soft));
    PetscCall(SlipFaultRestoreWork(fault, &ku));
    PetscCall(SlipFaultRestoreWork(fault, &u));
    fault->loads.soft /= (PetscReal)fault->mesh.N;
  }
  *stiffness = fault->loads.soft;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFaultLoadTolerance - what the pressure of the cells may be off by [n] [Pa]

  Collective. Stress that is worth a slip of relative times d_c, or times the largest displacement so far where that is
  less: a history is to be right before slip is as large as d_c, too. A smooth law answers to a stress of a sigma by e
  times the rate.
*/
PetscErrorCode SlipFaultLoadTolerance(SlipFault fault, PetscReal relative, PetscReal t, Vec w, PetscReal tolerance[])
{
  const PetscBool smooth = fault->friction.law->always_slides;
  PetscReal stiffness = 0, displacement;
  SlipFrictionCells friction;
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(SlipFaultLeastStiffness(fault, &stiffness));
  PetscCall(SlipFaultLargestDisplacement(fault, w, &displacement));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal mu, ds, dv, stress;
    PetscBool weakens;

    SlipFrictionEvaluate(&friction, i, a + SlipFaultStateAt(fault, i), SlipFaultSpeed(fault, a, i), &mu, &ds, &dv);
    stress = stiffness * PetscMin(displacement, SlipFaultSlipScale(fault, &friction, i, displacement, &weakens));
    if (smooth)
      stress = PetscMin(stiffness * fault->fields.cell[FIELD_FRICTION_SLIP][i],
                        fault->fields.cell[FIELD_FRICTION_A][i] * friction.stress[i]);
    if (SlipFaultOpens(fault)) mu = PetscMax(mu, 1);
    tolerance[i] = relative * stress / PetscMax(mu, PETSC_SMALL);
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}
