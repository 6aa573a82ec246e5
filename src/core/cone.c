/* The cone {|r| <= q}, cell by cell: projection, natural map and generalised Jacobian.

   The stage problem is G(x) = omega r, r in -q Sign(x). For any rho > 0 it is equivalent to the natural map
   x = S(x - rho G(x), rho omega q), S the soft shrinkage (the projection on the cone in its dual form). See Facchinei
   and Pang (2003), Finite-Dimensional Variational Inequalities, chapter 9; Alart and Curnier (1991), CMAME 92. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* Natural residual, mask and slope of SlipConeResidual() */
void SlipConeNatural(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                     const PetscReal dq[], const PetscReal rho[], PetscReal F[], PetscReal mask[], PetscReal slope[])
{
  for (PetscInt i = 0; i < n; i++) F[i] = SlipConeResidual(omega, x[i], g[i], q[i], dq[i], rho[i], &mask[i], &slope[i]);
}

/* The same if the bound is smooth and nothing sticks: F = g + omega q sign(x), and 0 where mask is 0, because x is
   prescribed there */
void SlipConeSmooth(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                    const PetscReal dq[], const PetscReal mask[], PetscReal F[], PetscReal slope[])
{
  for (PetscInt i = 0; i < n; i++) {
    F[i] = mask[i] != 0 ? g[i] + (x[i] < 0 ? -omega : omega) * q[i] : 0;
    slope[i] = omega * dq[i];
  }
}

/* Sets x to exactly zero where it sticks, or slides against its direction by less than the tolerance; r is its
   reaction. */
void SlipConeFinish(PetscInt n, PetscReal omega, const PetscReal g[], const PetscReal q[], const PetscReal rho[],
                    PetscReal x[], PetscReal r[])
{
  for (PetscInt i = 0; i < n; i++) {
    x[i] = SlipConeStop(omega, x[i], g[i], q[i], rho[i]);
    r[i] = SlipConeReaction(omega, x[i], g[i], q[i]);
  }
}

/* Stops at zero those cells whose sliding a step from one point to another would reverse, except rows without a bound.
   Returns whether there were any. */
PetscBool SlipConeStopTurning(PetscInt n, const PetscReal q[], const PetscReal from[], PetscReal to[])
{
  PetscBool turned = PETSC_FALSE;

  for (PetscInt i = 0; i < n; i++) {
    if (!SlipConeTurns(q[i], from[i], to[i])) continue;
    to[i] = 0.0;
    turned = PETSC_TRUE;
  }
  return turned;
}

/* ---- the self-adaptive fixed point x <- S(x - rho G(x), rho omega q), He and Liao (2002), JOTA 112 ---- */

/* Does one step, from x with g = G(x) to x1. */
void SlipConeProject(PetscInt n, PetscReal omega, const PetscReal x[], const PetscReal g[], const PetscReal q[],
                     const PetscReal rho[], PetscReal x1[])
{
  for (PetscInt i = 0; i < n; i++) x1[i] = SlipConeShrink(x[i] - rho[i] * g[i], rho[i] * omega * q[i]);
}

/* Adds rho (g1 - g)^2 and (x1 - x)^2 / rho of the cells to the sums. */
void SlipConeChanges(PetscInt n, const PetscReal x[], const PetscReal x1[], const PetscReal g[], const PetscReal g1[],
                     const PetscReal rho[], PetscReal sum[2])
{
  for (PetscInt i = 0; i < n; i++) {
    sum[0] += PetscSqr(g1[i] - g[i]) * rho[i];
    sum[1] += PetscSqr(x1[i] - x[i]) / rho[i];
  }
}

/* The ratio of those sums decides about rho: above 0.9 rho is multiplied by 2/3 and the step repeated (returns true),
   below 0.3 rho is multiplied by 3/2. factor: that on rho, 1 for no change */
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

