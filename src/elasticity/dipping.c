/*
  Displacement and its gradient by uniform slip on a rectangle of any strike and dip, in closed form.

  Slip b on a plane with the normal n loads an elastic body with the moment G M_jk, M_jk = b_j n_k + n_j b_k + 2 nu/(1 -
  2 nu) b_n delta_jk. With Kelvin's solution, V the integral of 1/R over the rectangle, q the distance from its plane
  and a = 1/(2 (1 - nu)), the displacement of a full space is

     4 pi u_i = -b_i V_n - (1 - a) (n_i U - b_n V_i) + a q U_i,     U = b_j V_j,

  where an index is a derivative: the integral of R has q V as its derivative along n, so that no more than V is needed.

  Mindlin's (1936) solution in the form of Okada (1992) is, in coordinates x, y, z (down) and with R the distance from
  the image of the source at the depth c, m = (1, 1, -1) and chi = w ln(R + w) - R, w = z + c,

     8 pi G G_ij = (Kelvin) + 2 delta_ij/R - (2 - a) m_i m_j R_ij - 2 (1 - 2 nu) m_i chi_ij
                   + 2 z m_j ((2 - a) (delta_j3 d_i - delta_i3 d_j) - a c d_ij) 1/R.

  M applied to the source's coordinates gives the field to be added, where V, q, n and b are those of the image, with
  mirrored normal and slip, n' and b' are their parts in the image's own directions, and X is that of dipping_surface.c:

     4 pi u_i = m_i J_i + z Z_i,      J_i = -b_i V_n + (1 - a) (n_i U - b_n V_i) + (2 - a) q U_i + F_i, Z_i = 4 (1 - a)
     delta_i3 U_n + 2 T_i - 2 a z U_ni, T_i = -b_3 V_ni - (1 - a) n_3 U_i + a (n_i U_3 + q U_3i) + (1 - a) b_n V_3i, F =
     2 (1 - 2 nu) n_y (b_x X_xy + b_y X_yy) + ..., = 2 (1 - 2 nu) sin(dip) (b_x X_xy - b_y X_xx) and a multiple of V,

  the latter in J_i already. Where 1/(1 - 2 nu) was it has cancelled.
*/
#include <slipcompat.h>
#include <slipstep/private/slipdipping.h>

/* V's derivatives at a point, and those along the slip, as far as they were computed */
typedef struct {
  PetscReal U1[3], U2[5], U3[7];
  PetscReal V1[3], V2[5], V3[7];
} Derivatives;

SLIP_WITHIN void Matrix(const PetscReal v[5], PetscReal m[3][3])
{
  m[0][0] = v[0];
  m[0][1] = m[1][0] = v[1];
  m[0][2] = m[2][0] = v[2];
  m[1][1] = v[3];
  m[1][2] = m[2][1] = v[4];
  m[2][2] = -v[0] - v[3];
}

/* Computes the derivatives at point k from V's derivatives of the orders lowest to highest. */
SLIP_WITHIN void DerivativesOf(const SlipPotential *v, PetscInt k, const PetscReal b[3], PetscInt lowest,
                               PetscInt highest, Derivatives *d)
{
  PetscReal fourth[9];

  if (lowest < 2)
    for (int i = 0; i < 3; i++) d->V1[i] = v->first[i][k];
  for (int i = 0; i < 5; i++) d->V2[i] = v->second[i][k];
  for (int i = 0; i < 7; i++) d->V3[i] = v->third[i][k];
  SlipAlong2(d->V2, b, d->U1);
  SlipAlong3(d->V3, b, d->U2);
  if (highest < 4) return;
  for (int i = 0; i < 9; i++) fourth[i] = v->fourth[i][k];
  SlipAlong4(fourth, b, d->U3);
}

SLIP_WITHIN void TurnBoth(const PetscReal slope[2], PetscReal m[3][3])
{
  for (int i = 0; i < 3; i++) SlipTurnSlope(slope, m[i]);
  for (int j = 0; j < 3; j++) {
    PetscReal column[3] = {m[0][j], m[1][j], m[2][j]};

    SlipTurnSlope(slope, column);
    for (int i = 0; i < 3; i++) m[i][j] = column[i];
  }
}

