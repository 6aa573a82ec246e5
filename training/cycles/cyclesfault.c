/* Small faults with cycles of events, drawn at random, and runs of them under a controller. */
#include "cycles.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>
#include <math.h>

#define SHEAR 32e9      /* [Pa] */
#define CORE_DEPTH 0.55 /* of the core, over that of the fault */
#define REFERENCE_RTOL 1e-7
#define USUAL_RTOL 1e-3
#define EVENT_RATE 1e-3  /* an event begins when the fastest cell passes it [m/s] */
#define QUIET_RATE 1e-5  /* and another one only after all were slower [m/s] */
#define END_AFTER 0.3    /* of the recurrence after the last event, in which none may follow */
#define MOST_STEPS 30000 /* of a reference */
#define LOST 4           /* cost of a run that is not good */
#define WORST_ERROR 50   /* over the accuracy: a larger one costs no more */

static const PetscInt Meshes[][2] = {{16, 8}, {20, 10}, {12, 12}, {24, 6}, {1, 48}, {1, 32}};

/* ---- a fault ---- */

/* In SI units; the weakening core is surrounded by cells that creep, of which the fault is half. */
typedef struct {
  PetscInt nx, nz;
  double cell, stress, a, b, slip, rim; /* a in the core, that of the rim over b */
} Draw;

/* G d_c/(b sigma): the length over which a rupture front weakens [m] */
static double FrontLength(const Draw *d)
{
  return SHEAR * d->slip / (d->b * d->stress);
}

static void DrawFault(Random *random, Draw *d)
{
  const PetscInt *mesh = Meshes[RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Meshes))];

  d->nx = mesh[0];
  d->nz = mesh[1];
  d->cell = RandomLog(random, 200, 2500);
  d->stress = RandomLog(random, 15e6, 60e6);
  d->b = RandomLog(random, 0.01, 0.03);
  d->a = d->b * (0.13 + 0.4 * RandomUniform(random));
  d->rim = 1.15 + RandomUniform(random);
  d->slip = 1;
  d->slip = RandomLog(random, 2.5, 4.5) * d->cell / FrontLength(d);
}

