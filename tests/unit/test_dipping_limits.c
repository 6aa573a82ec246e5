/* Fields of dipping rectangles against the vertical kernel and against themselves: turned, scaled, cut into parts, at
   dips near 90 degrees, on extensions of edges, on the rectangle and its edges; and tractions on planes. */
#include "unit.h"
#include <math.h>

static PetscReal Random(PetscReal from, PetscReal to)
{
  static uint64_t last = 24;

  last = last * 6364136223846793005u + 1442695040888963407u;
  return from + (to - from) * (PetscReal)(last >> 11) / 9007199254740992.0;
}

/* Displacement [3] and gradient [3][3] */
static void Fields(PetscReal nu, PetscBool full, const SlipDippingRectangle *r, const PetscReal slip[3],
                   const PetscReal at[3], PetscReal field[12])
{
  ok(SlipDippingDisplacement(nu, full, r, slip, 1, at, field));
  ok(SlipDippingGradient(nu, full, r, slip, 1, at, field + 3));
}

/* The largest difference, and the largest size, of displacement and of gradient */
static void AssertFields(const PetscReal ours[12], const PetscReal want[12], PetscReal allowed)
{
  PetscReal most[2] = {0};

  for (int i = 0; i < 12; i++) most[i >= 3] = PetscMax(most[i >= 3], PetscAbsReal(want[i]));
  for (int i = 0; i < 12; i++) AssertNear(ours[i], want[i], allowed * most[i >= 3]);
}

static void AnyPair(PetscReal dip, SlipDippingRectangle *r, PetscReal slip[3], PetscReal at[3])
{
  *r = (SlipDippingRectangle){Random(-3, 3), Random(-3, 3), 0, Random(1, 4), Random(1, 4), Random(0, 360), dip};
  r->z = 0.5 * r->width + Random(0, 3);
  for (int i = 0; i < 3; i++) slip[i] = Random(-1, 1);
  for (int i = 0; i < 2; i++) at[i] = Random(-6, 6);
  at[2] = Random(0, 8);
}

/* Strike slip of vertical cells, on the plane, beside it and on the surface: corners have 1e-16 of 1 / distance, and
   the points are at most ten sides away, so that 1e-13 of the cell's own stress drop is left. */
static void vertical(void **state)
{
  const PetscReal G = 30, slip[3] = {1, 0, 0};

  for (int trial = 0; trial < 400; trial++) {
    const PetscReal nu = Random(-0.5, 0.49), y = trial % 3 ? Random(-5, 5) : 0;
    const PetscBool full = (PetscBool)(trial % 4 == 3);
    SlipDippingRectangle r = {Random(-1, 1), 0.5, 0, Random(0.6, 2), Random(0.6, 2), 0, 90};
    PetscReal at[3] = {Random(-5, 5), 0.5 + y, Random(0, 6)}, stress[6], u[3], known[3];
    SlipRectangle old;

    r.z = 0.5 * r.width + (trial % 2 ? Random(0, 3) : 0);
    old = (SlipRectangle){r.x, r.y, r.z, r.length, r.width};
    ok(SlipDippingStress(G, nu, full, &r, slip, 1, at, stress));
    {
      const PetscReal drop = SlipKernelOffset(G, nu, at[0] - r.x, at[1] - r.y, at[2], r.z, r.length, r.width, full);

      AssertNear(-stress[3], drop, 1e-13 * (SlipKernelFullSpace(G, nu, 0, 0, 1, 1) + PetscAbsReal(drop)));
    }
    if (full) continue;
    at[2] = 0;
    ok(SlipDippingDisplacement(nu, PETSC_FALSE, &r, slip, 1, at, u));
    SlipSurfaceDisplacement(nu, &old, 1, at, known);
    for (int i = 0; i < 3; i++) AssertNear(u[i], known[i], 1e-13);
  }
}

