/*
  PCSLIPSTAGE: an approximate inverse of the Jacobian on the sliding set,

     y = m . P (m . r) + (1 - m) . r,

  where m is the 0/1 mask of sliding cells. On a uniform grid P is the part on the fault of the inverse of the stage
  operator on an endless plane (toeplitz_root.c), which has errors along the fault's edges: it stores one number for
  each pair of wavenumbers and takes O(N log N) work. Elsewhere P is the inverse diagonal, or for cells of several
  components the inverse of diag(B) and slope in a block per cell. P, and with it the whole, is positive definite for
  any slope.

  Two alternatives were slower: the inverse made periodic along strike, a block of nz^2 numbers per wavenumber (60 x 60
  under `heuristic`: 4.4 s against 3.9 s, 400 x 400: 75 s against 21 s), and overlapping parts of irregular cells with a
  coarse level (two faults of 4,050 cells: 27.6 s against 25.9 s for the inverse diagonal, of 3,872 cells 18.9 s against
  17.3 s).
*/
#include <petsc/private/petscimpl.h> /* prefix */
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatstage.h>
#include <math.h>
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipwork.h>

typedef struct {
  Mat B;              /* borrowed from the solver's matrix at set-up; that matrix itself if it has no parts */
  Vec mask, slope;    /* borrowed; NULL if every row is free */
  Vec cross;          /* off-diagonal entries of the slope, one per cell, borrowed; NULL with one component a cell */
  SlipToeplitz plane; /* plane of the symbol; NULL: P is the inverse diagonal */
  PetscReal *f;       /* P per pair of wavenumbers; NULL on the device, which computes it from inverse_symbol */
  SlipToeplitzInverse inverse_symbol;
  Mat sized;         /* matrix for which the vectors and f were allocated; referenced */
  Vec work, inverse; /* masked residual; inverse diagonal */
  Vec beside;        /* off-diagonal entries of the inverse, one per cell */
} PCSlipStage;

/* The largest share of the operator's symbol that weakening may subtract, so that P stays positive and bounded */
#define PC_SLOPE_LIMIT 0.9
/* Lower bound of eigenvalues over the largest: for n cells a side a stiffness has them down to about 1 / n of it */
#define PC_SMALLEST 1e-6

static PetscErrorCode ContextReset(PCSlipStage *c)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(c->f));
  PetscCall(VecDestroy(&c->work));
  PetscCall(VecDestroy(&c->inverse));
  PetscCall(VecDestroy(&c->beside));
  PetscCall(MatDestroy(&c->sized));
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

/* Computes the sum of the slope over the sliding set, divided by N: the mean slope weighted by the sliding part of the
   fault, which took the fewest iterations both on whole and on scattered sets. */
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

/* Computes P at the eigenvalues of the kernel on an endless plane; it is bounded where those of a stiffness are not
   above zero. */
