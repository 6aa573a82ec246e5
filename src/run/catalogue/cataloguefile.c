/* Writes the file of -fault_catalogue: a dataset for each column, with an entry for each event, the mesh, and maps; and
   visits the catalogue for checkpoints. */
#include <slipstep/private/sliprunfiles.h>
#include <slipstep/private/slipsys.h>
#include <math.h>

/* The columns, in the order of the enumeration; one fault has EVENT_NUM_COLUMNS of them */
static const SlipOutputColumn Columns[EVENT_ALL_COLUMNS] = {
  [EVENT_ONSET] = {"onset", "s", PETSC_FALSE},
  [EVENT_END] = {"end", "s", PETSC_FALSE},
  [EVENT_X] = {"x", "m", PETSC_FALSE},
  [EVENT_Y] = {"y", "m", PETSC_FALSE},
  [EVENT_Z] = {"z", "m", PETSC_FALSE},
  [EVENT_CELL] = {"cell", "1", PETSC_TRUE},
  [EVENT_AREA] = {"area", "m^2", PETSC_FALSE},
  [EVENT_MEAN_SLIP] = {"mean_slip", "m", PETSC_FALSE},
  [EVENT_MAX_SLIP] = {"max_slip", "m", PETSC_FALSE},
  [EVENT_DIRECTION] = {"direction", "1", PETSC_TRUE},
  [EVENT_MOMENT] = {"moment", "N m", PETSC_FALSE},
  [EVENT_MAGNITUDE] = {"magnitude", "1", PETSC_FALSE},
  [EVENT_STRESS_DROP] = {"stress_drop", "Pa", PETSC_FALSE},
  [EVENT_PEAK_SLIP_RATE] = {"peak_slip_rate", "m/s", PETSC_FALSE},
  [EVENT_ELASTIC_ENERGY] = {"elastic_energy", "J", PETSC_FALSE},
  [EVENT_KINETIC_ENERGY] = {"kinetic_energy", "J", PETSC_FALSE},
  [EVENT_DISSIPATED_ENERGY] = {"dissipated_energy", "J", PETSC_FALSE},
  [EVENT_RADIATED_ENERGY] = {"radiated_energy", "J", PETSC_FALSE},
  [EVENT_LOADING_WORK] = {"loading_work", "J", PETSC_FALSE},
  [EVENT_ENERGY_RESIDUAL] = {"energy_residual", "1", PETSC_FALSE},
  [EVENT_STEPS] = {"steps", "1", PETSC_TRUE},
  [EVENT_FAULT] = {"fault", "1", PETSC_TRUE},
  [EVENT_RAKE] = {"rake", "degrees", PETSC_FALSE},
  [EVENT_RUPTURE_SPEED] = {"rupture_speed", "m/s", PETSC_FALSE},
  [EVENT_RADIATED_EFFICIENCY] = {"radiated_efficiency", "1", PETSC_FALSE},
  [EVENT_GOES_ON] = {"goes_on", "1", PETSC_TRUE},
  [EVENT_IMAGES] = {"images", "1", PETSC_TRUE},
  [EVENT_FAULT_MOMENT] = {"fault_moment", "N m", PETSC_FALSE},
  [EVENT_FAULT_AREA] = {"fault_area", "m^2", PETSC_FALSE},
  [EVENT_FAULT_MEAN_SLIP] = {"fault_mean_slip", "m", PETSC_FALSE},
  [EVENT_FAULT_STRESS_DROP] = {"fault_stress_drop", "Pa", PETSC_FALSE},
  [EVENT_FAULT_ONSET] = {"fault_onset", "s", PETSC_FALSE},
  [EVENT_FAULT_CELL] = {"fault_cell", "1", PETSC_TRUE},
  [EVENT_FAULT_DISSIPATED_ENERGY] = {"fault_dissipated_energy", "J", PETSC_FALSE},
};

static const SlipOutputColumn Fluid[EVENT_FLUID_COLUMNS] = {{"well_distance", "m", PETSC_FALSE},
                                                            {"pore_pressure", "Pa", PETSC_FALSE}};

static const char *const Maps[2] = {"/maps/slip", "/maps/rupture_time"}, *const MapUnits[2] = {"m", "s"};

/* Columns with times of the run; only several faults have the last one */
static const PetscInt Times[] = {EVENT_ONSET, EVENT_END, EVENT_FAULT_ONSET};

