/*
  A uniform grid's operators along strike. K depends on x - x' only, so that it is the corner of a circulant of
  P >= 2 nx - 1 cells; an FFT along strike gives one real symmetric nz x nz block per wavenumber (the kernel is even in
  x). Functions of the blocks are the "spectral" operators, exact for K and approximate for sqrt(K) or an inverse.
*/
#include <slipstep/rooms/slipmat.h>
#include <petscblaslapack.h>
#include <fftw3.h>
#include <stdlib.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipwork.h>

struct _n_SlipCirculant {
  SlipGrid grid;
  MPI_Comm comm;            /* its ranks share the wavenumbers; PETSC_COMM_SELF if this process has all */
  PetscBool shared;         /* ranks share the wavenumbers */
  SlipTransposedFFT pencil; /* transforms on comm */
  PetscInt nk;              /* number of wavenumbers of this process */
  PetscInt period;          /* P, even, with small prime factors */
  PetscReal *symbol;        /* [nk][nz][nz], K per wavenumber, unscaled [Pa/m] */
  PetscReal *halves;        /* [nk] halves of its blocks, see SlipSymmetricHalf(); NULL before first use */
  PetscReal *vectors;       /* [nk][nz][nz], eigenvector i of block k is row i; NULL before first use */
  PetscReal *values;        /* [nk][nz], eigenvalues, with those below zero set to zero */
  PetscReal *column;        /* [4][nz], work of one wavenumber */
};

/* Cells in depth above which ranks share the work: measured on 2 ranks, shared products take 35 us instead of 55 us at
   100 x 40, and 28 us instead of 44 us at 100 x 32. */
#define SLIP_SHARE_MIN 30

/* Returns the smallest even length of at least n whose prime factors are 2, 3 and 5. */
PetscInt SlipGoodLength(PetscInt n)
{
  for (PetscInt length = PetscMax(2, n + n % 2);; length += 2) {
    PetscInt rest = length;

    for (PetscInt p = 2; p <= 5; p++)
      while (rest % p == 0) rest /= p;
    if (rest == 1) return length;
  }
}

/* Transforms by cosines over the leading index of a[nk][nz * nz] in place: kernel to symbol, and P times back. Plans
   are estimated and not measured, so that rounding is the same on all ranks and in all runs. */
