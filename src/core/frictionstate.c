/* States that a friction law declares: their values at the end of an implicit stage, and when steady slip is unstable.
   All are pure functions of a law's rates and their derivatives, for any number of states. */
#include <slipcompat.h>
#include <slipstep/rooms/slipcore.h>

/* A step of Newton's method after which the error, of the order of its square, is below rounding */
#define NEWTON_ENOUGH 1e-9

/* Range of frequencies, over the relaxation rates, in which instabilities are searched, and the ratio of successive
   ones; that of a law with one state is sqrt(b/a - 1) */
#define FREQUENCY_RANGE 1e4
#define FREQUENCY_STEP 1.5

enum { STATE_MAX_IT = 300, HALVINGS = 60, ENTRIES = SLIP_MAX_STATES * SLIP_MAX_STATES };

/* ds/dt and its derivatives */
static void Rates(const SlipFrictionLaw *law, const SlipFriction *p, const PetscReal s[], PetscReal v, PetscReal f[],
                  PetscReal f_s[], PetscReal f_v[])
{
  for (PetscInt k = 0; k < law->nstates * law->nstates; k++) f_s[k] = 0;
  law->rate(p, s, v, f, f_s, f_v);
}

static void Swap(PetscReal *a, PetscReal *b)
{
  const PetscReal c = *a;

  *a = *b;
  *b = c;
}

/* x = A^-1 x by Gaussian elimination with pivoting; A [n][n] is overwritten */
static void Solve(PetscInt n, PetscReal A[], PetscReal x[])
{
  for (PetscInt k = 0; k < n; k++) {
    PetscInt pivot = k;

    for (PetscInt i = k + 1; i < n; i++)
      if (PetscAbsReal(A[n * i + k]) > PetscAbsReal(A[n * pivot + k])) pivot = i;
    for (PetscInt j = k; j < n && pivot != k; j++) Swap(&A[n * k + j], &A[n * pivot + j]);
    if (pivot != k) Swap(&x[k], &x[pivot]);
    for (PetscInt i = k + 1; i < n; i++) {
      const PetscReal factor = A[n * i + k] / A[n * k + k];

      for (PetscInt j = k; j < n; j++) A[n * i + j] -= factor * A[n * k + j];
      x[i] -= factor * x[k];
    }
  }
  for (PetscInt k = n - 1; k >= 0; k--) {
    for (PetscInt j = k + 1; j < n; j++) x[k] -= A[n * k + j] * x[j];
    x[k] /= A[n * k + k];
  }
}

/* ---- the end of an implicit stage ---- */

/* The root of s - s0 - theta ds/dt(s), which grows with s, by Newton's method; ds: its derivative with respect to the
   rate. It lies between s0 and the steady state of the rate. Bisection replaces a step that leaves the bracket, one
   after the residual has grown, and every eighth (far from the root, where an exponential dominates, Newton's steps
   have the length 1). */
static PetscReal AdvanceOne(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, PetscReal s0,
                            PetscReal rate, PetscReal *ds)
{
  PetscReal s = s0, steady, low, high, before = PETSC_MAX_REAL, f, f_s, f_v;

  law->steady(p, rate, &steady);
  low = PetscMin(s0, steady);
  high = PetscMax(s0, steady);
  for (int it = 0; it < STATE_MAX_IT; it++) {
    PetscReal g, next;
    PetscBool enough;

    law->rate(p, &s, rate, &f, &f_s, &f_v);
    g = s - s0 - theta * f;
    if (PetscAbsReal(g) <= PETSC_MACHINE_EPSILON * (PetscAbsReal(s) + PetscAbsReal(s0))) break;
    if (g > 0)
      high = PetscMin(high, s);
    else
      low = PetscMax(low, s);
    next = s - g / (1 - theta * f_s);
    enough = PetscAbsReal(next - s) <= NEWTON_ENOUGH * PetscMax(PetscAbsReal(s), 1) ? PETSC_TRUE : PETSC_FALSE;
    if (!enough && low > -PETSC_MAX_REAL && high < PETSC_MAX_REAL &&
        (!(next < high && next > low) || PetscAbsReal(g) > before || it % 8 == 7))
      next = 0.5 * (low + high);
    before = PetscAbsReal(g);
    s = next;
    if (enough) break;
  }
  law->rate(p, &s, rate, &f, &f_s, &f_v);
  *ds = theta * f_v / (1 - theta * f_s);
  return s;
}

