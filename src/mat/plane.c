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
#include <fftw3.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

struct _n_SlipPlane {
  SlipGrid grid;
  PetscInt period, depth_period; /* padded lengths along strike and in depth, both even */
  SlipPencil pencil;
  PetscInt fields;             /* 2, or 1 in a full space */
  PetscReal *toeplitz;         /* [local nk][depth_period / 2 + 1], real since T is even */
  PetscReal *hankel, *product; /* the same, complex: A^ and q^ */
  PetscReal *z;                /* [nz] depths [m] */
  PetscReal *column;           /* [fields][depth_period] complex */
  fftw_plan depth, depth_back;
  VecScatter scatter; /* to this rank's rows of cells; NULL on one rank */
  Vec rows;
};

/* Of a product: real transforms along strike and complex ones in depth, forth and back, and the symbols. */
static PetscErrorCode LogFlops(SlipPlane p)
{
  const PetscLogDouble P = (PetscLogDouble)p->period, Q = (PetscLogDouble)p->depth_period;
  const PetscLogDouble rows = (PetscLogDouble)p->pencil->layout.rows, waves = (PetscLogDouble)p->pencil->layout.columns;

  PetscFunctionBegin;
  PetscCall(PetscLogFlops(5 * rows * P * PetscLog2Real(P) +
                          waves * Q * (10 * p->fields * PetscLog2Real(Q) + (p->fields == 2 ? 16 : 2))));
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
  const PetscInt P = p->depth_period, h = P / 2 + 1, local = p->pencil->layout.columns;
  PetscReal *kernels, *line, *out;
  fftw_plan plan;

  PetscFunctionBegin;
  PetscCall(KernelsByWave(p, comm, &kernels));
  PetscCall(SlipAllocate(P, &line));
  PetscCall(SlipAllocate((size_t)2 * h, &out));
  plan = fftw_plan_dft_r2c_1d((int)P, line, (fftw_complex *)out, FFTW_ESTIMATE);
  PetscCheck(plan, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a transform of length %" PetscInt_FMT, P);
  PetscCall(SlipAllocate((size_t)local * h, &p->toeplitz));
  PetscCall(SlipAllocate((size_t)local * (p->fields == 2 ? 2 * h : 0), &p->hankel));
  PetscCall(SlipAllocate((size_t)local * (p->fields == 2 ? 2 * h : 0), &p->product));
  for (PetscInt k = 0; k < local; k++) SymbolOf(p, kernels + (size_t)k * 3 * (2 * p->grid.nz - 1), plan, line, out, k);
  fftw_destroy_plan(plan);
  fftw_free(line);
  fftw_free(out);
  fftw_free(kernels);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Plan(SlipPlane p)
{
  const int Q = (int)p->depth_period, fields = (int)p->fields;
  fftw_complex *column = (fftw_complex *)p->column;

  PetscFunctionBegin;
  p->depth = fftw_plan_many_dft(1, &Q, fields, column, NULL, 1, Q, column, NULL, 1, Q, FFTW_FORWARD, FFTW_ESTIMATE);
  p->depth_back =
    fftw_plan_many_dft(1, &Q, fields, column, NULL, 1, Q, column, NULL, 1, Q, FFTW_BACKWARD, FFTW_ESTIMATE);
  PetscCheck(p->depth && p->depth_back, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan transforms of length %d", Q);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rows of cells that this rank transforms, from the distribution of K's vectors. */
static PetscErrorCode CreateScatter(SlipPlane p, Mat K)
{
  const PetscInt nx = p->grid.nx, n = p->pencil->layout.rows * nx;
  PetscMPIInt size;
  IS from;
  Vec x;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)K), &size));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(K, &x, NULL));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, &p->rows));
  PetscCall(ISCreateStride(PETSC_COMM_SELF, n, p->pencil->layout.row_start * nx, 1, &from));
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
  PetscCall(PetscNew(&p));
  p->grid = *grid;
  p->fields = grid->full_space ? 1 : 2;
  p->period = SlipGoodLength(2 * grid->nx - 1);
  p->depth_period = SlipGoodLength(2 * grid->nz - 1);
  PetscCall(SlipPencilCreate(comm, grid->nx, grid->nz, p->period, &p->pencil));
  PetscCall(FormSymbols(p, comm));
  PetscCall(PetscMalloc1(grid->nz, &p->z));
  for (PetscInt i = 0; i < grid->nz; i++) p->z[i] = grid->depth_top + ((PetscReal)i + 0.5) * b;
  PetscCall(SlipAllocate((size_t)p->fields * 2 * p->depth_period, &p->column));
  PetscCall(Plan(p));
  PetscCall(CreateScatter(p, K));
  *plane = p;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipPlaneDestroy(SlipPlane *plane)
{
  SlipPlane p = *plane;

  PetscFunctionBegin;
  if (!p) PetscFunctionReturn(PETSC_SUCCESS);
  fftw_destroy_plan(p->depth);
  fftw_destroy_plan(p->depth_back);
  fftw_free(p->toeplitz);
  fftw_free(p->hankel);
  fftw_free(p->product);
  fftw_free(p->column);
  PetscCall(SlipPencilDestroy(&p->pencil));
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
  SlipPencil pencil = p->pencil;

  SlipPencilForward(pencil, x);
  for (PetscInt k = 0; k < pencil->layout.columns; k++) ApplyWave(p, k, pencil->by_wave + (size_t)k * 2 * p->grid.nz);
  SlipPencilBackward(pencil, scale / (PetscReal)p->depth_period, y);
}

/* y = scale * K x */
PetscErrorCode SlipPlaneApply(SlipPlane p, PetscReal scale, Vec x, Vec y)
{
  const PetscReal *px;
  PetscReal *py;

  PetscFunctionBegin;
  PetscCall(LogFlops(p));
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

/* On this process. */
PetscReal SlipPlaneBytes(SlipPlane p)
{
  const PetscReal h = (PetscReal)(p->depth_period / 2 + 1), waves = (PetscReal)p->pencil->layout.columns;

  return (PetscReal)sizeof(PetscReal) * (waves * h * (p->fields == 2 ? 5 : 1) + 2 * p->fields * p->depth_period) +
         SlipPencilBytes(p->pencil);
}
