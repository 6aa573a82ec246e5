/* Waves that slip on a plane radiates: kernels of one wavenumber, and their sums of exponentials. Pure functions. */
#pragma once
#include <petscsys.h>

/* Slip rate V of wavenumber k on a plane in a full space meets, beside static stress and the impedance G/(2 cs), the
   stress (G k/2) int W(k cs t') V(t - t') dt' of the waves that are still under way. */
typedef enum {
  SLIP_WAVE_ANTIPLANE, /* mode III: slip across the wavenumber */
  SLIP_WAVE_INPLANE    /* mode II: along it */
} SlipWaveMode;

/* W(T) = Re sum_j a_j exp(s_j T), T >= 0, of which every s_j has Re s_j < 0 and Im s_j >= 0 */
typedef struct {
  PetscInt n;
  PetscReal *s, *a; /* [n][2] real and imaginary part */
  PetscReal error;  /* largest of W, of all T that were looked at, 0 to SLIP_WAVE_LONGEST */
} SlipWavePoles;
#define SLIP_WAVE_LONGEST 1000
#define SLIP_WAVE_MOST_POLES 64
#define SLIP_WAVE_FINEST 1e-8 /* tolerance of W */

/* W(0): the static stiffness of the mode over G k/2; ratio: cp/cs, of which mode III knows nothing */
PETSC_EXTERN PetscReal SlipWaveStatic(SlipWaveMode mode, PetscReal ratio);
PETSC_EXTERN PetscErrorCode SlipWaveKernel(SlipWaveMode mode, PetscReal ratio, PetscInt n, const PetscReal T[],
                                           PetscReal W[]);
PETSC_EXTERN PetscErrorCode SlipWavePolesCreate(SlipWaveMode mode, PetscReal ratio, PetscReal tolerance,
                                                SlipWavePoles *poles);
PETSC_EXTERN PetscReal SlipWavePolesEvaluate(const SlipWavePoles *p, PetscReal T);
PETSC_EXTERN PetscErrorCode SlipWavePolesDestroy(SlipWavePoles *p);