/* Computes -b_i V_n + sign (1 - a) (n_i U - b_n V_i) + factor q U_i, for the rectangle (-1, a) or image (1, 2 - a). */
static void Displacement(const SlipDipping *s, const Derivatives *d, PetscReal q, PetscReal sign, PetscReal factor,
                         PetscReal u[3])
{
  const PetscReal c = sign * (1 - s->a);

  for (int i = 0; i < 3; i++) u[i] = -s->b[i] * d->V1[2] - c * s->b[2] * d->V1[i] + factor * q * d->U1[i];
  u[2] += c * (s->b[0] * d->V1[0] + s->b[1] * d->V1[1] + s->b[2] * d->V1[2]);
}

/* Computes its derivatives, g[i][l] of u_i along l. */
SLIP_WITHIN void Gradient(const SlipDipping *s, const Derivatives *d, PetscReal q, PetscReal sign, PetscReal factor,
                          PetscReal g[3][3])
{
  const PetscReal c = sign * (1 - s->a);
  PetscReal V2[3][3], U2[3][3];

  Matrix(d->V2, V2);
  Matrix(d->U2, U2);
  for (int i = 0; i < 3; i++)
    for (int l = 0; l < 3; l++) g[i][l] = -s->b[i] * V2[2][l] - c * s->b[2] * V2[i][l] + factor * q * U2[i][l];
  for (int l = 0; l < 3; l++) {
    g[2][l] += c * d->U1[l];
    g[l][2] += factor * d->U1[l];
  }
}

/* Computes Z_i in the image's directions; down is the direction z in them. */
SLIP_WITHIN void Deep(const SlipDipping *s, const Derivatives *d, const PetscReal down[3], PetscReal q, PetscReal z,
                      PetscReal Z[3])
{
  const PetscReal a = s->a, c = 1 - a;
  const PetscReal b3 = s->b[1] * down[1] + s->b[2] * down[2], U3 = d->U1[1] * down[1] + d->U1[2] * down[2];
  const PetscReal normal[3] = {0, 0, 1};
  PetscReal Vn[3], Vz[3], Uz[3], Un[3];

  SlipAlong2(d->V2, normal, Vn);
  SlipAlong2(d->V2, down, Vz);
  SlipAlong2(d->U2, normal, Un);
  SlipAlong2(d->U2, down, Uz);
  for (int i = 0; i < 3; i++)
    Z[i] = 4 * c * down[i] * d->U1[2] +
           2 * (-b3 * Vn[i] - c * down[2] * d->U1[i] + a * (normal[i] * U3 + q * Uz[i]) + c * s->b[2] * Vz[i]) -
           2 * a * z * Un[i];
}

/* Computes the derivatives of z Z_i. */
SLIP_WITHIN void DeepGradient(const SlipDipping *s, const Derivatives *d, const PetscReal down[3], PetscReal q,
                              PetscReal z, PetscReal g[3][3])
{
  const PetscReal a = s->a, c = 1 - a, b3 = s->b[1] * down[1] + s->b[2] * down[2], normal[3] = {0, 0, 1};
  PetscReal Z[3], Un[3], Uz[3], tensor[5], V3n[5], V3z[5], U2[5], U3n[5], U3z[5], rest[3][3];

  Deep(s, d, down, q, z, Z);
  SlipAlong2(d->U2, normal, Un);
  SlipAlong2(d->U2, down, Uz);
  SlipAlong3(d->V3, normal, V3n);
  SlipAlong3(d->V3, down, V3z);
  SlipAlong3(d->U3, normal, U3n);
  SlipAlong3(d->U3, down, U3z);
  for (int i = 0; i < 5; i++) {
    U2[i] = d->U2[i];
    tensor[i] = 2 * (-b3 * V3n[i] - c * down[2] * U2[i] + a * q * U3z[i] + c * s->b[2] * V3z[i]) - 2 * a * z * U3n[i];
  }
  Matrix(tensor, rest);
  for (int i = 0; i < 3; i++)
    for (int l = 0; l < 3; l++)
      g[i][l] = down[l] * Z[i] + z * (rest[i][l] + 4 * c * down[i] * Un[l] - 2 * a * down[l] * Un[i] +
                                      2 * a * (normal[i] * Uz[l] + normal[l] * Uz[i]));
}

/* The data of sources, in lanes of points */
typedef struct {
  PetscReal b[3][SLIP_LANES], slope[2][SLIP_LANES], a[SLIP_LANES];
} Sources;

SLIP_WITHIN SlipDipping SourceOf(const Sources *of, PetscInt k)
{
  return (SlipDipping){
    .b = {of->b[0][k], of->b[1][k], of->b[2][k]}, .slope = {of->slope[0][k], of->slope[1][k]}, .a = of->a[k]};
}

