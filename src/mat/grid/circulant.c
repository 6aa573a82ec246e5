/*
  A uniform grid's operators along strike. K depends on x - x' only, so it is the corner of a circulant of P >= 2 nx - 1
  cells; one FFT along strike turns that into one real symmetric nz x nz block per wavenumber (the kernel is even in x).
  Functions of the blocks are the "spectral" operators: exact for K itself, an approximation for sqrt(K) or an inverse.
*/
#include <slipmat.h>
#include <petscblaslapack.h>
#include <fftw3.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>

struct _n_SlipCirculant {
  SlipGrid grid;
  MPI_Comm comm;            /* whose ranks share the wavenumbers; PETSC_COMM_SELF when this process has them all */
  SlipTransposedFFT pencil; /* NULL when it has */
  PetscInt nk;              /* wavenumbers of this process */
  PetscInt period;          /* P, even, with small prime factors */
  PetscReal *symbol;        /* [nk][nz][nz], K per wavenumber, unscaled [Pa/m] */
  PetscReal *vectors;       /* [nk][nz][nz], eigenvector i of block k is row i; NULL until asked for */
  PetscReal *values;        /* [nk][nz], eigenvalues, those below zero set to zero */
  PetscReal *field;         /* [nz][P] */
  PetscReal *re, *im;       /* [nk][nz], transform of field */
  PetscReal *re2, *im2;     /* [nk][nz] */
  fftw_plan forward, backward;
};

/* Cells in depth beyond which ranks share the work: measured on 2 ranks, at 50 x 50 shared products take 0.6 times
   those of one rank, whole ones 1.07 times. */
#define SLIP_SHARE_MIN 40

/* Smallest even length of at least n whose prime factors are 2, 3 and 5. */
PetscInt SlipGoodLength(PetscInt n)
{
  for (PetscInt length = PetscMax(2, n + n % 2);; length += 2) {
    PetscInt rest = length;

    for (PetscInt p = 2; p <= 5; p++)
      while (rest % p == 0) rest /= p;
    if (rest == 1) return length;
  }
}

/* In-place cosine transform over the leading index of a[nk][nz * nz]: kernel to symbol, and P times back. Plans are
   estimated, not measured, so that every rank and every run rounds alike. */
