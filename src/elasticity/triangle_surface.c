/*
  The terms of the free surface in the fields of a triangle besides derivatives of V: the part F of dipping.c.

  There F = 2 (1 - 2 nu) sin(dip) grad (b_x X_xy - b_y X_xx) with X the integral of chi = w ln(R + w) - R over the
  image. As x is in its plane, X_xj is minus the sum over the edges of m_x times the integral of chi_j along the edge,
  m its normal outward. With the outline's direction around the image's plane, sin(dip) m_x is the part v down of an
  edge's direction, so that

     F = -2 (1 - 2 nu) sum over edges of v grad int (b_x chi_y - b_y chi_x) ds,

  which has no strike in it: horizontal edges have no part. The bracket is the same in any horizontal directions.
  Those of the edge make the integrals N, of chi along it, and K, of chi across it, the ones of dipping_surface.c,
  whose x is across the edge and y along it, and whose dip is the edge's plunge.

  An edge may have either direction; usually it is downward. Then R + t > 0, but it is small where a point lies near the
  extension of a nearly horizontal edge: such an edge is directed upward, as only 1 + tz > 1/2 is needed.
*/
#include <slipstep/private/sliptriangle.h>

#define STEEP 0.5 /* edges with at least this vertical share have R + t > 0.13 R, and are directed downward */

/* An edge relative to a point: its direction, and the coordinates of its ends */
typedef struct {
  PetscReal sign, ty, tz; /* sign of the outline's direction relative to the chosen one; its parts along and down */
  PetscReal x, q, t[2];
} Image;

SLIP_WITHIN Image ImageOf(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt edge, PetscInt k)
{
  const PetscReal hx = e->hx[edge][k], hy = e->hy[edge][k], flat = e->flat[edge][k], steep = e->steep[edge][k];
  const PetscReal dx = p->x[k] - e->x[edge][k], dt = p->t[k] - e->t[edge][k], q = p->q[k];
  const PetscReal y = dt * e->ty[k] + q * e->tz[k], w = dt * e->tz[k] - q * e->ty[k];
  const PetscReal across = y * hx - dx * hy, other = (dx * hx + y * hy) * steep - w * flat;
  const PetscReal down = steep < 0 ? -1 : 1;
  const PetscReal start = SlipEdgeAlong(e, p, edge, edge, k), end = SlipEdgeAlong(e, p, edge, (edge + 1) % 3, k);
  Image image;

  image.sign = down * (start + end) < 0 && PetscAbsReal(steep) < STEEP ? -down : down;
  image.ty = image.sign * flat;
  image.tz = image.sign * steep;
  image.x = PetscAbsReal(across) <= p->rounding[k] ? 0 : across;
  image.q = PetscAbsReal(other) <= p->rounding[k] ? 0 : image.sign * other;
  image.t[0] = image.sign * start;
  image.t[1] = image.sign * end;
  return image;
}

/* Adds v times grad (b_xi K - b_eta N), with xi along the edge and eta across it, rotated horizontally to x and y. */
static void EdgeFirst(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt edge,
                      PetscReal sum[6][SLIP_LANES])
{
  for (PetscInt k = 0; k < p->n; k++) {
    const Image image = ImageOf(e, p, edge, k);
    const PetscReal hx = e->hx[edge][k], hy = e->hy[edge][k], lean = image.ty / (1 + image.tz);
    const PetscReal along = e->bx[k] * hx + e->by[k] * hy, across = e->by[k] * hx - e->bx[k] * hy;
    PetscReal g[3] = {0};

    if (e->steep[edge][k] == 0) continue;
    for (int i = 0; i < 2; i++) {
      const PetscReal sign = i ? -image.sign : image.sign;
      const SlipLogCorner c = SlipLogCornerOf(image.x, image.t[i], image.q, image.ty, image.tz, p->rounding[k]);
      const SlipLogSums s = SlipLogFirst_Private(&c, image.ty, image.tz, lean);

      for (int d = 0; d < 3; d++) g[d] += sign * (along * s.K[d] - across * s.N[d]);
    }
    sum[0][k] += e->steep[edge][k] * (hx * g[1] - hy * g[0]);
    sum[1][k] += e->steep[edge][k] * (hy * g[1] + hx * g[0]);
    sum[2][k] += e->steep[edge][k] * g[2];
  }
}

SLIP_WIDE static void EdgeSecond(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt edge,
                                 PetscReal sum[restrict 6][SLIP_LANES])
{
  for (PetscInt k = 0; k < p->n; k++) {
    const Image image = ImageOf(e, p, edge, k);
    const PetscReal hx = e->hx[edge][k], hy = e->hy[edge][k], lean = image.ty / (1 + image.tz);
    const PetscReal along = e->bx[k] * hx + e->by[k] * hy, across = e->by[k] * hx - e->bx[k] * hy;
    const PetscReal steep = e->steep[edge][k];
    PetscReal g[6] = {0}, ax, ay;

    for (int i = 0; i < 2; i++) {
      const PetscReal sign = i ? -image.sign : image.sign;
      const SlipLogCorner c = SlipLogCornerOf(image.x, image.t[i], image.q, image.ty, image.tz, p->rounding[k]);
      const SlipLogSums s = SlipLogSecond(&c, image.ty, image.tz, lean);

      for (int d = 0; d < 6; d++) g[d] += sign * (along * s.K[d] - across * s.N[d]);
    }
    /* g: eta eta, xi xi, ww, eta xi, eta w, xi w */
    ax = hx * g[1] - hy * g[3];
    ay = hx * g[3] - hy * g[0];
    sum[0][k] += steep * (hx * ax - hy * ay);
    sum[3][k] += steep * (hy * ax + hx * ay);
    sum[1][k] += steep * (hy * (hy * g[1] + hx * g[3]) + hx * (hy * g[3] + hx * g[0]));
    sum[2][k] += steep * g[2];
    sum[4][k] += steep * (hx * g[5] - hy * g[4]);
    sum[5][k] += steep * (hy * g[5] + hx * g[4]);
  }
}

/*
  SlipTriangleLog_Private - computes the first derivatives of the sum above along strike, to the right and down, or the
  second ones, xx yy zz xy xz yz, if gradient is true
*/
void SlipTriangleLog_Private(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscBool gradient,
                             PetscReal sum[6][SLIP_LANES])
{
  for (int d = 0; d < 6; d++)
    for (PetscInt k = 0; k < p->n; k++) sum[d][k] = 0;
  for (int edge = 0; edge < 3; edge++) (*(gradient ? EdgeSecond : EdgeFirst))(e, p, edge, sum);
}