/* Creates the table; rows: those of the file of an earlier run, or -1 for a new file */
static PetscErrorCode CreateTable(SlipFaultCatalogue cat, PetscInt rows)
{
  const PetscInt n = cat->hypocentre ? EVENT_ALL_COLUMNS : EVENT_NUM_COLUMNS;
  SlipOutputColumn column[EVENT_ALL_COLUMNS + EVENT_FLUID_COLUMNS];
  PetscInt entries[EVENT_ALL_COLUMNS + EVENT_FLUID_COLUMNS] = {0};

  PetscFunctionBegin;
  for (PetscInt c = 0; c < n; c++) {
    column[c] = Columns[c];
    entries[c] = c < EVENT_NUM_COLUMNS ? 0 : cat->fault->mesh.faults;
  }
  for (PetscInt c = 0; c < EVENT_FLUID_COLUMNS; c++) column[n + c] = Fluid[c];
  cat->table.ntimes = cat->hypocentre ? 3 : 2;
  cat->table.times = Times;
  PetscCall(SlipTableCreate(&cat->table, &cat->file, "", n + (cat->fault->kind.flows ? EVENT_FLUID_COLUMNS : 0), column,
                            entries, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(SlipFaultCatalogue cat)
{
  SlipFault fault = cat->fault;
  const PetscInt *const dims = fault->mesh.dims, ndim = fault->mesh.ndim;
  const PetscInt of_slip[] = {dims[0], ndim == 2 ? dims[1] : 2, 2}; /* for two components */
  SlipH5 *h = &cat->file;

  PetscFunctionBegin;
  PetscCall(SlipH5CreateKind(&cat->kind, fault->options.text[FAULT_CATALOGUE], h));
  PetscCall(SlipH5WriteAttrString(h, "/", "format", "slipstep-catalogue"));
  PetscCall(SlipH5WriteAttrInt(h, "/", "version", 1));
  PetscCall(SlipH5WriteAttrString(h, "/", "library_version", SLIPSTEP_VERSION));
  PetscCall(SlipH5WriteAttrReal(h, "/", "shear_modulus", fault->options.value[FAULT_SHEAR_MODULUS]));
  PetscCall(SlipH5WriteAttrReal(h, "/", "poisson_ratio", fault->options.value[FAULT_POISSON_RATIO]));
  PetscCall(SlipH5WriteAttrString(h, "/", "kernel", fault->options.text[FAULT_KERNEL]));
  PetscCall(SlipH5WriteAttrReal(h, "/", "event_rate", fault->options.value[FAULT_EVENT_RATE]));
  PetscCall(SlipH5WriteAttrInt(h, "/", "weakens", fault->resolution.weakens ? 1 : 0));
  PetscCall(SlipH5WriteAttrReal(h, "/", "fault_area", fault->mesh.area * (PetscReal)fault->mesh.N));
  PetscCall(SlipH5WriteAttrInts(h, "/", "faults", fault->mesh.faults, fault->mesh.labels));
  if (ndim == 2) {
    PetscCall(SlipH5WriteAttrReal(h, "/", "length_x", fault->mesh.extent[FAULT_LENGTH_X]));
    PetscCall(SlipH5WriteAttrReal(h, "/", "length_z", fault->mesh.extent[FAULT_LENGTH_Z]));
    PetscCall(SlipH5WriteAttrReal(h, "/", "depth_top", fault->mesh.extent[FAULT_DEPTH_TOP]));
    PetscCall(SlipH5WriteAttrReal(h, "/", "strike", fault->mesh.extent[FAULT_STRIKE]));
    PetscCall(SlipH5WriteAttrReal(h, "/", "dip", fault->mesh.extent[FAULT_DIP]));
  }
  PetscCall(CreateTable(cat, -1));
  for (PetscInt m = 0; m < 2 && cat->maps; m++)
    PetscCall(!m && fault->layout.components > 1 ? SlipH5CreateSeries(h, Maps[m], ndim + 1, of_slip, NULL, MapUnits[m])
                                                 : SlipH5CreateSeries(h, Maps[m], ndim, dims, NULL, MapUnits[m]));
  PetscCall(fault->mesh.kind->write(&fault->mesh, h));
  if (cat->maps) {
    const PetscReal *rake;

    PetscCall(VecGetArrayRead(cat->map[1], &rake));
    PetscCall(SlipH5WriteReal(h, "/mesh/rake", ndim, dims, rake, "degrees"));
    PetscCall(VecRestoreArrayRead(cat->map[1], &rake));
  }
  PetscCall(SlipH5NameDimensions(h, "/", &(SlipH5Axes){.row = "onset", .rest = "fault_index"}));
  if (cat->maps) PetscCall(SlipH5Link(h, "/onset", "/maps/onset"));
  PetscCall(SlipFaultNameDimensions(fault, h, cat->maps ? "/maps" : NULL, "onset"));
  PetscCall(SlipH5Live(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Continues the file of an earlier run, if it is that of the checkpoint, cut to its events. */
static PetscErrorCode Continue(SlipFaultCatalogue cat)
{
  SlipFault fault = cat->fault;
  SlipH5 *h = &cat->file;
  const char *prefix = SlipFaultPrefix(fault);
  const PetscInt rows = fault->run->events;
  PetscReal *end = NULL;
  PetscBool has, same = PETSC_FALSE;
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCall(SlipH5CreateCopy(&cat->kind, NULL, fault->options.text[FAULT_CATALOGUE], h));
  PetscCall(SlipH5Has(h, "/end", &has));
  if (has) PetscCall(SlipH5ReadReal(h, "/end", 1, &n, &end));
  if (has && n >= rows && (!rows || end[rows - 1] == cat->last_end)) same = PETSC_TRUE;
  PetscCall(PetscFree(end));
  PetscCheck(same, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s (-%sfault_catalogue) is not the catalogue that -%sfault_restart %s was written with: it has no event "
             "%" PetscInt_FMT " that ended at %.9g s; give the name of that one, or of a file that is not there",
             fault->options.text[FAULT_CATALOGUE], prefix, prefix, fault->options.text[FAULT_RESTART], rows,
             (double)cat->last_end);
  PetscCall(SlipH5Has(h, "/maps", &has));
  PetscCheck(has == cat->maps, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s (-%sfault_catalogue) has %s maps, which goes on: expected -%sfault_catalogue_maps %s",
             fault->options.text[FAULT_CATALOGUE], prefix, has ? "" : "no", prefix, has ? "yes" : "no");
  PetscCall(CreateTable(cat, rows));
  for (PetscInt m = 0; m < 2 && cat->maps; m++) PetscCall(SlipH5SetRows(h, Maps[m], rows));
  PetscCall(SlipH5Live(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes the last rows before an error that ends the program. */
static PetscErrorCode FlushBeforeExit(void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;

  PetscFunctionBegin;
  PetscCall(SlipTableFlush(&cat->table, &cat->file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the file, unless it exists. Collective. */
PetscErrorCode SlipCatalogueBegin(SlipFaultCatalogue cat)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (cat->begun) PetscFunctionReturn(PETSC_SUCCESS);
  if (cat->maps) { /* rank 0 gets the direction of the maps' slip, in place of a map */
    PetscReal *a;
    Vec rake;

    PetscCall(VecDuplicate(cat->rupture, &rake));
    PetscCall(VecGetArray(rake, &a));
    PetscCall(PetscArraycpy(a, cat->fault->fields.cell[FIELD_RAKE], cat->fault->mesh.n));
    PetscCall(VecRestoreArray(rake, &a));
    PetscCall(VecScatterBegin(cat->gather_cells, rake, cat->map[1], INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(cat->gather_cells, rake, cat->map[1], INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecDestroy(&rake));
  }
  if (!cat->rank) ierr = cat->resumed ? Continue(cat) : Create(cat);
  PetscCall(SlipErrorBcast(cat->fault->comm, ierr));
  cat->begun = PETSC_TRUE;
  cat->file.last = FlushBeforeExit;
  cat->file.ctx = cat;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes the gathered maps. */
static PetscErrorCode WriteMaps(SlipFaultCatalogue cat)
{
  const PetscInt c = cat->fault->layout.components, plane = cat->fault->layout.plane;
  const PetscReal *slip;
  PetscReal *time, *copy = NULL;
  const SlipArrays arrays[] = {{cat->map[0], .read = &slip}, {cat->map[1], .write = &time}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt e = 0; e < cat->fault->mesh.N; e++)
    if (time[e] < 0) time[e] = (PetscReal)NAN;
  if (c > plane) PetscCall(PetscMalloc1(plane * cat->fault->mesh.N, &copy));
  for (PetscInt k = 0; k < plane * cat->fault->mesh.N && copy; k++) copy[k] = slip[c * (k / plane) + k % plane];
  {
    const SlipH5Rows series[2] = {{Maps[0], copy ? copy : slip, 1}, {Maps[1], time, 1}};

    PetscCall(SlipH5AppendAll(&cat->file, 2, series, 1));
  }
  PetscCall(PetscFree(copy));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the row of an event, with its maps. Collective. */
PetscErrorCode SlipCatalogueAdd(SlipFaultCatalogue cat)
{
  const Vec from[2] = {cat->slip, cat->rupture};
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  PetscCall(SlipLogOutputBegin());
  for (PetscInt m = 0; m < 2 && cat->maps; m++) {
    const VecScatter gather = m ? cat->gather_cells : cat->gather;

    PetscCall(VecScatterBegin(gather, from[m], cat->map[m], INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(gather, from[m], cat->map[m], INSERT_VALUES, SCATTER_FORWARD));
  }
  if (!cat->rank) ierr = SlipTableAdd(&cat->table, &cat->file, cat->row);
  if (!cat->rank && !ierr && cat->maps) ierr = WriteMaps(cat);
  cat->unflushed = PETSC_TRUE;
  PetscCall(SlipLogOutputEnd());
  PetscCall(SlipErrorBcast(cat->fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: reads the values of a column in all rows [n]; the caller frees them with PetscFree(). */
PetscErrorCode SlipCatalogueReadColumn(SlipFaultCatalogue cat, SlipEventColumn column, PetscInt *n, PetscReal **values)
{
  char path[64];

  PetscFunctionBegin;
  PetscCall(SlipTableFlush(&cat->table, &cat->file));
  PetscCall(PetscSNPrintf(path, sizeof(path), "/%s", Columns[column].name));
  PetscCall(SlipH5ReadReal(&cat->file, path, 1, n, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes rows to the disk, at most as often as costs a hundredth of the time. It is called after every step, as the
   next event may be hours away. Collective. */
PetscErrorCode SlipCatalogueFlush(SlipFaultCatalogue cat)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscInt due = 0;

  PetscFunctionBegin;
  if (!cat->unflushed) PetscFunctionReturn(PETSC_SUCCESS);
  if (!cat->rank) {
    PetscBool now;

    PetscCall(SlipH5FlushIsDue(&cat->file, &now));
    if (now) ierr = SlipTableFlush(&cat->table, &cat->file);
    if (now && !ierr) ierr = SlipH5Flush(&cat->file);
    due = now ? 1 : 0;
  }
  PetscCall(SlipErrorBcast(cat->fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&due, 1, MPIU_INT, 0, cat->fault->comm));
  if (due) cat->unflushed = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Closes the file at the end of a run, or of one that did not reach it. Collective. */
PetscErrorCode SlipCatalogueClose(SlipFaultCatalogue cat, PetscBool complete)
{
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!cat->rank && cat->file.id > 0) {
    if (cat->file.live) ierr = SlipTableFlush(&cat->table, &cat->file);
    if (!ierr) ierr = complete ? SlipH5Close(&cat->file) : SlipH5Abandon(&cat->file);
  }
  PetscCall(SlipErrorBcast(cat->fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a checkpoint ---- */

/* Updates stored times when the origin of time has moved. */
void SlipCatalogueFollowOrigin(SlipFaultCatalogue cat)
{
  static const PetscInt times[] = {EVENT_ONSET, EVENT_END};
  const PetscReal by = cat->fault->loads.origin - cat->origin;
  const PetscInt faults = cat->fault->mesh.faults;

  cat->origin += by;
  cat->time_before -= by;
  cat->event.onset -= by;
  for (int k = 0; k < 2; k++) cat->event.time[k] -= by;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(times); k++) cat->row[times[k]] -= by;
  for (PetscInt k = 0; k < faults && cat->hypocentre; k++)
    cat->row[EVENT_NUM_COLUMNS + (EVENT_FAULT_ONSET - EVENT_NUM_COLUMNS) * faults + k] -= by;
}

/* Visits the present event. */
static PetscErrorCode VisitEvent(SlipState s, SlipFaultCatalogue cat)
{
  SlipFaultEvent *e = &cat->event;

  PetscFunctionBegin;
  PetscCall(SlipStateReal(s, "onset", 1, &e->onset));
  PetscCall(SlipStateReal(s, "elastic", 1, &e->elastic));
  PetscCall(SlipStateReal(s, "kinetic", 1, &e->kinetic));
  PetscCall(SlipStateReal(s, "work", cat->nwork, cat->work));
  PetscCall(SlipStateBool(s, "power_known", &cat->power_known));
  if (cat->power_known) PetscCall(SlipStateReal(s, "power", cat->nwork, cat->power));
  PetscCall(SlipStateReal(s, "peak", 1, &e->peak));
  PetscCall(SlipStateReal(s, "time", 2, e->time));
  PetscCall(SlipStateReal(s, "rate", 2, e->rate));
  PetscCall(SlipStateInt(s, "cell", 1, &e->cell));
  if (cat->fault->kind.flows) PetscCall(SlipStateReal(s, "pressure", 1, &e->pressure));
  PetscCall(SlipStateInt(s, "steps", 1, &e->steps));
  PetscCall(SlipStateBool(s, "images", &e->images));
  if (cat->hypocentre) PetscCall(SlipStateInt(s, "hypocentres", cat->fault->mesh.faults, cat->hypocentre));
  PetscCall(SlipStateVec(s, "displacement", cat->u0));
  PetscCall(SlipStateVec(s, "stress", cat->stress0));
  PetscCall(SlipStateVec(s, "rupture_time", cat->rupture));
  PetscCall(SlipStateBool(s, "ended", &cat->ended));
  if (!cat->ended) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateReal(s, "row", cat->nrow, cat->row));
  PetscCall(SlipStateVec(s, "slip", cat->slip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Visits the catalogue for a checkpoint. A checkpoint of a run without a catalogue has none: the catalogue begins
   there. It continues in the file of the earlier run, or from here in a new one. Collective. */
PetscErrorCode SlipCatalogueVisit(SlipFault fault, SlipState s, void *ctx)
{
  SlipFaultCatalogue cat = (SlipFaultCatalogue)ctx;
  const char *prefix = SlipFaultPrefix(fault);
  PetscReal rate = fault->options.value[FAULT_EVENT_RATE];
  char earlier[PETSC_MAX_PATH_LEN + 8];
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipStateHas(s, "catalogue", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  if (!SlipStateIsLoading(s)) {
    PetscCall(SlipCatalogueBegin(cat));
    if (!cat->rank) ierr = SlipTableFlush(&cat->table, &cat->file);
    if (!cat->rank && !ierr) ierr = SlipH5Sync(&cat->file);
    PetscCall(SlipErrorBcast(fault->comm, ierr));
  }
  SlipCatalogueFollowOrigin(cat); /* before anything is read or written */
  PetscCall(SlipStateGroup(s, "catalogue"));
  PetscCall(SlipStateReal(s, "event_rate", 1, &rate));
  PetscCheck(rate == fault->options.value[FAULT_EVENT_RATE], fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_event_rate is %g m/s, was %g m/s in -%sfault_restart %s", prefix,
             (double)fault->options.value[FAULT_EVENT_RATE], (double)rate, prefix, fault->options.text[FAULT_RESTART]);
  PetscCall(SlipStateInt(s, "events", 1, &fault->run->events));
  PetscCall(SlipStateReal(s, "last_end", 1, &cat->last_end));
  PetscCall(SlipStateReal(s, "slip_since", 1, &cat->slip_since));
  PetscCall(SlipStateBool(s, "active", &cat->active));
  if (cat->before) {
    PetscCall(SlipStateReal(s, "time_before", 1, &cat->time_before));
    PetscCall(SlipStateVec(s, "before", cat->before));
  }
  if (cat->active) PetscCall(VisitEvent(s, cat));
  if (!SlipStateIsLoading(s)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultFindEarlier(fault, fault->options.text[FAULT_CATALOGUE], "catalogue",
                                 fault->run->events ? PETSC_TRUE : PETSC_FALSE, earlier));
  cat->resumed = earlier[0] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipCatalogueBegin(cat));
  PetscFunctionReturn(PETSC_SUCCESS);
}