static PetscErrorCode CosineTransform(PetscInt nk, PetscInt nz, PetscReal a[])
{
  const int length = (int)nk, many = (int)(nz * nz);
  const fftw_r2r_kind kind = FFTW_REDFT00;
  fftw_plan plan = fftw_plan_many_r2r(1, &length, many, a, NULL, many, 1, a, NULL, many, 1, &kind, FFTW_ESTIMATE);

  PetscFunctionBegin;
  PetscCheck(plan, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a cosine transform of length %d", length);
  fftw_execute(plan);
  fftw_destroy_plan(plan);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StrikePlan(SlipCirculant s)
{
  const int nz = (int)s->grid.nz, P = (int)s->period;
  const fftw_iodim along = {P, 1, nz}, rows = {nz, P, 1}, back = {P, nz, 1}, back_rows = {nz, 1, P};

  PetscFunctionBegin;
  s->forward = fftw_plan_guru_split_dft_r2c(1, &along, 1, &rows, s->field, s->re, s->im, FFTW_ESTIMATE);
  s->backward = fftw_plan_guru_split_dft_c2r(1, &back, 1, &back_rows, s->re2, s->im2, s->field, FFTW_ESTIMATE);
  PetscCheck(s->forward && s->backward, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan transforms of length %d", P);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Symbol of the wavenumbers of this rank: rows of the kernel are transformed where they are and then transposed. */
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

/* With more than one rank in comm, each has some wavenumbers and rows of cells. Collective. */
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
  s->nk = s->period / 2 + 1;
  if (size > 1) {
    PetscCall(SlipTransposedFFTCreate(comm, grid->nx, nz, s->period, &s->pencil));
    s->nk = s->pencil->layout.columns;
    PetscCall(SymbolDistributed(s));
    PetscCall(PetscCalloc1(2 * nz, &s->re));
  } else {
    PetscCall(PetscMalloc1((size_t)s->nk * zz, &s->symbol));
    PetscCall(PetscCalloc1(s->period * nz, &s->field));
    PetscCall(PetscCalloc1(s->nk * nz, &s->re));
    PetscCall(PetscCalloc1(s->nk * nz, &s->im));
    PetscCall(PetscCalloc1(s->nk * nz, &s->re2));
    PetscCall(PetscCalloc1(s->nk * nz, &s->im2));
    for (PetscInt d = 0; d < s->nk; d++) SlipGridKernel(grid, d, s->symbol + (size_t)d * zz);
    PetscCall(CosineTransform(s->nk, nz, s->symbol));
    PetscCall(StrikePlan(s));
  }
  *strike = s;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipCirculantDestroy(SlipCirculant *strike)
{
  SlipCirculant s = *strike;

  PetscFunctionBegin;
  if (!s) PetscFunctionReturn(PETSC_SUCCESS);
  if (s->forward) fftw_destroy_plan(s->forward);
  if (s->backward) fftw_destroy_plan(s->backward);
  PetscCall(SlipTransposedFFTDestroy(&s->pencil));
  PetscCall(PetscFree(s->field));
  PetscCall(PetscFree(s->re));
  PetscCall(PetscFree(s->im));
  PetscCall(PetscFree(s->re2));
  PetscCall(PetscFree(s->im2));
  PetscCall(PetscFree(s->symbol));
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

/*@
  MatSlipStiffnessSetShare - whether the ranks share wavenumbers along strike, or each multiplies the whole

  Logically collective

  Input Parameters:
+ K     - stiffness on a uniform grid
- share - unless set: more than 40 cells deep, as small grids are multiplied faster than told of

  Options Database Key:
. -mat_slip_share - the same, for MatSlipStiffnessSetFromOptions()

  Errors: PETSC_ERR_ORDER after the first use of K, or of what was made from it

  Level: advanced

.seealso: MatCreateSlipStiffness(), MatSlipStiffnessSetDepth(), MatSlipStiffnessSetFromOptions()
@*/
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

/* The engine of this grid for a stiffness, made at first use and kept with it. */
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

/* That of the grid of K: NULL when K is not on a uniform grid. */
PetscErrorCode SlipCirculantOf(Mat K, SlipCirculant *strike)
{
  const SlipGrid *grid;

  PetscFunctionBegin;
  *strike = NULL;
  PetscCall(SlipGridOf(K, &grid));
  if (grid) PetscCall(SlipCirculantOfGrid(K, grid, strike));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sizes and symbol; any argument may be NULL. */
void SlipCirculantGet(SlipCirculant s, const SlipGrid **grid, PetscInt *period, PetscInt *nk, const PetscReal **symbol)
{
  if (grid) *grid = &s->grid;
  if (period) *period = s->period;
  if (nk) *nk = s->nk;
  if (symbol) *symbol = s->symbol;
}

/* The ranks' share of the work; NULL when every rank has all of it. */
SlipTransposedFFT SlipCirculantPencil(SlipCirculant s)
{
  return s->pencil;
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

/* blocks[nk][nz][nz]: V f V' per wavenumber for f[nk][nz] at the eigenvalues. */
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

/* Flops of the transforms of a field along strike, forth and back, and of reads passes over all blocks with a
   complex vector each: counted as for radix-2 transforms, 2.5 P log2 P each. */
static PetscErrorCode LogFlops(SlipCirculant s, PetscInt reads)
{
  const PetscLogDouble nz = (PetscLogDouble)s->grid.nz, P = (PetscLogDouble)s->period;
  const PetscLogDouble rows = s->pencil ? (PetscLogDouble)s->pencil->layout.rows : nz;

  PetscFunctionBegin;
  PetscCall(
    PetscLogFlops(5 * rows * P * PetscLog2Real(P) + 4 * (PetscLogDouble)reads * (PetscLogDouble)s->nk * nz * nz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void StrikePad(SlipCirculant s, const PetscReal x[])
{
  const PetscInt nx = s->grid.nx, nz = s->grid.nz, P = s->period;

  for (PetscInt iz = 0; iz < nz; iz++) {
    for (PetscInt ix = 0; ix < nx; ix++) s->field[iz * P + ix] = x[iz * nx + ix];
    for (PetscInt ix = nx; ix < P; ix++) s->field[iz * P + ix] = 0;
  }
}

static void StrikeUnpad(SlipCirculant s, PetscReal scale, PetscReal y[])
{
  const PetscInt nx = s->grid.nx, nz = s->grid.nz, P = s->period;

  for (PetscInt iz = 0; iz < nz; iz++)
    for (PetscInt ix = 0; ix < nx; ix++) y[iz * nx + ix] = scale / (PetscReal)P * s->field[iz * P + ix];
}

/* Transform of the zero-padded field x[nz][nx]. */
static void StrikeForward(SlipCirculant s, const PetscReal x[])
{
  StrikePad(s, x);
  fftw_execute(s->forward);
}

static void StrikeBackward(SlipCirculant s, PetscReal scale, PetscReal y[])
{
  fftw_execute(s->backward);
  StrikeUnpad(s, scale, y);
}

/* Entries of a piece of a block: OpenBLAS starts threads from 9,216, which at these sizes cost more than they save, and
   a hundredfold more when another process holds a core. Both vectors use a piece while it is in cache. */
#define SLIP_PIECE 8192

/* y = A x for two vectors, A symmetric. */
static void SymmetricProduct(PetscInt nz, const PetscReal A[], const PetscReal x[], const PetscReal x2[], PetscReal y[],
                             PetscReal y2[])
{
  const PetscScalar one = 1, zero = 0;
  const PetscBLASInt n = (PetscBLASInt)nz, inc = 1;
  const PetscInt most = PetscMax(1, SLIP_PIECE / nz);

  for (PetscInt start = 0; start < nz; start += most) {
    const PetscBLASInt rows = (PetscBLASInt)PetscMin(most, nz - start);
    const PetscReal *piece = A + (size_t)start * nz;

    BLASgemv_("T", &n, &rows, &one, piece, &n, x, &inc, &zero, y + start, &inc);
    BLASgemv_("T", &n, &rows, &one, piece, &n, x2, &inc, &zero, y2 + start, &inc);
  }
}

/* y = scale * (operator with these symmetric blocks) x; x and y are [nz][nx], or this rank's rows of it where ranks
   share the work, and may be the same. */
PetscErrorCode SlipCirculantApply(SlipCirculant s, PetscReal scale, const PetscReal blocks[], const PetscReal x[],
                                  PetscReal y[])
{
  const PetscInt nz = s->grid.nz, nk = s->nk;

  const PetscScalar one = 1, zero = 0;
  const PetscBLASInt n = (PetscBLASInt)nz, two = 2;

  PetscFunctionBegin;
  PetscCall(LogFlops(s, 1));
  if (s->pencil) {
    PetscCall(SlipTransposedFFTForward(s->pencil, x));
    for (PetscInt k = 0; k < nk; k++) {
      PetscReal *f = s->pencil->by_wave + (size_t)k * 2 * nz; /* nz complex, by columns a 2 x nz matrix */

      PetscCallBLAS("BLASgemm", BLASgemm_("N", "N", &two, &n, &n, &one, f, &two, blocks + (size_t)k * nz * nz, &n,
                                          &zero, s->re, &two));
      PetscCall(PetscArraycpy(f, s->re, 2 * nz));
    }
    PetscCall(SlipTransposedFFTBackward(s->pencil, scale, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  StrikeForward(s, x);
  for (PetscInt k = 0; k < nk; k++)
    SymmetricProduct(nz, blocks + (size_t)k * nz * nz, s->re + k * nz, s->im + k * nz, s->re2 + k * nz,
                     s->im2 + k * nz);
  StrikeBackward(s, scale, y);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Turns the transform of a field of one mirror parity about the middle of the row into real numbers (direction 1), and
   those back into the transform (-1): the phase of the middle is all that is complex, but for a factor i when odd. */
static void Unwind(SlipCirculant s, PetscInt parity, PetscInt direction, PetscInt k, PetscReal re[], PetscReal im[],
                   PetscReal real[])
{
  const PetscReal phase = PETSC_PI * (PetscReal)k * (PetscReal)(s->grid.nx - 1) / (PetscReal)s->period;
  const PetscReal a = parity ? PetscSinReal(phase) : PetscCosReal(phase);
  const PetscReal b = parity ? PetscCosReal(phase) : -PetscSinReal(phase);

  for (PetscInt i = 0; i < s->grid.nz; i++) {
    if (direction > 0)
      real[i] = a * re[i] + b * im[i];
    else {
      re[i] = a * real[i];
      im[i] = b * real[i];
    }
  }
}

/* The same for many fields of one mirror parity at once, X and Y [count][nz][nx], by level-3 BLAS; one process has all
   wavenumbers. */
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
    StrikeForward(s, X + (size_t)b * N);
    for (PetscInt k = 0; k < nk; k++)
      Unwind(s, parity, 1, k, s->re + k * nz, s->im + k * nz, f + (size_t)k * wide + b * nz);
  }
  for (PetscInt k = 0; k < nk; k++)
    PetscCallBLAS("BLASgemm", BLASgemm_("T", "N", &n, &m, &n, &one, blocks + (size_t)k * nz * nz, &n,
                                        f + (size_t)k * wide, &n, &zero, g + (size_t)k * wide, &n));
  for (PetscInt b = 0; b < count; b++) {
    for (PetscInt k = 0; k < nk; k++)
      Unwind(s, parity, -1, k, s->re2 + k * nz, s->im2 + k * nz, g + (size_t)k * wide + b * nz);
    StrikeBackward(s, scale, Y + (size_t)b * N);
  }
  PetscCall(PetscFree2(f, g));
  for (PetscInt b = 0; b < count; b++) PetscCall(LogFlops(s, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the engine of K on this process, 0 while it has none. */
PetscReal SlipCirculantBytes(Mat K)
{
  PetscReal numbers;
  SlipCirculant s = NULL;

  (void)SlipObjectQueryData((PetscObject)K, "SlipCirculant", &s);
  if (!s) return 0;
  numbers = (PetscReal)s->nk * (PetscReal)(s->grid.nz * s->grid.nz) * (s->vectors ? 2 : 1);
  if (!s->pencil) numbers += (PetscReal)s->grid.nz * (PetscReal)(s->period + 4 * s->nk);
  return (PetscReal)sizeof(PetscReal) * numbers + (s->pencil ? SlipTransposedFFTBytes(s->pencil) : 0);
}
