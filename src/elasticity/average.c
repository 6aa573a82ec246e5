/*
  Stress drop of a rectangular strike-slip dislocation averaged over a receiving rectangle of a parallel vertical plane.

  The density of dislocation_offset.c is integrated in x, c and z, over source and receiver. The integral is a sum over
  the corners of both, times the signs sx, tx, sz, tz = +-1 of each corner, of

     direct     -(1 - nu) Q(x, rho) - P(s, r) + y^2 R / r^2                     of x and s = z - c,
     image   -[ -(1 - nu) Q(x, rho) - (3 - 4 nu) (P(w, r) - y^2 / (R + w)) - 4 (1 - nu)(1 - 2 nu) g4
               - 2 (z c g2 - w g3 + g4) ]                                        of x and w = z + c,

     P(s, r) = |s| ln((|s| + R) / r) - R     with d_ss P = 1 / R,     Q(x, rho) = P with x for s, rho for r,

  with r^2 = x^2 + y^2, rho^2 = y^2 + s^2, R^2 = r^2 + s^2, and g2, g3, g4 the second, third and fourth antiderivatives
  in w of g0 = d_yy (1 / R): the antiderivative of z c g0(z + c) in z and c is z c g2 - w g3 + g4.

  Where an edge of the source lies on one of the receiver (x = 0 or s = 0 on y = 0) the average does not exist: the
  traction decreases as 1 / distance on both sides of an edge, and its integral grows as the logarithm of the distance.
  This is the line energy of a dislocation, and has the same treatment: the edge has a core, which replaces r = 0 or
  rho = 0 on its lines. Cores belong to lines, whose energy is that of the jump of slip across them, so that the average
  is exactly symmetric and the sum over the parts of a cell is that of the whole.
*/
#include <slipstep/private/slipelasticity.h>

/* Distance of two rectangles, in sides of the smaller one, above which that is integrated by quadrature with
   FAR_POINTS^2 points. The error is (4 FAR_SIDES)^(-2 FAR_POINTS) = 1e-12 of the entry; the sum over corners loses as
   many digits there, and more farther away. */
#define FAR_SIDES 8
#define FAR_POINTS 4

static const PetscReal FarNode[FAR_POINTS] = {-0.43056815579702629, -0.16999052179242813, 0.16999052179242813,
                                              0.43056815579702629}; /* of sides */
static const PetscReal FarWeight[FAR_POINTS] = {0.17392742256872684, 0.3260725774312731, 0.3260725774312731,
                                                0.17392742256872684};

/* Returns the distance of a line along t on which a corner lies, or its core if it goes through the receiver's edge. */
static PetscReal LineDistance(PetscReal u, PetscReal y, PetscReal core)
{
  return u == 0 && y == 0 ? core : PetscSqrtReal(u * u + y * y);
}

/* Returns |t| ln((|t| + R) / distance) - R. */
static PetscReal Line(PetscReal t, PetscReal distance, PetscReal R)
{
  const PetscReal s = PetscAbsReal(t);

  return s > 0 ? s * PetscLogReal((s + R) / distance) - R : -R;
}

/* Computes the differences of the corners of two intervals whose centres are d apart; a difference below touch is 0.
   Two equal ones are returned once, with the weight -2. */
static PetscInt Differences(PetscReal d, PetscReal a, PetscReal b, PetscReal touch, PetscReal value[4],
                            PetscReal weight[4])
{
  const PetscInt n = a == b ? 3 : 4;
  const PetscReal outer = 0.5 * (a + b), inner = 0.5 * (a - b);

  value[0] = d - outer;
  value[1] = d - inner;
  value[n - 2] = d + inner;
  value[n - 1] = d + outer;
  weight[0] = weight[n - 1] = 1;
  weight[1] = weight[2] = -1;
  if (n == 3) {
    weight[1] = -2;
    weight[2] = 1;
  }
  for (PetscInt i = 0; i < n; i++)
    if (PetscAbsReal(value[i]) <= touch) value[i] = 0;
  return n;
}

/* Two rectangles and the differences of their corners */
typedef struct {
  PetscInt nx;
  PetscReal x[4], weight[4], y;
  PetscReal core[2]; /* cores of edges in depth, which x crosses, and of edges along strike */
  PetscReal touch;   /* smaller differences are 0 [m] */
} Pair;

