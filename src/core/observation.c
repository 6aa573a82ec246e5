/* Observations: what a policy may observe before it chooses a step, one row each, all dimensionless. The formulas use
   plain numbers, so that the controller, the fault and the trainer's loops without objects share them. A new
   observation is a row and its formula here, and a member of SlipRunNumbers or SlipFaultNumbers for another sum. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <stdlib.h>
#include <string.h>

#define CRITICAL_RESIDUAL 4            /* E_c of the residual */
#define FAILED_RESIDUAL 2              /* residual of a solve that failed or was not run */
#define LOG_FLOOR 1e-16                /* smallest argument of a logarithm */
#define REJECTIONS_KEPT (PetscReal)0.8 /* factor on the weight of an attempt with each later one */
#define RATE_FLOOR 1e-12               /* smallest slip rate in logarithms [m/s] */

static const char Change[] = "change_";

static PetscReal LogWithin(PetscReal x, PetscReal low, PetscReal high)
{
  return PetscLog10Real(PetscClipInterval(x, low, high));
}

static PetscReal LogClipped(PetscReal x)
{
  return LogWithin(x, (PetscReal)LOG_FLOOR, (PetscReal)(1 / LOG_FLOOR));
}

static PetscReal PositiveOr1(PetscReal x)
{
  return x > 0 ? x : 1;
}

/* ---- of any run ---- */

/* Before the first attempt the residual is that of one failed solve. */
static PetscReal LastResidual(const SlipRunNumbers *r)
{
  return r->started ? r->residual : FAILED_RESIDUAL;
}

static PetscReal Residual(const SlipRunNumbers *r)
{
  return LastResidual(r) / CRITICAL_RESIDUAL;
}

static PetscReal LogResidual(const SlipRunNumbers *r)
{
  return LogClipped(LastResidual(r));
}

static PetscReal Converged(const SlipRunNumbers *r)
{
  return r->started && r->converged ? 1 : 0;
}

static PetscReal Accuracy(const SlipRunNumbers *r)
{
  return r->started && r->converged ? 1 / (1 + r->error) : 0;
}

static PetscReal LogError(const SlipRunNumbers *r)
{
  const PetscReal error = !r->started ? 1 : (r->converged ? r->error : 2);

  return PetscClipInterval(LogClipped(error), (PetscReal)-6, (PetscReal)6);
}

static PetscReal Step(const SlipRunNumbers *r)
{
  PetscReal step;

  if (!r->started) return -0.5;
  step = PetscClipInterval((r->dt - r->dt_min) / (r->dt_max - r->dt_min), (PetscReal)0, (PetscReal)1);
  return r->converged ? step : -step;
}

static PetscReal LogStep(const SlipRunNumbers *r)
{
  return LogClipped((r->started ? r->dt : 0.5 * (r->dt_min + r->dt_max)) / r->tstar);
}

static PetscReal TimeFraction(const SlipRunNumbers *r)
{
  return r->max_time < PETSC_MAX_REAL ? r->time / r->max_time : 0;
}

static PetscReal LogTimeScale(const SlipRunNumbers *r)
{
  return r->max_time < PETSC_MAX_REAL ? LogClipped(r->max_time / r->tstar) : 0;
}

static PetscReal LogTimeLeft(const SlipRunNumbers *r)
{
  const PetscReal left = r->max_time < PETSC_MAX_REAL ? (r->max_time - r->time) / r->tstar : PETSC_MAX_REAL;

  return LogWithin(left, (PetscReal)1e-3, (PetscReal)1e3);
}

/* Step over the duration, and over the time passed: diffusion scales like the root of time and has no other scale. */
static PetscReal LogStepShare(const SlipRunNumbers *r)
{
  return r->started && r->max_time < PETSC_MAX_REAL ? LogWithin(r->dt / r->max_time, (PetscReal)1e-9, 1) : -9;
}

static PetscReal LogStepPast(const SlipRunNumbers *r)
{
  return r->started && r->time > 0 ? LogWithin(r->dt / r->time, (PetscReal)1e-6, (PetscReal)1e3) : 0;
}

static PetscReal LogAccuracy(const SlipRunNumbers *r)
{
  return PetscLog10Real(r->accuracy);
}

