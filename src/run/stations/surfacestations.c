/* Records for -fault_surface_stations displacement and velocity of points of the free surface, from a list or a file,
   at the start and at every accepted step, in /ground of the output; the groups /surface/0, /surface/1, ... show each
   station. The slip of all cells along their rakes less that of the far field, u - u(start), moves a point. That is the
   motion relative to the plates that load the fault, which follows for any faults. The motion of the plates themselves,
   half of the loading rate on either side, is added by -fault_surface_motion total (as in Savage 1983), for one plane.
   A row is a product of a dense matrix, computed once, with displacements and slip rates; each process has the columns
   of its cells. */
#include <slipstep/private/sliprun.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipelasticity.h>
#include <math.h>

static const SlipOutputColumn Columns[] = {
  {"time", "s", PETSC_FALSE}, {"displacement", "m", PETSC_FALSE}, {"velocity", "m/s", PETSC_FALSE}};
enum { SURFACE_COLUMNS = PETSC_STATIC_ARRAY_LENGTH(Columns) };
#define ALL "/ground"
#define PLACES "/ground_points"
/* Number of stations whose own datasets have named dimensions: each of them rewrites the list of a dimension's users */
enum { SURFACE_NAMED = 100 };

typedef struct {
  PetscInt n;
  PetscReal *point;  /* [n][2] x, y [m] */
  PetscReal *matrix; /* [local cells][components][n][3] displacement for 1 m of slip or opening [m/m] */
  PetscReal *plates; /* [n][3] velocity of the plates [m/s]; NULL: not included */
  PetscReal begin;   /* time of the start [s] */
  PetscReal *row;    /* [1 + 6 n] time, displacements, velocities */
  PetscBool known;   /* a checkpoint has the start */
  Vec start;         /* displacement at the start [m] */
  SlipFaultLook ground;
  SlipOutput output; /* output with their tables, from this one on */
  PetscInt table;
  SlipFault fault;
} Surface;

/* Computes the displacements for 1 m of slip of a cell along its rake, or along strike and up dip, and of opening.
   Strike slip on planes along x has a simpler formula. */
static PetscErrorCode MakeMatrix(SlipFault fault, Surface *s)
{
  const PetscReal nu = fault->options.value[FAULT_POISSON_RATIO], *rakes = fault->fields.cell[FIELD_RAKE],
                  degrees = 180 / PETSC_PI;
  const PetscInt components = fault->layout.components;
  PetscReal *point;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(3 * s->n, &point));
  for (PetscInt k = 0; k < s->n; k++) PetscCall(PetscArraycpy(point + 3 * k, s->point + 2 * k, 2));
  for (PetscInt row = 0; row < components * fault->mesh.n; row++) {
    const PetscInt i = row / components, k = row % components;
    const PetscReal rake = components == 1 ? rakes[i] : k == 0 ? 0 : 90;
    PetscReal *u = s->matrix + 3 * (size_t)s->n * row, slip[3] = {0, 0, 0};
    SlipDippingRectangle rectangle;
    SlipFaultCell c;

    fault->mesh.kind->cell(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i), &c);
    if (k < 2)
      SlipDegrees(rake, &slip[1], &slip[0]);
    else
      slip[2] = 1;
    if (c.vertices) {
      PetscCall(SlipTrianglesDisplacement(nu, PETSC_FALSE, 1, c.vertices, c.direction[2], slip, s->n, point, u));
      continue;
    }
    if (c.direction[0][0] == 1 && c.direction[1][2] == 1 && rake == 0) {
      SlipSurfaceDisplacement(nu, &(SlipRectangle){c.centre[0], c.centre[1], c.centre[2], c.size[0], c.size[1]}, s->n,
                              s->point, u);
      continue;
    }
    rectangle = (SlipDippingRectangle){
      c.centre[0],
      c.centre[1],
      c.centre[2],
      c.size[0],
      c.size[1],
      degrees * PetscAtan2Real(c.direction[0][1], c.direction[0][0]),
      PetscMin(90, degrees * PetscAtan2Real(c.direction[1][2], hypot(c.direction[1][0], c.direction[1][1])))};
    PetscCall(SlipDippingDisplacement(nu, PETSC_FALSE, &rectangle, slip, s->n, point, u));
  }
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the velocities of plates that slide past each other on the fault's plane, also beyond its edges: points on
   the side of the hanging wall, or on the trace, move with half of the loading rate along the rake, others against it.
   */
