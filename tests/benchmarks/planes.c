static const char help[] =
  "Hierarchical K and Kn of two conjugate planes that are cut where they cross, so that cells touch there: times of "
  "assembly\n"
  "and of both products, memory, and errors of uniform slip against direct sums in some rows.\n"
  "  mpirun -n 2 planes -bench_n 8000 -bench_tolerance 1e-6\n"
  "  mpirun -n 2 planes -bench_n 16000 -bench_triangles\n"
  "  mpirun -n 2 planes -bench_n 16000 -bench_triangles -bench_vectors\n"
  "Prints one \"name value\" a line, in SI units.\n\n";

#include "../objects.h"
#include "cells.h"
#include <petsctime.h>
#include <time.h>

#define SIDE 100.0 /* of a cell [m] */
#define TOP 1000.0 /* depth of the upper edges [m] */
#define DIP 60.0
#define PRODUCTS 20
#define AT_ONCE 64 /* pairs of a direct sum */

/* Columns [8][n] of about wanted cells, five along strike for four along dip: strike 0 and, the other way down, 180. */
static PetscErrorCode CreateCells(PetscInt wanted, SlipCells *cells)
{
  const PetscInt nz = 2 * PetscMax(1, (PetscInt)(0.5 * PetscSqrtReal((PetscReal)wanted / 2.5) + 0.5));
  const PetscInt nx = PetscMax(1, wanted / (2 * nz)), n = 2 * nx * nz;
  PetscReal *column[8];

  PetscCall(PetscMalloc1(8 * (size_t)n, &column[0]));
  for (PetscInt k = 1; k < 8; k++) column[k] = column[k - 1] + n;
  for (PetscInt e = 0; e < n; e++) {
    const PetscInt plane = e / (nx * nz), i = e % nx, j = e / nx % nz;
    const PetscReal down = SIDE * ((PetscReal)j + 0.5), across = (down - 0.5 * SIDE * (PetscReal)nz) * 0.5;
    const PetscReal value[8] = {SIDE * ((PetscReal)i + 0.5),
                                plane ? -across : across,
                                TOP + down * PetscSqrtReal(0.75),
                                SIDE,
                                SIDE,
                                plane ? 180 : 0,
                                DIP,
                                plane ? 100 : 60};

    for (PetscInt k = 0; k < 8; k++) column[k][e] = value[k];
  }
  *cells = DippingCellsOfColumns(n, column[0]);
  return PETSC_SUCCESS;
}

/* Each square as two triangles, in the place of cells */
static PetscErrorCode CutCells(SlipCells *cells)
{
  const SlipCells squares = *cells;
  PetscReal *column = (PetscReal *)cells->x, *data;

  PetscCall(PetscMalloc1(2 * TRIANGLE_COLUMNS * (size_t)squares.n, &data));
  *cells = TrianglesOf(&squares, data);
  return PetscFree(column);
}

/* The kernel of rakes or of vectors, which has pairs at once */
static const SlipKernelType *TypeOf(PetscBool triangles, PetscBool vectors)
{
  if (vectors) return triangles ? &SlipKernelTriangleVector : &SlipKernelDippingVector;
  return triangles ? &SlipKernelTriangle : &SlipKernelDipping;
}

/* Blocks of pairs, at once where the kernel can */
static void Blocks(const SlipKernel *kernel, PetscInt size, PetscInt count, const SlipCell receiver[],
                   const SlipCell source[], PetscReal block[])
{
  if (kernel->type->centres)
    (*kernel->type->centres)(kernel, count, receiver, source, block);
  else
    for (PetscInt k = 0; k < count; k++) SlipKernelBlock(kernel, &receiver[k], &source[k], block + size * k);
}

