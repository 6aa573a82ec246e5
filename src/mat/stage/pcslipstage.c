/*
  PCSLIPSTAGE: an approximate inverse of the Jacobian on the sliding set,

     y = m . P (m . r) + (1 - m) . r,

  m the 0/1 mask of sliding cells. On a uniform grid P is one of

    blocks  the inverse of the stage operator made periodic along strike (with padding, so only the two ends of the
            fault are wrong), per wavenumber by the eigenvectors of K's block: the fewest iterations, but nz^2 numbers
            for each wavenumber;
    symbol  the part on the fault of the inverse of the stage operator on an endless plane (toeplitz_root.c), wrong along
            all edges: one number for each pair of wavenumbers and O(N log N) work;

  on irregular cells the inverse in overlapping parts (schwarz.c), elsewhere the inverse diagonal. P is positive
  definite whatever the slope, so the whole is.
*/
#include <slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatstage.h>

typedef struct {
  Mat B;                /* borrowed from the solver's matrix at set-up; that matrix itself when it has no parts */
  Vec mask, slope;      /* borrowed; NULL when every row is free */
  SlipCirculant strike; /* of blocks, or NULL */
  SlipToeplitz plane;   /* of the symbol, or NULL */
  SlipSchwarz schwarz;  /* of irregular cells, or NULL; without any P is the inverse diagonal */
  PetscReal *f;         /* P per eigenvalue [nk][nz], or per pair of wavenumbers */
  PetscReal *y;         /* [N] */
  SlipGather gather;
  Mat gathered;      /* matrix that gather, f and y were sized for; referenced */
  Vec work, inverse; /* masked residual; inverse diagonal */
} PCSlipStage;

/* The largest share of the operator's symbol that weakening may take away: keeps P positive and bounded. */
#define PC_SLOPE_LIMIT 0.9
/* Eigenvalues of a stiffness of n cells a side reach down to about 1 / n of the largest. */
#define PC_SMALLEST 1e-6

