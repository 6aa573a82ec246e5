/*
  The medium "waves": a plane, or an antiplane line, that radiates. With T the load, K the static stiffness, d slip less
  loading and V its rate, friction is T - K d + m - eta V, eta = G/(2 cs), where the memory m is the stress of waves
  under way: of each wavenumber k and mode (G k/2) int W(k cs t') V(t - t') dt' (Geubelle & Rice 1995). On planes
  fields are band-limited, on lines slip is constant on cells, as in the static matrix: the stress at their centres has,
  beside k, the wavenumbers 2 pi/dx -+ k, which look the same there, with amplitudes of +- (G/dx) sin(k dx/2). All
  farther ones are in a factor of theirs by which steady slip meets no damping.

  W is a sum of decaying exponentials (wave_poles.c), so that a step of any length at constant rates is one product for
  each of them: no history, no window. With a tolerance of 0 the rates of all steps are kept instead (wavehistory.c).
  While steps are longer than all that is remembered m is eta V, and nothing else is computed. The state (u, t) follows
  from a slot by going from its displacement to u at a constant rate.
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
    if (w->history)
      SlipWaveHistoryStep(w->history, &w->memory[m], h, oldest->step[m]);
    else
      SlipWaveMemoryTable(&w->memory[m], h, oldest->E[m], oldest->step[m]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The spectrum of u, which is often that of the state asked about last. Collective. */
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
  w->known = PETSC_TRUE;
  w->m_of = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* rate: of the way from a slot's displacement to that of which `slip` is the spectrum, in h */
static void RateOf(SlipWaves *w, const SlipWavePast *from, PetscReal h)
{
  const SlipWaveSpace s = w->space;
  const PetscReal inverse = 1 / h;

  for (PetscInt c = 0; c < s->modes * s->parts; c++) {
    const PetscReal *now = w->slip + c * s->stride, *before = from->slip + c * s->stride;
    PetscReal *rate = w->rate + c * s->stride;

    for (PetscInt i = 0; i < s->stride; i++) rate[i] = (now[i] - before[i]) * inverse;
  }
}

/* w->m: the sum of all kernels, by their weights, of sums [kernels][parts][stride], and with table != NULL of what slip
   adds on its way from a slot */
static void Sum(SlipWaves *w, const PetscReal sums[], const SlipWaveTable *table, const SlipWavePast *from, PetscReal h)
{
  const PetscInt stride = w->space->stride;

  for (PetscInt k = 0; k < w->kernels; k++)
    for (PetscInt p = 0; p < w->space->parts; p++) {
      const PetscInt field = w->memory[k].field, at = (field * w->space->parts + p) * stride;
      const PetscReal *sum = sums + (k * w->space->parts + p) * stride, *weight = w->memory[k].weight;
      const PetscReal *now = w->slip + at, *before = from->slip + at, *step = table ? table->step[k] : NULL;
      const PetscReal inverse = table ? 1 / h : 0;
      const PetscBool first = k == 0 || w->memory[k - 1].field != field ? PETSC_TRUE : PETSC_FALSE;
      PetscReal *m = w->m + at;

      for (PetscInt i = 0; i < stride; i++) {
        const PetscReal moved = table ? step[i] * ((now[i] - before[i]) * inverse) : 0;

        m[i] = (first ? 0 : m[i]) + weight[i] * (sum[i] + moved);
      }
    }
}

/* w->next: the sums of all kernels h after a slot, without slip */
static void Next(SlipWaves *w, SlipWavePast *from, PetscReal h, const SlipWaveTable *table)
{
  if (w->next_of == from && w->next_h == h) return;
  for (PetscInt k = 0; k < w->kernels; k++)
    if (w->history)
      SlipWaveHistorySum(w->history, &w->memory[k], from->steps, h, SlipWavesPart(w, w->next, k));
    else
      SlipWaveMemoryNext(&w->memory[k], table->E[k], from->z[k], SlipWavesPart(w, w->next, k));
  w->next_of = from;
  w->next_h = h;
}

