/* Both sides of triangles and their edges; directions of planes, tractions of pairs and input. */
#include "triangles.h"
#include <slipstep/private/sliptriangle.h>

/* Across the triangle displacement jumps by the slip, and stress does not jump in its traction. A point of the
   triangle belongs to the hanging wall, one of the trace too: its limit along the ground. */
static void sides(void **state)
{
  const PetscReal h = 1e-9;

  (void)state;
  for (int trial = 0; trial < 100; trial++) {
    PetscReal v[3][3], slip[3], at[3], to[3], d[3][3], up[3], on[3], down[3], stress[2][6], traction[2][3];

    AnyPair(trial % 5 == 0 ? 90 : Random(5, 90), v, slip, at);
    if (trial % 5 == 1) v[2][2] = v[1][2] = v[0][2];
    if (Flat(v)) continue;
    ok(SlipTriangleDirections(v[0], NULL, NULL, d[0]));
    for (int i = 0; i < 3; i++) at[i] = 0.3 * v[0][i] + 0.25 * v[1][i] + 0.45 * v[2][i];
    ok(SlipTriangleDisplacement(0.3, PETSC_FALSE, v[0], slip, 1, at, on));
    for (int side = 0; side < 2; side++) {
      for (int i = 0; i < 3; i++) to[i] = at[i] + (side ? -h : h) * d[2][i];
      ok(SlipTriangleDisplacement(0.3, PETSC_FALSE, v[0], slip, 1, to, side ? down : up));
      ok(SlipTriangleStress(1, 0.3, PETSC_FALSE, v[0], slip, 1, to, stress[side]));
      SlipStressTraction(1, stress[side], d[0], traction[side]);
    }
    for (int i = 0; i < 3; i++) {
      AssertNear(up[i] - down[i], slip[0] * d[0][i] + slip[1] * d[1][i] + slip[2] * d[2][i], 100 * h);
      AssertNear(up[i], on[i], 100 * h);
      AssertNear(traction[0][i], traction[1][i], 1e4 * h);
    }
    if (trial % 5 == 1) continue;
    { /* an edge up to the ground */
      const PetscReal y = v[0][2] / d[1][2], z = v[1][2] / d[1][2];

      for (int i = 0; i < 3; i++) {
        v[0][i] -= y * d[1][i];
        v[1][i] -= z * d[1][i];
      }
      v[0][2] = v[1][2] = 0;
    }
    if (Flat(v)) continue;
    ok(SlipTriangleDirections(v[0], NULL, NULL, d[0]));
    for (int i = 0; i < 3; i++) at[i] = to[i] = 0.4 * v[0][i] + 0.6 * v[1][i];
    for (int i = 0; i < 2; i++) to[i] += h * d[2][i] / PetscSqrtReal(1 - d[2][2] * d[2][2]);
    ok(SlipTriangleDisplacement(0.3, PETSC_FALSE, v[0], slip, 1, at, on));
    ok(SlipTriangleDisplacement(0.3, PETSC_FALSE, v[0], slip, 1, to, up));
    for (int i = 0; i < 3; i++) AssertNear(on[i], up[i], 1e4 * h);
  }
}

/* On edges and vertices, buried and on the ground, numbers come out: displacement with the logarithm of 1e-20, and
   stress without its infinite part. Near an edge its mean around the edge is that, as what goes with 1/r turns its
   sign. */
static void edges(void **state)
{
  enum { AROUND = 64 };

  (void)state;
  for (int trial = 0; trial < 120; trial++) {
    const PetscReal h = 1e-4, share = trial % 3 ? Random(0.3, 0.7) : 0;
    PetscReal v[3][3], slip[3], at[3], a[3], b[3], d[3][3], on[12], f[12], mean[12] = {0}, size = 0;

    AnyPair(trial % 2 ? Random(10, 90) : 90, v, slip, at);
    if (trial % 4 < 2) {
      const PetscReal top = PetscMin(v[0][2], v[1][2]);

      for (int k = 0; k < 3; k++) v[k][2] = PetscMax(v[k][2] - top, 0);
    }
    if (Flat(v)) continue;
    for (int i = 0; i < 3; i++) at[i] = (1 - share) * v[0][i] + share * v[1][i];
    Fields(0.25, PETSC_FALSE, v, slip, at, on);
    for (int k = 0; k < 12; k++) assert_true(PetscAbsReal(on[k]) < 1000);
    if (share == 0 || at[2] < 0.1) continue;
    ok(SlipTriangleDirections(v[0], NULL, NULL, d[0]));
    for (int i = 0; i < 3; i++) size += PetscSqr(v[1][i] - v[0][i]);
    for (int i = 0; i < 3; i++) a[i] = (v[1][i] - v[0][i]) / PetscSqrtReal(size);
    for (int i = 0; i < 3; i++) b[i] = a[(i + 1) % 3] * d[2][(i + 2) % 3] - a[(i + 2) % 3] * d[2][(i + 1) % 3];
    for (int n = 0; n < AROUND; n++) {
      const PetscReal turn = 2 * PETSC_PI * (n + 0.5) / AROUND;
      PetscReal to[3];

      for (int k = 0; k < 3; k++) to[k] = at[k] + h * (cos(turn) * b[k] + sin(turn) * d[2][k]);
      ok(SlipTriangleGradient(0.25, PETSC_FALSE, v[0], slip, 1, to, f));
      for (int k = 0; k < 9; k++) mean[k] += f[k] / AROUND;
    }
    /* h, times numbers of the size of the gradient's derivatives; the mean of 1/h itself cancels to 1e-16/h */
    for (int k = 0; k < 9; k++) AssertNear(mean[k], on[3 + k], 30 * h);
  }
}

