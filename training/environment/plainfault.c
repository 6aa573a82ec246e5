/* See plainfault.h. The stage solver follows src/snes/semismooth.c: Newton's method on the natural residual, without
   the weakening slope where that makes the Jacobian indefinite. */
#include "plainfault.h"
#include <slipcompat.h>
#include <math.h>

enum { memory = 5, halvings = 4, doublings = 40, max_it = 50, arrays = 16 };
#define TOLERANCE 1e-10 /* of the natural residual over the characteristic traction */
#define ROUNDING 1e-15

/* One stage: B x - c = r, |r| <= q(s0 + theta |x|) */
typedef struct {
  const PlainFault *p;
  PetscInt n;
  double theta, scale;
  double *B, *L;                                    /* [n n] */
  double *c, *s0, *x, *g, *q, *F, *slope, *dx, *xs; /* [n] */
  PetscBool *mask;                                  /* sliding */
  double merit, norm;
} Stage;

static double *Take(double **work, PetscInt n)
{
  double *a = *work;

  *work += n;
  return a;
}

/* y = A x, column by column so that the inner loop vectorises; A is symmetric, so its rows are its columns. */
static void Multiply(PetscInt n, const double A[], const double x[], double *restrict y)
{
  for (PetscInt i = 0; i < n; ++i) y[i] = 0;
  for (PetscInt j = 0; j < n; ++j) {
    const double *restrict column = A + j * n, factor = x[j];

    for (PetscInt i = 0; i < n; ++i) y[i] += column[i] * factor;
  }
}

/* Natural residual, mask and slope at x. */
static void Evaluate(Stage *st)
{
  const PlainFault *p = st->p;
  double sum = 0, worst = 0, against = 0;

  Multiply(st->n, st->B, st->x, st->g);
  for (PetscInt i = 0; i < st->n; ++i) {
    const double x = st->x[i], rho = 1 / st->B[i * st->n + i], s = st->s0[i] + st->theta * fabs(x);
    const double weak = p->drop[i] * exp(-s / p->slip[i]), dq = -weak / p->slip[i] * p->sigma[i] * st->theta;

    st->q[i] = (p->residual[i] + weak) * p->sigma[i];
    st->g[i] -= st->c[i];
    const double trial = x - rho * st->g[i], limit = rho * st->q[i];

    st->mask[i] = fabs(trial) > limit ? PETSC_TRUE : PETSC_FALSE;
    st->slope[i] = 0;
    if (!st->mask[i])
      st->F[i] = x / rho;
    else {
      const double sign = trial > 0 ? 1 : -1;

      st->F[i] = st->g[i] + sign * st->q[i];
      st->slope[i] = x * sign < 0 ? -dq : dq;
      if (x * sign < 0) against = PetscMax(against, fabs(x) / rho);
    }
    sum += st->F[i] * st->F[i];
    worst = PetscMax(worst, fabs(st->F[i]));
  }
  st->merit = sqrt(sum) / st->scale;
  st->norm = isfinite(sum) ? PetscMax(worst, against) / st->scale : (double)NAN;
}

/* Cholesky factor of A [m m] in its lower triangle, column by column so that the inner loop vectorises; false when
   indefinite. */
static PetscBool Factor(PetscInt m, double A[], double column[])
{
  for (PetscInt k = 0; k < m; ++k) {
    if (!(A[k * m + k] > 0)) return PETSC_FALSE;
    A[k * m + k] = sqrt(A[k * m + k]);
    for (PetscInt i = k + 1; i < m; ++i) column[i] = A[i * m + k] /= A[k * m + k];
    for (PetscInt i = k + 1; i < m; ++i) {
      double *restrict row = A + i * m;
      const double *restrict other = column, c = column[i];

      for (PetscInt j = k + 1; j <= i; ++j) row[j] -= c * other[j];
    }
  }
  return PETSC_TRUE;
}

/* Solve on the sliding set; false when indefinite. dx: right side in, step out. */
static PetscBool Solve(Stage *st, PetscBool with_slope, PetscInt index[], double b[])
{
  PetscInt m = 0;
  double *L = st->L;

  for (PetscInt i = 0; i < st->n; ++i)
    if (st->mask[i]) index[m++] = i;
  for (PetscInt i = 0; i < m; ++i) {
    for (PetscInt j = 0; j <= i; ++j) L[i * m + j] = st->B[index[i] * st->n + index[j]];
    if (with_slope) L[i * m + i] += st->slope[index[i]];
  }
  if (!Factor(m, L, b)) return PETSC_FALSE;
  for (PetscInt i = 0; i < m; ++i) {
    b[i] = st->dx[index[i]];
    for (PetscInt k = 0; k < i; ++k) b[i] -= L[i * m + k] * b[k];
    b[i] /= L[i * m + i];
  }
  for (PetscInt i = m - 1; i >= 0; --i) {
    b[i] /= L[i * m + i];
    for (PetscInt k = 0; k < i; ++k) b[k] -= L[i * m + k] * b[i];
  }
  for (PetscInt i = 0; i < m; ++i) st->dx[index[i]] = b[i];
  return PETSC_TRUE;
}

