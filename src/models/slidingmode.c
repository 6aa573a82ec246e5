/* Defines the first-order sliding mode controller, dw/dt = D sin(omega t) + r, r in -k Sign(w): the system, the
   observations of policies, and its exact solution. */
#include <slipstep/rooms/slipmodels.h>
#include <slipcompat.h>
#include <string.h>

static PetscErrorCode SetCase(SlipModel model, SlipModelCase setting)
{
  SlipSlidingMode *m = (SlipSlidingMode *)model;

  PetscFunctionBegin;
  m->k = 2;
  m->D = setting == SLIP_MODEL_TRAINING ? 1.5 : 1.75;
  m->omega = 50;
  model->start[0] = setting == SLIP_MODEL_TRAINING ? 0.1 : 0.15;
  model->max_time = 0.5;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetFromOptions(SlipModel model)
{
  SlipSlidingMode *m = (SlipSlidingMode *)model;
  PetscEnum setting = (PetscEnum)model->setting;

  PetscFunctionBegin;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "First-order sliding mode controller", NULL);
  PetscCall(PetscOptionsEnum("-sliding_mode_case", "Setting that the options below start from", NULL, SlipModelCases,
                             setting, &setting, NULL));
  PetscCall(SetCase(model, (SlipModelCase)setting));
  PetscCall(PetscOptionsReal("-sliding_mode_gain", "Bound k of the reaction [1/s]", NULL, m->k, &m->k, NULL));
  PetscCall(
    PetscOptionsReal("-sliding_mode_amplitude", "Amplitude D of the disturbance [1/s]", NULL, m->D, &m->D, NULL));
  PetscCall(PetscOptionsReal("-sliding_mode_frequency", "Angular frequency omega of the disturbance [rad/s]", NULL,
                             m->omega, &m->omega, NULL));
  PetscCall(
    PetscOptionsReal("-sliding_mode_start", "Start w(0), not zero", NULL, model->start[0], &model->start[0], NULL));
  PetscOptionsEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(SlipModel model)
{
  SlipSlidingMode *m = (SlipSlidingMode *)model;

  PetscFunctionBegin;
  PetscCheck(m->k >= 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-sliding_mode_gain is %g, expected a number >= 0",
             (double)m->k);
  PetscCheck(m->omega > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-sliding_mode_frequency is %g, expected a number > 0", (double)m->omega);
  PetscCheck(!PetscIsInfOrNanReal(m->D), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-sliding_mode_amplitude is %g, expected a finite number", (double)m->D);
  PetscCheck(model->start[0] != 0 && !PetscIsInfOrNanReal(model->start[0]), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-sliding_mode_start is %g, expected a finite number other than 0: states are measured in it",
             (double)model->start[0]);
  model->mass[0] = 1;
  model->bound = m->k;
  model->tstar = 1 / m->omega;
  model->dt = 1e-4;
  model->dt_max = 2 * PETSC_PI / (10 * m->omega);
  model->atol = 1e-6;
  model->rtol = 1e-3;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Load(SlipModel model, PetscReal t)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)model;

  return m->D * PetscSinReal(m->omega * t);
}

static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *model)
{
  PetscFunctionBegin;
  (void)w;
  F[0] = Load((SlipModel)model, t);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *model)
{
  PetscFunctionBegin;
  (void)t, (void)w, (void)model;
  J[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Predicts the time to the next change of regime: while w moves, until it is zero at its present rate; at rest, until
   the disturbance exceeds the gain. t: the time [s]. Returns the time in s, or PETSC_MAX_REAL when no change is
   predicted. */
PetscReal SlipSlidingModeEvent(const SlipSlidingMode *m, PetscReal t, PetscReal w)
{
  const PetscReal load = m->D * PetscSinReal(m->omega * t), rate = load - (w > 0 ? m->k : -m->k);
  PetscReal phase, departs;

  if (w != 0) return rate * w < 0 ? -w / rate : PETSC_MAX_REAL;
  if (m->k >= m->D) return PETSC_MAX_REAL;
  if (PetscAbsReal(load) > m->k) return 0;
  departs = PetscAsinReal(m->k / m->D); /* as a phase of half a period */
  phase = m->omega * t - PETSC_PI * PetscFloorReal(m->omega * t / PETSC_PI);
  return (phase < departs ? departs - phase : PETSC_PI + departs - phase) / m->omega;
}

static PetscReal Ratio(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  (void)t, (void)k;
  return w[0] / PetscAbsReal(model->start[0]);
}

static PetscReal Energy(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  return PetscSqr(Ratio(model, t, w, k));
}

static PetscReal LogEvent(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)model;

  (void)k;
  return PetscLog10Real(PetscClipInterval(SlipSlidingModeEvent(m, t, w[0]), 1e-3 / m->omega, 10 / m->omega) * m->omega);
}

static PetscReal LogState(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)model;

  (void)t, (void)k;
  return m->k > 0 ? PetscLog10Real(PetscMin(PetscAbsReal(w[0]) * m->omega / m->k + 1e-4, 10)) : 1;
}

static PetscReal LoadRatio(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)model;

  (void)w, (void)k;
  return PetscMin(PetscAbsReal(m->D * PetscSinReal(m->omega * t)), 1e3 * m->k) / (m->k > 0 ? m->k : 1);
}

