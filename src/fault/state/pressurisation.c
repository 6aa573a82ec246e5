/* Computes heat and pore pressure in the middle of the shear zone of each cell, and the suction of dilatancy:

      p = Lambda sum of memories m of the heat source tau |v| + p_d,      dp_d/dt = -p_d/t_p + (epsilon/beta) dpsi/dt,

   psi = ln(V0 theta/d_c) (core/shearzone.c; Segall & Rice 1995). The effective normal stress becomes sigma - p.

   The history is that of the start of the step. At a time t after it p is an explicit function of the state: the slip
   since then times the mean of the shear stresses at both ends is the heat of the step, which is exact also where the
   rate grows by a multiple in a step and stress is constant; in between the source is linear in time from that of the
   start. With dpsi/dt as the source dilatancy is a memory like the others. Both are of second order; what a parabola
   through the source at the end adds is the error estimate. Where the shear stress tau at the end depends on p, it
   follows from a closed form: tau = mu (sigma' - c' tau), c' = Lambda heat slip/2. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* Numbers of a cell in the history: displacement [m], and behind its components */
enum {
  STRESS,   /* friction [Pa] */
  POWER,    /* friction times |v| [W/m^2] */
  PSI,      /* first friction state, of dilatancy */
  PSI_RATE, /* its rate [1/s] */
  SUCTION,  /* p_d [Pa] */
  MEMORY    /* [sums.n] [J/m^2] */
};
#define YEAR 3.15576e7   /* [s] */
#define AGE (1e4 * YEAR) /* oldest heat whose diffusion is right [s] */

/* ---- set-up ---- */

