static const char help[] =
  "One operator of the 3 km fault on n x n cells: time of set-up and of a product, memory, or iterations of CG.\n"
  "  mpirun -n 2 operators -bench_kind k_fft -bench_n 100\n"
  "Prints one \"name value\" a line, in SI units. tests/benchmarks/run.sh runs it for many sizes.\n\n";

#include "../objects.h"
#include <petscksp.h>
#include <petsctime.h>
#include <math.h>
#include <stdlib.h>
#include <stdio.h>

#define LENGTH 3000.0    /* [m], also the mobilised thickness */
#define MODULUS 30e9     /* [Pa] */
#define DENSITY 2500.0   /* [kg/m^3] */
#define ZETA (0.8 / 3)   /* damping ratio */
#define SAMPLES 400      /* products timed at most, */
#define SAMPLES_MIN 3    /* at least */
#define SAMPLES_TIME 0.5 /* and about so long [s] */
#define TOLERANCE 1e-8   /* of CG */

typedef struct {
  MPI_Comm comm;
  PetscInt n;
  PetscReal mass, tstar, step; /* [kg/m^2], [s], length of a time step in T* */
  Mat K, H, B, A;              /* A: the operator that is timed, one of the others */
  PC pc;                       /* or this */
} Bench;

/* ---- what is timed, and what it needs ---- */

static PetscErrorCode CreateGridStiffness(Bench *b, const char type[])
{
  const SlipGrid grid = {b->n,   b->n, LENGTH,
                         LENGTH, 0,    {&SlipKernelStrikeSlip, MODULUS, 0.25, PETSC_FALSE, SLIP_AVERAGE_CENTRE, NULL}};

  PetscCall(MatCreateSlipStiffness(b->comm, &grid, type, &b->K));
  PetscCall(MatSlipStiffnessSetFromOptions(b->K));
  b->A = b->K;
  return PETSC_SUCCESS;
}

static PetscErrorCode CreateCellStiffness(Bench *b, const char type[])
{
  const PetscInt N = b->n * b->n;
  const PetscReal side = LENGTH / (PetscReal)b->n;
  SlipCells cells = {.n = N,
                     .kernel = {.type = &SlipKernelStrikeSlip, .shear_modulus = MODULUS, .poisson_ratio = 0.25}};
  PetscReal *x, *y, *z, *a;

  PetscCall(PetscMalloc4(N, &x, N, &y, N, &z, N, &a));
  for (PetscInt e = 0; e < N; e++) {
    x[e] = ((PetscReal)(e % b->n) + 0.5) * side;
    y[e] = 0;
    z[e] = ((PetscReal)(e / b->n) + 0.5) * side;
    a[e] = side;
  }
  cells.x = x;
  cells.y = y;
  cells.z = z;
  cells.length = cells.width = a;
  PetscCall(MatCreateSlipCellStiffness(b->comm, &cells, "hmat", 1e-8, &b->K));
  PetscCall(PetscFree4(x, y, z, a));
  b->A = b->K;
  return PETSC_SUCCESS;
}

/* One product, so that what K prepares in its first is not counted as H's. */
static PetscErrorCode CreateWarmStiffness(Bench *b)
{
  Vec x, y;

  PetscCall(CreateGridStiffness(b, "fft"));
  PetscCall(MatCreateVecs(b->K, &x, &y));
  PetscCall(VecSet(x, 1));
  PetscCall(MatMult(b->K, x, y));
  return DestroyObjects(&x, &y);
}

static PetscErrorCode CreateStage(Bench *b)
{
  PetscCall(CreateWarmStiffness(b));
  PetscCall(MatCreateSlipViscosity(b->K, b->mass, ZETA, "sqrtm", &b->H));
  PetscCall(MatCreateSlipStage(b->K, b->H, b->mass, &b->B));
  return MatSlipStageSetFromOptions(b->B);
}

