/* Private to src/mat/plane*.c: operators of a uniform grid by transforms along strike and in depth. */
#pragma once
#include <slipstep/private/slipmat.h>
#include <fftw3.h>

struct _n_SlipPlane {
  SlipGrid grid;
  MPI_Comm comm;                 /* K's */
  PetscInt period, depth_period; /* padded lengths along strike and in depth, both even */
  SlipPencil pencil;
  SlipPlaneSymbol stiffness;
  PetscReal *z;                      /* [nz] depths [m] */
  PetscReal *column;                 /* [2][depth_period] complex, and their transforms */
  fftw_plan depth[2], depth_back[2]; /* of one and of two columns */
  VecScatter scatter;                /* to this rank's rows of cells; NULL where it owns them */
  Vec rows;

  /* functions of the full space's kernel, see planeroot.c */
  PetscBool image;      /* fields are even about the free surface */
  PetscInt gap, length; /* cells between the fault's edge and its image; half the period in depth */
  PetscReal *symbol;    /* [local nk][length + 1], unscaled [Pa/m], >= 0; NULL until asked for */
  SlipPlaneSymbol root; /* of the square root of symbol; toeplitz NULL until asked for */
  PetscReal *diagonal;  /* [nz] of that root */
  PetscReal *line;      /* [length] complex with image, else [2 length], and its transform */
  PetscReal *turn;      /* [length / 2 + 1] complex with image: exp(-i pi k / length) */
  fftw_plan wave[2];    /* there and back */
};

PETSC_INTERN PetscErrorCode SlipPlaneAllocate(SlipPlane p, PetscInt parts, SlipPlaneSymbol *s);
PETSC_INTERN PetscErrorCode SlipPlaneSetSymbol(SlipPlane p, PetscInt stride, PetscInt parts, const PetscReal kernels[],
                                               SlipPlaneSymbol *s);
PETSC_INTERN PetscErrorCode SlipPlaneRootDestroy(SlipPlane p);
PETSC_INTERN PetscErrorCode SlipPlaneForward(SlipPlane p, Vec x);
PETSC_INTERN PetscErrorCode SlipPlaneBackward(SlipPlane p, PetscReal factor, Vec y);
