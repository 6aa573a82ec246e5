/* TSBATHE's steps on the way to instabilities, and what those of a problem that says when its next row begins to move
   are allowed beside the controller, which knows no jumps: between events the error of a step says little of the next
   one, as rows begin and cease to move, and after an arrest nothing of the steps before. */
#include <slipstep/private/slipts.h>

/* An attempt that would have gone past an instability says that it comes before the attempt's end, the barrier. Most
   begin where one more row begins to move, which the problem foretells: steps go there, all but a small share of the
   way, which is foretold so much better, and then across. Where it does not steps go half way to the barrier, so that
   each of them, taken or refused, halves what is unknown. Refused in a row they are cut by more: years become the
   seconds of its growth in a few attempts. After so many steps in a row that were cut and taken one is not: the
   instability may have begun, and is followed. */
static const PetscReal unstable_factor[] = {0.5, 0.2, 0.1}, short_of_join = 0.01;
enum { most_towards = 2 };
/* Where less than twice this share of the last step is left, the barrier was reached. */
static const PetscReal at_barrier = 1e-2, no_barrier = PETSC_MAX_REAL;
/* Growth after a step of so small an error and change of the rates, over those at its end: controllers double it. What
   grows more, or after rates that changed by more, runs into the next instability more often. */
static const PetscReal small_error = 0.02, small_change = 0.05, most_growth = 4, growth_safety = 0.8;

PetscErrorCode TSBatheIsConstant(TS ts, PetscBool *constant)
{
  return PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, constant);
}

/* Does the problem foretell when rows begin to move, and choose an error estimate steps? */
static PetscErrorCode TSBatheForetells(TS ts, PetscBool *foretells)
{
  const SlipProblemOps *problem;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, NULL));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &given, TSADAPTNONE, TSADAPTHISTORY, "rl", ""));
  *foretells = problem && problem->join && !given ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* *h, cut to the next join if that comes before the barrier: *known. What is not longer than the problem's own time
   goes across, and the barrier is forgotten: an instability has hardly grown then. */
static PetscErrorCode TSBatheToJoin(TS ts, PetscReal *h, PetscBool *known)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal way = ba->barrier - ts->ptime;
  const SlipProblemOps *problem;
  PetscReal join = PETSC_MAX_REAL, scale = 1;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSBatheForetells(ts, known));
  if (!*known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  PetscCall((*problem->join)(ts, ts->ptime, way, ts->vec_sol, &join, ctx));
  *known = join < way ? PETSC_TRUE : PETSC_FALSE;
  if (!*known) PetscFunctionReturn(PETSC_SUCCESS);
  if (problem->time_scale) PetscCall((*problem->time_scale)(ts, &scale, ctx));
  join *= 1 - short_of_join;
  if (join < scale) ba->barrier = no_barrier;
  *h = PetscMin(*h, PetscMax(join, scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step after one that went past an instability; h: the controller's */
PetscErrorCode TSBatheRefused(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscInt last = PETSC_STATIC_ARRAY_LENGTH(unstable_factor) - 1;
  PetscReal join = ba->last.dt, way;
  PetscBool constant, known = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(TSBatheIsConstant(ts, &constant));
  ba->towards = 0;
  if (constant) {
    ba->barrier = no_barrier;
    *h = PetscMin(*h, ba->last.dt * unstable_factor[last]);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ba->barrier = PetscMin(ba->barrier, ts->ptime + ba->last.dt);
  PetscCall(TSBatheForetells(ts, &known));
  way = known ? ba->last.dt : ba->barrier - ts->ptime;
  known = PETSC_FALSE;
  if (ba->failures == 1) PetscCall(TSBatheToJoin(ts, &join, &known));
  if (known && join < ba->last.dt)
    *h = join;
  else
    *h = PetscMin(*h, way * unstable_factor[PetscMin(ba->failures - 1, last)]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step after one that was taken; h: the controller's */
PetscErrorCode TSBatheApproach(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal limit = unstable_factor[0] * (ba->barrier - ts->ptime);
  PetscBool known = PETSC_FALSE;

  PetscFunctionBegin;
  if (ba->barrier != no_barrier && ba->barrier > ts->ptime) PetscCall(TSBatheToJoin(ts, h, &known));
  if (known) PetscFunctionReturn(PETSC_SUCCESS);
  if (limit < at_barrier * ba->last.dt) ba->barrier = no_barrier;
  if (ba->barrier == no_barrier || *h <= limit || ba->towards == most_towards) {
    ba->towards = 0;
  } else {
    ba->towards++;
    *h = limit;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The controller's verdict on an attempt: filters reject by the errors before it, too, after which a good step is one
   like any other */
PetscErrorCode TSBatheForgive(TS ts, PetscBool *accept)
{
  const PetscReal error = ((TS_Bathe *)ts->data)->last.error;
  PetscBool foretells = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(TSBatheForetells(ts, &foretells));
  if (foretells && error >= 0 && error <= 1) *accept = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step after one that was taken; h: the controller's, or what the error allows */
PetscErrorCode TSBatheGrow(TS ts, PetscReal *h)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal error = ba->last.error;
  PetscReal grown = most_growth;
  PetscBool foretells = PETSC_FALSE;
  PetscReal order;

  PetscFunctionBegin;
  PetscCall(TSBatheForetells(ts, &foretells));
  if (!foretells || !(error >= 0 && error < small_error) || ba->change > small_change)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheGetOrder(ts, &order));
  if (error > 0) grown = PetscMin(grown, growth_safety * PetscPowReal(error, -1 / (order + 1)));
  grown = PetscClipInterval(grown * ba->last.dt, ts->adapt->dt_min, ts->adapt->dt_max);
  if (ts->exact_final_time == TS_EXACTFINALTIME_MATCHSTEP) grown = SlipControlMatch(grown, ts->max_time - ts->ptime);
  *h = PetscMax(*h, grown);
  PetscFunctionReturn(PETSC_SUCCESS);
}
