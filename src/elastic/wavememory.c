/*
  The stored effect of earlier slip on a plane. Each wavenumber k and each exponential s_j of its kernel has a number
  z_j = s_j int exp(s_j k cs t') V(t - t') k cs dt'; the stress of waves under way is eta sum Re (a_j/s_j) z_j with
  eta = G/(2 cs). In a step h at a constant slip rate V, z becomes e (z + V) - V with e = exp(s_j k cs h), which is
  exact for any length of the step; steady slip has z = -V, for which the sum is V.

  Wavenumbers form blocks, whose exponentials are stored together, so that a step reads the memory once and in order.
  Numbers are in single precision, which is as accurate as the poles, because reading them takes most of the time.
*/
#include <slipstep/private/slipwavespace.h>
#include <stdlib.h>
#include <slipstep/private/slipwork.h>

#define B SLIP_WAVE_BLOCK
#define LEAST 1e-20 /* smaller exponentials are set to 0 */

/* Creates the memory of the space's wavenumbers with weights of 1; the caller may change both. Tolerance 0: no poles */
PetscErrorCode SlipWaveMemoryCreate(SlipWaveSpace space, SlipWaveMode mode, PetscInt field, PetscReal ratio,
                                    PetscReal cs, PetscReal tolerance, SlipWaveMemory *m)
{
  PetscFunctionBegin;
  *m = (SlipWaveMemory){
    .mode = mode, .field = field, .parts = space->parts, .n = space->n, .stride = space->stride, .cs = cs};
  PetscCall(PetscMalloc2(space->stride, &m->k, space->stride, &m->weight));
  PetscCall(PetscArraycpy(m->k, space->k, space->stride));
  for (PetscInt i = 0; i < space->stride; i++) m->weight[i] = 1;
  if (tolerance == 0) PetscFunctionReturn(PETSC_SUCCESS);
  SlipWorkAdd(SLIP_WORK_FIT, 1);
  PetscCall(SlipWavePolesCreate(mode, ratio, tolerance, &m->poles));
  PetscCall(PetscMalloc1(2 * m->poles.n, &m->b));
  for (PetscInt j = 0; j < m->poles.n; j++) {
    const PetscReal *s = m->poles.s + 2 * j, *a = m->poles.a + 2 * j, square = s[0] * s[0] + s[1] * s[1];

    m->b[2 * j] = (a[0] * s[0] + a[1] * s[1]) / square;
    m->b[2 * j + 1] = (a[1] * s[0] - a[0] * s[1]) / square;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipWaveMemoryDestroy(SlipWaveMemory *m)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(m->k, m->weight));
  PetscCall(PetscFree(m->b));
  PetscCall(SlipWavePolesDestroy(&m->poles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

size_t SlipWaveMemorySize(const SlipWaveMemory *m)
{
  return (size_t)2 * m->poles.n * m->parts * m->stride;
}

void SlipWaveMemoryTable(const SlipWaveMemory *m, PetscReal h, float E[], PetscReal step[])
{
  SlipWorkAdd(SLIP_WORK_DECAY, (PetscReal)(m->stride * m->poles.n));
  for (PetscInt i = 0; i < m->stride; i += B) {
    for (PetscInt l = 0; l < B; l++) step[i + l] = 0;
    for (PetscInt j = 0; j < m->poles.n; j++) {
      const PetscReal *s = m->poles.s + 2 * j, *b = m->b + 2 * j;
      float *e = E + 2 * (i * m->poles.n + j * B);

      for (PetscInt l = 0; l < B; l++) {
        const PetscReal T = m->k[i + l] * m->cs * h, grown = PetscExpReal(s[0] * T), turn = s[1] * T;

        e[l] = grown > LEAST ? (float)(grown * PetscCosReal(turn)) : 0;
        e[B + l] = grown > LEAST ? (float)(grown * PetscSinReal(turn)) : 0;
        step[i + l] += b[0] * ((PetscReal)e[l] - 1) - b[1] * (PetscReal)e[B + l];
      }
    }
  }
}

/* One block. The number of parts is a constant of the caller, so that the compiler holds the sums in registers. */
static inline __attribute__((always_inline)) void NextBlock(PetscInt parts, PetscInt poles, const PetscReal b[],
                                                            const float *restrict e, const float *restrict z,
                                                            float sum[])
{
  for (PetscInt j = 0; j < poles; j++, e += 2 * B, z += 2 * B * parts) {
    const float br = (float)b[2 * j], bi = (float)b[2 * j + 1];

    for (PetscInt p = 0; p < parts; p++)
      for (PetscInt l = 0; l < B; l++) {
        const float xr = z[2 * p * B + l], xi = z[(2 * p + 1) * B + l];

        sum[p * B + l] += br * (e[l] * xr - e[B + l] * xi) - bi * (e[l] * xi + e[B + l] * xr);
      }
  }
}

static inline __attribute__((always_inline)) void AdvanceBlock(PetscInt parts, PetscInt poles, const PetscReal b[],
                                                               const float *restrict e, const float rate[],
                                                               float *restrict z, float sum[], float then[])
{
  for (PetscInt j = 0; j < poles; j++, e += 2 * B, z += 2 * B * parts) {
    const float br = (float)b[2 * j], bi = (float)b[2 * j + 1];

    for (PetscInt p = 0; p < parts; p++)
      for (PetscInt l = 0; l < B; l++) {
        const float xi = z[(2 * p + 1) * B + l], real = z[2 * p * B + l] + rate[p * B + l],
                    yr = e[l] * real - e[B + l] * xi - rate[p * B + l], yi = e[l] * xi + e[B + l] * real;

        z[2 * p * B + l] = yr;
        z[(2 * p + 1) * B + l] = yi;
        sum[p * B + l] += br * yr - bi * yi;
        then[p * B + l] += br * (e[l] * yr - e[B + l] * yi) - bi * (e[l] * yi + e[B + l] * yr);
      }
  }
}

SLIP_VECTOR void SlipWaveMemoryNext(const SlipWaveMemory *m, const float E[], const float z[], PetscReal next[])
{
  const PetscInt poles = m->poles.n, parts = m->parts;

  SlipWorkAdd(SLIP_WORK_MEMORY, (PetscReal)(m->stride * poles * parts));
  for (PetscInt i = 0; i < m->stride; i += B) {
    const float *e = E + (size_t)2 * i * poles, *x = z + (size_t)2 * i * poles * parts;
    float sum[4 * B] = {0};

    if (parts == 4)
      NextBlock(4, poles, m->b, e, x, sum);
    else if (parts == 2)
      NextBlock(2, poles, m->b, e, x, sum);
    else
      NextBlock(1, poles, m->b, e, x, sum);
    for (PetscInt p = 0; p < parts; p++)
      for (PetscInt l = 0; l < B; l++) next[p * m->stride + i + l] = (PetscReal)sum[p * B + l];
  }
}

SLIP_VECTOR void SlipWaveMemoryAdvance(const SlipWaveMemory *m, const float E[], const PetscReal V[], float z[],
                                       PetscReal now[], PetscReal next[])
{
  const PetscInt poles = m->poles.n, parts = m->parts;

  SlipWorkAdd(SLIP_WORK_MEMORY, 2 * (PetscReal)(m->stride * poles * parts));
  for (PetscInt i = 0; i < m->stride; i += B) {
    const float *e = E + (size_t)2 * i * poles;
    float *x = z + (size_t)2 * i * poles * parts;
    float rate[4 * B], sum[4 * B] = {0}, then[4 * B] = {0};

    for (PetscInt p = 0; p < parts; p++)
      for (PetscInt l = 0; l < B; l++) rate[p * B + l] = (float)V[p * m->stride + i + l];
    if (parts == 4)
      AdvanceBlock(4, poles, m->b, e, rate, x, sum, then);
    else if (parts == 2)
      AdvanceBlock(2, poles, m->b, e, rate, x, sum, then);
    else
      AdvanceBlock(1, poles, m->b, e, rate, x, sum, then);
    for (PetscInt p = 0; p < parts; p++)
      for (PetscInt l = 0; l < B; l++) {
        now[p * m->stride + i + l] = (PetscReal)sum[p * B + l];
        next[p * m->stride + i + l] = (PetscReal)then[p * B + l];
      }
  }
}

/* Sets z to that of slip which has always been steady; the wavenumber k = 0 has no memory. */
void SlipWaveMemorySteady(const SlipWaveMemory *m, const PetscReal V[], float z[])
{
  for (PetscInt i = 0; i < m->stride; i += B)
    for (PetscInt p = 0; p < m->parts; p++)
      for (PetscInt j = 0; j < m->poles.n; j++) {
        float *x = z + 2 * (m->parts * (i * m->poles.n + j * B) + p * B);

        for (PetscInt l = 0; l < B; l++) {
          x[l] = m->k[i + l] > 0 ? (float)-V[p * m->stride + i + l] : 0;
          x[B + l] = 0;
        }
      }
}
