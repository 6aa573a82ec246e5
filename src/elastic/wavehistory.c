/*
  The rates of all steps, in place of exponentials: what these are checked against, slow and large. Of a wavenumber k

     (1/V) int_0^h W(k cs t') V k cs dt' = I(k cs h),   I(T) = int_0^T W,

  so that steps n at constant rates, from which times b_n > e_n have gone by since they began and ended, leave
  sum V_n [I(k cs b_n) - I(k cs e_n)]. I comes from a table, and is 1 beyond it: 3e-6 off in
  mode III, and 1e-2 in mode II, where W of a wavenumber falls as T^-1/2; slip of all wavenumbers has no more of it.
*/
#include <slipstep/private/slipwavespace.h>
#include <slipstep/private/slipstate.h>

#define SPACING 0.05 /* of the table: cubics between its points are off by 2e-8 */
enum { POINTS = 80001 };
#define FARTHEST ((POINTS - 1) * (PetscReal)SPACING)

/* [POINTS][2]: I and its slope W, by Simpson's rule */
static PetscErrorCode Tabulate(SlipWaveMode mode, PetscReal ratio, PetscReal **table)
{
  PetscReal *T, *W, sum = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(2 * POINTS - 1, &T, 2 * POINTS - 1, &W));
  PetscCall(PetscMalloc1(2 * POINTS, table));
  for (PetscInt i = 0; i < 2 * POINTS - 1; i++) T[i] = (PetscReal)(SPACING / 2) * (PetscReal)i;
  PetscCall(SlipWaveKernel(mode, ratio, 2 * POINTS - 1, T, W));
  for (PetscInt i = 0; i < POINTS; i++) {
    if (i) sum += (PetscReal)SPACING / 6 * (W[2 * i - 2] + 4 * W[2 * i - 1] + W[2 * i]);
    (*table)[2 * i] = sum;
    (*table)[2 * i + 1] = (PetscReal)SPACING * W[2 * i];
  }
  PetscCall(PetscFree2(T, W));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Integral(const PetscReal table[], PetscReal T)
{
  const PetscReal at = T / (PetscReal)SPACING;
  const PetscInt i = (PetscInt)PetscMin(at, (PetscReal)POINTS);
  const PetscReal x = at - (PetscReal)i, *p = table + 2 * i;

  if (i >= POINTS - 1) return 1;
  return p[0] + x * (p[1] + x * (3 * (p[2] - p[0]) - 2 * p[1] - p[3] + x * (2 * (p[0] - p[2]) + p[1] + p[3])));
}

PetscErrorCode SlipWaveHistoryCreate(SlipWaveSpace space, PetscReal ratio, SlipWaveHistory *history)
{
  SlipWaveHistory w;

  PetscFunctionBegin;
  PetscCall(PetscNew(&w));
  *history = w;
  w->numbers = (size_t)space->modes * space->parts * space->stride;
  PetscCall(Tabulate(SLIP_WAVE_ANTIPLANE, ratio, &w->table[SLIP_WAVE_ANTIPLANE]));
  if (!space->line) PetscCall(Tabulate(SLIP_WAVE_INPLANE, ratio, &w->table[SLIP_WAVE_INPLANE]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveHistoryDestroy(SlipWaveHistory *history)
{
  SlipWaveHistory w = *history;

  PetscFunctionBegin;
  if (!w) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(w->table[0]));
  PetscCall(PetscFree(w->table[1]));
  PetscCall(PetscFree(w->end));
  PetscCall(PetscFree(w->rate));
  PetscCall(PetscFree(w));
  *history = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After which nothing is left of a wavenumber */
PetscReal SlipWaveHistoryLongest(PetscReal k, PetscReal cs)
{
  return FARTHEST / (k * cs);
}

PetscErrorCode SlipWaveHistoryReserve(SlipWaveHistory w, PetscInt n)
{
  const PetscInt size = PetscMax(2 * w->size, n);

  PetscFunctionBegin;
  if (n <= w->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)size, &w->end));
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)size * w->numbers, &w->rate));
  w->size = size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One more step of h; what is older than the longest memory is forgotten */
