/*
  Stiffness of a dipping plane and change of its normal stress by slip, of type "slipdippingfft": exact products by
  transforms along strike and a real block per wavenumber, or in a full space transforms in depth as well, which take a
  hundredth of the memory for 150 cells in depth (dipping_blocks.c). Rakes may differ from cell to cell: slip
  is resolved into components before a product, and stress along the rakes after it. If all cells slip along strike, or
  all along dip, there is one component. Vectors of slip and of stress have these components already. Both matrices
  share one engine, so that products with both transform slip once.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <stdlib.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipwork.h>

#define TYPE "slipdippingfft"

typedef struct {
  PetscInt users; /* number of matrices that use it */
  PetscInt nx, nz, n;
  PetscInt component[3]; /* n of them: 0 along strike, 1 up dip, 2 opening */
  PetscBool vector;      /* slip and stress drop have all n components of each cell, 2 or 3 */
  PetscReal *share[2];   /* [rows of cells of this rank] components of unit slip along the rake; NULL for vectors */
  SlipTransposedFFT pencil;
  SlipGather gather, normal_gather; /* of slip; of compression if slip is a vector */
  PetscReal *stiffness;    /* [local wavenumbers] halves of symmetric blocks [n nz][n nz]; NULL after K is destroyed */
  PetscInt depth_period;   /* 0: none; otherwise `stiffness` is their transforms in depth instead */
  fftw_plan depth[2];      /* of `column`, [n][depth_period] complex: forward and backward */
  SlipDippingGrid grid;    /* without rakes */
  PetscReal *normal;       /* [local wavenumbers][n nz][nz]; NULL without Kn */
  PetscReal *waves;        /* [local wavenumbers][n nz] complex, of all components; the pencil's own for one */
  PetscReal *normal_waves; /* [local wavenumbers][nz] complex */
  PetscReal *column;       /* work of one wavenumber */
  PetscReal *field, *y;    /* [rows of cells]; y has n numbers for each if slip is a vector */
  SlipBlocksDevice device; /* NULL: not in use */
} Engine;

typedef struct {
  Engine *engine;
  PetscBool normal; /* this is Kn */
  PetscReal scale;  /* factor of MatScale() */
  Vec diagonal;     /* diagonal at a scale of 1 */
} Dipping;

/* ---- the engine ---- */