/* ---- two components per cell: |r| <= q in the Euclidean norm, a disk, and r = -q x / |x| where x != 0. x, g, F, mask
   and rho have the two numbers of a cell side by side (those of mask and of rho are equal) in blocks of c numbers,
   whose others are not changed; q, dq, hold and cross have one for each of n cells.

   With z = x - rho g and n = z / |z| a cell sticks where |z| <= rho omega q; elsewhere F = g + omega q n, and with
   P = I - n n'
     dF = (I - rho omega q / |z| P) dg + [omega q' n (x / |x|)' + omega q / |z| P] dx.
   Along n this is symmetric except for x / |x|, of which only the part along n is used, which is all of it at a
   solution. Across n the rows of the Newton step are divided by 1 - rho omega q / |z| > 0, and with P z = 0, that is
   P x = rho P g, they become
     P (g + dg) + k P (x + dx) = 0,   k = omega q / (|z| - rho omega q),
   which is q / |x| at a solution, so that the whole is symmetric: dG/dx + omega q' n n' + k P. k grows without bound
   towards the edge of sticking, where it only makes x + dx parallel to n, as any large number does. ---- */

/* Largest k rho: the step leaves this fraction of the part across n; a larger one would cost digits along n. */
static const PetscReal largest_hold = 1e6;

static inline PetscReal SlipDiskDot(const PetscReal a[2], const PetscReal b[2])
{
  return a[0] * b[0] + a[1] * b[1];
}

/* Natural residual as above; normal and hold are 0 in cells that do not slide against a bound. */
void SlipDiskNatural(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal g[],
                     const PetscReal q[], const PetscReal rho[], PetscReal F[], PetscReal mask[], PetscReal normal[],
                     PetscReal hold[])
{
  for (PetscInt i = 0; i < n; i++, x += c, g += c, rho += c, F += c, mask += c, normal += c) {
    const PetscReal wq = omega * q[i], z[] = {x[0] - rho[0] * g[0], x[1] - rho[0] * g[1]}, size = hypot(z[0], z[1]);
    const PetscReal beyond = size - rho[0] * wq;

    mask[0] = mask[1] = wq == 0.0 || !(beyond <= 0.0) ? 1.0 : 0.0; /* NaN counts as sliding, so that F becomes NaN */
    normal[0] = normal[1] = hold[i] = 0.0;
    if (mask[0] != 0.0 && wq != 0.0) {
      for (int k = 0; k < 2; k++) normal[k] = z[k] / size;
      hold[i] = wq * rho[0] < largest_hold * beyond ? wq / beyond : largest_hold / rho[0];
    }
    for (int k = 0; k < 2; k++) F[k] = mask[0] != 0.0 ? g[k] + wq * normal[k] : x[k] / rho[0];
  }
}

/* The same for a smooth bound, where nothing sticks: F = g + omega q x / |x|, 0 where mask is 0; at x = 0, q / |x| is
   q' */
void SlipDiskSmooth(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal g[],
                    const PetscReal q[], const PetscReal dq[], const PetscReal mask[], PetscReal F[],
                    PetscReal normal[], PetscReal hold[])
{
  for (PetscInt i = 0; i < n; i++, x += c, g += c, F += c, mask += c, normal += c) {
    const PetscReal size = hypot(x[0], x[1]);

    normal[0] = size > 0 ? x[0] / size : 1;
    normal[1] = size > 0 ? x[1] / size : 0;
    hold[i] = omega * (size > 0 ? q[i] / size : dq[i]);
    for (int k = 0; k < 2; k++) F[k] = mask[k] != 0 ? g[k] + omega * q[i] * normal[k] : 0;
  }
}

/* omega q' n n' + k P of each cell: its diagonal and off-diagonal entry; dq NULL: without q'. A cell that slides
   backwards has its sign changed as with one component. */
