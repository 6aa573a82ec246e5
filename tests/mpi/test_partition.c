/* Cells over ranks: compact shares of equal cost, and operators that do not depend on them. Exit code 0: good. */
#include "ranks.h"
#include "faultstart.h"
#include "cells.h"
#include <slipstep/rooms/slipelastic.h>
#include <slipstep/private/slipfault.h>

enum { NX = 40, NZ = 24, N = 2 * NX * NZ };
#define MASS 7e6

static PetscReal data[5 * N];

/* The rows of the file are in an order that has nothing to do with where cells are: 997 is prime. */
static SlipCells MakeCells(void)
{
  return TwoGradedFaults(NX, NZ, 997, data);
}

/* Sides that cells share with one of another rank. */
static PetscInt SharedSides(const SlipCells *c, const PetscMPIInt owner[])
{
  PetscInt cut = 0;

  for (PetscInt a = 0; a < N; a++)
    for (PetscInt b = 0; b < a; b++) {
      const PetscReal dx = PetscAbsReal(c->x[a] - c->x[b]), dz = PetscAbsReal(c->z[a] - c->z[b]);
      const PetscBool beside = (PetscBool)(dx < 51 && dz < 1), above = (PetscBool)(dx < 1 && dz < c->width[a] + 1);

      if (c->y[a] == c->y[b] && (beside || above) && owner[a] != owner[b]) cut++;
    }
  return cut;
}

/* A square of n cells has 4 sqrt(n) sides and each shared one counts for two ranks; half as many again for shapes. The
   cost of a cell varies by half. */
static PetscErrorCode CheckShares(const SlipCells *c)
{
  PetscMPIInt *owner, size;
  PetscInt *counts, k = 0;
  PetscReal limit;

  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscMalloc1(size, &counts));
  PetscCall(PetscMalloc1(N, &owner));
  PetscCallMPI(MPI_Allgather(&c->nlocal, 1, MPIU_INT, counts, 1, MPIU_INT, PETSC_COMM_WORLD));
  for (PetscInt i = 0; i < N; i++) owner[i] = -1;
  for (PetscMPIInt r = 0; r < size; r++) {
    Check(counts[r] > 0.6 * N / size && counts[r] < 1.5 * N / size, "rank %d has %d of %d cells", (int)r,
          (int)counts[r], (int)N);
    for (PetscInt i = 0; i < counts[r]; i++, k++) {
      Check(k < N && owner[c->order[k]] == -1, "a cell is in two shares");
      Check(i == 0 || c->order[k] > c->order[k - 1], "a share is not in order");
      owner[c->order[k]] = r;
    }
  }
  Check(k == N, "%d of %d cells are in a share", (int)k, (int)N);
  limit = 1.5 * size * 4 * PetscSqrtReal((PetscReal)N / size) / 2;
  k = SharedSides(c, owner);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%d shared sides, at most %g\n", (int)k, (double)limit));
  Check(k <= limit, "the shares are not compact");
  PetscCall(PetscFree(counts));
  return PetscFree(owner);
}

static PetscReal Value(PetscInt cell)
{
  return PetscSinReal((PetscReal)(cell * cell % 1000));
}

/* y = A x with x by cell; all [N] by cell, from A's rows order (NULL: by cell) */
static PetscErrorCode Product(Mat A, PC pc, const PetscInt order[], PetscReal all[])
{
  PetscInt start, end;
  PetscReal *a;
  Vec x, y;

  PetscCall(MatCreateVecs(A, &x, &y));
  PetscCall(VecGetOwnershipRange(x, &start, &end));
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = start; i < end; i++) a[i - start] = Value(order ? order[i] : i);
  PetscCall(VecRestoreArrayWrite(x, &a));
  if (pc)
    PetscCall(PCApply(pc, x, y));
  else
    PetscCall(MatMult(A, x, y));
  PetscCall(PetscArrayzero(all, N));
  PetscCall(VecGetArray(y, &a));
  for (PetscInt i = start; i < end; i++) all[order ? order[i] : i] = a[i - start];
  PetscCall(VecRestoreArray(y, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all, N, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)A)));
  return DestroyObjects(&x, &y);
}

