/* Writes the content of the output file of a run: its layout, the mesh, and the fields. */
#include <slipstep/private/sliprunfiles.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipwork.h>

static const struct {
  const char *name, *unit;
  PetscBool vector; /* a cell has as many numbers as slip has components */
} OutputFields[OUTPUT_NUM_FIELDS] = {
  [OUTPUT_SLIP_RATE] = {"slip_rate", "m/s", PETSC_TRUE},
  [OUTPUT_DISPLACEMENT] = {"displacement", "m", PETSC_TRUE},
  [OUTPUT_SLIP] = {"slip", "m", PETSC_TRUE},
  [OUTPUT_TRACTION] = {"traction", "Pa", PETSC_TRUE},
  [OUTPUT_STATE] = {NULL, NULL, PETSC_FALSE}, /* the law names it */
  [OUTPUT_PORE_PRESSURE] = {"pore_pressure", "Pa", PETSC_FALSE},
  [OUTPUT_NORMAL_STRESS] = {"normal_stress", "Pa", PETSC_FALSE},
  [OUTPUT_TEMPERATURE] = {"temperature", "K", PETSC_FALSE},
  [OUTPUT_ZONE_PRESSURE] = {"shear_zone_pressure", "Pa", PETSC_FALSE},
  [OUTPUT_PERMEABILITY] = {"permeability", "m^2", PETSC_FALSE},
  [OUTPUT_FLUID_FLUX] = {"fluid_flux", "m/s", PETSC_FALSE},
  [OUTPUT_OPENING] = {"opening", "m", PETSC_FALSE},
};

PetscInt SlipFaultOutputCount(SlipFault fault)
{
  return OUTPUT_NUM_FIELDS + fault->layout.states - 1;
}

/* Returns the state of friction that a field is; -1: none. */
static PetscInt StateOf(PetscInt f)
{
  return f == OUTPUT_STATE ? 0 : f < OUTPUT_NUM_FIELDS ? -1 : f - OUTPUT_NUM_FIELDS + 1;
}

/* Returns the name of a field of /fields. */
const char *SlipFaultOutputField(SlipFault fault, PetscInt f)
{
  return StateOf(f) < 0 ? OutputFields[f].name : SlipFrictionStateName(fault->friction.law, StateOf(f));
}

/* Returns how many numbers a cell has of a field. */
PetscInt SlipFaultOutputComponents(SlipFault fault, PetscInt f)
{
  if (f == OUTPUT_FLUID_FLUX) return 2; /* along strike and down dip */
  return StateOf(f) < 0 && OutputFields[f].vector ? fault->layout.plane : 1;
}

