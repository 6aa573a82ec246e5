/* Formulas of the catalogue of events: when a slip rate passes a bound within a step, how it goes there, the peak of a
   course, the magnitude.

   Between the ends of a step a slip rate goes by a straight line of its logarithm, which is exact for what grows or
   decays exponentially, as nucleation does. Where one end rests or slips the other way there is no logarithm, and it
   goes by a straight line: friction starts and stops a cell from and to exactly zero with a finite acceleration. Both
   are of the integrator's order, never leave the range of the two ends, and need no derivative, which nobody knows
   where a cell has just stopped. */
#include <slipcompat.h>
#include <slipcore.h>

/* Share of the way from slow to fast at which |v| is bound: |slow| <= bound < |fast| */
PetscReal SlipEventCrossing(PetscReal slow, PetscReal fast, PetscReal bound)
{
  const PetscReal x = fast > 0 ? slow : -slow, y = PetscAbsReal(fast);

  return x > 0 ? PetscLogReal(bound / x) / PetscLogReal(y / x) : (bound - x) / (y - x);
}

/* Slip rate at a share of the way from a to b */
PetscReal SlipEventRate(PetscReal a, PetscReal b, PetscReal share)
{
  return a * b > 0 ? a * PetscPowReal(b / a, share) : a + share * (b - a);
}

/* Largest value of the parabola through three points of which the middle one is the highest. Where their distances
   differ by more than a factor of two, which no controller makes of steps that resolve a peak, it could be far too
   high: the middle one counts then. */
PetscReal SlipEventPeak(const PetscReal t[3], const PetscReal y[3])
{
  const PetscReal a = t[1] - t[0], b = t[2] - t[1];
  const PetscReal rise = (y[1] - y[0]) / a, fall = (y[2] - y[1]) / b, bend = (fall - rise) / (a + b);
  PetscReal x;

  if (y[1] < y[0] || y[1] < y[2] || bend >= 0 || a > 2 * b || b > 2 * a) return PetscMax(y[1], PetscMax(y[0], y[2]));
  x = 0.5 * (a - rise / bend); /* from t[0] */
  return y[0] + rise * x + bend * x * (x - a);
}

/* Moment magnitude of a moment in N m (Hanks and Kanamori 1979, as the IASPEI standard has it) */
PetscReal SlipEventMagnitude(PetscReal moment)
{
  return 2.0 / 3.0 * (PetscLog10Real(moment) - 9.1);
}
