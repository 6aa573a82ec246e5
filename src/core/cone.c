/* The cone {|r| <= q}, cell by cell: projection, natural map and generalised Jacobian.

   The stage problem is G(x) = omega r, r in -q Sign(x). For any rho > 0 it is equivalent to the natural map
   x = S(x - rho G(x), rho omega q), S the soft shrinkage (the projection on the cone in its dual form). See Facchinei
   and Pang (2003), Finite-Dimensional Variational Inequalities, chapter 9; Alart and Curnier (1991), CMAME 92. */
#include <slipcompat.h>
#include <slipcore.h>

/* Natural residual in units of g: g + omega q sign(p) where sliding, x / rho where sticking; mask is 1 where sliding.
   slope is the diagonal that the bound adds to a sliding row of dG/dx: omega dq/d|x| sign(p) sign(x), with sign(p) for
   sign(0); 0 elsewhere. A row that slides against the sign of its x is no solution, and its residual says so: p > rho
   omega q and x < 0 make x > rho F, so that |F| > |x| / rho. */
void SlipConeNatural(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                     const PetscReal dq[], const PetscReal rho[], PetscReal F[], PetscReal mask[], PetscReal slope[])
{
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal wq = omega * q[i];
    PetscReal sign;

    switch (SlipConeRegion(x[i], g[i], rho[i], wq)) {
    case SLIP_REGION_STICK:
      mask[i] = slope[i] = 0.0;
      F[i] = x[i] / rho[i];
      continue;
    case SLIP_REGION_FREE:
      mask[i] = 1.0;
      slope[i] = 0.0;
      F[i] = g[i];
      continue;
    case SLIP_REGION_POSITIVE:
      sign = 1.0;
      break;
    default:
      sign = -1.0;
    }
    mask[i] = 1.0;
    F[i] = g[i] + sign * wq;
    slope[i] = sign * x[i] < 0.0 ? -omega * dq[i] : omega * dq[i];
  }
}

/* The same where the bound is smooth and nothing sticks: F = g + omega q sign(x), 0 where mask is 0 as x is prescribed there */
void SlipConeSmooth(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                    const PetscReal dq[], const PetscReal mask[], PetscReal F[], PetscReal slope[])
{
  for (PetscInt i = 0; i < n; i++) {
    F[i] = mask[i] != 0 ? g[i] + (x[i] < 0 ? -omega : omega) * q[i] : 0;
    slope[i] = omega * dq[i];
  }
}

/* x becomes exactly zero where it sticks, or slides against its own direction by less than the tolerance; r is its
   reaction */
void SlipConeFinish(PetscInt n, PetscReal omega, const PetscReal g[], const PetscReal q[], const PetscReal rho[],
                    PetscReal x[], PetscReal r[])
{
  for (PetscInt i = 0; i < n; i++) {
    const SlipRegion region = SlipConeRegion(x[i], g[i], rho[i], omega * q[i]);

    if (region == SLIP_REGION_STICK || (region == SLIP_REGION_POSITIVE && x[i] < 0.0) ||
        (region == SLIP_REGION_NEGATIVE && x[i] > 0.0))
      x[i] = 0.0;
    r[i] = SlipConeReaction(omega, x[i], g[i], q[i]);
  }
}

/* Stops at zero the cells that the step from one point to another would turn round; rows without a bound are left
   alone. Whether there were any */
PetscBool SlipConeStopTurning(PetscInt n, const PetscReal q[], const PetscReal from[], PetscReal to[])
{
  PetscBool turned = PETSC_FALSE;

  for (PetscInt i = 0; i < n; i++) {
    if (!(from[i] * to[i] < 0.0 && q[i] > 0.0)) continue;
    to[i] = 0.0;
    turned = PETSC_TRUE;
  }
  return turned;
}

/* ---- the self-adaptive fixed point x <- S(x - rho G(x), rho omega q), He and Liao (2002), JOTA 112 ---- */

/* One step of it, from x with g = G(x) to x1 */
void SlipConeProject(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                     const PetscReal rho[], PetscReal x1[])
{
  for (PetscInt i = 0; i < n; i++) x1[i] = SlipConeShrink(x[i] - rho[i] * g[i], rho[i] * omega * q[i]);
}

/* Add to the sums over the cells of rho (g1 - g)^2 and of (x1 - x)^2 / rho */
void SlipConeChanges(PetscInt n, const PetscReal x[], const PetscReal x1[], const PetscReal g[], const PetscReal g1[],
                     const PetscReal rho[], PetscReal sum[2])
{
  for (PetscInt i = 0; i < n; i++) {
    sum[0] += PetscSqr(g1[i] - g[i]) * rho[i];
    sum[1] += PetscSqr(x1[i] - x[i]) / rho[i];
  }
}

/* The ratio of those sums says whether rho suits: above 0.9 it is shortened by 2/3 and the step repeated (yes is
   returned), below 0.3 lengthened by 3/2. factor: on rho, 1 to leave it */
PetscBool SlipConeAdaptStep(PetscInt trial, const PetscReal sum[2], PetscReal *factor)
{
  const PetscReal ratio_high = 0.9, ratio_low = 0.3, shorten = 2.0 / 3.0, lengthen = 1.5;
  const PetscReal ratio = sum[1] > 0.0 ? PetscSqrtReal(sum[0] / sum[1]) : ratio_high;
  enum { max_trials = 20 };

  *factor = 1.0;
  if (ratio > ratio_high && trial < max_trials) {
    *factor = shorten * PetscMin(1.0, 1.0 / ratio);
    return PETSC_TRUE;
  }
  if (ratio < ratio_low) *factor = lengthen;
  return PETSC_FALSE;
}
