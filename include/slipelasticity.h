/* Elastic half-space: rectangular dislocations in closed form, as pure functions, and the kernels of operators. */
#pragma once
#include <petscsys.h>

/* Static shear-stress DROP at the centre of a receiver for unit uniform strike slip on a rectangular source cell of a
   vertical plane: entry K_ij > 0 on the diagonal [Pa/m]. Okada (1992); Chinnery (1963) for nu = 1/4. */
PETSC_EXTERN PetscReal SlipKernelFullSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dz, PetscReal a,
                                           PetscReal b);
PETSC_EXTERN PetscReal SlipKernelHalfSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal z_receiver,
                                           PetscReal z_source, PetscReal a, PetscReal b);
/* The same with the receiver on a parallel plane at the distance dy [m]. */
PETSC_EXTERN PetscReal SlipKernelOffset(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dy, PetscReal z_receiver,
                                        PetscReal z_source, PetscReal a, PetscReal b, PetscBool full_space);

/* A rectangle of a vertical plane: centre along strike, across and in depth, extents along strike and in depth [m]. */
typedef struct {
  PetscReal x, y, z, length, width;
} SlipRectangle;
/* Where the stress of slip on a cell is taken, and what cores edges have, in units of a cell's extent across them. */
typedef enum {
  SLIP_AVERAGE_CENTRE, /* the value at the centre */
  SLIP_AVERAGE_CELL,   /* the average over the cell; one core, for slip that is made to end at some edge */
  SLIP_AVERAGE_WHOLE   /* the same; a core inside and another at the border, for faults all of whose cells slide */
} SlipAverage;
/* The one at which cracks of 10 to 60 cells across have the exact slip in their middle, measured. */
#define SLIP_CORE_CELL 0.11
/* Inside: the one at which waves of slip meet the stiffness of the continuum to the second order of their wavenumber.
   At the border: the one at which a crack that ends there then slips as in the continuum, to the second order as
   well. */
#define SLIP_CORE_INNER 0.15915494309189535 /* 1 / (2 pi) */
#define SLIP_CORE_BORDER 0.0494428
/* Average of that drop over the receiver; core: of edges that both have in common. */
PETSC_EXTERN PetscReal SlipKernelAverage(PetscReal G, PetscReal nu, const SlipRectangle *receiver,
                                         const SlipRectangle *source, const PetscReal core[2], PetscBool full_space);

/* A rectangle of any direction: centre north, east and down, extents along strike and along dip [m], strike and dip
   after Aki & Richards [deg]; a row of cells in files. */
typedef struct {
  PetscReal x, y, z, length, width, strike, dip;
} SlipDippingRectangle;
/* One that slips along its rake [deg], along which its shear stress counts too; or a triangle that does. */
typedef struct {
  SlipDippingRectangle rectangle; /* of a triangle: centroid, extent along strike, its area over that, strike and dip */
  PetscReal rake;
  const PetscReal *vertices; /* [3][3] of a triangle, each north, east and down [m]; NULL: it is a rectangle */
  const PetscReal
    *directions; /* [3][3] of a triangle along its rake, across it and normal, as SlipPlaneDirections() has
                                  them; NULL: of strike, dip and rake */
} SlipCell;

/* Between cells of one size on one plane a kernel depends on their distance only, and not on its sign: */
typedef enum {
  SLIP_EVEN_STRIKE = 1, /* along strike, as a uniform grid needs */
  SLIP_EVEN_DEPTH = 2   /* in depth */
} SlipKernelSymmetry;
/* A kind of kernel: a row of functions, below. */
typedef struct _SlipKernelType SlipKernelType;
/* What the entries of a stiffness are computed from: a kind of kernel and its parameters. */
typedef struct {
  const SlipKernelType *type;
  PetscReal shear_modulus; /* G [Pa] */
  PetscReal poisson_ratio; /* nu, in (-1, 0.5) */
  PetscBool full_space;    /* leave out the free surface */
  SlipAverage average;     /* of the stress drop over the receiving cell, or its value at the centre */
  const void *ctx;         /* what else the type's functions need; borrowed */
} SlipKernel;
/* A block is [components + normals][components], row-major [Pa/m]: stress drop on the receiver, its
   shear components before its normal stress, positive where slip compresses, for unit slip on the source. */
