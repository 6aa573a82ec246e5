/* A TS without numerics (y' = 0) for controllers: the test says what each attempt's error is and whether it converged,
   and expects the exact sequence of steps. */
#pragma once
#include "unit.h"
#include <petsc/private/tsimpl.h>
#include <math.h>

/* A handful of pow() and products of numbers near 1: a few hundred roundings of 1.1e-16 at most. */
#define near(a, b) assert_true(fabs((a) - (b)) <= 1e-13 * (1 + fabs(b)))

/* ---- the TS: attempts as scripted ---- */

#define FAIL -2.0 /* in place of an error: the attempt does not converge */

static struct {
  const PetscReal *error; /* of attempt 0, 1, ... */
  int n, at;
  PetscInt order;
  PetscReal tried[64]; /* step of each attempt [s] */
  PetscBool accepted[64], needs_error;
  SlipAttempt last;
  PetscReal energy;      /* what the problem supplies; NaN: nothing */
  const char *untrained; /* what it says of itself */
  int asked;             /* how often */
} script;

static inline PetscErrorCode EvaluateWLTE_Scripted(TS ts, NormType norm, PetscInt *order, PetscReal *wlte)
{
  *order = script.order + 1; /* the power of h in the estimate of a method of that order */
  *wlte = script.last.error;
  return PETSC_SUCCESS;
}

static inline PetscErrorCode GetLastAttempt_Scripted(TS ts, SlipAttempt *attempt)
{
  *attempt = script.last;
  return PETSC_SUCCESS;
}

static inline PetscErrorCode Find_Scripted(TS ts, const char name[], PetscInt *row, void *ctx)
{
  *row = strcmp(name, "energy") || isnan(script.energy) ? -1 : 0;
  return PETSC_SUCCESS;
}

static inline PetscErrorCode Observe_Scripted(TS ts, PetscReal t, PetscInt n, const PetscInt row[], PetscReal value[],
                                              void *ctx)
{
  for (PetscInt i = 0; i < n; i++) {
    assert_int_equal(0, (int)row[i]);
    value[i] = script.energy;
    script.asked++;
  }
  return PETSC_SUCCESS;
}

static inline PetscErrorCode TimeScale_Scripted(TS ts, PetscReal *tstar, void *ctx)
{
  *tstar = 2;
  return PETSC_SUCCESS;
}

static inline PetscErrorCode Untrained_Scripted(TS ts, const char **why, void *ctx)
{
  *why = script.untrained;
  return PETSC_SUCCESS;
}

/* One attempt as TSBATHE makes it; ends the run when the script does. */
static inline PetscErrorCode Attempt(TS ts, PetscBool *accept)
{
  const PetscReal E = script.error[script.at];
  PetscErrorCode (*after)(TSAdapt, TS, PetscReal, PetscReal *);
  PetscReal next = ts->time_step;

  *accept = PETSC_FALSE;
  script.tried[script.at] = ts->time_step;
  script.last = (SlipAttempt){.step = ts->steps, .time = ts->ptime, .dt = ts->time_step, .error = E, .solves = 1};
  script.last.residual = E == FAIL ? 2 : 0.004;
  script.last.converged = E == FAIL ? PETSC_FALSE : PETSC_TRUE;
  if (E == FAIL) {
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseAfterFailure_C", &after));
    PetscCall((*after)(ts->adapt, ts, ts->time_step, &next));
  } else {
    PetscCall(TSAdaptChoose(ts->adapt, ts, ts->time_step, NULL, &next, accept));
  }
  script.accepted[script.at++] = *accept;
  if (*accept) ts->ptime += ts->time_step;
  ts->time_step = next;
  if (script.at == script.n) ts->reason = TS_CONVERGED_USER;
  return PETSC_SUCCESS;
}

static inline PetscErrorCode Step_Scripted(TS ts)
{
  PetscErrorCode (*first)(TSAdapt, TS, PetscReal *);
  PetscErrorCode (*needs)(TSAdapt, PetscBool *);
  PetscBool accept = PETSC_FALSE;

  if (!script.at) {
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptChooseFirst_C", &first));
    if (first) PetscCall((*first)(ts->adapt, ts, &ts->time_step));
    PetscCall(PetscObjectQueryFunction((PetscObject)ts->adapt, "TSAdaptNeedsError_C", &needs));
    script.needs_error = PETSC_TRUE;
    if (needs) PetscCall((*needs)(ts->adapt, &script.needs_error));
  }
  while (!accept && !ts->reason) PetscCall(Attempt(ts, &accept));
  return PETSC_SUCCESS;
}

static const SlipProblemOps Scripted = {.control = {.time_scale = TimeScale_Scripted, .untrained = Untrained_Scripted},
                                        .observations = {.find = Find_Scripted, .observe = Observe_Scripted}};

static inline PetscErrorCode Create_Scripted(TS ts)
{
  ts->ops->step = Step_Scripted;
  ts->ops->evaluatewlte = EvaluateWLTE_Scripted;
  ts->usessnes = PETSC_FALSE;
  ts->default_adapt_type = TSADAPTNONE;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "TSBatheGetLastAttempt_C", GetLastAttempt_Scripted));
  return TSSetSlipProblem(ts, &Scripted, NULL);
}

static inline PetscErrorCode Rhs(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  return VecZeroEntries(f);
}

/* A TS of three components (2, -4, 1), T* = 2 s, 100 s, first step h. */
static inline TS start(const char *type, const char *options, PetscReal h)
{
  TS ts;
  Vec y;
  TSAdapt adapt;

  memset(&script, 0, sizeof(script));
  script.order = 2;
  script.energy = NAN;
  ok(SetOptions(options));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetType(ts, "scripted"));
  ok(TSSetRHSFunction(ts, NULL, Rhs, NULL));
  ok(VecCreateSeq(PETSC_COMM_SELF, 3, &y));
  ok(VecSetValue(y, 0, 2, INSERT_VALUES));
  ok(VecSetValue(y, 1, -4, INSERT_VALUES));
  ok(VecSetValue(y, 2, 1, INSERT_VALUES));
  ok(VecAssemble(y));
  ok(TSSetSolution(ts, y));
  ok(VecDestroy(&y));
  ok(TSSetTimeStep(ts, h));
  ok(TSSetMaxTime(ts, 100));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  ok(TSGetAdapt(ts, &adapt));
  ok(TSAdaptSetType(adapt, type));
  return ts;
}

static inline PetscErrorCode run(TS ts, int n, const PetscReal error[])
{
  script.error = error;
  script.n = n;
  script.at = 0;
  return TSSolve(ts, NULL);
}

static inline void tried(const PetscReal h[])
{
  for (int i = 0; i < script.n; i++)
    if (fabs(script.tried[i] - h[i]) > 1e-13 * fabs(h[i])) /* as in near() */
      fail_msg("attempt %d: step %.17g, expected %.17g", i, script.tried[i], h[i]);
}

static inline void accepted(const char *pattern)
{
  for (int i = 0; i < script.n; i++) assert_int_equal(pattern[i] == 'a', script.accepted[i]);
}

static inline int Register(void **state)
{
  return (int)TSRegister("scripted", Create_Scripted);
}

/* What the heuristic does with q = 1/3: E = 8 halves, E = 1/27 would triple but 2 is the cap, E = 1/8 doubles, E = 0
   grows by the cap. */
static const PetscReal heuristic_error[] = {8, 1, 1.0 / 27, FAIL, 1.0 / 8, 0, 0.5, 1};
static const PetscReal heuristic_h[] = {0.1, 0.05, 0.05, 0.1, 0.06, 0.12, 0.24, 0.30238105197476955};