/* The stage operator at T*, which its preconditioner needs */
static PetscErrorCode CreateStageAtTstar(Bench *b)
{
  PetscCall(CreateStage(b));
  return MatSlipStageSetTheta(b->B, b->tstar);
}

static PetscErrorCode Viscosity(Bench *b, const char type[])
{
  PetscCall(MatCreateSlipViscosity(b->K, b->mass, ZETA, type, &b->H));
  b->A = b->H;
  return PETSC_SUCCESS;
}

static PetscErrorCode Stage(Bench *b, const char type[])
{
  PetscCall(MatSlipStageSetTheta(b->B, b->tstar));
  b->A = b->B;
  return PETSC_SUCCESS;
}

static PetscErrorCode Preconditioner(Bench *b, const char type[])
{
  PetscCall(PCCreate(b->comm, &b->pc));
  PetscCall(PCSetType(b->pc, type));
  PetscCall(PCSetOperators(b->pc, b->B, b->B));
  return PCSetUp(b->pc);
}

/* One row per operator: what is made before, and what is timed. */
static const struct {
  const char *name;
  PetscErrorCode (*prepare)(Bench *);
  PetscErrorCode (*create)(Bench *, const char type[]);
  const char *type;
} Kinds[] = {
  {"k_dense", NULL, CreateGridStiffness, "dense"},
  {"k_fft", NULL, CreateGridStiffness, "fft"},
  {"k_hmat", NULL, CreateCellStiffness, ""},
  {"h_sqrtm", CreateWarmStiffness, Viscosity, "sqrtm"},
  {"h_spectral", CreateWarmStiffness, Viscosity, "spectral"},
  {"h_lanczos", CreateWarmStiffness, Viscosity, "lanczos"},
  {"b", CreateStage, Stage, ""},
  {"pc", CreateStageAtTstar, Preconditioner, PCSLIPSTAGE},
};

/* ---- measuring ---- */

/* In (-1, 1), of the cell and the draw only, not of the rank */
static PetscReal Noise(PetscInt cell, PetscInt draw)
{
  const PetscReal noise = 43758.5453 * sin(12.9898 * (double)(cell + 1) + 78.233 * (double)draw);

  return 2 * (noise - floor(noise)) - 1;
}

/* 1 on the cells of n x n that slide: an ellipse in the middle, about 60 % of the fault */
static PetscReal Slides(PetscInt cell, PetscInt n)
{
  const PetscReal x = ((PetscReal)(cell % n) + 0.5) / (PetscReal)n - 0.5;
  const PetscReal z = ((PetscReal)(cell / n) + 0.5) / (PetscReal)n - 0.5;

  return x * x + z * z < 0.19 ? 1 : 0;
}

static PetscErrorCode Fill(PetscReal (*value)(PetscInt cell, PetscInt k), PetscInt k, Vec x)
{
  PetscInt start, end;
  PetscReal *a;

  PetscCall(VecGetOwnershipRange(x, &start, &end));
  PetscCall(VecGetArrayWrite(x, &a));
  for (PetscInt i = start; i < end; i++) a[i - start] = value(i, k);
  return VecRestoreArrayWrite(x, &a);
}

static PetscErrorCode Apply(Bench *b, Vec x, Vec y, PetscLogDouble *seconds)
{
  PetscLogDouble begin, end;

  PetscCallMPI(MPI_Barrier(b->comm));
  PetscCall(PetscTime(&begin));
  if (b->pc)
    PetscCall(PCApply(b->pc, x, y));
  else
    PetscCall(MatMult(b->A, x, y));
  PetscCallMPI(MPI_Barrier(b->comm));
  PetscCall(PetscTime(&end));
  *seconds = end - begin;
  return PETSC_SUCCESS;
}

static int Compare(const void *a, const void *b)
{
  const PetscLogDouble x = *(const PetscLogDouble *)a, y = *(const PetscLogDouble *)b;

  return x < y ? -1 : x > y;
}

