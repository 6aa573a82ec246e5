/* Runs of faults under a pore pressure, and their errors. */
#include "injections.h"
#include "environment/libraryrun.h"
#include <slipcompat.h>

#define USUAL_TYPE TSADAPTHEURISTIC
#define USUAL_RTOL 1e-3
#define CONFIRM_RTOL (8 * INJECTION_REFERENCE_RTOL) /* of the run that confirms the reference */
#define CONFIRMED 1e-3                              /* with this error at most */
#define BEGUN 0.01                                  /* a cell has begun at this share of the final largest slip */
#define MARGINAL (PetscReal)1.25
#define LEAST_BEGUN 0.1     /* share of the cells that begin, and */
#define FEWEST_BEGUN 3      /* so many at least, not to be drawn again */
#define MOST_ATTEMPTS 10000 /* of a reference, and of classical controllers */

static const SlipCourseNode *Nodes(const InjectionRun *r)
{
  return (const SlipCourseNode *)r->course.data;
}

static PetscErrorCode RunDestroy(InjectionRun *r)
{
  PetscFunctionBegin;
  PetscCall(TableClear(&r->course));
  PetscCall(PetscFree2(r->began, r->slip));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

typedef struct {
  InjectionRun *r;
  PetscReal passed;  /* [m] */
  PetscReal *before; /* [2 n] slip and rate of each cell at the last step */
  PetscReal last;    /* [s] */
} Watch;

static PetscErrorCode Follow(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Watch *watch = (Watch *)ctx;
  InjectionRun *r = watch->r;
  PetscReal row[3] = {t, 0, 0};
  const PetscReal *a;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < r->n; i++) {
    const PetscReal v = PetscAbsReal(a[3 * i]), s = a[3 * i + 2];
    PetscReal *before = watch->before + 2 * i;

    row[1] += s / (PetscReal)r->n;
    row[2] += v / (PetscReal)r->n;
    if (step > 0 && r->began[i] < 0 && s >= watch->passed) {               /* slip is a cubic between two steps */
      const PetscReal h = t - watch->last, most = 3 * (s - before[0]) / h; /* faster ends would make it fall within */
      const SlipCourseNode node[2] = {{0, before[0], PetscMin(before[1], most)}, {h, s, PetscMin(v, most)}};

      r->began[i] = watch->last + SlipCourseTime(2, node, watch->passed / s);
    }
    before[0] = r->slip[i] = s;
    before[1] = v;
  }
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(TableAdd(&r->course, row));
  watch->last = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* most: steps after which it is not good */
static PetscErrorCode Integrate(const InjectionEpisode *e, SlipPolicy policy, TSAdaptType type, PetscReal setting,
                                PetscInt most, InjectionRun *r)
{
  Watch watch = {.r = r, .passed = e->passed};
  FaultRun run = {policy, type, setting, .end = e->end, .most = most, .follow = Follow, .ctx = &watch};

  PetscFunctionBegin;
  *r = (InjectionRun){.course = {.width = 3}, .n = e->n};
  PetscCall(PetscMalloc2(e->n, &r->began, e->n, &r->slip));
  for (PetscInt i = 0; i < e->n; i++) r->began[i] = -1;
  PetscCall(PetscCalloc1(2 * e->n, &watch.before));
  PetscCall(RunFault(e->fault, &run, &r->solves, &r->rejected, &r->good));
  PetscCall(PetscFree(watch.before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- its error ---- */

/* RMS over the cells that begin in the reference of the error of the time, over the duration; a cell that begins in one of the two alone
   counts as 1. Cells whose final slip is close to where they begin are left to the error of the field. */
static PetscReal FrontError(const InjectionEpisode *e, const InjectionRun *r)
{
  const PetscReal *a = r->began, *b = e->reference.began;
  PetscReal sum = 0;
  PetscInt begun = 0;

  for (PetscInt i = 0; i < e->n; i++) {
    const PetscReal over = e->reference.slip[i] / e->passed;

    if (over > 1 / MARGINAL && over < MARGINAL) continue;
    if (b[i] >= 0) begun++;
    if (a[i] < 0 && b[i] < 0) continue;
    sum += a[i] < 0 || b[i] < 0 ? 1 : PetscSqr((a[i] - b[i]) / e->end);
  }
  return PetscSqrtReal(sum / (PetscReal)PetscMax(begun, 1));
}

PetscErrorCode InjectionEpisodeRun(InjectionEpisode *e, SlipPolicy policy, PetscReal accuracy, TSAdaptType type,
                                   PetscReal rtol, PetscInt *solves, PetscInt *rejected, InjectionErrors *errors,
                                   PetscReal *error)
{
  InjectionRun r;

  PetscFunctionBegin;
  PetscCall(Integrate(e, policy, type, policy ? accuracy : rtol, policy ? 20 * e->usual : MOST_ATTEMPTS, &r));
  *solves = r.solves;
  *rejected = r.rejected;
  *errors = (InjectionErrors){1, 1, 1};
  *error = -1;
  if (r.good) {
    *errors =
      (InjectionErrors){.course = SlipCourseLevy(r.course.n, Nodes(&r), e->reference.course.n, Nodes(&e->reference)),
                        .field = RunFieldError(e->n, r.slip, e->reference.slip),
                        .front = FrontError(e, &r)};
    *error = PetscMax(PetscMax(errors->course, errors->field), errors->front);
  }
  PetscCall(RunDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- an episode ---- */

/* Enough of it slips, and two tight runs agree. */
static PetscErrorCode Judge(InjectionEpisode *e, PetscBool *good)
{
  InjectionErrors errors;
  InjectionRun r;
  PetscReal most = 0, error;
  PetscInt begun = 0, solves, rejected;

  PetscFunctionBegin;
  e->passed = PETSC_MAX_REAL;
  PetscCall(Integrate(e, NULL, USUAL_TYPE, USUAL_RTOL, MOST_ATTEMPTS / 8, &r));
  for (PetscInt i = 0; i < e->n; i++) most = PetscMax(most, r.slip[i]);
  for (PetscInt i = 0; i < e->n; i++) begun += r.slip[i] > BEGUN * most ? 1 : 0;
  e->passed = (PetscReal)BEGUN * most;
  e->usual = r.solves;
  *good = r.good && most > 0 && begun >= FEWEST_BEGUN && (PetscReal)begun >= LEAST_BEGUN * (PetscReal)e->n
            ? PETSC_TRUE
            : PETSC_FALSE;
  PetscCall(RunDestroy(&r));
  if (!*good) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Integrate(e, NULL, INJECTION_REFERENCE_TYPE, INJECTION_REFERENCE_RTOL, MOST_ATTEMPTS, &e->reference));
  *good = e->reference.good;
  if (*good) {
    PetscCall(
      InjectionEpisodeRun(e, NULL, 0, INJECTION_REFERENCE_TYPE, CONFIRM_RTOL, &solves, &rejected, &errors, &error));
    *good = error >= 0 && error < CONFIRMED ? PETSC_TRUE : PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InjectionEpisodeCreate(uint64_t seed, InjectionEpisode *e)
{
  PetscBool good = PETSC_FALSE;
  Random random;

  PetscFunctionBegin;
  RandomSeed(&random, seed);
  while (!good) {
    *e = (InjectionEpisode){0};
    PetscCall(InjectionFaultDraw(&random, &e->fault, &e->n, &e->end, &e->weakens, &e->inertia));
    PetscCall(Judge(e, &good));
    if (!good) PetscCall(InjectionEpisodeDestroy(e));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode InjectionEpisodeDestroy(InjectionEpisode *e)
{
  PetscFunctionBegin;
  PetscCall(RunDestroy(&e->reference));
  PetscCall(SlipFaultDestroy(&e->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
