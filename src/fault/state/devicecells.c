/* Computes the cells of a rate-and-state fault on a device: stored numbers, loads at a time, slip rates in balance, and
   sums, as balance.c, loads.c, coupling.c and faultobserve.c do on the processor. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipmatcommon.h>

/* Numbers stored for each cell, in the order of kernels/ratestate.cl: law and load; then for two components; then where
   the normal stress or the shear load changes */
enum { OFFSET, SLOPE, INVERSE, SCALE, LOAD, SLIP, LOADING, TRACTION, WEIGHT, CREEP, SHIFT, NUM_ONE };
enum { LOAD_UP = NUM_ONE, ALONG, ALONG_UP, NUM_TWO };
enum { GROWTH = NUM_TWO, DIRECT, REFERENCE, FOLLOW, NORMAL, STRESS, NUM_CHANGING };
/* Counted vectors of states and of slip: those of TSADAMS of the highest order, its tolerances, and the fault's work */
enum { STATE_VECTORS = 19, SLIP_VECTORS = 14 };

static PetscBool Changes(SlipFault fault)
{
  return fault->loads.grows || fault->loads.pressed || fault->kind.coupled ? PETSC_TRUE : PETSC_FALSE;
}

static size_t NumKept(SlipFault fault)
{
  return Changes(fault) ? NUM_CHANGING : fault->layout.components > 1 ? NUM_TWO : NUM_ONE;
}

/* Puts K, and Kn unless that is NULL, on the device if the fault fits there; before any vector exists. Products are
   then computed there, and vectors from K and their duplicates are there. */