static PetscErrorCode PCSlipStageSetUpSymbol(PCSlipStage *c, const SlipStageParts *parts)
{
  const PetscReal *values;
  PetscReal slope, smallest = 0;
  PetscInt nk, count;

  PetscFunctionBegin;
  PetscCall(MeanSlope(c, &slope));
  c->inverse_symbol = (SlipToeplitzInverse){.identity = parts->mass / parts->theta + parts->radiation,
                                            .root = parts->damping * PetscSqrtReal(parts->scale),
                                            .stiffness = parts->theta * parts->scale,
                                            .slope = slope,
                                            .limit = 1 - PC_SLOPE_LIMIT,
                                            .smallest = PC_SMALLEST};
  if (!c->f) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipToeplitzGetWaves(c->plane, &nk, &count, &values));
  for (PetscInt i = 0; i < nk * count; i++)
    smallest = PetscMax(smallest, PC_SMALLEST * parts->theta * parts->scale * values[i]);
  for (PetscInt i = 0; i < nk * count; i++) {
    const PetscReal k = parts->scale * values[i];
    const PetscReal symbol =
      parts->mass / parts->theta + parts->radiation + parts->damping * PetscSqrtReal(k) + parts->theta * k;

    c->f[i] = 1 / PetscMax(PetscMax(symbol + slope, (1 - PC_SLOPE_LIMIT) * symbol), smallest);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUpDiagonal(PCSlipStage *c)
{
  PetscReal *d;
  const PetscReal *slope = NULL, *mask = NULL;
  const SlipArrays arrays[] = {{c->inverse, .write = &d}, {c->slope, .read = &slope}, {c->mask, .read = &mask}};
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatGetDiagonal(c->B, c->inverse));
  PetscCall(VecGetLocalSize(c->inverse, &n));
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal size = PetscAbsReal(d[i]), shifted = size + (slope ? slope[i] * mask[i] : 0);

    d[i] = size > 0 ? 1 / PetscMax(shifted, (1 - PC_SLOPE_LIMIT) * size) : 1;
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the inverse of diag(d) + S for a slope S = [s0 c; c s1], whose eigenvalues relative to d have the lower
   limit of cells with one component: with d^-1/2 S d^-1/2 = sum e_k n_k n_k' it is sum d^-1/2 n_k n_k' d^-1/2/(1 +
   e_k) */
static void InvertBlock(PetscReal d[2], const PetscReal s[2], PetscReal c, PetscReal *beside)
{
  const PetscReal root[] = {PetscSqrtReal(d[0]), PetscSqrtReal(d[1])}, a = s[0] / d[0], b = s[1] / d[1];
  const PetscReal e = c / (root[0] * root[1]), angle = 0.5 * atan2(2 * e, a - b), n[] = {cos(angle), sin(angle)};
  const PetscReal mean = 0.5 * (a + b), half = hypot(0.5 * (a - b), e);
  const PetscReal first = 1 / PetscMax(1 + mean + half, 1 - PC_SLOPE_LIMIT);
  const PetscReal second = 1 / PetscMax(1 + mean - half, 1 - PC_SLOPE_LIMIT);

  d[0] = (first * n[0] * n[0] + second * n[1] * n[1]) / d[0];
  d[1] = (first * n[1] * n[1] + second * n[0] * n[0]) / d[1];
  *beside = (first - second) * n[0] * n[1] / (root[0] * root[1]);
}

static PetscErrorCode SetUpBlocks(PCSlipStage *c)
{
  PetscReal *d, *beside;
  const PetscReal *slope, *cross;
  const SlipArrays arrays[] = {
    {c->inverse, .write = &d}, {c->slope, .read = &slope}, {c->cross, .read = &cross}, {c->beside, .write = &beside}};
  PetscInt n, block;

  PetscFunctionBegin;
  PetscCall(MatGetDiagonal(c->B, c->inverse));
  PetscCall(VecGetLocalSize(c->inverse, &block));
  PetscCall(VecGetLocalSize(c->cross, &n));
  PetscCall(SlipArraysGet(4, arrays));
  block /= PetscMax(n, 1);
  for (PetscInt i = 0, at = 0; i < n; i++, at += block) {
    for (PetscInt k = at; k < at + block; k++) d[k] = d[k] != 0 ? PetscAbsReal(d[k]) : 1;
    InvertBlock(&d[at], &slope[at], cross[i], &beside[i]);
    for (PetscInt k = at + 2; k < at + block; k++) d[k] = 1 / d[k]; /* opening */
  }
  PetscCall(SlipArraysRestore(4, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes work <- P work for blocks; both components in a cell's plane have the same mask. */
static PetscErrorCode ApplyBlocks(PCSlipStage *c)
{
  const PetscReal *d, *beside;
  PetscReal *w;
  const SlipArrays arrays[] = {{c->inverse, .read = &d}, {c->beside, .read = &beside}, {c->work, .write = &w}};
  PetscInt n, block;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(c->beside, &n));
  PetscCall(VecGetLocalSize(c->work, &block));
  block /= PetscMax(n, 1);
  PetscCall(SlipArraysGet(3, arrays));
  for (PetscInt i = 0, k = 0; i < n; i++, k += block) {
    const PetscReal x = w[k], y = w[k + 1];

    w[k] = d[k] * x + beside[i] * y;
    w[k + 1] = beside[i] * x + d[k + 1] * y;
    if (block > 2) w[k + 2] *= d[k + 2];
  }
  PetscCall(SlipArraysRestore(3, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the parts of the operator that P inverts: a stage operator, or a stiffness alone of a uniform grid; *found is
   false for others. */
static PetscErrorCode PartsOf(Mat B, SlipStageParts *parts, PetscBool *found)
{
  const SlipGrid *g;
  PetscReal scale;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)B, "slipstage", found));
  if (*found) {
    PetscCall(SlipStageGetParts(B, parts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipGridOf(B, &g));
  *found = (PetscBool)(g != NULL);
  if (!g) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipGridScale(B, &scale));
  *parts = (SlipStageParts){.K = B, .theta = 1, .scale = scale};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PCSetUp_SlipStage(PC pc)
{
  PCSlipStage *c = NULL;
  SlipStageParts parts;
  const PetscReal *symbol;
  PetscInt nk, count;
  PetscBool found = PETSC_FALSE;
  Mat J;

  PetscFunctionBegin;
  PetscCall(PetscLogEventBegin(SLIP_PCSetUp, pc, 0, 0, 0));
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  SlipWorkBegin(SLIP_SHARE_PRODUCTS);
  SlipWorkAdd(SLIP_WORK_PRODUCT, 1);
  PetscCall(PCGetOperators(pc, NULL, &J));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipStageOperator", (PetscObject *)&c->B));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipMask", (PetscObject *)&c->mask));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipSlope", (PetscObject *)&c->slope));
  PetscCall(PetscObjectQuery((PetscObject)J, "SlipCross", (PetscObject *)&c->cross));
  if (!c->B) c->B = J;
  PetscCheck(!c->slope || c->mask, PetscObjectComm((PetscObject)pc), PETSC_ERR_ARG_WRONGSTATE,
             "The Jacobian has a slope but no mask: set its parts first");
  PetscCall(PartsOf(c->B, &parts, &found));
  if (c->sized != c->B) {
    PetscCall(ContextReset(c));
    PetscCall(PetscObjectReference((PetscObject)c->B));
    c->sized = c->B;
    PetscCall(MatCreateVecs(c->B, &c->work, &c->inverse));
    if (found && !c->cross) PetscCall(SlipToeplitzOf(parts.K, &c->plane));
    if (c->cross) PetscCall(VecDuplicate(c->cross, &c->beside));
    if (c->plane && SlipToeplitzWantsValues(c->work)) {
      PetscCall(SlipToeplitzGetWaves(c->plane, &nk, &count, &symbol));
      PetscCall(PetscMalloc1(nk * count, &c->f));
    }
  }
  if (c->plane)
    PetscCall(PCSlipStageSetUpSymbol(c, &parts));
  else if (c->cross)
    PetscCall(SetUpBlocks(c));
  else
    PetscCall(SetUpDiagonal(c));
  SlipWorkEnd();
  PetscCall(PetscLogEventEnd(SLIP_PCSetUp, pc, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Applies the preconditioner; the work vector is masked r first and P times that later. */
static PetscErrorCode PCApply_SlipStage(PC pc, Vec r, Vec z)
{
  PCSlipStage *c = NULL;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  PetscCall(PetscLogEventBegin(SLIP_PCApply, pc, r, z, 0));
  SlipWorkBegin(SLIP_SHARE_PRODUCTS);
  SlipWorkAdd(SLIP_WORK_PRODUCT, 1);
  if (c->mask)
    PetscCall(VecPointwiseMult(c->work, c->mask, r));
  else
    PetscCall(VecCopy(r, c->work));
  if (c->plane) {
    PetscCall(SlipToeplitzInvert(c->plane, &c->inverse_symbol, c->f, c->work, c->inverse));
    SlipProductsAdd((SlipProducts){.pc = 1});
  } else if (c->cross)
    PetscCall(ApplyBlocks(c));
  else
    PetscCall(VecPointwiseMult(c->work, c->work, c->inverse));
  if (c->mask) {
    PetscCall(VecGetLocalSize(r, &n));
    PetscCall(SlipLoopRun(SLIP_LOOP_CHOOSE, n, NULL, (const Vec[]){c->mask, c->work, r, z}, NULL));
  } else
    PetscCall(VecCopy(c->work, z));
  SlipWorkEnd();
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
    PetscCall(
      PetscViewerASCIIPrintf(viewer, "  inverse: %s\n",
                             c->plane ? "symbol of an endless plane" : (c->cross ? "blocks of cells" : "diagonal")));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the memory on this process besides that of the stiffness. */
static PetscErrorCode PCSlipStageGetMemory(PC pc, PetscReal *bytes)
{
  PCSlipStage *c = NULL;
  const PetscReal *symbol;
  PetscInt n = 0, nk = 0, count = 0;

  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)pc, "PCSlipStage", &c));
  if (c->sized) PetscCall(MatGetLocalSize(c->sized, &n, NULL));
  if (c->plane) PetscCall(SlipToeplitzGetWaves(c->plane, &nk, &count, &symbol));
  *bytes = (PetscReal)sizeof(PetscReal) * (PetscReal)((c->beside ? 5 * n / 2 : 2 * n) + nk * count);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -pc_slipstage_type, which has one type only; other names, those of removed types too, are refused. */
static PetscErrorCode PCSetFromOptions_SlipStage(PetscObject pc, SlipOptionItems PetscOptionsObject, void *ctx)
{
  char type[64] = "auto";
  PetscBool known, same;

  PetscFunctionBegin;
  (void)ctx;
  PetscOptionsHeadBegin(PetscOptionsObject, "Approximate inverse on the sliding set");
  PetscCall(
    PetscOptionsString("-pc_slipstage_type",
                       "symbol: of wavenumbers in both directions on a uniform grid, else the diagonal; auto is "
                       "the same",
                       "PCSLIPSTAGE", type, type, sizeof(type), NULL));
  PetscOptionsHeadEnd();
  PetscCall(PetscStrcmp(type, "auto", &known));
  PetscCall(PetscStrcmp(type, "symbol", &same));
  PetscCheck(known || same, PetscObjectComm(pc), PETSC_ERR_ARG_UNKNOWN_TYPE,
             "-%spc_slipstage_type is \"%s\", expected symbol or auto: blocks did not pay and are gone",
             pc->prefix ? pc->prefix : "", type);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  PCSLIPSTAGE - "slipstage": approximate inverse of the Jacobian of a stage on its sliding set

  Notes:
  It is for a Jacobian of type MATSLIPJACOBIAN, whose parts are composed as "SlipStageOperator", "SlipMask" and
  "SlipSlope" (and "SlipCross" where cells have two components), or for a stage operator or a stiffness alone. It is
  symmetric positive definite even where weakening makes the Jacobian indefinite, as CG and MINRES need, and uses the
  mean of the slope over the fault. On a uniform grid it is the part on the fault of the inverse on an endless plane,
  elsewhere the inverse diagonal, or a block of two rows for each cell with two components.

  Options Database Key:
. -pc_slipstage_type <auto> - symbol or auto, which are the same

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
  PetscCall(PetscObjectAddOptionsHandler((PetscObject)pc, PCSetFromOptions_SlipStage, NULL, NULL));
  PetscCall(PetscObjectComposeFunction((PetscObject)pc, "PCSlipGetMemory_C", PCSlipStageGetMemory));
  PetscFunctionReturn(PETSC_SUCCESS);
}
