/* The elastic half-space: rectangular dislocations in closed form, as pure functions, and the kernels of operators */
#pragma once
#include <petscsys.h>

/* Static shear-stress DROP at the centre of a receiver for unit uniform strike slip on a rectangular source cell of a
   vertical plane: the entry K_ij, positive on the diagonal [Pa/m]. Okada (1992); Chinnery (1963) for nu = 1/4. */
PETSC_EXTERN PetscReal SlipKernelFullSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dz, PetscReal a,
                                           PetscReal b);
PETSC_EXTERN PetscReal SlipKernelHalfSpace(PetscReal G, PetscReal nu, PetscReal dx, PetscReal z_receiver,
                                           PetscReal z_source, PetscReal a, PetscReal b);
/* The same with the receiver on a parallel plane at the distance dy [m] */
PETSC_EXTERN PetscReal SlipKernelOffset(PetscReal G, PetscReal nu, PetscReal dx, PetscReal dy, PetscReal z_receiver,
                                        PetscReal z_source, PetscReal a, PetscReal b, PetscBool full_space);

/* A rectangle of a vertical plane: centre along strike, across and in depth, extents along strike and in depth [m] */
typedef struct {
  PetscReal x, y, z, length, width;
} SlipRectangle;
/* Where the stress of slip on a cell is evaluated, and the cores of edges, in units of the cell's extent across them */
typedef enum {
  SLIP_AVERAGE_CENTRE, /* the value at the centre */
  SLIP_AVERAGE_CELL,   /* average over the cell, one core, for slip that an edge stops */
  SLIP_AVERAGE_WHOLE   /* likewise, with one core inside and another at the border, for faults on which all cells slide
                          */
} SlipAverage;
/* With this core, cracks of 10 to 60 cells have the exact slip in their middle; this was measured. */
#define SLIP_CORE_CELL 0.11
/* With the inner core, waves of slip have the stiffness of the continuum to the second order of their wavenumber. With
   the border core, a crack that ends at the border then slips as in the continuum, also to the second order. */
#define SLIP_CORE_INNER 0.15915494309189535 /* 1 / (2 pi) */
#define SLIP_CORE_BORDER 0.0494428
/* Average of that drop over the receiver; core: the cores of edges that both share */
PETSC_EXTERN PetscReal SlipKernelAverage(PetscReal G, PetscReal nu, const SlipRectangle *receiver,
                                         const SlipRectangle *source, const PetscReal core[2], PetscBool full_space);

/* A rectangle in any direction: centre north, east and down, extents along strike and dip [m], strike and dip after Aki
   & Richards [deg]; it is a row of cells in files. */
typedef struct {
  PetscReal x, y, z, length, width, strike, dip;
} SlipDippingRectangle;
/* A rectangle or triangle that slips along its rake [deg]; its shear stress is that along the rake, too. */
typedef struct {
  SlipDippingRectangle rectangle; /* of a triangle: centroid, extent along strike, area over that extent, strike, dip */
  PetscReal rake;
  const PetscReal *vertices; /* [3][3] of a triangle, each north, east and down [m]; NULL: rectangle */
  const PetscReal
    *directions; /* [3][3] of a triangle along its rake, across it and normal, as SlipPlaneDirections() has
                                  them; NULL: of strike, dip and rake */
} SlipCell;

/* On one plane with equal cells, a kernel depends only on the distance of two cells, and not on its sign: */
typedef enum {
  SLIP_EVEN_STRIKE = 1, /* along strike, as a uniform grid needs */
  SLIP_EVEN_DEPTH = 2   /* in depth */
} SlipKernelSymmetry;
/* A kind of kernel: a table of functions, below */
typedef struct _SlipKernelType SlipKernelType;
/* The data from which entries of a stiffness are computed: a kind of kernel and its parameters */
typedef struct {
  const SlipKernelType *type;
  PetscReal shear_modulus; /* G [Pa] */
  PetscReal poisson_ratio; /* nu, in (-1, 0.5) */
  PetscBool full_space;    /* omit the free surface */
  SlipAverage average;     /* of the stress drop over the receiving cell, or its value at the centre */
  const void *ctx;         /* further data of the type's functions; borrowed */
} SlipKernel;
/* A block is [components + normals][components], row-major [Pa/m]: the stress drop on the receiver for unit slip on the
   source, first its shear components, then its normal stress, which is positive if slip compresses. */
