/* Errors of small systems, see smallerrors.h. */
#include "smallerrors.h"

static PetscReal Square(PetscInt n, const PetscReal w[])
{
  PetscReal sum = 0;

  for (PetscInt i = 0; i < n; ++i) sum += w[i] * w[i];
  return sum;
}

static void Exact(const EnvReference ref, PetscReal t, PetscReal w[])
{
  const PetscInt n = ref->states, k = PetscMin((PetscInt)(t / ref->dt), ref->n - 2);
  const PetscReal s = t / ref->dt - (PetscReal)k;

  for (PetscInt i = 0; i < n; ++i) w[i] = (1 - s) * ref->state[n * k + i] + s * ref->state[n * (k + 1) + i];
}

void SmallErrorsStart(EnvReference reference, const PetscReal w[], SmallErrors *e)
{
  *e = (SmallErrors){.reference = reference, .size2 = Square(reference->states, w)};
  for (PetscInt i = 0; i < reference->states; ++i) e->last[i] = w[i];
}

/* What a long step jumps over */
static void Between(SmallErrors *e, PetscReal t, const PetscReal to[])
{
  const EnvReference ref = e->reference;
  const PetscInt n = ref->states;

  for (; e->next < ref->n && (PetscReal)e->next * ref->dt <= t; ++e->next) {
    const PetscReal s = ((PetscReal)e->next * ref->dt - e->seen) / (t - e->seen), *exact = &ref->state[n * e->next];

    for (PetscInt i = 0; i < n; ++i) e->between += PetscSqr((1 - s) * e->last[i] + s * to[i] - exact[i]);
    e->between_size += Square(n, exact);
  }
}

void SmallErrorsStep(SmallErrors *e, PetscReal t, const PetscReal w[])
{
  const PetscInt n = e->reference->states;
  PetscReal exact[SMALL_MAX_STATES], error[SMALL_MAX_STATES], error2, size2;

  Exact(e->reference, t, exact);
  Between(e, t, w);
  for (PetscInt i = 0; i < n; ++i) {
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