/* g = s - s0 - theta ds/dt(s), and the largest of its entries */
static PetscReal Residual(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, const PetscReal s0[],
                          PetscReal rate, const PetscReal s[], PetscReal g[], PetscReal f_s[], PetscReal f_v[])
{
  PetscReal largest = 0;

  Rates(law, p, s, rate, g, f_s, f_v);
  for (PetscInt k = 0; k < law->nstates; k++) {
    g[k] = s[k] - s0[k] - theta * g[k];
    if (!(PetscAbsReal(g[k]) <= largest)) largest = PetscAbsReal(g[k]); /* also if it is NaN */
  }
  return largest;
}

/* A = 1 - theta df/ds */
static void NewtonMatrix(PetscInt n, PetscReal theta, const PetscReal f_s[], PetscReal A[])
{
  for (PetscInt k = 0; k < n * n; k++) A[k] = (k % (n + 1) == 0 ? 1 : 0) - theta * f_s[k];
}

/* The root of several states, by Newton's method from s0 or the steady states, whichever has the smaller residual:
   short stages end near the former, long ones near the latter. A step is halved until it lowers the residual. */
static void AdvanceAll(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, const PetscReal s0[],
                       PetscReal rate, PetscReal s[], PetscReal ds[])
{
  const PetscInt n = law->nstates;
  PetscReal g[SLIP_MAX_STATES], f_s[ENTRIES], f_v[SLIP_MAX_STATES], A[ENTRIES], next[SLIP_MAX_STATES], size, other;

  law->steady(p, rate, next);
  other = Residual(law, p, theta, s0, rate, next, g, f_s, f_v);
  size = Residual(law, p, theta, s0, rate, s0, g, f_s, f_v);
  for (PetscInt k = 0; k < n; k++) s[k] = other < size ? next[k] : s0[k];
  for (int it = 0; it < STATE_MAX_IT; it++) {
    PetscReal share = 1, step[SLIP_MAX_STATES];
    PetscBool enough = PETSC_TRUE;

    size = Residual(law, p, theta, s0, rate, s, g, f_s, f_v);
    NewtonMatrix(n, theta, f_s, A);
    for (PetscInt k = 0; k < n; k++) step[k] = -g[k];
    Solve(n, A, step);
    for (PetscInt k = 0; k < n; k++)
      if (!(PetscAbsReal(step[k]) <= NEWTON_ENOUGH * PetscMax(PetscAbsReal(s[k]), 1))) enough = PETSC_FALSE;
    for (int half = 0; half < HALVINGS; half++, share *= 0.5) {
      for (PetscInt k = 0; k < n; k++) next[k] = s[k] + share * step[k];
      if (enough || Residual(law, p, theta, s0, rate, next, g, f_s, f_v) < size) break;
    }
    for (PetscInt k = 0; k < n; k++) s[k] = next[k];
    if (enough || size == 0) break;
  }
  Rates(law, p, s, rate, g, f_s, f_v);
  NewtonMatrix(n, theta, f_s, A);
  for (PetscInt k = 0; k < n; k++) ds[k] = theta * f_v[k];
  Solve(n, A, ds);
}

/* Computes the states at the end of a stage that is implicit with theta [s], s = s0 + theta ds/dt, with the rate there,
   and their derivatives with respect to it. */
void SlipFrictionAdvanceOwn(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal theta, const PetscReal s0[],
                            PetscReal rate, PetscReal s[], PetscReal ds[])
{
  if (law->nstates == 1)
    *s = AdvanceOne(law, p, theta, *s0, rate, ds);
  else
    AdvanceAll(law, p, theta, s0, rate, s, ds);
}

/* ---- instability of steady slip ---- */

/* Steady slip is disturbed by exp(i w t), with s' = f(s, v). The response of stress to slip, over the normal stress, is
   -k + i w d, with d = mu_v - mu_s f_s y, k = -w^2 mu_s y and y = (w^2 + f_s^2)^-1 f_v, because (i w - f_s)^-1 = -(i w
   + f_s)(w^2 + f_s^2)^-1. With a spring of the stiffness k sigma it continues for ever where d is 0. */
