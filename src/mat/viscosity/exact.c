/*
  The exact root on a uniform grid: what the root per wavenumber misses, for each mirror parity, as a low-rank part,
  from dense eigenproblems, sketches or the cache.
*/
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

/* Up to this many cells the low-rank part comes from dense eigenproblems of half the order (as fast, measured);
   beyond, or to ask for it by option, from sketches. */
#define SLIP_SQRT_DENSE_MAX 1024
/* Bytes that set-up takes for each cell and each cell of the longer side: blocks of three operators and the low-rank
   part (measured at 200 x 200). */
#define SLIP_SQRT_BYTES 180.0
/* Terms below this share of the norm are kept in single precision, whose rounding, 3e-13 of the norm, depends on how
   the rows are spread over ranks. */
#define SLIP_SQRT_SINGLE 4e-6

/* One process: root block of one parity minus its spectral approximation, compressed. kernel: K's, unscaled; spectral:
   that of H. */
static PetscErrorCode ComputeCorrection(const SlipGrid *g, PetscReal factor, PetscReal scale, const PetscReal kernel[],
                                        const PetscReal spectral[], PetscReal cutoff, PetscInt parity,
                                        PetscReal *smallest, SlipLowRank *m)
{
  const PetscInt n = SlipMirrorWidth(g->nx, parity) * g->nz;
  PetscReal *root, *approximate;
  PetscInt info;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2((size_t)n * n, &root, (size_t)n * n, &approximate));
  SlipMirrorSplit(g->nx, g->nz, kernel, scale, parity, root);
  PetscCall(SlipDenseSqrt(n, root, smallest, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "Eigenvalues of the stiffness did not converge (LAPACK info %" PetscInt_FMT ")", info);
  SlipMirrorSplit(g->nx, g->nz, spectral, 1, parity, approximate);
  for (size_t i = 0; i < (size_t)n * n; i++) root[i] = factor * root[i] - approximate[i];
  PetscCall(SlipLowRankCompress(n, root, cutoff, 5 * g->nz, m));
  PetscCall(PetscFree2(root, approximate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives every rank what the root found. */
static PetscErrorCode BroadcastCorrection(MPI_Comm comm, PetscMPIInt root, SlipLowRank *m)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Bcast(&m->rank, 1, MPIU_INT, root, comm));
  if (rank != root) {
    PetscCall(PetscMalloc1((size_t)m->n * m->rank, &m->W));
    PetscCall(PetscMalloc1(m->rank, &m->lambda));
  }
  for (PetscInt k = 0; k < m->rank; k++)
    PetscCallMPI(MPI_Bcast(m->W + (size_t)k * m->n, (int)m->n, MPIU_REAL, root, comm));
  PetscCallMPI(MPI_Bcast(m->lambda, (int)m->rank, MPIU_REAL, root, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How the exact root is set up: the options. */
typedef struct {
  PetscReal tolerance; /* of products, relative to the norm */
  PetscBool dense;     /* from dense eigenproblems */
  PetscBool lanczos;   /* no set-up at all */
} SqrtOptions;

static PetscErrorCode GetOptions(MPI_Comm comm, const SlipGrid *g, SqrtOptions *o)
{
  const char *const choices[] = {"auto", "dense", "sketch", "lanczos"};
  const PetscReal N = (PetscReal)g->nx * (PetscReal)g->nz,
                  memory = SLIP_SQRT_BYTES * N * (PetscReal)PetscMax(g->nx, g->nz);
  PetscInt choice = 0;

  PetscFunctionBegin;
  o->tolerance = 1e-10;
  PetscOptionsBegin(comm, NULL, "Viscosity by the exact matrix square root", "Mat");
  PetscCall(PetscOptionsReal("-mat_slipsqrtm_tolerance", "Error of a product relative to the norm of the viscosity",
                             "MatCreateSlipViscosity", o->tolerance, &o->tolerance, NULL));
  PetscCall(PetscOptionsEList("-mat_slipsqrtm_setup",
                              "Low-rank part from dense eigenproblems, random sketches, none (Lanczos' method in each "
                              "product), or by size",
                              "MatCreateSlipViscosity", choices, 4, choices[0], &choice, NULL));
  PetscOptionsEnd();
  PetscCheck(o->tolerance >= 1e-12 && o->tolerance < 1, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "-mat_slipsqrtm_tolerance must lie in [1e-12, 1), not %g", (double)o->tolerance);
  o->lanczos = (PetscBool)(choice == 3 || (choice == 0 && memory > SLIP_MEMORY_MAX));
  o->dense = (PetscBool)(choice == 1 || (choice == 0 && g->nx * g->nz <= SLIP_SQRT_DENSE_MAX));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One process: the correction of one parity from dense matrices; blocks: those of the spectral part. */
static PetscErrorCode DenseCorrection(SlipCirculant strike, const PetscReal blocks[], PetscReal factor, PetscReal scale,
                                      PetscReal cutoff, PetscInt parity, PetscReal *smallest, SlipLowRank *m)
{
  const SlipGrid *g;
  PetscReal *kernel, *spectral;
  PetscInt nk;
  size_t size;

  PetscFunctionBegin;
  SlipCirculantGet(strike, &g, NULL, &nk, NULL);
  size = (size_t)nk * g->nz * g->nz;
  PetscCall(PetscMalloc2(size, &kernel, size, &spectral));
  for (PetscInt d = 0; d < nk; d++) SlipGridKernel(g, d, kernel + (size_t)d * g->nz * g->nz);
  PetscCall(PetscArraycpy(spectral, blocks, size));
  PetscCall(SlipCirculantBlocksToKernel(strike, spectral));
  PetscCall(ComputeCorrection(g, factor, scale, kernel, spectral, cutoff, parity, smallest, m));
  PetscCall(PetscFree2(kernel, spectral));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One process: the correction of one parity by one of the two methods, which need all wavenumbers. */
static PetscErrorCode BuildParity(SlipSpectral *c, PetscReal factor, PetscReal scale, PetscReal norm,
                                  const SqrtOptions *o, PetscInt parity, PetscReal *smallest, PetscReal *error,
                                  SlipLowRank *m)
{
  const PetscBool shared = (PetscBool)(SlipCirculantPencil(c->strike) != NULL);
  SlipCirculant whole = c->strike;
  PetscReal *blocks = c->blocks;
  const SlipGrid *g;

  PetscFunctionBegin;
  if (shared) {
    SlipCirculantGet(c->strike, &g, NULL, NULL, NULL);
    PetscCall(SlipCirculantCreate(PETSC_COMM_SELF, g, &whole));
    PetscCall(SlipSpectralRootBlocks(whole, factor, scale, &blocks));
  }
  if (o->dense)
    PetscCall(DenseCorrection(whole, blocks, factor, scale, 0.1 * o->tolerance * norm, parity, smallest, m));
  else
    PetscCall(SlipSketchCorrection(whole, blocks, factor * factor * scale, o->tolerance, parity, smallest, error, m));
  if (shared) {
    PetscCall(PetscFree(blocks));
    PetscCall(SlipCirculantDestroy(&whole));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The low-rank part, one parity a rank, or both on a single rank, where it is left. */
static PetscErrorCode BuildCorrection(MPI_Comm comm, SlipSpectral *c, PetscReal factor, PetscReal scale,
                                      const SqrtOptions *o)
{
  PetscReal norm = 0, bad[2] = {-PETSC_MAX_REAL, 0}; /* minus the smallest eigenvalue; error */
  PetscMPIInt rank, size;

  PetscFunctionBegin;
  PetscCall(SlipSpectralNorm(comm, c, factor, scale, &norm));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  for (PetscInt parity = 0; parity < 2; parity++) {
    SlipLowRank *m = &c->correction[parity];
    PetscReal smallest = PETSC_MAX_REAL, error = 0;

    if (!m->n || rank != parity % size) continue;
    PetscCall(BuildParity(c, factor, scale, norm, o, parity, &smallest, &error, m));
    bad[0] = PetscMax(bad[0], -smallest);
    bad[1] = PetscMax(bad[1], error);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bad, 2, MPIU_REAL, MPI_MAX, comm));
  PetscCheck(bad[0] < 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: an eigenvalue is not positive");
  PetscCheck(bad[1] <= o->tolerance, comm, PETSC_ERR_NOT_CONVERGED,
             "The exact root was found to %g only, not to -mat_slipsqrtm_tolerance %g", (double)bad[1],
             (double)o->tolerance);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The low-rank part on every rank, from the cache or built and kept there. Eigenvalues go through units of a unit
   factor, so that a run rounds alike whether it built them or read them. */
static PetscErrorCode GetCorrection(Mat K, SlipSpectral *c, PetscReal factor, PetscReal scale, const SqrtOptions *o)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const PetscReal unit = factor * PetscSqrtReal(scale);
  const SlipGrid *g;
  PetscBool found;
  PetscMPIInt size;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  SlipCirculantGet(c->strike, &g, NULL, NULL, NULL);
  PetscCall(SlipCacheLoad(K, g, o->tolerance, o->dense, c->correction, &found));
  if (!found) PetscCall(BuildCorrection(comm, c, factor, scale, o));
  for (PetscInt parity = 0; parity < 2; parity++) {
    SlipLowRank *m = &c->correction[parity];

    if (!m->n) continue;
    PetscCall(BroadcastCorrection(comm, found ? 0 : (PetscMPIInt)(parity % size), m));
    for (PetscInt k = 0; k < m->rank && !found; k++) m->lambda[k] /= unit;
  }
  if (!found) PetscCall(SlipCacheSave(K, g, o->tolerance, o->dense, c->correction));
  for (PetscInt parity = 0; parity < 2; parity++)
    for (PetscInt k = 0; k < c->correction[parity].rank; k++) c->correction[parity].lambda[k] *= unit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where ranks share the work, each keeps its rows of the low-rank part only; a row of cells has width coefficients. */
static PetscErrorCode KeepRows(SlipSpectral *c, PetscInt width, SlipLowRank *m)
{
  PetscInt start, rows;
  PetscReal *W;

  PetscFunctionBegin;
  if (!SlipCirculantPencil(c->strike)) PetscFunctionReturn(PETSC_SUCCESS);
  SlipSpectralRows(c, &start, &rows);
  PetscCall(PetscMalloc1((size_t)rows * width * m->rank, &W));
  for (PetscInt k = 0; k < m->rank; k++)
    PetscCall(PetscArraycpy(W + (size_t)k * rows * width, m->W + (size_t)k * m->n + start * width, rows * width));
  PetscCall(PetscFree(m->W));
  m->W = W;
  m->n = rows * width;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The exact root: spectral plus low rank. */
PetscErrorCode SlipViscosityCreate_SpectralExact(Mat K, PetscReal factor, Mat *H)
{
  SlipSpectral *c;
  SqrtOptions o;
  const SlipGrid *g;
  PetscReal norm = 0, scale;

  PetscFunctionBegin;
  PetscCall(SlipGridOf(K, &g));
  PetscCall(GetOptions(PetscObjectComm((PetscObject)K), g, &o));
  if (o.lanczos) {
    PetscCall(SlipViscosityCreate_Lanczos(K, factor, H));
    PetscCall(MatSlipViscositySetTolerance(*H, o.tolerance));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipViscosityCreate_SpectralBlocks(K, factor, H));
  if (factor == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(*H, &c));
  PetscCall(SlipGridScale(K, &scale));
  for (PetscInt parity = 0; parity < 2; parity++) c->correction[parity].n = SlipMirrorWidth(g->nx, parity) * g->nz;
  PetscCall(GetCorrection(K, c, factor, scale, &o));
  c->tolerance = o.tolerance;
  PetscCall(SlipSpectralNorm(PetscObjectComm((PetscObject)K), c, factor, scale, &norm));
  for (PetscInt parity = 0; parity < 2; parity++) {
    if (!c->correction[parity].n) continue;
    PetscCall(KeepRows(c, SlipMirrorWidth(g->nx, parity), &c->correction[parity]));
    PetscCall(SlipLowRankDemote(&c->correction[parity], SLIP_SQRT_SINGLE * norm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
