/*
  Tractions of pairs of triangles in lanes: the gradient of dipping.c times the receiver's normal n, from derivatives of
  triangle_edges.c.

  A stress is 2 G times the strain and a multiple of its trace, so that twice the strain times n gives the tractions
  along all directions of the receiver. With g and h the parts m_i J_i,l and (z Z_i)_l of dipping.c,
  without their m_i, it is

     m (g n) + g' (m n) + (h + h') n,

  each product in the directions of the image. The source is like an image at -z, and symmetric under m.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptrianglelanes.h>

#define STEEP 0.5 /* edges with a smaller vertical share may be directed upward: triangle_surface.c */

/*
  SlipTriangleDataOf_Private - computes the numbers of a triangle
*/
void SlipTriangleDataOf_Private(PetscReal nu, PetscBool full_space, PetscInt slips, const SlipTriangleCell *cell,
                                SlipTriangleData *d)
{
  const PetscReal *v = cell->vertices;
  SlipTriangle s;

  *d = (SlipTriangleData){.rounding = 0};
  SlipTriangleOf_Private(nu, full_space, v, cell->directions + 6, &s);
  for (int i = 0; i < 3; i++) {
    d->middle[i] = s.middle[i];
    d->centroid[i] = (v[i] + v[3 + i] + v[6 + i]) / 3;
    d->reach += SLIP_ROUNDING * PetscAbsReal(d->centroid[i]);
    for (int j = 0; j < 3; j++) d->direction[i][j] = cell->directions[3 * i + j];
  }
  if (!full_space) d->centroid[2] = PetscMax(d->centroid[2], 0);
  for (int i = 0; i < 2; i++) {
    d->strike[i] = s.strike[i];
    d->slope[i] = s.plane.slope[i];
  }
  d->rounding = s.rounding;
  for (int k = 0; k < 3; k++) {
    const PetscReal y = s.up[k] * s.plane.slope[0], z = s.up[k] * s.plane.slope[1];
    const PetscReal flat = PetscSqrtReal(s.along[k] * s.along[k] + y * y), down = z < 0 ? -1 : 1;
    const PetscReal one[2] = {s.up[k], s.along[k]};

    d->x[k] = s.x[k];
    d->t[k] = s.t[k];
    d->depth[k] = s.middle[2] + s.t[k] * -s.plane.slope[1];
    d->length[k] = s.length[k];
    d->along[k] = s.along[k];
    d->up[k] = s.up[k];
    for (int n = 0; n < 3; n++) {
      const PetscReal *last = n ? d->power[k][n - 1] : one;

      d->power[k][n][0] = last[0] * one[0] - last[1] * one[1];
      d->power[k][n][1] = last[0] * one[1] + last[1] * one[0];
    }
    d->hx[k] = flat > 0 ? s.along[k] / flat : 1;
    d->hy[k] = flat > 0 ? y / flat : 0;
    d->flat[k] = flat;
    d->steep[k] = z;
    d->down[k] = down;
    d->turns[k] = PetscAbsReal(z) < STEEP ? down : 0;
    for (int i = 0; i < 2; i++) {
      const PetscReal sign = i ? -down : down, up = i && d->turns[k] == 0 ? 1 : 1 + sign * z; /* 0 if it is vertical */

      d->lean[k][i] = sign * flat / up;
      d->share[k][i] = sign * z / up;
    }
  }
  for (PetscInt m = 0; m < slips; m++) {
    PetscReal by;

    SlipTriangleSetSlip_Private(&s, cell->directions + 3 * m);
    for (int i = 0; i < 3; i++) d->slip[m][i] = s.plane.b[i];
    by = s.plane.b[1] * s.plane.slope[0] + s.plane.b[2] * s.plane.slope[1];
    for (int k = 0; k < 3; k++) {
      const PetscReal factor = -2 * s.plane.rest * d->steep[k];

      d->edge_slip[m][k][0] = factor * (s.plane.b[0] * d->hx[k] + by * d->hy[k]);
      d->edge_slip[m][k][1] = factor * (by * d->hx[k] - s.plane.b[0] * d->hy[k]);
    }
  }
}

/* The derivatives at the receiver in lane k: V2, V3 and V4, those along the slip b, U1, U2 and U3, and q */
typedef struct {
  PetscReal b[3], V2[5], V3[7], Vn[3], U1[3], U2[5], q;
} Field;

