/*
  Stiffness of a uniform grid by transforms both along strike and in depth, O(N log N), on any number of ranks.

  Where s = z + z' is the sum of two depths, the surface part of the symmetrised kernel is A(s) - z z' q(s), by
  SlipKernelType.surface(), and the full space's T depends on z - z' only. Multiplication by z commutes with transforms
  along strike, so that each wavenumber needs two transforms in depth, of u and of z u, and two backward ones:

     y^(k) = T^(k) u^(k) + A^(k) u^(-k),   w^(k) = q^(k) (z u)^(-k),   K u = y - z w.

  Ranks have rows of cells for the transforms along strike and wavenumbers for those in depth, with a transpose between
  them (transposed_fft.c). All rows and all wavenumbers are transformed in the same way (lanes.c), so that results do
  not depend on the number of ranks.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <stdlib.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipwork.h>

/* Computes the three kernels at all distances along strike for depth index r (z - z' = r b, s = 2 top + (r + 1) b). */
static void KernelRow(const SlipGrid *g, PetscInt r, PetscInt nk, PetscReal row[])
{
  const SlipKernel *kernel = &g->kernel;
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  const PetscReal s = 2 * g->depth_top + (PetscReal)(r + 1) * b;
  const PetscBool even = SlipKernelIs(kernel, SLIP_EVEN_DEPTH);

  SlipWorkAdd(SLIP_WORK_KERNEL, (PetscReal)nk);
  for (PetscInt d = 0; d < nk; d++) {
    const PetscReal dx = (PetscReal)d * a;

    row[3 * d] = r < g->nz ? SlipKernelDirect(kernel, dx, (PetscReal)r * b, a, b) : 0;
    row[3 * d + 1] = row[3 * d + 2] = 0;
    if (!even) kernel->type->surface(kernel, dx, s, a, b, row + 3 * d + 1);
  }
}

/* Computes the kernels of this rank's depths, transforms them by cosines along strike, and transposes them to its
   wavenumbers. */
