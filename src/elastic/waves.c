/*
  The medium "waves": a plane, or an antiplane line, that radiates. With T the load, K the static stiffness, d slip less
  loading and V its rate, friction is T - K d + m - eta V, eta = G/(2 cs), where the memory m is the stress of waves that
  are under way: of each wavenumber k and mode (G k/2) int W(k cs t') V(t - t') dt' (Geubelle & Rice 1995). On planes fields
  are band-limited, on lines slip is constant on cells, as in the static matrix: the stress at their centres has, beside
  k, the wavenumbers 2 pi/dx -+ k, which look the same there, with the amplitudes (G/dx) sin(k dx/2), as much and as
  little. All farther ones are in a factor of theirs by which steady slip meets no damping.

  W is a sum of decaying exponentials (wave_poles.c), so that a step of any length at a constant rate is one product for
  each of them: no history, no window. While steps are longer than all that is remembered m is eta V, and nothing else is
  computed. The state (u, t) follows from a slot by going from its displacement to u at a constant rate.
*/
#include <slipstep/private/slipwaves.h>
#include <slipstep/private/slipstate.h>

#define ALIASES 100 /* tolerance of wavenumbers that look like others, over that of these: smooth slip has hardly any */
#define FORGOTTEN 40 /* exp(-40) is no part of a number */
enum { TABLES = 4, KERNELS = 3 }; /* steps that were taken lately; kernels of a line */

/* Of a step of h */
typedef struct {
  PetscReal h; /* [s]; 0: none */
  PetscInt used;
  float *E[KERNELS]; /* of each kernel */
  PetscReal *step[KERNELS];
} Table;

/* What a slot has, which slots share until they differ */
typedef struct {
  float *z[KERNELS];     /* SlipWaveMemorySize(); not there while slip is steady */
  PetscReal *now;        /* [kernels][parts][stride] sum of Re b z */
  PetscReal *slip;       /* spectrum of u */
  PetscBool steady;      /* all z are those of the rate `now` */
} Memory;

typedef struct {
  SlipWaveSpace space;
  SlipWaveImages images;
  PetscInt kernels;
  SlipWaveMemory memory[KERNELS];
  PetscReal *stiffness; /* [modes][stride] of the periodic K [Pa/m] */
  PetscReal eta, cs, least, longest; /* G/(2 cs), the least step and the time after which all is forgotten [s] */
  Table table[TABLES];
  PetscInt clock;
  Memory both[2];
  PetscInt of[2];    /* which of these a slot has */
  PetscReal *next;   /* as `now`, of next_of after next_h without slip */
  PetscReal next_h;
  const Memory *next_of;
  PetscReal *slip, *rate, *stress; /* spectra, at work */
  Vec last;                        /* of which `slip` is the spectrum */
  PetscBool known;
} Waves;

static size_t Numbers(const Waves *w)
{
  return (size_t)w->space->modes * w->space->parts * w->space->stride;
}

/* Of a field of a spectrum, or a kernel of what is remembered */
static PetscReal *Part(const Waves *w, PetscReal numbers[], PetscInt k)
{
  return numbers + (size_t)k * w->space->parts * w->space->stride;
}

static size_t SumNumbers(const Waves *w)
{
  return (size_t)w->kernels * w->space->parts * w->space->stride;
}

