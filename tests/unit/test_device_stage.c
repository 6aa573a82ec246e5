/* Steps with set-valued friction on a device of OpenCL, against the same by the processor: the operators of a stage,
   runs, bits, restarts, and what goes between the two. Where there is no device the test says so. */
#include "unit.h"
#include "tempdir.h"
#include <slipstep/private/slipdevice.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipmatcommon.h>
#include <slipstep/private/slipbathe.h>
#include <math.h>

static PetscBool present;
#define NEEDS_DEVICE                                                                                                   \
  (void)state;                                                                                                         \
  if (!present) skip()

/* ---- operators of a stage ---- */

#define MASS (2500.0 * 3000.0)
#define ZETA (0.8 / 3)

enum { NX = 20, NZ = 34, N = NX * NZ }; /* by transforms in depth on either */

static PetscReal Number(PetscInt i)
{
  return sin(1 + 3.7 * (PetscReal)i);
}

/* x of the device with the same numbers as y of the processor */
static Vec There(Mat A, Vec y)
{
  Vec x;

  ok(MatCreateVecs(A, &x, NULL));
  assert_true(SlipDeviceVecIs(x));
  ok(VecCopy(y, x));
  return x;
}

static void AssertVecs(Vec host, Vec there, PetscReal relative)
{
  PetscReal size, differ;
  Vec copy;

  ok(VecDuplicate(host, &copy));
  ok(VecCopy(there, copy));
  ok(VecNorm(host, NORM_INFINITY, &size));
  ok(VecAXPY(copy, -1, host));
  ok(VecNorm(copy, NORM_INFINITY, &differ));
  if (!(differ <= relative * size)) fail_msg("off by %g of %g", (double)differ, (double)size);
  ok(VecDestroy(&copy));
}

typedef struct {
  Mat K, H, B, A, J; /* A: what Newton's method takes for B */
  PC pc;
  Vec x, y, mask, slope;
} Stage;

/* depth_top: an image where the ground is near, none where it is far, or in a full space */
static void StageCreate(PetscReal depth_top, PetscBool full, PetscBool device, PetscReal theta, Stage *s)
{
  const SlipGrid grid = {NX, NZ, 3000.0, 5000.0, depth_top, ROCK(0.25, full, SLIP_AVERAGE_CENTRE)};
  PetscReal *m, *d, *x;

  ok(MatCreateSlipStiffness(PETSC_COMM_SELF, &grid, "fft", &s->K));
  ok(MatScale(s->K, 0.46));
  if (device) ok(SlipMatUseDevice(s->K));
  ok(MatCreateSlipViscosity(s->K, MASS, ZETA, "lanczos", &s->H));
  ok(MatCreateSlipStage(s->K, s->H, MASS, &s->B));
  ok(MatSlipStageSetTheta(s->B, theta));
  ok(MatCreateVecs(s->K, &s->x, &s->y));
  ok(MatCreateVecs(s->K, &s->mask, &s->slope));
  assert_true(SlipDeviceVecIs(s->slope) == device);
  ok(VecGetArrayWrite(s->x, &x));
  ok(VecGetArrayWrite(s->mask, &m));
  ok(VecGetArrayWrite(s->slope, &d));
  for (PetscInt i = 0; i < N; i++) {
    x[i] = Number(i);
    m[i] = Number(7 * i) > -0.3;
    d[i] = -m[i] * 0.2 * MASS / theta * (1 + 0.5 * Number(3 * i));
  }
  ok(VecRestoreArrayWrite(s->slope, &d));
  ok(VecRestoreArrayWrite(s->mask, &m));
  ok(VecRestoreArrayWrite(s->x, &x));
  ok(MatSlipStageGetApproximation(s->B, &s->A));
  assert_true(s->A != s->B);
  ok(MatCreateSlipJacobian(s->B, &s->J));
  ok(MatSlipJacobianSetParts(s->J, s->A, s->mask, s->slope));
  ok(PCCreate(PETSC_COMM_SELF, &s->pc));
  ok(PCSetType(s->pc, PCSLIPSTAGE));
  ok(PCSetOperators(s->pc, s->J, s->J));
}

