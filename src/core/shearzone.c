/*
  Heat and pore pressure in the middle of a shear zone whose heat source q = tau V has a Gaussian profile of standard
  deviation w (Rice 2006; the spectral method of Noda & Lapusta 2010):

     dT/dt = a_th d2T/dy2 + q w(y)/(rho c),      dp/dt = a_hy d2p/dy2 + Lambda dT/dt.

  With G_a(t) = (2 pi (w^2 + 2 a t))^(-1/2), what a unit of heat leaves in the middle after the time t is

     K_T = G_th/(rho c),      K_p = Lambda/(rho c) (a_hy G_hy - a_th G_th)/(a_hy - a_th).

  G_a(t) = 1/pi int_0^oo exp(-k^2 (w^2/2 + a t)) dk becomes a sum of exponentials in time by the trapezoidal rule in
  ln k, whose relative error, 2/sqrt(cosh(pi^2/D)) for the spacing D, is the same at all times: with x = k^2 (w^2/2 + a
  t) it is the size |Gamma((1 + 2 pi i/D)/2)| of the first harmonic. All wavenumbers below the last one become one with
  the same integrals of 1 and of k^2. So each cell remembers n numbers m with dm/dt = -rate m + q, which exact
  exponentials advance over steps of any length.
*/
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>
#include <math.h>

/* The last wavenumber over 1/(w^2/2 + a age)^(1/2), at this tolerance; longer waves together miss its fifth power */
#define LONGEST 0.3
#define LONGEST_TOLERANCE 1e-4
/* Diffusivities that differ by less are taken this far apart, which changes pressure by less than this and leaves 11
   digits. */
#define APART 1e-5
enum { PER_DECADE = 8 }; /* times at which the error is measured */

/* What a unit of heat leaves after t: temperature [K m^2/J], and pressure over Lambda */
void SlipShearZoneKernel(const SlipShearZone *zone, PetscReal t, PetscReal kernel[2])
{
  const PetscReal g[2] = {1 / PetscSqrtReal(2 * PETSC_PI * (PetscSqr(zone->width) + 2 * zone->diffusivity[0] * t)),
                          1 / PetscSqrtReal(2 * PETSC_PI * (PetscSqr(zone->width) + 2 * zone->diffusivity[1] * t))};

  kernel[0] = g[0] / zone->capacity;
  kernel[1] = (zone->share[0] * g[0] + zone->share[1] * g[1]) / zone->capacity;
}

/* The largest relative errors of both kernels from 0 to zone->age */
static void Measure(SlipShearZone *zone)
{
  const PetscReal first =
    1e-3 * PetscSqr(zone->width) /
    PetscMax(PetscMax(zone->diffusivity[0], zone->diffusivity[1]), PetscSqr(zone->width) / zone->age);

  zone->error[0] = zone->error[1] = 0;
  for (PetscReal t = 0; t <= zone->age; t = t > 0 ? t * PetscPowReal(10, 1.0 / PER_DECADE) : first) {
    PetscReal exact[2], sum[2] = {0, 0};

    SlipShearZoneKernel(zone, t, exact);
    for (PetscInt k = 0; k < zone->n; k++) {
      const PetscReal left = PetscExpReal(-zone->rate[k] * t);

      sum[0] += zone->temperature[k] * left;
      sum[1] += zone->pressure[k] * left;
    }
    for (int f = 0; f < 2; f++) zone->error[f] = PetscMax(zone->error[f], PetscAbsReal(sum[f] / exact[f] - 1));
  }
}

