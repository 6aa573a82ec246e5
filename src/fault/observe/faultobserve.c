/* Computes, from a state of the fault, what observers and controllers use: sums over the cells, energies and powers. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <petsc/private/petscimpl.h> /* PetscObjectStateGet() */
#include <petscblaslapack.h>
#include <slipcompat.h>

/* Adds this rank's sums for the motion x, displacements or rates [n], with kx = K x, nx = Kn x or NULL, and w the state
   whose friction weakens. The strength that x takes away by changing normal stress acts as stiffness does. */
PetscErrorCode SlipFaultHostMode(SlipFault fault, PetscReal t, Vec w, Vec x, Vec kx, Vec nx, PetscReal sum[])
{
  SlipFrictionCells friction;
  const PetscReal *a, *b, *f, *rise;
  const SlipArrays arrays[] = {{w, .read = &a}, {x, .read = &b}, {kx, .read = &f}, {nx, .read = &rise}};
  const int n = nx ? 4 : 3;
  const PetscInt c = fault->layout.components;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  PetscCall(SlipArraysGet(n, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal weight = fault->mesh.weight[i];
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, a + SlipFaultStateAt(fault, i), SlipFaultSpeed(fault, a, i), &mu, &ds, &dv);
    sum[MODE_STIFFNESS] += SlipFaultDot(fault, b + c * i, f + c * i);
    if (nx && friction.stress[i] > 0) sum[MODE_STIFFNESS] += SlipFaultLength(fault, b + c * i) * mu * weight * rise[i];
    sum[MODE_WEAKENING] -= ds * (weight * friction.stress[i]) * SlipFaultDot(fault, b + c * i, b + c * i);
    sum[MODE_INERTIA] += fault->operators.mass * weight * SlipFaultDot(fault, b + c * i, b + c * i);
  }
  PetscCall(SlipArraysRestore(n, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the sums for the moving cells, or for uc where all cells rest. x is the inner rate of an explicit step, which
   costs no product, else the rate in w. The sums are computed only when the state or its time has changed. */
static PetscErrorCode GetMode(SlipFault fault, PetscReal t, Vec w, PetscBool moves, const SlipFaultMode **mode)
{
  SlipFaultMode *c = &fault->known.mode;
  SlipFaultMoment now;
  PetscBool same, found = PETSC_FALSE;
  Vec x, kx, nx = fault->kind.coupled ? fault->cells : NULL;

  PetscFunctionBegin;
  *mode = c;
  PetscCall(SlipFaultStateUnchanged(fault, t, w, &c->moment, &now, &same));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &x));
  PetscCall(SlipFaultGetWork(fault, &kx));
  if (moves) PetscCall(SlipFaultInnerRate(fault, t, w, x, kx, nx, &found));
  if (!found && moves) PetscCall(SlipFaultGetRate(fault, w, x));
  if (!found && !moves) PetscCall(VecCopy(fault->critical.uc, x));
  if (!found && fault->device.device && nx) { /* nx is not on the device */
    PetscCall(SlipElasticApply(fault->medium, x, kx, NULL));
    PetscCall(SlipElasticApply(fault->medium, x, NULL, nx));
  } else if (!found)
    PetscCall(SlipElasticApply(fault->medium, x, kx, nx));
  PetscCall(PetscArrayzero(c->sum, FAULT_NUM_MODE));
  PetscCall((*fault->cell_ops->mode)(fault, t, w, x, kx, nx, c->sum));
  PetscCall(SlipFaultRestoreWork(fault, &kx));
  PetscCall(SlipFaultRestoreWork(fault, &x));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->sum, FAULT_NUM_MODE, MPIU_REAL, MPIU_SUM, fault->comm));
  c->moment = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipFaultKeepEstimates - adds up the integrator's error estimates for observations

  Collective. w: state after the attempt; error, derivative: the attempt's local error and dw/dt at its end, or NULL. A
  cell that has just stopped has no derivative.
*/
PetscErrorCode SlipFaultKeepEstimates(SlipFault fault, Vec w, Vec error, Vec derivative)
{
  SlipFaultEstimates *c = &fault->known.estimates;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(c, sizeof(*c)));
  if (!error && !derivative) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*fault->cell_ops->estimates)(fault, w, error, derivative, c->sum));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->sum, FAULT_NUM_ESTIMATES, MPIU_REAL, MPIU_SUM, fault->comm));
  c->known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the fastest relaxation: of the stress on a cell by its own slip ---- */

#define POWER_PRODUCTS 30 /* gives the largest eigenvalue of the reference faults to 1 % */

