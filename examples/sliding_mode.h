/* First-order sliding mode controller, dw/dt = D sin(omega t) + F_r, F_r in -k Sign(w): the system, its exact solution,
   what policies observe. Public headers only; the program sliding_mode and tests share it. */
#pragma once
#include <slipstep.h>
#include <string.h>

typedef struct {
  PetscReal k, D;  /* gain and disturbance [1/s] */
  PetscReal omega; /* of the disturbance [rad/s] */
  PetscReal start; /* w(0) */
} SlidingMode;

/* The study's two settings. */
static const SlidingMode SlidingModeCases[] = {{2.0, 1.5, 50.0, 0.1}, {2.0, 1.75, 50.0, 0.15}};
static const char *const SlidingModeCaseNames[] = {"training", "evaluation", "SlidingModeCase", "", NULL};

/* setting: the case when -sliding_mode_case is not given, 0 training or 1 evaluation */
static inline PetscErrorCode SlidingModeSetFromOptions(SlidingMode *m, PetscInt setting)
{
  PetscEnum chosen = (PetscEnum)setting;

  PetscFunctionBeginUser;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "First-order sliding mode controller", NULL);
  PetscCall(PetscOptionsEnum("-sliding_mode_case", "Setting that the options below start from", NULL,
                             SlidingModeCaseNames, chosen, &chosen, NULL));
  *m = SlidingModeCases[chosen];
  PetscCall(PetscOptionsReal("-sliding_mode_gain", "Bound k of the reaction [1/s]", NULL, m->k, &m->k, NULL));
  PetscCall(
    PetscOptionsReal("-sliding_mode_amplitude", "Amplitude D of the disturbance [1/s]", NULL, m->D, &m->D, NULL));
  PetscCall(PetscOptionsReal("-sliding_mode_frequency", "Angular frequency omega of the disturbance [rad/s]", NULL,
                             m->omega, &m->omega, NULL));
  PetscCall(PetscOptionsReal("-sliding_mode_start", "Start w(0), not zero", NULL, m->start, &m->start, NULL));
  PetscOptionsEnd();
  PetscCheck(m->k >= 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-sliding_mode_gain is %g, expected a number >= 0",
             (double)m->k);
  PetscCheck(m->omega > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-sliding_mode_frequency is %g, expected a number > 0", (double)m->omega);
  PetscCheck(!PetscIsInfOrNanReal(m->D), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-sliding_mode_amplitude is %g, expected a finite number", (double)m->D);
  PetscCheck(m->start != 0 && !PetscIsInfOrNanReal(m->start), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-sliding_mode_start is %g, expected a finite number other than 0: states are measured in it",
             (double)m->start);
  PetscFunctionReturn(0);
}

/* ---- the system ---- */

static inline PetscErrorCode SlidingModeForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const SlidingMode *m = (const SlidingMode *)ctx;

  PetscFunctionBeginUser;
  (void)w;
  F[0] = m->D * PetscSinReal(m->omega * t);
  PetscFunctionReturn(0);
}

static inline PetscErrorCode SlidingModeJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t;
  (void)w;
  (void)ctx;
  J[0] = 0;
  PetscFunctionReturn(0);
}

static inline PetscErrorCode SlidingModeBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[],
                                              void *ctx)
{
  PetscFunctionBeginUser;
  (void)t;
  (void)w;
  (void)dq; /* zero already */
  q[0] = ((const SlidingMode *)ctx)->k;
  PetscFunctionReturn(0);
}

/* Time to the next change of regime, as it looks at time t: while w moves, until it is zero at its present rate; at
   rest, until the disturbance exceeds the gain. PETSC_MAX_REAL: none in sight. */
static inline PetscReal SlidingModeEvent(const SlidingMode *m, PetscReal t, PetscReal w)
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

/* What policies observe at time t: energy U/U_c = (w/w_max)^2, velocity and state_0 w/w_max, with w_max = |w(0)|;
   log_event log10 of omega times SlidingModeEvent(), in [-3, 1]; log_state log10(|w| omega/k + 1e-4) in [-4, 1]; load
   |D sin(omega t)|/k, at most 1e3; bend cos(omega t) in the direction of w; rest 1 where w = 0. False: not an
   observation of the sliding mode controller. */
