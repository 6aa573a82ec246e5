/* The cone {|r| <= q}, cell by cell: projection, natural map and generalised Jacobian.

   The stage problem is G(x) = omega r, r in -q Sign(x). For any rho > 0 it is equivalent to the natural map
   x = S(x - rho G(x), rho omega q), S the soft shrinkage (the projection on the cone in its dual form). See Facchinei
   and Pang (2003), Finite-Dimensional Variational Inequalities, chapter 9; Alart and Curnier (1991), CMAME 92. */
#include <slipcompat.h>
#include <slipcore.h>

/* S(p, k) = sign(p) max(|p| - k, 0) */
PetscReal SlipConeShrink(PetscReal p, PetscReal k)
{
  if (p > k) return p - k;
  if (p < -k) return p + k;
  return 0.0;
}

/* Projection of r on [-q, q] */
PetscReal SlipConeClip(PetscReal r, PetscReal q)
{
  return r > q ? q : (r < -q ? -q : r);
}

/* Region of p = x - rho g; wq = omega q, zero on rows without a bound */
SlipRegion SlipConeRegion(PetscReal x, PetscReal g, PetscReal rho, PetscReal wq)
{
  const PetscReal p = x - rho * g;

  if (wq == 0.0) return SLIP_REGION_FREE;
  if (p > rho * wq) return SLIP_REGION_POSITIVE;
  if (p < -rho * wq) return SLIP_REGION_NEGATIVE;
  return SLIP_REGION_STICK;
}

/* Natural residual in units of g: g + omega q sign(p) where sliding, x / rho where sticking; mask is 1 where sliding */
void SlipConeNatural(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                     const PetscReal rho[], PetscReal F[], PetscReal mask[])
{
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal wq = omega * q[i];
    const SlipRegion region = SlipConeRegion(x[i], g[i], rho[i], wq);

    mask[i] = region == SLIP_REGION_STICK ? 0.0 : 1.0;
    switch (region) {
    case SLIP_REGION_STICK:
      F[i] = x[i] / rho[i];
      break;
    case SLIP_REGION_POSITIVE:
      F[i] = g[i] + wq;
      break;
    case SLIP_REGION_NEGATIVE:
      F[i] = g[i] - wq;
      break;
    case SLIP_REGION_FREE:
      F[i] = g[i];
      break;
    }
  }
}

/* Diagonal that the bound adds to a sliding row of dG/dx: omega dq/d|x| sign(p) sign(x), with sign(p) for sign(0); 0
   elsewhere */
void SlipConeSlope(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                   const PetscReal dq[], const PetscReal rho[], PetscReal slope[])
{
  for (PetscInt i = 0; i < n; i++) {
    const SlipRegion region = SlipConeRegion(x[i], g[i], rho[i], omega * q[i]);

    slope[i] = 0.0;
    if (region == SLIP_REGION_POSITIVE) slope[i] = x[i] < 0.0 ? -omega * dq[i] : omega * dq[i];
    if (region == SLIP_REGION_NEGATIVE) slope[i] = x[i] > 0.0 ? -omega * dq[i] : omega * dq[i];
  }
}

/* Largest |x| / rho of the rows that slide against the sign of x: such a point is no solution however small its
   residual */
PetscReal SlipConeInconsistency(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[],
                                const PetscReal q[], const PetscReal rho[])
{
  PetscReal worst = 0.0;

  for (PetscInt i = 0; i < n; i++) {
    const SlipRegion region = SlipConeRegion(x[i], g[i], rho[i], omega * q[i]);

    if ((region == SLIP_REGION_POSITIVE && x[i] < 0.0) || (region == SLIP_REGION_NEGATIVE && x[i] > 0.0))
      worst = PetscMax(worst, PetscAbsReal(x[i]) / rho[i]);
  }
  return worst;
}

/* Reaction of a solution: -q sign(x) where x != 0, the balance g / omega clipped into the cone where x = 0 */
PetscReal SlipConeReaction(PetscReal omega, PetscReal x, PetscReal g, PetscReal q)
{
  if (x > 0.0) return -q;
  if (x < 0.0) return q;
  return SlipConeClip(g / omega, q);
}
