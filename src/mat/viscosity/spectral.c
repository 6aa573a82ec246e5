/*
  Viscosity of type "slipspectral": the square root per wavenumber of the problem made periodic along strike. For the
  exact root the difference to it is a low-rank part for each mirror parity (exact.c).
*/
#include <slipcompat.h>
#include <slipstep/private/slipmatviscosity.h>

/* Gets the rows of cells on which this process works: all rows, or its share. */
void SlipSpectralRows(SlipSpectral *c, PetscInt *start, PetscInt *rows)
{
  SlipTransposedFFT pencil = SlipCirculantPencil(c->strike);
  const SlipGrid *g;

  SlipCirculantGet(c->strike, &g, NULL, NULL, NULL);
  *start = pencil ? pencil->layout.row_start : 0;
  *rows = pencil ? pencil->layout.rows : g->nz;
}

/* Adds to y the low-rank part of the viscosity, its terms above cutoff, times x; both are whole fields or this rank's
   rows of them. Collective. */
PetscErrorCode SlipSpectralAddCorrection(Mat H, PetscReal cutoff, const PetscReal x[], PetscReal y[])
{
  SlipSpectral *c;
  const SlipGrid *g;
  PetscInt start, rows;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  SlipCirculantGet(c->strike, &g, NULL, NULL, NULL);
  SlipSpectralRows(c, &start, &rows);
  for (PetscInt parity = 0; parity < 2; parity++) {
    SlipLowRank *m = &c->correction[parity];

    if (!m->rank) continue;
    SlipMirrorFold(g->nx, rows, parity, x, c->half_x);
    PetscCall(PetscArrayzero(c->half_y, m->n));
    PetscCall(SlipLowRankApply(m, SlipCirculantPencil(c->strike) ? PetscObjectComm((PetscObject)H) : PETSC_COMM_SELF,
                               cutoff, c->half_x, c->half_y));
    SlipMirrorUnfold(g->nx, rows, parity, c->half_y, y);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the blocks of the spectral part [Pa s/m] if H is of this type, otherwise NULL. */
PetscErrorCode SlipSpectralGetBlocks(Mat H, SlipCirculant *strike, const PetscReal **blocks)
{
  SlipSpectral *c;
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

/* Computes y = H x; the product of an increment, which needs less accuracy, has fewer terms of the low-rank part. */
static PetscErrorCode Product(void *ctx, Vec x, PetscReal allowed, PetscReal relative, Vec y)
{
  Mat H = (Mat)ctx;
  SlipSpectral *c;
  const PetscReal *px;
  PetscReal norm = 0;

  PetscFunctionBegin;
  (void)relative;
  PetscCall(MatShellGetContext(H, &c));
  if (allowed > 0) PetscCall(VecNorm(x, NORM_2, &norm));
  PetscCall(SlipGatherGet(&c->gather, x, &px));
  PetscCall(SlipCirculantApply(c->strike, 1, c->blocks, px, c->y));
  PetscCall(SlipSpectralAddCorrection(H, norm > 0 ? allowed / norm : 0, px, c->y));
  PetscCall(SlipGatherRestore(&c->gather, x, &px));
  PetscCall(SlipGatherPut(&c->gather, c->y, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpectralMult(Mat H, Vec x, Vec y)
{
  SlipSpectral *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  if (c->tolerance > 0)
    PetscCall(SlipRecycledMult(&c->increment, c->tolerance, Product, H, x, y));
  else
    PetscCall(Product(H, x, 0, 0, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the diagonal entry of the low-rank part at cell (ix, iz). */
static PetscReal CorrectionDiagonal(SlipSpectral *c, PetscInt nx, PetscInt ix, PetscInt iz)
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
  SlipSpectral *c;
  const SlipGrid *g;
  SlipTransposedFFT pencil;
  PetscInt start, rows, P, nk, first;
  PetscReal *sum;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  if (c->diagonal) {
    PetscCall(VecCopy(c->diagonal, d));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  SlipCirculantGet(c->strike, &g, &P, &nk, NULL);
  SlipSpectralRows(c, &start, &rows);
  pencil = SlipCirculantPencil(c->strike);
  first = pencil ? pencil->layout.column_start : 0;
  PetscCall(PetscMalloc1(g->nz, &sum));
  for (PetscInt iz = 0; iz < g->nz; iz++) { /* of the spectral part: the mean over all wavenumbers */
    sum[iz] = 0;
    for (PetscInt k = 0; k < nk; k++)
      sum[iz] += (first + k == 0 || 2 * (first + k) == P ? 1 : 2) * c->blocks[((size_t)k * g->nz + iz) * g->nz + iz];
    sum[iz] /= (PetscReal)P;
  }
  if (pencil)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, (int)g->nz, MPIU_REAL, MPI_SUM, PetscObjectComm((PetscObject)H)));
  for (PetscInt iz = 0; iz < rows; iz++)
    for (PetscInt ix = 0; ix < g->nx; ix++)
      c->y[iz * g->nx + ix] = sum[start + iz] + CorrectionDiagonal(c, g->nx, ix, iz);
  PetscCall(PetscFree(sum));
  PetscCall(SlipGatherPut(&c->gather, c->y, d));
  PetscCall(VecDuplicate(d, &c->diagonal));
  PetscCall(VecCopy(d, c->diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpectralGetInfo(Mat H, MatInfoType flag, MatInfo *info)
{
  SlipSpectral *c;
  const SlipGrid *g;
  PetscReal bytes;
  PetscInt nk, N;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  PetscCall(MatGetSize(H, &N, NULL));
  SlipCirculantGet(c->strike, &g, NULL, &nk, NULL);
  bytes = (PetscReal)sizeof(PetscReal) * ((PetscReal)nk * (PetscReal)(g->nz * g->nz) + 3 * (PetscReal)N);
  for (PetscInt parity = 0; parity < 2; parity++) {
    const SlipLowRank *m = &c->correction[parity];

    bytes += (PetscReal)m->n *
             (PetscReal)(m->head * (PetscInt)sizeof(PetscReal) + (m->rank - m->head) * (PetscInt)sizeof(float));
  }
  PetscCall(SlipInfoFill(H, bytes + SlipGatherBytes(&c->gather), flag, info));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpectralView(Mat H, PetscViewer viewer)
{
  SlipSpectral *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  PetscCall(PetscViewerASCIIPrintf(
    viewer,
    "viscosity per wavenumber along strike, plus %" PetscInt_FMT " even and %" PetscInt_FMT
    " odd terms of low rank, %" PetscInt_FMT " of them in double precision\n",
    c->correction[0].rank, c->correction[1].rank, c->correction[0].head + c->correction[1].head));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpectralDestroy(Mat H)
{
  SlipSpectral *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  for (PetscInt parity = 0; parity < 2; parity++) PetscCall(SlipLowRankDestroy(&c->correction[parity]));
  PetscCall(PetscFree(c->blocks));
  PetscCall(PetscFree3(c->half_x, c->half_y, c->y));
  PetscCall(SlipGatherDestroy(&c->gather));
  PetscCall(SlipRecycledReset(&c->increment));
  PetscCall(VecDestroy(&c->diagonal));
  PetscCall(MatDestroy(&c->K));
  PetscCall(PetscFree(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the blocks of factor * sqrt(scale * K). */
PetscErrorCode SlipSpectralRootBlocks(SlipCirculant strike, PetscReal factor, PetscReal scale, PetscReal **blocks)
{
  const SlipGrid *g;
  const PetscReal *values;
  PetscReal *f;
  PetscInt nk;

  PetscFunctionBegin;
  SlipCirculantGet(strike, &g, NULL, &nk, NULL);
  PetscCall(SlipCirculantGetEigen(strike, &values, NULL));
  PetscCall(PetscMalloc1(nk * g->nz, &f));
  for (PetscInt i = 0; i < nk * g->nz; i++) f[i] = factor * PetscSqrtReal(scale * values[i]);
  PetscCall(PetscMalloc1((size_t)nk * g->nz * g->nz, blocks));
  PetscCall(SlipCirculantFormBlocks(strike, f, *blocks));
  PetscCall(PetscFree(f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the largest eigenvalue of the spectral part. Collective. */
PetscErrorCode SlipSpectralNorm(MPI_Comm comm, SlipSpectral *c, PetscReal factor, PetscReal scale, PetscReal *norm)
{
  const SlipGrid *g;
  const PetscReal *values;
  PetscInt nk;

  PetscFunctionBegin;
  SlipCirculantGet(c->strike, &g, NULL, &nk, NULL);
  PetscCall(SlipCirculantGetEigen(c->strike, &values, NULL));
  *norm = 0;
  for (PetscInt i = 0; i < nk * g->nz; i++) *norm = PetscMax(*norm, factor * PetscSqrtReal(scale * values[i]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, norm, 1, MPIU_REAL, MPI_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipSpectralState(Mat H, SlipState s)
{
  SlipSpectral *c;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(H, &c));
  if (c->tolerance > 0) PetscCall(SlipRecycledState(&c->increment, H, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates H = factor * sqrt(scale * K) per wavenumber, of type "slipspectral" without a low-rank part. */
PetscErrorCode SlipViscosityCreate_SpectralBlocks(Mat K, PetscReal factor, Mat *H)
{
  const SlipShellOps ops = {.mult = SpectralMult,
                            .diagonal = SpectralGetDiagonal,
                            .info = SpectralGetInfo,
                            .view = SpectralView,
                            .destroy = SpectralDestroy,
                            .state = SlipSpectralState};
  SlipSpectral *c;
  PetscReal scale;
  PetscInt N;

  PetscFunctionBegin;
  PetscCall(PetscNew(&c));
  PetscCall(SlipCirculantOf(K, &c->strike));
  PetscCall(PetscObjectReference((PetscObject)K));
  c->K = K;
  PetscCall(SlipGridScale(K, &scale));
  PetscCall(SlipSpectralRootBlocks(c->strike, factor, scale, &c->blocks));
  PetscCall(MatGetSize(K, &N, NULL));
  PetscCall(PetscMalloc3(N, &c->half_x, N, &c->half_y, N, &c->y));
  PetscCall(SlipShellCreateLike(K, "slipspectral", &ops, c, H));
  PetscCall(SlipGatherCreate(*H, SlipCirculantPencil(c->strike), &c->gather));
  PetscFunctionReturn(PETSC_SUCCESS);
}
