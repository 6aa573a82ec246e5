/* -fault_catalogue: events of a run, from the first cell whose slip rate exceeds -fault_event_rate to the last that does,
   until all are much slower: what passes the bound again before that is the same event.

   The rates at the ends of accepted steps say which steps belong to an event; onset and end are where they pass the bound
   within the first and the last of these (core/event.c), and the part of the two that lies outside is taken off again. Of
   that part, in which every cell is slower than the bound, the integrals are those of a trapezoidal rule. Between events a
   step costs one reduction. In an event it costs two products with H, as every integral has the nodes and the weights by
   which the integrator itself forms displacements of slip rates (TSBatheGetQuadrature()): a cheaper rule, such as the two
   ends alone, would cost the ledger its order, or the sign of its error where a stage has stopped a cell. Products with K
   are needed at the onset and the end alone. */
#include <slipstep/private/slipfaultrecord.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <stdio.h>

/* An event is over when all rates have fallen below the bound over this: until then it may go on. Rates that creep up to the
   bound pass it to and fro, in the minute before an event of SEAS BP5 by less than a factor of 2; a decade is more than that,
   and little of the nine by which rates fall after an event. */
#define EVENT_OVER 10

/* ---- parts of a step ---- */

/* Powers of a state [W]; a product with H */
static PetscErrorCode Powers(SlipFaultCatalogue cat, PetscReal t, Vec w, PetscReal power[])
{
  SlipFault fault = cat->fault;
  const PetscReal area = fault->mesh.area;
  PetscReal sum[3], loading, *friction = cat->nwork > FAULT_NUM_WORKS ? power + FAULT_NUM_WORKS : NULL;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetPowers(fault, t, w, NULL, sum, friction));
  PetscCall(SlipFaultLoadingPower(fault, t, w, &loading));
  power[WORK_RADIATED] = area * sum[0];
  power[WORK_DISSIPATED] = area * sum[2];
  power[WORK_LOADING] = loading - area * sum[1];
  for (PetscInt k = FAULT_NUM_WORKS; k < cat->nwork; k++) power[k] *= area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void AddWork(SlipFaultCatalogue cat, PetscReal time, const PetscReal power[])
{
  for (PetscInt k = 0; k < cat->nwork; k++) cat->work[k] += time * power[k];
}

typedef struct {
  PetscReal begin, dt; /* [s] */
  Vec a, b;            /* states at its ends */
} Step;

/* The rate of cell i in a state that passes the bound: of one component with its sign, of two its magnitude */
static PetscReal EventRate(SlipFault fault, const PetscReal a[], PetscInt i)
{
  return fault->layout.components == 1 ? a[SlipFaultRateAt(fault, i)] : SlipFaultSpeed(fault, a, i);
}

