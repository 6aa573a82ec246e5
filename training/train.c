static const char help[] =
  "Trains a policy that chooses step sizes, by truncated quantile critics (TQC), TD3 or CMA-ES.\n"
  "  mpirun -n 2 train -train_algorithm cmaes -train_output policy.h5   (with an accuracy dial: the default policy)\n"
  "  train -train_algorithm steps -fault_nx 4 -fault_nz 4 -train_output bound.h5   (the best steps that there are)\n"
  "  mpirun -n 2 train -train_algorithm filter   (a classical controller, tuned: options of -ts_adapt_type pi)\n"
  "  train -train_problem circuit -train_reward accuracy -train_random -train_output policy.h5\n"
  "  train -train_algorithm cmaes -train_problem ode -train_output ode.h5   (the general policy, for any TS)\n"
  "  train -train_algorithm cmaes -train_problem cycles -train_output cycles.h5   (cycles of rate-and-state faults)\n"
  "  train -train_steps 20000 -train_output policy.h5 -train_log curve.h5\n"
  "  train -train_reward accuracy -train_random -train_output policy.h5      (random one-cell faults)\n"
  "  mpirun -n 2 train -train_alpha 1,2,4 -train_seed 1,2 -train_output policy.h5    (six trainings, two at a time)\n"
  "  fault -ts_adapt_type rl -ts_adapt_rl_policy policy.h5                   (uses it)\n"
  "The fault is that of the -fault_ options, one cell unless -fault_nx and -fault_nz say otherwise.\n"
  "Drawn by -train_random:\n";

#include "cmaes/cmatrain.h"
#include "cycles/cycles.h"
#include "ode/ode.h"
#include "offpolicy/sweep.h"
#include "problems/problems.h"
#include "steps/steps.h"
#include "tuning/filter.h"
#include <slipcompat.h>

/* What -train_ options there are, of all algorithms; test_options.py holds the list to the sources */
static const char names[] =
  "algorithm alpha atol batch batch_meshes batch_singles buffer calibration checkpoint "
  "checkpoint_interval continuation_step cost critic_network critics diagonal dial_high dial_low "
  "discount drop drop_quantiles dt_max dt_min episodes evaluate_episodes evaluate_interval family generations "
  "hidden late_generations late_meshes late_singles layers learning_rate learning_starts log log_overwrite "
  "max_attempts mesh_side meshes minutes "
  "moving_dt_max network noise noise_sigma observations output policy_delay polyak population "
  "problem progress quantiles random restarts resume reward rtol seed sigma singles smoothing smoothing_clip "
  "steps steps_least steps_most transfer validation validation_interval within";

/* The options that make `pi` the tuned filter, at any accuracy */
static PetscErrorCode RunFilter(void)
{
  FilterOptions o;
  FilterScore score;
  TunedFilter best;
  PetscBool only_help;

  PetscFunctionBeginUser;
  PetscCall(FilterOptionsSet(PETSC_COMM_WORLD, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FilterTune(PETSC_COMM_WORLD, &o, &best, &score));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "-ts_adapt_type pi -ts_adapt_pi_g1 %.4g -ts_adapt_pi_g2 %.4g -ts_adapt_pi_kappa %.4g "
                        "-ts_adapt_pi_ratio_min %.4g -ts_adapt_pi_ratio_max %.4g\n"
                        "-ts_rtol %.4g a^%.4g for an accuracy a\n",
                        (double)best.filter.g1, (double)best.filter.g2, (double)best.filter.kappa,
                        (double)best.filter.r_min, (double)best.filter.r_max, (double)best.factor, (double)best.power));
  PetscCall(SlipWarnOfUnusedOptions());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of several ranks the first trains and the others wait. */
static PetscErrorCode RunOne(const TrainOptions *o)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (!rank) PetscCall(TrainerTrain(o));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(PetscInt *failed)
{
  TrainOptions o;
  EnvRun run;
  EnvInstance instance;
  char algorithm[32] = "", problem[32] = "";
  PetscBool only_help, evolution, filter, general, cycles, steps;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-train_algorithm", algorithm, sizeof(algorithm), NULL));
  PetscCall(PetscStrcmp(algorithm, "cmaes", &evolution));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-train_problem", problem, sizeof(problem), NULL));
  PetscCall(PetscStrcmp(problem, "ode", &general));
  PetscCall(PetscStrcmp(problem, "cycles", &cycles));
  if (evolution && cycles) {
    PetscCall(CyclesTrain(PETSC_COMM_WORLD));
    PetscCall(SlipWarnOfUnusedOptions());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (evolution && general) {
    PetscCall(OdeTrain(PETSC_COMM_WORLD));
    PetscCall(SlipWarnOfUnusedOptions());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (evolution) {
    PetscCall(CMATrain(PETSC_COMM_WORLD, NULL));
    PetscCall(SlipWarnOfUnusedOptions());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrcmp(algorithm, "filter", &filter));
  if (filter) {
    PetscCall(RunFilter());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrcmp(algorithm, "steps", &steps));
  if (steps) {
    PetscCall(StepsRun(PETSC_COMM_WORLD));
    PetscCall(SlipWarnOfUnusedOptions());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TrainOptionsSet(PETSC_COMM_WORLD, &o));
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  if (only_help) { /* the options of the problem and of TS */
    PetscCall(EnvInstanceCreate(&o.env, NULL, PETSC_FALSE, &instance));
    PetscCall(o.env.problem->create(&o.env, &instance, &run));
    PetscCall(o.env.problem->destroy(&run));
    PetscCall(TrainOptionsFree(&o));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (SweepCount(&o) > 1)
    PetscCall(SweepRun(PETSC_COMM_WORLD, &o, failed));
  else
    PetscCall(RunOne(&o));
  PetscCall(TrainOptionsFree(&o));
  PetscCall(SlipWarnOfUnusedOptions());
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  static char manual[4096];
  char ranges[2048];
  PetscInt failed = 0;

  PetscFunctionBeginUser;
  PetscCall(ProblemDescribeDraws(ranges, sizeof(ranges)));
  PetscCall(PetscSNPrintf(manual, sizeof(manual), "%s%s\n\n", help, ranges));
  PetscCall(SlipProgramInitialize(&argc, &argv, "train", manual));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipDeclareOptions("train_", names));
  PetscCall(SlipCheckOptionNames());
  PetscCall(Run(&failed));
  PetscCall(PetscFinalize());
  return failed ? 1 : 0;
}
