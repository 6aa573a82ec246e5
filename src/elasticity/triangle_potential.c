/*
  Derivatives of the Newtonian potential V of a triangle, the integral of 1/R over it, in closed form.

  In its plane the derivative of V is a sum over the edges, - m L, with m the edge's normal outward and L the integral
  of 1/R along it; across the plane it is minus the solid angle. With p and s a point's distances from an edge, across
  it and from its start along it, and q that from the plane, L is the difference of ln(R + s) between both ends, and
  the derivatives of L are those of dipping_potential.c, harmonic functions of p, s and q. The solid angle is the sum
  (Wilton et al. 1984) of the differences of

     atan(p s / (p^2 + q^2 + |q| R)),

  each of which keeps its digits wherever a point is.

  Around the normal a derivative d = d_x - i d_t turns by a factor: where the edge's normal is m_x + i m_t, with conj
  its conjugate, d = conj (d_p - i d_s). So V's derivatives are sums over edges of

     d^n d_q^k V = -conj^n (d_p - i d_s)^(n - 1) d_q^k L,    d_q^k V = d_p d_q^(k - 2) L,    n >= 1, k >= 2

  as d conj(d) = -d_q^2. The derivatives of L along s there are omitted, as their sum over a closed outline is 0.
*/
#include <slipstep/private/sliptriangle.h>

/* The derivatives of L by p, s and q at an edge, up to the third ones that are needed */
typedef struct {
  PetscReal p, s, q;
  PetscReal pp, ps, pq, ss, sq, qq;
  PetscReal ppp, pps, ppq, pss, psq, pqq, sss, ssq, sqq, qqq;
} Line;

/* The loops have no calls and no branches, so that compilers vectorize them; fourth is a constant. */
SLIP_WITHIN Line LineOf(const SlipTriangleEdges *e, const SlipTrianglePoints *points, PetscInt edge, PetscInt k,
                        PetscBool fourth)
{
  const PetscReal near = SLIP_AT_EDGE * points->rounding[k], least = near * near;
  const PetscReal p = SlipEdgeAcross(e, points, edge, k), q = points->q[k], r2 = p * p + q * q;
  const PetscReal end[2] = {SlipEdgeAlong(e, points, edge, edge, k), SlipEdgeAlong(e, points, edge, (edge + 1) % 3, k)};
  const PetscReal side = end[0] + end[1] < 0 ? -1 : 1;
  PetscReal Y = 0, Z = 0, W = 0, i1 = 0, i3 = 0, i3s = 0, i5 = 0, i5s = 0, i5ss = 0;
  Line d;

  for (int i = 0; i < 2; i++) {
    const PetscReal sign = i ? -1 : 1, s = end[i], R2 = r2 + s * s, R = PetscSqrtReal(R2 > least ? R2 : least);
    const PetscReal inverse = R2 > least ? 1 / R : 0, i2 = inverse * inverse; /* vertex: no infinite terms */
    const SlipLine line = SlipLineOf(s, side, r2 > least ? r2 : least, R, inverse);

    Y += sign * line.Y;
    Z += sign * line.Z;
    i1 += sign * inverse;
    i3 += sign * inverse * i2;
    i3s += sign * s * inverse * i2;
    if (!fourth) continue;
    W += sign * line.W;
    i5 += sign * 3 * inverse * i2 * i2;
    i5s += sign * 3 * s * inverse * i2 * i2;
    i5ss += sign * 3 * s * s * inverse * i2 * i2;
  }
  d.p = p * Y;
  d.s = i1;
  d.q = q * Y;
  d.pp = Y + p * p * Z;
  d.ps = -p * i3;
  d.pq = p * q * Z;
  d.ss = -i3s;
  d.sq = -q * i3;
  d.qq = Y + q * q * Z;
  if (!fourth) return d;
  d.ppp = p * (3 * Z + p * p * W);
  d.pps = p * p * i5 - i3;
  d.ppq = q * (Z + p * p * W);
  d.pss = p * i5s;
  d.psq = p * q * i5;
  d.pqq = p * (Z + q * q * W);
  d.sss = i5ss - i3;
  d.ssq = q * i5s;
  d.sqq = q * q * i5 - i3;
  d.qqq = q * (3 * Z + q * q * W);
  return d;
}

/* sum[0] += Re(conj * value), sum[1] += Im, value = re - i im */
#define ADD(sum0, sum1, conj, re, im)                                                                                  \
  do {                                                                                                                 \
    (sum0)[k] -= (conj)[0] * (re) + (conj)[1] * (im);                                                                  \
    (sum1)[k] -= (conj)[1] * (re) - (conj)[0] * (im);                                                                  \
  } while (0)

/* Rows: real ones of d_q^j, then real and imaginary parts of d d_q^(j-1), d^2 d_q^(j-2) and so on. */
SLIP_WITHIN void Edge(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt edge, PetscBool fourth,
                      SlipPotential *restrict v)
{
  for (PetscInt k = 0; k < p->n; k++) {
    const Line d = LineOf(e, p, edge, k, fourth);
    const PetscReal mx = e->up[edge][k], mt = -e->along[edge][k], one[2] = {mx, -mt};
    const PetscReal two[2] = {mx * mx - mt * mt, -2 * mx * mt};
    const PetscReal three[2] = {two[0] * one[0] - two[1] * one[1], two[0] * one[1] + two[1] * one[0]};
    const PetscReal four[2] = {two[0] * two[0] - two[1] * two[1], 2 * two[0] * two[1]};

    v->second[0][k] += d.p;
    ADD(v->second[1], v->second[2], one, d.q, 0);
    ADD(v->second[3], v->second[4], two, d.p, d.s);
    v->third[0][k] += d.pq;
    ADD(v->third[1], v->third[2], one, d.qq, 0);
    ADD(v->third[3], v->third[4], two, d.pq, d.sq);
    ADD(v->third[5], v->third[6], three, d.pp - d.ss, 2 * d.ps);
    if (fourth) {
      v->fourth[0][k] += d.pqq;
      ADD(v->fourth[1], v->fourth[2], one, d.qqq, 0);
      ADD(v->fourth[3], v->fourth[4], two, d.pqq, d.sqq);
      ADD(v->fourth[5], v->fourth[6], three, d.ppq - d.ssq, 2 * d.psq);
      ADD(v->fourth[7], v->fourth[8], four, d.ppp - 3 * d.pss, 3 * d.pps - d.sss);
    }
  }
}

