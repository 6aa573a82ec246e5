/*
  Stress drop of a rectangular strike-slip dislocation on a parallel vertical plane at the distance y, in closed form.

  With f and g of dislocation.c, and density G / (16 pi (1 - nu)) ((d_xx + d_yy) f + 4 d_xxyy g) at any y, the integrals
  over x and over the depth s (z - c of the source itself, z + c of its image) are double differences over the corners
  of

     -(d_ss)(1/R)      x s / (R (y^2 + s^2))
     d_xxyy R          x d_yy [s / (r^2 R)] times -1, by 1/(R (R + s)) = 1/r^2 - s/(R r^2), r^2 = x^2 + y^2
     d_xxyy (1/R)      x d_yy [1 / (R (R + s))]
     s d_xxyy (1/R)    d_x d_yy R
     d_xxyy (R - s ln(R + s))   x / 2 (1/(R + s)^2 - 2 y^2 / (R (R + s)^3))

  R^2 = x^2 + y^2 + s^2. They are regular for y != 0; y = 0 is left to dislocation.c.
*/
#include <slipstep/rooms/slipelasticity.h>

/* A corner's coordinates along strike, across and in depth, from the receiver */
typedef struct {
  PetscReal x, y, s, R;
} Corner;

static PetscReal Potential(const Corner *c)
{
  return c->x * c->s / (c->R * (c->y * c->y + c->s * c->s));
}

static PetscReal Biharmonic(const Corner *c)
{
  const PetscReal r2 = c->x * c->x + c->y * c->y, y2 = c->y * c->y;

  return -c->x * c->s / (c->R * r2) * (1 - y2 / (c->R * c->R) - 2 * y2 / r2);
}

/* Computes the terms without the free surface: the (1 - nu) d_ss part and the d_xxyy R part. */
static PetscReal Direct(const Corner *c, PetscReal nu)
{
  return (1 - nu) * Potential(c) - Biharmonic(c);
}

/* Computes the terms of the image at the receiver's depth z; s is the sum of the two depths. */
static PetscReal Image(const Corner *c, PetscReal nu, PetscReal z)
{
  const PetscReal x = c->x, R = c->R, t = R + c->s, y2 = c->y * c->y;
  const PetscReal harmonic = 0.5 * x / (t * t) * (1 - 2 * y2 / (R * t));
  const PetscReal linear = 2 * x / (R * R * R) * (1 - 3 * y2 / (R * R));
  const PetscReal quadratic =
    2 * x / (R * R * t) * (y2 / R * (3 / (R * R) + 3 / (R * t) + 2 / (t * t)) - 1 / R - 1 / t);

  return (1 - nu) * Potential(c) - (3 - 4 * nu) * Biharmonic(c) + 4 * (1 - nu) * (1 - 2 * nu) * harmonic +
         z * (linear + z * quadratic);
}

/*@
  SlipKernelOffset - computes the stress drop at a receiver's centre on a parallel plane for unit strike slip on a cell

  Not collective, pure

  Input Parameters:
+ G          - shear modulus [Pa]
. nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. dx         - distance along strike from the cell's centre to the receiver [m]
. dy         - distance between the two planes [m]; 0: the result is SlipKernelHalfSpace() or SlipKernelFullSpace()
. z_receiver - depth of the receiver [m], positive
. z_source   - depth of the cell's centre [m], at least b / 2
. a          - the cell's extent along strike [m]
. b          - its extent in depth [m]
- full_space - leave out the free surface

  Output: drop of the stress xy on the receiver's plane [Pa/m]

  Reference: Okada (1992); the derivation from Mindlin (1936) is in the source file

  Level: intermediate

.seealso: SlipKernelHalfSpace(), MatCreateSlipCellStiffness()
@*/
PetscReal SlipKernelOffset(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dy, PetscReal z_receiver,
                           PetscReal z_source, PetscReal a, PetscReal b, PetscBool full_space)
{
  PetscReal sum = 0;

  if (dy == 0)
    return full_space ? SlipKernelFullSpace(G, nu, dx, z_receiver - z_source, a, b)
                      : SlipKernelHalfSpace(G, nu, dx, z_receiver, z_source, a, b);
  for (int i = -1; i <= 1; i += 2)
    for (int k = -1; k <= 1; k += 2) {
      Corner c = {dx + 0.5 * i * a, dy, z_receiver - z_source + 0.5 * k * b, 0};

      c.R = PetscSqrtReal(c.x * c.x + c.y * c.y + c.s * c.s);
      sum += i * k * Direct(&c, nu);
      if (full_space) continue;
      c.s = z_receiver + z_source + 0.5 * k * b;
      c.R = PetscSqrtReal(c.x * c.x + c.y * c.y + c.s * c.s);
      sum += i * k * Image(&c, nu, z_receiver);
    }
  return G / (4 * PETSC_PI * (1 - nu)) * sum;
}
