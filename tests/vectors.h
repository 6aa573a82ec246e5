/* A test problem of its own: a stage of cells with c = 1, 2 or 3 components, B = mass / theta + eta + theta K with a
   full symmetric K, and bounds that are constant, weaken with slip, or are smooth, each of them with normal stress that
   depends on all cells. Its numbers follow from a seed, on any number of ranks. */
#pragma once
#include "linear.h"
#include <math.h>

enum {
  VECTORS_CONSTANT,
  VECTORS_WEAKENING,
  VECTORS_COUPLED,
  VECTORS_SMOOTH,
  VECTORS_SMOOTH_COUPLED,
  VECTORS_LAWS,
  VECTORS_FRICTION = VECTORS_LAWS, /* of cells that open, c = 3: the strength is over the pressure */
  VECTORS_WEAKENING_FRICTION
};

/* What the numbers are; b, load and coupling are whole on each rank */
typedef struct {
  PetscInt n, c, law;
  PetscReal theta, omega;
  PetscReal *B, *load, *C; /* [c n, c n] [c n] [n, c n], by rows */
  PetscReal *strength;     /* [n] at rest */
  PetscReal drop, slip;    /* weakening: strength (1 - drop (1 - exp(-theta |x| / slip))) */
  PetscReal friction;      /* coupled: strength + friction C x */
  PetscReal v0;            /* smooth: friction asinh(|x| / v0), times 0.1 */
} VectorsNumbers;

typedef struct {
  LinearSystem l;
  VectorsNumbers numbers; /* borrowed arrays */
  Vec strength, normal;   /* of cells; normal: C x of the last bound */
  Vec factor;             /* its derivative by C x */
  Mat C;
  SlipConstraint con;
  PetscInt fixed; /* a cell whose x is prescribed (smooth laws), -1: none */
} Vectors;

/* Numbers in [0, 1) of a linear congruential generator (Knuth's MMIX) */
static inline PetscReal VectorsRandom(uint64_t *seed)
{
  *seed = *seed * 6364136223846793005u + 1442695040888963407u;
  return (PetscReal)(*seed >> 11) / 9007199254740992.0;
}

static inline PetscReal VectorsLogRandom(uint64_t *seed, PetscReal low, PetscReal high)
{
  return low * pow(high / low, VectorsRandom(seed));
}

static inline PetscBool VectorsIsSmooth(PetscInt law)
{
  return law == VECTORS_SMOOTH || law == VECTORS_SMOOTH_COUPLED ? PETSC_TRUE : PETSC_FALSE;
}

static inline PetscBool VectorsIsCoupled(PetscInt law)
{
  return law == VECTORS_COUPLED || law == VECTORS_SMOOTH_COUPLED ? PETSC_TRUE : PETSC_FALSE;
}

/* Random numbers: K = A A' / (c n) of entries in [-1, 1], C as large as K where friction is 1 */
static inline PetscErrorCode VectorsRandomNumbers(PetscInt n, PetscInt c, PetscInt law, uint64_t *seed,
                                                  VectorsNumbers *s)
{
  const PetscInt N = c * n;
  PetscReal *A, mass, eta;

  *s = (VectorsNumbers){.n = n, .c = c, .law = law};
  PetscCall(PetscMalloc4(N * N, &s->B, N, &s->load, n * N, &s->C, n, &s->strength));
  PetscCall(PetscMalloc1(N * N, &A));
  s->theta = VectorsLogRandom(seed, 1e-2, 1e2);
  s->omega = VectorsRandom(seed) < 0.5 ? 1 : 2;
  s->drop = 0.9 * VectorsRandom(seed);
  s->slip = VectorsLogRandom(seed, 0.3, 30);
  s->friction = VectorsRandom(seed);
  s->v0 = VectorsLogRandom(seed, 1e-12, 1e-2);
  mass = VectorsRandom(seed);
  eta = VectorsRandom(seed);
  for (PetscInt i = 0; i < N * N; i++) A[i] = 2 * VectorsRandom(seed) - 1;
  for (PetscInt i = 0; i < N; i++)
    for (PetscInt j = 0; j < N; j++) {
      PetscReal k = 0;

      for (PetscInt l = 0; l < N; l++) k += A[i * N + l] * A[j * N + l];
      s->B[i * N + j] = s->theta * k / (PetscReal)N + (i == j ? mass / s->theta + eta : 0);
    }
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal size = 3 * VectorsRandom(seed), angle = 2 * PETSC_PI * VectorsRandom(seed);

    s->strength[i] = 0.2 + VectorsRandom(seed);
    s->load[c * i] = size * (c == 1 && angle > PETSC_PI ? -1 : 1) * (c == 1 ? 1 : cos(angle));
    if (c >= 2) s->load[c * i + 1] = size * sin(angle);
    if (c == 3) s->load[c * i + 2] = 4 * VectorsRandom(seed) - 3; /* three in four are pressed */
    for (PetscInt j = 0; j < N; j++) s->C[i * N + j] = s->theta * (2 * VectorsRandom(seed) - 1) / (PetscReal)N;
  }
  return PetscFree(A);
}

