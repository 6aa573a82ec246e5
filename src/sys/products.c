/* What a run costs: how many products with K, H and stage operators there were, and what they take.

   Counts are plain integers of this process; operators are collective, so that all processes count the same. A kind of
   work costs what some of its calls did, measured where they happen, with what lies in the caches then: that tells the
   processor time without reading a clock twice in every product, of which a small one takes a few microseconds. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime() */
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <time.h>

/* For whom they are made, the last of users now */
#define USERS_MOST 32
static SlipProducts counts[SLIP_PRODUCTS_USERS];
static SlipProductsUser users[USERS_MOST];
static PetscInt last;

/* Processor time of each user, when the last one took over, and what their work costs by meters [s] */
static PetscReal taken[SLIP_PRODUCTS_USERS], begun, metered[SLIP_PRODUCTS_USERS];

/* Meters that run now, one inside of the other */
#define METERS_MOST 16
static struct {
  PetscBool timed;
  PetscReal begin, inner; /* [s] */
} meter[METERS_MOST];
static PetscInt running;

/* Processor time of this process, of all its threads [s] */
static PetscReal Clock(void)
{
  struct timespec t;

  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (PetscReal)t.tv_sec + (PetscReal)1e-9 * (PetscReal)t.tv_nsec;
}

/* The time since the last change of users is that of the last one */
static void TakeTime(void)
{
  const PetscReal now = Clock();

  taken[users[last]] += now - begun;
  begun = now;
}

/* Of calls one after the other those that are measured: all at first, but for the very first, which prepares what
   others find; then one in 16 by a hash, so that no rhythm of the work is met again and again */
static PetscBool IsSample(PetscInt64 call)
{
  return call > 1 && (call < 10 || ((uint32_t)call * UINT32_C(2654435761)) >> 28 == 0) ? PETSC_TRUE : PETSC_FALSE;
}

void SlipMeterBegin(SlipMeter *m)
{
  PetscBool timed;

  m->calls++;
  if (running >= METERS_MOST) running = 0; /* an error has left them */
  timed = IsSample(m->calls) || (running > 0 && meter[running - 1].timed) ? PETSC_TRUE : PETSC_FALSE;
  meter[running].timed = timed;
  meter[running].inner = 0;
  meter[running++].begin = timed ? Clock() : 0;
}

/* units: how much work it was; that of meters inside is not its own */
void SlipMeterEnd(SlipMeter *m, PetscReal units)
{
  if (running > 0 && meter[--running].timed) {
    const PetscReal all = Clock() - meter[running].begin;

    m->seconds += all - meter[running].inner;
    m->units += units;
    if (running > 0) meter[running - 1].inner += all;
  }
  if (m->units > 0) metered[users[last]] += units * m->seconds / m->units;
}

void SlipCostStart(SlipCost *c)
{
  TakeTime();
  c->last = counts[SLIP_PRODUCTS_RUN];
  c->taken = taken[SLIP_PRODUCTS_RUN];
  c->metered = metered[SLIP_PRODUCTS_RUN];
}

/* Of the run since the last row, or since SlipCostStart(). units: how much there was to do beside what meters see, at
   the price of some rows. The first row also prepares what others find, and costs what it took. */
void SlipCostRow(SlipCost *c, PetscReal units, SlipProducts *since)
{
  const SlipProducts before = c->last;
  const PetscReal before_taken = c->taken, before_metered = c->metered;

  SlipCostStart(c);
  *since = SlipProductsSince(&c->last, &before);
  since->time = c->taken - before_taken;
  c->rows++;
  if (IsSample(c->rows)) {
    c->seconds += since->time - (c->metered - before_metered);
    c->units += units;
  }
  since->cost = c->metered - before_metered + (c->units > 0 ? units * PetscMax(c->seconds, 0) / c->units : 0);
  if (c->rows == 1) since->cost = since->time;
  counts[SLIP_PRODUCTS_RUN].cost += since->cost;
  counts[SLIP_PRODUCTS_RUN].time += since->time;
  c->last = counts[SLIP_PRODUCTS_RUN];
}

/* Formed beside MatMult(), or inside of it as one */
void SlipProductsAdd(SlipProducts more)
{
  SlipProducts *c = &counts[users[last]];

  *c = (SlipProducts){c->k + more.k, c->h + more.h, c->pc + more.pc, c->all + more.all, c->cost, c->time};
}

SlipProducts SlipProductsNow(void)
{
  return counts[users[last]];
}

SlipProducts SlipProductsSince(const SlipProducts *now, const SlipProducts *before)
{
  return (SlipProducts){now->k - before->k,     now->h - before->h,       now->pc - before->pc,
                        now->all - before->all, now->cost - before->cost, now->time - before->time};
}

/* Those that follow are made for this user, until it is popped. */
PetscErrorCode SlipProductsPush(SlipProductsUser user)
{
  PetscFunctionBegin;
  PetscCheck(last + 1 < USERS_MOST, PETSC_COMM_SELF, PETSC_ERR_PLIB, "products are made for %d users at once",
             USERS_MOST);
  TakeTime();
  users[++last] = user;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipProductsPop(void)
{
  PetscFunctionBegin;
  PetscCheck(last > 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "products are made for nobody else");
  TakeTime();
  last--;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A run begins, or nothing does, whatever an error has left. */
void SlipProductsRun(void)
{
  TakeTime();
  last = running = 0;
}

void SlipProductsGetOf(SlipProductsUser of, SlipProducts *products)
{
  *products = counts[of];
}

/*@
  SlipProductsGet - products with stiffness and viscosity of this process so far

  Not collective

  Output Parameter:
. products - those with K and H and applications of the preconditioner, but for those of set-up and of output and
             estimates; differences say what something took

  Level: advanced

  Notes:
  `k` are those with K or Kn, those that products with H are made of included, `h` those with a viscosity that is no
  multiple of the identity. A stage operator that forms both at once counts in both. `pc` are applications of
  PCSLIPSTAGE by transforms, which cost about as much. `all` are those with K, and those with H that are not made of
  them, a product with both at once counted once. Solves with the rows of a few cells have none. What a medium of your
  own does in a call of its force counts as one product with K unless it multiplies by matrices of slipmat.h.

  `time` is the processor time of this process for attempts of runs, without output and estimates, and `cost` what they
  cost by these products, factorisations of a few cells' rows and the rest of the work, each at the price of some that
  were measured. They are known after each attempt of TSBATHE, and after those of others that have an output.

.seealso: SlipAttempt, TSBatheGetLastAttempt()
@*/
PetscErrorCode SlipProductsGet(SlipProducts *products)
{
  PetscFunctionBegin;
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, products);
  PetscFunctionReturn(PETSC_SUCCESS);
}
