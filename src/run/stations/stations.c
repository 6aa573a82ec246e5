/* Records for -fault_stations the cells of points of the fault, at the start and at every accepted step, in the groups
   /stations/0, /stations/1, ... of the output. Each has the rows of /series, so that a checkpoint counts only those. */
#include <slipstep/private/sliprun.h>
#include <stdio.h>

/* A point may be outside of a cell by this share of its size, as coordinates of edges are rounded. Where y is given the
   point may be so far off the plane, as coordinates in metres or decimetres seldom lie on a dipping plane. */
#define STATION_EDGE 1e-9
#define STATION_OFF 1e-2
#define STATION_OFF_TRIANGLE 0.1 /* for triangles, which only approximate a curved surface */

static const SlipOutputColumn Columns[] = {
  {"time", "s", PETSC_FALSE},      {"slip", "m", PETSC_FALSE},  {"slip_rate", "m/s", PETSC_FALSE},
  {"traction", "Pa", PETSC_FALSE}, {"state", "m", PETSC_FALSE}, {"normal_stress", "Pa", PETSC_FALSE},
  {"opening", "m", PETSC_FALSE},
};
/* There is a normal stress only where slip changes it, and an opening only where cells open; where slip heats closed
   cells their temperature takes its place. Slip, its rate and traction have a number for each component of slip. The
   law's states replace "state". */
static const SlipOutputColumn TemperatureColumn = {"temperature", "K", PETSC_FALSE};
enum {
  STATION_SLIP = 1,
  STATION_RATE,
  STATION_TRACTION,
  STATION_STATE,
  STATION_NORMAL,
  STATION_OPENING,
  STATION_COLUMNS = PETSC_STATIC_ARRAY_LENGTH(Columns)
};

typedef struct {
  PetscReal x, z;      /* given point [m] */
  PetscReal centre[3]; /* x, y, z of the cell's centre [m] */
  PetscInt cell;       /* in the order of the file or grid */
  PetscInt local;      /* number among this rank's cells, -1: on another rank */
  PetscReal u0[2];     /* displacement at the start [m] */
} Station;

typedef struct {
  PetscInt n;
  Station *station;
  PetscBool known;    /* a checkpoint has the start */
  PetscReal start;    /* time of the start [s] */
  PetscInt columns;   /* columns of their tables */
  PetscInt numbers;   /* numbers in a row */
  PetscReal *row;     /* [numbers n] */
  SlipFaultLook look; /* their numbers; m 0: before the first step */
  PetscInt *cell;     /* their places on this process, in look */
  PetscReal *stress;  /* [cells] room for normal stresses from the device */
  PetscReal *heat;    /* [n] room for the rise of temperature [K], NULL: there is none */
  SlipOutput output;  /* output with their tables, from this one on; NULL: there are no stations */
  PetscInt table;
  SlipFault fault;
} Stations;

/* ---- positions of stations ---- */

/* Computes the distance of the point from a cell's centre [3] along its strike, along its dip and off its plane. Of a
   point without y, x is the distance along the strike from the origin, and the depth gives the place along the dip. at
   [3]: the point on the plane */
static void Offsets(const SlipFaultCell *cell, const Station *s, const PetscReal *y, PetscReal off[3], PetscReal at[3])
{
  const PetscReal *strike = cell->direction[0], *dip = cell->direction[1], *normal = cell->direction[2];
  const PetscReal d[3] = {s->x - cell->centre[0], y ? *y - cell->centre[1] : 0, s->z - cell->centre[2]};

  off[0] = y ? d[0] * strike[0] + d[1] * strike[1] : s->x - (cell->centre[0] * strike[0] + cell->centre[1] * strike[1]);
  off[1] = y ? d[0] * dip[0] + d[1] * dip[1] + d[2] * dip[2] : d[2] / dip[2];
  off[2] = y ? PetscAbsReal(d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]) : 0;
  for (PetscInt k = 0; k < 3; k++) at[k] = cell->centre[k] + off[0] * strike[k] + off[1] * dip[k];
}

