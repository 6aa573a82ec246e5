/* Internal: the fields of a dipping rectangle or triangle as sums over its corners, for several points at once */
#pragma once
#include <slipstep/private/slipelasticity.h>

/* Number of points at once: their data fit into the first cache. */
#define SLIP_LANES 16
/* The loader selects a version with vectors of four where the processor has them; no version uses fused products, so
   that all give the same bits. The loops' functions must be inlined, SLIP_WITHIN. */
#if defined(__GNUC__)
  #define SLIP_WITHIN static inline __attribute__((always_inline))
#else
  #define SLIP_WITHIN static inline
#endif
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) &&                       \
  !defined(__SANITIZE_ADDRESS__)
  #define SLIP_WIDE __attribute__((target_clones("avx2", "default")))
#else
  #define SLIP_WIDE
#endif
/* The distance from an edge of a point on it, relative to rounding: negligible beside any other length */
#define SLIP_AT_EDGE 9.5367431640625e-07 /* 2^-20 */
/* Rounding of a point's coordinates, relative to the largest length */
#define SLIP_ROUNDING 1.4210854715202004e-14 /* 2^-46, 64 units in the last place */

/* Derivatives of the potential V, the integral of 1/R over a plane area, along its strike x, up its dip t and across it
   q; all others follow from d_xx + d_tt + d_qq = 0. Rows of third[] and fourth[] are named by t, q and the rest, x. */
typedef struct {
  PetscReal first[3][SLIP_LANES];  /* x t q */
  PetscReal second[5][SLIP_LANES]; /* xx xt xq tt tq */
  PetscReal third[7][SLIP_LANES];  /* xxx xxt xxq xtt xtq ttt ttq */
  PetscReal fourth[9][SLIP_LANES]; /* xxxx xxxt xxxq xxtt xxtq xttt xttq tttt tttq */
} SlipPotential;

/* Derivatives of X_xx and X_xy, X the integral of w ln(R + w) - R, along x, to the right y and down z. */
typedef struct {
  PetscReal along[3][SLIP_LANES], across[3][SLIP_LANES];               /* of X_xx and X_xy: x y z */
  PetscReal along_second[6][SLIP_LANES], across_second[6][SLIP_LANES]; /* xx yy zz xy xz yz */
} SlipLogPotential;

/* Points, each in the coordinates of its own rectangle, from its centre */
typedef struct {
  PetscInt n; /* at most SLIP_LANES */
  PetscReal x[SLIP_LANES], t[SLIP_LANES], q[SLIP_LANES];
  PetscReal rounding[SLIP_LANES]; /* of the coordinates: a point is on an edge or the plane if it is closer [m] */
  PetscReal move[SLIP_LANES];     /* added to t at corners, less than rounding */
  PetscReal half_length[SLIP_LANES], half_width[SLIP_LANES]; /* of the rectangle [m] */
  PetscReal ty[SLIP_LANES], tz[SLIP_LANES];                  /* y and z of the direction t of the image */
  PetscReal lean[SLIP_LANES];                                /* ty / (1 + tz) */
} SlipPlatePoints;

/* Distance from a corner; one within rounding is 0. */
SLIP_WITHIN PetscReal SlipCorner(PetscReal centre, PetscReal half, PetscReal rounding)
{
  const PetscReal v = centre + half;

  return PetscAbsReal(v) <= rounding ? 0 : v;
}

/* Compute the derivative along e of a tensor of derivatives of V of the second, third and fourth order, rows as in
   SlipPotential. */
SLIP_WITHIN void SlipAlong2(const PetscReal v[5], const PetscReal e[3], PetscReal d[3])
{
  d[0] = e[0] * v[0] + e[1] * v[1] + e[2] * v[2];
  d[1] = e[0] * v[1] + e[1] * v[3] + e[2] * v[4];
  d[2] = e[0] * v[2] + e[1] * v[4] - e[2] * (v[0] + v[3]);
}

SLIP_WITHIN void SlipAlong3(const PetscReal v[7], const PetscReal e[3], PetscReal d[5])
{
  d[0] = e[0] * v[0] + e[1] * v[1] + e[2] * v[2];
  d[1] = e[0] * v[1] + e[1] * v[3] + e[2] * v[4];
  d[2] = e[0] * v[2] + e[1] * v[4] - e[2] * (v[0] + v[3]);
  d[3] = e[0] * v[3] + e[1] * v[5] + e[2] * v[6];
  d[4] = e[0] * v[4] + e[1] * v[6] - e[2] * (v[1] + v[5]);
}