/* Finds the fields that -fault_output_fields names, and creates the output of the run. Collective. */
PetscErrorCode SlipFaultOutputCreateRun(SlipFaultOutput out, TS ts)
{
  SlipFault fault = out->fault;
  char **names, states[SLIP_MAX_STATES * FAULT_MAX_NAME];
  int n;

  PetscFunctionBegin;
  PetscCall(PetscStrToArray(fault->options.text[FAULT_OUTPUT_FIELDS], ',', &n, &names));
  for (int i = 0; i < n; i++) {
    PetscBool same = PETSC_FALSE;

    for (PetscInt f = 0; f < SlipFaultOutputCount(fault) && !same; f++) {
      PetscCall(PetscStrcmp(names[i], SlipFaultOutputField(fault, f), &same));
      if (same) out->wanted[f] = PETSC_TRUE;
    }
    if (!same) {
      states[0] = '\0';
      for (PetscInt k = 0; k < fault->layout.states; k++) {
        if (k) PetscCall(PetscStrlcat(states, ", ", sizeof(states)));
        PetscCall(PetscStrlcat(states, SlipFrictionStateName(fault->friction.law, k), sizeof(states)));
      }
    }
    PetscCheck(
      same, fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
      "-%sfault_output_fields has \"%s\", expected slip_rate, slip, displacement, traction, %s, pore_pressure, "
      "normal_stress, temperature, shear_zone_pressure, permeability, fluid_flux or opening",
      SlipFaultPrefix(fault), names[i], states);
  }
  if (SlipFaultOpens(fault)) out->wanted[OUTPUT_OPENING] = PETSC_TRUE; /* without it slip_rate and the others mislead */
  PetscCall(PetscStrToArrayDestroy(n, names));
  PetscCall(SlipFaultSeriesCreate(fault, ts));
  PetscCall(
    SlipOutputSetOption(fault->run->file, SlipFaultPrefix(fault), "fault_output", fault->options.output_overwrite));
  fault->run->file->kind.restart = "fault_restart";
  fault->run->file->moving_only = PETSC_TRUE; /* friction_power then costs no product with K for each row */
  PetscCall(SlipOutputAddRun(fault->run->file, "stiffness_scaling_factor", fault->operators.scaling));
  PetscCall(SlipOutputAddRun(fault->run->file, "time_scale", fault->operators.tstar));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers a vector of cells and writes it as the dataset /mesh/name. Collective. */
static PetscErrorCode SlipFaultOutputCells(SlipFaultOutput out, const char name[], const char unit[], Vec x)
{
  SlipFault fault = out->fault;
  const PetscReal *a;
  const PetscInt *const dims = fault->mesh.dims, ndim = fault->mesh.ndim;
  char path[64];
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(VecScatterBegin(out->gather_c, x, out->c0, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(out->gather_c, x, out->c0, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/mesh/%s", name));
  PetscCall(VecGetArrayRead(out->c0, &a));
  if (!out->rank)
    ierr = SlipH5WriteReal(SlipOutputFile(out->fault->run->file), path, ndim, dims, a, unit[0] ? unit : "1");
  PetscCall(VecRestoreArrayRead(out->c0, &a));
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: computes slip [N], or [N][2], from the gathered state where s is not the slip, as with healing or two
   components; NULL for others. The caller frees it. */
static PetscErrorCode SlipOfDisplacement(SlipFaultOutput out, PetscReal time, const PetscReal w[], PetscReal **slip)
{
  const PetscInt c = out->fault->layout.components, plane = out->fault->layout.plane;
  const PetscReal *u, *v;

  PetscFunctionBegin;
  *slip = NULL;
  if (!out->start0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(plane * out->fault->mesh.N, slip));
  PetscCall(VecGetArrayRead(out->start0, &u));
  PetscCall(VecGetArrayRead(out->vinf0, &v));
  for (PetscInt e = 0; e < out->fault->mesh.N; e++)
    for (PetscInt k = 0; k < plane; k++)
      (*slip)[plane * e + k] = w[SlipFaultDisplacementAt(out->fault, e) + k] - u[c * e + k] + time * v[c * e + k];
  PetscCall(VecRestoreArrayRead(out->vinf0, &v));
  PetscCall(VecRestoreArrayRead(out->start0, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the numbers from an offset in the block of each cell, as many as slip has components; those of one component
   stay in place, others are copied. */
static PetscErrorCode TakeVector(SlipFault fault, const PetscReal w[], PetscInt block, PetscInt offset,
                                 PetscReal **copy, SlipH5Rows *rows)
{
  const PetscInt c = fault->layout.plane, N = fault->mesh.N;

  PetscFunctionBegin;
  *copy = NULL;
  rows->data = w + offset;
  rows->stride = block;
  if (c == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(c * N + 1, copy));
  for (PetscInt e = 0; e < N; e++)
    for (PetscInt k = 0; k < c; k++) (*copy)[c * e + k] = w[block * e + offset + k];
  rows->data = *copy;
  rows->stride = 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes an entry of every wanted field from the gathered state and reaction, which is weighted by area. */
static PetscErrorCode SlipFaultOutputWriteFields(SlipFaultOutput out, PetscReal time)
{
  const SlipFaultMesh *mesh = &out->fault->mesh;
  const SlipFaultLayout *layout = &out->fault->layout;
  const PetscReal *w;
  PetscReal *r, *slip, *copy[OUTPUT_MAX_FIELDS] = {NULL};
  char path[OUTPUT_MAX_FIELDS][64];
  PetscReal rest, now = SlipTwoSum(out->fault->loads.origin, time, &rest);
  SlipH5Rows series[2 + OUTPUT_MAX_FIELDS] = {{"/fields/time", &now, 1}, {"/fields/time_rest", &rest, 1}};
  PetscInt n = out->rests ? 2 : 1;
  const SlipArrays arrays[] = {{out->w0, .read = &w}, {out->r0, .write = &r}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt e = 0; e < mesh->N && mesh->unit > 0; e++) {
    SlipFaultCell cell;

    mesh->kind->cell(mesh, e, &cell);
    for (PetscInt k = layout->components * e; k < layout->components * (e + 1); k++)
      r[k] /= mesh->unit * cell.size[0] * cell.size[1];
  }
  PetscCall(SlipOfDisplacement(out, now, w, &slip));
  for (PetscInt f = 0; f < SlipFaultOutputCount(out->fault); f++) {
    SlipH5Rows *rows = &series[n];

    if (!out->wanted[f]) continue;
    n++;
    PetscCall(PetscSNPrintf(path[f], sizeof(path[f]), "/fields/%s", SlipFaultOutputField(out->fault, f)));
    *rows = (SlipH5Rows){path[f], NULL, 1};
    switch (f) {
    case OUTPUT_TRACTION:
      PetscCall(TakeVector(out->fault, r, layout->components, 0, &copy[f], rows));
      break;
    case OUTPUT_OPENING:
      rows->data = w + layout->displacement + layout->plane;
      rows->stride = layout->block;
      break;
    case OUTPUT_PORE_PRESSURE:
    case OUTPUT_NORMAL_STRESS:
    case OUTPUT_TEMPERATURE:
    case OUTPUT_ZONE_PRESSURE:
    case OUTPUT_PERMEABILITY:
    case OUTPUT_FLUID_FLUX:
      PetscCall(VecGetArrayRead(out->of[f], &rows->data));
      break;
    case OUTPUT_SLIP_RATE:
      PetscCall(TakeVector(out->fault, w, layout->block, layout->rate, &copy[f], rows));
      break;
    case OUTPUT_DISPLACEMENT:
      PetscCall(TakeVector(out->fault, w, layout->block, layout->displacement, &copy[f], rows));
      break;
    default: /* the first state, which is the slip of most faults */
      rows->data = f == OUTPUT_SLIP && out->start0 ? slip : w + layout->state + PetscMax(StateOf(f), 0);
      if (rows->data != slip) rows->stride = layout->block;
    }
  }
  SlipWorkAdd(SLIP_WORK_PIECE, (PetscReal)n);
  SlipWorkAdd(SLIP_WORK_NUMBER, (PetscReal)n * (PetscReal)mesh->N);
  PetscCall(SlipH5AppendAll(SlipOutputFile(out->fault->run->file), n, series, 1));
  for (PetscInt f = 0; f < OUTPUT_MAX_FIELDS; f++) PetscCall(PetscFree(copy[f]));
  for (PetscInt f = 0, k = out->rests ? 2 : 1; f < SlipFaultOutputCount(out->fault); f++) {
    if (f < OUTPUT_NUM_FIELDS && out->wanted[f] && out->of[f])
      PetscCall(VecRestoreArrayRead(out->of[f], &series[k].data));
    k += out->wanted[f] ? 1 : 0;
  }
  PetscCall(PetscFree(slip));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FieldStorage(SlipFault fault, SlipH5Storage *storage)
{
  PetscFunctionBegin;
  *storage = (SlipH5Storage){.deflate = (PetscInt)fault->options.value[FAULT_OUTPUT_COMPRESSION]};
  PetscCall(PetscStrcmp(fault->options.text[FAULT_OUTPUT_PRECISION], "single", &storage->single));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: cuts the fields of an earlier run; new entries have their storage. */
static PetscErrorCode SlipFaultOutputCut(SlipFaultOutput out)
{
  SlipH5 *h = SlipOutputFile(out->fault->run->file);
  const char *prefix = SlipFaultPrefix(out->fault);
  SlipH5Storage storage, stored;
  PetscInt found, wanted = 1;
  char path[64];

  PetscFunctionBegin;
  PetscCall(FieldStorage(out->fault, &storage));
  PetscCall(SlipH5SetRows(h, "/fields/time", out->fault->run->entries));
  PetscCall(SlipTableRest(out->fault->run->file->clock, h, "/fields/time_rest", 0, NULL, out->fault->run->entries,
                          &out->rests));
  if (out->rests) wanted++;
  for (PetscInt f = 0; f < SlipFaultOutputCount(out->fault); f++) {
    if (!out->wanted[f]) continue;
    wanted++;
    PetscCall(PetscSNPrintf(path, sizeof(path), "/fields/%s", SlipFaultOutputField(out->fault, f)));
    PetscCall(SlipH5SetRows(h, path, out->fault->run->entries));
    PetscCall(SlipH5GetStorage(h, path, &stored));
    PetscCheck(stored.single == storage.single && stored.deflate == storage.deflate, PETSC_COMM_SELF,
               PETSC_ERR_FILE_UNEXPECTED,
               "%s in %s is stored otherwise: expected -%sfault_output_precision %s -%sfault_output_compression "
               "%" PetscInt_FMT ", or another -%sfault_output",
               path, h->target, prefix, stored.single ? "single" : "double", prefix, stored.deflate, prefix);
  }
  PetscCall(SlipH5CountMembers(h, "/fields", &found));
  PetscCheck(found == wanted, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "/fields in %s has other datasets than the %" PetscInt_FMT " that -%sfault_output_fields names", h->target,
             wanted - 1, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes /parameters, and creates the series of the fields, and the axes or cells. */
static PetscErrorCode SlipFaultOutputCreateFields(SlipFaultOutput out)
{
  SlipFault fault = out->fault;
  SlipH5 *h = SlipOutputFile(out->fault->run->file);
  const PetscInt *const dims = fault->mesh.dims, ndim = fault->mesh.ndim;
  SlipH5Storage storage;
  char path[64];

  PetscFunctionBegin;
  PetscCall(FieldStorage(fault, &storage));
  PetscCall(SlipH5Group(h, "/parameters", PETSC_FALSE));
  for (PetscInt id = 0; id < FAULT_NUM_REALS; id++) {
    PetscReal value;

    /* one number for all cells that affects the results, not their output */
    if (SlipFaultFieldOf(id) >= 0 || id >= FAULT_OUTPUT_INTERVAL || (ndim == 1 && id < MESH_REALS)) continue;
    PetscCall(SlipFaultGetReal(fault, SlipFaultReals[id].name, &value));
    PetscCall(SlipH5WriteAttrReal(h, "/parameters", SlipFaultReals[id].name, value));
  }
  for (PetscInt id = 0; id <= FAULT_STIFFNESS_SCALING; id++)
    if (SlipFaultStrings[id].choices || id == FAULT_FRICTION_LAW)
      PetscCall(SlipH5WriteAttrString(h, "/parameters", SlipFaultStrings[id].name, SlipFaultGetText(fault, id)));
  for (PetscInt id = FAULT_REGIONAL_STRESS; id <= FAULT_NUCLEATION; id++)
    if (fault->options.text[id][0] && id != FAULT_STRESS_HISTORY &&
        (id > FAULT_STRESS_HISTORY || fault->fields.regional))
      PetscCall(SlipH5WriteAttrString(h, "/parameters", SlipFaultStrings[id].name, fault->options.text[id]));
  for (PetscInt id = FAULT_PERMEABILITY_LAW; id <= FAULT_WELLS && fault->kind.flows; id++)
    if (fault->options.text[id][0])
      PetscCall(SlipH5WriteAttrString(h, "/parameters", SlipFaultStrings[id].name, fault->options.text[id]));
  PetscCall(SlipH5WriteAttrInt(h, "/parameters", "inertia", fault->kind.inertia));
  PetscCall(SlipH5WriteAttrInt(h, "/parameters", "opening", SlipFaultOpens(fault)));
  PetscCall(SlipH5WriteAttrReal(h, "/parameters", "area", fault->mesh.area * (PetscReal)fault->mesh.N));
  PetscCall(SlipFaultSeriesName(fault, h));
  PetscCall(SlipH5CreateSeries(h, "/fields/time", 0, NULL, NULL, "s"));
  PetscCall(SlipTableRest(fault->run->file->clock, h, "/fields/time_rest", 0, NULL, -1, &out->rests));
  for (PetscInt f = 0; f < SlipFaultOutputCount(fault); f++) {
    const PetscInt c = SlipFaultOutputComponents(fault, f), all[] = {dims[0], ndim == 2 ? dims[1] : c, c};

    if (!out->wanted[f]) continue;
    PetscCall(PetscSNPrintf(path, sizeof(path), "/fields/%s", SlipFaultOutputField(fault, f)));
    PetscCall(SlipH5CreateSeries(h, path, c > 1 ? ndim + 1 : ndim, all, &storage,
                                 StateOf(f) < 0 ? OutputFields[f].unit
                                                : SlipFrictionStateUnit(fault->friction.law, StateOf(f))));
  }
  PetscCall(fault->mesh.kind->write(&fault->mesh, h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: names the dimensions of /mesh, and of a group whose datasets have rows with a number for each cell; both
   have the axes. */
PetscErrorCode SlipFaultNameDimensions(SlipFault fault, SlipH5 *h, const char group[], const char row[])
{
  static const char *const grid[] = {"z", "x"}, *const list[] = {"cell", "vertex"};
  const PetscBool two = fault->mesh.ndim == 2 ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt sizes[] = {fault->mesh.N, fault->mesh.npoints};
  SlipH5Axes axes = {.n = 2, .axis = two ? grid : list};
  char path[64], name[64];
  PetscBool triangles;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, "/mesh/vertices", &triangles));
  if (!two && !triangles) axes.n = 1;
  for (PetscInt i = 0; i < axes.n && !two; i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "/mesh/%s", list[i]));
    PetscCall(SlipH5MakeDimension(h, path, sizes[i]));
  }
  PetscCall(SlipH5NameDimensions(h, "/mesh", &axes));
  if (!group) PetscFunctionReturn(PETSC_SUCCESS);
  axes.row = row;
  axes.n = fault->mesh.ndim;
  for (PetscInt i = 0; i < axes.n; i++) {
    PetscCall(PetscSNPrintf(path, sizeof(path), "/mesh/%s", axes.axis[i]));
    PetscCall(PetscSNPrintf(name, sizeof(name), "%s/%s", group, axes.axis[i]));
    PetscCall(SlipH5Link(h, path, name));
  }
  PetscCall(SlipH5NameDimensions(h, group, &axes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to the run's file what is specific to a fault. Collective. */
PetscErrorCode SlipFaultOutputLayout(SlipFault fault, SlipOutput run, void *ctx)
{
  SlipFaultOutput out = (SlipFaultOutput)ctx;
  PetscErrorCode ierr = PETSC_SUCCESS;
  const SlipParameter *p;
  PetscReal *a;
  Vec x;

  PetscFunctionBegin;
  (void)run;
  if (!out->rank) ierr = out->resumed ? SlipFaultOutputCut(out) : SlipFaultOutputCreateFields(out);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  if (out->resumed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(fault->cells, &x));
  for (PetscInt f = 0; (p = SlipFaultFieldRow(f)); f++) {
    if (!SlipFaultHasField(fault, f)) continue;
    PetscCall(VecGetArrayWrite(x, &a));
    PetscCall(PetscArraycpy(a, fault->fields.cell[f], fault->mesh.n));
    PetscCall(VecRestoreArrayWrite(x, &a));
    PetscCall(SlipFaultOutputCells(out, p->name, p->unit, x));
  }
  if (fault->fields.tendency) {
    PetscCall(VecGetArrayWrite(x, &a));
    PetscCall(PetscArraycpy(a, fault->fields.tendency, fault->mesh.n));
    PetscCall(VecRestoreArrayWrite(x, &a));
    PetscCall(SlipFaultOutputCells(out, "slip_tendency", "1", x));
  }
  if (fault->critical.known) { /* along the rake */
    const PetscReal *uc;

    PetscCall(VecGetArrayRead(fault->critical.uc, &uc));
    PetscCall(VecGetArrayWrite(x, &a));
    for (PetscInt i = 0; i < fault->mesh.n; i++)
      a[i] = SlipFaultDot(fault, uc + fault->layout.components * i, SlipFaultAlong(fault, i));
    PetscCall(VecRestoreArrayWrite(x, &a));
    PetscCall(VecRestoreArrayRead(fault->critical.uc, &uc));
    PetscCall(SlipFaultOutputCells(out, "critical_displacement", "m", x));
  }
  PetscCall(VecDestroy(&x));
  if (!out->rank) ierr = SlipFaultNameDimensions(fault, SlipOutputFile(run), "/fields", "time");
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the state with friction's states as output shows them: w itself, or a copy. Collective. */
static PetscErrorCode ShowState(SlipFaultOutput out, PetscReal t, Vec w, Vec *shown)
{
  SlipFault fault = out->fault;
  SlipFrictionCells friction;
  PetscBool any = PETSC_FALSE;
  PetscReal *a;

  PetscFunctionBegin;
  *shown = w;
  for (PetscInt f = 0; f < SlipFaultOutputCount(fault); f++)
    if (out->wanted[f] && StateOf(f) >= 0) any = PETSC_TRUE;
  if (!any || !fault->friction.law->nstates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
  if (!out->shown) PetscCall(VecDuplicate(w, &out->shown));
  PetscCall(VecCopy(w, out->shown));
  PetscCall(VecGetArray(out->shown, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = 0, at = SlipFaultStateAt(fault, i); k < fault->layout.states; k++)
      a[at + k] = SlipFrictionShown(&friction, i, k, a[at + k]);
  PetscCall(VecRestoreArray(out->shown, &a));
  *shown = out->shown;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers in out->of[f] the flux of pore fluid, two numbers of each cell. Collective. */
static PetscErrorCode GatherFlux(SlipFaultOutput out, PetscReal time, PetscInt f)
{
  SlipFault fault = out->fault;
  const PetscReal *one;
  PetscReal *flux, *x, *both;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(out->c0, &N));
  if (!out->numbers) PetscCall(VecDuplicate(fault->cells, &out->numbers));
  if (!out->of[f]) PetscCall(VecCreateSeq(PETSC_COMM_SELF, 2 * N, &out->of[f]));
  PetscCall(PetscMalloc1(2 * fault->mesh.n + 1, &flux));
  PetscCall(SlipFaultFluidFlow(fault, time, NULL, flux));
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(VecGetArrayWrite(out->numbers, &x));
    for (PetscInt i = 0; i < fault->mesh.n; i++) x[i] = flux[2 * i + k];
    PetscCall(VecRestoreArrayWrite(out->numbers, &x));
    PetscCall(VecScatterBegin(out->gather_c, out->numbers, out->c0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(out->gather_c, out->numbers, out->c0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecGetArrayRead(out->c0, &one));
    PetscCall(VecGetArray(out->of[f], &both));
    for (PetscInt e = 0; e < N; e++) both[2 * e + k] = one[e];
    PetscCall(VecRestoreArray(out->of[f], &both));
    PetscCall(VecRestoreArrayRead(out->c0, &one));
  }
  PetscCall(PetscFree(flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gathers in out->of[f] a number of each cell that is no part of the state w. Collective. */
static PetscErrorCode GatherNumbers(SlipFaultOutput out, PetscReal time, Vec w, PetscInt f)
{
  SlipFault fault = out->fault;
  SlipFrictionCells friction;
  PetscReal *x;

  PetscFunctionBegin;
  if (!out->numbers) PetscCall(VecDuplicate(fault->cells, &out->numbers));
  if (!out->of[f]) PetscCall(VecDuplicate(out->c0, &out->of[f]));
  PetscCall(VecGetArrayWrite(out->numbers, &x));
  if (f != OUTPUT_PORE_PRESSURE && f != OUTPUT_PERMEABILITY)
    PetscCall(SlipFaultGetFrictionOf(fault, time, w, &friction));
  if (f == OUTPUT_PORE_PRESSURE)
    PetscCall(SlipLoadsPressures(&fault->loads, time, PETSC_TRUE, x));
  else if (f == OUTPUT_PERMEABILITY)
    PetscCall(SlipFaultFluidFlow(fault, time, x, NULL));
  else if (f == OUTPUT_NORMAL_STRESS)
    PetscCall(PetscArraycpy(x, friction.stress, fault->mesh.n));
  else
    PetscCall(SlipFaultZoneValues(fault, time, w, &friction, fault->mesh.n, NULL, f == OUTPUT_TEMPERATURE ? x : NULL,
                                  f == OUTPUT_TEMPERATURE ? NULL : x));
  PetscCall(VecRestoreArrayWrite(out->numbers, &x));
  PetscCall(VecScatterBegin(out->gather_c, out->numbers, out->of[f], INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(out->gather_c, out->numbers, out->of[f], INSERT_VALUES, SCATTER_FORWARD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes an entry of /fields. Collective. */
PetscErrorCode SlipFaultOutputFields(SlipFaultOutput out, PetscReal time, Vec w)
{
  SlipFault fault = out->fault;
  PetscErrorCode ierr = PETSC_SUCCESS;
  Vec shown, traction;

  PetscFunctionBegin;
  PetscCall(SlipLogOutputBegin());
  PetscCall(SlipOutputBegin(fault->run->file));
  /* the slip of a fault that heals is relative to the start and the loading rate */
  if ((fault->kind.heals || fault->friction.law->nstates || fault->layout.components > 1) && !out->start0) {
    PetscCall(VecDuplicate(out->r0, &out->start0));
    PetscCall(VecDuplicate(out->r0, &out->vinf0));
    PetscCall(VecScatterBegin(out->gather_r, fault->critical.uc, out->start0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(out->gather_r, fault->critical.uc, out->start0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScale(out->start0, fault->critical.start_share));
    PetscCall(VecScatterBegin(out->gather_r, fault->operators.vinf, out->vinf0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(out->gather_r, fault->operators.vinf, out->vinf0, INSERT_VALUES, SCATTER_FORWARD));
  }
  PetscCall(ShowState(out, time, w, &shown));
  PetscCall(VecScatterBegin(out->gather_w, shown, out->w0, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(out->gather_w, shown, out->w0, INSERT_VALUES, SCATTER_FORWARD));
  if (out->wanted[OUTPUT_TRACTION]) {
    PetscCall(SlipFaultStepTraction(fault, time, w, &traction));
    PetscCall(VecScatterBegin(out->gather_r, traction, out->r0, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(out->gather_r, traction, out->r0, INSERT_VALUES, SCATTER_FORWARD));
  }
  for (PetscInt f = OUTPUT_PORE_PRESSURE; f <= OUTPUT_PERMEABILITY; f++)
    if (out->wanted[f]) PetscCall(GatherNumbers(out, time, w, f));
  if (out->wanted[OUTPUT_FLUID_FLUX]) PetscCall(GatherFlux(out, time, OUTPUT_FLUID_FLUX));
  if (!out->rank) ierr = SlipFaultOutputWriteFields(out, time);
  fault->run->entries++;
  fault->run->entry_time = fault->loads.origin + time;
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}
