/*
  Displacement and its gradient by uniform slip on a triangle, in closed form: what dipping.c says of rectangles holds
  for any plane area, with V of triangle_potential.c and the part F of triangle_surface.c.
*/
#include <slipcompat.h>
#include <slipstep/private/sliptriangle.h>

/* A triangle as one of the points sees it; the image of an edge that is horizontal to rounding is. */
static void Lane(const SlipTriangle *s, PetscInt k, SlipTriangleEdges *e)
{
  const SlipDipping *plane = &s->plane;
  const PetscReal ty = plane->slope[0], tz = plane->slope[1];

  e->ty[k] = ty;
  e->tz[k] = tz;
  e->bx[k] = plane->b[0];
  e->by[k] = plane->b[1] * ty + plane->b[2] * tz;
  for (int i = 0; i < 3; i++) {
    const PetscReal y = s->up[i] * ty, z = s->up[i] * tz, flat = PetscSqrtReal(s->along[i] * s->along[i] + y * y);

    e->x[i][k] = s->x[i];
    e->t[i][k] = s->t[i];
    e->along[i][k] = s->along[i];
    e->up[i][k] = s->up[i];
    e->hx[i][k] = flat > 0 ? s->along[i] / flat : 1;
    e->hy[i][k] = flat > 0 ? y / flat : 0;
    e->flat[i][k] = flat;
    e->steep[i][k] = PetscAbsReal(z) * s->length[i] > s->rounding ? z : 0;
  }
}

static PetscBool Inside(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt k)
{
  for (int edge = 0; edge < 3; edge++)
    if (SlipEdgeAcross(e, p, edge, k) > 0) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Points in the directions of their triangles or of the images, as in dipping.c */
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
    /* where displacement has two values, the hanging wall's; along the ground, so that the trace has its limit too */
    if (gradient || !Inside(e, p, k)) continue;
    p->q[k] = e->tz[k] > 0 ? tiny * e->tz[k] : tiny;
    p->move[k] = e->tz[k] > 0 ? tiny * e->ty[k] : 0;
  }
}

/*
  SlipTriangleFields_Private - 4 pi times the displacement or its gradient at some points
*/
void SlipTriangleFields_Private(const SlipTriangle *const source[], SlipTrianglePoints *ground, PetscBool gradient,
                                PetscReal out[])
{
  const PetscInt lowest = gradient ? 2 : 1;
  const SlipDipping *plane[SLIP_LANES];
  PetscReal rest[6][SLIP_LANES];
  SlipTrianglePoints p = *ground;
  SlipTriangleEdges e;
  SlipPotential v;

  for (PetscInt k = 0; k == 0 || k < p.n; k++) {
    plane[k] = &source[k]->plane;
    Lane(source[k], k, &e);
  }
  for (int image = 0; image < (plane[0]->full_space ? 1 : 2); image++) {
    const PetscBool surface = (PetscBool)(image && plane[0]->rest != 0);

    Place(source, &e, ground, (PetscBool)image, gradient, &p);
    SlipTrianglePotential_Private(&e, &p, lowest, image ? lowest + 2 : 3, &v);
    if (surface) {
      SlipTriangleLog_Private(&e, &p, gradient, rest);
      for (int d = 0; d < (gradient ? 6 : 3); d++)
        for (PetscInt k = 0; k < p.n; k++) rest[d][k] *= -2 * plane[k]->rest;
    }
    SlipDippingAdd_Private(plane, p.n, p.q, ground->q, &v, surface ? (const PetscReal(*)[SLIP_LANES])rest : NULL,
                           (PetscBool)image, gradient, out);
  }
}
