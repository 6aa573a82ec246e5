/*
  Viscosity of type "slipwaves": the square root per wavenumber along strike of the problem made periodic, the same as
  "slipspectral" but without blocks. A Lanczos process (lanczos.c) multiplies each wavenumber's field in depth with the
  matrix of toeplitz.c at this wavenumber. Short wavelengths are well-conditioned and small, so that most processes end
  after a few steps.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

#define WAVES_MAX 600            /* most steps of one process */
#define WAVES_ORTHOGONAL_MAX 128 /* cells in depth up to which the basis is reorthogonalised: it then ends by itself */
#define WAVES_SHARE 6            /* all steps so far over the steps between convergence tests */
#define WAVES_BYTES 24.0         /* bytes of blocks for each pair of cells in depth at each of nx wavenumbers */
#define WAVES_TOL 1e-12          /* relative tolerance of a product */
/* Changes of coefficients by rounding, over the root of the largest entry of T: eigenvalues have an error of 1e-16 of
   the largest one, and their roots (condition number)^(1/2), a few tens, times that. */
#define WAVES_ROUNDING 1e-14

typedef struct {
  Mat K; /* referenced: owns the plane */
  SlipToeplitz plane;
  PetscReal scale, factor; /* H = factor (scale kernel)^(1/2) */
  PetscInt nz;
  PetscInt max;                       /* most steps and basis vectors */
  PetscReal *basis;                   /* [max + 1][nz] complex */
  PetscReal *alpha, *beta, *c, *last; /* [max] */
  SlipRecycled increment;
} WavesContext;