/* Finds the largest eigenvalue of K over the weights, once a run, by power iteration. It starts from a short wave
   without symmetry, which is the same on any number of ranks. */
PetscErrorCode SlipFaultLargestEigenvalue(SlipFault fault, PetscReal *largest)
{
  SlipFaultBalance *b = &fault->balance;
  const PetscInt c = fault->layout.components;
  PetscReal *a, norm;
  Vec x, y;

  PetscFunctionBegin;
  *largest = b->stiffest;
  if (b->stiffest > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &x));
  PetscCall(SlipFaultGetWork(fault, &y));
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0; k < c; k++) {
      const PetscInt number = c * SlipFaultMeshRow(&fault->mesh, i) + k;

      a[c * i + k] = PetscSinReal(2 + (PetscReal)3.7 * (PetscReal)number);
    }
  PetscCall(VecRestoreArrayWrite(x, &a));
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
  PetscCall(VecNormalize(x, NULL));
  for (PetscInt k = 0; k < POWER_PRODUCTS; k++) {
    PetscCall(SlipElasticApply(fault->medium, x, y, NULL));
    PetscCall(VecGetArray(y, &a));
    for (PetscInt i = 0; i < c * fault->mesh.n; i++) a[i] /= fault->mesh.weight[i / c];
    PetscCall(VecRestoreArray(y, &a));
    PetscCall(VecNorm(y, NORM_2, &norm));
    *largest = b->stiffest = norm;
    if (norm == 0) break;
    PetscCall(VecAXPBY(x, 1 / norm, 0, y));
  }
  PetscCall(SlipProductsPop());
  PetscCall(SlipFaultRestoreWork(fault, &y));
  PetscCall(SlipFaultRestoreWork(fault, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* dv/dtau = 1/(eta + sigma dmu/dv) from the balance of cell i; with two components, along v. v: rate; force: K u; load:
   the shear load. The balance shows without an exponential whether the law's short cut holds. */
static PetscReal Compliance(const SlipFault fault, const SlipFrictionCells *friction, PetscInt i, const PetscReal s[],
                            const PetscReal v[], const PetscReal load[], const PetscReal force[])
{
  const PetscReal eta = fault->balance.eta, rate = SlipFaultLength(fault, v);
  const PetscReal direct = SlipFrictionDirect(friction, i) * friction->stress[i];
  PetscReal mu, ds, dv, strength, tau[3] = {0, 0, 0};

  for (PetscInt k = 0; k < fault->layout.components; k++)
    tau[k] = (load[k] - force[k]) / fault->mesh.weight[i] +
             eta * (fault->fields.cell[FIELD_LOADING_RATE][i] * SlipFaultAlong(fault, i)[k]);
  strength = SlipFaultLength(fault, tau) - eta * rate;

  if (strength > 10 * direct) return rate / (eta * rate + direct);
  SlipFrictionEvaluate(friction, i, s, rate, &mu, &ds, &dv);
  return 1 / (eta + friction->stress[i] * dv);
}

enum { COMPLIANCES = 64 };

/* Takes n cells of one component and puts each compliance by the short cut into largest, if it is the largest so far in
   its place. Returns the number of cells for which the short cut does not hold. */
SLIP_VECTOR static PetscInt Compliances(PetscInt n, PetscReal eta, const PetscReal *restrict v,
                                        const PetscReal *restrict load, const PetscReal *restrict force,
                                        const PetscReal *restrict weight, const PetscReal *restrict vinf,
                                        const PetscReal *restrict direct, PetscReal *restrict largest)
{
  PetscInt others = 0;

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal rate = PetscAbsReal(v[i]), tau = (load[i] - force[i]) / weight[i] + eta * vinf[i];
    const PetscReal holds = PetscAbsReal(tau) - eta * rate > 10 * direct[i] ? 1 : 0;
    const PetscReal compliance = holds * rate / (eta * rate + direct[i]);

    largest[i] = compliance > largest[i] ? compliance : largest[i];
    others += holds == 0;
  }
  return others;
}

PetscErrorCode SlipFaultHostCompliance(SlipFault fault, Vec w, PetscReal *most)
{
  SlipFaultBalance *b = &fault->balance;
  SlipFrictionCells friction;
  const PetscReal *a, *v, *force, *load, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  const PetscInt c = fault->layout.components;
  PetscReal largest[COMPLIANCES] = {0};
  const SlipFaultLoad *of_now;
  const SlipArrays arrays[] = {{w, .read = &a}, {b->rate, .read = &v}, {b->force, .read = &force}};

  PetscFunctionBegin;
  *most = 0;
  PetscCall(SlipFaultGetLoad(fault, b->time, &of_now));
  if (fault->coupling.balanced) /* the normal stress of that right-hand side saves a product in each attempt */
    PetscCall(SlipFaultCoupledFriction(fault, b->time, 0, &friction));
  else
    PetscCall(SlipFaultGetFrictionOf(fault, b->time, w, &friction));
  PetscCall(SlipArraysGet(3, arrays));
  PetscCall(VecGetArrayRead(of_now->shear, &load));
  for (PetscInt i = 0; i < fault->mesh.n; i += COMPLIANCES) {
    const PetscInt n = PetscMin(COMPLIANCES, fault->mesh.n - i);

    if (b->direct && c == 1 && !b->creeps &&
        !Compliances(n, b->eta, v + i, load + i, force + i, fault->mesh.weight + i, vinf + i, b->direct + i, largest))
      continue;
    for (PetscInt k = i; k < i + n; k++)
      if (!b->creeps || !b->creeps[k])
        *most = PetscMax(*most, Compliance(fault, &friction, k, a + SlipFaultStateAt(fault, k), v + c * k, load + c * k,
                                           force + c * k));
  }
  for (PetscInt k = 0; k < COMPLIANCES; k++) *most = PetscMax(*most, largest[k]);
  PetscCall(VecRestoreArrayRead(of_now->shear, &load));
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipProblemOps.relaxation, from the rates of the last right-hand side, as w has the step's first ones while it is
   judged; 0 where rates follow from momentum. Where friction sticks, it is the rate at which sliding cells relax. */
PetscErrorCode SlipFaultRelaxation(TS ts, Vec w, PetscReal *relaxation, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const SlipFaultBalance *b = &fault->balance;
  PetscReal most, stiffest;

  PetscFunctionBegin;
  (void)ts;
  *relaxation = 0;
  if (fault->kind.inertia ||
      !(fault->friction.law->always_slides ? b->known
                                           : fault->problem.steps.any_integrator || fault->problem.sides.side))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultLargestEigenvalue(fault, &stiffest));
  if (!fault->friction.law->always_slides) {
    if (!b->resting) *relaxation = stiffest / b->eta;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall((*fault->cell_ops->compliance)(fault, w, &most));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  *relaxation = stiffest * most;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills in the numbers that follow from the sums. */
static PetscErrorCode KnowSums(SlipFault fault, PetscReal t, Vec w, SlipFaultNumbers *known)
{
  const PetscReal N = (PetscReal)fault->mesh.N;
  const SlipFaultSums *s;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetSums(fault, t, w, &s));
  known->velocity = s->sum[SUM_V] / N;
  known->rate = s->sum[SUM_ABS_V] / N;
  known->peak = s->max_v;
  known->total_rate = s->sum[SUM_ABS_V];
  known->displacement = s->sum[SUM_U] / N;
  known->slip = s->sum[SUM_S] / N;
  known->sliding = s->sum[SUM_SLIDING] / N;
  known->energy = s->sum[SUM_U_KU];
  known->kinetic = fault->operators.mass * s->sum[SUM_V2];
  known->power = s->sum[SUM_V_KU];
  known->strength = s->sum[SUM_STRENGTH] / N;
  known->weakening = s->sum[SUM_WEAKENING] / N;
  known->push = s->sum[SUM_PUSH] / N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the values of the rows of SlipObservations in the state w. */
PetscErrorCode SlipFaultObserve(SlipFault fault, PetscReal t, Vec w, PetscInt n, const PetscInt row[],
                                PetscReal value[])
{
  const PetscReal N = (PetscReal)fault->mesh.N;
  const SlipFaultMode *mode = NULL;
  PetscBool undamped, sums = PETSC_FALSE;
  SlipFaultNumbers known = {.tstar = fault->operators.tstar,
                            .velocity_scale = fault->options.value[FAULT_VELOCITY_SCALE],
                            .mean_dc = fault->critical.mean_dc,
                            .mean_uc = fault->critical.mean_uc,
                            .mean_q0 = fault->critical.mean_q0,
                            .mean_drop = fault->critical.mean_drop,
                            .drop_slip = fault->critical.drop_slip,
                            .critical_energy = fault->critical.energy,
                            .mass = fault->operators.mass,
                            .estimated = fault->known.estimates.known,
                            .slip_error = fault->known.estimates.sum[ESTIMATE_SLIP_ERROR] / N,
                            .growth = fault->known.estimates.sum[ESTIMATE_GROWTH],
                            .step_limit = fault->known.step_limit,
                            .solve_cost = fault->known.solve_cost};

  PetscFunctionBegin;
  PetscCall(PetscStrcmp(fault->kind.viscosity, "none", &undamped));
  known.damping_ratio = undamped ? 0 : fault->options.value[FAULT_DAMPING_RATIO];
  if (fault->critical.inertia > 0) {
    known.critical_stiffness = fault->critical.energy / fault->critical.inertia;
    known.critical_weakening = fault->critical.weakening / fault->critical.inertia;
  }
  for (PetscInt i = 0; i < n; i++) {
    if (!(SlipObservations[row[i]].reads & SLIP_READS_STIFFNESS))
      sums = PETSC_TRUE;
    else
      PetscCall(SlipFaultRelaxation(NULL, w, &known.relaxation, fault));
  }
  if (sums) PetscCall(KnowSums(fault, t, w, &known));
  for (PetscInt i = 0; i < n && !mode; i++)
    if (SlipObservations[row[i]].reads & SLIP_READS_MODE) PetscCall(GetMode(fault, t, w, known.peak != 0, &mode));
  if (mode && mode->sum[MODE_INERTIA] > 0) {
    known.mode_stiffness = mode->sum[MODE_STIFFNESS] / mode->sum[MODE_INERTIA];
    known.mode_weakening = mode->sum[MODE_WEAKENING] / mode->sum[MODE_INERTIA];
  }
  for (PetscInt i = 0; i < n; i++) value[i] = (*SlipObservations[row[i]].fault)(&known);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the power that the medium loses beside the damping of the rate rel; it is cached for several observers. */
PetscErrorCode SlipFaultGetLost(SlipFault fault, PetscReal t, Vec w, Vec rel, PetscReal *lost)
{
  SlipFaultLost *c = &fault->known.lost;
  SlipFaultMoment now;
  PetscBool same;
  Vec u;

  PetscFunctionBegin;
  PetscCall(SlipFaultStateUnchanged(fault, t, w, &c->moment, &now, &same));
  if (!same) {
    PetscCall(SlipFaultGetWork(fault, &u));
    PetscCall(SlipFaultGetDisplacement(fault, w, u));
    PetscCall(SlipElasticGetPower(fault->medium, t, u, rel, &c->power));
    PetscCall(SlipFaultRestoreWork(fault, &u));
    c->moment = now;
  }
  *lost = c->power;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the powers where friction sticks, and caches those of a step's end. States within a step, for which there is no
   balance, do not replace them. */
static PetscErrorCode GetStickingPowers(SlipFault fault, PetscReal t, Vec w, PetscReal power[3], PetscReal friction[])
{
  SlipFaultPowers *c = &fault->known.powers;
  SlipFaultMoment now;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipFaultStateUnchanged(fault, t, w, &c->moment, &now, &same));
  if (same && !friction) {
    PetscCall(PetscArraycpy(power, c->power, 3));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultStickingPowers(fault, t, w, NULL, power, friction));
  if (!fault->balance.known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArraycpy(c->power, power, 3));
  c->moment = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to sum this rank's part of x . y times sign; BLAS adds many numbers at a time. */
static PetscErrorCode AddProducts(Vec x, Vec y, PetscReal sign, PetscReal *sum)
{
  const PetscReal *a, *b;
  const SlipArrays arrays[] = {{x, .read = &a}, {y, .read = &b}};
  const PetscBLASInt one = 1;
  PetscBLASInt n;
  PetscInt size;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(x, &size));
  PetscCall(PetscBLASIntCast(size, &n));
  PetscCall(SlipArraysGet(2, arrays));
  *sum += sign * BLASdot_(&n, a, &one, b, &one);
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultHostPowers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3], PetscReal friction[])
{
  const SlipFaultMesh *mesh = &fault->mesh;
  Vec rel, hv, q = fault->cells;
  const PetscInt c = fault->layout.components;
  const PetscReal *a, *f;
  PetscReal lost = 0;
  PetscBool at_once, along;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(power, 3));
  PetscCall(SlipElasticRests(fault->medium, &at_once));
  if (r || !fault->problem.steps.any_integrator || fault->friction.law->always_slides || fault->device.device)
    at_once = PETSC_FALSE;
  if (at_once) {
    PetscCall(GetStickingPowers(fault, t, w, power, friction));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultGetWork(fault, &rel));
  PetscCall(SlipFaultGetWork(fault, &hv));
  PetscCall(SlipFaultGetRate(fault, w, rel));
  along = r && c == 1 && !friction && !fault->device.device ? PETSC_TRUE : PETSC_FALSE;
  if (along) PetscCall(AddProducts(rel, r, -1, &power[2]));
  PetscCall(VecAXPY(rel, -1, fault->operators.vinf));
  PetscCall(SlipFaultDamping(fault, t, rel, hv));
  if (!r) PetscCall(SlipFaultStrength(fault, t, w, q));
  PetscCall(AddProducts(rel, hv, 1, &power[0]));
  PetscCall(AddProducts(fault->operators.vinf, hv, 1, &power[1]));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(r ? r : q, &f));
  if (friction) PetscCall(PetscArrayzero(friction, mesh->faults));
  for (PetscInt i = 0; i < mesh->n && !along; i++) {
    const PetscReal *v = a + SlipFaultRateAt(fault, i);
    const PetscReal share = r ? -SlipFaultDot(fault, v, f + c * i) : SlipFaultLength(fault, v) * f[i];

    power[2] += share;
    if (friction) friction[SlipFaultMeshFaultOf(mesh, SlipFaultMeshRow(mesh, i))] += share;
  }
  PetscCall(VecRestoreArrayRead(r ? r : q, &f));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, power, 3, MPIU_REAL, MPIU_SUM, fault->comm));
  if (friction)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, friction, (PetscMPIInt)mesh->faults, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscCall(SlipFaultGetLost(fault, t, w, rel, &lost));
  PetscCall(SlipFaultRestoreWork(fault, &hv));
  PetscCall(SlipFaultRestoreWork(fault, &rel));
  power[0] += lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultGetPowers(SlipFault fault, PetscReal t, Vec w, Vec r, PetscReal power[3], PetscReal friction[])
{
  PetscFunctionBegin;
  PetscCall((*fault->cell_ops->powers)(fault, t, w, r, power, friction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetObservables - computes the means of a state over the cells: rates, slip, energies and powers

  Collective.

  Input Parameters:
+ fault - the fault
. t     - time of the state [s]
. w     - state
- r     - friction traction [Pa], one per cell and weighted by area as TSBatheGetReaction() gives it, or NULL for
        -q(w) sign(v)

  Output Parameter:
. obs - the means; d(kinetic + elastic)/dt + viscous_power + friction_power = loading_power, with
        kinetic = M v.v/2, elastic = u.K u/2 - T.u, viscous = (v - v_inf).H (v - v_inf), friction = -v.r and
        loading = -v_inf.(K u - T + H (v - v_inf)) - dT/dt.u, each divided by the number of cells; T is the shear stress
        of -fault_initial_traction and -fault_stressing_rate at t; loading includes the power v.S of the stresses in
        time S. Where cells open, u, v and K include the opening, T
        includes the normal stress before any slip, as -sigma0, and loading includes the pore pressure's power p v_n

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultConfigureTS()
@*/
PetscErrorCode SlipFaultGetObservables(SlipFault fault, PetscReal t, Vec w, Vec r, SlipFaultObservables *obs)
{
  const SlipFaultSums *s;
  PetscReal power[3];
  const PetscReal N = (PetscReal)fault->mesh.N;

  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  PetscCall(SlipFaultGetSums(fault, t, w, &s));
  PetscCall(SlipFaultGetPowers(fault, t, w, r, power, NULL));
  obs->mean_slip_rate = s->sum[SUM_V] / N;
  obs->max_slip_rate = s->max_v;
  obs->mean_slip = s->sum[SUM_S] / N;
  /* A state that heals is not the slip: the slip is the displacement relative to the start and the far field. */
  if (fault->kind.heals || fault->friction.law->nstates)
    obs->mean_slip = (s->sum[SUM_U] + (fault->loads.origin + t) * s->sum[SUM_VINF]) / N -
                     fault->critical.start_share * fault->critical.mean_uc;
  obs->mean_displacement = s->sum[SUM_U] / N;
  obs->sliding_fraction = s->sum[SUM_SLIDING] / N;
  obs->kinetic = fault->kind.inertia ? fault->operators.mass * s->sum[SUM_V2] / (2 * N) : 0;
  obs->elastic = (s->sum[SUM_U_KU] / 2 - s->sum[SUM_U_T]) / N;
  obs->viscous_power = power[0] / N;
  obs->friction_power = power[2] / N;
  obs->loading_power = (s->sum[SUM_LOADING_T] - s->sum[SUM_VINF_KU] - power[1]) / N;
  PetscFunctionReturn(PETSC_SUCCESS);
}
