/* Circuit with an ideal Zener diode, states (V1, V2, i), a small system on one process:
     C1 dV1/dt = (V2 - V1)/R + r,  C2 dV2/dt = (V1 - V2)/R + i,  L di/dt = -V2,  r in -m Sign(V1).
   Its energy U = (C1 V1^2 + C2 V2^2 + L i^2)/2 falls at the rate (V1 - V2)^2/R + m |V1|. Public headers only; the
   program circuit and tests share it. */
#pragma once
#include <slipstep.h>
#include <string.h>

#define CIRCUIT_N 3

typedef struct {
  PetscReal C1, C2, R, L;         /* [F], [F], [Ohm], [H] */
  PetscReal m;                    /* current of the diode [A] */
  PetscReal start[CIRCUIT_N];     /* V1 [V], V2 [V], i [A] */
  PetscReal max_time;             /* [s] */
  PetscReal amplitude[CIRCUIT_N]; /* what states are measured in */
} Circuit;

/* The study's two settings. */
static const Circuit CircuitCases[] = {
  {1.0 / 9, 1, 1 / 0.7, 1.0 / 7, 0.8, {0.15264, -0.02281, 0.38127}, 10, {0, 0, 0}},
  {1.0 / 9, 1, 1 / 0.7, 1.0 / 7, 0.8, {9.998048, 1.980972, -10.908448}, 20, {0, 0, 0}}};
static const char *const CircuitCaseNames[] = {"training", "evaluation", "CircuitCase", "", NULL};
static const char *const CircuitUnitNames[] = {"amplitude", "start", "CircuitUnit", "", NULL};

static inline PetscReal CircuitEnergy(const Circuit *c, const PetscReal w[])
{
  return 0.5 * (c->C1 * PetscSqr(w[0]) + c->C2 * PetscSqr(w[1]) + c->L * PetscSqr(w[2]));
}

/* The amplitude each state would have if all the energy of the start were in it, or its own start as in the study's
   program */
static inline PetscErrorCode CircuitSetUnits(Circuit *c, PetscBool from_start)
{
  const PetscReal inertia[] = {c->C1, c->C2, c->L}, twice = 2 * CircuitEnergy(c, c->start);

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < CIRCUIT_N; k++) {
    PetscCheck(inertia[k] > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-circuit_%s is %g, expected a number > 0",
               k == 0   ? "c1"
               : k == 1 ? "c2"
                        : "l",
               (double)inertia[k]);
    PetscCheck(twice > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "-circuit_start is 0, 0, 0, expected a start with energy: states are measured in it");
    PetscCheck(!from_start || c->start[k] != 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "-circuit_unit start needs a -circuit_start without zeros, its entry %d is 0", (int)k);
    c->amplitude[k] = from_start ? c->start[k] : PetscSqrtReal(twice / inertia[k]);
  }
  PetscFunctionReturn(0);
}

/* setting: the case when -circuit_case is not given, 0 training or 1 evaluation */
static inline PetscErrorCode CircuitSetFromOptions(Circuit *c, PetscInt setting)
{
  PetscEnum chosen = (PetscEnum)setting, unit = (PetscEnum)0;
  PetscInt n = CIRCUIT_N;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Circuit with an ideal Zener diode", NULL);
  PetscCall(PetscOptionsEnum("-circuit_case", "Setting that the options below start from", NULL, CircuitCaseNames,
                             chosen, &chosen, NULL));
  *c = CircuitCases[chosen];
  PetscCall(PetscOptionsReal("-circuit_c1", "Capacity C1 [F]", NULL, c->C1, &c->C1, NULL));
  PetscCall(PetscOptionsReal("-circuit_c2", "Capacity C2 [F]", NULL, c->C2, &c->C2, NULL));
  PetscCall(PetscOptionsReal("-circuit_r", "Resistance R [Ohm]", NULL, c->R, &c->R, NULL));
  PetscCall(PetscOptionsReal("-circuit_l", "Inductance L [H]", NULL, c->L, &c->L, NULL));
  PetscCall(PetscOptionsReal("-circuit_m", "Current m of the diode [A]", NULL, c->m, &c->m, NULL));
  PetscCall(PetscOptionsRealArray("-circuit_start", "V1 [V], V2 [V], i [A] at the start", NULL, c->start, &n, &set));
  PetscCheck(!set || n == CIRCUIT_N, PETSC_COMM_WORLD, PETSC_ERR_ARG_SIZ, "-circuit_start has %d numbers, expected 3",
             (int)n);
  PetscCall(
    PetscOptionsReal("-ts_max_time", "End [s]; the largest step follows it", NULL, c->max_time, &c->max_time, NULL));
  PetscCall(
    PetscOptionsEnum("-circuit_unit",
                     "Policies observe states over the amplitude that the energy of the start allows each, or over "
                     "their start (the study's program)",
                     NULL, CircuitUnitNames, unit, &unit, NULL));
  PetscOptionsEnd();
  PetscCheck(c->R > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-circuit_r is %g, expected a number > 0",
             (double)c->R);
  PetscCheck(c->m >= 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-circuit_m is %g, expected a number >= 0",
             (double)c->m);
  PetscCheck(c->max_time > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-ts_max_time is %g, expected a number > 0",
             (double)c->max_time);
  PetscCall(CircuitSetUnits(c, unit ? PETSC_TRUE : PETSC_FALSE));
  PetscFunctionReturn(0);
}

