/* MatCreateSlipDippingStiffness() and its table of types; products with both of its matrices. */
#include <petsc/private/petscimpl.h> /* methods */
#include <slipmat.h>
#include <slipsys.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatinterface.h>

/* Up to this many cells dense products are as fast as others. */
#define SLIP_DENSE_MAX 256

/* The cells of a grid, along its own strike; cells->x owns all columns. */
static PetscErrorCode CellsOf(const SlipDippingGrid *d, SlipCells *cells)
{
  const SlipGrid *g = &d->grid;
  const PetscInt N = g->nx * g->nz;
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  PetscReal *column[8], sine, cosine;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(8 * (size_t)N, &column[0]));
  for (PetscInt k = 1; k < 8; k++) column[k] = column[k - 1] + N;
  SlipDegrees(d->dip, &sine, &cosine);
  for (PetscInt e = 0; e < N; e++) {
    const PetscReal down = ((PetscReal)(e / g->nx) + 0.5) * b;
    const PetscReal value[8] = {
      ((PetscReal)(e % g->nx) + 0.5) * a, cosine * down, g->depth_top + sine * down, a, b, 0, d->dip, d->rake[e]};

    for (PetscInt k = 0; k < 8; k++) column[k][e] = value[k];
  }
  *cells = (SlipCells){.n = N,
                       .x = column[0],
                       .y = column[1],
                       .z = column[2],
                       .length = column[3],
                       .width = column[4],
                       .strike = column[5],
                       .dip = column[6],
                       .rake = column[7],
                       .kernel = g->kernel};
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateOfCells(MPI_Comm comm, const SlipDippingGrid *grid, const char type[], Mat *K, Mat *Kn)
{
  const PetscReal tolerance = 1e-8;
  SlipCells cells;

  PetscFunctionBegin;
  PetscCall(CellsOf(grid, &cells));
  PetscCall(MatCreateSlipCellStiffness(comm, &cells, type, tolerance, K));
  if (Kn) PetscCall(MatCreateSlipCellNormalStiffness(comm, &cells, type, tolerance, Kn));
  PetscCall(SlipCellsDestroy(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateByTransforms(MPI_Comm comm, const SlipDippingGrid *grid, const char type[], Mat *K, Mat *Kn)
{
  SlipCells cells;

  PetscFunctionBegin;
  PetscCall(CellsOf(grid, &cells));
  PetscCall(SlipCellsCheck(comm, &cells, "cells"));
  PetscCall(SlipCellsDestroy(&cells));
  PetscCheck(grid->grid.kernel.type->normals == 1, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has no row of normal stress, expected one that has, such as SlipKernelDipping",
             grid->grid.kernel.type->name);
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipDippingCreate_FFT(comm, grid, K, Kn));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*K, SLIP_StiffnessMult));
  if (Kn) PetscCall(SlipLogProducts(*Kn, SLIP_StiffnessMult));
  PetscCall(SlipNote(*K, "SlipWhy", "%s as asked", type));
  PetscCall(MatSetOption(*K, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One row per type. */
static const struct {
  const char *name;
  PetscErrorCode (*create)(MPI_Comm, const SlipDippingGrid *, const char[], Mat *, Mat *);
} SlipDippingTypes[] = {
  {"dense", CreateOfCells},
  {"hmat", CreateOfCells},
  {"fft", CreateByTransforms},
};

/*@C
  MatCreateSlipDippingStiffness - stiffness of a uniform grid of cells on a plane of any dip, and what slip does to its
  normal stress

  Collective

  Input Parameters:
+ comm - communicator
. grid - cells, extents [m], dip and rakes [deg], and a kernel that has a row of normal stress, such as SlipKernelDipping
- type - "dense" (MATDENSE), "hmat" (hierarchical) or "auto"

  Output Parameters:
+ K  - symmetric N x N matrix [Pa/m], N = nx * nz, rows distributed by PETSC_DECIDE: the symmetric part of the stress drop
       along its rake at the centre of cell i for unit slip on cell j
- Kn - compression of the centre of cell i for unit slip on cell j [Pa/m], not symmetric; NULL where it is not wanted

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a bad grid, those of SlipKernelCheck(), PETSC_ERR_SUP for a kernel without normal
  stress, PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown type

  Level: intermediate

.seealso: MatCreateSlipStiffness(), MatSlipStiffnessMultBoth(), MatCreateSlipCellNormalStiffness()
@*/
PetscErrorCode MatCreateSlipDippingStiffness(MPI_Comm comm, const SlipDippingGrid *grid, const char *type, Mat *K,
                                             Mat *Kn)
{
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipDippingTypes);
  PetscBool match;
  PetscInt k;

  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCheck(grid->dip > 0 && grid->dip <= 90, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Dip must lie in (0, 90] degrees, not %g", (double)grid->dip);
  PetscCall(PetscStrcmp(type, "auto", &match));
  if (match) type = grid->grid.nx * grid->grid.nz > SLIP_DENSE_MAX ? "hmat" : "dense";
  for (k = 0; k < ntypes; k++) {
    PetscCall(PetscStrcmp(type, SlipDippingTypes[k].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "The stiffness of a dipping grid cannot be of type \"%s\"; known: dense, hmat, fft, auto", type);
  PetscCall(SlipDippingTypes[k].create(comm, grid, type, K, Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MatSlipStiffnessMultBoth - stress drop and compression by slip at once

  Collective

  Input Parameters:
+ K  - stiffness
. Kn - what slip does to normal stress, as made with K, or any other
- u  - slip [m]

  Output Parameters:
+ f - K u [Pa]
- n - Kn u [Pa]

  Note: matrices by transforms that were made together share what they need of u; others are two products

  Level: intermediate

.seealso: MatCreateSlipDippingStiffness(), MatCreateSlipCellNormalStiffness()
@*/
PetscErrorCode MatSlipStiffnessMultBoth(Mat K, Mat Kn, Vec u, Vec f, Vec n)
{
  PetscErrorCode (*both)(Mat, Mat, Vec, Vec, Vec);

  PetscFunctionBegin;
  PetscCall(PetscObjectQueryFunction((PetscObject)Kn, "MatSlipStiffnessMultBoth_C", &both));
  if (both) {
    PetscCall((*both)(K, Kn, u, f, n));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatMult(K, u, f));
  PetscCall(MatMult(Kn, u, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}
