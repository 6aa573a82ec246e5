static const char help[] = "Twenty ordinary differential equations of the literature, none of them in the training of "
                           "the general policy, under\n"
                           "any step-size controller: work and error, a line each run.\n"
                           "  ode -bench_problems duffing,flame -bench_controllers basic,dsp:PI42,rl,rl:other.h5\n"
                           "Prints \"problem method controller tolerance work error steps rejected end\". "
                           "tests/benchmarks/ode.py compares them.\n\n";

/* Error: root mean square over time and components, each in units of its largest value. Work: evaluations of f, and of its
   Jacobian with the solve that follows; Jacobians by differences count as one. */
#include <slipstep.h>
#include <math.h>
#include <stdlib.h>

enum { MAX_N = 40, STAGES = 7, TOLERANCES = 7, MAX_STEPS = 60000, MAX_WORK = 200000, NEWTON = 10 };

/* ---- the problems, in the order of the table: y' = f(t, y), n components ---- */

static void VanDerPol(double mu, const double y[], double f[])
{
  f[0] = y[1];
  f[1] = mu * (1 - y[0] * y[0]) * y[1] - y[0];
}

static void VanDerPol5(double t, const double y[], double f[])
{
  (void)t;
  VanDerPol(5, y, f);
}

static void VanDerPol100(double t, const double y[], double f[])
{
  (void)t;
  VanDerPol(100, y, f);
}

static void VanDerPol1000(double t, const double y[], double f[])
{
  (void)t;
  VanDerPol(1000, y, f);
}