static inline PetscErrorCode VectorsFreeNumbers(VectorsNumbers *s)
{
  return PetscFree4(s->B, s->load, s->C, s->strength);
}

static inline PetscReal VectorsSize(PetscInt c, const PetscReal x[])
{
  return c == 1 ? PetscAbsReal(x[0]) : hypot(x[0], x[1]);
}

/* q and dq/d|x| of a cell under the normal stress 1 + friction normal >= 0, in units of its strength */
static inline void VectorsStrength(const VectorsNumbers *s, PetscReal x, PetscReal normal, PetscReal *q, PetscReal *dq)
{
  const PetscReal fade = exp(-s->theta * x / s->slip), stress = PetscMax(1 + s->friction * normal, 0);

  switch (s->law) {
  case VECTORS_CONSTANT:
  case VECTORS_FRICTION:
    *q = 1;
    *dq = 0;
    break;
  case VECTORS_WEAKENING:
  case VECTORS_WEAKENING_FRICTION:
    *q = 1 - s->drop * (1 - fade);
    *dq = -s->drop * s->theta / s->slip * fade;
    break;
  case VECTORS_COUPLED:
    *q = stress;
    *dq = 0;
    break;
  default:
    *q = 0.1 * asinh(x / s->v0);
    *dq = 0.1 / hypot(x, s->v0);
    if (s->law != VECTORS_SMOOTH_COUPLED) break;
    *q *= stress;
    *dq *= stress;
  }
}

static PetscErrorCode VectorsBound(SlipConstraint con, Vec x, Vec q, Vec dq, void *ctx)
{
  Vectors *p = (Vectors *)ctx;
  const PetscInt c = p->numbers.c;
  const PetscReal *xx, *a, *normal;
  PetscReal *qq, *factor, *d = NULL, unused;
  PetscInt n;

  PetscCall(VecGetLocalSize(q, &n));
  PetscCall(MatMult(p->C, x, p->normal));
  xx = VecRead(x);
  a = VecRead(p->strength);
  normal = VecRead(p->normal);
  PetscCall(VecGetArray(q, &qq));
  PetscCall(VecGetArray(p->factor, &factor));
  if (dq) PetscCall(VecGetArray(dq, &d));
  for (PetscInt i = 0; i < n; i++) {
    VectorsStrength(&p->numbers, VectorsSize(c, &xx[c * i]), normal[i], &qq[i], d ? &d[i] : &unused);
    qq[i] *= a[i];
    if (d) d[i] *= a[i];
    factor[i] = 1 + p->numbers.friction * normal[i];
    factor[i] = factor[i] > 0 ? p->numbers.friction * qq[i] / factor[i] : 0;
  }
  if (dq) PetscCall(VecRestoreArray(dq, &d));
  PetscCall(VecRestoreArray(p->factor, &factor));
  return VecRestoreArray(q, &qq);
}

/* dq/d|x| at rest */
static PetscErrorCode VectorsStartSlope(SlipConstraint con, Vec dq, void *ctx)
{
  const Vectors *p = (const Vectors *)ctx;
  PetscReal q, d;

  VectorsStrength(&p->numbers, 0, 0, &q, &d);
  PetscCall(VecCopy(p->strength, dq));
  return VecScale(dq, d);
}

static PetscErrorCode VectorsCoupling(SlipConstraint con, Mat *C, Vec a, void *ctx)
{
  const Vectors *p = (const Vectors *)ctx;

  *C = p->C;
  return VecCopy(p->factor, a);
}