static PetscErrorCode CosineTransform(PetscInt nk, PetscInt nz, PetscReal a[])
{
  const fftw_r2r_kind kind = FFTW_REDFT00;
  const int length = (int)nk;
  fftw_plan plan;
  int many;

  PetscFunctionBegin;
  PetscCheck((PetscInt64)nz * nz <= PETSC_MPI_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "FFTW's integers do not count blocks of %" PetscInt_FMT
             " cells in depth, expected at most 46340: take transforms",
             nz);
  many = (int)(nz * nz);
  plan = fftw_plan_many_r2r(1, &length, many, a, NULL, many, 1, a, NULL, many, 1, &kind, FFTW_ESTIMATE);
  PetscCheck(plan, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a cosine transform of length %d", length);
  fftw_execute(plan);
  fftw_destroy_plan(plan);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the symbol of this rank's wavenumbers: each rank transforms its rows of the kernel, then all transpose. */
static PetscErrorCode SymbolDistributed(SlipCirculant s)
{
  const PetscInt nz = s->grid.nz, all = s->period / 2 + 1;
  const SlipLayout l = SlipLayoutOf(s->comm, nz, all, nz);
  const int length = (int)all;
  const fftw_r2r_kind kind = FFTW_REDFT00;
  PetscReal *rows, *blocks;
  fftw_plan cosine;

  PetscFunctionBegin;
  PetscCall(SlipAllocate(l.size, &rows));
  PetscCall(SlipAllocate(l.size, &blocks));
  cosine = fftw_plan_many_r2r(1, &length, (int)nz, rows, NULL, (int)nz, 1, rows, NULL, (int)nz, 1, &kind,
                              FFTW_ESTIMATE | FFTW_UNALIGNED);
  PetscCheck(cosine, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a cosine transform of length %d", length);
  for (PetscInt i = 0; i < l.rows; i++) {
    PetscReal *row = rows + (size_t)i * all * nz;

    for (PetscInt d = 0; d < all; d++)
      for (PetscInt j = 0; j < nz; j++) row[d * nz + j] = SlipGridEntry(&s->grid, d, l.row_start + i, j);
    fftw_execute_r2r(cosine, row, row);
  }
  PetscCall(SlipTranspose(s->comm, nz, all, nz, rows, blocks));
  PetscCall(PetscMalloc1((size_t)s->nk * nz * nz, &s->symbol));
  PetscCall(PetscArraycpy(s->symbol, blocks, (size_t)s->nk * nz * nz));
  fftw_destroy_plan(cosine);
  fftw_free(rows);
  fftw_free(blocks);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the operators. With several ranks in comm, each has some wavenumbers and rows of cells. Collective. */
PetscErrorCode SlipCirculantCreate(MPI_Comm comm, const SlipGrid *grid, SlipCirculant *strike)
{
  const PetscInt nz = grid->nz, zz = nz * nz;
  PetscMPIInt size;
  SlipCirculant s;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscNew(&s));
  s->grid = *grid;
  s->comm = comm;
  s->period = SlipGoodLength(2 * grid->nx - 1);
  s->shared = (PetscBool)(size > 1);
  PetscCall(SlipTransposedFFTCreate(comm, grid->nx, nz, s->period, &s->pencil));
  PetscCall(SlipAllocateLines((size_t)4 * nz, &s->column));
  s->nk = s->pencil->layout.columns;
  if (s->shared)
    PetscCall(SymbolDistributed(s));
  else {
    PetscCall(PetscMalloc1((size_t)s->nk * zz, &s->symbol));
    for (PetscInt d = 0; d < s->nk; d++) SlipGridKernel(grid, d, s->symbol + (size_t)d * zz);
    PetscCall(CosineTransform(s->nk, nz, s->symbol));
  }
  *strike = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCirculantDestroy(SlipCirculant *strike)
{
  SlipCirculant s = *strike;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipTransposedFFTDestroy(&s->pencil));
  free(s->column);
  PetscCall(PetscFree(s->symbol));
  free(s->halves);
  PetscCall(PetscFree2(s->vectors, s->values));
  PetscCall(PetscFree(s));
  *strike = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StrikeDestroy(SlipContainerArg arg)
{
  SlipCirculant s = (SlipCirculant)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  PetscCall(SlipCirculantDestroy(&s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets whether ranks share the wavenumbers along strike, or each computes whole products. K: stiffness on a uniform
   grid; share: whether they share; by default they do with more than 30 cells in depth. Option -mat_slip_share: the
   same, for MatSlipStiffnessSetFromOptions(). Errors: PETSC_ERR_ORDER after the first use of K, or of a matrix that was
   created from it. */
PetscErrorCode MatSlipStiffnessSetShare(Mat K, PetscBool share)
{
  SlipCirculant made;
  PetscBool *copy;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipCirculant", &made));
  PetscCheck(!made, PetscObjectComm((PetscObject)K), PETSC_ERR_ORDER,
             "Whether ranks share wavenumbers must be chosen before the stiffness is used");
  PetscCall(PetscNew(&copy));
  *copy = share;
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipShare", copy, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the operators of this grid for a stiffness, created at first use and composed with it. */
PetscErrorCode SlipCirculantOfGrid(Mat K, const SlipGrid *grid, SlipCirculant *strike)
{
  const PetscBool *set;
  PetscBool share;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipCirculant", strike));
  if (*strike) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipShare", &set));
  share = set ? *set : (PetscBool)(grid->nz > SLIP_SHARE_MIN);
  PetscCall(SlipCirculantCreate(share ? PetscObjectComm((PetscObject)K) : PETSC_COMM_SELF, grid, strike));
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipCirculant", *strike, StrikeDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the operators of the grid of K; NULL if K is not on a uniform grid. */
PetscErrorCode SlipCirculantOf(Mat K, SlipCirculant *strike)
{
  const SlipGrid *grid;

  PetscFunctionBegin;
  *strike = NULL;
  PetscCall(SlipGridOf(K, &grid));
  if (grid) PetscCall(SlipCirculantOfGrid(K, grid, strike));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets sizes and symbol; any argument may be NULL. */
void SlipCirculantGet(SlipCirculant s, const SlipGrid **grid, PetscInt *period, PetscInt *nk, const PetscReal **symbol)
{
  if (grid) *grid = &s->grid;
  if (period) *period = s->period;
  if (nk) *nk = s->nk;
  if (symbol) *symbol = s->symbol;
}

/* Returns the distribution of the work over ranks; NULL if every rank does all of it. */
SlipTransposedFFT SlipCirculantPencil(SlipCirculant s)
{
  return s->shared ? s->pencil : NULL;
}

PetscErrorCode SlipCirculantGetEigen(SlipCirculant s, const PetscReal **values, const PetscReal **vectors)
{
  const PetscInt nz = s->grid.nz, nk = s->nk;
  PetscInt info;

  PetscFunctionBegin;
  if (!s->vectors) {
    PetscCall(PetscMalloc2((size_t)nk * nz * nz, &s->vectors, nk * nz, &s->values));
    PetscCall(PetscArraycpy(s->vectors, s->symbol, (size_t)nk * nz * nz));
    for (PetscInt k = 0; k < nk; k++) {
      PetscCall(SlipDenseEigen(nz, s->vectors + (size_t)k * nz * nz, s->values + k * nz, &info));
      PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB,
                 "Eigenvalues of wavenumber %" PetscInt_FMT " did not converge (LAPACK info %" PetscInt_FMT ")", k,
                 info);
    }
    for (PetscInt k = 0; k < nk * nz; k++) s->values[k] = PetscMax(s->values[k], 0);
  }
  *values = s->values;
  if (vectors) *vectors = s->vectors;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes blocks[nk][nz][nz]: V f V' per wavenumber for f[nk][nz] at the eigenvalues. */
PetscErrorCode SlipCirculantFormBlocks(SlipCirculant s, const PetscReal f[], PetscReal blocks[])
{
  const PetscInt nz = s->grid.nz, nk = s->nk;
  const PetscReal *values, *vectors;
  const PetscScalar one = 1, zero = 0;
  PetscReal *scaled;
  PetscBLASInt n;

  PetscFunctionBegin;
  PetscCall(SlipCirculantGetEigen(s, &values, &vectors));
  PetscCall(PetscBLASIntCast(nz, &n));
  PetscCall(PetscMalloc1(nz * nz, &scaled));
  for (PetscInt k = 0; k < nk; k++) {
    const PetscReal *V = vectors + (size_t)k * nz * nz;

    for (PetscInt i = 0; i < nz * nz; i++) scaled[i] = f[k * nz + i / nz] * V[i];
    PetscCallBLAS("BLASgemm",
                  BLASgemm_("N", "T", &n, &n, &n, &one, scaled, &n, V, &n, &zero, blocks + (size_t)k * nz * nz, &n));
  }
  PetscCall(PetscFree(scaled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Logs the flops of the transforms of a field along strike, forward and backward, as of radix-2 ones, 2.5 P log2 P
   each, and of a pass over all blocks with a complex vector, which counts as this kind of work. */
static PetscErrorCode LogFlops(SlipCirculant s, SlipWork work)
{
  const PetscLogDouble nz = (PetscLogDouble)s->grid.nz, P = (PetscLogDouble)s->period;
  const PetscLogDouble rows = (PetscLogDouble)s->pencil->layout.rows;

  PetscFunctionBegin;
  PetscCall(SlipWorkFlops(SLIP_WORK_TRANSFORM, 5 * rows * P * PetscLog2Real(P)));
  PetscCall(SlipWorkFlops(work, 4 * (PetscLogDouble)s->nk * nz * nz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies by every wavenumber's block, or by their halves. */
static PetscErrorCode ApplyBlocks(SlipCirculant s, PetscReal scale, PetscBool half, size_t size,
                                  const PetscReal blocks[], const PetscReal x[], PetscReal y[])
{
  const PetscInt nz = s->grid.nz;

  PetscFunctionBegin;
  PetscCall(LogFlops(s, SLIP_WORK_BLOCK));
  PetscCall(SlipTransposedFFTForward(s->pencil, x));
  for (PetscInt k = 0; k < s->nk; k++)
    SlipSymmetricProduct(nz, half, blocks + (size_t)k * size, s->pencil->by_wave + (size_t)k * 2 * nz, s->column);
  PetscCall(SlipTransposedFFTBackward(s->pencil, scale, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = scale * (operator with these symmetric blocks) x; x and y are [nz][nx], or this rank's rows if ranks
   share the work, and may be the same. */
PetscErrorCode SlipCirculantApply(SlipCirculant s, PetscReal scale, const PetscReal blocks[], const PetscReal x[],
                                  PetscReal y[])
{
  PetscFunctionBegin;
  PetscCall(ApplyBlocks(s, scale, PETSC_FALSE, (size_t)s->grid.nz * s->grid.nz, blocks, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does the same with the stiffness itself, faster because it reads half of each block in order. */
PetscErrorCode SlipCirculantApplyStiffness(SlipCirculant s, PetscReal scale, const PetscReal x[], PetscReal y[])
{
  const PetscInt nz = s->grid.nz;
  const size_t size = SlipSymmetricHalf(nz, NULL, NULL);

  PetscFunctionBegin;
  if (!s->halves) {
    PetscCall(SlipAllocateLines((size_t)s->nk * size, &s->halves));
    for (PetscInt k = 0; k < s->nk; k++)
      (void)SlipSymmetricHalf(nz, s->symbol + (size_t)k * nz * nz, s->halves + (size_t)k * size);
  }
  PetscCall(ApplyBlocks(s, scale, PETSC_TRUE, size, s->halves, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Converts the transform of a field of one mirror parity about the middle of the row to real numbers (direction 1), and
   these to the transform (-1): only the phase of the middle is complex, and a factor i of odd fields. */
static void Unwind(SlipCirculant s, PetscInt parity, PetscInt direction, PetscInt k, PetscReal real[])
{
  const PetscReal phase = PETSC_PI * (PetscReal)k * (PetscReal)(s->grid.nx - 1) / (PetscReal)s->period;
  const PetscReal a = parity ? PetscSinReal(phase) : PetscCosReal(phase);
  const PetscReal b = parity ? PetscCosReal(phase) : -PetscSinReal(phase);
  PetscReal *f = s->pencil->by_wave + (size_t)k * 2 * s->grid.nz;

  for (PetscInt i = 0; i < s->grid.nz; i++) {
    if (direction > 0)
      real[i] = a * f[2 * i] + b * f[2 * i + 1];
    else {
      f[2 * i] = a * real[i];
      f[2 * i + 1] = b * real[i];
    }
  }
}

/* Multiplies many fields of one mirror parity at once, X and Y [count][nz][nx], by level-3 BLAS; one process must have
   all wavenumbers. */
PetscErrorCode SlipCirculantApplyMany(SlipCirculant s, PetscReal scale, const PetscReal blocks[], PetscInt parity,
                                      PetscInt count, const PetscReal X[], PetscReal Y[])
{
  const PetscInt nx = s->grid.nx, nz = s->grid.nz, nk = s->nk, N = nx * nz, wide = count * nz;
  const PetscScalar one = 1, zero = 0;
  const PetscBLASInt n = (PetscBLASInt)nz, m = (PetscBLASInt)count;
  PetscReal *f, *g; /* [nk][count][nz] */

  PetscFunctionBegin;
  PetscCall(PetscMalloc2((size_t)nk * wide, &f, (size_t)nk * wide, &g));
  for (PetscInt b = 0; b < count; b++) {
    PetscCall(SlipTransposedFFTForward(s->pencil, X + (size_t)b * N));
    for (PetscInt k = 0; k < nk; k++) Unwind(s, parity, 1, k, f + (size_t)k * wide + b * nz);
  }
  for (PetscInt k = 0; k < nk; k++)
    PetscCallBLAS("BLASgemm", BLASgemm_("T", "N", &n, &m, &n, &one, blocks + (size_t)k * nz * nz, &n,
                                        f + (size_t)k * wide, &n, &zero, g + (size_t)k * wide, &n));
  for (PetscInt b = 0; b < count; b++) {
    for (PetscInt k = 0; k < nk; k++) Unwind(s, parity, -1, k, g + (size_t)k * wide + b * nz);
    PetscCall(SlipTransposedFFTBackward(s->pencil, scale, Y + (size_t)b * N));
  }
  PetscCall(PetscFree2(f, g));
  for (PetscInt b = 0; b < count; b++) PetscCall(LogFlops(s, SLIP_WORK_MATRIX));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the memory of the operators of K on this process; 0 if there are none. */
PetscReal SlipCirculantBytes(Mat K)
{
  PetscReal numbers;
  SlipCirculant s = NULL;

  (void)SlipObjectQueryData((PetscObject)K, "SlipCirculant", &s);
  if (!s) return 0;
  numbers = (PetscReal)s->nk * (PetscReal)(s->grid.nz * s->grid.nz) * (s->vectors ? 2 : 1);
  if (s->halves) numbers += (PetscReal)s->nk * (PetscReal)SlipSymmetricHalf(s->grid.nz, NULL, NULL);
  return (PetscReal)sizeof(PetscReal) * numbers + SlipTransposedFFTBytes(s->pencil);
}
