/* What can be trained on: a problem, which the environment steps through without knowing it. It creates runs of the
   problem, draws its random instances, and knows the errors of a run and what a step changes in the exact continuation.
   The environment steps through runs and knows no problem. Public headers of the library only. */
#pragma once
#include "common/random.h"
#include "sliptrain.h"
#include <slipstep/rooms.h>

#define ENV_MAX_OBS 16
#define ENV_MAX_DRAW 12
#define ENV_MAX_ERRORS 3

/* What an attempted step is worth: rows of a table, chosen by -train_reward. Everything a reward may use. Costs are
   those of -train_cost: Newton iterations or wall seconds. */
typedef struct {
  const SlipAttempt *attempt;
  PetscReal dt_min, dt_max;           /* bounds of the action [s] */
  PetscReal cost, cost_min, cost_max; /* of the attempt; running extrema over successful ones, this one included */
  PetscReal alpha;                    /* weight of the error, -train_alpha */
  PetscReal effect; /* weighted errors that the step leaves in the exact continuation, see Problem.judge_step */
} RewardInput;

typedef struct {
  const char *name, *meaning;
  PetscBool needs_continuation; /* effect */
  PetscReal (*value)(const RewardInput *in);
} Reward;

typedef struct _Problem Problem;
typedef struct _CMAProblem CMAProblem; /* cmaproblem.h */

typedef struct {
  const Problem *problem;
  const Reward *reward; /* NULL: episodes have no rewards, and no continuation is computed for them */
  PetscBool wall_cost;  /* cost of an attempt: wall time instead of nonlinear iterations */
  PetscReal alpha;
  PetscBool random; /* draw an instance for every episode */
  PetscInt nobs;
  char *names[ENV_MAX_OBS];                          /* observations */
  PetscReal scale[ENV_MAX_OBS], offset[ENV_MAX_OBS]; /* the network sees obs * scale + offset */
  PetscReal dt_min, dt_max;                          /* bounds of the action */
  char dt_min_unit[8], dt_max_unit[8];               /* "s", "T*" or "t_max" */
  PetscBool log_spacing;
  PetscReal rtol, atol;   /* relative; absolute in the problem's units; 0: the problem's own */
  PetscReal continuation; /* step of exact continuations [T*] */
  PetscReal accuracy;     /* position of the accuracy dial, 0: the controller's default */
  PetscInt max_steps;     /* attempts after which an episode is cut off, 0: never */
} EnvOptions;

/* One simulated instance. */
typedef struct {
  void *model; /* the problem's own: SlipFault, SlipModel */
  TS ts;
  Vec w;
  PetscReal tstar, tmax; /* [s] */
} EnvRun;

/* What is known of an instance's exact solution; computed once, used by any number of runs. And what follows one run.
   Both are the problem's own. */
typedef struct _EnvReference *EnvReference;
typedef struct _EnvJudge *EnvJudge;

/* What an episode simulates: drawn parameters, or those of the options. */
typedef struct {
  PetscBool drawn;
  PetscReal value[ENV_MAX_DRAW];
  EnvReference reference; /* NULL: no errors and no effects of steps */
} EnvInstance;

/* One instance of a problem that controllers are compared on: what a reference solution belongs to. */
#define PROBLEM_CASE_NAME 96
typedef struct {
  const Problem *problem;
  PetscReal size;               /* edge of the fault [km], 0: no such thing */
  PetscInt mesh;                /* cells along each edge, 0: no such thing */
  char name[PROBLEM_CASE_NAME]; /* group in the file: "fault_3km_25x25", "circuit" */
} ProblemCase;

/* What the program evaluate needs of a problem. */
typedef struct {
  PetscBool meshes;  /* has sizes and meshes, and runs on any number of processes; otherwise on one */
  PetscInt nstates;  /* the first columns of the series, the state whose errors are measured */
  PetscInt ncolumns; /* of the series besides time */
  const char *const *columns, *const *units;
  PetscInt rate;      /* column whose largest error is recorded on its own, -1: none */
  PetscBool relative; /* errors over the size of the reference; otherwise in the unit of the state */
  PetscInt reference; /* default number of constant steps of the reference; 0: an exact solution is known */
  /* What runs of one case share, costly to set up */
  PetscErrorCode (*create)(MPI_Comm comm, const ProblemCase *c, void **model);
  PetscErrorCode (*destroy)(void **model);
  /* A TS at its start, configured as far as TSSetFromOptions() */
  PetscErrorCode (*start)(MPI_Comm comm, const ProblemCase *c, void *model, TS *ts, Vec *w);
  PetscErrorCode (*observe)(const ProblemCase *c, void *model, PetscReal t, Vec w, Vec r,
                            PetscReal row[]);                                                /* [ncolumns] */
  PetscErrorCode (*profiles)(const ProblemCase *c, void *model, Vec w, PetscReal profile[]); /* [mesh] */
  PetscErrorCode (*exact)(void *model, PetscReal t, PetscReal row[]);                        /* [ncolumns] */
} Evaluation;