/* At 90 degrees less e the fields are f + f' e + O(e^2): second differences of the dip are e^2 times numbers of the
   size of f, of some ten as sides and distances are of order 1. Formulas with quotients by the cosine would leave
   1e-16/e^2 or 1e-16/e. The smallest e is one of rounding. */
static void near_vertical(void **state)
{
  static const PetscReal steps[] = {1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12};

  for (int trial = 0; trial < 60; trial++)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(steps); k++) {
      const PetscReal e = steps[k] * PETSC_PI / 180;
      SlipDippingRectangle r;
      PetscReal slip[3], at[3], f[3][12], most = 0;

      AnyPair(90, &r, slip, at);
      if (trial % 4 == 0) at[0] = r.x, at[1] = r.y; /* in the plane, below or above */
      if (trial % 4 == 0 && PetscAbsReal(at[2] - r.z) < 0.6 * r.width) continue;
      for (int i = 0; i < 3; i++) {
        r.dip = 90 - i * steps[k];
        Fields(0.25, PETSC_FALSE, &r, slip, at, f[i]);
        for (int j = 0; j < 12; j++) most = PetscMax(most, PetscAbsReal(f[i][j]));
      }
      for (int j = 0; j < 12; j++) {
        AssertNear(f[0][j] - 2 * f[1][j] + f[2][j], 0, (100 * e * e + 1e-13) * (most + 0.1));
        AssertNear(f[1][j], f[0][j], (100 * e + 1e-13) * (most + 0.1));
      }
    }
}

/* Units of length: times 2^k the gradient is the same to the bit, as nothing but lengths is in it; a displacement has
   logarithms, whose units cancel to rounding. Metres for kilometres to rounding. */
static void units(void **state)
{
  static const PetscReal factors[] = {1024, 1. / 1024, 1000, 1e-3, 1e6};

  for (int trial = 0; trial < 100; trial++)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(factors); k++) {
      const PetscReal c = factors[k];
      SlipDippingRectangle r, s;
      PetscReal slip[3], at[3], to[3], f[12], g[12];

      AnyPair(Random(1, 90), &r, slip, at);
      if (trial % 3 == 0) { /* on an edge, which has no length of its own either */
        PetscReal d[3][3];

        SlipPlaneDirections(r.strike, r.dip, 0, &d[0][0]);
        for (int i = 0; i < 3; i++) at[i] = (i == 0 ? r.x : i == 1 ? r.y : r.z) + 0.5 * r.length * d[0][i];
      }
      s = (SlipDippingRectangle){c * r.x, c * r.y, c * r.z, c * r.length, c * r.width, r.strike, r.dip};
      for (int i = 0; i < 3; i++) to[i] = c * at[i];
      Fields(0.25, PETSC_FALSE, &r, slip, at, f);
      Fields(0.25, PETSC_FALSE, &s, slip, to, g);
      for (int i = 3; i < 12; i++) g[i] *= c;
      AssertFields(g, f, 1e-12);
      for (int i = 3; i < 12 && k < 2; i++) AssertNear(g[i], f[i], 0);
    }
}

/* Points on the extensions of the four edges, from 1e-3 to 3 sides beyond a corner, and at 1e-13 and 1e-8 beside one:
   the mean of two points at the distance h on either side is off by h^2 f'' = 1e-12 / (1e-3)^2 of f next to the corner,
   h = 1e-6 of the distance from it. */
