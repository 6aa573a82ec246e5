/* Runs of a fault of rate and state on a device of OpenCL beside those of the processor, for unit/test_device_*.c.
   Where there is no device the tests say so. */
#pragma once
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
  if (!present) skip()

typedef struct {
  SlipFault fault;
  TS ts;
  Vec w;
  PetscInt steps, rejected;
  SlipDeviceTraffic last;             /* at the end of the step before */
  PetscInt refused;                   /* attempts so far */
  PetscInt busy;                      /* steps with vectors */
  PetscInt64 vectors, numbers, bytes; /* most of a step; numbers of an attempt */
} Run;

static PetscErrorCode Watch(TS ts, PetscInt step, PetscReal t, Vec w, void *ctx)
{
  Run *run = (Run *)ctx;
  const SlipDeviceTraffic now = SlipDeviceGetTraffic();
  PetscInt refused;
  PetscReal end;

  PetscCall(TSGetStepRejections(ts, &refused));
  PetscCall(TSGetMaxTime(ts, &end));
  if (step > 2 &&
      t <
        end) { /* in the first two tolerances are put there, and the largest eigenvalue is found; the end is written */
    run->vectors = PetscMax(run->vectors, now.puts + now.fetches - run->last.puts - run->last.fetches);
    run->busy += now.puts + now.fetches > run->last.puts + run->last.fetches ? 1 : 0;
    run->numbers = PetscMax(run->numbers, (now.numbers - run->last.numbers) / (1 + refused - run->refused));
  }
  run->bytes = PetscMax(run->bytes, now.bytes);
  run->last = now;
  run->refused = refused;
  return PETSC_SUCCESS;
}

/* Before SlipFaultSetUp(), for fields and functions of a test; NULL: none */
static PetscErrorCode (*Prepare)(SlipFault fault) = NULL;

static PetscErrorCode Begin(const char options[], Run *run)
{
  PetscReal a[N];

  *run = (Run){0};
  PetscCall(SetOptions(base));
  PetscCall(PetscOptionsInsertString(NULL, options));
  PetscCall(SlipFaultCreate(PETSC_COMM_SELF, &run->fault));
  PetscCall(SlipFaultSetFromOptions(run->fault));
  for (PetscInt i = 0; i < N; i++) a[i] = i % NX < 3 || i % NX > 12 || i / NX > 5 ? 0.04 : 0.004 + 1e-4 * (PetscReal)i;
  PetscCall(SlipFaultSetField(run->fault, "friction_a", N, a));
  if (Prepare) PetscCall((*Prepare)(run->fault));
  PetscCall(SlipFaultSetUp(run->fault));
  PetscCall(SlipFaultCreateState(run->fault, &run->w));
  PetscCall(SlipFaultSetInitialState(run->fault, run->w));
  PetscCall(TSCreate(PETSC_COMM_SELF, &run->ts));
  PetscCall(SlipFaultConfigureTS(run->fault, run->ts));
  PetscCall(TSSetSolution(run->ts, run->w));
  PetscCall(TSMonitorSet(run->ts, Watch, run, NULL));
  return TSSetFromOptions(run->ts);
}

static PetscErrorCode Solve(const char options[], Run *run)
{
  int code;

  PetscCall(Begin(options, run));
  PetscCall(SlipFaultOutputStart(run->fault, run->ts));
  PetscCall(SlipFaultCheckpointStart(run->fault, run->ts));
  PetscCall(TSSolve(run->ts, run->w));
  PetscCall(SlipFaultCheckpointFinish(run->fault, run->ts, &code));
  PetscCall(SlipFaultOutputFinish(run->fault, run->ts, 0, 0));
  PetscCall(TSGetStepNumber(run->ts, &run->steps));
  return TSGetStepRejections(run->ts, &run->rejected);
}

static void End(Run *run)
{
  ObjectsDestroy(&run->w, &run->ts, &run->fault);
}

static void AssertSame(Vec x, Vec y, PetscReal allowed)
{
  const PetscReal *a, *b;
  PetscReal most = 0;
  PetscInt block, c;

  ok(VecGetBlockSize(x, &block));
  c = (block - 1) / 2;
  ok(VecGetArrayRead(x, &a));
  ok(VecGetArrayRead(y, &b));
  for (PetscInt i = 0; i < block * N; i++) {
    const PetscReal differ = fabs(a[i] - b[i]), *v = a + i / block * block;

    /* rates over their magnitude; displacements and states, which are of metres and tens, as they are */
    most = PetscMax(most, i % block < c && differ > 0 ? differ / hypot(v[0], c > 1 ? v[1] : 0) : differ);
  }
  if (!(most <= allowed)) fail_msg("off by %g, expected at most %g", (double)most, (double)allowed);
  ok(VecRestoreArrayRead(y, &b));
  ok(VecRestoreArrayRead(x, &a));
}

