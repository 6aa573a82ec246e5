/* Stiffness of type "slipfft": exact products by transforms along strike, and in depth by transforms or by a block per
   wavenumber, whichever is faster. */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipmatgrid.h>

typedef struct {
  SlipGrid grid;
  Vec border;              /* SLIP_AVERAGE_WHOLE: terms of cells at the border besides the kernel; otherwise NULL */
  Vec work;                /* only with border */
  SlipToeplitz plane;      /* borrowed from the matrix itself; NULL with blocks */
  SlipCirculant strike;    /* borrowed from the matrix itself, with blocks */
  PetscInt depth;          /* row of Depths */
  PetscBool ready;         /* transform was set, at first use */
  PetscBool transform;     /* transforms in depth instead of blocks */
  PetscReal scale;         /* factor of MatScale() */
  PetscInt start, end;     /* rows of this process */
  SlipGather gather;       /* only with blocks */
  PetscReal *y;            /* [N], only with blocks */
  SlipToeplitz there;      /* for products on the device by transforms in depth; NULL: not in use */
  SlipBlocksDevice blocks; /* for products on the device by blocks; NULL: not in use */
  Vec border_there, work_there;
} FFTContext;

/* Cells in depth up to which a block per wavenumber is as fast as transforms: measured along 100 cells with AVX2; with
   AVX-512 transforms of 40 take three quarters of the time. */
#define DEPTH_BLOCKS_MAX 30

static const char *const Depths[] = {"auto", "blocks", "transform"};

