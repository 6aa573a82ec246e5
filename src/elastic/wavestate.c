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
static void Exchange(SlipWaves *w, PetscInt i, PetscBool loading, PetscReal *x)
{
  const SlipWaveSpace s = w->space;
  const PetscInt block = i / SLIP_WAVE_BLOCK * SLIP_WAVE_BLOCK, lane = i % SLIP_WAVE_BLOCK;

  for (PetscInt c = 0; c < s->modes * s->parts; c++) Move(loading, w->past.slip + c * s->stride + i, &x);
  for (PetscInt c = 0; c < w->kernels * s->parts; c++) {
    Move(loading, w->past.now + c * s->stride + i, &x);
    Move(loading, w->next + c * s->stride + i, &x);
  }
  for (PetscInt m = 0; m < w->kernels; m++) {
    const PetscInt numbers = 2 * w->memory[m].poles.n * s->parts;

    for (PetscInt j = 0; j < numbers; j++) {
      float *z = w->past.z[m] + numbers * block + j * SLIP_WAVE_BLOCK + lane;
      PetscReal number = (PetscReal)*z;

      Move(loading, &number, &x);
      *z = (float)number;
    }
  }
}

PetscErrorCode SlipWavesVisit(SlipElastic el, SlipState state)
{
  const PetscBool loading = SlipStateIsLoading(state);
  PetscBool steady;
  PetscReal *a;
  PetscInt per;
  SlipWaves *w;
  Vec x;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  per = PerWave(w);
  if (loading) w->known = PETSC_FALSE;
  PetscCall(SlipStateReal(state, "next_step", 1, &w->next_h));
  PetscCall(SlipStateBool(state, "steady", &w->past.steady));
  steady = w->past.steady;
  PetscCall(SlipWavesBegin(w)); /* steady slip is written as what it leaves, too */
  w->past.steady = steady;
  PetscCall(VecCreateMPI(w->space->comm, per * w->space->n, PETSC_DETERMINE, &x));
  PetscCall(VecGetArray(x, &a));
  for (PetscInt i = 0; i < w->space->n && !loading; i++) Exchange(w, i, loading, a + i * per);
  PetscCall(VecRestoreArray(x, &a));
  PetscCall(SlipStateVec(state, "waves", x));
  PetscCall(VecGetArray(x, &a));
  for (PetscInt i = 0; i < w->space->n && loading; i++) Exchange(w, i, loading, a + i * per);
  PetscCall(VecRestoreArray(x, &a));
  PetscCall(VecDestroy(&x));
  PetscCall(SlipWaveImagesVisit(w->images, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}
