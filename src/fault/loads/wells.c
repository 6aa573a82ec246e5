/* Reads the wells of -fault_wells, and finds the cells that their fluid enters. The file is that of `slipstep wells`:
   src/package/slipstep/wells.py accepts and refuses the same ones. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- the file ---- */

static PetscBool IsName(const char word[])
{
  for (const char *c = word; *c; c++)
    if ((unsigned char)*c < 32 || *c == 127) return PETSC_FALSE;
  return *word ? PETSC_TRUE : PETSC_FALSE;
}

enum { NAME, X, Y, Z, TIME, VALUE, RADIUS, SPREAD, KINDS };
static const struct {
  const char *name;
  int kind;
  PetscReal unit;
  PetscBool pressure;
} Columns[] = {
  {"well", NAME, 1, PETSC_FALSE},  {"x", X, 1, PETSC_FALSE},           {"y", Y, 1, PETSC_FALSE},
  {"z", Z, 1, PETSC_FALSE},        {"radius", RADIUS, 1, PETSC_FALSE}, {"spread", SPREAD, 1, PETSC_FALSE},
  {"s", TIME, 1, PETSC_FALSE},     {"hours", TIME, 3600, PETSC_FALSE}, {"days", TIME, 86400, PETSC_FALSE},
  {"m3/s", VALUE, 1, PETSC_FALSE}, {"L/s", VALUE, 1e-3, PETSC_FALSE},  {"m3/day", VALUE, 1 / 86400.0, PETSC_FALSE},
  {"Pa", VALUE, 1, PETSC_TRUE},    {"MPa", VALUE, 1e6, PETSC_TRUE}};

typedef struct {
  SlipCsv csv;
  int column[KINDS]; /* word of each kind; -1: none */
  PetscReal unit[KINDS];
  PetscBool pressure;
  PetscInt n;
  SlipFaultWell *well;
} Table;

#define AT "%s, line %" PetscInt_FMT
#define PLACE(t) (t)->csv.name, (t)->csv.number

static PetscErrorCode ReadHead(Table *t)
{
  const int words = t->csv.words;
  PetscBool good = words <= SLIP_CSV_WORDS ? PETSC_TRUE : PETSC_FALSE;
  char head[128] = "";

  PetscFunctionBegin;
  for (int k = 0; k < KINDS; k++) t->column[k] = -1;
  for (int i = 0; i < PetscMin(words, SLIP_CSV_WORDS); i++) {
    size_t k = 0;

    while (k < PETSC_STATIC_ARRAY_LENGTH(Columns) && strcmp(t->csv.word[i], Columns[k].name)) k++;
    PetscCall(PetscStrlcat(head, i ? "," : "", sizeof(head)));
    PetscCall(PetscStrlcat(head, t->csv.word[i], sizeof(head)));
    good = good && k < PETSC_STATIC_ARRAY_LENGTH(Columns) && t->column[Columns[k].kind] < 0 ? PETSC_TRUE : PETSC_FALSE;
    if (!good) continue;
    t->column[Columns[k].kind] = i;
    t->unit[Columns[k].kind] = Columns[k].unit;
    if (Columns[k].kind == VALUE) t->pressure = Columns[k].pressure;
  }
  PetscCheck(good && t->column[NAME] >= 0 && t->column[X] >= 0 && t->column[Z] >= 0 && t->column[TIME] >= 0 &&
               t->column[VALUE] >= 0,
             PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             AT " has the columns %s, expected well,x,y,z, one of days, hours and s, and one of m3/day, L/s, m3/s, MPa "
                "and Pa; y may be left out, and radius and spread [m] may be added",
             PLACE(t), head);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the well of this name, or adds it. */
static PetscErrorCode FindWell(Table *t, const char name[], SlipFaultWell **well, PetscBool *added)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < t->n; k++) {
    *well = &t->well[k];
    if (!strcmp(name, (*well)->name)) PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscRealloc(sizeof(*t->well) * (size_t)(t->n + 1), &t->well));
  *well = &t->well[t->n++];
  **well = (SlipFaultWell){0};
  PetscCall(PetscStrallocpy(name, &(*well)->name));
  *added = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadRow(Table *t)
{
  PetscReal x[KINDS] = {[Y] = (PetscReal)NAN, [RADIUS] = (PetscReal)0.1};
  PetscBool good = t->csv.words <= SLIP_CSV_WORDS && IsName(t->csv.word[t->column[NAME]]) ? PETSC_TRUE : PETSC_FALSE;
  PetscBool added = PETSC_FALSE, moved = PETSC_FALSE;
  SlipFaultWell *well;
  int columns = 0;

  PetscFunctionBegin;
  for (int k = 0; k < KINDS; k++) columns += t->column[k] >= 0;
  good = good && t->csv.words == columns ? PETSC_TRUE : PETSC_FALSE;
  for (int k = X; k < KINDS && good; k++) {
    if (t->column[k] < 0) continue;
    good = SlipCsvNumber(t->csv.word[t->column[k]], &x[k]);
    x[k] *= t->unit[k];
  }
  PetscCheck(good, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             AT ": expected %d words, a name and finite numbers, separated by commas", PLACE(t), columns);
  PetscCheck(x[RADIUS] > 0 && x[SPREAD] >= 0 && !(t->pressure && x[SPREAD] > 0), PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED, AT ": radius is %g m and spread %g m, expected a radius > 0 and a spread %s",
             PLACE(t), (double)x[RADIUS], (double)x[SPREAD],
             t->pressure ? "0, as a pressure is held in the well" : ">= 0");
  PetscCall(FindWell(t, t->csv.word[t->column[NAME]], &well, &added));
  if (added) {
    PetscCall(PetscArraycpy(well->place, x + X, 3));
    well->radius = x[RADIUS];
    well->spread = x[SPREAD];
    well->pressure = t->pressure;
  }
  for (int k = 0; k < 3; k++)
    if (well->place[k] != x[X + k] && !(isnan(x[X + k]) && isnan(well->place[k]))) moved = PETSC_TRUE;
  PetscCheck(!moved && well->radius == x[RADIUS] && well->spread == x[SPREAD], PETSC_COMM_SELF,
             PETSC_ERR_FILE_UNEXPECTED, AT ": expected the place, radius and spread of the well %s in its line before",
             PLACE(t), well->name);
  PetscCheck(added || x[TIME] > well->time[well->rows - 1], PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             AT ": %g s is not after the line before of the well %s, %g s: expected times that rise", PLACE(t),
             (double)x[TIME], well->name, (double)well->time[well->rows - 1]);
  if (!(well->rows & (well->rows - 1))) { /* a power of two: full */
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)PetscMax(2 * well->rows, 1), &well->time));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)PetscMax(2 * well->rows, 1), &well->value));
  }
  well->time[well->rows] = x[TIME];
  well->value[well->rows++] = x[VALUE];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the file on one process; the caller frees the wells of the table also after an error. */
