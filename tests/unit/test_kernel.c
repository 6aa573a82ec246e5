/* The closed-form kernel against published values and against numerical integration of Mindlin's point-force
   solution. */
#include "unit.h"

typedef long double Long;

/* ---- independent evaluation ----
   Mindlin (1936): displacement component i of a unit force along j in {x, y} (G = 1) at depth c, receiver at (x, y, z);
   as printed, term by term. surface = 0 leaves Kelvin's full-space solution. */
typedef struct {
  Long nu, c, z;
  int surface;
} Medium;

static Long Mindlin(const Medium *m, int i, int j, Long x, Long y)
{
  const Long r[2] = {x, y}, delta = i == j, nu = m->nu, c = m->c, z = m->z;
  const Long R1 = sqrtl(x * x + y * y + (z - c) * (z - c)), R2 = sqrtl(x * x + y * y + (z + c) * (z + c));
  const Long w = R2 + z + c, xx = r[i] * r[j];
  Long u = (3 - 4 * nu) * delta / R1 + xx / (R1 * R1 * R1);

  if (m->surface) {
    u += delta / R2 + (3 - 4 * nu) * xx / (R2 * R2 * R2) + 2 * c * z / (R2 * R2 * R2) * (delta - 3 * xx / (R2 * R2)) +
         4 * (1 - nu) * (1 - 2 * nu) / w * (delta - xx / (R2 * w));
  }
  return u / (16 * acosl(-1) * (1 - nu));
}

/* Central differences of order 6: first and second derivative. */
static const Long First[4] = {0, 0.75L, -0.15L, 1.0L / 60};
static const Long Second[4] = {-49.0L / 18, 1.5L, -0.15L, 1.0L / 90};

/* d_yy G_xx + 2 d_xy G_xy + d_xx G_yy at (x, y): the stress drop density of slip on y = 0. The step is 0.004 of the
   distance R, so that truncation is about 1e-13 and rounding (epsilon 1e-19 over the step squared) 1e-14 of the
   value. */
static Long PointStressDrop(const Medium *m, Long x, Long y)
{
  const Long h = 0.004L * sqrtl(x * x + y * y + (m->z - m->c) * (m->z - m->c));
  Long yy = Second[0] * Mindlin(m, 0, 0, x, y), xx = Second[0] * Mindlin(m, 1, 1, x, y), xy = 0;

  for (int p = 1; p < 4; p++) {
    yy += Second[p] * (Mindlin(m, 0, 0, x, y + p * h) + Mindlin(m, 0, 0, x, y - p * h));
    xx += Second[p] * (Mindlin(m, 1, 1, x + p * h, y) + Mindlin(m, 1, 1, x - p * h, y));
    for (int q = 1; q < 4; q++)
      xy += First[p] * First[q] *
            (Mindlin(m, 0, 1, x + p * h, y + q * h) - Mindlin(m, 0, 1, x - p * h, y + q * h) -
             Mindlin(m, 0, 1, x + p * h, y - q * h) + Mindlin(m, 0, 1, x - p * h, y - q * h));
  }
  return (yy + 2 * xy + xx) / (h * h);
}

#define POINTS 24
/* Gauss-Legendre nodes and weights on (-1, 1) by Newton's method. */
static void Gauss(Long node[POINTS], Long weight[POINTS])
{
  for (int i = 0; i < POINTS; i++) {
    Long x = cosl(acosl(-1) * (i + 0.75L) / (POINTS + 0.5L)), slope = 1;

    for (int sweep = 0; sweep < 50; sweep++) {
      Long p0 = 1, p1 = x;

      for (int k = 2; k <= POINTS; k++) {
        const Long p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;

        p0 = p1;
        p1 = p2;
      }
      slope = POINTS * (x * p1 - p0) / (x * x - 1);
      x -= p1 / slope;
    }
    node[i] = x;
    weight[i] = 2 / ((1 - x * x) * slope * slope);
  }
}

/* Integral over the cell; for receivers outside it. 24 points converge like 3.7^-48 for a neighbour's centre. */
static Long IntegrateOffset(Long nu, int surface, Long dx, Long dy, Long z_receiver, Long z_source, Long a, Long b)
{
  Long node[POINTS], weight[POINTS], sum = 0;

  Gauss(node, weight);
  for (int i = 0; i < POINTS; i++)
    for (int k = 0; k < POINTS; k++) {
      const Medium m = {nu, z_source + 0.5L * b * node[k], z_receiver, surface};

      sum += weight[i] * weight[k] * PointStressDrop(&m, dx + 0.5L * a * node[i], dy);
    }
  return sum * a * b / 4;
}