static void extensions(void **state)
{
  for (int trial = 0; trial < 400; trial++) {
    const int edge = trial % 4;
    const PetscBool up = (PetscBool)(edge < 2 && trial % 8 < 4);
    const PetscReal tiny = trial % 2 ? 1e-13 : 1e-8;
    PetscReal beyond = pow(10, Random(-3, 0.5)), h;
    SlipDippingRectangle r;
    PetscReal slip[3], at[3], to[3], d[3][3], on[12], f[12], mean[12] = {0}, local[2];

    AnyPair(trial % 5 ? Random(1, 90) : 90, &r, slip, at);
    SlipPlaneDirections(r.strike, r.dip, 0, &d[0][0]);
    if (up) beyond = PetscMin(beyond, 0.9 * (r.z + 0.5 * r.width * d[1][2]));
    h = 1e-6 * beyond;
    local[0] = edge < 2 ? (edge ? 0.5 : -0.5) * r.length : (trial % 8 < 4 ? 1 : -1) * (0.5 * r.length + beyond);
    local[1] = edge < 2 ? (up ? 1 : -1) * (0.5 * r.width + beyond) : (edge == 2 ? 0.5 : -0.5) * r.width;
    for (int i = 0; i < 3; i++) at[i] = (i == 0 ? r.x : i == 1 ? r.y : r.z) + local[0] * d[0][i] + local[1] * d[1][i];
    Fields(0.25, PETSC_FALSE, &r, slip, at, on);
    for (int side = -1; side <= 1; side += 2) {
      for (int i = 0; i < 3; i++) to[i] = at[i] + side * h * (d[2][i] + d[edge < 2 ? 0 : 1][i]);
      Fields(0.25, PETSC_FALSE, &r, slip, to, f);
      for (int i = 0; i < 12; i++) mean[i] += 0.5 * f[i];
    }
    AssertFields(mean, on, 1e-10);
    for (int i = 0; i < 3; i++) to[i] = at[i] + tiny * beyond * d[2][i];
    Fields(0.25, PETSC_FALSE, &r, slip, to, f);
    AssertFields(f, on, 20 * tiny + 1e-12);
  }
}

/* Across the rectangle displacement jumps by the slip, and stress does not jump in its traction. A point of the
   rectangle belongs to the hanging wall, one of the trace too: its limit along the ground. */
static void sides(void **state)
{
  for (int trial = 0; trial < 60; trial++) {
    const PetscReal h = 1e-9, along = Random(-0.4, 0.4), up_dip = Random(-0.4, 0.4);
    SlipDippingRectangle r;
    PetscReal slip[3], at[3], to[3], d[3][3], up[3], on[3], down[3], stress[2][6], traction[2][3];

    AnyPair(trial % 3 ? Random(5, 90) : 90, &r, slip, at);
    SlipPlaneDirections(r.strike, r.dip, 0, &d[0][0]);
    for (int i = 0; i < 3; i++)
      at[i] = (i == 0 ? r.x : i == 1 ? r.y : r.z) + along * r.length * d[0][i] + up_dip * r.width * d[1][i];
    ok(SlipDippingDisplacement(0.3, PETSC_FALSE, &r, slip, 1, at, on));
    for (int side = 0; side < 2; side++) {
      for (int i = 0; i < 3; i++) to[i] = at[i] + (side ? -h : h) * d[2][i];
      ok(SlipDippingDisplacement(0.3, PETSC_FALSE, &r, slip, 1, to, side ? down : up));
      ok(SlipDippingStress(1, 0.3, PETSC_FALSE, &r, slip, 1, to, stress[side]));
      SlipStressTraction(1, stress[side], &d[0][0], traction[side]);
    }
    for (int i = 0; i < 3; i++) {
      AssertNear(up[i] - down[i], slip[0] * d[0][i] + slip[1] * d[1][i] + slip[2] * d[2][i], 100 * h);
      AssertNear(up[i], on[i], 100 * h);
      AssertNear(traction[0][i], traction[1][i], 1000 * h);
    }
    r.z = 0.5 * r.width * sin(r.dip * PETSC_PI / 180); /* up to the surface */
    for (int i = 0; i < 3; i++)
      at[i] = to[i] = (i == 0 ? r.x : r.y) + 0.3 * r.length * d[0][i] + 0.5 * r.width * d[1][i];
    at[2] = to[2] = 0;
    for (int i = 0; i < 2; i++) to[i] += h * d[2][i] / sin(r.dip * PETSC_PI / 180);
    ok(SlipDippingDisplacement(0.3, PETSC_FALSE, &r, slip, 1, at, on));
    ok(SlipDippingDisplacement(0.3, PETSC_FALSE, &r, slip, 1, to, up));
    for (int i = 0; i < 3; i++) AssertNear(on[i], up[i], 1000 * h);
  }
}