static PetscReal Dot(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0;

  for (PetscInt i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

static void Axpy(PetscInt n, PetscReal factor, const PetscReal x[], PetscReal y[])
{
  for (PetscInt i = 0; i < n; i++) y[i] += factor * x[i];
}

/* Computes the next basis vector and entries of T. As the matrix is real, products of complex vectors are real ones. */
static PetscErrorCode Step(WavesContext *w, PetscInt k, PetscInt m)
{
  const PetscInt n = 2 * w->nz;
  PetscReal *v = w->basis + (size_t)m * n, *next = v + n;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) next[i] = v[i];
  PetscCall(SlipToeplitzApplyWave(w->plane, SlipToeplitzStiffness(w->plane), k, next));
  for (PetscInt i = 0; i < n; i++) next[i] *= w->scale / (PetscReal)w->plane->depth_period;
  if (m > 0) Axpy(n, -w->beta[m - 1], v - n, next);
  w->alpha[m] = Dot(n, v, next);
  Axpy(n, -w->alpha[m], v, next);
  for (PetscInt i = m; i >= 0 && w->nz <= WAVES_ORTHOGONAL_MAX; i--) {
    const PetscReal *vi = w->basis + (size_t)i * n;

    Axpy(n, -Dot(n, vi, next), vi, next);
  }
  w->beta[m] = PetscSqrtReal(Dot(n, next, next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes f = (scale kernel)^(1/2) f at local wavenumber k, with an error of at most allowed. Where A is the operator
   and f has norm 1, the first coefficient is alpha^(1/2) = |A^(1/2) f|, and f.A^(1/2) f > 0: its error is at most
   2^(1/2) times that, so that negligible fields take one step. */
static PetscErrorCode RootOfWave(WavesContext *w, PetscInt k, PetscReal allowed, PetscReal f[])
{
  const PetscInt n = 2 * w->nz;
  const PetscReal norm = PetscSqrtReal(Dot(n, f, f));
  SlipRootLooks looks = {.before = 0};
  PetscReal largest = 0, lowest, error, size;
  PetscInt m;
  PetscBool last = PETSC_FALSE;

  PetscFunctionBegin;
  if (norm == 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < n; i++) w->basis[i] = f[i] / norm;
  for (m = 1;; m++) {
    PetscCheck(m <= w->max, PETSC_COMM_SELF, PETSC_ERR_NOT_CONVERGED,
               "The spectral viscosity did not converge in %" PetscInt_FMT " Lanczos steps at a wavenumber", w->max);
    PetscCall(Step(w, k, m - 1));
    largest = PetscMax(largest, w->alpha[m - 1]);
    last = (PetscBool)(w->beta[m - 1] <= 1e-14 * w->alpha[0] || (w->nz <= WAVES_ORTHOGONAL_MAX && m == w->nz));
    if (last || m >= looks.before + PetscMax(1, looks.before / WAVES_SHARE)) {
      PetscCall(SlipRootOfTridiagonal(m, w->alpha, w->beta, w->c, &lowest));
      error = SlipRootError(&looks, m, w->c, w->last, &size);
      if (m == 1) error = PETSC_SQRT2 * size;
      if (last || error * norm <= allowed || looks.change <= WAVES_ROUNDING * PetscSqrtReal(largest)) break;
    }
    for (PetscInt i = 0; i < n; i++) w->basis[(size_t)m * n + i] /= w->beta[m - 1];
  }
  for (PetscInt i = 0; i < n; i++) f[i] = 0;
  for (PetscInt i = 0; i < m; i++) Axpy(n, norm * w->c[i], w->basis + (size_t)i * n, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes y = H x. As half of the padded row's wavenumbers stand for two each, its square is 2 sum_k |e_k|^2 / P, at
   most the square of the largest |e_k|. */
static PetscErrorCode Product(void *ctx, Vec x, PetscReal allowed, PetscReal relative, Vec y)
{
  WavesContext *w = (WavesContext *)ctx;
  SlipTransposedFFT pencil = w->plane->pencil;
  const SlipToeplitzSymbol *root;
  const PetscReal *diagonal;

  PetscFunctionBegin;
  if (w->factor == 0) {
    PetscCall(VecZeroEntries(y));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (allowed == 0) {
    /* relative to the approximate root's product */
    PetscCall(SlipToeplitzGetRoot(w->plane, &root, &diagonal));
    PetscCall(SlipToeplitzApply(w->plane, w->factor * PetscSqrtReal(w->scale), root, x, y));
    PetscCall(VecNorm(y, NORM_2, &allowed));
    allowed *= relative;
  }
  PetscCall(SlipToeplitzForward(w->plane, x));
  for (PetscInt k = 0; k < pencil->layout.columns; k++)
    PetscCall(RootOfWave(w, k, allowed / w->factor, pencil->by_wave + (size_t)k * 2 * w->nz));
  PetscCall(SlipToeplitzBackward(w->plane, w->factor, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WavesMult(Mat H, Vec x, Vec y)
{
  WavesContext *w;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &w));
  PetscCall(SlipRecycledMult(&w->increment, WAVES_TOL, Product, w, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the diagonal of the approximate root, which is accurate enough for preconditioners. */
static PetscErrorCode WavesGetDiagonal(Mat H, Vec d)
{
  WavesContext *w;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &w));
  PetscCall(SlipToeplitzGetRootDiagonal(w->plane, w->factor * PetscSqrtReal(w->scale), d));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WavesDestroy(Mat H)
{
  WavesContext *w;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &w));
  PetscCall(SlipRecycledReset(&w->increment));
  PetscCall(PetscFree(w->basis));
  PetscCall(PetscFree4(w->alpha, w->beta, w->c, w->last));
  PetscCall(MatDestroy(&w->K));
  PetscCall(PetscFree(w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WavesState(Mat H, SlipState s)
{
  WavesContext *w;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &w));
  PetscCall(SlipRecycledState(&w->increment, H, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WavesAllow(Mat H, PetscReal tolerance)
{
  WavesContext *w;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &w));
  w->increment.least = tolerance;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ViscosityCreate_Waves(Mat K, PetscReal factor, Mat *H)
{
  const SlipShellOps ops = {
    .mult = WavesMult, .diagonal = WavesGetDiagonal, .destroy = WavesDestroy, .state = WavesState};
  WavesContext *w;
  const SlipGrid *grid;

  PetscFunctionBegin;
  PetscCall(PetscNew(&w));
  PetscCall(PetscObjectReference((PetscObject)K));
  w->K = K;
  w->factor = factor;
  PetscCall(SlipGridOf(K, &grid));
  PetscCall(SlipToeplitzOf(K, &w->plane));
  PetscCall(SlipGridScale(K, &w->scale));
  w->nz = grid->nz;
  w->max = PetscMin(WAVES_MAX, 2 * grid->nz);
  PetscCall(PetscMalloc1((size_t)(w->max + 1) * 2 * grid->nz, &w->basis));
  PetscCall(PetscMalloc4(w->max, &w->alpha, w->max, &w->beta, w->max, &w->c, w->max, &w->last));
  PetscCall(SlipShellCreateLike(K, "slipwaves", &ops, w, H));
  PetscCall(PetscObjectComposeFunction((PetscObject)*H, "MatSlipViscosityAllow_C", WavesAllow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the spectral viscosity with blocks or without: by the option, or with blocks if these take little memory. */
PetscErrorCode SlipViscosityCreate_Spectral(Mat K, PetscReal factor, Mat *H)
{
  const char *const choices[] = {"auto", "blocks", "lanczos"};
  const char *prefix;
  const SlipGrid *g;
  PetscInt choice = 0;

  PetscFunctionBegin;
  PetscCall(MatGetOptionsPrefix(K, &prefix));
  PetscCall(SlipGridOf(K, &g));
  PetscCheck(g, PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_WRONG,
             "A spectral viscosity needs a stiffness on a uniform grid; for other stiffnesses use sqrtm");
  PetscOptionsBegin(PetscObjectComm((PetscObject)K), prefix, "Viscosity by the square root per wavenumber", "Mat");
  PetscCall(PetscOptionsEList("-mat_slipspectral_type",
                              "A dense block per wavenumber, Lanczos' method in each product, or by size",
                              "MatCreateSlipViscosity", choices, 3, choices[0], &choice, NULL));
  PetscOptionsEnd();
  if (choice == 2 || (choice == 0 && WAVES_BYTES * (PetscReal)g->nx * PetscSqr((PetscReal)g->nz) > SLIP_MEMORY_MAX))
    PetscCall(ViscosityCreate_Waves(K, factor, H));
  else
    PetscCall(SlipViscosityCreate_SpectralBlocks(K, factor, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}