/* The first product, and the median of many, each with another vector: some viscosities remember those they have
   met. */
static PetscErrorCode TimeProducts(Bench *b, PetscLogDouble *first, PetscLogDouble *median)
{
  PetscLogDouble sample[SAMPLES], sum = 0;
  PetscInt count = 0;
  PetscMPIInt more = 1;
  Vec x, y;

  PetscCall(MatCreateVecs(b->K, &x, &y));
  PetscCall(Fill(Noise, 0, x));
  PetscCall(Apply(b, x, y, first));
  while (more) {
    PetscCall(Fill(Noise, count + 1, x));
    PetscCall(Apply(b, x, y, &sample[count]));
    sum += sample[count++];
    more = count < SAMPLES && (count < SAMPLES_MIN || sum < SAMPLES_TIME);
    PetscCallMPI(MPI_Bcast(&more, 1, MPI_INT, 0, b->comm)); /* clocks differ */
  }
  qsort(sample, (size_t)count, sizeof(sample[0]), Compare);
  *median = sample[count / 2];
  return DestroyObjects(&x, &y);
}

/* Largest memory of this process so far [bytes]: Linux knows, and counts from exec() on; elsewhere that of now. */
static PetscErrorCode PeakMemory(PetscReal *bytes)
{
  FILE *f = fopen("/proc/self/status", "r");
  char line[256];
  double kilobytes = 0;
  PetscLogDouble now;

  while (f && fgets(line, sizeof(line), f))
    if (sscanf(line, "VmHWM: %lf", &kilobytes) == 1) break;
  if (f) fclose(f);
  PetscCall(PetscMemoryGetCurrentUsage(&now));
  *bytes = kilobytes > 0 ? 1024 * kilobytes : (PetscReal)now;
  return PETSC_SUCCESS;
}

/* Memory of the operator, and the largest ever of a process. */
static PetscErrorCode PrintMemory(Bench *b)
{
  PetscReal most = 0, all = 0, bytes, resident;
  PetscErrorCode (*memory)(PC, PetscReal *) = NULL;

  if (b->pc) {
    PetscCall(PetscObjectQueryFunction((PetscObject)b->pc, "PCSlipGetMemory_C", &memory));
    if (memory) {
      PetscCall((*memory)(b->pc, &bytes));
      PetscCallMPI(MPI_Allreduce(&bytes, &most, 1, MPIU_REAL, MPIU_MAX, b->comm));
      PetscCallMPI(MPI_Allreduce(&bytes, &all, 1, MPIU_REAL, MPIU_SUM, b->comm));
    } else
      most = all = -1;
  } else if (b->A)
    PetscCall(MatSlipGetMemory(b->A, &most, &all));
  if (b->A || b->pc) PetscCall(PetscPrintf(b->comm, "memory %.17g\nmemory_all %.17g\n", (double)most, (double)all));
  PetscCall(PeakMemory(&resident));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &resident, 1, MPIU_REAL, MPIU_MAX, b->comm));
  return PetscPrintf(b->comm, "resident %.17g\n", (double)resident);
}

static PetscErrorCode RunOperator(Bench *b, const char kind[])
{
  PetscLogDouble begin, end, first = 0, median = 0;
  PetscBool same = PETSC_FALSE;
  size_t k = 0;

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(Kinds) && !same; i++) {
    k = i;
    PetscCall(PetscStrcmp(kind, Kinds[k].name, &same));
  }
  PetscCheck(same, b->comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "-bench_kind is \"%s\", expected k_dense, k_fft, k_hmat, h_sqrtm, h_spectral, h_lanczos, b, pc or cg",
             kind);
  if (Kinds[k].prepare) PetscCall((*Kinds[k].prepare)(b));
  PetscCallMPI(MPI_Barrier(b->comm));
  PetscCall(PetscTime(&begin));
  PetscCall((*Kinds[k].create)(b, Kinds[k].type));
  PetscCallMPI(MPI_Barrier(b->comm));
  PetscCall(PetscTime(&end));
  PetscCall(TimeProducts(b, &first, &median));
  return PetscPrintf(b->comm, "setup %.6g\nproduct %.6g\n", end - begin + PetscMax(first - median, 0), median);
}

