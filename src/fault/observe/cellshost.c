/* The operations on the cells of a fault by the processor: the row of the table, and its loops that only observers and
   explicit steps use. Loops of stages and of balances stand beside what else they do, in src/fault/stage. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>

/* ---- loads ---- */

static PetscErrorCode HostShear(SlipFault fault, PetscReal t, Vec *shear)
{
  const SlipFaultLoad *load;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  *shear = load->shear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HostOpened(SlipFault fault, PetscReal t, PetscInt *opened)
{
  const SlipFaultLoad *load;

  PetscFunctionBegin;
  *opened = 0;
  PetscCall(SlipFaultGetLoad(fault, t, &load));
  for (PetscInt i = 0; i < fault->mesh.n; i++) *opened += load->stress[i] <= 0 ? 1 : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Any cell may be a new one. */
static PetscErrorCode HostBare(SlipFault fault, PetscReal t, Vec w, Vec bare, PetscInt *more, PetscReal *least)
{
  PetscFunctionBegin;
  (void)t, (void)w, (void)bare;
  *more = fault->mesh.N;
  *least = PETSC_MAX_REAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums over the cells ---- */

static PetscErrorCode HostEstimates(SlipFault fault, Vec w, Vec error, Vec derivative, PetscReal sum[])
{
  const PetscReal *a, *e = NULL, *d = NULL;
  const SlipArrays arrays[] = {{w, .read = &a}, {error, .read = &e}, {derivative, .read = &d}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i), speed = SlipFaultLength(fault, v);

    if (error) sum[ESTIMATE_SLIP_ERROR] += fault->mesh.weight[i] * SlipFaultStateSize(fault, e, i);
    if (derivative && speed != 0)
      sum[ESTIMATE_GROWTH] +=
        fault->mesh.weight[i] * (fault->layout.components == 1
                                   ? PetscSign(*v) * d[SlipFaultRateAt(fault, i)]
                                   : SlipFaultDot(fault, v, d + SlipFaultRateAt(fault, i)) / speed);
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up for the state w after a step and its error e, whose K u is ku. */
static PetscErrorCode HostStep(SlipFault fault, PetscReal t, Vec w, Vec e, Vec ku, PetscReal sum[])
{
  SlipFrictionCells friction;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *b, *f;
  const SlipArrays arrays[] = {{w, .read = &a}, {e, .read = &b}, {ku, .read = &f}};

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(sum, STEP_SUMS));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i), *dv = b + SlipFaultRateAt(fault, i), *fi = f + c * i,
                    *du = b + SlipFaultDisplacementAt(fault, i), speed = SlipFaultSpeed(fault, a, i);
    const PetscReal s = a[SlipFaultStateAt(fault, i)], weight = fault->mesh.weight[i];
    PetscReal mu, slope[2], q;

    SlipFrictionEvaluate(&friction, i, &s, speed, &mu, &slope[0], &slope[1]);
    q = SlipFaultNormalFollows(fault) ? friction.stress[i] : fault->fields.cell[FIELD_NORMAL_STRESS][i];
    q = mu * (weight * q);
    sum[STEP_WORK] += fault->operators.mass * weight * SlipFaultDot(fault, v, dv) + SlipFaultDot(fault, fi, du) +
                      SlipFaultAcross(fault, fi) * SlipFaultAcross(fault, du) + q * b[SlipFaultStateAt(fault, i)];
    sum[STEP_RESTRAINT] += (SlipFaultDot(fault, SlipFaultAlong(fault, i), fi) + q) * s;
    sum[STEP_SLIP] += weight * s;
    sum[STEP_MOVING] += speed != 0 ? weight * s : 0;
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up for the state w after a step, its error e and its derivative d; a cell that has just stopped has none. */
static PetscErrorCode HostTiming(SlipFault fault, Vec w, Vec e, Vec d, PetscReal sum[])
{
  const PetscReal *a, *b, *c;
  const SlipArrays arrays[] = {{w, .read = &a}, {e, .read = &b}, {d, .read = &c}};

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(sum, TIMING_SUMS));
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt at = SlipFaultRateAt(fault, i);
    const PetscReal v = SlipFaultSpeed(fault, a, i), weight = fault->mesh.weight[i],
                    inertia = fault->operators.mass * weight;
    const PetscReal acceleration = SlipFaultAlongSlip(fault, a + at, c + at);

    sum[TIMING_RATE] += weight * v;
    sum[TIMING_SLIPS] += weight * a[SlipFaultStateAt(fault, i)];
    sum[TIMING_ALONG] += weight * b[SlipFaultStateAt(fault, i)];
    sum[TIMING_EXCESS] +=
      inertia * (SlipFaultDot(fault, a + at, b + at) - acceleration * b[SlipFaultStateAt(fault, i)]);
    sum[TIMING_VIGOUR] += inertia * v * v;
    sum[TIMING_GROWTH] += weight * acceleration;
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up |v| and the slip. */
static PetscErrorCode HostCourse(SlipFault fault, PetscReal time, Vec w, PetscReal sum[])
{
  const PetscReal *a, *slip;
  const SlipArrays arrays[] = {{w, .read = &a}, {fault->cells, .read = &slip}};

  PetscFunctionBegin;
  sum[TIMING_RATE] = sum[TIMING_SLIPS] = 0;
  PetscCall(SlipFaultGetSlip(fault, time, w, fault->cells));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    sum[TIMING_RATE] += fault->mesh.weight[i] * SlipFaultSpeed(fault, a, i);
    sum[TIMING_SLIPS] += fault->mesh.weight[i] * slip[i];
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds up by fault the slip rate along the rake, and the slip since the start. */
static PetscErrorCode HostMoments(SlipFault fault, PetscReal t, Vec w, PetscReal rate[], PetscReal moment[])
{
  const PetscInt n = fault->mesh.faults, c = fault->layout.components;
  const PetscReal start = fault->critical.start_share;
  const PetscReal *a, *uc, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  const SlipArrays arrays[] = {{w, .read = &a}, {fault->critical.uc, .read = &uc}};

  PetscFunctionBegin;
  t += fault->loads.origin;
  PetscCall(PetscArrayzero(rate, n));
  PetscCall(PetscArrayzero(moment, n));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt k = SlipFaultMeshFaultOf(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i));
    const PetscReal weight = fault->mesh.weight[i], *along = SlipFaultAlong(fault, i);

    rate[k] += weight * SlipFaultDot(fault, a + SlipFaultRateAt(fault, i), along);
    moment[k] += weight * (SlipFaultDot(fault, a + SlipFaultDisplacementAt(fault, i), along) + t * vinf[i] -
                           start * SlipFaultDot(fault, uc + c * i, along));
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest slip within the last time dt, at whose start displacements were u. */
static PetscErrorCode HostSlip(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest)
{
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE], *a, *then;
  const PetscInt c = fault->layout.components;
  const SlipArrays arrays[] = {{w, .read = &a}, {u, .read = &then}};

  PetscFunctionBegin;
  *largest = 0;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal slip[3] = {0, 0, 0};

    for (PetscInt k = 0; k < c; k++)
      slip[k] = a[SlipFaultDisplacementAt(fault, i) + k] - then[c * i + k] + vinf[i] * SlipFaultAlong(fault, i)[k] * dt;
    *largest = PetscMax(*largest, SlipFaultLength(fault, slip));
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { BOUNDED = 64 };

/* Counts those of n numbers that are not within their bounds, where these are positive. */
SLIP_VECTOR static PetscInt Outside(PetscInt n, const PetscReal *restrict a, const PetscReal *restrict bound)
{
  PetscInt outside = 0;

  for (PetscInt i = 0; i < n; i++) outside += !(PetscAbsReal(a[i]) < bound[i]) & (bound[i] > 0);
  return outside;
}

/* Counts the numbers of a state that are not within the bounds of a block. */
static PetscErrorCode HostOutside(SlipFault fault, Vec w, const PetscReal bound[], PetscInt *outside)
{
  const PetscInt block = fault->layout.block, n = fault->mesh.n;
  PetscReal bounds[BOUNDED * (2 * 3 + SLIP_MAX_STATES)];
  const PetscReal *a;

  PetscFunctionBegin;
  *outside = 0;
  for (PetscInt i = 0; i < BOUNDED * block; i++) bounds[i] = bound[i % block];
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i += BOUNDED)
    *outside += Outside(PetscMin(BOUNDED, n - i) * block, a + i * block, bounds);
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- records ---- */

static PetscErrorCode HostLook(SlipFault fault, PetscReal t, Vec w, SlipFaultLook *look)
{
  const PetscInt block = fault->layout.block, c = fault->layout.components;
  PetscReal *value = look->values;
  SlipFrictionCells friction;
  const PetscReal *a, *r;
  Vec traction;

  PetscFunctionBegin;
  PetscCall(SlipFaultStepTraction(fault, t, w, &traction));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(traction, &r));
  for (PetscInt k = 0; k < look->m; k++, value += block + c + 1) {
    const PetscInt i = look->cell[k];

    if (i < 0) continue;
    PetscCall(PetscArraycpy(value, a + block * i, block));
    for (PetscInt j = 0; j < c; j++) value[block + j] = r[c * i + j] / fault->mesh.weight[i];
    value[block + c] = friction.stress[i];
  }
  PetscCall(VecRestoreArrayRead(traction, &r));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to numbers of the ground the displacement of w since start, and its rate relative to the far field. */
static PetscErrorCode HostGround(SlipFault fault, Vec w, Vec start, SlipFaultLook *look, PetscReal moved[],
                                 PetscReal moves[])
{
  const PetscReal *a, *u0, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  const SlipArrays arrays[] = {{w, .read = &a}, {start, .read = &u0}};
  const PetscInt components = fault->layout.components;

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt row = 0; row < components * fault->mesh.n; row++) {
    const PetscInt i = row / components, j = row % components;
    const PetscReal u = a[SlipFaultDisplacementAt(fault, i) + j] - u0[row],
                    v = a[SlipFaultRateAt(fault, i) + j] - vinf[i] * SlipFaultAlong(fault, i)[j];
    const PetscReal *m = look->matrix + (size_t)look->m * (size_t)row;

    for (PetscInt k = 0; k < look->m; k++) {
      moved[k] += m[k] * u;
      moves[k] += m[k] * v;
    }
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the rate of cell i for a crossing: signed for one component, the magnitude for two. */
static PetscReal EventRate(SlipFault fault, const PetscReal a[], PetscInt i)
{
  return fault->layout.components == 1 ? a[SlipFaultRateAt(fault, i)] : SlipFaultSpeed(fault, a, i);
}

/* Marks in rupture, a vector of cells, the cells that first exceed the rate of events in this step, of nodes at shares
   of it. push: of cells that started within the step, or NULL; *unbroken: there are others */
static PetscErrorCode HostRupture(SlipFault fault, PetscInt nodes, const Vec node[], const PetscReal share[],
                                  PetscReal begin, PetscReal dt, Vec pushes, Vec rupture, PetscBool *unbroken)
{
  const PetscReal rate = fault->options.value[FAULT_EVENT_RATE];
  const PetscReal *a[SLIP_NUM_NODES], *push = NULL;
  PetscReal *t;
  SlipArrays arrays[SLIP_NUM_NODES + 2];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < nodes; k++) arrays[k] = (SlipArrays){node[k], .read = &a[k]};
  arrays[nodes] = (SlipArrays){pushes, .read = &push};
  arrays[nodes + 1] = (SlipArrays){rupture, .write = &t};
  PetscCall(SlipArraysGet(nodes + 2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    int k = 0;

    if (t[i] >= 0) continue;
    if (SlipFaultSpeed(fault, a[nodes - 1], i) <= rate) {
      *unbroken = PETSC_TRUE;
      continue;
    }
    while (SlipFaultSpeed(fault, a[k], i) <= rate) k++;
    t[i] = 0; /* a cell that exceeds it since the event began has no crossing */
    if (!k) continue;
    if (push && push[i] < 0) /* the cell started within the step */
      t[i] = SlipEventCrossing(push[i], SlipFaultSpeed(fault, a[nodes - 1], i), rate);
    else
      t[i] = share[k - 1] + (share[k] - share[k - 1]) *
                              SlipEventCrossing(EventRate(fault, a[k - 1], i), EventRate(fault, a[k], i), rate);
    t[i] = PetscMax(0, begin + dt * t[i]);
  }
  PetscCall(SlipArraysRestore(nodes + 2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultCellsOps SlipFaultCellsHost = {SlipFaultHostEliminate,
                                              SlipFaultHostBound,
                                              SlipFaultHostStartSlope,
                                              SlipFaultHostLift,
                                              SlipFaultHostSmooth,
                                              SlipFaultHostAddReaction,
                                              SlipFaultHostSolveMass,
                                              SlipFaultHostKick,
                                              SlipFaultHostDrift,
                                              SlipFaultHostStrength,
                                              SlipFaultHostRates,
                                              SlipFaultHostCompliance,
                                              HostShear,
                                              HostOpened,
                                              HostBare,
                                              SlipFaultHostSums,
                                              SlipFaultHostMode,
                                              HostEstimates,
                                              SlipFaultHostPowers,
                                              HostStep,
                                              HostTiming,
                                              HostCourse,
                                              HostMoments,
                                              HostSlip,
                                              HostOutside,
                                              SlipFaultStepTraction,
                                              HostLook,
                                              HostGround,
                                              HostRupture};
