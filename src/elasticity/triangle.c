/*
  Displacement and its gradient by uniform slip on a triangle, in closed form: the formulas of dipping.c hold for any
  plane area, with V of triangle_potential.c and the part F of triangle_surface.c.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptriangle.h>

/*
  SlipTriangleOf_Private - sets up a triangle without its slip; normal points into the hanging wall
*/
void SlipTriangleOf_Private(PetscReal nu, PetscBool full_space, const PetscReal vertices[9], const PetscReal normal[3],
                            SlipTriangle *s)
{
  PetscReal own[3], corner[3][3], sine;
  int order[3] = {0, 1, 2};

  SlipTriangleNormal(vertices, own);
  if (SlipDot(own, normal) < 0) {
    order[1] = 2;
    order[2] = 1;
    for (int i = 0; i < 3; i++) own[i] = -own[i];
  }
  SlipUnit(own);
  s->rounding = 0;
  for (int i = 0; i < 3; i++) {
    s->normal[i] = own[i];
    for (int k = 0; k < 3; k++) {
      const PetscReal v = vertices[3 * order[k] + i];

      corner[k][i] = i == 2 && !full_space && v < 0 ? 0 : v;
    }
    s->middle[i] = (corner[0][i] + corner[1][i] + corner[2][i]) / 3;
    s->rounding +=
      PetscMax(PetscAbsReal(corner[0][i]), PetscMax(PetscAbsReal(corner[1][i]), PetscAbsReal(corner[2][i])));
  }
  s->rounding *= SLIP_ROUNDING;
  sine = PetscSqrtReal(own[0] * own[0] + own[1] * own[1]);
  s->strike[0] = sine > 0 ? own[1] / sine : 1;
  s->strike[1] = sine > 0 ? -own[0] / sine : 0;
  s->plane = (SlipDipping){.depth = s->middle[2],
                           .slope = {own[2], sine},
                           .a = 1 / (2 * (1 - nu)),
                           .rest = 1 - 2 * nu,
                           .full_space = full_space};
  s->image_only = PETSC_FALSE;
  for (int k = 0; k < 3; k++) {
    const PetscReal x = corner[k][0] - s->middle[0], y = corner[k][1] - s->middle[1], z = corner[k][2] - s->middle[2];

    s->x[k] = s->strike[0] * x + s->strike[1] * y;
    s->t[k] = own[2] * (s->strike[0] * y - s->strike[1] * x) - sine * z;
  }
  for (int k = 0; k < 3; k++) {
    const PetscReal x = s->x[(k + 1) % 3] - s->x[k], t = s->t[(k + 1) % 3] - s->t[k];

    s->length[k] = PetscSqrtReal(x * x + t * t);
    s->along[k] = x / s->length[k];
    s->up[k] = t / s->length[k];
  }
}

/*
  SlipTriangleSetSlip_Private - sets the jump of displacement b, hanging wall less foot wall, north, east and down
*/
void SlipTriangleSetSlip_Private(SlipTriangle *s, const PetscReal b[3])
{
  const PetscReal right = s->strike[0] * b[1] - s->strike[1] * b[0];
  SlipDipping *plane = &s->plane;

  plane->b[0] = s->strike[0] * b[0] + s->strike[1] * b[1];
  plane->b[1] = plane->slope[0] * right - plane->slope[1] * b[2];
  plane->b[2] = plane->slope[1] * right + plane->slope[0] * b[2];
}

/*
  SlipTrianglePointOf_Private - converts point k to coordinates along strike, to the right and down
*/
void SlipTrianglePointOf_Private(const SlipTriangle *s, const PetscReal at[3], PetscInt k, SlipTrianglePoints *p)
{
  const PetscReal x = at[0] - s->middle[0], y = at[1] - s->middle[1];

  p->x[k] = s->strike[0] * x + s->strike[1] * y;
  p->t[k] = s->strike[0] * y - s->strike[1] * x;
  p->q[k] = s->plane.full_space || at[2] > 0 ? at[2] : 0;
  p->rounding[k] = s->rounding + SLIP_ROUNDING * (PetscAbsReal(at[0]) + PetscAbsReal(at[1]) + PetscAbsReal(at[2]));
}