/* A vector of the processor with the layout of a state */
static void OnHost(const Run *run, Vec *host)
{
  PetscInt block, n;

  ok(VecGetBlockSize(run->w, &block));
  ok(VecGetLocalSize(run->w, &n));
  ok(VecCreateSeq(PETSC_COMM_SELF, n, host));
  ok(VecSetBlockSize(*host, block));
}

/* The derivatives at t of states that runs have and of others: cells whose stress friction hardly opposes, or reverses,
   and states of all decades */
static void AssertRates(const char options[], PetscReal t)
{
  Vec host, f, there;
  const PetscReal *a, *b;
  PetscInt block, c;
  PetscReal *w;
  Run run;

  ok(Begin(options, &run));
  OnHost(&run, &host);
  ok(VecDuplicate(host, &f));
  ok(VecDuplicate(run.w, &there));
  ok(VecGetBlockSize(host, &block));
  c = (block - 1) / 2;
  for (int decade = 0; decade < 6; decade++) {
    ok(VecGetArrayWrite(host, &w));
    for (PetscInt i = 0; i < N; i++) {
      for (PetscInt k = 0; k < c; k++) {
        w[block * i + k] = 0;
        w[block * i + c + k] = 3 * decade * sin(1 + 0.37 * (double)i + (double)k) * cos(0.05 * (double)i);
      }
      w[block * i + 2 * c] = decade == 5 ? 60 * cos(0.3 * (double)i) : 7 + (12 - 4 * decade) * cos(0.3 * (double)i);
    }
    ok(VecRestoreArrayWrite(host, &w));
    ok(VecCopy(host, run.w));
    ok(SlipFaultRates(run.fault, t, host, f)); /* by the processor, as no kernel takes this vector */
    ok(SlipFaultRates(run.fault, t, run.w, there));
    ok(VecGetArrayRead(f, &a));
    ok(VecGetArrayRead(there, &b));
    for (PetscInt i = 0; i < block * N; i++) {
      const PetscReal *v = a + i / block * block + c; /* of a cell that hardly slips across, the whole rate counts */
      const PetscReal size = i % block < 2 * c ? hypot(v[0], c > 1 ? v[1] : 0) : fabs(a[i]);

      /* rounding of stresses of 1e8 Pa over a sigma = 2.5e5 Pa, of which rates are exponentials */
      AssertNear(b[i], a[i], 2e-12 * size + 1e-20);
    }
    ok(VecRestoreArrayRead(there, &b));
    ok(VecRestoreArrayRead(f, &a));
  }
  ObjectsDestroy(&host, &f, &there);
  End(&run);
}

/* Sums over the cells of a run's state, its powers and its fastest relaxation, against the processor's */
static void AssertSums(Run *run)
{
  const SlipFaultSums *sums;
  PetscReal sum[FAULT_NUM_SUMS], speed, power[2][3], relaxation[2];
  PetscReal t;
  Vec host;

  ok(TSGetTime(run->ts, &t));
  OnHost(run, &host);
  ok(VecCopy(run->w, host));
  ok(SlipFaultGetSums(run->fault, t, run->w, &sums));
  ok(PetscArraycpy(sum, sums->sum, FAULT_NUM_SUMS));
  speed = sums->max_v;
  ok(SlipFaultGetSums(run->fault, t, host, &sums));
  /* terms of either sign, a thousand times the sum where they cancel */
  for (int k = 0; k < FAULT_NUM_SUMS; k++) AssertNear(sum[k], sums->sum[k], 1e-11 * (fabs(sum[k]) + 1e-9));
  AssertNear(speed, sums->max_v, 0);
  ok(SlipFaultGetPowers(run->fault, t, run->w, NULL, power[0], NULL));
  ok(SlipFaultGetPowers(run->fault, t, host, NULL, power[1], NULL));
  for (int k = 0; k < 3; k++) AssertNear(power[0][k], power[1][k], 1e-12 * fabs(power[1][k]));
  ok(SlipFaultRelaxation(run->ts, run->w, &relaxation[0], run->fault));
  ok(SlipFaultRelaxation(run->ts, host, &relaxation[1], run->fault));
  AssertNear(relaxation[0], relaxation[1], 1e-12 * relaxation[1]);
  ok(VecDestroy(&host));
}

static int setup(void **state)
{
  SlipDevice device;

  present = SlipDeviceOpen(PETSC_COMM_SELF, "-test_device", "", &device) ? PETSC_FALSE : PETSC_TRUE;
  if (!present) print_message("skipped: %s\n", message);
  return 0;
}
