/* Families of random equations, stiff, oscillating and nonsmooth; a row of the table each. The textbook problems of
   tests/benchmarks/ode.c are none of them: no Van der Pol, no inverse-square force, no kinetics of the literature. */
#include "ode.h"
#include <slipcompat.h>
#include <math.h>

static double Between(Random *r, double low, double high)
{
  return low + (high - low) * RandomUniform(r);
}

/* y_i' = (-y_i + sum_j W_ij tanh(y_j) + b_i + a sin(omega t)) / tau_i: fixed points, cycles, little chaos */
static void Network(const Ode *o, double t, const double y[], double dy[])
{
  const double *tau = o->p, *b = tau + o->n, *W = b + o->n, *wave = W + o->n * o->n;
  double x[ODE_MAX_N];
  const double drive = wave[0] * sin(wave[1] * t);

  for (PetscInt i = 0; i < o->n; ++i) x[i] = tanh(y[i]);
  for (PetscInt i = 0; i < o->n; ++i) {
    double sum = -y[i] + b[i] + drive;

    for (PetscInt j = 0; j < o->n; ++j) sum += W[i * o->n + j] * x[j];
    dy[i] = sum / tau[i];
  }
}

static void DrawNetwork(Random *r, Ode *o)
{
  const double gain = Between(r, 1, 2.5);
  double *p = o->p;

  o->n = 2 + (PetscInt)RandomIndex(r, 4);
  for (PetscInt i = 0; i < o->n; ++i) *p++ = RandomLog(r, 0.02, 1);
  for (PetscInt i = 0; i < o->n; ++i) *p++ = 0.5 * RandomNormal(r);
  for (PetscInt i = 0; i < o->n * o->n; ++i) *p++ = gain * RandomNormal(r);
  *p++ = Between(r, 0, 1);
  *p++ = RandomLog(r, 0.5, 10);
  for (PetscInt i = 0; i < o->n; ++i) o->y0[i] = RandomNormal(r);
  o->end = RandomLog(r, 2, 20);
}

/* y_i' = -lambda_i (y_i - g_i(t)) + c y_(i-1): relaxation, fast or slow, to curves that jump smoothly */
static void Relaxation(const Ode *o, double t, const double y[], double dy[])
{
  for (PetscInt i = 0; i < o->n; ++i) {
    const double *p = o->p + 8 * i;
    const double g = p[1] * sin(p[2] * t) + p[3] * tanh((t - p[4]) / p[5]) + p[6] * tanh((t - p[7]) / p[5]);

    dy[i] = -p[0] * (y[i] - g) + (i ? y[i - 1] : 0);
  }
}

static void DrawRelaxation(Random *r, Ode *o)
{
  o->n = 1 + (PetscInt)RandomIndex(r, 4);
  o->end = 10;
  for (PetscInt i = 0; i < o->n; ++i) {
    double *p = o->p + 8 * i;

    p[0] = RandomLog(r, 0.3, 1e3);
    p[1] = Between(r, 0, 1);
    p[2] = RandomLog(r, 0.3, 10);
    p[3] = Between(r, 0, 1);
    p[4] = Between(r, 1, 9);
    p[5] = RandomLog(r, 1e-3, 1);
    p[6] = Between(r, -1, 0);
    p[7] = Between(r, 1, 9);
    o->y0[i] = RandomNormal(r);
  }
}

/* x' = (y - S(x))/eps, y' = m - x + a sin(omega t), S(x) = x - g tanh(2 x): sits on branches of S and jumps between
   them */
static void SlowFast(const Ode *o, double t, const double y[], double dy[])
{
  const double *p = o->p;

  dy[0] = (y[1] - y[0] + p[1] * tanh(2 * y[0])) / p[0];
  dy[1] = p[2] - y[0] + p[3] * sin(p[4] * t);
}

static void DrawSlowFast(Random *r, Ode *o)
{
  o->n = 2;
  o->p[0] = RandomLog(r, 2e-3, 0.5);
  o->p[1] = Between(r, 1, 3);
  o->p[2] = Between(r, -0.4, 0.4);
  o->p[3] = Between(r, 0, 0.5);
  o->p[4] = RandomLog(r, 0.3, 5);
  o->y0[0] = RandomNormal(r);
  o->y0[1] = RandomNormal(r);
  o->end = RandomLog(r, 4, 20);
}

/* x'' = -k x - c x' + F cos(omega t) + K max(0, gap - x) - m tanh(x'/d): a stop on one side, friction at low rates */
static void Contact(const Ode *o, double t, const double y[], double dy[])
{
  const double *p = o->p, into = p[5] - y[0];

  dy[0] = y[1];
  dy[1] = -p[0] * y[0] - p[1] * y[1] + p[2] * cos(p[3] * t) + (into > 0 ? p[4] * into : 0) - p[6] * tanh(y[1] / p[7]);
}

static void DrawContact(Random *r, Ode *o)
{
  o->n = 2;
  o->p[0] = RandomLog(r, 0.3, 30);
  o->p[1] = Between(r, 0, 0.5);
  o->p[2] = Between(r, 0, 3);
  o->p[3] = RandomLog(r, 0.5, 5);
  o->p[4] = RandomLog(r, 10, 1e4);
  o->p[5] = Between(r, -0.8, -0.1);
  o->p[6] = RandomUniform(r) < 0.5 ? 0 : Between(r, 0.1, 1);
  o->p[7] = RandomLog(r, 3e-3, 0.3);
  o->y0[0] = Between(r, 0, 1);
  o->y0[1] = RandomNormal(r);
  o->end = RandomLog(r, 3, 20);
}

