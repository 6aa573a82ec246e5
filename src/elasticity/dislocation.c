/*
  Stress drop of a rectangular strike-slip dislocation on a vertical plane, in closed form.

  The displacement Green's tensor of a half-space (Mindlin 1936) has, for horizontal forces and a, b in {x, y},

     16 pi G (1 - nu) G_ab = delta_ab f + d_a d_b g,
     f = 4 (1 - nu) (1/R1 + 1/R2),
     g = -R1 - (3 - 4 nu) R2 - 2 c z / R2 + 4 (1 - nu)(1 - 2 nu) (R2 - w ln(R2 + w)),

  where c is the depth of the source, z that of the receiver, w = z + c, R1^2 = x^2 + y^2 + (z - c)^2, R2^2 = x^2 + y^2
  + w^2. Slip along x on the plane y = 0 loads it with the density G^2 (d_yy G_xx + 2 d_xy G_xy + d_xx G_yy) of stress
  drop, so

     K = G / (16 pi (1 - nu)) * integral over the source of (d_xx + d_yy) f + 4 d_xxyy g.

  On y = 0: (d_xx + d_yy)(1/R) = -d_zz(1/R), d_yy R = 1/R, d_yy(1/R) = -1/R^3, d_yy(R2 - w ln(R2 + w)) = 1/(R2 + w).
  What remains is integrated in x and c exactly; the integral is the double difference of the functions below over the
  corners. It is the field that Okada (1992) gives for any dip.
*/
#include <slipstep/private/slipelasticity.h>

/* Returns the difference over [s1, s2] of the antiderivative -s / (r R) of d_rr (1/R), R^2 = r^2 + s^2. For s of one
   sign the large part -sign(s) / r cancels and is omitted, so that r = 0 (on the extension of an edge) is regular. */
static PetscReal EdgeDifference(PetscReal r, PetscReal s1, PetscReal s2)
{
  const PetscReal R1 = PetscSqrtReal(r * r + s1 * s1), R2 = PetscSqrtReal(r * r + s2 * s2);
  const PetscReal sign1 = (PetscReal)((s1 > 0) - (s1 < 0)), sign2 = (PetscReal)((s2 > 0) - (s2 < 0));
  const PetscReal regular = sign2 * r / (R2 * (R2 + PetscAbsReal(s2))) - sign1 * r / (R1 * (R1 + PetscAbsReal(s1)));

  return sign1 == sign2 ? regular : regular - (sign2 - sign1) / r;
}

/* Integrates -(coefficient_x d_xx + coefficient_z d_zz) (1/R) over [x1, x2] x [z1, z2], R^2 = x^2 + z^2. */
static PetscReal PotentialPart(PetscReal cx, PetscReal cz, PetscReal x1, PetscReal x2, PetscReal z1, PetscReal z2)
{
  return -cx * (EdgeDifference(x2, z1, z2) - EdgeDifference(x1, z1, z2)) -
         cz * (EdgeDifference(z2, x1, x2) - EdgeDifference(z1, x1, x2));
}

/* Antiderivatives in (x, w) of the remaining terms of the free surface, w > 0:
   d_xx 1/(R + w), and 2 c z d_xx R^-3 = z * linear + z^2 * quadratic. */
static PetscReal SurfaceHarmonic(PetscReal x, PetscReal w)
{
  const PetscReal s = PetscSqrtReal(x * x + w * w) + w;

  return 0.5 * x / (s * s);
}

static PetscReal SurfaceLinear(PetscReal x, PetscReal w)
{
  const PetscReal R = PetscSqrtReal(x * x + w * w);

  return 2 * x / (R * R * R);
}

static PetscReal SurfaceQuadratic(PetscReal x, PetscReal w)
{
  const PetscReal R = PetscSqrtReal(x * x + w * w), s = R + w;

  return -2 * x * (w + 2 * R) / (s * s * R * R * R);
}

