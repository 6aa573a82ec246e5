/* Private: what the fields of a dipping rectangle are put together from, sums over its corners for some points at once. */
#pragma once
#include <slipstep/private/slipelasticity.h>

/* So many points at once: what is kept of them fits into the first cache. */
#define SLIP_LANES 16
/* Vectors of four where the processor has them, by the loader's choice; without fused products, so with the same bits. What
   such a function calls in its loops must be within it. */
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
/* The distance from an edge that a point of the edge is taken to have, as a share of rounding: nothing beside any other length. */
#define SLIP_AT_EDGE 9.5367431640625e-07 /* 2^-20 */
/* What of a point's coordinates is rounding, as a share of the largest length. */
#define SLIP_ROUNDING 1.4210854715202004e-14 /* 2^-46, 64 units in the last place */

/* Derivatives of the potential V, the integral of 1/R over a rectangle, along its strike x, up its dip t and across it
   q; what is missing follows from d_xx + d_tt + d_qq = 0. Rows of third[] and fourth[]: so many t and q, the rest x. */
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

/* Points, each as its own rectangle sees it from its centre. */
typedef struct {
  PetscInt n; /* at most SLIP_LANES */
  PetscReal x[SLIP_LANES], t[SLIP_LANES], q[SLIP_LANES];
  PetscReal rounding[SLIP_LANES]; /* of the coordinates: what is less from an edge or the plane is on it [m] */
  PetscReal move[SLIP_LANES];     /* what is to be added to t at corners, less than rounding */
  PetscReal half_length[SLIP_LANES], half_width[SLIP_LANES]; /* of the rectangle [m] */
  PetscReal ty[SLIP_LANES], tz[SLIP_LANES];                  /* y and z of the direction t of the image */
  PetscReal lean[SLIP_LANES];                                /* ty / (1 + tz) */
} SlipPlatePoints;

/* From a corner: an edge's distance of rounding is 0. */
SLIP_WITHIN PetscReal SlipCorner(PetscReal centre, PetscReal half, PetscReal rounding)
{
  const PetscReal v = centre + half;

  return PetscAbsReal(v) <= rounding ? 0 : v;
}

/* A rectangle as its fields need it. Components of its own: along strike, up dip, and across it into the hanging wall; of
   its image the same, mirrored. */
typedef struct {
  PetscReal depth, length, width; /* of the centre; along strike and dip [m] */
  PetscReal slope[2];             /* y (to the right) and z of up dip, of the image: -cos(dip) and sin(dip) */
  PetscReal b[3];                 /* slip */
  PetscReal a, rest;              /* 1/(2 (1 - nu)) and 1 - 2 nu */
  PetscBool full_space;
} SlipDipping;

/* ---- dipping.c: 4 pi times the displacement [n][3] or its gradient [n][9] along strike, to the right and down, of points with
   x and y (as t) from the centre of their rectangles source[] and the depth (as q), the only numbers that are there yet; below
   the ground or on it. All rectangles are of one rock, with the ground or without. ---- */
PETSC_INTERN void SlipDippingFields_Private(const SlipDipping *const source[], SlipPlatePoints *points,
                                            PetscBool gradient, PetscReal out[]);
/* ---- dipping_potential.c ---- */
PETSC_INTERN void SlipPotential_Private(const SlipPlatePoints *points, PetscInt lowest, PetscInt highest,
                                        SlipPotential *v);
/* ---- dipping_surface.c ---- */
PETSC_INTERN void SlipLogPotential_Private(const SlipPlatePoints *points, PetscBool gradient, SlipLogPotential *l);

/* ---- dipping_points.c ---- */
PETSC_INTERN void SlipDippingTractions_Private(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt n,
                                               const SlipCell receiver[], const SlipCell source[],
                                               PetscReal traction[]);

/* From along strike and to the right to north and east; strike: cosine and sine */
static inline void SlipTurn(const PetscReal strike[2], PetscReal *along, PetscReal *right)
{
  const PetscReal s = *along, y = *right;

  *along = strike[0] * s - strike[1] * y;
  *right = strike[1] * s + strike[0] * y;
}