#define SLIP_KERNEL_BLOCK 12 /* the most numbers of one: three components of slip, and a row of normal stress */
struct _SlipKernelType {
  const char *name;
  PetscInt components;  /* of slip and stress drop: 1 along the rake, 2 along strike and up dip, 3 with opening */
  PetscInt normals;     /* rows of normal stress besides: 0, or 1 where it changes by slip */
  PetscInt symmetry[2]; /* SlipKernelSymmetry, added: below the free surface, in a full space */
  /* at the receiver's centre */
  void (*centre)(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source, PetscReal block[]);
  /* averaged over the receiver: symmetric times the receiver's area; NULL: refused */
  void (*average)(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source, PetscReal block[]);
  /* The free surface's share of K's symmetric part for cells a x b of one plane at the depths z and z', dx apart along
     strike: part[0] - z z' part[1], functions of dx and of z + z'. Products by transforms in depth need it; NULL: a
     grid below a free surface takes a block per wavenumber. */
  void (*surface)(const SlipKernel *kernel, PetscReal dx, PetscReal depth_sum, PetscReal a, PetscReal b,
                  PetscReal part[2]);
  /* What one edge of a cell adds to the cell's average on itself, where the edge's core is ratio times the one that
     average() took, along share of the edge; normal: the cell's extent across the edge [m]. NULL: nothing. */
  PetscReal (*edge)(const SlipKernel *kernel, PetscBool along_strike, PetscReal normal, PetscReal share,
                    PetscReal ratio);
  /* At points [n][3] of the plane of the source, its own centre and those of cells like it: stress drop along strike,
     up dip and across, [n][3], for unit slip along strike (component 0), up dip (1) or opening (2). With the distance
     along strike, what dip and dip or strike and strike have to do with each other is even, as is what slip up dip does
     across; the rest is odd. Products by transforms on dipping planes need it; NULL: refused. */
  PetscErrorCode (*plane)(const SlipKernel *kernel, const SlipDippingRectangle *source, PetscInt component, PetscInt n,
                          const PetscReal points[], PetscReal traction[]);
  /* centre() of n pairs, where many at once take less time than one by one; NULL: they do not */
  void (*centres)(const SlipKernel *kernel, PetscInt n, const SlipCell receiver[], const SlipCell source[],
                  PetscReal block[]);
  /* As edge(), of triangles: of the side from vertex k to the next one, [components][components]. NULL: nothing. */
  void (*side)(const SlipKernel *kernel, const SlipCell *cell, PetscInt k, PetscReal share, PetscReal ratio,
               PetscReal block[]);
};
/* Slip along strike on rectangles of parallel vertical planes, by the functions above. */
PETSC_EXTERN const SlipKernelType SlipKernelStrikeSlip;
/* Slip along their rakes on rectangles of any strike and dip: shear along the receiver's rake, and normal stress. */
PETSC_EXTERN const SlipKernelType SlipKernelDipping;
/* The same on triangles. */
PETSC_EXTERN const SlipKernelType SlipKernelTriangle;
/* Slip as a vector along strike and up dip on either, whatever their rakes: shear stress along both, and normal
   stress. */
PETSC_EXTERN const SlipKernelType SlipKernelDippingVector;
PETSC_EXTERN const SlipKernelType SlipKernelTriangleVector;
/* The same with opening as a third component, positive where the sides part: the third stress is the compression, as
   its own unit opening makes it, and there are no other rows of normal stress. */
PETSC_EXTERN const SlipKernelType SlipKernelDippingOpening;
PETSC_EXTERN const SlipKernelType SlipKernelTriangleOpening;
PETSC_EXTERN PetscErrorCode SlipKernelCheck(MPI_Comm comm, const SlipKernel *kernel);
/* The block [Pa/m] of a kernel that SlipKernelCheck() accepts. */
static inline void SlipKernelBlock(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source,
                                   PetscReal block[])
{
  (*(kernel->average ? kernel->type->average : kernel->type->centre))(kernel, receiver, source, block);
}

/* Displacement [n][3] of points [n][2] of the free surface for unit strike slip. Okada (1985). */
PETSC_EXTERN void SlipSurfaceDisplacement(PetscReal nu, const SlipRectangle *source, PetscInt n,
                                          const PetscReal points[], PetscReal u[]);

/* Fields at points [n][3] of slip [3] on it, along strike, up dip and opening, with a free surface or without. Okada
   (1992). */
PETSC_EXTERN PetscErrorCode SlipDippingDisplacement(PetscReal nu, PetscBool full_space,
                                                    const SlipDippingRectangle *source, const PetscReal slip[],
                                                    PetscInt n, const PetscReal points[], PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipDippingGradient(PetscReal nu, PetscBool full_space, const SlipDippingRectangle *source,
                                                const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                PetscReal gradient[]);
PETSC_EXTERN PetscErrorCode SlipDippingStress(PetscReal G, PetscReal nu, PetscBool full_space,
                                              const SlipDippingRectangle *source, const PetscReal slip[], PetscInt n,
                                              const PetscReal points[], PetscReal stress[]);
/* The same of many, slip [ncells][3], and stress [n][6]. */
PETSC_EXTERN PetscErrorCode SlipRectanglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                       const SlipDippingRectangle cells[], const PetscReal slip[],
                                                       PetscInt n, const PetscReal points[], PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipRectanglesStress(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                 const SlipDippingRectangle cells[], const PetscReal slip[], PetscInt n,
                                                 const PetscReal points[], PetscReal stress[]);
/* The same of a triangle with the vertices [3][3], slip [3] along its strike, up its dip and opening. */
PETSC_EXTERN PetscErrorCode SlipTriangleDisplacement(PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                                     const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                     PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipTriangleGradient(PetscReal nu, PetscBool full_space, const PetscReal vertices[],
                                                 const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                 PetscReal gradient[]);
PETSC_EXTERN PetscErrorCode SlipTriangleStress(PetscReal G, PetscReal nu, PetscBool full_space,
                                               const PetscReal vertices[], const PetscReal slip[], PetscInt n,
                                               const PetscReal points[], PetscReal stress[]);
PETSC_EXTERN PetscErrorCode SlipTriangleDirections(const PetscReal vertices[], const PetscReal side[],
                                                   PetscReal angles[], PetscReal directions[]);
/* The same of many, vertices [ncells][3][3], slip [ncells][3], with hanging walls at the sides [ncells][3] or NULL. */
PETSC_EXTERN PetscErrorCode SlipTrianglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                      const PetscReal vertices[], const PetscReal side[],
                                                      const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                      PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipTrianglesStress(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                const PetscReal vertices[], const PetscReal side[],
                                                const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                PetscReal stress[]);
/* Tractions [n][3], along the rake, across it and normal, on planes with directions [n][3][3]. */
PETSC_EXTERN void SlipPlaneDirections(PetscReal strike, PetscReal dip, PetscReal rake, PetscReal directions[]);
PETSC_EXTERN void SlipStressTraction(PetscInt n, const PetscReal stress[], const PetscReal directions[],
                                     PetscReal traction[]);
