/* Private: what the fields of a triangle are put together from, sums over its edges for some points at once. */
#pragma once
#include <slipstep/private/slipdipping.h>

/* A triangle as its fields need it. Edge k goes from vertex k to the next one, around the hanging wall's normal. */
typedef struct {
  SlipDipping plane;               /* depth is that of the middle */
  PetscReal middle[3], strike[2];  /* [m]; cosine and sine */
  PetscReal normal[3];             /* into the hanging wall */
  PetscReal x[3], t[3], length[3]; /* vertices from the middle, and of the edges [m] */
  PetscReal along[3], up[3];       /* directions of the edges along strike and up dip */
  PetscReal rounding;              /* of the triangle's coordinates [m] */
} SlipTriangle;

/* Those of some points. The images of edges: horizontal direction along strike and to the right, and of the edge the
   parts in that direction and down. */
typedef struct {
  PetscReal x[3][SLIP_LANES], t[3][SLIP_LANES], length[3][SLIP_LANES], along[3][SLIP_LANES], up[3][SLIP_LANES];
  PetscReal hx[3][SLIP_LANES], hy[3][SLIP_LANES], flat[3][SLIP_LANES], steep[3][SLIP_LANES];
  PetscReal ty[SLIP_LANES], tz[SLIP_LANES]; /* of the direction up dip of the image: to the right and down */
  PetscReal bx[SLIP_LANES], by[SLIP_LANES]; /* slip along strike and to the right */
} SlipTriangleEdges;

/* Points, each as its own triangle sees it from its middle. */
typedef struct {
  PetscInt n; /* at most SLIP_LANES */
  PetscReal x[SLIP_LANES], t[SLIP_LANES], q[SLIP_LANES];
  PetscReal rounding[SLIP_LANES]; /* of the coordinates: what is less from an edge or the plane is on it [m] */
  PetscReal move[SLIP_LANES];     /* what is to be added to t, less than rounding */
} SlipTrianglePoints;

/* ---- triangle.c: 4 pi times the displacement [n][3] or its gradient [n][9] along strike, to the right and down, of
   points with x and y (as t) from the middle of their triangles source[] and the depth (as q) ---- */
PETSC_INTERN void SlipTriangleFields_Private(const SlipTriangle *const source[], SlipTrianglePoints *ground,
                                             PetscBool gradient, PetscReal out[]);
/* ---- triangle_potential.c ---- */
PETSC_INTERN void SlipTrianglePotential_Private(const SlipTriangleEdges *e, const SlipTrianglePoints *p,
                                                PetscInt lowest, PetscInt highest, SlipPotential *v);
/* ---- triangle_surface.c: the sum over edges of the vertical part of each times derivatives of the integral along it
   of b_x chi_y - b_y chi_x ---- */
PETSC_INTERN void SlipTriangleLog_Private(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscBool gradient,
                                          PetscReal sum[6][SLIP_LANES]);

/* ---- triangle_points.c: pairs of cells that slip along the first of their directions, with tractions at the
   receivers' centroids along the receivers' own; cells are not checked ---- */
typedef struct {
  PetscReal vertices[9];   /* each north, east and down [m] */
  PetscReal directions[9]; /* along the rake, across it in the plane, and into the hanging wall */
} SlipTriangleCell;
PETSC_EXTERN void SlipTriangleTractions(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt n,
                                        const SlipTriangleCell *const receiver[],
                                        const SlipTriangleCell *const source[], PetscReal traction[]);

/* An edge's distances from a point along its normal outward and along itself from its end; those of rounding are 0. */
SLIP_WITHIN PetscReal SlipEdgeAcross(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt edge, PetscInt k)
{
  const PetscReal v = (p->x[k] - e->x[edge][k]) * e->up[edge][k] - (p->t[k] - e->t[edge][k]) * e->along[edge][k];

  return (PetscAbsReal(v) <= p->rounding[k] ? 0 : v) - p->move[k] * e->along[edge][k];
}

SLIP_WITHIN PetscReal SlipEdgeAlong(const SlipTriangleEdges *e, const SlipTrianglePoints *p, PetscInt edge,
                                    PetscInt vertex, PetscInt k)
{
  const PetscReal v = (p->x[k] - e->x[vertex][k]) * e->along[edge][k] + (p->t[k] - e->t[vertex][k]) * e->up[edge][k];

  return (PetscAbsReal(v) <= p->rounding[k] ? 0 : v) + p->move[k] * e->up[edge][k];
}
