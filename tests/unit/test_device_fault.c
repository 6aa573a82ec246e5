/* A fault of rate and state whose steps are computed on a device of OpenCL, against the same by the processor: slip
   rates, runs, what goes between the two, bits, restarts, and what is refused. Where there is no device the test says
   so. */
#include "unit.h"
#include "tempdir.h"
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipfault.h>
#include <math.h>

/* Cells that weaken, and some that are steady */
enum { NX = 16, NZ = 8, N = NX * NZ };
static const char base[] = "-fault_nx 16 -fault_nz 8 -fault_length_x 32e3 -fault_length_z 16e3 -fault_friction_law "
                           "rate_and_state -fault_normal_stress 25e6 "
                           "-fault_normal_stress_gradient 0 -fault_loading_rate 1e-9 -fault_friction_slip 0.1 "
                           "-fault_friction_b 0.03 "
                           "-fault_progress no -ts_max_time 7e9 ";
static PetscBool present;
#define NEEDS_DEVICE                                                                                                   \
  (void)state;                                                                                                         \
  if (!present) skip()

typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
  PetscInt steps, rejected;
  SlipDeviceTraffic last;             /* at the end of the step before */
  PetscInt64 vectors, numbers, bytes; /* most of a step */
} Run;

static PetscErrorCode Watch(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Run *run = (Run *)ctx;
  const SlipDeviceTraffic now = SlipDeviceGetTraffic();
  PetscReal end;

  PetscFunctionBegin;
  (void)w;
  PetscCall(TSGetMaxTime(ts, &end));
  if (step > 2 &&
      t <
        end) { /* in the first two tolerances are put there, and the largest eigenvalue is found; the end is written */
    run->vectors = PetscMax(run->vectors, now.puts + now.fetches - run->last.puts - run->last.fetches);
    run->numbers = PetscMax(run->numbers, now.numbers - run->last.numbers);
  }
  run->bytes = PetscMax(run->bytes, now.bytes);
  run->last = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Begin(const char options[], Run *run)
{
  PetscReal a[N];

  PetscFunctionBegin;
  *run = (Run){0};
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscOptionsInsertString(NULL, base));
  PetscCall(PetscOptionsInsertString(NULL, options));
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &run->fault));
  PetscCall(SlipFaultSetFromOptions(run->fault));
  for (PetscInt i = 0; i < N; i++) a[i] = i % NX < 3 || i % NX > 12 || i / NX > 5 ? 0.04 : 0.004 + 1e-4 * (PetscReal)i;
  PetscCall(SlipFaultSetField(run->fault, "friction_a", N, a));
  PetscCall(SlipFaultSetUp(run->fault));
  PetscCall(SlipFaultCreateState(run->fault, &run->w));
  PetscCall(SlipFaultSetInitialState(run->fault, run->w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlipFaultConfigureTS(run->fault, run->ts));
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(TSMonitorSet(run->ts, Watch, run, NULL));
  PetscCall(TSSetFromOptions(run->ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Solve(const char options[], Run *run)
{
  int code;

  PetscFunctionBegin;
  PetscCall(Begin(options, run));
  PetscCall(SlipFaultOutputStart(run->fault, run->ts));
  PetscCall(SlipFaultCheckpointStart(run->fault, run->ts));
  PetscCall(TSSolve(run->ts, run->w));
  PetscCall(SlipFaultCheckpointFinish(run->fault, run->ts, &code));
  PetscCall(SlipFaultOutputFinish(run->fault, run->ts, 0, 0));
  PetscCall(TSGetStepNumber(run->ts, &run->steps));
  PetscCall(TSGetStepRejections(run->ts, &run->rejected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void End(Run *run)
{
  ObjectsDestroy(&run->w, &run->ts, &run->fault);
}

static void AssertSame(Vec x, Vec y, PetscReal allowed)
{
  const PetscReal *a, *b;
  PetscReal most = 0;

  ok(VecGetArrayRead(x, &a));
  ok(VecGetArrayRead(y, &b));
  for (PetscInt i = 0; i < 3 * N; i++) {
    const PetscReal differ = fabs(a[i] - b[i]);

    /* rates over themselves; displacements and states, which are of metres and tens, as they are */
    most = PetscMax(most, i % 3 == 0 && differ > 0 ? differ / fabs(a[i]) : differ);
  }
  if (!(most <= allowed)) fail_msg("off by %g, expected at most %g", (double)most, (double)allowed);
  ok(VecRestoreArrayRead(y, &b));
  ok(VecRestoreArrayRead(x, &a));
}

/* Of states that runs have and of others: cells whose stress friction hardly opposes, or reverses, and states of all
   decades */
static void Rates(const char options[])
{
  Vec host, f, there;
  const PetscReal *a, *b;
  PetscReal *w;
  Run run;

  ok(Begin(options, &run));
  ok(VecCreateSeq(PETSC_COMM_SELF, 3 * N, &host));
  ok(VecSetBlockSize(host, 3));
  ok(VecDuplicate(host, &f));
  ok(VecDuplicate(run.w, &there));
  for (int decade = 0; decade < 6; decade++) {
    ok(VecGetArrayWrite(host, &w));
    for (PetscInt i = 0; i < N; i++) {
      w[3 * i] = 0;
      w[3 * i + 1] = 3 * decade * sin(1 + 0.37 * (double)i) * cos(0.05 * (double)i);
      w[3 * i + 2] = decade == 5 ? 60 * cos(0.3 * (double)i) : 7 + (12 - 4 * decade) * cos(0.3 * (double)i);
    }
    ok(VecRestoreArrayWrite(host, &w));
    ok(VecCopy(host, run.w));
    ok(SlipFaultRates(run.fault, 0, host, f)); /* by the processor, as no kernel takes this vector */
    ok(SlipFaultRates(run.fault, 0, run.w, there));
    ok(VecGetArrayRead(f, &a));
    ok(VecGetArrayRead(there, &b));
    for (PetscInt i = 0; i < 3 * N; i++)
      /* rounding of stresses of 1e8 Pa over a sigma = 2.5e5 Pa, of which rates are exponentials */
      AssertNear(b[i], a[i], 2e-12 * fabs(a[i]) + 1e-20);
    ok(VecRestoreArrayRead(there, &b));
    ok(VecRestoreArrayRead(f, &a));
  }
  ObjectsDestroy(&host, &f, &there);
  End(&run);
}

static void rates(void **state)
{
  NEEDS_DEVICE;
  Rates("-fault_device opencl");
  Rates("-fault_device opencl -fault_state_law slip -fault_kernel full_space");
}

/* Sums over the cells of a run's state, its powers and its fastest relaxation, against the processor's */
static void Sums(Run *run)
{
  const SlipFaultSums *sums;
  PetscReal sum[FAULT_NUM_SUMS], speed, power[2][3], relaxation[2];
  Vec host;

  ok(VecCreateSeq(PETSC_COMM_SELF, 3 * N, &host));
  ok(VecSetBlockSize(host, 3));
  ok(VecCopy(run->w, host));
  ok(SlipFaultGetSums(run->fault, 0, run->w, &sums));
  ok(PetscArraycpy(sum, sums->sum, FAULT_NUM_SUMS));
  speed = sums->max_v;
  ok(SlipFaultGetSums(run->fault, 0, host, &sums));
  /* terms of either sign, a thousand times the sum where they cancel */
  for (int k = 0; k < FAULT_NUM_SUMS; k++) AssertNear(sum[k], sums->sum[k], 1e-11 * (fabs(sum[k]) + 1e-9));
  AssertNear(speed, sums->max_v, 0);
  ok(SlipFaultGetPowers(run->fault, 0, run->w, NULL, power[0], NULL));
  ok(SlipFaultGetPowers(run->fault, 0, host, NULL, power[1], NULL));
  for (int k = 0; k < 3; k++) AssertNear(power[0][k], power[1][k], 1e-12 * fabs(power[1][k]));
  ok(SlipFaultRelaxation(run->ts, run->w, &relaxation[0], run->fault));
  ok(SlipFaultRelaxation(run->ts, host, &relaxation[1], run->fault));
  AssertNear(relaxation[0], relaxation[1], 1e-12 * relaxation[1]);
  ok(VecDestroy(&host));
}

/* 220 years with two events by either integrator: the same steps, and by the default nothing but numbers between the
   two */
static void runs(void **state)
{
  const char *const integrators[] = {"-fault_output run.h5 -fault_output_overwrite -fault_output_slip_interval 100 ",
                                     "-ts_type rk -ts_adapt_type basic "};
  char dir[TEMPDIR_LENGTH];
  Run host, there, again;

  NEEDS_DEVICE;
  assert_int_equal(0, TempDirMake("device", dir));
  assert_int_equal(0, chdir(dir));
  for (int k = 0; k < 2; k++) {
    char options[256];

    ok(Solve(integrators[k], &host));
    ok(PetscSNPrintf(options, sizeof(options), "%s -fault_device opencl", integrators[k]));
    ok(Solve(options, &there));
    ok(Solve(options, &again));
    assert_true(host.steps > 300);
    assert_int_equal(host.steps, there.steps);
    assert_int_equal(host.rejected, there.rejected);
    AssertSame(host.w, there.w, 1e-6); /* rounding, which events enlarge */
    AssertSame(there.w, again.w, 0);
    { /* what was said of memory at set-up holds, and not by much, beside the run before */
      const PetscReal bytes = (PetscReal)(again.bytes - there.last.bytes);

      assert_true(bytes <= again.fault->device.bytes && bytes > again.fault->device.bytes / 2);
    }
    Sums(&there);
    if (k == 0) {
      assert_int_equal(there.vectors, 0);
      assert_true(there.numbers <= 64);
      print_message("%d steps, at most %d numbers in one\n", (int)there.steps, (int)there.numbers);
    }
    End(&host);
    End(&there);
    End(&again);
  }
  assert_int_equal(0, chdir(".."));
  assert_int_equal(0, TempDirRemove(dir));
}

/* What -fault_view says of the device */
static void Said(void)
{
  char text[65536];
  Run run;
  FILE *file;

  ok(Begin("-fault_device opencl -fault_view :view.txt", &run));
  End(&run);
  file = fopen("view.txt", "r");
  assert_non_null(file);
  text[fread(text, 1, sizeof(text) - 1, file)] = '\0';
  fclose(file);
  assert_non_null(strstr(text, ", of which the fault and its integrator take up to 0.104 MB\n"));
}

/* A run that goes on from a checkpoint, to the bit */
static void restarts(void **state)
{
  const char *const integrators[] = {"", "-ts_type rk -ts_adapt_type basic "};
  char dir[TEMPDIR_LENGTH], options[256];
  Run whole, first, second;

  NEEDS_DEVICE;
  assert_int_equal(0, TempDirMake("device", dir));
  assert_int_equal(0, chdir(dir));
  Said();
  for (int k = 0; k < 2; k++) {
    ok(PetscSNPrintf(options, sizeof(options), "%s -fault_device opencl -ts_max_steps 90", integrators[k]));
    ok(Solve(options, &whole));
    ok(PetscSNPrintf(options, sizeof(options), "%s -fault_device opencl -ts_max_steps 50 -fault_checkpoint state%d",
                     integrators[k], k));
    ok(Solve(options, &first));
    ok(PetscSNPrintf(options, sizeof(options), "%s -fault_device opencl -ts_max_steps 90 -fault_restart state%d",
                     integrators[k], k));
    ok(Solve(options, &second));
    assert_int_equal(second.steps, 90);
    AssertSame(whole.w, second.w, 0);
    End(&whole);
    End(&first);
    End(&second);
  }
  assert_int_equal(0, chdir(".."));
  assert_int_equal(0, TempDirRemove(dir));
}

static int setup(void **state)
{
  SlipDevice device;

  (void)state;
  present = SlipDeviceOpen(PETSC_COMM_SELF, "-test_device", "", &device) ? PETSC_FALSE : PETSC_TRUE;
  if (!present) print_message("skipped: %s\n", message);
  return 0;
}

SLIP_TESTS_WITH(setup, NULL, rates, runs, restarts)