/* Newton step into dx, without the slope where it makes the Jacobian indefinite. */
static PetscBool Direction(Stage *st, PetscInt index[], double b[], PetscBool *picard)
{
  for (*picard = PETSC_FALSE;; *picard = PETSC_TRUE) {
    PetscBool sticking = PETSC_FALSE;

    for (PetscInt i = 0; i < st->n; ++i) {
      st->xs[i] = st->mask[i] ? 0 : st->x[i];
      if (st->xs[i] != 0) sticking = PETSC_TRUE;
    }
    if (sticking) Multiply(st->n, st->B, st->xs, st->dx);
    for (PetscInt i = 0; i < st->n; ++i) st->dx[i] = (sticking ? st->dx[i] : 0) - st->F[i];
    if (Solve(st, *picard ? PETSC_FALSE : PETSC_TRUE, index, b)) break;
    if (*picard) return PETSC_FALSE;
  }
  for (PetscInt i = 0; i < st->n; ++i)
    if (!st->mask[i]) st->dx[i] = -st->x[i];
  return PETSC_TRUE;
}

static void MoveTo(Stage *st, double lambda)
{
  for (PetscInt i = 0; i < st->n; ++i) st->x[i] = st->xs[i] + lambda * st->dx[i];
  Evaluate(st);
}

static double Push(const Stage *st)
{
  double push = 0;

  for (PetscInt i = 0; i < st->n; ++i)
    if (st->mask[i]) push += st->F[i] * st->dx[i];
  return push;
}

static void Expand(Stage *st)
{
  double push, last;

  MoveTo(st, 1);
  push = Push(st);
  for (PetscInt k = 0; k < doublings && push < 0; ++k) {
    const double lambda = ldexp(1, (int)k + 1);

    last = push;
    MoveTo(st, lambda);
    push = Push(st);
    if (push > -last) MoveTo(st, 0.5 * lambda);
  }
}

static void Search(Stage *st, const double recent[])
{
  double limit = 0, lambda = 1;

  for (PetscInt i = 0; i < memory; ++i) limit = PetscMax(limit, recent[i]);
  for (PetscInt k = 0; k <= halvings; ++k, lambda *= 0.5) {
    MoveTo(st, lambda);
    if (st->merit < (1 - 1e-4 * lambda) * limit) return;
  }
  MoveTo(st, 1);
}

/* Newton steps down to rounding; keeps the better point. */
static void Polish(Stage *st, PetscInt it, PetscInt index[], double b[])
{
  for (; st->norm > ROUNDING && it < max_it; ++it) {
    const double last = st->norm;
    double step = 0, size = 0;
    PetscBool picard;

    if (!Direction(st, index, b, &picard) || picard) return;
    memcpy(st->xs, st->x, sizeof(double) * (size_t)(st->n));
    MoveTo(st, 1);
    if (!(st->norm < last)) {
      memcpy(st->x, st->xs, sizeof(double) * (size_t)(st->n));
      Evaluate(st);
      return;
    }
    for (PetscInt i = 0; i < st->n; ++i) {
      step = PetscMax(step, fabs(st->dx[i]));
      size = PetscMax(size, fabs(st->x[i]));
    }
    if (st->norm > 0.5 * last || step <= 1e-11 * size) return;
  }
}

