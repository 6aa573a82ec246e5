/* Fields of dipping rectangles against published numbers, a free surface and a quadrature of point sources. */
#include "unit.h"
#include "pointsource.h"
#include <math.h>

/* The largest size of some numbers */
static PetscReal Largest(PetscInt n, const PetscReal v[])
{
  PetscReal most = 0;

  for (PetscInt i = 0; i < n; i++) most = PetscMax(most, PetscAbsReal(v[i]));
  return most;
}

/* ---- numbers of DC3D (Okada 1992) in double precision: lambda = mu, the middle of the fault at the depth 10, dip 30,
   10 along strike and 8 along dip, unit slip. Rows: displacement and its derivatives along x, y and z. Okada's y points
   to the left of the strike and his z up. ---- */
typedef struct {
  int slip;
  PetscReal at[3], row[4][3];
} Published;

static const Published DC3D[] = {
  {0,
   {3, 1, -6},
   {{0.1406147270713609, -0.0166970843337242, 0.07485063667815837},
    {-0.0144031722544121, -0.00737440794945976, 0.0282535669751798},
    {-0.0007867391061529708, 0.00747364212808601, -0.004264382186713333},
    {-0.0467119200534689, 0.005094750031777914, -0.004882063345343449}}},
  {0,
   {-2, -4, -12},
   {{0.07781476402591594, 0.01094774303372522, -0.01733893319569133},
    {0.002701414362859818, -0.006441122130310163, 0.009288779211755421},
    {0.02692249596150842, -0.002019728621441283, -0.004953666323943142},
    {0.2447907679489299, 0.008359645201096623, 0.0001741188455517744}}},
  {0,
   {0.5, 0, -10},
   {{0.0125098960040132, -0.003477909698668629, 0.007029028088050955},
    {-0.0001032580705115785, -0.007038450523182532, 0.01419325296438777},
    {0.06446780129684811, -2.321911503245068e-05, -2.07518160064632e-05},
    {-0.1111582471427356, -1.826662207302121e-05, 0.0002041367610104081}}},
  {1,
   {3, 1, -6},
   {{0.01646728448940647, 0.07156925543573074, 0.177235136759978},
    {0.006033662857090529, -0.008048829946600508, -0.01902592021323701},
    {0.004659012107349827, -0.00883769487919657, 0.03513042291599745},
    {0.001420657355845975, -0.03372461223073861, -0.01418037545312605}}},
  {1,
   {-2, -4, -12},
   {{0.002955032880741316, 0.1834326652701142, -0.05771583782856805},
    {-0.001942729769894523, 0.003888685188564652, -0.002708500868986128},
    {-0.004121915438935045, 0.0679416018586556, -0.07002494174521352},
    {0.007592653821992374, 0.3912635358546211, 0.03239447672084607}}},
  {1,
   {0.5, 0, -10},
   {{-0.0002655857377904386, 0.007751241342620313, 0.02476853118894218},
    {-0.0005285166772836133, -4.346283359242423e-05, -0.0002020157051111247},
    {-1.659130308260637e-05, 0.05219765787944185, 0.05317790900053344},
    {-1.559618899991955e-05, -0.1122996419737195, -0.05033134839143413}}},
  {2,
   {3, 1, -6},
   {{0.01288168518159129, -0.1160049690279656, 0.3114803823368902},
    {0.009748600951799396, 0.01185262236733865, -0.03254361293038276},
    {-0.008186525311325649, 0.01798693175295278, -0.02008661636976217},
    {0.006153613689056807, 0.04555930017956592, -0.05194463217406879}}},
  {2,
   {-2, -4, -12},
   {{0.01898371454674791, 0.05997592538307052, 0.1260009545831958},
    {-0.01033708818216328, 0.003392488758977484, 0.003721621436858806},
    {0.005067300878082518, 0.07741881996664822, 0.05351101851160809},
    {4.68626322581954e-05, -0.2413991561540199, 0.0796895200940434}}},
  {2,
   {0.5, 0, -10},
   {{-0.007307349433109012, -0.0120891934912965, 0.05811507534015839},
    {-0.01477567903220294, 5.993092214880516e-05, -0.0004060714219839071},
    {1.474564759417147e-05, -0.02518912134164638, 0.003525441437269171},
    {-3.676207565101591e-05, 0.004970109388265005, -0.02533635224176512}}},
};

/* 1e-10 of the largest entry of a row: both lose three or four digits of 1e-16 between corners. In the fault DC3D gives
   the mean of both sides, and we the hanging wall's: half of the slip more. */
