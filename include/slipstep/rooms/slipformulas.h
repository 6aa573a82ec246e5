/* Formulas of a cell that processors and devices share: the text compiles as C, and as OpenCL C before the kernels of
   src/device/kernels. Nothing here uses pointers to arrays, whose address spaces differ. */
#ifndef SLIPFORMULAS_H
#define SLIPFORMULAS_H
#ifdef __OPENCL_VERSION__
  #define SLIP_FORMULA static
  #define SLIP_VECTOR_FORMULA static
  #define SLIP_BITS_OF(x) as_ulong(x)
  #define SLIP_DOUBLE_OF(bits) as_double(bits)
typedef double PetscReal;
typedef ulong SlipBits;
#else
  #include <math.h>
  #include <slipcompat.h>
  #include <stdint.h>
  #define SLIP_FORMULA static inline
  #define SLIP_VECTOR_FORMULA SLIP_VECTOR_PART /* becomes part of loops that are vectorised */
  #define SLIP_BITS_OF(number) (((SlipWord){.x = (number)}).bits)
  #define SLIP_DOUBLE_OF(word) (((SlipWord){.bits = (word)}).x)
typedef uint64_t SlipBits;
typedef union {
  double x;
  SlipBits bits;
} SlipWord;
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

/* ---- kicks of a cell ---- */

/* Kick with a cell's own damping, M dv/dt = g - eta v: v becomes left v + a/M mean g exactly, x = eta a/M. Returns
   mean. */
SLIP_FORMULA PetscReal SlipKickDamping(PetscReal x, PetscReal *left)
{
  *left = exp(-x);
  return x > 0 ? -expm1(-x) / x : 1;
}

/* v after a of M dv/dt = g - eta v + r, r in -q Sign(v), with constant g and q: exact, also if the cell comes to rest
   and reverses. The projection of M v + a g on the cone, which is the same otherwise, stops a reversing cell until the
   next kick, or applies the friction of the end from the start on: an error of the first order in each reversal. */
SLIP_FORMULA PetscReal SlipKickConstant(PetscReal mass, PetscReal eta, PetscReal a, PetscReal g, PetscReal q,
                                        PetscReal v)
{
  for (int turn = 0; turn < 2; turn++) {
    const PetscReal sign = v > 0 || (v == 0 && g > 0) ? 1 : -1, push = sign * g - q, speed = fabs(v);
    PetscReal left, end;

    end = a / mass * push * SlipKickDamping(eta * a / mass, &left);
    end += left * speed;
    if (end > 0 || !(end - end == 0)) return sign * end; /* or infinite, or not a number */
    if (v == 0 || push > -2 * q) return 0;               /* friction holds it at rest */
    a -= eta > 0 ? mass / eta * log1p(eta * speed / -push) : mass * speed / -push;
    a = a < 0 ? 0 : a; /* the rest of the time, after its turn */
    v = 0;
  }
  return 0;
}

/* ---- rate and state, see src/core/ratestate.c ---- */

/* Exponential and logarithm that compilers can vectorise, without calls, branches or errors, to 2 ulp. SlipExp()
   replaces arguments below -708 by -708 and requires at most 709: with a bound there compilers would multiply e^709 in
   lanes that discard it, which overflows under -fp_trap. SlipLog() requires a positive normal number. */
#define SLIP_ROUNDER 6755399441055744.0 /* 1.5 * 2^52: adding it rounds a number to an integer in its low bits */
#define SLIP_LN2_HIGH 6.93147180369123816490e-01
#define SLIP_LN2_LOW 1.90821492927058770002e-10