/* B, scale; from the guess in x to the solution. */
static PetscBool SolveStage(Stage *st, PetscInt index[], double b[])
{
  const PlainFault *p = st->p;
  const PetscInt n = st->n;
  double recent[memory], cmax = 0, qmax = 0;
  PetscInt it;

  for (PetscInt i = 0; i < n * n; ++i) st->B[i] = p->H[i] + st->theta * p->K[i];
  for (PetscInt i = 0; i < n; ++i) {
    st->B[i * n + i] += p->mass / st->theta;
    cmax = PetscMax(cmax, fabs(st->c[i]));
    st->scale = 1;
  }
  Evaluate(st);
  for (PetscInt i = 0; i < n; ++i) qmax = PetscMax(qmax, st->q[i]);
  st->scale = cmax + qmax;
  Evaluate(st);
  for (PetscInt i = 0; i < memory; ++i) recent[i] = st->merit;
  for (it = 1; !(st->norm <= TOLERANCE); ++it) {
    PetscBool picard;

    if (it > max_it || isnan(st->norm) || !Direction(st, index, b, &picard)) return PETSC_FALSE;
    memcpy(st->xs, st->x, sizeof(double) * (size_t)(n));
    if (picard) {
      Expand(st);
      for (PetscInt i = 0; i < memory; ++i) recent[i] = st->merit;
    } else
      Search(st, recent);
    recent[it % memory] = st->merit;
  }
  Polish(st, it, index, b);
  for (PetscInt i = 0; i < n; ++i) {
    const double trial = st->x[i] - st->g[i] / st->B[i * n + i];

    if (!st->mask[i] || trial * st->x[i] < 0) st->x[i] = 0;
  }
  return PETSC_TRUE;
}

/* Smooth force F_s = -H v - K u and the reaction r0 at the start of a step: the balance where an cell rests. */
static void StartForce(const PlainFault *p, double tmp[], double f[])
{
  Multiply(p->n, p->H, p->v, f);
  Multiply(p->n, p->K, p->u, tmp);
  for (PetscInt i = 0; i < p->n; ++i) {
    const double q = (p->residual[i] + p->drop[i] * exp(-p->s[i] / p->slip[i])) * p->sigma[i];
    double r;

    f[i] = -f[i] - tmp[i];
    if (p->v[i] != 0)
      r = p->v[i] > 0 ? -q : q;
    else
      r = PetscClipInterval(-f[i], -q, q);
    f[i] += r;
  }
}

PetscBool PlainFaultAttempt(PlainFault *p, double h)
{
  const double gamma = 0.5, a1 = 1 / (gamma * (2 - gamma)), a0 = (1 - gamma) * (1 - gamma) / (gamma * (2 - gamma)),
               b2 = (1 - gamma) / (2 - gamma);
  const PetscInt n = p->n;
  double *work = p->work, *v1, *u1, *s1, *tmp, *base_u;
  PetscInt index[256];
  PetscBool mask[256];
  Stage st = {.p = p, .n = n, .mask = mask};

  st.B = Take(&work, n * n);
  st.L = Take(&work, n * n);
  double **list[] = {&st.c,  &st.s0, &st.x, &st.g, &st.q, &st.F, &st.slope,
                     &st.dx, &st.xs, &v1,   &u1,   &s1,   &tmp,  &base_u};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(list); ++k) *list[k] = Take(&work, n);
  /* stage 1: trapezoidal rule to t + gamma h */
  st.theta = 0.5 * gamma * h;
  StartForce(p, tmp, st.c);
  for (PetscInt i = 0; i < n; ++i) {
    base_u[i] = p->u[i] + st.theta * p->v[i];
    st.s0[i] = p->s[i] + st.theta * fabs(p->v[i]);
    st.x[i] = p->v[i];
  }
  Multiply(n, p->K, base_u, tmp);
  for (PetscInt i = 0; i < n; ++i) st.c[i] += p->mass / st.theta * p->v[i] - tmp[i];
  if (!SolveStage(&st, index, p->work + 2 * n * n + 14 * n)) return PETSC_FALSE;
  for (PetscInt i = 0; i < n; ++i) {
    v1[i] = st.x[i];
    u1[i] = base_u[i] + st.theta * v1[i];
    s1[i] = st.s0[i] + st.theta * fabs(v1[i]);
  }
  /* stage 2: three-point backward formula to t + h */
  st.theta = b2 * h;
  for (PetscInt i = 0; i < n; ++i) {
    base_u[i] = a1 * u1[i] - a0 * p->u[i];
    st.s0[i] = a1 * s1[i] - a0 * p->s[i];
  }
  Multiply(n, p->K, base_u, tmp);
  for (PetscInt i = 0; i < n; ++i) st.c[i] = p->mass / st.theta * (a1 * v1[i] - a0 * p->v[i]) - tmp[i];
  if (!SolveStage(&st, index, p->work + 2 * n * n + 14 * n)) return PETSC_FALSE;
  p->slip_error = p->growth = 0;
  for (PetscInt i = 0; i < n; ++i) {
    const double v = st.x[i];

    p->v2[i] = v;
    p->u2[i] = base_u[i] + st.theta * v;
    p->s2[i] = st.s0[i] + st.theta * fabs(v);
    p->slip_error += fabs(h / 6 * (fabs(p->v[i]) - 2 * fabs(v1[i]) + fabs(v))); /* embedded error for gamma 1/2 */
    if (v != 0) p->growth += (v > 0 ? 1 : -1) * (v - a1 * v1[i] + a0 * p->v[i]) / (b2 * h);
  }
  return PETSC_TRUE;
}

