/* Who watches a run: rows of one table, ours and those of users, which are created, started, told of each accepted step, visited for
   checkpoints, finished and destroyed in its order. */
#include <slipstep/private/slipfaultobservers.h>
#include <stdlib.h>
#include <string.h>

/* Ours. A new one is a file with its row, and its name here. */
#define OBSERVERS(ROW) ROW(Stations)

#define DECLARE(name) extern const SlipFaultObserver SlipFault##name;
#define LIST(name) &SlipFault##name,
OBSERVERS(DECLARE)
static const SlipFaultObserver *const Observers[] = {OBSERVERS(LIST)};
enum { NUM_OBSERVERS = PETSC_STATIC_ARRAY_LENGTH(Observers) };

/* Those of users, until the process ends */
#define OBSERVERS_REGISTERED 32
static SlipFaultObserver registered[OBSERVERS_REGISTERED];
static PetscInt nregistered = 0;

/* An observer in a run */
struct _n_SlipFaultWatch {
  const SlipFaultObserver *row;
  void *ctx;
};

static const SlipFaultObserver *ObserverAt(PetscInt i)
{
  return i < NUM_OBSERVERS ? Observers[i] : &registered[i - NUM_OBSERVERS];
}

/*@C
  SlipFaultRegisterObserver - have runs of faults watched

  Not collective, on every process; before SlipFaultOutputStart()

  Input Parameter:
. observer - its name; functions, each of which may be NULL, in the order in which they are called; and a context. Copied; the name
             and what the context points to stay the caller's

  Level: advanced

  Notes:
  All functions are collective and called for every fault whose SlipFaultOutputStart() is.
.vb
  create(fault, ts, &wanted, &ctx)    the run is set up: ctx is that of the row, or what is put there; wanted PETSC_FALSE: no more of it
  layout(fault, output, ctx)          -fault_output is made: SlipOutputAddTable() for datasets of its own
  start(fault, ts, time, w, ctx)      TSSolve() begins with the state w, also in a run that goes on from a checkpoint
  step(fault, ts, step, time, w, ctx) an accepted step has ended: SlipOutputAddRows() for its tables, before the row of /series
  visit(fault, state, ctx)            a checkpoint is written or read: SlipStateReal() and others for all that it remembers
  finish(fault, ts, output, ctx)      the run has ended: SlipOutputAddResult() for the summary
  destroy(&ctx)                       of a run that has ended or failed
.ve
  In a checkpoint it has a group of its own, observer_NAME; one without it, of a run without this observer, is not visited.
  With `repeats` it sees the repetition of -fault_check_error as well, from start on, after the other ones have finished.

  Errors: PETSC_ERR_ARG_WRONG without a name of at most 40 characters, or for one that is taken

.seealso: SlipFaultOutputStart(), SlipFaultOutputFinish(), SlipOutputAddTable(), SlipStateReal()
@*/
PetscErrorCode SlipFaultRegisterObserver(const SlipFaultObserver *observer)
{
  PetscBool same;

  PetscFunctionBegin;
  PetscAssertPointer(observer, 1);
  PetscCheck(observer->name && observer->name[0] && strlen(observer->name) <= 40, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "An observer needs a name of at most 40 characters");
  for (PetscInt i = 0; i < NUM_OBSERVERS + nregistered; i++) {
    PetscCall(PetscStrcmp(ObserverAt(i)->name, observer->name, &same));
    PetscCheck(!same, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "There is an observer %s already", observer->name);
  }
  PetscCheck(nregistered < OBSERVERS_REGISTERED, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The observer %s would be one of more than %d", observer->name, OBSERVERS_REGISTERED);
  registered[nregistered++] = *observer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSMonitor: what TSSolve() starts from, or the end of a step */
static PetscErrorCode SlipFaultObserversMonitor(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultRun *run = &fault->run;
  const PetscBool first = !run->started;

  PetscFunctionBegin;
  if (step < 0 || !run->nwatch || (!first && step == run->step)) PetscFunctionReturn(PETSC_SUCCESS);
  if (first && run->file) PetscCall(SlipOutputBegin(run->file));
  run->started = PETSC_TRUE;
  run->step = step;
  for (PetscInt i = 0; i < run->nwatch; i++) {
    const SlipFaultObserver *row = run->watch[i].row;

    if (run->error.off && !row->repeats) continue;
    if (first && row->start) PetscCall((*row->start)(fault, ts, time, w, run->watch[i].ctx));
    if (!first && row->step) PetscCall((*row->step)(fault, ts, step, time, w, run->watch[i].ctx));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultObserversCreate(SlipFault fault, TS ts)
{
  SlipFaultRun *run = &fault->run;

  PetscFunctionBegin;
  PetscCall(SlipFaultObserversDestroy(fault));
  PetscCall(PetscCalloc1(NUM_OBSERVERS + nregistered, &run->watch));
  for (PetscInt i = 0; i < NUM_OBSERVERS + nregistered; i++) {
    const SlipFaultObserver *row = ObserverAt(i);
    PetscBool wanted = PETSC_TRUE;

    run->watch[run->nwatch] = (struct _n_SlipFaultWatch){row, row->ctx};
    if (row->create) PetscCall((*row->create)(fault, ts, &wanted, &run->watch[run->nwatch].ctx));
    if (wanted) run->nwatch++;
  }
  PetscCall(TSMonitorSet(ts, SlipFaultObserversMonitor, fault, NULL)); /* PETSc does not add the same monitor twice */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultObserversLayout(SlipFault fault, SlipOutput output)
{
  SlipFaultRun *run = &fault->run;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < run->nwatch; i++)
    if (run->watch[i].row->layout) PetscCall((*run->watch[i].row->layout)(fault, output, run->watch[i].ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Our observers have the groups that they have always had, and share some. */
PetscErrorCode SlipFaultObserversVisit(SlipFault fault, SlipState s)
{
  SlipFaultRun *run = &fault->run;
  char group[64];
  PetscBool has = PETSC_TRUE;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < run->nwatch; i++) {
    const SlipFaultObserver *row = run->watch[i].row;
    const PetscBool own = row >= registered && row < registered + nregistered ? PETSC_TRUE : PETSC_FALSE;

    if (!row->visit) continue;
    if (own) {
      PetscCall(PetscSNPrintf(group, sizeof(group), "observer_%s", row->name));
      PetscCall(SlipStateHas(s, group, &has));
      if (!has) continue;
      PetscCall(SlipStateGroup(s, group));
    }
    PetscCall((*row->visit)(fault, s, run->watch[i].ctx));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultObserversFinish(SlipFault fault, TS ts, SlipOutput output)
{
  SlipFaultRun *run = &fault->run;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < run->nwatch; i++)
    if (run->watch[i].row->finish) PetscCall((*run->watch[i].row->finish)(fault, ts, output, run->watch[i].ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultObserversDestroy(SlipFault fault)
{
  SlipFaultRun *run = &fault->run;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < run->nwatch; i++)
    if (run->watch[i].row->destroy) PetscCall((*run->watch[i].row->destroy)(&run->watch[i].ctx));
  PetscCall(PetscFree(run->watch));
  run->nwatch = 0;
  run->started = PETSC_FALSE;
  run->file = NULL;
  PetscCall(SlipFaultStepValuesDestroy(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
