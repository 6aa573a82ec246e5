/* Stiffness of type "slipfft": products by one FFT along strike and a block per wavenumber; exact. */
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

typedef struct {
  SlipStrike strike; /* borrowed from the matrix itself */
  PetscReal scale;   /* what MatScale() asked for */
  SlipGather gather;
  PetscReal *y; /* [N] */
} FFTContext;

static PetscErrorCode FFTMult(Mat K, Vec x, Vec y)
{
  FFTContext *c;
  const PetscReal *px, *symbol;
  PetscReal *py;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  if (!c->strike) PetscCall(SlipStrikeOf(K, &c->strike));
  SlipStrikeGet(c->strike, NULL, NULL, NULL, &symbol);
  PetscCall(SlipGatherGet(&c->gather, x, &px));
  PetscCall(SlipStrikeApply(c->strike, c->scale, symbol, px, c->y));
  PetscCall(SlipGatherRestore(&c->gather, x, &px));
  PetscCall(VecGetArrayWrite(y, &py));
  PetscCall(PetscArraycpy(py, c->y + c->gather.start, c->gather.end - c->gather.start));
  PetscCall(VecRestoreArrayWrite(y, &py));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTGetDiagonal(Mat K, Vec d)
{
  FFTContext *c;
  const SlipGrid *grid;
  PetscReal *pd, *block;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(SlipGridOf(K, &grid));
  PetscCall(PetscMalloc1(grid->nz * grid->nz, &block));
  SlipGridKernel(grid, 0, block);
  PetscCall(VecGetArrayWrite(d, &pd));
  for (PetscInt i = c->gather.start; i < c->gather.end; i++)
    pd[i - c->gather.start] = c->scale * block[(i / grid->nx) * (grid->nz + 1)];
  PetscCall(VecRestoreArrayWrite(d, &pd));
  PetscCall(PetscFree(block));
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

static PetscErrorCode FFTDestroy(Mat K)
{
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  PetscCall(SlipGatherDestroy(&c->gather));
  PetscCall(PetscFree(c->y));
  PetscCall(PetscFree(c));
  PetscCall(PetscObjectComposeFunction((PetscObject)K, "MatConvert_slipfft_dense_C", NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStiffnessCreate_FFT(MPI_Comm comm, const SlipGrid *grid, Mat *K)
{
  const PetscInt N = grid->nx * grid->nz;
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->scale = 1;
  PetscCall(MatCreateShell(comm, PETSC_DECIDE, PETSC_DECIDE, N, N, c, K));
  PetscCall(MatSetUp(*K));
  PetscCall(MatShellSetManageScalingShifts(*K));
  PetscCall(MatShellSetOperation(*K, MATOP_MULT, SlipMatShellFn(FFTMult)));
  PetscCall(MatShellSetOperation(*K, MATOP_MULT_TRANSPOSE, SlipMatShellFn(FFTMult)));
  PetscCall(MatShellSetOperation(*K, MATOP_GET_DIAGONAL, SlipMatShellFn(FFTGetDiagonal)));
  PetscCall(MatShellSetOperation(*K, MATOP_SCALE, SlipMatShellFn(FFTScale)));
  PetscCall(MatShellSetOperation(*K, MATOP_DESTROY, SlipMatShellFn(FFTDestroy)));
  PetscCall(SlipShellFinish(*K, "slipfft"));
  PetscCall(SlipGatherCreate(*K, &c->gather));
  PetscCall(PetscMalloc1(N, &c->y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
