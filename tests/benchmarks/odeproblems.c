/* Twenty equations of the literature, in the order of the table: y' = f(t, y), n components. */
#include "ode.h"
#include <math.h>

static void VanDerPol(double mu, const double y[], double f[])
{
  f[0] = y[1];
  f[1] = mu * (1 - y[0] * y[0]) * y[1] - y[0];
}

static void VanDerPol5(double t, const double y[], double f[])
{
  VanDerPol(5, y, f);
}

static void VanDerPol100(double t, const double y[], double f[])
{
  VanDerPol(100, y, f);
}

static void VanDerPol1000(double t, const double y[], double f[])
{
  VanDerPol(1000, y, f);
}

static void Robertson(double t, const double y[], double f[])
{
  f[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
  f[2] = 3e7 * y[1] * y[1];
  f[1] = -f[0] - f[2];
}

/* Hairer and Wanner (1996), section IV.10 */
static void Hires(double t, const double y[], double f[])
{
  f[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
  f[1] = 1.71 * y[0] - 8.75 * y[1];
  f[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
  f[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
  f[4] = -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6];
  f[5] = -280 * y[5] * y[7] + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
  f[6] = 280 * y[5] * y[7] - 1.81 * y[6];
  f[7] = -f[6];
}

static void Oregonator(double t, const double y[], double f[])
{
  f[0] = 77.27 * (y[1] + y[0] * (1 - 8.375e-6 * y[0] - y[1]));
  f[1] = (y[2] - (1 + y[0]) * y[1]) / 77.27;
  f[2] = 0.161 * (y[0] - y[2]);
}

static void Brusselator(double t, const double y[], double f[])
{
  const double a = y[0] * y[0] * y[1];

  f[0] = 1 + a - 4 * y[0];
  f[1] = 3 * y[0] - a;
}

/* Hairer, Norsett and Wanner (1993), section II.0 */
static void Arenstorf(double t, const double y[], double f[])
{
  const double mu = 0.012277471, nu = 1 - mu;
  const double d1 = pow((y[0] + mu) * (y[0] + mu) + y[1] * y[1], 1.5),
               d2 = pow((y[0] - nu) * (y[0] - nu) + y[1] * y[1], 1.5);

  f[0] = y[2];
  f[1] = y[3];
  f[2] = y[0] + 2 * y[3] - nu * (y[0] + mu) / d1 - mu * (y[0] - nu) / d2;
  f[3] = y[1] - 2 * y[2] - nu * y[1] / d1 - mu * y[1] / d2;
}

static void Kepler(double t, const double y[], double f[])
{
  const double a = -pow(y[0] * y[0] + y[1] * y[1], -1.5);

  f[0] = y[2];
  f[1] = y[3];
  f[2] = a * y[0];
  f[3] = a * y[1];
}

/* Seven stars of masses 1 to 7: x, y, x', y' */
static void Pleiades(double t, const double y[], double f[])
{
  for (int i = 0; i < 14; i++) {
    f[i] = y[14 + i];
    f[14 + i] = 0;
  }
  for (int i = 0; i < 7; i++)
    for (int j = 0; j < 7; j++) {
      const double dx = y[j] - y[i], dy = y[7 + j] - y[7 + i], d = pow(dx * dx + dy * dy, 1.5);

      if (j == i) continue;
      f[14 + i] += (j + 1) * dx / d;
      f[21 + i] += (j + 1) * dy / d;
    }
}

static void Duffing(double t, const double y[], double f[])
{
  f[0] = y[1];
  f[1] = -0.3 * y[1] + y[0] - y[0] * y[0] * y[0] + 0.5 * cos(1.2 * t);
}

/* Prothero and Robinson: fast to a curve */
static void Forced(double t, const double y[], double f[])
{
  f[0] = -1000 * (y[0] - cos(t)) - sin(t);
}

/* A ball on a floor of stiffness 1e4 */
static void Bounce(double t, const double y[], double f[])
{
  f[0] = y[1];
  f[1] = -9.81 + (y[0] < 0 ? -1e4 * y[0] - 10 * y[1] : 0);
}

/* A block on a belt that moves at 0.3; Coulomb friction that weakens, regularised */
static void StickSlip(double t, const double y[], double f[])
{
  const double v = y[1] - 0.3;

  f[0] = y[1];
  f[1] = -y[0] - 0.02 * y[1] - tanh(v / 0.01) * (0.5 + 0.5 / (1 + fabs(v) / 0.2));
}

/* A drug in gut and blood, a dose a day during an hour */
static void Pulses(double t, const double y[], double f[])
{
  f[0] = (fmod(t, 1) < 1. / 24 ? 24 : 0) - 6 * y[0];
  f[1] = 6 * y[0] - 1.5 * y[1];
}

/* Heat in a rod of 40 cells, cold at both ends, under a source that goes to and fro */
static void Heat(double t, const double y[], double f[])
{
  const double kappa = 0.05 * 41 * 41, at = 0.5 + 0.35 * sin(2 * t);

  for (int i = 0; i < 40; i++) {
    const double x = (i + 1) / 41. - at;

    f[i] = kappa * ((i ? y[i - 1] : 0) - 2 * y[i] + (i < 39 ? y[i + 1] : 0)) + 10 * exp(-x * x / 0.002);
  }
}

/* Fronts that travel round a ring of 40 cells, upwind */
static void Advection(double t, const double y[], double f[])
{
  for (int i = 0; i < 40; i++) f[i] = 40 * (y[(i + 39) % 40] - y[i]) + 15 * y[i] * (1 - y[i]) * (y[i] - 0.3);
}

static void Lorenz(double t, const double y[], double f[])
{
  f[0] = 10 * (y[1] - y[0]);
  f[1] = y[0] * (28 - y[2]) - y[1];
  f[2] = y[0] * y[1] - 8. / 3 * y[2];
}

static void FitzHugh(double t, const double y[], double f[])
{
  f[0] = 10 * (y[0] - y[0] * y[0] * y[0] / 3 - y[1] + 0.5);
  f[1] = 0.8 * (y[0] + 0.7 - 0.8 * y[1]);
}

static void Flame(double t, const double y[], double f[])
{
  f[0] = y[0] * y[0] * (1 - y[0]);
}

const Case Cases[] = {
  {"vanderpol5", VanDerPol5, 2, M(RK3) | M(RK5) | M(ARK3) | M(BATHE), 20, {2}},
  {"vanderpol100", VanDerPol100, 2, M(ARK3) | M(ARK4) | M(BDF) | M(BATHE), 200, {2}},
  {"vanderpol1000", VanDerPol1000, 2, M(ARK4) | M(BDF), 2000, {2}},
  {"robertson", Robertson, 3, M(ARK3) | M(ARK4) | M(BDF), 400, {1}},
  {"hires", Hires, 8, M(ARK3) | M(ARK4) | M(BDF) | M(BATHE), 321.8122, {1, 0, 0, 0, 0, 0, 0, 0.0057}},
  {"oregonator", Oregonator, 3, M(ARK3) | M(ARK4) | M(BDF), 100, {1, 2, 3}},
  {"brusselator", Brusselator, 2, M(RK3) | M(RK5) | M(BDF), 20, {1.5, 3}},
  {"arenstorf", Arenstorf, 4, M(RK3) | M(RK5), 17.0652165601579625, {0.994, 0, 0, -2.00158510637908252}},
  {"kepler", Kepler, 4, M(RK3) | M(RK5), 12.566370614359172, {0.1, 0, 0, 4.358898943540674}},
  {"pleiades", Pleiades, 28, M(RK3) | M(RK5), 3, {3, 3, -1, -3, 2, -2,   2,    3, -3, 2, 0,     0, -4, 4,
                                                  0, 0, 0,  0,  0, 1.75, -1.5, 0, 0,  0, -1.25, 1, 0,  0}},
  {"duffing", Duffing, 2, M(RK3) | M(RK5) | M(ARK3), 30, {1}},
  {"forced", Forced, 1, M(ARK3) | M(BDF) | M(BATHE), 10, {2}},
  {"bounce", Bounce, 2, M(RK3) | M(RK5) | M(BDF) | M(BATHE), 3, {1}},
  {"stick_slip", StickSlip, 2, M(RK3) | M(RK5) | M(ARK3) | M(BATHE), 30, {0}},
  {"pulses", Pulses, 2, M(RK3) | M(RK5) | M(ARK3), 5, {0}},
  {"heat", Heat, 40, M(ARK3) | M(BDF) | M(BATHE), 6, {0}},
  {"advection", Advection, 40, M(RK3) | M(RK5), 3, {NAN}},
  {"lorenz", Lorenz, 3, M(RK3) | M(RK5), 5, {1, 1, 20}},
  {"fitzhugh", FitzHugh, 2, M(RK3) | M(RK5) | M(ARK3) | M(BATHE), 30, {-1, 1}},
  {"flame", Flame, 1, M(RK3) | M(ARK3) | M(BDF), 2000, {1e-3}},
  {NULL, NULL, 0, 0, 0, {0}},
};
