/*
  Derivatives of V of triangles, and those of X of their images, for pairs of triangles in lanes: the sums over edges of
  triangle_potential.c and triangle_surface.c for receivers that are on no edge.

  What both ends of an edge, or both edges at a vertex, share is computed once: the distances R of the vertices, and 1/R
  and 1/(R + w) from one division; 1/(R + |s|) of both ends and 1/r^2 from another one. With rho = R/(R + s),

     Y = rho/R^2,   Z = -(1 + rho) Y/R^2,   W = (3 + rho (3 + 2 rho)) Y/R^4.

  Of X only horizontal derivatives are computed: in a strain the other ones cancel, because horizontal components of the
  displacement by the image have the opposite sign of the vertical one, or follow from d_xx + d_yy + d_zz = 0.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptrianglelanes.h>

/* Distances and reciprocals at a vertex, and its distances from the receiver along strike and up dip */
typedef struct {
  PetscReal x, t, w, R, i, iw; /* w: sum of depths; i: 1/R; iw: 1/(R + w) */
} Vertex;

/* An edge: distance across it, and for both ends those along it, 1/(R + |s|) and 1/(R - |s|) */
typedef struct {
  PetscReal p, s[2], far[2], near[2];
} Line;

typedef struct {
  PetscReal second[5], third[7], fourth[9];
} Rows;

/* A receiver in the directions of its source or image */
typedef struct {
  PetscReal x, t, q, z, least, on2; /* depth; least and largest squares of distances that count as 0 */
} Place;

SLIP_WITHIN Place PlaceOf(const SlipTriangleLanes *s, const SlipTriangleLanes *r, int k, PetscBool image)
{
  const PetscReal dx = r->centroid[0][k] - s->middle[0][k], dy = r->centroid[1][k] - s->middle[1][k];
  const PetscReal y = s->strike[0][k] * dy - s->strike[1][k] * dx, rounding = s->rounding[k] + r->reach[k];
  const PetscReal z = image ? r->centroid[2][k] + s->middle[2][k] : s->middle[2][k] - r->centroid[2][k];
  const PetscReal q = s->slope[1][k] * y - s->slope[0][k] * z, near = SLIP_AT_EDGE * rounding;

  return (Place){.x = s->strike[0][k] * dx + s->strike[1][k] * dy,
                 .t = s->slope[0][k] * y + s->slope[1][k] * z,
                 .q = PetscAbsReal(q) <= rounding ? 0 : q,
                 .z = r->centroid[2][k],
                 .least = near * near,
                 .on2 = 4 * rounding * rounding};
}

SLIP_WITHIN Vertex VertexOf(const SlipTriangleLanes *s, int v, int k, PetscBool image, const Place *at)
{
  const PetscReal x = at->x - s->x[v][k], t = at->t - s->t[v][k], R2 = x * x + t * t + at->q * at->q;
  const PetscReal R = PetscSqrtReal(R2 > at->least ? R2 : at->least), w = image ? at->z + s->depth[v][k] : 0;
  const PetscReal Rw = R + w, inverse = 1 / (image ? R * Rw : R);

  return (Vertex){.x = x, .t = t, .w = w, .R = R, .i = image ? inverse * Rw : inverse, .iw = image ? inverse * R : 0};
}

SLIP_WITHIN Line LineOf(const SlipTriangleLanes *s, int edge, int k, const Place *at, const Vertex v[3],
                        PetscReal *closest)
{
  const Vertex *from = &v[edge], *to = &v[(edge + 1) % 3];
  const PetscReal p = from->x * s->up[edge][k] - from->t * s->along[edge][k];
  const PetscReal s0 = from->x * s->along[edge][k] + from->t * s->up[edge][k], s1 = s0 - s->length[edge][k];
  const PetscReal square = p * p + at->q * at->q, r2 = square > at->least ? square : at->least;
  const PetscReal f0 = from->R + PetscAbsReal(s0), f1 = to->R + PetscAbsReal(s1), both = f0 * f1, one = 1 / (both * r2);
  PetscReal gap;

  gap = -s0 > s1 ? -s0 : s1; /* beyond an end if positive */
  gap = square + (gap > 0 ? gap * gap : 0);
  *closest = gap < *closest ? gap : *closest;
  return (Line){
    .p = p, .s = {s0, s1}, .far = {one * (f1 * r2), one * (f0 * r2)}, .near = {one * both * f0, one * both * f1}};
}

