/* The pure functions of the cone with two components a cell: natural map, generalised Jacobian, finish. */
#include "unit.h"
#include "vectors.h"

enum { N = 3, DIM = 2 * N };

/* q = 1 - 0.3 |x| of each cell, dq = -0.3; g = B x - c */
static void Natural(PetscReal B[DIM][DIM], const PetscReal c[], PetscReal omega, const PetscReal x[],
                    PetscReal weakening, PetscReal F[], PetscReal mask[], PetscReal slope[], PetscReal cross[],
                    PetscReal normal[], PetscReal hold[], PetscReal z[])
{
  PetscReal g[DIM], q[N], dq[N], rho[DIM];

  for (PetscInt i = 0; i < DIM; i++) {
    g[i] = -c[i];
    for (PetscInt j = 0; j < DIM; j++) g[i] += B[i][j] * x[j];
    rho[i] = 0.3;
    z[i] = x[i] - rho[i] * g[i];
  }
  for (PetscInt i = 0; i < N; i++) {
    q[i] = 1 - weakening * hypot(x[2 * i], x[2 * i + 1]);
    dq[i] = -weakening;
  }
  SlipDiskNatural(N, 2, omega, x, g, q, rho, F, mask, normal, hold);
  SlipDiskSlope(N, 2, omega, x, dq, normal, hold, slope, cross);
}

/* The Jacobian B + slope, its rows across n divided by |z| / (|z| - rho omega q), against central differences of the
   natural residual: at any points where q is constant, and where it weakens at points whose z goes along x, as at
   solutions. The error of the differences is h^2 times third derivatives of at most 1e2 (|z| > 0.3 rho) and 1e-16 /
   h, together 1e-8. So is that of n n' F + |z| / (|z| - rho omega q) P F = F + k P x. */
static void jacobian_is_the_derivative(void **state)
{
  const PetscReal omega = 2, rho = 0.3, h = 1e-5;
  uint64_t seed = 1;
  PetscInt sliding = 0, sticking = 0;

  for (int trial = 0; trial < 300; trial++) {
    const PetscReal weakening = trial % 2 ? 0.3 : 0;
    PetscReal B[DIM][DIM], x[DIM], c[DIM], F[DIM], mask[DIM], slope[DIM], cross[N], normal[DIM], hold[N], z[DIM];

    for (PetscInt i = 0; i < DIM; i++) {
      x[i] = 2 * VectorsRandom(&seed) - 1;
      for (PetscInt j = 0; j <= i; j++) B[i][j] = B[j][i] = 2 * VectorsRandom(&seed) - 1;
    }
    for (PetscInt i = 0; i < N; i++) { /* a load that makes z what it is to be */
      const PetscReal size = VectorsRandom(&seed) * 2, angle = 2 * PETSC_PI * VectorsRandom(&seed);
      const PetscReal along = size / hypot(x[2 * i], x[2 * i + 1]);

      z[2 * i] = weakening != 0 ? along * x[2 * i] : size * cos(angle);
      z[2 * i + 1] = weakening != 0 ? along * x[2 * i + 1] : size * sin(angle);
    }
    for (PetscInt i = 0; i < DIM; i++) {
      c[i] = -(x[i] - z[i]) / rho;
      for (PetscInt j = 0; j < DIM; j++) c[i] += B[i][j] * x[j];
    }
    Natural(B, c, omega, x, weakening, F, mask, slope, cross, normal, hold, z);
    for (PetscInt j = 0; j < DIM; j++) {
      PetscReal y[DIM], ahead[DIM], behind[DIM], m[DIM], s[DIM], k[N], n[DIM], t[N], other[DIM];

      memcpy(y, x, sizeof(y));
      y[j] = x[j] + h;
      Natural(B, c, omega, y, weakening, ahead, m, s, k, n, t, other);
      y[j] = x[j] - h;
      Natural(B, c, omega, y, weakening, behind, m, s, k, n, t, other);
      for (PetscInt i = 0; i < N; i++) {
        const PetscReal *to = &normal[2 * i], size = hypot(z[2 * i], z[2 * i + 1]);
        const PetscReal wq = omega * (1 - weakening * hypot(x[2 * i], x[2 * i + 1])), share = 1 - rho * wq / size;
        const PetscReal difference[] = {(ahead[2 * i] - behind[2 * i]) / (2 * h),
                                        (ahead[2 * i + 1] - behind[2 * i + 1]) / (2 * h)};
        PetscReal row[] = {B[2 * i][j], B[2 * i + 1][j]}, along, across;

        if (PetscAbsReal(share) < 0.1) continue; /* differences across the edge, or with large derivatives */
        if (mask[2 * i] == 0) {
          sticking++;
          assert_true(share < 0 && mask[2 * i + 1] == 0 && slope[2 * i] == 0 && slope[2 * i + 1] == 0 && cross[i] == 0);
          for (int l = 0; l < 2; l++) AssertNear(difference[l], 2 * i + l == j ? 1 / rho : 0, 1e-8);
          continue;
        }
        sliding++;
        if (j == 2 * i) row[0] += slope[j], row[1] += cross[i];
        if (j == 2 * i + 1) row[0] += cross[i], row[1] += slope[j];
        along = to[0] * row[0] + to[1] * row[1];
        across = share * (to[0] * row[1] - to[1] * row[0]);
        AssertNear(difference[0], along * to[0] - across * to[1], 1e-6);
        AssertNear(difference[1], along * to[1] + across * to[0], 1e-6);
        if (j == 2 * i) { /* once a cell */
          const PetscReal *f = &F[j], *at = &x[j], part = (to[0] * f[1] - to[1] * f[0]) * (1 / share - 1);
          const PetscReal turn = hold[i] * (to[0] * at[1] - to[1] * at[0]);

          AssertNear(part, turn, 1e-12);
        }
      }
    }
  }
  assert_true(sliding > 1000 && sticking > 1000);
}

