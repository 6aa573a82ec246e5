/* Stiffness of type "slipfft", exact: products by transforms along strike, and in depth either by transforms too or by
   a block per wavenumber, whichever is faster. */
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>

typedef struct {
  SlipToeplitz plane;   /* borrowed from the matrix itself; NULL with blocks */
  SlipCirculant strike; /* borrowed from the matrix itself, with blocks */
  PetscInt depth;       /* row of Depths */
  PetscBool ready;      /* the choice of transform is made, at first use */
  PetscBool transform;  /* in depth, instead of blocks */
  PetscReal scale;      /* what MatScale() asked for */
  PetscInt start, end;  /* rows owned */
  SlipGather gather;    /* with blocks */
  PetscReal *y;         /* [N] with blocks */
} FFTContext;

static const char *const Depths[] = {"auto", "blocks", "transform"};

/* At first use: how depth is treated, and the engine of that. */
static PetscErrorCode MatSetUp_SlipFFT(Mat K, FFTContext *c)
{
  const SlipGrid *grid;
  PetscInt N;

  PetscFunctionBegin;
  if (c->ready) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipGridOf(K, &grid));
  c->transform = (PetscBool)(c->depth == 2 || (c->depth == 0 && grid->nz > SLIP_BLOCKS_MAX));
  if (c->transform)
    PetscCall(SlipToeplitzOf(K, &c->plane));
  else {
    PetscCall(MatGetSize(K, &N, NULL));
    PetscCall(PetscMalloc1(N, &c->y));
    PetscCall(SlipCirculantOf(K, &c->strike));
    PetscCall(SlipGatherCreate(K, SlipCirculantPencil(c->strike), &c->gather));
  }
  c->ready = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTMult(Mat K, Vec x, Vec y)
{
  FFTContext *c;
  const PetscReal *px, *symbol;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(MatSetUp_SlipFFT(K, c));
  if (c->transform) {
    PetscCall(SlipToeplitzApply(c->plane, c->scale, SlipToeplitzStiffness(c->plane), x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  SlipCirculantGet(c->strike, NULL, NULL, NULL, &symbol);
  PetscCall(SlipGatherGet(&c->gather, x, &px));
  PetscCall(SlipCirculantApply(c->strike, c->scale, symbol, px, c->y));
  PetscCall(SlipGatherRestore(&c->gather, x, &px));
  PetscCall(SlipGatherPut(&c->gather, c->y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTGetDiagonal(Mat K, Vec d)
{
  FFTContext *c;
  const SlipGrid *grid;
  PetscReal *pd;
  PetscInt depth = -1;
  PetscReal entry = 0;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(SlipGridOf(K, &grid));
  PetscCall(VecGetArrayWrite(d, &pd));
  for (PetscInt i = c->start; i < c->end; i++) {
    if (i / grid->nx != depth) {
      depth = i / grid->nx;
      entry = c->scale * SlipGridEntry(grid, 0, depth, depth);
    }
    pd[i - c->start] = entry;
  }
  PetscCall(VecRestoreArrayWrite(d, &pd));
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

static PetscErrorCode FFTGetInfo(Mat K, MatInfoType flag, MatInfo *info)
{
  FFTContext *c;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(SlipInfoFill(K,
                         SlipCirculantBytes(K) + (c->plane ? SlipToeplitzBytes(c->plane) : 0) +
                           SlipGatherBytes(&c->gather) + (PetscReal)sizeof(PetscReal) * (PetscReal)(c->y ? N : 0),
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
  c->depth = depth;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTDestroy(Mat K)
{
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(SlipGatherDestroy(&c->gather));
  PetscCall(PetscFree(c->y));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStiffnessCreate_FFT(MPI_Comm comm, const SlipGrid *grid, Mat *K)
{
  const SlipShellOps ops = {
    .mult = FFTMult, .diagonal = FFTGetDiagonal, .scale = FFTScale, .info = FFTGetInfo, .destroy = FFTDestroy};
  const PetscInt N = grid->nx * grid->nz;
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->scale = 1;
  PetscCall(SlipShellCreate(comm, PETSC_DECIDE, N, "slipfft", &ops, c, K));
  PetscCall(PetscObjectComposeFunction((PetscObject)*K, "MatSlipStiffnessSetDepth_C", FFTSetDepth));
  PetscCall(MatGetOwnershipRange(*K, &c->start, &c->end));
  PetscFunctionReturn(PETSC_SUCCESS);
}
