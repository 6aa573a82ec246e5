/* Stiffness of type "slipfft", exact: products by transforms along strike, and in depth either by transforms too or by
   a block per wavenumber, whichever is faster. */
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatgrid.h>

typedef struct {
  SlipToeplitz plane;   /* borrowed from the matrix itself at the first product; NULL with blocks */
  SlipCirculant strike; /* borrowed from the matrix itself, with blocks */
  PetscBool transform;  /* in depth, instead of blocks */
  PetscReal scale;      /* what MatScale() asked for */
  PetscInt start, end;  /* rows owned */
  SlipGather gather;    /* with blocks */
  PetscReal *y;         /* [N] with blocks */
} FFTContext;

static PetscErrorCode FFTMultTransform(Mat K, FFTContext *c, Vec x, Vec y)
{
  PetscFunctionBegin;
  if (!c->plane) PetscCall(SlipToeplitzOf(K, &c->plane));
  PetscCall(SlipToeplitzApply(c->plane, c->scale, SlipToeplitzStiffness(c->plane), x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FFTMult(Mat K, Vec x, Vec y)
{
  FFTContext *c;
  const PetscReal *px, *symbol;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(K, &c));
  if (c->transform) {
    PetscCall(FFTMultTransform(K, c, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!c->strike) {
    PetscCall(SlipCirculantOf(K, &c->strike));
    PetscCall(SlipGatherCreate(K, SlipCirculantPencil(c->strike), &c->gather));
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

/* How to treat depth: the option, or what is faster. */
static PetscErrorCode ChooseDepth(MPI_Comm comm, const SlipGrid *grid, PetscBool *transform)
{
  const char *const choices[] = {"auto", "blocks", "transform"};
  PetscInt choice = 0;

  PetscFunctionBegin;
  PetscOptionsBegin(comm, NULL, "Stiffness by fast Fourier transforms", "Mat");
  PetscCall(PetscOptionsEList("-mat_slipfft_depth",
                              "In depth: dense blocks per wavenumber, transforms as along strike, or the faster one",
                              "MatCreateSlipStiffness", choices, 3, choices[0], &choice, NULL));
  PetscOptionsEnd();
  *transform = (PetscBool)(choice == 2 || (choice == 0 && grid->nz > SLIP_BLOCKS_MAX));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStiffnessCreate_FFT(MPI_Comm comm, const SlipGrid *grid, Mat *K)
{
  const PetscInt N = grid->nx * grid->nz;
  FFTContext *c;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  c->scale = 1;
  PetscCall(ChooseDepth(comm, grid, &c->transform));
  PetscCall(MatCreateShell(comm, PETSC_DECIDE, PETSC_DECIDE, N, N, c, K));
  PetscCall(MatSetUp(*K));
  PetscCall(MatShellSetManageScalingShifts(*K));
  PetscCall(MatShellSetOperation(*K, MATOP_MULT, SlipMatShellFn(FFTMult)));
  PetscCall(MatShellSetOperation(*K, MATOP_MULT_TRANSPOSE, SlipMatShellFn(FFTMult)));
  PetscCall(MatShellSetOperation(*K, MATOP_GET_DIAGONAL, SlipMatShellFn(FFTGetDiagonal)));
  PetscCall(MatShellSetOperation(*K, MATOP_SCALE, SlipMatShellFn(FFTScale)));
  PetscCall(MatShellSetOperation(*K, MATOP_GETINFO, SlipMatShellFn(FFTGetInfo)));
  PetscCall(MatShellSetOperation(*K, MATOP_DESTROY, SlipMatShellFn(FFTDestroy)));
  PetscCall(SlipShellFinish(*K, "slipfft"));
  PetscCall(MatGetOwnershipRange(*K, &c->start, &c->end));
  if (c->transform) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(N, &c->y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