static void Robertson(double t, const double y[], double f[])
{
  (void)t;
  f[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
  f[2] = 3e7 * y[1] * y[1];
  f[1] = -f[0] - f[2];
}

/* Hairer and Wanner (1996), section IV.10 */
static void Hires(double t, const double y[], double f[])
{
  (void)t;
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
  (void)t;
  f[0] = 77.27 * (y[1] + y[0] * (1 - 8.375e-6 * y[0] - y[1]));
  f[1] = (y[2] - (1 + y[0]) * y[1]) / 77.27;
  f[2] = 0.161 * (y[0] - y[2]);
}

static void Brusselator(double t, const double y[], double f[])
{
  const double a = y[0] * y[0] * y[1];

  (void)t;
  f[0] = 1 + a - 4 * y[0];
  f[1] = 3 * y[0] - a;
}

/* Hairer, Norsett and Wanner (1993), section II.0 */
static void Arenstorf(double t, const double y[], double f[])
{
  const double mu = 0.012277471, nu = 1 - mu;
  const double d1 = pow((y[0] + mu) * (y[0] + mu) + y[1] * y[1], 1.5),
               d2 = pow((y[0] - nu) * (y[0] - nu) + y[1] * y[1], 1.5);

  (void)t;
  f[0] = y[2];
  f[1] = y[3];
  f[2] = y[0] + 2 * y[3] - nu * (y[0] + mu) / d1 - mu * (y[0] - nu) / d2;
  f[3] = y[1] - 2 * y[2] - nu * y[1] / d1 - mu * y[1] / d2;
}

static void Kepler(double t, const double y[], double f[])
{
  const double a = -pow(y[0] * y[0] + y[1] * y[1], -1.5);

  (void)t;
  f[0] = y[2];
  f[1] = y[3];
  f[2] = a * y[0];
  f[3] = a * y[1];
}

/* Seven stars of masses 1 to 7: x, y, x', y' */
static void Pleiades(double t, const double y[], double f[])
{
  (void)t;
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
  (void)t;
  f[0] = y[1];
  f[1] = -9.81 + (y[0] < 0 ? -1e4 * y[0] - 10 * y[1] : 0);
}

/* A block on a belt that moves at 0.3; Coulomb friction that weakens, regularised */
static void StickSlip(double t, const double y[], double f[])
{
  const double v = y[1] - 0.3;

  (void)t;
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
  (void)t;
  for (int i = 0; i < 40; i++) f[i] = 40 * (y[(i + 39) % 40] - y[i]) + 15 * y[i] * (1 - y[i]) * (y[i] - 0.3);
}

static void Lorenz(double t, const double y[], double f[])
{
  (void)t;
  f[0] = 10 * (y[1] - y[0]);
  f[1] = y[0] * (28 - y[2]) - y[1];
  f[2] = y[0] * y[1] - 8. / 3 * y[2];
}

static void FitzHugh(double t, const double y[], double f[])
{
  (void)t;
  f[0] = 10 * (y[0] - y[0] * y[0] * y[0] / 3 - y[1] + 0.5);
  f[1] = 0.8 * (y[0] + 0.7 - 0.8 * y[1]);
}

static void Flame(double t, const double y[], double f[])
{
  (void)t;
  f[0] = y[0] * y[0] * (1 - y[0]);
}

typedef enum { RK3, RK5, ARK3, ARK4, BDF, BATHE, METHODS } Method;
static const char *const MethodNames[] = {"rk3bs", "rk5dp", "arkimex3", "arkimex4", "bdf2", "bathe"};
/* tightest and loosest tolerance */
static const double Tolerances[METHODS][2] = {{1e-6, 1e-2}, {1e-8, 1e-3}, {1e-6, 1e-2},
                                              {1e-7, 1e-2}, {1e-5, 1e-2}, {1e-5, 1e-2}};
#define M(m) (1 << (m))

typedef struct {
  const char *name;
  void (*f)(double t, const double y[], double dy[]);
  int n, methods;
  double end, y0[MAX_N]; /* the first of a problem whose start is a formula is NaN */
} Case;

static const Case Cases[] = {
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
};

/* ---- the reference: Dormand and Prince's pair at 1e-11, kept where a component has changed by 1e-4 of its size ---- */

static const double A[STAGES][STAGES] = {{0},
                                         {1. / 5},
                                         {3. / 40, 9. / 40},
                                         {44. / 45, -56. / 15, 32. / 9},
                                         {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
                                         {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
                                         {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}};
static const double C[STAGES] = {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1};
static const double D[STAGES] = {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40};
#define REFERENCE_TOL 1e-11
#define CHANGE 1e-4

typedef struct {
  const Case *c;
  double y0[MAX_N], scale[MAX_N];
  PetscInt n, capacity;
  double *rows; /* [n][1 + 2 c->n]: time, state, derivative */
} Reference;

static PetscErrorCode Keep(Reference *r, double t, const double y[], const double f[])
{
  const int n = r->c->n, width = 1 + 2 * n;
  double *row;

  PetscFunctionBeginUser;
  if (r->n == r->capacity) {
    double *more;

    r->capacity = 2 * r->capacity + 1024;
    PetscCall(PetscMalloc1(r->capacity * width, &more));
    PetscCall(PetscArraycpy(more, r->rows, r->n * width));
    PetscCall(PetscFree(r->rows));
    r->rows = more;
  }
  row = r->rows + r->n++ * width;
  row[0] = t;
  PetscCall(PetscArraycpy(row + 1, y, n));
  PetscCall(PetscArraycpy(row + 1 + n, f, n));
  PetscFunctionReturn(0);
}

/* One pass; with the scales of the one before it. keep: rows */
static PetscErrorCode Integrate(Reference *r, double tol, PetscBool keep)
{
  const Case *c = r->c;
  const int n = c->n;
  double y[MAX_N], z[MAX_N], k[STAGES][MAX_N], scale[MAX_N], t = 0, h = 1e-8 * c->end;

  PetscFunctionBeginUser;
  for (int i = 0; i < n; i++) scale[i] = fabs(y[i] = r->y0[i]);
  (*c->f)(0, y, k[0]);
  if (keep) PetscCall(Keep(r, 0, y, k[0]));
  while (t < c->end) {
    double E = 0;

    h = PetscMin(h, c->end - t);
    for (int s = 1; s < STAGES; s++) {
      for (int i = 0; i < n; i++) {
        double sum = 0;

        for (int j = 0; j < s; j++) sum += A[s][j] * k[j][i];
        z[i] = y[i] + h * sum;
      }
      (*c->f)(t + C[s] * h, z, k[s]);
    }
    for (int i = 0; i < n; i++) {
      double e = 0;

      for (int j = 0; j < STAGES; j++) e += h * D[j] * k[j][i];
      e /= tol * (r->scale[i] + fabs(y[i]));
      E += e * e / n;
    }
    E = sqrt(E);
    if (E <= 1) {
      PetscBool moved = PETSC_FALSE;
      const double *last = keep ? r->rows + (r->n - 1) * (1 + 2 * n) : NULL;

      t = h < c->end - t ? t + h : c->end;
      PetscCall(PetscArraycpy(y, z, n));
      PetscCall(PetscArraycpy(k[0], k[STAGES - 1], n));
      for (int i = 0; i < n; i++) {
        scale[i] = fmax(scale[i], fabs(y[i]));
        if (keep && fabs(y[i] - last[1 + i]) > CHANGE * r->scale[i]) moved = PETSC_TRUE;
      }
      if (keep && (moved || t - last[0] > CHANGE * c->end || t == c->end)) PetscCall(Keep(r, t, y, k[0]));
    }
    h *= isfinite(E) ? PetscClipInterval(0.9 * pow(E, -0.2), 0.2, 5) : 0.1;
  }
  PetscCall(PetscArraycpy(r->scale, scale, n));
  PetscFunctionReturn(0);
}

static PetscErrorCode ReferenceCreate(const Case *c, Reference *r)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(r, sizeof(*r)));
  r->c = c;
  for (int i = 0; i < c->n; i++) r->y0[i] = isnan(c->y0[0]) ? exp(-200 * PetscSqr(i / 40. - 0.3)) : c->y0[i];
  for (int i = 0; i < c->n; i++) r->scale[i] = 1;
  PetscCall(Integrate(r, 1e-6, PETSC_FALSE)); /* for the scales */
  PetscCall(Integrate(r, REFERENCE_TOL, PETSC_TRUE));
  PetscFunctionReturn(0);
}

/* Mean square of the deviation at t; at: the interval, which only moves on */
static double Deviation(const Reference *r, double t, const PetscScalar y[], PetscInt *at)
{
  const int n = r->c->n, width = 1 + 2 * n;
  double sum = 0;

  while (*at < r->n - 2 && r->rows[(*at + 1) * width] < t) ++*at;
  const double *a = r->rows + *at * width, *b = a + width, h = b[0] - a[0], x = (t - a[0]) / h;

  for (int i = 0; i < n; i++) {
    const double exact = (1 - x) * (1 - x) * ((1 + 2 * x) * a[1 + i] + x * h * a[1 + n + i]) +
                         x * x * ((3 - 2 * x) * b[1 + i] - (1 - x) * h * b[1 + n + i]);
    const double d = (PetscRealPart(y[i]) - exact) / r->scale[i];

    sum += d * d;
  }
  return sum / n;
}

/* ---- a run ---- */

typedef struct {
  const Reference *r;
  PetscInt f, jacobians, at;
  double t, before, integral;
} Run;

static PetscErrorCode Rhs(TS ts, PetscReal t, Vec y, Vec f, void *ctx)
{
  Run *run = (Run *)ctx;
  const PetscScalar *a;
  PetscScalar *b;

  PetscFunctionBeginUser;
  (void)ts;
  run->f++;
  PetscCheck(run->f <= MAX_WORK, PETSC_COMM_SELF, PETSC_ERR_CONV_FAILED, "More than %d evaluations", (int)MAX_WORK);
  PetscCall(VecGetArrayRead(y, &a));
  PetscCall(VecGetArrayWrite(f, &b));
  (*run->r->c->f)(t, a, b);
  PetscCall(VecRestoreArrayWrite(f, &b));
  PetscCall(VecRestoreArrayRead(y, &a));
  PetscFunctionReturn(0);
}

static PetscErrorCode IFunction(TS ts, PetscReal t, Vec y, Vec ydot, Vec F, void *ctx)
{
  PetscFunctionBeginUser;
  PetscCall(Rhs(ts, t, y, F, ctx));
  PetscCall(VecAYPX(F, -1, ydot));
  PetscFunctionReturn(0);
}

/* shift I + factor df/dy */
static PetscErrorCode Differences(PetscReal t, Vec y, Mat P, PetscReal shift, PetscReal factor, Run *run)
{
  const Reference *r = run->r;
  const int n = r->c->n;
  const PetscScalar *a;
  PetscScalar *J;
  double z[MAX_N], f[MAX_N], g[MAX_N];

  PetscFunctionBeginUser;
  run->jacobians++;
  PetscCall(VecGetArrayRead(y, &a));
  for (int i = 0; i < n; i++) z[i] = a[i];
  PetscCall(VecRestoreArrayRead(y, &a));
  (*r->c->f)(t, z, f);
  PetscCall(MatDenseGetArrayWrite(P, &J));
  for (int j = 0; j < n; j++) {
    const double keep = z[j], step = 1e-7 * (fabs(keep) + 1e-3 * r->scale[j]);

    z[j] += step;
    (*r->c->f)(t, z, g);
    for (int i = 0; i < n; i++) J[j * n + i] = factor * (g[i] - f[i]) / (z[j] - keep) + (i == j ? shift : 0);
    z[j] = keep;
  }
  PetscCall(MatDenseRestoreArrayWrite(P, &J));
  PetscCall(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(0);
}

static PetscErrorCode Jacobian(TS ts, PetscReal t, Vec y, Mat J, Mat P, void *ctx)
{
  PetscFunctionBeginUser;
  (void)ts, (void)J;
  PetscCall(Differences(t, y, P, 0, 1, (Run *)ctx));
  PetscFunctionReturn(0);
}

static PetscErrorCode IJacobian(TS ts, PetscReal t, Vec y, Vec ydot, PetscReal shift, Mat J, Mat P, void *ctx)
{
  PetscFunctionBeginUser;
  (void)ts, (void)ydot, (void)J;
  PetscCall(Differences(t, y, P, shift, -1, (Run *)ctx));
  PetscFunctionReturn(0);
}

static PetscErrorCode Measure(TS ts, PetscInt step, PetscReal t, Vec y, void *ctx)
{
  Run *run = (Run *)ctx;
  const PetscScalar *a;
  double now;

  PetscFunctionBeginUser;
  (void)ts;
  if (step <= 0 || t <= run->t) PetscFunctionReturn(0);
  PetscCall(VecGetArrayRead(y, &a));
  now = Deviation(run->r, t, a, &run->at);
  PetscCall(VecRestoreArrayRead(y, &a));
  run->integral += 0.5 * (t - run->t) * (run->before + now);
  run->before = now;
  run->t = t;
  PetscFunctionReturn(0);
}

/* basic, basic:DELAY (attempts without growth after a failed solve), dsp:FILTER, pi, heuristic, rl or rl:FILE */
static PetscErrorCode SetController(TS ts, const char controller[])
{
  char type[32];
  const char *of = strchr(controller, ':');
  TSAdapt adapt;

  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(type, controller, of ? (size_t)(of - controller) + 1 : sizeof(type)));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptSetType(adapt, type));
  if (of && !strcmp(type, "basic"))
    PetscCall(TSAdaptSetTimeStepIncreaseDelay(adapt, (PetscInt)strtol(of + 1, NULL, 10)));
  if (of && !strcmp(type, "dsp")) PetscCall(TSAdaptDSPSetFilter(adapt, of + 1));
  if (of && !strcmp(type, "rl")) PetscCall(TSAdaptRLSetPolicyFile(adapt, of + 1));
  PetscFunctionReturn(0);
}

