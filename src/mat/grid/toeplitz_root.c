/*
  Approximate functions of a uniform grid's stiffness by transforms: the fault's cells are a part of an endless plane.

  Without a free surface K is a part of the operator of an endless plane of equal cells, which is diagonal in a Fourier
  transform over the plane: its symbol S is the transform of the full space's kernel. A free surface acts mainly like
  the fault's mirror image (exactly so for antiplane strain), that is like the plane's operator on fields that are even
  about the surface. Therefore the part of f(S) on the fault, and on its image, approximates f(K),

     f(K)_ij  ~  k(x - x', z - z') + k(x - x', z + z'),   k the transform of f(S),

  and is positive definite if f is positive. The square root has an error of 3 % in norm along the fault's edges where
  the fault touches the surface (measured), and the resulting error of B(theta) is at most 2 % of B.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipwork.h>

/* Gap between the fault and its image, over the fault's extent in depth, above which the image is left out */
#define SLIP_IMAGE_GAP 0.5

static PetscErrorCode CosinePlan(PetscInt length, PetscReal line[], fftw_plan *plan)
{
  PetscFunctionBegin;
  *plan = fftw_plan_r2r_1d((int)length, line, line, FFTW_REDFT00, FFTW_ESTIMATE | FFTW_UNALIGNED);
  PetscCheck(*plan, PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a cosine transform of length %" PetscInt_FMT,
             length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Makes one plan for all wavenumbers: complex exponentials over the period, twice the length, or cosines for fields that
  are even about the surface. FFTW's cosine transforms take four times as long as a complex transform of the same
  length, from which they follow (J. Makhoul, A fast cosine transform in one and two dimensions, IEEE Trans. ASSP 28,
  27-34, 1980): if v is the even cells of the line followed by its odd ones in reverse, V its transform and w = exp(-i
  pi / 2 n),

     X(k) = w^k V(k) + w^-k V(n - k),   V(k) = w^-k (X(k) - i X(n - k)) / 2.
*/
static PetscErrorCode PlanWaves(SlipToeplitz p)
{
  const int n = (int)p->length, period = p->image ? n : 2 * n;
  fftw_complex *line, *waves;

  PetscFunctionBegin;
  PetscCall(SlipAllocate((size_t)4 * period, &p->line));
  line = (fftw_complex *)p->line;
  waves = line + period;
  p->wave[0] = fftw_plan_dft_1d(period, line, waves, FFTW_FORWARD, FFTW_ESTIMATE);
  p->wave[1] = fftw_plan_dft_1d(period, waves, line, FFTW_BACKWARD, FFTW_ESTIMATE);
  PetscCheck(p->wave[0] && p->wave[1], PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan transforms of length %d",
             period);
  if (!p->image) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipAllocate((size_t)n + 2, &p->turn));
  for (int k = 0; k <= n / 2; k++) {
    p->turn[2 * k] = PetscCosReal(PETSC_PI * (PetscReal)k / (PetscReal)n);
    p->turn[2 * k + 1] = -PetscSinReal(PETSC_PI * (PetscReal)k / (PetscReal)n);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes S of this rank's wavenumbers along strike. Truncation of the kernel may make values negative. Collective. */
static PetscErrorCode FormWaves(SlipToeplitz p)
{
  const SlipGrid *g = &p->grid;
  const PetscInt nk = p->period / 2 + 1, depths = p->length + 1;
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  const SlipLayout l = SlipLayoutOf(p->comm, depths, nk, 1);
  PetscReal *rows;
  fftw_plan strike, depth;

  PetscFunctionBegin;
  PetscCall(SlipAllocate(l.size, &rows));
  PetscCall(SlipAllocate(l.size, &p->symbol));
  PetscCall(CosinePlan(nk, rows, &strike));
  PetscCall(CosinePlan(depths, p->symbol, &depth));
  for (PetscInt r = 0; r < l.rows; r++) {
    PetscReal *row = rows + (size_t)r * nk;

    for (PetscInt d = 0; d < nk; d++)
      row[d] = SlipKernelDirect(&g->kernel, (PetscReal)d * a, (PetscReal)(l.row_start + r) * b, a, b);
    fftw_execute_r2r(strike, row, row);
  }
  PetscCall(SlipTranspose(p->comm, depths, nk, 1, rows, p->symbol));
  for (PetscInt k = 0; k < l.columns; k++)
    fftw_execute_r2r(depth, p->symbol + (size_t)k * depths, p->symbol + (size_t)k * depths);
  for (size_t i = 0; i < (size_t)l.columns * depths; i++) p->symbol[i] = PetscMax(p->symbol[i], 0);
  fftw_destroy_plan(strike);
  fftw_destroy_plan(depth);
  fftw_free(rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RootDestroy(SlipToeplitz p)
{
  PetscFunctionBegin;
  PetscCall(SlipToeplitzSymbolDestroy(&p->root));
  fftw_free(p->symbol);
  fftw_free(p->line);
  fftw_free(p->turn);
  if (p->wave[0]) fftw_destroy_plan(p->wave[0]);
  if (p->wave[1]) fftw_destroy_plan(p->wave[1]);
  PetscCall(PetscFree(p->diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets S [Pa/m], unscaled: *count values at each of this rank's nk wavenumbers along strike. Collective. */
PetscErrorCode SlipToeplitzGetWaves(SlipToeplitz p, PetscInt *nk, PetscInt *count, const PetscReal **symbol)
{
  const SlipGrid *g = &p->grid;
  const PetscReal gap = 2 * g->depth_top * (PetscReal)g->nz / g->length_z;

  PetscFunctionBegin;
  if (!p->symbol) {
    p->root_destroy = RootDestroy;
    p->image = (PetscBool)(!SlipKernelIs(&g->kernel, SLIP_EVEN_DEPTH) && gap <= SLIP_IMAGE_GAP * (PetscReal)g->nz);
    p->gap = p->image ? (PetscInt)PetscFloorReal(gap + 0.5) : 0;
    p->length = SlipGoodLength(p->image ? 2 * g->nz + p->gap : g->nz);
    PetscCall(FormWaves(p));
    PetscCall(PlanWaves(p));
  }
  *nk = p->pencil->layout.columns;
  *count = p->length + 1;
  *symbol = p->symbol;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the square root's kernels per wavenumber along strike, [local nk][2 nz - 1][2]: of z - z', of z + z'. */
static PetscErrorCode RootKernels(SlipToeplitz p, PetscReal kernel[])
{
  const PetscInt nz = p->grid.nz, depths = p->length + 1;
  PetscReal *line;
  fftw_plan plan;

  PetscFunctionBegin;
  PetscCall(SlipAllocate(depths, &line));
  PetscCall(CosinePlan(depths, line, &plan));
  for (PetscInt k = 0; k < p->pencil->layout.columns; k++) {
    PetscReal *to = kernel + (size_t)k * 2 * (2 * nz - 1);

    for (PetscInt i = 0; i < depths; i++) line[i] = PetscSqrtReal(p->symbol[(size_t)k * depths + i]);
    fftw_execute_r2r(plan, line, line);
    for (PetscInt i = 0; i < 2 * nz - 1; i++) {
      to[2 * i] = i < nz ? line[i] / (PetscReal)(2 * p->length) : 0;
      to[2 * i + 1] = p->image ? line[i + 1 + p->gap] / (PetscReal)(2 * p->length) : 0;
    }
  }
  fftw_destroy_plan(plan);
  fftw_free(line);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the unscaled kernel's approximate square root, and its diagonal at all depths [(Pa/m)^(1/2)]. Collective. */
PetscErrorCode SlipToeplitzGetRoot(SlipToeplitz p, const SlipToeplitzSymbol **root, const PetscReal **diagonal)
{
  const PetscInt nz = p->grid.nz, first = p->pencil->layout.column_start;
  const PetscReal *symbol;
  PetscReal *kernel;
  PetscInt nk, count;

  PetscFunctionBegin;
  if (!p->root.toeplitz) {
    PetscCall(SlipToeplitzGetWaves(p, &nk, &count, &symbol));
    PetscCall(SlipAllocate((size_t)p->pencil->layout.columns * 2 * (2 * p->grid.nz - 1), &kernel));
    PetscCall(RootKernels(p, kernel));
    /* the diagonal at every depth is the mean over all wavenumbers */
    PetscCall(PetscCalloc1(nz, &p->diagonal));
    for (PetscInt k = 0; k < p->pencil->layout.columns; k++) {
      const PetscReal weight = (first + k == 0 || 2 * (first + k) == p->period ? 1.0 : 2.0) / (PetscReal)p->period;
      const PetscReal *line = kernel + (size_t)k * 2 * (2 * nz - 1);

      for (PetscInt i = 0; i < nz; i++) p->diagonal[i] += weight * (line[0] + line[2 * (2 * i) + 1]);
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, p->diagonal, (PetscMPIInt)nz, MPIU_REAL, MPI_SUM, p->comm));
    PetscCall(SlipToeplitzSetSymbol(p, 2, p->image ? 2 : 1, kernel, &p->root));
    fftw_free(kernel);
  }
  *root = &p->root;
  *diagonal = p->diagonal;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets d = factor times the diagonal of the root, which is constant along strike; d has the matrix' distribution. */
PetscErrorCode SlipToeplitzGetRootDiagonal(SlipToeplitz p, PetscReal factor, Vec d)
{
  const SlipToeplitzSymbol *root;
  const PetscReal *diagonal;
  PetscInt start, end;
  PetscReal *pd;

  PetscFunctionBegin;
  PetscCall(SlipToeplitzGetRoot(p, &root, &diagonal));
  PetscCall(VecGetOwnershipRange(d, &start, &end));
  PetscCall(VecGetArrayWrite(d, &pd));
  for (PetscInt i = start; i < end; i++) pd[i - start] = factor * diagonal[i / p->grid.nx];
  PetscCall(VecRestoreArrayWrite(d, &pd));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes sum = identity I + stiffness K + root K^(1/2) of the unscaled kernel, in reused memory. Collective. */
PetscErrorCode SlipToeplitzCombine(SlipToeplitz p, PetscReal identity, PetscReal stiffness, PetscReal root,
                                   SlipToeplitzSymbol *sum)
{
  const size_t size = SlipToeplitzSymbolSize(p);
  const SlipToeplitzSymbol *k = &p->stiffness, *r;
  const PetscReal *diagonal;

  PetscFunctionBegin;
  PetscCall(SlipToeplitzGetRoot(p, &r, &diagonal));
  if (!sum->toeplitz) PetscCall(SlipToeplitzAllocate(p, k->product ? 3 : 1, sum));
  for (size_t i = 0; i < size; i++) sum->toeplitz[i] = identity + stiffness * k->toeplitz[i] + root * r->toeplitz[i];
  for (size_t i = 0; i < 2 * size && k->hankel; i++)
    sum->hankel[i] = stiffness * k->hankel[i] + (r->hankel ? root * r->hankel[i] : 0);
  for (size_t i = 0; i < 2 * size && k->product; i++) sum->product[i] = stiffness * k->product[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the place in the line of the cell at depth i. With cosines half of the gap is before the fault (one cell less
   for an odd gap), and even cells come before odd ones in reverse. */
static PetscInt PlaceOf(SlipToeplitz p, PetscInt i)
{
  const PetscInt j = i + p->gap / 2;

  if (!p->image) return i;
  return j % 2 ? p->length - 1 - j / 2 : j / 2;
}

/* Multiplies cosines X(k) by f(k) in terms of V: where a and b are half the sum and difference of f(k) and f(n - k),
   V(k) = a V(k) + b w^-2k V(n - k) and V(n - k) = a V(n - k) + b w^2k V(k). */
static void MultiplyCosines(PetscInt n, const PetscReal f[], const PetscReal turn[], PetscReal V[])
{
  V[0] *= f[0];
  V[1] *= f[0];
  for (PetscInt k = 1; k <= n / 2; k++) {
    PetscReal *v = V + 2 * k, *u = V + 2 * (n - k);
    const PetscReal a = 0.5 * (f[k] + f[n - k]), b = 0.5 * (f[k] - f[n - k]), c = b * turn[2 * k],
                    s = b * turn[2 * k + 1];
    const PetscReal vr = v[0], vi = v[1], ur = u[0], ui = u[1];

    v[0] = a * vr + c * ur + s * ui;
    v[1] = a * vi + c * ui - s * ur;
    if (2 * k == n) break;
    u[0] = a * ur + c * vr - s * vi;
    u[1] = a * ui + c * vi + s * vr;
  }
}

/* Computes y = part of the plane's operator with the symbol f, [local nk][count] as S of SlipToeplitzGetWaves().
   Collective. */
PetscErrorCode SlipToeplitzApplyWaves(SlipToeplitz p, const PetscReal f[], Vec x, Vec y)
{
  const PetscInt n = p->length, reals = (p->image ? 2 : 4) * n;
  PetscReal *line = p->line, *waves = p->line + reals;

  PetscFunctionBegin;
  PetscCall(SlipToeplitzForward(p, x));
  for (PetscInt k = 0; k < p->pencil->layout.columns; k++) {
    PetscReal *field = p->pencil->by_wave + (size_t)k * 2 * p->grid.nz;
    const PetscReal *factors = f + (size_t)k * (n + 1);

    for (PetscInt i = 0; i < reals; i++) line[i] = 0; /* padded */
    for (PetscInt i = 0; i < p->grid.nz; i++) {
      const PetscInt to = PlaceOf(p, i);

      line[2 * to] = field[2 * i];
      line[2 * to + 1] = field[2 * i + 1];
    }
    fftw_execute(p->wave[0]);
    if (p->image) MultiplyCosines(n, factors, p->turn, waves);
    for (PetscInt i = 0; i < 2 * n && !p->image; i++) {
      const PetscReal factor = factors[PetscMin(i, 2 * n - i)];

      waves[2 * i] *= factor;
      waves[2 * i + 1] *= factor;
    }
    fftw_execute(p->wave[1]);
    for (PetscInt i = 0; i < p->grid.nz; i++) {
      const PetscInt from = PlaceOf(p, i);

      field[2 * i] = line[2 * from];
      field[2 * i + 1] = line[2 * from + 1];
    }
  }
  {
    const PetscLogDouble P = (PetscLogDouble)p->period, Q = 2 * (PetscLogDouble)p->length;

    PetscCall(
      SlipWorkFlops(SLIP_WORK_TRANSFORM, 5 * (PetscLogDouble)p->pencil->layout.rows * P * PetscLog2Real(P) +
                                           10 * (PetscLogDouble)p->pencil->layout.columns * Q * PetscLog2Real(Q)));
  }
  PetscCall(SlipToeplitzBackward(p, 1.0 / (PetscReal)((p->image ? 1 : 2) * p->length), y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