/* Zero at solutions g = omega r, whatever rho: slides, sticks at rest, sticks at the edge, no bound */
static void natural_map_is_zero_at_solutions(void **state)
{
  const PetscReal x[] = {3, 4, 0, 0, 0, 0, 5, -1}, q[] = {1, 1, 1.25, 0}, omega = 2, dq[4] = {0};
  const PetscReal g[] = {-1.2, -1.6, 1.2, -1, 1.5, 2, 0, 0};
  PetscReal F[8], mask[8], normal[8], hold[4], slope[8], cross[4], r[8], y[8];

  for (PetscReal s = 0.125; s < 20; s *= 4) {
    const PetscReal rho[] = {s, s, s, s, s, s, s, s};

    SlipDiskNatural(4, 2, omega, x, g, q, rho, F, mask, normal, hold);
    for (int i = 0; i < 8; i++) AssertNear(F[i], 0, 1e-14); /* rounding of |z| of at most 40 s in units of s */
    assert_true(mask[0] == 1 && mask[2] == 0 && mask[4] == 0 && mask[6] == 1);
    AssertNear(hold[0], omega * q[0] / 5, 1e-12); /* q / |x| */
    assert_true(hold[1] == 0 && hold[3] == 0 && normal[6] == 0);
    SlipDiskSlope(4, 2, omega, x, dq, normal, hold, slope, cross);
    assert_true(slope[6] == 0 && slope[7] == 0 && cross[3] == 0);
    memcpy(y, x, sizeof(x));
    SlipDiskFinish(4, 2, omega, g, q, rho, y, r);
    for (int i = 0; i < 8; i++) AssertNear(y[i], x[i], 1e-14);
    for (int i = 0; i < 8; i++) AssertNear(r[i], g[i] / omega, 1e-14);
    SlipDiskProject(4, 2, omega, x, g, q, rho, y);
    for (int i = 0; i < 8; i++) AssertNear(y[i], x[i], 1e-13 * s + 1e-14);
  }
}

/* On the way to the edge of sticking k grows to 1e6 / rho, and everything is a number; a load that is none shows. */
static void edge_of_sticking(void **state)
{
  const PetscReal x[2] = {0}, q = 1, dq = -1, rho[] = {0.5, 0.5};
  PetscReal F[2], mask[2], normal[2], hold, slope[2], cross;

  for (int k = 0; k < 40; k++) {
    const PetscReal size = 1 + pow(10, 2 - k), g[] = {-0.6 * size, -0.8 * size};

    SlipDiskNatural(1, 2, 1, x, g, &q, rho, F, mask, normal, &hold);
    SlipDiskSlope(1, 2, 1, x, &dq, normal, &hold, slope, &cross);
    assert_true(mask[0] == (size > 1 ? 1 : 0));
    if (size > 1 && size < 1 + 2e-7) assert_true(hold == 1e6 / rho[0]);
    assert_true(hold <= 2e6 && isfinite(slope[0]) && isfinite(slope[1]) && isfinite(cross));
    if (size > 1 + 1e-15) AssertNear(slope[0] + slope[1], hold - 1, 1e-9);
    if (size > 1 + 1e-5) AssertNear(hold * (size - 1), 1 / rho[0], 1e-9);
  }
  {
    const PetscReal g[] = {NAN, 0};

    SlipDiskNatural(1, 2, 1, x, g, &q, rho, F, mask, normal, &hold);
    assert_true(isnan(F[0]));
  }
}

/* Backwards means by more than a right angle; without a bound x is left alone. */
static void finish_and_turning(void **state)
{
  const PetscReal q[] = {1, 1, 1, 0}, rho[] = {1, 1, 1, 1, 1, 1, 1, 1}, g[] = {0, -3, -3, 0, -3, 0, 0, 4};
  const PetscReal from[] = {1, 0, 1, 0, 1, 0, 1, 0};
  PetscReal x[] = {0.5, 0.5, -0.5, 0.5, 0, 0.25, -7, 2}, r[8], to[] = {0.1, 5, -0.1, 5, 0, 5, -1, 0};

  SlipDiskFinish(4, 2, 1, g, q, rho, x, r);
  AssertNear(x[0] * 3.5, x[1] * 0.5, 1e-15); /* along z = (0.5, 3.5), as fast as before */
  AssertNear(hypot(x[0], x[1]), hypot(0.5, 0.5), 1e-15);
  AssertNear(hypot(r[0], r[1]), 1, 1e-15);
  assert_true(r[0] < 0 && r[1] < 0);
  assert_true(x[2] == 0 && x[3] == 0 && r[2] == -1 && r[3] == 0); /* backwards: stops, the balance on the disk */
  AssertNear(x[4] * 0.25, x[5] * 3, 1e-15);
  assert_true(x[6] == -7 && x[7] == 2 && r[6] == 0 && r[7] == 0);
  assert_true(SlipDiskStopTurning(4, 2, q, from, to));
  assert_true(to[0] == 0.1 && to[1] == 5 && to[2] == 0 && to[3] == 0 && to[5] == 5 && to[6] == -1);
  assert_false(SlipDiskStopTurning(4, 2, q, from, to));
}

SLIP_TESTS(jacobian_is_the_derivative, natural_map_is_zero_at_solutions, edge_of_sticking, finish_and_turning)
