/* The numbers of each fault in an event, against formulas of a constant strength; and the labels of a mesh. */
#include "unit.h"
#include "cells.h"
#include "faultstart.h"
#include <slipstep/private/slipelastic.h>
#include <slipstep/private/slipfault.h>
#include <math.h>
#include "tempdir.h"

enum { N = 12, FAULTS = 2, CELLS = 3 };
static const PetscReal names[FAULTS] = {2, 9}, residual = 0.5, area = 500 * 400, G = 30e9;

/* Rows of both faults in turn, each of two planes that meet: strikes 0 and 20 of fault 9, dips 90 and 60 of fault 2,
   2 km away */
static void MakeCells(const char file[], PetscReal label[N])
{
  PetscReal column[7][N];
  const SlipCells cells = {.n = N,
                           .x = column[0],
                           .y = column[1],
                           .z = column[2],
                           .length = column[3],
                           .width = column[4],
                           .strike = column[5],
                           .dip = column[6]};

  for (PetscInt e = 0; e < N; e++) {
    const PetscInt first = e % 2, plane = e / 2 % 2, k = e / 4;
    const PetscReal strike = first && plane ? 20 : 0, dip = !first && plane ? 60 : 90;
    const PetscReal down = !first && plane ? 1 : 0; /* the lower of two planes, or both at one depth */
    const PetscReal at[3] = {first && plane ? 1500 : 0, first ? 2000 : 0, 1000 + 400 * down};
    PetscReal d[9];

    SlipPlaneDirections(strike, dip, 0, d);
    for (int i = 0; i < 3; i++) column[i][e] = at[i] + (250 + 500 * (PetscReal)k) * d[i] - 200 * d[3 + i];
    column[3][e] = 500;
    column[4][e] = 400;
    column[5][e] = strike;
    column[6][e] = dip;
    label[e] = names[first];
  }
  ok(WriteLabelledCells(file, &cells, label));
}

/* A column of the only event, or a map of it */
static void Read(SlipH5 *h, const char name[], PetscInt ndim, PetscInt n, PetscReal value[])
{
  PetscInt dims[2] = {0, 1};
  PetscReal *x;

  ok(SlipH5ReadReal(h, name, ndim, dims, &x));
  assert_true(dims[0] == 1 && dims[1] == n);
  ok(PetscArraycpy(value, x, n));
  ok(PetscFree(x));
}

/* inertia: with it the first stage is backward, and the event begins between its state and the end of the first step;
   without it the event begins with the run. released: K times the slip of the event [Pa], of the rows */
static void Solve(const char mesh[], const char file[], const PetscReal stress[N], const PetscReal traction[N],
                  PetscBool inertia, PetscReal released[N])
{
  PetscInt n, label[FAULTS];
  PetscReal moment[FAULTS], slip[N], *a;
  SlipFault fault;
  SlipH5 h;
  TS ts;
  Vec w, u, force;

  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"mesh", mesh}, {"catalogue", file}, {"friction_law", "constant"}, {"initial", "traction"},
                     {"normal_coupling", "no"}));
  ok(FaultSetReals(fault, {"friction_residual", residual}, {"event_rate", inertia ? 8e-4 : 1e-4}, {"thickness", 1500}));
  ok(SlipFaultSetBool(fault, "initial_unstable", PETSC_TRUE));
  ok(SlipFaultSetBool(fault, "inertia", inertia));
  fault->options.catalogue_maps = PETSC_TRUE;
  ok(SlipFaultSetField(fault, "normal_stress", N, stress));
  ok(SlipFaultSetField(fault, "initial_traction", N, traction));
  ok(FaultStart(fault, TSADAPTNONE, 5e-3, 10, &w, &ts));
  ok(TSBatheSetFirstStage(ts, inertia ? TSBATHE_STAGE_BACKWARD : TSBATHE_STAGE_TRAPEZOIDAL));
  ok(SlipFaultGetLabels(fault, FAULTS, &n, label));
  assert_true(n == FAULTS && label[0] == 2 && label[1] == 9);
  assert_int_equal(4, fault->mesh.planes);
  ok(SlipFaultOutputStart(fault, ts));
  ok(TSSolve(ts, w));
  ok(SlipFaultOutputFinish(fault, ts, 0, 0));
  ok(SlipFaultGetEvents(fault, "onset", 1, &n, moment));
  assert_int_equal(1, n);
  ok(SlipFaultGetEvents(fault, "fault_moment", FAULTS, &n, moment));
  assert_int_equal(FAULTS, n);
  assert_true(moment[0] > 0 && moment[1] > 0);
  ok(SlipH5OpenRead(file, &h));
  Read(&h, "/maps/slip", 2, N, slip);
  ok(SlipH5Close(&h));
  ok(SlipFaultGetWork(fault, &u));
  ok(SlipFaultGetWork(fault, &force));
  ok(VecGetArrayWrite(u, &a));
  for (PetscInt i = 0; i < N; i++) a[i] = slip[SlipFaultMeshRow(&fault->mesh, i)];
  ok(VecRestoreArrayWrite(u, &a));
  ok(MatMult(fault->medium->K, u, force)); /* all areas are equal, and so rows have no weights */
  ok(VecGetArray(force, &a));
  for (PetscInt i = 0; i < N; i++) released[SlipFaultMeshRow(&fault->mesh, i)] = a[i];
  ok(VecRestoreArray(force, &a));
  ok(SlipFaultRestoreWork(fault, &force));
  ok(SlipFaultRestoreWork(fault, &u));
  ObjectsDestroy(&w, &ts, &fault);
}

