static const char help[] =
  "A user's friction laws: rate-and-state friction whose evolution effect ends at a cut-off "
  "rate, and with two states; and friction that weakens when a time comes.\n  friction_law -fault_cut_off_rate 1e-3 "
  "-fault_loading_rate 1e-9 -ts_max_time 1e10\n  friction_law -fault_friction_law two_states "
  "-fault_friction_b_2 -0.005 -fault_friction_slip_2 1\nAll else is as in fault.\n\n";

#include <slipstep.h>
#include <math.h>

/* ---- a parameter of its own ---- */

/* v_c: the option -fault_cut_off_rate, or cell by cell a dataset of -fault_parameters or SlipFaultSetField(). Constant,
   as the library refers to it. */
static const SlipParameter own[] = {{.name = "cut_off_rate",
                                     .value = 1e-2,
                                     .unit = "m/s",
                                     .lower = 0,
                                     .upper = PETSC_MAX_REAL,
                                     .open = PETSC_TRUE, /* > 0 */
                                     .help = "Slip rate v_c from which on friction does not weaken"},
                                    {.name = NULL}};
enum { CUT_OFF_RATE };

/*
  Friction that weakens with the slip rate up to a cut-off rate v_c and strengthens beyond it (Okubo 1989; Shibazaki &
  Shimamoto 2007), regularised as rate-and-state friction is:

     mu = a asinh( v/(2 V0) exp((f0 + b g)/a) ),   g = ln(exp(psi) + V0/v_c),   exp(psi) = V0 theta/d_c

  s[0] is psi. A law fills in mu and its derivatives with respect to s and v.
*/
static void CutOff(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal dmu_ds[],
                   PetscReal *dmu_dv)
{
  const PetscReal end = p->reference_rate / p->own[CUT_OFF_RATE], g = log(exp(s[0]) + end);

  SlipRateAndState(p, &g, v, mu, dmu_ds, dmu_dv);
  dmu_ds[0] *= exp(s[0]) / (exp(s[0]) + end);
}

/* The rate of s and its derivatives: the aging or the slip law, which are there to be used. */
static void Evolve(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal drate_ds[],
                   PetscReal drate_dv[])
{
  SlipRateAndStateRate(p, s, v, rate, drate_ds, drate_dv);
}

/* Where nothing changes at the rate v: theta = d_c/v */
static void Steady(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  s[0] = log(p->reference_rate / v);
}

/* What it is called, and which parameter it starts with */
static const SlipFrictionState psi[] = {{.name = "state", .start = "initial_state"}};

static const SlipFrictionLaw cut_off = {.name = "cut_off",
                                        .eval = CutOff,
                                        .formula =
                                          "a asinh(|v|/(2 V0) exp((f0 + b ln(V0 theta/slip + V0/cut_off_rate))/a))",
                                        .by_rate = PETSC_TRUE,
                                        .always_slides = PETSC_TRUE,
                                        .states = psi,
                                        .nstates = 1,
                                        .rate = Evolve,
                                        .steady = Steady,
                                        .own = own};

/* ---- two states ---- */

static const SlipParameter own_of_two[] = {{.name = "friction_b_2",
                                            .value = 0,
                                            .unit = "",
                                            .lower = PETSC_MIN_REAL,
                                            .upper = PETSC_MAX_REAL,
                                            .help = "Evolution effect b_2 of the second state"},
                                           {.name = "friction_slip_2",
                                            .value = 0.1,
                                            .unit = "m",
                                            .lower = 0,
                                            .upper = PETSC_MAX_REAL,
                                            .open = PETSC_TRUE,
                                            .help = "Slip d_2 in which the second state evolves"},
                                           {.name = "initial_state_2",
                                            .value = (PetscReal)NAN, /* steady, unless it is given */
                                            .unit = "s",
                                            .lower = 0,
                                            .upper = PETSC_MAX_REAL,
                                            .open = PETSC_TRUE,
                                            .help = "Second state at the start (default: steady)"},
                                           {.name = NULL}};
enum { B_2, SLIP_2 };

