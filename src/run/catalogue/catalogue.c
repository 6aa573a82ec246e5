/* Finds the events of a run for -fault_catalogue. An event lasts from the first cell whose slip rate exceeds
   -fault_event_rate to the last one, until all are much slower: a rate that exceeds the bound again before is part of
   it. The rates at the ends of accepted steps show which steps belong to an event. Onset and end are the times at which
   they pass the bound within the first and the last of these. cataloguestep.c integrates over a step, and finds when
   cells pass the bound in it. Between events a step costs one reduction. Products with K are necessary at the onset and
   the end, and where cells always slide for states within steps. */
#include <slipstep/private/sliprunfiles.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* An event is over when all rates are below the bound over this; until then it may continue. Slowly growing rates cross
   the bound repeatedly, in the minute before an event of SEAS BP5 within a factor of 2. A decade is more than that, and
   small against the nine decades by which rates fall after an event. */
#define EVENT_OVER 10
/* An energy residual is reported from this share of the energies on. A moment with such an error changes the magnitude
   by 0.01, 2/3 of log10(1.035), its last printed digit. Steps that follow an event leave less than 0.004. */
#define LARGE_RESIDUAL 0.035
#define LONGEST_NAME 60 /* of a fault, with its label, on the line of an event */

/* ---- an event ---- */

