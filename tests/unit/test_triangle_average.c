/* Averages over triangles against those over rectangles, a quadrature of the stress, and themselves in parts. */
#include "triangles.h"
#include "pointsource.h"
#include <slipstep/private/sliptriangle.h>

#define CORE 0.11

static PetscReal Area(const SlipTriangleCell *cell)
{
  PetscReal normal[3];

  SlipTriangleNormal(cell->vertices, normal);
  return 0.5 * PetscSqrtReal(SlipDot(normal, normal));
}

/* With the hanging wall above, and for a vertical one to the right of its strike in [0, 180) */
static void CellOf(PetscReal v[3][3], PetscReal rake, SlipTriangleCell *cell)
{
  PetscReal d[3][3];

  ok(SlipTriangleDirections(v[0], NULL, NULL, d[0]));
  for (int i = 0; i < 9; i++) cell->vertices[i] = v[i / 3][i % 3];
  for (int i = 0; i < 3; i++) {
    cell->directions[i] = cos(rake) * d[0][i] + sin(rake) * d[1][i];
    cell->directions[3 + i] = cos(rake) * d[1][i] - sin(rake) * d[0][i];
    cell->directions[6 + i] = d[2][i];
  }
}

/* Both halves of a vertical rectangle along x, on either diagonal */
static void Halves(const SlipRectangle *r, int diagonal, SlipTriangleCell half[2])
{
  static const int cut[2][2][3] = {{{0, 1, 2}, {3, 0, 2}}, {{1, 0, 3}, {2, 1, 3}}};
  const PetscReal x[2] = {r->x - 0.5 * r->length, r->x + 0.5 * r->length};
  const PetscReal z[2] = {r->z - 0.5 * r->width, r->z + 0.5 * r->width};
  const PetscReal corner[4][3] = {{x[0], r->y, z[0]}, {x[1], r->y, z[0]}, {x[1], r->y, z[1]}, {x[0], r->y, z[1]}};

  for (int h = 0; h < 2; h++) {
    PetscReal v[3][3];

    for (int i = 0; i < 9; i++) v[i / 3][i % 3] = corner[cut[diagonal][h][i / 3]][i % 3];
    CellOf(v, 0, &half[h]);
  }
}

/* Vertical strike slip, whose average is known in closed form with a surface too: cells of a graded grid from the
   surface on, on one plane and on parallel ones. Cores are those of the lines of both. Without a surface to rounding.
   With one to 1e-7, of which nodes are 1e-8 and the rest is that vertices of one cell are near those of another one
   on the ground. */
static void rectangles(void **state)
{
  static const PetscReal x[] = {0, 1, 2, 2.7, 4}, z[] = {0, 0.8, 1.6, 2.6};
  SlipRectangle cell[12];
  PetscReal worst[2] = {0};

  for (int k = 0; k < 12; k++)
    cell[k] = (SlipRectangle){0.5 * (x[k % 4] + x[k % 4 + 1]), 0, 0.5 * (z[k / 4] + z[k / 4 + 1]),
                              x[k % 4 + 1] - x[k % 4], z[k / 4 + 1] - z[k / 4]};
  for (int full = 0; full < 2; full++)
    for (int i = 0; i < 12; i++)
      for (int j = 0; j <= i; j++) {
        const PetscReal nu = (i + j) % 3 ? 0.25 : -0.3;
        SlipRectangle to = cell[i], from = cell[j];
        const PetscReal core[2] = {CORE * PetscMin(to.length, from.length), CORE * PetscMin(to.width, from.width)};
        SlipTriangleCell a[2], b[2];
        PetscReal sum = 0, want, own, both[2];

        to.y = (i + 2 * j) % 5 == 1 ? 0.4 : 0;
        Halves(&to, i % 2, a);
        Halves(&from, j % 3 == 1, b);
        for (int k = 0; k < 2; k++)
          for (int l = 0; l < 2; l++) {
            SlipTriangleAverage(1, nu, (PetscBool)full, 1, &a[k], &b[l], CORE, both);
            sum += both[0] * Area(&a[k]) / (to.length * to.width);
          }
        want = SlipKernelAverage(1, nu, &to, &from, core, (PetscBool)full);
        own = SlipKernelAverage(1, nu, &to, &to, core, (PetscBool)full);
        worst[full] = PetscMax(worst[full], PetscAbsReal(sum - want) / own);
        AssertNear(sum, want, (full ? 1e-13 : 1e-7) * own);
      }
}

