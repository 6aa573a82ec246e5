/* Small faults that slip under a pore pressure alone (train -train_algorithm tolerances -train_problem injection),
   drawn at random: the problem by which tolerances of injections are measured. */
#define _POSIX_C_SOURCE 200809L /* mkdtemp() */
#include "runs.h"
#include <slipcompat.h>
#include <slipstep/rooms/sliph5.h>
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#define FRICTION 0.6 /* at the start */
#define DEPTH 3000   /* of the upper edge [m] */
#define EULER 0.57721566490153286061
#define STRIP_STIFFNESS 0.64 /* of a long strip: 2/pi */
#define STRIP_LENGTH 200     /* over the width of all strips */
#define LEAST_EXCESS 0.05    /* of the mean excess of strength over stress */

enum { MAX_CORNERS = 24 };

/* A point source; diffusion from a line, as in SEAS BP6, and ramps of a fixed pattern as records of some corners */
typedef enum { PRESSURE_SOURCE, PRESSURE_LINE, PRESSURE_RAMPS } PressureKind;

static const PetscInt Strips[][2] = {{1, 24}, {1, 32}, {1, 48}, {1, 64}};
static const PetscInt Lines[][2] = {{24, 1}, {32, 1}, {48, 1}, {64, 1}};
static const PetscInt Planes[][2] = {{8, 8}, {10, 8}, {12, 10}, {16, 12}};

typedef struct {
  PetscInt nx, nz;
  double side, peak, excess; /* [m]; largest pressure [Pa]; of strength over stress, over the peak's effect */
  double source[2], reach, diffusivity;                     /* x, z [cells]; how far pressure goes [m]; [m^2/s] */
  double end, stop;                                         /* of the run, of the injection; 0: never [s] */
  double time[MAX_CORNERS + 1], amplitude[MAX_CORNERS + 1]; /* of a record; of ramps, over the peak */
  PetscInt corners;
  PressureKind kind;
} Draw;

static int Later(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;

  return x < y ? -1 : x > y ? 1 : 0;
}

/* Corners of a record: dense at first, as pressure grows with the root of time, and again after the end of the
   injection; of ramps anywhere. */
static void DrawRecord(Random *random, Draw *d)
{
  d->corners = d->kind == PRESSURE_RAMPS ? 3 + (PetscInt)RandomIndex(random, 6)
                                         : 6 + 2 * (PetscInt)RandomIndex(random, (MAX_CORNERS - 6) / 2 + 1);
  d->time[0] = d->amplitude[0] = 0;
  if (d->kind == PRESSURE_RAMPS) {
    for (PetscInt k = 1; k <= d->corners; k++) {
      d->time[k] = d->end * (0.02 + 0.98 * RandomUniform(random));
      d->amplitude[k] = RandomUniform(random);
    }
    qsort(d->time + 1, (size_t)d->corners, sizeof(double), Later);
    d->amplitude[1 + RandomIndex(random, (uint64_t)d->corners - 1)] = 1;
    return;
  }
  for (PetscInt k = 1; k <= d->corners; k++) {
    const PetscInt half = d->corners / 2;
    const double stop = d->stop > 0 ? d->stop : 0.5 * d->end;
    const double share = k <= half ? (double)k / (double)half : (double)(k - half) / (double)(d->corners - half);

    d->time[k] = k <= half ? stop * share * share : stop + (d->end - stop) * share * share;
  }
}

static void DrawPressure(Random *random, PetscBool strip, double stress, Draw *d)
{
  const double width = d->side * (double)PetscMax(d->nx, d->nz);

  d->kind = (PressureKind)RandomIndex(random, 3);
  if (strip && d->kind == PRESSURE_SOURCE) d->kind = PRESSURE_LINE;
  d->end = RandomLog(random, 1e4, 3e6);
  d->stop = RandomUniform(random) < 0.7 ? d->end * (0.3 + 0.5 * RandomUniform(random)) : 0;
  d->reach = 0.5 * width * RandomLog(random, 0.3, 1.2);
  d->diffusivity = d->reach * d->reach / (4 * (d->stop > 0 ? d->stop : d->end));
  d->peak = stress * RandomLog(random, 0.05, 0.6);
  d->excess = RandomLog(random, 0.03, 0.5);
  d->source[0] = (0.25 + 0.5 * RandomUniform(random)) * (double)d->nx;
  d->source[1] = (0.25 + 0.5 * RandomUniform(random)) * (double)d->nz;
  if (d->nx == 1) d->source[0] = 0.5;
  if (d->nz == 1) d->source[1] = 0.5;
  if (d->kind != PRESSURE_SOURCE) DrawRecord(random, d);
}

