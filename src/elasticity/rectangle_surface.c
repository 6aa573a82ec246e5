/*
  Displacement of the free surface by a rectangular strike-slip dislocation on a vertical plane, in closed form.

  Okada (1985), equations 25 to 29 at a dip of 90 degrees, is a double difference over the corners of the source. With x
  and y the distances of the point from a corner along and across strike, s the depth of the corner, T = R + s and
  R^2 = x^2 + y^2 + s^2, and with his y and z (to the left of the strike, upward) turned into ours (to its right, down),
  2 pi u is the double difference of

     u_x    atan(x s / (y R)) + x y / (R T) - (1 - 2 nu) x y / (2 T^2)
     u_y    y^2 / (R T) - (1 - 2 nu) / 2 (s / T + y^2 / T^2 + ln T)
     u_z    (1 - 2 nu) y / T - y / R

  His mu / (lambda + mu) is 1 - 2 nu.
*/
#include <slipstep/private/slipelasticity.h>

/* Computes the term of one corner. side: the side of the plane on which the point is, +-1; core: the distance that is
   used if the point is at the corner. */
static void Corner(PetscReal nu, PetscReal x, PetscReal y, PetscReal s, PetscReal side, PetscReal core, PetscReal u[3])
{
  const PetscReal m = 1 - 2 * nu, R = PetscSqrtReal(x * x + y * y + s * s), T = R + s;

  if (R == 0) { /* the other terms are 0 in the limit along the trace */
    u[0] = u[2] = 0;
    u[1] = -0.5 * m * PetscLogReal(core);
    return;
  }
  u[0] = side * PetscAtan2Real(x * s, PetscAbsReal(y) * R) + x * y / T * (1 / R - 0.5 * m / T);
  u[1] = y * y / (R * T) - 0.5 * m * ((s + y * y / T) / T + PetscLogReal(T));
  u[2] = m * y / T - y / R;
}

/*@
  SlipSurfaceDisplacement - computes the displacement of the free surface for unit strike slip on a vertical rectangle

  Not collective, pure

  Input Parameters:
+ nu     - Poisson's ratio, in (-1, 0.5), dimensionless
. source - the rectangle that slips, below the free surface or up to it
. n      - number of points
- points - [n][2] x along strike and y across it [m]

  Output Parameter:
. u - [n][3] displacement along x, y and z for 1 m of slip [m/m]

  Notes:
  x points along strike, y to the right of it, z down. Slip is the displacement of the side y > source->y less that of
  the other side: positive slip is left-lateral. The shear modulus does not matter.

  Both sides of a rectangle that breaks the surface move relative to each other. A point on its trace has the limit from
  y > source->y, u_x = +1/2; any point with y < source->y is on the other side.

  At the end of a rectangle that breaks the surface u_y has the logarithm of the distance from its upper corner, because
  strain is infinite there. At the corner itself the distance is SLIP_CORE_CELL of the rectangle's length, so that
  adjacent rectangles of one length and slip have the same displacement as one rectangle.

  Reference: Okada (1985)

  Level: intermediate

.seealso: SlipKernelHalfSpace(), SlipKernelOffset()
@*/
void SlipSurfaceDisplacement(PetscReal nu, const SlipRectangle *source, PetscInt n, const PetscReal points[],
                             PetscReal u[])
{
  const PetscReal touch = SLIP_TOUCH * PetscMin(source->length, source->width), core = SLIP_CORE_CELL * source->length;

  for (PetscInt p = 0; p < n; p++) {
    const PetscReal dx = points[2 * p] - source->x, dy = points[2 * p + 1] - source->y;
    const PetscReal y = PetscAbsReal(dy) <= touch ? 0 : dy, side = dy < 0 ? -1 : 1;

    for (int k = 0; k < 3; k++) u[3 * p + k] = 0;
    for (int i = -1; i <= 1; i += 2)
      for (int j = -1; j <= 1; j += 2) {
        const PetscReal x = dx - 0.5 * i * source->length, s = source->z + 0.5 * j * source->width;
        PetscReal corner[3];

        Corner(nu, PetscAbsReal(x) <= touch ? 0 : x, y, s <= touch ? 0 : s, side, core, corner);
        for (int k = 0; k < 3; k++) u[3 * p + k] -= i * j / (2 * PETSC_PI) * corner[k];
      }
  }
}