#define NODES 24
/* Traction on the receiver's plane by quadrature of SlipTriangleStress(), [2], and its size */
static void Quadrature(PetscReal nu, PetscBool full, const SlipTriangleCell *to, const SlipTriangleCell *from,
                       PetscReal sum[2], PetscReal *size)
{
  const PetscReal *v = to->vertices;
  PetscReal node[NODES], weight[NODES], own[3][3], slip[3] = {0};

  Gauss(NODES, node, weight);
  ok(SlipTriangleDirections(from->vertices, NULL, NULL, own[0]));
  for (int i = 0; i < 3; i++)
    for (int l = 0; l < 3; l++) slip[i] += own[i][l] * from->directions[l];
  sum[0] = sum[1] = *size = 0;
  for (int i = 0; i < NODES; i++)
    for (int j = 0; j < NODES; j++) {
      const PetscReal p = 0.5 + node[i], q = 0.5 + node[j], share = 2 * weight[i] * weight[j] * p;
      PetscReal at[3], stress[6], t[3];

      for (int l = 0; l < 3; l++) at[l] = v[l] + p * (v[3 + l] - v[l] + q * (v[6 + l] - v[3 + l]));
      ok(SlipTriangleStress(1, nu, full, from->vertices, slip, 1, at, stress));
      SlipStressTraction(1, stress, to->directions, t);
      sum[0] += share * t[0];
      sum[1] += share * t[2];
      *size += share * PetscSqrtReal(SlipDot(t, t));
    }
}

/* Pairs of any directions, some of both up to the ground, from half a side to 60 sides apart. The quadrature of 24
   nodes is off by 1e-14 there, averages by 1e-8 of the stress. */
static void quadrature(void **state)
{
  PetscReal worst[2] = {0};

  for (int trial = 0; trial < 150; trial++) {
    const PetscBool full = (PetscBool)(trial % 3 == 2);
    const PetscReal nu = Random(-0.3, 0.45), turn = Random(0, 2 * PETSC_PI);
    const PetscReal away = trial % 5 == 4 ? pow(10, Random(0.8, 2)) : Random(4.5, 7);
    SlipTriangleCell cell[2];
    PetscReal both[2], want[2], size;

    for (int k = 0; k < 2; k++) {
      const PetscReal depth = trial % 4 == 0 ? 0 : trial % 4 == 1 ? Random(0.01, 0.3) : Random(1, 4);
      const PetscReal x[2] = {k ? away * cos(turn) : 0, k ? away * sin(turn) : 0};
      PetscReal v[3][3], top = PETSC_MAX_REAL, first[2];

      AnyTriangle(trial % 7 == 3 ? 90 : Random(5, 90), v);
      for (int i = 0; i < 3; i++) top = PetscMin(top, v[i][2]);
      for (int l = 0; l < 2; l++) first[l] = v[0][l];
      for (int i = 0; i < 3; i++) {
        for (int l = 0; l < 2; l++) v[i][l] += x[l] - first[l];
        v[i][2] -= top - depth;
      }
      CellOf(v, Random(0, 6), &cell[k]);
    }
    Quadrature(nu, full, &cell[0], &cell[1], want, &size);
    SlipTriangleAverage(1, nu, full, 1, &cell[0], &cell[1], CORE, both);
    for (int i = 0; i < 2; i++) {
      worst[full] = PetscMax(worst[full], PetscAbsReal(both[i] - want[i]) / size);
      AssertNear(both[i], want[i], 1e-7 * size);
    }
  }
}

/* Cells of a bent sheet, up to the ground or below it, each cut in two, with rakes of their own: [8] */
static void Sheet(int trial, SlipTriangleCell cell[8])
{
  const PetscReal dip = Random(trial % 3 ? 20 : 10, 90) * PETSC_PI / 180, top = trial % 2 ? 0 : Random(0.05, 1);
  PetscReal x[3][3][3];
  int n = 0;

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const PetscReal down = j + (j ? Random(-0.2, 0.2) : 0);

      x[i][j][0] = i + Random(-0.2, 0.2);
      x[i][j][1] = down * cos(dip) + Random(-0.1, 0.1);
      x[i][j][2] = top + down * sin(dip);
    }
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++)
      for (int half = 0; half < 2; half++) {
        const PetscReal *corner[4] = {x[i][j], x[i + 1][j], x[i + 1][j + 1], x[i][j + 1]};
        PetscReal v[3][3];

        for (int k = 0; k < 3; k++)
          for (int l = 0; l < 3; l++) v[k][l] = corner[((i + j + trial) % 2 + k + 2 * half) % 4][l];
        CellOf(v, Random(0, 6), &cell[n++]);
      }
}

/* The force of a cell's slip on itself and on a neighbour is that of its four parts on theirs, with the core of the
   same length, which is a doubled share of their heights. A whole sees what its parts see in another order of closed
   forms and nodes. */
