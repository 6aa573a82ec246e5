/* Elastic energy and the power of loading against what they are: the work of the stress, and the energy's change in
   time. */
#include "unit.h"
#include "faultstart.h"
#include <slipstep/private/slipfault.h>
#include <math.h>
#include "cells.h"
#include "tempdir.h"

enum { NX = 3, NZ = 3, N = 2 * NX * NZ };

/* Two planes of cells whose areas differ, with a stress at the start, its rate and a loading rate, all of them cell by
   cell */
static SlipFault Fault(void)
{
  PetscReal cells[5 * N], traction[N], stressing[N], loading[N];
  const SlipCells mesh = TwoGradedFaults(NX, NZ, 5, cells);
  char dir[TEMPDIR_LENGTH], file[TEMPDIR_FILE];
  SlipFault fault;

  assert_int_equal(0, TempDirFile("stress", "mesh.h5", dir, file));
  ok(WriteCells(file, &mesh));
  for (int i = 0; i < N; i++) {
    traction[i] = 1e7 * (1 + sin(i));
    stressing[i] = 0.02 * (1 + cos(2 * i));
    loading[i] = 1e-9 * (2 + sin(3 * i));
  }
  ok(SlipFaultCreate(PETSC_COMM_SELF, &fault));
  ok(FaultSetStrings(fault, {"mesh", file}, {"initial", "traction"}, {"viscosity", "radiation"}));
  ok(FaultSetReals(fault, {"normal_stress", 50e6}, {"normal_stress_gradient", 15e3}));
  ok(SlipFaultSetField(fault, "initial_traction", N, traction));
  ok(SlipFaultSetField(fault, "stressing_rate", N, stressing));
  ok(SlipFaultSetField(fault, "loading_rate", N, loading));
  ok(SlipFaultSetUp(fault));
  assert_true(fault->mesh.weight[N - 1] != fault->mesh.weight[0]);
  assert_int_equal(0, TempDirRemove(dir));
  return fault;
}

/* A state without slip rate whose displacement differs from cell to cell, and what dt of rest makes of it */
static Vec State(SlipFault fault, PetscReal scale, PetscReal dt)
{
  PetscReal *a;
  Vec w;

  ok(SlipFaultCreateState(fault, &w));
  ok(VecGetArray(w, &a));
  for (PetscInt i = 0; i < N; i++)
    a[3 * i + 1] = scale * (1 + cos(5 * (double)i)) - dt * fault->fields.cell[FIELD_LOADING_RATE][i];
  ok(VecRestoreArray(w, &a));
  return w;
}

static PetscReal EnergyOf(SlipFault fault, PetscReal t, Vec w)
{
  PetscReal energy;

  ok(SlipFaultElasticEnergy(fault, t, w, &energy));
  return energy;
}

/* The stress is linear in the displacement, so that its work from one state to another is that of the mean of both,
   times the area of each cell: the elastic energy falls by as much, at any time. */
static void energy(void **state)
{
  SlipFault fault = Fault();
  Vec from = State(fault, 0.1, 0), to = State(fault, 0.25, 1e8), stress[2];

  VecsDuplicate(fault->critical.uc, &stress[0], &stress[1]);
  for (int k = 0; k < 2; k++) {
    const PetscReal t = 3e8 * k, fall = EnergyOf(fault, t, from) - EnergyOf(fault, t, to), *a, *b, *x, *y;
    PetscReal work = 0;

    ok(SlipFaultStress(fault, t, from, stress[0]));
    ok(SlipFaultStress(fault, t, to, stress[1]));
    a = VecRead(from);
    b = VecRead(to);
    x = VecRead(stress[0]);
    y = VecRead(stress[1]);
    for (PetscInt i = 0; i < N; i++)
      work += fault->mesh.weight[i] * fault->mesh.area * 0.5 * (x[i] + y[i]) * (b[3 * i + 1] - a[3 * i + 1]);
    /* rounding of sums of 18 terms, of which the work is no small difference */
    assert_true(fabs(fall / work - 1) < 1e-12);
  }
  /* the stress of the start is T0 and its rate, whatever the area */
  ok(VecZeroEntries(from));
  ok(SlipFaultStress(fault, 1e8, from, stress[0]));
  {
    const PetscReal *x = VecRead(stress[0]);

    for (PetscInt i = 0; i < N; i++)
      assert_true(fabs(x[i] / (fault->fields.cell[FIELD_INITIAL_TRACTION][i] +
                               1e8 * fault->fields.cell[FIELD_STRESSING_RATE][i]) -
                       1) < 1e-14);
  }
  ObjectsDestroy(&from, &to, &stress[0], &stress[1], &fault);
}

/* While a fault rests its energy changes by loading alone, du/dt = -v_inf and dT/dt, and is quadratic in time: the
   power of loading is the difference of the energies before and after over the time between, however long that is. */
static void loading(void **state)
{
  const PetscReal t = 2e8, h = 1e8;
  SlipFault fault = Fault();
  Vec before = State(fault, 0.1, -h), now = State(fault, 0.1, 0), after = State(fault, 0.1, h);
  const PetscReal change = EnergyOf(fault, t + h, after) - EnergyOf(fault, t - h, before);
  PetscReal power;

  ok(SlipFaultLoadingPower(fault, t, now, &power));
  assert_true(fabs(2 * h * power / change - 1) < 1e-12);
  ObjectsDestroy(&before, &now, &after, &fault);
}

SLIP_TESTS(energy, loading)
