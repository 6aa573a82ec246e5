/*
  Derivatives of the Newtonian potential V of a rectangle, the integral of 1/R over it, in closed form.

  x is a point's distance from a corner along the rectangle's strike, t that up its dip, q the distance from its plane,
  R^2 = x^2 + t^2 + q^2. V's derivatives are double differences over the corners of

     V_x  ln(R + t)     V_t  ln(R + x)     V_q  -atan(x t / (q R))
     V_xx x Y     V_xt 1/R     V_xq q Y     V_tt t X     V_tq q X,     Y = 1/(R (R + t)), X = 1/(R (R + x))

  and of the derivatives of these, where with Z = -(2 R + t) / (R^3 (R + t)^2), W = (8 R^2 + 9 R t + 3 t^2) / (R^5 (R +
  t)^3)

     Y_x = x Z, Y_q = q Z, Z_x = x W, Z_q = q W, Y_t = -1/R^3, Z_t = 3/R^5.

  Terms that do not depend on t, or not on x, cancel in the differences. Therefore ln(R + t) may be -ln(R - t), and Y
  may be -1/(R (R - t)), at both ends of an edge. These are used where the middle of the edge is at t < 0, so that the
  extension of an edge is no special case. On the edge itself Y is infinite, but has a factor x or q, which is 0, in all
  terms of stress.
*/
#include <slipstep/private/slipdipping.h>

/* Computes a corner's coordinates and distance, i and j = +-1, for point k. */
SLIP_WITHIN void CornerOf(const SlipPlatePoints *p, PetscInt k, PetscReal i, PetscReal j, PetscReal *x, PetscReal *t,
                          PetscReal *R, PetscReal *i1, SlipLine *up, SlipLine *along)
{
  const PetscReal edge = SLIP_AT_EDGE * p->rounding[k], least = edge * edge, q2 = p->q[k] * p->q[k];
  PetscReal x2, t2, R2, inverse;

  *x = SlipCorner(p->x[k], i * p->half_length[k], p->rounding[k]);
  *t = SlipCorner(p->t[k], j * p->half_width[k], p->rounding[k]) + p->move[k];
  x2 = *x * *x;
  t2 = *t * *t;
  R2 = x2 + t2 + q2;
  *R = PetscSqrtReal(R2 > least ? R2 : least);
  inverse = R2 > least ? 1 / *R : 0; /* at the corner itself: without the infinite terms */
  *i1 = inverse;
  *up = SlipLineOf(*t, p->t[k] < 0 ? -1 : 1, x2 + q2 > least ? x2 + q2 : least, *R, inverse);
  *along = SlipLineOf(*x, p->x[k] < 0 ? -1 : 1, t2 + q2 > least ? t2 + q2 : least, *R, inverse);
}

/* The loops have no calls and no branches, so that compilers vectorize them; fourth is a constant. */
SLIP_WITHIN void Rational(const SlipPlatePoints *p, PetscReal i, PetscReal j, PetscBool fourth,
                          SlipPotential *restrict v)
{
  const PetscReal sign = i * j;

  for (PetscInt k = 0; k < p->n; k++) {
    const PetscReal q = p->q[k];
    PetscReal x, t, R, i1, i2, i3;
    SlipLine Y, X;

    CornerOf(p, k, i, j, &x, &t, &R, &i1, &Y, &X);
    i2 = i1 * i1;
    i1 *= sign;
    i3 = i1 * i2;
    v->second[0][k] += sign * x * Y.Y;
    v->second[1][k] += i1;
    v->second[2][k] += sign * q * Y.Y;
    v->second[3][k] += sign * t * X.Y;
    v->second[4][k] += sign * q * X.Y;
    v->third[0][k] += sign * (Y.Y + x * x * Y.Z);
    v->third[1][k] -= x * i3;
    v->third[2][k] += sign * x * q * Y.Z;
    v->third[3][k] -= t * i3;
    v->third[4][k] -= q * i3;
    v->third[5][k] += sign * (X.Y + t * t * X.Z);
    v->third[6][k] += sign * t * q * X.Z;
    if (fourth) {
      const PetscReal i5 = 3 * i3 * i2;

      v->fourth[0][k] += sign * x * (3 * Y.Z + x * x * Y.W);
      v->fourth[1][k] += x * x * i5 - i3;
      v->fourth[2][k] += sign * q * (Y.Z + x * x * Y.W);
      v->fourth[3][k] += x * t * i5;
      v->fourth[4][k] += x * q * i5;
      v->fourth[5][k] += t * t * i5 - i3;
      v->fourth[6][k] += t * q * i5;
      v->fourth[7][k] += sign * t * (3 * X.Z + t * t * X.W);
      v->fourth[8][k] += sign * q * (X.Z + t * t * X.W);
    }
  }
}

static void First(const SlipPlatePoints *p, PetscReal i, PetscReal j, SlipPotential *v)
{
  const PetscReal sign = i * j;

  for (PetscInt k = 0; k < p->n; k++) {
    const PetscReal q = PetscAbsReal(p->q[k]), side = p->q[k] < 0 ? -1 : 1;
    PetscReal x, t, R, inverse;
    SlipLine up, along;

    CornerOf(p, k, i, j, &x, &t, &R, &inverse, &up, &along);
    v->first[0][k] += sign * (p->t[k] < 0 ? -1 : 1) * PetscLogReal(up.sum);
    v->first[1][k] += sign * (p->x[k] < 0 ? -1 : 1) * PetscLogReal(along.sum);
    v->first[2][k] -= sign * side * PetscAtan2Real(x * t, q * R);
  }
}

/*
  SlipPotential_Private - computes the derivatives of V of the orders lowest to 3, or to 4, where lowest is 1 or 2
*/
SLIP_WIDE void SlipPotential_Private(const SlipPlatePoints *p, PetscInt lowest, PetscInt highest, SlipPotential *v)
{
  for (PetscInt k = 0; k < p->n; k++) {
    for (int d = 0; d < 3; d++) v->first[d][k] = 0;
    for (int d = 0; d < 5; d++) v->second[d][k] = 0;
    for (int d = 0; d < 7; d++) v->third[d][k] = 0;
    for (int d = 0; d < 9; d++) v->fourth[d][k] = 0;
  }
  for (int i = -1; i <= 1; i += 2)
    for (int j = -1; j <= 1; j += 2) {
      if (lowest < 2) First(p, i, j, v);
      if (highest > 3)
        Rational(p, i, j, PETSC_TRUE, v);
      else
        Rational(p, i, j, PETSC_FALSE, v);
    }
}
