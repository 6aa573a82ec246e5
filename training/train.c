static const char help[] =
  "Trains a policy that chooses step sizes, by truncated quantile critics (TQC), TD3 or CMA-ES.\n"
  "  mpirun -n 2 train -train_algorithm cmaes -train_output policy.h5   (with an accuracy dial: the default policy)\n"
  "  train -train_algorithm tolerances -train_problem rupture -train_output mine.h5   (-ts_rtol of each controller by "
  "the accuracy that it keeps, for -fault_tolerances)\n"
  "  train -train_problem circuit -train_reward accuracy -train_random -train_output policy.h5\n"
  "  train -train_algorithm cmaes -train_problem ode -train_output ode.h5   (the general policy, for any TS)\n"
  "  train -train_steps 20000 -train_output policy.h5 -train_log curve.h5\n"
  "  train -train_reward accuracy -train_random -train_output policy.h5      (random one-cell faults)\n"
  "  mpirun -n 2 train -train_alpha 1,2,4 -train_seed 1,2 -train_output policy.h5    (six trainings, two at a time)\n"
  "  fault -ts_adapt_type rl -ts_adapt_rl_policy policy.h5                   (uses it)\n"
  "The fault is that of the -fault_ options, one cell unless -fault_nx and -fault_nz say otherwise.\n"
  "Drawn by -train_random:\n";

#include "cmaes/cmatrain.h"
#include "common/options.h"
#include "dials/ladder.h"
#include "study/trainer.h"
#include "problems/problems.h"
#include <slipcompat.h>

/* What -train_ options there are, of all algorithms; test_options.py holds the list to the sources */
static const char names[] =
  "algorithm alpha atol batch batch_meshes batch_singles buffer calibrate calibration checkpoint "
  "checkpoint_interval continuation_step controllers cost critic_network critics diagonal dial_high dial_low "
  "discount drop drop_quantiles dt_max dt_min episodes evaluate_episodes evaluate_interval family generations "
  "hidden late_generations late_meshes late_singles layers learning_rate learning_starts log log_overwrite "
  "max_attempts mesh_side meshes minutes move "
  "moving_dt_max network noise_sigma observations output policy_delay polyak population "
  "problem progress quantiles random resume reward rtol seed sigma singles smoothing smoothing_clip "
  "start steps transfer validation validation_interval within";

static PetscErrorCode TrainCMA(MPI_Comm comm, PetscInt *failed)
{
  (void)failed;
  return CMATrain(comm, NULL);
}

/* The table of trainers. train reads options of its own, which -help shows; failed: how many of several trainings
   did */
static const struct {
  const char *name, *meaning;
  PetscErrorCode (*train)(MPI_Comm comm, PetscInt *failed);
} Trainers[] = {{"tqc", "truncated quantile critics", SweepTrain},
                {"td3", "TD3", SweepTrain},
                {"cmaes", "CMA-ES, with an accuracy dial", TrainCMA},
                {"tolerances", "of classical controllers, by the accuracy that they keep", TolerancesRun}};
enum { TRAINERS = PETSC_STATIC_ARRAY_LENGTH(Trainers) };

static PetscErrorCode Run(PetscInt *failed)
{
  const char *known[TRAINERS + 1] = {NULL};
  char text[512] = "Trainer";
  PetscBool only_help, named;
  PetscInt k = 0;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < TRAINERS; ++i) {
    known[i] = Trainers[i].name;
    PetscCall(TextAdd(text, sizeof(text), "%s%s, %s", i ? "; " : ": ", Trainers[i].name, Trainers[i].meaning));
  }
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Trainers with further options", "train");
  PetscCall(OptionChoice(PetscOptionsObject, "-train_algorithm", text, known, &k));
  PetscOptionsEnd();
  PetscCall(PetscOptionsHasHelp(NULL, &only_help));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-train_algorithm", &named));
  if (only_help && !named) /* all of them: the others' options follow those of the default */
    for (PetscInt i = 1; i < TRAINERS; ++i)
      if (Trainers[i].train != Trainers[k].train) PetscCall((*Trainers[i].train)(PETSC_COMM_WORLD, failed));
  PetscCall((*Trainers[k].train)(PETSC_COMM_WORLD, failed));
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
