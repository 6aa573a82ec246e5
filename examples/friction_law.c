static const char help[] = "A user's friction law, with an additional parameter: rate-and-state friction whose "
                           "evolution effect ends at a cut-off rate.\n  friction_law -fault_cut_off_rate 1e-3 "
                           "-fault_loading_rate 1e-9 -ts_max_time 1e10\nAll else is as in fault.\n\n";

#include <slipstep.h>
#include <math.h>

/* v_c: the option -fault_cut_off_rate, or cell by cell a dataset of -fault_parameters or SlipFaultSetField(). Constant, as the
   library refers to it. */
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

  s is psi. A law fills in mu and its derivatives with respect to s and v.
*/
static void CutOff(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *mu, PetscReal *dmu_ds, PetscReal *dmu_dv)
{
  const PetscReal end = p->reference_rate / p->own[CUT_OFF_RATE];

  SlipRateAndState(p, log(exp(s) + end), v, mu, dmu_ds, dmu_dv);
  *dmu_ds *= exp(s) / (exp(s) + end);
}

/* The rate of s and its derivatives: the aging or the slip law, which are there to be used. */
static void Evolve(const SlipFriction *p, PetscReal s, PetscReal v, PetscReal *rate, PetscReal *drate_ds,
                   PetscReal *drate_dv)
{
  SlipRateAndStateRate(p, s, v, rate, drate_ds, drate_dv);
}

/* Where nothing changes at the rate v: theta = d_c/v */
static PetscReal Steady(const SlipFriction *p, PetscReal v)
{
  return log(p->reference_rate / v);
}

static PetscErrorCode Run(int *code)
{
  const SlipFrictionLaw law = {.name = "cut_off",
                               .eval = CutOff,
                               .formula = "a asinh(|v|/(2 V0) exp((f0 + b ln(V0 theta/slip + V0/cut_off_rate))/a))",
                               .by_rate = PETSC_TRUE,
                               .always_slides = PETSC_TRUE,
                               .state = Evolve,
                               .steady = Steady,
                               .own = own};
  PetscBool only_help, complete = PETSC_TRUE;
  SlipFault fault;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(SlipFaultRegisterFrictionLaw(&law)); /* before the options are read */
  PetscCall(SlipCheckOptionNames());
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(SlipFaultSetString(fault, "friction_law", "cut_off"));
  PetscCall(SlipFaultSetFromOptions(fault));
  PetscCall(SlipFaultSetUp(fault));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultSetInitialState(fault, w));
  PetscCall(TSCreate(PETSC_COMM_WORLD, &ts));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(SlipCheckSolverOptions(ts));
  PetscCall(TSSetFromOptions(ts));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
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