static PetscReal Failures(const SlipRunNumbers *r)
{
  return (PetscReal)r->failures;
}

/* The elementary controller's ratio of steps; one half after a failure, because the step is halved then */
static PetscReal ErrorStep(const SlipRunNumbers *r)
{
  if (!r->started || r->order <= 0) return 0;
  if (!r->converged) return -PetscLog10Real((PetscReal)2);
  return PetscClipInterval(-LogWithin(r->error, (PetscReal)1e-30, (PetscReal)1e30) / r->order, (PetscReal)-1,
                           (PetscReal)1);
}

static PetscReal LogStepRatio(const SlipRunNumbers *r)
{
  return r->started && r->dt_before > 0 ? LogWithin(r->dt / r->dt_before, (PetscReal)0.1, (PetscReal)10) : 0;
}

static PetscReal Rejected(const SlipRunNumbers *r)
{
  return r->rejected > 0 ? 1 : 0;
}

static PetscReal Rejections(const SlipRunNumbers *r)
{
  return r->rejections;
}

static PetscReal Order(const SlipRunNumbers *r)
{
  return r->order;
}

static PetscReal SquaredNorm(const SlipRunNumbers *r)
{
  return PetscSqr(r->norm / PositiveOr1(r->norm0));
}

static PetscReal Mean(const SlipRunNumbers *r)
{
  return r->mean / PositiveOr1(r->max0);
}

static PetscReal Component(const SlipRunNumbers *r)
{
  return r->component / (r->component0 != 0 ? r->component0 : PositiveOr1(r->max0));
}

/* ---- of a fault ---- */

/* The slip that corresponds to the strength drop, D [m]; d_c for friction that does not weaken */
static PetscReal DropSlip(const SlipFaultNumbers *f)
{
  return f->drop_slip > 0 ? f->drop_slip : f->mean_dc;
}

static PetscReal LogOfRate(const SlipFaultNumbers *f, PetscReal rate)
{
  return LogWithin(rate * f->tstar / DropSlip(f), (PetscReal)1e-6, (PetscReal)1e6);
}

static PetscReal LogRate(const SlipFaultNumbers *f)
{
  return LogOfRate(f, f->rate);
}

static PetscReal LogPeakRate(const SlipFaultNumbers *f)
{
  return LogOfRate(f, f->peak);
}

/* In units of d_c/T* [m/s] */
static PetscReal LogVelocity(const SlipFaultNumbers *f)
{
  return PetscLog10Real(PetscMax(f->peak, RATE_FLOOR) / (f->mean_dc / f->tstar));
}

static PetscReal LogMeanVelocity(const SlipFaultNumbers *f)
{
  return PetscLog10Real(PetscMax(f->rate, RATE_FLOOR) / (f->mean_dc / f->tstar));
}

static PetscReal Velocity(const SlipFaultNumbers *f)
{
  return f->velocity / f->velocity_scale;
}

static PetscReal Energy(const SlipFaultNumbers *f)
{
  return f->energy / PositiveOr1(f->critical_energy);
}

static PetscReal Kinetic(const SlipFaultNumbers *f)
{
  return f->kinetic / PositiveOr1(f->critical_energy);
}

static PetscReal LogEnergyRate(const SlipFaultNumbers *f)
{
  const PetscReal rate = 2 * PetscAbsReal(f->power) * f->tstar / PositiveOr1(f->critical_energy);

  return PetscLog10Real(PetscMax(rate, RATE_FLOOR));
}

static PetscReal SlidingFraction(const SlipFaultNumbers *f)
{
  return f->sliding;
}

static PetscReal Slip(const SlipFaultNumbers *f)
{
  return f->slip / f->mean_dc;
}

static PetscReal Progress(const SlipFaultNumbers *f)
{
  return f->slip / DropSlip(f);
}

static PetscReal Displacement(const SlipFaultNumbers *f)
{
  return f->displacement / PositiveOr1(f->mean_uc);
}

static PetscReal Strength(const SlipFaultNumbers *f)
{
  return f->strength / PositiveOr1(f->mean_q0);
}

static PetscReal Weakening(const SlipFaultNumbers *f)
{
  return f->weakening / PositiveOr1(f->mean_drop);
}

static PetscReal LogDrop(const SlipFaultNumbers *f)
{
  return PetscLog10Real(DropSlip(f) / f->mean_dc);
}

