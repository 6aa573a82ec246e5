/* What the parts of the comparison of general controllers share: problems (odeproblems.c), their references
   (odereference.c) and runs (ode.c). */
#pragma once
#include <petscts.h>

/* ---- problems y' = f(t, y), n components ---- */
enum { MAX_N = 40 };
typedef enum { RK3, RK5, ARK3, ARK4, BDF, BATHE, METHODS } Method;
#define M(m) (1 << (m))

typedef struct {
  const char *name;
  void (*f)(double t, const double y[], double dy[]);
  int n, methods;
  double end, y0[MAX_N]; /* the first of a problem whose start is a formula is NaN */
} Case;
extern const Case Cases[]; /* ends with a NULL name */

/* ---- references ---- */
typedef struct {
  const Case *c;
  double y0[MAX_N], scale[MAX_N];
  PetscInt n, capacity;
  double *rows; /* [n][1 + 2 c->n]: time, state, derivative */
} Reference;
PetscErrorCode ReferenceCreate(const Case *c, Reference *r);
/* Mean square of the deviation at t; at: the interval, which only moves on */
double ReferenceDeviation(const Reference *r, double t, const PetscScalar y[], PetscInt *at);
