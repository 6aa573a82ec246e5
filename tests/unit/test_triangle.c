/* Fields of triangles against published numbers, rectangles, a free surface and a quadrature of point sources. */
#include "unit.h"
#include "pointsource.h"
#include <math.h>

static PetscReal Random(PetscReal from, PetscReal to)
{
  static uint64_t last = 2015;

  last = last * 6364136223846793005u + 1442695040888963407u;
  return from + (to - from) * (PetscReal)(last >> 11) / 9007199254740992.0;
}

static PetscReal Largest(PetscInt n, const PetscReal v[])
{
  PetscReal most = 0;

  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, PetscAbsReal(v[i]));
  return most;
}

/* Displacement [3] and gradient [3][3] */
static void Fields(PetscReal nu, PetscBool full, PetscReal vertices[3][3], const PetscReal slip[3],
                   const PetscReal at[3], PetscReal field[12])
{
  ok(SlipTriangleDisplacement(nu, full, vertices[0], slip, 1, at, field));
  ok(SlipTriangleGradient(nu, full, vertices[0], slip, 1, at, field + 3));
}

/* ---- numbers of Nikkhoo and Walter (2015), doubles by their own code: lambda = mu = 1, x east, y north, z up. Slip
   is along e_z x normal, up dip and opening, of the side of the normal (P2 - P1) x (P3 - P1). ---- */
typedef struct {
  PetscBool full;
  PetscReal vertices[3][3], slip[3], at[3], u[3], stress[6];
} Published;

#define SIMPLE                                                                                                         \
  {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},                                                                                   \
  {                                                                                                                    \
    1, 0, 0                                                                                                            \
  }
#define BURIED                                                                                                         \
  {{0, 0.1, -0.1}, {1, -0.2, -0.2}, {1, 1, -0.3}},                                                                     \
  {                                                                                                                    \
    1.3, 1.4, 1.5                                                                                                      \
  }

static const Published Doubles[] = {
  {PETSC_TRUE,
   SIMPLE,
   {1.2, 0.6, -0.6},
   {-7.0288078512746859e-03, -1.1441442378132355e-02, 1.0062032831061142e-02},
   {3.3329704974121632e-02, 2.3492326135992597e-03, 2.1986423308767426e-02, 1.7776927046311911e-02,
    -3.6646233266027887e-02, 2.9477438122424565e-03}},
  {PETSC_TRUE,
   SIMPLE,
   {1.2, 0.6, 1.8},
   {8.3345940045261198e-04, 3.3786447203081396e-03, 2.5364326715365190e-03},
   {-4.0944027575961529e-04, 1.7319147947606663e-03, -7.1627310890961370e-03, 7.5905515989943551e-04,
    -3.4379115127278516e-03, 4.6207390409161043e-03}},
  {PETSC_TRUE,
   SIMPLE,
   {0.6, 0.0, 2.4},
   {-2.2131745023634686e-04, 2.4615524498679438e-03, -1.8860546730686302e-03},
   {-5.0949954147939524e-04, -1.0470902824517092e-03, 4.8895028368629951e-03, 7.5771436826951866e-05,
    7.9629404661161682e-04, 3.2071102816324248e-03}},
  {PETSC_FALSE,
   BURIED,
   {1.2, 0.6, -3.6},
   {-6.8849027662109315e-05, 3.3057715662497371e-04, -3.3961335197468835e-03},
   {7.4975653330618380e-04, 6.0799296057182598e-04, -5.4024184009692049e-03, -1.7157423196624512e-04,
    -1.1531136048015629e-03, 1.5844957568475759e-03}},
  {PETSC_FALSE,
   BURIED,
   {-0.6, 1.2, 0.0},
   {-1.1925561122541034e-02, 1.2958724288512604e-02, 2.1441375274943719e-03},
   {-7.3339294411995992e-02, -2.7629763434179715e-02, 0, 4.3410533017012351e-02, 0, 0}},
  {PETSC_FALSE,
   BURIED,
   {0.6, 0.0, -0.6},
   {4.2900557302489317e-02, -3.9637572869472476e-02, -9.3038485834666063e-02},
   {-1.9121527228034432e-01, -4.2017495152416429e-02, -4.2679544262174463e-01, -2.5558707295320469e-02,
    -2.4575223352024705e-01, -2.9208156679851394e-01}},
};

