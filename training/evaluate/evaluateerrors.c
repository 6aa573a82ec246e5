/* Errors of a run against a reference, and tables of rows: numbers only. */
#include "evaluate.h"
#include <slipcompat.h>

PetscErrorCode EvaluateTableAdd(EvaluateTable *t, const PetscReal row[])
{
  PetscFunctionBegin;
  if (t->n == t->capacity) {
    t->capacity = t->capacity ? 2 * t->capacity : 256;
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(t->capacity * t->width), &t->data));
  }
  PetscCall(PetscArraycpy(&t->data[t->n++ * t->width], row, t->width));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EvaluateTableClear(EvaluateTable *t)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(t->data));
  t->n = t->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Row of the reference at time t, linear between its rows; *at is where the last search ended. Times ascend. */
static void Interpolate(const EvaluateTable *ref, PetscReal t, PetscInt *at, PetscReal row[])
{
  const PetscInt w = ref->width;
  const PetscReal *a, *b;
  PetscReal s;

  while (*at < ref->n - 2 && ref->data[(*at + 1) * w] < t) ++*at;
  a = &ref->data[*at * w];
  b = a + w;
  s = b[0] > a[0] ? (t - a[0]) / (b[0] - a[0]) : 1;
  s = PetscClipInterval(s, (PetscReal)0, (PetscReal)1);
  for (PetscInt k = 1; k < w; k++) row[k - 1] = (1 - s) * a[k] + s * b[k];
}

static PetscReal Norm2(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0;

  for (PetscInt k = 0; k < n; k++) sum += PetscSqr(a[k] - (b ? b[k] : 0));
  return sum;
}

/*
  Errors at the ends of the accepted steps, e = |y - y_ref| over the state columns:
    final   e at the last step (signed for a single state), max  the largest e, both over |y_ref| at the end (relative
            problems; the largest |y_ref| where the state decays, that is for several states)
    l2      (int e^2 dt)^1/2 over (int |y_ref|^2 dt)^1/2, or over the root of the duration where errors are absolute;
            trapezoidal rule over the accepted steps
    rate    largest error of the rate column over its largest reference value
*/
PetscErrorCode EvaluateErrors(const Evaluation *p, void *model, const EvaluateTable *ref, const EvaluateTable *series,
                              EvaluateResult *r)
{
  const PetscInt n = p->nstates, w = series->width;
  PetscReal exact[EVALUATE_COLUMNS], errors = 0, sizes = 0, largest = 0, size = 0, rate = 0, rate_size = 0, e2 = 0,
                                     s2 = 0;
  PetscReal before_e2 = 0, before_s2 = 0, scale;
  PetscInt at = 0;

  PetscFunctionBegin;
  PetscCheck(series->n > 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "a run without rows");
  for (PetscInt i = 0; i < series->n; i++) {
    const PetscReal *row = &series->data[i * w], dt = i ? row[0] - row[-w] : 0;

    if (p->exact)
      PetscCall(p->exact(model, row[0], exact));
    else
      Interpolate(ref, row[0], &at, exact);
    e2 = Norm2(n, row + 1, exact);
    s2 = Norm2(n, exact, NULL);
    errors += 0.5 * dt * (before_e2 + e2);
    sizes += 0.5 * dt * (before_s2 + s2);
    largest = PetscMax(largest, e2);
    if (p->rate >= 0) rate = PetscMax(rate, PetscAbsReal(row[1 + p->rate] - exact[p->rate]));
    before_e2 = e2;
    before_s2 = s2;
  }
  for (PetscInt i = 0; i < ref->n; i++) {
    const PetscReal *row = &ref->data[i * ref->width + 1];

    size = PetscMax(size, Norm2(n, row, NULL));
    if (p->rate >= 0) rate_size = PetscMax(rate_size, PetscAbsReal(row[p->rate]));
  }
  scale = p->relative ? PetscSqrtReal(n > 1 ? size : s2) : 1;
  r->final = series->data[(series->n - 1) * w + 1];
  r->final_error = (n == 1 ? r->final - exact[0] : PetscSqrtReal(e2)) / scale;
  r->max_error = PetscSqrtReal(largest) / scale;
  r->l2_error = PetscSqrtReal(errors / (p->relative ? sizes : series->data[(series->n - 1) * w]));
  r->rate_error = p->rate >= 0 ? rate / rate_size : NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}
