/* Calls the observers of a run, built-in ones and users', which are rows of one table and share the run's file. In its
   order they are created, started, called for each step, visited for checkpoints, finished and destroyed. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipts.h>
#include <stdlib.h>
#include <string.h>
#include <slipstep/private/slipwork.h>

/* The built-in observers. A new one is a file with its row, and its name here. */
extern const SlipFaultObserver SlipFaultProgressObserver, SlipFaultOutputObserver, SlipFaultXdmfObserver,
  SlipFaultStationsObserver, SlipFaultSurfaceObserver, SlipFaultCatalogueObserver, SlipFaultCouplingObserver,
  SlipFaultFluidObserver, SlipFaultEstimateObserver;
static const SlipFaultObserver *const Observers[] = {
  &SlipFaultProgressObserver, &SlipFaultOutputObserver,  &SlipFaultXdmfObserver,
  &SlipFaultStationsObserver, &SlipFaultSurfaceObserver, &SlipFaultCatalogueObserver,
  &SlipFaultCouplingObserver, &SlipFaultFluidObserver,   &SlipFaultEstimateObserver};
enum { NUM_OBSERVERS = PETSC_STATIC_ARRAY_LENGTH(Observers) };

/* Observers of users, until the process ends */
#define OBSERVERS_REGISTERED 32
static SlipFaultObserver registered[OBSERVERS_REGISTERED];
static PetscInt nregistered = 0;

/* An observer in a run */
struct _n_SlipFaultWatch {
  const SlipFaultObserver *row;
  void *ctx;
};

/* The last built-in observer is the last of all: at its end the estimate of errors may repeat the run. */
static const SlipFaultObserver *ObserverAt(PetscInt i)
{
  const PetscInt first = NUM_OBSERVERS - 1;

  return i < first ? Observers[i] : i < first + nregistered ? &registered[i - first] : Observers[first];
}