SLIP_VECTOR_FORMULA double SlipExp(double x)
{
  double k, r, sum;

  x = x < -708 ? -708 : x;
  k = x * 1.44269504088896340736 + SLIP_ROUNDER;
  r = x - (k - SLIP_ROUNDER) * SLIP_LN2_HIGH - (k - SLIP_ROUNDER) * SLIP_LN2_LOW;
  /* Taylor series: |r| <= ln 2/2, so that the omitted term is below 1e-17 */
  sum = 1.0 / 6227020800;
  sum = 1.0 / 479001600 + r * sum;
  sum = 1.0 / 39916800 + r * sum;
  sum = 1.0 / 3628800 + r * sum;
  sum = 1.0 / 362880 + r * sum;
  sum = 1.0 / 40320 + r * sum;
  sum = 1.0 / 5040 + r * sum;
  sum = 1.0 / 720 + r * sum;
  sum = 1.0 / 120 + r * sum;
  sum = 1.0 / 24 + r * sum;
  sum = 1.0 / 6 + r * sum;
  sum = 1.0 / 2 + r * sum;
  sum = 1 + r * sum;
  sum = 1 + r * sum;
  return sum * SLIP_DOUBLE_OF((SLIP_BITS_OF(k) + 1023) << 52);
}

/* m of x = 2^exponent m, in [sqrt(1/2), sqrt(2)) */
SLIP_VECTOR_FORMULA double SlipSplit(double x, double *exponent)
{
  const SlipBits one = 1, sqrt_half = 0x3fe6a09e667f3bcdUL, wide = 0x4330000000000000UL, bits = SLIP_BITS_OF(x);
  const SlipBits shift = (bits - sqrt_half + (2048 * one << 52)) >> 52; /* 2048 avoids negative numbers */

  *exponent = SLIP_DOUBLE_OF(wide | shift) - (4503599627370496.0 + 2048);
  return SLIP_DOUBLE_OF(bits - ((shift - 2048) << 52));
}

SLIP_VECTOR_FORMULA double SlipLog(double x)
{
  double exponent, m = SlipSplit(x, &exponent), s = (m - 1) / (m + 1), s2 = s * s, sum; /* |s| <= 0.172 */

  sum = 1.0 / 21; /* the omitted term is below 1e-17 */
  sum = 1.0 / 19 + s2 * sum;
  sum = 1.0 / 17 + s2 * sum;
  sum = 1.0 / 15 + s2 * sum;
  sum = 1.0 / 13 + s2 * sum;
  sum = 1.0 / 11 + s2 * sum;
  sum = 1.0 / 9 + s2 * sum;
  sum = 1.0 / 7 + s2 * sum;
  sum = 1.0 / 5 + s2 * sum;
  sum = 1.0 / 3 + s2 * sum;
  return exponent * SLIP_LN2_LOW + (2 * s * s2 * sum + (2 * s + exponent * SLIP_LN2_HIGH));
}

/* The same with relative errors of 1e-5 and 1.1e-5. Divisions take most of the time of a balance; this minimax
   polynomial avoids them. */
SLIP_VECTOR_FORMULA double SlipRoughExp(double x)
{
  double k, r;

  x = x < -708 ? -708 : x;
  k = x * 1.44269504088896340736 + SLIP_ROUNDER;
  r = x - (k - SLIP_ROUNDER) * (SLIP_LN2_HIGH + SLIP_LN2_LOW);
  return SLIP_DOUBLE_OF((SLIP_BITS_OF(k) + 1023) << 52) *
         (1 + r * (1 + r * (1.0 / 2 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120))))));
}

SLIP_VECTOR_FORMULA double SlipRoughLog(double x)
{
  double exponent, t = SlipSplit(x, &exponent) - 1;

  return exponent * (SLIP_LN2_HIGH + SLIP_LN2_LOW) +
         t * (0.99991888 + t * (-0.49923359 + t * (0.33734499 + t * (-0.27349856 + t * 0.1751314))));
}

/* The solution w of w + ln w = L, Lambert's W(e^L), L >= -708, and 1/(1 + w): a guess to a percent (Winitzki 2003), and
   two steps of fourth order (Fritsch et al. 1973),

     w (1 + z/(1 + w) (q - z)/(q - 2 z)),   z = L - ln w - w,   q = 2 (1 + w) (1 + w + 2 z/3),

   where the first step may use a rough logarithm. At the second one z/(1 + w) is below 1e-4, and the quotients are 1 +
   r + 2 r^2 with r = z/q, to rounding. */
