/*
  Stiffness of a uniform grid by transforms both along strike and in depth, O(N log N), on any number of ranks.

  With s = z + z' the sum of two depths, the surface part constant + z linear + z^2 quadratic (kernel.c) of the
  symmetrised kernel is

     c(s) + (z + z')/2 l(s) + (z^2 + z'^2)/2 q(s) = A(s) - z z' q(s),   A = c + s/2 l + s^2/2 q,

  and the full space's T depends on z - z' only. Multiplying by z commutes with transforms along strike, so each
  wavenumber along strike needs two transforms in depth, of u and of z u, and two back:

     y^(k) = T^(k) u^(k) + A^(k) u^(-k),   w^(k) = q^(k) (z u)^(-k),   K u = y - z w.

  Rows of cells are spread over the ranks along z for the transforms along strike and along the wavenumber for those in
  depth, with FFTW's distributed transpose between them. One plan serves every row and one every wavenumber, so that
  results do not depend on the number of ranks.
*/
#include <slipmat.h>
#include <fftw3-mpi.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

/* A table of tuples of reals, [rows][columns], rows spread over the ranks; and its transpose. */
typedef struct {
  ptrdiff_t rows, row_start;       /* this rank's rows of the table */
  ptrdiff_t columns, column_start; /* and of its transpose */
  ptrdiff_t size;                  /* reals to allocate for either */
} Layout;

struct _n_SlipPlane {
  SlipGrid grid;
  PetscInt period, depth_period; /* padded lengths along strike and in depth, both even */
  Layout layout;                 /* [nz][nk] complex */
  PetscInt fields;               /* 2, or 1 in a full space */
  PetscReal *toeplitz;           /* [local nk][depth_period / 2 + 1], real since T is even */
  PetscReal *hankel, *product;   /* the same, complex: A^ and q^ */
  PetscReal *z;                  /* [nz] depths [m] */
  PetscReal *row;                /* [period], zero from nx on before a forward transform */
  PetscReal *by_depth, *by_wave; /* [local nz][nk] and [local nk][nz] complex */
  PetscReal *column;             /* [fields][depth_period] complex */
  fftw_plan strike, strike_back, depth, depth_back, transpose, transpose_back;
  VecScatter scatter; /* to this rank's rows of cells; NULL on one rank */
  Vec rows;
};

static Layout LayoutOf(MPI_Comm comm, PetscInt rows, PetscInt columns, PetscInt tuple)
{
  const ptrdiff_t n[2] = {rows, columns};
  Layout l;

  l.size = fftw_mpi_local_size_many_transposed(2, n, tuple, FFTW_MPI_DEFAULT_BLOCK, FFTW_MPI_DEFAULT_BLOCK, comm,
                                               &l.rows, &l.row_start, &l.columns, &l.column_start);
  return l;
}

