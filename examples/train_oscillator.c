static const char help[] =
  "Trains a step-size policy for oscillators with dry friction: the pattern for problems of your own.\n"
  "  mpirun -n 2 train_oscillator -train_output my.h5\n"
  "  oscillator -ts_adapt_type rl -ts_adapt_rl_policy my.h5 -ts_adapt_rl_accuracy 1e-2    (uses it)\n\n";

#include "oscillator.h"
#include <sliptrain.h>

#define FINE 100 /* steps of the reference in a time T* */

/* 1. An instance: a system, its TS, the course that it should take, and how far the run under way has been from it. */
typedef struct {
  Oscillator o;
  TS ts;
  Vec w;
  PetscReal dt, *x; /* of the reference: x[k] at time k dt */
  PetscInt n;
  PetscReal worst; /* largest error of x so far [m] */
} Instance;

/* The reference, by constant steps */
static PetscErrorCode Record(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  const PetscInt one = 1;
  PetscScalar x;

  PetscFunctionBeginUser;
  (void)ts;
  (void)t;
  PetscCall(VecGetValues(w, 1, &one, &x));
  if (step >= 0 && step < ((Instance *)ctx)->n) ((Instance *)ctx)->x[step] = PetscRealPart(x);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reference(Instance *i, PetscReal tstar, PetscReal end)
{
  TSAdapt adapt;
  TS ts;
  Vec w;

  PetscFunctionBeginUser;
  i->n = (PetscInt)PetscCeilReal(FINE * end / tstar) + 1;
  i->dt = end / (PetscReal)(i->n - 1);
  PetscCall(PetscCalloc1(i->n, &i->x));
  PetscCall(CreateState(&i->o, &w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(TSSetSolution(ts, w));
  PetscCall(ConfigureTS(&i->o, ts));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, TSADAPTNONE));
  PetscCall(TSSetTimeStep(ts, i->dt));
  PetscCall(TSSetMaxTime(ts, end));
  PetscCall(TSMonitorSet(ts, Record, i, NULL));
  PetscCall(TSSolve(ts, w));
  PetscCall(VecDestroy(&w));
  PetscCall(TSDestroy(&ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 2. A run is followed: each step against the reference, linear between its points. */
static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Instance *i = (Instance *)ctx;
  const PetscInt k = PetscClipInterval((PetscInt)(t / i->dt), 0, i->n - 2), one = 1;
  const PetscReal part = t / i->dt - (PetscReal)k;
  PetscScalar x;

  PetscFunctionBeginUser;
  (void)ts;
  PetscCall(VecGetValues(w, 1, &one, &x));
  if (step == 0) i->worst = 0;
  i->worst = PetscMax(i->worst, PetscAbsReal(PetscRealPart(x) - (1 - part) * i->x[k] - part * i->x[k + 1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal LogUniform(PetscRandom random, PetscReal low, PetscReal high)
{
  PetscReal u = 0;

  PetscCallAbort(PETSC_COMM_SELF, PetscRandomGetValueReal(random, &u));
  return low * PetscPowReal(high / low, u);
}

/* 3. What the policy shall be good for. The friction stops the motion after 1 to 20 half cycles. */
static PetscErrorCode Draw(uint64_t seed, void **instance, TS *ts, Vec *w)
{
  PetscReal end, tstar;
  PetscRandom random;
  Instance *i;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&i));
  PetscCall(PetscRandomCreate(PETSC_COMM_SELF, &random));
  PetscCall(PetscRandomSetType(random, PETSCRANDER48));
  PetscCall(PetscRandomSetSeed(random, (unsigned long)seed));
  PetscCall(PetscRandomSeed(random));
  i->o.mass = LogUniform(random, 0.1, 10);
  i->o.stiffness = LogUniform(random, 4, 400);
  i->o.start = LogUniform(random, 0.1, 10);
  i->o.normal = i->o.mass * 10;
  i->o.friction = LogUniform(random, 0.025, 0.5) * i->o.stiffness * i->o.start / i->o.normal;
  tstar = PetscSqrtReal(i->o.mass / i->o.stiffness);
  end = tstar * LogUniform(random, 10, 30);
  PetscCall(PetscRandomDestroy(&random));
  PetscCall(Reference(i, tstar, end));
  PetscCall(CreateState(&i->o, &i->w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &i->ts));
  PetscCall(TSSetSolution(i->ts, i->w));
  PetscCall(ConfigureTS(&i->o, i->ts));
  PetscCall(TSSetMaxTime(i->ts, end));
  PetscCall(TSMonitorSet(i->ts, Follow, i, NULL));
  *instance = i;
  *ts = i->ts;
  *w = i->w;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(void **instance)
{
  Instance *i = (Instance *)*instance;

  PetscFunctionBeginUser;
  PetscCall(TSDestroy(&i->ts));
  PetscCall(VecDestroy(&i->w));
  PetscCall(PetscFree(i->x));
  PetscCall(PetscFree(*instance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 4. What the dial bounds: the largest error over the run, relative to the start. */
static PetscErrorCode Error(void *instance, TS ts, Vec w, PetscReal *error)
{
  const Instance *i = (const Instance *)instance;

  PetscFunctionBeginUser;
  (void)ts;
  (void)w;
  *error = i->worst / PetscAbsReal(i->o.start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  static const char *const observations[] = {"log_accuracy", "log_turn", "log_swing", "log_time_left", NULL};
  const SlipTrainProblem problem = {.name = "oscillator",
                                    .draw = Draw,
                                    .error = Error,
                                    .destroy = Destroy,
                                    .observations = observations,
                                    .dt_min = 1e-3,
                                    .dt_max = 3};

  PetscFunctionBeginUser;
  PetscCall(SlipProgramInitialize(&argc, &argv, "train_oscillator", help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipTrain(PETSC_COMM_WORLD, &problem));
  PetscCall(SlipWarnOfUnusedOptions());
  PetscCall(PetscFinalize());
  return 0;
}