/* A constant strength mu sigma dissipates mu sigma times slip, as cells slip one way alone, and slip is the integral
   of the slip rate by the same nodes and weights; stress falls by K times slip. Both are equal to rounding: measured
   2e-15 and 6e-16. Numbers of an event that slips backward are those along its direction. */
static void Event(PetscReal sign, PetscBool inertia)
{
  PetscReal label[N], stress[N], traction[N], slip[N], rupture[N], released[N], value[FAULTS], energy[FAULTS], all,
    onset, largest, direction, most = 0;
  char folder[TEMPDIR_LENGTH], mesh[TEMPDIR_LENGTH + 16], file[TEMPDIR_LENGTH + 16];
  SlipH5 h;

  assert_int_equal(0, TempDirMake("faults", folder));
  snprintf(mesh, sizeof(mesh), "%s/mesh.h5", folder);
  snprintf(file, sizeof(file), "%s/events.h5", folder);
  MakeCells(mesh, label);
  for (PetscInt e = 0; e < N; e++) {
    stress[e] = 2e7 + 1e6 * (PetscReal)e;
    traction[e] = sign * (residual * stress[e] +
                          (e == 2 ? -2e6 : 1e6 + 2e5 * (PetscReal)(e % 4))); /* one cell stays, others start */
  }
  Solve(mesh, file, stress, traction, inertia, released);
  ok(SlipH5OpenRead(file, &h));
  Read(&h, "/maps/slip", 2, N, slip);
  Read(&h, "/maps/rupture_time", 2, N, rupture);
  Read(&h, "/onset", 1, 1, &onset);
  Read(&h, "/dissipated_energy", 1, 1, &all);
  Read(&h, "/fault_dissipated_energy", 2, FAULTS, energy);
  AssertNear((energy[0] + energy[1]) / all, 1, 1e-13);
  Read(&h, "/direction", 1, 1, &direction);
  Read(&h, "/max_slip", 1, 1, &largest);
  for (PetscInt e = 0; e < N; e++) most = PetscMax(most, slip[e]);
  assert_true(direction == sign && largest == most);
  for (int k = 0; k < FAULTS; k++) {
    PetscReal work = 0, sum = 0, broken = 0, first = PETSC_MAX_REAL, drop = 0;
    PetscInt broke = 0;

    for (PetscInt e = 0; e < N; e++) {
      if (label[e] != names[k]) continue;
      assert_true(slip[e] >= 0);
      work += residual * stress[e] * area * slip[e];
      sum += slip[e];
      if (isnan(rupture[e])) continue;
      broke++;
      broken += slip[e];
      drop += released[e];
      first = PetscMin(first, rupture[e]);
    }
    assert_int_equal(N / FAULTS - (k == 0 ? 1 : 0), broke);
    AssertLess(1e-2, sum);
    AssertNear(energy[k] / work, 1, 1e-13);
    Read(&h, "/fault_moment", 2, FAULTS, value);
    AssertNear(value[k] / (G * area * sum), 1, 1e-13);
    Read(&h, "/fault_area", 2, FAULTS, value);
    AssertNear(value[k] / (area * (PetscReal)broke), 1, 1e-13);
    Read(&h, "/fault_mean_slip", 2, FAULTS, value);
    AssertNear(value[k] / (broken / (PetscReal)broke), 1, 1e-13);
    Read(&h, "/fault_onset", 2, FAULTS, value);
    assert_true(value[k] == onset + first);
    Read(&h, "/fault_stress_drop", 2, FAULTS, value);
    AssertNear(value[k] / (drop / (PetscReal)broke), 1, 1e-13);
  }
  ok(SlipH5Close(&h));
  assert_int_equal(0, TempDirRemove(folder));
}

static void one_event(void **state)
{
  Event(1, PETSC_FALSE);
  Event(-1, PETSC_FALSE);
  Event(1, PETSC_TRUE);
}

SLIP_TESTS(one_event)