static PetscErrorCode SetUp(const Reference *r, Method method, double tol, Run *run, TS *ts, Vec *y)
{
  const int n = r->c->n;
  PetscScalar *a;
  Vec atol;
  Mat J;
  SNES snes;
  KSP ksp;
  PC pc;

  PetscFunctionBeginUser;
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, n, y));
  PetscCall(VecDuplicate(*y, &atol));
  PetscCall(VecGetArray(*y, &a));
  for (int i = 0; i < n; i++) a[i] = r->y0[i];
  PetscCall(VecRestoreArray(*y, &a));
  PetscCall(VecGetArray(atol, &a));
  for (int i = 0; i < n; i++) a[i] = tol * r->scale[i];
  PetscCall(VecRestoreArray(atol, &a));
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, n, n, NULL, &J));
  PetscCall(TSCreate(PETSC_COMM_SELF, ts));
  PetscCall(TSSetType(*ts, method <= RK5 ? TSRK : method <= ARK4 ? TSARKIMEX : method == BDF ? TSBDF : "bathe"));
  if (method <= RK5) PetscCall(TSRKSetType(*ts, method == RK3 ? TSRK3BS : TSRK5DP));
  if (method == ARK3 || method == ARK4) PetscCall(TSARKIMEXSetType(*ts, method == ARK3 ? TSARKIMEX3 : TSARKIMEX4));
  if (method == BDF) PetscCall(TSBDFSetOrder(*ts, 2));
  if (method == ARK3 || method == ARK4 || method == BDF) {
    PetscCall(TSSetIFunction(*ts, NULL, IFunction, run));
    PetscCall(TSSetIJacobian(*ts, J, J, IJacobian, run));
  } else {
    PetscCall(TSSetRHSFunction(*ts, NULL, Rhs, run));
    PetscCall(TSSetRHSJacobian(*ts, J, J, Jacobian, run));
  }
  PetscCall(TSSetTolerances(*ts, 0, atol, tol, NULL));
  PetscCall(TSSetMaxTime(*ts, r->c->end));
  PetscCall(TSSetTimeStep(*ts, 1e-5 * r->c->end));
  PetscCall(TSSetMaxSteps(*ts, MAX_STEPS));
  PetscCall(TSSetMaxSNESFailures(*ts, -1));
  PetscCall(TSSetErrorIfStepFails(*ts, PETSC_FALSE));
  PetscCall(TSSetExactFinalTime(*ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSMonitorSet(*ts, Measure, run, NULL));
  PetscCall(TSGetSNES(*ts, &snes));
  PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, NEWTON, PETSC_DEFAULT));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(PCSetType(pc, PCLU));
  PetscCall(MatDestroy(&J));
  PetscCall(VecDestroy(&atol));
  PetscFunctionReturn(0);
}