/* Sets lane k of the edges to those of a triangle. */
static void Lane(const SlipTriangle *s, PetscInt k, SlipTriangleEdges *e)
{
  const PetscReal ty = s->plane.slope[0], tz = s->plane.slope[1];

  e->ty[k] = ty;
  e->tz[k] = tz;
  for (int i = 0; i < 3; i++) {
    const PetscReal y = s->up[i] * ty, z = s->up[i] * tz, flat = PetscSqrtReal(s->along[i] * s->along[i] + y * y);

    e->x[i][k] = s->x[i];
    e->t[i][k] = s->t[i];
    e->along[i][k] = s->along[i];
    e->up[i][k] = s->up[i];
    e->hx[i][k] = flat > 0 ? s->along[i] / flat : 1;
    e->hy[i][k] = flat > 0 ? y / flat : 0;
    e->flat[i][k] = flat;
    e->steep[i][k] = z;
  }
}

static PetscBool Inside(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt k)
{
  for (int edge = 0; edge < 3; edge++)
    if (SlipEdgeAcross(e, p, edge, k) > 0) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Converts points to the directions of their triangles or of the images, as in dipping.c. */
static void Place(const SlipTriangle *const source[], const SlipTriangleEdges *e, const SlipTrianglePoints *ground,
                  PetscBool image, PetscBool gradient, SlipTrianglePoints *p)
{
  for (PetscInt k = 0; k < p->n; k++) {
    const PetscReal depth = source[k]->plane.depth, y = ground->t[k], tiny = SLIP_AT_EDGE * p->rounding[k];
    const PetscReal z = image ? ground->q[k] + depth : depth - ground->q[k];

    p->t[k] = e->ty[k] * y + e->tz[k] * z;
    p->q[k] = e->tz[k] * y - e->ty[k] * z;
    p->move[k] = 0;
    if (PetscAbsReal(p->q[k]) > p->rounding[k]) continue;
    p->q[k] = 0;
    /* where displacement has two values, take the hanging wall's; along the ground, so also on the trace */
    if (gradient || !Inside(e, p, k)) continue;
    p->q[k] = tiny * e->tz[k];
    p->move[k] = tiny * e->ty[k];
  }
}

/* Sets the horizontal slip on a triangle. */
static void Slip(const SlipDipping *plane, PetscInt k, SlipTriangleEdges *e)
{
  e->bx[k] = plane->b[0];
  e->by[k] = plane->b[1] * plane->slope[0] + plane->b[2] * plane->slope[1];
}

/*
  SlipTriangleFields_Private - computes 4 pi times the displacement or its gradient at some points, by each of some
  slips on the same triangles; terms that depend on the triangles alone are computed once
*/
void SlipTriangleFields_Private(PetscInt slips, const SlipTriangle *const *const of[], SlipTrianglePoints *ground,
                                PetscBool gradient, PetscReal *const out[])
{
  const SlipTriangle *const *const source = of[0];
  const PetscInt lowest = gradient ? 2 : 1;
  const SlipDipping *plane[SLIP_LANES];
  PetscReal rest[6][SLIP_LANES];
  SlipTrianglePoints p = *ground;
  SlipTriangleEdges e;
  SlipPotential v;

  for (PetscInt k = 0; k == 0 || k < p.n; k++) Lane(source[k], k, &e);
  for (PetscInt s = 0; s < slips && source[0]->image_only; s++)
    for (PetscInt k = 0; k < (gradient ? 9 : 3) * p.n; k++) out[s][k] = 0;
  for (int image = source[0]->image_only ? 1 : 0; image < (source[0]->plane.full_space ? 1 : 2); image++) {
    const PetscBool surface = (PetscBool)(image && source[0]->plane.rest != 0);

    Place(source, &e, ground, (PetscBool)image, gradient, &p);
    SlipTrianglePotential_Private(&e, &p, lowest, image ? lowest + 2 : 3, &v);
    for (PetscInt s = 0; s < slips; s++) {
      for (PetscInt k = 0; k < p.n; k++) {
        plane[k] = &of[s][k]->plane;
        Slip(plane[k], k, &e);
      }
      if (surface) {
        SlipTriangleLog_Private(&e, &p, gradient, rest);
        for (int d = 0; d < (gradient ? 6 : 3); d++)
          for (PetscInt k = 0; k < p.n; k++) rest[d][k] *= -2 * plane[k]->rest;
      }
      SlipDippingAdd_Private(plane, p.n, p.q, ground->q, &v, surface ? (const PetscReal(*)[SLIP_LANES])rest : NULL,
                             (PetscBool)image, gradient, out[s]);
    }
  }
}
