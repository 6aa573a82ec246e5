/* A constraint for small systems, for which the user gives arrays: forces, their dense Jacobian and the bounds of the
   reaction.

   It eliminates the rows that no reaction enters: for given constrained states x, Newton's method solves
     A_f (w_f - base_f) / theta = F_f(t, w) + explicit_f
   for the free states w_f. The constrained rows are G(x) = A_c (x - base_c) / theta - F_c(t, w) - explicit_c, and their
   Jacobian is the Schur complement of A / theta - dF/dw, symmetric for mechanical systems and reciprocal circuits. */
#include <slipstep/private/slipsnes.h>
#include <slipstep/private/slipsys.h>
#include <petscblaslapack.h>
#include <math.h>

enum { max_newton = 30 };
static const PetscReal newton_tol = 1e-13;  /* last correction over the largest state */
static const PetscReal rounding_tol = 1e-8; /* below this, a correction that no longer decreases is rounding */
static const PetscReal kick_tol = 1e-8;     /* last change of a kick's rates over the rates */
static const PetscReal symmetry_tol = 1e-10;

typedef struct {
  SlipSmall p;
  PetscReal *mass;              /* [n] */
  PetscInt *rows, *rest, nrest; /* constrained rows; free rows and their number */
  PetscReal t, theta;           /* the stage */
  PetscReal *base, *load;       /* [n] */
  PetscBool known, solved;      /* w is that of x; the elimination converged */
  PetscReal *x, *w, *F, *J;     /* [nrows], [n], [n], [n n] of the last point */
  PetscReal *start, *rates;     /* [n] F of an explicit step's start; [4 nrows] rates in a kick, q, dq and q at rest */
  PetscReal *D, *rhs;           /* free block of A / theta - dF/dw, and right-hand sides, column-major */
  PetscBLASInt *pivot;          /* [nrest] */
  Mat B;
  PetscReal *fastest; /* [n n + 2] dF/dw and the results of the last call of Frequency(); NULL before it */
} Small;