static PetscErrorCode SetNumbers(const Draw *d, SlipFault fault)
{
  const struct {
    const char *name;
    double value;
  } rows[] = {{"nx", (double)d->nx},
              {"nz", (double)d->nz},
              {"length_x", d->nx == 1 ? 1e7 : (double)d->nx * d->cell},
              {"length_z", (double)d->nz * d->cell},
              {"shear_modulus", SHEAR},
              {"density", 2670},
              {"normal_stress", d->stress},
              {"normal_stress_gradient", 0},
              {"friction_b", d->b},
              {"friction_slip", d->slip},
              {"loading_rate", 1e-9}};

  PetscFunctionBegin;
  PetscCall(SlipFaultSetString(fault, "friction_law", "rate_and_state"));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++)
    PetscCall(SlipFaultSetReal(fault, rows[i].name, (PetscReal)rows[i].value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The core reaches from a fifth of the depth to three quarters and over the middle two thirds along strike; a tenth of it, at one end,
   begins ten times faster than the rest. */
static PetscErrorCode SetFields(const Draw *d, SlipFault fault)
{
  const PetscInt n = d->nx * d->nz;
  PetscReal *a, *rate;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &a, n, &rate));
  for (PetscInt i = 0; i < n; i++) {
    const double x = ((double)(i % d->nx) + 0.5) / (double)d->nx - 0.5, z = ((double)(i / d->nx) + 0.5) / (double)d->nz;
    const PetscBool core =
      (d->nx == 1 || fabs(x) < 1.0 / 3) && z > 0.2 && z < 0.2 + CORE_DEPTH ? PETSC_TRUE : PETSC_FALSE;

    a[i] = (PetscReal)(core ? d->a : d->b * d->rim);
    rate[i] = core && (d->nx == 1 ? z > 0.6 : x < -0.2) ? 1e-8 : 1e-9;
  }
  PetscCall(SlipFaultSetField(fault, "friction_a", n, a));
  PetscCall(SlipFaultSetField(fault, "initial_rate", n, rate));
  PetscCall(PetscFree2(a, rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

typedef struct {
  CycleResult *result;
  PetscInt most;            /* events after which it ends */
  PetscBool quiet;          /* all were slow since the last event */
  PetscReal last_log, last; /* ln of the largest rate, and when [s] */
} Watch;

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Watch *watch = (Watch *)ctx;
  CycleResult *r = watch->result;
  const PetscReal bound = PetscLogReal(EVENT_RATE);
  const PetscReal *a;
  PetscReal most = 0, now;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(w, &n));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < n; i += 3) most = PetscMax(most, PetscAbsReal(a[i]));
  PetscCall(VecRestoreArrayRead(w, &a));
  now = PetscLogReal(PetscMax(most, 1e-30));
  if (most < QUIET_RATE) watch->quiet = PETSC_TRUE;
  if (step > 0 && watch->quiet && now > bound && watch->last_log <= bound) {
    watch->quiet = PETSC_FALSE;
    if (r->events <= CYCLE_EVENTS)
      r->onset[r->events] = watch->last + (t - watch->last) * (bound - watch->last_log) / (now - watch->last_log);
    if (++r->events >= watch->most) PetscCall(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  }
  watch->last_log = now;
  watch->last = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* most: events after which it ends; end [s], steps: so does it there */
static PetscErrorCode Integrate(SlipFault fault, SlipPolicy policy, PetscReal accuracy, PetscReal rtol, PetscInt most,
                                PetscReal end, PetscInt steps, CycleResult *r)
{
  Watch watch = {.result = r, .most = most, .quiet = PETSC_TRUE};
  Vec w;
  TS ts;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(SlipFaultSetInitialState(fault, w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &ts));
  PetscCall(SlipFaultConfigureTS(fault, ts));
  PetscCall(TSSetType(ts, TSADAMS));
  PetscCall(RunSetController(ts, policy, accuracy, TSADAPTBASIC, rtol));
  PetscCall(TSSetMaxTime(ts, end));
  PetscCall(TSSetMaxSteps(ts, steps));
  PetscCall(TSSetErrorIfStepFails(ts, PETSC_FALSE));
  PetscCall(TSMonitorSet(ts, Follow, &watch, NULL));
  PetscCall(RunSolve(ts, w, &r->good));
  PetscCall(TSGetStepNumber(ts, &r->steps));
  PetscCall(TSGetStepRejections(ts, &r->rejected));
  r->products = 2 * r->steps + r->rejected;
  PetscCall(TSDestroy(&ts));
  PetscCall(VecDestroy(&w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CycleEpisodeRun(CycleEpisode *e, SlipPolicy policy, PetscReal accuracy, PetscReal rtol, CycleResult *r)
{
  const PetscReal recurrence = e->onset[CYCLE_EVENTS - 1] - e->onset[CYCLE_EVENTS - 2];

  PetscFunctionBegin;
  PetscCall(Integrate(e->fault, policy, accuracy, rtol, CYCLE_EVENTS + 1, e->end, e->products, r));
  if (r->events != CYCLE_EVENTS) r->good = PETSC_FALSE;
  for (PetscInt i = 1; i < CYCLE_EVENTS && r->good; i++)
    r->error += PetscSqr((r->onset[i] - e->onset[i]) / recurrence * CYCLE_JUDGED / (i + 1)) / (CYCLE_EVENTS - 1);
  r->error = PetscSqrtReal(r->error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

double CycleCost(const CycleEpisode *e, const CycleResult *r, PetscReal accuracy)
{
  if (!r->good) return LOST;
  return log((double)r->products / (double)e->usual) +
         log(PetscClipInterval((double)(r->error / accuracy), 1.0, (double)WORST_ERROR));
}

/* ---- an episode ---- */

/* Its reference has events that are no farther apart than twice, and is found again with the usual tolerance. */
static PetscErrorCode Judge(CycleEpisode *e, PetscBool *good)
{
  CycleResult r;
  PetscReal recurrence, first;

  PetscFunctionBegin;
  *good = PETSC_FALSE;
  PetscCall(Integrate(e->fault, NULL, 0, USUAL_RTOL, CYCLE_EVENTS, PETSC_MAX_REAL, MOST_STEPS / 3, &r));
  if (!r.good || r.events < CYCLE_EVENTS) PetscFunctionReturn(PETSC_SUCCESS);
  recurrence = r.onset[CYCLE_EVENTS - 1] - r.onset[CYCLE_EVENTS - 2];
  first = r.onset[1] - r.onset[0];
  if (recurrence > 2 * first || first > 2 * recurrence) PetscFunctionReturn(PETSC_SUCCESS);
  e->end = r.onset[CYCLE_EVENTS - 1] + END_AFTER * recurrence;
  PetscCall(Integrate(e->fault, NULL, 0, REFERENCE_RTOL, CYCLE_EVENTS + 1, e->end, MOST_STEPS, &r));
  if (!r.good || r.events != CYCLE_EVENTS) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArraycpy(e->onset, r.onset, CYCLE_EVENTS));
  e->products = r.products;
  PetscCall(CycleEpisodeRun(e, NULL, 0, USUAL_RTOL, &r));
  e->usual = r.products;
  *good = r.good;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CycleEpisodeCreate(uint64_t seed, CycleEpisode *e)
{
  PetscBool good = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  while (!good) {
    Draw d;

    PetscCall(PetscMemzero(e, sizeof(*e)));
    DrawFault(&random, &d);
    PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &e->fault));
    PetscCall(SetNumbers(&d, e->fault));
    PetscCall(SetFields(&d, e->fault));
    PetscCall(SlipFaultSetUp(e->fault));
    PetscCall(Judge(e, &good));
    if (!good) PetscCall(SlipFaultDestroy(&e->fault));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CycleEpisodeDestroy(CycleEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
