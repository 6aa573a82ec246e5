/* What a run and a controller may know of the fault's state: sums over the cells, energies and powers. */
#include <slipstep/private/slipfault.h>
#include <slipcompat.h>

/* Slip rates below this count as standing still where their logarithm is taken [m/s]. */
#define SLIP_FAULT_RATE_FLOOR 1e-12

static PetscErrorCode SlipFaultExtractDisplacement(SlipFault fault, Vec w, Vec u)
{
  const PetscReal *a;
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayWrite(u, &b));
  for (PetscInt i = 0; i < fault->n; i++) b[i] = a[3 * i + 1];
  PetscCall(VecRestoreArrayWrite(u, &b));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* This rank's part of the sums, weighted by area; ku = K u is weighted already. */
static PetscErrorCode SlipFaultAddUp(SlipFault fault, Vec w, Vec ku, PetscReal sum[], PetscReal *max_v)
{
  SlipFrictionCells friction;
  const PetscReal *a, *f;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetFriction(fault, &friction));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(ku, &f));
  for (PetscInt i = 0; i < fault->n; i++) {
    const PetscReal v = a[3 * i], u = a[3 * i + 1], s = a[3 * i + 2], weight = fault->weight[i];
    const PetscReal weak = SlipFrictionWeakest(&friction, i);
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&friction, i, s, PetscAbsReal(v), &mu, &ds, &dv);
    sum[SUM_V] += weight * v;
    sum[SUM_ABS_V] += weight * PetscAbsReal(v);
    sum[SUM_V2] += weight * (v * v);
    sum[SUM_U] += weight * u;
    sum[SUM_S] += weight * s;
    sum[SUM_SLIDING] += v != 0 ? weight : 0;
    sum[SUM_U_KU] += u * f[i];
    sum[SUM_V_KU] += v * f[i];
    sum[SUM_VINF_KU] += fault->field[FIELD_LOADING_RATE][i] * f[i];
    sum[SUM_WEAKENING] += (mu - weak) * (weight * fault->field[FIELD_NORMAL_STRESS][i]);
    sum[SUM_STRENGTH] += mu * (weight * fault->field[FIELD_NORMAL_STRESS][i]);
    *max_v = PetscMax(*max_v, PetscAbsReal(v));
  }
  PetscCall(VecRestoreArrayRead(ku, &f));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Has w changed anywhere since it was summed? Keeps a copy of what is summed. */
static PetscErrorCode SlipFaultIsNew(SlipFault fault, Vec w, PetscBool *is_new)
{
  const PetscReal *a;
  PetscBool same = PETSC_FALSE;
  PetscInt changed;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  if (fault->summed)
    PetscCall(PetscArraycmp(a, fault->summed, 3 * fault->n, &same));
  else
    PetscCall(PetscMalloc1(3 * fault->n + 1, &fault->summed));
  if (!same) PetscCall(PetscArraycpy(fault->summed, a, 3 * fault->n));
  PetscCall(VecRestoreArrayRead(w, &a));
  changed = same ? 0 : 1;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPIU_INT, MPI_MAX, fault->comm));
  *is_new = changed ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums of a state, computed (one product with K, two reductions) only when the state has changed. */
PetscErrorCode SlipFaultGetSums(SlipFault fault, Vec w, const SlipFaultSums **sums)
{
  SlipFaultSums *c = &fault->sums;
  PetscBool is_new = PETSC_TRUE;

  PetscFunctionBegin;
  *sums = c;
  PetscCall(SlipFaultIsNew(fault, w, &is_new));
  if (!is_new) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultExtractDisplacement(fault, w, fault->work[0]));
  PetscCall(MatMult(fault->K, fault->work[0], fault->work[1]));
  PetscCall(PetscArrayzero(c->sum, FAULT_NUM_SUMS));
  c->max_v = 0;
  PetscCall(SlipFaultAddUp(fault, w, fault->work[1], c->sum, &c->max_v));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->sum, FAULT_NUM_SUMS, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &c->max_v, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- observations for controllers: one row each, all dimensionless ---- */

static PetscReal PositiveOr1(PetscReal x)
{
  return x > 0 ? x : 1;
}

/* Slip rate V* = d_c/T* [m/s]. */
static PetscReal RateUnit(SlipFault f)
{
  return f->mean_dc / f->tstar;
}

static PetscReal Energy(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_U_KU] / PositiveOr1(f->critical_energy);
}

static PetscReal Velocity(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_V] / f->N / f->value[FAULT_VELOCITY_SCALE];
}

