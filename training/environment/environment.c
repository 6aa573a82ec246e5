/* Episodes: the actor between TSAdapt rl and the learner, see environment.h. */
#include "environment.h"
#include "common/options.h"
#include <slipcompat.h>

/* Any other name of the library's or the problem's table is taken as it is. */
static const struct {
  const char *name;
  PetscReal scale, offset;
} ScaleTable[] = {
  {"log_accuracy", 0.7, 1.75},  {"log_rate", 0.5, 0.5},
  {"log_peak_rate", 0.5, 0.5},  {"progress", 1, -0.7},
  {"weakening", 1.5, -0.75},    {"log_drop", 2, -1.2},
  {"log_slip_error", 0.5, 1.5}, {"growth", 0.5, 0},
  {"sliding_fraction", 2, -1},  {"change_sliding_fraction", 2, 0},
  {"log_time_left", 1, -1},     {"log_growth_time", 2, 0.5},
  {"growth_rate", 1, -0.5},     {"start_growth_rate", 3, -3.5},
  {"log_mode_rate", 0.4, 0.6},  {"log_push", 0.5, 0.7},
  {"damping_ratio", 4, -1.4},   {"log_peak_ratio", 2, -0.7},
  {"seen_growth", 0.7, 0},      {"change_log_mode_rate", 0.5, 0},
  {"log_step_limit", 0.8, 0.4}, {"log_solve_cost", 2, -2.3},
};