static void published_doubles(void **state)
{
  const SlipDippingRectangle source = {0, 0, 10, 10, 8, 0, 30};
  const PetscReal m[3] = {1, -1, -1};

  for (size_t p = 0; p < PETSC_STATIC_ARRAY_LENGTH(DC3D); p++) {
    const Published *d = &DC3D[p];
    const PetscReal at[3] = {d->at[0], -d->at[1], -d->at[2]};
    PetscReal slip[3] = {0}, u[3], g[3][3], half[9];

    slip[d->slip] = 1;
    ok(SlipDippingDisplacement(0.25, PETSC_FALSE, &source, slip, 1, at, u));
    ok(SlipDippingGradient(0.25, PETSC_FALSE, &source, slip, 1, at, &g[0][0]));
    SlipPlaneDirections(0, 30, 0, half);
    for (int i = 0; i < 3; i++)
      if (p % 3 == 2) u[i] -= 0.5 * half[3 * d->slip + i];
    for (int i = 0; i < 3; i++) {
      AssertNear(m[i] * u[i], d->row[0][i], 1e-10 * Largest(3, d->row[0]));
      for (int l = 0; l < 3; l++)
        AssertNear(m[i] * m[l] * g[i][l], d->row[1 + l][i], 1e-10 * Largest(3, d->row[1 + l]));
    }
  }
}

/* Okada (1985), cases 2 and 3 of table 2, to half of the last digit of four: ux uy uz, ux,x ux,y uy,x uy,y uz,x uz,y at
   (x, y), from the lower edge at the depth 4, 3 along strike and 2 along dip */
static void published_table(void **state)
{
  static const PetscReal dips[2] = {70, 90}, points[2][2] = {{2, 3}, {0, 0}};
  static const PetscReal table[2][3][9] = {
    {{-8.689e-3, -4.298e-3, -2.747e-3, -1.220e-3, 2.470e-4, -8.191e-3, -5.814e-4, -5.175e-3, 2.945e-4},
     {-4.682e-3, -3.527e-2, -3.564e-2, -8.867e-3, -1.519e-4, 4.057e-3, -1.035e-2, 4.088e-3, 2.626e-3},
     {-2.660e-4, 1.056e-2, 3.214e-3, -5.655e-4, 1.993e-3, -1.066e-3, 1.230e-2, -3.730e-4, 1.040e-2}},
    {{0, 5.253e-3, 0, 0, -1.864e-2, -2.325e-3, 0, 0, 2.289e-2},
     {0, 0, 0, 0, 2.748e-2, 0, 0, 0, -7.166e-2},
     {1.223e-2, 0, -1.606e-2, -4.182e-3, 0, 0, -2.325e-3, -9.146e-3, 0}}};

  for (int t = 0; t < 2; t++)
    for (int c = 0; c < 3; c++) {
      const PetscReal angle = dips[t] * PETSC_PI / 180, at[3] = {points[t][0], -points[t][1], 0};
      const SlipDippingRectangle source = {1.5, -PetscCosReal(angle), 4 - PetscSinReal(angle), 3, 2, 0, dips[t]};
      PetscReal slip[3] = {0}, u[3], g[3][3], ours[9];

      slip[c] = 1;
      ok(SlipDippingDisplacement(0.25, PETSC_FALSE, &source, slip, 1, at, u));
      ok(SlipDippingGradient(0.25, PETSC_FALSE, &source, slip, 1, at, &g[0][0]));
      for (int i = 0; i < 3; i++) {
        ours[i] = i ? -u[i] : u[i];
        ours[3 + 2 * i] = i ? -g[i][0] : g[i][0];
        ours[4 + 2 * i] = i ? g[i][1] : -g[i][1];
      }
      for (int i = 0; i < 9; i++) {
        const PetscReal want = table[t][c][i];
        const PetscReal digit = want == 0 ? 1e-15 : pow(10, floor(log10(fabs(want))) - 3);

        AssertNear(ours[i], want, 0.5001 * digit);
      }
    }
}

static PetscReal Random(PetscReal from, PetscReal to)
{
  static uint64_t last = 20261123;

  last = last * 6364136223846793005u + 1442695040888963407u;
  return from + (to - from) * (PetscReal)(last >> 11) / 9007199254740992.0;
}

/* d[2][3]: along strike and up dip of a rectangle, and its normal into the hanging wall */
static void Directions(const SlipDippingRectangle *r, PetscReal d[3][3])
{
  SlipPlaneDirections(r->strike, r->dip, 0, &d[0][0]);
}

/* The distance of a point from a rectangle */
static PetscReal Distance(const SlipDippingRectangle *r, const PetscReal at[3])
{
  const PetscReal half[3] = {0.5 * r->length, 0.5 * r->width, 0}, v[3] = {at[0] - r->x, at[1] - r->y, at[2] - r->z};
  PetscReal d[3][3], sum = 0;

  Directions(r, d);
  for (int i = 0; i < 3; i++)
    sum += PetscSqr(PetscMax(0, PetscAbsReal(v[0] * d[i][0] + v[1] * d[i][1] + v[2] * d[i][2]) - half[i]));
  return PetscSqrtReal(sum);
}