SLIP_WITHIN void SlipAlong4(const PetscReal v[9], const PetscReal e[3], PetscReal d[7])
{
  d[0] = e[0] * v[0] + e[1] * v[1] + e[2] * v[2];
  d[1] = e[0] * v[1] + e[1] * v[3] + e[2] * v[4];
  d[2] = e[0] * v[2] + e[1] * v[4] - e[2] * (v[0] + v[3]);
  d[3] = e[0] * v[3] + e[1] * v[5] + e[2] * v[6];
  d[4] = e[0] * v[4] + e[1] * v[6] - e[2] * (v[1] + v[5]);
  d[5] = e[0] * v[5] + e[1] * v[7] + e[2] * v[8];
  d[6] = e[0] * v[6] + e[1] * v[8] - e[2] * (v[3] + v[7]);
}

/* Rotates v from the image's directions to x, y, z, and from those of the rectangle to the mirrored ones. */
SLIP_WITHIN void SlipTurnSlope(const PetscReal slope[2], PetscReal v[3])
{
  const PetscReal t = v[1], q = v[2];

  v[1] = slope[0] * t + slope[1] * q;
  v[2] = slope[1] * t - slope[0] * q;
}

/* A line that contains an edge: s = +-1 is the side of its middle, r2 the squared distance from it */
typedef struct {
  PetscReal sum, Y, Z, W; /* R + s t; the others are defined in dipping_potential.c */
} SlipLine;

SLIP_WITHIN SlipLine SlipLineOf(PetscReal t, PetscReal s, PetscReal r2, PetscReal R, PetscReal inverse)
{
  const PetscReal along = s * t, far = R + PetscAbsReal(t), sum = along >= 0 ? far : r2 / far;
  const PetscReal a = 1 / sum, i2 = inverse * inverse;
  SlipLine line;

  line.sum = sum;
  line.Y = s * inverse * a;
  line.Z = -s * (R + sum) * inverse * i2 * a * a;
  line.W = s * (3 * sum * (sum + R) + 2 * R * R) * inverse * i2 * i2 * a * a * a;
  return line;
}

/* A corner of the image of an edge along t, in the vertical plane of y and w: dipping_surface.c */
typedef struct {
  PetscReal x, y, t, q, w, R;
  PetscReal Rw, Rt; /* R + w, R + t */
  PetscReal i;      /* 1/R, 0 at a corner itself, which omits infinite terms */
} SlipLogCorner;

SLIP_WITHIN SlipLogCorner SlipLogCornerOf(PetscReal x, PetscReal t, PetscReal q, PetscReal ty, PetscReal tz,
                                          PetscReal rounding)
{
  const PetscReal edge = SLIP_AT_EDGE * rounding, least = edge * edge;
  SlipLogCorner c;
  PetscReal r2, R2;

  c.x = x;
  c.t = t;
  c.q = q;
  c.y = c.t * ty + c.q * tz;
  c.w = c.t * tz - c.q * ty;
  r2 = c.x * c.x + c.q * c.q;
  R2 = r2 + c.t * c.t;
  c.R = PetscSqrtReal(R2 > least ? R2 : least);
  c.i = R2 > least ? 1 / c.R : 0;
  c.w = c.w > 0 ? c.w : 0;
  c.Rw = c.R + c.w;
  c.Rt = c.t >= 0 ? c.R + c.t : (r2 > least ? r2 : least) / (c.R - c.t);
  return c;
}

/* Derivatives at a corner of the integrals of chi_x and chi_y along t; x y w, or xx yy ww xy xw yw */
typedef struct {
  PetscReal K[6], N[6];
} SlipLogSums;

SLIP_WITHIN SlipLogSums SlipLogSecond(const SlipLogCorner *c, PetscReal ty, PetscReal tz, PetscReal s)
{
  const PetscReal up = 1 + tz, D = c->i / c->Rw, Y = c->i / c->Rt, E = D * (c->y + s * c->R) / c->Rt;
  const PetscReal B = (c->y * E - tz * c->R * c->i / (up * c->Rt)) / c->Rw;
  const PetscReal zz = ty * c->i + tz * c->q * Y, yz = c->t * D - tz * c->i + tz * c->q * E;
  const PetscReal yy = c->y * B - D * (ty * c->R + tz * c->y) + tz * c->t * E;

  return (SlipLogSums){{-c->x * (B + Y), c->x * B, c->x * Y, -(yy + zz), -(yz + tz * c->i - ty * c->q * Y), c->x * E},
                       {-(yy + zz), yy, zz, c->x * B, c->x * E, yz}};
}