/* K u, of each component, and Kn u on cell i of slip by 1 m along each component; all cells have one area */
static void DirectSum(const SlipCells *c, PetscInt i, PetscReal sum[3])
{
  const PetscInt n = c->kernel.type->components, size = (n + 1) * n;
  SlipCell own[AT_ONCE], other[AT_ONCE];
  PetscReal here[6 * AT_ONCE], there[6 * AT_ONCE];

  for (PetscInt k = 0; k <= n; k++) sum[k] = 0;
  for (PetscInt k = 0; k < AT_ONCE; k++) own[k] = CellOf(c, i);
  for (PetscInt first = 0; first < c->n; first += AT_ONCE) {
    const PetscInt count = PetscMin(AT_ONCE, c->n - first);

    for (PetscInt k = 0; k < count; k++) other[k] = CellOf(c, first + k);
    Blocks(&c->kernel, size, count, own, other, here);
    Blocks(&c->kernel, size, count, other, own, there);
    for (PetscInt k = 0; k < count; k++)
      for (PetscInt l = 0; l < n; l++) {
        for (PetscInt m = 0; m < n; m++) sum[m] += 0.5 * (here[size * k + m * n + l] + there[size * k + l * n + m]);
        sum[n] += here[size * k + n * n + l];
      }
  }
}

/* Root mean square over the rows, relative; and the largest over that of the sums. Collective. */
static PetscErrorCode Errors(MPI_Comm comm, const SlipCells *c, PetscInt rows, Vec f, Vec n)
{
  static const char *const name[2] = {"k", "kn"};
  const PetscInt stride = PetscMax(1, c->n / rows), components = c->kernel.type->components;
  const PetscReal *a[2];
  PetscReal sums[5] = {0, 0, 0, 0, 0}, worst[2] = {0, 0};
  PetscInt start, end;

  PetscCall(VecGetOwnershipRange(n, &start, &end));
  a[0] = VecRead(f);
  a[1] = VecRead(n);
  for (PetscInt i = start; i < end; i++) {
    const PetscInt e = c->order ? c->order[i] : i;
    PetscReal want[3];

    if (e % stride != stride / 2) continue;
    DirectSum(c, e, want);
    sums[4]++;
    for (PetscInt m = 0; m <= components; m++) {
      const PetscInt k = m == components;
      const PetscReal error = (k ? a[1][i - start] : a[0][(i - start) * components + m]) - want[m];

      sums[k] += error * error;
      sums[2 + k] += want[m] * want[m];
      worst[k] = PetscMax(worst[k], PetscAbsReal(error));
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 5, MPIU_REAL, MPIU_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, worst, 2, MPIU_REAL, MPIU_MAX, comm));
  PetscCall(PetscPrintf(comm, "rows %g\n", (double)sums[4]));
  for (int k = 0; k < 2; k++)
    PetscCall(PetscPrintf(comm, "error_%s %.3g\nlargest_error_%s %.3g\n", name[k],
                          (double)PetscSqrtReal(sums[k] / sums[2 + k]), name[k],
                          (double)(worst[k] / PetscSqrtReal(sums[2 + k] / sums[4]))));
  return PETSC_SUCCESS;
}

/* Numbers of a product that do not depend on who owns which cell */
static PetscErrorCode Print(MPI_Comm comm, const char name[], const SlipCells *c, Vec x)
{
  const PetscReal *a;
  PetscReal sum[2] = {0, 0};
  PetscInt start, end, rows;

  PetscCall(VecGetOwnershipRange(x, &start, &end));
  PetscCall(VecGetSize(x, &rows));
  rows /= c->n;
  a = VecRead(x);
  for (PetscInt i = start; i < end; i++) {
    sum[0] += a[i - start] * PetscSinReal((PetscReal)(rows * c->order[i / rows] + i % rows));
    sum[1] += a[i - start] * a[i - start];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, comm));
  return PetscPrintf(comm, "%s_sum %.12g\n%s_norm %.12g\n", name, (double)(sum[0] / PetscSqrtReal(sum[1])), name,
                     (double)PetscSqrtReal(sum[1]));
}

