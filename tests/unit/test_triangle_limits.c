/* Fields of triangles against themselves: in parts, turned, scaled, with vertices in any order, nearly vertical and
   horizontal, on extensions of edges, above and below vertices. */
#include "triangles.h"

/* Units of length: times 2^k the gradient is the same to the bit; metres for kilometres to rounding. */
static void units(void **state)
{
  static const PetscReal factors[] = {1024, 1. / 1024, 1000, 1e-3};

  for (int trial = 0; trial < 60; trial++)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(factors); k++) {
      const PetscReal c = factors[k];
      PetscReal v[3][3], w[3][3], slip[3], at[3], to[3], f[12], g[12];

      AnyPair(Random(1, 90), v, slip, at);
      if (trial % 3 == 0) /* on an edge, which has no length of its own either */
        for (int i = 0; i < 3; i++) at[i] = 0.5 * (v[0][i] + v[1][i]);
      for (int i = 0; i < 3; i++) {
        to[i] = c * at[i];
        for (int j = 0; j < 3; j++) w[j][i] = c * v[j][i];
      }
      Fields(0.25, PETSC_FALSE, v, slip, at, f);
      Fields(0.25, PETSC_FALSE, w, slip, to, g);
      for (int i = 3; i < 12; i++) g[i] *= c;
      AssertFields(g, f, 1e-12);
      for (int i = 3; i < 12 && k < 2; i++) AssertNear(g[i], f[i], 0);
    }
}

/* A vertex that moves by e: fields are f + f' e + O(e^2), where a plane is vertical or horizontal at e = 0, where an
   edge is horizontal or vertical, and where two of them are; second differences are e^2 times numbers of the size of
   f. Formulas with quotients by a cosine or sine would leave 1e-16/e. Slip is a jump in the frame, as strike and dip
   of a horizontal plane are not continuous. The smallest e is one of rounding. */
static void near_special_planes(void **state)
{
  static const PetscReal steps[] = {1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12, 1e-15};

  for (int trial = 0; trial < 240; trial++)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(steps); k++) {
      const int kind = trial % 6;
      const PetscReal e = steps[k];
      PetscReal v[3][3], at[3], jump[3], f[3][12], most = 0, side[3],
                                                   move[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)};

      AnyPair(kind == 0 ? 90 : Random(10, 80), v, jump, at);
      if (kind == 1) v[1][2] = v[2][2] = v[0][2];                             /* horizontal */
      if (kind == 2) v[1][2] = v[0][2];                                       /* a horizontal edge */
      if (kind == 3) v[1][0] = v[0][0], v[1][1] = v[0][1];                    /* a vertical one */
      if (kind == 4) v[1][0] = v[0][0], v[1][1] = v[0][1], v[2][2] = v[1][2]; /* both */
      if (kind == 5) /* an edge along x, with the point on its extension and above the other end */
        for (int i = 1; i < 3; i++) at[i] = v[1][i] = v[0][i];
      if (kind == 5) at[0] = v[1][0] + 2 * (v[1][0] - v[0][0]);
      if (Flat(v)) continue;
      if (trial % 4 == 1) at[2] = 0;
      if (trial % 4 == 2 && kind)
        at[0] = v[1][0], at[1] = v[1][1], at[2] = Random(0, 1) * v[1][2] * 0.8; /* above a vertex */
      for (int i = 0; i < 3; i++) {
        PetscReal w[3][3], d[3][3], slip[3] = {0};

        for (int l = 0; l < 9; l++) w[l / 3][l % 3] = v[l / 3][l % 3];
        for (int l = 0; l < 3; l++) w[1][l] += i * e * move[l];
        ok(SlipTriangleDirections(w[0], i ? side : NULL, NULL, d[0]));
        if (i == 0)
          for (int l = 0; l < 3; l++) side[l] = d[2][l];
        {
          PetscReal own[3][3];
          PetscReal same = 0;

          ok(SlipTriangleDirections(w[0], NULL, NULL, own[0]));
          for (int l = 0; l < 3; l++) same += own[2][l] * d[2][l];
          for (int c = 0; c < 3; c++)
            for (int l = 0; l < 3; l++) slip[c] += same * own[c][l] * jump[l];
        }
        Fields(0.25, PETSC_FALSE, w, slip, at, f[i]);
        for (int j = 0; j < 12; j++) most = PetscMax(most, PetscAbsReal(f[i][j]));
      }
      if (most > 10) continue; /* close to the triangle: numbers of the size of f are larger */
      for (int j = 0; j < 12; j++) {
        AssertNear(f[0][j] - 2 * f[1][j] + f[2][j], 0, (300 * e * e + 1e-11) * (most + 0.1));
        AssertNear(f[1][j], f[0][j], (100 * e + 1e-11) * (most + 0.1));
      }
    }
}

/* What is at a point is the limit of what is next to it: the mean of both sides at the distance h is off by h^2 f'',
   and a point at tiny by tiny f'. Fields change over the distance beyond from the next vertex. */
static void AssertSmooth(PetscReal v[3][3], const PetscReal slip[3], const PetscReal at[3], const PetscReal off[3],
                         PetscReal beyond, PetscReal tiny)
{
  const PetscReal h = 1e-6 * beyond;
  PetscReal to[3], on[12], f[12], mean[12] = {0};

  Fields(0.25, PETSC_FALSE, v, slip, at, on);
  for (int side = -1; side <= 1; side += 2) {
    for (int i = 0; i < 3; i++) to[i] = at[i] + side * h * off[i];
    Fields(0.25, PETSC_FALSE, v, slip, to, f);
    for (int i = 0; i < 12; i++) mean[i] += 0.5 * f[i];
  }
  AssertFields(mean, on, 1e-10);
  for (int i = 0; i < 3; i++) to[i] = at[i] + tiny * beyond * off[i];
  Fields(0.25, PETSC_FALSE, v, slip, to, f);
  AssertFields(f, on, 30 * tiny + 1e-11);
}

