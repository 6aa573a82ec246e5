/* Internal: parts of the dislocation that operators of a grid compute separately */
#pragma once
#include <slipstep/rooms/slipelasticity.h>

/* Edges touch if they differ by less than this fraction of the smaller cell's smaller side. */
#define SLIP_TOUCH 1e-6
/* A cell is on the ground if it is not deeper than this fraction of its height, or shorter side. With hardly any rock
   above it, its own stiffness is a hundredth of that of a deeper one (level squares of depth 0.01: 0.025 G/L instead of
   1.6). */
#define SLIP_GROUND 0.01

/* Sine and cosine of an angle in degrees, exact at multiples of 90. */
static inline void SlipDegrees(PetscReal angle, PetscReal *sine, PetscReal *cosine)
{
  const PetscReal turn = angle - 360 * PetscFloorReal(angle / 360 + 0.5), size = PetscAbsReal(turn); /* [0, 180] */
  const PetscReal s = PetscSinReal(PETSC_PI / 180 * (size > 90 ? 180 - size : size));

  *sine = turn < 0 ? -s : s;
  *cosine = PetscSinReal(PETSC_PI / 180 * (90 - size));
}

/* ---- triangle_points.c ---- */
PETSC_INTERN PetscBool SlipHangingWall(const PetscReal normal[3]);

/* ---- dislocation.c ---- */
PETSC_INTERN void SlipKernelSurface_Private(PetscReal G, PetscReal nu, PetscReal dx, PetscReal depth_sum, PetscReal a,
                                            PetscReal b, PetscReal part[3]);

/* ---- average.c; core: of edges inside, in units of cells ---- */
static inline PetscReal SlipAverageCore(SlipAverage average)
{
  return average == SLIP_AVERAGE_WHOLE ? SLIP_CORE_INNER : SLIP_CORE_CELL;
}
/* The border's core relative to that */
static inline PetscReal SlipAverageBorderRatio(SlipAverage average)
{
  return average == SLIP_AVERAGE_WHOLE ? SLIP_CORE_BORDER / SLIP_CORE_INNER : 1;
}
/* equal cells of a grid */
PETSC_INTERN void SlipAverageSurface_Private(PetscReal G, PetscReal nu, PetscReal core, PetscReal dx,
                                             PetscReal depth_sum, PetscReal a, PetscReal b, PetscReal part[2]);
PETSC_INTERN PetscReal SlipAverageEdge_Private(const SlipKernel *kernel, PetscBool along_strike, PetscReal normal,
                                               PetscReal share, PetscReal ratio);

/* ---- kernels of pairs of cells in lanes, whose arrays are [numbers][SLIP_PAIRS] for a cell in each lane ---- */
#define SLIP_PAIRS 8 /* lanes: two vectors of four numbers, or one of eight */
typedef struct {
  PetscInt numbers; /* of a cell, as a source and as a receiver */
  void (*cell)(const SlipKernel *kernel, const SlipCell *cell, PetscReal numbers[]);
  /* Blocks [rows][components][SLIP_PAIRS] of the shear components or, if normal, the row of normal stress. near is 1
     in lanes whose blocks are not valid, for which centre() is to be called, else 0. */
  void (*blocks)(const SlipKernel *kernel, PetscBool normal, const PetscReal receiver[], const PetscReal source[],
                 PetscReal block[], PetscReal near[]);
} SlipKernelLanes;
PETSC_EXTERN const SlipKernelLanes *SlipKernelGetLanes(const SlipKernel *kernel); /* NULL: none; kernel.c */

/* ---- queries of operators ---- */
PETSC_INTERN PetscErrorCode SlipKernelCheckComponents(MPI_Comm comm, const SlipKernel *kernel, PetscInt components);
static inline PetscBool SlipKernelIs(const SlipKernel *kernel, SlipKernelSymmetry symmetry)
{
  return (PetscBool)((kernel->type->symmetry[kernel->full_space ? 1 : 0] & (int)symmetry) != 0);
}
/* True if K = T(z - z') + A(z + z') - z z' q(z + z') on a grid, which transforms in depth need */
static inline PetscBool SlipKernelTransforms(const SlipKernel *kernel)
{
  return (PetscBool)(kernel->type->surface || SlipKernelIs(kernel, SLIP_EVEN_DEPTH));
}
/* T of one component: cells a x b of one plane without the free surface. */
static inline PetscReal SlipKernelDirect(const SlipKernel *kernel, PetscReal dx, PetscReal dz, PetscReal a, PetscReal b)
{
  const SlipCell receiver = {.rectangle = {dx, 0, dz, a, b, 0, 90}, .rake = 0},
                 source = {.rectangle = {0, 0, 0, a, b, 0, 90}, .rake = 0};
  SlipKernel full = *kernel;
  PetscReal block[SLIP_KERNEL_BLOCK];

  full.full_space = PETSC_TRUE;
  SlipKernelBlock(&full, &receiver, &source, block);
  return block[0];
}