static PetscErrorCode ReadFile(SlipFault fault, Table *t)
{
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool first = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCall(SlipCsvOpen(fault->options.text[FAULT_WELLS], SlipFaultPrefix(fault), "fault_wells", &t->csv));
  for (; !ierr && SlipCsvNext(&t->csv); first = PETSC_FALSE) ierr = first ? ReadHead(t) : ReadRow(t);
  PetscCall(SlipCsvClose(&t->csv));
  PetscCall(ierr);
  PetscCheck(t->n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has no rows, expected a line of names and a line for each change of a well", t->csv.name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the cells of wells ---- */

static void CellAt(const SlipFaultMesh *mesh, PetscInt i, const PetscReal place[3], SlipFaultCell *cell,
                   PetscReal *distance)
{
  const PetscBool flat = isnan(place[1]) ? PETSC_TRUE : PETSC_FALSE;

  mesh->kind->cell(mesh, SlipFaultMeshRow(mesh, i), cell);
  *distance = 0;
  for (int k = 0; k < 3; k++)
    if (k != 1 || !flat) *distance += PetscSqr(cell->centre[k] - place[k]);
  *distance = PetscSqrtReal(*distance);
}

/* Finds the cell with the nearest centre of all processes, of several the first one by rows, which does not depend on
   the number of processes: its row, its centre, and twice the distance from there to its corners. */
static PetscErrorCode Nearest(const SlipFaultMesh *mesh, SlipFaultWell *well, PetscInt *row, PetscReal centre[3],
                              PetscReal *size)
{
  PetscReal least = PETSC_MAX_REAL, d, all[4] = {0};
  PetscInt first = PETSC_MAX_INT;
  SlipFaultCell cell;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < mesh->n; i++) {
    CellAt(mesh, i, well->place, &cell, &d);
    least = PetscMin(least, d);
  }
  PetscCallMPI(MPI_Allreduce(&least, &well->away, 1, MPIU_REAL, MPIU_MIN, mesh->comm));
  for (PetscInt i = 0; i < mesh->n; i++) {
    CellAt(mesh, i, well->place, &cell, &d);
    if (d == well->away) first = PetscMin(first, SlipFaultMeshRow(mesh, i));
  }
  PetscCallMPI(MPI_Allreduce(&first, row, 1, MPIU_INT, MPI_MIN, mesh->comm));
  for (PetscInt i = 0; i < mesh->n; i++) {
    if (SlipFaultMeshRow(mesh, i) != *row) continue;
    CellAt(mesh, i, well->place, &cell, &d);
    for (int k = 0; k < 3; k++) all[k] = cell.centre[k];
    all[3] = hypot(cell.size[0], cell.size[1]);
    if (cell.vertices) all[3] = 0;
    for (int v = 0; v < 3 && cell.vertices; v++) {
      const PetscReal *x = cell.vertices + 3 * v, *o = cell.centre;

      all[3] =
        PetscMax(all[3], 2 * PetscSqrtReal(PetscSqr(x[0] - o[0]) + PetscSqr(x[1] - o[1]) + PetscSqr(x[2] - o[2])));
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, 4, MPIU_REAL, MPIU_SUM, mesh->comm)); /* all but one process have 0 */
  for (int k = 0; k < 3; k++) centre[k] = all[k];
  *size = all[3];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Least weight of a cell over that of the nearest one */
#define SEEN 1e-16

/* Finds the cells of a well, and their shares: the nearest one, or the cells of its fault by the value of a Gaussian at
   their centres, times their areas. */
static PetscErrorCode Locate(SlipFault fault, SlipFaultWell *well)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  PetscReal centre[3] = {0}, size, sum = 0, low[6];
  SlipFaultCell cell;
  PetscInt row, other = 0;

  PetscFunctionBegin;
  for (int k = 0; k < 6; k++) low[k] = PETSC_MAX_REAL; /* of x, y, z, and of their negatives */
  PetscCall(Nearest(mesh, well, &row, centre, &size));
  PetscCall(PetscMalloc2(mesh->n, &well->cell, mesh->n, &well->share));
  for (PetscInt i = 0; i < mesh->n; i++) {
    const PetscInt at = SlipFaultMeshRow(mesh, i);
    const PetscBool same = SlipFaultMeshFaultOf(mesh, at) == SlipFaultMeshFaultOf(mesh, row) ? PETSC_TRUE : PETSC_FALSE;
    PetscReal d, weight = 0;

    CellAt(mesh, i, well->place, &cell, &d);
    for (int k = 0; k < 3; k++) {
      low[k] = PetscMin(low[k], cell.centre[k]);
      low[3 + k] = PetscMin(low[3 + k], -cell.centre[k]);
    }
    if (!same && isnan(well->place[1]) && d <= well->away + 1e-9 * size) other = 1;
    if (well->spread > 0 && same)
      weight = mesh->weight[i] * PetscExpReal(-(d - well->away) * (d + well->away) / (2 * PetscSqr(well->spread)));
    if (at == row ? well->spread == 0 : weight < SEEN) weight = at == row ? 1 : 0;
    if (weight == 0) continue;
    well->cell[well->ncells] = i;
    well->share[well->ncells++] = weight;
    sum += weight;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, low, 6, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &other, 1, MPIU_INT, MPI_MAX, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscCheck(well->away <= size, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_wells %s: the well %s is %.6g m from the centre of the nearest cell, whose size is %.6g m, "
             "expected a place in the fault, in the frame of the cells, x = %.6g to %.6g, y = %.6g to %.6g, z = %.6g "
             "to %.6g m",
             SlipFaultPrefix(fault), fault->options.text[FAULT_WELLS], well->name, (double)well->away, (double)size,
             (double)low[0], -(double)low[3], (double)low[1], -(double)low[4], (double)low[2], -(double)low[5]);
  PetscCheck(!other, fault->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-%sfault_wells %s: the well %s is as near to two faults in x and z, expected a column y",
             SlipFaultPrefix(fault), fault->options.text[FAULT_WELLS], well->name);
  for (PetscInt k = 0; k < well->ncells; k++) well->share[k] /= sum;
  if (isnan(well->place[1])) well->place[1] = centre[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of numbers that look as if they were in another unit, as `slipstep wells` does (checks.py). */
static PetscErrorCode Doubt(const SlipFaultWell *well)
{
  PetscReal largest = 0;
  char what[256];

  PetscFunctionBegin;
  for (PetscInt k = 0; k < well->rows; k++) largest = PetscMax(largest, PetscAbsReal(well->value[k]));
  (void)snprintf(what, sizeof(what), "the largest %s of the well %.128s is", well->pressure ? "pressure" : "rate",
                 well->name);
  if (well->pressure)
    PetscCall(SlipWarnOfUnit(what, largest, "Pa", 100, 1e10, "MPa", "Pa, in a column of MPa"));
  else
    PetscCall(SlipWarnOfUnit(what, largest, "m^3/s", 1e-12, 1, "km^3/s", "L/s or m^3/day"));
  (void)snprintf(what, sizeof(what), "the last time of the well %.128s is", well->name);
  PetscCall(
    SlipWarnOfUnit(what, well->time[well->rows - 1], "s", 1e-6, 3.2e10, "years", "s, in a column of days or hours"));
  (void)snprintf(what, sizeof(what), "the radius of the well %.128s is", well->name);
  PetscCall(SlipWarnOfUnit(what, well->radius, "m", 1e-3, 10, "km", "mm or cm"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DestroyWell(SlipFaultWell *well)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(well->name));
  PetscCall(PetscFree(well->time));
  PetscCall(PetscFree(well->value));
  PetscCall(PetscFree2(well->cell, well->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the wells on rank 0, sends them to all processes, and finds their cells. */
PetscErrorCode SlipFaultWellsSetUp(SlipFault fault)
{
  SlipFaultLoads *loads = &fault->loads;
  Table t = {.n = 0};
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (!fault->options.text[FAULT_WELLS][0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) ierr = ReadFile(fault, &t);
  loads->nwells = t.n;
  loads->wells = t.well; /* destroyed with the fault, also after an error */
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCallMPI(MPI_Bcast(&loads->nwells, 1, MPIU_INT, 0, fault->comm));
  if (rank) PetscCall(PetscCalloc1(loads->nwells, &loads->wells));
  for (PetscInt k = 0; k < loads->nwells; k++) {
    SlipFaultWell *well = &loads->wells[k];
    PetscInt size[3] = {well->rows, well->name ? (PetscInt)strlen(well->name) + 1 : 0, well->pressure};
    PetscReal x[5] = {well->place[0], well->place[1], well->place[2], well->radius, well->spread};

    PetscCallMPI(MPI_Bcast(size, 3, MPIU_INT, 0, fault->comm));
    PetscCallMPI(MPI_Bcast(x, 5, MPIU_REAL, 0, fault->comm));
    if (rank) {
      PetscCall(PetscMalloc1(size[1], &well->name));
      PetscCall(PetscMalloc1(size[0], &well->time));
      PetscCall(PetscMalloc1(size[0], &well->value));
    }
    well->rows = size[0];
    well->pressure = size[2] ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(PetscArraycpy(well->place, x, 3));
    well->radius = x[3];
    well->spread = x[4];
    PetscCallMPI(MPI_Bcast(well->name, (PetscMPIInt)size[1], MPI_CHAR, 0, fault->comm));
    PetscCallMPI(MPI_Bcast(well->time, (PetscMPIInt)size[0], MPIU_REAL, 0, fault->comm));
    PetscCallMPI(MPI_Bcast(well->value, (PetscMPIInt)size[0], MPIU_REAL, 0, fault->comm));
    PetscCall(Locate(fault, well));
    if (!rank) PetscCall(Doubt(well));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultWellsDestroy(SlipFault fault)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < fault->loads.nwells; k++) PetscCall(DestroyWell(&fault->loads.wells[k]));
  PetscCall(PetscFree(fault->loads.wells));
  fault->loads.nwells = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultWellsView(SlipFault fault, PetscViewer viewer)
{
  PetscFunctionBegin;
  for (PetscInt k = 0; k < fault->loads.nwells; k++) {
    const SlipFaultWell *well = &fault->loads.wells[k];
    PetscInt cells = well->ncells;
    PetscReal low = PETSC_MAX_REAL, high = PETSC_MIN_REAL;

    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cells, 1, MPIU_INT, MPI_SUM, fault->comm));
    for (PetscInt j = 0; j < well->rows; j++) {
      low = PetscMin(low, well->value[j]);
      high = PetscMax(high, well->value[j]);
    }
    PetscCall(PetscViewerASCIIPrintf(
      viewer,
      "well %s: at %.9g, %.9g, %.9g m, %.3g m from the centre of a cell, in %" PetscInt_FMT " cells, %" PetscInt_FMT
      " changes from %.6g to %.6g s, %s %.6g to %.6g %s\n",
      well->name, (double)well->place[0], (double)well->place[1], (double)well->place[2], (double)well->away, cells,
      well->rows, (double)well->time[0], (double)well->time[well->rows - 1], well->pressure ? "pressure" : "rate",
      (double)low, (double)high, well->pressure ? "Pa" : "m^3/s"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- in time ---- */

PetscBool SlipFaultWellHolds(const SlipFaultWell *well, PetscReal t)
{
  return well->pressure && SlipTimeAfter(t) >= well->time[0] ? PETSC_TRUE : PETSC_FALSE;
}

PetscReal SlipFaultWellValue(const SlipFaultWell *well, PetscReal t)
{
  const PetscReal after = SlipTimeAfter(t);
  PetscReal share;

  return after < well->time[0] ? 0 : well->value[SlipRecordInterval(well->rows, well->time, after, &share)];
}

PetscReal SlipFaultWellNext(const SlipFaultWell *well, PetscReal t)
{
  const PetscReal after = SlipTimeAfter(t);
  PetscReal share;
  PetscInt row = 0;

  if (after >= well->time[0]) row = SlipRecordInterval(well->rows, well->time, after, &share) + 1;
  return row < well->rows ? well->time[row] : PETSC_MAX_REAL;
}