/* A thousandth of D before the first attempt and if the integrator gives no estimate */
static PetscReal LogSlipError(const SlipFaultNumbers *f)
{
  return f->estimated ? LogWithin(f->slip_error / DropSlip(f), (PetscReal)1e-9, (PetscReal)1e3) : -3;
}

static PetscReal Growth(const SlipFaultNumbers *f)
{
  return f->estimated && f->total_rate != 0 ? PetscAsinhReal(f->tstar * f->growth / f->total_rate) : 0;
}

/* ---- of the growing mode: the rate v, or the critical displacement if no cell moves yet ---- */

/* The faster root of lambda^2 + 2 zeta w lambda + w^2 - W = 0 [1/s], its real part where they are complex: a mode of
   stiffness w^2 and weakening W, both over its inertia, whose damping is that of H = 2 zeta sqrt(M K) */
static PetscReal Root(PetscReal stiffness, PetscReal weakening, PetscReal zeta)
{
  const PetscReal w = PetscSqrtReal(stiffness), D = (zeta * zeta - 1) * stiffness + weakening;

  return -zeta * w + (D > 0 ? PetscSqrtReal(D) : 0);
}

/* 1/(w + lambda/2) [s]: the time in which the mode oscillates, or grows */
static PetscReal TimeOf(PetscReal stiffness, PetscReal root)
{
  const PetscReal rate = PetscSqrtReal(stiffness) + PetscMax(root, 0) / 2;

  return rate > 0 ? 1 / rate : PETSC_MAX_REAL;
}

static PetscReal ModeRoot(const SlipFaultNumbers *f)
{
  return Root(f->mode_stiffness, f->mode_weakening, f->damping_ratio);
}

static PetscReal ModeTime(const SlipFaultNumbers *f)
{
  return PetscMin(TimeOf(f->mode_stiffness, ModeRoot(f)), 1e6 * f->tstar);
}

static PetscReal LogGrowthTime(const SlipFaultNumbers *f)
{
  return LogWithin(ModeTime(f) / f->tstar, (PetscReal)1e-6, (PetscReal)1e6);
}

static PetscReal GrowthRate(const SlipFaultNumbers *f)
{
  return ModeRoot(f) * ModeTime(f);
}

static PetscReal StartGrowthRate(const SlipFaultNumbers *f)
{
  const PetscReal root = Root(f->critical_stiffness, f->critical_weakening, f->damping_ratio);

  return f->critical_stiffness > 0 ? root * TimeOf(f->critical_stiffness, root) : 0;
}

static PetscReal SeenGrowth(const SlipFaultNumbers *f)
{
  return f->estimated && f->total_rate != 0 ? PetscAsinhReal(ModeTime(f) * f->growth / f->total_rate) : 0;
}

/* w of uc [1/s]; 1/T* if there is none */
static PetscReal CriticalFrequency(const SlipFaultNumbers *f)
{
  return f->critical_stiffness > 0 ? PetscSqrtReal(f->critical_stiffness) : 1 / f->tstar;
}

static PetscReal LogModeRate(const SlipFaultNumbers *f)
{
  return LogWithin(f->rate / (CriticalFrequency(f) * DropSlip(f)), (PetscReal)1e-8, (PetscReal)1e3);
}

static PetscReal LogPush(const SlipFaultNumbers *f)
{
  const PetscReal unit = f->mass * PetscSqr(CriticalFrequency(f)) * DropSlip(f);

  return LogWithin(PetscAbsReal(f->push) / unit, (PetscReal)1e-8, (PetscReal)1e3);
}

static PetscReal Phase(const SlipFaultNumbers *f)
{
  const PetscReal x = CriticalFrequency(f) * f->rate, y = f->push / f->mass;

  return x == 0 && y == 0 ? 0 : PetscAtan2Real(y, x) / (PetscReal)(PETSC_PI / 2);
}

static PetscReal DampingRatio(const SlipFaultNumbers *f)
{
  return f->damping_ratio;
}

static PetscReal LogPeakRatio(const SlipFaultNumbers *f)
{
  return f->rate > 0 ? LogWithin(f->peak / f->rate, (PetscReal)1, (PetscReal)50) : 0;
}

