/* Heat and pore pressure of a shear zone as sums of exponentials: kernels and weights against closed forms, and slip at
   constant friction and rate against Rice (2006). */
#include "unit.h"
#include <slipstep/rooms/slipcore.h>
#include <math.h>

static const PetscReal RHO_C = 2.7e6, LAMBDA = 1e5, SIGMA = 1e8, YEAR = 3.15576e7;

static SlipShearZone Zone(PetscReal width, PetscReal thermal, PetscReal hydraulic, PetscReal tolerance, PetscReal age)
{
  SlipShearZone zone = {.width = width, .diffusivity = {thermal, hydraulic}, .capacity = RHO_C};

  ok(SlipShearZoneCreate(tolerance, age, &zone));
  return zone;
}

/* The sums equal the kernels to the tolerance, at times between those of the set-up, and the set-up says so. */
static void kernels(void **state)
{
  const PetscReal of[][4] = {{1e-3, 1e-6, 1e-4, 1e-4}, {1e-2, 1e-6, 1e-6, 1e-4}, {1e-5, 1e-6, 1e-7, 1e-6},
                             {1e-3, 0, 1e-5, 1e-3},    {1e-3, 1e-6, 0, 1e-3},    {1e-3, 0, 0, 1e-4}};

  for (size_t c = 0; c < PETSC_STATIC_ARRAY_LENGTH(of); c++) {
    const PetscReal w = of[c][0], th = of[c][1], hy = of[c][2], tolerance = of[c][3], age = 1e4 * YEAR;
    SlipShearZone zone = Zone(w, th, hy, tolerance, age);

    print_message("w %g th %g hy %g: %d numbers, errors %.2g %.2g of %g\n", (double)w, (double)th, (double)hy,
                  (int)zone.n, (double)zone.error[0], (double)zone.error[1], (double)tolerance);
    assert_true(zone.error[0] <= tolerance && zone.error[1] <= tolerance);
    assert_true(zone.n < 160);
    for (PetscReal t = 1.37e-7; t < age; t *= 3.1) {
      PetscReal sum[2] = {0, 0}, g = 1 / sqrt(2 * PETSC_PI * (w * w + 2 * th * t)), p;

      for (PetscInt k = 0; k < zone.n; k++) {
        sum[0] += zone.temperature[k] * exp(-zone.rate[k] * t);
        sum[1] += zone.pressure[k] * exp(-zone.rate[k] * t);
      }
      AssertNear(sum[0], g / RHO_C, 1.1 * tolerance * g / RHO_C); /* a tenth for times in between */
      if (th != hy)
        p = (hy / sqrt(2 * PETSC_PI * (w * w + 2 * hy * t)) - th * g) / (hy - th);
      else /* d(a G_a)/da, as G_a = (2 pi (w^2 + 2 a t))^(-1/2) */
        p = g * (w * w + th * t) / (w * w + 2 * th * t);
      AssertNear(sum[1], p / RHO_C, 1.1 * tolerance * p / RHO_C + 1e-5 * p / RHO_C * (th == hy));
    }
    ok(SlipShearZoneDestroy(&zone));
  }
}

/* Weights against integrals of exp(-x (1 - y)) by Simpson's rule with 2000 intervals, whose error is below 1e-9 where
   x is at most 30 */
static void weights(void **state)
{
  for (PetscReal x = 1e-9; x < 30; x *= 2.3) {
    const PetscReal h = 3;
    PetscReal sum[3] = {0, 0, 0};
    SlipShearZoneWeights a;

    for (int k = 0; k <= 2000; k++) {
      const PetscReal y = k / 2000.0, f = exp(-x * (1 - y)) * (k % 2000 == 0 ? 1 : k % 2 ? 4 : 2) / 6000;

      sum[0] += f * (1 - 2 * y);
      sum[1] += f * 2 * y;
      sum[2] += f * (3 * y * y - 2 * y);
    }
    SlipShearZoneStep(x / h, h, &a);
    AssertNear(a.left, exp(-x), 1e-14);
    AssertNear(a.start, h * sum[0], 1e-8);
    AssertNear(a.heat, sum[1], 1e-8);
    AssertNear(a.curve, h * sum[2], 1e-8);
  }
}