/* Strike and dip of triangles that were made with them, on the other side too, and the conventions of special planes */
static void directions(void **state)
{
  static const struct {
    PetscReal vertices[9], strike, dip;
  } special[] = {
    {{0, 0, 5, 1, 0, 5, 0, 1, 5}, 0, 0},                                                 /* horizontal */
    {{0, 1, 5, 1, 0, 5, 0, 0, 5}, 0, 0},           {{0, 0, 5, 1, 0, 5, 0, 0, 6}, 0, 90}, /* vertical, striking north */
    {{1, 0, 5, 0, 0, 5, 0, 0, 6}, 0, 90},          {{0, 0, 5, 1, 1e-13, 5, 0, 0, 6}, 0, 90}, /* by rounding */
    {{0, 0, 5, 1, -1e-13, 5, 0, 1e-13, 6}, 0, 90}, {{0, 0, 5, -1, 1, 5, 0, 0, 6}, 135, 90},
    {{0, 0, 5, 1, -1, 5, 0, 0, 6}, 135, 90},       {{0, 0, 5, 0, -1, 5, 0, 0, 6}, 90, 90},
    {{0, 0, 5, 1, 0, 5, 0, 1, 6}, 0, 45}, /* down to the east */
    {{0, 0, 5, 1, 0, 5, 0, -1, 6}, 180, 45},
  };
  PetscReal angles[2], d[9], want[9];

  (void)state;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(special); k++) {
    ok(SlipTriangleDirections(special[k].vertices, NULL, angles, d));
    AssertNear(remainder(angles[0] - special[k].strike, 360), 0, 1e-10);
    AssertNear(angles[1], special[k].dip, 1e-10);
    SlipPlaneDirections(special[k].strike, special[k].dip, 0, want);
    for (int i = 0; i < 9; i++) AssertNear(d[i], want[i], 1e-12);
  }
  for (int trial = 0; trial < 100; trial++) {
    const PetscReal dip = Random(0.1, 89.9), middle[3] = {1, 2, 9}, below[3] = {0, 0, 1}, above[3] = {0, 0, -1};
    const PetscReal strike = Random(0, 360);
    PetscReal v[3][3], other[2], o[9];

    SlipPlaneDirections(strike, dip, 0, want);
    for (int k = 0; k < 3; k++) {
      const PetscReal x = Random(-1, 1) + (k == 1 ? 3 : 0), t = Random(-1, 1) + (k == 2 ? 3 : 0);

      for (int i = 0; i < 3; i++) v[k][i] = middle[i] + x * want[i] + t * want[3 + i];
    }
    ok(SlipTriangleDirections(v[0], trial % 2 ? NULL : above, angles, d));
    AssertNear(remainder(angles[0] - strike, 360), 0, 1e-9);
    AssertNear(angles[1], dip, 1e-11);
    for (int i = 0; i < 9; i++) AssertNear(d[i], want[i], 1e-12);
    ok(SlipTriangleDirections(v[0], below, other, o));
    AssertNear(PetscAbsReal(remainder(other[0] - angles[0], 360)), 180, 1e-9);
    AssertNear(other[1], 180 - angles[1], 1e-11);
    SlipPlaneDirections(other[0], other[1], 0, want);
    for (int i = 0; i < 9; i++) {
      AssertNear(o[i], want[i], 1e-12);
      AssertNear(o[i], (i / 3 == 1 ? 1 : -1) * d[i], 1e-12);
    }
  }
}

