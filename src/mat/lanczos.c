/*
  Viscosity of stiffnesses without a uniform grid: H = factor D (D^-1 S D^-1)^(1/2) D, D = diag(w)^(1/2), w the weights
  of the rows of S. That is w times the H = factor K^(1/2) of the unweighted K = diag(1/w) S, and symmetric. The root is
  a dense one for a dense S or up to SLIP_ROOT_DENSE_MAX rows; else each product is a Lanczos process of its own (Higham
  2008, Functions of Matrices, section 13.2),

     A^(1/2) x  =  |x| V_m T_m^(1/2) e_1,   A V_m = V_m T_m + residual,

  with full reorthogonalisation, ended when the coefficients T_m^(1/2) e_1 no longer change. Parts of x along the last
  ones are recalled instead.
*/
#include <petsc/private/petscimpl.h>
#include <slipmat.h>
#include <petscblaslapack.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>
#include <slipstep/private/slipcells.h>

extern void dstev_(const char *jobz, const PetscBLASInt *n, double *d, double *e, double *z, const PetscBLASInt *ldz,
                   double *work, PetscBLASInt *info);

#define SLIP_ROOT_DENSE_MAX 3000
#define LANCZOS_MAX 600    /* steps of one product */
#define LANCZOS_BLOCK 20   /* basis vectors are allocated in blocks */
#define LANCZOS_EVERY 5    /* steps between looks at the convergence */
#define LANCZOS_SAMPLES 16 /* rows from which the diagonal is estimated */
#define LANCZOS_TOL 1e-10  /* default relative tolerance */
/* Shares of the tolerance for what is computed and for what earlier products tell: a new direction must fit in beside as
   many as are remembered. */
#define LANCZOS_NEW 0.02
#define LANCZOS_OLD 0.95

typedef struct {
  Mat S;       /* referenced */
  Vec root;    /* D, or NULL for the identity */
  Vec inverse; /* D^-1, or NULL */
  PetscReal factor, tolerance;
  PetscInt nbasis;
  Vec basis[LANCZOS_MAX + 1];
  Vec diagonal; /* estimate, on first use */
  Vec work;
  PetscReal alpha[LANCZOS_MAX], beta[LANCZOS_MAX]; /* of T */
  PetscReal c[LANCZOS_MAX], last[LANCZOS_MAX];     /* T^(1/2) e_1, now and at the last look */
  PetscReal h[LANCZOS_MAX];                        /* reorthogonalisation */
  PetscReal change;                                /* of c at the last look */
  PetscReal largest;                               /* Ritz value so far */
  PetscInt products, steps;                        /* so far */
  SlipRecall recall;                               /* of A^(1/2) */
  PetscObjectState state;                          /* of S, which recall holds for */
} Lanczos;

/* ---- the function of the tridiagonal matrix (pure) ---- */

