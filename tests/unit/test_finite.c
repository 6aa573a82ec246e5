/* Numbers that are none do not get into files: a run whose pressure ceases to be a number ends in an error that says
   so, and its output and its catalogue have what was before. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/sliph5.h>
#include <math.h>
#include "tempdir.h"

enum { NX = 3, NZ = 2 };
static const PetscReal last = 1e8; /* until when the pressure is a number [s] */

static PetscErrorCode Ends(SlipFault fault, PetscReal t, PetscInt n, PetscReal p[], void *ctx)
{
  for (PetscInt i = 0; i < n; i++) p[i] = t > last ? (PetscReal)NAN : 1e6;
  return PETSC_SUCCESS;
}

/* Counts of numbers, and of those that are none */
typedef struct {
  size_t all, bad;
} Count;

/* Of the datasets that a file has, or that which stays of it when a run does not end; rupture times are NaN where
   nothing ruptures, and are not among them. */
static Count Scan(const char name[])
{
  static const struct {
    const char *name;
    PetscInt ndim;
  } data[] = {{"/series/time", 1},
              {"/series/mean_slip", 1},
              {"/series/mean_slip_rate", 1},
              {"/series/elastic_energy", 1},
              {"/fields/slip", 3},
              {"/fields/slip_rate", 3},
              {"/fields/traction", 3},
              {"/steps/dt", 1},
              {"/onset", 1},
              {"/end", 1},
              {"/moment", 1},
              {"/mean_slip", 1},
              {"/ts/solution", 1}};
  char part[TEMPDIR_LENGTH + 64];
  Count count = {0, 0};
  SlipH5 h;

  snprintf(part, sizeof(part), "%s.part", name);
  ok(SlipH5OpenRead(access(name, R_OK) ? part : name, &h));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(data); k++) {
    PetscInt dims[3] = {1, 1, 1};
    PetscBool has;
    PetscReal *x;

    ok(SlipH5Has(&h, data[k].name, &has));
    if (!has) continue;
    ok(SlipH5ReadReal(&h, data[k].name, data[k].ndim, dims, &x));
    for (PetscInt i = 0; i < dims[0] * dims[1] * dims[2]; i++) {
      count.all++;
      if (!isfinite(x[i])) count.bad++;
    }
    ok(PetscFree(x));
  }
  ok(SlipH5Close(&h));
  return count;
}

static void Run(TSType type, TSAdaptType adapt)
{
  char folder[TEMPDIR_LENGTH], file[2][TEMPDIR_LENGTH + 24];
  const char *const options[] = {"output", "catalogue"};
  const PetscBool bathe = strcmp(type, TSBATHE) ? PETSC_FALSE : PETSC_TRUE;
  PetscReal time;
  SlipFault fault;
  TS ts;
  Vec w;

  assert_int_equal(0, TempDirMake("finite", folder));
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"friction_law", bathe ? "constant" : "rate_and_state"}, {"viscosity", "radiation"}));
  ok(FaultSetReals(fault, {"nx", NX}, {"nz", NZ}, {"normal_stress", 50e6}, {"normal_stress_gradient", 0},
                   {"loading_rate", 1e-9}));
  if (bathe) ok(SlipFaultSetString(fault, "initial", "traction"));
  if (bathe) ok(SlipFaultSetReal(fault, "initial_traction", 24e6));
  ok(SlipFaultSetInertia(fault, PETSC_FALSE));
  ok(SlipFaultSetPressureFunction(fault, Ends, NULL));
  for (int k = 0; k < 2; k++) {
    snprintf(file[k], sizeof(file[k]), "%s/%s.h5", folder, options[k]);
    ok(SlipFaultSetString(fault, options[k], file[k]));
  }
  ok(FaultStart(fault, TSADAPTNONE, 1e6, 3 * last, &w, &ts));
  ok(TSSetType(ts, type));
  SetAdapt(ts, adapt);
  ok(TSSetMaxSteps(ts, 1000));
  ok(SlipFaultOutputStart(fault, ts));
  fails(TSSolve(ts, w), "SlipFaultSetPressureFunction() gives nan");
  ok(TSGetTime(ts, &time));
  assert_true(time > 0 && time <= last);
  ObjectsDestroy(&w, &ts, &fault);
  for (int k = 0; k < 2; k++) {
    const Count count = Scan(file[k]);

    assert_true(k || count.all > 50);
    if (count.bad) fail_msg("%s, %s: %zu of %zu numbers of %s are none", type, adapt, count.bad, count.all, file[k]);
  }
  assert_int_equal(0, TempDirRemove(folder));
}

static void bathe(void **state)
{
  Run(TSBATHE, "heuristic");
  Run(TSBATHE, TSADAPTNONE);
}

static void explicit_steps(void **state)
{
  Run(TSRK, TSADAPTBASIC);
  Run(TSADAMS, TSADAPTDSP);
  Run(TSADAMS, TSADAPTNONE);
}

SLIP_TESTS(bathe, explicit_steps)
