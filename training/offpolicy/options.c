/* -train_* options of TQC and TD3. */
#include "trainer.h"
#include "common/files.h"
#include "problems/problems.h"

/* What the first policies were trained with; CMA-ES takes these as they are. */
static const struct {
  const char *name;
  PetscReal scale, offset;
} ScaleTable[] = {
  {"log_velocity", 0.25, 0.5}, {"log_mean_velocity", 0.25, 0.5}, {"log_energy_rate", 0.25, 0.5},
  {"log_energy", 0.25, 0.5},   {"log_error", 0.5, -0.5},         {"slip", 0.1, 0},
};

static PetscErrorCode SetObservations(EnvOptions *o, PetscInt n, const char *const names[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < o->nobs; ++i) PetscCall(PetscFree(o->names[i]));
  o->nobs = n;
  for (PetscInt i = 0; i < n; ++i) {
    PetscCall(PetscStrallocpy(names[i], &o->names[i]));
    EnvObservationScale(names[i], &o->scale[i], &o->offset[i]);
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ScaleTable); ++k)
      if (!strcmp(names[i], ScaleTable[k].name)) {
        o->scale[i] = ScaleTable[k].scale;
        o->offset[i] = ScaleTable[k].offset;
      }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetPreset(EnvOptions *o)
{
  const Preset *row = ProblemPreset(o->problem, o->reward->name);
  PetscInt n = 0;

  PetscFunctionBegin;
  o->dt_min = row->dt_min;
  o->dt_max = row->dt_max;
  o->log_spacing = row->log_spacing;
  PetscCall(PetscStrncpy(o->dt_min_unit, row->dt_min_unit, sizeof(o->dt_min_unit)));
  PetscCall(PetscStrncpy(o->dt_max_unit, row->dt_max_unit, sizeof(o->dt_max_unit)));
  while (row->names[n]) ++n;
  PetscCall(SetObservations(o, n, row->names));
  o->rtol = o->problem->rtol;
  o->atol = o->problem->atol;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckChoice(const char option[], const char value[], const char *const known[])
{
  char list[128] = "";
  PetscBool same;

  PetscFunctionBegin;
  for (PetscInt i = 0; known[i]; ++i) {
    PetscCall(PetscStrcmp(value, known[i], &same));
    if (same) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(PetscStrlcat(list, " ", sizeof(list)));
    PetscCall(PetscStrlcat(list, known[i], sizeof(list)));
  }
  SETERRQ(PETSC_COMM_WORLD, PETSC_ERR_ARG_UNKNOWN_TYPE, "%s %s is not known; expected one of:%s", option, value, list);
}

static PetscErrorCode CheckPositive(const char option[], PetscReal value)
{
  PetscFunctionBegin;
  PetscCheck(value > 0 && !PetscIsInfOrNanReal(value), PETSC_COMM_WORLD, PETSC_ERR_ARG_OUTOFRANGE,
             "%s is %.6g, expected a number > 0", option, (double)value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number in [low, high]; high PETSC_MAX_REAL: no limit. */
static PetscErrorCode CheckRange(const char option[], PetscReal value, PetscReal low, PetscReal high)
{
  char limit[32] = "";

  PetscFunctionBegin;
  if (high < PETSC_MAX_REAL) snprintf(limit, sizeof(limit), " and <= %.6g", (double)high);
  PetscCheck(value >= low && value <= high, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%s is %.6g, expected a number >= %.6g%s", option, (double)value, (double)low, limit);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseEnvironment(EnvOptions *e, SlipOptionItems PetscOptionsObject)
{
  const char *const costs[] = {"iterations", "wall", NULL};
  char problem[64] = "fault", reward[64] = "published", cost[32] = "iterations", *names[ENV_MAX_OBS], text[256];
  PetscInt n = ENV_MAX_OBS;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscOptionsString(
    "-train_problem",
    "What is simulated: fault, fault_dial, sliding_mode or circuit (parameters: -fault_, -sliding_mode_, "
    "-circuit_ options)",
    NULL, problem, problem, sizeof(problem), NULL));
  PetscCall(ProblemFind(problem, &e->problem));
  PetscCall(PetscOptionsString(
    "-train_reward",
    "Reward: published (S1 S2 exp(-alpha E_r), -S1 on failure), accuracy (price of an attempt plus alpha times the "
    "effect of the step on the errors of the whole run), balanced (likewise, with half the cube root of alpha) or "
    "dial (that of -train_algorithm cmaes, step by step; -train_problem fault_dial)",
    NULL, reward, reward, sizeof(reward), NULL));
  PetscCall(RewardFind(reward, &e->reward));
  PetscCheck(!e->reward->needs_dial || e->problem->has_dial, PETSC_COMM_WORLD, PETSC_ERR_SUP,
             "-train_reward %s needs a problem with an accuracy dial: -train_problem fault_dial", reward);
  PetscCall(SetPreset(e));
  PetscCall(PetscOptionsString("-train_cost",
                               "Cost of an attempt in the published reward: iterations (nonlinear) or wall (time, "
                               "not reproducible)",
                               NULL, cost, cost, sizeof(cost), NULL));
  PetscCall(CheckChoice("-train_cost", cost, costs));
  PetscCall(PetscStrcmp(cost, "wall", &e->wall_cost));
  PetscCall(PetscOptionsStringArray("-train_observations",
                                    "Names of the observations, in order (default: depends on problem and reward)",
                                    NULL, names, &n, &set));
  if (set) {
    PetscCheck(n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "-train_observations has no value, expected names");
    PetscCall(SetObservations(e, n, (const char *const *)names));
    for (PetscInt i = 0; i < n; ++i) PetscCall(PetscFree(names[i]));
  }
  PetscCall(PetscSNPrintf(text, sizeof(text), "Shortest step the policy can choose [%s]", e->dt_min_unit));
  PetscCall(PetscOptionsReal("-train_dt_min", text, NULL, e->dt_min, &e->dt_min, NULL));
  PetscCall(PetscSNPrintf(text, sizeof(text), "Longest step the policy can choose [%s]", e->dt_max_unit));
  PetscCall(PetscOptionsReal("-train_dt_max", text, NULL, e->dt_max, &e->dt_max, NULL));
  PetscCall(CheckPositive("-train_dt_min", e->dt_min));
  PetscCall(CheckPositive("-train_dt_max", e->dt_max));
  PetscCall(PetscOptionsBool("-train_random", "Draw an instance of the problem for every episode", NULL, e->random,
                             &e->random, NULL));
  e->continuation = 1. / 12;
  PetscCall(PetscOptionsReal("-train_rtol", "Relative tolerance in the error estimate", NULL, e->rtol, &e->rtol, NULL));
  PetscCall(PetscSNPrintf(text, sizeof(text), "Absolute tolerance [%s]", e->problem->atol_unit));
  PetscCall(PetscOptionsReal("-train_atol", text, NULL, e->atol, &e->atol, NULL));
  PetscCall(CheckPositive("-train_rtol", e->rtol));
  PetscCall(CheckPositive("-train_atol", e->atol));
  PetscCall(PetscOptionsReal("-train_continuation_step",
                             "Step of the exact continuation of rewards accuracy and balanced [T*]", NULL,
                             e->continuation, &e->continuation, NULL));
  PetscCall(CheckPositive("-train_continuation_step", e->continuation));
  PetscCall(PetscOptionsInt("-train_max_attempts", "Attempts after which an episode is cut off, 0: never", NULL,
                            e->max_steps, &e->max_steps, NULL));
  PetscCall(CheckRange("-train_max_attempts", (PetscReal)e->max_steps, 0, PETSC_MAX_REAL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckLearner(const LearnerOptions *n)
{
  PetscFunctionBegin;
  for (PetscInt l = 0; l < n->actor_layers; ++l) PetscCall(CheckPositive("-train_network", (PetscReal)n->actor[l]));
  for (PetscInt l = 0; l < n->critic_layers; ++l)
    PetscCall(CheckPositive("-train_critic_network", (PetscReal)n->critic[l]));
  PetscCall(CheckPositive("-train_critics", (PetscReal)n->critics));
  PetscCall(CheckPositive("-train_quantiles", (PetscReal)n->quantiles));
  PetscCall(CheckPositive("-train_batch", (PetscReal)n->batch));
  PetscCall(CheckRange("-train_drop_quantiles", (PetscReal)n->drop, 0, (PetscReal)(n->quantiles - 1)));
  PetscCall(CheckPositive("-train_policy_delay", (PetscReal)n->delay));
  PetscCall(CheckPositive("-train_learning_rate", (PetscReal)n->lr));
  PetscCall(CheckRange("-train_discount", (PetscReal)n->gamma, 0, 1));
  PetscCall(CheckRange("-train_polyak", (PetscReal)n->tau, 0, 1));
  PetscCall(CheckRange("-train_noise_sigma", (PetscReal)n->noise, 0, PETSC_MAX_REAL));
  PetscCall(CheckRange("-train_smoothing", (PetscReal)n->smoothing, 0, PETSC_MAX_REAL));
  PetscCall(CheckRange("-train_smoothing_clip", (PetscReal)n->smoothing_clip, 0, PETSC_MAX_REAL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseReal(SlipOptionItems PetscOptionsObject, const char name[], const char text[], double *value)
{
  PetscReal x = (PetscReal)*value;

  PetscFunctionBegin;
  PetscCall(PetscOptionsReal(name, text, NULL, x, &x, NULL));
  *value = (double)x;
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
  PetscCall(PetscOptionsIntArray(name, text, NULL, width, &n, &set));
  PetscCheck(!set || n > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "%s has no value, expected widths such as 64,64",
             name);
  if (set) *layers = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseNetworks(LearnerOptions *n, SlipOptionItems PetscOptionsObject)
{
  PetscInt hidden = 64;

  PetscFunctionBegin;
  n->actor_layers = 2;
  n->critic_layers = 3;
  PetscCall(PetscOptionsInt("-train_hidden", "Width of the hidden layers", NULL, hidden, &hidden, NULL));
  PetscCall(CheckPositive("-train_hidden", (PetscReal)hidden));
  PetscCall(ParseWidths(PetscOptionsObject, "-train_network",
                        "Widths of the actor's hidden layers (default 2 of -train_hidden)", hidden, &n->actor_layers,
                        n->actor));
  PetscCall(ParseWidths(PetscOptionsObject, "-train_critic_network",
                        "Widths of the critics' hidden layers (default 3 of -train_hidden)", hidden, &n->critic_layers,
                        n->critic));
  PetscCall(PetscOptionsInt("-train_critics", "Critics (default: tqc 5, td3 2; the published tqc policies had 2)", NULL,
                            n->critics, &n->critics, NULL));
  PetscCall(
    PetscOptionsInt("-train_quantiles", "Quantiles of each critic (tqc)", NULL, n->quantiles, &n->quantiles, NULL));
  PetscCall(PetscOptionsDeprecated("-train_drop", "-train_drop_quantiles", "0.2.0", NULL));
  PetscCall(PetscOptionsInt("-train_drop_quantiles", "Largest target quantiles dropped, per critic (tqc)", NULL,
                            n->drop, &n->drop, NULL));
  PetscCall(PetscOptionsInt("-train_batch", "Transitions in a gradient step", NULL, n->batch, &n->batch, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TD3 has Gaussian noise only; TQC either gSDE, or a Gaussian of which the actor learns the deviation. */
static PetscErrorCode ParseNoise(const AgentOptions *a, LearnerOptions *n, SlipOptionItems PetscOptionsObject)
{
  const char *const noises[] = {"gsde", "gaussian", NULL};
  const PetscBool td3 = a->learner == &LearnerTD3 ? PETSC_TRUE : PETSC_FALSE;
  char noise[32];

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(noise, td3 ? "gaussian" : "gsde", sizeof(noise)));
  PetscCall(PetscOptionsString("-train_noise",
                               "Exploration: gsde (state-dependent; tqc, its default) or gaussian (tqc: of a learnt "
                               "deviation; td3: of -train_noise_sigma)",
                               NULL, noise, noise, sizeof(noise), NULL));
  PetscCall(CheckChoice("-train_noise", noise, noises));
  PetscCall(PetscStrcmp(noise, "gaussian", &n->gaussian));
  PetscCheck(n->gaussian || !td3, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "-train_noise gsde needs -train_algorithm tqc; td3 has gaussian");
  PetscCall(ParseReal(PetscOptionsObject, "-train_noise_sigma",
                      "Standard deviation of td3's exploration, actions being in [-1, 1]", &n->noise));
  PetscCall(ParseReal(PetscOptionsObject, "-train_smoothing", "Standard deviation of the target action's noise (td3)",
                      &n->smoothing));
  PetscCall(ParseReal(PetscOptionsObject, "-train_smoothing_clip", "Bound of the target action's noise (td3)",
                      &n->smoothing_clip));
  PetscCall(PetscOptionsInt("-train_policy_delay", "Gradient steps of the critics to one of the actor (td3)", NULL,
                            n->delay, &n->delay, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ParseAgent(TrainOptions *o, SlipOptionItems PetscOptionsObject)
{
  AgentOptions *a = &o->agent;
  LearnerOptions *n = &a->networks;
  const char *const algorithms[] = {"tqc", "td3", "cmaes", NULL};
  char algorithm[32] = "tqc";
  PetscBool td3;
  double buffer = 1e6, starts = 100;

  PetscFunctionBegin;
  PetscCall(PetscOptionsString("-train_algorithm",
                               "Learner: tqc, td3, or cmaes (with options of its own: -train_algorithm cmaes -help)",
                               NULL, algorithm, algorithm, sizeof(algorithm), NULL));
  PetscCall(CheckChoice("-train_algorithm", algorithm, algorithms));
  PetscCall(PetscStrcmp(algorithm, "td3", &td3));
  a->learner = td3 ? &LearnerTD3 : &LearnerTQC;
  *n = (LearnerOptions){.obs = o->env.nobs,
                        .act = 1,
                        .critics = td3 ? 2 : 5,
                        .quantiles = 25,
                        .drop = 2,
                        .batch = 256,
                        .lr = td3 ? 1e-3 : 3e-4,
                        .gamma = 0.99,
                        .tau = 0.005,
                        .noise = 0.1,
                        .smoothing = 0.2,
                        .smoothing_clip = 0.5,
                        .delay = 2};
  PetscCall(ParseNetworks(n, PetscOptionsObject));
  PetscCall(ParseNoise(a, n, PetscOptionsObject));
  PetscCall(ParseReal(PetscOptionsObject, "-train_learning_rate",
                      "Learning rate of all optimisers (default: tqc 3e-4, td3 1e-3)", &n->lr));
  PetscCall(ParseReal(PetscOptionsObject, "-train_discount", "Discount gamma", &n->gamma));
  PetscCall(ParseReal(PetscOptionsObject, "-train_polyak", "Polyak coefficient tau of the target networks", &n->tau));
  PetscCall(ParseReal(PetscOptionsObject, "-train_buffer", "Capacity of the replay buffer in transitions", &buffer));
  PetscCall(
    ParseReal(PetscOptionsObject, "-train_learning_starts", "Steps with random actions before learning", &starts));
  PetscCall(CheckLearner(n));
  PetscCall(CheckRange("-train_buffer", (PetscReal)buffer, 1, PETSC_MAX_REAL));
  PetscCall(CheckRange("-train_learning_starts", (PetscReal)starts, 0, PETSC_MAX_REAL));
  a->buffer = (PetscInt64)PetscMin(buffer, (double)o->steps); /* never more than the run can fill */
  a->learning_starts = (PetscInt64)starts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The lists of a sweep: every alpha with every seed */
static PetscErrorCode ParseSweep(TrainOptions *o, SlipOptionItems PetscOptionsObject)
{
  PetscBool set;

  PetscFunctionBegin;
  o->nalpha = o->nseed = TRAIN_MAX_LIST;
  o->alphas[0] = 1;
  o->seeds[0] = 0;
  PetscCall(PetscOptionsIntArray("-train_seed",
                                 "Seed, or a list of seeds (default 0): each is trained with each -train_alpha, spread "
                                 "over the ranks; F.h5 becomes F_alpha2_seed1.h5",
                                 NULL, o->seeds, &o->nseed, &set));
  if (!set || !o->nseed) o->nseed = 1;
  PetscCall(PetscOptionsRealArray("-train_alpha", "Weight of the error in the reward, or a list of them (default 1)",
                                  NULL, o->alphas, &o->nalpha, &set));
  if (!set || !o->nalpha) o->nalpha = 1;
  for (PetscInt i = 0; i < o->nalpha; ++i) PetscCall(CheckRange("-train_alpha", o->alphas[i], 0, PETSC_MAX_REAL));
  o->env.alpha = o->alphas[0];
  o->seed = o->seeds[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainOptionsSet(MPI_Comm comm, TrainOptions *o)
{
  PetscReal steps = 20000, checkpoint = 5000;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(o, sizeof(*o)));
  o->progress = 1000;
  o->evaluate_episodes = 32;
  PetscOptionsBegin(comm, NULL, "Training a step-size policy", "train");
  PetscCall(PetscOptionsReal("-train_steps", "Environment steps (attempts), in total with those of -train_resume", NULL,
                             steps, &steps, NULL));
  PetscCheck(steps >= 1 && steps < 1e12, comm, PETSC_ERR_ARG_OUTOFRANGE, "-train_steps %g must be positive",
             (double)steps);
  o->steps = (PetscInt64)steps;
  PetscCall(ParseSweep(o, PetscOptionsObject));
  PetscCall(PetscOptionsInt("-train_progress", "Steps from one progress line to the next, 0: quiet", NULL, o->progress,
                            &o->progress, NULL));
  PetscCall(
    PetscOptionsInt("-train_evaluate_interval",
                    "Steps between evaluations of the policy without noise; the best one is written. 0: write the last",
                    NULL, o->evaluate_interval, &o->evaluate_interval, NULL));
  PetscCall(PetscOptionsInt("-train_evaluate_episodes", "Episodes of an evaluation, the same faults each time", NULL,
                            o->evaluate_episodes, &o->evaluate_episodes, NULL));
  PetscCheck(o->evaluate_episodes > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_evaluate_episodes %" PetscInt_FMT " must be positive", o->evaluate_episodes);
  PetscCall(PetscOptionsReal("-train_checkpoint_interval", "Steps between checkpoints, 0: only at the end", NULL,
                             checkpoint, &checkpoint, NULL));
  PetscCall(CheckRange("-train_checkpoint_interval", checkpoint, 0, (PetscReal)PETSC_MAX_INT));
  PetscCall(CheckRange("-train_progress", (PetscReal)o->progress, 0, PETSC_MAX_REAL));
  PetscCall(CheckRange("-train_evaluate_interval", (PetscReal)o->evaluate_interval, 0, PETSC_MAX_REAL));
  o->checkpoint_interval = (PetscInt)checkpoint;
  PetscCall(ParseEnvironment(&o->env, PetscOptionsObject));
  PetscCall(ParseAgent(o, PetscOptionsObject));
  PetscCall(PetscOptionsBool("-train_transfer",
                             "-train_resume is of another mesh or fault: keep its networks and optimisers, forget its "
                             "transitions and evaluations",
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