/* Returns whether a cell contains the point of its plane with these distances from its centre. */
static PetscBool Contains(const SlipFaultCell *cell, const PetscReal off[2], PetscReal size)
{
  PetscReal p[3][2];
  int left = 0;

  if (!cell->vertices)
    return PetscAbsReal(off[0]) <= (0.5 + STATION_EDGE) * cell->size[0] &&
               PetscAbsReal(off[1]) <= (0.5 + STATION_EDGE) * cell->size[1]
             ? PETSC_TRUE
             : PETSC_FALSE;
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 2; j++) {
      p[k][j] = 0;
      for (int i = 0; i < 3; i++) p[k][j] += (cell->vertices[3 * k + i] - cell->centre[i]) * cell->direction[j][i];
    }
  for (int k = 0; k < 3; k++) { /* the point is on the side of the centre, or on the edge */
    const PetscReal *a = p[k], *b = p[(k + 1) % 3], e[2] = {b[0] - a[0], b[1] - a[1]};
    const PetscReal inner = e[1] * a[0] - e[0] * a[1], own = e[0] * (off[1] - a[1]) - e[1] * (off[0] - a[0]);

    left += own * PetscSign(inner) >= -STATION_EDGE * size * PetscSqrtReal(e[0] * e[0] + e[1] * e[1]) ? 1 : 0;
  }
  return left == 3 ? PETSC_TRUE : PETSC_FALSE;
}

/* Finds the cell that contains the point, of several the first one of the nearest plane, or else the nearest cell;
   inside: the cell contains it. y: NULL when it was not given. several: cells of several planes contain it, elsewhere
   */
