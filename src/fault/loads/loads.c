/* Computes what loads and unclamps a fault in time: the shear stress at the start and its rate, the pore pressure of a
   record, a function, a point source or fluid that diffuses (fluid.c), and the terms of terms.c. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <math.h>
#include <slipstep/private/slipwork.h>

#define NEVER PETSC_MAX_REAL

/* ---- the record of -fault_pore_pressure ---- */

/* Returns the row of the record before t, and the share of the way from it to the next row. */
PetscInt SlipLoadsInterval(const SlipFaultLoads *loads, PetscReal t, PetscReal *share)
{
  return SlipRecordInterval(loads->rows, loads->times, t, share);
}

/* Adds the pressure of the record at t [Pa] to p [n]. */
void SlipLoadsAddRecord(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  const PetscInt n = loads->n;
  PetscReal share;
  const PetscInt row = SlipLoadsInterval(loads, t, &share);
  const PetscReal *a = loads->record + (size_t)row * n, *b = share > 0 ? a + n : a;

  for (PetscInt i = 0; i < n; i++) p[i] += (1 - share) * a[i] + share * b[i];
}

/* Returns the number of the first corner of records after t, or the number of corners if there is none. */
PetscInt SlipLoadsCornerAfter(const SlipFaultLoads *loads, PetscReal t)
{
  const PetscReal after = SlipTimeAfter(t);
  PetscReal share;

  if (!loads->ncorners || after >= loads->corners[loads->ncorners - 1]) return loads->ncorners;
  return after < loads->corners[0] ? 0 : SlipRecordInterval(loads->ncorners, loads->corners, after, &share) + 1;
}

/* On rank 0: reads and checks times [rows] and pressures [rows][N] of the open file. */
static PetscErrorCode ReadRecord(SlipFault fault, SlipH5 *h, PetscInt *rows, PetscReal **times, PetscReal **pressure)
{
  const char *prefix = SlipFaultPrefix(fault);
  const SlipFaultMesh *mesh = &fault->mesh;
  const PetscInt any = -1;
  PetscInt dims[3], ndim, want[3] = {0, mesh->dims[0], mesh->dims[1]};
  PetscBool said, flat;

  PetscFunctionBegin;
  PetscCall(SlipH5CheckNames(h, "time pressure"));
  PetscCall(SlipH5CheckUnits(h, "/time", "s", &said));
  PetscCall(SlipH5CheckUnits(h, "/pressure", "Pa", &said));
  PetscCall(SlipH5ReadRealSized(h, "/time", 1, &any, "m times", dims, times));
  *rows = dims[0];
  PetscCheck(*rows > 0, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s (-%sfault_pore_pressure): /time is empty, expected at least one time", h->name, prefix);
  for (PetscInt k = 0; k < *rows; k++)
    PetscCheck(isfinite((*times)[k]) && (!k || (*times)[k] > (*times)[k - 1]), PETSC_COMM_SELF,
               PETSC_ERR_FILE_UNEXPECTED,
               "%s (-%sfault_pore_pressure): /time[%" PetscInt_FMT
               "] is %.9g s, expected finite times, each later than the one before",
               h->name, prefix, k, (double)(*times)[k]);
  want[0] = *rows;
  PetscCall(SlipH5GetRank(h, "/pressure", &ndim));
  flat = ndim == 2 ? PETSC_TRUE : PETSC_FALSE;
  if (flat) want[1] = mesh->N;
  PetscCall(SlipH5ReadRealSized(h, "/pressure", flat ? 2 : 1 + mesh->ndim, want,
                                "a row of Nz x Nx or N cells for each of /time", dims, pressure));
  for (size_t k = 0; k < (size_t)*rows * (size_t)fault->mesh.N; k++)
    PetscCheck(isfinite((*pressure)[k]), PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s (-%sfault_pore_pressure): /pressure has %.6g in row %zu, cell %zu, expected a finite number of Pa",
               h->name, prefix, (double)(*pressure)[k], k / (size_t)fault->mesh.N, k % (size_t)fault->mesh.N);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the record; each process stores the columns of its own cells. */
static PetscErrorCode LoadRecord(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;
  PetscReal *times = NULL, *all = NULL, *row;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) {
    ierr =
      SlipH5OpenReadOption(SlipFaultPrefix(fault), "fault_pore_pressure", fault->options.text[FAULT_PORE_PRESSURE], &h);
    if (!ierr) {
      ierr = ReadRecord(fault, &h, &loads->rows, &times, &all);
      PetscCall(SlipH5Close(&h));
    }
  }
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&loads->rows, 1, MPIU_INT, 0, fault->comm));
  PetscCall(PetscMalloc1(loads->rows, &loads->times));
  PetscCall(PetscMalloc1((size_t)loads->rows * PetscMax(fault->mesh.n, 1), &loads->record));
  PetscCall(PetscMalloc1(fault->mesh.N, &row));
  if (!rank) PetscCall(PetscArraycpy(loads->times, times, loads->rows));
  PetscCallMPI(MPI_Bcast(loads->times, (PetscMPIInt)loads->rows, MPIU_REAL, 0, fault->comm));
  for (PetscInt k = 0; k < loads->rows; k++) {
    if (!rank) PetscCall(PetscArraycpy(row, all + (size_t)k * fault->mesh.N, fault->mesh.N));
    PetscCallMPI(MPI_Bcast(row, (PetscMPIInt)fault->mesh.N, MPIU_REAL, 0, fault->comm));
    for (PetscInt i = 0; i < fault->mesh.n; i++)
      loads->record[(size_t)k * fault->mesh.n + i] = row[SlipFaultMeshRow(&fault->mesh, i)];
  }
  PetscCall(PetscFree(row));
  PetscCall(PetscFree(times));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the point source of -fault_injection ---- */

