/*
  Viscosity of type "slipspectral": the square root per wavenumber of the problem made periodic along strike, and for
  the exact root also what that misses as a low-rank part for each mirror parity.
*/
#include <slipmat.h>
#include <slipstep/private/slipcompat.h>
#include <slipstep/private/slipmat.h>

typedef struct {
  Mat K; /* referenced: owns the strike engine */
  SlipStrike strike;
  PetscReal *blocks; /* [nk][nz][nz] [Pa s/m] */
  SlipLowRank correction[2];
  PetscReal *half_x, *half_y; /* scratch */
  PetscReal *y;               /* [N] */
  SlipGather gather;
} SpectralContext;

/* Largest eigenvalue in which products of the truncated exact root may be wrong, relative to the largest of the root
   itself; the sum of what is left out stays below 1e-10. */
#define SLIP_SQRT_CUTOFF 1e-11
/* Terms below this share of the norm are kept in single precision. */
#define SLIP_SQRT_SINGLE 3e-5

static PetscReal FoldWeight(PetscInt ix, PetscInt nx)
{
  return 2 * ix + 1 == nx ? 0.5 : PETSC_SQRT2 / 2;
}

/* y += low-rank part of the viscosity times x, whole fields. */
PetscErrorCode SlipSpectralAddCorrection(Mat H, const PetscReal x[], PetscReal y[])
{
  SpectralContext *c;
  const SlipGrid *g;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  SlipStrikeGet(c->strike, &g, NULL, NULL, NULL);
  for (PetscInt parity = 0; parity < 2; parity++) {
    SlipLowRank *m = &c->correction[parity];
    const PetscInt hx = SlipMirrorWidth(g->nx, parity);
    const PetscReal sign = parity ? -1 : 1;

    if (!m->rank) continue;
    for (PetscInt iz = 0; iz < g->nz; iz++) {
      const PetscReal *row = x + iz * g->nx;

      for (PetscInt ix = 0; ix < hx; ix++)
        c->half_x[iz * hx + ix] = FoldWeight(ix, g->nx) * (row[ix] + sign * row[g->nx - 1 - ix]);
    }
    PetscCall(PetscArrayzero(c->half_y, m->n));
    SlipLowRankApply(m, c->half_x, c->half_y);
    for (PetscInt iz = 0; iz < g->nz; iz++) {
      PetscReal *row = y + iz * g->nx;

      for (PetscInt ix = 0; ix < hx; ix++) {
        const PetscReal value = FoldWeight(ix, g->nx) * c->half_y[iz * hx + ix];

        row[ix] += value;
        row[g->nx - 1 - ix] += sign * value;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Blocks of the spectral part [Pa s/m] when H is of this type, else NULL. */
PetscErrorCode SlipSpectralGetBlocks(Mat H, SlipStrike *strike, const PetscReal **blocks)
{
  SpectralContext *c;
  PetscBool match;

  PetscFunctionBegin;
  *blocks = NULL;
  *strike = NULL;
  PetscCall(PetscObjectTypeCompare((PetscObject)H, "slipspectral", &match));
  if (!match) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatShellGetContext(H, &c));
  *blocks = c->blocks;
  *strike = c->strike;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpectralMult(Mat H, Vec x, Vec y)
{
  SpectralContext *c;
  const PetscReal *px;
  PetscReal *py;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  PetscCall(SlipGatherGet(&c->gather, x, &px));
  PetscCall(SlipStrikeApply(c->strike, 1, c->blocks, px, c->y));
  PetscCall(SlipSpectralAddCorrection(H, px, c->y));
  PetscCall(SlipGatherRestore(&c->gather, x, &px));
  PetscCall(VecGetArrayWrite(y, &py));
  PetscCall(PetscArraycpy(py, c->y + c->gather.start, c->gather.end - c->gather.start));
  PetscCall(VecRestoreArrayWrite(y, &py));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Diagonal entry of the low-rank part at cell (ix, iz). */
static PetscReal CorrectionDiagonal(SpectralContext *c, PetscInt nx, PetscInt ix, PetscInt iz)
{
  const PetscInt rx = PetscMin(ix, nx - 1 - ix);
  PetscReal sum = 0;

  for (PetscInt parity = 0; parity < 2; parity++) {
    SlipLowRank *m = &c->correction[parity];
    const PetscInt hx = SlipMirrorWidth(nx, parity);
    const PetscReal weight = 2 * rx + 1 == nx ? 1 : 0.5;

    if (rx >= hx) continue;
    sum += weight * SlipLowRankDiagonal(m, iz * hx + rx);
  }
  return sum;
}

static PetscErrorCode SpectralGetDiagonal(Mat H, Vec d)
{
  SpectralContext *c;
  const SlipGrid *g;
  PetscInt P, nk;
  PetscReal *pd;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  SlipStrikeGet(c->strike, &g, &P, &nk, NULL);
  PetscCall(VecGetArrayWrite(d, &pd));
  for (PetscInt i = c->gather.start; i < c->gather.end; i++) {
    const PetscInt iz = i / g->nx;
    PetscReal sum = 0;

    for (PetscInt k = 0; k < nk; k++)
      sum += (k == 0 || 2 * k == P ? 1 : 2) * c->blocks[((size_t)k * g->nz + iz) * g->nz + iz];
    pd[i - c->gather.start] = sum / (PetscReal)P + CorrectionDiagonal(c, g->nx, i % g->nx, iz);
  }
  PetscCall(VecRestoreArrayWrite(d, &pd));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpectralDestroy(Mat H)
{
  SpectralContext *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  for (PetscInt parity = 0; parity < 2; parity++) {
    PetscCall(SlipLowRankDestroy(&c->correction[parity]));
  }
  PetscCall(PetscFree(c->blocks));
  PetscCall(PetscFree3(c->half_x, c->half_y, c->y));
  PetscCall(SlipGatherDestroy(&c->gather));
  PetscCall(MatDestroy(&c->K));
  PetscCall(PetscFree(c));
  PetscCall(PetscObjectComposeFunction((PetscObject)H, "MatConvert_slipspectral_dense_C", NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* factor * sqrt(scale * K) per wavenumber; H of type "slipspectral" without a low-rank part. */
PetscErrorCode SlipViscosityCreate_Spectral(Mat K, PetscReal factor, Mat *H)
{
  SpectralContext *c;
  const SlipGrid *g;
  const PetscReal *values;
  PetscReal scale, *f;
  PetscInt nk, m, N;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  PetscCall(SlipStrikeOf(K, &c->strike));
  PetscCheck(c->strike, PetscObjectComm((PetscObject)K), PETSC_ERR_ARG_WRONG,
             "A spectral viscosity needs a stiffness on a uniform grid; for other stiffnesses use sqrtm");
  SlipStrikeGet(c->strike, &g, NULL, &nk, NULL);
  PetscCall(PetscObjectReference((PetscObject)K));
  c->K = K;
  PetscCall(SlipGridScale(K, &scale));
  PetscCall(SlipStrikeGetEigen(c->strike, &values, NULL));
  PetscCall(PetscMalloc1(nk * g->nz, &f));
  for (PetscInt i = 0; i < nk * g->nz; i++) f[i] = factor * PetscSqrtReal(scale * values[i]);
  PetscCall(PetscMalloc1((size_t)nk * g->nz * g->nz, &c->blocks));
  PetscCall(SlipStrikeFormBlocks(c->strike, f, c->blocks));
  PetscCall(PetscFree(f));
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(MatGetLocalSize(K, &m, NULL));
  PetscCall(PetscMalloc3(N, &c->half_x, N, &c->half_y, N, &c->y));
  PetscCall(MatCreateShell(PetscObjectComm((PetscObject)K), m, m, N, N, c, H));
  PetscCall(MatSetUp(*H));
  PetscCall(MatShellSetManageScalingShifts(*H));
  PetscCall(MatShellSetOperation(*H, MATOP_MULT, SlipMatShellFn(SpectralMult)));
  PetscCall(MatShellSetOperation(*H, MATOP_MULT_TRANSPOSE, SlipMatShellFn(SpectralMult)));
  PetscCall(MatShellSetOperation(*H, MATOP_GET_DIAGONAL, SlipMatShellFn(SpectralGetDiagonal)));
  PetscCall(MatShellSetOperation(*H, MATOP_DESTROY, SlipMatShellFn(SpectralDestroy)));
  PetscCall(SlipShellFinish(*H, "slipspectral"));
  PetscCall(SlipGatherCreate(*H, &c->gather));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One process: root block of one parity minus its spectral approximation, compressed. kernel: K's, unscaled; spectral: that
 * of H. */
static PetscErrorCode ComputeCorrection(const SlipGrid *g, PetscReal factor, PetscReal scale, const PetscReal kernel[],
                                        const PetscReal spectral[], PetscReal norm, PetscInt parity,
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
  PetscCall(SlipLowRankCompress(n, root, SLIP_SQRT_CUTOFF * norm, 5 * g->nz, m));
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

/* The exact root: spectral plus low rank. */
PetscErrorCode SlipViscosityCreate_SpectralExact(Mat K, PetscReal factor, Mat *H)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  SpectralContext *c;
  const SlipGrid *g;
  const PetscReal *values;
  PetscReal *kernel = NULL, *spectral = NULL, norm = 0, scale, smallest[2] = {PETSC_MAX_REAL, PETSC_MAX_REAL};
  PetscMPIInt rank, size;
  PetscInt nk;

  PetscFunctionBegin;
  PetscCall(SlipViscosityCreate_Spectral(K, factor, H));
  PetscCall(MatShellGetContext(*H, &c));
  PetscCall(SlipGridScale(K, &scale));
  SlipStrikeGet(c->strike, &g, NULL, &nk, NULL);
  PetscCall(SlipStrikeGetEigen(c->strike, &values, NULL));
  for (PetscInt i = 0; i < nk * g->nz; i++) norm = PetscMax(norm, factor * PetscSqrtReal(scale * values[i]));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (rank < 2) { /* one parity each, or both on a single rank */
    PetscCall(PetscMalloc2((size_t)nk * g->nz * g->nz, &kernel, (size_t)nk * g->nz * g->nz, &spectral));
    for (PetscInt d = 0; d < nk; d++) SlipGridKernel(g, d, kernel + (size_t)d * g->nz * g->nz);
    PetscCall(PetscArraycpy(spectral, c->blocks, (size_t)nk * g->nz * g->nz));
    PetscCall(SlipStrikeBlocksToKernel(c->strike, spectral));
  }
  for (PetscInt parity = 0; parity < 2; parity++) {
    c->correction[parity].n = SlipMirrorWidth(g->nx, parity) * g->nz;
    if (c->correction[parity].n && rank == parity % size)
      PetscCall(
        ComputeCorrection(g, factor, scale, kernel, spectral, norm, parity, &smallest[parity], &c->correction[parity]));
  }
  PetscCall(PetscFree2(kernel, spectral));
  for (PetscInt parity = 0; parity < 2; parity++) {
    if (c->correction[parity].n == 0) continue;
    PetscCall(BroadcastCorrection(comm, (PetscMPIInt)(parity % size), &c->correction[parity]));
    PetscCall(SlipLowRankDemote(&c->correction[parity], SLIP_SQRT_SINGLE * norm));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, smallest, 2, MPIU_REAL, MPI_MIN, comm));
  PetscCheck(PetscMin(smallest[0], smallest[1]) > 0, comm, PETSC_ERR_ARG_WRONG,
             "The stiffness has no real square root: its smallest eigenvalue is %g Pa/m",
             (double)PetscMin(smallest[0], smallest[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