static PetscReal LogStepLimit(const SlipFaultNumbers *f)
{
  return LogWithin(f->step_limit / ModeTime(f), (PetscReal)1e-4, (PetscReal)1e3);
}

static PetscReal LogSolveCost(const SlipFaultNumbers *f)
{
  return LogWithin(f->solve_cost, (PetscReal)1e-1, (PetscReal)1e4);
}

static PetscReal LogRelaxation(const SlipFaultNumbers *f)
{
  return LogWithin(f->relaxation * f->tstar, (PetscReal)1e-30, (PetscReal)1e30);
}

/* h, E and residuals are those of the last attempt. The text after "else" applies to problems that do not supply the
   row; rows without a formula for any run are those of faults. */
const SlipObservation SlipObservations[] = {
  {"energy", SLIP_READS_STATE, SquaredNorm, Energy, "mean internal energy / critical energy; else |w|^2/|w_0|^2"},
  {"velocity", SLIP_READS_STATE, Mean, Velocity, "mean rate / its estimated maximum; else mean of w / max |w_0|"},
  {"state_", SLIP_READS_STATE, Component, NULL, "state_k: component k of the state / its start; else w_k/w_k(0)"},
  {"residual", SLIP_READS_RESIDUAL, Residual, NULL, "sum of the attempt's final residuals / 4; 0.5 at the start"},
  {"converged", 0, Converged, NULL, "1 when the attempt converged, else 0; 0 at the start"},
  {"accuracy", SLIP_READS_ERROR, Accuracy, NULL, "1/(1 + E), E its error estimate; 0 after a failure and at the start"},
  {"step", 0, Step, NULL, "(h - h_min)/(h_max - h_min), negative after a failure; -0.5 at the start"},
  {"log_error", SLIP_READS_ERROR, LogError, NULL, "log10 of E in [-6, 6]; of 2 after a failure, of 1 at the start"},
  {"log_residual", SLIP_READS_RESIDUAL, LogResidual, NULL,
   "log10 of the sum of residuals, at least -16; of 2 at the start"},
  {"log_step", 0, LogStep, NULL, "log10(h/T*); of (h_min + h_max)/2 at the start"},
  {"time_fraction", 0, TimeFraction, NULL, "time / maximum time; 0 without a maximum"},
  {"log_time_scale", 0, LogTimeScale, NULL, "log10(maximum time / T*); 0 without a maximum"},
  {"log_time_left", 0, LogTimeLeft, NULL, "log10(remaining time / T*) in [-3, 3]; 3 without a maximum time"},
  {"log_step_share", 0, LogStepShare, NULL, "log10(last step / maximum time) in [-9, 0]; -9 without a maximum"},
  {"log_step_past", 0, LogStepPast, NULL, "log10(last step / time) in [-6, 3]"},
  {SLIP_OBSERVES_ACCURACY, 0, LogAccuracy, NULL,
   "log10 of the wanted relative error of the run's result (-ts_adapt_rl_accuracy)"},
  {"failures", 0, Failures, NULL, "attempts in a row that did not converge"},
  {"log_error_step", SLIP_READS_ERROR | SLIP_READS_ATTEMPTS, ErrorStep, NULL,
   "log10 of E^-q, the ratio of steps that the error asks for, in [-1, 1]; of 1/2 after a failure, of 1 at the start"},
  {"log_step_ratio", SLIP_READS_ATTEMPTS, LogStepRatio, NULL,
   "log10 of h over the accepted step before it, in [-1, 1]; 0 without one"},
  {"rejected", SLIP_READS_ATTEMPTS, Rejected, NULL, "1 when the attempt converged and was rejected, else 0"},
  {"rejections", SLIP_READS_ATTEMPTS, Rejections, NULL,
   "share of rejected attempts, those before counting 0.8 times less each"},
  {"order", SLIP_READS_ERROR | SLIP_READS_ATTEMPTS, Order, NULL, "power of h that E goes with, 1/q; 0 at the start"},
  {"log_velocity", SLIP_READS_STATE, NULL, LogVelocity,
   "of a fault: log10(max|v| / V), V = d_c over T*, |v| at least 1e-12 m/s"},
  {"log_mean_velocity", SLIP_READS_STATE, NULL, LogMeanVelocity, "of a fault: log10(mean|v| / V), likewise"},
  {"sliding_fraction", SLIP_READS_STATE, NULL, SlidingFraction, "of a fault: share of cells with v != 0"},
  {"slip", SLIP_READS_STATE, NULL, Slip, "of a fault: mean s / mean d_c"},
  {"displacement", SLIP_READS_STATE, NULL, Displacement,
   "of a fault: mean u / mean uc, that of the instability: -1 at the critical start"},
  {"strength", SLIP_READS_STATE, NULL, Strength, "of a fault: mean q / mean q at v = s = 0"},
  {"log_rate", SLIP_READS_STATE, NULL, LogRate,
   "of a fault: log10(mean|v| / V) in [-6, 6], V = D over T*; D: slip that the strength drop implies, mean uc times "
   "mean "
   "drop of the strength over its mean at the start"},
  {"log_peak_rate", SLIP_READS_STATE, NULL, LogPeakRate, "of a fault: log10(max|v| / V), likewise, in [-6, 6]"},
  {"progress", SLIP_READS_STATE, NULL, Progress, "of a fault: mean s / D"},
  {"weakening", SLIP_READS_STATE, NULL, Weakening,
   "of a fault: mean of what the strength can still lose / that at the start"},
  {"log_drop", SLIP_READS_STATE, NULL, LogDrop, "of a fault: log10(D / mean d_c), the same throughout a run"},
  {"log_slip_error", SLIP_READS_STATE | SLIP_READS_ERROR | SLIP_READS_ESTIMATES, NULL, LogSlipError,
   "of a fault: log10(mean |estimated error of s in the last attempt| / D) in [-9, 3]"},
  {"growth", SLIP_READS_STATE | SLIP_READS_ESTIMATES, NULL, Growth,
   "of a fault: asinh(T* d(mean|v|)/dt / mean|v|) at the end of the last attempt"},
  {"log_growth_time", SLIP_READS_STATE | SLIP_READS_MODE, NULL, LogGrowthTime,
   "of a fault: log10(T_g/T*), T_g = 1/(w + lambda/2), w the frequency and lambda the growth rate, if positive, of v, "
   "after an explicit step of its inner rate, or where all rest of uc"},
  {"growth_rate", SLIP_READS_STATE | SLIP_READS_MODE, NULL, GrowthRate, "of a fault: lambda T_g, lambda of any sign"},
  {"start_growth_rate", SLIP_READS_STATE, NULL, StartGrowthRate,
   "of a fault: lambda T_g of uc at the start, the same throughout a run"},
  {"seen_growth", SLIP_READS_STATE | SLIP_READS_ESTIMATES | SLIP_READS_MODE, NULL, SeenGrowth,
   "of a fault: asinh(T_g d(mean|v|)/dt / mean|v|) at the end of the last attempt"},
  {"log_mode_rate", SLIP_READS_STATE, NULL, LogModeRate,
   "of a fault: log10(mean|v| / (D w)), w the frequency of uc, in [-8, 3]"},
  {"log_push", SLIP_READS_STATE, NULL, LogPush,
   "of a fault: log10(|P| / (M D w^2)) in [-8, 3], P mean of what the elastic force along the motion exceeds the "
   "strength by, where a cell rests at least 0"},
  {"phase", SLIP_READS_STATE, NULL, Phase,
   "of a fault: angle of (w mean|v|, P/M) over pi/2: 1 speeds up, -1 slows down"},
  {"damping_ratio", SLIP_READS_STATE, NULL, DampingRatio, "of a fault: zeta, the same throughout a run"},
  {"log_peak_ratio", SLIP_READS_STATE, NULL, LogPeakRatio, "of a fault: log10(max|v| / mean|v|), at most that of 50"},
  {"kinetic", SLIP_READS_STATE, NULL, Kinetic, "of a fault: v'Mv/(uc'K uc)"},
  {"log_energy_rate", SLIP_READS_STATE, NULL, LogEnergyRate,
   "of a fault: log10 of the elastic energy's change per time T*, over the critical energy"},
  {"log_relaxation", SLIP_READS_STATE | SLIP_READS_STIFFNESS, NULL, LogRelaxation,
   "of a fault without inertia whose friction is smooth: log10(T* r), r = largest eigenvalue of K times the largest "
   "change of v with the stress, 1/(eta + sigma dmu/dv), in [-30, 30]: explicit steps longer than 2 to 3 over r are "
   "unstable; -30 for others"},
  {"log_step_limit", SLIP_READS_STATE | SLIP_READS_MODE | SLIP_READS_METHOD, NULL, LogStepLimit,
   "of a fault: log10(the longest stable explicit step / T_g) in [-4, 3]: 3 where any is stable, -4 where there are "
   "none"},
  {"log_solve_cost", SLIP_READS_STATE | SLIP_READS_METHOD, NULL, LogSolveCost,
   "of a fault: log10 of the products of an implicit solve of that step over those of an explicit step, in [-1, 4]"},
  {Change, 0, NULL, NULL, "before a name: the value less that at the accepted step before; 0 at the start"},
  {NULL, 0, NULL, NULL, NULL},
};

