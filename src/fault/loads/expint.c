/* Computes the exponential integral E1(x) of e^-t/t from x > 0 on, which each stage of a step needs in thousands of
   cells: up to 1 by its power series, beyond by polynomials for x e^x E1(x) in 1/x, which is smooth from 0 to 1. Lentz'
   continued fraction gives these once (Abramowitz & Stegun 1964, 5.1.11 and 5.1.22). */
#include <slipcompat.h>
#include <slipstep/private/slipfault.h>

/* Pieces of 0 to 1 and coefficients of each: an interpolation at Chebyshev's points is exact to 1e-15 */
enum { PIECES = 64, TERMS = 9, SERIES = 20 };
static PetscReal piece[PIECES][TERMS], series[SERIES];
static PetscBool made = PETSC_FALSE;

/* Returns x e^x E1(x) at x = 1/z > 1. */
static PetscReal Fraction(PetscReal z)
{
  const PetscReal x = 1 / z;

  return x * SlipExponentialFraction(x);
}

/* Finds the polynomial with the values f at the points x: divided differences, then powers. */
static void Interpolate(const PetscReal x[TERMS], PetscReal f[TERMS], PetscReal power[TERMS])
{
  for (int k = 1; k < TERMS; k++)
    for (int i = TERMS - 1; i >= k; i--) f[i] = (f[i] - f[i - 1]) / (x[i] - x[i - k]);
  for (int k = 0; k < TERMS; k++) power[k] = 0;
  for (int k = TERMS - 1; k >= 0; k--) {
    for (int i = TERMS - 1; i > 0; i--) power[i] = power[i - 1] - x[k] * power[i];
    power[0] = f[k] - x[k] * power[0];
  }
}

static void Make(void)
{
  PetscReal factor = 1;

  for (int k = 1; k <= SERIES; k++) {
    factor *= -1 / (PetscReal)k;
    series[k - 1] = -factor / (PetscReal)k;
  }
  for (int p = 0; p < PIECES; p++) {
    PetscReal x[TERMS], f[TERMS];

    for (int k = 0; k < TERMS; k++) {
      x[k] = PetscCosReal(PETSC_PI * ((PetscReal)k + (PetscReal)0.5) / TERMS);
      f[k] = Fraction(((PetscReal)p + (PetscReal)0.5 * (1 + x[k])) / PIECES);
    }
    Interpolate(x, f, piece[p]);
  }
  made = PETSC_TRUE;
}

/* x > 0; 0 beyond 700 */
PetscReal SlipExponentialIntegral(PetscReal x)
{
  const PetscReal euler = 0.57721566490153286061;
  PetscReal sum = 0;

  if (!made) Make();
  if (x > 700) return 0;
  if (x <= 1) {
    for (int k = SERIES - 1; k >= 0; k--) sum = (sum + series[k]) * x;
    return sum - PetscLogReal(x) - euler;
  }
  {
    const PetscReal at = PIECES / x;
    const int p = PetscMin((int)at, PIECES - 1);
    const PetscReal y = 2 * (at - (PetscReal)p) - 1;

    for (int k = TERMS - 1; k >= 0; k--) sum = sum * y + piece[p][k];
  }
  return sum * PetscExpReal(-x) / x;
}
