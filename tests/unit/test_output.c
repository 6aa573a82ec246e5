/* The output of a run that stops and goes on: the rows of both are those of one run; and what an output may replace. */
#define _DEFAULT_SOURCE /* symlink(), mkfifo() */
#include "unit.h"
#include "tempdir.h"
#include <slipstep/rooms/sliph5.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static char dir[TEMPDIR_LENGTH], cwd[4096];

/* dw/dt = -w in steps of 1/8, which sum up exactly */
static PetscErrorCode Decay(TS ts, PetscReal t, Vec w, Vec f, void *ctx)
{
  PetscCall(VecCopy(w, f));
  return VecScale(f, -1);
}

static PetscErrorCode Row(TS ts, PetscReal t, Vec w, Vec r, PetscReal row[], void *ctx)
{
  PetscCheck(!r, PETSC_COMM_SELF, PETSC_ERR_PLIB, "there is no constraint");
  return VecSum(w, row);
}

/* A run from step `from` to step `to` */
static PetscErrorCode Start(const char file[], PetscInt from, PetscInt to, Vec w, TS *ts, SlipOutput *out)
{
  static const SlipOutputColumn column = {"w", "m", PETSC_FALSE};

  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(TSSetRHSFunction(*ts, NULL, Decay, NULL));
  PetscCall(TSSetType(*ts, TSBATHE));
  SetAdapt(*ts, TSADAPTNONE);
  PetscCall(TSSetTimeStep(*ts, 0.125));
  PetscCall(TSSetTime(*ts, 0.125 * (PetscReal)from));
  PetscCall(TSSetStepNumber(*ts, from));
  PetscCall(TSSetMaxSteps(*ts, to));
  PetscCall(TSSetMaxTime(*ts, 100));
  PetscCall(TSSetExactFinalTime(*ts, TS_EXACTFINALTIME_STEPOVER));
  PetscCall(TSSetSolution(*ts, w));
  return SlipOutputCreate(*ts, file, 1, &column, Row, NULL, out);
}

/* Rows of a series, and the attribute complete; of a copy, as HDF5 would find what this process itself writes */
static PetscReal *Read(const char file[], const char path[], PetscInt *n, PetscInt *complete)
{
  PetscReal *x;
  SlipH5 h;
  char command[64];

  snprintf(command, sizeof(command), "cp %s copy.h5", file);
  assert_int_equal(0, system(command));
  ok(SlipH5OpenRead("copy.h5", &h));
  ok(SlipH5ReadReal(&h, path, 1, n, &x));
  ok(SlipH5ReadAttrInt(&h, "/", "complete", complete));
  ok(SlipH5Close(&h));
  return x;
}

static void resumes(void **state)
{
  static const char *const paths[] = {"/series/time", "/series/w", "/steps/time", "/steps/dt", "/steps/accepted"};
  TS ts;
  Vec w, half;
  SlipOutput out;
  PetscInt steps, series, n, m, complete;
  PetscReal *x, *y;

  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &w));
  ok(VecDuplicate(w, &half));
  ok(VecSet(w, 1));
  ok(Start("one.h5", 0, 200, w, &ts, &out));
  ok(TSSolve(ts, w));
  ok(SlipOutputFinish(&out, 1, 2));
  ok(TSDestroy(&ts));

  /* 80 steps, of which 70 are in the checkpoint; then its process ends */
  ok(VecSet(w, 1));
  ok(Start("two.h5", 0, 70, w, &ts, &out));
  ok(TSSolve(ts, w));
  ok(VecCopy(w, half));
  ok(SlipOutputSync(out, &steps, &series));
  assert_int_equal(70, steps);
  assert_int_equal(71, series); /* with the start */
  ok(TSSetMaxSteps(ts, 80));
  ok(TSSolve(ts, w));
  x = Read("two.h5.part", "/series/w", &n, &complete);
  assert_true(n >= 71 && !complete);
  PetscFree(x);
  ok(SlipOutputDestroy(&out));
  ok(TSDestroy(&ts));
  assert_int_not_equal(0, access("two.h5", F_OK));
  x = Read("two.h5.part", "/steps/dt", &n, &complete);
  assert_true(n == 80 && !complete);
  PetscFree(x);

  /* it is not thrown away, nor continued by a run of other columns or with more rows than there are */
  ok(VecCopy(half, w));
  ok(Start("two.h5", 0, 5, w, &ts, &out));
  fails(TSSolve(ts, w), "two.h5.part holds 80 rows of an unfinished run");
  ok(SlipOutputDestroy(&out));
  ok(TSDestroy(&ts));
  ok(VecDestroy(&w)); /* TSSolve() has left it locked */
  ok(VecDuplicate(half, &w));
  ok(Start("two.h5", 70, 200, w, &ts, &out));
  fails(SlipOutputResume(out, 70, 82), "/series/time in");
  ok(SlipOutputDestroy(&out));
  ok(TSDestroy(&ts));

  ok(VecCopy(half, w));
  ok(Start("two.h5", 70, 200, w, &ts, &out));
  ok(SlipOutputResume(out, steps, series));
  x = Read("two.h5.part", "/series/time", &n, &complete);
  assert_true(n == 71 && !complete);
  PetscFree(x);
  ok(TSSolve(ts, w));
  ok(SlipOutputFinish(&out, 1, 2));
  ok(TSDestroy(&ts));
  for (size_t i = 0; i < sizeof(paths) / sizeof(*paths); i++) {
    x = Read("one.h5", paths[i], &n, &complete);
    y = Read("two.h5", paths[i], &m, &complete);
    assert_true(n == (i < 2 ? 201 : 200) && m == n && complete == 1);
    assert_memory_equal(x, y, (size_t)n * sizeof(*x));
    if (i < 2) assert_true(x[0] == (i ? 1 : 0)); /* the state of the start, at its time */
    PetscFree(x);
    PetscFree(y);
  }
  assert_int_not_equal(0, access("two.h5.part", F_OK));

  /* a run that has ended is extended; until then its file stays */
  ok(Start("two.h5", 200, 210, w, &ts, &out));
  ok(SlipOutputResume(out, 200, 201));
  ok(TSSolve(ts, w));
  x = Read("two.h5", "/series/w", &n, &complete);
  assert_true(n == 201 && complete == 1);
  PetscFree(x);
  ok(SlipOutputFinish(&out, 10, 20));
  ok(TSDestroy(&ts));
  x = Read("two.h5", "/series/w", &n, &complete);
  assert_true(n == 211 && complete == 1);
  PetscFree(x);
  {
    SlipH5 h;
    PetscReal wall;
    PetscInt restarts;

    ok(SlipH5OpenRead("two.h5", &h));
    ok(SlipH5ReadAttrReal(&h, "/result", "wall_time_solve", &wall));
    assert_true(wall > 22 && wall < 23); /* and some milliseconds of the run that was given up */
    ok(SlipH5ReadAttrInt(&h, "/run", "restarts", &restarts));
    assert_int_equal(2, restarts);
    ok(SlipH5Close(&h));
  }
  ObjectsDestroy(&w, &half);
}