static PetscReal CornerSum(PetscReal (*f)(PetscReal, PetscReal), PetscReal x1, PetscReal x2, PetscReal w1, PetscReal w2)
{
  return (f(x2, w2) - f(x2, w1)) - (f(x1, w2) - f(x1, w1));
}

/*
  SlipKernelSurface_Private - computes the free surface's part of the stress drop, split by its dependence on the
  receiver's depth z: constant + z * linear + z^2 * quadratic, functions of dx and of the sum of the two depths only.
*/
void SlipKernelSurface_Private(PetscReal G, PetscReal nu, PetscReal dx, PetscReal depth_sum, PetscReal a, PetscReal b,
                               PetscReal part[3])
{
  const PetscReal factor = G / (4 * PETSC_PI * (1 - nu));
  const PetscReal x1 = dx - 0.5 * a, x2 = dx + 0.5 * a, w1 = depth_sum - 0.5 * b, w2 = depth_sum + 0.5 * b;

  part[0] = factor * (PotentialPart(3 - 4 * nu, 1 - nu, x1, x2, w1, w2) +
                      4 * (1 - nu) * (1 - 2 * nu) * CornerSum(SurfaceHarmonic, x1, x2, w1, w2));
  part[1] = factor * CornerSum(SurfaceLinear, x1, x2, w1, w2);
  part[2] = factor * CornerSum(SurfaceQuadratic, x1, x2, w1, w2);
}

/*@
  SlipKernelFullSpace - computes the stress drop at a receiver's centre for unit strike slip on a cell in a full space

  Not collective, pure

  Input Parameters:
+ G  - shear modulus [Pa]
. nu - Poisson's ratio, in (-1, 0.5), dimensionless
. dx - distance along strike from the cell's centre to the receiver [m]
. dz - distance in depth [m]
. a  - the cell's extent along strike [m]
- b  - its extent in depth [m]

  Output: entry of the stiffness [Pa/m], positive at the cell's own centre; infinite on the cell's edges

  Note: the entry of a cell on itself is G sqrt(2) (2 - nu) / (pi (1 - nu) a) for a = b.

  Reference: Chinnery (1963), Okada (1992); the derivation is in the source file

  Level: intermediate

.seealso: SlipKernelHalfSpace(), MatCreateSlipStiffness()
@*/
PetscReal SlipKernelFullSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dz, PetscReal a, PetscReal b)
{
  const PetscReal factor = G / (4 * PETSC_PI * (1 - nu));

  return factor * PotentialPart(1, 1 - nu, dx - 0.5 * a, dx + 0.5 * a, dz - 0.5 * b, dz + 0.5 * b);
}

/*@
  SlipKernelHalfSpace - computes the stress drop at a receiver's centre for unit strike slip on a cell in a half-space

  Not collective, pure

  Input Parameters:
+ G          - shear modulus [Pa]
. nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. dx         - distance along strike from the cell's centre to the receiver [m]
. z_receiver - depth of the receiver [m], positive
. z_source   - depth of the cell's centre [m], at least b / 2
. a          - the cell's extent along strike [m]
- b          - its extent in depth [m]

  Output: entry of the stiffness [Pa/m]; not symmetric in the two depths, as only the source is averaged over its cell

  Reference: Okada (1992); Chinnery (1963) for nu = 1/4; the derivation is in the source file

  Level: intermediate

.seealso: SlipKernelFullSpace(), MatCreateSlipStiffness()
@*/
PetscReal SlipKernelHalfSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal z_receiver, PetscReal z_source,
                              PetscReal a, PetscReal b)
{
  PetscReal part[3];

  SlipKernelSurface_Private(G, nu, dx, z_receiver + z_source, a, b, part);
  return SlipKernelFullSpace(G, nu, dx, z_receiver - z_source, a, b) + part[0] +
         z_receiver * (part[1] + z_receiver * part[2]);
}