static void StageDestroy(Stage *s)
{
  ObjectsDestroy(&s->pc, &s->J, &s->B, &s->H, &s->K);
  ObjectsDestroy(&s->x, &s->y, &s->mask, &s->slope);
}

static void operators(void **state)
{
  const PetscReal top[] = {0, 70, 1e5, 0}, theta[] = {1e-3, 0.3, 1e7};

  NEEDS_DEVICE;
  for (int k = 0; k < 4; k++)
    for (int t = 0; t < 3; t++) {
      SlipDeviceTraffic before;
      Stage host, there;

      StageCreate(top[k], k == 3 ? PETSC_TRUE : PETSC_FALSE, PETSC_FALSE, theta[t], &host);
      StageCreate(top[k], k == 3 ? PETSC_TRUE : PETSC_FALSE, PETSC_TRUE, theta[t], &there);
      for (int again = 0; again < 2; again++) { /* sums of symbols are made once for each theta */
        ok(MatMult(host.A, host.x, host.y));
        ok(MatMult(there.A, there.x, there.y));
        AssertVecs(host.y, there.y, 1e-12);
        ok(MatMult(host.J, host.x, host.y));
        ok(MatMult(there.J, there.x, there.y));
        AssertVecs(host.y, there.y, 1e-12);
        ok(PCApply(host.pc, host.x, host.y));
        ok(PCApply(there.pc, there.x, there.y));
        AssertVecs(host.y, there.y, 1e-12);
        ok(MatSlipStageSetTheta(host.B, 2 * theta[t]));
        ok(MatSlipStageSetTheta(there.B, 2 * theta[t]));
        ok(MatSlipStageGetApproximation(host.B, &host.A));
        ok(MatSlipStageGetApproximation(there.B, &there.A));
        ok(MatSlipJacobianSetParts(host.J, host.A, host.mask, host.slope));
        ok(MatSlipJacobianSetParts(there.J, there.A, there.mask, there.slope));
      }
      before = SlipDeviceGetTraffic();
      ok(MatMult(there.J, there.x, there.y));
      ok(PCApply(there.pc, there.x, there.y));
      assert_int_equal(before.puts, SlipDeviceGetTraffic().puts);
      assert_int_equal(before.fetches, SlipDeviceGetTraffic().fetches);
      /* H by Lanczos' method, to its tolerance */
      ok(MatMult(host.B, host.x, host.y));
      ok(MatMult(there.B, there.x, there.y));
      AssertVecs(host.y, there.y, 1e-10);
      StageDestroy(&there);
      StageDestroy(&host);
    }
}

/* Those of vectors of the processor are still made there, by the matrices of a device. */
static void mirrors(void **state)
{
  Stage host, there;
  Vec x;

  NEEDS_DEVICE;
  StageCreate(0, PETSC_FALSE, PETSC_FALSE, 0.3, &host);
  StageCreate(0, PETSC_FALSE, PETSC_TRUE, 0.3, &there);
  ok(MatMult(host.A, host.x, host.y));
  x = There(there.K, host.y);
  ok(MatMult(there.A, host.x, host.y));
  AssertVecs(host.y, x, 1e-15);
  ok(VecDestroy(&x));
  StageDestroy(&there);
  StageDestroy(&host);
}

/* ---- runs ---- */

static const char base[] =
  "-fault_nx 20 -fault_nz 34 -fault_length_z 5000 -mat_slipsqrtm_setup lanczos -fault_progress no ";

typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
  PetscInt steps, rejected, solves, newton, linear;
  SlipDeviceTraffic last;      /* at the end of the step before */
  PetscInt64 vectors, numbers; /* most of a step */
} Run;

static PetscErrorCode Watch(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Run *run = (Run *)ctx;
  const SlipDeviceTraffic now = SlipDeviceGetTraffic();
  PetscReal end;

  PetscCall(TSGetMaxTime(ts, &end));
  if (step > 2 && t < end) {
    run->vectors = PetscMax(run->vectors, now.puts + now.fetches - run->last.puts - run->last.fetches);
    run->numbers = PetscMax(run->numbers, now.numbers - run->last.numbers);
  }
  run->last = now;
  return PETSC_SUCCESS;
}

