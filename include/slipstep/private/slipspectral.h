/* Private to src/mat: the viscosity "slipspectral", whose Mat is in viscosity_spectral.c and whose low-rank part, where
   it has one, is set up by viscosity_exact.c. */
#pragma once
#include <slipmat.h>
#include <slipcells.h>
#include <slipstep/private/slipmat.h>
#include <slipstep/private/slipcells.h>

typedef struct {
  Mat K; /* referenced: owns the strike engine */
  SlipStrike strike;
  PetscReal *blocks; /* [nk][nz][nz] [Pa s/m] */
  SlipLowRank correction[2];
  PetscReal *half_x, *half_y; /* scratch */
  PetscReal *y;               /* [N] */
  SlipGather gather;
  PetscReal tolerance;     /* of the exact root; 0 without a low-rank part */
  SlipIncrement increment; /* with one */
  Vec diagonal;            /* NULL until asked for: it reads the whole low-rank part against its grain */
} SlipSpectral;

/* The rows of cells that this process works on: all of them, or its share. */
PETSC_INTERN void SlipSpectralRows(SlipSpectral *c, PetscInt *start, PetscInt *rows);
/* Blocks of factor * sqrt(scale * K), to be freed. */
PETSC_INTERN PetscErrorCode SlipSpectralRootBlocks(SlipStrike strike, PetscReal factor, PetscReal scale,
                                                   PetscReal **blocks);
/* Largest eigenvalue of the part in blocks. Collective. */
PETSC_INTERN PetscErrorCode SlipSpectralNorm(MPI_Comm comm, SlipSpectral *c, PetscReal factor, PetscReal scale,
                                             PetscReal *norm);