void SlipDiskSlope(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal dq[],
                   const PetscReal normal[], const PetscReal hold[], PetscReal slope[], PetscReal cross[])
{
  for (PetscInt i = 0; i < n; i++, x += c, normal += c, slope += c) {
    const PetscReal size = hypot(x[0], x[1]),
                    along = dq ? omega * dq[i] * (size > 0 ? SlipDiskDot(normal, x) / size : 1) : 0;

    slope[0] = along * normal[0] * normal[0] + hold[i] * normal[1] * normal[1];
    slope[1] = along * normal[1] * normal[1] + hold[i] * normal[0] * normal[0];
    for (PetscInt k = 2; k < c; k++) slope[k] = 0;
    cross[i] = (along - hold[i]) * normal[0] * normal[1];
  }
}

/* y -= k P x */
void SlipDiskHold(PetscInt n, PetscInt c, const PetscReal normal[], const PetscReal hold[], const PetscReal x[],
                  PetscReal y[])
{
  for (PetscInt i = 0; i < n; i++, normal += c, x += c, y += c) {
    const PetscReal across = hold[i] * (normal[0] * x[1] - normal[1] * x[0]);

    y[0] += across * normal[1];
    y[1] -= across * normal[0];
  }
}

/* Reaction of a solution, or of a state at rest, as SlipConeReaction() */
void SlipDiskReaction(PetscReal omega, const PetscReal x[2], const PetscReal g[2], PetscReal q, PetscReal r[2])
{
  const PetscReal size = hypot(x[0], x[1]), balance = hypot(g[0], g[1]) / omega;

  for (int k = 0; k < 2; k++)
    if (size > 0)
      r[k] = -q * (x[k] / size);
    else
      r[k] = balance > q ? q * (g[k] / omega / balance) : g[k] / omega;
}

/* As SlipConeFinish(). x is rotated by the part across n that the tolerance allows, so that r is opposite to x and in
   balance however slow the cell is. */
void SlipDiskFinish(PetscInt n, PetscInt c, PetscReal omega, const PetscReal g[], const PetscReal q[],
                    const PetscReal rho[], PetscReal x[], PetscReal r[])
{
  for (PetscInt i = 0; i < n; i++, g += c, rho += c, x += c, r += c) {
    const PetscReal wq = omega * q[i], z[] = {x[0] - rho[0] * g[0], x[1] - rho[0] * g[1]}, size = hypot(z[0], z[1]);
    const PetscReal speed = size > rho[0] * wq && SlipDiskDot(z, x) > 0 ? hypot(x[0], x[1]) : 0;

    if (wq != 0.0)
      for (int k = 0; k < 2; k++) x[k] = speed > 0 ? z[k] / size * speed : 0;
    SlipDiskReaction(omega, x, g, q[i], r);
  }
}

/* As SlipConeStopTurning(), for cells that would turn by more than a right angle */
PetscBool SlipDiskStopTurning(PetscInt n, PetscInt c, const PetscReal q[], const PetscReal from[], PetscReal to[])
{
  PetscBool turned = PETSC_FALSE;

  for (PetscInt i = 0; i < n; i++, from += c, to += c) {
    if (!(SlipDiskDot(from, to) < 0.0 && q[i] > 0.0)) continue;
    to[0] = to[1] = 0.0;
    turned = PETSC_TRUE;
  }
  return turned;
}

/* As SlipConeProject() */
void SlipDiskProject(PetscInt n, PetscInt c, PetscReal omega, const PetscReal x[], const PetscReal g[],
                     const PetscReal q[], const PetscReal rho[], PetscReal x1[])
{
  for (PetscInt i = 0; i < n; i++, x += c, g += c, rho += c, x1 += c) {
    const PetscReal z[] = {x[0] - rho[0] * g[0], x[1] - rho[0] * g[1]}, size = hypot(z[0], z[1]);
    const PetscReal left = SlipConeShrink(size, rho[0] * omega * q[i]);

    for (int k = 0; k < 2; k++) x1[k] = left > 0 ? z[k] * (left / size) : 0;
  }
}