/* Adds an edge to the rows of triangle_potential.c. */
SLIP_WITHIN void AddEdge(const SlipTriangleLanes *s, int edge, int k, PetscBool fourth, PetscReal q, const Line *l,
                         const Vertex *from, const Vertex *to, Rows *v)
{
  const PetscReal side = l->s[0] + l->s[1] < 0 ? -1 : 1, p = l->p, one[2] = {s->up[edge][k], s->along[edge][k]};
  const PetscReal two[2] = {s->power[edge][0][0][k], s->power[edge][0][1][k]};
  const PetscReal three[2] = {s->power[edge][1][0][k], s->power[edge][1][1][k]};
  const PetscReal rho0 = from->R * (side * l->s[0] >= 0 ? l->far[0] : l->near[0]);
  const PetscReal rho1 = to->R * (side * l->s[1] >= 0 ? l->far[1] : l->near[1]);
  const PetscReal u0 = from->i * from->i, u1 = to->i * to->i, c0 = from->i * u0, c1 = to->i * u1;
  const PetscReal Y0 = rho0 * u0, Y1 = rho1 * u1, Z0 = Y0 * u0, Z1 = Y1 * u1;
  const PetscReal Y = side * (Y0 - Y1), Z = side * (Z1 * (1 + rho1) - Z0 * (1 + rho0));
  const PetscReal i3 = c0 - c1, i3s = c0 * l->s[0] - c1 * l->s[1];
  const PetscReal dp = p * Y, ds = from->i - to->i, dq = q * Y, pZ = p * Z, pp = Y + p * pZ, ps = -p * i3, pq = q * pZ;
  const PetscReal ss = -i3s, sq = -q * i3, qq = Y + q * q * Z;

/* sum += conj value, value = re - i im, of which the real and the imaginary part are two rows */
#define ADD(row0, row1, conj, re, im)                                                                                  \
  do {                                                                                                                 \
    (row0) -= (conj)[0] * (re);                                                                                        \
    (row0) -= (conj)[1] * (im);                                                                                        \
    (row1) -= (conj)[1] * (re);                                                                                        \
    (row1) += (conj)[0] * (im);                                                                                        \
  } while (0)
  v->second[0] += dp;
  v->second[1] -= one[0] * dq;
  v->second[2] -= one[1] * dq;
  ADD(v->second[3], v->second[4], two, dp, ds);
  v->third[0] += pq;
  v->third[1] -= one[0] * qq;
  v->third[2] -= one[1] * qq;
  ADD(v->third[3], v->third[4], two, pq, sq);
  ADD(v->third[5], v->third[6], three, pp - ss, 2 * ps);
  if (fourth) {
    const PetscReal W = side * (Z0 * u0 * (3 + rho0 * (3 + 2 * rho0)) - Z1 * u1 * (3 + rho1 * (3 + 2 * rho1))),
                    pW = p * W;
    const PetscReal e0 = 3 * c0 * u0, e1 = 3 * c1 * u1, e0s = e0 * l->s[0], e1s = e1 * l->s[1];
    const PetscReal i5 = e0 - e1, i5s = e0s - e1s, i5ss = e0s * l->s[0] - e1s * l->s[1];
    const PetscReal four[2] = {s->power[edge][2][0][k], s->power[edge][2][1][k]}, q2W = q * q * W;
    const PetscReal pqq = p * (Z + q2W), sqq = q * q * i5 - i3, qqq = q * (3 * Z + q2W), pss = p * i5s;

    v->fourth[0] += pqq;
    v->fourth[1] -= one[0] * qqq;
    v->fourth[2] -= one[1] * qqq;
    ADD(v->fourth[3], v->fourth[4], two, pqq, sqq);
    ADD(v->fourth[5], v->fourth[6], three, q * (Z + p * pW - i5s), 2 * p * q * i5);
    ADD(v->fourth[7], v->fourth[8], four, p * (3 * Z + p * pW) - 3 * pss, 3 * (p * p * i5 - i3) - (i5ss - i3));
  }
#undef ADD
}

