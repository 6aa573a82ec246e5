/* Vectors on a device of OpenCL against those of the processor. Where there is no device, or the library is built
   without OpenCL, the test says so and ends. */
#define _POSIX_C_SOURCE 200809L /* sigaction(), pthread_sigmask() */
#include "unit.h"
#include <slipstep/rooms/slipcells.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipts.h>
#include <slipstep/private/slipdevice.h>
#include <math.h>
#include <signal.h>

enum { N = 1500, BLOCK = 3, MANY = 6 };
static SlipDevice device;
static struct sigaction before[32]; /* before the device was opened */
#define NEEDS_DEVICE                                                                                                   \
  if (!device) skip()

static PetscReal Entry(PetscInt which, PetscInt i)
{
  return sin(1.3 + 0.7 * (double)which + 0.013 * (double)((which + 2) * i));
}

/* Vectors with the same numbers on the processor and on the device */
static void Fill(PetscInt which, Vec x)
{
  PetscReal *a;
  PetscInt n;

  ok(VecGetLocalSize(x, &n));
  ok(VecGetArrayWrite(x, &a));
  for (PetscInt i = 0; i < n; i++) a[i] = Entry(which, i);
  ok(VecRestoreArrayWrite(x, &a));
}

static void Create(VecType type, PetscInt n, PetscInt block, Vec *x)
{
  ok(VecCreate(PETSC_COMM_SELF, x));
  ok(VecSetSizes(*x, n, n));
  ok(VecSetBlockSize(*x, block));
  ok(VecSetType(*x, type));
}

/* Largest difference, relative to the largest entry of x */
static PetscReal Difference(Vec x, Vec y)
{
  const PetscReal *a, *b;
  PetscReal most = 0, differ = 0;
  PetscInt n;

  ok(VecGetLocalSize(x, &n));
  ok(VecGetArrayRead(x, &a));
  ok(VecGetArrayRead(y, &b));
  for (PetscInt i = 0; i < n; i++) {
    most = PetscMax(most, fabs(a[i]));
    differ = PetscMax(differ, fabs(a[i] - b[i]));
  }
  ok(VecRestoreArrayRead(y, &b));
  ok(VecRestoreArrayRead(x, &a));
  return differ / most;
}

/* Everything that steps do with vectors, in x[0], of either type */
static void Operate(Vec x[MANY], PetscInt k)
{
  const PetscScalar factor[] = {0.3, -0.7, 1.1, 2.5, -0.2};

  switch (k) {
  case 0:
    ok(VecSet(x[0], 0.25));
    break;
  case 1:
    ok(VecCopy(x[1], x[0]));
    break;
  case 2:
    ok(VecScale(x[0], -1.5));
    break;
  case 3:
    ok(VecAXPY(x[0], 0.3, x[1]));
    break;
  case 4:
    ok(VecAYPX(x[0], 0.3, x[1]));
    break;
  case 5:
    ok(VecAXPBY(x[0], 0.3, -2, x[1]));
    break;
  case 6:
    ok(VecAXPBYPCZ(x[0], 0.3, -2, 0.5, x[1], x[2]));
    break;
  case 7:
    ok(VecWAXPY(x[0], 0.3, x[1], x[2]));
    break;
  case 8:
    ok(VecMAXPY(x[0], 5, factor, x + 1));
    break;
  case 9:
    ok(VecPointwiseMult(x[0], x[1], x[2]));
    break;
  case 10:
    ok(VecPointwiseDivide(x[0], x[1], x[2]));
    break;
  case 11:
    ok(VecAbs(x[0]));
    break; /* of VECSEQ, on the mirror */
  case 12:
    ok(VecReciprocal(x[0]));
    break; /* likewise */
  case 13:
    ok(VecAXPBYPCZ(x[0], 0.3, -2, 0, x[1], x[2]));
    break;
  default:
    ok(VecShift(x[0], 3));
    break;
  }
}

static void vectors(void **state)
{
  Vec host[MANY], there[MANY];

  NEEDS_DEVICE;
  for (PetscInt k = 0; k < MANY; k++) {
    Create(VECSEQ, N, BLOCK, &host[k]);
    if (k == 0)
      Create(VECSLIPOPENCL, N, BLOCK, &there[0]);
    else
      ok(VecDuplicate(there[0], &there[k]));
    Fill(k, host[k]);
    Fill(k, there[k]);
  }
  for (PetscInt k = 0; k < 15; k++) {
    Operate(host, k);
    Operate(there, k);
    /* sums of five products, of numbers up to some hundred times the result where one is divided by a small one */
    if (!(Difference(host[0], there[0]) < 1e-14)) print_error("operation %d\n", (int)k);
    assert_true(Difference(host[0], there[0]) < 1e-14);
    Fill(0, host[0]);
    Fill(0, there[0]);
  }
  for (PetscInt k = 0; k < MANY; k++) ObjectsDestroy(&host[k], &there[k]);
}

