/* Displacement and stress at points by slip on many rectangles or triangles, as sums of the fields of dipping_points.c
   and triangle_points.c. Maps of the fields of a fault's slip use them. */
#include <slipcompat.h>
#include <slipstep/rooms/slipelasticity.h>

typedef struct {
  PetscReal G, nu; /* G = 0: displacement */
  PetscBool full_space;
  const SlipDippingRectangle *cells; /* rectangles; NULL: triangles */
  const PetscReal *vertices;         /* [.][3][3] of triangles */
  const PetscReal *side;             /* [.][3] vectors into the triangles' hanging walls, or NULL */
} Sources;

/* Converts slip on a triangle with a given side of its hanging wall to slip [3] with that of SlipTriangleStress(). */
static PetscErrorCode SlipFromSide(const PetscReal vertices[], const PetscReal side[], const PetscReal slip[],
                                   PetscReal own[])
{
  PetscReal from[9], to[9], jump[3];
  PetscBool other;

  PetscFunctionBegin;
  PetscCall(SlipTriangleDirections(vertices, side, NULL, from));
  PetscCall(SlipTriangleDirections(vertices, NULL, NULL, to));
  other = (PetscBool)(from[6] * to[6] + from[7] * to[7] + from[8] * to[8] < 0);
  for (int i = 0; i < 3; i++) {
    jump[i] = slip[0] * from[i] + slip[1] * from[3 + i] + slip[2] * from[6 + i];
    if (other) jump[i] = -jump[i];
  }
  for (int k = 0; k < 3; k++)
    own[k] = other ? to[3 * k] * jump[0] + to[3 * k + 1] * jump[1] + to[3 * k + 2] * jump[2] : slip[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the field of one source. */
static PetscErrorCode Field(const Sources *s, PetscInt k, const PetscReal slip[], PetscInt n, const PetscReal points[],
                            PetscReal field[])
{
  PetscReal own[3] = {slip[0], slip[1], slip[2]};

  PetscFunctionBegin;
  if (s->side) PetscCall(SlipFromSide(s->vertices + 9 * k, s->side + 3 * k, slip, own));
  if (s->vertices && s->G > 0)
    PetscCall(SlipTriangleStress(s->G, s->nu, s->full_space, s->vertices + 9 * k, own, n, points, field));
  else if (s->vertices)
    PetscCall(SlipTriangleDisplacement(s->nu, s->full_space, s->vertices + 9 * k, own, n, points, field));
  else if (s->G > 0)
    PetscCall(SlipDippingStress(s->G, s->nu, s->full_space, s->cells + k, slip, n, points, field));
  else
    PetscCall(SlipDippingDisplacement(s->nu, s->full_space, s->cells + k, slip, n, points, field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sum(const Sources *s, PetscInt ncells, const PetscReal slip[], PetscInt n,
                          const PetscReal points[], PetscReal sum[])
{
  const PetscInt size = s->G > 0 ? 6 : 3;
  PetscReal *one;

  PetscFunctionBegin;
  PetscCheck(ncells >= 0 && n >= 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%" PetscInt_FMT " %s and %" PetscInt_FMT " points, expected no fewer than 0", ncells,
             s->vertices ? "triangles" : "rectangles", n);
  PetscCall(PetscArrayzero(sum, size * n));
  PetscCall(PetscMalloc1(size * n, &one));
  for (PetscInt k = 0; k < ncells; k++) {
    const PetscReal *u = slip + 3 * k;

    if (u[0] == 0 && u[1] == 0 && u[2] == 0) continue; /* as for most cells of a large fault in an event */
    PetscCall(Field(s, k, u, n, points, one));
    for (PetscInt i = 0; i < size * n; i++) sum[i] += one[i];
  }
  PetscCall(PetscFree(one));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipRectanglesDisplacement - computes the displacement of points by slip on rectangles, such as the cells of a fault

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

.seealso: SlipRectanglesStress(), SlipTrianglesDisplacement(), SlipDippingDisplacement(), SlipDippingRectangle
@*/
PetscErrorCode SlipRectanglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                          const SlipDippingRectangle cells[], const PetscReal slip[], PetscInt n,
                                          const PetscReal points[], PetscReal u[])
{
  const Sources sources = {.nu = nu, .full_space = full_space, .cells = cells};

  PetscFunctionBegin;
  PetscCall(Sum(&sources, ncells, slip, n, points, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipRectanglesStress - computes the stress at points by slip on rectangles, such as the cells of a fault

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
  const Sources sources = {.G = G, .nu = nu, .full_space = full_space, .cells = cells};

  PetscFunctionBegin;
  PetscCheck(G > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "The shear modulus is %g Pa, expected one > 0",
             (double)G);
  PetscCall(Sum(&sources, ncells, slip, n, points, stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipTrianglesDisplacement - computes the displacement of points by slip on triangles, such as the cells of a fault

  Not collective, pure

  Input Parameters:
+ nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. full_space - leave out the free surface z = 0
. ncells     - number of triangles
. vertices   - [ncells][3][3] of each, north, east and down, in any order [m]
. side       - [ncells][3] vectors that point into their hanging walls, dimensionless, or NULL: as of
               SlipTriangleDirections()
. slip       - [ncells][3] along strike, up dip and opening: of the hanging wall against the foot wall, with the
               directions that SlipTriangleDirections() has for the side [m]
. n          - number of points
- points     - [n][3] north, east and down [m]; below a free surface or on it

  Output Parameter:
. u - [n][3] displacement north, east and down [m]

  Errors: as of SlipTriangleDisplacement() and, of a triangle that slips, of SlipTriangleDirections()

  Level: intermediate

.seealso: SlipTrianglesStress(), SlipTriangleDisplacement(), SlipTriangleDirections(), SlipRectanglesDisplacement()
@*/
PetscErrorCode SlipTrianglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                         const PetscReal vertices[], const PetscReal side[], const PetscReal slip[],
                                         PetscInt n, const PetscReal points[], PetscReal u[])
{
  const Sources sources = {.nu = nu, .full_space = full_space, .vertices = vertices, .side = side};

  PetscFunctionBegin;
  PetscCall(Sum(&sources, ncells, slip, n, points, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipTrianglesStress - computes the stress at points by slip on triangles, such as the cells of a fault

  Not collective, pure

  Input Parameters:
+ G          - shear modulus, > 0 [Pa]
. nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. full_space - leave out the free surface z = 0
. ncells     - number of triangles
. vertices   - [ncells][3][3] of each, north, east and down, in any order [m]
. side       - [ncells][3] vectors that point into their hanging walls, dimensionless, or NULL: as of
               SlipTriangleDirections()
. slip       - [ncells][3] along strike, up dip and opening: of the hanging wall against the foot wall, with the
               directions that SlipTriangleDirections() has for the side [m]
. n          - number of points
- points     - [n][3] north, east and down [m]; below a free surface or on it

  Output Parameter:
. stress - [n][6] xx, yy, zz, xy, xz, yz with x north, y east, z down; tension is positive [Pa]

  Note: SlipStressTraction() makes it the traction on planes

  Errors: as of SlipTrianglesDisplacement(), and PETSC_ERR_ARG_OUTOFRANGE for the shear modulus

  Level: intermediate

.seealso: SlipTrianglesDisplacement(), SlipTriangleStress(), SlipStressTraction()
@*/
PetscErrorCode SlipTrianglesStress(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt ncells,
                                   const PetscReal vertices[], const PetscReal side[], const PetscReal slip[],
                                   PetscInt n, const PetscReal points[], PetscReal stress[])
{
  const Sources sources = {.G = G, .nu = nu, .full_space = full_space, .vertices = vertices, .side = side};

  PetscFunctionBegin;
  PetscCheck(G > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "The shear modulus is %g Pa, expected one > 0",
             (double)G);
  PetscCall(Sum(&sources, ncells, slip, n, points, stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}