/* The parameters of rate-and-state friction with d_2 in place of d_c */
static SlipFriction Second(const SlipFriction *p)
{
  SlipFriction second = *p;

  second.slip = p->own[SLIP_2];
  return second;
}

/*
  Rate-and-state friction with two states (Ruina 1983; Gu et al. 1984), regularised:

     mu = a asinh( v/(2 V0) exp((f0 + b psi_1 + b_2 psi_2)/a) ),   psi_k = ln(V0 theta_k/d_k)

  each evolving in its slip d_k by -fault_state_law. By the slip law it is, in Ruina's words with Theta_k = b_k psi_k,
  mu = f0 + a ln(v/V0) + Theta_1 + Theta_2 and dTheta_k/dt = -(v/d_k)(Theta_k + b_k ln(v/V0)).
*/
static void TwoStates(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *mu, PetscReal dmu_ds[],
                      PetscReal *dmu_dv)
{
  const PetscReal sum = p->b * s[0] + p->own[B_2] * s[1];
  SlipFriction whole = *p;

  whole.b = 1; /* the sum takes the place of b psi */
  SlipRateAndState(&whole, &sum, v, mu, dmu_ds, dmu_dv);
  dmu_ds[1] = dmu_ds[0] * p->own[B_2];
  dmu_ds[0] *= p->b;
}

/* Neither rate depends on the other state: entries 1 and 2 of drate_ds [2][2] stay 0. */
static void EvolveTwo(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal drate_ds[],
                      PetscReal drate_dv[])
{
  const SlipFriction second = Second(p);

  SlipRateAndStateRate(p, s, v, rate, drate_ds, drate_dv);
  SlipRateAndStateRate(&second, s + 1, v, rate + 1, drate_ds + 3, drate_dv + 1);
}

static void SteadyTwo(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  s[0] = s[1] = log(p->reference_rate / v);
}

static PetscReal Theta2(const SlipFriction *p, PetscReal s)
{
  const SlipFriction second = Second(p);

  return SlipRateAndStateTheta(&second, s);
}

static PetscReal OfTheta2(const SlipFriction *p, PetscReal theta)
{
  const SlipFriction second = Second(p);

  return SlipRateAndStateOfTheta(&second, theta);
}

/* Outputs have /fields/state and /fields/state_2 in s, stations columns of these names. */
static const SlipFrictionState both[] = {
  {.name = "state",
   .unit = "s",
   .start = "initial_state",
   .shown = SlipRateAndStateTheta,
   .of_shown = SlipRateAndStateOfTheta,
   .largest = 500},
  {.name = "state_2", .unit = "s", .start = "initial_state_2", .shown = Theta2, .of_shown = OfTheta2, .largest = 500}};

static const SlipFrictionLaw two_states = {
  .name = "two_states",
  .eval = TwoStates,
  .formula = "a asinh(|v|/(2 V0) exp((f0 + b ln(V0 theta/slip) + b_2 ln(V0 theta_2/slip_2))/a))",
  .by_rate = PETSC_TRUE,
  .always_slides = PETSC_TRUE,
  .states = both,
  .nstates = 2,
  .rate = EvolveTwo,
  .steady = SteadyTwo,
  .direct = SlipRateAndStateDirect,
  .own = own_of_two};

/* ---- friction by time ---- */

static const SlipParameter own_of_time[] = {{.name = "weakening_time",
                                             .value = 0,
                                             .unit = "s",
                                             .lower = 0,
                                             .upper = PETSC_MAX_REAL,
                                             .help = "Time T at which friction begins to weaken by itself"},
                                            {.name = "weakening_duration",
                                             .value = 0,
                                             .unit = "s",
                                             .lower = 0,
                                             .upper = PETSC_MAX_REAL,
                                             .help = "How long that takes; 0: it is done at once"},
                                            {.name = NULL}};
enum { WEAKENING_TIME, WEAKENING_DURATION };
enum { BY_SLIP, BY_TIME };