/* ---- integrators that do not tell of their attempts ---- */

/* A step that is longer is left in its second stage. */
#define LONGEST 0.3
static PetscErrorCode InDomain(TS ts, PetscReal t, Vec w, PetscBool *accept)
{
  PetscReal begin;

  PetscCall(TSGetTime(ts, &begin));
  *accept = t - begin < LONGEST ? PETSC_TRUE : PETSC_FALSE;
  return PETSC_SUCCESS;
}

static PetscReal *Column(SlipH5 *h, const char path[], PetscInt want)
{
  PetscInt n;
  PetscReal *x;

  ok(SlipH5ReadReal(h, path, 1, &n, &x));
  assert_int_equal(want, n);
  return x;
}

/* dw/dt = -w from 1 by an explicit pair whose first steps are ten times too long for the domain and then for the
   tolerance: /steps has all attempts, each begins where the accepted ones before it end, and those that a stage ended
   say so */
static void attempts(void **state)
{
  static const SlipOutputColumn column = {"w", "m", PETSC_FALSE};
  PetscInt accepted, rejected, failed = 0, refused = 0, taken = 0;
  PetscReal *time, *dt, *accept, *converged, *error, now = 0;
  SlipOutput out;
  SlipH5 h;
  Vec w;
  TS ts;

  ok(VecCreateSeq(PETSC_COMM_SELF, 1, &w));
  ok(VecSet(w, 1));
  ok(TSCreate(PETSC_COMM_SELF, &ts));
  ok(TSSetRHSFunction(ts, NULL, Decay, NULL));
  ok(TSSetType(ts, TSRK));
  SetAdapt(ts, TSADAPTBASIC);
  ok(TSSetFunctionDomainError(ts, InDomain));
  ok(TSSetTolerances(ts, 1e-9, NULL, 1e-9, NULL));
  ok(TSSetTimeStep(ts, 3.));
  ok(TSSetMaxTime(ts, 0.25));
  ok(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_STEPOVER));
  ok(TSSetSolution(ts, w));
  ok(SlipOutputCreate(ts, "rk.h5", 1, &column, Row, NULL, &out));
  ok(TSSolve(ts, w));
  ok(TSGetStepNumber(ts, &accepted));
  ok(TSGetStepRejections(ts, &rejected));
  ok(SlipOutputFinish(&out, 0, 0));
  ok(SlipH5OpenRead("rk.h5", &h));
  time = Column(&h, "/steps/time", accepted + rejected);
  dt = Column(&h, "/steps/dt", accepted + rejected);
  accept = Column(&h, "/steps/accepted", accepted + rejected);
  converged = Column(&h, "/steps/converged", accepted + rejected);
  error = Column(&h, "/steps/error", accepted + rejected);
  for (PetscInt k = 0; k < accepted + rejected; k++) {
    assert_true(fabs(time[k] - now) < 1e-14);
    if (converged[k] == 0) {
      /* each a quarter of the one before */
      assert_true(fabs(dt[k] - 3. / pow(4, (double)failed++)) < 1e-14 && dt[k] / 2 >= LONGEST && error[k] < 0);
    } else if (accept[k] == 0) {
      assert_true(error[k] > 1);
      refused++;
    } else {
      assert_true(error[k] <= 1);
      now += dt[k];
      taken++;
    }
  }
  assert_true(failed == 2 && refused > 0);
  assert_int_equal(accepted, taken);
  assert_true(now >= 0.25);
  ok(SlipH5Close(&h));
  PetscFree(time), PetscFree(dt), PetscFree(accept), PetscFree(converged), PetscFree(error);
  ObjectsDestroy(&ts, &w);
}

static int Enter(void **state)
{
  return !getcwd(cwd, sizeof(cwd)) || TempDirMake("test_output", dir) || chdir(dir);
}

static int Leave(void **state)
{
  return chdir(cwd) || TempDirRemove(dir);
}

SLIP_TESTS_WITH(Enter, Leave, resumes, attempts)