/* The cell's own centre: slip of the whole plane leaves no stress, so the cell gives minus the rest of the plane, and
   the density falls like R^-3: minus the integral over the angle of density(R = 1) / (distance to the edge), side by
   side. */
static Long IntegrateSelf(Long nu, Long a, Long b)
{
  Long node[POINTS], weight[POINTS], sum = 0;
  const Long corner = atan2l(b, a), quarter = acosl(0);

  Gauss(node, weight);
  for (int i = 0; i < POINTS; i++) {
    const Long side = 0.5L * corner * (1 + node[i]), top = corner + 0.5L * (quarter - corner) * (1 + node[i]);
    const Medium m_side = {nu, 10, 10 + sinl(side), 0}, m_top = {nu, 10, 10 + sinl(top), 0};

    sum += weight[i] * 0.5L * corner * PointStressDrop(&m_side, cosl(side), 0) * cosl(side) / (0.5L * a);
    sum += weight[i] * 0.5L * (quarter - corner) * PointStressDrop(&m_top, cosl(top), 0) * sinl(top) / (0.5L * b);
  }
  return -4 * sum;
}

/* 1e-8 is what is asked; the integration reaches about 1e-11. */
static void AssertClose(PetscReal value, Long reference)
{
  if (!(fabsl(value - reference) < 1e-8L * fabsl(reference)))
    print_error("kernel %.15g, integrated %.15Lg\n", (double)value, reference);
  assert_true(fabsl(value - reference) < 1e-8L * fabsl(reference));
}

static const Long Ratios[] = {0.25L, 0.1L, 0.4L, -0.2L};

/* The image's share at the cell's own centre is regular: integrate Mindlin minus Kelvin, over the cell's four quarters
   so that no point falls on the singular centre; both are differenced with the same step, so the truncation of the
   singular part cancels. */
static void test_self(void **state)
{
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Ratios); k++) {
    const Long nu = Ratios[k], a = 1, b = 1, z = 0.5L;
    const PetscReal v = (PetscReal)nu;
    Long rest = 0;

    for (int i = -1; i <= 1; i += 2)
      for (int j = -1; j <= 1; j += 2)
        rest += IntegrateOffset(nu, 1, i * a / 4, 0, z, z + j * b / 4, a / 2, b / 2) -
                IntegrateOffset(nu, 0, i * a / 4, 0, z, z + j * b / 4, a / 2, b / 2);
    AssertClose(SlipKernelHalfSpace(1, v, 0, 0.5, 0.5, 1, 1), IntegrateSelf(nu, a, b) + rest);
    AssertClose(SlipKernelFullSpace(1, v, 0, 0, 2, 1), IntegrateSelf(nu, 2, 1));
    AssertClose(SlipKernelFullSpace(1, v, 0, 0, 1, 1), IntegrateSelf(nu, 1, 1));
  }
}

/* Receivers on the source's plane, on an edge's extension and near the surface too, and on a parallel one, also right
   beside the source. */
static void test_against_integration(void **state)
{
  static const struct {
    PetscReal dx, dy, z_receiver, z_source, a, b;
  } rows[] = {
    {2, 0, 0.5, 0.5, 2, 1},    {0, 0, 1.5, 0.5, 2, 1},    {0, 0, 0.5, 1.5, 2, 1},  {-4, 0, 0.5, 3.5, 2, 1},
    {6, 0, 4.5, 0.5, 2, 1},    {1, 0, 2.5, 0.5, 1, 1},    {30, 0, 7.5, 2.5, 1, 1}, {3, 0, 0.01, 0.5, 1, 1},
    {-6, 0, 9, 6, 2, 1},       {1, 0, 9, 6, 2, 1},        {20, 0, 2, 9, 2, 1},     {0, 1.2, 0.5, 0.5, 2, 1},
    {2, -1, 0.5, 1.5, 2, 1},   {-4, 3, 0.5, 3.5, 2, 1},   {1, 2, 2.5, 2.5, 2, 1},  {6, 0.7, 4.5, 0.5, 2, 1},
    {0, 2.5, 3.5, 1.5, 1, 3},  {30, -20, 7.5, 2.5, 1, 1}, {3, 5, 0.01, 0.5, 1, 1}, {0.3, 40, 9, 2, 2, 2},
    {0, 0.01, 5.5, 2.5, 2, 1}, {2.7, 1e-3, 4, 2, 2, 1},
  };

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(Ratios); k++)
    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(rows); i++)
      for (int surface = 0; surface < 2; surface++) {
        const PetscReal nu = (PetscReal)Ratios[k], dx = rows[i].dx, dy = rows[i].dy, a = rows[i].a, b = rows[i].b;
        const PetscReal z = rows[i].z_receiver, zs = rows[i].z_source;
        const PetscReal drop = SlipKernelOffset(1, nu, dx, dy, z, zs, a, b, surface ? PETSC_FALSE : PETSC_TRUE);

        AssertClose(drop, IntegrateOffset(Ratios[k], surface, dx, dy, z, zs, a, b));
        if (dy == 0)
          assert_true(drop == (surface ? SlipKernelHalfSpace(1, nu, dx, z, zs, a, b)
                                       : SlipKernelFullSpace(1, nu, dx, z - zs, a, b)));
      }
}