/*
  Linear slip weakening, or weakening by time where that is further on, as TPV24 of SCEC and USGS starts its ruptures:

     mu = mu_d + dmu (1 - max(min(s/d_c, 1), min((t - T)/t_0, 1), 0))

  With a T for each cell it is a rupture whose front is given, as in examples/kostrov.sh. The states are slip and time.
*/
static void ByTime(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal *excess, PetscReal dmu_ds[],
                   PetscReal *dmu_dv)
{
  const PetscReal duration = p->own[WEAKENING_DURATION], since = s[BY_TIME] - p->own[WEAKENING_TIME],
                  slip = s[BY_SLIP] / p->slip, time = since < 0 ? 0 : (since < duration ? since / duration : 1);

  (void)v;
  *excess = p->drop * (1 - PetscMin(PetscMax(slip, time), 1));
  dmu_ds[BY_SLIP] = slip > time && slip < 1 ? -p->drop / p->slip : 0;
  dmu_ds[BY_TIME] = time >= slip && since > 0 && since < duration ? -p->drop / duration : 0;
  *dmu_dv = 0;
}

static void Pass(const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal rate[], PetscReal drate_ds[],
                 PetscReal drate_dv[])
{
  (void)p, (void)s;
  rate[BY_SLIP] = v;
  rate[BY_TIME] = 1;
  for (int k = 0; k < 4; k++) drate_ds[k] = 0;
  drate_dv[BY_SLIP] = 1;
  drate_dv[BY_TIME] = 0;
}

/* None are: all has weakened */
static void AllWeak(const SlipFriction *p, PetscReal v, PetscReal s[])
{
  (void)v;
  s[BY_SLIP] = p->slip;
  s[BY_TIME] = p->own[WEAKENING_TIME] + p->own[WEAKENING_DURATION];
}

static const SlipFrictionState slip_and_time[] = {{.name = "state", .unit = "m"}, {.name = "elapsed", .unit = "s"}};

static const SlipFrictionLaw time_weakening = {
  .name = "time_weakening",
  .eval = ByTime,
  .formula = "residual + drop (1 - max(min(s/slip, 1), min((t - weakening_time)/weakening_duration, 1), 0))",
  .states = slip_and_time,
  .nstates = 2,
  .rate = Pass,
  .steady = AllWeak,
  .own = own_of_time,
  .reads = "residual drop slip"};

/* ---- the run ---- */

static PetscErrorCode Run(int *code)
{
  PetscBool only_help, complete = PETSC_TRUE;
  SlipFault fault;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  PetscCall(SlipFaultRegisterFrictionLaw(&cut_off)); /* before the options are read */
  PetscCall(SlipFaultRegisterFrictionLaw(&two_states));
  PetscCall(SlipFaultRegisterFrictionLaw(&time_weakening));
  PetscCall(SlipCheckOptionNames());
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(SlipFaultSetString(fault, "friction_law", "cut_off"));
  PetscCall(SlipFaultSetFromOptions(fault));
  if (only_help) PetscCall(SlipFaultSetReal(fault, "initial_rate", 1e-9)); /* help needs no choices of the user's */
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultSetInitialState(fault, w));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(SlipCheckSolverOptions(ts));
  PetscCall(TSSetFromOptions(ts));
  if (!only_help) {
    PetscCall(SlipCheckUnusedOptions());
    PetscCall(SlipFaultOutputStart(fault, ts));
    PetscCall(SlipFaultCheckpointStart(fault, ts));
    PetscCall(TSSolve(ts, w));
    PetscCall(SlipFaultCheckpointFinish(fault, ts, code));
    if (*code)
      PetscCall(SlipFaultReportStop(fault, ts, 0, 0));
    else {
      PetscCall(SlipFaultOutputFinish(fault, ts, 0, 0));
      PetscCall(SlipFaultReportEnd(fault, ts, &complete));
    }
    if (!complete) *code = SLIP_EXIT_INCOMPLETE;
    PetscCall(SlipWarnOfUnusedOptions());
  }
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscCall(SlipFaultDestroy(&fault));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  int code = 0;

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "friction_law", help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipSignalsPush());
  PetscCall(Run(&code));
  PetscCall(PetscFinalize());
  return code;
}
