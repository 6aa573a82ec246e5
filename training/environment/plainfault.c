/* See plainfault.h. The stage solver is src/snes/semismooth.c's: Newton's method on the natural residual, without the
   weakening slope where that makes the Jacobian indefinite.

   Why there are two. Measured on 24 single cells and 20 meshes of up to 7 x 7 cells, a generation of fault.h5's
   training, runs of TSBATHE with SNESSEMISMOOTH take 12 to 14 times the processor time of these on single cells and 3.8
   to 4.9 times on meshes, 5 times in all: objects, checks and monitors cost more than the arithmetic of so few cells.
   And the library's loop cannot be this one: its operators are products with FFTs or hierarchical matrices, on any
   number of ranks, with Krylov solves and approximations; here they are entries, solved directly. Shared are the
   formulas and every decision. */
#include "plainfault.h"
#include <slipcompat.h>
#include <math.h>

#define GAMMA 0.5
enum { arrays = 19 };

/* One stage: B x - c = r, |r| <= q(s(s0, theta, |x|)) */
typedef struct {
  const PlainFault *p;
  PetscInt n, *index; /* index: of the sliding cells */
  double theta, scale;
  double *B, *L;                                                   /* [n n] */
  double *c, *s0, *x, *g, *q, *dq, *F, *slope, *dx, *xs, *rho, *b; /* [n]; rho is 1/diag(B), b work */
  double *mask;                                                    /* 1 where sliding */
  double *x1, *g1, *rho1;                                          /* of projection steps */
  double merit, norm;
  SlipSearch search;
  PetscBool picard; /* the last step left out the slope */
} Stage;

static double *Take(double **work, PetscInt n)
{
  double *a = *work;

  *work += n;
  return a;
}

void PlainMultiply(PetscInt n, const double A[], const double x[], double *restrict y)
{
  for (PetscInt i = 0; i < n; ++i) y[i] = 0;
  for (PetscInt j = 0; j < n; ++j) {
    const double *restrict column = A + j * n, factor = x[j];

    for (PetscInt i = 0; i < n; ++i) y[i] += column[i] * factor;
  }
}

/* g = B y - c */
static void Residual(const Stage *st, const double y[], double g[])
{
  PlainMultiply(st->n, st->B, y, g);
  for (PetscInt i = 0; i < st->n; ++i) g[i] -= st->c[i];
}

