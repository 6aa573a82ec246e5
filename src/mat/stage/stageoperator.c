/* The stage operator B(theta) = (mass / theta) I + H + theta K as a shell matrix. */
#include <petsc/private/petscimpl.h> /* prefix */
#include <slipstep/private/slipmatstage.h>

/* The choices of MatSlipStageSetJacobian() */
enum { JACOBIAN_AUTO, JACOBIAN_EXACT, JACOBIAN_APPROXIMATE };
static const char *const Jacobians[] = {"auto", "exact", "approximate"};

/* Largest size up to which dense operands are added for each theta: that costs three products and saves one in each of
   the tens of iterations at that theta, but it needs N^2 more numbers (200 MB here). */
#define SLIP_STAGE_ASSEMBLE_MAX 5000

/* Returns the memory besides that of K and H. */
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

/* Destroys what StageSetUp() created. */
static PetscErrorCode StageReset(SlipStageContext *s)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(s->blocks, s->y));
  PetscCall(MatDestroy(&s->approximation));
  PetscCall(SlipGatherDestroy(&s->gather));
  s->strike = NULL;
  s->assembled_theta = 0;
  PetscCall(PetscArrayzero(s->sum_here, 3));
  PetscCall(PetscArrayzero(s->sum_there, 3));
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

/* Makes one pair of transforms per wavenumber serve K and its spectral viscosity. */
static PetscErrorCode StageFuse(SlipStageContext *s, SlipCirculant strike)
{
  const SlipGrid *g;
  SlipCirculant own;
  PetscInt N, nk;

  PetscFunctionBegin;
  PetscCall(SlipCirculantOf(s->K, &own));
  if (own != strike) PetscFunctionReturn(PETSC_SUCCESS); /* H is of another stiffness */
  s->strike = strike;
  PetscCall(MatGetSize(s->K, &N, NULL));
  SlipCirculantGet(strike, &g, NULL, &nk, NULL);
  PetscCall(PetscMalloc2((size_t)nk * g->nz * g->nz, &s->blocks, N, &s->y));
  PetscCall(SlipGatherCreate(s->K, SlipCirculantPencil(strike), &s->gather));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Number of cells up to which the entries of K are stored (72 MB) for solves on small sliding sets: a factorisation of
   100 rows takes a tenth of the time of the products that conjugate gradients need to the same residual. */
#define SLIP_STAGE_ENTRIES_MAX 3000

/* Gets B = scale dense + diag(diagonal) where H is diagonal, for solvers that factor blocks; composed as
   "MatSlipGetDense_C". */
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
      PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP)); /* it takes a product per column */
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

/* Chooses whether Jacobians are cheaper than B, which pays where products with H are much more expensive than those
   with K, and how products are computed: fused by transforms or per wavenumber, assembled, or K and H separately. */
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

/* Increases the state of B, so that solvers see that it has changed. */
static PetscErrorCode StageChanged(Mat B)
{
  PetscFunctionBegin;
  PetscCall(MatAssemblyBegin(B, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(B, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets products use the factorised root of the viscosity between solves, if it has one since the last call. */
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

/* Writes or reads the correction of the approximation in a checkpoint, after the viscosity. */
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

/* Creates a stage operator; mean: see the context. */
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

/* Corrects an approximation by the products with H that H has stored. */
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

/* Creates the approximation. H = 2 zeta (M K)^(1/2) is between 0 and zeta ((M / theta) W + theta K): without a grid,
   half of that bound has an error of at most its own size. */
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
  MatCreateSlipStage - creates the operator of an implicit stage, B(theta) = (mass / theta) I + H + theta K

  Collective

  Input Parameters:
+ K    - stiffness [Pa/m]
. H    - viscosity [Pa s/m] with the same distribution
- mass - inertia per unit area [kg/m^2], zero or positive

  Output Parameter:
. B - matrix of type "slipstage" [Pa s/m]; set theta before using it

  Notes:
  K and H are referenced and must not change while B exists. If the rows of K have weights (MatSlipGetWeights()), the
  inertia has them too: B = (mass / theta) diag(w) + H + theta K.

  MatSlipStageSetFromOptions() reads its options, with K's prefix.

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

/* Sets which operator MatSlipStageGetApproximation() returns for Newton matrices. B: matrix of MatCreateSlipStage();
   type: "exact" (B itself), "approximate" (a cheap viscosity) or "auto" (by cost; default). Option
   -mat_slipstage_jacobian <auto>: the same, for MatSlipStageSetFromOptions(). Call this before a solver is set up with
   B. Errors: PETSC_ERR_ARG_UNKNOWN_TYPE. */
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

/* Reads the options of a stage operator, with its prefix. B: matrix of MatCreateSlipStage(), which has the prefix of K.
   Option -mat_slipstage_jacobian <auto>: Newton matrices: exact, approximate, or by cost (MatSlipStageSetJacobian()).
   */
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
  MatSlipStageSetTheta - sets the theta of the stage operator; the same value again costs nothing

  Logically collective

  Input Parameters:
+ B     - matrix of MatCreateSlipStage()
- theta - the theta [s], positive

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
  MatSlipStageGetTheta - gets the theta of a stage operator

  Not collective

  Input Parameter:
. B - matrix of MatCreateSlipStage()

  Output Parameter:
. theta - the theta [s]; 0 if it was never set

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

/* Sets the relative error that products with iterates far from earlier ones may have; 0: the usual error. It is
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

/* Sets the error that products with H may have in the 2-norm [Pa]; 0: the usual error. It is composed as
   "MatSlipSetWanted_C" for solvers that stop at a larger residual. */
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

/* Gets the error of the last product in the 2-norm; 0: rounding. It is composed as "MatSlipGetNoise_C" for solvers,
   which need not reduce residuals below it. */
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

/* Gets a stage operator with a cheap viscosity, the matrix of an inexact Newton method. B: matrix of
   MatCreateSlipStage() whose theta is set; A: borrowed; B itself if its products are cheap, otherwise a matrix of type
   "slipstage" with the same theta. H is at most zeta ((mass / theta) I + theta K), because a + b >= 2 sqrt(a b) for
   each mode of K. With A in place of B, a Newton iteration on B v = c reduces the error at least by the factor |A^-1 (H
   - H_A)|. On a uniform grid H_A is the viscosity of type "toeplitz": the factor is 0.02, and products are as cheap as
   those with K. Elsewhere H_A = (zeta / 2) ((mass / theta) I + theta K): the factor is zeta / (2 + zeta), 0.12 for zeta
   = 0.8 / 3. Both improve with products with H, as those that H has stored correct H_A: A is another operator at each
   call, and on a grid of 100 x 100 the factor of the first Newton iteration decreases from 3e-2 to 1e-3. Near an
   instability, where weakening cancels most of B, the factor is larger in proportion. */
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
