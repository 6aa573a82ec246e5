/* Small faults that rupture from a patch, drawn at random, and runs of them under a controller. */
#include "ruptures.h"
#include "common/files.h"
#include "runs/drawnfield.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>
#include <math.h>

#define SHEAR 30e9          /* [Pa] */
#define RESIDUAL 0.5        /* friction after all weakening */
#define CELL_STIFFNESS 1.05 /* of a square cell by itself, over the shear modulus by its side: sqrt(2)/pi 7/3 */
#define FULL 0.98           /* the stress outside of the patch is at most this share of the strength */
#define UNSTABLE 1.01       /* and this one in it */
#define COARSE_RTOL 1e-2
#define LEAST_BROKEN 0.1 /* share of the cells that a rupture breaks, not to be drawn again */
#define LONGEST 400      /* of the coarse run [T*] */
#define COARSE_STEPS 4000
#define MOST_ATTEMPTS 40000 /* of a reference and of classical controllers */
#define MARGINAL (PetscReal)1.25

static const PetscInt Meshes[][2] = {{12, 6}, {16, 6}, {10, 10}, {16, 8}, {24, 4}, {20, 6}};

/* ---- a fault ---- */

typedef struct {
  PetscInt nx, nz;
  double side, stress, drop, weakening, scatter, length; /* [m], [Pa], mean, over the stiffness, relative, [cells] */
  double share, patch[3];                                /* of the drop; x, z, radius [cells] */
  double thickness;                                      /* [m] */
  PetscBool inertia, exact;                              /* exact: viscosity by the square root */
} Draw;

static void DrawFault(Random *random, PetscInt larger, Draw *d)
{
  const PetscInt *mesh = Meshes[RandomIndex(random, PETSC_STATIC_ARRAY_LENGTH(Meshes))];
  const double kind = RandomUniform(random);

  d->nx = larger * mesh[0];
  d->nz = larger * mesh[1];
  d->side = RandomLog(random, 100, 1000);
  d->stress = RandomLog(random, 15e6, 100e6);
  d->drop = RandomLog(random, 0.05, 0.3);
  d->weakening = RandomLog(random, 0.2, 0.8);
  d->scatter = 0.3 * RandomUniform(random);
  d->length = RandomLog(random, 2, 8);
  d->share = 0.45 + 0.3 * RandomUniform(random);
  d->patch[2] = (1.2 + 1.3 * RandomUniform(random)) * 0.58 / (CELL_STIFFNESS * d->weakening) + 0.8;
  d->patch[0] = RandomUniform(random) * (double)d->nx;
  d->patch[1] = RandomUniform(random) * (double)d->nz;
  d->thickness = RandomLog(random, 0.3, 1) * d->side * (double)PetscMax(d->nx, d->nz);
  d->inertia = kind < 0.3 ? PETSC_TRUE : PETSC_FALSE;
  d->exact = kind < 0.1 ? PETSC_TRUE : PETSC_FALSE;
}

