/* -fault_surface_stations: points of the free surface whose displacement and velocity are recorded at every accepted step, in the groups
   /surface/0, /surface/1, ... of the output. What moves a point is the slip of all cells less that of the far field, u - u(start): where
   plates drag a fault, their own motion of half the loading rate on either side comes on top. A row is a product of a dense matrix,
   made once, with displacements and slip rates, of which each process has the columns of its cells. */
#include <slipstep/private/slipfaultobservers.h>
#include <slipstep/private/slipmatcells.h>
#include <slipelasticity.h>
#include <stdlib.h>
#include <string.h>

static const SlipOutputColumn Columns[] = {
  {"time", "s", PETSC_FALSE}, {"displacement", "m", PETSC_FALSE}, {"velocity", "m/s", PETSC_FALSE}};
static const PetscInt Entries[] = {0, 3, 3};
enum { SURFACE_COLUMNS = PETSC_STATIC_ARRAY_LENGTH(Columns), SURFACE_NUMBERS = 7 };

typedef struct {
  PetscInt n;
  PetscReal *point;  /* [n][2] x, y [m] */
  PetscReal *matrix; /* [local cells][n][3] displacement for 1 m of slip [m/m] */
  PetscReal *row;    /* [n][7] */
  PetscBool known;   /* a checkpoint has it */
  Vec start;         /* displacement at the start [m] */
  SlipOutput output; /* which has their tables, from this one on */
  PetscInt table;
} Surface;

static PetscErrorCode ReadPoint(SlipFault fault, const char text[], PetscReal point[2])
{
  const char *c = text;
  PetscInt n = 0;
  char *end;

  PetscFunctionBegin;
  do {
    point[n] = (PetscReal)strtod(c, &end);
    if (end == c || PetscIsInfOrNanReal(point[n])) break;
    c = end + strspn(end, " ");
    n++;
  } while (n < 2 && *c == ',' && c++);
  PetscCheck(n == 2 && !*c, fault->comm, PETSC_ERR_ARG_WRONG,
             "-%sfault_surface_stations has the point \"%s\", expected points \"x,y;x,y\" in m", SlipFaultPrefix(fault),
             text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MakeMatrix(SlipFault fault, Surface *s)
{
  const PetscReal nu = fault->options.value[FAULT_POISSON_RATIO];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    SlipFaultCell c;

    fault->mesh.kind->cell(&fault->mesh, SlipFaultMeshRow(&fault->mesh, i), &c);
    SlipSurfaceDisplacement(nu, &(SlipRectangle){c.centre[0], c.centre[1], c.centre[2], c.size[0], c.size[1]}, s->n,
                            s->point, s->matrix + 3 * s->n * i);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceCreate(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  const char *text = fault->options.text[FAULT_SURFACE_STATIONS], *prefix = SlipFaultPrefix(fault);
  Surface *s;
  PetscBool half_space;
  char **point;
  int n;

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
  PetscCall(PetscStrToArray(text, ';', &n, &point));
  PetscCheck(n > 0, fault->comm, PETSC_ERR_ARG_WRONG,
             "-%sfault_surface_stations is \"%s\", expected points \"x,y;x,y\" in m", prefix, text);
  PetscCall(PetscNew(&s));
  *ctx = s;
  s->n = n;
  PetscCall(PetscMalloc3(2 * n, &s->point, 3 * n * fault->mesh.n, &s->matrix, SURFACE_NUMBERS * n, &s->row));
  for (int k = 0; k < n; k++) PetscCall(ReadPoint(fault, point[k], s->point + 2 * k));
  PetscCall(PetscStrToArrayDestroy(n, point));
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
  if (!s->known || !s->output->resumed)
    PetscCall(VecStrideGather(w, fault->layout.displacement, s->start, INSERT_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SurfaceStep(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Surface *s = (Surface *)ctx;
  const PetscReal *a, *u0, *vinf = fault->fields.cell[FIELD_LOADING_RATE];
  const SlipArrays arrays[] = {{w, .read = &a}, {s->start, .read = &u0}};
  const PetscMPIInt n = (PetscMPIInt)(SURFACE_NUMBERS * s->n);
  PetscMPIInt rank;

  PetscFunctionBegin;
  (void)ts;
  (void)step;
  PetscCall(SlipLogOutputBegin());
  PetscCall(PetscArrayzero(s->row, n));
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal u = a[SlipFaultDisplacementAt(fault, i)] - u0[i], v = a[SlipFaultRateAt(fault, i)] - vinf[i];
    const PetscReal *m = s->matrix + 3 * s->n * i;

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
  PetscCall(PetscFree3(s->point, s->matrix, s->row));
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