static PetscErrorCode RunOne(const Reference *r, Method method, const char controller[], double tol)
{
  Run run = {.r = r};
  PetscInt steps, rejected;
  PetscErrorCode ierr;
  TSConvergedReason reason;
  TS ts;
  Vec y;
  double error;

  PetscFunctionBeginUser;
  PetscCall(SetUp(r, method, tol, &run, &ts, &y));
  PetscCall(SetController(ts, controller));
  PetscCall(PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL));
  ierr = TSSolve(ts, y);
  PetscCall(PetscPopErrorHandler());
  PetscCall(TSGetConvergedReason(ts, &reason));
  PetscCall(TSGetStepNumber(ts, &steps));
  PetscCall(TSGetStepRejections(ts, &rejected));
  error = sqrt(run.integral / r->c->end);
  printf("%s %s %s %.3e %d %.6e %d %d %s\n", r->c->name, MethodNames[method], controller, tol,
         (int)(run.f + run.jacobians), error, (int)steps, (int)rejected,
         ierr                                           ? "error"
         : reason < 0 || run.t < r->c->end * (1 - 1e-9) ? "not_reached"
         : isfinite(error)                              ? "end"
                                                        : "nan");
  PetscCall(TSDestroy(&ts));
  PetscCall(VecDestroy(&y));
  PetscFunctionReturn(0);
}