/*@C
  SlipFaultRegisterObserver - adds an observer to all runs of faults

  Not collective, on every process; before SlipFaultOutputStart()

  Input Parameter:
. observer - its name; functions, each of which may be NULL, in the order in which they are called; and a context.
             Copied; the name and what the context points to stay the caller's

  Level: advanced

  Notes:
  All functions are collective and called for every fault whose SlipFaultOutputStart() is called.
.vb
  create(fault, ts, &wanted, &ctx)    the run is set up: ctx is that of the row, or what the function sets; wanted
                                      PETSC_FALSE: there are no more calls
  layout(fault, output, ctx)          -fault_output is created: SlipOutputAddTable() for datasets of its own
  start(fault, ts, time, w, ctx)      TSSolve() begins with the state w, also in a run that continues from a checkpoint:
                                      SlipOutputAddRows() for the row of the start
  step(fault, ts, step, time, w, ctx) an accepted step has ended: SlipOutputAddRows() for its tables, before the row of
                                      /series
  visit(fault, state, ctx)            a checkpoint is written or read: SlipStateReal() and others for all data of the
                                      observer that must survive
  finish(fault, ts, output, ctx)      the run has ended: SlipOutputAddResult() for the summary
  destroy(&ctx)                       the run has ended or failed
.ve
  The observer has a group of its own in a checkpoint, observer_NAME. It is not visited for a checkpoint without that
  group, from a run without this observer. With `repeats` it is also called in the repetition of -fault_check_error,
  from start on, after the other ones have finished.

  Errors: PETSC_ERR_ARG_WRONG without a name of at most 40 characters, or for a name in use

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

/* TSMonitor: called for the state that TSSolve() starts from, and for the end of each step. */
static PetscErrorCode SlipFaultObserversMonitor(TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultRun *run = fault->run;
  const PetscBool first = !run->started;

  PetscFunctionBegin;
  if (step < 0 || !run->nwatch || (!first && step == run->step)) PetscFunctionReturn(PETSC_SUCCESS);
  if (first && run->file) PetscCall(SlipOutputBegin(run->file));
  run->started = PETSC_TRUE;
  run->step = step;
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_LOOK));
  for (PetscInt i = 0; i < run->nwatch; i++) {
    const SlipFaultObserver *row = run->watch[i].row;

    if (run->error.off && !row->repeats) continue;
    if (first && row->start) PetscCall((*row->start)(fault, ts, time, w, run->watch[i].ctx));
    if (!first && row->step) PetscCall((*row->step)(fault, ts, step, time, w, run->watch[i].ctx));
  }
  PetscCall(SlipProductsPop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to the run's file what it has besides /run, /steps and /series. */
static PetscErrorCode SlipFaultObserversLayout(SlipOutput output, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const SlipFaultRun *run = fault->run;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < run->nwatch; i++)
    if (run->watch[i].row->layout) PetscCall((*run->watch[i].row->layout)(fault, output, run->watch[i].ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits the observers for a checkpoint. Built-in ones have the groups of earlier versions, and share some. */
PetscErrorCode SlipFaultObserversVisit(SlipFault fault, SlipState s)
{
  SlipFaultRun *run = fault->run;
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

/* Destroys the observers at the end of a run, or of one that failed or was stopped, whose files stay unfinished. */
PetscErrorCode SlipFaultObserversDestroy(SlipFault fault)
{
  SlipFaultRun *run = fault->run;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < run->nwatch; i++)
    if (run->watch[i].row->destroy) PetscCall((*run->watch[i].row->destroy)(&run->watch[i].ctx));
  PetscCall(PetscFree(run->watch));
  run->nwatch = 0;
  run->started = run->complete = PETSC_FALSE;
  PetscCall(SlipFaultStepValuesDestroy(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets the origin of a long run's time move (src/ts/clock.c), or warns why it cannot. Collective; before the observers,
   which store times. */
static PetscErrorCode SlipFaultClockStart(SlipFault fault, TS ts)
{
  const char *what = NULL;
  PetscReal end;
  PetscMPIInt rank;
  char limit[32], last[32];
  PetscBool known, history, rests;
  TSAdapt adapt;

  PetscFunctionBegin;
  fault->loads.origin = 0; /* an earlier run may have failed */
  /* what uses absolute times other than through ts, so that the origin cannot move; NULL: it can */
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, &known, TSBATHE, TSMOREAU, TSADAMS, TSRKC, TSRK, TSLAPUSTA, ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTHISTORY, &history));
  PetscCall(SlipElasticRests(fault->medium, &rests));
  what = fault->loads.pore                                     ? "a pore pressure, which is of absolute times"
         : SlipLoadsChange(&fault->loads)                      ? "stresses in time, which are of absolute times"
         : !rests                                              ? "a medium whose stress is of absolute times"
         : fault->options.check_error                          ? "-fault_check_error"
         : !known                                              ? "this -ts_type"
         : history || ts->event || ts->trajectory || ts->tspan ? "events, trajectories and given times of the TS"
                                                               : NULL;
  PetscCall(SlipClockStart(ts, what ? PETSC_FALSE : PETSC_TRUE));
  PetscCall(SlipClockRead(ts, NULL, &end));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!what || rank || !fault->options.reports || end <= SLIP_CLOCK_LIMIT || end >= PETSC_MAX_REAL)
    PetscFunctionReturn(PETSC_SUCCESS);
  SlipTimeText((PetscReal)SLIP_CLOCK_LIMIT, 4, limit, sizeof(limit));
  SlipTimeText(end, 4, last, sizeof(last));
  PetscCall(
    SlipWarning("time is one double in this run, as its origin cannot move with %s: at its end, %s, a step below "
                "%.2g s is lost, and ends it by an error. Expected an end before %s, or steps that stay longer",
                what, last, (double)(PETSC_MACHINE_EPSILON * end), limit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputStart - starts the observers of a run, built-in ones and those of SlipFaultRegisterObserver(). They
  write -fault_output and -fault_catalogue, estimate the error of slip and print the progress

  Collective; after TSSetFromOptions(), before TSSolve().

  Input Parameters:
+ fault - the fault
- ts    - the TS that it configured

  Options Database Keys:
+ -fault_output <F.h5>          - writes the run to this file
. -fault_output_size <1e8>      - limits the size of its fields where no other option sets their times [bytes]
. -fault_catalogue <F.h5>       - writes a row for each event to this file; each is also a line on standard output
. -fault_event_rate <1e-3>      - slip rate of a cell at which an event begins; it ends below a tenth everywhere [m/s]
- -fault_catalogue_maps <no>    - writes slip and rupture time of every cell as well

  Level: intermediate

  Errors: PETSC_ERR_FILE_OPEN when a file cannot be created, PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown field,
  PETSC_ERR_ARG_INCOMP for features that cannot be combined, see SlipFaultFeaturesView()

  Notes:
  The content goes to FILE.part, created at the start of TSSolve(), which SlipFaultOutputFinish() renames to FILE: a run
  that fails leaves an older FILE as it was. FILE.part can be read all the time, see SlipOutputCreate(). slipfault.h
  describes the layout.

.seealso: SlipFaultOutputFinish(), SlipFaultRegisterObserver(), SlipFaultCheckpointStart(), SlipFaultFeaturesView()
@*/
PetscErrorCode SlipFaultOutputStart(SlipFault fault, TS ts)
{
  SlipFaultRun *run = fault->run;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipFaultCheckFileNames(fault)); /* as SlipFaultSetString() may have set them */
  PetscCall(SlipFaultCheckFeatures(fault, ts));
  PetscCheck(!run->file && !run->catalogue, fault->comm, PETSC_ERR_ORDER,
             "the output of the last run was not finished");
  PetscCall(SlipFaultObserversDestroy(fault));
  fault->balance.sides = 0;
  SlipProductsRun();
  SlipFaultDeviceTraffic(run->traffic);
  run->prepared = -run->before[SLIP_PRODUCTS_RUN].cost;
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, &run->before[SLIP_PRODUCTS_RUN]);
  run->prepared += run->before[SLIP_PRODUCTS_RUN].cost;
  SlipProductsGetOf(SLIP_PRODUCTS_LOOK, &run->before[SLIP_PRODUCTS_LOOK]);
  PetscCall(SlipFaultClockStart(fault, ts));
  PetscCall(SlipFaultReportSteps(fault, ts));
  PetscCall(TSMonitorSet(ts, SlipFaultObserversMonitor, fault, NULL)); /* before that of /series; PETSc has it once */
  /* if an observer refuses the run, those before it are destroyed */
  PetscCall(PetscCalloc1(NUM_OBSERVERS + nregistered, &run->watch));
  for (PetscInt i = 0; i < NUM_OBSERVERS + nregistered; i++) {
    const SlipFaultObserver *row = ObserverAt(i);
    struct _n_SlipFaultWatch *watch = &run->watch[run->nwatch];
    PetscBool wanted = PETSC_TRUE;
    PetscErrorCode ierr = PETSC_SUCCESS;

    *watch = (struct _n_SlipFaultWatch){row, row->ctx};
    if (row->create) ierr = (*row->create)(fault, ts, &wanted, &watch->ctx);
    if (wanted && (!ierr || watch->ctx != row->ctx)) run->nwatch++;
    if (ierr) PetscCall(SlipFaultObserversDestroy(fault));
    PetscCall(ierr);
  }
  if (run->file) run->file->layout = SlipFaultObserversLayout;
  PetscCall(SlipFaultStressPrint(fault)); /* no check can refuse the run any more */
  PetscCall(SlipFaultResolutionPrint(fault));
  PetscCall(SlipFaultHmatPrint(fault));
  PetscCall(SlipFaultViscosityPrint(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the cost of the run. Products include those before a restart, and "products" those of output and estimates. */
static PetscErrorCode ProductsResult(const SlipFaultRun *run, SlipOutput file)
{
  SlipProducts p[SLIP_PRODUCTS_USERS];

  PetscFunctionBegin;
  for (int i = 0; i < SLIP_PRODUCTS_USERS; i++) {
    SlipProductsGetOf((SlipProductsUser)i, &p[i]);
    p[i] = SlipProductsSince(&p[i], &run->before[i]);
  }
  {
    const SlipProducts *ran = &p[SLIP_PRODUCTS_RUN], *setup = &p[SLIP_PRODUCTS_SETUP], *look = &p[SLIP_PRODUCTS_LOOK];
    const PetscReal set_up = setup->cost + run->prepared;
    const struct {
      const char *name, *label;
      PetscReal n;
    } row[] = {{"products_k", "products with K", ran->k},
               {"products_h", ran->h ? "products with H" : NULL, ran->h},
               {"products_pc", ran->pc ? "preconditioner applied" : NULL, ran->pc},
               {"products_all", ran->h ? "products in all" : NULL, ran->all},
               {"products_k_setup", setup->k ? "of set-up, with K" : NULL, setup->k},
               {"products_h_setup", NULL, setup->h},
               {"products", NULL, ran->k + look->k}};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row); i++)
      PetscCall(SlipOutputAddResult(file, row[i].name, row[i].label, NULL, row[i].n));
    PetscCall(SlipOutputAddResult(file, "cost", "cost", "s", set_up + ran->cost + look->cost));
    PetscCall(SlipOutputAddResult(file, "cost_setup", NULL, "s", set_up));
    PetscCall(SlipOutputAddResult(file, "cost_output", NULL, "s", look->cost));
    PetscCall(SlipOutputAddResult(file, "processor_time", NULL, "s", SlipProcessorTime() - run->time));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultOutputFinish - prints the summary of a run and completes its output file

  Collective; after TSSolve().

  Input Parameters:
+ fault      - the fault
. ts         - the TS that was solved
. wall_setup - wall time of set-up [s]
- wall_solve - wall time of TSSolve() [s]

  Options Database Key:
. -fault_check_error - repeats the run with every step computed in four parts, for a Richardson estimate of its errors;
                       this costs five times the Bathe solves of the run; with TSBATHE only

  Level: intermediate

  Notes:
  Attributes of /result, where friction weakens and there are several cells: least_resolution, the cells in the least
  cohesive zone (in the least length of nucleation where there is none), and cells_fail_alone, the share of weakening
  cells that can fail by themselves.

  When the fault rests at the end, the summary has an estimate of the error that `TSAdaptRLGetMeasure()` names (of the
  history with controllers that have no measure), which nine in ten runs stay below, or the reason why it is unknown;
  `SlipFaultOutputStart()` must have been called. The estimate judges the accuracy of a policy that observes
  log_accuracy: likely met, or unknown; the check finds met or not met. Attributes of /result, X being slip (the final
  mean slip), history and event_time: X_error_estimate, X_error_measure (the estimate before its calibration),
  slip_error_signed (the first variation, computed minus exact), accuracy_requested, slip_error_estimate_met (of the
  run's measure: 1 or -1), and with the check X_error_check, slip_error_check_signed, slip_error_check_met (of the
  run's measure: 1 or 0), check_error_final, check_error_history, check_error_shift, check_error_peak,
  check_error_field, check_solves.

.seealso: SlipFaultOutputStart(), TSAdaptRLSetMeasure()
@*/
PetscErrorCode SlipFaultOutputFinish(SlipFault fault, TS ts, PetscReal wall_setup, PetscReal wall_solve)
{
  SlipFaultRun *run = fault->run;
  SlipFaultObservables obs;
  SlipOutput file;
  PetscReal t, omega;
  Vec w;
  static const struct {
    const char *name, *label;
  } row[] = {{"device_puts", "arrays to the device"},
             {"device_fetches", "arrays from the device"},
             {"device_numbers", "numbers from the device"}};
  PetscInt64 now[3];

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_LOOK));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(SlipFaultGetObservables(fault, t, w, NULL, &obs));
  if (!run->file) PetscCall(SlipOutputCreate(ts, NULL, 0, NULL, NULL, NULL, &run->file));
  file = run->file;
  PetscCall(SlipOutputBegin(file));
  if (fault->problem.steps.any_integrator)
    PetscCall(SlipOutputAddResult(file, "right_hand_sides", "right-hand sides", NULL, fault->balance.sides));
  PetscCall(ProductsResult(run, file));
  /* transfers between the processor and the device since the run began */
  SlipFaultDeviceTraffic(now);
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row) && fault->device.device; i++)
    PetscCall(SlipOutputAddResult(file, row[i].name, row[i].label, NULL, (PetscReal)(now[i] - run->traffic[i])));
  PetscCall(SlipElasticGetFoundFrequency(fault->medium, &omega));
  if (omega > 0) PetscCall(SlipOutputAddResult(file, "largest_frequency", "largest frequency", "rad/s", omega));
  PetscCall(SlipOutputAddResult(file, "mean_slip", "final mean slip", "m", obs.mean_slip));
  PetscCall(SlipFaultStepsResult(fault, ts, file));
  PetscCall(SlipFaultHmatResult(fault, file));
  PetscCall(SlipFaultResolutionResult(fault, file));
  for (PetscInt i = 0; i < run->nwatch; i++)
    if (run->watch[i].row->finish) PetscCall((*run->watch[i].row->finish)(fault, ts, file, run->watch[i].ctx));
  PetscCall(SlipProductsPop());
  run->file = NULL;
  PetscCall(SlipOutputFinish(&file, wall_setup, wall_solve));
  PetscCall(SlipFaultViewTimes(fault));
  SlipProductsGetOf(SLIP_PRODUCTS_RUN, &run->before[SLIP_PRODUCTS_RUN]); /* the next run is prepared from here on */
  run->complete = PETSC_TRUE;
  PetscCall(SlipFaultObserversDestroy(fault));
  PetscCall(SlipClockStop(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}