/* Tractions are those of the stress */
static void pairs(void **state)
{
  enum { MANY = 53 };
  const PetscReal G = 30, nu = 0.25;
  static SlipTriangleCell cell[2 * MANY];
  const SlipTriangleCell *receiver[MANY], *source[MANY];
  PetscReal traction[MANY][3], slip[2 * MANY][3];

  (void)state;
  for (int k = 0; k < 2 * MANY; k++) {
    const PetscReal rake = Random(-180, 180) * PETSC_PI / 180, below[3] = {0.1, 0.2, 1};
    const PetscBool over = (PetscBool)(k % 3 == 1);
    PetscReal v[3][3], d[3][3];

    AnyTriangle(k % 7 ? Random(1, 90) : 90, v);
    if (over)
      ok(SlipTriangleDirections(v[0], below, NULL, d[0]));
    else
      ok(SlipTriangleDirections(v[0], NULL, NULL, d[0]));
    for (int i = 0; i < 9; i++) cell[k].vertices[i] = v[i / 3][i % 3];
    for (int i = 0; i < 3; i++) {
      cell[k].directions[i] = cos(rake) * d[0][i] + sin(rake) * d[1][i];
      cell[k].directions[3 + i] = cos(rake) * d[1][i] - sin(rake) * d[0][i];
      cell[k].directions[6 + i] = d[2][i];
    }
    slip[k][0] = cos(rake);
    slip[k][1] = sin(rake);
    slip[k][2] = 0;
    { /* slip up dip has the other sign on the other side */
      PetscReal own[3][3];

      ok(SlipTriangleDirections(v[0], NULL, NULL, own[0]));
      if (own[2][0] * d[2][0] + own[2][1] * d[2][1] + own[2][2] * d[2][2] < 0) slip[k][1] = -slip[k][1];
    }
  }
  for (int full = 0; full < 2; full++) {
    for (int k = 0; k < MANY; k++) {
      receiver[k] = &cell[MANY + k];
      source[k] = &cell[k];
      if (k == 7) receiver[k] = source[k];
      SlipTriangleTractions(G, nu, (PetscBool)full, 1, receiver[k], source[k], traction[k]);
    }
    for (int k = 0; k < MANY; k++) {
      const PetscReal *v = receiver[k]->vertices;
      PetscReal at[3], stress[6], t[3];

      for (int i = 0; i < 3; i++) at[i] = (v[i] + v[3 + i] + v[6 + i]) / 3;
      ok(SlipTriangleStress(G, nu, (PetscBool)full, source[k]->vertices, slip[source[k] - cell], 1, at, stress));
      SlipStressTraction(1, stress, receiver[k]->directions, t);
      for (int i = 0; i < 3; i++)
        AssertNear(traction[k][i], t[i], 1e-11 * (PetscAbsReal(t[0]) + PetscAbsReal(t[1]) + PetscAbsReal(t[2])));
      if (k == 7) assert_true(traction[k][0] > 0); /* the stress drop */
    }
  }
}

/* Within a triangle of 1e6 m points belong to the hanging wall, near a corner at the origin too, whose own coordinates
   do not round. */
static void near_a_corner(void **state)
{
  const PetscReal slip[3] = {1, 0, 0};
  PetscReal wide[9] = {0, 0, 0, 1e6, 3e5, 2e5, -2e5, 1e6, 7e5}, directions[9], u[3];

  (void)state;
  ok(SlipTriangleDirections(wide, NULL, NULL, directions));
  for (int n = 0; n < 200; n++) {
    const PetscReal a = Random(1e-6, 1e-5), b = Random(1e-6, 1e-5);
    PetscReal at[3], beyond[3], hanging[3];

    for (int i = 0; i < 3; i++) {
      at[i] = a * wide[3 + i] + b * wide[6 + i];
      beyond[i] = at[i] + 1e-3 * directions[6 + i];
    }
    ok(SlipTriangleDisplacement(0.25, PETSC_TRUE, wide, slip, 1, at, u));
    ok(SlipTriangleDisplacement(0.25, PETSC_TRUE, wide, slip, 1, beyond, hanging));
    for (int i = 0; i < 3; i++) AssertNear(u[i], hanging[i], 1e-2); /* of a jump of 1, and a strain of 0.1 a metre */
  }
}