static PetscErrorCode Run(MPI_Comm comm)
{
  PetscInt n = 8000, rows = 200, *order;
  PetscReal tolerance = 1e-4, most[2], all[2], *column;
  PetscLogDouble begin, cut, first, second, end, least = PETSC_MAX_REAL, own = PETSC_MAX_REAL, cpu, resident;
  SlipCells cells;
  Vec u, f, c;
  SlipKernelType singly;
  PetscBool one = PETSC_FALSE, triangles = PETSC_FALSE, vectors = PETSC_FALSE;
  Mat K, Kn;

  PetscOptionsBegin(comm, NULL, "Benchmark of planes", "");
  PetscCall(PetscOptionsInt("-bench_n", "Cells", "", n, &n, NULL));
  PetscCall(PetscOptionsInt("-bench_rows", "Rows that are compared with direct sums", "", rows, &rows, NULL));
  PetscCall(PetscOptionsReal("-bench_tolerance", "Of hierarchical storage", "", tolerance, &tolerance, NULL));
  PetscCall(PetscOptionsBool("-bench_singly", "Take entries one by one", "", one, &one, NULL));
  PetscCall(PetscOptionsBool("-bench_triangles", "Cut each square in two", "", triangles, &triangles, NULL));
  PetscCall(PetscOptionsBool("-bench_vectors", "Slip as a vector", "", vectors, &vectors, NULL));
  PetscOptionsEnd();
  PetscCall(CreateCells(triangles ? n / 2 : n, &cells));
  if (triangles) PetscCall(CutCells(&cells));
  cells.kernel.type = TypeOf(triangles, vectors);
  singly = *cells.kernel.type;
  singly.centres = NULL;
  if (one) cells.kernel.type = &singly;
  PetscCall(PetscTime(&begin));
  PetscCall(SlipCellsPartition(comm, &cells, "hmat", NULL, &order, &cells.nlocal));
  cells.order = order;
  PetscCall(PetscTime(&cut));
  if (vectors) { /* all time counts as that of K */
    PetscCall(MatCreateSlipCellVectorStiffness(comm, &cells, "hmat", tolerance, &K, &Kn));
  } else
    PetscCall(MatCreateSlipCellStiffness(comm, &cells, "hmat", tolerance, &K));
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(PetscTime(&first));
  if (!vectors) PetscCall(MatCreateSlipCellNormalStiffness(comm, &cells, "hmat", tolerance, &Kn));
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(PetscTime(&second));
  cpu = (PetscLogDouble)clock() / CLOCKS_PER_SEC;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cpu, 1, MPI_DOUBLE, MPI_MAX, comm));
  PetscCall(PetscPrintf(
    comm, "cells %" PetscInt_FMT "\npartition %.3g\nassembly_k %.4g\nassembly_kn %.4g\nprocessor_time %.4g\n", cells.n,
    cut - begin, first - cut, second - first, cpu));
  PetscCall(MatCreateVecs(K, &u, &f));
  PetscCall(MatCreateVecs(Kn, NULL, &c));
  PetscCall(VecSet(u, 1));
  PetscCall(MatSlipStiffnessMultBoth(K, Kn, u, f, c));
  for (int k = 0; k < PRODUCTS; k++) { /* the least, as other programs may run */
    PetscLogDouble start;

    PetscCallMPI(MPI_Barrier(comm));
    PetscCall(PetscTime(&begin));
    start = (PetscLogDouble)clock() / CLOCKS_PER_SEC;
    PetscCall(MatSlipStiffnessMultBoth(K, Kn, u, f, c));
    own = PetscMin(own, (PetscLogDouble)clock() / CLOCKS_PER_SEC - start);
    PetscCallMPI(MPI_Barrier(comm));
    PetscCall(PetscTime(&end));
    least = PetscMin(least, end - begin);
  }
  PetscCall(MatSlipGetMemory(K, &most[0], &all[0]));
  PetscCall(MatSlipGetMemory(Kn, &most[1], &all[1]));
  PetscCall(PetscMemoryGetCurrentUsage(&resident));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &resident, 1, MPI_DOUBLE, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_DOUBLE, MPI_MAX, comm));
  PetscCall(
    PetscPrintf(comm, "products %.4g\nproducts_processor_time %.4g\nmemory_k %.4g\nmemory_kn %.4g\nresident_all %.4g\n",
                least, own, (double)all[0], (double)all[1], resident));
  PetscCall(MatView(K, PETSC_VIEWER_STDOUT_(comm)));
  PetscCall(MatView(Kn, PETSC_VIEWER_STDOUT_(comm)));
  PetscCall(Print(comm, "k", &cells, f));
  PetscCall(Print(comm, "kn", &cells, c));
  if (rows > 0) PetscCall(Errors(comm, &cells, rows, f, c));
  PetscCall(DestroyObjects(&u, &f, &c, &K, &Kn));
  PetscCall(PetscFree(order));
  column = (PetscReal *)cells.x;
  return PetscFree(column);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipErrorHandlerPush("planes"));
  PetscCall(Run(PETSC_COMM_WORLD));
  return PetscFinalize();
}
