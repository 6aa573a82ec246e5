/* Small faults under a pore pressure, drawn at random. */
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
  double side, stress, drop, weakening; /* [m], [Pa], of friction, over the stiffness of a cell by itself */
  double peak, excess;                  /* largest pressure [Pa]; of strength over stress, over the peak's effect */
  double scatter, length;               /* of the excess: relative, [cells] */
  double source[2], reach, diffusivity; /* x, z [cells]; how far pressure goes [m]; [m^2/s] */
  double end, stop;                     /* of the run, of the injection; 0: never [s] */
  double time[MAX_CORNERS + 1], amplitude[MAX_CORNERS + 1]; /* of a record; of ramps, over the peak */
  PetscInt corners;
  PressureKind kind;
  double thickness; /* [m] */
  PetscBool strip, weakens, linear, inertia, exact, half_space;
} Draw;

static void DrawMesh(Random *random, Draw *d)
{
  const PetscInt(*const kinds[])[2] = {Strips, Lines, Planes, Planes};
  const uint64_t kind = RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(kinds));
  const PetscInt *mesh = kinds[kind][RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Planes))];

  d->nx = mesh[0];
  d->nz = mesh[1];
  d->strip = kind == 0 ? PETSC_TRUE : PETSC_FALSE;
}

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

static void DrawPressure(Random *random, Draw *d)
{
  const double width = d->side * (double)PetscMax(d->nx, d->nz);

  d->kind = (PressureKind)RandomIndex(random, 3);
  if (d->strip && d->kind == PRESSURE_SOURCE) d->kind = PRESSURE_LINE;
  d->end = RandomLog(random, 1e4, 3e6);
  d->stop = RandomUniform(random) < 0.7 ? d->end * (0.3 + 0.5 * RandomUniform(random)) : 0;
  d->reach = 0.5 * width * RandomLog(random, 0.3, 1.2);
  d->diffusivity = d->reach * d->reach / (4 * (d->stop > 0 ? d->stop : d->end));
  d->peak = d->stress * RandomLog(random, 0.05, 0.6);
  d->excess = RandomLog(random, 0.03, 0.5);
  d->source[0] = (0.25 + 0.5 * RandomUniform(random)) * (double)d->nx;
  d->source[1] = (0.25 + 0.5 * RandomUniform(random)) * (double)d->nz;
  if (d->nx == 1) d->source[0] = 0.5;
  if (d->nz == 1) d->source[1] = 0.5;
  if (d->kind != PRESSURE_SOURCE) DrawRecord(random, d);
}

static void DrawFault(Random *random, Draw *d)
{
  double kind;

  *d = (Draw){0};
  DrawMesh(random, d);
  d->side = RandomLog(random, 30, 300);
  d->stress = RandomLog(random, 15e6, 80e6);
  d->weakens = RandomUniform(random) < 0.4 ? PETSC_TRUE : PETSC_FALSE;
  d->linear = RandomUniform(random) < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  d->drop = d->weakens ? FRICTION * RandomLog(random, 0.03, 0.2) : 0;
  d->weakening = RandomLog(random, 0.1, 0.6);
  d->scatter = RandomUniform(random) < 0.3 ? 0 : 0.5 * RandomUniform(random);
  d->length = RandomLog(random, 1, 6);
  d->thickness = RandomLog(random, 0.3, 1) * d->side * (double)PetscMax(d->nx, d->nz);
  kind = RandomUniform(random);
  d->inertia = kind < 0.25 ? PETSC_TRUE : PETSC_FALSE;
  d->exact = kind < 0.1 ? PETSC_TRUE : PETSC_FALSE;
  d->half_space = RandomUniform(random) < 0.3 && !d->strip ? PETSC_TRUE : PETSC_FALSE;
  DrawPressure(random, d);
}

/* ---- pressure ---- */

/* Of diffusion from a line with a constant flux for a time t, over that at the line after the time 1: r over the square
   root of 4 D */
