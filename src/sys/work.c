/* What a run costs: processor time by kinds of work, which are counted where they are done, each at a fixed price. The
   same run costs the same to the bit, whatever else the machine does. tests/benchmarks/cost.py finds the prices. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime() */
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>
#include <time.h>
#include "workprices.h"

const char *const SlipShareNames[] = {"set-up", "products", "direct solves", "cells", "observation", "output"};

/* Costs are multiples of this [s], of which sums and differences have no rounding: attempts add up to the run, and a
   run that goes on costs what it would have cost at once. */
#define QUANTUM (1.0 / (1 << 30))

#define WORK_NAME(name, share) #name,
const char *const SlipWorkNames[] = {SLIP_WORK_LIST(WORK_NAME)};

#define SHARE_OF(name, part) SLIP_SHARE_##part,
static const SlipShare ShareOf[] = {SLIP_WORK_LIST(SHARE_OF)};

static SlipWorkTotals totals;
static PetscLogDouble flops_seen, flops_ours; /* of PETSc's log: at the last look, and those since that have a kind */

/* Parts that are begun, one inside of the other */
#define DEPTH_MOST 16
static SlipShare begun[DEPTH_MOST];
static PetscInt depth;
static PetscBool preparing = PETSC_TRUE, paused; /* between runs; for a checkpoint */

static PetscBool measured;
static PetscReal clock_seen;

PetscReal SlipProcessorTime(void)
{
  struct timespec t;

  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (PetscReal)t.tv_sec + (PetscReal)1e-9 * (PetscReal)t.tv_nsec;
}

/* In a run what is done is of this share. */
static SlipShare ShareNow(SlipShare in_run)
{
  const SlipProductsUser user = SlipProductsUserNow();

  return user == SLIP_PRODUCTS_SETUP || preparing ? SLIP_SHARE_SETUP
         : user == SLIP_PRODUCTS_LOOK             ? SLIP_SHARE_OUTPUT
                                                  : in_run;
}

/* Files and what else belongs to set-up or output is no attempt's, also where it is met on the way: a run that goes on
   from a checkpoint reads others. */
static SlipProductsUser UserOf(SlipShare share)
{
  const SlipProductsUser now = SlipProductsUserNow();

  if (now != SLIP_PRODUCTS_RUN) return now;
  return share == SLIP_SHARE_SETUP    ? SLIP_PRODUCTS_SETUP
         : share == SLIP_SHARE_OUTPUT ? SLIP_PRODUCTS_LOOK
                                      : SLIP_PRODUCTS_RUN;
}

void SlipWorkAdd(SlipWork work, PetscReal units)
{
  const SlipShare share = ShareNow(ShareOf[work]);
  const PetscReal cost = QUANTUM * PetscFloorReal(units * WorkPrices[work] / QUANTUM + (PetscReal)0.5);

  if (paused) return;
  totals.units[work][share] += units;
  totals.cost[share] += cost;
  SlipProductsAddFor(UserOf(ShareOf[work]), (SlipProducts){.cost = cost});
}

void SlipWorkCells(PetscInt n, PetscInt components)
{
  SlipWorkAdd(SLIP_WORK_EVALUATION, 1);
  SlipWorkAdd(SLIP_WORK_STRENGTH, (PetscReal)(n * components));
}

void SlipWorkLogged(SlipWork work, PetscLogDouble flops)
{
  flops_ours += flops;
  SlipWorkAdd(work, (PetscReal)flops);
}

/* Whole ones, as their sums have no rounding then. */
PetscErrorCode SlipWorkFlops(SlipWork work, PetscLogDouble flops)
{
  const PetscLogDouble whole = PetscFloorReal(flops);

  PetscFunctionBegin;
  PetscCall(PetscLogFlops(whole));
  SlipWorkLogged(work, whole);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void TakeTime(void)
{
  const PetscReal now = SlipProcessorTime();
  const PetscInt last = PetscMin(depth, DEPTH_MOST) - 1;

  totals.seconds[ShareNow(last < 0 ? SLIP_SHARE_CELLS : begun[last])] += now - clock_seen;
  clock_seen = now;
}

void SlipWorkTake(void)
{
  PetscLogDouble flops = 0;

  (void)PetscGetFlops(&flops);
  if (flops - flops_seen > flops_ours) SlipWorkAdd(SLIP_WORK_VECTOR, (PetscReal)(flops - flops_seen - flops_ours));
  flops_seen = flops;
  flops_ours = 0;
  if (measured) TakeTime();
}

void SlipWorkBegin(SlipShare part)
{
  if (measured) TakeTime();
  if (depth < DEPTH_MOST) begun[depth] = part;
  depth++;
}

void SlipWorkEnd(void)
{
  if (measured) TakeTime();
  if (depth > 0) depth--;
}

void SlipWorkPrepare(void)
{
  SlipWorkTake();
  preparing = PETSC_TRUE;
}

void SlipWorkPause(PetscBool pause)
{
  SlipWorkTake();
  paused = pause;
}

void SlipWorkReset(void)
{
  preparing = paused = PETSC_FALSE;
  depth = 0;
}

void SlipWorkMeasure(void)
{
  if (measured) return;
  measured = PETSC_TRUE;
  clock_seen = SlipProcessorTime();
  totals.seconds[SLIP_SHARE_SETUP] += clock_seen;
}

SlipWorkTotals SlipWorkGet(void)
{
  SlipWorkTake();
  return totals;
}