/* Slips for the time end at the rate v and constant friction f in n steps, as the fault does: strength f (sigma - p), p
   = p* + heat (tau0 + tau1)/2 v h. Returns shear stress and temperature at the end. */
static void Slide(const SlipShearZone *zone, PetscReal f, PetscReal v, PetscReal end, int n, PetscReal *tau,
                  PetscReal *temperature)
{
  const PetscReal h = end / n;
  PetscReal m[200] = {0};
  SlipShearZoneWeights w;

  assert_true(zone->n <= 200);
  *tau = f * SIGMA;
  for (int step = 0; step < n; step++) {
    PetscReal p = 0, heat = 0, before = *tau, Q;

    for (PetscInt k = 0; k < zone->n; k++) {
      SlipShearZoneStep(zone->rate[k], h, &w);
      p += LAMBDA * zone->pressure[k] * (w.left * m[k] + w.start * before * v);
      heat += LAMBDA * zone->pressure[k] * w.heat;
    }
    *tau = f * (SIGMA - p - heat * before * v * h / 2) / (1 + f * heat * v * h / 2);
    Q = (before + *tau) / 2 * v * h;
    *temperature = 0;
    for (PetscInt k = 0; k < zone->n; k++) {
      SlipShearZoneStep(zone->rate[k], h, &w);
      m[k] = w.left * m[k] + w.start * before * v + w.heat * Q;
      *temperature += zone->temperature[k] * m[k];
    }
  }
}

/* Undrained and adiabatic: tau = f sigma exp(-f Lambda slip/(rho c h)), h = sqrt(2 pi) w, by steps of second order */
static void undrained(void **state)
{
  const PetscReal w = 5e-3, f = 0.6, h = sqrt(2 * PETSC_PI) * w, slip = 2 * RHO_C * h / (f * LAMBDA);
  const PetscReal exact = f * SIGMA * exp(-2), rise = SIGMA / LAMBDA * (1 - exp(-2));
  SlipShearZone zone = Zone(w, 0, 0, 1e-6, YEAR);
  PetscReal tau[3], T;

  for (int k = 0; k < 3; k++) Slide(&zone, f, 1, slip, 40 << k, &tau[k], &T);
  AssertNear(log2((tau[0] - exact) / (tau[1] - exact)), 2, 0.1);
  AssertNear(log2((tau[1] - exact) / (tau[2] - exact)), 2, 0.1);
  AssertNear(tau[2], exact, 1e-3 * exact);
  AssertNear(T, rise, 1e-3 * rise);
  ok(SlipShearZoneDestroy(&zone));
}

/* Slip on a plane: tau = f sigma exp(x) erfc(sqrt(x)), x = slip/L*; the zone is so thin that its width changes this by
   less than w/sqrt(a t) = 1e-4. Pressure begins as sqrt(t), so the order is below 2. */
static void on_a_plane(void **state)
{
  const PetscReal th = 1e-6, of[] = {1e-4, 1e-5, 1e-6}, f = 0.6, v = 1;

  for (int k = 0; k < 3; k++)
    for (PetscReal x = 0.1; x < 5; x *= 3) {
      const PetscReal L = 4 / (f * f) * PetscSqr(RHO_C / LAMBDA) * PetscSqr(sqrt(of[k]) + sqrt(th)) / v,
                      end = x * L / v;
      const PetscReal g = exp(x) * erfc(sqrt(x)), exact = f * SIGMA * g;
      const PetscReal rise = (1 + sqrt(of[k] / th)) * SIGMA / LAMBDA * (1 - g);
      SlipShearZone zone = Zone(1e-4 * sqrt(th * end), th, of[k], 1e-5, YEAR);
      PetscReal tau, T;

      Slide(&zone, f, v, end, 2000, &tau, &T);
      print_message("a_hy %g, slip %g L*: shear stress %.3e, temperature %.3e off\n", (double)of[k], (double)x,
                    (double)(tau / exact - 1), (double)(T / rise - 1));
      AssertNear(tau, exact, 1e-3 * exact);
      AssertNear(T, rise, 1e-3 * rise);
      ok(SlipShearZoneDestroy(&zone));
    }
}

SLIP_TESTS(kernels, weights, undrained, on_a_plane)
