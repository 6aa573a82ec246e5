/* The stage operator B(theta) = (mass / theta) I + H + theta K as a shell matrix. */
#include <petsc/private/petscimpl.h> /* prefix */
#include <slipstep/private/slipmatstage.h>

/* What MatSlipStageSetJacobian() chooses. */
enum { JACOBIAN_AUTO, JACOBIAN_EXACT, JACOBIAN_APPROXIMATE };
static const char *const Jacobians[] = {"auto", "exact", "approximate"};

/* Dense operands are summed at each theta up to this size: it costs three products and saves one in each of the tens of
   iterations at that theta, but it needs N^2 more numbers (200 MB here). */
#define SLIP_STAGE_ASSEMBLE_MAX 5000

/* Beside K and H. */
static PetscErrorCode StageGetInfo(Mat B, MatInfoType flag, MatInfo *info)
{
  SlipStageContext *s;
  const SlipGrid *g;
  PetscReal numbers;
  PetscInt m, N, nk;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCall(MatGetSize(B, &N, NULL));
  PetscCall(MatGetLocalSize(B, &m, NULL));
  numbers = (PetscReal)m;
  if (s->assemble) numbers += (PetscReal)m * (PetscReal)N;
  if (s->entries && s->entries != s->K) numbers += (PetscReal)m * (PetscReal)N;
  if (s->correction) numbers += SlipSecantVectors(s->correction) * (PetscReal)m;
  if (s->strike) {
    SlipCirculantGet(s->strike, &g, NULL, &nk, NULL);
    numbers += (PetscReal)nk * (PetscReal)(g->nz * g->nz) + (PetscReal)N;
  }
  PetscCall(SlipInfoFill(B, (PetscReal)sizeof(PetscReal) * numbers + SlipGatherBytes(&s->gather), flag, info));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageView(Mat B, PetscViewer viewer)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCall(PetscViewerASCIIPrintf(viewer, "products: %s\n",
                                   s->assemble ? "K and H summed at each theta"
                                   : s->strike ? "K and H per wavenumber, with one pair of transforms"
                                               : "with K and H apart"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What StageSetUp() made. */
static PetscErrorCode StageReset(SlipStageContext *s)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(s->blocks, s->y));
  PetscCall(MatDestroy(&s->approximation));
  PetscCall(SlipGatherDestroy(&s->gather));
  s->strike = NULL;
  s->assembled_theta = s->device_theta = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageDestroy(Mat B)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  PetscCall(StageReset(s));
  PetscCall(MatDestroy(&s->K));
  PetscCall(MatDestroy(&s->given));
  PetscCall(MatDestroy(&s->assembled));
  PetscCall(MatDestroy(&s->entries));
  PetscCall(VecDestroy(&s->diagonal));
  PetscCall(VecDestroy(&s->work));
  for (int k = 0; k < 2; k++) PetscCall(VecDestroy(&s->parts[k]));
  PetscCall(SlipToeplitzSymbolDestroy(&s->sum));
  PetscCall(SlipSecantDestroy(&s->correction));
  PetscCall(PetscFree(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One pair of transforms per wavenumber serves K and a spectral viscosity of it. */
static PetscErrorCode StageFuse(SlipStageContext *s, SlipCirculant strike)
{
  const SlipGrid *g;
  SlipCirculant own;
  PetscInt N, nk;

  PetscFunctionBegin;
  PetscCall(SlipCirculantOf(s->K, &own));
  if (own != strike) PetscFunctionReturn(PETSC_SUCCESS); /* H was made from another stiffness */
  s->strike = strike;
  PetscCall(MatGetSize(s->K, &N, NULL));
  SlipCirculantGet(strike, &g, NULL, &nk, NULL);
  PetscCall(PetscMalloc2((size_t)nk * g->nz * g->nz, &s->blocks, N, &s->y));
  PetscCall(SlipGatherCreate(s->K, SlipCirculantPencil(strike), &s->gather));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Up to so many cells the entries of K are kept for solves on small sliding sets, 72 MB of them: a factorisation of 100
   rows takes a tenth of the products that conjugate gradients need to the same residual. */
#define SLIP_STAGE_ENTRIES_MAX 3000

/* B = scale dense + diag(diagonal) where H is diagonal, for solvers that factor blocks; composed as
   "MatSlipGetDense_C" */
static PetscErrorCode StageGetEntries(Mat B, Mat *dense, PetscReal *scale, Vec *diagonal)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &s));
  if (!s->entries) {
    PetscBool already;

    PetscCall(PetscObjectTypeCompareAny((PetscObject)s->K, &already, MATSEQDENSE, MATMPIDENSE, ""));
    if (already) {
      PetscCall(PetscObjectReference((PetscObject)s->K));
      s->entries = s->K;
    } else {
      PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP)); /* a product for each column */
      PetscCall(MatConvert(s->K, MATDENSE, MAT_INITIAL_MATRIX, &s->entries));
      PetscCall(SlipProductsPop());
    }
    PetscCall(MatSetOption(s->entries, MAT_SYMMETRIC, PETSC_TRUE));
    PetscCall(MatCreateVecs(s->K, NULL, &s->diagonal));
  }
  if (s->diagonal_theta != s->theta) {
    PetscCall(MatGetDiagonal(s->H, s->diagonal));
    if (s->weights)
      PetscCall(VecAXPY(s->diagonal, s->mass / s->theta, s->weights));
    else
      PetscCall(VecShift(s->diagonal, s->mass / s->theta));
    s->diagonal_theta = s->theta;
  }
  *dense = s->entries;
  *scale = s->theta;
  *diagonal = s->diagonal;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageCreateApproximation(SlipStageContext *s);
static PetscErrorCode MatSlipStageSetLoose(Mat B, PetscReal loose);
static PetscErrorCode MatSlipStageSetWanted(Mat B, PetscReal wanted);
static PetscErrorCode MatSlipStageGetNoise(Mat B, PetscReal *noise);

/* Chooses whether Jacobians are formed from something cheaper than B, where products with H are much more expensive
   than those with K, and how products are formed: fused by transforms or per wavenumber, assembled, or K and H
   apart. */
static PetscErrorCode StageSetUp(Mat B, SlipStageContext *s)
{
  const SlipGrid *g;
  const PetscReal *viscosity;
  SlipCirculant strike;
  PetscBool denseK, denseH, plane, slow, spectral, approximate, radiation;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(StageReset(s));
  PetscCall(MatGetSize(s->K, &N, NULL));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)s->K, &denseK, MATSEQDENSE, MATMPIDENSE, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)s->H, &denseH, MATSEQDENSE, MATMPIDENSE, ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)s->H, "sliptoeplitz", &plane));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)s->H, &slow, "sliplanczos", "slipwaves", ""));
  PetscCall(PetscObjectTypeCompare((PetscObject)s->H, "slipspectral", &spectral));
  PetscCall(PetscObjectTypeCompare((PetscObject)s->H, "slipradiation", &radiation));
  PetscCall(SlipRadiationGet(s->H, &s->radiation));
  PetscCall(SlipLogsProducts(s->H, &s->counts));
  s->assemble = (PetscBool)(denseK && denseH && N <= SLIP_STAGE_ASSEMBLE_MAX);
  PetscCall(SlipViscosityGetFactor(s->H, &s->damping));
  PetscCall(SlipGridOf(s->K, &g));
  if (g) PetscCall(SlipGridScale(s->K, &s->scale));
  approximate = s->jacobian == JACOBIAN_AUTO ? (PetscBool)(slow || (spectral && g && g->nz > SLIP_BLOCKS_MAX))
                                             : (PetscBool)(s->jacobian == JACOBIAN_APPROXIMATE);
  if (plane || !(s->damping > 0) || !(s->mass > 0)) approximate = PETSC_FALSE;
  if (plane && g) PetscCall(SlipToeplitzOf(s->K, &s->plane));
  PetscCall(SlipSpectralGetBlocks(s->H, &strike, &viscosity));
  if (!denseK && strike && !approximate) PetscCall(StageFuse(s, strike));
  if (approximate) PetscCall(StageCreateApproximation(s));
  PetscCall(PetscObjectComposeFunction((PetscObject)B, "MatSlipGetDense_C",
                                       radiation && N <= SLIP_STAGE_ENTRIES_MAX ? StageGetEntries : NULL));
  PetscCall(PetscObjectComposeFunction((PetscObject)B, "MatSlipGetApproximation_C",
                                       approximate ? MatSlipStageGetApproximation : NULL));
  PetscCall(PetscObjectComposeFunction((PetscObject)B, "MatSlipSetLoose_C", approximate ? MatSlipStageSetLoose : NULL));
  PetscCall(
    PetscObjectComposeFunction((PetscObject)B, "MatSlipSetWanted_C", approximate ? MatSlipStageSetWanted : NULL));
  PetscCall(PetscObjectComposeFunction((PetscObject)B, "MatSlipGetNoise_C", approximate ? MatSlipStageGetNoise : NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells solvers that B has changed. */
static PetscErrorCode StageChanged(Mat B)
{
  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Has the viscosity got a factorised root since, products are formed with that, between solves. */
static PetscErrorCode StageRenew(Mat B, SlipStageContext *s)
{
  Mat now;

  PetscFunctionBegin;
  if (!s->given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLanczosGetNow(s->given, &now));
  if (now == s->H) PetscFunctionReturn(PETSC_SUCCESS);
  s->H = now;
  PetscCall(StageSetUp(B, s));
  PetscCall(StageChanged(B));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For checkpoints, after the viscosity: what an approximation has learnt of it. */
static PetscErrorCode StageState(Mat B, SlipState s)
{
  SlipStageContext *stage, *a = NULL;
  SlipRecycled *known;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(B, &stage));
  PetscCall(StageRenew(B, stage));
  if (stage->approximation) PetscCall(MatShellGetContext(stage->approximation, &a));
  if (!a || !a->correction) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLanczosGetRecycled(stage->H, &known));
  PetscCall(SlipSecantState(a->correction, known, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A stage operator; mean: see the context. */
static PetscErrorCode StageCreate(Mat K, Mat H, PetscReal mass, PetscReal mean, Mat *B)
{
  const SlipShellOps ops = {.mult = SlipStageMult,
                            .diagonal = SlipStageGetDiagonal,
                            .info = StageGetInfo,
                            .view = StageView,
                            .destroy = StageDestroy,
                            .state = StageState};
  SlipStageContext *s;
  const char *prefix;

  PetscFunctionBegin;
  PetscCall(PetscNew(&s));
  PetscCall(PetscObjectReference((PetscObject)K));
  if (H) PetscCall(PetscObjectReference((PetscObject)H));
  s->K = K;
  s->given = s->H = H;
  s->mass = mass;
  s->mean = mean;
  PetscCall(MatSlipGetWeights(K, &s->weights));
  PetscCall(MatCreateVecs(K, NULL, &s->work));
  PetscCall(SlipShellCreateLike(K, "slipstage", &ops, s, B));
  PetscCall(MatGetOptionsPrefix(K, &prefix));
  PetscCall(MatSetOptionsPrefix(*B, prefix));
  PetscCall(SlipLogProducts(*B, SLIP_StageMult));
  if (H) PetscCall(StageSetUp(*B, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets an approximation learn from the products with H, where H remembers them. */
static PetscErrorCode StageCorrect(SlipStageContext *s)
{
  SlipStageContext *a;
  SlipRecycled *known;

  PetscFunctionBegin;
  PetscCall(SlipLanczosGetRecycled(s->H, &known));
  PetscCall(MatShellGetContext(s->approximation, &a));
  if (known) PetscCall(SlipSecantCreate(s->K, a->H, s->mass, a->mean > 0 ? a->mean : 1, &a->correction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* H = 2 zeta (M K)^(1/2) is at most zeta ((M / theta) W + theta K) and at least nothing; without a grid to know better,
   half the bound is off by half of it at most. */
static PetscErrorCode StageCreateApproximation(SlipStageContext *s)
{
  const PetscReal zeta = s->damping / (2 * PetscSqrtReal(s->mass));
  const SlipGrid *grid;
  Mat H;

  PetscFunctionBegin;
  PetscCall(SlipGridOf(s->K, &grid));
  if (!grid) {
    PetscCall(StageCreate(s->K, NULL, s->mass, 1 + 0.5 * zeta, &s->approximation));
    PetscCall(StageCorrect(s));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipViscosityCreate_Plane(s->K, s->damping, &H));
  PetscCall(SlipViscosityComposeFactor(H, s->damping));
  PetscCall(StageCreate(s->K, H, s->mass, 0, &s->approximation));
  PetscCall(MatDestroy(&H));
  PetscCall(StageCorrect(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatCreateSlipStage - the operator of an implicit stage, B(theta) = (mass / theta) I + H + theta K

  Collective

  Input Parameters:
+ K    - stiffness [Pa/m]
. H    - viscosity [Pa s/m] with the same distribution
- mass - inertia per unit area [kg/m^2], zero or positive

  Output Parameter:
. B - matrix of type "slipstage" [Pa s/m]; set theta before using it

  Notes:
  K and H are referenced and must not change while B lives. Where the rows of K are weighted
  (MatSlipGetWeights()), so is the inertia: B = (mass / theta) diag(w) + H + theta K.

  Its options, with K's prefix, are read by MatSlipStageSetFromOptions().

  Errors: PETSC_ERR_ARG_SIZ when the sizes of K and H differ, PETSC_ERR_ARG_OUTOFRANGE for the mass

  Level: beginner

.seealso: MatSlipStageSetTheta(), MatSlipStageSetFromOptions(), MatCreateSlipStiffness(), MatCreateSlipViscosity(),
          PCSLIPSTAGE
@*/
PetscErrorCode MatCreateSlipStage(Mat K, Mat H, PetscReal mass, Mat *B)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  PetscInt m, N, mH, NH;

  PetscFunctionBegin;
  PetscCheck(mass >= 0 && !PetscIsInfOrNanReal(mass), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Inertia per unit area must be zero or positive and finite, not %g kg/m^2", (double)mass);
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(MatGetLocalSize(K, &m, NULL));
  PetscCall(MatGetSize(H, &NH, NULL));
  PetscCall(MatGetLocalSize(H, &mH, NULL));
  PetscCheck(N == NH, comm, PETSC_ERR_ARG_SIZ, "K has %" PetscInt_FMT " rows, H has %" PetscInt_FMT, N, NH);
  PetscCheck(m == mH, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ, "K has %" PetscInt_FMT " local rows, H has %" PetscInt_FMT, m,
             mH);
  PetscCall(StageCreate(K, H, mass, 0, B));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StageContext(Mat B, SlipStageContext **s)
{
  MatType type;
  PetscBool match;

  PetscFunctionBegin;
  PetscCall(MatGetType(B, &type));
  PetscCall(PetscObjectTypeCompare((PetscObject)B, "slipstage", &match));
  PetscCheck(match, PetscObjectComm((PetscObject)B), PETSC_ERR_ARG_WRONG,
             "Matrix is a \"%s\", expected a \"slipstage\"", type);
  PetscCall(MatShellGetContext(B, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatSlipStageSetJacobian - choose what MatSlipStageGetApproximation() gives for Newton matrices

  Collective

  Input Parameters:
+ B    - matrix of MatCreateSlipStage()
- type - "exact" (B itself), "approximate" (a cheap viscosity) or "auto" (by cost; unless set)

  Options Database Key:
. -mat_slipstage_jacobian <auto> - the same, for MatSlipStageSetFromOptions()

  Note: before a solver is set up with B.

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE

  Level: advanced

.seealso: MatSlipStageGetApproximation(), MatSlipStageSetFromOptions()
@*/
PetscErrorCode MatSlipStageSetJacobian(Mat B, const char type[])
{
  SlipStageContext *s;
  PetscInt choice;
  PetscBool known;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCall(PetscEListFind(3, Jacobians, type, &choice, &known));
  PetscCheck(known, PetscObjectComm((PetscObject)B), PETSC_ERR_ARG_UNKNOWN_TYPE,
             "Jacobians of a stage operator cannot be \"%s\", expected auto, exact or approximate", type);
  if (choice == s->jacobian) PetscFunctionReturn(PETSC_SUCCESS);
  s->jacobian = choice;
  if (s->H) PetscCall(StageSetUp(B, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStageSetFromOptions - read the options of a stage operator, with its prefix

  Collective

  Input Parameter:
. B - matrix of MatCreateSlipStage(), which gave it the prefix of K

  Options Database Key:
. -mat_slipstage_jacobian <auto> - Newton matrices: exact, approximate, or by cost (MatSlipStageSetJacobian())

  Level: intermediate

.seealso: MatSlipStageSetJacobian(), MatSetOptionsPrefix()
@*/
PetscErrorCode MatSlipStageSetFromOptions(Mat B)
{
  SlipStageContext *s;
  PetscInt choice;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  choice = s->jacobian;
  PetscObjectOptionsBegin((PetscObject)B);
  PetscCall(PetscOptionsEList("-mat_slipstage_jacobian",
                              "Newton matrices from the stage operator itself, from a cheap approximation of its "
                              "viscosity, or by cost",
                              "MatSlipStageSetJacobian", Jacobians, 3, Jacobians[choice], &choice, &set));
  PetscOptionsEnd();
  if (set) PetscCall(MatSlipStageSetJacobian(B, Jacobians[choice]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStageSetTheta - set the theta of the stage operator; the same value again costs nothing

  Logically collective

  Input Parameters:
+ B     - matrix of MatCreateSlipStage()
- theta - [s], positive

  Level: intermediate

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a theta that is not positive and finite

.seealso: MatCreateSlipStage(), MatSlipStageGetTheta()
@*/
PetscErrorCode MatSlipStageSetTheta(Mat B, PetscReal theta)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCheck(theta > 0 && PetscIsNormalReal(theta), PetscObjectComm((PetscObject)B), PETSC_ERR_ARG_OUTOFRANGE,
             "theta must be positive and finite, not %g s", (double)theta);
  PetscCall(StageRenew(B, s));
  if (s->theta != theta) {
    s->theta = theta;
    PetscCall(StageChanged(B));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStageGetTheta - the theta of a stage operator

  Not collective

  Input Parameter:
. B - matrix of MatCreateSlipStage()

  Output Parameter:
. theta - [s], 0 when it was never set

  Level: intermediate

.seealso: MatSlipStageSetTheta()
@*/
PetscErrorCode MatSlipStageGetTheta(Mat B, PetscReal *theta)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  *theta = s->theta;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Products with iterates far from the ones before are wanted to this relative error only, 0 for all as exact as ever;
   composed as "MatSlipSetLoose_C" for solvers that correct their iterates by such products. */
static PetscErrorCode MatSlipStageSetLoose(Mat B, PetscReal loose)
{
  SlipStageContext *s;
  SlipRecycled *known;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCall(SlipLanczosGetRecycled(s->H, &known));
  if (known) known->loose = loose;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An error that products with H may have in the 2-norm [Pa], 0: as little as ever; composed as "MatSlipSetWanted_C" for
   solvers that stop at a residual which is larger. */
static PetscErrorCode MatSlipStageSetWanted(Mat B, PetscReal wanted)
{
  SlipStageContext *s;
  SlipRecycled *known;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCall(SlipLanczosGetRecycled(s->H, &known));
  if (known) known->wanted = wanted;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The error of the last product in the 2-norm, 0 for that of rounding; composed as "MatSlipGetNoise_C" for solvers,
   which need not bring residuals below it. */
static PetscErrorCode MatSlipStageGetNoise(Mat B, PetscReal *noise)
{
  SlipStageContext *s;
  SlipRecycled *known;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCall(SlipLanczosGetRecycled(s->H, &known));
  *noise = known ? known->noise : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStageGetApproximation - a stage operator with a cheap viscosity, for the matrix of an inexact Newton method

  Logically collective

  Input Parameter:
. B - matrix of MatCreateSlipStage() whose theta is set

  Output Parameter:
. A - borrowed; B itself where its own products are cheap, else a matrix of type "slipstage" with the same theta

  Notes:
  H is at most zeta ((mass / theta) I + theta K), because a + b >= 2 sqrt(a b) for each mode of K. With A for B, a
  Newton iteration on B v = c leaves at most the share |A^-1 (H - H_A)| of the error. On a uniform grid H_A is the
  viscosity of type "toeplitz": a share of 0.02 and products as cheap as those with K. Elsewhere
  H_A = (zeta / 2) ((mass / theta) I + theta K): zeta / (2 + zeta), that is 0.12 for zeta = 0.8 / 3. Both become better
  as products with H are made, since H_A is corrected by those that H remembers: A is another operator at each call,
  and on a grid of 100 x 100 the first Newton iteration leaves 1e-3 where it left 3e-2. Near instability, where
  weakening takes most of B away, the share is larger in proportion.

  Level: advanced

.seealso: MatCreateSlipStage(), MatSlipStageSetJacobian(), MatSlipStageSetTheta(), SNESSEMISMOOTH
@*/
PetscErrorCode MatSlipStageGetApproximation(Mat B, Mat *A)
{
  SlipStageContext *s, *a;
  SlipRecycled *known;
  PetscBool changed;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  *A = s->approximation ? s->approximation : B;
  if (!s->approximation || s->theta <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatSlipStageSetTheta(*A, s->theta));
  PetscCall(MatShellGetContext(*A, &a));
  if (!a->correction) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipLanczosGetRecycled(s->H, &known));
  PetscCall(SlipSecantUpdate(a->correction, known, s->theta, &changed));
  if (changed) PetscCall(StageChanged(*A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipStageGetParts(Mat B, SlipStageParts *parts)
{
  SlipStageContext *s;

  PetscFunctionBegin;
  PetscCall(StageContext(B, &s));
  PetscCheck(s->theta > 0, PetscObjectComm((PetscObject)B), PETSC_ERR_ORDER, "Call MatSlipStageSetTheta() first");
  *parts = (SlipStageParts){s->K, s->H, s->mass, s->theta, s->scale, s->damping, s->radiation};
  PetscFunctionReturn(PETSC_SUCCESS);
}
