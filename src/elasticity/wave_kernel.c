#define _DEFAULT_SOURCE /* j0, j1 */
/*
  The kernels of waves of one wavenumber, in closed form. With J = int_0^x J0 and a = cp/cs,

     W_III(T) = int_T^inf J1(x)/x dx = 1 + J1(T) - J(T),
     W_II(T)  = 2 (1 - 1/a^2) - int_0^T C,  C(T) = J1(T)/T + 4 T [W_III(a T) - W_III(T)] - (4/a) J0(a T) + 3 J0(T)

  (Geubelle & Rice 1995), of which the integrals of x W_III(x) and of J0 are in closed form as well.
*/
#include <slipstep/rooms/slipwaves.h>
#include <slipcompat.h>
#include <math.h>

/* Gauss' points of a panel and their weights, on [-1, 1] */
#define POINTS 8
static const double point[POINTS / 2] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                         0.9602898564975363},
                                   weight[POINTS / 2] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                         0.1012285362903763};
#define PANEL 0.5 /* longest panel, for which the integral of J0 is accurate to rounding */

/* Returns int_x^y J0. */
static double Between(double x, double y)
{
  const int panels = 1 + (int)((y - x) / PANEL);
  const double half = (y - x) / (2 * panels);
  double sum = 0;

  for (int k = 0; k < panels; k++)
    for (int i = 0; i < POINTS / 2; i++) {
      const double centre = x + (2 * k + 1) * half;

      sum += half * weight[i] * (j0(centre - half * point[i]) + j0(centre + half * point[i]));
    }
  return sum;
}

/* Returns W(0), the static stiffness of a mode over G k/2. mode: SLIP_WAVE_ANTIPLANE or SLIP_WAVE_INPLANE; ratio:
   cp/cs, above 1; of mode II alone, dimensionless. */
PetscReal SlipWaveStatic(SlipWaveMode mode, PetscReal ratio)
{
  return mode == SLIP_WAVE_ANTIPLANE ? 1 : 2 * (1 - 1 / (ratio * ratio));
}

/* Return W_III(x), and the integral of x W_III(x) from 0, from J = int_0^x J0. */
static double Antiplane(double x, double J)
{
  return 1 + j1(x) - J;
}

static double Moment(double x, double J)
{
  return 0.5 * (x * x * Antiplane(x, J) + J - x * j0(x));
}

/* Computes W(T), the part of the stress by slip of one wavenumber that arrives after the time T. mode:
   SLIP_WAVE_ANTIPLANE or SLIP_WAVE_INPLANE; ratio: cp/cs, above 1; of mode II alone, dimensionless; T: [n] times k cs
   t, ascending, not negative, dimensionless; W: [n], dimensionless, with an error of 1e-16 T^2 in mode II. Errors:
   PETSC_ERR_ARG_OUTOFRANGE for times that are negative or descend. Geubelle & Rice (1995). */
PetscErrorCode SlipWaveKernel(SlipWaveMode mode, PetscReal ratio, PetscInt n, const PetscReal T[], PetscReal W[])
{
  const double a = (double)ratio, square = 1 / (a * a);
  double x = 0, J = 0, far = 0; /* the integrals to x and to a x */

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    const double t = (double)T[i];

    PetscCheck(t >= x, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "Time %" PetscInt_FMT " is %g, expected ascending ones, not negative", i, t);
    J += Between(x, t);
    W[i] = (PetscReal)Antiplane(t, J);
    if (mode == SLIP_WAVE_INPLANE) {
      far += Between(a * x, a * t);
      W[i] +=
        (PetscReal)(1 - 2 * square - 4 * (square * Moment(a * t, far) - Moment(t, J)) - (3 * J - 4 * square * far));
    }
    x = t;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