static PetscErrorCode RunAll(void)
{
  char *problems[32], *controllers[32];
  PetscInt nproblems = 32, ncontrollers = 32;

  PetscFunctionBeginUser;
  PetscOptionsBegin(PETSC_COMM_SELF, NULL, "Benchmark of controllers", "");
  PetscCall(PetscOptionsStringArray("-bench_problems", "Names of problems (all)", "", problems, &nproblems, NULL));
  PetscCall(PetscOptionsStringArray("-bench_controllers", "basic, basic:DELAY, dsp:FILTER, pi, heuristic, rl, rl:FILE",
                                    "", controllers, &ncontrollers, NULL));
  PetscOptionsEnd();
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Cases); k++) {
    PetscBool wanted = nproblems ? PETSC_FALSE : PETSC_TRUE;
    Reference r;

    for (PetscInt i = 0; i < nproblems; i++)
      if (!strcmp(problems[i], Cases[k].name)) wanted = PETSC_TRUE;
    if (!wanted) continue;
    PetscCall(ReferenceCreate(&Cases[k], &r));
    for (int m = 0; m < METHODS; m++) {
      if (!(Cases[k].methods & M(m))) continue;
      for (PetscInt c = 0; c < ncontrollers; c++)
        for (int i = 0; i < TOLERANCES; i++)
          PetscCall(RunOne(&r, (Method)m, controllers[c],
                           Tolerances[m][1] * pow(Tolerances[m][0] / Tolerances[m][1], i / (TOLERANCES - 1.))));
    }
    fflush(stdout);
    PetscCall(PetscFree(r.rows));
  }
  for (PetscInt i = 0; i < nproblems; i++) PetscCall(PetscFree(problems[i]));
  for (PetscInt i = 0; i < ncontrollers; i++) PetscCall(PetscFree(controllers[i]));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(SlipStepInitializePackage());
  PetscCall(SlipErrorHandlerPush("ode"));
  PetscCall(RunAll());
  PetscCall(PetscFinalize());
  return 0;
}