/* Self stiffness of a square in closed form; half space, nu = 1/4: known values to their printed digits. */
static void test_known_values(void **state)
{
  const PetscReal a = 0.3, last_digit = 1e-5;

  for (PetscReal size = 0.1; size < 5; size *= 3) {
    const PetscReal expected = 30e9 * PETSC_SQRT2 / PETSC_PI * (7.0 / 3) / size;

    assert_true(PetscAbsReal(SlipKernelFullSpace(30e9, 0.25, 0, 0, size, size) / expected - 1) < 1e-14);
  }
  assert_true(PetscAbsReal(SlipKernelHalfSpace(1, 0.25, 0, 0.15, 0.15, a, a) - 3.11646) < last_digit);
  assert_true(PetscAbsReal(SlipKernelHalfSpace(1, 0.25, 0, 0.45, 0.45, a, a) - 3.48343) < last_digit);
  assert_true(PetscAbsReal(SlipKernelHalfSpace(1, 0.25, 0, 1e3, 1e3, a, a) - 3.50123) < last_digit);
  assert_true(PetscAbsReal(SlipKernelHalfSpace(1, 0.25, 0, 1.5, 1.5, 3, 3) - 0.311646) < 1e-6);
}

/* Equal slip on the cells of a square is slip of the square: their stress drops add up, and nearly cancel. */
static void test_cells_add_up(void **state)
{
  const int reach = 400;
  PetscReal sum = 0;

  for (int i = -reach; i <= reach; i++)
    for (int j = -reach; j <= reach; j++) sum += SlipKernelFullSpace(1, 0.25, i, j, 1, 1);
  /* 640,000 terms of at most 1 with errors of 1e-16 */
  assert_true(PetscAbsReal(sum - SlipKernelFullSpace(1, 0.25, 0, 0, 2 * reach + 1, 2 * reach + 1)) < 1e-10);
}

/* The stress drop of unit slip on a strip of an endless fault: that of a screw dislocation at each edge, G/(2 pi d) at
   the distance d (Segall 2010, section 2.2), with its image above a free surface. */
static PetscReal Antiplane(PetscReal z_receiver, PetscReal z_source, PetscReal width, PetscBool surface)
{
  const PetscReal top = z_source - width / 2, bottom = z_source + width / 2;
  PetscReal drop = 1 / (bottom - z_receiver) - 1 / (top - z_receiver);

  if (surface) drop += 1 / (bottom + z_receiver) - 1 / (top + z_receiver);
  return drop / (2 * PETSC_PI);
}

/* So it is in the middle of long cells, whatever Poisson's ratio. What the ends at +-a/2 add is (d/a)^2 times 1.3 of it
   at most, with d the distance to source or image, of 80 at most here; the next term is of the order d/a of that, of
   which 0.2 in the ratio of 4 is 13 times. */
static void test_long_cells_are_antiplane(void **state)
{
  const PetscReal nu[] = {0, 0.25, 0.45}, width = 0.2, a = 1e4;
  const PetscReal depth[][2] = {{0.1, 0.1}, {0.1, 39.9}, {20.1, 0.1}, {39.9, 39.7}};

  for (size_t n = 0; n < sizeof(nu) / sizeof(nu[0]); n++)
    for (size_t k = 0; k < sizeof(depth) / sizeof(depth[0]); k++) {
      const PetscReal r = depth[k][0], s = depth[k][1];
      const PetscReal half = Antiplane(r, s, width, PETSC_TRUE), full = Antiplane(r, s, width, PETSC_FALSE);
      const PetscReal error = SlipKernelHalfSpace(1, nu[n], 0, r, s, a, width) / half - 1;
      const PetscReal other = SlipKernelHalfSpace(1, nu[n], 0, r, s, 2 * a, width) / half - 1;

      assert_true(PetscAbsReal(error) < 2 * PetscSqr(80 / a));
      assert_true(PetscAbsReal(SlipKernelFullSpace(1, nu[n], 0, r - s, a, width) / full - 1) < 2 * PetscSqr(80 / a));
      if (PetscAbsReal(other) > 1e-9) assert_true(PetscAbsReal(error / other - 4) < 0.2);
    }
}

SLIP_TESTS(test_known_values, test_against_integration, test_self, test_cells_add_up, test_long_cells_are_antiplane)