SLIP_WITHIN Field FieldOf(const SlipTriangleLanes *s, const SlipTrianglePairs *v, PetscInt slip, int k)
{
  Field f = {.b = {s->slip[slip][0][k], s->slip[slip][1][k], s->slip[slip][2][k]},
             .V2 = {v->second[0][k], v->second[1][k], v->second[2][k], v->second[3][k], v->second[4][k]},
             .V3 = {v->third[0][k], v->third[1][k], v->third[2][k], v->third[3][k], v->third[4][k], v->third[5][k],
                    v->third[6][k]},
             .q = v->q[k]};

  f.Vn[0] = f.V2[2];
  f.Vn[1] = f.V2[4];
  f.Vn[2] = -f.V2[0] - f.V2[3];
  SlipAlong2(f.V2, f.b, f.U1);
  SlipAlong3(f.V3, f.b, f.U2);
  return f;
}

/* Computes the symmetric part of the gradient J_i,l: -c b_n V_il + factor q U_il. */
SLIP_WITHIN void Symmetric(const Field *f, PetscReal c, PetscReal factor, PetscReal A[5])
{
  const PetscReal cb = c * f->b[2], fq = factor * f->q;

  for (int i = 0; i < 5; i++) A[i] = fq * f->U2[i] - cb * f->V2[i];
}

/* The normals of a receiver in the directions of the image, and with its vertical part reversed */
SLIP_WITHIN void Normals(const SlipTriangleLanes *s, const SlipTriangleLanes *r, int k, PetscReal plain[3],
                         PetscReal mirrored[3])
{
  const PetscReal slope[2] = {s->slope[0][k], s->slope[1][k]}, c = s->strike[0][k], d = s->strike[1][k];
  const PetscReal n[3] = {r->direction[2][0][k], r->direction[2][1][k], r->direction[2][2][k]};

  plain[0] = mirrored[0] = c * n[0] + d * n[1];
  plain[1] = mirrored[1] = c * n[1] - d * n[0];
  plain[2] = n[2];
  mirrored[2] = -n[2];
  SlipTurnSlope(slope, plain);
  SlipTurnSlope(slope, mirrored);
}

/* Twice the strain times the normal: in the image's directions as it is, and with a vertical part that is to be
   reversed; its part along strike, to the right and down; and the trace of the strain */
typedef struct {
  PetscReal plain[3][SLIP_PAIRS], mirrored[3][SLIP_PAIRS], ground[3][SLIP_PAIRS], trace[SLIP_PAIRS];
} Strain;

/* Computes the part of the sources. */
SLIP_FUSED static void SourceStrain(const SlipTriangleLanes *s, const SlipTriangleLanes *r, const SlipTrianglePairs *v,
                                    PetscReal a, PetscInt slip, Strain *restrict e)
{
  const PetscReal c = a - 1, both = c + a;

  for (int k = 0; k < SLIP_PAIRS; k++) {
    const Field f = FieldOf(s, v, slip, k);
    PetscReal plain[3], n[3], A[5], An[3], Vn, Un, bn;

    Normals(s, r, k, plain, n);
    Symmetric(&f, c, a, A);
    SlipAlong2(A, n, An);
    Vn = SlipDot(f.Vn, n);
    bn = SlipDot(f.b, n);
    Un = SlipDot(f.U1, n);
    for (int i = 0; i < 3; i++) {
      e->mirrored[i][k] = 2 * An[i] - f.b[i] * Vn - f.Vn[i] * bn + both * n[2] * f.U1[i];
      e->plain[i][k] = e->ground[i][k] = 0;
    }
    e->mirrored[2][k] += both * Un;
    e->trace[k] = (both - 1) * f.U1[2];
  }
}

