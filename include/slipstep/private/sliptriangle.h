/* Internal: the fields of a triangle as sums over its edges, for several points at once */
#pragma once
#include <slipstep/private/slipdipping.h>

/* A triangle. Edge k goes from vertex k to the next one, around the hanging wall's normal. */
typedef struct {
  SlipDipping plane;               /* depth is that of the middle */
  PetscReal middle[3], strike[2];  /* [m]; cosine and sine */
  PetscReal normal[3];             /* into the hanging wall */
  PetscReal x[3], t[3], length[3]; /* vertices from the middle, and of the edges [m] */
  PetscReal along[3], up[3];       /* directions of the edges along strike and up dip */
  PetscReal rounding;              /* of the triangle's coordinates [m] */
  PetscBool image_only;            /* of all sources of a call: only the effect of the free surface */
} SlipTriangle;

/* Edges for several points. For the images: horizontal direction along strike and to the right, and the components of
   the edge in that direction and down */
typedef struct {
  PetscReal x[3][SLIP_LANES], t[3][SLIP_LANES], length[3][SLIP_LANES], along[3][SLIP_LANES], up[3][SLIP_LANES];
  PetscReal hx[3][SLIP_LANES], hy[3][SLIP_LANES], flat[3][SLIP_LANES], steep[3][SLIP_LANES];
  PetscReal ty[SLIP_LANES], tz[SLIP_LANES]; /* of the direction up dip of the image: to the right and down */
  PetscReal bx[SLIP_LANES], by[SLIP_LANES]; /* slip along strike and to the right */
} SlipTriangleEdges;

/* Points, each in the coordinates of its own triangle, from its middle */
typedef struct {
  PetscInt n; /* at most SLIP_LANES */
  PetscReal x[SLIP_LANES], t[SLIP_LANES], q[SLIP_LANES];
  PetscReal rounding[SLIP_LANES]; /* of the coordinates: a point is on an edge or the plane if it is closer [m] */
  PetscReal move[SLIP_LANES];     /* added to t, less than rounding */
} SlipTrianglePoints;

/* ---- triangle.c: 4 pi times the displacement [n][3] or its gradient [n][9] along strike, to the right and down, of
   points with x and y (as t) from the middle of their triangles and the depth (as q); of [slips][n]: the triangles with
   each of the slips, which alone differ; out [slips] ---- */
PETSC_INTERN void SlipTriangleFields_Private(PetscInt slips, const SlipTriangle *const *const of[],
                                             SlipTrianglePoints *ground, PetscBool gradient, PetscReal *const out[]);
PETSC_INTERN void SlipTriangleOf_Private(PetscReal nu, PetscBool full_space, const PetscReal vertices[9],
                                         const PetscReal normal[3], SlipTriangle *triangle);
PETSC_INTERN void SlipTriangleSetSlip_Private(SlipTriangle *triangle, const PetscReal b[3]);
PETSC_INTERN void SlipTrianglePointOf_Private(const SlipTriangle *triangle, const PetscReal at[3], PetscInt k,
                                              SlipTrianglePoints *p);
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
PETSC_EXTERN void SlipTriangleTractions(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips,
                                        const SlipTriangleCell *receiver, const SlipTriangleCell *source,
                                        PetscReal traction[]);

/* ---- triangle_loops.c: a triangle as a closed loop around its normal; slips are those of the normal's side, north,
   east and down ---- */
typedef struct {
  PetscReal vertices[9]; /* [m] */
  PetscReal area, least; /* area, and smallest height [m] */
  PetscReal normal[3];   /* of a mirror image, whose jump is that of the triangle itself, the triangle's normal */
  PetscBool full_space;  /* there is no free surface */
} SlipTriangleLoop;
PETSC_EXTERN void SlipTriangleLoops(PetscReal nu, const SlipTriangleLoop *A, PetscInt na, const PetscReal a[][3],
                                    const SlipTriangleLoop *B, PetscInt nb, const PetscReal b[][3], PetscReal core,
                                    PetscReal force[]);
PETSC_EXTERN PetscReal SlipTriangleLoopEdge(PetscReal nu, const SlipTriangleLoop *loop, const PetscReal a[3],
                                            const PetscReal b[3], PetscInt edge, PetscReal share, PetscReal ratio);
/* ---- triangle_average.c ---- */
PETSC_EXTERN void SlipTriangleAverage(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips,
                                      const SlipTriangleCell *receiver, const SlipTriangleCell *source, PetscReal core,
                                      PetscReal average[]);
PETSC_EXTERN void SlipTriangleAverageEdge(PetscReal G, PetscReal nu, PetscInt slips, const SlipTriangleCell *cell,
                                          PetscInt k, PetscReal share, PetscReal ratio, PetscReal edge[]);

static inline PetscReal SlipDot(const PetscReal a[3], const PetscReal b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void SlipCross(const PetscReal a[3], const PetscReal b[3], PetscReal c[3])
{
  for (int i = 0; i < 3; i++) c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static inline void SlipUnit(PetscReal v[3])
{
  const PetscReal size = PetscSqrtReal(SlipDot(v, v));

  for (int i = 0; i < 3; i++) v[i] /= size;
}

/* The normal around which the vertices are ordered, with the length of twice the area, from the two shorter sides;
   returns the longest side's square */
static inline PetscReal SlipTriangleNormal(const PetscReal vertices[9], PetscReal normal[3])
{
  PetscReal side[3][3], square[3];
  int longest = 0;

  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 3; i++) side[k][i] = vertices[3 * ((k + 1) % 3) + i] - vertices[3 * k + i];
    square[k] = SlipDot(side[k], side[k]);
    if (square[k] > square[longest]) longest = k;
  }
  SlipCross(side[(longest + 1) % 3], side[(longest + 2) % 3], normal);
  return square[longest];
}

/* An edge's distances from a point: along its outward normal, and along itself from its end; 0 within rounding */
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
