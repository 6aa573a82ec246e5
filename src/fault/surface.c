/* -fault_surface_stations: points of the free surface, in a list or a file, whose displacement and velocity are recorded at every
   accepted step, in the groups /surface/0, /surface/1, ... of the output. What moves a point is the slip of all cells along their rakes
   less that of the far field, u - u(start): where plates drag a fault, their own motion of half the loading rate on either side comes on
   top. A row is a product of a dense matrix, made once, with displacements and slip rates, of which each process has the columns of its
   cells. */
#include <slipstep/private/slipfaultobservers.h>
#include <slipstep/private/slipmatcells.h>
#include <slipstep/private/slipelasticity.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const SlipOutputColumn Columns[] = {
  {"time", "s", PETSC_FALSE}, {"displacement", "m", PETSC_FALSE}, {"velocity", "m/s", PETSC_FALSE}};
static const PetscInt Entries[] = {0, 3, 3};
enum { SURFACE_COLUMNS = PETSC_STATIC_ARRAY_LENGTH(Columns), SURFACE_NUMBERS = 7 };

typedef struct {
  PetscInt n;
  PetscReal *point;  /* [n][2] x, y [m] */
  PetscReal *matrix; /* [local cells][components][n][3] displacement for 1 m of slip or opening [m/m] */
  PetscReal *row;    /* [n][7] */
  PetscBool known;   /* a checkpoint has it */
  Vec start;         /* displacement at the start [m] */
  SlipOutput output; /* which has their tables, from this one on */
  PetscInt table;
} Surface;

#define POINTS "expected points \"x,y;x,y\" in m, or a file with a point \"x,y\" or \"x y\" on each line"
enum { LONGEST_LINE = 256 };

/* Two numbers with a comma between, or where it may be so only space, and nothing else */
static PetscBool ReadPoint(const char text[], PetscBool space, PetscReal point[2])
{
  static const char Space[] = " \t\r\n";
  const char *c = text;
  char *end;

  for (PetscInt k = 0; k < 2; k++) {
    point[k] = (PetscReal)strtod(c, &end);
    if (end == c || PetscIsInfOrNanReal(point[k])) return PETSC_FALSE;
    c = end + strspn(end, Space);
    if (k == 0 && *c == ',')
      c++;
    else if (k == 0 && (!space || c == end))
      return PETSC_FALSE;
  }
  return *c ? PETSC_FALSE : PETSC_TRUE;
}