static double Spread(double r, double t)
{
  const double x = t > 0 ? r / sqrt(t) : 0;

  return t > 0 ? sqrt(t) * (exp(-x * x) - sqrt(PETSC_PI) * x * erfc(x)) : 0;
}

/* Of corner k of the record, r from the source [Pa] */
static double RecordPressure(const Draw *d, double r, PetscInt k)
{
  const double last = d->stop > 0 ? d->stop : d->end, x = r / (2 * sqrt(d->diffusivity));

  if (d->kind == PRESSURE_RAMPS) return d->peak * d->amplitude[k] * exp(-(r / d->reach) * (r / d->reach));
  return d->peak * (Spread(x, d->time[k]) - (d->stop > 0 ? Spread(x, d->time[k] - d->stop) : 0)) / sqrt(last);
}

static PetscErrorCode WritePressure(const Draw *d, SlipH5 *h)
{
  const PetscInt rows = d->corners + 1, n = d->nx * d->nz, dims[2] = {rows, n};
  PetscReal *pressure, time[MAX_CORNERS + 1];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(rows * n, &pressure));
  for (PetscInt k = 0; k < rows; k++) {
    time[k] = (PetscReal)d->time[k];
    for (PetscInt i = 0; i < n; i++) {
      const double x = (double)(i % d->nx) + 0.5 - d->source[0], z = (double)(i / d->nx) + 0.5 - d->source[1];

      pressure[k * n + i] = (PetscReal)RecordPressure(d, d->side * hypot(x, z), k);
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

static PetscErrorCode SetNumbers(const Draw *d, SlipFault fault)
{
  const double stiffness = d->strip ? STRIP_STIFFNESS : RUN_CELL_STIFFNESS;
  const char *law = !d->weakens ? "constant" : d->linear ? "linear_slip_weakening" : "exponential_slip_weakening";
  const RunOption rows[] = {
    {"length_x", (d->strip ? STRIP_LENGTH * (double)d->nz : (double)d->nx) * d->side, NULL},
    {"depth_top", DEPTH, NULL},
    {"thickness", d->thickness, NULL},
    {"friction_residual", FRICTION - d->drop, NULL},
    {"friction_drop", d->drop, NULL},
    {"friction_slip", d->weakens ? d->drop * d->stress * d->side / (d->weakening * stiffness * RUN_SHEAR) : 1, NULL},
    {"friction_law", 0, law},
    {"initial", 0, "traction"},
    {"kernel", 0, d->half_space ? "half_space" : "full_space"},
    {"viscosity", 0, d->exact ? "sqrtm" : "radiation"},
    {"inertia", 0, d->inertia ? "yes" : "no"}};

  return RunSetOptions(fault, PETSC_STATIC_ARRAY_LENGTH(rows), rows);
}

static PetscErrorCode SetStress(Random *random, const Draw *d, SlipFault fault)
{
  const PetscInt n = d->nx * d->nz;
  PetscReal *stress;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &stress));
  RunDrawField(random, d->nx, d->nz, d->length, stress);
  for (PetscInt i = 0; i < n; i++)
    stress[i] = (PetscReal)(FRICTION * (d->stress - d->excess * d->peak *
                                                      PetscMax(1 + d->scatter * (double)stress[i], LEAST_EXCESS)));
  PetscCall(SlipFaultSetField(fault, "initial_traction", n, stress));
  PetscCall(PetscFree(stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InjectionDraw(RunEpisode *e, Random *random)
{
  Draw d;

  PetscFunctionBegin;
  DrawFault(random, &d);
  e->end = (PetscReal)d.end;
  PetscCall(RunNewFault(e, d.nx, d.nz, d.side, d.stress));
  PetscCall(SetNumbers(&d, e->fault));
  PetscCall(SetStress(random, &d, e->fault));
  if (d.kind == PRESSURE_SOURCE) {
    PetscCall(SetSource(&d, e->fault));
    PetscCall(SlipFaultSetUp(e->fault));
  } else
    PetscCall(SetUpWithRecord(&d, e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