static inline PetscBool SlidingModeObservation(const SlidingMode *m, PetscReal t, PetscReal w, const char name[],
                                               PetscReal *value)
{
  const PetscReal ratio = w / PetscAbsReal(m->start), sign = w > 0 ? 1 : (w < 0 ? -1 : 0);

  if (!strcmp(name, "energy")) {
    *value = PetscSqr(ratio);
  } else if (!strcmp(name, "velocity") || !strcmp(name, "state_0")) {
    *value = ratio;
  } else if (!strcmp(name, "log_event")) {
    *value = PetscLog10Real(PetscClipInterval(SlidingModeEvent(m, t, w), 1e-3 / m->omega, 10 / m->omega) * m->omega);
  } else if (!strcmp(name, "log_state")) {
    *value = m->k > 0 ? PetscLog10Real(PetscMin(PetscAbsReal(w) * m->omega / m->k + 1e-4, 10)) : 1;
  } else if (!strcmp(name, "load")) {
    *value = PetscMin(PetscAbsReal(m->D * PetscSinReal(m->omega * t)), 1e3 * m->k) / (m->k > 0 ? m->k : 1);
  } else if (!strcmp(name, "bend")) {
    *value = sign * PetscCosReal(m->omega * t);
  } else if (!strcmp(name, "rest")) {
    *value = sign == 0 ? 1 : 0;
  } else {
    return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* "SlipObserve_C" */
static inline PetscErrorCode SlidingModeObserve(TS ts, const char name[], PetscReal *value, PetscBool *known)
{
  SlipAttempt last;
  SlidingMode *m;
  Vec x;
  const PetscScalar *a;

  PetscFunctionBeginUser;
  PetscCall(TSGetApplicationContext(ts, &m));
  PetscCall(TSGetSolution(ts, &x));
  PetscCall(TSBatheGetLastAttempt(ts, &last)); /* TSGetTime() is the step's start until the controller has chosen */
  PetscCall(VecGetArrayRead(x, &a));
  *known = SlidingModeObservation(m, last.time + last.dt, a[0], name, value);
  PetscCall(VecRestoreArrayRead(x, &a));
  PetscFunctionReturn(0);
}

/* "SlipTimeScale_C": 1/omega. */
static inline PetscErrorCode SlidingModeTimeScale(TS ts, PetscReal *tstar)
{
  SlidingMode *m;

  PetscFunctionBeginUser;
  PetscCall(TSGetApplicationContext(ts, &m));
  *tstar = 1 / m->omega;
  PetscFunctionReturn(0);
}

/* "SlipProblemName_C" */
static inline PetscErrorCode SlidingModeProblemName(TS ts, const char **name)
{
  PetscFunctionBeginUser;
  (void)ts;
  *name = "sliding_mode";
  PetscFunctionReturn(0);
}

/* All that precedes TSSetFromOptions(): 0.5 s, h in [1e-9 s, 2 pi/(10 omega)], first step 1e-4 s, the study's
   tolerances. The study's least step of 1e-5 s is for its policies, whose files hold their own bounds: across the
   arrest an error estimate falls as slowly as h, and controllers that obey it need less than that for some starts. */
static inline PetscErrorCode SlidingModeConfigureTS(SlidingMode *m, TS ts)
{
  const PetscReal mass[] = {1};
  const PetscInt rows[] = {0};
  const SlipSmall problem = {.n = 1,
                             .mass = mass,
                             .nrows = 1,
                             .rows = rows,
                             .force = SlidingModeForce,
                             .jacobian = SlidingModeJacobian,
                             .bound = SlidingModeBound,
                             .ctx = m};
  TSAdapt adapt;

  PetscFunctionBeginUser;
  PetscCall(SlipSmallConfigureTS(&problem, ts));
  PetscCall(TSSetMaxTime(ts, 0.5));
  PetscCall(TSSetTimeStep(ts, 1e-4));
  PetscCall(TSSetTolerances(ts, 1e-6, NULL, 1e-3, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTHEURISTIC));
  PetscCall(TSAdaptSetStepLimits(adapt, 1e-9, 2 * PETSC_PI / (10 * m->omega)));
  PetscCall(TSSetApplicationContext(ts, m));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipObserve_C", SlidingModeObserve));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipTimeScale_C", SlidingModeTimeScale));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipProblemName_C", SlidingModeProblemName));
  PetscFunctionReturn(0);
}

