/* MatCreateSlipDippingStiffness(), the same function for vectors of slip, their table of types, and products with both
   of their matrices. */
#include <petsc/private/petscimpl.h> /* methods */
#include <slipstep/rooms/slipmat.h>
#include <slipstep/rooms/slipsys.h>
#include <slipstep/private/slipelasticity.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/private/slipmatinterface.h>

/* Number of cells up to which dense products are as fast as others */
#define SLIP_DENSE_MAX 256
/* Ratio of cells along dip to those along strike above which hierarchical products of slip along dip are faster than
   blocks of cells along dip. Measured, K and Kn: 1.7 and 1.6 ms at 8 x 400 cells, 3.6 and 6.2 ms at 8 x 800, 0.3 and
   1.0 ms at 4 x 400, but 13 and 3.7 ms at 20 x 400. */
#define SLIP_DEEP 50

/* Creates the cells of a grid, along its own strike; cells->x owns all columns. */
static PetscErrorCode CellsOf(const SlipDippingGrid *d, SlipCells *cells)
{
  const SlipGrid *g = &d->grid;
  const PetscInt N = g->nx * g->nz;
  const PetscReal a = g->length_x / (PetscReal)g->nx, b = g->length_z / (PetscReal)g->nz;
  const PetscBool vector = (PetscBool)(g->kernel.type->components > 1);
  PetscReal *column[8], sine, cosine;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(8 * (size_t)N, &column[0]));
  for (PetscInt k = 1; k < 8; k++) column[k] = column[k - 1] + N;
  SlipDegrees(d->dip, &sine, &cosine);
  for (PetscInt e = 0; e < N; e++) {
    const PetscReal down = ((PetscReal)(e / g->nx) + 0.5) * b;
    const PetscReal value[8] = {((PetscReal)(e % g->nx) + 0.5) * a,
                                cosine * down,
                                g->depth_top + sine * down,
                                a,
                                b,
                                0,
                                d->dip,
                                vector ? 0 : d->rake[e]};

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
  const PetscReal tolerance = grid->tolerance != 0 ? grid->tolerance : (PetscReal)1e-8;
  SlipCells cells;

  PetscFunctionBegin;
  PetscCall(CellsOf(grid, &cells));
  if (cells.kernel.type->components > 1)
    PetscCall(MatCreateSlipCellVectorStiffness(comm, &cells, type, tolerance, K, Kn));
  else {
    PetscCall(MatCreateSlipCellStiffness(comm, &cells, type, tolerance, K));
    if (Kn) PetscCall(MatCreateSlipCellNormalStiffness(comm, &cells, type, tolerance, Kn));
  }
  PetscCall(SlipCellsDestroy(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateByTransforms(MPI_Comm comm, const SlipDippingGrid *grid, const char type[], Mat *K, Mat *Kn)
{
  const PetscBool opens = (PetscBool)(grid->grid.kernel.type->components == 3);
  SlipCells cells;

  PetscFunctionBegin;
  PetscCall(CellsOf(grid, &cells));
  PetscCall(SlipCellsCheck(comm, &cells, "cells"));
  PetscCall(SlipCellsDestroy(&cells));
  PetscCheck(grid->grid.kernel.type->components == 3 || grid->grid.kernel.type->normals == 1, comm, PETSC_ERR_SUP,
             "Kernel \"%s\" has no row of normal stress, expected one that has, such as SlipKernelDipping",
             grid->grid.kernel.type->name);
  PetscCall(PetscLogEventBegin(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipDippingCreate_FFT(comm, grid, K, opens ? NULL : Kn));
  PetscCall(PetscLogEventEnd(SLIP_StiffnessSetUp, 0, 0, 0, 0));
  PetscCall(SlipLogProducts(*K, SLIP_StiffnessMult));
  if (Kn && opens) PetscCall(MatCreateSlipNormalRows(*K, Kn));
  if (Kn && !opens) PetscCall(SlipLogProducts(*Kn, SLIP_StiffnessMult));
  PetscCall(SlipNote(*K, "SlipWhy", "%s as asked", type));
  PetscCall(MatSetOption(*K, MAT_SPD, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the type for "auto" and returns the reason in words. Hierarchical storage is for kernels with an average of
   their own, or without stress on whole planes. */
static const char *ChooseType(const SlipDippingGrid *grid, const char **why)
{
  const SlipGrid *g = &grid->grid;

  if (g->nx * g->nz <= SLIP_DENSE_MAX) {
    *why = "at most 256 cells";
    return "dense";
  }
  if (g->nz > SLIP_DEEP * g->nx) {
    *why = "more than 50 cells along dip for one along strike";
    return "hmat";
  }
  if (!SlipDippingTransforms(&g->kernel)) {
    *why = "a kernel without the stress on a whole plane";
    return "hmat";
  }
  *why = "more than 256 cells";
  return "fft";
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

/* Creates the matrices for a kernel with so many components. */
static PetscErrorCode Create(MPI_Comm comm, const SlipDippingGrid *grid, PetscInt components, const char type[], Mat *K,
                             Mat *Kn)
{
  const PetscInt ntypes = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(SlipDippingTypes);
  const char *why = NULL;
  PetscBool match;
  PetscInt k;

  PetscFunctionBegin;
  PetscCall(SlipMatInitializePackage());
  PetscCheck(grid->dip > 0 && grid->dip <= 90, comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Dip must lie in (0, 90] degrees, not %g", (double)grid->dip);
  PetscCheck(grid->grid.nx > 0 && grid->grid.nz > 0 && grid->grid.nx <= PETSC_MAX_INT / grid->grid.nz, comm,
             PETSC_ERR_ARG_OUTOFRANGE,
             "Grid must have at least one cell each way and not more than PetscInt counts, not %" PetscInt_FMT
             " x %" PetscInt_FMT,
             grid->grid.nx, grid->grid.nz);
  PetscCall(SlipKernelCheck(comm, &grid->grid.kernel));
  PetscCall(SlipKernelCheckComponents(comm, &grid->grid.kernel, components));
  PetscCall(PetscStrcmp(type, "auto", &match));
  if (match) type = ChooseType(grid, &why);
  for (k = 0; k < ntypes; k++) {
    PetscCall(PetscStrcmp(type, SlipDippingTypes[k].name, &match));
    if (match) break;
  }
  PetscCheck(match, comm, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "The stiffness of a dipping grid cannot be of type \"%s\"; known: dense, hmat, fft, auto", type);
  PetscCall(SlipDippingTypes[k].create(comm, grid, type, K, Kn));
  if (why) PetscCall(SlipNote(*K, "SlipWhy", "auto: %s", why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipDippingStiffness - creates the stiffness of a uniform grid of cells on a plane of any dip, and the matrix
  of the change of normal stress

  Collective

  Input Parameters:
+ comm - communicator
. grid - cells, extents [m], dip and rakes [deg], and a kernel that has a row of normal stress, such as
         SlipKernelDipping
- type - "dense" (MATDENSE), "fft" (products by fast Fourier transforms, exact), "hmat" (hierarchical, to the tolerance
         of grid) or "auto"

  Output Parameters:
+ K  - symmetric N x N matrix [Pa/m], N = nx * nz, rows distributed by PETSC_DECIDE: the symmetric part of the stress
       drop along its rake at the centre of cell i for unit slip on cell j
- Kn - compression of the centre of cell i for unit slip on cell j [Pa/m], not symmetric; NULL: it is not created

  Notes:
  Type "fft" stores about nx + 1 blocks for K, half of nz x nz numbers each, and as many of nz x nz for Kn: 20 and 33 MB
  at 400 x 100 cells. That holds if all rakes are 0 or 180 degrees, or all 90 or -90; otherwise slip has two components,
  and blocks take four times and twice as much. It needs a kernel with plane() of SlipKernelType.

  "auto" is "dense" up to 256 cells, "hmat" for more than 50 cells along dip for one along strike and for kernels
  without plane(), and otherwise "fft". MatScale(), MatGetDiagonal() and conversion to MATDENSE work on every type.
  Either matrix may be destroyed first.

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a bad grid, those of SlipKernelCheck(), PETSC_ERR_SUP for a kernel without normal
  stress, or with "fft" without plane(), PETSC_ERR_ARG_UNKNOWN_TYPE for an unknown type

  Level: intermediate

.seealso: MatCreateSlipDippingVectorStiffness(), MatCreateSlipStiffness(), MatSlipStiffnessMultBoth(),
  MatCreateSlipCellNormalStiffness()
@*/
PetscErrorCode MatCreateSlipDippingStiffness(MPI_Comm comm, const SlipDippingGrid *grid, const char *type, Mat *K,
                                             Mat *Kn)
{
  PetscFunctionBegin;
  PetscCall(Create(comm, grid, 1, type, K, Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  MatCreateSlipDippingVectorStiffness - creates the stiffness of a uniform grid of cells on a plane of any dip for slip
  as a vector in the plane, and the matrix of the change of normal stress

  Collective

  Input Parameters:
+ comm - communicator
. grid - cells, extents [m], dip [deg], and a kernel of two components such as SlipKernelDippingVector, or of three such
         as SlipKernelDippingOpening; its rakes are ignored
- type - "dense" (MATDENSE), "fft" (products by fast Fourier transforms, exact), "hmat" (hierarchical, to the tolerance
         of grid) or "auto", as for MatCreateSlipDippingStiffness()

  Output Parameters:
+ S  - symmetric 2 N x 2 N matrix [Pa/m], N = nx * nz: rows and columns 2 i and 2 i + 1 are along strike and up dip of
       cell i; each process has twice its rows of N by PETSC_DECIDE
- Kn - N x 2 N matrix [Pa/m], compression of the centre of a cell, not symmetric; NULL: it is not created. With opening
       both are as for MatCreateSlipCellVectorStiffness()

  Notes:
  S is the symmetric part of the stress drop at the centre of a cell for unit slip along either component on another
  one.

  Type "fft" stores what it stores for MatCreateSlipDippingStiffness() where rakes vary.

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a bad grid, those of SlipKernelCheck(), PETSC_ERR_SUP for a kernel of one
  component, without normal stress where Kn is wanted, or with "fft" without plane(), PETSC_ERR_ARG_UNKNOWN_TYPE for an
  unknown type

  Level: intermediate

.seealso: MatCreateSlipDippingStiffness(), MatCreateSlipCellVectorStiffness(), MatSlipStiffnessMultBoth()
@*/
PetscErrorCode MatCreateSlipDippingVectorStiffness(MPI_Comm comm, const SlipDippingGrid *grid, const char *type, Mat *S,
                                                   Mat *Kn)
{
  PetscFunctionBegin;
  PetscCall(Create(comm, grid, 2, type, S, Kn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the stress drop and the compression by slip at once. Kn: change of normal stress by slip, created with K or
   by any other function; u: slip [m]; f: K u [Pa]; n: Kn u [Pa]. Matrices by transforms that were created together
   transform u once; others take two products. */
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
