/* An observer of a user's own, by public functions alone: it is told of the start, of every accepted step and of the
   end, its table is in the output, and a run that goes on from a checkpoint has the same rows as the unbroken one. */
#include "unit.h"
#include <math.h>
#include "faultstart.h"
#include "tempdir.h"
#include <slipstep/rooms/sliph5.h>

#define STEP 0.05 /* [s] */

/* The running maximum of the slip rates' sum of squares, which only memory can tell */
typedef struct {
  PetscInt created, starts, steps, finished, destroyed, loaded;
  PetscInt last;     /* number of the last step */
  PetscReal largest; /* of sums so far [m^2/s^2] */
  Vec before;        /* state of the step before */
  PetscReal way;     /* sum of its changes, of the norm [mixed units] */
  SlipOutput output;
  PetscInt table;
} Mine;

static PetscErrorCode Create(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  Mine *m = (Mine *)*ctx;

  assert_int_equal(*wanted, PETSC_TRUE);
  m->created++;
  return SlipFaultCreateState(fault, &m->before);
}

static PetscErrorCode LayOut(SlipFault fault, SlipOutput output, void *ctx)
{
  static const SlipOutputColumn columns[] = {{"time", "s", PETSC_FALSE}, {"largest_and_way", "1", PETSC_FALSE}};
  const PetscInt entries[] = {0, 2};
  Mine *m = (Mine *)ctx;

  m->output = output;
  PetscCall(SlipOutputAddTable(output, "/mine", 2, columns, entries, &m->table));
  return SlipOutputAddAttribute(output, "/mine", "answer", 42);
}

static PetscErrorCode Start(SlipFault fault, TS ts, PetscReal time, Vec w, void *ctx)
{
  Mine *m = (Mine *)ctx;
  PetscReal now;

  PetscCall(TSGetTime(ts, &now));
  assert_true(now == time);
  if (!m->loaded) PetscCall(VecCopy(w, m->before));
  m->starts++;
  return PETSC_SUCCESS;
}

static PetscErrorCode Step(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  Mine *m = (Mine *)ctx;
  PetscReal row[3] = {time}, norm;

  assert_int_equal(step, m->last + 1);
  m->last = step;
  m->steps++;
  PetscCall(VecStrideNorm(w, 0, NORM_2, &norm));
  m->largest = PetscMax(m->largest, norm * norm);
  PetscCall(VecAXPY(m->before, -1, w));
  PetscCall(VecNorm(m->before, NORM_2, &norm));
  m->way += norm;
  PetscCall(VecCopy(w, m->before));
  row[1] = m->largest;
  row[2] = m->way;
  return SlipOutputAddRows(m->output, m->table, 1, row);
}

static PetscErrorCode Visit(SlipFault fault, SlipState state, void *ctx)
{
  Mine *m = (Mine *)ctx;

  PetscCall(SlipStateInt(state, "last", 1, &m->last));
  PetscCall(SlipStateReal(state, "largest", 1, &m->largest));
  PetscCall(SlipStateReal(state, "way", 1, &m->way));
  PetscCall(SlipStateVec(state, "before", m->before));
  if (SlipStateIsLoading(state)) m->loaded++;
  return PETSC_SUCCESS;
}

static PetscErrorCode Finish(SlipFault fault, TS ts, SlipOutput output, void *ctx)
{
  Mine *m = (Mine *)ctx;

  assert_ptr_equal(output, m->output);
  PetscCall(SlipOutputAddResult(output, "way", NULL, NULL, m->way));
  m->finished++;
  return PETSC_SUCCESS;
}

static PetscErrorCode Destroy(void **ctx)
{
  Mine *m = (Mine *)*ctx;

  PetscCall(VecDestroy(&m->before));
  m->destroyed++;
  return PETSC_SUCCESS;
}

static Mine mine;

/* An observer that wants nothing of any run, and one that has a name alone */
static PetscInt idle_steps = 0;

static PetscErrorCode Refuse(SlipFault fault, TS ts, PetscBool *wanted, void **ctx)
{
  *wanted = PETSC_FALSE;
  return PETSC_SUCCESS;
}

static PetscErrorCode CountIdle(SlipFault fault, TS ts, PetscInt step, PetscReal time, Vec w, void *ctx)
{
  idle_steps++;
  return PETSC_SUCCESS;
}

static void registered(void **state)
{
  const SlipFaultObserver row = {"mine", Create, LayOut, Start, Step, Visit, Finish, Destroy, &mine, PETSC_FALSE};
  const SlipFaultObserver idle = {.name = "idle", .create = Refuse, .step = CountIdle}, named = {.name = "name"};

  ok(SlipFaultRegisterObserver(&row));
  ok(SlipFaultRegisterObserver(&idle));
  ok(SlipFaultRegisterObserver(&named));
  fails(SlipFaultRegisterObserver(&row), "There is an observer mine already");
  fails(SlipFaultRegisterObserver(&(SlipFaultObserver){.name = "stations"}), "There is an observer stations already");
  fails(SlipFaultRegisterObserver(&(SlipFaultObserver){.create = Create}), "needs a name");
}

