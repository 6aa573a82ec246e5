/*
  Viscosity of any stiffness, without set-up: H = factor D (D^-1 S D^-1)^(1/2) D with D = diag(w)^(1/2), where w are the
  weights of the rows of S. Each product is a Lanczos process (Higham 2008, Functions of Matrices, section 13.2),

     A^(1/2) x  =  |x| V_m T_m^(1/2) e_1,   A V_m = V_m T_m + residual,

  which ends when the coefficients T_m^(1/2) e_1 no longer change. The three-term recurrence is enough: lost
  orthogonality repeats eigenvalues that it has already found, which does not affect the root (Druskin and Knizhnerman
  1991, USSR Comput. Math. Math. Phys. 31). Small matrices are reorthogonalised, so that the process ends within N
  steps.

  Products with a solver's iterates are sums of increments (recycled.c).

  On a grid a factorised root (exact.c) replaces the process once its work exceeds that of the root's set-up, so that a
  run costs at most twice as much as with the better of both from its start: one event of 30 x 30 cells takes 70
  products, 15 ms, where the set-up takes 79 ms, and a century of events 1e5 products.
*/
#include <petsc/private/petscimpl.h>
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipblas.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>
#include <slipstep/private/slipsys.h>

#define LANCZOS_MAX 600    /* most steps of one product */
#define LANCZOS_BLOCK 20   /* basis vectors that are allocated at once */
#define LANCZOS_SHARE 0.03 /* steps between convergence tests over all steps so far: a test costs their number cubed */
#define LANCZOS_SAMPLES 16 /* rows from which the diagonal is estimated */
#define LANCZOS_SAMPLE_ERROR 1e-3   /* relative error of these: they only choose preconditioners and Newton's models */
#define LANCZOS_SAFETY 3            /* allowed error over its estimate */
#define LANCZOS_GAIN 0.1            /* smallest accepted ratio of the error to the last change */
#define LANCZOS_TOL 1e-8            /* default relative tolerance */
#define LANCZOS_ORTHOGONAL_MAX 2000 /* number of rows up to which the basis is reorthogonalised */

typedef struct {
  Mat S;       /* referenced */
  Vec root;    /* D, or NULL for the identity */
  Vec inverse; /* D^-1, or NULL */
  PetscReal factor, tolerance;
  PetscInt nbasis;
  Vec basis[LANCZOS_MAX + 1];
  Vec diagonal; /* its estimate, from first use on */
  Vec work;
  PetscReal alpha[LANCZOS_MAX], beta[LANCZOS_MAX]; /* entries of T */
  PetscReal c[LANCZOS_MAX], last[LANCZOS_MAX];     /* T^(1/2) e_1, now and at the last convergence test */
  PetscReal h[LANCZOS_MAX];                        /* work of reorthogonalisation */
  PetscInt products, steps;                        /* their numbers so far */
  PetscBool orthogonal;                            /* reorthogonalise */
  SlipRecycled increment;
  PetscReal set_up;                          /* processor time of the set-up of a factorised root, or 0 for none [s] */
  PetscReal spent;                           /* time of products so far, by their work, on the slowest process [s] */
  PetscReal factor_tolerance;                /* tolerance of the factorised root */
  SlipRootFn create;                         /* function that creates it */
  Mat factorised;                            /* NULL before */
  PetscErrorCode (*multiply)(Mat, Vec, Vec); /* its product, not logged */
} Lanczos;

/* ---- the function of the tridiagonal matrix (pure) ---- */