PetscErrorCode EnvObservationsSet(PetscInt n, const char *const names[], PetscInt *nobs, char *copies[],
                                  PetscReal scale[], PetscReal offset[])
{
  PetscFunctionBegin;
  for (PetscInt i = 0; i < *nobs; ++i) PetscCall(PetscFree(copies[i]));
  *nobs = n;
  for (PetscInt i = 0; i < n; ++i) {
    PetscCall(PetscStrallocpy(names[i], &copies[i]));
    scale[i] = 1;
    offset[i] = 0;
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(ScaleTable); ++k)
      if (!strcmp(names[i], ScaleTable[k].name)) {
        scale[i] = ScaleTable[k].scale;
        offset[i] = ScaleTable[k].offset;
      }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvCreate(const EnvOptions *o, Environment *env)
{
  PetscFunctionBegin;
  PetscCall(PetscMemzero(env, sizeof(*env)));
  env->o = *o;
  env->cost_min = PETSC_MAX_REAL;
  env->cost_max = PETSC_MIN_REAL;
  for (PetscInt i = 0; i < ENV_MAX_OBS; ++i) {
    env->obs_min[i] = PETSC_MAX_REAL;
    env->obs_max[i] = PETSC_MIN_REAL;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal InSeconds(PetscReal value, const char unit[], const EnvRun *run)
{
  return value * (unit[0] == 'T' ? run->tstar : (unit[0] == 't' ? run->tmax : 1));
}

/* TSAdaptRLActorFn: inversion of control, TSSolve() calls the learner. The step is as of SlipPolicyActionToStep(). */
static PetscErrorCode Actor(TSAdapt adapt, TS ts, PetscInt n, const PetscReal obs[], const SlipAttempt *last,
                            PetscBool guarded, PetscReal *h, void *ctx)
{
  Environment *env = (Environment *)ctx;
  EnvResult *r = &env->result;
  const Reward *reward = env->o.reward;
  RewardInput in = {.attempt = last, .dt_min = env->dt_min, .dt_max = env->dt_max, .alpha = env->o.alpha};
  EnvMoment moment = {.obs = env->obs, .first = last ? PETSC_FALSE : PETSC_TRUE, .overruled = guarded};
  PetscReal action = 0, x;

  PetscFunctionBegin;
  (void)adapt, (void)n;
  for (PetscInt i = 0; i < env->o.nobs; ++i) {
    env->obs_min[i] = PetscMin(env->obs_min[i], obs[i]);
    env->obs_max[i] = PetscMax(env->obs_max[i], obs[i]);
    env->obs[i] = obs[i] * env->o.scale[i] + env->o.offset[i];
  }
  if (last) {
    in.cost = env->o.wall_cost ? last->wall : (PetscReal)last->newton;
    if (last->converged) {
      env->cost_min = PetscMin(env->cost_min, in.cost);
      env->cost_max = PetscMax(env->cost_max, in.cost);
    }
    in.cost_min = env->cost_min;
    in.cost_max = env->cost_max;
    if (reward && reward->needs_continuation && last->accepted)
      PetscCall(env->o.problem->judge_step(env->judge, &env->run, last->time + last->dt, &in.effect));
    if (reward) moment.reward = reward->value(&in);
    r->attempts++;
    r->solves += last->solves;
    r->accepted += last->accepted ? 1 : 0;
    r->total += moment.reward;
    moment.terminated =
      last->accepted && last->time + last->dt >= env->run.tmax * (1 - 1e-12) ? PETSC_TRUE : PETSC_FALSE;
    moment.truncated = env->o.max_steps && r->attempts >= env->o.max_steps ? PETSC_TRUE : PETSC_FALSE;
  }
  if (!env->stopped) PetscCall(env->actor(&moment, &action, &env->stopped, env->ctx));
  if (moment.terminated)
    r->finished = PETSC_TRUE;
  else if (moment.truncated || env->stopped) {
    env->stopped = PETSC_TRUE;
    PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  x = 0.5 * (action + 1);
  *h = env->o.log_spacing ? env->dt_min * PetscPowReal(env->dt_max / env->dt_min, x)
                          : env->dt_min + x * (env->dt_max - env->dt_min);
  PetscFunctionReturn(PETSC_SUCCESS);
}

const char *ProblemPolicy(const Problem *p)
{
  return p->policy_problem ? p->policy_problem : p->name;
}

const Preset *ProblemPreset(const Problem *p, const char reward[])
{
  const Preset *row = p->presets;

  while (row->reward && strcmp(row->reward, reward)) ++row;
  return row;
}

PetscErrorCode ProblemDraw(const Problem *p, Random *random, PetscReal drawn[])
{
  PetscFunctionBegin;
  do {
    for (PetscInt i = 0; i < p->ndraw; ++i) {
      const DrawRow *row = &p->draw[i];

      drawn[i] = row->uniform ? row->low + (row->high - row->low) * (PetscReal)RandomUniform(random)
                              : (PetscReal)RandomLog(random, (double)row->low, (double)row->high);
    }
  } while (p->drawable && !p->drawable(drawn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvInstanceCreate(const EnvOptions *o, Random *random, PetscBool reference, EnvInstance *instance)
{
  PetscFunctionBegin;
  *instance = (EnvInstance){.drawn = random ? PETSC_TRUE : PETSC_FALSE};
  if (random) PetscCall(ProblemDraw(o->problem, random, instance->value));
  if (reference) PetscCall(o->problem->reference_create(o, instance, &instance->reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvInstanceDestroy(const EnvOptions *o, EnvInstance *instance)
{
  PetscFunctionBegin;
  if (instance->reference) PetscCall(o->problem->reference_destroy(&instance->reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvRunInstance(Environment *env, const EnvInstance *instance, EnvActorFn actor, void *ctx,
                              EnvResult *result)
{
  const EnvOptions *o = &env->o;
  const PetscBool effects = o->reward && o->reward->needs_continuation ? PETSC_TRUE : PETSC_FALSE;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(o->problem->create(o, instance, &env->run));
  env->dt_min = InSeconds(o->dt_min, o->dt_min_unit, &env->run);
  env->dt_max = InSeconds(o->dt_max, o->dt_max_unit, &env->run);
  PetscCheck(env->run.tmax > 0 && !PetscIsInfOrNanReal(env->run.tmax), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_max_time is %.6g, expected a number > 0 s", (double)env->run.tmax);
  PetscCheck(env->dt_min < env->dt_max, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "-train_dt_min is %.6g s and -train_dt_max %.6g s, expected a longer -train_dt_max", (double)env->dt_min,
             (double)env->dt_max);
  PetscCheck(instance->reference || !effects, PETSC_COMM_SELF, PETSC_ERR_ORDER,
             "Reward %s needs an instance with a reference", o->reward->name);
  if (instance->reference) PetscCall(o->problem->judge_create(o, instance, &env->run, effects, &env->judge));
  PetscCall(TSGetAdapt(env->run.ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  if (o->accuracy > 0) PetscCall(TSAdaptRLSetAccuracy(adapt, o->accuracy));
  PetscCall(TSAdaptRLSetActor(adapt, o->nobs, (const char *const *)o->names, env->dt_min, env->dt_max, Actor, env));
  env->actor = actor;
  env->ctx = ctx;
  env->stopped = PETSC_FALSE;
  env->result = (EnvResult){.attempts = 0};
  for (PetscInt i = 0; i < ENV_MAX_ERRORS; ++i) env->result.error[i] = (PetscReal)NAN;
  PetscCall(TSSolve(env->run.ts, env->run.w));
  if (env->judge) {
    PetscCall(o->problem->judge_errors(env->judge, &env->run, env->result.error));
    PetscCall(o->problem->judge_destroy(&env->judge));
  }
  *result = env->result;
  PetscCall(o->problem->destroy(&env->run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvRunEpisode(Environment *env, Random *random, EnvActorFn actor, void *ctx, EnvResult *result)
{
  const PetscBool reference = env->o.reward && env->o.reward->needs_continuation ? PETSC_TRUE : PETSC_FALSE;
  EnvInstance instance;

  PetscFunctionBegin;
  PetscCall(EnvInstanceCreate(&env->o, env->o.random ? random : NULL, reference, &instance));
  PetscCall(EnvRunInstance(env, &instance, actor, ctx, result));
  PetscCall(EnvInstanceDestroy(&env->o, &instance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnvSetTolerances(TS ts, PetscReal rtol, PetscReal factor)
{
  Vec vatol, scaled = NULL;
  PetscReal atol;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, &atol, &vatol, NULL, NULL));
  if (vatol) {
    PetscCall(VecDuplicate(vatol, &scaled));
    PetscCall(VecCopy(vatol, scaled));
    PetscCall(VecScale(scaled, factor));
  }
  PetscCall(TSSetTolerances(ts, vatol ? atol : factor * atol, scaled, rtol, NULL));
  PetscCall(VecDestroy(&scaled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the table of rewards ---- */

#define SOLVE_COST 0.25   /* an attempt */
#define FAILURE_COST 0.25 /* on top of that, an attempt that did not converge */
#define EFFECT_PRICE 1    /* four attempts for an effect of 1 */
#define BALANCE 0.5
#define WORST_STEP 15 /* largest penalty of one step's error, so that one disaster does not drown everything else */

/* R = S1 S2 exp(-alpha E); -S1 when the step fails. S1: how long the step is, S2: how cheap it was. */
static PetscReal Published(const RewardInput *in)
{
  const PetscReal length =
    PetscClipInterval((in->attempt->dt - in->dt_min) / (in->dt_max - in->dt_min), (PetscReal)0, (PetscReal)1);
  const PetscReal span = PetscMax((PetscReal)1e-8, in->cost_max - in->cost_min);

  if (!in->attempt->converged) return -length;
  return length * (1 - (in->cost - in->cost_min) / span) * PetscExpReal(-in->alpha * in->attempt->error);
}

/* A price for each attempt and one for the error that the step leaves in what matters at the end. */
static PetscReal Priced(const RewardInput *in, PetscReal weight)
{
  if (!in->attempt->converged) return -SOLVE_COST - FAILURE_COST;
  return -SOLVE_COST - PetscMin(weight * EFFECT_PRICE * in->effect, (PetscReal)WORST_STEP);
}

static PetscReal Accuracy(const RewardInput *in)
{
  return Priced(in, in->alpha);
}

/* With N steps of second order a run costs N + weight/N^2, least at an N that grows as the cube root of the weight. The
   study's alphas, 0.5 to 128, would ask for six times as many steps with the last as with the first; their cube roots
   for less than twice as many. */
static PetscReal Balanced(const RewardInput *in)
{
  return Priced(in, (PetscReal)BALANCE * PetscPowReal(in->alpha, 1. / 3));
}

static const Reward RewardTable[] = {
  {"published", "length of the step, times cheapness, times exp(-alpha E_r); minus the length when it fails",
   PETSC_FALSE, Published},
  {"accuracy",
   "-0.25 an attempt (-0.5 a failed one) and alpha times the error that a step leaves; for the fault and alpha 1, -0.5 "
   "for each 1 % by which the step changes the final slip, 10 % by which it changes the peak rate and 5 % by which it "
   "shifts the event in time; for small systems -0.5 for each 1 % by which it leaves the exact solution",
   PETSC_TRUE, Accuracy},
  {"balanced", "as accuracy, with 0.5 times the cube root of alpha as the weight", PETSC_TRUE, Balanced},
  {NULL, NULL, PETSC_FALSE, NULL}};

PetscErrorCode RewardFind(const char name[], const Reward **row)
{
  const char *names[PETSC_STATIC_ARRAY_LENGTH(RewardTable)];
  PetscInt k;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(RewardTable); ++i) names[i] = RewardTable[i].name;
  PetscCall(OptionFind("-train_reward", name, names, &k));
  *row = &RewardTable[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}