/* ---- names, looked up once, and values ---- */

/* Finds the number of the row with a name, -1 if there is none. A row that ends in _ is followed by a component k,
   which is 0 for others. */
PetscInt SlipObservationFind(const char name[], PetscInt *component)
{
  *component = 0;
  for (PetscInt i = 0; SlipObservations[i].name; i++) {
    const SlipObservation *row = &SlipObservations[i];
    const size_t n = strlen(row->name);
    char *end;
    long k;

    if (!row->run && !row->fault) continue;
    if (row->name[n - 1] != '_') {
      if (!strcmp(name, row->name)) return i;
      continue;
    }
    if (strncmp(name, row->name, n) || name[n] < '0' || name[n] > '9') continue;
    k = strtol(name + n, &end, 10);
    if (*end || k > PETSC_MAX_INT) continue;
    *component = (PetscInt)k;
    return i;
  }
  return -1;
}

/* Sets the row and component of a name, not yet the problem's own row. "change_" before a name makes a row of any
   row. */
void SlipObservedSet(SlipObserved *seen, const char name[])
{
  const size_t length = sizeof(Change) - 1;
  PetscInt row;

  memset(seen, 0, sizeof(*seen));
  strncpy(seen->name, name, sizeof(seen->name) - 1);
  seen->change = strncmp(name, Change, length) ? 0 : length;
  row = SlipObservationFind(seen->name + seen->change, &seen->component);
  seen->row = row < 0 ? NULL : &SlipObservations[row];
  seen->own = -1;
}