/* 1e-9 of the largest: both lose a few of sixteen digits between edges, and theirs in angles besides */
static void published_doubles(void **state)
{
  for (size_t p = 0; p < PETSC_STATIC_ARRAY_LENGTH(Doubles); p++) {
    const Published *d = &Doubles[p];
    const PetscReal at[3] = {d->at[1], d->at[0], -d->at[2]};
    PetscReal v[3][3], a[2][3], side[3], theirs[9], ours[9], slip[3] = {0}, u[3], s[6];

    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 3; i++) v[k][i] = i < 2 ? d->vertices[k][1 - i] : -d->vertices[k][2];
    for (int k = 0; k < 2; k++)
      for (int i = 0; i < 3; i++) a[k][i] = v[k + 1][i] - v[0][i];
    for (int i = 0; i < 3; i++) side[i] = a[0][(i + 1) % 3] * a[1][(i + 2) % 3] - a[0][(i + 2) % 3] * a[1][(i + 1) % 3];
    ok(SlipTriangleDirections(v[0], side, NULL, theirs));
    ok(SlipTriangleDirections(v[0], NULL, NULL, ours));
    { /* the jump has the sign of the side to which it belongs */
      const PetscReal same = theirs[6] * ours[6] + theirs[7] * ours[7] + theirs[8] * ours[8];

      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          for (int l = 0; l < 3; l++) slip[i] += same * ours[3 * i + l] * theirs[3 * j + l] * d->slip[j];
    }
    ok(SlipTriangleDisplacement(0.25, d->full, v[0], slip, 1, at, u));
    ok(SlipTriangleStress(1, 0.25, d->full, v[0], slip, 1, at, s));
    {
      const PetscReal east[3] = {u[1], u[0], -u[2]}, tensor[6] = {s[1], s[0], s[2], s[3], -s[5], -s[4]};

      for (int i = 0; i < 3; i++) AssertNear(east[i], d->u[i], 1e-9 * Largest(3, d->u));
      for (int i = 0; i < 6; i++) AssertNear(tensor[i], d->stress[i], 1e-9 * Largest(6, d->stress));
    }
  }
}

/* Two triangles, on either diagonal, are a rectangle. Both lose 1e-16 (d/a)^2 at the distance d, below 1e-13 here but
   for points at a hundred of the shorter side; displacement that is small for its slip loses some more. */
static void two_make_a_rectangle(void **state)
{
  static const int cut[2][2][3] = {{{0, 1, 2}, {3, 0, 2}}, {{1, 0, 3}, {2, 1, 3}}};
  static const PetscReal ratios[3] = {0, 0.25, 0.4};
  PetscReal worst = 0;

  for (int trial = 0; trial < 3000; trial++) {
    const PetscReal dip = trial % 7 == 1 ? 90 : Random(0.5, 90), nu = ratios[trial % 3];
    const PetscBool full = (PetscBool)(trial % 4 == 3);
    SlipDippingRectangle r = {Random(-3, 3), Random(-3, 3), 0, Random(0.5, 4), Random(0.5, 4), Random(0, 360), dip};
    const PetscReal slip[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)};
    PetscReal at[3] = {Random(-6, 6), Random(-6, 6), trial % 5 ? Random(0, 6) : 0}, corner[4][3], d[3][3], want[12];
    PetscReal sum[12] = {0};

    if (dip == 90) r.strike = Random(0, 180); /* a vertical triangle's */
    r.z = 0.5 * r.width * sin(dip * PETSC_PI / 180) + (trial % 3 ? Random(0, 3) : 0);
    SlipPlaneDirections(r.strike, r.dip, 0, d[0]);
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < 3; i++)
        corner[k][i] = (i == 0   ? r.x
                        : i == 1 ? r.y
                                 : r.z) +
                       0.5 * (k == 0 || k == 3 ? -1 : 1) * r.length * d[0][i] +
                       0.5 * (k < 2 ? -1 : 1) * r.width * d[1][i];
    if (trial % 6 == 2) /* in the plane */
      for (int i = 0; i < 3; i++) at[i] = corner[0][i] + 0.3 * r.length * d[0][i] + 0.6 * r.width * d[1][i];
    ok(SlipDippingDisplacement(nu, full, &r, slip, 1, at, want));
    ok(SlipDippingGradient(nu, full, &r, slip, 1, at, want + 3));
    for (int half = 0; half < 2; half++) {
      PetscReal v[3][3], field[12];

      for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) v[k][i] = corner[cut[trial % 2][half][k]][i];
      Fields(nu, full, v, slip, at, field);
      for (int i = 0; i < 12; i++) sum[i] += field[i];
    }
    for (int i = 0; i < 12; i++) {
      const PetscReal size = i < 3 ? Largest(3, want) : Largest(9, want + 3);

      worst = PetscMax(worst, PetscAbsReal(sum[i] - want[i]) / size);
      AssertNear(sum[i], want[i], 1e-11 * size);
    }
  }
}