enum { STIFFNESS, VISCOSITY, STAGE, INVERSE, NUM };

static PetscErrorCode Frequency(Mat K, const PetscInt order[], PetscReal *omega)
{
  const SlipElasticRock rock = {.mass = MASS, .viscosity = "none", .tolerance = 1e-8, .components = 1, .order = order};
  SlipElastic el;

  PetscCall(SlipElasticCreate(PetscObjectComm((PetscObject)K), &el));
  PetscCall(SlipElasticSetStiffness(el, K, NULL));
  PetscCall(SlipElasticSetUp(el, &rock));
  PetscCall(SlipElasticGetFrequency(el, omega));
  return SlipElasticDestroy(&el);
}

static PetscErrorCode Products(MPI_Comm comm, const SlipCells *c, PetscReal result[NUM][N], PetscReal *omega)
{
  Mat K, H, B;
  PC pc;

  PetscCall(MatCreateSlipCellStiffness(comm, c, "hmat", 1e-6, &K));
  PetscCall(MatScale(K, 0.5));
  PetscCall(Frequency(K, c->order, omega));
  PetscCall(MatCreateSlipViscosity(K, MASS, 0.25, "lanczos", &H));
  PetscCall(MatSlipViscositySetTolerance(H, 1e-12));
  PetscCall(MatCreateSlipStage(K, H, MASS, &B));
  PetscCall(MatSlipStageSetTheta(B, 1));
  PetscCall(PCCreate(comm, &pc));
  PetscCall(PCSetOperators(pc, B, B));
  PetscCall(PCSetType(pc, PCSLIPSTAGE));
  PetscCall(PCSetUp(pc));
  PetscCall(Product(K, NULL, c->order, result[STIFFNESS]));
  PetscCall(Product(H, NULL, c->order, result[VISCOSITY]));
  PetscCall(Product(B, NULL, c->order, result[STAGE]));
  PetscCall(Product(B, pc, c->order, result[INVERSE]));
  PetscCall(PCDestroy(&pc));
  return DestroyObjects(&B, &H, &K);
}

/* Blocks do not depend on the shares, only the order of sums does: 1e-12. Lanczos' method looks at its convergence, so
   that its products agree to a few of its tolerance, and those with B, of which H is a part. The preconditioner is an
   inverse diagonal, whose part of H is scaled by the mean of 16 rows, evenly spread over the matrix: the shares order
   the rows, so these are other cells, and their mean differs by 1e-4 to 3e-4 here. It is no error of a product: only
   the path of the linear iterations depends on it. */
static PetscErrorCode Run(void)
{
  static PetscReal mine[NUM][N], alone[NUM][N];
  const PetscReal tolerance[NUM] = {1e-12, 1e-11, 1e-11, 1e-3};
  SlipCells c = MakeCells();
  PetscReal omega[2];
  PetscInt *order;

  PetscCall(Products(PETSC_COMM_SELF, &c, alone, &omega[0]));
  PetscCall(SlipCellsPartition(PETSC_COMM_WORLD, &c, "hmat", NULL, &order, &c.nlocal));
  c.order = order;
  PetscCall(CheckShares(&c));
  PetscCall(Products(PETSC_COMM_WORLD, &c, mine, &omega[1]));
  for (int k = 0; k < NUM; k++) {
    PetscReal error = 0, norm = 0;

    for (PetscInt e = 0; e < N; e++) {
      error += PetscSqr(mine[k][e] - alone[k][e]);
      norm += PetscSqr(alone[k][e]);
    }
    Check(error <= PetscSqr(tolerance[k]) * norm, "product %d differs by %g, expected at most %g", k,
          (double)PetscSqrtReal(error / norm), (double)tolerance[k]);
  }
  /* From the same start, so that only rounding differs: some 1e-15 in each of 20 products */
  Check(PetscAbsReal(omega[1] - omega[0]) <= 1e-11 * omega[0], "largest frequency %.15g rad/s, on one rank %.15g rad/s",
        (double)omega[1], (double)omega[0]);
  return PetscFree(order);
}