SLIP_VECTOR_FORMULA double SlipLambertOfExp(double L, double *inverse)
{
  const double x = SlipRoughExp(L > 20 ? 20 : L), more = SlipRoughLog(1 + x), p = L > 20 ? L : (x < 1e-3 ? x : more);
  const double guess = p * (1 - SlipRoughLog(1 + p) / (2 + p)), z = L - SlipRoughLog(guess) - guess;
  const double q = 2 * (1 + guess) * (1 + guess + 2.0 / 3 * z);
  const double w = guess * (1 + z * (q - z) / ((1 + guess) * (q - 2 * z))), near = 1 / (1 + w);
  const double a = near * (L - SlipLog(w) - w), r = 0.5 * a * near * (1 - 2.0 / 3 * a);
  const double solution = w * (1 + a * (1 + r * (1 + 2 * r)));

  *inverse = near * (2 - (1 + solution) * near);
  return solution;
}

/* The closed form below holds if y is this large and ln V in the range of floating-point numbers. */
#define SLIP_SINH_IS_EXP 10.0
#define SLIP_LEAST_LOG (-700.0)
/* An impossible slip rate, which marks cells that it does not hold for */
#define SLIP_NO_RATE 1.7976931348623157e308

/* The slip rate of a cell from load = |tau|/(a sigma), L and a sigma/eta, for L above least: see BalanceFast() of
   src/core/ratestate.c */
SLIP_VECTOR_FORMULA double SlipBalanceRate(double load, double L, double scale, double least)
{
  double inverse_w;
  const double w = SlipLambertOfExp(L > least ? L : least, &inverse_w), y = load - w;
  const double tail = SlipRoughExp(y > SLIP_SINH_IS_EXP ? -2 * y : -2 * SLIP_SINH_IS_EXP);
  const double V = w * scale * (1 + w * tail * inverse_w) * (1 - tail);

  return (y > SLIP_SINH_IS_EXP) & (L > least) & (scale > 0) ? V : SLIP_NO_RATE;
}

/* No natural state has psi below -200; far too long steps must give finite numbers, so that they can be rejected. */
#define SLIP_MOST_HEALING 200.0

/* dpsi/dt of the aging law, and of the slip law with 1/V0 */
SLIP_VECTOR_FORMULA double SlipAgingRate(double V0, double length, double psi, double speed)
{
  return (V0 * SlipExp(-psi < SLIP_MOST_HEALING ? -psi : SLIP_MOST_HEALING) - speed) / length;
}

SLIP_VECTOR_FORMULA double SlipSlipLawRate(double inverse, double length, double psi, double speed)
{
  const double least = speed > 1e-300 ? speed : 1e-300;

  return -speed / length * (SlipLog(least * inverse) + psi);
}

/* dpsi/dt of the composite law: the slip law, and below the cut-off rate the healing of the aging law, with 1/V_c */
SLIP_VECTOR_FORMULA double SlipCompositeRate(double V0, double cutoff_inverse, double length, double psi, double speed)
{
  const double healing = -psi < SLIP_MOST_HEALING ? -psi : SLIP_MOST_HEALING;

  return V0 / length * SlipExp(healing - speed * cutoff_inverse) + SlipSlipLawRate(1 / V0, length, psi, speed);
}

/* dpsi/dt of the law of Perrin, Rice and Zheng */
SLIP_VECTOR_FORMULA double SlipPrzRate(double V0, double length, double psi, double speed)
{
  const double healing = -psi < SLIP_MOST_HEALING ? -psi : SLIP_MOST_HEALING;
  const double most = psi < SLIP_MOST_HEALING ? psi : SLIP_MOST_HEALING, share = 0.5 * speed / V0;

  return V0 / length * (SlipExp(healing) - share * share * SlipExp(most));
}

/* ---- the exponential integral ---- */

/* e^x E1(x), x > 1, by Lentz' continued fraction (Abramowitz & Stegun 1964, 5.1.22) */
SLIP_FORMULA PetscReal SlipExponentialFraction(PetscReal x)
{
  PetscReal b = x + 1, c = 1e300, d = 1 / b, product = d;

  for (int k = 1; k < 200; k++) {
    const PetscReal a = -(PetscReal)(k * k);

    b += 2;
    d = 1 / (a * d + b);
    c = b + a / c;
    product *= c * d;
    if (fabs(c * d - 1) < 2.2204460492503131e-16) break;
  }
  return product;
}

#endif
