/* Writes /steps: a row for each attempt of an integrator. TSBATHE reports its attempts. With others the controller has
   them, and differences of counts give their costs; their rows are written at the end of a step, as it may still change
   after the controller has accepted it. */
#include <slipstep/private/sliprunoutput.h>
#include <slipstep/private/slipadapt.h>
#include <slipstep/private/slipsys.h>
#include <slipcompat.h>
#include <slipstep/rooms/slipsys.h>
#include <petsctime.h>

/* Adds the row of an attempt. Collective. */
static PetscErrorCode Add(SlipOutput out, const SlipAttempt *attempt, PetscInt sides)
{
  const PetscReal row[] = {attempt->time,
                           attempt->dt,
                           attempt->accepted,
                           attempt->error,
                           attempt->converged,
                           (PetscReal)attempt->newton,
                           (PetscReal)attempt->linear,
                           (PetscReal)attempt->solves,
                           (PetscReal)attempt->method,
                           (PetscReal)sides,
                           (PetscReal)attempt->products.k,
                           (PetscReal)attempt->products.h,
                           (PetscReal)attempt->products.pc,
                           attempt->products.cost,
                           attempt->residual,
                           (PetscReal)attempt->reason,
                           attempt->wall};
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(out));
  if (!out->rank) ierr = SlipOutputRow(out, &out->steps, row);
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(out->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- TSBATHE ---- */

static PetscErrorCode SlipOutputAttemptMonitor(TS ts, const SlipAttempt *attempt, Vec w, void *ctx)
{
  SlipOutput out;

  PetscFunctionBegin;
  (void)w, (void)ctx;
  PetscCall(SlipObjectQueryData((PetscObject)ts, SLIP_OUTPUT_KEY, &out));
  if (!out || !out->wanted || out->closed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Add(out, attempt, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipOutputAttemptsStart(TS ts)
{
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(ts, &bathe));
  if (bathe) PetscCall(TSBatheMonitorSet(ts, SlipOutputAttemptMonitor, NULL, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- other integrators ---- */

/* Computes right-hand sides, iterations and time since the last row; right-hand sides that are not counted are -1. */
static PetscErrorCode Spend(SlipOutput out, SlipAttempt *attempt, PetscInt *spent)
{
  SlipOutputAttempts *a = &out->attempts;
  PetscInt newton, linear, sides = -1;
  PetscLogDouble now;

  PetscFunctionBegin;
  PetscCall(TSGetSNESIterations(out->ts, &newton));
  PetscCall(TSGetKSPIterations(out->ts, &linear));
  if (out->sides) PetscCall((*out->sides)(out->ctx, &sides));
  PetscCall(PetscTime(&now));
  attempt->newton = newton - a->newton;
  attempt->linear = linear - a->linear;
  attempt->wall = (PetscReal)(now - a->begin);
  *spent = out->sides ? sides - a->sides : -1;
  if (out->started)
    attempt->products = SlipProductsRow(&a->cost);
  else
    (void)SlipProductsRow(&a->cost);
  a->newton = newton;
  a->linear = linear;
  a->sides = sides;
  a->begin = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Attempted(TS ts, const SlipAttempt *attempt)
{
  SlipOutputAttempts *a;
  SlipOutput out;
  PetscInt sides;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)ts, SLIP_OUTPUT_KEY, &out));
  if (!out || !out->wanted || out->closed) PetscFunctionReturn(PETSC_SUCCESS);
  a = &out->attempts;
  a->last = *attempt;
  a->judged = attempt->accepted;
  if (attempt->accepted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Spend(out, &a->last, &sides));
  PetscCall(Add(out, &a->last, sides));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a row when a step ends; begins when TSSolve() does. Without a controller only steps have rows. Collective. */
PetscErrorCode SlipOutputAttemptsStep(SlipOutput out, PetscInt step, PetscReal time)
{
  SlipOutputAttempts *a = &out->attempts;
  const PetscReal start = a->time + (a->origin - out->clock->origin);
  PetscBool bathe;
  PetscInt sides;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(out->ts, &bathe));
  if (bathe) PetscFunctionReturn(PETSC_SUCCESS);
  if (!out->started)
    PetscCall(Spend(out, &a->last, &sides));
  else if (step != out->last_step) {
    if (!a->judged)
      a->last =
        (SlipAttempt){.time = start, .dt = time - start, .converged = PETSC_TRUE, .accepted = PETSC_TRUE, .error = -1};
    PetscCall(Spend(out, &a->last, &sides));
    PetscCall(Add(out, &a->last, sides));
  }
  a->judged = PETSC_FALSE;
  a->time = time;
  a->origin = out->clock->origin;
  PetscCall(SlipAdaptWatch(out->ts, Attempted));
  PetscFunctionReturn(PETSC_SUCCESS);
}
