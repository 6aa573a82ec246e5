/* Limits the local error of a step on faults that rest and creep for years between events.

   The results of such runs are the times and the slips of events. The error of a slip is measured against d_c, over
   which strength changes, and that of a slip rate against the fault's largest rate now. Each cell counts by itself, as
   an event begins in a few of them. While all is slow, rates do not count: they jump whenever a cell starts or stops
   sliding, within the time that inertia or radiation take for one cell, in which a slow slip is negligible.

   With inertia a rate lasts, and its error is that of the slip which it leads to: the rate times the time in which the
   cell would swing, against d_c. Relative to the rate itself the limit would be too loose while an event slips, and too
   tight while the cell creeps, where long steps do not follow the swing.

   A cell of constant friction has no d_c: its strength does not fall with slip, so that nothing there is unstable.
   Without inertia, stages that end in balance are exact at any length while slip goes on in one direction. Its slip is
   measured against the largest displacement of the fault so far, the only slip that such a run can compare it with. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>

/* Wanted errors over the relative tolerance: of the slip and the state over d_c, of the slip rate over the largest one,
   which later steps correct unless it grows, and of the slip that a rate leads to, which they do not correct. */
static const PetscReal of_slip = 1, of_rate = 10, of_swing = 0.05;
/* Likewise, the error of a second-order step where strength falls with slip: the slip over d_c, cubed, times the share
   of the weakening rate that the cell still has. It does not depend on the embedded estimate, which may miss cells that
   begin or cease to slip within the step. */
static const PetscReal of_cube = 0.5;

/* Returns the slip against which the error of a cell is measured [m]: d_c where the cell weakens, else displacement. */
PetscReal SlipFaultSlipScale(SlipFault fault, const SlipFrictionCells *friction, PetscInt i, PetscReal displacement,
                             PetscBool *weakens)
{
  *weakens = SlipFrictionExcess(friction, i, NULL, 0) > 0 ? PETSC_TRUE : PETSC_FALSE;
  return *weakens ? fault->fields.cell[FIELD_FRICTION_SLIP][i] : displacement;
}

/* Returns the size of the opening in a state or an error, from its displacement on; 0 where cells do not open. */
static PetscReal Opening(SlipFault fault, const PetscReal u[])
{
  return PetscAbsReal(SlipFaultAcross(fault, u));
}

/* Finds the largest |u| or opening of a state [m]; SLIP_FAULT_ATOL means no motion yet. Collective. */
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

/* Without inertia the balance gives the rate from the slip at once: its error is that of the slip times K/(H + theta K)
   of the cell. K/H would do for short steps; after long ones the next stage removes most of such an error. slow: the
   least of the cells' rates d_c over the time that inertia or radiation take. swing: for cells with inertia that weaken
   with slip, which are not in largest, the error over the wanted one. */
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

/* Returns the rate of weakening with slip of cell i in the state s, over the friction drop by d_c: at most 1. */
static PetscReal Weakening(const SlipFrictionCells *friction, PetscInt i, const PetscReal s[])
{
  PetscReal mu, ds, dv;

  SlipFrictionEvaluate(friction, i, s, 0, &mu, &ds, &dv);
  return PetscMin(1, -ds * friction->slip[i] / friction->drop[i]);
}

/* Norm for a smooth law. The slip is measured against d_c, and the state, a logarithm, by the same share; with inertia
   also the slip rate against itself: equal shares change the friction equally. Without inertia the balance gives the
   rate. */
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
  SlipFaultErrorNorm - finds the largest ratio of a cell's error to the wanted one

  Collective. e: local error of a step h from w0 to w1; w1: the state at the time t.
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

/* Returns whether stress changes with time, so that one event follows another. */
static PetscBool IsLoaded(SlipFault fault)
{
  return fault->kind.sequence || fault->loads.pressed ? PETSC_TRUE : PETSC_FALSE;
}

/* Share of the largest displacement against which slips are measured as a rupture begins */
static const PetscReal of_displacement = 0.1;

/* Returns the scale of a slip in explicit steps without inertia. As the only rupture of a run begins, errors of slip
   grow with it and make it earlier or later: slips are measured against the displacement so far while that is of the
   order of d_c. */
PetscReal SlipFaultStickingScale(SlipFault fault, PetscReal scale, PetscBool weakens, PetscReal displacement)
{
  return weakens && !IsLoaded(fault) ? PetscMin(scale, of_displacement * displacement) : scale;
}

/*
  SlipFaultStickingErrorNorm - does the same for an explicit step without inertia, which ends in w1 at the last
  right-hand side

  Collective. Formulas of higher order that do not average over a stop need only the first two of these errors: of slips
  and, where the fault is loaded, of the rates that follow from them. The latter measures a later nucleation against
  itself, long before its slip is large.
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
  PetscCall(SlipFaultGetFriction(fault, 0, &friction)); /* no stress is needed, so any time will do */
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

/* Finds K u.u of a fault that slips as a whole, over its area [Pa/m]: no other slip costs less, but for its shape. */
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
  SlipFaultLoadTolerance - finds the largest acceptable error of the pressure of the cells [n] [Pa], and of their shear
  load unless that is NULL

  Collective. It is the stress of a slip of relative times d_c, or times the largest displacement so far where that is
  less: a history must be right before slip is as large as d_c, too. With a smooth law, a stress of a sigma changes the
  rate by the factor e.
*/
PetscErrorCode SlipFaultLoadTolerance(SlipFault fault, PetscReal relative, PetscReal t, Vec w, PetscReal pressure[],
                                      PetscReal shear[])
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
    pressure[i] = relative * stress / PetscMax(mu, PETSC_SMALL);
    if (shear) shear[i] = relative * stress;
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}
