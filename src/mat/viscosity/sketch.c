/*
  Computes the difference D of the exact viscosity H = S + D to the spectral one S, without dense matrices of the size
  of the fault.

  H^2 = factor^2 K =: A is given exactly, so that D solves the Riccati equation S D + D S + D^2 = A - S^2. D is positive
  semidefinite and of low numerical rank (about 4.4 nz for each mirror parity at 1e-11). In an orthonormal basis Q of
  D's range, with T = Q'SQ, the Galerkin solution is D = Q X Q',

     (T + X)^2 = T^2 + Q'(A - S^2)Q.

  The basis grows by random sketches of the residual R = A - (S + D)^2: to first order the error of D is the integral of
  exp(-St) R exp(-St), whose range (S + a)^-1 R (S + a)^-1 covers for a few shifts a between the ends of S's spectrum
  (generalised Davidson; sketches as in Halko, Martinsson & Tropp 2011). The filters (S + a)^-1 are applied per
  wavenumber. It ends when, by random probes of R, the error of D is not above the tolerance.
*/
#include <slipstep/rooms/slipmat.h>
#include <petscblaslapack.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>
#include <slipstep/private/slipwork.h>

#define FILTERS 4
#define PROBES 4
#define BATCH 32 /* fields that are multiplied at once: enough for level-3 BLAS, few enough for the cache */

typedef struct {
  SlipCirculant strike;
  const SlipGrid *grid;
  PetscInt parity, n;         /* mirror parity, order of its block */
  PetscReal square;           /* factor^2 scale: A = square * kernel */
  const PetscReal *blocks;    /* blocks of S */
  PetscReal *filter[FILTERS]; /* blocks of (S + a)^-1 */
  PetscInt r, room;           /* columns of the basis, and room for them */
  PetscReal *Q, *SQ;          /* [n * room] column-major */
  PetscReal *T, *M;           /* [room * room] Q'SQ and Q'AQ - (SQ)'SQ */
  PetscReal *X;               /* [r * r] */
  PetscReal smallest;         /* eigenvalue of A in the basis */
  uint64_t seed;
} Sketch;