/* ---- the system ---- */

static inline PetscErrorCode CircuitForce(PetscReal t, const PetscReal w[], PetscReal F[], void *ctx)
{
  const Circuit *c = (const Circuit *)ctx;

  PetscFunctionBeginUser;
  (void)t;
  F[0] = (w[1] - w[0]) / c->R;
  F[1] = (w[0] - w[1]) / c->R + w[2];
  F[2] = -w[1];
  PetscFunctionReturn(0);
}

static inline PetscErrorCode CircuitJacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *ctx)
{
  const PetscReal g = 1 / ((const Circuit *)ctx)->R, values[] = {-g, g, 0, g, -g, 1, 0, -1, 0};

  PetscFunctionBeginUser;
  (void)t;
  (void)w;
  PetscCall(PetscArraycpy(J, values, CIRCUIT_N * CIRCUIT_N));
  PetscFunctionReturn(0);
}

static inline PetscErrorCode CircuitBound(PetscReal t, const PetscReal w[], PetscReal q[], PetscReal dq[], void *ctx)
{
  PetscFunctionBeginUser;
  (void)t;
  (void)w;
  (void)dq; /* zero already */
  q[0] = ((const Circuit *)ctx)->m;
  PetscFunctionReturn(0);
}

/* log10 of the time in which V1 gets to zero at its present rate [T*], in [-3, 1]; 1 when it does not or is there.
   Where V1 crosses zero its rate jumps by up to 2 m/C1, and a step across that is of first order only. */
static inline PetscReal CircuitLogEvent(const Circuit *c, const PetscReal w[])
{
  const PetscReal rate = ((w[1] - w[0]) / c->R - (w[0] > 0 ? c->m : -c->m)) / c->C1;
  const PetscReal left = rate * w[0] < 0 ? -w[0] / rate / PetscSqrtReal(c->L * c->C2) : 10;

  return PetscLog10Real(PetscClipInterval(left, (PetscReal)1e-3, (PetscReal)10));
}

/* log10 of the V1 that the energy allows over the voltage m R at which the diode holds V1, in [-3, 3] */
static inline PetscReal CircuitLogLevel(const Circuit *c, const PetscReal w[])
{
  const PetscReal level = PetscSqrtReal(2 * CircuitEnergy(c, w) / c->C1), held = c->m * c->R;

  return PetscLog10Real(PetscClipInterval(level, 1e-3 * held, 1e3 * held) / held);
}

/* What policies observe: energy U/U_0 and its log10, at least -16; state_0, state_1, state_2: V1, V2, i over what they
   are measured in; log_event and log_level as above, log_level 3 without a diode. False: not an observation of the
   circuit. */
static inline PetscBool CircuitObservation(const Circuit *c, const PetscReal w[], const char name[], PetscReal *value)
{
  const PetscReal energy = CircuitEnergy(c, w) / CircuitEnergy(c, c->start);

  if (!strcmp(name, "energy")) {
    *value = energy;
  } else if (!strcmp(name, "log_energy")) {
    *value = PetscLog10Real(PetscMax(energy, (PetscReal)1e-16));
  } else if (!strcmp(name, "log_event")) {
    *value = CircuitLogEvent(c, w);
  } else if (!strcmp(name, "log_level")) {
    *value = c->m > 0 ? CircuitLogLevel(c, w) : 3;
  } else if (!strncmp(name, "state_", 6) && name[6] >= '0' && name[6] < '0' + CIRCUIT_N && !name[7]) {
    *value = w[name[6] - '0'] / c->amplitude[name[6] - '0'];
  } else {
    return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* "SlipObserve_C" */
static inline PetscErrorCode CircuitObserve(TS ts, const char name[], PetscReal *value, PetscBool *known)
{
  Circuit *c;
  Vec w;
  const PetscScalar *a;

  PetscFunctionBeginUser;
  PetscCall(TSGetApplicationContext(ts, &c));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(VecGetArrayRead(w, &a));
  *known = CircuitObservation(c, a, name, value);
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(0);
}

/* "SlipTimeScale_C": sqrt(L C2). */
static inline PetscErrorCode CircuitTimeScale(TS ts, PetscReal *tstar)
{
  Circuit *c;

  PetscFunctionBeginUser;
  PetscCall(TSGetApplicationContext(ts, &c));
  *tstar = PetscSqrtReal(c->L * c->C2);
  PetscFunctionReturn(0);
}

/* "SlipProblemName_C" */
static inline PetscErrorCode CircuitProblemName(TS ts, const char **name)
{
  PetscFunctionBeginUser;
  (void)ts;
  *name = "circuit";
  PetscFunctionReturn(0);
}

/* All that precedes TSSetFromOptions(): h in [1e-9 s, t_max/10], first step 1e-3 s, the study's tolerances. As in
   sliding_mode.h, the study's least step of 1e-5 s is left to the policies' files. */
static inline PetscErrorCode CircuitConfigureTS(Circuit *c, TS ts)
{
  const PetscReal mass[] = {c->C1, c->C2, c->L};
  const PetscInt rows[] = {0};
  const SlipSmall problem = {.n = CIRCUIT_N,
                             .mass = mass,
                             .nrows = 1,
                             .rows = rows,
                             .force = CircuitForce,
                             .jacobian = CircuitJacobian,
                             .bound = CircuitBound,
                             .ctx = c};
  TSAdapt adapt;

  PetscFunctionBeginUser;
  PetscCall(SlipSmallConfigureTS(&problem, ts));
  PetscCall(TSSetMaxTime(ts, c->max_time));
  PetscCall(TSSetTimeStep(ts, 1e-3));
  PetscCall(TSSetTolerances(ts, 1e-8, NULL, 1e-6, NULL));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTHEURISTIC));
  PetscCall(TSAdaptSetStepLimits(adapt, 1e-9, c->max_time / 10));
  PetscCall(TSSetApplicationContext(ts, c));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipObserve_C", CircuitObserve));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipTimeScale_C", CircuitTimeScale));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "SlipProblemName_C", CircuitProblemName));
  PetscFunctionReturn(0);
}