static void parts(void **state)
{
  PetscReal worst[2] = {0};

  for (int trial = 0; trial < 40; trial++) {
    const PetscBool full = (PetscBool)(trial % 4 == 3);
    SlipTriangleCell cell[8], part[2][4];
    PetscReal both[2], own[2], sum[2] = {0};

    Sheet(trial, cell);
    for (int other = 0; other < 2; other++) {
      for (int c = 0; c < 2; c++) {
        const SlipTriangleCell *whole = &cell[c ? 1 + other : 1];
        PetscReal m[3][3];

        for (int i = 0; i < 9; i++) m[i / 3][i % 3] = 0.5 * (whole->vertices[i] + whole->vertices[(i + 3) % 9]);
        for (int k = 0; k < 4; k++) {
          part[c][k] = *whole;
          for (int i = 0; i < 3; i++) {
            part[c][k].vertices[i] = k < 3 ? whole->vertices[3 * k + i] : m[0][i];
            part[c][k].vertices[3 + i] = k < 3 ? m[k][i] : m[1][i];
            part[c][k].vertices[6 + i] = k < 3 ? m[(k + 2) % 3][i] : m[2][i];
          }
        }
      }
      SlipTriangleAverage(1, 0.25, full, 1, &cell[1], &cell[1], CORE, own);
      SlipTriangleAverage(1, 0.25, full, 1, &cell[1], &cell[1 + other], CORE, both);
      sum[0] = sum[1] = 0;
      for (int k = 0; k < 4; k++)
        for (int l = 0; l < 4; l++) {
          PetscReal one[2];

          SlipTriangleAverage(1, 0.25, full, 1, &part[0][k], &part[1][l], 2 * CORE, one);
          for (int i = 0; i < 2; i++) sum[i] += 0.25 * one[i];
        }
      for (int i = 0; i < 2; i++) {
        worst[full] = PetscMax(worst[full], PetscAbsReal(sum[i] - both[i]) / own[0]);
        AssertNear(sum[i], both[i], (full ? 1e-12 : 3e-7) * own[0]);
      }
    }
  }
}

/* The force of one cell on another one is that of the other one on it, to the bit: nothing has to be made symmetric. */
static void symmetric(void **state)
{
  for (int trial = 0; trial < 12; trial++) {
    SlipTriangleCell cell[8];

    Sheet(trial, cell);
    for (int k = 0; k < 3; k++) cell[7].vertices[3 * k] += 30; /* far away */
    for (int i = 0; i < 8; i++)
      for (int j = 0; j < i; j++) {
        PetscReal a[2], b[2];

        SlipTriangleAverage(1, 0.25, (PetscBool)(trial % 3 == 0), 1, &cell[i], &cell[j], CORE, a);
        SlipTriangleAverage(1, 0.25, (PetscBool)(trial % 3 == 0), 1, &cell[j], &cell[i], CORE, b);
        AssertNear(a[0] * Area(&cell[i]), b[0] * Area(&cell[j]), 4 * PETSC_MACHINE_EPSILON * PetscAbsReal(a[0]));
      }
  }
}

/* Where neighbours bend by a small angle the average changes by as little: edges in a row are collinear to rounding,
   parallel edges opposite to each other nearly so. An angle e costs 1e-16/e, or e below 1e-8. */
static void bends(void **state)
{
  static const PetscReal angles[] = {1e-15, 1e-12, 1e-10, 1e-9, 3e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-4};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(angles); k++)
    for (int row = 0; row < 2; row++) {
      const PetscReal e = angles[k];
      PetscReal v[3][3] = {{0, 0, 5}, {1, 0, 5}, {0.3, 0.5, 6}};
      PetscReal w[3][3] = {{1, 0, 5}, {2, 0, 5}, {1.3, 0.5, 6}}, flat[2], bent[2];
      SlipTriangleCell a, b;

      if (!row) w[2][0] = 0.3; /* they share an edge */
      CellOf(v, 0.4, &a);
      CellOf(w, 0.4, &b);
      SlipTriangleAverage(1, 0.25, PETSC_TRUE, 1, &a, &b, CORE, flat);
      w[1][1] += e;
      w[1][2] -= e;
      if (row) w[2][1] -= 0.7 * e;
      CellOf(w, 0.4, &b);
      SlipTriangleAverage(1, 0.25, PETSC_TRUE, 1, &a, &b, CORE, bent);
      for (int i = 0; i < 2; i++) AssertNear(bent[i], flat[i], 10 * e + 1e-8);
    }
}

/* Edges of two triangles that are apart and parallel up to an angle e, against a quadrature: 1e-16/e of the edges'
   terms is lost, which are a hundred times the stress here, or e where they are taken to be parallel */
