/* The medium "waves" in checkpoints: what each wavenumber remembers, by whichever process. */
#include <slipstep/private/slipwavespace.h>
#include <slipstep/private/slipstate.h>

/* What a wavenumber has in a checkpoint, by whichever process: `now`, `slip`, `next`, and all z */
static PetscInt PerWave(const SlipWaves *w)
{
  PetscInt numbers = (w->space->modes + 2 * w->kernels) * w->space->parts;

  for (PetscInt m = 0; m < w->kernels; m++) numbers += 2 * w->memory[m].poles.n * w->space->parts;
  return numbers;
}

static void Move(PetscBool loading, PetscReal *number, PetscReal **x)
{
  if (loading)
    *number = **x;
  else
    **x = *number;
  (*x)++;
}

/* Those of wavenumber i, to x or from it */
static void Exchange(SlipWaves *w, SlipWavePast *memory, PetscInt i, PetscBool loading, PetscReal *x)
{
  const SlipWaveSpace s = w->space;
  const PetscInt block = i / SLIP_WAVE_BLOCK * SLIP_WAVE_BLOCK, lane = i % SLIP_WAVE_BLOCK;

  for (PetscInt c = 0; c < s->modes * s->parts; c++) Move(loading, memory->slip + c * s->stride + i, &x);
  for (PetscInt c = 0; c < w->kernels * s->parts; c++) {
    Move(loading, memory->now + c * s->stride + i, &x);
    Move(loading, w->next + c * s->stride + i, &x);
  }
  for (PetscInt m = 0; m < w->kernels; m++) {
    const PetscInt numbers = 2 * w->memory[m].poles.n * s->parts;

    for (PetscInt j = 0; j < numbers; j++) {
      float *z = memory->z[m] + numbers * block + j * SLIP_WAVE_BLOCK + lane;
      PetscReal number = (PetscReal)*z;

      Move(loading, &number, &x);
      *z = (float)number;
    }
  }
}

static PetscErrorCode VisitMemory(SlipWaves *w, SlipState state, const char name[], SlipWavePast *memory)
{
  const PetscBool loading = SlipStateIsLoading(state), steady = memory->steady;
  const PetscInt per = PerWave(w);
  PetscReal *a;
  Vec x;

  PetscFunctionBegin;
  if (!w->history) PetscCall(SlipWavesBegin(w, memory)); /* steady slip is written as what it leaves, too */
  memory->steady = steady;
  PetscCall(VecCreateMPI(w->space->comm, per * w->space->n, PETSC_DETERMINE, &x));
  PetscCall(VecGetArray(x, &a));
  for (PetscInt i = 0; i < w->space->n && !loading; i++) Exchange(w, memory, i, loading, a + i * per);
  PetscCall(VecRestoreArray(x, &a));
  PetscCall(SlipStateVec(state, name, x));
  PetscCall(VecGetArray(x, &a));
  for (PetscInt i = 0; i < w->space->n && loading; i++) Exchange(w, memory, i, loading, a + i * per);
  PetscCall(VecRestoreArray(x, &a));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWavesVisit(SlipElastic el, SlipState state)
{
  static const char *const names[] = {"waves_before", "waves"}, *const flags[] = {"steady_before", "steady"};
  const PetscBool loading = SlipStateIsLoading(state);
  PetscBool shared, follows;
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  shared = w->of[0] == w->of[1] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateBool(state, "shared", &shared));
  if (loading) {
    w->of[1] = 1;
    w->of[0] = shared ? 1 : 0;
    w->known = PETSC_FALSE;
    w->m_of = NULL;
  }
  follows = w->next_of == &w->both[w->of[1]] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateBool(state, "next", &follows));
  PetscCall(SlipStateReal(state, "next_step", 1, &w->next_h));
  w->next_of = follows ? &w->both[w->of[1]] : NULL;
  for (int slot = shared ? 1 : 0; slot < 2; slot++) {
    SlipWavePast *memory = &w->both[w->of[slot]];

    PetscCall(SlipStateBool(state, flags[slot], &memory->steady));
    PetscCall(VisitMemory(w, state, names[slot], memory));
  }
  if (w->history) {
    SlipWavePast *before = &w->both[w->of[0]], *last = &w->both[w->of[1]];

    PetscCall(SlipStateInt(state, "history_before", 1, &before->steps));
    PetscCall(SlipStateInt(state, "history_steps", 1, &last->steps));
    PetscCall(SlipWaveHistoryVisit(w->history, w->space, state, PetscMax(before->steps, last->steps)));
  }
  PetscCall(SlipWaveImagesVisit(w->images, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}
