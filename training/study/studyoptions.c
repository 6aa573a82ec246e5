/* -train_* options of TQC and TD3. */
#include <slipstep/rooms/slipsys.h>
#include "trainer.h"
#include "common/files.h"
#include "common/options.h"
#include "problems/problems.h"

/* What the first policies were trained with; CMA-ES takes these as they are. */
static const struct {
  const char *name;
  PetscReal scale, offset;
} ScaleTable[] = {
  {"log_velocity", 0.25, 0.5}, {"log_mean_velocity", 0.25, 0.5}, {"log_energy_rate", 0.25, 0.5},
  {"log_energy", 0.25, 0.5},   {"log_error", 0.5, -0.5},         {"slip", 0.1, 0},
};

static PetscErrorCode SetObservations(EnvOptions *o, const char *const names[])
{
  PetscInt n = 0;

  PetscFunctionBegin;
  while (names[n]) ++n;
  PetscCall(EnvObservationsSet(n, names, &o->nobs, o->names, o->scale, o->offset));
  for (PetscInt i = 0; i < n; ++i)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ScaleTable); ++k)
      if (!strcmp(names[i], ScaleTable[k].name)) {
        o->scale[i] = ScaleTable[k].scale;
        o->offset[i] = ScaleTable[k].offset;
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseEnvironment(EnvOptions *e, SlipOptionItems PetscOptionsObject)
{
  const char *const costs[] = {"iterations", "wall", NULL};
  char reward[64] = "published", *names[ENV_MAX_OBS + 1];
  char low[64], high[64], atol[256];
  PetscInt n = ENV_MAX_OBS, cost = 0;
  const Preset *preset;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(ProblemOption(PetscOptionsObject, PROBLEM_BY_STEPS, &e->problem, NULL));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-train_family", &set));
  PetscCheck(!set, PETSC_COMM_WORLD, PETSC_ERR_ARG_WRONG,
             "-train_family is for faults with an accuracy dial: expected -train_algorithm cmaes or tolerances");
  PetscCall(PetscOptionsString(
    "-train_reward",
    "Reward: published (S1 S2 exp(-alpha E_r), -S1 on failure), accuracy (price of an attempt plus alpha times the "
    "effect of the step on the errors of the whole run) or balanced (likewise, with half the cube root of alpha)",
    NULL, reward, reward, sizeof(reward), NULL));
  PetscCall(RewardFind(reward, &e->reward));
  preset = ProblemPreset(e->problem, e->reward->name);
  e->dt_min = preset->dt_min;
  e->dt_max = preset->dt_max;
  e->log_spacing = preset->log_spacing;
  PetscCall(PetscStrncpy(e->dt_min_unit, preset->dt_min_unit, sizeof(e->dt_min_unit)));
  PetscCall(PetscStrncpy(e->dt_max_unit, preset->dt_max_unit, sizeof(e->dt_max_unit)));
  PetscCall(SetObservations(e, preset->names));
  e->rtol = e->problem->rtol;
  e->atol = e->problem->atol;
  PetscCall(OptionChoice(PetscOptionsObject, "-train_cost",
                         "Cost of an attempt in the published reward: iterations (nonlinear) or wall (time, not "
                         "reproducible)",
                         costs, &cost));
  e->wall_cost = cost ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscOptionsStringArray("-train_observations",
                                    "Names of the observations, in order (default: depends on problem and reward)",
                                    NULL, names, &n, &set));
  if (set) {
    PetscCheck(n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "-train_observations has no value, expected names");
    names[n] = NULL;
    PetscCall(SetObservations(e, (const char *const *)names));
    for (PetscInt i = 0; i < n; ++i) PetscCall(PetscFree(names[i]));
  }
  PetscCall(SlipCheckBoolOption(PETSC_COMM_WORLD, NULL, NULL, "-train_random"));
  PetscCall(PetscOptionsBool("-train_random", "Draw an instance of the problem for every episode", NULL, e->random,
                             &e->random, NULL));
  e->continuation = 1. / 12;
  PetscCall(PetscSNPrintf(low, sizeof(low), "Shortest step the policy can choose [%s]", e->dt_min_unit));
  PetscCall(PetscSNPrintf(high, sizeof(high), "Longest step the policy can choose [%s]", e->dt_max_unit));
  PetscCall(PetscSNPrintf(atol, sizeof(atol), "Absolute tolerance [%s]", e->problem->atol_unit));
  const NumberOption row[] = {
    OPTION_POSITIVE("-train_dt_min", low, &e->dt_min),
    OPTION_POSITIVE("-train_dt_max", high, &e->dt_max),
    OPTION_POSITIVE("-train_rtol", "Relative tolerance in the error estimate", &e->rtol),
    OPTION_POSITIVE("-train_atol", atol, &e->atol),
    OPTION_POSITIVE("-train_continuation_step", "Step of the exact continuation of rewards accuracy and balanced [T*]",
                    &e->continuation),
    OPTION_INTEGER("-train_max_attempts", "Attempts after which an episode is cut off, 0: never", &e->max_steps, 0,
                   PETSC_MAX_REAL)};
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Widths of hidden layers: all of -train_hidden unless listed */
static PetscErrorCode ParseWidths(SlipOptionItems PetscOptionsObject, const char name[], const char text[],
                                  PetscInt hidden, PetscInt *layers, PetscInt width[])
{
  PetscInt n = LEARNER_MAX_HIDDEN;
  PetscBool set;

  PetscFunctionBegin;
  for (PetscInt l = 0; l < *layers; ++l) width[l] = hidden;
  PetscCall(SlipCheckIntegerOption(PETSC_COMM_SELF, NULL, NULL, name));
  PetscCall(PetscOptionsIntArray(name, text, NULL, width, &n, &set));
  PetscCheck(!set || n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "%s has no value, expected widths such as 64,64",
             name);
  if (set) *layers = n;
  for (PetscInt l = 0; l < *layers; ++l) {
    const NumberOption check = OPTION_COUNT(name, NULL, &width[l]);

    PetscCall(OptionsNumbers(PetscOptionsObject, 1, &check));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Networks and their training */
static PetscErrorCode ParseLearner(LearnerOptions *n, SlipOptionItems PetscOptionsObject)
{
  PetscInt hidden = 64;
  const NumberOption first[] = {
    OPTION_COUNT("-train_hidden", "Width of the hidden layers", &hidden),
    OPTION_COUNT("-train_critics", "Critics (default: tqc 5, td3 2; the published tqc policies had 2)", &n->critics),
    OPTION_COUNT("-train_quantiles", "Quantiles of each critic (tqc)", &n->quantiles),
    OPTION_COUNT("-train_batch", "Transitions in a gradient step", &n->batch)};

  PetscFunctionBegin;
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(first), first));
  n->actor_layers = 2;
  n->critic_layers = 3;
  PetscCall(ParseWidths(PetscOptionsObject, "-train_network",
                        "Widths of the actor's hidden layers (default 2 of -train_hidden)", hidden, &n->actor_layers,
                        n->actor));
  PetscCall(ParseWidths(PetscOptionsObject, "-train_critic_network",
                        "Widths of the critics' hidden layers (default 3 of -train_hidden)", hidden, &n->critic_layers,
                        n->critic));
  PetscCall(PetscOptionsDeprecated("-train_drop", "-train_drop_quantiles", "0.2.0", NULL));
  const NumberOption row[] = {
    OPTION_INTEGER("-train_drop_quantiles", "Largest target quantiles dropped, per critic (tqc)", &n->drop, 0,
                   n->quantiles - 1),
    OPTION_REAL("-train_noise_sigma", "Standard deviation of td3's exploration, actions being in [-1, 1]", &n->noise, 0,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_smoothing", "Standard deviation of the target action's noise (td3)", &n->smoothing, 0,
                PETSC_MAX_REAL),
    OPTION_REAL("-train_smoothing_clip", "Bound of the target action's noise (td3)", &n->smoothing_clip, 0,
                PETSC_MAX_REAL),
    OPTION_COUNT("-train_policy_delay", "Gradient steps of the critics to one of the actor (td3)", &n->delay),
    OPTION_POSITIVE("-train_learning_rate", "Learning rate of all optimisers (default: tqc 3e-4, td3 1e-3)", &n->lr),
    OPTION_REAL("-train_discount", "Discount gamma", &n->gamma, 0, 1),
    OPTION_REAL("-train_polyak", "Polyak coefficient tau of the target networks", &n->tau, 0, 1)};
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Learner *const Learners[] = {&LearnerTQC, &LearnerTD3};

static PetscErrorCode ParseAgent(TrainOptions *o, SlipOptionItems PetscOptionsObject)
{
  AgentOptions *a = &o->agent;
  char algorithm[32] = "tqc";
  PetscReal buffer = 1e6, starts = 100;
  const NumberOption row[] = {
    OPTION_REAL("-train_buffer", "Capacity of the replay buffer in transitions", &buffer, 1, PETSC_MAX_REAL),
    OPTION_REAL("-train_learning_starts", "Steps with random actions before learning", &starts, 0, PETSC_MAX_REAL)};

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-train_algorithm", algorithm, sizeof(algorithm), NULL));
  a->learner = Learners[0];
  for (size_t i = 1; i < PETSC_STATIC_ARRAY_LENGTH(Learners); ++i)
    if (!strcmp(algorithm, Learners[i]->name)) a->learner = Learners[i];
  a->networks = (LearnerOptions){.obs = o->env.nobs,
                                 .critics = a->learner->critics,
                                 .quantiles = 25,
                                 .drop = 2,
                                 .batch = 256,
                                 .lr = a->learner->lr,
                                 .gamma = 0.99,
                                 .tau = 0.005,
                                 .noise = 0.1,
                                 .smoothing = 0.2,
                                 .smoothing_clip = 0.5,
                                 .delay = 2};
  PetscCall(ParseLearner(&a->networks, PetscOptionsObject));
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  a->buffer = (PetscInt64)PetscMin(buffer, (PetscReal)o->steps); /* never more than the run can fill */
  a->learning_starts = (PetscInt64)starts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainOptionsSet(MPI_Comm comm, TrainOptions *o)
{
  PetscReal steps = 20000, checkpoint = 5000;
  const NumberOption row[] = {
    OPTION_INTEGER("-train_progress", "Steps from one progress line to the next, 0: quiet", &o->progress, 0,
                   PETSC_MAX_REAL),
    OPTION_INTEGER("-train_evaluate_interval",
                   "Steps between evaluations of the policy without noise; the best one is written. 0: write the last",
                   &o->evaluate_interval, 0, PETSC_MAX_REAL),
    OPTION_COUNT("-train_evaluate_episodes", "Episodes of an evaluation, the same faults each time",
                 &o->evaluate_episodes),
    OPTION_REAL("-train_checkpoint_interval", "Steps between checkpoints, 0: only at the end", &checkpoint, 0,
                PETSC_MAX_INT)};
  PetscReal unused;
  PetscBool given, set;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(o, sizeof(*o)));
  o->progress = 1000;
  o->evaluate_episodes = 32;
  PetscOptionsBegin(comm, NULL, "Training a step-size policy", "train");
  PetscCall(SlipCheckNumberOption(comm, NULL, NULL, "-train_steps", PETSC_FALSE, &given, &unused));
  PetscCall(PetscOptionsReal("-train_steps", "Environment steps (attempts), in total with those of -train_resume", NULL,
                             steps, &steps, NULL));
  PetscCheck(steps >= 1 && steps < 1e12, comm, PETSC_ERR_ARG_OUTOFRANGE, "-train_steps %g must be positive",
             (double)steps);
  o->steps = (PetscInt64)steps;
  /* the lists of a sweep: every alpha with every seed */
  o->nalpha = o->nseed = TRAIN_MAX_LIST;
  o->alphas[0] = 1;
  o->seeds[0] = 0;
  PetscCall(SlipCheckIntegerOption(PETSC_COMM_WORLD, NULL, NULL, "-train_seed"));
  PetscCall(PetscOptionsIntArray("-train_seed",
                                 "Seed, or a list of seeds (default 0): each is trained with each -train_alpha, spread "
                                 "over the ranks; F.h5 becomes F_alpha2_seed1.h5",
                                 NULL, o->seeds, &o->nseed, &set));
  if (!set || !o->nseed) o->nseed = 1;
  PetscCall(PetscOptionsRealArray("-train_alpha", "Weight of the error in the reward, or a list of them (default 1)",
                                  NULL, o->alphas, &o->nalpha, &set));
  if (!set || !o->nalpha) o->nalpha = 1;
  for (PetscInt i = 0; i < o->nalpha; ++i) {
    const NumberOption check = OPTION_REAL("-train_alpha", NULL, &o->alphas[i], 0, PETSC_MAX_REAL);

    PetscCall(OptionsNumbers(PetscOptionsObject, 1, &check));
  }
  o->env.alpha = o->alphas[0];
  o->seed = o->seeds[0];
  PetscCall(OptionsNumbers(PetscOptionsObject, PETSC_STATIC_ARRAY_LENGTH(row), row));
  o->checkpoint_interval = (PetscInt)checkpoint;
  PetscCall(ParseEnvironment(&o->env, PetscOptionsObject));
  PetscCall(ParseAgent(o, PetscOptionsObject));
  PetscCall(SlipCheckBoolOption(PETSC_COMM_WORLD, NULL, NULL, "-train_transfer"));
  PetscCall(PetscOptionsBool("-train_transfer",
                             "-train_resume names a checkpoint of another mesh or fault: use its networks and "
                             "optimisers, discard its transitions and evaluations",
                             NULL, o->transfer, &o->transfer, NULL));
  PetscCall(TrainSetFiles(PetscOptionsObject, "Checkpoint to write: networks, optimisers, buffer, random state",
                          o->output, o->log, o->checkpoint, o->resume));
  PetscOptionsEnd();
  PetscCheck(!o->transfer || o->resume[0], PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "-train_transfer needs -train_resume, the checkpoint to start from");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainOptionsFree(TrainOptions *o)
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < o->env.nobs; ++i) PetscCall(PetscFree(o->env.names[i]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
