/* Errors of small systems, see smallerrors.h. */
#include "smallerrors.h"

static PetscReal Square(PetscInt n, const PetscReal w[])
{
  PetscReal sum = 0;

  for (PetscInt i = 0; i < n; ++i) sum += w[i] * w[i];
  return sum;
}

void SmallErrorsStart(EnvReference reference, const PetscReal w[], SmallErrors *e)
{
  *e = (SmallErrors){.reference = reference, .size2 = Square(reference->states, w)};
  for (PetscInt i = 0; i < reference->states; ++i) e->last[i] = w[i];
}

void SmallErrorsStep(SmallErrors *e, PetscReal t, const PetscReal w[])
{
  const EnvReference ref = e->reference;
  const PetscInt n = ref->states, k = PetscMin((PetscInt)(t / ref->dt), ref->n - 2);
  const PetscReal at = t / ref->dt - (PetscReal)k;
  PetscReal exact[SMALL_MAX_STATES], error[SMALL_MAX_STATES], error2, size2;

  for (; e->next < ref->n && (PetscReal)e->next * ref->dt <= t; ++e->next) { /* what a long step jumps over */
    const PetscReal s = ((PetscReal)e->next * ref->dt - e->seen) / (t - e->seen), *known = &ref->state[n * e->next];

    for (PetscInt i = 0; i < n; ++i) e->between += PetscSqr((1 - s) * e->last[i] + s * w[i] - known[i]);
    e->between_size += Square(n, known);
  }
  for (PetscInt i = 0; i < n; ++i) {
    exact[i] = (1 - at) * ref->state[n * k + i] + at * ref->state[n * (k + 1) + i];
    error[i] = w[i] - exact[i];
    e->last[i] = w[i];
  }
  error2 = Square(n, error);
  size2 = Square(n, exact);
  e->errors += 0.5 * (t - e->seen) * (e->error2 + error2);
  e->sizes += 0.5 * (t - e->seen) * (e->size2 + size2);
  e->seen = t;
  e->error2 = error2;
  e->size2 = size2;
}

void SmallErrorsEnd(const SmallErrors *e, PetscReal error[2])
{
  error[0] = PetscSqrtReal(e->errors / e->sizes);
  error[1] = PetscSqrtReal(e->between / e->between_size);
}