/* Natural residual, mask and slope at x. */
static void Evaluate(Stage *st)
{
  const SlipFrictionCells *f = &st->p->friction;
  double sum = 0, worst = 0;

  Residual(st, st->x, st->g);
  for (PetscInt i = 0; i < st->n; ++i) {
    PetscReal mu, dmu_ds, dmu_dv, ds_dv; /* laws of one state */

    /* SlipFrictionStrength() but for the order of the factors, on whose last bit the costs of CMA-ES, with their jumps
       where cells come to rest, depend */
    SlipFrictionStage(f, i, st->theta, &st->s0[i], st->x[i], &mu, &dmu_ds, &dmu_dv, &ds_dv);
    st->q[i] = mu * f->stress[i];
    st->dq[i] = dmu_ds * f->stress[i] * ds_dv + dmu_dv * f->stress[i];
  }
  SlipConeNatural(st->n, 1, st->x, st->g, st->q, st->dq, st->rho, st->F, st->mask, st->slope);
  for (PetscInt i = 0; i < st->n; ++i) {
    sum += st->F[i] * st->F[i];
    worst = PetscMax(worst, fabs(st->F[i]));
  }
  st->merit = sqrt(sum) / st->scale;
  st->norm = isfinite(sum) ? worst / st->scale : (double)NAN;
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
static PetscBool Solve(Stage *st)
{
  PetscInt m = 0, *index = st->index;
  double *L = st->L, *b = st->b;

  for (PetscInt i = 0; i < st->n; ++i)
    if (st->mask[i] != 0) index[m++] = i;
  for (PetscInt i = 0; i < m; ++i) {
    for (PetscInt j = 0; j <= i; ++j) L[i * m + j] = st->B[index[i] * st->n + index[j]];
    if (!st->picard) L[i * m + i] += st->slope[index[i]];
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

/* Newton step into dx, without the slope where it makes the Jacobian indefinite; keeps x in xs. */
static PetscBool Direction(Stage *st)
{
  for (st->picard = PETSC_FALSE;; st->picard = PETSC_TRUE) {
    PetscBool sticking = PETSC_FALSE;

    for (PetscInt i = 0; i < st->n; ++i) {
      st->xs[i] = st->mask[i] != 0 ? 0 : st->x[i];
      if (st->xs[i] != 0) sticking = PETSC_TRUE;
    }
    if (sticking) PlainMultiply(st->n, st->B, st->xs, st->dx);
    for (PetscInt i = 0; i < st->n; ++i) st->dx[i] = (sticking ? st->dx[i] : 0) - st->F[i];
    if (Solve(st)) break;
    if (st->picard) return PETSC_FALSE;
  }
  for (PetscInt i = 0; i < st->n; ++i) {
    if (st->mask[i] == 0) st->dx[i] = -st->x[i];
    st->xs[i] = st->x[i];
  }
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
    if (st->mask[i] != 0) push += st->F[i] * st->dx[i];
  return push;
}

static void Expand(Stage *st)
{
  double push, last;

  MoveTo(st, 1);
  push = Push(st);
  for (PetscInt k = 0; k < SLIP_SEARCH_DOUBLINGS && push < 0; ++k) {
    const double lambda = ldexp(1, (int)k + 1);

    last = push;
    MoveTo(st, lambda);
    push = Push(st);
    if (SlipSearchOvershoots(last, push)) MoveTo(st, 0.5 * lambda);
  }
}

/* The full step, the one that turns no cell round, or a shorter one; whether none helped */
static PetscBool Search(Stage *st)
{
  const double last = st->merit;
  double lambda = 1;

  for (PetscInt k = 0; k <= SLIP_SEARCH_HALVINGS; ++k, lambda *= 0.5) {
    MoveTo(st, lambda);
    if (k == 0 && !SlipSearchSuffices(last, st->merit)) {
      const double full = st->merit;

      if (SlipConeStopTurning(st->n, st->q, st->xs, st->x)) {
        Evaluate(st);
        if (!(st->merit < full)) MoveTo(st, 1);
      }
    }
    if (SlipSearchAccepts(&st->search, lambda, st->merit)) return PETSC_FALSE;
  }
  MoveTo(st, 1);
  return PETSC_TRUE;
}

/* Projection steps against cycling sliding sets */
static void Project(Stage *st)
{
  memcpy(st->rho1, st->rho, sizeof(double) * (size_t)st->n);
  for (PetscInt k = 0; k < SLIP_SEARCH_PROJECTIONS; ++k) {
    PetscReal factor;
    PetscBool again = PETSC_TRUE;

    for (PetscInt trial = 0; again; ++trial) {
      PetscReal sum[2] = {0, 0};

      SlipConeProject(st->n, 1, st->x, st->g, st->q, st->rho1, st->x1);
      Residual(st, st->x1, st->g1);
      SlipConeChanges(st->n, st->x, st->x1, st->g, st->g1, st->rho1, sum);
      again = SlipConeAdaptStep(trial, sum, &factor);
      for (PetscInt i = 0; i < st->n; ++i) st->rho1[i] *= factor;
    }
    memcpy(st->x, st->x1, sizeof(double) * (size_t)st->n);
    Evaluate(st);
  }
  st->search.stalls = 0;
  SlipSearchForget(&st->search, st->merit);
}

/* Newton steps down to rounding; keeps the better point. */
static void Polish(Stage *st, PetscInt it)
{
  for (; st->norm > SLIP_SEARCH_ROUNDING && it <= SLIP_SEARCH_MAX_IT; ++it) {
    const double last = st->norm;
    double step = 0, size = 0;

    if (!Direction(st) || st->picard) return;
    MoveTo(st, 1);
    if (!(st->norm < last)) {
      memcpy(st->x, st->xs, sizeof(double) * (size_t)st->n);
      Evaluate(st);
      return;
    }
    for (PetscInt i = 0; i < st->n; ++i) {
      step = PetscMax(step, fabs(st->dx[i]));
      size = PetscMax(size, fabs(st->x[i]));
    }
    if (SlipSearchPolished(last, st->norm, step, size)) return;
  }
}

/* B, scale; from the guess in x to the solution, its reaction in g. */
static PetscBool SolveStage(Stage *st)
{
  const PlainFault *p = st->p;
  const PetscInt n = st->n;
  double cmax = 0, qmax = 0;
  PetscInt it;

  for (PetscInt i = 0; i < n * n; ++i) st->B[i] = p->H[i] + st->theta * p->K[i];
  for (PetscInt i = 0; i < n; ++i) {
    st->B[i * n + i] += p->mass / st->theta;
    st->rho[i] = 1 / st->B[i * n + i];
    cmax = PetscMax(cmax, fabs(st->c[i]));
  }
  st->scale = 1;
  Evaluate(st);
  for (PetscInt i = 0; i < n; ++i) qmax = PetscMax(qmax, st->q[i]);
  st->scale = cmax + qmax > 0 ? cmax + qmax : 1;
  st->merit /= st->scale;
  st->norm /= st->scale;
  SlipSearchForget(&st->search, st->merit);
  st->search.stalls = 0;
  for (it = 1; !(st->norm <= SLIP_SEARCH_RTOL); ++it) {
    PetscBool stalled = PETSC_FALSE;

    if (it > SLIP_SEARCH_MAX_IT || isnan(st->norm) || !Direction(st)) return PETSC_FALSE;
    if (st->picard) {
      Expand(st);
      SlipSearchForget(&st->search, st->merit);
    } else
      stalled = Search(st);
    SlipSearchRemember(&st->search, it, st->merit);
    if (st->norm > SLIP_SEARCH_RTOL && SlipSearchStuck(&st->search, stalled, st->merit)) Project(st);
  }
  Polish(st, it);
  SlipConeFinish(n, 1, st->g, st->q, st->rho, st->x, st->F);
  return PETSC_TRUE;
}

PetscBool PlainFaultAttempt(PlainFault *p, double h)
{
  const PetscInt n = p->n;
  double *work = p->work, *v1 = p->w1, *u1 = v1 + n, *s1 = u1 + n, *tmp, *base_u, *ds;
  const SlipBathe c = p->bathe;
  Stage st = {.p = p, .n = n, .index = p->index};

  p->end.known = PETSC_FALSE;
  st.B = Take(&work, n * n);
  st.L = Take(&work, n * n);
  double **list[arrays] = {&st.c,   &st.s0, &st.x,    &st.g,  &st.q,  &st.dq,   &st.F, &st.slope, &st.dx, &st.xs,
                           &st.rho, &st.b,  &st.mask, &st.x1, &st.g1, &st.rho1, &tmp,  &base_u,   &ds};

  for (size_t k = 0; k < arrays; ++k) *list[k] = Take(&work, n);
  /* stage 1: trapezoidal rule to t + gamma h */
  st.theta = c.theta[0] * h;
  PlainMultiply(n, p->H, p->v, st.c);
  PlainMultiply(n, p->K, p->u, tmp);
  SlipFrictionStrength(&p->friction, n, 0, 1, p->s, 1, p->v, st.q, NULL);
  for (PetscInt i = 0; i < n; ++i) { /* the reaction is the balance where a cell rests */
    st.c[i] = -st.c[i] - tmp[i];
    st.c[i] += SlipConeReaction(1, p->v[i], -st.c[i], st.q[i]);
  }
  SlipFrictionStateRate(&p->friction, n, 1, p->s, 1, p->v, ds);
  for (PetscInt i = 0; i < n; ++i) {
    base_u[i] = p->u[i] + st.theta * p->v[i];
    st.s0[i] = p->s[i] + st.theta * ds[i];
    st.x[i] = p->v[i];
  }
  PlainMultiply(n, p->K, base_u, tmp);
  for (PetscInt i = 0; i < n; ++i) st.c[i] += p->mass / st.theta * p->v[i] - tmp[i];
  if (!SolveStage(&st)) return PETSC_FALSE;
  SlipFrictionStateAdvance(&p->friction, n, st.theta, st.s0, st.x, 1, s1);
  for (PetscInt i = 0; i < n; ++i) {
    v1[i] = st.x[i];
    u1[i] = base_u[i] + st.theta * v1[i];
  }
  /* stage 2: three-point backward formula to t + h */
  st.theta = c.theta[1] * h;
  for (PetscInt i = 0; i < n; ++i) {
    base_u[i] = c.a1 * u1[i] - c.a0 * p->u[i];
    st.s0[i] = c.a1 * s1[i] - c.a0 * p->s[i];
  }
  PlainMultiply(n, p->K, base_u, tmp);
  for (PetscInt i = 0; i < n; ++i) st.c[i] = p->mass / st.theta * (c.a1 * v1[i] - c.a0 * p->v[i]) - tmp[i];
  if (!SolveStage(&st)) return PETSC_FALSE;
  SlipFrictionStateAdvance(&p->friction, n, st.theta, st.s0, st.x, 1, p->s2);
  p->slip_error = p->growth = 0;
  for (PetscInt i = 0; i < n; ++i) {
    const double v = st.x[i];

    p->v2[i] = v;
    p->u2[i] = base_u[i] + st.theta * v;
    p->slip_error += fabs(h / c.divisor * ((1 - GAMMA) * fabs(p->v[i]) - fabs(v1[i]) + GAMMA * fabs(v)));
    if (v != 0) p->growth += (v > 0 ? 1 : -1) * SlipBatheEndRate(&c, st.theta, p->v[i], v1[i], v);
  }
  return PETSC_TRUE;
}

double PlainFaultStrength(const PlainFault *p, PetscInt i)
{
  PetscReal mu, ds, dv;

  SlipFrictionEvaluate(&p->friction, i, &p->s[i], fabs(p->v[i]), &mu, &ds, &dv);
  return mu * p->friction.stress[i];
}

double PlainFaultWeakening(const PlainFault *p, PetscInt i)
{
  return SlipFrictionExcess(&p->friction, i, &p->s[i], fabs(p->v[i])) * p->friction.stress[i];
}

void PlainFaultMode(const PlainFault *p, const double x[], const double given[], PetscReal *stiffness,
                    PetscReal *weakening)
{
  double inertia = 0;

  *stiffness = *weakening = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    PetscReal mu, ds, dv;
    double kx = given ? given[i] : 0;

    for (PetscInt j = 0; j < p->n && !given; ++j) kx += p->K[i * p->n + j] * x[j];
    SlipFrictionEvaluate(&p->friction, i, &p->s[i], fabs(p->v[i]), &mu, &ds, &dv);
    *stiffness += x[i] * kx;
    *weakening -= ds * p->friction.stress[i] * x[i] * x[i];
    inertia += p->mass * x[i] * x[i];
  }
  *stiffness = inertia > 0 ? *stiffness / inertia : 0;
  *weakening = inertia > 0 ? *weakening / inertia : 0;
}

void PlainFaultAccept(PlainFault *p)
{
  memcpy(p->v, p->v2, sizeof(double) * (size_t)(p->n));
  memcpy(p->u, p->u2, sizeof(double) * (size_t)(p->n));
  memcpy(p->s, p->s2, sizeof(double) * (size_t)(p->n));
  p->start.h = p->end.h;
  p->start.h_before = p->end.h_before;
  p->start.known = p->end.known;
  if (!p->end.known) return;
  memcpy(p->start.f, p->end.f, sizeof(double) * (size_t)(PLAIN_MEMORY * p->n));
}

void PlainFaultSetState(PlainFault *p, const double w[])
{
  for (PetscInt i = 0; i < p->n; ++i) {
    p->v[i] = w[3 * i];
    p->u[i] = w[3 * i + 1];
    p->s[i] = w[3 * i + 2];
  }
  p->start.known = PETSC_FALSE;
}

/* Entries of a matrix that may be known by its products only */
static PetscErrorCode Entries(Mat A, PetscInt n, double a[])
{
  const PetscScalar *entry;
  Mat dense;

  PetscFunctionBegin;
  PetscCall(MatComputeOperator(A, MATDENSE, &dense));
  PetscCall(MatDenseGetArrayRead(dense, &entry));
  for (PetscInt j = 0; j < n; ++j)
    for (PetscInt i = 0; i < n; ++i) a[i * n + j] = (double)PetscRealPart(entry[j * n + i]);
  PetscCall(MatDenseRestoreArrayRead(dense, &entry));
  PetscCall(MatDestroy(&dense));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainFaultCreate(SlipFault fault, Vec start, PlainFault *p)
{
  PetscReal mass, tstar, perturbation, scale;
  const PetscScalar *w;
  char coupling[8];
  PetscBool no;
  PetscInt n;
  Mat K, H;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(p, sizeof(*p)));
  PetscCall(VecGetSize(start, &n));
  p->n = n /= 3;
  PetscCall(SlipFaultGetString(fault, "normal_coupling", coupling, sizeof(coupling)));
  PetscCall(PetscStrcmp(coupling, "no", &no));
  PetscCheck(no, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "training on events does not know normal stress that slip changes, as of a fault that dips: expected "
             "-fault_normal_coupling no, or ruptures from a given stress (-fault_initial traction)");
  PetscCall(SlipFaultGetOperators(fault, &K, &H, &mass));
  PetscCall(SlipFaultGetFriction(fault, 0, &p->friction));
  PetscCall(SlipFaultGetTimeScale(fault, &tstar));
  PetscCall(SlipFaultGetReal(fault, "initial_perturbation", &perturbation));
  PetscCall(SlipFaultGetReal(fault, "velocity_scale", &scale));
  p->known.velocity_scale = (double)scale;
  p->friction.weight = NULL; /* 1 on a grid */
  SlipBatheSetUp(GAMMA, &p->bathe);
  p->known.mass = p->mass = (double)mass;
  PetscCall(SlipFaultGetReal(fault, "damping_ratio", &p->known.damping_ratio));
  p->known.tstar = (double)tstar;
  PetscCall(PetscMalloc4(n * n, &p->K, n * n, &p->H, 2 * n * n + arrays * n, &p->work, n, &p->index));
  PetscCall(PetscCalloc7(n, &p->v, n, &p->u, n, &p->s, n, &p->v2, n, &p->u2, n, &p->s2, n, &p->uc));
  PetscCall(PetscCalloc3(3 * n, &p->w1, PLAIN_MEMORY * n, &p->start.f, PLAIN_MEMORY * n, &p->end.f));
  PetscCall(Entries(K, n, p->K));
  PetscCall(Entries(H, n, p->H));
  PetscCall(VecGetArrayRead(start, &w));
  for (PetscInt i = 0; i < n; ++i) { /* v = s = 0 so far */
    const double u = -(double)PetscRealPart(w[3 * i + 1]) / (1 + (double)perturbation), q = PlainFaultStrength(p, i);

    p->uc[i] = u;
    p->known.mean_dc += p->friction.slip[i] / (double)n;
    p->known.mean_drop += PlainFaultWeakening(p, i) / (double)n;
    p->known.critical_energy += u * q;
    p->known.mean_uc += u / (double)n;
    p->known.mean_q0 += q / (double)n;
  }
  PetscCall(VecRestoreArrayRead(start, &w));
  p->known.drop_slip = p->known.mean_drop / p->known.mean_q0 * p->known.mean_uc;
  PlainFaultMode(p, p->uc, NULL, &p->known.critical_stiffness, &p->known.critical_weakening);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PlainFaultDestroy(PlainFault *p)
{
  PetscFunctionBegin;
  PetscCall(PetscFree4(p->K, p->H, p->work, p->index));
  PetscCall(PetscFree7(p->v, p->u, p->s, p->v2, p->u2, p->s2, p->uc));
  PetscCall(PetscFree3(p->w1, p->start.f, p->end.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}