/* The worst cell of a solve is called by its row of the mesh's file. One cell is thrown at 1 km/s at the start of a
   stage that takes no iteration: its residual, mass over theta times that, is 1e3 times any strength. */
static PetscErrorCode WorstCell(SlipFault fault)
{
  const PetscInt rows[] = {0, 1, 777, N - 1};
  SNES snes;
  Vec w, x, r;

  PetscCall(SlipFaultConstraintCreate(fault));
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(SNESSetType(snes, SNESSEMISMOOTH));
  PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 0, PETSC_DEFAULT));
  PetscCall(SNESSetSlipConstraint(snes, fault->stage.con));
  PetscCall(SlipFaultCreateState(fault, &w));
  PetscCall(DuplicateVecs(fault->critical.uc, &x, &r));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(rows); k++) {
    const SlipStage stage = {.theta = 1e-2, .omega = 1, .base = w};
    PetscInt found;

    PetscCall(VecZeroEntries(w));
    PetscCall(VecZeroEntries(x));
    for (PetscInt i = fault->mesh.start; i < fault->mesh.start + fault->mesh.n; i++)
      if ((fault->mesh.order ? fault->mesh.order[i] : i) == rows[k])
        PetscCall(VecSetValue(w, 3 * i, 1e3, INSERT_VALUES));
    PetscCall(VecAssemble(w));
    PetscCall(SNESSlipSolveStage(snes, &stage, x, r, NULL));
    PetscCall(SNESSlipGetWorstCell(snes, &found, NULL));
    Check(found == rows[k], "the worst cell is %d, expected that of row %d", (int)found, (int)rows[k]);
  }
  return DestroyObjects(&r, &x, &w, &snes);
}

/* A field is given by the rows of the mesh's file, and every process takes those of its own cells. */
static PetscErrorCode GiveField(void)
{
  const SlipCells c = MakeCells();
  PetscReal stress[N];
  char file[64];
  PetscMPIInt rank, size;
  SlipFault fault;

  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCall(PetscSNPrintf(file, sizeof(file), "test_partition_%d.h5", (int)size));
  if (!rank) PetscCall(WriteCells(file, &c));
  PetscCallMPI(MPI_Barrier(PETSC_COMM_WORLD));
  for (PetscInt k = 0; k < N; k++) stress[k] = 1e7 + k;
  PetscCall(SlipFaultCreate(PETSC_COMM_WORLD, &fault));
  PetscCall(FaultSetStrings(fault, {"mesh", file}, {"operator", "hmat"}, {"viscosity", "none"}));
  PetscCall(SlipFaultSetReal(fault, "thickness", 2000));
  PetscCall(SlipFaultSetField(fault, "normal_stress", N, stress));
  PetscCall(SlipFaultSetUp(fault));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt e = fault->mesh.start + i, row = fault->mesh.order ? fault->mesh.order[e] : e;
    const PetscReal got = fault->fields.cell[FIELD_NORMAL_STRESS][i];

    Check(got == stress[row], "the cell of row %d has %.1f Pa, given were %.1f", (int)row, (double)got,
          (double)stress[row]);
  }
  PetscCall(WorstCell(fault));
  PetscCall(SlipFaultDestroy(&fault));
  if (!rank) (void)remove(file);
  return PETSC_SUCCESS;
}

static PetscErrorCode Test(void)
{
  PetscCall(Run());
  return GiveField();
}

SLIP_RANKS(Test)