typedef struct {
  PetscInt n;
  PetscReal mu_v, mu_s[SLIP_MAX_STATES], f_s[ENTRIES], f_v[SLIP_MAX_STATES];
} Steady;

/* Computes d and k */
static PetscReal Damping(const Steady *c, PetscReal w, PetscReal *k)
{
  const PetscInt n = c->n;
  PetscReal A[ENTRIES], y[SLIP_MAX_STATES], d = c->mu_v;

  for (PetscInt i = 0; i < n; i++) {
    y[i] = c->f_v[i];
    for (PetscInt j = 0; j < n; j++) {
      A[n * i + j] = i == j ? w * w : 0;
      for (PetscInt l = 0; l < n; l++) A[n * i + j] += c->f_s[n * i + l] * c->f_s[n * l + j];
    }
  }
  Solve(n, A, y);
  *k = 0;
  for (PetscInt i = 0; i < n; i++) {
    *k -= w * w * c->mu_s[i] * y[i];
    for (PetscInt j = 0; j < n; j++) d -= c->mu_s[i] * c->f_s[n * i + j] * y[j];
  }
  return d;
}

/* The largest k of the frequencies at which d is 0; 0: there are none */
static PetscReal Largest(const Steady *c)
{
  PetscReal low = PETSC_MAX_REAL, high = 0, k, most = 0, last;

  for (PetscInt i = 0; i < c->n; i++) {
    low = PetscMin(low, PetscAbsReal(c->f_s[(c->n + 1) * i]));
    high = PetscMax(high, PetscAbsReal(c->f_s[(c->n + 1) * i]));
  }
  if (!(low > 0)) return 0;
  last = Damping(c, low / FREQUENCY_RANGE, &k);
  for (PetscReal w = low / FREQUENCY_RANGE; w < high * FREQUENCY_RANGE; w *= FREQUENCY_STEP) {
    const PetscReal next = Damping(c, w * FREQUENCY_STEP, &k);
    PetscReal a = w, b = w * FREQUENCY_STEP;

    while ((last < 0) != (next < 0) && b - a > 4 * PETSC_MACHINE_EPSILON * b) {
      const PetscReal x = 0.5 * (a + b);

      *((Damping(c, x, &k) < 0) == (last < 0) ? &a : &b) = x;
    }
    if ((last < 0) != (next < 0)) most = PetscMax(most, k);
    last = next;
  }
  return most;
}

/* SlipFrictionWeakening() from a law's functions. With one state x' = f(x, v) the results are -mu_x f_v and mu_v f_x -
   mu_x f_v. With two of Ruina's, d is 0 where a = sum b_k/(1 + (d_k w/v)^2) (Gu et al. 1984). With a rate of
   ruptures the fall is that after a step from v to it: of strong_rate_weakening from the peak to steady friction. */
void SlipFrictionInstability(const SlipFrictionLaw *law, const SlipFriction *p, PetscReal v, PetscReal *fall,
                             PetscReal *critical)
{
  Steady c = {.n = law->nstates};
  PetscReal s[SLIP_MAX_STATES], mu, rate[SLIP_MAX_STATES];

  law->steady(p, v, s);
  law->eval(p, s, v, &mu, c.mu_s, &c.mu_v);
  Rates(law, p, s, v, rate, c.f_s, c.f_v);
  *fall = 0;
  for (PetscInt k = 0; k < c.n; k++) *fall -= c.mu_s[k] * c.f_v[k];
  *critical = c.n == 1 ? c.mu_v * *c.f_s - *c.mu_s * *c.f_v : Largest(&c);
  if (!law->rupture) return;
  law->eval(p, s, law->rupture(p), &mu, c.mu_s, &c.mu_v);
  Rates(law, p, s, law->rupture(p), rate, c.f_s, c.f_v);
  *fall = 0;
  for (PetscInt k = 0; k < c.n; k++) *fall -= c.mu_s[k] * rate[k] / law->rupture(p);
}