/* Converts rows to those of SlipPotential, and stores them. */
SLIP_WITHIN void Unfold(const Rows *v, int k, PetscBool fourth, SlipTrianglePairs *to)
{
  const PetscReal qq = v->second[0], qqq = v->third[0], xqq = v->third[1], tqq = -v->third[2];

  to->second[0][k] = 0.5 * (v->second[3] - qq);
  to->second[1][k] = -0.5 * v->second[4];
  to->second[2][k] = v->second[1];
  to->second[3][k] = -0.5 * (v->second[3] + qq);
  to->second[4][k] = -v->second[2];
  to->third[0][k] = 0.25 * (v->third[5] - 3 * xqq);
  to->third[1][k] = -0.25 * (tqq + v->third[6]);
  to->third[2][k] = 0.5 * (v->third[3] - qqq);
  to->third[3][k] = -0.25 * (xqq + v->third[5]);
  to->third[4][k] = -0.5 * v->third[4];
  to->third[5][k] = 0.25 * (v->third[6] - 3 * tqq);
  to->third[6][k] = -0.5 * (v->third[3] + qqq);
  if (fourth) {
    const PetscReal q4 = v->fourth[0], xq3 = v->fourth[1], tq3 = -v->fourth[2], re2 = v->fourth[3];
    const PetscReal xtqq = -0.5 * v->fourth[4], xxtt = 0.125 * (q4 - v->fourth[7]);

    to->fourth[0][k] = 0.5 * (q4 - re2) - xxtt;
    to->fourth[1][k] = -0.5 * xtqq - 0.125 * v->fourth[8];
    to->fourth[2][k] = 0.25 * (v->fourth[5] - 3 * xq3);
    to->fourth[3][k] = xxtt;
    to->fourth[4][k] = -0.25 * (tq3 + v->fourth[6]);
    to->fourth[5][k] = -0.5 * xtqq + 0.125 * v->fourth[8];
    to->fourth[6][k] = -0.25 * (xq3 + v->fourth[5]);
    to->fourth[7][k] = 0.5 * (re2 + q4) - xxtt;
    to->fourth[8][k] = 0.25 * (v->fourth[6] - 3 * tq3);
  }
}

SLIP_FUSED void SlipTriangleSourceEdges_Private(const SlipTriangleLanes *source, const SlipTriangleLanes *receiver,
                                                PetscReal near[restrict], SlipTrianglePairs *restrict pairs)
{
  for (int k = 0; k < SLIP_PAIRS; k++) {
    const Place at = PlaceOf(source, receiver, k, PETSC_FALSE);
    const Vertex v[3] = {VertexOf(source, 0, k, PETSC_FALSE, &at), VertexOf(source, 1, k, PETSC_FALSE, &at),
                         VertexOf(source, 2, k, PETSC_FALSE, &at)};
    PetscReal closest = PETSC_MAX_REAL;
    const Line l[3] = {LineOf(source, 0, k, &at, v, &closest), LineOf(source, 1, k, &at, v, &closest),
                       LineOf(source, 2, k, &at, v, &closest)};
    Rows rows = {{0}, {0}, {0}};

    AddEdge(source, 0, k, PETSC_FALSE, at.q, &l[0], &v[0], &v[1], &rows);
    AddEdge(source, 1, k, PETSC_FALSE, at.q, &l[1], &v[1], &v[2], &rows);
    AddEdge(source, 2, k, PETSC_FALSE, at.q, &l[2], &v[2], &v[0], &rows);
    Unfold(&rows, k, PETSC_FALSE, pairs);
    pairs->q[k] = at.q;
    near[k] = closest <= at.on2 ? 1 : near[k];
  }
}

/* Sums of dipping_surface.c at an end of an edge of the image */
typedef struct {
  PetscReal B, Y, yy, zz;
} End;