static PetscErrorCode SmallDestroy(SlipContainerArg arg)
{
  Small *s = (Small *)SlipContainerArgPointer(arg);

  PetscFunctionBegin;
  PetscCall(PetscFree3(s->mass, s->rows, s->rest));
  PetscCall(PetscFree4(s->base, s->load, s->x, s->w));
  PetscCall(PetscFree2(s->start, s->rates));
  PetscCall(PetscFree5(s->F, s->J, s->D, s->rhs, s->pivot));
  PetscCall(PetscFree(s->fastest));
  PetscCall(MatDestroy(&s->B));
  PetscCall(PetscFree(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns an entry of A / theta - dF/dw. */
static PetscReal SmallEntry(const Small *s, PetscInt i, PetscInt j)
{
  return (i == j ? s->mass[i] / s->theta : 0.0) - s->J[i * s->p.n + j];
}

static PetscErrorCode SmallJacobian(Small *s)
{
  PetscFunctionBegin;
  PetscCall(PetscArrayzero(s->J, s->p.n * s->p.n));
  PetscCall((*s->p.jacobian)(s->t, s->w, s->J, s->p.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves with the free block for the columns of rhs; singular: the free states cannot be eliminated here. */
static PetscErrorCode SmallSolveFree(Small *s, PetscInt columns, PetscBool *singular)
{
  PetscBLASInt n, m, info;

  PetscFunctionBegin;
  for (PetscInt j = 0; j < s->nrest; j++)
    for (PetscInt i = 0; i < s->nrest; i++) s->D[i + s->nrest * j] = SmallEntry(s, s->rest[i], s->rest[j]);
  PetscCall(PetscBLASIntCast(s->nrest, &n));
  PetscCall(PetscBLASIntCast(columns, &m));
  LAPACKgesv_(&n, &m, s->D, &n, s->pivot, s->rhs, &n, &info);
  PetscCheck(info >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "gesv: argument %d is wrong", (int)-info);
  *singular = info > 0 ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns A_i (w_i - base_i) / theta - F_i - explicit_i. */
static PetscReal SmallBalance(const Small *s, PetscInt i)
{
  return s->mass[i] * (s->w[i] - s->base[i]) / s->theta - s->F[i] - s->load[i];
}

/* Computes the free states and the forces for the constrained states X. */
static PetscErrorCode SmallEliminate(Small *s, Vec X)
{
  const PetscReal *x;
  PetscReal size = 0.0, state = 0.0, last = PETSC_MAX_REAL;
  PetscBool same, singular = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(X, &x));
  PetscCall(PetscArraycmp(x, s->x, s->p.nrows, &same));
  if (!same || !s->known) {
    s->known = PETSC_FALSE;
    for (PetscInt k = 0; k < s->p.nrows; k++) s->w[s->rows[k]] = s->x[k] = x[k];
  }
  PetscCall(VecRestoreArrayRead(X, &x));
  if (s->known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*s->p.force)(s->t, s->w, s->F, s->p.ctx));
  s->solved = s->nrest ? PETSC_FALSE : PETSC_TRUE;
  for (PetscInt it = 0; it < max_newton && !s->solved && !singular; it++) {
    /* a Newton correction of the free states */
    PetscCall(SmallJacobian(s));
    for (PetscInt i = 0; i < s->nrest; i++) s->rhs[i] = SmallBalance(s, s->rest[i]);
    PetscCall(SmallSolveFree(s, 1, &singular));
    size = state = 0.0;
    for (PetscInt i = 0; i < s->nrest && !singular; i++) {
      s->w[s->rest[i]] -= s->rhs[i];
      size = PetscMax(size, PetscAbsReal(s->rhs[i]));
      state = PetscMax(state, PetscAbsReal(s->w[s->rest[i]]));
      if (PetscIsInfOrNanReal(s->rhs[i])) singular = PETSC_TRUE;
    }
    PetscCall((*s->p.force)(s->t, s->w, s->F, s->p.ctx));
    if (size <= newton_tol * state || (size > 0.5 * last && size <= rounding_tol * state)) s->solved = PETSC_TRUE;
    last = size;
  }
  if (singular) s->solved = PETSC_FALSE;
  if (!s->solved)
    for (PetscInt i = 0; i < s->nrest; i++)
      s->w[s->rest[i]] = s->base[s->rest[i]]; /* a safe first guess for the next point */
  s->known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Stage(SlipConstraint con, const SlipStage *stage, void *ctx)
{
  Small *s = (Small *)ctx;
  const PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  s->t = stage->t;
  s->theta = stage->theta;
  s->known = PETSC_FALSE;
  PetscCall(VecGetArrayRead(stage->base, &a));
  PetscCall(PetscArraycpy(s->base, a, s->p.n));
  PetscCall(PetscArraycpy(s->w, a, s->p.n));
  PetscCall(VecRestoreArrayRead(stage->base, &a));
  PetscCall(PetscArrayzero(s->load, s->p.n));
  if (stage->explicit_part) {
    PetscCall(VecGetArrayRead(stage->explicit_part, &a));
    PetscCall(PetscArraycpy(s->load, a, s->p.n));
    PetscCall(VecRestoreArrayRead(stage->explicit_part, &a));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes G(x). It is NaN where the elimination fails: the solve then diverges, and a shorter step is tried. */
static PetscErrorCode Residual(SlipConstraint con, Vec x, Vec g, void *ctx)
{
  Small *s = (Small *)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  PetscCall(SmallEliminate(s, x));
  PetscCall(VecGetArrayWrite(g, &a));
  for (PetscInt k = 0; k < s->p.nrows; k++) a[k] = s->solved ? SmallBalance(s, s->rows[k]) : NAN;
  PetscCall(VecRestoreArrayWrite(g, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Jacobian(SlipConstraint con, Vec x, Mat *B, void *ctx)
{
  Small *s = (Small *)ctx;
  const PetscInt m = s->p.nrows, f = s->nrest;
  PetscBool singular = PETSC_FALSE;
  PetscReal *b, skew = 0.0, size = 0.0;

  PetscFunctionBegin;
  (void)con;
  PetscCall(SmallEliminate(s, x));
  PetscCall(SmallJacobian(s));
  for (PetscInt k = 0; k < m; k++)
    for (PetscInt i = 0; i < f; i++) s->rhs[i + f * k] = SmallEntry(s, s->rest[i], s->rows[k]);
  if (f) PetscCall(SmallSolveFree(s, m, &singular));
  PetscCall(MatDenseGetArrayWrite(s->B, &b));
  for (PetscInt k = 0; k < m; k++)
    for (PetscInt j = 0; j < m; j++) {
      if (!s->solved || singular) { /* any regular matrix will do, as the residual is NaN */
        b[j + m * k] = j == k ? s->mass[s->rows[k]] / s->theta : 0.0;
        continue;
      }
      b[j + m * k] = SmallEntry(s, s->rows[j], s->rows[k]);
      for (PetscInt i = 0; i < f; i++) b[j + m * k] -= SmallEntry(s, s->rows[j], s->rest[i]) * s->rhs[i + f * k];
    }
  for (PetscInt i = 0; i < m; i++)
    for (PetscInt j = 0; j < m; j++) {
      size = PetscMax(size, PetscAbsReal(b[i + m * j]));
      skew = PetscMax(skew, PetscAbsReal(b[i + m * j] - b[j + m * i]));
    }
  PetscCall(MatDenseRestoreArrayWrite(s->B, &b));
  /* the linear solver must know whether the Schur complement is symmetric */
  PetscCall(MatSetOption(s->B, MAT_SYMMETRIC, skew <= symmetry_tol * size ? PETSC_TRUE : PETSC_FALSE));
  *B = s->B;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes q, and dq unless it is NULL, at a state. */
static PetscErrorCode SmallBound(Small *s, PetscReal t, const PetscReal w[], Vec q, Vec dq)
{
  PetscReal *a, *d = NULL;
  const SlipArrays arrays[] = {{q, .write = &a}, {dq, .write = &d}};

  PetscFunctionBegin;
  PetscCall(SlipArraysGet(2, arrays));
  if (d) PetscCall(PetscArrayzero(d, s->p.nrows));
  PetscCall((*s->p.bound)(t, w, a, d, s->p.ctx));
  for (PetscInt k = 0; k < s->p.nrows; k++)
    PetscCheck(!(a[k] < 0.0), PETSC_COMM_SELF, PETSC_ERR_USER,
               "The bound of reaction %" PetscInt_FMT " is %g at time %g; it must not be negative", k, (double)a[k],
               (double)t);
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Bound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  Small *s = (Small *)ctx;

  PetscFunctionBegin;
  (void)con;
  PetscCall(SmallEliminate(s, x));
  PetscCall(SmallBound(s, s->t, s->w, q, dq));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode BoundState(SlipConstraint con, PetscReal t, Vec w, Vec q, void *ctx)
{
  const PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(SmallBound((Small *)ctx, t, a, q, NULL));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce(SlipConstraint con, Vec w, Vec x, void *ctx)
{
  const Small *s = (const Small *)ctx;
  const PetscReal *a;
  PetscReal *b;
  const SlipArrays arrays[] = {{w, .read = &a}, {x, .write = &b}};

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt k = 0; k < s->p.nrows; k++) b[k] = a[s->rows[k]];
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Lift(SlipConstraint con, Vec x, Vec w, void *ctx)
{
  Small *s = (Small *)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  PetscCall(SmallEliminate(s, x));
  PetscCall(VecGetArrayWrite(w, &a));
  PetscCall(PetscArraycpy(a, s->w, s->p.n));
  PetscCall(VecRestoreArrayWrite(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Smooth(SlipConstraint con, PetscReal t, Vec w, Vec Fs, void *ctx)
{
  const Small *s = (const Small *)ctx;
  const PetscReal *a;
  PetscReal *b;
  const SlipArrays arrays[] = {{w, .read = &a}, {Fs, .write = &b}};

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipArraysGet(2, arrays));
  PetscCall((*s->p.force)(t, a, b, s->p.ctx));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddReaction(SlipConstraint con, PetscReal a, Vec r, Vec F, void *ctx)
{
  const Small *s = (const Small *)ctx;
  const PetscReal *b;
  PetscReal *f;
  const SlipArrays arrays[] = {{r, .read = &b}, {F, .write = &f}};

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipArraysGet(2, arrays));
  for (PetscInt k = 0; k < s->p.nrows; k++) f[s->rows[k]] += a * b[k];
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SolveMass(SlipConstraint con, Vec F, Vec k, void *ctx)
{
  const Small *s = (const Small *)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  if (F != k) PetscCall(VecCopy(F, k));
  PetscCall(VecGetArray(k, &a));
  for (PetscInt i = 0; i < s->p.n; i++) a[i] /= s->mass[i];
  PetscCall(VecRestoreArray(k, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- explicit steps: SlipExplicitOps. They use s->w as work. ---- */

/* Computes F of the states a in s->F; unless moving, the constrained states are 0. */
static PetscErrorCode SmallForce(Small *s, PetscReal t, const PetscReal a[], PetscBool moving)
{
  PetscFunctionBegin;
  s->known = PETSC_FALSE;
  PetscCall(PetscArraycpy(s->w, a, s->p.n));
  for (PetscInt k = 0; k < s->p.nrows && !moving; k++) s->w[s->rows[k]] = 0;
  PetscCall((*s->p.force)(t, s->w, s->F, s->p.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Drive(SlipConstraint con, PetscReal t, Vec w, Vec f, void *ctx)
{
  Small *s = (Small *)ctx;
  const PetscReal *a;
  PetscReal *b;
  const SlipArrays arrays[] = {{w, .read = &a}, {f, .write = &b}};

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipArraysGet(2, arrays));
  PetscCall(SmallForce(s, t, a, PETSC_FALSE));
  for (PetscInt k = 0; k < s->p.nrows; k++) b[k] = s->F[s->rows[k]];
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the part of the force on the constrained states that depends on them. F stays in s->F for the next drift. */
static PetscErrorCode Damping(SlipConstraint con, PetscReal t, Vec w, Vec p, void *ctx)
{
  Small *s = (Small *)ctx;
  const PetscReal *a;
  PetscReal *b;
  const SlipArrays arrays[] = {{w, .read = &a}, {p, .write = &b}};

  PetscFunctionBegin;
  (void)con;
  PetscCall(SlipArraysGet(2, arrays));
  PetscCall(SmallForce(s, t, a, PETSC_FALSE));
  for (PetscInt k = 0; k < s->p.nrows; k++) b[k] = s->F[s->rows[k]];
  PetscCall(SmallForce(s, t, a, PETSC_TRUE));
  for (PetscInt k = 0; k < s->p.nrows; k++) b[k] -= s->F[s->rows[k]];
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves m/a (x - base) = g - q sign(x) for x at the states in s->w, which it changes: by Newton's method, or, where q
   decreases faster with |x| than momentum increases, by iteration without dq. *depends: q depends on |x|, which its
   derivative at rest need not show (q0 + q1 exp(-(x/v)^2), or a strength that drops at any motion). *ok becomes
   PETSC_FALSE where no x was found, and does not change otherwise. */
static PetscErrorCode SmallKick(Small *s, PetscReal t, PetscReal a, const PetscReal g[], const PetscReal base[],
                                PetscReal x[], PetscBool *depends, PetscBool *ok)
{
  PetscReal *q = s->rates + s->p.nrows, *dq = q + s->p.nrows, *rest = dq + s->p.nrows, change = 1;

  PetscFunctionBegin;
  *depends = PETSC_FALSE;
  for (PetscInt k = 0; k < s->p.nrows; k++) s->w[s->rows[k]] = x[k] = 0;
  for (PetscInt it = 0; it < max_newton && change > newton_tol; it++) {
    change = 0;
    PetscCall(PetscArrayzero(dq, s->p.nrows));
    PetscCall((*s->p.bound)(t, s->w, q, dq, s->p.ctx));
    if (it == 0) PetscCall(PetscArraycpy(rest, q, s->p.nrows));
    for (PetscInt k = 0; k < s->p.nrows; k++) {
      const PetscReal D = s->mass[s->rows[k]] / a, load = g[k] + D * base[k], size = PetscAbsReal(load);
      const PetscReal slope = D + dq[k] > 0 ? dq[k] : 0, last = PetscAbsReal(x[k]);
      const PetscReal now = PetscMax(size - q[k] + slope * last, 0) / (D + slope);

      if (dq[k] != 0 || q[k] != rest[k]) *depends = PETSC_TRUE;
      if (it > 0 && x[k] == 0) continue; /* it sticks */
      x[k] = load < 0 && now > 0 ? -now : now;
      if (now != last) change = PetscMax(change, PetscAbsReal(now - last) / PetscMax(now, PETSC_SMALL));
      s->w[s->rows[k]] = x[k];
    }
  }
  if (change > kick_tol) *ok = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Kicks the rates: exactly if the bound does not depend on them, else as for a fault (Alexander's second formula). */
static PetscErrorCode Kick(SlipConstraint con, PetscReal t, PetscReal a, Vec g, Vec w, PetscBool *ok, void *ctx)
{
  Small *s = (Small *)ctx;
  const PetscReal *push;
  PetscReal *b;
  PetscBool depends;
  SlipBathe c;
  const SlipArrays arrays[] = {{g, .read = &push}, {w, .write = &b}};

  PetscFunctionBegin;
  (void)con;
  s->known = PETSC_FALSE;
  SlipBatheSetUpBackward(&c);
  PetscCall(SlipArraysGet(2, arrays));
  PetscCall(PetscArraycpy(s->w, b, s->p.n));
  for (PetscInt k = 0; k < s->p.nrows; k++) s->rates[k] = b[s->rows[k]];
  PetscCall(SmallKick(s, t, a, push, s->rates, s->x, &depends, ok));
  for (PetscInt k = 0; k < s->p.nrows && !depends; k++)
    s->x[k] = SlipKickConstant(s->mass[s->rows[k]], 0, a, push[k], s->rates[s->p.nrows + k], s->rates[k]);
  if (depends) {
    PetscCall(SmallKick(s, t, c.theta[0] * a, push, s->rates, s->x, &depends, ok));
    for (PetscInt k = 0; k < s->p.nrows; k++) s->rates[k] = s->x[k] + c.a0 * (s->x[k] - s->rates[k]);
    PetscCall(SmallKick(s, t, c.theta[1] * a, push, s->rates, s->x, &depends, ok));
  }
  for (PetscInt k = 0; k < s->p.nrows; k++) b[s->rows[k]] = s->x[k];
  PetscCall(SlipArraysRestore(2, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Drifts by the explicit midpoint rule: an Euler step inside, then the whole step with Damping()'s force. */
static PetscErrorCode Drift(SlipConstraint con, SlipNode from, PetscReal t, PetscReal h, Vec w, void *ctx)
{
  Small *s = (Small *)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)con;
  if (!s->nrest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(w, &a));
  if (from == SLIP_NODE_START) {
    PetscCall(SmallForce(s, t, a, PETSC_TRUE));
    PetscCall(PetscArraycpy(s->start, s->F, s->p.n));
  }
  for (PetscInt j = 0; j < s->nrest; j++) {
    const PetscInt i = s->rest[j];

    a[i] += h / s->mass[i] * (from == SLIP_NODE_START ? s->F[i] : 2 * s->F[i] - s->start[i]);
  }
  PetscCall(VecRestoreArray(w, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest frequency. Eigenvalues cost more than a step, and forces are often linear: those of the last call
   are cached while dF/dw is the same. */
static PetscErrorCode Frequency(SlipConstraint con, PetscReal t, Vec w, PetscReal *omega, PetscReal *ratio, void *ctx)
{
  Small *s = (Small *)ctx;
  const PetscInt entries = s->p.n * s->p.n;
  PetscBool same = s->fastest ? PETSC_TRUE : PETSC_FALSE;
  PetscBLASInt n, size, one = 1, info;
  const PetscReal *a;
  PetscReal *re, *im, *work, none;

  PetscFunctionBegin;
  (void)con;
  s->known = PETSC_FALSE;
  s->t = t;
  PetscCall(VecGetArrayRead(w, &a));
  PetscCall(PetscArraycpy(s->w, a, s->p.n));
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCall(SmallJacobian(s));
  if (!s->fastest) PetscCall(PetscMalloc1(entries + 2, &s->fastest));
  if (same) PetscCall(PetscArraycmp(s->J, s->fastest, entries, &same));
  if (!same) {
    PetscCall(PetscArraycpy(s->fastest, s->J, entries));
    s->fastest[entries] = s->fastest[entries + 1] = 0;
    for (PetscInt i = 0; i < s->p.n; i++)
      for (PetscInt j = 0; j < s->p.n; j++) s->J[i * s->p.n + j] /= s->mass[i];
    PetscCall(PetscBLASIntCast(s->p.n, &n));
    PetscCall(PetscBLASIntCast(4 * s->p.n, &size));
    PetscCall(PetscMalloc3(s->p.n, &re, s->p.n, &im, 4 * s->p.n, &work));
    LAPACKgeev_("N", "N", &n, s->J, &n, re, im, &none, &one, &none, &one, work, &size, &info);
    for (PetscInt i = 0; i < s->p.n && !info; i++) {
      s->fastest[entries] = PetscMax(s->fastest[entries], hypot(re[i], im[i]));
      s->fastest[entries + 1] = PetscMax(s->fastest[entries + 1], -re[i]);
    }
    if (s->fastest[entries] > 0) s->fastest[entries + 1] /= s->fastest[entries];
    PetscCall(PetscFree3(re, im, work));
  }
  *omega = s->fastest[entries];
  *ratio = s->fastest[entries + 1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipExplicitOps SmallExplicitOps = {Drive, Damping, Kick, Drift, NULL, Frequency, NULL, PETSC_TRUE};

static PetscErrorCode SmallCheck(const SlipSmall *p)
{
  PetscFunctionBegin;
  PetscCheck(p->n >= 1, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "SlipSmall has n = %" PetscInt_FMT " states", p->n);
  PetscCheck(p->nrows >= 1 && p->nrows <= p->n, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "SlipSmall has nrows = %" PetscInt_FMT " constrained rows, expected 1 to n = %" PetscInt_FMT, p->nrows,
             p->n);
  PetscCheck(p->mass && p->rows && p->force && p->jacobian && p->bound, PETSC_COMM_SELF, PETSC_ERR_ARG_NULL,
             "SlipSmall must supply mass, rows, force, jacobian and bound");
  for (PetscInt i = 0; i < p->n; i++)
    PetscCheck(p->mass[i] > 0.0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "mass[%" PetscInt_FMT "] of SlipSmall is %g, expected a number > 0", i, (double)p->mass[i]);
  for (PetscInt k = 0; k < p->nrows; k++)
    PetscCheck(p->rows[k] >= 0 && p->rows[k] < p->n && (!k || p->rows[k] > p->rows[k - 1]), PETSC_COMM_SELF,
               PETSC_ERR_ARG_OUTOFRANGE,
               "rows[%" PetscInt_FMT "] of SlipSmall is %" PetscInt_FMT
               ", expected ascending rows below n = %" PetscInt_FMT,
               k, p->rows[k], p->n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@C
  SlipConstraintCreateSmall - creates the constraint of a small dense system A dw/dt = F_s(t, w) + F_r from arrays

  Not collective (one process)

  Input Parameter:
. problem - states, masses, constrained rows and functions of the system; arrays are copied, its ctx is borrowed

  Output Parameter:
. con - the constraint, on PETSC_COMM_SELF

  Level: beginner

  Notes:
  The reduced unknowns are the constrained states in the order of rows; the constraint eliminates the others, by
  Newton's method if F_s is nonlinear. A stage whose elimination fails has not converged, and its step is tried again.

  It is for systems of up to a few hundred states, because every evaluation factors a dense matrix.

  Errors: PETSC_ERR_ARG_OUTOFRANGE for a mass that is not positive or rows that do not ascend; PETSC_ERR_USER later,
  when a bound is negative.

.seealso: SlipSmallConfigureTS(), SlipConstraintCreate(), TSBatheSetConstraint()
@*/
PetscErrorCode SlipConstraintCreateSmall(const SlipSmall *problem, SlipConstraint *con)
{
  const SlipConstraintOps ops = {Stage,       Residual,          Jacobian,   Bound, Reduce, Lift, Smooth,
                                 AddReaction, SolveMass,         BoundState, NULL,  NULL,   NULL, NULL,
                                 NULL,        &SmallExplicitOps, PETSC_FALSE};
  PetscInt n, m, f;
  Small *s;
  Vec x;

  PetscFunctionBegin;
  PetscAssertPointer(problem, 1);
  PetscAssertPointer(con, 2);
  PetscCall(SmallCheck(problem));
  n = problem->n, m = problem->nrows, f = n - m;
  PetscCall(PetscNew(&s));
  s->p = *problem;
  PetscCall(PetscMalloc3(n, &s->mass, m, &s->rows, f, &s->rest));
  PetscCall(PetscCalloc4(n, &s->base, n, &s->load, m, &s->x, n, &s->w));
  PetscCall(PetscMalloc2(n, &s->start, 4 * m, &s->rates));
  PetscCall(PetscMalloc5(n, &s->F, n * n, &s->J, f * f, &s->D, f * m, &s->rhs, f, &s->pivot));
  PetscCall(PetscArraycpy(s->mass, problem->mass, n));
  PetscCall(PetscArraycpy(s->rows, problem->rows, m));
  for (PetscInt i = 0, k = 0; i < n; i++) {
    if (k < m && s->rows[k] == i)
      k++;
    else
      s->rest[s->nrest++] = i;
  }
  PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, m, m, NULL, &s->B));
  PetscCall(MatAssemblyBegin(s->B, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->B, MAT_FINAL_ASSEMBLY));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, m, &x));
  PetscCall(SlipConstraintCreate(PETSC_COMM_SELF, &ops, s, x, con));
  (*con)->single = PETSC_TRUE;
  PetscCall(VecDestroy(&x));
  PetscCall(SlipObjectComposeData((PetscObject)*con, "SlipSmall", s, SmallDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}
