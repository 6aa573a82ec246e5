/* Maps and sums of one event of a loaded fault, some cells of which do not rupture, against the states of all steps. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include "tempdir.h"

enum { NX = 6, NZ = 5, N = NX * NZ, STEPS = 180 };
static const PetscReal step_length = 0.05, rate = 0.02, loading = 1e-3;

/* The states at the start and after each step; one that is a rest may be longer */
typedef struct {
  PetscInt n;
  PetscReal t[STEPS + 1], v[STEPS + 1][N], s[STEPS + 1][N];
} Course;

static PetscErrorCode Watch(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Course *c = (Course *)ctx;
  const PetscReal *a;

  if (step < 0 || step > STEPS) return PETSC_SUCCESS;
  c->n = step + 1;
  c->t[step] = t;
  a = VecRead(w);
  for (int i = 0; i < N; i++) {
    c->v[step][i] = a[3 * i];
    c->s[step][i] = a[3 * i + 2];
  }
  return PETSC_SUCCESS;
}

/* What cell i has slipped at t, along a straight line between the ends of the step */
static PetscReal SlipAt(const Course *c, PetscReal t, int i)
{
  int k = 0;

  while (k + 2 < c->n && c->t[k + 1] < t) k++;
  return c->s[k][i] + (t - c->t[k]) / (c->t[k + 1] - c->t[k]) * (c->s[k + 1][i] - c->s[k][i]);
}

/* When its slip rate passes the bound, likewise; -1: it does not */
static PetscReal RuptureOf(const Course *c, int i)
{
  for (int k = 0; k + 1 < c->n; k++) {
    const PetscReal a = c->v[k][i], b = c->v[k + 1][i];

    if (a <= rate && b > rate) return c->t[k] + (rate - a) / (b - a) * (c->t[k + 1] - c->t[k]);
  }
  return -1;
}

/* The only entry of a column, or the only map */
static void Read(const char file[], const char name[], PetscInt ndim, PetscReal value[])
{
  PetscInt dims[3];
  PetscReal *x;
  SlipH5 h;

  ok(SlipH5OpenRead(file, &h));
  ok(SlipH5ReadReal(&h, name, ndim, dims, &x));
  assert_int_equal(1, dims[0]);
  ok(PetscArraycpy(value, x, ndim == 1 ? 1 : N));
  ok(PetscFree(x));
  ok(SlipH5Close(&h));
}

static void Solve(const char file[], Course *course)
{
  SlipFault fault;
  TS ts;
  Vec w;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "catalogue", file));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"loading_rate", loading}, {"event_rate", rate}));
  fault->options.catalogue_maps = PETSC_TRUE;
  ok(FaultStart(fault, TSADAPTNONE, step_length, STEPS * step_length, &w, &ts));
  ok(SlipFaultOutputStart(fault, ts));
  ok(TSMonitorSet(ts, Watch, course, NULL));
  ok(TSSolve(ts, w));
  ok(SlipFaultOutputFinish(fault, ts, 0, 0));
  ObjectsDestroy(&w, &ts, &fault);
}

static void one_event(void **state)
{
  static Course course;
  const PetscReal area = 500 * 600, G = 30e9;
  PetscReal slip[N], rupture[N], onset, end, moment, size, mean, first = 1e300, sum = 0, broken = 0;
  PetscInt broke = 0;
  char folder[TEMPDIR_LENGTH], file[TEMPDIR_LENGTH + 16];

  assert_int_equal(0, TempDirMake("maps", folder));
  snprintf(file, sizeof(file), "%s/events.h5", folder);
  Solve(file, &course);
  Read(file, "/onset", 1, &onset);
  Read(file, "/end", 1, &end);
  Read(file, "/moment", 1, &moment);
  Read(file, "/area", 1, &size);
  Read(file, "/mean_slip", 1, &mean);
  Read(file, "/maps/slip", 3, slip);
  Read(file, "/maps/rupture_time", 3, rupture);
  assert_int_equal(0, TempDirRemove(folder));
  assert_true(onset > 1 && end > onset + 2 && end < course.t[course.n - 1]);
  for (int i = 0; i < N; i++) {
    const PetscReal when = RuptureOf(&course, i);

    /* Cells that do not heal count the slip as s, whatever their displacement, which loading changes by 3e-3 m
       meanwhile. Straight lines err by the acceleration, 0.05 m/s^2 at most, times the step squared over 8, at both
       ends here and in the catalogue. */
    assert_true(fabs(slip[i] - (SlipAt(&course, end, i) - SlipAt(&course, onset, i))) < 5e-5);
    sum += slip[i];
    assert_true(isnan(rupture[i]) == (when < 0));
    if (when < 0) continue;
    /* straight lines of the rate and of its logarithm differ by (change of the rate)^2/(8 rate), 1 % of the change */
    assert_true(fabs(onset + rupture[i] - when) < 0.02 * step_length);
    first = PetscMin(first, rupture[i]);
    broken += slip[i];
    broke++;
  }
  /* the event begins where the first cell ruptures, to rounding of the times */
  assert_true(first < 1e-13);
  assert_true(broke > 0 && broke < N);
  assert_true(fabs(size / (area * (PetscReal)broke) - 1) < 1e-14);
  assert_true(fabs(mean / (broken / (PetscReal)broke) - 1) < 1e-13);
  /* of all slip, also of cells that never reach the rate, here some tenth of it */
  assert_true(fabs(moment / (G * area * sum) - 1) < 1e-13);
  assert_true(broken < 0.97 * sum);
}

SLIP_TESTS(one_event)
