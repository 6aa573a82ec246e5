/* Slip as a vector, planes that dip and meshes on a device of OpenCL, where slip changes normal stress: slip rates,
   sums, runs, restarts, and what goes between processor and device. */
#include "devicerun.h"
#include <slipstep/rooms/sliph5.h>

/* The cells of the grid as a list; those of the right half are a fault of their own, which dips and is turned */
static PetscErrorCode WriteRectangles(void)
{
  const PetscInt shape[] = {N, 7}, count = N;
  PetscInt fault[N];
  PetscReal cells[N][7];
  SlipH5 h;

  for (PetscInt e = 0; e < N; e++) {
    const PetscInt i = e % NX, j = e / NX;
    const PetscBool right = i >= NX / 2 ? PETSC_TRUE : PETSC_FALSE;
    const PetscReal down = 2e3 * (j + 0.5), c = right ? 0.5 : 0, s = right ? sqrt(0.75) : 1;
    const PetscReal cell[7] = {2e3 * (i + 0.5), (right ? 1e3 : 0) + c * down, 1e3 + s * down, 2e3, 2e3, 0,
                               right ? 60 : 90};

    PetscCall(PetscArraycpy(cells[e], cell, 7));
    fault[e] = right ? 1 : 0;
  }
  PetscCall(SlipH5Create("rectangles.h5", &h));
  PetscCall(SlipH5WriteReal(&h, "/cells", 2, shape, cells[0], NULL));
  PetscCall(SlipH5WriteAttrString(&h, "/cells", "columns", "x y z length width strike dip"));
  PetscCall(SlipH5WriteAttrString(&h, "/cells", "units", "m"));
  PetscCall(SlipH5WriteInt(&h, "/fault", 1, &count, fault, NULL));
  return SlipH5Close(&h);
}

/* A plane that dips, 4 km squares of which each is cut in two */
static PetscErrorCode WriteTriangles(void)
{
  enum { COLUMNS = NX / 2, ROWS = NZ, ALL = (COLUMNS + 1) * (ROWS + 1) };
  const PetscInt vertices[] = {ALL, 3}, triangles[] = {N, 3};
  PetscReal vertex[ALL][3];
  PetscInt corner[N][3];
  SlipH5 h;

  for (PetscInt k = 0; k < ALL; k++) {
    const PetscReal down = 2e3 * (PetscReal)(k / (COLUMNS + 1));
    const PetscReal point[3] = {4e3 * (PetscReal)(k % (COLUMNS + 1)), 0.5 * down, 1e3 + sqrt(0.75) * down};

    PetscCall(PetscArraycpy(vertex[k], point, 3));
  }
  for (PetscInt q = 0; q < N / 2; q++) {
    const PetscInt k = q % COLUMNS + (COLUMNS + 1) * (q / COLUMNS), below = k + COLUMNS + 1;
    const PetscInt two[2][3] = {{k, k + 1, below}, {k + 1, below + 1, below}};

    PetscCall(PetscArraycpy(corner[2 * q], two[0], 6));
  }
  PetscCall(SlipH5Create("triangles.h5", &h));
  PetscCall(SlipH5WriteReal(&h, "/vertices", 2, vertices, vertex[0], "m"));
  PetscCall(SlipH5WriteInt(&h, "/triangles", 2, triangles, corner[0], NULL));
  return SlipH5Close(&h);
}

static PetscErrorCode Creep(SlipFault fault)
{
  PetscReal a[N];

  for (PetscInt i = 0; i < N; i++) a[i] = i % NX == 0 ? 1 : 0;
  return SlipFaultSetField(fault, "creep", N, a);
}