/* Computes c = T^(1/2) e_1; T has alpha[m] on and beta[m - 1] beside its diagonal; *lowest is the least Ritz value. */
PetscErrorCode SlipRootOfTridiagonal(PetscInt m, const PetscReal alpha[], const PetscReal beta[], PetscReal c[],
                                     PetscReal *lowest)
{
  PetscBLASInt n, info;
  PetscReal *d, *e, *Z, *work;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(m, &n));
  PetscCall(PetscMalloc4(m, &d, m, &e, m * m, &Z, PetscMax(1, 2 * m - 2), &work));
  PetscCall(PetscArraycpy(d, alpha, m));
  PetscCall(PetscArraycpy(e, beta, m));
  SLIP_dstev("V", &n, d, e, Z, &n, work, &info);
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK stev: info %d", (int)info);
  *lowest = d[0];
  PetscCall(PetscArrayzero(c, m));
  for (PetscInt k = 0; k < m; k++) {
    const PetscReal f = PetscSqrtReal(PetscMax(d[k], 0)) * Z[(size_t)k * m];

    for (PetscInt i = 0; i < m; i++) c[i] += f * Z[(size_t)k * m + i];
  }
  PetscCall(PetscFree4(d, e, Z, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- one product ---- */

static PetscErrorCode EnsureBasis(Lanczos *l, PetscInt m)
{
  PetscFunctionBegin;
  while (l->nbasis <= m && l->nbasis <= LANCZOS_MAX) {
    const PetscInt end = PetscMin(l->nbasis + LANCZOS_BLOCK, LANCZOS_MAX + 1);

    for (; l->nbasis < end; l->nbasis++) PetscCall(VecDuplicate(l->work, &l->basis[l->nbasis]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes v_{m+1} and the next entries of T from v_0 .. v_m, by classical Gram-Schmidt twice, or by the recurrence. */
static PetscErrorCode Step(Lanczos *l, PetscInt m)
{
  Vec next;

  PetscFunctionBegin;
  PetscCall(EnsureBasis(l, m + 1));
  next = l->basis[m + 1];
  if (!l->root)
    PetscCall(MatMult(l->S, l->basis[m], next));
  else { /* D^-1 S D^-1 */
    PetscCall(VecPointwiseMult(l->work, l->inverse, l->basis[m]));
    PetscCall(MatMult(l->S, l->work, next));
    PetscCall(VecPointwiseMult(next, next, l->inverse));
  }
  l->alpha[m] = 0;
  for (PetscInt pass = 0; pass < 2 && l->orthogonal; pass++) {
    PetscCall(VecMDot(next, m + 1, l->basis, l->h));
    l->alpha[m] += l->h[m];
    for (PetscInt i = 0; i <= m; i++) l->h[i] = -l->h[i];
    PetscCall(VecMAXPY(next, m + 1, l->h, l->basis));
  }
  if (!l->orthogonal) {
    if (m > 0) PetscCall(VecAXPY(next, -l->beta[m - 1], l->basis[m - 1]));
    PetscCall(VecDot(next, l->basis[m], &l->alpha[m]));
    PetscCall(VecAXPY(next, -l->alpha[m], l->basis[m]));
  }
  PetscCall(VecNorm(next, NORM_2, &l->beta[m]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the error of the coefficients c of m steps. Their change since the last test is the error at that test.
   Since then each step has reduced it by at least as much as before, because convergence is superlinear, which gives
   the present error. A further bound, by the best polynomial, which needs the norm of A, would save 1 % of the products
   of a run. *size is |c|. */
PetscReal SlipRootError(SlipRootLooks *looks, PetscInt m, const PetscReal c[], PetscReal last[], PetscReal *size)
{
  const PetscReal steps = (PetscReal)(m - looks->before);
  PetscReal change = 0, error = PETSC_MAX_REAL;

  *size = 0;
  for (PetscInt i = 0; i < m; i++) {
    change += PetscSqr(c[i] - (i < looks->before ? last[i] : 0));
    *size += PetscSqr(c[i]);
    last[i] = c[i];
  }
  change = PetscSqrtReal(change);
  *size = PetscSqrtReal(*size);
  if (looks->before && change < looks->change)
    error =
      change * PetscMax(LANCZOS_GAIN, LANCZOS_SAFETY * PetscPowReal(change / looks->change, steps / looks->steps));
  *looks = (SlipRootLooks){.before = m, .steps = steps, .change = change};
  return error;
}

/* Computes the basis and its coefficients c for the vector in basis[0], of norm 1, with an error of at most the larger
   of allowed and relative |c|; *m is their number. */
static PetscErrorCode LanczosProcess(Lanczos *l, PetscInt N, PetscReal allowed, PetscReal relative, PetscInt *m)
{
  SlipRootLooks looks = {.before = 0};
  PetscReal lowest, size, error;

  PetscFunctionBegin;
  for (*m = 1;; (*m)++) {
    PetscBool whole;

    PetscCheck(*m <= LANCZOS_MAX, PetscObjectComm((PetscObject)l->S), PETSC_ERR_NOT_CONVERGED,
               "A product with the viscosity did not reach its tolerance %g in %d Lanczos steps: raise it by "
               "-%smat_slipsqrtm_tolerance",
               (double)l->tolerance, LANCZOS_MAX, ((PetscObject)l->S)->prefix ? ((PetscObject)l->S)->prefix : "");
    PetscCall(Step(l, *m - 1));
    whole = (PetscBool)((l->orthogonal && *m == N) || l->beta[*m - 1] <= 1e-14 * l->alpha[0]);
    if (whole || *m >= looks.before + PetscMax(1, (PetscInt)(LANCZOS_SHARE * (PetscReal)looks.before))) {
      PetscCall(SlipRootOfTridiagonal(*m, l->alpha, l->beta, l->c, &lowest));
      PetscCheck(lowest > 0, PetscObjectComm((PetscObject)l->S), PETSC_ERR_ARG_WRONG,
                 "The stiffness has no real square root: it has an eigenvalue of at most %g Pa/m", (double)lowest);
      if (whole) break; /* the basis spans the whole space, or an invariant one */
      error = SlipRootError(&looks, *m, l->c, l->last, &size);
      if (error <= PetscMax(allowed, relative * size)) break;
    }
    PetscCall(VecScale(l->basis[*m], 1 / l->beta[*m - 1]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = H x with an error of at most the larger of allowed [Pa] and relative |H x|, as if D were its mean, 1. */
static PetscErrorCode Product(void *ctx, Vec x, PetscReal allowed, PetscReal relative, Vec y)
{
  Lanczos *l = (Lanczos *)ctx;
  PetscReal norm;
  PetscInt m, N;

  PetscFunctionBegin;
  PetscCall(EnsureBasis(l, 0));
  if (l->root)
    PetscCall(VecPointwiseMult(l->basis[0], l->root, x));
  else
    PetscCall(VecCopy(x, l->basis[0]));
  PetscCall(VecNormalize(l->basis[0], &norm));
  PetscCall(VecZeroEntries(y));
  if (norm == 0 || l->factor == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetSize(x, &N));
  PetscCall(LanczosProcess(l, N, allowed / (norm * l->factor), relative, &m));
  PetscCall(VecMAXPY(y, m, l->c, l->basis));
  PetscCall(VecScale(y, norm * l->factor));
  if (l->root) PetscCall(VecPointwiseMult(y, y, l->root));
  l->products++;
  l->steps += m;
  PetscCall(PetscInfo(l->S, "%" PetscInt_FMT " Lanczos steps for a vector of norm %.2e\n", m, (double)norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the factorised root ---- */

static PetscErrorCode Factorise(Lanczos *l)
{
  SlipMatFn *multiply;

  PetscFunctionBegin;
  PetscCall(
    PetscInfo(l->S, "The viscosity is factorised, after %" PetscInt_FMT " products by Lanczos' method\n", l->products));
  PetscCall(SlipRecycledReset(&l->increment));
  for (PetscInt i = 0; i < l->nbasis; i++) PetscCall(VecDestroy(&l->basis[i]));
  l->nbasis = 0;
  l->increment.noise = 0;
  PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
  PetscCall(PetscLogEventBegin(SLIP_ViscositySetUp, l->S, 0, 0, 0));
  PetscCall((*l->create)(l->S, l->factor, l->factor_tolerance, &l->factorised));
  PetscCall(SlipViscosityComposeFactor(l->factorised, l->factor));
  PetscCall(PetscLogEventEnd(SLIP_ViscositySetUp, l->S, 0, 0, 0));
  PetscCall(SlipProductsPop());
  PetscCall(MatGetOperation(l->factorised, MATOP_MULT, &multiply));
  l->multiply = (PetscErrorCode(*)(Mat, Vec, Vec))multiply;
  PetscCall(SlipLogProducts(l->factorised, SLIP_ViscosityMult));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosMult(Mat H, Vec x, Vec y)
{
  Lanczos *l;
  SlipProducts before, now;
  PetscReal work;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  if (!l->factorised && l->set_up > 0 && l->spent > l->set_up) PetscCall(Factorise(l));
  if (l->factorised) {
    SlipProductsAdd((SlipProducts){.all = 1});
    PetscCall((*l->multiply)(l->factorised, x, y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (l->set_up > 0) SlipProductsGetOf(SLIP_PRODUCTS_RUN, &before);
  PetscCall(SlipRecycledMult(&l->increment, l->tolerance, Product, l, x, y));
  if (l->set_up > 0) {
    /* the work of a run, without that of output, which differs between restarted and unbroken runs */
    SlipProductsGetOf(SLIP_PRODUCTS_RUN, &now);
    work = now.cost - before.cost;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &work, 1, MPIU_REAL, MPI_MAX, PetscObjectComm((PetscObject)l->S)));
    l->spent += work;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrix ---- */

/* Estimates the diagonal from the mean of H_ii over factor sqrt(w_i S_ii) in some rows, well enough to precondition. */
static PetscErrorCode EstimateDiagonal(Lanczos *l)
{
  PetscInt N, start, end, samples;
  PetscReal ratio = 0;
  Vec e, y;

  PetscFunctionBegin;
  PetscCall(VecGetSize(l->diagonal, &N));
  PetscCall(VecGetOwnershipRange(l->diagonal, &start, &end));
  samples = PetscMin(N, LANCZOS_SAMPLES);
  PetscCall(VecDuplicate(l->diagonal, &e));
  PetscCall(VecDuplicate(l->diagonal, &y));
  PetscCall(MatGetDiagonal(l->S, l->diagonal));
  if (l->root) PetscCall(VecPointwiseMult(l->diagonal, l->diagonal, l->root));
  if (l->root) PetscCall(VecPointwiseMult(l->diagonal, l->diagonal, l->root));
  PetscCall(VecSqrtAbs(l->diagonal));
  PetscCall(VecScale(l->diagonal, l->factor));
  for (PetscInt k = 0; k < samples; k++) {
    const PetscInt row = k * (N / samples) + N / samples / 2;
    PetscReal yi, di;

    PetscCall(VecZeroEntries(e));
    if (start <= row && row < end) PetscCall(VecSetValue(e, row, 1, INSERT_VALUES));
    PetscCall(VecAssemblyBegin(e));
    PetscCall(VecAssemblyEnd(e));
    PetscCall(VecDot(e, l->diagonal, &di));
    PetscCall(Product(l, e, LANCZOS_SAMPLE_ERROR * di, 0, y));
    PetscCall(VecDot(e, y, &yi));
    ratio += yi / di / (PetscReal)samples;
  }
  PetscCall(VecScale(l->diagonal, ratio));
  PetscCall(VecDestroy(&e));
  PetscCall(VecDestroy(&y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosGetDiagonal(Mat H, Vec d)
{
  Lanczos *l;
  const SlipGrid *grid;
  SlipToeplitz plane;
  PetscReal scale;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  if (!l->diagonal) {
    PetscCall(VecDuplicate(l->work, &l->diagonal));
    PetscCall(SlipGridOf(l->S, &grid));
    if (grid && !l->root) { /* the diagonal of the approximate root */
      PetscCall(SlipToeplitzOf(l->S, &plane));
      PetscCall(SlipGridScale(l->S, &scale));
      PetscCall(SlipToeplitzGetRootDiagonal(plane, l->factor * PetscSqrtReal(scale), l->diagonal));
    }
    PetscCall(SlipProductsPush(SLIP_PRODUCTS_SETUP));
    if (!grid || l->root) PetscCall(EstimateDiagonal(l));
    PetscCall(SlipProductsPop());
  }
  PetscCall(VecCopy(l->diagonal, d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosView(Mat H, PetscViewer viewer)
{
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "viscosity by Lanczos' method: relative tolerance %g, %.1f products with the "
                                   "stiffness in each of %" PetscInt_FMT " so far\n",
                                   (double)l->tolerance, (double)l->steps / (double)PetscMax(l->products, 1),
                                   l->products));
  if (l->set_up > 0)
    PetscCall(PetscViewerASCIIPrintf(viewer, "%s, once they took more than its set-up, %.2g s by counts of work\n",
                                     l->factorised ? "factorised" : "to be factorised", (double)l->set_up));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosGetInfo(Mat H, MatInfoType flag, MatInfo *info)
{
  Lanczos *l;
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  PetscCall(MatGetLocalSize(H, &n, NULL));
  PetscCall(SlipInfoFill(H, (PetscReal)sizeof(PetscReal) * (PetscReal)(l->nbasis + 4) * (PetscReal)n, flag, info));
  if (l->factorised) {
    MatInfo more;

    PetscCall(MatGetInfo(l->factorised, flag, &more));
    info->memory += more.memory;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosAllow(Mat H, PetscReal tolerance)
{
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  l->increment.least = tolerance;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosSetTolerance(Mat H, PetscReal tolerance)
{
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  PetscCheck(tolerance > 0 && tolerance < 1, PetscObjectComm((PetscObject)H), PETSC_ERR_ARG_OUTOFRANGE,
             "Tolerance of a viscosity's products must lie in (0, 1), not %g", (double)tolerance);
  l->tolerance = tolerance;
  PetscCall(SlipRecycledReset(&l->increment));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosDestroy(Mat H)
{
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  for (PetscInt i = 0; i < l->nbasis; i++) PetscCall(VecDestroy(&l->basis[i]));
  PetscCall(VecDestroy(&l->work));
  PetscCall(SlipRecycledReset(&l->increment));
  PetscCall(VecDestroy(&l->diagonal));
  PetscCall(VecDestroy(&l->root));
  PetscCall(VecDestroy(&l->inverse));
  PetscCall(MatDestroy(&l->factorised));
  PetscCall(MatDestroy(&l->S));
  PetscCall(PetscFree(l));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosSetFromOptions(Mat H)
{
  Lanczos *l;
  PetscReal tolerance;
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  tolerance = l->tolerance;
  PetscObjectOptionsBegin((PetscObject)H);
  PetscCall(PetscOptionsReal("-mat_slipsqrtm_tolerance", "Relative error of a product by Lanczos' method, in (0, 1)",
                             "MatSlipViscositySetTolerance", tolerance, &tolerance, &set));
  PetscOptionsEnd();
  if (set) PetscCall(MatSlipViscositySetTolerance(H, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads the state in a checkpoint. */
static PetscErrorCode LanczosState(Mat H, SlipState s)
{
  PetscBool estimated, factorised;
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  PetscCall(SlipStateInt(s, "products", 1, &l->products));
  PetscCall(SlipStateInt(s, "steps", 1, &l->steps));
  estimated = l->diagonal ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateBool(s, "estimated", &estimated));
  if (estimated && !l->diagonal) PetscCall(VecDuplicate(l->work, &l->diagonal));
  if (estimated) PetscCall(SlipStateVec(s, "diagonal", l->diagonal));
  PetscCall(SlipStateReal(s, "spent", 1, &l->spent));
  factorised = l->factorised ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateBool(s, "factorised", &factorised));
  if (factorised && !l->factorised) PetscCall(Factorise(l));
  if (!factorised) PetscCall(MatDestroy(&l->factorised)); /* if a program loads another run */
  if (factorised)
    PetscCall(SlipSpectralState(l->factorised, s));
  else
    PetscCall(SlipRecycledState(&l->increment, H, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipViscosityCreate_Lanczos(Mat S, PetscReal factor, Mat *H)
{
  const SlipShellOps ops = {.mult = LanczosMult,
                            .diagonal = LanczosGetDiagonal,
                            .info = LanczosGetInfo,
                            .view = LanczosView,
                            .destroy = LanczosDestroy,
                            .state = LanczosState};
  const char *prefix;
  Lanczos *l;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(PetscNew(&l));
  PetscCall(PetscObjectReference((PetscObject)S));
  l->S = S;
  l->factor = factor;
  l->tolerance = LANCZOS_TOL;
  PetscCall(MatGetSize(S, &N, NULL));
  l->orthogonal = (PetscBool)(N <= LANCZOS_ORTHOGONAL_MAX);
  PetscCall(MatCreateVecs(S, &l->work, NULL));
  PetscCall(SlipRootWeights(S, &l->root, &l->inverse));
  PetscCall(SlipShellCreateLike(S, "sliplanczos", &ops, l, H));
  PetscCall(MatSetOption(*H, MAT_SPD, PETSC_TRUE));
  PetscCall(MatGetOptionsPrefix(S, &prefix));
  PetscCall(MatSetOptionsPrefix(*H, prefix));
  PetscCall(PetscObjectComposeFunction((PetscObject)*H, "MatSlipViscositySetTolerance_C", LanczosSetTolerance));
  PetscCall(PetscObjectComposeFunction((PetscObject)*H, "MatSlipViscositySetFromOptions_C", LanczosSetFromOptions));
  PetscCall(PetscObjectComposeFunction((PetscObject)*H, "MatSlipViscosityAllow_C", LanczosAllow));
  PetscCall(LanczosSetFromOptions(*H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes an H of SlipViscosityCreate_Lanczos() create a factorised root of this tolerance after products have taken more
   than set_up [s]. */
PetscErrorCode SlipLanczosFactorise(Mat H, SlipRootFn create, PetscReal tolerance, PetscReal set_up)
{
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  l->create = create;
  l->factor_tolerance = tolerance;
  l->set_up = set_up;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the matrix that computes products now, borrowed: the factorised root if H has one, otherwise H. */
PetscErrorCode SlipLanczosGetNow(Mat H, Mat *now)
{
  PetscBool lanczos;
  Lanczos *l;

  PetscFunctionBegin;
  *now = H;
  PetscCall(PetscObjectTypeCompare((PetscObject)H, "sliplanczos", &lanczos));
  if (!lanczos) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(H, &l));
  if (l->factorised) *now = l->factorised;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the stored products of a viscosity, borrowed; NULL if H is of another type. */
PetscErrorCode SlipLanczosGetRecycled(Mat H, SlipRecycled **known)
{
  PetscBool lanczos;
  Lanczos *l;

  PetscFunctionBegin;
  *known = NULL;
  PetscCall(PetscObjectTypeCompare((PetscObject)H, "sliplanczos", &lanczos));
  if (!lanczos) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(H, &l));
  *known = &l->increment;
  PetscFunctionReturn(PETSC_SUCCESS);
}
