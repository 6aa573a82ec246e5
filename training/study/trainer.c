/* The training run: episodes until the steps are done, evaluation of the deterministic policy in between, the policy
   at the end. */
#include "trainer.h"
#include "common/files.h"
#include <slipcompat.h>
#include <petsctime.h>

#define EVALUATION_SEED 20260 /* the instances of every evaluation are the same */

PetscErrorCode TrainerCreate(const TrainOptions *o, Trainer *t)
{
  LearnerState s;
  Random random;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(t, sizeof(*t)));
  t->o = *o;
  t->best = -PETSC_MAX_REAL;
  PetscCall(EnvCreate(&o->env, &t->env));
  if (
    o->evaluate_interval) { /* drawn once, so that evaluations differ by the policy alone; exact solutions are known */
    if (!o->env.random) t->o.evaluate_episodes = 1;
    RandomSeed(&random, EVALUATION_SEED);
    PetscCall(PetscCalloc1((size_t)t->o.evaluate_episodes, &t->evaluation));
    for (PetscInt i = 0; i < t->o.evaluate_episodes; ++i)
      PetscCall(EnvInstanceCreate(&t->o.env, o->env.random ? &random : NULL, PETSC_TRUE, &t->evaluation[i]));
  }
  PetscCall(AgentCreate(&o->agent, (uint64_t)o->seed, &t->agent));
  RandomSeed(&t->instances, (uint64_t)o->seed + 0x5eed);
  o->agent.learner->state(t->agent.learner, &s);
  t->actor = s.array[0].data;
  t->nactor = s.array[0].n;
  PetscCall(PetscCalloc1(t->nactor, &t->best_actor));
  PetscCall(TrainCheckFiles(PETSC_COMM_SELF, o->output, o->log, o->checkpoint)); /* now, not at the end */
  if (o->resume[0]) PetscCallFile("-train_resume", CheckpointRead(t, o->resume));
  t->begin_steps = t->agent.steps;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainerDestroy(Trainer *t)
{
  PetscFunctionBegin;
  if (t->log) PetscCall(SlipH5Close(t->log));
  PetscCall(PetscFree(t->log));
  PetscCall(AgentDestroy(&t->agent));
  PetscCall(PetscFree(t->best_actor));
  for (PetscInt i = 0; t->evaluation && i < t->o.evaluate_episodes; ++i)
    PetscCall(EnvInstanceDestroy(&t->o.env, &t->evaluation[i]));
  PetscCall(PetscFree(t->evaluation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TrainingActor(const EnvMoment *m, PetscReal *action, PetscBool *stop, void *ctx)
{
  Trainer *t = (Trainer *)ctx;

  PetscFunctionBegin;
  if (!m->first) AgentLearn(&t->agent, m->obs, m->reward, m->terminated);
  *stop = t->agent.steps >= t->o.steps ? PETSC_TRUE : PETSC_FALSE;
  if (m->terminated || m->truncated || *stop) PetscFunctionReturn(PETSC_SUCCESS);
  *action = AgentAct(&t->agent, m->obs, PETSC_TRUE);
  if (m->overruled) t->agent.pending = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EvaluationActor(const EnvMoment *m, PetscReal *action, PetscBool *stop, void *ctx)
{
  Trainer *t = (Trainer *)ctx;

  PetscFunctionBegin;
  (void)stop;
  *action = AgentAct(&t->agent, m->obs, PETSC_FALSE);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Evaluate(Trainer *t)
{
  Environment env = t->env; /* a copy: ranges and extrema of training are not touched */
  EnvResult r;
  double total = 0, attempts = 0, error = 0, n = (double)t->o.evaluate_episodes;

  PetscFunctionBegin;
  if (!env.o.max_steps) env.o.max_steps = 10000; /* a policy that stalls must not stall its evaluation */
  for (PetscInt i = 0; i < t->o.evaluate_episodes; ++i) {
    PetscCall(EnvRunInstance(&env, &t->evaluation[i], EvaluationActor, t, &r));
    total += r.total;
    attempts += (double)r.attempts;
    error += PetscAbsReal(r.error[0]);
  }
  t->evaluated = t->agent.steps;
  if (total / n > t->best) {
    t->best = total / n;
    t->best_steps = t->agent.steps;
    PetscCall(PetscArraycpy(t->best_actor, t->actor, t->nactor));
  }
  PetscCall(TrainLogEvaluation(t, total / n, attempts / n, error / n));
  if (t->o.progress)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "%s  evaluation  return %8.3f  attempts %6.1f  error %7.3f %%%s\n",
                          t->o.label, total / n, attempts / n, 100 * error / n,
                          t->best_steps == t->agent.steps ? "  best so far" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is due after an episode. */
static PetscErrorCode AfterEpisode(Trainer *t, const EnvResult *r, PetscInt64 *shown)
{
  const Losses *l = &t->agent.losses;
  PetscLogDouble now;
  int flag;

  PetscFunctionBegin;
  t->episodes++;
  /* lets other ranks reach the counters of a sweep */
  PetscCallMPI(MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, PETSC_COMM_WORLD, &flag, MPI_STATUS_IGNORE));
  PetscCall(TrainLogEpisode(t, r));
  if (t->o.progress && (t->agent.steps - *shown >= t->o.progress || t->agent.steps >= t->o.steps)) {
    PetscCall(PetscTime(&now));
    PetscCall(PetscPrintf(
      PETSC_COMM_SELF,
      "%sstep %7" PetscInt64_FMT "/%" PetscInt64_FMT "  episode %5" PetscInt64_FMT
      "  return %8.3f  length %4" PetscInt_FMT "  critic %9.3e  actor %9.3f  left %5.0f s\n",
      t->o.label, t->agent.steps, t->o.steps, t->episodes, (double)r->total, r->attempts, l->critic, l->actor,
      (now - t->begin) / (double)(t->agent.steps - t->begin_steps) * (double)(t->o.steps - t->agent.steps)));
    *shown = t->agent.steps;
  }
  if (t->o.evaluate_interval && t->agent.steps - t->evaluated >= t->o.evaluate_interval && t->agent.updates)
    PetscCall(Evaluate(t));
  if (t->o.checkpoint[0] && t->o.checkpoint_interval && t->agent.steps - t->checkpointed >= t->o.checkpoint_interval) {
    t->checkpointed = t->agent.steps;
    PetscCall(CheckpointWrite(t, t->o.checkpoint));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainerRun(Trainer *t)
{
  EnvResult r;
  PetscInt64 shown = t->agent.steps;

  PetscFunctionBegin;
  PetscCall(PetscTime(&t->begin));
  if (t->o.transfer && t->o.evaluate_interval) PetscCall(Evaluate(t)); /* what it is to be better than */
  while (t->agent.steps < t->o.steps) {
    PetscCall(EnvRunEpisode(&t->env, &t->instances, TrainingActor, t, &r));
    PetscCall(AfterEpisode(t, &r, &shown));
  }
  if (t->o.evaluate_interval && t->evaluated < t->agent.steps) PetscCall(Evaluate(t));
  if (!t->o.evaluate_interval) {
    t->best_steps = t->agent.steps;
    PetscCall(PetscArraycpy(t->best_actor, t->actor, t->nactor));
  }
  if (t->o.output[0]) PetscCall(TrainerStorePolicy(t, t->o.output));
  if (t->o.checkpoint[0]) PetscCall(CheckpointWrite(t, t->o.checkpoint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainerTrain(const TrainOptions *o)
{
  Trainer t;

  PetscFunctionBegin;
  PetscCall(TrainerCreate(o, &t));
  PetscCall(TrainerRun(&t));
  PetscCall(TrainerDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}