/* Computes C (rows x columns) = alpha op(A) B + beta C, column-major. */
static PetscErrorCode Gemm(const char *transA, PetscInt rows, PetscInt columns, PetscInt inner, PetscReal alpha,
                           const PetscReal A[], PetscInt lda, const PetscReal B[], PetscInt ldb, PetscReal beta,
                           PetscReal C[], PetscInt ldc)
{
  const PetscBLASInt m = (PetscBLASInt)rows, n = (PetscBLASInt)columns, k = (PetscBLASInt)inner;
  const PetscBLASInt la = (PetscBLASInt)lda, lb = (PetscBLASInt)ldb, lc = (PetscBLASInt)ldc;

  PetscFunctionBegin;
  if (!rows || !columns) PetscFunctionReturn(PETSC_SUCCESS);
  SlipWorkAdd(SLIP_WORK_MATRIX, 2 * (PetscReal)rows * (PetscReal)columns * (PetscReal)inner);
  PetscCallBLAS("BLASgemm", BLASgemm_(transA, "N", &m, &n, &k, &alpha, A, &la, B, &lb, &beta, C, &lc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes Y = scale * (operator with these blocks) X for columns that are fields of one parity, [columns][n]. Y may be
   X. */
static PetscErrorCode Multiply(Sketch *s, PetscReal scale, const PetscReal blocks[], PetscInt columns,
                               const PetscReal X[], PetscReal Y[])
{
  const PetscInt nx = s->grid->nx, nz = s->grid->nz, N = nx * nz;
  PetscReal *fields;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)BATCH * N, &fields));
  for (PetscInt start = 0; start < columns; start += BATCH) {
    const PetscInt count = PetscMin(BATCH, columns - start);

    PetscCall(PetscArrayzero(fields, (size_t)count * N));
    for (PetscInt k = 0; k < count; k++)
      SlipMirrorUnfold(nx, nz, s->parity, X + (size_t)(start + k) * s->n, fields + (size_t)k * N);
    PetscCall(SlipCirculantApplyMany(s->strike, scale, blocks, s->parity, count, fields, fields));
    for (PetscInt k = 0; k < count; k++)
      SlipMirrorFold(nx, nz, s->parity, fields + (size_t)k * N, Y + (size_t)(start + k) * s->n);
  }
  PetscCall(PetscFree(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes Y = (S + D) X with the D found so far. */
static PetscErrorCode MultiplyRoot(Sketch *s, PetscInt columns, const PetscReal X[], PetscReal Y[])
{
  PetscReal *a, *b;

  PetscFunctionBegin;
  PetscCall(Multiply(s, 1, s->blocks, columns, X, Y));
  if (!s->r) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2((size_t)s->r * columns, &a, (size_t)s->r * columns, &b));
  PetscCall(Gemm("T", s->r, columns, s->n, 1, s->Q, s->n, X, s->n, 0, a, s->r));
  PetscCall(Gemm("N", s->r, columns, s->r, 1, s->X, s->r, a, s->r, 0, b, s->r));
  PetscCall(Gemm("N", s->n, columns, s->r, 1, s->Q, s->n, b, s->r, 1, Y, s->n));
  PetscCall(PetscFree2(a, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes Y = (A - (S + D)^2) X. */
static PetscErrorCode MultiplyResidual(Sketch *s, PetscInt columns, const PetscReal X[], PetscReal Y[])
{
  const size_t count = (size_t)s->n * columns;
  const PetscReal *symbol;
  PetscReal *once, *twice;

  PetscFunctionBegin;
  SlipCirculantGet(s->strike, NULL, NULL, NULL, &symbol);
  PetscCall(PetscMalloc2(count, &once, count, &twice));
  PetscCall(MultiplyRoot(s, columns, X, once));
  PetscCall(MultiplyRoot(s, columns, once, twice));
  PetscCall(Multiply(s, s->square, symbol, columns, X, Y));
  for (size_t i = 0; i < count; i++) Y[i] -= twice[i];
  PetscCall(PetscFree2(once, twice));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sketches the residual in Y [columns][n], in unit columns; each filter is applied to a share of the columns. */
static PetscErrorCode SketchResidual(Sketch *s, PetscInt columns, PetscReal Y[])
{
  const PetscInt n = s->n;

  PetscFunctionBegin;
  SlipRandomFill((size_t)n * columns, Y, &s->seed);
  for (PetscInt f = 0; f < FILTERS; f++) {
    const PetscInt start = columns * f / FILTERS, count = columns * (f + 1) / FILTERS - start;
    PetscReal *part = Y + (size_t)start * n;

    PetscCall(Multiply(s, 1, s->filter[f], count, part, part));
    PetscCall(MultiplyResidual(s, count, part, part));
    PetscCall(Multiply(s, 1, s->filter[f], count, part, part));
  }
  for (PetscInt k = 0; k < columns; k++) {
    PetscReal *y = Y + (size_t)k * n, sum = 0;

    for (PetscInt i = 0; i < n; i++) sum += y[i] * y[i];
    for (PetscInt i = 0; i < n && sum > 0; i++) y[i] /= PetscSqrtReal(sum);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Enlarges A from r columns of `old` entries to `room` columns of `rows` entries. */
static PetscErrorCode Enlarge(PetscReal **A, PetscInt old, PetscInt r, PetscInt rows, PetscInt room)
{
  PetscReal *grown;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1((size_t)rows * room, &grown));
  for (PetscInt k = 0; k < r; k++)
    PetscCall(PetscArraycpy(grown + (size_t)k * rows, *A + (size_t)k * old, PetscMin(old, rows)));
  PetscCall(PetscFree(*A));
  *A = grown;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the columns r ... r + columns of T and M, and their transposes. */
static PetscErrorCode Project(Sketch *s, PetscInt columns)
{
  const PetscInt n = s->n, r = s->r, all = r + columns, room = s->room;
  const PetscReal *symbol, *Y = s->Q + (size_t)r * n;
  PetscReal *SY = s->SQ + (size_t)r * n, *AY;

  PetscFunctionBegin;
  SlipCirculantGet(s->strike, NULL, NULL, NULL, &symbol);
  PetscCall(Multiply(s, 1, s->blocks, columns, Y, SY));
  PetscCall(PetscMalloc1((size_t)n * columns, &AY));
  PetscCall(Multiply(s, s->square, symbol, columns, Y, AY));
  PetscCall(Gemm("T", all, columns, n, 1, s->Q, n, SY, n, 0, s->T + (size_t)r * room, room));
  PetscCall(Gemm("T", all, columns, n, 1, s->Q, n, AY, n, 0, s->M + (size_t)r * room, room));
  PetscCall(Gemm("T", all, columns, n, -1, s->SQ, n, SY, n, 1, s->M + (size_t)r * room, room));
  PetscCall(PetscFree(AY));
  for (PetscInt j = r; j < all; j++)
    for (PetscInt i = 0; i < j; i++) {
      s->T[(size_t)i * room + j] = s->T[(size_t)j * room + i];
      s->M[(size_t)i * room + j] = s->M[(size_t)j * room + i];
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds so many columns to the basis. */
static PetscErrorCode Grow(Sketch *s, PetscInt columns)
{
  const PetscInt n = s->n, old = s->room;
  PetscReal *Y, *a;
  PetscInt r, room, info;

  PetscFunctionBegin;
  columns = PetscMin(columns, n - s->r);
  if (s->r + columns > old) {
    s->room = PetscMin(n, PetscMax(s->r + columns, old + old / 2));
    PetscCall(Enlarge(&s->Q, n, s->r, n, s->room));
    PetscCall(Enlarge(&s->SQ, n, s->r, n, s->room));
    PetscCall(Enlarge(&s->T, old, s->r, s->room, s->room));
    PetscCall(Enlarge(&s->M, old, s->r, s->room, s->room));
  }
  room = s->room;
  Y = s->Q + (size_t)s->r * s->n;
  PetscCall(SketchResidual(s, columns, Y));
  for (PetscInt pass = 0; pass < 2; pass++) {
    if (s->r) {
      PetscCall(PetscMalloc1((size_t)s->r * columns, &a));
      PetscCall(Gemm("T", s->r, columns, s->n, 1, s->Q, s->n, Y, s->n, 0, a, s->r));
      PetscCall(Gemm("N", s->n, columns, s->r, -1, s->Q, s->n, a, s->r, 1, Y, s->n));
      PetscCall(PetscFree(a));
    }
    PetscCall(SlipOrthonormalise((PetscBLASInt)s->n, (PetscBLASInt)columns, Y, NULL));
  }
  PetscCall(Project(s, columns));
  r = s->r += columns;
  /* X = (T^2 + M)^(1/2) - T */
  PetscCall(PetscFree(s->X));
  PetscCall(PetscMalloc1((size_t)r * r, &s->X));
  for (PetscInt k = 0; k < r; k++) PetscCall(PetscArraycpy(s->X + (size_t)k * r, s->M + (size_t)k * room, r));
  PetscCall(Gemm("T", r, r, r, 1, s->T, room, s->T, room, 1, s->X, r));
  PetscCall(SlipDenseSqrt(r, s->X, &s->smallest, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "Eigenvalues of the stiffness did not converge (LAPACK info %" PetscInt_FMT ")", info);
  for (PetscInt k = 0; k < r && s->smallest > 0; k++)
    for (PetscInt i = 0; i < r; i++) s->X[(size_t)k * r + i] -= s->T[(size_t)k * room + i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest |R x| / |x| of random probes. */
static PetscErrorCode Probe(Sketch *s, PetscReal *largest)
{
  const PetscInt n = s->n;
  PetscReal *x, *y;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2((size_t)n * PROBES, &x, (size_t)n * PROBES, &y));
  SlipRandomFill((size_t)n * PROBES, x, &s->seed);
  PetscCall(MultiplyResidual(s, PROBES, x, y));
  *largest = 0;
  for (PetscInt k = 0; k < PROBES; k++) {
    PetscReal xx = 0, yy = 0;

    for (PetscInt i = k * n; i < (k + 1) * n; i++) {
      xx += x[i] * x[i];
      yy += y[i] * y[i];
    }
    *largest = PetscMax(*largest, PetscSqrtReal(yy / xx));
  }
  PetscCall(PetscFree2(x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates filters for shifts in geometric progression between the ends of the spectrum of S. */
static PetscErrorCode CreateFilters(Sketch *s, PetscReal *low, PetscReal *high)
{
  const PetscReal *values;
  PetscReal *f;
  PetscInt nk;

  PetscFunctionBegin;
  SlipCirculantGet(s->strike, NULL, NULL, &nk, NULL);
  PetscCall(SlipCirculantGetEigen(s->strike, &values, NULL));
  nk *= s->grid->nz;
  *low = PETSC_MAX_REAL;
  *high = 0;
  for (PetscInt i = 0; i < nk; i++) {
    const PetscReal root = PetscSqrtReal(s->square * values[i]);

    *low = PetscMin(*low, root);
    *high = PetscMax(*high, root);
  }
  *low = PetscMax(*low, 1e-3 * *high);
  PetscCall(PetscMalloc1(nk, &f));
  for (PetscInt k = 0; k < FILTERS; k++) {
    const PetscReal shift = *low * PetscPowReal(*high / *low, (PetscReal)k / (FILTERS - 1));

    for (PetscInt i = 0; i < nk; i++) f[i] = *low / (PetscSqrtReal(s->square * values[i]) + shift);
    PetscCall(PetscMalloc1((size_t)nk * s->grid->nz, &s->filter[k]));
    PetscCall(SlipCirculantFormBlocks(s->strike, f, s->filter[k]));
  }
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Computes D for one mirror parity on one process, with a tolerance relative to the norm of H. blocks: S; square:
  factor^2 times the scale of K; *smallest: an eigenvalue of K in the units of square; *error: relative error by the
  probes. m is empty if *smallest is not positive.
*/
PetscErrorCode SlipSketchCorrection(SlipCirculant strike, const PetscReal blocks[], PetscReal square,
                                    PetscReal tolerance, PetscInt parity, PetscReal *smallest, PetscReal *error,
                                    SlipLowRank *m)
{
  Sketch s = {.strike = strike, .parity = parity, .square = square, .blocks = blocks, .seed = 20260101};
  PetscReal low = 0, high = 0, residual = 0, last = PETSC_MAX_REAL, *W, *values;
  PetscInt info;

  PetscFunctionBegin;
  SlipCirculantGet(strike, &s.grid, NULL, NULL, NULL);
  s.n = SlipMirrorWidth(s.grid->nx, parity) * s.grid->nz;
  PetscCall(CreateFilters(&s, &low, &high));
  PetscCall(Grow(&s, PetscMax(32, 6 * s.grid->nz)));
  for (;;) {
    if (s.smallest <= 0) break;
    PetscCall(Probe(&s, &residual));
    *error = residual / (high * low); /* |dD| <= |R| / (2 low); measured: 1 to 2 times less than this */
    PetscCall(PetscInfo(NULL, "Viscosity, parity %" PetscInt_FMT ": %" PetscInt_FMT " columns, error %g\n", parity, s.r,
                        (double)*error));
    if (*error <= 0.5 * tolerance || s.r == s.n || *error > 0.5 * last) break; /* the last: only rounding is left */
    last = *error;
    PetscCall(Grow(&s, PetscMax(32, s.grid->nz)));
  }
  *smallest = s.smallest;
  if (s.smallest > 0) {
    /* D = Q X Q' in its eigenvectors, those above cutoff */
    PetscCall(PetscMalloc2((size_t)s.n * s.r, &W, s.r, &values));
    PetscCall(SlipDenseEigen(s.r, s.X, values, &info));
    PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "Eigenvalues did not converge (LAPACK info %" PetscInt_FMT ")",
               info);
    PetscCall(Gemm("N", s.n, s.r, s.r, 1, s.Q, s.n, s.X, s.r, 0, W, s.n));
    m->n = s.n;
    PetscCall(SlipLowRankSelect(s.n, s.r, W, values, (0.1 * tolerance * high), m));
    PetscCall(PetscFree2(W, values));
  }
  for (PetscInt k = 0; k < FILTERS; k++) PetscCall(PetscFree(s.filter[k]));
  PetscCall(PetscFree(s.Q));
  PetscCall(PetscFree(s.SQ));
  PetscCall(PetscFree(s.T));
  PetscCall(PetscFree(s.M));
  PetscCall(PetscFree(s.X));
  PetscFunctionReturn(PETSC_SUCCESS);
}