/* Chooses at first use how depth is treated, and creates the engine of that. */
static PetscErrorCode MatSetUp_SlipFFT(Mat K, FFTContext *c)
{
  PetscInt N;

  PetscFunctionBegin;
  if (c->ready) PetscFunctionReturn(PETSC_SUCCESS);
  c->transform = (PetscBool)(c->depth == 2 ||
                             (c->depth == 0 && c->grid.nz > DEPTH_BLOCKS_MAX && SlipKernelTransforms(&c->grid.kernel)));
  if (c->transform)
    PetscCall(SlipToeplitzOfGrid(K, &c->grid, &c->plane));
  else {
    PetscCall(MatGetSize(K, &N, NULL));
    PetscCall(PetscMalloc1(N, &c->y));
    PetscCall(SlipCirculantOfGrid(K, &c->grid, &c->strike));
    PetscCall(SlipGatherCreate(K, SlipCirculantPencil(c->strike), &c->gather));
  }
  c->ready = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = scale * (kernel of the grid) x. */
static PetscErrorCode KernelMult(FFTContext *c, Vec x, Vec y)
{
  const PetscReal *px;

  PetscFunctionBegin;
  if (c->transform) {
    PetscCall(SlipToeplitzApply(c->plane, c->scale, SlipToeplitzStiffness(c->plane), x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipGatherGet(&c->gather, x, &px));
  PetscCall(SlipCirculantApplyStiffness(c->strike, c->scale, px, c->y));
  PetscCall(SlipGatherRestore(&c->gather, x, &px));
  PetscCall(SlipGatherPut(&c->gather, c->y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the matrix on the device, with transforms in depth if the kernel allows them, otherwise with a block per
   wavenumber. */
static PetscErrorCode FFTDevice(Mat K, PetscBool use, PetscReal *bytes)
{
  const PetscReal *symbol;
  SlipBlocksShape shape;
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  shape = (SlipBlocksShape){.nx = c->grid.nx, .nz = c->grid.nz, .period = SlipGoodLength(2 * c->grid.nx - 1), .n = 1};
  if (SlipKernelTransforms(&c->grid.kernel)) {
    *bytes = SlipToeplitzDeviceBytes(c->grid.nx, c->grid.nz);
    if (use) {
      PetscCall(SlipToeplitzOfGrid(K, &c->grid, &c->there));
      PetscCall(SlipToeplitzDevicePut(c->there, &c->there->stiffness));
    }
  } else {
    *bytes = SlipBlocksDeviceBytes(&shape, PETSC_FALSE);
    if (use) {
      PetscCall(SlipCirculantOfGrid(K, &c->grid, &c->strike));
      SlipCirculantGet(c->strike, NULL, NULL, NULL, &symbol);
      PetscCall(SlipBlocksDeviceCreate(&shape, &c->blocks));
      PetscCall(SlipBlocksDevicePutShear(c->blocks, symbol));
    }
  }
  if (!c->border) PetscFunctionReturn(PETSC_SUCCESS);
  *bytes += 2 * (PetscReal)sizeof(PetscReal) * (PetscReal)(c->end - c->start);
  if (use) {
    PetscCall(SlipVecCopyThere(c->border, &c->border_there));
    PetscCall(VecDuplicate(c->border_there, &c->work_there));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTDeviceMult(Mat K, Vec x, Vec y)
{
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  if (c->there)
    PetscCall(SlipToeplitzMult(c->there, c->scale, &c->there->stiffness, x, y));
  else {
    PetscCall(SlipBlocksDeviceForward(c->blocks, x));
    PetscCall(SlipBlocksDeviceShear(c->blocks, c->scale, y));
  }
  if (!c->border) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecPointwiseMult(c->work_there, c->border_there, x));
  PetscCall(VecAXPY(y, c->scale, c->work_there));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTMult(Mat K, Vec x, Vec y)
{
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(MatSetUp_SlipFFT(K, c));
  PetscCall(KernelMult(c, x, y));
  if (!c->border) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecPointwiseMult(c->work, c->border, x));
  PetscCall(VecAXPY(y, c->scale, c->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTGetDiagonal(Mat K, Vec d)
{
  FFTContext *c;
  PetscReal *pd;
  PetscInt depth = -1;
  PetscReal entry = 0;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(VecGetArrayWrite(d, &pd));
  for (PetscInt i = c->start; i < c->end; i++) {
    if (i / c->grid.nx != depth) {
      depth = i / c->grid.nx;
      entry = c->scale * SlipGridEntry(&c->grid, 0, depth, depth);
    }
    pd[i - c->start] = entry;
  }
  PetscCall(VecRestoreArrayWrite(d, &pd));
  if (c->border) PetscCall(VecAXPY(d, c->scale, c->border));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTScale(Mat K, PetscScalar a)
{
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  c->scale *= PetscRealPart(a);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes all entries by a product per depth instead of one per cell: entries depend on the depths of two cells and on
   their distance along strike, so that the columns of the first cell of each depth contain all of them. */
static PetscErrorCode FFTEntries(Mat K, Mat dense)
{
  FFTContext *c;
  PetscInt nx, lda;
  VecScatter scatter;
  Vec x, y, all;
  PetscReal *a;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  nx = c->grid.nx;
  PetscCall(MatCreateVecs(K, &x, &y));
  PetscCall(VecScatterCreateToAll(y, &scatter, &all));
  PetscCall(MatDenseGetLDA(dense, &lda));
  PetscCall(MatDenseGetArrayWrite(dense, &a));
  for (PetscInt jz = 0; jz < c->grid.nz; jz++) {
    const PetscInt first = jz * nx;
    const PetscReal *column;

    PetscCall(VecZeroEntries(x));
    if (first >= c->start && first < c->end) PetscCall(VecSetValue(x, first, 1, INSERT_VALUES));
    PetscCall(VecAssemblyBegin(x));
    PetscCall(VecAssemblyEnd(x));
    PetscCall(MatMult(K, x, y));
    PetscCall(VecScatterBegin(scatter, y, all, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecScatterEnd(scatter, y, all, INSERT_VALUES, SCATTER_FORWARD));
    PetscCall(VecGetArrayRead(all, &column));
    for (PetscInt jx = 0; jx < nx; jx++) {
      PetscReal *entry = a + (size_t)(first + jx) * lda;

      for (PetscInt row = c->start / nx * nx; row < c->end; row += nx) { /* all cells of a depth */
        for (PetscInt i = PetscMax(row, c->start); i < PetscMin(row + jx, c->end); i++)
          entry[i - c->start] = column[row + jx - (i - row)];
        for (PetscInt i = PetscMax(row + jx, c->start); i < PetscMin(row + nx, c->end); i++)
          entry[i - c->start] = column[i - jx];
      }
      if (c->border && first + jx >= c->start && first + jx < c->end)
        entry[first + jx - c->start] += c->scale * (SlipGridBorder(&c->grid, jx, jz) - SlipGridBorder(&c->grid, 0, jz));
    }
    PetscCall(VecRestoreArrayRead(all, &column));
  }
  PetscCall(MatDenseRestoreArrayWrite(dense, &a));
  PetscCall(MatAssemblyBegin(dense, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(dense, MAT_FINAL_ASSEMBLY));
  PetscCall(MatSetOption(dense, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(VecScatterDestroy(&scatter));
  PetscCall(VecDestroy(&all));
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTToDense(Mat K, MatType type, MatReuse reuse, Mat *D)
{
  PetscInt n, N;
  Mat dense;

  PetscFunctionBegin;
  (void)type;
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(MatGetLocalSize(K, &n, NULL));
  PetscCall(MatCreateDense(PetscObjectComm((PetscObject)K), n, n, N, N, NULL, &dense));
  PetscCall(FFTEntries(K, dense));
  PetscCall(SlipShellReplace(K, dense, reuse, D));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the memory of products, unless these are on the device. Collective, as it creates the engine. */
static PetscErrorCode FFTGetInfo(Mat K, MatInfoType flag, MatInfo *info)
{
  FFTContext *c;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(MatGetSize(K, &N, NULL));
  if (!c->there && !c->blocks) PetscCall(MatSetUp_SlipFFT(K, c));
  PetscCall(SlipInfoFill(
    K,
    SlipCirculantBytes(K) + (c->plane ? SlipToeplitzBytes(c->plane) : 0) + SlipGatherBytes(&c->gather) +
      (PetscReal)sizeof(PetscReal) * (PetscReal)((c->y ? N : 0) + (c->border ? 2 * (c->end - c->start) : 0)),
    flag, info));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTSetDepth(Mat K, const char type[])
{
  FFTContext *c;
  PetscInt depth;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(PetscEListFind(3, Depths, type, &depth, &known));
  PetscCheck(known, PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_UNKNOWN_TYPE,
             "Depth cannot be treated by \"%s\", expected auto, blocks or transform", type);
  PetscCheck(!c->ready || depth == c->depth, PetscObjectComm((PetscObject)K), PETSC_ERR_ORDER,
             "How depth is treated must be chosen before the first product");
  PetscCheck(depth != 2 || SlipKernelTransforms(&c->grid.kernel), PetscObjectComm((PetscObject)K), PETSC_ERR_SUP,
             "Kernel \"%s\" has no transforms in depth, expected auto or blocks", c->grid.kernel.type->name);
  c->depth = depth;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTDestroy(Mat K)
{
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(SlipBlocksDeviceDestroy(&c->blocks));
  PetscCall(VecDestroy(&c->border_there));
  PetscCall(VecDestroy(&c->work_there));
  PetscCall(SlipGatherDestroy(&c->gather));
  PetscCall(VecDestroy(&c->border));
  PetscCall(VecDestroy(&c->work));
  PetscCall(PetscFree(c->y));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStiffnessCreate_FFT(MPI_Comm comm, const SlipGrid *grid, Mat *K)
{
  const SlipShellOps ops = {.mult = FFTMult,
                            .diagonal = FFTGetDiagonal,
                            .scale = FFTScale,
                            .info = FFTGetInfo,
                            .destroy = FFTDestroy,
                            .device = FFTDevice,
                            .device_mult = FFTDeviceMult};
  const PetscInt N = grid->nx * grid->nz;
  FFTContext *c;
  PetscReal *b;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->scale = 1;
  c->grid = *grid;
  PetscCall(SlipShellCreateOfSize(comm, PETSC_DECIDE, PETSC_DECIDE, N, N, "slipfft", &ops, c, K));
  PetscCall(PetscObjectComposeFunction((PetscObject)*K, "MatSlipStiffnessSetDepth_C", FFTSetDepth));
  PetscCall(PetscObjectComposeFunction((PetscObject)*K, "MatConvert_slipfft_dense_C", FFTToDense));
  PetscCall(MatGetOwnershipRange(*K, &c->start, &c->end));
  if (grid->kernel.average == SLIP_AVERAGE_WHOLE) {
    PetscCall(MatCreateVecs(*K, &c->border, NULL));
    PetscCall(VecDuplicate(c->border, &c->work));
    PetscCall(VecGetArrayWrite(c->border, &b));
    for (PetscInt i = c->start; i < c->end; i++)
      b[i - c->start] = SlipGridBorder(&c->grid, i % c->grid.nx, i / c->grid.nx);
    PetscCall(VecRestoreArrayWrite(c->border, &b));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
