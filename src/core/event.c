/* Formulas of the catalogue of events: when a slip rate crosses a bound within a step, the rate in between, the peak of
   a curve, the magnitude.

   Between the ends of a step the logarithm of a slip rate is linear in time, which is exact for exponential growth or
   decay, as in nucleation. If one end is at rest or slips the other way there is no logarithm, and the rate itself is
   linear: friction starts and stops a cell from and to exactly zero with a finite acceleration. Both are of the
   integrator's order, never leave the range of the two ends, and need no derivative, which is undefined
   where a cell has just stopped. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

/* Fraction of the way from slow to fast at which |v| is bound: |slow| <= bound < |fast| */
PetscReal SlipEventCrossing(PetscReal slow, PetscReal fast, PetscReal bound)
{
  const PetscReal x = fast > 0 ? slow : -slow, y = PetscAbsReal(fast);

  return x > 0 ? PetscLogReal(bound / x) / PetscLogReal(y / x) : (bound - x) / (y - x);
}

/* Slip rate at a fraction of the way from a to b */
PetscReal SlipEventRate(PetscReal a, PetscReal b, PetscReal share)
{
  return a * b > 0 ? a * PetscPowReal(b / a, share) : a + share * (b - a);
}

/* Largest value of the parabola through three points of which the middle one is the highest. If their distances differ
   by more than a factor of two, which no controller causes when steps resolve a peak, the parabola could be far too
   high, and the result is the middle value. */
PetscReal SlipEventPeak(const PetscReal t[3], const PetscReal y[3])
{
  const PetscReal a = t[1] - t[0], b = t[2] - t[1];
  const PetscReal rise = (y[1] - y[0]) / a, fall = (y[2] - y[1]) / b, bend = (fall - rise) / (a + b);
  PetscReal x;

  if (y[1] < y[0] || y[1] < y[2] || bend >= 0 || a > 2 * b || b > 2 * a) return PetscMax(y[1], PetscMax(y[0], y[2]));
  x = 0.5 * (a - rise / bend); /* from t[0] */
  return y[0] + rise * x + bend * x * (x - a);
}

/* Moment magnitude of a moment in N m (Hanks and Kanamori 1979, in the form of the IASPEI standard) */
PetscReal SlipEventMagnitude(PetscReal moment)
{
  return 2.0 / 3.0 * (PetscLog10Real(moment) - 9.1);
}
