/*
  The longest stable explicit steps with damping by earlier rates. Kick, drift, kick (Verlet's velocity form) is

     M v' + H v + K u = 0,   v+ = v - (h/2) M^-1 (K u0 + e),   u1 = u0 + h v+,   v1 = v+ - (h/2) M^-1 (K u1 - e + 2 p),

  with p = H v+, the first kick uses e instead of it, from the p of the last steps, p' and p'': e = weight p' +
  (1 - weight) p''. A whole step is damped by h p, so that steps are of second order for any weight; at 7/4, which
  reaches the middle of the first kick, the error of the lag is of third order.

  For symmetric K and H, a mode x has the numbers k = h^2 x.Kx/x.Mx and c = h x.Hx/x.Mx, and

     (v+ of the next step) - (v+) = -k u1 - c ((1 + weight/2) v+ + (1/2 - weight) v+' - (1 - weight)/2 v+''),

  stable while k + 4 weight c < 4; at the limit the mode reverses in each step. Hence the bound below also holds if part
  of the cells stick, for H that do not share the modes of K, and for smaller damping.
*/
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

#define MOST_WEIGHT (PetscReal)1.75 /* weight of the last product with H in the first kick */

/* Computes the longest stable step of an explicit scheme with lagged damping. zeta: damping ratio, H at most 2 zeta M
   (M^-1 K)^(1/2), zero or positive, dimensionless; weight: of the last product with H in the first kick's estimate,
   dimensionless, 1/2 to 7/4; 1: only this product Return value: the step times the largest frequency, dimensionless: 2
   where zeta is 0. Damping that each kick solves for, such as that of radiation, does not count: zeta is 0 then. The
   bound is that of constant steps. If steps vary by up to a factor of 2 from one to the next, it is safe for zeta >=
   0.12, and four fifths of it for zeta >= 0.08. With less damping no bound below 2 is safe: steps that alternate can
   amplify a mode, at h omega of 1.6 by 15 % per step, at 1.2 by 3 % (products of amplification matrices over periods of
   2 to 5 steps). */
PetscReal SlipLagLimit(PetscReal zeta, PetscReal weight)
{
  const PetscReal b = 2 * weight * zeta;

  return 2 / (b + PetscSqrtReal(1 + b * b)); /* W^2 + 8 weight zeta W = 4, without cancellation */
}

/* Weight of the last step's damping in the first kick of a step h; the last two steps were h1 and h2 [s], 0: there was
   none. It extrapolates to the middle of the kick, so that the error of the lag is of third order, but not beyond what
   is stable. omega: the largest frequency [1/s], 0: unknown */
PetscReal SlipLagWeight(PetscReal h, PetscReal h1, PetscReal h2, PetscReal omega, PetscReal zeta)
{
  const PetscReal W = h * omega, middle = 0.25 * h + 0.5 * h1, apart = 0.5 * (h1 + h2);
  PetscReal weight = MOST_WEIGHT;

  if (h1 == 0) return 1;
  weight = PetscMin(weight, 1 + middle / apart);
  if (W * zeta > 0) weight = PetscMin(weight, SLIP_LAG_MARGIN * (4 - W * W) / (8 * zeta * W));
  return PetscMax(weight, 1);
}
