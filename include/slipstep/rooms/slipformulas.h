/* Formulas of a cell that processors and devices share: the text compiles as C, and as OpenCL C before the kernels of
   src/device/kernels. Nothing here uses pointers to arrays, whose address spaces differ. */
#ifndef SLIPFORMULAS_H
#define SLIPFORMULAS_H
#ifdef __OPENCL_VERSION__
  #define SLIP_FORMULA static
typedef double PetscReal;
#else
  #include <math.h>
  #include <petscsys.h>
  #define SLIP_FORMULA static inline
#endif

/* ---- the cone {|r| <= q}, see src/core/cone.c ---- */

/* Where x - rho g lies: inside the shrinkage interval (sticking), outside of it (sliding one way or the other), or on a
   row without a bound, which always "slides". */
typedef enum {
  SLIP_REGION_NEGATIVE = -1,
  SLIP_REGION_STICK = 0,
  SLIP_REGION_POSITIVE = 1,
  SLIP_REGION_FREE = 2
} SlipRegion;

/* S(p, k) = sign(p) max(|p| - k, 0) */
SLIP_FORMULA PetscReal SlipConeShrink(PetscReal p, PetscReal k)
{
  if (p > k) return p - k;
  if (p < -k) return p + k;
  return 0.0;
}

/* Projection of r on [-q, q] */
SLIP_FORMULA PetscReal SlipConeClip(PetscReal r, PetscReal q)
{
  return r > q ? q : (r < -q ? -q : r);
}

/* Region of p = x - rho g; wq = omega q, zero on rows without a bound; a p that is not a number counts as sliding. */
SLIP_FORMULA SlipRegion SlipConeRegion(PetscReal x, PetscReal g, PetscReal rho, PetscReal wq)
{
  const PetscReal p = x - rho * g;

  if (wq == 0.0) return SLIP_REGION_FREE;
  if (p > rho * wq) return SLIP_REGION_POSITIVE;
  return p >= -rho * wq ? SLIP_REGION_STICK : SLIP_REGION_NEGATIVE;
}

/* Reaction of a solution: -q sign(x) if x != 0, else the balance g / omega clipped into the cone. In a state at rest g
   is the static balance -F_s and omega is 1. */
SLIP_FORMULA PetscReal SlipConeReaction(PetscReal omega, PetscReal x, PetscReal g, PetscReal q)
{
  if (x > 0.0) return -q;
  if (x < 0.0) return q;
  return SlipConeClip(g / omega, q);
}

/* By how much the elastic force ku exceeds the strength q along the motion v, or at rest in magnitude (at least 0) */
SLIP_FORMULA PetscReal SlipConePush(PetscReal v, PetscReal ku, PetscReal q)
{
  const PetscReal against = fabs(ku) - q;

  return v != 0 ? -(v > 0 ? 1 : -1) * ku - q : (against < 0 ? 0 : against);
}

/* Natural residual in units of g: g + omega q sign(p) where the cell slides, x / rho where it sticks; mask is 1 where
   it slides. slope is the diagonal that the bound adds to a sliding row of dG/dx: omega dq/d|x| sign(p) sign(x), with
   sign(p) for sign(0); elsewhere it is 0. A row that slides against the sign of its x is no solution, and its residual
   is not 0: p > rho omega q and x < 0 give x > rho F, so that |F| > |x| / rho. */
SLIP_FORMULA PetscReal SlipConeResidual(PetscReal omega, PetscReal x, PetscReal g, PetscReal q, PetscReal dq,
                                        PetscReal rho, PetscReal *mask, PetscReal *slope)
{
  const PetscReal wq = omega * q;
  const SlipRegion region = SlipConeRegion(x, g, rho, wq);
  const PetscReal sign = region == SLIP_REGION_POSITIVE ? 1.0 : -1.0;

  *mask = region == SLIP_REGION_STICK ? 0.0 : 1.0;
  *slope = 0.0;
  if (region == SLIP_REGION_STICK) return x / rho;
  if (region == SLIP_REGION_FREE) return g;
  *slope = sign * x < 0.0 ? -omega * dq : omega * dq;
  return g + sign * wq;
}

/* Exactly zero if the cell sticks, or slides against its direction by less than the tolerance, else x */
SLIP_FORMULA PetscReal SlipConeStop(PetscReal omega, PetscReal x, PetscReal g, PetscReal q, PetscReal rho)
{
  const SlipRegion region = SlipConeRegion(x, g, rho, omega * q);

  return region == SLIP_REGION_STICK || (region == SLIP_REGION_POSITIVE && x < 0.0) ||
             (region == SLIP_REGION_NEGATIVE && x > 0.0)
           ? 0.0
           : x;
}

/* Whether a step would reverse the sliding of a cell; rows without a bound may reverse. */
SLIP_FORMULA int SlipConeTurns(PetscReal q, PetscReal from, PetscReal to)
{
  return from * to < 0.0 && q > 0.0;
}

#endif
