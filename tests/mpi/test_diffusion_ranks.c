/* Fluid that diffuses in cells of several processes: as on one, and no volume is lost between them. Exit code 0:
   good. */
#include "ranks.h"
#include "cells.h"
#include "diffusion.h"

enum { NX = 24, NZ = 17, STEPS = 6 };

/* Two planes that meet along their middle, half of the second's cells on either side */
static void Kinked(const PetscReal from[2], PetscReal to[3])
{
  to[0] = 2400 * from[0];
  to[1] = 500 * PetscAbsReal(from[0] - 0.5);
  to[2] = 100 + 1700 * from[1];
}

/* Runs an injection in one cell; the pressures p [N] by rows, and what is missing of the volume, over it. */
static PetscErrorCode Inject(MPI_Comm comm, const char file[], PetscReal p[], PetscReal *missing)
{
  const PetscReal extent[MESH_REALS] = {[MESH_NX] = NX,         [MESH_NZ] = NZ,         [MESH_LENGTH_X] = 2400,
                                        [MESH_LENGTH_Z] = 1700, [MESH_DEPTH_TOP] = 100, [MESH_DIP] = 60};
  const FluidRock rock = {2e-10, 1e-10, 3e-11, 1e5};
  const PetscReal dt = 2e5;
  PetscReal stored, before, border, volume = 0;
  Fluid f;

  PetscCall(FluidCreate(comm, file, extent, &rock, &f));
  for (PetscInt i = 0; i < f.mesh.n; i++) {
    const PetscInt row = SlipFaultMeshRow(&f.mesh, i);

    f.source[i] = row == f.mesh.N / 3 ? 1e-3 : row == f.mesh.N / 2 ? -2e-4 : 0;
    f.p[i] = 1e5;
  }
  PetscCall(FluidStored(&f, &before));
  for (int k = 0; k < STEPS; k++) { /* backward Euler, whose flows at the end are those of its step */
    for (PetscInt i = 0; i < f.mesh.n; i++) f.work[i] = f.storage[i] * f.p[i] + dt * f.source[i];
    PetscCall(SlipDiffusionSolve(f.d, dt, f.work, f.p));
    PetscCall(SlipDiffusionFlow(f.d, &border, NULL));
    volume += dt * (8e-4 - border);
  }
  PetscCall(FluidStored(&f, &stored));
  *missing = PetscAbsReal(stored - before - volume) / (STEPS * dt * 1e-3);
  PetscCall(PetscArrayzero(p, f.mesh.N));
  for (PetscInt i = 0; i < f.mesh.n; i++) p[SlipFaultMeshRow(&f.mesh, i)] = f.p[i];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, p, (PetscMPIInt)f.mesh.N, MPIU_REAL, MPIU_SUM, comm));
  return FluidDestroy(&f);
}

/* The pressure agrees to the tolerance of the solver, 1e-9 of the largest change of a step; a sum over six steps has
   less than ten times that. */
static PetscErrorCode Compare(const char file[], PetscInt n)
{
  PetscReal *alone, *mine, missing[2], error = 0, most = 0;

  PetscCall(PetscMalloc2(n, &alone, n, &mine));
  PetscCall(Inject(PETSC_COMM_SELF, file, alone, &missing[0]));
  PetscCall(Inject(PETSC_COMM_WORLD, file, mine, &missing[1]));
  for (PetscInt e = 0; e < n; e++) {
    error = PetscMax(error, PetscAbsReal(mine[e] - alone[e]));
    most = PetscMax(most, PetscAbsReal(alone[e] - 1e5));
  }
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "differs by %g of %g, volume by %g, alone %g\n", (double)error, (double)most,
                        (double)missing[1], (double)missing[0]));
  Check(error < 1e-8 * most, "pressures differ by %g Pa of %g Pa", (double)error, (double)most);
  Check(missing[0] < 1e-12 && missing[1] < 1e-12, "%g of the volume is missing", (double)missing[1]);
  return PetscFree2(alone, mine);
}

static PetscErrorCode Test(void)
{
  PetscMPIInt rank, size;
  char file[64];

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscSNPrintf(file, sizeof(file), "test_diffusion_ranks_%d.h5", (int)size));
  PetscCall(Compare("", NX * NZ));
  if (!rank) PetscCall(FluidTriangles(file, NX, NZ, 0.5, Kinked));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscCall(Compare(file, 2 * NX * NZ));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!rank) { /* two planes of rectangles that meet in an edge */
    static PetscReal numbers[8 * 2 * NX * NZ];
    const SlipCells cells = TwoDippingPlanes(NX, NZ, numbers);

    PetscCall(WriteCells(file, &cells));
  }
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  PetscCall(Compare(file, 2 * NX * NZ));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  if (!rank) (void)remove(file);
  return PETSC_SUCCESS;
}

SLIP_RANKS(Test)
