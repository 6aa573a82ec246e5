/* The operations on the cells of a fault on a device: kernels/ratestate.cl, loads.cl and record.cl compute cells that
   always slide (devicecells.c), kernels/stage.cl those that stick, with one component and built-in laws under constant
   normal stress. For all others, and for vectors that are elsewhere, as of users, the processor's row computes. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipdevice.h>

#define HOST SlipFaultCellsHost

/* ---- cells that stick ---- */

/* Numbers stored for each cell, in the order of kernels/stage.cl */
enum { RESIDUAL, DROP, DISTANCE, RATE, STRESS, VINF, TRACTION, STRESSING, NUM_KEPT };
enum { MOST_ARRAYS = 12 };

/* Returns the number of the law in the order of kernels/stage.cl, or -1. */
static int LawOf(SlipFault fault)
{
  static const char *const laws[] = {"exponential_slip_weakening", "linear_slip_weakening", "rate_weakening",
                                     "constant"};

  for (int k = 0; k < 4; k++)
    if (!strcmp(fault->friction.law->name, laws[k])) return k;
  return -1;
}

/* Returns whether kernels compute this fault with these vectors, of which NULL does not count. */
static PetscBool Sticks(SlipFault fault, PetscInt n, const Vec x[])
{
  if (!fault->device.device || fault->layout.components != 1 || fault->layout.block != 3 || LawOf(fault) < 0)
    return PETSC_FALSE;
  if (fault->mesh.kind != &SlipFaultMeshGrid || fault->kind.oblique) return PETSC_FALSE; /* its weights are 1 */
  if (fault->kind.heals || fault->friction.healing || fault->kind.coupled || fault->loads.pressed) return PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++)
    if (x[k] && !SlipDeviceVecIs(x[k])) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Gets the numbers of the cells; copies them to the device once. */