static PetscErrorCode FindCell(SlipFault fault, const PetscReal *y, Station *s, PetscBool *inside, PetscBool *several)
{
  PetscReal least = PETSC_MAX_REAL, found[3] = {0, 0, 0};
  SlipFaultCell cell;

  PetscFunctionBegin;
  *inside = *several = PETSC_FALSE;
  for (PetscInt e = 0; e < fault->mesh.N; e++) {
    PetscReal off[3], at[3], distance, size;
    PetscBool in, nearer;

    fault->mesh.kind->cell(&fault->mesh, e, &cell);
    Offsets(&cell, s, y, off, at);
    size = PetscMin(cell.size[0], cell.size[1]);
    in = Contains(&cell, off, size) && off[2] <= (cell.vertices ? STATION_OFF_TRIANGLE : STATION_OFF) * size
           ? PETSC_TRUE
           : PETSC_FALSE;
    distance = in ? off[2] : PetscSqrtReal(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    nearer = distance < least - (in ? STATION_EDGE * size : 0) ? PETSC_TRUE : PETSC_FALSE;
    if (*inside && in && !y) {
      const PetscReal apart[3] = {at[0] - found[0], at[1] - found[1], at[2] - found[2]};

      if (apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2] > PetscSqr(STATION_OFF * size))
        *several = PETSC_TRUE;
    }
    if (in == *inside ? !nearer : !in) continue;
    *inside = in;
    least = distance;
    s->cell = e;
    PetscCall(PetscArraycpy(found, at, 3));
    PetscCall(PetscArraycpy(s->centre, cell.centre, 3));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cell of a point [3]: x, y or NaN, z. */
static PetscErrorCode PlaceStation(SlipFault fault, const PetscReal point[3], Station *s)
{
  const char *prefix = SlipFaultPrefix(fault);
  const PetscBool three = PetscIsNanReal(point[1]) ? PETSC_FALSE : PETSC_TRUE;
  PetscBool inside, several;
  char across[32] = "", text[96];

  PetscFunctionBegin;
  s->x = point[0];
  s->z = point[2];
  if (three) (void)snprintf(across, sizeof(across), "%.10g,", (double)point[1]);
  (void)snprintf(text, sizeof(text), "%.10g,%s%.10g", (double)point[0], across, (double)point[2]);
  PetscCall(FindCell(fault, three ? &point[1] : NULL, s, &inside, &several));
  PetscCheck(inside, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_stations has the point %s outside the fault, expected points in its cells; the centre of the "
             "nearest is at x = %g, y = %g, z = %g m",
             prefix, text, (double)s->centre[0], (double)s->centre[1], (double)s->centre[2]);
  PetscCheck(!several, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_stations has the point %s, which several planes have: expected x,y,z", prefix, text);
  s->local = -1;
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if (SlipFaultMeshRow(&fault->mesh, i) == s->cell) s->local = i;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StationsCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  const char *text = fault->options.text[FAULT_STATIONS];
  Stations *list;
  PetscReal *point;
  PetscInt n;

  PetscFunctionBegin;
  (void)ts;
  (void)wanted; /* the observer exists also without stations, as checkpoints store that */
  PetscCall(PetscNew(&list));
  *ctx = list;
  list->fault = fault;
  if (!text[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultReadPoints(fault, FAULT_STATIONS, "xz", PETSC_TRUE, &n, &point));
  list->n = n;
  if (fault->zone.sums.n) PetscCall(PetscMalloc1(n + 1, &list->heat));
  list->columns = SlipFaultOpens(fault) || list->heat ? STATION_COLUMNS
                  : SlipFaultNormalFollows(fault)     ? STATION_OPENING
                                                      : STATION_NORMAL;
  list->columns += fault->layout.states - 1;
  list->numbers = list->columns + 3 * (fault->layout.plane - 1);
  PetscCall(PetscCalloc2(n, &list->station, list->numbers * n, &list->row));
  for (PetscInt k = 0; k < n; k++) PetscCall(PlaceStation(fault, point + 3 * k, &list->station[k]));
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StationsDestroy(void **ctx)
{
  Stations *list = (Stations *)*ctx;

  PetscFunctionBegin;
  PetscCall(PetscFree2(list->station, list->row));
  PetscCall(PetscFree(list->stress));
  PetscCall(PetscFree(list->heat));
  PetscCall(SlipFaultLookDestroy(list->fault, &list->look));
  PetscCall(PetscFree(list->cell));
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- groups of stations ---- */

static PetscErrorCode WritePlace(SlipFault fault, SlipH5 *h, const char group[], const Station *s)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrReal(h, group, "x", s->x));
  PetscCall(SlipH5WriteAttrReal(h, group, "z", s->z));
  PetscCall(SlipH5WriteAttrInt(h, group, "cell", s->cell));
  PetscCall(SlipH5WriteAttrReal(h, group, "cell_x", s->centre[0]));
  if (fault->mesh.ndim == 1) PetscCall(SlipH5WriteAttrReal(h, group, "cell_y", s->centre[1]));
  PetscCall(SlipH5WriteAttrReal(h, group, "cell_z", s->centre[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: checks that a file that is continued has the same stations. */
static PetscErrorCode CheckPlaces(SlipFault fault, SlipH5 *h, const Stations *list)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscInt n = 0, cell = -1;
  char group[64];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, "/stations", &has));
  if (has) PetscCall(SlipH5CountMembers(h, "/stations", &n));
  PetscCheck(n == list->n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has %" PetscInt_FMT " stations, but -%sfault_stations %" PetscInt_FMT
             ": expected the same ones, or another -%sfault_output",
             h->target, n, prefix, list->n, prefix);
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(PetscSNPrintf(group, sizeof(group), "/stations/%" PetscInt_FMT, k));
    PetscCall(SlipH5ReadAttrInt(h, group, "cell", &cell));
    PetscCheck(cell == list->station[k].cell, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s has station %" PetscInt_FMT " in cell %" PetscInt_FMT ", -%sfault_stations in cell %" PetscInt_FMT
               ": expected the same ones, or another -%sfault_output",
               h->target, k, cell, prefix, list->station[k].cell, prefix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the groups with their tables, or cuts those of an earlier run as /series is cut. */
static PetscErrorCode StationsLayout(SlipFault fault, SlipOutput output, void *ctx)
{
  Stations *list = (Stations *)ctx;
  SlipH5 *h = SlipOutputFile(output);
  const PetscInt c = fault->layout.plane, states = fault->layout.states,
                 entries[STATION_COLUMNS + SLIP_MAX_STATES] = {0, c, c, c}; /* one number in the other columns */
  SlipOutputColumn columns[STATION_COLUMNS + SLIP_MAX_STATES];
  PetscErrorCode ierr = PETSC_SUCCESS;
  char group[64];

  PetscFunctionBegin;
  list->output = output;
  PetscCall(PetscArraycpy(columns, Columns, STATION_STATE));
  for (PetscInt k = 0; k < states; k++)
    columns[STATION_STATE + k] = (SlipOutputColumn){SlipFrictionStateName(fault->friction.law, k),
                                                    SlipFrictionStateUnit(fault->friction.law, k), PETSC_FALSE};
  PetscCall(
    PetscArraycpy(columns + STATION_STATE + states, Columns + STATION_NORMAL, STATION_COLUMNS - STATION_NORMAL));
  if (list->heat) columns[STATION_OPENING + states - 1] = TemperatureColumn;
  if (h && output->resumed) ierr = CheckPlaces(fault, h, list);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  for (PetscInt k = 0; k < list->n; k++) {
    PetscInt table;

    PetscCall(PetscSNPrintf(group, sizeof(group), "/stations/%" PetscInt_FMT, k));
    PetscCall(SlipOutputAddTable(output, group, list->columns, columns, c == 1 ? NULL : entries, &table));
    if (!k) list->table = table;
    if (h && !output->resumed) ierr = WritePlace(fault, h, group, &list->station[k]);
    PetscCall(SlipErrorBcast(fault->comm, ierr));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- rows of stations ---- */

/* Gets the numbers of the stations, and the friction there. */
static PetscErrorCode Look(SlipFault fault, PetscReal time, Vec w, Stations *list, SlipFrictionCells *friction)
{
  const PetscInt width = fault->layout.block + fault->layout.components + 1;

  PetscFunctionBegin;
  if (!list->look.m) {
    PetscCall(PetscMalloc1(list->n, &list->cell));
    for (PetscInt k = 0; k < list->n; k++) list->cell[k] = list->station[k].local;
    PetscCall(PetscMalloc1(list->n * width, &list->look.values));
    PetscCall(PetscMalloc1(fault->mesh.n, &list->stress));
    PetscCall(PetscArraycpy(list->stress, fault->loads.normal, fault->mesh.n));
    list->look.m = list->n;
    list->look.cell = list->cell;
  }
  PetscCall((*fault->cell_ops->look)(fault, time, w, &list->look));
  for (PetscInt k = 0; k < list->n; k++)
    if (list->cell[k] >= 0) list->stress[list->cell[k]] = list->look.values[width * (k + 1) - 1];
  *friction = SlipFaultCellFriction(fault, list->stress);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a row for each station. Slip is signed, and follows from du/dt = v - v_inf. */
static PetscErrorCode StationsStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Stations *list = (Stations *)ctx;
  const PetscInt c = fault->layout.plane;
  const PetscInt block = fault->layout.block, width = block + fault->layout.components + 1;
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  SlipFrictionCells friction;
  PetscMPIInt rank;
  const PetscReal since = fault->loads.origin + time - list->start;

  PetscFunctionBegin;
  (void)ts;
  (void)step;
  if (!list->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLogOutputBegin());
  PetscCall(PetscArrayzero(list->row, list->numbers * list->n));
  PetscCall(Look(fault, time, w, list, &friction));
  if (list->heat) PetscCall(SlipFaultZoneValues(fault, time, w, &friction, list->n, list->cell, list->heat, NULL));
  for (PetscInt k = 0; k < list->n; k++) {
    const Station *s = &list->station[k];
    const PetscInt i = s->local;
    const PetscReal *state = list->look.values + width * k;
    PetscReal *row = list->row + list->numbers * k;

    if (i < 0) continue;
    *row++ = time;
    for (PetscInt j = 0; j < c; j++, row++) {
      row[0] = state[fault->layout.displacement + j] - s->u0[j] + vinf[i] * SlipFaultAlong(fault, i)[j] * since;
      row[c] = state[fault->layout.rate + j];
      row[2 * c] = state[block + j];
    }
    row += 2 * c;
    for (PetscInt j = 0; j < fault->layout.states; j++)
      *row++ = SlipFrictionShown(&friction, i, j, state[fault->layout.state + j]);
    if (SlipFaultNormalFollows(fault) || list->heat) *row++ = friction.stress[i];
    if (list->heat) *row = list->heat[k];
    if (SlipFaultOpens(fault)) *row = SlipFaultAcross(fault, state + fault->layout.displacement);
  }
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCallMPI(MPI_Reduce(rank ? list->row : MPI_IN_PLACE, list->row, (PetscMPIInt)(list->numbers * list->n), MPIU_REAL,
                          MPIU_SUM, 0, fault->comm));
  PetscCall(SlipOutputAddRows(list->output, list->table, list->n, list->row));
  PetscCall(SlipLogOutputEnd());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stores the start of slip unless a checkpoint has it, and adds the row of the start unless the file has it. */
static PetscErrorCode StationsStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  Stations *list = (Stations *)ctx;

  PetscFunctionBegin;
  if (!list->output) PetscFunctionReturn(PETSC_SUCCESS);
  if (!list->output->resumed || !list->known) {
    const PetscInt c = fault->layout.plane;
    const PetscReal *a;

    list->start = fault->loads.origin + time;
    PetscCall(PetscArrayzero(list->row, c * list->n));
    PetscCall(VecGetArrayRead(w, &a));
    for (PetscInt k = 0; k < list->n; k++)
      for (PetscInt j = 0; j < c && list->station[k].local >= 0; j++)
        list->row[c * k + j] = a[SlipFaultDisplacementAt(fault, list->station[k].local) + j];
    PetscCall(VecRestoreArrayRead(w, &a));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, list->row, (PetscMPIInt)(c * list->n), MPIU_REAL, MPIU_SUM, fault->comm));
    for (PetscInt k = 0; k < list->n; k++)
      for (PetscInt j = 0; j < c; j++) list->station[k].u0[j] = list->row[c * k + j];
  }
  if (!list->output->start_known) PetscCall(StationsStep(fault, ts, 0, time, w, list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads the start of slip. Stations that the earlier run did not have begin where this run continues. */
static PetscErrorCode StationsVisit(SlipFault fault, SlipState s, void *ctx)
{
  Stations *list = (Stations *)ctx;
  PetscInt stations = list->n;

  PetscFunctionBegin;
  PetscCall(SlipStateGroup(s, "output"));
  PetscCall(SlipStateInt(s, "stations", 1, &stations));
  for (PetscInt k = 0; k < list->n && stations == list->n; k++) {
    char name[64];
    PetscInt cell = list->station[k].cell;

    PetscCall(PetscSNPrintf(name, sizeof(name), "station_%" PetscInt_FMT "_cell", k));
    PetscCall(SlipStateInt(s, name, 1, &cell));
    if (cell != list->station[k].cell) stations = -1;
    PetscCall(PetscSNPrintf(name, sizeof(name), "station_%" PetscInt_FMT "_displacement", k));
    PetscCall(SlipStateReal(s, name, fault->layout.plane, list->station[k].u0));
  }
  PetscCall(SlipStateReal(s, "station_start", 1, &list->start));
  if (SlipStateIsLoading(s)) list->known = stations == list->n ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultStationsObserver = {.name = "stations",
                                                     .create = StationsCreate,
                                                     .layout = StationsLayout,
                                                     .start = StationsStart,
                                                     .step = StationsStep,
                                                     .visit = StationsVisit,
                                                     .destroy = StationsDestroy};