static const struct {
  const char *options;
  PetscErrorCode (*prepare)(SlipFault);
} Faults[] = {
  {"-fault_slip_components 2 -fault_rake 20 -fault_operator dense ", Creep},
  {"-fault_dip 60 -fault_rake 90 -fault_operator hmat ", NULL},
  {"-fault_dip 50 -fault_slip_components 2 -fault_rake -70 -fault_friction_alpha 0.02 -fault_operator dense ", Creep},
  {"-fault_mesh rectangles.h5 -fault_operator hmat -fault_stressing_rate 1e-3 ", NULL},
  {"-fault_mesh rectangles.h5 -fault_slip_components 2 -fault_rake 30 -fault_state_law slip "
   "-fault_injection 9e3,0,7e3 -fault_injection_pressure 1e6 -fault_injection_diffusivity 0.3 ",
   NULL},
  {"-fault_mesh triangles.h5 -fault_rake 80 -fault_operator hmat ", NULL},
};
enum { NUM_FAULTS = sizeof(Faults) / sizeof(*Faults) };

static void Within(char dir[])
{
  assert_int_equal(0, TempDirMake("device", dir));
  assert_int_equal(0, chdir(dir));
  ok(WriteRectangles());
  ok(WriteTriangles());
}

static void Leave(const char dir[])
{
  Prepare = NULL;
  assert_int_equal(0, chdir(".."));
  assert_int_equal(0, TempDirRemove(dir));
}

static void rates(void **state)
{
  char dir[TEMPDIR_LENGTH], options[512];

  NEEDS_DEVICE;
  Within(dir);
  for (int k = 0; k < NUM_FAULTS; k++) {
    Prepare = Faults[k].prepare;
    ok(PetscSNPrintf(options, sizeof(options), "%s-fault_device opencl", Faults[k].options));
    AssertRates(options, 1e7);
  }
  Leave(dir);
}

/* The same steps as by the processor, nothing but numbers between the two, and the same sums */
static void runs(void **state)
{
  char dir[TEMPDIR_LENGTH], options[512];
  Run host, there;

  NEEDS_DEVICE;
  Within(dir);
  for (int k = 0; k < NUM_FAULTS; k++) {
    Prepare = Faults[k].prepare;
    ok(PetscSNPrintf(
      options, sizeof(options),
      "%s-ts_max_time 1e9 -ts_adapt_type basic -ts_rtol 1e-7 -fault_output run.h5 -fault_output_overwrite "
      "-fault_output_slip_interval 100 ",
      Faults[k].options));
    ok(Solve(options, &host));
    ok(PetscStrlcat(options, "-fault_device opencl", sizeof(options)));
    ok(Solve(options, &there));
    assert_true(host.steps > 40);
    assert_int_equal(host.steps, there.steps);
    assert_int_equal(host.rejected, there.rejected);
    AssertSame(host.w, there.w, 1e-7); /* rounding, which loading enlarges, least by steps that accuracy bounds */
    AssertSums(&there);
    print_message("fault %d: %d steps, at most %d arrays and %d numbers in one\n", k, (int)there.steps,
                  (int)there.vectors, (int)there.numbers);
    assert_int_equal(there.vectors, 0);
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
  for (int k = 2; k < NUM_FAULTS; k += 2) {
    const char *const more[] = {"-ts_max_steps 60", "-ts_max_steps 35 -fault_checkpoint state",
                                "-ts_max_steps 60 -fault_restart state"};

    Prepare = Faults[k].prepare;
    for (int j = 0; j < 3; j++) {
      ok(PetscSNPrintf(options, sizeof(options), "%s-fault_device opencl %s", Faults[k].options, more[j]));
      ok(Solve(options, &run[j]));
    }
    AssertSame(run[0].w, run[2].w, 0);
    for (int j = 0; j < 3; j++) End(&run[j]);
    remove("state");
  }
  Leave(dir);
}

/* Numbers of a file of the processor's and one of the device's run, off by a share of the largest */
static void AssertDataset(const char host[], const char there[], const char path[], PetscInt ndim, PetscReal share)
{
  PetscInt dims[2][4], n = 1;
  PetscReal *a, *b, most = 0;
  SlipH5 h[2];

  ok(SlipH5OpenRead(host, &h[0]));
  ok(SlipH5OpenRead(there, &h[1]));
  for (int k = 0; k < 2; k++)
    for (PetscInt j = 0; j < ndim; j++) dims[k][j] = -1;
  ok(SlipH5ReadRealSized(&h[0], path, ndim, dims[0], NULL, dims[0], &a));
  ok(SlipH5ReadRealSized(&h[1], path, ndim, dims[1], NULL, dims[1], &b));
  for (PetscInt j = 0; j < ndim; j++) {
    assert_int_equal(dims[0][j], dims[1][j]);
    n *= dims[0][j];
  }
  assert_true(n > 0);
  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, isnan(a[i]) ? 0 : fabs(a[i]));
  for (PetscInt i = 0; i < n; i++) {
    if (isnan(a[i]) && isnan(b[i])) continue;
    if (!(fabs(a[i] - b[i]) <= share * most))
      fail_msg("%s[%d] is %.15g, expected %.15g", path, (int)i, (double)b[i], (double)a[i]);
  }
  ok(PetscFree(a));
  ok(PetscFree(b));
  ok(SlipH5Close(&h[0]));
  ok(SlipH5Close(&h[1]));
}

