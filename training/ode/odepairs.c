/* Embedded pairs on plain arrays, see ode.h. */
#include "ode.h"
#include <slipcompat.h>
#include <math.h>

typedef struct {
  PetscInt stages;
  double order; /* of E */
  double a[ODE_MAX_STAGES][ODE_MAX_STAGES], c[ODE_MAX_STAGES];
  double error[ODE_MAX_STAGES]; /* weights of the solution less those of the embedded one */
} Tableau;

/* Both have the first stage of the next step as the last one of this: its row are the weights of the solution. */
static const Tableau Tableaus[] = {
  {.stages = 4,
   .order = 3,
   .a = {{0}, {1. / 2}, {0, 3. / 4}, {2. / 9, 1. / 3, 4. / 9}},
   .c = {0, 1. / 2, 3. / 4, 1},
   .error = {2. / 9 - 7. / 24, 1. / 3 - 1. / 4, 4. / 9 - 1. / 3, -1. / 8}},
  {.stages = 7,
   .order = 5,
   .a = {{0},
         {1. / 5},
         {3. / 40, 9. / 40},
         {44. / 45, -56. / 15, 32. / 9},
         {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
         {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
         {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}},
   .c = {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1},
   .error = {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40}}};

double OdeOrder(OdePair pair)
{
  return pair == ODE_BATHE ? 3 : Tableaus[pair].order;
}

void OdeStepperStart(const Ode *ode, OdePair pair, double tol, OdeStepper *s)
{
  memset(s, 0, sizeof(*s));
  s->ode = ode;
  s->pair = pair;
  s->tol = tol;
  memcpy(s->y, ode->y0, sizeof(s->y));
  ode->f(ode, 0, s->y, s->k);
  s->work = 1;
}

/* PETSc's weighted norm of the two-norm kind, TSErrorWeightedNorm() of the solution and the embedded one */
static double Weighted(const OdeStepper *s, const double e[])
{
  const PetscInt n = s->ode->n;
  double sum = 0;

  for (PetscInt i = 0; i < n; ++i) {
    const double x = e[i] / (s->tol * (1 + fmax(fabs(s->y1[i]), fabs(s->y1[i] - e[i]))));

    sum += x * x;
  }
  return sqrt(sum / (double)n);
}

static PetscBool AttemptExplicit(OdeStepper *s, double h)
{
  const Tableau *tab = &Tableaus[s->pair];
  const PetscInt n = s->ode->n;
  double k[ODE_MAX_STAGES][ODE_MAX_N], e[ODE_MAX_N];

  memcpy(k[0], s->k, sizeof(k[0]));
  for (PetscInt j = 1; j < tab->stages; ++j) {
    for (PetscInt i = 0; i < n; ++i) {
      double sum = 0;

      for (PetscInt m = 0; m < j; ++m) sum += tab->a[j][m] * k[m][i];
      s->y1[i] = s->y[i] + h * sum;
    }
    s->ode->f(s->ode, s->t + tab->c[j] * h, s->y1, k[j]);
  }
  s->work += tab->stages - 1;
  for (PetscInt i = 0; i < n; ++i) {
    e[i] = 0;
    for (PetscInt j = 0; j < tab->stages; ++j) e[i] += h * tab->error[j] * k[j][i];
  }
  memcpy(s->k1, k[tab->stages - 1], sizeof(s->k1));
  s->E = Weighted(s, e);
  if (isnan(s->E)) s->E = PETSC_MAX_REAL;
  return PETSC_TRUE;
}

/* x = A^-1 b by elimination with pivoting; A and b are overwritten */
static PetscBool Solve(PetscInt n, double A[ODE_MAX_N][ODE_MAX_N], double b[])
{
  for (PetscInt c = 0; c < n; ++c) {
    PetscInt pivot = c;

    for (PetscInt i = c + 1; i < n; ++i)
      if (fabs(A[i][c]) > fabs(A[pivot][c])) pivot = i;
    if (!(fabs(A[pivot][c]) > 0)) return PETSC_FALSE;
    for (PetscInt j = 0; j < n; ++j) {
      const double swap = A[c][j];

      A[c][j] = A[pivot][j];
      A[pivot][j] = swap;
    }
    const double swap = b[c];

    b[c] = b[pivot];
    b[pivot] = swap;
    for (PetscInt i = c + 1; i < n; ++i) {
      const double l = A[i][c] / A[c][c];

      for (PetscInt j = c; j < n; ++j) A[i][j] -= l * A[c][j];
      b[i] -= l * b[c];
    }
  }
  for (PetscInt i = n - 1; i >= 0; --i) {
    for (PetscInt j = i + 1; j < n; ++j) b[i] -= A[i][j] * b[j];
    b[i] /= A[i][i];
  }
  return PETSC_TRUE;
}

/* w = base + theta f(t, w) by Newton's method, from w; its differences are not counted, its solves are */
static PetscBool Stage(OdeStepper *s, double t, double theta, const double base[], double w[])
{
  enum { most = 12 };
  const PetscInt n = s->ode->n;
  double f[ODE_MAX_N], g[ODE_MAX_N], d[ODE_MAX_N], A[ODE_MAX_N][ODE_MAX_N];

  for (PetscInt it = 0; it < most; ++it) {
    double norm = 0;

    s->ode->f(s->ode, t, w, f);
    for (PetscInt j = 0; j < n; ++j) {
      const double keep = w[j], eps = 1e-7 * (1 + fabs(keep));

      w[j] += eps;
      s->ode->f(s->ode, t, w, g);
      w[j] = keep;
      for (PetscInt i = 0; i < n; ++i) A[i][j] = (i == j ? 1 : 0) - theta * (g[i] - f[i]) / eps;
    }
    for (PetscInt i = 0; i < n; ++i) d[i] = base[i] + theta * f[i] - w[i];
    s->work += 2;
    if (!Solve(n, A, d)) return PETSC_FALSE;
    for (PetscInt i = 0; i < n; ++i) {
      w[i] += d[i];
      norm = fmax(norm, fabs(d[i]) / (1 + fabs(w[i])));
    }
    if (!(norm < 1e10)) return PETSC_FALSE;
    if (norm < 1e-3 * s->tol) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static PetscBool AttemptBathe(OdeStepper *s, double h)
{
  const PetscInt n = s->ode->n;
  const double gamma = 2 - sqrt(2);
  SlipBathe c;
  double base[ODE_MAX_N] = {0}, w1[ODE_MAX_N], e[ODE_MAX_N];

  SlipBatheSetUp(gamma, &c);
  for (PetscInt i = 0; i < n; ++i) {
    base[i] = s->y[i] + 0.5 * gamma * h * s->k[i];
    w1[i] = s->y[i];
  }
  if (!Stage(s, s->t + gamma * h, 0.5 * gamma * h, base, w1)) return PETSC_FALSE;
  for (PetscInt i = 0; i < n; ++i) {
    e[i] = c.error[0] * s->k[i] + c.error[1] * (w1[i] - base[i]) / (0.5 * gamma * h);
    base[i] = c.a1 * w1[i] - c.a0 * s->y[i];
    s->y1[i] = w1[i];
  }
  if (!Stage(s, s->t + h, c.theta[1] * h, base, s->y1)) return PETSC_FALSE;
  for (PetscInt i = 0; i < n; ++i) {
    s->k1[i] = (s->y1[i] - base[i]) / (c.theta[1] * h);
    e[i] = h * (e[i] + c.error[2] * s->k1[i]);
  }
  s->E = Weighted(s, e);
  return isnan(s->E) ? PETSC_FALSE : PETSC_TRUE;
}

PetscBool OdeAttempt(OdeStepper *s, double h)
{
  return s->pair == ODE_BATHE ? AttemptBathe(s, h) : AttemptExplicit(s, h);
}

void OdeAccept(OdeStepper *s, double h)
{
  s->t += h;
  memcpy(s->y, s->y1, sizeof(s->y));
  memcpy(s->k, s->k1, sizeof(s->k));
}
