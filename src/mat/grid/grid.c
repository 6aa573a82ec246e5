/* The uniform grid behind a stiffness: checks, its kernel values, and how a Mat remembers it. */
#include <slipmat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>

PetscErrorCode SlipGridCheck(MPI_Comm comm, const SlipGrid *g)
{
  PetscFunctionBegin;
  PetscCheck(g->nx > 0 && g->nz > 0, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Grid must have at least one cell each way, not %" PetscInt_FMT " x %" PetscInt_FMT, g->nx, g->nz);
  PetscCheck(g->nx <= PETSC_MAX_INT / g->nz, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Grid of %" PetscInt_FMT " x %" PetscInt_FMT " cells overflows PetscInt", g->nx, g->nz);
  PetscCheck(g->length_x > 0 && PetscIsNormalReal(g->length_x), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Length along strike must be positive and finite, not %g m", (double)g->length_x);
  PetscCheck(g->length_z > 0 && PetscIsNormalReal(g->length_z), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Length in depth must be positive and finite, not %g m", (double)g->length_z);
  PetscCheck(g->depth_top >= 0 && !PetscIsInfOrNanReal(g->depth_top), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Depth of the upper edge must be zero or positive and finite, not %g m", (double)g->depth_top);
  PetscCheck(g->shear_modulus > 0 && PetscIsNormalReal(g->shear_modulus), comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Shear modulus must be positive and finite, not %g Pa", (double)g->shear_modulus);
  PetscCheck(g->poisson_ratio > -1 && g->poisson_ratio < 0.5, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Poisson's ratio must lie in (-1, 0.5), not %g", (double)g->poisson_ratio);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGridCompose(Mat K, const SlipGrid *grid)
{
  SlipGrid *copy;

  PetscFunctionBegin;
  PetscCall(PetscNew(&copy));
  *copy = *grid;
  PetscCall(SlipObjectComposeData((PetscObject)K, "SlipGrid", copy, SlipContainerDestroyDefault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGridOf(Mat K, const SlipGrid **grid)
{
  PetscFunctionBegin;
  PetscCall(SlipObjectQueryData((PetscObject)K, "SlipGrid", grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same as averages over cells, all of whose edges are shared; symmetric as it is. */
static PetscReal AverageEntry(const SlipGrid *g, PetscInt d, PetscInt iz, PetscInt jz)
{
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz, dx = (PetscReal)d * a;
  const PetscReal zi = g->depth_top + ((PetscReal)iz + 0.5) * b, zj = g->depth_top + ((PetscReal)jz + 0.5) * b;
  const PetscReal G = g->shear_modulus,
                  direct = SlipAverageDirect_Private(G, g->poisson_ratio, SlipAverageCore(g->average), dx,
                                                     (PetscReal)PetscAbsInt(iz - jz) * b, a, b);
  PetscReal part[2];

  if (g->full_space) return direct;
  SlipAverageSurface_Private(G, g->poisson_ratio, SlipAverageCore(g->average), dx,
                             2 * g->depth_top + (PetscReal)(iz + jz + 1) * b, a, b, part);
  return direct + part[0] - zi * zj * part[1];
}

/* What averages over the cells at the border have on the diagonal beyond SlipGridEntry(), unscaled [Pa/m]: no cell
   shares their outer edges. The free surface is no edge. */
PetscReal SlipGridBorder(const SlipGrid *g, PetscInt ix, PetscInt iz)
{
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  const PetscReal G = g->shear_modulus, nu = g->poisson_ratio, ratio = SlipAverageBorderRatio(g->average);
  const PetscBool top = (PetscBool)(iz == 0 && (g->full_space || g->depth_top > SLIP_TOUCH * PetscMin(a, b)));
  const int in_depth = (ix == 0) + (ix == g->nx - 1), along_strike = (top ? 1 : 0) + (iz == g->nz - 1);

  return in_depth * SlipAverageBorder_Private(G, nu, PETSC_FALSE, a, 1, ratio) +
         along_strike * SlipAverageBorder_Private(G, nu, PETSC_TRUE, b, 1, ratio);
}

/* Symmetrised kernel between depths iz and jz, d cells apart along strike, unscaled [Pa/m]. */
PetscReal SlipGridEntry(const SlipGrid *g, PetscInt d, PetscInt iz, PetscInt jz)
{
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz, G = g->shear_modulus;
  const PetscReal zi = g->depth_top + ((PetscReal)iz + 0.5) * b, zj = g->depth_top + ((PetscReal)jz + 0.5) * b;

  if (g->average) return AverageEntry(g, d, iz, jz);
  if (g->full_space) return SlipKernelFullSpace(G, g->poisson_ratio, (PetscReal)d * a, (PetscReal)(iz - jz) * b, a, b);
  if (iz == jz) return SlipKernelHalfSpace(G, g->poisson_ratio, (PetscReal)d * a, zi, zj, a, b);
  return 0.5 * (SlipKernelHalfSpace(G, g->poisson_ratio, (PetscReal)d * a, zi, zj, a, b) +
                SlipKernelHalfSpace(G, g->poisson_ratio, (PetscReal)d * a, zj, zi, a, b));
}

void SlipGridKernel(const SlipGrid *g, PetscInt d, PetscReal block[])
{
  for (PetscInt iz = 0; iz < g->nz; iz++)
    for (PetscInt jz = 0; jz <= iz; jz++) block[iz * g->nz + jz] = block[jz * g->nz + iz] = SlipGridEntry(g, d, iz, jz);
}

PetscErrorCode SlipFirstEntry(Mat K, PetscReal *first)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const PetscScalar *d;
  PetscMPIInt rank;
  Vec diagonal;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(MatCreateVecs(K, NULL, &diagonal));
  PetscCall(MatGetDiagonal(K, diagonal));
  PetscCall(VecGetArrayRead(diagonal, &d));
  *first = rank ? 0 : PetscRealPart(d[0]);
  PetscCall(VecRestoreArrayRead(diagonal, &d));
  PetscCall(VecDestroy(&diagonal));
  PetscCallMPI(MPI_Bcast(first, 1, MPIU_REAL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipGridScale(Mat K, PetscReal *scale)
{
  const SlipGrid *grid;
  PetscReal first;

  PetscFunctionBegin;
  PetscCall(SlipGridOf(K, &grid));
  PetscCall(SlipFirstEntry(K, &first));
  *scale = first / SlipGridEntry(grid, 0, 0, 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}