static inline PetscErrorCode CircuitCreateState(const Circuit *c, Vec *w)
{
  PetscScalar *a;

  PetscFunctionBeginUser;
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, CIRCUIT_N, w));
  PetscCall(VecGetArrayWrite(*w, &a));
  PetscCall(PetscArraycpy(a, c->start, CIRCUIT_N));
  PetscCall(VecRestoreArrayWrite(*w, &a));
  PetscFunctionReturn(0);
}

/* ---- the exact solution, phase by phase ---- */

/* Time t on from a state while V1 keeps the given sign, or rests for sign 0: the system is linear then, and 16 terms of
   its Taylor series are exact to rounding while t is less than a fifth of the shortest time of the circuit. */
static inline void CircuitFlow(const Circuit *c, int sign, PetscReal t, const PetscReal from[], PetscReal to[])
{
  const PetscReal inertia[CIRCUIT_N] = {c->C1, c->C2, c->L};
  PetscReal term[CIRCUIT_N] = {from[0], from[1], from[2]};

  for (int k = 0; k < CIRCUIT_N; k++) to[k] = from[k];
  for (int n = 1; n <= 16; n++) {
    PetscReal F[CIRCUIT_N] = {(term[1] - term[0]) / c->R, (term[0] - term[1]) / c->R + term[2], -term[1]};

    if (n == 1) F[0] -= sign * c->m;
    if (!sign) F[0] = 0;
    for (int k = 0; k < CIRCUIT_N; k++) {
      term[k] = F[k] / inertia[k] * t / n;
      to[k] += term[k];
    }
  }
}

/* Does a phase go on at a state? V1 keeps its sign; at rest V2 drives no more current than the diode bears. */
static inline PetscBool CircuitPhaseHolds(const Circuit *c, int sign, const PetscReal w[])
{
  if (sign) return sign * w[0] >= 0 ? PETSC_TRUE : PETSC_FALSE;
  return PetscAbsReal(w[1]) <= c->m * c->R ? PETSC_TRUE : PETSC_FALSE;
}

/* The sign of the phase that begins at a state with V1 = 0 */
static inline int CircuitPhaseFromRest(const Circuit *c, const PetscReal w[])
{
  if (CircuitPhaseHolds(c, 0, w)) return 0;
  return w[1] > 0 ? 1 : -1;
}

/* The exact state after time t, in which a phase does not begin and end: t is that of CircuitFlow(). The end of a phase
   is found by bisection. sign: of the phase, CircuitPhaseFromRest() or the sign of V1 at the start. */
static inline void CircuitAdvance(const Circuit *c, PetscReal t, int *sign, PetscReal w[])
{
  PetscReal to[CIRCUIT_N];

  for (int phases = 0; phases < 10; phases++) {
    PetscReal low = 0, high = t;

    CircuitFlow(c, *sign, t, w, to);
    if (CircuitPhaseHolds(c, *sign, to)) break;
    for (int i = 0; i < 50; i++) {
      const PetscReal middle = 0.5 * (low + high);

      CircuitFlow(c, *sign, middle, w, to);
      if (CircuitPhaseHolds(c, *sign, to))
        low = middle;
      else
        high = middle;
    }
    CircuitFlow(c, *sign, high, w, to);
    if (*sign) to[0] = 0;
    *sign = *sign ? CircuitPhaseFromRest(c, to) : (to[1] > 0 ? 1 : -1);
    for (int k = 0; k < CIRCUIT_N; k++) w[k] = to[k];
    t -= high;
  }
  for (int k = 0; k < CIRCUIT_N; k++) w[k] = to[k];
}