void PlainFaultAccept(PlainFault *p)
{
  memcpy(p->v, p->v2, sizeof(double) * (size_t)(p->n));
  memcpy(p->u, p->u2, sizeof(double) * (size_t)(p->n));
  memcpy(p->s, p->s2, sizeof(double) * (size_t)(p->n));
}

void PlainFaultSetState(PlainFault *p, const double w[])
{
  for (PetscInt i = 0; i < p->n; ++i) {
    p->v[i] = w[3 * i];
    p->u[i] = w[3 * i + 1];
    p->s[i] = w[3 * i + 2];
  }
}

/* Entries of a matrix that may be known by its products only: its columns. */
static PetscErrorCode Entries(Mat A, PetscInt n, double a[])
{
  const PetscScalar *y;
  Vec unit, column;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, &unit, &column));
  for (PetscInt j = 0; j < n; ++j) {
    PetscCall(VecZeroEntries(unit));
    PetscCall(VecSetValue(unit, j, 1, INSERT_VALUES));
    PetscCall(VecAssemblyBegin(unit));
    PetscCall(VecAssemblyEnd(unit));
    PetscCall(MatMult(A, unit, column));
    PetscCall(VecGetArrayRead(column, &y));
    for (PetscInt i = 0; i < n; ++i) a[i * n + j] = (double)PetscRealPart(y[i]);
    PetscCall(VecRestoreArrayRead(column, &y));
  }
  PetscCall(VecDestroy(&unit));
  PetscCall(VecDestroy(&column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainFaultCreate(SlipFault fault, const PetscReal sigma[], const PetscReal residual[],
                                const PetscReal drop[], const PetscReal slip[], Vec start, PlainFault *p)
{
  PetscReal mass, tstar, perturbation;
  double uc = 0, q0 = 0;
  const PetscScalar *w;
  PetscInt n;
  Mat K, H;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(p, sizeof(*p)));
  PetscCall(VecGetSize(start, &n));
  p->n = n /= 3;
  PetscCall(SlipFaultGetOperators(fault, &K, &H, &mass));
  PetscCall(SlipFaultGetTimeScale(fault, &tstar));
  PetscCall(SlipFaultGetReal(fault, "initial_perturbation", &perturbation));
  p->mass = (double)mass;
  p->tstar = (double)tstar;
  PetscCall(PetscMalloc3(n * n, &p->K, n * n, &p->H, 2 * n * n + arrays * n, &p->work));
  PetscCall(PetscMalloc4(n, &p->sigma, n, &p->residual, n, &p->drop, n, &p->slip));
  PetscCall(PetscCalloc6(n, &p->v, n, &p->u, n, &p->s, n, &p->v2, n, &p->u2, n, &p->s2));
  PetscCall(Entries(K, n, p->K));
  PetscCall(Entries(H, n, p->H));
  PetscCall(VecGetArrayRead(start, &w));
  for (PetscInt i = 0; i < n; ++i) {
    const double u = -(double)PetscRealPart(w[3 * i + 1]) / (1 + (double)perturbation),
                 q = (residual[i] + drop[i]) * sigma[i];

    p->sigma[i] = (double)sigma[i];
    p->residual[i] = (double)residual[i];
    p->drop[i] = (double)drop[i];
    p->slip[i] = (double)slip[i];
    p->mean_dc += slip[i] / (double)n;
    p->mean_drop += drop[i] * sigma[i] / (double)n;
    p->critical_energy += u * q;
    uc += u / (double)n;
    q0 += q / (double)n;
  }
  PetscCall(VecRestoreArrayRead(start, &w));
  p->drop_slip = p->mean_drop / q0 * uc;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainFaultDestroy(PlainFault *p)
{
  PetscFunctionBegin;
  PetscCall(PetscFree3(p->K, p->H, p->work));
  PetscCall(PetscFree4(p->sigma, p->residual, p->drop, p->slip));
  PetscCall(PetscFree6(p->v, p->u, p->s, p->v2, p->u2, p->s2));
  PetscFunctionReturn(PETSC_SUCCESS);
}
