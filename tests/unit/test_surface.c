/* Displacement of the free surface against Okada's table, quadrature of point sources by the solutions of Boussinesq
   and Cerruti, and a screw dislocation; its sides, its parts, and the points at which formulas have 0 / 0. */
#include "unit.h"
#include <math.h>

static const PetscReal Ratios[] = {0.25, 0, 0.4, -0.2};

static void Displacement(PetscReal nu, const SlipRectangle *source, PetscReal x, PetscReal y, PetscReal u[3])
{
  const PetscReal point[2] = {x, y};

  SlipSurfaceDisplacement(nu, source, 1, point, u);
}

/* Case 3 of table 2 of Okada (1985), to half of its last digit; his y and z point against ours. Central differences
   over 1e-4 are off by 1e-8. */
static void test_published_values(void **state)
{
  const SlipRectangle source = {1.5, 0, 3, 3, 2};
  const PetscReal h = 1e-4, points[5][2] = {{0, 0}, {-h, 0}, {h, 0}, {0, -h}, {0, h}};
  PetscReal u[5][3], along[3], across[3];

  SlipSurfaceDisplacement(0.25, &source, 5, &points[0][0], &u[0][0]);
  for (int k = 0; k < 3; k++) {
    along[k] = (u[2][k] - u[1][k]) / (2 * h);
    across[k] = (u[4][k] - u[3][k]) / (2 * h);
  }
  AssertNear(u[0][0], 0, 0);
  AssertNear(u[0][1], -5.253e-3, 0.5e-6);
  AssertNear(u[0][2], 0, 0);
  AssertNear(along[0], 0, 1e-8);
  AssertNear(across[0], 1.864e-2, 0.5e-5);
  AssertNear(along[1], 2.325e-3, 0.5e-6);
  AssertNear(across[1], 0, 1e-8);
  AssertNear(along[2], 0, 1e-8);
  AssertNear(across[2], 2.289e-2, 0.5e-5);
}

/* 4 pi G times the displacement along i, at the distance r from a unit force along k on the surface: Cerruti's
   solution, and Boussinesq's for k = 2 (Love 1927, sections 135 and 167) */
static PetscReal Force(PetscReal nu, int k, int i, const PetscReal r[3])
{
  const PetscReal m = 1 - 2 * nu, R = PetscSqrtReal(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]), T = R + r[2];
  const PetscReal direct = (i == k ? 1 / R : 0) + r[i] * r[k] / (R * R * R);

  if (k == 2) return i == 2 ? direct + m / R : direct - m * r[i] / (R * T);
  if (i == 2) return direct + m * r[k] / (R * T);
  return direct + m * ((i == k ? 1 / T : 0) - r[i] * r[k] / (R * T * T));
}

/* Betti: the displacement along k of a point of the surface is the stress xy that a unit force along k there makes on
   the source. The shear strain by differences of the fourth order over R / 1000, off by 1e-12 of it; rounding by
   1e-13. */
static PetscReal PointSource(PetscReal nu, int k, const PetscReal r[3])
{
  const PetscReal h = 1e-3 * PetscSqrtReal(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  PetscReal strain = 0;

  for (int by = 0; by < 2; by++)
    for (int step = 1; step <= 2; step++)
      for (int sign = -1; sign <= 1; sign += 2) {
        PetscReal at[3] = {r[0], r[1], r[2]};

        at[by] += sign * step * h;
        strain += sign * (step == 1 ? 8 : -1) / (12 * h) * Force(nu, k, 1 - by, at);
      }
  return strain / (4 * PETSC_PI);
}

#define PANELS 12

/* Fifty points within four lengths of a source, a third of its size from it at least: panels of a twelfth with Gauss'
   5 points are off by (1/16)^10, the differences by 1e-12. */
static void test_against_point_sources(void **state)
{
  const PetscReal node[5] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831, 0.9061798459386640};
  const PetscReal weight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                               0.2369268850561891};
  const SlipRectangle source = {0.7, -0.4, 1.1, 1.5, 1};
  PetscReal point[2];

  for (int n = 0; n < 50; n++) {
    const PetscReal nu = Ratios[n % 4];
    PetscReal u[3], sum[3] = {0, 0, 0};

    for (int i = 0; i < 2; i++) point[i] = 8 * fmod((n + 1) * (i ? 0.7548776662466927 : 0.5698402909980532), 1) - 4;
    Displacement(nu, &source, point[0], point[1], u);
    for (int a = 0; a < 5 * PANELS; a++)
      for (int b = 0; b < 5 * PANELS; b++) {
        const PetscReal along = (a / 5 + 0.5 + 0.5 * node[a % 5]) / PANELS - 0.5;
        const PetscReal down = (b / 5 + 0.5 + 0.5 * node[b % 5]) / PANELS - 0.5;
        const PetscReal r[3] = {source.x + along * source.length - point[0], source.y - point[1],
                                source.z + down * source.width};

        for (int k = 0; k < 3; k++)
          sum[k] += 0.25 * weight[a % 5] * weight[b % 5] / (PANELS * PANELS) * source.length * source.width *
                    PointSource(nu, k, r);
      }
    for (int k = 0; k < 3; k++) AssertNear(u[k], sum[k], 1e-11);
  }
}