PetscErrorCode SlipFaultDeviceOperators(SlipFault fault, Mat K, Mat Kn)
{
  SlipFaultDevice *d = &fault->device;
  const SlipFaultLoads *loads = &fault->loads;
  const PetscReal n = (PetscReal)fault->mesh.n, c = (PetscReal)fault->layout.components;
  PetscReal bytes = 0, normal = 0, vectors = STATE_VECTORS * (PetscReal)fault->layout.block + SLIP_VECTORS * c;
  PetscBool room;

  PetscFunctionBegin;
  if (!d->device) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipMatDeviceBytes(K, &bytes));
  if (Kn) PetscCall(SlipMatDeviceBytes(Kn, &normal));
  vectors += (PetscReal)NumKept(fault) + (PetscReal)loads->rows;
  vectors += (loads->pressed ? 1 : 0) + (loads->source.distance2 ? 1 : 0) + (loads->grows ? c : 0);
  d->bytes = bytes + normal + (PetscReal)sizeof(PetscReal) * n * vectors;
  PetscCall(SlipFaultDeviceRoom(fault, &room));
  if (!room) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipMatUseDevice(K));
  if (Kn) PetscCall(SlipMatUseDevice(Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether slip rates are balanced on the device. */
PetscBool SlipFaultDeviceBalances(SlipFault fault)
{
  return fault->device.device && fault->friction.law->keep && fault->balance.eta > 0 && !fault->kind.inertia
           ? PETSC_TRUE
           : PETSC_FALSE;
}

/* Returns whether kernels can compute with this state. They cannot with a state that a user has created elsewhere. */
PetscBool SlipFaultOnDevice(SlipFault fault, Vec w)
{
  return SlipFaultDeviceBalances(fault) && SlipDeviceVecIs(w) ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- numbers stored for each cell ---- */

/* Fills [NumKept()][n] with the constants, and with the law under the normal stress of the start. */
static PetscErrorCode FillCells(SlipFault fault, PetscReal a[])
{
  const PetscInt n = fault->mesh.n;
  SlipFrictionCells friction = SlipFaultCellFriction(fault, fault->loads.normal);
  const PetscReal *const from[] = {fault->fields.cell[FIELD_FRICTION_SLIP], fault->fields.cell[FIELD_LOADING_RATE],
                                   fault->fields.cell[FIELD_INITIAL_TRACTION], fault->mesh.weight};

  PetscFunctionBegin;
  friction.law->keep(&friction, n, fault->balance.eta, a); /* OFFSET to SCALE */
  PetscCall(PetscArrayzero(a + LOAD * n, (size_t)n * (NumKept(fault) - LOAD)));
  for (int k = 0; k < 4; k++) PetscCall(PetscArraycpy(a + (SLIP + k) * n, from[k], n));
  for (PetscInt i = 0; i < n && fault->balance.creeps; i++) a[CREEP * n + i] = fault->balance.creeps[i] ? 1 : 0;
  for (PetscInt i = 0; i < n && fault->layout.components > 1; i++)
    for (PetscInt k = 0; k < 2; k++) a[(ALONG + k) * n + i] = SlipFaultAlong(fault, i)[k];
  if (!Changes(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < n; i++) {
    a[GROWTH * n + i] = fault->loads.rate[i];
    a[DIRECT * n + i] = friction.a[i];
    a[REFERENCE * n + i] = friction.reference[i] / friction.a[i];
    a[FOLLOW * n + i] = friction.alpha && friction.alpha[i] > 0 ? friction.alpha[i] / friction.b[i] : 0;
    a[NORMAL * n + i] = a[STRESS * n + i] = fault->loads.normal[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Allocates n numbers on the device, and sends them unless they are NULL. */
PetscErrorCode SlipFaultDevicePut(SlipFault fault, size_t n, const PetscReal from[], const char what[],
                                  SlipDeviceMemory *to)
{
  PetscFunctionBegin;
  PetscCall(SlipDeviceAllocate(fault->device.device, sizeof(PetscReal) * n, what, to));
  if (from) PetscCall(SlipDevicePut(fault->device.device, n, from, *to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the cells' numbers to the device, once. */
static PetscErrorCode CreateCells(SlipFault fault)
{
  SlipFaultDevice *d = &fault->device;
  const SlipFaultLoads *loads = &fault->loads;
  const size_t n = (size_t)fault->mesh.n, kept = n * NumKept(fault);
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(kept, &a));
  PetscCall(FillCells(fault, a));
  PetscCall(SlipFaultDevicePut(fault, kept, a, "cells", &d->cells));
  PetscCall(PetscFree(a));
  if (loads->pressed) PetscCall(SlipFaultDevicePut(fault, n, NULL, "the pore pressure", &d->pressure));
  if (loads->rows)
    PetscCall(SlipFaultDevicePut(fault, n * (size_t)loads->rows, loads->record, "pressures", &d->record));
  if (loads->source.distance2)
    PetscCall(SlipFaultDevicePut(fault, n, loads->source.distance2, "distances", &d->distance2));
  d->loaded = d->pressed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the pore pressure at t: a user's function is evaluated here and copied, and the device computes the others. */
static PetscErrorCode Pressure(SlipFault fault, PetscReal t)
{
  SlipFaultDevice *d = &fault->device;
  const SlipFaultLoads *loads = &fault->loads;
  const SlipFaultSource *source = &loads->source;
  const int n = (int)fault->mesh.n, own = loads->function ? 1 : 0, recorded = loads->rows ? 1 : 0;
  const PetscReal D = source->distance2 ? source->diffusivity : 0, open = 4 * D * t,
                  shut = source->stop > 0 ? 4 * D * (t - source->stop) : 0;
  const SlipDeviceMemory record = recorded ? d->record : d->pressure,
                         distance2 = source->distance2 ? d->distance2 : d->pressure;
  PetscReal share = 0;
  int64_t row;

  PetscFunctionBegin;
  if (own) {
    PetscCall(SlipLoadsOwnPressure(loads, t));
    PetscCall(SlipDevicePut(d->device, (size_t)n, loads->own, d->pressure));
  }
  row = recorded ? (int64_t)SlipLoadsInterval(loads, t, &share) : 0;
  {
    const SlipDeviceArg args[] = {
      SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(own),       SLIP_DEVICE_ARG(recorded),         SLIP_DEVICE_ARG(row),
      SLIP_DEVICE_ARG(share), SLIP_DEVICE_ARG(record),    SLIP_DEVICE_ARG(source->pressure), SLIP_DEVICE_ARG(open),
      SLIP_DEVICE_ARG(shut),  SLIP_DEVICE_ARG(distance2), SLIP_DEVICE_ARG(d->pressure)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_FAULT_PRESSURE, (size_t)n, 1, 11, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the numbers of the cells to the time t; rise: Kn u where slip changes normal stress, else NULL. */
static PetscErrorCode Cells(SlipFault fault, PetscReal t, Vec rise, SlipDeviceMemory *cells)
{
  SlipFaultDevice *d = &fault->device;
  const SlipFaultLoads *loads = &fault->loads;
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, shears = loads->shears, grows = loads->grows,
            pressed = loads->pressed, coupled = rise ? 1 : 0;
  const PetscReal V0 = fault->options.value[FAULT_FRICTION_REFERENCE_RATE], eta = fault->balance.eta;
  const PetscReal since = loads->origin;
  SlipDeviceMemory pressure, raised;
  PetscBool other;

  PetscFunctionBegin;
  if (!d->cells) PetscCall(CreateCells(fault));
  *cells = d->cells;
  other = d->time != t || d->origin != since ? PETSC_TRUE : PETSC_FALSE;
  if (!d->loaded || (grows && other)) {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(c),       SLIP_DEVICE_ARG(shears),
                                  SLIP_DEVICE_ARG(grows), SLIP_DEVICE_ARG(since),   SLIP_DEVICE_ARG(t),
                                  SLIP_DEVICE_ARG(eta),   SLIP_DEVICE_ARG(d->cells)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_FAULT_LOAD, (size_t)n, 1, 8, args));
  }
  other = pressed && (other || !d->pressed) ? PETSC_TRUE : PETSC_FALSE;
  if (other) PetscCall(Pressure(fault, t));
  d->loaded = PETSC_TRUE;
  d->pressed = loads->pressed;
  d->time = t;
  d->origin = since;
  if (!other && !coupled) PetscFunctionReturn(PETSC_SUCCESS);
  raised = pressure = pressed ? d->pressure : d->cells;
  if (coupled) PetscCall(SlipDeviceVecRead(rise, &raised));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),       SLIP_DEVICE_ARG(eta),     SLIP_DEVICE_ARG(V0),
                                  SLIP_DEVICE_ARG(pressed), SLIP_DEVICE_ARG(coupled), SLIP_DEVICE_ARG(pressure),
                                  SLIP_DEVICE_ARG(raised),  SLIP_DEVICE_ARG(d->cells)};

    PetscCall(SlipDeviceRun(d->device, KERNEL_FAULT_STRENGTH, (size_t)n, 1, 8, args));
  }
  d->moment = (SlipFaultMoment){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the numbers for the state w at t, whose slip may have changed normal stress: see SlipFaultGetFrictionOf(). */
static PetscErrorCode CellsOf(SlipFault fault, PetscReal t, Vec w, SlipDeviceMemory *cells)
{
  SlipFaultCoupling *c = &fault->coupling;
  SlipFaultMoment now;
  PetscBool same;

  PetscFunctionBegin;
  if (!fault->kind.coupled) {
    PetscCall(Cells(fault, t, NULL, cells));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *cells = fault->device.cells;
  PetscCall(SlipFaultStateUnchanged(fault, t, w, &fault->device.moment, &now, &same));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetDisplacement(fault, w, c->u));
  if (c->balanced) PetscCall(SlipFaultDisplacementUnchanged(fault, t, c->u, &c->balanced));
  if (!c->balanced) PetscCall(SlipElasticForce(fault->medium, t, c->u, NULL, NULL, c->rise));
  PetscCall(Cells(fault, t, c->rise, cells));
  fault->device.moment = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the numbers for the state w at t, or the present ones for w NULL; changes: do they include normal stress? */
PetscErrorCode SlipFaultDeviceCells(SlipFault fault, PetscReal t, Vec w, struct _cl_mem **cells, PetscBool *changes)
{
  PetscFunctionBegin;
  if (!fault->device.cells) PetscCall(CreateCells(fault));
  *cells = fault->device.cells;
  if (w) PetscCall(CellsOf(fault, t, w, cells));
  if (changes) *changes = Changes(fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the shear load at t, times weights, as a vector of slip on the device. */
PetscErrorCode SlipFaultDeviceShear(SlipFault fault, PetscReal t, Vec *shear)
{
  SlipFaultDevice *d = &fault->device;
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, grows = fault->loads.grows;
  const PetscReal origin = fault->loads.origin;
  SlipDeviceMemory to;

  PetscFunctionBegin;
  if (!d->cells) PetscCall(CreateCells(fault));
  if (d->shear && (!grows || (d->shear_time == t && d->shear_origin == origin))) {
    *shear = d->shear;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!d->shear) PetscCall(VecDuplicate(fault->critical.uc, &d->shear));
  *shear = d->shear;
  d->shear_time = t;
  d->shear_origin = origin;
  PetscCall(SlipDeviceVecWrite(d->shear, &to));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),      SLIP_DEVICE_ARG(c), SLIP_DEVICE_ARG(grows),
                                  SLIP_DEVICE_ARG(origin), SLIP_DEVICE_ARG(t), SLIP_DEVICE_ARG(fault->device.cells),
                                  SLIP_DEVICE_ARG(to)};

    PetscCall(SlipDeviceRun(fault->device.device, KERNEL_FAULT_SHEAR, (size_t)n, 1, 7, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the cells that the pore pressure at t opens. */
PetscErrorCode SlipFaultDeviceOpen(SlipFault fault, PetscReal t, PetscInt *opened)
{
  const int n = (int)fault->mesh.n;
  SlipDeviceMemory cells;
  PetscReal count;

  PetscFunctionBegin;
  if (!fault->device.cells) PetscCall(CreateCells(fault));
  cells = fault->device.cells;
  if (!fault->kind.coupled)
    PetscCall(Cells(fault, t, NULL, &cells));
  else if (!fault->device.pressed || fault->device.time != t || fault->device.origin != fault->loads.origin) {
    PetscCall(Pressure(fault, t));
    fault->device.pressed = PETSC_FALSE; /* the stored strength is of another time */
  }
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(fault->device.pressure)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_OPEN, (size_t)n, 3, args, 1, 1, &count));
  }
  *opened = (PetscInt)count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- results of a state ---- */

/* Computes balance.rate from the state w at t, whose K u is in balance.force, and unless F is NULL the rates F of w */
PetscErrorCode SlipFaultDeviceRates(SlipFault fault, PetscReal t, Vec w, Vec F)
{
  SlipFaultBalance *b = &fault->balance;
  const PetscReal V0 = fault->options.value[FAULT_FRICTION_REFERENCE_RATE],
                  cutoff = fault->options.value[FAULT_STATE_CUTOFF_RATE];
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, state_law = (int)fault->friction.state_law;
  SlipDevice device = fault->device.device;
  SlipDeviceMemory cells, state, force, rate, f = NULL;

  PetscFunctionBegin;
  PetscCall(Cells(fault, t, fault->kind.coupled ? fault->coupling.rise : NULL, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(b->force, &force));
  PetscCall(SlipDeviceVecWrite(b->rate, &rate));
  if (F) PetscCall(SlipDeviceVecWrite(F, &f));
  {
    const SlipDeviceArg closed[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state),
                                    SLIP_DEVICE_ARG(force), SLIP_DEVICE_ARG(rate)};
    const SlipDeviceArg others[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(c),     SLIP_DEVICE_ARG(b->eta),
                                    SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(force),
                                    SLIP_DEVICE_ARG(rate)};
    const SlipDeviceArg derivative[] = {SLIP_DEVICE_ARG(n),      SLIP_DEVICE_ARG(state_law), SLIP_DEVICE_ARG(V0),
                                        SLIP_DEVICE_ARG(cutoff), SLIP_DEVICE_ARG(cells),     SLIP_DEVICE_ARG(state),
                                        SLIP_DEVICE_ARG(rate),   SLIP_DEVICE_ARG(f)};

    PetscCall(SlipDeviceRun(device, c == 1 ? KERNEL_FAULT_RATES : KERNEL_FAULT_RATES_2, (size_t)n, 1, 5, closed));
    PetscCall(SlipDeviceRun(device, KERNEL_FAULT_OTHERS, (size_t)n, 1, 7, others));
    if (F)
      PetscCall(SlipDeviceRun(device, c == 1 ? KERNEL_FAULT_DERIVATIVE : KERNEL_FAULT_DERIVATIVE_2, (size_t)n, 1, 8,
                              derivative));
  }
  fault->coupling.balanced = fault->kind.coupled;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest dv/dtau of the balance for the rates of the last right-hand side, with its normal stress where that
   is cached. */
PetscErrorCode SlipFaultDeviceCompliance(SlipFault fault, Vec w, PetscReal *most)
{
  SlipFaultBalance *b = &fault->balance;
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  SlipDeviceMemory cells, state, rate;

  PetscFunctionBegin;
  if (fault->coupling.balanced)
    PetscCall(Cells(fault, b->time, fault->coupling.rise, &cells));
  else
    PetscCall(CellsOf(fault, b->time, w, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(b->rate, &rate));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(c),     SLIP_DEVICE_ARG(b->eta),
                                  SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(rate)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_RELAXATION, (size_t)n, 6, args, 1, 0, most));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the sums of a state at t whose K u is force, and its largest |v|. */
PetscErrorCode SlipFaultDeviceSums(SlipFault fault, PetscReal t, Vec w, Vec force, PetscReal sum[], PetscReal *max_v)
{
  const PetscReal eta = fault->balance.eta, since = fault->loads.origin + t;
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, shears = fault->loads.shears,
            grows = fault->loads.grows;
  PetscReal results[FAULT_NUM_SUMS + 1];
  SlipDeviceMemory cells, state, ku;

  PetscFunctionBegin;
  PetscCall(CellsOf(fault, t, w, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(force, &ku));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),      SLIP_DEVICE_ARG(c),     SLIP_DEVICE_ARG(eta),
                                  SLIP_DEVICE_ARG(shears), SLIP_DEVICE_ARG(grows), SLIP_DEVICE_ARG(since),
                                  SLIP_DEVICE_ARG(cells),  SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(ku)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_SUMS, (size_t)n, 9, args, FAULT_NUM_SUMS + 1,
                               FAULT_NUM_SUMS, results));
  }
  PetscCall(PetscArraycpy(sum, results, FAULT_NUM_SUMS));
  *max_v = results[FAULT_NUM_SUMS];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does SlipFaultGetPowers() with the friction of the state. */
PetscErrorCode SlipFaultDevicePowers(SlipFault fault, PetscReal t, Vec w, PetscReal power[3])
{
  const PetscReal eta = fault->balance.eta;
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  SlipDeviceMemory cells, state;

  PetscFunctionBegin;
  PetscCall(CellsOf(fault, t, w, &cells));
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(c), SLIP_DEVICE_ARG(eta), SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_POWERS, (size_t)n, 5, args, 3, 3, power));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes for each of several faults the power of friction in the state w at t, as SlipFaultGetPowers() does, and the
   sums of slip rate, displacement and loading along the rake, weighted by area; NULL: not wanted. */
PetscErrorCode SlipFaultDeviceShares(SlipFault fault, PetscReal t, Vec w, PetscReal friction[], PetscReal rate[],
                                     PetscReal displacement[], PetscReal loading[])
{
  SlipFaultDevice *d = &fault->device;
  const PetscReal eta = fault->balance.eta;
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  SlipDeviceMemory cells, state;
  PetscReal share[4], *a;

  PetscFunctionBegin;
  PetscCall(CellsOf(fault, t, w, &cells));
  if (!d->faults) {
    PetscCall(PetscMalloc1(n, &a));
    for (PetscInt i = 0; i < n; i++)
      a[i] = (PetscReal)SlipFaultMeshFaultOf(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i));
    PetscCall(SlipFaultDevicePut(fault, (size_t)n, a, "cells", &d->faults));
    PetscCall(PetscFree(a));
  }
  PetscCall(SlipDeviceVecRead(w, &state));
  for (int k = 0; k < fault->mesh.faults; k++) {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),    SLIP_DEVICE_ARG(c),         SLIP_DEVICE_ARG(k),
                                  SLIP_DEVICE_ARG(eta),  SLIP_DEVICE_ARG(d->faults), SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(d->device, KERNEL_FAULT_SHARE, (size_t)n, 7, args, 4, 4, share));
    if (friction) friction[k] = share[0];
    if (rate) rate[k] = share[1];
    if (displacement) displacement[k] = share[2];
    if (loading) loading[k] = share[3];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the cells without normal stress in the state w at t that bare does not mark; least: the least of all [Pa] */
PetscErrorCode SlipFaultDeviceBare(SlipFault fault, PetscReal t, Vec w, Vec bare, PetscInt *more, PetscReal *least)
{
  const int n = (int)fault->mesh.n;
  SlipDeviceMemory cells, marks;
  PetscReal results[2];

  PetscFunctionBegin;
  PetscCall(CellsOf(fault, t, w, &cells));
  PetscCall(SlipDeviceVecRead(bare, &marks));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(marks)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_BARE, (size_t)n, 3, args, 2, 1, results));
  }
  *more = (PetscInt)results[0];
  *least = -results[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest slip within the last time dt, at whose start displacements were u. */
PetscErrorCode SlipFaultDeviceSlip(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  SlipDeviceMemory state, then;

  PetscFunctionBegin;
  if (!fault->device.cells) PetscCall(CreateCells(fault));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(u, &then));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),     SLIP_DEVICE_ARG(c),
                                  SLIP_DEVICE_ARG(dt),    SLIP_DEVICE_ARG(fault->device.cells),
                                  SLIP_DEVICE_ARG(state), SLIP_DEVICE_ARG(then)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_SLIP, (size_t)n, 6, args, 1, 0, largest));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the displacements and states that are not within these bounds. */
PetscErrorCode SlipFaultDeviceOutside(SlipFault fault, Vec w, PetscReal displacement, PetscReal bound,
                                      PetscInt *outside)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  SlipDeviceMemory state;
  PetscReal count;

  PetscFunctionBegin;
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n), SLIP_DEVICE_ARG(c), SLIP_DEVICE_ARG(displacement),
                                  SLIP_DEVICE_ARG(bound), SLIP_DEVICE_ARG(state)};

    PetscCall(SlipDeviceReduce(fault->device.device, KERNEL_FAULT_OUTSIDE, (size_t)n, 5, args, 1, 1, &count));
  }
  *outside = (PetscInt)count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a vector of cells, on the device where the states are there. */
PetscErrorCode SlipFaultCellVector(SlipFault fault, Vec *x)
{
  PetscFunctionBegin;
  PetscCall(VecCreate(fault->comm, x));
  PetscCall(VecSetSizes(*x, fault->mesh.n, fault->mesh.N));
  PetscCall(VecSetType(*x, fault->device.device ? VECSLIPOPENCL : VECSTANDARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}