/* Sets up the sums for this relative error of G. */
static PetscErrorCode Sum(PetscReal tolerance, SlipShearZone *zone)
{
  const PetscReal w = zone->width, spacing = PetscSqr(PETSC_PI) / acosh(4 / PetscSqr(tolerance));
  const PetscReal ratio = PetscExpReal(-spacing), *a = zone->diffusivity;
  const PetscReal shortest = PetscSqrtReal(2 * PetscLogReal(1 / tolerance)) / w;
  const PetscReal longest = LONGEST * PetscPowReal(tolerance / LONGEST_TOLERANCE, 0.2) /
                            PetscSqrtReal(PetscSqr(w) / 2 + PetscMax(a[0], a[1]) * zone->age);
  const PetscInt n = (PetscInt)PetscCeilReal(PetscLogReal(shortest / longest) / spacing) + 1;

  PetscFunctionBegin;
  zone->n = 2 * (n + 1);
  PetscCall(PetscMalloc3(zone->n, &zone->rate, zone->n, &zone->temperature, zone->n, &zone->pressure));
  for (PetscInt k = 0; k <= n; k++) {
    PetscReal wave = shortest * PetscExpReal(-spacing * (PetscReal)k), weight;

    if (k < n)
      weight = spacing * wave;
    else { /* the rest of the sum over wave ratio^j, in which k^2 has this mean */
      weight = spacing * wave / (1 - ratio);
      wave *= PetscSqrtReal((1 - ratio) / (1 - PetscPowReal(ratio, 3)));
    }
    weight *= PetscExpReal(-PetscSqr(wave * w) / 2) / (PETSC_PI * zone->capacity);
    for (PetscInt d = 0; d < 2; d++) {
      zone->rate[2 * k + d] = a[d] * PetscSqr(wave);
      zone->temperature[2 * k + d] = d ? 0 : weight;
      zone->pressure[2 * k + d] = zone->share[d] * weight;
    }
  }
  Measure(zone);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the wavenumbers for a relative error of both kernels up to the age [s] of heat; heat that is older decays too
   fast. zone has width, diffusivity and capacity. The kernel of pressure has up to 13 times the error of G, where both
   diffusivities are equal. */
PetscErrorCode SlipShearZoneCreate(PetscReal tolerance, PetscReal age, SlipShearZone *zone)
{
  PetscReal *a = zone->diffusivity;
  const PetscReal fastest = PetscMax(a[0], a[1]);

  PetscFunctionBegin;
  if (fastest > 0 && PetscAbsReal(a[1] - a[0]) < APART * fastest) a[1] = a[0] * (1 + APART);
  zone->share[1] = fastest > 0 ? a[1] / (a[1] - a[0]) : 0;
  zone->share[0] = 1 - zone->share[1];
  zone->age = age;
  zone->n = 0;
  for (PetscReal each = tolerance; each > PETSC_MACHINE_EPSILON; each /= (PetscReal)1.3) {
    if (zone->n) PetscCall(SlipShearZoneDestroy(zone));
    PetscCall(Sum(each, zone));
    if (PetscMax(zone->error[0], zone->error[1]) <= tolerance) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the sums. */
PetscErrorCode SlipShearZoneDestroy(SlipShearZone *zone)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(zone->rate, zone->temperature, zone->pressure));
  zone->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* moment_j = int_0^1 exp(-x (1 - y)) y^j dy, j = 0, 1, 2 */
static void Moments(PetscReal x, PetscReal moment[3])
{
  if (x < 1) { /* sum of (-x)^m 2!/(m + 3)!, and down from there */
    PetscReal term = 1.0 / 3;

    moment[2] = 0;
    for (int m = 1; m < 20; m++) {
      moment[2] += term;
      term *= -x / (m + 3);
    }
    moment[1] = (1 - x * moment[2]) / 2;
    moment[0] = 1 - x * moment[1];
  } else {
    moment[0] = -expm1(-x) / x;
    moment[1] = (1 - moment[0]) / x;
    moment[2] = (1 - 2 * moment[1]) / x;
  }
}

/* Weights of a step h [s] of a number with this rate [1/s]: m becomes left m + start q0 + heat Q, where q0 is the power
   at the start and Q the heat of the step, between which the power is linear in time, q0 + 2 (Q/h - q0) t/h. curve is
   what a parabola adds whose value at the end exceeds that line by 1: its integral is 0. */
void SlipShearZoneStep(PetscReal rate, PetscReal h, SlipShearZoneWeights *weights)
{
  PetscReal moment[3];

  Moments(rate * h, moment);
  weights->left = PetscExpReal(-rate * h);
  weights->start = h * (moment[0] - 2 * moment[1]);
  weights->heat = 2 * moment[1];
  weights->curve = h * (3 * moment[2] - 2 * moment[1]);
}
