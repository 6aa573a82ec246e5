/* Defines the circuit with an ideal Zener diode, states (V1, V2, i), see slipmodels.h: the system, the observations of
   policies, and its exact solution. */
#include <slipstep/rooms/slipmodels.h>
#include <slipcompat.h>
#include <string.h>

#define N 3

static PetscErrorCode SetCase(SlipModel model, SlipModelCase setting)
{
  const PetscReal start[][N] = {{0.15264, -0.02281, 0.38127}, {9.998048, 1.980972, -10.908448}};
  SlipCircuit *c = (SlipCircuit *)model;

  PetscFunctionBegin;
  c->C1 = 1.0 / 9;
  c->C2 = 1;
  c->R = 1 / 0.7;
  c->L = 1.0 / 7;
  c->m = 0.8;
  PetscCall(PetscArraycpy(model->start, start[setting], N));
  model->max_time = setting == SLIP_MODEL_TRAINING ? 10 : 20;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetFromOptions(SlipModel model)
{
  const char *const units[] = {"amplitude", "start", "CircuitUnit", "", NULL};
  SlipCircuit *c = (SlipCircuit *)model;
  PetscEnum setting = (PetscEnum)model->setting, unit = (PetscEnum)0;
  PetscInt n = N;
  PetscBool set;

  PetscFunctionBegin;
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Circuit with an ideal Zener diode", NULL);
  PetscCall(PetscOptionsEnum("-circuit_case", "Setting that the options below start from", NULL, SlipModelCases,
                             setting, &setting, NULL));
  PetscCall(SetCase(model, (SlipModelCase)setting));
  PetscCall(PetscOptionsReal("-circuit_c1", "Capacity C1 [F]", NULL, c->C1, &c->C1, NULL));
  PetscCall(PetscOptionsReal("-circuit_c2", "Capacity C2 [F]", NULL, c->C2, &c->C2, NULL));
  PetscCall(PetscOptionsReal("-circuit_r", "Resistance R [Ohm]", NULL, c->R, &c->R, NULL));
  PetscCall(PetscOptionsReal("-circuit_l", "Inductance L [H]", NULL, c->L, &c->L, NULL));
  PetscCall(PetscOptionsReal("-circuit_m", "Current m of the diode [A]", NULL, c->m, &c->m, NULL));
  PetscCall(
    PetscOptionsRealArray("-circuit_start", "V1 [V], V2 [V], i [A] at the start", NULL, model->start, &n, &set));
  PetscCheck(!set || n == N, PETSC_COMM_WORLD, PETSC_ERR_ARG_SIZ, "-circuit_start has %d numbers, expected 3", (int)n);
  PetscCall(PetscOptionsReal("-ts_max_time", "End [s]; the largest step follows it", NULL, model->max_time,
                             &model->max_time, NULL));
  PetscCall(
    PetscOptionsEnum("-circuit_unit",
                     "Policies observe states over the amplitude that the energy of the start allows each, or over "
                     "their start (the study's program)",
                     NULL, units, unit, &unit, NULL));
  PetscOptionsEnd();
  c->unit_start = unit ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(SlipModel model)
{
  const char *const options[N] = {"-circuit_c1", "-circuit_c2", "-circuit_l"};
  SlipCircuit *c = (SlipCircuit *)model;
  const PetscReal mass[N] = {c->C1, c->C2, c->L};
  PetscReal twice;

  PetscFunctionBegin;
  PetscCheck(c->R > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-circuit_r is %g, expected a number > 0",
             (double)c->R);
  PetscCheck(c->m >= 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "-circuit_m is %g, expected a number >= 0",
             (double)c->m);
  PetscCheck(model->max_time > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_max_time is %g, expected a number > 0", (double)model->max_time);
  for (PetscInt k = 0; k < N; k++)
    PetscCheck(mass[k] > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE, "%s is %g, expected a number > 0", options[k],
               (double)mass[k]);
  PetscCall(PetscArraycpy(model->mass, mass, N));
  for (PetscInt k = 0; k < N; k++)
    PetscCheck(!PetscIsInfOrNanReal(model->start[k]), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "-circuit_start has %g, expected finite numbers", (double)model->start[k]);
  twice = 2 * SlipModelEnergy(model, model->start);
  PetscCheck(twice > 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "-circuit_start is 0, 0, 0, expected a start with energy: states are measured in it");
  for (PetscInt k = 0; k < N; k++) {
    PetscCheck(!c->unit_start || model->start[k] != 0, PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
               "-circuit_unit start needs a -circuit_start without zeros, its entry %d is 0", (int)k);
    c->amplitude[k] = c->unit_start ? model->start[k] : PetscSqrtReal(twice / mass[k]);
  }
  model->bound = c->m;
  model->tstar = PetscSqrtReal(c->L * c->C2);
  model->dt = 1e-3;
  model->dt_max = model->max_time / 10;
  model->atol = 1e-8;
  model->rtol = 1e-6;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Force(PetscReal t, const PetscReal w[], PetscReal F[], void *model)
{
  const SlipCircuit *c = (const SlipCircuit *)model;

  PetscFunctionBegin;
  (void)t;
  F[0] = (w[1] - w[0]) / c->R;
  F[1] = (w[0] - w[1]) / c->R + w[2];
  F[2] = -w[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(PetscReal t, const PetscReal w[], PetscReal J[], void *model)
{
  const PetscReal g = 1 / ((const SlipCircuit *)model)->R, values[] = {-g, g, 0, g, -g, 1, 0, -1, 0};

  PetscFunctionBegin;
  (void)t, (void)w;
  PetscCall(PetscArraycpy(J, values, N * N));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Energy(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  (void)t, (void)k;
  return SlipModelEnergy(model, w) / SlipModelEnergy(model, model->start);
}

static PetscReal LogEnergy(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  return PetscLog10Real(PetscMax(Energy(model, t, w, k), (PetscReal)1e-16));
}

/* Where V1 crosses zero its rate jumps by up to 2 m/C1, and a step across the jump has only first order. */
static PetscReal LogEvent(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  const SlipCircuit *c = (const SlipCircuit *)model;
  const PetscReal rate = ((w[1] - w[0]) / c->R - (w[0] > 0 ? c->m : -c->m)) / c->C1;
  const PetscReal left = rate * w[0] < 0 ? -w[0] / rate / PetscSqrtReal(c->L * c->C2) : 10;

  (void)t, (void)k;
  return PetscLog10Real(PetscClipInterval(left, (PetscReal)1e-3, (PetscReal)10));
}

static PetscReal LogLevel(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  const SlipCircuit *c = (const SlipCircuit *)model;
  const PetscReal level = PetscSqrtReal(2 * SlipModelEnergy(model, w) / c->C1), held = c->m * c->R;

  (void)t, (void)k;
  return c->m > 0 ? PetscLog10Real(PetscClipInterval(level, 1e-3 * held, 1e3 * held) / held) : 3;
}

static PetscReal State(SlipModel model, PetscReal t, const PetscReal w[], PetscInt k)
{
  (void)t;
  return w[k] / ((const SlipCircuit *)model)->amplitude[k];
}

static const SlipModelObservation Observations[] = {
  {"energy", Energy, 0},        /* U/U_0 */
  {"log_energy", LogEnergy, 0}, /* its log10, at least -16 */
  {"log_event", LogEvent, 0}, /* log10 of the time in which V1 gets to zero at its present rate [T*], in [-3, 1]; 1 when
                                   it does not or is there */
  {"log_level", LogLevel, 0}, /* log10 of the V1 that the energy allows over the voltage m R at which the diode holds
                                   V1, in [-3, 3]; 3 without a diode */
  {"state_0", State, 0},      /* V1, V2, i over their units */
  {"state_1", State, 1},        {"state_2", State, 2}, {NULL, NULL, 0},
};

/* ---- the exact solution, phase by phase ---- */

/* Implements SlipCircuitFlow(). The table calls it some 1e5 times, and an exported function would not be inlined. */
static void Flow(const SlipCircuit *c, int sign, PetscReal t, const PetscReal from[], PetscReal to[])
{
  const PetscReal inertia[N] = {c->C1, c->C2, c->L};
  PetscReal term[N] = {from[0], from[1], from[2]};

  for (int k = 0; k < N; k++) to[k] = from[k];
  for (int n = 1; n <= 16; n++) {
    PetscReal F[N] = {(term[1] - term[0]) / c->R, (term[0] - term[1]) / c->R + term[2], -term[1]};

    if (n == 1) F[0] -= sign * c->m;
    if (!sign) F[0] = 0;
    for (int k = 0; k < N; k++) {
      term[k] = F[k] / inertia[k] * t / n;
      to[k] += term[k];
    }
  }
}

/* Returns whether a phase continues: V1 keeps its sign, or at rest V2 drives no more current than the diode bears. */
static PetscBool PhaseHolds(const SlipCircuit *c, int sign, const PetscReal w[])
{
  if (sign) return sign * w[0] >= 0 ? PETSC_TRUE : PETSC_FALSE;
  return PetscAbsReal(w[1]) <= c->m * c->R ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the sign of the phase that begins at a state with V1 = 0. */
static int PhaseFromRest(const SlipCircuit *c, const PetscReal w[])
{
  if (PhaseHolds(c, 0, w)) return 0;
  return w[1] > 0 ? 1 : -1;
}

/* Implements SlipCircuitAdvance(). */
static void Advance(const SlipCircuit *c, PetscReal t, int *sign, PetscReal w[])
{
  PetscReal to[N];

  for (int phases = 0; phases < 10; phases++) {
    PetscReal low = 0, high = t;

    Flow(c, *sign, t, w, to);
    if (PhaseHolds(c, *sign, to)) break;
    for (int i = 0; i < 50; i++) {
      const PetscReal middle = 0.5 * (low + high);

      Flow(c, *sign, middle, w, to);
      if (PhaseHolds(c, *sign, to))
        low = middle;
      else
        high = middle;
    }
    Flow(c, *sign, high, w, to);
    if (*sign) to[0] = 0;
    *sign = *sign ? PhaseFromRest(c, to) : (to[1] > 0 ? 1 : -1);
    for (int k = 0; k < N; k++) w[k] = to[k];
    t -= high;
  }
  for (int k = 0; k < N; k++) w[k] = to[k];
}

/* Computes the exact state of the circuit after a time, while V1 keeps its sign or rests. sign: 1 or -1, that of V1, or
   0: it rests; t: the time [s], less than a fifth of the shortest time of the circuit; from: the state now [3]; to: the
   state then [3]. The system is linear, and 16 terms of its Taylor series are exact to rounding for such times. */
void SlipCircuitFlow(const SlipCircuit *c, int sign, PetscReal t, const PetscReal from[], PetscReal to[])
{
  Flow(c, sign, t, from, to);
}

/* Computes the exact state of the circuit after a time, across the ends of phases. t: the time [s], so short that no
   phase begins and ends within it, and short enough for SlipCircuitFlow(); sign: of the phase: that of V1, 0 while it
   rests; w: the state [3]. Bisection finds the end of a phase. */
void SlipCircuitAdvance(const SlipCircuit *c, PetscReal t, int *sign, PetscReal w[])
{
  Advance(c, t, sign, w);
}

static void Table(SlipModel model, PetscReal dt, PetscInt n, PetscReal state[])
{
  const SlipCircuit *c = (const SlipCircuit *)model;
  const PetscReal rate = 1 / (c->C1 * c->R) + 1 / (c->C2 * c->R) + 1 / PetscSqrtReal(c->L * c->C2);
  const PetscInt parts = (PetscInt)PetscCeilReal(5 * rate * dt); /* for SlipCircuitFlow() */
  int sign = model->start[0] > 0 ? 1 : (model->start[0] < 0 ? -1 : PhaseFromRest(c, model->start));
  PetscReal w[N];

  for (PetscInt i = 0; i < N; ++i) w[i] = state[i] = model->start[i];
  for (PetscInt k = 1; k < n; ++k) {
    for (PetscInt part = 0; part < parts; ++part) Advance(c, dt / (PetscReal)parts, &sign, w);
    for (PetscInt i = 0; i < N; ++i) state[N * k + i] = w[i];
  }
}

static const char *const States[] = {"V1", "V2", "i"}, *const Units[] = {"V", "V", "A", "A"};

/* In the order of SlipModelOps */
const SlipModelOps SlipCircuitOps = {"circuit",      N,     States, Units,    "J",  sizeof(SlipCircuit), SetCase,
                                     SetFromOptions, SetUp, Force,  Jacobian, NULL, Observations,        NULL,
                                     Table};