static PetscErrorCode SetNumbers(const Draw *d, SlipFault fault)
{
  const struct {
    const char *name;
    double value;
  } rows[] = {{"nx", (double)d->nx},
              {"nz", (double)d->nz},
              {"length_x", (double)d->nx * d->side},
              {"length_z", (double)d->nz * d->side},
              {"thickness", d->thickness},
              {"shear_modulus", SHEAR},
              {"normal_stress", d->stress},
              {"normal_stress_gradient", 0},
              {"friction_residual", RESIDUAL}};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++)
    PetscCall(SlipFaultSetReal(fault, rows[i].name, (PetscReal)rows[i].value));
  PetscCall(SlipFaultSetString(fault, "initial", "traction"));
  PetscCall(SlipFaultSetBool(fault, "initial_unstable", PETSC_TRUE));
  PetscCall(SlipFaultSetBool(fault, "inertia", d->inertia));
  PetscCall(SlipFaultSetString(fault, "viscosity", d->exact ? "sqrtm" : "radiation"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* weaken [n]: d_c [m] */
static PetscErrorCode SetFields(Random *random, const Draw *d, SlipFault fault, PetscReal weaken[])
{
  const PetscInt n = d->nx * d->nz;
  PetscReal *drop, *stress;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(n, &drop, n, &stress));
  DrawnField(random, d->nx, d->nz, d->length, drop);
  DrawnField(random, d->nx, d->nz, d->length, stress);
  for (PetscInt i = 0; i < n; i++) {
    const double x = (double)(i % d->nx) + 0.5 - d->patch[0], z = (double)(i / d->nx) + 0.5 - d->patch[1];
    double strength;

    drop[i] = (PetscReal)(d->drop * PetscMax(1 + d->scatter * (double)drop[i], 0.1));
    strength = (RESIDUAL + (double)drop[i]) * d->stress;
    stress[i] = (PetscReal)(d->stress * (RESIDUAL + d->share * (1 + d->scatter * (double)stress[i]) * (double)drop[i]));
    stress[i] = PetscMin(stress[i], (PetscReal)(FULL * strength));
    if (hypot(x, z) < d->patch[2]) stress[i] = (PetscReal)(UNSTABLE * strength);
    weaken[i] = (PetscReal)((double)drop[i] * d->stress * d->side / (d->weakening * CELL_STIFFNESS * SHEAR));
  }
  PetscCall(SlipFaultSetField(fault, "friction_drop", n, drop));
  PetscCall(SlipFaultSetField(fault, "friction_slip", n, weaken));
  PetscCall(SlipFaultSetField(fault, "initial_traction", n, stress));
  PetscCall(PetscFree2(drop, stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

static PetscErrorCode RunDestroy(RuptureRun *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->course));
  PetscCall(PetscFree2(r->broke, r->slip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

typedef struct {
  const RuptureEpisode *e;
  RuptureRun *r;
  PetscReal *before;   /* [2 n] slip and rate of each cell at the last step */
  PetscReal last, end; /* [s] */
  PetscInt nsteps;
  const double *steps; /* [nsteps] [s], then one to the end; NULL: the controller's */
} Watch;

/* When a cell's slip, a cubic between two steps, first reaches d_c; share: of the step */
static PetscReal Crossing(PetscReal s0, PetscReal v0, PetscReal s1, PetscReal v1, PetscReal h, PetscReal weaken)
{
  const SlipCourseNode node[2] = {{0, s0, v0}, {h, s1, v1}};

  return SlipCourseTime(2, node, weaken / s1);
}

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Watch *watch = (Watch *)ctx;
  RuptureRun *r = watch->r;
  PetscReal row[3] = {t, 0, 0};
  const PetscReal *a;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < r->n; i++) {
    const PetscReal v = PetscAbsReal(a[3 * i]), s = a[3 * i + 2];

    row[1] += s / (PetscReal)r->n;
    row[2] += v / (PetscReal)r->n;
    if (step > 0 && r->broke[i] < 0 && s >= watch->e->weaken[i])
      r->broke[i] = watch->last + Crossing(watch->before[2 * i], watch->before[2 * i + 1], s, v, t - watch->last,
                                           watch->e->weaken[i]);
    watch->before[2 * i] = r->slip[i] = s;
    watch->before[2 * i + 1] = v;
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(TableAdd(&r->course, row));
  watch->last = t;
  if (watch->steps && t < watch->end) {
    const PetscReal left = watch->end - t, h = step < watch->nsteps ? (PetscReal)watch->steps[step] : left;

    PetscCall(TSSetTimeStep(ts, PetscMin(h, left)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Until end [s]; most: steps after which it is not good; steps [nsteps]: in place of those of a controller, or NULL */
static PetscErrorCode IntegrateBy(const RuptureEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                                  PetscReal end, PetscInt most, PetscInt nsteps, const double steps[], RuptureRun *r)
{
  Watch watch = {.e = e, .r = r, .end = end, .nsteps = nsteps, .steps = steps};
  FaultRun run = {policy, type, setting, .end = end, .most = most, .follow = Follow, .ctx = &watch};

  PetscFunctionBegin;
  *r = (RuptureRun){.course = {.width = 3}, .n = e->n};
  PetscCall(PetscMalloc2(e->n, &r->broke, e->n, &r->slip));
  for (PetscInt i = 0; i < e->n; i++) r->broke[i] = -1;
  PetscCall(PetscCalloc1(2 * e->n, &watch.before));
  PetscCall(RunFault(e->fault, &run, &r->solves, &r->rejected, &r->good));
  PetscCall(PetscFree(watch.before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Integrate(const RuptureEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                                PetscReal end, PetscInt most, RuptureRun *r)
{
  return IntegrateBy(e, policy, type, setting, end, most, 0, NULL, r);
}

static const SlipCourseNode *Nodes(const RuptureRun *r)
{
  return (const SlipCourseNode *)r->course.data;
}

/* RMS over the cells that broke in the reference of the error of the time, over the rise time; a cell that broke in one of the two
   alone counts as 1. Cells whose final slip is close to d_c are left to the error of the field. */
static PetscReal BreakError(const RuptureEpisode *e, const RuptureRun *r)
{
  const PetscReal *a = r->broke, *b = e->reference.broke;
  PetscReal sum = 0;
  PetscInt broken = 0;

  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal over = e->reference.slip[i] / e->weaken[i];

    if (over > 1 / MARGINAL && over < MARGINAL) continue;
    if (b[i] >= 0) broken++;
    if (a[i] < 0 && b[i] < 0) continue;
    sum += a[i] < 0 || b[i] < 0 ? 1 : PetscMin(1, PetscSqr((a[i] - b[i]) / e->rise));
  }
  return PetscSqrtReal(sum / (PetscReal)PetscMax(broken, 1));
}

/* The largest of all; negative: the run did not end */
static void Compare(const RuptureEpisode *e, const RuptureRun *r, PetscReal errors[], PetscReal *error)
{
  for (PetscInt i = 0; i < SLIP_NUM_ERRORS; i++) errors[i] = 1;
  *error = -1;
  if (!r->good) return;
  SlipCourseCompare(r->course.n, Nodes(r), e->reference.course.n, Nodes(&e->reference), errors);
  errors[SLIP_ERROR_FIELD] = RunFieldError(e->n, r->slip, e->reference.slip);
  *error = PetscMax(SlipMeasureOf(&SlipMeasures[0], errors), BreakError(e, r));
}

PetscErrorCode RuptureEpisodeRunSteps(RuptureEpisode *e, PetscInt n, const double dt[], PetscReal *error)
{
  PetscReal errors[SLIP_NUM_ERRORS];
  RuptureRun r;

  PetscFunctionBegin;
  PetscCall(IntegrateBy(e, NULL, TSADAPTNONE, RUPTURE_REFERENCE_RTOL, e->end, n + 1, n, dt, &r));
  if (r.rejected > 0) r.good = PETSC_FALSE;
  Compare(e, &r, errors, error);
  PetscCall(RunDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RuptureEpisodeRun(RuptureEpisode *e, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                 PetscReal rtol, PetscInt *solves, PetscInt *rejected, PetscReal errors[],
                                 PetscReal *error)
{
  RuptureRun r;

  PetscFunctionBegin;
  PetscCall(Integrate(e, policy, type, policy ? accuracy : rtol, e->end, policy ? 20 * e->usual : MOST_ATTEMPTS, &r));
  *solves = r.solves;
  *rejected = r.rejected;
  Compare(e, &r, errors, error);
  PetscCall(RunDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an episode ---- */

/* e->reference to end, and its rise; good: it got there */
static PetscErrorCode SetReference(RuptureEpisode *e)
{
  RuptureRun *r = &e->reference;

  PetscFunctionBegin;
  PetscCall(Integrate(e, NULL, TSADAPTPI, RUPTURE_REFERENCE_RTOL, e->end, MOST_ATTEMPTS, r));
  if (r->good)
    e->rise =
      SlipCourseTime(r->course.n, Nodes(r), (PetscReal)0.9) - SlipCourseTime(r->course.n, Nodes(r), (PetscReal)0.1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The coarse run does not end where the rupture has faded, after 3 to 15 T* mostly, so that episodes are far longer than their ruptures:
   rupture.h5 was trained and measured on these. One that takes too many steps is judged by those that it took. */
static PetscErrorCode Judge(RuptureEpisode *e, double margin, PetscBool *good)
{
  RuptureRun r;
  PetscReal tstar;
  PetscInt broken = 0;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetTimeScale(e->fault, &tstar));
  PetscCall(Integrate(e, NULL, TSADAPTPI, COARSE_RTOL, LONGEST * tstar, COARSE_STEPS, &r));
  for (PetscInt i = 0; i < e->n; i++) broken += r.broke[i] >= 0 ? 1 : 0;
  e->end = Nodes(&r)[r.course.n - 1].time * (PetscReal)margin;
  e->usual = r.solves;
  *good = (r.good || r.course.n > COARSE_STEPS) && (PetscReal)broken >= LEAST_BROKEN * (PetscReal)e->n ? PETSC_TRUE
                                                                                                       : PETSC_FALSE;
  PetscCall(RunDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SetReference(e));
  *good = e->reference.good;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RuptureEpisodeCreate(uint64_t seed, PetscInt larger, RuptureEpisode *e)
{
  PetscBool good = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  while (!good) {
    Draw d;

    *e = (RuptureEpisode){0};
    DrawFault(&random, larger, &d);
    e->n = d.nx * d.nz;
    PetscCall(PetscMalloc1(e->n, &e->weaken));
    PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &e->fault));
    PetscCall(SetNumbers(&d, e->fault));
    PetscCall(SetFields(&random, &d, e->fault, e->weaken));
    PetscCall(SlipFaultSetUp(e->fault));
    PetscCall(Judge(e, 1 + 2 * RandomUniform(&random) * RandomUniform(&random), &good));
    if (!good) PetscCall(RuptureEpisodeDestroy(e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RuptureEpisodeOfFault(SlipFault fault, PetscReal end, RuptureEpisode *e)
{
  Vec w;

  PetscFunctionBegin;
  *e = (RuptureEpisode){.fault = fault, .end = end};
  PetscCall(SlipFaultReference(fault));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(VecGetSize(w, &e->n));
  PetscCall(VecDestroy(&w));
  e->n /= 3;
  PetscCall(PetscMalloc1(e->n, &e->weaken));
  PetscCall(SlipFaultGetField(fault, "friction_slip", e->n, e->weaken));
  PetscCall(SetReference(e));
  PetscCheck(e->reference.good, PETSC_COMM_SELF, PETSC_ERR_NOT_CONVERGED,
             "The reference, pi at the tolerance %g, does not reach the %g s of -ts_max_time in %d attempts",
             RUPTURE_REFERENCE_RTOL, (double)end, MOST_ATTEMPTS);
  PetscCheck(Nodes(&e->reference)[e->reference.course.n - 1].slip > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
             "Nothing slips in the %g s of -ts_max_time", (double)end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RuptureEpisodeOfFamily(const Family *family, uint64_t seed, RuptureEpisode *e)
{
  char text[ERROR_TEXT] = "";
  PetscBool good = PETSC_FALSE;
  PetscErrorCode code;
  PetscReal margin;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  for (PetscInt tries = 0; !good; ++tries) {
    PetscCheck(
      tries < FAMILY_TRIES, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG,
      "-train_family %s: of %d faults drawn none ruptures: expected one whose slip passes friction_slip in a tenth "
      "of the cells, and then fades within %g T*",
      family->file, FAMILY_TRIES, (double)LONGEST);
    *e = (RuptureEpisode){0};
    PetscCall(PetscPushErrorHandler(ErrorCapture, text));
    code = RuptureDrawOfFamily(family, &random, &e->fault, &e->n, &e->weaken, &margin);
    PetscCall(PetscPopErrorHandler());
    PetscCheck(!code, PETSC_COMM_SELF, code, "-train_family %s: a fault of it cannot be made: %s", family->file, text);
    PetscCall(Judge(e, (double)margin, &good));
    if (!good) PetscCall(RuptureEpisodeDestroy(e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RuptureEpisodeDestroy(RuptureEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(RunDestroy(&e->reference));
  PetscCall(PetscFree(e->weaken));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
