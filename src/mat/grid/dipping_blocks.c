/*
  A real block per wavenumber along strike for the stress of slip on a dipping plane on the plane itself.

  Stress along c for slip along d, strike s or up dip t, depends on the distance x along strike: T_ss, T_tt and T_nt,
  the normal stress by t, are even in x, and T_st, T_ts and T_ns are odd. Opening is as slip up dip. Transforms of odd
  ones are -i times sine transforms. If i times the component up dip replaces this component, of slip and of shear
  stress, all is real:

     (y_s, i y_t) = X (f_s, i f_t),   X = (T_ss, -T_st; T_ts, T_tt),   y_n = -i (T_ns, T_nt) (f_s, i f_t)

  with transforms by cosines and sines. The symmetric part of the stiffness has the symmetric part of X.

  In a full space stress depends on the distance in depth only, in which the same pairs are even or odd. Transforms in
  depth then make X a real number for an even pair and an imaginary one for an odd pair, at each pair of wavenumbers.
*/
#include <slipstep/rooms/slipmat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>

enum { STRIKE, DIP, NORMAL };

/* Tables of traction by slip along strike, up dip or opening; tables are odd or even along strike */
typedef struct {
  PetscInt count;
  PetscInt traction[3];
  PetscBool odd[3];
} Tables;

static Tables TablesOf(PetscInt n, const PetscInt component[], PetscBool normal, PetscInt slip)
{
  Tables t = {.count = n + (normal ? 1 : 0)};

  for (PetscInt i = 0; i < t.count; i++) {
    t.traction[i] = i < n ? component[i] : NORMAL;
    t.odd[i] = (PetscBool)((t.traction[i] == STRIKE) != (slip == STRIKE));
  }
  return t;
}

/* Computes the centre of the cell of row iz that is d cells along strike from the first. */
static void CentreOf(const SlipDippingGrid *g, PetscInt d, PetscInt iz, PetscReal point[3])
{
  const PetscReal down = ((PetscReal)iz + 0.5) * g->grid.length_z / (PetscReal)g->grid.nz;
  PetscReal sine, cosine;

  SlipDegrees(g->dip, &sine, &cosine);
  point[0] = (PetscReal)d * g->grid.length_x / (PetscReal)g->grid.nx;
  point[1] = cosine * down;
  point[2] = g->grid.depth_top + sine * down;
}

static SlipDippingRectangle CellOf(const SlipDippingGrid *g, PetscInt iz)
{
  PetscReal p[3];

  CentreOf(g, 0, iz, p);
  return (SlipDippingRectangle){
    p[0], p[1], p[2], g->grid.length_x / (PetscReal)g->grid.nx, g->grid.length_z / (PetscReal)g->grid.nz, 0, g->dip};
}

/* Computes the traction [3] of slip along each component on a cell of row iz at its own centre: along that component,
   and normal. */