static PetscReal Direct(const Pair *p, PetscReal nu, PetscReal s)
{
  PetscReal sum = 0;

  for (PetscInt i = 0; i < p->nx; i++) {
    const PetscReal x = p->x[i], y2 = p->y * p->y, R = PetscSqrtReal(x * x + y2 + s * s);
    const PetscReal r = LineDistance(x, p->y, p->core[0]), rho = LineDistance(s, p->y, p->core[1]);

    sum -= p->weight[i] * ((1 - nu) * Line(x, rho, R) + Line(s, r, R) - (y2 > 0 ? y2 * R / (r * r) : 0));
  }
  return sum;
}

/* Computes the image's terms without the product of the two depths, and the factor of that product. Where R = 0, on the
   surface, the product is 0 and its factor is left out. */
static void Image(const Pair *p, PetscReal nu, PetscReal w, PetscReal *rest, PetscReal *product)
{
  *rest = *product = 0;
  for (PetscInt i = 0; i < p->nx; i++) {
    const PetscReal x = p->x[i], y2 = p->y * p->y, R = PetscSqrtReal(x * x + y2 + w * w), t = R + w;
    const PetscReal rho = LineDistance(w, p->y, p->core[1]);
    PetscReal L, P, U, g2, g3, g4;

    if (R == 0) continue;
    L = PetscLogReal(t);
    P = w * L - R;
    U = (R * R + R * w + w * w) / (6 * t) + 0.5 * P;
    g2 = -1 / t + y2 / (R * t * t);
    g3 = -0.5 * (w / t + L) - 0.5 * y2 / (t * t);
    g4 = -U + y2 * (2 * R + w) / (6 * t * t);
    *rest += p->weight[i] * (-(1 - nu) * Line(x, rho, R) - (3 - 4 * nu) * (P - y2 / t) -
                             4 * (1 - nu) * (1 - 2 * nu) * g4 + 2 * w * g3 - 2 * g4);
    *product -= p->weight[i] * 2 * g2;
  }
}

static PetscReal DirectSum(const Pair *p, PetscReal nu, PetscReal dz, PetscReal b, PetscReal b_source)
{
  PetscReal s[4], weight[4], sum = 0;
  const PetscInt n = Differences(dz, b, b_source, p->touch, s, weight);

  for (PetscInt k = 0; k < n; k++) sum += weight[k] * Direct(p, nu, s[k]);
  return sum;
}

/* Computes the image's sum for rectangles centred at the depths z_i and z_j as part[0] - z_i z_j part[1]. */
static void ImageSums(const Pair *p, PetscReal nu, PetscReal z, PetscReal b, PetscReal z_source, PetscReal b_source,
                      PetscReal part[2])
{
  part[0] = part[1] = 0;
  for (int i = -1; i <= 1; i += 2)
    for (int j = -1; j <= 1; j += 2) {
      const PetscReal own = 0.5 * i * b, other = 0.5 * j * b_source, w = z + z_source + (own + other);
      PetscReal rest, product;

      Image(p, nu, w > p->touch ? w : 0, &rest, &product);
      part[0] += i * j * (rest + (z * other + z_source * own + own * other) * product);
      part[1] -= i * j * product;
    }
}

static PetscReal Factor(PetscReal G, PetscReal nu)
{
  return G / (4 * PETSC_PI * (1 - nu));
}

static void PairOf(PetscReal dx, PetscReal dy, PetscReal a, PetscReal b, PetscReal a_source, PetscReal b_source,
                   const PetscReal core[2], Pair *p)
{
  p->touch = SLIP_TOUCH * PetscMin(PetscMin(a, b), PetscMin(a_source, b_source));
  p->y = PetscAbsReal(dy) <= p->touch ? 0 : dy;
  p->core[0] = core[0];
  p->core[1] = core[1];
  p->nx = Differences(dx, a, a_source, p->touch, p->x, p->weight);
}

/* Computes the force on the receiver by quadrature over it; the other, larger rectangle has exact stress. */
static PetscReal FarForce(PetscReal G, PetscReal nu, const SlipRectangle *r, const SlipRectangle *s,
                          PetscBool full_space)
{
  PetscReal sum = 0;

  for (int i = 0; i < FAR_POINTS; i++)
    for (int k = 0; k < FAR_POINTS; k++)
      sum += FarWeight[i] * FarWeight[k] *
             SlipKernelOffset(G, nu, r->x + FarNode[i] * r->length - s->x, r->y - s->y, r->z + FarNode[k] * r->width,
                              s->z, s->length, s->width, full_space);
  return r->length * r->width * sum;
}