#define POINTS 26
/* 50 pairs of a rectangle and a point, some of each at the surface, with a slip of any direction. A point is at least
   half a side away: 26 nodes are off by (1 + sqrt 2)^-52 = 1e-20, beside which rounding of a sum of numbers of one size
   is 1e-15, and of the corners 1e-16 (d/a)^2, 1e-13 for the farthest points. */
static void quadrature(void **state)
{
  PetscReal node[POINTS], weight[POINTS], worst = 0;

  Gauss(POINTS, node, weight);
  for (int pair = 0; pair < 50; pair++) {
    const PetscBool full = (PetscBool)(pair % 5 == 4);
    const PetscReal nu = Random(-0.5, 0.48), dip = pair % 6 == 1 ? 90 : Random(1, 90), up = sin(dip * PETSC_PI / 180);
    SlipDippingRectangle r = {Random(-9, 9), Random(-9, 9), 0, Random(0.5, 4), Random(0.5, 4), Random(-180, 360), dip};
    PetscReal slip[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)}, at[3], d[3][3], b[3], ours[12], sum[12] = {0};

    r.z = 0.5 * r.width * up + (pair % 3 ? Random(0, 6) : 0);
    do {
      for (int i = 0; i < 2; i++) at[i] = (i ? r.y : r.x) + Random(-8, 8);
      at[2] = pair % 4 ? Random(0, 9) : 0;
    } while (Distance(&r, at) < 0.5 * PetscMax(r.length, r.width));
    Directions(&r, d);
    for (int i = 0; i < 3; i++) b[i] = slip[0] * d[0][i] + slip[1] * d[1][i] + slip[2] * d[2][i];
    for (int i = 0; i < POINTS; i++)
      for (int j = 0; j < POINTS; j++) {
        const PetscReal x = node[i] * r.length, t = node[j] * r.width;
        const PetscReal from[3] = {r.x + x * d[0][0] + t * d[1][0], r.y + x * d[0][1] + t * d[1][1],
                                   r.z + x * d[0][2] + t * d[1][2]};
        PetscReal field[12];

        PointSource(nu, full, b, d[2], at, from, field);
        for (int k = 0; k < 12; k++) sum[k] += weight[i] * weight[j] * r.length * r.width * field[k];
      }
    ok(SlipDippingDisplacement(nu, full, &r, slip, 1, at, ours));
    ok(SlipDippingGradient(nu, full, &r, slip, 1, at, ours + 3));
    for (int k = 0; k < 12; k++) {
      const PetscReal size = k < 3 ? Largest(3, sum) : Largest(9, sum + 3);

      worst = PetscMax(worst, PetscAbsReal(ours[k] - sum[k]) / size);
      AssertNear(ours[k], sum[k], 1e-9 * size);
    }
  }
  print_message("quadrature: off by at most %g\n", (double)worst);
}

/* The surface has no traction: 1e-12 of the largest stress on it, where eight corners of 1e-16 cancel. */
static void free_surface(void **state)
{
  enum { POINTS_OF_SURFACE = 40 };

  for (int trial = 0; trial < 60; trial++) {
    const PetscReal dip = trial % 6 == 1 ? 90 : Random(1, 90), nu = Random(-0.5, 0.49);
    SlipDippingRectangle r = {0, 0, 0, Random(0.5, 4), Random(0.5, 4), Random(0, 360), dip};
    const PetscReal slip[3] = {Random(-1, 1), Random(-1, 1), Random(-1, 1)};
    PetscReal at[POINTS_OF_SURFACE][3], stress[POINTS_OF_SURFACE][6], traction = 0, most = 0;

    r.z = 0.5 * r.width * sin(dip * PETSC_PI / 180) + (trial % 3 ? Random(0, 3) : 0);
    for (int k = 0; k < POINTS_OF_SURFACE; k++) {
      at[k][0] = Random(-4, 4);
      at[k][1] = Random(-4, 4);
      at[k][2] = 0;
    }
    ok(SlipDippingStress(1, nu, PETSC_FALSE, &r, slip, POINTS_OF_SURFACE, &at[0][0], &stress[0][0]));
    for (int k = 0; k < POINTS_OF_SURFACE; k++) {
      const PetscReal on[3] = {stress[k][2], stress[k][4], stress[k][5]};

      most = PetscMax(most, Largest(6, stress[k]));
      traction = PetscMax(traction, Largest(3, on));
    }
    AssertNear(traction, 0, 1e-12 * most);
  }
}

SLIP_TESTS(published_doubles, published_table, quadrature, free_surface)