/* y_i' = r_(i-1) y_(i-1) - r_i y_i, the first one fed at rates that switch at random times */
static void Chain(const Ode *o, double t, const double y[], double dy[])
{
  const double *rate = o->p, *when = rate + ODE_MAX_N, *feed = when + 8;
  double in = 0;

  for (PetscInt i = 0; i < 8; ++i) in = t >= when[i] ? feed[i] : in;
  for (PetscInt i = 0; i < o->n; ++i) {
    const double out = rate[i] * y[i];

    dy[i] = in - out;
    in = out;
  }
}

static void DrawChain(Random *r, Ode *o)
{
  double t = 0;

  o->n = 2 + (PetscInt)RandomIndex(r, 3);
  o->end = 10;
  for (PetscInt i = 0; i < ODE_MAX_N; ++i) o->p[i] = RandomLog(r, 0.3, 100);
  for (PetscInt i = 0; i < 8; ++i) {
    t += Between(r, 0.2, 2.3);
    o->p[ODE_MAX_N + i] = t;
    o->p[ODE_MAX_N + 8 + i] = RandomUniform(r) < 0.4 ? 0 : Between(r, 0, 3);
  }
  for (PetscInt i = 0; i < o->n; ++i) o->y0[i] = Between(r, 0, 1);
}

/* r'' = -r/|r|^(e + 1), softened; e is not 2 */
static void Central(const Ode *o, double t, const double y[], double dy[])
{
  const double d2 = y[0] * y[0] + y[1] * y[1] + o->p[1], a = -pow(d2, -0.5 * (o->p[0] + 1));

  (void)t;
  dy[0] = y[2];
  dy[1] = y[3];
  dy[2] = a * y[0];
  dy[3] = a * y[1];
}

static void DrawCentral(Random *r, Ode *o)
{
  o->n = 4;
  o->p[0] = RandomUniform(r) < 0.5 ? Between(r, 1.1, 1.8) : Between(r, 2.2, 2.6);
  o->p[1] = RandomLog(r, 1e-6, 1e-3);
  o->y0[0] = 1;
  o->y0[1] = 0;
  o->y0[2] = Between(r, -0.3, 0.3);
  o->y0[3] = Between(r, 0.3, 1);
  o->end = RandomLog(r, 4, 20);
}

/* A to B, B + B to C, C to A, A + C to 2 C */
static void Kinetics(const Ode *o, double t, const double y[], double dy[])
{
  const double *k = o->p, ab = k[0] * y[0], bc = k[1] * y[1] * y[1], ca = k[2] * y[2] - k[3] * y[0] * y[2];

  (void)t;
  dy[0] = ca - ab;
  dy[1] = ab - bc;
  dy[2] = bc - ca;
}

static void DrawKinetics(Random *r, Ode *o)
{
  o->n = 3;
  for (PetscInt i = 0; i < 4; ++i) o->p[i] = RandomLog(r, 0.05, 500);
  o->y0[0] = 1;
  o->y0[1] = Between(r, 0, 0.2);
  o->y0[2] = RandomLog(r, 1e-4, 0.3);
  o->end = RandomLog(r, 0.5, 20);
}

/* Two coupled oscillators driven by a wave whose frequency grows */
static void Driven(const Ode *o, double t, const double y[], double dy[])
{
  const double *p = o->p, drive = p[4] * sin((p[5] + p[6] * t) * t), c = p[7] * (y[2] - y[0]);

  dy[0] = y[1];
  dy[1] = -p[0] * p[0] * y[0] - p[1] * y[1] + c + drive;
  dy[2] = y[3];
  dy[3] = -p[2] * p[2] * y[2] - p[3] * y[3] - c;
}

static void DrawDriven(Random *r, Ode *o)
{
  o->n = 4;
  o->p[0] = RandomLog(r, 0.5, 10);
  o->p[1] = Between(r, 0, 1);
  o->p[2] = RandomLog(r, 0.5, 30);
  o->p[3] = RandomLog(r, 0.01, 30);
  o->p[4] = Between(r, 0, 3);
  o->p[5] = Between(r, 0, 2);
  o->p[6] = Between(r, 0, 1);
  o->p[7] = Between(r, 0, 2);
  for (PetscInt i = 0; i < 4; ++i) o->y0[i] = RandomNormal(r);
  o->end = RandomLog(r, 3, 15);
}

static const struct {
  const char *name;
  OdeFn f;
  void (*draw)(Random *r, Ode *o);
} Family[] = {{"network", Network, DrawNetwork},     {"relaxation", Relaxation, DrawRelaxation},
              {"slow_fast", SlowFast, DrawSlowFast}, {"contact", Contact, DrawContact},
              {"chain", Chain, DrawChain},           {"central", Central, DrawCentral},
              {"kinetics", Kinetics, DrawKinetics},  {"driven", Driven, DrawDriven}};

const PetscInt OdeKinds = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(Family);

void OdeDraw(Random *random, PetscInt kind, Ode *ode)
{
  memset(ode, 0, sizeof(*ode));
  ode->kind = Family[kind].name;
  ode->f = Family[kind].f;
  Family[kind].draw(random, ode);
}