static PetscErrorCode KernelsByWave(SlipToeplitz p, MPI_Comm comm, PetscReal **kernels)
{
  const PetscInt nk = p->period / 2 + 1, depths = 2 * p->grid.nz - 1;
  const SlipLayout l = SlipLayoutOf(comm, depths, nk, 3);
  const int length = (int)nk;
  const fftw_r2r_kind kind = FFTW_REDFT00;
  PetscReal *rows;
  fftw_plan cosine;

  PetscFunctionBegin;
  PetscCall(SlipAllocate(l.size, &rows));
  PetscCall(SlipAllocate(l.size, kernels));
  cosine = fftw_plan_many_r2r(1, &length, 3, rows, NULL, 3, 1, rows, NULL, 3, 1, &kind, FFTW_ESTIMATE | FFTW_UNALIGNED);
  PetscCheck(cosine, comm, PETSC_ERR_LIB, "FFTW cannot plan a cosine transform of length %d", length);
  for (PetscInt r = 0; r < l.rows; r++) {
    PetscReal *row = rows + (size_t)r * 3 * nk;

    KernelRow(&p->grid, l.row_start + r, nk, row);
    fftw_execute_r2r(cosine, row, row);
  }
  PetscCall(SlipTranspose(comm, depths, nk, 3, rows, *kernels));
  fftw_destroy_plan(cosine);
  fftw_free(rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the reals of the symbol of T: SLIP_LANES wavenumbers are side by side, and the last lanes may be unused. */
size_t SlipToeplitzSymbolSize(SlipToeplitz p)
{
  const PetscInt groups = (p->pencil->layout.columns + SLIP_LANES - 1) / SLIP_LANES;

  return (size_t)groups * SLIP_LANES * (p->depth_period / 2 + 1);
}

/* Returns the place of number i of wavenumber k. */
static size_t SymbolAt(SlipToeplitz p, PetscInt k, PetscInt i)
{
  return ((size_t)(k / SLIP_LANES) * (p->depth_period / 2 + 1) + i) * SLIP_LANES + k % SLIP_LANES;
}

/* Returns the same for a complex symbol, whose imaginary part is SLIP_LANES later. */
static size_t ComplexAt(SlipToeplitz p, PetscInt k, PetscInt i)
{
  return 2 * SymbolAt(p, k, i) - k % SLIP_LANES;
}

/* Gets the symbol at local wavenumber k along strike and i <= depth_period / 2 in depth: a real number of part 0,
   toeplitz, a complex one of part 1, hankel, and of part 2, product. */
void SlipToeplitzSymbolOf(SlipToeplitz p, const SlipToeplitzSymbol *s, PetscInt part, PetscInt k, PetscInt i,
                          PetscReal number[])
{
  const PetscReal *parts[] = {s->toeplitz, s->hankel, s->product};
  const size_t at = part ? ComplexAt(p, k, i) : SymbolAt(p, k, i);

  for (PetscInt c = 0; c < (part ? 2 : 1); c++) number[c] = parts[part][at + (size_t)(c * SLIP_LANES)];
}

/* Allocates the first 1 to 3 parts of a symbol: toeplitz, hankel, product. */
PetscErrorCode SlipToeplitzAllocate(SlipToeplitz p, PetscInt parts, SlipToeplitzSymbol *s)
{
  const size_t size = SlipToeplitzSymbolSize(p);

  PetscFunctionBegin;
  PetscCall(SlipAllocate(size, &s->toeplitz));
  if (parts > 1) PetscCall(SlipAllocate(2 * size, &s->hankel));
  if (parts > 2) PetscCall(SlipAllocate(2 * size, &s->product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipToeplitzSymbolDestroy(SlipToeplitzSymbol *s)
{
  PetscFunctionBegin;
  fftw_free(s->toeplitz);
  fftw_free(s->hankel);
  fftw_free(s->product);
  if (s->there_free) PetscCall((*s->there_free)(s));
  *s = (SlipToeplitzSymbol){NULL};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets a symbol to the transforms in depth of the kernels [local nk][2 nz - 1][stride], the first of which is even. */
PetscErrorCode SlipToeplitzSetSymbol(SlipToeplitz p, PetscInt stride, PetscInt parts, const PetscReal kernels[],
                                     SlipToeplitzSymbol *s)
{
  const PetscInt nz = p->grid.nz, P = p->depth_period, h = P / 2 + 1, local = p->pencil->layout.columns;
  PetscReal *line, *out;
  fftw_plan plan;

  PetscFunctionBegin;
  PetscCall(SlipToeplitzAllocate(p, parts, s));
  PetscCall(SlipAllocate(P, &line));
  PetscCall(SlipAllocate((size_t)2 * h, &out));
  plan = fftw_plan_dft_r2c_1d((int)P, line, (fftw_complex *)out, FFTW_ESTIMATE);
  PetscCheck(plan, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a transform of length %" PetscInt_FMT, P);
  for (PetscInt k = 0; k < local; k++)
    for (PetscInt part = 0; part < parts; part++) {
      const PetscReal *kernel = kernels + (size_t)k * stride * (2 * nz - 1) + part;
      PetscReal *complex_symbol = part == 1 ? s->hankel : s->product;

      for (PetscInt i = 0; i < P; i++) line[i] = 0;
      for (PetscInt i = 0; i < (part ? 2 * nz - 1 : nz); i++) line[i] = kernel[stride * i];
      for (PetscInt i = 1; i < nz && !part; i++) line[P - i] = kernel[stride * i];
      fftw_execute(plan);
      for (PetscInt i = 0; i < h && part; i++)
        for (int c = 0; c < 2; c++) complex_symbol[ComplexAt(p, k, i) + c * SLIP_LANES] = out[2 * i + c];
      for (PetscInt i = 0; i < h && !part; i++) s->toeplitz[SymbolAt(p, k, i)] = out[2 * i];
    }
  fftw_destroy_plan(plan);
  fftw_free(line);
  fftw_free(out);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Plans transforms out of place, which take two thirds of the time in place (1024 complex numbers, measured). */
static PetscErrorCode Plan(SlipToeplitz p)
{
  const int Q = (int)p->depth_period;
  fftw_complex *column, *waves;

  PetscFunctionBegin;
  PetscCall(SlipAllocate((size_t)8 * Q, &p->column));
  column = (fftw_complex *)p->column;
  waves = column + 2 * Q;
  for (int i = 0; i < 2; i++) {
    p->depth[i] = fftw_plan_many_dft(1, &Q, i + 1, column, NULL, 1, Q, waves, NULL, 1, Q, FFTW_FORWARD, FFTW_ESTIMATE);
    p->depth_back[i] =
      fftw_plan_many_dft(1, &Q, i + 1, waves, NULL, 1, Q, column, NULL, 1, Q, FFTW_BACKWARD, FFTW_ESTIMATE);
    PetscCheck(p->depth[i] && p->depth_back[i], PETSC_COMM_SELF, PETSC_ERR_LIB,
               "FFTW cannot plan transforms of length %d", Q);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the scatter to the rows of cells that this rank transforms if K's vectors have another distribution. */
static PetscErrorCode CreateScatter(SlipToeplitz p, Mat K)
{
  const PetscInt nx = p->grid.nx, n = p->pencil->layout.rows * nx;
  PetscInt start, end;
  PetscBool same;
  IS from;
  Vec x;

  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(K, &start, &end));
  same = (PetscBool)(end - start == n && (n == 0 || start == p->pencil->layout.row_start * nx));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPIU_BOOL, MPI_LAND, PetscObjectComm((PetscObject)K)));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(K, &x, NULL));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &p->rows));
  PetscCall(ISCreateStride(PETSC_COMM_SELF, n, p->pencil->layout.row_start * nx, 1, &from));
  PetscCall(VecScatterCreate(x, from, p->rows, NULL, &p->scatter));
  PetscCall(ISDestroy(&from));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the engine with the distribution of K's vectors. Collective on K. */
static PetscErrorCode PlaneCreate(Mat K, const SlipGrid *grid, SlipToeplitz *plane)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const PetscReal b = grid->length_z / (PetscReal)grid->nz;
  SlipToeplitz p;
  PetscReal *kernels;

  PetscFunctionBegin;
  PetscCall(PetscNew(&p));
  p->grid = *grid;
  p->comm = comm;
  p->period = SlipGoodLength(2 * grid->nx - 1);
  p->depth_period = SlipGoodLength(2 * grid->nz - 1);
  PetscCall(SlipTransposedFFTCreate(comm, grid->nx, grid->nz, p->period, &p->pencil));
  PetscCall(KernelsByWave(p, comm, &kernels));
  PetscCall(
    SlipToeplitzSetSymbol(p, 3, SlipKernelIs(&p->grid.kernel, SLIP_EVEN_DEPTH) ? 1 : 3, kernels, &p->stiffness));
  fftw_free(kernels);
  PetscCall(PetscMalloc1(grid->nz, &p->z));
  for (PetscInt i = 0; i < grid->nz; i++) p->z[i] = grid->depth_top + ((PetscReal)i + 0.5) * b;
  PetscCall(SlipLanesFFTCreate(p->depth_period / 2, &p->lanes));
  for (int i = 0; i < 4; i++) PetscCall(SlipAllocateLines((size_t)SLIP_LANES * p->depth_period, &p->room[i]));
  PetscCall(CreateScatter(p, K));
  *plane = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PlaneDestroy(SlipContainerArg arg)
{
  SlipToeplitz p = (SlipToeplitz)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  for (int i = 0; i < 2; i++) {
    if (p->depth[i]) fftw_destroy_plan(p->depth[i]);
    if (p->depth_back[i]) fftw_destroy_plan(p->depth_back[i]);
  }
  fftw_free(p->column);
  for (int i = 0; i < 4; i++) free(p->room[i]);
  PetscCall(SlipLanesFFTDestroy(&p->lanes));
  if (p->device) PetscCall((*p->device_destroy)(&p->device));
  PetscCall(SlipToeplitzSymbolDestroy(&p->stiffness));
  if (p->root_destroy) PetscCall((*p->root_destroy)(p));
  PetscCall(SlipTransposedFFTDestroy(&p->pencil));
  PetscCall(VecScatterDestroy(&p->scatter));
  PetscCall(VecDestroy(&p->rows));
  PetscCall(PetscFree(p->z));
  PetscCall(PetscFree(p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal SymbolReals(const SlipToeplitzSymbol *s)
{
  return (PetscReal)((s->toeplitz ? 1 : 0) + (s->hankel ? 2 : 0) + (s->product ? 2 : 0));
}

PetscReal SlipToeplitzBytes(SlipToeplitz p)
{
  const PetscReal size = (PetscReal)SlipToeplitzSymbolSize(p), P = (PetscReal)p->depth_period;
  const PetscReal root = (PetscReal)p->pencil->layout.columns * (PetscReal)(p->length + 1);

  return (PetscReal)sizeof(PetscReal) * (size * (SymbolReals(&p->stiffness) + SymbolReals(&p->root)) +
                                         (p->symbol ? root : 0) + ((p->column ? 8 : 0) + 5 * SLIP_LANES) * P) +
         SlipTransposedFFTBytes(p->pencil);
}

/* Gets the engine of this grid for a stiffness, created at first use and composed with it. Collective. */
PetscErrorCode SlipToeplitzOfGrid(Mat K, const SlipGrid *grid, SlipToeplitz *plane)
{
  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipToeplitz", plane));
  if (*plane) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PlaneCreate(K, grid, plane));
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipToeplitz", *plane, PlaneDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the engine of the grid of K; NULL if K is not on a uniform grid. Collective. */
PetscErrorCode SlipToeplitzOf(Mat K, SlipToeplitz *plane)
{
  const SlipGrid *grid;

  PetscFunctionBegin;
  *plane = NULL;
  PetscCall(SlipGridOf(K, &grid));
  if (grid) PetscCall(SlipToeplitzOfGrid(K, grid, plane));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the symbol of the unscaled kernel [Pa/m]. */
const SlipToeplitzSymbol *SlipToeplitzStiffness(SlipToeplitz p)
{
  return &p->stiffness;
}

/* Computes u(k) = T u(k) + A(k) u(-k) in place, where A(-k) is the conjugate of A(k); T or A may be NULL, for 0. */
static void MultiplyPairs(PetscInt P, const PetscReal T[], const PetscReal A[], PetscReal u[])
{
  for (PetscInt k = 0; k <= P / 2; k++) {
    PetscReal *a = u + 2 * k, *b = u + 2 * (k ? P - k : 0);
    const PetscReal ar = a[0], ai = a[1], br = b[0], bi = b[1], t = T ? T[SLIP_LANES * k] : 0;
    const PetscReal r = A ? A[SLIP_NUMBER * k] : 0, i = A ? A[SLIP_NUMBER * k + SLIP_LANES] : 0;

    a[0] = t * ar + r * br - i * bi;
    a[1] = t * ai + r * bi + i * br;
    b[0] = t * br + r * ar + i * ai;
    b[1] = t * bi + r * ai - i * ar;
  }
}

/* Computes depth_period times the product at local wavenumber k: f [nz] complex, in place. It is for single wavenumbers
   and uses FFTW, because lanes.c would use one lane only. */
PetscErrorCode SlipToeplitzApplyWave(SlipToeplitz p, const SlipToeplitzSymbol *s, PetscInt k, PetscReal f[])
{
  const PetscInt nz = p->grid.nz, P = p->depth_period, last = s->product ? 1 : 0;
  PetscReal *u, *v, *u_waves, *v_waves;

  PetscFunctionBegin;
  if (!p->column) PetscCall(Plan(p));
  u = p->column;
  v = u + 2 * P;
  u_waves = v + 2 * P;
  v_waves = u_waves + 2 * P;
  for (PetscInt i = 0; i < 2 * nz; i++) u[i] = f[i];
  for (PetscInt i = 2 * nz; i < 2 * P; i++) u[i] = 0;
  for (PetscInt i = 0; i < 2 * P && s->product; i++) v[i] = i < 2 * nz ? p->z[i / 2] * f[i] : 0;
  fftw_execute(p->depth[last]);
  MultiplyPairs(P, s->toeplitz + SymbolAt(p, k, 0), s->hankel ? s->hankel + ComplexAt(p, k, 0) : NULL, u_waves);
  if (s->product) MultiplyPairs(P, NULL, s->product + ComplexAt(p, k, 0), v_waves);
  fftw_execute(p->depth_back[last]);
  for (PetscInt i = 0; i < 2 * nz; i++) f[i] = s->product ? u[i] - p->z[i / 2] * v[i] : u[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms this rank's rows of cells to its wavenumbers in the pencil. Collective. */
PetscErrorCode SlipToeplitzForward(SlipToeplitz p, Vec x)
{
  const PetscReal *px;

  PetscFunctionBegin;
  if (p->scatter) {
    PetscCall(VecScatterBegin(p->scatter, x, p->rows, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(p->scatter, x, p->rows, INSERT_VALUES, SCATTER_FORWARD));
    x = p->rows;
  }
  PetscCall(VecGetArrayRead(x, &px));
  PetscCall(SlipTransposedFFTForward(p->pencil, px));
  PetscCall(VecRestoreArrayRead(x, &px));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms backward, times factor. Collective. */
PetscErrorCode SlipToeplitzBackward(SlipToeplitz p, PetscReal factor, Vec y)
{
  PetscReal *py;

  PetscFunctionBegin;
  PetscCall(VecGetArrayWrite(p->scatter ? p->rows : y, &py));
  PetscCall(SlipTransposedFFTBackward(p->pencil, factor, py));
  PetscCall(VecRestoreArrayWrite(p->scatter ? p->rows : y, &py));
  if (p->scatter) {
    PetscCall(VecScatterBegin(p->scatter, p->rows, y, INSERT_VALUES, SCATTER_REVERSE));
    PetscCall(VecScatterEnd(p->scatter, p->rows, y, INSERT_VALUES, SCATTER_REVERSE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = scale * (operator of this symbol) x. Collective. */
PetscErrorCode SlipToeplitzApply(SlipToeplitz p, PetscReal scale, const SlipToeplitzSymbol *symbol, Vec x, Vec y)
{
  SlipTransposedFFT pencil = p->pencil;
  const PetscLogDouble P = (PetscLogDouble)p->period, Q = (PetscLogDouble)p->depth_period;
  const PetscLogDouble rows = (PetscLogDouble)p->pencil->layout.rows, waves = (PetscLogDouble)p->pencil->layout.columns;
  const PetscLogDouble fields = symbol->product ? 2 : 1;

  PetscFunctionBegin;
  PetscCall(SlipToeplitzForward(p, x));
  for (PetscInt k = 0; k < pencil->layout.columns; k += SLIP_LANES)
    SlipLanesMultiply(p->lanes, symbol, k / SLIP_LANES, p->grid.nz, p->z, p->room,
                      pencil->by_wave + (size_t)k * 2 * p->grid.nz);
  PetscCall(SlipToeplitzBackward(p, scale / (PetscReal)p->depth_period, y));
  /* real transforms along strike and complex ones in depth, both ways, and the symbols */
  PetscCall(
    SlipWorkFlops(SLIP_WORK_TRANSFORM, 5 * rows * P * PetscLog2Real(P) +
                                         waves * Q * (10 * fields * PetscLog2Real(Q) + (symbol->hankel ? 16 : 2))));
  PetscFunctionReturn(PETSC_SUCCESS);
}