static PetscErrorCode GetCells(SlipFault fault, Vec *cells)
{
  const PetscInt n = fault->mesh.n;
  PetscReal *const *field = fault->fields.cell;
  SlipFrictionCells friction;
  PetscReal *a;

  PetscFunctionBegin;
  if (!fault->device.sticking) {
    PetscCall(SlipFaultGetFriction(fault, 0, &friction));
    PetscCall(VecCreate(fault->comm, &fault->device.sticking));
    PetscCall(VecSetSizes(fault->device.sticking, NUM_KEPT * n, NUM_KEPT * n));
    PetscCall(VecSetType(fault->device.sticking, VECSLIPOPENCL));
    PetscCall(VecGetArrayWrite(fault->device.sticking, &a));
    for (PetscInt i = 0; i < n; i++) {
      a[RESIDUAL * n + i] = friction.residual[i];
      a[DROP * n + i] = friction.drop[i];
      a[DISTANCE * n + i] = friction.slip[i];
      a[RATE * n + i] = friction.rate[i];
      a[STRESS * n + i] = friction.stress[i];
      a[VINF * n + i] = field[FIELD_LOADING_RATE][i];
      a[TRACTION * n + i] = field[FIELD_INITIAL_TRACTION][i];
      a[STRESSING * n + i] = field[FIELD_STRESSING_RATE][i];
    }
    PetscCall(VecRestoreArrayWrite(fault->device.sticking, &a));
  }
  *cells = fault->device.sticking;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs a kernel, whose last `written` of n vectors it changes. `friction`: it evaluates friction; its law is then the
   first number, and the stored numbers of cells are the last vector. */
static PetscErrorCode Run(SlipFault fault, SlipDeviceKernel kernel, PetscBool friction, PetscInt numbers,
                          const PetscReal number[], PetscInt n, PetscInt written, const Vec x[], PetscInt results,
                          PetscReal result[])
{
  PetscReal with_law[MOST_ARRAYS], *unused;
  SlipArrays list[MOST_ARRAYS];
  PetscInt first = 0;

  PetscFunctionBegin;
  if (friction) with_law[first++] = LawOf(fault);
  for (PetscInt k = 0; k < numbers; k++) with_law[first + k] = number[k];
  for (PetscInt k = 0; k < n; k++) list[k] = (SlipArrays){.vec = x[k], .write = k < n - written ? NULL : &unused};
  if (friction) {
    list[n] = (SlipArrays){.vec = NULL};
    PetscCall(GetCells(fault, &list[n++].vec));
  }
  PetscCall(SlipDeviceArraysRun(kernel, fault->mesh.n, first + numbers, with_law, n, list, results,
                                kernel == KERNEL_STICK_SUMS ? results - 1 : results, result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Eliminate(SlipFault fault, const SlipStage *stage)
{
  const PetscReal theta = stage->theta, inertia = fault->kind.inertia ? fault->operators.mass / theta : 0;
  const PetscReal numbers[] = {inertia, theta, stage->explicit_part ? 1 : 0};
  const Vec x[] = {stage->base,    stage->explicit_part, fault->operators.vinf,
                   fault->stage.c, fault->stage.u0,      fault->stage.s0};

  PetscFunctionBegin;
  if (!Sticks(fault, 6, x))
    PetscCall((*HOST.eliminate)(fault, stage));
  else
    PetscCall(Run(fault, KERNEL_STICK_ELIMINATE, PETSC_FALSE, 3, numbers, 6, 3, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bound(SlipFault fault, Vec v, Vec q, Vec dq)
{
  const PetscReal numbers[] = {fault->stage.theta, dq ? 1 : 0};
  const Vec x[] = {v, fault->stage.s0, q, dq};

  PetscFunctionBegin;
  if (!Sticks(fault, 4, x))
    PetscCall((*HOST.bound)(fault, v, q, dq));
  else
    PetscCall(Run(fault, KERNEL_STICK_BOUND, PETSC_TRUE, 2, numbers, 4, 2, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StartSlope(SlipFault fault, Vec dq)
{
  const Vec x[] = {fault->stage.s0, dq};

  PetscFunctionBegin;
  if (!Sticks(fault, 2, x))
    PetscCall((*HOST.start_slope)(fault, dq));
  else
    PetscCall(Run(fault, KERNEL_STICK_START_SLOPE, PETSC_TRUE, 1, &fault->stage.theta, 2, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Lift(SlipFault fault, Vec v, Vec w)
{
  const Vec x[] = {v, fault->stage.u0, fault->stage.s0, w};

  PetscFunctionBegin;
  if (!Sticks(fault, 4, x))
    PetscCall((*HOST.lift)(fault, v, w));
  else
    PetscCall(Run(fault, KERNEL_STICK_LIFT, PETSC_FALSE, 1, &fault->stage.theta, 4, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Smooth(SlipFault fault, const SlipFrictionCells *friction, Vec w, Vec relative, Vec force, Vec F)
{
  const Vec x[] = {w, relative, force, F};

  PetscFunctionBegin;
  if (!Sticks(fault, 4, x))
    PetscCall((*HOST.smooth)(fault, friction, w, relative, force, F));
  else
    PetscCall(Run(fault, KERNEL_STICK_SMOOTH, PETSC_FALSE, 0, NULL, 4, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddReaction(SlipFault fault, PetscReal a, Vec r, Vec F)
{
  const Vec x[] = {r, F};

  PetscFunctionBegin;
  if (!Sticks(fault, 2, x))
    PetscCall((*HOST.add_reaction)(fault, a, r, F));
  else
    PetscCall(Run(fault, KERNEL_STICK_ADD_REACTION, PETSC_FALSE, 1, &a, 2, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveMass(SlipFault fault, Vec k)
{
  const PetscReal mass = fault->kind.inertia ? fault->operators.mass : 0;
  const Vec x[] = {k};

  PetscFunctionBegin;
  if (!Sticks(fault, 1, x))
    PetscCall((*HOST.solve_mass)(fault, k));
  else
    PetscCall(Run(fault, KERNEL_STICK_MASS, PETSC_FALSE, 1, &mass, 1, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Strength(SlipFault fault, PetscReal t, Vec w, Vec q)
{
  const Vec x[] = {w, q};

  PetscFunctionBegin;
  if (!Sticks(fault, 2, x))
    PetscCall((*HOST.strength)(fault, t, w, q));
  else
    PetscCall(Run(fault, KERNEL_STICK_STRENGTH, PETSC_TRUE, 0, NULL, 2, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Kick(SlipFault fault, PetscReal t, PetscReal a, Vec g, Vec eta, Vec w, PetscBool *ok)
{
  const PetscReal numbers[] = {fault->operators.mass, a, eta ? 1 : 0};
  const Vec x[] = {g, fault->operators.vinf, eta, w};

  PetscFunctionBegin;
  if (fault->friction.law->by_rate || !Sticks(fault, 4, x))
    PetscCall((*HOST.kick)(fault, t, a, g, eta, w, ok));
  else
    PetscCall(Run(fault, KERNEL_STICK_KICK, PETSC_TRUE, 3, numbers, 4, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Drift(SlipFault fault, PetscReal t, PetscReal h, Vec w)
{
  const Vec x[] = {fault->operators.vinf, w};

  PetscFunctionBegin;
  if (!Sticks(fault, 2, x))
    PetscCall((*HOST.drift)(fault, t, h, w));
  else
    PetscCall(Run(fault, KERNEL_STICK_DRIFT, PETSC_FALSE, 1, &h, 2, 1, x, 0, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Mode(SlipFault fault, PetscReal t, Vec w, Vec mode, Vec kx, Vec nx, PetscReal sum[])
{
  const Vec x[] = {w, mode, kx};

  PetscFunctionBegin;
  if (nx || !Sticks(fault, 3, x))
    PetscCall((*HOST.mode)(fault, t, w, mode, kx, nx, sum));
  else
    PetscCall(Run(fault, KERNEL_STICK_MODE, PETSC_TRUE, 1, &fault->operators.mass, 3, 0, x, FAULT_NUM_MODE, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Estimates(SlipFault fault, Vec w, Vec error, Vec derivative, PetscReal sum[])
{
  const PetscReal given[] = {error ? 1 : 0, derivative ? 1 : 0};
  const Vec x[] = {w, error, derivative};

  PetscFunctionBegin;
  if (!Sticks(fault, 3, x))
    PetscCall((*HOST.estimates)(fault, w, error, derivative, sum));
  else
    PetscCall(Run(fault, KERNEL_STICK_ESTIMATES, PETSC_FALSE, 2, given, 3, 0, x, FAULT_NUM_ESTIMATES, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Step(SlipFault fault, PetscReal t, Vec w, Vec e, Vec ku, PetscReal sum[])
{
  const Vec x[] = {w, e, ku};

  PetscFunctionBegin;
  if (!Sticks(fault, 3, x))
    PetscCall((*HOST.step)(fault, t, w, e, ku, sum));
  else
    PetscCall(Run(fault, KERNEL_STICK_STEP, PETSC_TRUE, 1, &fault->operators.mass, 3, 0, x, STEP_SUMS, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Timing(SlipFault fault, Vec w, Vec e, Vec d, PetscReal sum[])
{
  const Vec x[] = {w, e, d};

  PetscFunctionBegin;
  if (!Sticks(fault, 3, x))
    PetscCall((*HOST.timing)(fault, w, e, d, sum));
  else
    PetscCall(Run(fault, KERNEL_STICK_TIMING, PETSC_FALSE, 1, &fault->operators.mass, 3, 0, x, TIMING_SUMS, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Course(SlipFault fault, PetscReal t, Vec w, PetscReal sum[])
{
  const Vec x[] = {w, w, w};

  PetscFunctionBegin;
  if (!Sticks(fault, 3, x))
    PetscCall((*HOST.course)(fault, t, w, sum));
  else
    PetscCall(Run(fault, KERNEL_STICK_TIMING, PETSC_FALSE, 1, &fault->operators.mass, 3, 0, x, TIMING_SUMS, sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the shear load by its copy on the device, which is renewed when the load has changed. */
static PetscErrorCode ShearThere(SlipFault fault, Vec *shear)
{
  SlipFaultDevice *d = &fault->device;
  PetscObjectState state;
  PetscObjectId id;

  PetscFunctionBegin;
  PetscCall(PetscObjectGetId((PetscObject)*shear, &id));
  PetscCall(PetscObjectStateGet((PetscObject)*shear, &state));
  if (!d->shear) {
    PetscCall(VecDuplicate(fault->critical.uc, &d->shear));
    d->shear_id = 0;
  }
  if (id != d->shear_id || state != d->shear_state) PetscCall(VecCopy(*shear, d->shear));
  d->shear_id = id;
  d->shear_state = state;
  *shear = d->shear;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- both kinds of cells ---- */

static PetscErrorCode Shear(SlipFault fault, PetscReal t, Vec *shear)
{
  PetscFunctionBegin;
  if (SlipFaultDeviceBalances(fault))
    PetscCall(SlipFaultDeviceShear(fault, t, shear));
  else {
    PetscCall((*HOST.shear)(fault, t, shear));
    if (*shear && fault->device.device) PetscCall(ShearThere(fault, shear));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sums(SlipFault fault, PetscReal t, Vec w, Vec force, PetscReal sum[], PetscReal *max_v)
{
  const PetscReal numbers[] = {fault->loads.shears ? 1 : 0, fault->loads.origin + t};
  const Vec x[] = {w, force};
  PetscReal result[FAULT_NUM_SUMS + 1];

  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w) && SlipDeviceVecIs(force))
    PetscCall(SlipFaultDeviceSums(fault, t, w, force, sum, max_v));
  else if (Sticks(fault, 2, x)) {
    PetscCall(Run(fault, KERNEL_STICK_SUMS, PETSC_TRUE, 2, numbers, 2, 0, x, FAULT_NUM_SUMS + 1, result));
    PetscCall(PetscArraycpy(sum, result, FAULT_NUM_SUMS));
    *max_v = result[FAULT_NUM_SUMS];
  } else
    PetscCall((*HOST.sums)(fault, t, w, force, sum, max_v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Powers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3], PetscReal friction[])
{
  const PetscReal known = r ? 1 : 0;
  PetscReal lost;
  Vec rel, hv;

  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w)) { /* all cells on the device slide, so that r is -q(w) sign(v) */
    PetscCall(SlipFaultDevicePowers(fault, t, w, power));
    if (friction && fault->mesh.faults == 1) friction[0] = power[2];
    if (friction && fault->mesh.faults > 1) PetscCall(SlipFaultDeviceShares(fault, t, w, friction, NULL, NULL, NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (fault->mesh.faults > 1 || !Sticks(fault, 2, (const Vec[]){w, r})) {
    PetscCall((*HOST.powers)(fault, t, w, r, power, friction));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultGetWork(fault, &rel));
  PetscCall(SlipFaultGetWork(fault, &hv));
  PetscCall(SlipFaultGetRate(fault, w, rel));
  PetscCall(VecAXPY(rel, -1, fault->operators.vinf));
  PetscCall(SlipFaultDamping(fault, t, rel, hv));
  PetscCall(Run(fault, KERNEL_STICK_POWERS, PETSC_TRUE, 1, &known, 4, 0, (const Vec[]){w, rel, hv, r}, 3, power));
  if (friction) friction[0] = power[2];
  PetscCall(SlipFaultGetLost(fault, t, w, rel, &lost));
  PetscCall(SlipFaultRestoreWork(fault, &hv));
  PetscCall(SlipFaultRestoreWork(fault, &rel));
  power[0] += lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- cells that always slide ---- */

static PetscErrorCode Rates(SlipFault fault, PetscReal t, Vec w, Vec F)
{
  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w))
    PetscCall(SlipFaultDeviceRates(fault, t, w, F));
  else
    PetscCall((*HOST.rates)(fault, t, w, F));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Compliance(SlipFault fault, Vec w, PetscReal *most)
{
  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w))
    PetscCall(SlipFaultDeviceCompliance(fault, w, most));
  else
    PetscCall((*HOST.compliance)(fault, w, most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Opened(SlipFault fault, PetscReal t, PetscInt *opened)
{
  PetscFunctionBegin;
  if (SlipFaultDeviceBalances(fault))
    PetscCall(SlipFaultDeviceOpen(fault, t, opened));
  else
    PetscCall((*HOST.opened)(fault, t, opened));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bare(SlipFault fault, PetscReal t, Vec w, Vec bare, PetscInt *more, PetscReal *least)
{
  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w))
    PetscCall(SlipFaultDeviceBare(fault, t, w, bare, more, least));
  else
    PetscCall((*HOST.bare)(fault, t, w, bare, more, least));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Slip(SlipFault fault, PetscReal dt, Vec w, Vec u, PetscReal *largest)
{
  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w) && SlipDeviceVecIs(u))
    PetscCall(SlipFaultDeviceSlip(fault, dt, w, u, largest));
  else
    PetscCall((*HOST.slip)(fault, dt, w, u, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Outside(SlipFault fault, Vec w, const PetscReal bound[], PetscInt *outside)
{
  PetscFunctionBegin;
  if (SlipFaultOnDevice(fault, w))
    PetscCall(SlipFaultDeviceOutside(fault, w, bound[fault->layout.displacement], bound[fault->layout.state], outside));
  else
    PetscCall((*HOST.outside)(fault, w, bound, outside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start is not critical there. */
static PetscErrorCode Moments(SlipFault fault, PetscReal t, Vec w, PetscReal rate[], PetscReal slip[])
{
  const PetscInt n = fault->mesh.faults;
  PetscReal *loading;

  PetscFunctionBegin;
  if (!SlipFaultOnDevice(fault, w)) {
    PetscCall((*HOST.moments)(fault, t, w, rate, slip));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(n, &loading));
  PetscCall(SlipFaultDeviceShares(fault, t, w, NULL, rate, slip, loading));
  for (PetscInt k = 0; k < n; k++) slip[k] += (fault->loads.origin + t) * loading[k];
  PetscCall(PetscFree(loading));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Leaves r NULL, as Powers() computes without it. */
static PetscErrorCode Traction(SlipFault fault, PetscReal t, Vec w, Vec *r)
{
  PetscFunctionBegin;
  if (!SlipFaultOnDevice(fault, w)) PetscCall((*HOST.traction)(fault, t, w, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- records ---- */

enum { GROUND_AT_ONCE = 12 }; /* as many numbers of the ground as kernels/record.cl sums at once */

/* Gets the state, the strength and the normal stress, from which the traction follows. */
static PetscErrorCode Look(SlipFault fault, PetscReal t, Vec w, SlipFaultLook *look)
{
  const int m = (int)look->m, n = (int)fault->mesh.n, c = (int)fault->layout.components;
  const PetscInt block = fault->layout.block, width = block + 2;
  const PetscReal eta = fault->balance.eta;
  SlipDevice device = fault->device.device;
  SlipDeviceMemory cells, state;
  PetscReal *row, *value = look->values;
  PetscBool changing;
  int changes;

  PetscFunctionBegin;
  if (!SlipFaultOnDevice(fault, w)) {
    PetscCall((*HOST.look)(fault, t, w, look));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1((size_t)m * (size_t)width, &row));
  if (!look->places) {
    for (PetscInt k = 0; k < m; k++) row[k] = (PetscReal)look->cell[k];
    PetscCall(SlipFaultDevicePut(fault, (size_t)m, row, "stations", &look->places));
    PetscCall(SlipFaultDevicePut(fault, (size_t)m * (size_t)width, NULL, "stations", &look->out));
  }
  PetscCall(SlipFaultDeviceCells(fault, t, w, &cells, &changing));
  changes = changing;
  PetscCall(SlipDeviceVecRead(w, &state));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(m),     SLIP_DEVICE_ARG(n),       SLIP_DEVICE_ARG(c),
                                  SLIP_DEVICE_ARG(eta),   SLIP_DEVICE_ARG(changes), SLIP_DEVICE_ARG(look->places),
                                  SLIP_DEVICE_ARG(cells), SLIP_DEVICE_ARG(state),   SLIP_DEVICE_ARG(look->out)};

    PetscCall(SlipDeviceRun(device, KERNEL_FAULT_LOOK, (size_t)m, 1, 9, args));
  }
  PetscCall(SlipDeviceFetchNumbers(device, (size_t)m * (size_t)width, look->out, row));
  for (PetscInt k = 0; k < m; k++, value += block + c + 1) {
    const PetscReal *from = row + width * k, speed = SlipFaultLength(fault, from), strength = from[block];

    PetscCall(PetscArraycpy(value, from, block));
    for (PetscInt j = 0; j < c; j++)
      value[block + j] = c == 1 ? (from[0] > 0 ? -strength : strength) : speed > 0 ? -strength * (from[j] / speed) : 0;
    value[block + c] = changes ? from[block + 1] : fault->loads.normal[look->cell[k]];
  }
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends the matrix once, by numbers of the ground. */
static PetscErrorCode Ground(SlipFault fault, Vec w, Vec start, SlipFaultLook *look, PetscReal moved[],
                             PetscReal moves[])
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components;
  const size_t rows = (size_t)look->m, columns = (size_t)(c * n);
  PetscReal results[2 * GROUND_AT_ONCE], *a;
  SlipDeviceMemory cells, state, u0;

  PetscFunctionBegin;
  if (!SlipFaultOnDevice(fault, w)) {
    PetscCall((*HOST.ground)(fault, w, start, look, moved, moves));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!look->places) {
    PetscCall(PetscMalloc1(rows * columns, &a));
    for (size_t i = 0; i < columns; i++)
      for (size_t k = 0; k < rows; k++) a[k * columns + i] = look->matrix[i * rows + k];
    PetscCall(SlipFaultDevicePut(fault, rows * columns, a, "stations of the ground", &look->places));
    PetscCall(PetscFree(a));
  }
  PetscCall(SlipFaultDeviceCells(fault, 0, NULL, &cells, NULL));
  PetscCall(SlipDeviceVecRead(w, &state));
  PetscCall(SlipDeviceVecRead(start, &u0));
  for (int first = 0; first < look->m; first += GROUND_AT_ONCE) {
    const int count = (int)PetscMin(GROUND_AT_ONCE, look->m - first);
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),
                                  SLIP_DEVICE_ARG(c),
                                  SLIP_DEVICE_ARG(first),
                                  SLIP_DEVICE_ARG(count),
                                  SLIP_DEVICE_ARG(look->places),
                                  SLIP_DEVICE_ARG(u0),
                                  SLIP_DEVICE_ARG(cells),
                                  SLIP_DEVICE_ARG(state)};

    PetscCall(
      SlipDeviceReduce(fault->device.device, KERNEL_FAULT_GROUND, (size_t)n, 8, args, 2 * count, 2 * count, results));
    PetscCall(PetscArraycpy(moved + first, results, count));
    PetscCall(PetscArraycpy(moves + first, results + count, count));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultLookDestroy(SlipFault fault, SlipFaultLook *look)
{
  PetscFunctionBegin;
  if (look->places) PetscCall(SlipDeviceFree(fault->device.device, &look->places));
  if (look->out) PetscCall(SlipDeviceFree(fault->device.device, &look->out));
  PetscCall(PetscFree(look->values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Rupture(SlipFault fault, PetscInt nodes, const Vec node[], const PetscReal share[],
                              PetscReal begin, PetscReal dt, Vec push, Vec rupture, PetscBool *unbroken)
{
  const int n = (int)fault->mesh.n, c = (int)fault->layout.components, count = (int)nodes;
  const PetscReal bound = fault->options.value[FAULT_EVENT_RATE];
  SlipDeviceMemory state[3], times;
  PetscReal at[3];

  PetscFunctionBegin;
  if (!SlipFaultOnDevice(fault, node[nodes - 1])) {
    PetscCall((*HOST.rupture)(fault, nodes, node, share, begin, dt, push, rupture, unbroken));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt last = PetscMin(k, nodes - 1);

    at[k] = share[last];
    PetscCall(SlipDeviceVecRead(node[last], &state[k]));
  }
  PetscCall(SlipDeviceVecChange(rupture, &times));
  {
    const SlipDeviceArg args[] = {SLIP_DEVICE_ARG(n),        SLIP_DEVICE_ARG(c),        SLIP_DEVICE_ARG(count),
                                  SLIP_DEVICE_ARG(bound),    SLIP_DEVICE_ARG(begin),    SLIP_DEVICE_ARG(dt),
                                  SLIP_DEVICE_ARG(at[0]),    SLIP_DEVICE_ARG(at[1]),    SLIP_DEVICE_ARG(at[2]),
                                  SLIP_DEVICE_ARG(state[0]), SLIP_DEVICE_ARG(state[1]), SLIP_DEVICE_ARG(state[2]),
                                  SLIP_DEVICE_ARG(times)};

    PetscCall(SlipDeviceRun(fault->device.device, KERNEL_FAULT_RUPTURE, (size_t)n, 1, 13, args));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultCellsOps SlipFaultCellsOpenCL = {
  Eliminate, Bound,      StartSlope, Lift,   Smooth,  AddReaction, SolveMass, Kick,      Drift,  Strength,
  Rates,     Compliance, Shear,      Opened, Bare,    Sums,        Mode,      Estimates, Powers, Step,
  Timing,    Course,     Moments,    Slip,   Outside, Traction,    Look,      Ground,    Rupture};

/* Chooses the row; after the device has room for the fault. */
void SlipFaultCellsChoose(SlipFault fault)
{
  fault->cell_ops = fault->device.device ? &SlipFaultCellsOpenCL : &SlipFaultCellsHost;
}