static PetscReal Bend(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)model;

  (void)k;
  return (w[0] > 0 ? 1 : (w[0] < 0 ? -1 : 0)) * PetscCosReal(m->omega * t);
}

static PetscReal Rest(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  (void)model, (void)t, (void)k;
  return w[0] == 0 ? 1 : 0;
}

static const SlipModelObservation Observations[] = {
  {"energy", Energy, 0},      /* U/U_c = (w/w_max)^2, w_max = |w(0)| */
  {"velocity", Ratio, 0},     /* w/w_max */
  {"state_0", Ratio, 0},      /* likewise */
  {"log_event", LogEvent, 0}, /* log10 of omega times SlipSlidingModeEvent(), in [-3, 1] */
  {"log_state", LogState, 0}, /* log10(|w| omega/k + 1e-4) in [-4, 1] */
  {"load", LoadRatio, 0},     /* |D sin(omega t)|/k, at most 1e3 */
  {"bend", Bend, 0},          /* cos(omega t) in the direction of w */
  {"rest", Rest, 0},          /* 1 where w = 0 */
  {NULL, NULL, 0},
};

/* ---- the exact solution, phase by phase ---- */

/* Returns s w at time t while w slides with the sign s from w0 at t0. */
static PetscReal Slide(const SlipSlidingMode *m, PetscReal s, PetscReal t0, PetscReal w0, PetscReal t)
{
  return s * (w0 + m->D / m->omega * (PetscCosReal(m->omega * t0) - PetscCosReal(m->omega * t))) - m->k * (t - t0);
}

/* Returns the first time after t at which omega t is an angle of the form angle + n period. */
static PetscReal Next(const SlipSlidingMode *m, PetscReal t, PetscReal angle, PetscReal period)
{
  const PetscReal phase = m->omega * t, rounding = 1e-9;
  PetscReal n = PetscCeilReal((phase - angle) / period);

  if (angle + n * period <= phase + rounding) n += 1;
  return (angle + n * period) / m->omega;
}

/* Returns when the slide from (t0, w0) ends at w = 0, or t when it does not end before. Bisection finds it, as w is
   monotone between the turning points, where D sin(omega t) = s k. */
static PetscReal Arrest(const SlipSlidingMode *m, PetscReal s, PetscReal t0, PetscReal w0, PetscReal t)
{
  const PetscReal angle = m->k < m->D ? PetscAsinReal(s * m->k / m->D) : 0;
  PetscReal from = t0, to = t0;

  while (to < t) {
    from = to;
    to = t;
    if (m->k < m->D) {
      to = PetscMin(to, Next(m, from, angle, 2 * PETSC_PI));
      to = PetscMin(to, Next(m, from, PETSC_PI - angle, 2 * PETSC_PI));
    }
    if (Slide(m, s, t0, w0, to) > 0) continue;
    for (PetscInt i = 0; i < 60; i++) {
      const PetscReal middle = 0.5 * (from + to);

      if (Slide(m, s, t0, w0, middle) > 0)
        from = middle;
      else
        to = middle;
    }
    return to;
  }
  return t;
}

/* Returns when w leaves zero, where it is at t0: once |D sin(omega t)| passes k, in that direction. */
static PetscReal Depart(const SlipSlidingMode *m, PetscReal t0, PetscReal *s)
{
  PetscReal t = t0, load = m->D * PetscSinReal(m->omega * t0);

  *s = load > 0 ? 1 : -1;
  if (m->k >= m->D) return PETSC_MAX_REAL;
  if (PetscAbsReal(load) > m->k) return t0;
  t = Next(m, t0, PetscAsinReal(m->k / m->D), PETSC_PI);
  *s = PetscSinReal(m->omega * t) > 0 ? 1 : -1;
  return t;
}

static PetscReal Exact(SlipModel model, PetscReal t, PetscReal *r)
{
  const SlipSlidingMode *m = (const SlipSlidingMode *)model;
  PetscReal t0 = 0, w0 = model->start[0], s = w0 > 0 ? 1 : -1, end;

  while (PETSC_TRUE) {
    *r = -s * m->k;
    end = Arrest(m, s, t0, w0, t);
    if (end >= t) return s * Slide(m, s, t0, w0, t);
    w0 = 0;
    t0 = Depart(m, end, &s);
    if (t0 >= t) {
      *r = -m->D * PetscSinReal(m->omega * t);
      return 0;
    }
  }
}

static const char *const States[] = {"w"}, *const Units[] = {"1", "1/s"};

const SlipModelOps SlipSlidingModeOps = {
  "sliding_mode", 1,    States,       Units, "1", sizeof(SlipSlidingMode), SetCase, SetFromOptions, SetUp, Force,
  Jacobian,       Load, Observations, Exact, NULL};