static PetscErrorCode ContextReset(PCSlipStage *c)
{
  PetscFunctionBegin;
  PetscCall(SlipGatherDestroy(&c->gather));
  PetscCall(PetscFree2(c->f, c->y));
  PetscCall(VecDestroy(&c->work));
  PetscCall(VecDestroy(&c->inverse));
  PetscCall(MatDestroy(&c->gathered));
  c->strike = NULL;
  c->schwarz = NULL;
  c->plane = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ContextDestroy(SlipContainerArg arg)
{
  PCSlipStage *stage = (PCSlipStage *)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  PetscCall(ContextReset(stage));
  PetscCall(PetscFree(stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sum over all rows of slope on the sliding set, divided by N: the mean slope weighted by how much of the fault slides,
   which took the fewest iterations on whole and on scattered sets alike. */
static PetscErrorCode MeanSlope(PCSlipStage *c, PetscReal *mean)
{
  PetscScalar sum;
  PetscInt N;

  PetscFunctionBegin;
  *mean = 0;
  if (!c->slope) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDot(c->slope, c->mask, &sum));
  PetscCall(VecGetSize(c->slope, &N));
  *mean = PetscRealPart(sum) / (PetscReal)N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* f of n eigenvalues of the unscaled kernel; bounded where a stiffness alone has none above zero. */
static void InverseOf(const SlipStageParts *parts, PetscReal slope, PetscInt n, const PetscReal values[], PetscReal f[])
{
  PetscReal smallest = 0;

  for (PetscInt i = 0; i < n; i++) smallest = PetscMax(smallest, PC_SMALLEST * parts->theta * parts->scale * values[i]);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal k = parts->scale * values[i];
    const PetscReal symbol = parts->mass / parts->theta + parts->damping * PetscSqrtReal(k) + parts->theta * k;

    f[i] = 1 / PetscMax(PetscMax(symbol + slope, (1 - PC_SLOPE_LIMIT) * symbol), smallest);
  }
}

static PetscErrorCode SetUpInverse(PCSlipStage *c, const SlipStageParts *parts)
{
  const PetscReal *values;
  const SlipGrid *g;
  PetscReal slope;
  PetscInt nk, count;

  PetscFunctionBegin;
  PetscCall(MeanSlope(c, &slope));
  if (c->plane) {
    PetscCall(SlipToeplitzGetWaves(c->plane, &nk, &count, &values));
    InverseOf(parts, slope, nk * count, values, c->f);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipCirculantGetEigen(c->strike, &values, NULL));
  SlipCirculantGet(c->strike, &g, NULL, &nk, NULL);
  InverseOf(parts, slope, nk * g->nz, values, c->f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUpDiagonal(PCSlipStage *c)
{
  PetscReal *d;
  const PetscReal *slope = NULL, *mask = NULL;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatGetDiagonal(c->B, c->inverse));
  PetscCall(VecGetLocalSize(c->inverse, &n));
  PetscCall(VecGetArray(c->inverse, &d));
  if (c->slope) {
    PetscCall(VecGetArrayRead(c->slope, &slope));
    PetscCall(VecGetArrayRead(c->mask, &mask));
  }
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal size = PetscAbsReal(d[i]), shifted = size + (slope ? slope[i] * mask[i] : 0);

    d[i] = size > 0 ? 1 / PetscMax(shifted, (1 - PC_SLOPE_LIMIT) * size) : 1;
  }
  if (c->slope) {
    PetscCall(VecRestoreArrayRead(c->slope, &slope));
    PetscCall(VecRestoreArrayRead(c->mask, &mask));
  }
  PetscCall(VecRestoreArray(c->inverse, &d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How to invert on a grid: the option, or what is cheaper. */
static PetscErrorCode ChooseInverse(PC pc, PetscBool stage, const SlipGrid *g, PetscBool *blocks)
{
  const char *const choices[] = {"auto", "blocks", "symbol"};
  const char *prefix;
  PetscInt choice = 0;

  PetscFunctionBegin;
  PetscCall(PCGetOptionsPrefix(pc, &prefix));
  PetscOptionsBegin(PetscObjectComm((PetscObject)pc), prefix, "Approximate inverse on the sliding set", "PC");
  PetscCall(PetscOptionsEList("-pc_slipstage_type",
                              "On a uniform grid: a block per wavenumber along strike, a symbol of wavenumbers in both "
                              "directions, or by size",
                              "PCSLIPSTAGE", choices, 3, choices[0], &choice, NULL));
  PetscOptionsEnd();
  *blocks = (PetscBool)(choice == 1 || (choice == 0 && stage && g->nz <= SLIP_BLOCKS_MAX));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sizes what depends on the stage operator only. */
static PetscErrorCode Allocate(PC pc, PCSlipStage *c, const SlipStageParts *parts)
{
  const SlipGrid *g;
  const PetscReal *symbol;
  PetscInt nk, count, N;
  PetscBool blocks = PETSC_TRUE;

  PetscFunctionBegin;
  if (c->gathered == c->B) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ContextReset(c));
  PetscCall(PetscObjectReference((PetscObject)c->B));
  c->gathered = c->B;
  PetscCall(MatCreateVecs(c->B, &c->work, &c->inverse));
  if (!parts) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipGridOf(parts->K, &g));
  if (!g) {
    PetscCall(SlipSchwarzOf(parts->K, &c->schwarz));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ChooseInverse(pc, (PetscBool)(c->B != parts->K), g, &blocks));
  if (!blocks) {
    PetscCall(SlipToeplitzOf(parts->K, &c->plane));
    PetscCall(SlipToeplitzGetWaves(c->plane, &nk, &count, &symbol));
    PetscCall(PetscMalloc2(nk * count, &c->f, 0, &c->y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipCirculantOf(parts->K, &c->strike));
  SlipCirculantGet(c->strike, &g, NULL, &nk, NULL);
  PetscCall(MatGetSize(c->B, &N, NULL));
  PetscCall(PetscMalloc2(nk * g->nz, &c->f, N, &c->y));
  PetscCall(SlipGatherCreate(c->B, SlipCirculantPencil(c->strike), &c->gather));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What P inverts: a stage operator, or a stiffness alone; *found is false when nothing is known but entries. */
static PetscErrorCode PartsOf(Mat B, SlipStageParts *parts, PetscBool *found)
{
  const SlipCells *cells;
  const SlipGrid *g;
  PetscReal scale = 1;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)B, "slipstage", found));
  if (*found) {
    PetscCall(SlipStageGetParts(B, parts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipGridOf(B, &g));
  PetscCall(SlipCellsOf(B, &cells));
  *found = (PetscBool)(g || cells);
  if (g) PetscCall(SlipGridScale(B, &scale));
  *parts = (SlipStageParts){.K = B, .theta = 1, .scale = scale};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PCSetUp_SlipStage(PC pc)
{
  PCSlipStage *c = NULL;
  SlipStageParts parts;
  PetscReal slope;
  PetscBool found = PETSC_FALSE;
  Mat J;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(SLIP_PCSetUp, pc, 0, 0, 0));
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  PetscCall(PCGetOperators(pc, NULL, &J));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipStageOperator", (PetscObject *)&c->B));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipMask", (PetscObject *)&c->mask));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipSlope", (PetscObject *)&c->slope));
  if (!c->B) c->B = J;
  PetscCheck(!c->slope || c->mask, PetscObjectComm((PetscObject)pc), PETSC_ERR_ARG_WRONGSTATE,
             "The Jacobian has a slope but no mask: set its parts first");
  PetscCall(PartsOf(c->B, &parts, &found));
  PetscCall(Allocate(pc, c, found ? &parts : NULL));
  if (c->strike || c->plane)
    PetscCall(SetUpInverse(c, &parts));
  else if (c->schwarz) {
    PetscCall(MeanSlope(c, &slope));
    PetscCall(SlipSchwarzSetUp(c->schwarz, &parts, slope, PC_SLOPE_LIMIT));
  } else
    PetscCall(SetUpDiagonal(c));
  PetscCall(PetscLogEventEnd(SLIP_PCSetUp, pc, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* work = P work */
static PetscErrorCode ApplyInverse(PCSlipStage *c)
{
  const PetscReal *x;

  PetscFunctionBegin;
  if (c->schwarz) {
    PetscCall(SlipSchwarzApply(c->schwarz, c->work));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (c->plane) {
    PetscCall(SlipToeplitzApplyWaves(c->plane, c->f, c->work, c->work));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!c->strike) {
    PetscCall(VecPointwiseMult(c->work, c->work, c->inverse));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipGatherGet(&c->gather, c->work, &x));
  PetscCall(SlipCirculantApplyFunction(c->strike, c->f, x, c->y));
  PetscCall(SlipGatherRestore(&c->gather, c->work, &x));
  PetscCall(SlipGatherPut(&c->gather, c->y, c->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PCApply_SlipStage(PC pc, Vec r, Vec z)
{
  PCSlipStage *c = NULL;
  const PetscReal *mask, *pr, *pw;
  PetscReal *pz;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  PetscCall(PetscLogEventBegin(SLIP_PCApply, pc, r, z, 0));
  if (!c->mask) {
    PetscCall(VecCopy(r, c->work));
    PetscCall(ApplyInverse(c));
    PetscCall(VecCopy(c->work, z));
    PetscCall(PetscLogEventEnd(SLIP_PCApply, pc, r, z, 0));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecPointwiseMult(c->work, c->mask, r));
  PetscCall(ApplyInverse(c));
  PetscCall(VecGetLocalSize(r, &n));
  PetscCall(VecGetArrayRead(c->mask, &mask));
  PetscCall(VecGetArrayRead(r, &pr));
  PetscCall(VecGetArrayRead(c->work, &pw));
  PetscCall(VecGetArrayWrite(z, &pz));
  for (PetscInt i = 0; i < n; i++) pz[i] = mask[i] != 0 ? pw[i] : pr[i];
  PetscCall(VecRestoreArrayWrite(z, &pz));
  PetscCall(VecRestoreArrayRead(c->work, &pw));
  PetscCall(VecRestoreArrayRead(r, &pr));
  PetscCall(VecRestoreArrayRead(c->mask, &mask));
  PetscCall(PetscLogEventEnd(SLIP_PCApply, pc, r, z, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PCView_SlipStage(PC pc, PetscViewer viewer)
{
  PCSlipStage *c = NULL;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (ascii)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  inverse: %s\n",
                                     c->plane     ? "symbol of an endless plane"
                                     : c->strike  ? "periodic along strike, per wavenumber"
                                     : c->schwarz ? "overlapping parts of irregular cells"
                                                  : "diagonal"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What it adds to the engine of the stiffness, on this process. */
static PetscErrorCode PCSlipStageGetMemory(PC pc, PetscReal *bytes)
{
  PCSlipStage *c = NULL;
  const SlipGrid *g;
  PetscInt n = 0, N = 0, nk = 0;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  if (c->gathered) PetscCall(MatGetLocalSize(c->gathered, &n, NULL));
  *bytes = 2 * (PetscReal)n;
  if (c->strike) {
    SlipCirculantGet(c->strike, &g, NULL, &nk, NULL);
    PetscCall(MatGetSize(c->gathered, &N, NULL));
    *bytes += (PetscReal)(nk * g->nz + N);
  }
  *bytes = *bytes * (PetscReal)sizeof(PetscReal) + SlipGatherBytes(&c->gather);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  PCSLIPSTAGE - "slipstage": approximate inverse of the Jacobian of a stage on its sliding set

  Notes:
  For a Jacobian of type MATSLIPJACOBIAN, whose parts it finds composed as "SlipStageOperator", "SlipMask" and
  "SlipSlope", or for a stage operator or a stiffness alone. Symmetric positive definite even where weakening makes the
  Jacobian indefinite, as CG and MINRES need. The slope enters by its mean over the fault. On a uniform grid it is the
  inverse made periodic along strike, on irregular cells that of overlapping clusters of cells and of means over larger
  ones, and without either the inverse diagonal.

  Options Database Key:
. -pc_slipstage_type <auto> - on a uniform grid: blocks, symbol, or by size (blocks up to 60 cells in depth)

  Level: intermediate

.seealso: MatCreateSlipStage(), MatCreateSlipJacobian(), PCType
M*/
PetscErrorCode PCCreate_SlipStage(PC pc)
{
  PCSlipStage *c = NULL;

  PetscFunctionBegin;
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetSetUp(pc, PCSetUp_SlipStage));
  PetscCall(PCShellSetApply(pc, PCApply_SlipStage));
  PetscCall(PCShellSetApplyTranspose(pc, PCApply_SlipStage));
  PetscCall(PCShellSetView(pc, PCView_SlipStage));
  PetscCall(PCShellSetName(pc, "approximate inverse on the sliding set"));
  PetscCall(PetscObjectChangeTypeName((PetscObject)pc, PCSLIPSTAGE));
  PetscCall(PetscNew(&c));
  PetscCall(SlipObjectComposeData((PetscObject)pc, "PCSlipStage", c, ContextDestroy));
  PetscCall(PetscObjectComposeFunction((PetscObject)pc, "PCSlipGetMemory_C", PCSlipStageGetMemory));
  PetscFunctionReturn(PETSC_SUCCESS);
}
