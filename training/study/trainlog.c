/* The learning curve in HDF5. */
#include "trainer.h"
#include "common/files.h"
#include <petsctime.h>

struct _TrainLog {
  SlipH5 h5;
};

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
  h = &t->log->h5;
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
  if (t->log) PetscCall(CurveAppend(&t->log->h5, EPISODE_COLUMNS, EpisodeColumns, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainLogEvaluation(Trainer *t, double mean_return, double attempts, double error)
{
  const PetscReal row[EVALUATION_COLUMNS] = {(PetscReal)t->agent.steps, mean_return, attempts, error};

  PetscFunctionBegin;
  PetscCall(Open(t));
  if (t->log) PetscCall(CurveAppend(&t->log->h5, EVALUATION_COLUMNS, EvaluationColumns, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrainLogClose(TrainLog *log)
{
  PetscFunctionBegin;
  if (!*log) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipH5Close(&(*log)->h5));
  PetscCall(PetscFree(*log));
  PetscFunctionReturn(PETSC_SUCCESS);
}