/* Vertices within a ball, below the ground, none flatter than a tenth; up to it where touch is true */
static void AnyTriangle(PetscBool touch, PetscReal v[3][3])
{
  const PetscReal middle[3] = {Random(-5, 5), Random(-5, 5), Random(0, 4)};
  PetscReal top = PETSC_MAX_REAL, least, most;

  do {
    PetscReal area = 0;

    most = 0;
    for (int k = 0; k < 3; k++)
      for (int i = 0; i < 3; i++) v[k][i] = middle[i] + Random(-2, 2);
    for (int k = 0; k < 3; k++) {
      const PetscReal *p = v[k], *q = v[(k + 1) % 3], *r = v[(k + 2) % 3];
      PetscReal a2 = 0, b2 = 0, ab = 0;

      for (int i = 0; i < 3; i++) {
        a2 += PetscSqr(q[i] - p[i]);
        b2 += PetscSqr(r[i] - p[i]);
        ab += (q[i] - p[i]) * (r[i] - p[i]);
      }
      area = PetscSqrtReal(a2 * b2 - ab * ab);
      most = PetscMax(most, PetscSqrtReal(a2));
    }
    least = area / most;
  } while (least < 0.1 * most);
  for (int k = 0; k < 3; k++) top = PetscMin(top, v[k][2]);
  if (touch || top < 0)
    for (int k = 0; k < 3; k++) v[k][2] -= top;
}

#define NODES 30
/* By quadrature over a triangle, of the square (a, b) with the vertex 0 at a = 0: NODES^2 point sources */
static void Quadrature(PetscReal nu, PetscBool full, PetscReal v[3][3], const PetscReal slip[3], const PetscReal at[3],
                       PetscReal sum[12])
{
  PetscReal node[NODES], weight[NODES], d[3][3], b[3], e[2][3], cross[3], area;

  Gauss(NODES, node, weight);
  ok(SlipTriangleDirections(v[0], NULL, NULL, d[0]));
  for (int i = 0; i < 3; i++) {
    b[i] = slip[0] * d[0][i] + slip[1] * d[1][i] + slip[2] * d[2][i];
    e[0][i] = v[1][i] - v[0][i];
    e[1][i] = v[2][i] - v[1][i];
  }
  for (int i = 0; i < 3; i++) cross[i] = e[0][(i + 1) % 3] * e[1][(i + 2) % 3] - e[0][(i + 2) % 3] * e[1][(i + 1) % 3];
  area = PetscSqrtReal(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]); /* twice */
  for (int k = 0; k < 12; k++) sum[k] = 0;
  for (int i = 0; i < NODES; i++)
    for (int j = 0; j < NODES; j++) {
      const PetscReal p = 0.5 + node[i], q = 0.5 + node[j];
      PetscReal from[3], field[12];

      for (int l = 0; l < 3; l++) from[l] = v[0][l] + p * (e[0][l] + q * e[1][l]);
      PointSource(nu, full, b, d[2], at, from, field);
      for (int k = 0; k < 12; k++) sum[k] += weight[i] * weight[j] * p * area * field[k];
    }
}

static PetscReal Apart(PetscReal v[3][3], const PetscReal at[3])
{
  PetscReal least = PETSC_MAX_REAL;

  for (int i = 0; i <= 20; i++)
    for (int j = 0; j <= 20 - i; j++) {
      PetscReal sum = 0;

      for (int l = 0; l < 3; l++) sum += PetscSqr((i * v[0][l] + j * v[1][l] + (20 - i - j) * v[2][l]) / 20 - at[l]);
      least = PetscMin(least, sum);
    }
  return PetscSqrtReal(least);
}

static PetscReal LongestSide(PetscReal v[3][3])
{
  PetscReal most = 0;

  for (int k = 0; k < 3; k++) {
    PetscReal sum = 0;

    for (int i = 0; i < 3; i++) sum += PetscSqr(v[(k + 1) % 3][i] - v[k][i]);
    most = PetscMax(most, sum);
  }
  return PetscSqrtReal(most);
}

