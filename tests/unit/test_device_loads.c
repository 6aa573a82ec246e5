/* Loads of a fault of rate and state that change in time, and cells that creep, on a device of OpenCL: slip rates,
   sums, runs, restarts, and what goes between processor and device. */
#include "devicerun.h"
#include "record.h"
#include <slipstep/rooms/sliph5.h>

/* Pressures of three times, which rise at the left and fall at the right */
static PetscErrorCode WriteOwnRecord(void)
{
  const PetscInt three = 3, shape[] = {3, N};
  const PetscReal times[] = {0, 3e8, 1.2e9};
  PetscReal pressure[3 * N];

  for (PetscInt i = 0; i < 3 * N; i++)
    pressure[i] = 2e6 + 1.5e6 * (PetscReal)(i / N) * (0.5 - (PetscReal)(i % NX) / NX);
  return WriteRecord("record.h5", three, times, 2, shape, pressure);
}

static PetscErrorCode OwnPressure(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  for (PetscInt i = 0; i < n; i++) p[i] = 1e6 * sin(t / 1e9 + 0.1 * (double)i);
  return PETSC_SUCCESS;
}

/* The cells of two columns creep, in a field; stressing differs from cell to cell */
static PetscErrorCode Creep(SlipFault fault)
{
  PetscReal a[N], b[N];

  for (PetscInt i = 0; i < N; i++) {
    a[i] = i % NX == 0 || i % NX == 9 ? 1 : 0;
    b[i] = 1e-3 * (double)(i % 7);
  }
  PetscCall(SlipFaultSetField(fault, "creep", N, a));
  return SlipFaultSetField(fault, "stressing_rate", N, b);
}

static PetscErrorCode Own(SlipFault fault)
{
  return SlipFaultSetPressureFunction(fault, OwnPressure, NULL);
}

#define INJECTION                                                                                                      \
  "-fault_injection 9e3,7e3 -fault_injection_pressure 1.5e6 -fault_injection_diffusivity 0.3 -fault_injection_stop "   \
  "4e8 "
static const struct {
  const char *options;
  PetscErrorCode (*prepare)(SlipFault);
  PetscInt arrays; /* at most in a step: of its state where a time of a record is passed, puts of a user's pressure */
} Loads[] = {{"-fault_stressing_rate 2e-3 ", NULL, 0},
             {INJECTION, NULL, 0},
             {INJECTION "-fault_friction_alpha 0.02 -fault_state_law slip -fault_stressing_rate -1e-3 ", NULL, 0},
             {"-fault_pore_pressure record.h5 ", NULL, 2},
             {"-fault_pore_pressure record.h5 -fault_friction_alpha 0.01 " INJECTION, Creep, 2},
             {"", Creep, 0},
             {"-fault_stressing_rate 1e-3 ", Own, 3}};
enum { NUM_LOADS = sizeof(Loads) / sizeof(*Loads) };

static void Within(char dir[])
{
  assert_int_equal(0, TempDirMake("device", dir));
  assert_int_equal(0, chdir(dir));
  ok(WriteOwnRecord());
}

static void Leave(const char dir[])
{
  assert_int_equal(0, chdir(".."));
  assert_int_equal(0, TempDirRemove(dir));
}

/* At the start, before and after an injection stops, between times of the record, at one of them and after all */
static void rates(void **state)
{
  const PetscReal times[] = {0, 1e7, 3e8, 4.5e8, 2e9};
  char dir[TEMPDIR_LENGTH], options[512];

  NEEDS_DEVICE;
  Within(dir);
  for (int k = 0; k < NUM_LOADS; k++) {
    Prepare = Loads[k].prepare;
    ok(PetscSNPrintf(options, sizeof(options), "%s-fault_device opencl", Loads[k].options));
    for (int j = 0; j < 5; j++) AssertRates(options, times[j]);
  }
  Leave(dir);
}

/* The same steps as by the processor, nothing but numbers between the two in most of them, and the same sums */
static void runs(void **state)
{
  char dir[TEMPDIR_LENGTH], options[512];
  Run host, there;

  NEEDS_DEVICE;
  Within(dir);
  for (int k = 0; k < NUM_LOADS; k++) {
    Prepare = Loads[k].prepare;
    ok(PetscSNPrintf(options, sizeof(options), "%s-ts_max_time 8e8 -ts_adapt_type basic -ts_rtol 1e-7 ",
                     Loads[k].options));
    ok(Solve(options, &host));
    ok(PetscStrlcat(options, "-fault_device opencl", sizeof(options)));
    ok(Solve(options, &there));
    assert_true(host.steps > 40);
    assert_int_equal(host.steps, there.steps);
    assert_int_equal(host.rejected, there.rejected);
    AssertSame(host.w, there.w, 1e-8); /* rounding, which loading enlarges, least by steps that accuracy bounds */
    AssertSums(&there);
    print_message("load %d: %d steps, at most %d arrays and %d numbers in one\n", k, (int)there.steps,
                  (int)there.vectors, (int)there.numbers);
    assert_true(there.vectors <= Loads[k].arrays);
    assert_true(there.numbers <= 64);
    End(&host);
    End(&there);
  }
  Leave(dir);
}

/* A run that goes on from a checkpoint, to the bit */
static void restarts(void **state)
{
  char dir[TEMPDIR_LENGTH], options[512];
  Run run[3];

  NEEDS_DEVICE;
  Within(dir);
  for (int k = 1; k < NUM_LOADS; k += 3) {
    const char *const more[] = {"-ts_max_steps 60", "-ts_max_steps 35 -fault_checkpoint state",
                                "-ts_max_steps 60 -fault_restart state"};

    Prepare = Loads[k].prepare;
    for (int j = 0; j < 3; j++) {
      ok(PetscSNPrintf(options, sizeof(options), "%s-fault_device opencl %s", Loads[k].options, more[j]));
      ok(Solve(options, &run[j]));
    }
    AssertSame(run[0].w, run[2].w, 0);
    for (int j = 0; j < 3; j++) End(&run[j]);
    remove("state");
  }
  Leave(dir);
}

SLIP_TESTS_WITH(setup, NULL, rates, runs, restarts)
