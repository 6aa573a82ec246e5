/* Episodes of a user's problem (sliptrain.h): its TS runs under the policy, and it says what the error was. */
#include "episodes.h"
#include <slipstep/rooms/slipadapt.h>
#include <slipcompat.h>

#define UNFINISHED_ERROR 1 /* of a run that was cut off or failed: all of it */
#define MAX_FAILURES 8     /* in a row */
#define WORST_ERROR 1e3    /* of one whose error is no number */

/* TSBatheAttemptFn: a run that goes on for ever is cut off, and so is one whose solves fail, before TSBATHE makes that
   an error. */
static PetscErrorCode Count(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  Episode *e = (Episode *)ctx;

  PetscFunctionBegin;
  (void)w;
  e->failures = attempt->converged ? 0 : e->failures + 1;
  if (--e->attempts_left <= 0 || e->failures >= MAX_FAILURES) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(const CMAOptions *o, uint64_t seed, PetscInt side, void **episode)
{
  const SlipTrainProblem *user = o->problem->user;
  const SlipProblemOps *ops;
  void *ctx;
  PetscReal longest;
  PetscMPIInt size;
  PetscBool bathe;
  TSAdapt adapt;
  Episode *e;

  PetscFunctionBegin;
  (void)side;
  PetscCall(PetscNew(&e));
  *episode = e;
  e->user = user;
  e->run.width = COURSE_WIDTH;
  PetscCall((*user->draw)(seed, &e->instance, &e->ts, &e->w));
  PetscCheck(e->ts && e->w, PETSC_COMM_SELF, PETSC_ERR_ARG_NULL, "SlipTrain(): draw() of problem %s gave no TS or Vec",
             user->name);
  PetscCall(TSBatheIs(e->ts, &bathe));
  PetscCheck(bathe, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "SlipTrain(): the TS of problem %s is of another type than bathe", user->name);
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)e->ts), &size));
  PetscCheck(size == 1, PETSC_COMM_SELF, PETSC_ERR_WRONG_MPI_SIZE,
             "SlipTrain(): the TS of problem %s is on %d processes, expected PETSC_COMM_SELF", user->name, (int)size);
  PetscCall(VecDuplicate(e->w, &e->start));
  PetscCall(VecCopy(e->w, e->start));
  PetscCall(TSSetSolution(e->ts, e->w));
  PetscCall(TSGetTime(e->ts, &e->begin));
  PetscCall(TSGetMaxTime(e->ts, &e->tmax));
  PetscCheck(e->tmax > e->begin && e->tmax < PETSC_MAX_REAL, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "SlipTrain(): a run of problem %s goes from %g to %g s, expected TSSetMaxTime() after the start",
             user->name, (double)e->begin, (double)e->tmax);
  e->tstar = 1;
  PetscCall(TSGetSlipProblem(e->ts, &ops, &ctx));
  if (ops && ops->control.time_scale) PetscCall((*ops->control.time_scale)(e->ts, &e->tstar, ctx));
  PetscCall(TSBatheMonitorSet(e->ts, Count, e, NULL));
  PetscCall(TSSetMaxSteps(e->ts, EPISODE_MAX_STEPS));
  PetscCall(TSSetErrorIfStepFails(e->ts, PETSC_FALSE));
  PetscCall(TSGetAdapt(e->ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  PetscCall(TSAdaptRLSetStrict(adapt, PETSC_TRUE));
  PetscCall(TSAdaptGetStepLimits(adapt, NULL, &longest));
  PetscCall(TSAdaptSetStepLimits(adapt, 0, longest)); /* failures that halve the step are counted, no error */
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **episode)
{
  Episode *e = (Episode *)*episode;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&e->start));
  PetscCall((*e->user->destroy)(&e->instance));
  PetscCall(TableClear(&e->run));
  PetscCall(PetscFree(*episode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(void *episode, SlipPolicy policy, PetscReal accuracy, EpisodeResult *r)
{
  Episode *e = (Episode *)episode;
  TSConvergedReason reason;
  PetscInt solves, accepted;
  PetscReal t;

  PetscFunctionBegin;
  PetscCall(EpisodeSolve(e, policy, accuracy, &accepted, &solves));
  PetscCall(TSGetTime(e->ts, &t));
  PetscCall(TSGetConvergedReason(e->ts, &reason));
  *r = (EpisodeResult){.solves = solves, .attempts = solves, .failures = solves - accepted, .error = UNFINISHED_ERROR};
  r->done = (t - e->begin) / (e->tmax - e->begin);
  if (reason == TS_CONVERGED_TIME || r->done >= 1 - 1e-10) {
    r->done = 1;
    PetscCall((*e->user->error)(e->instance, e->ts, e->w, &r->error));
    if (PetscIsInfOrNanReal(r->error)) r->error = WORST_ERROR;
  }
  r->cost = EpisodeCost(r, accuracy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define DIAL_LOW 3e-3

/* Runs are the library's, some ten times slower than those of small models without objects. */
static PetscErrorCode SetUpTraining(CMAOptions *o)
{
  const SlipTrainProblem *user = o->problem->user;

  PetscFunctionBegin;
  *o = (CMAOptions){.problem = o->problem,
                    .hidden = 6,
                    CMA_DIAL_DEFAULTS,
                    .dt_min = user->dt_min,
                    .dt_max = user->dt_max,
                    .dt_max_unit = "T*",
                    .nsingle = 128,
                    .batch_single = 16,
                    .late_single = 16,
                    .validation = 40,
                    .calibration = 60,
                    .population = 12,
                    .diagonal = 60,
                    .generations = 160,
                    .interval = 20,
                    .low = DIAL_LOW};
  PetscCall(CMAObservationsSet(o, user->observations));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const CMAProblem CMAUser = {CMA_DIAL,   .setup = SetUpTraining, .create = Create, .destroy = Destroy,
                            .run = Run, .watch = EpisodeWatch};