/* Zero, free with fftw_free() */
static PetscErrorCode AllocateSingle(size_t count, float **a)
{
  PetscReal *room;

  PetscFunctionBegin;
  PetscCall(SlipAllocate((count + 1) / 2, &room));
  *a = (float *)room;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- steps ---- */

static PetscErrorCode TableOf(Waves *w, PetscReal h, Table **table)
{
  Table *oldest = w->table;

  PetscFunctionBegin;
  w->clock++;
  for (PetscInt i = 0; i < TABLES; i++) {
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
      PetscCall(AllocateSingle((size_t)2 * w->memory[m].poles.n * w->space->stride, &oldest->E[m]));
      PetscCall(SlipAllocate((size_t)w->space->stride, &oldest->step[m]));
    }
    SlipWaveMemoryTable(&w->memory[m], h, oldest->E[m], oldest->step[m]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* z of steady slip, before a step that remembers some of it */
static PetscErrorCode Begin(Waves *w, Memory *memory)
{
  PetscFunctionBegin;
  for (PetscInt m = 0; m < w->kernels; m++)
    if (!memory->z[m]) PetscCall(AllocateSingle(SlipWaveMemorySize(&w->memory[m]), &memory->z[m]));
  if (!memory->steady) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt m = 0; m < w->kernels; m++)
    SlipWaveMemorySteady(&w->memory[m], Part(w, memory->now, m), memory->z[m]);
  memory->steady = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The spectrum of u, which is often that of the state asked about last. Collective. */
static PetscErrorCode Transform(Waves *w, Vec u)
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* rate: of the way from a slot's displacement to that of which `slip` is the spectrum, in h; of k = 0 there are no waves
   but those of the impedance */
static void RateOf(Waves *w, const Memory *from, PetscReal h)
{
  const SlipWaveSpace s = w->space;
  const PetscReal inverse = 1 / h;

  for (PetscInt c = 0; c < s->modes * s->parts; c++) {
    const PetscReal *now = w->slip + c * s->stride, *before = from->slip + c * s->stride;
    PetscReal *rate = w->rate + c * s->stride;

    for (PetscInt i = 0; i < s->stride; i++) rate[i] = (now[i] - before[i]) * inverse;
  }
}

/* x = the sum of all kernels, by their weights */
static PetscErrorCode Sum(Waves *w, const PetscReal sums[], PetscReal x[])
{
  const PetscInt stride = w->space->stride;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(x, Numbers(w)));
  for (PetscInt m = 0; m < w->kernels; m++) {
    const PetscReal *sum = sums + (size_t)m * w->space->parts * stride;
    PetscReal *y = Part(w, x, w->memory[m].field);

    for (PetscInt p = 0; p < w->space->parts; p++)
      for (PetscInt i = 0; i < stride; i++) y[p * stride + i] += w->memory[m].weight[i] * sum[p * stride + i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* stress: m/eta at the end of that way */
static PetscErrorCode MemoryAfter(Waves *w, Memory *from, PetscReal h)
{
  const PetscInt stride = w->space->stride;
  Table *table;

  PetscFunctionBegin;
  if (!(h > 0)) {
    PetscCall(Sum(w, from->now, w->stress));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  RateOf(w, from, h);
  if (h >= w->longest) {
    PetscCall(PetscArraycpy(w->stress, w->rate, Numbers(w)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Begin(w, from));
  PetscCall(TableOf(w, h, &table));
  for (PetscInt m = 0; m < w->kernels && (w->next_of != from || w->next_h != h); m++)
    SlipWaveMemoryNext(&w->memory[m], table->E[m], from->z[m], Part(w, w->next, m));
  w->next_of = from;
  w->next_h = h;
  PetscCall(Sum(w, w->next, w->stress));
  for (PetscInt m = 0; m < w->kernels; m++) {
    const PetscReal *rate = Part(w, w->rate, w->memory[m].field), *step = table->step[m], *weight = w->memory[m].weight;
    PetscReal *y = Part(w, w->stress, w->memory[m].field);

    for (PetscInt p = 0; p < w->space->parts; p++)
      for (PetscInt i = 0; i < stride; i++) y[p * stride + i] += weight[i] * step[i] * rate[p * stride + i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the operations ---- */

static PetscErrorCode Force_Waves(SlipElastic el, PetscReal t, Vec u, Vec v, Vec shear, Vec normal)
{
  SlipElasticPast past;
  PetscInt slot;
  Waves *w;
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
    PetscCall(PetscArrayzero(w->stress, Numbers(w)));
  } else {
    PetscCall(SlipElasticGetPast(el, slot, &past));
    PetscCall(MemoryAfter(w, &w->both[w->of[slot]], t - past.t));
  }
  for (PetscInt m = 0; m < w->space->modes; m++)
    for (PetscInt p = 0; p < w->space->parts; p++) {
      const PetscInt stride = w->space->stride, at = (m * w->space->parts + p) * stride;
      const PetscReal *k = w->stiffness + m * stride, *u = w->slip + at;
      PetscReal *f = w->stress + at;

      for (PetscInt i = 0; i < stride; i++) f[i] = k[i] * u[i] - w->eta * f[i];
    }
  PetscCall(SlipWaveSpaceBackward(w->space, w->stress, shear));
  PetscCall(SlipWaveImagesSubtract(w->images, t, u, shear));
  if (!v) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticGetWork(el, 1, &damping));
  PetscCall(SlipElasticForceStatic(el, t, NULL, v, damping, NULL));
  PetscCall(VecAXPY(shear, 1, damping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Advance_Waves(SlipElastic el, PetscInt from, PetscInt to, PetscReal t, Vec u)
{
  SlipElasticPast past;
  Memory *before, *after;
  PetscReal h;
  Table *table;
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(Transform(w, u));
  if (from < 0) {
    w->of[to] = to;
    after = &w->both[to];
    after->steady = PETSC_TRUE;
    PetscCall(PetscArrayzero(after->now, SumNumbers(w)));
    PetscCall(SlipWaveImagesStart(w->images));
  } else {
    PetscCall(SlipElasticGetPast(el, from, &past));
    h = t - past.t;
    before = &w->both[w->of[from]];
    w->of[to] = from == to && w->of[1 - to] != w->of[from] ? w->of[from] : 1 - w->of[from];
    after = &w->both[w->of[to]];
    if (h >= w->longest) {
      RateOf(w, before, h);
      for (PetscInt m = 0; m < w->kernels; m++)
        PetscCall(PetscArraycpy(Part(w, after->now, m), Part(w, w->rate, w->memory[m].field),
                                w->space->parts * w->space->stride));
      after->steady = PETSC_TRUE;
    } else if (h > 0) {
      RateOf(w, before, h);
      PetscCall(Begin(w, before));
      after->steady = PETSC_FALSE;
      PetscCall(Begin(w, after));
      PetscCall(TableOf(w, h, &table));
      for (PetscInt m = 0; m < w->kernels; m++)
        SlipWaveMemoryAdvance(&w->memory[m], table->E[m], Part(w, w->rate, w->memory[m].field), before->z[m], after->z[m],
                              Part(w, after->now, m), Part(w, w->next, m));
    } else if (after != before) {
      after->steady = before->steady;
      PetscCall(PetscArraycpy(after->now, before->now, SumNumbers(w)));
      if (!before->steady) {
        PetscCall(Begin(w, after));
        for (PetscInt m = 0; m < w->kernels; m++)
          PetscCall(PetscArraycpy(after->z[m], before->z[m], SlipWaveMemorySize(&w->memory[m])));
      }
    }
    w->next_of = h > 0 && h < w->longest ? after : NULL;
    w->next_h = h;
  }
  if (from < 0) w->next_of = NULL;
  PetscCall(PetscArraycpy(after->slip, w->slip, Numbers(w)));
  PetscCall(SlipWaveImagesAdd(w->images, t, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Copy_Waves(SlipElastic el, PetscInt from, PetscInt to)
{
  Waves *w;

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
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  *work = 0;
  PetscCall(SlipElasticFindPast(el, t, &slot));
  if (slot < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipElasticGetPast(el, slot, &past));
  PetscCall(SlipWaveImagesWork(w->images, t, u, x, work));
  PetscCall(Transform(w, u));
  PetscCall(MemoryAfter(w, &w->both[w->of[slot]], t - past.t));
  if (x != u) PetscCall(SlipWaveSpaceForward(w->space, x, w->rate));
  for (PetscInt c = 0; c < w->space->modes * w->space->parts; c++) {
    const PetscInt at = c * w->space->stride;
    const PetscReal *y = (x == u ? w->slip : w->rate) + at;

    for (PetscInt i = 0; i < w->space->n; i++) *work += w->space->share[i] * y[i] * w->eta * w->stress[at + i];
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
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  *step = w->least;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- set-up ---- */

/* What a plane has to be for it */
static PetscErrorCode Check(SlipElastic el, const SlipElasticRock *rock)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)el);
  const char *prefix = ((PetscObject)el)->prefix ? ((PetscObject)el)->prefix : "";
  const SlipElasticGrid *g = rock->grid;

  PetscFunctionBegin;
  PetscCheck(g, comm, PETSC_ERR_SUP,
             "-%sfault_medium waves is of one plane with equal cells: expected a uniform grid without -%sfault_mesh and "
             "-%sfault_stiffness_file",
             prefix, prefix, prefix);
  PetscCheck(!rock->inertia && !strcmp(rock->viscosity, "radiation") && rock->across == 0 && !el->Kn, comm, PETSC_ERR_SUP,
             "-%sfault_medium waves: expected radiation damping, and neither inertia, opening, nor slip that changes normal "
             "stress",
             prefix);
  if (g->nx == 1) {
    const PetscReal depth = g->size[1] * (PetscReal)g->nz;

    PetscCheck(g->size[0] >= SLIP_WAVE_ENDLESS * depth, comm, PETSC_ERR_SUP,
               "-%sfault_medium waves of one column of cells is an antiplane line: expected -%sfault_length_x of at least "
               "%g times -%sfault_length_z, not %g m",
               prefix, prefix, (double)SLIP_WAVE_ENDLESS, prefix, (double)g->size[0]);
    PetscCheck(rock->components == 1, comm, PETSC_ERR_SUP,
               "-%sfault_medium waves of an antiplane line: expected -%sfault_slip_components 1", prefix, prefix);
    PetscCheck(g->full_space || g->depth_top == 0, comm, PETSC_ERR_SUP,
               "-%sfault_medium waves of a line reaches the ground or has none: expected -%sfault_depth_top 0, not %g m, "
               "or -%sfault_kernel full_space",
               prefix, prefix, (double)g->depth_top, prefix);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(g->full_space, comm, PETSC_ERR_SUP,
             "-%sfault_medium waves of a plane knows no ground, which reflects waves: expected -%sfault_kernel full_space, "
             "or an antiplane line (-%sfault_nx 1)",
             prefix, prefix, prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The slowest decay and the longest wave say after which time all is forgotten */
static PetscErrorCode Longest(Waves *w)
{
  PetscReal slowest = PETSC_MAX_REAL, k = PETSC_MAX_REAL;

  PetscFunctionBegin;
  for (PetscInt m = 0; m < w->kernels; m++)
    for (PetscInt j = 0; j < w->memory[m].poles.n; j++) slowest = PetscMin(slowest, -w->memory[m].poles.s[2 * j]);
  for (PetscInt i = 0; i < w->space->n; i++)
    if (w->space->k[i] > 0) k = PetscMin(k, w->space->k[i]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &k, 1, MPIU_REAL, MPIU_MIN, w->space->comm));
  w->longest = FORGOTTEN / (slowest * k * w->cs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of a plane mode II and mode III; of a line k, and 2 pi/dx -+ k, see above */
static PetscErrorCode SetUpKernels(Waves *w, PetscReal ratio, PetscReal tolerance)
{
  const SlipWaveSpace s = w->space;
  const PetscReal dx = s->grid.size[1], all = 2 * (PetscReal)PETSC_PI / dx;

  PetscFunctionBegin;
  w->kernels = s->line ? KERNELS : 2;
  PetscCall(PetscMalloc1((size_t)s->modes * s->stride, &w->stiffness));
  for (PetscInt m = 0; m < w->kernels; m++) {
    const SlipWaveMode mode = s->line || m == 1 ? SLIP_WAVE_ANTIPLANE : SLIP_WAVE_INPLANE;

    PetscCall(SlipWaveMemoryCreate(s, mode, s->line ? 0 : m, ratio, w->cs, s->line && m ? PetscMin(ALIASES * tolerance, 0.1) : tolerance,
                                   &w->memory[m]));
    for (PetscInt i = 0; i < s->stride && !s->line; i++)
      w->stiffness[m * s->stride + i] = w->eta * w->cs * s->k[i] * SlipWaveStatic(mode, ratio);
  }
  for (PetscInt i = 0; i < s->stride && s->line; i++) {
    const PetscReal k = s->k[i], half = k * dx / 2;
    const PetscReal share = half > 0 ? PetscSinReal(half) / half : 1, amplitude = (1 - share) / (1 / (all - k) - 1 / (all + k));

    w->stiffness[i] = w->eta * w->cs * k * share;
    w->memory[0].weight[i] = share;
    if (half == 0) continue;
    w->memory[1].k[i] = all - k;
    w->memory[1].weight[i] = amplitude / (all - k);
    w->memory[2].k[i] = all + k;
    w->memory[2].weight[i] = -amplitude / (all + k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp_Waves(SlipElastic el, const SlipElasticRock *rock)
{
  const PetscReal ratio = PetscSqrtReal(2 * (1 - rock->poisson_ratio) / (1 - 2 * rock->poisson_ratio));
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  PetscCall(Check(el, rock));
  w->eta = rock->impedance;
  w->cs = PetscSqrtReal(rock->shear_modulus / rock->density);
  PetscCall(SlipWaveSpaceCreate(el->K, rock, &w->space));
  PetscCall(SlipWaveImagesCreate(w->space, rock, &w->images));
  PetscCall(SetUpKernels(w, ratio, rock->waves_tolerance));
  for (int b = 0; b < 2; b++) {
    PetscCall(SlipAllocate(SumNumbers(w), &w->both[b].now));
    PetscCall(SlipAllocate(Numbers(w), &w->both[b].slip));
    w->both[b].steady = PETSC_TRUE;
  }
  PetscReal **const spectra[] = {&w->slip, &w->rate, &w->stress};
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(spectra); i++) PetscCall(SlipAllocate(Numbers(w), spectra[i]));
  PetscCall(SlipAllocate(SumNumbers(w), &w->next));
  PetscCall(MatCreateVecs(el->K, &w->last, NULL));
  PetscCall(Longest(w));
  w->least = w->space->line ? w->space->grid.size[1] / (2 * w->cs)
                            : PetscMin(w->space->grid.size[0], w->space->grid.size[1]) / (3 * w->cs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints and views ---- */

/* What a wavenumber has in a checkpoint, by whichever process: `now`, `slip`, `next`, and all z */
static PetscInt PerWave(const Waves *w)
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
static void Exchange(Waves *w, Memory *memory, PetscInt i, PetscBool loading, PetscReal *x)
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

static PetscErrorCode VisitMemory(Waves *w, SlipState state, const char name[], Memory *memory)
{
  const PetscBool loading = SlipStateIsLoading(state), steady = memory->steady;
  const PetscInt per = PerWave(w);
  PetscReal *a;
  Vec x;

  PetscFunctionBegin;
  PetscCall(Begin(w, memory)); /* steady slip is written as what it leaves, too */
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

static PetscErrorCode Visit_Waves(SlipElastic el, SlipState state)
{
  static const char *const names[] = {"waves_before", "waves"}, *const flags[] = {"steady_before", "steady"};
  const PetscBool loading = SlipStateIsLoading(state);
  PetscBool shared, follows;
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  shared = w->of[0] == w->of[1] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateBool(state, "shared", &shared));
  if (loading) {
    w->of[1] = 1;
    w->of[0] = shared ? 1 : 0;
    w->known = PETSC_FALSE;
  }
  follows = w->next_of == &w->both[w->of[1]] ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateBool(state, "next", &follows));
  PetscCall(SlipStateReal(state, "next_step", 1, &w->next_h));
  w->next_of = follows ? &w->both[w->of[1]] : NULL;
  for (int slot = shared ? 1 : 0; slot < 2; slot++) {
    Memory *memory = &w->both[w->of[slot]];

    PetscCall(SlipStateBool(state, flags[slot], &memory->steady));
    PetscCall(VisitMemory(w, state, names[slot], memory));
  }
  PetscCall(SlipWaveImagesVisit(w->images, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode View_Waves(SlipElastic el, PetscViewer viewer)
{
  PetscReal bytes = 0;
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  for (PetscInt m = 0; m < w->kernels; m++)
    bytes += (PetscReal)sizeof(float) *
             (PetscReal)(2 * SlipWaveMemorySize(&w->memory[m]) + (size_t)2 * w->memory[m].poles.n * w->space->stride);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPIU_REAL, MPIU_SUM, w->space->comm));
  PetscCall(PetscViewerASCIIPrintf(
    viewer, "waves: %s, period %" PetscInt_FMT " x %" PetscInt_FMT " cells, shortest step %.3g s, memory %.3g MB\n",
    w->space->line ? (w->space->mirror ? "antiplane line up to the ground" : "antiplane line in a full space")
                   : "plane in a full space",
    w->space->length[0], w->space->length[1], (double)w->least, (double)bytes / 1e6));
  for (PetscInt m = 0; m < w->space->modes; m++)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  mode %s: %" PetscInt_FMT " exponentials, error %.1e\n",
                                     w->memory[m].mode == SLIP_WAVE_INPLANE ? "II" : "III", w->memory[m].poles.n,
                                     (double)w->memory[m].poles.error));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy_Waves(SlipElastic el)
{
  Waves *w;

  PetscFunctionBegin;
  PetscCall(SlipElasticGetData(el, &w));
  for (int b = 0; b < 2; b++) {
    for (int m = 0; m < KERNELS; m++) fftw_free(w->both[b].z[m]);
    fftw_free(w->both[b].now);
    fftw_free(w->both[b].slip);
  }
  for (int i = 0; i < TABLES; i++)
    for (int m = 0; m < KERNELS; m++) {
      fftw_free(w->table[i].E[m]);
      fftw_free(w->table[i].step[m]);
    }
  fftw_free(w->next);
  fftw_free(w->slip);
  fftw_free(w->rate);
  fftw_free(w->stress);
  PetscCall(PetscFree(w->stiffness));
  for (PetscInt m = 0; m < w->kernels; m++) PetscCall(SlipWaveMemoryDestroy(&w->memory[m]));
  PetscCall(SlipWaveImagesDestroy(&w->images));
  PetscCall(SlipWaveSpaceDestroy(&w->space));
  PetscCall(VecDestroy(&w->last));
  PetscCall(PetscFree(w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipElasticOps WavesOps = {.setup = SetUp_Waves,
                                        .force = Force_Waves,
                                        .energy = Energy_Waves,
                                        .power = Power_Waves,
                                        .advance = Advance_Waves,
                                        .copy = Copy_Waves,
                                        .shortest = Shortest_Waves,
                                        .visit = Visit_Waves,
                                        .view = View_Waves,
                                        .destroy = Destroy_Waves};

PetscErrorCode SlipElasticCreate_Waves(SlipElastic el)
{
  Waves *w;

  PetscFunctionBegin;
  PetscCall(PetscNew(&w));
  PetscCall(SlipElasticSetOps(el, &WavesOps, w));
  PetscFunctionReturn(PETSC_SUCCESS);
}