/*@
  SlipKernelAverage - computes the average stress drop over a receiving rectangle for unit strike slip on another one

  Not collective, pure

  Input Parameters:
+ G          - shear modulus [Pa]
. nu         - Poisson's ratio, in (-1, 0.5), dimensionless
. receiver   - the rectangle over which the stress is averaged
. source     - the rectangle that slips, on the same plane or a parallel one
. core       - cores of the lines on which edges of both lie, positive [m]: of edges in depth, of edges along strike
- full_space - leave out the free surface

  Output: average of the drop of the stress xy over the receiver [Pa/m]

  Notes:
  Times the receiver's area it is the force on the receiver, which is symmetric in both rectangles. An edge that both
  share would add an infinite term, the logarithm of the distance from the edge; such a line therefore has a core, for
  example of SLIP_CORE_CELL cells. The average of rectangles without such a line does not depend on it. Edges at the
  free surface cancel with those of the image.

  A rectangle that is more than 8 of its sides away from a larger one is integrated by quadrature, to 1e-12 of the
  value, because the sum over corners loses digits there.

  Level: intermediate

.seealso: SlipKernelOffset(), MatCreateSlipCellStiffness(), MatCreateSlipStiffness()
@*/
PetscReal SlipKernelAverage(PetscReal G, PetscReal nu, const SlipRectangle *receiver, const SlipRectangle *source,
                            const PetscReal core[2], PetscBool full_space)
{
  const SlipRectangle *r = receiver, *s = source;
  const PetscReal area = r->length * r->width, dx = r->x - s->x, dy = r->y - s->y, dz = r->z - s->z;
  const SlipRectangle *small = area > s->length * s->width ? s : r, *large = small == r ? s : r;
  const PetscReal x = PetscMax(0, PetscAbsReal(large->x - small->x) - 0.5 * large->length);
  const PetscReal z = PetscMax(0, PetscAbsReal(large->z - small->z) - 0.5 * large->width);
  PetscReal sum, image[2];
  Pair p;

  /* the distance of the larger rectangle from the centre of the smaller one */
  if (PetscSqrtReal(x * x + PetscSqr(large->y - small->y) + z * z) > FAR_SIDES * PetscMax(small->length, small->width))
    return FarForce(G, nu, small, large, full_space) / area;
  PairOf(dx, dy, r->length, r->width, s->length, s->width, core, &p);
  sum = DirectSum(&p, nu, dz, r->width, s->width);
  if (!full_space) {
    ImageSums(&p, nu, r->z, r->width, s->z, s->width, image);
    sum += image[0] - r->z * s->z * image[1];
  }
  return Factor(G, nu) / area * sum;
}

/*
  SlipAverageSurface_Private - computes the free surface's part of the average, part[0] - z_i z_j part[1] for cells at
  the depths z_i, z_j; the parts are functions of dx and of the sum of the two depths only
*/
void SlipAverageSurface_Private(PetscReal G, PetscReal nu, PetscReal core, PetscReal dx, PetscReal depth_sum,
                                PetscReal a, PetscReal b, PetscReal part[2])
{
  const PetscReal cores[2] = {core * a, core * b};
  PetscReal factor = Factor(G, nu) / (a * b);
  Pair p;

  if (dx * dx + depth_sum * depth_sum > PetscSqr((FAR_SIDES + 0.5) * PetscMax(a, b))) {
    part[0] = part[1] = 0;
    for (int i = 0; i < FAR_POINTS; i++)
      for (int k = 0; k < FAR_POINTS; k++) {
        const PetscReal z = FarNode[k] * b, weight = FarWeight[i] * FarWeight[k];
        PetscReal centre[3];

        SlipKernelSurface_Private(G, nu, dx + FarNode[i] * a, depth_sum + z, a, b, centre);
        part[0] += weight * (centre[0] + z * (centre[1] + z * centre[2]));
        part[1] += weight * centre[2];
      }
    /* z_i^2 = z_i (z_i + z_j) - z_i z_j: the terms linear in z_i cancel, as the average is symmetric */
    return;
  }
  PairOf(dx, 0, a, b, a, b, cores, &p);
  ImageSums(&p, nu, 0.5 * depth_sum, b, 0.5 * depth_sum, b, part);
  part[0] *= factor;
  part[1] *= factor;
}

/*
  SlipAverageEdge_Private - computes what one edge of a cell adds to the cell's SlipKernelAverage() on itself [Pa/m] if
  the core along share of the edge is ratio times the one that was used; normal is the cell's extent across the edge
*/
PetscReal SlipAverageEdge_Private(const SlipKernel *k, PetscBool along_strike, PetscReal normal, PetscReal share,
                                  PetscReal ratio)
{
  return -2 * Factor(k->shear_modulus, k->poisson_ratio) * (along_strike ? 1 - k->poisson_ratio : 1) * share / normal *
         PetscLogReal(ratio);
}