/* Computes the gradient by the sources. Their slope is that of their images: z and up change their sign. */
SLIP_WIDE static void Gradients(PetscInt n, const Sources *of, const PetscReal q[], const SlipPotential *v,
                                PetscReal out[restrict 9][SLIP_LANES])
{
  const PetscReal m[3] = {1, 1, -1};

  for (PetscInt k = 0; k < n; k++) {
    const SlipDipping s = SourceOf(of, k);
    PetscReal g[3][3];
    Derivatives d;

    DerivativesOf(v, k, s.b, 2, 3, &d);
    Gradient(&s, &d, q[k], -1, s.a, g);
    TurnBoth(s.slope, g);
    for (int i = 0; i < 9; i++) out[i][k] = m[i / 3] * m[i % 3] * g[i / 3][i % 3];
  }
}

/* Adds the gradient by the images; rest is the part of X. */
SLIP_WIDE static void AddGradients(PetscInt n, const Sources *of, const PetscReal q[], const PetscReal z[],
                                   const SlipPotential *v, const PetscReal (*rest)[SLIP_LANES],
                                   PetscReal out[restrict 9][SLIP_LANES])
{
  const PetscReal m[3] = {1, 1, -1};

  for (PetscInt k = 0; k < n; k++) {
    const SlipDipping s = SourceOf(of, k);
    const PetscReal down[3] = {0, s.slope[1], -s.slope[0]};
    const PetscReal x[3][3] = {
      {rest[0][k], rest[3][k], rest[4][k]}, {rest[3][k], rest[1][k], rest[5][k]}, {rest[4][k], rest[5][k], rest[2][k]}};
    PetscReal g[3][3], deep[3][3];
    Derivatives d;

    DerivativesOf(v, k, s.b, 2, 4, &d);
    Gradient(&s, &d, q[k], 1, 2 - s.a, g);
    TurnBoth(s.slope, g);
    DeepGradient(&s, &d, down, q[k], z[k], deep);
    TurnBoth(s.slope, deep);
    for (int i = 0; i < 9; i++)
      out[i][k] = out[i][k] + m[i / 3] * (g[i / 3][i % 3] + x[i / 3][i % 3]) + deep[i / 3][i % 3];
  }
}

/* Computes displacement in the same way. */
static void Displacements(const SlipDipping *const source[], PetscInt n, const PetscReal q[], const PetscReal z[],
                          const SlipPotential *v, const PetscReal (*rest)[SLIP_LANES], PetscBool image, PetscReal out[])
{
  const PetscReal m[3] = {1, 1, -1};

  for (PetscInt k = 0; k < n; k++) {
    const SlipDipping *s = source[k];
    const PetscReal down[3] = {0, s->slope[1], -s->slope[0]}, sign = image ? 1 : -1, factor = image ? 2 - s->a : s->a;
    PetscReal *to = out + 3 * k, u[3], Z[3];
    Derivatives d;

    DerivativesOf(v, k, s->b, 1, 3, &d);
    Displacement(s, &d, q[k], sign, factor, u);
    SlipTurnSlope(s->slope, u);
    for (int i = 0; i < 3; i++) {
      if (rest) u[i] += rest[i][k];
      to[i] = image ? to[i] + m[i] * u[i] : m[i] * u[i];
    }
    if (!image) continue;
    Deep(s, &d, down, q[k], z[k], Z);
    SlipTurnSlope(s->slope, Z);
    for (int i = 0; i < 3; i++) to[i] += z[k] * Z[i];
  }
}

/*
  SlipDippingAdd_Private - computes the part of 4 pi times the displacement or its gradient from V of the sources, or
  adds that from V of the images and from X in the directions x, y, z
*/
void SlipDippingAdd_Private(const SlipDipping *const source[], PetscInt n, const PetscReal q[], const PetscReal z[],
                            const SlipPotential *v, const PetscReal (*rest)[SLIP_LANES], PetscBool image,
                            PetscBool gradient, PetscReal out[])
{
  static const PetscReal none[6][SLIP_LANES] = {{0}};
  PetscReal g[9][SLIP_LANES];
  Sources of;

  if (!gradient) {
    Displacements(source, n, q, z, v, rest, image, out);
    return;
  }
  for (PetscInt k = 0; k < n; k++) {
    for (int i = 0; i < 3; i++) of.b[i][k] = source[k]->b[i];
    for (int i = 0; i < 2; i++) of.slope[i][k] = source[k]->slope[i];
    of.a[k] = source[k]->a;
    for (int i = 0; i < 9 && image; i++) g[i][k] = out[9 * k + i];
  }
  if (image)
    AddGradients(n, &of, q, z, v, rest ? rest : none, g);
  else
    Gradients(n, &of, q, v, g);
  for (PetscInt k = 0; k < n; k++)
    for (int i = 0; i < 9; i++) out[9 * k + i] = g[i][k];
}