static PetscErrorCode Solve(const char options[], const char more[], Run *run)
{
  int code;
  TS_Bathe *ba;
  PetscBool bathe;

  *run = (Run){0};
  PetscCall(SetOptions(base));
  PetscCall(PetscOptionsInsertString(NULL, options));
  PetscCall(PetscOptionsInsertString(NULL, more));
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &run->fault));
  PetscCall(SlipFaultSetFromOptions(run->fault));
  PetscCall(SlipFaultSetUp(run->fault));
  PetscCall(SlipFaultCreateState(run->fault, &run->w));
  PetscCall(SlipFaultSetInitialState(run->fault, run->w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlipFaultConfigureTS(run->fault, run->ts));
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(TSMonitorSet(run->ts, Watch, run, NULL));
  PetscCall(TSSetFromOptions(run->ts));
  PetscCall(SlipFaultOutputStart(run->fault, run->ts));
  PetscCall(SlipFaultCheckpointStart(run->fault, run->ts));
  PetscCall(TSSolve(run->ts, run->w));
  PetscCall(SlipFaultCheckpointFinish(run->fault, run->ts, &code));
  PetscCall(SlipFaultOutputFinish(run->fault, run->ts, 0, 0));
  PetscCall(TSGetStepNumber(run->ts, &run->steps));
  PetscCall(TSGetStepRejections(run->ts, &run->rejected));
  PetscCall(TSBatheIs(run->ts, &bathe));
  ba = (TS_Bathe *)run->ts->data;
  if (bathe) {
    run->solves = ba->totals.solves;
    run->newton = ba->totals.newton;
    run->linear = ba->totals.linear;
  }
  return PETSC_SUCCESS;
}

static void End(Run *run)
{
  ObjectsDestroy(&run->w, &run->ts, &run->fault);
}

/* Entries over the largest of their kind: rates, displacements, states. Cells that stick are the same ones. */
static void AssertSame(Vec x, Vec y, PetscReal allowed)
{
  const PetscReal *a, *b;
  PetscReal most[3] = {0, 0, 0}, size[3] = {0, 0, 0};

  ok(VecGetArrayRead(x, &a));
  ok(VecGetArrayRead(y, &b));
  for (PetscInt i = 0; i < 3 * N; i++) {
    if (i % 3 == 0) assert_true((a[i] == 0) == (b[i] == 0));
    most[i % 3] = PetscMax(most[i % 3], fabs(a[i] - b[i]));
    size[i % 3] = PetscMax(size[i % 3], fabs(a[i]));
  }
  for (int k = 0; k < 3; k++)
    if (!(most[k] <= allowed * size[k]))
      fail_msg("number %d off by %g of %g, expected at most %g", k, (double)most[k], (double)size[k], (double)allowed);
  ok(VecRestoreArrayRead(y, &b));
  ok(VecRestoreArrayRead(x, &a));
}

/* The critical start exceeds the strength by 1e-5, of which rounding of K^-1 and of K u, 1e-14, is 1e-9; what differs
   grows with the event, and explicit steps take damping to 2e-4 only, whose choices rounding turns. */
/* Errors of steps from a given traction are those of the processor.
   Where all cells rest it finds until when, of a state and its force. */