/* Iterations of preconditioned CG for the Jacobian of a step's second stage (theta = h/3), without weakening. */
static PetscErrorCode RunCG(Bench *b)
{
  Vec mask, slope, rhs, x;
  Mat J;
  KSP ksp;
  PC pc;
  PetscInt iterations;
  KSPConvergedReason reason;
  PetscLogDouble begin, end;

  PetscCall(CreateStage(b));
  PetscCall(MatSlipStageSetTheta(b->B, b->step * b->tstar / 3));
  PetscCall(MatCreateVecs(b->K, &x, &rhs));
  PetscCall(DuplicateVecs(x, &mask, &slope));
  PetscCall(VecZeroEntries(slope));
  PetscCall(Fill(Slides, b->n, mask));
  PetscCall(Fill(Noise, 0, rhs));
  PetscCall(VecPointwiseMult(rhs, rhs, mask));
  PetscCall(MatCreateSlipJacobian(b->B, &J));
  PetscCall(MatSlipJacobianSetParts(J, b->B, mask, slope));
  PetscCall(KSPCreate(b->comm, &ksp));
  PetscCall(KSPSetOperators(ksp, J, J));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCSLIPSTAGE));
  PetscCall(KSPSetTolerances(ksp, TOLERANCE, 0, 1e10, 10000));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(KSPSetUp(ksp));
  PetscCall(PetscTime(&begin));
  PetscCall(KSPSolve(ksp, rhs, x));
  PetscCall(PetscTime(&end));
  PetscCall(KSPGetIterationNumber(ksp, &iterations));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCheck(reason > 0, b->comm, PETSC_ERR_NOT_CONVERGED, "CG ended as %s after %" PetscInt_FMT " iterations",
             KSPConvergedReasons[reason], iterations);
  PetscCall(PetscPrintf(b->comm, "iterations %" PetscInt_FMT "\nsolve %.6g\n", iterations, end - begin));
  return DestroyObjects(&ksp, &J, &mask, &slope, &rhs, &x);
}

static PetscErrorCode Run(void)
{
  Bench b = {
    .comm = PETSC_COMM_WORLD, .n = 50, .mass = DENSITY * LENGTH, .tstar = LENGTH * sqrt(DENSITY / MODULUS), .step = 1};
  char kind[32] = "k_fft";
  PetscBool cg;

  PetscOptionsBegin(b.comm, NULL, "Benchmark of operators", "");
  PetscCall(PetscOptionsString("-bench_kind", "k_dense, k_fft, k_hmat, h_sqrtm, h_spectral, h_lanczos, b, pc or cg", "",
                               kind, kind, sizeof(kind), NULL));
  PetscCall(PetscOptionsInt("-bench_n", "Cells along strike and in depth", "", b.n, &b.n, NULL));
  PetscCall(PetscOptionsReal("-bench_step", "Length of a time step for cg [T*]", "", b.step, &b.step, NULL));
  PetscOptionsEnd();
  PetscCheck(b.n > 0 && b.step > 0, b.comm, PETSC_ERR_ARG_OUTOFRANGE, "-bench_n and -bench_step must be positive");
  PetscCall(PetscStrcmp(kind, "cg", &cg));
  if (cg)
    PetscCall(RunCG(&b));
  else
    PetscCall(RunOperator(&b, kind));
  PetscCall(PrintMemory(&b));
  PetscCall(PCDestroy(&b.pc));
  return DestroyObjects(&b.B, &b.H, &b.K);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipErrorHandlerPush("operators"));
  PetscCall(Run());
  return PetscFinalize();
}
