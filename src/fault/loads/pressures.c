/* The pore pressures of a fault, a row of a table each: a record, a point source, a function of the caller, and fluid
   that diffuses in the cells. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultwells.h>
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
static PetscErrorCode RecordSetUp(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;
  PetscReal *times = NULL, *all = NULL, *row;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;
  SlipH5 h;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_PORE_PRESSURE][0]) PetscFunctionReturn(PETSC_SUCCESS);
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

static PetscErrorCode RecordAdd(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  PetscFunctionBegin;
  SlipLoadsAddRecord(loads, t, p);
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

/* p = p* [E1(r^2/(4 D t)) - E1(r^2/(4 D (t - stop)))]. A cell around the source gets the mean pressure over a disc of
   equal area, for which r has a lower bound. */
static PetscErrorCode SourceAdd(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  const PetscReal scale = loads->source.pressure, stop = loads->source.stop, D = loads->source.diffusivity;

  PetscFunctionBegin;
  SlipWorkAdd(SLIP_WORK_SOURCE, (PetscReal)loads->n * ((t > 0) + (stop > 0 && t > stop)));
  for (PetscInt i = 0; i < loads->n; i++) {
    if (t > 0) p[i] += scale * SlipExponentialIntegral(loads->source.distance2[i] / (4 * D * t));
    if (stop > 0 && t > stop)
      p[i] -= scale * SlipExponentialIntegral(loads->source.distance2[i] / (4 * D * (t - stop)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal SourceEnd(const SlipFaultLoads *loads, PetscReal t)
{
  return loads->source.stop > SlipTimeAfter(t) ? loads->source.stop : NEVER;
}

static PetscReal SourceScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration)
{
  const PetscReal stop = loads->source.stop;

  (void)duration;
  return (stop > 0 && t >= stop ? t - stop : t) / 20 + loads->source.time / 1000;
}

/* ---- the function of SlipFaultSetPressureFunction() ---- */

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

static PetscErrorCode FunctionSetUp(SlipFault fault)
{
  PetscFunctionBegin;
  if (fault->loads.function) PetscCall(PetscMalloc1(PetscMax(fault->mesh.n, 1), &fault->loads.own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FunctionAdd(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  PetscFunctionBegin;
  PetscCall(SlipLoadsOwnPressure(loads, t));
  for (PetscInt i = 0; i < loads->n; i++) p[i] += loads->own[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal FunctionScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration)
{
  (void)loads, (void)t;
  return duration / 1000;
}

/* ---- fluid.c ---- */

static PetscErrorCode Given(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  PetscFunctionBegin;
  PetscCall(SlipLoadsPressures(loads, t, PETSC_FALSE, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FluidSetUp(SlipFault fault)
{
  PetscFunctionBegin;
  fault->fluid.given = Given;
  fault->fluid.change = SlipLoadsPressuresEnd;
  PetscCall(SlipFaultWellsSetUp(fault));
  PetscCall(SlipFaultFluidSetUp(fault));
  PetscCall(SlipFaultFluidWarn(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FluidAdd(const SlipFaultLoads *loads, PetscReal t, PetscReal p[])
{
  PetscFunctionBegin;
  PetscCall(SlipFaultFluidPressure(loads->fault, t, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal FluidEnd(const SlipFaultLoads *loads, PetscReal t)
{
  PetscReal next = NEVER;

  for (PetscInt k = 0; k < loads->nwells; k++) next = PetscMin(next, SlipFaultWellNext(&loads->wells[k], t));
  return next;
}

static PetscReal FluidScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration)
{
  (void)duration;
  return SlipFaultFluidScale(loads->fault, t);
}

/* ---- all of them ---- */

static PetscBool HasRecord(const SlipFaultLoads *loads)
{
  return loads->rows > 0 ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool HasSource(const SlipFaultLoads *loads)
{
  return loads->source.distance2 ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool HasFunction(const SlipFaultLoads *loads)
{
  return loads->function ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool HasFluid(const SlipFaultLoads *loads)
{
  return loads->fault->fluid.on;
}

static const struct {
  PetscErrorCode (*setup)(SlipFault fault);
  PetscBool (*on)(const SlipFaultLoads *loads);                                     /* after the set-up */
  PetscErrorCode (*add)(const SlipFaultLoads *loads, PetscReal t, PetscReal p[]);   /* to p [n] [Pa], at t */
  PetscReal (*end)(const SlipFaultLoads *loads, PetscReal t);                       /* the next kink after t that is no
                                                                                     corner of a record; NULL: none */
  PetscReal (*scale)(const SlipFaultLoads *loads, PetscReal t, PetscReal duration); /* for how long after t it is nearly
                                                                                       linear in a run of this duration;
                                                                                       NULL: it is, between corners */
  PetscBool diffuses;
} Rows[] = {{RecordSetUp, HasRecord, RecordAdd, NULL, NULL, PETSC_FALSE},
            {SourceSetUp, HasSource, SourceAdd, SourceEnd, SourceScale, PETSC_FALSE},
            {FunctionSetUp, HasFunction, FunctionAdd, NULL, FunctionScale, PETSC_FALSE},
            {FluidSetUp, HasFluid, FluidAdd, FluidEnd, FluidScale, PETSC_TRUE}};

#define EACH(row, loads)                                                                                               \
  for (size_t row = 0; row < PETSC_STATIC_ARRAY_LENGTH(Rows); row++)                                                   \
    if ((*Rows[row].on)(loads))

/* Sets up all pressures, and says whether there is one. */
PetscErrorCode SlipLoadsPressuresSetUp(SlipFaultLoads *loads)
{
  PetscFunctionBegin;
  for (size_t row = 0; row < PETSC_STATIC_ARRAY_LENGTH(Rows); row++) PetscCall((*Rows[row].setup)(loads->fault));
  EACH(row, loads) loads->pore = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipLoadsPressuresDestroy(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads; /* whose fault is not set before the set-up */

  PetscFunctionBegin;
  PetscCall(PetscFree(loads->times));
  PetscCall(PetscFree(loads->record));
  PetscCall(PetscFree(loads->source.distance2));
  PetscCall(PetscFree(loads->own));
  PetscCall(SlipFaultFluidDestroy(fault));
  PetscCall(SlipFaultWellsDestroy(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the pore pressure of the cells of this process at t [Pa]; diffusing: with that of fluid.c. Collective. */
PetscErrorCode SlipLoadsPressures(const SlipFaultLoads *loads, PetscReal t, PetscBool diffusing, PetscReal p[])
{
  PetscFunctionBegin;
  PetscCall(PetscArrayzero(p, loads->n));
  EACH(row, loads) if (diffusing || !Rows[row].diffuses) PetscCall((*Rows[row].add)(loads, t, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the next time after t at which a pressure has a kink, beside the corners of records; PETSC_MAX_REAL: none */
PetscReal SlipLoadsPressuresEnd(const SlipFaultLoads *loads, PetscReal t)
{
  PetscReal next = NEVER;

  EACH(row, loads) if (Rows[row].end) next = PetscMin(next, (*Rows[row].end)(loads, t));
  return next;
}

/* Returns for how long after t pressures are nearly linear in time. */
PetscReal SlipLoadsPressuresScale(const SlipFaultLoads *loads, PetscReal t, PetscReal duration)
{
  PetscReal scale = NEVER;

  EACH(row, loads) if (Rows[row].scale) scale = PetscMin(scale, (*Rows[row].scale)(loads, t, duration));
  return scale;
}