static void numbers(void **state)
{
  const NormType types[] = {NORM_1, NORM_2, NORM_INFINITY};
  PetscReal a, b, again;
  Vec x, y, u, v;

  NEEDS_DEVICE;
  Create(VECSEQ, N, BLOCK, &x);
  Create(VECSLIPOPENCL, N, BLOCK, &u);
  ok(VecDuplicate(x, &y));
  ok(VecDuplicate(u, &v));
  Fill(1, x);
  Fill(1, u);
  Fill(2, y);
  Fill(2, v);
  for (int k = 0; k < 3; k++) {
    ok(VecNorm(x, types[k], &a));
    ok(VecNorm(u, types[k], &b));
    assert_true(fabs(a - b) <= 1e-13 * a); /* sums of N numbers, by other trees */
  }
  ok(VecDot(x, y, &a));
  ok(VecDot(u, v, &b));
  ok(VecDot(u, v, &again));
  assert_true(fabs(a - b) <= 1e-13 * N);
  assert_true(b == again); /* to the bit */
  ok(VecSum(x, &a));
  ok(VecSum(u, &b));
  assert_true(fabs(a - b) <= 1e-13 * N);
  { /* what is no number is seen */
    PetscReal *p;

    ok(VecGetArray(u, &p));
    p[N / 2] = NAN;
    ok(VecRestoreArray(u, &p));
    ok(VecNorm(u, NORM_INFINITY, &b));
    assert_false(isfinite(b));
    ok(VecSum(u, &b));
    assert_false(isfinite(b));
  }
  ObjectsDestroy(&x, &y, &u, &v);
}

/* Only what is asked for goes between the two, each way once */
static void traffic(void **state)
{
  SlipDeviceTraffic before, after;
  const PetscReal *a;
  PetscReal norm;
  Vec x, y;

  NEEDS_DEVICE;
  Create(VECSLIPOPENCL, N, BLOCK, &x);
  ok(VecDuplicate(x, &y));
  Fill(1, x);
  before = SlipDeviceGetTraffic();
  ok(VecCopy(x, y));    /* x is put there */
  ok(VecAXPY(y, 2, x)); /* it is there */
  ok(VecScale(y, 0.5));
  ok(VecNorm(y, NORM_2, &norm));
  after = SlipDeviceGetTraffic();
  assert_int_equal(after.puts - before.puts, 1);
  assert_int_equal(after.fetches - before.fetches, 0);
  assert_true(after.numbers - before.numbers <= 4);
  for (int k = 0; k < 2; k++) {
    ok(VecGetArrayRead(y, &a)); /* fetched once */
    assert_true(fabs(a[1] - 1.5 * Entry(1, 1)) < 1e-15);
    ok(VecRestoreArrayRead(y, &a));
  }
  ok(VecScale(y, 2)); /* and still there */
  after = SlipDeviceGetTraffic();
  assert_int_equal(after.puts - before.puts, 1);
  assert_int_equal(after.fetches - before.fetches, 1);
  fails(VecPlaceArray(y, &norm), "placed");
  ObjectsDestroy(&x, &y);
}

static void strides(void **state)
{
  Vec w, u, v, host, part;

  NEEDS_DEVICE;
  Create(VECSLIPOPENCL, N, BLOCK, &w);
  Create(VECSEQ, N, BLOCK, &host);
  Create(VECSLIPOPENCL, N / BLOCK, 1, &u);
  Create(VECSLIPOPENCL, N / BLOCK, 1, &v);
  Create(VECSEQ, N / BLOCK, 1, &part);
  Fill(3, w);
  Fill(3, host);
  Fill(4, v);
  ok(VecStrideGather(w, 1, u, INSERT_VALUES));
  ok(VecStrideGather(host, 1, part, INSERT_VALUES));
  assert_true(Difference(part, u) == 0);
  Fill(4, part);
  ok(VecStrideScatter(v, 2, w, INSERT_VALUES));
  ok(VecStrideScatter(part, 2, host, INSERT_VALUES));
  assert_true(Difference(host, w) == 0);
  ObjectsDestroy(&w, &u, &v, &host, &part);
}

/* u' = -u^2 of entries from 1/2 to 2, whose solution is u / (1 + t u) */
static PetscErrorCode Decay(TS ts, PetscReal t, Vec u, Vec f, void *ctx)
{
  PetscCall(VecPointwiseMult(f, u, u));
  return VecScale(f, -1);
}

/* By Adams' steps with tolerances that are vectors, of which one entry has none; the number of steps */
static PetscInt Integrate(VecType type, PetscInt n, Vec *u)
{
  PetscReal *a;
  PetscInt steps;
  Vec tolerance;
  TS ts;

  Create(type, n, 1, u);
  ok(VecGetArrayWrite(*u, &a));
  for (PetscInt i = 0; i < n; i++) a[i] = 1.25 + 0.75 * sin(1 + 3 * (double)i);
  ok(VecRestoreArrayWrite(*u, &a));
  ok(VecDuplicate(*u, &tolerance));
  ok(VecSet(tolerance, 1e-8));
  if (n > 1) ok(VecGetArray(tolerance, &a));
  if (n > 1) a[n / 2] = 0;
  if (n > 1) ok(VecRestoreArray(tolerance, &a));
  ts = MakeTS(TSADAMS, 1e-4, 1);
  SetAdapt(ts, TSADAPTBASIC);
  ok(TSSetRHSFunction(ts, NULL, Decay, NULL));
  ok(TSSetSolution(ts, *u));
  ok(TSSetTolerances(ts, 0, tolerance, 0, tolerance));
  ok(TSSolve(ts, *u));
  ok(TSGetStepNumber(ts, &steps));
  ObjectsDestroy(&ts, &tolerance);
  return steps;
}