/* Infinitely long, u_x = (atan(bottom / y) - atan(top / y)) / pi; what a length of 2e5 depths leaves out is
   below y depth / (length / 2)^2 = 1e-9. */
static void test_screw_dislocation(void **state)
{
  const PetscReal tops[] = {0, 0.3};

  for (int t = 0; t < 2; t++) {
    const SlipRectangle source = {0, 0, 0.5 * (tops[t] + 1), 2e5, 1 - tops[t]};

    for (PetscReal y = 0.01; y < 10; y *= 3) {
      PetscReal u[3], other[3];

      Displacement(0.3, &source, 0, y, u);
      AssertNear(u[0], (PetscAtanReal(1 / y) - PetscAtanReal(tops[t] / y)) / PETSC_PI, 1e-9);
      AssertNear(u[1], 0, 1e-9);
      AssertNear(u[2], 0, 1e-9);
      Displacement(0.3, &source, 0, -y, other);
      AssertNear(other[0], -u[0], 0);
      AssertNear(other[1], u[1], 0);
      AssertNear(other[2], -u[2], 0);
    }
  }
}

/* On the trace of a rectangle that breaks the surface, on its ends, on the continuation of both, and above a buried
   one: the limits from either side, where a step of 1e-9 changes nothing but the side. */
static void test_trace(void **state)
{
  const SlipRectangle breaking = {2, 5, 0.5, 4, 1}, buried = {2, 5, 1, 4, 1};
  const PetscReal xs[] = {1, 2.7, 5, -3, 0, 4}, expected[] = {0.5, 0.5, 0, 0, 0.25, 0.25};

  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(xs); i++) {
    PetscReal u[3], side[3];

    Displacement(0.25, &breaking, xs[i], 5, u);
    AssertNear(u[0], expected[i], 1e-15);
    AssertNear(u[2], 0, 0);
    assert_true(isfinite(u[1]));
    Displacement(0.25, &breaking, xs[i], 5 - 1e-9, side);
    AssertNear(side[0], -expected[i], 1e-15);
    AssertNear(side[1], u[1], 0);
    Displacement(0.25, &buried, xs[i], 5, u);
    AssertNear(u[0], 0, 1e-16);
  }
  /* beside the trace by more than what counts as on it: the same but for slopes of order 1 times 1e-5 */
  for (int i = 0; i < 4; i++) {
    PetscReal u[3], near[3];

    Displacement(0.25, &breaking, xs[i], 5, u);
    Displacement(0.25, &breaking, xs[i], 5 + 1e-5, near);
    for (int k = 0; k < 3; k++) AssertNear(near[k], u[k], 1e-5);
  }
}

/* A rectangle is the sum of its parts, everywhere but for rounding: also where parts meet on the trace, and where it
   ends. */
static void test_parts_add_up(void **state)
{
  const SlipRectangle whole = {30, -10, 50, 200, 100};
  const PetscReal points[][2] = {{300, 40}, {30, -10}, {80, -10}, {130, 0}, {-70, -10.5}, {-20, -10}, {31, -9.99}};

  for (size_t p = 0; p < PETSC_STATIC_ARRAY_LENGTH(points); p++) {
    PetscReal expected[3], sum[3] = {0, 0, 0};

    Displacement(0.1, &whole, points[p][0], points[p][1], expected);
    for (int i = 0; i < 4; i++)
      for (int j = 0; j < 3; j++) {
        const SlipRectangle part = {30 + 50 * (i - 1.5), -10, 50 + 100. / 3 * (j - 1), 50, 100. / 3};
        PetscReal u[3];

        Displacement(0.1, &part, points[p][0], points[p][1], u);
        for (int k = 0; k < 3; k++) sum[k] += u[k];
      }
    for (int k = 0; k < 3; k++) AssertNear(sum[k], expected[k], 2e-14);
  }
}

SLIP_TESTS(test_published_values, test_against_point_sources, test_screw_dislocation, test_trace, test_parts_add_up)
