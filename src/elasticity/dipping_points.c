/*
  Fields of a dipping rectangle at points in the ground, x north, y east, z down, and tractions on planes of any
  direction: the conversion to the coordinates of dipping.c, and checks of input.
*/
#include <slipcompat.h>
#include <slipstep/private/slipdipping.h>
#include <slipstep/private/slipelasticity.h>

static PetscErrorCode SlipDippingCheck_Private(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *r)
{
  const PetscReal sizes[7] = {r->x, r->y, r->z, r->length, r->width, r->strike, r->dip};
  PetscReal sine, cosine, top;

  PetscFunctionBegin;
  for (int i = 0; i < 7; i++)
    PetscCheck(!PetscIsInfOrNanReal(sizes[i]), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "Entry %d of a rectangle is %g, expected x y z length width strike dip", i, (double)sizes[i]);
  PetscCheck(nu > -1 && nu < 0.5, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Poisson's ratio must lie in (-1, 0.5), not %g", (double)nu);
  PetscCheck(r->length > 0 && r->width > 0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Length and width of a rectangle must be positive, not %g and %g m", (double)r->length, (double)r->width);
  PetscCheck(r->dip > 0 && r->dip <= 90, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Dip must lie in (0, 90] degrees, not %g", (double)r->dip);
  if (full_space) PetscFunctionReturn(PETSC_SUCCESS);
  SlipDegrees(r->dip, &sine, &cosine);
  top = r->z - 0.5 * r->width * sine;
  PetscCheck(top >= -SLIP_TOUCH * PetscMin(r->length, r->width), PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "The upper edge of a rectangle lies %g m above the ground, expected below it", (double)-top);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void DippingOf(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *r, const PetscReal slip[3],
                      SlipDipping *s)
{
  PetscReal cosine;

  s->depth = r->z;
  s->length = r->length;
  s->width = r->width;
  SlipDegrees(r->dip, &s->slope[1], &cosine);
  s->slope[0] = -cosine;
  for (int i = 0; i < 3; i++) s->b[i] = slip[i];
  s->a = 1 / (2 * (1 - nu));
  s->rest = 1 - 2 * nu;
  s->full_space = full_space;
}

/* Converts point k to coordinates along strike, to the right and down. */
static void PointOf(PetscBool full_space, const SlipDippingRectangle *r, const PetscReal strike[2],
                    const PetscReal at[3], PetscInt k, SlipPlatePoints *p)
{
  const PetscReal own = PetscAbsReal(r->x) + PetscAbsReal(r->y) + PetscAbsReal(r->z) + r->length + r->width;
  const PetscReal x = at[0] - r->x, y = at[1] - r->y;

  p->x[k] = strike[0] * x + strike[1] * y;
  p->t[k] = strike[0] * y - strike[1] * x;
  p->q[k] = full_space || at[2] > 0 ? at[2] : 0;
  p->rounding[k] = SLIP_ROUNDING * (own + PetscAbsReal(at[0]) + PetscAbsReal(at[1]) + PetscAbsReal(at[2]));
}

static PetscErrorCode SlipDippingAll_Private(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *source,
                                             const PetscReal slip[3], PetscBool gradient, PetscInt n,
                                             const PetscReal points[], PetscReal out[])
{
  const PetscInt size = gradient ? 9 : 3;
  const SlipDipping *all[SLIP_LANES], *const *const of[1] = {all};
  PetscReal strike[2];
  SlipDipping s;

  PetscFunctionBegin;
  PetscCall(SlipDippingCheck_Private(nu, full_space, source));
  SlipDegrees(source->strike, &strike[1], &strike[0]);
  DippingOf(nu, full_space, source, slip, &s);
  for (PetscInt k = 0; k < SLIP_LANES; k++) all[k] = &s;
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    PetscReal *const at[1] = {out + size * first};
    SlipPlatePoints p;

    p.n = PetscMin(SLIP_LANES, n - first);
    for (PetscInt k = 0; k < p.n; k++) {
      const PetscReal *point = points + 3 * (first + k);

      PointOf(full_space, source, strike, point, k, &p);
      PetscCheck(full_space || point[2] >= -p.rounding[k], PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
                 "A point lies %g m above the ground, expected below it", (double)-point[2]);
    }
    SlipDippingFields_Private(1, of, &p, gradient, at);
    for (PetscInt k = first; k < first + p.n; k++) SlipTurnOut(strike, gradient, out + size * k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the displacement of points by uniform slip on a rectangle of any strike and dip. nu: Poisson's ratio, in
   (-1, 0.5), dimensionless; full_space: leave out the free surface z = 0; source: the rectangle that slips, below the
   free surface or up to it; slip: [3] along strike, up dip and opening: of the hanging wall against the foot wall [m];
   points: [n][3] north, east and down [m]; below a free surface or on it; u: [n][3] displacement north, east and down,
   in the unit of slip [m]. Lengths may have any one unit. The shear modulus does not matter. A point on the rectangle,
   to 1e-14 of the coordinates, belongs to the hanging wall; a point on the trace of a rectangle that breaks the surface
   has the limit from there along the ground. On an edge across which the rectangle slips the displacement has the
   logarithm of the distance, and the value at 1e-20 of the coordinates from it is returned. All other points, also on
   extensions of edges, need no care, at any dip. Errors: PETSC_ERR_ARG_OUTOFRANGE for Poisson's ratio, a rectangle
   without an extent, a dip outside (0, 90] degrees, and rectangles and points above a free surface. Okada (1992); the
   derivation is in the source file dipping.c. */
PetscErrorCode SlipDippingDisplacement(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *source,
                                       const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal u[])
{
  PetscFunctionBegin;
  PetscCall(SlipDippingAll_Private(nu, full_space, source, slip, PETSC_FALSE, n, points, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the gradient of the displacement of points by uniform slip on a rectangle. nu: Poisson's ratio, in (-1,
   0.5), dimensionless; full_space: leave out the free surface z = 0; source: the rectangle that slips, below the free
   surface or up to it; slip: [3] along strike, up dip and opening: of the hanging wall against the foot wall [m];
   points: [n][3] north, east and down [m]; below a free surface or on it; gradient: [n][3][3] derivative of the
   displacement i along j, both north, east and down, dimensionless. On an edge of the rectangle, to 1e-14 of the
   coordinates, the gradient is infinite: the term in 1 / distance, which changes its sign around the edge, is left out,
   and the rest is returned. Next to an edge values are not limited. Far away, at the distance d from a rectangle of the
   side a, corners cancel to 1e-15 (d/a)^2 of the value. Errors: as of SlipDippingDisplacement(). Okada (1992); the
   derivation is in the source file dipping.c. */
PetscErrorCode SlipDippingGradient(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *source,
                                   const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal gradient[])
{
  PetscFunctionBegin;
  PetscCall(SlipDippingAll_Private(nu, full_space, source, slip, PETSC_TRUE, n, points, gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the stress at points by uniform slip on a rectangle of any strike and dip. G: shear modulus [Pa]; nu:
   Poisson's ratio, in (-1, 0.5), dimensionless; full_space: leave out the free surface z = 0; source: the rectangle
   that slips, below the free surface or up to it; slip: [3] along strike, up dip and opening: of the hanging wall
   against the foot wall [m]; points: [n][3] north, east and down [m]; below a free surface or on it; stress: [n][6] xx,
   yy, zz, xy, xz, yz with x north, y east, z down; tension is positive [Pa]. On an edge of the rectangle, where stress
   is infinite, the finite part is returned, as for SlipDippingGradient(). Errors: as of SlipDippingDisplacement().
   Okada (1992); the derivation is in the source file dipping.c. */
PetscErrorCode SlipDippingStress(PetscReal G, PetscReal nu, PetscBool full_space, const SlipDippingRectangle *source,
                                 const PetscReal slip[], PetscInt n, const PetscReal points[], PetscReal stress[])
{
  PetscFunctionBegin;
  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);
    PetscReal gradient[9 * SLIP_LANES];

    PetscCall(SlipDippingAll_Private(nu, full_space, source, slip, PETSC_TRUE, count, points + 3 * first, gradient));
    for (PetscInt k = 0; k < count; k++) SlipStressOf(G, nu, gradient + 9 * k, stress + 6 * (first + k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SlipDippingTractions_Private - computes the traction [n][3], along the rake, across it and normal, at the centre of
  each receiver by slip along the rake of its own source; for 2 or 3 slips [n][slips][3], along strike, up dip and
  normal, by slip along strike and up dip and by opening. Cells are not checked: a mesh has checked them.
*/
void SlipDippingTractions_Private(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips, PetscInt n,
                                  const SlipCell receiver[], const SlipCell source[], PetscReal traction[])
{
  const PetscBool vector = slips > 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscReal strike[2] = {1, 0}, rake[2] = {1, 0}, directions[9];

  for (PetscInt first = 0; first < n; first += SLIP_LANES) {
    const PetscInt count = PetscMin(SLIP_LANES, n - first);
    const SlipDipping *all[3][SLIP_LANES], *const *const of[3] = {all[0], all[1], all[2]};
    PetscReal gradient[3][9 * SLIP_LANES], *const out[3] = {gradient[0], gradient[1], gradient[2]};
    PetscReal turn[SLIP_LANES][2], stress[6];
    SlipDipping lane[SLIP_LANES], other[2][SLIP_LANES];
    SlipPlatePoints p;

    p.n = count;
    for (PetscInt k = 0; k < count; k++) {
      const SlipCell *s = source + first + k;
      const SlipDippingRectangle *r = &receiver[first + k].rectangle;
      const PetscReal at[3] = {r->x, r->y, r->z}, slip[3] = {0, 0, 0};
      const PetscBool again = first + k ? PETSC_TRUE : PETSC_FALSE; /* most are on the same plane as the last one */

      if (!again || s->rectangle.strike != s[-1].rectangle.strike)
        SlipDegrees(s->rectangle.strike, &strike[1], &strike[0]);
      if (!vector && (!again || s->rake != s[-1].rake)) SlipDegrees(s->rake, &rake[1], &rake[0]);
      if (k && s->rectangle.dip == s[-1].rectangle.dip) {
        lane[k] = lane[k - 1];
        lane[k].depth = s->rectangle.z;
        lane[k].length = s->rectangle.length;
        lane[k].width = s->rectangle.width;
      } else
        DippingOf(nu, full_space, &s->rectangle, slip, &lane[k]);
      lane[k].b[0] = rake[0];
      lane[k].b[1] = rake[1];
      all[0][k] = &lane[k];
      for (PetscInt m = 1; m < slips; m++) {
        other[m - 1][k] = lane[k];
        other[m - 1][k].b[0] = 0;
        other[m - 1][k].b[m] = 1;
        all[m][k] = &other[m - 1][k];
      }
      turn[k][0] = strike[0];
      turn[k][1] = strike[1];
      PointOf(full_space, &s->rectangle, strike, at, k, &p);
    }
    SlipDippingFields_Private(slips, of, &p, PETSC_TRUE, out);
    for (PetscInt k = 0; k < count; k++) {
      const SlipCell *r = receiver + first + k;

      if (!(first + k) || (!vector && r->rake != r[-1].rake) || r->rectangle.strike != r[-1].rectangle.strike ||
          r->rectangle.dip != r[-1].rectangle.dip)
        SlipPlaneDirections(r->rectangle.strike, r->rectangle.dip, vector ? 0 : r->rake, directions);
      for (PetscInt s = 0; s < slips; s++) {
        SlipTurnOut(turn[k], PETSC_TRUE, gradient[s] + 9 * k);
        SlipStressOf(G, nu, gradient[s] + 9 * k, stress);
        SlipStressTraction(1, stress, directions, traction + 3 * (slips * (first + k) + s));
      }
    }
  }
}

/*@
  SlipPlaneDirections - computes the directions of a fault plane, after Aki & Richards (1980)

  Not collective, pure

  Input Parameters:
+ strike - clockwise from north; the plane dips to the right of it [deg]
. dip    - of the plane from the horizontal [deg]
- rake   - in the plane from the strike, positive up dip: 0 left-lateral, 90 thrust [deg]

  Output Parameter:
. directions - [3][3] unit vectors, each north, east and down, dimensionless: along the rake, in the plane across it (90
               degrees more), and across the plane into the hanging wall; right-handed

  Level: intermediate

.seealso: SlipStressTraction(), SlipDippingRectangle
@*/
void SlipPlaneDirections(PetscReal strike, PetscReal dip, PetscReal rake, PetscReal directions[])
{
  PetscReal along[2], down[2], turn[2];

  SlipDegrees(strike, &along[1], &along[0]);
  SlipDegrees(dip, &down[1], &down[0]);
  SlipDegrees(rake, &turn[1], &turn[0]);
  for (int i = 0; i < 3; i++) {
    const PetscReal s = i < 2 ? along[i] : 0, right = i == 0 ? -along[1] : i == 1 ? along[0] : 0, z = i == 2;
    const PetscReal up = -down[0] * right - down[1] * z;

    directions[i] = turn[0] * s + turn[1] * up;
    directions[3 + i] = turn[0] * up - turn[1] * s;
    directions[6 + i] = down[1] * right - down[0] * z;
  }
}

/*@
  SlipStressTraction - computes the traction of stresses on planes

  Not collective, pure

  Input Parameters:
+ n          - number of stresses and of planes
. stress     - [n][6] xx, yy, zz, xy, xz, yz, tension positive [Pa]
- directions - [n][3][3] of the planes, by SlipPlaneDirections(), dimensionless

  Output Parameter:
. traction - [n][3] traction of the foot wall on the hanging wall: shear along the rake, shear across it, and normal
             stress, positive in compression [Pa]

  Note: the stress by slip on a rectangle at its own centre has the sign of the slip: it is the stress drop, as in a
  stiffness. Stress that drives slip along the rake has the opposite sign.

  Level: intermediate

.seealso: SlipDippingStress(), SlipPlaneDirections()
@*/
void SlipStressTraction(PetscInt n, const PetscReal stress[], const PetscReal directions[], PetscReal traction[])
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal *s = stress + 6 * k, *d = directions + 9 * k, *m = d + 6;
    const PetscReal t[3] = {s[0] * m[0] + s[3] * m[1] + s[4] * m[2], s[3] * m[0] + s[1] * m[1] + s[5] * m[2],
                            s[4] * m[0] + s[5] * m[1] + s[2] * m[2]};

    for (int i = 0; i < 3; i++) traction[3 * k + i] = -(t[0] * d[3 * i] + t[1] * d[3 * i + 1] + t[2] * d[3 * i + 2]);
  }
}
