/*
  Fields of a triangle at points in the ground, x north, y east, z down: the conversion to the coordinates of
  triangle.c, and checks of input.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptriangle.h>

/* Smallest height of a triangle over its longest side */
#define FLAT 1e-6
/* Planes that are horizontal or vertical, or vertical and striking north, within this angle [rad] count as such in the
   choice of directions. */
#define EXACT 1e-9

static PetscErrorCode SlipTriangleCheck_Private(const PetscReal vertices[9])
{
  PetscReal normal[3], longest, height;

  PetscFunctionBegin;
  for (int i = 0; i < 9; i++)
    PetscCheck(!PetscIsInfOrNanReal(vertices[i]), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "Coordinate %d of a triangle is %g, expected three vertices, each north, east and down", i,
               (double)vertices[i]);
  longest = PetscSqrtReal(SlipTriangleNormal(vertices, normal));
  height = longest > 0 ? PetscSqrtReal(SlipDot(normal, normal)) / longest : 0;
  PetscCheck(height > FLAT * longest, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "A triangle has a height of %g m on a side of %g m, expected more than %g of the side", (double)height,
             (double)longest, FLAT);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a unit normal points into the hanging wall, after Aki & Richards: upward, or for a vertical plane to
   the right of a strike in [0, 180) degrees, which is to the south unless it strikes north. */
PetscBool SlipHangingWall(const PetscReal normal[3])
{
  if (PetscAbsReal(normal[2]) > EXACT) return (PetscBool)(normal[2] < 0);
  if (PetscAbsReal(normal[0]) > EXACT) return (PetscBool)(normal[0] < 0);
  return (PetscBool)(normal[1] > 0);
}

/* Computes strike, dip and directions of a triangle, after Aki & Richards (1980). vertices: [3][3] north, east and
   down, in any order [m]; side: [3] any vector that points into the hanging wall, or NULL: above the plane, and for a
   vertical one to the right of a strike in [0, 180) degrees; dimensionless; angles: [2] strike in [0, 360) and dip
   [deg]; or NULL; directions: [3][3] unit vectors, each north, east and down, dimensionless: along strike, up dip, and
   across the plane into the hanging wall; right-handed, those of SlipPlaneDirections() at rake 0; or NULL. A horizontal
   triangle has the strike 0: its directions are north, west and up. Planes count as horizontal, vertical and striking
   north within 1e-9 rad. Where side is below the plane the dip is more than 90 degrees, and the strike the opposite
   one, so that neighbours of a surface that turns over have directions that differ by little. Slip along strike and
   opening are the same numbers for both sides, and slip up dip changes its sign. Errors: PETSC_ERR_ARG_OUTOFRANGE for
   triangles without an area, and for a side in the plane. */
PetscErrorCode SlipTriangleDirections(const PetscReal vertices[], const PetscReal side[], PetscReal angles[],
                                      PetscReal directions[])
{
  PetscReal n[3], strike[3] = {1, 0, 0}, dip, azimuth;

  PetscFunctionBegin;
  PetscCall(SlipTriangleCheck_Private(vertices));
  SlipTriangleNormal(vertices, n);
  SlipUnit(n);
  PetscCheck(!side || PetscAbsReal(SlipDot(side, n)) > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The side (%g, %g, %g) lies in the plane of a triangle, expected a vector into the hanging wall",
             (double)side[0], (double)side[1], (double)side[2]);
  if (side ? SlipDot(side, n) < 0 : !SlipHangingWall(n))
    for (int i = 0; i < 3; i++) n[i] = -n[i];
  if (PetscSqrtReal(n[0] * n[0] + n[1] * n[1]) > EXACT) {
    strike[0] = n[1];
    strike[1] = -n[0];
  } else {
    for (int i = 0; i < 3; i++) strike[i] = (i == 0) - n[0] * n[i];
  }
  SlipUnit(strike);
  azimuth = PetscAtan2Real(strike[1], strike[0]) * 180 / PETSC_PI;
  dip = PetscAtan2Real(PetscSqrtReal(n[0] * n[0] + n[1] * n[1]), -n[2]) * 180 / PETSC_PI;
  if (angles) {
    angles[0] = azimuth < 0 ? azimuth + 360 : azimuth;
    if (angles[0] >= 360) angles[0] = 0; /* by rounding */
    angles[1] = dip;
  }
  if (directions) {
    for (int i = 0; i < 3; i++) {
      directions[i] = strike[i];
      directions[6 + i] = n[i];
    }
    SlipCross(n, strike, directions + 3);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks and sets up a triangle that slips. */
static PetscErrorCode SlipTriangleCreate_Private(PetscReal nu, PetscBool full_space, const PetscReal vertices[9],
                                                 const PetscReal slip[3], SlipTriangle *s)
{
  PetscReal directions[9], jump[3], top;

  PetscFunctionBegin;
  PetscCheck(nu > -1 && nu < 0.5, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Poisson's ratio must lie in (-1, 0.5), not %g", (double)nu);
  PetscCall(SlipTriangleDirections(vertices, NULL, NULL, directions));
  for (int i = 0; i < 3; i++)
    jump[i] = slip[0] * directions[i] + slip[1] * directions[3 + i] + slip[2] * directions[6 + i];
  SlipTriangleOf_Private(nu, full_space, vertices, directions + 6, s);
  SlipTriangleSetSlip_Private(s, jump);
  if (full_space) PetscFunctionReturn(PETSC_SUCCESS);
  top = PetscMin(vertices[2], PetscMin(vertices[5], vertices[8]));
  PetscCheck(top >= -SLIP_TOUCH * PetscMin(s->length[0], PetscMin(s->length[1], s->length[2])), PETSC_COMM_SELF,
             PETSC_ERR_ARG_OUTOFRANGE, "A vertex of a triangle lies %g m above the ground, expected below it",
             (double)-top);
  top = PetscMax(vertices[2], PetscMax(vertices[5], vertices[8]));
  PetscCheck(top > s->rounding, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "A triangle lies on the ground, expected one below it or up to it");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipTriangleAll_Private(PetscReal nu, PetscBool full_space, const PetscReal vertices[9],
                                              const PetscReal slip[3], PetscBool gradient, PetscInt n,
                                              const PetscReal points[], PetscReal out[])
{
  const PetscInt size = gradient ? 9 : 3;
  const SlipTriangle *all[SLIP_LANES], *const *const of[1] = {all};
  SlipTriangle s;

  PetscFunctionBegin;
  PetscCall(SlipTriangleCreate_Private(nu, full_space, vertices, slip, &s));
  for (PetscInt k = 0; k < SLIP_LANES; k++) all[k] = &s;
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    PetscReal *const to[1] = {out + size * first};
    SlipTrianglePoints p;

    p.n = PetscMin(SLIP_LANES, n - first);
    for (PetscInt k = 0; k < p.n; k++) {
      const PetscReal *at = points + 3 * (first + k);

      SlipTrianglePointOf_Private(&s, at, k, &p);
      PetscCheck(full_space || at[2] >= -p.rounding[k], PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
                 "A point lies %g m above the ground, expected below it", (double)-at[2]);
    }
    SlipTriangleFields_Private(1, of, &p, gradient, to);
    for (PetscInt k = first; k < first + p.n; k++) SlipTurnOut(s.strike, gradient, out + size * k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the displacement of points by uniform slip on a triangle. nu: Poisson's ratio, in (-1, 0.5), dimensionless;
   full_space: leave out the free surface z = 0; vertices: [3][3] of the triangle that slips, each north, east and down,
   in any order; below the free surface or up to it [m]; slip: [3] along strike, up dip and opening: of the hanging wall
   against the foot wall [m]; points: [n][3] north, east and down [m]; below a free surface or on it; u: [n][3]
   displacement north, east and down, in the unit of slip [m]. Strike, dip and hanging wall are those of
   SlipTriangleDirections() without a side. Lengths may have any one unit. The shear modulus does not matter. A point on
   the triangle, to 1e-14 of the coordinates, belongs to the hanging wall; a point on the trace of a triangle that
   breaks the surface has the limit from there along the ground. On an edge across which the triangle slips the
   displacement has the logarithm of the distance, and the value at 1e-20 of the coordinates from it is returned. All
   other points, also on extensions of edges and above and below vertices, need no care. Errors:
   PETSC_ERR_ARG_OUTOFRANGE for Poisson's ratio, a triangle whose height is less than 1e-6 of its longest side, one that
   lies on the ground, and vertices and points above a free surface. The derivation is in the source files dipping.c,
   triangle_potential.c and triangle_surface.c; Nikkhoo and Walter (2015) have the same fields. */
PetscErrorCode SlipTriangleDisplacement(PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                        const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal u[])
{
  PetscFunctionBegin;
  PetscCall(SlipTriangleAll_Private(nu, full_space, vertices, slip, PETSC_FALSE, n, points, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the gradient of the displacement of points by uniform slip on a triangle. nu: Poisson's ratio, in (-1, 0.5),
   dimensionless; full_space: leave out the free surface z = 0; vertices: [3][3] of the triangle that slips, each north,
   east and down, in any order; below the free surface or up to it [m]; slip: [3] along strike, up dip and opening: of
   the hanging wall against the foot wall [m]; points: [n][3] north, east and down [m]; below a free surface or on it;
   gradient: [n][3][3] derivative of the displacement i along j, both north, east and down, dimensionless. On an edge of
   the triangle, to 1e-14 of the coordinates, the gradient is infinite: the term in 1 / distance, which changes its sign
   around the edge, is left out, and the rest is returned. Next to an edge values are not limited. Far away, at the
   distance d from a triangle of the side a, edges cancel to 1e-14 (d/a)^2 of the value, more where it is flat. Errors:
   as of SlipTriangleDisplacement(). */
PetscErrorCode SlipTriangleGradient(PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                    const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal gradient[])
{
  PetscFunctionBegin;
  PetscCall(SlipTriangleAll_Private(nu, full_space, vertices, slip, PETSC_TRUE, n, points, gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the stress at points by uniform slip on a triangle. G: shear modulus [Pa]; nu: Poisson's ratio, in (-1,
   0.5), dimensionless; full_space: leave out the free surface z = 0; vertices: [3][3] of the triangle that slips, each
   north, east and down, in any order; below the free surface or up to it [m]; slip: [3] along strike, up dip and
   opening: of the hanging wall against the foot wall [m]; points: [n][3] north, east and down [m]; below a free surface
   or on it; stress: [n][6] xx, yy, zz, xy, xz, yz with x north, y east, z down; tension is positive [Pa]. On an edge of
   the triangle, where stress is infinite, the finite part is returned, as for SlipTriangleGradient(). Errors: as of
   SlipTriangleDisplacement(). */
PetscErrorCode SlipTriangleStress(PetscReal G, PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                  const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal stress[])
{
  PetscFunctionBegin;
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);
    PetscReal gradient[9 * SLIP_LANES];

    PetscCall(SlipTriangleAll_Private(nu, full_space, vertices, slip, PETSC_TRUE, count, points + 3 * first, gradient));
    for (PetscInt k = 0; k < count; k++) SlipStressOf(G, nu, gradient + 9 * k, stress + 6 * (first + k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipTriangleTractions - computes the traction [slips][3] along the directions of the receiver, at its centroid, by
  unit slip along the first 1 to 3 directions of the source: both in the plane, and opening
*/
void SlipTriangleTractions(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips,
                           const SlipTriangleCell *receiver, const SlipTriangleCell *source, PetscReal traction[])
{
  const SlipTriangle *all[3] = {NULL}, *const *const of[3] = {&all[0], &all[1], &all[2]};
  PetscReal gradient[3][9], *const out[3] = {gradient[0], gradient[1], gradient[2]}, stress[6];
  const PetscReal *v = receiver->vertices;
  const PetscReal at[3] = {(v[0] + v[3] + v[6]) / 3, (v[1] + v[4] + v[7]) / 3, (v[2] + v[5] + v[8]) / 3};
  SlipTriangle triangle[3];
  SlipTrianglePoints p;

  p.n = 1;
  for (PetscInt m = 0; m < slips; m++) {
    if (m)
      triangle[m] = triangle[0];
    else
      SlipTriangleOf_Private(nu, full_space, source->vertices, source->directions + 6, &triangle[0]);
    SlipTriangleSetSlip_Private(&triangle[m], source->directions + 3 * m);
    all[m] = &triangle[m];
  }
  SlipTrianglePointOf_Private(all[0], at, 0, &p);
  SlipTriangleFields_Private(slips, of, &p, PETSC_TRUE, out);
  for (PetscInt m = 0; m < slips; m++) {
    SlipTurnOut(all[m]->strike, PETSC_TRUE, gradient[m]);
    SlipStressOf(G, nu, gradient[m], stress);
    SlipStressTraction(1, stress, receiver->directions, traction + 3 * m);
  }
}