/* 60 triangles, some up to the ground, some points of each on it, any slip. A point is at least half of a side away:
   30 nodes are off by (1 + sqrt 2)^-60 = 1e-23, beside which edges lose 1e-15 (d/a)^2, 1e-12 for the farthest points
   and the flattest triangles. */
static void quadrature(void **state)
{
  PetscReal worst = 0;

  for (int pair = 0; pair < 60; pair++) {
    const PetscBool full = (PetscBool)(pair % 5 == 4);
    const PetscReal nu = pair % 7 == 3 ? 0 : Random(-0.5, 0.48),
                    slip[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)};
    PetscReal v[3][3], at[3], ours[12], sum[12];

    AnyTriangle((PetscBool)(pair % 3 == 0), v);
    if (pair % 6 == 1) v[2][2] = v[1][2] = v[0][2] = 0.5; /* horizontal */
    if (pair % 6 == 2) v[2][0] = 0.3 * v[0][0] + 0.7 * v[1][0], v[2][1] = 0.3 * v[0][1] + 0.7 * v[1][1]; /* vertical */
    do {
      for (int i = 0; i < 2; i++) at[i] = v[0][i] + Random(-6, 6);
      at[2] = pair % 4 ? Random(0, 8) : 0;
    } while (Apart(v, at) < 0.5 * LongestSide(v));
    Quadrature(nu, full, v, slip, at, sum);
    Fields(nu, full, v, slip, at, ours);
    for (int k = 0; k < 12; k++) {
      const PetscReal size = k < 3 ? Largest(3, sum) : Largest(9, sum + 3);

      worst = PetscMax(worst, PetscAbsReal(ours[k] - sum[k]) / size);
      AssertNear(ours[k], sum[k], 1e-11 * size);
    }
  }
}

/* Far away edges cancel: at the distance d from a triangle of the side 1 and the height h they leave 1e-15 d^2 / h, h
   > 0.1. */
static void far_away(void **state)
{
  for (int power = 1; power <= 4; power++) {
    const PetscReal d = pow(10, power);
    PetscReal worst = 0;

    for (int trial = 0; trial < 20; trial++) {
      const PetscReal slip[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)}, turn = Random(0, 2 * PETSC_PI);
      PetscReal v[3][3], at[3], ours[12], sum[12], side;

      AnyTriangle((PetscBool)(trial % 2), v);
      side = LongestSide(v);
      for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) v[k][i] /= side;
      at[0] = v[0][0] + d * cos(turn);
      at[1] = v[0][1] + d * sin(turn);
      at[2] = trial % 3 ? Random(0, 1) * d : 0;
      Quadrature(0.25, (PetscBool)(trial % 4 == 3), v, slip, at, sum);
      Fields(0.25, (PetscBool)(trial % 4 == 3), v, slip, at, ours);
      for (int k = 0; k < 12; k++) {
        const PetscReal error = PetscAbsReal(ours[k] - sum[k]) / (k < 3 ? Largest(3, sum) : Largest(9, sum + 3));

        worst = PetscMax(worst, error);
      }
    }
    AssertLess(worst, 1e-13 * d * d);
  }
}

/* Slivers: their two long edges cancel to 1e-15 of the side over the height. */
static void slivers(void **state)
{
  for (int power = 1; power <= 5; power++) {
    const PetscReal height = pow(10, -power);
    PetscReal worst = 0;

    for (int trial = 0; trial < 20; trial++) {
      const PetscReal slip[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)};
      PetscReal v[3][3], at[3], ours[12], sum[12], share = Random(0, 1);

      AnyTriangle((PetscBool)(trial % 2), v);
      for (int i = 0; i < 3; i++) v[2][i] = (1 - height) * (share * v[0][i] + (1 - share) * v[1][i]) + height * v[2][i];
      do {
        for (int i = 0; i < 2; i++) at[i] = v[0][i] + Random(-4, 4);
        at[2] = trial % 4 ? Random(0, 6) : 0;
      } while (Apart(v, at) < 0.5 * LongestSide(v));
      Quadrature(0.25, PETSC_FALSE, v, slip, at, sum);
      Fields(0.25, PETSC_FALSE, v, slip, at, ours);
      for (int k = 0; k < 12; k++) {
        const PetscReal error = PetscAbsReal(ours[k] - sum[k]) / (k < 3 ? Largest(3, sum) : Largest(9, sum + 3));

        worst = PetscMax(worst, error);
      }
    }
    AssertLess(worst, 1e-12 / height);
  }
}

SLIP_TESTS(published_doubles, two_make_a_rectangle, quadrature, far_away, slivers)