/* The least share of the way from slow, where no such cell is above the rate, to fast after which one is */
static PetscErrorCode FirstCrossing(SlipFaultCatalogue cat, Vec slow, Vec fast, PetscReal *share)
{
  SlipFault fault = cat->fault;
  const PetscReal rate = fault->options.value[FAULT_EVENT_RATE];
  const PetscReal *a, *b;
  const SlipArrays arrays[] = {{slow, .read = &a}, {fast, .read = &b}};

  PetscFunctionBegin;
  *share = 1;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if (SlipFaultSpeed(fault, b, i) > rate)
      *share = PetscMin(*share, SlipEventCrossing(EventRate(fault, a, i), EventRate(fault, b, i), rate));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, share, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells that are above the rate at the end of a step for the first time in this event */
static PetscErrorCode MarkRuptured(SlipFaultCatalogue cat, const Step *step)
{
  SlipFault fault = cat->fault;
  const PetscReal rate = fault->options.value[FAULT_EVENT_RATE], begin = step->begin - cat->event.onset;
  const PetscReal *a, *b;
  PetscReal *t;
  const SlipArrays arrays[] = {{step->a, .read = &a}, {step->b, .read = &b}, {cat->rupture, .write = &t}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    if (t[i] >= 0 || SlipFaultSpeed(fault, b, i) <= rate) continue;
    /* one that was above it all along when the run began has no crossing */
    t[i] = SlipFaultSpeed(fault, a, i) > rate
             ? 0
             : PetscMax(0, begin + step->dt * SlipEventCrossing(EventRate(fault, a, i), EventRate(fault, b, i), rate));
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscCall(SlipCatalogueHypocentres(cat, step->b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rate at a share of the way: of two components its magnitude is between those of the ends as a rate of one is, in a direction
   between theirs */
static void RateBetween(SlipFault fault, const PetscReal from[], const PetscReal to[], PetscReal share, PetscReal v[])
{
  PetscReal size, length;

  if (fault->layout.components == 1) {
    v[0] = SlipEventRate(from[0], to[0], share);
    return;
  }
  for (PetscInt k = 0; k < fault->layout.components; k++) v[k] = (1 - share) * from[k] + share * to[k];
  length = SlipFaultLength(fault, v);
  size = SlipEventRate(SlipFaultLength(fault, from), SlipFaultLength(fault, to), share);
  for (int k = 0; k < 2 && length > 0; k++) v[k] *= size / length;
}

/* State at a share of the way from slow to fast, dt away from slow, negative when it is the earlier one: the displacements
   go with the mean of the two rates, from the side on which they are small. */
static PetscErrorCode Cut(SlipFaultCatalogue cat, Vec slow, Vec fast, PetscReal share, PetscReal dt)
{
  SlipFault fault = cat->fault;
  const PetscReal *a, *b, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  PetscReal *c;
  const SlipArrays arrays[] = {{slow, .read = &a}, {fast, .read = &b}, {cat->cut, .write = &c}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal *from = a + SlipFaultRateAt(fault, i), *to = b + SlipFaultRateAt(fault, i);
    PetscReal *v = c + SlipFaultRateAt(fault, i);

    RateBetween(fault, from, to, share, v);
    for (PetscInt k = 0; k < fault->layout.components; k++)
      c[SlipFaultDisplacementAt(fault, i) + k] = a[SlipFaultDisplacementAt(fault, i) + k] +
                                                 dt * (0.5 * (from[k] + v[k]) - vinf[i] * SlipFaultAlong(fault, i)[k]);
    c[SlipFaultStateAt(fault, i)] =
      fault->friction.law->state
        ? a[SlipFaultStateAt(fault, i)] + share * (b[SlipFaultStateAt(fault, i)] - a[SlipFaultStateAt(fault, i)])
        : a[SlipFaultStateAt(fault, i)] + dt * 0.5 * (SlipFaultLength(fault, from) + SlipFaultLength(fault, v));
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodes and weights of the last step, which ends in w: those of TSBATHE, or the two ends */
static PetscErrorCode GetQuadrature(SlipFaultCatalogue cat, TS ts, Vec w, PetscReal share[3], PetscReal weight[3],
                                    Vec node[3])
{
  PetscFunctionBegin;
  if (!cat->before) {
    PetscCall(TSBatheGetQuadrature(ts, share, weight, node));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  share[0] = share[1] = 0;
  share[2] = 1;
  weight[0] = weight[2] = 0.5;
  weight[1] = 0;
  node[0] = node[1] = cat->before;
  node[2] = w;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* When it began [s] and how long it was [s] */
static PetscErrorCode GetLastStep(SlipFaultCatalogue cat, TS ts, PetscReal time, PetscReal *begin, PetscReal *dt)
{
  SlipAttempt attempt;

  PetscFunctionBegin;
  if (cat->before) {
    *begin = cat->time_before;
    *dt = time - cat->time_before;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSBatheGetLastAttempt(ts, &attempt));
  *begin = attempt.time;
  *dt = attempt.dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What cells lose that fall shut within the step: with inertia the energy of their opening, M v_n^2/2 [J], of the rate at its start */
static PetscErrorCode AddImpacts(SlipFaultCatalogue cat, const Step *step)
{
  SlipFault fault = cat->fault;
  const PetscReal *a, *b;
  const SlipArrays arrays[] = {{step->a, .read = &a}, {step->b, .read = &b}};
  PetscReal lost = 0;

  PetscFunctionBegin;
  if (!SlipFaultOpens(fault) || !fault->kind.inertia) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt opening = SlipFaultDisplacementAt(fault, i) + 2;

    if (a[opening] > 0 && b[opening] == 0)
      lost += 0.5 * fault->operators.mass * fault->mesh.weight[i] * PetscSqr(a[SlipFaultRateAt(fault, i) + 2]);
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &lost, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  cat->work[WORK_DISSIPATED] += fault->mesh.area * lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The step's share of all integrals, and of the largest slip rate */
static PetscErrorCode AddStep(SlipFaultCatalogue cat, TS ts, const Step *step, PetscReal max)
{
  SlipFaultEvent *e = &cat->event;
  PetscReal share[3], weight[3];
  Vec node[3];

  PetscFunctionBegin;
  PetscCall(GetQuadrature(cat, ts, step->b, share, weight, node));
  if (!cat->power_known) PetscCall(Powers(cat, step->begin, node[0], cat->power));
  AddWork(cat, step->dt * weight[0], cat->power);
  for (PetscInt k = 1; k < 3; k++) {
    if (weight[k] == 0) continue;
    PetscCall(Powers(cat, step->begin + share[k] * step->dt, node[k], cat->power));
    AddWork(cat, step->dt * weight[k], cat->power);
  }
  cat->power_known = PETSC_TRUE;
  PetscCall(AddImpacts(cat, step));
  {
    const PetscReal time[] = {e->time[0], e->time[1], step->begin + step->dt}, rate[] = {e->rate[0], e->rate[1], max};

    e->peak = PetscMax(e->peak, e->steps ? SlipEventPeak(time, rate) : max);
    PetscCall(PetscArraycpy(e->time, time + 1, 2));
    PetscCall(PetscArraycpy(e->rate, rate + 1, 2));
  }
  e->steps++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an event ---- */

/* w: state at the onset; fast, max: the one in which cells were first seen above the rate, and the largest there */
static PetscErrorCode BeginEvent(SlipFaultCatalogue cat, PetscReal onset, Vec w, Vec fast, PetscReal max)
{
  SlipFault fault = cat->fault;
  SlipFaultEvent *e = &cat->event;

  PetscFunctionBegin;
  *e = (SlipFaultEvent){.onset = onset, .peak = max};
  cat->active = PETSC_TRUE;
  cat->power_known = PETSC_FALSE;
  PetscCall(SlipFaultGetDisplacement(fault, w, cat->u0));
  PetscCall(SlipFaultStress(fault, onset, w, cat->stress0));
  PetscCall(SlipCatalogueEnergies(fault, onset, w, &e->elastic, &e->kinetic));
  PetscCall(VecSet(cat->rupture, -1));
  PetscCall(PetscArrayzero(cat->work, cat->nwork));
  for (PetscInt k = 0; k < fault->mesh.faults && cat->hypocentre; k++) cat->hypocentre[k] = -1;
  PetscCall(SlipCatalogueFastest(fault, fast, 1, NULL, &max, &e->cell));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first step of an event, in which the rate is passed */
static PetscErrorCode Onset(SlipFaultCatalogue cat, const Step *step, PetscReal max)
{
  SlipFaultEvent *e = &cat->event;
  PetscReal share, start;

  PetscFunctionBegin;
  PetscCall(FirstCrossing(cat, step->a, step->b, &share));
  PetscCall(Cut(cat, step->a, step->b, share, share * step->dt));
  PetscCall(BeginEvent(cat, step->begin + share * step->dt, cat->cut, step->b, max));
  PetscCall(SlipFaultLargestSpeed(cat->fault, step->a, &start));
  e->time[1] = step->begin;
  e->rate[1] = start;
  PetscCall(Powers(cat, step->begin, step->a, cat->power));
  cat->power_known = PETSC_TRUE;
  PetscCall(Powers(cat, e->onset, cat->cut, cat->cut_power));
  AddWork(cat, -0.5 * share * step->dt, cat->power);
  AddWork(cat, -0.5 * share * step->dt, cat->cut_power);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintEvent(SlipFault fault, const PetscReal row[])
{
  char when[32], lasted[32], where[32] = "", across[32] = "", line[256];

  PetscFunctionBegin;
  SlipTimeText(row[EVENT_ONSET], 7, when, sizeof(when));
  SlipTimeText(row[EVENT_END] - row[EVENT_ONSET], 4, lasted, sizeof(lasted));
  if (fault->mesh.faults > 1) (void)snprintf(where, sizeof(where), "fault %lld  ", (long long)row[EVENT_FAULT]);
  if (row[EVENT_Y] != 0) (void)snprintf(across, sizeof(across), "  y %.4g km", (double)row[EVENT_Y] / 1e3);
  (void)snprintf(
    line, sizeof(line), "event %lld  t %s  Mw %.2f  %sx %.4g km%s  z %.4g km  slip %.3g m  drop %.3g MPa  %s\n",
    (long long)fault->run.events, when, (double)row[EVENT_MAGNITUDE], where, (double)row[EVENT_X] / 1e3, across,
    (double)row[EVENT_Z] / 1e3, (double)row[EVENT_MEAN_SLIP], (double)row[EVENT_STRESS_DROP] / 1e6, lasted);
  PetscCall(PetscPrintf(fault->comm, "%s", line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step of an event in which the rate is passed again: its row, should the event not go on */
static PetscErrorCode End(SlipFaultCatalogue cat, const Step *step)
{
  PetscReal share, end;

  PetscFunctionBegin;
  PetscCall(FirstCrossing(cat, step->b, step->a, &share));
  end = step->begin + (1 - share) * step->dt;
  PetscCall(Cut(cat, step->b, step->a, share, -share * step->dt));
  PetscCall(Powers(cat, end, cat->cut, cat->cut_power));
  PetscCall(PetscArraycpy(cat->whole, cat->work, cat->nwork));
  AddWork(cat, -0.5 * share * step->dt, cat->power);
  AddWork(cat, -0.5 * share * step->dt, cat->cut_power);
  PetscCall(SlipCatalogueFillRow(cat, end, cat->cut));
  PetscCall(PetscArraycpy(cat->work, cat->whole, cat->nwork));
  cat->ended = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The event is over */
static PetscErrorCode Close(SlipFaultCatalogue cat)
{
  PetscFunctionBegin;
  PetscCall(SlipCatalogueAdd(cat));
  cat->active = cat->ended = cat->power_known = PETSC_FALSE;
  cat->last_end = cat->row[EVENT_END];
  cat->fault->run.events++;
  PetscCall(PrintEvent(cat->fault, cat->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step that ended in w */
static PetscErrorCode Follow(SlipFaultCatalogue cat, TS ts, PetscReal time, Vec w)
{
  SlipFault fault = cat->fault;
  const PetscReal rate = fault->options.value[FAULT_EVENT_RATE];
  PetscReal max, begin = 0, dt = 0, share[3], weight[3];
  Vec node[3];
  Step now;

  PetscFunctionBegin;
  PetscCall(SlipFaultStepRate(fault, time, w, &max));
  if (!cat->active && max <= rate) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GetLastStep(cat, ts, time, &begin, &dt));
  PetscCall(GetQuadrature(cat, ts, w, share, weight, node));
  now = (Step){begin, dt, node[0], w};
  if (!cat->active) PetscCall(Onset(cat, &now, max));
  PetscCall(MarkRuptured(cat, &now));
  PetscCall(AddStep(cat, ts, &now, max));
  if (max > rate)
    cat->ended = PETSC_FALSE;
  else if (!cat->ended)
    PetscCall(End(cat, &now));
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

/* What TSSolve() starts from may be within an event. */
static PetscErrorCode CatalogueStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;
  PetscReal max;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipCatalogueBegin(cat));
  PetscCall(SlipCatalogueFlush(cat));
  PetscCall(SlipFaultStepRate(fault, time, w, &max));
  if (!cat->active && max > fault->options.value[FAULT_EVENT_RATE]) {
    PetscCall(BeginEvent(cat, time, w, w, max));
    PetscCall(MarkRuptured(cat, &(Step){time, 0, w, w}));
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
  fault->run.events = file[0] ? 0 : -1;
  *wanted = file[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  PetscCheck(bathe || fault->friction.law->always_slides, fault->comm, PETSC_ERR_SUP,
             "-%sfault_catalogue works with -ts_type bathe, not %s, unless friction is smooth (rate_and_state)", prefix,
             ((PetscObject)ts)->type_name);
  PetscCall(PetscStrcmp(file, fault->options.text[FAULT_OUTPUT], &same));
  PetscCheck(!same, fault->comm, PETSC_ERR_FILE_OPEN,
             "-%sfault_catalogue and -%sfault_output are both %s, expected two files", prefix, prefix, file);
  PetscCall(PetscNew(&cat));
  *ctx = fault->run.catalogue = cat;
  cat->fault = fault;
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
    PetscCall(VecDuplicate(fault->cells, &cat->rupture));
  }
  {
    const PetscInt several = fault->mesh.faults > 1 ? fault->mesh.faults : 0;

    cat->nrow = EVENT_NUM_COLUMNS + (EVENT_ALL_COLUMNS - EVENT_NUM_COLUMNS) * several;
    cat->nwork = FAULT_NUM_WORKS + several;
    PetscCall(PetscCalloc5(cat->nrow, &cat->row, cat->nwork, &cat->work, cat->nwork, &cat->power, cat->nwork,
                           &cat->cut_power, cat->nwork, &cat->whole));
    if (several) PetscCall(PetscMalloc1(several, &cat->hypocentre));
  }
  PetscCall(SlipFaultCreateState(fault, &cat->cut));
  if (!bathe) PetscCall(SlipFaultCreateState(fault, &cat->before));
  if (cat->maps) PetscCall(SlipFaultGatherCreate(fault, cat->slip, &cat->gather, &cat->map[0]));
  if (cat->maps) PetscCall(SlipFaultGatherCreate(fault, cat->rupture, &cat->gather_cells, &cat->map[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The file is complete, and the summary says how many events there were. */
static PetscErrorCode CatalogueFinish(SlipFault fault, TS ts, SlipOutput run, void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;
  char when[32], line[256];

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipCatalogueBegin(cat));
  if (cat->active && cat->ended) PetscCall(Close(cat));
  if (cat->active) {
    SlipTimeText(cat->event.onset, 7, when, sizeof(when));
    (void)snprintf(
      line, sizeof(line),
      "The event that began at t %s goes on at the end of the run: it is not in the catalogue. Continue the run "
      "with a later -ts_max_time\n",
      when);
    PetscCall(PetscPrintf(fault->comm, "%s", line));
  }
  PetscCall(SlipOutputAddResult(run, "events", "events", NULL, (PetscReal)fault->run.events));
  PetscCall(SlipCatalogueClose(cat, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CatalogueDestroy(void **ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)*ctx;

  PetscFunctionBegin;
  cat->fault->run.catalogue = NULL;
  PetscCall(SlipCatalogueClose(cat, PETSC_FALSE));
  {
    Vec *vecs[] = {&cat->u0,   &cat->stress0, &cat->rupture, &cat->cut,   &cat->stress,
                   &cat->slip, &cat->map[0],  &cat->map[1],  &cat->before};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  }
  PetscCall(VecScatterDestroy(&cat->gather));
  PetscCall(VecScatterDestroy(&cat->gather_cells));
  PetscCall(SlipTableDestroy(&cat->table));
  PetscCall(PetscFree5(cat->row, cat->work, cat->power, cat->cut_power, cat->whole));
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