/* Stations, points of the ground and events, which take no vector from the device but where an event begins and ends */
static void observers(void **state)
{
  static const struct {
    const char *path;
    PetscInt ndim;
  } data[] = {{"/stations/0/slip", 1},      {"/stations/0/slip_rate", 1}, {"/stations/1/traction", 1},
              {"/stations/1/state", 1},     {"/ground/displacement", 3},  {"/ground/velocity", 3},
              {"/series/friction_power", 1}};
  static const char *const columns[] = {"/onset",    "/end", "/magnitude", "/radiated_energy", "/dissipated_energy",
                                        "/mean_slip"};
  const char *const faults[] = {"-fault_friction_slip 0.1 ", "-fault_mesh rectangles.h5 -fault_operator dense "};
  char dir[TEMPDIR_LENGTH], options[1024];
  Run run[2];

  NEEDS_DEVICE;
  Within(dir);
  for (int k = 0; k < 2; k++) {
    for (int j = 0; j < 2; j++) {
      ok(PetscSNPrintf(
        options, sizeof(options),
        "%s-ts_adapt_type basic -ts_rtol 1e-5 -ts_max_time %s -fault_output run%d.h5 -fault_output_overwrite "
        "-fault_output_slip_interval "
        "100 -fault_catalogue events%d.h5 -fault_catalogue_maps yes -fault_stations 11000,%s5000;21000,%s "
        "-fault_surface_stations 0,2000;9000,-3000;1000,1000;0,-500;7000,7000 %s",
        faults[k], k ? "4e9" : "5e9", j, j, k ? "0," : "", k ? "5500,8794.23" : "9000",
        j ? "-fault_device opencl" : ""));
      ok(Solve(options, &run[j]));
    }
    assert_int_equal(run[0].steps, run[1].steps);
    AssertSame(run[0].w, run[1].w, 1e-6);
    print_message("%d steps, of which %d with vectors, at most %d numbers in one\n", (int)run[1].steps,
                  (int)run[1].busy, (int)run[1].numbers);
    for (size_t j = 0; j < sizeof(data) / sizeof(*data); j++)
      AssertDataset("run0.h5", "run1.h5", data[j].path, data[j].ndim, 1e-7);
    if (k == 0) {
      for (size_t j = 0; j < sizeof(columns) / sizeof(*columns); j++)
        AssertDataset("events0.h5", "events1.h5", columns[j], 1, 1e-7);
      AssertDataset("events0.h5", "events1.h5", "/maps/rupture_time", 3, 1e-6);
    }
    assert_true(run[1].busy <= 8);
    End(&run[0]);
    End(&run[1]);
  }
  Leave(dir);
}

SLIP_TESTS_WITH(setup, NULL, rates, runs, restarts, observers)