/* The root of D v + omega q(v) = |f| by halving in asinh(v / v0), with the sign of f; C x as bound was asked about
   last */
static PetscErrorCode VectorsSolveCells(SlipConstraint con, PetscReal omega, Vec D, Vec f, Vec x, PetscBool *unstable,
                                        void *ctx)
{
  const Vectors *p = (const Vectors *)ctx;
  const PetscReal *d, *ff, *a, *normal;
  PetscReal *xx;
  PetscInt n, first;

  PetscCall(VecGetLocalSize(p->strength, &n));
  PetscCall(VecGetOwnershipRange(p->strength, &first, NULL));
  d = VecRead(D);
  ff = VecRead(f);
  a = VecRead(p->strength);
  normal = VecRead(p->normal);
  PetscCall(VecGetArray(x, &xx));
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal load = PetscAbsReal(ff[i]);
    PetscReal low = 0, high = asinh(load / (d[i] * p->numbers.v0));

    for (int it = 0; it < 100; it++) {
      const PetscReal u = 0.5 * (low + high), v = p->numbers.v0 * sinh(u);
      PetscReal q, unused;

      VectorsStrength(&p->numbers, v, normal[i], &q, &unused);
      if (d[i] * v + omega * a[i] * q > load)
        high = u;
      else
        low = u;
    }
    xx[i] = first + i == p->fixed ? 77 : copysign(p->numbers.v0 * sinh(low), ff[i]);
  }
  return VecRestoreArray(x, &xx);
}

static PetscErrorCode VectorsPrescribed(SlipConstraint con, Vec mask, void *ctx)
{
  const Vectors *p = (const Vectors *)ctx;
  PetscInt first, last;

  PetscCall(VecGetOwnershipRange(mask, &first, &last));
  if (p->fixed >= first && p->fixed < last) PetscCall(VecSetValue(mask, p->fixed, 0, INSERT_VALUES));
  return VecAssemble(mask);
}

static inline PetscErrorCode VectorsCreate(MPI_Comm comm, const VectorsNumbers *s, Vectors *p)
{
  const PetscBool smooth = VectorsIsSmooth(s->law);
  const SlipConstraintOps ops = {.residual = LinearResidual,
                                 .jacobian = LinearJacobian,
                                 .bound = VectorsBound,
                                 .solve_cells = smooth ? VectorsSolveCells : NULL,
                                 .prescribed = smooth ? VectorsPrescribed : NULL,
                                 .start_slope = VectorsStartSlope,
                                 .coupling = VectorsIsCoupled(s->law) ? VectorsCoupling : NULL};
  PetscInt n, first, last;

  *p = (Vectors){.numbers = *s, .fixed = -1};
  PetscCall(VecCreate(comm, &p->strength));
  PetscCall(VecSetSizes(p->strength, PETSC_DECIDE, s->n));
  PetscCall(VecSetFromOptions(p->strength));
  PetscCall(DuplicateVecs(p->strength, &p->normal, &p->factor));
  PetscCall(VecGetLocalSize(p->strength, &n));
  PetscCall(VecGetOwnershipRange(p->strength, &first, &last));
  PetscCall(MatCreateDense(comm, s->c * n, s->c * n, s->c * s->n, s->c * s->n, NULL, &p->l.B));
  PetscCall(MatCreateDense(comm, n, s->c * n, s->n, s->c * s->n, NULL, &p->C));
  PetscCall(MatCreateVecs(p->l.B, NULL, &p->l.load));
  for (PetscInt i = s->c * first; i < s->c * last; i++) {
    for (PetscInt j = 0; j < s->c * s->n; j++)
      PetscCall(MatSetValue(p->l.B, i, j, s->B[i * s->c * s->n + j], INSERT_VALUES));
    PetscCall(VecSetValue(p->l.load, i, s->load[i], INSERT_VALUES));
  }
  for (PetscInt i = first; i < last; i++) {
    for (PetscInt j = 0; j < s->c * s->n; j++)
      PetscCall(MatSetValue(p->C, i, j, s->C[i * s->c * s->n + j], INSERT_VALUES));
    PetscCall(VecSetValue(p->strength, i, s->strength[i], INSERT_VALUES));
  }
  PetscCall(MatAssemble(p->l.B));
  PetscCall(MatAssemble(p->C));
  PetscCall(VecAssemble(p->l.load));
  PetscCall(VecAssemble(p->strength));
  PetscCall(SlipConstraintCreate(comm, &ops, p, p->l.load, &p->con));
  return SlipConstraintSetComponents(p->con, s->c, p->strength);
}