enum { ROWS = 20, PART = 8 };

/* A run of 9 cells for so many steps, of ROWS, which writes a checkpoint or goes on from it */
static void Run(const char output[], const char checkpoint[], const char restart[], PetscInt steps)
{
  SlipFault fault;
  int stopped;
  TS ts;
  Vec w;

  mine = (Mine){0};
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(SlipFaultSetString(fault, "output", output));
  ok(FaultSetReals(fault, {"nx", 3}, {"nz", 3}));
  if (checkpoint) ok(SlipFaultSetString(fault, "checkpoint", checkpoint));
  if (restart) ok(SlipFaultSetString(fault, "restart", restart));
  ok(FaultStart(fault, TSADAPTNONE, STEP, ROWS * STEP, &w, &ts));
  ok(TSSetMaxSteps(ts, steps));
  ok(TSSetSolution(ts, w));
  ok(SlipFaultOutputStart(fault, ts));
  ok(SlipFaultCheckpointStart(fault, ts));
  assert_int_equal(mine.created, 1);
  ok(TSSolve(ts, w));
  ok(SlipFaultCheckpointFinish(fault, ts, &stopped));
  assert_int_equal(mine.finished, 0);
  ok(SlipFaultOutputFinish(fault, ts, 0, 0));
  assert_int_equal(mine.finished, 1);
  assert_int_equal(mine.destroyed, 1);
  assert_int_equal(mine.starts, 1);
  assert_int_equal(idle_steps, 0);
  ObjectsDestroy(&w, &ts, &fault);
  assert_int_equal(mine.destroyed, 1);
}

static void Read(const char file[], PetscInt rows, PetscReal **x, PetscReal **series)
{
  PetscInt dims[2], n;
  PetscReal answer, way;
  SlipH5 h;

  ok(SlipH5OpenRead(file, &h));
  ok(SlipH5ReadReal(&h, "/mine/largest_and_way", 2, dims, x));
  ok(SlipH5ReadReal(&h, "/series/time", 1, &n, series));
  assert_int_equal(dims[0], rows);
  assert_int_equal(dims[1], 2);
  assert_true((*series)[0] == 0 && isnan((*x)[0]) && isnan((*x)[1])); /* it adds no row for the start */
  assert_int_equal(n, rows);
  ok(SlipH5ReadAttrReal(&h, "/mine", "answer", &answer));
  ok(SlipH5ReadAttrReal(&h, "/result", "way", &way));
  assert_true(answer == 42 && way == (*x)[2 * rows - 1]);
  ok(SlipH5Close(&h));
}

/* The way and the maximum of the second part come from the checkpoint. */
static void goes_on(void **state)
{
  PetscReal *whole, *parts, *time;
  char dir[TEMPDIR_LENGTH], file[3][2 * TEMPDIR_LENGTH];

  assert_int_equal(TempDirMake("observer", dir), 0);
  for (int k = 0; k < 3; k++) snprintf(file[k], sizeof(file[k]), "%s/%d", dir, k);
  Run(file[0], NULL, NULL, ROWS);
  assert_int_equal(mine.steps, ROWS);
  assert_int_equal(mine.loaded, 0);
  Run(file[1], file[2], NULL, PART);
  assert_int_equal(mine.steps, PART);
  Run(file[1], NULL, file[2], ROWS);
  assert_int_equal(mine.steps, ROWS - PART);
  assert_int_equal(mine.loaded, 1);
  Read(file[0], 1 + ROWS, &whole, &time);
  ok(PetscFree(time));
  Read(file[1], 1 + ROWS, &parts, &time);
  assert_memory_equal(whole, parts, 2 * (1 + ROWS) * sizeof(*whole));
  assert_true(whole[2 * ROWS + 1] > 0);
  ok(PetscFree(time));
  ok(PetscFree(whole));
  ok(PetscFree(parts));
  assert_int_equal(TempDirRemove(dir), 0);
}

/* A run that is refused when it starts leaves nothing behind: the same fault starts with what was wrong put right. */
static void refused_start(void **state)
{
  SlipFault fault;
  TS ts;
  Vec w;

  mine = (Mine){0};
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetReals(fault, {"nx", 3}, {"nz", 3}));
  ok(FaultStart(fault, TSADAPTNONE, STEP, ROWS * STEP, &w, &ts));
  ok(SlipFaultSetString(fault, "catalogue", "no_such_folder/events.h5"));
  fails(SlipFaultOutputStart(fault, ts), "no_such_folder");
  assert_int_equal(mine.created, mine.destroyed);
  ok(SlipFaultSetString(fault, "catalogue", ""));
  ok(SlipFaultOutputStart(fault, ts));
  assert_int_equal(mine.created, mine.destroyed + 1);
  ok(VecDestroy(&w));
  ok(TSDestroy(&ts)); /* it has a reference to the fault */
  ok(SlipFaultDestroy(&fault));
  assert_int_equal(mine.created, mine.destroyed);
}

SLIP_TESTS(registered, goes_on, refused_start)