static void nearly_parallel(void **state)
{
  for (int power = -12; power <= -2; power++)
    for (int trial = 0; trial < 4; trial++) {
      const PetscReal e = 3 * pow(10, power);
      PetscReal v[3][3], w[3][3], both[2], want[2], size;
      SlipTriangleCell a, b;

      AnyTriangle(50, v);
      for (int i = 0; i < 9; i++) w[i / 3][i % 3] = v[i / 3][i % 3] + (i % 3 == trial % 3 ? 3.5 : 0);
      CellOf(v, 1, &a);
      for (int i = 0; i < 3; i++) w[1][i] += e * a.directions[6 + i];
      CellOf(w, 1, &b);
      Quadrature(0.25, PETSC_TRUE, &a, &b, want, &size);
      SlipTriangleAverage(1, 0.25, PETSC_TRUE, 1, &a, &b, CORE, both);
      for (int i = 0; i < 2; i++) AssertNear(both[i], want[i], (1e-10 + PetscMin(6 * e, 1e-11 / e)) * size);
    }
}

/* Waves of slip on a plane of equal triangles, two in each parallelogram of the sides 1 and (shear, high): with the
   core that rectangles have inside a fault, 1/(2 pi) of the heights, K has no error of the first order in the
   wavenumber k, for triangles of any shape, waves along slip and across it. The continuum's is G k/2, over 1 - nu
   along slip; the second order's share is 0.043 k^2 for equilateral triangles and grows with the longest side. A core
   of 0.11 instead is off by 0.06 k. The sum ends in a window of 80 sides. */
static void waves(void **state)
{
  enum { SIDES = 80 };
  static const PetscReal shapes[3][2] = {{0.5, 0.8660254037844386}, {0, 1}, {0.3, 0.7}};
  const PetscReal nu = 0.25, k = 0.35;

  for (int shape = 0; shape < 3; shape++) {
    const PetscReal shear = shapes[shape][0], high = shapes[shape][1], end = 0.98 * SIDES * high;

    for (int up = 0; up < 2; up++) {
      PetscReal v[3][3] = {{0, 0, 0}, {1, 0, 0}, {shear, high, 0}}, sum[2] = {0};
      SlipTriangleCell source;

      CellOf(v, up * PETSC_PI / 2, &source);
      for (int i = -SIDES; i <= SIDES; i++)
        for (int j = -SIDES; j <= SIDES; j++)
          for (int other = 0; other < 2; other++) {
            const PetscReal x = i + shear * j, y = high * j;
            const PetscReal apart[2] = {x + other * (1 + shear) / 3, y + other * high / 3};
            const PetscReal r = PetscSqrtReal(apart[0] * apart[0] + apart[1] * apart[1]);
            PetscReal w[3][3] = {{x, y, 0}, {x + 1, y, 0}, {x + shear, y + high, 0}}, both[2];
            SlipTriangleCell receiver;

            if (r > end) continue;
            if (other) {
              w[0][0] = x + 1 + shear;
              w[0][1] = y + high;
            }
            CellOf(w, up * PETSC_PI / 2, &receiver);
            SlipTriangleAverage(1, nu, PETSC_TRUE, 1, &receiver, &source, SLIP_CORE_INNER, both);
            for (int across = 0; across < 2; across++)
              sum[across] += both[0] * cos(k * apart[across]) *
                             (r < 0.3 * end ? 1 : 0.5 + 0.5 * cos(PETSC_PI * (r / end - 0.3) / 0.7));
          }
      for (int across = 0; across < 2; across++) {
        const PetscReal exact = 0.5 * k / (across == up ? 1 - nu : 1);

        AssertNear(sum[across], exact, 0.07 * k * k * exact);
      }
    }
  }
}

/* A core that is wider on a part of an edge: as if the average had been taken with it */
static void edges(void **state)
{
  PetscReal v[3][3], a[2], b[2], one, other, sum = 0;
  SlipTriangleCell cell;

  AnyTriangle(40, v);
  CellOf(v, 1, &cell);
  SlipTriangleAverage(30, 0.2, PETSC_FALSE, 1, &cell, &cell, CORE, a);
  SlipTriangleAverage(30, 0.2, PETSC_FALSE, 1, &cell, &cell, 0.3 * CORE, b);
  for (int k = 0; k < 3; k++) {
    SlipTriangleAverageEdge(30, 0.2, 1, &cell, k, 0.25, 0.3, &one);
    SlipTriangleAverageEdge(30, 0.2, 1, &cell, k, 0.75, 0.3, &other);
    sum += one + other;
  }
  AssertNear(a[0] + sum, b[0], 1e-12 * b[0]);
  assert_true(b[0] > a[0] && a[0] > 0);
}

SLIP_TESTS(rectangles, quadrature, parts, symmetric, bends, nearly_parallel, waves, edges)