/* May the problem have a row of its own that takes precedence? Is the value cached over a failed attempt? */
PetscBool SlipObservedOfState(const SlipObserved *seen)
{
  return !seen->row || seen->change || seen->row->reads & SLIP_READS_STATE ? PETSC_TRUE : PETSC_FALSE;
}

/* Can the row be computed from the numbers of a run without its state, error estimate, residuals and attempts? */
PetscBool SlipObservedOfRun(const SlipObserved *seen)
{
  const PetscInt unknown = SLIP_READS_STATE | SLIP_READS_ERROR | SLIP_READS_RESIDUAL | SLIP_READS_ATTEMPTS;

  return seen->row && seen->row->run && !(seen->row->reads & unknown) ? PETSC_TRUE : PETSC_FALSE;
}

/* The value that the policy gets: for a change, the difference to the value at the previous accepted step */
PetscReal SlipObservedTake(SlipObserved *seen, PetscReal now)
{
  seen->value = now;
  if (!seen->change) return now;
  seen->value = seen->has_base ? now - seen->base : 0;
  seen->base = now;
  seen->has_base = PETSC_TRUE;
  return seen->value;
}

/* Updates the history after an attempt at the step h; run->dt is still that of the previous one. */
void SlipRunAttempt(SlipRunNumbers *run, PetscReal h, PetscBool converged, PetscBool accepted)
{
  const PetscBool rejected = converged && !accepted ? PETSC_TRUE : PETSC_FALSE;

  if (run->accepted) run->dt_before = run->dt;
  run->started = PETSC_TRUE;
  run->converged = converged;
  run->accepted = accepted;
  run->dt = h;
  run->rejected = rejected ? run->rejected + 1 : 0;
  run->rejections = REJECTIONS_KEPT * run->rejections + (1 - REJECTIONS_KEPT) * (rejected ? 1 : 0);
}