/* w->m at the end of the way from a slot to that of which `slip` is the spectrum, in h */
static PetscErrorCode MemoryAfter(SlipWaves *w, SlipWavePast *from, PetscReal h)
{
  SlipWaveTable *table;

  PetscFunctionBegin;
  if (w->m_of == from && w->m_h == h) PetscFunctionReturn(PETSC_SUCCESS);
  w->m_of = from;
  w->m_h = h;
  if (!(h > 0)) {
    if (w->history) Next(w, from, 0, NULL);
    Sum(w, w->history ? w->next : from->now, NULL, from, h);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (h >= w->longest) {
    RateOf(w, from, h);
    PetscCall(PetscArraycpy(w->m, w->rate, SlipWavesNumbers(w)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!w->history) PetscCall(SlipWavesBegin(w, from));
  PetscCall(TableOf(w, h, &table));
  Next(w, from, h, table);
  Sum(w, w->next, table, from, h);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is slip on that way, or up to its start, known to be steady? */
static PetscBool IsSteady(const SlipWaves *w, const SlipWavePast *from, PetscReal h)
{
  return h >= w->longest || (!(h > 0) && from->steady) ? PETSC_TRUE : PETSC_FALSE;
}

/* ---- the operations ---- */

static PetscErrorCode Force_Waves(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  SlipElasticPast past;
  PetscInt slot;
  PetscBool steady = PETSC_FALSE;
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
  PetscCall(SlipElasticFindPast(el, t, &slot));
  if (slot < 0) {
    PetscCall(PetscArrayzero(w->m, SlipWavesNumbers(w)));
    w->m_of = NULL;
  } else {
    PetscCall(SlipElasticGetPast(el, slot, &past));
    steady = IsSteady(w, &w->both[w->of[slot]], t - past.t);
    PetscCall(MemoryAfter(w, &w->both[w->of[slot]], t - past.t));
  }
  for (PetscInt m = 0; m < w->space->modes; m++)
    for (PetscInt p = 0; p < w->space->parts; p++) {
      const PetscInt stride = w->space->stride, at = (m * w->space->parts + p) * stride;
      const PetscReal *k = w->stiffness + m * stride, *u = w->slip + at, *under_way = w->m + at;
      PetscReal *f = w->stress + at;

      for (PetscInt i = 0; i < stride; i++) f[i] = k[i] * u[i] - w->eta * under_way[i];
    }
  PetscCall(SlipWaveSpaceBackward(w->space, w->stress, shear));
  PetscCall(SlipWaveImagesSubtract(w->images, t, steady, u, shear));
  if (!v) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticGetWork(el, 1, &damping));
  PetscCall(SlipElasticForceStatic(el, t, NULL, v, damping, NULL));
  PetscCall(VecAXPY(shear, 1, damping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What exponentials remember at the end of the way from a slot to that of which `slip` is the spectrum, in h */
static PetscErrorCode AddExponentials(SlipWaves *w, SlipWavePast *before, SlipWavePast *after, PetscReal h)
{
  SlipWaveTable *table;

  PetscFunctionBegin;
  if (h >= w->longest) {
    RateOf(w, before, h);
    for (PetscInt m = 0; m < w->kernels; m++)
      PetscCall(PetscArraycpy(SlipWavesPart(w, after->now, m), SlipWavesPart(w, w->rate, w->memory[m].field),
                              w->space->parts * w->space->stride));
    after->steady = PETSC_TRUE;
  } else if (h > 0) {
    RateOf(w, before, h);
    PetscCall(SlipWavesBegin(w, before));
    after->steady = PETSC_FALSE;
    PetscCall(SlipWavesBegin(w, after));
    PetscCall(TableOf(w, h, &table));
    for (PetscInt m = 0; m < w->kernels; m++)
      SlipWaveMemoryAdvance(&w->memory[m], table->E[m], SlipWavesPart(w, w->rate, w->memory[m].field), before->z[m],
                            after->z[m], SlipWavesPart(w, after->now, m), SlipWavesPart(w, w->next, m));
  } else if (after != before) {
    after->steady = before->steady;
    PetscCall(PetscArraycpy(after->now, before->now, SlipWavesSums(w)));
    if (!before->steady) {
      PetscCall(SlipWavesBegin(w, after));
      for (PetscInt m = 0; m < w->kernels; m++)
        PetscCall(PetscArraycpy(after->z[m], before->z[m], SlipWaveMemorySize(&w->memory[m])));
    }
  }
  w->next_of = h > 0 && h < w->longest ? after : NULL;
  w->next_h = h;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same, of a history: another slot may be the start of this one */
static PetscErrorCode AddStep(SlipWaves *w, SlipWavePast *before, SlipWavePast *after, PetscReal h)
{
  SlipWavePast *other = &w->both[after == w->both];
  const PetscInt at = (PetscInt)(other - w->both);

  PetscFunctionBegin;
  if (h > 0) RateOf(w, before, h);
  after->steps = before->steps;
  after->steady = h > 0 ? (PetscBool)(h >= w->longest) : before->steady;
  if (w->of[0] != at && w->of[1] != at) other->steps = after->steps;
  if (h > 0) PetscCall(SlipWaveHistoryAdd(w->history, h, w->longest, w->rate, &after->steps, &other->steps));
  w->next_of = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Advance_Waves(SlipElastic el, PetscInt from, PetscInt to, PetscReal t, Vec u)
{
  SlipElasticPast past;
  SlipWavePast *before, *after;
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(Transform(w, u));
  w->m_of = NULL;
  if (from < 0) {
    w->of[to] = to;
    after = &w->both[to];
    after->steady = PETSC_TRUE;
    after->steps = 0;
    PetscCall(PetscArrayzero(after->now, SlipWavesSums(w)));
    PetscCall(SlipWaveImagesStart(w->images));
  } else {
    PetscCall(SlipElasticGetPast(el, from, &past));
    before = &w->both[w->of[from]];
    w->of[to] = from == to && w->of[1 - to] != w->of[from] ? w->of[from] : 1 - w->of[from];
    after = &w->both[w->of[to]];
    PetscCall(w->history ? AddStep(w, before, after, t - past.t) : AddExponentials(w, before, after, t - past.t));
  }
  if (from < 0) w->next_of = NULL;
  PetscCall(PetscArraycpy(after->slip, w->slip, SlipWavesNumbers(w)));
  PetscCall(SlipWaveImagesAdd(w->images, t, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Copy_Waves(SlipElastic el, PetscInt from, PetscInt to)
{
  SlipWaves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  w->of[to] = w->of[from];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* x.m of this process, of the displacement u at t and the field x: m what the waves under way add to the stress, the
   delay of images included */
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
  PetscCall(SlipWaveImagesWork(w->images, t, IsSteady(w, &w->both[w->of[slot]], t - past.t), u, x, work));
  PetscCall(Transform(w, u));
  PetscCall(MemoryAfter(w, &w->both[w->of[slot]], t - past.t));
  if (x != u) PetscCall(SlipWaveSpaceForward(w->space, x, w->rate));
  for (PetscInt c = 0; c < w->space->modes * w->space->parts; c++) {
    const PetscInt at = c * w->space->stride;
    const PetscReal *y = (x == u ? w->slip : w->rate) + at;

    for (PetscInt i = 0; i < w->space->n; i++) *work += w->space->share[i] * y[i] * w->eta * w->m[at + i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* u.m/2: what is stored is u.K u/2, of the stress K u - m */
static PetscErrorCode Energy_Waves(SlipElastic el, PetscReal t, Vec u, PetscReal *stored)
{
  PetscReal work;

  PetscFunctionBegin;
  PetscCall(Work(el, t, u, u, &work));
  *stored += 0.5 * work;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -v.m, which waves bring back of what the impedance takes */
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
                                        .copy = Copy_Waves,
                                        .shortest = Shortest_Waves,
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