/* Numbers of entries that no width of vector code divides */
static void adams(void **state)
{
  NEEDS_DEVICE;
  for (PetscInt n = 1; n < 10; n++) {
    Vec host, there;
    const PetscReal *a;
    const PetscInt steps = Integrate(VECSEQ, n, &host);

    assert_int_equal(steps, Integrate(VECSLIPOPENCL, n, &there));
    assert_true(Difference(host, there) < 1e-13); /* rounding of some hundred steps that forget */
    ok(VecGetArrayRead(there, &a));
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal first = 1.25 + 0.75 * sin(1 + 3 * (double)i);

      AssertNear(a[i], first / (1 + first), 1e-5);
    }
    ok(VecRestoreArrayRead(there, &a));
    ObjectsDestroy(&host, &there);
  }
}

static void memory(void **state)
{
  SlipDeviceMemory m = NULL;

  NEEDS_DEVICE;
  fails(SlipDeviceReserve(device, (size_t)1 << 52, "the vectors of a test"), "the vectors of a test need 4.504e+09 MB");
  fails(SlipDeviceAllocate(device, (size_t)1 << 52, "a test", &m), "expected fewer cells, or another device");
  assert_null(m);
}

static void another(void **state)
{
  SlipDevice same;

  NEEDS_DEVICE;
  ok(SlipDeviceOpen(PETSC_COMM_SELF, "-test_device", "", &same));
  assert_ptr_equal(same, device);
  fails(SlipDeviceOpen(PETSC_COMM_SELF, "-test_device 7", "7", &same),
        "-test_device 7: a process computes on one device");
}

/* Vectors that are lent where there is one memory for both, without traffic. tests/fakeopencl.c makes a card of any
   device, so that kernels for cards are tested as well. */
static void lent(void **state)
{
  SlipDeviceTraffic before, after;
  const PetscReal *a;
  Vec x, y, there[2], here[2];

  NEEDS_DEVICE;
  if (getenv("FAKEOPENCL")) assert_false(SlipDeviceShares(device));
  if (!SlipDeviceShares(device)) skip();
  Create(VECSLIPOPENCL, N, BLOCK, &x);
  ok(VecDuplicate(x, &y));
  Fill(1, x);
  ok(VecScale(x, 2)); /* there */
  before = SlipDeviceGetTraffic();
  there[0] = x;
  there[1] = y;
  ok(SlipDeviceVecsLend(2, 1, there, here));
  ok(VecWAXPY(here[1], 1, here[0], here[0]));
  ok(SlipDeviceVecsReturn(2, there, here));
  after = SlipDeviceGetTraffic();
  assert_int_equal(after.puts + after.fetches, before.puts + before.fetches);
  ok(VecScale(y, 0.5));
  ok(VecGetArrayRead(y, &a));
  for (PetscInt i = 0; i < N; i++) assert_true(a[i] == 2 * Entry(1, i));
  ok(VecRestoreArrayRead(y, &a));
  ObjectsDestroy(&x, &y);
}

/* Drivers bring compilers that take signals over */
static void Handlers(struct sigaction handler[])
{
  for (int k = 1; k < 32; k++) (void)sigaction(k, NULL, &handler[k]);
}

static void signals(void **state)
{
  const int tests[] = {SIGSEGV, SIGILL, SIGFPE, SIGBUS, SIGABRT}; /* that cmocka takes over itself */
  struct sigaction now[32];
  sigset_t blocked;

  NEEDS_DEVICE;
  Handlers(now);
  (void)pthread_sigmask(SIG_SETMASK, NULL, &blocked);
  for (int k = 1; k < 32; k++) {
    PetscBool other = PETSC_FALSE;

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(tests); i++) other |= tests[i] == k;
    if (!other && now[k].sa_handler != before[k].sa_handler) fail_msg("signal %d has another handler", k);
    assert_int_equal(0, sigismember(&blocked, k));
  }
}

static int setup(void **state)
{
  ok(SlipDeviceRegisterVec());
  Handlers(before);
  if (SlipDeviceOpen(PETSC_COMM_SELF, "-test_device_name nothing", "nothing", &device) && SlipDeviceBuiltIn() &&
      !strstr(message, "there is no device") &&
      !strstr(message, "-test_device_name nothing: there is no such device of OpenCL; expected one of 0 "))
    return 1;
  if (SlipDeviceOpen(PETSC_COMM_SELF, "-test_device", "", &device)) {
    device = NULL;
    print_message("skipped: %s\n", message);
    return strstr(message, "there is no device") || !SlipDeviceBuiltIn() ? 0 : 1;
  }
  return 0;
}

SLIP_TESTS_WITH(setup, NULL, vectors, numbers, traffic, strides, adams, memory, lent, another, signals)
