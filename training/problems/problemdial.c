/* The episodes of -train_algorithm cmaes as a problem for learners that go step by step: faults drawn at random, single
   cells and small meshes, each at a random position of the accuracy dial. The effect of a step is the change that it
   makes to the penalties of the episode's cost (EpisodeCost()), as an exact continuation sees them; so over a run that
   finishes the effects add up to all of its penalties, whatever the steps. */
#include "episodes.h"
#include <slipcompat.h>

enum { SEED, KIND, DIAL, DRAWS };
static const DrawRow DialDraws[DRAWS] = {
  [SEED] = {"seed of the episode's fault", 0, 1e15, PETSC_TRUE},
  [KIND] = {"kind (below 0.36 a mesh)", 0, 1, PETSC_TRUE}, /* 144 of 400, as in the defaults of cmaes */
  [DIAL] = {"position of the accuracy dial", TSADAPTRL_ACCURACY_MIN, TSADAPTRL_ACCURACY_MAX, PETSC_FALSE},
};
#define MESH_SHARE 0.36
#define MESH_SIDE 7

struct _EnvReference {
  Episode *episode;
  PetscReal slip; /* mean slip at the end of the start's continuation [m] */
};

struct _EnvJudge {
  const EnvOptions *o;
  EnvReference reference;
  PetscReal dial, penalty; /* penalty: of the state after the last step */
  double *state;           /* [3 cells] */
};

static PetscErrorCode MakeEpisode(const EnvInstance *instance, Episode **episode)
{
  const PetscReal *value = instance->value;

  PetscFunctionBegin;
  PetscCall(EpisodeCreate((uint64_t)value[SEED], instance->drawn && value[KIND] < MESH_SHARE ? MESH_SIDE : 1, episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mean slip where constant steps from a state [3 cells] at time t lead, at rest or at the end of the episode. The
   reaction is the balance where an cell rests and the strength where it moves: no other state is needed. */
static PetscReal Continue(const EnvOptions *o, Episode *e, const double state[], PetscReal t)
{
  const PetscReal dt = o->continuation * e->tstar;
  PlainFault *p = &e->plain;
  PetscReal slip = 0;
  PetscBool moves = PETSC_TRUE;

  PlainFaultSetState(p, state);
  for (; moves && t < e->tmax; t += dt) {
    if (!PlainFaultAttempt(p, dt)) break;
    PlainFaultAccept(p);
    moves = PETSC_FALSE;
    slip = 0;
    for (PetscInt i = 0; i < p->n; ++i) {
      if (p->v[i] != 0 || p->s[i] == 0) moves = PETSC_TRUE;
      slip += p->s[i] / (PetscReal)p->n;
    }
  }
  return slip;
}

static PetscErrorCode ReferenceCreate(const EnvOptions *o, const EnvInstance *instance, EnvReference *reference)
{
  PetscFunctionBegin;
  PetscCheck(instance->drawn, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONGSTATE,
             "-train_problem fault_dial has drawn faults only: add -train_random");
  PetscCall(PetscNew(reference));
  PetscCall(MakeEpisode(instance, &(*reference)->episode));
  (*reference)->slip = Continue(o, (*reference)->episode, (*reference)->episode->plain_start, 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceDestroy(EnvReference *reference)
{
  PetscFunctionBegin;
  PetscCall(EpisodeDestroy(&(*reference)->episode));
  PetscCall(PetscFree(*reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The run is that of the reference's episode; without a reference, of one of its own. */
static PetscErrorCode Create(const EnvOptions *o, const EnvInstance *instance, EnvRun *run)
{
  Episode *e;

  PetscFunctionBegin;
  (void)o;
  run->model = NULL;
  if (instance->reference)
    e = instance->reference->episode;
  else {
    PetscCall(MakeEpisode(instance, &e));
    run->model = e;
  }
  PetscCall(EpisodeRewind(e, instance->drawn ? instance->value[DIAL] : TSADAPTRL_ACCURACY_MAX));
  run->ts = e->ts;
  run->w = e->w;
  run->tstar = e->tstar;
  run->tmax = e->tmax;
  run->dial = instance->value[DIAL];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(EnvRun *run)
{
  Episode *own = (Episode *)run->model;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(run->ts, &adapt));
  PetscCall(TSAdaptRLSetActor(adapt, 0, NULL, 0, 0, NULL, NULL));
  if (own) PetscCall(EpisodeDestroy(&own));
  *run = (EnvRun){.problem = run->problem};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeCreate(const EnvOptions *o, const EnvInstance *instance, EnvRun *run, PetscBool effects,
                                  EnvJudge *judge)
{
  PetscInt n;

  PetscFunctionBegin;
  (void)effects;
  PetscCall(PetscNew(judge));
  (*judge)->o = o;
  (*judge)->reference = instance->reference;
  (*judge)->dial = instance->value[DIAL];
  PetscCall(VecGetSize(run->w, &n));
  PetscCall(PetscMalloc1(n, &(*judge)->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeStep(EnvJudge j, EnvRun *run, PetscReal t, PetscReal *effect)
{
  Episode *e = j->reference->episode;
  const PetscScalar *w;
  PetscReal penalty;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetSize(run->w, &n));
  PetscCall(VecGetArrayRead(run->w, &w));
  for (PetscInt i = 0; i < n; ++i) j->state[i] = (double)PetscRealPart(w[i]);
  PetscCall(VecRestoreArrayRead(run->w, &w));
  if (t < run->tmax * (1 - 1e-12))
    penalty = EpisodePenalty(PetscAbsReal(Continue(j->o, e, j->state, t) / j->reference->slip - 1) / j->dial);
  else { /* nothing to continue: what the whole run costs but for its solves */
    EpisodeResult r;

    PetscCall(EpisodeFollow(e, t, run->w));
    EpisodeConclude(e, 0, 0, &r);
    penalty = EpisodeCost(&r, j->dial);
  }
  *effect = penalty - j->penalty;
  j->penalty = penalty;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeErrors(EnvJudge j, EnvRun *run, PetscReal error[])
{
  EpisodeResult r;

  PetscFunctionBegin;
  (void)run;
  EpisodeConclude(j->reference->episode, 0, 0, &r);
  error[0] = r.slip_error / j->dial;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeDestroy(EnvJudge *judge)
{
  PetscFunctionBegin;
  if (!*judge) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*judge)->state));
  PetscCall(PetscFree(*judge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Preset DialPresets[] = {
  PRESET(NULL, 1e-2, "T*", 1e2, "T*", PETSC_TRUE, "log_accuracy", "log_rate", "log_peak_rate", "energy", "progress",
         "weakening", "log_drop", "log_step", "log_slip_error", "growth", "sliding_fraction", "change_sliding_fraction",
         "log_time_left", "converged"),
};

const Problem ProblemDial = {.name = "fault_dial",
                             .policy_problem = "fault",
                             .meaning =
                               "faults drawn as by -train_algorithm cmaes, at a random position of the accuracy dial",
                             .has_dial = PETSC_TRUE,
                             PROBLEM_DRAWS(DialDraws),
                             .presets = DialPresets,
                             PROBLEM_FAULT_TOLERANCES,
                             PROBLEM_ERRORS("final mean slip over the dial"),
                             PROBLEM_FUNCTIONS(Create)};
