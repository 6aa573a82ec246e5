/* Small faults that slip under a pore pressure alone (train -train_algorithm tolerances
   -train_problem injection): the problem by which tolerances of injections are measured. */
#include "runs.h"
#include <slipcompat.h>

#define USUAL_TYPE TSADAPTHEURISTIC
#define USUAL_RTOL 1e-3
#define CONFIRM_RTOL (8 * RUN_INJECTION_RTOL) /* of the run that confirms the reference */
#define CONFIRMED 1e-3                        /* with this error at most */
#define BEGUN 0.01                            /* a cell has begun at this share of the final largest slip */
#define LEAST_BEGUN 0.1                       /* share of the cells that begin, and */
#define FEWEST_BEGUN 3                        /* so many at least, not to be drawn again */
#define MOST_ATTEMPTS 10000                   /* of a reference, and of classical controllers */

/* The largest of the Levy distance of mean slip over time, over the final slip and the duration, the errors of the
   cells' final slips, and of the times at which they begin, over the duration */
static PetscErrorCode Compare(const RunEpisode *e, const RunResult *r, PetscReal errors[], PetscReal *error)
{
  PetscFunctionBegin;
  errors[SLIP_ERROR_HISTORY] = SlipCourseLevy(r->course.n, RunNodes(r), e->reference.course.n, RunNodes(&e->reference));
  errors[SLIP_ERROR_FIELD] = RunFieldError(e->n, r->slip, e->reference.slip);
  errors[SLIP_ERROR_SHIFT] = RunPassedError(e, r, e->end);
  *error = PetscMax(PetscMax(errors[SLIP_ERROR_HISTORY], errors[SLIP_ERROR_FIELD]), errors[SLIP_ERROR_SHIFT]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Enough of it slips, and two tight runs agree. */
static PetscErrorCode Judge(RunEpisode *e, PetscBool *good)
{
  const RunRequest usual = {NULL, USUAL_TYPE, USUAL_RTOL, .end = e->end, .most = MOST_ATTEMPTS / 8},
                   tight = {NULL, RUN_INJECTION_TYPE, RUN_INJECTION_RTOL, .end = e->end, .most = MOST_ATTEMPTS};
  PetscReal most = 0;
  PetscInt begun = 0;
  EpisodeResult confirmed;
  RunResult r;

  PetscFunctionBegin;
  PetscCall(RunIntegrate(e, &usual, &r));
  for (PetscInt i = 0; i < e->n; i++) most = PetscMax(most, r.slip[i]);
  for (PetscInt i = 0; i < e->n; i++) begun += r.slip[i] > BEGUN * most ? 1 : 0;
  e->usual = r.solves;
  e->work = r.work;
  *good = r.good && most > 0 && begun >= FEWEST_BEGUN && (PetscReal)begun >= LEAST_BEGUN * (PetscReal)e->n
            ? PETSC_TRUE
            : PETSC_FALSE;
  PetscCall(RunResultDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(e->n, &e->level));
  for (PetscInt i = 0; i < e->n; i++) e->level[i] = (PetscReal)BEGUN * most;
  PetscCall(RunIntegrate(e, &tight, &e->reference));
  *good = e->reference.good;
  if (*good) {
    PetscCall(RunEpisodeRun(e, NULL, RUN_INJECTION_TYPE, CONFIRM_RTOL, &confirmed));
    *good = confirmed.done == 1 && confirmed.error < CONFIRMED ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const RunKind RunInjection = {.size = sizeof(RunEpisode),
                              .column = 2,
                              .slips = 1,
                              .bounded = PETSC_TRUE,
                              .draw = InjectionDraw,
                              .judge = Judge,
                              .compare = Compare,
                              .most = MOST_ATTEMPTS,
                              .expected =
                                "slips: expected one of which a tenth of the cells, and three of them, slip a "
                                "hundredth of the most",
                              .work = PETSC_TRUE,
                              .worst = 50};

/* ---- the problem: no policy of it is trained ---- */

static const CMAProblem CMAInjections = {RUNS, .stream = 15, .runs = &RunInjection, .create = RunsCreate,
                                         .classical = RunsClassical};

const Problem ProblemInjection = {
  .name = "injection", .meaning = "small faults that slip under a pore pressure", .cma = &CMAInjections};