/* On edges and corners, buried and on the ground, numbers come out: displacement with the logarithm of 1e-20, 46, and
   stress without its infinite part. Near an edge its mean around the edge is that, as what goes with 1/r turns its
   sign. */
static void edges(void **state)
{
  enum { AROUND = 64 };

  for (int trial = 0; trial < 90; trial++) {
    const PetscReal h = 1e-4, i = trial % 3 - 1, j = trial / 3 % 3 - 1;
    SlipDippingRectangle r;
    PetscReal slip[3], at[3], d[3][3], on[12], f[12], mean[12] = {0};

    AnyPair(trial % 2 ? Random(10, 90) : 90, &r, slip, at);
    if (trial % 4 < 2) r.z = 0.5 * r.width * sin(r.dip * PETSC_PI / 180);
    SlipPlaneDirections(r.strike, r.dip, 0, &d[0][0]);
    for (int k = 0; k < 3; k++)
      at[k] = (k == 0 ? r.x : k == 1 ? r.y : r.z) + 0.5 * i * r.length * d[0][k] + 0.5 * j * r.width * d[1][k];
    at[2] = PetscMax(at[2], 0);
    Fields(0.25, PETSC_FALSE, &r, slip, at, on);
    for (int k = 0; k < 12; k++) assert_true(PetscAbsReal(on[k]) < 100);
    if (i * j != 0 || i + j == 0 || at[2] < 0.1) continue;
    for (int a = 0; a < AROUND; a++) {
      const PetscReal turn = 2 * PETSC_PI * (a + 0.5) / AROUND;
      PetscReal to[3];

      for (int k = 0; k < 3; k++) to[k] = at[k] + h * (cos(turn) * d[i == 0 ? 1 : 0][k] + sin(turn) * d[2][k]);
      ok(SlipDippingGradient(0.25, PETSC_FALSE, &r, slip, 1, to, f));
      for (int k = 0; k < 9; k++) mean[k] += f[k] / AROUND;
    }
    /* h, times numbers of the size of the gradient's derivatives; the mean of 1/h itself cancels to 1e-16/h */
    for (int k = 0; k < 9; k++) AssertNear(mean[k], on[3 + k], 10 * h);
  }
}

/* Frames and signs by hand. A thrust of strike 0 and dip 30: hanging wall to the east, up dip to the west and up. */
static void tractions(void **state)
{
  const PetscReal half = 0.5, root = PetscSqrtReal(0.75), push[6] = {0, -1, 0, 0, 0, 0}, shear[6] = {0, 0, 0, 1, 0, 0};
  const PetscReal want[9] = {0, -root, -half, -1, 0, 0, 0, half, -root}, nu = 0.25;
  PetscReal d[9], t[3], stress[6];

  SlipPlaneDirections(0, 30, 90, d);
  for (int i = 0; i < 9; i++) AssertNear(d[i], want[i], 1e-15);
  /* a push from east to west presses the plane by sin^2 and drives the hanging wall up dip */
  SlipStressTraction(1, push, d, t);
  AssertNear(t[0], -half * root, 1e-15);
  AssertNear(t[1], 0, 1e-15);
  AssertNear(t[2], 0.25, 1e-15);
  /* positive xy drives left-lateral slip of a vertical plane along x, to the bit by exact sines */
  SlipPlaneDirections(360, 90, 0, d);
  SlipStressTraction(1, shear, d, t);
  AssertNear(t[0], -1, 0);
  AssertNear(t[1], 0, 0);
  AssertNear(t[2], 0, 0);
  for (int trial = 0; trial < 50;
       trial++) { /* a square's own stress drop in a full space is that of its rake and no other */
    const PetscReal rake = Random(-180, 180), a = 2, turn = rake * PETSC_PI / 180;
    const SlipDippingRectangle r = {1, 2, 3, a, a, Random(0, 360), Random(1, 90)};
    const PetscReal slip[3] = {cos(turn), sin(turn), 0}, open[3] = {0, 0, 1}, at[3] = {1, 2, 3};
    const PetscReal unit = PetscSqrtReal(2) / (PETSC_PI * (1 - nu) * a);

    SlipPlaneDirections(r.strike, r.dip, rake, d);
    ok(SlipDippingStress(1, nu, PETSC_TRUE, &r, slip, 1, at, stress));
    SlipStressTraction(1, stress, d, t);
    AssertNear(t[0], unit * (2 - nu), 1e-14);
    AssertNear(t[1], 0, 1e-14);
    AssertNear(t[2], 0, 1e-14);
    ok(SlipDippingStress(1, nu, PETSC_TRUE, &r, open, 1, at, stress));
    SlipStressTraction(1, stress, d, t);
    AssertNear(t[0], 0, 1e-14);
    AssertNear(t[1], 0, 1e-14);
    AssertNear(t[2], 2 * unit, 1e-14); /* opening presses its own walls */
  }
}