static PetscErrorCode SourceSetUp(SlipFault fault)
{
  SlipFaultSource *source = &fault->loads.source;
  PetscReal point[3] = {0, 0, 0}, least = NEVER;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_INJECTION][0]) PetscFunctionReturn(PETSC_SUCCESS);
  source->pressure = fault->options.value[FAULT_INJECTION_PRESSURE];
  source->diffusivity = fault->options.value[FAULT_INJECTION_DIFFUSIVITY];
  source->stop = fault->options.value[FAULT_INJECTION_STOP];
  PetscCall(SlipFaultReadPoint(fault, FAULT_INJECTION, 0, "", point, NULL));
  PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &source->distance2));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal area = fault->mesh.weight[i] * fault->mesh.area;
    PetscReal distance2 = 0;
    SlipFaultCell cell;

    fault->mesh.kind->cell(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i), &cell);
    for (int k = 0; k < 3; k++) distance2 += PetscSqr(cell.centre[k] - point[k]);
    /* The mean of -ln r^2 over a disc of the cell's area is its value at r^2 = area/(pi e), and E1 is this logarithm
       near the source. */
    source->distance2[i] = PetscMax(distance2, area / (PETSC_PI * PetscExpReal(1)));
    least = PetscMin(least, source->distance2[i] / (4 * source->diffusivity));
  }
  PetscCallMPI(MPI_Allreduce(&least, &source->time, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all loads together ---- */

/* Fills loads->own [n] by the function of SlipFaultSetPressureFunction(). */
PetscErrorCode SlipLoadsOwnPressure(const SlipFaultLoads *loads, PetscReal t)
{
  PetscFunctionBegin;
  PetscCall((*loads->function)(loads->fault, t, loads->n, loads->own, loads->ctx));
  for (PetscInt i = 0; i < loads->n; i++)
    PetscCheck(isfinite(loads->own[i]), PETSC_COMM_SELF, PETSC_ERR_FP,
               "the function of SlipFaultSetPressureFunction() gives %g Pa at %.9g s in cell %" PetscInt_FMT
               ", expected a finite number",
               (double)loads->own[i], (double)t, loads->fault->mesh.start + i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the pore pressure of the cells of this process at t [Pa], without that of the fluid that diffuses. */
static PetscErrorCode GivenPressure(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  const PetscReal scale = loads->source.pressure, stop = loads->source.stop, D = loads->source.diffusivity;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(p, loads->n));
  if (loads->rows) SlipLoadsAddRecord(loads, t, p);
  if (loads->source.distance2) {
    /* p = p* [E1(r^2/(4 D t)) - E1(r^2/(4 D (t - stop)))]. A cell around the source gets the mean pressure over a disc
       of equal area, for which r has a lower bound. */
    SlipWorkAdd(SLIP_WORK_SOURCE, (PetscReal)loads->n * ((t > 0) + (stop > 0 && t > stop)));
    for (PetscInt i = 0; i < loads->n; i++) {
      if (t > 0) p[i] += scale * SlipExponentialIntegral(loads->source.distance2[i] / (4 * D * t));
      if (stop > 0 && t > stop)
        p[i] -= scale * SlipExponentialIntegral(loads->source.distance2[i] / (4 * D * (t - stop)));
    }
  }
  if (!loads->function) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLoadsOwnPressure(loads, t));
  for (PetscInt i = 0; i < loads->n; i++) p[i] += loads->own[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the pore pressure of the cells of this process at t [Pa]. Collective. */
PetscErrorCode SlipLoadsPressure(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  PetscFunctionBegin;
  PetscCall(GivenPressure(loads, t, p));
  if (loads->fault->fluid.on) PetscCall(SlipFaultFluidPressure(loads->fault, t, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the normal stress at t [n] [Pa] without any slip and without the fluid that diffuses; it may be negative. */
PetscErrorCode SlipLoadsBare(const SlipFaultLoads *loads, PetscReal t, PetscReal stress[])
{
  PetscFunctionBegin;
  PetscCall(GivenPressure(loads, t, stress));
  SlipLoadsAddTerms(loads, t, PETSC_FALSE, NULL, NULL, stress);
  for (PetscInt i = 0; i < loads->n; i++) stress[i] = loads->normal[i] - stress[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the shear load, times weights, along the rake of each cell (1 for one component). Adding t to the origin
   first would lose the changes within the steps of an event to rounding. */
static void ShearAt(const SlipFaultLoads *loads, PetscReal t, PetscReal *restrict a)
{
  const PetscReal *restrict weight = loads->weight, *restrict traction = loads->traction, *restrict rate = loads->rate;
  const PetscInt c = loads->fault->layout.components, n = loads->n;
  const PetscReal origin = loads->origin;

  for (PetscInt i = 0; i < n && c == 1; i++) a[i] = weight[i] * (traction[i] + origin * rate[i] + t * rate[i]);
  for (PetscInt i = 0; i < n && c > 1; i++)
    for (PetscInt k = 0; k < c; k++)
      a[c * i + k] = weight[i] * (traction[i] + origin * rate[i] + t * rate[i]) * SlipFaultAlong(loads->fault, i)[k];
  SlipLoadsAddTerms(loads, t, PETSC_FALSE, weight, a, NULL);
}

/*
  SlipLoadsEvaluate - computes shear load and effective normal stress at the time t

  Collective. A pure function: the same t gives the same bits, whatever calls came before. out is zero before the first
  call and owns its arrays, which SlipLoadDestroy() frees; nothing is computed when it has that time already.
*/
PetscErrorCode SlipLoadsEvaluate(const SlipFaultLoads *loads, PetscReal t, SlipFaultLoad *out)
{
  PetscReal *a;

  PetscFunctionBegin;
  if (out->stress && ((out->time == t && out->origin == loads->origin) || !SlipLoadsVary(loads)))
    PetscFunctionReturn(PETSC_SUCCESS);
  out->stress = out->bare = loads->normal;
  if (loads->pressed) {
    if (!out->own) PetscCall(PetscMalloc1(2 * loads->n + 1, &out->own));
    PetscCall(SlipLoadsPressure(loads, t, out->own));
    SlipLoadsAddTerms(loads, t, PETSC_FALSE, NULL, NULL, out->own);
    for (PetscInt i = 0; i < loads->n; i++) {
      out->own[loads->n + i] = loads->normal[i] - out->own[i];
      out->own[i] = PetscMax(out->own[loads->n + i], 0);
    }
    out->stress = out->own;
    out->bare = out->own + loads->n;
  }
  if (loads->shears && (!out->shear || loads->grows || SlipFaultOpens(loads->fault))) {
    if (!out->shear) {
      PetscCall(VecCreate(loads->fault->comm, &out->shear));
      PetscCall(VecSetSizes(out->shear, loads->fault->layout.components * loads->n, PETSC_DETERMINE));
      PetscCall(VecSetType(out->shear, VECSTANDARD));
    }
    PetscCall(VecGetArrayWrite(out->shear, &a));
    ShearAt(loads, t, a);
    for (PetscInt i = 0; i < loads->n && SlipFaultOpens(loads->fault); i++)
      a[3 * i + 2] = -loads->weight[i] * out->bare[i];
    PetscCall(VecRestoreArrayWrite(out->shear, &a));
  }
  out->time = t;
  out->origin = loads->origin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLoadDestroy(SlipFaultLoad *load)
{
  PetscFunctionBegin;
  PetscCall(VecDestroy(&load->shear));
  PetscCall(PetscFree(load->own));
  *load = (SlipFaultLoad){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the load at t, borrowed until the next call for another time. */
PetscErrorCode SlipFaultGetLoad(SlipFault fault, PetscReal t, const SlipFaultLoad **load)
{
  PetscFunctionBegin;
  PetscCall(SlipLoadsEvaluate(&fault->loads, t, &fault->known.load));
  *load = &fault->known.load;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the next time after t at which a source stops, a well changes, or a course begins or ends; PETSC_MAX_REAL:
   there is none. */
PetscReal SlipLoadsNextEnd(const SlipFaultLoads *loads, PetscReal t)
{
  const PetscReal after = SlipTimeAfter(t), stop = loads->source.stop;
  PetscReal next = NEVER;

  if (loads->source.distance2 && stop > after) next = stop;
  for (PetscInt k = 0; k < loads->nterms; k++)
    next = PetscMin(next, loads->terms[k].course->end(&loads->terms[k], after));
  for (PetscInt k = 0; k < loads->nwells; k++) next = PetscMin(next, SlipFaultWellNext(&loads->wells[k], t));
  return next;
}

/* Returns the next corner of records, or end of a source, course or rate of a well, after t; PETSC_MAX_REAL: there is
   none. */
PetscReal SlipLoadsNextCorner(const SlipFaultLoads *loads, PetscReal t)
{
  const PetscInt corner = SlipLoadsCornerAfter(loads, t);
  const PetscReal next = SlipLoadsNextEnd(loads, t);

  return corner < loads->ncorners ? PetscMin(next, loads->corners[corner]) : next;
}

/* Returns for how long after t loads are nearly linear in time, which limits the pieces of a search for an onset. Both
   ends of a piece may miss the crest of a tide between them by 1 - cos(pi/64), a thousandth of its amplitude. */
PetscReal SlipLoadsPressureScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration)
{
  const PetscReal stop = loads->source.stop, course = SlipLoadsScale(loads, t);
  PetscReal scale = PetscMin(loads->function ? duration / 1000 : NEVER, course < NEVER ? course / 64 : NEVER);

  if (loads->fault->fluid.on) scale = PetscMin(scale, SlipFaultFluidScale(loads->fault, t));
  if (!loads->source.distance2) return scale;
  return PetscMin(scale, (stop > 0 && t >= stop ? t - stop : t) / 20 + loads->source.time / 1000);
}

/* Sets up the loads; after the cells and the weights. */
PetscErrorCode SlipFaultLoadsSetUp(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;
  SlipFaultKind *kind = &fault->kind;
  PetscInt any[3] = {0, 0, 0};
  PetscReal fastest = 0;
  PetscBool medium;

  PetscFunctionBegin;
  loads->fault = fault;
  loads->n = fault->mesh.n;
  loads->weight = fault->mesh.weight;
  loads->traction = fault->fields.cell[FIELD_INITIAL_TRACTION];
  loads->rate = fault->fields.cell[FIELD_STRESSING_RATE];
  loads->normal = fault->fields.cell[FIELD_NORMAL_STRESS];
  for (PetscInt i = 0; i < loads->n; i++) {
    if (loads->traction[i] != 0 || loads->rate[i] != 0) any[0] = 1;
    if (loads->rate[i] != 0) any[1] = 1;
    if (fault->fields.cell[FIELD_HEALING_TIME][i] > 0) any[2] = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 3, MPIU_INT, MPI_MAX, fault->comm));
  /* A traction balances the start of a smooth law, and the normal stress of cells that open is a load. */
  loads->shears = any[0] || fault->friction.law->always_slides || SlipFaultOpens(fault) ? PETSC_TRUE : PETSC_FALSE;
  loads->grows = any[1] ? PETSC_TRUE : PETSC_FALSE;
  if (fault->options.text[FAULT_PORE_PRESSURE][0]) PetscCall(LoadRecord(fault));
  PetscCall(SourceSetUp(fault));
  PetscCall(SlipFaultWellsSetUp(fault));
  if (loads->function) PetscCall(PetscMalloc1(PetscMax(loads->n, 1), &loads->own));
  PetscCall(SlipFaultFluidSetUp(fault));
  loads->pore = loads->pressed =
    loads->rows || loads->source.distance2 || loads->function || fault->fluid.on ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipLoadsTermsSetUp(loads));
  for (PetscInt k = 0; k < loads->nterms; k++) {
    if (loads->terms[k].normal) loads->pressed = PETSC_TRUE;
    if (loads->terms[k].shear) loads->shears = loads->grows = PETSC_TRUE;
    /* one event may follow another, as at a rate; policies, which are for one event with inertia, know no such load */
    if (loads->terms[k].shear && !(loads->terms[k].course->once && !kind->inertia)) any[1] = 1;
  }
  /* the kind of problem that the loads and the healing make */
  kind->heals = (PetscBool)any[2];
  PetscCall(SlipElasticLoads(fault->medium, &medium));
  kind->sequence = kind->loaded || any[1] || medium || any[2] ? PETSC_TRUE : PETSC_FALSE;
  kind->driven = kind->sequence || SlipLoadsChange(loads) || !kind->inertia || fault->friction.law->always_slides
                   ? PETSC_TRUE
                   : PETSC_FALSE;
  if (!kind->heals) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(PetscMax(loads->n, 1), &fault->friction.healing));
  for (PetscInt i = 0; i < loads->n; i++) {
    const PetscReal time = fault->fields.cell[FIELD_HEALING_TIME][i];

    fault->friction.healing[i] = time > 0 ? 1 / time : 0;
    fastest = PetscMax(fastest, fault->friction.healing[i]);
  }
  PetscCallMPI(MPI_Allreduce(&fastest, &loads->fastest_healing, 1, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultLoadsDestroy(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&loads->drive));
  PetscCall(VecDestroy(&loads->pull));
  PetscCall(VecDestroy(&loads->hold));
  PetscCall(PetscFree(loads->times));
  PetscCall(PetscFree(loads->record));
  PetscCall(PetscFree(loads->source.distance2));
  PetscCall(PetscFree(loads->own));
  PetscCall(SlipLoadsTermsDestroy(loads));
  PetscCall(SlipFaultFluidDestroy(fault));
  PetscCall(SlipFaultWellsDestroy(fault));
  PetscCall(PetscFree(fault->friction.healing));
  PetscCall(SlipLoadDestroy(&fault->known.load));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipFaultSetPressureFunction - sets a function of the caller that gives the pore pressure in time and space

  Logically collective; before SlipFaultSetUp().

  Input Parameters:
+ fault    - the fault
. function - fills p [n] with the pore pressure [Pa] of the n cells of this process at the time t [s], in the order of
             the state; smooth in time, and dependent on time alone, as times come in any order
- ctx      - context of the function; the fault stores the pointer

  Level: intermediate

  Notes:
  The strength is mu (sigma_n - p), never below 0. p adds to -fault_pore_pressure and -fault_injection. The search for
  the end of rest steps by thousandths of the run's duration: it may miss shorter pulses of pressure.

  Errors: PETSC_ERR_ORDER after SlipFaultSetUp(); of the run PETSC_ERR_FP for a pressure that is not finite

.seealso: SlipFaultSetField(), SlipFaultSetUp()
@*/
PetscErrorCode SlipFaultSetPressureFunction(SlipFault fault, SlipFaultPressureFn function, void *ctx)
{
  PetscFunctionBegin;
  PetscValidHeaderSpecific(fault, SLIP_FAULT_CLASSID, 1);
  PetscCheck(!fault->setup, fault->comm, PETSC_ERR_ORDER,
             "call SlipFaultSetPressureFunction() before SlipFaultSetUp()");
  fault->loads.function = function;
  fault->loads.ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}
