/* -fault_stations: points of the fault whose cells are recorded at every accepted step, in the groups /stations/0,
   /stations/1, ... of the output. Their rows are those of /series, so that a checkpoint's count of the one is that
   of the other. */
#include <slipstep/private/slipfaultrecord.h>
#include <slipstep/private/slipmatcells.h>
#include <stdlib.h>
#include <string.h>

/* A point may be outside of a cell by this part of its size: coordinates of edges are rounded. */
#define STATION_EDGE 1e-9

static const SlipOutputColumn Columns[] = {
  {"time", "s", PETSC_FALSE},      {"slip", "m", PETSC_FALSE},  {"slip_rate", "m/s", PETSC_FALSE},
  {"traction", "Pa", PETSC_FALSE}, {"state", "m", PETSC_FALSE},
};
enum { STATION_COLUMNS = PETSC_STATIC_ARRAY_LENGTH(Columns), STATION_STATE = STATION_COLUMNS - 1 };

/* ---- where they are ---- */

/* The first cell that contains the point, or the nearest one: inside says which. y: NULL when it was not given. planes:
   cells of several planes contain it */
static PetscErrorCode FindCell(SlipFault fault, const PetscReal *y, SlipFaultStation *s, PetscBool *inside,
                               PetscBool *planes)
{
  PetscReal centre[3] = {0}, size[2] = {0}, least = PETSC_MAX_REAL;

  PetscFunctionBegin;
  *inside = *planes = PETSC_FALSE;
  for (PetscInt e = 0; e < fault->mesh.N; e++) {
    PetscReal dx, dz, off;
    PetscBool in;

    PetscCall(SlipFaultPlaceOf(fault, e, centre, size));
    dx = PetscAbsReal(s->x - centre[0]);
    dz = PetscAbsReal(s->z - centre[2]);
    off = y ? PetscAbsReal(*y - centre[1]) : 0;
    in = dx <= (0.5 + STATION_EDGE) * size[0] && dz <= (0.5 + STATION_EDGE) * size[1] && off <= STATION_EDGE * size[0]
           ? PETSC_TRUE
           : PETSC_FALSE;
    if (*inside && in && centre[1] != s->centre[1]) *planes = PETSC_TRUE;
    if (*inside || (!in && dx * dx + dz * dz + off * off >= least)) continue;
    *inside = in;
    least = dx * dx + dz * dz + off * off;
    s->cell = e;
    PetscCall(PetscArraycpy(s->centre, centre, 3));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* This rank's number of the cell */
static void FindLocal(SlipFault fault, SlipFaultStation *s)
{
  s->local = -1;
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    if ((fault->mesh.order ? fault->mesh.order[fault->mesh.start + i] : fault->mesh.start + i) == s->cell) s->local = i;
}

/* One point of the list: two or three numbers with commas between */
static PetscErrorCode ReadStation(SlipFault fault, const char point[], SlipFaultStation *s)
{
  const char *prefix = SlipFaultPrefix(fault), *c = point;
  PetscReal number[3];
  PetscBool inside, planes;
  PetscInt n = 0;
  char *end;

  PetscFunctionBegin;
  do {
    number[n] = (PetscReal)strtod(c, &end);
    if (end == c || PetscIsInfOrNanReal(number[n])) break;
    c = end + strspn(end, " ");
    n++;
  } while (n < 3 && *c == ',' && c++);
  PetscCheck(n >= 2 && !*c, fault->comm, PETSC_ERR_ARG_WRONG,
             "-%sfault_stations has the point \"%s\", expected points \"x,z;x,z\" in m, \"x,y,z\" where planes overlap",
             prefix, point);
  s->x = number[0];
  s->z = number[n - 1];
  PetscCall(FindCell(fault, n == 3 ? &number[1] : NULL, s, &inside, &planes));
  PetscCheck(inside, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_stations has the point %s outside the fault, expected points in its cells; the centre of the "
             "nearest is at x = %g, y = %g, z = %g m",
             prefix, point, (double)s->centre[0], (double)s->centre[1], (double)s->centre[2]);
  PetscCheck(!planes, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_stations has the point %s, which several planes have: expected x,y,z", prefix, point);
  FindLocal(fault, s);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStationsSetUp(SlipFaultOutput out)
{
  SlipFault fault = out->fault;
  SlipFaultStations *list = &out->stations;
  const char *text = fault->options.text[FAULT_STATIONS], *prefix = SlipFaultPrefix(fault);
  char **point;
  int n;

  PetscFunctionBegin;
  if (!text[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(strlen(text) + 1 < sizeof(fault->options.text[FAULT_STATIONS]), fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_stations is too long, expected less than %d characters", prefix, PETSC_MAX_PATH_LEN - 1);
  PetscCall(PetscStrToArray(text, ';', &n, &point));
  PetscCheck(n > 0, fault->comm, PETSC_ERR_ARG_WRONG, "-%sfault_stations is \"%s\", expected points \"x,z;x,z\" in m",
             prefix, text);
  list->n = n;
  PetscCall(PetscCalloc2(n, &list->station, STATION_COLUMNS * n, &list->row));
  for (int k = 0; k < n; k++) PetscCall(ReadStation(fault, point[k], &list->station[k]));
  PetscCall(PetscStrToArrayDestroy(n, point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultStationsDestroy(SlipFaultOutput out)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(out->stations.station, out->stations.row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- their groups ---- */

static PetscErrorCode WritePlace(SlipFault fault, SlipH5 *h, const char group[], const SlipFaultStation *s)
{
  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrReal(h, group, "x", s->x));
  PetscCall(SlipH5WriteAttrReal(h, group, "z", s->z));
  PetscCall(SlipH5WriteAttrInt(h, group, "cell", s->cell));
  PetscCall(SlipH5WriteAttrReal(h, group, "cell_x", s->centre[0]));
  if (fault->mesh.cells.n) PetscCall(SlipH5WriteAttrReal(h, group, "cell_y", s->centre[1]));
  PetscCall(SlipH5WriteAttrReal(h, group, "cell_z", s->centre[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A file that goes on has the same stations. */
static PetscErrorCode CheckPlaces(SlipFaultOutput out)
{
  SlipH5 *h = SlipOutputFile(out->run);
  const char *prefix = SlipFaultPrefix(out->fault);
  PetscInt n = 0, cell = -1;
  char group[64];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, "/stations", &has));
  if (has) PetscCall(SlipH5CountMembers(h, "/stations", &n));
  PetscCheck(n == out->stations.n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has %" PetscInt_FMT " stations, but -%sfault_stations %" PetscInt_FMT
             ": expected the same ones, or another -%sfault_output",
             h->name, n, prefix, out->stations.n, prefix);
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(PetscSNPrintf(group, sizeof(group), "/stations/%" PetscInt_FMT, k));
    PetscCall(SlipH5ReadAttrInt(h, group, "cell", &cell));
    PetscCheck(cell == out->stations.station[k].cell, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s has station %" PetscInt_FMT " in cell %" PetscInt_FMT ", -%sfault_stations in cell %" PetscInt_FMT
               ": expected the same ones, or another -%sfault_output",
               h->name, k, cell, prefix, out->stations.station[k].cell, prefix);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: the groups with their tables, or those of an earlier run, cut as /series is */
PetscErrorCode SlipFaultStationsLayout(SlipFaultOutput out)
{
  SlipH5 *h = SlipOutputFile(out->run);
  SlipOutputColumn columns[STATION_COLUMNS];
  char group[64];

  PetscFunctionBegin;
  PetscCall(PetscArraycpy(columns, Columns, STATION_COLUMNS));
  columns[STATION_STATE].unit = SlipFaultStateUnit(out->fault);
  if (out->resumed) PetscCall(CheckPlaces(out));
  for (PetscInt k = 0; k < out->stations.n; k++) {
    PetscCall(PetscSNPrintf(group, sizeof(group), "/stations/%" PetscInt_FMT, k));
    PetscCall(SlipOutputAddTable(out->run, group, STATION_COLUMNS, columns));
    if (!out->resumed) PetscCall(WritePlace(out->fault, h, group, &out->stations.station[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- their rows ---- */

/* Collective. The traction is the static one of the state, which the next step starts from: where a cell has just come to
   rest it does not contain the impulse that stopped it. Weighted by area. */
PetscErrorCode SlipFaultTraction(SlipFault fault, PetscReal time, Vec w, Vec r)
{
  PetscFunctionBegin;
  PetscCheck(fault->friction.law->smooth || fault->stage.con, fault->comm, PETSC_ERR_ORDER,
             "the traction is known after SlipFaultConfigureTS()");
  if (fault->friction.law->smooth)
    PetscCall(SlipFaultSmoothTraction(fault, time, w, r));
  else
    PetscCall(SlipConstraintInitialReaction(fault->stage.con, time, w, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective, also for /fields. Computed once for a state. */
PetscErrorCode SlipFaultOutputTraction(SlipFaultOutput out, PetscReal time, Vec w)
{
  SlipFaultMoment *known = &out->traction_moment, now;
  PetscBool same;

  PetscFunctionBegin;
  PetscCall(SlipFaultIsNow(out->fault, time, w, known, &now, &same));
  if (out->traction && same) PetscFunctionReturn(PETSC_SUCCESS);
  if (!out->traction) PetscCall(VecDuplicate(out->fault->critical.uc, &out->traction));
  PetscCall(SlipFaultTraction(out->fault, time, w, out->traction));
  *known = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start, which slip counts from */
PetscErrorCode SlipFaultStationsStart(SlipFaultOutput out, PetscReal time, Vec w)
{
  SlipFaultStations *list = &out->stations;
  const PetscReal *a;

  PetscFunctionBegin;
  list->start = time;
  PetscCall(PetscArrayzero(list->row, list->n));
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt k = 0; k < list->n; k++)
    if (list->station[k].local >= 0) list->row[k] = a[SlipFaultDisplacementAt(out->fault, list->station[k].local)];
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, list->row, (PetscMPIInt)list->n, MPIU_REAL, MPIU_SUM, out->fault->comm));
  for (PetscInt k = 0; k < list->n; k++) list->station[k].u0 = list->row[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective, with each row of /series. Slip is what du/dt = v - v_inf makes of it, signed. */
PetscErrorCode SlipFaultStationsRow(SlipFaultOutput out, PetscReal time, Vec w)
{
  SlipFault fault = out->fault;
  SlipFaultStations *list = &out->stations;
  const PetscReal *a, *r, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  if (!list->n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultOutputTraction(out, time, w));
  PetscCall(PetscArrayzero(list->row, STATION_COLUMNS * list->n));
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(VecGetArrayRead(out->traction, &r));
  for (PetscInt k = 0; k < list->n; k++) {
    const SlipFaultStation *s = &list->station[k];
    const PetscInt i = s->local;
    PetscReal *row = list->row + STATION_COLUMNS * k;

    if (i < 0) continue;
    row[0] = time;
    row[1] = a[SlipFaultDisplacementAt(fault, i)] - s->u0 + vinf[i] * (time - list->start);
    row[2] = a[SlipFaultRateAt(fault, i)];
    row[3] = r[i] / fault->mesh.weight[i];
    row[STATION_STATE] = SlipFaultShownState(fault, i, a[SlipFaultStateAt(fault, i)]);
  }
  PetscCall(VecRestoreArrayRead(out->traction, &r));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Reduce(out->rank ? list->row : MPI_IN_PLACE, list->row, (PetscMPIInt)(STATION_COLUMNS * list->n),
                          MPIU_REAL, MPIU_SUM, 0, fault->comm));
  for (PetscInt k = 0; k < list->n && !out->rank && !ierr; k++)
    ierr = SlipOutputAddRow(out->run, k, list->row + STATION_COLUMNS * k);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}