/* Adds the part of z Z to plain: (h + h') n with h its gradient; returns the trace of h. */
SLIP_WITHIN PetscReal AddDeep(const Field *f, const SlipTrianglePairs *v, int k, PetscReal a, const PetscReal down[3],
                              PetscReal z, const PetscReal n[3], PetscReal plain[3])
{
  const PetscReal c = 1 - a, b3 = f->b[1] * down[1] + f->b[2] * down[2];
  const PetscReal w[3] = {0, 2 * a * f->q * down[1], 2 * a * (f->q * down[2] - z)};
  const PetscReal u[3] = {0, 2 * c * f->b[2] * down[1], 2 * (c * f->b[2] * down[2] - b3)}, less = 2 * c * down[2];
  const PetscReal fourth[9] = {v->fourth[0][k], v->fourth[1][k], v->fourth[2][k], v->fourth[3][k], v->fourth[4][k],
                               v->fourth[5][k], v->fourth[6][k], v->fourth[7][k], v->fourth[8][k]};
  const PetscReal Un[3] = {f->U2[2], f->U2[4], -f->U2[0] - f->U2[3]};
  PetscReal U3[7], Z[3], Uz[3], part[3], one[5], rest[5], Rn[3], dn, Zn, Unn, Uzn;

  SlipAlong4(fourth, f->b, U3);
  SlipAlong3(U3, w, rest);
  SlipAlong3(f->V3, u, one);
  for (int i = 0; i < 5; i++) rest[i] += one[i] - less * f->U2[i];
  SlipAlong2(rest, n, Rn);
  SlipAlong2(f->U2, down, Uz);
  SlipAlong2(f->U2, w, Z);
  SlipAlong2(f->V2, u, part);
  for (int i = 0; i < 3; i++) Z[i] += part[i] + 4 * c * f->U1[2] * down[i] - less * f->U1[i];
  Z[2] += 2 * a * (f->U1[1] * down[1] + f->U1[2] * down[2]);
  dn = SlipDot(down, n);
  Zn = SlipDot(Z, n);
  Unn = SlipDot(Un, n);
  Uzn = SlipDot(Uz, n);
  for (int i = 0; i < 3; i++)
    plain[i] += Z[i] * dn + down[i] * Zn +
                z * (2 * Rn[i] + (4 * c - 2 * a) * (down[i] * Unn + Un[i] * dn) + 4 * a * n[2] * Uz[i]);
  plain[2] += 4 * a * z * Uzn;
  return SlipDot(down, Z) + z * (4 * c + 2 * a) * SlipDot(down, Un);
}

/* Adds the part of the images. */
SLIP_FUSED static void AddImageStrain(const SlipTriangleLanes *s, const SlipTriangleLanes *r,
                                      const SlipTrianglePairs *v, PetscReal a, PetscInt slip, Strain *restrict e)
{
  const PetscReal c = 1 - a, factor = 2 - a;

  for (int k = 0; k < SLIP_PAIRS; k++) {
    const PetscReal down[3] = {0, s->slope[1][k], -s->slope[0][k]}, z = r->centroid[2][k];
    const Field f = FieldOf(s, v, slip, k);
    PetscReal n[3], m[3], A[5], An[3], Am[3], Ad[3], to[3], Vn, Un, Um, bm, deep;

    Normals(s, r, k, n, m);
    Symmetric(&f, c, factor, A);
    SlipAlong2(A, n, An);
    SlipAlong2(A, m, Am);
    SlipAlong2(A, down, Ad);
    Vn = SlipDot(f.Vn, n);
    Un = SlipDot(f.U1, n);
    Um = SlipDot(f.U1, m);
    bm = SlipDot(f.b, m);
    for (int i = 0; i < 3; i++) {
      e->mirrored[i][k] += An[i] - f.b[i] * Vn + factor * n[2] * f.U1[i];
      to[i] = Am[i] - f.Vn[i] * bm + c * m[2] * f.U1[i];
    }
    e->mirrored[2][k] += c * Un;
    to[2] += factor * Um;
    deep = AddDeep(&f, v, k, a, down, z, n, to);
    for (int i = 0; i < 3; i++) e->plain[i][k] = to[i];
    e->trace[k] +=
      deep + (c + factor - 1) * f.U1[2] -
      2 * (SlipDot(down, Ad) - SlipDot(f.b, down) * SlipDot(f.Vn, down) + (c + factor) * down[2] * SlipDot(f.U1, down));
  }
}