/* A plane source. Its own components are along strike, up dip, and across it into the hanging wall; those of its image
   are mirrored. */
typedef struct {
  PetscReal depth, length, width; /* of the centre; of a rectangle, along strike and dip [m] */
  PetscReal slope[2];             /* y (to the right) and z of up dip, of the image: -cos(dip) and sin(dip) */
  PetscReal b[3];                 /* slip */
  PetscReal a, rest;              /* 1/(2 (1 - nu)) and 1 - 2 nu */
  PetscBool full_space;
} SlipDipping;

/* ---- dipping.c: what a potential adds to 4 pi times the displacement [n][3] or its gradient [n][9] along strike, to
   the right and down: of the sources, which comes first, or of their images, with the part of X along strike, to the
   right and down (xx yy zz xy xz yz) where there is one; q: of the points from the sources or images, z: their depths
   ---- */
PETSC_INTERN void SlipDippingAdd_Private(const SlipDipping *const source[], PetscInt n, const PetscReal q[],
                                         const PetscReal z[], const SlipPotential *v,
                                         const PetscReal (*rest)[SLIP_LANES], PetscBool image, PetscBool gradient,
                                         PetscReal out[]);
/* 4 pi times the displacement [n][3] or its gradient [n][9] along strike, to the right and down, of points below the
   ground or on it with x and y (as t) from the centre of their rectangles and the depth (as q), the only numbers that
   are set yet. All rectangles are in one rock, with or without a free surface. of [slips][n]: the rectangles with each
   of the slips, which differ in nothing else; out [slips] ---- */
PETSC_INTERN void SlipDippingFields_Private(PetscInt slips, const SlipDipping *const *const of[],
                                            SlipPlatePoints *points, PetscBool gradient, PetscReal *const out[]);
/* ---- dipping_potential.c ---- */
PETSC_INTERN void SlipPotential_Private(const SlipPlatePoints *points, PetscInt lowest, PetscInt highest,
                                        SlipPotential *v);
/* ---- dipping_surface.c ---- */
PETSC_INTERN void SlipLogPotential_Private(const SlipPlatePoints *points, PetscBool gradient, SlipLogPotential *l);
PETSC_INTERN SlipLogSums SlipLogFirst_Private(const SlipLogCorner *corner, PetscReal ty, PetscReal tz, PetscReal lean);

/* ---- dipping_points.c: by slip along the source's rake, or by 2 or 3 slips along its strike, up its dip and across it
   ---- */
PETSC_INTERN void SlipDippingTractions_Private(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips,
                                               PetscInt n, const SlipCell receiver[], const SlipCell source[],
                                               PetscReal traction[]);

/* G times the stress of a gradient [3][3]: xx yy zz xy xz yz */
static inline void SlipStressOf(PetscReal G, PetscReal nu, const PetscReal g[9], PetscReal s[6])
{
  const PetscReal volume = 2 * nu / (1 - 2 * nu) * (g[0] + g[4] + g[8]);

  for (int i = 0; i < 3; i++) s[i] = G * (2 * g[4 * i] + volume);
  s[3] = G * (g[1] + g[3]);
  s[4] = G * (g[2] + g[6]);
  s[5] = G * (g[5] + g[7]);
}

/* Turns a vector along strike and to the right into north and east; strike: cosine and sine */
static inline void SlipTurn(const PetscReal strike[2], PetscReal *along, PetscReal *right)
{
  const PetscReal s = *along, y = *right;

  *along = strike[0] * s - strike[1] * y;
  *right = strike[1] * s + strike[0] * y;
}

/* Converts 4 pi times the displacement or its gradient along strike and to the right */
static inline void SlipTurnOut(const PetscReal strike[2], PetscBool gradient, PetscReal v[])
{
  const PetscInt size = gradient ? 9 : 3;

  if (gradient)
    for (int i = 0; i < 3; i++) SlipTurn(strike, v + 3 * i, v + 3 * i + 1);
  for (int j = 0; j < size / 3; j++) SlipTurn(strike, v + j, v + (gradient ? 3 : 1) + j);
  for (int i = 0; i < size; i++) v[i] /= 4 * PETSC_PI;
}