static PetscErrorCode EngineDestroy(Engine **engine)
{
  Engine *e = *engine;

  PetscFunctionBegin;
  *engine = NULL;
  if (!e || --e->users > 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipBlocksDeviceDestroy(&e->device));
  if (e->n > 1) fftw_free(e->waves);
  fftw_free(e->normal_waves);
  free(e->stiffness);
  free(e->normal);
  free(e->column);
  for (int back = 0; back < 2; back++)
    if (e->depth[back]) fftw_destroy_plan(e->depth[back]);
  PetscCall(PetscFree2(e->share[0], e->share[1]));
  PetscCall(PetscFree2(e->field, e->y));
  PetscCall(SlipTransposedFFTDestroy(&e->pencil));
  PetscCall(SlipGatherDestroy(&e->gather));
  PetscCall(SlipGatherDestroy(&e->normal_gather));
  PetscCall(PetscFree(e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the components along which some cell slips, and the components of each cell of this rank's rows. */
static PetscErrorCode SetComponents(Engine *e, PetscBool opens, const PetscReal rake[])
{
  const PetscInt N = e->nx * e->nz, rows = e->pencil->layout.rows * e->nx;
  PetscBool used[3] = {e->vector, e->vector, opens};
  PetscReal part[2];

  PetscFunctionBegin;
  for (PetscInt i = 0; i < N && !e->vector; i++) {
    SlipDegrees(rake[i], &part[1], &part[0]);
    for (int c = 0; c < 2; c++) used[c] = (PetscBool)(used[c] || part[c] != 0);
  }
  for (PetscInt c = 0; c < 3; c++)
    if (used[c]) e->component[e->n++] = c;
  if (e->vector) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(rows, &e->share[0], e->n > 1 ? rows : 0, &e->share[1]));
  for (PetscInt i = 0; i < rows; i++) {
    SlipDegrees(rake[e->pencil->layout.row_start * e->nx + i], &part[1], &part[0]);
    for (PetscInt c = 0; c < e->n; c++) e->share[c][i] = part[e->component[c]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PlanDepth(Engine *e)
{
  const int Q = (int)e->depth_period;
  fftw_complex *column = (fftw_complex *)e->column;

  PetscFunctionBegin;
  for (int back = 0; back < 2; back++) {
    e->depth[back] = fftw_plan_many_dft(1, &Q, (int)e->n, column, NULL, 1, Q, column, NULL, 1, Q,
                                        back ? FFTW_BACKWARD : FFTW_FORWARD, FFTW_ESTIMATE);
    PetscCheck(e->depth[back], PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan transforms of length %d", Q);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode EngineCreate(MPI_Comm comm, const SlipDippingGrid *grid, PetscBool normal, Engine **engine)
{
  const PetscInt nx = grid->grid.nx, nz = grid->grid.nz, period = SlipGoodLength(2 * nx - 1);
  PetscInt rows, nk;
  Engine *e;

  PetscFunctionBegin;
  PetscCall(PetscNew(&e));
  e->nx = nx;
  e->nz = nz;
  e->vector = (PetscBool)(grid->grid.kernel.type->components > 1);
  PetscCall(SlipTransposedFFTCreate(comm, nx, nz, period, &e->pencil));
  rows = e->pencil->layout.rows * nx;
  nk = e->pencil->layout.columns;
  PetscCall(SetComponents(e, (PetscBool)(grid->grid.kernel.type->components > 2), grid->rake));
  e->grid = *grid;
  e->grid.rake = NULL;
  e->depth_period = !normal && SlipDippingSteady(grid) ? SlipGoodLength(2 * nz - 1) : 0;
  if (e->depth_period)
    PetscCall(SlipDippingSymbol(comm, grid, period, nk, e->n, e->component, e->depth_period, &e->stiffness));
  else
    PetscCall(SlipDippingBlocks(comm, grid, period, nk, e->n, e->component, &e->stiffness, normal ? &e->normal : NULL));
  e->waves = e->pencil->by_wave;
  if (e->n > 1) PetscCall(SlipAllocate((size_t)2 * nk * e->n * nz, &e->waves));
  if (normal) PetscCall(SlipAllocate((size_t)2 * nk * nz, &e->normal_waves));
  PetscCall(SlipAllocateLines((size_t)e->n * PetscMax(4 * nz, 2 * e->depth_period), &e->column));
  if (e->depth_period) PetscCall(PlanDepth(e));
  PetscCall(PetscMalloc2(rows, &e->field, e->vector ? e->n * rows : rows, &e->y));
  *engine = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies to[k] = i^turns from[k], nz complex numbers of each local wavenumber, which are so many reals apart. */
static void CopyWaves(const Engine *e, int turns, const PetscReal from[], PetscInt from_apart, PetscReal to[],
                      PetscInt to_apart)
{
  const PetscReal cosine = turns == 0, sine = turns;

  for (PetscInt k = 0; k < e->pencil->layout.columns; k++) {
    const PetscReal *a = from + (size_t)k * from_apart;
    PetscReal *b = to + (size_t)k * to_apart;

    for (PetscInt i = 0; i < 2 * e->nz; i += 2) {
      const PetscReal re = a[i], im = a[i + 1];

      b[i] = cosine * re - sine * im;
      b[i + 1] = cosine * im + sine * re;
    }
  }
}

/* Transforms the components of slip. Collective. */
static PetscErrorCode Forward(Engine *e, Vec u)
{
  const PetscInt rows = e->pencil->layout.rows * e->nx, nz = e->nz;
  const PetscReal *pu;

  PetscFunctionBegin;
  PetscCall(SlipGatherGet(&e->gather, u, &pu));
  for (PetscInt c = 0; c < e->n; c++) {
    for (PetscInt i = 0; i < rows; i++) e->field[i] = e->vector ? pu[e->n * i + c] : e->share[c][i] * pu[i];
    PetscCall(SlipTransposedFFTForward(e->pencil, e->field));
    if (e->n > 1) CopyWaves(e, c ? 1 : 0, e->pencil->by_wave, 2 * nz, e->waves + 2 * c * nz, 2 * e->n * nz);
  }
  PetscCall(SlipGatherRestore(&e->gather, u, &pu));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies f [n nz] complex, in place, by the block of local wavenumber k, by transforms in depth. */
static PetscErrorCode ApplySymbol(Engine *e, PetscInt k, PetscReal f[])
{
  const PetscInt n = e->n, nz = e->nz, Q = e->depth_period, half = Q / 2 + 1;
  const PetscReal *symbol = e->stiffness + (size_t)k * n * (n + 1) / 2 * half;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < n; c++) {
    PetscCall(PetscArraycpy(e->column + 2 * c * Q, f + 2 * c * nz, 2 * nz));
    PetscCall(PetscArrayzero(e->column + 2 * (c * Q + nz), 2 * (Q - nz)));
  }
  fftw_execute(e->depth[0]);
  for (PetscInt q = 0; q < Q; q++) {
    const PetscReal *at = symbol + (q < half ? q : Q - q), sign = q < half ? 1 : -1;
    PetscReal y[3][2] = {{0}};

    for (PetscInt c = 0; c < n; c++)
      for (PetscInt d = c; d < n; d++, at += half) {
        const PetscReal *x = e->column + 2 * (c * Q + q), *z = e->column + 2 * (d * Q + q);
        const PetscBool odd = (PetscBool)(e->component[c] == 0 && e->component[d] != 0);

        if (!odd) {
          for (int p = 0; p < 2; p++) y[c][p] += *at * z[p];
          for (int p = 0; p < 2 && d > c; p++) y[d][p] += *at * x[p];
          continue;
        }
        for (int p = 0; p < 2; p++) { /* times i sign *at above the diagonal, and its conjugate below */
          y[c][p] += (p ? sign : -sign) * *at * z[1 - p];
          y[d][p] -= (p ? sign : -sign) * *at * x[1 - p];
        }
      }
    for (PetscInt c = 0; c < n; c++)
      for (int p = 0; p < 2; p++) e->column[2 * (c * Q + q) + p] = y[c][p];
  }
  fftw_execute(e->depth[1]);
  for (PetscInt c = 0; c < n; c++) PetscCall(PetscArraycpy(f + 2 * c * nz, e->column + 2 * c * Q, 2 * nz));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies by the blocks of all wavenumbers, of one matrix or of both at each wavenumber; shear overwrites slip. */
static PetscErrorCode ApplyBlocks(Engine *e, PetscBool shear, PetscBool normal)
{
  const PetscInt nz = e->nz, m = e->n * nz;
  const size_t half = SlipSymmetricHalf(m, NULL, NULL);

  PetscFunctionBegin;
  for (PetscInt k = 0; k < e->pencil->layout.columns; k++) {
    PetscReal *f = e->waves + (size_t)2 * k * m;

    if (normal)
      SlipGeneralProduct(nz, m, e->normal + (size_t)k * nz * m, f, e->normal_waves + (size_t)2 * k * nz, e->column);
    if (shear && e->depth_period)
      PetscCall(ApplySymbol(e, k, f));
    else if (shear)
      SlipSymmetricProduct(m, PETSC_TRUE, e->stiffness + k * half, f, e->column);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes f = scale times shear along the rakes, or all components of stress drop. Collective. */
static PetscErrorCode BackwardShear(Engine *e, PetscReal scale, Vec f)
{
  const PetscInt rows = e->pencil->layout.rows * e->nx, nz = e->nz;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < e->n; c++) {
    if (e->n > 1) CopyWaves(e, c ? -1 : 0, e->waves + 2 * c * nz, 2 * e->n * nz, e->pencil->by_wave, 2 * nz);
    PetscCall(SlipTransposedFFTBackward(e->pencil, scale, e->field));
    for (PetscInt i = 0; i < rows && e->vector; i++) e->y[e->n * i + c] = e->field[i];
    for (PetscInt i = 0; i < rows && !e->vector; i++) e->y[i] = (c ? e->y[i] : 0) + e->share[c][i] * e->field[i];
  }
  PetscCall(SlipGatherPut(&e->gather, e->y, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes n = scale times compression; slip up dip alone has no factor i. Collective. */
static PetscErrorCode BackwardNormal(Engine *e, PetscReal scale, Vec n)
{
  PetscFunctionBegin;
  CopyWaves(e, e->component[0] == 0 ? -1 : 0, e->normal_waves, 2 * e->nz, e->pencil->by_wave, 2 * e->nz);
  PetscCall(SlipTransposedFFTBackward(e->pencil, scale, e->y));
  PetscCall(SlipGatherPut(e->vector ? &e->normal_gather : &e->gather, e->y, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Logs the flops as of radix-2 transforms of pairs of rows, 2.5 P log2 P each. */
static PetscErrorCode LogFlops(const Engine *e, PetscBool shear, PetscBool normal)
{
  const PetscLogDouble P = (PetscLogDouble)e->pencil->period, rows = (PetscLogDouble)e->pencil->layout.rows;
  const PetscLogDouble nk = (PetscLogDouble)e->pencil->layout.columns, nz = (PetscLogDouble)e->nz;
  const PetscLogDouble n = (PetscLogDouble)e->n, transforms = n * (shear ? 2 : 1) + (normal ? 1 : 0);

  PetscFunctionBegin;
  PetscCall(SlipWorkFlops(SLIP_WORK_TRANSFORM, 2.5 * transforms * rows * P * PetscLog2Real(P)));
  if (e->depth_period && !e->device) {
    const PetscLogDouble Q = (PetscLogDouble)e->depth_period;

    PetscCall(SlipWorkFlops(SLIP_WORK_TRANSFORM, nk * Q * (10 * n * PetscLog2Real(Q) + 4 * n * n)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipWorkFlops(SLIP_WORK_BLOCK, 4 * nk * nz * nz * n * ((shear ? n : 0) + (normal ? 1 : 0))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrices ---- */

static PetscErrorCode DippingDevice(Mat A, PetscBool use, PetscReal *bytes)
{
  SlipBlocksShape shape;
  Dipping *d;
  Engine *e;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  e = d->engine;
  shape = (SlipBlocksShape){.nx = e->nx,
                            .nz = e->nz,
                            .period = e->pencil->period,
                            .n = e->n,
                            .share = {e->share[0], e->share[1]},
                            .half = PETSC_TRUE,
                            .strike = (PetscBool)(e->component[0] == 0)};
  *bytes = SlipBlocksDeviceBytes(&shape, d->normal);
  if (!use) PetscFunctionReturn(PETSC_SUCCESS);
  if (!e->device) PetscCall(SlipBlocksDeviceCreate(&shape, &e->device));
  if (d->normal)
    PetscCall(SlipBlocksDevicePutNormal(e->device, e->normal));
  else if (!e->depth_period)
    PetscCall(SlipBlocksDevicePutShear(e->device, e->stiffness));
  else {
    PetscReal *blocks;

    PetscCall(SlipDippingBlocks(PetscObjectComm((PetscObject)A), &e->grid, e->pencil->period, e->pencil->layout.columns,
                                e->n, e->component, &blocks, NULL));
    PetscCall(SlipBlocksDevicePutShear(e->device, blocks));
    free(blocks);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DippingMult(Mat A, Vec u, Vec y)
{
  Dipping *d;
  Engine *e;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  e = d->engine;
  PetscCall(Forward(e, u));
  PetscCall(ApplyBlocks(e, (PetscBool)!d->normal, d->normal));
  PetscCall(d->normal ? BackwardNormal(e, d->scale, y) : BackwardShear(e, d->scale, y));
  PetscCall(LogFlops(e, (PetscBool)!d->normal, d->normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DippingDeviceMult(Mat A, Vec u, Vec y)
{
  Dipping *d;
  Engine *e;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  e = d->engine;
  PetscCall(SlipBlocksDeviceForward(e->device, u));
  PetscCall(d->normal ? SlipBlocksDeviceNormal(e->device, d->scale, y) : SlipBlocksDeviceShear(e->device, d->scale, y));
  PetscCall(LogFlops(e, (PetscBool)!d->normal, d->normal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes both products at once if K was created with this Kn. */
static PetscErrorCode MultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n, PetscBool device)
{
  Dipping *k, *kn;
  PetscBool together;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(Kn, &kn));
  PetscCall(PetscObjectTypeCompare((PetscObject)K, TYPE, &together));
  if (together) {
    PetscCall(MatShellGetContext(K, &k));
    together = (PetscBool)(k->engine == kn->engine && !k->normal);
  }
  if (!together) {
    PetscCall(MatMult(K, u, f));
    PetscCall(MatMult(Kn, u, n));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscLogEventBegin(SLIP_StiffnessMult, K, u, f, n));
  SlipWorkBegin(SLIP_SHARE_PRODUCTS);
  SlipWorkAdd(SLIP_WORK_PRODUCT, 2);
  if (device) {
    PetscCall(SlipBlocksDeviceForward(kn->engine->device, u));
    PetscCall(SlipBlocksDeviceShear(kn->engine->device, k->scale, f));
    PetscCall(SlipBlocksDeviceNormal(kn->engine->device, kn->scale, n));
  } else {
    PetscCall(Forward(kn->engine, u));
    PetscCall(ApplyBlocks(kn->engine, PETSC_TRUE, PETSC_TRUE));
    PetscCall(BackwardShear(kn->engine, k->scale, f));
    PetscCall(BackwardNormal(kn->engine, kn->scale, n));
  }
  PetscCall(LogFlops(kn->engine, PETSC_TRUE, PETSC_TRUE));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessMult, K, u, f, n));
  SlipWorkEnd();
  SlipProductsAdd((SlipProducts){.k = 2, .all = 2});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MatSlipStiffnessMultBoth() of this type */
static PetscErrorCode DippingMultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n)
{
  return MultBoth(K, Kn, u, f, n, PETSC_FALSE);
}

static PetscErrorCode DippingDeviceBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n)
{
  return MultBoth(K, Kn, u, f, n, PETSC_TRUE);
}

static PetscErrorCode DippingGetDiagonal(Mat A, Vec diagonal)
{
  Dipping *d;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  PetscCall(VecCopy(d->diagonal, diagonal));
  PetscCall(VecScale(diagonal, d->scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DippingScale(Mat A, PetscScalar a)
{
  Dipping *d;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  d->scale *= PetscRealPart(a);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the numbers on this process, of blocks and of the rest, which counts for K, or for Kn when it is alone. */
static PetscReal BlockNumbers(const Dipping *d)
{
  const Engine *e = d->engine;
  const PetscInt m = e->n * e->nz;

  if (e->depth_period)
    return (PetscReal)e->pencil->layout.columns * (PetscReal)(e->n * (e->n + 1) / 2 * (e->depth_period / 2 + 1));
  return (PetscReal)e->pencil->layout.columns *
         (d->normal ? (PetscReal)e->nz * (PetscReal)m : (PetscReal)SlipSymmetricHalf(m, NULL, NULL));
}

static PetscErrorCode DippingGetInfo(Mat A, MatInfoType flag, MatInfo *info)
{
  PetscReal bytes, rows, nk;
  const Engine *e;
  Dipping *d;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  e = d->engine;
  rows = (PetscReal)e->pencil->layout.rows * (PetscReal)e->nx;
  nk = (PetscReal)e->pencil->layout.columns * (PetscReal)e->nz;
  bytes = BlockNumbers(d) + (d->normal ? 2 * nk : 0);
  if (!d->normal || e->users == 1)
    bytes += (PetscReal)(e->vector ? e->n + 1 : e->n + 2) * rows + (e->n > 1 ? 4 * nk : 0);
  bytes *= (PetscReal)sizeof(PetscReal);
  if (!d->normal || e->users == 1) bytes += SlipTransposedFFTBytes(e->pencil) + SlipGatherBytes(&e->gather);
  if (d->normal) bytes += SlipGatherBytes(&e->normal_gather);
  PetscCall(SlipInfoFill(A, bytes, flag, info));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DippingView(Mat A, PetscViewer viewer)
{
  PetscReal numbers[2];
  const Engine *e;
  Dipping *d;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  e = d->engine;
  numbers[0] = numbers[1] = BlockNumbers(d);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &numbers[0], 1, MPIU_REAL, MPIU_SUM, PetscObjectComm((PetscObject)A)));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &numbers[1], 1, MPIU_REAL, MPIU_MAX, PetscObjectComm((PetscObject)A)));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "%s of a dipping plane: %" PetscInt_FMT " x %" PetscInt_FMT
                                   " cells, slip %s, %" PetscInt_FMT " wavenumbers\n",
                                   d->normal ? "normal stress" : "stiffness", e->nx, e->nz,
                                   e->n > 2          ? "as a vector, and opening"
                                   : e->vector       ? "as a vector"
                                   : e->n > 1        ? "of any rake"
                                   : e->component[0] ? "up or down dip"
                                                     : "along strike",
                                   e->pencil->period / 2 + 1));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "%s: %.1f MB, at most %.1f MB on one process\n", e->depth_period ? "transforms of blocks" : "blocks",
    (double)(1e-6 * sizeof(PetscReal) * numbers[0]), (double)(1e-6 * sizeof(PetscReal) * numbers[1])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Destroys the blocks of one matrix with it, and the rest with the second one. */
static PetscErrorCode DippingDestroy(Mat A)
{
  Dipping *d;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &d));
  if (d->engine) {
    PetscReal **blocks = d->normal ? &d->engine->normal : &d->engine->stiffness;

    free(*blocks);
    *blocks = NULL;
  }
  PetscCall(VecDestroy(&d->diagonal));
  PetscCall(EngineDestroy(&d->engine));
  PetscCall(PetscFree(d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the diagonal for the cells of this rank, for a square matrix; terms between strike and dip are zero there. */
static PetscErrorCode FillDiagonal(Mat A, const SlipDippingGrid *g, Dipping *d)
{
  const PetscInt components = d->engine->vector ? d->engine->n : 1;
  PetscReal *a, shear[3] = {0, 0, 0}, normal[3] = {0, 0, 0}, part[2];
  PetscInt start, end, row = -1;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, NULL, &d->diagonal));
  PetscCall(VecGetOwnershipRange(d->diagonal, &start, &end));
  PetscCall(VecGetArrayWrite(d->diagonal, &a));
  for (PetscInt i = start; i < end; i++) {
    if (i / components / g->grid.nx != row) {
      row = i / components / g->grid.nx;
      PetscCall(SlipDippingOwn(g, row, shear, normal));
    }
    if (d->engine->vector) {
      a[i - start] = shear[i % components];
      continue;
    }
    SlipDegrees(g->rake[i], &part[1], &part[0]);
    a[i - start] = d->normal ? part[0] * normal[0] + part[1] * normal[1]
                             : PetscSqr(part[0]) * shear[0] + PetscSqr(part[1]) * shear[1];
  }
  PetscCall(VecRestoreArrayWrite(d->diagonal, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateOne(MPI_Comm comm, const SlipDippingGrid *grid, Engine *engine, PetscBool normal, Mat *A)
{
  const PetscInt columns = engine->vector ? engine->n : 1, rows = normal ? 1 : columns;
  const SlipShellOps ops = {.mult = DippingMult,
                            .diagonal = rows == columns ? DippingGetDiagonal : NULL,
                            .scale = DippingScale,
                            .view = DippingView,
                            .info = DippingGetInfo,
                            .destroy = DippingDestroy,
                            .device = DippingDevice,
                            .device_mult = DippingDeviceMult,
                            .device_both = DippingDeviceBoth,
                            .unsymmetric = normal};
  PetscInt N = engine->nx * engine->nz, n = PETSC_DECIDE;
  Dipping *d;

  PetscFunctionBegin;
  PetscCall(PetscSplitOwnership(comm, &n, &N));
  PetscCall(PetscNew(&d));
  d->scale = 1;
  d->normal = normal;
  d->engine = engine;
  engine->users++;
  PetscCall(SlipShellCreateOfSize(comm, rows * n, columns * n, rows * N, columns * N, TYPE, &ops, d, A));
  if (rows == columns) PetscCall(FillDiagonal(*A, grid, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool SlipDippingTransforms(const SlipKernel *kernel)
{
  return (PetscBool)(kernel->type->plane && kernel->average == SLIP_AVERAGE_CENTRE);
}

/* Creates K, and Kn unless it is NULL, for a grid and a kernel that have been checked. Collective. */
PetscErrorCode SlipDippingCreate_FFT(MPI_Comm comm, const SlipDippingGrid *grid, Mat *K, Mat *Kn)
{
  const SlipKernel *kernel = &grid->grid.kernel;
  Engine *e = NULL;

  PetscFunctionBegin;
  PetscCheck(
    SlipDippingTransforms(kernel), comm, PETSC_ERR_SUP,
    "Kernel \"%s\" has no stress on a whole plane, which type fft needs: expected one that has, at centres, such as "
    "SlipKernelDipping, or type dense or hmat",
    kernel->type->name);
  PetscCall(EngineCreate(comm, grid, Kn ? PETSC_TRUE : PETSC_FALSE, &e));
  PetscCall(CreateOne(comm, grid, e, PETSC_FALSE, K));
  PetscCall(SlipGatherCreate(*K, e->pencil, &e->gather));
  if (!Kn) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CreateOne(comm, grid, e, PETSC_TRUE, Kn));
  if (e->vector) PetscCall(SlipGatherCreate(*Kn, e->pencil, &e->normal_gather));
  PetscCall(PetscObjectComposeFunction((PetscObject)*Kn, "MatSlipStiffnessMultBoth_C", DippingMultBoth));
  PetscFunctionReturn(PETSC_SUCCESS);
}