/* Many points are what each of them is, to the bit, and wrong input ends with what is wrong. */
static void input(void **state)
{
  enum { MANY = 53 };
  const SlipDippingRectangle r = {0, 0, 3, 2, 2, 20, 40};
  const PetscReal slip[3] = {1, 2, 3};
  PetscReal at[MANY][3], u[MANY][3], s[MANY][6], one[6];
  SlipDippingRectangle wrong;

  for (int k = 0; k < MANY; k++)
    for (int i = 0; i < 3; i++) at[k][i] = Random(i < 2 ? -4 : 0, 4);
  ok(SlipDippingDisplacement(0.25, PETSC_FALSE, &r, slip, MANY, &at[0][0], &u[0][0]));
  ok(SlipDippingStress(1, 0.25, PETSC_FALSE, &r, slip, MANY, &at[0][0], &s[0][0]));
  for (int k = 0; k < MANY; k++) {
    ok(SlipDippingDisplacement(0.25, PETSC_FALSE, &r, slip, 1, at[k], one));
    for (int i = 0; i < 3; i++) AssertNear(one[i], u[k][i], 1e-15);
    ok(SlipDippingStress(1, 0.25, PETSC_FALSE, &r, slip, 1, at[k], one));
    for (int i = 0; i < 6; i++) AssertNear(one[i], s[k][i], 1e-13);
  }
  fails(SlipDippingStress(1, 0.5, PETSC_FALSE, &r, slip, 1, at[0], one),
        "Poisson's ratio must lie in (-1, 0.5), not 0.5");
  at[1][2] = -1;
  fails(SlipDippingStress(1, 0.25, PETSC_FALSE, &r, slip, 2, at[0], s[0]), "above the ground, expected below it");
  ok(SlipDippingStress(1, 0.25, PETSC_TRUE, &r, slip, 2, at[0], s[0]));
  wrong = r;
  wrong.z = 0.5;
  fails(SlipDippingDisplacement(0.25, PETSC_FALSE, &wrong, slip, 1, at[0], one), "above the ground");
  ok(SlipDippingDisplacement(0.25, PETSC_TRUE, &wrong, slip, 1, at[0], one));
  wrong.dip = 90.5;
  fails(SlipDippingDisplacement(0.25, PETSC_TRUE, &wrong, slip, 1, at[0], one), "90.5");
  wrong = r;
  wrong.width = 0;
  fails(SlipDippingDisplacement(0.25, PETSC_TRUE, &wrong, slip, 1, at[0], one),
        "Length and width of a rectangle must be positive");
  wrong.width = NAN;
  fails(SlipDippingGradient(0.25, PETSC_TRUE, &wrong, slip, 1, at[0], one), "x y z length width strike dip");
}

SLIP_TESTS(vertical, near_vertical, units, extensions, sides, edges, tractions, input)
