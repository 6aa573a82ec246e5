/* See plainfault.h: the explicit step of src/ts/moreau.c and src/fault/stage/explicitkick.c, with entries in place of
   products. */
#include "plainfault.h"
#include <slipcompat.h>
#include <math.h>

enum { F, P, P_BEFORE, P_END, INNER, K_INNER }; /* of PlainMemory.f */

static double *At(const PlainFault *p, const PlainMemory *m, int row)
{
  return m->f + row * p->n;
}

double PlainFaultLimit(const PlainFault *p)
{
  return p->omega > 0 ? (double)(SLIP_LAG_MARGIN * SlipLagLimit(p->known.damping_ratio, 1)) / p->omega : 0;
}

static void Force(const PlainFault *p, const double u[], double f[])
{
  PlainMultiply(p->n, p->K, u, f);
  for (PetscInt i = 0; i < p->n; ++i) f[i] = -f[i];
}

/* Nothing is known of earlier steps. */
static void Start(PlainFault *p)
{
  PlainMemory *m = &p->start;

  Force(p, p->u, At(p, m, F));
  PlainMultiply(p->n, p->H, p->v, At(p, m, P));
  memcpy(At(p, m, P_END), At(p, m, P), sizeof(double) * (size_t)p->n);
  m->h = m->h_before = 0;
  m->known = PETSC_TRUE;
}

/* v after h [s] with the force g - friction */
static void Kick(const PlainFault *p, double h, const double g[], const double s[], double v[])
{
  for (PetscInt i = 0; i < p->n; ++i) {
    PetscReal mu, ds, dv;

    SlipFrictionEvaluate(&p->friction, i, &s[i], 0, &mu, &ds, &dv);
    v[i] = SlipKickConstant(p->mass, 0, h, g[i], mu * p->friction.stress[i], v[i]);
  }
}

static void Drift(const PlainFault *p, double h, const double v[], double u[], double s[])
{
  double *speed = p->work, *work = speed + p->n;

  for (PetscInt i = 0; i < p->n; ++i) {
    u[i] += h * v[i];
    speed[i] = fabs(v[i]);
  }
  SlipFrictionStateDrift(&p->friction, p->n, h, speed, 1, s, work);
}

/* Sums of the estimates of slip and of d|v|/dt at the end, where a cell that has stopped has none */
static void Estimate(PlainFault *p, double h)
{
  const double *f = At(p, &p->end, F), *damping = At(p, &p->end, P_END);

  p->slip_error = p->growth = 0;
  for (PetscInt i = 0; i < p->n; ++i) {
    const double v = p->v2[i];
    PetscReal mu, ds, dv;

    p->slip_error += fabs(2. / 3 * (p->s2[i] - p->s[i] - 0.5 * h * (fabs(p->v[i]) + fabs(v))));
    if (v == 0) continue;
    SlipFrictionEvaluate(&p->friction, i, &p->s2[i], fabs(v), &mu, &ds, &dv);
    p->growth += ((v > 0 ? 1 : -1) * (f[i] - damping[i]) - mu * p->friction.stress[i]) / p->mass;
  }
}

PetscBool PlainFaultKick(PlainFault *p, double h)
{
  const PetscInt n = p->n;
  const size_t size = sizeof(double) * (size_t)n;
  const PlainMemory *m = &p->start;
  PlainMemory *end = &p->end;
  double *first = p->work + 2 * n, *push = first + n, *inner = At(p, end, INNER), *damping = At(p, end, P), weight;

  if (!m->known) Start(p);
  weight = SlipLagWeight(h, m->h, m->h_before, p->omega, p->known.damping_ratio);
  memcpy(p->v2, p->v, size);
  memcpy(p->u2, p->u, size);
  memcpy(p->s2, p->s, size);
  for (PetscInt i = 0; i < n; ++i) {
    first[i] = At(p, m, P)[i];
    if (weight != 1) first[i] = weight * first[i] + (1 - weight) * At(p, m, P_BEFORE)[i];
    push[i] = At(p, m, F)[i] - first[i];
  }
  Kick(p, 0.5 * h, push, p->s2, p->v2);
  memcpy(inner, p->v2, size);
  Drift(p, 0.5 * h, inner, p->u2, p->s2);
  PlainMultiply(n, p->H, inner, damping);
  Drift(p, 0.5 * h, inner, p->u2, p->s2);
  Force(p, p->u2, At(p, end, F));
  for (PetscInt i = 0; i < n; ++i) {
    At(p, end, K_INNER)[i] = (At(p, m, F)[i] - At(p, end, F)[i]) / h;
    push[i] = At(p, end, F)[i] - 2 * damping[i] + first[i];
    At(p, end, P_END)[i] = damping[i] + h / (h + m->h) * (damping[i] - At(p, m, P)[i]);
  }
  Kick(p, 0.5 * h, push, p->s2, p->v2);
  memcpy(At(p, end, P_BEFORE), At(p, m, P), size);
  end->h_before = m->h;
  end->h = h;
  end->known = PETSC_TRUE;
  for (PetscInt i = 0; i < n; ++i)
    if (!isfinite(p->v2[i]) || !isfinite(p->s2[i])) return PETSC_FALSE;
  Estimate(p, h);
  return PETSC_TRUE;
}

void PlainFaultMotion(const PlainFault *p, PetscBool moves, PetscReal *stiffness, PetscReal *weakening)
{
  const double *inner = p->start.known && p->start.h > 0 ? At(p, &p->start, INNER) : NULL;
  PetscBool moved = PETSC_FALSE;

  for (PetscInt i = 0; i < p->n && inner; ++i)
    if (inner[i] != 0) moved = PETSC_TRUE;
  if (!moves)
    PlainFaultMode(p, p->uc, NULL, stiffness, weakening);
  else if (moved)
    PlainFaultMode(p, inner, At(p, &p->start, K_INNER), stiffness, weakening);
  else
    PlainFaultMode(p, p->v, NULL, stiffness, weakening);
}