static PetscReal LogVelocity(SlipFault f, const SlipFaultSums *s)
{
  return PetscLog10Real(PetscMax(s->max_v, SLIP_FAULT_RATE_FLOOR) / RateUnit(f));
}

static PetscReal LogMeanVelocity(SlipFault f, const SlipFaultSums *s)
{
  return PetscLog10Real(PetscMax(s->sum[SUM_ABS_V] / f->N, SLIP_FAULT_RATE_FLOOR) / RateUnit(f));
}

static PetscReal SlidingFraction(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_SLIDING] / f->N;
}

static PetscReal Slip(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_S] / f->N / f->mean_dc;
}

static PetscReal Displacement(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_U] / f->N / PositiveOr1(f->mean_uc);
}

static PetscReal Strength(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_STRENGTH] / f->N / PositiveOr1(f->mean_q0);
}

static PetscReal Kinetic(SlipFault f, const SlipFaultSums *s)
{
  return f->mass * s->sum[SUM_V2] / PositiveOr1(f->critical_energy);
}

static PetscReal LogEnergyRate(SlipFault f, const SlipFaultSums *s)
{
  const PetscReal rate = 2 * PetscAbsReal(s->sum[SUM_V_KU]) * f->tstar / PositiveOr1(f->critical_energy);

  return PetscLog10Real(PetscMax(rate, SLIP_FAULT_RATE_FLOOR));
}

/* The slip that the strength drop implies, D [m]; d_c for friction that does not weaken. */
static PetscReal DropSlip(SlipFault f)
{
  return f->drop_slip > 0 ? f->drop_slip : f->mean_dc;
}

static PetscReal LogOfRate(SlipFault f, PetscReal rate)
{
  return PetscLog10Real(PetscClipInterval(rate * f->tstar / DropSlip(f), (PetscReal)1e-6, (PetscReal)1e6));
}

static PetscReal LogRate(SlipFault f, const SlipFaultSums *s)
{
  return LogOfRate(f, s->sum[SUM_ABS_V] / f->N);
}

static PetscReal LogPeakRate(SlipFault f, const SlipFaultSums *s)
{
  return LogOfRate(f, s->max_v);
}

static PetscReal Progress(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_S] / f->N / DropSlip(f);
}

static PetscReal Weakening(SlipFault f, const SlipFaultSums *s)
{
  return s->sum[SUM_WEAKENING] / f->N / PositiveOr1(f->mean_drop);
}

static PetscReal LogDrop(SlipFault f, const SlipFaultSums *s)
{
  (void)s;
  return PetscLog10Real(DropSlip(f) / f->mean_dc);
}

/* Before the first attempt and where the integrator gives no estimate: as if a thousandth of D. */
static PetscReal LogSlipError(SlipFault f, const SlipFaultSums *s)
{
  const PetscReal error = f->estimates.sum[ESTIMATE_SLIP_ERROR] / f->N / DropSlip(f);

  (void)s;
  return f->estimates.known ? PetscLog10Real(PetscClipInterval(error, (PetscReal)1e-9, (PetscReal)1e3)) : -3;
}

static PetscReal Growth(SlipFault f, const SlipFaultSums *s)
{
  const PetscReal rate = s->sum[SUM_ABS_V];

  if (!f->estimates.known || rate == 0) return 0;
  return PetscAsinhReal(f->tstar * f->estimates.sum[ESTIMATE_GROWTH] / rate);
}

static const struct {
  const char *name;
  PetscReal (*value)(SlipFault, const SlipFaultSums *);
} SlipFaultObservations[] = {
  {"energy", Energy},                     /* u'Ku/(uc'K uc), uc at the instability */
  {"velocity", Velocity},                 /* mean v / velocity_scale */
  {"log_velocity", LogVelocity},          /* log10(max|v| / V), V = d_c over T*, |v| at least 1e-12 m/s */
  {"log_mean_velocity", LogMeanVelocity}, /* log10(mean|v| / V), likewise */
  {"sliding_fraction", SlidingFraction},  /* share of cells with v != 0 */
  {"slip", Slip},                         /* mean s / mean d_c */
  {"displacement", Displacement},         /* mean u / mean uc: -1 at the critical start */
  {"strength", Strength},                 /* mean q / mean q at v = s = 0 */
  /* D: slip that the strength drop implies, mean uc times mean drop of the strength over its mean at the start */
  {"log_rate", LogRate},              /* log10(mean|v| / V), V = D over T*, in [-6, 6] */
  {"log_peak_rate", LogPeakRate},     /* log10(max|v| / V), likewise, in [-6, 6] */
  {"progress", Progress},             /* mean s / D */
  {"weakening", Weakening},           /* mean of what the strength can still lose / that at the start */
  {"log_drop", LogDrop},              /* log10(D / mean d_c), the same throughout a run */
  {"log_slip_error", LogSlipError},   /* log10(mean |estimated error of s in the last attempt| / D) in [-9, 3] */
  {"growth", Growth},                 /* asinh(T* d(mean|v|)/dt / mean|v|) at the end of the last attempt */
  {"kinetic", Kinetic},               /* v'Mv/(uc'K uc) */
  {"log_energy_rate", LogEnergyRate}, /* log10 of the elastic energy's change per time T*, over the critical energy */
};

