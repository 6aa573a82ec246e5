/*
  The medium "waves": a plane or an antiplane line from which elastic waves radiate. Where T is the load, K the static
  stiffness, d slip less loading and V its rate, friction is T - K d + m - eta V, eta = G/(2 cs). The memory m is the
  stress of waves under way: for each wavenumber k and mode (G k/2) int W(k cs t') V(t - t') dt' (Geubelle & Rice 1995).
  On planes fields are band-limited. On lines slip is constant on cells, as in the static matrix: the stress at cell
  centres has, besides k, the aliases 2 pi/dx -+ k, with amplitudes of +- (G/dx) sin(k dx/2). A factor of these stands
  for all farther aliases; it is chosen so that steady slip has no damping.

  W is a sum of decaying exponentials (wave_poles.c), so that a step of any length at a constant rate takes one product
  per exponential, without a history and without a time window. If a step is longer than the memory, m is eta V, and
  nothing else is computed. The state (u, t) follows from the step's start by a constant rate up to u. A step overwrites
  the memory; steps have no parts, which would need a copy of it.
*/
#include <slipstep/private/slipwavespace.h>
#include <slipstep/private/slipstate.h>

/* ---- steps ---- */

static PetscErrorCode TableOf(SlipWaves *w, PetscReal h, SlipWaveTable **table)
{
  SlipWaveTable *oldest = w->table;

  PetscFunctionBegin;
  w->clock++;
  for (PetscInt i = 0; i < SLIP_WAVE_TABLES; i++) {
    *table = w->table + i;
    if ((*table)->h == h) {
      (*table)->used = w->clock;
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    if ((*table)->used < oldest->used) oldest = *table;
  }
  *table = oldest;
  oldest->h = h;
  oldest->used = w->clock;
  for (PetscInt m = 0; m < w->kernels; m++) {
    if (!oldest->E[m]) {
      PetscCall(SlipWavesAllocate((size_t)2 * w->memory[m].poles.n * w->space->stride, &oldest->E[m]));
      PetscCall(SlipAllocate((size_t)w->space->stride, &oldest->step[m]));
    }
    SlipWaveMemoryTable(&w->memory[m], h, oldest->E[m], oldest->step[m]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the spectrum of u, unless u is the displacement of the last call, which is often so. Collective. */
static PetscErrorCode Transform(SlipWaves *w, Vec u)
{
  PetscBool same = PETSC_FALSE;

  PetscFunctionBegin;
  if (w->known) {
    PetscInt n;
    const PetscReal *a, *b;
    PetscBool here;

    PetscCall(VecGetLocalSize(u, &n));
    PetscCall(VecGetArrayRead(u, &a));
    PetscCall(VecGetArrayRead(w->last, &b));
    PetscCall(PetscArraycmp(a, b, n, &here));
    PetscCall(VecRestoreArrayRead(w->last, &b));
    PetscCall(VecRestoreArrayRead(u, &a));
    PetscCallMPI(MPI_Allreduce(&here, &same, 1, MPIU_BOOL, MPI_LAND, w->space->comm));
  }
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecCopy(u, w->last));
  PetscCall(SlipWaveSpaceForward(w->space, u, w->slip));
  PetscCall(SlipWaveImagesSet(w->images, u));
  w->known = PETSC_TRUE;
  w->m_known = w->answered = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets w->rate to the spectrum of the constant rate that leads from the step's start to w->slip in the time h. */
SLIP_VECTOR static void SlipWavesRate(SlipWaves *w, PetscReal h)
{
  const PetscReal inverse = 1 / h;
  const size_t n = SlipWavesNumbers(w);

  for (size_t i = 0; i < n; i++) w->rate[i] = (w->slip[i] - w->past.slip[i]) * inverse;
}

/* Sets w->m to the weighted sum over all kernels of sums [kernels][parts][stride], and with table != NULL also of what
   slip at a constant rate adds from the step's start during h. */
SLIP_VECTOR static void SlipWavesSum(SlipWaves *w, const PetscReal sums[], const SlipWaveTable *table, PetscReal h)
{
  const PetscInt stride = w->space->stride;
  const PetscReal inverse = table ? 1 / h : 0;

  for (PetscInt k = 0; k < w->kernels; k++)
    for (PetscInt p = 0; p < w->space->parts; p++) {
      const PetscInt field = w->memory[k].field, at = (field * w->space->parts + p) * stride;
      const PetscReal *sum = sums + (k * w->space->parts + p) * stride, *weight = w->memory[k].weight;
      const PetscReal *now = w->slip + at, *before = w->past.slip + at, *step = table ? table->step[k] : NULL;
      const PetscBool first = k == 0 || w->memory[k - 1].field != field ? PETSC_TRUE : PETSC_FALSE;
      PetscReal *m = w->m + at;

      for (PetscInt i = 0; i < stride; i++) {
        const PetscReal moved = table ? step[i] * ((now[i] - before[i]) * inverse) : 0;

        m[i] = (first ? 0 : m[i]) + weight[i] * (sum[i] + moved);
      }
    }
}

/* Sets w->next to the sums of all kernels at h > 0 after the step's start, without slip since then. */
static void Next(SlipWaves *w, PetscReal h, const SlipWaveTable *table)
{
  if (w->next_h == h) return;
  for (PetscInt k = 0; k < w->kernels; k++)
    SlipWaveMemoryNext(&w->memory[k], table->E[k], w->past.z[k], SlipWavesPart(w, w->next, k));
  w->next_h = h;
}

/* Computes w->m at h after the step's start, for slip that goes at a constant rate to the state of spectrum w->slip. */
static PetscErrorCode MemoryAfter(SlipWaves *w, PetscReal h)
{
  SlipWaveTable *table;

  PetscFunctionBegin;
  if (w->m_known && w->m_h == h) PetscFunctionReturn(PETSC_SUCCESS);
  w->m_known = PETSC_TRUE;
  w->m_h = h;
  if (!(h > 0)) {
    SlipWavesSum(w, w->past.now, NULL, h);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (h >= w->longest) {
    SlipWavesRate(w, h);
    PetscCall(PetscArraycpy(w->m, w->rate, SlipWavesNumbers(w)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipWavesBegin(w));
  PetscCall(TableOf(w, h, &table));
  Next(w, h, table);
  SlipWavesSum(w, w->next, table, h);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether slip counts as steady: h is longer than the memory, or h is 0 and slip was steady before. */
static PetscBool IsSteady(const SlipWaves *w, PetscReal h)
{
  return h >= w->longest || (!(h > 0) && w->past.steady) ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- the operations ---- */

/* Sets w->stress to the spectrum of the stress of w->slip, with the memory w->m. */
SLIP_VECTOR static void SlipWavesResist(SlipWaves *w)
{
  for (PetscInt m = 0; m < w->space->modes; m++)
    for (PetscInt p = 0; p < w->space->parts; p++) {
      const PetscInt stride = w->space->stride, at = (m * w->space->parts + p) * stride;
      const PetscReal *k = w->stiffness + m * stride, *u = w->slip + at, *under_way = w->m + at, eta = w->eta;
      PetscReal *f = w->stress + at;

      for (PetscInt i = 0; i < stride; i++) f[i] = k[i] * u[i] - eta * under_way[i];
    }
}

/* Sets w->answer to the stress, without damping, of the displacement whose spectrum is w->slip, at the time t. */
static PetscErrorCode Answer(SlipElastic el, SlipWaves *w, PetscReal t)
{
  SlipElasticPast past;
  PetscInt slot;
  PetscBool steady = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipElasticFindPast(el, t, &slot));
  if (slot < 0) {
    PetscCall(PetscArrayzero(w->m, SlipWavesNumbers(w)));
    w->m_known = PETSC_FALSE;
  } else {
    PetscCall(SlipElasticGetPast(el, slot, &past));
    steady = IsSteady(w, t - past.t);
    PetscCall(MemoryAfter(w, t - past.t));
  }
  SlipWavesResist(w);
  PetscCall(SlipWaveSpaceBackward(w->space, w->stress, w->answer));
  PetscCall(SlipWaveImagesSubtract(w->images, t, steady, w->answer));
  w->answered = PETSC_TRUE;
  w->answer_t = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Force_Waves(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  SlipWaves *w;
  Vec damping;

  PetscFunctionBegin;
  if (normal && u) PetscCall(VecZeroEntries(normal));
  if (!u || !shear) {
    if (v && shear) PetscCall(SlipElasticForceStatic(el, t, NULL, v, shear, NULL));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(Transform(w, u));
  if (!w->answered || w->answer_t != t) PetscCall(Answer(el, w, t));
  PetscCall(VecCopy(w->answer, shear));
  if (!v) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticGetWork(el, 1, &damping));
  PetscCall(SlipElasticForceStatic(el, t, NULL, v, damping, NULL));
  PetscCall(VecAXPY(shear, 1, damping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Advances the memory by a step of h, in which slip goes at a constant rate to the state of spectrum w->slip. */
static PetscErrorCode AddStep(SlipWaves *w, PetscReal h)
{
  SlipWavePast *past = &w->past;
  SlipWaveTable *table;

  PetscFunctionBegin;
  if (!(h > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  SlipWavesRate(w, h);
  w->next_h = 0;
  if (h >= w->longest) {
    for (PetscInt m = 0; m < w->kernels; m++)
      PetscCall(PetscArraycpy(SlipWavesPart(w, past->now, m), SlipWavesPart(w, w->rate, w->memory[m].field),
                              w->space->parts * w->space->stride));
    past->steady = PETSC_TRUE;
  } else {
    PetscCall(SlipWavesBegin(w));
    PetscCall(TableOf(w, h, &table));
    for (PetscInt m = 0; m < w->kernels; m++)
      SlipWaveMemoryAdvance(&w->memory[m], table->E[m], SlipWavesPart(w, w->rate, w->memory[m].field), past->z[m],
                            SlipWavesPart(w, past->now, m), SlipWavesPart(w, w->next, m));
    w->next_h = h;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Advance_Waves(SlipElastic el, PetscInt from, PetscInt to, PetscReal t, Vec u)
{
  SlipElasticPast start;
  PetscReal *last;
  SlipWaves *w;

  PetscFunctionBegin;
  (void)to;
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(Transform(w, u));
  if (from < 0) {
    w->past.steady = PETSC_TRUE;
    w->next_h = 0;
    PetscCall(PetscArrayzero(w->past.now, SlipWavesSums(w)));
    PetscCall(SlipWaveImagesStart(w->images));
  } else {
    PetscCall(SlipElasticGetPast(el, from, &start));
    PetscCall(AddStep(w, t - start.t));
  }
  last = w->past.slip; /* its array is reused for the next state's spectrum */
  w->past.slip = w->slip;
  w->slip = last;
  w->known = PETSC_FALSE; /* Transform() then recomputes all that depends on the spectrum */
  PetscCall(SlipWaveImagesAdd(w->images, t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns this process' part of the scalar product of the fields of two spectra. */
SLIP_VECTOR static PetscReal SlipWavesProduct(const SlipWaves *w, const PetscReal x[], const PetscReal y[])
{
  const PetscInt stride = w->space->stride;
  PetscReal lane[SLIP_WAVE_BLOCK] = {0}, sum = 0;

  for (PetscInt c = 0; c < w->space->modes * w->space->parts; c++)
    for (PetscInt i = 0; i < stride; i += SLIP_WAVE_BLOCK)
      for (PetscInt l = 0; l < SLIP_WAVE_BLOCK; l++)
        lane[l] += w->space->share[i + l] * x[c * stride + i + l] * y[c * stride + i + l];
  for (PetscInt l = 0; l < SLIP_WAVE_BLOCK; l++) sum += lane[l];
  return sum;
}

/* Computes this process' part of x.m, for the displacement u at t and a field x. The memory m is the stress that waves
   under way add, including the delayed stress of images. */
static PetscErrorCode Work(SlipElastic el, PetscReal t, Vec u, Vec x, PetscReal *work)
{
  SlipElasticPast past;
  PetscInt slot;
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  *work = 0;
  PetscCall(SlipElasticFindPast(el, t, &slot));
  if (slot < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticGetPast(el, slot, &past));
  PetscCall(Transform(w, u));
  PetscCall(SlipWaveImagesWork(w->images, t, IsSteady(w, t - past.t), x == u ? NULL : x, work));
  PetscCall(MemoryAfter(w, t - past.t));
  if (x != u) PetscCall(SlipWaveSpaceForward(w->space, x, w->rate));
  *work += w->eta * SlipWavesProduct(w, x == u ? w->slip : w->rate, w->m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds u.m/2: the medium stores u.K u/2 while its stress is K u - m. */
static PetscErrorCode Energy_Waves(SlipElastic el, PetscReal t, Vec u, PetscReal *stored)
{
  PetscReal work;

  PetscFunctionBegin;
  PetscCall(Work(el, t, u, u, &work));
  *stored += 0.5 * work;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Subtracts v.m, the power that waves return of what the impedance takes. */
static PetscErrorCode Power_Waves(SlipElastic el, PetscReal t, Vec u, Vec v, PetscReal *lost)
{
  PetscReal work;

  PetscFunctionBegin;
  PetscCall(Work(el, t, u, v, &work));
  *lost -= work;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Shortest_Waves(SlipElastic el, PetscReal *step)
{
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  *step = w->least;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipElasticOps WavesOps = {.setup = SlipWavesSetUp,
                                        .force = Force_Waves,
                                        .energy = Energy_Waves,
                                        .power = Power_Waves,
                                        .advance = Advance_Waves,
                                        .shortest = Shortest_Waves,
                                        .images = SlipWavesImages,
                                        .visit = SlipWavesVisit,
                                        .view = SlipWavesView,
                                        .destroy = SlipWavesDestroy};

PetscErrorCode SlipElasticCreate_Waves(SlipElastic el)
{
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(PetscNew(&w));
  PetscCall(SlipElasticSetOps(el, &WavesOps, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}