static inline PetscErrorCode VectorsDestroy(Vectors *p)
{
  return DestroyObjects(&p->con, &p->l.B, &p->C, &p->l.load, &p->strength, &p->normal, &p->factor);
}

/* And its numbers */
static inline PetscErrorCode VectorsDestroyAll(Vectors *p)
{
  PetscCall(VectorsDestroy(p));
  return VectorsFreeNumbers(&p->numbers);
}

/* A solver of the type, the linear systems direct or by Krylov's methods */
static inline PetscErrorCode VectorsCreateSolver(Vectors *p, const char *type, PetscBool direct, SNES *snes)
{
  PetscCall(CreateSolver(p->con, type, direct ? "350" : "0", snes));
  if (VectorsIsSmooth(p->numbers.law)) /* which is not polished */
    PetscCall(SNESSetTolerances(*snes, PETSC_DEFAULT, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  return PETSC_SUCCESS;
}

/* From the guess in x */
static inline PetscErrorCode VectorsSolve(Vectors *p, SNES snes, Vec x, Vec r, SNESConvergedReason *reason)
{
  const SlipStage stage = {.theta = p->numbers.theta, .omega = p->numbers.omega};

  PetscCall(SNESSlipSolveStage(snes, &stage, x, r, NULL));
  return SNESGetConvergedReason(snes, reason);
}

/* Whether a solution holds: |r| <= q, r = -q x / |x| where x != 0, both over q, and G(x) = omega r over the largest
   load or strength. Of cells that open q is friction times the pressure, and x_n >= 0, r_n >= 0, x_n r_n = 0. Of this
   process. */
static inline PetscErrorCode VectorsHold(Vectors *p, Vec x, Vec r, PetscBool *holds)
{
  const PetscInt c = p->numbers.c;
  const PetscReal *xx, *rr, *qq, *gg;
  PetscReal scale, beyond = 0, opposite = 0, balance = 0;
  PetscInt n, first, inside = 0, contact = 0;
  Vec q, g;

  PetscCall(VecDuplicate(p->strength, &q));
  PetscCall(VecDuplicate(x, &g));
  PetscCall(VecNorm(p->l.load, NORM_INFINITY, &scale));
  scale = PetscMax(scale, 1);
  PetscCall(VectorsBound(p->con, x, q, NULL, p));
  PetscCall(LinearResidual(p->con, x, g, p));
  PetscCall(VecGetLocalSize(q, &n));
  PetscCall(VecGetOwnershipRange(q, &first, NULL));
  xx = VecRead(x);
  rr = VecRead(r);
  qq = VecRead(q);
  gg = VecRead(g);
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal *v = xx + c * i, *f = rr + c * i, strength = qq[i] * (c == 3 ? f[2] : 1);
    const PetscReal size = VectorsSize(c, v), reaction = VectorsSize(c, f);

    if (first + i == p->fixed) continue;
    contact += c == 3 && !(v[2] >= 0 && f[2] >= 0 && v[2] * f[2] == 0);
    if (!(reaction <= strength)) beyond = PetscMax(beyond, strength > 0 ? reaction / strength - 1 : 1);
    inside += size > 0 && reaction < (1 - 1e-9) * strength;
    for (PetscInt k = 0; k < PetscMin(c, 2); k++)
      if (size > 0 && strength > 0) opposite = PetscMax(opposite, PetscAbsReal(f[k] / strength + v[k] / size));
    for (PetscInt k = 0; k < c; k++)
      balance = PetscMax(balance, PetscAbsReal(gg[c * i + k] - p->numbers.omega * f[k]) / scale);
  }
  *holds = beyond <= 1e-12 && opposite <= 1e-10 && balance <= 1e-9 && !inside && !contact ? PETSC_TRUE : PETSC_FALSE;
  if (!*holds)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "law %d: beyond %g, opposite %g, balance %g, %d inside, %d not in contact\n",
                          (int)p->numbers.law, (double)beyond, (double)opposite, (double)balance, (int)inside,
                          (int)contact));
  return DestroyObjects(&q, &g);
}