enum { AT_REST = 3, OF_TRACTION = 12, THROUGH_PROCESSOR = 1000 };
static const struct {
  const char *options;
  PetscReal allowed;
  PetscBool steps;    /* the same ones */
  PetscInt64 vectors; /* at most in a step */
} cases[] = {
  {"-ts_bathe_method implicit -ts_max_time 12 ", 1e-6, PETSC_TRUE, AT_REST},
  {"-ts_bathe_method implicit -ts_adapt_type none -ts_dt 0.2 -ts_max_time 4 -fault_viscosity radiation ", 1e-6,
   PETSC_TRUE, 0},
  {"-ts_bathe_method implicit -ts_max_time 12 -fault_kernel full_space -fault_friction_law linear_slip_weakening ",
   1e-6, PETSC_TRUE, AT_REST},
  {"-fault_normal_stress 2e7 -fault_normal_stress_gradient 0 -fault_initial traction -fault_initial_traction 1.21e7 "
   "-fault_initial_unstable yes -fault_stressing_rate 0 -ts_type bathe -ts_max_time 3 ",
   1e-6, PETSC_TRUE, OF_TRACTION},
  {"-fault_friction_law rate_weakening -fault_friction_rate 1 -ts_bathe_method implicit -ts_max_time 8 ", 1e-6,
   PETSC_TRUE, 0},
  {"-ts_bathe_method explicit -ts_adapt_type none -ts_dt 0.05 -ts_max_time 8 -fault_viscosity radiation ", 1e-6,
   PETSC_TRUE, 0},
  {"-ts_max_time 12 ", 1e-3, PETSC_FALSE, AT_REST},
  {"-ts_type moreau -ts_adapt_type none -ts_dt 0.05 -ts_max_time 4 -fault_viscosity none ", 1e-6, PETSC_TRUE, 0},
  {"-fault_healing_time 1000 -ts_bathe_method implicit -ts_max_time 8 ", 1e-6, PETSC_TRUE, THROUGH_PROCESSOR},
  {"-ts_type rkc -fault_inertia no -fault_viscosity radiation -ts_max_time 6 ", 1e-6, PETSC_TRUE, THROUGH_PROCESSOR},
  {"-ts_type bathe -fault_friction_law rate_and_state -fault_initial_rate 0.1 -fault_friction_slip 0.02 -ts_max_time "
   "400 ",
   1e-6, PETSC_TRUE, THROUGH_PROCESSOR},
};

static void runs(void **state)
{
  NEEDS_DEVICE;
  for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++) {
    Run host, there, again;

    ok(Solve(cases[k].options, "", &host));
    ok(Solve(cases[k].options, "-fault_device opencl", &there));
    ok(Solve(cases[k].options, "-fault_device opencl", &again));
    print_message("%s: %d steps, %d Newton and %d linear iterations; at most %d vectors and %d numbers in a step\n",
                  cases[k].options, (int)there.steps, (int)there.newton, (int)there.linear, (int)there.vectors,
                  (int)there.numbers);
    assert_true(host.steps > 5);
    if (cases[k].steps) {
      assert_int_equal(host.steps, there.steps);
      assert_int_equal(host.rejected, there.rejected);
      assert_int_equal(host.solves, there.solves);
      assert_int_equal(host.newton, there.newton);
    }
    AssertSame(host.w, there.w, cases[k].allowed);
    assert_true(there.vectors <= cases[k].vectors);
    if (cases[k].vectors == 0) /* beside those that solvers ask for: a norm or a product of two vectors each */
      assert_true(there.numbers <= 64 + 40 * (there.newton + there.linear) + 400);
    AssertSame(there.w, again.w, 0);
    End(&host);
    End(&there);
    End(&again);
  }
}

/* A run that goes on from a checkpoint, to the bit */
static void restarts(void **state)
{
  const char *const methods[] = {"-ts_bathe_method implicit ", ""};
  char dir[TEMPDIR_LENGTH], options[256];
  Run whole, first, second;

  NEEDS_DEVICE;
  assert_int_equal(0, TempDirMake("device", dir));
  assert_int_equal(0, chdir(dir));
  for (int k = 0; k < 2; k++) {
    ok(Solve(methods[k], "-fault_device opencl -ts_max_steps 30", &whole));
    ok(PetscSNPrintf(options, sizeof(options), "-fault_device opencl -ts_max_steps 17 -fault_checkpoint state%d", k));
    ok(Solve(methods[k], options, &first));
    ok(PetscSNPrintf(options, sizeof(options), "-fault_device opencl -ts_max_steps 30 -fault_restart state%d", k));
    ok(Solve(methods[k], options, &second));
    assert_int_equal(second.steps, 30);
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

  present = SlipDeviceOpen(PETSC_COMM_SELF, "-test_device", "", &device) ? PETSC_FALSE : PETSC_TRUE;
  if (!present) print_message("skipped: %s\n", message);
  if (present) ok(SlipDeviceRegisterVec());
  return 0;
}

SLIP_TESTS_WITH(setup, NULL, operators, mirrors, runs, restarts)
