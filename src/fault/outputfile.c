/* What the output file of a run holds: its layout, the mesh, and the fields. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipsys.h>

static const SlipOutputColumn SeriesColumns[] = {
  {"mean_slip_rate", "m/s", PETSC_FALSE},   {"max_slip_rate", "m/s", PETSC_FALSE},
  {"mean_slip", "m", PETSC_FALSE},          {"mean_displacement", "m", PETSC_FALSE},
  {"sliding_fraction", "1", PETSC_FALSE},   {"kinetic_energy", "J/m^2", PETSC_FALSE},
  {"elastic_energy", "J/m^2", PETSC_FALSE}, {"viscous_power", "W/m^2", PETSC_FALSE},
  {"friction_power", "W/m^2", PETSC_FALSE}, {"loading_power", "W/m^2", PETSC_FALSE},
};

static const struct {
  const char *name, *unit;
  PetscInt component; /* of the state's block; -1: the reaction */
} OutputFields[OUTPUT_NUM_FIELDS] = {
  [OUTPUT_SLIP_RATE] = {"slip_rate", "m/s", 0},
  [OUTPUT_DISPLACEMENT] = {"displacement", "m", 1},
  [OUTPUT_SLIP] = {"slip", "m", 2},
  [OUTPUT_TRACTION] = {"traction", "Pa", -1},
};