/* Converts these rows to those of SlipPotential. */
SLIP_WITHIN void Unfold(PetscInt n, PetscBool fourth, SlipPotential *restrict v)
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal qq = v->second[0][k], xq = v->second[1][k], tq = -v->second[2][k], re = v->second[3][k];

    v->second[0][k] = 0.5 * (re - qq);
    v->second[1][k] = -0.5 * v->second[4][k];
    v->second[2][k] = xq;
    v->second[3][k] = -0.5 * (re + qq);
    v->second[4][k] = tq;
  }
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal qqq = v->third[0][k], xqq = v->third[1][k], tqq = -v->third[2][k], re2 = v->third[3][k];
    const PetscReal im2 = v->third[4][k], re3 = v->third[5][k], im3 = v->third[6][k];

    v->third[0][k] = 0.25 * (re3 - 3 * xqq);
    v->third[1][k] = -0.25 * (tqq + im3);
    v->third[2][k] = 0.5 * (re2 - qqq);
    v->third[3][k] = -0.25 * (xqq + re3);
    v->third[4][k] = -0.5 * im2;
    v->third[5][k] = 0.25 * (im3 - 3 * tqq);
    v->third[6][k] = -0.5 * (re2 + qqq);
  }
  if (!fourth) return;
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal q4 = v->fourth[0][k], xq3 = v->fourth[1][k], tq3 = -v->fourth[2][k], re2 = v->fourth[3][k];
    const PetscReal im2 = v->fourth[4][k], re3 = v->fourth[5][k], im3 = v->fourth[6][k], re4 = v->fourth[7][k];
    const PetscReal im4 = v->fourth[8][k], xxqq = 0.5 * (re2 - q4), xtqq = -0.5 * im2, ttqq = -0.5 * (re2 + q4);
    const PetscReal xxtt = 0.125 * (q4 - re4);

    v->fourth[0][k] = -xxqq - xxtt;
    v->fourth[1][k] = -0.5 * xtqq - 0.125 * im4;
    v->fourth[2][k] = 0.25 * (re3 - 3 * xq3);
    v->fourth[3][k] = xxtt;
    v->fourth[4][k] = -0.25 * (tq3 + im3);
    v->fourth[5][k] = -0.5 * xtqq + 0.125 * im4;
    v->fourth[6][k] = -0.25 * (xq3 + re3);
    v->fourth[7][k] = -ttqq - xxtt;
    v->fourth[8][k] = 0.25 * (im3 - 3 * tq3);
  }
}

static void First(const SlipTriangleEdges *e, const SlipTrianglePoints *points, PetscInt edge, SlipPotential *v)
{
  for (PetscInt k = 0; k < points->n; k++) {
    const PetscReal near = SLIP_AT_EDGE * points->rounding[k], least = near * near;
    const PetscReal p = SlipEdgeAcross(e, points, edge, k), q = PetscAbsReal(points->q[k]), r2 = p * p + q * q;
    const PetscReal end[2] = {SlipEdgeAlong(e, points, edge, edge, k),
                              SlipEdgeAlong(e, points, edge, (edge + 1) % 3, k)};
    const PetscReal side = end[0] + end[1] < 0 ? -1 : 1;
    PetscReal L = 0, angle = 0;

    for (int i = 0; i < 2; i++) {
      const PetscReal sign = i ? -1 : 1, s = end[i], R2 = r2 + s * s, R = PetscSqrtReal(R2 > least ? R2 : least);
      const SlipLine line = SlipLineOf(s, side, r2 > least ? r2 : least, R, 0);

      L += sign * side * PetscLogReal(line.sum);
      angle -= sign * PetscAtan2Real(p * s, r2 + q * R);
    }
    v->first[0][k] -= e->up[edge][k] * L;
    v->first[1][k] += e->along[edge][k] * L;
    v->first[2][k] -= points->q[k] < 0 ? -angle : angle;
  }
}

/*
  SlipTrianglePotential_Private - computes the derivatives of V of the orders lowest to 3, or to 4; lowest is 1 or 2
*/
SLIP_WIDE void SlipTrianglePotential_Private(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt lowest,
                                             PetscInt highest, SlipPotential *v)
{
  for (PetscInt k = 0; k < p->n; k++) {
    for (int d = 0; d < 3; d++) v->first[d][k] = 0;
    for (int d = 0; d < 5; d++) v->second[d][k] = 0;
    for (int d = 0; d < 7; d++) v->third[d][k] = 0;
    for (int d = 0; d < 9; d++) v->fourth[d][k] = 0;
  }
  for (int edge = 0; edge < 3; edge++) {
    if (lowest < 2) First(e, p, edge, v);
    if (highest > 3)
      Edge(e, p, edge, PETSC_TRUE, v);
    else
      Edge(e, p, edge, PETSC_FALSE, v);
  }
  Unfold(p->n, (PetscBool)(highest > 3), v);
}
