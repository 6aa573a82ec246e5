/* What cells offers to the other rooms and to the trainer, and not to users */
#pragma once
#include <slipcells.h>
#include <slipstep/rooms/slipelasticity.h>
#include <slipstep/rooms/slipsys.h>

/* Raises an error if cells are not finite, have no extent, reach above the surface, overlap or cross. Messages name
   source and count rows from 0. */
PETSC_EXTERN PetscErrorCode SlipCellsCheck(MPI_Comm comm, const SlipCells *cells, const char source[]);
/* Partitions a mesh into compact parts of equal cost: computes order [n], an array of shared, or if that is NULL one to
   free by PetscFree(), and nlocal, see above, for a stiffness of this type. */
PETSC_EXTERN PetscErrorCode SlipCellsPartition(MPI_Comm comm, const SlipCells *cells, const char *type,
                                               SlipShared shared, PetscInt **order, PetscInt *nlocal);
/* What one of several processes will have of a stiffness */
typedef struct {
  PetscReal cells, blocks; /* its cells, and its blocks */
  PetscReal bytes;         /* of the entries [B] */
  PetscReal pairs;         /* pairs of cells that are computed at assembly */
  PetscReal flops;         /* of a product */
  PetscReal touched;       /* numbers of x and of y that its blocks touch, */
  PetscReal foreign;       /* and those of them that it receives and sends */
  PetscReal machine;       /* what the processes of a machine hold together while they assemble [B] */
  PetscReal seconds;       /* processor time of assembly, by entries measured on this processor [s] */
} SlipCellsForecast;
/* Predicts K, and if normal then Kn, on size processes; forecast [1 or 2][size]. */
PETSC_EXTERN PetscErrorCode SlipCellsForecasts(const SlipCells *cells, const char type[], PetscReal tolerance,
                                               PetscBool normal, PetscMPIInt size, SlipCellsForecast forecast[]);
/* Gets the weights A_i / mean(A) of the rows of such a stiffness, borrowed, or NULL if all are 1. */
PETSC_EXTERN PetscErrorCode MatSlipGetWeights(Mat S, Vec *weights);
/* Sets the relative tolerance of products with a viscosity by Lanczos' method; other types ignore it. */
PETSC_EXTERN PetscErrorCode MatSlipViscosityAllow(Mat H, PetscReal tolerance);
PETSC_EXTERN PetscErrorCode MatSlipViscositySetTolerance(Mat H, PetscReal tolerance);
PETSC_EXTERN PetscErrorCode MatSlipViscositySetFromOptions(Mat H);