#define SLIP_KERNEL_BLOCK 12 /* the longest block: three components of slip and a row of normal stress */
struct _SlipKernelType {
  const char *name;
  PetscInt components;  /* of slip and stress drop: 1 along the rake, 2 along strike and up dip, 3 with opening */
  PetscInt normals;     /* additional rows of normal stress: 0, or 1 if slip changes it */
  PetscInt symmetry[2]; /* sums of SlipKernelSymmetry: below the free surface, in a full space */
  /* at the receiver's centre */
  void (*centre)(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source, PetscReal block[]);
  /* averaged over the receiver: symmetric after multiplication with its area; NULL: not supported */
  void (*average)(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source, PetscReal block[]);
  /* Part of the free surface in the symmetric part of K, for cells a x b of one plane at the depths z and z', dx apart
     along strike: part[0] - z z' part[1], which are functions of dx and of z + z'. Products by transforms in depth need
     it; NULL: a grid below a free surface stores a block per wavenumber. */
  void (*surface)(const SlipKernel *kernel, PetscReal dx, PetscReal depth_sum, PetscReal a, PetscReal b,
                  PetscReal part[2]);
  /* Contribution of one edge of a cell to the cell's average on itself, if the core of the edge is ratio times the one
     that average() used, along the fraction `share` of the edge; normal: the cell's extent across the edge [m]. NULL: 0
     */
  PetscReal (*edge)(const SlipKernel *kernel, PetscBool along_strike, PetscReal normal, PetscReal share,
                    PetscReal ratio);
  /* Stress drop along strike, up dip and across [n][3] at points [n][3] of the plane of the source (its own centre and
     those of equal cells), for unit slip along strike (component 0), up dip (1) or opening (2). As functions of the
     distance along strike, the pairs dip and dip, strike and strike, and slip up dip with the stress across are even;
     all others are odd. A kernel that is SLIP_EVEN_DEPTH depends on the distance in depth only, in which the same pairs
     are even and odd. Products by transforms on dipping planes need plane(); NULL: not supported. */
  PetscErrorCode (*plane)(const SlipKernel *kernel, const SlipDippingRectangle *source, PetscInt component, PetscInt n,
                          const PetscReal points[], PetscReal traction[]);
  /* centre() of n pairs, if computing many at once is faster; NULL: it is not */
  void (*centres)(const SlipKernel *kernel, PetscInt n, const SlipCell receiver[], const SlipCell source[],
                  PetscReal block[]);
  /* Like edge(), for triangles: the side from vertex k to the next one, [components][components]. NULL: 0 */
  void (*side)(const SlipKernel *kernel, const SlipCell *cell, PetscInt k, PetscReal share, PetscReal ratio,
               PetscReal block[]);
};
/* Slip along strike on rectangles of parallel vertical planes, by the functions above */
PETSC_EXTERN const SlipKernelType SlipKernelStrikeSlip;
/* The same where the image of the slip, mirrored at the surface, in a full space stands for the free surface: no shear
   stress acts on it, but normal stress, which vanishes in truth. It is exact where slip does not vary along strike. */
PETSC_EXTERN const SlipKernelType SlipKernelMirror;
/* Slip along rakes on rectangles of any strike and dip: shear stress along the receiver's rake, and normal stress */
PETSC_EXTERN const SlipKernelType SlipKernelDipping;
/* The same on triangles */
PETSC_EXTERN const SlipKernelType SlipKernelTriangle;
/* Slip as a vector along strike and up dip on rectangles or triangles, without rakes: shear stress along both
   directions, and normal stress */
PETSC_EXTERN const SlipKernelType SlipKernelDippingVector;
PETSC_EXTERN const SlipKernelType SlipKernelTriangleVector;
/* The same with opening as the third component, positive if the sides separate: the third stress is the compression by
   unit opening, and there are no other rows of normal stress. */
PETSC_EXTERN const SlipKernelType SlipKernelDippingOpening;
PETSC_EXTERN const SlipKernelType SlipKernelTriangleOpening;
/* Computes the block [Pa/m] of a kernel that SlipKernelCheck() accepts. */
static inline void SlipKernelBlock(const SlipKernel *kernel, const SlipCell *receiver, const SlipCell *source,
                                   PetscReal block[])
{
  (*(kernel->average ? kernel->type->average : kernel->type->centre))(kernel, receiver, source, block);
}

/* Displacement [n][3] at points [n][2] of the free surface for unit strike slip. Okada (1985). */
PETSC_EXTERN void SlipSurfaceDisplacement(PetscReal nu, const SlipRectangle *source, PetscInt n,
                                          const PetscReal points[], PetscReal u[]);

/* The same for many rectangles with slip [ncells][3]; stress [n][6] */
PETSC_EXTERN PetscErrorCode SlipRectanglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                       const SlipDippingRectangle cells[], const PetscReal slip[],
                                                       PetscInt n, const PetscReal points[], PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipRectanglesStress(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                 const SlipDippingRectangle cells[], const PetscReal slip[], PetscInt n,
                                                 const PetscReal points[], PetscReal stress[]);
/* The same for many triangles: vertices [ncells][3][3], slip [ncells][3], hanging walls at sides [ncells][3] or NULL */
PETSC_EXTERN PetscErrorCode SlipTrianglesDisplacement(PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                      const PetscReal vertices[], const PetscReal side[],
                                                      const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                      PetscReal u[]);
PETSC_EXTERN PetscErrorCode SlipTrianglesStress(PetscReal G, PetscReal nu, PetscBool full_space, PetscInt ncells,
                                                const PetscReal vertices[], const PetscReal side[],
                                                const PetscReal slip[], PetscInt n, const PetscReal points[],
                                                PetscReal stress[]);
/* Tractions [n][3] along the rake, across it and normal, on planes with the directions [n][3][3] */
PETSC_EXTERN void SlipPlaneDirections(PetscReal strike, PetscReal dip, PetscReal rake, PetscReal directions[]);
PETSC_EXTERN void SlipStressTraction(PetscInt n, const PetscReal stress[], const PetscReal directions[],
                                     PetscReal traction[]);