PetscErrorCode SlipDippingOwn(const SlipDippingGrid *g, PetscInt iz, PetscReal shear[3], PetscReal normal[3])
{
  const SlipKernel *kernel = &g->grid.kernel;
  const SlipDippingRectangle cell = CellOf(g, iz);
  PetscReal point[3], traction[3];

  PetscFunctionBegin;
  CentreOf(g, 0, iz, point);
  for (PetscInt d = 0; d < PetscMax(2, kernel->type->components); d++) {
    PetscCall((*kernel->type->plane)(kernel, &cell, d, 1, point, traction));
    shear[d] = traction[d];
    normal[d] = d == STRIKE ? 0 : traction[NORMAL]; /* 0 as it is odd */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the tables of slip on the first cell of row jz: row[period / 2 + 1][table][nz], zero beyond the grid, for the
   first nz rows of receivers. points and traction [nz][3] are work. */
static PetscErrorCode FillRow(const SlipDippingGrid *g, PetscInt slip, const Tables *t, PetscInt jz, PetscInt nz,
                              PetscReal points[], PetscReal traction[], PetscReal row[])
{
  const SlipKernel *kernel = &g->grid.kernel;
  const SlipDippingRectangle source = CellOf(g, jz);

  PetscFunctionBegin;
  for (PetscInt d = 0; d < g->grid.nx; d++) {
    for (PetscInt iz = 0; iz < nz; iz++) CentreOf(g, d, iz, points + 3 * iz);
    PetscCall((*kernel->type->plane)(kernel, &source, slip, nz, points, traction));
    for (PetscInt i = 0; i < t->count; i++)
      for (PetscInt iz = 0; iz < nz; iz++) row[(d * t->count + i) * nz + iz] = traction[3 * iz + t->traction[i]];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void TransformRow(PetscInt nk, PetscInt nz, const Tables *t, const fftw_plan plan[2], PetscReal row[])
{
  const PetscInt apart = t->count * nz;

  for (PetscInt i = 0; i < t->count; i++) {
    PetscReal *table = row + i * nz, *inside = table + apart;

    if (!t->odd[i]) {
      fftw_execute_r2r(plan[0], table, table);
      continue;
    }
    if (plan[1]) fftw_execute_r2r(plan[1], inside, inside);
    for (PetscInt iz = 0; iz < nz; iz++) table[iz] = table[(nk - 1) * apart + iz] = 0;
  }
}

/* Computes all tables of slip along one component, [local wavenumbers][source row][table][nz], of the first nz rows of
   receivers, which fftw_free() frees. Each rank computes some rows of sources. */
static PetscErrorCode TablesByWave(MPI_Comm comm, const SlipDippingGrid *g, PetscInt slip, const Tables *t, PetscInt nk,
                                   PetscInt nz, PetscReal **waves)
{
  const PetscInt apart = t->count * nz;
  const SlipLayout l = SlipLayoutOf(comm, g->grid.nz, nk, apart);
  const int length[2] = {(int)nk, (int)nk - 2};
  const fftw_r2r_kind kind[2] = {FFTW_REDFT00, FFTW_RODFT00};
  PetscReal *rows, *points, *traction;
  fftw_plan plan[2];

  PetscFunctionBegin;
  PetscCall(SlipAllocate(l.size, &rows));
  PetscCall(PetscMalloc2(3 * nz, &points, 3 * nz, &traction));
  /* for the even tables, and for the odd ones without the ends, which are 0; NULL: none */
  for (int odd = 0; odd < 2; odd++) {
    plan[odd] = NULL;
    if (length[odd] < 1) continue;
    plan[odd] = fftw_plan_many_r2r(1, &length[odd], (int)nz, rows, NULL, (int)apart, 1, rows, NULL, (int)apart, 1,
                                   &kind[odd], FFTW_ESTIMATE | FFTW_UNALIGNED);
    PetscCheck(plan[odd], PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a transform of length %d", length[odd]);
  }
  for (PetscInt j = 0; j < l.rows; j++) {
    PetscReal *row = rows + (size_t)j * nk * apart;

    PetscCall(FillRow(g, slip, t, l.row_start + j, nz, points, traction, row));
    TransformRow(nk, nz, t, plan, row);
  }
  for (int odd = 0; odd < 2; odd++)
    if (plan[odd]) fftw_destroy_plan(plan[odd]);
  PetscCall(PetscFree2(points, traction));
  PetscCall(SlipAllocate(l.size, waves));
  PetscCall(SlipTranspose(comm, g->grid.nz, nk, apart, rows, *waves));
  fftw_free(rows);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the symmetric part of X, above, [n nz][n nz] from this wavenumber's tables of slip along each component. */
static void StiffnessBlock(PetscInt n, PetscInt nz, PetscInt tables, PetscReal *const waves[], PetscReal X[])
{
  const PetscInt m = n * nz;

  for (PetscInt d = 0; d < n; d++)
    for (PetscInt jz = 0; jz < nz; jz++)
      for (PetscInt c = 0; c < n; c++)
        for (PetscInt iz = 0; iz < nz; iz++) {
          const PetscReal entry = waves[d][(jz * tables + c) * nz + iz];

          X[(size_t)(d * nz + jz) * m + c * nz + iz] = c == 0 && d > 0 ? -entry : entry; /* along strike */
        }
  for (PetscInt j = 0; j < m; j++)
    for (PetscInt i = 0; i <= j; i++)
      X[(size_t)j * m + i] = X[(size_t)i * m + j] = 0.5 * (X[(size_t)j * m + i] + X[(size_t)i * m + j]);
}

/* Computes the blocks of this rank's nk_local wavenumbers of period / 2 + 1: halves of symmetric ones for the
   stiffness, and [n nz][nz] for normal stress unless that is NULL; n components of slip. free() frees both.
   Collective. */
PetscErrorCode SlipDippingBlocks(MPI_Comm comm, const SlipDippingGrid *g, PetscInt period, PetscInt nk_local,
                                 PetscInt n, const PetscInt component[], PetscReal **stiffness, PetscReal **normal)
{
  const PetscInt nz = g->grid.nz, m = n * nz, tables = n + (normal ? 1 : 0);
  const size_t half = SlipSymmetricHalf(m, NULL, NULL), wave = (size_t)nz * tables * nz;
  PetscReal *waves[3] = {NULL, NULL, NULL}, *X;

  PetscFunctionBegin;
  for (PetscInt d = 0; d < n; d++) {
    const Tables t = TablesOf(n, component, normal ? PETSC_TRUE : PETSC_FALSE, component[d]);

    PetscCall(TablesByWave(comm, g, component[d], &t, period / 2 + 1, nz, &waves[d]));
  }
  PetscCall(SlipAllocateLines((size_t)nk_local * half, stiffness));
  if (normal) PetscCall(SlipAllocateLines((size_t)nk_local * nz * m, normal));
  PetscCall(PetscMalloc1((size_t)m * m, &X));
  for (PetscInt k = 0; k < nk_local; k++) {
    PetscReal *const own[3] = {waves[0] + k * wave, n > 1 ? waves[1] + k * wave : NULL,
                               n > 2 ? waves[2] + k * wave : NULL};

    StiffnessBlock(n, nz, tables, own, X);
    (void)SlipSymmetricHalf(m, X, *stiffness + k * half);
    for (PetscInt j = 0; j < m && normal; j++)
      PetscCall(PetscArraycpy(*normal + ((size_t)k * m + j) * nz, own[j / nz] + ((j % nz) * tables + n) * nz, nz));
  }
  PetscCall(PetscFree(X));
  for (PetscInt d = 0; d < n; d++) fftw_free(waves[d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether stress depends on the distance in depth only. */
PetscBool SlipDippingSteady(const SlipDippingGrid *g)
{
  return SlipKernelIs(&g->grid.kernel, SLIP_EVEN_DEPTH);
}

/* Computes the transforms of the blocks in depth, of an even length Q, over Q: [local wavenumbers][pairs (c, d) of
   components, c <= d][Q / 2 + 1], of even pairs the real and of odd ones the imaginary part. free() frees them.
   Collective. */
PetscErrorCode SlipDippingSymbol(MPI_Comm comm, const SlipDippingGrid *g, PetscInt period, PetscInt nk_local,
                                 PetscInt n, const PetscInt component[], PetscInt Q, PetscReal **symbol)
{
  const PetscInt nz = g->grid.nz, half = Q / 2 + 1;
  const fftw_r2r_kind kind[2] = {FFTW_REDFT00, FFTW_RODFT00};
  PetscReal *waves[3] = {NULL, NULL, NULL}, *at;
  fftw_plan plan[2] = {NULL, NULL};
  Tables t[3];

  PetscFunctionBegin;
  for (PetscInt d = 0; d < n; d++) {
    t[d] = TablesOf(n, component, PETSC_FALSE, component[d]);
    PetscCall(TablesByWave(comm, g, component[d], &t[d], period / 2 + 1, 1, &waves[d]));
  }
  PetscCall(SlipAllocateLines((size_t)nk_local * n * (n + 1) / 2 * half, symbol));
  PetscCall(PetscArrayzero(*symbol, (size_t)nk_local * n * (n + 1) / 2 * half));
  for (int odd = 0; odd < 2; odd++) {
    const PetscInt length = half - 2 * odd; /* odd functions are 0 at both ends */

    if (length < 1 || !nk_local) continue;
    plan[odd] = fftw_plan_r2r_1d((int)length, *symbol, *symbol, kind[odd], FFTW_ESTIMATE | FFTW_UNALIGNED);
    PetscCheck(plan[odd], PETSC_COMM_SELF, PETSC_ERR_LIB, "FFTW cannot plan a transform of length %" PetscInt_FMT,
               length);
  }
  at = *symbol;
  for (PetscInt k = 0; k < nk_local; k++)
    for (PetscInt c = 0; c < n; c++)
      for (PetscInt d = c; d < n; d++, at += half) {
        const PetscBool odd = t[d].odd[c];

        /* the symmetric part of the block, for a receiver j rows above the source */
        for (PetscInt j = odd ? 1 : 0; j < nz; j++) {
          const PetscReal upper = waves[d][(k * nz + j) * n + c], lower = waves[c][(k * nz + j) * n + d];

          at[j] = (odd ? 0.5 * (-upper - lower) : 0.5 * (upper + lower)) / (PetscReal)Q;
        }
        if (plan[odd]) fftw_execute_r2r(plan[odd], at + odd, at + odd);
      }
  for (int odd = 0; odd < 2; odd++)
    if (plan[odd]) fftw_destroy_plan(plan[odd]);
  for (PetscInt d = 0; d < n; d++) fftw_free(waves[d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