SLIP_WITHIN End EndOf(const Vertex *v, PetscReal t, PetscReal far, PetscReal near, PetscReal q, PetscReal ty,
                      PetscReal tz, PetscReal lean, PetscReal share)
{
  const PetscReal a = t >= 0 ? far : near, y = t * ty + q * tz, D = v->i * v->iw, E = D * (y + lean * v->R) * a;
  const PetscReal B = (y * E - share * a) * v->iw, Y = v->i * a;

  return (End){.B = B, .Y = Y, .yy = y * B - D * (ty * v->R + tz * y) + tz * t * E, .zz = ty * v->i + tz * q * Y};
}

/* Stores the sums of an edge of the image; see triangle_surface.c. */
SLIP_WITHIN void StoreLog(const SlipTriangleLanes *s, int edge, int k, const Place *at, const Line *l,
                          const Vertex *from, const Vertex *to, SlipTrianglePairs *pairs)
{
  const PetscReal hx = s->hx[edge][k], hy = s->hy[edge][k], flat = s->flat[edge][k], steep = s->steep[edge][k];
  const PetscReal y = from->t * s->slope[0][k] + at->q * s->slope[1][k], x = y * hx - from->x * hy;
  const PetscReal lean0 = s->lean[edge][0][k], lean1 = s->lean[edge][1][k];
  const PetscReal share0 = s->share[edge][0][k], share1 = s->share[edge][1][k];
  const PetscReal down = s->down[edge][k], turned = s->turns[edge][k] * (l->s[0] + l->s[1]);
  const PetscReal sign = turned < 0 ? -down : down, lean = turned < 0 ? lean1 : lean0;
  const PetscReal share = turned < 0 ? share1 : share0, ty = sign * flat, tz = sign * steep;
  const PetscReal q = sign * ((from->x * hx + y * hy) * steep - from->w * flat);
  const End a = EndOf(from, sign * l->s[0], l->far[0], l->near[0], q, ty, tz, lean, share);
  const End b = EndOf(to, sign * l->s[1], l->far[1], l->near[1], q, ty, tz, lean, share);

  pairs->log[edge][0][k] = sign * x * (a.B - b.B);
  pairs->log[edge][1][k] = sign * x * (a.B - b.B + a.Y - b.Y);
  pairs->log[edge][2][k] = sign * (a.yy - b.yy + a.zz - b.zz);
  pairs->log[edge][3][k] = sign * (a.yy - b.yy);
}

SLIP_FUSED void SlipTriangleImageEdges_Private(const SlipTriangleLanes *source, const SlipTriangleLanes *receiver,
                                               PetscReal near[restrict], SlipTrianglePairs *restrict pairs)
{
  for (int k = 0; k < SLIP_PAIRS; k++) {
    const Place at = PlaceOf(source, receiver, k, PETSC_TRUE);
    const Vertex v[3] = {VertexOf(source, 0, k, PETSC_TRUE, &at), VertexOf(source, 1, k, PETSC_TRUE, &at),
                         VertexOf(source, 2, k, PETSC_TRUE, &at)};
    PetscReal closest = PETSC_MAX_REAL;
    const Line l[3] = {LineOf(source, 0, k, &at, v, &closest), LineOf(source, 1, k, &at, v, &closest),
                       LineOf(source, 2, k, &at, v, &closest)};
    Rows rows = {{0}, {0}, {0}};

    AddEdge(source, 0, k, PETSC_TRUE, at.q, &l[0], &v[0], &v[1], &rows);
    AddEdge(source, 1, k, PETSC_TRUE, at.q, &l[1], &v[1], &v[2], &rows);
    AddEdge(source, 2, k, PETSC_TRUE, at.q, &l[2], &v[2], &v[0], &rows);
    Unfold(&rows, k, PETSC_TRUE, pairs);
    StoreLog(source, 0, k, &at, &l[0], &v[0], &v[1], pairs);
    StoreLog(source, 1, k, &at, &l[1], &v[1], &v[2], pairs);
    StoreLog(source, 2, k, &at, &l[2], &v[2], &v[0], pairs);
    pairs->q[k] = at.q;
    near[k] = closest <= at.on2 ? 1 : near[k];
  }
}
