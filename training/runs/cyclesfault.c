/* Runs of small faults with cycles of events under a controller, explicit. */
#include "cycles.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>

#define REFERENCE_RTOL 1e-7
#define USUAL_RTOL 1e-3
#define EVENT_RATE 1e-3  /* an event begins when the fastest cell passes it [m/s] */
#define QUIET_RATE 1e-5  /* and another one only after all were slower [m/s] */
#define END_AFTER 0.3    /* of the recurrence after the last event, in which none may follow */
#define MOST_STEPS 30000 /* of a reference */

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
    PetscCall(PetscMemzero(e, sizeof(*e)));
    PetscCall(CycleFaultDraw(&random, &e->fault, NULL, NULL));
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