/* value of the observation of this name in state w; known is false when the fault has none. */
PetscErrorCode SlipFaultObserve(SlipFault fault, Vec w, const char name[], PetscReal *value, PetscBool *known)
{
  PetscFunctionBegin;
  *known = PETSC_FALSE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(SlipFaultObservations) && !*known; i++) {
    const SlipFaultSums *sums;

    PetscCall(PetscStrcmp(name, SlipFaultObservations[i].name, known));
    if (!*known) continue;
    PetscCall(SlipFaultGetSums(fault, w, &sums));
    *value = SlipFaultObservations[i].value(fault, sums);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sums over the cells: power[0] of (v - v_inf) H (v - v_inf), [1] of v_inf H (v - v_inf), [2] of -v r, or q |v|. */
static PetscErrorCode SlipFaultAddPowers(SlipFault fault, Vec w, Vec r, PetscReal power[3])
{
  Vec rel = fault->work[0], hv = fault->work[1], q = fault->work[2];
  const PetscReal *a, *f, *vinf = fault->field[FIELD_LOADING_RATE];
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayWrite(rel, &b));
  for (PetscInt i = 0; i < fault->n; i++) b[i] = a[3 * i] - vinf[i];
  PetscCall(VecRestoreArrayWrite(rel, &b));
  PetscCall(MatMult(fault->H, rel, hv));
  if (!r) PetscCall(SlipFaultStrength(fault, w, q));
  PetscCall(VecGetArrayRead(hv, &f));
  for (PetscInt i = 0; i < fault->n; i++) {
    power[0] += (a[3 * i] - vinf[i]) * f[i];
    power[1] += vinf[i] * f[i];
  }
  PetscCall(VecRestoreArrayRead(hv, &f));
  PetscCall(VecGetArrayRead(r ? r : q, &f));
  for (PetscInt i = 0; i < fault->n; i++) power[2] += r ? -a[3 * i] * f[i] : PetscAbsReal(a[3 * i]) * f[i];
  PetscCall(VecRestoreArrayRead(r ? r : q, &f));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, power, 3, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultGetObservables - means over the cells of a state: rates, slip, energies and powers

  Collective.

  Input Parameters:
+ fault - the fault
. w     - state
- r     - friction traction [Pa], one per cell and weighted by area as TSBatheGetReaction() gives it, or NULL for
        -q(w) sign(v)

  Output Parameter:
. obs - the means; d(kinetic + elastic)/dt + viscous_power + friction_power = loading_power, with
        kinetic = M v.v/2, elastic = u.K u/2, viscous = (v - v_inf).H (v - v_inf), friction = -v.r and
        loading = -v_inf.(K u + H (v - v_inf)), each divided by the number of cells

  Level: intermediate

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp()

.seealso: SlipFaultConfigureTS()
@*/
PetscErrorCode SlipFaultGetObservables(SlipFault fault, Vec w, Vec r, SlipFaultObservables *obs)
{
  const SlipFaultSums *s;
  PetscReal power[3] = {0, 0, 0};
  const PetscReal N = (PetscReal)fault->N;

  PetscFunctionBegin;
  PetscCheck(fault->setup, fault->comm, PETSC_ERR_ORDER, "call SlipFaultSetUp() first");
  PetscCall(SlipFaultGetSums(fault, w, &s));
  PetscCall(SlipFaultAddPowers(fault, w, r, power));
  obs->mean_slip_rate = s->sum[SUM_V] / N;
  obs->max_slip_rate = s->max_v;
  obs->mean_slip = s->sum[SUM_S] / N;
  obs->mean_displacement = s->sum[SUM_U] / N;
  obs->sliding_fraction = s->sum[SUM_SLIDING] / N;
  obs->kinetic = fault->mass * s->sum[SUM_V2] / (2 * N);
  obs->elastic = s->sum[SUM_U_KU] / (2 * N);
  obs->viscous_power = power[0] / N;
  obs->friction_power = power[2] / N;
  obs->loading_power = -(s->sum[SUM_VINF_KU] + power[1]) / N;
  PetscFunctionReturn(PETSC_SUCCESS);
}
