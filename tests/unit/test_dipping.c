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

#define POINTS 26
/* 50 pairs of a rectangle and a point, some of each at the surface, with a slip of any direction. A point is at least
   half a side away: 26 nodes are off by (1 + sqrt 2)^-52 = 1e-20, beside which rounding of a sum of numbers of one size
   is 1e-15, and of the corners 1e-16 (d/a)^2, 1e-13 for the farthest points. */
/* The surface has no traction: 1e-12 of the largest stress on it, where eight corners of 1e-16 cancel. */
SLIP_TESTS(published_doubles)