/* Many points are what each of them is, and wrong input ends with what is wrong. */
static void input(void **state)
{
  enum { MANY = 53 };
  const PetscReal v[9] = {0, 0, 3, 2, 0.5, 2, 1, 2, 2.5}, slip[3] = {1, 2, 3};
  PetscReal at[MANY][3], u[MANY][3], s[MANY][6], one[6], wrong[9];

  (void)state;
  for (int k = 0; k < MANY; k++)
    for (int i = 0; i < 3; i++) at[k][i] = Random(i < 2 ? -4 : 0, 4);
  ok(SlipTriangleDisplacement(0.25, PETSC_FALSE, v, slip, MANY, at[0], u[0]));
  ok(SlipTriangleStress(1, 0.25, PETSC_FALSE, v, slip, MANY, at[0], s[0]));
  for (int k = 0; k < MANY; k++) {
    ok(SlipTriangleDisplacement(0.25, PETSC_FALSE, v, slip, 1, at[k], one));
    for (int i = 0; i < 3; i++) AssertNear(one[i], u[k][i], 1e-15);
    ok(SlipTriangleStress(1, 0.25, PETSC_FALSE, v, slip, 1, at[k], one));
    for (int i = 0; i < 6; i++) AssertNear(one[i], s[k][i], 1e-13);
  }
  fails(SlipTriangleStress(1, 0.5, PETSC_FALSE, v, slip, 1, at[0], one),
        "Poisson's ratio must lie in (-1, 0.5), not 0.5");
  at[1][2] = -1;
  fails(SlipTriangleStress(1, 0.25, PETSC_FALSE, v, slip, 2, at[0], s[0]), "above the ground, expected below it");
  ok(SlipTriangleStress(1, 0.25, PETSC_TRUE, v, slip, 2, at[0], s[0]));
  memcpy(wrong, v, sizeof(wrong));
  wrong[5] = -0.5;
  fails(SlipTriangleDisplacement(0.25, PETSC_FALSE, wrong, slip, 1, at[0], one), "0.5 m above the ground");
  ok(SlipTriangleDisplacement(0.25, PETSC_TRUE, wrong, slip, 1, at[0], one));
  memcpy(wrong, v, sizeof(wrong));
  wrong[5] = 0;
  ok(SlipTriangleDisplacement(0.25, PETSC_FALSE, wrong, slip, 1, at[0], u[0]));
  wrong[5] = -1e-6; /* a vertex that is above the ground by rounding of its file is on it */
  ok(SlipTriangleDisplacement(0.25, PETSC_FALSE, wrong, slip, 1, at[0], u[1]));
  for (int i = 0; i < 3; i++) AssertNear(u[1][i], u[0][i], 1e-5);
  at[2][0] = at[3][0] = 0.7; /* a point is on it as well, to the bit */
  at[2][1] = at[3][1] = -0.3;
  at[2][2] = 0;
  at[3][2] = -1e-14;
  ok(SlipTriangleStress(1, 0.25, PETSC_FALSE, v, slip, 2, at[2], s[0]));
  for (int i = 0; i < 6; i++) assert_true(s[1][i] == s[0][i]);
  at[2][0] = wrong[3];
  at[2][1] = wrong[4];
  at[2][2] = 0;
  ok(SlipTriangleStress(1, 0.25, PETSC_FALSE, wrong, slip, 1, at[2], s[0]));
  for (int i = 0; i < 3; i++)
    AssertNear(s[0][i ? 3 + i : 2], 0, 1e-6 * (PetscAbsReal(s[0][0]) + PetscAbsReal(s[0][1])));
  wrong[2] = wrong[5] = wrong[8] = 0;
  fails(SlipTriangleDisplacement(0.25, PETSC_FALSE, wrong, slip, 1, at[0], one), "lies on the ground");
  memcpy(wrong, v, sizeof(wrong));
  for (int i = 0; i < 3; i++) wrong[3 + i] = 0.5 * (v[i] + v[6 + i]);
  fails(SlipTriangleDisplacement(0.25, PETSC_TRUE, wrong, slip, 1, at[0], one), "height");
  memcpy(wrong, v, 3 * sizeof(PetscReal));
  memcpy(wrong + 3, v, 3 * sizeof(PetscReal));
  memcpy(wrong + 6, v, 3 * sizeof(PetscReal));
  fails(SlipTriangleGradient(0.25, PETSC_TRUE, wrong, slip, 1, at[0], one), "height");
  wrong[4] = NAN;
  fails(SlipTriangleGradient(0.25, PETSC_TRUE, wrong, slip, 1, at[0], one), "each north, east and down");
  {
    const PetscReal flat[9] = {0, 0, 3, 2, 0, 3, 1, 2, 3}, side[3] = {1, 2, 0};

    fails(SlipTriangleDirections(flat, side, NULL, one), "expected a vector into the hanging wall");
  }
}

SLIP_TESTS(sides, edges, directions, pairs, near_a_corner, input)
