/* The uniform grid of a stiffness: checks, its kernel values, and its composition with a Mat. */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatgrid.h>
#include <slipstep/private/slipwork.h>

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
  PetscCall(SlipKernelCheck(comm, &g->kernel));
  PetscCall(SlipKernelCheckComponents(comm, &g->kernel, 1));
  PetscCheck(SlipKernelIs(&g->kernel, SLIP_EVEN_STRIKE), comm, PETSC_ERR_SUP,
             "Kernel \"%s\" is not one of the distance along strike, which a uniform grid needs: expected "
             "SLIP_EVEN_STRIKE, or MatCreateSlipCellStiffness()",
             g->kernel.type->name);
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

/* Returns what averages over cells at the border add to SlipGridEntry() on the diagonal, unscaled [Pa/m], because no
   cell shares their outer edges. The free surface is no edge. */
PetscReal SlipGridBorder(const SlipGrid *g, PetscInt ix, PetscInt iz)
{
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  const SlipKernel *k = &g->kernel;
  const PetscReal ratio = SlipAverageBorderRatio(k->average);
  const PetscBool top = (PetscBool)(iz == 0 && (k->full_space || g->depth_top > SLIP_TOUCH * PetscMin(a, b)));
  const int in_depth = (ix == 0) + (ix == g->nx - 1), along_strike = (top ? 1 : 0) + (iz == g->nz - 1);

  if (!k->type->edge) return 0;
  return in_depth * k->type->edge(k, PETSC_FALSE, a, 1, ratio) +
         along_strike * k->type->edge(k, PETSC_TRUE, b, 1, ratio);
}

/* Returns the symmetrised kernel between depths iz and jz, d cells apart along strike, unscaled [Pa/m]. */
PetscReal SlipGridEntry(const SlipGrid *g, PetscInt d, PetscInt iz, PetscInt jz)
{
  const SlipKernel *k = &g->kernel;
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz, dx = (PetscReal)d * a;
  const PetscReal zi = g->depth_top + ((PetscReal)iz + 0.5) * b, zj = g->depth_top + ((PetscReal)jz + 0.5) * b;
  const PetscBool even = SlipKernelIs(k, SLIP_EVEN_DEPTH);
  SlipCell receiver = {.rectangle = {dx, 0, zi, a, b, 0, 90}, .rake = 0},
           source = {.rectangle = {0, 0, zj, a, b, 0, 90}, .rake = 0};
  PetscReal entry[SLIP_KERNEL_BLOCK], other[SLIP_KERNEL_BLOCK]; /* the first is shear stress */

  SlipWorkAdd(SLIP_WORK_KERNEL, 1);
  if (even || (k->average && k->type->surface)) {
    PetscReal part[2] = {0, 0};

    if (!even) k->type->surface(k, dx, 2 * g->depth_top + (PetscReal)(iz + jz + 1) * b, a, b, part);
    return SlipKernelDirect(k, dx, (PetscReal)PetscAbsInt(iz - jz) * b, a, b) + part[0] - zi * zj * part[1];
  }
  SlipKernelBlock(k, &receiver, &source, entry);
  if (iz == jz || k->average) return entry[0];
  receiver.rectangle.z = zj;
  source.rectangle.z = zi;
  SlipKernelBlock(k, &receiver, &source, other);
  return 0.5 * (entry[0] + other[0]);
}

void SlipGridKernel(const SlipGrid *g, PetscInt d, PetscReal block[])
{
  for (PetscInt iz = 0; iz < g->nz; iz++)
    for (PetscInt jz = 0; jz <= iz; jz++) block[iz * g->nz + jz] = block[jz * g->nz + iz] = SlipGridEntry(g, d, iz, jz);
}

PetscErrorCode SlipGridScale(Mat K, PetscReal *scale)
{
  MPI_Comm comm = PetscObjectComm((PetscObject)K);
  const SlipGrid *grid;
  const PetscScalar *d;
  PetscReal first;
  PetscMPIInt rank;
  Vec diagonal;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(SlipGridOf(K, &grid));
  PetscCall(MatCreateVecs(K, NULL, &diagonal));
  PetscCall(MatGetDiagonal(K, diagonal));
  PetscCall(VecGetArrayRead(diagonal, &d));
  first = rank ? 0 : PetscRealPart(d[0]);
  PetscCall(VecRestoreArrayRead(diagonal, &d));
  PetscCall(VecDestroy(&diagonal));
  PetscCallMPI(MPI_Bcast(&first, 1, MPIU_REAL, 0, comm));
  *scale = first / SlipGridEntry(grid, 0, 0, 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}
