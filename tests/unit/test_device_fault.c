/* A fault of rate and state whose steps are computed on a device of OpenCL, against the same by the processor: slip
   rates, runs, what goes between the two, bits, restarts, and what is refused. */
#include "devicerun.h"

static void rates(void **state)
{
  NEEDS_DEVICE;
  AssertRates("-fault_device opencl", 0);
  AssertRates("-fault_device opencl -fault_state_law slip -fault_kernel full_space", 0);
  AssertRates("-fault_device opencl -fault_state_law composite", 0);
  AssertRates("-fault_device opencl -fault_state_law prz", 0);
  AssertRates("-fault_device opencl -fault_state_law composite -fault_state_cutoff_rate 1e-3 -fault_slip_components 2 "
              "-fault_rake 30",
              0);
}

/* 220 years with two events by either integrator: the same steps, and by the default nothing but numbers between the
   two */
static void runs(void **state)
{
  const char *const integrators[] = {
    "-ts_adapt_type basic -ts_rtol 1e-5 -fault_output run.h5 -fault_output_overwrite -fault_output_slip_interval 100 ",
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
    AssertSums(&there);
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

/* The composite law through an event: as by the processor */
static void composite(void **state)
{
  Run host, there;

  NEEDS_DEVICE;
  ok(Solve("-ts_adapt_type basic -ts_rtol 1e-3 -fault_state_law composite", &host));
  ok(Solve("-ts_adapt_type basic -ts_rtol 1e-3 -fault_state_law composite -fault_device opencl", &there));
  assert_true(SlipDeviceVecIs(there.w) && !SlipDeviceVecIs(host.w));
  assert_int_equal(there.vectors, 0); /* no kernel was left out */
  assert_true(host.steps > 100);
  assert_int_equal(host.steps, there.steps);
  assert_int_equal(host.rejected, there.rejected);
  AssertSame(host.w, there.w, 1e-6); /* as in runs() */
  End(&host);
  End(&there);
}

/* What -fault_view says of the device */
static void Said(void)
{
  char text[65536], taken[128];
  Run run;
  FILE *file;

  ok(Begin("-fault_device opencl -fault_view :view.txt", &run));
  ok(PetscSNPrintf(taken, sizeof(taken), ", of which the fault and its integrator take up to %.3g MB\n",
                   1e-6 * (double)run.fault->device.bytes));
  End(&run);
  file = fopen("view.txt", "r");
  assert_non_null(file);
  text[fread(text, 1, sizeof(text) - 1, file)] = '\0';
  fclose(file);
  assert_non_null(strstr(text, taken));
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

SLIP_TESTS_WITH(setup, NULL, rates, runs, composite, restarts)