static PetscErrorCode MovePlates(SlipFault fault, Surface *s)
{
  const SlipFaultMesh *mesh = &fault->mesh;
  const PetscReal *vinf = fault->fields.cell[FIELD_LOADING_RATE], *rake = fault->fields.cell[FIELD_RAKE];
  const char *prefix = SlipFaultPrefix(fault);
  PetscReal bounds[4] = {PETSC_MIN_REAL, PETSC_MIN_REAL, PETSC_MIN_REAL, PETSC_MIN_REAL}, slip[3], size = 0, sine,
            cosine;
  PetscBool plane = PETSC_TRUE;
  SlipFaultCell first, c;

  PetscFunctionBegin;
  mesh->kind->cell(mesh, 0, &first);
  for (PetscInt row = 0; row < mesh->N; row++) {
    PetscReal off = 0, turned = 0;

    mesh->kind->cell(mesh, row, &c);
    for (PetscInt j = 0; j < 3; j++) {
      off += (c.centre[j] - first.centre[j]) * first.direction[2][j];
      turned = PetscMax(turned, PetscAbsReal(c.direction[2][j] - first.direction[2][j]));
    }
    size = PetscMax(size, PetscMax(c.size[0], c.size[1]));
    if (PetscAbsReal(off) > 1e-6 * size || turned > 1e-6) plane = PETSC_FALSE;
  }
  for (PetscInt i = 0; i < mesh->n; i++) {
    const PetscReal value[4] = {vinf[i], -vinf[i], rake[i], -rake[i]};

    for (PetscInt k = 0; k < 4; k++) bounds[k] = PetscMax(bounds[k], value[k]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 4, MPIU_REAL, MPIU_MAX, fault->comm));
  PetscCheck(plane && bounds[0] == -bounds[1] && bounds[2] == -bounds[3], fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_surface_motion total needs cells on one plane with one -%sfault_loading_rate and one "
             "-%sfault_rake, as the plates beside others are not known: expected relative",
             prefix, prefix, prefix);
  SlipDegrees(bounds[2], &sine, &cosine);
  for (PetscInt j = 0; j < 3; j++) slip[j] = cosine * first.direction[0][j] - sine * first.direction[1][j];
  PetscCall(PetscMalloc1(3 * s->n, &s->plates));
  for (PetscInt k = 0; k < s->n; k++) {
    const PetscReal *p = s->point + 2 * k, *normal = first.direction[2];
    const PetscReal off =
      (p[0] - first.centre[0]) * normal[0] + (p[1] - first.centre[1]) * normal[1] - first.centre[2] * normal[2];
    const PetscReal far = PetscMax(hypot(p[0], p[1]), hypot(first.centre[0], first.centre[1])) + size;
    const PetscReal side = off >= -1e-14 * far ? 0.5 : -0.5; /* rounding puts a point on the trace slightly off it */

    for (PetscInt j = 0; j < 3; j++) s->plates[3 * k + j] = side * bounds[0] * slip[j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  const char *text = fault->options.text[FAULT_SURFACE_STATIONS];
  PetscReal *points;
  Surface *s;
  PetscBool total;

  PetscFunctionBegin;
  (void)ts;
  *wanted = text[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&s));
  *ctx = s;
  s->fault = fault;
  PetscCall(SlipFaultReadPoints(fault, FAULT_SURFACE_STATIONS, "xy", PETSC_FALSE, &s->n, &points));
  PetscCall(PetscMalloc1(2 * s->n, &s->point));
  for (PetscInt k = 0; k < s->n; k++) {
    s->point[2 * k] = points[3 * k];
    s->point[2 * k + 1] = points[3 * k + 2];
  }
  PetscCall(PetscFree(points));
  PetscCall(PetscMalloc2((size_t)(3 * s->n) * (size_t)(fault->layout.components * fault->mesh.n), &s->matrix,
                         1 + 6 * s->n, &s->row));
  PetscCall(PetscStrcmp(fault->options.text[FAULT_SURFACE_MOTION], "total", &total));
  if (total) PetscCall(MovePlates(fault, s));
  PetscCall(MakeMatrix(fault, s));
  PetscCall(VecDuplicate(fault->critical.uc, &s->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: checks that a file that is continued has the same points and the same motion. */
static PetscErrorCode CheckPlaces(SlipFault fault, SlipH5 *h, const Surface *s)
{
  const char *prefix = SlipFaultPrefix(fault), *name[] = {PLACES "/x", PLACES "/y"};
  PetscInt n = 0, total = 0;
  PetscReal *place;
  PetscBool has, same = PETSC_TRUE;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, PLACES, &has));
  for (PetscInt c = 0; c < 2 && has && same; c++) {
    PetscCall(SlipH5ReadReal(h, name[c], 1, &n, &place));
    for (PetscInt k = 0; k < n && n == s->n; k++)
      same = same && place[k] == s->point[2 * k + c] ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(PetscFree(place));
  }
  PetscCheck(has && same && n == s->n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has other points of the surface than -%sfault_surface_stations: expected the same ones, or another "
             "-%sfault_output",
             h->target, prefix, prefix);
  PetscCall(SlipH5ReadAttrInt(h, ALL, "total", &total));
  PetscCheck(!total == !s->plates, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has stations with -%sfault_surface_motion %s: expected the same, or another -%sfault_output",
             h->target, prefix, total ? "total" : "relative", prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* On rank 0: writes the positions of stations, and a group for each, which shows its part of all. */
static PetscErrorCode WriteStations(const Surface *s, SlipH5 *h)
{
  const char *const station[] = {"station"}, *const name[] = {"x", "y"};
  const SlipH5Axes all = {.row = "time", .n = 1, .axis = station, .rest = "component"};
  const SlipH5Axes one = {.row = "time"}, places = {.row = "station"};
  char group[64], path[96];
  PetscReal *place;

  PetscFunctionBegin;
  PetscCall(SlipH5WriteAttrInt(h, ALL, "total", s->plates ? 1 : 0));
  PetscCall(SlipH5NameDimensions(h, ALL, &all));
  PetscCall(PetscMalloc1(s->n, &place));
  for (PetscInt c = 0; c < 2; c++) {
    for (PetscInt k = 0; k < s->n; k++) place[k] = s->point[2 * k + c];
    PetscCall(PetscSNPrintf(path, sizeof(path), PLACES "/%s", name[c]));
    PetscCall(SlipH5WriteReal(h, path, 1, &s->n, place, "m"));
  }
  PetscCall(PetscFree(place));
  PetscCall(SlipH5NameDimensions(h, PLACES, &places));
  for (PetscInt k = 0; k < s->n; k++) {
    PetscCall(PetscSNPrintf(group, sizeof(group), "/surface/%" PetscInt_FMT, k));
    PetscCall(SlipH5Group(h, group, PETSC_FALSE));
    PetscCall(SlipH5WriteAttrReal(h, group, "x", s->point[2 * k]));
    PetscCall(SlipH5WriteAttrReal(h, group, "y", s->point[2 * k + 1]));
    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/time", group));
    PetscCall(SlipH5Link(h, ALL "/time", path));
    for (PetscInt c = 1; c < SURFACE_COLUMNS; c++) {
      PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", group, Columns[c].name));
      PetscCall(SlipH5CreateView(h, path, c == 1 ? ALL "/displacement" : ALL "/velocity", k, Columns[c].unit));
    }
    if (k < SURFACE_NAMED) PetscCall(SlipH5NameDimensions(h, group, &one));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Links the rests of times of long runs, also where the run was not long when the file was created. */
static PetscErrorCode LinkRests(Surface *s, SlipH5 *h)
{
  char path[96];
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, ALL "/time_rest", &has));
  for (PetscInt k = 0; k < s->n && has; k++) {
    PetscBool linked;

    PetscCall(PetscSNPrintf(path, sizeof(path), "/surface/%" PetscInt_FMT "/time_rest", k));
    PetscCall(SlipH5Has(h, path, &linked));
    if (!linked) PetscCall(SlipH5Link(h, ALL "/time_rest", path));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceLayout(SlipFault fault, SlipOutput output, void *ctx)
{
  Surface *s = (Surface *)ctx;
  const PetscInt entries[] = {0, -s->n, -s->n};
  SlipH5 *h = SlipOutputFile(output);
  PetscErrorCode ierr = PETSC_SUCCESS;

  PetscFunctionBegin;
  s->output = output;
  if (h && output->resumed) ierr = CheckPlaces(fault, h, s);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscCall(SlipOutputAddTable(output, ALL, SURFACE_COLUMNS, Columns, entries, &s->table));
  if (h && !output->resumed) ierr = WriteStations(s, h);
  if (h && !ierr) ierr = LinkRests(s, h);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Surface *s = (Surface *)ctx;
  const PetscMPIInt n = (PetscMPIInt)(1 + 6 * s->n);
  PetscReal *const moved = s->row + 1, *const moves = moved + 3 * s->n;
  PetscMPIInt rank;

  PetscFunctionBegin;
  (void)ts;
  (void)step;
  PetscCall(SlipLogOutputBegin());
  PetscCall(PetscArrayzero(s->row, n));
  s->ground.m = 3 * s->n;
  s->ground.matrix = s->matrix;
  PetscCall((*fault->cell_ops->ground)(fault, w, s->start, &s->ground, moved, moves));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCallMPI(MPI_Reduce(rank ? s->row : MPI_IN_PLACE, s->row, n, MPIU_REAL, MPIU_SUM, 0, fault->comm));
  s->row[0] = time;
  for (PetscInt k = 0; k < 3 * s->n && s->plates; k++) {
    moved[k] += (fault->loads.origin + time - s->begin) * s->plates[k];
    moves[k] += s->plates[k];
  }
  PetscCall(SlipOutputAddRows(s->output, s->table, 1, s->row));
  PetscCall(SlipLogOutputEnd());
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  Surface *s = (Surface *)ctx;

  PetscFunctionBegin;
  if (!s->known || !s->output->resumed) {
    PetscCall(SlipFaultGetDisplacement(fault, w, s->start));
    s->begin = fault->loads.origin + time;
  }
  if (!s->output->start_known) PetscCall(SurfaceStep(fault, ts, 0, time, w, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Saves or loads the start. Stations that the earlier run did not have begin where this run continues. */
static PetscErrorCode SurfaceVisit(SlipFault fault, SlipState state, void *ctx)
{
  Surface *s = (Surface *)ctx;
  PetscBool has;

  PetscFunctionBegin;
  (void)fault;
  PetscCall(SlipStateHas(state, "surface", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(state, "surface"));
  PetscCall(SlipStateVec(state, "start", s->start));
  if (s->plates) PetscCall(SlipStateReal(state, "begin", 1, &s->begin));
  s->known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceDestroy(void **ctx)
{
  Surface *s = (Surface *)*ctx;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&s->start));
  PetscCall(SlipFaultLookDestroy(s->fault, &s->ground));
  PetscCall(PetscFree(s->point));
  PetscCall(PetscFree(s->plates));
  PetscCall(PetscFree2(s->matrix, s->row));
  PetscCall(PetscFree(*ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const SlipFaultObserver SlipFaultSurfaceObserver = {.name = "surface",
                                                    .create = SurfaceCreate,
                                                    .layout = SurfaceLayout,
                                                    .start = SurfaceStart,
                                                    .step = SurfaceStep,
                                                    .visit = SurfaceVisit,
                                                    .destroy = SurfaceDestroy};
