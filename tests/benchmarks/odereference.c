/* The reference: Dormand and Prince's pair at 1e-11, kept where a component has changed by 1e-4 of its size. */
#include "ode.h"
#include <math.h>

enum { STAGES = 7 };

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

static PetscErrorCode Keep(Reference *r, double t, const double y[], const double f[])
{
  const int n = r->c->n, width = 1 + 2 * n;
  double *row;

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
  return PetscArraycpy(row + 1 + n, f, n);
}

/* One pass; with the scales of the one before it. keep: rows */
static PetscErrorCode Integrate(Reference *r, double tol, PetscBool keep)
{
  const Case *c = r->c;
  const int n = c->n;
  double y[MAX_N], z[MAX_N], k[STAGES][MAX_N], scale[MAX_N], t = 0, h = 1e-8 * c->end;

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
  return PetscArraycpy(r->scale, scale, n);
}

PetscErrorCode ReferenceCreate(const Case *c, Reference *r)
{
  PetscCall(PetscMemzero(r, sizeof(*r)));
  r->c = c;
  for (int i = 0; i < c->n; i++) r->y0[i] = isnan(c->y0[0]) ? exp(-200 * PetscSqr(i / 40. - 0.3)) : c->y0[i];
  for (int i = 0; i < c->n; i++) r->scale[i] = 1;
  PetscCall(Integrate(r, 1e-6, PETSC_FALSE)); /* for the scales */
  return Integrate(r, REFERENCE_TOL, PETSC_TRUE);
}

double ReferenceDeviation(const Reference *r, double t, const PetscScalar y[], PetscInt *at)
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