/* Adds the part of X. */
SLIP_FUSED static void AddLogStrain(const SlipTriangleLanes *s, const SlipTriangleLanes *r, const SlipTrianglePairs *v,
                                    PetscInt slip, Strain *restrict e)
{
  for (int k = 0; k < SLIP_PAIRS; k++) {
    const PetscReal c = s->strike[0][k], d = s->strike[1][k], n0 = r->direction[2][0][k], n1 = r->direction[2][1][k];
    const PetscReal along = c * n0 + d * n1, right = c * n1 - d * n0;
    PetscReal xx = 0, xy = 0, yy = 0;

#define ADD(edge)                                                                                                      \
  do {                                                                                                                 \
    const PetscReal bx = s->edge_slip[slip][edge][0][k], by = s->edge_slip[slip][edge][1][k];                          \
    const PetscReal hx = s->hx[edge][k], hy = s->hy[edge][k], g0 = by * v->log[edge][2][k] - bx * v->log[edge][1][k];  \
    const PetscReal g1 = bx * v->log[edge][0][k] - by * v->log[edge][3][k];                                            \
    const PetscReal g3 = -bx * v->log[edge][2][k] - by * v->log[edge][0][k];                                           \
    const PetscReal ax = hx * g1 - hy * g3, ay = hx * g3 - hy * g0;                                                    \
                                                                                                                       \
    xx += hx * ax - hy * ay;                                                                                           \
    xy += hy * ax + hx * ay;                                                                                           \
    yy += hy * (hy * g1 + hx * g3) + hx * (hy * g3 + hx * g0);                                                         \
  } while (0)
    ADD(0);
    ADD(1);
    ADD(2);
#undef ADD
    e->ground[0][k] = 2 * (xx * along + xy * right);
    e->ground[1][k] = 2 * (xy * along + yy * right);
    e->ground[2][k] = 2 * (xx + yy) * r->direction[2][2][k];
    e->trace[k] += 2 * (xx + yy);
  }
}

/* Computes tractions [rows][stride][SLIP_PAIRS] from strains times unit = G/(4 pi). */
SLIP_FUSED static void Tractions(const SlipTriangleLanes *s, const SlipTriangleLanes *r, PetscReal unit, PetscReal nu,
                                 PetscInt first, PetscInt rows, PetscInt stride, const Strain *e,
                                 PetscReal traction[restrict])
{
  const PetscReal volume = 2 * nu / (1 - 2 * nu);
  PetscReal t[3][SLIP_PAIRS];

  for (int k = 0; k < SLIP_PAIRS; k++) {
    const PetscReal slope[2] = {s->slope[0][k], s->slope[1][k]}, c = s->strike[0][k], d = s->strike[1][k];
    PetscReal plain[3] = {e->plain[0][k], e->plain[1][k], e->plain[2][k]}, along, right;
    PetscReal mirrored[3] = {e->mirrored[0][k], e->mirrored[1][k], e->mirrored[2][k]};

    SlipTurnSlope(slope, plain);
    SlipTurnSlope(slope, mirrored);
    along = plain[0] + mirrored[0] + e->ground[0][k];
    right = plain[1] + mirrored[1] + e->ground[1][k];
    t[0][k] = -unit * (c * along - d * right);
    t[1][k] = -unit * (d * along + c * right);
    t[2][k] = -unit * (plain[2] - mirrored[2] + e->ground[2][k]);
  }
  for (PetscInt i = first; i < first + rows; i++) {
    const PetscReal more = i == 2 ? unit * volume : 0;
    PetscReal *to = traction + stride * SLIP_PAIRS * (i - first);

    for (int k = 0; k < SLIP_PAIRS; k++)
      to[k] = r->direction[i][0][k] * t[0][k] + r->direction[i][1][k] * t[1][k] + r->direction[i][2][k] * t[2][k] -
              more * e->trace[k];
  }
}

/*
  SlipTriangleLanesTractions_Private - computes tractions [rows][slips][SLIP_PAIRS] along directions of the receivers,
  from number `first` on, by unit slips on the sources. near [SLIP_PAIRS] is 1 where they are not valid, else 0: on
  edges the functions of triangle.c must be used.
*/
void SlipTriangleLanesTractions_Private(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips, PetscInt first,
                                        PetscInt rows, const SlipTriangleLanes *receiver,
                                        const SlipTriangleLanes *source, PetscReal traction[], PetscReal near[])
{
  const PetscReal a = 1 / (2 * (1 - nu));
  SlipTrianglePairs direct, image;

  for (int k = 0; k < SLIP_PAIRS; k++) near[k] = 0;
  SlipTriangleSourceEdges_Private(source, receiver, near, &direct);
  if (!full_space) SlipTriangleImageEdges_Private(source, receiver, near, &image);
  for (PetscInt slip = 0; slip < slips; slip++) {
    Strain e;

    SourceStrain(source, receiver, &direct, a, slip, &e);
    if (!full_space) {
      AddImageStrain(source, receiver, &image, a, slip, &e);
      AddLogStrain(source, receiver, &image, slip, &e);
    }
    Tractions(source, receiver, G / (4 * PETSC_PI), nu, first, rows, slips, &e, traction + slip * SLIP_PAIRS);
  }
}
