/* Triangles and points that tests draw, and fields that they compare. */
#pragma once
#include "unit.h"
#include <math.h>

static inline PetscReal Random(PetscReal from, PetscReal to)
{
  static uint64_t last = 33;

  last = last * 6364136223846793005u + 1442695040888963407u;
  return from + (to - from) * (PetscReal)(last >> 11) / 9007199254740992.0;
}

/* Displacement [3] and gradient [3][3] */
static inline void Fields(PetscReal nu, PetscBool full, PetscReal v[3][3], const PetscReal slip[3],
                          const PetscReal at[3], PetscReal field[12])
{
  ok(SlipTriangleDisplacement(nu, full, v[0], slip, 1, at, field));
  ok(SlipTriangleGradient(nu, full, v[0], slip, 1, at, field + 3));
}

/* To a share of the largest, of displacement and of gradient; slip and sides are of order 1, and edges round to 1e-16
   of that where they cancel, far away: 1e-3 of it is the least that counts as large */
static inline void AssertFields(const PetscReal ours[12], const PetscReal want[12], PetscReal allowed)
{
  PetscReal most[2] = {1e-3, 1e-3};

  for (int i = 0; i < 12; i++) most[i >= 3] = PetscMax(most[i >= 3], PetscAbsReal(want[i]));
  for (int i = 0; i < 12; i++) AssertNear(ours[i], want[i], allowed * most[i >= 3]);
}

/* Whether a triangle has a height below a fifth of its longest side, or less than 0.3 */
static inline PetscBool Flat(PetscReal v[3][3])
{
  PetscReal square[3] = {0}, most, sum = 0, quartic = 0, height;

  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++) square[k] += PetscSqr(v[(k + 1) % 3][i] - v[k][i]);
  most = PetscMax(square[0], PetscMax(square[1], square[2]));
  for (int k = 0; k < 3; k++) {
    sum += square[k];
    quartic += PetscSqr(square[k]);
  }
  height = 0.5 * PetscSqrtReal(PetscMax(0, sum * sum - 2 * quartic) / most); /* by Heron */
  return (PetscBool)(height < 0.3 || height < 0.2 * PetscSqrtReal(most));
}

/* A triangle with a strike, or a vertical one's, and two sides of 0.8 to 2, its middle at a depth of 2.5 to 5 */
static inline void AnyTriangle(PetscReal dip, PetscReal v[3][3])
{
  const PetscReal strike = Random(0, dip == 90 ? 179 : 360), middle[3] = {Random(-3, 3), Random(-3, 3), Random(2.5, 5)};
  PetscReal d[3][3];

  SlipPlaneDirections(strike, dip, 0, d[0]);
  do {
    const PetscReal turn = Random(0, 2 * PETSC_PI), open = Random(0.5, 2.5);

    for (int k = 0; k < 3; k++) {
      const PetscReal size = k ? Random(0.8, 2) : 0, x = size * cos(turn + k * open), t = size * sin(turn + k * open);

      for (int i = 0; i < 3; i++) v[k][i] = middle[i] + x * d[0][i] + t * d[1][i];
    }
  } while (Flat(v));
}

static inline void AnySlip(PetscReal slip[3])
{
  for (int i = 0; i < 3; i++) slip[i] = Random(-1, 1);
}

static inline void AnyPair(PetscReal dip, PetscReal v[3][3], PetscReal slip[3], PetscReal at[3])
{
  AnyTriangle(dip, v);
  AnySlip(slip);
  for (int i = 0; i < 2; i++) at[i] = Random(-6, 6);
  at[2] = Random(0, 8);
}
