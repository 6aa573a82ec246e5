/* Checkpoints of the medium "waves": the memory of each wavenumber, for any number of processes. */
#include <slipstep/private/slipwavespace.h>
#include <slipstep/private/slipstate.h>

/* Count of the numbers that a checkpoint has for a wavenumber: `now`, `slip`, `next`, and all z */
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

/* Copies these numbers of wavenumber i to x, or from x while a checkpoint is loaded. */
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
  PetscCall(SlipWavesBegin(w)); /* a checkpoint has z also where slip is steady */
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