PetscErrorCode SlipWaveHistoryAdd(SlipWaveHistory w, PetscReal h, PetscReal longest, const PetscReal rate[])
{
  const PetscReal start = w->steps ? w->end[w->steps - 1] : 0;
  PetscInt old = 0;

  PetscFunctionBegin;
  while (old + 1 < w->steps && w->end[old] < start - longest) old++;
  if (old > w->steps / 2) {
    PetscCall(PetscArraymove(w->end, w->end + old, w->steps - old));
    PetscCall(PetscArraymove(w->rate, w->rate + (size_t)old * w->numbers, (size_t)(w->steps - old) * w->numbers));
    w->steps -= old;
  }
  PetscCall(SlipWaveHistoryReserve(w, w->steps + 1));
  w->end[w->steps] = start + h;
  PetscCall(PetscArraycpy(w->rate + (size_t)w->steps * w->numbers, rate, w->numbers));
  w->steps++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What a kernel has of all steps, a time h after the last of them without slip: sum [parts][stride]. What was before
   the first has been at rest. */
void SlipWaveHistorySum(SlipWaveHistory w, const SlipWaveMemory *m, PetscReal h, PetscReal sum[])
{
  const PetscInt steps = w->steps;
  const PetscReal *table = w->table[m->mode], now = (steps ? w->end[steps - 1] : 0) + h;

  for (PetscInt i = 0; i < m->stride; i++) {
    const PetscReal factor = m->k[i] * m->cs;
    const PetscReal *rate = w->rate + (size_t)m->field * m->parts * m->stride + i;
    PetscReal later = Integral(table, factor * h);

    for (PetscInt p = 0; p < m->parts; p++) sum[p * m->stride + i] = 0;
    for (PetscInt n = steps - 1; n >= 0 && factor > 0 && factor * (now - w->end[n]) < FARTHEST; n--) {
      const PetscReal all = Integral(table, factor * (now - (n ? w->end[n - 1] : 0)));

      for (PetscInt p = 0; p < m->parts; p++)
        sum[p * m->stride + i] += rate[(size_t)n * w->numbers + p * m->stride] * (all - later);
      later = all;
    }
  }
}

/* Of slip at a rate of 1 for a time h: step [stride] */
void SlipWaveHistoryStep(SlipWaveHistory w, const SlipWaveMemory *m, PetscReal h, PetscReal step[])
{
  for (PetscInt i = 0; i < m->stride; i++) step[i] = Integral(w->table[m->mode], m->k[i] * m->cs * h);
}

/* n waves of this process, each with its fields of all steps */
PetscErrorCode SlipWaveHistoryVisit(SlipWaveHistory w, SlipWaveSpace s, SlipState state)
{
  const PetscBool loading = SlipStateIsLoading(state);
  const PetscInt fields = s->modes * s->parts;
  PetscInt steps, per;
  PetscReal *a;
  Vec x;

  PetscFunctionBegin;
  PetscCall(SlipStateInt(state, "history_steps", 1, &w->steps));
  steps = w->steps;
  per = steps * fields;
  PetscCall(SlipWaveHistoryReserve(w, steps));
  if (!steps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateReal(state, "history_end", steps, w->end));
  PetscCall(VecCreateMPI(s->comm, per * s->n, PETSC_DETERMINE, &x));
  for (int back = 0; back < 2; back++) {
    if (back) PetscCall(SlipStateVec(state, "history", x));
    if (back != (int)loading) continue;
    PetscCall(VecGetArray(x, &a));
    for (PetscInt i = 0; i < s->n; i++)
      for (PetscInt n = 0; n < steps; n++)
        for (PetscInt c = 0; c < fields; c++) {
          PetscReal *here = w->rate + (size_t)n * w->numbers + c * s->stride + i, *there = a + i * per + n * fields + c;

          if (loading)
            *here = *there;
          else
            *there = *here;
        }
    PetscCall(VecRestoreArray(x, &a));
  }
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
