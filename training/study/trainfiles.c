/* The files of a training: the policy; checkpoints of networks, optimisers, buffer, random numbers and counters, so
   that training goes on bit by bit; the learning curve. */
#include "trainer.h"
#include "common/files.h"
#include "problems/problems.h"
#include <petsctime.h>

/* The actor as a policy file of the library */
PetscErrorCode TrainerStorePolicy(Trainer *t, const char file[])
{
  const EnvOptions *e = &t->o.env;
  const Scalar *a = t->best_actor;
  DenseShape s;
  SlipPolicy p;

  PetscFunctionBegin;
  PetscCall(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  PetscCall(SlipPolicySetObservations(p, e->nobs, (const char *const *)e->names, e->scale, e->offset));
  t->agent.o.learner->policy(t->agent.learner, &s);
  for (PetscInt l = 0; l < s.layers; ++l) {
    const PetscInt in = s.size[l], out = s.size[l + 1];
    const SlipActivation last = t->agent.o.learner->clamp ? SLIP_ACTIVATION_HARDTANH2 : SLIP_ACTIVATION_LINEAR;
    PetscReal *weight, *bias;

    PetscCall(PetscMalloc2(in * out, &weight, out, &bias));
    for (PetscInt i = 0; i < in * out; ++i) weight[i] = (PetscReal)a[s.weight[l] + (size_t)i];
    for (PetscInt i = 0; i < out; ++i) bias[i] = (PetscReal)a[s.bias[l] + (size_t)i];
    PetscCall(SlipPolicyAddLayer(p, in, out, weight, bias, l + 1 < s.layers ? SLIP_ACTIVATION_RELU : last));
    PetscCall(PetscFree2(weight, bias));
  }
  PetscCall(SlipPolicySetAction(p, -1, 1, e->dt_min, e->dt_min_unit, e->dt_max, e->dt_max_unit, e->log_spacing));
  PetscCall(SlipPolicySetRange(p, t->env.obs_min, t->env.obs_max));
  PetscCall(SlipPolicySetAttribute(p, "algorithm", t->o.agent.learner->name));
  PetscCall(SlipPolicySetAttribute(p, "problem", ProblemPolicy(e->problem)));
  PetscCall(SlipPolicySetAttribute(p, "reward", e->reward->name));
  PetscCall(PolicySetNumber(p, "alpha", "%g", (double)e->alpha));
  PetscCall(PolicySetNumber(p, "training_steps", "%.0f", (double)t->best_steps));
  PetscCall(PolicySetNumber(p, "seed", "%.0f", (double)t->o.seed));
  PetscCall(SlipPolicyStore(p, file));
  PetscCall(SlipPolicyDestroy(&p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints ---- */

#define CHECKPOINT_FORMAT "slipstep-training"
#define RANDOM_WORDS 6
#define CHUNKS 4 /* 16 bits each, so that any PetscInt holds one */

/* The counters and scalars, in one order for both directions. */
enum { NUMBER_COUNT = 16 };
static void ListNumbers(Trainer *t, PetscReal x[NUMBER_COUNT], PetscBool store)
{
  Agent *a = &t->agent;
  LearnerState s;
  PetscInt64 *counter[] = {&a->steps,       &a->updates,     NULL,         NULL,          NULL,
                           &a->replay.size, &a->replay.next, &t->episodes, &t->evaluated, &t->checkpointed,
                           &t->best_steps};
  PetscReal *real[] = {&t->env.cost_min, &t->env.cost_max};
  const PetscInt nc = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(counter), nr = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(real);

  a->o.learner->state(a->learner, &s);
  for (PetscInt i = 0; i < LEARNER_COUNTERS; ++i) counter[2 + i] = s.counter[i];
  for (PetscInt i = 0; i < nc; ++i) {
    if (store)
      x[i] = (PetscReal)*counter[i];
    else
      *counter[i] = (PetscInt64)x[i];
  }
  for (PetscInt i = 0; i < nr; ++i) {
    if (store)
      x[nc + i] = *real[i];
    else
      *real[i] = x[nc + i];
  }
  if (store)
    x[nc + nr] = (PetscReal)t->best;
  else
    t->best = (double)x[nc + nr];
  for (PetscInt i = nc + nr + 1; store && i < NUMBER_COUNT; ++i) x[i] = 0;
}

static PetscErrorCode WriteRandom(SlipH5 *h, const char path[], const Random *r)
{
  PetscInt chunk[RANDOM_WORDS * CHUNKS], dims[1] = {RANDOM_WORDS * CHUNKS};
  uint64_t word[RANDOM_WORDS];

  PetscFunctionBegin;
  memcpy(word, r, sizeof(word));
  for (PetscInt i = 0; i < RANDOM_WORDS * CHUNKS; ++i)
    chunk[i] = (PetscInt)((word[i / CHUNKS] >> (16 * (i % CHUNKS))) & 0xffff);
  PetscCall(SlipH5WriteInt(h, path, 1, dims, chunk, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadRandom(SlipH5 *h, const char path[], Random *r)
{
  PetscReal *chunk;
  uint64_t word[RANDOM_WORDS] = {0};

  PetscFunctionBegin;
  PetscCall(CheckpointReadFixed(h, path, RANDOM_WORDS * CHUNKS, &chunk));
  for (PetscInt i = 0; i < RANDOM_WORDS * CHUNKS; ++i) word[i / CHUNKS] |= (uint64_t)chunk[i] << (16 * (i % CHUNKS));
  memcpy(r, word, sizeof(word));
  PetscCall(PetscFree(chunk));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointWrite(Trainer *t, const char file[])
{
  SlipH5 h;
  LearnerState s;
  PetscReal x[NUMBER_COUNT], range[2 * ENV_MAX_OBS];
  PetscInt dims[2] = {0, ReplayWidth(&t->agent.replay)};

  PetscFunctionBegin;
  PetscCall(SlipH5Create(file, &h));
  PetscCall(SlipH5WriteAttrString(&h, "/", "format", CHECKPOINT_FORMAT));
  PetscCall(SlipH5WriteAttrInt(&h, "/", "version", 1));
  PetscCall(SlipH5WriteAttrString(&h, "/", "algorithm", t->agent.o.learner->name));
  PetscCall(SlipH5WriteStrings(&h, "/observations", t->o.env.nobs, (const char *const *)t->o.env.names));
  t->agent.o.learner->state(t->agent.learner, &s);
  for (PetscInt i = 0; i < s.n; ++i) {
    dims[0] = (PetscInt)s.array[i].n;
    PetscCall(SlipH5WriteFloat(&h, s.array[i].path, 1, dims, s.array[i].data, NULL));
  }
  dims[0] = (PetscInt)t->nactor;
  PetscCall(SlipH5WriteFloat(&h, "/best/parameters", 1, dims, t->best_actor, NULL));
  ListNumbers(t, x, PETSC_TRUE);
  dims[0] = NUMBER_COUNT;
  PetscCall(SlipH5WriteReal(&h, "/counters", 1, dims, x, NULL));
  PetscCall(PetscArraycpy(range, t->env.obs_min, ENV_MAX_OBS));
  PetscCall(PetscArraycpy(range + ENV_MAX_OBS, t->env.obs_max, ENV_MAX_OBS));
  dims[0] = 2 * ENV_MAX_OBS;
  PetscCall(SlipH5WriteReal(&h, "/range", 1, dims, range, NULL));
  PetscCall(WriteRandom(&h, "/random/agent", &t->agent.random));
  PetscCall(WriteRandom(&h, "/random/instances", &t->instances));
  dims[0] = (PetscInt)t->agent.replay.size;
  PetscCall(SlipH5WriteFloat(&h, "/buffer", 2, dims, t->agent.replay.data, NULL));
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointRead(Trainer *t, const char file[])
{
  char algorithm[64] = "tqc"; /* the first checkpoints had no algorithm */
  Replay *r = &t->agent.replay;
  PetscInt dims[2];
  PetscBool has, same;
  SlipH5 h;
  LearnerState s;
  PetscReal *x;

  PetscFunctionBegin;
  PetscCall(SlipH5OpenRead(file, &h));
  PetscCall(CheckpointCheckFormat(&h, CHECKPOINT_FORMAT, ""));
  PetscCall(SlipH5HasAttribute(&h, "/", "algorithm", &has));
  if (has) PetscCall(SlipH5ReadAttrString(&h, "/", "algorithm", algorithm, sizeof(algorithm)));
  PetscCall(PetscStrcmp(algorithm, t->agent.o.learner->name, &same));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "-train_resume %s was trained with -train_algorithm %s, expected %s", h.name, algorithm,
             t->agent.o.learner->name);
  PetscCall(CheckpointCheckObservations(&h, t->o.env.nobs, t->o.env.names));
  t->agent.o.learner->state(t->agent.learner, &s);
  for (PetscInt i = 0; i < s.n; ++i)
    PetscCall(CheckpointReadArray(&h, s.array[i].path, (PetscInt)s.array[i].n, sizeof(Scalar), s.array[i].data));
  PetscCall(CheckpointReadArray(&h, "/best/parameters", (PetscInt)t->nactor, sizeof(Scalar), t->best_actor));
  PetscCall(CheckpointReadFixed(&h, "/counters", NUMBER_COUNT, &x));
  ListNumbers(t, x, PETSC_FALSE);
  PetscCall(PetscFree(x));
  PetscCall(CheckpointReadFixed(&h, "/range", 2 * ENV_MAX_OBS, &x));
  PetscCall(PetscArraycpy(t->env.obs_min, x, ENV_MAX_OBS));
  PetscCall(PetscArraycpy(t->env.obs_max, x + ENV_MAX_OBS, ENV_MAX_OBS));
  PetscCall(PetscFree(x));
  PetscCall(ReadRandom(&h, "/random/agent", &t->agent.random));
  PetscCall(ReadRandom(&h, "/random/instances", &t->instances));
  if (t->o.transfer) { /* of another instance, of which its transitions and evaluations say nothing */
    r->size = r->next = 0;
    t->best = -PETSC_MAX_REAL;
  } else {
    const PetscInt want[2] = {(PetscInt)r->size, ReplayWidth(r)};

    PetscCheck(r->size >= 0 && r->size <= r->capacity, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "-train_resume %s: /buffer has %" PetscInt64_FMT
               " rows, expected at most -train_buffer %" PetscInt64_FMT,
               h.name, r->size, r->capacity);
    PetscCall(SlipH5ReadRealSized(&h, "/buffer", 2, want, "rows as /counters says", dims, &x));
    for (PetscInt i = 0; i < dims[0] * dims[1]; ++i) r->data[i] = (Scalar)x[i];
    r->next = r->size % r->capacity == 0 ? r->next % r->capacity : r->size;
    PetscCall(PetscFree(x));
  }
  PetscCall(SlipH5Close(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the learning curve ---- */

enum { EPISODE_COLUMNS = 11, EVALUATION_COLUMNS = 4 };
static const CurveColumn EpisodeColumns[EPISODE_COLUMNS] =
  {{"/episodes/step", ""},       {"/episodes/return", ""},       {"/episodes/length", "attempts"},
   {"/episodes/accepted", ""},   {"/episodes/error", ""},        {"/episodes/critic_loss", ""},
   {"/episodes/actor_loss", ""}, {"/episodes/entropy_loss", ""}, {"/episodes/entropy_coefficient", ""},
   {"/episodes/mean_value", ""}, {"/episodes/wall_time", "s"}},
                         EvaluationColumns[EVALUATION_COLUMNS] = {{"/evaluations/step", ""},
                                                                  {"/evaluations/return", ""},
                                                                  {"/evaluations/length", "attempts"},
                                                                  {"/evaluations/error", ""}};

static PetscErrorCode Open(Trainer *t)
{
  SlipH5Kind kind;
  SlipH5 *h;

  PetscFunctionBegin;
  if (t->log || !t->o.log[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&t->log));
  h = t->log;
  PetscCall(CurveKind(&kind));
  PetscCall(SlipH5CreateKind(&kind, t->o.log, h));
  PetscCall(CurveCreate(h, EPISODE_COLUMNS, EpisodeColumns));
  PetscCall(CurveCreate(h, EVALUATION_COLUMNS, EvaluationColumns));
  PetscCall(SlipH5WriteAttrString(h, "/", "problem", t->o.env.problem->name));
  PetscCall(SlipH5WriteAttrString(h, "/", "algorithm", t->o.agent.learner->name));
  PetscCall(SlipH5WriteAttrString(h, "/", "error", t->o.env.problem->errors[0]));
  PetscCall(SlipH5WriteAttrInt(h, "/", "seed", t->o.seed));
  PetscCall(SlipH5WriteAttrReal(h, "/", "alpha", t->o.env.alpha));
  PetscCall(SlipH5WriteAttrString(h, "/", "reward", t->o.env.reward->name));
  PetscCall(SlipH5Live(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainLogEpisode(Trainer *t, const EnvResult *r)
{
  const Losses *l = &t->agent.losses;
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(Open(t));
  PetscCall(PetscTime(&now));
  const PetscReal row[EPISODE_COLUMNS] = {(PetscReal)t->agent.steps,
                                          r->total,
                                          (PetscReal)r->attempts,
                                          (PetscReal)r->accepted,
                                          r->error[0],
                                          l->critic,
                                          l->actor,
                                          l->entropy,
                                          l->alpha,
                                          l->mean_q,
                                          now - t->begin};
  if (t->log) PetscCall(CurveAppend(t->log, EPISODE_COLUMNS, EpisodeColumns, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainLogEvaluation(Trainer *t, double mean_return, double attempts, double error)
{
  const PetscReal row[EVALUATION_COLUMNS] = {(PetscReal)t->agent.steps, mean_return, attempts, error};

  PetscFunctionBegin;
  PetscCall(Open(t));
  if (t->log) PetscCall(CurveAppend(t->log, EVALUATION_COLUMNS, EvaluationColumns, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
