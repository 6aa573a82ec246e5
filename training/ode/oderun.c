/* Runs of a random equation under PETSc's controller basic or a policy, its reference, and what a run costs. */
#include "ode.h"
#include "environment/plainpolicy.h"
#include <slipcompat.h>
#include <math.h>

enum { MOST_POINTS = 20000, TOLERANCES = 7, USUAL_LEAST = 15, USUAL_MOST = 1000 };
#define REFERENCE_TOL 1e-3 /* of the reference over the smallest tolerance that is run */
#define SPREAD 10          /* tolerances of basic's line lie so much round the episode's */
#define WORST 3            /* cost of a run that did not end */

/* ---- a controller ---- */

/* policy NULL: basic */
static PetscErrorCode ControllerStart(PlainPolicy *c, SlipPolicy policy, double order)
{
  PetscBool known;

  PetscFunctionBegin;
  c->policy = policy;
  c->run = (SlipRunNumbers){.order = order};
  if (!policy) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PlainPolicyStart(policy, NULL, c, &known));
  c->run.order = order;
  for (PetscInt i = 0; i < c->n; ++i) {
    const SlipObservation *row = c->seen[i].row;

    PetscCheck(row && row->run && !(row->reads & (SLIP_READS_STATE | SLIP_READS_RESIDUAL)), PETSC_COMM_SELF,
               PETSC_ERR_ARG_WRONG,
               "-train_observations: %s is not known of a plain equation; expected rows of errors and attempts",
               c->seen[i].name);
    c->seen[i].own = -1; /* nor a fault */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The next step after a converged attempt with the step h, as TSAdaptChoose_RL() and TSAdaptChoose_Basic() with its
   defaults have it */
static PetscErrorCode Next(PlainPolicy *c, double E, double h, double *next)
{
  const PetscBool accepted = E <= 1 ? PETSC_TRUE : PETSC_FALSE, again = c->run.rejected > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscReal action;

  PetscFunctionBegin;
  SlipRunAttempt(&c->run, h, PETSC_TRUE, accepted);
  c->run.error = E;
  c->run.failures = 0;
  if (!c->policy) {
    *next = h * PetscClipInterval(E > 0 ? (E > 1 && again ? 0.9 * 0.5 : 0.9) * pow(E, -1 / c->run.order) : 10, 0.1, 10);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PlainPolicyObserve(c, NULL, NULL, accepted);
  PetscCall(SlipPolicyEvaluate(c->policy, c->obs, &action, NULL));
  PetscCall(SlipPolicyActionToStep(c->policy, action, 1, 1, next));
  *next *= h;
  if (!accepted) *next = SlipControlShrink(h, *next, c->run.rejected);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the reference: steps of the fifth order with cubics between them ---- */

static PetscErrorCode ReferenceCreate(OdeEpisode *e, double tol, PetscBool *good)
{
  const PetscInt n = e->ode.n;
  PlainPolicy c;
  OdeStepper s;
  double h = 1e-6 * e->ode.end, next;

  PetscFunctionBegin;
  *good = PETSC_FALSE;
  PetscCall(PetscMalloc3(MOST_POINTS, &e->t, n * MOST_POINTS, &e->y, n * MOST_POINTS, &e->k));
  PetscCall(ControllerStart(&c, NULL, OdeOrder(ODE_DP54)));
  OdeStepperStart(&e->ode, ODE_DP54, tol, &s);
  for (e->n = 0; e->n < MOST_POINTS; e->n++) {
    e->t[e->n] = s.t;
    for (PetscInt i = 0; i < n; ++i) {
      e->y[e->n * n + i] = s.y[i];
      e->k[e->n * n + i] = s.k[i];
      e->scale[i] = fmax(e->scale[i], fabs(s.y[i]));
    }
    if (s.t >= e->ode.end * (1 - 1e-12)) break;
    do {
      if (s.work > 20 * MOST_POINTS) PetscFunctionReturn(PETSC_SUCCESS);
      (void)OdeAttempt(&s, h);
      PetscCall(Next(&c, s.E, h, &next));
      if (s.E <= 1) OdeAccept(&s, h);
      h = SlipControlMatch(next, e->ode.end - s.t);
    } while (s.E > 1);
  }
  if (e->n++ == MOST_POINTS) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < n; ++i)
    if (!(e->scale[i] < 1e4)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < n; ++i) e->scale[i] = fmax(e->scale[i], 1e-2);
  *good = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mean square of the deviation at time t; at: the interval, which only moves on */
static double Deviation(const OdeEpisode *e, double t, const double y[], PetscInt *at)
{
  const PetscInt n = e->ode.n;
  double sum = 0;

  while (*at < e->n - 2 && e->t[*at + 1] < t) ++*at;
  const double h = e->t[*at + 1] - e->t[*at], x = (t - e->t[*at]) / h;
  const double *y0 = e->y + *at * n, *y1 = y0 + n, *k0 = e->k + *at * n, *k1 = k0 + n;

  for (PetscInt i = 0; i < n; ++i) {
    const double exact =
      (1 - x) * (1 - x) * ((1 + 2 * x) * y0[i] + x * h * k0[i]) + x * x * ((3 - 2 * x) * y1[i] - (1 - x) * h * k1[i]);
    const double d = (y[i] - exact) / e->scale[i];

    sum += d * d;
  }
  return sum / (double)n;
}

PetscErrorCode OdeEpisodeRun(const OdeEpisode *e, SlipPolicy policy, double tol, OdeResult *r)
{
  PlainPolicy c;
  OdeStepper s;
  double h = e->first, next, before = 0, now, integral = 0;
  PetscInt at = 0;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  PetscCall(ControllerStart(&c, policy, OdeOrder(e->pair)));
  OdeStepperStart(&e->ode, e->pair, tol, &s);
  while (s.t < e->ode.end * (1 - 1e-12) && r->steps + r->rejected + r->failed < e->limit) {
    if (!OdeAttempt(&s, h)) {
      SlipRunAttempt(&c.run, h, PETSC_FALSE, PETSC_FALSE);
      ++r->failed;
      h *= policy ? 0.5 : 0.25;
      continue;
    }
    PetscCall(Next(&c, s.E, h, &next));
    if (s.E <= 1) {
      OdeAccept(&s, h);
      now = Deviation(e, s.t, s.y, &at);
      integral += 0.5 * h * (before + now);
      before = now;
      ++r->steps;
      h = SlipControlMatch(next, e->ode.end - s.t);
    } else {
      ++r->rejected;
      h = next;
    }
  }
  r->work = s.work;
  r->done = s.t >= e->ode.end * (1 - 1e-12) && integral < PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
  r->error = r->done ? sqrt(integral / e->ode.end) : PETSC_MAX_REAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

double OdeEpisodeCost(const OdeEpisode *e, const OdeResult *r)
{
  if (!r->done) return WORST;
  return PetscClipInterval(log(r->work) - e->basic[0] - e->basic[1] * log(fmax(r->error, 1e-14)), -1, WORST);
}

/* ---- episodes ---- */

/* The line of ln work over ln error through runs of basic; good when their error follows the tolerance */
static PetscErrorCode FitBasic(OdeEpisode *e, PetscBool *good)
{
  double x[TOLERANCES], y[TOLERANCES], mx = 0, my = 0, xx = 0, xy = 0, worst = 0;
  OdeResult r;

  PetscFunctionBegin;
  *good = PETSC_FALSE;
  for (PetscInt i = 0; i < TOLERANCES; ++i) {
    PetscCall(OdeEpisodeRun(e, NULL, e->tol * pow(SPREAD, 2 * (double)i / (TOLERANCES - 1) - 1), &r));
    if (!r.done || !(r.error > 0) || r.steps < USUAL_LEAST || r.steps > USUAL_MOST) PetscFunctionReturn(PETSC_SUCCESS);
    x[i] = log(r.error);
    y[i] = log(r.work);
    mx += x[i] / TOLERANCES;
    my += y[i] / TOLERANCES;
    if (2 * i == TOLERANCES - 1) e->limit = 20 * (r.steps + r.rejected + r.failed) + 200;
  }
  for (PetscInt i = 0; i < TOLERANCES; ++i) {
    xx += (x[i] - mx) * (x[i] - mx);
    xy += (x[i] - mx) * (y[i] - my);
  }
  e->basic[1] = xy / xx;
  e->basic[0] = my - e->basic[1] * mx;
  for (PetscInt i = 0; i < TOLERANCES; ++i) worst = fmax(worst, fabs(y[i] - e->basic[0] - e->basic[1] * x[i]));
  *good = e->basic[1] < -0.08 && e->basic[1] > -1 && worst < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OdeEpisodeCreate(uint64_t seed, OdeEpisode *e)
{
  const double loosest[] = {1e-2, 1e-3, 1e-2}, tightest[] = {1e-5, 1e-6, 1e-4};
  PetscBool good = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  const PetscInt kind = (PetscInt)RandomIndex(&random, (uint64_t)OdeKinds);
  const OdePair pair = (OdePair)RandomIndex(&random, ODE_PAIRS);

  for (PetscInt i = 0; i < 2000 && !good; ++i) {
    PetscCall(PetscMemzero(e, sizeof(*e)));
    OdeDraw(&random, kind, &e->ode);
    e->pair = pair;
    e->tol = RandomLog(&random, tightest[pair], loosest[pair]);
    e->first = e->ode.end * RandomLog(&random, 1e-5, 1e-2);
    e->limit = 3 * USUAL_MOST;
    PetscCall(ReferenceCreate(e, PetscMax(e->tol / SPREAD * REFERENCE_TOL, 1e-11), &good));
    if (good) PetscCall(FitBasic(e, &good));
    if (!good) PetscCall(OdeEpisodeDestroy(e));
  }
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_PLIB, "No usual episode of the family %s in 2000 draws", e->ode.kind);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode OdeEpisodeDestroy(OdeEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(e->t, e->y, e->k));
  PetscFunctionReturn(PETSC_SUCCESS);
}
