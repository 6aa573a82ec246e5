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
  Table course; /* of the start's continuation */
};

struct _EnvJudge {
  const EnvOptions *o;
  EnvReference reference;
  PetscReal dial, penalty; /* penalty: of the state after the last step */
  double *state;           /* [3 cells] */
  Table course;            /* of the run so far and its continuation */
};

static PetscErrorCode MakeEpisode(const EnvOptions *o, const EnvInstance *instance, Episode **episode)
{
  const PetscReal *value = instance->value;

  PetscFunctionBegin;
  PetscCall(EpisodeCreate((const Family *)o->family, (uint64_t)value[SEED],
                          instance->drawn && value[KIND] < MESH_SHARE ? MESH_SIDE : 1, episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Constant steps from a state [3 cells] at time t to rest or to the end of the episode, added to a course. The reaction
   is the balance where a cell rests and the strength where it moves: no other state is needed. */
static PetscErrorCode Continue(const EnvOptions *o, Episode *e, const double state[], PetscReal t, Table *course)
{
  const PetscReal dt = o->continuation * e->tstar;
  PlainFault *p = &e->plain;
  PetscReal row[COURSE_WIDTH];
  PetscBool moves = PETSC_TRUE;

  PetscFunctionBegin;
  PlainFaultSetState(p, state);
  while (moves && t < e->tmax) {
    if (!PlainFaultAttempt(p, dt)) break;
    PlainFaultAccept(p);
    moves = PETSC_FALSE;
    for (PetscInt i = 0; i < p->n; ++i)
      if (p->v[i] != 0 || p->s[i] == 0) moves = PETSC_TRUE;
    row[0] = t += dt;
    PlainMeans(p, &row[1], &row[2]);
    PetscCall(TableAdd(course, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceCreate(const EnvOptions *o, const EnvInstance *instance, EnvReference *reference)
{
  const PetscReal start[COURSE_WIDTH] = {0, 0, 0};

  PetscFunctionBegin;
  PetscCheck(instance->drawn, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONGSTATE,
             "-train_problem fault_dial has drawn faults only: add -train_random");
  PetscCall(PetscNew(reference));
  PetscCall(MakeEpisode(o, instance, &(*reference)->episode));
  (*reference)->course.width = COURSE_WIDTH;
  PetscCall(TableAdd(&(*reference)->course, start));
  PetscCall(Continue(o, (*reference)->episode, (*reference)->episode->plain_start, 0, &(*reference)->course));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReferenceDestroy(EnvReference *reference)
{
  PetscFunctionBegin;
  PetscCall(EpisodeDestroy((void **)&(*reference)->episode));
  PetscCall(TableClear(&(*reference)->course));
  PetscCall(PetscFree(*reference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The run is that of the reference's episode; without a reference, of one of its own. */
static PetscErrorCode Create(const EnvOptions *o, const EnvInstance *instance, EnvRun *run)
{
  Episode *e;

  PetscFunctionBegin;
  run->model = NULL;
  if (instance->reference)
    e = instance->reference->episode;
  else {
    PetscCall(MakeEpisode(o, instance, &e));
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
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(run->ts, &adapt));
  PetscCall(TSAdaptRLSetActor(adapt, 0, NULL, 0, 0, NULL, NULL));
  PetscCall(EpisodeDestroy(&run->model));
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
  (*judge)->course.width = COURSE_WIDTH;
  PetscCall(VecGetSize(run->w, &n));
  PetscCall(PetscMalloc1(n, &(*judge)->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Error of the run so far and its continuation from j->state at time t. Both, and the start's continuation, which it is
   compared with, take the same steps; the field of slip is seen at the end only. */
static PetscErrorCode ContinuedError(EnvJudge j, PetscReal t, PetscReal *error)
{
  Episode *e = j->reference->episode;
  const Table *start = &j->reference->course;
  PetscReal errors[SLIP_NUM_ERRORS];

  PetscFunctionBegin;
  j->course.n = 0;
  for (PetscInt k = 0; k < e->run.n; ++k) PetscCall(TableAdd(&j->course, e->run.data + COURSE_WIDTH * k));
  PetscCall(Continue(j->o, e, j->state, t, &j->course));
  SlipCourseCompare(j->course.n, CourseNodes(&j->course), start->n, CourseNodes(start), errors);
  *error = SlipMeasureOf(e->measure, errors);
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
  PetscCall(EpisodeFollow(e, t, run->w));
  if (t < run->tmax * (1 - 1e-12)) {
    PetscReal error = 0;

    PetscCall(ContinuedError(j, t, &error));
    penalty = EpisodePenalty(error / j->dial);
  } else { /* nothing to continue: what the whole run costs but for its solves */
    EpisodeResult r;

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
  error[0] = r.error / j->dial;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode JudgeDestroy(EnvJudge *judge)
{
  PetscFunctionBegin;
  if (!*judge) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*judge)->state));
  PetscCall(TableClear(&(*judge)->course));
  PetscCall(PetscFree(*judge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Preset DialPresets[] = {
  PRESET(NULL, 1e-2, "T*", 1e2, "T*", PETSC_TRUE, "log_accuracy", "log_growth_time", "growth_rate", "start_growth_rate",
         "log_mode_rate", "log_push", "phase", "progress", "weakening", "damping_ratio", "log_step",
         "change_log_mode_rate", "log_slip_error", "seen_growth", "sliding_fraction", "log_peak_ratio"),
};

/* ---- for CMA-ES ---- */

#define DIAL_LOW 1e-3 /* finer accuracies of the whole history take hundreds of steps */

static PetscErrorCode SetUpTraining(CMAOptions *o)
{
  const Preset *preset = &DialPresets[0];

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .family = o->family,
                    .hidden = 12,
                    CMA_DIAL_DEFAULTS,
                    .dt_min = preset->dt_min,
                    .dt_max = preset->dt_max,
                    .moving = 30,
                    .dt_max_unit = "T*",
                    .nsingle = 400,
                    .nmesh = 200,
                    .batch_single = 24,
                    .batch_mesh = 20,
                    .late_generations = 800,
                    .late_single = 90,
                    .late_mesh = 60,
                    .validation = 60,
                    .calibration = 100,
                    .population = 24,
                    .diagonal = 200,
                    .generations = 2600,
                    .interval = 50,
                    .low = DIAL_LOW};
  PetscCall(CMAObservationsSet(o, preset->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateForCMA(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  return EpisodeCreate((const Family *)o->family, seed, side, (Episode **)episode);
}

const CMAProblem CMAFault = {CMA_DIAL,
                             .kinds = PETSC_TRUE,
                             .measure = "history",
                             .setup = SetUpTraining,
                             .create = CreateForCMA,
                             .destroy = EpisodeDestroy,
                             .run = EpisodeRun,
                             .classical = EpisodeRunClassical,
                             .watch = EpisodeWatch};

/* ---- likewise, with steps that may be explicit ---- */

static PetscErrorCode SetUpProducts(CMAOptions *o)
{
  const char *names[ENV_MAX_OBS + 3] = {NULL};
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCall(SetUpTraining(o));
  for (const char *const *name = DialPresets[0].names; *name; name++) names[n++] = *name;
  names[n++] = "log_step_limit";
  names[n] = "log_solve_cost";
  PetscCall(CMAObservationsSet(o, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateProducts(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  return EpisodeCreateProducts((const Family *)o->family, seed, side, (Episode **)episode);
}

static const CMAProblem CMAProducts = {CMA_DIAL,
                                       .kinds = PETSC_TRUE,
                                       .measure = "history",
                                       .setup = SetUpProducts,
                                       .create = CreateProducts,
                                       .destroy = EpisodeDestroy,
                                       .run = EpisodeRunProducts};

const Problem ProblemProducts = {.name = "fault_products",
                                 .meaning =
                                   "the faults of fault_dial, in steps that are explicit or implicit, as takes "
                                   "fewer products with stiffness and viscosity",
                                 .cma = &CMAProducts};

const Problem ProblemDial = {.name = "fault_dial",
                             .policy_problem = "fault",
                             .meaning =
                               "faults drawn as by -train_algorithm cmaes, at a random position of the accuracy dial",
                             .has_dial = PETSC_TRUE,
                             PROBLEM_DRAWS(DialDraws),
                             .presets = DialPresets,
                             PROBLEM_FAULT_TOLERANCES,
                             PROBLEM_ERRORS("history of slip over the dial"),
                             PROBLEM_FUNCTIONS(Create),
                             .cma = &CMAFault};