static PetscErrorCode SlipFaultOutputSeries(TS ts, PetscReal t, Vec w, Vec r, PetscReal row[], void *ctx)
{
  SlipFaultObservables o;

  PetscFunctionBegin;
  (void)ts;
  (void)t;
  PetscCall(SlipFaultGetObservables((SlipFault)ctx, w, r, &o));
  {
    const PetscReal values[] = {o.mean_slip_rate,   o.max_slip_rate, o.mean_slip, o.mean_displacement,
                                o.sliding_fraction, o.kinetic,       o.elastic,   o.viscous_power,
                                o.friction_power,   o.loading_power};

    PetscCall(PetscArraycpy(row, values, PETSC_STATIC_ARRAY_LENGTH(values)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective: which fields -fault_output_fields names, and the output of the run. */
PetscErrorCode SlipFaultOutputCreateRun(SlipFaultOutput out, TS ts)
{
  SlipFault fault = out->fault;
  char **names;
  int n;

  PetscFunctionBegin;
  PetscCall(PetscStrToArray(fault->text[FAULT_OUTPUT_FIELDS], ',', &n, &names));
  for (int i = 0; i < n; i++) {
    PetscBool same = PETSC_FALSE;

    for (PetscInt f = 0; f < OUTPUT_NUM_FIELDS && !same; f++) {
      PetscCall(PetscStrcmp(names[i], OutputFields[f].name, &same));
      if (same) out->wanted[f] = PETSC_TRUE;
    }
    PetscCheck(same, fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
               "-%sfault_output_fields has \"%s\", expected slip_rate, slip, displacement or traction",
               SlipFaultPrefix(fault), names[i]);
  }
  PetscCall(PetscStrToArrayDestroy(n, names));
  PetscCall(SlipOutputCreate(ts, fault->text[FAULT_OUTPUT], PETSC_STATIC_ARRAY_LENGTH(SeriesColumns), SeriesColumns,
                             SlipFaultOutputSeries, fault, &out->run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shape of a field in the file, [Nz, Nx], or [n] for a mesh. */
static PetscInt FieldShape(SlipFault fault, PetscInt dims[2])
{
  dims[0] = fault->mesh.n ? (PetscInt)fault->value[FAULT_NX] : (PetscInt)fault->value[FAULT_NZ];
  dims[1] = (PetscInt)fault->value[FAULT_NX];
  return fault->mesh.n ? 1 : 2;
}

static PetscErrorCode SlipFaultOutputAxes(SlipFaultOutput out)
{
  SlipFault fault = out->fault;
  const PetscInt nx = (PetscInt)fault->value[FAULT_NX], nz = (PetscInt)fault->value[FAULT_NZ];
  PetscReal *x, *z, other;

  PetscFunctionBegin;
  if (fault->mesh.n) {
    PetscCall(SlipFaultMeshWrite(fault, out->file));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc2(nx, &x, nz, &z));
  for (PetscInt i = 0; i < nx; i++) PetscCall(SlipFaultCellCentre(fault, i, &x[i], &other));
  for (PetscInt i = 0; i < nz; i++) PetscCall(SlipFaultCellCentre(fault, i * nx, &other, &z[i]));
  PetscCall(SlipH5WriteReal(out->file, "/mesh/x", 1, &nx, x, "m"));
  PetscCall(SlipH5WriteReal(out->file, "/mesh/z", 1, &nz, z, "m"));
  PetscCall(SlipH5WriteAttrInt(out->file, "/mesh", "nx", nx));
  PetscCall(SlipH5WriteAttrInt(out->file, "/mesh", "nz", nz));
  PetscCall(PetscFree2(x, z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A reduced vector's values, gathered, as the dataset /mesh/name. Collective. */
static PetscErrorCode SlipFaultOutputCells(SlipFaultOutput out, const char name[], const char unit[], Vec x)
{
  SlipFault fault = out->fault;
  const PetscReal *a;
  PetscInt dims[2], ndim = FieldShape(fault, dims);
  char path[64];
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(VecScatterBegin(out->gather_r, x, out->r0, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(out->gather_r, x, out->r0, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/mesh/%s", name));
  PetscCall(VecGetArrayRead(out->r0, &a));
  if (!out->rank) ierr = SlipH5WriteReal(out->file, path, ndim, dims, a, unit[0] ? unit : "1");
  PetscCall(VecRestoreArrayRead(out->r0, &a));
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: one entry of every field wanted, from the gathered state and reaction; the reaction is weighted by area. */
static PetscErrorCode SlipFaultOutputWriteFields(SlipFaultOutput out)
{
  const PetscInt N = out->fault->N;
  const SlipCells *mesh = &out->fault->mesh;
  const PetscReal unit = mesh->n ? 2 * SlipCellsUnit(mesh) : 1;
  const PetscReal *w, *r;
  PetscReal *x;
  char path[64];
  const SlipArrays arrays[] = {{out->w0, .read = &w}, {out->r0, .read = &r}};

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(N, &x));
  PetscCall(SlipArraysGet(2, arrays));
  PetscCall(SlipH5Append(out->file, "/fields/time", 1, &out->time));
  for (PetscInt f = 0; f < OUTPUT_NUM_FIELDS; f++) {
    const PetscInt c = OutputFields[f].component;

    if (!out->wanted[f]) continue;
    for (PetscInt e = 0; e < N; e++) x[e] = c < 0 ? r[e] : w[3 * e + c];
    for (PetscInt e = 0; c < 0 && e < mesh->n; e++) x[e] /= unit * mesh->length[e] * mesh->width[e];
    PetscCall(PetscSNPrintf(path, sizeof(path), "/fields/%s", OutputFields[f].name));
    PetscCall(SlipH5Append(out->file, path, 1, x));
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: series of the fields, those of the start, and the axes or cells. */
static PetscErrorCode SlipFaultOutputLayout(SlipFaultOutput out)
{
  SlipFault fault = out->fault;
  PetscInt dims[2], ndim = FieldShape(fault, dims);
  char path[64];

  PetscFunctionBegin;
  PetscCall(SlipH5CreateSeries(out->file, "/fields/time", 0, NULL, PETSC_FALSE, "s"));
  for (PetscInt f = 0; f < OUTPUT_NUM_FIELDS; f++) {
    if (!out->wanted[f]) continue;
    PetscCall(PetscSNPrintf(path, sizeof(path), "/fields/%s", OutputFields[f].name));
    PetscCall(SlipH5CreateSeries(out->file, path, ndim, dims, PETSC_FALSE, OutputFields[f].unit));
  }
  if (out->gathered) PetscCall(SlipFaultOutputWriteFields(out));
  PetscCall(SlipFaultOutputAxes(out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultOutputBegin(SlipFaultOutput out)
{
  SlipFault fault = out->fault;
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscReal *a;
  Vec x;

  PetscFunctionBegin;
  if (out->begun) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(out->run));
  out->begun = PETSC_TRUE;
  out->file = SlipOutputFile(out->run);
  if (!out->rank) ierr = SlipFaultOutputLayout(out);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(VecDuplicate(fault->uc, &x));
  for (PetscInt f = 0; f < FAULT_NUM_FIELDS; f++) {
    const SlipFaultReal *p = &SlipFaultReals[SlipFaultFields[f]];

    PetscCall(VecGetArrayWrite(x, &a));
    PetscCall(PetscArraycpy(a, fault->field[f], fault->n));
    PetscCall(VecRestoreArrayWrite(x, &a));
    PetscCall(SlipFaultOutputCells(out, p->name, p->unit, x));
  }
  PetscCall(VecDestroy(&x));
  PetscCall(SlipFaultOutputCells(out, "critical_displacement", "m", fault->uc));
  PetscCall(SlipLogOutputEnd());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective: gathered, and written when the file is there, else when it is made. r may be NULL: the traction is then
   not known and written as zero. */
PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w, Vec r)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipLogOutputBegin());
  PetscCall(VecScatterBegin(out->gather_w, w, out->w0, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(out->gather_w, w, out->w0, INSERT_VALUES, SCATTER_FORWARD));
  if (r) {
    PetscCall(VecScatterBegin(out->gather_r, r, out->r0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(out->gather_r, r, out->r0, INSERT_VALUES, SCATTER_FORWARD));
  } else
    PetscCall(VecZeroEntries(out->r0));
  out->time = time;
  out->gathered = PETSC_TRUE;
  if (out->file) ierr = SlipFaultOutputWriteFields(out);
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(out->fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}