/* Points on the extensions of the three edges, from 1e-3 to 3 sides beyond a vertex */
static void extensions(void **state)
{
  for (int trial = 0; trial < 600; trial++) {
    const int edge = trial % 3, begin = trial % 2 ? edge : (edge + 1) % 3, end = trial % 2 ? (edge + 1) % 3 : edge;
    PetscReal v[3][3], slip[3], at[3], off[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)}, length = 0;
    PetscReal share = pow(10, Random(-3, 0.5));

    AnyPair(trial % 5 == 0 ? 90 : Random(1, 90), v, slip, at);
    if (trial % 5 == 1) v[2][2] = v[1][2] = v[0][2];
    if (trial % 5 == 2) v[end][2] = v[begin][2]; /* a horizontal edge */
    if (Flat(v)) continue;
    if (v[end][2] < v[begin][2]) share = PetscMin(share, 0.9 * v[end][2] / (v[begin][2] - v[end][2]));
    for (int i = 0; i < 3; i++) {
      at[i] = v[end][i] + share * (v[end][i] - v[begin][i]);
      length += PetscSqr(v[end][i] - v[begin][i]);
    }
    AssertSmooth(v, slip, at, off, PetscMin(share, 1) * PetscSqrtReal(length), trial % 7 ? 1e-13 : 1e-8);
  }
}

/* Points vertically above and below vertices, on the ground too; below and above points of edges; and in the plane
   outside */
static void above_vertices(void **state)
{
  for (int trial = 0; trial < 600; trial++) {
    const int vertex = trial % 3;
    PetscReal v[3][3], slip[3], at[3], off[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)}, beyond = 1;

    AnyPair(trial % 5 == 0 ? 0 : Random(1, 80), v, slip, at);
    if (trial % 5 == 0) v[2][2] = v[1][2] = v[0][2];
    if (Flat(v)) continue;
    for (int i = 0; i < 3; i++) at[i] = v[vertex][i];
    if (trial % 4 == 0) {
      at[2] = 0;
      off[2] = 0;
      beyond = 0.3;
    } else if (trial % 4 == 1) {
      beyond = pow(10, Random(-3, 0));
      at[2] += trial % 8 == 1 ? beyond : -beyond * PetscMin(1, 0.9 * at[2]);
      beyond *= PetscMin(1, 0.9 * v[vertex][2]);
    } else if (trial % 4 == 2) { /* of an edge */
      for (int i = 0; i < 2; i++) at[i] += 0.3 * (v[(vertex + 1) % 3][i] - at[i]);
      at[2] = 0;
      off[2] = 0;
    } else { /* the parallelogram's other vertex */
      for (int i = 0; i < 3; i++) at[i] = v[(vertex + 1) % 3][i] + v[(vertex + 2) % 3][i] - v[vertex][i];
      if (at[2] < 0.1) continue;
      beyond = 0.3;
    }
    AssertSmooth(v, slip, at, off, 0.3 * beyond, trial % 7 ? 1e-13 : 1e-8);
  }
}

/* Nearly horizontal edges next to the ground, and points of the ground on their extensions, where the logarithm of an
   edge that is taken downward is of a small number: displacement is that of two parts to rounding, and the surface
   has no traction */
static void shallow_edges(void **state)
{
  for (int trial = 0; trial < 800; trial++) {
    const PetscReal h = pow(10, -1 - trial % 8), x = Random(0.5, 1.5);
    const PetscReal at[3] = {trial % 3 ? -Random(0.3, 3) : x + Random(0.3, 3), h * Random(-2, 2), 0};
    PetscReal v[3][3] = {
      {0, 0, h * Random(0.5, 1)}, {x, 0, h * Random(1.2, 2)}, {Random(0, 1), Random(0.5, 1), Random(0.1, 1)}};
    PetscReal part[2][3][3], slip[3], u[3], half[2][3], stress[6], most = 0;

    AnySlip(slip);
    for (int k = 0; k < 9; k++) part[0][k / 3][k % 3] = part[1][k / 3][k % 3] = v[k / 3][k % 3];
    for (int i = 0; i < 3; i++) part[0][1][i] = part[1][0][i] = 0.5 * (v[0][i] + v[1][i]);
    ok(SlipTriangleDisplacement(0.25, PETSC_FALSE, v[0], slip, 1, at, u));
    for (int k = 0; k < 2; k++) ok(SlipTriangleDisplacement(0.25, PETSC_FALSE, part[k][0], slip, 1, at, half[k]));
    for (int i = 0; i < 3; i++) AssertNear(half[0][i] + half[1][i], u[i], 3e-15);
    ok(SlipTriangleStress(1, 0.25, PETSC_FALSE, v[0], slip, 1, at, stress));
    for (int i = 0; i < 6; i++) most = PetscMax(most, PetscAbsReal(stress[i]));
    for (int i = 0; i < 3; i++) AssertNear(stress[i ? 3 + i : 2], 0, 1e-12 * most);
  }
}

SLIP_TESTS(units, near_special_planes, extensions, above_vertices, shallow_edges)