/* One drawn parameter in [low, high]. */
typedef struct {
  const char *meaning;
  PetscReal low, high;
  PetscBool uniform; /* otherwise log-uniform */
} DrawRow;

/* Default observations and bounds of the step for a reward. */
typedef struct {
  const char *reward; /* name, NULL: any other */
  const char *names[ENV_MAX_OBS + 1];
  PetscReal dt_min, dt_max;
  const char *dt_min_unit, *dt_max_unit;
  PetscBool log_spacing;
} Preset;

struct _Problem {
  const char *name, *meaning;
  const char *policy_problem; /* what its policies are for; NULL: name */
  const DrawRow *draw;
  PetscInt ndraw;
  PetscBool (*drawable)(const PetscReal drawn[]);      /* NULL: all draws are good */
  const SlipModelOps *model;                           /* of a small model, else NULL */
  void (*apply)(const PetscReal drawn[], void *model); /* draws to the parameters of a small model */
  const Preset *presets;                               /* the last one has reward NULL */
  PetscReal rtol, atol;                                /* defaults of -train_rtol and -train_atol */
  const char *atol_unit;
  PetscInt nerrors;
  const char *errors[ENV_MAX_ERRORS]; /* what EnvResult.error holds, the most important one first */
  /* Step by step, for TQC and TD3; create NULL: not for these. */
  /* A run at its start, TS ready for TSSolve() but for the step limits and the controller. */
  PetscErrorCode (*create)(const EnvOptions *o, const EnvInstance *instance, EnvRun *run);
  PetscErrorCode (*destroy)(EnvRun *run);
  PetscErrorCode (*reference_create)(const EnvOptions *o, const EnvInstance *instance, EnvReference *reference);
  PetscErrorCode (*reference_destroy)(EnvReference *reference);
  /* Follow a run that has not begun; instance->reference is known. */
  PetscErrorCode (*judge_create)(const EnvOptions *o, const EnvInstance *instance, EnvRun *run, PetscBool effects,
                                 EnvJudge *judge);
  /* effects: what the accepted step to time t, the current state of the run, changes in the exact continuation: errors
     of the whole run, weighted such that 1 is worth four attempts. Called once after each accepted step. */
  PetscErrorCode (*judge_step)(EnvJudge judge, EnvRun *run, PetscReal t, PetscReal *effect);
  PetscErrorCode (*judge_errors)(EnvJudge judge, EnvRun *run, PetscReal error[]); /* [nerrors], after TSSolve() */
  PetscErrorCode (*judge_destroy)(EnvJudge *judge);
  const CMAProblem *cma;        /* NULL: not for -train_algorithm cmaes */
  const SlipTrainProblem *user; /* a user's table; NULL: one of ours */
  const Evaluation *evaluation; /* NULL: it is only trained on */
};

/* Rows of a problem's presets: bounds of the step with their units, spacing, observations. */
#define PRESET(reward_, low, low_unit, high, high_unit, logarithmic, ...)                                              \
  {                                                                                                                    \
    .reward = (reward_), .names = {__VA_ARGS__}, .dt_min = (low), .dt_max = (high), .dt_min_unit = (low_unit),         \
    .dt_max_unit = (high_unit), .log_spacing = (logarithmic)                                                           \
  }

/* The functions of a problem's row, which go by the same names in every file. */
#define PROBLEM_FUNCTIONS                                                                                              \
  .create = Create, .destroy = Destroy, .reference_create = ReferenceCreate, .reference_destroy = ReferenceDestroy,    \
  .judge_create = JudgeCreate, .judge_step = JudgeStep, .judge_errors = JudgeErrors, .judge_destroy = JudgeDestroy

/* .ndraw and .nerrors follow from the rows. */
#define PROBLEM_DRAWS(rows) .draw = rows, .ndraw = PETSC_STATIC_ARRAY_LENGTH(rows)
#define PROBLEM_ERRORS(...)                                                                                            \
  .nerrors = sizeof((const char *[]){__VA_ARGS__}) / sizeof(const char *), .errors = {__VA_ARGS__}