/* Computes a point's coordinates in the directions of its rectangle or of the image, which are the mirrored ones: the
   image is to a point at -z as the rectangle is to z. */
static void Place(const SlipDipping *s, const SlipPlatePoints *ground, PetscInt k, PetscBool image, PetscBool gradient,
                  SlipPlatePoints *p)
{
  const PetscReal ty = s->slope[0], tz = s->slope[1], y = ground->t[k];
  const PetscReal z = image ? ground->q[k] + s->depth : s->depth - ground->q[k];

  p->t[k] = ty * y + tz * z;
  p->q[k] = tz * y - ty * z;
  p->move[k] = 0;
  if (PetscAbsReal(p->q[k]) > p->rounding[k]) return;
  p->q[k] = 0;
  /* where displacement has two values, take the hanging wall's; along the ground, so that it holds on the trace too */
  if (gradient || PetscAbsReal(p->x[k]) > p->half_length[k] + p->rounding[k] ||
      PetscAbsReal(p->t[k]) > p->half_width[k] + p->rounding[k])
    return;
  p->q[k] = SLIP_AT_EDGE * p->rounding[k] * tz;
  p->move[k] = SLIP_AT_EDGE * p->rounding[k] * ty;
}

/* Computes first or second derivatives of 2 (1 - 2 nu) sin(dip) (b_x X_xy - b_y X_xx) at n points. */
static void Rest(const SlipDipping *const source[], PetscInt n, const SlipLogPotential *f, PetscBool gradient,
                 PetscReal rest[6][SLIP_LANES])
{
  for (PetscInt k = 0; k < n; k++) {
    const SlipDipping *s = source[k];
    const PetscReal surface = 2 * s->rest * s->slope[1], by = s->b[1] * s->slope[0] + s->b[2] * s->slope[1];

    for (int d = 0; d < 3 && !gradient; d++) rest[d][k] = surface * (s->b[0] * f->across[d][k] - by * f->along[d][k]);
    for (int d = 0; d < 6 && gradient; d++)
      rest[d][k] = surface * (s->b[0] * f->across_second[d][k] - by * f->along_second[d][k]);
  }
}

/*
  SlipDippingFields_Private - computes 4 pi times the displacement or its gradient at some points, by each of some slips
  on the same rectangles; terms that depend on the rectangles alone are computed once
*/
void SlipDippingFields_Private(PetscInt slips, const SlipDipping *const *const of[], SlipPlatePoints *ground,
                               PetscBool gradient, PetscReal *const out[])
{
  const SlipDipping *const *const source = of[0];
  const PetscInt lowest = gradient ? 2 : 1;
  PetscReal rest[6][SLIP_LANES];
  SlipPlatePoints p;
  SlipLogPotential f;
  SlipPotential v;

  for (PetscInt k = 0; k < ground->n; k++) {
    ground->half_length[k] = 0.5 * source[k]->length;
    ground->half_width[k] = 0.5 * source[k]->width;
    ground->ty[k] = source[k]->slope[0];
    ground->tz[k] = source[k]->slope[1];
    ground->lean[k] = ground->ty[k] / (1 + ground->tz[k]);
  }
  p = *ground;
  for (int image = 0; image < (source[0]->full_space ? 1 : 2); image++) {
    const PetscBool surface = (PetscBool)(image && source[0]->rest != 0);

    for (PetscInt k = 0; k < p.n; k++) Place(source[k], ground, k, (PetscBool)image, gradient, &p);
    SlipPotential_Private(&p, lowest, image ? lowest + 2 : 3, &v);
    if (surface) SlipLogPotential_Private(&p, gradient, &f);
    for (PetscInt s = 0; s < slips; s++) {
      if (surface) Rest(of[s], p.n, &f, gradient, rest);
      SlipDippingAdd_Private(of[s], p.n, p.q, ground->q, &v, surface ? (const PetscReal(*)[SLIP_LANES])rest : NULL,
                             (PetscBool)image, gradient, out[s]);
    }
  }
}