static PetscErrorCode Allocate(ptrdiff_t count, PetscReal **a)
{
  PetscFunctionBegin;
  *a = fftw_alloc_real((size_t)PetscMax(count, 1));
  PetscCheck(*a, PETSC_COMM_SELF, PETSC_ERR_MEM, "No memory for %zu numbers", (size_t)count);
  for (ptrdiff_t i = 0; i < count; i++) (*a)[i] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The three kernels at every distance along strike for depth index r (z - z' = r b, s = 2 top + (r + 1) b), [nk][3]. */
static void KernelRow(const SlipGrid *g, PetscInt r, PetscInt nk, PetscReal row[])
{
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  const PetscReal G = g->shear_modulus, nu = g->poisson_ratio, s = 2 * g->depth_top + (PetscReal)(r + 1) * b;

  for (PetscInt d = 0; d < nk; d++) {
    const PetscReal dx = (PetscReal)d * a;
    PetscReal part[3] = {0, 0, 0};

    if (!g->full_space) SlipKernelSurface_Private(G, nu, dx, s, a, b, part);
    row[3 * d] = r < g->nz ? SlipKernelFullSpace(G, nu, dx, (PetscReal)r * b, a, b) : 0;
    row[3 * d + 1] = part[0] + s * (0.5 * part[1] + 0.5 * s * part[2]);
    row[3 * d + 2] = part[2];
  }
}

/* Kernels, cosine transformed along strike, of this rank's depths; then transposed to its wavenumbers. */
static PetscErrorCode KernelsByWave(SlipPlane p, MPI_Comm comm, PetscReal **kernels)
{
  const PetscInt nk = p->period / 2 + 1, depths = 2 * p->grid.nz - 1;
  const Layout l = LayoutOf(comm, depths, nk, 3);
  const int length = (int)nk;
  const fftw_r2r_kind kind = FFTW_REDFT00;
  PetscReal *rows;
  fftw_plan cosine, transpose;

  PetscFunctionBegin;
  PetscCall(Allocate(l.size, &rows));
  PetscCall(Allocate(l.size, kernels));
  cosine = fftw_plan_many_r2r(1, &length, 3, rows, NULL, 3, 1, rows, NULL, 3, 1, &kind, FFTW_ESTIMATE | FFTW_UNALIGNED);
  transpose = fftw_mpi_plan_many_transpose(depths, nk, 3, FFTW_MPI_DEFAULT_BLOCK, FFTW_MPI_DEFAULT_BLOCK, rows,
                                           *kernels, comm, FFTW_ESTIMATE);
  PetscCheck(cosine && transpose, comm, PETSC_ERR_LIB, "FFTW cannot plan a cosine transform of length %d", length);
  for (PetscInt r = 0; r < (PetscInt)l.rows; r++) {
    PetscReal *row = rows + (size_t)r * 3 * nk;

    KernelRow(&p->grid, (PetscInt)l.row_start + r, nk, row);
    fftw_execute_r2r(cosine, row, row);
  }
  fftw_execute(transpose);
  fftw_destroy_plan(cosine);
  fftw_destroy_plan(transpose);
  fftw_free(rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Transforms in depth of one wavenumber's kernels [2 nz - 1][3] into symbol k. */
static void SymbolOf(SlipPlane p, const PetscReal kernel[], fftw_plan plan, PetscReal line[], PetscReal out[],
                     PetscInt k)
{
  const PetscInt nz = p->grid.nz, P = p->depth_period, h = P / 2 + 1;
  PetscReal *const target[3] = {p->toeplitz + (size_t)k * h, p->hankel + (size_t)k * 2 * h,
                                p->product + (size_t)k * 2 * h};

  for (PetscInt part = 0; part < (p->fields == 2 ? 3 : 1); part++) {
    for (PetscInt i = 0; i < P; i++) line[i] = 0;
    for (PetscInt i = 0; i < (part ? 2 * nz - 1 : nz); i++) line[i] = kernel[3 * i + part];
    for (PetscInt i = 1; i < nz && !part; i++) line[P - i] = kernel[3 * i];
    fftw_execute(plan);
    for (PetscInt i = 0; i < h; i++) {
      if (part) {
        target[part][2 * i] = out[2 * i];
        target[part][2 * i + 1] = out[2 * i + 1];
      } else
        target[0][i] = out[2 * i];
    }
  }
}

static PetscErrorCode FormSymbols(SlipPlane p, MPI_Comm comm)
{
  const PetscInt P = p->depth_period, h = P / 2 + 1, local = (PetscInt)p->layout.columns;
  PetscReal *kernels, *line, *out;
  fftw_plan plan;

  PetscFunctionBegin;
  PetscCall(KernelsByWave(p, comm, &kernels));
  PetscCall(Allocate(P, &line));
  PetscCall(Allocate((ptrdiff_t)2 * h, &out));
  plan = fftw_plan_dft_r2c_1d((int)P, line, (fftw_complex *)out, FFTW_ESTIMATE);
  PetscCheck(plan, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a transform of length %" PetscInt_FMT, P);
  PetscCall(Allocate((ptrdiff_t)local * h, &p->toeplitz));
  PetscCall(Allocate((ptrdiff_t)local * (p->fields == 2 ? 2 * h : 0), &p->hankel));
  PetscCall(Allocate((ptrdiff_t)local * (p->fields == 2 ? 2 * h : 0), &p->product));
  for (PetscInt k = 0; k < local; k++) SymbolOf(p, kernels + (size_t)k * 3 * (2 * p->grid.nz - 1), plan, line, out, k);
  fftw_destroy_plan(plan);
  fftw_free(line);
  fftw_free(out);
  fftw_free(kernels);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Plan(SlipPlane p, MPI_Comm comm)
{
  const PetscInt nz = p->grid.nz, nk = p->period / 2 + 1;
  const int P = (int)p->period, Q = (int)p->depth_period, fields = (int)p->fields;
  const ptrdiff_t block = FFTW_MPI_DEFAULT_BLOCK;
  fftw_complex *column = (fftw_complex *)p->column, *line = (fftw_complex *)p->by_depth;

  PetscFunctionBegin;
  p->strike = fftw_plan_dft_r2c_1d(P, p->row, line, FFTW_ESTIMATE);
  p->strike_back = fftw_plan_dft_c2r_1d(P, line, p->row, FFTW_ESTIMATE);
  p->depth = fftw_plan_many_dft(1, &Q, fields, column, NULL, 1, Q, column, NULL, 1, Q, FFTW_FORWARD, FFTW_ESTIMATE);
  p->depth_back =
    fftw_plan_many_dft(1, &Q, fields, column, NULL, 1, Q, column, NULL, 1, Q, FFTW_BACKWARD, FFTW_ESTIMATE);
  p->transpose = fftw_mpi_plan_many_transpose(nz, nk, 2, block, block, p->by_depth, p->by_wave, comm, FFTW_ESTIMATE);
  p->transpose_back =
    fftw_mpi_plan_many_transpose(nk, nz, 2, block, block, p->by_wave, p->by_depth, comm, FFTW_ESTIMATE);
  PetscCheck(p->strike && p->strike_back && p->depth && p->depth_back && p->transpose && p->transpose_back, comm,
             PETSC_ERR_LIB, "FFTW cannot plan transforms of %d x %d points", P, Q);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of cells that this rank transforms, from the distribution of K's vectors. */
static PetscErrorCode CreateScatter(SlipPlane p, Mat K)
{
  const PetscInt nx = p->grid.nx, n = (PetscInt)p->layout.rows * nx;
  PetscMPIInt size;
  IS from;
  Vec x;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)K), &size));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(K, &x, NULL));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &p->rows));
  PetscCall(ISCreateStride(PETSC_COMM_SELF, n, (PetscInt)p->layout.row_start * nx, 1, &from));
  PetscCall(VecScatterCreate(x, from, p->rows, NULL, &p->scatter));
  PetscCall(ISDestroy(&from));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Collective on K, whose vectors' distribution is taken. */
PetscErrorCode SlipPlaneCreate(Mat K, const SlipGrid *grid, SlipPlane *plane)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const PetscReal b = grid->length_z / (PetscReal)grid->nz;
  SlipPlane p;

  PetscFunctionBegin;
  fftw_mpi_init(); /* may be called again and again */
  PetscCall(PetscNew(&p));
  p->grid = *grid;
  p->fields = grid->full_space ? 1 : 2;
  p->period = SlipGoodLength(2 * grid->nx - 1);
  p->depth_period = SlipGoodLength(2 * grid->nz - 1);
  p->layout = LayoutOf(comm, grid->nz, p->period / 2 + 1, 2);
  PetscCall(FormSymbols(p, comm));
  PetscCall(PetscMalloc1(grid->nz, &p->z));
  for (PetscInt i = 0; i < grid->nz; i++) p->z[i] = grid->depth_top + ((PetscReal)i + 0.5) * b;
  PetscCall(Allocate(p->period, &p->row));
  PetscCall(Allocate(PetscMax(p->layout.size, p->period + 2), &p->by_depth)); /* plans want at least one row */
  PetscCall(Allocate(p->layout.size, &p->by_wave));
  PetscCall(Allocate((ptrdiff_t)p->fields * 2 * p->depth_period, &p->column));
  PetscCall(Plan(p, comm));
  PetscCall(CreateScatter(p, K));
  *plane = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipPlaneDestroy(SlipPlane *plane)
{
  SlipPlane p = *plane;

  PetscFunctionBegin;
  if (!p) PetscFunctionReturn(PETSC_SUCCESS);
  fftw_destroy_plan(p->strike);
  fftw_destroy_plan(p->strike_back);
  fftw_destroy_plan(p->depth);
  fftw_destroy_plan(p->depth_back);
  fftw_destroy_plan(p->transpose);
  fftw_destroy_plan(p->transpose_back);
  fftw_free(p->toeplitz);
  fftw_free(p->hankel);
  fftw_free(p->product);
  fftw_free(p->row);
  fftw_free(p->by_depth);
  fftw_free(p->by_wave);
  fftw_free(p->column);
  PetscCall(VecScatterDestroy(&p->scatter));
  PetscCall(VecDestroy(&p->rows));
  PetscCall(PetscFree(p->z));
  PetscCall(PetscFree(p));
  *plane = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* In place on n pairs (k, -k) of u: u(k) = T u(k) + A(k) u(-k), A(-k) the conjugate of A(k). */
static void MultiplyFirst(PetscInt P, const PetscReal T[], const PetscReal A[], PetscReal u[])
{
  for (PetscInt k = 0; k <= P / 2; k++) {
    PetscReal *a = u + 2 * k, *b = u + 2 * (k ? P - k : 0);
    const PetscReal ar = a[0], ai = a[1], br = b[0], bi = b[1], r = A[2 * k], i = A[2 * k + 1];

    a[0] = T[k] * ar + r * br - i * bi;
    a[1] = T[k] * ai + r * bi + i * br;
    b[0] = T[k] * br + r * ar + i * ai;
    b[1] = T[k] * bi + r * ai - i * ar;
  }
}

/* The same for v(k) = q(k) v(-k). */
static void MultiplySecond(PetscInt P, const PetscReal q[], PetscReal v[])
{
  for (PetscInt k = 0; k <= P / 2; k++) {
    PetscReal *a = v + 2 * k, *b = v + 2 * (k ? P - k : 0);
    const PetscReal ar = a[0], ai = a[1], br = b[0], bi = b[1], r = q[2 * k], i = q[2 * k + 1];

    a[0] = r * br - i * bi;
    a[1] = r * bi + i * br;
    b[0] = r * ar + i * ai;
    b[1] = r * ai - i * ar;
  }
}

static void MultiplyFullSpace(PetscInt P, const PetscReal T[], PetscReal u[])
{
  for (PetscInt k = 0; k < P; k++) {
    const PetscReal t = T[PetscMin(k, P - k)];

    u[2 * k] *= t;
    u[2 * k + 1] *= t;
  }
}

/* Product at local wavenumber k: f [nz] complex, in place. */
static void ApplyWave(SlipPlane p, PetscInt k, PetscReal f[])
{
  const PetscInt nz = p->grid.nz, P = p->depth_period, h = P / 2 + 1;
  PetscReal *u = p->column, *v = p->column + 2 * P;

  for (PetscInt i = 0; i < 2 * nz; i++) u[i] = f[i];
  for (PetscInt i = 2 * nz; i < 2 * P; i++) u[i] = 0;
  if (p->fields == 2) {
    for (PetscInt i = 0; i < nz; i++) {
      v[2 * i] = p->z[i] * f[2 * i];
      v[2 * i + 1] = p->z[i] * f[2 * i + 1];
    }
    for (PetscInt i = 2 * nz; i < 2 * P; i++) v[i] = 0;
  }
  fftw_execute(p->depth);
  if (p->fields == 2) {
    MultiplyFirst(P, p->toeplitz + (size_t)k * h, p->hankel + (size_t)k * 2 * h, u);
    MultiplySecond(P, p->product + (size_t)k * 2 * h, v);
  } else
    MultiplyFullSpace(P, p->toeplitz + (size_t)k * h, u);
  fftw_execute(p->depth_back);
  for (PetscInt i = 0; i < 2 * nz; i++) f[i] = u[i];
  if (p->fields == 2)
    for (PetscInt i = 0; i < 2 * nz; i++) f[i] -= p->z[i / 2] * v[i];
}

/* From this rank's rows x [local nz][nx] to those of scale * K x. Collective. */
static void ApplyRows(SlipPlane p, PetscReal scale, const PetscReal x[], PetscReal y[])
{
  const PetscInt nx = p->grid.nx, P = p->period, nk = P / 2 + 1, rows = (PetscInt)p->layout.rows;
  const PetscReal factor = scale / ((PetscReal)P * (PetscReal)p->depth_period);

  for (PetscInt ix = nx; ix < P; ix++) p->row[ix] = 0;
  for (PetscInt iz = 0; iz < rows; iz++) {
    for (PetscInt ix = 0; ix < nx; ix++) p->row[ix] = x[(size_t)iz * nx + ix];
    fftw_execute_dft_r2c(p->strike, p->row, (fftw_complex *)(p->by_depth + (size_t)iz * 2 * nk));
  }
  fftw_execute(p->transpose);
  for (PetscInt k = 0; k < (PetscInt)p->layout.columns; k++) ApplyWave(p, k, p->by_wave + (size_t)k * 2 * p->grid.nz);
  fftw_execute(p->transpose_back);
  for (PetscInt iz = 0; iz < rows; iz++) {
    fftw_execute_dft_c2r(p->strike_back, (fftw_complex *)(p->by_depth + (size_t)iz * 2 * nk), p->row);
    for (PetscInt ix = 0; ix < nx; ix++) y[(size_t)iz * nx + ix] = factor * p->row[ix];
  }
}

/* y = scale * K x */
PetscErrorCode SlipPlaneApply(SlipPlane p, PetscReal scale, Vec x, Vec y)
{
  const PetscReal *px;
  PetscReal *py;

  PetscFunctionBegin;
  if (p->scatter) {
    PetscCall(VecScatterBegin(p->scatter, x, p->rows, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(p->scatter, x, p->rows, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecGetArray(p->rows, &py));
    ApplyRows(p, scale, py, py);
    PetscCall(VecRestoreArray(p->rows, &py));
    PetscCall(VecScatterBegin(p->scatter, p->rows, y, INSERT_VALUES, SCATTER_REVERSE));
    PetscCall(VecScatterEnd(p->scatter, p->rows, y, INSERT_VALUES, SCATTER_REVERSE));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArrayRead(x, &px));
  PetscCall(VecGetArrayWrite(y, &py));
  ApplyRows(p, scale, px, py);
  PetscCall(VecRestoreArrayWrite(y, &py));
  PetscCall(VecRestoreArrayRead(x, &px));
  PetscFunctionReturn(PETSC_SUCCESS);
}
