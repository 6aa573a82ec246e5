/* Internal: tractions of many pairs of triangles at once, from numbers of each triangle that are computed once */
#pragma once
#include <slipstep/private/sliptriangle.h>

/* The loader selects the version of the processor. Those with vectors use fused products. */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__) &&     \
  !defined(__SANITIZE_ADDRESS__)
  #define SLIP_FUSED __attribute__((target_clones("avx512f", "arch=x86-64-v3", "default")))
#else
  #define SLIP_FUSED
#endif

/* The numbers of a triangle, for one lane in SlipTriangleData and for all in SlipTriangleLanes: both have the same
   members in the same order, and nothing else than PetscReal, so that number i is row i of the lanes. Directions and
   coordinates are those of sliptriangle.h; slips, directions and edges come in threes. */
#define SLIP_TRIANGLE_NUMBERS(LANES)                                                                                   \
  /* as a source: middle [m], cosine and sine of the strike, y and z of up dip of the image, rounding [m] */           \
  PetscReal middle[3] LANES, strike[2] LANES, slope[2] LANES, rounding LANES;                                          \
  /* vertices from the middle and their depths, lengths and directions of edges */                                     \
  PetscReal x[3] LANES, t[3] LANES, depth[3] LANES, length[3] LANES, along[3] LANES, up[3] LANES;                      \
  /* second to fourth power of the edges' normals as complex numbers: real and imaginary parts */                      \
  PetscReal power[3][3][2] LANES;                                                                                      \
  /* edges of the image, as in SlipTriangleEdges */                                                                    \
  PetscReal hx[3] LANES, hy[3] LANES, flat[3] LANES, steep[3] LANES;                                                   \
  /* 1 if the edge is downward, else -1; the same, or 0 where it must not be turned */                                 \
  PetscReal down[3] LANES, turns[3] LANES;                                                                             \
  /* ty/(1 + tz) and tz/(1 + tz) of the directions downward and upward */                                              \
  PetscReal lean[3][2] LANES, share[3][2] LANES;                                                                       \
  /* slips along strike, up dip and across, and for edges those along and across them times -2 (1 - 2 nu) steep */     \
  PetscReal slip[3][3] LANES, edge_slip[3][3][2] LANES;                                                                \
  /* as a receiver: centroid and rounding [m], and directions of slip and of the normal, north, east and down */       \
  PetscReal centroid[3] LANES, reach LANES, direction[3][3] LANES;

typedef struct {
  SLIP_TRIANGLE_NUMBERS()
} SlipTriangleData;
typedef struct {
  SLIP_TRIANGLE_NUMBERS([SLIP_PAIRS])
} SlipTriangleLanes;

/* Derivatives of V at the receivers: rows of SlipPotential; and for each edge of the image sums over its ends of x B, x
   (B + Y), yy + zz and yy of dipping_surface.c */
typedef struct {
  PetscReal q[SLIP_PAIRS], second[5][SLIP_PAIRS], third[7][SLIP_PAIRS], fourth[9][SLIP_PAIRS];
  PetscReal log[3][4][SLIP_PAIRS];
} SlipTrianglePairs;

/* ---- triangle_edges.c: those of the sources, or of their images; near: 1 for receivers on an edge, which need the
   care of triangle_potential.c, else unchanged ---- */
PETSC_INTERN void SlipTriangleSourceEdges_Private(const SlipTriangleLanes *source, const SlipTriangleLanes *receiver,
                                                  PetscReal near[], SlipTrianglePairs *pairs);
PETSC_INTERN void SlipTriangleImageEdges_Private(const SlipTriangleLanes *source, const SlipTriangleLanes *receiver,
                                                 PetscReal near[], SlipTrianglePairs *pairs);
/* ---- triangle_lanes.c ---- */
PETSC_INTERN void SlipTriangleDataOf_Private(PetscReal nu, PetscBool full_space, PetscInt slips,
                                             const SlipTriangleCell *cell, SlipTriangleData *data);
PETSC_INTERN void SlipTriangleLanesTractions_Private(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt slips,
                                                     PetscInt first, PetscInt rows, const SlipTriangleLanes *receiver,
                                                     const SlipTriangleLanes *source, PetscReal traction[],
                                                     PetscReal near[]);