/* ---- the exact solution, phase by phase ---- */

/* s w at time t while w slides with the sign s from w0 at t0 */
static inline PetscReal SlidingModeSlide(const SlidingMode *m, PetscReal s, PetscReal t0, PetscReal w0, PetscReal t)
{
  return s * (w0 + m->D / m->omega * (PetscCosReal(m->omega * t0) - PetscCosReal(m->omega * t))) - m->k * (t - t0);
}

/* First time after t at which omega t is an angle of the form angle + n period */
static inline PetscReal SlidingModeNext(const SlidingMode *m, PetscReal t, PetscReal angle, PetscReal period)
{
  const PetscReal phase = m->omega * t, rounding = 1e-9;
  PetscReal n = PetscCeilReal((phase - angle) / period);

  if (angle + n * period <= phase + rounding) n += 1;
  return (angle + n * period) / m->omega;
}

/* When the slide from (t0, w0) ends at w = 0; t when it does not end before. Between the turning points, where
   D sin(omega t) = s k, w is monotone: bisection. */
static inline PetscReal SlidingModeArrest(const SlidingMode *m, PetscReal s, PetscReal t0, PetscReal w0, PetscReal t)
{
  const PetscReal angle = m->k < m->D ? PetscAsinReal(s * m->k / m->D) : 0;
  PetscReal from = t0, to = t0;

  while (to < t) {
    from = to;
    to = t;
    if (m->k < m->D) {
      to = PetscMin(to, SlidingModeNext(m, from, angle, 2 * PETSC_PI));
      to = PetscMin(to, SlidingModeNext(m, from, PETSC_PI - angle, 2 * PETSC_PI));
    }
    if (SlidingModeSlide(m, s, t0, w0, to) > 0) continue;
    for (PetscInt i = 0; i < 60; i++) {
      const PetscReal middle = 0.5 * (from + to);

      if (SlidingModeSlide(m, s, t0, w0, middle) > 0)
        from = middle;
      else
        to = middle;
    }
    return to;
  }
  return t;
}

/* When w leaves zero, being there at t0: once |D sin(omega t)| passes k, in that direction */
static inline PetscReal SlidingModeDepart(const SlidingMode *m, PetscReal t0, PetscReal *s)
{
  PetscReal t = t0, load = m->D * PetscSinReal(m->omega * t0);

  *s = load > 0 ? 1 : -1;
  if (m->k >= m->D) return PETSC_MAX_REAL;
  if (PetscAbsReal(load) > m->k) return t0;
  t = SlidingModeNext(m, t0, PetscAsinReal(m->k / m->D), PETSC_PI);
  *s = PetscSinReal(m->omega * t) > 0 ? 1 : -1;
  return t;
}

/* The exact w and reaction at time t from w(0) = start */
static inline PetscReal SlidingModeExact(const SlidingMode *m, PetscReal t, PetscReal *r)
{
  PetscReal t0 = 0, w0 = m->start, s = w0 > 0 ? 1 : -1, end;

  while (PETSC_TRUE) {
    *r = -s * m->k;
    end = SlidingModeArrest(m, s, t0, w0, t);
    if (end >= t) return s * SlidingModeSlide(m, s, t0, w0, t);
    w0 = 0;
    t0 = SlidingModeDepart(m, end, &s);
    if (t0 >= t) {
      *r = -m->D * PetscSinReal(m->omega * t);
      return 0;
    }
  }
}
