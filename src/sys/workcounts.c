/* The cost of a run: products with K, H and stage operators, and processor time by kinds of work, which are counted
   where they occur, each at a fixed price. The same run has exactly the same cost, whatever else the machine does.
   Counts are those of this process; operators are collective, so that all processes count the same products.
   tests/benchmarks/cost.py measures the prices. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime() */
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>
#include <time.h>
#include "workprices.h"

/* The users for whom products are counted; the last one is the present user. */
#define USERS_MOST 32
static SlipProducts counts[SLIP_PRODUCTS_USERS];
static SlipProductsUser users[USERS_MOST];
static PetscInt last;

const char *const SlipShareNames[] = {"set-up", "products", "direct solves", "cells", "observation", "output"};

/* Costs are multiples of this [s], so that sums and differences have no rounding: attempts add up to the run, and a
   continued run costs the same as an unbroken one. */
#define QUANTUM (1.0 / (1 << 30))

#define WORK_NAME(name, share) #name,
const char *const SlipWorkNames[] = {SLIP_WORK_LIST(WORK_NAME)};

#define SHARE_OF(name, share) SLIP_SHARE_##share,
static const SlipShare ShareOf[] = {SLIP_WORK_LIST(SHARE_OF)};

static SlipWorkTotals totals;
static PetscLogDouble flops_seen, flops_ours; /* flops in PETSc's log: at the last call, and those since then that
                                                 belong to a kind of work */

/* Shares that have begun, nested */
#define DEPTH_MOST 16
static SlipShare begun[DEPTH_MOST];
static PetscInt depth;
static PetscBool preparing = PETSC_TRUE, paused; /* between runs; during a checkpoint */

static PetscBool measured;
static PetscReal clock_seen;

PetscReal SlipProcessorTime(void)
{
  struct timespec t;

  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (PetscReal)t.tv_sec + (PetscReal)1e-9 * (PetscReal)t.tv_nsec;
}

/* The share of work during a run */
static SlipShare ShareNow(SlipShare in_run)
{
  const SlipProductsUser user = users[last];

  return user == SLIP_PRODUCTS_SETUP || preparing ? SLIP_SHARE_SETUP
         : user == SLIP_PRODUCTS_LOOK             ? SLIP_SHARE_OUTPUT
                                                  : in_run;
}

/* Work on files and other parts of set-up or output never belongs to an attempt, even if it occurs during one, because
   a run that continues from a checkpoint reads other files. */
static SlipProductsUser UserOf(SlipShare share)
{
  const SlipProductsUser now = users[last];

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
  counts[UserOf(ShareOf[work])].cost += cost;
}

void SlipWorkCells(PetscInt n, PetscInt components, PetscBool always_slides)
{
  SlipWorkAdd(SLIP_WORK_EVALUATION, 1);
  SlipWorkAdd(always_slides ? SLIP_WORK_BALANCE : SLIP_WORK_STRENGTH, (PetscReal)(n * components));
}

void SlipWorkLogged(SlipWork work, PetscLogDouble flops)
{
  flops_ours += flops;
  SlipWorkAdd(work, (PetscReal)flops);
}

/* Rounds to integers, whose sums are exact. */
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

void SlipWorkSkip(void)
{
  (void)PetscGetFlops(&flops_seen);
  flops_ours = 0;
}

void SlipWorkBegin(SlipShare share)
{
  if (measured) TakeTime();
  if (depth < DEPTH_MOST) begun[depth] = share;
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

/* ---- products, and for whom they are made ---- */

SlipProducts SlipProductsRow(SlipProducts *last_row)
{
  const SlipProducts before = *last_row;

  SlipWorkTake();
  *last_row = counts[SLIP_PRODUCTS_RUN];
  return SlipProductsSince(last_row, &before);
}

/* Counts products that are computed outside of MatMult(), or several in one. */
void SlipProductsAdd(SlipProducts more)
{
  SlipProducts *c = &counts[users[last]];

  *c = (SlipProducts){c->k + more.k, c->h + more.h, c->pc + more.pc, c->all + more.all, c->cost};
}

SlipProducts SlipProductsNow(void)
{
  return counts[users[last]];
}

SlipProducts SlipProductsSince(const SlipProducts *now, const SlipProducts *before)
{
  return (SlipProducts){now->k - before->k, now->h - before->h, now->pc - before->pc, now->all - before->all,
                        now->cost - before->cost};
}

/* Counts the following products for this user, until it is popped. */
PetscErrorCode SlipProductsPush(SlipProductsUser user)
{
  PetscFunctionBegin;
  PetscCheck(last + 1 < USERS_MOST, PETSC_COMM_SELF, PETSC_ERR_PLIB, "products are made for %d users at once",
             USERS_MOST);
  SlipWorkTake();
  users[++last] = user;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipProductsPop(void)
{
  PetscFunctionBegin;
  PetscCheck(last > 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "products are made for nobody else");
  SlipWorkTake();
  last--;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Resets the state at the beginning or end of a run, whatever an error has left. */
void SlipProductsRun(void)
{
  SlipWorkTake();
  last = 0;
  SlipWorkReset();
}

void SlipProductsGetOf(SlipProductsUser of, SlipProducts *products)
{
  SlipWorkTake();
  *products = counts[of];
}

/*@
  SlipProductsGet - gets the products with stiffness and viscosity of this process so far

  Not collective

  Output Parameter:
. products - those with K and H and applications of the preconditioner, except those of set-up, output and estimates;
             differences are the cost of an operation

  Level: advanced

  Notes:
  `k` counts products with K or Kn, including those inside of products with H; `h` counts products with a viscosity that
  is no multiple of the identity. A stage operator that computes both at once counts in both. `pc` counts applications
  of PCSLIPSTAGE by transforms, which cost about as much. `all` counts products with K, and those with H that do not
  consist of them; a product with both at once counts once. Solves with the rows of a few cells count none. A call of
  the force of a user's own medium counts as one product with K unless it multiplies by matrices of slipmat.h.

  `cost` is the processor time [s] of all work without set-up, output and estimates: each kind of work is counted, at a
  fixed price. The same run has exactly the same cost on any machine, whatever else that does. On a device it is the
  time that the processor would have taken for the same products.

.seealso: SlipAttempt, TSBatheGetLastAttempt()
@*/
PetscErrorCode SlipProductsGet(SlipProducts *products)
{
  PetscFunctionBegin;
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, products);
  PetscFunctionReturn(PETSC_SUCCESS);
}