PetscErrorCode SlipFaultZoneSetUp(SlipFault fault)
{
  SlipFaultZone *z = &fault->zone;
  const PetscReal *value = fault->options.value, width = value[FAULT_SHEAR_ZONE_WIDTH];
  PetscInt any[2] = {0, 0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    any[0] |= fault->fields.cell[FIELD_DILATANCY][i] != 0;
    any[1] |= fault->fields.cell[FIELD_THERMAL_PRESSURISATION][i] != 0;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 2, MPIU_INT, MPI_MAX, fault->comm));
  z->dilates = any[0] ? PETSC_TRUE : PETSC_FALSE;
  z->presses = any[0] || any[1] ? PETSC_TRUE : PETSC_FALSE;
  z->on = width > 0 || z->dilates ? PETSC_TRUE : PETSC_FALSE;
  if (!z->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!z->dilates || fault->friction.law->eval == SlipRateAndState, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_dilatancy needs the state theta, which -%sfault_friction_law %s does not have: expected "
             "rate_and_state",
             SlipFaultPrefix(fault), SlipFaultPrefix(fault), fault->friction.law->name);
  z->storage = value[FAULT_DILATANCY_STORAGE];
  z->run = 1 / value[FAULT_DILATANCY_TIME];
  z->sums = (SlipShearZone){.width = width,
                            .diffusivity = {value[FAULT_THERMAL_DIFFUSIVITY], value[FAULT_HYDRAULIC_DIFFUSIVITY]},
                            .capacity = value[FAULT_HEAT_CAPACITY]};
  if (width > 0) PetscCall(SlipShearZoneCreate(value[FAULT_SHEAR_ZONE_TOLERANCE], AGE, &z->sums));
  z->block = fault->layout.components + MEMORY + z->sums.n;
  PetscCall(PetscMalloc3(z->sums.n, &z->weights, z->sums.n, &z->share, fault->mesh.n, &z->left));
  for (int k = 0; k < 2; k++) {
    PetscCall(VecCreate(fault->comm, &z->past[k]));
    PetscCall(VecSetSizes(z->past[k], z->block * fault->mesh.n, PETSC_DETERMINE));
    PetscCall(VecSetType(z->past[k], VECSTANDARD));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultZoneDestroy(SlipFault fault)
{
  SlipFaultZone *z = &fault->zone;

  PetscFunctionBegin;
  if (!z->on) PetscFunctionReturn(PETSC_SUCCESS);
  if (z->sums.n) PetscCall(SlipShearZoneDestroy(&z->sums));
  PetscCall(PetscFree3(z->weights, z->share, z->left));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&z->past[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultZoneView(SlipFault fault, PetscViewer viewer)
{
  const SlipShearZone *sums = &fault->zone.sums;

  PetscFunctionBegin;
  if (!sums->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerASCIIPrintf(
    viewer,
    "shear zone: %" PetscInt_FMT " wavenumbers, largest error of what heat leaves after up to %g years: %.2g of the "
    "temperature, %.2g of the pressure\n",
    sums->n / 2, (double)(sums->age / (PetscReal)YEAR), (double)sums->error[0], (double)sums->error[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- from the history to a time ---- */

static const PetscReal *Past(SlipFault fault, const PetscReal past[], PetscInt i)
{
  return past + fault->zone.block * i;
}

/* Prepares the way from the history to t, and gets the numbers in its slot. */
static PetscErrorCode Begin(SlipFault fault, PetscReal t, const PetscReal **past)
{
  SlipFaultZone *z = &fault->zone;
  const PetscInt slot = z->trial && t < z->time[1] ? 0 : 1;
  const PetscReal h = PetscMax(t - z->time[slot], 0);

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(z->past[slot], past));
  if (z->weighed && z->slot == slot && z->to == t) PetscFunctionReturn(PETSC_SUCCESS);
  z->weighed = PETSC_TRUE;
  z->slot = slot;
  z->to = t;
  SlipShearZoneStep(z->run, h, &z->dilatancy);
  z->pressure = z->temperature = (SlipShearZoneWeights){.left = 0};
  for (PetscInt k = 0; k < z->sums.n; k++) {
    const PetscReal p = z->sums.pressure[k], T = z->sums.temperature[k];
    SlipShearZoneWeights *w = &z->weights[k];

    SlipShearZoneStep(z->sums.rate[k], h, w);
    z->pressure.start += p * w->start;
    z->pressure.heat += p * w->heat;
    z->pressure.curve += p * w->curve;
    z->temperature.start += T * w->start;
    z->temperature.heat += T * w->heat;
    z->share[k] = p * w->left;
  }
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *b = Past(fault, *past, i) + fault->layout.components, *restrict m = b + MEMORY;
    PetscReal sum = z->pressure.start * b[POWER];

    for (PetscInt k = 0; k < z->sums.n; k++) sum += z->share[k] * m[k];
    z->left[i] = sum;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode End(SlipFault fault, const PetscReal **past)
{
  PetscFunctionBegin;
  PetscCall(VecRestoreArrayRead(fault->zone.past[fault->zone.slot], past));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the length of the slip of cell i since the history [m], for the displacement u, and its components. */
static PetscReal Slip(SlipFault fault, const PetscReal past[], const PetscReal vinf[], PetscInt i, const PetscReal u[],
                      PetscReal slip[3])
{
  const PetscReal h = fault->zone.to - fault->zone.time[fault->zone.slot];

  return SlipFaultSlipped(fault, i, h, Past(fault, past, i), u, vinf, slip);
}

/* The pressure of cell i after this slip in the state psi: fixed + gain tau, tau: the shear stress at the end [Pa] */
static void Pressure(SlipFault fault, const PetscReal past[], PetscInt i, PetscReal slip, PetscReal psi,
                     PetscReal *fixed, PetscReal *gain)
{
  const SlipFaultZone *z = &fault->zone;
  const PetscReal *b = Past(fault, past, i) + fault->layout.components;
  const PetscReal lambda = fault->fields.cell[FIELD_THERMAL_PRESSURISATION][i];

  *gain = lambda * z->pressure.heat * slip / 2;
  *fixed = lambda * z->left[i] + *gain * b[STRESS];
  if (z->dilates && fault->fluid.on)
    *fixed += SlipFaultFluidUndrained(fault, i, z->to - z->time[z->slot], psi - b[PSI], b[PSI_RATE]);
  else if (z->dilates)
    *fixed +=
      z->dilatancy.left * b[SUCTION] + fault->fields.cell[FIELD_DILATANCY][i] / z->storage *
                                         (z->dilatancy.start * b[PSI_RATE] + z->dilatancy.heat * (psi - b[PSI]));
}

static PetscBool Unknown(SlipFault fault)
{
  return fault->zone.known ? PETSC_FALSE : PETSC_TRUE;
}

/* For a state with its slip rates: friction gives tau. */
PetscErrorCode SlipFaultZoneOfState(SlipFault fault, PetscReal t, Vec w, PetscReal stress[])
{
  const SlipFrictionCells friction = SlipFaultCellFriction(fault, stress);
  const PetscReal *a, *past, *vinf;

  PetscFunctionBegin;
  if (Unknown(fault)) {
    for (PetscInt i = 0; i < fault->mesh.n; i++) stress[i] = PetscMax(stress[i], 0);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Begin(fault, t, &past));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(fault->operators.vinf, &vinf));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *s = a + SlipFaultStateAt(fault, i);
    PetscReal slip[3], fixed, gain, mu = 0, ds[SLIP_MAX_STATES], dv;

    Pressure(fault, past, i, Slip(fault, past, vinf, i, a + SlipFaultDisplacementAt(fault, i), slip), *s, &fixed,
             &gain);
    if (gain != 0) SlipFrictionEvaluate(&friction, i, s, SlipFaultSpeed(fault, a, i), &mu, ds, &dv);
    stress[i] = PetscMax((stress[i] - fixed) / (1 + mu * gain), 0);
  }
  PetscCall(VecRestoreArrayRead(fault->operators.vinf, &vinf));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(End(fault, &past));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For a state [block n] whose slip rates follow from the stress tau that friction and radiation damping balance: the
   damping is that of the rate that makes the slip with the start's by a straight line. */
PetscErrorCode SlipFaultZoneOfBalance(SlipFault fault, PetscReal t, const PetscReal a[], const PetscReal tau[],
                                      PetscReal stress[])
{
  const PetscInt c = fault->layout.components;
  const PetscReal *past, *vinf;
  PetscReal h;

  PetscFunctionBegin;
  if (Unknown(fault)) {
    for (PetscInt i = 0; i < fault->mesh.n; i++) stress[i] = PetscMax(stress[i], 0);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Begin(fault, t, &past));
  PetscCall(VecGetArrayRead(fault->operators.vinf, &vinf));
  h = t - fault->zone.time[fault->zone.slot];
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *b = Past(fault, past, i) + c;
    PetscReal way[3];
    const PetscReal slip = Slip(fault, past, vinf, i, a + SlipFaultDisplacementAt(fault, i), way);
    const PetscReal before = b[STRESS] > 0 ? b[POWER] / b[STRESS] : 0;
    const PetscReal speed = h > 0 ? PetscMax(2 * slip / h - before, 0) : before;
    PetscReal fixed, gain, end = SlipFaultLength(fault, tau + c * i) / fault->mesh.weight[i];

    end = PetscMax(end - fault->balance.eta * speed, 0);
    Pressure(fault, past, i, slip, a[SlipFaultStateAt(fault, i)], &fixed, &gain);
    stress[i] = PetscMax(stress[i] - fixed - gain * end, 0);
  }
  PetscCall(VecRestoreArrayRead(fault->operators.vinf, &vinf));
  PetscCall(End(fault, &past));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For a stage with u = u0 + theta v [n][components], without dilatancy: q and dq/d|v| (NULL: not wanted) are those of
   the given normal stress, of which only the positive part counts. Both and the stress become those under pressure. */
PetscErrorCode SlipFaultZoneOfStage(SlipFault fault, Vec u0, const PetscReal v[], PetscReal stress[], PetscReal q[],
                                    PetscReal dq[])
{
  const PetscInt c = fault->layout.components;
  const PetscReal theta = fault->stage.theta, *lambda = fault->fields.cell[FIELD_THERMAL_PRESSURISATION];
  const PetscReal *past, *vinf, *start_u;

  PetscFunctionBegin;
  if (Unknown(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Begin(fault, fault->stage.time, &past));
  PetscCall(VecGetArrayRead(fault->operators.vinf, &vinf));
  PetscCall(VecGetArrayRead(u0, &start_u));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal weight = fault->mesh.weight[i], mu = stress[i] > 0 ? q[i] / (weight * stress[i]) : 0;
    const PetscReal speed = SlipFaultLength(fault, v + c * i), start = Past(fault, past, i)[c + STRESS];
    PetscReal u[3], way[3], slip, more, fixed, gain, next;

    for (PetscInt k = 0; k < c; k++) u[k] = start_u[c * i + k] + theta * v[c * i + k];
    slip = Slip(fault, past, vinf, i, u, way);
    Pressure(fault, past, i, slip, 0, &fixed, &gain);
    next = PetscMax((stress[i] - fixed) / (1 + mu * gain), 0);
    /* d slip/d|v|, and by it the change of gain */
    more = slip > 0 && speed > 0 ? theta * SlipFaultDot(fault, way, v + c * i) / (slip * speed) : theta;
    more *= lambda[i] * fault->zone.pressure.heat / 2;
    if (dq && mu > 0)
      dq[i] = next > 0 ? (dq[i] * next / stress[i] - weight * mu * more * (start + mu * next)) / (1 + mu * gain) : 0;
    stress[i] = next;
    q[i] = weight * mu * next;
  }
  PetscCall(VecRestoreArrayRead(u0, &start_u));
  PetscCall(VecRestoreArrayRead(fault->operators.vinf, &vinf));
  PetscCall(End(fault, &past));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step is accurate enough if the change of friction stress, at most that of pressure, is at most rtol times that by
   which friction changes: b sigma, or the drop that weakening makes. rate: slip rates at the end, NULL: those of w */
PetscErrorCode SlipFaultZoneError(SlipFault fault, PetscReal rtol, PetscReal t, Vec w, Vec rate, PetscReal *E)
{
  SlipFaultZone *z = &fault->zone;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *v = NULL, *past, *vinf, *const *cell = (const PetscReal *const *)fault->fields.cell;
  PetscReal largest = 0, h;
  const SlipArrays arrays[] = {{w, .read = &a}, {fault->operators.vinf, .read = &vinf}, {rate, .read = &v}};

  PetscFunctionBegin;
  *E = 0;
  if (Unknown(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Begin(fault, t, &past));
  PetscCall(SlipArraysGet(rate ? 3 : 2, arrays));
  h = t - z->time[z->slot];
  for (PetscInt i = 0; i < fault->mesh.n && h > 0; i++) {
    PetscReal way[3];
    const PetscReal *b = Past(fault, past, i) + c;
    const PetscReal slip = Slip(fault, past, vinf, i, a + SlipFaultDisplacementAt(fault, i), way);
    const PetscReal speed = rate ? SlipFaultLength(fault, v + c * i) : SlipFaultSpeed(fault, a, i);
    const PetscReal change = SlipFaultFrictionChange(fault, i);
    PetscReal error =
      cell[FIELD_THERMAL_PRESSURISATION][i] * z->pressure.curve * (b[POWER] + b[STRESS] * (speed - 2 * slip / h));

    if (z->dilates && !fault->fluid.on)
      error +=
        cell[FIELD_DILATANCY][i] / z->storage * z->dilatancy.curve *
        (b[PSI_RATE] + SlipFaultFirstStateRate(fault, i, a, speed) - 2 * (a[SlipFaultStateAt(fault, i)] - b[PSI]) / h);

    if (change > 0) largest = SlipLarger(largest, PetscAbsReal(error) / change);
  }
  PetscCall(SlipArraysRestore(rate ? 3 : 2, arrays));
  PetscCall(End(fault, &past));
  PetscCall(SlipAllreduceLargest(fault->comm, 1, &largest));
  *E = largest / rtol;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the history ---- */

/* Sets the numbers of slot 1 for the state w at t, after a way from the history, or from nothing. */
static PetscErrorCode Move(SlipFault fault, PetscReal t, Vec w, const SlipFrictionCells *friction)
{
  SlipFaultZone *z = &fault->zone;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *vinf, *past;
  PetscReal *to;

  PetscFunctionBegin;
  if (z->known) {
    PetscCall(Begin(fault, t, &past));
    PetscCall(End(fault, &past));
  }
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(fault->operators.vinf, &vinf));
  PetscCall(VecGetArray(z->past[1], &to));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal speed = SlipFaultSpeed(fault, a, i), *u = a + SlipFaultDisplacementAt(fault, i),
                    *s = a + SlipFaultStateAt(fault, i);
    PetscReal *b = to + z->block * i, *restrict m = b + c + MEMORY, mu, ds[SLIP_MAX_STATES], dv, tau, way[3];

    SlipFrictionEvaluate(friction, i, s, speed, &mu, ds, &dv);
    tau = mu * friction->stress[i];
    if (z->known) {
      const PetscReal heat = (b[c + STRESS] + tau) / 2 * Slip(fault, to, vinf, i, u, way), power = b[c + POWER];

      for (PetscInt k = 0; k < z->sums.n; k++)
        m[k] = z->weights[k].left * m[k] + z->weights[k].start * power + z->weights[k].heat * heat;
      b[c + SUCTION] = z->dilatancy.left * b[c + SUCTION] +
                       fault->fields.cell[FIELD_DILATANCY][i] / z->storage *
                         (z->dilatancy.start * b[c + PSI_RATE] + z->dilatancy.heat * (*s - b[c + PSI]));
    } else
      PetscCall(PetscArrayzero(b, z->block));
    for (PetscInt k = 0; k < c; k++) b[k] = u[k];
    b[c + STRESS] = tau;
    b[c + POWER] = tau * speed;
    b[c + PSI] = *s;
    b[c + PSI_RATE] = z->dilates ? SlipFaultFirstStateRate(fault, i, a, speed) : 0;
  }
  PetscCall(VecRestoreArray(z->past[1], &to));
  PetscCall(VecRestoreArrayRead(fault->operators.vinf, &vinf));
  PetscCall(VecRestoreArrayRead(w, &a));
  z->time[1] = t;
  z->known = PETSC_TRUE;
  z->weighed = PETSC_FALSE;
  fault->coupling.moment = (SlipFaultMoment){0}; /* the same stress now follows by other sums */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Forgets the history: a run begins. */
void SlipFaultZoneForget(SlipFault fault)
{
  fault->zone.known = PETSC_FALSE;
  fault->coupling.moment = (SlipFaultMoment){0};
}

PetscErrorCode SlipFaultZoneAccept(SlipFault fault, PetscReal t, Vec w, const SlipFrictionCells *friction)
{
  PetscFunctionBegin;
  if (!fault->zone.on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Move(fault, t, w, friction));
  fault->zone.trial = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultZoneAdvance(SlipFault fault, PetscReal t, Vec w, const SlipFrictionCells *friction)
{
  SlipFaultZone *z = &fault->zone;

  PetscFunctionBegin;
  if (!z->on) PetscFunctionReturn(PETSC_SUCCESS);
  if (!z->trial) {
    PetscCall(VecCopy(z->past[1], z->past[0]));
    z->time[0] = z->time[1];
  }
  PetscCall(Move(fault, t, w, friction));
  z->trial = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultZoneRollBack(SlipFault fault)
{
  SlipFaultZone *z = &fault->zone;

  PetscFunctionBegin;
  if (!z->trial) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(z->past[0], z->past[1]));
  z->time[1] = z->time[0];
  z->trial = z->weighed = PETSC_FALSE;
  fault->coupling.moment = (SlipFaultMoment){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SlipFaultZoneOrigin(SlipFault fault, PetscReal by)
{
  for (int k = 0; k < 2; k++) fault->zone.time[k] -= by;
  fault->zone.weighed = PETSC_FALSE;
}

/* Writes the history to a checkpoint, or reads it. */
PetscErrorCode SlipFaultZoneVisit(SlipFault fault, SlipState state)
{
  static const char *const time[] = {"time_before", "time"}, *const cells[] = {"cells_before", "cells"};
  SlipFaultZone *z = &fault->zone;

  PetscFunctionBegin;
  if (!z->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(state, "shear_zone"));
  PetscCall(SlipStateBool(state, "known", &z->known));
  PetscCall(SlipStateBool(state, "within_attempt", &z->trial));
  for (int k = z->trial ? 0 : 1; k < 2 && z->known; k++) {
    PetscCall(SlipStateReal(state, time[k], 1, &z->time[k]));
    PetscCall(SlipStateVec(state, cells[k], z->past[k]));
  }
  z->weighed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultZoneValues(SlipFault fault, PetscReal t, Vec w, const SlipFrictionCells *friction, PetscInt n,
                                   const PetscInt cells[], PetscReal temperature[], PetscReal pressure[])
{
  const SlipFaultZone *z = &fault->zone;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *past, *vinf;

  PetscFunctionBegin;
  if (temperature) PetscCall(PetscArrayzero(temperature, n));
  if (pressure) PetscCall(PetscArrayzero(pressure, n));
  if (Unknown(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Begin(fault, t, &past));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(fault->operators.vinf, &vinf));
  for (PetscInt j = 0; j < n; j++) {
    const PetscInt i = cells ? cells[j] : j;

    if (i < 0) continue;
    const PetscReal *s = a + SlipFaultStateAt(fault, i), *b = Past(fault, past, i) + c;
    PetscReal way[3], mu, ds[SLIP_MAX_STATES], dv, fixed, gain, tau, sum;
    const PetscReal slip = Slip(fault, past, vinf, i, a + SlipFaultDisplacementAt(fault, i), way);

    SlipFrictionEvaluate(friction, i, s, SlipFaultSpeed(fault, a, i), &mu, ds, &dv);
    tau = mu * friction->stress[i];
    Pressure(fault, past, i, slip, *s, &fixed, &gain);
    if (pressure) pressure[j] = fixed + gain * tau;
    if (!temperature) continue;
    sum = z->temperature.start * b[POWER] + z->temperature.heat * (b[STRESS] + tau) / 2 * slip;
    for (PetscInt k = 0; k < z->sums.n; k++) sum += z->sums.temperature[k] * z->weights[k].left * b[MEMORY + k];
    temperature[j] = sum;
  }
  PetscCall(VecRestoreArrayRead(fault->operators.vinf, &vinf));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(End(fault, &past));
  PetscFunctionReturn(PETSC_SUCCESS);
}
