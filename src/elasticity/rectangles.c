/* Displacement and stress at points by slip on many rectangles: sums over those of dipping_points.c. What maps of a fault's slip
   are computed from. */
#include <slipcompat.h>
#include <slipelasticity.h>

typedef struct {
  PetscReal G, nu; /* G is 0 for displacement */
  PetscBool full_space;
} Medium;

static PetscErrorCode SumOverCells(const Medium *medium, PetscInt ncells, const SlipDippingRectangle cells[],
                                   const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal sum[])
{
  const PetscInt size = medium->G > 0 ? 6 : 3;
  PetscReal *one;

  PetscFunctionBegin;
  PetscCheck(ncells >= 0 && n >= 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " rectangles and %" PetscInt_FMT " points, expected no fewer than 0", ncells, n);
  PetscCall(PetscArrayzero(sum, size * n));
  PetscCall(PetscMalloc1(size * n, &one));
  for (PetscInt k = 0; k < ncells; k++) {
    const PetscReal *u = slip + 3 * k;

    if (u[0] == 0 && u[1] == 0 && u[2] == 0) continue; /* in an event most cells of a large fault */
    if (medium->G > 0)
      PetscCall(SlipDippingStress(medium->G, medium->nu, medium->full_space, cells + k, u, n, points, one));
    else
      PetscCall(SlipDippingDisplacement(medium->nu, medium->full_space, cells + k, u, n, points, one));
    for (PetscInt i = 0; i < size * n; i++) sum[i] += one[i];
  }
  PetscCall(PetscFree(one));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipRectanglesDisplacement - displacement of points by slip on rectangles of any strike and dip, such as the cells of a fault

  Not collective, pure

  Input Parameters:
+ nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. full_space - leave out the free surface z = 0
. ncells     - number of rectangles
. cells      - [ncells] they; in memory [ncells][7], so that a table of x y z length width strike dip will do [m, deg]
. slip       - [ncells][3] along strike, up dip and opening: of the hanging wall against the foot wall [m]
. n          - number of points
- points     - [n][3] north, east and down [m]; below a free surface or on it

  Output Parameter:
. u - [n][3] displacement north, east and down [m]

  Errors: as of SlipDippingDisplacement()

  Level: intermediate

.seealso: SlipRectanglesStress(), SlipDippingDisplacement(), SlipDippingRectangle
@*/
PetscErrorCode SlipRectanglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                          const SlipDippingRectangle cells[], const PetscReal slip[], PetscInt n,
                                          const PetscReal points[], PetscReal u[])
{
  const Medium medium = {0, nu, full_space};

  PetscFunctionBegin;
  PetscCall(SumOverCells(&medium, ncells, cells, slip, n, points, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipRectanglesStress - stress at points by slip on rectangles of any strike and dip, such as the cells of a fault

  Not collective, pure

  Input Parameters:
+ G          - shear modulus, > 0 [Pa]
. nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. full_space - leave out the free surface z = 0
. ncells     - number of rectangles
. cells      - [ncells] they; in memory [ncells][7], so that a table of x y z length width strike dip will do [m, deg]
. slip       - [ncells][3] along strike, up dip and opening: of the hanging wall against the foot wall [m]
. n          - number of points
- points     - [n][3] north, east and down [m]; below a free surface or on it

  Output Parameter:
. stress - [n][6] xx, yy, zz, xy, xz, yz with x north, y east, z down; tension is positive [Pa]

  Note: SlipStressTraction() makes it the traction on planes

  Errors: as of SlipDippingStress(), and PETSC_ERR_ARG_OUTOFRANGE for the shear modulus

  Level: intermediate

.seealso: SlipRectanglesDisplacement(), SlipDippingStress(), SlipStressTraction()
@*/
PetscErrorCode SlipRectanglesStress(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt ncells,
                                    const SlipDippingRectangle cells[], const PetscReal slip[], PetscInt n,
                                    const PetscReal points[], PetscReal stress[])
{
  const Medium medium = {G, nu, full_space};

  PetscFunctionBegin;
  PetscCheck(G > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "The shear modulus is %g Pa, expected one > 0",
             (double)G);
  PetscCall(SumOverCells(&medium, ncells, cells, slip, n, points, stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}