/* c = T^(1/2) e_1; *lowest and *highest are the extreme Ritz values. */
static PetscErrorCode RootOfTridiagonal(PetscInt m, const PetscReal alpha[], const PetscReal beta[], PetscReal c[],
                                        PetscReal *lowest, PetscReal *highest)
{
  PetscBLASInt n, info;
  PetscReal *d, *e, *Z, *work;

  PetscFunctionBegin;
  PetscCall(PetscBLASIntCast(m, &n));
  PetscCall(PetscMalloc4(m, &d, m, &e, m * m, &Z, PetscMax(1, 2 * m - 2), &work));
  PetscCall(PetscArraycpy(d, alpha, m));
  PetscCall(PetscArraycpy(e, beta, m));
  dstev_("V", &n, d, e, Z, &n, work, &info);
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK stev: info %d", (int)info);
  *lowest = d[0];
  *highest = d[m - 1];
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

/* v_{m+1} and the next entries of T from v_0 .. v_m, by the three-term recurrence and a sweep of Gram-Schmidt. */
static PetscErrorCode Step(Lanczos *l, PetscInt m)
{
  Vec next;

  PetscFunctionBegin;
  PetscCall(EnsureBasis(l, m + 1));
  next = l->basis[m + 1];
  if (l->root) {
    PetscCall(VecPointwiseMult(l->work, l->inverse, l->basis[m]));
    PetscCall(MatMult(l->S, l->work, next));
    PetscCall(VecPointwiseMult(next, next, l->inverse));
  } else
    PetscCall(MatMult(l->S, l->basis[m], next));
  if (m > 0) PetscCall(VecAXPY(next, -l->beta[m - 1], l->basis[m - 1]));
  PetscCall(VecDot(next, l->basis[m], &l->alpha[m]));
  PetscCall(VecAXPY(next, -l->alpha[m], l->basis[m]));
  PetscCall(VecMDot(next, m + 1, l->basis, l->h));
  l->alpha[m] += l->h[m];
  for (PetscInt i = 0; i <= m; i++) l->h[i] = -l->h[i];
  PetscCall(VecMAXPY(next, m + 1, l->h, l->basis));
  PetscCall(VecNorm(next, NORM_2, &l->beta[m]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the coefficients of m steps with those of the last look: *converged when they have changed by at most the
   tolerance times the larger of their norm and size. */
static PetscErrorCode Look(Lanczos *l, PetscInt m, PetscInt before, PetscReal size, PetscBool *converged)
{
  PetscReal lowest = 0, highest = 0, change2 = 0, norm2 = 0;

  PetscFunctionBegin;
  PetscCall(RootOfTridiagonal(m, l->alpha, l->beta, l->c, &lowest, &highest));
  l->largest = PetscMax(l->largest, highest);
  PetscCheck(lowest > 0, PetscObjectComm((PetscObject)l->S), PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: it has an eigenvalue of at most %g Pa/m", (double)lowest);
  for (PetscInt i = 0; i < m; i++) {
    const PetscReal d = l->c[i] - (i < before ? l->last[i] : 0);

    change2 += d * d;
    norm2 += l->c[i] * l->c[i];
    l->last[i] = l->c[i];
  }
  l->change = PetscSqrtReal(change2);
  *converged = before > 0 && l->change <= LANCZOS_NEW * l->tolerance * PetscMax(PetscSqrtReal(norm2), size)
                 ? PETSC_TRUE
                 : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The basis and its coefficients c for the vector in basis[0], of norm 1; *m is their number. size: see Look(). */
static PetscErrorCode Process(Lanczos *l, PetscInt N, PetscReal size, PetscInt *m)
{
  PetscBool converged = PETSC_FALSE;
  PetscInt before = 0;

  PetscFunctionBegin;
  for (*m = 1; !converged; (*m)++) {
    PetscCheck(*m <= LANCZOS_MAX, PetscObjectComm((PetscObject)l->S), PETSC_ERR_NOT_CONVERGED,
               "A product with the viscosity did not reach %g in %d Lanczos steps: raise -fault_krylov_tolerance",
               (double)l->tolerance, LANCZOS_MAX);
    PetscCall(Step(l, *m - 1));
    if (*m == N || l->beta[*m - 1] <= 1e-14 * l->alpha[0]) { /* the whole space, or an invariant one */
      PetscCall(Look(l, *m, before, size, &converged));
      l->change = 0;
      break;
    }
    if (*m % LANCZOS_EVERY == 0) {
      PetscCall(Look(l, *m, before, size, &converged));
      before = *m;
      if (converged) break;
    }
    PetscCall(VecScale(l->basis[*m], 1 / l->beta[*m - 1]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y += |x| A^(1/2) v for v = x / |x| in basis[0], which is remembered. */
static PetscErrorCode AddRoot(Lanczos *l, PetscReal norm, PetscReal size, Vec y)
{
  PetscInt m, N;

  PetscFunctionBegin;
  PetscCall(VecGetSize(y, &N));
  PetscCall(Process(l, N, size / norm, &m));
  PetscCall(VecZeroEntries(l->work));
  PetscCall(VecMAXPY(l->work, m, l->c, l->basis));
  PetscCall(SlipRecallAdd(&l->recall, l->basis[0], l->work, l->change));
  PetscCall(VecAXPY(y, norm, l->work));
  l->steps += m;
  PetscCall(
    PetscInfo(l->S, "%" PetscInt_FMT " Lanczos steps for a part of norm %.2e with %" PetscInt_FMT " directions known\n",
              m, (double)norm, l->recall.n - 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosMult(Mat H, Vec x, Vec y)
{
  Lanczos *l;
  PetscReal norm, size;
  PetscObjectState state;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  PetscCall(PetscObjectStateGet((PetscObject)l->S, &state));
  if (state != l->state) PetscCall(SlipRecallReset(&l->recall));
  l->state = state;
  PetscCall(EnsureBasis(l, 0));
  if (l->root)
    PetscCall(VecPointwiseMult(l->basis[0], l->root, x));
  else
    PetscCall(VecCopy(x, l->basis[0]));
  PetscCall(SlipRecallSplit(&l->recall, LANCZOS_OLD * l->tolerance, l->basis[0], y, &size));
  PetscCall(VecNormalize(l->basis[0], &norm));
  /* a rest this small changes the result by less than a new direction may be wrong */
  if (norm > 0 && (size == 0 || PetscSqrtReal(l->largest) * norm > LANCZOS_NEW * l->tolerance * size))
    PetscCall(AddRoot(l, norm, size, y));
  PetscCall(VecScale(y, l->factor));
  if (l->root) PetscCall(VecPointwiseMult(y, y, l->root));
  l->products++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the matrix ---- */

/* H_ii over factor sqrt(w_i S_ii), averaged over rows spread over the matrix: exact at these, close at the others, as
   preconditioners need. */
static PetscErrorCode EstimateDiagonal(Mat H, Lanczos *l)
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
    PetscCall(LanczosMult(H, e, y));
    PetscCall(VecDot(e, y, &yi));
    PetscCall(VecDot(e, l->diagonal, &di));
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

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  if (!l->diagonal) {
    PetscCall(VecDuplicate(l->work, &l->diagonal));
    PetscCall(EstimateDiagonal(H, l));
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
  PetscCall(SlipRecallReset(&l->recall));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LanczosDestroy(Mat H)
{
  Lanczos *l;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &l));
  for (PetscInt i = 0; i < l->nbasis; i++) PetscCall(VecDestroy(&l->basis[i]));
  PetscCall(SlipRecallDestroy(&l->recall));
  PetscCall(VecDestroy(&l->work));
  PetscCall(VecDestroy(&l->diagonal));
  PetscCall(VecDestroy(&l->root));
  PetscCall(VecDestroy(&l->inverse));
  PetscCall(MatDestroy(&l->S));
  PetscCall(PetscFree(l));
  PetscCall(PetscObjectComposeFunction((PetscObject)H, "MatConvert_sliplanczos_dense_C", NULL));
  PetscCall(PetscObjectComposeFunction((PetscObject)H, "MatSlipViscositySetTolerance_C", NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* D and D^-1 of S's weights; both NULL without any. */
static PetscErrorCode RootWeights(Mat S, Vec *root, Vec *inverse)
{
  Vec weights;

  PetscFunctionBegin;
  *root = *inverse = NULL;
  PetscCall(MatSlipGetWeights(S, &weights));
  if (!weights) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(weights, root));
  PetscCall(VecCopy(weights, *root));
  PetscCall(VecSqrtAbs(*root));
  PetscCall(VecDuplicate(weights, inverse));
  PetscCall(VecCopy(*root, *inverse));
  PetscCall(VecReciprocal(*inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipViscosityCreate_Lanczos(Mat S, PetscReal factor, Mat *H)
{
  Lanczos *l;
  PetscInt m, N;

  PetscFunctionBegin;
  PetscCall(PetscNew(&l));
  PetscCall(PetscObjectReference((PetscObject)S));
  l->S = S;
  l->factor = factor;
  l->tolerance = LANCZOS_TOL;
  PetscCall(MatGetSize(S, &N, NULL));
  PetscCall(MatGetLocalSize(S, &m, NULL));
  PetscCall(MatCreateVecs(S, &l->work, NULL));
  PetscCall(RootWeights(S, &l->root, &l->inverse));
  PetscCall(MatCreateShell(PetscObjectComm((PetscObject)S), m, m, N, N, l, H));
  PetscCall(MatShellSetManageScalingShifts(*H));
  PetscCall(MatShellSetOperation(*H, MATOP_MULT, SlipMatShellFn(LanczosMult)));
  PetscCall(MatShellSetOperation(*H, MATOP_MULT_TRANSPOSE, SlipMatShellFn(LanczosMult)));
  PetscCall(MatShellSetOperation(*H, MATOP_GET_DIAGONAL, SlipMatShellFn(LanczosGetDiagonal)));
  PetscCall(MatShellSetOperation(*H, MATOP_VIEW, SlipMatShellFn(LanczosView)));
  PetscCall(MatShellSetOperation(*H, MATOP_GETINFO, SlipMatShellFn(LanczosGetInfo)));
  PetscCall(MatShellSetOperation(*H, MATOP_DESTROY, SlipMatShellFn(LanczosDestroy)));
  PetscCall(SlipShellFinish(*H, "sliplanczos"));
  PetscCall(PetscObjectComposeFunction((PetscObject)*H, "MatSlipViscositySetTolerance_C", LanczosSetTolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipViscositySetTolerance - relative tolerance of the products with a viscosity that Lanczos' method applies

  Logically collective

  Input Parameters:
+ H         - viscosity of MatCreateSlipViscosity(); nothing happens to those that are not applied by Lanczos' method
- tolerance - of products, relative in the 2-norm, in (0, 1); 1e-10 unless set. A new direction takes a fiftieth of it
              by the change that the last five steps made, parts along earlier ones the rest

  Level: intermediate

.seealso: MatCreateSlipViscosity(), MatCreateSlipCellStiffness()
@*/
PetscErrorCode MatSlipViscositySetTolerance(Mat H, PetscReal tolerance)
{
  PetscFunctionBegin;
  PetscTryMethod(H, "MatSlipViscositySetTolerance_C", (Mat, PetscReal), (H, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the dense root ---- */

/* Rank 0 computes the root, so that it does not depend on the number of ranks. */
static PetscErrorCode ViscosityCreate_DenseRoot(Mat S, PetscReal factor, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)S);
  Vec root, inverse;
  Mat scaled;
  PetscReal *entries = NULL, result[2] = {1, 0};
  PetscMPIInt rank;
  PetscInt N, m, info = 0;
  PetscBool found;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(MatGetSize(S, &N, NULL));
  PetscCall(MatGetLocalSize(S, &m, NULL));
  PetscCall(RootWeights(S, &root, &inverse));
  PetscCall(SlipCacheLoadRoot(S, &entries, &found));
  if (!found) {
    PetscCall(MatConvert(S, MATDENSE, MAT_INITIAL_MATRIX, &scaled));
    if (root) PetscCall(MatDiagonalScale(scaled, inverse, inverse));
    PetscCall(SlipDenseGather(scaled, &entries));
    PetscCall(MatDestroy(&scaled));
  }
  if (rank == 0 && !found) {
    PetscCall(SlipDenseSqrt(N, entries, &result[0], &info));
    result[1] = (PetscReal)info;
  }
  PetscCallMPI(MPI_Bcast(result, 2, MPIU_REAL, 0, comm));
  PetscCheck(result[1] == 0, comm, PETSC_ERR_LIB, "Eigenvalues of the stiffness did not converge (LAPACK info %g)",
             (double)result[1]);
  PetscCheck(result[0] > 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: its smallest eigenvalue is %g Pa/m", (double)result[0]);
  if (!found) PetscCall(SlipCacheSaveRoot(S, entries));
  for (size_t k = 0; !rank && k < (size_t)N * N; k++) entries[k] *= factor;
  PetscCall(SlipDenseScatter(comm, m, N, entries, H));
  PetscCall(PetscFree(entries));
  if (root) PetscCall(MatDiagonalScale(*H, root, root));
  PetscCall(VecDestroy(&root));
  PetscCall(VecDestroy(&inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipViscosityIsOfCells(Mat K, PetscBool *is)
{
  Vec weights;

  PetscFunctionBegin;
  PetscCall(MatSlipGetWeights(K, &weights));
  PetscCall(PetscObjectTypeCompare((PetscObject)K, "sliphmat", is));
  if (weights) *is = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The root takes after the stiffness: dense for a dense one, and for a hierarchical one where that is cheap. */
PetscErrorCode SlipViscosityCreate_Cells(Mat K, PetscReal factor, Mat *H)
{
  PetscBool hmat;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(PetscObjectTypeCompare((PetscObject)K, "sliphmat", &hmat));
  if (hmat && N > SLIP_ROOT_DENSE_MAX)
    PetscCall(SlipViscosityCreate_Lanczos(K, factor, H));
  else
    PetscCall(ViscosityCreate_DenseRoot(K, factor, H));
  PetscCall(MatSetOption(*H, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*H, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