/* Rank 0: n points of a text file, freed with PetscFree() */
static PetscErrorCode ReadFile(SlipFault fault, const char name[], PetscInt *n, PetscReal **point)
{
  const char *prefix = SlipFaultPrefix(fault);
  FILE *file = fopen(name, "r");
  char line[LONGEST_LINE];
  PetscInt room = 0;

  PetscFunctionBegin;
  *n = 0;
  *point = NULL;
  PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "%s (-%sfault_surface_stations) cannot be read: %s", name,
             prefix, strerror(errno));
  for (PetscInt number = 1; fgets(line, LONGEST_LINE, file); number++) {
    const size_t length = strlen(line), used = strcspn(line, "#");
    const PetscBool whole = length + 1 < LONGEST_LINE || line[length - 1] == '\n' ? PETSC_TRUE : PETSC_FALSE;

    line[whole ? used : strcspn(line, "\n")] = '\0';
    if (whole && line[strspn(line, " \t\r\n")] == '\0') continue;
    if (*n == room) PetscCall(PetscRealloc(2 * (size_t)(room += 64) * sizeof(**point), point));
    if (whole && ReadPoint(line, PETSC_TRUE, *point + 2 * *n)) {
      ++*n;
      continue;
    }
    (void)fclose(file);
    PetscCall(PetscFree(*point));
    line[strcspn(line, "\r\n")] = '\0';
    SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
            "%s (-%sfault_surface_stations), line %" PetscInt_FMT
            ": \"%.60s\", expected a point \"x,y\" or \"x y\" in m, or a comment after #",
            name, prefix, number, line);
  }
  (void)fclose(file);
  PetscCheck(*n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s (-%sfault_surface_stations) has no points, expected one \"x,y\" or \"x y\" in m on each line", name,
             prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective: the points of a file, or of a list */
static PetscErrorCode ReadPoints(SlipFault fault, const char text[], PetscInt *n, PetscReal **points)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscErrorCode ierr = PETSC_SUCCESS;
  PetscBool file = PETSC_FALSE;
  PetscMPIInt rank;
  char **point;
  int count;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  if (!rank) PetscCall(PetscTestFile(text, '\0', &file));
  PetscCallMPI(MPI_Bcast(&file, 1, MPIU_BOOL, 0, fault->comm));
  if (file) {
    if (!rank) ierr = ReadFile(fault, text, n, points);
    PetscCall(SlipErrorBcast(fault->comm, ierr));
    PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, fault->comm));
    if (rank) PetscCall(PetscMalloc1(2 * (size_t)*n, points));
    PetscCallMPI(MPI_Bcast(*points, (PetscMPIInt)(2 * *n), MPIU_REAL, 0, fault->comm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrToArray(text, ';', &count, &point));
  PetscCheck(count > 0, fault->comm, PETSC_ERR_ARG_WRONG, "-%sfault_surface_stations is \"%s\", " POINTS, prefix, text);
  *n = count;
  PetscCall(PetscMalloc1(2 * (size_t)count, points));
  for (int k = 0; k < count; k++)
    PetscCheck(ReadPoint(point[k], PETSC_FALSE, *points + 2 * k), fault->comm, PETSC_ERR_ARG_WRONG,
               "-%sfault_surface_stations has the point \"%s\", " POINTS, prefix, point[k]);
  PetscCall(PetscStrToArrayDestroy(count, point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static SlipDippingRectangle RectangleOf(const SlipFaultCell *c)
{
  const PetscReal *along = c->direction[0], *down = c->direction[1], degrees = 180 / PETSC_PI;

  return (SlipDippingRectangle){c->centre[0],
                                c->centre[1],
                                c->centre[2],
                                c->size[0],
                                c->size[1],
                                degrees * PetscAtan2Real(along[1], along[0]),
                                PetscMin(90, degrees * PetscAtan2Real(down[2], hypot(down[0], down[1])))};
}

/* For 1 m of slip of a cell along its rake, or along strike and up dip, and of opening. Strike slip on planes along x has a form of its own. */
static PetscErrorCode MakeMatrix(SlipFault fault, Surface *s)
{
  const PetscReal nu = fault->options.value[FAULT_POISSON_RATIO], *rakes = fault->fields.cell[FIELD_RAKE];
  const PetscInt components = fault->layout.components;
  PetscReal *point;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(3 * s->n, &point));
  for (PetscInt k = 0; k < s->n; k++) PetscCall(PetscArraycpy(point + 3 * k, s->point + 2 * k, 2));
  for (PetscInt row = 0; row < components * fault->mesh.n; row++) {
    const PetscInt i = row / components, k = row % components;
    const PetscReal rake = components == 1 ? rakes[i] : k == 0 ? 0 : 90;
    PetscReal *u = s->matrix + 3 * s->n * row, slip[3] = {0, 0, 0};
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
    rectangle = RectangleOf(&c);
    PetscCall(SlipDippingDisplacement(nu, PETSC_FALSE, &rectangle, slip, s->n, point, u));
  }
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  const char *text = fault->options.text[FAULT_SURFACE_STATIONS], *prefix = SlipFaultPrefix(fault);
  Surface *s;
  PetscBool half_space;

  PetscFunctionBegin;
  (void)ts;
  *wanted = text[0] ? PETSC_TRUE : PETSC_FALSE;
  if (!*wanted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(fault->options.text[FAULT_OUTPUT][0], fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_surface_stations %s is written to the output: expected -%sfault_output", prefix, text, prefix);
  PetscCall(PetscStrcmp(fault->options.text[FAULT_KERNEL], "half_space", &half_space));
  PetscCheck(half_space, fault->comm, PETSC_ERR_ARG_INCOMP,
             "-%sfault_surface_stations needs a free surface: expected -%sfault_kernel half_space", prefix, prefix);
  PetscCheck(strlen(text) + 1 < sizeof(fault->options.text[FAULT_SURFACE_STATIONS]), fault->comm,
             PETSC_ERR_ARG_OUTOFRANGE, "-%sfault_surface_stations is too long, expected less than %d characters",
             prefix, PETSC_MAX_PATH_LEN - 1);
  PetscCall(PetscNew(&s));
  *ctx = s;
  PetscCall(ReadPoints(fault, text, &s->n, &s->point));
  PetscCall(
    PetscMalloc2(3 * s->n * fault->layout.components * fault->mesh.n, &s->matrix, SURFACE_NUMBERS * s->n, &s->row));
  PetscCall(MakeMatrix(fault, s));
  PetscCall(VecDuplicate(fault->critical.uc, &s->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A file that goes on has the same points. */
static PetscErrorCode CheckPlaces(SlipFault fault, SlipH5 *h, const Surface *s)
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscReal place[2] = {0, 0};
  PetscInt n = 0;
  PetscBool has;
  char group[64];

  PetscFunctionBegin;
  PetscCall(SlipH5Has(h, "/surface", &has));
  if (has) PetscCall(SlipH5CountMembers(h, "/surface", &n));
  for (PetscInt k = 0; k < n && n == s->n; k++) {
    PetscCall(PetscSNPrintf(group, sizeof(group), "/surface/%" PetscInt_FMT, k));
    PetscCall(SlipH5ReadAttrReal(h, group, "x", &place[0]));
    PetscCall(SlipH5ReadAttrReal(h, group, "y", &place[1]));
    if (place[0] != s->point[2 * k] || place[1] != s->point[2 * k + 1]) n = -1;
  }
  PetscCheck(n == s->n, PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
             "%s has other points of the surface than -%sfault_surface_stations: expected the same ones, or another "
             "-%sfault_output",
             h->name, prefix, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceLayout(SlipFault fault, SlipOutput output, void *ctx)
{
  Surface *s = (Surface *)ctx;
  SlipH5 *h = SlipOutputFile(output);
  PetscErrorCode ierr = PETSC_SUCCESS;
  char group[64];

  PetscFunctionBegin;
  s->output = output;
  if (h && output->resumed) ierr = CheckPlaces(fault, h, s);
  PetscCall(SlipErrorBcast(fault->comm, ierr));
  for (PetscInt k = 0; k < s->n; k++) {
    PetscInt table;

    PetscCall(PetscSNPrintf(group, sizeof(group), "/surface/%" PetscInt_FMT, k));
    PetscCall(SlipOutputAddTable(output, group, SURFACE_COLUMNS, Columns, Entries, &table));
    PetscCall(SlipOutputAddAttribute(output, group, "x", s->point[2 * k]));
    PetscCall(SlipOutputAddAttribute(output, group, "y", s->point[2 * k + 1]));
    if (!k) s->table = table;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceStart(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  Surface *s = (Surface *)ctx;

  PetscFunctionBegin;
  (void)ts;
  (void)time;
  if (!s->known || !s->output->resumed) PetscCall(SlipFaultGetDisplacement(fault, w, s->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Surface *s = (Surface *)ctx;
  const PetscReal *a, *u0, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  const SlipArrays arrays[] = {{w, .read = &a}, {s->start, .read = &u0}};
  const PetscMPIInt n = (PetscMPIInt)(SURFACE_NUMBERS * s->n);
  const PetscInt components = fault->layout.components;
  PetscMPIInt rank;

  PetscFunctionBegin;
  (void)ts;
  (void)step;
  PetscCall(SlipLogOutputBegin());
  PetscCall(PetscArrayzero(s->row, n));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt row = 0; row < components * fault->mesh.n; row++) {
    const PetscInt i = row / components, j = row % components;
    const PetscReal u = a[SlipFaultDisplacementAt(fault, i) + j] - u0[row],
                    v = a[SlipFaultRateAt(fault, i) + j] - vinf[i] * SlipFaultAlong(fault, i)[j];
    const PetscReal *m = s->matrix + 3 * s->n * row;

    for (PetscInt k = 0; k < s->n; k++)
      for (PetscInt c = 0; c < 3; c++) {
        s->row[SURFACE_NUMBERS * k + 1 + c] += m[3 * k + c] * u;
        s->row[SURFACE_NUMBERS * k + 4 + c] += m[3 * k + c] * v;
      }
  }
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCallMPI(MPI_Reduce(rank ? s->row : MPI_IN_PLACE, s->row, n, MPIU_REAL, MPIU_SUM, 0, fault->comm));
  for (PetscInt k = 0; k < s->n; k++) s->row[SURFACE_NUMBERS * k] = time;
  PetscCall(SlipOutputAddRows(s->output, s->table, s->n, s->row));
  PetscCall(SlipLogOutputEnd());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where they began; those that the run of before did not have begin where this one goes on. */
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
  s->known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceDestroy(void **ctx)
{
  Surface *s = (Surface *)*ctx;

  PetscFunctionBegin;
  PetscCall(VecDestroy(&s->start));
  PetscCall(PetscFree(s->point));
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