/* Gets the pore pressure at the hypocentre at the onset. Collective. */
static PetscErrorCode OnsetPressure(SlipFaultCatalogue cat)
{
  SlipFault fault = cat->fault;
  SlipFaultEvent *e = &cat->event;
  PetscReal *p;

  PetscFunctionBegin;
  if (!fault->kind.flows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(fault->mesh.n + 1, &p));
  PetscCall(SlipLoadsPressures(&fault->loads, e->onset, PETSC_TRUE, p));
  e->pressure = 0;
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if (SlipFaultMeshRow(&fault->mesh, i) == e->cell) e->pressure = p[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &e->pressure, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscCall(PetscFree(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins an event; w: state at the onset, in which the fastest cell is the first one */
static PetscErrorCode BeginEvent(SlipFaultCatalogue cat, PetscReal onset, Vec w)
{
  SlipFault fault = cat->fault;
  SlipFaultEvent *e = &cat->event;
  PetscReal max, first, last;
  const PetscReal time = fault->loads.origin + onset;

  PetscFunctionBegin;
  *e = (SlipFaultEvent){.onset = onset};
  /* waves of images of earlier events, which may overlap in time, may still be present */
  PetscCall(SlipElasticGetImages(fault->medium, &first, &last));
  if (!fault->run->events || time > cat->last_end + last) cat->slip_since = time;
  e->images = time > cat->slip_since + first ? PETSC_TRUE : PETSC_FALSE;
  cat->active = cat->unbroken = PETSC_TRUE;
  cat->power_known = PETSC_FALSE;
  PetscCall(SlipFaultGetDisplacement(fault, w, cat->u0));
  PetscCall(SlipFaultStress(fault, onset, w, cat->stress0));
  PetscCall(SlipCatalogueEnergies(fault, onset, w, &e->elastic, &e->kinetic));
  PetscCall(VecSet(cat->rupture, -1));
  PetscCall(PetscArrayzero(cat->work, cat->nwork));
  PetscCall(SlipFaultTermsEnergy(fault, onset, w, &cat->work[WORK_LOADING]));
  for (PetscInt k = 0; k < fault->mesh.faults && cat->hypocentre; k++) cat->hypocentre[k] = -1;
  PetscCall(SlipFaultLargestSpeed(fault, w, &max));
  PetscCall(SlipCatalogueFastest(fault, w, 1, NULL, &max, &e->cell));
  PetscCall(OnsetPressure(cat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the energy residual over the larger of the two terms of the balance: an event of a fault that loading moves
   may release almost no energy. */
static PetscReal Residual(PetscReal left, PetscReal elastic, PetscReal dissipated)
{
  const PetscReal size = PetscMax(PetscAbsReal(elastic), PetscAbsReal(dissipated));

  return size > 0 ? PetscAbsReal(left * elastic) / size : 0;
}

/* Writes on which fault an event began: its label and, on rank 0, its name in the mesh's file. */
static void NameFault(const SlipFaultMesh *mesh, PetscInt label, char text[], size_t size)
{
  char key[32];
  const char *at = mesh->names;

  (void)snprintf(key, sizeof(key), "%lld ", (long long)label);
  while (at && strncmp(at, key, strlen(key))) {
    at = strstr(at, "; ");
    if (at) at += 2;
  }
  (void)snprintf(text, size, "fault %.*s", at ? (int)PetscMin(strcspn(at, ";"), LONGEST_NAME) : (int)strlen(key) - 1,
                 at ? at : key);
}

/* Closes an event that is over, and prints it. */
static PetscErrorCode Close(SlipFaultCatalogue cat)
{
  SlipFault fault = cat->fault;
  const PetscReal *row = cat->row;
  const PetscReal residual =
    Residual(row[EVENT_ENERGY_RESIDUAL], row[EVENT_ELASTIC_ENERGY], row[EVENT_DISSIPATED_ENERGY]);
  char when[32], lasted[32], where[LONGEST_NAME + 16] = "", across[32] = "", off[48] = "", line[384];

  PetscFunctionBegin;
  PetscCall(SlipCatalogueAdd(cat));
  cat->active = cat->ended = cat->power_known = cat->push_known = PETSC_FALSE;
  cat->last_end = fault->loads.origin + row[EVENT_END];
  fault->run->events++;
  SlipTimeText(fault->loads.origin + row[EVENT_ONSET], 7, when, sizeof(when));
  SlipTimeText(row[EVENT_END] - row[EVENT_ONSET], 4, lasted, sizeof(lasted));
  if (fault->mesh.faults > 1) NameFault(&fault->mesh, (PetscInt)row[EVENT_FAULT], where, sizeof(where));
  if (row[EVENT_Y] != 0) (void)snprintf(across, sizeof(across), "  y %.4g km", (double)row[EVENT_Y] / 1e3);
  if (!(residual < LARGE_RESIDUAL))
    (void)snprintf(off, sizeof(off), "  energy residual %.2g %%", (double)residual * 100);
  (void)snprintf(line, sizeof(line),
                 "event %lld  t %s  Mw %.2f  %s%sx %.4g km%s  z %.4g km  slip %.3g m  drop %.3g MPa  %s%s%s\n",
                 (long long)fault->run->events, when, (double)row[EVENT_MAGNITUDE], where, where[0] ? "  " : "",
                 (double)row[EVENT_X] / 1e3, across, (double)row[EVENT_Z] / 1e3, (double)row[EVENT_MEAN_SLIP],
                 (double)row[EVENT_STRESS_DROP] / 1e6, lasted, off, row[EVENT_IMAGES] != 0 ? "  images?" : "");
  PetscCall(PetscPrintf(fault->comm, "%s", line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Follows a step that ended in w. Where the rate falls below the bound, the event's row is filled, in case the event
   does not continue. */
static PetscErrorCode Follow(SlipFaultCatalogue cat, TS ts, PetscReal time, Vec w)
{
  SlipFault fault = cat->fault;
  SlipFaultEvent *e = &cat->event;
  const PetscReal rate = fault->options.value[FAULT_EVENT_RATE];
  PetscReal max;
  PetscBool ends;
  SlipEventStep step;

  PetscFunctionBegin;
  PetscCall(SlipFaultStepRate(fault, time, w, &max));
  if (!cat->active && max <= rate) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipCatalogueGetStep(cat, ts, time, w, &step));
  if (!cat->active) { /* the event begins in this step, in which the rate exceeds the bound */
    PetscCall(SlipCatalogueCross(cat, &step, PETSC_TRUE));
    PetscCall(BeginEvent(cat, step.begin + step.cut * step.dt, cat->cut));
    e->time[1] = step.begin;
    PetscCall(SlipFaultLargestSpeed(fault, step.node[0], &e->rate[1]));
    if (e->rate[1] == 0) {
      PetscCall(SlipCatalogueFirstToSlip(cat, step.begin, step.node[0], &e->cell));
      PetscCall(OnsetPressure(cat));
    }
  }
  ends = max <= rate && !cat->ended ? PETSC_TRUE : PETSC_FALSE;
  if (ends) PetscCall(SlipCatalogueCross(cat, &step, PETSC_FALSE));
  PetscCall(SlipCatalogueIntegrate(cat, &step, cat->fast, cat->slow));
  PetscCall(SlipCatalogueMarkRuptured(cat, &step));
  {
    const PetscReal times[] = {e->time[0], e->time[1], step.begin + step.dt}, rates[] = {e->rate[0], e->rate[1], max};

    e->peak = PetscMax(e->peak, e->steps ? SlipEventPeak(times, rates) : max);
    for (int k = 0; k < 2; k++) {
      e->time[k] = times[k + 1];
      e->rate[k] = rates[k + 1];
    }
    e->steps++;
  }
  for (PetscInt k = 0; k < cat->nwork; k++) cat->work[k] += cat->fast[k];
  if (ends) {
    PetscCall(SlipCatalogueFillRow(cat, step.begin + step.cut * step.dt, cat->cut));
    for (PetscInt k = 0; k < cat->nwork; k++) cat->work[k] += cat->slow[k];
  }
  cat->ended = max <= rate ? PETSC_TRUE : PETSC_FALSE;
  if (cat->ended && max <= rate / EVENT_OVER) PetscCall(Close(cat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

static PetscErrorCode Remember(SlipFaultCatalogue cat, PetscReal time, Vec w)
{
  PetscFunctionBegin;
  if (!cat->before) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(w, cat->before));
  cat->time_before = time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins the catalogue; TSSolve() may start within an event. */
static PetscErrorCode CatalogueStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;
  PetscReal max;

  PetscFunctionBegin;
  (void)ts;
  cat->unbroken = PETSC_TRUE;
  SlipCatalogueFollowOrigin(cat);
  PetscCall(SlipCatalogueBegin(cat));
  PetscCall(SlipCatalogueFlush(cat));
  PetscCall(SlipFaultStepRate(fault, time, w, &max));
  if (!cat->active && max > fault->options.value[FAULT_EVENT_RATE]) {
    PetscCall(BeginEvent(cat, time, w));
    PetscCall(SlipCatalogueMarkRuptured(cat, &(SlipEventStep){.begin = time, .nodes = 1, .node = {w}}));
    cat->event.peak = max;
    cat->event.time[1] = time;
    cat->event.rate[1] = max;
  }
  PetscCall(Remember(cat, time, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CatalogueStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;

  PetscFunctionBegin;
  (void)fault;
  (void)step;
  SlipCatalogueFollowOrigin(cat);
  PetscCall(SlipCatalogueFlush(cat));
  PetscCall(Follow(cat, ts, time, w));
  PetscCall(Remember(cat, time, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CatalogueCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  const char *prefix = SlipFaultPrefix(fault), *file = fault->options.text[FAULT_CATALOGUE];
  SlipFaultCatalogue cat;
  PetscBool same, bathe;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  fault->run->events = file[0] ? 0 : -1;
  *wanted = file[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSBatheIs(ts, &bathe));
  PetscCall(PetscStrcmp(file, fault->options.text[FAULT_OUTPUT], &same));
  PetscCheck(!same, fault->comm, PETSC_ERR_FILE_OPEN,
             "-%sfault_catalogue and -%sfault_output are both %s, expected two files", prefix, prefix, file);
  PetscCall(PetscNew(&cat));
  *ctx = fault->run->catalogue = cat;
  cat->fault = fault;
  cat->origin = fault->loads.origin;
  PetscCall(SlipClockGet(ts, &cat->table.clock));
  cat->maps = fault->options.catalogue_maps;
  cat->file.id = -1;
  cat->kind = (SlipH5Kind){.prefix = prefix,
                           .option = "fault_catalogue",
                           .restart = "fault_restart",
                           .discard = "fault_output_overwrite",
                           .growing = PETSC_TRUE,
                           .overwrite = fault->options.output_overwrite};
  PetscCallMPI(MPI_Comm_rank(fault->comm, &cat->rank));
  if (!cat->rank) {
    const SlipH5Kind name = {.prefix = prefix, .option = "fault_catalogue"};

    ierr = SlipH5CheckCreateKind(&name, file);
  }
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  {
    Vec *vecs[] = {&cat->u0, &cat->stress0, &cat->stress, &cat->slip};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDuplicate(fault->critical.uc, vecs[i]));
    PetscCall(SlipFaultCellVector(fault, &cat->rupture));
  }
  {
    const PetscInt several = fault->mesh.faults > 1 ? fault->mesh.faults : 0;

    cat->nrow = EVENT_NUM_COLUMNS + (EVENT_ALL_COLUMNS - EVENT_NUM_COLUMNS) * several;
    if (fault->kind.flows) cat->nrow += EVENT_FLUID_COLUMNS;
    cat->nwork = FAULT_NUM_WORKS + several;
    PetscCall(PetscCalloc5(cat->nrow, &cat->row, cat->nwork, &cat->work, cat->nwork, &cat->power, cat->nwork,
                           &cat->cut_power, cat->nwork, &cat->next));
    PetscCall(PetscCalloc5(cat->nwork, &cat->inner, cat->nwork, &cat->sum, cat->nwork, &cat->fast, cat->nwork,
                           &cat->slow, (SLIP_EVENT_HALVINGS + 1) * cat->nwork, &cat->romberg));
    if (several) PetscCall(PetscMalloc1(several, &cat->hypocentre));
  }
  PetscCall(SlipFaultCreateState(fault, &cat->cut));
  for (int k = 0; k < 3 && !bathe; k++)
    PetscCall(SlipFaultCreateState(fault, (Vec *[]){&cat->before, &cat->middle, &cat->within}[k]));
  if (cat->maps) PetscCall(SlipFaultGatherCreate(&fault->mesh, cat->slip, &cat->gather, &cat->map[0]));
  if (cat->maps) PetscCall(SlipFaultGatherCreate(&fault->mesh, cat->rupture, &cat->gather_cells, &cat->map[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WarnOfResiduals(SlipFaultCatalogue cat)
{
  PetscReal *left, *elastic, *dissipated, shortest, most = 0;
  PetscInt n, rows, large = 0, event = 0;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetShortestStep(cat->fault->medium, &shortest));
  PetscCall(SlipCatalogueReadColumn(cat, EVENT_ENERGY_RESIDUAL, &rows, &left));
  PetscCall(SlipCatalogueReadColumn(cat, EVENT_ELASTIC_ENERGY, &rows, &elastic));
  PetscCall(SlipCatalogueReadColumn(cat, EVENT_DISSIPATED_ENERGY, &rows, &dissipated));
  n = PetscMin(rows, cat->fault->run->events); /* the events that are over */
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal residual = Residual(left[k], elastic[k], dissipated[k]);

    if (residual < LARGE_RESIDUAL) continue;
    large++;
    if (!(residual > most)) continue;
    most = residual;
    event = k + 1;
  }
  if (large)
    PetscCall(SlipWarning("%" PetscInt_FMT " of %" PetscInt_FMT
                          " events have an energy residual of more than %g %%, at most %.2g %% (event %" PetscInt_FMT
                          "): their steps are too long for moments and energies. Use %s",
                          large, n, 100 * LARGE_RESIDUAL, (double)most * 100, event,
                          shortest > 0  ? "smaller cells (-fault_nx, -fault_nz), whose steps are shorter"
                          : cat->before ? "-ts_adapt_type basic, or a smaller -ts_rtol with it"
                                        : "a smaller -fault_accuracy or -ts_rtol"));
  PetscCall(PetscFree(left));
  PetscCall(PetscFree(elastic));
  PetscCall(PetscFree(dissipated));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WarnOfImages(SlipFaultCatalogue cat)
{
  PetscReal *images;
  PetscInt n, some = 0, event = 0;

  PetscFunctionBegin;
  PetscCall(SlipCatalogueReadColumn(cat, EVENT_IMAGES, &n, &images));
  for (PetscInt k = n - 1; k >= 0; k--) {
    if (images[k] == 0) continue;
    some++;
    event = k + 1;
  }
  PetscCall(PetscFree(images));
  if (some)
    PetscCall(SlipWarning("%" PetscInt_FMT " of %" PetscInt_FMT " events (the first is event %" PetscInt_FMT
                          ") began when waves of periodic images of earlier ones may have been there, and may be of "
                          "these: /images of the catalogue is 1. Compare a run with a larger -%sfault_waves_padding",
                          some, n, event, SlipFaultPrefix(cat->fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Completes the file, and adds the number of events to the summary. */
static PetscErrorCode CatalogueFinish(SlipFault fault, TS ts, SlipOutput run, void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipCatalogueBegin(cat));
  if (cat->active && cat->ended) PetscCall(Close(cat));
  PetscCall(SlipOutputAddResult(run, "events", "events", NULL, (PetscReal)fault->run->events));
  if (cat->active) { /* the row of an unfinished event, which a restart removes */
    char when[32], text[160];
    PetscReal t;
    Vec w;

    PetscCall(TSGetTime(ts, &t));
    PetscCall(TSGetSolution(ts, &w));
    PetscCall(SlipCatalogueFillRow(cat, t, w));
    cat->row[EVENT_GOES_ON] = 1;
    PetscCall(SlipCatalogueAdd(cat));
    SlipTimeText(cat->origin + cat->event.onset, 7, when, sizeof(when));
    PetscCall(PetscSNPrintf(text, sizeof(text),
                            "M %.2f so far, since t %s: the last row, of this much; a later -ts_max_time continues it",
                            (double)cat->row[EVENT_MAGNITUDE], when));
    PetscCall(SlipOutputAddResult(run, "event", "event that goes on", text, (PetscReal)NAN));
    PetscCall(SlipOutputAddResult(run, "magnitude_so_far", NULL, NULL, cat->row[EVENT_MAGNITUDE]));
  }
  if (!cat->rank && fault->options.reports) ierr = WarnOfResiduals(cat);
  if (!cat->rank && fault->options.reports && !ierr) ierr = WarnOfImages(cat);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(SlipCatalogueClose(cat, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CatalogueDestroy(void **ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)*ctx;

  PetscFunctionBegin;
  cat->fault->run->catalogue = NULL;
  PetscCall(SlipCatalogueClose(cat, PETSC_FALSE));
  {
    Vec *vecs[] = {&cat->u0,     &cat->stress0,  &cat->rupture,  &cat->cut,    &cat->stress,
                   &cat->slip,   &cat->map[0],   &cat->map[1],   &cat->before, &cat->middle,
                   &cat->within, &cat->slope[0], &cat->slope[1], &cat->push};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  }
  PetscCall(VecScatterDestroy(&cat->gather));
  PetscCall(VecScatterDestroy(&cat->gather_cells));
  PetscCall(SlipTableDestroy(&cat->table));
  PetscCall(PetscFree5(cat->row, cat->work, cat->power, cat->cut_power, cat->next));
  PetscCall(PetscFree5(cat->inner, cat->sum, cat->fast, cat->slow, cat->romberg));
  PetscCall(PetscFree(cat->hypocentre));
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultCatalogueObserver = {.name = "catalogue",
                                                      .create = CatalogueCreate,
                                                      .start = CatalogueStart,
                                                      .step = CatalogueStep,
                                                      .visit = SlipCatalogueVisit,
                                                      .finish = CatalogueFinish,
                                                      .destroy = CatalogueDestroy};