/* ---- pressure ---- */

/* Of diffusion from a line with a constant flux for a time t, over that at the line after the time 1: r over the square
   root of 4 D */
static double Spread(double r, double t)
{
  const double x = t > 0 ? r / sqrt(t) : 0;

  return t > 0 ? sqrt(t) * (exp(-x * x) - sqrt(PETSC_PI) * x * erfc(x)) : 0;
}

/* Of the corners of the record, by the distance r from the source */
static PetscErrorCode WritePressure(const Draw *d, SlipH5 *h)
{
  const PetscInt rows = d->corners + 1, n = d->nx * d->nz, dims[2] = {rows, n};
  const double last = d->stop > 0 ? d->stop : d->end;
  PetscReal *pressure, time[MAX_CORNERS + 1];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rows * n, &pressure));
  for (PetscInt k = 0; k < rows; k++) {
    time[k] = (PetscReal)d->time[k];
    for (PetscInt i = 0; i < n; i++) {
      const double r = d->side *
                       hypot((double)(i % d->nx) + 0.5 - d->source[0], (double)(i / d->nx) + 0.5 - d->source[1]),
                   x = r / (2 * sqrt(d->diffusivity));

      if (d->kind == PRESSURE_RAMPS)
        pressure[k * n + i] = (PetscReal)(d->peak * d->amplitude[k] * exp(-(r / d->reach) * (r / d->reach)));
      else
        pressure[k * n + i] =
          (PetscReal)(d->peak * (Spread(x, d->time[k]) - (d->stop > 0 ? Spread(x, d->time[k] - d->stop) : 0)) /
                      sqrt(last));
    }
  }
  PetscCall(SlipH5WriteReal(h, "/time", 1, dims, time, "s"));
  PetscCall(SlipH5WriteReal(h, "/pressure", 2, dims, pressure, "Pa"));
  PetscCall(PetscFree(pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets up the fault with a record, which faults read from files. A pressure function would need none, but has no
   corners for steps to end at. */
static PetscErrorCode SetUpFromFile(const Draw *d, const char file[], SlipFault fault)
{
  PetscErrorCode code;
  SlipH5 h;

  PetscFunctionBegin;
  PetscCall(SlipH5Create(file, &h));
  code = WritePressure(d, &h);
  if (code) (void)SlipH5Abandon(&h);
  PetscCall(code);
  PetscCall(SlipH5Close(&h));
  PetscCall(SlipFaultSetString(fault, "pore_pressure", file));
  PetscCall(SlipFaultSetUp(fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The file is in a folder of its own, and neither is left where the fault cannot be set up. */
static PetscErrorCode SetUpWithRecord(const Draw *d, SlipFault fault)
{
  char folder[PETSC_MAX_PATH_LEN], file[PETSC_MAX_PATH_LEN + 16];
  PetscErrorCode code;
  PetscBool removed;

  PetscFunctionBegin;
  PetscCall(PetscGetTmp(PETSC_COMM_SELF, folder, sizeof(folder)));
  /* the template of mkdtemp(3), which replaces the six last letters by a unique name */
  PetscCall(PetscStrlcat(folder, "/slipstep_injection_XXXXXX", sizeof(folder)));
  PetscCheck(mkdtemp(folder), PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "Cannot make the directory %s", folder);
  PetscCall(PetscSNPrintf(file, sizeof(file), "%s/pressure.h5", folder));
  code = SetUpFromFile(d, file, fault);
  (void)unlink(file);
  removed = rmdir(folder) ? PETSC_FALSE : PETSC_TRUE;
  PetscCall(code);
  PetscCheck(removed, PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "Cannot remove %s", folder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pressure of a source is p* E1: that of its own cell at the end of the injection is to be the peak. */
static PetscErrorCode SetSource(const Draw *d, SlipFault fault)
{
  const double x = d->side * d->side / (PETSC_PI * exp(1)) / (d->reach * d->reach), most = x - EULER - log(x);
  char point[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(point, sizeof(point), "%.17g,%.17g", d->source[0] * d->side, DEPTH + d->source[1] * d->side));
  PetscCall(SlipFaultSetString(fault, "injection", point));
  PetscCall(SlipFaultSetReal(fault, "injection_pressure", (PetscReal)(d->peak / most)));
  PetscCall(SlipFaultSetReal(fault, "injection_diffusivity", (PetscReal)d->diffusivity));
  PetscCall(SlipFaultSetReal(fault, "injection_stop", (PetscReal)d->stop));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the fault ---- */

/* Strips and lines are long in one direction, planes in two. Some have inertia, of these some viscosity by the square
   root. */
PetscErrorCode InjectionDraw(RunEpisode *e, Random *random)
{
  const PetscInt(*const meshes[])[2] = {Strips, Lines, Planes, Planes};
  const uint64_t shape = RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(meshes));
  const PetscInt *mesh = meshes[shape][RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Planes))];
  const PetscBool strip = shape == 0 ? PETSC_TRUE : PETSC_FALSE;
  const double stiffness = strip ? STRIP_STIFFNESS : RUN_CELL_STIFFNESS;
  const PetscInt n = mesh[0] * mesh[1];
  Draw d = {.nx = mesh[0], .nz = mesh[1], .side = RandomLog(random, 30, 300)};
  const double normal = RandomLog(random, 15e6, 80e6); /* [Pa] */
  const PetscBool weakens = RandomUniform(random) < 0.4 ? PETSC_TRUE : PETSC_FALSE,
                  linear = RandomUniform(random) < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  /* of friction; over the stiffness of a cell by itself; of the excess, relative and [cells]; [m] */
  const double drop = weakens ? FRICTION * RandomLog(random, 0.03, 0.2) : 0, weakening = RandomLog(random, 0.1, 0.6),
               scatter = RandomUniform(random) < 0.3 ? 0 : 0.5 * RandomUniform(random),
               length = RandomLog(random, 1, 6),
               thickness = RandomLog(random, 0.3, 1) * d.side * (double)PetscMax(d.nx, d.nz),
               kind = RandomUniform(random);
  const PetscBool half_space = RandomUniform(random) < 0.3 && !strip ? PETSC_TRUE : PETSC_FALSE;
  PetscReal *stress;

  PetscFunctionBegin;
  DrawPressure(random, strip, normal, &d);
  const RunOption rows[] = {
    {"length_x", (strip ? STRIP_LENGTH * (double)d.nz : (double)d.nx) * d.side, NULL},
    {"depth_top", DEPTH, NULL},
    {"thickness", thickness, NULL},
    {"friction_residual", FRICTION - drop, NULL},
    {"friction_drop", drop, NULL},
    {"friction_slip", weakens ? drop * normal * d.side / (weakening * stiffness * RUN_SHEAR) : 1, NULL},
    {"friction_law", 0,
     !weakens ? "constant"
     : linear ? "linear_slip_weakening"
              : "exponential_slip_weakening"},
    {"initial", 0, "traction"},
    {"kernel", 0, half_space ? "half_space" : "full_space"},
    {"viscosity", 0, kind < 0.1 ? "sqrtm" : "radiation"},
    {"inertia", 0, kind < 0.25 ? "yes" : "no"}};

  e->end = (PetscReal)d.end;
  PetscCall(RunNewFault(e, d.nx, d.nz, d.side, normal));
  PetscCall(RunSetOptions(e->fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscCall(PetscMalloc1(n, &stress));
  RunDrawField(random, d.nx, d.nz, length, stress);
  for (PetscInt i = 0; i < n; i++)
    stress[i] =
      (PetscReal)(FRICTION * (normal - d.excess * d.peak * PetscMax(1 + scatter * (double)stress[i], LEAST_EXCESS)));
  PetscCall(SlipFaultSetField(e->fault, "initial_traction", n, stress));
  PetscCall(PetscFree(stress));
  if (d.kind == PRESSURE_SOURCE) {
    PetscCall(SetSource(&d, e->fault));
    PetscCall(SlipFaultSetUp(e->fault));
  } else
    PetscCall(SetUpWithRecord(&d, e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- runs ---- */

#define USUAL_TYPE TSADAPTHEURISTIC
#define USUAL_RTOL 1e-3
#define CONFIRM_RTOL (8 * RUN_INJECTION_RTOL) /* of the run that confirms the reference */
#define CONFIRMED 1e-3                        /* with this error at most */
#define BEGUN 0.01                            /* a cell has begun at this share of the final largest slip */
#define LEAST_BEGUN 0.1                       /* share of the cells that begin, and */
#define FEWEST_BEGUN 3                        /* so many at least, not to be drawn again */
#define MOST_ATTEMPTS 10000                   /* of a reference, and of classical controllers */

/* The largest of the Levy distance of mean slip over time, over the final slip and the duration, the errors of the
   cells' final slips, and of the times at which they begin, over the duration */
static PetscErrorCode Compare(const RunEpisode *e, const RunResult *r, PetscReal errors[], PetscReal *error)
{
  PetscFunctionBegin;
  errors[SLIP_ERROR_HISTORY] =
    SlipCourseLevy(r->course.n, CourseNodes(&r->course), e->reference.course.n, CourseNodes(&e->reference.course));
  errors[SLIP_ERROR_FIELD] = RunFieldError(e->n, r->slip, 1, e->reference.slip);
  errors[SLIP_ERROR_SHIFT] = RunPassedError(e, r, e->end);
  *error = PetscMax(PetscMax(errors[SLIP_ERROR_HISTORY], errors[SLIP_ERROR_FIELD]), errors[SLIP_ERROR_SHIFT]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Enough of it slips, and two tight runs agree. */
static PetscErrorCode Judge(RunEpisode *e, PetscBool *good)
{
  const RunRequest usual = {NULL, USUAL_TYPE, USUAL_RTOL, .end = e->end, .most = MOST_ATTEMPTS / 8},
                   tight = {NULL, RUN_INJECTION_TYPE, RUN_INJECTION_RTOL, .end = e->end, .most = MOST_ATTEMPTS};
  PetscReal most = 0;
  PetscInt begun = 0;
  EpisodeResult confirmed;
  RunResult r;

  PetscFunctionBegin;
  PetscCall(RunIntegrate(e, &usual, &r));
  for (PetscInt i = 0; i < e->n; i++) most = PetscMax(most, r.slip[i]);
  for (PetscInt i = 0; i < e->n; i++) begun += r.slip[i] > BEGUN * most ? 1 : 0;
  e->usual = r.solves;
  e->work = r.work;
  *good = r.good && most > 0 && begun >= FEWEST_BEGUN && (PetscReal)begun >= LEAST_BEGUN * (PetscReal)e->n
            ? PETSC_TRUE
            : PETSC_FALSE;
  PetscCall(RunResultDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(e->n, &e->level));
  for (PetscInt i = 0; i < e->n; i++) e->level[i] = (PetscReal)BEGUN * most;
  PetscCall(RunIntegrate(e, &tight, &e->reference));
  *good = e->reference.good;
  if (*good) {
    PetscCall(RunEpisodeRun(e, NULL, RUN_INJECTION_TYPE, CONFIRM_RTOL, &confirmed));
    *good = confirmed.done == 1 && confirmed.error < CONFIRMED ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const RunKind RunInjection = {.size = sizeof(RunEpisode),
                              .column = 2,
                              .slips = 1,
                              .bounded = PETSC_TRUE,
                              .draw = InjectionDraw,
                              .judge = Judge,
                              .compare = Compare,
                              .most = MOST_ATTEMPTS,
                              .expected =
                                "slips: expected one of which a tenth of the cells, and three of them, slip a "
                                "hundredth of the most",
                              .worst = 50};

/* ---- the problem: no policy of it is trained ---- */

static const CMAProblem CMAInjections = {RUNS, .stream = 15, .runs = &RunInjection, .create = RunsCreate,
                                         .classical = RunsClassical};

const Problem ProblemInjection = {
  .name = "injection", .meaning = "small faults that slip under a pore pressure", .cma = &CMAInjections};
